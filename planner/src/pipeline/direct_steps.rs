//! The fewest steps straight to a near goal: turns on the spot, steps sideways and backward, and
//! everything between.
//!
//! The mid-feet pose is interpolated from the start to the goal, heading included. Candidates for
//! both feet lie at every interpolated pose. A step lands one foot while the other one stands, and
//! what it costs depends on these two placements alone. So a walk is a path through placements of
//! alternating feet, and Dijkstra's algorithm finds the cheapest. Only the placements and the steps
//! of a path that was found are tested, against the ground and by inverse kinematics; those that
//! fail are excluded, and the next path is searched.

use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::yaw_of;

use crate::base::arena::{filled, reserve};
use crate::motion::ids::FootholdId;
use crate::preparation::step_limits::StepLimits;

/// Most placements of both feet.
pub(crate) const PLACEMENTS_MAX: usize = 416;
/// Cost of a step in addition to its effort, m^3: a long step costs less than two short ones.
const STEP_BASE: f64 = 0.4;

/// A candidate for a placement of one foot.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StepPlacement {
    /// The foot.
    pub limb: usize,
    /// Pose of its sole in the world.
    pub world_from_sole: Pose,
    /// The vertex of the route at which it lies.
    pub vertex: usize,
    /// Its foothold, once it has been tested and added.
    pub foothold: Option<FootholdId>,
    /// Whether the ground does not support it.
    pub is_rejected: bool,
}

/// Attempts that count for a step near the step limits.
const DOUBTFUL_ATTEMPTS: f32 = 30.0;
/// Growth of their expected effort with each path that failed a test.
const DOUBT_GROWTH: f32 = 0.2;
/// Effort of a step up to which no other path is searched, m^3: about the cost of a step.
const ACCEPTABLE_EFFORT: f32 = 0.5;
/// Effort of a step like one that failed a test, m^3.
const REJECTED_ALIKE: f32 = 20.0;
/// Steps between rounded offsets of two placements, m and rad.
const OFFSET_STEP: f64 = 0.02;
const TURN_STEP: f64 = 0.06;
/// Most offsets whose effort is known.
const KNOWN_MAX: usize = 2_048;
/// The cost of a step that is beyond the step limits, or failed a test.
const REJECTED: f32 = f32::INFINITY;

/// A step that was not looked at.
const UNKNOWN: StepCost = StepCost { effort: -1.0, is_tested: false, is_doubtful: false };

/// The knowledge about the step between two placements.
#[derive(Debug, Clone, Copy, PartialEq)]
struct StepCost {
    /// S(T) D^3(T) of both transitions, m^3; negative before the first look at it.
    effort: f32,
    /// Whether it was tested.
    is_tested: bool,
    /// Whether it lies near the step limits.
    is_doubtful: bool,
}

/// The tests of a path, and of those before it.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PathTests {
    /// The next test: of its placements, then of its steps; none while it is searched.
    pub next: Option<usize>,
    /// Whether a test failed.
    pub has_failed: bool,
    /// Number of paths that failed a test.
    pub failed_paths: u32,
}

/// The placements of both feet about the straight way to a near goal, and the steps between them,
/// allocated once.
#[derive(Debug)]
pub(crate) struct DirectSteps {
    /// The placements: left and right at the start, left and right at the goal, then others.
    pub placements: Vec<StepPlacement>,
    /// The knowledge about the step between each two of them.
    steps: Vec<StepCost>,
    costs: Vec<f64>,
    before: Vec<u16>,
    is_expanded: Vec<bool>,
    /// The placements of the path found last: the foot that stands at first, then those that land.
    pub path: Vec<usize>,
    /// Whether direct steps were tried, or are being tried.
    pub is_tried: bool,
    /// Whether the current sequence is one of direct steps.
    pub is_active: bool,
    /// Whether the placements are those of turns on the spot, and of walks without a turn.
    pub is_separate: bool,
    /// Whether a path is being searched.
    is_searching: bool,
    /// The tests of the path.
    pub tests: PathTests,
    known: KnownEfforts,
}

/// Indices of the placements at the start and at the goal, left and right.
pub(crate) const AT_START: [usize; 2] = [0, 1];
pub(crate) const AT_GOAL: [usize; 2] = [2, 3];

/// S(T) D^3(T) of both transitions between two soles at the first attempt, m^3.
fn cubed_length([left, right]: [&Pose; 2]) -> f32 {
    let length = left.translation.distance(right.translation);
    (2.0 * length * length * length) as f32
}

/// The expected effort of a step by the step limits, m^3, infinite beyond them; and whether it lies
/// near them.
fn expected_effort(limits: &StepLimits, soles: [&Pose; 2]) -> (f32, bool) {
    let [left, right] = soles;
    let is_inside = limits.is_inside(0, left, right) && limits.is_inside(1, right, left);
    match () {
        () if is_inside => (cubed_length(soles), false),
        () if limits.may_step(soles) => (DOUBTFUL_ATTEMPTS * cubed_length(soles), true),
        () => (REJECTED, false),
    }
}

