//! Stage P of w-RPG: uniform samples of C_N, joined by straight lines [Grey 5.3, 5.5].
//!
//! E is a box times three Euler angles, with one metric, in which a radian counts a metre. Lines
//! are straight in its six coordinates. Every pair of samples may be joined; a line is tested only
//! once it is part of the best route over lines that are not refuted (Bohlin, Kavraki 2000), which
//! gives the route that testing all of them first would give.

use std::f64::consts::PI;

use glam::{DMat3, DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::rotation_from_rpy;

use crate::base::arena::{filled, reserve};
use crate::base::random::{Random, Stream};
use crate::methods::workbench::Workbench;
use crate::preparation::necessary;

/// Distance between two tests of C_N along a line, in the metric of E, m.
const LINE_STEP: f64 = 0.1;
/// Pairs of points that a search over them looks at for one unit of work.
const PAIRS_PER_UNIT: u64 = 10_000;
/// Highest root in E above that of the standing robot, relative to its height over the ground.
pub(crate) const ROOT_HEIGHT_SHARE: f64 = 1.1;
/// Most samples.
pub(crate) const POINTS_MAX: usize = 1_024;
/// The index of the start and of the goal.
const ENDS: [usize; 2] = [0, 1];

/// Coordinates in E: position (m), roll, pitch and yaw (rad).
type Point = [f64; 6];

/// The test of a route: all lines before `line` hold, and that one before its point `next`.
#[derive(Debug, Clone, Copy, Default)]
struct RouteTest {
    line: usize,
    next: u32,
}

/// What a step of the search for a route came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RouteEvent {
    /// There is more to do.
    Continue,
    /// There is a route.
    Found,
    /// The samples hold no route.
    Exhausted,
}

/// A set of pairs of points, one bit for each.
#[derive(Debug)]
struct PairSet(Vec<u64>);

impl PairSet {
    /// No pair. Allocates.
    fn new() -> Self {
        Self(filled(0, POINTS_MAX * POINTS_MAX / 64))
    }

    fn insert(&mut self, from: usize, to: usize) {
        for bit in [from * POINTS_MAX + to, to * POINTS_MAX + from] {
            self.0[bit / 64] |= 1 << (bit % 64);
        }
    }

    fn contains(&self, from: usize, to: usize) -> bool {
        let bit = from * POINTS_MAX + to;
        self.0[bit / 64] >> (bit % 64) & 1 == 1
    }
}

/// The samples of C_N and the lines between them, allocated once.
#[derive(Debug)]
pub(crate) struct Exploration {
    points: Vec<Point>,
    /// The pairs that a tested line joins.
    joined: PairSet,
    /// The pairs whose line leaves C_N.
    refuted: PairSet,
    test: RouteTest,
    /// Number of routes that used each point.
    used: Vec<u32>,
    costs: Vec<f64>,
    before: Vec<u32>,
    is_done: Vec<bool>,
    /// The points of the route found last.
    route: Vec<u32>,
    bounds: [DVec3; 2],
    /// Largest roll, pitch and yaw of samples, rad.
    angles_max: [f64; 3],
    draws: u64,
}

impl Exploration {
    /// Reserves memory.
    pub fn new() -> Self {
        Self {
            points: reserve(POINTS_MAX),
            joined: PairSet::new(),
            refuted: PairSet::new(),
            test: RouteTest::default(),
            used: filled(0, POINTS_MAX),
            costs: filled(0.0, POINTS_MAX),
            before: filled(0, POINTS_MAX),
            is_done: filled(false, POINTS_MAX),
            route: reserve(POINTS_MAX),
            bounds: [DVec3::ZERO; 2],
            angles_max: [PI; 3],
            draws: 0,
        }
    }

    /// Begins between two root poses, in a box of E.
    pub fn begin(&mut self, ends: [&Pose; 2], bounds: [DVec3; 2]) {
        self.points.clear();
        self.points.extend(ends.map(coordinates));
        self.bounds = bounds;
        self.joined.0.fill(0);
        self.refuted.0.fill(0);
        self.used.fill(0);
        self.route.clear();
    }

    /// Draws samples with the root upright, of one heading.
    pub fn keep_upright(&mut self) {
        self.angles_max = [0.0; 3];
    }

    /// Number of samples, start and goal excluded.
    pub fn samples(&self) -> usize {
        self.points.len() - ENDS.len()
    }

    /// Whether no sample fits any more.
    pub fn is_full(&self) -> bool {
        self.points.len() == POINTS_MAX
    }

    /// Draws a point of E, and keeps it if C_N holds.
    pub fn sample(&mut self, bench: &mut Workbench<'_>) {
        bench.counts.route += 1;
        let mut random = Random::new(bench.context.seed, Stream::Method, 0, self.draws);
        self.draws += 1;
        let [low, high] = self.bounds;
        let at = [0, 1, 2].map(|axis| random.uniform(low[axis], high[axis]));
        let angles = self.angles_max.map(|half| random.uniform(-half, half));
        let point = [at[0], at[1], at[2], angles[0], angles[1], angles[2]];
        if holds(bench, &point) {
            self.points.push(point);
        }
    }

    /// Begins to search a route.
    pub fn begin_route(&mut self) {
        self.route.clear();
    }

