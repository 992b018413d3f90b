//! Kinematics, centre of mass and torques of the hubo robot against Pinocchio's numbers
//! (`tests/data/pinocchio_hubo.json`).

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};
use serde_json::Value;
use surefoot_controller_sim::kinematics::forward::{Configuration, Posture};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::rotation_distance;
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::robot::model::RobotModel;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

fn vector(value: &Value) -> DVec3 {
    DVec3::from_slice(&numbers(value))
}

fn rotation(value: &Value) -> DQuat {
    DQuat::from_slice(&numbers(value)).normalize()
}

fn names(value: &Value) -> Vec<String> {
    value.as_array().unwrap().iter().map(|name| name.as_str().unwrap().to_owned()).collect()
}

/// For each of the model's joints, its place in the file.
fn joint_places(model: &RobotModel, file: &[String]) -> Vec<usize> {
    model
        .joints
        .iter()
        .map(|joint| file.iter().position(|name| *name == joint.name).unwrap())
        .collect()
}

fn assert_near(ours: &[f64], theirs: &[f64], places: &[usize], what: &str) {
    for (joint, &place) in places.iter().enumerate() {
        assert!(
            (ours[joint] - theirs[place]).abs() < 1e-6,
            "{what}, joint {joint}: {} {}",
            ours[joint],
            theirs[place]
        );
    }
}

#[test]
fn hubo_kinematics_and_statics_agree_with_pinocchio() {
    let data: Value = serde_json::from_str(
        &std::fs::read_to_string(root().join("tests/data/pinocchio_hubo.json")).unwrap(),
    )
    .unwrap();
    let model = load_robot(&root().join(data["robot"].as_str().unwrap())).unwrap();
    assert!((model.mass() - data["mass"].as_f64().unwrap()).abs() < 1e-9);
    let (places, link_names) =
        (joint_places(&model, &names(&data["joint_names"])), names(&data["link_names"]));
    let configurations = data["configurations"].as_array().unwrap();
    assert!(configurations.len() >= 20);
    for case in configurations {
        let q = numbers(&case["q"]);
        let world_from_root =
            Pose::from_parts(vector(&case["root_xyz"]), rotation(&case["root_quat_xyzw"]));
        let configuration =
            Configuration { world_from_root, q: places.iter().map(|&place| q[place]).collect() };
        let posture = Posture::new(&model, &configuration);
        for (index, name) in link_names.iter().enumerate() {
            let pose = &posture.world_from_link
                [model.links.iter().position(|link| link.name == *name).unwrap()];
            assert!(
                (pose.translation - vector(&case["links_xyz"][index])).length() < 1e-9,
                "{name}"
            );
            assert!(
                rotation_distance(pose.rotation, rotation(&case["links_quat_xyzw"][index])) < 1e-9,
                "{name}"
            );
        }
        assert!((posture.centre_of_mass(&model) - vector(&case["com"])).length() < 1e-9);
        assert_near(
            &posture.gravity_torques(&model),
            &numbers(&case["gravity_torques"]),
            &places,
            "gravity",
        );
        for (limb, foot) in model.feet.iter().enumerate() {
            let theirs = numbers(&case["standing_torques"][&foot.name]);
            assert_near(&posture.standing_torques(&model, limb), &theirs, &places, &foot.name);
        }
    }
}
