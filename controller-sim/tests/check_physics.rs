//! Each physical check against cases computed by hand: what holds passes with the right margin,
//! what does not is named.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

mod check_robot;

use check_robot::*;
use glam::DVec3;
use surefoot_controller_sim::kinematics::forward::{Configuration, Posture};
use surefoot_controller_sim::{Checker, CheckerError, Course, MotionSegment, Violation};
use surefoot_shared_types::base::spatial::rotation_about;
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::Margins;
use surefoot_shared_types::message::{Check, Contact, SupportMode, Waypoint};
use surefoot_shared_types::robot::model::{
    AllowedOverlap, Attachment, Joint, LinkShape, LockedJoint, RobotModel,
};
use surefoot_shared_types::world::world::{GRAVITY, World};
use surefoot_shared_types::{Pose, Shape};

fn check_motion(
    robot: RobotModel,
    world: World,
    contacts: &[Contact],
    waypoints: &[Waypoint],
) -> Result<Margins, Violation> {
    let mode = match contacts {
        [one] if one.limb == 0 => SupportMode::Left,
        [_] => SupportMode::Right,
        _ => SupportMode::Double,
    };
    let mut checker = Checker::new(robot, world, CheckerConfig::default()).unwrap();
    checker.check_segment(
        &MotionSegment { mode, contacts, waypoints, course: Course::Straight },
        &mut || {},
    )
}

fn refused(result: Result<Margins, Violation>, check: Check, words: &str) -> Violation {
    let violation = result.expect_err("must be refused");
    assert_eq!(violation.check, check, "{violation}");
    assert!(violation.detail.contains(words), "{violation}");
    violation
}

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
fn a_joint_past_its_limit_is_named() {
    let waypoints = swing((2.3, 0.0), (2.51, 0.0), 3);
    let violation = refused(
        check_motion(robot(), world(vec![]), &both_feet(), &waypoints),
        Check::Limits,
        "shoulder",
    );
    assert_eq!(violation.waypoint, 2);
}

