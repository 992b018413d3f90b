//! Nested placements: a sole on a face too steep to hold it alone, kept from sliding by a second
//! face against its edge, as in the concave M of figure 4.11 [Grey 4.2.3]. Random planes do not
//! find them: too steep a plane is rejected, and the edge would have to meet the valley exactly.
//!
//! A walk cannot use them: planner and checker count only forces under the sole. So they have a
//! query of their own.

use std::ops::ControlFlow;

use glam::{DMat3, DQuat, DVec2, DVec3};
use parry3d_f64::bounding_volume::Aabb;
use surefoot_shared_types::Pose;

use crate::foot_placement::elements::{Element, Face};
use crate::foot_placement::features::{keep_nearest, list_feature};
use crate::foot_placement::plane_features::Candidate;
use crate::foot_placement::posed_sole::SupportRequirement;
use crate::foot_placement::proposal::Proposal;
use crate::foot_placement::request::{PlacementQuery, PlacementStats, Source, SupportedSole};
use crate::foot_placement::scratch::Scratch;
use crate::foot_placement::sole_support::{NoSupport, Support};
use crate::foot_placement::surfaces::Surfaces;
use crate::foot_placement::tuning::{
    NEST_EDGE_GAP, NEST_NORMAL_Z_MIN, VALLEY_GAP, VALLEY_RISE_MAX, VALLEY_SHIFTS,
};
use crate::geometry::polygon::{edges, inward_normal};

/// The line in which a steep face and a face that stands against it meet.
struct Valley {
    /// A point of it.
    point: DVec3,
    /// Its unit direction.
    along: DVec3,
    /// The unit direction from it up the steep face.
    uphill: DVec3,
    /// The steep face's normal.
    normal: DVec3,
    /// The other face's normal.
    against: DVec3,
    /// The range in which both faces reach it, m along it from `point`.
    span: [f64; 2],
}

/// Passes nested placements within reach to `out`, nearest first, until it returns `false`.
/// Friction on both faces holds each of them with the centre of mass above the middle of the
/// sole's support.
pub fn propose_nests(
    surfaces: &Surfaces,
    scratch: &mut Scratch,
    query: &PlacementQuery,
    out: &mut dyn FnMut(SupportedSole) -> bool,
) -> PlacementStats {
    let mut proposal = Proposal::new(surfaces, scratch, query, out);
    if query.is_finite() && query.sole.outline.len() >= 3 {
        proposal.stats.stopped = try_valleys(&mut proposal).is_break();
    }
    proposal.stats
}

/// Lists the nearest faces within reach that are flat enough to be nested on.
fn gather_slopes(surfaces: &Surfaces, scratch: &mut Scratch, query: &PlacementQuery) {
    let region: Aabb = query.region(1.0);
    scratch.features.clear();
    for id in surfaces.elements_in(&region).take(surfaces.config().support_elements_max) {
        let Element::Face(face, _) = surfaces.element(id) else { continue };
        if face.normal.z < NEST_NORMAL_Z_MIN {
            continue;
        }
        list_feature(surfaces, scratch, query, id);
    }
    keep_nearest(scratch, surfaces.config().features_max);
}

