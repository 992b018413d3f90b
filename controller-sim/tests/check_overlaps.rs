//! Collision with the world and self-collision against cases computed by hand.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

mod check_robot;
mod checked_motion;

use check_robot::*;
use checked_motion::{check_motion, refused};
use glam::DVec3;
use surefoot_controller_sim::{Checker, Course, MotionSegment};
use surefoot_shared_types::base::spatial::rotation_about;
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::{Check, SupportMode, Waypoint};
use surefoot_shared_types::robot::model::{
    AllowedOverlap, Attachment, Joint, LinkShape, RobotModel,
};
use surefoot_shared_types::{Pose, Shape};

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
fn a_hand_stays_out_of_the_world() {
    // The hanging hand ends at z = 0.9 + 0.2 - 0.4 - 0.38 = 0.32.
    let block =
        |depth: f64| ("block", at(0.0, 0.25, 0.32 + depth - 0.05), box_of(0.01, 0.01, 0.05));
    let still = [waypoint(0.0, 0.0, 0.0)];
    let on = |depth: f64| check_motion(robot(), world(vec![block(depth)]), &both_feet(), &still);
    let margins = on(-1e-4).unwrap();
    assert!((margins.collision - 1e-4).abs() < 1e-6, "{margins:?}");
    on(5e-7).unwrap();
    refused(on(1e-4), Check::Collision, "forearm overlaps block by 0.10 mm, limit 0.00 mm");
    refused(on(0.0025), Check::Collision, "2.50 mm");
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
fn allowed_overlaps_without_effect_are_named_with_the_reason() {
    let mut covered = robot();
    let (link_from_shape, shape) = (at(0.0, 0.225, -0.5), box_of(0.2, 0.2, 0.3));
    covered.links[3].shapes.push(LinkShape { link_from_shape, shape });
    let idle = |links: [&str; 2], depth: f64| {
        let mut model = covered.clone();
        model.allowed_overlaps = vec![AllowedOverlap { links: links.map(String::from), depth }];
        let checker = Checker::new(model, world(vec![]), CheckerConfig::default()).unwrap();
        checker.idle_overlaps().join("\n")
    };
    assert_eq!(idle(["forearm", "upper_arm"], 0.25), "");
    let said = |links, depth, reason: &str| {
        let line = idle(links, depth);
        let [a, b] = links;
        let begin = format!("[[allowed_overlaps]] of {a} and {b} has no effect: ");
        assert!(line.starts_with(&begin) && line.contains(reason), "{line}");
    };
    said(["upper_arm", "forearm"], 0.001, "mm without it");
    said(["left_leg", "right_leg"], 0.1, "they are clear of each other");
    // A cover of the left leg lies in the hand, which hangs on shoulder, elbow and wrist.
    let wrist = Joint { child: 5, name: "wrist".into(), ..covered.joints[ELBOW].clone() };
    covered.joints.push(wrist);
    covered.standing_q.push(0.0);
    let mut hand = covered.links[4].clone();
    hand.name = "hand".into();
    hand.parent = Some(Attachment { parent: 4, parent_from_joint: Pose::IDENTITY, joint: Some(4) });
    covered.links.push(hand);
    covered.links[4].shapes.clear();
    let (link_from_shape, shape) = (at(0.0, 0.195, -0.4), box_of(0.02, 0.02, 0.02));
    covered.links[1].shapes.push(LinkShape { link_from_shape, shape });
    let far = |links: [&str; 2]| {
        let mut model = covered.clone();
        model.allowed_overlaps =
            vec![AllowedOverlap { links: links.map(String::from), depth: 0.1 }];
        let checker = Checker::new(model, world(vec![]), CheckerConfig::default()).unwrap();
        checker.idle_overlaps().join("\n")
    };
    assert!(far(["hand", "left_leg"]).ends_with("4 joints lie between them, and at most 3 may"));
    assert!(far(["forearm", "upper_arm"]).ends_with("one of them has no collision shape"));
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
