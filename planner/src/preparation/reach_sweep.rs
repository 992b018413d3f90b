//! The reachable space of a leg, computed from the sole upward: the set that the joints k to n
//! reach is the set that the joints k + 1 to n reach, swept by joint k. The joint limits form a
//! box, so this is exact except for the discretisation. Each step adds a bound of its
//! discretisation error, and the result grows by the sum, so that it contains every reachable
//! position [Grey 4.2.1].
//!
//! The sweep of a solid set is the set at one limit and the sweep of its border, because a point
//! that enters the solid while the joint moves crosses the border.

use glam::{DVec3, IVec3};
use surefoot_shared_types::robot::model::JointKind;

use crate::geometry::bvh::Aabb;
use crate::geometry::voxel_grid::VoxelGrid;
use crate::kinematics::Leg;
use crate::kinematics::leg_joint::LegJoint;
use crate::preparation::tuning::{BOUNDS_HALF_ARC, COARSENING, FINE_SIDE, HALF_ARC, POINTS_MAX};

/// Distance from a cube's centre to its corner, in sides.
const CENTER_TO_CORNER: f64 = 0.866_025_403_784_438_7;
/// Upper bound of rounding errors, m.
const ROUNDING: f64 = 1e-9;

/// A set of sole positions, and the largest distance (m) of a member from its representation.
enum SoleSet {
    Points(Vec<DVec3>, f64),
    Cubes(VoxelGrid, f64),
}

/// The outer bound of the positions of a leg's sole relative to the root, for any rotation, as
/// cubes of side `COARSENING * FINE_SIDE`. `step` is called after each joint.
pub(crate) fn reachable(leg: &Leg, step: &dyn Fn()) -> VoxelGrid {
    let sole =
        leg.root_from_sole(&[0.0; surefoot_shared_types::base::limits::JOINTS_MAX]).translation;
    let mut reached = SoleSet::Points(vec![sole], 0.0);
    for joint in leg.joints().iter().rev() {
        reached = swept(&reached, joint);
        step();
    }
    grown(reached)
}

/// The set swept by a joint over its whole range.
fn swept(reached: &SoleSet, joint: &LegJoint) -> SoleSet {
    let range = JointRange::new(joint);
    match reached {
        SoleSet::Points(points, error) => {
            let count: usize = points.iter().map(|&point| range.samples(point, HALF_ARC)).sum();
            if count <= POINTS_MAX {
                let mut swept = Vec::with_capacity(count);
                points.iter().for_each(|&point| {
                    range.sweep(point, HALF_ARC, &mut |sample| swept.push(sample))
                });
                return SoleSet::Points(swept, error + HALF_ARC);
            }
            let mut cubes = VoxelGrid::around(
                &range.bounds(points.iter().copied(), 0.0),
                FINE_SIDE,
                COARSENING,
            );
            points.iter().for_each(|&point| range.sweep_into(point, &mut cubes));
            SoleSet::Cubes(cubes, error + HALF_ARC)
        }
        SoleSet::Cubes(cubes, error) => {
            let around = FINE_SIDE * CENTER_TO_CORNER;
            SoleSet::Cubes(swept_cubes(cubes, &range), error + around + HALF_ARC)
        }
    }
}

fn swept_cubes(cubes: &VoxelGrid, range: &JointRange) -> VoxelGrid {
    let border: Vec<DVec3> = cubes.border().cubes().map(|cube| cubes.center(cube)).collect();
    let bounds = range.bounds(border.iter().copied(), FINE_SIDE);
    let mut swept = VoxelGrid::around(&bounds, FINE_SIDE, COARSENING);
    fill_at_lower_limit(cubes, range, &mut swept);
    border.iter().for_each(|&center| range.sweep_into(center, &mut swept));
    swept
}

/// Sets every cube whose centre, moved back from the lower limit, lies in the set. This covers the
/// cubes of the set that have all their neighbours without a gap.
fn fill_at_lower_limit(cubes: &VoxelGrid, range: &JointRange, swept: &mut VoxelGrid) {
    let back = range.joint.motion(range.lower).inverse();
    let dims = swept.dims.as_ivec3();
    let along = back.rotation * DVec3::X;
    for z in 0..dims.z {
        for y in 0..dims.y {
            let first = cubes.in_cubes(back * swept.center(IVec3::new(0, y, z)));
            for x in 0..dims.x {
                if cubes.is_set_at(first + f64::from(x) * along) {
                    swept.set(IVec3::new(x, y, z));
                }
            }
        }
    }
}

