//! A monitor's statistics of the simulated robot's states.

use serde::Serialize;
use surefoot_shared_types::message::SimulationState;

/// Statistics of the ticks of a period.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct StateSummary {
    /// Ticks received per second.
    ticks_per_second: f64,
    /// Ticks missed so far.
    missed: u64,
    /// The plan's time at the last tick, s.
    plan_seconds: f64,
    /// The smallest distance that the centre of mass could still move, m.
    balance_margin: f64,
    /// The largest share of the friction in use.
    friction_use: f64,
    /// The largest share of an effort limit in use.
    torque_use: f64,
}

/// Statistics of the states received so far.
#[derive(Debug, Default)]
pub(crate) struct StateStats {
    last: Option<SimulationState>,
    missed: u64,
    ticks: u64,
    worst: Option<[f64; 3]>,
}

impl StateStats {
    /// Takes in a state.
    pub(crate) fn record(&mut self, state: &SimulationState) {
        let before = self.last.filter(|before| before.controller_id == state.controller_id);
        self.missed += before.map_or(0, |before| state.tick.saturating_sub(before.tick + 1));
        self.last = Some(*state);
        self.ticks += 1;
        let [margin, friction, torque] = self.worst.unwrap_or([f64::INFINITY, 0.0, 0.0]);
        self.worst = Some([
            margin.min(state.balance_margin),
            friction.max(state.friction_use),
            torque.max(state.torque_use),
        ]);
    }

    /// Statistics of the last `period` (s), if a state was received; starts a new one.
    pub(crate) fn summary(&mut self, period: f64) -> Option<StateSummary> {
        let [balance_margin, friction_use, torque_use] = self.worst.take()?;
        let ticks = std::mem::take(&mut self.ticks);
        Some(StateSummary {
            ticks_per_second: if period > 0.0 { ticks as f64 / period } else { 0.0 },
            missed: self.missed,
            plan_seconds: self.last?.waypoint.time,
            balance_margin,
            friction_use,
            torque_use,
        })
    }
}

impl StateSummary {
    /// Part of a line of text.
    pub(crate) fn describe(&self) -> String {
        let Self { ticks_per_second, missed, plan_seconds, .. } = self;
        let margin = 1000.0 * self.balance_margin;
        let (friction, torque) = (100.0 * self.friction_use, 100.0 * self.torque_use);
        format!(
            "robot at {plan_seconds:.2} s, {ticks_per_second:.0} ticks/s ({missed} missed), centre of mass {margin:.1} mm inside, \
             friction {friction:.0} %, torque {torque:.0} %"
        )
    }
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;

    #[test]
    fn the_worst_of_a_period_is_reported_and_missed_ticks_are_counted() {
        let mut stats = StateStats::default();
        assert_eq!(stats.summary(1.0), None);
        let state = |tick, balance_margin, torque_use| SimulationState {
            controller_id: 7,
            tick,
            balance_margin,
            torque_use,
            ..SimulationState::zeroed()
        };
        for state in [state(1, 0.02, 0.3), state(2, 0.01, 0.2), state(6, 0.03, 0.5)] {
            stats.record(&state);
        }
        let summary = stats.summary(1.5).unwrap();
        assert_eq!(
            (summary.ticks_per_second, summary.missed, summary.balance_margin, summary.torque_use),
            (2.0, 3, 0.01, 0.5)
        );
        assert_eq!(stats.summary(1.0), None);
        stats.record(&SimulationState { controller_id: 8, ..state(20, 0.1, 0.1) });
        assert_eq!(stats.summary(1.0).unwrap().missed, 3, "another controller counts anew");
    }
}
