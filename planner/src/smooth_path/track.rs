//! What a phase follows: the curve of the whole plan, or the searched motion of the phase alone.

use glam::DVec2;
use surefoot_shared_types::Pose;

use crate::robot::configuration::Configuration;
use crate::smooth_path::curve::Curve;
use crate::smooth_path::followed_motion::FollowedMotion;
use crate::smooth_path::key_table::KeySource;
use crate::smooth_path::layout::swing_of;
use crate::smooth_path::phase_grid::PhaseGrid;

/// What the configurations of a phase follow.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Track<'a> {
    /// The curve of the whole plan.
    Curve(&'a Curve),
    /// The searched motion of the phase.
    Followed(&'a FollowedMotion),
}

impl Track<'_> {
    /// Writes the height and the rotation of the root and the free joints at a place into
    /// `configuration`. Returns the centre of mass (world x and y, m) and the poses of both soles.
    pub fn pose(
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
