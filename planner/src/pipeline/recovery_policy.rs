//! When stage M needs more footholds or another route, and which of them [Grey 4.4.4].
//!
//! New footholds bring new cheap sequences, which delay the old ones. So an action is due only
//! where the cheapest sequence has a transition of high cost, or many sequences have failed. Both
//! limits double with every action. The actions take turns: wider stances with toe-out angles,
//! random footholds, a detour, another route.

/// Failed sequences before an action is due, at first and at most.
const FAILURES_MAX: [u32; 2] = [24, 192];
/// Highest acceptable cost of a transition of the cheapest sequence, at first and at most, m3. A
/// transition of 0.3 m that no primitive posture satisfies costs more than the first from the
/// beginning.
const ACCEPTABLE_COST: [f64; 2] = [3.2, 9.6];
/// Sequences that are tried at any cost.
const COSTLY_SEQUENCES: u32 = 2;
/// Vertices of the route on either side of a bottleneck that a detour replaces.
const DETOUR_REACH: usize = 4;

/// What follows a failed segment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RecoveryAction {
    /// Sweep the vertices near the failed transitions again, with a wider stance and toe-out.
    Resweep,
    /// Sample random footholds near the failed transitions.
    SampleNear,
    /// Replace the route near the worst failure.
    Detour,
    /// Find another route.
    NewRoute,
}

/// Failed searches for a motion between two configurations after which others are sampled.
pub(crate) const ALTERNATIVE_FAILURES: u32 = 3;

/// The actions in order. From [`REPEATED_FROM`] on they repeat.
const ACTIONS: [RecoveryAction; 6] = [
    RecoveryAction::Resweep,
    RecoveryAction::SampleNear,
    RecoveryAction::Detour,
    RecoveryAction::SampleNear,
    RecoveryAction::SampleNear,
    RecoveryAction::NewRoute,
];
/// Index of the action that follows the last one.
const REPEATED_FROM: usize = 1;

/// Failures of one segment, and the actions that were taken.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RecoveryPolicy {
    failures: u32,
    failures_max: u32,
    acceptable_cost: f64,
    next_action: usize,
}

impl Default for RecoveryPolicy {
    /// No failure.
    fn default() -> Self {
        Self {
            failures: 0,
            failures_max: FAILURES_MAX[0],
            acceptable_cost: ACCEPTABLE_COST[0],
            next_action: 0,
        }
    }
}

impl RecoveryPolicy {
    /// Counts a failed sequence whose costliest transition costs `cost_max` (m3). Returns the
    /// action that is due; none where the next sequence is to be tried.
    pub fn count_failure(&mut self, cost_max: f64) -> Option<RecoveryAction> {
        self.failures += 1;
        let is_costly = cost_max > self.acceptable_cost && self.failures > COSTLY_SEQUENCES;
        if self.failures <= self.failures_max && !is_costly {
            return None;
        }
        self.failures = 0;
        self.acceptable_cost = (2.0 * self.acceptable_cost).min(ACCEPTABLE_COST[1]);
        self.failures_max = (2 * self.failures_max).min(FAILURES_MAX[1]);
        Some(self.next_action())
    }

    /// The next action, at once: for a segment without any sequence.
    pub fn next_action(&mut self) -> RecoveryAction {
        let action = ACTIONS[self.next_action];
        self.next_action += 1;
        if self.next_action == ACTIONS.len() {
            self.next_action = REPEATED_FROM;
        }
        action
    }
}

/// The ends of a detour about a vertex, within the segment from `first` to `last`; none where it
/// would replace the whole segment.
pub(crate) fn detour_about([first, last]: [usize; 2], vertex: usize) -> Option<[usize; 2]> {
    let ends = [vertex.saturating_sub(DETOUR_REACH).max(first), (vertex + DETOUR_REACH).min(last)];
    (ends != [first, last] && ends[0] < ends[1]).then_some(ends)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_failure_limit_grows_and_the_actions_take_turns() {
        let mut policy = RecoveryPolicy::default();
        let rounds: Vec<(u32, RecoveryAction)> = (0..12)
            .map(|_| {
                let mut failures = 1;
                loop {
                    match policy.count_failure(0.0) {
                        Some(action) => break (failures, action),
                        None => failures += 1,
                    }
                }
            })
            .collect();
        assert!(rounds.windows(2).all(|pair| pair[0].0 <= pair[1].0));
        assert_eq!(rounds[0], (FAILURES_MAX[0] + 1, RecoveryAction::Resweep));
        assert!(
            rounds[1..6].iter().any(|round| round.1 == RecoveryAction::Detour)
                && rounds[6..].iter().any(|round| round.1 == RecoveryAction::NewRoute)
        );
        assert!(rounds[1..].iter().all(|round| round.1 != RecoveryAction::Resweep));
    }

    #[test]
    fn a_high_cost_makes_an_action_due_early_and_the_limit_grows() {
        let failures = |policy: &mut RecoveryPolicy, cost: f64| {
            (1..).find(|_| policy.count_failure(cost).is_some()).unwrap()
        };
        let mut policy = RecoveryPolicy::default();
        assert_eq!(failures(&mut policy, 1.5 * ACCEPTABLE_COST[0]), COSTLY_SEQUENCES + 1);
        assert!(failures(&mut policy, 1.5 * ACCEPTABLE_COST[0]) > FAILURES_MAX[0], "acceptable");
        assert_eq!(failures(&mut policy, 2.0 * ACCEPTABLE_COST[1]), COSTLY_SEQUENCES + 1);
    }

    #[test]
    fn a_detour_stays_within_its_segment_and_never_replaces_all_of_it() {
        assert_eq!(detour_about([0, 30], 2), Some([0, 6]));
        assert_eq!(detour_about([0, 30], 29), Some([25, 30]));
        assert_eq!(detour_about([10, 14], 12), None);
    }
}
