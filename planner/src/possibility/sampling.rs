//! Where the trees of stage P grow: toward stations anywhere, and ahead of where they are the least
//! crowded [Grey 3, 4.3].
//!
//! Stations drawn anywhere find their way around in a room. Of a course that is many times as long
//! as it is wide they hit the few metres where a tree may grow ever less often; the other draws go
//! there at once, however long it is.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;
use surefoot_shared_types::spatial::rotation_about;

use super::station::Station;
use super::tree::{Tree, Vertex};
use crate::collision::bvh::Aabb;
use crate::random::Random;

/// Samples drawn while the demands are high, and as many after they are relaxed, for each
/// [`SAMPLED_LENGTH`] of the place.
const SAMPLES_MAX: f64 = 384.0;
/// How long a place is that so many samples are enough for, m.
const SAMPLED_LENGTH: f64 = 10.0;
/// How long a short place may be, m.
const SHORT_LENGTH_MAX: f64 = 12.0;
/// How far beyond the box around both ends the root is sampled, at least, m, and as a share of
/// their distance.
const REACH: (f64, f64) = (2.5, 0.5);
/// One of so many samples of a tree lies anywhere; the others lie ahead of a vertex.
const ANYWHERE_EVERY: u32 = 4;
/// Only so many of the latest vertices count: where a tree has been, it need not be looked for ways
/// on.
const RECENT: usize = 192;
/// On a long course, what a metre from where the other tree began counts as crowd: ways on are
/// sought at the front before others.
const CROWD_PER_METRE: f64 = 2.0;
/// How far ahead of the vertex, m.
const AHEAD: [f64; 2] = [0.5, 1.5];
/// How far off its heading, rad.
const AHEAD_TURN_MAX: f64 = 1.0;
/// How far above or below it, m.
const AHEAD_RISE_MAX: f64 = 0.4;
/// How far off their way robots face that walk backward, rad.
pub(super) const BACKWARD: f64 = PI;
/// How far off their way robots face that step sideways, rad.
pub(super) const SIDES: [f64; 2] = [FRAC_PI_2, -FRAC_PI_2];

/// Where stations are drawn: around both ends (world, m), not beyond the world.
pub(super) fn bounds_around([start, goal]: [DVec3; 2], world: &Aabb) -> Aabb {
    let (least, share) = REACH;
    let around = Aabb { min: start.min(goal), max: start.max(goal) }
        .grown((share * start.distance(goal)).max(least));
    let (min, max) = (around.min.max(world.min), around.max.min(world.max));
    Aabb { min: min.min(max), max: max.max(min) }
}

/// How many samples are enough in a place.
pub(super) fn samples_max(bounds: &Aabb) -> u32 {
    (SAMPLES_MAX * (length(bounds) / SAMPLED_LENGTH).max(1.0)) as u32
}

/// Whether a place is so short that one passage decides whether there is a way.
pub(super) fn is_short(bounds: &Aabb) -> bool {
    length(bounds) <= SHORT_LENGTH_MAX
}

fn length(bounds: &Aabb) -> f64 {
    (bounds.max - bounds.min).truncate().length()
}

/// How a tree is to grow.
#[derive(Debug, Clone, Copy)]
pub(super) struct Course<'a> {
    /// Where stations are drawn.
    pub bounds: &'a Aabb,
    /// Where the other tree began.
    pub toward: DVec3,
    /// Whether it grows from the goal: it is walked toward its root, so that its vertices face away
    /// from where it grows.
    pub backward: bool,
    /// How far off its way the robot faces unless it sidles, rad.
    pub facing: f64,
    /// Whether the robot may face aside of its way.
    pub sidles: bool,
}

/// A branch to be grown: the vertex it grows from, toward where, and how far off its way the robot
/// faces, rad.
type Drawn = (u32, Station, f64);

/// Sample number `count` of a tree. The robot faces as at the vertex it grows from, unless it
/// sidles besides.
pub(super) fn draw(tree: &mut Tree, course: &Course<'_>, count: u32, random: &mut Random) -> Drawn {
    if count.is_multiple_of(ANYWHERE_EVERY) {
        anywhere(tree, course, random)
    } else {
        ahead(tree, course, random)
    }
}

/// A station anywhere, and the vertex nearest to it.
fn anywhere(tree: &Tree, course: &Course<'_>, random: &mut Random) -> Drawn {
    let position = DVec3::from_array(std::array::from_fn(|axis| {
        random.uniform(course.bounds.min[axis], course.bounds.max[axis])
    }));
    let target = Station { position, yaw: random.uniform(-PI, PI) };
    (tree.nearest(|station| station.place_distance_squared(position)), target, course.facing)
}

