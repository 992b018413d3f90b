//! Finds the two feet: links that mirror each other and reach the ground.

use glam::DVec3;

use crate::base::spatial::Pose;
use crate::robot_draft::body::LinkShapes;
use crate::robot_draft::mirror::{Side, side_of};
use crate::robot_draft::skeleton::{NodeIndex, Skeleton};
use crate::robot_draft::sole_search::find_sole;

/// Least and most moving joints of a leg that a walk can be planned for.
pub(crate) const LEG_JOINTS: [usize; 2] = [6, 8];
/// Least moving joints between two feet's common body and each foot.
pub(crate) const LEG_JOINTS_MIN: usize = 3;
/// How much higher than the lowest link a foot may end, as a share of the robot's height.
const GROUND_SHARE: f64 = 0.04;
/// How far the middles of mirrored links lie off one plane, m.
const MIRROR_GAP_MAX: f64 = 0.02;
/// How far the lines between mirrored links differ in direction, as a sine.
const MIRROR_TURN_MAX: f64 = 0.1;

/// Two bodies that mirror each other, and the moving joints that each has for itself.
#[derive(Debug, Clone)]
pub(crate) struct MirroredPair {
    /// The left one first, once [`MirroredPair::sorted`] knows it.
    pub(crate) bodies: [NodeIndex; 2],
    pub(crate) chains: [Vec<NodeIndex>; 2],
}

impl MirroredPair {
    /// The pair of two bodies, if they mirror each other where all joints stand at 0.
    fn new(
        skeleton: &Skeleton,
        poses: &[Pose],
        bodies: [NodeIndex; 2],
        joints_min: usize,
    ) -> Option<Self> {
        let pair = Self::unchecked(skeleton, bodies);
        let [a, b] = &pair.chains;
        let is_long = a.len() == b.len() && a.len() >= joints_min;
        let kinds = |chain: &[NodeIndex]| -> Vec<_> {
            chain.iter().map(|at| skeleton.nodes[*at].joint.as_ref().map(|it| it.kind)).collect()
        };
        (is_long && kinds(a) == kinds(b) && is_mirrored(skeleton, poses, a, b)).then_some(pair)
    }

    /// The pair of two bodies that a user names.
    pub(crate) fn unchecked(skeleton: &Skeleton, bodies: [NodeIndex; 2]) -> Self {
        let mut chains = bodies.map(|body| skeleton.chain(body));
        let shared = chains[0].iter().zip(&chains[1]).take_while(|(a, b)| a == b).count();
        chains.iter_mut().for_each(|chain| drop(chain.drain(..shared)));
        Self { bodies, chains }
    }

    /// The side of the first body by the names of the links, or else of the joints.
    pub(crate) fn side(&self, skeleton: &Skeleton) -> Option<Side> {
        let [a, b] = self.bodies;
        let by_links = side_of(skeleton.link_name(a), skeleton.link_name(b));
        let joints = [a, b].map(|at| skeleton.joint_name(at));
        let by_joints = || match joints {
            [Some(a), Some(b)] => side_of(a, b),
            _ => None,
        };
        by_links.or_else(by_joints)
    }

    /// The same pair, its left body first.
    pub(crate) fn sorted(mut self, side: Side) -> Self {
        if side == Side::Right {
            self.bodies.reverse();
            self.chains.reverse();
        }
        self
    }
}

/// Whether the joints of two chains lie on both sides of one upright plane.
fn is_mirrored(skeleton: &Skeleton, poses: &[Pose], a: &[NodeIndex], b: &[NodeIndex]) -> bool {
    let points = |chain: &[NodeIndex]| -> Vec<DVec3> {
        chain.iter().map(|node| skeleton.joint_point(poses, *node)).collect()
    };
    let (a, b) = (points(a), points(b));
    let across: Vec<DVec3> = a.iter().zip(&b).map(|(a, b)| *a - *b).collect();
    let Some(widest) = across.iter().copied().reduce(|widest, line| {
        if line.length_squared() > widest.length_squared() { line } else { widest }
    }) else {
        return false;
    };
    let Some(normal) = widest.with_z(0.0).try_normalize() else { return false };
    let middle = |at: usize| 0.5 * (a[at] + b[at]);
    let plane = middle(0).dot(normal);
    across.iter().enumerate().all(|(at, line)| {
        let gap = line.reject_from_normalized(normal).length();
        let allowed = (MIRROR_TURN_MAX * line.length()).max(MIRROR_GAP_MAX);
        gap <= allowed && (middle(at).dot(normal) - plane).abs() <= MIRROR_GAP_MAX
    })
}

