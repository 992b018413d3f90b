//! Chooses the next task of the segments, without any work.

use crate::base::capacity::ArenaFull;
use crate::motion::transition_sequence::Objective;
use crate::pipeline::search::Search;
use crate::pipeline::shortcut_stage::shortcut_work_end;
use crate::pipeline::stage::Event;
use crate::preparation::planning_context::PlanningContext;

/// Chooses the stage that the segments need next. Has no state: [`Search`] has the segments.
#[derive(Debug, Default)]
pub(crate) struct SegmentStage;

impl SegmentStage {
    /// Chooses the next task. Begins another route where a segment must be left; joins the
    /// sequences where all segments are complete.
    ///
    /// # Errors
    /// The plan has too many transitions.
    pub fn step(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        _budget: u64,
    ) -> Result<Event, ArenaFull> {
        if search.guide.live.owed() > 0 {
            return Ok(Event::GrowRoutes);
        }
        let event = search.segments.next();
        match event {
            Event::LeaveRoute => {
                search.segments.current_mut().seek(Objective::Feasible);
                if !std::mem::take(&mut search.direct.is_active) {
                    search.route.restart();
                }
                search.segmentation.cancel_detour();
            }
            Event::Complete => {
                search.segmentation.join()?;
                if shortcut_work_end(context, search) <= search.stats.work {
                    return Ok(Event::NoWorkLeft);
                }
            }
            _ => {}
        }
        Ok(event)
    }
}
