#!/usr/bin/env python3
"""Draws the searches of `surefoot bench methods --out DIR`, and prints their tables.

    tools/plot_methods.py DIR OUT.svg      reads DIR/methods.jsonl

A circle's area is the share of the searches that found a plan, its colour their mean work relative to the least of the
world. Tables in Markdown, for each method: plans found, mean work in thousands of units and mean steps; plans found and
mean processor milliseconds. Standard library only.
"""

import json
import math
import sys
from pathlib import Path

METHODS = "rpg rpg-discs astar astar-adaptive reachability random-mmp w-rpg mmprm bounding-box".split()
CELL_WIDTH, CELL_HEIGHT, LEFT, TOP = 104, 34, 130, 64
RADIUS_MAX = 14.0
RATIO_MAX = 30.0
"""Work relative to the least at which the colour ends."""


def searches(folder):
    """The searches of each world and method, in the order of the journal."""
    table = {}
    with open(Path(folder) / "methods.jsonl") as journal:
        next(journal)
        for line in journal:
            search = json.loads(line)
            key = search["trial"]["scenario"], search["method"]
            table.setdefault(key, []).append(search)
    return table


class Cell:
    """The searches of a world by a method."""

    def __init__(self, searches):
        self.trials = len(searches)
        self.is_expressible = any(one["trial"]["outcome"] != "not_expressible" for one in searches)
        self.is_expressible |= not searches
        found = [one for one in searches if one["trial"]["outcome"] == "found"]
        self.found = len(found)
        mean = lambda of: sum(map(of, found)) / len(found) if found else math.nan
        self.work = mean(lambda one: one["trial"]["work"])
        self.milliseconds = 1e3 * mean(lambda one: one["trial"]["processor_seconds"])
        self.steps = mean(lambda one: one["steps"])

    def text(self, numbers):
        if self.found:
            return f"{self.found}: {numbers}"
        return "not run" if not self.trials else "0" if self.is_expressible else "n/e"


def print_table(cells, worlds, methods, numbers):
    print("| World |", " | ".join(f"`{method}`" for method in methods), "|")
    print("|", " | ".join(["---"] * (len(methods) + 1)), "|")
    for world in worlds:
        row = [cells[world, method] for method in methods]
        print(f"| {world} |", " | ".join(cell.text(numbers(cell)) for cell in row), "|")
    found = [sum(cells[world, method].found for world in worlds) for method in methods]
    trials = [sum(cells[world, method].trials for world in worlds) for method in methods]
    print("| all |", " | ".join(f"{one} of {of}" for one, of in zip(found, trials)), "|\n")


def colour(ratio):
    """From green (the least work) over yellow to red."""
    part = min(1.0, math.log(ratio) / math.log(RATIO_MAX))
    stops = [(61, 139, 55), (232, 196, 72), (200, 85, 61)]
    low = min(int(2 * part), 1)
    blend = [round(a + (b - a) * (2 * part - low)) for a, b in zip(stops[low], stops[low + 1])]
    return "#" + "".join(f"{value:02x}" for value in blend)


def figure(cells, worlds, methods):
    width, height = LEFT + CELL_WIDTH * len(methods) + 10, TOP + CELL_HEIGHT * len(worlds) + 40
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
        'font-family="sans-serif" font-size="12">',
        f'<rect width="{width}" height="{height}" fill="white"/>',
        f'<text x="{LEFT}" y="22" font-size="14">Plans found (area) and mean work of a plan, '
        "thousands of units</text>",
    ]
    for column, method in enumerate(methods):
        x = LEFT + CELL_WIDTH * (column + 0.5)
        out.append(f'<text x="{x}" y="{TOP - 16}" text-anchor="middle">{method}</text>')
    for row, world in enumerate(worlds):
        y = TOP + CELL_HEIGHT * (row + 0.5)
        out.append(f'<text x="{LEFT - 12}" y="{y + 4}" text-anchor="end">{world}</text>')
        of_world = [cells[world, method] for method in methods]
        least = min((cell.work for cell in of_world if cell.found), default=math.nan)
        for column, cell in enumerate(of_world):
            x = LEFT + CELL_WIDTH * (column + 0.3)
            if not cell.found:
                label = "0" if cell.is_expressible else "not expressible"
                out.append(f'<text x="{x - 6}" y="{y + 4}" fill="#999">{label}</text>')
                continue
            radius = RADIUS_MAX * math.sqrt(cell.found / cell.trials)
            fill = colour(cell.work / least)
            out.append(f'<circle cx="{x:.1f}" cy="{y}" r="{RADIUS_MAX}" fill="none" stroke="#ccc"/>')
            out.append(f'<circle cx="{x:.1f}" cy="{y}" r="{radius:.1f}" fill="{fill}"/>')
            out.append(f'<text x="{x + 20:.1f}" y="{y + 4}">{cell.work / 1e3:.1f}</text>')
    y = height - 14
    for index, ratio in enumerate((1, 2, 5, 10, RATIO_MAX)):
        x = LEFT + 150 * index
        out.append(f'<circle cx="{x}" cy="{y - 4}" r="7" fill="{colour(ratio)}"/>')
        out.append(f'<text x="{x + 14}" y="{y}">{ratio:g} times the least</text>')
    return "\n".join([*out, "</svg>"]) + "\n"


def main(arguments):
    if len(arguments) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    folder, out = arguments
    table = searches(folder)
    worlds = list(dict.fromkeys(world for world, _ in table))
    methods = [method for method in METHODS if any((world, method) in table for world in worlds)]
    cells = {(world, method): Cell(table.get((world, method), [])) for world in worlds for method in methods}
    print_table(cells, worlds, methods, lambda cell: f"{cell.work / 1e3:.1f}, {cell.steps:.0f}")
    print_table(cells, worlds, methods, lambda cell: f"{cell.milliseconds:.0f}")
    Path(out).write_text(figure(cells, worlds, methods))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
