//! How deep two links of the robot may overlap, decided from the robot alone.
//!
//! Links without a joint between them do not move against each other and are not checked. A pair
//! that is clear in the standing posture must stay apart. Covers of links that are near each other
//! and overlap there overlap deeper as the joints between them bend: within the range of these
//! joints in walks they are not checked, and beyond it they may be as deep as in any of a grid of
//! postures within it, or as deep as the robot file allows. Any other pair that overlaps in the
//! standing posture may overlap as deep as there. Joints that are locked separate links, too.

use surefoot_shared_types::Pose;
use surefoot_shared_types::robot::model::{AllowedOverlap, JointIndex, LinkIndex, RobotModel};

use crate::geometry::body::{CollisionBody, SolidPose};
use crate::geometry::penetration::body_depth;
use crate::kinematics::forward::{Configuration, Posture};

/// Covers of links this many joints apart may overlap as the joints bend: a hip, an ankle or a
/// wrist has up to three joints.
const NEAR_MAX: usize = 3;
/// Joints move in walks by at most this from the standing posture, rad or m: those that carry a
/// foot, and the others.
const LEG_JOINT_REACH: f64 = 2.6;
const FREE_JOINT_REACH: f64 = 0.65;
/// Postures per joint in which the depth of near links is measured. Between them it may be a little
/// greater, so the largest measured depth is a strict limit.
const POSTURES_PER_JOINT: usize = 7;
/// Depths are allowed with this rounding, m.
const DEPTH_ROUNDING: f64 = 1e-6;

/// Two bodies with a joint between them. The smaller index of the bodies comes first.
#[derive(Debug, Clone, PartialEq)]
pub struct SelfPair {
    /// Indices of the bodies.
    pub bodies: (usize, usize),
    /// How deep they overlap in the standing posture, m; 0 where they are clear of each other.
    pub standing_depth: f64,
    /// How deep they may overlap, m.
    pub depth_max: f64,
    /// The joints between near bodies and their ranges in walks: nothing is checked where all of
    /// them are within their ranges. Empty for other pairs.
    pub walked: Vec<JointRange>,
}

/// A joint's range in walks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointRange {
    /// The joint.
    pub joint: JointIndex,
    /// Its lower end, rad or m.
    pub low: f64,
    /// Its upper end, rad or m.
    pub high: f64,
}

impl SelfPair {
    /// Whether every joint between the bodies is within its range in walks.
    pub fn is_walked(walked: &[JointRange], configuration: &Configuration) -> bool {
        let is_within =
            |range: &JointRange| (range.low..=range.high).contains(&configuration.q[range.joint]);
        !walked.is_empty() && walked.iter().all(is_within)
    }
}

/// All pairs of bodies with a joint between them.
pub fn self_pairs(model: &RobotModel, bodies: &[CollisionBody]) -> Vec<SelfPair> {
    let survey = DepthSurvey::new(model, bodies);
    let indices = (0..bodies.len()).flat_map(|a| (a + 1..bodies.len()).map(move |b| (a, b)));
    indices.filter_map(|pair| survey.pair(pair)).collect()
}

/// Measures depths in postures of a robot whose root is at the origin.
struct DepthSurvey<'a> {
    /// Locked joints are its last joints.
    model: RobotModel,
    bodies: &'a [CollisionBody],
    standing: Posture,
    /// The joints that carry a foot.
    leg_joints: Vec<JointIndex>,
    /// Joints from this one on are locked.
    moving: usize,
}

impl<'a> DepthSurvey<'a> {
    fn new(robot: &RobotModel, bodies: &'a [CollisionBody]) -> Self {
        let model = robot.unlocked();
        let standing = posture(&model, model.standing_q.clone());
        let leg_joints = model.feet.iter().flat_map(|foot| model.chain(foot.link)).collect();
        Self { model, bodies, standing, leg_joints, moving: robot.joints.len() }
    }

    /// The pair of these bodies, if they are robot's and a joint separates them.
    fn pair(&self, bodies: (usize, usize)) -> Option<SelfPair> {
        let (a, b) = (self.bodies[bodies.0].link?, self.bodies[bodies.1].link?);
        let between = joints_between(&self.model, (a, b));
        if between.is_empty() {
            return None;
        }
        let standing_depth = overlap_depth(self.bodies, &self.standing, bodies, 0.0);
        let pair = |depth_max, walked| SelfPair { bodies, standing_depth, depth_max, walked };
        if standing_depth == 0.0 {
            return Some(pair(0.0, vec![]));
        }
        if between.len() > NEAR_MAX {
            return Some(pair(standing_depth + DEPTH_ROUNDING, vec![]));
        }
        let moving: Vec<JointIndex> =
            between.into_iter().filter(|joint| *joint < self.moving).collect();
        let walked: Vec<JointRange> = moving.into_iter().map(|joint| self.walked(joint)).collect();
        let known = standing_depth.max(self.granted((a, b)));
        let depth_max = postures(&self.model, &walked)
            .fold(known, |known, posture| overlap_depth(self.bodies, &posture, bodies, known));
        Some(pair(depth_max + DEPTH_ROUNDING, walked))
    }

