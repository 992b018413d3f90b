//! The longest steps: how far from one sole the other may be, by direction, for a primitive posture to reach both [Grey 4.4.2].
//!
//! In each direction level soles are tried, from far to near. A pair counts as near enough up to a little beyond the longest step in
//! any of the four directions about its own. Other postures reach farther, now and then: what is not near enough is unlikely, not
//! impossible.

use std::f64::consts::{PI, TAU};

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use rayon::prelude::*;
use surefoot_shared_types::Pose;
use surefoot_shared_types::spatial::{rotation_about, yaw_of};

use crate::body::Body;
use crate::constraint::Constraints;
use crate::motion::foothold::Foothold;
use crate::motion::transition::reaches;

/// Directions around the stance that are tried.
const BEARINGS: usize = 16;
/// Directions down and up that are tried.
const CLIMBS: usize = 7;
/// The steepest of them, rad.
const CLIMB_MAX: f64 = PI / 3.0;
/// Turns of the touching sole that are tried, rad.
const TURNS: [f64; 3] = [0.0, 0.4, -0.4];
/// By how much shorter steps are tried, m: first coarsely, then between the last two.
const STEPS: [f64; 2] = [0.08, 0.02];
/// How much longer than those that were tried steps may be, on inclined soles and in other postures.
const SLACK: f64 = 1.1;

/// The longest steps of a robot.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct LongestSteps {
    /// By stance foot, climb and bearing: how far the other sole may be, m.
    longest: [[[f64; BEARINGS]; CLIMBS]; 2],
    /// How far apart soles may be at all, m: one leg's reach, and the hips apart.
    reach: f64,
}

impl LongestSteps {
    /// Works them out for a robot.
    pub fn of(constraints: &Constraints) -> Self {
        let toward = |index: usize| {
            let (stance, climb, bearing) = (index / (CLIMBS * BEARINGS), index / BEARINGS % CLIMBS, index % BEARINGS);
            longest_toward(constraints, stance, direction(climb, bearing))
        };
        let lengths: Vec<f64> = (0..2 * CLIMBS * BEARINGS).into_par_iter().map(toward).collect();
        let mut longest = [[[0.0; BEARINGS]; CLIMBS]; 2];
        longest.as_flattened_mut().as_flattened_mut().copy_from_slice(&lengths);
        Self { longest, reach: reach(&constraints.body) }
    }

    /// Whether a primitive posture may stand on the first sole and touch with the other, `limb` being the first one's foot.
    pub fn may_touch(&self, limb: usize, world_from_stance: &Pose, world_from_other: &Pose) -> bool {
        let offset = world_from_other.translation - world_from_stance.translation;
        let around = libm::atan2(offset.y, offset.x) - yaw_of(world_from_stance.rotation);
        let climb = libm::atan2(offset.z, offset.truncate().length());
        let bearings = about(around.rem_euclid(TAU) / TAU * BEARINGS as f64).map(|bearing| bearing % BEARINGS);
        let climbs = about(((climb / CLIMB_MAX + 1.0) * 0.5).clamp(0.0, 1.0) * (CLIMBS - 1) as f64).map(|climb| climb.min(CLIMBS - 1));
        let longest = |climb: usize| bearings.map(|bearing| self.longest[limb][climb][bearing]);
        let longest = climbs.map(longest).as_flattened().iter().copied().fold(0.0, f64::max);
        offset.length() <= SLACK * longest
    }

    /// Whether primitive postures may stand on either sole, left or right, and touch with the other.
    pub fn may_step(&self, [left, right]: [&Pose; 2]) -> bool {
        self.may_touch(0, left, right) && self.may_touch(1, right, left)
    }

    /// How far apart soles may be at all, m.
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// Whether all of them are lengths.
    pub fn is_sound(&self) -> bool {
        let mut lengths = self.longest.as_flattened().as_flattened().iter().chain([&self.reach]);
        lengths.all(|length| length.is_finite() && *length >= 0.0)
    }
}

/// The whole numbers on either side.
fn about(place: f64) -> [usize; 2] {
    [place as usize, place as usize + 1]
}

/// A direction that is tried.
fn direction(climb: usize, bearing: usize) -> DVec3 {
    let (sin, cos) = libm::sincos(TAU * bearing as f64 / BEARINGS as f64);
    let (up, along) = libm::sincos(CLIMB_MAX * (2.0 * climb as f64 / (CLIMBS - 1) as f64 - 1.0));
    DVec3::new(along * cos, along * sin, up)
}

/// The longest step in a direction, m.
fn longest_toward(constraints: &Constraints, stance: usize, direction: DVec3) -> f64 {
    let is_step = |length: f64| TURNS.iter().any(|&turn| is_step(constraints, stance, direction * length, turn));
    let from_top = |top: f64, step: f64| {
        let mut lengths = (0..(top / step) as usize).map(|count| top - step * count as f64);
        lengths.find(|&length| is_step(length)).unwrap_or(0.0)
    };
    let coarse = from_top(reach(&constraints.body), STEPS[0]);
    from_top(coarse + STEPS[0], STEPS[1])
}

/// How far apart soles may be at all, m: one leg's reach, and the hips apart.
fn reach(body: &Body) -> f64 {
    let [left, right] = &body.legs;
    left.reach().max(right.reach()) + left.hip().distance(right.hip())
}

/// Whether the robot, standing on one level sole, touches with the other one at an offset, turned.
fn is_step(constraints: &Constraints, stance: usize, offset: DVec3, turn: f64) -> bool {
    let other = Foothold::whole(&constraints.body, 1 - stance, Pose::from_parts(offset, rotation_about(DVec3::Z, turn)));
    reaches(constraints, &Foothold::whole(&constraints.body, stance, Pose::IDENTITY), &other)
}
