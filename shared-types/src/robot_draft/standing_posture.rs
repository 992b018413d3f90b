//! A standing posture: knees bent, soles level below the hips, the centre of mass above them.

use glam::{DQuat, DVec2, DVec3};

use crate::base::spatial::{Pose, rotation_about};
use crate::robot_draft::leg_ik::{FrameTarget, usable_range};
use crate::robot_draft::skeleton::{NodeIndex, Skeleton};

/// Bends of the knees that are tried in this order, rad.
const KNEE_BENDS: [f64; 5] = [0.5, 0.6, 0.4, 0.8, 0.3];
/// A joint that turns about the lateral axis to at least this cosine bends the leg.
const PITCH_COS_MIN: f64 = 0.7;
/// Rounds of moving the soles below the centre of mass.
const BALANCE_ROUNDS: usize = 4;
/// How far the soles may lie ahead of the hips or behind them, as a share of the hips' height.
const OFFSET_SHARE_MAX: f64 = 0.15;
/// Least distance between both soles, m.
const SOLE_GAP_MIN: f64 = 0.03;

/// A leg of the draft.
#[derive(Debug, Clone)]
pub(crate) struct DraftLeg {
    /// The nodes of its own moving joints, hip first.
    pub(crate) chain: Vec<NodeIndex>,
    pub(crate) body: NodeIndex,
    pub(crate) body_from_sole: Pose,
    /// Whether the polygon is what lies between balls of the collision shapes.
    pub(crate) stands_on_balls: bool,
    /// In the sole frame.
    pub(crate) polygon: Vec<DVec2>,
}

/// The positions of all nodes' joints as the robot stands, and the bend of its knees.
#[derive(Debug, Clone)]
pub(crate) struct StandingPosture {
    pub(crate) positions: Vec<f64>,
    /// Signed rotation about the lateral axis, rad.
    pub(crate) knee_bend: f64,
}

/// A robot with its legs, seen along its heading.
pub(crate) struct StandingSearch<'a> {
    pub(crate) skeleton: &'a Skeleton<'a>,
    pub(crate) legs: &'a [DraftLeg; 2],
    /// The angle of the robot's forward direction about the root's z, rad.
    pub(crate) yaw: f64,
}

/// Where the soles go, in the frame of the heading.
struct Targets {
    /// Forward, per leg.
    x: [f64; 2],
    /// To the left, per leg.
    y: [f64; 2],
    z: f64,
}

