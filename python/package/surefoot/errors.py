"""The exceptions of this package. Each message names the problem and its correction."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray


class Error(Exception):
    """Any error of Surefoot."""


class InputError(Error, ValueError):
    """A robot, world, scenario or plan file cannot be used, or an output file be written."""

    def __init__(
        self,
        message: str,
        *,
        path: str | os.PathLike[str] = "",
        line: int | None = None,
        element: str | None = None,
        others: list[str] | None = None,
    ) -> None:
        super().__init__(message)
        self.path = Path(path)
        """The file."""
        self.line = line
        """The line, counted from 1, if known."""
        self.element = element
        """The element of the file, such as ``joint 'left_knee'``, if it is one."""
        self.others = others or []
        """What else is wrong, one line each."""


class ParameterError(Error, ValueError):
    """A number of the start, the goal or the parameters is out of range, or unknown."""

    def __init__(self, message: str, *, parameter: str | None = None) -> None:
        super().__init__(message)
        self.parameter = parameter
        """Its name, as in a scenario file, if known."""


class WorldError(Error, ValueError):
    """A world in memory cannot be built."""

    def __init__(self, message: str, *, shape: str | None = None) -> None:
        super().__init__(message)
        self.shape = shape
        """The shape that is out of order, if it is one."""


class RobotError(Error):
    """The planner or the checker cannot compute with the robot or the world."""


class NoPlan(Error):
    """The search ended without a plan. The same inputs always end in the same way."""

    def __init__(
        self,
        message: str,
        *,
        outcome: str = "",
        parameter: str | None = None,
        stats: dict[str, Any] | None = None,
        route: NDArray[np.float64] | None = None,
        tree: NDArray[np.float64] | None = None,
        bottleneck: Sequence[float] | None = None,
    ) -> None:
        super().__init__(message)
        self.outcome = outcome
        """``budget_exhausted``, ``arena_full``, ``impossible``, ``start_invalid`` or
        ``goal_invalid``."""
        self.parameter = parameter
        """The parameter that bounds a full arena."""
        self.stats = stats or {}
        """Statistics of the search, as :attr:`surefoot.Plan.stats`."""
        self.route = np.zeros((0, 3)) if route is None else route
        """The guide route found last, midway between the soles, m."""
        edges = np.zeros((0, 3)) if tree is None else tree
        self.tree = edges.reshape(-1, 2, 3)
        """The edges of both trees of stage P."""
        self.bottleneck = None if bottleneck is None else tuple(bottleneck)
        """Where most sequences failed, if any did, m."""


class Refused(Error):
    """The checker refuses a plan. Raised by :meth:`surefoot.Report.raise_if_refused` alone."""


class InstanceError(Error):
    """A running instance cannot be found or listened to."""


class ClusterError(Error):
    """Ray cannot be started or reached."""


class MissingPackage(Error, ImportError):
    """An optional package is not installed; the message says how to install it."""


def missing(package: str, extra: str) -> MissingPackage:
    """The error for an optional package that is not there."""
    return MissingPackage(
        f"the package '{package}' is not installed; run: pip install 'surefoot[{extra}]'"
    )
