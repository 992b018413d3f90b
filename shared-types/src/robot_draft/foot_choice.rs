//! Chooses the two feet, or says which links could be feet and what to add.

use crate::base::closest::closest;
use crate::base::input_error::InputError;
use crate::base::spatial::Pose;
use crate::robot_draft::body::LinkShapes;
use crate::robot_draft::foot_search::{LEG_JOINTS, MirroredPair, bare_feet, standing_pairs};
use crate::robot_draft::heading::{Heading, HeadingError, heading_of, yaw_of};
use crate::robot_draft::mirror::Side;
use crate::robot_draft::options::DraftOptions;
use crate::robot_draft::skeleton::{NodeIndex, Skeleton};

/// Most candidates that a message names.
const CANDIDATES_MAX: usize = 4;
/// The element that messages about the choice name.
const ELEMENT: &str = "feet";

/// The feet that the user names, or the only ones of the mirrored `pairs` that the robot can stand
/// on.
///
/// # Errors
/// None or several pairs could be feet, or left and right cannot be distinguished.
pub(crate) fn choose_feet(
    skeleton: &Skeleton,
    shapes: &LinkShapes,
    poses: &[Pose],
    pairs: &[MirroredPair],
    options: &DraftOptions,
) -> Result<Heading, InputError> {
    if let Some(names) = &options.feet {
        let feet = named_feet(skeleton, names)?;
        let yaw = yaw_of(skeleton, poses, &feet);
        return Ok(Heading { feet, yaw, source: "the left and the right foot that were named" });
    }
    let mut standing = standing_pairs(skeleton, shapes, poses, pairs);
    if let Some(pair) = bare_feet(skeleton, shapes, poses, pairs, &standing) {
        return Err(complaint(skeleton, bare_feet_message(skeleton, pair)));
    }
    let feet = match standing.len() {
        1 => standing.remove(0),
        0 => return Err(no_feet(skeleton, poses, pairs)),
        _ => return Err(several_feet(skeleton, &standing)),
    };
    let side = feet.side(skeleton).unwrap_or(Side::Left);
    let sorted = feet.clone().sorted(side);
    heading_of(skeleton, shapes, poses, feet)
        .map_err(|error| complaint(skeleton, heading_message(skeleton, error, &sorted)))
}

/// What feet without shapes lack; a shape alone helps no leg that is too short.
fn bare_feet_message(skeleton: &Skeleton, pair: &MirroredPair) -> String {
    let [left, right] = pair.bodies.map(|body| skeleton.link_name(body));
    let (joints, [least, most]) = (pair.chains[0].len(), LEG_JOINTS);
    if joints < least {
        return format!(
            "'{left}' and '{right}' lie lowest, and each leg has {joints} moving joints; {least} to {most} are needed to place a sole freely, so this robot is not supported"
        );
    }
    format!(
        "'{left}' and '{right}' lie lowest and have no shape, and soles are found on shapes; add a <collision> to them in the URDF"
    )
}

fn heading_message(skeleton: &Skeleton, error: HeadingError, feet: &MirroredPair) -> String {
    let [left, right] = feet.bodies.map(|body| skeleton.link_name(body));
    let lines = format!("--feet {left},{right} or --feet {right},{left}");
    match error {
        HeadingError::Unknown => {
            format!("neither names nor toes show which is the left one; add {lines}")
        }
        HeadingError::Contradiction => {
            format!(
                "'{left}' is on the right of the toes' direction; add {lines}, the left one first"
            )
        }
    }
}

fn complaint(skeleton: &Skeleton, message: String) -> InputError {
    InputError::element(&skeleton.urdf.source.path, ELEMENT, message)
}

fn line_of(skeleton: &Skeleton, pair: &MirroredPair) -> String {
    let sorted = pair.side(skeleton).map_or(pair.clone(), |side| pair.clone().sorted(side));
    let [left, right] = sorted.bodies.map(|body| skeleton.link_name(body));
    format!("--feet {left},{right}")
}

fn named_feet(skeleton: &Skeleton, names: &[String; 2]) -> Result<MirroredPair, InputError> {
    let body = |name: &String| -> Result<NodeIndex, InputError> {
        let nodes = 0..skeleton.nodes.len();
        let node =
            nodes.clone().find(|node| skeleton.link_name(*node) == name).ok_or_else(|| {
                let known = nodes.map(|node| skeleton.link_name(node));
                let meant = closest(name, known).map(|meant| format!("; did you mean '{meant}'?"));
                complaint(skeleton, format!("no link '{name}'{}", meant.unwrap_or_default()))
            })?;
        Ok(skeleton.body(node))
    };
    let bodies = [body(&names[0])?, body(&names[1])?];
    if bodies[0] == bodies[1] {
        let message = format!("'{}' and '{}' are fixed to each other", names[0], names[1]);
        return Err(complaint(skeleton, message + "; name the links of two feet"));
    }
    let pair = MirroredPair::unchecked(skeleton, bodies);
    if pair.chains.iter().any(Vec::is_empty) {
        let message = format!("'{}' and '{}' are in one leg", names[0], names[1]);
        return Err(complaint(skeleton, message + "; name the links of two feet"));
    }
    Ok(pair)
}

fn several_feet(skeleton: &Skeleton, pairs: &[MirroredPair]) -> InputError {
    let lines: Vec<String> =
        pairs.iter().take(CANDIDATES_MAX).map(|pair| line_of(skeleton, pair)).collect();
    let message = format!(
        "{} pairs of links reach the ground, and a biped has one; add one of: {}",
        pairs.len(),
        lines.join(" | ")
    );
    complaint(skeleton, message)
}

/// No pair reaches the ground: the lowest pairs are named.
fn no_feet(skeleton: &Skeleton, poses: &[Pose], pairs: &[MirroredPair]) -> InputError {
    if pairs.is_empty() {
        let message = "no two links mirror each other where all joints stand at 0, as feet do; add --feet LEFT,RIGHT with the links of two feet";
        return complaint(skeleton, message.to_owned());
    }
    let height = |pair: &MirroredPair| poses[pair.bodies[0]].translation.z;
    let mut pairs = pairs.to_vec();
    pairs.sort_by(|a, b| height(a).total_cmp(&height(b)));
    let lines: Vec<String> =
        pairs.iter().take(CANDIDATES_MAX).map(|pair| line_of(skeleton, pair)).collect();
    let message = format!(
        "no two links that mirror each other reach the ground where all joints stand at 0; add one of: {}",
        lines.join(" | ")
    );
    complaint(skeleton, message)
}
