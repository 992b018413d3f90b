//! The exact support of a sole at a given pose.

use glam::{DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::POLYGON_VERTICES_MAX;

use crate::foot_placement::elements::{CurvedSurface, Element, Face, FaceKind, SurfaceEnds};
use crate::foot_placement::posed_sole::{PosedSole, SoleShape, SupportRequirement, is_sole};
use crate::foot_placement::resting_sole::rest_from;
use crate::foot_placement::scratch::{Contacts, Scratch};
use crate::foot_placement::sole_support::{NoSupport, Support};
use crate::foot_placement::surfaces::Surfaces;
use crate::foot_placement::tuning::SAMPLE_SPACING;
use crate::geometry::bvh;
use crate::geometry::polygon::{
    CLIP_VERTICES_MAX, ClipBuffer, HalfPlane, Sides, area_and_centroid, clip, clip_to_sides,
    convex_hull, distance_to, inner_distance, simplify, width,
};
use crate::geometry::resting_foot::{GroundPoint, clip_to_held, keep_from_ground_edges, tilts};

/// Depth inside the outline from which a surface counts as standing in it, m. A surface that only
/// touches the outline does not.
const OUTLINE_INSET: f64 = 1e-4;
/// Depth below the sole plane from which a surface that faces down does not cover the ground
/// there, m.
const COVER_DEPTH: f64 = 1e-4;
/// Incline against the sole up to which a mesh counts as even there: on it, a foot that lands
/// beside its place stands as it would have.
const EVEN_INCLINE_MAX: f64 = 1e-3;
/// Incline against the sole up to which a face that does not carry is ground that a foot beside its
/// place finds lower. A steeper one is a step, from whose edge the support keeps away.
const SLOPE_MAX: f64 = 0.3;
/// Halvings of the search for the point of a curved surface's axis nearest to the plate.
const AXIS_SEARCH_STEPS: usize = 48;

/// A face, or a line, within the outline of a sole, m.
type BoundedPolygon = heapless::Vec<DVec3, CLIP_VERTICES_MAX>;

/// Obstacles found near a sole.
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

/// The incline of a face against the sole, from the cosine (above 0) between their normals.
fn incline(alignment: f64) -> f64 {
    (1.0 - alignment * alignment).max(0.0).sqrt() / alignment
}

impl Surfaces {
    /// The exact support of a sole at a pose: the hull of all points within the outline where
    /// a surface is within `plane_distance_max` of the sole plane, aligned with it and inside the
    /// friction cone [Grey 4.1.2]. `sole_polygon` is in the sole frame, m.
    ///
    /// # Errors
    /// Why there is no support. `scratch` then holds the highest point of the obstacle.
    pub fn support(
        &self,
        scratch: &mut Scratch,
        sole_polygon: &[DVec2],
        world_from_sole: &Pose,
    ) -> Result<Support, NoSupport> {
        self.support_of_sole(scratch, SoleShape::flat(sole_polygon), world_from_sole)
    }

    /// The same for a sole of which only some parts touch level ground: the hull of what they
    /// touch.
    ///
    /// # Errors
    /// As [`Self::support`].
    pub fn support_of_sole(
        &self,
        scratch: &mut Scratch,
        sole: SoleShape<'_>,
        world_from_sole: &Pose,
    ) -> Result<Support, NoSupport> {
        self.support_of(scratch, sole, world_from_sole, self.enough())
    }

    /// What every support must meet.
    fn enough(&self) -> SupportRequirement {
        SupportRequirement {
            area_min: self.config.support_area_min,
            is_braced: false,
            any_intrusion: false,
        }
    }

    /// The support of a sole that is set down at a pose, and the pose in which it stands then.
    ///
    /// # Errors
    /// As [`Self::support`].
    pub(crate) fn support_set_down(
        &self,
        scratch: &mut Scratch,
        shape: SoleShape<'_>,
        world_from_sole: &Pose,
    ) -> Result<(Pose, Support), NoSupport> {
        self.set_down(scratch, shape, world_from_sole, self.enough())
    }

    /// The same, if the support meets the requirement. The sole moves along its normal where the
    /// highest ground under it is in touch, but too far from its plane to land on it. It tilts
    /// where it does not rest on the highest ground, if it has such a support then, too.
    pub(crate) fn set_down(
        &self,
        scratch: &mut Scratch,
        shape: SoleShape<'_>,
        world_from_sole: &Pose,
        requirement: SupportRequirement,
    ) -> Result<(Pose, Support), NoSupport> {
        let (mut pose, mut exact) =
            (*world_from_sole, self.support_of(scratch, shape, world_from_sole, requirement));
        if let Some(height) = scratch.contacts.height_off.take() {
            pose *= Pose::from_translation(DVec3::Z * height);
            exact = self.support_of(scratch, shape, &pose, requirement);
        }
        let exact = exact?;
        if scratch.contacts.is_tilting
            && let Some(rest) = rest_from(self, scratch, shape.outline, &pose)
            && let Ok(support) = self.support_of(scratch, shape, &rest, requirement)
        {
            return Ok((rest, support));
        }
        Ok((pose, exact))
    }

    /// The support of a sole at a pose, if it meets the requirement.
    pub(crate) fn support_of(
        &self,
        scratch: &mut Scratch,
        shape: SoleShape<'_>,
        world_from_sole: &Pose,
        requirement: SupportRequirement,
    ) -> Result<Support, NoSupport> {
        scratch.contacts.intrusion = None;
        scratch.contacts.height_off = None;
        if !is_sole(shape.outline) || !world_from_sole.is_finite() {
            return Err(NoSupport::InvalidSole);
        }
        let sole = PosedSole {
            is_braced: requirement.is_braced,
            pads: shape.pads,
            ..PosedSole::new(shape.outline, world_from_sole)
        };
        if !sole.is_braced && !self.is_flat_enough(sole.normal) {
            return Err(NoSupport::TooSteep);
        }
        let findings = self.examine(scratch, &sole, requirement.any_intrusion)?;
        if let Some(point) = findings.intrusion {
            scratch.contacts.intrusion = Some(*world_from_sole * point);
            let is_inside_out = findings.faces_down && scratch.contacts.points.is_empty();
            return Err(if is_inside_out { NoSupport::FacesDown } else { NoSupport::Penetrates });
        }
        if scratch.contacts.points.is_empty() {
            return Err(NoSupport::NothingBelow);
        }
        self.check_height(&mut scratch.contacts, &sole)?;
        scratch.contacts.find_tilt(&sole);
        self.evaluate_contacts(scratch, &sole, requirement.area_min)
    }

    /// Whether the highest ground under a sole is near enough to its plane: a foot that meets the
    /// ground before or after its time meets it at speed.
    fn check_height(&self, contacts: &mut Contacts, sole: &PosedSole) -> Result<(), NoSupport> {
        // Parts of a sole with pads lie above its plane.
        let is_met = |point: &&GroundPoint| point.is_carrying || sole.pads.is_empty();
        let by_height = |a: &&GroundPoint, b: &&GroundPoint| a.at.z.total_cmp(&b.at.z);
        let highest = contacts.ground.iter().filter(is_met).max_by(by_height);
        let Some(at) = highest.map(|point| point.at) else { return Ok(()) };
        if at.z.abs() <= self.config.ground_height_max {
            return Ok(());
        }
        contacts.height_off = Some(at.z);
        if at.z < 0.0 {
            return Err(NoSupport::NothingBelow);
        }
        contacts.intrusion = Some(*sole.world_from_sole * at);
        Err(NoSupport::Penetrates)
    }

    /// Collects contact points and the highest obstacle. With `any_intrusion` it ends at the first
    /// obstacle.
    fn examine(
        &self,
        scratch: &mut Scratch,
        sole: &PosedSole,
        any_intrusion: bool,
    ) -> Result<Findings, NoSupport> {
        scratch.contacts.points.clear();
        scratch.contacts.ground.clear();
        scratch.contacts.has_open_edges = false;
        scratch.contacts.has_face = false;
        scratch.contacts.has_line = false;
        scratch.contacts.corner_spacing = f64::INFINITY;
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
                    self.examine_face(scratch, (sole, &plate), &mut findings, (face, vertices))
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
        (face, vertices): (&Face, &[DVec3]),
    ) {
        let tolerance = self.config.plane_distance_max;
        let buffer = &mut scratch.clip;
        buffer.polygon.clear();
        buffer.polygon.extend(vertices.iter().map(|&v| sole.in_sole(v)));
        let around = bvh::Aabb::of_points(buffer.polygon.iter().copied());
        let alignment = face.normal.dot(sole.normal);
        let obstructs_above = if alignment < -0.5 { -COVER_DEPTH } else { tolerance };
        let is_level = alignment.abs() >= self.carrying_cos;
        let may_tip = alignment > 0.0 && around.max.z > -tolerance;
        if !plate.overlaps(&around) || !is_level && !may_tip && around.max.z <= obstructs_above {
            return;
        }
        clip_to_sides(buffer, &sole.sides, 0.0);
        let incline = incline(alignment);
        if !is_level && may_tip {
            self.add_steep_ground(scratch, face.kind, incline);
        }
        let clipped = bvh::Aabb::of_points(scratch.clip.polygon.iter().copied());
        let (lowest, highest) = (clipped.min.z, clipped.max.z);
        findings.faces_down |= alignment <= -self.carrying_cos && lowest.abs() <= tolerance;
        if highest > obstructs_above && lowest < self.config.plate_height {
            self.find_intrusion(&mut scratch.clip, sole, findings, obstructs_above);
        }
        if alignment >= self.carrying_cos && (sole.is_braced || self.is_flat_enough(face.normal)) {
            self.clip_to_plane(&mut scratch.clip);
            let is_reliable =
                face.of_mesh() || width(&scratch.clip.polygon) >= self.config.contact_width_min;
            for_each_touching_part(scratch, sole, |scratch, _| {
                self.touch_face(scratch, sole, (face, vertices), incline, is_reliable);
            });
        }
    }

    /// Adds the part of a face that does not carry, in the clip buffer, to the ground on which the
    /// foot may tilt. Surfaces above the plate are no ground; those that pass through it obstruct.
    fn add_steep_ground(&self, scratch: &mut Scratch, kind: FaceKind, incline: f64) {
        let is_ground = match kind {
            FaceKind::Solid | FaceKind::Mesh => true,
            FaceKind::CylinderSide => false,
            FaceKind::CylinderCap => incline <= SLOPE_MAX,
        };
        if !is_ground {
            return;
        }
        let heights = -self.config.plane_distance_max..=self.config.plate_height;
        let drop = if incline <= SLOPE_MAX { self.config.foot_shift * incline } else { 0.0 };
        for &at in scratch.clip.polygon.iter().filter(|point| heights.contains(&point.z)) {
            scratch.contacts.ground.push(GroundPoint { at, drop, is_carrying: false });
        }
    }

    /// Adds the part of a face in the clip buffer that stands in the plate, higher than
    /// `obstructs_above` (m), to the findings.
    fn find_intrusion(
        &self,
        buffer: &mut ClipBuffer,
        sole: &PosedSole,
        findings: &mut Findings,
        obstructs_above: f64,
    ) {
        clip_to_sides(buffer, &sole.sides, OUTLINE_INSET);
        clip(&mut buffer.polygon, &mut buffer.spare, |p| self.config.plate_height - p.z);
        let obstructing = buffer.polygon.iter().filter(|p| p.z > obstructs_above);
        obstructing.for_each(|p| findings.intrude(*p));
    }

    /// Clips the buffer to the part near enough to the sole plane to carry.
    fn clip_to_plane(&self, buffer: &mut ClipBuffer) {
        let tolerance = self.config.plane_distance_max;
        clip(&mut buffer.polygon, &mut buffer.spare, |p| tolerance - p.z);
        clip(&mut buffer.polygon, &mut buffer.spare, |p| tolerance + p.z);
    }

    /// Adds the part of a face in the clip buffer, which a part of the sole touches. One that is
    /// not reliable supports nothing, but a foot that touches it may tilt about it.
    fn touch_face(
        &self,
        scratch: &mut Scratch,
        sole: &PosedSole,
        (face, vertices): (&Face, &[DVec3]),
        incline: f64,
        is_reliable: bool,
    ) {
        let drop = self.config.foot_shift * incline;
        scratch.contacts.add_ground(&scratch.clip.polygon, drop);
        if face.of_mesh() && drop > 0.0 {
            self.add_inner_ground(scratch, sole, vertices, drop);
        }
        if !is_reliable {
            return;
        }
        let buffer = &mut scratch.clip;
        if self.config.is_secured && !face.of_mesh() {
            clip_inside(buffer, sole, vertices, self.edge_inset());
        }
        scratch.contacts.has_open_edges |= face.of_mesh();
        scratch.contacts.has_face |= !scratch.clip.polygon.is_empty();
        if face.of_mesh() && incline > EVEN_INCLINE_MAX {
            let spacing = &mut scratch.contacts.corner_spacing;
            *spacing = shortest_edge(vertices).min(*spacing);
        }
        scratch.contacts.add_all(&scratch.clip.polygon);
    }

    /// Adds the corners of the part of a face in the clip buffer in which a foot beside its place
    /// finds this face and no other: it is lower there by no more than `drop` (m), although a
    /// corner of the face may be lower, beside a steeper one.
    fn add_inner_ground(
        &self,
        scratch: &mut Scratch,
        sole: &PosedSole,
        vertices: &[DVec3],
        drop: f64,
    ) {
        let whole = BoundedPolygon::from_slice(&scratch.clip.polygon).unwrap_or_default();
        clip_inside(&mut scratch.clip, sole, vertices, self.config.foot_shift);
        scratch.contacts.add_ground(&scratch.clip.polygon, drop);
        scratch.clip.polygon.clear();
        scratch.clip.polygon.extend_from_slice(&whole);
    }

    /// How far a secured support stays inside the edges of the ground, m.
    fn edge_inset(&self) -> f64 {
        self.config.foot_shift + SAMPLE_SPACING
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
        // A foot beside its place stands beside the line.
        let drop = 0.5 * self.config.foot_shift.powi(2) / curved.radius;
        if curved.ends == SurfaceEnds::Spherical {
            if let Some(point) = self.intrusion_of_curved(sole, curved, a, b) {
                findings.intrude(point);
            }
            for end in [a, b] {
                let point = end + DVec3::Z * curved.radius;
                if point.z.abs() <= tolerance && sole.touches(point.truncate()) {
                    scratch.contacts.add(point.truncate());
                    scratch.contacts.add_ground(&[point], drop);
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
        self.clip_to_plane(buffer);
        for_each_touching_part(scratch, sole, |scratch, sides| {
            let buffer = &mut scratch.clip;
            scratch.contacts.add_ground(&buffer.polygon, drop);
            if self.config.is_secured {
                self.keep_from_ends(buffer, [a, b]);
                // Samples on both sides of a line find it.
                clip_to_sides(buffer, sides, SAMPLE_SPACING);
            }
            scratch.contacts.has_line |= !scratch.clip.polygon.is_empty();
            scratch.contacts.add_all(&scratch.clip.polygon);
        });
    }

    /// Clips the line on which a sole touches a curved surface with this axis (sole frame) to the
    /// part far enough from the surface's ends.
    fn keep_from_ends(&self, buffer: &mut ClipBuffer, [a, b]: [DVec3; 2]) {
        let along = (b - a).normalize_or_zero();
        let (first, last) = (along.dot(a) + self.edge_inset(), along.dot(b) - self.edge_inset());
        clip(&mut buffer.polygon, &mut buffer.spare, |p| along.dot(p) - first);
        clip(&mut buffer.polygon, &mut buffer.spare, |p| last - along.dot(p));
    }

    /// The highest point of a capsule or ball with the axis `a b` (sole frame) within the plate
    /// above the sole, if it stands in the plate.
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

    /// The support that the collected contact points span.
    fn evaluate_contacts(
        &self,
        scratch: &mut Scratch,
        sole: &PosedSole,
        area_min: f64,
    ) -> Result<Support, NoSupport> {
        let contacts = &mut scratch.contacts;
        // A foot beside its place finds the lines lower, and the faces where they were.
        let has_open_edges = contacts.has_open_edges || contacts.has_face && contacts.has_line;
        let is_uneven = contacts.corner_spacing.is_finite();
        let Contacts { points, hull, spare, ground, area_max, corner_spacing, .. } = contacts;
        if ground.is_full() {
            return Err(NoSupport::TooManyElements);
        }
        convex_hull(points, hull);
        simplify(hull, POLYGON_VERTICES_MAX);
        // Cutting off parts of it only takes from the area.
        *area_max = area_and_centroid(hull).0;
        if *area_max < area_min {
            return Err(NoSupport::AreaTooSmall);
        }
        clip_to_held(hull, spare, ground, self.config.centre_height);
        simplify(hull, POLYGON_VERTICES_MAX);
        if self.config.is_secured && has_open_edges {
            let pads = sole.pads.iter().map(Vec::as_slice);
            let whole = sole.pads.is_empty().then_some(sole.outline);
            let touching = (!is_uneven).then(|| pads.chain(whole).flatten().copied());
            keep_from_ground_edges(hull, spare, touching, self.edge_inset());
        }
        let (area, centroid) = area_and_centroid(hull);
        *area_max = area;
        if area < area_min {
            return Err(NoSupport::AreaTooSmall);
        }
        let edge_distance = inner_distance(hull, centroid);
        if edge_distance < self.config.centroid_edge_distance_min {
            return Err(NoSupport::CentroidNearEdge);
        }
        let polygon = hull.iter().copied().collect();
        Ok(Support { polygon, area, edge_distance, corner_spacing: *corner_spacing })
    }
}

/// Passes the sides of each part of the sole that touches level ground, with as much of the clip
/// buffer, which lies within the outline, as lies within that part.
fn for_each_touching_part(
    scratch: &mut Scratch,
    sole: &PosedSole,
    mut touch: impl FnMut(&mut Scratch, &Sides),
) {
    let within_sole = BoundedPolygon::from_slice(&scratch.clip.polygon).unwrap_or_default();
    for sides in sole.touching() {
        scratch.clip.polygon.clear();
        scratch.clip.polygon.extend_from_slice(&within_sole);
        if !sole.pads.is_empty() {
            clip_to_sides(&mut scratch.clip, &sides, 0.0);
        }
        touch(scratch, &sides);
    }
}

/// Clips the buffer to the part of a face that is `inset` (m) inside its edges.
fn clip_inside(buffer: &mut ClipBuffer, sole: &PosedSole, vertices: &[DVec3], inset: f64) {
    let corner = |index: usize| sole.in_sole(vertices[index % vertices.len()]).truncate();
    for index in 0..vertices.len() {
        let inside = HalfPlane::left_of(corner(index), corner(index + 1));
        let depth = |point: DVec3| inside.depth(point.truncate()) - inset;
        clip(&mut buffer.polygon, &mut buffer.spare, depth);
    }
}

/// The shortest edge of a face, m.
fn shortest_edge(vertices: &[DVec3]) -> f64 {
    let next = vertices.iter().cycle().skip(1);
    vertices.iter().zip(next).map(|(a, b)| a.distance(*b)).fold(f64::INFINITY, f64::min)
}

impl Contacts {
    /// Finds whether the sole tilts. Parts of a sole with pads lie above its plane.
    fn find_tilt(&mut self, sole: &PosedSole) {
        let middle = area_and_centroid(sole.outline).1;
        self.is_tilting = sole.pads.is_empty() && tilts(&self.ground, middle);
    }

    /// Adds the vertices of a polygon in the sole frame.
    fn add_all(&mut self, polygon: &[DVec3]) {
        polygon.iter().for_each(|point| self.add(point.truncate()));
    }

    /// Adds the vertices of a polygon in the sole frame, lower by `drop` (m), to the ground that
    /// carries.
    fn add_ground(&mut self, polygon: &[DVec3], drop: f64) {
        let point = |&at: &DVec3| GroundPoint { at, drop, is_carrying: true };
        polygon.iter().map(point).for_each(|point| self.ground.push(point));
    }

    /// Adds a contact point. A full list is first reduced to its hull, which loses nothing.
    fn add(&mut self, point: DVec2) {
        if self.points.is_full() {
            convex_hull(&mut self.points, &mut self.hull);
            self.points.clear();
            for &corner in &self.hull {
                self.points.push(corner);
            }
        }
        self.points.push(point);
    }
}
