//! Gravity torques compared with Pinocchio and with virtual work; balanced loads.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;
#[path = "common/pinocchio.rs"]
mod pinocchio;

use common::{hubo, random_positions};
use glam::{DQuat, DVec2, DVec3};
use pinocchio::{numbers, reference};
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::geometry::convex_region::ConvexRegion;
use surefoot_planner::kinematics::Kinematics;
use surefoot_planner::robot::configuration::Configuration;
use surefoot_planner::robot::gravity_torques::{
    FootLoad, balance_loads, com_shift, effort_use, write_torques,
};
use surefoot_planner::robot::kinematic_state::KinematicState;
use surefoot_planner::robot::mass_tree::MassTree;
use surefoot_planner::robot::mechanism::{LINKS_MAX, Mechanism};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::base::spatial::rotation_from_rpy;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::model::{JointKind, RobotModel};
use surefoot_shared_types::world::world::GRAVITY;

fn poses_of(kinematics: &Kinematics, world_from_root: &Pose, q: &[f64]) -> Vec<Pose> {
    let mut poses = vec![Pose::IDENTITY; LINKS_MAX];
    kinematics.forward(world_from_root, q, &mut poses);
    poses
}

fn kinematic_state_of(model: &RobotModel, poses: &[Pose]) -> KinematicState {
    KinematicState::from_link_poses(
        &Mechanism::new(model, &PlannerConfig::default()).unwrap(),
        poses,
    )
}

fn torques_of(model: &RobotModel, poses: &[Pose], loads: &[FootLoad; 2]) -> Vec<f64> {
    let mut torques = [0.0; JOINTS_MAX];
    write_torques(
        &MassTree::new(model, 1.0),
        &kinematic_state_of(model, poses),
        loads,
        &mut torques,
    );
    torques[..model.joints.len()].to_vec()
}

#[test]
fn torques_in_single_support_agree_with_pinocchio() {
    let data = reference();
    let model = hubo();
    let kinematics = Kinematics::new(&model);
    let names: Vec<&str> =
        data["joint_names"].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
    let indices: Vec<usize> = model
        .joints
        .iter()
        .map(|joint| names.iter().position(|name| *name == joint.name).unwrap())
        .collect();
    for case in data["configurations"].as_array().unwrap() {
        let pinocchio_q = numbers(&case["q"]);
        let q: Vec<f64> = indices.iter().map(|&at| pinocchio_q[at]).collect();
        let rotation = DQuat::from_slice(&numbers(&case["root_quat_xyzw"])).normalize();
        let root = Pose::from_parts(DVec3::from_slice(&numbers(&case["root_xyz"])), rotation);
        let poses = poses_of(&kinematics, &root, &q);
        let point = kinematics.center_of_mass(&poses).truncate();
        for (limb, foot) in model.feet.iter().enumerate() {
            let share = |of: usize| if of == limb { 1.0 } else { 0.0 };
            let torques =
                torques_of(&model, &poses, &[0, 1].map(|of| FootLoad { share: share(of), point }));
            let expected = numbers(&case["standing_torques"][&foot.name]);
            for (joint, &at) in indices.iter().enumerate() {
                let (actual, expected) = (torques[joint], expected[at]);
                assert!(
                    (actual - expected).abs() < 1e-6,
                    "{} on {}: {actual}, not {expected}",
                    names[at],
                    foot.name
                );
            }
        }
    }
}

/// The potential energy (J) of the weight less the work of the vertical foot forces. Its derivative
/// by a joint position is the joint's torque.
fn potential(
    kinematics: &Kinematics,
    root: &Pose,
    q: &[f64],
    contacts: &[(usize, DVec3, f64); 2],
) -> f64 {
    let poses = poses_of(kinematics, root, q);
    let weight = kinematics.mass() * GRAVITY;
    let work = contacts
        .iter()
        .map(|(link, point, share)| share * weight * (poses[*link] * *point).z)
        .sum::<f64>();
    weight * kinematics.center_of_mass(&poses).z - work
}

fn assert_virtual_work(model: &RobotModel) {
    const STEP: f64 = 1e-5;
    let kinematics = Kinematics::new(model);
    let mut random = Random::new(1, Stream::Preparation, 0, 0);
    for _ in 0..50 {
        let q = random_positions(model, 0.0, &mut random);
        let mut angle = || random.uniform(-1.0, 1.0);
        let root = Pose::from_parts(
            DVec3::new(angle(), angle(), angle()),
            rotation_from_rpy(angle(), angle(), angle()),
        );
        let share = 0.5 + 0.5 * angle();
        let poses = poses_of(&kinematics, &root, &q);
        let contacts = [0, 1].map(|limb| {
            let point = DVec3::new(0.1 * angle(), 0.05 * angle(), -0.12);
            (model.feet[limb].link, point, [1.0 - share, share][limb])
        });
        let loads = contacts.map(|(link, point, share)| FootLoad {
            share,
            point: (poses[link] * point).truncate(),
        });
        for (joint, torque) in torques_of(model, &poses, &loads).into_iter().enumerate() {
            let at = |shift: f64| {
                let mut moved = q.clone();
                moved[joint] += shift;
                potential(&kinematics, &root, &moved, &contacts)
            };
            let slope = (at(STEP) - at(-STEP)) / (2.0 * STEP);
            assert!(
                (torque - slope).abs() < 1e-5,
                "{}: {torque}, not {slope}",
                model.joints[joint].name
            );
        }
    }
}

#[test]
fn torques_in_double_support_satisfy_virtual_work() {
    assert_virtual_work(&hubo());
}

