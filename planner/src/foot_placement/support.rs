//! What carries a sole at a given pose, exactly.

use glam::{DMat3, DVec2, DVec3};
use parry3d_f64::bounding_volume::Aabb;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::POLYGON_VERTICES_MAX;

use crate::foot_placement::scratch::{Bounded, Scratch};
use crate::foot_placement::sole_support::{NoSupport, Support};
use crate::foot_placement::surfaces::{CurvedSurface, Element, Face, SurfaceEnds, Surfaces};
use crate::geometry::bvh;
use crate::geometry::polygon::{
    Sides, area_and_centroid, clip, clip_to_sides, convex_hull, cross, distance_to, edges,
    inner_distance, sides_of, simplify, width,
};

/// A surface that only touches the outline does not stand in it: how far inside it must be, m.
const OUTLINE_INSET: f64 = 1e-4;
/// How far a surface that faces down must be below the sole plane not to lie on top of the ground
/// there, m.
const COVER_DEPTH: f64 = 1e-4;
/// Halvings of the search for the point of a curved surface's axis nearest to the plate.
const AXIS_SEARCH_STEPS: usize = 48;

/// Requirements on a support.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SupportRequirement {
    /// The smallest area, m2.
    pub area_min: f64,
    /// Whether surfaces steeper than friction holds carry too: something else keeps the foot from
    /// sliding.
    pub is_braced: bool,
    /// Whether any surface that stands in the outline is enough to reject the sole; else it is the
    /// highest that is remembered.
    pub any_intrusion: bool,
}

/// A sole at a pose.
pub(crate) struct PosedSole<'a> {
    outline: &'a [DVec2],
    /// The outline's sides.
    pub(crate) sides: Sides,
    world_from_sole: &'a Pose,
    /// The rotation part of `sole_from_world`.
    sole_from_world: DMat3,
    normal: DVec3,
    /// Whether steep surfaces carry it too.
    is_braced: bool,
}

impl<'a> PosedSole<'a> {
    /// A sole that only surfaces within the friction cone carry.
    pub(crate) fn new(outline: &'a [DVec2], world_from_sole: &'a Pose) -> Self {
        let rotation = DMat3::from_quat(world_from_sole.rotation);
        Self {
            outline,
            sides: sides_of(outline),
            world_from_sole,
            sole_from_world: rotation.transpose(),
            normal: rotation.z_axis,
            is_braced: false,
        }
    }

    /// A point of the world in the sole frame.
    pub(crate) fn in_sole(&self, point: DVec3) -> DVec3 {
        self.sole_from_world * (point - self.world_from_sole.translation)
    }

    /// The box in the world around the outline between two heights above the sole plane.
    pub(crate) fn region(&self, lowest: f64, highest: f64) -> Aabb {
        let corner = |p: &DVec2, z: f64| *self.world_from_sole * p.extend(z);
        let corners = self.outline.iter().flat_map(|p| [corner(p, lowest), corner(p, highest)]);
        let around = bvh::Aabb::of_points(corners);
        Aabb::new(around.min, around.max)
    }

    /// The box in the sole frame around the outline between two heights above the sole plane.
    fn plate(&self, lowest: f64, highest: f64) -> bvh::Aabb {
        bvh::Aabb::of_points(
            self.outline.iter().flat_map(|p| [p.extend(lowest), p.extend(highest)]),
        )
    }
}

/// What was found near a sole so far.
#[derive(Default)]
struct Findings {
    /// The highest point, in the sole frame, of a surface that stands in the outline.
    intrusion: Option<DVec3>,
    /// Whether a surface in the sole plane faces down.
    faces_down: bool,
}

impl Findings {
    fn intrude(&mut self, point: DVec3) {
        if self.intrusion.is_none_or(|highest| point.z > highest.z) {
            self.intrusion = Some(point);
        }
    }
}

impl Surfaces {
    /// The exact support of a sole at a pose: the hull of all places within the outline where
    /// a surface is within `plane_distance_max` of the sole plane, aligned with it and inside the
    /// friction cone [Grey 4.1.2].
    ///
    /// # Errors
    /// Why there is none. `scratch` then holds the highest point of the obstacle.
    pub fn support(
        &self,
        scratch: &mut Scratch,
        sole_polygon: &[DVec2],
        world_from_sole: &Pose,
    ) -> Result<Support, NoSupport> {
        let requirement = SupportRequirement {
            area_min: self.config.support_area_min,
            is_braced: false,
            any_intrusion: false,
        };
        self.support_of(scratch, sole_polygon, world_from_sole, requirement)
    }

