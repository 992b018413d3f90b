//! The contacts of a span: where forces may act, and how friction bounds them.

use glam::{DMat3, DVec2, DVec3};
use heapless::Vec as BoundedVec;
use surefoot_shared_types::base::limits::POLYGON_VERTICES_MAX;
use surefoot_shared_types::message::Contact;

use crate::constraints::foothold::Ground;
use crate::geometry::polygon::{least_width, outward_sides};
use crate::timing::friction_pyramid::FrictionPyramid;
use crate::timing::limits::Level;
use crate::timing::path_point::PathSpan;
use crate::timing::tuning::{
    INCLINED_COSINE, TWIST_ARM_SHARE, TWIST_ARM_SHARE_INCLINED, TWIST_ARM_SHARE_ROUGH,
};

/// A polygon of a sole, m.
pub(crate) type SolePolygon = BoundedVec<DVec2, { 2 * POLYGON_VERTICES_MAX }>;

/// Force (N) and moment about its centre (N m) of a contact.
pub type FootWrench = (DVec3, DVec3);

/// The supported part of a sole, in its frame.
pub(crate) fn supported_part(contact: &Contact) -> SolePolygon {
    contact.polygon().iter().map(|&corner| DVec2::from(corner)).collect()
}

/// The stance feet of a span.
#[derive(Debug, Clone, Default)]
pub struct Support {
    /// The left foot first.
    pub feet: BoundedVec<FootSupport, 2>,
}

/// A stance foot: the part of its sole within which the centre of pressure stays.
#[derive(Debug, Clone)]
pub struct FootSupport {
    /// The foot.
    pub limb: usize,
    /// Its centre in the world, m.
    pub center: DVec3,
    /// The polygon about the centre in the axes of the sole, m.
    pub polygon: SolePolygon,
    /// Distance from the centre of pressure at which friction holds the moment about the normal of
    /// the only stance sole, m.
    pub twist_arm: f64,
    /// Axes of the sole in the world.
    pub axes: DMat3,
    /// What friction holds.
    pub friction: FrictionPyramid,
}

/// The stance feet of a span at each of its levels.
#[derive(Debug)]
pub(crate) struct SpanSupports {
    levels: &'static [Level],
    supports: BoundedVec<Support, { Level::ALL.len() }>,
}

impl SpanSupports {
    /// The contacts of a span at some levels, the strictest first; the centre of pressure is
    /// `extra` (m) further inside than at a level.
    pub fn new(span: &PathSpan, levels: &'static [Level], extra: f64, friction: f64) -> Self {
        let support = |&level: &Level| Support::new(span, level, extra, friction);
        Self { levels, supports: levels.iter().map(support).collect() }
    }

    /// The levels, the strictest first.
    pub fn levels(&self) -> &'static [Level] {
        self.levels
    }

    /// The next level after one, which leaves more: one of these, or that at which no contact
    /// forces are known.
    pub fn next(&self, level: Level) -> Option<Level> {
        let known = self.levels.iter().copied().find(|at| *at > level);
        known.or((level < Level::Unsupported).then_some(Level::Unsupported))
    }

    /// The feet at a level, or at the next one of these levels; at the last one where no contact
    /// forces are known.
    pub fn at(&self, level: Level) -> &Support {
        let place = self.levels.iter().position(|at| *at >= level);
        &self.supports[place.unwrap_or(self.supports.len() - 1)]
    }
}

impl Support {
    /// The contacts of a span at a level, `extra` (m) further inside.
    pub fn new(span: &PathSpan, level: Level, extra: f64, friction: f64) -> Self {
        let foot = |contact: &Contact| {
            let ground = span.grounds[contact.limb as usize];
            FootSupport::new((contact, ground), level, extra, friction)
        };
        Self { feet: span.contacts.iter().map(foot).collect() }
    }

