//! Reachability-guided planning: a guide route of the root, one contact sequence along it, one
//! interpolation (Tonneau, Del Prete, Pettre, Park, Manocha, Mansard 2018) [Grey 2.1].
//!
//! The route leads over uniform samples of C_N with the root upright. From the start on, the feet
//! step by turns as far ahead along it as a prepared posture allows; the first placement that holds
//! is kept. Stage M then plans the configurations and motions of that one sequence. Where any of
//! this fails, another route is sampled.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{rotation_about, wrap_angle, yaw_of};

use crate::base::arena::reserve;
use crate::base::capacity::ArenaFull;
use crate::constraints::foothold::Foothold;
use crate::methods::exploration::{Exploration, ROOT_HEIGHT_SHARE, RouteEvent};
use crate::methods::guide_line::GuideLine;
use crate::methods::lattice::transition;
use crate::methods::lattice_steps::StepTest;
use crate::methods::multi_modal_prm::MultiModalPrm;
use crate::methods::placements::foothold_near;
use crate::methods::workbench::{MethodEvent, Workbench};
use crate::motion::ids::{FootholdId, GOAL, START, TransitionId};
use crate::motion::mode_graph::ModeGraph;
use crate::primitives::level_sole::side_of;

/// Strides that are tried, longest first, relative to the longest level step.
const STRIDES: [f64; 6] = [0.6, 0.5, 0.4, 0.3, 0.2, 0.1];
/// Largest turn from one foot to the next, rad.
const TURN_MAX: f64 = 0.3;
/// Longest line between two samples, relative to the longest level step.
const LINE_SHARE: f64 = 3.0;
/// Most steps of a sequence.
const STEPS_MAX: usize = 512;

/// What follows next.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Task {
    Begin,
    /// Sample C_N.
    Explore,
    /// Search a route over lines between the samples.
    Route,
    /// Step on, with this stride.
    Step {
        stride: usize,
    },
    /// Complete the sequence.
    Complete,
}

/// The contact sequence so far.
#[derive(Debug)]
struct Walk {
    /// The feet: left, right.
    feet: [FootholdId; 2],
    /// The foot that steps next.
    limb: usize,
    /// Length along the route (m) that each foot has reached.
    reached: [f64; 2],
    transitions: Vec<TransitionId>,
}

/// The method, allocated once.
#[derive(Debug)]
pub(crate) struct Reachability {
    route_samples: u32,
    task: Task,
    exploration: Exploration,
    line: GuideLine,
    walk: Walk,
    rounds: usize,
    /// Completes the sequence.
    pub prm: MultiModalPrm,
}

impl Reachability {
    /// Reserves memory; a route leads over this many samples.
    pub fn new(route_samples: u32, prm: MultiModalPrm) -> Self {
        Self {
            route_samples,
            task: Task::Begin,
            exploration: Exploration::new(),
            line: GuideLine::new(),
            walk: Walk {
                feet: [0; 2],
                limb: 0,
                reached: [0.0; 2],
                transitions: reserve(2 * STEPS_MAX + 1),
            },
            rounds: 0,
            prm,
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
            Task::Begin => self.begin(bench),
            Task::Explore => self.explore(bench),
            Task::Route => self.seek_route(bench)?,
            Task::Step { stride } => self.step_on(bench, stride)?,
            Task::Complete => {
                return self.prm.complete(bench, budget, (&mut self.task, Task::Begin));
            }
        }
        Ok(MethodEvent::Continue)
    }

    /// Begins a round in the box of E above the world.
    fn begin(&mut self, bench: &mut Workbench<'_>) {
        bench.counts.route += 1;
        let world = bench.context.constraints.collision.world_bounds();
        let ends = [START, GOAL].map(|end| bench.roadmap.boundary(end));
        let roots = ends.map(|end| end.state.configuration.world_from_root);
        let soles = ends.map(|end| end.state.world_from_soles[0].translation.z);
        let standing = roots[0].translation.z - soles[0];
        let high = soles[0].max(soles[1]) + ROOT_HEIGHT_SHARE * standing;
        let low = DVec3::new(world.min.x, world.min.y, soles[0].min(soles[1]));
        let bounds = [low, DVec3::new(world.max.x, world.max.y, high)];
        self.exploration.begin([&roots[0], &roots[1]], bounds);
        self.exploration.keep_upright();
        self.rounds += 1;
        self.task = Task::Explore;
    }

    fn explore(&mut self, bench: &mut Workbench<'_>) {
        let is_complete = self.exploration.samples() >= self.route_samples as usize;
        if is_complete || self.exploration.is_full() {
            bench.counts.route += 1;
            self.exploration.begin_route();
            self.task = Task::Route;
        } else {
            self.exploration.sample(bench);
        }
    }

