//! Samples of stage P: poses anywhere, and poses ahead of vertices with few neighbours
//! [Grey 3, 4.3].
//!
//! Poses anywhere suffice in a short region. In a region much longer than wide they rarely hit the
//! few metres where a tree can grow; poses ahead of a vertex do so at any length.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;
use surefoot_shared_types::base::spatial::rotation_about;

use crate::base::random::Random;
use crate::geometry::bvh::Aabb;
use crate::possibility::mid_feet_pose::MidFeetPose;
use crate::possibility::tree::{PossibilityTree, Vertex};
use crate::possibility::tuning::{
    AHEAD_DISTANCES, AHEAD_RISE_MAX, AHEAD_TURN_MAX, ANYWHERE_EVERY, NEIGHBOURS_PER_METRE,
    RECENT_VERTICES, REGION_GROWTH, REGION_MARGIN, REGION_SAMPLES_MAX, SAMPLED_LENGTH,
    SHORT_LENGTH_MAX,
};

/// Heading offset of a robot that walks backward, rad.
pub(crate) const BACKWARD: f64 = PI;
/// Heading offsets of a robot that sidesteps, rad.
pub(crate) const SIDES: [f64; 2] = [FRAC_PI_2, -FRAC_PI_2];

/// Region in which poses are drawn: around both ends (world, m), within the world's bounds.
pub(crate) fn bounds_around([start, goal]: [DVec3; 2], world: &Aabb) -> Aabb {
    let (margin_min, distance_share) = REGION_MARGIN;
    let around = Aabb { min: start.min(goal), max: start.max(goal) }
        .grown((distance_share * start.distance(goal)).max(margin_min));
    let (min, max) = (around.min.max(world.min), around.max.min(world.max));
    Aabb { min: min.min(max), max: max.max(min) }
}

/// The region grown by a quarter of its horizontal diagonal on each side, within the world's
/// bounds.
pub(crate) fn widened(bounds: &Aabb, world: &Aabb) -> Aabb {
    let around = bounds.grown(REGION_GROWTH * length(bounds));
    Aabb {
        min: bounds.min.min(around.min.max(world.min)),
        max: bounds.max.max(around.max.min(world.max)),
    }
}

/// Number of samples for a region.
pub(crate) fn samples_max(bounds: &Aabb) -> u32 {
    (REGION_SAMPLES_MAX * (length(bounds) / SAMPLED_LENGTH).max(1.0)) as u32
}

/// Whether a region is so short that a single passage decides whether a route exists.
pub(crate) fn is_short(bounds: &Aabb) -> bool {
    length(bounds) <= SHORT_LENGTH_MAX
}

/// Length of the horizontal diagonal of a region, m.
fn length(bounds: &Aabb) -> f64 {
    (bounds.max - bounds.min).truncate().length()
}

/// Parameters of a sample.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SampleRequest<'a> {
    /// Region in which poses are drawn.
    pub bounds: &'a Aabb,
    /// Root of the other tree, world, m.
    pub toward: DVec3,
    /// Whether the tree grows from the goal. It is then walked toward its root, so the heading at
    /// its vertices is opposite to the direction of growth.
    pub backward: bool,
    /// Heading offset of the robot unless it sidesteps, rad.
    pub heading_offset: f64,
    /// Whether the robot may sidestep.
    pub may_sidestep: bool,
}

/// The vertex to extend, the target pose, and the heading offset of the robot, rad.
type Sample = (u32, MidFeetPose, f64);

/// Sample number `count` of a tree. The heading offset is that of the extended vertex, unless the
/// robot sidesteps.
pub(crate) fn sample(
    tree: &mut PossibilityTree,
    request: &SampleRequest<'_>,
    count: u32,
    random: &mut Random,
) -> Sample {
    if count.is_multiple_of(ANYWHERE_EVERY) {
        sample_anywhere(tree, request, random)
    } else {
        sample_ahead(tree, request, random)
    }
}

/// A pose anywhere, and the vertex nearest to it.
fn sample_anywhere(
    tree: &PossibilityTree,
    request: &SampleRequest<'_>,
    random: &mut Random,
) -> Sample {
    let position = DVec3::from_array(std::array::from_fn(|axis| {
        random.uniform(request.bounds.min[axis], request.bounds.max[axis])
    }));
    let target = MidFeetPose { position, yaw: random.uniform(-PI, PI) };
    (tree.nearest(|pose| pose.position_distance_squared(position)), target, request.heading_offset)
}

