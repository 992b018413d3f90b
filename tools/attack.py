#!/usr/bin/env python3
"""Attacks the shared memory of another user's instances: for a soak test beside it.

    surefoot bench soak --walks 100 &
    sudo -u nobody python3 tools/attack.py --seconds 300

It opens, truncates, overwrites and removes what belongs to the other user, takes the names of
folders, and puts files, pipes, folders and links of all names beside the segments. It prints what
succeeded; exit code 1 if anything did. Its own files are removed at the end.
"""

import argparse
import os
import random
import shutil
import sys
import time

SHARED_MEMORY = "/dev/shm"
OPENINGS = (os.O_RDWR, os.O_RDONLY, os.O_WRONLY | os.O_TRUNC)
ENDINGS = ("", ".x", ".connection", ".dynamic", ".data", ".service")
# Most files of its own at a time.
OWN_MAX = 300


class Attack:
    def __init__(self, seed):
        self.random = random.Random(seed)
        self.own = []
        self.tries = 0
        self.successes = []

    def run(self, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            names = [name for name in os.listdir(SHARED_MEMORY) if name.startswith("surefoot")]
            self.random.shuffle(names)
            for name in names[:40]:
                self.touch(f"{SHARED_MEMORY}/{name}")
                self.squat(f"{SHARED_MEMORY}/{name}{self.random.choice(ENDINGS)}")
            owner = self.random.choice((0, 1000))
            self.squat(f"{SHARED_MEMORY}/surefoot-{owner}")
            self.squat(f"{SHARED_MEMORY}/surefoot-{owner}-{self.random.getrandbits(64):016x}")
            while len(self.own) > OWN_MAX:
                remove(self.own.pop(0))
            time.sleep(0.002)
        for path in self.own:
            remove(path)

    def touch(self, path):
        """Reads, writes and removes a file of another user, if it can."""
        for flags in OPENINGS:
            self.tries += 1
            try:
                file = os.open(path, flags | os.O_NONBLOCK | os.O_NOFOLLOW)
            except OSError:
                continue
            if os.fstat(file).st_uid != os.geteuid():
                self.successes.append(f"opened {path} with {flags:#x}")
                if flags != os.O_RDONLY and not os.path.isdir(path):
                    os.write(file, b"\xff" * 64)
            os.close(file)
        for remove_it in (os.unlink, os.rmdir):
            try:
                if os.lstat(path).st_uid != os.geteuid():
                    remove_it(path)
                    self.successes.append(f"removed {path}")
            except OSError:
                pass

    def squat(self, path):
        """Takes a name that is free."""
        makers = (
            lambda: os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY)),
            lambda: os.mkfifo(path),
            lambda: os.mkdir(path, 0o700),
            lambda: os.symlink("/etc/passwd", path),
        )
        try:
            self.random.choice(makers)()
            self.own.append(path)
        except OSError:
            pass


def remove(path):
    if os.path.isdir(path) and not os.path.islink(path):
        shutil.rmtree(path, ignore_errors=True)
    elif os.path.lexists(path):
        os.unlink(path)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=300.0)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    attack = Attack(arguments.seed)
    attack.run(arguments.seconds)
    print(f"{attack.tries} attempts, {len(attack.successes)} of them succeeded")
    print("\n".join(attack.successes[:20]), end="")
    sys.exit(1 if attack.successes else 0)


main()
