//! Placements read off the geometry: on the planes near the ideal, wholly on a face, or across a
//! pair of features.

use std::f64::consts::FRAC_PI_2;

use glam::{DQuat, DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::POLYGON_VERTICES_MAX;
use surefoot_shared_types::base::spatial::{rotation_about, wrap_angle};

use crate::foot_placement::plane_features::{Candidate, Plane};
use crate::foot_placement::planes::{list_footprints, list_planes};
use crate::foot_placement::request::PlacementQuery;
use crate::foot_placement::scratch::Scratch;
use crate::foot_placement::sole_fit::{extent, shift_onto, shift_to_centre, shift_within};
use crate::foot_placement::surfaces::Surfaces;
use crate::foot_placement::tuning::{
    EDGE_MARGINS, FACE_MARGINS, LINE_WIDTH, PAIR_SHIFTS, PAIRED_MAX, PARALLEL_COS, PARTIAL_COST,
    PARTIAL_SHIFT_SHARES, SINGLES_MAX, SPAN_SHARES, TURN_COST, TURNS_ACROSS,
};

/// The sole in a plane frame, turned by `turn` about its own origin, with a heading that the query
/// allows.
struct TurnedSole {
    /// Turn from the ideal heading, rad.
    turn: f64,
    plane_from_sole: DQuat,
    /// The turned outline, m.
    outline: heapless::Vec<DVec2, POLYGON_VERTICES_MAX>,
}

impl TurnedSole {
    fn extent(&self, direction: DVec2) -> [f64; 2] {
        extent(self.outline.iter().copied(), direction)
    }
}

/// Begins to list candidates for a query whose features are gathered: the ideal on each plane.
pub(crate) fn begin_candidates(surfaces: &Surfaces, scratch: &mut Scratch, query: &PlacementQuery) {
    scratch.candidates.best.clear();
    scratch.candidates.waiting.clear();
    list_planes(surfaces, scratch, query);
    scratch.planes.nearest.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance));
    scratch.planes.listed = 0;
    for i in 0..scratch.planes.nearest.len() {
        let plane = scratch.planes.nearest[i];
        Lister { scratch, query, plane }.ideal();
    }
}

/// Adds the next best candidate to `scratch.candidates.best` and returns whether there was one. A
/// plane's candidates other than the ideal are listed only when one of them may be the next: most
/// queries end after the first few.
pub(crate) fn next_candidate(
    surfaces: &Surfaces,
    scratch: &mut Scratch,
    query: &PlacementQuery,
) -> bool {
    while let Some(&plane) = scratch.planes.nearest.get(scratch.planes.listed)
        && !scratch.candidates.waiting.is_full()
        && scratch.candidates.waiting.peek().is_none_or(|next| plane.distance < next.cost)
    {
        scratch.planes.listed += 1;
        list_footprints(surfaces, scratch, &plane);
        let mut lister = Lister { scratch, query, plane };
        lister.singles();
        lister.pairs();
    }
    let next = scratch.candidates.waiting.pop();
    next.iter().for_each(|candidate| scratch.candidates.best.push(*candidate));
    next.is_some()
}

/// Lists the candidates of one plane.
struct Lister<'a, 'r> {
    scratch: &'a mut Scratch,
    query: &'a PlacementQuery<'r>,
    plane: Plane,
}

impl Lister<'_, '_> {
    /// The sole turned by `turn` (rad), or `None` if the query does not allow its heading.
    fn sole(&self, turn: f64) -> Option<TurnedSole> {
        let rotation = rotation_about(DVec3::Z, turn);
        let (sin, cos) = libm::sincos(turn);
        let outline = || {
            self.query
                .sole
                .outline
                .iter()
                .take(POLYGON_VERTICES_MAX)
                .map(|p| DVec2::new(cos, sin).rotate(*p))
                .collect()
        };
        let is_allowed = self.query.is_heading(self.plane.world_from_plane.rotation * rotation);
        is_allowed.then(|| TurnedSole { turn, plane_from_sole: rotation, outline: outline() })
    }

