//! Accelerations with which joints pass the waypoints of straight lines in time, with a continuous
//! speed and without ever moving against the lines.

use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::message::Waypoint;

/// For each joint an acceleration (rad/s2 or m/s2) that suffices, at rest at the first and the last
/// waypoint. `intervals` are the times between the waypoints, s.
///
/// At a waypoint the speed is 0 where the joint turns back, else the mean of those before and after
/// it by their times, at most twice the lower one: so the joint never turns back between two
/// waypoints, where it accelerates up to an instant and brakes from there, or the other way round.
pub fn needed_accelerations(waypoints: &[Waypoint], intervals: &[f64]) -> [f64; JOINTS_MAX] {
    std::array::from_fn(|joint| {
        let way = |index: usize| waypoints[index + 1].q[joint] - waypoints[index].q[joint];
        let last = waypoints.len().saturating_sub(1);
        let (mut needed, mut speed) = (0.0f64, 0.0);
        for index in 0..last {
            let after = if index + 1 < last {
                passing_speed(
                    [way(index), way(index + 1)],
                    [intervals[index], intervals[index + 1]],
                )
            } else {
                0.0
            };
            needed = needed.max(between(speed, after, way(index), intervals[index]));
            speed = after;
        }
        needed
    })
}

/// The speed at a waypoint between two ways and their times.
fn passing_speed([a, b]: [f64; 2], [a_time, b_time]: [f64; 2]) -> f64 {
    if a * b <= 0.0 {
        return 0.0;
    }
    let (before, after) = (a / a_time, b / b_time);
    let mean = (before * b_time + after * a_time) / (a_time + b_time);
    let most = 2.0 * before.abs().min(after.abs());
    mean.clamp(-most, most)
}

/// The acceleration from one speed to another over a way within some time.
fn between(from: f64, to: f64, way: f64, seconds: f64) -> f64 {
    // The acceleration `a` solves `|d - (u + w) t / 2| + (w - u)^2 / (4 a) = a t^2 / 4`.
    let (rest, change) = ((way - 0.5 * (from + to) * seconds).abs(), (to - from) * seconds);
    2.0 * (rest + (rest * rest + 0.25 * change * change).sqrt()) / (seconds * seconds)
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;

    fn needed(positions: &[f64], intervals: &[f64]) -> f64 {
        let waypoint = |position: &f64| {
            let mut waypoint = Waypoint::zeroed();
            waypoint.q[3] = *position;
            waypoint
        };
        let waypoints: Vec<Waypoint> = positions.iter().map(waypoint).collect();
        needed_accelerations(&waypoints, intervals)[3]
    }

    #[test]
    fn from_rest_to_rest_takes_four_times_the_way_over_the_time_squared() {
        assert!((needed(&[0.0, 0.1], &[0.5]) - 1.6).abs() < 1e-12);
        assert!((needed(&[0.0, -0.1], &[0.5]) - 1.6).abs() < 1e-12);
    }

    #[test]
    fn a_joint_that_turns_back_or_waits_is_at_rest_there() {
        assert!((needed(&[0.0, 0.1, 0.0], &[0.5, 0.5]) - 1.6).abs() < 1e-12);
        assert!((needed(&[0.0, 0.0, 0.1, 0.1], &[2.0, 0.5, 2.0]) - 1.6).abs() < 1e-12);
    }

    #[test]
    fn a_steady_joint_accelerates_at_the_ends_only() {
        // It is at full speed at the inner waypoints: 0.1 rad in 0.5 s from rest to 0.2 rad/s.
        let ends = between(0.0, 0.2, 0.1, 0.5);
        assert!((needed(&[0.0, 0.1, 0.2, 0.3], &[0.5; 3]) - ends).abs() < 1e-12, "{ends}");
        // Half of the way is left to catch up: u = 0, w = d / t takes (1 + sqrt 2) d / t^2.
        assert!((ends - (1.0 + 2.0f64.sqrt()) * 0.4).abs() < 1e-12, "{ends}");
    }
}
