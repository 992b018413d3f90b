//! Arms that keep clear of the body and hang near it.

use glam::{DQuat, DVec3};
use parry3d_f64::query::distance;
use parry3d_f64::shape::SharedShape;

use crate::base::spatial::{Pose, rotation_about};
use crate::robot::exact_meshes::solid;
use crate::robot_draft::body::LinkShapes;
use crate::robot_draft::leg_ik::usable_range;
use crate::robot_draft::skeleton::{NodeIndex, Skeleton};

/// Turns of the shoulder that are tried, rad.
const SHOULDER_TURNS: [f64; 13] =
    [0.0, 0.1, -0.1, 0.2, -0.2, 0.35, -0.35, 0.6, -0.6, 1.0, -1.0, 1.3, -1.3];
/// Turns of the elbow that are tried, rad.
const ELBOW_TURNS: [f64; 5] = [0.0, 0.4, -0.4, 0.8, -0.8];
/// The clearance that is sought, m.
const CLEARANCE: f64 = 0.03;
/// What a missing clearance costs, all of it.
const CLEARANCE_COST: f64 = 10.0;
/// What a turn costs by radian.
const TURN_COST: f64 = 0.1;
/// Axes this near to a direction lie along it.
const ALONG_MIN: f64 = 0.8;
/// Arm joints among which the shoulder's roll is looked for, or else its pitch; the last of them,
/// or of a shorter arm, is the elbow.
const SHOULDER_JOINTS: usize = 4;

/// A solid of a link, and the sphere around it, in the link's frame.
struct Solid {
    link_from_shape: Pose,
    shape: SharedShape,
    centre: DVec3,
    radius: f64,
}

/// The arms of a robot that stands, and what they must keep clear of.
pub(crate) struct ArmSearch<'a> {
    skeleton: &'a Skeleton<'a>,
    solids: Vec<Vec<Solid>>,
    yaw: f64,
}

impl<'a> ArmSearch<'a> {
    pub(crate) fn new(skeleton: &'a Skeleton<'a>, shapes: &LinkShapes, yaw: f64) -> Self {
        let solids = shapes.collision.iter().map(|parts| {
            let solids = parts.iter().filter_map(|part| {
                let (shape, link_from_shape) = (solid(&part.shape)?, part.link_from_shape);
                let sphere = shape.compute_local_bounding_sphere();
                let (centre, radius) = (link_from_shape * sphere.center, sphere.radius);
                Some(Solid { link_from_shape, shape, centre, radius })
            });
            solids.collect()
        });
        Self { skeleton, solids: solids.collect(), yaw }
    }

    /// Turns shoulders and elbows of a pair of arms. The other joints stay.
    pub(crate) fn clear(&self, arms: &[Vec<NodeIndex>; 2], positions: &mut [f64]) {
        let poses = self.skeleton.poses(positions);
        let [arm, other] = arms;
        let heading = rotation_about(DVec3::Z, self.yaw);
        let near_shoulder = &arm[..arm.len().min(SHOULDER_JOINTS)];
        let shoulder = [DVec3::X, DVec3::Y]
            .iter()
            .find_map(|axis| self.along(near_shoulder, &poses, heading * *axis));
        let elbow = arm.get(SHOULDER_JOINTS - 1).or(arm.last()).copied();
        let elbow = elbow.filter(|elbow| Some(*elbow) != shoulder);
        let obstacles = self.obstacles(arm);
        let mut best: Option<(f64, Vec<f64>)> = None;
        for turn in SHOULDER_TURNS.iter().filter(|turn| shoulder.is_some() || **turn == 0.0) {
            for bend in ELBOW_TURNS.iter().filter(|bend| elbow.is_some() || **bend == 0.0) {
                let mut tried = positions.to_vec();
                for (node, turn) in [(shoulder, *turn), (elbow, *bend)] {
                    let Some(node) = node else { continue };
                    let (lower, upper) = usable_range(self.skeleton, node);
                    tried[node] = (tried[node] + turn).clamp(lower, upper);
                }
                let cost = self.cost(arm, &obstacles, &tried, &heading)
                    + TURN_COST * (turn.abs() + bend.abs());
                if best.as_ref().is_none_or(|(least, _)| cost < *least - 1e-9) {
                    best = Some((cost, tried));
                }
            }
        }
        let Some((_, found)) = best else { return };
        for (node, mirrored) in arm.iter().zip(other) {
            let turn = found[*node] - positions[*node];
            let (lower, upper) = usable_range(self.skeleton, *mirrored);
            if turn != 0.0 {
                positions[*node] = found[*node];
                let turn = self.mirror_sense(*node, *mirrored, &poses, &heading) * turn;
                positions[*mirrored] = (positions[*mirrored] + turn).clamp(lower, upper);
            }
        }
    }

