//! A survey of configurations that shows which pairs of bodies may touch, and how far apart the
//! others are in the standing posture.

use surefoot_shared_types::Pose;
use surefoot_shared_types::robot::model::RobotModel;

use crate::base::random::{Random, Stream};
use crate::collision::body_distance::bodies_within;
use crate::collision::robot_bodies::CollisionBody;
use crate::collision::separating_direction::SeparatingDirection;
use crate::collision::tuning::SURVEY_SAMPLES;
use crate::geometry::narrow_phase::separating_direction;
use crate::kinematics::forward::Kinematics;

/// Bisections of the clearance in the standing posture: below a nanometre of any clearance in use.
const BISECTIONS: usize = 30;

/// The poses of all bodies in the surveyed configurations.
///
/// Locked joints move in them, except in the standing posture: a pair does not become one of
/// neighbours because the joints between are locked.
pub(crate) struct PairSurvey {
    /// Poses of all bodies' nodes in each random configuration.
    samples: Vec<Vec<Pose>>,
    /// Poses of all links in the standing posture.
    standing: Vec<Pose>,
}

impl PairSurvey {
    /// The survey of a robot; `unlocked` is its model with locked joints free.
    pub(crate) fn new(model: &RobotModel, unlocked: &RobotModel, bodies: &[CollisionBody]) -> Self {
        let sample_count = if bodies.len() > 1 { SURVEY_SAMPLES } else { 0 };
        let kinematics = Kinematics::new(unlocked);
        let links_from_nodes: Vec<Pose> =
            bodies.iter().map(|body| body.node_from_link.inverse()).collect();
        let node_poses = |q: &[f64]| -> Vec<Pose> {
            let links = link_poses(&kinematics, q);
            bodies
                .iter()
                .zip(&links_from_nodes)
                .map(|(body, link_from_node)| links[body.link] * *link_from_node)
                .collect()
        };
        let samples =
            (0..sample_count).map(|index| node_poses(&random_q(unlocked, index))).collect();
        Self { samples, standing: link_poses(&Kinematics::new(model), &model.standing_q) }
    }

    /// Number of random configurations in which a pair touches.
    pub(crate) fn hits(&self, bodies: &[CollisionBody], pair: [usize; 2]) -> usize {
        self.samples.iter().filter(|poses| touch(bodies, pair, poses)).count()
    }

    /// Whether two bodies are apart by more than `distance` (m) in the standing posture.
    fn is_apart_standing(&self, a: &CollisionBody, b: &CollisionBody, distance: f64) -> bool {
        let [pose_a, pose_b] = [a, b].map(|body| &self.standing[body.node_link]);
        !bodies_within(a, pose_a, b, pose_b, distance)
    }

    /// Whether two bodies touch in the standing posture.
    pub(crate) fn touches_standing(&self, a: &CollisionBody, b: &CollisionBody) -> bool {
        !self.is_apart_standing(a, b, 0.0)
    }

    /// `clearance` (m), or half of the pair's distance in the standing posture if that is less (a
    /// lower bound within a nanometre).
    pub(crate) fn standing_clearance(
        &self,
        a: &CollisionBody,
        b: &CollisionBody,
        clearance: f64,
    ) -> f64 {
        if self.is_apart_standing(a, b, 2.0 * clearance) {
            return clearance;
        }
        let (mut free, mut hit) = (0.0, clearance);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (free + hit);
            if self.is_apart_standing(a, b, 2.0 * middle) { free = middle } else { hit = middle }
        }
        free
    }

    /// A direction along which two bodies of one part each are apart in the standing posture;
    /// `None` if there is none, or if one has several parts or is a sphere or a capsule.
    pub(crate) fn standing_separation(
        &self,
        a: &CollisionBody,
        b: &CollisionBody,
    ) -> Option<SeparatingDirection> {
        let ([part_a], [part_b]) = (a.parts.as_slice(), b.parts.as_slice()) else { return None };
        if part_a.core_segment.is_some() || part_b.core_segment.is_some() {
            return None;
        }
        let [from_a, from_b] = [(a, part_a), (b, part_b)]
            .map(|(body, part)| self.standing[body.node_link] * part.node_from_part);
        SeparatingDirection::beyond(
            part_a,
            separating_direction(&part_a.solid, &part_b.solid, &from_a.inv_mul(&from_b))?,
        )
    }
}

fn link_poses(kinematics: &Kinematics, q: &[f64]) -> Vec<Pose> {
    let mut poses = vec![Pose::IDENTITY; kinematics.links_len()];
    kinematics.forward(&Pose::IDENTITY, q, &mut poses);
    poses
}

fn random_q(model: &RobotModel, index: usize) -> Vec<f64> {
    let mut random = Random::new(0, Stream::Preparation, 0, index as u64);
    let pi = std::f64::consts::PI;
    model
        .joints
        .iter()
        .map(|joint| random.uniform(joint.lower.clamp(-pi, pi), joint.upper.clamp(-pi, pi)))
        .collect()
}

/// Whether two bodies touch, for these poses of all bodies' nodes.
fn touch(bodies: &[CollisionBody], [a, b]: [usize; 2], poses: &[Pose]) -> bool {
    bodies_within(&bodies[a], &poses[a], &bodies[b], &poses[b], 0.0)
}
