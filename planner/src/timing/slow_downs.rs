//! Where the next profile of a path shall be slower.

use crate::base::arena::reserve;
use crate::timing::timed_path::TimedPath;
use crate::timing::tuning::{ROUNDING_TIME, SLOW_DOWN};

/// By node: the factor by which the rates of the next profile are shrunk.
#[derive(Debug)]
pub struct SlowDowns {
    factors: Vec<f64>,
    /// The first node that may become slower.
    first: usize,
}

impl SlowDowns {
    /// Reserves memory for this many nodes.
    pub fn new(nodes_max: usize) -> Self {
        Self { factors: reserve(nodes_max), first: 0 }
    }

    /// Begins a path.
    pub fn begin(&mut self) {
        self.factors.clear();
        self.first = 0;
    }

    /// Adds a node.
    pub fn push(&mut self) {
        self.factors.push(1.0);
    }

    /// Keeps the first nodes.
    pub fn truncate(&mut self, nodes: usize) {
        self.factors.truncate(nodes);
    }

    /// Only nodes from `first` on become slower.
    pub fn keep_before(&mut self, first: usize) {
        self.first = first;
    }

    /// Takes the factors of the nodes from the first one on; the next ones are 1.
    pub fn take(&mut self) -> impl Iterator<Item = f64> + '_ {
        self.factors[self.first..].iter_mut().map(|factor| std::mem::replace(factor, 1.0))
    }

    /// The nodes within the rounding of a position shall be slower by `factor`.
    pub fn ask_near(&mut self, timed: &TimedPath, position: f64, speed: f64, factor: f64) {
        let reach = 0.5 * ROUNDING_TIME * speed;
        let nodes = &timed.nodes;
        let begin = nodes.partition_point(|node| node.position < position - reach);
        let end = nodes.partition_point(|node| node.position <= position + reach);
        self.ask([begin.saturating_sub(1), end + 1], factor.max(SLOW_DOWN));
    }

    /// The nodes between two times (s) shall be slower.
    pub fn ask_between(&mut self, timed: &TimedPath, begin: f64, end: f64) {
        let [begin, end] = [begin, end].map(|time| timed.law.at(time).position);
        let nodes = &timed.nodes;
        let first = nodes.partition_point(|node| node.position < begin);
        let last = nodes.partition_point(|node| node.position <= end);
        self.ask([first, last], SLOW_DOWN);
    }

    fn ask(&mut self, [begin, end]: [usize; 2], factor: f64) {
        let end = end.min(self.factors.len());
        for slower in self.factors[..end].iter_mut().skip(begin.max(self.first)) {
            *slower = slower.min(factor);
        }
    }
}
