//! Constrained projection onto two soles: its results satisfy the target, and it solves cases in
//! which sampling the root pose fails.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use common::{hubo, with_split_hip};
use glam::{DQuat, DVec2, DVec3};
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::geometry::convex_region::ConvexRegion;
use surefoot_planner::robot::configuration::Configuration;
use surefoot_planner::robot::constrained_projection::{ProjectionTarget, project};
use surefoot_planner::robot::kinematic_state::KinematicState;
use surefoot_planner::robot::mechanism::Mechanism;
use surefoot_planner::robot::posture_ik::{Posture, initial_guess, solve_posture};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{rotation_about, rotation_distance, rotation_from_rpy};
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::model::RobotModel;

const COM_MARGIN: f64 = 0.01;

/// A robot without closed-form legs whose ankles roll little, as many humanoids.
fn stiff_ankled() -> RobotModel {
    let mut model = with_split_hip(&hubo());
    for joint in model.joints.iter_mut().filter(|joint| joint.name.ends_with("ankle_roll")) {
        (joint.lower, joint.upper) = (-0.2, 0.2);
    }
    model
}

fn robot(model: &RobotModel) -> Mechanism {
    Mechanism::new(model, &PlannerConfig::default()).unwrap()
}

fn sole_region(robot: &Mechanism, world_from_sole: &Pose) -> ConvexRegion {
    ConvexRegion::seen_from_above(world_from_sole, &robot.soles[0].polygon)
}

/// The standing posture with the centre of mass over the centre of the left sole.
fn upright(region: &ConvexRegion, robot: &Mechanism) -> Posture {
    Posture {
        world_from_root: DQuat::IDENTITY,
        leg_extension: robot.standing_leg_extension,
        com: region.centroid(),
    }
}

fn assert_stands(robot: &Mechanism, target: &ProjectionTarget<'_>, found: &Configuration) {
    let kinematic_state = KinematicState::new(robot, found);
    for (limb, sole) in target.world_from_soles.iter().enumerate() {
        let reached = kinematic_state.world_from_sole(robot, limb);
        assert!(reached.translation.distance(sole.translation) < 1e-8, "{reached:?} {sole:?}");
        assert!(rotation_distance(reached.rotation, sole.rotation) < 1e-7, "{reached:?} {sole:?}");
        assert!(
            robot.legs[limb]
                .joints()
                .iter()
                .all(|joint| joint.is_within_limits(found.q[joint.index])),
            "{:?}",
            found.q
        );
    }
    assert!(
        target.region.contains(kinematic_state.com.truncate(), target.com_margin),
        "{}",
        kinematic_state.com
    );
}

#[test]
fn most_reachable_pairs_of_soles_are_solved() {
    let robot = robot(&stiff_ankled());
    let mut random = Random::new(5, Stream::Preparation, 0, 0);
    let (mut found, mut solved_upright, mut tried) = (0, 0, 0);
    while tried < 400 {
        let mut sampled = Configuration {
            world_from_root: Pose::from_translation(DVec3::Z),
            q: robot.standing_q,
        };
        let angles = [0.3, 0.3, 0.5].map(|half| random.uniform(-half, half));
        sampled.world_from_root.rotation = rotation_from_rpy(angles[0], angles[1], angles[2]);
        for joint in robot.legs.iter().flat_map(|leg| leg.joints()) {
            let deviation = random.uniform(-0.5, 0.5);
            sampled.q[joint.index] =
                (sampled.q[joint.index] + deviation).clamp(joint.lower, joint.upper);
        }
        let kinematic_state = KinematicState::new(&robot, &sampled);
        let soles = [0, 1].map(|limb| kinematic_state.world_from_sole(&robot, limb));
        let region = sole_region(&robot, &soles[0]);
        if !region.contains(kinematic_state.com.truncate(), COM_MARGIN) {
            continue;
        }
        tried += 1;
        solved_upright += usize::from(
            solve_posture(&robot, &soles, &upright(&region, &robot), robot.standing_q).is_ok(),
        );
        let target =
            ProjectionTarget { world_from_soles: &soles, region: &region, com_margin: COM_MARGIN };
        let start = initial_guess(&robot, &soles, &upright(&region, &robot), robot.standing_q);
        if let Some(configuration) =
            project(&robot, &target, &start, &mut KinematicState::default())
        {
            found += 1;
            assert_stands(&robot, &target, &configuration);
        }
    }
    assert!(
        found > tried / 2 && found > 3 * solved_upright,
        "{found} of {tried} solved, {solved_upright} with an upright root"
    );
}

#[test]
fn a_sole_tilted_beyond_the_reach_of_an_upright_root_is_solved() {
    let robot = robot(&stiff_ankled());
    let soles = [(0.12, 0.0), (-0.12, -0.44)]
        .map(|(y, roll)| Pose::from_parts(DVec3::Y * y, rotation_about(DVec3::X, roll)));
    let region = sole_region(&robot, &soles[0]);
    let target =
        ProjectionTarget { world_from_soles: &soles, region: &region, com_margin: COM_MARGIN };
    assert!(
        solve_posture(&robot, &soles, &upright(&region, &robot), robot.standing_q).is_err(),
        "the root must lean"
    );
    let start = initial_guess(&robot, &soles, &upright(&region, &robot), robot.standing_q);
    let found = project(&robot, &target, &start, &mut KinematicState::default()).unwrap();
    assert_stands(&robot, &target, &found);
}

#[test]
fn soles_out_of_reach_are_not_solved() {
    let robot = robot(&stiff_ankled());
    let soles = [1.2, -1.2].map(|y| Pose::from_translation(DVec3::Y * y));
    let region =
        ConvexRegion::hull([(-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1)].map(DVec2::from));
    let target = ProjectionTarget { world_from_soles: &soles, region: &region, com_margin: 0.0 };
    let start = initial_guess(&robot, &soles, &upright(&region, &robot), robot.standing_q);
    assert_eq!(project(&robot, &target, &start, &mut KinematicState::default()), None);
}
