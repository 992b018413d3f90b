"""The jungle gym: four platforms, and four ways between neighbours of them. x points east, y north."""

import math
import random

from worlds.courses import BAR_RADIUS, BAR_SPACING, BARS, SLAB_HALF, SLABS, SPIRAL_ANGLE, SPIRAL_RADIUS, SPIRAL_TOP
from worlds.writing import bar, block, box, i_beam, world

PLATFORM = 1.6
GROUND = -0.8
TOP = SPIRAL_TOP
SPAN = 2.0
"""From the eastern platforms to the western ones: the beam's length and the bars' span."""
FLIGHT = 1.0
"""From the southern platforms to the northern ones: five treads of 0.20; the sixth riser is the platform's."""
RISE, TREAD, FLIGHT_WIDTH = 0.22, 0.20, 1.2
BARS_ABOVE_GROUND = 1.0

EAST, WEST = SPAN / 2, -SPAN / 2
NORTH, SOUTH = FLIGHT / 2, -FLIGHT / 2
MIDDLE_EAST, MIDDLE_NORTH = EAST + PLATFORM / 2, NORTH + PLATFORM / 2
FAR_WEST = WEST - PLATFORM

SLAB_ZERO_EDGE = 0.12
"""From the spiral's axis to the platforms' western edges: there a slab below the first one, or above the last, would end."""
SPIRAL_AXIS = FAR_WEST - SLAB_ZERO_EDGE


def platforms(tops=(TOP, TOP)):
    """Solid from the ground to their tops; those of north-east and north-west are given."""
    yield block("ground", (-3.8, -2.3, GROUND - 0.5), (2.8, 2.3, GROUND))
    for side, west, top in (("east", EAST, tops[0]), ("west", FAR_WEST, tops[1])):
        yield block(f"platform_south_{side}", (west, SOUTH - PLATFORM, GROUND), (west + PLATFORM, SOUTH, 0.0))
        yield block(f"platform_north_{side}", (west, NORTH, GROUND), (west + PLATFORM, NORTH + PLATFORM, top))


def flight(rise=RISE):
    """Solid steps from south-east to north-east."""
    for i in range(5):
        west, south = MIDDLE_EAST - FLIGHT_WIDTH / 2, SOUTH + TREAD * i
        yield block(f"step_{i + 1}", (west, south, GROUND), (west + FLIGHT_WIDTH, south + TREAD, rise * (i + 1)))


def monkey_bars():
    """Bars from north-east to north-west, 1.0 above a ground of their own."""
    low, high = (WEST, NORTH, GROUND), (EAST, NORTH + PLATFORM, TOP - BARS_ABOVE_GROUND)
    yield block("ground_below_bars", low, high)
    first = -BAR_SPACING * (BARS - 1) / 2
    for i in range(BARS):
        yield bar(f"bar_{i + 1}", (first + BAR_SPACING * i, MIDDLE_NORTH, TOP - BAR_RADIUS), BAR_RADIUS, 1.2)


def rising_bars(low, high):
    """The bars of bars_uneven from north-east to north-west: 0.18 apart, in equal rises from the height of one platform to that of the other."""
    yield block("ground_below_bars", (WEST, NORTH, GROUND), (EAST, NORTH + PLATFORM, low - BARS_ABOVE_GROUND))
    rng = random.Random(UNEVEN_SEED)
    first = UNEVEN_SPACING * (UNEVEN_BARS - 1) / 2
    for i in range(UNEVEN_BARS):
        along, up = rng.uniform(-0.01, 0.01), rng.uniform(-0.03, 0.03)
        top = low + (high - low) * (i + 1) / (UNEVEN_BARS + 1)
        centre = (round(first - UNEVEN_SPACING * i - along, 4), MIDDLE_NORTH, round(top + up - BAR_RADIUS, 4))
        yield bar(f"bar_{i + 1}", centre, BAR_RADIUS, 1.2)


def beam(half_flange=0.06):
    """The I-beam from south-east to south-west: 0.20 high, flanges 0.015 thick, web 0.015."""
    for part, half_width, low, high in i_beam(half_flange, -0.20, 0.0):
        yield block(f"beam_{part}", (WEST, -MIDDLE_NORTH - half_width, low), (EAST, -MIDDLE_NORTH + half_width, high))


def spiral(top=TOP):
    """Slabs from south-west to north-west, winding clockwise about an axis halfway between both."""
    for i in range(1, SLABS + 1):
        angle = math.pi + SPIRAL_ANGLE * ((SLABS + 1) / 2 - i)
        centre = (SPIRAL_AXIS + SPIRAL_RADIUS * math.cos(angle), SPIRAL_RADIUS * math.sin(angle))
        yield box(f"slab_{i}", (*centre, top * i / (SLABS + 1) - SLAB_HALF[2]), SLAB_HALF, (0.0, 0.0, angle))


COMMENT = (
    "A jungle gym about the origin; x points east, y north. Four platforms 1.6 x 1.6: south-east and south-west at z = 0 with the",
    "ground 0.8 below, north-east and north-west at z = 1.32. From south-east to north-east climb six risers of 0.22, from",
)


def jungle_gym(with_bars, with_beam):
    bars = "north-east to north-west lie twelve monkey bars, from" if with_bars else "north-east to north-west leads nothing, from"
    beam_line = "south-east to south-west lies an I-beam, and from" if with_beam else "south-east to south-west leads nothing, and from"
    comment = (*COMMENT, f"{bars} {beam_line}", "south-west to north-west wind six spiral steps.")
    shapes = [*platforms(), *flight(), *spiral()]
    shapes += monkey_bars() if with_bars else []
    shapes += beam() if with_beam else []
    return world(comment, shapes)


HARD_RISE, HARD_SPIRAL_RISE, HARD_HALF_FLANGE = 0.26, 0.28, 0.03
UNEVEN_SPACING, UNEVEN_BARS, UNEVEN_SEED = 0.18, 11, 1
"""As in bars_uneven."""


def gym_hard():
    tops = (6 * HARD_RISE, (SLABS + 1) * HARD_SPIRAL_RISE)
    shapes = [*platforms(tops), *flight(HARD_RISE), *spiral(tops[1]), *rising_bars(*tops), *beam(HARD_HALF_FLANGE)]
    comment = (
        "As jungle_gym_full, of the harder ways: risers of 0.26 (stairs_steep) to a platform at 1.56, bars 0.18 apart and uneven",
        "(bars_uneven) that rise evenly to a platform at 1.96, a beam with flanges 0.06 wide (beam_narrow), and a spiral with rises of",
        "0.28 (spiral_high).",
    )
    return world(comment, shapes)


WRITERS = {
    "gym_hard": gym_hard,
    "jungle_gym_full": lambda: jungle_gym(True, True),
    "jungle_gym_spiral_route": lambda: jungle_gym(False, True),
    "jungle_gym_stair_route": lambda: jungle_gym(True, False),
}
