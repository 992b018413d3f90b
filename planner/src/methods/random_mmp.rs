//! Random-MMP: one tree over modes and configurations (Hauser, Ng-Thow-Hing 2010) [Grey 2.3].
//!
//! A node is a transition with a configuration that a motion reaches: the foot that landed last
//! stands. A random point of the world, or the goal, chooses the node whose stance is nearest to
//! it; the other foot gets a random placement one step away. A node is added if both transitions of
//! the step get configurations, and the swing and the shift of weight get motions. Several steps
//! are tried at once, so that they run in parallel.

use glam::{DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{rotation_about, yaw_of};

use crate::base::arena::reserve;
use crate::base::capacity::ArenaFull;
use crate::base::random::{Random, Stream};
use crate::methods::lattice::transition;
use crate::methods::multi_modal_prm::MultiModalPrm;
use crate::methods::placements::{Adaptation, foothold_near};
use crate::methods::workbench::{MethodEvent, Workbench};
use crate::motion::ids::{FootholdId, GOAL, START, TransitionId};
use crate::motion::mode_graph::ModeGraph;
use crate::motion::roadmap::{ModeEdge, RouteSegment};
use crate::primitives::level_sole::side_of;

/// Steps that are tried at once.
const STEPS_MAX: usize = 16;
/// Share of the steps that lead toward the goal.
const GOAL_SHARE: f64 = 0.2;
/// Largest turn of a random placement against the stance, rad.
const TURN_MAX: f64 = 0.7;
/// How far a placement may lie from a random one.
const NEAR: Adaptation = Adaptation { distance: 0.1, height: 0.35, turn: 0.3 };
/// Batches in which the start may get its configurations.
const START_BATCHES: u32 = 20;
/// The parent of the first nodes.
const NO_NODE: u32 = u32::MAX;

/// A transition that the tree reaches.
#[derive(Debug, Clone, Copy)]
struct Node {
    /// The foot that landed last carries the weight.
    transition: TransitionId,
    parent: u32,
    /// Position of its stance, seen from above, m.
    at: DVec2,
}

/// A step that is being tried: the node that it begins from, and the transition that it reaches
/// first.
#[derive(Debug, Clone, Copy)]
struct Step {
    parent: u32,
    swing: TransitionId,
}

/// What follows next.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Task {
    /// Sample the transitions of the start; this many batches are done.
    Begin(u32),
    /// Choose steps.
    Choose,
    /// Sample their transitions.
    Sample,
    /// Plan their swings.
    Swing,
    /// Plan their shifts of weight.
    Shift,
    /// Complete the sequence.
    Complete,
}

/// The method, allocated once.
#[derive(Debug)]
pub(crate) struct RandomMmp {
    task: Task,
    nodes: Vec<Node>,
    steps: heapless::Vec<Step, STEPS_MAX>,
    draws: u64,
    path: Vec<TransitionId>,
    /// Completes the sequence.
    pub prm: MultiModalPrm,
}

impl RandomMmp {
    /// Reserves memory.
    pub fn new(nodes_max: usize, prm: MultiModalPrm) -> Self {
        Self {
            task: Task::Begin(0),
            nodes: reserve(nodes_max),
            steps: heapless::Vec::new(),
            draws: 0,
            path: reserve(2 * nodes_max),
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
            Task::Begin(batches) => return self.begin(bench, batches, budget),
            Task::Choose => self.choose(bench)?,
            Task::Sample => self.sample(bench, budget)?,
            Task::Swing => self.swing(bench, budget)?,
            Task::Shift => self.shift(bench, budget)?,
            // Where a motion from the start or to the goal fails, the tree grows on.
            Task::Complete => {
                return self.prm.complete(bench, budget, (&mut self.task, Task::Choose));
            }
        }
        Ok(MethodEvent::Continue)
    }

    /// Samples both transitions of the start.
    fn begin(
        &mut self,
        bench: &mut Workbench<'_>,
        batches: u32,
        budget: u64,
    ) -> Result<MethodEvent, ArenaFull> {
        let [left, right] = bench.roadmap.boundary(START).footholds;
        let first = transition(&mut bench.roadmap.graph, left, right)?;
        let both = [first, ModeGraph::twin(first)];
        if !advance_sampling(bench, &both, budget)? {
            return Ok(MethodEvent::Continue);
        }
        self.task = Task::Begin(batches + 1);
        for transition in both {
            if bench.roadmap.graph.transitions()[transition as usize].is_found() {
                self.add(bench, transition, NO_NODE)?;
                self.task = Task::Choose;
            }
        }
        Ok(if batches == START_BATCHES {
            MethodEvent::Exhausted("no foot can be lifted at the start")
        } else {
            MethodEvent::Continue
        })
    }

