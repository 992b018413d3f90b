//! The step limits: nearly all pairs of soles on which the robot can stand on one and touch the
//! other are within them.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use std::f64::consts::PI;

use common::{hubo, preparation_for};
use glam::{DQuat, DVec3};
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::collision::model::CollisionModel;
use surefoot_planner::constraints::constraints::Constraints;
use surefoot_planner::constraints::foothold::{Foothold, single_mode};
use surefoot_planner::primitives::transition_configuration::sample;
use surefoot_planner::primitives::transition_pair::TransitionPair;
use surefoot_planner::robot::mechanism::Mechanism;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::rotation_about;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::World;

/// Attempts at each pair: primitive postures, their neighbourhood, then uniform samples.
const ATTEMPTS: u64 = 60;

/// Distances (m) between which a walk's soles lie: beyond the collision of the shanks, and nearer
/// than in the standing posture.
const WALKING_WIDTHS: [f64; 2] = [0.12, 0.19];

/// A level sole's heading, or that of one inclined by up to 0.2 rad.
fn rotation(random: &mut Random, turn: f64) -> DQuat {
    let axis = DVec3::new(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), 0.0).normalize();
    let heading = rotation_about(DVec3::Z, turn);
    if random.below(2) == 0 {
        heading
    } else {
        rotation_about(axis, random.uniform(0.0, 0.2)) * heading
    }
}

/// The number of pairs on which sampling finds a configuration, and the number of those outside the
/// step limits.
fn left_out(model: &RobotModel, pairs: u64) -> (u64, u64) {
    let config = PlannerConfig::default();
    let preparation = preparation_for(model, &config);
    let steps = preparation.step_limits();
    let world = World { mu: 0.6, shapes: vec![], digest: Default::default() };
    let robot = Mechanism::new(model, &config).unwrap();
    let collision = CollisionModel::new(model, &world, config.clearance).unwrap();
    let constraints = Constraints::new(robot, collision, config);
    let (mut found, mut left_out) = (0, 0);
    for index in 0..pairs {
        let mut random = Random::new(5, Stream::Preparation, 7, index);
        let limb = random.below(2);
        let foothold = |limb: usize, pose: Pose| Foothold::whole(&constraints.robot, limb, pose);
        let offset = DVec3::from_array([0.8, 0.8, 0.5].map(|side| random.uniform(-side, side)));
        let stance = foothold(limb, Pose::from_parts(DVec3::ZERO, rotation(&mut random, 0.0)));
        let turn = random.uniform(-0.8, 0.8);
        let other = foothold(1 - limb, Pose::from_parts(offset, rotation(&mut random, turn)));
        let pair = TransitionPair { stance: &stance, other: &other };
        let mode = single_mode(&stance);
        if (0..ATTEMPTS)
            .any(|attempt| sample(&constraints, &mode, pair, (1, index), attempt).is_ok())
        {
            found += 1;
            left_out +=
                u64::from(!steps.may_touch(limb, &stance.world_from_sole, &other.world_from_sole));
        }
    }
    (found, left_out)
}

#[test]
fn few_sampled_steps_exceed_the_step_limits() {
    let (found, left_out) = left_out(&hubo(), 4_000);
    assert!(found > 300 && left_out * 100 <= found, "{left_out} of {found}");
}

#[test]
fn soles_without_a_valid_posture_exceed_the_step_limits() {
    let model = hubo();
    let preparation = preparation_for(&model, &PlannerConfig::default());
    let steps = preparation.step_limits();
    let at = |x: f64, y: f64, z: f64| Pose::from_translation(DVec3::new(x, y, z));
    assert!(
        steps.may_touch(0, &Pose::IDENTITY, &at(0.2, -0.2, 0.0))
            && steps.may_touch(1, &Pose::IDENTITY, &at(0.0, 0.2, 0.15))
    );
    for far in [
        at(steps.reach(), 0.0, 0.0),
        at(-0.9, -0.2, 0.0),
        at(0.0, 0.6, 0.0),
        at(0.2, 0.0, -0.8),
        at(f64::NAN, 0.0, 0.0),
    ] {
        assert!(!steps.may_touch(0, &Pose::IDENTITY, &far), "{far:?}");
    }
    let turned = |pose: &Pose, turn: f64| {
        Pose::from_parts(pose.translation, pose.rotation * rotation_about(DVec3::Z, turn))
    };
    let beside = at(0.0, -0.25, 0.0);
    assert!(!steps.may_touch(0, &Pose::IDENTITY, &at(0.0, -0.06, 0.0)), "the legs collide");
    assert!(
        !steps.may_touch(0, &Pose::IDENTITY, &turned(&beside, 2.0)),
        "the leg does not turn that far"
    );
    let about = turned(&Pose::IDENTITY, PI);
    assert!(
        steps.may_touch(0, &about, &(about * beside))
            && !steps.may_touch(0, &about, &turned(&beside, PI)),
        "it turns with the stance"
    );
}

#[test]
fn a_walk_is_narrow_and_the_feet_touch_at_its_width_on_both_sides() {
    let preparation = preparation_for(&hubo(), &PlannerConfig::default());
    let steps = preparation.step_limits();
    let width = steps.walking_width();
    assert!((WALKING_WIDTHS[0]..WALKING_WIDTHS[1]).contains(&width), "{width} m");
    let [left, right] =
        [0.5, -0.5].map(|side| Pose::from_translation(DVec3::new(0.0, side * width, 0.0)));
    assert!(steps.is_inside(0, &left, &right) && steps.is_inside(1, &right, &left));
}
