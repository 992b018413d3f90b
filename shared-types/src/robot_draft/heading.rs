//! Which way a robot looks: from its left and its right foot, and from its toes.

use glam::DVec3;

use crate::base::spatial::Pose;
use crate::robot_draft::body::LinkShapes;
use crate::robot_draft::foot_search::MirroredPair;
use crate::robot_draft::mirror::Side;
use crate::robot_draft::skeleton::{NodeIndex, Skeleton};
use crate::robot_draft::sole_search::find_sole;

/// Headings this near to an axis of the root are that axis, rad.
const SNAP: f64 = 0.03;
/// How far the middle of a sole lies ahead of its ankle to show where the toes are, as a share of
/// the sole's length.
const TOES_SHARE_MIN: f64 = 0.05;

/// The feet, left first, and the heading of the robot in the root's frame.
#[derive(Debug, Clone)]
pub(crate) struct Heading {
    pub(crate) feet: MirroredPair,
    /// The angle of the robot's forward direction about the root's z, rad.
    pub(crate) yaw: f64,
    /// What shows it.
    pub(crate) source: &'static str,
}

/// Why left and right cannot be distinguished.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum HeadingError {
    /// The names say nothing, and the soles lie symmetric to their ankles.
    Unknown,
    /// By their names, the robot would walk heels first.
    Contradiction,
}

/// Distinguishes left from right by the names, and by the toes where the names say nothing.
pub(crate) fn heading_of(
    skeleton: &Skeleton,
    shapes: &LinkShapes,
    poses: &[Pose],
    feet: MirroredPair,
) -> Result<Heading, HeadingError> {
    let toes = |feet: &MirroredPair| toes_ahead(skeleton, shapes, poses, feet);
    match feet.side(skeleton) {
        Some(side) => {
            let feet = feet.sorted(side);
            if toes(&feet) == Some(false) {
                return Err(HeadingError::Contradiction);
            }
            Ok(Heading {
                yaw: yaw_of(skeleton, poses, &feet),
                feet,
                source: "the names of left and right",
            })
        }
        None => {
            let ahead = toes(&feet).ok_or(HeadingError::Unknown)?;
            let feet = feet.sorted(if ahead { Side::Left } else { Side::Right });
            Ok(Heading { yaw: yaw_of(skeleton, poses, &feet), feet, source: "the toes" })
        }
    }
}

/// The heading that goes with feet in this order.
pub(crate) fn yaw_of(skeleton: &Skeleton, poses: &[Pose], feet: &MirroredPair) -> f64 {
    let forward = forward_of(skeleton, poses, feet);
    let yaw = libm::atan2(forward.y, forward.x);
    let quarter = std::f64::consts::FRAC_PI_2;
    let snapped = (yaw / quarter).round() * quarter;
    if (yaw - snapped).abs() <= SNAP { snapped } else { yaw }
}

fn forward_of(skeleton: &Skeleton, poses: &[Pose], feet: &MirroredPair) -> DVec3 {
    let [left, right] = feet.bodies.map(|body| skeleton.joint_point(poses, body));
    (left - right).with_z(0.0).normalize_or(DVec3::Y).cross(DVec3::Z)
}

/// The ankle in the frame of the foot.
pub(crate) fn ankle_of(skeleton: &Skeleton, poses: &[Pose], foot: NodeIndex) -> DVec3 {
    poses[foot].inverse() * skeleton.joint_point(poses, foot)
}

/// Whether the toes point where feet in this order look; `None` for symmetric feet.
fn toes_ahead(
    skeleton: &Skeleton,
    shapes: &LinkShapes,
    poses: &[Pose],
    feet: &MirroredPair,
) -> Option<bool> {
    let body = feet.bodies[0];
    let turn = poses[body].rotation.inverse();
    let (down, forward) = (turn * DVec3::NEG_Z, turn * forward_of(skeleton, poses, feet));
    let sole = find_sole(&shapes.surface(skeleton, body), down, forward)?;
    let sole = sole.below(ankle_of(skeleton, poses, body));
    let low = sole.polygon.iter().map(|corner| corner.x).fold(f64::INFINITY, f64::min);
    let high = sole.polygon.iter().map(|corner| corner.x).fold(f64::NEG_INFINITY, f64::max);
    let (middle, length) = (0.5 * (low + high), high - low);
    (middle.abs() > TOES_SHARE_MIN * length).then_some(middle > 0.0)
}
