//! The rounded time law of a path: position, speed and acceleration along the path over time.
//!
//! The time-optimal law `s(t)` has jumps in its acceleration. The rounded law is its average over
//! `ROUNDING_TIME`: `(1 / T) (S(t + T / 2) - S(t - T / 2))` with `S` the integral of `s`. So its
//! acceleration is continuous and its jerk bounded. At rests the law waits for `T`, so that the
//! rounded one rests there too. Speeds and accelerations are averages of rates that the limits
//! allow near by; only where limits change within the window a rounded rate may exceed them.

use crate::base::arena::reserve;
use crate::timing::profile::Node;
use crate::timing::tuning::ROUNDING_TIME;

/// Position along the path with its derivatives by time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PathRates {
    /// Length of the path up to here, in units of its parameter.
    pub position: f64,
    /// Its derivative.
    pub speed: f64,
    /// Its second derivative.
    pub acceleration: f64,
}

/// The law of a path.
#[derive(Debug)]
pub struct TimeLaw {
    /// One for each node: the cell that begins there.
    cells: Vec<Cell>,
}

/// A cell of constant acceleration.
#[derive(Debug, Clone, Copy, Default)]
struct Cell {
    /// When it begins, s.
    time: f64,
    duration: f64,
    start: PathRates,
    /// Integral of the position up to its beginning.
    integral: f64,
}

impl Cell {
    fn end(&self) -> f64 {
        self.time + self.duration
    }

    /// Rates and the integral of the position `elapsed` seconds after its beginning; at rest after
    /// its end.
    fn at(&self, elapsed: f64) -> (PathRates, f64) {
        let PathRates { position, speed, acceleration } = self.start;
        let t = elapsed.min(self.duration);
        let reached = position + t * (speed + 0.5 * t * acceleration);
        let integral = self.integral + t * (position + t * (0.5 * speed + t * acceleration / 6.0));
        if elapsed > self.duration {
            let rates = PathRates { position: reached, ..PathRates::default() };
            return (rates, integral + reached * (elapsed - self.duration));
        }
        let speed = speed + t * acceleration;
        (PathRates { position: reached, speed, acceleration }, integral)
    }
}

impl TimeLaw {
    /// Reserves memory for paths of this many nodes.
    pub fn new(nodes_max: usize) -> Self {
        Self { cells: reserve(nodes_max) }
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.cells.capacity() * size_of::<Cell>()
    }

    /// Writes the cells from node `first` on for squared speeds `speeds` at the nodes.
    pub fn rebuild(&mut self, first: usize, nodes: &[Node], speeds: &[f64]) {
        self.cells.truncate(first);
        for index in first..nodes.len() {
            let cell = self.cell_at(index, nodes, speeds);
            self.cells.push(cell);
        }
    }

    fn cell_at(&self, index: usize, nodes: &[Node], speeds: &[f64]) -> Cell {
        let node = &nodes[index];
        let (time, integral) = match self.cells.last() {
            Some(before) => (before.end(), before.at(before.duration).1),
            None => (0.0, 0.0),
        };
        let wait = match index {
            0 => 0.5 * ROUNDING_TIME,
            _ if node.rests => ROUNDING_TIME,
            _ => 0.0,
        };
        let speed = speeds[index].max(0.0).sqrt();
        let step = nodes.get(index + 1).map_or(0.0, |next| next.position - node.position);
        let next_speed = speeds.get(index + 1).map_or(0.0, |speed| speed.max(0.0).sqrt());
        let mean = 0.5 * (speed + next_speed);
        let duration = if step > 0.0 { step / mean.max(SPEED_MIN) } else { 0.0 };
        let acceleration = if step > 0.0 { (next_speed - speed) / duration } else { 0.0 };
        Cell {
            time: time + wait,
            duration,
            start: PathRates { position: node.position, speed, acceleration },
            integral: integral + node.position * wait,
        }
    }

    /// When the rounded law ends, s.
    pub fn end(&self) -> f64 {
        self.cells.last().map_or(0.0, |cell| cell.end() + 0.5 * ROUNDING_TIME)
    }

    /// When the unrounded law reaches a node, s.
    pub fn time_of_node(&self, node: usize) -> f64 {
        self.cells[node].time
    }

