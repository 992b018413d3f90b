//! The pose in which a rigid sole rests: on three points around its centroid.

use glam::{DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::yaw_of;

use crate::foot_placement::elements::Element;
use crate::foot_placement::plane_features::pose_on_plane;
use crate::foot_placement::posed_sole::PosedSole;
use crate::foot_placement::scratch::Scratch;
use crate::foot_placement::surfaces::Surfaces;
use crate::foot_placement::tuning::REST_ITERATIONS;
use crate::geometry::polygon::{area_and_centroid, clip_to_sides, cross};

/// Most replacements of a corner of the triangle below a sole.
const CLIMBS_MAX: usize = 48;
/// Height above the plane of rest up to which a point counts as below it, m.
const REST_SLACK: f64 = 1e-6;
/// Twice the area of the smallest triangle that a sole rests on, m2.
const AREA_MIN: f64 = 1e-8;
/// The corners of the first triangle, below all ground and around every sole, m.
const BELOW: [DVec3; 3] = [
    DVec3::new(-20.0, -10.0, -100.0),
    DVec3::new(20.0, -10.0, -100.0),
    DVec3::new(0.0, 20.0, -100.0),
];

/// A sole that is set down.
pub(crate) struct SoleToRest<'a> {
    /// Its outline in the sole frame, m.
    pub outline: &'a [DVec2],
    /// Where it is set down, m.
    pub position: DVec3,
    /// Its heading, rad.
    pub yaw: f64,
    /// The lowest and highest ground relative to the position, m.
    pub reach_z: [f64; 2],
}

/// The pose at which a sole rests when it is set down; `None` where no ground is below its
/// centroid or the ground is too steep.
pub(crate) fn rest_pose(
    surfaces: &Surfaces,
    scratch: &mut Scratch,
    sole: &SoleToRest,
) -> Option<Pose> {
    let &SoleToRest { outline, position, yaw, reach_z } = sole;
    let level = pose_on_plane(position, DVec3::Z, yaw);
    set_to_rest(surfaces, scratch, outline, (&level, reach_z))
}

/// The pose in which a sole comes to rest from one in which it touches the ground; `None` as for
/// [`rest_pose`].
pub(crate) fn rest_from(
    surfaces: &Surfaces,
    scratch: &mut Scratch,
    outline: &[DVec2],
    touching: &Pose,
) -> Option<Pose> {
    set_to_rest(surfaces, scratch, outline, (touching, near(surfaces)))
}

/// Lowest and highest ground near a sole that touches it, relative to the sole, m.
fn near(surfaces: &Surfaces) -> [f64; 2] {
    [-surfaces.config().plate_height, surfaces.config().plate_height]
}

/// The pose in which a sole rests that is set down from `pose` on the ground between two heights
/// relative to it, m.
fn set_to_rest(
    surfaces: &Surfaces,
    scratch: &mut Scratch,
    outline: &[DVec2],
    (pose, mut heights): (&Pose, [f64; 2]),
) -> Option<Pose> {
    let (position, yaw, middle) =
        (pose.translation, yaw_of(pose.rotation), area_and_centroid(outline).1);
    let mut pose = *pose;
    for _ in 0..REST_ITERATIONS {
        gather_ground(surfaces, scratch, outline, &pose, heights);
        let [a, b, c] = resting_triangle(&scratch.ground, middle)?.map(|point| pose * point);
        let normal = (b - a).cross(c - a).normalize();
        if !surfaces.is_flat_enough(normal) {
            return None;
        }
        let height = a.z - normal.truncate().dot(position.truncate() - a.truncate()) / normal.z;
        pose = pose_on_plane(position.truncate().extend(height), normal, yaw);
        heights = near(surfaces);
    }
    Some(pose)
}

