use surefoot_shared_types::message::chunk::{FLAG_FIRST, FLAG_LAST};

use super::*;

const ID: u64 = 9;
/// Time between two set-points, s.
const TICK: f64 = 0.001;

/// A chunk of one second, from `sequence` s on, in which joint 0 moves from `sequence` to
/// `sequence + 1` rad. A smooth one moves at 1 rad/s and brakes over 0.2 s.
fn chunk(epoch: u64, sequence: u64, is_last: bool, is_smooth: bool) -> PlanChunk {
    let mut chunk = PlanChunk {
        plan_id: 1,
        epoch,
        sequence,
        flags: if sequence == 0 { FLAG_FIRST } else { 0 } | if is_last { FLAG_LAST } else { 0 },
        mode: (sequence % 2) as u32,
        waypoints_len: 2,
        joints_len: 1,
        contacts_len: 1,
        interpolation: u64::from(is_smooth),
        brake_at: sequence as f64 + if is_smooth && !is_last { 0.9 } else { 1.0 },
        brake_duration: if is_smooth && !is_last { 0.2 } else { 0.0 },
        resume_duration: if is_smooth && !is_last { 0.2 } else { 0.0 },
        ..PlanChunk::zeroed()
    };
    chunk.contacts[0].limb = (sequence % 2) as u32;
    chunk.contacts[0].rotation = [0.0, 0.0, 0.0, 1.0];
    for (at, waypoint) in chunk.waypoints[..2].iter_mut().enumerate() {
        let time = (sequence + at as u64) as f64;
        waypoint.time = time;
        waypoint.root_rotation = [0.0, 0.0, 0.0, 1.0];
        waypoint.q[0] = time;
        if is_smooth {
            waypoint.joint_velocity[0] = 1.0;
        }
    }
    chunk
}

fn accepting(epoch: u64, next_sequence: u64) -> Feedback {
    Feedback { plan_id: 1, epoch, next_sequence, ..Feedback::zeroed() }
}

/// The set-points of `seconds`.
fn play(playback: &mut Playback, seconds: f64) -> Vec<SetPoint> {
    let count = (seconds / TICK).round() as usize;
    (0..count).filter_map(|_| playback.advance(ID, TICK)).collect()
}

#[test]
fn only_accepted_chunks_are_played() {
    let mut playback = Playback::default();
    playback.receive(&chunk(0, 0, false, false));
    playback.receive(&chunk(0, 1, true, false));
    assert_eq!(playback.advance(ID, TICK), None, "nothing is accepted");
    playback.accept(&accepting(0, 1));
    let points = play(&mut playback, 3.0);
    assert_eq!(points.len(), 3000);
    let last = points.last().unwrap();
    assert_eq!((last.waypoint.q[0], last.flags, last.rate), (1.0, FLAG_STARVED, 0.0));
    assert_eq!(last.waypoint.joint_velocity[0], 0.0);
    assert!(playback.is_idle());
    playback.accept(&accepting(0, 2));
    assert!(!playback.is_idle());
    let last = *play(&mut playback, 1.5).last().unwrap();
    assert_eq!((last.waypoint.q[0], last.flags), (2.0, FLAG_FINISHED));
}