/// All pairs of bodies that mirror each other and have this many moving joints each for themselves.
pub(crate) fn mirrored_pairs(
    skeleton: &Skeleton,
    poses: &[Pose],
    joints_min: usize,
) -> Vec<MirroredPair> {
    let moving: Vec<NodeIndex> = skeleton.moving().collect();
    let pairs = moving
        .iter()
        .enumerate()
        .flat_map(|(at, a)| moving[at + 1..].iter().map(move |b| [*a, *b]));
    pairs.filter_map(|bodies| MirroredPair::new(skeleton, poses, bodies, joints_min)).collect()
}

/// Feet that the URDF gives no shapes: the lowest mirrored pair without any, if it lies below all
/// shapes, or below what stands of a leg that is too short without it.
pub(crate) fn bare_feet<'a>(
    skeleton: &Skeleton,
    shapes: &LinkShapes,
    poses: &[Pose],
    pairs: &'a [MirroredPair],
    standing: &[MirroredPair],
) -> Option<&'a MirroredPair> {
    let ground = (0..poses.len())
        .map(|node| span_of(skeleton, shapes, poses, node)[0])
        .fold(f64::INFINITY, f64::min);
    let height = |pair: &MirroredPair| poses[pair.bodies[0]].translation.z;
    let ends_leg_of = |pair: &MirroredPair, standing: &MirroredPair| {
        let is_below = skeleton.is_below(pair.bodies[0], standing.bodies[0]);
        is_below && standing.chains[0].len() < LEG_JOINTS[0]
    };
    let is_bare = |pair: &MirroredPair| shapes.surface(skeleton, pair.bodies[0]).is_empty();
    let is_foot = |pair: &MirroredPair| match standing {
        [] => height(pair) < ground,
        _ => standing.iter().any(|other| ends_leg_of(pair, other)),
    };
    let bare = pairs.iter().filter(|pair| is_bare(pair) && is_foot(pair));
    // Of an ankle and the foot that turns about the same point, the foot.
    bare.min_by(|a, b| height(a).total_cmp(&height(b)).then(b.bodies[0].cmp(&a.bodies[0])))
}

/// Those of the `pairs` that reach the ground where all joints stand at 0. Of several in one leg,
/// as a foot and its toes, the one with the larger sole.
pub(crate) fn standing_pairs(
    skeleton: &Skeleton,
    shapes: &LinkShapes,
    poses: &[Pose],
    pairs: &[MirroredPair],
) -> Vec<MirroredPair> {
    let heights: Vec<[f64; 2]> =
        (0..poses.len()).map(|node| span_of(skeleton, shapes, poses, node)).collect();
    let ground = heights.iter().map(|[low, _]| *low).fold(f64::INFINITY, f64::min);
    let top = heights.iter().map(|[_, high]| *high).fold(f64::NEG_INFINITY, f64::max);
    let reach = ground + GROUND_SHARE * (top - ground);
    let mut found: Vec<(f64, MirroredPair)> = Vec::new();
    for pair in pairs {
        if pair.bodies.iter().any(|body| heights[*body][0] > reach) {
            continue;
        }
        let area = sole_area(skeleton, shapes, poses, pair.bodies[0]);
        let in_same_leg = |other: &MirroredPair| {
            let [a, b] = [pair.bodies[0], other.bodies[0]];
            skeleton.is_below(a, b) || skeleton.is_below(b, a)
        };
        match found.iter_mut().find(|(_, other)| in_same_leg(other)) {
            Some(known) if area > known.0 => *known = (area, pair.clone()),
            Some(_) => {}
            None => found.push((area, pair.clone())),
        }
    }
    found.into_iter().map(|(_, pair)| pair).collect()
}

/// The lowest and the highest point of a body; infinite for one without shapes.
fn span_of(skeleton: &Skeleton, shapes: &LinkShapes, poses: &[Pose], body: NodeIndex) -> [f64; 2] {
    let surface = shapes.surface(skeleton, body);
    let down = poses[body].rotation.inverse() * DVec3::NEG_Z;
    let height = poses[body].translation.z;
    if surface.is_empty() {
        return [f64::INFINITY, f64::NEG_INFINITY];
    }
    [height - surface.extent(down), height + surface.extent(-down)]
}

fn sole_area(skeleton: &Skeleton, shapes: &LinkShapes, poses: &[Pose], body: NodeIndex) -> f64 {
    let turn = poses[body].rotation.inverse();
    let surface = shapes.surface(skeleton, body);
    find_sole(&surface, turn * DVec3::NEG_Z, turn * DVec3::X).map_or(0.0, |sole| sole.area)
}
