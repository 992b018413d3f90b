//! The dynamic checks of smooth motions: an arm that swings along polynomials of degree 5.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

mod check_robot;
mod checked_motion;
mod smooth_swing;

use bytemuck::Zeroable;
use check_robot::*;
use checked_motion::refused;
use smooth_swing::{check, check_with, smooth_swing};
use surefoot_controller_sim::{
    Checker, ChunkExecutor, ChunkWalk, Course, Identity, LateChunks, LateWalk, MotionSegment, Pace,
    PlanClock, Stop, walk_late,
};
use surefoot_shared_types::Shape;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::chunk::{CHUNK_SCHEMA, FLAG_FIRST, FLAG_LAST};
use surefoot_shared_types::message::{
    Check, Feedback, Interpolation, PlanChunk, RestState, SupportMode, WalkRecord, Waypoint,
    WithCrc,
};
use surefoot_shared_types::robot::model::ACCELERATION_DEFAULT;
use surefoot_shared_types::world::world::{GRAVITY, World};

#[test]
fn a_gentle_swing_is_accepted_with_the_margins_computed_by_hand() {
    let still = check(&smooth_swing(0.0, 1.0, 6), &[]).unwrap();
    let margins = check(&smooth_swing(0.3, 1.0, 6), &[]).unwrap();
    // At rest the zero-moment point is the centre of mass.
    assert!((still.zero_moment - still.balance).abs() < 1e-9, "{still:?}");
    // The arm has 2 (0.2^2 + 0.6^2) + 2 kg m2 about the shoulder and accelerates by up to
    // 0.3 x 5.774 rad/s2; its centre of mass lies 0.4 m below the shoulder, which is 1.1 m high.
    let inertia = 2.0 * (0.2 * 0.2 + 0.6 * 0.6) + 2.0;
    let acceleration = 0.3 * 5.7735;
    let weight = 34.0 * GRAVITY;
    let about_ground = (inertia - 4.0 * 0.4 * 1.1) * acceleration;
    let shift = f64::abs(about_ground) / weight;
    let lost = still.zero_moment - margins.zero_moment;
    assert!(lost > shift && lost < shift + 0.015, "{lost} {shift}");
    // The shoulder also carries up to 2 (0.2 + 0.6) g sin(0.3) of 200 N m.
    let (least, most) = (inertia * acceleration / 200.0, (inertia * acceleration + 4.7) / 200.0);
    let share = 1.0 - margins.dynamic_torque;
    assert!(share >= least && share <= most + 0.05, "{share} {least} {most}");
}

#[test]
fn a_swing_that_tips_the_robot_over_is_refused() {
    refused(check(&smooth_swing(0.3, 0.2, 6), &[]), Check::ZeroMoment, "too fast");
}

#[test]
fn a_joint_that_is_too_weak_for_the_acceleration_is_refused() {
    let mut weak = robot();
    weak.joints[SHOULDER].effort = 9.0;
    let motion = smooth_swing(0.3, 0.7, 6);
    assert!(check_with(weak.clone(), world(vec![]), &smooth_swing(0.3, 3.0, 6), &[]).is_ok());
    refused(check_with(weak, world(vec![]), &motion, &[]), Check::DynamicTorque, "shoulder");
}

#[test]
fn forces_beyond_friction_are_refused() {
    let icy = World { mu: 0.01, ..world(vec![]) };
    let motion = smooth_swing(0.3, 1.0, 6);
    refused(check_with(robot(), icy, &motion, &[]), Check::DynamicTorque, "friction");
}

#[test]
fn speeds_and_stated_accelerations_between_waypoints_are_refused() {
    // The shoulder's speed reaches 0.5625 rad/s and its acceleration 1.732 rad/s2.
    let motion = smooth_swing(0.3, 1.0, 5);
    let limited = |velocity: f64, acceleration: f64| {
        let mut limited = robot();
        limited.joints[SHOULDER].velocity = velocity;
        limited.joints[SHOULDER].stated_acceleration = Some(acceleration);
        check_with(limited, world(vec![]), &motion, &[])
    };
    assert!(limited(0.57, 1.74).is_ok());
    refused(limited(0.555, 1.74), Check::Spacing, "shoulder");
    // It is fastest after the third waypoint.
    assert_eq!(limited(0.555, 1.74).unwrap_err().waypoint, 2);
    refused(limited(0.57, 1.7), Check::Acceleration, "shoulder");
}

