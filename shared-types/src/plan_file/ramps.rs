//! The chunks of a plan file, if they fit its waypoints and phases.

use crate::base::limits::CHUNK_WAYPOINTS_MAX;
use crate::plan_format::blocks::{ChunkBlock, PlanFile};

/// Largest excess of the instant at which the robot stands over the chunk's end, s: times are
/// rounded.
const STOP_ROUNDING_MAX: f64 = 1e-9;

/// The chunks of a plan file; none in a plan of straight lines.
///
/// # Errors
/// Why the chunks do not fit the rest of the file, which was edited. The motion can be checked
/// without them.
pub fn fitting_chunks(plan: &PlanFile) -> Result<&[ChunkBlock], String> {
    let mut expected = 0;
    for (at, chunk) in plan.chunks.iter().enumerate() {
        check_chunk(plan, chunk, expected).map_err(|reason| format!("chunk {at} {reason}"))?;
        expected = chunk.last;
    }
    if plan.chunks.is_empty() || expected + 1 == plan.waypoints.len() {
        return Ok(&plan.chunks);
    }
    Err(format!("the chunks end at waypoint {expected} of {}", plan.waypoints.len()))
}

fn check_chunk(plan: &PlanFile, chunk: &ChunkBlock, expected: usize) -> Result<(), String> {
    let ChunkBlock { first, last, brake_at, brake_duration, resume_duration } = *chunk;
    if first != expected || last < first || last >= plan.waypoints.len() {
        return Err(format!("covers waypoints {first}..{last}, which do not follow {expected}"));
    }
    if last - first >= CHUNK_WAYPOINTS_MAX {
        return Err(format!("has more than {CHUNK_WAYPOINTS_MAX} waypoints"));
    }
    if !plan.phases.iter().any(|phase| phase.first <= first && last <= phase.last) {
        return Err("lies in two phases".to_owned());
    }
    let (begin, end) = (plan.waypoints[first].t, plan.waypoints[last].t);
    let stops = brake_at + 0.5 * brake_duration;
    let is_inside = begin <= stops && stops <= end + STOP_ROUNDING_MAX;
    if is_inside && brake_duration >= 0.0 && resume_duration >= 0.0 {
        return Ok(());
    }
    Err(format!("stops at {stops} s, outside of {begin} to {end} s"))
}
