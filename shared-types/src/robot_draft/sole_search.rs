//! Finds the sole of a foot: the flat face on its underside.

use glam::{DMat3, DQuat, DVec2, DVec3};

use crate::base::limits::POLYGON_VERTICES_MAX;
use crate::base::spatial::Pose;
use crate::geometry::convex_hull::{convex_polygon, hull_triangles, polygon_area};
use crate::robot::surface_points::SurfacePoints;

/// A sole faces at most this far from straight down where all joints stand at 0, rad.
const TILT_MAX: f64 = 0.7;
/// How far points may lie above the lowest one and still belong to the sole, m: first the least.
const THICKNESSES: [f64; 2] = [1e-3, 2.5e-3];
/// A thicker sole has to be this many times as large.
const THICKNESS_GAIN_MIN: f64 = 1.3;
/// A face along an axis of the link is taken unless another one is this many times as large.
const AXIS_GAIN_MIN: f64 = 1.1;
/// Turns below this angle are those of rounding, rad.
const TURN_MIN: f64 = 2e-3;
/// Shifts of a sole's frame below this length are those of rounding, m.
const SHIFT_MIN: f64 = 1e-4;
/// The smallest sole, m2: about that of a coin.
const AREA_MIN: f64 = 5e-4;
/// Balls whose lowest points lie at most this far from the plane of the sole carry it, m.
const BALL_GAP_MAX: f64 = 2e-3;
/// The part of the sole's area by which the balls' points may extend beyond it.
const BALL_EXCESS_MAX: f64 = 0.02;

/// A flat face.
#[derive(Debug, Clone)]
pub(crate) struct FoundSole {
    pub(crate) link_from_sole: Pose,
    /// Convex, in the sole frame.
    pub(crate) polygon: Vec<DVec2>,
    pub(crate) area: f64,
}

impl FoundSole {
    /// The same sole with its frame's origin below a point of the link's frame.
    pub(crate) fn below(mut self, point: DVec3) -> Self {
        let shift = (self.link_from_sole.inverse() * point).truncate();
        if shift.length() > SHIFT_MIN {
            self.link_from_sole.translation += self.link_from_sole.rotation * shift.extend(0.0);
            self.polygon.iter_mut().for_each(|corner| *corner -= shift);
        }
        self
    }
}

/// The largest flat face that looks down. `down` and `forward` are unit vectors in the frame of the
/// link, whose origin is projected onto the sole.
pub(crate) fn find_sole(surface: &SurfacePoints, down: DVec3, forward: DVec3) -> Option<FoundSole> {
    let axes: Vec<DVec3> = [down].into_iter().chain(link_axes()).collect();
    let of_axes = best(surface, &axes, down, forward);
    let of_faces = best(surface, &face_normals(surface), down, forward);
    let found = match (of_axes, of_faces) {
        (Some(axis), Some(face)) if face.area > AXIS_GAIN_MIN * axis.area => Some(face),
        (Some(axis), _) => Some(axis),
        (None, face) => face,
    };
    found.filter(|sole| sole.area >= AREA_MIN)
}

/// The part of a sole of looks that lies between balls, which are what the URDF's collision shapes
/// touch the ground with: simulators let the foot stand on these points. None where they carry no
/// sole, or another one than the looks show. Centres and radii are in the frame of the link, m.
pub(crate) fn carried_by_balls(sole: &FoundSole, balls: &[(DVec3, f64)]) -> Option<Vec<DVec2>> {
    let sole_from_link = sole.link_from_sole.inverse();
    let lowest = balls.iter().map(|(centre, radius)| {
        let centre = sole_from_link * *centre;
        centre - *radius * DVec3::Z
    });
    let touching = lowest.filter(|point| point.z.abs() <= BALL_GAP_MAX);
    let corners: Vec<DVec2> = touching.map(DVec3::truncate).collect();
    let polygon = simplified(convex_polygon(&corners));
    if polygon.len() < 3 || polygon_area(&polygon) < AREA_MIN {
        return None;
    }
    let both: Vec<DVec2> = sole.polygon.iter().chain(&polygon).copied().collect();
    let excess = polygon_area(&convex_polygon(&both)) - sole.area;
    (excess <= BALL_EXCESS_MAX * sole.area).then_some(polygon)
}

fn link_axes() -> impl Iterator<Item = DVec3> {
    DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis])
}

