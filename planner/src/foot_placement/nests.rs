//! Nested placements: a sole on a face too steep to hold it alone, kept from sliding by a second
//! face that stands against its edge, as in the concave M of figure 4.11. Random planes never find
//! one: too steep a plane is rejected, and the edge would have to meet the valley exactly
//! [Grey 4.2.3].
//!
//! A walk cannot use them yet: planner and checker count forces under the sole only. Hence they
//! have a query of their own.

use std::ops::ControlFlow;

use glam::{DMat3, DQuat, DVec2, DVec3};
use parry3d_f64::bounding_volume::Aabb;
use surefoot_shared_types::Pose;

use crate::base::random::{Random, Stream};
use crate::foot_placement::candidates::Candidate;
use crate::foot_placement::propose::{
    PlacementQuery, PlacementStats, Proposal, Source, SupportedSole, keep_nearest,
};
use crate::foot_placement::scratch::Scratch;
use crate::foot_placement::sole_support::{NoSupport, Support};
use crate::foot_placement::support::SupportRequirement;
use crate::foot_placement::surfaces::{Element, Face, Surfaces};
use crate::geometry::polygon::{edges, inward_normal};

/// The steepest face that a sole is nested on or against, as its normal's z: 70 degrees.
const NORMAL_Z_MIN: f64 = 0.342;
/// How far a valley may rise along its length, as a sine: the foot must not slide along it either.
const VALLEY_RISE_MAX: f64 = 0.05;
/// How far a face may end from the valley and still count as reaching it, m.
const VALLEY_GAP: f64 = 1e-3;
/// How far the nested edge stays from the valley, m: touching, for a foot that yields by as much.
const EDGE_GAP: f64 = 5e-4;
/// Shifts along the valley from the place nearest to the ideal, m.
const SHIFTS_ALONG: [f64; 5] = [0.0, 0.07, -0.07, 0.14, -0.14];

/// Where a steep face and one that stands against it meet.
struct Valley {
    /// A point of it.
    point: DVec3,
    /// Its direction.
    along: DVec3,
    /// The direction from it up the steep face.
    uphill: DVec3,
    /// The steep face's normal.
    normal: DVec3,
    /// The other face's normal.
    against: DVec3,
    /// From where to where both faces meet in it, m along it from `point`.
    span: [f64; 2],
}

impl Surfaces {
    /// Hands nested placements within reach to `out`, nearest first, until it returns `false`. Each
    /// is held by friction on both faces with the centre of mass above the middle of the sole's
    /// support.
    pub fn propose_nests(
        &self,
        scratch: &mut Scratch,
        query: &PlacementQuery,
        out: &mut dyn FnMut(SupportedSole) -> bool,
    ) -> PlacementStats {
        let random = Random::new(query.seed, Stream::FootPlacement, query.object, query.attempt);
        let mut proposal = Proposal {
            surfaces: self,
            scratch,
            query,
            random,
            stats: PlacementStats::default(),
            out,
        };
        if query.ideal.is_finite() && query.reach_xy.is_finite() && query.sole_polygon.len() >= 3 {
            proposal.stats.stopped = proposal.nest().is_break();
        }
        proposal.stats
    }

    /// Lists the nearest faces within reach that are not too steep to be nested on.
    fn gather_slopes(&self, scratch: &mut Scratch, query: &PlacementQuery) {
        let region: Aabb = query.region(1.0);
        scratch.features.clear();
        for id in self.elements_in(&region).take(self.config.support_elements_max) {
            let Element::Face(face, _) = self.element(id) else { continue };
            if face.normal.z < NORMAL_Z_MIN {
                continue;
            }
            self.list_feature(scratch, query, id);
        }
        keep_nearest(scratch, self.config.features_max);
    }

    /// The valley in which a steep face meets another one, if they do.
    fn valley(&self, steep: u32, other: u32, near: DVec3) -> Option<Valley> {
        let (Element::Face(steep, steep_corners), Element::Face(other, other_corners)) =
            (self.element(steep), self.element(other))
        else {
            return None;
        };
        if self.is_flat_enough(steep.normal) {
            return None;
        }
        let along = steep
            .normal
            .cross(other.normal)
            .try_normalize()
            .filter(|t| t.z.abs() <= VALLEY_RISE_MAX)?;
        let uphill = along.cross(steep.normal);
        let uphill = if uphill.z < 0.0 { -uphill } else { uphill };
        let point = point_of_both(steep, other, along, near)?;
        let [one, two] =
            [steep_corners, other_corners].map(|corners| reach_along(corners, point, along));
        let span = [one[0].max(two[0]), one[1].min(two[1])];
        let is_concave = other.normal.dot(uphill) > 1e-3;
        (is_concave && span[0] < span[1]).then_some(Valley {
            point,
            along,
            uphill,
            normal: steep.normal,
            against: other.normal,
            span,
        })
    }
}

/// The point nearest to `near` on the line in which two faces' planes meet.
fn point_of_both(one: &Face, other: &Face, along: DVec3, near: DVec3) -> Option<DVec3> {
    let rows = DMat3::from_cols(one.normal, other.normal, along).transpose();
    let point = rows.inverse() * DVec3::new(one.offset, other.offset, along.dot(near));
    point.is_finite().then_some(point)
}