/// The valley in which a steep face meets another face, if they meet in one.
fn valley_of(surfaces: &Surfaces, steep: u32, other: u32, near: DVec3) -> Option<Valley> {
    let (Element::Face(steep, steep_corners), Element::Face(other, other_corners)) =
        (surfaces.element(steep), surfaces.element(other))
    else {
        return None;
    };
    if surfaces.is_flat_enough(steep.normal) {
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

/// The point nearest to `near` on the line in which two faces' planes meet.
fn point_of_both(one: &Face, other: &Face, along: DVec3, near: DVec3) -> Option<DVec3> {
    let rows = DMat3::from_cols(one.normal, other.normal, along).transpose();
    let point = rows.inverse() * DVec3::new(one.offset, other.offset, along.dot(near));
    point.is_finite().then_some(point)
}

/// The range in which a face reaches a line in its plane, m along the line from `point`; an empty
/// range (infinity, minus infinity) if it does not.
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
            self.point + self.along * shift + self.uphill * (NEST_EDGE_GAP + furthest),
            rotation,
        )
    }

    /// Whether friction on both faces carries a weight above the middle of a support. `friction` is
    /// the friction angle, rad.
    ///
    /// Two forces carry a weight only if all three meet in a point. Seen along the valley, the
    /// other face's force passes through the nested edge at an angle between `against - friction`
    /// and `against + friction` from the vertical. The steep face's force passes through the
    /// support's far end. Its angle must lie between `slope - friction` and `slope + friction`.
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
        // The forces meet above the middle; from there follows the angle of the steep face's force.
        let needed =
            |angle: f64| libm::atan2(far.x - middle.x, middle.x / libm::tan(angle) - far.y);
        needed(flattest) <= slope + friction && needed(steepest) >= slope - friction
    }
}

/// Tries the valley of every ordered pair of faces.
fn try_valleys(proposal: &mut Proposal<'_, '_>) -> ControlFlow<()> {
    let surfaces = proposal.surfaces;
    gather_slopes(surfaces, proposal.scratch, proposal.query);
    let count = proposal.scratch.features.len();
    proposal.stats.features = count as u32;
    for (i, j) in (0..count).flat_map(|i| (0..count).map(move |j| (i, j))).filter(|(i, j)| i != j) {
        let [steep, other] = [i, j].map(|k| proposal.scratch.features[k].1);
        let near = proposal.query.ideal.translation;
        if let Some(valley) = valley_of(surfaces, steep, other, near) {
            try_valley(proposal, &valley)?;
        }
    }
    ControlFlow::Continue(())
}

/// Tries the sole with each of its edges in a valley, nearest to the ideal first.
fn try_valley(proposal: &mut Proposal<'_, '_>, valley: &Valley) -> ControlFlow<()> {
    let query = proposal.query;
    let candidates = &mut proposal.scratch.candidates.best;
    candidates.clear();
    for (a, b) in edges(query.sole.outline) {
        let outward = -inward_normal(a, b);
        for shift in VALLEY_SHIFTS {
            let shift = shift.clamp(valley.span[0], valley.span[1]);
            let world_from_sole = valley.world_from_sole(query.sole.outline, outward, shift);
            if query.is_in_reach(&world_from_sole) {
                let cost = (world_from_sole.translation - query.ideal.translation).length();
                candidates.push(Candidate { cost, world_from_sole });
            }
        }
    }
    candidates.sort_unstable_by(|a, b| a.cost.total_cmp(&b.cost));
    for i in 0..candidates.len() {
        let pose = proposal.scratch.candidates.best[i].world_from_sole;
        examine_nest(proposal, valley, pose)?;
    }
    ControlFlow::Continue(())
}

/// Returns a nested placement to the caller if friction on both faces holds it and the foot is
/// free there.
fn examine_nest(
    proposal: &mut Proposal<'_, '_>,
    valley: &Valley,
    world_from_sole: Pose,
) -> ControlFlow<()> {
    let friction = libm::acos(proposal.surfaces.steepest_cos);
    proposal.stats.examined[Source::Nested as usize] += 1;
    let requirement =
        SupportRequirement { is_braced: true, any_intrusion: false, ..proposal.requirement(0.0) };
    match proposal.surfaces.support_of(
        proposal.scratch,
        proposal.query.sole,
        &world_from_sole,
        requirement,
    ) {
        Err(reason) => proposal.stats.rejected[reason as usize] += 1,
        Ok(support) if !valley.holds(&world_from_sole, &support, friction) => {
            proposal.stats.rejected[NoSupport::TooSteep as usize] += 1;
        }
        Ok(support) => {
            let _found_or_not_free =
                proposal.return_if_free(world_from_sole, support, Source::Nested)?;
        }
    }
    ControlFlow::Continue(())
}
