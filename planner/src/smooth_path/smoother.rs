//! Makes the smooth path of a plan: checks the phases, varies the stances around those that fail,
//! leaves the rest to the searched motion, and writes points and spans.

use surefoot_shared_types::message::Contact;

use crate::base::arena::reserve;
use crate::base::capacity::ArenaFull;
use crate::constraints::constraints::Constraints;
use crate::constraints::rejection::Rejection;
use crate::plan::chunk_builder::contact_of;
use crate::smooth_path::curve::Curve;
use crate::smooth_path::followed_motion::FollowedMotion;
use crate::smooth_path::key_table::KeySource;
pub use crate::smooth_path::layout::SearchedPlan;
use crate::smooth_path::layout::{Layout, swing_of};
use crate::smooth_path::phase_check::PhaseCheck;
use crate::smooth_path::phase_grid::{BEYOND, PhaseGrid};
use crate::smooth_path::phase_points::PhasePoints;
use crate::smooth_path::searched_motion::{self, SearchedPhase};
use crate::smooth_path::track::Track;
use crate::smooth_path::tuning::{JOIN_DIFFERENCE_MAX, KEY_SECONDS, REFINEMENTS_MAX};
use crate::smooth_path::variant::VARIANTS;
use crate::timing::path_point::{PathPoint, PathSpan};

/// What becomes of a phase.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PhaseState {
    /// It is to be checked.
    Open,
    /// Its part of the curve satisfies the constraints.
    Smooth,
    /// The spline along its searched motion is to be checked.
    OpenFollowed,
    /// It follows the spline along its searched motion, from rest to rest.
    Followed,
    /// It keeps the searched motion, which rests at its waypoints.
    Searched,
}

/// The next unit of work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Task {
    /// The keys of a stance.
    Keys {
        swing: usize,
    },
    /// The ends of a swing and the heights of its stance.
    Heights {
        swing: usize,
    },
    /// The check of the first open phase.
    Choose,
    /// The next configuration of the phase that is checked.
    Check {
        phase: usize,
    },
    /// The points of a phase; of a searched motion those from waypoint `next` on.
    Write {
        phase: usize,
        next: usize,
    },
    Over,
}

/// The inputs of a smooth path.
#[derive(Debug, Clone, Copy)]
pub struct SmoothingInputs<'a> {
    /// The constraints.
    pub constraints: &'a Constraints,
    /// The plan.
    pub plan: SearchedPlan<'a>,
    /// Largest share of its reach that a leg uses where the root is as high as the legs allow.
    pub leg_extension: f64,
}

/// Makes one smooth path. All memory is reserved at first.
#[derive(Debug)]
pub struct Smoother {
    layout: Layout,
    curve: Curve,
    states: Vec<PhaseState>,
    /// How often the intervals of each phase are halved.
    refinements: Vec<u8>,
    task: Task,
    check: PhaseCheck,
    followed: FollowedMotion,
    written: PhasePoints,
    points: Vec<PathPoint>,
    spans: Vec<PathSpan>,
}

impl Smoother {
    /// Reserves memory for plans of `edges_max` edges and paths of `points_max` points.
    pub fn new(edges_max: usize, points_max: usize) -> Self {
        Self {
            layout: Layout::new(edges_max),
            curve: Curve::new(edges_max),
            states: reserve(2 * edges_max + 1),
            refinements: reserve(2 * edges_max + 1),
            task: Task::Over,
            check: PhaseCheck::new(),
            followed: FollowedMotion::new(),
            written: PhasePoints::new(),
            points: reserve(points_max),
            spans: reserve(points_max / 2),
        }
    }

    /// The points of the path.
    pub fn points(&self) -> &[PathPoint] {
        &self.points
    }

    /// The spans of the path.
    pub fn spans(&self) -> &[PathSpan] {
        &self.spans
    }

    /// Number of phases that keep the searched motion, or follow it from rest to rest.
    pub fn searched_phases(&self) -> u64 {
        let phases = self.states.iter().enumerate();
        let is_searched = |&(phase, state): &(usize, &PhaseState)| {
            *state != PhaseState::Smooth && !self.layout.edges(phase).is_empty()
        };
        phases.filter(is_searched).count() as u64
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.layout.bytes()
            + self.curve.bytes()
            + self.points.capacity() * size_of::<PathPoint>()
            + self.spans.capacity() * size_of::<PathSpan>()
            + self.states.capacity()
            + self.refinements.capacity()
    }