    /// The support of a sole at a pose if it meets the requirement.
    pub(crate) fn support_of(
        &self,
        scratch: &mut Scratch,
        sole_polygon: &[DVec2],
        world_from_sole: &Pose,
        requirement: SupportRequirement,
    ) -> Result<Support, NoSupport> {
        scratch.intrusion = None;
        if !is_sole(sole_polygon) || !world_from_sole.is_finite() {
            return Err(NoSupport::InvalidSole);
        }
        let sole = PosedSole {
            is_braced: requirement.is_braced,
            ..PosedSole::new(sole_polygon, world_from_sole)
        };
        if !sole.is_braced && !self.is_flat_enough(sole.normal) {
            return Err(NoSupport::TooSteep);
        }
        let findings = self.examine(scratch, &sole, requirement.any_intrusion)?;
        if let Some(point) = findings.intrusion {
            scratch.intrusion = Some(*world_from_sole * point);
            let is_inside_out = findings.faces_down && scratch.contact_points.is_empty();
            return Err(if is_inside_out { NoSupport::FacesDown } else { NoSupport::Penetrates });
        }
        if scratch.contact_points.is_empty() {
            return Err(NoSupport::NothingBelow);
        }
        self.evaluate_contacts(scratch, requirement.area_min)
    }

    /// Collects contact points and intrusions, or just one of these.
    fn examine(
        &self,
        scratch: &mut Scratch,
        sole: &PosedSole,
        any_intrusion: bool,
    ) -> Result<Findings, NoSupport> {
        scratch.contact_points.clear();
        let mut findings = Findings::default();
        let heights = [-self.config.plane_distance_max, self.config.plate_height];
        let (region, plate) =
            (sole.region(heights[0], heights[1]), sole.plate(heights[0], heights[1]));
        for (count, id) in self.elements_in(&region).enumerate() {
            if count >= self.config.support_elements_max {
                return Err(NoSupport::TooManyElements);
            }
            match self.element(id) {
                Element::Face(face, vertices) => {
                    self.examine_face(scratch, (sole, &plate), &mut findings, face, vertices)
                }
                Element::Curved(curved) => {
                    self.examine_curved(scratch, sole, &mut findings, curved)
                }
            }
            if any_intrusion && findings.intrusion.is_some() {
                break;
            }
        }
        Ok(findings)
    }

    fn examine_face(
        &self,
        scratch: &mut Scratch,
        (sole, plate): (&PosedSole, &bvh::Aabb),
        findings: &mut Findings,
        face: &Face,
        vertices: &[DVec3],
    ) {
        let tolerance = self.config.plane_distance_max;
        let buffer = &mut scratch.clip;
        buffer.polygon.clear();
        buffer.polygon.extend(vertices.iter().map(|&v| sole.in_sole(v)));
        let around = bvh::Aabb::of_points(buffer.polygon.iter().copied());
        let alignment = face.normal.dot(sole.normal);
        let obstructs_above = if alignment < -0.5 { -COVER_DEPTH } else { tolerance };
        let is_level = alignment.abs() >= self.carrying_cos;
        if !plate.overlaps(&around) || !is_level && around.max.z <= obstructs_above {
            return;
        }
        clip_to_sides(buffer, &sole.sides, 0.0);
        let clipped = bvh::Aabb::of_points(buffer.polygon.iter().copied());
        let (lowest, highest) = (clipped.min.z, clipped.max.z);
        findings.faces_down |= alignment <= -self.carrying_cos && lowest.abs() <= tolerance;
        if highest > obstructs_above && lowest < self.config.plate_height {
            clip_to_sides(buffer, &sole.sides, OUTLINE_INSET);
            clip(&mut buffer.polygon, &mut buffer.spare, |p| self.config.plate_height - p.z);
            buffer
                .polygon
                .iter()
                .filter(|p| p.z > obstructs_above)
                .for_each(|p| findings.intrude(*p));
        }
        if alignment >= self.carrying_cos && (sole.is_braced || self.is_flat_enough(face.normal)) {
            clip(&mut buffer.polygon, &mut buffer.spare, |p| tolerance - p.z);
            clip(&mut buffer.polygon, &mut buffer.spare, |p| tolerance + p.z);
            if !face.of_mesh && width(&buffer.polygon) < self.config.contact_width_min {
                return;
            }
            for i in 0..scratch.clip.polygon.len() {
                add_contact(
                    &mut scratch.contact_points,
                    &mut scratch.hull,
                    scratch.clip.polygon[i].truncate(),
                );
            }
        }
    }

