//! Samples footholds along the guide route, and near steps that are not found
//! [Grey 4.2, 4.4.4].

use std::ops::Range;

use crate::base::capacity::ArenaFull;
use crate::base::random::{Random, Stream};
use crate::base::work_budget::items_in;
use crate::constraints::foothold::Foothold;
use crate::foot_placement::Scratch;
use crate::motion::ids::TransitionId;
use crate::motion::mode_costs::ModeId;
use crate::pipeline::bottlenecks::most_attempted_mode;
use crate::pipeline::foothold_order::FootholdOrder;
use crate::pipeline::foothold_sampling::{FootholdSampler, PERTURBATIONS_MAX};
use crate::pipeline::search::Search;
use crate::pipeline::stage::Event;
use crate::preparation::planning_context::PlanningContext;

/// Adds footholds to Gamma_M, as [`FootholdOrder`] says. A sweep and sampling near a transition
/// take one unit of work for each foot and each transition, a perturbation one for each attempt, a
/// uniform round one for each foothold.
/// Has no state: [`Search`] has the order.
#[derive(Debug, Default)]
pub(crate) struct FootholdStage;

impl FootholdStage {
    /// Advances the current order.
    ///
    /// # Errors
    /// The foothold arena is full.
    pub fn step(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        budget: u64,
    ) -> Result<Event, ArenaFull> {
        match search.footholds.order {
            FootholdOrder::Sweep { next } => sweep(context, search, next),
            FootholdOrder::SampleNear { index } => sample_near(context, search, index),
            FootholdOrder::Perturb { index, tried, end } => {
                perturb(context, search, (index, tried, end), budget)
            }
            FootholdOrder::Uniform { left } => sample_uniformly(context, search, left),
        }
    }
}

/// Samples footholds of one foot at one vertex, if it is selected. `next` is twice the vertex plus
/// the foot.
fn sweep(context: &PlanningContext, search: &mut Search, next: usize) -> Result<Event, ArenaFull> {
    search.stats.work += 1;
    let route = search.route.route();
    if next == 2 * route.vertex_count() {
        search.stats.sweeps += 1;
        search.segments.current_mut().sweeps += 1;
        return Ok(Event::Done);
    }
    search.footholds.order = FootholdOrder::Sweep { next: next + 1 };
    let (vertex, limb) = (next / 2, next % 2);
    if !search.footholds.selection.contains(vertex) {
        return Ok(Event::Continue);
    }
    let sampler = FootholdSampler::new(context);
    let (graph, scratch) = (&mut search.roadmap.graph, &mut search.footholds.scratch[0]);
    let (sweeps, name) = (search.segments.current().sweeps, search.stats.sweeps);
    let known = search.route.placements(vertex);
    if sweeps == 0 && !known.is_empty() {
        for placed in known.iter().filter(|placed| placed.limb == limb) {
            sampler.reuse(placed, route.is_used_by_primitives(vertex, placed), graph, scratch)?;
        }
        sampler.toe_out(route, (vertex, limb), name, graph, scratch)?;
    } else {
        sampler.sweep_vertex(route, (vertex, limb), (sweeps, name), graph, scratch)?;
    }
    Ok(Event::Continue)
}

/// Samples near both footholds of the transition at `index` of the current sequence, if it has no
/// configuration or belongs to the mode in which most attempts failed [Grey 4.4.4]. Both are moved
/// and turned alike, so that the step stays similar. After the last transition, all are perturbed.
fn sample_near(
    context: &PlanningContext,
    search: &mut Search,
    index: usize,
) -> Result<Event, ArenaFull> {
    search.stats.work += 1;
    let sequence = &search.segments.current().sequence;
    let Some(&id) = sequence.get(index) else {
        search.footholds.order = FootholdOrder::Perturb { index: 0, tried: 0, end: sequence.len() };
        return Ok(Event::Continue);
    };
    search.footholds.order = FootholdOrder::SampleNear { index: index + 1 };
    let graph = &mut search.roadmap.graph;
    let transition = &graph.transitions()[id as usize];
    let (is_found, footholds) = (transition.is_found(), [transition.stance, transition.other]);
    let is_its_mode = |mode| ModeId::of(graph, id).contains(&mode);
    if is_found
        && !most_attempted_mode(graph, &search.roadmap.costs, sequence).is_some_and(is_its_mode)
    {
        return Ok(Event::Continue);
    }
    let sampler = FootholdSampler::new(context);
    let name = (u64::from(id) | 1 << 41, search.stats.sequences);
    for foothold in footholds {
        let foothold = &graph.footholds()[foothold as usize];
        let (limb, pose) = (foothold.limb, foothold.world_from_sole);
        sampler.sample_near(&pose, limb, name, graph, &mut search.footholds.scratch[0])?;
    }
    Ok(Event::Continue)
}

