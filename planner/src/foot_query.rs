//! The placements of one foot near where it is wished for, as both stages ask for them
//! [Grey 4.2, 4.4.4].

use std::ops::ControlFlow;

use surefoot_shared_types::Pose;

use crate::collision::FootState;
use crate::constraint::Constraints;
use crate::foot_placement::{Effort, Placement, Request, Scratch, Surfaces};

/// How far from the ideal a placement may be, m.
const REACH_XY: f64 = 0.35;
/// How far a placement's heading may be from the ideal at the most, rad.
pub const YAW_SPREAD_MAX: f64 = 0.8;
/// How far from an ideal that is carried exactly more placements are of no use, m.
const EXACT: f64 = 1e-3;

/// Placements that a foot is asked for.
#[derive(Debug, Clone, Copy)]
pub struct FootQuery {
    /// Which foot.
    pub limb: usize,
    /// Where its sole is wished for.
    pub ideal: Pose,
    /// How far below and above that a placement may be, m.
    pub reach_z: [f64; 2],
    /// How far its heading may be from the ideal, rad.
    pub yaw_spread: f64,
    /// The seed of the random streams.
    pub seed: u64,
    /// The query's name in the random stream: object and attempt.
    pub name: (u64, u64),
    /// How hard to try.
    pub effort: Effort,
    /// Placements that are enough.
    pub kept_max: usize,
}

impl FootQuery {
    /// Hands placements where the foot is free to `keep`, best first, until enough are kept or one
    /// is the ideal itself. `keep` answers whether it kept the placement, or breaks where it has no
    /// room.
    pub fn run(
        &self,
        (constraints, surfaces): (&Constraints, &Surfaces),
        scratch: &mut Scratch,
        keep: &mut dyn FnMut(Placement) -> ControlFlow<(), bool>,
    ) {
        let request = Request {
            sole_polygon: &constraints.body.sole_polygons[self.limb],
            ideal: self.ideal,
            reach_xy: REACH_XY,
            reach_z: self.reach_z,
            yaw_spread: self.yaw_spread,
            seed: self.seed,
            object: self.name.0,
            attempt: self.name.1,
            effort: self.effort,
            is_free: &|pose| {
                constraints.collision.foot_hit(self.limb, pose, FootState::Leaving).is_none()
            },
        };
        let mut kept = 0;
        surfaces.propose(scratch, &request, &mut |placement: Placement| {
            let is_ideal =
                placement.world_from_sole.translation.distance(self.ideal.translation) < EXACT;
            let ControlFlow::Continue(is_kept) = keep(placement) else { return false };
            kept += usize::from(is_kept);
            kept < self.kept_max && !is_ideal
        });
    }
}
