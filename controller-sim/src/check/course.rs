//! How a motion goes from waypoint to waypoint, and where the robot may stop on the way.

use surefoot_shared_types::message::{PlanChunk, Waypoint};

use crate::base::comparison::is_at_most;
use crate::kinematics::trajectory;

/// Time between two instants of a ramp that are checked, s.
const RAMP_TICK: f64 = 0.02;
/// Fewest and most instants of a ramp that are checked; no message has a ramp that is longer.
const RAMP_TICKS: [f64; 2] = [10.0, 1000.0];
/// The largest speed of a robot at rest, m/s and rad/s: rounding.
const REST_SPEED_MAX: f64 = 1e-6;
/// Times are equal up to this rounding, s.
const TIME_ROUNDING: f64 = 1e-9;

/// How a motion goes from waypoint to waypoint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Course<'a> {
    /// In straight lines at a constant speed.
    Straight,
    /// By polynomials of degree 5, with these stops.
    Smooth(&'a [Stop]),
}

impl Course<'_> {
    /// The robot at instants of its stops within `waypoints`, each with the index of the waypoint
    /// before it.
    pub(crate) fn stop_instants(&self, waypoints: &[Waypoint]) -> Vec<(usize, Waypoint)> {
        match self {
            Self::Straight => Vec::new(),
            Self::Smooth(stops) => stops.iter().flat_map(|stop| stop.instants(waypoints)).collect(),
        }
    }

    /// A stop within `waypoints` at which the robot brakes or goes on within no time although it
    /// moves by the plan: the index of the waypoint before, and the plan time, s.
    pub(crate) fn abrupt_stop(&self, waypoints: &[Waypoint]) -> Option<(usize, f64)> {
        let Self::Smooth(stops) = self else { return None };
        let abrupt = stops.iter().filter(|stop| stop.seconds == 0.0 || stop.resume_seconds == 0.0);
        abrupt.map(Stop::rest_at).find_map(|time| {
            let (before, planned) = planned_at(waypoints, time)?;
            (!is_resting(&planned)).then_some((before, time))
        })
    }
}

/// Whether nothing moves at a waypoint.
pub fn is_resting(waypoint: &Waypoint) -> bool {
    let mut speeds = waypoint.root_velocity.iter().chain(&waypoint.joint_velocity);
    speeds.all(|speed| is_at_most(speed.abs(), REST_SPEED_MAX))
}

/// Where the robot stops if the next chunk does not come, and how it goes on from there: from plan
/// time `brake_at` (s) on, plan time slows down over `seconds` to a rest, and later speeds up over
/// `resume_seconds`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// The plan time at which the robot begins to brake, s.
    pub brake_at: f64,
    /// How long it brakes, s.
    pub seconds: f64,
    /// How long it takes to full speed when it goes on, s.
    pub resume_seconds: f64,
}

impl Stop {
    /// That of a chunk.
    pub fn of_chunk(chunk: &PlanChunk) -> Self {
        Self {
            brake_at: chunk.brake_at,
            seconds: chunk.brake_duration,
            resume_seconds: chunk.resume_duration,
        }
    }

    /// The plan time at which the robot rests, s.
    pub fn rest_at(&self) -> f64 {
        self.brake_at + 0.5 * self.seconds
    }

    /// Whether the robot brakes or goes on between two plan times (s).
    pub fn concerns(&self, begin: f64, end: f64) -> bool {
        self.brake_at <= end && begin <= self.rest_at() + 0.5 * self.resume_seconds
    }

    /// Where the robot comes to rest if it executes a chunk and no other: within a smooth chunk, at
    /// the end of straight lines.
    pub fn rest(chunk: &PlanChunk) -> Waypoint {
        let waypoints = chunk.waypoints();
        let end = waypoints[waypoints.len() - 1];
        let time = Self::of_chunk(chunk).rest_at();
        let next = waypoints.partition_point(|waypoint| waypoint.time <= time);
        let is_inside = chunk.is_smooth() && (1..waypoints.len()).contains(&next);
        if is_inside {
            trajectory::between(&waypoints[next - 1], &waypoints[next], time).rested()
        } else {
            end.rested()
        }
    }

    /// The robot while it brakes and while it goes on, at instants within the time of `waypoints`,
    /// each with the index of the waypoint before it.
    pub(crate) fn instants(&self, waypoints: &[Waypoint]) -> Vec<(usize, Waypoint)> {
        let mut instants = Vec::new();
        for (begin, seconds, brakes) in
            [(self.brake_at, self.seconds, true), (self.rest_at(), self.resume_seconds, false)]
        {
            let ticks = (seconds / RAMP_TICK).ceil().clamp(RAMP_TICKS[0], RAMP_TICKS[1]) as usize;
            instants.extend((0..=ticks).filter(|_| seconds > 0.0).filter_map(|tick| {
                let PlanRate { elapsed, rate, change } =
                    PlanRate::of_ramp(tick as f64 / ticks as f64, seconds, brakes);
                let (before, planned) = planned_at(waypoints, begin + elapsed)?;
                Some((before, at_rate(planned, rate, change)))
            }));
        }
        instants
    }
}

