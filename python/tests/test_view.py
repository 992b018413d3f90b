"""Recordings for Rerun, without a viewer. Skipped without rerun-sdk."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import surefoot
import surefoot.view as view_module
from surefoot.viewer import view

pytest.importorskip("rerun")
RERUN = [sys.executable, "-m", "rerun"]


def entities(recording: Path) -> str:
    """All that Rerun's own reader finds in a sound recording."""
    subprocess.run([*RERUN, "rrd", "verify", recording], check=True, capture_output=True)
    command = [*RERUN, "rrd", "print", recording]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def test_a_plan_is_recorded_whole(plan: surefoot.Plan, tmp_path: Path) -> None:
    path = tmp_path / "walk.rrd"
    recording = view(plan, save=path, rate_hz=5.0)
    assert recording.path == path and recording.seconds == plan.duration
    found = entities(path)
    for entity in (
        "/world/",
        "/robot/",
        "/guide_route",
        "/footholds",
        "/support_polygon",
        "/centre_of_mass",
        "/centre_of_mass_projection",
        "/contact_force/left",
        "/contact_force/right",
        "/margins/length/balance",
        "/margins/share/torque",
        "/use/torque",
        "/torque/",
    ):
        assert entity in found, f"{entity} is not in the recording"


def test_the_command_records_a_saved_plan(plan: surefoot.Plan, tmp_path: Path) -> None:
    plan.save(tmp_path / "walk.json")
    command = [sys.executable, "-m", "surefoot.view", "walk.json", "--save", "walk.rrd"]
    shown = subprocess.run(
        [*command, "--rate", "2"], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert shown.stdout.startswith("wrote walk.rrd:") and (tmp_path / "walk.rrd").stat().st_size
    command[3] = "nowhere.json"
    refused = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert refused.returncode == 2 and refused.stderr.startswith("error: nowhere.json")


def test_a_search_without_a_plan_is_recorded(robot: surefoot.Robot, tmp_path: Path) -> None:
    far = surefoot.Scenario("ibeam_hallway")
    with pytest.raises(surefoot.NoPlan) as found:
        surefoot.plan(robot, far.world, far.start, far.goal, work_max=300)
    recording = tmp_path / "search.rrd"
    view_module(found.value, save=recording, world=far.world)  # type: ignore[operator]
    assert "/outcome" in entities(recording) and "/world/" in entities(recording)


def test_a_viewer_without_a_window_shows_the_walk(plan: surefoot.Plan, tmp_path: Path) -> None:
    client = pytest.importorskip("rerun.experimental").ViewerClient
    if not adapters():
        pytest.skip("no Vulkan driver; mesa-vulkan-drivers has one")
    path = tmp_path / "walk.rrd"
    view(plan, save=path, rate_hz=5.0)
    program = str(Path(sys.executable).with_name("rerun"))
    with client.spawn(headless=True, port=9951, executable_path=program) as viewer:
        viewer.open(str(path))
        viewer.set_time("plan_time", duration=plan.duration / 2, play_state="paused")
        (recording,) = viewer.get_state().recordings
        (line,) = [one for one in recording.timelines if one.name == "plan_time"]
        assert (line.start, line.end) == (0, round(1e9 * plan.duration))
        assert {one.name for one in viewer.get_state().views} >= {"walk", "torques, N m"}
        picture = viewer.take_screenshot()
    assert picture.startswith(b"\x89PNG") and len(picture) > 50_000


def adapters() -> list[Path]:
    """The Vulkan drivers of this machine."""
    folders = [Path("/usr/share/vulkan/icd.d"), Path("/etc/vulkan/icd.d")]
    return [file for folder in folders for file in folder.glob("*.json")]
