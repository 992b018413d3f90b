//! Writes the motions of a plan as chunks, and finalizes them: time, sequence number, digest.

use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::message::PlanChunk;

use crate::base::capacity::ArenaFull;
use crate::base::work_budget::items_in;
use crate::motion::roadmap::ModeEdge;
use crate::pipeline::outcome::Outcome;
use crate::pipeline::search::{Search, SearchStats};
use crate::pipeline::smooth_path_stage::SmoothPath;
use crate::pipeline::stage::Event;
use crate::pipeline::timed_chunks::{Progress, TimedChunks};
use crate::plan::chunk_builder::{ChunkBuilder, ModeMotion, PARALLEL_MOTIONS_MAX};
use crate::preparation::planning_context::PlanningContext;
use crate::timing::limit::BindingTimes;
use crate::timing::path_timing::PathTiming;

/// Pieces of a plan that are timed at once where none of them is needed early.
const PIECES_AT_ONCE: usize = 3;

/// Makes the chunks of a plan and their digest. One unit of work for each motion that is written,
/// and one for each chunk that is finalized.
#[derive(Debug)]
pub(crate) struct ChunkStage {
    /// The chunks, and those that a plan retraces before.
    pub chunks: ChunkBuilder,
    /// The next motion of the plan.
    next: usize,
    /// Whether all motions are written.
    is_written: bool,
    /// The timing of a smooth path; none where plans keep the searched motion.
    timed: Option<TimedChunks>,
    digest: Digest,
    /// The best plan while others are tried; none where plans are not improved.
    kept: Option<KeptChunks>,
}

/// The chunks of the best plan, and the statistics of their motion.
#[derive(Debug)]
struct KeptChunks {
    chunks: ChunkBuilder,
    digest: Digest,
    binding: BindingTimes,
    stats: SearchStats,
}

impl ChunkStage {
    /// Takes the chunks of a plan, which are none yet or those that retrace, and where the plan is
    /// to be improved memory for the chunks of another.
    pub fn new(
        chunks: ChunkBuilder,
        timing: Option<PathTiming>,
        others: Option<ChunkBuilder>,
    ) -> Self {
        let timed = timing.map(TimedChunks::new);
        let kept = others.map(|chunks| KeptChunks {
            chunks,
            digest: Digest::default(),
            binding: BindingTimes::default(),
            stats: SearchStats::default(),
        });
        Self { chunks, next: 0, is_written: false, timed, digest: Digest::default(), kept }
    }

    /// Keeps the plan that is complete as the best one.
    pub fn keep(&mut self, stats: &SearchStats) {
        let binding = self.binding().cloned();
        let Some(kept) = &mut self.kept else { return };
        std::mem::swap(&mut kept.chunks, &mut self.chunks);
        (kept.digest, kept.stats) = (self.digest, *stats);
        kept.binding = binding.unwrap_or_default();
    }

    /// Begins another plan, from the same start to the same goal as the best one. Nothing of it is
    /// needed early, so more pieces are timed at once where all of the best one have a timing.
    pub fn begin_another(&mut self) {
        let Some(kept) = &self.kept else { return };
        let pieces = if kept.stats.untimed_pieces == 0 { PIECES_AT_ONCE } else { 1 };
        self.chunks.begin_like(&kept.chunks);
        (self.next, self.is_written) = (0, false);
        self.timed.iter_mut().for_each(|timed| timed.begin(pieces));
    }

    /// Takes the best plan.
    pub fn take_kept(&mut self, stats: &mut SearchStats) {
        let Some(kept) = &mut self.kept else { return };
        std::mem::swap(&mut kept.chunks, &mut self.chunks);
        self.digest = kept.digest;
        take_motion(stats, &kept.stats);
    }

    /// The chunks of the best plan.
    pub fn kept_chunks(&self) -> &[PlanChunk] {
        self.kept.as_ref().map_or(&[], |kept| kept.chunks.chunks())
    }

    /// When the best plan ends, s.
    pub fn kept_seconds(&self) -> f64 {
        self.kept.as_ref().map_or(0.0, |kept| kept.chunks.end())
    }

