"""Finds the running instances of this user, and iceoryx2's configuration of each.

    import surefoot_instances
    instance = surefoot_instances.find(None)     # the only running one
    node_builder.config(instance.config())       # needs iceoryx2==0.10.0
    name = instance.service_name("chunks")

shared-types/src/instance/{base_folder, lock, location}.rs are the same in Rust.
"""

from __future__ import annotations

import dataclasses
import fcntl
import os
import pathlib
import re
import stat
from typing import Any

SHARED_MEMORY = pathlib.Path("/dev/shm")
TOKEN = re.compile("[0-9a-f]{16}")


class InstanceError(Exception):
    """No such instance, or one that is not private. The text says what to do."""


@dataclasses.dataclass(frozen=True)
class Instance:
    """A running instance: its name, its root folder and its random token."""

    name: str
    root: pathlib.Path
    token: str

    @property
    def segment_prefix(self) -> str:
        """The beginning of the name of every shared-memory segment."""
        return f"surefoot-{self.token}-{self.name}."

    def service_name(self, role: str) -> str:
        """The name of a service: role is chunks, feedback, state, requests or status."""
        return f"surefoot/{self.name}/{role}"

    def config(self) -> Any:
        """iceoryx2's configuration: root path and segment prefix."""
        import iceoryx2 as iox

        config = iox.config.default()
        config.global_cfg.root_path = iox.Path.new(str(self.root))
        config.global_cfg.prefix = iox.FileName.new(self.segment_prefix)
        return config


def is_private(folder: pathlib.Path) -> bool:
    """Whether the path is a folder, no link, that only this user may enter."""
    try:
        status = os.lstat(folder)
    except FileNotFoundError:
        return False
    mode = stat.S_IMODE(status.st_mode)
    return stat.S_ISDIR(status.st_mode) and status.st_uid == os.geteuid() and mode & 0o077 == 0


def base_folders() -> list[pathlib.Path]:
    """The private folders that hold this user's instances."""
    plain = f"surefoot-{os.geteuid()}"
    with_token = sorted(
        name
        for name in os.listdir(SHARED_MEMORY)
        if name.startswith(f"{plain}-") and TOKEN.fullmatch(name[len(plain) + 1 :])
    )
    folders = (SHARED_MEMORY / name for name in [plain, *with_token])
    return [folder for folder in folders if is_private(folder)]


def running() -> list[Instance]:
    """The running instances of this user, sorted by name."""
    roots = (root for base in base_folders() for root in sorted(base.iterdir()))
    found = (instance_at(root) for root in roots if is_private(root))
    return sorted((one for one in found if one is not None), key=lambda one: one.name)


def instance_at(root: pathlib.Path) -> Instance | None:
    """The running instance with this root folder; None if no process runs in it."""
    try:
        descriptor = os.open(root / "lock", os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError:
        return None
    try:
        if not stat.S_ISREG(os.fstat(descriptor).st_mode):
            return None
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return None  # No process holds the lock: the instance is dead.
        except BlockingIOError:
            pass
        token = os.read(descriptor, 64).decode("ascii", "replace").removesuffix("\n")
    finally:
        os.close(descriptor)
    return Instance(root.name, root, token) if TOKEN.fullmatch(token) else None


def find(name: str | None) -> Instance:
    """The running instance of this name; without a name, the only running one."""
    instances = running()
    if name is None and len(instances) == 1:
        return instances[0]
    for instance in instances:
        if instance.name == name:
            return instance
    names = ", ".join(instance.name for instance in instances)
    raise InstanceError(f"name a running instance: {names or 'none runs'}")
