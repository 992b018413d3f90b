//! Stage P of w-RPG: uniform samples of C_N, joined by straight lines [Grey 5.3, 5.5].
//!
//! E is a box times three Euler angles, with one metric, in which a radian counts a metre. Lines
//! are straight in its six coordinates. Two samples are joined only if they lie, seen from above,
//! within three quarters of the discs' radius: those of lemma 3 do, since their balls have a
//! quarter of it as radius and stand as far apart, and so the discs of a route leave no gap.

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
/// Longest line, seen from above, relative to the radius of the discs.
const LINE_SHARE: f64 = 0.75;
/// Highest root in E above that of the standing robot, relative to its height over the ground.
pub(crate) const ROOT_HEIGHT_SHARE: f64 = 1.1;
/// Most samples.
pub(crate) const POINTS_MAX: usize = 1_024;
/// The index of the start and of the goal.
const ENDS: [usize; 2] = [0, 1];

/// Coordinates in E: position (m), roll, pitch and yaw (rad).
type Point = [f64; 6];

/// A line that is being tested, from its `next` point on.
#[derive(Debug, Clone, Copy, Default)]
struct Line {
    from: usize,
    to: usize,
    next: u32,
}

/// The samples of C_N and the lines between them, allocated once.
#[derive(Debug)]
pub(crate) struct Exploration {
    points: Vec<Point>,
    /// One bit for each pair of points: whether a line joins them.
    joined: Vec<u64>,
    line: Line,
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
            joined: filled(0, POINTS_MAX * POINTS_MAX / 64),
            line: Line::default(),
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
        self.line = Line { from: 1, to: 0, next: 0 };
        self.bounds = bounds;
        self.joined.fill(0);
        self.used.fill(0);
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

    /// Tests the next point of the next line no longer, seen from above, than the discs of this
    /// radius (m) allow. Returns `false` once all pairs are tested.
    pub fn join_next(&mut self, bench: &mut Workbench<'_>, disc_radius: f64) -> bool {
        bench.counts.route += 1;
        let Line { from, to, next } = self.line;
        if from == self.points.len() {
            return false;
        }
        let (a, b) = (&self.points[from], &self.points[to]);
        let is_near = above(a).distance(above(b)) <= LINE_SHARE * disc_radius;
        let steps = libm::ceil(distance(a, b) / LINE_STEP).max(1.0) as u32;
        let share = f64::from(next) / f64::from(steps);
        let point = std::array::from_fn(|axis| a[axis] + share * (b[axis] - a[axis]));
        if !is_near || !holds(bench, &point) {
            self.next_line();
        } else if next == steps {
            self.join(from, to);
            self.next_line();
        } else {
            self.line.next += 1;
        }
        true
    }

    fn next_line(&mut self) {
        let Line { from, to, .. } = self.line;
        let (from, to) = if to + 1 < from { (from, to + 1) } else { (from + 1, 0) };
        self.line = Line { from, to, next: 0 };
    }

    fn join(&mut self, from: usize, to: usize) {
        for bit in [from * POINTS_MAX + to, to * POINTS_MAX + from] {
            self.joined[bit / 64] |= 1 << (bit % 64);
        }
    }

    fn is_joined(&self, from: usize, to: usize) -> bool {
        let bit = from * POINTS_MAX + to;
        self.joined[bit / 64] >> (bit % 64) & 1 == 1
    }

    /// Finds the route with the fewest lines, where a point counts one more for each earlier route
    /// that used it: so later routes differ. Returns whether there is one.
    pub fn find_route(&mut self, bench: &mut Workbench<'_>) -> bool {
        bench.counts.route += 1;
        let count = self.points.len();
        self.costs[..count].fill(f64::INFINITY);
        self.is_done[..count].fill(false);
        self.costs[ENDS[0]] = 0.0;
        while let Some(at) = self.nearest_open(count).filter(|&at| at != ENDS[1]) {
            self.is_done[at] = true;
            for to in 0..count {
                if !self.is_joined(at, to) {
                    continue;
                }
                let cost = self.costs[at] + 1.0 + f64::from(self.used[to]);
                if cost < self.costs[to] {
                    (self.costs[to], self.before[to]) = (cost, at as u32);
                }
            }
        }
        self.route.clear();
        if !self.costs[ENDS[1]].is_finite() {
            return false;
        }
        bench.counts.routes += 1;
        let mut at = ENDS[1];
        self.route.push(at as u32);
        while at != ENDS[0] {
            at = self.before[at] as usize;
            self.used[at] += 1;
            self.route.push(at as u32);
        }
        true
    }

    /// The cheapest point that was reached and not expanded; the first of several.
    fn nearest_open(&self, count: usize) -> Option<usize> {
        let open = (0..count).filter(|&at| !self.is_done[at] && self.costs[at].is_finite());
        open.min_by(|&a, &b| self.costs[a].total_cmp(&self.costs[b]))
    }

    /// The vertices of the route found last, seen from above, m.
    pub fn route(&self) -> impl Iterator<Item = DVec2> + '_ {
        self.route.iter().map(|&at| above(&self.points[at as usize]))
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.points.capacity() * size_of::<Point>() + self.joined.capacity() * size_of::<u64>()
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
