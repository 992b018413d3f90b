//! Vertex candidates: root poses that meet C_N, with placements for both feet and a free upper
//! body [Grey 4.1, 4.2].

use std::ops::ControlFlow;

use glam::DVec3;
use surefoot_shared_types::Pose;

use crate::base::threads::Threads;
use crate::constraints::constraints::Constraints;
use crate::constraints::foothold::Foothold;
use crate::constraints::foothold::{FootPair, FootPlacement, is_whole};
use crate::foot_placement::foothold_query::{FootholdQuery, YAW_SPREAD_MAX};
use crate::foot_placement::{SampleLimits, Scratch, Surfaces};
use crate::possibility::mid_feet_pose::MidFeetPose;
use crate::possibility::upper_body::{UpperBody, UpperBodyFit};
use crate::preparation::build::Preparation;
use crate::primitives::transition_configuration::is_step;

/// How far below and above the ideal a placement may be, m.
const REACH_Z: [f64; 2] = [-0.5, 0.5];
/// Placements kept for each foot.
const KEPT_MAX: usize = 6;
/// Placements kept at a vertex.
pub const PLACEMENTS_MAX: usize = 2 * KEPT_MAX;
/// Steps between two vertices that are tried by inverse kinematics.
const STEPS_TRIED_MAX: usize = 8;
/// Longest distance between two tests of the upper body, m: shorter than any upper body is thick.
const FIT_STEP: f64 = 0.12;
/// Sample limits under C_S: geometric candidates only.
const LIMITS: SampleLimits = SampleLimits { geometric_max: 64, perturbed_max: 0, sampled_max: 0 };
/// Sample limits under C_N alone.
const RELAXED_LIMITS: SampleLimits =
    SampleLimits { geometric_max: 64, perturbed_max: 8, sampled_max: 24 };
/// What a metre between the feet's heights costs when a pair is chosen.
const HEIGHT_DIFFERENCE_COST: f64 = 2.0;
/// What a metre of height away from the target costs: elevation is projected toward it where there
/// is a choice [Grey 4.3].
const AWAY_FROM_TARGET_COST: f64 = 0.5;

/// Constants of stage P.
#[derive(Debug, Clone, Copy)]
pub struct StageContext<'a> {
    /// The robot and the world's geometry.
    pub constraints: &'a Constraints,
    /// Where soles can rest.
    pub surfaces: &'a Surfaces,
    /// The upper body.
    pub upper_body: &'a UpperBody,
    /// What the legs may reach, and where primitives hold.
    pub preparation: &'a Preparation<'static>,
    /// The seed of all streams.
    pub seed: u64,
    /// Ideal lateral distance between the soles, m.
    pub stance_width: f64,
    /// The threads that share the work.
    pub threads: &'a Threads,
}

