//! Improves a plan: makes other walks from it, smooths and times them, and keeps the one that takes
//! the least time.
//!
//! Most of a walk does not change with a foothold. So a window of a few steps is chosen, its walk
//! is smoothed and timed from rest to rest, and so are other walks between the same ends. A
//! faster one goes into a draft. Now and then all of the draft is smoothed and timed; it becomes
//! the best plan where it takes less time.

use crate::base::arena::reserve;
use crate::base::capacity::ArenaFull;
use crate::base::random::{Random, Stream};
use crate::motion::ids::TransitionId;
use crate::motion::roadmap::RouteSegment;
use crate::pipeline::chunk_stage::ChunkStage;
use crate::pipeline::improvement::Improvement;
use crate::pipeline::improvement_walk::Walk;
use crate::pipeline::improvement_window::{Places, Window};
use crate::pipeline::outcome::Outcome;
use crate::pipeline::search::Search;
use crate::pipeline::stage::{Event, WorkCategory};
use crate::pipeline::trial_motion::{Trial, TrialMotion};
use crate::preparation::planning_context::PlanningContext;
use crate::smooth_path::smoother::{SearchedPlan, SmoothingInputs};

/// Walks that are tried in one window.
const TRIES: u32 = 8;
/// One of so many windows leaves out steps.
const FEWER_EVERY: usize = 8;
/// Smallest gain in a window, s.
const GAIN_MIN: f64 = 0.01;
/// Work that is left for a whole walk, relative to the most that one has taken.
const RESERVE: f64 = 1.05;
/// Work in windows between two whole walks, relative to all of the improvement so far.
const WINDOWS_SHARE: f64 = 0.5;

/// What the stage does next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Task {
    /// Take the first plan.
    Begin,
    /// Choose a window.
    Choose,
    /// Smooth and time the draft in the window, or the walk that is tried.
    Measure { is_tried: bool },
    /// Make another walk.
    Propose,
    /// Sample configurations of its transitions, from `next` on.
    Sample { next: usize },
    /// Plan motions along its edges, from `next` on.
    Move { next: usize },
    /// Compare the duration of the draft with that of the best plan.
    Compare,
}

/// Makes other walks, one in each round. A round's random numbers depend on the seed and its number
/// alone. One unit of work for each round; searches, smoothing and timing count as elsewhere.
#[derive(Debug)]
pub(crate) struct ImprovementStage {
    /// Work units to spend; 0 leaves plans as they are.
    wanted: u64,
    task: Task,
    walks: Walks,
    window: Window,
    /// Number of steps that were tried without, in order.
    swept: usize,
    /// How long each step of the best plan takes.
    places: Places,
    /// The motion in the window; none where plans keep the searched motion.
    trial: Option<TrialMotion>,
    /// Most work that the smoothing and timing of one walk took.
    walk_work: u64,
    /// Work when the last one began or ended.
    since: u64,
    improvement: Option<Improvement>,
}

/// The walks that are compared.
#[derive(Debug)]
struct Walks {
    /// The best plan.
    best: Walk,
    /// The best plan with faster walks in windows.
    draft: Walk,
    /// The walk that is tried.
    tried: Walk,
}

impl ImprovementStage {
    /// Reserves memory for plans of `edges_max` edges, if work is wanted.
    pub fn new(wanted: u64, edges_max: usize, trial: Option<TrialMotion>) -> Self {
        let edges_max = if wanted > 0 { edges_max } else { 0 };
        let walk = || Walk { nodes: reserve(edges_max + 1) };
        Self {
            wanted,
            task: Task::Begin,
            walks: Walks { best: walk(), draft: walk(), tried: walk() },
            window: Window::about((0, false), std::iter::empty(), 1),
            swept: 0,
            places: Places::new(edges_max),
            trial,
            walk_work: 0,
            since: 0,
            improvement: None,
        }
    }

    /// Whether plans are to be improved.
    pub fn is_wanted(&self) -> bool {
        self.wanted > 0
    }

    /// What the improvement came to so far; `None` before it begins.
    pub fn improvement(&self) -> Option<Improvement> {
        self.improvement
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        let Walks { best, draft, tried } = &self.walks;
        let nodes = [best, draft, tried].map(|walk| walk.nodes.capacity());
        let trial = self.trial.as_ref().map_or(0, TrialMotion::bytes);
        nodes.iter().sum::<usize>() * size_of::<TransitionId>() + self.places.bytes() + trial
    }