#[test]
fn forces_of_prismatic_joints_satisfy_virtual_work() {
    let mut model = hubo();
    for joint in model
        .joints
        .iter_mut()
        .filter(|joint| joint.name.ends_with("knee") || joint.name.ends_with("elbow"))
    {
        joint.kind = JointKind::Prismatic;
    }
    assert_virtual_work(&model);
}

#[test]
fn effort_use_is_the_share_of_the_most_strained_joint() {
    let model = hubo();
    let kinematics = Kinematics::new(&model);
    let poses = poses_of(&kinematics, &Pose::IDENTITY, &model.standing_q);
    let point = kinematics.center_of_mass(&poses).truncate();
    let loads = [FootLoad { share: 0.5, point }; 2];
    let torques = torques_of(&model, &poses, &loads);
    let expected = torques
        .iter()
        .zip(&model.joints)
        .map(|(torque, joint)| torque.abs() / joint.effort)
        .fold(0.0, f64::max);
    for effort_share in [1.0, 0.5, 0.1] {
        let mass_tree = MassTree::new(&model, effort_share);
        let used = effort_use(&mass_tree, &kinematic_state_of(&model, &poses), &loads);
        assert!((used - expected / effort_share).abs() < 1e-12 && used > 0.0);
    }
}

fn foot_region(center: DVec2, yaw: f64) -> ConvexRegion {
    let rotation = DVec2::new(libm::cos(yaw), libm::sin(yaw));
    ConvexRegion::hull(
        [(-0.09, -0.07), (0.13, -0.07), (0.13, 0.07), (-0.09, 0.07)]
            .map(|corner| center + rotation.rotate(corner.into())),
    )
}

/// Two random feet with loads within their support polygons.
fn random_stance(random: &mut Random) -> ([ConvexRegion; 2], [DVec2; 2], f64) {
    let mut region = |y: f64| {
        let center = DVec2::new(random.uniform(-0.2, 0.2), y + random.uniform(-0.05, 0.05));
        foot_region(center, random.uniform(-0.5, 0.5))
    };
    let regions = [region(0.15), region(-0.15)];
    let points = [0, 1].map(|foot| {
        let vertices = regions[foot].vertices();
        let corner = vertices[random.below(vertices.len())];
        corner.lerp(regions[foot].centroid(), random.uniform(0.0, 1.0))
    });
    (regions, points, random.uniform(0.0, 1.0))
}

#[test]
fn balanced_loads_are_within_their_soles_and_carry_the_weight() {
    let mut random = Random::new(8, Stream::Preparation, 0, 0);
    let mut balanced = 0;
    const CASES: usize = 10_000;
    for _ in 0..CASES {
        let (regions, points, share) = random_stance(&mut random);
        let com = points[0] * (1.0 - share) + points[1] * share;
        let Some(loads) = balance_loads([&regions[0], &regions[1]], com, share) else { continue };
        balanced += 1;
        assert_eq!([loads[0].share, loads[1].share], [1.0 - share, share]);
        let center = loads.iter().map(|load| load.point * load.share).sum::<DVec2>();
        assert!(center.distance(com) < 1e-6);
        for (load, region) in loads.iter().zip(&regions) {
            assert!(region.margin(load.point) > -1e-9, "{load:?} outside {region:?}");
        }
    }
    assert!(
        balanced as f64 > 0.98 * CASES as f64,
        "{balanced} of {CASES} feasible stances balanced"
    );
}

#[test]
fn infeasible_loads_are_not_balanced() {
    let feet = [foot_region(DVec2::new(0.0, 0.15), 0.0), foot_region(DVec2::new(0.0, -0.15), 0.0)];
    let regions = [&feet[0], &feet[1]];
    for share in [0.0, 0.1, 0.5, 0.9, 1.0] {
        assert_eq!(balance_loads(regions, DVec2::new(0.2, 0.0), share), None, "ahead of both feet");
        assert_eq!(balance_loads(regions, DVec2::new(0.0, 0.3), share), None, "beside both feet");
    }
    assert_eq!(
        balance_loads(regions, DVec2::new(0.0, 0.15), 0.9),
        None,
        "over the left foot with the weight on the right"
    );
    assert!(balance_loads(regions, DVec2::new(0.0, 0.15), 0.0).is_some());
}

#[test]
fn com_shift_is_the_derivative_of_the_centre_of_mass() {
    let robot = Mechanism::new(&hubo(), &PlannerConfig::default()).unwrap();
    let mut random = Random::new(3, Stream::Preparation, 0, 0);
    let rotation = rotation_from_rpy(0.3, -0.2, 0.7);
    let mut at = Configuration {
        world_from_root: Pose::from_parts(DVec3::new(1.0, 2.0, 3.0), rotation),
        q: robot.standing_q,
    };
    for joint in &robot.free_joints {
        at.q[joint.index] =
            (at.q[joint.index] + random.uniform(-0.5, 0.5)).clamp(joint.lower, joint.upper);
    }
    let kinematic_state = KinematicState::new(&robot, &at);
    assert!(!robot.trunk_joints.is_empty());
    for joint in &robot.free_joints {
        let step = 1e-6;
        let moved = |by: f64| {
            let mut moved = at;
            moved.q[joint.index] += by;
            KinematicState::new(&robot, &moved).com
        };
        let measured = (moved(step) - moved(-step)) / (2.0 * step);
        let shift = com_shift(&robot.mass_tree, &kinematic_state, joint.index);
        assert!(measured.distance(shift) < 1e-7, "joint {}: {measured} {shift}", joint.index);
    }
}
