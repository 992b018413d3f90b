//! Every reason for which a received chunk is refused, and that a refusal leaves the robot where it
//! stands.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

mod check_robot;

use std::cell::RefCell;

use check_robot::*;
use surefoot_controller_sim::{Checker, ChunkExecutor, Goal, Identity};
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::config::scenario::{GoalTolerance, StancePose};
use surefoot_shared_types::message::chunk::{CHUNK_SCHEMA, FLAG_FIRST, FLAG_LAST};
use surefoot_shared_types::message::request::StancePoseData;
use surefoot_shared_types::message::{Check, Contact, PlanChunk, SupportMode, Waypoint, WithCrc};

const IDENTITY: Identity = Identity {
    controller_id: 7,
    robot: Digest([1; 32]),
    world: Digest([2; 32]),
    config: Digest([3; 32]),
};

fn executor() -> ChunkExecutor {
    ChunkExecutor::new(
        Checker::new(robot(), world(vec![]), CheckerConfig::default()).unwrap(),
        IDENTITY,
    )
}

fn chunk(
    sequence: u64,
    stream: Digest,
    mode: SupportMode,
    contacts: &[Contact],
    waypoints: &[Waypoint],
) -> Box<PlanChunk> {
    let mut chunk: Box<PlanChunk> = Box::new(bytemuck::Zeroable::zeroed());
    chunk.schema = CHUNK_SCHEMA;
    chunk.target_controller = 7;
    chunk.sequence = sequence;
    chunk.flags = if sequence == 0 { FLAG_FIRST } else { 0 };
    chunk.mode = mode as u32;
    chunk.contacts_len = contacts.len() as u32;
    chunk.contacts[..contacts.len()].copy_from_slice(contacts);
    chunk.waypoints_len = waypoints.len() as u32;
    chunk.waypoints[..waypoints.len()].copy_from_slice(waypoints);
    chunk.joints_len = 4;
    chunk.brake_at = waypoints[waypoints.len() - 1].time;
    (chunk.robot, chunk.world, chunk.config, chunk.stream) =
        (IDENTITY.robot, IDENTITY.world, IDENTITY.config, stream);
    signed(chunk)
}

fn signed(mut chunk: Box<PlanChunk>) -> Box<PlanChunk> {
    chunk.crc = chunk.computed_crc();
    chunk
}

fn first() -> Box<PlanChunk> {
    chunk(
        0,
        Digest::default(),
        SupportMode::Double,
        &both_feet(),
        &swing((0.0, 0.0), (0.2, 0.0), 3),
    )
}

/// The chunk after [`first`].
fn second() -> Box<PlanChunk> {
    let mut waypoints = swing((0.2, 0.0), (0.0, 0.0), 3);
    waypoints.iter_mut().for_each(|waypoint| waypoint.time += 2.0);
    chunk(1, first().stream_after(), SupportMode::Double, &both_feet(), &waypoints)
}

/// The check that refuses the second chunk, changed, after [`first`] is accepted.
fn refusal(change: impl Fn(&mut PlanChunk)) -> Check {
    let mut executor = executor();
    executor.check_and_execute(&first()).unwrap();
    let before = executor.rest_state().cloned();
    let mut changed = second();
    change(&mut changed);
    let check = executor.check_and_execute(&signed(changed)).expect_err("must be refused").check;
    assert_eq!(
        (executor.rest_state().cloned(), executor.next_sequence()),
        (before, 1),
        "a refusal must not move the robot"
    );
    executor.check_and_execute(&second()).expect("the right chunk is still accepted");
    check
}

#[test]
fn a_swing_foot_is_not_dragged_along_by_many_short_chunks() {
    let mut light = robot();
    light.links[2].mass = 0.1;
    light.links[0].com.y = 0.1;
    let checker = Checker::new(light, world(vec![]), CheckerConfig::default()).unwrap();
    let mut executor = ChunkExecutor::new(checker, IDENTITY);
    // The right hip moves the foot over the floor by less than a chunk may.
    let at = |step: u64| {
        let mut at = waypoint(step as f64, 0.0, 0.0);
        at.q[1] = 0.005 * step as f64;
        at
    };
    let mut walk = |step: u64| {
        let motion = [at(step), at(step + 1)];
        let chunk = chunk(step, executor.stream(), SupportMode::Left, &[contact(0)], &motion);
        executor.check_and_execute(&chunk)
    };
    walk(0).unwrap();
    let violation = (1..4).find_map(|step| walk(step).err()).unwrap();
    assert!(violation.detail.contains("right foot slides over the world"), "{violation}");
}

