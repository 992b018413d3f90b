#!/usr/bin/env python3
"""Fails if a locked dependency needs a newer Rust than the workspace declares.

Compares the `rust-version` of every package in Cargo.lock that is built on x86-64 Linux with the
workspace's own. Packages that declare none are only counted. The workspace's own sources are held
to their rust-version by clippy's lint `incompatible_msrv`.
"""

import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
TARGET = "x86_64-unknown-linux-gnu"


def version(text):
    """'1.89' -> (1, 89, 0)."""
    return tuple(([int(part) for part in text.split(".")] + [0, 0])[:3])


def newer(packages, declared):
    """The dependencies whose declared minimum is above `declared`, as lines of text."""
    return [
        f"{package['name']} {package['version']} needs Rust {package['rust_version']}"
        for package in packages
        if package["rust_version"] and version(package["rust_version"]) > version(declared)
    ]


def main():
    command = ["cargo", "metadata", "--format-version=1", "--locked", "--filter-platform", TARGET]
    output = subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE).stdout
    metadata = json.loads(output)
    members = set(metadata["workspace_members"])
    ours = {package["rust_version"] for package in metadata["packages"] if package["id"] in members}
    if len(ours) != 1 or None in ours:
        sys.exit(f"the workspace declares {sorted(map(str, ours))}; expected one rust-version")
    declared = ours.pop()
    faults = newer(metadata["packages"], declared)
    if faults:
        sys.exit("\n".join([f"rust-version is {declared}, but:", *faults]))
    silent = sum(not package["rust_version"] for package in metadata["packages"])
    total = len(metadata["packages"])
    print(f"{total} packages need at most Rust {declared}; {silent} of them declare no version")


if __name__ == "__main__":
    main()