/// The efforts of steps that were tested, by their rounded offset.
#[derive(Debug)]
struct KnownEfforts {
    sorted: Vec<(u32, f32)>,
}

impl KnownEfforts {
    /// The effort at an offset, or 0 if none is known.
    fn get(&self, offset: u32) -> f32 {
        let found = self.sorted.binary_search_by_key(&offset, |known| known.0);
        found.map_or(0.0, |index| self.sorted[index].1)
    }

    /// Records an effort, the least of several at one offset.
    fn record(&mut self, offset: u32, effort: f32) {
        match self.sorted.binary_search_by_key(&offset, |known| known.0) {
            Ok(index) => self.sorted[index].1 = self.sorted[index].1.min(effort),
            Err(_) if self.sorted.len() == self.sorted.capacity() => {}
            Err(index) => self.sorted.insert(index, (offset, effort)),
        }
    }
}

/// The index of the step between two placements.
fn index_of(a: usize, b: usize) -> usize {
    a.min(b) * PLACEMENTS_MAX + a.max(b)
}

impl DirectSteps {
    /// No placement, with reserved memory. Allocates.
    pub fn new() -> Self {
        Self {
            placements: reserve(PLACEMENTS_MAX),
            steps: filled(UNKNOWN, PLACEMENTS_MAX * PLACEMENTS_MAX),
            costs: filled(f64::INFINITY, PLACEMENTS_MAX),
            before: filled(0, PLACEMENTS_MAX),
            is_expanded: filled(false, PLACEMENTS_MAX),
            path: reserve(PLACEMENTS_MAX),
            is_tried: false,
            is_active: false,
            is_separate: false,
            is_searching: false,
            tests: PathTests::default(),
            known: KnownEfforts { sorted: reserve(KNOWN_MAX) },
        }
    }

    /// Adds a candidate, unless the arena is full.
    pub fn add(&mut self, placement: StepPlacement) {
        if self.placements.len() < PLACEMENTS_MAX {
            self.placements.push(placement);
        }
    }

    /// Begins again with other placements. Known efforts of offsets between placements stay.
    pub fn begin_separate(&mut self) {
        self.placements.clear();
        self.steps.fill(UNKNOWN);
        (self.is_separate, self.is_searching) = (true, false);
        self.tests = PathTests::default();
    }

    /// The placements of a step of the path.
    pub fn step(&self, index: usize) -> [usize; 2] {
        [self.path[index], self.path[index + 1]]
    }

    /// Whether a step was tested.
    pub fn is_tested(&self, a: usize, b: usize) -> bool {
        self.steps[index_of(a, b)].is_tested
    }

    /// Records the effort of a step that was tested: S(T) D^3(T) of both transitions, m^3. Returns
    /// whether it is acceptable, or no more than was expected.
    pub fn record(&mut self, a: usize, b: usize, effort: f64) -> bool {
        let (effort, expected) = (effort as f32, self.effort_so_far(a, b));
        self.steps[index_of(a, b)] = StepCost { effort, is_tested: true, is_doubtful: false };
        self.known.record(self.offset_key(a, b), effort);
        effort <= expected.max(ACCEPTABLE_EFFORT)
    }

    /// Excludes a step.
    pub fn reject(&mut self, a: usize, b: usize) {
        self.known.record(self.offset_key(a, b), REJECTED_ALIKE);
        self.steps[index_of(a, b)] =
            StepCost { effort: REJECTED, is_tested: true, is_doubtful: false };
    }

    /// Advances the search for the cheapest path from the start to the goal by one placement.
    /// Returns whether there is a path, once the search has ended.
    pub fn advance(
        &mut self,
        limits: &StepLimits,
        do_collide: impl Fn([&Pose; 2]) -> bool,
    ) -> Option<bool> {
        if !std::mem::replace(&mut self.is_searching, true) {
            self.begin();
        }
        if let Some(at) = self.cheapest() {
            self.is_expanded[at] = true;
            if !AT_GOAL.iter().all(|&goal| self.is_expanded[goal]) {
                self.expand(at, limits, do_collide);
                return None;
            }
        }
        self.is_searching = false;
        Some(self.trace())
    }

    /// Reaches both placements of the start, and those of the goal that are the same.
    fn begin(&mut self) {
        let count = self.placements.len();
        self.costs[..count].fill(f64::INFINITY);
        self.is_expanded[..count].fill(false);
        for limb in [0, 1] {
            let [start, goal] = [AT_START[limb], AT_GOAL[limb]];
            (self.costs[start], self.before[start]) = (0.0, start as u16);
            if self.placements[start].foothold == self.placements[goal].foothold {
                (self.costs[goal], self.before[goal]) = (0.0, goal as u16);
            }
        }
    }