#[test]
fn jumps_and_stopped_clocks_are_refused() {
    let jump = swing((0.0, 0.0), (0.21, 0.0), 2);
    refused(check_motion(robot(), world(vec![]), &both_feet(), &jump), Check::Spacing, "shoulder");
    let mut stopped = swing((0.0, 0.0), (0.1, 0.0), 3);
    stopped[2].time = stopped[1].time;
    assert_eq!(
        refused(
            check_motion(robot(), world(vec![]), &both_feet(), &stopped),
            Check::Spacing,
            "time"
        )
        .waypoint,
        1
    );
    let mut slide = swing((0.0, 0.0), (0.1, 0.0), 2);
    slide[1].root_position[0] = 1e6;
    refused(check_motion(robot(), world(vec![]), &both_feet(), &slide), Check::Spacing, "root");
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

#[test]
fn a_collision_with_a_thin_rod_between_two_waypoints_is_found() {
    // The hand moves 0.77 m x 0.2 rad = 0.15 m in one step, over a rod of 1 cm that neither end
    // touches.
    let rod =
        |x: f64| ("rod", at(x, 0.25, 0.45), Shape::Cylinder { radius: 0.005, half_length: 0.05 });
    let waypoints = swing((-0.1, 0.0), (0.1, 0.0), 2);
    refused(
        check_motion(robot(), world(vec![rod(0.0)]), &both_feet(), &waypoints),
        Check::Collision,
        "forearm overlaps rod",
    );
    let margins = check_motion(robot(), world(vec![rod(0.15)]), &both_feet(), &waypoints).unwrap();
    assert!(margins.collision > 0.03 && margins.collision < 0.1, "{margins:?}");
}

#[test]
fn overlaps_up_to_the_tolerance_pass() {
    // The hanging hand ends at z = 0.9 + 0.2 - 0.4 - 0.38 = 0.32.
    let block =
        |depth: f64| ("block", at(0.0, 0.25, 0.32 + depth - 0.05), box_of(0.01, 0.01, 0.05));
    let still = [waypoint(0.0, 0.0, 0.0)];
    let margins = check_motion(robot(), world(vec![block(0.0015)]), &both_feet(), &still).unwrap();
    assert!((margins.collision + 0.0015).abs() < 1e-6, "{margins:?}");
    refused(
        check_motion(robot(), world(vec![block(0.0025)]), &both_feet(), &still),
        Check::Collision,
        "2.50 mm",
    );
}

#[test]
fn feet_may_not_penetrate_shapes_beside_their_soles() {
    // A step whose riser cuts into the shin, 0.04 m ahead of the ankle, over the toes: the sole
    // itself is on the floor.
    let step = |depth: f64| ("step", at(0.04 - depth + 0.2, -0.1, 0.4), box_of(0.2, 0.03, 0.2));
    let still = [waypoint(0.0, 0.0, 0.0)];
    check_motion(robot(), world(vec![step(0.0025)]), &both_feet(), &still).unwrap();
    refused(
        check_motion(robot(), world(vec![step(0.0035)]), &both_feet(), &still),
        Check::Collision,
        "right_leg overlaps step by 3.50 mm",
    );
    // A foot that does not carry may press less deep.
    let mut light = robot();
    light.links[2].mass = 0.1;
    light.links[0].com.y = 0.1;
    check_motion(light.clone(), world(vec![step(0.0015)]), &[contact(0)], &still).unwrap();
    refused(
        check_motion(light, world(vec![step(0.0025)]), &[contact(0)], &still),
        Check::Collision,
        "right_leg overlaps step by 2.50 mm",
    );
}

/// The robot with a fin on its upper arm, in the frame of that link.
fn robot_with_fin(x: f64, y: f64, z: f64) -> RobotModel {
    let mut finned = robot();
    let (link_from_shape, shape) = (at(x, y, z), box_of(0.02, 0.02, 0.02));
    finned.links[3].shapes.push(LinkShape { link_from_shape, shape });
    finned
}

#[test]
fn distant_links_that_overlap_in_the_standing_posture_may_overlap_as_deep_as_there() {
    // A fin on the left leg is 5 mm deep in the forearm, which the elbow turns towards it.
    let mut arched = robot();
    let (link_from_shape, shape) = (at(0.0, 0.195, -0.4), box_of(0.02, 0.02, 0.02));
    arched.links[1].shapes.push(LinkShape { link_from_shape, shape });
    // The leg hangs on the hip, the forearm on shoulder and elbow: three joints.
    let check = |robot: RobotModel, elbow: f64| {
        let motion = swing((0.0, 0.0), (0.0, elbow), 4);
        check_motion(robot, world(vec![]), &both_feet(), &motion)
    };
    check(arched.clone(), 0.1).unwrap();
    // One more joint between them.
    let mut distant = arched;
    let wrist = Joint { child: 5, name: "wrist".into(), ..distant.joints[ELBOW].clone() };
    distant.joints.push(wrist);
    distant.standing_q.push(0.0);
    let mut hand = distant.links[4].clone();
    hand.name = "hand".into();
    hand.parent = Some(Attachment { parent: 4, parent_from_joint: Pose::IDENTITY, joint: Some(4) });
    hand.mass = 0.1;
    distant.links[4].shapes.clear();
    distant.links.push(hand);
    check(distant.clone(), 0.005).unwrap();
    refused(check(distant, 0.1), Check::SelfCollision, "left_leg overlaps hand");
}

#[test]
fn neighbours_that_overlap_in_the_standing_posture_are_excused_and_named() {
    let finned = robot_with_fin(0.0, 0.045, -0.6);
    let motion = swing((0.0, 0.0), (0.0, 0.1), 4);
    check_motion(finned.clone(), world(vec![]), &both_feet(), &motion).unwrap();
    let checker = Checker::new(finned, world(vec![]), CheckerConfig::default()).unwrap();
    let named = checker.allowed_overlaps();
    assert!(named.len() == 1 && named[0].contains("upper_arm and forearm"), "{named:?}");
}

#[test]
fn neighbours_sink_into_each_other_no_deeper_than_in_walks_or_as_the_robot_file_says() {
    // A cover of the upper arm overlaps the forearm, which sinks into it as the elbow bends.
    let mut covered = robot();
    let (link_from_shape, shape) = (at(0.0, 0.225, -0.5), box_of(0.2, 0.2, 0.3));
    covered.links[3].shapes.push(LinkShape { link_from_shape, shape });
    let check = |robot: &RobotModel, elbow: f64| {
        let motion = swing((0.0, 0.0), (0.0, elbow), 13);
        check_motion(robot.clone(), world(vec![]), &both_feet(), &motion)
    };
    check(&covered, 0.59).unwrap();
    let line = "its robot file says: [[allowed_overlaps]] links = [\"upper_arm\", \"forearm\"]";
    let violation = check(&covered, 1.2).unwrap_err();
    refused(Err(violation.clone()), Check::SelfCollision, line);
    let depth: f64 = violation.detail.rsplit(' ').next().unwrap().parse().unwrap();
    assert!((0.05..0.25).contains(&depth) && !violation.detail.contains('-'), "{violation}");
    let links = ["forearm", "upper_arm"].map(String::from);
    covered.allowed_overlaps.push(AllowedOverlap { links, depth: 0.25 });
    check(&covered, 1.2).unwrap();
}

#[test]
fn a_leg_sinks_into_a_cover_no_deeper_than_in_walks() {
    // A rod of the torso touches the right leg from behind, and reaches to where the leg swings.
    let mut robot = robot_on_the_left_foot();
    let slant =
        Pose::from_parts(DVec3::new(-0.0675, -0.1, -0.005), rotation_about(DVec3::Y, -0.0555));
    let shape = Shape::Capsule { radius: 0.02, half_length: 0.496 };
    robot.joints[1].upper = 3.0;
    robot.links[0].shapes.push(LinkShape { link_from_shape: slant, shape });
    let mut checker = Checker::new(robot, world(vec![]), CheckerConfig::default()).unwrap();
    let mut self_collision = |angle: f64| {
        let swung = |i: usize| {
            let mut at = waypoint(i as f64, 0.0, 0.0);
            at.q[1] = angle + 0.01 * i as f64;
            at
        };
        let segment = MotionSegment {
            mode: SupportMode::Left,
            contacts: &[contact(0)],
            waypoints: &[swung(0), swung(1)],
            course: Course::Straight,
        };
        let violations = checker.check_all(&segment).violations;
        violations.into_iter().find(|violation| violation.check == Check::SelfCollision)
    };
    assert_eq!(self_collision(0.0), None);
    assert_eq!(self_collision(2.58), None);
    let violation = self_collision(2.9).unwrap();
    assert!(violation.detail.contains("torso overlaps right_leg by"), "{violation}");
}

#[test]
fn neighbours_that_are_clear_in_the_standing_posture_stay_clear() {
    // The forearm reaches the fin only when the elbow bends.
    let finned = robot_with_fin(0.0, 0.15, -0.35);
    let still = [waypoint(0.0, 0.0, 0.0)];
    check_motion(finned.clone(), world(vec![]), &both_feet(), &still).unwrap();
    refused(
        check_motion(finned, world(vec![]), &both_feet(), &swing((0.0, 0.0), (0.0, 2.0), 21)),
        Check::SelfCollision,
        "upper_arm overlaps forearm",
    );
}

#[test]
fn a_robot_under_an_open_roof_is_not_inside_it() {
    let corners =
        [(-2., -2., 0.), (4., -2., 0.), (4., 0., 3.), (-2., 0., 3.), (-2., 2., 0.), (4., 2., 0.)];
    let source = None;
    let roof = Shape::Mesh {
        vertices: corners.map(DVec3::from).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3], [3, 2, 5], [3, 5, 4]],
        source,
    };
    let still = [waypoint(0.0, 0.0, 0.0)];
    let under = world(vec![("roof", at(0., 0., 0.), roof)]);
    check_motion(robot(), under, &both_feet(), &still).unwrap();
}

