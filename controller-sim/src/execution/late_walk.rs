//! Walks whose chunks come late at random: the robot brakes, stands and goes on, and every instant
//! is checked.

use surefoot_shared_types::message::{Check, PlanChunk, Waypoint};

use crate::base::comparison::{is_at_most, largest};
use crate::base::random::uniform;
use crate::check::checker::Checker;
use crate::check::segment::Violation;
use crate::execution::chunk_walk::ChunkWalk;
use crate::execution::late_chunks::LateChunks;
use crate::execution::tuning::{JUMP_MAX, SAMPLE_TICK, SAMPLES_PER_CHECK};

/// What happened in a walk.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LateWalk {
    /// Chunks that came late.
    pub late: u64,
    /// How often the robot began to brake.
    pub brakes: u64,
    /// How long it stood, s.
    pub stood: f64,
    /// Instants checked.
    pub instants: u64,
    /// Duration, s.
    pub seconds: f64,
    /// Whether it arrived at the end of the plan.
    pub is_finished: bool,
    /// The motion as executed, in chunks.
    pub executed: Vec<PlanChunk>,
}

/// Walks a smooth plan of accepted chunks that come at random times. Checks at every sample that
/// the robot does not jump, and at every tenth sample, an instant, the dynamics.
///
/// # Errors
/// The first instant (s since the start) that violates a dynamic check, or at which the robot
/// jumps.
pub fn walk_late(
    checker: &mut Checker,
    chunks: &[PlanChunk],
    late: &LateChunks,
) -> Result<LateWalk, (f64, Violation)> {
    let mut result = LateWalk::default();
    let arrivals = arrivals(chunks, late, &mut result);
    let longest = arrivals.last().copied().unwrap_or(0.0) + 3.0 * duration(chunks) + 60.0;
    let (mut walk, mut accepted) = (ChunkWalk::recorded(), 0);
    let mut before: Option<Waypoint> = None;
    let mut samples = 0_u32;
    while !walk.is_finished() && result.seconds < longest {
        while arrivals.get(accepted).is_some_and(|arrival| *arrival <= result.seconds) {
            walk.accept(&chunks[accepted]);
            accepted += 1;
        }
        walk.advance(SAMPLE_TICK);
        samples += 1;
        result.seconds = f64::from(samples) * SAMPLE_TICK;
        let Some((chunk, instant)) = walk.now() else { continue };
        let at_now = |violation| (result.seconds, violation);
        check_jump(before.as_ref(), chunk, &instant).map_err(at_now)?;
        if samples.is_multiple_of(SAMPLES_PER_CHECK) {
            checker.check_instant(chunk.contacts(), &instant).map_err(at_now)?;
            result.instants += 1;
        }
        before = Some(instant);
    }
    result.is_finished = walk.is_finished();
    (result.brakes, result.stood) = (walk.counts().brakes, walk.counts().stood);
    result.executed = walk.executed();
    Ok(result)
}

/// When each chunk comes (s): most within half of its duration after the one before, some late.
fn arrivals(chunks: &[PlanChunk], late: &LateChunks, walk: &mut LateWalk) -> Vec<f64> {
    let mut time = 0.0;
    let arrival = |chunk: &PlanChunk| {
        let delay = late.delay(chunk.epoch, chunk.sequence);
        walk.late += u64::from(delay.is_some());
        let spread = uniform(late.seed, &[chunk.sequence]);
        time += 0.5 * duration(std::slice::from_ref(chunk)) * spread + delay.unwrap_or(0.0);
        time
    };
    chunks.iter().map(arrival).collect()
}

fn duration(chunks: &[PlanChunk]) -> f64 {
    let begin = chunks.first().and_then(|chunk| chunk.waypoints().first());
    let end = chunks.last().and_then(|chunk| chunk.waypoints().last());
    begin.zip(end).map_or(0.0, |(begin, end)| end.time - begin.time)
}

/// Whether the robot is where its speed leads; in straight lines, whose instants have no speed, not
/// farther than their speed leads.
fn check_jump(
    before: Option<&Waypoint>,
    chunk: &PlanChunk,
    now: &Waypoint,
) -> Result<(), Violation> {
    let Some(before) = before else { return Ok(()) };
    let allowed = SAMPLE_TICK * if chunk.is_smooth() { 0.0 } else { line_speed(chunk) };
    let led = |from: f64, to: f64, speeds: [f64; 2]| {
        (to - from - 0.5 * SAMPLE_TICK * (speeds[0] + speeds[1])).abs() - allowed
    };
    let joints = (0..now.q.len()).map(|joint| {
        let speeds = [before.joint_velocity[joint], now.joint_velocity[joint]];
        led(before.q[joint], now.q[joint], speeds)
    });
    let root = (0..3).map(|axis| {
        let speeds = [before.root_velocity[axis], now.root_velocity[axis]];
        led(before.root_position[axis], now.root_position[axis], speeds)
    });
    let jump = largest(joints.chain(root).map(|jump| if jump < 0.0 { 0.0 } else { jump }));
    if is_at_most(jump, JUMP_MAX) {
        return Ok(());
    }
    Err(Violation::new(Check::Continuity, 0, format!("the robot jumps by {jump:.2e}")))
}

/// The largest speed of a joint or of the root along the lines of a chunk, rad/s or m/s.
fn line_speed(chunk: &PlanChunk) -> f64 {
    let speeds = chunk.waypoints().windows(2).flat_map(|pair| {
        let numbers = |waypoint: &Waypoint| waypoint.root_position.into_iter().chain(waypoint.q);
        let seconds = pair[1].time - pair[0].time;
        let apart = numbers(&pair[0]).zip(numbers(&pair[1])).map(|(a, b)| (b - a).abs());
        apart.map(move |apart| apart / seconds).collect::<Vec<f64>>()
    });
    largest(speeds)
}