    fn examine_curved(
        &self,
        scratch: &mut Scratch,
        sole: &PosedSole,
        findings: &mut Findings,
        curved: &CurvedSurface,
    ) {
        let tolerance = self.config.plane_distance_max;
        let (a, b) = (sole.in_sole(curved.a), sole.in_sole(curved.b));
        if a.z.max(b.z) + curved.radius < -tolerance {
            return;
        }
        if curved.ends == SurfaceEnds::Spherical {
            if let Some(point) = self.intrusion_of_curved(sole, curved, a, b) {
                findings.intrude(point);
            }
            for end in [a, b] {
                let point = end + DVec3::Z * curved.radius;
                if point.z.abs() <= tolerance
                    && inner_distance(sole.outline, point.truncate()) >= 0.0
                {
                    add_contact(&mut scratch.contact_points, &mut scratch.hull, point.truncate());
                }
            }
        }
        let Some(side_normal) = curved.side_normal(sole.normal) else { return };
        if side_normal.dot(sole.normal) < self.carrying_cos || !self.is_flat_enough(side_normal) {
            return;
        }
        let offset = sole.sole_from_world * side_normal * curved.radius;
        let buffer = &mut scratch.clip;
        buffer.polygon.clear();
        buffer.polygon.extend([a + offset, b + offset]);
        clip_to_sides(buffer, &sole.sides, 0.0);
        clip(&mut buffer.polygon, &mut buffer.spare, |p| tolerance - p.z);
        clip(&mut buffer.polygon, &mut buffer.spare, |p| tolerance + p.z);
        for i in 0..scratch.clip.polygon.len() {
            add_contact(
                &mut scratch.contact_points,
                &mut scratch.hull,
                scratch.clip.polygon[i].truncate(),
            );
        }
    }

    /// Where a capsule or ball with the axis `a b` (sole frame) stands in the plate above the sole,
    /// if it does.
    fn intrusion_of_curved(
        &self,
        sole: &PosedSole,
        curved: &CurvedSurface,
        a: DVec3,
        b: DVec3,
    ) -> Option<DVec3> {
        let (low, high) = (self.config.plane_distance_max, self.config.plate_height);
        let distance = |t: f64| {
            let p = a + (b - a) * t;
            let aside = distance_to(sole.outline, p.truncate());
            let above = (low - p.z).max(p.z - high).max(0.0);
            (aside * aside + above * above).sqrt()
        };
        let (mut from, mut to) = (0.0, 1.0);
        // The axis of a ball is a point.
        let steps = if a == b { 0 } else { AXIS_SEARCH_STEPS };
        for _ in 0..steps {
            let (third, two_thirds) = (from + (to - from) / 3.0, to - (to - from) / 3.0);
            if distance(third) <= distance(two_thirds) { to = two_thirds } else { from = third }
        }
        let nearest = 0.5 * (from + to);
        let point = a + (b - a) * nearest;
        (distance(nearest) < curved.radius - OUTLINE_INSET)
            .then(|| point.truncate().extend((point.z + curved.radius).min(high)))
    }

    /// The support that the collected contact points make.
    fn evaluate_contacts(
        &self,
        scratch: &mut Scratch,
        area_min: f64,
    ) -> Result<Support, NoSupport> {
        convex_hull(&mut scratch.contact_points, &mut scratch.hull);
        simplify(&mut scratch.hull, POLYGON_VERTICES_MAX);
        let (area, centroid) = area_and_centroid(&scratch.hull);
        if area < area_min {
            return Err(NoSupport::AreaTooSmall);
        }
        let edge_distance = inner_distance(&scratch.hull, centroid);
        if edge_distance < self.config.centroid_edge_distance_min {
            return Err(NoSupport::CentroidNearEdge);
        }
        Ok(Support { polygon: scratch.hull.iter().copied().collect(), area, edge_distance })
    }
}

/// Whether a polygon is convex, counter-clockwise, and of a size that fits.
fn is_sole(polygon: &[DVec2]) -> bool {
    let n = polygon.len();
    let turns_left =
        |i: usize| cross(polygon[i], polygon[(i + 1) % n], polygon[(i + 2) % n]) >= -1e-12;
    (3..=POLYGON_VERTICES_MAX).contains(&n)
        && polygon.iter().all(|p| p.is_finite())
        && (0..n).all(turns_left)
        && edges(polygon).map(|(a, b)| a.perp_dot(b)).sum::<f64>() > 0.0
}

/// Keeps a contact point; a full list is first reduced to its hull, which loses nothing.
fn add_contact(points: &mut Bounded<DVec2>, hull: &mut Vec<DVec2>, point: DVec2) {
    if points.is_full() {
        convex_hull(points, hull);
        points.clear();
        for &corner in hull.iter() {
            points.push(corner);
        }
    }
    points.push(point);
}
