//! The rule that says how the robot moves between two waypoints of a plan.
//!
//! With `s = (t - t0) / (t1 - t0)` between the waypoints at `t0` and `t1`:
//!
//! - *Linear*: joints and root position are linear in `s`. The root's rotation is
//!   `R0 exp(s log(R0' R1))`, the shortest arc at a constant speed. Velocity is constant within an
//!   interval and jumps at waypoints; the velocities and accelerations of waypoints are 0.
//! - *Quintic*: each joint and each root coordinate is the polynomial of degree 5 that has the
//!   position, velocity and acceleration of both waypoints. The root's rotation is
//!   `R0 exp(phi(t))`, where each coordinate of the rotation vector `phi` is such a polynomial:
//!   from 0 to `log(R0' R1)`, with the derivatives that give the angular velocities and
//!   accelerations of the waypoints.
//!
//! Torques are linear in `s` in both. `biped-plan/1` states the same rule for its optional fields.

use bytemuck::Zeroable;
use glam::{DQuat, DVec3};

use crate::base::limits::JOINTS_MAX;
use crate::base::spatial::{interpolate, rotation_from_scaled_axis, scaled_axis_from_rotation};
use crate::message::chunk::{PlanChunk, ROOT_FREEDOMS, Waypoint};
use crate::message::rotation_vector::{
    RotationRates, angular_from_vector_rates, vector_rates_from_angular,
};

/// How the robot moves between two waypoints.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u64)]
pub enum Interpolation {
    /// Straight lines at a constant speed.
    Linear = 0,
    /// Polynomials of degree 5 through positions, velocities and accelerations.
    Quintic = 1,
}

/// Position, velocity and acceleration of one number.
pub type Rates = [f64; 3];

impl PlanChunk {
    /// Whether its waypoints are joined smoothly.
    pub fn is_smooth(&self) -> bool {
        Interpolation::from_wire(self.interpolation) == Some(Interpolation::Quintic)
    }
}

impl Interpolation {
    /// The rule with this wire value, if the value is valid.
    pub fn from_wire(value: u64) -> Option<Self> {
        [Self::Linear, Self::Quintic].into_iter().find(|rule| *rule as u64 == value)
    }

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        ["linear", "quintic"][self as usize]
    }

    /// The robot at `time` (s) among waypoints, of which there is at least one: configuration,
    /// velocity, acceleration and torque. Before the first and after the last one it is at rest.
    /// At a waypoint of a linear motion the velocity is that of the interval after it.
    pub fn sample(self, waypoints: &[Waypoint], time: f64) -> Waypoint {
        let next = waypoints.partition_point(|waypoint| waypoint.time <= time);
        match (next.checked_sub(1).map(|at| &waypoints[at]), waypoints.get(next)) {
            (Some(from), Some(to)) => self.between(from, to, time),
            (Some(last), None) if last.time == time => *last,
            _ => waypoints[next.min(waypoints.len() - 1)].rested(),
        }
    }

    /// The robot at `time` (s) between two waypoints, of which the second one is later.
    pub fn between(self, from: &Waypoint, to: &Waypoint, time: f64) -> Waypoint {
        let (seconds, elapsed) = (to.time - from.time, time - from.time);
        let share = elapsed / seconds;
        let mut waypoint = match self {
            Self::Linear => linear(from, to, share),
            Self::Quintic => quintic_motion(from, to, time),
        };
        waypoint.time = time;
        waypoint.torque = mix(&from.torque, &to.torque, share);
        waypoint.rest_torque = mix(&from.rest_torque, &to.rest_torque, share);
        waypoint.rate_change_torque = mix(&from.rate_change_torque, &to.rate_change_torque, share);
        waypoint
    }
}

fn mix(from: &[f64; JOINTS_MAX], to: &[f64; JOINTS_MAX], share: f64) -> [f64; JOINTS_MAX] {
    std::array::from_fn(|joint| from[joint] + share * (to[joint] - from[joint]))
}

fn linear(from: &Waypoint, to: &Waypoint, share: f64) -> Waypoint {
    let rate = 1.0 / (to.time - from.time);
    let [start, end] = [from, to].map(Waypoint::world_from_root);
    let root = interpolate(&start, &end, share);
    let turn = scaled_axis_from_rotation(start.rotation.conjugate() * end.rotation);
    let speed = rate * (end.translation - start.translation);
    Waypoint {
        root_position: root.translation.to_array(),
        root_rotation: root.rotation.to_array(),
        q: mix(&from.q, &to.q, share),
        root_velocity: joined(speed, start.rotation * (rate * turn)),
        joint_velocity: std::array::from_fn(|joint| rate * (to.q[joint] - from.q[joint])),
        ..Waypoint::zeroed()
    }
}

