//! How deep two links of the robot may overlap, decided from the robot alone.
//!
//! Links without a joint between them do not move against each other and are not checked. Links at
//! most three joints apart whose covers overlap in the standing posture are not checked either: the
//! overlap about a joint grows as the joint bends. Any other pair that overlaps in the standing
//! posture may overlap as deep as there, and all pairs that are clear there must stay apart. Joints
//! that are locked separate links, too.

use std::collections::BTreeMap;

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::robot::model::{LinkIndex, RobotModel};

use crate::geometry::body::{CollisionBody, SolidPose};
use crate::geometry::penetration::body_separation;
use crate::kinematics::forward::{Configuration, Posture};

/// Covers of links this many joints apart may overlap as the joints bend: a hip, an ankle or a
/// wrist has up to three joints.
const NEAR_MAX: usize = 3;
/// Depths are allowed with this rounding, m.
const DEPTH_ROUNDING: f64 = 1e-6;

/// The depth that each pair of bodies may overlap, m; infinite for a pair that is not checked, and
/// no entry for bodies of one rigid piece. The smaller index of the bodies comes first.
pub type AllowedDepths = BTreeMap<(usize, usize), f64>;

/// The allowed depths of all pairs of bodies with a joint between them. `model` has its locked
/// joints as joints.
pub fn allowed_depths(model: &RobotModel, bodies: &[CollisionBody]) -> AllowedDepths {
    let posture = standing_posture(model);
    let placed: Vec<Option<(LinkIndex, SolidPose)>> = bodies
        .iter()
        .map(|body| {
            body.link.map(|link| (link, SolidPose::new(body, &posture.world_from_link[link])))
        })
        .collect();
    let mut depths = AllowedDepths::new();
    for (first, second) in
        (0..bodies.len()).flat_map(|a| (a + 1..bodies.len()).map(move |b| (a, b)))
    {
        let (Some((a, at)), Some((b, there))) = (&placed[first], &placed[second]) else { continue };
        let apart = if a == b { 0 } else { joints_apart(model, (*a, *b)) };
        if apart == 0 {
            continue;
        }
        let direction = (there.bounds.centre() - at.bounds.centre()).normalize_or(DVec3::X);
        let solids = ((&bodies[first].solid, at), (&bodies[second].solid, there));
        let distance = body_separation(solids.0, solids.1, direction, 0.0).distance;
        let depth = match apart {
            _ if distance >= 0.0 => 0.0,
            1..=NEAR_MAX => f64::INFINITY,
            _ => DEPTH_ROUNDING - distance,
        };
        depths.insert((first, second), depth);
    }
    depths
}

/// The pairs that may overlap, one line each, with the reason.
pub fn describe(depths: &AllowedDepths, bodies: &[CollisionBody]) -> Vec<String> {
    let mut lines: Vec<String> = depths
        .iter()
        .filter(|(_, depth)| **depth > 0.0)
        .map(|(&(a, b), depth)| {
            let (a, b) = (&bodies[a].name, &bodies[b].name);
            if depth.is_infinite() {
                return format!("may overlap: {a} and {b}, near each other, as when standing");
            }
            let depth = 1e3 * depth;
            format!("may overlap: {a} and {b}, by {depth:.1} mm as when standing")
        })
        .collect();
    lines.dedup();
    lines
}

/// The standing posture of a robot whose root is at the origin. Locked joints stand at their
/// positions.
fn standing_posture(model: &RobotModel) -> Posture {
    let q = model.standing_q.clone();
    Posture::new(model, &Configuration { world_from_root: Pose::IDENTITY, q })
}

/// The joints between two links.
fn joints_apart(model: &RobotModel, (a, b): (LinkIndex, LinkIndex)) -> usize {
    let (first, second) = (model.chain(a), model.chain(b));
    let shared = first.iter().zip(&second).take_while(|(x, y)| x == y).count();
    first.len() + second.len() - 2 * shared
}