/// From where to where a face reaches a line in its plane, m along the line; an empty range
/// (infinity, minus infinity) if it does not.
fn reach_along(corners: &[DVec3], point: DVec3, along: DVec3) -> [f64; 2] {
    let mut reach = [f64::INFINITY, f64::NEG_INFINITY];
    let mut add = |p: DVec3| {
        let at = (p - point).dot(along);
        reach = [reach[0].min(at), reach[1].max(at)];
    };
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let [away_a, away_b] = [a, b].map(|p| (p - point).reject_from_normalized(along));
        if away_a.length() <= VALLEY_GAP {
            add(a);
        }
        if away_a.dot(away_b) < 0.0 {
            add(a + (b - a) * (away_a.length() / (away_a.length() + away_b.length())));
        }
    }
    reach
}

impl Valley {
    /// The sole with its edge whose outward normal is `outward` in the valley, `shift` (m) along
    /// it.
    fn world_from_sole(&self, sole: &[DVec2], outward: DVec2, shift: f64) -> Pose {
        let down = -self.uphill;
        let aside = self.normal.cross(down);
        let x = down * outward.x - aside * outward.y;
        let rotation =
            DQuat::from_mat3(&DMat3::from_cols(x, self.normal.cross(x), self.normal)).normalize();
        let furthest = sole.iter().map(|p| p.dot(outward)).fold(f64::NEG_INFINITY, f64::max);
        Pose::from_parts(
            self.point + self.along * shift + self.uphill * (EDGE_GAP + furthest),
            rotation,
        )
    }

    /// Whether friction on both faces carries a weight above the middle of a support, `friction`
    /// being its angle, rad.
    ///
    /// Two forces carry a weight only if the three meet in a point. Seen along the valley the other
    /// face's force passes through the nested edge, at an angle between `against - friction` and
    /// `against + friction` from the vertical, and the steep face's through the support's far end:
    /// it must lie between `slope - friction` and `slope + friction`.
    fn holds(&self, world_from_sole: &Pose, support: &Support, friction: f64) -> bool {
        let horizontal = self.uphill.truncate().normalize().extend(0.0);
        let height_and_distance =
            |p: DVec3| DVec2::new((p - self.point).dot(horizontal), p.z - self.point.z);
        let in_world = |p: &DVec2| height_and_distance(*world_from_sole * p.extend(0.0));
        let count = support.polygon.len() as f64;
        let middle = support.polygon.iter().map(in_world).sum::<DVec2>() / count;
        let far = support
            .polygon
            .iter()
            .map(in_world)
            .fold(DVec2::ZERO, |far, p| if p.x > far.x { p } else { far });
        let slope = libm::asin(self.uphill.z.clamp(-1.0, 1.0));
        let against = libm::atan2(self.against.dot(horizontal), self.against.z);
        let [flattest, steepest] =
            [against - friction, against + friction].map(|angle| angle.clamp(1e-6, 1.5));
        // Where the forces meet, above the middle; then the angle of the steep face's force.
        let needed =
            |angle: f64| libm::atan2(far.x - middle.x, middle.x / libm::tan(angle) - far.y);
        needed(flattest) <= slope + friction && needed(steepest) >= slope - friction
    }
}

impl Proposal<'_, '_> {
    fn nest(&mut self) -> ControlFlow<()> {
        let surfaces = self.surfaces;
        surfaces.gather_slopes(self.scratch, self.query);
        self.stats.features = self.scratch.features.len() as u32;
        let count = self.scratch.features.len();
        for (i, j) in
            (0..count).flat_map(|i| (0..count).map(move |j| (i, j))).filter(|(i, j)| i != j)
        {
            let [steep, other] = [i, j].map(|k| self.scratch.features[k].1);
            if let Some(valley) = surfaces.valley(steep, other, self.query.ideal.translation) {
                self.try_valley(&valley)?;
            }
        }
        ControlFlow::Continue(())
    }

    /// Tries the sole with each of its edges in a valley, the nearest place first.
    fn try_valley(&mut self, valley: &Valley) -> ControlFlow<()> {
        let query = self.query;
        self.scratch.candidates.clear();
        for (a, b) in edges(query.sole_polygon) {
            let outward = -inward_normal(a, b);
            for shift in SHIFTS_ALONG {
                let shift = shift.clamp(valley.span[0], valley.span[1]);
                let world_from_sole = valley.world_from_sole(query.sole_polygon, outward, shift);
                if query.reaches(&world_from_sole) {
                    let cost = (world_from_sole.translation - query.ideal.translation).length();
                    self.scratch.candidates.push(Candidate { cost, world_from_sole });
                }
            }
        }
        self.scratch.candidates.sort_unstable_by(|a, b| a.cost.total_cmp(&b.cost));
        for i in 0..self.scratch.candidates.len() {
            self.examine_nest(valley, self.scratch.candidates[i].world_from_sole)?;
        }
        ControlFlow::Continue(())
    }

    fn examine_nest(&mut self, valley: &Valley, world_from_sole: Pose) -> ControlFlow<()> {
        self.stats.examined[Source::Nested as usize] += 1;
        let requirement =
            SupportRequirement { is_braced: true, any_intrusion: false, ..self.requirement(0.0) };
        match self.surfaces.support_of(
            self.scratch,
            self.query.sole_polygon,
            &world_from_sole,
            requirement,
        ) {
            Err(reason) => self.stats.rejected[reason as usize] += 1,
            Ok(support)
                if !valley.holds(
                    &world_from_sole,
                    &support,
                    libm::acos(self.surfaces.steepest_cos),
                ) =>
            {
                self.stats.rejected[NoSupport::TooSteep as usize] += 1;
            }
            Ok(support) => {
                let _found_or_not_free = self.hand_out(world_from_sole, support, Source::Nested)?;
            }
        }
        ControlFlow::Continue(())
    }
}
