//! A sole at a pose, and what its support must meet.

use glam::{DMat3, DVec2, DVec3};
use parry3d_f64::bounding_volume::Aabb;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::POLYGON_VERTICES_MAX;

use crate::geometry::bvh;
use crate::geometry::polygon::{Sides, cross, edges, inner_distance, sides_of};
use crate::robot::sole::Sole;

/// Requirements on a support.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SupportRequirement {
    /// The smallest area, m2.
    pub area_min: f64,
    /// Whether surfaces outside the friction cone support the sole, because another face keeps the
    /// foot from sliding.
    pub is_braced: bool,
    /// Whether the first surface found in the outline ends the examination. Otherwise the highest
    /// one is kept.
    pub any_intrusion: bool,
}

/// A sole as the ground meets it. All polygons are convex and counter-clockwise, in its frame, m.
#[derive(Debug, Clone, Copy)]
pub struct SoleShape<'a> {
    /// Its outline.
    pub outline: &'a [DVec2],
    /// The parts of it that touch level ground; empty where all of it does.
    pub pads: &'a [Vec<DVec2>],
}

impl<'a> SoleShape<'a> {
    /// The shape of a robot's sole.
    pub fn of(sole: &'a Sole) -> Self {
        Self { outline: &sole.polygon, pads: &sole.pads }
    }

    /// A sole of which every part touches level ground.
    pub fn flat(outline: &'a [DVec2]) -> Self {
        Self { outline, pads: &[] }
    }
}

/// A sole at a pose.
pub(crate) struct PosedSole<'a> {
    /// The outline in the sole frame.
    pub(crate) outline: &'a [DVec2],
    /// The parts that touch level ground; empty where all of it does.
    pub(crate) pads: &'a [Vec<DVec2>],
    /// The outline's sides.
    pub(crate) sides: Sides,
    pub(crate) world_from_sole: &'a Pose,
    /// The rotation part of `sole_from_world`.
    pub(crate) sole_from_world: DMat3,
    /// The sole plane's normal in the world.
    pub(crate) normal: DVec3,
    /// Whether steep surfaces support it.
    pub(crate) is_braced: bool,
}

impl<'a> PosedSole<'a> {
    /// A sole that only surfaces within the friction cone support.
    pub(crate) fn new(outline: &'a [DVec2], world_from_sole: &'a Pose) -> Self {
        let rotation = DMat3::from_quat(world_from_sole.rotation);
        Self {
            outline,
            pads: &[],
            sides: sides_of(outline),
            world_from_sole,
            sole_from_world: rotation.transpose(),
            normal: rotation.z_axis,
            is_braced: false,
        }
    }

    /// The sides of each part that touches level ground.
    pub(crate) fn touching(&self) -> impl Iterator<Item = Sides> + '_ {
        let whole = self.pads.is_empty().then(|| self.sides.clone());
        whole.into_iter().chain(self.pads.iter().map(|pad| sides_of(pad)))
    }

    /// Whether a point of the sole (m) touches level ground.
    pub(crate) fn touches(&self, at: DVec2) -> bool {
        let is_in = |polygon: &[DVec2]| inner_distance(polygon, at) >= 0.0;
        if self.pads.is_empty() { is_in(self.outline) } else { self.pads.iter().any(|p| is_in(p)) }
    }

    /// A point of the world in the sole frame.
    pub(crate) fn in_sole(&self, point: DVec3) -> DVec3 {
        self.sole_from_world * (point - self.world_from_sole.translation)
    }

    /// The box in the world around the outline between two heights above the sole plane.
    pub(crate) fn region(&self, lowest: f64, highest: f64) -> Aabb {
        let corners = self.outline.iter().map(|p| *self.world_from_sole * p.extend(0.0));
        let around = bvh::Aabb::of_points(corners);
        let [low, high] = [lowest, highest].map(|height| height * self.normal);
        Aabb::new(around.min + low.min(high), around.max + low.max(high))
    }

    /// The box in the sole frame around the outline between two heights above the sole plane.
    pub(crate) fn plate(&self, lowest: f64, highest: f64) -> bvh::Aabb {
        let around = bvh::Aabb::of_points(self.outline.iter().map(|p| p.extend(0.0)));
        bvh::Aabb { min: around.min.with_z(lowest), max: around.max.with_z(highest) }
    }
}

/// Whether a polygon is convex, counter-clockwise, and has 3 to [`POLYGON_VERTICES_MAX`] vertices.
pub(crate) fn is_sole(polygon: &[DVec2]) -> bool {
    let n = polygon.len();
    let turns_left =
        |i: usize| cross(polygon[i], polygon[(i + 1) % n], polygon[(i + 2) % n]) >= -1e-12;
    (3..=POLYGON_VERTICES_MAX).contains(&n)
        && polygon.iter().all(|p| p.is_finite())
        && (0..n).all(turns_left)
        && edges(polygon).map(|(a, b)| a.perp_dot(b)).sum::<f64>() > 0.0
}
