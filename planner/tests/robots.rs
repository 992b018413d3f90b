//! Variants of the shipped robot: weak ankles, weak hips, a waist between the root and the legs,
//! fingers, narrow joint limits.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use common::{Case, hubo, run};
use glam::{DVec2, DVec3};
use surefoot_planner::Outcome;
use surefoot_planner::robot::configuration::Configuration;
use surefoot_planner::robot::gravity_torques::{FootLoad, effort_use};
use surefoot_planner::robot::kinematic_state::KinematicState;
use surefoot_planner::robot::mechanism::Mechanism;
use surefoot_planner::robot::single_support::SingleSupportPosture;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::model::{Attachment, Joint, Link, RobotModel};

fn robot(model: &RobotModel) -> Mechanism {
    Mechanism::new(model, &PlannerConfig::default()).unwrap()
}

/// Hubo with another effort (N m) of the joints of one kind.
fn with_effort(kind: &str, effort: f64) -> RobotModel {
    let mut model = hubo();
    model
        .joints
        .iter_mut()
        .filter(|joint| joint.name.ends_with(kind))
        .for_each(|joint| joint.effort = effort);
    model.digest = Digest::of(&[kind.as_bytes(), &effort.to_le_bytes()]);
    model
}

/// Hubo with a waist joint between the root and the legs.
fn with_waist() -> RobotModel {
    let mut model = hubo();
    let waist = model.joints.len();
    for link in &mut model.links[1..] {
        let attachment = link.parent.as_mut().unwrap();
        let is_hip =
            attachment.joint.is_some_and(|joint| model.joints[joint].name.ends_with("hip_yaw"));
        attachment.parent = if attachment.parent > 0 || is_hip { attachment.parent + 1 } else { 0 };
    }
    model.joints.iter_mut().for_each(|joint| joint.child += 1);
    model.feet.iter_mut().for_each(|foot| foot.link += 1);
    let parent =
        Some(Attachment { parent: 0, parent_from_joint: Pose::IDENTITY, joint: Some(waist) });
    let hips = Link {
        name: "hips".into(),
        parent,
        shapes: Vec::new(),
        mass: 0.5,
        ..model.links[0].clone()
    };
    model.links.insert(1, hips);
    model.joints.push(Joint {
        name: "waist".into(),
        axis: DVec3::Z,
        child: 1,
        ..model.joints[0].clone()
    });
    model.standing_q.push(0.0);
    model.digest = Digest::of(&[b"waist"]);
    model
}

/// Hubo with narrow limits of the joints of one kind.
fn with_narrow(kind: &str) -> RobotModel {
    let mut model = hubo();
    for (joint, standing) in model
        .joints
        .iter_mut()
        .zip(&model.standing_q)
        .filter(|(joint, _)| joint.name.ends_with(kind))
    {
        (joint.lower, joint.upper) = (standing - 1e-3, standing + 2e-3);
    }
    model.digest = Digest::of(&[kind.as_bytes(), b"narrow"]);
    model
}

/// Hubo with a finger on its left hand, bent in the standing posture.
fn with_finger() -> RobotModel {
    let mut model = hubo();
    let (finger, joint) = (model.links.len(), model.joints.len());
    let hand = model.links.iter().position(|link| link.name == "left_hand").unwrap();
    let parent = Some(Attachment {
        parent: hand,
        parent_from_joint: Pose::from_translation(DVec3::new(0.0, 0.0, -0.1)),
        joint: Some(joint),
    });
    model.links.push(Link {
        name: "finger".into(),
        parent,
        shapes: Vec::new(),
        mass: 0.03,
        ..model.links[hand].clone()
    });
    model.joints.push(Joint {
        name: "finger".into(),
        axis: DVec3::Y,
        child: finger,
        ..model.joints[0].clone()
    });
    model.standing_q.push(0.2);
    model.digest = Digest::of(&[b"finger"]);
    model
}

#[test]
fn fingers_keep_their_standing_positions_while_arms_move() {
    let model = with_finger();
    let [finger, wrist] = ["finger", "left_wrist_pitch"]
        .map(|name| model.joints.iter().position(|joint| joint.name == name).unwrap());
    let mut planner = Case { model, ..Case::shipped("jungle_gym_full").with_seed(2) }.planner(2);
    assert_eq!(run(&mut planner, 10_000), Outcome::Found);
    let moves = |joint: usize| {
        let mut waypoints = planner.chunks().iter().flat_map(|chunk| chunk.waypoints());
        let first = planner.chunks()[0].waypoints()[0].q[joint];
        waypoints.any(|waypoint| waypoint.q[joint] != first)
    };
    assert_eq!((moves(finger), moves(wrist)), (false, true));
    assert_eq!(planner.chunks()[0].waypoints()[0].q[finger], 0.2);
}

fn finds_a_walk(model: RobotModel) -> bool {
    let case = Case { model, ..Case::shipped("flat_walk") };
    run(&mut case.planner(2), 10_000) == Outcome::Found
}