/// A robot light enough on its right leg to stand on the left foot.
fn robot_on_the_left_foot() -> RobotModel {
    let mut light = robot();
    light.links[2].mass = 0.1;
    light.links[0].com.y = 0.1;
    light
}

#[test]
fn a_swing_foot_may_not_slide_over_the_ground() {
    // The right hip swings the foot along an arc that begins and ends on the floor or 10 cm over
    // it.
    let motion = |angle: f64, count: usize| -> Vec<Waypoint> {
        let part = |i: usize| i as f64 / (count - 1) as f64;
        let at = |i: usize| {
            let mut at = waypoint(i as f64, 0.0, 0.0);
            at.q[1] = angle * part(i);
            at
        };
        (0..count).map(at).collect()
    };
    let lowered = |height: f64| {
        let mut floor = world(vec![]);
        // Under the right foot the floor is lower.
        floor.shapes[0].world_from_shape = at(0.0, 3.0, -0.25);
        floor.shapes.push(surefoot_shared_types::world::world::WorldShape {
            name: "low".into(),
            world_from_shape: at(0.0, -3.05, -0.25 - height),
            shape: box_of(3.0, 3.0, 0.25),
        });
        floor
    };
    let check = |height: f64, angle: f64| {
        check_motion(robot_on_the_left_foot(), lowered(height), &[contact(0)], &motion(angle, 4))
    };
    check(0.05, 0.02).unwrap();
    check(0.0, 0.005).unwrap();
    refused(check(0.0, 0.02), Check::Collision, "right foot slides over the world while it swings");
}

