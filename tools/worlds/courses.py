"""Single obstacles along a straight or winding way."""

import math
import random

from worlds.writing import FLOOR_HALF_THICKNESS, bar, box, floor, world

SEED = 1

# ---------------------------------------------------------------------------------------------- stepping_stones

GAP_FROM, GAP_TO = 2.0, 5.0
STONE_HALF = (0.14, 0.10, 0.10)
STONES_PER_COLUMN = 8
STONE_PITCH = 0.35
STONE_SPACING = (0.28, 0.42)
STONE_JITTER = 0.05


def jittered_column(rng, first_x, y):
    """Stone centres of one column, drawn again until their spacings keep to STONE_SPACING."""
    while True:
        jitter = lambda: rng.uniform(-STONE_JITTER, STONE_JITTER)
        centres = [(first_x + STONE_PITCH * i + jitter(), y + jitter()) for i in range(STONES_PER_COLUMN)]
        spacings = [b[0] - a[0] for a, b in zip(centres, centres[1:])]
        if all(STONE_SPACING[0] <= s <= STONE_SPACING[1] for s in spacings):
            return centres


def stepping_stones():
    rng = random.Random(SEED)
    shapes = [floor("floor_start", 0.0, GAP_FROM, 1.0), floor("floor_goal", GAP_TO, GAP_TO + 2.0, 1.0)]
    for side, first_x, y in (("left", 2.19, 0.15), ("right", 2.36, -0.15)):
        for i, (x, y) in enumerate(jittered_column(rng, first_x, y)):
            centre = (round(x, 4), round(y, 4), -STONE_HALF[2])
            shapes.append(box(f"stone_{side}_{i + 1}", centre, STONE_HALF))
    comment = (
        "A gap of 3.0 between two floors, void below, with two irregular columns of stones 0.28 x 0.20 whose tops are",
        "level with the floors. Centres in a column are 0.28 to 0.42 apart along x and jittered by up to 0.05 from a",
        "regular row; the columns are staggered so that left and right alternate.",
    )
    return world(comment, shapes)


# ------------------------------------------------------------------------------------------- stairs and climbs


def solid_steps(count, rise, tread, x_from, half_width):
    """`count` solid steps that stand on z = 0."""
    for i in range(count):
        height = rise * (i + 1)
        centre = (x_from + tread * (i + 0.5), 0.0, height / 2)
        yield box(f"step_{i + 1}", centre, (tread / 2, half_width, height / 2))


def platform(name, x_from, x_to, half_width, top):
    """A solid block from z = 0 to its top."""
    return box(name, ((x_from + x_to) / 2, 0.0, top / 2), ((x_to - x_from) / 2, half_width, top / 2))


def stairs_bauzil():
    shapes = [floor("floor", 0.0, 4.5, 1.0), *solid_steps(6, 0.10, 0.30, 1.5, 0.5), platform("landing", 3.3, 4.5, 0.5, 0.60)]
    comment = ("Six steps of rise 0.10, tread 0.30 and width 1.0 up to a landing at 0.60, as HPP's and SL1M's demos climb.",)
    return world(comment, shapes)


def stairs():
    shapes = [floor("floor", 0.0, 4.0, 1.0), *solid_steps(5, 0.22, 0.20, 1.5, 0.6), platform("platform", 2.5, 4.0, 0.6, 1.32)]
    comment = ("Six risers of 0.22 with treads 0.20 deep and 1.2 wide, solid, open at the sides, to a platform 1.5 x 1.2.",)
    return world(comment, shapes)


SLABS = 6
SLAB_HALF = (0.25, 0.13, 0.025)
SPIRAL_RADIUS = 0.70
SPIRAL_ANGLE = 0.55
SPIRAL_TOP = 1.32


def spiral_pose(index, tangential, top, half_height):
    """Centre and yaw of a box `index` steps up the spiral, x radial, shifted along the walk, below a given top."""
    angle = -math.pi / 2 + SPIRAL_ANGLE * index
    x = SPIRAL_RADIUS * math.cos(angle) - tangential * math.sin(angle)
    y = SPIRAL_RADIUS * math.sin(angle) + tangential * math.cos(angle)
    return (x, y, top - half_height), (0.0, 0.0, angle)


def spiral_steps():
    shapes = [box("floor", (-0.42, -0.70, -FLOOR_HALF_THICKNESS), (0.55, 0.50, FLOOR_HALF_THICKNESS))]
    for i in range(1, SLABS + 1):
        centre, rpy = spiral_pose(i, 0.0, SPIRAL_TOP * i / (SLABS + 1), SLAB_HALF[2])
        shapes.append(box(f"slab_{i}", centre, SLAB_HALF, rpy))
    centre, rpy = spiral_pose(SLABS + 1, 0.30, SPIRAL_TOP, FLOOR_HALF_THICKNESS)
    shapes.append(box("platform", centre, (0.40, 0.43, FLOOR_HALF_THICKNESS), rpy))
    comment = (
        "Six slabs 0.50 (radial) x 0.26 x 0.05 with their centres on a circle of radius 0.70 about the origin, 0.55 rad apart,",
        "in seven equal rises from the floor at z = 0 to a platform at z = 1.32. Climbed counter-clockwise.",
    )
    return world(comment, shapes)


# ------------------------------------------------------------------------------------------- bars and tiles

BARS = 12
BAR_RADIUS = 0.02
BAR_SPACING = 0.16


def monkey_bars():
    shapes = [
        floor("floor_start", 0.0, 1.6, 0.8),
        floor("floor_goal", 3.6, 5.2, 0.8),
        floor("ground", 0.0, 5.2, 0.8, top=-1.0),
    ]
    first = 2.6 - BAR_SPACING * (BARS - 1) / 2
    for i in range(BARS):
        shapes.append(bar(f"bar_{i + 1}", (first + BAR_SPACING * i, 0.0, -BAR_RADIUS), BAR_RADIUS, 1.2))
    comment = (
        "Two platforms 2.0 apart, 1.0 above the ground, with 12 round bars of diameter 0.04 between them, 0.16 apart centre to",
        "centre, 1.2 wide, their tops level with the platforms. To be walked on top of.",
    )
    return world(comment, shapes)


TILE = 0.26


def checkers():
    shapes = [floor("floor_start", 0.0, GAP_FROM, 1.0), floor("floor_goal", GAP_TO, GAP_TO + 2.0, 1.0)]
    rows, columns = int((GAP_TO - GAP_FROM) / TILE), 5
    first_x, first_y = (GAP_FROM + GAP_TO - TILE * (rows - 1)) / 2, -TILE * (columns - 1) / 2
    for row in range(rows):
        for column in range(row % 2, columns, 2):
            centre = (first_x + TILE * row, first_y + TILE * column, -0.10)
            shapes.append(box(f"tile_{row + 1}_{column + 1}", centre, (TILE / 2, TILE / 2, 0.10)))
    comment = ("A gap of 3.0 filled with a checkerboard of 0.26 squares, alternate squares missing, 1.3 wide. Void below.",)
    return world(comment, shapes)


WRITERS = {
    "checkers": checkers,
    "monkey_bars": monkey_bars,
    "spiral_steps": spiral_steps,
    "stairs": stairs,
    "stairs_bauzil": stairs_bauzil,
    "stepping_stones": stepping_stones,
}
