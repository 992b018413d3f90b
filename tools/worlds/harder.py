"""The worlds of the thesis with one thing made harder."""

import math
import random

from worlds.courses import SPIRAL_ANGLE, SPIRAL_RADIUS, platform, solid_steps
from worlds.writing import FLOOR_HALF_THICKNESS, bar, block, box, cylinder, floor, i_beam, world

SEED = 1

# ---------------------------------------------------------------------------------------------- stairs


def steep_stairs(rise):
    top = 6 * rise
    shapes = [floor("floor", 0.0, 4.0, 1.0), *solid_steps(5, rise, 0.20, 1.5, 0.6), platform("platform", 2.5, 4.0, 0.6, top)]
    return world((f"As stairs, with risers of {rise:.2f}: six of them, treads 0.20 deep.",), shapes)


def stairs_nosing():
    """Open treads: each 0.03 thick, and 0.03 over the riser below it."""
    shapes = [floor("floor", 0.0, 4.0, 1.0)]
    for i in range(5):
        x, top = 1.5 + 0.20 * i, 0.22 * (i + 1)
        shapes.append(block(f"tread_{i + 1}", (x - 0.03, -0.6, top - 0.03), (x + 0.20, 0.6, top)))
        shapes.append(block(f"riser_{i + 1}", (x, -0.6, 0.0), (x + 0.20, 0.6, top - 0.03)))
    shapes.append(block("landing", (2.47, -0.6, 1.29), (4.0, 0.6, 1.32)))
    shapes.append(block("support", (2.5, -0.6, 0.0), (4.0, 0.6, 1.29)))
    return world(("As stairs, with treads 0.03 thick that stand 0.03 over their risers.",), shapes)


# ---------------------------------------------------------------------------------------------- beam


def beam_narrow():
    shapes = [
        floor("floor_start", 0.0, 1.6, 0.8),
        floor("floor_goal", 5.6, 7.2, 0.8),
        floor("ground", 0.0, 7.2, 0.8, top=-0.8),
    ]
    for part, half, low, high in i_beam(0.03, -0.20, 0.0):
        shapes.append(block(f"beam_{part}", (1.6, -half, low), (5.6, half, high)))
    return world(("As beam, with flanges 0.06 wide, 4.0 long.",), shapes)


# ---------------------------------------------------------------------------------------------- bars


def bars(comment, spacing, radius, span, offsets=None):
    """Round bars in a gap of length `span`, centred; `offsets(i)` moves a bar along x and z."""
    shapes = [
        floor("floor_start", 0.0, 1.6, 0.8),
        floor("floor_goal", 1.6 + span, 3.2 + span, 0.8),
        floor("ground", 0.0, 3.2 + span, 0.8, top=-1.0),
    ]
    count = math.floor(span / spacing)
    first = 1.6 + (span - spacing * (count - 1)) / 2
    for i in range(count):
        dx, dz = offsets(i) if offsets else (0.0, 0.0)
        centre = (round(first + spacing * i + dx, 4), 0.0, round(dz - radius, 4))
        shapes.append(bar(f"bar_{i + 1}", centre, radius, 1.2))
    return world(comment, shapes)


def bars_uneven():
    rng = random.Random(SEED)
    draws = [(rng.uniform(-0.01, 0.01), rng.uniform(-0.03, 0.03)) for _ in range(20)]
    comment = ("As monkey_bars, 0.18 apart, moved by up to 0.01 along the walk and 0.03 up or down.",)
    return bars(comment, 0.18, 0.02, 2.0, lambda i: draws[i])


# ---------------------------------------------------------------------------------------------- spiral


def spiral(comment, top, slab_half):
    shapes = [box("floor", (-0.42, -0.70, -FLOOR_HALF_THICKNESS), (0.55, 0.50, FLOOR_HALF_THICKNESS))]
    for i in range(1, 7):
        angle = -math.pi / 2 + SPIRAL_ANGLE * i
        centre = (SPIRAL_RADIUS * math.cos(angle), SPIRAL_RADIUS * math.sin(angle), top * i / 7 - slab_half[2])
        shapes.append(box(f"slab_{i}", centre, slab_half, (0.0, 0.0, angle)))
    angle = -math.pi / 2 + SPIRAL_ANGLE * 7
    x = SPIRAL_RADIUS * math.cos(angle) - 0.30 * math.sin(angle)
    y = SPIRAL_RADIUS * math.sin(angle) + 0.30 * math.cos(angle)
    centre = (x, y, top - FLOOR_HALF_THICKNESS)
    shapes.append(box("platform", centre, (0.40, 0.43, FLOOR_HALF_THICKNESS), (0.0, 0.0, angle)))
    return world(comment, shapes)


# ---------------------------------------------------------------------------------------------- hallways


def hallway(comment, obstacles):
    shapes = [
        floor("floor", 0.0, 6.0, 1.0),
        block("wall_left", (0.0, 1.0, 0.0), (6.0, 1.1, 2.0)),
        block("wall_right", (0.0, -1.1, 0.0), (6.0, -1.0, 2.0)),
    ]
    return world(comment, [*shapes, *obstacles])


def hallway_high():
    beams = []
    for i, x in ((1, 3.0), (2, 3.15)):
        for part, half, low, high in i_beam(0.025, 0.0, 0.30):
            beams.append(block(f"beam_{i}_{part}", (x - half, -1.0, low), (x + half, 1.0, high)))
    return hallway(("As ibeam_hallway, with beams 0.30 high.",), beams)


