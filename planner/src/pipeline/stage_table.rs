//! The transitions between the stages, as data. docs/ARCHITECTURE.md shows them as a diagram; a
//! test compares the two.

use crate::pipeline::stage::{Event, Stage};

/// A row of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transition {
    /// The stage that ends.
    pub stage: Stage,
    /// The event that ends it.
    pub event: Event,
    /// The stage that follows.
    pub next: Stage,
}

const fn row(stage: Stage, event: Event, next: Stage) -> Transition {
    Transition { stage, event, next }
}

/// All transitions. In addition, every stage leads to [`Stage::Over`] where an arena is full or
/// the work limit is reached.
pub const TRANSITIONS: [Transition; 48] = [
    row(Stage::Endpoints, Event::Done, Stage::Route),
    row(Stage::Endpoints, Event::Invalid, Stage::Over),
    row(Stage::Endpoints, Event::OtherMethod, Stage::Method),
    row(Stage::Method, Event::Complete, Stage::Shortcuts),
    row(Stage::Method, Event::NoWorkLeft, Stage::SmoothPath),
    row(Stage::Method, Event::Invalid, Stage::Over),
    row(Stage::Route, Event::Near, Stage::DirectSteps),
    row(Stage::DirectSteps, Event::Done, Stage::Segments),
    row(Stage::DirectSteps, Event::NewRoute, Stage::Route),
    row(Stage::Route, Event::NoRouteYet, Stage::Relaxation),
    row(Stage::Relaxation, Event::Done, Stage::Route),
    row(Stage::Relaxation, Event::Impossible, Stage::Over),
    row(Stage::Route, Event::NewRoute, Stage::Segmentation),
    row(Stage::Route, Event::Detour, Stage::Footholds),
    row(Stage::Route, Event::NoFurtherRoute, Stage::Connections),
    row(Stage::Segmentation, Event::Done, Stage::Footholds),
    row(Stage::Footholds, Event::Done, Stage::Connections),
    row(Stage::Connections, Event::NewRoute, Stage::Primitives),
    row(Stage::Connections, Event::Done, Stage::Segments),
    row(Stage::Primitives, Event::Done, Stage::Segments),
    row(Stage::Segments, Event::GrowRoutes, Stage::RouteGrowth),
    row(Stage::RouteGrowth, Event::Done, Stage::Segments),
    row(Stage::Segments, Event::Failed, Stage::Recovery),
    row(Stage::Segments, Event::NeedsEstimates, Stage::Estimates),
    row(Stage::Segments, Event::NeedsSequence, Stage::Sequence),
    row(Stage::Segments, Event::NeedsConfigurations, Stage::Configurations),
    row(Stage::Segments, Event::NeedsMotions, Stage::Motions),
    row(Stage::Segments, Event::LeaveRoute, Stage::Route),
    row(Stage::Segments, Event::Complete, Stage::Shortcuts),
    row(Stage::Segments, Event::NoWorkLeft, Stage::SmoothPath),
    row(Stage::Estimates, Event::Done, Stage::Segments),
    row(Stage::Sequence, Event::Done, Stage::Segments),
    row(Stage::Configurations, Event::Done, Stage::Segments),
    row(Stage::Motions, Event::Done, Stage::Segments),
    row(Stage::Recovery, Event::Done, Stage::Segments),
    row(Stage::Recovery, Event::NeedsFootholds, Stage::Footholds),
    row(Stage::Recovery, Event::Detour, Stage::Route),
    row(Stage::Recovery, Event::OtherRoute, Stage::Route),
    row(Stage::Recovery, Event::LongSteps, Stage::Connections),
    row(Stage::Recovery, Event::Near, Stage::DirectSteps),
    row(Stage::Shortcuts, Event::Done, Stage::SmoothPath),
    row(Stage::SmoothPath, Event::Done, Stage::Chunks),
    row(Stage::SmoothPath, Event::Blocked, Stage::Over),
    row(Stage::Chunks, Event::NeedsPath, Stage::SmoothPath),
    row(Stage::Chunks, Event::Found, Stage::Over),
    row(Stage::Chunks, Event::Improve, Stage::Improvement),
    row(Stage::Improvement, Event::NewWalk, Stage::SmoothPath),
    row(Stage::Improvement, Event::Found, Stage::Over),
];

/// The stage that follows `stage` after `event`.
///
/// # Panics
/// The table has no row for this event of this stage.
pub(crate) fn next(stage: Stage, event: Event) -> Stage {
    if event == Event::Continue {
        return stage;
    }
    let is_row = |row: &&Transition| row.stage == stage && row.event == event;
    match TRANSITIONS.iter().find(is_row) {
        Some(row) => row.next,
        None => panic!("no row for {event:?} of {stage:?}"),
    }
}