/// The result in coarse cubes, grown by the sum of all errors.
fn grown(reached: SoleSet) -> VoxelGrid {
    let (fine, error) = match reached {
        SoleSet::Cubes(cubes, error) => (cubes, error),
        SoleSet::Points(points, error) => {
            let mut cubes =
                VoxelGrid::around(&Aabb::of_points(points.iter().copied()), FINE_SIDE, COARSENING);
            points.iter().for_each(|&point| cubes.set_at(cubes.in_cubes(point)));
            (cubes, error)
        }
    };
    let reach = error + FINE_SIDE * CENTER_TO_CORNER + ROUNDING;
    let bounds =
        Aabb { min: fine.origin, max: fine.origin + fine.dims.as_dvec3() * fine.side }.grown(reach);
    let mut coarse = VoxelGrid::around(&bounds, FINE_SIDE * f64::from(COARSENING), 1);
    for cube in fine.cubes() {
        coarse.set_at(coarse.in_cubes(fine.center(cube)));
    }
    for cube in fine.border().cubes() {
        set_within(&mut coarse, fine.center(cube), reach);
    }
    coarse
}

/// Sets every cube within `reach` (m) of a point.
fn set_within(cubes: &mut VoxelGrid, point: DVec3, reach: f64) {
    let cube_at = |by: f64| cubes.in_cubes(point + DVec3::splat(by)).floor().as_ivec3();
    let (low, high) = (cube_at(-reach), cube_at(reach));
    for z in low.z..=high.z {
        for y in low.y..=high.y {
            for x in low.x..=high.x {
                let cube = IVec3::new(x, y, z);
                let beyond = (cubes.center(cube) - point).abs() - DVec3::splat(0.5 * cubes.side);
                if beyond.max(DVec3::ZERO).length_squared() <= reach * reach {
                    cubes.set(cube);
                }
            }
        }
    }
}

/// A joint and its range of positions.
struct JointRange<'a> {
    joint: &'a LegJoint,
    lower: f64,
    upper: f64,
}

impl<'a> JointRange<'a> {
    fn new(joint: &'a LegJoint) -> Self {
        let (lower, upper) = (joint.lower, joint.upper);
        let exceeds_a_turn =
            joint.kind == JointKind::Revolute && upper - lower > std::f64::consts::TAU;
        Self {
            joint,
            lower,
            upper: if exceeds_a_turn { lower + std::f64::consts::TAU } else { upper },
        }
    }

    /// The distance that a point moves over the whole range, m.
    fn travel(&self, point: DVec3) -> f64 {
        let span = self.upper - self.lower;
        match self.joint.kind {
            JointKind::Prismatic => span,
            JointKind::Revolute => {
                span * (point - self.joint.point).cross(self.joint.axis).length()
            }
        }
    }

    fn samples(&self, point: DVec3, half_arc: f64) -> usize {
        libm::ceil(self.travel(point) / (2.0 * half_arc)).max(1.0) as usize
    }

    /// Passes positions of the point to `take`. Every position on its path is within `half_arc` (m)
    /// of one of them.
    fn sweep(&self, point: DVec3, half_arc: f64, take: &mut impl FnMut(DVec3)) {
        let count = self.samples(point, half_arc);
        let step = (self.upper - self.lower) / count as f64;
        let first = self.lower + 0.5 * step;
        match self.joint.kind {
            JointKind::Prismatic => {
                (0..count).for_each(|i| take(point + self.joint.axis * (first + step * i as f64)))
            }
            JointKind::Revolute => Circle::new(self.joint, point).walk([first, step], count, take),
        }
    }

    /// Sets the cubes at samples of a point's path, which are `HALF_ARC` apart at most.
    fn sweep_into(&self, point: DVec3, cubes: &mut VoxelGrid) {
        let count = self.samples(point, HALF_ARC);
        let step = (self.upper - self.lower) / count as f64;
        let first = self.lower + 0.5 * step;
        if self.joint.kind == JointKind::Prismatic {
            (0..count).for_each(|i| {
                cubes.set_at(cubes.in_cubes(point + self.joint.axis * (first + step * i as f64)))
            });
            return;
        }
        let circle = Circle::new(self.joint, point);
        let (centre, scale) = (cubes.in_cubes(circle.centre), 1.0 / cubes.side);
        let scaled = Circle { centre, ahead: circle.ahead * scale, aside: circle.aside * scale };
        scaled.walk([first, step], count, &mut |sample| cubes.set_at(sample));
    }

