//! A coarse path from start to goal over the ground that steps reach, along which the robot above
//! its legs fits. It proves nothing; stage P follows it where straight branches find no route.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;

use crate::base::arena::reserve;
use crate::relaxation::grid::{AROUND, Grid, levels};
use crate::relaxation::tuning::{
    CLIMB_COST, CLIMB_MAX, COLUMNS_MAX, GAP_COST, GOAL_DISTANCE, LEG_LENGTH_MAX, PLACES_MAX,
    PLACES_PER_UNIT, STRIDE_MAX,
};

/// Millimetres, the unit of costs.
const PER_METRE: f64 = 1_000.0;

/// Ground on which the path stands, and the place from which it came.
#[derive(Debug, Clone, Copy)]
struct Visit {
    column: u32,
    level: u32,
    parent: u32,
}

/// A place that waits for its test, by the least cost of a path over it, mm.
type Entry = (Reverse<u32>, Reverse<[u32; 4]>);

/// What the search does next.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Activity {
    Searching,
    /// Replaces the places between one of the path and a later one by the line between both, if a
    /// metre of it costs at most `cost_max`, as it does along the places.
    Shortcutting {
        from: usize,
        to: usize,
        cost_max: f64,
    },
    Over,
}

/// The search for the path (A* over voxels of ground), and the path.
#[derive(Debug)]
pub(crate) struct PathSearch {
    /// The places that are tested, by cost.
    places: Vec<Visit>,
    /// Their voxels, by column.
    seen: Vec<u64>,
    waiting: BinaryHeap<Entry>,
    goal: DVec3,
    activity: Activity,
    /// The places of the path found, m.
    found: Vec<DVec3>,
    /// The ends of its straight legs after the start, m.
    path: Vec<DVec3>,
}

impl PathSearch {
    /// A search with reserved memory. Allocates.
    pub fn new() -> Self {
        Self {
            places: reserve(PLACES_MAX),
            seen: vec![0; COLUMNS_MAX],
            waiting: BinaryHeap::with_capacity(PLACES_MAX * (AROUND.len() - 1)),
            goal: DVec3::ZERO,
            activity: Activity::Over,
            found: reserve(PLACES_MAX),
            path: reserve(PLACES_MAX),
        }
    }

    /// Begins between two points on the ground.
    pub fn begin(&mut self, grid: &Grid, [start, goal]: [DVec3; 2]) {
        self.seen[..grid.columns()].fill(0);
        self.places.clear();
        self.waiting.clear();
        self.path.clear();
        (self.goal, self.activity) = (goal, Activity::Over);
        if let Some((column, level)) = grid.voxel_of(start) {
            self.activity = Activity::Searching;
            self.wait(grid, [column, level], (0, 0));
        }
    }

    /// The path, once there is one: the ends of its straight legs after the start, m.
    pub fn path(&self) -> &[DVec3] {
        &self.path
    }

    /// Does one unit of work on the ground of `reached`, by column. `cost` returns that of a metre
    /// at a point on the ground in a direction, at least 1, or `None` where the robot does not fit.
    /// Returns whether the search is over.
    pub fn advance(
        &mut self,
        grid: &Grid,
        reached: &[u64],
        cost: impl Fn(DVec3, DVec3) -> Option<f64>,
    ) -> bool {
        for _ in 0..PLACES_PER_UNIT {
            match self.activity {
                Activity::Searching => self.search(grid, reached, &cost),
                Activity::Shortcutting { from, to, cost_max } => {
                    self.extend_leg(grid, reached, ([from, to], cost_max), &cost);
                    break;
                }
                Activity::Over => break,
            }
        }
        self.activity == Activity::Over
    }

    /// Tests the place with the least cost, and adds those around it.
    fn search(&mut self, grid: &Grid, reached: &[u64], cost: impl Fn(DVec3, DVec3) -> Option<f64>) {
        let Some((_, Reverse([spent, column, level, parent]))) = self.waiting.pop() else {
            return self.activity = Activity::Over;
        };
        let at = [column as usize, level as usize];
        if self.seen[at[0]] & 1 << at[1] != 0 {
            return;
        }
        let Some(cost) = self.cost_of(grid, at, (spent, parent), cost) else { return };
        self.seen[at[0]] |= 1 << at[1];
        let index = self.places.len() as u32;
        self.places.push(Visit { column, level, parent });
        let offset = grid.center(at[0], at[1]) - self.goal;
        if offset.truncate().length() <= GOAL_DISTANCE && offset.z.abs() <= CLIMB_MAX {
            return self.trace(grid);
        }
        if self.places.len() == PLACES_MAX {
            return self.activity = Activity::Over;
        }
        for &direction in &AROUND[1..] {
            if let Some(next) = next_ground(grid, reached, at, direction)
                && self.seen[next[0]] & 1 << next[1] == 0
            {
                self.wait(grid, next, (cost, index));
            }
        }
    }

