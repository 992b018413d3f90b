//! Which joints are locked: fingers, heads, toes, and joints beyond those that a plan holds.

use std::collections::BTreeMap;

use crate::base::limits::JOINTS_MAX;
use crate::robot::model::JointKind;
use crate::robot::urdf_joint::JointType;
use crate::robot_draft::foot_search::MirroredPair;
use crate::robot_draft::skeleton::{NodeIndex, Skeleton};

/// A joint that moves less than this share of the robot's mass moves a finger or a cover.
const MASS_SHARE_MIN: f64 = 1e-3;
/// Least joints of an arm: a shoulder and an elbow.
pub(crate) const ARM_JOINTS_MIN: usize = 2;
/// Most joints of an arm that are looked at, shoulder first.
const ARM_JOINTS_MAX: usize = 10;

/// The limbs of a robot and the joints that are locked.
#[derive(Debug, Clone, Default)]
pub(crate) struct Limbs {
    /// The arms, left first where their names show it; each as long as it does not branch.
    pub(crate) arms: Vec<[Vec<NodeIndex>; 2]>,
    /// Locked nodes and why.
    pub(crate) locked: BTreeMap<NodeIndex, &'static str>,
}

/// Sorts all joints that belong to no leg.
pub(crate) fn limbs(skeleton: &Skeleton, pairs: &[MirroredPair], feet: &MirroredPair) -> Limbs {
    let arms = arms(skeleton, pairs, feet);
    let mut limbs = Limbs { arms, locked: BTreeMap::new() };
    let tips = feet.bodies.iter().chain(limbs.arms.iter().flatten().filter_map(|arm| arm.last()));
    let kept: Vec<NodeIndex> = tips.flat_map(|tip| skeleton.chain(*tip)).collect();
    for node in skeleton.moving() {
        if !kept.contains(&node) {
            let is_toe = feet.bodies.iter().any(|foot| skeleton.is_below(node, *foot));
            let is_hand = limbs.arms.iter().flatten().any(|arm| is_below_one(skeleton, node, arm));
            let reason = match (is_toe, is_hand) {
                (true, _) => "below the sole: a toe",
                (_, true) => "beyond the wrist: a finger, or a cover",
                _ => "carries neither a leg nor an arm of two joints: a head, or a cover",
            };
            limbs.locked.insert(node, reason);
        }
    }
    lock_unusable(skeleton, feet, &mut limbs);
    lock_surplus(skeleton, &mut limbs);
    lock_mimicked(skeleton, &mut limbs);
    limbs
}

fn is_below_one(skeleton: &Skeleton, node: NodeIndex, arm: &[NodeIndex]) -> bool {
    arm.first().is_some_and(|first| skeleton.is_below(node, *first))
}

/// Pairs of chains off the trunk that mirror each other, and are no fingers of another pair.
fn arms(
    skeleton: &Skeleton,
    pairs: &[MirroredPair],
    feet: &MirroredPair,
) -> Vec<[Vec<NodeIndex>; 2]> {
    let mut arms: Vec<[Vec<NodeIndex>; 2]> = Vec::new();
    for pair in pairs {
        let [a, b] = pair.chains.each_ref().map(|chain| chain[0]);
        let is_leg = feet.chains.iter().flatten().any(|leg| [a, b].contains(leg))
            || feet.bodies.iter().any(|foot| skeleton.is_below(*foot, a));
        let is_known = arms.iter().flatten().any(|arm| [a, b].contains(&arm[0]));
        if is_leg || is_known {
            continue;
        }
        let sorted = pair.side(skeleton).map_or(pair.clone(), |side| pair.clone().sorted(side));
        let chains = sorted.chains.map(|chain| unbranched(skeleton, &chain));
        let count = chains[0].len().min(chains[1].len());
        if count >= ARM_JOINTS_MIN {
            arms.push(chains.map(|chain| chain[..count].to_vec()));
        }
    }
    let firsts: Vec<NodeIndex> = arms.iter().flatten().map(|arm| arm[0]).collect();
    let is_finger = |node: NodeIndex| {
        firsts.iter().any(|first| *first != node && skeleton.is_below(node, *first))
    };
    arms.retain(|[left, _]| !is_finger(left[0]));
    arms
}

