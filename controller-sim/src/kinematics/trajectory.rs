//! The motion between two waypoints of a smooth chunk, by the checker's own evaluation of the rule
//! in `message/interpolation.rs`: polynomials of degree 5 in time.
//!
//! The polynomials are solved from their end conditions as power series. Rotations go through the
//! quaternion `e(v) = (cos |v|/2, v sinc(|v|/2)/2)` of the rotation vector `v` and its derivatives
//! by the chain rule: the body's angular velocity is `2 e* e'`, its derivative `2 e* e''`.

use glam::{DMat3, DQuat, DVec3};
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::base::spatial::scaled_axis_from_rotation;
use surefoot_shared_types::message::Waypoint;

use crate::base::comparison::{is_at_most, largest};

/// The largest distance of the curve from the straight line between two knots, rad and m.
const DEVIATION_MAX: f64 = 2e-4;
/// The largest difference of the acceleration from the mean of those at two successive knots,
/// weighted by time: of the root's position, m/s2, and of joints and of the root's rotation, rad/s2
/// (m/s2 of a prismatic joint).
const ROOT_ACCELERATION_DEVIATION_MAX: f64 = 0.1;
const ACCELERATION_DEVIATION_MAX: f64 = 1.0;
/// Most pieces into which the curve between two waypoints is divided.
const PIECES_MAX: usize = 64;
/// Below this angle (rad) power series replace quotients that lose their digits.
const SERIES_BELOW: f64 = 1e-2;

/// Position, velocity and acceleration.
type Derivatives = [f64; 3];

/// The motion at `time` (s) between two waypoints, of which the second one is later, with its
/// torques, which change evenly.
pub(crate) fn between(from: &Waypoint, to: &Waypoint, time: f64) -> Waypoint {
    let elapsed = time - from.time;
    let mut waypoint = Waypoint { time, ..*from };
    for joint in 0..JOINTS_MAX {
        let [q, velocity, acceleration] = joint_curve(from, to, joint).at(elapsed);
        waypoint.q[joint] = q;
        waypoint.joint_velocity[joint] = velocity;
        waypoint.joint_acceleration[joint] = acceleration;
    }
    for axis in 0..3 {
        let [position, velocity, acceleration] = root_curve(from, to, axis).at(elapsed);
        waypoint.root_position[axis] = position;
        waypoint.root_velocity[axis] = velocity;
        waypoint.root_acceleration[axis] = acceleration;
    }
    turn_root(&mut waypoint, [from, to], elapsed);
    let share = elapsed / (to.time - from.time);
    for (torques, last) in [
        (&mut waypoint.torque, &to.torque),
        (&mut waypoint.rest_torque, &to.rest_torque),
        (&mut waypoint.rate_change_torque, &to.rate_change_torque),
    ] {
        torques.iter_mut().zip(last).for_each(|(torque, last)| *torque += share * (last - *torque));
    }
    waypoint
}

/// Waypoints of straight lines that stay within [`DEVIATION_MAX`] of the curve through `waypoints`,
/// these among them, each with the index of the waypoint at or before it.
///
/// # Errors
/// The first waypoint after which that takes more than [`PIECES_MAX`] lines.
pub(crate) fn knots(waypoints: &[Waypoint]) -> Result<Vec<(usize, Waypoint)>, usize> {
    let mut knots = Vec::new();
    for (index, pair) in waypoints.windows(2).enumerate() {
        let [from, to] = [&pair[0], &pair[1]];
        knots.push((index, *from));
        let count = piece_count(from, to).ok_or(index)?;
        let seconds = to.time - from.time;
        for knot in 1..count {
            let time = from.time + seconds * knot as f64 / count as f64;
            knots.push((index, between(from, to, time)));
        }
    }
    knots.extend(waypoints.last().map(|last| (waypoints.len() - 1, *last)));
    Ok(knots)
}

/// A function whose second derivative is at most `a` is at most `a t^2 / 8` from its chord over a
/// time `t`; that bounds the way to the straight line, and what the acceleration does between two
/// knots. Nothing where more than [`PIECES_MAX`] pieces are needed or a number is not finite.
fn piece_count(from: &Waypoint, to: &Waypoint) -> Option<usize> {
    let seconds = to.time - from.time;
    let turn_or_joint = |curve: Quintic| curve.bend(seconds, ACCELERATION_DEVIATION_MAX);
    let joints = (0..JOINTS_MAX).map(|joint| joint_curve(from, to, joint));
    let turning = joints.chain(turn_curves(from, to)).map(turn_or_joint);
    let root = (0..3).map(|axis| root_curve(from, to, axis));
    let moving = root.map(|curve| curve.bend(seconds, ROOT_ACCELERATION_DEVIATION_MAX));
    let count = (seconds * (largest(turning.chain(moving)) / 8.0).sqrt()).ceil();
    is_at_most(count, PIECES_MAX as f64).then(|| (count as usize).max(2))
}