/// The outward normals of the faces of the surface's convex hull.
fn face_normals(surface: &SurfacePoints) -> Vec<DVec3> {
    let points: Vec<DVec3> = surface.all_points().collect();
    let Ok((corners, triangles)) = hull_triangles(&points) else { return Vec::new() };
    let normal = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|index| corners[index as usize]);
        (b - a).cross(c - a).try_normalize()
    };
    triangles.iter().filter_map(normal).collect()
}

fn best(
    surface: &SurfacePoints,
    normals: &[DVec3],
    down: DVec3,
    forward: DVec3,
) -> Option<FoundSole> {
    let least_cos = libm::cos(TILT_MAX);
    let looks_down = normals.iter().filter(|normal| normal.dot(down) >= least_cos);
    let soles = looks_down.filter_map(|normal| sole_along(surface, *normal, forward));
    soles.reduce(|best, sole| if sole.area > best.area { sole } else { best })
}

/// The sole whose outward normal is `normal`.
fn sole_along(surface: &SurfacePoints, normal: DVec3, forward: DVec3) -> Option<FoundSole> {
    let [thin, thick] =
        THICKNESSES.map(|thickness| sole_within(surface, normal, forward, thickness));
    match (thin, thick) {
        (Some(thin), Some(thick)) if thick.area > THICKNESS_GAIN_MIN * thin.area => Some(thick),
        (Some(thin), _) => Some(thin),
        (None, thick) => thick,
    }
}

fn sole_within(
    surface: &SurfacePoints,
    normal: DVec3,
    forward: DVec3,
    thickness: f64,
) -> Option<FoundSole> {
    let x = forward.reject_from_normalized(normal).try_normalize()?;
    let turn = DQuat::from_mat3(&DMat3::from_cols(x, (-normal).cross(x), -normal));
    let angle = crate::base::spatial::scaled_axis_from_rotation(turn).length();
    let rotation = if angle < TURN_MIN { DQuat::IDENTITY } else { turn };
    let down = -(rotation * DVec3::Z);
    let depth = surface.extent(down);
    let from_link = Pose::from_parts(down * depth, rotation).inverse();
    let is_low = |point: &DVec3| point.dot(down) >= depth - thickness;
    let low = surface.standing_points(down).filter(is_low);
    let corners: Vec<DVec2> = low.map(|point| (from_link * point).truncate()).collect();
    let polygon = simplified(convex_polygon(&corners));
    let area = if polygon.len() < 3 { 0.0 } else { polygon_area(&polygon) };
    (area > 0.0).then(|| FoundSole { link_from_sole: from_link.inverse(), polygon, area })
}

