//! Each limit of the physical checks on both sides, and the numbers in the messages of refusals.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

mod check_robot;

use check_robot::*;
use glam::{DQuat, DVec3};
use surefoot_controller_sim::{Checker, Course, MotionSegment, SegmentReport, Violation};
use surefoot_shared_types::base::spatial::rotation_about;
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::{Check, Contact, Margins, SupportMode, Waypoint};
use surefoot_shared_types::robot::model::{JointKind, LinkShape, RobotModel};
use surefoot_shared_types::world::world::{GRAVITY, World, WorldShape};
use surefoot_shared_types::{Pose, Shape};

fn checker(robot: RobotModel, world: World) -> Checker {
    Checker::new(robot, world, CheckerConfig::default()).unwrap()
}

fn double<'a>(
    contacts: &'a [Contact],
    waypoints: &'a [Waypoint],
    course: Course<'a>,
) -> MotionSegment<'a> {
    let mode = if contacts.len() == 1 { SupportMode::Left } else { SupportMode::Double };
    MotionSegment { mode, contacts, waypoints, course }
}

fn check_in(robot: RobotModel, world: World, waypoints: &[Waypoint]) -> Result<Margins, Violation> {
    let feet = both_feet();
    checker(robot, world).check_segment(&double(&feet, waypoints, Course::Straight), &mut || {})
}

fn check(robot: RobotModel, waypoints: &[Waypoint]) -> Result<Margins, Violation> {
    check_in(robot, world(vec![]), waypoints)
}

fn report(robot: RobotModel, world: World, waypoints: &[Waypoint]) -> SegmentReport {
    let feet = both_feet();
    checker(robot, world).check_all(&double(&feet, waypoints, Course::Straight))
}

/// The violation, with its numbers in their order.
fn refusal(result: Result<Margins, Violation>, check: Check) -> (Violation, Vec<f64>) {
    let violation = result.expect_err("must be refused");
    assert_eq!(violation.check, check, "{violation}");
    let is_part = |symbol: char| symbol.is_ascii_digit() || symbol == '.' || symbol == '-';
    let words = violation.detail.split(|symbol| !is_part(symbol));
    let numbers = words.filter_map(|word| word.trim_end_matches('.').parse().ok()).collect();
    (violation, numbers)
}

fn assert_near(found: &[f64], expected: &[f64], tolerance: f64) {
    let is_near = |(a, b): (&f64, &f64)| (a - b).abs() <= tolerance;
    let are_near = found.len() == expected.len() && found.iter().zip(expected).all(is_near);
    assert!(are_near, "{found:?} instead of {expected:?}");
}

fn still() -> Vec<Waypoint> {
    swing((0.0, 0.0), (0.0, 0.0), 2)
}

#[test]
fn a_joint_may_stand_at_its_limit_and_move_as_far_and_as_fast_as_allowed() {
    let margins = check(robot(), &swing((2.4, 0.0), (2.5, 0.0), 2)).unwrap();
    assert!(margins.limits.abs() < 1e-9, "{margins:?}");
    check(robot(), &swing((0.0, 0.0), (0.2, 0.0), 2)).unwrap();
    let mut slow = robot();
    slow.joints[SHOULDER].velocity = 0.1;
    let mut waypoints = swing((0.0, 0.0), (0.1, 0.0), 2);
    waypoints.iter_mut().for_each(|waypoint| waypoint.time += 10.0);
    check(slow.clone(), &waypoints).unwrap();
    waypoints[1].time = 10.5;
    let (_, numbers) = refusal(check(slow, &waypoints), Check::Spacing);
    assert_near(&numbers, &[0.2, 0.1], 1e-9);
    let (_, numbers) = refusal(check(robot(), &swing((0.0, 0.0), (0.25, 0.0), 2)), Check::Spacing);
    assert_near(&numbers, &[0.25, 0.2], 1e-9);
}

#[test]
fn the_root_may_move_and_turn_as_far_as_allowed() {
    // The soles do not follow, which is checked later.
    let moved = |distance: f64, turn: f64| {
        let mut waypoints = still();
        waypoints[1].root_position[0] += distance;
        waypoints[1].root_rotation = rotation_about(DVec3::Z, turn).to_array();
        check(robot(), &waypoints)
    };
    for (distance, turn) in [(0.1, 0.0), (0.0, 0.2)] {
        refusal(moved(distance, turn), Check::Contact);
    }
    let (_, numbers) = refusal(moved(0.101, 0.0), Check::Spacing);
    assert_near(&numbers, &[0.101, 0.1], 1e-9);
    let (_, numbers) = refusal(moved(0.0, 0.201), Check::Spacing);
    assert_near(&numbers, &[0.201, 0.2], 1e-9);
}

