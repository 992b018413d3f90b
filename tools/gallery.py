#!/usr/bin/env python3
"""Draws the pictures of docs/GALLERY.md: the plan of each scenario, and one search without a plan.

Needs `surefoot` in PATH or at --program, and the Python package Pillow, which reduces the pictures
to 256 colours: 20 of them take 2 MB. The page itself is written too: its sentences are those of
`surefoot list`.
"""

import argparse
import pathlib
import subprocess
import sys
import textwrap

DOCS = pathlib.Path(__file__).resolve().parent.parent / "docs"
FOUND = [
    "flat_walk",
    "ibeam_gap",
    "ibeam_hallway",
    "beam",
    "stairs",
    "cinder_blocks",
    "stepping_stones",
    "checkers",
    "pass_under",
    "rough_ground",
    "spiral_steps",
    "monkey_bars",
    "bars_thin",
    "jungle_gym_full",
    "jungle_gym_spiral_route",
    "sl1m_complex",
    "stairs_bauzil",
    "gauntlet_1",
    "gauntlet_2",
]
NOT_FOUND = ["no_way_wall"]
EXIT_NO_PLAN = 3
HEAD = """\
# Gallery

The plans of shipped scenarios, and one search that found none, as
`surefoot plan NAME --picture NAME.png` draws them. `tools/gallery.py` makes this page.

The robot is drawn at up to eight instants, from the start (blue) to the goal (red), under their
times where these are not hidden; lines of a floor are 0.5 m apart. Left soles are teal, right soles
magenta; the lines around them are the support polygons, and the thin line above is the path of the
centre of mass.
"""
SEARCH = """\

Without a plan the picture shows how far the search came: lines are the trees of the search from
start and goal, and the orange mark is the bottleneck.
"""


def draw(program, scenario, folder):
    """Draws one scenario; returns its exit code."""
    path = folder / f"{scenario}.png"
    command = [program, "plan", scenario, "--quiet", "--picture", str(path)]
    code = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, check=False)
    if code.returncode not in (0, EXIT_NO_PLAN):
        sys.exit(f"{scenario}: {code.stderr.decode()}")
    reduce(path)
    return code.returncode


def reduce(path):
    """Rewrites a picture with a palette, without dithering."""
    from PIL import Image

    with Image.open(path) as picture:
        few = picture.convert("RGB").quantize(256, dither=Image.Dither.NONE)
    few.save(path, optimize=True)


def sentences(program):
    """What `surefoot list` says of each scenario."""
    listed = subprocess.run([program, "list"], capture_output=True, text=True, check=True).stdout
    table = listed.split("\n\n")[0].splitlines()[1:]
    return dict(line.strip().split(maxsplit=1) for line in table)


def page(said):
    """The text of docs/GALLERY.md."""
    text = HEAD
    for scenario in FOUND + NOT_FOUND:
        text += SEARCH if scenario == NOT_FOUND[0] else ""
        text += f"\n## {scenario}\n\n{textwrap.fill(said[scenario], 100)}\n\n![{scenario}](gallery/{scenario}.png)\n"
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default="surefoot", help="the command surefoot")
    options = parser.parse_args()
    folder = DOCS / "gallery"
    folder.mkdir(exist_ok=True)
    for scenario in FOUND + NOT_FOUND:
        wanted = EXIT_NO_PLAN if scenario in NOT_FOUND else 0
        code = draw(options.program, scenario, folder)
        if code != wanted:
            sys.exit(f"{scenario}: exit code {code}, not {wanted}")
    (DOCS / "GALLERY.md").write_text(page(sentences(options.program)))


if __name__ == "__main__":
    main()