    /// A box around the paths of some points, with `margin` (m) around them.
    fn bounds(&self, points: impl Iterator<Item = DVec3>, margin: f64) -> Aabb {
        let mut bounds = Aabb::EMPTY;
        for point in points {
            self.sweep(point, BOUNDS_HALF_ARC, &mut |sample| {
                bounds = bounds.union(Aabb { min: sample, max: sample })
            });
        }
        bounds.grown(margin + BOUNDS_HALF_ARC)
    }
}

/// The circular path of a point about an axis.
struct Circle {
    centre: DVec3,
    ahead: DVec3,
    aside: DVec3,
}

impl Circle {
    fn new(joint: &LegJoint, point: DVec3) -> Self {
        let centre = joint.point + joint.axis * (point - joint.point).dot(joint.axis);
        let ahead = point - centre;
        Self { centre, ahead, aside: joint.axis.cross(ahead) }
    }

    /// Passes `count` positions to `take`, from the angle `first` on in steps of `step`, rad.
    fn walk(&self, [first, step]: [f64; 2], count: usize, take: &mut impl FnMut(DVec3)) {
        let (mut sin, mut cos) = libm::sincos(first);
        let (step_sin, step_cos) = libm::sincos(step);
        for _ in 0..count {
            take(self.centre + self.ahead * cos + self.aside * sin);
            (sin, cos) = (sin * step_cos + cos * step_sin, cos * step_cos - sin * step_sin);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::{Random, Stream};

    fn hinge() -> LegJoint {
        LegJoint {
            index: 0,
            kind: JointKind::Revolute,
            point: DVec3::new(0.1, 0.0, 0.0),
            axis: DVec3::Z,
            lower: -1.0,
            upper: 2.0,
        }
    }

    #[test]
    fn every_position_on_a_path_is_near_a_sample() {
        let (joint, point) = (hinge(), DVec3::new(0.4, 0.2, 0.3));
        let range = JointRange::new(&joint);
        let mut samples = vec![];
        range.sweep(point, HALF_ARC, &mut |sample| samples.push(sample));
        for i in 0..=1000 {
            let position: DVec3 = joint.motion(-1.0 + 3.0 * f64::from(i) / 1000.0) * point;
            assert!(samples.iter().any(|sample| sample.distance(position) <= HALF_ARC + 1e-9));
        }
    }

    #[test]
    fn every_sole_is_reachable_where_hip_axes_do_not_meet() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../configs/robots/hubo/robot.toml");
        let mut model = surefoot_shared_types::robot::load::load_robot(&path).unwrap();
        let hip = model.joints.iter().find(|joint| joint.name == "left_hip_pitch").unwrap().child;
        model.links[hip].parent.as_mut().unwrap().parent_from_joint.translation.x += 0.03;
        let leg = Leg::new(&model, 0, 0.0).unwrap();
        assert!(!leg.is_closed_form());
        let cubes = reachable(&leg, &|| ());
        let mut random = Random::new(1, Stream::Preparation, 7, 0);
        for _ in 0..50_000 {
            let q: Vec<f64> =
                model.joints.iter().map(|joint| random.uniform(joint.lower, joint.upper)).collect();
            assert!(cubes.is_set_at(cubes.in_cubes(leg.root_from_sole(&q).translation)), "{q:?}");
        }
    }

    #[test]
    fn a_swept_solid_has_no_hole() {
        let mut cubes = VoxelGrid::around(
            &Aabb { min: DVec3::splat(0.2), max: DVec3::splat(0.4) },
            FINE_SIDE,
            COARSENING,
        );
        for i in 0..20 * 20 * 20 {
            let cube = IVec3::new(10 + i % 20, 10 + i / 20 % 20, 10 + i / 400);
            cubes.set(cube);
        }
        let joint = hinge();
        let range = JointRange::new(&joint);
        let swept = swept_cubes(&cubes, &range);
        let inside = cubes.center(IVec3::splat(20));
        for i in 0..=300 {
            let position: DVec3 = joint.motion(-1.0 + 3.0 * f64::from(i) / 300.0) * inside;
            assert!(swept.is_set_at(swept.in_cubes(position)), "{i}");
        }
    }
}