/// Perturbs the transition at `index` of the current sequence, unless it has a configuration. Both
/// footholds move together: a step at the limit of the robot's reach needs both in the right
/// places.
fn perturb(
    context: &PlanningContext,
    search: &mut Search,
    (index, tried, end): (usize, usize, usize),
    budget: u64,
) -> Result<Event, ArenaFull> {
    let Some(&id) = search.segments.current().sequence[..end].get(index) else {
        search.stats.work += 1;
        return Ok(Event::Done);
    };
    let next = FootholdOrder::Perturb { index: index + 1, tried: 0, end };
    if tried == PERTURBATIONS_MAX || search.roadmap.graph.transitions()[id as usize].is_found() {
        search.stats.work += 1;
        search.footholds.order = next;
        return Ok(Event::Continue);
    }
    let attempts = tried..PERTURBATIONS_MAX.min(tried + items_in(budget, PERTURBATIONS_MAX));
    let found = first_perturbation(context, search, id, attempts.clone());
    let tried_now = found.as_ref().map_or(attempts.end, |(last, _)| last + 1);
    search.stats.work += (tried_now - tried) as u64;
    search.footholds.order = match found {
        None => FootholdOrder::Perturb { index, tried: tried_now, end },
        Some((_, footholds)) => {
            search.roadmap.graph.add_pair(footholds)?;
            next
        }
    };
    Ok(Event::Continue)
}

/// The first of several perturbations of a transition that is possible, with its index.
fn first_perturbation(
    context: &PlanningContext,
    search: &mut Search,
    id: TransitionId,
    attempts: Range<usize>,
) -> Option<(usize, [Foothold; 2])> {
    let sampler = FootholdSampler::new(context);
    let (graph, sequences) = (&search.roadmap.graph, search.stats.sequences);
    let perturb = |attempt: usize, scratch: &mut Scratch| {
        sampler.perturbation(id, (attempt as u64, sequences), graph, scratch)
    };
    context.threads.find_first(attempts, search.footholds.scratch.each_mut(), perturb)
}

/// Samples one foothold of a round of uniform ones; `left` are left.
fn sample_uniformly(
    context: &PlanningContext,
    search: &mut Search,
    left: u32,
) -> Result<Event, ArenaFull> {
    search.stats.work += 1;
    if left == 0 {
        return Ok(Event::Done);
    }
    search.footholds.order = FootholdOrder::Uniform { left: left - 1 };
    let rounds = search.footholds.uniform.rounds;
    let mut random = Random::new(context.seed, Stream::UniformFoothold, rounds, u64::from(left));
    let route = search.route.route();
    let vertex = random.below(route.vertex_count());
    let (around, uniform) = (route.pose(vertex).position, &search.footholds.uniform);
    let ideal = uniform.draw(around, &mut random);
    let may_use = |position| uniform.may_use(around, position);
    let sampler = FootholdSampler::new(context);
    let (graph, scratch) = (&mut search.roadmap.graph, &mut search.footholds.scratch[0]);
    let name = (u64::from(left) | 1 << 43, rounds);
    sampler.add_within(&ideal, left as usize % 2, name, may_use, (graph, scratch))?;
    Ok(Event::Continue)
}
