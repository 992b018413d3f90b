//! A* over a fixed set of steps (Kuffner 2001, Chestnutt 2005) [Grey 2.2].
//!
//! A node is a transition: the foot that landed last stands, and the other foot steps next. A step
//! costs more the longer it is; the distance to the goal divided by the longest step is the
//! heuristic. Only the stance matters to what follows, so each is expanded once. The sequence that
//! is found gets its configurations and motions from stage M; where one fails, that step is
//! excluded and the search begins again.

use crate::base::arena::{filled, reserve};
use crate::base::capacity::ArenaFull;
use crate::constraints::foothold::Foothold;
use crate::methods::lattice_steps::{STEPS_LEN, StepTest, step_from};
use crate::methods::multi_modal_prm::MultiModalPrm;
use crate::methods::placements::foothold_near;
use crate::methods::workbench::{MethodEvent, Workbench};
use crate::motion::ids::{FootholdId, GOAL, START, TransitionId};
use crate::motion::indexed_heap::IndexHeap;
use crate::motion::mode_graph::ModeGraph;
use crate::motion::roadmap::ModeEdge;
use crate::motion::tuning::ATTEMPTS_MAX;
use crate::primitives::PrimitiveTrajectory;

/// Cost of a step, in addition to its length relative to the longest one.
const STEP_COST: f64 = 1.0;
/// Weight of the heuristic (weighted A*): paths may cost more than the cheapest, and far fewer
/// nodes are expanded.
const HEURISTIC_WEIGHT: f64 = 4.0;
/// Placements nearer than this (m) and turned less than this (sine of half the angle) are the same.
const SAME: (f64, f64) = (0.03, 0.04);
/// The parent of the first nodes.
const NO_NODE: u32 = u32::MAX;

/// A transition that the search reached.
#[derive(Debug, Clone, Copy)]
struct Node {
    /// The foot that landed last carries the weight.
    transition: TransitionId,
    parent: u32,
    cost: f64,
}

/// What follows next.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Task {
    Begin,
    /// Expand the next node.
    Pop,
    /// Try the steps of a node from `step` on.
    Expand {
        node: u32,
        step: usize,
    },
    /// Add the primitives of the path from edge `next` on.
    Primitives {
        node: u32,
    },
    /// Complete the sequence.
    Complete,
}

/// The method, allocated once.
#[derive(Debug)]
pub(crate) struct Lattice {
    test: StepTest,
    task: Task,
    nodes: Vec<Node>,
    open: IndexHeap,
    /// By foothold: the least cost at which it was reached as a stance.
    reached: Vec<f64>,
    path: Vec<u32>,
    /// Completes the sequence.
    pub prm: MultiModalPrm,
}

impl Lattice {
    /// Reserves memory.
    pub fn new(test: StepTest, footholds_max: usize, prm: MultiModalPrm) -> Self {
        let nodes_max = 2 * footholds_max;
        Self {
            test,
            task: Task::Begin,
            nodes: reserve(nodes_max),
            open: IndexHeap::new(nodes_max),
            reached: filled(f64::INFINITY, footholds_max),
            path: reserve(nodes_max),
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
            Task::Begin => self.begin(bench)?,
            Task::Pop => return self.pop(bench),
            Task::Expand { node, step } => self.expand(bench, node, step)?,
            Task::Primitives { node } => self.add_primitives(bench, node, budget)?,
            // Where a transition or a motion fails, another sequence is searched.
            Task::Complete => {
                return self.prm.complete(bench, budget, (&mut self.task, Task::Begin));
            }
        }
        Ok(MethodEvent::Continue)
    }

    /// Begins with both transitions of the start.
    fn begin(&mut self, bench: &mut Workbench<'_>) -> Result<(), ArenaFull> {
        bench.counts.sequence += 1;
        self.nodes.clear();
        self.open.clear();
        self.reached.fill(f64::INFINITY);
        let [left, right] = bench.roadmap.boundary(START).footholds;
        let first = transition(&mut bench.roadmap.graph, left, right)?;
        for transition in [first, ModeGraph::twin(first)] {
            self.reach(bench, Node { transition, parent: NO_NODE, cost: 0.0 })?;
        }
        self.task = Task::Pop;
        Ok(())
    }

