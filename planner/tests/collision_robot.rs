//! The collision model of the reference robot.

use std::path::Path;

use glam::{DQuat, DVec3};
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::collision::model::{CollisionModel, FootPhase, Hit};
use surefoot_planner::kinematics::{KinematicTree, Kinematics};
use surefoot_planner::robot::kinematic_state::KinematicState;
use surefoot_planner::robot::mechanism::Mechanism;
use surefoot_shared_types::base::spatial::rotation_from_scaled_axis;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::robot::model::{LockedJoint, RobotModel};
use surefoot_shared_types::world::world::{World, WorldShape};
use surefoot_shared_types::{Pose, Shape};

const CLEARANCE: f64 = 0.01;
const STANCE: [FootPhase; 2] = [FootPhase::Stance; 2];

fn hubo() -> RobotModel {
    load_robot(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../configs/robots/hubo/robot.toml"))
        .expect("the reference robot loads")
}

fn world(boxes: &[(DVec3, DVec3)]) -> World {
    let place = |(index, &(center, half_extents)): (usize, &(DVec3, DVec3))| WorldShape {
        name: format!("box {index}"),
        world_from_shape: Pose::from_parts(center, DQuat::IDENTITY),
        shape: Shape::Box { half_extents },
    };
    World {
        mu: 0.6,
        shapes: boxes.iter().enumerate().map(place).collect(),
        digest: Default::default(),
    }
}

/// A floor whose top is at `top`.
fn floor(top: f64) -> (DVec3, DVec3) {
    (DVec3::new(0.0, 0.0, top - 0.25), DVec3::new(5.0, 5.0, 0.25))
}

fn poses_at(robot: &RobotModel, root: &Pose, q: &[f64]) -> Vec<Pose> {
    let mut poses = vec![Pose::IDENTITY; robot.links.len()];
    Kinematics::new(robot).forward(root, q, &mut poses);
    poses
}

fn state_of(robot: &RobotModel, poses: &[Pose]) -> KinematicState {
    KinematicState::from_link_poses(
        &Mechanism::new(robot, &PlannerConfig::default()).expect("the robot walks"),
        poses,
    )
}

/// Link poses of the standing robot with the left sole at height 0.
fn standing(robot: &RobotModel) -> Vec<Pose> {
    let at_origin = poses_at(robot, &Pose::IDENTITY, &robot.standing_q);
    let sole = at_origin[robot.feet[0].link] * robot.feet[0].link_from_sole;
    let root = Pose::from_parts(DVec3::new(0.0, 0.0, -sole.translation.z), DQuat::IDENTITY);
    poses_at(robot, &root, &robot.standing_q)
}

fn raised(poses: &[Pose], by: f64) -> Vec<Pose> {
    poses
        .iter()
        .map(|pose| Pose::from_parts(pose.translation + DVec3::Z * by, pose.rotation))
        .collect()
}

#[test]
fn the_standing_robot_hits_nothing() {
    let robot = hubo();
    let model = CollisionModel::new(&robot, &world(&[floor(0.0)]), CLEARANCE).unwrap();
    let poses = standing(&robot);
    assert_eq!(model.hit(&state_of(&robot, &poses), &STANCE), None);
    assert_eq!(model.self_hit(&state_of(&robot, &poses)), None);
}

#[test]
fn self_clearance_is_at_most_half_of_the_standing_distance() {
    let robot = hubo();
    let model = CollisionModel::new(&robot, &world(&[]), 0.5).unwrap();
    let poses = standing(&robot);
    assert_eq!(model.self_hit(&state_of(&robot, &poses)), None);
    // The feet must keep half of the distance between their boxes.
    let soles =
        [0, 1].map(|limb: usize| poses[robot.feet[limb].link] * robot.feet[limb].link_from_sole);
    let distance = (soles[0].translation.y - soles[1].translation.y) - 0.14;
    let left_at =
        |apart: f64| Pose::from_parts(DVec3::new(0.0, 0.14 + apart, 0.0), DQuat::IDENTITY);
    assert!(model.feet_hit([&left_at(0.5 * distance - 1e-6), &Pose::IDENTITY]));
    assert!(!model.feet_hit([&left_at(0.5 * distance + 1e-6), &Pose::IDENTITY]));
}

#[test]
fn the_foot_phase_decides_the_clearance_to_the_floor() {
    let robot = hubo();
    let model = CollisionModel::new(&robot, &world(&[floor(0.0)]), CLEARANCE).unwrap();
    let poses = standing(&robot);
    let hits = |by: f64, phase: FootPhase| {
        model.world_hit(&state_of(&robot, &raised(&poses, by)), &[phase; 2]).is_some()
    };
    assert!(
        !hits(0.0, FootPhase::Stance)
            && !hits(-0.0014, FootPhase::Stance)
            && hits(-0.0016, FootPhase::Stance)
    );
    assert!(
        !hits(0.0, FootPhase::LiftOff)
            && !hits(-0.0002, FootPhase::LiftOff)
            && hits(-0.0004, FootPhase::LiftOff)
    );
    assert!(hits(0.0014, FootPhase::Rising) && !hits(0.0016, FootPhase::Rising));
    assert!(
        hits(0.0, FootPhase::Swing)
            && hits(0.0099, FootPhase::Swing)
            && !hits(0.0101, FootPhase::Swing)
    );
}

#[test]
fn clearance_beside_a_foot_applies_in_lift_off_and_not_in_stance() {
    let robot = hubo();
    let poses = standing(&robot);
    let foot = poses[robot.feet[0].link] * robot.feet[0].link_from_sole;
    let outer = robot.feet[0].polygon.iter().map(|corner| corner.y).fold(0.0, f64::max);
    let side = foot.translation.y + outer;
    let with_wall = |apart: f64| {
        let wall = (DVec3::new(0.0, side + apart + 0.25, 0.03), DVec3::new(5.0, 0.25, 0.03));
        CollisionModel::new(&robot, &world(&[floor(0.0), wall]), CLEARANCE).unwrap()
    };
    assert_eq!(with_wall(0.009).foot_hit(0, &foot, FootPhase::Stance), None);
    assert_eq!(with_wall(0.009).foot_hit(0, &foot, FootPhase::LiftOff), Some(1));
    assert_eq!(with_wall(0.011).foot_hit(0, &foot, FootPhase::LiftOff), None);
    let rising = Pose::from_parts(foot.translation + 0.002 * DVec3::Z, foot.rotation);
    assert_eq!(with_wall(0.009).foot_hit(0, &rising, FootPhase::Rising), Some(1));
    assert_eq!(with_wall(0.011).foot_hit(0, &rising, FootPhase::Rising), None);
    assert!(with_wall(0.011).foot_hit(0, &foot, FootPhase::Swing).is_some());
    assert_eq!(with_wall(-0.001).foot_hit(0, &foot, FootPhase::Stance), Some(1));
}

#[test]
fn a_foot_that_leaves_its_foothold_may_touch_the_world_for_5_mm_and_20_mrad() {
    let at = Pose::from_parts(DVec3::new(0.3, -0.1, 0.2), rotation_from_scaled_axis(DVec3::X));
    let far = Pose::from_translation(DVec3::X);
    let phase_at = |shift: f64, turn: f64| {
        let moved = Pose::from_parts(DVec3::Y * shift, rotation_from_scaled_axis(DVec3::Z * turn));
        let phases = [[at, far], [far, at]]
            .map(|footholds| FootPhase::of_leaving(&footholds, &(at * moved)));
        assert_eq!(phases[0], phases[1]);
        phases[0]
    };
    assert_eq!(phase_at(0.0, 0.0), FootPhase::LiftOff);
    assert_eq!(phase_at(0.0049, 0.0199), FootPhase::LiftOff);
    assert_eq!(phase_at(0.0051, 0.0), FootPhase::Rising);
    assert_eq!(phase_at(0.0, 0.0201), FootPhase::Rising);
}

#[test]
fn a_foot_alone_is_checked_like_the_foot_of_the_robot() {
    let robot = hubo();
    let mut random = Random::new(4, Stream::Preparation, 1, 0);
    let mut offset = |reach: f64| {
        DVec3::new(
            random.uniform(-reach, reach),
            random.uniform(-reach, reach),
            random.uniform(-reach, reach),
        )
    };
    let blocks: Vec<_> = (0..20).map(|_| (offset(0.5), DVec3::splat(0.03))).collect();
    let model = CollisionModel::new(&robot, &world(&blocks), CLEARANCE).unwrap();
    let at_rest = standing(&robot);
    let foot = &robot.feet[1];
    let mut hits = 0;
    for _ in 0..2_000 {
        let world_from_sole = Pose::from_parts(offset(0.4), rotation_from_scaled_axis(offset(0.5)));
        // The rest of the robot is far away.
        let mut poses = raised(&at_rest, 100.0);
        poses[foot.link] = world_from_sole * foot.link_from_sole.inverse();
        for phase in [FootPhase::Stance, FootPhase::LiftOff, FootPhase::Rising, FootPhase::Swing] {
            let foot_alone = model.foot_hit(1, &world_from_sole, phase);
            let whole = model.world_hit(&state_of(&robot, &poses), &[FootPhase::Swing, phase]);
            assert_eq!(foot_alone.map(|shape| Hit::World { link: foot.link, shape }), whole);
            hits += usize::from(foot_alone.is_some());
        }
    }
    assert!((100..7_900).contains(&hits), "{hits}");
}

#[test]
fn feet_side_by_side_do_not_collide_and_overlapping_feet_do() {
    let robot = hubo();
    let model = CollisionModel::new(&robot, &world(&[]), CLEARANCE).unwrap();
    let right = Pose::IDENTITY;
    let width = 0.14;
    let left_at = |y: f64| Pose::from_parts(DVec3::new(0.0, y, 0.0), DQuat::IDENTITY);
    assert!(!model.feet_hit([&left_at(0.2), &right]));
    assert!(!model.feet_hit([&left_at(width + CLEARANCE + 1e-6), &right]));
    assert!(model.feet_hit([&left_at(width + CLEARANCE - 1e-6), &right]));
    assert!(model.feet_hit([&left_at(0.0), &right]));
}

#[test]
fn every_link_that_touches_a_block_is_found() {
    let robot = hubo();
    let tree = KinematicTree::new(&robot);
    let poses = standing(&robot);
    for (link, pose) in
        poses.iter().enumerate().filter(|&(link, _)| !robot.links[link].shapes.is_empty())
    {
        let center = *pose * robot.links[link].shapes[0].link_from_shape.translation;
        let model =
            CollisionModel::new(&robot, &world(&[(center, DVec3::splat(0.001))]), CLEARANCE)
                .unwrap();
        let is_fixed_to_link = |other: usize| tree.of_link(other).0 == tree.of_link(link).0;
        let alone: Vec<Pose> = poses
            .iter()
            .enumerate()
            .map(|(i, p)| if is_fixed_to_link(i) { *p } else { raised(&[*p], 50.0)[0] })
            .collect();
        assert_eq!(
            model.world_hit(&state_of(&robot, &alone), &STANCE),
            Some(Hit::World { link, shape: 0 }),
            "{}",
            robot.links[link].name
        );
    }
}

#[test]
fn crossed_legs_collide() {
    let robot = hubo();
    let model = CollisionModel::new(&robot, &world(&[]), CLEARANCE).unwrap();
    let mut poses = standing(&robot);
    let (left, right) = (robot.feet[0].link, robot.feet[1].link);
    poses[left] = poses[right];
    let (a, b) = (left.min(right), left.max(right));
    assert_eq!(model.self_hit(&state_of(&robot, &poses)), Some(Hit::SelfPair { a, b }));
}

#[test]
fn allowed_pairs_are_deterministic_and_contain_only_neighbours() {
    let robot = hubo();
    let build = || CollisionModel::new(&robot, &world(&[]), CLEARANCE).unwrap();
    let (first, second) = (build(), build());
    assert_eq!(first.allowed_pairs(), second.allowed_pairs());
    assert!(first.allowed_pairs().is_sorted() && first.allowed_pairs().iter().all(|(a, b)| a < b));
    let (left, right) = (robot.feet[0].link, robot.feet[1].link);
    assert!(!first.allowed_pairs().contains(&(left.min(right), left.max(right))));
    for (link, attachment) in robot
        .links
        .iter()
        .enumerate()
        .filter_map(|(link, l)| l.parent.as_ref().map(|parent| (link, parent)))
    {
        let has_shapes = |link: usize| !robot.links[link].shapes.is_empty();
        // A forearm meets its upper arm where the elbow is bent far.
        let is_free = robot.links[link].name.ends_with("_forearm");
        if has_shapes(link) && has_shapes(attachment.parent) {
            assert!(is_free != first.allowed_pairs().contains(&(attachment.parent, link)));
        }
    }
    assert!(first.bytes() > 1_000);
}

fn joint_index(robot: &RobotModel, name: &str) -> usize {
    robot.joints.iter().position(|joint| joint.name == name).expect("the robot has this joint")
}

fn link_index(robot: &RobotModel, name: &str) -> usize {
    robot.links.iter().position(|link| link.name == name).expect("the robot has this link")
}

#[test]
fn links_beside_a_joint_collide_where_it_is_bent_far() {
    let robot = hubo();
    let model = CollisionModel::new(&robot, &world(&[]), CLEARANCE).unwrap();
    let elbow = joint_index(&robot, "left_elbow");
    let mut q = robot.standing_q.clone();
    q[elbow] = robot.joints[elbow].lower;
    let poses = poses_at(&robot, &Pose::IDENTITY, &q);
    let [a, b] = ["left_upper_arm", "left_forearm"].map(|name| link_index(&robot, name));
    assert_eq!(model.self_hit(&state_of(&robot, &poses)), Some(Hit::SelfPair { a, b }));
}

#[test]
fn links_that_overlap_where_the_robot_stands_may_touch() {
    let mut robot = hubo();
    let elbow = joint_index(&robot, "left_elbow");
    robot.standing_q[elbow] = robot.joints[elbow].lower;
    let model = CollisionModel::new(&robot, &world(&[]), CLEARANCE).unwrap();
    assert_eq!(model.self_hit(&state_of(&robot, &standing(&robot))), None);
}

/// The robot with a joint locked at a position.
fn with_locked_joint(mut robot: RobotModel, (name, position): (&str, f64)) -> RobotModel {
    let index =
        robot.joints.iter().position(|joint| joint.name == name).expect("the robot has this joint");
    let joint = robot.joints.remove(index);
    robot.standing_q.remove(index);
    for attachment in robot.links.iter_mut().filter_map(|link| link.parent.as_mut()) {
        attachment.joint =
            attachment.joint.filter(|&at| at != index).map(|at| at - usize::from(at > index));
    }
    let attachment = robot.links[joint.child].parent.as_mut().expect("a joint leads there");
    let parent_from_joint = attachment.parent_from_joint;
    attachment.parent_from_joint =
        parent_from_joint * Pose::from_rotation(rotation_from_scaled_axis(position * joint.axis));
    robot.locked_joints.push(LockedJoint { joint, position, parent_from_joint });
    robot
}

#[test]
fn links_do_not_become_neighbours_because_a_joint_between_them_is_locked() {
    let free = CollisionModel::new(&hubo(), &world(&[]), CLEARANCE).unwrap();
    let locked = [("left_elbow", -0.4), ("left_wrist_yaw", 0.0), ("right_shoulder_roll", -0.15)]
        .into_iter()
        .fold(hubo(), with_locked_joint);
    let model = CollisionModel::new(&locked, &world(&[]), CLEARANCE).unwrap();
    assert_eq!(model.allowed_pairs(), free.allowed_pairs());
    assert_eq!(model.self_hit(&state_of(&locked, &standing(&locked))), None);
}

#[test]
fn locked_links_that_overlap_collide() {
    let arm = [
        ("left_shoulder_pitch", 0.0),
        ("left_shoulder_roll", 0.0),
        ("left_shoulder_yaw", -1.57),
        ("left_elbow", -1.57),
    ];
    let locked = arm.into_iter().fold(hubo(), with_locked_joint);
    let model = CollisionModel::new(&locked, &world(&[]), CLEARANCE).unwrap();
    let hit = model.self_hit(&state_of(&locked, &standing(&locked))).map(|hit| model.describe(hit));
    assert!(
        hit.as_deref().is_some_and(|hit| hit.starts_with("link 'torso' collides with link 'left_")),
        "{hit:?}"
    );
}

#[test]
fn no_corner_moves_farther_than_the_bound() {
    let robot = hubo();
    let model = CollisionModel::new(&robot, &world(&[]), CLEARANCE).unwrap();
    let mut random = Random::new(8, Stream::Preparation, 2, 0);
    for _ in 0..300 {
        let mut random_poses = || {
            let q: Vec<f64> =
                robot.joints.iter().map(|joint| random.uniform(joint.lower, joint.upper)).collect();
            let offset = DVec3::new(
                random.uniform(-2.0, 2.0),
                random.uniform(-2.0, 2.0),
                random.uniform(-2.0, 2.0),
            );
            poses_at(&robot, &Pose::from_parts(offset, rotation_from_scaled_axis(offset)), &q)
        };
        let (from, to) = (random_poses(), random_poses());
        let bound = model.motion_bound(&state_of(&robot, &from), &state_of(&robot, &to));
        let mut farthest: f64 = 0.0;
        for (link, robot) in robot.links.iter().enumerate() {
            for placed in &robot.shapes {
                let reach = match &placed.shape {
                    Shape::Box { half_extents } => *half_extents,
                    Shape::Cylinder { half_length, .. } => DVec3::new(0.0, 0.0, *half_length),
                    Shape::Capsule { half_length, radius } => {
                        DVec3::new(0.0, 0.0, half_length + radius)
                    }
                    _ => DVec3::ZERO,
                };
                for corner in [
                    reach,
                    -reach,
                    reach * DVec3::new(1.0, -1.0, 1.0),
                    reach * DVec3::new(-1.0, 1.0, 1.0),
                ] {
                    let point = placed.link_from_shape * corner;
                    farthest = farthest.max((to[link] * point - from[link] * point).length());
                }
            }
        }
        assert!(farthest <= bound && bound < 2.0 * farthest, "{farthest} {bound}");
    }
}

#[test]
fn an_invalid_clearance_or_shape_is_an_error() {
    let robot = hubo();
    for clearance in [-0.01, f64::NAN, f64::INFINITY] {
        assert!(
            CollisionModel::new(&robot, &world(&[]), clearance)
                .unwrap_err()
                .to_string()
                .contains("clearance")
        );
    }
    let flat = world(&[(DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0))]);
    assert!(
        CollisionModel::new(&robot, &flat, CLEARANCE)
            .unwrap_err()
            .to_string()
            .starts_with("world shape 'box 0'")
    );
    let mut invalid = world(&[floor(0.0)]);
    invalid.shapes[0].world_from_shape.translation.x = f64::NAN;
    assert!(CollisionModel::new(&robot, &invalid, CLEARANCE).is_err());
}
