//! Algorithm 1: planes through triplets of intersection points, and placements on them
//! [Grey 4.2.2].

use std::ops::ControlFlow;

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::yaw_of;

use crate::foot_placement::candidates::centre_of;
use crate::foot_placement::config::{NEAR_TARGETS_MAX, NEIGHBORS_MAX};
use crate::foot_placement::propose::{Examined, Proposal, Source};
use crate::foot_placement::sole_support::NoSupport;
use crate::foot_placement::sole_support::pose_on_plane;
use crate::foot_placement::support::SupportRequirement;
use crate::foot_placement::surfaces::Element;
use crate::geometry::polygon::clip;

/// Where the first targets lie: at the ideal, then half a foot ahead of it, behind it and to both
/// sides, m.
const NEAR_TARGETS: [DVec3; NEAR_TARGETS_MAX] = [
    DVec3::ZERO,
    DVec3::new(0.1, 0.0, 0.0),
    DVec3::new(-0.1, 0.0, 0.0),
    DVec3::new(0.0, 0.1, 0.0),
    DVec3::new(0.0, -0.1, 0.0),
];
/// How far from the triplet's middle, and how far from the ideal heading, near placements are, as
/// a share of what others may.
const NEAR_FRACTION: f64 = 0.25;
/// The share of the attempts over which the bound of the support's area relaxes.
const RELAXING_SHARE: f64 = 0.25;
/// Random points taken inside each face.
const INNER_POINTS: usize = 4;
/// Most points along one edge or line.
const EDGE_POINTS_MAX: usize = 64;
/// Twice the area of the flattest triangle that still defines a plane, m2.
const TRIANGLE_AREA_MIN: f64 = 1e-4;

type Triplet = [DVec3; 3];

/// What became of a triplet.
enum TripletEnd {
    Found,
    Exhausted,
}

