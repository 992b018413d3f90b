//! The step limits: the range of distances between two soles, by direction and turn, in which a
//! primitive posture is valid on both [Grey 4.4.2].
//!
//! In each direction level soles are tried, from far to near and back. A pair counts as possible
//! where it lies between the shortest and the longest step of any of the eight samples around its
//! direction and turn, with some slack. Other postures sometimes reach farther: a pair that does
//! not count is unlikely, not impossible.

use std::f64::consts::TAU;

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use rayon::prelude::*;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{rotation_about, wrap_angle, yaw_of};

use crate::constraints::constraints::Constraints;
use crate::constraints::foothold::{Foothold, single_mode};
use crate::preparation::tuning::{
    BEARINGS, CLIMB_MAX, CLIMBS, STEP_DECREMENTS, STEP_LENGTH_SLACK, STEP_TURN_INCREMENT,
    STEP_TURN_MAX, STEP_TURNS, WALKING_WIDTH_MARGIN,
};
use crate::primitives::level_sole::side_of;
use crate::primitives::transition_configuration::has_valid_posture;
use crate::primitives::transition_pair::TransitionPair;
use crate::robot::mechanism::Mechanism;

/// Share of the spacing of the sampled turns at which a turn counts as a sampled one.
const EXACT_TURN: f64 = 0.05;
/// The farthest soles that a posture may hold on, relative to the reach of one leg and the distance
/// of the hips (planner/tests/completeness.rs).
const FARTHEST_SHARE: f64 = 1.1;
/// The shortest and the longest step where no step is possible.
const NO_STEP: [f64; 2] = [1.0, 0.0];

/// By climb and bearing: the shortest and the longest step, m. The first exceeds the second where
/// no step is possible.
type Lengths = [[[f64; 2]; BEARINGS]; CLIMBS];

/// The step limits of a robot.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct StepLimits {
    /// By stance foot and turn.
    lengths: [[Lengths; STEP_TURNS]; 2],
    /// Upper bound of the distance between soles, m: one leg's reach and the distance of the hips.
    reach: f64,
    /// The largest outward turn of the touching sole, rad.
    turn_max: f64,
}

impl StepLimits {
    /// Computes the step limits of a robot, in an empty world.
    pub fn of(constraints: &Constraints) -> Self {
        let toward = |index: usize| {
            lengths_by_direction(constraints, index / STEP_TURNS, turn_at(index % STEP_TURNS))
        };
        let found: Vec<Lengths> = (0..2 * STEP_TURNS).into_par_iter().map(toward).collect();
        let mut lengths = [[Lengths::default(); STEP_TURNS]; 2];
        lengths.as_flattened_mut().copy_from_slice(&found);
        Self { lengths, reach: reach(&constraints.robot), turn_max: turn_max(constraints) }
    }

    /// Whether the robot may stand on the first sole, of the foot `limb`, and touch with the other,
    /// in a primitive posture.
    pub fn may_touch(
        &self,
        limb: usize,
        world_from_stance: &Pose,
        world_from_other: &Pose,
    ) -> bool {
        let offset = world_from_other.translation - world_from_stance.translation;
        let heading = yaw_of(world_from_stance.rotation);
        let bearing = libm::atan2(offset.y, offset.x) - heading;
        let climb = libm::atan2(offset.z, offset.truncate().length());
        let turn = side_of(1 - limb) * wrap_angle(yaw_of(world_from_other.rotation) - heading);
        let bearings = around_index(bearing.rem_euclid(TAU) / TAU * BEARINGS as f64)
            .map(|bearing| bearing % BEARINGS);
        let climbs =
            around_index(((climb / CLIMB_MAX + 1.0) * 0.5).clamp(0.0, 1.0) * (CLIMBS - 1) as f64)
                .map(|climb| climb.min(CLIMBS - 1));
        let length = offset.length();
        let holds = |[shortest, longest]: [f64; 2]| {
            shortest <= STEP_LENGTH_SLACK * length && length <= STEP_LENGTH_SLACK * longest
        };
        let any_holds = |lengths: &Lengths| {
            climbs
                .iter()
                .any(|&climb| bearings.iter().any(|&bearing| holds(lengths[climb][bearing])))
        };
        around_turn(turn).any(|turn| any_holds(&self.lengths[limb][turn]))
    }

    /// Whether the other one of two level soles lies well within the step limits: between the
    /// shortest and the longest step of all samples around its direction and turn, without slack.
    pub fn is_inside(
        &self,
        limb: usize,
        world_from_stance: &Pose,
        world_from_other: &Pose,
    ) -> bool {
        let offset = (world_from_other.translation - world_from_stance.translation).truncate();
        let heading = yaw_of(world_from_stance.rotation);
        let bearing = libm::atan2(offset.y, offset.x) - heading;
        let turn = side_of(1 - limb) * wrap_angle(yaw_of(world_from_other.rotation) - heading);
        let bearings = around_index(bearing.rem_euclid(TAU) / TAU * BEARINGS as f64)
            .map(|bearing| bearing % BEARINGS);
        let length = offset.length();
        let holds = |turn: usize| {
            bearings.iter().all(|&bearing| {
                let [shortest, longest] = self.lengths[limb][turn][CLIMBS / 2][bearing];
                shortest <= length && length <= longest
            })
        };
        let below = (turn / STEP_TURN_MAX + 1.0) * 0.5 * (STEP_TURNS - 1) as f64;
        let nearest = libm::round(below);
        if (below - nearest).abs() < EXACT_TURN {
            return (0.0..STEP_TURNS as f64).contains(&nearest) && holds(nearest as usize);
        }
        turn.abs() < STEP_TURN_MAX && around_turn(turn).all(holds)
    }