/// The robot at `time` (s) between two waypoints of a quintic motion, without torques.
pub fn quintic_motion(from: &Waypoint, to: &Waypoint, time: f64) -> Waypoint {
    let (seconds, elapsed) = (to.time - from.time, time - from.time);
    let mut waypoint = Waypoint { time, ..Waypoint::zeroed() };
    for joint in 0..JOINTS_MAX {
        let state =
            |w: &Waypoint| [w.q[joint], w.joint_velocity[joint], w.joint_acceleration[joint]];
        let [from, to] = [state(from), state(to)];
        if stands(from, to) {
            // As the polynomial has it: never -0.
            waypoint.q[joint] = from[0] + 0.0;
            continue;
        }
        let [q, velocity, acceleration] = hermite(from, to, seconds, elapsed);
        waypoint.q[joint] = q;
        (waypoint.joint_velocity[joint], waypoint.joint_acceleration[joint]) =
            (velocity, acceleration);
    }
    let axis = |axis: usize| {
        let state = |w: &Waypoint| {
            [w.root_position[axis], w.root_velocity[axis], w.root_acceleration[axis]]
        };
        hermite(state(from), state(to), seconds, elapsed)
    };
    let [x, y, z] = [axis(0), axis(1), axis(2)];
    waypoint.root_position = [x[0], y[0], z[0]];
    let (rotation, rates) = quintic_rotation(from, to, seconds, elapsed);
    waypoint.root_rotation = rotation.to_array();
    waypoint.root_velocity = joined(DVec3::new(x[1], y[1], z[1]), rates.first);
    waypoint.root_acceleration = joined(DVec3::new(x[2], y[2], z[2]), rates.second);
    waypoint
}

/// The rotation, and angular velocity and acceleration along the world's axes.
fn quintic_rotation(
    from: &Waypoint,
    to: &Waypoint,
    seconds: f64,
    elapsed: f64,
) -> (DQuat, RotationRates) {
    let [start, end] = [from, to].map(|waypoint| DQuat::from_array(waypoint.root_rotation));
    let vector = scaled_axis_from_rotation(start.conjugate() * end);
    let begin = vector_rates_from_angular(DVec3::ZERO, &body_rates(from, start));
    let finish = vector_rates_from_angular(vector, &body_rates(to, end));
    let coordinate = |axis: usize| {
        let begin = [0.0, begin.first[axis], begin.second[axis]];
        let finish = [vector[axis], finish.first[axis], finish.second[axis]];
        hermite(begin, finish, seconds, elapsed)
    };
    let [x, y, z] = [coordinate(0), coordinate(1), coordinate(2)];
    let order = |order: usize| DVec3::new(x[order], y[order], z[order]);
    let rates = RotationRates { first: order(1), second: order(2) };
    let body = angular_from_vector_rates(order(0), &rates);
    let rotation = (start * rotation_from_scaled_axis(order(0))).normalize();
    (rotation, RotationRates { first: rotation * body.first, second: rotation * body.second })
}

/// Angular velocity and acceleration of a waypoint along the root's own axes.
fn body_rates(waypoint: &Waypoint, world_from_root: DQuat) -> RotationRates {
    let inverse = world_from_root.conjugate();
    let angular = |rates: &[f64; ROOT_FREEDOMS]| inverse * DVec3::new(rates[3], rates[4], rates[5]);
    RotationRates {
        first: angular(&waypoint.root_velocity),
        second: angular(&waypoint.root_acceleration),
    }
}

fn joined(linear: DVec3, angular: DVec3) -> [f64; ROOT_FREEDOMS] {
    [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
}

/// Whether the polynomial between two states is constant.
pub fn stands(from: Rates, to: Rates) -> bool {
    from[1] == 0.0 && from[2] == 0.0 && to == from
}

/// The quintic Hermite polynomial between two states that are `seconds` apart, `elapsed` seconds
/// after the first one.
pub fn hermite(from: Rates, to: Rates, seconds: f64, elapsed: f64) -> Rates {
    let [p, v, a] = from;
    // What the polynomial of degree 2 with the state `from` lacks at the end, in units of `s`.
    let position = to[0] - (p + seconds * (v + 0.5 * seconds * a));
    let velocity = seconds * (to[1] - (v + seconds * a));
    let acceleration = seconds * seconds * (to[2] - a);
    let c3 = 10.0 * position - 4.0 * velocity + 0.5 * acceleration;
    let c4 = -15.0 * position + 7.0 * velocity - acceleration;
    let c5 = 6.0 * position - 3.0 * velocity + 0.5 * acceleration;
    let s = elapsed / seconds;
    let rate = 1.0 / seconds;
    [
        p + elapsed * (v + 0.5 * elapsed * a) + s * s * s * (c3 + s * (c4 + s * c5)),
        v + elapsed * a + rate * s * s * (3.0 * c3 + s * (4.0 * c4 + 5.0 * s * c5)),
        a + rate * rate * s * (6.0 * c3 + s * (12.0 * c4 + 20.0 * s * c5)),
    ]
}
