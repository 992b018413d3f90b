"""Small worlds in which a search without one of its last resorts finds nothing: docs/COMPLETENESS.md."""

import math

from worlds.writing import block, box, floor, world

PEG_HALF = 0.035
PEGS = ((2.24, 0.15), (2.48, -0.15), (2.72, 0.15), (2.96, -0.15), (3.20, 0.15))


def pegs():
    """A gap with posts narrower than the search wants its footholds, and wider than the checker does."""
    shapes = [floor("floor_start", 0.0, 2.0, 1.0), floor("floor_goal", 3.44, 5.44, 1.0)]
    for i, (x, y) in enumerate(PEGS):
        shapes.append(block(f"peg_{i + 1}", (x - PEG_HALF, y - PEG_HALF, -0.5), (x + PEG_HALF, y + PEG_HALF, 0.0)))
    comment = ("A gap of 1.44 with five posts of 0.07 x 0.07, 0.24 apart along the walk and 0.30 across, left and right in turn.",)
    return world(comment, shapes)


PILLORY_AT = 3.0
PILLORY_HALF, NECK_HALF = 0.5, 0.05
PILLORY_LOW, PILLORY_HIGH = 1.33, 1.36


def pillory():
    """A plate that encloses the neck of a robot that stands upright at the goal, and no other part of it."""
    low, high = PILLORY_AT - PILLORY_HALF, PILLORY_AT + PILLORY_HALF
    shapes = [floor("floor", 0.0, 4.0, 1.0)]
    for name, x, y in (
        ("behind", (low, PILLORY_AT - NECK_HALF), (-PILLORY_HALF, PILLORY_HALF)),
        ("ahead", (PILLORY_AT + NECK_HALF, high), (-PILLORY_HALF, PILLORY_HALF)),
        ("left", (PILLORY_AT - NECK_HALF, PILLORY_AT + NECK_HALF), (NECK_HALF, PILLORY_HALF)),
        ("right", (PILLORY_AT - NECK_HALF, PILLORY_AT + NECK_HALF), (-PILLORY_HALF, -NECK_HALF)),
    ):
        shapes.append(block(f"plate_{name}", (x[0], y[0], PILLORY_LOW), (x[1], y[1], PILLORY_HIGH)))
    comment = (
        "A floor with a plate 1.0 x 1.0 over the goal, 1.33 to 1.36 high, with a hole of 0.10 x 0.10: the neck of a robot that stands",
        "upright at the goal passes through it, its head does not.",
    )
    return world(comment, shapes)


def dead_end():
    """Two passages through a block: the straight one is hung with low bars, the other one is free."""
    shapes = [block("floor", (0.0, -2.0, -0.5), (6.0, 4.0, 0.0))]
    for name, low, high in (("right", -2.0, -0.5), ("middle", 0.5, 1.9), ("left", 2.9, 4.0)):
        shapes.append(block(f"block_{name}", (2.0, low, 0.0), (4.0, high, 2.0)))
    for i, x in ((1, 2.4), (2, 3.0), (3, 3.6)):
        shapes.append(block(f"bar_{i}", (x - 0.025, -0.5, 1.05), (x + 0.025, 0.5, 1.10)))
    comment = (
        "A block 2.0 thick and 2.0 high across the way, with two passages 1.0 wide. In the straight one hang the three bars of",
        "pass_under_low, 1.05 high; the other one, 2.4 aside, is free.",
    )
    return world(comment, shapes)


def low_beam():
    """A beam across a walled way, so low that the robot passes only with its trunk pitched far forward."""
    shapes = [floor("floor", 0.0, 5.0, 0.8)]
    for name, y in (("left", 0.8), ("right", -0.9)):
        shapes.append(block(f"wall_{name}", (0.0, y, 0.0), (5.0, y + 0.1, 2.0)))
    shapes.append(block("beam", (2.45, -0.8, 1.05), (2.55, 0.8, 1.65)))
    comment = ("A way 1.6 wide between walls, with a beam across it from 1.05 to 1.65 above the floor, 0.10 thick.",)
    return world(comment, shapes)


def long_wall():
    """A wall that ends only far outside the region in which a search for a guide route begins."""
    shapes = [
        block("floor", (-6.3, -8.0, -0.5), (9.7, 8.0, 0.0)),
        block("wall", (1.65, -6.0, 0.0), (1.75, 6.0, 2.0)),
    ]
    comment = ("A floor of 16 x 16 with a wall 2.0 high and 12.0 long across the way, whose ends are open.",)
    return world(comment, shapes)


SLOT_LEAN, SLOT_HALF_WIDTH, SLOT_LOW, SLOT_LEGS = 0.5, 0.36, 0.55, 0.3
SLOT_FROM, SLOT_TO, SLOT_THICK, SLOT_PIVOT, SLOT_END = 1.5, 3.5, 0.4, 0.75, 1.3


def slanted_slot():
    """A way between two walls that lean to the left, too narrow for the upper body with the root level."""
    x, half = (SLOT_FROM + SLOT_TO) / 2, (SLOT_TO - SLOT_FROM) / 2
    shapes = [floor("floor", 0.0, 5.0, 1.0)]
    for name, side in (("left", 1.0), ("right", -1.0)):
        y = sorted((side * 1.0, side * 1.1))
        shapes.append(block(f"wall_{name}", (0.0, y[0], 0.0), (5.0, y[1], 2.0)))
        y = sorted((side * SLOT_LEGS, side * 1.0))
        shapes.append(block(f"low_{name}", (SLOT_FROM, y[0], 0.0), (SLOT_TO, y[1], SLOT_LOW)))
        along, out = (math.sin(SLOT_LEAN), math.cos(SLOT_LEAN)), (math.cos(SLOT_LEAN), -math.sin(SLOT_LEAN))
        start = (SLOT_LOW - SLOT_PIVOT - side * SLOT_HALF_WIDTH * out[1]) / along[1]
        middle, aside = (start + SLOT_END) / 2, side * (SLOT_HALF_WIDTH + SLOT_THICK / 2)
        at = (x, aside * out[0] + middle * along[0], SLOT_PIVOT + aside * out[1] + middle * along[1])
        extents = (half, SLOT_THICK / 2, (SLOT_END - start) / 2)
        shapes.append(box(f"leaning_{name}", at, extents, (-SLOT_LEAN, 0.0, 0.0)))
    comment = (
        "A way 2.0 long between two walls that lean 0.5 rad to the left, 0.72 apart; below 0.55 they are upright and 0.6 apart.",
    )
    return world(comment, shapes)


WRITERS = {
    "holes/dead_end": dead_end,
    "holes/long_wall": long_wall,
    "holes/low_beam": low_beam,
    "holes/pegs": pegs,
    "holes/pillory": pillory,
    "holes/slanted_slot": slanted_slot,
}