#[test]
fn a_joint_of_a_smooth_motion_may_be_as_fast_and_accelerate_as_much_as_its_limit() {
    let at = |speed: f64, acceleration: f64| {
        let mut robot = robot();
        (robot.joints[SHOULDER].velocity, robot.joints[SHOULDER].stated_acceleration) =
            (0.5, Some(3.0));
        let mut instant = waypoint(0.0, 0.0, 0.0);
        instant.joint_velocity[SHOULDER] = speed;
        instant.joint_acceleration[SHOULDER] = acceleration;
        checker(robot, world(vec![])).check_instant(&both_feet(), &instant)
    };
    at(0.5, 0.0).unwrap();
    at(-0.5, 3.0).unwrap();
    let (_, numbers) = refusal(at(-0.51, 0.0), Check::Spacing);
    assert_near(&numbers, &[-0.51, 0.5], 1e-9);
    let (_, numbers) = refusal(at(0.0, 3.01), Check::Acceleration);
    assert_near(&numbers, &[3.01, 3.0], 1e-9);
}

#[test]
fn what_a_joint_leaves_of_its_acceleration_is_reported() {
    let mut robot = robot();
    robot.joints[SHOULDER].stated_acceleration = Some(4.0);
    let mut waypoints = still();
    waypoints[0].joint_acceleration[SHOULDER] = 1.0;
    waypoints[1].joint_acceleration[SHOULDER] = 1.0;
    let feet = both_feet();
    let segment = double(&feet, &waypoints, Course::Smooth(&[]));
    let found = checker(robot, world(vec![])).check_all(&segment).acceleration;
    assert!((found - 0.75).abs() < 1e-9, "{found}");
}

#[test]
fn accelerations_of_straight_lines_may_reach_their_limit() {
    // There and back over 24.95 mrad, 0.1 s each way, takes 9.98 of 10 rad/s2: the limit is tried
    // before anything below it by less than a hundredth.
    let turn =
        |angle: f64| [waypoint(0.0, 0.0, 0.0), waypoint(0.1, angle, 0.0), waypoint(0.2, 0.0, 0.0)];
    assert_eq!(report(robot(), world(vec![]), &turn(0.02495)).acceleration, 0.0);
    let (violation, _) = refusal(check(robot(), &turn(0.0252)), Check::Acceleration);
    assert_eq!(violation.waypoint, 2);
    let scale = checker(robot(), world(vec![])).time_scale_min(&turn(0.05));
    assert!((scale - 2.0_f64.sqrt()).abs() < 0.01, "{scale}");
    assert_eq!(checker(robot(), world(vec![])).time_scale_min(&turn(0.01)), 1.0);
    // The joint that needs more of its limit counts, whichever comes first.
    let mut quick = turn(0.0252);
    quick[1].q[ELBOW] = 0.012;
    let mut robot = robot();
    robot.joints[SHOULDER].stated_acceleration = Some(11.0);
    robot.joints[ELBOW].stated_acceleration = Some(4.0);
    let (violation, numbers) = refusal(check(robot, &quick), Check::Acceleration);
    assert!(violation.detail.contains("elbow"), "{violation}");
    assert_near(&numbers, &[4.8, 4.0], 0.05);
}

