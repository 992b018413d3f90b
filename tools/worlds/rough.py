"""Rough ground: one triangle mesh of hills and dents, as a depth camera may give it."""

import math
import random

from worlds.writing import grid_file, shape, world

SEED = 1
CELL, CELLS_ALONG, CELLS_ACROSS = 0.10, 66, 20
FIRST = -0.8
# The rough part along x, and over how far it fades into level ground at both ends.
ROUGH, FADE = (0.5, 4.5), 0.5
# Height of the hills, and of the dents on them.
HILLS, DENTS = 0.09, 0.002


def waves():
    rng = random.Random(SEED)
    return [(rng.uniform(1.5, 3.5), rng.uniform(-2.5, 2.5), rng.uniform(0.0, 2 * math.pi)) for _ in range(6)]


def height(rng, x, y):
    share = min(1.0, max(0.0, (x - ROUGH[0]) / FADE), max(0.0, (ROUGH[1] - x) / FADE))
    hills = HILLS / 2 * sum(math.sin(kx * x + ky * y + phase) for kx, ky, phase in waves())
    return share * (hills + rng.uniform(-DENTS, DENTS))


def rough_ground_file():
    rng = random.Random(SEED)

    def corner(i, j):
        x, y = FIRST + CELL * i, CELL * (j - CELLS_ACROSS / 2)
        return x, y, round(height(rng, x, y), 4)

    return grid_file(CELLS_ALONG, CELLS_ACROSS, corner)


def rough_ground():
    comment = ("Four metres of hills and dents between two level ends, as one triangle mesh: hardly two triangles lie in one plane.",)
    return world(comment, [shape("ground", (0.0, 0.0, 0.0), 'mesh = { path = "rough_ground.obj" }')])


WRITERS = {"rough_ground": rough_ground, "rough_ground.obj": rough_ground_file}
