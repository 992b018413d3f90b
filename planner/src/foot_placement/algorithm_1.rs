//! Algorithm 1: planes through triplets of intersection points, and placements on them
//! [Grey 4.2.2].

use std::ops::ControlFlow;

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::yaw_of;

use crate::base::random::Random;
use crate::foot_placement::elements::Element;
use crate::foot_placement::plane_features::pose_on_plane;
use crate::foot_placement::posed_sole::SupportRequirement;
use crate::foot_placement::proposal::{Examined, Proposal};
use crate::foot_placement::request::Source;
use crate::foot_placement::sole_support::NoSupport;
use crate::foot_placement::surfaces::Surfaces;
use crate::foot_placement::tuning::{
    EDGE_POINTS_MAX, INNER_POINTS, NEAR_FRACTION, NEAR_TARGETS, NEAR_TARGETS_MAX, NEIGHBORS_MAX,
    RELAXATION_SHARE,
};
use crate::geometry::polygon::clip;

/// Twice the area of the smallest triangle that defines a plane, m2.
const TRIANGLE_AREA_MIN: f64 = 1e-4;

type Triplet = [DVec3; 3];

/// Result of the attempts at a triplet.
enum TripletOutcome {
    Found,
    Exhausted,
}

/// The whole of Algorithm 1. Each target gives at most one placement.
pub(crate) fn propose_sampled(proposal: &mut Proposal<'_, '_>) -> ControlFlow<()> {
    if proposal.query.limits.sampled_max == 0 {
        return ControlFlow::Continue(());
    }
    sample_intersection(proposal);
    let config = proposal.surfaces.config();
    for attempt in 0..config.sample_attempts_max {
        if is_exhausted(proposal) {
            break;
        }
        let target = sample_target(proposal, attempt);
        let relaxed =
            f64::from(attempt) / (RELAXATION_SHARE * f64::from(config.sample_attempts_max));
        let requirement = SupportRequirement {
            any_intrusion: false,
            ..proposal.requirement((1.0 - relaxed).max(0.0))
        };
        let neighbors = nearest(&proposal.scratch.intersection_points, target, config.neighbors);
        if neighbors.len() < 3 {
            break;
        }
        for _ in 0..config.plane_attempts_max {
            let triplet = sample_triplet(&mut proposal.random, &neighbors);
            if let TripletOutcome::Found = try_triplet(proposal, triplet, requirement)? {
                break;
            }
        }
    }
    ControlFlow::Continue(())
}

/// Whether as many placements are drawn as the query allows.
fn is_exhausted(proposal: &Proposal<'_, '_>) -> bool {
    let stats = &proposal.stats;
    stats.examined[Source::Sampled as usize] + stats.out_of_reach
        >= proposal.query.limits.sampled_max
}