/// The memory in which the placements of both feet are found.
#[derive(Debug)]
pub enum FootScratch<'a> {
    /// One foot after the other.
    Shared(&'a mut Scratch),
    /// In parallel.
    Each([&'a mut Scratch; 2]),
}

/// A root pose that meets the necessary conditions C_N.
#[derive(Debug, Clone)]
pub struct VertexCandidate {
    /// The requested pose, moved onto the ground (elevation projection).
    pub pose: MidFeetPose,
    /// The placements of both feet.
    pub placements: heapless::Vec<FootPlacement, PLACEMENTS_MAX>,
    /// The pair of them below the pose, unless its feet collide.
    pub pair: Option<FootPair>,
    /// Whether the upper body of the upright robot is free.
    pub is_upright: bool,
}

/// Request for a vertex candidate.
#[derive(Debug, Clone, Copy)]
pub struct VertexQuery {
    /// The mid-feet pose.
    pub pose: MidFeetPose,
    /// Height of the branch's target, m.
    pub target_height: f64,
    /// Whether C_N alone is enough.
    pub relaxed: bool,
    /// The name of the query in the random stream.
    pub name: u64,
}

impl StageContext<'_> {
    /// Finds placements for both feet near a pose and moves the pose over the best pair of them:
    /// vertically, and laterally where the ground is narrow. `None` where C_N fails, or C_S unless
    /// the query is relaxed.
    pub fn find_candidate(
        &self,
        query: &VertexQuery,
        scratch: &mut FootScratch<'_>,
    ) -> Option<VertexCandidate> {
        let placements = self.find_both_placements(query, scratch)?;
        let (position, pair, are_apart) = self.best_pair(query, &placements)?;
        let pose = MidFeetPose { position, yaw: query.pose.yaw };
        let [left, right] = &pair;
        let fit = self.upper_body.fit(&self.constraints.collision, &pose);
        let fits = fit >= fit_min(query.relaxed)
            && self.upper_body.are_legs_free(
                &self.constraints.collision,
                &pose,
                [&left.world_from_sole, &right.world_from_sole],
            );
        fits.then_some(VertexCandidate {
            pose,
            placements,
            pair: are_apart.then_some(pair),
            is_upright: fit == UpperBodyFit::Upright,
        })
    }

    /// Whether the upper body is free at a pose.
    pub fn is_free(&self, pose: &MidFeetPose, relaxed: bool) -> bool {
        self.upper_body.fit(&self.constraints.collision, pose) >= fit_min(relaxed)
    }

    /// The least fit of the upper body between two poses, tested every [`FIT_STEP`]; `None` if it
    /// is too small.
    pub fn fit_between(
        &self,
        from: &MidFeetPose,
        to: &MidFeetPose,
        relaxed: bool,
    ) -> Option<UpperBodyFit> {
        let pieces = libm::ceil(from.position.distance(to.position) / FIT_STEP).max(2.0);
        (1..pieces as usize).try_fold(UpperBodyFit::Upright, |least, piece| {
            let fit = self
                .upper_body
                .fit(&self.constraints.collision, &from.interpolate(to, piece as f64 / pieces));
            (fit >= fit_min(relaxed)).then_some(fit.min(least))
        })
    }

    /// Whether a step leads from one of these placements to one of those, by inverse kinematics
    /// [Grey 4.4.2]; only the shortest few of those that the robot may make are tried. True where
    /// no placements are known.
    pub fn has_step_between(&self, from: &[FootPlacement], to: &[FootPlacement]) -> bool {
        let mut steps: heapless::Vec<
            (f64, [&FootPlacement; 2]),
            { PLACEMENTS_MAX * PLACEMENTS_MAX },
        > = heapless::Vec::new();
        let possible = self.preparation.step_limits();
        for from in from {
            let is_possible = |to: &FootPlacement| {
                let [left, right] = if from.limb == 0 { [from, to] } else { [to, from] };
                possible.may_step([&left.world_from_sole, &right.world_from_sole])
            };
            for to in to.iter().filter(|to| to.limb != from.limb && is_possible(to)) {
                let length =
                    from.world_from_sole.translation.distance(to.world_from_sole.translation);
                let _full = steps.push((length, [from, to]));
            }
        }
        steps.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let is_step = |(_, step): &(f64, [&FootPlacement; 2])| {
            let [from, to] = step.map(|placement| {
                Foothold::whole(&self.constraints.robot, placement.limb, placement.world_from_sole)
            });
            is_step(self.constraints, [&from, &to])
        };
        from.is_empty() || steps.iter().take(STEPS_TRIED_MAX).any(is_step)
    }

    /// Placements of the left foot, then of the right one; `None` where one of them has none.
    fn find_both_placements(
        &self,
        query: &VertexQuery,
        scratch: &mut FootScratch<'_>,
    ) -> Option<heapless::Vec<FootPlacement, PLACEMENTS_MAX>> {
        let (left, right) = match scratch {
            FootScratch::Each([left, right]) => self.threads.join(
                || self.find_placements(query, 0, left),
                || self.find_placements(query, 1, right),
            ),
            FootScratch::Shared(scratch) => {
                let left = self.find_placements(query, 0, scratch);
                if left.is_empty() {
                    return None;
                }
                (left, self.find_placements(query, 1, scratch))
            }
        };
        let has_both = !left.is_empty() && !right.is_empty();
        has_both.then(|| left.into_iter().chain(right).collect())
    }

    fn find_placements(
        &self,
        query: &VertexQuery,
        limb: usize,
        scratch: &mut Scratch,
    ) -> heapless::Vec<FootPlacement, KEPT_MAX> {
        let mut placements = heapless::Vec::new();
        let foothold_query = FootholdQuery {
            limb,
            ideal: query.pose.world_from_ideal_sole(limb, self.stance_width),
            reach_z: REACH_Z,
            yaw_spread: YAW_SPREAD_MAX.min(self.preparation.step_limits().turn_max()),
            seed: self.seed,
            name: (query.name << 1 | limb as u64 | 1 << 60, 0),
            limits: if query.relaxed { RELAXED_LIMITS } else { LIMITS },
            kept_max: KEPT_MAX,
        };
        foothold_query.run((self.constraints, self.surfaces), scratch, &mut |placement| {
            let is_whole = is_whole(&self.constraints.robot, limb, &placement.support.polygon);
            match placements.push(FootPlacement {
                limb,
                world_from_sole: placement.world_from_sole,
                is_whole,
            }) {
                Ok(()) => ControlFlow::Continue(true),
                Err(_) => ControlFlow::Break(()),
            }
        });
        placements
    }

    /// The pair of soles of least cost (near their ideals, level, toward the target's height), the
    /// point midway between them, and whether the soles are apart. Soles that collide count only if
    /// all pairs do. Both soles of a pair must be reachable at once according to R.
    fn best_pair(
        &self,
        query: &VertexQuery,
        placements: &[FootPlacement],
    ) -> Option<(DVec3, FootPair, bool)> {
        let mut apart: Option<(f64, DVec3, FootPair)> = None;
        let mut any = apart;
        for left in placements.iter().filter(|placement| placement.limb == 0) {
            for right in placements.iter().filter(|placement| placement.limb == 1) {
                let soles = [&left.world_from_sole, &right.world_from_sole];
                let (cost, middle) = self.pair_cost(query, soles);
                let pose = MidFeetPose { position: middle, yaw: query.pose.yaw };
                if apart.is_some_and(|(least, ..)| least <= cost)
                    || !self.upper_body.may_reach(self.preparation, &pose, soles)
                {
                    continue;
                }
                if any.is_none_or(|(least, ..)| cost < least) {
                    any = Some((cost, middle, [*left, *right]));
                }
                if !self.constraints.collision.feet_hit(soles) {
                    apart = Some((cost, middle, [*left, *right]));
                }
            }
        }
        let are_apart = apart.is_some();
        apart.or(any).map(|(_, middle, pair)| (middle, pair, are_apart))
    }

    fn pair_cost(&self, query: &VertexQuery, [left, right]: [&Pose; 2]) -> (f64, DVec3) {
        let middle = left.translation.midpoint(right.translation);
        let ideals = [0, 1]
            .map(|limb| query.pose.world_from_ideal_sole(limb, self.stance_width).translation);
        let aside = left.translation.distance(ideals[0]) + right.translation.distance(ideals[1]);
        let uneven = (left.translation.z - right.translation.z).abs();
        let away = (query.target_height - middle.z).abs();
        (aside + HEIGHT_DIFFERENCE_COST * uneven + AWAY_FROM_TARGET_COST * away, middle)
    }
}

/// The least fit that a pose must have.
fn fit_min(relaxed: bool) -> UpperBodyFit {
    if relaxed { UpperBodyFit::Core } else { UpperBodyFit::Crouched }
}