#[test]
fn what_accelerates_between_the_middle_and_the_ends_of_a_short_motion_is_refused() {
    // From rest to rest by 0.3 mrad within 2 ms: at both ends and in the middle nothing
    // accelerates, between them the shoulder does with 430 rad/s2.
    let at = |index: usize| waypoint(0.002 * index as f64, 3e-4 * (index % 2) as f64, 0.0);
    let shaking: Vec<Waypoint> = (0..20).map(at).collect();
    refused(check(&shaking, &[]), Check::ZeroMoment, "too fast");
    let at = |index: usize| waypoint(0.05 * index as f64, 3e-4 * (index % 2) as f64, 0.0);
    check(&(0..20).map(at).collect::<Vec<_>>(), &[]).unwrap();
}

#[test]
fn without_known_stops_the_default_acceleration_limit_holds() {
    // A light forearm swings by 0.2 rad from rest to rest in 0.2 s: 28.9 rad/s2 on the way.
    let mut light = robot();
    (light.links[4].mass, light.links[4].inertia) = (0.1, 1e-3 * glam::DMat3::IDENTITY);
    let motion = [waypoint(0.0, 0.0, 0.0), waypoint(0.2, 0.0, 0.2)];
    check_with(light.clone(), world(vec![]), &motion, &[]).unwrap();
    let mut checker = Checker::new(light, world(vec![]), CheckerConfig::default())
        .unwrap()
        .keeping_default_accelerations();
    let mut check = |waypoints: &[Waypoint]| {
        let (mode, contacts, course) = (SupportMode::Double, &both_feet(), Course::Smooth(&[]));
        checker.check_segment(&MotionSegment { mode, contacts, waypoints, course }, &mut || {})
    };
    refused(check(&motion), Check::Acceleration, "elbow accelerates by");
    check(&[motion[0], Waypoint { time: 0.4, ..motion[1] }]).unwrap();
}

#[test]
fn a_stated_acceleration_holds_where_it_equals_the_default_one() {
    let mut light = robot();
    (light.links[4].mass, light.links[4].inertia) = (0.1, 1e-3 * glam::DMat3::IDENTITY);
    let motion = [waypoint(0.0, 0.0, 0.0), waypoint(0.2, 0.0, 0.2)];
    check_with(light.clone(), world(vec![]), &motion, &[]).unwrap();
    light.joints[ELBOW].stated_acceleration = Some(ACCELERATION_DEFAULT);
    let found = check_with(light, world(vec![]), &motion, &[]);
    refused(found, Check::Acceleration, "elbow accelerates by");
}

#[test]
fn a_stance_sole_that_moves_is_refused() {
    let mut motion = smooth_swing(0.3, 1.0, 6);
    motion[3].root_velocity[0] = 0.03;
    refused(check(&motion, &[]), Check::Contact, "while it stands");
    let mut motion = smooth_swing(0.3, 1.0, 6);
    motion[3].joint_velocity[0] = 0.03;
    refused(check(&motion, &[]), Check::Contact, "the left sole moves");
}

#[test]
fn a_smooth_motion_on_ground_higher_or_lower_than_declared_is_refused() {
    let on_ground_at = |height: f64| {
        let mut ground = world(vec![]);
        ground.shapes.iter_mut().for_each(|shape| shape.world_from_shape.translation.z += height);
        check_with(robot(), ground, &smooth_swing(0.1, 1.0, 6), &[])
    };
    for height in [-4e-4, 0.0, 4e-4] {
        on_ground_at(height).unwrap();
    }
    for (height, side) in [(-6e-4, "0.60 mm over"), (6e-4, "0.60 mm in"), (2e-3, "2.00 mm in")] {
        let violation = on_ground_at(height).unwrap_err();
        assert_eq!(violation.check, Check::Contact);
        assert!(violation.detail.contains(side), "{violation}");
    }
}

#[test]
fn soles_of_a_smooth_motion_that_are_not_as_deep_as_each_other_are_refused() {
    // The ground is lower under the left foot and higher under the right one.
    let apart = |left: f64, right: f64| {
        let floor = |name, side: f64, height: f64| {
            (name, at(0.0, 0.5 * side, height - 0.1), box_of(1.0, 0.5, 0.1))
        };
        let mut ground = world(vec![floor("left", 1.0, left), floor("right", -1.0, right)]);
        ground.shapes.remove(0);
        check_with(robot(), ground, &smooth_swing(0.1, 1.0, 6), &[])
    };
    apart(-2e-4, 2e-4).unwrap();
    apart(4e-4, 4e-4).unwrap();
    refused(apart(-4e-4, 4e-4), Check::Contact, "0.80 mm deeper in the ground");
}