    /// Adds a node, unless its stance was reached at no more cost.
    fn reach(&mut self, bench: &Workbench<'_>, node: Node) -> Result<(), ArenaFull> {
        let graph = &bench.roadmap.graph;
        let stance = graph.transitions()[node.transition as usize].stance as usize;
        let (foothold, goals) =
            (&graph.footholds()[stance], bench.roadmap.boundary(GOAL).footholds);
        if node.cost >= self.reached[stance] && !goals.contains(&(stance as FootholdId)) {
            return Ok(());
        }
        if self.nodes.len() == self.nodes.capacity() {
            return Err(ArenaFull::Footholds);
        }
        self.reached[stance] = self.reached[stance].min(node.cost);
        let goal = &graph.footholds()[goals[foothold.limb] as usize];
        let estimate = HEURISTIC_WEIGHT * foothold.distance(goal) / bench.step_max();
        self.open.push(self.nodes.len() as u32, node.cost + estimate, 0);
        self.nodes.push(node);
        Ok(())
    }

    /// Takes the cheapest node, and ends at the goal.
    fn pop(&mut self, bench: &mut Workbench<'_>) -> Result<MethodEvent, ArenaFull> {
        bench.counts.sequence += 1;
        let Some((node, ..)) = self.open.pop() else {
            return Ok(MethodEvent::Exhausted("its steps lead to no walk"));
        };
        let goals = bench.roadmap.boundary(GOAL).footholds;
        let ends =
            &bench.roadmap.graph.transitions()[self.nodes[node as usize].transition as usize];
        if goals.contains(&ends.stance) && goals.contains(&ends.other) {
            bench.counts.sequences += 1;
            self.trace(bench, node)?;
        } else {
            self.task = Task::Expand { node, step: 0 };
        }
        Ok(MethodEvent::Continue)
    }

    /// Tries the next step of a node; after those of the set, the foothold at the goal.
    fn expand(
        &mut self,
        bench: &mut Workbench<'_>,
        node: u32,
        step: usize,
    ) -> Result<(), ArenaFull> {
        bench.counts.placements += 1;
        self.task =
            if step < STEPS_LEN { Task::Expand { node, step: step + 1 } } else { Task::Pop };
        let from = self.nodes[node as usize];
        let stance = bench.roadmap.graph.transitions()[from.transition as usize].stance;
        let landed = if step < STEPS_LEN {
            self.landing(bench, stance, step)?
        } else {
            let limb = bench.roadmap.graph.footholds()[stance as usize].limb;
            Some(bench.roadmap.boundary(GOAL).footholds[1 - limb])
        };
        let Some(landed) = landed else { return Ok(()) };
        let graph = &bench.roadmap.graph;
        let pair = [stance, landed].map(|id| &graph.footholds()[id as usize]);
        let cost = from.cost + STEP_COST + pair[0].distance(pair[1]) / bench.step_max();
        let is_goal = bench.roadmap.boundary(GOAL).footholds.contains(&landed);
        if cost >= self.reached[landed as usize] && !is_goal {
            return Ok(());
        }
        bench.counts.transitions += 1;
        if !self.test.holds(bench, pair) {
            return Ok(());
        }
        let swing = transition(&mut bench.roadmap.graph, stance, landed)?;
        if is_excluded(bench, ModeEdge { from: from.transition, to: swing }) {
            return Ok(());
        }
        self.reach(bench, Node { transition: ModeGraph::twin(swing), parent: node, cost })
    }

    /// The foothold to which a step of the set leads, if the ground supports it.
    fn landing(
        &self,
        bench: &mut Workbench<'_>,
        stance: FootholdId,
        step: usize,
    ) -> Result<Option<FootholdId>, ArenaFull> {
        let foothold = &bench.roadmap.graph.footholds()[stance as usize];
        let (limb, ideal) = (1 - foothold.limb, step_from(foothold, step, bench.step_max()));
        let Some(landed) = foothold_near(bench, limb, ideal, self.test.adaptation()) else {
            return Ok(None);
        };
        let is_same = |known: &Foothold| {
            let turn = known.world_from_sole.rotation.conjugate() * landed.world_from_sole.rotation;
            known.distance(&landed) < SAME.0 && turn.xyz().length() < SAME.1
        };
        let graph = &mut bench.roadmap.graph;
        let position = landed.world_from_sole.translation;
        let known = graph.near(limb, position).find(|(_, known)| is_same(known));
        match known.map(|(id, _)| id) {
            Some(id) => Ok(Some(id)),
            None => graph.add_foothold(landed).map(Some),
        }
    }

