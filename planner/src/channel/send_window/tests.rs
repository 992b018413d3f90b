//! The send window against scripted feedback.

use std::time::Duration;

use bytemuck::Zeroable;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::base::limits::CORRECTIONS_MAX;
use surefoot_shared_types::instance::error::ChannelError;
use surefoot_shared_types::message::feedback::FEEDBACK_SCHEMA;
use surefoot_shared_types::message::{
    Check, Feedback, PlanChunk, Verdict, WithCrc, WorldCorrection,
};

use crate::channel::chunk_source::SourceState;
use crate::channel::send_window::{DeliveryOutcome, SendWindow};
use crate::channel::tuning::{
    CONFIRM_TIME, CONTRADICTIONS_MAX, GO_BACKS_MAX, IDLE_HEARTBEATS, TAKEOVER_SILENCE,
};

pub(super) const SESSION: u64 = 77;

pub(super) fn stream(len: u64) -> Vec<PlanChunk> {
    let mut chunks: Vec<PlanChunk> = Vec::new();
    for sequence in 0..len {
        let stream = chunks.last().map_or(Digest::default(), PlanChunk::stream_after);
        let used = PlanChunk { waypoints_len: 2, ..PlanChunk::zeroed() };
        chunks.push(PlanChunk { plan_id: 1, sequence, stream, ..used });
    }
    chunks
}

pub(super) fn feedback(
    controller_id: u64,
    count: u64,
    accepted: u64,
    chunks: &[PlanChunk],
) -> Feedback {
    let stream = if accepted == 0 {
        Digest::default()
    } else {
        chunks[accepted as usize - 1].stream_after()
    };
    with_crc(Feedback {
        schema: FEEDBACK_SCHEMA,
        controller_id,
        count,
        session: SESSION,
        plan_id: 1,
        next_sequence: accepted,
        stream,
        ..Feedback::zeroed()
    })
}

/// A window over a complete stream.
fn window_over(chunks: &[PlanChunk]) -> SendWindow {
    let mut window = SendWindow::new(SESSION, 8);
    window.extend(chunks, SourceState::Complete).unwrap();
    window
}

/// A time at which every claim is confirmed.
const LATER: Duration = Duration::from_secs(1);

/// Receives feedback while the current controller is not silent.
fn receive(window: &mut SendWindow, feedback: &Feedback) -> bool {
    window.receive(feedback, Duration::ZERO, Duration::ZERO)
}

/// Receives feedback after a silence of the current controller.
fn take_over(window: &mut SendWindow, feedback: &Feedback) -> bool {
    window.receive(feedback, Duration::ZERO, TAKEOVER_SILENCE)
}

fn with_crc(mut feedback: Feedback) -> Feedback {
    feedback.write_crc();
    feedback
}

fn send_all(window: &mut SendWindow) -> Vec<u64> {
    let mut sent = Vec::new();
    while let Some((index, _)) = window.to_send() {
        sent.push(index as u64);
        window.record_sent();
    }
    sent
}

#[test]
fn the_window_waits_for_a_controller_and_never_exceeds_its_size() {
    let chunks = stream(20);
    let mut window = window_over(&chunks);
    assert!(window.to_send().is_none());
    assert!(receive(&mut window, &feedback(5, 1, 0, &chunks)));
    assert_eq!(window.to_send().unwrap().1, 5);
    assert_eq!(send_all(&mut window), (0..8).collect::<Vec<_>>());
    receive(&mut window, &feedback(5, 2, 3, &chunks));
    assert_eq!(send_all(&mut window), [8, 9, 10]);
    receive(&mut window, &feedback(5, 3, 20, &chunks));
    assert_eq!(window.outcome(LATER), Some(DeliveryOutcome::Accepted));
}

#[test]
fn chunks_are_resent_to_an_idle_controller_only() {
    let chunks = stream(4);
    let mut window = window_over(&chunks);
    receive(&mut window, &feedback(5, 1, 0, &chunks));
    send_all(&mut window);
    assert!(!window.go_back(), "a silent controller may be executing chunks");
    receive(&mut window, &feedback(5, 2, 1, &chunks));
    for count in 3..3 + IDLE_HEARTBEATS {
        assert!(!window.go_back());
        receive(&mut window, &feedback(5, count, 1, &chunks));
    }
    assert!(window.go_back());
    assert_eq!(send_all(&mut window), [1, 2, 3]);
    assert_eq!(window.counts(), (7, 3));
}

