//! Windows of a walk in which others are tried, where the walk takes long.

use surefoot_shared_types::message::{PlanChunk, SupportMode};

use crate::base::arena::reserve;
use crate::base::random::Random;
use crate::motion::ids::TransitionId;
use crate::motion::roadmap::Roadmap;
use crate::pipeline::improvement_walk::Walk;

/// Steps before and after the chosen one that may change, too.
const CHANGED: usize = 1;
/// Steps around these that are smoothed and timed with them.
const AROUND: usize = 2;

/// How long each step of a plan takes, from touch-down to touch-down, s.
#[derive(Debug)]
pub(crate) struct Places {
    seconds: Vec<f64>,
}

impl Places {
    /// Reserves memory for plans of `steps_max` steps.
    pub fn new(steps_max: usize) -> Self {
        Self { seconds: reserve(steps_max) }
    }

    /// Measures the steps of a plan.
    pub fn measure(&mut self, chunks: &[PlanChunk]) {
        self.seconds.clear();
        let (mut begin, mut is_single) = (0.0, false);
        for chunk in chunks {
            let was_single = is_single;
            is_single = chunk.mode != SupportMode::Double as u32;
            let time = chunk.waypoints().first().map_or(begin, |first| first.time);
            if was_single && !is_single && self.seconds.len() < self.seconds.capacity() {
                self.seconds.push(time - begin);
                begin = time;
            }
        }
    }

    /// A random step of `steps`, the more likely the longer it takes: by the square of its time.
    pub fn choose(&self, steps: usize, random: &mut Random) -> usize {
        let known = &self.seconds[..self.seconds.len().min(steps)];
        let weight = |seconds: &f64| seconds * seconds;
        let mut left = random.uniform(0.0, known.iter().map(weight).sum());
        let is_past = |seconds: &f64| {
            left -= weight(seconds);
            left < 0.0
        };
        known.iter().position(is_past).unwrap_or(0)
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.seconds.capacity() * size_of::<f64>()
    }
}

/// Some steps of a walk.
#[derive(Debug, Default, Clone, Copy)]
pub(crate) struct Window {
    /// The first node, at a touch-down or the start.
    begin: usize,
    /// The last node, at a lift-off or the goal.
    pub end: usize,
    /// The nodes before the swings that may change: the first, and the end.
    changed: [usize; 2],
    /// Walks tried so far.
    pub tries: u32,
    /// Duration of the walk in it, s.
    pub seconds: f64,
}

impl Window {
    /// The window about a swing, of a walk of `nodes` nodes with these nodes before its swings.
    pub fn about(chosen: usize, swings: impl Iterator<Item = usize> + Clone, nodes: usize) -> Self {
        let node = |swing: usize| swings.clone().nth(swing).unwrap_or(nodes - 1);
        let first = chosen.saturating_sub(CHANGED);
        let before = first.checked_sub(AROUND + 1);
        let after = chosen + CHANGED + AROUND + 1;
        Self {
            begin: before.map_or(0, |swing| node(swing) + 1),
            end: node(after),
            changed: [node(first), node(chosen + CHANGED + 1)],
            tries: 0,
            seconds: f64::INFINITY,
        }
    }

    /// The nodes of `walk` in the window, which is one of `draft`.
    pub fn of<'a>(&self, draft: &Walk, walk: &'a Walk) -> &'a [TransitionId] {
        &walk.nodes[self.begin..=self.end + walk.nodes.len() - draft.nodes.len()]
    }

    /// The node before a random swing that may change.
    pub fn swing(&self, draft: &Walk, roadmap: &Roadmap, random: &mut Random) -> Option<usize> {
        let may_change = |swing: &usize| (self.changed[0]..self.changed[1]).contains(swing);
        let count = draft.swings(roadmap).filter(may_change).count();
        draft.swings(roadmap).filter(may_change).nth(random.below(count.max(1)))
    }

    /// Whether another walk is that of the draft outside of the window.
    pub fn has_the_ends_of(&self, draft: &Walk, walk: &Walk) -> bool {
        let (nodes, others) = (&draft.nodes, &walk.nodes);
        let last = nodes.len() - self.end;
        others.len() >= self.begin + 1 + last
            && nodes[..=self.begin] == others[..=self.begin]
            && nodes[self.end..] == others[others.len() - last..]
    }
}
