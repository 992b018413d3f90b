//! Runs another method in place of the stages from the route to recovery.

use crate::base::capacity::ArenaFull;
use crate::methods::method_search::MethodSearch;
use crate::methods::workbench::{MethodCounts, MethodEvent, Workbench};
use crate::motion::ids::{GOAL, START};
use crate::pipeline::outcome::Outcome;
use crate::pipeline::search::{Search, SearchStats};
use crate::pipeline::shortcut_stage::shortcut_work_end;
use crate::pipeline::stage::{Event, WorkCategory};
use crate::preparation::planning_context::PlanningContext;

/// The search of another method; none for the full planner.
#[derive(Debug)]
pub(crate) struct MethodStage {
    /// The method's search.
    pub search: Option<MethodSearch>,
}

impl MethodStage {
    /// Advances the method by at most `budget` units of work.
    ///
    /// # Errors
    /// An arena is full.
    pub fn step(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        budget: u64,
    ) -> Result<Event, ArenaFull> {
        let Some(method) = &mut self.search else { return Ok(Event::Invalid) };
        let mut bench = Workbench {
            context,
            roadmap: &mut search.roadmap,
            batch: &mut search.batch,
            scratch: &mut search.footholds.scratch[0],
            counts: MethodCounts::default(),
        };
        let event = method.step(&mut bench, budget);
        add(&mut search.stats, &bench.counts);
        match event? {
            MethodEvent::Continue => Ok(Event::Continue),
            MethodEvent::NotExpressible(reason) => {
                search.outcome = Some(Outcome::NotExpressible(reason));
                Ok(Event::Invalid)
            }
            MethodEvent::Exhausted(reason) => {
                search.outcome = Some(Outcome::MethodExhausted(reason));
                Ok(Event::Invalid)
            }
            MethodEvent::Found => {
                search.segmentation.begin(START);
                search.segmentation.push(GOAL, 0);
                search.segmentation.complete(0, method.sequence())?;
                search.segmentation.join()?;
                let has_work = shortcut_work_end(context, search) > search.stats.work;
                Ok(if has_work { Event::Complete } else { Event::NoWorkLeft })
            }
        }
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.search.as_ref().map_or(0, MethodSearch::bytes)
    }
}

/// Adds the counts of one step.
fn add(stats: &mut SearchStats, counts: &MethodCounts) {
    stats.work += counts.work();
    for (category, work) in [
        (WorkCategory::Route, counts.route),
        (WorkCategory::Footholds, counts.placements),
        (WorkCategory::Transitions, counts.transitions),
        (WorkCategory::Sequence, counts.sequence),
        (WorkCategory::Configurations, counts.configurations),
        (WorkCategory::Motions, counts.motions),
    ] {
        stats.work_by_category[category as usize] += work;
    }
    stats.sequences += counts.sequences;
    stats.routes += counts.routes;
    stats.transitions_found += counts.transitions_found;
    stats.motions_found += counts.motions_found;
    for (total, count) in stats.rejections.iter_mut().zip(counts.rejections) {
        *total += count;
    }
}