#[test]
fn a_new_controller_starts_at_its_own_index_and_the_old_one_is_ignored() {
    let chunks = stream(6);
    let mut window = window_over(&chunks);
    receive(&mut window, &feedback(5, 1, 0, &chunks));
    send_all(&mut window);
    receive(&mut window, &feedback(5, 2, 4, &chunks));
    assert!(!receive(&mut window, &feedback(6, 1, 0, &chunks)), "the first one is not silent");
    assert!(take_over(&mut window, &feedback(6, 1, 0, &chunks)));
    assert_eq!(window.acknowledged(), 0);
    assert!(!receive(&mut window, &feedback(5, 3, 6, &chunks)));
    assert_eq!(window.outcome(LATER), None);
    assert_eq!(send_all(&mut window), (0..6).collect::<Vec<_>>());
}

#[test]
fn a_new_planner_continues_the_same_stream_but_not_another_one() {
    let chunks = stream(6);
    let mut foreign = stream(6);
    foreign[2].waypoints[0].time = 1.0;
    for index in 3..6 {
        foreign[index].stream = foreign[index - 1].stream_after();
    }
    let mut window = window_over(&chunks);
    receive(&mut window, &with_crc(Feedback { session: 1, ..feedback(5, 1, 4, &chunks) }));
    assert_eq!(send_all(&mut window), [4, 5]);
    let mut window = window_over(&chunks);
    receive(
        &mut window,
        &with_crc(Feedback { session: 1, finished: 1, ..feedback(5, 1, 6, &foreign) }),
    );
    assert_eq!((window.outcome(LATER), window.acknowledged()), (None, 0));
    assert_eq!(send_all(&mut window), (0..6).collect::<Vec<_>>());
}

#[test]
fn refusals_end_the_delivery_unless_they_are_of_another_session() {
    let chunks = stream(6);
    let refused = |session| {
        with_crc(Feedback {
            verdict: 2,
            check: 3,
            refused_waypoint: 9,
            session,
            ..feedback(5, 1, 0, &chunks)
        })
    };
    let mut window = window_over(&chunks);
    receive(&mut window, &refused(1));
    assert_eq!(window.outcome(LATER), None);
    receive(&mut window, &refused(SESSION));
    assert_eq!(
        window.outcome(LATER),
        Some(DeliveryOutcome::Refused { sequence: 0, check: Check::Collision, waypoint: 9 })
    );
    assert!(window.to_send().is_none());
}

#[test]
fn corrections_of_the_first_chunk_count_for_another_session() {
    let chunks = stream(3);
    let refusal = |check: Check, refused_sequence: u64| {
        with_crc(Feedback {
            session: SESSION + 1,
            verdict: Verdict::Refused as u32,
            check: check as u32,
            refused_sequence,
            corrections_len: 1,
            corrections: [WorldCorrection::missing(0); CORRECTIONS_MAX],
            ..feedback(5, 1, 0, &chunks)
        })
    };
    let outcome = |feedback: &Feedback| {
        let mut window = window_over(&chunks);
        assert!(receive(&mut window, feedback));
        window.outcome(LATER)
    };
    let refused = DeliveryOutcome::Refused { sequence: 0, check: Check::WorldDiffers, waypoint: 0 };
    assert_eq!(outcome(&refusal(Check::WorldDiffers, 0)), Some(refused));
    assert_eq!(outcome(&refusal(Check::World, 0)), None);
    assert_eq!(outcome(&refusal(Check::WorldDiffers, 1)), None);
}

#[test]
fn forged_feedback_does_not_move_the_window() {
    let chunks = stream(6);
    let mut window = window_over(&chunks);
    receive(&mut window, &feedback(5, 1, 2, &chunks));
    let good = feedback(5, 2, 4, &chunks);
    let forgeries = [
        Feedback { next_sequence: 7, ..good },
        Feedback { next_sequence: u64::MAX, ..good },
        Feedback { next_sequence: 3, ..good },
        Feedback { plan_id: 2, ..good },
        Feedback { stream: Digest([9; 32]), ..good },
        Feedback { schema: 0, ..good },
        feedback(5, 2, 1, &chunks),
    ];
    for forgery in &forgeries {
        receive(&mut window, &with_crc(*forgery));
        assert_eq!(window.acknowledged(), 2);
    }
    assert!(!receive(&mut window, &Feedback { next_sequence: 5, ..good }), "a damaged feedback");
    receive(&mut window, &good);
    assert_eq!(window.acknowledged(), 4);
}

