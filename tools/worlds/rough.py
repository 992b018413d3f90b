"""Rough ground: one triangle mesh of hills and dents, as a depth camera may give it."""

import math
import random

from worlds.writing import number, shape, world

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
    lines = ["# Written by tools/make_worlds.py."]
    for i in range(CELLS_ALONG + 1):
        for j in range(CELLS_ACROSS + 1):
            x, y = FIRST + CELL * i, CELL * (j - CELLS_ACROSS / 2)
            lines.append("v " + " ".join(number(round(v, 4) + 0.0) for v in (x, y, height(rng, x, y))))
    for i in range(CELLS_ALONG):
        for j in range(CELLS_ACROSS):
            a = 1 + i * (CELLS_ACROSS + 1) + j
            b, c, d = a + CELLS_ACROSS + 1, a + CELLS_ACROSS + 2, a + 1
            lines += [f"f {a} {b} {c}", f"f {a} {c} {d}"]
    return "\n".join(lines) + "\n"


def rough_ground():
    comment = ("Four metres of hills and dents between two level ends, as one triangle mesh: hardly two triangles lie in one plane.",)
    return world(comment, [shape("ground", (0.0, 0.0, 0.0), 'mesh = { path = "rough_ground.obj" }')])


WRITERS = {"rough_ground": rough_ground, "rough_ground.obj": rough_ground_file}