    /// Searches a route; then begins to walk along it.
    fn seek_route(&mut self, bench: &mut Workbench<'_>) -> Result<(), ArenaFull> {
        match self.exploration.seek_route(bench, LINE_SHARE * bench.step_max()) {
            RouteEvent::Continue => return Ok(()),
            RouteEvent::Exhausted => {
                self.task = Task::Begin;
                return Ok(());
            }
            RouteEvent::Found => {}
        }
        self.line.set(self.exploration.route());
        let feet = bench.roadmap.boundary(START).footholds;
        let limb = self.rounds % 2;
        let first = transition(&mut bench.roadmap.graph, feet[1 - limb], feet[limb])?;
        self.walk.transitions.clear();
        self.walk.transitions.push(first);
        (self.walk.feet, self.walk.limb, self.walk.reached) = (feet, limb, [0.0; 2]);
        self.task = Task::Step { stride: 0 };
        Ok(())
    }

    /// Tries one placement of the next foot: that of the goal, or the one a stride ahead.
    fn step_on(&mut self, bench: &mut Workbench<'_>, stride: usize) -> Result<(), ArenaFull> {
        bench.counts.placements += 1;
        let stance = self.walk.feet[1 - self.walk.limb];
        let goals = bench.roadmap.boundary(GOAL).footholds;
        if stride == 0 && self.may_step(bench, goals[self.walk.limb]) {
            self.land(bench, goals[self.walk.limb], self.line.length)?;
            return self.end_at(bench, goals);
        }
        let reached = self.walk.reached[1 - self.walk.limb];
        let Some(share) = STRIDES.get(stride) else {
            self.task = Task::Begin;
            return Ok(());
        };
        self.task = Task::Step { stride: stride + 1 };
        let standing = &bench.roadmap.graph.footholds()[stance as usize];
        let (ideal, length) = self.ideal(bench, standing, reached + share * bench.step_max());
        let adaptation = StepTest::AdaptedPostures.adaptation();
        let Some(landed) = foothold_near(bench, self.walk.limb, ideal, adaptation) else {
            return Ok(());
        };
        let landed = bench.roadmap.graph.add_foothold(landed)?;
        if self.may_step(bench, landed) {
            self.land(bench, landed, length)?;
            self.task = Task::Step { stride: 0 };
            if self.walk.transitions.len() + 2 > self.walk.transitions.capacity() {
                self.task = Task::Begin;
            }
        }
        Ok(())
    }

    /// The ideal sole of the next foot at a length along the route (m), and the length that it
    /// reaches: where the route bends, the foot turns beside the other one first.
    fn ideal(&self, bench: &Workbench<'_>, standing: &Foothold, length: f64) -> (Pose, f64) {
        let limb = self.walk.limb;
        let goals = bench.roadmap.boundary(GOAL).footholds;
        let goal = goals.map(|id| bench.roadmap.graph.footholds()[id as usize].world_from_sole);
        let width = goal[0].translation.distance(goal[1].translation);
        let (point, mut direction) = self.line.at(length);
        if length >= self.line.length {
            direction = yaw_of(goal[limb].rotation);
        }
        let heading = yaw_of(standing.world_from_sole.rotation);
        let turn = wrap_angle(direction - heading);
        let yaw = heading + turn.clamp(-TURN_MAX, TURN_MAX);
        let rotation = rotation_about(DVec3::Z, yaw);
        let aside = rotation * (side_of(limb) * width * DVec3::Y);
        let at = standing.world_from_sole.translation;
        if turn.abs() > TURN_MAX {
            return (Pose::from_parts(at + aside, rotation), self.walk.reached[1 - limb]);
        }
        let position = point.extend(at.z) + 0.5 * aside;
        (Pose::from_parts(position, rotation), length.min(self.line.length))
    }

    /// Whether a prepared posture holds on a step of the next foot to a foothold.
    fn may_step(&self, bench: &Workbench<'_>, landed: FootholdId) -> bool {
        let footholds = bench.roadmap.graph.footholds();
        let stance = self.walk.feet[1 - self.walk.limb];
        let pair = [stance, landed].map(|id| &footholds[id as usize]);
        StepTest::AdaptedPostures.holds(bench, pair)
    }

    /// Appends a step of the next foot.
    fn land(
        &mut self,
        bench: &mut Workbench<'_>,
        landed: FootholdId,
        length: f64,
    ) -> Result<(), ArenaFull> {
        let Walk { feet, limb, reached, transitions } = &mut self.walk;
        let swing = transition(&mut bench.roadmap.graph, feet[1 - *limb], landed)?;
        transitions.extend([swing, ModeGraph::twin(swing)]);
        (feet[*limb], reached[*limb]) = (landed, length);
        *limb = 1 - *limb;
        Ok(())
    }

    /// Steps onto the second foothold of the goal, if a posture holds there, and completes the
    /// sequence.
    fn end_at(
        &mut self,
        bench: &mut Workbench<'_>,
        goals: [FootholdId; 2],
    ) -> Result<(), ArenaFull> {
        let last = goals[self.walk.limb];
        let is_there = self.walk.feet[self.walk.limb] == last;
        if !is_there && !self.may_step(bench, last) {
            self.task = Task::Begin;
            return Ok(());
        }
        if !is_there {
            self.land(bench, last, self.line.length)?;
        }
        bench.counts.sequences += 1;
        self.prm.begin_with(self.walk.transitions.iter().copied())?;
        self.task = Task::Complete;
        Ok(())
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.exploration.bytes()
            + self.line.bytes()
            + self.walk.transitions.capacity() * size_of::<TransitionId>()
            + self.prm.bytes()
    }
}