    fn add(
        &mut self,
        bench: &Workbench<'_>,
        transition: TransitionId,
        parent: u32,
    ) -> Result<(), ArenaFull> {
        if self.nodes.len() == self.nodes.capacity() {
            return Err(ArenaFull::Configurations);
        }
        let stance = bench.roadmap.graph.pair(transition).0;
        let at = stance.world_from_sole.translation.truncate();
        self.nodes.push(Node { transition, parent, at });
        Ok(())
    }

    /// Chooses the next step to try.
    fn choose(&mut self, bench: &mut Workbench<'_>) -> Result<(), ArenaFull> {
        bench.counts.placements += 1;
        let mut random = Random::new(bench.context.seed, Stream::Method, 2, self.draws);
        self.draws += 1;
        let is_toward_goal = random.uniform(0.0, 1.0) < GOAL_SHARE;
        let goals = bench.roadmap.boundary(GOAL).footholds;
        let target = if is_toward_goal {
            let goal = &bench.roadmap.graph.footholds()[goals[random.below(2)] as usize];
            goal.world_from_sole.translation.truncate()
        } else {
            let world = bench.context.constraints.collision.world_bounds();
            let coordinate =
                |axis: usize, random: &mut Random| random.uniform(world.min[axis], world.max[axis]);
            DVec2::new(coordinate(0, &mut random), coordinate(1, &mut random))
        };
        let parent = self.nearest(target);
        let from = self.nodes[parent as usize].transition;
        let stance = bench.roadmap.graph.transitions()[from as usize].stance;
        let landed = if is_toward_goal && self.is_near_goal(bench, stance) {
            Some(goals[1 - bench.roadmap.graph.footholds()[stance as usize].limb])
        } else {
            landing(bench, stance, &mut random)?
        };
        let footholds = bench.roadmap.graph.footholds();
        let pair = |landed: FootholdId| [stance, landed].map(|id| &footholds[id as usize]);
        if let Some(landed) = landed.filter(|&landed| bench.may_step(pair(landed))) {
            bench.counts.transitions += 1;
            let swing = transition(&mut bench.roadmap.graph, stance, landed)?;
            let is_chosen = self.steps.iter().any(|step| step.swing == swing);
            let has_motion = bench.roadmap.edges.get(from, swing).motion.is_some();
            if !is_chosen && !has_motion && from != swing {
                let _within = self.steps.push(Step { parent, swing });
            }
        }
        if self.steps.is_full() || self.draws.is_multiple_of(4 * STEPS_MAX as u64) {
            self.task = Task::Sample;
        }
        Ok(())
    }

    /// The node whose stance is nearest to a point; the first of several.
    fn nearest(&self, target: DVec2) -> u32 {
        let distance = |index: &u32| self.nodes[*index as usize].at.distance_squared(target);
        let nodes = 0..self.nodes.len() as u32;
        nodes.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
    }

    fn is_near_goal(&self, bench: &Workbench<'_>, stance: FootholdId) -> bool {
        let footholds = bench.roadmap.graph.footholds();
        let stance = &footholds[stance as usize];
        let goal = bench.roadmap.boundary(GOAL).footholds[1 - stance.limb];
        stance.distance(&footholds[goal as usize]) <= bench.step_max()
    }

    /// Samples the transitions of all steps.
    fn sample(&mut self, bench: &mut Workbench<'_>, budget: u64) -> Result<(), ArenaFull> {
        let both = |step: &Step| [step.swing, ModeGraph::twin(step.swing)];
        let transitions: heapless::Vec<TransitionId, { 2 * STEPS_MAX }> =
            self.steps.iter().flat_map(both).collect();
        if advance_sampling(bench, &transitions, budget)? {
            let graph = &bench.roadmap.graph;
            let is_found = |id: TransitionId| graph.transitions()[id as usize].is_found();
            self.steps.retain(|step| both(step).into_iter().all(is_found));
            self.task = Task::Swing;
        }
        Ok(())
    }

    /// Plans the swings of all steps.
    fn swing(&mut self, bench: &mut Workbench<'_>, budget: u64) -> Result<(), ArenaFull> {
        let nodes = &self.nodes;
        let edge =
            |step: &Step| ModeEdge { from: nodes[step.parent as usize].transition, to: step.swing };
        let edges: heapless::Vec<ModeEdge, STEPS_MAX> = self.steps.iter().map(edge).collect();
        if advance_motions(bench, &edges, budget)? {
            let has_motion = |step: &Step| bench.roadmap.motion(edge(step)).is_some();
            self.steps.retain(has_motion);
            self.task = Task::Shift;
        }
        Ok(())
    }