    /// Begins with a plan.
    pub fn begin(&mut self, inputs: &SmoothingInputs<'_>) {
        self.layout.read(&inputs.plan);
        source(inputs, &self.layout).begin(&mut self.curve);
        self.states.clear();
        self.states.resize(self.layout.phases_len(), PhaseState::Open);
        self.refinements.clear();
        self.refinements.resize(self.layout.phases_len(), 0);
        for phase in 0..self.states.len() {
            if self.layout.edges(phase).is_empty() {
                self.states[phase] = PhaseState::Searched;
                for key in self.layout.end_keys(phase) {
                    self.curve.rests[key] = true;
                }
            }
        }
        self.points.clear();
        self.spans.clear();
        self.task = Task::Keys { swing: 0 };
    }

    /// Whether the path is complete.
    pub fn is_over(&self) -> bool {
        self.task == Task::Over
    }

    /// Spends one unit of work. Returns the rejection of the configuration that was checked, if it
    /// was rejected.
    ///
    /// # Errors
    /// The arena of points or spans is full.
    pub fn advance(
        &mut self,
        inputs: &SmoothingInputs<'_>,
    ) -> Result<Option<Rejection>, ArenaFull> {
        match self.task {
            Task::Keys { swing } if swing < self.layout.swings_len() => {
                source(inputs, &self.layout).make_stance(&mut self.curve, swing);
                self.task = Task::Keys { swing: swing + 1 };
            }
            Task::Keys { .. } => {
                let source = source(inputs, &self.layout);
                (0..self.layout.swings_len())
                    .for_each(|swing| source.find_swing(&mut self.curve, swing));
                self.task = Task::Heights { swing: 0 };
            }
            Task::Heights { swing } if swing < self.layout.swings_len() => {
                source(inputs, &self.layout).set_heights(&mut self.curve, swing);
                self.task = Task::Heights { swing: swing + 1 };
            }
            Task::Heights { .. } => self.task = Task::Choose,
            Task::Choose => self.choose(inputs),
            Task::Check { phase } => return Ok(self.check(inputs, phase)),
            Task::Write { phase, next } => self.write(inputs, phase, next)?,
            Task::Over => {}
        }
        Ok(None)
    }

    /// Leaves all phases to the searched motion.
    pub fn abandon(&mut self) {
        if matches!(self.task, Task::Write { .. } | Task::Over) {
            return;
        }
        self.states.fill(PhaseState::Searched);
        self.curve.rests.fill(true);
        self.task = Task::Write { phase: 0, next: 0 };
    }

    /// Begins with the check of the first open phase; without one, with the points.
    fn choose(&mut self, inputs: &SmoothingInputs<'_>) {
        let open = self
            .states
            .iter()
            .position(|state| matches!(state, PhaseState::Open | PhaseState::OpenFollowed));
        let Some(phase) = open else {
            self.points.clear();
            self.spans.clear();
            self.task = Task::Write { phase: 0, next: 0 };
            return;
        };
        match self.grid(inputs, phase) {
            Some(grid) => {
                self.check.begin(grid, self.rests_of(phase));
                self.task = Task::Check { phase };
            }
            None => self.reject(inputs, phase),
        }
    }

    /// The grid of a phase; `None` where it has no length.
    fn grid(&mut self, inputs: &SmoothingInputs<'_>, phase: usize) -> Option<PhaseGrid> {
        let refinements = self.refinements[phase];
        if matches!(self.states[phase], PhaseState::Open | PhaseState::Smooth) {
            return PhaseGrid::new(&source(inputs, &self.layout), &self.curve, phase, refinements);
        }
        let edges = self.layout.edges(phase);
        let mode = inputs.plan.roadmap.mode(inputs.plan.edge(edges.start));
        let stance = [0, 1].map(|limb| mode.is_stance(limb).then_some(mode.world_from_soles[limb]));
        let searched = SearchedPhase { plan: inputs.plan, edges };
        self.followed.begin(&inputs.constraints.robot, &searched, stance, refinements);
        (self.followed.end() > 0).then(|| PhaseGrid::followed(phase, self.followed.end()))
    }

    /// Whether the robot rests at the beginning and at the end of a phase.
    fn rests_of(&self, phase: usize) -> [bool; 2] {
        self.layout.end_keys(phase).map(|key| self.curve.rests[key])
    }

