//! The timing of a smooth walk.

use surefoot_planner::timing::limits::TimingLimits;
use surefoot_planner::timing::path_point::Path;
use surefoot_planner::timing::path_timing::PathTiming;
use surefoot_planner::timing::timed_robot::TimedRobot;
use surefoot_shared_types::config::{CheckerConfig, ExecutionConfig};
use surefoot_shared_types::robot::model::RobotModel;

use crate::smooth_walk::SmoothWalk;

/// Coefficient of friction of the ground.
pub const FRICTION: f64 = 0.6;

impl SmoothWalk {
    /// Its path.
    pub fn path(&self) -> Path<'_> {
        Path { points: &self.points, spans: &self.spans }
    }

    /// A timing with memory for it.
    pub fn timing(&self, model: &RobotModel, execution: &ExecutionConfig) -> PathTiming {
        let limits = TimingLimits::new(model, execution, FRICTION, &CheckerConfig::default());
        let points_max = self.points.len() + self.spans.len();
        PathTiming::new(TimedRobot::new(model, limits), points_max)
    }

    /// Begins a timing with all spans of it.
    pub fn begin(&self, timing: &mut PathTiming) {
        timing.begin();
        for _ in &self.spans {
            timing.add_span(self.path()).unwrap();
        }
    }

    /// As [`Self::begin`], and times it as a whole; `false` where a span has no timing.
    #[allow(dead_code, reason = "each test binary uses its own part")]
    pub fn solve(&self, timing: &mut PathTiming) -> bool {
        self.begin(timing);
        timing.solve(self.path(), self.spans.len(), 0)
    }
}

/// The duration of a profile of positions and squared speeds, s.
#[allow(dead_code, reason = "each test binary uses its own part")]
pub fn profile_seconds(states: &[(f64, f64)]) -> f64 {
    let cells = states.windows(2).filter(|pair| pair[1].0 > pair[0].0);
    cells.map(|pair| 2.0 * (pair[1].0 - pair[0].0) / (pair[0].1.sqrt() + pair[1].1.sqrt())).sum()
}