    /// The cost of the path to a place, mm: `spent` to its parent, and the way from there.
    fn cost_of(
        &self,
        grid: &Grid,
        at: [usize; 2],
        (spent, parent): (u32, u32),
        cost: impl Fn(DVec3, DVec3) -> Option<f64>,
    ) -> Option<u32> {
        let Some(parent) = self.places.get(parent as usize) else { return Some(0) };
        let [from, to] = [[parent.column as usize, parent.level as usize], at]
            .map(|[column, level]| grid.center(column, level));
        let way = to - from;
        let length = way.truncate().length();
        let across_gap = if length > 1.5 * grid.cell { GAP_COST } else { 1.0 };
        let rise = CLIMB_COST * way.z.abs();
        let per_metre = worst_cost([from, to], 0.5 * length, cost)?;
        Some(spent + ((length * per_metre * across_gap + rise) * PER_METRE) as u32)
    }

    fn wait(&mut self, grid: &Grid, [column, level]: [usize; 2], (cost, parent): (u32, u32)) {
        if self.waiting.len() < self.waiting.capacity() {
            let left = grid.center(column, level).distance(self.goal) * PER_METRE;
            let place = [cost, column as u32, level as u32, parent];
            self.waiting.push((Reverse(cost + left as u32), Reverse(place)));
        }
    }

    /// Makes the places up to the last one the path.
    fn trace(&mut self, grid: &Grid) {
        self.found.clear();
        let mut index = self.places.len() - 1;
        loop {
            let Visit { column, level, parent } = self.places[index];
            self.found.push(grid.center(column as usize, level as usize));
            if index == 0 {
                break;
            }
            index = parent as usize;
        }
        self.found.reverse();
        self.activity = Activity::Shortcutting { from: 0, to: 0, cost_max: 1.0 };
    }

    /// Extends a straight leg by one place if the robot fits all along as well as over the places;
    /// begins the next one if not.
    fn extend_leg(
        &mut self,
        grid: &Grid,
        reached: &[u64],
        ([from, to], cost_max): ([usize; 2], f64),
        cost: impl Fn(DVec3, DVec3) -> Option<f64>,
    ) {
        if to + 1 >= self.found.len() {
            self.path.push(self.goal);
            return self.activity = Activity::Over;
        }
        let [start, last, next] = [from, to, to + 1].map(|index| self.found[index]);
        let step_cost = worst_cost([last, next], 0.5 * grid.cell, &cost);
        let cost_max = step_cost.map_or(cost_max, |cost| cost.max(cost_max));
        let is_clear = || {
            let worst = worst_cost([start, next], 0.5 * grid.cell, &cost);
            lies_on_ground(grid, reached, [start, next])
                && worst.is_some_and(|cost| cost <= cost_max)
        };
        if from == to || start.distance(next) <= LEG_LENGTH_MAX && is_clear() {
            return self.activity = Activity::Shortcutting { from, to: to + 1, cost_max };
        }
        self.path.push(last);
        self.activity = Activity::Shortcutting { from: to, to, cost_max: 1.0 };
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        size_of_val(self.seen.as_slice())
            + self.places.capacity() * size_of::<Visit>()
            + self.waiting.capacity() * size_of::<Entry>()
            + (self.found.capacity() + self.path.capacity()) * size_of::<DVec3>()
    }
}

/// The nearest ground in a direction, at most a stride away, whose height is nearest to that of a
/// place.
fn next_ground(
    grid: &Grid,
    reached: &[u64],
    [column, level]: [usize; 2],
    direction: [i32; 2],
) -> Option<[usize; 2]> {
    let stride = grid.cell * libm::hypot(f64::from(direction[0]), f64::from(direction[1]));
    let strides = (libm::floor(STRIDE_MAX / stride) as i32).max(1);
    (1..=strides).find_map(|count| {
        let next = grid.neighbor(column, direction.map(|offset| offset * count))?;
        Some([next, ground_near(grid, reached[next], level)?])
    })
}

/// The level of ground nearest to another level, if one can climb from one to the other.
fn ground_near(grid: &Grid, reached: u64, level: usize) -> Option<usize> {
    let nearest = levels(reached).min_by_key(|&other| other.abs_diff(level))?;
    (nearest.abs_diff(level) as f64 * grid.level <= CLIMB_MAX.max(grid.level)).then_some(nearest)
}

/// Points on a line at most `spacing` (m) apart, its end included and its start not.
fn points([from, to]: [DVec3; 2], spacing: f64) -> impl Iterator<Item = DVec3> {
    let count = libm::ceil(from.distance(to) / spacing).max(1.0);
    (1..=count as u32).map(move |index| from.lerp(to, f64::from(index) / count))
}

