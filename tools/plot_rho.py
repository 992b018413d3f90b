#!/usr/bin/env python3
"""Draws figure 5.8 from reports of `surefoot bench rho --json`.

    tools/plot_rho.py OUT REPORT.json...    write OUT.csv and OUT.svg

The cost of a walk is the work of all searches of a radius, those without a plan included, divided by the plans found:
the mean work if a search that ends at the work limit is begun again with another seed. MMPRM is w-RPG with an infinite
radius. Rows whose radius grows are in OUT.csv alone. Standard library only.
"""

import csv
import json
import math
import sys

WIDTH, HEIGHT = 760, 440
LEFT, TOP, RIGHT, BOTTOM = 80, 40, 230, 60
COLOURS = ("#1b6ca8", "#c8553d", "#3d8b37")
INFINITE_AT = 8.0
"""Where an infinite radius stands: past 4, the largest finite one."""


def rows(paths):
    for path in paths:
        with open(path) as file:
            report = json.load(file)
        for row in report["rows"]:
            found, trials = row["found"], row["trials"]
            work = (row["mean_work"] or 0.0) * found + report["work_max"] * (trials - found)
            yield {
                "method": "w-rpg" if row["method"] == "mmprm" else row["method"],
                "scenario": row["scenario"],
                "rho_share": row["disc_radius_share"] or "inf",
                "rho_growth": row.get("disc_radius_growth") or 1.0,
                "trials": trials,
                "found": found,
                "work_max": report["work_max"],
                "mean_work_of_found": round(row["mean_work"]) if found else "",
                "work_per_plan": round(work / found) if found else "",
            }


def x_of(row):
    share = row["rho_share"]
    return INFINITE_AT if share == "inf" else float(share)


def curve_of(row):
    return row["method"], row["scenario"]


def figure(table):
    drawn = [row for row in table if row["found"] and row["rho_growth"] == 1.0]
    least = {}
    for row in drawn:
        name = curve_of(row)
        least[name] = min(least.get(name, math.inf), row["work_per_plan"])
    scenarios = sorted({scenario for _, scenario in least})
    methods = sorted({method for method, _ in least}, reverse=True)
    ratio = lambda row: row["work_per_plan"] / least[curve_of(row)]
    top = max(map(ratio, drawn))
    across = lambda x: LEFT + (math.log2(x) + 2) / (math.log2(INFINITE_AT) + 2) * (WIDTH - LEFT - RIGHT)
    up = lambda y: HEIGHT - BOTTOM - math.log(y) / math.log(1.1 * top) * (HEIGHT - TOP - BOTTOM)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" font-family="sans-serif" font-size="12">']
    out.append(f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>')
    out.append(f'<text x="{LEFT}" y="20" font-size="14">Work per plan over the radius of the discs, relative to the least</text>')
    for x in (0.25, 0.5, 1, 2, 4, INFINITE_AT):
        label = "inf" if x == INFINITE_AT else f"{x:g}"
        out.append(f'<line x1="{across(x):.1f}" x2="{across(x):.1f}" y1="{TOP}" y2="{HEIGHT - BOTTOM}" stroke="#ddd"/>')
        out.append(f'<text x="{across(x):.1f}" y="{HEIGHT - BOTTOM + 18}" text-anchor="middle">{label}</text>')
    for y in (1, 2, 3, 5, 10, 20, 50, 100):
        if y <= 1.1 * top:
            out.append(f'<line x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{up(y):.1f}" y2="{up(y):.1f}" stroke="#ddd"/>')
            out.append(f'<text x="{LEFT - 8}" y="{up(y) + 4:.1f}" text-anchor="end">{y}</text>')
    out.append(f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 16}" text-anchor="middle">rho / R_max</text>')
    for index, name in enumerate(sorted(least, key=lambda name: (methods.index(name[0]), name[1]))):
        curve = sorted((row for row in drawn if curve_of(row) == name), key=x_of)
        points = " ".join(f"{across(x_of(row)):.1f},{up(ratio(row)):.1f}" for row in curve)
        colour = COLOURS[scenarios.index(name[1]) % len(COLOURS)]
        dashes = ' stroke-dasharray="6 4"' if methods.index(name[0]) else ""
        out.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="2"{dashes}/>')
        for row in curve:
            out.append(f'<circle cx="{across(x_of(row)):.1f}" cy="{up(ratio(row)):.1f}" r="3" fill="{colour}"/>')
        y = TOP + 20 + 20 * index
        out.append(f'<text x="{WIDTH - RIGHT + 16}" y="{y}" fill="{colour}">{" ".join(name)}{" (dashed)" if dashes else ""}</text>')
    return "\n".join([*out, "</svg>"]) + "\n"


def main(arguments):
    if len(arguments) < 2:
        print(__doc__, file=sys.stderr)
        return 2
    out, *paths = arguments
    table = sorted(rows(paths), key=lambda row: (curve_of(row), row["rho_growth"], x_of(row)))
    with open(f"{out}.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, table[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(table)
    with open(f"{out}.svg", "w") as file:
        file.write(figure(table))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
