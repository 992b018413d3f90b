"""Listens to a running walk, through the package ``iceoryx2``."""

from __future__ import annotations

import ctypes
import time
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot import _instances, _messages
from surefoot.errors import InstanceError, missing
from surefoot.plans import FEET, Foothold

POLL_SECONDS = 0.0005
"""Time between two looks for a message."""
CHUNKS_BUFFERED = 8
"""Chunks that wait for a slow reader, as in shared-types/src/instance/tuning.rs."""
CARRYING = ((True, False), (False, True), (True, True))
"""Whether the left and the right foot carry in each support mode."""
FIRST, LAST = 1, 2
"""Flags of the first and the last chunk of a plan."""


@dataclass(frozen=True)
class Chunk:
    """A part of a plan within one support mode, as the planner published it."""

    plan_id: int
    """Number of the plan in its session."""
    epoch: int
    """Number of the replan within the plan."""
    sequence: int
    """Number of the chunk in its epoch, from 0."""
    is_first: bool
    """Whether the plan begins with it."""
    is_last: bool
    """Whether the plan ends with it."""
    contacts: tuple[bool, bool]
    """Whether the left and the right foot carry the robot."""
    footholds: list[Foothold]
    """The stance feet."""
    time: NDArray[np.float64]
    """Times of the waypoints since the beginning of the plan, s."""
    root_position: NDArray[np.float64]
    """Positions of the root link in the world, m, a row each."""
    root_rotation: NDArray[np.float64]
    """Rotations of the root link, unit quaternions x, y, z, w."""
    joints: NDArray[np.float64]
    """Joint positions in the order of :attr:`surefoot.Robot.joint_names`, rad or m."""


@dataclass(frozen=True)
class Description:
    """What a reader has to know of a walk; no file is needed."""

    robot_name: str
    """The robot's name in its URDF."""
    joint_names: tuple[str, ...]
    """The moving joints in the order of all joint vectors."""
    joint_limits: NDArray[np.float64]
    """Lower and upper position limit of each joint, rad or m, a row each."""
    root_link: str
    """The link whose pose is that of the root."""
    robot_digest: str
    """Digest of the robot."""
    world_digest: str
    """Digest of the world as planner and controller knew it at their start."""
    scenario_digest: str
    """Digest of the scenario."""
    conventions: str
    """Frame, orders and units of all numbers."""


class Subscription:
    """Receives the chunks of an instance. Nobody waits for it: what it reads too late it misses.

    Iterating ends when the planner has left, or the instance has ended. Close it, or use it with
    ``with``.
    """

    def __init__(self, instance: _instances.Instance) -> None:
        try:
            import iceoryx2 as iox
        except ImportError:
            raise missing("iceoryx2", "live") from None
        self.instance = instance.name
        """The name of the instance."""
        self.missed = 0
        """Chunks that were sent and not received: those that later ones show, and at the end those
        that the controller has accepted."""
        self._root = instance.root
        self._plan: tuple[int, int] | None = None
        self._session = 0
        self._next = 0
        self._accepted = 0
        iox.set_log_level(iox.LogLevel.Fatal)
        try:
            node = _node(iox, instance)
            self._service, self._subscriber = _open(
                iox, node, instance, "chunks", _messages.PlanChunk, CHUNKS_BUFFERED
            )
            self._ports = {
                role: _open(iox, node, instance, role, message, 1)
                for role, message in (
                    ("feedback", _messages.Feedback),
                    ("description", _messages.Description),
                )
            }
        except Exception as error:  # The package has an exception for each reason.
            raise InstanceError(
                f"the chunks of '{instance.name}' cannot be subscribed to ({error!r}); is it of "
                "this version of surefoot?"
            ) from None

    def receive(self) -> Chunk | None:
        """The next chunk, if one has come."""
        accepted = self._read_feedback()
        sample = _next_intact(self._subscriber)
        if sample is None:
            self._accepted = max(self._accepted, accepted)
            self._settle()
            return None
        message = sample.payload().contents
        chunk = _chunk(message)
        session = message.session
        sample.delete()
        plan = (chunk.plan_id, chunk.epoch)
        if plan != self._plan or (chunk.sequence == 0 and session != self._session):
            self._settle()
            self._next = self._accepted = 0
        self._plan, self._session = plan, session
        self.missed += max(0, chunk.sequence - self._next)
        self._next = max(self._next, chunk.sequence + 1)
        return chunk

    def description(self, *, wait: float = 5.0) -> Description:
        """What a reader has to know of the walk; waits up to ``wait`` seconds for it.

        Raises :class:`InstanceError` if neither planner nor controller has published it.
        """
        deadline = time.monotonic() + wait
        while (sample := _next_intact(self._ports["description"][1])) is None:
            if time.monotonic() >= deadline:
                raise InstanceError(f"'{self.instance}' has no planner and no controller yet")
            time.sleep(POLL_SECONDS)
        described = _description(sample.payload().contents)
        sample.delete()
        return described

    def _read_feedback(self) -> int:
        """The number of chunks of the current plan that the controller has accepted."""
        accepted = 0
        while (sample := _next_intact(self._ports["feedback"][1])) is not None:
            message = sample.payload().contents
            if (message.plan_id, message.epoch) == self._plan:
                accepted = max(accepted, message.next_sequence)
            sample.delete()
        return accepted

    def _settle(self) -> None:
        """There is no further chunk: the accepted ones that were not received are missed."""
        self.missed += max(0, self._accepted - self._next)
        self._next = max(self._next, self._accepted)

    def is_attended(self) -> bool:
        """Whether a planner is connected."""
        return bool(self._service.dynamic_config.number_of_publishers > 0)

    def is_running(self) -> bool:
        """Whether any process runs the instance."""
        return _instances.instance_at(self._root) is not None

    def __iter__(self) -> Iterator[Chunk]:
        has_chunk = False
        while True:
            attended = self.is_attended() if has_chunk else self.is_running()
            while (chunk := self.receive()) is not None:
                has_chunk = True
                yield chunk
            if not attended:
                return
            time.sleep(POLL_SECONDS)

    def close(self) -> None:
        """Lets go of the shared memory."""
        self._subscriber = self._service = None
        self._ports = {}

    def __enter__(self) -> Subscription:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def subscribe(instance: str | None = None, *, wait: float = 10.0) -> Subscription:
    """Attaches to a running instance; without a name to the only one. It waits up to ``wait``
    seconds for it to appear.

    Raises :class:`InstanceError` if there is none, :class:`MissingPackage` without ``iceoryx2``.
    """
    deadline = time.monotonic() + wait
    while True:
        try:
            return Subscription(_instances.find(instance))
        except (_instances.InstanceError, InstanceError) as error:
            if time.monotonic() >= deadline:
                raise InstanceError(str(error)) from None
        time.sleep(0.05)


