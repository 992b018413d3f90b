//! How a motion goes from waypoint to waypoint, and where the robot may stop on the way.

use surefoot_shared_types::message::{Interpolation, PlanChunk, Waypoint};

use crate::kinematics::trajectory;

/// Time between two instants of a stop that are checked, s.
const STOP_TICK: f64 = 0.02;
/// Most instants of a stop that are checked.
const STOP_TICKS_MAX: f64 = 100.0;

/// How a motion goes from waypoint to waypoint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Course<'a> {
    /// In straight lines at a constant speed.
    Straight,
    /// By polynomials of degree 5, with these stops.
    Smooth(&'a [Stop]),
}

/// Where the robot stops if the next chunk does not come: from plan time `brake_at` (s) on, plan
/// time slows down over `seconds`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// The plan time at which the robot begins to brake, s.
    pub brake_at: f64,
    /// How long it brakes, s.
    pub seconds: f64,
}

impl Stop {
    /// That of a chunk.
    pub fn of_chunk(chunk: &PlanChunk) -> Self {
        Self { brake_at: chunk.brake_at, seconds: chunk.brake_duration }
    }

    /// Whether the chunk moves smoothly.
    pub fn is_smooth(chunk: &PlanChunk) -> bool {
        Interpolation::from_wire(chunk.interpolation) == Some(Interpolation::Quintic)
    }

    /// Where the robot comes to rest if it executes a chunk and no other: within a smooth chunk, at
    /// the end of straight lines.
    pub fn rest(chunk: &PlanChunk) -> Waypoint {
        let waypoints = chunk.waypoints();
        let end = waypoints[waypoints.len() - 1];
        let time = chunk.brake_at + 0.5 * chunk.brake_duration;
        let next = waypoints.partition_point(|waypoint| waypoint.time <= time);
        let is_inside = Self::is_smooth(chunk) && (1..waypoints.len()).contains(&next);
        if is_inside {
            trajectory::between(&waypoints[next - 1], &waypoints[next], time).rested()
        } else {
            end.rested()
        }
    }

    /// The robot while it brakes, at instants within the time of `waypoints`, each with the index
    /// of the waypoint before it.
    pub(crate) fn instants(&self, waypoints: &[Waypoint]) -> Vec<(usize, Waypoint)> {
        let ticks = (self.seconds / STOP_TICK).ceil().clamp(1.0, STOP_TICKS_MAX) as usize;
        let instant = |tick: usize| {
            let share = tick as f64 / ticks as f64;
            let (advance, rate, change) = self.slowed(share);
            let time = self.brake_at + advance;
            let next = waypoints.partition_point(|waypoint| waypoint.time <= time);
            let before = next.checked_sub(1)?.min(waypoints.len().checked_sub(2)?);
            let last = &waypoints[before + 1];
            if time > last.time + 1e-9 {
                return None;
            }
            let planned = trajectory::between(&waypoints[before], last, time.min(last.time));
            Some((before, at_rate(planned, rate, change)))
        };
        (0..=ticks).filter_map(instant).collect()
    }

    /// How far plan time has advanced after a share of the stop, its rate, and the rate's change.
    fn slowed(&self, share: f64) -> (f64, f64, f64) {
        let [u2, u3] = [share.powi(2), share.powi(3)];
        let rate = 1.0 - 10.0 * u3 + 15.0 * u3 * share - 6.0 * u3 * u2;
        let advance = share - 2.5 * u2 * u2 + 3.0 * u2 * u3 - u3 * u3;
        let seconds = self.seconds;
        let change =
            if seconds > 0.0 { -30.0 * u2 * (1.0 - share) * (1.0 - share) / seconds } else { 0.0 };
        (seconds * advance, if seconds > 0.0 { rate } else { 0.0 }, change)
    }
}

/// The motion if plan time passes at `rate`, which changes by `change` a second.
fn at_rate(mut waypoint: Waypoint, rate: f64, change: f64) -> Waypoint {
    let root = waypoint.root_acceleration.iter_mut().zip(&mut waypoint.root_velocity);
    let joints = waypoint.joint_acceleration.iter_mut().zip(&mut waypoint.joint_velocity);
    for (acceleration, velocity) in root.chain(joints) {
        *acceleration = rate * rate * *acceleration + change * *velocity;
        *velocity *= rate;
    }
    waypoint
}