#[test]
fn refused_soles_are_measured_in_millimetres_and_degrees() {
    let on_floor_at = |z: f64| {
        let mut moved = world(vec![]);
        moved.shapes[0].world_from_shape = at(0.0, 0.0, z - 0.25);
        check_in(robot(), moved, &still())
    };
    let (_, numbers) = refusal(on_floor_at(0.004), Check::Contact);
    assert_near(&numbers, &[4.0, 3.0], 1e-9);
    let (_, numbers) = refusal(on_floor_at(-0.0031), Check::Contact);
    assert_near(&numbers, &[3.1, 3.0], 1e-9);
    let declared = |change: &dyn Fn(&mut Contact)| {
        let mut feet = both_feet();
        change(&mut feet[1]);
        let motion = still();
        checker(robot(), world(vec![]))
            .check_segment(&double(&feet, &motion, Course::Straight), &mut || {})
    };
    let (_, numbers) = refusal(declared(&|foot| foot.position[0] = 0.0021), Check::Contact);
    assert_near(&numbers, &[2.1, 2.0], 1e-9);
    let turned = |foot: &mut Contact, degrees: f64| {
        foot.rotation = rotation_about(DVec3::Z, degrees.to_radians()).to_array();
    };
    let (_, numbers) = refusal(declared(&|foot| turned(foot, 0.3)), Check::Contact);
    assert_near(&numbers, &[0.3, 0.2], 1e-9);
    declared(&|foot| turned(foot, 0.19)).unwrap();
    let margin = declared(&|foot| foot.position[0] = 0.0005).unwrap().contact;
    assert!((margin - 0.0015).abs() < 1e-9, "{margin}");
    // 5 mm of the soles, 10 cm wide, lie over the floor; what a foot beside its place may miss
    // does not count.
    let mut edge = world(vec![]);
    edge.shapes[0].world_from_shape = at(3.095, 0.0, -0.25);
    let (_, numbers) = refusal(check_in(robot(), edge, &still()), Check::Contact);
    assert!(numbers[0] > 1.0 && numbers[0] < 5.0 && numbers[2] == 5.0, "{numbers:?}");
}

#[test]
fn a_foot_beside_its_declared_place_takes_its_distance_from_the_balance() {
    let balance = |ahead: f64| {
        let mut feet = both_feet();
        feet.iter_mut().for_each(|foot| foot.position[1] += ahead);
        let motion = still();
        let segment = double(&feet, &motion, Course::Straight);
        checker(robot(), world(vec![])).check_segment(&segment, &mut || {}).unwrap().balance
    };
    // Beside the robot the edge is further away than in front of it.
    let lost = balance(0.0) - balance(1e-3);
    assert!((lost - 1e-3).abs() < 1e-6, "{lost}");
}

#[test]
fn a_robot_out_of_balance_is_measured_in_millimetres() {
    let mut heavy = robot();
    heavy.links[4].mass = 30.0;
    let result = check(heavy, &swing((0.0, 0.0), (1.2, 0.0), 13));
    let (violation, numbers) = refusal(result, Check::Balance);
    assert!(violation.detail.contains("left and right foot"), "{violation}");
    // It leans by little more than the margin in the first sample that is refused.
    assert!(numbers[0] > 0.0 && numbers[0] < 5.0 && numbers[1] == 5.0, "{numbers:?}");
}

#[test]
fn the_unused_friction_is_counted_in_sixteenths() {
    let slope = |angle: f64, mu: f64| {
        let mut slope = world(vec![]);
        let turn = rotation_about(DVec3::Y, angle);
        slope.shapes[0].world_from_shape =
            Pose::from_parts(turn * DVec3::new(0.0, 0.0, -0.25), turn);
        slope.mu = mu;
        report(robot(), slope, &still()).reserves.friction
    };
    assert_eq!(slope(0.0, 0.6), 1.0 - 1.0 / 16.0);
    // A tangent of 0.002 is a fifth of the friction, more than three sixteenths.
    assert_eq!(slope(0.002, 0.01), 1.0 - 4.0 / 16.0);
    assert_eq!(slope(0.002, 0.004), 1.0 - 9.0 / 16.0);
}

#[test]
fn a_joint_may_need_all_of_its_effort_that_may_be_used() {
    let level = -std::f64::consts::FRAC_PI_2;
    let with_effort = |effort: f64| {
        let mut weak = robot();
        weak.joints[SHOULDER].effort = effort;
        report(weak, world(vec![]), &swing((level, 0.0), (level, 0.0), 2))
    };
    let needed = 1.6 * GRAVITY;
    let report = with_effort(needed / 0.95);
    assert_eq!(report.violations, []);
    assert!((report.margins.torque - 0.05).abs() < 1e-9, "{report:?}");
    assert!((report.reserves.least_squares_torque - 0.05).abs() < 1e-9, "{report:?}");
    let [violation] = &with_effort(15.0).violations[..] else { panic!("one check is violated") };
    let said = "joint shoulder needs 15.70 N m or N, limit 14.25, 95 % of 15.00";
    assert_eq!(violation.detail, said);
    assert!((with_effort(8.0).reserves.least_squares_torque - (1.0 - needed / 8.0)).abs() < 1e-9);
}

