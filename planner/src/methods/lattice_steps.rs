//! The fixed set of steps of a search over footsteps (Kuffner 2001, Chestnutt 2005), and the tests
//! of one step.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{rotation_about, yaw_of};

use crate::constraints::foothold::Foothold;
use crate::methods::placements::Adaptation;
use crate::methods::workbench::Workbench;
use crate::preparation::{sufficient, sufficient_shift};
use crate::primitives::level_sole::side_of;
use crate::primitives::transition_configuration::is_valid_step;

/// Longest level step of the reference robot, for which the steps are given, m.
const REFERENCE_STEP: f64 = 0.75;
/// The steps: where the other foot lands relative to the one that stands: ahead (m), aside (m), and
/// outward turn (rad).
const STEPS: [[f64; 3]; 18] = [
    [0.3, 0.2, 0.0],
    [0.2, 0.2, 0.0],
    [0.1, 0.2, 0.0],
    [0.0, 0.2, 0.0],
    [-0.1, 0.2, 0.0],
    [-0.2, 0.2, 0.0],
    [0.4, 0.2, 0.0],
    [0.5, 0.2, 0.0],
    [0.15, 0.3, 0.0],
    [0.0, 0.35, 0.0],
    [-0.15, 0.3, 0.0],
    [0.1, 0.22, 0.35],
    [0.0, 0.22, 0.35],
    [-0.1, 0.22, 0.35],
    [0.1, 0.22, -0.35],
    [0.0, 0.22, -0.35],
    [0.2, 0.22, 0.2],
    [0.2, 0.22, -0.2],
];
/// Number of steps.
pub(crate) const STEPS_LEN: usize = STEPS.len();

/// Largest rise or fall of a step, m.
const HEIGHT: f64 = 0.35;
/// A placement that must be where the step leads: rounding only.
const EXACT: Adaptation = Adaptation { distance: 1e-3, height: HEIGHT, turn: 0.01 };
/// A placement that adapts to the ground.
const ADAPTIVE: Adaptation = Adaptation { distance: 0.1, height: HEIGHT, turn: 0.3 };

/// What a step must satisfy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum StepTest {
    /// A prepared posture is valid on both transitions, where the step leads exactly.
    Postures,
    /// A prepared posture is valid on both transitions, where the placement adapts to the ground.
    AdaptedPostures,
    /// C_S holds for both half swings and the shift: primitives alone.
    ExpandedGeometry,
}

impl StepTest {
    /// How far placements may lie from where a step leads.
    pub fn adaptation(self) -> Adaptation {
        if self == Self::AdaptedPostures { ADAPTIVE } else { EXACT }
    }

    /// Whether the robot may stand on one foothold and step onto the other one.
    pub fn holds(self, bench: &Workbench<'_>, [stance, landed]: [&Foothold; 2]) -> bool {
        if !bench.may_step([stance, landed]) {
            return false;
        }
        if self == Self::ExpandedGeometry {
            return is_primitive(bench, [stance, landed]);
        }
        is_valid_step(&bench.context.constraints, [stance, landed])
    }
}

/// Whether C_S holds for all primitives between two footholds.
fn is_primitive(bench: &Workbench<'_>, footholds: [&Foothold; 2]) -> bool {
    let (constraints, preparation) = (&bench.context.constraints, &bench.context.preparation);
    let (robot, collision) = (&constraints.robot, &constraints.collision);
    let [first, second] = footholds.map(|foothold| foothold.placement(robot));
    let (left, right) = if first.limb == 0 { (&first, &second) } else { (&second, &first) };
    sufficient(preparation, robot, collision, &first, &second)
        && sufficient(preparation, robot, collision, &second, &first)
        && sufficient_shift(preparation, robot, collision, left, right)
}

/// Where a step of the set leads the other foot from a foothold, in its plane.
pub(crate) fn step_from(stance: &Foothold, index: usize, step_max: f64) -> Pose {
    let [ahead, aside, turn] = STEPS[index];
    let (scale, side) = (step_max / REFERENCE_STEP, side_of(1 - stance.limb));
    let heading = rotation_about(DVec3::Z, yaw_of(stance.world_from_sole.rotation));
    let offset = heading * DVec3::new(scale * ahead, side * scale * aside, 0.0);
    Pose::from_parts(
        stance.world_from_sole.translation + offset,
        heading * rotation_about(DVec3::Z, side * turn),
    )
}
