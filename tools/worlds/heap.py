"""Cinder blocks heaped in a pit."""

import math
import random

from worlds.writing import block, box, floor, world

SEED = 1
DRAW = 26
"""Which of the seed's heaps: one over which no crossing keeps to one height and heading, which is rare (tests/worlds_heap.rs)."""

PIT_FROM, PIT_TO = 2.0, 4.4
PIT_DEPTH = 0.25
HALF_WIDTH = 1.0
WALL = 0.10
WALL_HEIGHT = 2.0
BLOCK_HALF = (0.195, 0.095, 0.095)
TILT, HEIGHT_JITTER = 0.35, 0.06
STEEP_TILT, STEEP_HEIGHT_JITTER = 0.70, 0.12
STEEP_HEAPS = 20

GAP = 0.05
CELL = 0.01
SHARED_CONTACT = 0.003
SLIVER = 0.011
"""A strip of contact narrower than this carries nothing (docs/decisions/0003-planner-margins.md)."""


class Block:
    """A block's pose, its top face and what it covers, seen from above."""

    def __init__(self, centre, rpy):
        self.centre, self.rpy = centre, rpy
        self.axes = rotation_columns(rpy)
        self.normal = self.axes[2]
        self.top = [self.point(x, y, 1.0) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        corners = [self.point(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
        self.outline = hull([(x, y) for x, y, _ in corners])

    def point(self, x, y, z):
        scaled = (x * BLOCK_HALF[0], y * BLOCK_HALF[1], z * BLOCK_HALF[2])
        return tuple(c + sum(axis[k] * s for axis, s in zip(self.axes, scaled)) for k, c in enumerate(self.centre))

    def above(self, point):
        """The height of a point over the plane of this block's top."""
        return sum(n * (p - q) for n, p, q in zip(self.normal, point, self.top[0]))


def rotation_columns(rpy):
    """The columns of Rz(yaw) Ry(pitch) Rx(roll)."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in rpy)
    return (
        (cy * cp, sy * cp, -sp),
        (cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr),
        (cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr),
    )


def cross(o, a, b):
    return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])


def hull(points):
    """The convex hull, counter-clockwise."""
    points = sorted(points)

    def half(points):
        chain = []
        for p in points:
            while len(chain) >= 2 and cross(chain[-2], chain[-1], p) <= 0:
                chain.pop()
            chain.append(p)
        return chain[:-1]

    return half(points) + half(points[::-1])


def clip(polygon, inside):
    """The part of a polygon in space where `inside` is not negative."""
    kept = []
    for a, b in zip(polygon, polygon[1:] + polygon[:1]):
        da, db = inside(a), inside(b)
        if da >= 0:
            kept.append(a)
        if da * db < 0:
            kept.append(tuple(p + (q - p) * da / (da - db) for p, q in zip(a, b)))
    return kept


def width(polygon):
    """The least distance between two parallel lines about a flat polygon in space."""
    if len(polygon) < 3:
        return 0.0
    least = math.inf
    for a, b in zip(polygon, polygon[1:] + polygon[:1]):
        edge = [q - p for p, q in zip(a, b)]
        length = math.hypot(*edge)
        if length < 1e-9:
            continue
        across = 0.0
        for c in polygon:
            to = [q - p for p, q in zip(a, c)]
            along = sum(e * t for e, t in zip(edge, to)) / length
            across = max(across, math.sqrt(max(0.0, sum(t * t for t in to) - along * along)))
        least = min(least, across)
    return least


def share_a_sole(one, other):
    """Whether a sole that lies on one block's top would rest on the other's as well."""
    for below, beside in ((one, other), (other, one)):
        level = clip(beside.top, lambda p: -below.above(p))
        if width(clip(level, lambda p: below.above(p) + SHARED_CONTACT)) >= SLIVER:
            return True
    return False


class Pit:
    """Which cells of the pit's floor lie under a block."""

    def __init__(self):
        self.size = (round((PIT_TO - PIT_FROM) / CELL), round(2 * HALF_WIDTH / CELL))
        self.bare = {(i, j) for i in range(self.size[0]) for j in range(self.size[1])}

    @staticmethod
    def centre(cell):
        return PIT_FROM + CELL * (cell[0] + 0.5), -HALF_WIDTH + CELL * (cell[1] + 0.5)

    def cells_under(self, outline, grown=0.0):
        """The cells whose centre lies under an outline grown by a distance."""
        xs, ys = [p[0] for p in outline], [p[1] for p in outline]
        i_from, i_to = (int((x - PIT_FROM) / CELL) for x in (min(xs) - grown, max(xs) + grown))
        j_from, j_to = (int((y + HALF_WIDTH) / CELL) for y in (min(ys) - grown, max(ys) + grown))
        edges = []
        for a, b in zip(outline, outline[1:] + outline[:1]):
            length = math.dist(a, b)
            nx, ny = (b[1] - a[1]) / length, (a[0] - b[0]) / length
            edges.append((nx, ny, nx * a[0] + ny * a[1] + grown))
        for i in range(max(i_from, 0), min(i_to + 1, self.size[0])):
            for j in range(max(j_from, 0), min(j_to + 1, self.size[1])):
                x, y = self.centre((i, j))
                if all(nx * x + ny * y <= limit for nx, ny, limit in edges):
                    yield i, j


def lies_in_pit(outline):
    """Within the banks; a block may reach a little into the walls."""
    return all(PIT_FROM <= x <= PIT_TO and abs(y) <= HALF_WIDTH + WALL / 2 for x, y in outline)


def placed(rng, target, pit, heap, tilt, jitter):
    """A block drawn at random, laid over a bare point so that it covers as much bare ground as it can; none if it does not fit.

    The lowest block, untilted, stands on the pit's floor.
    """
    rpy = (rng.uniform(-tilt, tilt), rng.uniform(-tilt, tilt), rng.uniform(-math.pi, math.pi))
    height = -PIT_DEPTH + BLOCK_HALF[2] + jitter + rng.uniform(-jitter, jitter)
    rpy, height = tuple(round(a, 4) for a in rpy), round(height, 4)
    best = (0, None)
    for _ in range(40):
        along, across = rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0)
        ux, uy = math.cos(rpy[2]), math.sin(rpy[2])
        dx, dy = along * BLOCK_HALF[0], across * BLOCK_HALF[1]
        centre = (round(target[0] + dx * ux - dy * uy, 4), round(target[1] + dx * uy + dy * ux, 4), height)
        candidate = Block(centre, rpy)
        if not lies_in_pit(candidate.outline):
            continue
        near = [b for b in heap if math.dist(b.centre, centre) < 0.70]
        if any(share_a_sole(candidate, b) for b in near):
            continue
        gain = sum(cell in pit.bare for cell in pit.cells_under(candidate.outline))
        best = max(best, (gain, candidate), key=lambda scored: scored[0])
    return best[1]


def heaped(seed, tilt, jitter):
    """Blocks drawn one after the other until no gap between them is wider than GAP."""
    rng = random.Random(seed)
    pit, heap, given_up = Pit(), [], set()
    # Cells about which a gap wider than GAP may still lie: their centres are farther than GAP / 2 from every block.
    wide = {c for c in pit.bare if PIT_FROM + 0.10 <= pit.centre(c)[0] <= PIT_TO - 0.10}
    while wide:
        target = min(wide)
        for _ in range(400):
            found = placed(rng, pit.centre(target), pit, heap, tilt, jitter)
            if found is not None:
                break
        else:
            raise RuntimeError(f"no block fits at {pit.centre(target)}, {len(heap)} blocks lie")
        heap.append(found)
        pit.bare.difference_update(pit.cells_under(found.outline))
        wide.difference_update(pit.cells_under(found.outline, GAP / 2))
    return heap


def pit_with(heap, *comment):
    """The corridor with its pit, filled with a heap."""
    shapes = [floor("floor_start", 0.0, PIT_FROM, HALF_WIDTH), floor("floor_goal", PIT_TO, PIT_TO + 2.0, HALF_WIDTH)]
    end = PIT_TO + 2.0
    shapes.append(block("pit_floor", (PIT_FROM, -HALF_WIDTH, -0.75), (PIT_TO, HALF_WIDTH, -PIT_DEPTH)))
    for side, y in (("left", HALF_WIDTH), ("right", -HALF_WIDTH - WALL)):
        shapes.append(block(f"wall_{side}", (0.0, y, -0.75), (end, y + WALL, WALL_HEIGHT)))
    for i, one in enumerate(heap):
        shapes.append(box(f"block_{i + 1}", one.centre, BLOCK_HALF, one.rpy))
    return world(comment, shapes)


def cinder_blocks():
    return pit_with(
        heaped(f"{SEED}.{DRAW}", TILT, HEIGHT_JITTER),
        "A corridor 2.0 wide with a pit 2.4 long and 0.25 deep in it, filled with a layer of cinder blocks 0.39 x 0.19 x 0.19 that lie",
        "as close as a heap does. Roll and pitch are drawn from +-0.35, yaw from +-pi, heights from +-0.06; poses that would let",
        "one sole lie on two blocks at once are drawn again. All are fixed in place.",
    )


def cinder_blocks_steep(seed):
    return pit_with(
        heaped(f"steep.{seed}", STEEP_TILT, STEEP_HEIGHT_JITTER),
        f"As cinder_blocks, with roll and pitch drawn from +-0.70 and heights from +-0.12. Heap {seed} of {STEEP_HEAPS}.",
    )


WRITERS = {"cinder_blocks": cinder_blocks} | {
    f"cinder_blocks_steep/{seed:02}": lambda seed=seed: cinder_blocks_steep(seed) for seed in range(1, STEEP_HEAPS + 1)
}