fn joint_curve(from: &Waypoint, to: &Waypoint, joint: usize) -> Quintic {
    let at = |w: &Waypoint| [w.q[joint], w.joint_velocity[joint], w.joint_acceleration[joint]];
    Quintic::new(at(from), at(to), to.time - from.time)
}

/// One coordinate of the root's position.
fn root_curve(from: &Waypoint, to: &Waypoint, axis: usize) -> Quintic {
    let at =
        |w: &Waypoint| [w.root_position[axis], w.root_velocity[axis], w.root_acceleration[axis]];
    Quintic::new(at(from), at(to), to.time - from.time)
}

/// The coordinates of the root's rotation vector from the first waypoint on.
fn turn_curves(from: &Waypoint, to: &Waypoint) -> [Quintic; 3] {
    let [start, end] = [from, to].map(|w| DQuat::from_array(w.root_rotation).normalize());
    let turn = scaled_axis_from_rotation(start.conjugate() * end);
    let begin = vector_rates(DVec3::ZERO, angular_rates(from, start));
    let finish = vector_rates(turn, angular_rates(to, end));
    std::array::from_fn(|axis| {
        let first = [0.0, begin[0][axis], begin[1][axis]];
        let last = [turn[axis], finish[0][axis], finish[1][axis]];
        Quintic::new(first, last, to.time - from.time)
    })
}

/// A polynomial of degree 5 in time, lowest power first.
struct Quintic([f64; 6]);

impl Quintic {
    /// From one state to another within `duration` s.
    fn new(from: Derivatives, to: Derivatives, duration: f64) -> Self {
        let t = duration;
        let [p0, v0, a0] = from;
        let [p1, v1, a1] = to;
        let rise = p1 - p0;
        let (t2, t3) = (t * t, t * t * t);
        let cubic = (20.0 * rise - (8.0 * v1 + 12.0 * v0) * t - (3.0 * a0 - a1) * t2) / (2.0 * t3);
        let quartic = (-30.0 * rise + (14.0 * v1 + 16.0 * v0) * t + (3.0 * a0 - 2.0 * a1) * t2)
            / (2.0 * t3 * t);
        let quintic = (12.0 * rise - 6.0 * (v1 + v0) * t - (a0 - a1) * t2) / (2.0 * t3 * t2);
        Self([p0, v0, 0.5 * a0, cubic, quartic, quintic])
    }

    fn at(&self, time: f64) -> Derivatives {
        let (mut p, mut v, mut half_a) = (0.0, 0.0, 0.0);
        for coefficient in self.0.iter().rev() {
            half_a = half_a * time + v;
            v = v * time + p;
            p = p * time + coefficient;
        }
        [p, v, 2.0 * half_a]
    }

    /// The second derivatives of position and acceleration until `duration`, the larger one, each
    /// as a multiple of the deviation that is allowed.
    fn bend(&self, duration: f64, acceleration_deviation: f64) -> f64 {
        largest([
            self.acceleration_bound(duration) / DEVIATION_MAX,
            self.snap_bound(duration) / acceleration_deviation,
        ])
    }

    /// The largest second derivative of the acceleration until `duration`, that of its ends.
    fn snap_bound(&self, duration: f64) -> f64 {
        let [.., c4, c5] = self.0;
        largest([24.0 * c4, 24.0 * c4 + 120.0 * c5 * duration].map(f64::abs))
    }

    /// At least the largest acceleration until `duration`: that of the cubic's control points.
    fn acceleration_bound(&self, duration: f64) -> f64 {
        let [_, _, c2, c3, c4, c5] = self.0;
        let (t, t2) = (duration, duration * duration);
        let (p0, p1, p2, p3) = (2.0 * c2, 6.0 * c3 * t, 12.0 * c4 * t2, 20.0 * c5 * t2 * t);
        let control = [p0, p0 + p1 / 3.0, p0 + (2.0 * p1 + p2) / 3.0, p0 + p1 + p2 + p3];
        largest(control.map(f64::abs))
    }
}

/// Sets the root's rotation, angular velocity and angular acceleration.
fn turn_root(waypoint: &mut Waypoint, [from, to]: [&Waypoint; 2], elapsed: f64) {
    let start = DQuat::from_array(from.root_rotation).normalize();
    let states = turn_curves(from, to).map(|curve| curve.at(elapsed));
    let order = |order: usize| DVec3::from_array(states.map(|state| state[order]));
    let [unit, first, second] = quaternion_derivatives(order(0), order(1), order(2));
    let rotation = (start * unit).normalize();
    let [omega, alpha] =
        [first, second].map(|rate| rotation * (2.0 * (unit.conjugate() * rate).xyz()));
    waypoint.root_rotation = rotation.to_array();
    for axis in 0..3 {
        waypoint.root_velocity[3 + axis] = omega[axis];
        waypoint.root_acceleration[3 + axis] = alpha[axis];
    }
}

