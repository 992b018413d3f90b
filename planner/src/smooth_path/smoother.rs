//! Makes the smooth path of a plan: checks the phases in order, varies the stances around those
//! that fail, leaves the rest to the searched motion, and writes points and spans. What the next
//! phases cannot change any more is final, so that it can be timed while they are made.

use std::ops::Range;

use surefoot_shared_types::message::Contact;

use crate::base::arena::reserve;
use crate::base::capacity::ArenaFull;
use crate::constraints::constraints::Constraints;
use crate::constraints::rejection::Rejection;
use crate::plan::chunk_builder::contact_of;
use crate::smooth_path::curve::Curve;
use crate::smooth_path::followed_motion::FollowedMotion;
use crate::smooth_path::followed_trial::next_trial;
use crate::smooth_path::key_table::KeySource;
pub use crate::smooth_path::layout::SearchedPlan;
use crate::smooth_path::layout::{Layout, swing_of};
use crate::smooth_path::phase_check::PhaseCheck;
use crate::smooth_path::phase_grid::{BEYOND, PhaseGrid};
use crate::smooth_path::searched_motion::{self, SearchedPhase};
use crate::smooth_path::track::Track;
use crate::smooth_path::tuning::{JOIN_DIFFERENCE_MAX, KEY_SECONDS, OPEN_PHASES, REFINEMENTS_MAX};
use crate::smooth_path::variant::VARIANTS;
use crate::smooth_path::written_path::WrittenPath;
use crate::timing::path_point::{Path, PathPoint, PathSpan};

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
    Keys { swing: usize },
    /// The ends of a swing and the heights of its stance.
    Heights { swing: usize },
    /// The choice of the first phase that is not written.
    Choose,
    /// The next configuration of the phase that is checked.
    Check { phase: usize },
    /// The next configuration of a phase that was checked before a phase before it changed.
    Repeat { phase: usize },
    /// The points of a searched motion from waypoint `next` on.
    WriteSearched { phase: usize, next: usize },
    /// Nothing: a phase can only go on from final ones that would have to change.
    Blocked,
    /// Nothing: the path is complete.
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
    /// How often the intervals of each phase are halved, or which trial it is along a searched
    /// motion.
    refinements: Vec<u8>,
    /// The phase that failed last: it is checked again before those before it that changed.
    failed: Option<usize>,
    task: Task,
    check: Box<PhaseCheck>,
    followed: Box<FollowedMotion>,
    path: WrittenPath,
    /// Phases before the first one that is not written that may still change.
    open_phases: usize,
}

impl Smoother {
    /// Reserves memory for plans of `edges_max` edges and paths of `points_max` points.
    pub fn new(edges_max: usize, points_max: usize) -> Self {
        Self {
            layout: Layout::new(edges_max),
            curve: Curve::new(edges_max),
            states: reserve(2 * edges_max + 1),
            refinements: reserve(2 * edges_max + 1),
            failed: None,
            task: Task::Over,
            check: Box::new(PhaseCheck::new()),
            followed: Box::new(FollowedMotion::new()),
            path: WrittenPath::new(2 * edges_max + 1, points_max),
            open_phases: usize::MAX,
        }
    }