    /// Advances by one piece of work.
    ///
    /// # Errors
    /// An arena is full.
    pub fn step(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        chunks: &mut ChunkStage,
        budget: u64,
    ) -> Result<Event, ArenaFull> {
        match self.task {
            Task::Begin => self.begin(search, chunks),
            Task::Choose => return Ok(self.choose(context, search, chunks)),
            Task::Measure { is_tried } => self.measure(context, search, is_tried, budget),
            Task::Propose => self.propose(context, search)?,
            Task::Sample { next } => self.sample(context, search, next, budget)?,
            Task::Move { next } => self.plan_motions(context, search, next, budget)?,
            Task::Compare => self.compare(search, chunks),
        }
        Ok(Event::Continue)
    }

    /// Takes the first plan. From here on the limit of the work ends the improvement.
    fn begin(&mut self, search: &mut Search, chunks: &mut ChunkStage) {
        chunks.keep(&search.stats);
        self.walks.best.take(search.segmentation.plan());
        self.walks.draft.copy(&self.walks.best);
        self.places.measure(chunks.kept_chunks());
        search.limits.work_max =
            search.limits.work_max.min(search.stats.work.saturating_add(self.wanted));
        let seconds = chunks.kept_seconds();
        self.improvement = Some(Improvement {
            first_work: search.stats.work,
            first_seconds: seconds,
            seconds,
            ..Improvement::default()
        });
        let of = |category: WorkCategory| search.stats.work_by_category[category as usize];
        self.walk_work = of(WorkCategory::Shortcuts) + of(WorkCategory::Chunks);
        self.since = search.stats.work;
        self.task = Task::Choose;
    }

    /// Ends with the best plan.
    pub fn end(&mut self, search: &mut Search, chunks: &mut ChunkStage) {
        let Some(improvement) = &mut self.improvement else { return };
        improvement.work = search.stats.work - improvement.first_work;
        chunks.take_kept(&mut search.stats);
        search.segmentation.set_plan(&self.walks.best.nodes);
        search.outcome = Some(Outcome::Found);
    }

    /// Chooses the next window, or lets the draft be smoothed and timed: after enough windows, or
    /// where no more work is left than that takes.
    fn choose(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        chunks: &mut ChunkStage,
    ) -> Event {
        search.stats.work += 1;
        let is_last = self.has_left_only_a_walk(search);
        let Walks { best, draft, .. } = &self.walks;
        if draft.nodes != best.nodes {
            if is_last || self.has_tried_enough(search) {
                search.segmentation.set_plan(&draft.nodes);
                chunks.begin_another();
                self.since = search.stats.work;
                self.task = Task::Compare;
                return Event::NewWalk;
            }
        } else if is_last {
            self.end(search, chunks);
            return Event::Found;
        }
        let name = self.improvement.map_or(0, |improvement| improvement.rounds);
        let mut random = Random::new(context.seed, Stream::Improvement, name, 1);
        let swings = draft.swings(&search.roadmap);
        let steps = swings.clone().count();
        let place = if self.swept < steps {
            self.swept += 1;
            (self.swept - 1, true)
        } else {
            (self.places.choose(steps, &mut random), random.below(FEWER_EVERY) == 0)
        };
        self.window = Window::about(place, swings, draft.nodes.len());
        self.task = Task::Propose;
        Event::Continue
    }

    /// Whether the windows since the last whole walk have taken as much work as that, and their
    /// share of all.
    fn has_tried_enough(&self, search: &Search) -> bool {
        let first = self.improvement.map_or(0, |improvement| improvement.first_work);
        let all = (search.stats.work - first) as f64;
        let tried = search.stats.work - self.since;
        tried >= self.walk_work && tried as f64 >= WINDOWS_SHARE * all || self.trial.is_none()
    }

    /// Whether no more work is left than one walk and one window may take.
    fn has_left_only_a_walk(&self, search: &Search) -> bool {
        let left = search.limits.work_max.saturating_sub(search.stats.work);
        left < (RESERVE * self.walk_work as f64) as u64
    }

