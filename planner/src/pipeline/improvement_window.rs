//! Windows of a walk in which others are tried: where it takes long.

use surefoot_shared_types::message::{PlanChunk, SupportMode};

use crate::base::arena::reserve;
use crate::base::random::Random;
use crate::motion::ids::TransitionId;
use crate::pipeline::improvement_walk::Walk;
use crate::pipeline::trial_motion::TrialFacts;

/// Steps after the one that changes that are smoothed and timed with it: the foot's own next step,
/// which begins on the foothold, and the one between.
const AFTER: usize = 2;
/// The same where steps are left out, which changes one more.
const AFTER_FEWER: usize = 4;
/// How much less likely a step becomes once walks were tried there and none was faster.
const FADED: f64 = 0.5;

/// How long each step of a plan takes, from touch-down to touch-down, s.
#[derive(Debug)]
pub(crate) struct Places {
    /// Less where walks were tried.
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
    /// What makes a step long may be its foothold or one of the two before.
    pub fn choose(&self, steps: usize, random: &mut Random) -> usize {
        let known = &self.seconds[..self.seconds.len().min(steps)];
        let weight = |seconds: &f64| seconds * seconds;
        let mut left = random.uniform(0.0, known.iter().map(weight).sum());
        let is_past = |seconds: &f64| {
            left -= weight(seconds);
            left < 0.0
        };
        let chosen = known.iter().position(is_past).unwrap_or(0);
        chosen.saturating_sub(random.below(3))
    }

    /// Makes the step of a window less likely, if no walk was faster there.
    pub fn leave(&mut self, window: &Window) {
        if window.has_gained {
            return;
        }
        if let Some(seconds) = self.seconds.get_mut(window.step) {
            *seconds *= FADED;
        }
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.seconds.capacity() * size_of::<f64>()
    }
}

/// Some steps of a walk.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Window {
    /// The step that changes.
    step: usize,
    /// The node before it.
    swing: usize,
    /// The first node, at a touch-down or the start.
    begin: usize,
    /// The last node, at a lift-off or the goal.
    end: usize,
    /// Walks tried so far.
    pub tries: u32,
    /// Whether steps are left out in it; else footholds are moved.
    pub has_fewer: bool,
    has_gained: bool,
    /// The motion of the draft in it.
    facts: TrialFacts,
}

impl Window {
    /// The window about a step, of a walk of `nodes` nodes with these nodes before its swings, to
    /// move footholds or to have fewer steps.
    pub fn about(
        (step, has_fewer): (usize, bool),
        swings: impl Iterator<Item = usize> + Clone,
        nodes: usize,
    ) -> Self {
        let after = if has_fewer { AFTER_FEWER } else { AFTER };
        let node = |swing: usize| swings.clone().nth(swing).unwrap_or(nodes - 1);
        Self {
            step,
            swing: node(step),
            begin: step.checked_sub(1).map_or(0, |swing| node(swing) + 1),
            end: node(step + after + 1),
            tries: 0,
            has_fewer,
            has_gained: false,
            facts: TrialFacts::WORST,
        }
    }

    /// The node before the step that changes.
    pub fn swing(&self) -> usize {
        self.swing
    }

    /// What another motion in it is compared with: that of the draft, faster by `gain` (s).
    pub fn known(&self, gain: f64) -> TrialFacts {
        TrialFacts { seconds: self.facts.seconds - gain, ..self.facts }
    }

    /// Takes the motion of the draft, which is another walk of so many nodes if `is_tried`.
    pub fn take(&mut self, facts: TrialFacts, nodes: usize, before: usize, is_tried: bool) {
        self.facts = facts;
        if is_tried {
            self.has_gained = true;
            self.end = self.end + nodes - before;
        }
    }

    /// The nodes of `walk` in the window, which is one of `draft`.
    pub fn of<'a>(&self, draft: &Walk, walk: &'a Walk) -> &'a [TransitionId] {
        &walk.nodes[self.begin..=self.end + walk.nodes.len() - draft.nodes.len()]
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