    /// The part of the path that does not change any more; once the path is complete all of it.
    pub fn path(&self) -> Path<'_> {
        self.path.final_part()
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
            + self.path.bytes()
            + self.states.capacity()
            + self.refinements.capacity()
    }

    /// Begins with a plan. If `in_parts`, the first phases are final before the last ones are made;
    /// only then the path may be blocked.
    pub fn begin(&mut self, inputs: &SmoothingInputs<'_>, in_parts: bool) {
        self.open_phases = if in_parts { OPEN_PHASES } else { usize::MAX };
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
        self.path.begin();
        self.failed = None;
        self.task = Task::Keys { swing: 0 };
    }

    /// Whether the path is complete.
    pub fn is_over(&self) -> bool {
        self.task == Task::Over
    }

    /// Whether no path continues the final part.
    pub fn is_blocked(&self) -> bool {
        self.task == Task::Blocked
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
            Task::Check { phase } => return self.check(inputs, phase),
            Task::Repeat { phase } => self.repeat(inputs, phase)?,
            Task::WriteSearched { phase, next } => self.write_searched(inputs, phase, next)?,
            Task::Blocked | Task::Over => {}
        }
        Ok(None)
    }

    /// Leaves all phases to the searched motion, unless some are final.
    pub fn abandon(&mut self) {
        if self.path.final_phases() > 0 || self.is_over() || self.is_searched() {
            return;
        }
        self.states.fill(PhaseState::Searched);
        self.curve.rests.fill(true);
        self.path.begin();
        self.failed = None;
        self.task = Task::Choose;
    }

    /// Whether all phases keep the searched motion.
    fn is_searched(&self) -> bool {
        self.states.iter().all(|state| *state == PhaseState::Searched)
    }

    /// Begins with the phase that failed last, if it is to be checked again, else with the first
    /// one that is not written: with its check, or with its points where it needs none.
    fn choose(&mut self, inputs: &SmoothingInputs<'_>) {
        let failed = self.failed.take().filter(|&phase| self.is_open(phase));
        let phase = failed.unwrap_or(self.path.phases());
        if phase == self.states.len() {
            self.path.finalize(phase);
            self.task = Task::Over;
            return;
        }
        if self.states[phase] == PhaseState::Searched {
            self.path.begin_phase();
            self.task = Task::WriteSearched { phase, next: 0 };
            return;
        }
        let is_open = self.is_open(phase);
        match self.grid(inputs, phase) {
            Some(grid) => {
                self.check.begin(grid, self.rests_of(phase));
                self.task = if is_open { Task::Check { phase } } else { Task::Repeat { phase } };
            }
            None if is_open => self.reject(inputs, phase),
            None => self.leave_unwritten(inputs, phase),
        }
    }

    /// Whether a phase is to be checked.
    fn is_open(&self, phase: usize) -> bool {
        matches!(self.states[phase], PhaseState::Open | PhaseState::OpenFollowed)
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
        let followed = &self.followed;
        (followed.end() > 0)
            .then(|| PhaseGrid::followed(phase, followed.end(), followed.intervals()))
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
    /// much between two points that stance soles drift. Along a searched motion the next kind of
    /// spline is tried. Returns whether there is one.
    fn refine(&mut self, phase: usize, rejection: Rejection) -> bool {
        let next = self.refinements[phase] + 1;
        let chosen = match self.states[phase] {
            PhaseState::Open => {
                Some(next).filter(|_| rejection == Rejection::FootDrift && next <= REFINEMENTS_MAX)
            }
            _ => next_trial(next, swing_of(phase).is_some()),
        };
        self.refinements[phase] = chosen.unwrap_or(self.refinements[phase]);
        chosen.is_some()
    }

    /// Checks the next configuration of a phase. Once all are checked, writes the phase if it is
    /// the next one.
    fn check(
        &mut self,
        inputs: &SmoothingInputs<'_>,
        phase: usize,
    ) -> Result<Option<Rejection>, ArenaFull> {
        let track = match self.states[phase] {
            PhaseState::Open => Track::Curve(&self.curve),
            _ => Track::Followed(&self.followed),
        };
        match self.check.advance(&source(inputs, &self.layout), track) {
            Ok(false) => Ok(None),
            Ok(true) => {
                self.states[phase] = match self.states[phase] {
                    PhaseState::Open => PhaseState::Smooth,
                    _ => PhaseState::Followed,
                };
                if phase == self.path.phases() {
                    return self.write(inputs, phase).map(|()| None);
                }
                self.task = Task::Choose;
                Ok(None)
            }
            Err(rejection) => {
                self.task = Task::Choose;
                self.failed = Some(phase);
                if !self.refine(phase, rejection) {
                    self.reject(inputs, phase);
                }
                Ok(Some(rejection))
            }
        }
    }

    /// Makes the next configuration of a phase that was checked, and writes the phase once it has
    /// all.
    fn repeat(&mut self, inputs: &SmoothingInputs<'_>, phase: usize) -> Result<(), ArenaFull> {
        let track = match self.states[phase] {
            PhaseState::Smooth => Track::Curve(&self.curve),
            _ => Track::Followed(&self.followed),
        };
        let points = &mut self.check.points;
        match points.advance(&source(inputs, &self.layout), track) {
            Ok(()) if points.is_complete() => self.write(inputs, phase),
            Ok(()) => Ok(()),
            Err(_) => {
                self.leave_unwritten(inputs, phase);
                Ok(())
            }
        }
    }

    /// Leaves a phase that is within the constraints but not continuous to the searched motion.
    fn leave_unwritten(&mut self, inputs: &SmoothingInputs<'_>, phase: usize) {
        self.task = Task::Choose;
        match self.states[phase] {
            PhaseState::Smooth => self.keep_searched(inputs, phase),
            _ => self.states[phase] = PhaseState::Searched,
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
                && self.may_change(*swing)
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

    /// Leaves a phase to the searched motion: the robot rests at both ends. Where that would change
    /// final phases, the path is blocked.
    fn keep_searched(&mut self, inputs: &SmoothingInputs<'_>, phase: usize) {
        let near = (phase / 2).saturating_sub(1)..(phase / 2 + 1).min(self.layout.swings_len());
        if !near.clone().all(|swing| self.may_change(swing)) {
            self.task = Task::Blocked;
            return;
        }
        self.states[phase] = PhaseState::OpenFollowed;
        self.refinements[phase] = next_trial(0, swing_of(phase).is_some()).unwrap_or(0);
        for key in self.layout.end_keys(phase) {
            self.curve.rests[key] = true;
        }
        near.for_each(|swing| self.remake(inputs, swing));
    }

    /// The first smooth phase that a change of a stance changes, with the phase before it: the
    /// derivatives at the end of that one are differences across it.
    fn first_changed(&self, swing: usize) -> Option<usize> {
        let mut phases = phases_around(swing, self.states.len());
        let changed = phases.find(|phase| self.states[*phase] == PhaseState::Smooth)?;
        let before = changed.saturating_sub(1);
        Some(if self.states[before] == PhaseState::Smooth { before } else { changed })
    }

    /// Whether a stance may change: it changes no final phase.
    fn may_change(&self, swing: usize) -> bool {
        self.first_changed(swing).is_none_or(|phase| phase >= self.path.final_phases())
    }

    /// Makes the keys of a stance anew, and opens the phases that they change.
    fn remake(&mut self, inputs: &SmoothingInputs<'_>, swing: usize) {
        let source = source(inputs, &self.layout);
        source.make_stance(&mut self.curve, swing);
        for near in swing.saturating_sub(1)..(swing + 2).min(self.layout.swings_len()) {
            source.find_swing(&mut self.curve, near);
        }
        source.set_heights(&mut self.curve, swing);
        if let Some(phase) = self.first_changed(swing) {
            self.path.withdraw(phase);
        }
        for phase in phases_around(swing, self.states.len()) {
            if self.states[phase] == PhaseState::Smooth {
                self.states[phase] = PhaseState::Open;
            }
        }
    }

    /// Whether the first configuration of the phase is that of the phase before, whose legs may
    /// have bent another way.
    fn joins(&self, phase: usize) -> bool {
        let [first, _] = self.layout.end_keys(phase);
        let made = &self.check.points.configurations;
        if self.curve.rests[first] {
            return true;
        }
        let joints = |last: &PathPoint| {
            let pairs = last.q.iter().zip(&made[BEYOND].q);
            pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        self.path.last().is_some_and(|last| joints(last) <= JOIN_DIFFERENCE_MAX)
    }

    /// Writes the points and the span of a phase whose configurations are made.
    fn write(&mut self, inputs: &SmoothingInputs<'_>, phase: usize) -> Result<(), ArenaFull> {
        if !self.joins(phase) {
            self.leave_unwritten(inputs, phase);
            return Ok(());
        }
        let [first, _] = self.layout.end_keys(phase);
        let starts_at_rest = self.curve.rests[first];
        let Self { path, check, .. } = self;
        let grid = check.points.grid;
        path.begin_phase();
        let begin = path.last_parameter();
        let skipped = usize::from(!starts_at_rest);
        let span_first = path.points_len() - skipped;
        for index in skipped..=grid.intervals {
            let parameter = begin + KEY_SECONDS * grid.step * index as f64;
            path.push_point(check.points.point(BEYOND + index, parameter))?;
        }
        let edge = self.layout.edges(phase).start;
        self.push_span(inputs, edge, span_first, starts_at_rest)?;
        self.end_phase();
        Ok(())
    }

    /// Goes on after a phase that is written, and finalizes those that the next ones cannot change.
    fn end_phase(&mut self) {
        self.path.finalize(self.path.phases().saturating_sub(self.open_phases));
        self.task = Task::Choose;
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
            self.end_phase();
            return Ok(());
        };
        self.task = Task::WriteSearched { phase, next: next + 1 };
        if from == to {
            return Ok(());
        }
        let first = self.path.points_len();
        for point in searched_motion::points(&from, &to, self.path.last_parameter()) {
            self.path.push_point(point)?;
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
        let last = self.path.points_len() - 1;
        let support = motion.support;
        let grounds = inputs.plan.roadmap.grounds(inputs.plan.edge(edge));
        self.path.push_span(PathSpan { first, last, starts_at_rest, support, contacts, grounds })
    }
}

/// The phases of a path of `len` phases whose curve a stance changes.
fn phases_around(swing: usize, len: usize) -> Range<usize> {
    (2 * swing).saturating_sub(1)..(2 * swing + 4).min(len)
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
