//! Placements read off the geometry: on the planes near the ideal, wholly on a face, or across a pair of features.

use std::f64::consts::FRAC_PI_2;

use glam::{DQuat, DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::message::limits::POLYGON_VERTICES_MAX;
use surefoot_shared_types::spatial::{rotation_about, wrap_angle, yaw_of};

use super::polygon::area_and_centroid;
use super::pose_on_plane;
use super::propose::Request;
use super::regions::{extent, narrowest_direction, shift_onto, shift_to_centre, shift_within};
use super::scratch::Scratch;
use super::surfaces::{Element, FACE_VERTICES_MAX, Round, Surfaces};

/// Most features of one plane that are proposed on one by one.
const SINGLES_MAX: usize = 12;
/// Most features of one plane that are paired.
const PAIRED_MAX: usize = 8;
/// Most round features whose common tangent planes are tried.
const TANGENT_ROUNDS_MAX: usize = 8;
/// How far inside a face's edges a sole is put: comfortably first, then just so, m.
const EDGE_MARGINS: [f64; 2] = [0.01, 1e-3];
/// Outer spans of a pair, as shares of the sole's extent across it, that a sole may bridge.
const SPAN_SHARES: [f64; 2] = [0.4, 1.3];
/// Shifts along a pair from the place nearest to the ideal, m.
const SHIFTS_ALONG: [f64; 7] = [0.0, 0.07, -0.07, 0.14, -0.14, 0.25, -0.25];
/// Turns away from straight across a pair, rad: askew, a sole reaches further.
const TURNS_ACROSS: [f64; 5] = [0.0, 0.2, -0.2, 0.35, -0.35];
/// What a radian of turn costs in the order of candidates, m.
const TURN_COST: f64 = 0.2;
/// What resting only partly costs in the order of candidates, m.
const PARTIAL_COST: f64 = 0.05;

/// A plane that a sole may lie in.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plane {
    /// Origin straight above or below the ideal position, z its normal, x the ideal heading.
    pub world_from_plane: Pose,
    /// The normal in the world.
    pub normal: DVec3,
}

/// A feature seen in a plane.
#[derive(Debug, Clone)]
pub(super) struct Footprint {
    /// A face's outline, a line's two ends, or a point; in the plane frame.
    outline: heapless::Vec<DVec2, FACE_VERTICES_MAX>,
    /// The unit direction across its narrow side.
    across: DVec2,
}

/// A placement to examine.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    /// Smaller is tried first, m.
    pub cost: f64,
    /// The placement.
    pub world_from_sole: Pose,
}

/// The sole in a plane frame, turned by `turn` about its own origin; wherever it lies there, it heads where the request lets it.
struct TurnedSole {
    turn: f64,
    rotation: DQuat,
    outline: heapless::Vec<DVec2, POLYGON_VERTICES_MAX>,
}

impl TurnedSole {
    fn extent(&self, direction: DVec2) -> [f64; 2] {
        extent(self.outline.iter().copied(), direction)
    }
}

impl Footprint {
    fn extent(&self, direction: DVec2) -> [f64; 2] {
        extent(self.outline.iter().copied(), direction)
    }
}

impl Surfaces {
    /// Fills `scratch.candidates` for a request whose features are gathered, best first.
    pub(super) fn list_candidates(&self, scratch: &mut Scratch, request: &Request) {
        scratch.candidates.clear();
        self.list_planes(scratch, request);
        for i in 0..scratch.planes.len() {
            if scratch.candidates.is_full() {
                break;
            }
            let plane = scratch.planes[i];
            self.list_footprints(scratch, &plane);
            let mut lister = Lister { scratch, request, plane };
            lister.ideal();
            lister.singles();
            lister.pairs();
        }
        scratch.candidates.sort_unstable_by(|a, b| a.cost.total_cmp(&b.cost).then_with(|| order_of(a).total_cmp(&order_of(b))));
    }

