//! The guide routes beside the current one [Grey 3.2, figure 3.6]: stage P grows them in the rounds
//! of stage M, and stage M works on all of them in turn.

use crate::pipeline::recovery_policy::RecoveryPolicy;
use crate::possibility::{MidFeetPose, Progress, RouteSearch};

/// Work units of stage M for each unit in which stage P grows another route.
const WORK_PER_GROWTH: u64 = 2;

/// The state of another route.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum RouteState {
    /// None is searched.
    Unused,
    /// Stage P searches it.
    Growing,
    /// It is found, and stage M has not worked on it.
    Fresh,
    /// Stage M has worked on it.
    Known,
}

/// A guide route beside the current one.
#[derive(Debug)]
struct OtherRoute {
    search: RouteSearch,
    state: RouteState,
    /// Failures on it, and the actions that were taken.
    recovery: RecoveryPolicy,
    /// The number of the turn after which stage M left it.
    left_at: u64,
}

/// A change to another live route.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RouteChange {
    /// The failures on that route.
    pub recovery: RecoveryPolicy,
    /// Whether stage M has not worked on it.
    pub is_fresh: bool,
}

/// All routes beside the current one. None where `planner.live_routes` is 1.
#[derive(Debug)]
pub(crate) struct LiveRoutes {
    others: Vec<OtherRoute>,
    /// Work of stage M while another route grew, and work of its growth.
    counted: [u64; 2],
    /// Number of turns to another route.
    turns: u64,
    /// Actions taken in the current turn.
    actions: u32,
    /// Whether stage P has found no other route since the current one was found.
    is_exhausted: bool,
    /// The turn that begins in stage P.
    pub turn: Option<RouteChange>,
}

impl LiveRoutes {
    /// Unused routes, one for each search.
    pub fn new(searches: impl Iterator<Item = RouteSearch>) -> Self {
        let unused = |search| OtherRoute {
            search,
            state: RouteState::Unused,
            recovery: RecoveryPolicy::default(),
            left_at: 0,
        };
        Self {
            others: searches.map(unused).collect(),
            counted: [0; 2],
            turns: 0,
            actions: 0,
            is_exhausted: false,
            turn: None,
        }
    }

    /// The searches of all other routes.
    pub fn searches_mut(&mut self) -> impl Iterator<Item = &mut RouteSearch> {
        self.others.iter_mut().map(|other| &mut other.search)
    }

    /// Whether there may be a route beside the current one.
    pub fn has_others(&self) -> bool {
        !self.others.is_empty()
    }

    /// Counts work of stage M.
    pub fn count_work(&mut self, spent: u64) {
        if self.growing().is_some() {
            self.counted[0] += spent;
        }
    }

    /// Work units by which the other routes are to grow before stage M goes on.
    pub fn owed(&self) -> u64 {
        (self.counted[0] / WORK_PER_GROWTH).saturating_sub(self.counted[1])
    }

    /// Lets another route grow that avoids a place where stage M failed on the current one, unless
    /// one grows or none is unused.
    pub fn begin_growth(&mut self, current: &RouteSearch, failed_at: (MidFeetPose, f64)) {
        if self.is_exhausted || self.growing().is_some() {
            return;
        }
        let Some(other) = self.others.iter_mut().find(|other| other.state == RouteState::Unused)
        else {
            return;
        };
        other.search.begin_beside(current, failed_at);
        (other.state, other.recovery) = (RouteState::Growing, RecoveryPolicy::default());
        self.counted = [0; 2];
    }

    /// Lets a route grow by an `advance` of its search, which returns the progress and the work
    /// spent. Returns the latter.
    pub fn grow(&mut self, advance: impl FnOnce(&mut RouteSearch) -> (Progress, u64)) -> u64 {
        let Some(index) = self.growing() else { return 0 };
        let other = &mut self.others[index];
        let (progress, spent) = advance(&mut other.search);
        self.counted[1] += spent;
        match progress {
            Progress::Growing => return spent,
            Progress::Route => other.state = RouteState::Fresh,
            Progress::Exhausted | Progress::Full => {
                other.state = RouteState::Unused;
                self.is_exhausted = true;
            }
        }
        self.counted = [0; 2];
        spent
    }

    /// Counts an action on the current route.
    pub fn count_action(&mut self) {
        self.actions += 1;
    }

    /// The current route is left: stage P may find others again.
    pub fn end_route(&mut self) {
        self.is_exhausted = false;
    }

    /// Exchanges the current route for another one where one is due: a fresh one at once, a known
    /// one after an action on the current one. The failures on the current one are `recovery`.
    /// Returns whether it does.
    pub fn take_turn(&mut self, current: &mut RouteSearch, recovery: RecoveryPolicy) -> bool {
        let is_due = |other: &&mut OtherRoute| match other.state {
            RouteState::Fresh => true,
            RouteState::Known => self.actions > 0,
            RouteState::Unused | RouteState::Growing => false,
        };
        let due = self.others.iter_mut().filter(is_due);
        let Some(other) = due.min_by_key(|other| (other.state != RouteState::Fresh, other.left_at))
        else {
            return false;
        };
        std::mem::swap(&mut other.search, current);
        self.turn = Some(RouteChange {
            recovery: other.recovery,
            is_fresh: other.state == RouteState::Fresh,
        });
        self.turns += 1;
        (other.state, other.recovery, other.left_at) = (RouteState::Known, recovery, self.turns);
        self.actions = 0;
        true
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.others.iter().map(|other| size_of::<OtherRoute>() + other.search.bytes()).sum()
    }

    /// The index of the route that grows.
    fn growing(&self) -> Option<usize> {
        self.others.iter().position(|other| other.state == RouteState::Growing)
    }
}