    /// Smooths and times the walk in the window. A faster one goes into the draft.
    fn measure(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        is_tried: bool,
        budget: u64,
    ) {
        let Walks { draft, tried, .. } = &mut self.walks;
        let Some(trial) = &mut self.trial else { return };
        let walk = if is_tried { &*tried } else { &*draft };
        let inputs = SmoothingInputs {
            constraints: &context.constraints,
            plan: SearchedPlan { roadmap: &search.roadmap, nodes: self.window.of(draft, walk) },
            leg_extension: context.preparation.gait().leg_extension,
        };
        let (spent, result) = trial.advance(&inputs, &self.window.known(GAIN_MIN), budget);
        search.stats.work += spent;
        match result {
            Trial::Running => return,
            Trial::Rejected => {}
            Trial::Better(facts) => {
                self.window.take(facts, tried.nodes.len(), draft.nodes.len(), is_tried);
                if is_tried {
                    std::mem::swap(draft, tried);
                }
            }
        }
        self.window.is_measured = true;
        self.task = if is_tried { Task::Propose } else { Task::Measure { is_tried: true } };
    }

    /// Makes the walk of the next round.
    fn propose(&mut self, context: &PlanningContext, search: &mut Search) -> Result<(), ArenaFull> {
        search.stats.work += 1;
        let is_last = self.has_left_only_a_walk(search);
        let Some(improvement) = &mut self.improvement else { return Ok(()) };
        let tries = if self.window.has_fewer { 1 } else { TRIES };
        if self.window.tries >= tries || is_last {
            self.places.leave(&self.window);
            self.task = Task::Choose;
            return Ok(());
        }
        self.window.tries += 1;
        improvement.rounds += 1;
        let mut random = Random::new(context.seed, Stream::Improvement, improvement.rounds, 0);
        let Walks { draft, tried, .. } = &mut self.walks;
        tried.copy(draft);
        let swing = self.window.swing();
        let may_be = if self.window.has_fewer {
            tried.leave_out_steps(context, search, swing)?
        } else {
            tried.move_foothold(context, search, swing, &mut random)?
        };
        if may_be && self.window.has_the_ends_of(draft, tried) {
            self.task = Task::Sample { next: 0 };
        }
        Ok(())
    }

    /// Samples the missing configurations of the walk.
    fn sample(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        mut next: usize,
        budget: u64,
    ) -> Result<(), ArenaFull> {
        let tried = &self.walks.tried;
        if !search.batch.is_running() {
            search.batch.begin();
            next = search.batch.add_sampling(0, &search.roadmap, segment(tried), next);
            self.task = Task::Sample { next };
        }
        let Some(batch) = search.advance_batch(context, budget)? else { return Ok(()) };
        self.task = match () {
            () if batch.failures[0] > 0 => Task::Propose,
            () if next == tried.nodes.len() - 2 => Task::Move { next: 0 },
            () => Task::Sample { next },
        };
        Ok(())
    }

    /// Plans the missing motions of the walk.
    fn plan_motions(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        mut next: usize,
        budget: u64,
    ) -> Result<(), ArenaFull> {
        let Walks { draft, tried, .. } = &mut self.walks;
        if !search.batch.is_running() {
            search.batch.begin();
            let Search { batch, roadmap, .. } = search;
            next = batch.add_motions(0, context, roadmap, segment(tried), next);
            self.task = Task::Move { next };
        }
        let Some(batch) = search.advance_batch(context, budget)? else { return Ok(()) };
        if batch.failures[0] > 0 {
            self.task = Task::Propose;
        } else if next == tried.nodes.len() - 1 {
            self.task = if self.trial.is_some() {
                Task::Measure { is_tried: self.window.is_measured }
            } else {
                draft.copy(tried);
                Task::Choose
            };
        }
        Ok(())
    }

    /// Keeps the draft if it takes less time than the best plan; else forgets it.
    fn compare(&mut self, search: &mut Search, chunks: &mut ChunkStage) {
        self.walk_work = self.walk_work.max(search.stats.work - self.since);
        self.since = search.stats.work;
        self.task = Task::Choose;
        let Some(improvement) = &mut self.improvement else { return };
        let Walks { best, draft, .. } = &mut self.walks;
        if chunks.seconds() < improvement.seconds {
            improvement.kept += 1;
            improvement.seconds = chunks.seconds();
            chunks.keep(&search.stats);
            best.copy(draft);
            self.places.measure(chunks.kept_chunks());
        } else {
            draft.copy(best);
        }
    }
}

/// A walk as one segment.
fn segment(walk: &Walk) -> RouteSegment<'_> {
    let last = walk.nodes.len() - 1;
    RouteSegment { sequence: &walk.nodes[1..last], ends: [walk.nodes[0], walk.nodes[last]] }
}
