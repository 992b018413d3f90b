//! Which ground no placement of a sole can touch, because too little other ground is near.
//!
//! Two contacts of a sole are at most its length apart. So all contacts of a sole that touches an
//! element lie on it and on others within that distance, and the support is at most the convex hull
//! of these elements. Where that hull is too small or too narrow, no sole can touch the element.
//!
//! In the plane of a sole, the contact on a curved surface lies where its axis does, seen along the
//! sole's normal, and the axis is lower by the radius. So axes stand for curved surfaces here, and
//! differences between radii count as rounding. All of it errs toward ground that bears soles; the
//! faces of meshes are taken to do so.

use glam::{DVec2, DVec3};

use crate::foot_placement::config::{LeastSupport, SoleNeeds};
use crate::foot_placement::elements::{Element, Face, FaceKind};
use crate::foot_placement::surfaces::Surfaces;
use crate::geometry::bvh::Aabb;
use crate::geometry::polygon::{
    FACE_VERTICES_MAX, area_and_centroid, convex_hull, distance_to, edges, width,
};

/// Most elements near another that are examined. One with more is taken to bear soles.
const NEIGHBORS_MAX: usize = 64;

/// An element, seen from above.
struct Patch {
    /// The outline of a face, or the ends of an axis, m.
    points: heapless::Vec<DVec2, FACE_VERTICES_MAX>,
    /// Its lowest and highest point, m.
    heights: [f64; 2],
    /// The radius of a curved surface, 0 of a face, m.
    radius: f64,
}

/// The elements of a world, as ground that bears soles or does not.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bearing<'a> {
    surfaces: &'a Surfaces,
}

/// Finds the elements that soles may touch. Allocates.
pub(crate) fn find_bearing(surfaces: &mut Surfaces, needs: SoleNeeds) {
    surfaces.needs = Some(needs);
    let ids = 0..surfaces.element_count();
    let bearing = Bearing::of(surfaces);
    surfaces.bearing = ids.map(|id| bearing.bears(id, &needs)).collect();
}

impl<'a> Bearing<'a> {
    /// The elements of a world.
    pub fn of(surfaces: &'a Surfaces) -> Self {
        Self { surfaces }
    }

    /// Whether some ground is flat enough, and no sole can touch it.
    pub fn has_bare_ground(&self) -> bool {
        (0..self.surfaces.element_count()).any(|id| self.is_bare(id))
    }

    /// Whether an element is flat enough, and no sole can touch it. The sides of a cylinder belong
    /// to its curved surface.
    fn is_bare(&self, id: u32) -> bool {
        let is_side = |face: &Face| face.kind == FaceKind::CylinderSide;
        self.surfaces.may_carry(id)
            && !self.surfaces.may_bear(id)
            && !matches!(self.surfaces.element(id), Element::Face(face, _) if is_side(face))
    }

    /// Lower bound of the distance between two soles, m, each of which touches one of two elements
    /// and extends by `radius` (m) from its origin.
    pub(crate) fn sole_distance(&self, ids: [u32; 2], radius: f64) -> f64 {
        let [one, other] = ids.map(|id| self.patch(id));
        let aside = distance(&one.points, &other.points);
        let aside = aside - one.radius - other.radius - 2.0 * radius;
        let [[low, high], [other_low, other_high]] = [(ids[0], one), (ids[1], other)]
            .map(|(id, patch)| self.sole_heights(id, &patch, radius));
        let above = (low - other_high).max(other_low - high);
        libm::hypot(aside.max(0.0), above.max(0.0))
    }

    /// Lower bound of the distance from a sole at a place to one that touches an element, m.
    pub(crate) fn distance_from_sole(&self, id: u32, sole: DVec3, radius: f64) -> f64 {
        let patch = self.patch(id);
        let aside = distance(&patch.points, &[sole.truncate()]) - patch.radius - radius;
        let [low, high] = self.sole_heights(id, &patch, radius);
        libm::hypot(aside.max(0.0), (low - sole.z).max(sole.z - high).max(0.0))
    }

