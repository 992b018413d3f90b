#!/usr/bin/env python3
"""Writes the worlds whose shapes are drawn at random or repeat, into configs/worlds/.

    tools/make_worlds.py            write all of them
    tools/make_worlds.py --check    write nothing; exit 1 if a file differs from what would be written

The files are what counts: they are committed, and the planner and its tests read them. Every draw comes from
random.Random(SEED), whose sequence Python guarantees. Standard library only.
"""

import sys
from pathlib import Path

from worlds import beyond, courses, gym, harder, heap, holes, rough, samples

WORLDS = Path(__file__).resolve().parent.parent / "configs" / "worlds"
WRITERS = (
    beyond.WRITERS
    | courses.WRITERS
    | gym.WRITERS
    | harder.WRITERS
    | heap.WRITERS
    | holes.WRITERS
    | rough.WRITERS
    | samples.WRITERS
)


def main(arguments):
    if arguments not in ([], ["--check"]):
        print(__doc__, file=sys.stderr)
        return 2
    stale = []
    for name, write in WRITERS.items():
        path, text = WORLDS / (name if "." in name else f"{name}.toml"), write()
        if not arguments:
            path.parent.mkdir(exist_ok=True)
            path.write_text(text)
        elif not path.exists() or path.read_text() != text:
            stale.append(path)
    for path in stale:
        print(f"{path} is not what this script writes", file=sys.stderr)
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
