//! Feed-forward torques where motions begin, end and follow each other, and those not compared.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

mod check_robot;
mod checked_motion;

use check_robot::*;
use checked_motion::{check_motion, refused};
use surefoot_controller_sim::{
    Checker, ChunkExecutor, Course, Identity, MotionSegment, Problem, Stop, Violation,
    check_plan_in,
};
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::chunk::{CHUNK_SCHEMA, FLAG_FIRST, FLAG_LAST};
use surefoot_shared_types::message::{
    Check, Interpolation, Margins, PlanChunk, SupportMode, Waypoint, WithCrc,
};
use surefoot_shared_types::plan_file::write::plan_without_origin;
use surefoot_shared_types::plan_format::blocks::{EndBlock, PhaseBlock, PlanFile};
use surefoot_shared_types::robot::model::RobotModel;

const NOTHING: [f64; JOINTS_MAX] = [0.0; JOINTS_MAX];
const STOP: Stop = Stop { brake_at: 0.3, seconds: 0.5, resume_seconds: 0.5 };
const IDENTITY: Identity = Identity {
    controller_id: 7,
    robot: Digest([1; 32]),
    world: Digest([2; 32]),
    config: Digest([3; 32]),
};

/// A robot that stands on its left foot alone; its right one touches the ground.
fn light() -> RobotModel {
    let mut light = robot();
    (light.links[2].mass, light.links[0].com.y) = (0.1, 0.1);
    light
}

fn checker() -> Checker {
    Checker::new(light(), world(vec![]), CheckerConfig::default()).unwrap()
}

/// The arm swings by `angle` (rad) from rest to rest within a second, along
/// `10 s^3 - 15 s^4 + 6 s^5`, with the torques of one foot.
fn swing_on_one_foot(angle: f64) -> Vec<Waypoint> {
    let mut checker = checker();
    let at = |index: usize| {
        let s = index as f64 / 6.0;
        let mut waypoint = waypoint(s, angle * s * s * s * (10.0 - s * (15.0 - 6.0 * s)), 0.0);
        waypoint.joint_velocity[SHOULDER] = angle * 30.0 * s * s * (1.0 - s) * (1.0 - s);
        waypoint.joint_acceleration[SHOULDER] = angle * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s);
        waypoint
    };
    let mut motion: Vec<Waypoint> = (0..=6).map(at).collect();
    let supports = checker.sole_supports(&[contact(0)], &motion);
    for waypoint in &mut motion {
        let planned = checker.moving_load(&supports, waypoint).torques;
        let mut changing = *waypoint;
        changing.joint_acceleration[SHOULDER] += waypoint.joint_velocity[SHOULDER];
        let changed = checker.moving_load(&supports, &changing).torques;
        let resting = checker.moving_load(&supports, &waypoint.rested()).torques;
        for joint in 0..4 {
            waypoint.torque[joint] = planned[joint];
            waypoint.rate_change_torque[joint] = changed[joint] - planned[joint];
            waypoint.rest_torque[joint] = resting[joint];
        }
    }
    motion
}

fn check_with(
    mut checker: Checker,
    waypoints: &[Waypoint],
    stops: &[Stop],
) -> Result<Margins, Violation> {
    let (mode, contacts, course) = (SupportMode::Left, &[contact(0)], Course::Smooth(stops));
    checker.check_segment(&MotionSegment { mode, contacts, waypoints, course }, &mut || {})
}

fn check(waypoints: &[Waypoint], stops: &[Stop]) -> Result<Margins, Violation> {
    check_with(checker(), waypoints, stops)
}

#[test]
fn where_the_feet_change_the_size_of_torques_counts() {
    let sound = swing_on_one_foot(0.2);
    check(&sound, &[STOP]).unwrap();
    for at in [0, 6] {
        for size in [-201.0, 201.0] {
            let mut moving = sound.clone();
            moving[at].torque[ELBOW] = size;
            let mut resting = sound.clone();
            resting[at].rest_torque[ELBOW] = size;
            for motion in [moving, resting] {
                let violation = refused(check(&motion, &[]), Check::DynamicTorque, "is fed");
                assert_eq!(violation.waypoint, at);
            }
        }
    }
}

#[test]
fn torques_of_an_executed_walk_are_within_the_limits() {
    let executed = |motion: &[Waypoint]| check_with(checker().with_stops_in_motion(), motion, &[]);
    let mut motion = swing_on_one_foot(0.2);
    motion[3].torque[ELBOW] = 199.0;
    executed(&motion).unwrap();
    for size in [-201.0, 201.0] {
        motion[3].torque[ELBOW] = size;
        refused(executed(&motion), Check::DynamicTorque, "joint elbow is fed");
    }
}