#[test]
fn a_smooth_plan_without_a_next_chunk_brakes_and_goes_on() {
    let mut playback = Playback::default();
    for sequence in 0..3 {
        playback.receive(&chunk(0, sequence, sequence == 2, true));
    }
    playback.accept(&accepting(0, 1));
    let starved = play(&mut playback, 2.0);
    let held = *starved.last().unwrap();
    assert!((held.waypoint.q[0] - 1.0).abs() < 1e-9, "{}", held.waypoint.q[0]);
    assert_eq!((held.flags, held.waypoint.joint_velocity[0]), (FLAG_STARVED, 0.0));
    playback.accept(&accepting(0, 3));
    let gone_on = play(&mut playback, 3.0);
    let all: Vec<&SetPoint> = starved.iter().chain(&gone_on).collect();
    for pair in all.windows(2) {
        let step = pair[1].waypoint.q[0] - pair[0].waypoint.q[0];
        assert!((0.0..=1.01 * TICK).contains(&step), "a step of {step} rad");
        let change = pair[1].waypoint.joint_velocity[0] - pair[0].waypoint.joint_velocity[0];
        assert!(change.abs() < 0.02 || pair[1].flags == FLAG_FINISHED, "{change} rad/s in a tick");
    }
    let last = all.last().unwrap();
    assert_eq!((last.waypoint.q[0], last.flags), (3.0, FLAG_FINISHED));
    let counts = playback.counts();
    assert!(counts.missed == 0 && counts.ticks == 5000 && counts.starved_ticks > 500);
}

#[test]
fn a_missed_chunk_stops_the_robot_before_it_and_is_counted() {
    let mut playback = Playback::default();
    playback.receive(&chunk(0, 0, false, false));
    playback.receive(&chunk(0, 2, true, false));
    playback.accept(&accepting(0, 3));
    let last = *play(&mut playback, 2.0).last().unwrap();
    assert_eq!(last.flags, FLAG_STARVED | FLAG_MISSED);
    assert_eq!((last.waypoint.q[0], playback.counts().missed), (1.0, 1));
    // The next epoch begins elsewhere, then one begins where the robot stands.
    let elsewhere = PlanChunk { sequence: 0, epoch: 1, ..chunk(1, 2, true, false) };
    playback.receive(&elsewhere);
    playback.accept(&accepting(1, 1));
    let last = *play(&mut playback, 1.0).last().unwrap();
    assert_eq!((last.waypoint.q[0], last.flags & FLAG_MISSED), (1.0, FLAG_MISSED));
    let there = PlanChunk { sequence: 0, epoch: 2, ..chunk(2, 1, true, false) };
    playback.receive(&there);
    playback.accept(&accepting(2, 1));
    let last = *play(&mut playback, 2.0).last().unwrap();
    assert_eq!((last.waypoint.q[0], last.flags, last.epoch), (2.0, FLAG_FINISHED, 2));
}

#[test]
fn repeated_and_late_chunks_change_nothing() {
    let mut playback = Playback::default();
    for _ in 0..3 {
        playback.receive(&chunk(0, 0, false, false));
    }
    playback.accept(&accepting(0, 1));
    playback.receive(&chunk(0, 0, false, false));
    playback.accept(&accepting(0, 1));
    playback.receive(&chunk(0, 1, true, false));
    playback.accept(&accepting(0, 2));
    let points = play(&mut playback, 2.5);
    let positions: Vec<f64> = points.iter().map(|point| point.waypoint.q[0]).collect();
    assert!(positions.is_sorted() && positions.last() == Some(&2.0));
    assert_eq!((playback.counts().missed, playback.counts().starved_ticks), (0, 0));
    assert!(playback.waiting.is_empty());
}

#[test]
fn the_schedule_holds_where_and_when_a_foot_lands() {
    let mut playback = Playback::default();
    let mut next = chunk(0, 1, true, false);
    next.contacts[0].position = [0.3, 0.1, 0.0];
    playback.receive(&chunk(0, 0, false, false));
    playback.receive(&next);
    playback.accept(&accepting(0, 1));
    let first = playback.advance(ID, TICK).unwrap();
    assert_eq!((first.feet[0].in_contact, first.feet[0].changes_at), (1, -1.0));
    assert_eq!((first.feet[1].in_contact, first.feet[1].has_pose), (0, 0));
    playback.accept(&accepting(0, 2));
    let second = playback.advance(ID, TICK).unwrap();
    assert_eq!((second.feet[0].changes_at, second.feet[1].changes_at), (1.0, 1.0));
    assert_eq!((second.feet[1].has_pose, second.feet[1].position), (1, [0.3, 0.1, 0.0]));
    assert!(second.is_well_formed());
}
