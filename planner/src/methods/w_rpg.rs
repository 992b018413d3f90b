//! w-RPG and its limit MMPRM [Grey 5.3, 5.7].
//!
//! A round samples C_N, takes a route over lines between the samples, samples placements in the
//! discs about its points, joins all pairs of placements that the robot may step between, and runs
//! a multi-modal PRM over the modes. It uses no sufficient conditions, no elevation, no primitives
//! along a route, and no priors. Where a round fails, the next one adds as many samples again and
//! takes another route; nothing found before is dropped. Without stage P, placements are uniform
//! over the world.

use glam::{DVec2, DVec3};

use crate::base::capacity::ArenaFull;
use crate::constraints::foothold::Foothold;
use crate::methods::disc_placements::SamplingArea;
use crate::methods::exploration::{Exploration, ROOT_HEIGHT_SHARE, RouteEvent};
use crate::methods::method::MethodParameters;
use crate::methods::multi_modal_prm::{MultiModalPrm, Progress};
use crate::methods::workbench::{MethodEvent, Workbench};
use crate::motion::ids::{FootholdId, GOAL, START};

/// Largest difference between the heights of start and goal on level ground, m.
const LEVEL: f64 = 1e-3;
/// Failed sequences that end a round.
const SEQUENCES_PER_ROUND: u32 = 48;

/// What follows next.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Task {
    Begin,
    /// Sample C_N.
    Explore,
    /// Search a route over lines between them.
    Route,
    /// Sample placements; this many are left.
    Place {
        left: u32,
    },
    /// Connect the placements.
    Connect,
    /// Run the multi-modal PRM.
    Modes,
}

/// The method, allocated once.
#[derive(Debug)]
pub(crate) struct WRpg {
    parameters: MethodParameters,
    /// Whether stage P restricts where placements are sampled.
    has_stage_p: bool,
    task: Task,
    exploration: Exploration,
    area: SamplingArea,
    /// The multi-modal PRM, with the sequence that it completes.
    pub prm: MultiModalPrm,
    round: u32,
    failures: u32,
}

impl WRpg {
    /// Reserves memory.
    pub fn new(parameters: MethodParameters, prm: MultiModalPrm) -> Self {
        Self {
            parameters,
            has_stage_p: parameters.disc_radius_share.is_finite(),
            task: Task::Begin,
            exploration: Exploration::new(),
            area: SamplingArea::new(),
            prm,
            round: 1,
            failures: 0,
        }
    }

    /// Advances by at most `budget` units of work.
    ///
    /// # Errors
    /// An arena is full.
    pub fn step(
        &mut self,
        bench: &mut Workbench<'_>,
        budget: u64,
    ) -> Result<MethodEvent, ArenaFull> {
        match self.task {
            Task::Begin => return Ok(self.begin(bench)),
            Task::Explore => self.explore(bench),
            Task::Route => return Ok(self.seek_route(bench)),
            Task::Place { left } => self.place(bench, left)?,
            Task::Connect => self.connect(bench)?,
            Task::Modes => return self.run_modes(bench, budget),
        }
        Ok(MethodEvent::Continue)
    }

    /// rho of the round, m.
    fn disc_radius(&self, bench: &Workbench<'_>) -> f64 {
        self.parameters.disc_radius_share_of(u64::from(self.round)) * bench.step_max()
    }

    /// Height of the ground, m.
    fn ground_height(bench: &Workbench<'_>, end: usize) -> f64 {
        let footholds = bench.roadmap.boundary(end).footholds;
        let height = |id: FootholdId| {
            bench.roadmap.graph.footholds()[id as usize].world_from_sole.translation.z
        };
        0.5 * (height(footholds[0]) + height(footholds[1]))
    }

    /// Sets the box of E and the rectangle of placements: the world seen from above.
    fn begin(&mut self, bench: &mut Workbench<'_>) -> MethodEvent {
        bench.counts.route += 1;
        let [ground, goal_ground] = [START, GOAL].map(|end| Self::ground_height(bench, end));
        if (ground - goal_ground).abs() > LEVEL {
            return MethodEvent::NotExpressible(
                "it places feet on level ground of one height only",
            );
        }
        let world = bench.context.constraints.collision.world_bounds();
        let roots = [START, GOAL]
            .map(|end| bench.roadmap.boundary(end).state.configuration.world_from_root);
        let height = ROOT_HEIGHT_SHARE * (roots[0].translation.z - ground);
        let low = DVec3::new(world.min.x, world.min.y, ground);
        let high = DVec3::new(world.max.x, world.max.y, ground + height);
        self.exploration.begin([&roots[0], &roots[1]], [low, high]);
        let rectangle: [DVec2; 2] = [low.truncate(), high.truncate()];
        self.area.set_rectangle(rectangle, ground);
        self.begin_round();
        MethodEvent::Continue
    }

