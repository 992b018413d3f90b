//! The step limits: how far from one sole the other may be, by direction and turn, for a
//! primitive posture to hold on both [Grey 4.4.2].
//!
//! In each direction level soles are tried, from far to near and back. A pair counts as possible
//! where it lies between the shortest and the longest step of any of the eight that were tried
//! about its own direction and turn, and a little beyond. Other postures reach farther, now and
//! then: what is not counted is unlikely, not impossible.

use std::f64::consts::{PI, TAU};

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use rayon::prelude::*;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{rotation_about, wrap_angle, yaw_of};

use crate::constraints::constraints::Constraints;
use crate::constraints::foothold::{Foothold, single_mode};
use crate::primitives::level_sole::side_of;
use crate::primitives::transition_configuration::{TransitionPair, has_valid_posture};
use crate::robot::mechanism::Mechanism;

/// Directions around the stance that are tried.
const BEARINGS: usize = 16;
/// Directions down and up that are tried.
const CLIMBS: usize = 7;
/// The steepest of them, rad.
const CLIMB_MAX: f64 = PI / 3.0;
/// Turns of the touching sole outward that are tried: as many, and the steepest of them, rad.
const TURNS: usize = 7;
/// By how much larger turns are tried where the feet are side by side, rad.
const TURN_STEP: f64 = 0.05;
/// The largest turn, rad.
const TURN_MAX: f64 = 1.2;
/// By how much shorter steps are tried, m: first coarsely, then between the last two.
const STEPS: [f64; 2] = [0.08, 0.02];
/// How much longer than those that were tried steps may be, on inclined soles and in other
/// postures.
const SLACK: f64 = 1.15;
/// The shortest and the longest step where there is none.
const NO_STEP: [f64; 2] = [1.0, 0.0];

/// By climb and bearing: how near and how far the other sole may be, m. The first is above the
/// second where no step is possible.
type Lengths = [[[f64; 2]; BEARINGS]; CLIMBS];

/// The step limits of a robot.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct StepLimits {
    /// By stance foot and turn.
    lengths: [[Lengths; TURNS]; 2],
    /// How far apart soles may be at all, m: one leg's reach, and the hips apart.
    reach: f64,
    /// How far the touching sole may be turned outward, rad.
    turn_max: f64,
}

impl StepLimits {
    /// Works them out for a robot.
    pub fn of(constraints: &Constraints) -> Self {
        let toward =
            |index: usize| lengths_by_direction(constraints, index / TURNS, turn_at(index % TURNS));
        let found: Vec<Lengths> = (0..2 * TURNS).into_par_iter().map(toward).collect();
        let mut lengths = [[Lengths::default(); TURNS]; 2];
        lengths.as_flattened_mut().copy_from_slice(&found);
        Self { lengths, reach: reach(&constraints.robot), turn_max: turn_max(constraints) }
    }

    /// Whether a primitive posture may stand on the first sole and touch with the other, `limb`
    /// being the first one's foot.
    pub fn may_touch(
        &self,
        limb: usize,
        world_from_stance: &Pose,
        world_from_other: &Pose,
    ) -> bool {
        let offset = world_from_other.translation - world_from_stance.translation;
        let heading = yaw_of(world_from_stance.rotation);
        let around = libm::atan2(offset.y, offset.x) - heading;
        let climb = libm::atan2(offset.z, offset.truncate().length());
        let turn = side_of(1 - limb) * wrap_angle(yaw_of(world_from_other.rotation) - heading);
        let bearings =
            about(around.rem_euclid(TAU) / TAU * BEARINGS as f64).map(|bearing| bearing % BEARINGS);
        let climbs = about(((climb / CLIMB_MAX + 1.0) * 0.5).clamp(0.0, 1.0) * (CLIMBS - 1) as f64)
            .map(|climb| climb.min(CLIMBS - 1));
        let length = offset.length();
        let holds =
            |[shortest, longest]: [f64; 2]| shortest <= SLACK * length && length <= SLACK * longest;
        let any_holds = |lengths: &Lengths| {
            climbs
                .iter()
                .any(|&climb| bearings.iter().any(|&bearing| holds(lengths[climb][bearing])))
        };
        about_turn(turn).any(|turn| any_holds(&self.lengths[limb][turn]))
    }

    /// Whether primitive postures may stand on either sole, left or right, and touch with the
    /// other.
    pub fn may_step(&self, [left, right]: [&Pose; 2]) -> bool {
        self.may_touch(0, left, right) && self.may_touch(1, right, left)
    }

