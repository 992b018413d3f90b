//! Vertex candidates: root poses that meet C_N, with placements for both feet and a free upper
//! body [Grey 4.1, 4.2].

use std::ops::ControlFlow;

use glam::DVec3;
use surefoot_shared_types::Pose;

use crate::base::threads::Threads;
use crate::constraints::constraints::Constraints;
use crate::constraints::foothold::{FootPair, FootPlacement, Foothold, is_whole};
use crate::foot_placement::YAW_SPREAD_MAX;
use crate::foot_placement::foothold_query::FootholdQuery;
use crate::foot_placement::{SampleLimits, Scratch, Surfaces};
use crate::possibility::mid_feet_pose::MidFeetPose;
use crate::possibility::root_poses::RootPoses;
use crate::possibility::root_vertex::{PostureId, RootPosture, UPRIGHT};
use crate::possibility::route_condition::RouteCondition;
use crate::possibility::tuning::{
    AWAY_FROM_TARGET_COST, FIT_STEP, FOOT_PLACEMENTS_MAX, HEIGHT_DIFFERENCE_COST,
    PLACEMENT_REACH_Z, STEPS_TRIED_MAX, VERTEX_PLACEMENTS_MAX,
};
use crate::possibility::upper_body::{UpperBody, UpperBodyFit};
use crate::preparation::Preparation;
use crate::primitives::transition_configuration::is_step;

/// Limits of the placement search under the strictest condition: geometric candidates only.
const LIMITS: SampleLimits = SampleLimits { geometric_max: 64, perturbed_max: 0, sampled_max: 0 };
/// Limits of the placement search under the others.
const RELAXED_LIMITS: SampleLimits =
    SampleLimits { geometric_max: 64, perturbed_max: 8, sampled_max: 24 };
/// Read-only inputs of stage P.
#[derive(Debug, Clone, Copy)]
pub struct StageContext<'a> {
    /// The robot, and its collision model in the world.
    pub constraints: &'a Constraints,
    /// Surfaces on which soles can be placed.
    pub surfaces: &'a Surfaces,
    /// The upper body.
    pub upper_body: &'a UpperBody,
    /// Reachable spaces, step limits and the range of primitives.
    pub preparation: &'a Preparation,
    /// The root postures, once the world asks for them.
    pub postures: &'a [RootPosture],
    /// The seed of all random streams.
    pub seed: u64,
    /// Ideal lateral distance between the soles, m.
    pub stance_width: f64,
    /// The threads.
    pub threads: &'a Threads,
}