    /// Plans the shifts of weight of all steps, and adds the nodes that they reach.
    fn shift(&mut self, bench: &mut Workbench<'_>, budget: u64) -> Result<(), ArenaFull> {
        let edge = |step: &Step| ModeEdge { from: step.swing, to: ModeGraph::twin(step.swing) };
        let edges: heapless::Vec<ModeEdge, STEPS_MAX> = self.steps.iter().map(edge).collect();
        if !advance_motions(bench, &edges, budget)? {
            return Ok(());
        }
        self.task = Task::Choose;
        let goals = bench.roadmap.boundary(GOAL).footholds;
        for step in std::mem::take(&mut self.steps) {
            let reached = ModeGraph::twin(step.swing);
            let is_known = self.nodes.iter().any(|node| node.transition == reached);
            if is_known || bench.roadmap.motion(edge(&step)).is_none() {
                continue;
            }
            self.add(bench, reached, step.parent)?;
            let ends = &bench.roadmap.graph.transitions()[reached as usize];
            if goals.contains(&ends.stance) && goals.contains(&ends.other) {
                self.trace(bench)?;
                break;
            }
        }
        Ok(())
    }

    /// Takes the path to the node added last.
    fn trace(&mut self, bench: &mut Workbench<'_>) -> Result<(), ArenaFull> {
        bench.counts.sequences += 1;
        self.path.clear();
        let mut at = self.nodes.len() as u32 - 1;
        while at != NO_NODE {
            let Node { transition, parent, .. } = self.nodes[at as usize];
            self.path.push(transition);
            if parent != NO_NODE {
                self.path.push(ModeGraph::twin(transition));
            }
            at = parent;
        }
        self.path.reverse();
        self.prm.begin_with(self.path.iter().copied())?;
        self.task = Task::Complete;
        Ok(())
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>()
            + self.path.capacity() * size_of::<TransitionId>()
            + self.prm.bytes()
    }
}

/// A random foothold of the other foot within a step of a stance, if there is ground.
fn landing(
    bench: &mut Workbench<'_>,
    stance: FootholdId,
    random: &mut Random,
) -> Result<Option<FootholdId>, ArenaFull> {
    let (foothold, reach) = (&bench.roadmap.graph.footholds()[stance as usize], bench.step_max());
    let (limb, side) = (1 - foothold.limb, side_of(1 - foothold.limb));
    let heading = rotation_about(DVec3::Z, yaw_of(foothold.world_from_sole.rotation));
    let (ahead, aside) = (random.uniform(-reach, reach), random.uniform(0.0, reach));
    let offset = heading * DVec3::new(ahead, side * aside, 0.0);
    let turn = rotation_about(DVec3::Z, random.uniform(-TURN_MAX, TURN_MAX));
    let ideal = Pose::from_parts(foothold.world_from_sole.translation + offset, heading * turn);
    let Some(landed) = foothold_near(bench, limb, ideal, NEAR) else { return Ok(None) };
    let graph = &mut bench.roadmap.graph;
    match graph.find_equivalent(&landed) {
        Some(known) => Ok(Some(known)),
        None => graph.add_foothold(landed).map(Some),
    }
}

/// Samples transitions, or goes on doing so. Returns whether the batch has ended.
fn advance_sampling(
    bench: &mut Workbench<'_>,
    transitions: &[TransitionId],
    budget: u64,
) -> Result<bool, ArenaFull> {
    if !bench.batch.is_running() {
        bench.batch.begin();
        let all = RouteSegment { sequence: transitions, ends: [0; 2] };
        bench.batch.add_sampling(0, bench.roadmap, all, 0);
    }
    let (spent, batch) = bench.advance_batch(budget)?;
    bench.counts.configurations += spent;
    let Some(batch) = batch else { return Ok(false) };
    bench.counts.transitions_found += u64::from(batch.found);
    Ok(true)
}

/// Plans motions along single edges, or goes on doing so. Returns whether the batch has ended.
fn advance_motions(
    bench: &mut Workbench<'_>,
    edges: &[ModeEdge],
    budget: u64,
) -> Result<bool, ArenaFull> {
    if !bench.batch.is_running() {
        bench.batch.begin();
        for edge in edges {
            let alone = RouteSegment { sequence: &[], ends: [edge.from, edge.to] };
            bench.batch.add_motions(0, bench.context, bench.roadmap, alone, 0);
        }
    }
    let (spent, batch) = bench.advance_batch(budget)?;
    bench.counts.motions += spent;
    let Some(batch) = batch else { return Ok(false) };
    bench.counts.motions_found += u64::from(batch.found);
    Ok(true)
}
