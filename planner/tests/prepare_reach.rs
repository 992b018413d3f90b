//! The reachable space R: every reachable position is in it, and a damaged file is rejected
//! [Grey 4.2.1].

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use common::{hubo, preparation_of, random_positions};
use glam::DVec3;
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::kinematics::Leg;
use surefoot_planner::preparation::{Preparation, PreparationError, build, key};
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::robot::model::RobotModel;

/// Tests the soles at random joint positions, within the limits and often at them.
fn every_reachable_sole_is_in_r(model: &RobotModel, samples: u64) {
    let words = preparation_of(model);
    let made_from = key(model, &PlannerConfig::default());
    let preparation = Preparation::from_bytes(bytemuck::cast_slice(&words), &made_from).unwrap();
    for limb in 0..2 {
        let leg = Leg::new(model, limb, 0.0).unwrap();
        for sample in 0..samples {
            let mut random = Random::new(11, Stream::Preparation, limb as u64, sample);
            let mut q = random_positions(model, 0.0, &mut random);
            for (position, joint) in q.iter_mut().zip(&model.joints) {
                match random.below(6) {
                    0 => *position = joint.lower,
                    1 => *position = joint.upper,
                    _ => {}
                }
            }
            let sole = leg.root_from_sole(&q).translation;
            assert!(
                preparation.may_reach(limb, sole),
                "limb {limb}, sample {sample}: {sole} from {q:?}"
            );
        }
    }
}

#[test]
fn every_sole_of_hubo_is_in_r() {
    every_reachable_sole_is_in_r(&hubo(), 200_000);
}

/// Ten million soles for each leg:
/// `cargo test --release -p surefoot-planner --test prepare_reach -- --ignored`. Names of
/// `robot.toml` files in SUREFOOT_ROBOTS, separated by colons, are tested too.
#[test]
#[ignore = "takes a minute"]
fn every_sole_of_millions_is_in_r() {
    every_reachable_sole_is_in_r(&hubo(), 10_000_000);
    let others = std::env::var("SUREFOOT_ROBOTS").unwrap_or_default();
    for path in others.split(':').filter(|path| !path.is_empty()) {
        every_reachable_sole_is_in_r(&load_robot(path.as_ref()).unwrap(), 10_000_000);
    }
}

#[test]
fn the_bound_is_tight() {
    let model = hubo();
    let words = preparation_of(&model);
    let preparation = Preparation::from_bytes(
        bytemuck::cast_slice(&words),
        &key(&model, &PlannerConfig::default()),
    )
    .unwrap();
    let leg = Leg::new(&model, 0, 0.0).unwrap();
    let straight = leg.root_from_sole(&vec![0.0; model.joints.len()]).translation;
    assert!(preparation.may_reach(0, straight));
    let beyond = straight + (straight - leg.hip()).normalize() * 0.08;
    assert!(!preparation.may_reach(0, beyond) && !preparation.may_reach(0, 0.9 * DVec3::Z));
    assert!(
        !preparation.may_reach(0, DVec3::splat(1e300)) && !preparation.may_reach(0, DVec3::NAN)
    );
    let blocks = preparation.reach(0).blocks();
    let nearest = blocks[0];
    let inside = (DVec3::from(nearest.center) - straight)
        .abs()
        .cmple(DVec3::from(nearest.half_extents) + DVec3::splat(0.2));
    assert!(inside.all(), "{nearest:?}");
}

#[test]
fn the_same_robot_gives_the_same_bytes() {
    let model = hubo();
    let again = build(&model, &PlannerConfig::default(), &|_| ()).unwrap();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let alone = pool.install(|| build(&model, &PlannerConfig::default(), &|_| ()).unwrap());
    assert!(again == *preparation_of(&model) && again == alone);
}

#[test]
fn a_damaged_file_is_rejected() {
    let model = hubo();
    let made_from = key(&model, &PlannerConfig::default());
    let words = preparation_of(&model);
    let sound: &[u8] = bytemuck::cast_slice(&words);
    let error_of = |change: &dyn Fn(&mut Vec<u64>)| {
        let mut changed = words.to_vec();
        change(&mut changed);
        Preparation::from_bytes(bytemuck::cast_slice(&changed), &made_from).map(drop).unwrap_err()
    };
    assert!(Preparation::from_bytes(sound, &made_from).is_ok());
    assert_eq!(error_of(&|words| words.truncate(words.len() / 2)), PreparationError::Damaged);
    assert_eq!(error_of(&|words| words.clear()), PreparationError::Damaged);
    assert_eq!(error_of(&|words| words.push(0)), PreparationError::Damaged);
    assert_eq!(error_of(&|words| words[0] ^= 1), PreparationError::Foreign);
    let mut random = Random::new(5, Stream::Preparation, 0, 0);
    for _ in 0..50 {
        let (at, bit) = (random.below(words.len()), random.below(64));
        error_of(&|words| words[at] ^= 1 << bit);
    }
    let other = PlannerConfig { clearance: 0.01, ..PlannerConfig::default() };
    assert_eq!(
        Preparation::from_bytes(sound, &key(&model, &other)).map(drop).unwrap_err(),
        PreparationError::OtherRobot
    );
    let shifted = [&[0], sound].concat();
    assert!(Preparation::from_bytes(&shifted[1..], &made_from).is_ok(), "any address will do");
    assert_eq!(
        Preparation::from_bytes(&shifted, &made_from).map(drop),
        Err(PreparationError::Damaged)
    );
}
