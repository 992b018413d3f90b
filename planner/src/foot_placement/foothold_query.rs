//! Placements of one foot near an ideal pose, as both stages query them [Grey 4.2, 4.4.4].

use std::ops::ControlFlow;

use surefoot_shared_types::Pose;

use crate::collision::model::FootPhase;
use crate::constraints::constraints::Constraints;
use crate::foot_placement::posed_sole::SoleShape;
use crate::foot_placement::propose::propose;
use crate::foot_placement::request::{PlacementQuery, SampleLimits, SupportedSole};
use crate::foot_placement::scratch::Scratch;
use crate::foot_placement::surfaces::Surfaces;
use crate::foot_placement::tuning::{FOOTHOLD_REACH_XY, IDEAL_DISTANCE};

/// A query for placements of a foot.
#[derive(Debug, Clone, Copy)]
pub struct FootholdQuery {
    /// The foot: 0 left, 1 right.
    pub limb: usize,
    /// Desired pose of its sole in the world.
    pub ideal: Pose,
    /// The lowest and highest height of a placement relative to the ideal's, m.
    pub reach_z: [f64; 2],
    /// The largest turn away from the ideal heading, rad.
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
    /// Passes placements where the foot is free to `keep`, best first, until `kept_max` are kept or
    /// one of them is the ideal. `keep` returns whether it keeps the placement, or breaks if its
    /// list is full.
    pub fn run(
        &self,
        (constraints, surfaces): (&Constraints, &Surfaces),
        scratch: &mut Scratch,
        keep: &mut dyn FnMut(SupportedSole) -> ControlFlow<(), bool>,
    ) {
        let query = PlacementQuery {
            sole: SoleShape::of(&constraints.robot.soles[self.limb]),
            ideal: self.ideal,
            reach_xy: FOOTHOLD_REACH_XY,
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
        propose(surfaces, scratch, &query, &mut |sole: SupportedSole| {
            let distance = sole.world_from_sole.translation.distance(self.ideal.translation);
            let ControlFlow::Continue(is_kept) = keep(sole) else { return false };
            kept += usize::from(is_kept);
            kept < self.kept_max && distance >= IDEAL_DISTANCE
        });
    }
}
