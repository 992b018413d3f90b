//! Other walks made from a plan: a foothold in another place, or a step less with each foot.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::rotation_about;

use crate::base::capacity::ArenaFull;
use crate::base::random::Random;
use crate::constraints::foothold::{Foothold, left_and_right};
use crate::motion::ids::{FootholdId, GOAL, START, TransitionId, boundary_of};
use crate::motion::mode_graph::ModeGraph;
use crate::motion::roadmap::{ModeEdge, Roadmap};
use crate::pipeline::foothold_sampling::FootholdSampler;
use crate::pipeline::search::Search;
use crate::preparation::planning_context::PlanningContext;

/// Greatest offsets (m) of a foothold that is moved at random, far and near.
const SHIFTS: [f64; 2] = [0.12, 0.04];
/// Greatest turn (rad) of such a foothold for each metre of the greatest offset.
const TURN_PER_SHIFT: f64 = 2.0;
/// Largest part of the way to its aim that a foothold is moved.
const PART_MAX: f64 = 1.0;
/// Marks the names of random placements.
const NAME: u64 = 1 << 43;

/// Where a foothold is moved.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Shift {
    /// Anywhere within this distance along each axis, m.
    Random(f64),
    /// Towards the middle between the places of its foot before and after it.
    Between,
    /// Towards the heading of the stance foot and the width at which the robot walks.
    Aside,
}

impl Shift {
    const KINDS: usize = 4;

    fn of(kind: usize) -> Self {
        match kind {
            0 => Self::Between,
            1 => Self::Aside,
            kind => Self::Random(SHIFTS[kind % SHIFTS.len()]),
        }
    }
}

/// The nodes of a plan, to be changed. Allocated once.
#[derive(Debug)]
pub(crate) struct Walk {
    pub nodes: Vec<TransitionId>,
}

impl Walk {
    /// The index of the node before each swing.
    pub fn swings<'a>(&'a self, roadmap: &'a Roadmap) -> impl Iterator<Item = usize> + Clone + 'a {
        let edge =
            move |index: &usize| ModeEdge { from: self.nodes[*index], to: self.nodes[index + 1] };
        (0..self.nodes.len() - 1).filter(move |index| !roadmap.is_double(edge(index)))
    }

    /// Becomes another walk.
    pub fn copy(&mut self, other: &Self) {
        self.nodes.clear();
        self.nodes.extend_from_slice(&other.nodes);
    }

    /// Takes the nodes of a plan, without those of boundaries between segments.
    pub fn take(&mut self, plan: &[TransitionId]) {
        let last = plan.len() - 1;
        let is_kept = |(index, node): &(usize, &TransitionId)| {
            *index == 0 || *index == last || boundary_of(**node).is_none()
        };
        self.nodes.clear();
        self.nodes.extend(plan.iter().enumerate().filter(is_kept).map(|(_, node)| *node));
    }

    /// The foothold on which the swing after a node lands.
    fn landing(&self, graph: &ModeGraph, swing: usize) -> FootholdId {
        let node = self.nodes[swing + 1];
        graph.transitions()[node as usize].other
    }

    /// Moves the foothold on which the swing after a node lands. Returns whether there is such a
    /// walk.
    ///
    /// # Errors
    /// An arena is full.
    pub fn move_foothold(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        swing: usize,
        random: &mut Random,
    ) -> Result<bool, ArenaFull> {
        let aim = Shift::of(random.below(Shift::KINDS));
        let known = self.landing(&search.roadmap.graph, swing);
        if is_at_an_end(&search.roadmap, known) {
            return Ok(false);
        }
        let foothold = &search.roadmap.graph.footholds()[known as usize];
        let (limb, crouch) = (foothold.limb, foothold.crouch);
        let Some(pose) = self.aimed(context, &search.roadmap, (swing, aim), random) else {
            return Ok(false);
        };
        let graph = &mut search.roadmap.graph;
        let before = graph.footholds().len();
        let name = (NAME | u64::from(known), random.bits());
        let scratch = &mut search.footholds.scratch[0];
        FootholdSampler::new(context).add_at(&pose, limb, name, graph, scratch)?;
        if graph.footholds().len() == before {
            return Ok(false);
        }
        let moved = before as FootholdId;
        graph.set_crouch(moved, crouch);
        self.replace(context, graph, swing + 1, [known, moved])
    }