/// Lines 8 to 19: placements on the triplet's plane. An obstacle's point replaces the nearest
/// point of the triplet, so that the plane turns toward the obstacle.
fn try_triplet(
    proposal: &mut Proposal<'_, '_>,
    mut triplet: Triplet,
    requirement: SupportRequirement,
) -> ControlFlow<(), TripletOutcome> {
    for iteration in 0..proposal.surfaces.config().iterations_max {
        if is_exhausted(proposal) {
            break;
        }
        let Some(normal) = suitable_normal(proposal.surfaces, &triplet) else {
            proposal.stats.planes_unsuitable += 1;
            break;
        };
        let pose = sample_pose(proposal, &triplet, normal, iteration);
        if !proposal.query.is_in_reach(&pose) {
            proposal.stats.out_of_reach += 1;
            continue;
        }
        match proposal.examine(pose, Source::Sampled, requirement)? {
            Examined::Found => return ControlFlow::Continue(TripletOutcome::Found),
            Examined::Rejected(NoSupport::Penetrates | NoSupport::FacesDown) => {
                if let Some(point) = proposal.scratch.contacts.intrusion {
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
    ControlFlow::Continue(TripletOutcome::Exhausted)
}

/// `IsSuitablePlane`: the upward normal, unless the points are collinear or the plane too
/// steep.
fn suitable_normal(surfaces: &Surfaces, triplet: &Triplet) -> Option<DVec3> {
    let spanned = (triplet[1] - triplet[0]).cross(triplet[2] - triplet[0]);
    let normal = if spanned.z < 0.0 { -spanned } else { spanned };
    let length = normal.length();
    (length >= TRIANGLE_AREA_MIN).then(|| normal / length).filter(|&n| surfaces.is_flat_enough(n))
}

/// `SampleRandomSE2`: the triangle's centroid with the ideal heading first, then positions and
/// headings near both, then any position in the triangle with any heading.
fn sample_pose(
    proposal: &mut Proposal<'_, '_>,
    triplet: &Triplet,
    normal: DVec3,
    iteration: u32,
) -> Pose {
    let share = match iteration {
        0 if proposal.surfaces.config().iterations_near_ideal > 0 => 0.0,
        i if i < proposal.surfaces.config().iterations_near_ideal => NEAR_FRACTION,
        _ => 1.0,
    };
    let middle = (triplet[0] + triplet[1] + triplet[2]) / 3.0;
    let point = middle + (point_in_triangle(&mut proposal.random, triplet) - middle) * share;
    let spread = share * proposal.query.yaw_spread.min(std::f64::consts::PI);
    let yaw = yaw_of(proposal.query.ideal.rotation) + proposal.random.uniform(-spread, spread);
    let rotation = pose_on_plane(DVec3::ZERO, normal, yaw).rotation;
    Pose::from_parts(point - rotation * proposal.query.sole_centroid().extend(0.0), rotation)
}

/// A uniformly distributed point of a triangle.
fn point_in_triangle(random: &mut Random, triangle: &Triplet) -> DVec3 {
    let (mut u, mut v) = (random.uniform(0.0, 1.0), random.uniform(0.0, 1.0));
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    triangle[0] + (triangle[1] - triangle[0]) * u + (triangle[2] - triangle[0]) * v
}

/// `SampleRandomTranslation`: the near positions first, then anywhere within reach.
fn sample_target(proposal: &mut Proposal<'_, '_>, attempt: u32) -> DVec3 {
    let query = proposal.query;
    if attempt < proposal.surfaces.config().sample_attempts_near_ideal {
        return query.ideal * NEAR_TARGETS[attempt as usize % NEAR_TARGETS_MAX];
    }
    let reach = query.reach_xy;
    let x = proposal.random.uniform(-reach, reach);
    let y = proposal.random.uniform(-reach, reach);
    query.ideal.translation
        + DVec3::new(x, y, proposal.random.uniform(query.reach_z[0], query.reach_z[1]))
}

/// Three different points, of at least three.
fn sample_triplet(random: &mut Random, points: &[DVec3]) -> Triplet {
    let i = random.below(points.len());
    let j = (i + 1 + random.below(points.len() - 1)) % points.len();
    let first_free =
        |taken: [usize; 2], at: usize| (at..).find(|k| !taken.contains(&(k % points.len())));
    let k = first_free([i, j], random.below(points.len())).map_or(0, |k| k % points.len());
    [points[i], points[j], points[k]]
}

/// `SampleIntersection`: vertices, points along edges and lines, and random points of the
/// features within reach.
fn sample_intersection(proposal: &mut Proposal<'_, '_>) {
    proposal.scratch.intersection_points.clear();
    for i in 0..proposal.scratch.features.len() {
        if proposal.scratch.intersection_points.is_full() {
            break;
        }
        clip_to_reach(proposal, proposal.scratch.features[i].1);
        add_edge_points(proposal);
        add_inner_points(proposal);
    }
}

/// Writes the part of a feature within reach to the clip buffer: a polygon, a line's two ends,
/// or a point.
fn clip_to_reach(proposal: &mut Proposal<'_, '_>, id: u32) {
    let region = proposal.query.region(1.0);
    let buffer = &mut proposal.scratch.clip;
    buffer.polygon.clear();
    match proposal.surfaces.element(id) {
        Element::Face(_, vertices) => buffer.polygon.extend(vertices.iter().copied()),
        Element::Curved(curved) => {
            buffer
                .polygon
                .extend(curved.line_with_normal(curved.side_normal(DVec3::Z).unwrap_or(DVec3::Z)));
        }
    }
    for axis in 0..3 {
        clip(&mut buffer.polygon, &mut buffer.spare, |p| p[axis] - region.mins[axis]);
        clip(&mut buffer.polygon, &mut buffer.spare, |p| region.maxs[axis] - p[axis]);
    }
}

/// Adds points at equal distances along each edge of the clipped feature.
fn add_edge_points(proposal: &mut Proposal<'_, '_>) {
    let polygon = &proposal.scratch.clip.polygon;
    for i in 0..polygon.len() {
        let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
        let steps = ((a.distance(b) / proposal.surfaces.config().point_spacing).ceil() as usize)
            .clamp(1, EDGE_POINTS_MAX);
        for step in 0..steps {
            proposal.scratch.intersection_points.push(a + (b - a) * (step as f64 / steps as f64));
        }
    }
}

/// Adds random points of the clipped feature, if it is a face.
fn add_inner_points(proposal: &mut Proposal<'_, '_>) {
    for _ in 0..INNER_POINTS {
        let count = proposal.scratch.clip.polygon.len();
        if count < 3 {
            return;
        }
        let k = 1 + proposal.random.below(count - 2);
        let polygon = &proposal.scratch.clip.polygon;
        let triangle = [polygon[0], polygon[k], polygon[k + 1]];
        let point = point_in_triangle(&mut proposal.random, &triangle);
        proposal.scratch.intersection_points.push(point);
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
        let index = nearest.partition_point(|&(known, _)| known <= distance);
        nearest.truncate(count - 1);
        let _always_fits = nearest.insert(index, (distance, point));
    }
    nearest.into_iter().map(|(_, point)| point).collect()
}
