//! The transport end to end: both ends in one process, on two threads, over real shared memory.
//!
//! What must hold: every chunk is judged exactly once per controller instance, in order, whoever is
//! restarted and however slow the controller is; damage is refused; nothing stays behind.

#![allow(clippy::unwrap_used, reason = "a test ends where the transport cannot be opened")]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use bytemuck::Zeroable;
use surefoot_controller_sim::channel::{ChunkReceiver, Ended, Judgement, Refusal, Tally};
use surefoot_planner::channel::{ChannelError, ChunkSender, Delivery, Outcome};
use surefoot_shared_types::digest::Digest;
use surefoot_shared_types::instance::{Instance, Link, draw_id};
use surefoot_shared_types::message::chunk::{CHUNK_SCHEMA, FLAG_FIRST, FLAG_LAST};
use surefoot_shared_types::message::{Check, Margins, PlanChunk, Sealed, Waypoint};

/// An instance in a folder of its own; checks at the end that nothing is left.
struct Room {
    base: tempfile::TempDir,
    instance: Option<Instance>,
}

impl Room {
    fn new() -> Self {
        let private = fs::Permissions::from_mode(0o700);
        let base = tempfile::Builder::new()
            .prefix("sf-test")
            .permissions(private)
            .tempdir_in("/dev/shm")
            .unwrap();
        let instance = Instance::create_in(base.path(), "transport").unwrap();
        Self { base, instance: Some(instance) }
    }

    /// Another handle, as another process would get it.
    fn enter(&self) -> Instance {
        Instance::attach_in(self.base.path(), "transport").unwrap()
    }

    fn close(mut self) {
        let prefix = self.instance.as_ref().unwrap().segment_prefix().to_owned();
        self.instance = None;
        let segments = fs::read_dir("/dev/shm")
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap());
        assert_eq!(
            segments.filter(|name| name.starts_with(&prefix)).count(),
            0,
            "segments left behind"
        );
        assert!(!self.base.path().join("transport").exists(), "root left behind");
    }
}

fn plan(len: u64) -> Vec<PlanChunk> {
    let mut chunks: Vec<PlanChunk> = Vec::new();
    for sequence in 0..len {
        let stream = chunks.last().map_or(Digest::default(), PlanChunk::stream_after);
        let mut chunk =
            PlanChunk { schema: CHUNK_SCHEMA, plan_id: 1, sequence, stream, ..PlanChunk::zeroed() };
        chunk.flags = if sequence == 0 { FLAG_FIRST } else { 0 }
            | if sequence + 1 == len { FLAG_LAST } else { 0 };
        chunk.waypoints_len = 2;
        chunk.waypoints[1] = Waypoint { time: sequence as f64 + 1.0, ..chunk.waypoints[1] };
        chunks.push(chunk);
    }
    chunks
}

/// A judge that accepts everything after `time_per_chunk` and notes the sequence numbers.
fn accept_all(
    seen: &mut Vec<u64>,
    time_per_chunk: Duration,
) -> impl FnMut(&PlanChunk, &mut dyn FnMut()) -> Judgement {
    move |chunk, _| {
        std::thread::sleep(time_per_chunk);
        seen.push(chunk.sequence);
        Judgement::Accepted(Margins { balance: 0.5, ..Margins::UNMEASURED }, chunk.stream_after())
    }
}

/// Repeats the last word until the planner has left. Nothing more is walked.
fn linger(receiver: &mut ChunkReceiver) {
    let mut judge = |_: &PlanChunk, _: &mut dyn FnMut()| panic!("a chunk after the end");
    assert_eq!(receiver.linger(&mut judge, Some(Duration::from_secs(20)), &|| true).unwrap(), None);
}

fn deliver(instance: &Instance, chunks: &[PlanChunk]) -> Delivery {
    let mut sender = ChunkSender::open(instance, draw_id()).unwrap();
    sender.deliver(chunks, &mut |_| {}, &|| true).unwrap()
}