#[test]
fn the_same_share_of_the_effort_is_for_moving() {
    let with_effort = |effort: f64| {
        let mut weak = robot();
        weak.joints[SHOULDER].effort = effort;
        let level = waypoint(0.0, -std::f64::consts::FRAC_PI_2, 0.0);
        checker(weak, world(vec![])).check_instant(&both_feet(), &level)
    };
    let needed = 1.6 * GRAVITY;
    let margins = with_effort(needed / 0.95).unwrap();
    assert!((margins.dynamic_torque - 0.05).abs() < 1e-6, "{margins:?}");
    refusal(with_effort(0.9999 * needed / 0.95), Check::DynamicTorque);
}

#[test]
fn links_with_mass_and_without_a_shape_are_named() {
    let mut bare = robot();
    bare.links[4].shapes.clear();
    bare.links[3].shapes.clear();
    bare.links[3].mass = 0.0;
    let checker = checker(bare, world(vec![]));
    let named: Vec<String> = checker.unshaped_links().collect();
    assert_eq!(named, ["forearm (2.00 kg)"]);
}

/// A pose that moves and turns everything.
fn elsewhere() -> Pose {
    Pose::from_parts(DVec3::new(3.0, -2.0, 5.0), rotation_about(DVec3::Z, 1.0))
}

