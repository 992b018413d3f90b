"""A running walk is heard in another process. Skipped without iceoryx2 and the program."""

from __future__ import annotations

import os
import shutil
import subprocess
import zlib
from pathlib import Path

import numpy as np
import pytest

import surefoot
from surefoot import _messages
from surefoot import live as live_module

pytest.importorskip("iceoryx2")
PROGRAM = os.environ.get("SUREFOOT_PROGRAM") or shutil.which("surefoot")
pytestmark = pytest.mark.skipif(PROGRAM is None, reason="no program; set SUREFOOT_PROGRAM")


def walk(*options: str) -> subprocess.Popen[str]:
    """A walk that starts now."""
    command = [str(PROGRAM), "walk", "stepping_stones", "--quiet", *options]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def test_every_chunk_is_received_or_counted_as_missed() -> None:
    name = f"test-live-{os.getpid()}"
    walking = walk("--instance", name, "--rate", "20")
    with surefoot.subscribe(name, wait=60.0) as live:
        described = live.description(wait=60.0)
        chunks = list(live)
        missed = live.missed
    assert walking.wait(timeout=120) == 0, walking.stderr
    plan = surefoot.Scenario("stepping_stones").plan()
    assert len(chunks) + missed == len(plan.chunk_times)
    robot = surefoot.Robot("hubo")
    assert described.joint_names == tuple(robot.joint_names)
    assert described.robot_name == "hubo" and "quaternion x y z w" in described.conventions
    assert described.joint_limits.shape == (len(robot.joint_names), 2)
    assert chunks and chunks[-1].is_last and chunks[0].plan_id == 1
    for chunk in chunks:
        begin, end = plan.chunk_times[chunk.sequence]
        assert (chunk.time[0], chunk.time[-1]) == (begin, end)
        first = int(np.searchsorted(plan.waypoints.time, begin))
        planned = plan.waypoints.joints[first : first + len(chunk.time)]
        assert (chunk.joints == planned).all()
        carrying = [step.foot for step in chunk.footholds]
        assert carrying == [foot for foot, on in zip(surefoot.FEET, chunk.contacts) if on]


def test_a_walk_without_a_plan_ends_the_subscription(tmp_path: Path) -> None:
    name = f"test-none-{os.getpid()}"
    task = surefoot.Scenario("no_way_wall")
    scenario = tmp_path / "scenario.toml"
    scenario.write_text(
        f'robot = "{task.robot_path}"\nworld = "{task.world_path}"\n'
        f"start = {{ xyz = [{task.start.x}, {task.start.y}, {task.start.z}] }}\n"
        f"goal = {{ xyz = [{task.goal.x}, {task.goal.y}, {task.goal.z}] }}\n"
        "planner = { work_max = 3000 }\n"
    )
    command = [str(PROGRAM), "walk", str(scenario), "--quiet", "--instance", name]
    walking = subprocess.Popen(command, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    with surefoot.subscribe(name, wait=60.0) as live:
        assert list(live) == [] and live.missed == 0
    assert walking.wait(timeout=60) == 3


def test_an_instance_that_does_not_run_is_named() -> None:
    with pytest.raises(surefoot.InstanceError, match="name a running instance"):
        surefoot.subscribe("nobody", wait=0.0)


def test_the_crc_of_a_message_shows_damage() -> None:
    message = _messages.PlanChunk()
    message.sequence = 7
    message.crc = zlib.crc32(bytes(message))
    assert live_module._crc_matches(message)
    message.sequence = 8
    assert not live_module._crc_matches(message)
