//! The stages of the pipeline, the events that end a stage, and the categories of work in reports.

/// A stage of the search. `stages.rs` says what each makes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// The robot stands on the start and on the goal [Grey 4.4.1].
    Endpoints,
    /// Stage P finds a guide route [Grey 3, 4.1-4.3].
    Route,
    /// The relaxed problem shows whether there can be a plan.
    Relaxation,
    /// The fewest steps straight to a near goal are searched and tested [Grey 4.4.2].
    DirectSteps,
    /// The route is divided into segments [Grey 3.2].
    Segmentation,
    /// Footholds are sampled along the route [Grey 4.2, 4.4.4].
    Footholds,
    /// Footholds are connected by transitions [Grey 4.4.2].
    Connections,
    /// Primitives give the motions along possible edges [Grey 3.2, 4.4.5].
    Primitives,
    /// Stage P grows further routes beside the current one [Grey 3.2].
    RouteGrowth,
    /// The next task of the segments is chosen.
    Segments,
    /// Prior costs of transitions are estimated [Grey 4.4.2].
    Estimates,
    /// The cheapest sequence of transitions is searched [Grey 4.4.2].
    Sequence,
    /// Transitions get configurations [Grey 4.4.2].
    Configurations,
    /// Edges within a mode get motions [Grey 4.4.3].
    Motions,
    /// A recovery action is chosen for a segment that failed [Grey 4.4.4].
    Recovery,
    /// Motions are shortened [Grey 4.4.6].
    Shortcuts,
    /// The next part of the smooth path over the plan is made.
    SmoothPath,
    /// The plan's chunks are written and finalized, as far as the path is made.
    Chunks,
    /// Another walk is made from the plan, to see whether it takes less time.
    Improvement,
    /// Another method than the stages from `Route` to `Recovery` searches the walk.
    Method,
    /// The search has ended.
    Over,
}

impl Stage {
    /// The category that its work counts for; none for stages that spend no work, and for another
    /// method, which counts its work itself.
    pub fn category(self) -> Option<WorkCategory> {
        match self {
            Self::Endpoints => Some(WorkCategory::Endpoints),
            Self::Relaxation => Some(WorkCategory::Relaxation),
            Self::Route | Self::RouteGrowth | Self::Segmentation => Some(WorkCategory::Route),
            Self::Footholds | Self::DirectSteps => Some(WorkCategory::Footholds),
            Self::Connections | Self::Estimates => Some(WorkCategory::Transitions),
            Self::Sequence => Some(WorkCategory::Sequence),
            Self::Configurations => Some(WorkCategory::Configurations),
            Self::Primitives | Self::Motions => Some(WorkCategory::Motions),
            Self::Shortcuts | Self::SmoothPath => Some(WorkCategory::Shortcuts),
            Self::Chunks => Some(WorkCategory::Chunks),
            Self::Improvement => Some(WorkCategory::Improvement),
            Self::Segments | Self::Recovery | Self::Method | Self::Over => None,
        }
    }
}

/// What a step of a stage came to. [`Event::Continue`] keeps the stage, every other event leads to
/// the stage that `stage_table.rs` names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// The stage has more to do.
    Continue,
    /// The stage is complete.
    Done,
    /// The robot cannot stand at the start or at the goal, or a method ends without a plan.
    Invalid,
    /// Another method is to search the walk.
    OtherMethod,
    /// The goal is near: direct steps come before any guide route.
    Near,
    /// There is a new guide route.
    NewRoute,
    /// The route has a detour within the current segment.
    Detour,
    /// Stage P finds no first route quickly, or one that meets C_N alone.
    NoRouteYet,
    /// The relaxed problem has no solution.
    Impossible,
    /// Stage P finds no further route.
    NoFurtherRoute,
    /// Further routes are to grow.
    GrowRoutes,
    /// Stage M turns to another live route.
    OtherRoute,
    /// A segment's sequence cannot be completed.
    Failed,
    /// Some transitions of a sequence have no estimate.
    NeedsEstimates,
    /// A segment needs a sequence.
    NeedsSequence,
    /// A segment's transitions need configurations.
    NeedsConfigurations,
    /// A segment's edges need motions.
    NeedsMotions,
    /// A segment cannot be completed on this route.
    LeaveRoute,
    /// All segments are complete, and work is left for shortcuts.
    Complete,
    /// All segments are complete, and no work is left for shortcuts.
    NoWorkLeft,
    /// More footholds are needed.
    NeedsFootholds,
    /// Footholds beyond the reach of primitives are to be connected.
    LongSteps,
    /// The plan is complete, and is to be improved.
    Improve,
    /// Another walk is to be smoothed and timed.
    NewWalk,
    /// The next part of the smooth path is to be made.
    NeedsPath,
    /// No smooth path continues the part that does not change any more.
    Blocked,
    /// The plan is complete.
    Found,
}

/// A category of work in reports. Several stages may count for one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum WorkCategory {
    /// RestState on the start and on the goal.
    Endpoints,
    /// Finding a guide route and dividing it into segments.
    Route,
    /// Solving the relaxed problem.
    Relaxation,
    /// Sampling footholds.
    Footholds,
    /// Connecting footholds and estimating the costs of their transitions.
    Transitions,
    /// Searching the cheapest sequence of transitions.
    Sequence,
    /// Sampling configurations.
    Configurations,
    /// Finding motions, those of primitives included.
    Motions,
    /// Shortening and smoothing motions.
    Shortcuts,
    /// Writing and finalizing chunks.
    Chunks,
    /// Making and timing other walks after the first plan.
    Improvement,
}

impl WorkCategory {
    /// Number of categories.
    pub const COUNT: usize = 11;
    /// Names in reports, by discriminant.
    pub const NAMES: [&'static str; Self::COUNT] = [
        "endpoints",
        "route",
        "relaxation",
        "footholds",
        "transitions",
        "sequence",
        "configurations",
        "motions",
        "shortcuts",
        "chunks",
        "improvement",
    ];
}