#[test]
fn torques_of_a_change_of_the_rate_count_beside_others() {
    let check = |motion: &[Waypoint], stops: &[Stop]| {
        let mut weak = light();
        weak.joints[SHOULDER].effort = 17.0;
        let checker = Checker::new(weak, world(vec![]), CheckerConfig::default()).unwrap();
        check_with(checker, motion, stops)
    };
    let sound = swing_on_one_foot(0.4);
    check(&sound, &[]).unwrap();
    // Without torques of the motion those of a stop would be the only ones that a servo gets.
    let mut alone = sound.clone();
    for waypoint in &mut alone {
        (waypoint.torque, waypoint.rest_torque) = (NOTHING, NOTHING);
    }
    check(&alone, &[]).unwrap();
    refused(check(&alone, &[STOP]), Check::DynamicTorque, "feed-forward torques");
    // A motion that states none leaves the stop to the servo, although it needs half of a limit.
    let mut without = sound.clone();
    let braked = 4.0 * without[3].rate_change_torque[SHOULDER].abs();
    assert!(braked > 8.0, "{braked}");
    without.iter_mut().for_each(|waypoint| waypoint.rate_change_torque = NOTHING);
    check(&without, &[]).unwrap();
}

#[test]
fn straight_lines_state_no_torques_at_rest() {
    let mut motion = [waypoint(0.0, 0.0, 0.0), waypoint(1.0, 0.0, 0.0)];
    motion[1].rest_torque[SHOULDER] = 1.0;
    let found = check_motion(robot(), world(vec![]), &both_feet(), &motion);
    refused(found, Check::DynamicTorque, "straight lines with feed-forward torques");
}

/// A part of a motion on the left foot.
fn chunk(before: Option<&PlanChunk>, waypoints: &[Waypoint]) -> Box<PlanChunk> {
    let mut chunk: Box<PlanChunk> = Box::new(bytemuck::Zeroable::zeroed());
    (chunk.schema, chunk.target_controller, chunk.mode) =
        (CHUNK_SCHEMA, 7, SupportMode::Left as u32);
    chunk.sequence = before.map_or(0, |before| before.sequence + 1);
    chunk.flags = if before.is_none() { FLAG_FIRST } else { FLAG_LAST };
    (chunk.contacts_len, chunk.contacts[0]) = (1, contact(0));
    chunk.waypoints_len = waypoints.len() as u32;
    chunk.waypoints[..waypoints.len()].copy_from_slice(waypoints);
    chunk.joints_len = 4;
    chunk.interpolation = Interpolation::Quintic as u64;
    (chunk.brake_at, chunk.brake_duration, chunk.resume_duration) =
        if before.is_none() { (0.2, 0.6, 0.6) } else { (1.0, 0.0, 0.0) };
    (chunk.robot, chunk.world, chunk.config) = (IDENTITY.robot, IDENTITY.world, IDENTITY.config);
    chunk.stream = before.map_or(Digest::default(), PlanChunk::stream_after);
    chunk.crc = chunk.computed_crc();
    chunk
}

/// The plan of a motion on the left foot, with a phase for each half of it.
fn plan_in_halves(motion: &[Waypoint]) -> PlanFile {
    let region =
        EndBlock::RootRegion { xy: [0.0; 2], radius: 1.0, z_range: None, yaw: None, yaw_tol: None };
    let ends = [region.clone(), region];
    let whole = [*chunk(None, motion)];
    let folder = std::path::Path::new("/");
    let mut plan = plan_without_origin(&light(), &world(vec![]), ends, &whole, folder);
    let half = |(first, last)| PhaseBlock { first, last, ..plan.phases[0].clone() };
    plan.phases = [(0, 3), (3, 6)].map(half).to_vec();
    plan.chunks.clear();
    plan
}

#[test]
fn on_the_same_foot_torques_count_where_one_motion_ends_and_the_next_one_begins() {
    // The right foot touches the ground all the time, and would share the load where it lands.
    for (off, goes_on) in [(0.0, true), (9.0, true), (-11.0, false), (11.0, false)] {
        let mut motion = swing_on_one_foot(0.2);
        motion[3].torque[SHOULDER] += off;
        let first = chunk(None, &motion[..4]);
        let mut executor = ChunkExecutor::new(checker(), IDENTITY);
        executor.check_and_execute(&first).unwrap();
        let found = executor.check_and_execute(&chunk(Some(&first), &motion[3..]));
        assert_eq!(found.is_ok(), goes_on, "{found:?}");
        let mut plan = plan_in_halves(&motion);
        let mut checked = |executed: bool| {
            plan.executed = executed;
            let ends = [plan.start.clone(), plan.goal.clone()];
            let config = CheckerConfig::default();
            let problem = Problem::of_ends(light(), world(vec![]), config, ends);
            check_plan_in(&plan, std::path::Path::new("/by_hand.json"), &problem).unwrap()
        };
        let report = checked(false);
        assert_eq!(report.is_valid(), goes_on, "{:?}", report.violations().collect::<Vec<_>>());
        if let Some(found) = report.violations().next() {
            let (check, at) = (found.violation.check, found.violation.waypoint);
            assert_eq!((found.phase, check, at), (1, Check::DynamicTorque, 3));
        }
        // A walk that was executed has stops in it, and its torques are not those of the plan.
        assert!(checked(true).is_valid());
    }
}
