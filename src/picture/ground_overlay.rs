//! Drawings on the ground: footholds, support polygons, start and goal.

use glam::{DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::plan_format::blocks::{EndBlock, PlanFile};
use surefoot_shared_types::robot::model::RobotModel;

use crate::picture::colour::{Colour, bottleneck_colour, goal_colour, start_colour};
use crate::picture::error::PictureError;
use crate::picture::motion::PlanMotion;
use crate::picture::surface::Surface;

/// How far a foothold's plate lies over the sole's plane, m.
const PLATE_LIFT: f64 = 0.004;
/// How far a support polygon and an end's mark lie over the ground, m.
const SHEET_LIFT: f64 = 0.002;
/// Two stances of a foot nearer than this are the same foothold, m.
const SAME_PLACE: f64 = 1e-4;
/// The radius of an end's mark that has none of its own, m.
const END_RADIUS: f64 = 0.25;
/// The width of an end's ring, m.
const RING_WIDTH: f64 = 0.035;

/// A place where a foot stands.
#[derive(Debug, Clone)]
pub struct Foothold {
    /// Which foot.
    pub limb: usize,
    /// The sole frame.
    pub world_from_sole: Pose,
    /// The sole's outline, world frame.
    pub outline: Vec<DVec3>,
    /// The outline as a plate.
    pub plate: Surface,
    /// The first waypoint at which it is used.
    pub first: usize,
}

/// Consecutive waypoints on the same feet.
#[derive(Debug, Clone)]
pub struct Stance {
    /// First waypoint.
    pub first: usize,
    /// Last waypoint.
    pub last: usize,
    /// The number of feet on the ground.
    pub feet: usize,
    /// Their support polygon: the hull seen from above, world frame.
    pub polygon: Vec<DVec3>,
}

/// Rings on the ground: an end of the walk, or the place where a search failed most often.
#[derive(Debug, Clone)]
pub struct EndpointMarker {
    /// The rings.
    pub rings: Surface,
    /// Their colour.
    pub colour: Colour,
}

impl EndpointMarker {
    /// One ring for the start.
    pub fn start(centre: DVec3) -> Self {
        Self { rings: rings(centre, &[END_RADIUS]), colour: start_colour() }
    }

    /// Two rings for the goal.
    pub fn goal(centre: DVec3) -> Self {
        Self { rings: rings(centre, &[END_RADIUS, 0.55 * END_RADIUS]), colour: goal_colour() }
    }

    /// Three narrow rings for the place where a search failed most often.
    pub fn bottleneck(centre: DVec3) -> Self {
        let radii = [0.6, 0.4, 0.2].map(|share| share * END_RADIUS);
        Self { rings: rings(centre, &radii), colour: bottleneck_colour() }
    }
}

/// The footholds of a plan in the order of their use, and its stances.
pub fn contacts(
    model: &RobotModel,
    plan: &PlanFile,
) -> Result<(Vec<Foothold>, Vec<Stance>), PictureError> {
    let mut footholds: Vec<Foothold> = Vec::new();
    let mut stances = Vec::new();
    for phase in &plan.phases {
        if phase.first > phase.last || phase.last >= plan.waypoints.len() {
            return Err(PictureError::plan(format!(
                "a phase covers waypoints {} to {} of {}",
                phase.first,
                phase.last,
                plan.waypoints.len()
            )));
        }
        let mut corners = Vec::new();
        for contact in &phase.contacts {
            let limb = model.feet.iter().position(|foot| foot.name == contact.foot);
            let limb = limb.ok_or_else(|| {
                PictureError::plan(format!(
                    "a phase stands on '{}', which is no foot of the robot",
                    contact.foot
                ))
            })?;
            let foothold = foothold(model, limb, contact.sole_pose.pose(), phase.first);
            corners.extend(foothold.outline.iter().copied());
            let known = |f: &Foothold| {
                f.limb == limb
                    && (f.world_from_sole.translation - foothold.world_from_sole.translation)
                        .length()
                        < SAME_PLACE
            };
            if !footholds.iter().any(known) {
                footholds.push(foothold);
            }
        }
        stances.push(Stance {
            first: phase.first,
            last: phase.last,
            feet: phase.contacts.len(),
            polygon: hull_from_above(corners),
        });
    }
    Ok((footholds, stances))
}

pub(crate) fn foothold(
    model: &RobotModel,
    limb: usize,
    world_from_sole: Pose,
    first: usize,
) -> Foothold {
    let polygon = &model.feet[limb].polygon;
    let lifted =
        |z: f64| polygon.iter().map(|p| world_from_sole * p.extend(z)).collect::<Vec<DVec3>>();
    Foothold {
        limb,
        world_from_sole,
        outline: lifted(0.0),
        plate: Surface::polygon(&lifted(PLATE_LIFT)),
        first,
    }
}

/// The convex hull of the points' horizontal places, counter-clockwise, each with its own height.
pub(crate) fn hull_from_above(mut points: Vec<DVec3>) -> Vec<DVec3> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut hull = half_hull(points.iter());
    hull.extend(half_hull(points.iter().rev()));
    hull.iter().map(|point| point + DVec3::Z * SHEET_LIFT).collect()
}

