//! What a phase follows: the curve of the whole plan, or the searched motion of the phase alone.

use glam::DVec2;
use surefoot_shared_types::Pose;

use crate::constraints::rejection::Rejection;
use crate::robot::configuration::Configuration;
use crate::robot::kinematic_state::KinematicState;
use crate::smooth_path::curve::Curve;
use crate::smooth_path::followed_motion::FollowedMotion;
use crate::smooth_path::followed_trial::FollowedKind;
use crate::smooth_path::key_table::KeySource;
use crate::smooth_path::layout::swing_of;
use crate::smooth_path::phase_grid::PhaseGrid;
use crate::smooth_path::posture_solver::PostureSolver;

/// What the configurations of a phase follow.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Track<'a> {
    /// The curve of the whole plan.
    Curve(&'a Curve),
    /// The searched motion of the phase.
    Followed(&'a FollowedMotion),
}

impl Track<'_> {
    /// Writes the configuration at a place, which is near `configuration`, and its kinematic state.
    ///
    /// # Errors
    /// A leg does not reach its sole, or the centre of mass does not converge.
    pub fn configure(
        &self,
        source: &KeySource<'_>,
        (grid, place): (&PhaseGrid, f64),
        solver: &mut PostureSolver,
        configuration: &mut Configuration,
        state: &mut KinematicState,
    ) -> Result<(), Rejection> {
        let robot = &source.constraints.robot;
        if let Self::Followed(motion) = self
            && motion.kind() == FollowedKind::Joints
        {
            *configuration = motion.configuration(place);
            state.update(robot, configuration);
            return Ok(());
        }
        let (com, soles) = self.pose(source, grid, place, configuration);
        solver.solve(robot, &soles, com, configuration, state)
    }

    /// Writes the height and the rotation of the root and the free joints at a place into
    /// `configuration`. Returns the centre of mass (world x and y, m) and the poses of both soles.
    fn pose(
        &self,
        source: &KeySource<'_>,
        grid: &PhaseGrid,
        place: f64,
        configuration: &mut Configuration,
    ) -> (DVec2, [Pose; 2]) {
        match self {
            Self::Curve(curve) => {
                let around = curve.around(place, grid.middle());
                around.pose(source.constraints, source.plan.roadmap, configuration);
                (around.com(), curve.soles(&source.plan, source.layout, place))
            }
            Self::Followed(motion) => {
                let target = motion.pose(&source.constraints.robot, place, configuration);
                (target.com, target.world_from_soles)
            }
        }
    }

    /// Horizontal distance (m) of the swing sole of a phase from the nearer of its footholds.
    pub fn distance_aside(&self, source: &KeySource<'_>, grid: &PhaseGrid, place: f64) -> f64 {
        let Some(swing) = swing_of(grid.phase) else { return 0.0 };
        match self {
            Self::Curve(curve) => {
                let fraction = curve.swing_fraction(swing, place);
                curve.swing(&source.plan, source.layout, swing).distance_aside(fraction)
            }
            Self::Followed(motion) => motion.distance_aside(place),
        }
    }
}