#[test]
fn an_obstacle_that_only_the_curve_meets_is_found() {
    // The arm swings out by 0.125 rad and back between two waypoints at which it hangs down.
    let mut motion = [waypoint(0.0, 0.0, 0.0), waypoint(1.0, 0.0, 0.0)];
    motion.iter_mut().for_each(|waypoint| waypoint.joint_acceleration[SHOULDER] = 4.0);
    let rod =
        |x: f64| ("rod", at(x, 0.25, 0.4), Shape::Cylinder { radius: 0.005, half_length: 0.05 });
    assert!(check_with(robot(), world(vec![rod(-0.25)]), &motion, &[]).is_ok());
    let near = world(vec![rod(-0.09)]);
    refused(check_with(robot(), near, &motion, &[]), Check::Collision, "forearm overlaps rod");
}

#[test]
fn joint_limits_hold_on_the_curve() {
    let mut limited = robot();
    limited.joints[SHOULDER].upper = 0.1;
    let mut motion = [waypoint(0.0, 0.0, 0.0), waypoint(1.0, 0.0, 0.0)];
    motion.iter_mut().for_each(|waypoint| waypoint.joint_acceleration[SHOULDER] = 4.0);
    refused(check_with(limited, world(vec![]), &motion, &[]), Check::Limits, "shoulder");
}

#[test]
fn a_curve_that_leaves_its_waypoints_far_behind_is_refused() {
    let mut motion = [waypoint(0.0, 0.0, 0.0), waypoint(20.0, 0.0, 0.0)];
    motion.iter_mut().for_each(|waypoint| waypoint.joint_acceleration[SHOULDER] = 1e5);
    refused(check(&motion, &[]), Check::Spacing, "bends too much");
}

#[test]
fn nan_passes_no_dynamic_check() {
    let changes: [fn(&mut Waypoint); 4] = [
        |waypoint| waypoint.joint_velocity[SHOULDER] = f64::NAN,
        |waypoint| waypoint.joint_acceleration[SHOULDER] = f64::NAN,
        |waypoint| waypoint.root_velocity[4] = f64::NAN,
        |waypoint| waypoint.root_acceleration[2] = f64::NAN,
    ];
    for (index, change) in changes.iter().enumerate() {
        let mut motion = smooth_swing(0.3, 1.0, 6);
        change(&mut motion[3]);
        assert!(check(&motion, &[]).is_err(), "change {index}");
    }
    let stop = Stop { brake_at: f64::NAN, seconds: 0.5, resume_seconds: 0.5 };
    assert!(!stop.concerns(0.0, 1.0));
}

#[test]
fn a_stop_that_tips_the_robot_over_is_refused() {
    let motion = smooth_swing(0.3, 1.0, 6);
    let stop = |seconds: f64, resume_seconds: f64| Stop { brake_at: 0.4, seconds, resume_seconds };
    assert!(check(&motion, &[stop(0.6, 0.6)]).is_ok());
    refused(check(&motion, &[stop(0.02, 0.6)]), Check::ZeroMoment, "too fast");
    refused(check(&motion, &[stop(0.6, 0.02)]), Check::ZeroMoment, "too fast");
}

const IDENTITY: Identity = Identity {
    controller_id: 7,
    robot: Digest([1; 32]),
    world: Digest([2; 32]),
    config: Digest([3; 32]),
};

fn executor() -> ChunkExecutor {
    let checker = Checker::new(robot(), world(vec![]), CheckerConfig::default()).unwrap();
    ChunkExecutor::new(checker, IDENTITY)
}