    /// When the plan ends, s.
    pub fn seconds(&self) -> f64 {
        self.chunks.end()
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        let kept = self.kept.as_ref().map_or(0, |kept| kept.chunks.bytes());
        self.chunks.bytes() + kept + self.timed.as_ref().map_or(0, TimedChunks::bytes)
    }

    /// Writes the next motions and finalizes chunks before them, within `budget` units of work. The
    /// pieces of a smooth `path`, and their chunks, are not divided by the budget; where more of
    /// the path is needed, the stage ends.
    ///
    /// # Errors
    /// The waypoint arena is full.
    pub fn step(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        path: Option<SmoothPath<'_>>,
        budget: u64,
    ) -> Result<Event, ArenaFull> {
        if self.is_written {
            return self.finalize(context, search, budget);
        }
        let (Some(timed), Some(path)) = (&mut self.timed, path) else {
            return self.write(context, search, budget);
        };
        match timed.advance(path, &mut self.chunks)? {
            Progress::NeedsPath => return Ok(Event::NeedsPath),
            Progress::Spent(units) => search.stats.work += units,
            Progress::Complete => {
                search.stats.work += 1;
                self.is_written = true;
            }
        }
        timed.count(&mut search.stats);
        Ok(Event::Continue)
    }

    /// Writes the chunks of the next motions, and finalizes those of earlier motions.
    fn write(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        budget: u64,
    ) -> Result<Event, ArenaFull> {
        let motions_max = items_in(budget, PARALLEL_MOTIONS_MAX);
        let plan = &search.segmentation.plan()[self.next..];
        let edges =
            plan.windows(2).take(motions_max).map(|pair| ModeEdge { from: pair[0], to: pair[1] });
        let count = edges.len();
        if count == 0 {
            search.stats.work += 1;
            self.is_written = true;
            return Ok(Event::Continue);
        }
        let motions: heapless::Vec<ModeMotion<'_>, PARALLEL_MOTIONS_MAX> =
            edges.filter_map(|edge| search.roadmap.mode_motion(edge)).collect();
        let chunks_max = items_in(budget - count as u64, usize::MAX);
        let finalized = self.chunks.append(&motions, chunks_max, &context.threads)?;
        search.stats.work += (count + finalized) as u64;
        self.next += count;
        Ok(Event::Continue)
    }

    /// Finalizes the chunks that are left.
    fn finalize(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        budget: u64,
    ) -> Result<Event, ArenaFull> {
        if self.chunks.unfinalized() > 1 {
            let chunks_max = items_in(budget, usize::MAX);
            search.stats.work += self.chunks.append(&[], chunks_max, &context.threads)? as u64;
            return Ok(Event::Continue);
        }
        search.stats.work += 1;
        self.digest = self.chunks.finalize_last();
        if self.kept.is_some() {
            return Ok(Event::Improve);
        }
        search.outcome = Some(Outcome::Found);
        Ok(Event::Found)
    }

    /// How long each limit binds a timed motion; none where plans keep the searched motion.
    fn binding(&self) -> Option<&BindingTimes> {
        self.timed.as_ref().map(TimedChunks::binding)
    }

    /// How long each limit binds the motion of the plan; none where it keeps the searched motion.
    pub fn binding_of_plan(&self) -> Option<&BindingTimes> {
        let of_plan = self.binding()?;
        Some(self.kept.as_ref().map_or(of_plan, |kept| &kept.binding))
    }

    /// The chunks that are final, also while the plan is made: a complete plan begins with them.
    pub fn final_chunks(&self) -> &[PlanChunk] {
        self.chunks.finalized()
    }

    /// The chunks of the plan.
    pub fn chunks(&self) -> &[PlanChunk] {
        self.chunks.chunks()
    }

    /// The digest of the plan's chunks; zero before the plan is complete.
    pub fn digest(&self) -> Digest {
        self.digest
    }
}

/// Takes what the statistics `of` another moment say about the smooth motion.
fn take_motion(stats: &mut SearchStats, of: &SearchStats) {
    (stats.rests, stats.searched_phases) = (of.rests, of.searched_phases);
    (stats.relaxed_points, stats.beyond_limits) = (of.relaxed_points, of.beyond_limits);
    (stats.without_stop, stats.untimed_pieces) = (of.without_stop, of.untimed_pieces);
}