/// The polygon with few enough corners; those go whose loss costs least area.
fn simplified(mut polygon: Vec<DVec2>) -> Vec<DVec2> {
    let corner_area = |polygon: &[DVec2], at: usize| {
        let count = polygon.len();
        let (a, b) = (polygon[(at + count - 1) % count], polygon[(at + 1) % count]);
        (polygon[at] - a).perp_dot(b - polygon[at]).abs()
    };
    while polygon.len() > POLYGON_VERTICES_MAX {
        let areas = (0..polygon.len()).map(|at| (corner_area(&polygon, at), at));
        let least = areas.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let Some((_, at)) = least else { break };
        polygon.remove(at);
    }
    polygon
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shape::Shape;

    fn block(low: DVec3, high: DVec3) -> Vec<DVec3> {
        let pick =
            |bit: usize, axis: usize| if bit >> axis & 1 == 1 { high[axis] } else { low[axis] };
        (0..8).map(|bit| DVec3::new(pick(bit, 0), pick(bit, 1), pick(bit, 2))).collect()
    }

    #[test]
    fn the_bottom_face_of_a_block_is_its_sole() {
        let points = block(DVec3::new(-0.05, -0.04, -0.1), DVec3::new(0.15, 0.04, 0.02));
        let surface = SurfacePoints { points, ..SurfacePoints::default() };
        let sole = find_sole(&surface, DVec3::NEG_Z, DVec3::X).unwrap();
        assert!((sole.link_from_sole.translation - DVec3::new(0.0, 0.0, -0.1)).length() < 1e-12);
        assert!((sole.area - 0.2 * 0.08).abs() < 1e-12, "{}", sole.area);
        assert_eq!(sole.polygon.len(), 4);
    }

    #[test]
    fn four_balls_carry_a_sole() {
        let centres = [[0.1, 0.03], [0.1, -0.03], [-0.05, 0.03], [-0.05, -0.03]];
        let balls = centres.map(|[x, y]| (DVec3::new(x, y, -0.03), 0.005)).to_vec();
        let sole =
            find_sole(&SurfacePoints { balls, ..SurfacePoints::default() }, DVec3::NEG_Z, DVec3::X);
        let sole = sole.unwrap();
        assert!((sole.link_from_sole.translation.z + 0.035).abs() < 1e-12);
        assert!((sole.area - 0.15 * 0.06).abs() < 1e-12, "{}", sole.area);
    }

    #[test]
    fn lying_cylinders_carry_what_lies_between_their_lowest_lines_and_a_standing_one_its_end() {
        let along_x =
            crate::base::spatial::rotation_from_rpy(0.0, std::f64::consts::FRAC_PI_2, 0.3);
        let mut surface = SurfacePoints::default();
        for y in [-0.02, 0.02] {
            let shape = Shape::Cylinder { radius: 0.02, half_length: 0.12 };
            // Turned about its own axis, its rim's corners lie elsewhere.
            let turn = along_x * crate::base::spatial::rotation_about(DVec3::Z, y);
            surface.add(&shape, &Pose::from_parts(y * DVec3::Y, turn));
        }
        let sole = find_sole(&surface, DVec3::NEG_Z, DVec3::X).unwrap();
        assert!((sole.link_from_sole.translation.z + 0.02).abs() < 1e-9);
        assert!((sole.area - 0.24 * 0.04 * libm::cos(0.3)).abs() < 1e-9, "{}", sole.area);
        let mut surface = SurfacePoints::default();
        surface.add(&Shape::Cylinder { radius: 0.06, half_length: 0.02 }, &Pose::IDENTITY);
        let sole = find_sole(&surface, DVec3::NEG_Z, DVec3::X).unwrap();
        let disc = std::f64::consts::PI * 0.06 * 0.06;
        assert!(sole.area > 0.95 * disc && sole.area < disc, "{}", sole.area);
    }

    #[test]
    fn balls_below_looks_carry_what_lies_between_them() {
        let points = block(DVec3::new(-0.07, -0.04, -0.0354), DVec3::new(0.14, 0.04, 0.02));
        let surface = SurfacePoints { points, ..SurfacePoints::default() };
        let sole = find_sole(&surface, DVec3::NEG_Z, DVec3::X).unwrap();
        let balls = |x: f64, z: f64| {
            [[x, 0.03], [x, -0.03], [-0.05, 0.025], [-0.05, -0.025]]
                .map(|[x, y]| (DVec3::new(x, y, z), 0.005))
        };
        let polygon = carried_by_balls(&sole, &balls(0.12, -0.03)).unwrap();
        assert!((polygon_area(&polygon) - 0.17 * 0.055).abs() < 1e-12);
        assert_eq!(carried_by_balls(&sole, &balls(0.12, -0.027)), None, "3.4 mm above the sole");
        assert_eq!(carried_by_balls(&sole, &balls(0.16, -0.03)), None, "before the toes");
        assert_eq!(carried_by_balls(&sole, &balls(0.12, -0.03)[..2]), None, "two points");
    }

    #[test]
    fn a_tilted_block_has_a_tilted_sole_and_a_ball_has_none() {
        let turn = crate::base::spatial::rotation_from_rpy(0.0, 0.3, 0.0);
        let points = block(DVec3::new(-0.1, -0.05, -0.06), DVec3::new(0.1, 0.05, 0.0));
        let points: Vec<DVec3> = points.into_iter().map(|point| turn * point).collect();
        let sole = find_sole(
            &SurfacePoints { points, ..SurfacePoints::default() },
            DVec3::NEG_Z,
            DVec3::X,
        );
        let sole = sole.unwrap();
        let up = sole.link_from_sole.rotation * DVec3::Z;
        assert!(up.abs_diff_eq(turn * DVec3::Z, 1e-9), "{up}");
        let ball = SurfacePoints { balls: vec![(DVec3::ZERO, 0.1)], ..SurfacePoints::default() };
        assert!(find_sole(&ball, DVec3::NEG_Z, DVec3::X).is_none());
    }

    #[test]
    fn a_round_sole_gets_as_many_corners_as_fit() {
        let rim: Vec<DVec2> = (0..40)
            .map(|at| DVec2::from_angle(std::f64::consts::TAU * f64::from(at) / 40.0))
            .collect();
        let polygon = simplified(convex_polygon(&rim));
        assert_eq!(polygon.len(), POLYGON_VERTICES_MAX);
        assert!(polygon_area(&polygon) > 0.95 * std::f64::consts::PI);
    }
}
