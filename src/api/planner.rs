//! The planner: finds walks of one robot in one world.

use std::num::NonZeroUsize;

pub use surefoot_planner::pipeline::{Improvement, SearchStats, SearchTrace};
use surefoot_planner::{Outcome, Planner as Search, Status};
use surefoot_shared_types::Pose as SpatialPose;
use surefoot_shared_types::config::builder::ScenarioError;
use surefoot_shared_types::config::scenario::Scenario;
use surefoot_shared_types::message::{CorrectionKind, PlanChunk, RestState, WorldCorrection};
use surefoot_shared_types::plan_file::write::ends_of;

use crate::api::error::{BuildError, PlanError, ReplanError, StartError};
use crate::api::event::Event;
use crate::api::parameters::Parameters;
use crate::api::plan::{Plan, State};
use crate::api::plan_inputs::PlanInputs;
use crate::api::prepared::Prepared;
use crate::api::stance::{Goal, Stance, content};
use crate::api::world::World;

/// Work units of each step of [`Planner::plan`]: few enough that the loop costs nothing.
const WORK_PER_STEP: u64 = 1 << 20;
/// Plan id of the chunks: a planner plans one walk at a time; [`Publisher`](crate::Publisher) names
/// the session.
const PLAN_ID: u64 = 1;

/// Collects the settings of a planner. [`PlannerBuilder::build`] validates them.
#[derive(Debug, Clone)]
pub struct PlannerBuilder {
    prepared: Prepared,
    world: World,
    parameters: Parameters,
    threads: usize,
    work_max: Option<u64>,
    improve: u64,
    seed: u64,
}

impl PlannerBuilder {
    /// Number of threads that share the work, 1 by default; the thread that plans is one of them.
    /// At most one for each core that the process may use. It has no influence on the plan.
    #[must_use]
    pub fn threads(self, threads: usize) -> Self {
        Self { threads, ..self }
    }

    /// Limit of the work of one search, in work units of about ten microseconds; by default
    /// `parameters.planner.work_max`.
    #[must_use]
    pub fn work_max(self, work_max: u64) -> Self {
        Self { work_max: Some(work_max), ..self }
    }

    /// Improves each plan with at most this many work units, 0 by default: other walks are made
    /// from it, and the one that takes the least time is the plan. The work counts for
    /// [`PlannerBuilder::work_max`], too.
    #[must_use]
    pub fn improve(self, work: u64) -> Self {
        Self { improve: work, ..self }
    }

    /// Seed of all random streams, 1 by default. The same seed and inputs give the same plan.
    #[must_use]
    pub fn seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }

    /// Sets all parameters. The margins must be those that the robot was prepared for.
    #[must_use]
    pub fn parameters(self, parameters: Parameters) -> Self {
        Self { parameters, ..self }
    }

    /// Validates the settings and compiles robot and world once, to see that they can be used.
    ///
    /// # Errors
    /// A parameter is out of range, there is no thread, or the planner cannot use the robot, its
    /// preparation or the world.
    pub fn build(self) -> Result<Planner, BuildError> {
        let threads = NonZeroUsize::new(self.threads).ok_or(BuildError::NoThread)?;
        let mut parameters = self.parameters;
        if let Some(work_max) = self.work_max {
            parameters.planner.work_max = work_max;
        }
        let (prepared, world, seed) = (self.prepared, self.world, self.seed);
        let improve = self.improve;
        let task = Task::new(Stance::at(0.0, 0.0, 0.0), Goal::at(0.0, 0.0, 0.0), world.clone());
        let planner = Planner {
            prepared,
            world,
            parameters,
            threads,
            improve,
            seed,
            task,
            search: None,
            plan: None,
        };
        match planner.begun(&planner.task) {
            Ok(_) => Ok(planner),
            Err(StartError::Stance(error)) => Err(error.into()),
            Err(StartError::Planner(error)) => Err(error.into()),
        }
    }
}

/// A planning problem: start, goal, world and plan name.
#[derive(Debug, Clone)]
struct Task {
    start: Stance,
    goal: Goal,
    world: World,
    /// How the world differs from the one that the planner was built with.
    corrections: Vec<WorldCorrection>,
    /// Where the robot is, in place of the start stance.
    rest_state: Option<RestState>,
    /// The chunks that led there.
    executed: Vec<PlanChunk>,
    /// How often the plan was made anew.
    epoch: u64,
}