    /// Adds the turned sole at a shift (m) in the plane, if within the query's reach.
    fn add(&mut self, sole: &TurnedSole, shift: DVec2, extra_cost: f64) {
        let position = self.plane.world_from_plane * shift.extend(0.0);
        if self.query.is_near(position) {
            let world_from_sole = Pose::from_parts(
                position,
                self.plane.world_from_plane.rotation * sole.plane_from_sole,
            );
            let cost = (position - self.query.ideal.translation).length()
                + TURN_COST * sole.turn.abs()
                + extra_cost;
            self.scratch.candidates.waiting.push(Candidate { cost, world_from_sole });
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
        for i in 0..self.scratch.planes.footprints.len().min(SINGLES_MAX) {
            let [aligned, other] =
                aligned_turns(self.scratch.planes.footprints[i].across).map(|turn| self.sole(turn));
            for sole in [&as_it_is, &aligned, &other].into_iter().flatten() {
                self.single(i, sole);
            }
        }
    }

    /// The sole shifted onto one feature: wholly if it fits, else partly.
    fn single(&mut self, feature: usize, sole: &TurnedSole) {
        let footprint = &self.scratch.planes.footprints[feature];
        let whole = EDGE_MARGINS
            .iter()
            .find_map(|&margin| shift_onto(&footprint.outline, &sole.outline, margin));
        if let Some(shift) = whole {
            self.add(sole, shift, 0.0);
            for share in PARTIAL_SHIFT_SHARES {
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
        let count = self.scratch.planes.footprints.len().min(PAIRED_MAX);
        let span_max = SPAN_SHARES[1] * 2.0 * self.query.sole_radius();
        for i in 0..count {
            for j in 0..i {
                let (one, other) =
                    (&self.scratch.planes.footprints[i], &self.scratch.planes.footprints[j]);
                let across = one.across;
                if across.dot(other.across).abs() < PARALLEL_COS
                    && across.perp_dot(other.across).abs() < PARALLEL_COS
                {
                    continue;
                }
                self.pair(i, j, across, span_max);
                self.pair(i, j, across.perp(), span_max);
            }
        }
    }

    /// The sole across features `i` and `j`, if these are separate along `across` and span less
    /// than `span_max` (m).
    fn pair(&mut self, i: usize, j: usize, across: DVec2, span_max: f64) {
        let (one, other) = (&self.scratch.planes.footprints[i], &self.scratch.planes.footprints[j]);
        let [a, b] = [one.extent(across), other.extent(across)];
        let along = across.perp();
        let [c, d] = [one.extent(along), other.extent(along)];
        let lengthwise = [c[0].max(d[0]), c[1].min(d[1])];
        let are_separate = a[1] <= b[0] || b[1] <= a[0];
        if !are_separate || lengthwise[0] >= lengthwise[1] {
            return;
        }
        let outer = [a[0].min(b[0]), a[1].max(b[1])];
        if outer[1] - outer[0] > span_max {
            return;
        }
        let is_line = |[from, to]: [f64; 2]| to - from < LINE_WIDTH;
        let margins = if is_line(a) || is_line(b) { &EDGE_MARGINS[..1] } else { &FACE_MARGINS };
        for aligned in aligned_turns(across) {
            for skew in TURNS_ACROSS {
                let turn = wrap_angle(aligned + skew);
                self.across_pair((outer, margins), lengthwise, across, turn);
            }
        }
        self.across_pair((outer, margins), lengthwise, across, 0.0);
    }

    /// The sole turned by `turn` (rad) across a pair: centred on its outer span, and moved over it
    /// by the smallest shift that leaves one of the margins at both ends, if there is one; at
    /// several positions along the pair.
    fn across_pair(
        &mut self,
        (outer, margins): ([f64; 2], &[f64]),
        lengthwise: [f64; 2],
        across: DVec2,
        turn: f64,
    ) {
        if self.scratch.candidates.waiting.is_full() {
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
        let into_sole = margins.iter().find_map(|&margin| shift_within(reach, outer, margin));
        let nearest = into_sole.map(|shift| -shift);
        let lengthwise_at = |desired: f64| {
            let moved = [length[0] + desired, length[1] + desired];
            desired
                + shift_within(lengthwise, moved, EDGE_MARGINS[1])
                    .unwrap_or_else(|| shift_to_centre(lengthwise, moved))
        };
        let start = lengthwise_at(0.0);
        for shift in PAIR_SHIFTS.map(|shift| along * lengthwise_at(start + shift)) {
            for over in [Some(centred), nearest].into_iter().flatten() {
                self.add(&sole, across * over + shift, 0.0);
            }
        }
    }
}

/// The two smallest turns that align a sole, heading along x, with a direction or its
/// perpendicular, the smaller first, rad.
fn aligned_turns(direction: DVec2) -> [f64; 2] {
    let angle = libm::atan2(direction.y, direction.x);
    let nearest = angle - FRAC_PI_2 * libm::round(angle / FRAC_PI_2);
    [nearest, if nearest > 0.0 { nearest - FRAC_PI_2 } else { nearest + FRAC_PI_2 }]
}

/// Shifts of a sole over a feature in one direction, m: into it if it fits, else centred and flush
/// with either end.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::foot_placement::config::FootPlacementConfig;
    use crate::foot_placement::features::gather;
    use crate::foot_placement::posed_sole::SoleShape;
    use crate::foot_placement::request::SampleLimits;
    use glam::DVec3;
    use surefoot_shared_types::Shape;
    use surefoot_shared_types::world::world::{World, WorldShape};

    /// Five steps, each 0.12 m above the one before, and three bars beside them.
    fn steps_and_bars() -> Surfaces {
        let block = |index: usize, half_extents: [f64; 3], position: [f64; 3]| WorldShape {
            name: format!("block {index}"),
            world_from_shape: Pose::from_translation(DVec3::from(position)),
            shape: Shape::Box { half_extents: DVec3::from(half_extents) },
        };
        let steps =
            (0..5).map(|i| block(i, [0.15, 0.4, 0.06], [0.3 * i as f64, 0.0, 0.12 * i as f64]));
        let bars = (0..3).map(|i| block(5 + i, [0.02, 0.5, 0.02], [0.14 * i as f64, 0.9, 0.3]));
        let world =
            World { mu: 0.6, shapes: steps.chain(bars).collect(), digest: Default::default() };
        Surfaces::new(&world, FootPlacementConfig::default()).unwrap()
    }

    fn costs(surfaces: &Surfaces, scratch: &mut Scratch, query: &PlacementQuery) -> Vec<f64> {
        while next_candidate(surfaces, scratch, query) {}
        scratch.candidates.best.iter().map(|candidate| candidate.cost).collect()
    }

    #[test]
    fn listing_planes_on_demand_gives_the_same_candidates_as_listing_all_at_once() {
        let surfaces = steps_and_bars();
        let mut scratch = Scratch::new(surfaces.config());
        let sole_polygon =
            [(-0.1, -0.05), (0.1, -0.05), (0.1, 0.05), (-0.1, 0.05)].map(|(x, y)| DVec2::new(x, y));
        for i in 0..24 {
            let ideal = Pose::from_translation(DVec3::new(
                0.07 * i as f64,
                0.05 * i as f64,
                0.03 * i as f64,
            ));
            let query = PlacementQuery {
                sole: SoleShape::flat(&sole_polygon),
                ideal,
                reach_xy: 0.35,
                reach_z: [-0.5, 0.5],
                yaw_spread: 0.8,
                seed: 1,
                object: 0,
                attempt: 0,
                limits: SampleLimits::default(),
                is_free: &|_| true,
            };
            gather(&surfaces, &mut scratch, &query);
            begin_candidates(&surfaces, &mut scratch, &query);
            let on_demand = costs(&surfaces, &mut scratch, &query);
            assert!(on_demand.windows(2).all(|pair| pair[0] <= pair[1] + 1e-9), "best first");
            begin_candidates(&surfaces, &mut scratch, &query);
            scratch.planes.nearest.iter_mut().for_each(|plane| plane.distance = 0.0);
            let at_once = costs(&surfaces, &mut scratch, &query);
            assert!(
                on_demand.iter().zip(&at_once).all(|(one, other)| (one - other).abs() < 1e-9)
                    && on_demand.len() == at_once.len()
            );
            assert_eq!(scratch.dropped(), 0);
        }
    }
}