fn chunk(before: Option<&PlanChunk>, waypoints: &[Waypoint], stop: Stop) -> Box<PlanChunk> {
    let mut chunk: Box<PlanChunk> = Box::new(Zeroable::zeroed());
    (chunk.schema, chunk.target_controller, chunk.mode) =
        (CHUNK_SCHEMA, 7, SupportMode::Double as u32);
    chunk.sequence = before.map_or(0, |before| before.sequence + 1);
    chunk.flags = if before.is_none() { FLAG_FIRST } else { FLAG_LAST };
    chunk.contacts_len = 2;
    chunk.contacts[..2].copy_from_slice(&both_feet());
    chunk.waypoints_len = waypoints.len() as u32;
    chunk.waypoints[..waypoints.len()].copy_from_slice(waypoints);
    chunk.joints_len = 4;
    chunk.interpolation = Interpolation::Quintic as u64;
    (chunk.brake_at, chunk.brake_duration, chunk.resume_duration) =
        (stop.brake_at, stop.seconds, stop.resume_seconds);
    (chunk.robot, chunk.world, chunk.config) = (IDENTITY.robot, IDENTITY.world, IDENTITY.config);
    chunk.stream = before.map_or(Digest::default(), PlanChunk::stream_after);
    chunk.crc = chunk.computed_crc();
    chunk
}

const FIRST_STOP: Stop = Stop { brake_at: 0.2, seconds: 0.6, resume_seconds: 0.6 };
const NO_STOP: Stop = Stop { brake_at: 1.0, seconds: 0.0, resume_seconds: 0.0 };

/// The swing in two chunks, between which the arm does not rest.
fn halves() -> [Box<PlanChunk>; 2] {
    let motion = smooth_swing(0.3, 1.0, 6);
    let first = chunk(None, &motion[..4], FIRST_STOP);
    let second = chunk(Some(&first), &motion[3..], NO_STOP);
    [first, second]
}

/// The check that refuses the second half, changed.
fn refusal(stop: Stop, change: impl Fn(&mut [Waypoint])) -> Check {
    let [first, _] = halves();
    let mut executor = executor();
    executor.check_and_execute(&first).unwrap();
    let mut motion = smooth_swing(0.3, 1.0, 6);
    change(&mut motion[3..]);
    let changed = chunk(Some(&first), &motion[3..], stop);
    executor.check_and_execute(&changed).expect_err("must be refused").check
}

#[test]
fn a_smooth_plan_goes_on_without_a_rest() {
    let [first, second] = halves();
    let mut executor = executor();
    let margins = executor.check_and_execute(&first).unwrap();
    assert!(margins.zero_moment.is_finite() && margins.dynamic_torque.is_finite());
    // Without the second half the robot comes to rest where it brakes.
    assert_eq!(executor.rest_state().unwrap().waypoint.time, 0.5);
    executor.check_and_execute(&second).unwrap();
    assert!(executor.finished());
    assert_eq!(executor.rest_state().unwrap().waypoint.q[SHOULDER], 0.3);
}

#[test]
fn position_velocity_and_acceleration_continue_across_chunks() {
    assert_eq!(refusal(NO_STOP, |half| half[0].q[SHOULDER] += 1e-6), Check::Continuity);
    assert_eq!(
        refusal(NO_STOP, |half| half[0].joint_velocity[SHOULDER] += 1e-6),
        Check::Continuity
    );
    assert_eq!(
        refusal(NO_STOP, |half| half[0].joint_acceleration[SHOULDER] += 1e-6),
        Check::Continuity
    );
    assert_eq!(refusal(NO_STOP, |half| half[0].root_velocity[0] = 1e-6), Check::Continuity);
    assert_eq!(refusal(NO_STOP, |half| half[0].root_acceleration[5] = 1e-6), Check::Continuity);
}

#[test]
fn feed_forward_torques_continue_across_chunks() {
    let moving = refusal(NO_STOP, |half| half[0].torque[SHOULDER] += 1e-6);
    let resting = refusal(NO_STOP, |half| half[0].rest_torque[ELBOW] -= 1e-6);
    assert_eq!([moving, resting], [Check::Continuity; 2]);
    // Rounding may differ.
    let [first, _] = halves();
    let motion = smooth_swing(0.3, 1.0, 6);
    for (size, goes_on) in [(0.8e-9, true), (1.2e-9, false)] {
        let mut executor = executor();
        executor.check_and_execute(&first).unwrap();
        let mut rounded = motion[3..].to_vec();
        rounded[0].rest_torque[ELBOW] = size;
        let found = executor.check_and_execute(&chunk(Some(&first), &rounded, NO_STOP));
        let is_refused = found.is_err_and(|found| found.check == Check::Continuity);
        assert_eq!(!is_refused, goes_on);
    }
}