impl Task {
    fn new(start: Stance, goal: Goal, world: World) -> Self {
        let (corrections, executed) = (vec![], vec![]);
        Self { start, goal, world, corrections, rest_state: None, executed, epoch: 0 }
    }

    /// Places where a sole found no contact: half sides of a rectangle (m) around each pose.
    fn missing_contacts(&self) -> impl Iterator<Item = (SpatialPose, [f64; 2])> {
        let is_missing = |correction: &&WorldCorrection| {
            correction.known_kind() == Some(CorrectionKind::ContactMissing)
        };
        self.corrections.iter().filter(is_missing).map(|correction| {
            let [half_length, half_width, _] = correction.half_extents;
            (correction.pose(), [half_length, half_width])
        })
    }
}

/// Finds whole-body walks of one robot in one world.
///
/// # Examples
/// A control loop gives the search a share of each cycle:
/// ```no_run
/// # fn cycle(planner: &mut surefoot::Planner) -> Result<(), Box<dyn std::error::Error>> {
/// use surefoot::{Goal, Stance, Step};
///
/// planner.begin(Stance::at(0.0, 0.0, 0.0), Goal::at(3.0, 0.0, 0.0))?;
/// let plan = loop {
///     match planner.step(40) {
///         Step::Working => continue, // the rest of the cycle
///         Step::Done(plan) => break plan?,
///     }
/// };
/// # Ok(()) }
/// ```
#[derive(Debug)]
pub struct Planner {
    prepared: Prepared,
    world: World,
    parameters: Parameters,
    threads: NonZeroUsize,
    improve: u64,
    seed: u64,
    task: Task,
    search: Option<Box<Begun>>,
    /// The plan found last.
    plan: Option<Plan>,
}

/// A search that was begun, and its scenario.
#[derive(Debug)]
struct Begun {
    search: Search,
    scenario: Scenario,
}

/// What a step of the planner leaves behind.
#[derive(Debug)]
pub enum Step {
    /// There is more to do.
    Working,
    /// The search is over.
    Done(Result<Plan, PlanError>),
}

impl Planner {
    /// Begins with a prepared robot and a world: default parameters, one thread, seed 1.
    pub fn builder(prepared: &Prepared, world: &World) -> PlannerBuilder {
        PlannerBuilder {
            prepared: prepared.clone(),
            world: world.clone(),
            parameters: Parameters::default(),
            threads: 1,
            work_max: None,
            improve: 0,
            seed: 1,
        }
    }

    /// Finds a walk.
    ///
    /// # Errors
    /// The search could not begin, or it ended without a plan: which bound or which end says so.
    pub fn plan(&mut self, start: Stance, goal: Goal) -> Result<Plan, PlanError> {
        self.begin(start, goal)?;
        self.finish()
    }

    /// Begins the search for a walk, for [`Planner::step`].
    ///
    /// # Errors
    /// A number of the start or the goal is out of range.
    pub fn begin(&mut self, start: Stance, goal: Goal) -> Result<(), StartError> {
        self.begin_task(Task::new(start, goal, self.world.clone()))
    }

    /// Advances the search by at most `work` units, or to its end, and exceeds its work by at most
    /// one unit. Only the step that finds the plan allocates: it copies the chunks into the plan.
    ///
    /// # Panics
    /// No search was begun.
    pub fn step(&mut self, work: u64) -> Step {
        let begun = self.search.as_mut().expect("begin comes before step");
        match begun.search.step(work) {
            Status::Working => Step::Working,
            Status::Done(outcome) => Step::Done(self.result(&outcome)),
        }
    }

    /// Finds a walk to the goal from a state that the robot is in, after something happened.
    ///
    /// # Errors
    /// Nothing was planned before, a correction names no shape of the world, or there is no plan.
    pub fn replan(&mut self, from: &State, what_happened: &Event) -> Result<Plan, ReplanError> {
        self.begin_replan(from, what_happened)?;
        Ok(self.finish()?)
    }

    /// Begins the search of [`Planner::replan`], for [`Planner::step`].
    ///
    /// # Errors
    /// Nothing was planned before, or a correction names no shape of the world.
    pub fn begin_replan(&mut self, from: &State, what_happened: &Event) -> Result<(), ReplanError> {
        if self.search.is_none() {
            return Err(ReplanError::NothingPlanned);
        }
        let before = &self.task;
        let mut task = Task {
            rest_state: Some(*from.rest_state()),
            executed: self.executed_until(from.time),
            epoch: before.epoch + 1,
            ..before.clone()
        };
        match what_happened {
            Event::WorldChanged(corrections) => {
                task.corrections.extend_from_slice(corrections);
                task.world = World::new(self.world.model().corrected(&task.corrections)?);
            }
            Event::GoalChanged(goal) => task.goal = *goal,
            Event::ChunkRefused { .. } | Event::FootMisplaced => {}
        }
        Ok(self.begin_task(task).map_err(PlanError::from)?)
    }