    /// The planes of the gathered features, nearest first, then those tangent to two round features.
    fn list_planes(&self, scratch: &mut Scratch, request: &Request) {
        scratch.planes.clear();
        let mut rounds: heapless::Vec<Round, TANGENT_ROUNDS_MAX> = heapless::Vec::new();
        let ideal = (request.ideal.translation, yaw_of(request.ideal.rotation));
        for i in 0..scratch.features.len() {
            match self.element(scratch.features[i].1) {
                Element::Face(face, vertices) => self.add_plane(scratch, ideal, face.normal, vertices[0]),
                Element::Round(round) => {
                    if let Some(normal) = round.side_normal(DVec3::Z) {
                        self.add_plane(scratch, ideal, normal, round.line_facing(normal)[0]);
                    }
                    let _ignored_beyond_the_nearest = rounds.push(*round);
                }
            }
        }
        for (i, one) in rounds.iter().enumerate() {
            for other in &rounds[..i] {
                if let Some(normal) = common_tangent(one, other) {
                    self.add_plane(scratch, ideal, normal, one.line_facing(normal)[0]);
                }
            }
        }
    }

    /// Adds a plane near the ideal position and heading unless it is too steep or known already.
    fn add_plane(&self, scratch: &mut Scratch, (ideal, yaw): (DVec3, f64), normal: DVec3, point: DVec3) {
        if !self.is_flat_enough(normal) {
            return;
        }
        let below = ideal.truncate() - point.truncate();
        let height = point.z - normal.truncate().dot(below) / normal.z;
        let origin = ideal.truncate().extend(height);
        let tolerance = self.config.plane_distance_max;
        let is_same = |p: &Plane| {
            let apart = (point - p.world_from_plane.translation).dot(p.normal).abs();
            p.normal.dot(normal) >= self.coplanar_cos
                && apart <= tolerance
                && (p.world_from_plane.translation.z - height).abs() <= tolerance
        };
        if !scratch.planes.iter().any(is_same) {
            let world_from_plane = pose_on_plane(origin, normal, yaw);
            scratch.planes.push(Plane { world_from_plane, normal });
        }
    }

    /// The gathered features that lie in a plane, as seen in it, nearest first.
    fn list_footprints(&self, scratch: &mut Scratch, plane: &Plane) {
        scratch.footprints.clear();
        let tolerance = self.config.plane_distance_max;
        let in_plane = |p: DVec3| plane.world_from_plane.inverse_transform_point(p);
        for i in 0..scratch.features.len() {
            let mut outline = heapless::Vec::new();
            match self.element(scratch.features[i].1) {
                Element::Face(face, vertices) => {
                    let is_in_plane = |&v: &DVec3| (v - plane.world_from_plane.translation).dot(plane.normal).abs() <= tolerance;
                    if face.normal.dot(plane.normal) >= self.coplanar_cos && vertices.iter().any(is_in_plane) {
                        outline.extend(vertices.iter().map(|&v| in_plane(v).truncate()));
                    }
                }
                Element::Round(round) => {
                    let normal = round.side_normal(plane.normal).filter(|n| n.dot(plane.normal) >= self.coplanar_cos);
                    let top = normal.map(|n| round.line_facing(n).map(in_plane));
                    let top = top.filter(|ends| ends.iter().all(|p| p.z.abs() <= tolerance));
                    outline.extend(top.iter().flatten().map(|p| p.truncate()));
                }
            }
            if !outline.is_empty() {
                let across = narrowest_direction(&outline).unwrap_or(DVec2::X);
                scratch.footprints.push(Footprint { outline, across });
            }
        }
    }
}

/// Any fixed order among candidates of equal cost.
fn order_of(candidate: &Candidate) -> f64 {
    let p = candidate.world_from_sole.translation;
    p.x + 3.0 * p.y + 7.0 * p.z + 11.0 * candidate.world_from_sole.rotation.z
}