#[test]
fn chunks_in_order_are_executed_to_the_end() {
    let mut executor = executor();
    executor.check_and_execute(&first()).unwrap();
    let mut last = second();
    last.flags = FLAG_LAST;
    let last = signed(last);
    executor.check_and_execute(&last).unwrap();
    assert!(executor.finished());
    assert_eq!(executor.stream(), last.stream_after());
    assert_eq!(executor.rest_state().unwrap().waypoint.time, 4.0);
    assert_eq!(executor.check_and_execute(&last).unwrap_err().check, Check::Sequence);
}

#[test]
fn any_flipped_bit_is_refused_by_the_crc() {
    let good = first();
    let size = size_of::<PlanChunk>();
    for bit in (0..8 * size).step_by(997) {
        let mut bad = good.clone();
        bytemuck::bytes_of_mut(&mut *bad)[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(
            with_cached_executor(|executor| executor.check_and_execute(&bad).unwrap_err().check),
            Check::Crc,
            "bit {bit}"
        );
    }
}

/// Runs on one shared executor that must never move.
fn with_cached_executor<T>(use_it: impl FnOnce(&mut ChunkExecutor) -> T) -> T {
    thread_local!(static EXECUTOR: RefCell<ChunkExecutor> = RefCell::new(executor()));
    EXECUTOR.with_borrow_mut(use_it)
}

#[test]
fn malformed_messages_are_refused() {
    let changes: [&dyn Fn(&mut PlanChunk); 24] = [
        &|chunk| chunk.schema = CHUNK_SCHEMA + 1,
        &|chunk| chunk.flags = 4,
        &|chunk| chunk.flags = FLAG_FIRST,
        &|chunk| chunk.mode = 3,
        &|chunk| chunk.contacts_len = u32::MAX,
        &|chunk| chunk.contacts_len = 1,
        &|chunk| chunk.contacts[1].limb = 0,
        &|chunk| chunk.contacts[1].limb = 9,
        &|chunk| chunk.contacts[0].polygon_len = 17,
        &|chunk| chunk.contacts[0].rotation = [0.0, 0.0, 0.0, 1.1],
        &|chunk| chunk.waypoints_len = 0,
        &|chunk| chunk.waypoints_len = 33,
        &|chunk| chunk.joints_len = 5,
        &|chunk| chunk.waypoints[1].q[2] = f64::NAN,
        &|chunk| chunk.waypoints[2].root_position[0] = f64::INFINITY,
        &|chunk| chunk.interpolation = 2,
        &|chunk| chunk.brake_at = f64::NAN,
        &|chunk| chunk.brake_at = 2.9,
        &|chunk| chunk.brake_duration = 0.1,
        &|chunk| chunk.resume_duration = 21.0,
        &|chunk| chunk.waypoints[1].joint_velocity[0] = 0.1,
        &|chunk| {
            chunk.interpolation = 1;
            chunk.brake_at = 1.0;
        },
        &|chunk| {
            chunk.interpolation = 1;
            (chunk.brake_at, chunk.brake_duration) = (3.9, 0.4);
        },
        &|chunk| {
            chunk.interpolation = 1;
            chunk.waypoints[1].root_acceleration[4] = f64::NAN;
        },
    ];
    for (index, change) in changes.iter().enumerate() {
        assert_eq!(refusal(change), Check::Malformed, "change {index}");
    }
}

#[test]
fn chunks_for_others_are_refused() {
    assert_eq!(refusal(|chunk| chunk.target_controller = 8), Check::Controller);
    assert_eq!(refusal(|chunk| chunk.robot = Digest([9; 32])), Check::Robot);
    assert_eq!(refusal(|chunk| chunk.world = Digest([9; 32])), Check::World);
    assert_eq!(refusal(|chunk| chunk.config = Digest([9; 32])), Check::Config);
}

#[test]
fn chunks_out_of_order_are_refused() {
    assert_eq!(refusal(|chunk| *chunk = *first()), Check::Sequence);
    assert_eq!(refusal(|chunk| chunk.sequence = 2), Check::Sequence);
    assert_eq!(refusal(|chunk| chunk.plan_id = 1), Check::Sequence);
    assert_eq!(refusal(|chunk| chunk.stream = Digest([9; 32])), Check::Stream);
}

#[test]
fn chunks_that_do_not_continue_are_refused() {
    assert_eq!(refusal(|chunk| chunk.waypoints[0].q[2] += 1e-8), Check::Continuity);
    assert_eq!(refusal(|chunk| chunk.waypoints[0].time += 0.1), Check::Continuity);
    assert_eq!(refusal(|chunk| chunk.contacts[1].position[0] += 1e-5), Check::Continuity);
}

#[test]
fn a_foot_may_be_lifted_but_not_swapped() {
    let mut light = robot();
    light.links[2].mass = 0.1;
    light.links[0].com.y = 0.1;
    let mut executor = ChunkExecutor::new(
        Checker::new(light, world(vec![]), CheckerConfig::default()).unwrap(),
        IDENTITY,
    );
    let still = [waypoint(0.0, 0.0, 0.0)];
    let start = chunk(0, Digest::default(), SupportMode::Left, &[contact(0)], &still);
    executor.check_and_execute(&start).unwrap();
    let swapped = chunk(1, start.stream_after(), SupportMode::Right, &[contact(1)], &still);
    assert_eq!(executor.check_and_execute(&swapped).unwrap_err().check, Check::Continuity);
    let lowered = chunk(1, start.stream_after(), SupportMode::Double, &both_feet(), &still);
    executor.check_and_execute(&lowered).unwrap();
}

#[test]
fn physics_is_checked_last_and_a_new_plan_begins_where_the_robot_stands() {
    assert_eq!(refusal(|chunk| chunk.waypoints[2].q[2] = 0.5), Check::Spacing);
    assert_eq!(
        refusal(|chunk| {
            chunk.waypoints[2].time = chunk.waypoints[1].time + 0.1;
            chunk.brake_at = chunk.waypoints[2].time;
        }),
        Check::Acceleration
    );
    let mut executor = executor();
    executor.check_and_execute(&first()).unwrap();
    let mut elsewhere = first();
    elsewhere.plan_id = 1;
    assert_eq!(
        executor.check_and_execute(&signed(elsewhere)).unwrap_err().check,
        Check::Continuity
    );
    let mut here = chunk(
        0,
        Digest::default(),
        SupportMode::Double,
        &both_feet(),
        &swing((0.2, 0.0), (0.1, 0.0), 3),
    );
    here.plan_id = 1;
    executor.check_and_execute(&signed(here)).unwrap();
    assert_eq!((executor.plan_id(), executor.next_sequence()), (Some(1), 1));
}

#[test]
fn a_kept_foot_does_not_creep() {
    let mut executor = executor();
    let (mut stream, mut moved) = (Digest::default(), 0.0);
    for sequence in 0..5 {
        // Each chunk declares the soles 0.9 um from those of the chunk before.
        let mut feet = both_feet();
        feet.iter_mut().for_each(|foot| foot.position[0] += moved);
        let time = sequence as f64;
        let still = [waypoint(time, 0.0, 0.0), waypoint(time + 1.0, 0.0, 0.0)];
        let next = chunk(sequence, stream, SupportMode::Double, &feet, &still);
        match executor.check_and_execute(&next) {
            Ok(_) => stream = next.stream_after(),
            Err(violation) => {
                assert_eq!((violation.check, sequence), (Check::Continuity, 2), "{violation}");
                return;
            }
        }
        moved += 0.9e-6;
    }
    panic!("both feet slid by {moved} m");
}

#[test]
fn the_first_chunk_begins_at_the_start() {
    let start = |x: f64| StancePose {
        position: glam::DVec3::new(x, 0.0, 0.0),
        yaw: 0.0,
        stance_width: 0.2,
    };
    executor().starting_at(start(0.03)).check_and_execute(&first()).unwrap();
    let mut elsewhere = executor().starting_at(start(2.0));
    let violation = elsewhere.check_and_execute(&first()).unwrap_err();
    assert_eq!(violation.check, Check::Continuity, "{violation}");
    assert_eq!(elsewhere.rest_state(), None);
}

#[test]
fn the_last_chunk_ends_at_the_goal() {
    let refusal_at = |x: f64, yaw: f64, change: &dyn Fn(&mut PlanChunk)| {
        let position = glam::DVec3::new(x, 0.0, 0.05);
        let goal = Goal {
            stance: StancePose { position, yaw, stance_width: 0.2 },
            tolerance: GoalTolerance { position: 0.1, yaw: 0.15 },
        };
        let mut executor = executor().ending_at(goal);
        executor.check_and_execute(&first()).expect("only the last chunk ends at the goal");
        let before = executor.rest_state().cloned();
        let mut last = second();
        last.flags = FLAG_LAST;
        change(&mut last);
        let refusal = executor.check_and_execute(&signed(last)).err();
        let stays = executor.rest_state() == before.as_ref() && !executor.finished();
        assert_eq!(refusal.is_some(), stays, "a refusal must not move the robot");
        refusal.map(|refusal| (refusal.check, refusal.detail))
    };
    let whole = &|_: &mut PlanChunk| {};
    assert_eq!(refusal_at(0.09, 0.1, whole), None);
    for (x, yaw, words) in [
        (0.11, 0.0, "left sole 0.110 m beside its place at the goal"),
        (0.0, 0.16, "left sole turned by 0.160 rad from the goal"),
        (f64::NAN, 0.0, "left sole NaN m beside"),
    ] {
        let (check, detail) = refusal_at(x, yaw, whole).expect("must be refused");
        assert!(check == Check::Continuity && detail.contains(words), "{detail}");
    }
    let on_one_foot = |last: &mut PlanChunk| {
        (last.mode, last.contacts_len) = (SupportMode::Left as u32, 1);
    };
    let (_, detail) = refusal_at(0.0, 0.0, &on_one_foot).expect("must be refused");
    assert!(detail.contains("ends on one foot"), "{detail}");
    // A plan whose last chunk is called another one is not finished, and has not arrived.
    assert_eq!(refusal_at(3.0, 0.0, &|last| last.flags = 0), None);
}

#[test]
fn a_controller_that_serves_holds_a_plan_to_the_goal_that_it_states() {
    let refusal_with = |x: f64, stance_width: f64| {
        let mut executor = executor().ending_as_stated(GoalTolerance { position: 0.1, yaw: 0.15 });
        executor.check_and_execute(&first()).expect("only the last chunk states the goal");
        let mut last = second();
        last.flags = FLAG_LAST;
        last.goal = StancePoseData { position: [x, 0.0, 0.05], yaw: 0.1, stance_width };
        let refusal = executor.check_and_execute(&signed(last)).err();
        assert_eq!(refusal.is_none(), executor.finished());
        refusal.map(|refusal| (refusal.check, refusal.detail))
    };
    assert_eq!(refusal_with(0.09, 0.2), None);
    for (x, stance_width, check, words) in [
        (0.13, 0.2, Check::Continuity, "left sole 0.120 m beside its place at the goal"),
        (0.0, 0.0, Check::Continuity, "does not state the goal"),
        (f64::NAN, 0.2, Check::Malformed, "goal with a number out of range"),
        (0.0, -0.2, Check::Malformed, "goal with a number out of range"),
        (0.0, f64::NAN, Check::Malformed, "goal with a number out of range"),
    ] {
        let refusal = refusal_with(x, stance_width).expect("must be refused");
        assert!(refusal.0 == check && refusal.1.contains(words), "{refusal:?}");
    }
}

#[test]
fn a_chunk_of_days_is_refused() {
    let mut motion = swing((0.0, 0.0), (0.2, 0.0), 2);
    motion[1].time = 2e4;
    let long = chunk(0, Digest::default(), SupportMode::Double, &both_feet(), &motion);
    assert_eq!(executor().check_and_execute(&long).unwrap_err().check, Check::Spacing);
}