    /// The statistics of the search that was begun last.
    pub fn stats(&self) -> SearchStats {
        self.search.as_ref().map(|begun| begun.search.stats()).unwrap_or_default()
    }

    /// What the improvement of the plan came to so far; `None` before a first plan, and where plans
    /// are not improved.
    pub fn improvement(&self) -> Option<Improvement> {
        self.search.as_ref().and_then(|begun| begun.search.improvement())
    }

    /// Ends the improvement of a plan, with the best one so far: the next step returns it. Returns
    /// whether there is one.
    pub fn stop_improving(&mut self) -> bool {
        self.search.as_mut().is_some_and(|begun| begun.search.stop_improving())
    }

    /// How far the search that was begun last has come: the trees of stage P, the guide route, and
    /// where most sequences failed.
    pub fn trace(&self) -> SearchTrace {
        self.search.as_ref().map(|begun| begun.search.trace()).unwrap_or_default()
    }

    fn begin_task(&mut self, task: Task) -> Result<(), StartError> {
        self.search = Some(Box::new(self.begun(&task)?));
        (self.task, self.plan) = (task, None);
        Ok(())
    }

    /// A search for a task, ready to step.
    fn begun(&self, task: &Task) -> Result<Begun, StartError> {
        let scenario = self.scenario(task)?;
        let preparation = self.prepared.preparation().clone();
        let model = self.prepared.robot().model();
        let mut builder = Search::builder(model, task.world.model(), &scenario, preparation)
            .threads(self.threads)
            .improve(self.improve)
            .plan_name(PLAN_ID, task.epoch);
        if let Some(rest_state) = &task.rest_state {
            builder = builder.start_in(rest_state).retrace(&task.executed, 0);
        }
        for (world_from_sole, half_sides) in task.missing_contacts() {
            builder = builder.keep_out(world_from_sole, half_sides);
        }
        Ok(Begun { search: builder.build()?, scenario })
    }

    fn scenario(&self, task: &Task) -> Result<Scenario, ScenarioError> {
        let robot = self.prepared.robot();
        content(robot, task.start, task.goal, &self.parameters, self.seed).build()
    }

    /// The chunks of the plan found last that end by a time (s).
    fn executed_until(&self, time: f64) -> Vec<PlanChunk> {
        let chunks = self.plan.as_ref().map_or(&[][..], Plan::chunks);
        let ends_by = |chunk: &&PlanChunk| chunk.waypoints().last().is_some_and(|w| w.time <= time);
        chunks.iter().take_while(ends_by).copied().collect()
    }

    fn finish(&mut self) -> Result<Plan, PlanError> {
        loop {
            if let Step::Done(plan) = self.step(WORK_PER_STEP) {
                return plan;
            }
        }
    }

    fn result(&mut self, outcome: &Outcome) -> Result<Plan, PlanError> {
        let Some(begun) = &self.search else { unreachable!("a search has ended") };
        let Begun { search, scenario } = &**begun;
        match outcome {
            Outcome::Found => {
                let (robot, world) = (self.prepared.robot().clone(), self.task.world.clone());
                let ends = ends_of(robot.model(), scenario, search.chunks());
                let inputs = PlanInputs { robot, world, ends };
                let plan = Plan::new(search.chunks(), search.digest(), inputs);
                self.plan = Some(plan.clone());
                Ok(plan)
            }
            // The last three end searches by other methods or in parts, which this type has none of.
            Outcome::BudgetExhausted(_)
            | Outcome::NotExpressible(_)
            | Outcome::MethodExhausted(_)
            | Outcome::NoContinuation => {
                Err(PlanError::BudgetExhausted { work: search.stats().work })
            }
            Outcome::ArenaFull(full) => Err(PlanError::ArenaFull { parameter: full.parameter() }),
            Outcome::Impossible(_) => Err(PlanError::Impossible(search.describe(outcome))),
            Outcome::StartInvalid(_) => Err(PlanError::StartInvalid(search.describe(outcome))),
            Outcome::GoalInvalid(_) => Err(PlanError::GoalInvalid(search.describe(outcome))),
        }
    }
}