/// Of the latest vertices the one that is the least crowded, of several the last, and a station
/// ahead of it; on a long course what lies behind the front counts as crowded.
fn ahead(tree: &mut Tree, course: &Course<'_>, random: &mut Random) -> Drawn {
    let per_metre = if is_short(course.bounds) { 0.0 } else { CROWD_PER_METRE };
    let crowd = |vertex: &Vertex| {
        f64::from(vertex.crowd)
            + per_metre * libm::sqrt(vertex.station.place_distance_squared(course.toward))
    };
    let inside = tree
        .iter()
        .enumerate()
        .rev()
        .take(RECENT)
        .filter(|(_, vertex)| course.bounds.contains(vertex.station.position));
    let tip =
        inside.min_by(|(_, a), (_, b)| crowd(a).total_cmp(&crowd(b))).map_or(0, |(index, _)| index);
    tree[tip].crowd += 1;
    let Vertex { station: at, facing: faced, .. } = tree[tip];
    let yaw = at.yaw - faced + random.uniform(-AHEAD_TURN_MAX, AHEAD_TURN_MAX);
    let distance = random.uniform(AHEAD[0], AHEAD[1]) * if course.backward { -1.0 } else { 1.0 };
    let way = DVec3::new(distance, 0.0, random.uniform(-AHEAD_RISE_MAX, AHEAD_RISE_MAX));
    let facing =
        if course.sidles { [course.facing, SIDES[0], SIDES[1]][random.below(3)] } else { faced };
    (
        tip as u32,
        Station { position: at.position + rotation_about(DVec3::Z, yaw) * way, yaw: yaw + facing },
        facing,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    const BOUNDS: Aabb =
        Aabb { min: DVec3::new(-1.0, -2.0, -1.0), max: DVec3::new(60.0, 2.0, 1.0) };

    /// A course along which crowds alone decide.
    const WIDE: Aabb = Aabb { min: DVec3::new(-1.0, -2.0, -1.0), max: DVec3::new(10.0, 2.0, 1.0) };

    fn course(bounds: &Aabb) -> Course<'_> {
        Course { bounds, toward: bounds.max, backward: false, facing: 0.0, sidles: false }
    }

    /// Stations along x, of which none crowds another.
    fn tree(along_x: &[f64]) -> Tree {
        let mut tree = Tree::new(1_000);
        for &x in along_x {
            tree.add(Vertex::root(Station { position: DVec3::new(x, 0.0, 0.0), yaw: 0.0 }, None));
        }
        tree
    }

    /// How far a tree gets along a corridor whatever its length, where each sample ahead adds a
    /// station a stride toward it.
    fn farthest(samples: u32) -> f64 {
        let mut tree = tree(&[0.0]);
        for count in 0..samples {
            let mut random = Random::new(1, Stream::Possibility, u64::from(count), 0);
            let (tip, target, _) = ahead(&mut tree, &course(&BOUNDS), &mut random);
            tree.add(Vertex::root(tree[tip as usize].station.toward(&target, 0.25, 0.0), None));
        }
        tree.iter().map(|vertex| vertex.station.position.x).fold(0.0, f64::max)
    }

    #[test]
    fn twice_the_samples_lead_about_twice_as_far() {
        let [near, far] = [250, 500].map(farthest);
        assert!(near > 4.0 && far > 1.6 * near && far < 55.0, "{near} m, {far} m");
    }

    #[test]
    fn a_tree_grows_where_it_is_the_least_crowded_and_ahead() {
        let mut random = Random::new(1, Stream::Possibility, 0, 0);
        let mut tree = tree(&[0.0, 5.0, 9.0]);
        (tree[0].crowd, tree[2].crowd) = (2, 2);
        for backward in [false, true] {
            let (tip, target, _) =
                ahead(&mut tree, &Course { backward, ..course(&WIDE) }, &mut random);
            assert_eq!((tip, target.position.x < 5.0), (1, backward), "{target:?}");
        }
        assert_eq!(tree[1].crowd, 2, "what was tried counts as crowded");
    }

    #[test]
    fn nothing_grows_on_outside_the_place() {
        let mut random = Random::new(1, Stream::Possibility, 0, 0);
        let mut tree = tree(&[0.0, 70.0]);
        tree[0].crowd = 9;
        assert_eq!(ahead(&mut tree, &course(&BOUNDS), &mut random).0, 0);
    }

    #[test]
    fn a_long_course_is_tried_at_the_front_until_that_is_crowded() {
        let mut random = Random::new(1, Stream::Possibility, 0, 0);
        let mut tree = tree(&[0.0, 20.0, 5.0]);
        let tips: Vec<u32> =
            (0..60).map(|_| ahead(&mut tree, &course(&BOUNDS), &mut random).0).collect();
        assert!(tips[..25].iter().all(|&tip| tip == 1) && tips.contains(&2), "{tips:?}");
    }
}
