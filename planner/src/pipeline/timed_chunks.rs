//! Times a smooth path piece by piece, from touch-down to touch-down, and writes its chunks.
//!
//! A piece without a timing within the limits is left to a motion that rests at every waypoint; the
//! timing of the pieces before it ends at rest, and that of the pieces after it begins anew.

use crate::base::capacity::ArenaFull;
use crate::pipeline::search::SearchStats;
use crate::pipeline::smooth_path_stage::SmoothPath;
use crate::plan::chunk_builder::{ChunkBuilder, TimedPart};
use crate::timing::limit::BindingTimes;
use crate::timing::load_sharing::LoadSchedule;
use crate::timing::path_point::{Path, PathPoint};
use crate::timing::path_timing::{PathTiming, TimingStats};
use crate::timing::stops::Stop;

/// Work units of the limits at one point, and of one point in a profile.
pub(crate) const UNITS_PER_POINT: u64 = 4;
/// Pieces whose timing changes as more of the path is known.
const OPEN_PIECES: usize = 1;
/// Most intervals of a chunk that rests at every waypoint.
const RESTING_INTERVALS_MAX: usize = 31;
/// Largest joint motion (rad or m) between two such waypoints where a point of the path allows it.
const RESTING_MOTION_MAX: f64 = 0.05;
/// Most parts into which the path between two of its points is divided for that.
const RESTING_PARTS_MAX: usize = 4;

/// What a step came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Progress {
    /// Work units spent.
    Spent(u64),
    /// More of the path is needed.
    NeedsPath,
    /// All chunks are written.
    Complete,
}

/// Times a path and writes the spans whose times are final.
#[derive(Debug)]
pub(crate) struct TimedChunks {
    timing: PathTiming,
    /// The first span of the present timing.
    first: usize,
    /// Number of spans before the end of each of the last pieces, the latest last.
    pieces: [usize; OPEN_PIECES + 1],
    /// Number of spans that are written.
    written: usize,
    /// The end of the spans without a timing that follow those of the present one.
    untimed_end: Option<usize>,
    /// When the chunk written last brakes, s.
    brake_after: f64,
    counts: Counts,
    binding: BindingTimes,
}

/// What happened in earlier timings, and the chunks and pieces that are not within the limits.
#[derive(Debug, Clone, Copy, Default)]
struct Counts {
    earlier: TimingStats,
    /// Chunks without a stop within the limits.
    without_stop: u64,
    /// Pieces without a timing.
    untimed_pieces: u64,
}

impl TimedChunks {
    /// Takes the memory of a timing.
    pub fn new(timing: PathTiming) -> Self {
        Self {
            timing,
            first: 0,
            pieces: [0; OPEN_PIECES + 1],
            written: 0,
            untimed_end: None,
            brake_after: 0.0,
            counts: Counts::default(),
            binding: BindingTimes::default(),
        }
    }

    /// Begins another path.
    pub fn begin(&mut self) {
        self.timing.begin();
        (self.first, self.pieces, self.written) = (0, [0; OPEN_PIECES + 1], 0);
        (self.untimed_end, self.brake_after) = (None, 0.0);
        (self.counts, self.binding) = (Counts::default(), BindingTimes::default());
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.timing.bytes()
    }

    /// How long each limit binds the motion so far.
    pub fn binding(&self) -> &BindingTimes {
        &self.binding
    }

    /// Writes what happened so far.
    pub fn count(&self, stats: &mut SearchStats) {
        let Counts { earlier, without_stop, untimed_pieces } = self.counts;
        let now = self.timing.stats();
        let unsupported = earlier.unsupported + now.unsupported;
        stats.relaxed_points = earlier.relaxed + now.relaxed - unsupported;
        stats.rests = earlier.rests + now.rests;
        stats.beyond_limits = unsupported;
        (stats.without_stop, stats.untimed_pieces) = (without_stop, untimed_pieces);
    }

    /// Times the next span, or writes the chunks of one.
    ///
    /// # Errors
    /// An arena is full.
    pub fn advance(
        &mut self,
        SmoothPath { path, is_complete: is_whole }: SmoothPath<'_>,
        chunks: &mut ChunkBuilder,
    ) -> Result<Progress, ArenaFull> {
        if self.written == self.first && self.timing.spans() == 0 {
            self.timing.begin();
        }
        let known = self.first + self.timing.spans();
        let is_complete = is_whole && known == path.spans.len() || self.untimed_end.is_some();
        if self.written < self.first + self.timing.final_spans(is_complete) {
            self.written += 1;
            return self.write(path, self.written - 1, chunks).map(Progress::Spent);
        }
        if let Some(end) = self.untimed_end {
            return self.write_untimed(path, end, chunks).map(Progress::Spent);
        }
        if is_complete {
            return Ok(Progress::Complete);
        }
        // Whether a foot lands at the end of a span shows in the next one.
        if !is_whole && known + 1 >= path.spans.len() {
            return Ok(Progress::NeedsPath);
        }
        self.time_next(path).map(Progress::Spent)
    }

    /// Adds the next span, and times the path up to its end where a foot lands there. Returns the
    /// work units spent.
    fn time_next(&mut self, path: Path<'_>) -> Result<u64, ArenaFull> {
        let known = self.first + self.timing.spans();
        let span = &path.spans[known];
        let points = (span.last - span.first + 1) as u64;
        self.timing.add_span(Path { spans: &path.spans[self.first..], ..path })?;
        let known = known + 1;
        let is_single = span.contacts.len() == 1;
        let lands = path.spans.get(known).is_none_or(|next| next.contacts.len() > 1);
        if known < path.spans.len() && !(is_single && lands) {
            return Ok(UNITS_PER_POINT * points);
        }
        self.pieces.rotate_left(1);
        self.pieces[OPEN_PIECES] = known;
        let open = path.spans[self.pieces[0].max(self.first)].first;
        // The first piece alone is final only where the next one has no timing, or there is none.
        let is_first = self.pieces[0] <= self.first && known < path.spans.len();
        if !is_first && !self.solve(path, known) {
            self.counts.untimed_pieces += 1;
            self.untimed_end = Some(known);
            let known_path = Path { spans: &path.spans[self.first..known], ..path };
            if self.timing.end_at_last_rest(known_path) == 0 {
                self.leave_piece_untimed(path)?;
            }
        }
        Ok(UNITS_PER_POINT * (points + (span.last - open) as u64))
    }