/// Runs a receiver to the end of the plan; returns what it judged.
fn receive(instance: &Instance, time_per_chunk: Duration) -> (Ended, Vec<u64>, Tally) {
    let mut receiver = ChunkReceiver::open(instance, draw_id()).unwrap();
    let mut seen = Vec::new();
    let mut judge = accept_all(&mut seen, time_per_chunk);
    let mut ended = Ended::Left;
    while ended == Ended::Left {
        ended = receiver.run(&mut judge, &|| true).unwrap();
    }
    drop(judge);
    linger(&mut receiver);
    (ended, seen, receiver.tally())
}

#[test]
fn five_hundred_chunks_reach_a_slow_controller_in_order_once_each() {
    let room = Room::new();
    let chunks = plan(500);
    let (delivery, (ended, seen, tally)) = std::thread::scope(|scope| {
        let (to, from) = (room.enter(), room.enter());
        let controller = scope.spawn(move || receive(&from, Duration::from_micros(500)));
        let delivery = deliver(&to, &chunks);
        (delivery, controller.join().unwrap())
    });
    assert_eq!(
        (delivery.outcome, delivery.accepted, ended),
        (Outcome::Accepted, 500, Ended::Finished)
    );
    assert_eq!(seen, (0..500).collect::<Vec<_>>());
    assert_eq!(delivery.feedback.unwrap().margins.balance, 0.5);
    assert_eq!(tally.accepted, 500);
    println!("sent {} resent {} {tally:?}", delivery.sent, delivery.resent);
    room.close();
}

#[test]
fn lost_and_late_words_lose_no_chunk() {
    let room = Room::new();
    let chunks = plan(300);
    let (delivery, seen) = std::thread::scope(|scope| {
        let (to, from) = (room.enter(), room.enter());
        let controller = scope.spawn(move || {
            let mut receiver = ChunkReceiver::open(&from, draw_id()).unwrap();
            receiver.disturb_words(11);
            let mut seen = Vec::new();
            let mut judge = accept_all(&mut seen, Duration::from_micros(100));
            while receiver.run(&mut judge, &|| true).unwrap() != Ended::Finished {}
            drop(judge);
            linger(&mut receiver);
            seen
        });
        let delivery = deliver(&to, &chunks);
        (delivery, controller.join().unwrap())
    });
    assert_eq!((delivery.outcome, delivery.accepted), (Outcome::Accepted, 300));
    assert_eq!(seen, (0..300).collect::<Vec<_>>());
    room.close();
}

#[test]
fn a_controller_slower_than_the_resend_time_gets_nothing_twice() {
    let room = Room::new();
    let chunks = plan(20);
    let (delivery, (_, seen, tally)) = std::thread::scope(|scope| {
        let (to, from) = (room.enter(), room.enter());
        let controller = scope.spawn(move || receive(&from, Duration::from_millis(60)));
        let delivery = deliver(&to, &chunks);
        (delivery, controller.join().unwrap())
    });
    assert_eq!((delivery.outcome, seen.len()), (Outcome::Accepted, 20));
    assert_eq!((tally.duplicates, tally.gaps), (0, 0), "{delivery:?}");
    room.close();
}

#[test]
fn restarted_controllers_go_on_where_the_robot_stands() {
    let room = Room::new();
    let chunks = plan(200);
    let (delivery, lives) = std::thread::scope(|scope| {
        let (to, from) = (room.enter(), room.enter());
        let controllers = scope.spawn(move || {
            let mut lives = Vec::new();
            for life in [37, 1, 8, 120] {
                let mut seen = Vec::new();
                let judged = AtomicUsize::new(0);
                let mut receiver = ChunkReceiver::open(&from, draw_id()).unwrap();
                let mut accept = accept_all(&mut seen, Duration::ZERO);
                let mut judge = |chunk: &PlanChunk, alive: &mut dyn FnMut()| {
                    judged.fetch_add(1, Ordering::Relaxed);
                    accept(chunk, alive)
                };
                let ended =
                    receiver.run(&mut judge, &|| judged.load(Ordering::Relaxed) < life).unwrap();
                assert_eq!(ended, Ended::Stopped);
                drop((receiver, accept));
                lives.push(seen);
            }
            lives.push(receive(&from, Duration::ZERO).1);
            lives
        });
        (deliver(&to, &chunks), controllers.join().unwrap())
    });
    assert_eq!(delivery.outcome, Outcome::Accepted);
    let lengths: Vec<usize> = lives.iter().map(Vec::len).collect();
    assert_eq!(lengths, [37, 1, 8, 120, 34]);
    assert_eq!(
        lives.concat(),
        (0..200).collect::<Vec<_>>(),
        "contiguous, once each, over all controllers"
    );
    assert_eq!(delivery.feedback.unwrap().walked, 200);
    room.close();
}