/// Angular velocity and acceleration of a waypoint along the root's own axes.
fn angular_rates(waypoint: &Waypoint, world_from_root: DQuat) -> [DVec3; 2] {
    [waypoint.root_velocity, waypoint.root_acceleration]
        .map(|rates| world_from_root.conjugate() * DVec3::new(rates[3], rates[4], rates[5]))
}

/// The derivatives of the rotation vector `vector` for an angular velocity and acceleration along
/// the body's axes. Both depend linearly on the derivatives; the columns are measured.
fn vector_rates(vector: DVec3, [omega, alpha]: [DVec3; 2]) -> [DVec3; 2] {
    let body_rates = |first: DVec3, second: DVec3| {
        let [unit, rate, change] = quaternion_derivatives(vector, first, second);
        [rate, change].map(|derivative| 2.0 * (unit.conjugate() * derivative).xyz())
    };
    let column = |axis: DVec3| body_rates(axis, DVec3::ZERO)[0];
    let inverse = DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z)).inverse();
    let first = inverse * omega;
    let without_second = body_rates(first, DVec3::ZERO)[1];
    [first, inverse * (alpha - without_second)]
}

/// The unit quaternion of a rotation vector and its first and second derivative, for a vector with
/// these derivatives.
fn quaternion_derivatives(vector: DVec3, first: DVec3, second: DVec3) -> [DQuat; 3] {
    // With s = |v|^2: cos(|v|/2) = c(s) and sin(|v|/2) / |v| = k(s). c' = -k / 4.
    let s = vector.length_squared();
    let rate = 2.0 * vector.dot(first);
    let change = 2.0 * (first.length_squared() + vector.dot(second));
    let [c, k, k1, k2] = half_angle_series(s);
    let scalar = [c, -0.25 * k * rate, -0.25 * (k1 * rate * rate + k * change)];
    let (k_rate, k_change) = (k1 * rate, k2 * rate * rate + k1 * change);
    let parts = [
        k * vector,
        k_rate * vector + k * first,
        k_change * vector + 2.0 * k_rate * first + k * second,
    ];
    [0, 1, 2].map(|order| DQuat::from_vec4(parts[order].extend(scalar[order])))
}