    /// Times the spans of the present timing before `end`. Returns whether that is within the
    /// limits.
    fn solve(&mut self, path: Path<'_>, end: usize) -> bool {
        let [fixed, written] =
            [self.pieces[0], self.written].map(|spans| spans.saturating_sub(self.first));
        self.timing.solve(Path { spans: &path.spans[self.first..end], ..path }, fixed, written)
    }

    /// Times the first piece of the present timing alone, where there is another one. Where that
    /// fails, the first one has no timing.
    fn leave_piece_untimed(&mut self, path: Path<'_>) -> Result<(), ArenaFull> {
        self.timing.begin();
        let end = self.pieces[0];
        if end <= self.first {
            return Ok(());
        }
        let first_piece = Path { spans: &path.spans[self.first..end], ..path };
        for _ in first_piece.spans {
            self.timing.add_span(first_piece)?;
        }
        if !self.timing.solve(first_piece, 0, 0) {
            self.timing.begin();
            self.untimed_end = Some(end);
        }
        Ok(())
    }

    /// How the robot stops in a chunk of a span of the present timing. Where no ramp is within the
    /// limits, it is the longest one.
    fn stop(&mut self, (span, chunk): (usize, usize), end: f64) -> Stop {
        let found = self.timing.stop(span, chunk);
        self.counts.without_stop += u64::from(found.is_none());
        found.unwrap_or_else(|| {
            let seconds = 2.0 * (end - self.brake_after);
            Stop { brake_at: self.brake_after, brake_duration: seconds, resume_duration: seconds }
        })
    }

    /// Writes the chunks of a timed span. Returns the work units spent.
    fn write(
        &mut self,
        path: Path<'_>,
        index: usize,
        chunks: &mut ChunkBuilder,
    ) -> Result<u64, ArenaFull> {
        let end = self.first + self.timing.spans();
        let timed = Path { spans: &path.spans[self.first..end], ..path };
        let span = index - self.first;
        let times = self.timing.span_times(span);
        let count = times.chunks();
        let schedule = LoadSchedule::beside(chunks.stance_retraced_to(), path.spans, index);
        for part in 0..count {
            let [first, last] = times.chunk(part);
            let stop = self.stop((span, part), times.at(last, times.intervals));
            self.brake_after = stop.brake_at;
            let binding = self.timing.binding_times(span, part);
            self.binding.add_all(&binding);
            let waypoints = (first..last + 1)
                .map(|at| self.timing.waypoint(timed, span, (&times, at), &schedule));
            let part = TimedPart { span: &path.spans[index], stop, binding: binding.longest() };
            chunks.append_timed(part, waypoints)?;
        }
        Ok(chunks.finalize(count) as u64 + count as u64)
    }

    /// Writes the chunks of the next span without a timing, of those before `end`. After the last
    /// one the next timing begins. Returns the work units spent.
    fn write_untimed(
        &mut self,
        path: Path<'_>,
        end: usize,
        chunks: &mut ChunkBuilder,
    ) -> Result<u64, ArenaFull> {
        let index = self.written;
        let span = &path.spans[index];
        let intervals = span.last - span.first;
        let parts = parts_between(&path.points[span.first..=span.last]);
        let per_chunk = RESTING_INTERVALS_MAX / parts;
        let schedule = LoadSchedule::beside(chunks.stance_retraced_to(), path.spans, index);
        let mut at = |place: usize| {
            let points = &path.points[span.first..];
            let [from, to] = [place / parts, place.div_ceil(parts)].map(|at| points[at].parameter);
            let part = (place % parts) as f64 / parts as f64;
            self.timing.resting_waypoint(path, index, from + (to - from) * part, &schedule)
        };
        let mut written = 0;
        for first in (0..intervals).step_by(per_chunk) {
            let last = (first + per_chunk).min(intervals);
            chunks.append_resting(span, (first * parts..last * parts + 1).map(&mut at))?;
            written += 1;
        }
        self.written += 1;
        if self.written == end {
            self.begin_anew();
        }
        Ok(chunks.finalize(written) as u64 + intervals as u64)
    }

    /// Begins a timing at the first span that is not written.
    fn begin_anew(&mut self) {
        let earlier = &mut self.counts.earlier;
        *earlier = earlier.plus(&self.timing.stats());
        earlier.rests += 1;
        self.timing.begin();
        (self.first, self.pieces) = (self.written, [self.written; OPEN_PIECES + 1]);
        (self.untimed_end, self.brake_after) = (None, 0.0);
    }
}

/// The number of waypoints for each interval between points where the robot rests at all.
fn parts_between(points: &[PathPoint]) -> usize {
    let motion = |pair: &[PathPoint]| {
        let joints = pair[0].q.iter().zip(&pair[1].q);
        joints.map(|(from, to)| (to - from).abs()).fold(0.0, f64::max)
    };
    let largest = points.windows(2).map(motion).fold(0.0, f64::max);
    (libm::ceil(largest / RESTING_MOTION_MAX) as usize).clamp(1, RESTING_PARTS_MAX)
}
