//! A plan whose first chunks are sent while the rest of it is made.

use surefoot_planner::Planner;
use surefoot_planner::channel::chunk_source::{ChunkSource, SourceState};
use surefoot_shared_types::message::PlanChunk;

use crate::commands::search_loop::{SearchLoop, Searched};
use crate::report::command_error::CommandError;
use crate::report::event::{PlanResult, Planned, RoleEvent};

/// Work units between two polls of the transport: a few milliseconds.
const WORK_PER_POLL: u64 = 64;

/// What a growing plan calls.
pub(super) struct Callbacks<'a> {
    /// Reports progress.
    pub emit: &'a mut dyn FnMut(&RoleEvent) -> Result<(), CommandError>,
    /// Receives the plan once it is complete.
    pub on_found: &'a mut dyn FnMut(&Planner, &Planned) -> Result<(), CommandError>,
}

/// A search whose first chunk is final, and its result once it has ended.
#[derive(Debug)]
pub(super) struct OpenSearch {
    pub planner: Planner,
    pub search: SearchLoop,
    pub planned: Option<Planned>,
    /// Whether a complete plan was passed on.
    is_reported: bool,
}

impl OpenSearch {
    /// A search with this limit of its work.
    pub fn begin(planner: Planner, work_max: u64) -> Self {
        let search = SearchLoop::begin(work_max);
        Self { planner, search, planned: None, is_reported: false }
    }

    /// Searches until the first chunk is final, or to the end. Returns `false` if a signal comes or
    /// `is_over` returns true before.
    ///
    /// # Errors
    /// Reporting fails.
    pub fn make_first_chunk(
        &mut self,
        emit: &mut dyn FnMut(&RoleEvent) -> Result<(), CommandError>,
        is_over: &mut dyn FnMut() -> bool,
    ) -> Result<bool, CommandError> {
        match self.search.until_first_chunk(&mut self.planner, emit, is_over)? {
            Searched::Interrupted => return Ok(false),
            Searched::FirstChunk => {}
            Searched::Ended(planned) => self.planned = Some(*planned),
        }
        Ok(true)
    }

    /// Whether the search has ended without a complete plan.
    pub fn has_failed(&self) -> bool {
        self.planned.as_ref().is_some_and(|planned| planned.result != PlanResult::Found)
    }

    /// Whether it has ended without any chunk to deliver.
    pub fn is_without_chunks(&self) -> bool {
        self.has_failed() && self.planner.final_chunks().is_empty()
    }

    /// Whether its improvement was stopped before all its work.
    pub fn is_stopped(&self) -> bool {
        let improved = self.planned.as_ref().and_then(|planned| planned.improved);
        improved.is_some_and(|improved| improved.stopped)
    }

    /// Ends the search.
    ///
    /// # Errors
    /// A signal comes, or reporting fails.
    pub fn finish(&mut self, callbacks: &mut Callbacks<'_>) -> Result<(), CommandError> {
        if self.planned.is_none() {
            self.planned = Some(self.search.run(&mut self.planner, callbacks.emit)?);
        }
        self.report(callbacks)
    }

    /// Passes a complete plan on, once.
    fn report(&mut self, callbacks: &mut Callbacks<'_>) -> Result<(), CommandError> {
        let found = self.planned.as_ref().filter(|planned| planned.result == PlanResult::Found);
        let Some(planned) = found.filter(|_| !self.is_reported) else { return Ok(()) };
        self.is_reported = true;
        (callbacks.on_found)(&self.planner, planned)
    }
}

/// The chunks of an open search.
pub(super) struct GrowingPlan<'a> {
    open: &'a mut OpenSearch,
    callbacks: Callbacks<'a>,
    /// The first error of a callback. It ends the plan.
    error: Option<CommandError>,
}

impl<'a> GrowingPlan<'a> {
    /// The chunks of a search that goes on between two polls.
    ///
    /// # Errors
    /// The search has ended, and a callback fails.
    pub fn new(
        open: &'a mut OpenSearch,
        mut callbacks: Callbacks<'a>,
    ) -> Result<Self, CommandError> {
        open.report(&mut callbacks)?;
        Ok(Self { open, callbacks, error: None })
    }

    /// Ends the search, also where the delivery has ended before; without its plan if the delivery
    /// was stopped.
    ///
    /// # Errors
    /// A callback failed, or a signal comes.
    pub fn finish(mut self, is_stopped: bool) -> Result<(), CommandError> {
        if let Some(error) = self.error.take() {
            return Err(error);
        }
        if is_stopped && self.open.planned.is_none() {
            let planned = self.open.search.interrupted(&self.open.planner);
            return (self.callbacks.emit)(&RoleEvent::Planned(planned));
        }
        self.open.finish(&mut self.callbacks)
    }
}

impl ChunkSource for GrowingPlan<'_> {
    fn chunks(&self) -> &[PlanChunk] {
        self.open.planner.final_chunks()
    }

    fn state(&self) -> SourceState {
        match &self.open.planned {
            _ if self.error.is_some() => SourceState::Ended,
            None => SourceState::Open,
            Some(planned) if planned.result == PlanResult::Found => SourceState::Complete,
            Some(_) => SourceState::Ended,
        }
    }

    fn advance(&mut self) {
        let OpenSearch { planner, search, .. } = &mut *self.open;
        let step = search.step(planner, WORK_PER_POLL, self.callbacks.emit);
        let ended = step.and_then(|planned| {
            self.open.planned = planned;
            self.open.report(&mut self.callbacks)
        });
        self.error = ended.err();
    }
}
