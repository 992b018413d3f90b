//! Walks whose chunks come late at random: the robot brakes, stands and goes on.

use surefoot_shared_types::message::{Check, PlanChunk, Waypoint};

use crate::base::comparison::{is_at_most, largest};
use crate::base::random::uniform;
use crate::check::checker::Checker;
use crate::check::course::{at_rate, planned_at};
use crate::check::segment::Violation;
use crate::execution::plan_clock::{Pace, PlanClock};

/// Time between two instants that are checked, s.
const TICK: f64 = 0.01;
/// The share of chunks that come late.
const LATE_SHARE: f64 = 0.2;
/// The longest delay of a late chunk, s.
const DELAY_MAX: f64 = 3.0;
/// How far a number may be from where its speed leads within a tick, rad or m.
const JUMP_MAX: f64 = 1e-3;

/// What happened in a walk.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LateWalk {
    /// Chunks that came late.
    pub late: u64,
    /// How often the robot began to brake.
    pub brakes: u64,
    /// How often it stood and went on.
    pub resumptions: u64,
    /// Instants checked.
    pub instants: u64,
    /// Duration, s.
    pub seconds: f64,
    /// Whether it arrived at the end of the plan.
    pub is_finished: bool,
}

/// Walks a smooth plan of accepted chunks that come at random times, and checks every instant.
///
/// # Errors
/// The first instant that violates a dynamic check, or at which the robot jumps.
pub fn walk_late(
    checker: &mut Checker,
    chunks: &[PlanChunk],
    seed: u64,
) -> Result<LateWalk, (f64, Violation)> {
    let mut walk = LateWalk::default();
    let arrivals = arrivals(chunks, seed, &mut walk);
    let begin = chunks.first().map_or(0.0, |chunk| chunk.waypoints()[0].time);
    let longest = arrivals.last().copied().unwrap_or(0.0) + 3.0 * duration(chunks) + 60.0;
    let (mut clock, mut accepted) = (PlanClock::new(begin), 0);
    let mut before: Option<Waypoint> = None;
    while !clock.is_finished() && walk.seconds < longest {
        while arrivals.get(accepted).is_some_and(|arrival| *arrival <= walk.seconds) {
            clock.accept(&chunks[accepted]);
            accepted += 1;
        }
        let pace = clock.pace();
        clock.advance(TICK);
        walk.seconds += TICK;
        walk.count(pace, clock.pace());
        let now = clock.now();
        let Some(chunk) = chunk_at(&chunks[..accepted], now.time) else { continue };
        let Some((_, planned)) = planned_at(chunk.waypoints(), now.time) else { continue };
        let instant = at_rate(planned, now.rate, now.rate_change);
        checker
            .check_instant(chunk.contacts(), &instant)
            .and_then(|_| check_jump(before.as_ref(), &instant))
            .map_err(|violation| (now.time, violation))?;
        walk.instants += 1;
        before = Some(instant);
    }
    walk.is_finished = clock.is_finished();
    Ok(walk)
}

impl LateWalk {
    fn count(&mut self, before: Pace, after: Pace) {
        let stands = |pace: Pace| matches!(pace, Pace::Braking(..) | Pace::AtRest(_));
        self.brakes += u64::from(!stands(before) && stands(after));
        let has_braked = stands(before) && before != Pace::AtRest(0);
        self.resumptions += u64::from(has_braked && !stands(after));
    }
}

/// When each chunk comes (s): most within half of its duration after the one before, some late.
fn arrivals(chunks: &[PlanChunk], seed: u64, walk: &mut LateWalk) -> Vec<f64> {
    let mut time = 0.0;
    let arrival = |(index, chunk): (usize, &PlanChunk)| {
        let random = |key: u64| uniform(seed, &[index as u64, key]);
        let is_late = random(0) < LATE_SHARE;
        walk.late += u64::from(is_late);
        let delay = if is_late { DELAY_MAX * random(1) } else { 0.0 };
        time += 0.5 * duration(std::slice::from_ref(chunk)) * random(2) + delay;
        time
    };
    chunks.iter().enumerate().map(arrival).collect()
}

fn duration(chunks: &[PlanChunk]) -> f64 {
    let begin = chunks.first().and_then(|chunk| chunk.waypoints().first());
    let end = chunks.last().and_then(|chunk| chunk.waypoints().last());
    begin.zip(end).map_or(0.0, |(begin, end)| end.time - begin.time)
}

/// The first chunk that ends at a time (s) or later.
fn chunk_at(chunks: &[PlanChunk], time: f64) -> Option<&PlanChunk> {
    let ends_before =
        |chunk: &PlanChunk| chunk.waypoints().last().is_some_and(|waypoint| waypoint.time < time);
    chunks.get(chunks.partition_point(ends_before))
}

/// Whether the robot is where its speed leads.
fn check_jump(before: Option<&Waypoint>, now: &Waypoint) -> Result<(), Violation> {
    let Some(before) = before else { return Ok(()) };
    let led = |from: f64, to: f64, speeds: [f64; 2]| {
        (to - from - 0.5 * TICK * (speeds[0] + speeds[1])).abs()
    };
    let joints = (0..now.q.len()).map(|joint| {
        let speeds = [before.joint_velocity[joint], now.joint_velocity[joint]];
        led(before.q[joint], now.q[joint], speeds)
    });
    let root = (0..3).map(|axis| {
        let speeds = [before.root_velocity[axis], now.root_velocity[axis]];
        led(before.root_position[axis], now.root_position[axis], speeds)
    });
    let jump = largest(joints.chain(root));
    if is_at_most(jump, JUMP_MAX) {
        return Ok(());
    }
    Err(Violation::new(Check::Continuity, 0, format!("the robot jumps by {jump:.2e}")))
}
