//! Contact, balance and torques against cases computed by hand: what holds passes with the right
//! margin, what does not is named.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

mod check_robot;
mod checked_motion;

use check_robot::*;
use checked_motion::{check_motion, refused};
use glam::DVec3;
use surefoot_controller_sim::kinematics::forward::{Configuration, Posture};
use surefoot_shared_types::base::spatial::rotation_about;
use surefoot_shared_types::message::Check;
use surefoot_shared_types::robot::model::{Joint, LockedJoint, RobotModel};
use surefoot_shared_types::world::world::{GRAVITY, World};
use surefoot_shared_types::{Pose, Shape};

#[test]
fn standing_is_accepted_with_the_margins_computed_by_hand() {
    let margins =
        check_motion(robot(), world(vec![]), &both_feet(), &swing((0.0, 0.0), (0.3, 0.0), 4))
            .unwrap();
    // The elbow is 2.5 from its limits at 0, the shoulder 2.2 at 0.3.
    assert!((margins.limits - 2.2).abs() < 1e-9, "{margins:?}");
    assert!((margins.contact - 2e-3).abs() < 1e-9, "{margins:?}");
    // The support polygon is 0.2 m long; the arm (4 of 34 kg) moves the centre of mass by less than
    // 3 cm forwards.
    assert!(margins.balance > 0.07 && margins.balance < 0.1, "{margins:?}");
    // The shin ends 0.04 m over the floor but belongs to the foot's link; the hand hangs 0.33 m
    // over the floor.
    assert_eq!(margins.collision, 0.1);
    // The upper arm ends 0.38 m below the shoulder, the forearm begins 0.42 m below it.
    assert!((margins.self_collision - 0.04).abs() < 1e-6, "{margins:?}");
}

#[test]
fn a_pendulum_needs_weight_times_lever() {
    let (model, lean) = (robot(), 0.7);
    let posture = Posture::new(
        &model,
        &Configuration { world_from_root: at(0., 0., 0.9), q: vec![0., 0., lean, 0.] },
    );
    // Swinging an arm back by a positive turn about y: its links' centres lie 0.2 and 0.6 m from
    // the shoulder.
    let expected = -MASSES[2] * GRAVITY * (0.2 + 0.6) * -libm::sin(lean);
    let torques = posture.gravity_torques(&model);
    assert!((torques[SHOULDER] - expected).abs() < 1e-9, "{torques:?}");
    let total = MASSES[0] + 2.0 * (MASSES[1] + MASSES[2]);
    let com = posture.centre_of_mass(&model);
    assert!((com.x - MASSES[2] * (0.2 + 0.6) * -libm::sin(lean) / total).abs() < 1e-12, "{com}");
    assert!((com.y - 2.0 * MASSES[2] * 0.25 / total).abs() < 1e-12, "{com}");
    // On one foot the stance hip carries everything but its own leg, about its own axis.
    let standing = posture.standing_torques(&model, 0);
    assert!((standing[0] - (torques[0] + com.x * total * GRAVITY)).abs() < 1e-9, "{standing:?}");
    assert_eq!(standing[1], torques[1]);
}

#[test]
fn a_robot_turned_as_a_whole_keeps_its_shape() {
    let model = robot();
    let q = vec![0.1, -0.2, 0.7, 0.4];
    let upright =
        Posture::new(&model, &Configuration { world_from_root: Pose::IDENTITY, q: q.clone() });
    let turn =
        Pose::from_parts(DVec3::new(1., 2., 3.), rotation_about(DVec3::new(0.6, 0.0, 0.8), 1.1));
    let turned = Posture::new(&model, &Configuration { world_from_root: turn, q });
    for (a, b) in upright.world_from_link.iter().zip(&turned.world_from_link) {
        assert!((turn * a.translation - b.translation).length() < 1e-12);
    }
}

#[test]
fn straight_lines_that_need_more_friction_are_refused() {
    // The arm, 4 of 34 kg, sets off at 0.1 rad/s: its centre accelerates by 0.02 m/s2.
    let check = |mu: f64| {
        let icy = World { mu, ..world(vec![]) };
        check_motion(robot(), icy, &both_feet(), &swing((0.0, 0.0), (0.3, 0.0), 4))
    };
    check(0.004).unwrap();
    refused(check(0.001), Check::ZeroMoment, "friction holds 0.1");
}