#[test]
fn restarted_planners_go_on_where_the_controller_stands() {
    let room = Room::new();
    let chunks = plan(200);
    let (deliveries, (ended, seen, tally)) = std::thread::scope(|scope| {
        let (to, from) = (room.enter(), room.enter());
        let controller = scope.spawn(move || receive(&from, Duration::from_micros(200)));
        let mut deliveries = Vec::new();
        for life in [5, 60, 61, 150, 1000] {
            let accepted = AtomicUsize::new(0);
            let mut sender = ChunkSender::open(&to, draw_id()).unwrap();
            let mut note = |word: &surefoot_shared_types::message::Feedback| {
                accepted.store(word.next_sequence as usize, Ordering::Relaxed)
            };
            deliveries.push(
                sender
                    .deliver(&chunks, &mut note, &|| accepted.load(Ordering::Relaxed) < life)
                    .unwrap(),
            );
        }
        (deliveries, controller.join().unwrap())
    });
    assert_eq!(ended, Ended::Finished);
    assert_eq!(seen, (0..200).collect::<Vec<_>>(), "contiguous, once each, over all planners");
    assert_eq!(
        deliveries.iter().filter(|delivery| delivery.outcome == Outcome::Stopped).count(),
        4
    );
    assert_eq!(deliveries.last().unwrap().outcome, Outcome::Accepted);
    println!("{tally:?}");
    room.close();
}

#[test]
fn a_finished_plan_is_not_walked_again_for_a_new_planner_but_another_plan_is() {
    let room = Room::new();
    let chunks = plan(10);
    let mut other = plan(10);
    other[0].waypoints[0].time = -1.0;
    for index in 1..other.len() {
        other[index].stream = other[index - 1].stream_after();
    }
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let (to, from) = (room.enter(), room.enter());
        let stop = &stop;
        let controller = scope.spawn(move || {
            let mut seen = Vec::new();
            let mut receiver = ChunkReceiver::open(&from, draw_id()).unwrap();
            let mut judge = accept_all(&mut seen, Duration::ZERO);
            while receiver.run(&mut judge, &|| !stop.load(Ordering::Relaxed)).unwrap()
                != Ended::Stopped
            {}
            drop(judge);
            seen
        });
        assert_eq!(deliver(&to, &chunks).outcome, Outcome::Accepted);
        let again = deliver(&to, &chunks);
        assert_eq!((again.outcome, again.sent), (Outcome::Accepted, 0));
        let replaced = deliver(&to, &other);
        assert_eq!((replaced.outcome, replaced.accepted), (Outcome::Accepted, 10));
        stop.store(true, Ordering::Relaxed);
        assert_eq!(controller.join().unwrap(), (0..10).chain(0..10).collect::<Vec<_>>());
    });
    room.close();
}

