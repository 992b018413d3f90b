"""Surefoot plans how a legged robot walks over arbitrary geometry.

    import surefoot
    plan = surefoot.plan("hubo", "flat_walk", start=(0.5, 0, 0), goal=(2.5, 0, 0))
    for step in plan.footholds:
        print(step.foot, step.position)

Lengths are in metres, angles in radians, times in seconds, quaternions x, y, z, w. The x axis of
the world points ahead where a yaw is 0, z points up. ``docs/PYTHON.md`` of the repository shows
more.
"""

from __future__ import annotations

import importlib.metadata
from typing import TYPE_CHECKING, Any

from surefoot._native import shipped
from surefoot.checker import Checker, CheckResult, End, Loads, Margins, Report
from surefoot.errors import (
    ClusterError,
    Error,
    InputError,
    InstanceError,
    MissingPackage,
    NoPlan,
    ParameterError,
    Refused,
    RobotError,
    WorldError,
)
from surefoot.plans import FEET, Foothold, Footholds, Plan, Samples, Waypoints
from surefoot.planning import plan
from surefoot.robot import Limits, Mesh, Robot, Sole
from surefoot.scenario import Scenario
from surefoot.stance import Goal, Stance
from surefoot.world import World, WorldBuilder

__version__ = importlib.metadata.version("surefoot")

if TYPE_CHECKING:
    from surefoot.live import subscribe
    from surefoot.viewer import view

__all__ = [
    "FEET",
    "CheckResult",
    "Checker",
    "ClusterError",
    "End",
    "Error",
    "Foothold",
    "Footholds",
    "Goal",
    "InputError",
    "InstanceError",
    "Limits",
    "Loads",
    "Margins",
    "Mesh",
    "MissingPackage",
    "NoPlan",
    "ParameterError",
    "Plan",
    "Refused",
    "Report",
    "Robot",
    "RobotError",
    "Samples",
    "Scenario",
    "Sole",
    "Stance",
    "Waypoints",
    "World",
    "WorldBuilder",
    "WorldError",
    "plan",
    "shipped",
    "subscribe",
    "view",
]


def __getattr__(name: str) -> Any:
    if name == "subscribe":
        from surefoot.live import subscribe

        return subscribe
    if name == "view":
        from surefoot.viewer import view

        return view
    raise AttributeError(f"module 'surefoot' has no attribute '{name}'")
