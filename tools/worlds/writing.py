"""How shapes and worlds are written down."""

import math
from typing import NamedTuple

FLOOR_HALF_THICKNESS = 0.25
MU = 0.6


def number(value):
    """A TOML float with at most six decimals."""
    text = f"{value:.6f}".rstrip("0")
    return text + "0" if text.endswith(".") else text


def vector(values):
    return "[" + ", ".join(number(v + 0.0) for v in values) + "]"


class Shape(NamedTuple):
    """One `[[shapes]]` entry."""

    name: str
    xyz: tuple
    rpy: tuple | None
    kind: str

    def lines(self):
        turned = [] if self.rpy is None else [f"rpy = {vector(self.rpy)}"]
        return ["", "[[shapes]]", f'name = "{self.name}"', f"xyz = {vector(self.xyz)}", *turned, self.kind]

    def moved(self, prefix, dx, dy):
        """The same shape elsewhere, its name prefixed."""
        x, y, z = self.xyz
        return self._replace(name=prefix + self.name, xyz=(x + dx, y + dy, z))


def shape(name, xyz, kind, rpy=None):
    return Shape(name, tuple(xyz), rpy, kind)


def box(name, xyz, half_extents, rpy=None):
    return shape(name, xyz, f"box = {{ half_extents = {vector(half_extents)} }}", rpy)


def cylinder(name, xyz, radius, length, rpy):
    return shape(name, xyz, f"cylinder = {{ radius = {number(radius)}, length = {number(length)} }}", rpy)


def bar(name, xyz, radius, length):
    """A round bar that lies across the x axis."""
    return cylinder(name, xyz, radius, length, (math.pi / 2, 0.0, 0.0))


def block(name, low, high):
    """A box from its lower to its upper corner."""
    return box(name, [(a + b) / 2 for a, b in zip(low, high)], [(b - a) / 2 for a, b in zip(low, high)])


def i_beam(half_flange, low, high):
    """The parts of an I-beam with flanges and a web 0.015 thick: name, half width, lower and upper end."""
    yield "bottom_flange", half_flange, low, low + 0.015
    yield "web", 0.0075, low + 0.015, high - 0.015
    yield "top_flange", half_flange, high - 0.015, high


def floor(name, x_from, x_to, half_width, top=0.0):
    """A level floor across the x axis."""
    centre = ((x_from + x_to) / 2, 0.0, top - FLOOR_HALF_THICKNESS)
    return box(name, centre, ((x_to - x_from) / 2, half_width, FLOOR_HALF_THICKNESS))


def grid_file(cells_along, cells_across, corner):
    """A triangulated grid as OBJ; `corner(i, j)` is where one of its corners lies."""
    lines = ["# Written by tools/make_worlds.py."]
    for i in range(cells_along + 1):
        for j in range(cells_across + 1):
            lines.append("v " + " ".join(number(v + 0.0) for v in corner(i, j)))
    for i in range(cells_along):
        for j in range(cells_across):
            a = 1 + i * (cells_across + 1) + j
            b, c, d = a + cells_across + 1, a + cells_across + 2, a + 1
            lines += [f"f {a} {b} {c}", f"f {a} {c} {d}"]
    return "\n".join(lines) + "\n"


def world(comment, shapes):
    lines = ["# " + line for line in comment] + ["# Written by tools/make_worlds.py.", f"mu = {number(MU)}"]
    for entry in shapes:
        lines += entry.lines()
    return "\n".join(lines) + "\n"
