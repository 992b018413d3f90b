//! The rule of interpolation: it passes through its waypoints, and velocity and acceleration are
//! the derivatives of the configuration.

use bytemuck::Zeroable;
use glam::{DQuat, DVec3};
use surefoot_shared_types::base::spatial::{
    rotation_distance, rotation_from_scaled_axis, scaled_axis_from_rotation,
};
use surefoot_shared_types::message::{Interpolation, Waypoint};

/// A number between -1 and 1 for each index.
fn number(index: u32) -> f64 {
    libm::sin(f64::from(index) * 12.9898 + 0.3)
}

/// A waypoint with arbitrary motion; its root is turned by about `turn` rad.
fn waypoint(seed: u32, time: f64, turn: f64) -> Waypoint {
    let at = |index: u32| number(100 * seed + index);
    let mut waypoint = Waypoint { time, ..Waypoint::zeroed() };
    let rotation = rotation_from_scaled_axis(turn * DVec3::new(at(1), at(2), at(3)));
    waypoint.root_rotation = rotation.to_array();
    waypoint.root_position = [at(4), at(5), at(6)];
    for index in 0..6 {
        waypoint.root_velocity[index] = 2.0 * at(7 + index as u32);
        waypoint.root_acceleration[index] = 5.0 * at(13 + index as u32);
    }
    for index in 0..4 {
        waypoint.q[index] = at(20 + index as u32);
        waypoint.joint_velocity[index] = 3.0 * at(30 + index as u32);
        waypoint.joint_acceleration[index] = 9.0 * at(40 + index as u32);
        waypoint.torque[index] = 50.0 * at(50 + index as u32);
        waypoint.rest_torque[index] = 50.0 * at(60 + index as u32);
        waypoint.rate_change_torque[index] = 5.0 * at(70 + index as u32);
    }
    waypoint
}

/// The largest difference of any number of two waypoints.
fn difference(a: &Waypoint, b: &Waypoint) -> f64 {
    let numbers = |w: &Waypoint| {
        let body = w.root_position.into_iter().chain(w.q).chain(w.rates());
        body.collect::<Vec<f64>>()
    };
    let rotation = |w: &Waypoint| DQuat::from_array(w.root_rotation);
    let largest = numbers(a)
        .iter()
        .zip(numbers(b))
        .fold(0.0, |largest: f64, (x, y)| largest.max((x - y).abs()));
    largest.max(rotation_distance(rotation(a), rotation(b)))
}

/// The central differences of the configurations around `time`: root linear, root angular, first
/// joint.
fn differences(rule: Interpolation, ends: &[Waypoint; 2], time: f64) -> (DVec3, DVec3, f64) {
    let step = 1e-6;
    let [before, after] = [time - step, time + step].map(|t| rule.between(&ends[0], &ends[1], t));
    let turn = DQuat::from_array(after.root_rotation)
        * DQuat::from_array(before.root_rotation).conjugate();
    let rate = 0.5 / step;
    (
        rate * (DVec3::from(after.root_position) - DVec3::from(before.root_position)),
        rate * scaled_axis_from_rotation(turn),
        rate * (after.q[0] - before.q[0]),
    )
}

fn split(rates: &[f64; 6]) -> (DVec3, DVec3) {
    let [x, y, z, a, b, c] = *rates;
    (DVec3::new(x, y, z), DVec3::new(a, b, c))
}

#[test]
fn a_quintic_has_the_state_of_both_waypoints_at_its_ends() {
    for (seed, turn) in [(1, 0.01), (2, 0.1), (3, 0.7), (4, 1.5)] {
        let (from, to) = (waypoint(seed, 1.0, turn), waypoint(seed + 10, 1.3, turn));
        let rule = Interpolation::Quintic;
        assert!(difference(&rule.between(&from, &to, 1.0), &from) < 1e-9, "begin, turn {turn}");
        assert!(difference(&rule.between(&from, &to, 1.3), &to) < 1e-8, "end, turn {turn}");
    }
}

#[test]
fn velocities_and_accelerations_are_the_derivatives_of_the_configuration() {
    for rule in [Interpolation::Linear, Interpolation::Quintic] {
        for (seed, turn) in [(1, 0.01), (2, 0.3), (3, 1.2)] {
            let ends = [waypoint(seed, 0.0, turn), waypoint(seed + 10, 0.4, turn)];
            for tick in 1..20 {
                let time = 0.02 * f64::from(tick);
                let here = rule.between(&ends[0], &ends[1], time);
                let (linear, angular) = split(&here.root_velocity);
                let (position_rate, turn_rate, joint_rate) = differences(rule, &ends, time);
                assert!((linear - position_rate).length() < 1e-6, "{rule:?} {time}");
                assert!((angular - turn_rate).length() < 1e-6, "{rule:?} {time}: {angular}");
                assert!((here.joint_velocity[0] - joint_rate).abs() < 1e-6);
                let step = 1e-6;
                let [before, after] =
                    [time - step, time + step].map(|t| rule.between(&ends[0], &ends[1], t));
                let changes = (0..6).map(|at| {
                    let change =
                        (after.root_velocity[at] - before.root_velocity[at]) / (2.0 * step);
                    (change - here.root_acceleration[at]).abs()
                });
                assert!(changes.fold(0.0, f64::max) < 1e-4, "{rule:?} {time}");
            }
        }
    }
}

#[test]
fn samples_beyond_the_waypoints_rest_and_torques_are_linear() {
    let waypoints = [waypoint(1, 1.0, 0.1), waypoint(2, 2.0, 0.1)];
    let rule = Interpolation::Quintic;
    for (time, nearest) in [(0.5, &waypoints[0]), (2.5, &waypoints[1])] {
        let sample = rule.sample(&waypoints, time);
        assert_eq!((sample.q, sample.time), (nearest.q, nearest.time));
        assert!(sample.rates().all(|rate| rate == 0.0));
    }
    assert_eq!(rule.sample(&waypoints, 2.0), waypoints[1]);
    let quarter = rule.sample(&waypoints, 1.25);
    let torques = |w: &Waypoint| [w.torque[1], w.rest_torque[1], w.rate_change_torque[1]];
    let [from, to, between] = [&waypoints[0], &waypoints[1], &quarter].map(torques);
    for index in 0..3 {
        let expected = 0.75 * from[index] + 0.25 * to[index];
        assert!((between[index] - expected).abs() < 1e-12 && quarter.time == 1.25);
    }
}

#[test]
fn every_rule_has_its_wire_value() {
    for rule in [Interpolation::Linear, Interpolation::Quintic] {
        assert_eq!(Interpolation::from_wire(rule as u64), Some(rule));
    }
    assert_eq!(Interpolation::from_wire(2), None);
}
