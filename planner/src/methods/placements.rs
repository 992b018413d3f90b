//! Footholds at given poses and near them.

use surefoot_shared_types::Pose;

use crate::collision::model::FootPhase;
use crate::constraints::foothold::Foothold;
use crate::foot_placement::{PlacementQuery, SampleLimits, SoleShape, SupportedSole, propose};
use crate::methods::workbench::Workbench;

/// Limits of a query near an ideal pose.
const NEAR_LIMITS: SampleLimits =
    SampleLimits { geometric_max: 48, perturbed_max: 0, sampled_max: 0 };

/// How far a placement may lie from its ideal.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Adaptation {
    /// Horizontally, m.
    pub distance: f64,
    /// In height, up and down, m.
    pub height: f64,
    /// In heading, rad.
    pub turn: f64,
}

/// The foothold exactly at a sole pose, if the sole has support and the foot is free there.
pub(crate) fn foothold_at(bench: &mut Workbench<'_>, limb: usize, pose: &Pose) -> Option<Foothold> {
    let constraints = &bench.context.constraints;
    let sole = SoleShape::of(&constraints.robot.soles[limb]);
    let support = bench.context.surfaces.support_of_sole(bench.scratch, sole, pose).ok()?;
    let is_free = constraints.collision.foot_hit(limb, pose, FootPhase::Stance).is_none();
    is_free.then(|| support.foothold(&constraints.robot, limb, *pose))
}

/// The best foothold near an ideal sole pose, if any.
pub(crate) fn foothold_near(
    bench: &mut Workbench<'_>,
    limb: usize,
    ideal: Pose,
    adaptation: Adaptation,
) -> Option<Foothold> {
    let constraints = &bench.context.constraints;
    let query = PlacementQuery {
        sole: SoleShape::of(&constraints.robot.soles[limb]),
        ideal,
        reach_xy: adaptation.distance,
        reach_z: [-adaptation.height, adaptation.height],
        yaw_spread: adaptation.turn,
        seed: bench.context.seed,
        object: limb as u64,
        attempt: 0,
        limits: NEAR_LIMITS,
        is_free: &|pose| constraints.collision.foot_hit(limb, pose, FootPhase::LiftOff).is_none(),
    };
    let mut found = None;
    propose(&bench.context.surfaces, bench.scratch, &query, &mut |sole: SupportedSole| {
        found = Some(sole.support.foothold(&constraints.robot, limb, sole.world_from_sole));
        false
    });
    found
}