/// The first joints of a chain up to where it branches, slides or gets light.
fn unbranched(skeleton: &Skeleton, chain: &[NodeIndex]) -> Vec<NodeIndex> {
    let Some(&first) = chain.first() else { return Vec::new() };
    let total = skeleton.mass_below(0);
    let is_arm = |node: NodeIndex| {
        let is_turning = skeleton.nodes[node]
            .joint
            .as_ref()
            .is_some_and(|joint| joint.kind == JointKind::Revolute && joint.follows.is_none());
        is_turning && skeleton.mass_below(node) >= MASS_SHARE_MIN * total
    };
    let mut arm = Vec::new();
    let mut at = Some(first).filter(|node| is_arm(*node));
    while let Some(node) = at {
        arm.push(node);
        let below: Vec<NodeIndex> = skeleton
            .moving()
            .filter(|other| moving_parent(skeleton, *other) == Some(node))
            .collect();
        at = match below[..] {
            [only] if is_arm(only) && arm.len() < ARM_JOINTS_MAX => Some(only),
            _ => None,
        };
    }
    arm
}

/// The moving body that a moving body hangs on.
fn moving_parent(skeleton: &Skeleton, node: NodeIndex) -> Option<NodeIndex> {
    skeleton.nodes[node].parent.map(|parent| skeleton.body(parent))
}

/// Locks joints of arms and trunk that cannot move in a plan: without range, or of no mass.
fn lock_unusable(skeleton: &Skeleton, feet: &MirroredPair, limbs: &mut Limbs) {
    let nodes: Vec<NodeIndex> = skeleton.moving().collect();
    for node in nodes {
        let Some(joint) = &skeleton.nodes[node].joint else { continue };
        if feet.chains.iter().flatten().any(|leg| *leg == node) {
            continue;
        }
        let stated = skeleton.urdf_joint(node);
        let limit = stated.and_then(|joint| joint.limit.as_ref());
        let turns_freely = stated.is_some_and(|joint| joint.joint_type == JointType::Continuous);
        let reason = if limit.is_none() {
            "the URDF states no <limit>"
        } else if !turns_freely && limit.is_some_and(|limit| limit.range.is_none()) {
            "its <limit> states no range"
        } else if joint.lower >= joint.upper {
            "its limits leave no range of motion"
        } else if body_mass(skeleton, node) <= 0.0 {
            "the link that it moves has no mass"
        } else {
            continue;
        };
        limbs.locked.entry(node).or_insert(reason);
    }
}

fn body_mass(skeleton: &Skeleton, body: NodeIndex) -> f64 {
    let nodes = skeleton.body_nodes(body).into_iter();
    nodes.map(|node| skeleton.urdf.links[skeleton.nodes[node].urdf_link].mass).sum()
}

/// Locks the outermost joints of the arms while more move than a plan holds.
fn lock_surplus(skeleton: &Skeleton, limbs: &mut Limbs) {
    let count = |limbs: &Limbs| {
        skeleton
            .moving()
            .filter(|node| !limbs.locked.contains_key(node) && !skeleton.is_mimic(*node))
            .count()
    };
    for back in 0..ARM_JOINTS_MAX {
        if count(limbs) <= JOINTS_MAX {
            return;
        }
        let outer: Vec<NodeIndex> = limbs
            .arms
            .iter()
            .flatten()
            .filter_map(|arm| arm.len().checked_sub(back + 1).map(|at| arm[at]))
            .collect();
        for node in outer {
            limbs.locked.entry(node).or_insert("more joints move than a plan holds");
        }
    }
}

/// A joint that mimics another one is held with it, and not listed; where the other one moves, it
/// is locked, too.
fn lock_mimicked(skeleton: &Skeleton, limbs: &mut Limbs) {
    let mimics: Vec<(NodeIndex, NodeIndex)> = skeleton
        .moving()
        .filter_map(|node| {
            let (leader, _, _) = skeleton.nodes[node].joint.as_ref()?.follows?;
            Some((node, leader))
        })
        .collect();
    for (node, leader) in &mimics {
        limbs.locked.remove(node);
        if !mimics.iter().any(|(other, _)| other == leader) {
            limbs.locked.entry(*leader).or_insert("another joint mimics it");
        }
    }
}