/// Plan time during a ramp.
pub(crate) struct PlanRate {
    /// Plan time since the beginning of the ramp, s.
    pub(crate) elapsed: f64,
    /// Seconds of the plan a second.
    pub(crate) rate: f64,
    /// The change of the rate, 1/s.
    pub(crate) change: f64,
}

impl PlanRate {
    /// After a share of a ramp of `seconds` s, down from 1 or up from 0.
    pub(crate) fn of_ramp(share: f64, seconds: f64, brakes: bool) -> Self {
        let [u2, u3] = [share.powi(2), share.powi(3)];
        let rise = 10.0 * u3 - 15.0 * u3 * share + 6.0 * u3 * u2;
        let area = 2.5 * u2 * u2 - 3.0 * u2 * u3 + u3 * u3;
        let slope = 30.0 * u2 * (1.0 - share) * (1.0 - share) / seconds;
        if brakes {
            Self { elapsed: seconds * (share - area), rate: 1.0 - rise, change: -slope }
        } else {
            Self { elapsed: seconds * area, rate: rise, change: slope }
        }
    }
}

/// The planned motion at a time within that of `waypoints`, and the index of the waypoint before.
pub(crate) fn planned_at(waypoints: &[Waypoint], time: f64) -> Option<(usize, Waypoint)> {
    let next = waypoints.partition_point(|waypoint| waypoint.time <= time);
    let before = next.checked_sub(1)?.min(waypoints.len().checked_sub(2)?);
    let last = &waypoints[before + 1];
    let is_inside = is_at_most(time, last.time + TIME_ROUNDING);
    is_inside.then(|| (before, trajectory::between(&waypoints[before], last, time.min(last.time))))
}