    /// The first joint whose axis lies along a direction.
    fn along(&self, arm: &[NodeIndex], poses: &[Pose], direction: DVec3) -> Option<NodeIndex> {
        arm.iter().copied().find(|node| {
            let axis = self.skeleton.nodes[*node].joint.as_ref().map(|joint| joint.axis);
            axis.is_some_and(|axis| {
                (poses[*node].rotation * axis).dot(direction).abs() >= ALONG_MIN
            })
        })
    }

    /// 1 where the mirrored joint turns by the same angle, -1 where by the opposite one.
    fn mirror_sense(
        &self,
        node: NodeIndex,
        mirrored: NodeIndex,
        poses: &[Pose],
        heading: &DQuat,
    ) -> f64 {
        let axis = |node: NodeIndex| {
            let axis = self.skeleton.nodes[node].joint.as_ref().map_or(DVec3::Z, |it| it.axis);
            heading.inverse() * (poses[node].rotation * axis)
        };
        // A reflection at the plane between both arms turns the other way round.
        let [own, other] = [axis(node), axis(mirrored)];
        DVec3::new(-own.x, own.y, -own.z).dot(other).signum()
    }

    /// Pairs of a node of the arm and one of the rest, with more than one moving joint between.
    fn obstacles(&self, arm: &[NodeIndex]) -> Vec<[NodeIndex; 2]> {
        let skeleton = self.skeleton;
        let has_solid = |node: &NodeIndex| !self.solids[*node].is_empty();
        let nodes: Vec<NodeIndex> = (0..skeleton.nodes.len()).filter(has_solid).collect();
        let (of_arm, rest): (Vec<_>, Vec<_>) =
            nodes.into_iter().partition(|node| skeleton.is_below(*node, arm[0]));
        let base = skeleton.nodes[arm[0]].parent.map(|parent| skeleton.body(parent));
        let are_near = |node: NodeIndex, other: NodeIndex| {
            skeleton.body(node) == arm[0] && Some(skeleton.body(other)) == base
        };
        let pairs = of_arm.iter().flat_map(|node| rest.iter().map(move |other| [*node, *other]));
        pairs.filter(|[node, other]| !are_near(*node, *other)).collect()
    }

    /// Low where the arm is clear of the rest, hangs near the body and is not raised.
    fn cost(
        &self,
        arm: &[NodeIndex],
        obstacles: &[[NodeIndex; 2]],
        positions: &[f64],
        heading: &DQuat,
    ) -> f64 {
        let poses = self.skeleton.poses(positions);
        let missing = |pair: &[NodeIndex; 2]| {
            let nearest = self.distance(*pair, &poses);
            (CLEARANCE - nearest).max(0.0) / CLEARANCE
        };
        let missing: f64 = obstacles.iter().map(missing).sum();
        let (Some(first), Some(last)) = (arm.first(), arm.last()) else { return 0.0 };
        let span = |node: &NodeIndex| heading.inverse() * poses[*node].translation;
        let reach: f64 = arm.windows(2).map(|pair| span(&pair[0]).distance(span(&pair[1]))).sum();
        let (from, to) = (span(first), span(last));
        let (aside, raised) = ((to.y - from.y).abs(), (to.z - from.z).max(0.0));
        CLEARANCE_COST * missing + (aside + raised) / reach.max(f64::MIN_POSITIVE)
    }

    /// The distance of two nodes' shapes, m; infinite where it is more than the clearance.
    fn distance(&self, pair: [NodeIndex; 2], poses: &[Pose]) -> f64 {
        let [first, second] = pair.map(|node| &self.solids[node]);
        let [pose_a, pose_b] = pair.map(|node| poses[node]);
        let mut nearest = f64::INFINITY;
        for a in first {
            for b in second {
                let apart = (pose_a * a.centre).distance(pose_b * b.centre);
                if apart > CLEARANCE + a.radius + b.radius {
                    continue;
                }
                let (from_a, from_b) = (pose_a * a.link_from_shape, pose_b * b.link_from_shape);
                let gap = distance(&from_a, &*a.shape, &from_b, &*b.shape);
                nearest = nearest.min(gap.map_or(0.0, |gap| gap.distance));
            }
        }
        nearest
    }
}
