"""Batches on Ray with two workers. Skipped without ray and pyarrow."""

from __future__ import annotations

import os
import signal
import threading
import time
from pathlib import Path

import pytest

import surefoot
from surefoot import batch
from surefoot.statistics import write_page
from surefoot.walks import Options, Task, walk

pytest.importorskip("ray")
parquet = pytest.importorskip("pyarrow.parquet")
SCENARIOS, SEEDS = ["ibeam_hallway", "stepping_stones"], range(1, 7)


def rows(folder: Path) -> list[dict[str, object]]:
    """The results of a batch."""
    found: list[dict[str, object]] = parquet.read_table(folder / "walks.parquet").to_pylist()
    return found


def kill_a_worker(stop: threading.Event, killed: list[int]) -> None:
    """Kills one process that runs a walk, as the system does where memory is short."""
    while not stop.is_set() and not killed:
        for entry in Path("/proc").glob("[0-9]*/cmdline"):
            try:
                if entry.read_bytes().startswith(b"ray::walk"):
                    os.kill(int(entry.parent.name), signal.SIGKILL)
                    killed.append(int(entry.parent.name))
                    break
            except OSError:
                continue
        time.sleep(0.001)


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same batch with one worker, which nobody kills."""
    folder = tmp_path_factory.mktemp("alone")
    batch.run(SCENARIOS, SEEDS, out=folder, workers=1, progress=False)
    return folder


def test_a_killed_worker_costs_only_its_walks(alone: Path, tmp_path: Path) -> None:
    stop, killed = threading.Event(), list[int]()
    killer = threading.Thread(target=kill_a_worker, args=(stop, killed))
    killer.start()
    summary = batch.run(SCENARIOS, SEEDS, out=tmp_path, workers=2, progress=False)
    stop.set()
    killer.join()
    assert killed, "no worker was killed"
    assert summary.walks == len(SCENARIOS) * len(SEEDS) and summary.lost == []
    assert summary.outcomes == {"accepted": summary.walks}
    times = parquet.read_table(tmp_path / "times.parquet").to_pylist()
    assert max(row["attempts"] for row in times) > 1, "the walk was given out again"
    assert rows(tmp_path) == rows(alone), "one worker or two, killed or not"
    walks = "walks.parquet"
    assert (tmp_path / walks).read_bytes() == (alone / walks).read_bytes()


def test_results_are_those_of_walks_one_by_one(alone: Path) -> None:
    found = rows(alone)
    assert len({(row["scenario"], row["seed"]) for row in found}) == len(found)
    for row in (found[0], found[-1]):
        plan = surefoot.Scenario(str(row["scenario"])).plan(seed=int(str(row["seed"])))
        assert row["digest"] == plan.digest and row["steps"] == len(plan.footholds) - 2


def test_a_batch_goes_on_where_it_was(alone: Path, tmp_path: Path) -> None:
    first = batch.run(SCENARIOS[1:], SEEDS, out=tmp_path, workers=2, progress=False)
    assert (first.walks, first.resumed) == (len(SEEDS), 0)
    summary = batch.run(SCENARIOS, SEEDS, out=tmp_path, workers=2, progress=False)
    assert (summary.walks, summary.resumed) == (2 * len(SEEDS), len(SEEDS))
    assert rows(tmp_path) == rows(alone)
    with pytest.raises(surefoot.ParameterError, match="choose another"):
        batch.run(SCENARIOS, SEEDS, out=tmp_path, work_max=7, progress=False)


def test_a_walk_without_a_plan_is_a_row(tmp_path: Path) -> None:
    row, times = walk(Task("no_way_wall", "hubo", 1), Options(work_max=2000))
    assert row["outcome"] == "budget_exhausted" and row["work"] >= 2000 and times["seconds"] > 0
    row, _ = walk(Task("nowhere", "", 1), Options())
    assert row["outcome"] == "error" and "InputError" in row["message"]
    row, _ = walk(Task("flat_walk", "", 1), Options(plans=str(tmp_path)))
    assert row["outcome"] == "accepted"
    assert surefoot.Plan.load(tmp_path / "flat_walk-hubo-1.json").duration == row["duration"]


def test_plans_of_scenario_files_of_one_name_are_kept_apart(
    repository: Path, tmp_path: Path
) -> None:
    configs = repository / "configs"
    for goal in ("1.0", "1.5"):
        folder = tmp_path / goal
        folder.mkdir()
        (folder / "walk.toml").write_text(
            f'robot = "{configs}/robots/hubo/robot.toml"\n'
            f'world = "{configs}/worlds/flat_walk.toml"\n'
            f"[start]\nxyz = [0.5, 0.0, 0.0]\n[goal]\nxyz = [{goal}, 0.0, 0.0]\n"
        )
        walk(Task(str(folder / "walk.toml"), "", 1), Options(plans=str(tmp_path)))
    assert len(list(tmp_path.glob("walk-hubo-1-*.json"))) == 2


def test_the_page_states_what_the_tables_hold(alone: Path) -> None:
    text = write_page(alone).read_text()
    count = len(SCENARIOS) * len(SEEDS)
    assert f"{count} walks, {count} planned and accepted" in text
    assert all(scenario in text for scenario in SCENARIOS) and "<svg" in text
    with pytest.raises(surefoot.InputError):
        write_page(alone / "nowhere")