    /// A phase failed: its stances are varied, or it keeps more of the searched motion.
    fn reject(&mut self, inputs: &SmoothingInputs<'_>, phase: usize) {
        match self.states[phase] {
            PhaseState::Open => self.perturb(inputs, phase),
            _ => self.states[phase] = PhaseState::Searched,
        }
    }

    /// Halves the intervals of a phase where that may help: legs that are nearly straight bend so
    /// much between two points that stance soles drift, and a spline with more keys is nearer to
    /// the searched motion. Returns whether it did.
    fn refine(&mut self, phase: usize, rejection: Rejection) -> bool {
        let helps = match self.states[phase] {
            PhaseState::Open => rejection == Rejection::FootDrift,
            _ => true,
        };
        let does = helps && self.refinements[phase] < REFINEMENTS_MAX;
        self.refinements[phase] += u8::from(does);
        does
    }

    /// Checks the next configuration of a phase.
    fn check(&mut self, inputs: &SmoothingInputs<'_>, phase: usize) -> Option<Rejection> {
        let track = match self.states[phase] {
            PhaseState::Open => Track::Curve(&self.curve),
            _ => Track::Followed(&self.followed),
        };
        match self.check.advance(&source(inputs, &self.layout), track) {
            Ok(false) => None,
            Ok(true) => {
                self.states[phase] = match self.states[phase] {
                    PhaseState::Open => PhaseState::Smooth,
                    _ => PhaseState::Followed,
                };
                self.task = Task::Choose;
                None
            }
            Err(rejection) => {
                if !self.refine(phase, rejection) {
                    self.reject(inputs, phase);
                }
                self.task = Task::Choose;
                Some(rejection)
            }
        }
    }

    /// Gives a stance at a phase that failed its next variant; where there is none, the phase keeps
    /// the searched motion.
    fn perturb(&mut self, inputs: &SmoothingInputs<'_>, phase: usize) {
        let stances = match swing_of(phase) {
            Some(swing) => swing..swing + 1,
            None => (phase / 2).saturating_sub(1)..(phase / 2 + 1).min(self.layout.swings_len()),
        };
        let last = VARIANTS.len() as u8 - 1;
        let can_vary = |swing: &usize| {
            self.curve.variants[*swing] < last
                && matches!(self.states[2 * swing + 1], PhaseState::Open | PhaseState::Smooth)
        };
        let chosen = stances.filter(can_vary).min_by_key(|swing| self.curve.variants[*swing]);
        match chosen {
            None => self.keep_searched(inputs, phase),
            Some(swing) => {
                self.curve.variants[swing] += 1;
                self.remake(inputs, swing);
            }
        }
    }

    /// Leaves a phase to the searched motion: the robot rests at both ends.
    fn keep_searched(&mut self, inputs: &SmoothingInputs<'_>, phase: usize) {
        self.states[phase] = PhaseState::OpenFollowed;
        self.refinements[phase] = 0;
        for key in self.layout.end_keys(phase) {
            self.curve.rests[key] = true;
        }
        let first = (phase / 2).saturating_sub(1);
        for swing in first..(phase / 2 + 1).min(self.layout.swings_len()) {
            self.remake(inputs, swing);
        }
    }

    /// Makes the keys of a stance anew, and opens the phases that they change.
    fn remake(&mut self, inputs: &SmoothingInputs<'_>, swing: usize) {
        let source = source(inputs, &self.layout);
        source.make_stance(&mut self.curve, swing);
        for near in swing.saturating_sub(1)..(swing + 2).min(self.layout.swings_len()) {
            source.find_swing(&mut self.curve, near);
        }
        source.set_heights(&mut self.curve, swing);
        let phases = (2 * swing).saturating_sub(1)..(2 * swing + 4).min(self.states.len());
        for state in &mut self.states[phases] {
            if *state == PhaseState::Smooth {
                *state = PhaseState::Open;
            }
        }
    }