/// One side of the hull of sorted points, without its last point.
fn half_hull<'a>(points: impl Iterator<Item = &'a DVec3>) -> Vec<DVec3> {
    let mut side: Vec<DVec3> = Vec::new();
    for &point in points {
        while let [.., a, b] = side[..]
            && (b - a).truncate().perp_dot((point - b).truncate()) <= 0.0
        {
            side.pop();
        }
        side.push(point);
    }
    side.pop();
    side
}

/// The marks of a plan's start (one ring) and goal (two rings).
pub fn endpoint_markers(
    plan: &PlanFile,
    motion: &PlanMotion,
    footholds: &[Foothold],
) -> Vec<EndpointMarker> {
    let (start, start_radius) =
        endpoint_disc(&plan.start, motion.world_from_root(0).translation.truncate());
    let (goal, goal_radius) =
        endpoint_disc(&plan.goal, motion.world_from_root(motion.len() - 1).translation.truncate());
    let start = start.extend(height_near(start, footholds));
    let goal = goal.extend(height_near(goal, footholds));
    let start = rings(start, &[start_radius]);
    let goal = rings(goal, &[goal_radius, 0.55 * goal_radius]);
    vec![
        EndpointMarker { rings: start, colour: start_colour() },
        EndpointMarker { rings: goal, colour: goal_colour() },
    ]
}

/// Centre and radius of an end; `root` is where the plan's own root is then.
fn endpoint_disc(end: &EndBlock, root: DVec2) -> (DVec2, f64) {
    match end {
        EndBlock::Config { .. } => (root, END_RADIUS),
        EndBlock::RootRegion { xy, radius, .. } => {
            ((*xy).into(), radius.clamp(0.6 * END_RADIUS, 4.0 * END_RADIUS))
        }
        EndBlock::Feet { soles, .. } => {
            let sum: DVec2 = soles.values().map(|sole| DVec2::new(sole.xyz[0], sole.xyz[1])).sum();
            (if soles.is_empty() { root } else { sum / soles.len() as f64 }, END_RADIUS)
        }
    }
}

/// The height of the foothold nearest to a place; 0 without footholds.
fn height_near(place: DVec2, footholds: &[Foothold]) -> f64 {
    let soles = footholds.iter().map(|foothold| foothold.world_from_sole.translation);
    let nearest =
        soles.min_by(|a, b| a.truncate().distance(place).total_cmp(&b.truncate().distance(place)));
    nearest.map_or(0.0, |sole| sole.z)
}

/// Flat rings with these outer radii.
fn rings(centre: DVec3, radii: &[f64]) -> Surface {
    const SEGMENTS: u32 = 64;
    let mut vertices = Vec::new();
    let mut faces = Vec::new();
    for &outer in radii {
        let base = vertices.len() as u32;
        for i in 0..SEGMENTS {
            let (sin, cos) =
                libm::sincos(std::f64::consts::TAU * f64::from(i) / f64::from(SEGMENTS));
            let radius = |r: f64| centre + DVec3::new(r * cos, r * sin, SHEET_LIFT);
            vertices.extend([radius((outer - RING_WIDTH).max(0.0)), radius(outer)]);
            let [a, b] = [base + 2 * i, base + 2 * ((i + 1) % SEGMENTS)];
            faces.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
        }
    }
    Surface::new(&(vertices, faces))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hull_from_above_keeps_heights_and_drops_inner_points() {
        let points =
            [[0.0, 0.0, 1.0], [1.0, 0.0, 2.0], [1.0, 1.0, 3.0], [0.0, 1.0, 4.0], [0.5, 0.5, 9.0]]
                .map(DVec3::from_array);
        let hull = hull_from_above(points.to_vec());
        assert_eq!(hull.len(), 4);
        assert!(hull.iter().all(|p| p.z < 5.0 && p.z > 1.0));
        assert!(hull_from_above(Vec::new()).is_empty());
    }
}