    /// The nodes that the unrounded law passes between two times (s), with one more at both ends.
    pub fn nodes_between(&self, begin: f64, end: f64) -> std::ops::Range<usize> {
        let first = self.cells.partition_point(|cell| cell.time < begin);
        let last = self.cells.partition_point(|cell| cell.time <= end);
        first.saturating_sub(1)..(last + 1).min(self.cells.len())
    }

    /// The rounded law at a time.
    pub fn at(&self, time: f64) -> PathRates {
        let [(before, from), (after, to)] =
            [-0.5, 0.5].map(|part| self.unrounded(time + part * ROUNDING_TIME));
        PathRates {
            position: (to - from) / ROUNDING_TIME,
            speed: (after.position - before.position) / ROUNDING_TIME,
            acceleration: (after.speed - before.speed) / ROUNDING_TIME,
        }
    }

    /// When the rounded law is at a node, s.
    pub fn rounded_time_of_node(&self, node: usize, nodes: &[Node]) -> f64 {
        let cell = &self.cells[node];
        if node + 1 == nodes.len() {
            return self.end();
        }
        if nodes[node].rests {
            return cell.time - 0.5 * ROUNDING_TIME;
        }
        let [mut early, mut late] = [-0.5, 0.5].map(|part| cell.time + part * ROUNDING_TIME);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (early + late);
            if self.at(middle).position < nodes[node].position {
                early = middle;
            } else {
                late = middle;
            }
        }
        0.5 * (early + late)
    }

    fn unrounded(&self, time: f64) -> (PathRates, f64) {
        let after = self.cells.partition_point(|cell| cell.time <= time);
        match after.checked_sub(1) {
            Some(at) => self.cells[at].at(time - self.cells[at].time),
            None => self.cells.first().map_or_else(Default::default, |first| {
                let position = first.start.position;
                let rates = PathRates { position, ..PathRates::default() };
                (rates, first.integral + position * (time - first.time))
            }),
        }
    }
}

/// Smallest mean speed of a cell.
const SPEED_MIN: f64 = 1e-6;
/// Halvings in the search for the time of a node.
const HALVINGS: usize = 50;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::timing::limits::Level;
    use crate::timing::rate_set::RateSet;
    use crate::timing::zero_moment::BalanceTerms;

    fn node(position: f64, rests: bool) -> Node {
        Node {
            position,
            rests,
            rates: RateSet::default(),
            part: 1.0,
            factor: 1.0,
            level: Level::Full,
            balance: BalanceTerms::default(),
            inner: Default::default(),
        }
    }

    #[test]
    fn the_rounded_law_is_smooth_and_rests_at_rests() {
        let nodes = [0.0, 0.5, 1.0, 1.5, 2.0].map(|at| node(at, at == 0.0 || at == 1.0));
        let speeds = [0.0, 1.0, 0.0, 1.0, 0.0];
        let mut law = TimeLaw::new(nodes.len());
        law.rebuild(0, &nodes, &speeds);
        assert!((law.end() - 4.0 - 2.0 * ROUNDING_TIME).abs() < 1e-12, "{}", law.end());
        let rest = law.rounded_time_of_node(2, &nodes);
        for (time, position) in [(0.0, 0.0), (rest, 1.0), (law.end(), 2.0)] {
            let at = law.at(time);
            assert!((at.position - position).abs() < 1e-12, "{at:?}");
            assert!(at.speed.abs() < 1e-12 && at.acceleration.abs() < 1e-12, "{at:?}");
        }
        let step = 1e-4;
        for tick in 1..40_000 {
            let time = law.end() * f64::from(tick) / 40_000.0;
            let [before, here, after] = [time - step, time, time + step].map(|t| law.at(t));
            let speed = (after.position - before.position) / (2.0 * step);
            let acceleration = (after.speed - before.speed) / (2.0 * step);
            assert!((speed - here.speed).abs() < 1e-6, "{time}");
            assert!((acceleration - here.acceleration).abs() < 2e-3, "{time}");
            let jerk = (after.acceleration - before.acceleration) / (2.0 * step);
            assert!(jerk.abs() <= 2.0 / ROUNDING_TIME + 1e-6, "{time} {jerk}");
        }
        let middle = law.rounded_time_of_node(1, &nodes);
        assert!((law.at(middle).position - 0.5).abs() < 1e-12);
    }
}
