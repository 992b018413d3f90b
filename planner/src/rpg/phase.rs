//! The phases of a search, as the head of `rpg.rs` draws them, and the tally of what was done in
//! them.

use crate::constraints::constraints::Rejection;
use crate::motion::mode_graph::FootholdId;
use crate::motion::shortcut::Pass;
use crate::outcome::Outcome;
use crate::possibility::LabelStats;
use crate::stage::Stage;

/// What a search is about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Phase {
    Ends,
    Route,
    Stoop,
    Cut { station: usize },
    Seed { next: usize },
    Connect { next: FootholdId },
    Scatter { index: usize },
    Vary { index: usize, tried: usize, end: usize },
    Primitive,
    Emit,
    Sequence,
    Judge,
    Sample,
    Move,
    Weigh { next: usize },
    Polish(Pass),
    Assemble { next: usize },
    Seal,
    Over(Outcome),
}

impl Phase {
    /// Whether the phase counts its own units of work; a piece of any other is one unit.
    pub(crate) fn counts(&self) -> bool {
        matches!(
            self,
            Self::Route
                | Self::Stoop
                | Self::Connect { .. }
                | Self::Judge
                | Self::Vary { .. }
                | Self::Emit
                | Self::Sequence
                | Self::Sample
                | Self::Move
                | Self::Polish(_)
                | Self::Assemble { .. }
                | Self::Seal
        )
    }

    /// The stage that its work counts for.
    pub(crate) fn stage(&self) -> Stage {
        match self {
            Self::Ends => Stage::Ends,
            Self::Route | Self::Stoop | Self::Cut { .. } => Stage::Route,
            Self::Seed { .. } | Self::Scatter { .. } | Self::Vary { .. } => Stage::Seed,
            Self::Connect { .. } | Self::Judge => Stage::Connect,
            Self::Sequence => Stage::Sequence,
            Self::Sample => Stage::Sample,
            Self::Primitive | Self::Emit | Self::Move => Stage::Move,
            Self::Weigh { .. } | Self::Polish(_) => Stage::Polish,
            Self::Assemble { .. } | Self::Seal => Stage::Assemble,
            Self::Over(_) => Stage::Over,
        }
    }
}

/// What a search has done so far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Tally {
    /// Work units spent.
    pub work: u64,
    /// The same by [`Stage`].
    pub work_by_stage: [u64; Stage::COUNT],
    /// Sequences tried.
    pub sequences: u64,
    /// Guide routes followed.
    pub routes: u64,
    /// Whether stage P found no route at all, so that the straight way was tried.
    pub is_unguided: bool,
    /// Most segments of a route that shared a round.
    pub segments_at_once: u64,
    /// Sweeps of foot placements along guide routes.
    pub sweeps: u64,
    /// Transitions with a configuration.
    pub transitions_found: u64,
    /// Motions found.
    pub motions_found: u64,
    /// Motions that pi_S gave.
    pub primitives: u64,
    /// Motions that pi_S could not give although C_S holds; always 0.
    pub primitives_failed: u64,
    /// Edges of the guide route followed last.
    pub route_edges: LabelStats,
    /// Edges of the trees of stage P.
    pub tree_edges: LabelStats,
    /// What was rejected, by [`Rejection`].
    pub rejections: [u64; Rejection::COUNT],
}