    /// A point (world, m) about which moments are taken.
    pub fn reference(&self) -> DVec3 {
        self.feet.first().map_or(DVec3::ZERO, |foot| foot.center)
    }
}

impl FootSupport {
    fn new((contact, ground): (&Contact, Ground), level: Level, extra: f64, friction: f64) -> Self {
        let sole = supported_part(contact);
        let width = least_width(&sole);
        let mut polygon = inset(&sole, level.cop_margin(width) + extra);
        let middle = polygon.iter().sum::<DVec2>() / polygon.len().max(1) as f64;
        polygon.iter_mut().for_each(|corner| *corner -= middle);
        let world_from_sole = contact.world_from_sole();
        let axes = DMat3::from_quat(world_from_sole.rotation);
        Self {
            limb: contact.limb as usize,
            center: world_from_sole * middle.extend(0.0),
            polygon,
            twist_arm: width.max(WIDTH_MIN) * twist_arm_share(ground, axes.z_axis),
            axes,
            friction: level.friction(&axes, friction),
        }
    }

    /// Points of the world and forces of which every force and moment of the contact is a sum with
    /// factors that are not negative.
    pub fn generators(&self) -> impl Iterator<Item = (DVec3, DVec3)> + '_ {
        self.polygon.iter().flat_map(move |corner| {
            let point = self.center + self.axes * corner.extend(0.0);
            self.friction.edges().map(move |edge| (point, self.axes * edge.extend(1.0)))
        })
    }
}

/// The arm of a sole's twist as a share of the width of its supported part. `normal` is the sole's.
fn twist_arm_share(ground: Ground, normal: DVec3) -> f64 {
    match ground {
        Ground::Rough => TWIST_ARM_SHARE_ROUGH,
        _ if normal.z < INCLINED_COSINE => TWIST_ARM_SHARE_INCLINED,
        Ground::Even | Ground::Uneven => TWIST_ARM_SHARE,
    }
}

/// Least width of a sole that counts, m.
const WIDTH_MIN: f64 = 1e-3;

/// A convex polygon less a margin (m); where it is too narrow for that, less half of it, and so on.
fn inset(polygon: &SolePolygon, margin: f64) -> SolePolygon {
    let mut margin = margin;
    for _ in 0..HALVINGS_MAX {
        let mut kept = polygon.clone();
        for (normal, offset) in outward_sides(polygon) {
            kept = clipped(&kept, normal, offset - margin);
        }
        if kept.len() >= 3 {
            return kept;
        }
        margin *= 0.5;
    }
    polygon.clone()
}

/// Halvings of a margin that a polygon is too narrow for.
const HALVINGS_MAX: usize = 12;
/// Smallest distance of two corners that both stay, m.
const APART_MIN: f64 = 1e-9;

/// The part of a convex polygon with `normal . p <= offset`.
fn clipped(polygon: &SolePolygon, normal: DVec2, offset: f64) -> SolePolygon {
    let mut kept = SolePolygon::new();
    let mut push = |corner: DVec2| {
        if kept.last().is_none_or(|last| last.distance(corner) > APART_MIN) {
            let _only_shrinks = kept.push(corner);
        }
    };
    let Some(&last) = polygon.last() else { return polygon.clone() };
    let (mut a, mut a_depth) = (last, offset - normal.dot(last));
    for &b in polygon {
        let b_depth = offset - normal.dot(b);
        if (a_depth >= 0.0) != (b_depth >= 0.0) {
            push(a + (b - a) * (a_depth / (a_depth - b_depth)));
        }
        if b_depth >= 0.0 {
            push(b);
        }
        (a, a_depth) = (b, b_depth);
    }
    if kept.len() > 1 && kept[0].distance(kept[kept.len() - 1]) <= APART_MIN {
        kept.pop();
    }
    kept
}

/// Feet for the tests of what two feet exert.
#[cfg(test)]
pub(super) mod example_feet {
    use super::*;