    /// The lowest and the highest origin of a sole that touches an element, m.
    fn sole_heights(&self, id: u32, patch: &Patch, radius: f64) -> [f64; 2] {
        let known = self.surfaces.bearing.get(id as usize).copied().flatten();
        let tilt_sin = known.unwrap_or(self.steepest_sin());
        let aside = radius * tilt_sin + self.surfaces.config.plane_distance_max;
        // A curved surface is touched at least so far above its axis.
        let above =
            patch.radius * libm::cos(libm::asin(tilt_sin) + self.surfaces.config.normal_tilt_max);
        [patch.heights[0] + above - aside, patch.heights[1] + patch.radius + aside]
    }

    /// For an element that no sole can touch, although it is flat enough: the length of a sole and
    /// the distance to the nearest ground that it would also have to touch, infinite without any;
    /// m.
    pub(crate) fn spacing_beside(&self, id: u32) -> Option<[f64; 2]> {
        let needs = self.surfaces.needs.filter(|_| self.is_bare(id))?;
        let patch = self.patch(id);
        let mut nearest = f64::INFINITY;
        self.surfaces.for_each_in(
            &self.surfaces.bounds(id).grown(2.0 * self.reach_of(needs.length)),
            |other| {
                if other != id && self.is_ground(other) {
                    nearest = nearest.min(self.contact_distance(&patch, &self.patch(other)));
                }
            },
        );
        Some([needs.length, nearest])
    }

    /// The sine of the greatest tilt of a sole that touches an element; `None` if none can.
    fn bears(&self, id: u32, needs: &SoleNeeds) -> Option<f64> {
        if !self.is_ground(id) {
            return None;
        }
        let patch = self.patch(id);
        let mut points = patch.points.to_vec();
        if self.is_of_mesh(id) || self.is_enough(&mut points, 0.0, &needs.least) {
            return Some(self.tilt_sin(id));
        }
        // A sole on this element also touches one of the others, and lies as that one does.
        let (mut count, mut radii, mut tilt_sin) = (0, [patch.radius; 2], 0.0f64);
        self.surfaces.for_each_in(
            &self.surfaces.bounds(id).grown(self.reach_of(needs.length)),
            |other| {
                if other == id || count > NEIGHBORS_MAX || !self.is_ground(other) {
                    return;
                }
                let near = self.patch(other);
                if self.contact_distance(&patch, &near) <= needs.length {
                    count += 1;
                    radii = [radii[0].min(near.radius), radii[1].max(near.radius)];
                    tilt_sin = tilt_sin.max(self.tilt_sin(other));
                    points.extend(near.points);
                }
            },
        );
        if count > NEIGHBORS_MAX {
            return Some(self.steepest_sin());
        }
        let shift = self.height_slack(radii) * self.steepest_sin();
        let is_enough = count > 0 && self.is_enough(&mut points, shift, &needs.least);
        is_enough.then(|| tilt_sin.min(self.tilt_sin(id)))
    }

    /// The sine of the greatest tilt of a sole that touches an element: little more than that of a
    /// face.
    fn tilt_sin(&self, id: u32) -> f64 {
        match self.surfaces.element(id) {
            Element::Face(face, _) => {
                let tilt =
                    libm::acos(face.normal.z.min(1.0)) + self.surfaces.config.normal_tilt_max;
                libm::sin(tilt).min(self.steepest_sin())
            }
            Element::Curved(_) => self.steepest_sin(),
        }
    }

    /// Whether an element may be a contact: flat enough, and no face so narrow that it counts for
    /// none.
    fn is_ground(&self, id: u32) -> bool {
        self.surfaces.may_carry(id)
            && match self.surfaces.element(id) {
                Element::Face(face, vertices) if !face.of_mesh() => {
                    // In its own plane a face is wider than seen from above, in that of a sole no
                    // wider than in its own.
                    width(vertices) / face.normal.z >= self.surfaces.config.contact_width_min
                }
                Element::Face(..) | Element::Curved(_) => true,
            }
    }

