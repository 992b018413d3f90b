"""Plans as arrays, samples and files."""

from __future__ import annotations

import threading
import time
from pathlib import Path

import numpy as np
import pytest

import surefoot


def golden(repository: Path, scenario: str) -> str:
    """The digest of a shipped scenario's plan, which the Rust tests hold."""
    lines = (repository / "tests/data/golden_digests.txt").read_text().splitlines()
    return next(line.split()[2] for line in lines if line.split()[:1] == [scenario])


@pytest.mark.parametrize("name", ["ibeam_hallway", "stepping_stones"])
def test_the_plan_of_a_scenario_is_that_of_the_program(repository: Path, name: str) -> None:
    for threads in (1, 2):
        assert surefoot.Scenario(name).plan(threads=threads).digest == golden(repository, name)


def test_footholds_lead_from_the_start_to_the_goal(plan: surefoot.Plan) -> None:
    steps = plan.footholds
    assert [step.foot for step in steps[:2]] == ["left", "right"] and steps[0].time == 0.0
    assert np.allclose(steps.position[:2].mean(axis=0), (0.5, 0, 0), atol=0.03)
    assert np.allclose(steps.position[-2:].mean(axis=0), (1.5, 0, 0), atol=0.1)
    assert np.allclose(np.linalg.norm(steps.rotation, axis=1), 1.0)
    assert (np.diff(steps.time) >= 0.0).all() and steps.position.shape == (len(steps), 3)
    assert steps[-1].foot == list(steps)[-1].foot and steps[-1].polygon.shape[1] == 2
    with pytest.raises(IndexError):
        steps[len(steps)]


def test_waypoints_hold_the_whole_body(plan: surefoot.Plan) -> None:
    points = plan.waypoints
    assert points.joints.shape == (len(points), len(plan.joint_names)) == (len(points), 27)
    assert points.root_position.shape == (len(points), 3) and points.joints.dtype == np.float64
    assert (np.diff(points.time) > 0.0).all() and points.time[-1] == plan.duration
    limits = plan.robot.limits
    assert ((points.joints >= limits.lower) & (points.joints <= limits.upper)).all()
    assert points.contacts.any(axis=1).all() and not points.contacts.all()
    assert plan.chunk_times[0, 0] == 0.0 and plan.chunk_times[-1, 1] == plan.duration
    assert plan.route.shape[1] == 3 and len(plan.route) >= 2
    assert plan.stats["work"] > 0


def test_samples_are_the_motion_at_a_rate(
    plan: surefoot.Plan, straight_plan: surefoot.Plan
) -> None:
    samples = plan.sample(50.0)
    assert samples.time[1] == 0.02 and samples.time[-1] == plan.duration
    at_waypoints = plan.at(plan.waypoints.time)
    assert np.allclose(at_waypoints.joints, plan.waypoints.joints, atol=1e-12)
    assert (at_waypoints.contacts == plan.waypoints.contacts).all()
    points = straight_plan.waypoints
    middle = straight_plan.at(0.5 * (points.time[3] + points.time[4]))
    assert np.allclose(middle.joints, points.joints[3:5].mean(axis=0), atol=1e-9)
    assert np.allclose(np.linalg.norm(samples.root_rotation, axis=1), 1.0)
    assert len(samples[::5]) == -(-len(samples) // 5)
    for rate in (0.0, -1.0, float("nan")):
        with pytest.raises(surefoot.ParameterError):
            plan.sample(rate)


def test_the_soles_stand_where_the_footholds_are(plan: surefoot.Plan) -> None:
    points = plan.waypoints
    robot = plan.robot
    poses = robot.link_poses(points.root_position, points.root_rotation, points.joints)
    assert poses.shape == (len(points), len(robot.link_names), 7)
    left = poses[:, robot.link_names.index(robot.soles[0].link), :3]
    first_lift = int(np.argmin(points.contacts[:, 0]))
    assert np.ptp(left[:first_lift], axis=0).max() < 2e-3, "a stance foot stays"
    assert np.ptp(left, axis=0)[0] > 0.5, "it comes along"


def test_a_saved_plan_is_loaded(plan: surefoot.Plan, tmp_path: Path) -> None:
    path = tmp_path / "walk.json"
    plan.save(path)
    loaded = surefoot.Plan.load(path)
    assert (loaded.waypoints.joints == plan.waypoints.joints).all()
    assert (loaded.footholds.position == plan.footholds.position).all()
    assert loaded.joint_names == plan.joint_names and loaded.digest is None
    assert surefoot.Checker(loaded.robot).check(loaded).valid


def test_other_threads_run_while_a_walk_is_planned(robot: surefoot.Robot) -> None:
    counted = 0
    done = threading.Event()

    def count() -> None:
        nonlocal counted
        while not done.is_set():
            counted += 1
            time.sleep(0.0005)

    counter = threading.Thread(target=count)
    counter.start()
    before = counted
    surefoot.Scenario("stepping_stones").plan(robot=robot)
    during = counted - before
    done.set()
    counter.join()
    assert during > 0


def test_one_robot_serves_several_threads(robot: surefoot.Robot) -> None:
    digests: list[str | None] = []

    def walk() -> None:
        plan = surefoot.plan(robot, "flat_walk", start=(0.5, 0, 0), goal=(1.5, 0, 0), threads=1)
        digests.append(plan.digest)

    threads = [threading.Thread(target=walk) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(digests) == 3 and len(set(digests)) == 1
