//! Which parts of a box the shapes of the world fill.

use glam::DVec3;

use crate::collision::world_shapes::{Nearby, WorldShapes};
use crate::geometry::bvh::Aabb;

/// Most divisions of a box.
const DIVISIONS_MAX: u32 = 24;
/// Share of the reach by which a bounding box grows where a box is divided at it: the rest is left
/// for rounding.
const DIVISION_REACH: f64 = 0.97;
/// Shortest part of a divided side, m.
const SIDE_MIN: f64 = 1e-6;

impl WorldShapes {
    /// A box around all points of a box that may be farther than `reach` (m) from all shapes, and
    /// whether these are all of its points; `None` if there are none. The box is divided; a part is
    /// left out if all of it is within reach of one convex shape.
    pub(crate) fn free_part(&self, region: &Aabb, reach: f64) -> Option<(Aabb, bool)> {
        let nearby = self.nearby(&region.grown(reach));
        let left = DIVISIONS_MAX;
        let mut parts = FreeParts { world: self, nearby, reach, left, free: None, is_whole: true };
        parts.add(region);
        parts.free.map(|free| (free, parts.is_whole))
    }

    /// A shape within `reach` (m) of a point.
    pub(crate) fn shape_near(&self, point: DVec3, reach: f64) -> Option<usize> {
        let nearby = self.nearby(&Aabb { min: point, max: point }.grown(reach));
        nearby.indices().find(|&index| self.depth(index, point) >= -reach)
    }
}

/// The division of a box.
struct FreeParts<'a> {
    world: &'a WorldShapes,
    nearby: Nearby,
    reach: f64,
    /// Divisions that are left.
    left: u32,
    /// The box around the parts that are not within reach.
    free: Option<Aabb>,
    /// Whether no part was left out.
    is_whole: bool,
}

impl FreeParts<'_> {
    fn is_near(&self, index: usize, point: DVec3) -> bool {
        self.world.depth(index, point) >= -self.reach
    }

    fn add(&mut self, region: &Aabb) {
        let is_inside =
            |index: usize| corners(region).into_iter().all(|corner| self.is_near(index, corner));
        if self.nearby.indices().any(is_inside) {
            self.is_whole = false;
            return;
        }
        let Some((axis, plane)) = self.division(region).filter(|_| self.left > 0) else {
            self.free = Some(self.free.map_or(*region, |free| free.union(*region)));
            return;
        };
        self.left -= 1;
        let (mut low, mut high) = (*region, *region);
        (low.max[axis], high.min[axis]) = (plane, plane);
        self.add(&low);
        self.add(&high);
    }

    /// Where a box is divided: at a face of a shape's bounding box, grown by the reach, or across
    /// its longest side if its centre is within reach of a shape.
    fn division(&self, region: &Aabb) -> Option<(usize, f64)> {
        let reach = DIVISION_REACH * self.reach;
        for bounds in self.nearby.boxes() {
            for axis in 0..3 {
                for plane in [bounds.min[axis] - reach, bounds.max[axis] + reach] {
                    let [low, high] = [region.min[axis] + SIDE_MIN, region.max[axis] - SIDE_MIN];
                    if (low..high).contains(&plane) {
                        return Some((axis, plane));
                    }
                }
            }
        }
        let center = region.center();
        let is_over = self.nearby.indices().any(|index| self.is_near(index, center));
        let half = region.half_extents();
        let axis = (0..3).max_by(|&a, &b| half[a].total_cmp(&half[b]))?;
        is_over.then_some((axis, center[axis]))
    }
}

fn corners(region: &Aabb) -> [DVec3; 8] {
    std::array::from_fn(|corner| {
        let side = |axis: usize| if corner >> axis & 1 == 0 { region.min } else { region.max };
        DVec3::new(side(0).x, side(1).y, side(2).z)
    })
}

#[cfg(test)]
mod tests {
    use surefoot_shared_types::base::digest::Digest;
    use surefoot_shared_types::world::world::{World, WorldShape};
    use surefoot_shared_types::{Pose, Shape};

    use super::*;

    fn boxes(list: &[([f64; 3], [f64; 3])]) -> WorldShapes {
        let shapes = list.iter().enumerate().map(|(index, (center, half_extents))| WorldShape {
            name: index.to_string(),
            world_from_shape: Pose::from_translation((*center).into()),
            shape: Shape::Box { half_extents: (*half_extents).into() },
        });
        let world = World { mu: 0.6, shapes: shapes.collect(), digest: Digest::of(&[&[0]]) };
        WorldShapes::new(&world).unwrap()
    }

    #[test]
    fn a_box_is_filled_by_one_shape_or_by_several_that_touch() {
        let world =
            boxes(&[([0.0, 0.0, -0.5], [1.0, 1.0, 0.5]), ([0.0, 0.0, 0.5], [0.1, 1.0, 0.5])]);
        let around = |center: [f64; 3]| {
            let center = DVec3::from(center);
            Aabb { min: center, max: center }.grown(0.03)
        };
        let free = |center: [f64; 3]| world.free_part(&around(center), 5e-3);
        assert_eq!(free([0.0, 0.0, -0.5]), None, "in the floor");
        assert_eq!(free([0.0, 0.0, 0.0]), None, "at the seam of floor and wall");
        assert_eq!(free([0.5, 0.0, 0.5]), Some((around([0.5, 0.0, 0.5]), true)), "in the open");
        let (foot, is_whole) = free([0.09, 0.0, 0.0]).unwrap();
        assert!(!is_whole);
        assert!(foot.min.distance(DVec3::new(0.105, -0.03, 0.005)) < 1e-3, "{foot:?}");
        assert_eq!(foot.max, around([0.09, 0.0, 0.0]).max);
        assert_eq!(world.shape_near(DVec3::new(0.0, 0.0, 0.9), 0.0), Some(1));
    }
}