    /// Whether the robot may stand on either sole, left or right, and touch with the other, in
    /// primitive postures.
    pub fn may_step(&self, [left, right]: [&Pose; 2]) -> bool {
        self.may_touch(0, left, right) && self.may_touch(1, right, left)
    }

    /// R_max: the longest step between level soles of any direction and turn, m.
    pub fn longest_level_step(&self) -> f64 {
        let level = self.lengths.as_flattened().iter().map(|lengths| &lengths[CLIMBS / 2]);
        let longest = |longest: f64, [shortest, length]: &[f64; 2]| {
            if shortest <= length { longest.max(*length) } else { longest }
        };
        level.flatten().fold(0.0, longest)
    }

    /// Distance between the soles in a walk straight ahead (m), beside the heading: the narrowest
    /// on both feet with some space. The narrower the stance, the less the centre of mass sways.
    pub fn walking_width(&self) -> f64 {
        let shortest = |stance: usize| {
            let toward_other = if stance == 0 { 3 * BEARINGS / 4 } else { BEARINGS / 4 };
            self.lengths[stance][STEP_TURNS / 2][CLIMBS / 2][toward_other][0]
        };
        shortest(0).max(shortest(1)) + WALKING_WIDTH_MARGIN
    }

    /// Upper bound of the distance between soles, m.
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// Distance between soles (m) beyond which no pair was sampled that a posture holds on. Uniform
    /// rounds connect footholds up to it, and beyond it the relaxed problem calls a gap too wide.
    pub fn farthest(&self) -> f64 {
        FARTHEST_SHARE * self.reach
    }

    /// The largest outward turn of the touching sole, rad.
    pub fn turn_max(&self) -> f64 {
        self.turn_max
    }

    /// Whether all values are finite and not negative.
    pub fn is_sound(&self) -> bool {
        let lengths = self.lengths.as_flattened().as_flattened().as_flattened().as_flattened();
        lengths
            .iter()
            .chain([&self.reach, &self.turn_max])
            .all(|length| length.is_finite() && *length >= 0.0)
    }
}

/// The two indices around a position.
fn around_index(position: f64) -> [usize; 2] {
    [position as usize, position as usize + 1]
}

/// The indices of the sampled turns around a turn (rad).
fn around_turn(turn: f64) -> impl Iterator<Item = usize> {
    let below = libm::floor((turn / STEP_TURN_MAX + 1.0) * 0.5 * (STEP_TURNS - 1) as f64);
    [below, below + 1.0]
        .into_iter()
        .filter(|index| (0.0..STEP_TURNS as f64).contains(index))
        .map(|index| index as usize)
}

/// The sampled outward turn at an index, rad.
fn turn_at(index: usize) -> f64 {
    STEP_TURN_MAX * (2.0 * index as f64 / (STEP_TURNS - 1) as f64 - 1.0)
}

/// The sampled unit direction at a climb and a bearing.
fn direction(climb: usize, bearing: usize) -> DVec3 {
    let (sin, cos) = libm::sincos(TAU * bearing as f64 / BEARINGS as f64);
    let (up, along) = libm::sincos(CLIMB_MAX * (2.0 * climb as f64 / (CLIMBS - 1) as f64 - 1.0));
    DVec3::new(along * cos, along * sin, up)
}

/// The shortest and the longest steps with the touching sole turned outward by `turn` (rad).
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
    let Some(coarse) = below(reach(&constraints.robot), STEP_DECREMENTS[0]) else { return NO_STEP };
    let longest = below(coarse + STEP_DECREMENTS[0], STEP_DECREMENTS[1]).unwrap_or(coarse);
    let shortest = (0..)
        .map(|count| STEP_DECREMENTS[1] * f64::from(count))
        .take_while(|length| *length < coarse)
        .find(is_step);
    [shortest.unwrap_or(coarse), longest]
}

/// Upper bound of the distance between soles, m: one leg's reach and the distance of the hips.
fn reach(robot: &Mechanism) -> f64 {
    let [left, right] = &robot.legs;
    left.reach().max(right.reach()) + left.hip().distance(right.hip())
}

/// The largest outward turn of the touching sole at any distance beside the other, rad.
fn turn_max(constraints: &Constraints) -> f64 {
    let reach = reach(&constraints.robot);
    let has_step = |turn: f64| {
        [0, 1].iter().all(|&stance| {
            let aside = side_of(1 - stance) * DVec3::Y;
            (1..(reach / STEP_DECREMENTS[1]) as usize).any(|count| {
                is_step(constraints, stance, aside * STEP_DECREMENTS[1] * count as f64, turn)
            })
        })
    };
    (1..=(STEP_TURN_MAX / STEP_TURN_INCREMENT) as usize)
        .map(|count| STEP_TURN_INCREMENT * count as f64)
        .take_while(|&turn| has_step(turn))
        .last()
        .unwrap_or(0.0)
}

/// Whether the robot, standing on one level sole, may touch with the other one at an offset (m),
/// turned outward by `turn` (rad).
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