fn moved_waypoint(pose: &Pose, waypoint: &Waypoint) -> Waypoint {
    let root = *pose * waypoint.world_from_root();
    let turned = |rates: [f64; 6]| {
        let [linear, angular] =
            [0, 3].map(|first| pose.rotation * DVec3::from_slice(&rates[first..]));
        [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
    };
    Waypoint {
        root_position: root.translation.to_array(),
        root_rotation: root.rotation.normalize().to_array(),
        root_velocity: turned(waypoint.root_velocity),
        root_acceleration: turned(waypoint.root_acceleration),
        ..*waypoint
    }
}

fn moved_contact(pose: &Pose, contact: &Contact) -> Contact {
    let sole = *pose * contact.world_from_sole();
    let rotation = DQuat::normalize(sole.rotation).to_array();
    Contact { position: sole.translation.to_array(), rotation, ..*contact }
}

#[test]
fn margins_do_not_depend_on_where_the_robot_stands_and_where_it_looks() {
    let block = |x: f64, y: f64| ("block", at(x, y, 0.3), box_of(0.05, 0.05, 0.05));
    let here = world(vec![block(0.3, 0.3), block(-0.2, 0.25)]);
    let mut there = here.clone();
    for shape in &mut there.shapes {
        shape.world_from_shape = elsewhere() * shape.world_from_shape;
    }
    let feet = both_feet();
    let feet_there = feet.map(|contact| moved_contact(&elsewhere(), &contact));
    for course in [Course::Straight, Course::Smooth(&[])] {
        let mut motion = swing((0.0, 0.0), (-0.4, 0.3), 4);
        if course != Course::Straight {
            // It begins and ends in motion.
            motion.iter_mut().for_each(|waypoint| {
                waypoint.joint_velocity[SHOULDER] = -0.4 / 3.0;
                waypoint.joint_velocity[ELBOW] = 0.1;
                waypoint.joint_acceleration[ELBOW] = 0.2;
            });
        }
        let motion_there: Vec<Waypoint> =
            motion.iter().map(|waypoint| moved_waypoint(&elsewhere(), waypoint)).collect();
        let found = checker(robot(), here.clone()).check_all(&double(&feet, &motion, course));
        let segment = double(&feet_there, &motion_there, course);
        let found_there = checker(robot(), there.clone()).check_all(&segment);
        assert_eq!(found.violations, []);
        assert_eq!(found_there.violations, []);
        let numbers = |Margins {
                           limits,
                           contact,
                           balance,
                           collision,
                           self_collision,
                           torque,
                           zero_moment,
                           dynamic_torque,
                       }: Margins| {
            [
                limits,
                contact,
                balance,
                collision,
                self_collision,
                torque,
                zero_moment,
                dynamic_torque,
            ]
        };
        for (a, b) in numbers(found.margins).into_iter().zip(numbers(found_there.margins)) {
            assert!(a == b || (a - b).abs() < 1e-6, "{found:?} {found_there:?}");
        }
    }
}

#[test]
fn a_swing_foot_slides_with_its_own_shapes() {
    // A spur beside the right foot reaches the floor, which is lower there than under the left one.
    let mut spurred = robot();
    spurred.links[2].mass = 0.1;
    spurred.links[0].com.y = 0.1;
    let spur =
        LinkShape { link_from_shape: at(0.0, -0.065, -0.91), shape: box_of(0.01, 0.01, 0.01) };
    spurred.links[2].shapes.push(spur);
    let mut floor = world(vec![]);
    floor.shapes[0].world_from_shape = at(0.0, 3.0, -0.25);
    floor.shapes.push(WorldShape {
        name: "low".into(),
        world_from_shape: at(0.0, -3.05, -0.27),
        shape: box_of(3.0, 3.0, 0.25),
    });
    let swung = |i: usize| {
        let mut at = waypoint(i as f64, 0.0, 0.0);
        at.q[1] = 0.005 * i as f64;
        at
    };
    let motion: Vec<Waypoint> = (0..4).map(swung).collect();
    let feet = [contact(0)];
    let result = checker(spurred, floor)
        .check_segment(&double(&feet, &motion, Course::Straight), &mut || {});
    let (violation, numbers) = refusal(result, Check::Collision);
    assert!(violation.detail.contains("right foot slides"), "{violation}");
    assert_near(&numbers, &[9.0, 0.57, 6.0, 1.43], 0.05);
}

/// The depths in the lines about two bodies: the limit and that in the standing posture, mm.
fn allowed(robot: &RobotModel) -> Vec<f64> {
    let checker = checker(robot.clone(), world(vec![]));
    let [line] = checker.allowed_overlaps() else {
        panic!("one pair overlaps: {:?}", checker.allowed_overlaps())
    };
    let words = line.split_whitespace();
    words.filter_map(|word| word.parse().ok()).collect()
}

#[test]
fn near_links_may_overlap_as_deep_as_in_any_of_seven_positions_of_each_joint() {
    // A ball at the end of the forearm sinks into a large slanted block of the torso.
    let mut covered = robot();
    let ball = DVec3::new(0.0, 0.0, -0.3);
    covered.links[4].shapes = vec![LinkShape {
        link_from_shape: Pose::from_translation(ball),
        shape: Shape::Sphere { radius: 0.05 },
    }];
    covered.links[3].shapes.clear();
    let slant = rotation_about(DVec3::new(2.0, -1.0, 0.0).normalize(), 1.1);
    let middle = slant * DVec3::new(0.0, 0.0, -2.0) + DVec3::new(0.0, 0.25, -0.53);
    covered.links[0].shapes = vec![LinkShape {
        link_from_shape: Pose::from_parts(middle, slant),
        shape: box_of(2.0, 2.0, 2.0),
    }];
    let depth = |shoulder: f64, elbow: f64| {
        let shoulder =
            Pose::from_parts(DVec3::new(0., 0.25, 0.2), rotation_about(DVec3::Y, shoulder));
        let elbow = Pose::from_parts(DVec3::new(0., 0., -0.4), rotation_about(DVec3::X, elbow));
        let centre = shoulder * elbow * ball;
        let height = (slant.inverse() * (centre - middle)).z - 2.0;
        1e3 * (0.05 - height)
    };
    covered.joints[SHOULDER].lower = -0.25;
    covered.joints[ELBOW].upper = 0.4;
    let part = |from: f64, to: f64, index: usize| from + (to - from) * index as f64 / 6.0;
    let grid =
        (0..49).map(|index| depth(part(-0.25, 0.65, index % 7), part(-0.65, 0.4, index / 7)));
    let deepest = grid.fold(0.0, f64::max);
    let found = pair_depths(&covered, "torso and forearm");
    assert!((found[0] - deepest).abs() < 0.06, "{found:?} {deepest}");
    assert!((found[1] - depth(0.0, 0.0)).abs() < 0.06, "{found:?}");
    assert!(deepest > depth(0.0, 0.0) + 20.0, "the postures matter");
}

/// The numbers of the line about a pair.
fn pair_depths(robot: &RobotModel, pair: &str) -> Vec<f64> {
    let checker = checker(robot.clone(), world(vec![]));
    let lines = checker.allowed_overlaps();
    let line = lines.iter().find(|line| line.contains(pair)).unwrap_or_else(|| panic!("{lines:?}"));
    line.split_whitespace().filter_map(|word| word.parse().ok()).collect()
}

#[test]
fn links_beside_a_prismatic_joint_are_measured_over_its_range() {
    let mut sliding = robot();
    sliding.joints[ELBOW].kind = JointKind::Prismatic;
    sliding.joints[ELBOW].axis = DVec3::Z;
    (sliding.joints[ELBOW].lower, sliding.joints[ELBOW].upper) = (-0.1, 0.03);
    // The upper arm ends 0.02 m over the elbow, the forearm begins 0.02 m below it.
    let sleeve = LinkShape { link_from_shape: at(0., 0., -0.4), shape: box_of(0.1, 0.1, 0.03) };
    sliding.links[3].shapes = vec![sleeve];
    assert_near(&allowed(&sliding), &[40.0, 10.0], 0.06);
}

#[test]
fn a_rod_that_is_met_soon_after_a_waypoint_and_left_behind_at_once_is_found() {
    // The hand is clear of the rod by 5 mm at the first waypoint, 2.5 cm later 4 mm deep in it,
    // and 2.5 cm clear in the middle of the step.
    let rod = |x: f64, z: f64| {
        ("rod", at(x, 0.25, z), Shape::Capsule { radius: 0.005, half_length: 0.0 })
    };
    let step = swing((0.0, 0.0), (0.2, 0.0), 2);
    let height = 1.1 - 0.75 * libm::cos(0.0333);
    let met = check_in(robot(), world(vec![rod(-0.025, height - 0.031)]), &step);
    let (violation, _) = refusal(met, Check::Collision);
    assert!(violation.detail.contains("forearm overlaps rod"), "{violation}");
    check_in(robot(), world(vec![rod(-0.025, height - 0.036)]), &step).unwrap();
    check_in(robot(), world(vec![rod(0.03, height - 0.031)]), &step).unwrap();
}

#[test]
fn the_air_under_a_sole_and_its_displacement_are_one_budget() {
    let mut lower = world(vec![]);
    lower.shapes[0].world_from_shape = at(0.0, 0.0, -0.2516);
    let mut feet = both_feet();
    feet[1].position[0] = 1.5e-3;
    let motion = still();
    let result = checker(robot(), lower)
        .check_segment(&double(&feet, &motion, Course::Straight), &mut || {});
    let (_, numbers) = refusal(result, Check::Contact);
    assert_near(&numbers, &[3.1, 3.0], 1e-9);
}

#[test]
fn a_violation_on_a_curve_names_the_received_waypoint_before_it() {
    let motion = swing((2.3, 0.0), (2.51, 0.0), 3);
    let feet = both_feet();
    let result = checker(robot(), world(vec![]))
        .check_segment(&double(&feet, &motion, Course::Smooth(&[])), &mut || {});
    let (violation, _) = refusal(result, Check::Limits);
    assert_eq!(violation.waypoint, 1);
}

#[test]
fn a_margin_is_no_larger_than_the_least_distance_between_the_measured_instants() {
    // The edge of a forearm passes 2 mm above that of a bar, at no instant that is measured.
    let edged = (at(0., 0., -0.2), rotation_about(DVec3::Y, std::f64::consts::FRAC_PI_4));
    let mut model = robot();
    let link_from_shape = Pose::from_parts(edged.0.translation, edged.1);
    model.links[4].shapes = vec![LinkShape { link_from_shape, shape: box_of(0.02, 0.04, 0.02) }];
    let half_diagonal = 0.02 * 2.0_f64.sqrt();
    let lowest = 0.9 + 0.2 - 0.4 - 0.2 - half_diagonal;
    let place = DVec3::new(0.0, 0.25, lowest - 2e-3 - half_diagonal);
    let bar = ("bar", Pose::from_parts(place, edged.1), box_of(0.02, 0.04, 0.02));
    for end in [0.31, 0.37, 0.41] {
        let motion = swing((-0.3, 0.0), (end, 0.0), 8);
        let margins = check_in(model.clone(), world(vec![bar.clone()]), &motion).unwrap();
        assert!((1.4e-3..=2e-3 + 1e-9).contains(&margins.collision), "{margins:?}");
    }
}