/// The motion if plan time passes at `rate`, which changes by `change` a second.
pub(crate) fn at_rate(mut waypoint: Waypoint, rate: f64, change: f64) -> Waypoint {
    let root = waypoint.root_acceleration.iter_mut().zip(&mut waypoint.root_velocity);
    let joints = waypoint.joint_acceleration.iter_mut().zip(&mut waypoint.joint_velocity);
    for (acceleration, velocity) in root.chain(joints) {
        *acceleration = rate * rate * *acceleration + change * *velocity;
        *velocity *= rate;
    }
    for (joint, torque) in waypoint.torque.iter_mut().enumerate() {
        let rest = waypoint.rest_torque[joint];
        *torque =
            rest + rate * rate * (*torque - rest) + change * waypoint.rate_change_torque[joint];
    }
    waypoint
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;
    use surefoot_shared_types::base::limits::JOINTS_MAX;
    use surefoot_shared_types::message::{Interpolation, Ramp};

    use super::*;

    #[test]
    fn the_checkers_own_ramps_agree_with_those_of_the_messages() {
        for (ramp, brakes) in
            [(Ramp::Brake { seconds: 0.7 }, true), (Ramp::Resume { seconds: 0.7 }, false)]
        {
            for tick in 0..=20 {
                let share = 0.05 * f64::from(tick);
                let own = PlanRate::of_ramp(share, 0.7, brakes);
                let rule = ramp.at(0.7 * share);
                let instants = [at_rate(pair()[1], own.rate, own.change), rule.apply(&pair()[1])];
                let [of_own, of_rule] = instants.map(|instant| instant.rates().collect::<Vec<_>>());
                assert!(of_own.iter().zip(&of_rule).all(|(a, b)| (a - b).abs() < 1e-12));
                let numbers = [own.elapsed, own.rate, own.change];
                for (a, b) in numbers.iter().zip([rule.elapsed, rule.rate, rule.rate_change]) {
                    assert!((a - b).abs() < 1e-12, "{share}: {a} {b}");
                }
            }
        }
    }

    #[test]
    fn a_stop_within_no_time_is_abrupt_where_the_plan_moves() {
        let [first, second] = pair();
        let still = Waypoint { time: 2.0, ..second }.rested();
        let waypoints = [first, second, still];
        let abrupt = |stop: Stop| Course::Smooth(&[stop]).abrupt_stop(&waypoints);
        let stop = |brake_at: f64, seconds: f64, resume_seconds: f64| Stop {
            brake_at,
            seconds,
            resume_seconds,
        };
        assert_eq!(abrupt(stop(0.5, 0.0, 0.4)), Some((0, 0.5)));
        assert_eq!(abrupt(stop(1.0, 0.4, 0.0)), Some((1, 1.2)));
        assert_eq!(abrupt(stop(0.5, 0.4, 0.4)), None);
        assert_eq!(abrupt(stop(2.0, 0.0, 0.0)), None, "the plan rests there");
        assert_eq!(abrupt(stop(2.5, 0.0, 0.0)), None, "in another segment");
        assert_eq!(Course::Straight.abrupt_stop(&waypoints), None);
    }

    #[test]
    fn the_instants_of_a_stop_lie_within_the_waypoints() {
        let at = |time: f64| Waypoint {
            time,
            root_rotation: [0.0, 0.0, 0.0, 1.0],
            ..Waypoint::zeroed()
        };
        let stop = Stop { brake_at: 0.3, seconds: 0.4, resume_seconds: 0.6 };
        let times = |begin: f64, end: f64| -> Vec<f64> {
            let waypoints = [at(begin), at(end)];
            stop.instants(&waypoints).iter().map(|(_, instant)| instant.time).collect()
        };
        // It rests at 0.5 s, and is back at full speed at 0.8 s: 21 and 31 instants.
        assert_eq!(times(0.0, 1.0).len(), 52);
        assert!(times(0.0, 0.3).len() == 1 && times(0.9, 1.0).is_empty());
        let (before, after) = (times(0.0, 0.5), times(0.5, 1.0));
        assert!(before.len() >= 21 && after.len() >= 31, "{} {}", before.len(), after.len());
        assert!(after.iter().all(|time| (0.5..=0.8 + 1e-12).contains(time)));
        assert!(stop.concerns(0.8, 0.9) && !stop.concerns(0.81, 0.9) && !stop.concerns(0.0, 0.29));
    }

    /// A motion from one state to another within a second.
    fn pair() -> [Waypoint; 2] {
        let at = |time: f64, sign: f64| {
            let mut waypoint =
                Waypoint { time, root_rotation: [0.0, 0.0, 0.0, 1.0], ..Waypoint::zeroed() };
            waypoint.q[3] = 0.4 * sign;
            waypoint.joint_velocity[3] = 0.3 - 0.2 * sign;
            waypoint.joint_acceleration[3] = 1.5 * sign;
            waypoint.root_position[1] = 0.1 * sign;
            waypoint.root_velocity[1] = 0.2;
            (waypoint.torque[3], waypoint.rest_torque[3]) = (8.0, 4.0);
            waypoint.rate_change_torque[3] = 0.5;
            waypoint
        };
        [at(0.0, -1.0), at(1.0, 1.0)]
    }

    #[test]
    fn velocity_and_acceleration_of_a_ramp_are_derivatives_of_its_position() {
        let (waypoints, seconds, begin) = (pair(), 0.5, 0.3);
        for brakes in [true, false] {
            let at = |time: f64| {
                let PlanRate { elapsed, rate, change } =
                    PlanRate::of_ramp(time / seconds, seconds, brakes);
                let (_, planned) = planned_at(&waypoints, begin + elapsed).unwrap();
                at_rate(planned, rate, change)
            };
            for time in [0.05, 0.2, 0.31, 0.45] {
                let step = 1e-4;
                let [before, here, after] = [time - step, time, time + step].map(at);
                let derivative =
                    |of: fn(&Waypoint) -> f64| (of(&after) - of(&before)) / (2.0 * step);
                let is_near = |a: f64, b: f64| (a - b).abs() < 1e-5;
                assert!(is_near(derivative(|at| at.q[3]), here.joint_velocity[3]));
                assert!(is_near(derivative(|at| at.joint_velocity[3]), here.joint_acceleration[3]));
                assert!(is_near(derivative(|at| at.root_position[1]), here.root_velocity[1]));
                assert!(is_near(derivative(|at| at.root_velocity[1]), here.root_acceleration[1]));
            }
        }
    }

    #[test]
    fn the_rest_of_a_chunk_lies_on_its_curve_at_the_plan_time_of_the_rest() {
        let [first, second] = pair();
        let third = Waypoint { time: 2.0, q: [0.2; JOINTS_MAX], ..second };
        let rest = |brake_at: f64, interpolation: Interpolation| {
            let mut chunk = Box::new(PlanChunk::zeroed());
            (chunk.waypoints[0], chunk.waypoints[1], chunk.waypoints[2]) = (first, second, third);
            chunk.waypoints_len = 3;
            chunk.interpolation = interpolation as u64;
            (chunk.brake_at, chunk.brake_duration) = (brake_at, 0.4);
            Stop::rest(&chunk)
        };
        for (brake_at, from, to) in [(0.1, first, second), (0.8, second, third)] {
            let time = brake_at + 0.2;
            let found = rest(brake_at, Interpolation::Quintic);
            assert_eq!(found, trajectory::between(&from, &to, time).rested());
            assert_eq!(rest(brake_at, Interpolation::Linear), third.rested());
        }
        let between = rest(1.3, Interpolation::Quintic);
        assert_eq!(between, trajectory::between(&second, &third, 1.5).rested());
        assert_eq!(rest(1.8, Interpolation::Quintic), third.rested());
        assert_eq!(rest(2.5, Interpolation::Quintic), third.rested());
    }
}
