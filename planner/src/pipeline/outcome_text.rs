//! How a search ended, as a line for a person: with the names of shapes, and what was measured
//! where the robot would stand.

use glam::{DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::config::scenario::StancePose;

use crate::collision::model::FootPhase;
use crate::constraints::rejection::Rejection;
use crate::foot_placement::sole_support::NoSupport;
use crate::geometry::bvh::Aabb;
use crate::geometry::polygon::edges;
use crate::pipeline::outcome::{EndpointError, Outcome};
use crate::preparation::planning_context::PlanningContext;

/// Greatest distance of the ground from a sole for which its height is named, m.
const NAMED_DISTANCE_MAX: f64 = 1.0;
/// Half of the height of the plate above a sole in which obstacles are named, m.
const PLATE_HALF_HEIGHT: f64 = 0.009;
/// Points along each side of a sole under which the ground is compared.
const GROUND_SAMPLES: usize = 8;

/// One line that says what ended the search and what to do about it. `ends` are start and goal.
pub(crate) fn describe(
    context: &PlanningContext,
    ends: [&StancePose; 2],
    outcome: &Outcome,
) -> String {
    let text = outcome.describe();
    let details = match outcome {
        Outcome::StartInvalid(error) => details(context, ends[0], error),
        Outcome::GoalInvalid(error) => details(context, ends[1], error),
        Outcome::Impossible(obstruction) => {
            Some(obstruction.describe(&context.constraints.collision))
        }
        _ => None,
    };
    match details {
        Some(details) => format!("{text}: {details}"),
        None => text,
    }
}

/// What was measured where the robot cannot stand.
fn details(
    context: &PlanningContext,
    stance: &StancePose,
    error: &EndpointError,
) -> Option<String> {
    let collision = &context.constraints.collision;
    match *error {
        EndpointError::Unsupported { limb, reason } => {
            let sole = stance.world_from_soles()[limb];
            match reason {
                NoSupport::Penetrates => {
                    let named = obstacle(context, limb, &sole);
                    let height = height_text(context, &sole);
                    let known: Vec<String> = [named, height].into_iter().flatten().collect();
                    match known.is_empty() {
                        true => unevenness(context, limb, &sole),
                        false => Some(known.join("; ")),
                    }
                }
                NoSupport::NothingBelow | NoSupport::TooSteep => {
                    steepness(context, &sole).or_else(|| height_text(context, &sole))
                }
                NoSupport::AreaTooSmall | NoSupport::CentroidNearEdge => {
                    unevenness(context, limb, &sole)
                }
                _ => None,
            }
        }
        EndpointError::FootCollides { limb } => {
            let sole = stance.world_from_soles()[limb];
            let shape = collision.foot_hit(limb, &sole, FootPhase::Stance)?;
            collision.shape_name(shape).map(|name| format!("with '{name}'"))
        }
        EndpointError::NoPosture { rejection: Rejection::Unreachable, .. } => Some(format!(
            "the legs do not reach both soles, whose distance is stance_width = {} m",
            stance.stance_width
        )),
        EndpointError::NoPosture { hit, .. } => hit.map(|hit| collision.describe(hit)),
        EndpointError::UnknownStance => None,
    }
}

/// The shape that stands in the place of a sole.
fn obstacle(context: &PlanningContext, limb: usize, sole: &Pose) -> Option<String> {
    let collision = &context.constraints.collision;
    let polygon = &context.constraints.robot.soles[limb].polygon;
    let low = polygon.iter().copied().reduce(DVec2::min)?;
    let high = polygon.iter().copied().reduce(DVec2::max)?;
    let above = (0.5 * (low + high)).extend(2.0 * PLATE_HALF_HEIGHT);
    let plate = Pose::from_parts(*sole * above, sole.rotation);
    let half_extents = (0.5 * (high - low)).extend(PLATE_HALF_HEIGHT);
    let shape = collision.box_hit(&plate, half_extents)?;
    collision.shape_name(shape).map(|name| format!("'{name}'"))
}

/// The height of the ground under or over a sole.
fn height_text(context: &PlanningContext, sole: &Pose) -> Option<String> {
    let (height, _) = ground_at(context, sole.translation)?;
    let here = sole.translation.z;
    (height - here).abs().gt(&1e-3).then(|| {
        format!("the ground there is at z = {height:.3} m, the sole at z = {:.3} m", here + 0.0)
    })
}

/// How much the height of the ground differs under a sole, if it does.
fn unevenness(context: &PlanningContext, limb: usize, sole: &Pose) -> Option<String> {
    let polygon = &context.constraints.robot.soles[limb].polygon;
    let along_sides = edges(polygon).flat_map(|(a, b)| {
        (0..GROUND_SAMPLES).map(move |k| a.lerp(b, k as f64 / GROUND_SAMPLES as f64))
    });
    let inside = along_sides.flat_map(|at| [at, 0.5 * at]);
    let heights = inside.filter_map(|at| ground_at(context, *sole * at.extend(0.0)));
    let [low, high] = heights
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], (z, _)| [low.min(z), high.max(z)]);
    let difference = 1e3 * (high - low);
    (difference >= 0.1 && difference.is_finite())
        .then(|| format!("the ground under the sole is uneven by at least {difference:.1} mm"))
}

/// The angle of the ground at a sole, if it is too steep.
fn steepness(context: &PlanningContext, sole: &Pose) -> Option<String> {
    let (height, normal_z) = ground_at(context, sole.translation)?;
    let steepest_cos = context.surfaces.steepest_cos;
    let is_steep = normal_z < steepest_cos && (height - sole.translation.z).abs() < 0.1;
    is_steep.then(|| {
        format!(
            "the ground there is {:.1} degrees steep, and the friction holds {:.1}",
            libm::acos(normal_z.clamp(-1.0, 1.0)).to_degrees(),
            libm::acos(steepest_cos.min(1.0)).to_degrees()
        )
    })
}

/// Height and vertical component of the normal of the surface nearest to a point, over or under it,
/// that faces up.
fn ground_at(context: &PlanningContext, at: DVec3) -> Option<(f64, f64)> {
    let surfaces = &context.surfaces;
    let mut nearest: Option<(f64, f64)> = None;
    let reach = DVec3::Z * NAMED_DISTANCE_MAX;
    let column = Aabb { min: at - reach, max: at + reach };
    surfaces.for_each_in(&column, |id| {
        let normal_z = surfaces.normal_z(id);
        let (distance, height) = surfaces.distance_and_height(id, at.truncate());
        let is_nearer =
            nearest.is_none_or(|(known, _)| (height - at.z).abs() < (known - at.z).abs());
        if normal_z > 0.1 && distance <= surfaces.radius(id) && is_nearer {
            nearest = Some((height, normal_z));
        }
    });
    nearest
}