    /// How far apart soles may be at all, m.
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// How far the touching sole may be turned outward, rad.
    pub fn turn_max(&self) -> f64 {
        self.turn_max
    }

    /// Whether all of them are lengths.
    pub fn is_sound(&self) -> bool {
        let lengths = self.lengths.as_flattened().as_flattened().as_flattened().as_flattened();
        lengths
            .iter()
            .chain([&self.reach, &self.turn_max])
            .all(|length| length.is_finite() && *length >= 0.0)
    }
}

/// The whole numbers on either side.
fn about(place: f64) -> [usize; 2] {
    [place as usize, place as usize + 1]
}

/// The turns that were tried on either side of one, of those that there are.
fn about_turn(turn: f64) -> impl Iterator<Item = usize> {
    let below = libm::floor((turn / TURN_MAX + 1.0) * 0.5 * (TURNS - 1) as f64);
    [below, below + 1.0]
        .into_iter()
        .filter(|place| (0.0..TURNS as f64).contains(place))
        .map(|place| place as usize)
}

/// A turn outward that is tried, rad.
fn turn_at(index: usize) -> f64 {
    TURN_MAX * (2.0 * index as f64 / (TURNS - 1) as f64 - 1.0)
}

/// A direction that is tried.
fn direction(climb: usize, bearing: usize) -> DVec3 {
    let (sin, cos) = libm::sincos(TAU * bearing as f64 / BEARINGS as f64);
    let (up, along) = libm::sincos(CLIMB_MAX * (2.0 * climb as f64 / (CLIMBS - 1) as f64 - 1.0));
    DVec3::new(along * cos, along * sin, up)
}

/// The shortest and the longest steps with the touching sole turned outward by as much (rad).
fn lengths_by_direction(constraints: &Constraints, stance: usize, turn: f64) -> Lengths {
    std::array::from_fn(|climb| {
        std::array::from_fn(|bearing| {
            lengths_toward(constraints, stance, direction(climb, bearing), turn)
        })
    })
}

/// The shortest and the longest step in a direction, m.
fn lengths_toward(
    constraints: &Constraints,
    stance: usize,
    direction: DVec3,
    turn: f64,
) -> [f64; 2] {
    let is_step = |length: &f64| is_step(constraints, stance, direction * *length, turn);
    let below = |top: f64, step: f64| {
        (0..(top / step) as usize).map(move |count| top - step * count as f64).find(is_step)
    };
    let Some(coarse) = below(reach(&constraints.robot), STEPS[0]) else { return NO_STEP };
    let longest = below(coarse + STEPS[0], STEPS[1]).unwrap_or(coarse);
    let shortest = (0..)
        .map(|count| STEPS[1] * f64::from(count))
        .take_while(|length| *length < coarse)
        .find(is_step);
    [shortest.unwrap_or(coarse), longest]
}

/// How far apart soles may be at all, m: one leg's reach, and the hips apart.
fn reach(robot: &Mechanism) -> f64 {
    let [left, right] = &robot.legs;
    left.reach().max(right.reach()) + left.hip().distance(right.hip())
}

/// How far the touching sole may be turned outward somewhere beside the other, rad.
fn turn_max(constraints: &Constraints) -> f64 {
    let reach = reach(&constraints.robot);
    let has_step = |turn: f64| {
        [0, 1].iter().all(|&stance| {
            let aside = side_of(1 - stance) * DVec3::Y;
            (1..(reach / STEPS[1]) as usize)
                .any(|count| is_step(constraints, stance, aside * STEPS[1] * count as f64, turn))
        })
    };
    (1..=(TURN_MAX / TURN_STEP) as usize)
        .map(|count| TURN_STEP * count as f64)
        .take_while(|&turn| has_step(turn))
        .last()
        .unwrap_or(0.0)
}

/// Whether the robot, standing on one level sole, touches with the other one at an offset, turned.
fn is_step(constraints: &Constraints, stance: usize, offset: DVec3, turn: f64) -> bool {
    let rotation = rotation_about(DVec3::Z, side_of(1 - stance) * turn);
    let other = Foothold::whole(&constraints.robot, 1 - stance, Pose::from_parts(offset, rotation));
    let stance = Foothold::whole(&constraints.robot, stance, Pose::IDENTITY);
    has_valid_posture(
        constraints,
        &single_mode(&stance),
        TransitionPair { stance: &stance, other: &other },
    )
}