#[test]
fn a_new_plan_may_state_other_torques_than_the_one_before() {
    let still = [waypoint(0.0, 0.0, 0.0), waypoint(1.0, 0.0, 0.0)];
    let plan = |plan_id: u64, torque: f64| {
        let mut motion = still;
        for waypoint in &mut motion {
            (waypoint.torque[ELBOW], waypoint.rest_torque[ELBOW]) = (torque, torque);
        }
        let mut plan = chunk(None, &motion, NO_STOP);
        (plan.plan_id, plan.flags) = (plan_id, FLAG_FIRST | FLAG_LAST);
        plan.write_crc();
        plan
    };
    let mut executor = executor();
    executor.check_and_execute(&plan(1, 0.0)).unwrap();
    executor.check_and_execute(&plan(2, 1e-3)).unwrap();
}

#[test]
fn a_plan_begins_and_ends_at_rest() {
    let motion = smooth_swing(0.3, 1.0, 6);
    let moving = chunk(None, &motion[2..5], Stop { brake_at: 0.35, ..FIRST_STOP });
    assert_eq!(executor().check_and_execute(&moving).unwrap_err().check, Check::Continuity);
    assert_eq!(refusal(NO_STOP, |half| half[3].joint_velocity[0] = 1e-3), Check::Continuity);
}

#[test]
fn a_stop_within_no_time_is_refused_where_the_plan_moves() {
    let motion = smooth_swing(0.3, 1.0, 6);
    for (seconds, resume_seconds) in [(0.0, 0.6), (0.6, 0.0)] {
        let stop = Stop { brake_at: 0.3, seconds, resume_seconds };
        let violation = executor().check_and_execute(&chunk(None, &motion, stop)).unwrap_err();
        assert_eq!(violation.check, Check::Acceleration, "{violation}");
        assert!(violation.detail.contains("within no time"), "{violation}");
    }
    let stop = Stop { resume_seconds: 0.6, ..NO_STOP };
    executor().check_and_execute(&chunk(None, &motion, stop)).unwrap();
}

#[test]
fn a_plan_that_would_rest_before_its_end_is_refused() {
    // The controller would take the robot to stand where it stopped, and it walks to the end.
    let stop = Stop { brake_at: 0.6, seconds: 0.6, resume_seconds: 0.6 };
    assert_eq!(refusal(stop, |_| ()), Check::Continuity);
}

#[test]
fn stops_across_chunks_are_checked() {
    // The second half brakes while the first one still moves: gently, too late, before it.
    let stop = |brake_at: f64, seconds: f64| Stop { brake_at, seconds, resume_seconds: 1.0 };
    let accepted = |own: Stop| {
        let [first, _] = halves();
        let mut executor = executor();
        executor.check_and_execute(&first).unwrap();
        let motion = smooth_swing(0.3, 1.0, 6);
        let mut second = chunk(Some(&first), &motion[3..], own);
        second.flags = 0;
        second.write_crc();
        executor.check_and_execute(&second)
    };
    assert!(accepted(stop(0.35, 0.6)).is_ok());
    refused(accepted(stop(0.19, 0.8)), Check::Continuity, "brakes at 0.19 s");
    refused(accepted(stop(0.493, 0.02)), Check::ZeroMoment, "while it brakes before this chunk");
    // The first half's stop goes on in the second one.
    let quick = Stop { resume_seconds: 0.02, ..FIRST_STOP };
    let motion = smooth_swing(0.3, 1.0, 6);
    let first = chunk(None, &motion[..4], quick);
    let mut executor = executor();
    executor.check_and_execute(&first).unwrap();
    let second = chunk(Some(&first), &motion[3..], NO_STOP);
    refused(executor.check_and_execute(&second), Check::ZeroMoment, "too fast");
}

#[test]
fn a_robot_whose_next_chunk_is_late_brakes_stands_and_goes_on() {
    let [first, second] = halves();
    let mut clock = PlanClock::new(0.0);
    clock.advance(1.0);
    assert_eq!((clock.now().time, clock.now().rate), (0.0, 0.0));
    clock.accept(&first);
    // At full speed after nothing, at 0.2 s the robot brakes for 0.6 s and stands at 0.5 s.
    clock.advance(0.1);
    assert_eq!((clock.now().time, clock.now().rate), (0.1, 1.0));
    clock.advance(0.4);
    let now = clock.now();
    assert!((now.rate - 0.5).abs() < 1e-9 && now.rate_change < 0.0, "{now:?}");
    clock.advance(5.0);
    assert_eq!((clock.now().time, clock.now().rate), (0.5, 0.0));
    assert!(matches!(clock.pace(), Pace::AtRest(_)) && !clock.is_finished());
    clock.accept(&second);
    clock.advance(0.3);
    assert!((clock.now().rate - 0.5).abs() < 1e-9, "{:?}", clock.now());
    clock.advance(0.3);
    assert!((clock.now().time - 0.8).abs() < 1e-9, "{:?}", clock.now());
    clock.advance(0.3);
    assert!(clock.is_finished());
    assert_eq!((clock.now().time, clock.now().rate), (1.0, 0.0));
}