    fn is_of_mesh(&self, id: u32) -> bool {
        matches!(self.surfaces.element(id), Element::Face(face, _) if face.of_mesh())
    }

    fn patch(&self, id: u32) -> Patch {
        let radius = self.surfaces.radius(id);
        let ends;
        let points = match self.surfaces.element(id) {
            Element::Face(_, vertices) => vertices,
            Element::Curved(curved) => {
                // On an axis inclined against the sole the contact lies beside its end.
                let beyond = (curved.b - curved.a).normalize_or_zero() * radius;
                ends = [curved.a - beyond, curved.b + beyond];
                &ends
            }
        };
        let around = Aabb::of_points(points.iter().copied());
        let heights = [around.min.z, around.max.z];
        let seen = points.iter().take(FACE_VERTICES_MAX).map(|p| p.truncate());
        Patch { points: seen.collect(), heights, radius }
    }

    /// Lower bound of the distance between a contact on one element and one on another, m.
    fn contact_distance(&self, one: &Patch, other: &Patch) -> f64 {
        let aside = distance(&one.points, &other.points);
        let above = (one.heights[0] - other.heights[1]).max(other.heights[0] - one.heights[1]);
        // The part of the distance along the sole's normal does not count.
        let along = self.height_slack([one.radius, other.radius]);
        libm::sqrt((aside * aside + above.max(0.0) * above.max(0.0) - along * along).max(0.0))
    }

    /// Upper bound of the distance along a sole's normal of axes and faces that it touches, m.
    fn height_slack(&self, [smaller, larger]: [f64; 2]) -> f64 {
        let inclined = smaller.max(larger) * (1.0 / self.surfaces.carrying_cos - 1.0);
        (larger - smaller).abs() + inclined + 2.0 * self.surfaces.config.plane_distance_max
    }

    /// Upper bound of the distance between surfaces that a sole of a length (m) touches, m.
    fn reach_of(&self, length: f64) -> f64 {
        length + 2.0 * self.surfaces.config.plane_distance_max
    }

    /// Sine of the steepest tilt of a sole.
    fn steepest_sin(&self) -> f64 {
        self.surfaces.steepest_tan() * self.surfaces.steepest_cos
    }

    /// Whether the convex hull of points that are known up to `shift` (m), seen from above, may be
    /// enough support.
    fn is_enough(&self, points: &mut [DVec2], shift: f64, least: &LeastSupport) -> bool {
        let mut hull = Vec::with_capacity(points.len() + 8);
        convex_hull(points, &mut hull);
        let perimeter: f64 = edges(&hull).map(|(a, b)| a.distance(b)).sum();
        let area = area_and_centroid(&hull).0 + shift * (perimeter + 4.0 * shift);
        let flat: Vec<DVec3> = hull.iter().map(|p| p.extend(0.0)).collect();
        let across = width(&flat) + 2.0 * shift;
        // A sole in an inclined plane has more than is seen from above.
        let config = &self.surfaces.config;
        area / self.surfaces.steepest_cos >= least.area.min(config.support_area_min)
            && across / self.surfaces.steepest_cos
                >= 2.0 * least.centroid_edge_distance.min(config.centroid_edge_distance_min)
    }
}

