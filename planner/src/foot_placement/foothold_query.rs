//! Placements of one foot near an ideal pose, as both stages query them
//! [Grey 4.2, 4.4.4].

use std::ops::ControlFlow;

use surefoot_shared_types::Pose;

use crate::collision::model::FootPhase;
use crate::constraints::constraints::Constraints;
use crate::foot_placement::propose::{PlacementQuery, SampleLimits, SupportedSole};
use crate::foot_placement::scratch::Scratch;
use crate::foot_placement::surfaces::Surfaces;

/// How far from the ideal a placement may be, m.
const REACH_XY: f64 = 0.35;
/// How far a placement's heading may be from the ideal at the most, rad.
pub const YAW_SPREAD_MAX: f64 = 0.8;
/// How far from an ideal that is carried exactly more placements are of no use, m.
const EXACT: f64 = 1e-3;

/// A query for placements of a foot.
#[derive(Debug, Clone, Copy)]
pub struct FootholdQuery {
    /// Which foot.
    pub limb: usize,
    /// Desired pose of its sole.
    pub ideal: Pose,
    /// How far below and above that a placement may be, m.
    pub reach_z: [f64; 2],
    /// How far its heading may be from the ideal, rad.
    pub yaw_spread: f64,
    /// The seed of the random streams.
    pub seed: u64,
    /// The query's name in the random stream: object and attempt.
    pub name: (u64, u64),
    /// How many placements to examine.
    pub limits: SampleLimits,
    /// Most placements kept.
    pub kept_max: usize,
}

impl FootholdQuery {
    /// Hands placements where the foot is free to `keep`, best first, until enough are kept or one
    /// is the ideal itself. `keep` returns whether it kept the placement, or breaks if its list is
    /// full.
    pub fn run(
        &self,
        (constraints, surfaces): (&Constraints, &Surfaces),
        scratch: &mut Scratch,
        keep: &mut dyn FnMut(SupportedSole) -> ControlFlow<(), bool>,
    ) {
        let query = PlacementQuery {
            sole_polygon: &constraints.robot.soles[self.limb].polygon,
            ideal: self.ideal,
            reach_xy: REACH_XY,
            reach_z: self.reach_z,
            yaw_spread: self.yaw_spread,
            seed: self.seed,
            object: self.name.0,
            attempt: self.name.1,
            limits: self.limits,
            is_free: &|pose| {
                constraints.collision.foot_hit(self.limb, pose, FootPhase::LiftOff).is_none()
            },
        };
        let mut kept = 0;
        surfaces.propose(scratch, &query, &mut |sole: SupportedSole| {
            let is_ideal =
                sole.world_from_sole.translation.distance(self.ideal.translation) < EXACT;
            let ControlFlow::Continue(is_kept) = keep(sole) else { return false };
            kept += usize::from(is_kept);
            kept < self.kept_max && !is_ideal
        });
    }
}
