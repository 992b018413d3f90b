"""Long courses: SL1M's, and the gauntlet."""

import math
import random

from worlds.courses import (
    SEED,
    SLAB_HALF,
    SLABS,
    SPIRAL_ANGLE,
    SPIRAL_RADIUS,
    SPIRAL_TOP,
    STONE_HALF,
    jittered_column,
    platform,
    solid_steps,
)
from worlds.writing import FLOOR_HALF_THICKNESS, block, box, floor, i_beam, world

# ---------------------------------------------------------------------------------------------- sl1m_complex

TILES = 8
TILE = (0.34, 0.33)
TILE_HALF_THICKNESS = 0.05
TILE_TOPS = (0.05, 0.20)
TILE_TILT = math.radians(15.0)
TILE_SPREAD = math.radians(4.0)


def tile(rng, index):
    """A tile tilted about the walk's axis, to the left or to the right, and a little along the walk, by 15 degrees at the most."""
    side = 1 if index % 2 == 0 else -1
    while True:
        roll, pitch = rng.uniform(0.0, TILE_TILT), rng.uniform(-TILE_SPREAD, TILE_SPREAD)
        if math.cos(roll) * math.cos(pitch) >= math.cos(TILE_TILT):
            break
    top = rng.uniform(*TILE_TOPS)
    roll, pitch = round(side * roll, 4), round(pitch, 4)
    x, y = 2.0 + TILE[0] / 2 + TILE[0] / 2 * index, side * TILE[1] / 2
    normal = (math.sin(pitch) * math.cos(roll), -math.sin(roll), math.cos(pitch) * math.cos(roll))
    centre = [p - TILE_HALF_THICKNESS * n for p, n in zip((x, y, round(top, 4)), normal)]
    return box(f"tile_{index + 1}", centre, (TILE[0] / 2, TILE[1] / 2, TILE_HALF_THICKNESS), (roll, pitch, 0.0))


def sl1m_complex():
    rng = random.Random(SEED)
    rubble_end = 2.0 + TILE[0] / 2 * (TILES + 1)
    foot = rubble_end + 1.0
    top = foot + 6 * 0.30
    shapes = [floor("floor_start", 0.0, 2.0, 1.0), floor("floor_middle", rubble_end, top, 1.0)]
    shapes += [tile(rng, i) for i in range(TILES)]
    shapes += solid_steps(6, 0.10, 0.30, foot, 0.5)
    shapes.append(block("bridge", (top, -0.15, 0.50), (top + 3.0, 0.15, 0.60)))
    shapes.append(platform("platform", top + 3.0, top + 4.0, 0.5, 0.60))
    comment = (
        "After SL1M's \"complex\" scene: rubble tiles 0.34 x 0.33 on the left and on the right in turn, their middles 0.05 to 0.20",
        "high, tilted to that side by up to 15 degrees, over a void; six steps of 0.10 x 0.30 x 1.0; a bridge 3.0 x 0.30 at 0.60; a",
        "platform 1.0 long.",
    )
    return world(comment, shapes)


# ---------------------------------------------------------------------------------------------- gauntlet

TRENCH = (1.0, 2.0)
STONES = (3.0, 6.0)
SPIRAL_ENTRY = 8.0
COPY = (SPIRAL_ENTRY + 1.2, 2 * SPIRAL_RADIUS + 2 * 0.336392)
"""From one copy to the next, x and y: as far aside as the way down ends beside the way up."""


def trench():
    """The pair of I-beams in the middle of a trench, as in ibeam_gap."""
    yield floor("floor_start", 0.0, TRENCH[0], 1.0)
    yield block("trench_floor", (0.0, -1.0, -1.3), (STONES[0], 1.0, -0.8))
    for name, x_from, x_to in (("start", 0.0, TRENCH[0]), ("middle", TRENCH[1], STONES[0])):
        yield block(f"footing_{name}", (x_from, -1.0, -0.8), (x_to, 1.0, -0.5))
    for side, y in (("left", 1.0), ("right", -1.1)):
        yield block(f"wall_{side}", (0.0, y, -0.8), (STONES[0], y + 0.1, 2.0))
    for i, x in ((1, 1.425), (2, 1.575)):
        for side, y in (("left", 0.6), ("right", -0.6)):
            yield block(f"post_{i}_{side}", (x - 0.025, y - 0.025, -0.8), (x + 0.025, y + 0.025, -0.1))
        for part, half, low, high in i_beam(0.025, -0.1, 0.1):
            yield block(f"beam_{i}_{part}", (x - half, -1.0, low), (x + half, 1.0, high))
    yield floor("floor_middle", TRENCH[1], STONES[0], 1.0)


def stones():
    """The stones of stepping_stones."""
    rng = random.Random(SEED)
    for side, first_x, y in (("left", 3.19, 0.15), ("right", 3.36, -0.15)):
        for i, (x, y) in enumerate(jittered_column(rng, first_x, y)):
            yield box(f"stone_{side}_{i + 1}", (round(x, 4), round(y, 4), -STONE_HALF[2]), STONE_HALF)
    yield block("floor_spiral", (STONES[1], -0.45, -2 * FLOOR_HALF_THICKNESS), (SPIRAL_ENTRY + 0.13, 0.45, 0.0))


def spirals():
    """spiral_steps up, and turned by half a turn about the middle of the platform, so that it leads down."""
    axis = (SPIRAL_ENTRY, SPIRAL_RADIUS)
    middle = (axis[0] - 0.683257, axis[1] + 0.336392)
    for i in range(1, SLABS + 1):
        angle = -math.pi / 2 + SPIRAL_ANGLE * i
        x, y = axis[0] + SPIRAL_RADIUS * math.cos(angle), axis[1] + SPIRAL_RADIUS * math.sin(angle)
        z = SPIRAL_TOP * i / (SLABS + 1) - SLAB_HALF[2]
        yield box(f"slab_up_{i}", (x, y, z), SLAB_HALF, (0.0, 0.0, angle))
        yield box(f"slab_down_{i}", (2 * middle[0] - x, 2 * middle[1] - y, z), SLAB_HALF, (0.0, 0.0, angle + math.pi))
    turn = -math.pi / 2 + SPIRAL_ANGLE * (SLABS + 1)
    yield box("platform", (*middle, SPIRAL_TOP - FLOOR_HALF_THICKNESS), (0.40, 0.43, FLOOR_HALF_THICKNESS), (0.0, 0.0, turn))
    end = COPY[1]
    yield block("floor_end", (2 * middle[0] - axis[0] - 0.13, end - 0.37, -2 * FLOOR_HALF_THICKNESS), (COPY[0], end + 0.63, 0.0))


def gauntlet(copies):
    shapes = []
    for i in range(copies):
        for entry in (*trench(), *stones(), *spirals()):
            shapes.append(entry.moved(f"c{i + 1}_", COPY[0] * i, COPY[1] * i))
    last = block("floor_goal", (0.0, -1.0, -2 * FLOOR_HALF_THICKNESS), (1.5, 1.0, 0.0))
    shapes.append(last.moved("c_", COPY[0] * copies, COPY[1] * copies))
    times = "Once" if copies == 1 else f"{copies} times in a row"
    comment = (
        f"{times}: the trench of ibeam_gap, the stones of stepping_stones, spiral_steps up, and the same turned by half a turn",
        "about the platform's middle, down. Each copy ends aside of where it began.",
    )
    return world(comment, shapes)


WRITERS = {"sl1m_complex": sl1m_complex} | {f"gauntlet_{n}": lambda n=n: gauntlet(n) for n in (1, 2, 4, 8)}