/// The distance between two convex polygons, lines or points, m.
fn distance(one: &[DVec2], other: &[DVec2]) -> f64 {
    let crosses = |(a, b): (DVec2, DVec2), (c, d): (DVec2, DVec2)| {
        let side = |from: DVec2, to: DVec2, p: DVec2| (to - from).perp_dot(p - from);
        side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
    };
    if edges(one).any(|side| edges(other).any(|across| crosses(side, across))) {
        return 0.0;
    }
    let to_other = one.iter().map(|p| distance_to(other, *p));
    to_other.chain(other.iter().map(|p| distance_to(one, *p))).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use surefoot_shared_types::base::spatial::rotation_about;
    use surefoot_shared_types::world::world::{World, WorldShape};
    use surefoot_shared_types::{Pose, Shape};

    use super::*;
    use crate::base::random::{Random, Stream};
    use crate::foot_placement::{FootPlacementConfig, Scratch};
    use crate::geometry::polygon::diameter;

    const SOLE: [DVec2; 4] = [
        DVec2::new(-0.09, -0.04),
        DVec2::new(0.11, -0.04),
        DVec2::new(0.11, 0.04),
        DVec2::new(-0.09, 0.04),
    ];

    /// A row of bars or posts along x, level or nearly so, of random size and distance.
    fn row(random: &mut Random) -> World {
        let distance = random.uniform(0.05, 0.3);
        let [half_length, half_width] = [0.006, 0.03].map(|most| random.uniform(0.005, most));
        let (radius, rise) = (random.uniform(0.005, 0.03), random.uniform(-0.02, 0.02));
        let is_round = random.uniform(0.0, 1.0) < 0.5;
        let piece = |index: i32| {
            let height = if index % 2 == 0 { 0.0 } else { rise };
            let (shape, turn, depth) = if is_round {
                let turn = rotation_about(DVec3::X, std::f64::consts::FRAC_PI_2);
                (Shape::Cylinder { radius, half_length: 0.3 }, turn, radius)
            } else {
                let half_extents = DVec3::new(half_length, half_width, 0.05);
                (Shape::Box { half_extents }, glam::DQuat::IDENTITY, 0.05)
            };
            let at = DVec3::new(distance * f64::from(index), 0.0, height - depth);
            let world_from_shape = Pose::from_parts(at, turn);
            WorldShape { name: format!("{index}"), world_from_shape, shape }
        };
        World { shapes: (-2..3).map(piece).collect(), mu: 0.6, digest: Default::default() }
    }

    /// Whether a sole has support on some of the world at random poses.
    fn has_support(surfaces: &Surfaces, random: &mut Random) -> bool {
        let mut scratch = Scratch::new(surfaces.config());
        (0..4_000).any(|_| {
            let [x, y, yaw] = [0.3, 0.1, 3.0].map(|most| random.uniform(-most, most));
            let tilt = if random.uniform(0.0, 1.0) < 0.5 { 0.0 } else { random.uniform(-0.3, 0.3) };
            let rotation = rotation_about(DVec3::Y, tilt) * rotation_about(DVec3::Z, yaw);
            let at = DVec3::new(x, y, -libm::tan(tilt) * x);
            surfaces.support(&mut scratch, &SOLE, &Pose::from_parts(at, rotation)).is_ok()
        })
    }

    #[test]
    fn no_sole_rests_where_all_ground_is_bare() {
        let config = FootPlacementConfig { support_area_min: 2e-3, ..Default::default() };
        let least = LeastSupport {
            area: config.support_area_min,
            centroid_edge_distance: config.centroid_edge_distance_min,
        };
        let (mut bare, mut supported) = (0, 0);
        for index in 0..600 {
            let mut random = Random::new(index, Stream::FootPlacement, 0, 7);
            let world = row(&mut random);
            let surfaces = Surfaces::new(&world, config.clone()).unwrap();
            let mut known = surfaces.clone();
            find_bearing(&mut known, SoleNeeds { length: diameter(&SOLE), least });
            let is_bare = (0..known.element_count()).all(|id| !known.may_bear(id));
            let is_supported = has_support(&surfaces, &mut random);
            assert!(!(is_bare && is_supported), "world {index}: {world:?}");
            (bare, supported) = (bare + u32::from(is_bare), supported + u32::from(is_supported));
        }
        assert!(bare > 30 && supported > 30, "{bare} bare, {supported} with support");
    }
}