/// Memory of the placement searches of both feet.
#[derive(Debug)]
pub enum FootScratch<'a> {
    /// One memory for one foot after the other.
    Shared(&'a mut Scratch),
    /// One memory for each foot, which are searched in parallel.
    Each([&'a mut Scratch; 2]),
}

/// A pose that meets the condition of its query.
#[derive(Debug, Clone)]
pub struct VertexCandidate {
    /// The requested pose, projected to the ground (elevation projection).
    pub pose: MidFeetPose,
    /// The placements of both feet.
    pub placements: heapless::Vec<FootPlacement, VERTEX_PLACEMENTS_MAX>,
    /// The pair of placements below the pose.
    pub pair: Option<FootPair>,
    /// Whether its feet are free of each other.
    pub are_apart: bool,
    /// Whether the upper body of the upright robot is free.
    pub is_upright: bool,
    /// The root posture.
    pub posture: PostureId,
}

/// Request for a vertex candidate.
#[derive(Debug, Clone, Copy)]
pub struct VertexQuery {
    /// The mid-feet pose.
    pub pose: MidFeetPose,
    /// Height of the branch's target, m.
    pub target_height: f64,
    /// What the vertex must satisfy.
    pub condition: RouteCondition,
    /// The name of the query in the random stream.
    pub name: u64,
}

impl StageContext<'_> {
    /// Finds placements for both feet near a pose and moves the pose over the best pair of them:
    /// vertically, and laterally where the ground is narrow. `None` if the condition fails. Under
    /// C_N alone a vertex may have no placements. The root posture of a leaning robot is chosen
    /// with the edge, afterwards.
    pub fn find_candidate(
        &self,
        query: &VertexQuery,
        scratch: &mut FootScratch<'_>,
    ) -> Option<VertexCandidate> {
        if query.condition == RouteCondition::Necessary {
            return self.find_possible(query, scratch);
        }
        let placements = self.find_both_placements(query, scratch)?;
        let (position, pair, are_apart) = self.best_pair(query, &placements)?;
        let pose = MidFeetPose { position, yaw: query.pose.yaw };
        if query.condition == RouteCondition::Leaning {
            return Some(VertexCandidate {
                pose,
                placements,
                pair: Some(pair),
                are_apart,
                is_upright: false,
                posture: UPRIGHT,
            });
        }
        let [left, right] = &pair;
        let fit = self.upper_body.fit(&self.constraints.collision, &pose);
        let fits = fit >= fit_min(query.condition)
            && self.upper_body.are_legs_free(
                &self.constraints.collision,
                &pose,
                [&left.world_from_sole, &right.world_from_sole],
            );
        fits.then_some(VertexCandidate {
            pose,
            placements,
            pair: Some(pair),
            are_apart,
            is_upright: fit == UpperBodyFit::Upright,
            posture: UPRIGHT,
        })
    }

    /// A vertex under C_N alone, with placements if both feet find some. It keeps its place, since
    /// the root need not be midway between the feet.
    fn find_possible(
        &self,
        query: &VertexQuery,
        scratch: &mut FootScratch<'_>,
    ) -> Option<VertexCandidate> {
        let placements = self.find_both_placements(query, scratch).unwrap_or_default();
        let best = self.best_pair(query, &placements);
        let mut pose = query.pose;
        pose.position.z = best.map_or(pose.position.z, |(middle, ..)| middle.z);
        self.is_possible(&pose, query.name).then_some(VertexCandidate {
            pose,
            placements,
            pair: best.map(|(_, pair, _)| pair),
            are_apart: best.is_some_and(|(.., are_apart)| are_apart),
            is_upright: false,
            posture: UPRIGHT,
        })
    }

    /// Whether C_N holds at a root pose over a pose; `name` names the root poses that are tested.
    pub fn is_possible(&self, pose: &MidFeetPose, name: u64) -> bool {
        let StageContext { constraints, preparation, seed, .. } = *self;
        let mid_feet_from_root = self.upper_body.mid_feet_from_root();
        RootPoses { constraints, preparation, mid_feet_from_root, seed }.is_possible(pose, name)
    }

    /// Whether the upper body is free at a pose.
    pub fn is_free(&self, pose: &MidFeetPose, condition: RouteCondition) -> bool {
        self.upper_body.fit(&self.constraints.collision, pose) >= fit_min(condition)
    }

    /// The least fit of the upper body between two poses, tested every `FIT_STEP`; `None` if it
    /// is too small.
    pub fn fit_between(
        &self,
        from: &MidFeetPose,
        to: &MidFeetPose,
        condition: RouteCondition,
    ) -> Option<UpperBodyFit> {
        let interval_count = libm::ceil(from.position.distance(to.position) / FIT_STEP).max(2.0);
        (1..interval_count as usize).try_fold(UpperBodyFit::Upright, |least, index| {
            let pose = from.interpolate(to, index as f64 / interval_count);
            let fit = if condition == RouteCondition::Necessary {
                let is_possible = self.is_possible(&pose, index as u64);
                if is_possible { UpperBodyFit::Core } else { UpperBodyFit::None }
            } else {
                self.upper_body.fit(&self.constraints.collision, &pose)
            };
            (fit >= fit_min(condition)).then_some(fit.min(least))
        })
    }

    /// Whether a step leads from one of the placements `from` to one of `to`, by inverse kinematics
    /// [Grey 4.4.2]. Only the shortest steps within the step limits are tested. `true` if `from` is
    /// empty.
    pub fn has_step_between(&self, from: &[FootPlacement], to: &[FootPlacement]) -> bool {
        let mut steps: heapless::Vec<
            (f64, [&FootPlacement; 2]),
            { VERTEX_PLACEMENTS_MAX * VERTEX_PLACEMENTS_MAX },
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
                let FootPlacement { limb, world_from_sole, .. } = *placement;
                Foothold::whole(&self.constraints.robot, limb, world_from_sole)
            });
            is_step(self.constraints, [&from, &to])
        };
        from.is_empty() || steps.iter().take(STEPS_TRIED_MAX).any(is_step)
    }

    /// Placements of the left foot, then of the right one; `None` if a foot has none.
    fn find_both_placements(
        &self,
        query: &VertexQuery,
        scratch: &mut FootScratch<'_>,
    ) -> Option<heapless::Vec<FootPlacement, VERTEX_PLACEMENTS_MAX>> {
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

    /// Placements of a foot near its ideal pose.
    fn find_placements(
        &self,
        query: &VertexQuery,
        limb: usize,
        scratch: &mut Scratch,
    ) -> heapless::Vec<FootPlacement, FOOT_PLACEMENTS_MAX> {
        let mut placements = heapless::Vec::new();
        let foothold_query = FootholdQuery {
            limb,
            ideal: query.pose.world_from_ideal_sole(limb, self.stance_width),
            reach_z: PLACEMENT_REACH_Z,
            yaw_spread: YAW_SPREAD_MAX.min(self.preparation.step_limits().turn_max()),
            seed: self.seed,
            name: (query.name << 1 | limb as u64 | 1 << 60, 0),
            limits: if query.condition > RouteCondition::UpperBody {
                RELAXED_LIMITS
            } else {
                LIMITS
            },
            kept_max: FOOT_PLACEMENTS_MAX,
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

    /// The pair of placements of least cost, the point midway between its soles (world, m), and
    /// whether its feet are free of each other. A pair whose feet collide counts only if all pairs
    /// do. Both soles of a pair must be reachable at once according to R.
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

    /// Cost of a pair of soles and the point midway between them, world, m. The cost is the sum of
    /// the distances to the ideal soles, and weighted differences in height.
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

/// The least fit of the upper body under a condition.
fn fit_min(condition: RouteCondition) -> UpperBodyFit {
    match condition {
        RouteCondition::UpperBody => UpperBodyFit::Crouched,
        RouteCondition::Root | RouteCondition::Leaning | RouteCondition::Necessary => {
            UpperBodyFit::Core
        }
    }
}
