//! Post-processing of the motions of a walk that is complete: shortcuts and local optimisation
//! within each mode [Grey 4.4.6].
//!
//! First shortcuts, in the motions that are longest against the straight way before the others;
//! with what is left of the work, local optimisation of all motions in turn. What is found takes
//! the place of the motion in Gamma_M.

use surefoot_shared_types::base::limits::CHUNK_WAYPOINTS_MAX;

use crate::motion::indexed_heap::IndexHeap;
use crate::motion::mode_graph::{ArenaFull, TransitionId};
use crate::motion::roadmap::{ModeEdge, Roadmap};
use crate::motion::shortcut::{Pass, distance, length};
use crate::rpg::{Phase, Planner};

/// A motion whose straight way is longer than this share of it gets no shortcuts.
const STRAIGHT_MAX: f64 = 0.8;

/// What post-processing goes through, and what may be spent on it.
#[derive(Debug)]
pub struct Polish {
    /// Edges of the walk by how much of their length the straight way is.
    crooked: IndexHeap,
    /// The edge whose corners come next.
    next: usize,
    /// It ends when the tally's work is this much.
    until: u64,
}

impl Polish {
    /// Room for any walk.
    pub fn new(edges_max: usize) -> Self {
        Self { crooked: IndexHeap::new(edges_max), next: 0, until: 0 }
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.crooked.bytes()
    }
}

impl Planner {
    /// After the last segment: post-processing, as far as enough work is left to put the plan
    /// together.
    pub(crate) fn polish_or_assemble(&mut self) -> Phase {
        let config = &self.shared.constraints.config;
        let wanted = (config.shortcut_work_share * self.tally.work as f64) as u64;
        let until = self
            .tally
            .work
            .saturating_add(wanted)
            .min(config.work_max.saturating_sub(self.work_to_assemble()));
        if until <= self.tally.work {
            return Phase::Assemble { next: 0 };
        }
        self.polish.crooked.clear();
        (self.polish.next, self.polish.until) = (0, until);
        Phase::Weigh { next: 0 }
    }

    /// Units of work that at the most are needed to put the plan together, and to weigh its motions
    /// before.
    fn work_to_assemble(&self) -> u64 {
        let (edges, waypoints) = (self.walk.len(), self.roadmap.waypoints_len());
        (3 * edges + waypoints / (CHUNK_WAYPOINTS_MAX - 1) + 1) as u64
    }

    /// Compares one motion of the walk to the straight way.
    pub(crate) fn weigh(&mut self, next: usize) -> Phase {
        let Some(edge) = edge_of(&self.walk, next) else { return Phase::Polish(Pass::Shortcuts) };
        if let Some(share) =
            straightness(&self.roadmap, edge).filter(|share| *share <= STRAIGHT_MAX)
        {
            self.polish.crooked.push(next as u32, share, 0);
        }
        Phase::Weigh { next: next + 1 }
    }

    /// Makes motions of the walk shorter, round by round.
    pub(crate) fn polish(&mut self, goal: Pass, budget: u64) -> Result<Phase, ArenaFull> {
        if !self.round.is_running() {
            let work = self.polish.until.saturating_sub(self.tally.work + 1);
            let (Polish { crooked, next, .. }, walk) = (&mut self.polish, &self.walk);
            let edges = std::iter::from_fn(|| match goal {
                Pass::Shortcuts => {
                    crooked.pop().and_then(|(index, ..)| edge_of(walk, index as usize))
                }
                Pass::Corners => {
                    *next += 1;
                    edge_of(walk, *next - 1)
                }
            });
            self.round.begin_shortcuts(&self.shared, &self.roadmap, edges, (goal, work));
        }
        let is_last = self.round.is_empty();
        let has_ended = self.advance_round(budget)?.is_some();
        Ok(match goal {
            Pass::Shortcuts if has_ended && is_last => Phase::Polish(Pass::Corners),
            Pass::Corners if has_ended && is_last => Phase::Assemble { next: 0 },
            _ => Phase::Polish(goal),
        })
    }
}

fn edge_of(walk: &[TransitionId], index: usize) -> Option<ModeEdge> {
    let pair = walk.get(index..index + 2)?;
    Some(ModeEdge { from: pair[0], to: pair[1] })
}

/// The length of the straight way as a share of that of a motion; `None` where there is none.
fn straightness(roadmap: &Roadmap, edge: ModeEdge) -> Option<f64> {
    let (first, path) = (roadmap.state(edge.from).configuration, roadmap.motion(edge)?);
    let whole = distance(&first, path.first()?) + length(path);
    Some(distance(&first, path.last()?) / whole)
}
