"""Errors are typed exceptions that say what to do."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import surefoot

FLOOR = (0.5, 0, 0)


def test_a_file_is_named_with_its_line(tmp_path: Path) -> None:
    world = tmp_path / "world.toml"
    world.write_text('mu = 0.6\n\n[[shapes]]\nname = "a"\nsphere = { radius = -1 }\n')
    with pytest.raises(surefoot.InputError) as found:
        surefoot.World(world)
    assert (found.value.path, found.value.line) == (world, 3)
    assert found.value.element == "shape 'a'" and "radius" in str(found.value)
    with pytest.raises(surefoot.InputError, match="did you mean 'ibeam_hallway'"):
        surefoot.Scenario("ibeam_halway")
    with pytest.raises(surefoot.InputError, match="robot; did you mean 'hubo'"):
        surefoot.Robot("hubbo")
    with pytest.raises(surefoot.InputError, match=r"nowhere\.json"):
        surefoot.Plan.load(tmp_path / "nowhere.json")


def test_a_folder_that_is_not_there_is_named(plan: surefoot.Plan, tmp_path: Path) -> None:
    with pytest.raises(surefoot.InputError, match="cannot be written"):
        plan.save(tmp_path / "nowhere" / "walk.json")


def test_no_plan_says_which_end(robot: surefoot.Robot) -> None:
    far = surefoot.Scenario("ibeam_hallway")
    with pytest.raises(surefoot.NoPlan, match="raise work_max") as found:
        surefoot.plan(robot, far.world, far.start, far.goal, work_max=5)
    assert found.value.outcome == "budget_exhausted" and found.value.stats["work"] >= 5
    assert found.value.tree.shape[1:] == (2, 3)
    with pytest.raises(surefoot.NoPlan) as found:
        surefoot.plan(robot, "flat_walk", (0.5, 0, 5), goal=(3, 0, 0))
    assert found.value.outcome == "start_invalid"
    with pytest.raises(surefoot.NoPlan) as found:
        surefoot.plan(robot, "flat_walk", FLOOR, goal=(3, 0, 5))
    assert found.value.outcome == "goal_invalid" and "goal" in str(found.value)
    copy = pickle.loads(pickle.dumps(found.value))
    assert (str(copy), copy.outcome) == (str(found.value), "goal_invalid")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"start": (1, 2)}, "start: give x, y, z"),
        ({"goal": "ahead"}, "goal: give x, y, z"),
        ({"goal": (np.nan, 0, 0)}, "goal"),
        ({"seed": -1}, "seed is -1"),
        ({"threads": 0}, "threads is 0"),
        ({"work_max": 0}, "work_max"),
        ({"parameters": {"planner": {"com_margin": -1.0}}}, "planner.com_margin"),
        ({"parameters": {"planner": {"work_maxx": 1}}}, "no parameter 'work_maxx'; did you mean"),
        ({"parameters": {"planer": {}}}, r"no table \[planer\]; did you mean 'planner'"),
        ({"parameters": {"checker": {"zzz": 1}}}, "no parameter 'zzz'; there are "),
        ({"parameters": {"planner": {"work_max": object()}}}, "numbers and names"),
    ],
)
def test_a_wrong_number_is_named(
    robot: surefoot.Robot, changes: dict[str, object], words: str
) -> None:
    arguments: dict[str, object] = {"start": FLOOR, "goal": (1.5, 0, 0), **changes}
    with pytest.raises(surefoot.ParameterError, match=words):
        surefoot.plan(robot, "flat_walk", **arguments)  # type: ignore[arg-type]


def test_every_error_is_one_of_surefoot() -> None:
    for name in surefoot.__all__:
        kind = getattr(surefoot, name)
        if isinstance(kind, type) and issubclass(kind, BaseException):
            assert issubclass(kind, surefoot.Error)
    with pytest.raises(surefoot.Error):
        surefoot.World("nowhere")


def test_an_interrupt_ends_a_search() -> None:
    def interrupt() -> None:
        time.sleep(1.0)
        os.kill(os.getpid(), signal.SIGINT)

    robot = surefoot.Robot("hubo")
    surefoot.plan(robot, "flat_walk", FLOOR, goal=(0.8, 0, 0))
    old = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        threading.Thread(target=interrupt).start()
        with pytest.raises(KeyboardInterrupt):
            while True:
                scenario = surefoot.Scenario("no_way_wall")
                with pytest.raises(surefoot.NoPlan):
                    scenario.plan(robot=robot)
    finally:
        signal.signal(signal.SIGINT, old)


def test_it_works_from_any_folder_without_a_home(tmp_path: Path) -> None:
    program = (
        "import surefoot, warnings; warnings.simplefilter('error');"
        "plan = surefoot.plan('hubo', 'flat_walk', (0.5, 0, 0), (0.8, 0, 0));"
        "print(plan.digest)"
    )
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path / "cache")}
    command = [sys.executable, "-c", program]
    first = subprocess.run(
        command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True
    )
    assert len(first.stdout.strip()) == 64
    assert list((tmp_path / "cache" / "surefoot").glob("*.prepared"))