#[test]
fn a_weak_ankle_holds_the_weight_only_near_its_axis() {
    let strong = robot(&hubo());
    assert_eq!(
        strong.soles[0].ankle_limits.clip(&strong.soles[0].polygon).as_slice(),
        strong.soles[0].polygon
    );
    let weak = robot(&with_effort("ankle_pitch", 40.0));
    let supported = weak.soles[0].ankle_limits.clip(&weak.soles[0].polygon);
    let toe = supported.iter().fold(f64::NEG_INFINITY, |most, corner| most.max(corner.x))
        - PlannerConfig::default().com_margin;
    let kinematic_state = KinematicState::new(
        &weak,
        &Configuration { world_from_root: Pose::IDENTITY, q: weak.standing_q },
    );
    let effort_use = |x: f64| {
        let point =
            (kinematic_state.world_from_sole(&weak, 0) * DVec3::new(x, 0.0, 0.0)).truncate();
        effort_use(
            &weak.mass_tree,
            &kinematic_state,
            &[FootLoad { share: 1.0, point }, FootLoad { share: 0.0, point: DVec2::ZERO }],
        )
    };
    assert!(
        toe < 0.1 && effort_use(toe) < 1.05 && effort_use(toe + 0.01) > 1.05,
        "{toe} {} {}",
        effort_use(toe),
        effort_use(toe + 0.01)
    );
}

#[test]
fn a_robot_with_weak_ankles_walks() {
    assert!(finds_a_walk(with_effort("ankle_pitch", 25.0)));
}

fn single_support_postures(model: &RobotModel) -> [SingleSupportPosture; 2] {
    let robot = robot(model);
    [0, 1].map(|limb| SingleSupportPosture::derive(&robot, limb))
}

#[test]
fn a_robot_leans_over_weak_hips_only() {
    assert_eq!(single_support_postures(&hubo()).map(|posture| posture.rotation), [[0.0; 2]; 2]);
    let required = single_support_postures(&hubo())[0].effort_use;
    let hip = hubo().joints.iter().find(|joint| joint.name == "left_hip_roll").unwrap().effort;
    let model = with_effort("hip_roll", 0.85 * required * hip);
    let [left, right] = single_support_postures(&model);
    assert!(
        left.effort_use < 1.0 && right.effort_use < 1.0,
        "{} {}",
        left.effort_use,
        right.effort_use
    );
    // A roll to the left is negative.
    assert!(
        left.rotation[0] < 0.0 && right.rotation[0] > 0.0,
        "{:?} {:?}",
        left.rotation,
        right.rotation
    );
    assert!(finds_a_walk(model));
}

#[test]
fn the_trunk_leans_over_a_foot_whose_ankle_rolls_little() {
    let mut model = hubo();
    for joint in model.joints.iter_mut().filter(|joint| joint.name.ends_with("ankle_roll")) {
        (joint.lower, joint.upper) = (-0.2, 0.2);
    }
    let waist = model.joints.iter().position(|joint| joint.name == "waist_yaw").unwrap();
    let yawing = single_support_postures(&model);
    assert!(
        yawing.iter().all(|posture| posture.margin_deficit > 0.0 && posture.q[waist] == 0.0),
        "a yaw of the trunk does not help"
    );
    (model.joints[waist].axis, model.joints[waist].lower, model.joints[waist].upper) =
        (DVec3::X, -0.5, 0.5);
    let [left, right] = single_support_postures(&model);
    assert!(
        left.margin_deficit < yawing[0].margin_deficit && left.rotation == [0.0; 2],
        "{left:?}"
    );
    assert!(left.q[waist] < -0.1 && right.q[waist] > 0.1, "{} {}", left.q[waist], right.q[waist]);
    model.digest = Digest::of(&[b"rolling waist"]);
    assert!(finds_a_walk(model));
}

#[test]
fn a_joint_that_carries_both_legs_does_not_move() {
    let model = with_waist();
    let robot = robot(&model);
    let waist = model.joints.len() - 1;
    assert!(robot.legs.iter().all(|leg| leg.joints().iter().all(|joint| joint.index != waist)));
    let soles = [0.12, -0.09].map(|y| Pose::from_translation(DVec3::new(y, y, 0.0)));
    let height = -0.97 * robot.legs[0].root_from_sole(&robot.standing_q).translation.z;
    let mut configuration = Configuration {
        world_from_root: Pose::from_translation(DVec3::Z * height),
        q: robot.standing_q,
    };
    assert!(robot.place_soles(&mut configuration, &soles));
    let kinematic_state = KinematicState::new(&robot, &configuration);
    let missed = [0, 1].map(|limb| {
        kinematic_state.world_from_sole(&robot, limb).translation.distance(soles[limb].translation)
    });
    assert!(missed.iter().all(|missed| *missed < 1e-8), "{missed:?}");
    assert!(finds_a_walk(model));
}

#[test]
fn a_joint_narrower_than_its_margins_is_allowed() {
    assert!(finds_a_walk(with_narrow("shoulder_roll")));
    let model = with_narrow("hip_pitch");
    let narrow = robot(&model);
    let joint = narrow.legs[0]
        .joints()
        .iter()
        .find(|joint| model.joints[joint.index].name.ends_with("hip_pitch"))
        .unwrap();
    let middle = model.joints[joint.index].lower.midpoint(model.joints[joint.index].upper);
    assert_eq!([joint.lower, joint.upper], [middle; 2]);
}