#[test]
fn a_broken_stream_is_not_sent() {
    let index_of = |chunks: &[PlanChunk]| match SendWindow::new(SESSION, 8)
        .extend(chunks, SourceState::Complete)
    {
        Err(ChannelError::Stream { index }) => Some(index),
        _ => None,
    };
    assert_eq!(index_of(&[]), Some(0));
    assert_eq!(index_of(&stream(3)[1..]), Some(0));
    let mut chunks = stream(4);
    chunks.swap(1, 2);
    assert_eq!(index_of(&chunks), Some(1));
    let mut chunks = stream(4);
    chunks[2].waypoints[1].time = 3.0;
    assert_eq!(index_of(&chunks), Some(3));
    let mut chunks = stream(4);
    chunks[3].epoch = 1;
    assert_eq!(index_of(&chunks), Some(3));
}

#[test]
fn a_controller_that_never_accepts_counts_as_lost() {
    let chunks = stream(2);
    let mut window = window_over(&chunks);
    let mut go_backs = 0;
    for count in 1.. {
        receive(&mut window, &feedback(5, count, 0, &chunks));
        if window.outcome(LATER).is_some() {
            break;
        }
        send_all(&mut window);
        go_backs += u32::from(window.go_back());
    }
    assert_eq!(
        (window.outcome(LATER), go_backs),
        (Some(DeliveryOutcome::ControllerLost), GO_BACKS_MAX)
    );
}

#[test]
fn a_busy_controller_is_not_idle() {
    let chunks = stream(4);
    let mut window = window_over(&chunks);
    receive(&mut window, &feedback(5, 1, 0, &chunks));
    send_all(&mut window);
    for count in 2..20 {
        receive(&mut window, &with_crc(Feedback { busy: 1, ..feedback(5, count, 0, &chunks) }));
        assert!(!window.go_back());
    }
}

#[test]
fn a_later_epoch_supersedes_the_delivery() {
    let chunks = stream(4);
    let mut window = window_over(&chunks);
    receive(
        &mut window,
        &with_crc(Feedback { epoch: 2, session: 1, ..feedback(5, 1, 3, &chunks) }),
    );
    assert_eq!(window.outcome(LATER), Some(DeliveryOutcome::Superseded));
    assert!(window.to_send().is_none());
}

#[test]
fn a_second_of_motion_is_on_its_way() {
    let mut chunks = stream(20);
    for index in 0..chunks.len() {
        chunks[index].waypoints[0].time = 0.4 * index as f64;
        chunks[index].stream =
            if index == 0 { Digest::default() } else { chunks[index - 1].stream_after() };
    }
    let mut window = window_over(&chunks);
    receive(&mut window, &feedback(5, 1, 0, &chunks));
    assert_eq!(send_all(&mut window), [0, 1, 2]);
    receive(&mut window, &feedback(5, 2, 1, &chunks));
    assert_eq!(send_all(&mut window), [3]);
}

/// A refusal of chunk `accepted`.
fn refusal(count: u64, accepted: u64, chunks: &[PlanChunk]) -> Feedback {
    with_crc(Feedback {
        verdict: Verdict::Refused as u32,
        check: Check::Torque as u32,
        refused_sequence: accepted,
        ..feedback(5, count, accepted, chunks)
    })
}

#[test]
fn a_refusal_that_the_controller_contradicts_does_not_count() {
    let chunks = stream(6);
    let mut window = window_over(&chunks);
    receive(&mut window, &feedback(5, 1, 2, &chunks));
    receive(&mut window, &refusal(2, 2, &chunks));
    assert_eq!(window.outcome(CONFIRM_TIME / 2), None, "not confirmed");
    receive(&mut window, &feedback(5, 2, 3, &chunks));
    assert_eq!((window.outcome(LATER), window.acknowledged()), (None, 3));
    receive(&mut window, &refusal(3, 3, &chunks));
    receive(&mut window, &refusal(4, 3, &chunks));
    let refused = DeliveryOutcome::Refused { sequence: 3, check: Check::Torque, waypoint: 0 };
    assert_eq!(window.outcome(LATER), Some(refused));
}

#[test]
fn a_refusal_of_another_stream_or_chunk_does_not_count() {
    let chunks = stream(6);
    let of = |feedback: Feedback| {
        let mut window = window_over(&chunks);
        receive(&mut window, &with_crc(feedback));
        window.outcome(LATER)
    };
    let good = refusal(1, 2, &chunks);
    assert!(of(good).is_some());
    assert_eq!(of(Feedback { stream: Digest([9; 32]), ..good }), None);
    assert_eq!(of(Feedback { refused_sequence: 4, ..good }), None);
    assert_eq!(of(Feedback { session: SESSION + 1, stream: Digest([9; 32]), ..good }), None);
}

