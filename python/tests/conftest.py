"""The walks that several tests look at."""

from __future__ import annotations

from pathlib import Path

import pytest

import surefoot

REPOSITORY = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def repository() -> Path:
    """The repository that the package was built from."""
    return REPOSITORY


@pytest.fixture(scope="session")
def robot() -> surefoot.Robot:
    return surefoot.Robot("hubo")


@pytest.fixture(scope="session")
def plan(robot: surefoot.Robot) -> surefoot.Plan:
    """A short walk on a flat floor."""
    return surefoot.plan(robot, "flat_walk", start=(0.5, 0, 0), goal=(1.5, 0, 0))


@pytest.fixture(scope="session")
def straight_plan(robot: surefoot.Robot) -> surefoot.Plan:
    """The same walk in straight lines."""
    parameters = {"execution": {"motion": "quasi_static"}}
    return surefoot.plan(robot, "flat_walk", (0.5, 0, 0), (1.5, 0, 0), parameters=parameters)
