//! Which links may touch each other: decided from the robot alone, as MoveIt's setup assistant
//! does.
//!
//! Links at most one joint apart; links that overlap in nearly every random configuration; and
//! links at most three joints apart that overlap at joint position 0. Joints that are held still
//! part links, too.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::robot::model::{LinkIndex, RobotModel};

use crate::geometry::body::{CollisionBody, SolidPose};
use crate::geometry::separation::separation;
use crate::kinematics::forward::{Configuration, Posture};

/// Random configurations tried.
const CONFIGURATIONS: u32 = 300;
/// Overlapping in this many of them, a pair always overlaps (95 %).
const ALWAYS_MIN: u32 = 285;
/// Links this many moving joints apart are one piece or neighbours.
const NEIGHBOURS_MAX: usize = 1;
/// Links this many moving joints apart may overlap at joint position 0.
const NEAR_MAX: usize = 3;

/// A pair of links, the smaller index first.
pub type LinkPair = (LinkIndex, LinkIndex);

/// All pairs of links that carry bodies and may touch.
pub fn allowed_pairs(model: &RobotModel, bodies: &[CollisionBody]) -> BTreeSet<LinkPair> {
    let links: BTreeSet<LinkIndex> = bodies.iter().filter_map(|body| body.link).collect();
    let pairs = links.iter().flat_map(|&a| links.range(a + 1..).map(move |&b| (a, b)));
    let distances: BTreeMap<LinkPair, usize> =
        pairs.map(|pair| (pair, joints_apart(model, pair))).collect();
    let in_doubt: Vec<LinkPair> = distances
        .iter()
        .filter(|(_, apart)| **apart > NEIGHBOURS_MAX)
        .map(|(pair, _)| *pair)
        .collect();
    let at_zero: BTreeSet<LinkPair> =
        overlapping(model, bodies, &in_doubt, neutral(model)).into_iter().collect();
    let mut random = SplitMix(0);
    let mut counts: BTreeMap<LinkPair, u32> = BTreeMap::new();
    for _ in 0..CONFIGURATIONS {
        let q = model
            .joints
            .iter()
            .map(|joint| random.between(joint.lower.max(-PI), joint.upper.min(PI)))
            .collect();
        for pair in overlapping(model, bodies, &in_doubt, q) {
            *counts.entry(pair).or_default() += 1;
        }
    }
    let allowed = |pair: &LinkPair, apart: usize| {
        apart <= NEIGHBOURS_MAX
            || counts.get(pair).is_some_and(|count| *count >= ALWAYS_MIN)
            || (apart <= NEAR_MAX && at_zero.contains(pair))
    };
    distances
        .into_iter()
        .filter(|(pair, apart)| allowed(pair, *apart))
        .map(|(pair, _)| pair)
        .collect()
}

fn neutral(model: &RobotModel) -> Vec<f64> {
    model.joints.iter().map(|joint| 0.0_f64.max(joint.lower).min(joint.upper)).collect()
}

/// The moving joints on the way from one link to the other.
fn joints_apart(model: &RobotModel, (a, b): LinkPair) -> usize {
    let (first, second) = (model.chain(a), model.chain(b));
    let shared = first.iter().zip(&second).take_while(|(x, y)| x == y).count();
    first.len() + second.len() - 2 * shared
}

fn overlapping(
    model: &RobotModel,
    bodies: &[CollisionBody],
    pairs: &[LinkPair],
    q: Vec<f64>,
) -> Vec<LinkPair> {
    let posture = Posture::new(model, &Configuration { world_from_root: Pose::IDENTITY, q });
    let mut on_link: Vec<Vec<(&CollisionBody, SolidPose)>> = vec![Vec::new(); model.links.len()];
    for body in bodies {
        if let Some(link) = body.link {
            on_link[link].push((body, SolidPose::new(body, &posture.world_from_link[link])));
        }
    }
    let touch = |(a, b): &LinkPair| {
        on_link[*a].iter().any(|(first, at)| {
            on_link[*b].iter().any(|(second, there)| {
                let direction = (there.bounds.centre() - at.bounds.centre()).normalize_or(DVec3::X);
                separation((&first.solid, at), (&second.solid, there), direction, 0.0).distance
                    < 0.0
            })
        })
    };
    pairs.iter().copied().filter(touch).collect()
}

/// Steele, Lea and Flood's SplitMix64.
struct SplitMix(u64);

impl SplitMix {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.next() >> 11) as f64 / (1_u64 << 53) as f64)
    }
}