def _node(iox: Any, instance: _instances.Instance) -> Any:
    """A node in the instance."""
    builder = iox.NodeBuilder.new().config(instance.config())
    builder = builder.signal_handling_mode(iox.SignalHandlingMode.Disabled)
    return builder.create(iox.ServiceType.Ipc)


def _open(
    iox: Any, node: Any, instance: _instances.Instance, role: str, message: Any, buffered: int
) -> tuple[Any, Any]:
    """A service, whose layout must be ours, and a subscriber of it."""
    layout = iox.AttributeVerifier.new().require(
        iox.AttributeKey.new("surefoot.layout"), iox.AttributeValue.new(message.LAYOUT)
    )
    name = iox.ServiceName.new(instance.service_name(role))
    service = node.service_builder(name).publish_subscribe(message).open_with_attributes(layout)
    return service, service.subscriber_builder().buffer_size(buffered).create()


def _next_intact(subscriber: Any) -> Any:
    """The next sample whose message is undamaged; ``None`` if there is none."""
    while (sample := subscriber.receive()) is not None:
        if _crc_matches(sample.payload().contents):
            return sample
        sample.delete()
    return None


def _crc_matches(message: Any) -> bool:
    """Whether a message holds the CRC-32 of its bytes, in which the CRC counts as zero."""
    field = type(message).crc
    content = ctypes.string_at(ctypes.addressof(message), ctypes.sizeof(message))
    crc = zlib.crc32(content[: field.offset])
    crc = zlib.crc32(bytes(field.size), crc)
    return zlib.crc32(content[field.offset + field.size :], crc) == int(message.crc)


def _text(name: Any) -> str:
    return bytes(name.bytes)[: name.length].decode()


def _description(message: Any) -> Description:
    joints = message.joints[: message.joints_len]
    return Description(
        robot_name=_text(message.robot_name),
        joint_names=tuple(_text(joint.name) for joint in joints),
        joint_limits=np.array([(joint.lower, joint.upper) for joint in joints]).reshape(-1, 2),
        root_link=_text(message.root_link),
        robot_digest=bytes(message.robot).hex(),
        world_digest=bytes(message.world).hex(),
        scenario_digest=bytes(message.config).hex(),
        conventions=bytes(message.conventions).rstrip(b"\0").decode(),
    )


def _chunk(message: Any) -> Chunk:
    waypoints = np.ctypeslib.as_array(message.waypoints)[: message.waypoints_len]
    return Chunk(
        plan_id=message.plan_id,
        epoch=message.epoch,
        sequence=message.sequence,
        is_first=bool(message.flags & FIRST),
        is_last=bool(message.flags & LAST),
        contacts=CARRYING[message.mode],
        footholds=[
            _foothold(message.contacts[at], waypoints["time"][0])
            for at in range(message.contacts_len)
        ],
        time=waypoints["time"].copy(),
        root_position=waypoints["root_position"].copy(),
        root_rotation=waypoints["root_rotation"].copy(),
        joints=waypoints["q"][:, : message.joints_len].copy(),
    )


def _foothold(contact: Any, begin: float) -> Foothold:
    polygon = np.array([list(corner) for corner in contact.polygon])
    return Foothold(
        foot=FEET[contact.limb],
        time=float(begin),
        position=np.array(list(contact.position)),
        rotation=np.array(list(contact.rotation)),
        polygon=polygon[: contact.polygon_len],
    )