/// The largest cost of a metre at points of a line at most `spacing` (m) apart; `None` if the robot
/// does not fit at one of them.
fn worst_cost(
    [from, to]: [DVec3; 2],
    spacing: f64,
    cost: impl Fn(DVec3, DVec3) -> Option<f64>,
) -> Option<f64> {
    let costs = points([from, to], spacing).map(|point| cost(point, to - from));
    costs.reduce(|a, b| a.zip(b).map(|(a, b)| a.max(b))).flatten()
}

/// Whether the ground below a line is about as high as the line.
fn lies_on_ground(grid: &Grid, reached: &[u64], line: [DVec3; 2]) -> bool {
    points(line, 0.5 * grid.cell).all(|point| {
        grid.voxel_of(point).is_some_and(|(column, level)| {
            ground_near(grid, reached[column], level).is_some_and(|near| near.abs_diff(level) <= 1)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::bvh::Aabb;

    const BOUNDS: Aabb = Aabb { min: DVec3::new(-3.0, -6.0, -0.5), max: DVec3::new(3.0, 6.0, 2.0) };

    /// The cost of a metre beside a wall along y of length 6 m, whose left end is at y = 3 m, for a
    /// robot that is 0.5 m wide and as long.
    fn beside_wall(point: DVec3, _: DVec3) -> Option<f64> {
        (point.x.abs() > 0.25 || point.y > 3.25 || point.y < -5.0).then_some(1.0)
    }

    /// The path between two points on level ground, which is missing where `is_gap` holds.
    fn path(
        ends: [DVec3; 2],
        is_gap: impl Fn(DVec3) -> bool,
        cost: impl Fn(DVec3, DVec3) -> Option<f64>,
    ) -> Vec<DVec3> {
        let grid = Grid::covering(&BOUNDS).unwrap();
        let (_, level) = grid.voxel_of(DVec3::ZERO).unwrap();
        let reached: Vec<u64> = (0..grid.columns())
            .map(|column| u64::from(!is_gap(grid.center(column, level))) << level)
            .collect();
        let mut search = PathSearch::new();
        search.begin(&grid, ends);
        while !search.advance(&grid, &reached, &cost) {}
        search.path().to_vec()
    }

    fn length(start: DVec3, path: &[DVec3]) -> f64 {
        let points = [&[start], path].concat();
        points.windows(2).map(|ends| ends[0].distance(ends[1])).sum()
    }

    #[test]
    fn a_path_leads_around_a_wall_by_the_shorter_side() {
        let ends = [DVec3::new(-1.0, 0.0, 0.0), DVec3::new(1.0, 0.0, 0.0)];
        let path = path(ends, |_| false, beside_wall);
        let shortest = 2.0 * DVec3::new(0.75, 3.25, 0.0).length() + 0.5;
        let found = length(ends[0], &path);
        assert!(path.len() < 12 && path.iter().any(|point| point.y > 3.2), "{path:?}");
        assert!(found < 1.1 * shortest, "{found} m, at best {shortest} m: {path:?}");
        let starts = std::iter::once(&ends[0]).chain(&path);
        for (from, to) in starts.zip(&path) {
            assert!(worst_cost([*from, *to], 0.05, beside_wall).is_some(), "{from} to {to}");
        }
    }

    #[test]
    fn a_gap_is_crossed_where_a_stride_does_and_no_other() {
        let ends = [DVec3::new(-2.0, 0.0, 0.0), DVec3::new(2.0, 0.0, 0.0)];
        let free = |_: DVec3, _: DVec3| Some(1.0);
        let narrow = path(ends, |point| point.x.abs() < 0.15, free);
        assert!(length(ends[0], &narrow) < 4.2, "{narrow:?}");
        assert!(path(ends, |point| point.x.abs() < 0.5, free).is_empty());
    }

    #[test]
    fn a_costly_passage_is_taken_where_the_way_around_costs_more() {
        let ends = [DVec3::new(-1.0, 0.0, 0.0), DVec3::new(1.0, 0.0, 0.0)];
        let low_beam = |cost: f64| {
            move |point: DVec3, way: DVec3| {
                Some(if beside_wall(point, way).is_some() { 1.0 } else { cost })
            }
        };
        for (cost, is_straight) in [(4.0, true), (40.0, false)] {
            let path = path(ends, |_| false, low_beam(cost));
            let is_inside = path.iter().all(|point| point.y.abs() < 0.5);
            assert_eq!(is_inside, is_straight, "{cost}: {path:?}");
        }
    }

    #[test]
    fn there_is_no_path_through_a_wall_across_the_floor() {
        let ends = [DVec3::new(-1.0, 0.0, 0.0), DVec3::new(1.0, 0.0, 0.0)];
        let across = |point: DVec3, _: DVec3| (point.x.abs() > 0.25).then_some(1.0);
        assert!(path(ends, |_| false, across).is_empty());
    }
}