#[test]
fn a_foot_off_its_declared_pose_is_refused() {
    let mut contacts = both_feet();
    contacts[1].position[0] = 0.0021;
    refused(
        check_motion(robot(), world(vec![]), &contacts, &swing((0.0, 0.0), (0.1, 0.0), 2)),
        Check::Contact,
        "right sole",
    );
    // A hip turned by 0.004 rad moves its sole by 3.6 mm.
    let mut waypoints = [waypoint(0.0, 0.0, 0.0), waypoint(1.0, 0.0, 0.0)];
    waypoints[1].q[0] = 0.004;
    refused(
        check_motion(robot(), world(vec![]), &both_feet(), &waypoints),
        Check::Contact,
        "left sole",
    );
}

#[test]
fn a_sole_needs_ground_under_it() {
    let mut on_edge = world(vec![]);
    // The floor ends 2 mm behind the toes: 2 mm x 10 cm support the left sole, which is less than 5
    // cm2.
    on_edge.shapes[0].world_from_shape = at(3.098, 0.0, -0.25);
    refused(
        check_motion(robot(), on_edge, &both_feet(), &swing((0.0, 0.0), (0.1, 0.0), 2)),
        Check::Contact,
        "cm2",
    );
    let mut sunk = world(vec![]);
    sunk.shapes[0].world_from_shape = at(0.0, 0.0, -0.246);
    refused(
        check_motion(robot(), sunk, &both_feet(), &swing((0.0, 0.0), (0.1, 0.0), 2)),
        Check::Contact,
        "deep",
    );
    let mut far = world(vec![]);
    far.shapes[0].world_from_shape = at(0.0, 0.0, -0.2531);
    refused(
        check_motion(robot(), far, &both_feet(), &swing((0.0, 0.0), (0.1, 0.0), 2)),
        Check::Contact,
        "3.10 mm off the ground",
    );
}

#[test]
fn two_bars_support_a_sole_over_their_span() {
    let mut bars = world(vec![]);
    bars.shapes.clear();
    let lying = |x: f64| {
        Pose::from_parts(
            DVec3::new(x, 0.0, -0.02),
            rotation_about(DVec3::X, std::f64::consts::FRAC_PI_2),
        )
    };
    for (name, x) in [("rear", -0.06), ("front", 0.07)] {
        let bar = Shape::Cylinder { radius: 0.02, half_length: 1.0 };
        bars.shapes.push(surefoot_shared_types::world::world::WorldShape {
            name: name.into(),
            world_from_shape: lying(x),
            shape: bar,
        });
    }
    let margins =
        check_motion(robot(), bars.clone(), &both_feet(), &swing((0.0, 0.0), (0.1, 0.0), 2))
            .unwrap();
    // The centre of mass is near the middle; the rear bar is 6 cm behind it, the line of contact a
    // few mm wide.
    assert!(margins.balance > 0.05 && margins.balance < 0.065, "{margins:?}");
    // One bar alone carries each sole on a strip of a few millimetres.
    bars.shapes.pop();
    refused(
        check_motion(robot(), bars, &both_feet(), &swing((0.0, 0.0), (0.1, 0.0), 2)),
        Check::Contact,
        "cm2",
    );
}

#[test]
fn a_slope_beyond_friction_or_a_tilted_surface_is_no_ground() {
    let tilted = |angle: f64, mu: f64| {
        let mut slope = world(vec![]);
        let turn = rotation_about(DVec3::Y, angle);
        slope.shapes[0].world_from_shape =
            Pose::from_parts(turn * DVec3::new(0.0, 0.0, -0.25), turn);
        slope.mu = mu;
        check_motion(robot(), slope, &both_feet(), &swing((0.0, 0.0), (0.1, 0.0), 2))
    };
    tilted(0.002, 0.6).unwrap();
    refused(tilted(0.002, 0.0019), Check::Contact, "cm2");
    refused(tilted(0.15, 0.6), Check::Contact, "");
}

