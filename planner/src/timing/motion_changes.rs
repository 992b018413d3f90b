//! What changed in the time law of a path since the motion of a span was checked: a span whose law
//! is the same as then is not checked again.

use crate::base::arena::reserve;
use crate::timing::timed_path::TimedPath;
use crate::timing::tuning::ROUNDING_TIME;

/// Distance (s) from a span within which a change of the law counts as one of its motion. The
/// rounded law depends on half of `ROUNDING_TIME` to both sides, and passes a node that much
/// earlier or later at most.
const REACH: f64 = 2.0 * ROUNDING_TIME;

/// Laws are counted from 1 on.
#[derive(Debug)]
pub struct MotionChanges {
    /// Number of laws so far.
    laws: u32,
    /// By node: its squared speed in the last law.
    speeds: Vec<f64>,
    /// By node: the last law that changed it.
    changed: Vec<u32>,
    /// By span: the last law that changed its motion.
    versions: Vec<u32>,
    /// By span: the version whose rates, and whose motion, were within the limits.
    checked: [Vec<u32>; 2],
}

/// The parts of the check of a span.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Checked {
    /// Its rates against those of the points around.
    Rates,
    /// Its motion as it is emitted.
    Motion,
}

impl MotionChanges {
    /// Reserves memory.
    pub fn new(nodes_max: usize, spans_max: usize) -> Self {
        Self {
            laws: 0,
            speeds: reserve(nodes_max),
            changed: reserve(nodes_max),
            versions: reserve(spans_max),
            checked: [reserve(spans_max), reserve(spans_max)],
        }
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.speeds.capacity() * (size_of::<f64>() + size_of::<u32>())
            + 3 * self.versions.capacity() * size_of::<u32>()
    }

    /// Begins a path.
    pub fn begin(&mut self) {
        self.laws = 0;
        self.speeds.clear();
        let [rates, motion] = &mut self.checked;
        for list in [&mut self.changed, &mut self.versions, rates, motion] {
            list.clear();
        }
    }

    /// Adds a span. Its nodes follow.
    pub fn push_span(&mut self) {
        if let Some(last) = self.changed.last_mut() {
            // The path does not end there any more.
            *last = self.laws + 1;
        }
        self.versions.push(0);
        self.checked.iter_mut().for_each(|checked| checked.push(0));
    }

    /// Adds a node.
    pub fn push_node(&mut self) {
        self.speeds.push(0.0);
        self.changed.push(self.laws + 1);
    }

    /// Keeps the first nodes and spans.
    pub fn truncate(&mut self, nodes: usize, spans: usize) {
        self.speeds.truncate(nodes);
        self.changed.truncate(nodes);
        if let Some(last) = self.changed.last_mut() {
            *last = self.laws + 1;
        }
        let [rates, motion] = &mut self.checked;
        for list in [&mut self.versions, rates, motion] {
            list.truncate(spans);
        }
    }

    /// The robot rests at a node from the next law on.
    pub fn rest_at(&mut self, node: usize) {
        self.changed[node] = self.laws + 1;
    }

    /// Takes a new law, which begins to differ from the last one at node `first` or later.
    pub fn note(&mut self, first: usize, timed: &TimedPath, speeds: &[f64]) {
        self.laws += 1;
        let before = self.speeds[first..].iter_mut().zip(&mut self.changed[first..]);
        for ((known, changed), &speed) in before.zip(&speeds[first..]) {
            if *known != speed {
                (*known, *changed) = (speed, self.laws);
            }
        }
        let changes_from = timed.law.time_of_node(first);
        for span in (0..timed.spans()).rev() {
            let ends = timed.first_node(span + 1).min(timed.nodes.len() - 1);
            let [begin, end] =
                [timed.first_node(span), ends].map(|node| timed.law.time_of_node(node));
            if end + REACH < changes_from {
                break;
            }
            let near = timed.law.nodes_between(begin - REACH, end + REACH);
            self.versions[span] = self.changed[near].iter().copied().fold(0, u32::max);
        }
    }

    /// Whether a span was within the limits as it is.
    pub(super) fn is_checked(&self, what: Checked, span: usize) -> bool {
        self.checked[what as usize][span] == self.versions[span]
    }

    /// A span is within the limits as it is.
    pub(super) fn mark(&mut self, what: Checked, span: usize) {
        self.checked[what as usize][span] = self.versions[span];
    }
}