/// The upward normal of the plane that touches two parallel round sides, or two balls, from above.
fn common_tangent(one: &Round, other: &Round) -> Option<DVec3> {
    let along = match (one.direction(), other.direction()) {
        (Some(d), Some(e)) if d.dot(e).abs() > 0.9998 => d,
        (None, None) => (other.a - one.a).cross(DVec3::Z).try_normalize()?,
        _ => return None,
    };
    let between = other.a - one.a;
    let between = between - along * between.dot(along);
    let distance = between.length();
    let lean = (one.radius - other.radius) / distance;
    if distance < 1e-6 || lean.abs() >= 1.0 {
        return None;
    }
    let direction = between / distance;
    let side = along.cross(direction);
    let side = if side.z < 0.0 { -side } else { side };
    Some(direction * lean + side * (1.0 - lean * lean).sqrt())
}

/// Lists the candidates of one plane.
struct Lister<'a, 'r> {
    scratch: &'a mut Scratch,
    request: &'a Request<'r>,
    plane: Plane,
}

impl Lister<'_, '_> {
    /// The sole turned; `None` where the request lets no sole head there.
    fn sole(&self, turn: f64) -> Option<TurnedSole> {
        let rotation = rotation_about(DVec3::Z, turn);
        let (sin, cos) = libm::sincos(turn);
        let outline = || self.request.sole_polygon.iter().take(POLYGON_VERTICES_MAX).map(|p| DVec2::new(cos, sin).rotate(*p)).collect();
        let heads = self.request.heads(self.plane.world_from_plane.rotation * rotation);
        heads.then(|| TurnedSole { turn, rotation, outline: outline() })
    }

    /// Adds the sole turned and then shifted, if within the request's reach.
    fn add(&mut self, sole: &TurnedSole, shift: DVec2, extra_cost: f64) {
        let plane_from_sole = Pose::from_parts(shift.extend(0.0), sole.rotation);
        let world_from_sole = self.plane.world_from_plane * plane_from_sole;
        if self.request.is_near(world_from_sole.translation) {
            let distance = (world_from_sole.translation - self.request.ideal.translation).length();
            let cost = distance + TURN_COST * sole.turn.abs() + extra_cost;
            self.scratch.candidates.push(Candidate { cost, world_from_sole });
        }
    }

    /// The ideal itself.
    fn ideal(&mut self) {
        if let Some(sole) = self.sole(0.0) {
            self.add(&sole, DVec2::ZERO, 0.0);
        }
    }

    /// The ideal moved onto each feature, as it is and turned along the feature's sides.
    fn singles(&mut self) {
        let as_it_is = self.sole(0.0);
        for i in 0..self.scratch.footprints.len().min(SINGLES_MAX) {
            let [aligned, other] = aligned_turns(self.scratch.footprints[i].across).map(|turn| self.sole(turn));
            for sole in [&as_it_is, &aligned, &other].into_iter().flatten() {
                self.single(i, sole);
            }
        }
    }

    fn single(&mut self, feature: usize, sole: &TurnedSole) {
        let footprint = &self.scratch.footprints[feature];
        let whole = EDGE_MARGINS.iter().find_map(|&margin| shift_onto(&footprint.outline, &sole.outline, margin));
        if let Some(shift) = whole {
            self.add(sole, shift, 0.0);
            for share in [0.5, 0.75] {
                self.add(sole, shift * share, PARTIAL_COST);
            }
            return;
        }
        let across = footprint.across;
        let along = across.perp();
        let options = [across, along].map(|d| shifts_over(footprint.extent(d), sole.extent(d)));
        for &over in &options[0] {
            for &lengthwise in &options[1] {
                self.add(sole, across * over + along * lengthwise, PARTIAL_COST);
            }
        }
    }