    /// A joint's range in walks.
    fn walked(&self, joint: JointIndex) -> JointRange {
        let (limits, standing) = (&self.model.joints[joint], self.model.standing_q[joint]);
        let is_of_leg = self.leg_joints.contains(&joint);
        let reach = if is_of_leg { LEG_JOINT_REACH } else { FREE_JOINT_REACH };
        let (low, high) = ((standing - reach).max(limits.lower), standing + reach);
        JointRange { joint, low, high: high.min(limits.upper) }
    }

    /// The depth that the robot file allows these links.
    fn granted(&self, (a, b): (LinkIndex, LinkIndex)) -> f64 {
        let names = [&self.model.links[a].name, &self.model.links[b].name];
        self.model.allowed_overlap(names.map(String::as_str)).unwrap_or(0.0)
    }
}

/// How deep two bodies of the robot overlap in a posture, m; `known` where they overlap less.
pub(super) fn overlap_depth(
    bodies: &[CollisionBody],
    posture: &Posture,
    (a, b): (usize, usize),
    known: f64,
) -> f64 {
    let [a, b] = [a, b].map(|index| &bodies[index]);
    let [at_a, at_b] = [a, b].map(|body| placed(body, posture));
    body_depth((&a.solid, &at_a), (&b.solid, &at_b), known)
}

/// A body of the robot in a posture.
pub(super) fn placed(body: &CollisionBody, posture: &Posture) -> SolidPose {
    let pose = body.link.map_or(Pose::IDENTITY, |link| posture.world_from_link[link]);
    SolidPose::new(body, &pose)
}

/// The postures in which these joints have equally spaced positions, each with each, and all others
/// stand.
fn postures<'a>(
    model: &'a RobotModel,
    ranges: &'a [JointRange],
) -> impl Iterator<Item = Posture> + 'a {
    let count = POSTURES_PER_JOINT.pow(ranges.len() as u32);
    (0..count).map(move |index| {
        let mut q = model.standing_q.clone();
        let mut rest = index;
        for range in ranges {
            let share = (rest % POSTURES_PER_JOINT) as f64 / (POSTURES_PER_JOINT - 1) as f64;
            q[range.joint] = range.low + share * (range.high - range.low);
            rest /= POSTURES_PER_JOINT;
        }
        posture(model, q)
    })
}

fn posture(model: &RobotModel, q: Vec<f64>) -> Posture {
    Posture::new(model, &Configuration { world_from_root: Pose::IDENTITY, q })
}

/// The joints on the path between two links.
fn joints_between(model: &RobotModel, (a, b): (LinkIndex, LinkIndex)) -> Vec<JointIndex> {
    let (first, second) = (model.chain(a), model.chain(b));
    let shared = first.iter().zip(&second).take_while(|(x, y)| x == y).count();
    first[shared..].iter().chain(&second[shared..]).copied().collect()
}

/// The pairs that may overlap, one line each, with the reason.
pub fn describe(pairs: &[SelfPair], bodies: &[CollisionBody]) -> Vec<String> {
    let overlapping = pairs.iter().filter(|pair| pair.standing_depth > 0.0);
    let mut lines: Vec<String> = overlapping
        .map(|pair| {
            let (a, b) = (&bodies[pair.bodies.0].name, &bodies[pair.bodies.1].name);
            let (standing, depth) = (1e3 * pair.standing_depth, 1e3 * pair.depth_max);
            let reason = if pair.walked.is_empty() {
                format!("by {depth:.1} mm as when standing")
            } else {
                format!("neighbours, by {depth:.1} mm as in walks, {standing:.1} mm when standing")
            };
            format!("may overlap: {a} and {b}, {reason}")
        })
        .collect();
    lines.dedup();
    lines
}

/// The entries of the robot file under `[[allowed_overlaps]]` that allow nothing, one line each
/// with the reason. `unlocked` is the robot whose locked joints move.
pub fn without_effect(
    unlocked: &RobotModel,
    pairs: &[SelfPair],
    bodies: &[CollisionBody],
) -> Vec<String> {
    let line = |allowed: &AllowedOverlap| {
        let reason = reason_of_none(unlocked, allowed, (pairs, bodies))?;
        let [a, b] = &allowed.links;
        Some(format!("[[allowed_overlaps]] of {a} and {b} has no effect: {reason}"))
    };
    unlocked.allowed_overlaps.iter().filter_map(line).collect()
}