/// `c`, `k` and the first and second derivative of `k`, all by the squared angle.
fn half_angle_series(s: f64) -> [f64; 4] {
    let angle = s.sqrt();
    let (sin, cos) = libm::sincos(0.5 * angle);
    if angle < SERIES_BELOW {
        return [
            cos,
            0.5 - s * (1.0 / 48.0 - s / 3840.0),
            -1.0 / 48.0 + s * (1.0 / 1920.0 - s / 215_040.0),
            1.0 / 1920.0 - s / 107_520.0,
        ];
    }
    let k = sin / angle;
    let k1 = (0.25 * cos - 0.5 * k) / s;
    let k2 = (-0.0625 * k - 1.5 * k1) / s;
    [cos, k, k1, k2]
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;
    use surefoot_shared_types::base::spatial::{rotation_distance, rotation_from_scaled_axis};
    use surefoot_shared_types::message::Interpolation;

    use super::*;

    fn waypoint(seed: u32, time: f64, turn: f64) -> Waypoint {
        let at = |index: u32| libm::sin(f64::from(100 * seed + index) * 12.9898 + 0.3);
        let mut waypoint = Waypoint { time, ..Waypoint::zeroed() };
        let vector = turn * DVec3::new(at(1), at(2), at(3));
        waypoint.root_rotation = rotation_from_scaled_axis(vector).to_array();
        waypoint.root_position = [at(4), at(5), at(6)];
        for index in 0..6 {
            waypoint.root_velocity[index] = at(7 + index as u32);
            waypoint.root_acceleration[index] = 4.0 * at(13 + index as u32);
        }
        waypoint.q[2] = at(20);
        waypoint.joint_velocity[2] = 3.0 * at(30);
        waypoint.joint_acceleration[2] = 9.0 * at(40);
        waypoint
    }

    /// A waypoint with a twentieth of all numbers.
    fn gentle(seed: u32, time: f64) -> Waypoint {
        let mut waypoint = waypoint(seed, time, 0.05);
        let numbers = waypoint.root_position.iter_mut().chain(&mut waypoint.q);
        let rates = waypoint.root_velocity.iter_mut().chain(&mut waypoint.root_acceleration);
        let joints = waypoint.joint_velocity.iter_mut().chain(&mut waypoint.joint_acceleration);
        numbers.chain(rates).chain(joints).for_each(|number| *number *= 0.05);
        waypoint
    }

    #[test]
    fn the_checkers_own_evaluation_agrees_with_the_rule_of_the_messages() {
        for (seed, turn) in [(1, 0.0), (2, 0.004), (3, 0.2), (4, 1.2)] {
            let ends = [waypoint(seed, 2.0, turn), waypoint(seed + 50, 2.3, turn)];
            for tick in 0..=30 {
                let time = 2.0 + 0.01 * f64::from(tick);
                let own = between(&ends[0], &ends[1], time);
                let rule = Interpolation::Quintic.between(&ends[0], &ends[1], time);
                let rotation = |w: &Waypoint| DQuat::from_array(w.root_rotation);
                assert!(rotation_distance(rotation(&own), rotation(&rule)) < 1e-10);
                let numbers = |w: &Waypoint| {
                    let rates = w.root_velocity.into_iter().chain(w.root_acceleration);
                    let joints = [w.q[2], w.joint_velocity[2], w.joint_acceleration[2]];
                    rates.chain(w.root_position).chain(joints).collect::<Vec<f64>>()
                };
                for (a, b) in numbers(&own).iter().zip(numbers(&rule)) {
                    assert!((a - b).abs() < 1e-7, "turn {turn} at {time}: {a} {b}");
                }
            }
        }
    }

    #[test]
    fn straight_lines_between_knots_stay_near_the_curve() {
        let waypoints = [gentle(1, 0.0), gentle(2, 0.4)];
        let knots = knots(&waypoints).unwrap();
        assert_eq!((knots[0].1, knots[knots.len() - 1]), (waypoints[0], (1, waypoints[1])));
        for pair in knots.windows(2) {
            let [(_, a), (_, b)] = [&pair[0], &pair[1]];
            let middle = between(&waypoints[0], &waypoints[1], 0.5 * (a.time + b.time));
            let chord = 0.5 * (a.q[2] + b.q[2]);
            assert!((middle.q[2] - chord).abs() <= DEVIATION_MAX);
        }
    }

    #[test]
    fn accelerations_between_knots_are_near_those_at_the_knots() {
        // From rest to rest, nothing accelerates in the middle.
        let still = Waypoint { root_rotation: [0.0, 0.0, 0.0, 1.0], ..Waypoint::zeroed() };
        let mut moved = Waypoint { time: 0.02, ..still };
        (moved.q[2], moved.root_position[1]) = (3e-4, 2e-4);
        for pair in [[still, moved], [gentle(1, 0.0), gentle(2, 0.4)]] {
            let [from, to] = &pair;
            for knots in knots(&pair).unwrap().windows(2) {
                let [(_, a), (_, b)] = [&knots[0], &knots[1]];
                for share in [0.25, 0.5, 0.75] {
                    let at = between(from, to, a.time + share * (b.time - a.time));
                    let off = |of: fn(&Waypoint) -> f64| {
                        let chord = of(a) + share * (of(b) - of(a));
                        (of(&at) - chord).abs()
                    };
                    assert!(off(|at| at.joint_acceleration[2]) <= ACCELERATION_DEVIATION_MAX);
                    let root = off(|at| at.root_acceleration[1]);
                    assert!(root <= ROOT_ACCELERATION_DEVIATION_MAX, "{root}");
                }
            }
        }
    }

    #[test]
    fn a_curve_that_bends_too_much_or_is_no_curve_has_no_knots() {
        let mut waypoints = [gentle(1, 0.0), gentle(2, 0.4), gentle(3, 0.8)];
        assert!(knots(&waypoints).is_ok());
        waypoints[2].joint_acceleration[2] = 1e5;
        assert_eq!(knots(&waypoints), Err(1));
        waypoints[1].root_velocity[4] = f64::NAN;
        assert_eq!(knots(&waypoints), Err(0));
    }

    #[test]
    fn no_acceleration_exceeds_its_bound() {
        for seed in 1..40 {
            let ends = [waypoint(seed, 0.0, 0.1), waypoint(seed + 50, 0.4, 0.1)];
            let curve = joint_curve(&ends[0], &ends[1], 2);
            let bound = curve.acceleration_bound(0.4);
            let samples = (0..=40).map(|tick| curve.at(0.01 * f64::from(tick))[2].abs());
            let most = largest(samples);
            assert!(most <= bound * (1.0 + 1e-12) && bound <= 5.5 * most, "{most} {bound}");
        }
    }
}