    /// Where the foothold on which the swing after a node lands is moved; `None` where that is
    /// nowhere.
    fn aimed(
        &self,
        context: &PlanningContext,
        roadmap: &Roadmap,
        (swing, aim): (usize, Shift),
        random: &mut Random,
    ) -> Option<Pose> {
        let graph = &roadmap.graph;
        let footholds = graph.footholds();
        let pose = |id: FootholdId| footholds[id as usize].world_from_sole;
        let landing = self.landing(graph, swing);
        let here = pose(landing);
        let part = random.uniform(0.0, PART_MAX);
        match aim {
            Shift::Random(shift) => Some(nearby(&here, shift, random)),
            Shift::Between => {
                let from = match boundary_of(self.nodes[swing]) {
                    Some(boundary) => {
                        roadmap.boundary(boundary).footholds[footholds[landing as usize].limb]
                    }
                    None => graph.transitions()[self.nodes[swing] as usize].other,
                };
                let next = self.swings(roadmap).filter(|next| *next > swing).nth(1)?;
                let to = self.landing(graph, next);
                let middle = 0.5 * (pose(from).translation + pose(to).translation);
                Some(Pose::from_parts(here.translation.lerp(middle, part), here.rotation))
            }
            Shift::Aside => {
                let stance = graph.transitions()[self.nodes[swing + 1] as usize].stance;
                let stance = pose(stance);
                let from_stance =
                    stance.rotation.inverse() * (here.translation - stance.translation);
                let side = from_stance.y.signum();
                let width = context.preparation.step_limits().walking_width();
                let shift = (side * width - from_stance.y) * part;
                let moved = here.translation + stance.rotation * (DVec3::Y * shift);
                Some(Pose::from_parts(moved, here.rotation.slerp(stance.rotation, part)))
            }
        }
    }

    /// Leaves out the step after a node and the next one, which the other foot makes. Returns
    /// whether there is such a walk.
    ///
    /// # Errors
    /// An arena is full.
    pub fn leave_out_steps(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        swing: usize,
    ) -> Result<bool, ArenaFull> {
        let Search { roadmap, .. } = search;
        let Some(&[touch, twin, lift, landed, last]) = self
            .nodes
            .get(swing + 1..swing + 6)
            .and_then(|nodes| <&[TransitionId; 5]>::try_from(nodes).ok())
        else {
            return Ok(false);
        };
        if boundary_of(last).is_some()
            || twin != ModeGraph::twin(touch)
            || landed != ModeGraph::twin(lift)
        {
            return Ok(false);
        }
        let transitions = roadmap.graph.transitions();
        let [stance, second] =
            [transitions[touch as usize].stance, transitions[landed as usize].stance];
        if is_at_an_end(roadmap, second) || transitions[last as usize].stance != second {
            return Ok(false);
        }
        self.nodes.drain(swing + 1..swing + 5);
        self.replace(context, &mut roadmap.graph, swing + 1, [second, stance])
    }

    /// Replaces a foothold in the nodes from `first` on, as far as they use it. Returns whether the
    /// transitions may exist.
    fn replace(
        &mut self,
        context: &PlanningContext,
        graph: &mut ModeGraph,
        first: usize,
        [known, other]: [FootholdId; 2],
    ) -> Result<bool, ArenaFull> {
        for node in &mut self.nodes[first..] {
            if boundary_of(*node).is_some() {
                return Ok(true);
            }
            let transition = &graph.transitions()[*node as usize];
            let feet = [transition.stance, transition.other];
            if !feet.contains(&known) {
                return Ok(true);
            }
            let [a, b] = feet.map(|foot| if foot == known { other } else { foot });
            match transition_between(context, graph, [a, b])? {
                Some(id) => *node = id,
                None => return Ok(false),
            }
        }
        Ok(true)
    }
}

/// Whether the robot stands on a foothold at the start or at the goal.
fn is_at_an_end(roadmap: &Roadmap, foothold: FootholdId) -> bool {
    [START, GOAL].iter().any(|end| roadmap.boundary(*end).footholds.contains(&foothold))
}

/// A random pose near a sole, turned about the vertical.
fn nearby(world_from_sole: &Pose, shift: f64, random: &mut Random) -> Pose {
    let offset = DVec3::new(random.uniform(-shift, shift), random.uniform(-shift, shift), 0.0);
    let turn = TURN_PER_SHIFT * shift;
    let turn = rotation_about(DVec3::Z, random.uniform(-turn, turn));
    Pose::from_parts(world_from_sole.translation + offset, world_from_sole.rotation * turn)
}

/// The transition `(stance | other)`, made if there is none; `None` where the robot makes no such
/// step, or its feet collide.
fn transition_between(
    context: &PlanningContext,
    graph: &mut ModeGraph,
    [stance, other]: [FootholdId; 2],
) -> Result<Option<TransitionId>, ArenaFull> {
    if let Some(known) = graph.find(stance, other) {
        return Ok(Some(known));
    }
    let [a, b]: [&Foothold; 2] = [stance, other].map(|id| &graph.footholds()[id as usize]);
    if a.limb == b.limb {
        return Ok(None);
    }
    let soles = left_and_right(a, b).map(|foothold| &foothold.world_from_sole);
    let may_step = context.preparation.step_limits().may_step(soles)
        && !context.constraints.collision.feet_hit(soles);
    if !may_step {
        return Ok(None);
    }
    graph.connect(stance, other)?;
    Ok(graph.find(stance, other))
}
