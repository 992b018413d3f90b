//! The chunks of a plan file, if they fit its waypoints and phases.

use crate::base::limits::CHUNK_WAYPOINTS_MAX;
use crate::message::chunk::{RAMP_SECONDS_MAX, STOP_ROUNDING_MAX};
use crate::plan_format::blocks::{ChunkBlock, PlanFile};

/// The chunks of a plan file; none in a plan of straight lines.
///
/// # Errors
/// Why the chunks do not fit the rest of the file, which was edited. The motion can be checked
/// without them.
pub fn fitting_chunks(plan: &PlanFile) -> Result<&[ChunkBlock], String> {
    let (mut expected, mut brakes) = (0, f64::NEG_INFINITY);
    for (at, chunk) in plan.chunks.iter().enumerate() {
        let begins = (expected, brakes);
        check_chunk(plan, chunk, begins).map_err(|reason| format!("chunk {at} {reason}"))?;
        (expected, brakes) = (chunk.last, chunk.brake_at);
    }
    if plan.chunks.is_empty() || expected + 1 == plan.waypoints.len() {
        return Ok(&plan.chunks);
    }
    Err(format!("the chunks end at waypoint {expected} of {}", plan.waypoints.len()))
}

/// Whether a chunk begins at the waypoint `expected`, does not brake before the chunk before it
/// does, and comes to rest within its waypoints.
fn check_chunk(
    plan: &PlanFile,
    chunk: &ChunkBlock,
    (expected, brakes): (usize, f64),
) -> Result<(), String> {
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
    if !(begin <= stops && stops <= end + STOP_ROUNDING_MAX) {
        return Err(format!("stops at {stops} s, outside of {begin} to {end} s"));
    }
    if brake_at < brakes {
        return Err(format!("brakes at {brake_at} s, before the last one does at {brakes} s"));
    }
    let is_ramp = |seconds: f64| (0.0..=RAMP_SECONDS_MAX).contains(&seconds);
    if is_ramp(brake_duration) && is_ramp(resume_duration) {
        return Ok(());
    }
    Err(format!(
        "brakes in {brake_duration} s and goes on in {resume_duration} s; each is 0 to \
         {RAMP_SECONDS_MAX} s"
    ))
}
