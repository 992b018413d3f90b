"""Scenarios: robot, world, start, goal, seed and parameters of one planning problem."""

from __future__ import annotations

import json
import os
from functools import cached_property
from pathlib import Path
from typing import Any

from surefoot import _native
from surefoot.parameters import ParameterTables, parameters_of
from surefoot.plans import Plan
from surefoot.planning import plan
from surefoot.robot import Robot
from surefoot.stance import Goal, Stance
from surefoot.world import World


class Scenario:
    """A scenario file, or one that the package carries (``surefoot.shipped("scenario")``)."""

    def __init__(self, scenario: str | os.PathLike[str]) -> None:
        found = _native.load_scenario(_native.resolve("scenario", scenario))
        self.name: str = found["name"]
        """Its name: the stem of the file's name."""
        self.robot_path = Path(found["robot"])
        """The robot file."""
        self.world_path = Path(found["world"])
        """The world file."""
        self.start = Stance(*found["start"])
        """Where the walk begins."""
        self.goal = Goal(*found["goal"], *found["goal_tolerance"])
        """Where it ends."""
        self.seed: int = found["seed"]
        """The seed of all random streams."""
        self._parameters: _native.Parameters = found["parameters"]

    def __repr__(self) -> str:
        return f"<Scenario {self.name}>"

    @property
    def parameters(self) -> dict[str, dict[str, Any]]:
        """All parameters, in tables ``planner``, ``checker`` and ``execution``."""
        tables: dict[str, dict[str, Any]] = json.loads(self._parameters.to_json())
        return tables

    @cached_property
    def robot(self) -> Robot:
        """The robot."""
        return Robot(self.robot_path)

    @cached_property
    def world(self) -> World:
        """The world."""
        return World(self.world_path)

    def plan(
        self,
        *,
        robot: Robot | str | os.PathLike[str] | None = None,
        seed: int | None = None,
        threads: int | None = None,
        parameters: ParameterTables | None = None,
    ) -> Plan:
        """Finds the walk, as :func:`surefoot.plan`. What is given replaces the scenario's."""
        return plan(
            self.robot if robot is None else robot,
            self.world,
            self.start,
            self.goal,
            seed=self.seed if seed is None else seed,
            threads=threads,
            parameters=parameters_of(parameters, self._parameters),
        )