    /// Writes the path to a node.
    fn trace(&mut self, bench: &mut Workbench<'_>, node: u32) -> Result<(), ArenaFull> {
        self.path.clear();
        let before = |at: &u32| Some(self.nodes[*at as usize].parent).filter(|at| *at != NO_NODE);
        self.path.extend(std::iter::successors(Some(node), before));
        self.path.reverse();
        let nodes = &self.nodes;
        let transitions = self.path.iter().enumerate().flat_map(|(index, &at)| {
            let arrived = nodes[at as usize].transition;
            let swing = (index > 0).then_some(ModeGraph::twin(arrived));
            swing.into_iter().chain([arrived])
        });
        self.prm.begin_with(transitions)?;
        let is_primitive = self.test == StepTest::ExpandedGeometry;
        self.task = if is_primitive { Task::Primitives { node: 0 } } else { Task::Complete };
        bench.counts.sequence += 1;
        Ok(())
    }

    /// Adds the primitives between the transitions of the path.
    fn add_primitives(
        &mut self,
        bench: &mut Workbench<'_>,
        first: u32,
        budget: u64,
    ) -> Result<(), ArenaFull> {
        if !bench.batch.is_running() {
            bench.batch.begin();
            let mut next = first;
            let sequence = self.prm.sequence();
            for pair in sequence.windows(2).skip(first as usize) {
                if bench.batch.is_full() {
                    break;
                }
                next += 1;
                let edge = ModeEdge { from: pair[0], to: pair[1] };
                let is_known = bench.roadmap.edges.get(edge.from, edge.to).motion.is_some();
                if let Some(trajectory) = trajectory(bench, edge).filter(|_| !is_known) {
                    bench.batch.add_primitive(edge, trajectory);
                }
            }
            self.task = Task::Primitives { node: next };
        }
        let (spent, batch) = bench.advance_batch(budget)?;
        bench.counts.motions += spent;
        if let (Some(batch), Task::Primitives { node }) = (batch, self.task) {
            bench.counts.motions_found += u64::from(batch.found);
            if node as usize + 1 >= self.prm.sequence().len() {
                self.task = Task::Complete;
            }
        }
        Ok(())
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>()
            + self.open.bytes()
            + self.reached.capacity() * size_of::<f64>()
            + self.path.capacity() * size_of::<u32>()
            + self.prm.bytes()
    }
}

/// The transition from a stance onto another foothold, added if the graph does not have it.
pub(crate) fn transition(
    graph: &mut ModeGraph,
    stance: FootholdId,
    other: FootholdId,
) -> Result<TransitionId, ArenaFull> {
    if let Some(known) = graph.find(stance, other) {
        return Ok(known);
    }
    graph.connect(stance, other)?;
    Ok(graph.transitions().len() as TransitionId - 2)
}

/// Whether stage M has failed on a step: on its motions, or on a configuration at its end.
fn is_excluded(bench: &Workbench<'_>, edge: ModeEdge) -> bool {
    let (graph, edges) = (&bench.roadmap.graph, &bench.roadmap.edges);
    let twin = ModeGraph::twin(edge.to);
    let is_unsampled = |id: TransitionId| {
        let transition = &graph.transitions()[id as usize];
        !transition.is_found() && transition.attempts > ATTEMPTS_MAX
    };
    is_unsampled(edge.to)
        || is_unsampled(twin)
        || edges.get(edge.from, edge.to).failures > 0
        || edges.get(edge.to, twin).failures > 0
}

/// The primitive between two transitions of a path.
fn trajectory(bench: &Workbench<'_>, edge: ModeEdge) -> Option<PrimitiveTrajectory> {
    let (constraints, gait) = (&bench.context.constraints, bench.context.preparation.gait());
    let graph = &bench.roadmap.graph;
    let (stance, touched) = graph.pair(edge.from);
    let made = if edge.to == ModeGraph::twin(edge.from) {
        PrimitiveTrajectory::shift(constraints, gait, [stance, touched])
    } else {
        PrimitiveTrajectory::swing(constraints, gait, stance, [touched, graph.pair(edge.to).1])
    };
    made.ok()
}