    fn begin_round(&mut self) {
        self.failures = 0;
        let left = 2 * self.parameters.placements;
        self.task = if self.has_stage_p { Task::Explore } else { Task::Place { left } };
    }

    /// Samples C_N until the round has its samples.
    fn explore(&mut self, bench: &mut Workbench<'_>) {
        let wanted = self.parameters.route_samples as usize * self.round as usize;
        if self.exploration.samples() >= wanted || self.exploration.is_full() {
            bench.counts.route += 1;
            self.exploration.begin_route();
            self.task = Task::Route;
        } else {
            self.exploration.sample(bench);
        }
    }

    fn seek_route(&mut self, bench: &mut Workbench<'_>) -> MethodEvent {
        match self.exploration.seek_route(bench, f64::INFINITY) {
            RouteEvent::Continue => {}
            RouteEvent::Exhausted => return self.end_round(),
            RouteEvent::Found => {
                let (radius, ground) = (self.disc_radius(bench), Self::ground_height(bench, START));
                self.area.set_discs(self.exploration.route(), radius, ground);
                self.task = Task::Place { left: 2 * self.parameters.placements };
            }
        }
        MethodEvent::Continue
    }

    /// Samples one placement; the feet alternate.
    fn place(&mut self, bench: &mut Workbench<'_>, left: u32) -> Result<(), ArenaFull> {
        if left == 0 {
            bench.counts.placements += 1;
            self.task = Task::Connect;
        } else if self.area.sample(bench, left as usize % 2)? {
            self.task = Task::Place { left: left - 1 };
        }
        Ok(())
    }

    /// Joins the next placement with all earlier ones of the other foot that may be one step away.
    fn connect(&mut self, bench: &mut Workbench<'_>) -> Result<(), ArenaFull> {
        bench.counts.transitions += 1;
        let id = bench.roadmap.graph.connected();
        if id as usize == bench.roadmap.graph.footholds().len() {
            self.prm.begin();
            self.task = Task::Modes;
            return Ok(());
        }
        let mut next = 0;
        while let Some(other) = next_neighbour(bench, id, next) {
            bench.roadmap.graph.connect(id, other)?;
            next = other + 1;
        }
        bench.roadmap.graph.mark_connected(id);
        Ok(())
    }

    /// Advances the multi-modal PRM.
    fn run_modes(
        &mut self,
        bench: &mut Workbench<'_>,
        budget: u64,
    ) -> Result<MethodEvent, ArenaFull> {
        let progress = self.prm.advance(bench, budget)?;
        self.failures += u32::from(progress == Progress::Failed);
        Ok(match progress {
            Progress::Complete => MethodEvent::Found,
            Progress::Disconnected => self.end_round(),
            Progress::Failed if self.failures == SEQUENCES_PER_ROUND => self.end_round(),
            Progress::Failed | Progress::Working => MethodEvent::Continue,
        })
    }

    fn end_round(&mut self) -> MethodEvent {
        if self.round == self.parameters.rounds_max {
            return MethodEvent::Exhausted("its samples hold no walk");
        }
        self.round += 1;
        self.begin_round();
        MethodEvent::Continue
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.exploration.bytes() + self.area.bytes() + self.prm.bytes()
    }
}

/// The first foothold of the other foot, from `next` on and before `id`, that may be one step from
/// foothold `id`.
fn next_neighbour(bench: &Workbench<'_>, id: FootholdId, next: FootholdId) -> Option<FootholdId> {
    let graph = &bench.roadmap.graph;
    let reach = bench.context.preparation.step_limits().reach();
    let here = &graph.footholds()[id as usize];
    let near = graph.near(1 - here.limb, here.world_from_sole.translation);
    let mut earlier =
        near.skip_while(|&(other, _)| other < next).take_while(|&(other, _)| other < id);
    let may_step = |(_, other): &(FootholdId, &Foothold)| {
        here.distance(other) <= reach && bench.may_step([here, other])
    };
    earlier.find(may_step).map(|(other, _)| other)
}