/// Why an entry allows nothing; nothing if it does.
fn reason_of_none(
    model: &RobotModel,
    allowed: &AllowedOverlap,
    (pairs, bodies): (&[SelfPair], &[CollisionBody]),
) -> Option<String> {
    let link = |name: &String| model.links.iter().position(|link| link.name == *name);
    let [Some(a), Some(b)] = allowed.links.each_ref().map(link) else {
        return Some("one of them is part of another link".into());
    };
    let between = joints_between(model, (a, b)).len();
    if between == 0 {
        return Some("no joint lies between them, so they are not checked".into());
    }
    let is_meant = |pair: &&SelfPair| {
        let links = [pair.bodies.0, pair.bodies.1].map(|index| bodies[index].link);
        links == [Some(a), Some(b)] || links == [Some(b), Some(a)]
    };
    let mut meant = pairs.iter().filter(is_meant).peekable();
    if meant.peek().is_none() {
        return Some("one of them has no collision shape".into());
    }
    let mut overlapping = meant.filter(|pair| pair.standing_depth > 0.0).peekable();
    if overlapping.peek().is_none() {
        return Some("they are clear of each other as the robot stands, and must stay so".into());
    }
    if between > NEAR_MAX {
        return Some(format!("{between} joints lie between them, and at most {NEAR_MAX} may"));
    }
    let least = overlapping.map(|pair| pair.depth_max).fold(f64::INFINITY, f64::min);
    let is_deeper = least <= allowed.depth + 2.0 * DEPTH_ROUNDING;
    (!is_deeper).then(|| format!("they may overlap by {:.1} mm without it", 1e3 * least))
}

/// What a robot file has to say for these bodies to overlap `depth` (m) deep.
pub fn advice((a, b): (&CollisionBody, &CollisionBody), depth: f64) -> String {
    let (links, tenths) = ([&a.name, &b.name], (1e4 * depth).ceil());
    format!(
        "; if the robot is built so, its robot file says: [[allowed_overlaps]] links = {links:?} \
         depth = {}",
        tenths / 1e4
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check_robot::{ELBOW, at, robot};
    use surefoot_shared_types::Shape;
    use surefoot_shared_types::robot::model::{LinkShape, LockedJoint};

    /// The robot whose forearm lies beside its upper arm and overlaps it, and the pair of both.
    fn overlapping(change: impl FnOnce(&mut RobotModel)) -> (SelfPair, Vec<CollisionBody>) {
        let mut model = robot();
        let shape = Shape::Capsule { radius: 0.03, half_length: 0.2 };
        model.links[4].shapes = vec![LinkShape { link_from_shape: at(0., 0.03, -0.2), shape }];
        change(&mut model);
        let bodies = CollisionBody::of_robot(&model).unwrap();
        let is_of = |index: usize, link: usize| bodies[index].link == Some(link);
        let pairs = self_pairs(&model, &bodies).into_iter();
        let mut of_arm = pairs.filter(|pair| is_of(pair.bodies.0, 3) && is_of(pair.bodies.1, 4));
        let pair = of_arm.next().unwrap();
        assert_eq!(of_arm.next(), None);
        (pair, bodies)
    }

    #[test]
    fn covers_of_neighbours_overlap_as_deep_as_their_joint_bends_in_walks() {
        let (pair, _) = overlapping(|_| ());
        // The ends of both cores are (0, 0.03) and (0.05, 0) m from the elbow, which turns one.
        let depth = |angle: f64| {
            let end = 0.03 * glam::DVec2::from_angle(angle);
            0.06 - end.distance(glam::DVec2::new(0.0, 0.05))
        };
        assert!((pair.standing_depth - depth(0.0)).abs() < 1e-6, "{pair:?}");
        assert!((pair.depth_max - depth(0.65)).abs() < 1e-5, "{pair:?}");
        assert_eq!(pair.walked, [JointRange { joint: ELBOW, low: -0.65, high: 0.65 }]);
        let (granted, _) = overlapping(|model| {
            model.standing_q[ELBOW] = 0.2;
            (model.joints[ELBOW].lower, model.joints[ELBOW].upper) = (-0.3, 0.4);
        });
        assert_eq!(granted.walked, [JointRange { joint: ELBOW, low: -0.3, high: 0.4 }]);
    }

    #[test]
    fn a_locked_joint_does_not_bend() {
        let (pair, bodies) = overlapping(|model| {
            let joint = model.joints.pop().unwrap();
            let position = model.standing_q.pop().unwrap();
            model.links[4].parent.as_mut().unwrap().joint = None;
            let parent_from_joint = at(0., 0., -0.4);
            model.locked_joints = vec![LockedJoint { joint, position, parent_from_joint }];
        });
        assert!(pair.walked.is_empty(), "{pair:?}");
        assert!((pair.depth_max - pair.standing_depth).abs() < 1e-5, "{pair:?}");
        let named = describe(std::slice::from_ref(&pair), &bodies);
        assert!(named[0].ends_with("by 1.7 mm as when standing"), "{named:?}");
        let text = advice((&bodies[pair.bodies.0], &bodies[pair.bodies.1]), 0.012_34);
        assert!(text.ends_with("links = [\"upper_arm\", \"forearm\"] depth = 0.0124"), "{text}");
    }
}