/// The latest vertex with the fewest neighbours (the last of several), and a pose ahead of it. In a
/// long region the distance to the root of the other tree counts as neighbours.
fn sample_ahead(
    tree: &mut PossibilityTree,
    request: &SampleRequest<'_>,
    random: &mut Random,
) -> Sample {
    let per_metre = if is_short(request.bounds) { 0.0 } else { NEIGHBOURS_PER_METRE };
    let density = |vertex: &Vertex| {
        f64::from(vertex.neighbour_count)
            + per_metre * libm::sqrt(vertex.pose.position_distance_squared(request.toward))
    };
    let inside = tree
        .iter()
        .enumerate()
        .rev()
        .take(RECENT_VERTICES)
        .filter(|(_, vertex)| request.bounds.contains(vertex.pose.position));
    let tip = inside
        .min_by(|(_, a), (_, b)| density(a).total_cmp(&density(b)))
        .map_or(0, |(index, _)| index);
    tree[tip].neighbour_count += 1;
    let Vertex { pose: at, heading_offset: offset, .. } = tree[tip];
    let yaw = at.yaw - offset + random.uniform(-AHEAD_TURN_MAX, AHEAD_TURN_MAX);
    let distance = random.uniform(AHEAD_DISTANCES[0], AHEAD_DISTANCES[1])
        * if request.backward { -1.0 } else { 1.0 };
    let displacement = DVec3::new(distance, 0.0, random.uniform(-AHEAD_RISE_MAX, AHEAD_RISE_MAX));
    let heading_offset = if request.may_sidestep {
        [request.heading_offset, SIDES[0], SIDES[1]][random.below(3)]
    } else {
        offset
    };
    (
        tip as u32,
        MidFeetPose {
            position: at.position + rotation_about(DVec3::Z, yaw) * displacement,
            yaw: yaw + heading_offset,
        },
        heading_offset,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::Stream;

    const BOUNDS: Aabb =
        Aabb { min: DVec3::new(-1.0, -2.0, -1.0), max: DVec3::new(60.0, 2.0, 1.0) };

    /// A short region, in which neighbour counts alone decide.
    const WIDE: Aabb = Aabb { min: DVec3::new(-1.0, -2.0, -1.0), max: DVec3::new(10.0, 2.0, 1.0) };

    fn request(bounds: &Aabb) -> SampleRequest<'_> {
        SampleRequest {
            bounds,
            toward: bounds.max,
            backward: false,
            heading_offset: 0.0,
            may_sidestep: false,
        }
    }

    /// A tree of vertices along x that are not neighbours.
    fn tree(along_x: &[f64]) -> PossibilityTree {
        let mut tree = PossibilityTree::new(1_000);
        for &x in along_x {
            tree.add(Vertex::root(
                MidFeetPose { position: DVec3::new(x, 0.0, 0.0), yaw: 0.0 },
                None,
            ));
        }
        tree
    }

    /// The length of corridor that a tree covers, m, if each sample ahead adds a vertex one stride
    /// toward it.
    fn farthest(samples: u32) -> f64 {
        let mut tree = tree(&[0.0]);
        for count in 0..samples {
            let mut random = Random::new(1, Stream::Possibility, u64::from(count), 0);
            let (tip, target, _) = sample_ahead(&mut tree, &request(&BOUNDS), &mut random);
            tree.add(Vertex::root(tree[tip as usize].pose.step_toward(&target, 0.25, 0.0), None));
        }
        tree.iter().map(|vertex| vertex.pose.position.x).fold(0.0, f64::max)
    }

    #[test]
    fn twice_the_samples_cover_about_twice_the_length() {
        let [near, far] = [250, 500].map(farthest);
        assert!(near > 4.0 && far > 1.6 * near && far < 55.0, "{near} m, {far} m");
    }

    #[test]
    fn a_tree_grows_ahead_of_the_vertex_with_the_fewest_neighbours() {
        let mut random = Random::new(1, Stream::Possibility, 0, 0);
        let mut tree = tree(&[0.0, 5.0, 9.0]);
        (tree[0].neighbour_count, tree[2].neighbour_count) = (2, 2);
        for backward in [false, true] {
            let (tip, target, _) =
                sample_ahead(&mut tree, &SampleRequest { backward, ..request(&WIDE) }, &mut random);
            assert_eq!((tip, target.position.x < 5.0), (1, backward), "{target:?}");
        }
        assert_eq!(tree[1].neighbour_count, 2, "a sample counts as a neighbour");
    }

    #[test]
    fn no_vertex_outside_the_region_is_extended() {
        let mut random = Random::new(1, Stream::Possibility, 0, 0);
        let mut tree = tree(&[0.0, 70.0]);
        tree[0].neighbour_count = 9;
        assert_eq!(sample_ahead(&mut tree, &request(&BOUNDS), &mut random).0, 0);
    }

    #[test]
    fn a_long_region_is_sampled_at_the_front_until_that_has_many_neighbours() {
        let mut random = Random::new(1, Stream::Possibility, 0, 0);
        let mut tree = tree(&[0.0, 20.0, 5.0]);
        let tips: Vec<u32> =
            (0..60).map(|_| sample_ahead(&mut tree, &request(&BOUNDS), &mut random).0).collect();
        assert!(tips[..25].iter().all(|&tip| tip == 1) && tips.contains(&2), "{tips:?}");
    }
}
