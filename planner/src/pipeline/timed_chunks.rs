//! Times a smooth path piece by piece, from touch-down to touch-down, and writes its chunks.

use crate::base::capacity::ArenaFull;
use crate::pipeline::search::SearchStats;
use crate::plan::chunk_builder::{ChunkBuilder, TimedPart};
use crate::timing::path_point::Path;
use crate::timing::path_timing::{PathTiming, TimingStats};
use crate::timing::stops::Stop;

/// Work units of the limits at one point, and of one point in a profile.
const UNITS_PER_POINT: u64 = 4;
/// Pieces whose timing changes as more of the path is known.
const OPEN_PIECES: usize = 2;

/// Times a path and writes the spans whose times are final.
#[derive(Debug)]
pub(crate) struct TimedChunks {
    timing: PathTiming,
    /// Number of spans before the end of each of the last pieces, the latest last.
    pieces: [usize; OPEN_PIECES + 1],
    /// Number of spans that are written.
    written: usize,
    /// When the chunk written last brakes, s.
    brake_after: f64,
    /// Chunks without a stop within the limits.
    without_stop: u64,
}

impl TimedChunks {
    /// Takes the memory of a timing.
    pub fn new(timing: PathTiming) -> Self {
        Self { timing, pieces: [0; OPEN_PIECES + 1], written: 0, brake_after: 0.0, without_stop: 0 }
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.timing.bytes()
    }

    /// Writes what happened so far.
    pub fn count(&self, stats: &mut SearchStats) {
        let TimingStats { rests, relaxed, unsupported, beyond } = self.timing.stats();
        stats.relaxed_points = relaxed - unsupported;
        (stats.rests, stats.beyond_limits) = (rests, unsupported + beyond);
        stats.without_stop = self.without_stop;
    }

    /// Whether all of the motion is within the limits and the robot can stop in every chunk.
    pub fn is_within(&self) -> bool {
        self.timing.stats().beyond == 0 && self.without_stop == 0
    }

    /// Times the next span, or writes the chunks of one. Returns the work units spent; `None` once
    /// all chunks are written.
    ///
    /// # Errors
    /// An arena is full.
    pub fn advance(
        &mut self,
        path: Path<'_>,
        chunks: &mut ChunkBuilder,
    ) -> Result<Option<u64>, ArenaFull> {
        if self.timing.spans() == 0 {
            self.timing.begin();
        }
        let is_complete = self.timing.spans() == path.spans.len();
        if self.written < self.timing.final_spans(is_complete) {
            self.written += 1;
            return self.write(path, self.written - 1, chunks).map(Some);
        }
        if is_complete {
            return Ok(None);
        }
        let span = &path.spans[self.timing.spans()];
        let points = (span.last - span.first + 1) as u64;
        self.timing.add_span(path)?;
        let known = self.timing.spans();
        let mut units = UNITS_PER_POINT * points;
        let is_single = span.contacts.len() == 1;
        let lands = path.spans.get(known).is_none_or(|next| next.contacts.len() > 1);
        if known == path.spans.len() || is_single && lands {
            self.pieces.rotate_left(1);
            self.pieces[OPEN_PIECES] = known;
            let first = &path.spans[self.pieces[0]];
            let known_path = Path { spans: &path.spans[..known], ..path };
            self.timing.solve(known_path, self.pieces[0], self.written);
            units += UNITS_PER_POINT * (span.last - first.first) as u64;
        }
        Ok(Some(units))
    }

    /// How the robot stops in a chunk. Where no ramp is within the limits, it is the longest one.
    fn stop(&mut self, path: Path<'_>, (span, chunk): (usize, usize), end: f64) -> Stop {
        let found = self.timing.stop(path, span, chunk);
        self.without_stop += u64::from(found.is_none());
        found.unwrap_or_else(|| {
            let seconds = 2.0 * (end - self.brake_after);
            Stop { brake_at: self.brake_after, brake_duration: seconds, resume_duration: seconds }
        })
    }

    /// Writes the chunks of a span. Returns the work units spent.
    fn write(
        &mut self,
        path: Path<'_>,
        index: usize,
        chunks: &mut ChunkBuilder,
    ) -> Result<u64, ArenaFull> {
        let times = self.timing.span_times(index);
        let count = times.chunks();
        for part in 0..count {
            let [first, last] = times.chunk(part);
            let stop = self.stop(path, (index, part), times.at(last, times.intervals));
            self.brake_after = stop.brake_at;
            let waypoints =
                (first..last + 1).map(|at| self.timing.waypoint(path, index, &times, at));
            chunks.append_timed(TimedPart { span: &path.spans[index], stop }, waypoints)?;
        }
        Ok(chunks.finalize(count) as u64 + count as u64)
    }
}