#[test]
fn a_refusal_ends_the_delivery_with_its_reason() {
    let room = Room::new();
    let chunks = plan(30);
    let (delivery, ended) = std::thread::scope(|scope| {
        let (to, from) = (room.enter(), room.enter());
        let controller = scope.spawn(move || {
            let mut receiver = ChunkReceiver::open(&from, draw_id()).unwrap();
            let mut judge = |chunk: &PlanChunk, _: &mut dyn FnMut()| match chunk.sequence {
                17 => Judgement::Refused { check: Check::Balance, waypoint: 3, correction: None },
                _ => Judgement::Accepted(Margins::UNMEASURED, chunk.stream_after()),
            };
            let ended = receiver.run(&mut judge, &|| true).unwrap();
            linger(&mut receiver);
            ended
        });
        (deliver(&to, &chunks), controller.join().unwrap())
    });
    assert_eq!(ended, Ended::Refused(Refusal { sequence: 17, check: Check::Balance, waypoint: 3 }));
    assert_eq!(
        delivery.outcome,
        Outcome::Refused { sequence: 17, check: Check::Balance, waypoint: 3 }
    );
    assert_eq!(delivery.accepted, 17);
    room.close();
}

#[test]
fn damaged_chunks_are_refused_over_shared_memory() {
    let room = Room::new();
    let instance = room.enter();
    let header_bits = (0..8 * std::mem::offset_of!(PlanChunk, contacts)).step_by(5);
    let body_bits =
        (8 * std::mem::offset_of!(PlanChunk, contacts)..8 * size_of::<PlanChunk>()).step_by(4001);
    let link = Link::open(&instance).unwrap();
    let publisher = link.chunks.publisher_builder().create().unwrap();
    for bit in header_bits.chain(body_bits) {
        let id = draw_id();
        fs::remove_file(instance.root().join("robot")).unwrap_or_default();
        let mut receiver = ChunkReceiver::open(&instance, id).unwrap();
        let mut chunk = plan(1)[0];
        (chunk.session, chunk.target_instance) = (1, id);
        chunk.seal();
        bytemuck::bytes_of_mut(&mut chunk)[bit / 8] ^= 1 << (bit % 8);
        publisher.send_copy(chunk).unwrap();
        let mut judge =
            |_: &PlanChunk, _: &mut dyn FnMut()| panic!("a damaged chunk reached the judge");
        let ended = receiver.run(&mut judge, &|| true).unwrap();
        assert_eq!(
            ended,
            Ended::Refused(Refusal { sequence: 0, check: Check::Crc, waypoint: 0 }),
            "bit {bit}"
        );
    }
    drop((publisher, link, instance));
    room.close();
}

#[test]
fn without_a_controller_the_delivery_ends_honestly() {
    let room = Room::new();
    let instance = room.enter();
    let chunks = plan(3);
    let mut sender = ChunkSender::open(&instance, draw_id()).unwrap();
    assert_eq!(sender.deliver(&chunks, &mut |_| {}, &|| false).unwrap().outcome, Outcome::Stopped);
    sender.set_lost_after(Duration::from_millis(50));
    let delivery = sender.deliver(&chunks, &mut |_| {}, &|| true).unwrap();
    assert_eq!(
        (delivery.outcome, delivery.sent, delivery.feedback),
        (Outcome::ControllerLost, 0, None)
    );
    assert!(matches!(
        sender.deliver(&chunks[1..], &mut |_| {}, &|| true),
        Err(ChannelError::Stream { index: 0 })
    ));
    assert!(matches!(ChunkSender::open(&instance, 0), Err(ChannelError::Id)));
    drop((sender, instance));
    room.close();
}

#[test]
fn a_reader_that_never_reads_does_not_hold_up_the_walk() {
    let room = Room::new();
    let logger = Link::open(&room.enter()).unwrap();
    let stuck = logger.chunks.subscriber_builder().create().unwrap();
    let chunks = plan(100);
    let (delivery, (_, seen, _)) = std::thread::scope(|scope| {
        let (to, from) = (room.enter(), room.enter());
        let controller = scope.spawn(move || receive(&from, Duration::ZERO));
        (deliver(&to, &chunks), controller.join().unwrap())
    });
    assert_eq!((delivery.outcome, seen.len()), (Outcome::Accepted, 100));
    drop((stuck, logger));
    room.close();
}