#[test]
fn a_robot_inside_a_closed_mesh_is_refused() {
    let corner =
        |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) * 4.0 - 2.0;
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles =
        quads.iter().flat_map(|q: &[u32; 4]| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    let source = None;
    let solid = Shape::Mesh { vertices: (0..8).map(corner).collect(), triangles, source };
    let result = check_motion(
        robot(),
        world(vec![("rock", at(0., 0., 0.), solid)]),
        &both_feet(),
        &[waypoint(0.0, 0.0, 0.0)],
    );
    // The soles are probed first: they lie two metres deep.
    refused(result, Check::Contact, "deep");
}

#[test]
fn the_forearm_swung_into_the_body_is_a_self_collision() {
    let result =
        check_motion(robot(), world(vec![]), &both_feet(), &swing((0.0, 0.0), (0.0, -1.5), 11));
    let violation = refused(result, Check::SelfCollision, "forearm");
    assert!(violation.waypoint > 0);
}

#[test]
fn check_all_names_every_violated_check() {
    let mut weak = robot();
    weak.joints[SHOULDER].effort = 1.0;
    let mut checker = Checker::new(weak, world(vec![]), CheckerConfig::default()).unwrap();
    let waypoints = swing((0.9, 0.0), (0.9, -1.5), 11);
    let report = checker.check_all(&MotionSegment {
        mode: SupportMode::Double,
        contacts: &both_feet(),
        waypoints: &waypoints,
        course: Course::Straight,
    });
    let found: Vec<Check> = report.violations.iter().map(|violation| violation.check).collect();
    assert_eq!(found, [Check::Torque]);
    assert!(report.margins.balance.is_finite() && report.margins.torque == f64::INFINITY);
}

#[test]
fn nan_passes_no_check() {
    let standing = |spoil: fn(&mut Waypoint)| {
        let mut waypoint = waypoint(0.0, 0.0, 0.0);
        spoil(&mut waypoint);
        check_motion(robot(), world(vec![]), &both_feet(), &[waypoint])
    };
    refused(standing(|waypoint| waypoint.q[SHOULDER] = f64::NAN), Check::Limits, "shoulder");
    refused(standing(|waypoint| waypoint.root_position[2] = f64::NAN), Check::Contact, "left sole");
    refused(
        standing(|waypoint| waypoint.root_rotation = [f64::NAN; 4]),
        Check::Contact,
        "left sole",
    );
    let mut swing = swing((0.0, 0.0), (0.1, 0.0), 3);
    swing[1].time = f64::NAN;
    refused(check_motion(robot(), world(vec![]), &both_feet(), &swing), Check::Spacing, "time");
    let mut contacts = both_feet();
    contacts[1].position[0] = f64::NAN;
    refused(
        check_motion(robot(), world(vec![]), &contacts, &[waypoint(0.0, 0.0, 0.0)]),
        Check::Contact,
        "right sole",
    );
}

#[test]
fn links_with_a_nan_pose_collide() {
    let mut lost = waypoint(0.0, 0.0, 0.0);
    lost.q[SHOULDER] = f64::NAN;
    let mut checker = Checker::new(robot(), world(vec![]), CheckerConfig::default()).unwrap();
    let report = checker.check_all(&MotionSegment {
        mode: SupportMode::Double,
        contacts: &both_feet(),
        waypoints: &[lost],
        course: Course::Straight,
    });
    let checks: Vec<Check> = report.violations.iter().map(|violation| violation.check).collect();
    assert!(
        checks.contains(&Check::Collision) && checks.contains(&Check::SelfCollision),
        "{:?}",
        report.violations
    );
}