#[test]
fn a_controller_continues_the_walk_of_the_one_before_at_any_instant() {
    const TICK: f64 = 0.01;
    let [first, second] = halves();
    // The second half comes after the robot has stopped in the first one.
    let until = |ticks: usize, walk: &mut ChunkWalk, from: usize| {
        for tick in from..ticks {
            match tick {
                5 => walk.accept(&first),
                150 => walk.accept(&second),
                _ => {}
            }
            walk.advance(TICK);
        }
    };
    let mut whole = ChunkWalk::default();
    until(300, &mut whole, 0);
    assert!(whole.is_finished() && whole.counts().brakes == 1);
    for killed_at in 6..300 {
        let mut before = ChunkWalk::default();
        until(killed_at, &mut before, 0);
        let chunks = [*first, *second];
        let accepted = &chunks[..if killed_at > 150 { 2 } else { 1 }];
        let mut after = ChunkWalk::default();
        assert!(after.take_over(accepted, before.record().as_ref()), "{killed_at}");
        assert_eq!(after.now().map(|(_, now)| now), before.now().map(|(_, now)| now));
        until(300, &mut after, killed_at);
        assert!(after.is_finished() && after.now() == whole.now(), "{killed_at}");
        let stops = [before.counts(), after.counts()];
        assert_eq!(stops[0].brakes + stops[1].brakes, 1, "{killed_at}");
        assert!((stops[0].stood + stops[1].stood - whole.counts().stood).abs() < 1e-9);
    }
}

#[test]
fn without_a_record_the_robot_stands_where_its_chunks_say() {
    let [first, second] = halves();
    let stands_at = |chunks: &[PlanChunk], record: Option<&WalkRecord>| {
        let mut walk = ChunkWalk::default();
        assert!(!walk.take_over(chunks, record));
        let standing = walk.now().map(|(_, now)| now.time);
        walk.advance(10.0);
        (standing, walk.now().map(|(_, now)| now.time))
    };
    // Killed before it moved; killed, and the chunks are not those from the record's instant on.
    assert_eq!(stands_at(&[*first], None), (Some(0.0), Some(0.5)));
    assert_eq!(stands_at(&[*second], None), (Some(1.0), Some(1.0)));
    let mut walk = ChunkWalk::default();
    walk.accept(&first);
    walk.advance(0.1);
    let record = walk.record().unwrap();
    assert_eq!(stands_at(&[*second], Some(&record)), (Some(1.0), Some(1.0)));
    let other_plan = WalkRecord { epoch: 9, ..record };
    assert_eq!(stands_at(&[*first], Some(&other_plan)), (Some(0.0), Some(0.5)));
    for stop in [1, 2, u64::MAX] {
        let damaged = WalkRecord { pace: 2, stop, time: 1e9, ..record };
        assert_eq!(stands_at(&[*first], Some(&damaged)).1, Some(0.5));
    }
    assert_eq!(stands_at(&[], Some(&record)), (None, None));
}

#[test]
fn a_controller_that_takes_over_within_a_smooth_chunk_accepts_the_next_one() {
    let [first, second] = halves();
    let mut before = executor();
    before.check_and_execute(&first).unwrap();
    let rest = before.rest_state().unwrap();
    let feedback = Feedback {
        session: 1,
        plan_id: first.plan_id,
        next_sequence: 1,
        stream: before.stream(),
        rest_state: RestState::zeroed().after(first.mode, first.contacts(), &rest.waypoint),
        ..Feedback::zeroed()
    };
    let taken_over = || {
        let checker = Checker::new(robot(), world(vec![]), CheckerConfig::default()).unwrap();
        ChunkExecutor::take_over(checker, IDENTITY, &feedback)
    };
    let mut without_chunks = taken_over();
    refused(
        without_chunks.check_and_execute(&second),
        Check::Continuity,
        "from where the robot stands",
    );
    let mut with_chunks = taken_over().going_on_after(&[*first]);
    let margins = with_chunks.check_and_execute(&second).unwrap();
    // The directions in which distances are measured first come from earlier chunks.
    let expected = before.check_and_execute(&second).unwrap();
    let [found, expected]: [[f64; 8]; 2] = [margins, expected].map(bytemuck::cast);
    let is_equal = found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-12);
    assert!(is_equal, "{found:?} {expected:?}");
    assert!(with_chunks.finished());
}