impl StandingSearch<'_> {
    /// The first posture that places both soles, with the other joints at `neutral`; the bend
    /// `first` is tried before the others.
    pub(crate) fn solve(&self, neutral: &[f64], first: Option<f64>) -> Option<StandingPosture> {
        first.iter().chain(&KNEE_BENDS).find_map(|bend| self.with_bend(neutral, *bend))
    }

    fn heading(&self) -> DQuat {
        rotation_about(DVec3::Z, self.yaw)
    }

    fn with_bend(&self, neutral: &[f64], bend: f64) -> Option<StandingPosture> {
        let mut positions = neutral.to_vec();
        let knee_bend = self.bend(&self.legs[0], bend, &mut positions)?;
        self.bend(&self.legs[1], bend, &mut positions)?;
        let mut targets = self.targets(neutral, bend);
        for _ in 0..BALANCE_ROUNDS {
            self.place(&targets, &mut positions).then_some(())?;
            self.balance(&mut targets, &positions);
        }
        self.place(&targets, &mut positions).then_some(())?;
        Some(StandingPosture { positions, knee_bend })
    }

    /// The joints of a leg that turn about the lateral axis, with their sense.
    fn pitch_joints(&self, leg: &DraftLeg, poses: &[Pose]) -> Vec<(NodeIndex, f64)> {
        let lateral = self.heading() * DVec3::Y;
        let sense = |node: NodeIndex| {
            let axis = self.skeleton.nodes[node].joint.as_ref()?.axis;
            let along = (poses[node].rotation * axis).dot(lateral);
            (along.abs() >= PITCH_COS_MIN).then(|| (node, along.signum()))
        };
        leg.chain.iter().filter_map(|node| sense(*node)).collect()
    }

    /// The pitch joints of a leg and the place of the knee among them: the one nearest to the
    /// middle between hip and ankle.
    fn knee(&self, leg: &DraftLeg, poses: &[Pose]) -> Option<(Vec<(NodeIndex, f64)>, usize)> {
        let pitch = self.pitch_joints(leg, poses);
        let height = |node: NodeIndex| poses[node].translation.z;
        let middle = 0.5 * (height(*leg.chain.first()?) + height(*leg.chain.last()?));
        let off_middle = |at: usize| (height(pitch[at].0) - middle).abs();
        let knee = (0..pitch.len()).min_by(|a, b| off_middle(*a).total_cmp(&off_middle(*b)))?;
        Some((pitch, knee))
    }

    /// Bends a knee, and turns the pitch joints before and after it back by half of it each.
    /// Returns the bend; `None` for a leg without a knee.
    fn bend(&self, leg: &DraftLeg, bend: f64, positions: &mut [f64]) -> Option<f64> {
        let (pitch, at) = self.knee(leg, &self.skeleton.poses(positions))?;
        let (knee, sense) = pitch[at];
        let range_left = |sign: f64| {
            let (lower, upper) = usable_range(self.skeleton, knee);
            if sign * sense > 0.0 { upper - positions[knee] } else { positions[knee] - lower }
        };
        // Knees bend forward where their limits let them, as a rotation to the left does.
        let sign = if range_left(1.0) >= bend.min(range_left(-1.0)) { 1.0 } else { -1.0 };
        let before = at.checked_sub(1).map(|hip| (pitch[hip], -0.5));
        let after = pitch.get(at + 1).map(|ankle| (*ankle, -0.5));
        for ((node, sense), share) in before.into_iter().chain([(pitch[at], 1.0)]).chain(after) {
            let (lower, upper) = usable_range(self.skeleton, node);
            positions[node] = (positions[node] + sign * sense * share * bend).clamp(lower, upper);
        }
        Some(sign * bend)
    }

    /// Soles below the hips, as far apart as where all joints stand at 0, and as much higher as
    /// bent knees lift them: thigh and shank are taken for equally long.
    fn targets(&self, neutral: &[f64], bend: f64) -> Targets {
        let heading = self.heading().inverse();
        let poses = self.skeleton.poses(neutral);
        let hips = self.legs.each_ref().map(|leg| self.hip(leg, &poses));
        let soles = self
            .legs
            .each_ref()
            .map(|leg| heading * (poses[leg.body] * leg.body_from_sole).translation);
        let [left, right] = soles.map(|sole| sole.y);
        let middle = 0.5 * (hips[0].y + hips[1].y);
        let half = (0.5 * (left - right)).max(self.half_width_min());
        let ankle =
            |leg: &DraftLeg| leg.chain.last().map_or(0.0, |node| poses[*node].translation.z);
        let lift =
            |limb: usize| (hips[limb].z - ankle(&self.legs[limb])) * (1.0 - libm::cos(0.5 * bend));
        Targets {
            x: hips.map(|hip| hip.x),
            y: [middle + half, middle - half],
            z: 0.5 * (soles[0].z + lift(0) + soles[1].z + lift(1)),
        }
    }

    /// The first pitch joint of a leg, in the frame of the heading.
    fn hip(&self, leg: &DraftLeg, poses: &[Pose]) -> DVec3 {
        let first = self.pitch_joints(leg, poses).first().map(|(node, _)| *node);
        let node = first.unwrap_or(leg.chain[0]);
        self.heading().inverse() * poses[node].translation
    }

    /// Half of the distance between the sole frames at which the soles do not overlap, m.
    fn half_width_min(&self) -> f64 {
        let inner = |leg: &DraftLeg, sign: f64| {
            leg.polygon.iter().map(|corner| -sign * corner.y).fold(f64::NEG_INFINITY, f64::max)
        };
        0.5 * (inner(&self.legs[0], 1.0) + inner(&self.legs[1], -1.0) + SOLE_GAP_MIN)
    }

    fn place(&self, targets: &Targets, positions: &mut [f64]) -> bool {
        let heading = self.heading();
        let place = |(limb, leg): (usize, &DraftLeg), positions: &mut [f64]| {
            let at = DVec3::new(targets.x[limb], targets.y[limb], targets.z);
            let target = FrameTarget {
                chain: &leg.chain,
                body: leg.body,
                body_from_frame: leg.body_from_sole,
                root_from_target: Pose::from_parts(heading * at, heading),
            };
            target.solve(self.skeleton, positions)
        };
        self.legs.iter().enumerate().all(|leg| place(leg, positions))
    }

    /// Moves the targets forward or back until the middles of the soles lie below the centre of
    /// mass, as far as the hips allow.
    fn balance(&self, targets: &mut Targets, positions: &[f64]) {
        let poses = self.skeleton.poses(positions);
        let com = self.heading().inverse() * self.skeleton.centre_of_mass(&poses);
        for (limb, leg) in self.legs.iter().enumerate() {
            let corners = leg.polygon.iter().map(|corner| corner.x);
            let low = corners.clone().fold(f64::INFINITY, f64::min);
            let middle = 0.5 * (low + corners.fold(f64::NEG_INFINITY, f64::max));
            let hip = self.hip(leg, &poses);
            let most = OFFSET_SHARE_MAX * (hip.z - targets.z).abs();
            targets.x[limb] = (com.x - middle).clamp(hip.x - most, hip.x + most);
        }
    }
}