#[test]
fn a_check_calls_the_heartbeat_at_every_waypoint() {
    let waypoints = swing((0.0, 0.0), (0.3, 0.0), 8);
    let mut checker = Checker::new(robot(), world(vec![]), CheckerConfig::default()).unwrap();
    let mut signs = 0;
    let segment = MotionSegment {
        mode: SupportMode::Double,
        contacts: &both_feet(),
        waypoints: &waypoints,
        course: Course::Straight,
    };
    checker.check_segment(&segment, &mut || signs += 1).unwrap();
    // Torque, collision and self-collision.
    assert!(signs >= 3 * waypoints.len(), "{signs}");
}

#[test]
fn robots_that_cannot_be_checked_are_refused() {
    let mut one_legged = robot();
    one_legged.feet.pop();
    assert!(matches!(
        Checker::new(one_legged, world(vec![]), CheckerConfig::default()),
        Err(CheckerError::NotABiped { feet: 1 })
    ));
    let mut giant = robot();
    giant.feet[0].polygon[0].x = -0.11;
    assert!(matches!(
        Checker::new(giant, world(vec![]), CheckerConfig::default()),
        Err(CheckerError::SoleOffFoot { .. })
    ));
}

#[test]
fn starts_stops_and_turns_are_accelerations() {
    let mut checker = Checker::new(robot(), world(vec![]), CheckerConfig::default()).unwrap();
    let mut unused = |waypoints: &[Waypoint]| {
        checker
            .check_all(&MotionSegment {
                mode: SupportMode::Double,
                contacts: &both_feet(),
                waypoints,
                course: Course::Straight,
            })
            .acceleration
    };
    // From rest to rest over 0.1 rad within a second takes 0.4 rad/s2, of a limit of 10 rad/s2.
    let needs = |unused: f64, share: f64| ((1.0 - unused) / share - 1.0).abs() < 0.02;
    assert!(needs(unused(&[waypoint(0.0, 0.0, 0.0), waypoint(1.0, 0.1, 0.0)]), 0.04));
    // There and back over 12.5 mrad, 0.1 s each way, takes 5 rad/s2.
    let turn = [waypoint(0.0, 0.0, 0.0), waypoint(0.1, 0.0125, 0.0), waypoint(0.2, 0.0, 0.0)];
    assert!(needs(unused(&turn), 0.5));
    // A wait before and one after a move give it no more than the travel back, 1 mrad each.
    let wait = [
        waypoint(0.0, 0.0, 0.0),
        waypoint(2.0, 0.0, 0.0),
        waypoint(2.1, 0.0125, 0.0),
        waypoint(4.1, 0.0125, 0.0),
    ];
    let share = 1.0 - unused(&wait);
    assert!(share > 0.2 && share < 0.505, "{share}");
    assert_eq!(unused(&[waypoint(0.0, 0.3, 0.0)]), 1.0);
    // Half the time is four times the acceleration.
    let quicker = turn.map(|waypoint| Waypoint { time: 0.5 * waypoint.time, ..waypoint });
    refused(
        check_motion(robot(), world(vec![]), &both_feet(), &quicker),
        Check::Acceleration,
        "joint shoulder has to accelerate by 20",
    );
}

#[test]
fn a_motion_that_does_not_stop_at_its_end_is_refused() {
    // Gently up to 1.4 rad/s, and then no further waypoint.
    let times_and_angles = [(0.0, 0.0), (0.4, 0.1), (0.6, 0.2), (0.75, 0.29), (0.8, 0.36)];
    let waypoints = times_and_angles.map(|(time, shoulder)| waypoint(time, shoulder, 0.0));
    let violation = refused(
        check_motion(robot(), world(vec![]), &both_feet(), &waypoints),
        Check::Acceleration,
        "shoulder",
    );
    assert_eq!(violation.waypoint, 4);
    let whole = check_motion(
        robot(),
        world(vec![]),
        &both_feet(),
        &[&waypoints[..], &[waypoint(1.2, 0.45, 0.0)]].concat(),
    );
    assert!(whole.is_ok(), "{whole:?}");
}