    /// Takes the next route over lines that are not refuted and, seen from above, at most
    /// `line_max` (m) long, or tests the next point of the one that was taken.
    pub fn seek_route(&mut self, bench: &mut Workbench<'_>, line_max: f64) -> RouteEvent {
        bench.counts.route += 1;
        if self.route.is_empty() {
            let count = self.points.len() as u64;
            bench.counts.route += count * count / PAIRS_PER_UNIT;
            self.test = RouteTest { line: 0, next: 1 };
            let is_any = self.take_route(line_max);
            return if is_any { RouteEvent::Continue } else { RouteEvent::Exhausted };
        }
        let RouteTest { line, next } = self.test;
        let [from, to] = [line, line + 1].map(|index| self.route[index] as usize);
        let steps = self.steps(from, to);
        if self.joined.contains(from, to) || next > steps {
            self.joined.insert(from, to);
            self.test = RouteTest { line: line + 1, next: 1 };
            if line + 2 == self.route.len() {
                self.finish_route(bench);
                return RouteEvent::Found;
            }
        } else if holds(bench, &self.between(from, to, f64::from(next) / f64::from(steps))) {
            self.test.next += 1;
        } else {
            self.refuted.insert(from, to);
            self.route.clear();
        }
        RouteEvent::Continue
    }

    /// Number of points that are tested on a line.
    fn steps(&self, from: usize, to: usize) -> u32 {
        libm::ceil(distance(&self.points[from], &self.points[to]) / LINE_STEP).max(1.0) as u32
    }

    /// The point of E at a share of a line.
    fn between(&self, from: usize, to: usize, share: f64) -> Point {
        let [a, b] = [from, to].map(|index| &self.points[index]);
        std::array::from_fn(|axis| a[axis] + share * (b[axis] - a[axis]))
    }

    /// Counts the route that was found.
    fn finish_route(&mut self, bench: &mut Workbench<'_>) {
        bench.counts.routes += 1;
        for &at in &self.route[1..] {
            self.used[at as usize] += 1;
        }
    }

    /// Takes the route from the goal to the start with the fewest lines, where a point counts one
    /// more for each earlier route that used it: so later routes differ. Returns whether there is
    /// one.
    fn take_route(&mut self, line_max: f64) -> bool {
        let count = self.points.len();
        self.costs[..count].fill(f64::INFINITY);
        self.is_done[..count].fill(false);
        self.costs[ENDS[0]] = 0.0;
        while let Some(at) = self.nearest_open(count).filter(|&at| at != ENDS[1]) {
            self.is_done[at] = true;
            for to in 0..count {
                let length = above(&self.points[at]).distance(above(&self.points[to]));
                if length > line_max || self.refuted.contains(at, to) {
                    continue;
                }
                let cost = self.costs[at] + 1.0 + f64::from(self.used[to]);
                if cost < self.costs[to] {
                    (self.costs[to], self.before[to]) = (cost, at as u32);
                }
            }
        }
        if !self.costs[ENDS[1]].is_finite() {
            return false;
        }
        let mut at = ENDS[1];
        self.route.push(at as u32);
        while at != ENDS[0] {
            at = self.before[at] as usize;
            self.route.push(at as u32);
        }
        true
    }

    /// The cheapest point that was reached and not expanded; the first of several.
    fn nearest_open(&self, count: usize) -> Option<usize> {
        let open = (0..count).filter(|&at| !self.is_done[at] && self.costs[at].is_finite());
        open.min_by(|&a, &b| self.costs[a].total_cmp(&self.costs[b]))
    }

    /// The vertices of the route found last, seen from above, from the goal to the start, m.
    pub fn route(&self) -> impl Iterator<Item = DVec2> + '_ {
        self.route.iter().map(|&at| above(&self.points[at as usize]))
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        let pairs = self.joined.0.capacity() + self.refuted.0.capacity();
        self.points.capacity() * size_of::<Point>() + pairs * size_of::<u64>()
    }
}

/// The coordinates of a root pose.
fn coordinates(world_from_root: &Pose) -> Point {
    let at = world_from_root.translation;
    let matrix = DMat3::from_quat(world_from_root.rotation);
    let pitch = libm::asin((-matrix.x_axis.z).clamp(-1.0, 1.0));
    let roll = libm::atan2(matrix.y_axis.z, matrix.z_axis.z);
    [at.x, at.y, at.z, roll, pitch, libm::atan2(matrix.x_axis.y, matrix.x_axis.x)]
}

/// Whether C_N holds at a point of E.
fn holds(bench: &Workbench<'_>, &[x, y, z, roll, pitch, yaw]: &Point) -> bool {
    let constraints = &bench.context.constraints;
    let world_from_root =
        Pose::from_parts(DVec3::new(x, y, z), rotation_from_rpy(roll, pitch, yaw));
    let preparation = &bench.context.preparation;
    necessary(preparation, &constraints.robot, &constraints.collision, &world_from_root).holds()
}

fn above(point: &Point) -> DVec2 {
    DVec2::new(point[0], point[1])
}

fn distance(a: &Point, b: &Point) -> f64 {
    libm::sqrt(a.iter().zip(b).map(|(a, b)| (b - a) * (b - a)).sum())
}