/// Fills `scratch.ground` with the corners, in the sole frame, of all surfaces under the sole
/// between two heights relative to it, m.
fn gather_ground(
    surfaces: &Surfaces,
    scratch: &mut Scratch,
    outline: &[DVec2],
    world_from_sole: &Pose,
    [lowest, highest]: [f64; 2],
) {
    scratch.ground.clear();
    let sole = PosedSole::new(outline, world_from_sole);
    let region = sole.region(lowest, highest);
    for id in surfaces.elements_in(&region).take(surfaces.config().support_elements_max) {
        scratch.clip.polygon.clear();
        match surfaces.element(id) {
            Element::Face(face, vertices) if face.normal.z > 0.0 => {
                scratch.clip.polygon.extend(vertices.iter().map(|&v| sole.in_sole(v)));
            }
            Element::Face(..) => {}
            Element::Curved(curved) => {
                let normal = curved.side_normal(world_from_sole.rotation * DVec3::Z);
                let line = normal.map(|normal| curved.line_with_normal(normal));
                scratch
                    .clip
                    .polygon
                    .extend(line.into_iter().flatten().map(|end| sole.in_sole(end)));
            }
        }
        clip_to_sides(&mut scratch.clip, &sole.sides, 0.0);
        scratch.clip.polygon.iter().for_each(|&point| scratch.ground.push(point));
    }
}

/// The three of some points whose plane passes under `middle` and has no point above it. A
/// triangle under `middle` repeatedly takes the point that is highest above it as a corner, until
/// no point is above it.
fn resting_triangle(points: &[DVec3], middle: DVec2) -> Option<[DVec3; 3]> {
    let mut triangle = BELOW;
    for _ in 0..CLIMBS_MAX {
        let above = height_above(triangle);
        let (height, highest) =
            points.iter().map(|p| (above(p), p)).max_by(|a, b| a.0.total_cmp(&b.0))?;
        if height <= REST_SLACK {
            return triangle.iter().all(|corner| !BELOW.contains(corner)).then_some(triangle);
        }
        triangle = climbed(&triangle, *highest, middle)?;
    }
    None
}

/// The triangle with a point in place of that corner whose loss keeps `middle` deepest inside.
fn climbed(triangle: &[DVec3; 3], point: DVec3, middle: DVec2) -> Option<[DVec3; 3]> {
    let replaced = [0, 1, 2].map(|corner| {
        let mut climbed = *triangle;
        climbed[corner] = point;
        climbed
    });
    let depth = |triangle: &[DVec3; 3]| {
        let [a, b, c] = triangle.map(|corner| corner.truncate());
        let area = cross(a, b, c);
        if area > AREA_MIN {
            cross(a, b, middle).min(cross(b, c, middle)).min(cross(c, a, middle)) / area
        } else {
            f64::NEG_INFINITY
        }
    };
    let best = replaced.into_iter().max_by(|a, b| depth(a).total_cmp(&depth(b)))?;
    (depth(&best) >= -1e-9).then_some(best)
}

/// The height of a point above a triangle's plane along z, m, as a function of the point.
fn height_above([a, b, c]: [DVec3; 3]) -> impl Fn(&DVec3) -> f64 {
    let normal = (b - a).cross(c - a);
    let slope = normal.truncate() / normal.z;
    move |p| p.z - a.z + slope.dot((p - a).truncate())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::{Random, Stream};

    #[test]
    fn a_sole_rests_on_three_points_around_its_centroid_with_no_point_above_them() {
        let mut random = Random::new(1, Stream::FootPlacement, 0, 0);
        for _ in 0..200 {
            let points: Vec<DVec3> = (0..60)
                .map(|_| {
                    DVec3::from_array([0.1, 0.1, 0.02].map(|side| random.uniform(-side, side)))
                })
                .collect();
            let Some(triangle) = resting_triangle(&points, DVec2::ZERO) else { continue };
            assert!(points.iter().all(|p| height_above(triangle)(p) <= REST_SLACK));
            let [a, b, c] = triangle.map(|corner| corner.truncate());
            let sides =
                [cross(a, b, DVec2::ZERO), cross(b, c, DVec2::ZERO), cross(c, a, DVec2::ZERO)];
            assert!(sides.iter().all(|side| *side >= -1e-9), "{sides:?}");
        }
    }

    #[test]
    fn a_centroid_with_ground_on_one_side_only_has_no_rest_pose() {
        let points = [
            DVec3::new(0.1, 0.0, 0.0),
            DVec3::new(0.2, 0.1, 0.0),
            DVec3::new(0.2, -0.1, 0.1),
            DVec3::new(0.3, 0.0, 0.0),
        ];
        assert_eq!(resting_triangle(&points, DVec2::ZERO), None);
        assert_eq!(resting_triangle(&[], DVec2::ZERO), None);
    }
}
