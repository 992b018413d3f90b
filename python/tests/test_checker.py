"""The controller's checks."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot


def test_an_accepted_plan_has_margins_and_loads(straight_plan: surefoot.Plan) -> None:
    plan = straight_plan
    checker = surefoot.Checker(plan.robot)
    report = checker.check(plan)
    assert report.valid and report.violations() == [] and report.start.violation is None
    report.raise_if_refused()
    assert report.margins["balance"] is not None and report.margins["balance"] > 0.0
    margins = checker.margins(plan)
    assert margins.time.shape == (len(margins.of["balance"]), 2)
    assert np.nanmin(margins.of["balance"]) == pytest.approx(report.margins["balance"], rel=0.2)
    loads = checker.loads(plan, 20.0)
    carried = np.nansum(loads.forces[:, :, 2], axis=1)
    assert np.allclose(carried, 9.81 * plan.robot.mass, rtol=1e-6)
    assert loads.torques.shape == (len(loads.time), len(plan.joint_names))
    assert (loads.torque_use <= 1.0).all() and loads.time[-1] == plan.duration
    stance = ~np.isnan(loads.forces[:, :, 2])
    assert (stance == plan.at(loads.time).contacts).mean() > 0.9


@pytest.mark.parametrize("rate_hz", [0.0, -1.0, float("inf"), float("nan")])
def test_loads_take_a_positive_rate(straight_plan: surefoot.Plan, rate_hz: float) -> None:
    checker = surefoot.Checker(straight_plan.robot)
    with pytest.raises(surefoot.ParameterError, match="rate_hz"):
        checker.loads(straight_plan, rate_hz)


def test_a_plan_answers_its_scenario_and_no_other() -> None:
    scenario = surefoot.Scenario("stepping_stones")
    plan = scenario.plan()
    checker = surefoot.Checker(scenario.robot)
    assert checker.check(plan, scenario).valid
    assert checker.check(plan, "stepping_stones").valid
    report = checker.check(plan, "flat_walk")
    assert not report.valid
    with pytest.raises(surefoot.Refused, match="goal"):
        report.raise_if_refused()
