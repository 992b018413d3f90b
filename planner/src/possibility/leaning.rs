//! Vertices and edges of Gamma_P with a root pose in SE(3): where no upright root pose leads on,
//! the root bends and leans [Grey 3.2, 4.1.1].

use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{interpolate, rotation_distance};

use crate::base::random::{Random, Stream};
use crate::constraints::foothold::FootPair;
use crate::possibility::mid_feet_pose::MidFeetPose;
use crate::possibility::root_vertex::{PostureId, RootVertex, UPRIGHT};
use crate::possibility::tuning::{
    POSTURE_CHANGE_COST, POSTURES_PER_VERTEX, ROOT_TEST_STEP, ROOT_TEST_TURN,
};
use crate::possibility::upper_body::is_in_reach;
use crate::possibility::vertex_candidates::StageContext;
use crate::robot::crouch::Crouch;

/// Stage P's search for vertices and edges with a root pose in SE(3).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Leaning<'a>(pub &'a StageContext<'a>);

impl Leaning<'_> {
    /// The root posture at `to` in which the upper body is free, the legs reach down to the soles,
    /// and an edge leads there: that `toward` which the branch grows, else of those tried the one
    /// with the least lean and change. `name` names the postures that are tried.
    pub fn lean_to(
        &self,
        from: RootVertex,
        (to, pair): (&MidFeetPose, Option<&FootPair>),
        toward: PostureId,
        name: u64,
    ) -> Option<PostureId> {
        let others = self.postures_near(from.posture, name);
        let mut tried =
            std::iter::once(toward).chain(others.into_iter().map(|(_, posture)| posture));
        tried.find(|&posture| {
            let at = RootVertex { pose: *to, posture };
            self.is_root_free(&self.world_from_root(at), [posture; 2])
                && pair.is_none_or(|pair| self.may_stand_over(at, pair))
                && self.may_lean_between(from, at)
        })
    }

    /// Whether an edge leads from one root pose to another: both at once, or the root first leans
    /// and then moves, or the reverse.
    pub fn may_lean_between(&self, from: RootVertex, to: RootVertex) -> bool {
        let is_free = |from: RootVertex, to: RootVertex| {
            let postures = [from.posture, to.posture];
            self.is_root_path_free([from, to].map(|at| self.world_from_root(at)), postures)
        };
        let leads_over = |middle: RootVertex| is_free(from, middle) && is_free(middle, to);
        is_free(from, to)
            || from.posture != to.posture
                && (leads_over(RootVertex { posture: to.posture, ..from })
                    || leads_over(RootVertex { posture: from.posture, ..to }))
    }

    /// The postures to try after one, with their costs, the cheapest first: that one, the upright
    /// one, and random ones.
    fn postures_near(
        &self,
        from: PostureId,
        name: u64,
    ) -> heapless::Vec<(f64, PostureId), POSTURES_PER_VERTEX> {
        let mut random = Random::new(self.0.seed, Stream::Possibility, name | 1 << 59, 1);
        let at = self.crouch(from);
        let cost = |posture: PostureId| {
            let crouch = self.crouch(posture);
            crouch.depth() + POSTURE_CHANGE_COST * crouch.distance(&at)
        };
        let drawn = (2..POSTURES_PER_VERTEX).map(|_| random.below(self.0.postures.len()) as u16);
        let mut tried: heapless::Vec<_, POSTURES_PER_VERTEX> = [from, UPRIGHT]
            .into_iter()
            .chain(drawn)
            .map(|posture| (cost(posture), posture))
            .collect();
        tried.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        tried
    }

    /// The crouch of a posture.
    pub fn crouch(&self, posture: PostureId) -> Crouch {
        self.0.postures[posture as usize].crouch
    }

    fn world_from_root(&self, at: RootVertex) -> Pose {
        at.pose.world_from_mid_feet() * self.0.postures[at.posture as usize].mid_feet_from_root
    }

    /// Whether the upper body is free at a root pose, the waist as in each of two postures.
    fn is_root_free(&self, world_from_root: &Pose, postures: [PostureId; 2]) -> bool {
        let StageContext { upper_body, constraints, .. } = self.0;
        let [from, to] = postures.map(|posture| self.crouch(posture).waist > 0.0);
        let is_free = |is_bent: bool| {
            upper_body.is_free_above_legs(&constraints.collision, world_from_root, is_bent)
        };
        is_free(from) && (from == to || is_free(to))
    }

    /// Whether the legs fit at a root pose: both soles are in its reachable space R, so that
    /// no leg is longer or more folded than it can be, and a leg can extend down to them.
    fn may_stand_over(&self, at: RootVertex, [left, right]: &FootPair) -> bool {
        let StageContext { upper_body, constraints, preparation, .. } = self.0;
        let world_from_root = self.world_from_root(at);
        let world_from_soles = [&left.world_from_sole, &right.world_from_sole];
        is_in_reach(preparation, &world_from_root, world_from_soles)
            && upper_body.is_leg_free(&constraints.collision, &world_from_root, world_from_soles)
    }

    /// Whether the upper body is free between two root poses and at the second, along a geodesic of
    /// SE(3).
    fn is_root_path_free(&self, [from, to]: [Pose; 2], postures: [PostureId; 2]) -> bool {
        let distance = from.translation.distance(to.translation);
        let angle = rotation_distance(from.rotation, to.rotation);
        let tests = libm::ceil((distance / ROOT_TEST_STEP).max(angle / ROOT_TEST_TURN)).max(1.0);
        (1..=tests as usize).all(|index| {
            self.is_root_free(&interpolate(&from, &to, index as f64 / tests), postures)
        })
    }
}