#[test]
fn a_robot_whose_chunks_are_in_time_does_not_brake() {
    let mut clock = PlanClock::new(0.0);
    halves().iter().for_each(|chunk| clock.accept(chunk));
    clock.advance(0.75);
    assert_eq!(clock.now().rate, 1.0);
    assert!((clock.now().time - 0.75).abs() < 1e-12);
}

#[test]
fn every_instant_of_walks_with_late_chunks_passes_the_dynamic_checks() {
    let chunks = halves().map(|chunk| *chunk);
    let mut checker = Checker::new(robot(), world(vec![]), CheckerConfig::default()).unwrap();
    let (mut brakes, mut late) = (0, 0);
    for seed in 0..40 {
        let walk = walk_late(&mut checker, &chunks, &late_chunks(seed)).unwrap();
        assert!(walk.is_finished && (walk.brakes > 0 || walk.stood == 0.0), "{seed}");
        check_executed(&walk, &chunks);
        (brakes, late) = (brakes + walk.brakes, late + walk.late);
    }
    assert!(brakes >= 3 && late >= 3, "{brakes} {late}");
    // A stop that is too short is noticed where it takes place.
    let mut hasty = chunks;
    (hasty[0].brake_at, hasty[0].brake_duration) = (0.45, 0.02);
    let refused =
        (0..40).filter_map(|seed| walk_late(&mut checker, &hasty, &late_chunks(seed)).err());
    let (at, violation) = refused.into_iter().next().unwrap();
    assert!(at > 0.44, "{at}: {violation}");
}

fn late_chunks(seed: u64) -> LateChunks {
    LateChunks { seed, share: 0.5 }
}

/// The motion as executed is that of the plan, later by the time in which the robot braked, stood
/// and went on, and continuous.
fn check_executed(walk: &LateWalk, planned: &[PlanChunk]) {
    let ends = |chunks: &[PlanChunk]| {
        let waypoints: Vec<Waypoint> =
            chunks.iter().flat_map(PlanChunk::waypoints).copied().collect();
        (waypoints[0], waypoints[waypoints.len() - 1])
    };
    let ((begin, end), (first, last)) = (ends(&walk.executed), ends(planned));
    let same = |a: &Waypoint, b: &Waypoint| a.q == b.q && a.root_position == b.root_position;
    assert!(same(&begin, &first) && same(&end, &last) && begin.time == 0.0);
    let longer = end.time - (last.time - first.time);
    assert!(longer >= walk.stood - 1e-9 && (walk.brakes > 0 || longer < 1e-9), "{longer}");
    for pair in walk.executed.windows(2) {
        let [end, begin] = [pair[0].waypoints().last(), pair[1].waypoints().first()];
        let (end, begin) = (end.unwrap(), begin.unwrap());
        assert!(end.time == begin.time && (end.q[2] - begin.q[2]).abs() < 1e-12);
    }
    for waypoints in walk.executed.iter().map(PlanChunk::waypoints) {
        for pair in waypoints.windows(2) {
            let seconds = pair[1].time - pair[0].time;
            assert!(seconds > 0.0);
            let middle = Interpolation::Quintic.sample(pair, pair[0].time + 0.5 * seconds);
            // Where the robot brakes and goes on, it is where its speed leads; the waypoints of the
            // plan itself are far apart.
            let joints = if seconds <= 0.0101 { 0..middle.q.len() } else { 0..0 };
            for joint in joints {
                let mean = 0.5 * (pair[0].joint_velocity[joint] + pair[1].joint_velocity[joint]);
                let led = pair[0].q[joint] + seconds * mean;
                assert!((led - pair[1].q[joint]).abs() < 1e-3, "{} {led}", pair[0].time);
                assert!((middle.joint_velocity[joint] - mean).abs() < 0.1);
            }
        }
    }
}