    /// The placement that is reached at the lowest cost and not yet expanded.
    fn cheapest(&self) -> Option<usize> {
        let open = |index: &usize| !self.is_expanded[*index] && self.costs[*index].is_finite();
        (0..self.placements.len())
            .filter(open)
            .min_by(|&a, &b| self.costs[a].total_cmp(&self.costs[b]))
    }

    /// Follows all steps that land the other foot.
    fn expand(&mut self, at: usize, limits: &StepLimits, do_collide: impl Fn([&Pose; 2]) -> bool) {
        for next in 0..self.placements.len() {
            if self.costs[at] + STEP_BASE < self.costs[next] {
                let cost = self.costs[at]
                    + STEP_BASE
                    + f64::from(self.effort(at, next, limits, &do_collide));
                if cost < self.costs[next] {
                    (self.costs[next], self.before[next]) = (cost, at as u16);
                }
            }
        }
    }

    /// The effort of a step as far as is known; infinite where there is none.
    fn effort(
        &mut self,
        a: usize,
        b: usize,
        limits: &StepLimits,
        do_collide: impl Fn([&Pose; 2]) -> bool,
    ) -> f32 {
        let [first, second] = [&self.placements[a], &self.placements[b]];
        if first.limb == second.limb || first.is_rejected || second.is_rejected {
            return REJECTED;
        }
        let step = &mut self.steps[index_of(a, b)];
        if *step == UNKNOWN {
            let soles = if first.limb == 0 { [first, second] } else { [second, first] }
                .map(|placement| &placement.world_from_sole);
            // The robot stands at the goal, so the last step lands there however long it is.
            let is_goal = AT_GOAL.contains(&a) && AT_GOAL.contains(&b);
            step.effort = if is_goal {
                cubed_length(soles)
            } else {
                let (effort, is_doubtful) = expected_effort(limits, soles);
                step.is_doubtful = is_doubtful;
                let is_free = effort < REJECTED && !do_collide(soles);
                if is_free { effort } else { REJECTED }
            };
        }
        self.effort_so_far(a, b)
    }

    /// The effort of a step that was looked at; what was found on other placements with nearly the
    /// same offset holds for it, too.
    fn effort_so_far(&self, a: usize, b: usize) -> f32 {
        let StepCost { effort, is_tested, is_doubtful } = self.steps[index_of(a, b)];
        if is_tested || effort == REJECTED {
            return effort;
        }
        // The more paths have failed, the less a doubtful step is worth a test.
        let doubt =
            if is_doubtful { 1.0 + DOUBT_GROWTH * self.tests.failed_paths as f32 } else { 1.0 };
        (doubt * effort).max(self.known.get(self.offset_key(a, b)))
    }

    /// The offset between two placements of different feet, rounded.
    fn offset_key(&self, a: usize, b: usize) -> u32 {
        let pair = if self.placements[a].limb == 0 { [a, b] } else { [b, a] };
        let [left, right] = pair.map(|index| &self.placements[index].world_from_sole);
        let left_from_right = left.inverse() * *right;
        let rounded = |value: f64, step: f64| (libm::round(value / step) as i32 + 512) as u32;
        let [x, y, _] = left_from_right.translation.to_array();
        rounded(x, OFFSET_STEP) << 20
            | rounded(y, OFFSET_STEP) << 10
            | rounded(yaw_of(left_from_right.rotation), TURN_STEP)
    }

    /// Writes the path whose last two placements are those of the goal.
    fn trace(&mut self) -> bool {
        let [left, right] = AT_GOAL;
        let last = [(left, right), (right, left)].into_iter().filter(|&(stands, lands)| {
            self.costs[stands].is_finite() && self.steps[index_of(stands, lands)].effort != REJECTED
        });
        let Some((stands, lands)) = last.min_by(|a, b| self.costs[a.0].total_cmp(&self.costs[b.0]))
        else {
            return false;
        };
        self.path.clear();
        self.path.extend([lands, stands]);
        let mut at = stands;
        while self.before[at] as usize != at && self.path.len() < PLACEMENTS_MAX {
            at = self.before[at] as usize;
            self.path.push(at);
        }
        self.path.reverse();
        true
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.placements.capacity() * size_of::<StepPlacement>()
            + self.steps.capacity() * size_of::<StepCost>()
            + self.costs.capacity() * size_of::<f64>()
            + self.before.capacity() * size_of::<u16>()
            + self.is_expanded.capacity()
            + self.path.capacity() * size_of::<usize>()
            + self.known.sorted.capacity() * size_of::<(u32, f32)>()
    }
}