def hallway_plates():
    plates = [block(f"plate_{i}", (x - 0.005, -1.0, 0.0), (x + 0.005, 1.0, 0.20)) for i, x in ((1, 3.0), (2, 3.19))]
    return hallway(("As ibeam_hallway, with two upright plates 0.01 thick, 0.20 high and 0.19 apart in place of the beams.",), plates)


def pass_under_low():
    shapes = [
        floor("floor", 0.0, 4.0, 1.0),
        block("wall_left", (0.0, 1.0, 0.0), (4.0, 1.1, 2.0)),
        block("wall_right", (0.0, -1.1, 0.0), (4.0, -1.0, 2.0)),
        block("wall_start", (-0.1, -1.1, 0.0), (0.0, 1.1, 2.0)),
        block("wall_goal", (4.0, -1.1, 0.0), (4.1, 1.1, 2.0)),
    ]
    for i, x in ((1, 1.4), (2, 2.0), (3, 2.6)):
        shapes.append(block(f"bar_{i}", (x - 0.025, -1.0, 1.05), (x + 0.025, 1.0, 1.10)))
    return world(("As pass_under, with all three undersides at 1.05.",), shapes)


# ---------------------------------------------------------------------------------------------- clutter

RAIL_RADIUS = 0.02
RAIL_HEIGHT, RAIL_ASIDE, BAR_HEIGHT = 0.95, 0.38, 1.50
"""Of the rails' and the bar's axes: above where the robot treads, and from the middle."""


def clutter(begin, end, middle):
    """Two rails along the line from one point of the way to another, and a bar across above a point between both."""
    length, pitch = math.dist(begin, end), math.atan2(begin[1] - end[1], end[0] - begin[0])
    x, z = (begin[0] + end[0]) / 2, (begin[1] + end[1]) / 2 + RAIL_HEIGHT
    for side, y in (("left", RAIL_ASIDE), ("right", -RAIL_ASIDE)):
        yield cylinder(f"rail_{side}", (x, y, z), RAIL_RADIUS, length, (0.0, math.pi / 2 + pitch, 0.0))
    yield bar("bar_across", (middle[0], 0.0, middle[1] + BAR_HEIGHT), RAIL_RADIUS, 1.2)


CLUTTER = "with a rail of 0.04 on each side, 0.95 high and 0.38 from the middle, and a bar of 0.04 across at 1.50."


def cluttered_beam():
    shapes = [
        floor("floor_start", 0.0, 1.6, 0.8),
        floor("floor_goal", 3.6, 5.2, 0.8),
        floor("ground", 0.0, 5.2, 0.8, top=-0.8),
    ]
    for part, half, low, high in i_beam(0.06, -0.20, 0.0):
        shapes.append(block(f"beam_{part}", (1.6, -half, low), (3.6, half, high)))
    return world((f"As beam, {CLUTTER}",), [*shapes, *clutter((1.6, 0.0), (3.6, 0.0), (2.6, 0.0))])


def cluttered_stairs():
    shapes = [floor("floor", 0.0, 4.0, 1.0), *solid_steps(5, 0.22, 0.20, 1.5, 0.6), platform("platform", 2.5, 4.0, 0.6, 1.32)]
    rails = clutter((1.5, 0.11), (2.5, 1.21), (2.0, 0.66))
    return world((f"As stairs, {CLUTTER}", "The rails stand 0.95 over the middles of the treads."), [*shapes, *rails])


# ---------------------------------------------------------------------------------------------- detours

DETOURS = (3, 4, 5, 6, 8, 11)


def detour(half_length):
    shapes = [
        block("floor", (-12.0, -12.0, -0.5), (12.0, 12.0, 0.0)),
        block("wall", (-0.05, -half_length, 0.0), (0.05, half_length, 2.0)),
    ]
    return world((f"A floor 24 x 24 with a wall 0.1 thick, 2.0 high and {2 * half_length} long between start and goal.",), shapes)


WRITERS = {
    "stairs_steep": lambda: steep_stairs(0.26),
    "stairs_steepest": lambda: steep_stairs(0.28),
    "stairs_nosing": stairs_nosing,
    "beam_narrow": beam_narrow,
    "bars_wide": lambda: bars(("As monkey_bars, 0.21 apart: a sole has 5 mm of play.",), 0.21, 0.02, 2.0),
    "bars_thin": lambda: bars(("As monkey_bars, of diameter 0.02, 0.20 apart, over 4.0.",), 0.20, 0.01, 4.0),
    "bars_uneven": bars_uneven,
    "spiral_high": lambda: spiral(("As spiral_steps, with seven rises of 0.28.",), 7 * 0.28, (0.25, 0.13, 0.025)),
    "spiral_small": lambda: spiral(("As spiral_steps, with slabs of 0.32 x 0.24.",), 1.32, (0.16, 0.12, 0.025)),
    "hallway_high": hallway_high,
    "hallway_plates": hallway_plates,
    "pass_under_low": pass_under_low,
    "cluttered_beam": cluttered_beam,
    "cluttered_stairs": cluttered_stairs,
} | {f"detour_{length}": lambda length=length: detour(length) for length in DETOURS}
