//! Moves a configuration away from the limits of its legs' joints, so that a spline through it and
//! its neighbours stays within them.

use glam::{DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::rotation_from_scaled_axis;

use crate::robot::configuration::Configuration;
use crate::robot::kinematic_state::KinematicState;
use crate::robot::mechanism::Mechanism;
use crate::smooth_path::posture_solver::PostureSolver;
use crate::smooth_path::tuning::{SLACK_ROUNDS_MAX, SLACK_SHIFT, SLACK_TURN, SLACK_WANTED};

/// A change of the root's height (m) and of its rotation (rotation vector in the world, rad).
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct RootOffset {
    height: f64,
    turn: DVec3,
}

impl RootOffset {
    /// The same offset, `share` times as large.
    pub(crate) fn scaled(self, share: f64) -> Self {
        Self { height: share * self.height, turn: share * self.turn }
    }

    fn moved(self, height: f64, turn: DVec3) -> Self {
        Self { height: self.height + height, turn: self.turn + turn }
    }

    fn apply(self, configuration: &Configuration) -> Configuration {
        let mut moved = *configuration;
        let root = &mut moved.world_from_root;
        root.translation.z += self.height;
        root.rotation = (rotation_from_scaled_axis(self.turn) * root.rotation).normalize();
        moved
    }
}

/// Single changes of an offset.
const CHANGES: [(f64, DVec3); 8] = [
    (SLACK_SHIFT, DVec3::ZERO),
    (-SLACK_SHIFT, DVec3::ZERO),
    (0.0, DVec3::new(SLACK_TURN, 0.0, 0.0)),
    (0.0, DVec3::new(-SLACK_TURN, 0.0, 0.0)),
    (0.0, DVec3::new(0.0, SLACK_TURN, 0.0)),
    (0.0, DVec3::new(0.0, -SLACK_TURN, 0.0)),
    (0.0, DVec3::new(0.0, 0.0, SLACK_TURN)),
    (0.0, DVec3::new(0.0, 0.0, -SLACK_TURN)),
];

/// What a configuration keeps where its root moves: the centre of mass (world x and y, m) and the
/// poses of the soles.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Kept<'a> {
    pub com: DVec2,
    pub world_from_soles: &'a [Pose; 2],
}

impl Kept<'_> {
    /// The configuration with the root moved by an offset; nothing if a leg does not reach.
    pub(crate) fn with(
        &self,
        robot: &Mechanism,
        configuration: &Configuration,
        offset: RootOffset,
        state: &mut KinematicState,
    ) -> Option<Configuration> {
        let mut moved = offset.apply(configuration);
        let mut solver = PostureSolver::default();
        let found = solver.solve(robot, self.world_from_soles, self.com, &mut moved, state);
        found.is_ok().then_some(moved)
    }

    /// An offset by which the legs' joints are [`SLACK_WANTED`] within their limits, or as far as
    /// steps from `offset` on lead.
    pub(crate) fn offset_inside(
        &self,
        robot: &Mechanism,
        configuration: &Configuration,
        mut offset: RootOffset,
        state: &mut KinematicState,
    ) -> RootOffset {
        let mut slack = |offset: RootOffset| {
            let moved = self.with(robot, configuration, offset, state);
            moved.map_or(f64::NEG_INFINITY, |moved| slack_of(robot, &moved))
        };
        let mut best = slack(offset);
        for _ in 0..SLACK_ROUNDS_MAX {
            if best >= SLACK_WANTED {
                break;
            }
            let before = best;
            for (height, turn) in CHANGES {
                let changed = offset.moved(height, turn);
                let found = slack(changed);
                if found > best {
                    (offset, best) = (changed, found);
                }
            }
            if best <= before {
                break;
            }
        }
        offset
    }
}

/// The least distance of a joint of the legs from its limits, rad or m.
fn slack_of(robot: &Mechanism, configuration: &Configuration) -> f64 {
    let joints = robot.legs.iter().flat_map(|leg| leg.joints());
    let distances = joints.map(|joint| {
        let q = configuration.q[joint.index];
        (q - joint.lower).min(joint.upper - q)
    });
    distances.fold(f64::INFINITY, f64::min)
}
