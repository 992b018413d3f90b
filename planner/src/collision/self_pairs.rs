//! The pairs of links that are checked for self-collision, with the distance that each keeps.

use glam::DAffine3;
use surefoot_shared_types::robot::model::{RobotModel, joints_between};

use crate::collision::body_distance::parts_within;
use crate::collision::pair_survey::PairSurvey;
use crate::collision::robot_bodies::CollisionBody;
use crate::collision::separating_direction::SeparatingDirection;
use crate::collision::tuning::{COLLIDING_SAMPLES_MIN, NEIGHBOR_JOINTS_MAX};
use crate::geometry::distance::exceeds;
use crate::robot::bounding_spheres::{Centers, LANES};

/// A pair of bodies that is checked.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BodyPair {
    /// Index of the first body.
    pub(crate) a: u32,
    /// Index of the second body, the larger one.
    pub(crate) b: u32,
    /// Distance to keep, m.
    pub(crate) clearance: f64,
    /// A direction along which the bodies are apart in the standing posture, and in most others.
    standing_separation: Option<SeparatingDirection>,
}

impl BodyPair {
    /// Whether two bodies whose spheres are near come within the pair's clearance of each other;
    /// the frames of their nodes are given in any common frame.
    pub(crate) fn is_hit(
        &self,
        a: (&CollisionBody, &DAffine3),
        b: (&CollisionBody, &DAffine3),
    ) -> bool {
        let are_apart = self.standing_separation.is_some_and(|direction| {
            direction.is_separated(a.1, (&b.0.parts[0], b.1), self.clearance)
        });
        !are_apart && parts_within(a, b, self.clearance)
    }
}

/// The pairs that are checked, and the pairs that may touch.
#[derive(Debug, Clone)]
pub(crate) struct SelfPairs {
    /// Checked pairs in ascending order.
    pub(crate) checked: Vec<BodyPair>,
    /// Links of the pairs that may touch, in ascending order.
    pub(crate) allowed: Vec<(usize, usize)>,
    /// Numbers per row of the tables.
    stride: usize,
    /// For each two bodies, row by row: the squared distance (m2) of their spheres' centres up to
    /// which the solids are compared. Negative for pairs that may touch, for pairs in the other
    /// order, and at the end of each row.
    reach_squared: Vec<f64>,
    /// For each two bodies the index of their checked pair.
    pair_indices: Vec<u32>,
}

impl SelfPairs {
    /// Sorts the pairs of a robot's bodies. A checked pair keeps `clearance` (m), or less if it is
    /// nearer in the standing posture.
    pub(crate) fn new(model: &RobotModel, bodies: &[CollisionBody], clearance: f64) -> Self {
        let unlocked = model.unlocked();
        let survey = PairSurvey::new(model, &unlocked, bodies);
        let stride = bodies.len().next_multiple_of(LANES);
        let mut pairs = Self {
            checked: Vec::new(),
            allowed: Vec::new(),
            stride,
            reach_squared: vec![-1.0; bodies.len() * stride],
            pair_indices: vec![0; bodies.len() * stride],
        };
        for a in 0..bodies.len() {
            for b in a + 1..bodies.len() {
                let links = [bodies[a].link, bodies[b].link];
                let joints = joints_between(&unlocked.links, links);
                let hits = survey.hits(bodies, [a, b]);
                let stands_touching = survey.touches_standing(&bodies[a], &bodies[b]);
                let is_near = joints <= NEIGHBOR_JOINTS_MAX || hits >= COLLIDING_SAMPLES_MIN;
                if joints == 0 || joints == 1 && hits == 0 || is_near && stands_touching {
                    pairs.allowed.push((links[0].min(links[1]), links[0].max(links[1])));
                    continue;
                }
                let is_rigid = joints_between(&model.links, links) == 0;
                if !is_rigid || stands_touching {
                    pairs.add_checked(&survey, bodies, [a, b], clearance);
                }
            }
        }
        pairs.allowed.sort_unstable();
        pairs
    }

    fn add_checked(
        &mut self,
        survey: &PairSurvey,
        bodies: &[CollisionBody],
        [a, b]: [usize; 2],
        clearance: f64,
    ) {
        let (body_a, body_b) = (&bodies[a], &bodies[b]);
        let clearance = survey.standing_clearance(body_a, body_b, clearance);
        let reach = body_a.sphere.radius + body_b.sphere.radius + clearance;
        self.reach_squared[a * self.stride + b] = reach * reach;
        self.pair_indices[a * self.stride + b] = self.checked.len() as u32;
        let standing_separation = survey.standing_separation(body_a, body_b);
        self.checked.push(BodyPair { a: a as u32, b: b as u32, clearance, standing_separation });
    }

    /// The first checked pair whose spheres are near and that `accept` accepts.
    pub(crate) fn find_near(
        &self,
        centers: &Centers,
        mut accept: impl FnMut(&BodyPair) -> bool,
    ) -> Option<&BodyPair> {
        // The comparison of blocks reads sign bits, which are meaningless for NaN.
        let is_finite = centers.are_finite();
        (0..centers.count()).find_map(|a| {
            let center = centers.get(a);
            let (reaches, _) =
                self.reach_squared[a * self.stride..(a + 1) * self.stride].as_chunks::<LANES>();
            (a / LANES..reaches.len()).find_map(|block| {
                if is_finite && centers.are_apart(center, block, &reaches[block]) {
                    return None;
                }
                (0..LANES).find_map(|lane| {
                    let (b, reach) = (block * LANES + lane, reaches[block][lane]);
                    let is_near =
                        reach >= 0.0 && !exceeds(center.distance_squared(centers.get(b)), reach);
                    if !is_near {
                        return None;
                    }
                    Some(&self.checked[self.pair_indices[a * self.stride + b] as usize])
                        .filter(|pair| accept(pair))
                })
            })
        })
    }

    /// Heap memory, bytes.
    pub(crate) fn bytes(&self) -> usize {
        let tables =
            size_of_val(self.reach_squared.as_slice()) + size_of_val(self.pair_indices.as_slice());
        size_of_val(self.checked.as_slice()) + size_of_val(self.allowed.as_slice()) + tables
    }
}