#[test]
fn an_acceptance_that_the_controller_contradicts_is_taken_back() {
    let chunks = stream(6);
    let mut window = window_over(&chunks);
    receive(&mut window, &feedback(5, 1, 2, &chunks));
    send_all(&mut window);
    receive(&mut window, &feedback(5, 2, 6, &chunks));
    assert_eq!(window.outcome(CONFIRM_TIME / 2), None, "not confirmed");
    for count in 2..=4 {
        receive(&mut window, &feedback(5, count + 1, 2, &chunks));
    }
    assert_eq!((window.outcome(LATER), window.acknowledged()), (None, 2));
    assert_eq!(send_all(&mut window), [2, 3, 4, 5]);
}

#[test]
fn two_processes_that_publish_as_the_controller_end_the_delivery() {
    let chunks = stream(6);
    let mut rivals = window_over(&chunks);
    let mut forged = window_over(&chunks);
    for count in 1..=u64::from(CONTRADICTIONS_MAX) {
        receive(&mut rivals, &feedback(5, count, 1, &chunks));
        receive(&mut rivals, &feedback(6, count, 2, &chunks));
        receive(&mut forged, &feedback(5, count, 1, &chunks));
        receive(&mut forged, &refusal(count, 1, &chunks));
    }
    for window in [&mut rivals, &mut forged] {
        receive(window, &feedback(5, 99, 1, &chunks));
        assert_eq!(window.outcome(LATER), Some(DeliveryOutcome::Contradicted));
    }
}

#[test]
fn chunks_are_sent_before_the_stream_is_complete() {
    let chunks = stream(4);
    let mut window = SendWindow::new(SESSION, 8);
    receive(&mut window, &feedback(5, 1, 0, &chunks));
    assert!(send_all(&mut window).is_empty());
    window.extend(&chunks[..2], SourceState::Open).unwrap();
    assert_eq!(send_all(&mut window), [0, 1]);
    receive(&mut window, &feedback(5, 2, 2, &chunks));
    assert_eq!(window.outcome(LATER), None, "more chunks follow");
    window.extend(&chunks, SourceState::Complete).unwrap();
    assert_eq!(send_all(&mut window), [2, 3]);
    receive(&mut window, &feedback(5, 3, 4, &chunks));
    assert_eq!(window.outcome(LATER), Some(DeliveryOutcome::Accepted));
}

#[test]
fn a_stream_that_ends_early_is_delivered_and_incomplete() {
    let chunks = stream(3);
    let mut window = SendWindow::new(SESSION, 8);
    window.extend(&chunks, SourceState::Open).unwrap();
    receive(&mut window, &feedback(5, 1, 0, &chunks));
    window.extend(&chunks, SourceState::Ended).unwrap();
    assert_eq!((send_all(&mut window), window.outcome(LATER)), (vec![0, 1, 2], None));
    receive(&mut window, &feedback(5, 2, 3, &chunks));
    assert_eq!(window.outcome(LATER), Some(DeliveryOutcome::Incomplete));
}

#[test]
fn a_restarted_planner_waits_until_it_has_made_what_the_controller_accepted() {
    let chunks = stream(6);
    let mut window = SendWindow::new(SESSION, 8);
    window.extend(&chunks[..1], SourceState::Open).unwrap();
    let of_predecessor =
        |count| with_crc(Feedback { session: 1, ..feedback(5, count, 4, &chunks) });
    receive(&mut window, &of_predecessor(1));
    assert!(send_all(&mut window).is_empty(), "the controller has it already");
    window.extend(&chunks[..5], SourceState::Open).unwrap();
    receive(&mut window, &of_predecessor(2));
    assert_eq!((window.acknowledged(), send_all(&mut window)), (4, vec![4]));
    // A plan of the same name with fewer chunks is another one: it is sent from its beginning.
    let mut other = SendWindow::new(SESSION, 8);
    other.extend(&chunks[..3], SourceState::Open).unwrap();
    receive(&mut other, &of_predecessor(1));
    other.extend(&chunks[..3], SourceState::Complete).unwrap();
    receive(&mut other, &of_predecessor(2));
    assert_eq!(send_all(&mut other), [0, 1, 2]);
}