    /// The sole across each pair of neighbouring parallel features.
    fn pairs(&mut self) {
        let count = self.scratch.footprints.len().min(PAIRED_MAX);
        for i in 0..count {
            for j in 0..i {
                let (one, other) = (&self.scratch.footprints[i], &self.scratch.footprints[j]);
                let across = one.across;
                if across.dot(other.across).abs() < 0.985 && across.perp_dot(other.across).abs() < 0.985 {
                    continue;
                }
                self.pair(i, j, across);
                self.pair(i, j, across.perp());
            }
        }
    }

    /// The sole across features `i` and `j`, which lie apart along `across`.
    fn pair(&mut self, i: usize, j: usize, across: DVec2) {
        let (one, other) = (&self.scratch.footprints[i], &self.scratch.footprints[j]);
        let [a, b] = [one.extent(across), other.extent(across)];
        let along = across.perp();
        let [c, d] = [one.extent(along), other.extent(along)];
        let lengthwise = [c[0].max(d[0]), c[1].min(d[1])];
        let lie_apart = a[1] <= b[0] || b[1] <= a[0];
        if !lie_apart || lengthwise[0] >= lengthwise[1] {
            return;
        }
        let outer = [a[0].min(b[0]), a[1].max(b[1])];
        for aligned in aligned_turns(across) {
            for skew in TURNS_ACROSS {
                self.across_pair(outer, lengthwise, across, wrap_angle(aligned + skew));
            }
        }
        self.across_pair(outer, lengthwise, across, 0.0);
    }

    fn across_pair(&mut self, outer: [f64; 2], lengthwise: [f64; 2], across: DVec2, turn: f64) {
        if self.scratch.candidates.is_full() {
            return;
        }
        let Some(sole) = self.sole(turn) else { return };
        let along = across.perp();
        let (reach, length) = (sole.extent(across), sole.extent(along));
        let share = (outer[1] - outer[0]) / (reach[1] - reach[0]);
        if !(SPAN_SHARES[0]..=SPAN_SHARES[1]).contains(&share) {
            return;
        }
        let centred = shift_to_centre(outer, reach);
        let nearest = shift_within(reach, outer, 0.0).map_or(centred, |outer_into_sole| -outer_into_sole);
        let lengthwise_at = |wish: f64| {
            let moved = [length[0] + wish, length[1] + wish];
            wish + shift_within(lengthwise, moved, EDGE_MARGINS[1]).unwrap_or_else(|| shift_to_centre(lengthwise, moved))
        };
        let start = lengthwise_at(0.0);
        for over in [centred, nearest] {
            for shift in SHIFTS_ALONG {
                self.add(&sole, across * over + along * lengthwise_at(start + shift), 0.0);
            }
        }
    }
}

/// The two smallest turns that align a sole, heading along x, with a direction or its perpendicular: first the smaller.
fn aligned_turns(direction: DVec2) -> [f64; 2] {
    let angle = libm::atan2(direction.y, direction.x);
    let nearest = angle - FRAC_PI_2 * libm::round(angle / FRAC_PI_2);
    [nearest, if nearest > 0.0 { nearest - FRAC_PI_2 } else { nearest + FRAC_PI_2 }]
}

/// Where to shift a sole over a feature in one direction: into it if it fits; else centred, or flush with either end.
fn shifts_over(face: [f64; 2], sole: [f64; 2]) -> heapless::Vec<f64, 3> {
    let fitting = EDGE_MARGINS.iter().find_map(|&margin| shift_within(face, sole, margin));
    match fitting {
        Some(shift) => heapless::Vec::from_iter([shift]),
        None => heapless::Vec::from_array([
            shift_to_centre(face, sole),
            face[0] + EDGE_MARGINS[0] - sole[0],
            face[1] - EDGE_MARGINS[0] - sole[1],
        ]),
    }
}

/// The centre of a sole polygon in the sole frame.
pub(super) fn centre_of(sole_polygon: &[DVec2]) -> DVec2 {
    area_and_centroid(sole_polygon).1
}