impl Proposal<'_, '_> {
    /// The whole of Algorithm 1; each target that leads to a placement hands it out and the next
    /// target follows.
    pub(crate) fn sample(&mut self) -> ControlFlow<()> {
        if self.query.limits.sampled_max == 0 {
            return ControlFlow::Continue(());
        }
        self.sample_intersection();
        let config = &self.surfaces.config;
        for attempt in 0..config.sample_attempts_max {
            let target = self.sample_target(attempt);
            let relaxed =
                f64::from(attempt) / (RELAXING_SHARE * f64::from(config.sample_attempts_max));
            let requirement = SupportRequirement {
                any_intrusion: false,
                ..self.requirement((1.0 - relaxed).max(0.0))
            };
            let neighbors = nearest(&self.scratch.intersection_points, target, config.neighbors);
            if neighbors.len() < 3 {
                break;
            }
            for _ in 0..config.plane_attempts_max {
                let triplet = self.sample_triplet(&neighbors);
                if let TripletEnd::Found = self.try_triplet(triplet, requirement)? {
                    break;
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// Lines 8 to 19: placements on the triplet's plane, which turns towards whatever is in the
    /// way.
    fn try_triplet(
        &mut self,
        mut triplet: Triplet,
        requirement: SupportRequirement,
    ) -> ControlFlow<(), TripletEnd> {
        for iteration in 0..self.surfaces.config.iterations_max {
            if self.stats.examined[Source::Sampled as usize] + self.stats.out_of_reach
                >= self.query.limits.sampled_max
            {
                break;
            }
            let Some(normal) = self.suitable_normal(&triplet) else {
                self.stats.planes_unsuitable += 1;
                break;
            };
            let pose = self.sample_pose(&triplet, normal, iteration);
            if !self.query.reaches(&pose) {
                self.stats.out_of_reach += 1;
                continue;
            }
            match self.examine(pose, Source::Sampled, requirement)? {
                Examined::Found => return ControlFlow::Continue(TripletEnd::Found),
                Examined::Rejected(NoSupport::Penetrates | NoSupport::FacesDown) => {
                    if let Some(point) = self.scratch.intrusion {
                        let closest = (0..3).min_by(|&i, &j| {
                            triplet[i]
                                .distance_squared(point)
                                .total_cmp(&triplet[j].distance_squared(point))
                        });
                        triplet[closest.unwrap_or(0)] = point;
                    }
                }
                Examined::Rejected(_) | Examined::NotFree => {}
            }
        }
        ControlFlow::Continue(TripletEnd::Exhausted)
    }

    /// `IsSuitablePlane`: the upward normal, unless the points are collinear or the plane too
    /// steep.
    fn suitable_normal(&self, triplet: &Triplet) -> Option<DVec3> {
        let spanned = (triplet[1] - triplet[0]).cross(triplet[2] - triplet[0]);
        let normal = if spanned.z < 0.0 { -spanned } else { spanned };
        let length = normal.length();
        (length >= TRIANGLE_AREA_MIN)
            .then(|| normal / length)
            .filter(|&n| self.surfaces.is_flat_enough(n))
    }

    /// `SampleRandomSE2`: the triangle's centroid with the ideal heading first, then near both,
    /// then anywhere in it, any heading allowed.
    fn sample_pose(&mut self, triplet: &Triplet, normal: DVec3, iteration: u32) -> Pose {
        let share = match iteration {
            0 if self.surfaces.config.iterations_near_ideal > 0 => 0.0,
            i if i < self.surfaces.config.iterations_near_ideal => NEAR_FRACTION,
            _ => 1.0,
        };
        let middle = (triplet[0] + triplet[1] + triplet[2]) / 3.0;
        let point = middle + (self.point_in_triangle(triplet) - middle) * share;
        let spread = share * self.query.yaw_spread.min(std::f64::consts::PI);
        let yaw = yaw_of(self.query.ideal.rotation) + self.random.uniform(-spread, spread);
        let turned = pose_on_plane(DVec3::ZERO, normal, yaw).rotation;
        Pose::from_parts(point - turned * centre_of(self.query.sole_polygon).extend(0.0), turned)
    }

    fn point_in_triangle(&mut self, triangle: &Triplet) -> DVec3 {
        let (mut u, mut v) = (self.random.uniform(0.0, 1.0), self.random.uniform(0.0, 1.0));
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        triangle[0] + (triangle[1] - triangle[0]) * u + (triangle[2] - triangle[0]) * v
    }

    /// `SampleRandomTranslation`: the near positions first, then anywhere within reach.
    fn sample_target(&mut self, attempt: u32) -> DVec3 {
        let query = self.query;
        if attempt < self.surfaces.config.sample_attempts_near_ideal {
            return query.ideal * NEAR_TARGETS[attempt as usize % NEAR_TARGETS_MAX];
        }
        let reach = query.reach_xy;
        let x = self.random.uniform(-reach, reach);
        let y = self.random.uniform(-reach, reach);
        query.ideal.translation
            + DVec3::new(x, y, self.random.uniform(query.reach_z[0], query.reach_z[1]))
    }

    /// Three different points.
    fn sample_triplet(&mut self, points: &[DVec3]) -> Triplet {
        let i = self.random.below(points.len());
        let j = (i + 1 + self.random.below(points.len() - 1)) % points.len();
        let first_free =
            |taken: [usize; 2], at: usize| (at..).find(|k| !taken.contains(&(k % points.len())));
        let k = first_free([i, j], self.random.below(points.len())).map_or(0, |k| k % points.len());
        [points[i], points[j], points[k]]
    }

    /// `SampleIntersection`: vertices, points along edges and lines, and random points of the
    /// features within reach.
    fn sample_intersection(&mut self) {
        self.scratch.intersection_points.clear();
        for i in 0..self.scratch.features.len() {
            if self.scratch.intersection_points.is_full() {
                break;
            }
            self.clip_to_reach(self.scratch.features[i].1);
            self.add_edge_points();
            self.add_inner_points();
        }
    }

    /// Leaves in the clip buffer what of a feature lies within reach: a polygon, a line's two ends,
    /// or a point.
    fn clip_to_reach(&mut self, id: u32) {
        let region = self.query.region(1.0);
        let buffer = &mut self.scratch.clip;
        buffer.polygon.clear();
        match self.surfaces.element(id) {
            Element::Face(_, vertices) => buffer.polygon.extend(vertices.iter().copied()),
            Element::Curved(curved) => {
                buffer.polygon.extend(
                    curved.line_with_normal(curved.side_normal(DVec3::Z).unwrap_or(DVec3::Z)),
                );
            }
        }
        for axis in 0..3 {
            clip(&mut buffer.polygon, &mut buffer.spare, |p| p[axis] - region.mins[axis]);
            clip(&mut buffer.polygon, &mut buffer.spare, |p| region.maxs[axis] - p[axis]);
        }
    }

    fn add_edge_points(&mut self) {
        let polygon = &self.scratch.clip.polygon;
        for i in 0..polygon.len() {
            let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
            let steps = ((a.distance(b) / self.surfaces.config.point_spacing).ceil() as usize)
                .clamp(1, EDGE_POINTS_MAX);
            for step in 0..steps {
                self.scratch.intersection_points.push(a + (b - a) * (step as f64 / steps as f64));
            }
        }
    }

    fn add_inner_points(&mut self) {
        for _ in 0..INNER_POINTS {
            let count = self.scratch.clip.polygon.len();
            if count < 3 {
                return;
            }
            let k = 1 + self.random.below(count - 2);
            let polygon = &self.scratch.clip.polygon;
            let triangle = [polygon[0], polygon[k], polygon[k + 1]];
            let point = self.point_in_triangle(&triangle);
            self.scratch.intersection_points.push(point);
        }
    }
}

/// The `count` points nearest to `target`, nearest first.
fn nearest(points: &[DVec3], target: DVec3, count: usize) -> heapless::Vec<DVec3, NEIGHBORS_MAX> {
    let mut nearest: heapless::Vec<(f64, DVec3), NEIGHBORS_MAX> = heapless::Vec::new();
    for &point in points {
        let distance = point.distance_squared(target);
        if nearest.get(count - 1).is_some_and(|&(farthest, _)| farthest <= distance) {
            continue;
        }
        let place = nearest.partition_point(|&(known, _)| known <= distance);
        nearest.truncate(count - 1);
        let _always_fits = nearest.insert(place, (distance, point));
    }
    nearest.into_iter().map(|(_, point)| point).collect()
}
