"""What foot placement sampling is tried on alone. Everything lies about the origin, its top near z = 0."""

import math
import random

from worlds.writing import MU, bar, block, box, grid_file, shape, vector, world

SEED = 1
FRICTION_ANGLE = math.atan(MU)
SOLE_LENGTH = 0.22


def parallel_bars(percent):
    span, width = SOLE_LENGTH * percent / 100, 0.03
    shapes = [block(f"bar_{i}", (x, -0.5, -width), (x + width, 0.5, 0.0)) for i, x in ((1, -span / 2), (2, span / 2 - width))]
    comment = (f"Two bars 0.03 wide whose outer span is {percent} % of the sole's length. For foot placement alone.",)
    return world(comment, shapes)


def slab(name, tilt, low, high):
    """A slab whose top rises along x at an angle and passes through the origin, from `low` to `high` along its slope."""
    middle, half_thickness = (low + high) / 2, 0.05
    centre = (middle * math.cos(tilt) + half_thickness * math.sin(tilt), 0.0, middle * math.sin(tilt) - half_thickness * math.cos(tilt))
    return box(name, centre, ((high - low) / 2, 0.5, half_thickness), (0.0, -tilt, 0.0))


def ring():
    for i in range(8):
        angle = math.pi / 4 * i
        yield box(f"block_{i + 1}", (0.1 * math.cos(angle), 0.1 * math.sin(angle), -0.03), (0.02, 0.02, 0.03), (0.0, 0.0, angle))


def prism(name, outline):
    """A convex outline in the x-z plane, 1.0 long along y."""
    points = ", ".join(vector((x, y, z)) for x, z in outline for y in (-0.5, 0.5))
    return shape(name, (0.0, 0.0, 0.0), f"convex = {{ points = [{points}] }}")


def m_groove():
    rise = math.tan(1.25 * FRICTION_ANGLE)
    half = 0.30
    shapes = [prism(f"half_{i + 1}", ((0.0, -0.1), (0.0, 0.0), (s * half, rise * half), (s * half, -0.1))) for i, s in enumerate((1, -1))]
    comment = (
        "The concave M of figure 4.11: two faces that meet in a valley, each a quarter steeper than friction holds, the opening 0.6",
        "wide. A sole stands on neither face alone; with its toes in the valley the other face holds it.",
    )
    return world(comment, shapes)


CELLS, CELL, ROUGHNESS = 24, 0.10, 0.05


def rubble_mesh_file():
    """A square 2.4 wide with random heights."""
    rng = random.Random(SEED)

    def corner(i, j):
        return CELL * (i - CELLS / 2), CELL * (j - CELLS / 2), rng.uniform(-ROUGHNESS, 0.0)

    return grid_file(CELLS, CELLS, corner)


def feature(comment, *shapes):
    return lambda: world((comment + " For foot placement alone.",), shapes)


FEATURES = {
    "box_edge": feature("The edge of a box.", block("box", (-1.0, -0.5, -0.5), (0.0, 0.5, 0.0))),
    "cylinder": feature("A cylinder on its side.", bar("cylinder", (0.0, 0.0, -0.15), 0.15, 1.0)),
    "ibeam": feature(
        "An I-beam 0.20 high with flanges 0.12 wide.",
        block("bottom_flange", (-0.06, -1.0, -0.20), (0.06, 1.0, -0.185)),
        block("web", (-0.0075, -1.0, -0.185), (0.0075, 1.0, -0.015)),
        block("top_flange", (-0.06, -1.0, -0.015), (0.06, 1.0, 0.0)),
    ),
    "ramp_0_9": feature("A ramp at 0.9 of the friction angle.", slab("ramp", 0.9 * FRICTION_ANGLE, -0.5, 0.5)),
    "ramp_1_1": feature("A ramp at 1.1 of the friction angle: nothing stands there.", slab("ramp", 1.1 * FRICTION_ANGLE, -0.5, 0.5)),
    "ring": feature("Eight blocks in a ring.", *ring()),
    "rubble_mesh": feature("A triangle mesh of random heights.", shape("rubble", (0.0, 0.0, 0.0), 'mesh = { path = "rubble.obj" }')),
    "sphere_cap": feature("The cap of a sphere of radius 1.5.", shape("sphere", (0.0, 0.0, -1.5), "sphere = { radius = 1.5 }")),
    "staircase": feature(
        "Five steps of rise 0.22 and tread 0.20.",
        *(block(f"step_{i + 1}", (0.2 * i - 0.5, -0.6, -0.66), (0.2 * i - 0.3, 0.6, 0.22 * (i - 2))) for i in range(5)),
    ),
    "v_groove": feature(
        "Two faces that meet in a valley, each at half the friction angle.",
        slab("right", 0.5 * FRICTION_ANGLE, 0.0, 0.5),
        slab("left", -0.5 * FRICTION_ANGLE, -0.5, 0.0),
    ),
}

WRITERS = (
    {f"parallel_bars_{percent}": lambda percent=percent: parallel_bars(percent) for percent in range(60, 135, 5)}
    | {f"features/{name}": write for name, write in FEATURES.items()}
    | {"features/rubble.obj": rubble_mesh_file, "m_groove": m_groove}
)