    /// A foot whose sole is tilted about x, rad.
    pub(in crate::timing) fn tilted_foot(limb: usize, y: f64, tilt: f64) -> FootSupport {
        let polygon = [(-0.1, -0.05), (0.1, -0.05), (0.1, 0.05), (-0.1, 0.05)].map(DVec2::from);
        FootSupport {
            limb,
            center: DVec3::new(0.05 * y, y, 0.2 * y),
            polygon: polygon.into_iter().collect(),
            twist_arm: 0.05,
            axes: DMat3::from_rotation_x(tilt),
            friction: FrictionPyramid::with_four_sides(0.6),
        }
    }

    /// The sum of both feet's wrenches about the origin.
    pub(in crate::timing) fn about_origin(
        feet: [&FootSupport; 2],
        wrenches: [FootWrench; 2],
    ) -> FootWrench {
        let [a, b] = [0, 1].map(|at| {
            let (force, moment) = wrenches[at];
            (force, moment + feet[at].center.cross(force))
        });
        (a.0 + b.0, a.1 + b.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sole_is_shrunk_on_all_sides() {
        let sole: SolePolygon = [(-0.1, -0.05), (0.1, -0.05), (0.1, 0.05), (-0.1, 0.05)]
            .map(DVec2::from)
            .into_iter()
            .collect();
        assert!((least_width(&sole) - 0.1).abs() < 1e-12);
        assert!((Level::Full.cop_margin(0.1) - 0.015).abs() < 1e-12);
        assert!((Level::Full.cop_margin(0.2) - 0.024).abs() < 1e-12);
        assert!((Level::Inclined.cop_margin(0.1) - 0.027).abs() < 1e-12);
        let inner = inset(&sole, 0.012);
        assert_eq!(inner.len(), 4);
        assert!(
            inner.iter().all(|p| (p.x.abs() - 0.088).abs() + (p.y.abs() - 0.038).abs() < 1e-12)
        );
        let narrow = inset(&sole, 0.08);
        assert!(narrow.iter().all(|p| (p.y.abs() - 0.01).abs() < 1e-12), "half of the margin");
    }

    #[test]
    fn soles_go_through_their_own_levels() {
        let after_full = |is_inclined: bool| {
            let levels = Level::levels(is_inclined);
            let supports = SpanSupports { levels, supports: BoundedVec::new() };
            let mut level = Level::Full;
            let next = move || supports.next(level).inspect(|next| level = *next);
            std::iter::from_fn(next).collect::<Vec<_>>()
        };
        let level = [Level::NarrowSole, Level::Bare, Level::Unsupported];
        assert_eq!(after_full(false), level);
        assert_eq!(after_full(true), [&[Level::Steep], &level[..]].concat());
    }

    #[test]
    fn friction_turns_less_on_a_rough_mesh_and_on_slopes() {
        let mut contact: Contact = bytemuck::Zeroable::zeroed();
        (contact.polygon_len, contact.rotation) = (4, [0.0, 0.0, 0.0, 1.0]);
        let mut sloping = contact;
        sloping.rotation = glam::DQuat::from_rotation_x(0.1).to_array();
        let corners = [[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05]];
        for of in [&mut contact, &mut sloping] {
            of.polygon[..4].copy_from_slice(&corners);
        }
        let arm_of = |contact: &Contact, ground| {
            FootSupport::new((contact, ground), Level::Full, 0.0, 0.6).twist_arm
        };
        let arm = |ground| arm_of(&contact, ground);
        assert_eq!(arm(Ground::Even), arm(Ground::Uneven));
        assert!((arm(Ground::Even) - 0.05).abs() < 1e-12);
        assert!((arm(Ground::Rough) - 0.01).abs() < 1e-12);
        assert!((arm_of(&sloping, Ground::Even) - 0.025).abs() < 1e-12);
        assert!((arm_of(&sloping, Ground::Rough) - 0.01).abs() < 1e-12);
    }
}