    /// Writes points of a phase.
    fn write(
        &mut self,
        inputs: &SmoothingInputs<'_>,
        phase: usize,
        next: usize,
    ) -> Result<(), ArenaFull> {
        if phase == self.states.len() {
            self.task = Task::Over;
            return Ok(());
        }
        if self.states[phase] == PhaseState::Searched {
            return self.write_searched(inputs, phase, next);
        }
        if next == 0
            && let Some(grid) = self.grid(inputs, phase)
        {
            self.written.begin(grid, self.rests_of(phase));
        }
        let track = match self.states[phase] {
            PhaseState::Smooth => Track::Curve(&self.curve),
            _ => Track::Followed(&self.followed),
        };
        let is_made = self.written.advance(&source(inputs, &self.layout), track).is_ok();
        if !is_made || !self.joins(phase) {
            match self.states[phase] {
                PhaseState::Smooth => self.keep_searched(inputs, phase),
                _ => self.states[phase] = PhaseState::Searched,
            }
            self.task = Task::Choose;
            return Ok(());
        }
        self.task = Task::Write { phase, next: next + 1 };
        if self.written.is_complete() {
            self.write_smooth(inputs, phase)?;
            self.task = Task::Write { phase: phase + 1, next: 0 };
        }
        Ok(())
    }

    /// Whether the first configuration of the phase is that of the phase before, whose legs may
    /// have bent another way.
    fn joins(&self, phase: usize) -> bool {
        let [first, _] = self.layout.end_keys(phase);
        let made = &self.written.configurations;
        if made.len() != BEYOND + 1 || self.curve.rests[first] {
            return true;
        }
        let joints = |last: &PathPoint| {
            let pairs = last.q.iter().zip(&made[BEYOND].q);
            pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        self.points.last().is_some_and(|last| joints(last) <= JOIN_DIFFERENCE_MAX)
    }

    /// Writes the points and the span of a phase of the curve.
    fn write_smooth(
        &mut self,
        inputs: &SmoothingInputs<'_>,
        phase: usize,
    ) -> Result<(), ArenaFull> {
        let [first, _] = self.layout.end_keys(phase);
        let starts_at_rest = self.curve.rests[first];
        let grid = self.written.grid;
        let begin = self.last_parameter();
        let skipped = usize::from(!starts_at_rest);
        let span_first = self.points.len() - skipped;
        for index in skipped..=grid.intervals {
            let parameter = begin + KEY_SECONDS * grid.step * index as f64;
            push(&mut self.points, self.written.point(BEYOND + index, parameter))?;
        }
        self.push_span(inputs, self.layout.edges(phase).start, span_first, starts_at_rest)
    }

    /// Writes the searched motion of a phase from waypoint `next` to the one after it.
    fn write_searched(
        &mut self,
        inputs: &SmoothingInputs<'_>,
        phase: usize,
        next: usize,
    ) -> Result<(), ArenaFull> {
        let searched = SearchedPhase { plan: inputs.plan, edges: self.layout.edges(phase) };
        let Some((edge, [from, to])) = searched.pair(next) else {
            self.task = Task::Write { phase: phase + 1, next: 0 };
            return Ok(());
        };
        self.task = Task::Write { phase, next: next + 1 };
        if from == to {
            return Ok(());
        }
        let first = self.points.len();
        for point in searched_motion::points(&from, &to, self.last_parameter()) {
            push(&mut self.points, point)?;
        }
        self.push_span(inputs, edge, first, true)
    }

    /// Appends the span of the points from `first` on, within the mode of an edge.
    fn push_span(
        &mut self,
        inputs: &SmoothingInputs<'_>,
        edge: usize,
        first: usize,
        starts_at_rest: bool,
    ) -> Result<(), ArenaFull> {
        let motion = inputs.plan.roadmap.mode_motion(inputs.plan.edge(edge));
        let Some(motion) = motion else { return Ok(()) };
        let mut contacts: heapless::Vec<Contact, 2> =
            motion.stance.iter().map(|foothold| contact_of(foothold)).collect();
        contacts.sort_unstable_by_key(|contact| contact.limb);
        let last = self.points.len() - 1;
        let span = PathSpan { first, last, starts_at_rest, support: motion.support, contacts };
        push(&mut self.spans, span)
    }

    fn last_parameter(&self) -> f64 {
        self.points.last().map_or(0.0, |last| last.parameter)
    }
}

/// What keys are made from.
fn source<'a>(inputs: &SmoothingInputs<'a>, layout: &'a Layout) -> KeySource<'a> {
    KeySource {
        constraints: inputs.constraints,
        plan: inputs.plan,
        layout,
        leg_extension: inputs.leg_extension,
    }
}

/// Appends to an arena.
fn push<T>(arena: &mut Vec<T>, item: T) -> Result<(), ArenaFull> {
    if arena.len() == arena.capacity() {
        return Err(ArenaFull::Waypoints);
    }
    arena.push(item);
    Ok(())
}