#[test]
fn leaning_out_of_the_support_is_refused() {
    let mut heavy = robot();
    heavy.links[4].mass = 30.0;
    let result =
        check_motion(heavy, world(vec![]), &both_feet(), &swing((0.0, 0.0), (1.2, 0.0), 13));
    let violation = refused(result, Check::Balance, "centre of mass");
    assert!(violation.waypoint > 0, "it stands at first: {violation}");
    let one_foot =
        check_motion(robot(), world(vec![]), &[contact(0)], &swing((0.0, 0.0), (0.1, 0.0), 2));
    refused(one_foot, Check::Balance, "left foot");
}

#[test]
fn a_weak_joint_is_named() {
    let mut weak = robot();
    // Held level, the arm needs 2 kg x 9.81 x (0.2 + 0.6) m = 15.7 N m.
    // The checker allows 95 % of the limit.
    weak.joints[SHOULDER].effort = 15.6 / 0.95;
    let level = |world: World, robot: RobotModel| {
        check_motion(
            robot,
            world,
            &both_feet(),
            &swing((-1.4, 0.0), (-std::f64::consts::FRAC_PI_2, 0.0), 2),
        )
    };
    refused(level(world(vec![]), weak.clone()), Check::Torque, "shoulder");
    let effort = 15.8 / 0.95;
    weak.joints[SHOULDER].effort = effort;
    let margins = level(world(vec![]), weak).unwrap();
    assert!((margins.torque - (1.0 - 1.6 * GRAVITY / effort)).abs() < 1e-4, "{margins:?}");
}

#[test]
fn a_joint_that_is_weak_between_two_waypoints_is_named() {
    let level = std::f64::consts::FRAC_PI_2;
    let past_level = |effort: f64| {
        let mut weak = robot();
        weak.joints[SHOULDER].effort = effort;
        check_motion(
            weak,
            world(vec![]),
            &both_feet(),
            &swing((0.1 - level, 0.0), (-0.1 - level, 0.0), 2),
        )
    };
    let needed = 1.6 * GRAVITY / 0.95;
    refused(past_level(needed * 0.5 * (1.0 + libm::cos(0.1))), Check::Torque, "shoulder");
    assert!(past_level(1.01 * needed).is_ok());
}

/// The robot whose elbow is locked at half a radian and may need `effort`.
fn robot_with_locked_elbow(effort: f64) -> RobotModel {
    let mut robot = robot();
    let elbow = Joint { effort, ..robot.joints.pop().unwrap() };
    robot.standing_q.pop();
    let attachment = robot.links[elbow.child].parent.as_mut().unwrap();
    let parent_from_joint = attachment.parent_from_joint;
    attachment.joint = None;
    attachment.parent_from_joint =
        parent_from_joint * Pose::from_parts(DVec3::ZERO, rotation_about(elbow.axis, 0.5));
    robot.locked_joints.push(LockedJoint { joint: elbow, position: 0.5, parent_from_joint });
    robot
}

#[test]
fn a_locked_joint_must_hold_its_load_too() {
    let needed = MASSES[2] * GRAVITY * 0.2 * libm::sin(0.5) / 0.95;
    let stand = |effort| {
        check_motion(
            robot_with_locked_elbow(effort),
            world(vec![]),
            &both_feet(),
            &[waypoint(0.0, 0.0, 0.0)],
        )
    };
    refused(stand(0.99 * needed), Check::Torque, "elbow");
    assert!((stand(2.0 * needed).unwrap().torque - (1.0 - 0.5 * 0.95)).abs() < 1e-4);
    assert!(stand(f64::INFINITY).is_ok());
}

#[test]
fn two_feet_share_the_load_as_well_as_they_can() {
    // Both hips turn about one line, so together they hold the arm's 2 kg x 9.81 x 0.8 m x
    // sin(0.6); at best half each.
    let half = 0.5 * MASSES[2] * GRAVITY * 0.8 * libm::sin(0.6) / 0.95;
    let hips_of = |effort: f64| {
        let mut weak = robot();
        (weak.joints[0].effort, weak.joints[1].effort) = (effort, effort);
        check_motion(weak, world(vec![]), &both_feet(), &swing((-0.5, 0.0), (-0.6, 0.0), 2))
    };
    let margins = hips_of(1.02 * half).unwrap();
    assert!((margins.torque - (1.0 - 0.95 / 1.02)).abs() < 1e-4, "{margins:?}");
    refused(hips_of(0.98 * half), Check::Torque, "hip");
}
