//! The transport beside other processes that publish chunks and feedback of their own: who sent a
//! message decides whether it counts, whatever it contains.

#![allow(clippy::unwrap_used, reason = "a transport that cannot be opened fails the test")]

#[path = "common/chunk_stream.rs"]
mod chunk_stream;
#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/delivery.rs"]
mod delivery;
#[path = "common/private_folder.rs"]
mod private_folder;

use std::fs;
use std::sync::Barrier;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use bytemuck::Zeroable;
use chunk_stream::plan;
use delivery::{TestInstance, accept_all, chunk_publisher, deliver, receive_after, wait_for};
use iceoryx2::port::publisher::Publisher;
use iceoryx2::prelude::ipc;
use surefoot_controller_sim::channel::plan_subscriber::{ChunkDecision, PlanSubscriber, StreamEnd};
use surefoot_planner::channel::plan_publisher::{Delivery, PlanPublisher};
use surefoot_planner::channel::send_window::DeliveryOutcome;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::observer::Observer;
use surefoot_shared_types::instance::participant::Participant;
use surefoot_shared_types::instance::sender::random_id;
use surefoot_shared_types::message::{Check, Feedback, Margins, PlanChunk, Verdict, WithCrc};

/// A controller that accepts each chunk only after another process has sent one more of them,
/// damaged.
#[test]
fn a_process_that_forges_damaged_chunks_holds_up_no_delivery() {
    let (test_instance, chunks) = (TestInstance::new(), plan(100));
    let (over, forged) = (AtomicBool::new(false), AtomicUsize::new(0));
    let [to, from, beside] = [(); 3].map(|()| test_instance.attach());
    let (delivery, (ended, seen, stats)) = std::thread::scope(|scope| {
        scope.spawn(|| {
            let (_participant, publisher) = chunk_publisher(&beside);
            for chunk in chunks.iter().cycle().take_while(|_| !over.load(Ordering::Relaxed)) {
                publisher.send_copy(PlanChunk { crc: !chunk.crc, ..*chunk }).unwrap();
                forged.fetch_add(1, Ordering::Relaxed);
                std::thread::sleep(Duration::from_millis(1));
            }
        });
        let controller = scope.spawn(|| {
            receive_after(&from, |_| wait_for(&forged, forged.load(Ordering::Relaxed) + 1))
        });
        let delivery = deliver(&to, &chunks);
        let received = controller.join().unwrap();
        over.store(true, Ordering::Relaxed);
        (delivery, received)
    });
    drop((to, from, beside));
    assert_eq!((delivery.outcome, ended), (DeliveryOutcome::Accepted, StreamEnd::Finished));
    assert_eq!(seen, (0..100).collect::<Vec<_>>());
    assert!(stats.other_senders > 20 && stats.accepted == 100, "{stats:?}");
    test_instance.close();
}

/// What a forger makes of a chunk of the planner: the next one, of another motion; the same one,
/// again; the first one of a plan of its own. All have the planner's session, or one that was never
/// seen, and the right CRC.
fn forged(chunk: &PlanChunk) -> [PlanChunk; 3] {
    let mut next = PlanChunk { sequence: chunk.sequence + 1, ..*chunk };
    next.stream = chunk.stream_after();
    next.waypoints[0].time = FORGED_TIME;
    let first = PlanChunk { session: 77, plan_id: chunk.plan_id + 1, sequence: 0, ..next };
    [next, *chunk, first].map(|mut chunk| {
        chunk.write_crc();
        chunk
    })
}

/// Time of the first waypoint of forged chunks, s.
const FORGED_TIME: f64 = 1e3;

/// Sends what [`forged`] makes of every chunk that arrives, until `over` is set, and counts those
/// that a reader received.
fn forge_chunks(instance: &Instance, over: &AtomicBool, is_open: &Barrier, sent: &AtomicUsize) {
    let observer = Observer::open(instance).unwrap();
    let (_participant, publisher) = chunk_publisher(instance);
    is_open.wait();
    while !over.load(Ordering::Relaxed) {
        let Some(chunk) = observer.chunk().unwrap() else { continue };
        assert!(chunk.waypoints[0].time != FORGED_TIME, "observers skip forged chunks, too");
        for chunk in forged(&chunk) {
            let has_reader = publisher.send_copy(chunk).is_ok_and(|readers| readers > 0);
            sent.fetch_add(usize::from(has_reader), Ordering::Relaxed);
        }
    }
}

/// A process that knows the session answers the planner's chunks; the controller waits for 30 of
/// its own.
#[test]
fn chunks_that_the_planner_did_not_send_are_dropped_whatever_they_contain() {
    let (test_instance, chunks) = (TestInstance::new(), plan(100));
    let (over, is_open, sent) = (AtomicBool::new(false), Barrier::new(2), AtomicUsize::new(0));
    let [to, from, beside] = [(); 3].map(|()| test_instance.attach());
    let (delivery, (checked, stats)) = std::thread::scope(|scope| {
        scope.spawn(|| forge_chunks(&beside, &over, &is_open, &sent));
        let controller = scope.spawn(|| {
            let mut subscriber = PlanSubscriber::open(&from, random_id()).unwrap();
            let mut checked = Vec::new();
            let mut check_chunk = |chunk: &PlanChunk, _: &mut dyn FnMut()| {
                wait_for(&sent, chunk.sequence.min(30) as usize);
                checked.push((chunk.sequence, chunk.waypoints[0].time == FORGED_TIME));
                ChunkDecision::Accepted(Margins::UNMEASURED, chunk.stream_after())
            };
            let is_going = || !over.load(Ordering::Relaxed);
            while is_going() {
                subscriber.run(&mut check_chunk, &is_going).unwrap();
                subscriber.linger(&mut check_chunk, None, &is_going).unwrap();
            }
            (checked, subscriber.stats())
        });
        is_open.wait();
        let delivery = deliver(&to, &chunks);
        over.store(true, Ordering::Relaxed);
        (delivery, controller.join().unwrap())
    });
    drop((to, from, beside));
    assert_eq!(delivery.outcome, DeliveryOutcome::Accepted);
    assert_eq!(checked, (0..100).map(|sequence| (sequence, false)).collect::<Vec<_>>());
    assert!(sent.into_inner() > 20 && stats.other_senders > 20, "{stats:?}");
    test_instance.close();
}

/// Whenever the controller looks, another chunk has arrived that it drops.
#[test]
fn a_flood_of_dropped_chunks_delays_no_heartbeat() {
    let (test_instance, chunk) = (TestInstance::new(), plan(1)[0]);
    let (instance, beside) = (test_instance.attach(), test_instance.attach());
    let (participant, publisher) = chunk_publisher(&beside);
    let mut subscriber = PlanSubscriber::open(&instance, random_id()).unwrap();
    let mut check_chunk = |_: &PlanChunk, _: &mut dyn FnMut()| panic!("none is for it");
    let sent = AtomicUsize::new(0);
    let keep_going = || {
        publisher.send_copy(chunk).unwrap();
        sent.fetch_add(1, Ordering::Relaxed) < 10_000
    };
    subscriber.run(&mut check_chunk, &keep_going).unwrap();
    let (heartbeats, stats) = (subscriber.feedback().count, subscriber.stats());
    println!("{heartbeats} heartbeats, {stats:?}");
    assert!(heartbeats > 5 && stats.received >= 10_000, "{heartbeats} heartbeats, {stats:?}");
    drop((publisher, participant, subscriber, instance, beside));
    test_instance.close();
}

/// Ports for a process that forges feedback: an observer of all messages, and a publisher.
struct Forger {
    observer: Observer,
    publisher: Publisher<ipc::Service, Feedback, ()>,
    _participant: Participant,
}

impl Forger {
    fn open(instance: &Instance) -> Self {
        let observer = Observer::open(instance).unwrap();
        let participant = Participant::open(instance).unwrap();
        let making = participant.making().unwrap();
        let publisher = participant.feedback.publisher_builder().create().unwrap();
        drop(making);
        Self { observer, publisher, _participant: participant }
    }

    /// Publishes what `forge` makes of every feedback that it receives, until `over` is set.
    fn run(&self, over: &AtomicBool, mut forge: impl FnMut(&Feedback) -> Option<Feedback>) {
        while !over.load(Ordering::Relaxed) {
            while let Some(feedback) = self.observer.feedback().unwrap() {
                if let Some(mut forged) = forge(&feedback) {
                    forged.write_crc();
                    self.publisher.send_copy(forged).unwrap();
                }
            }
            std::thread::sleep(Duration::from_micros(200));
        }
    }
}

/// Whether the controller names its publisher, as ours does. One of another program need not.
#[derive(Clone, Copy, PartialEq)]
enum Controller {
    Named,
    Unnamed,
}

/// Delivers `chunks` to a controller that takes 2 ms for each, while another process forges
/// feedback; returns the delivery and the chunks that the controller checked. All ports exist
/// before the first message: iceoryx2 does not repeat a connection that fails, and of the three
/// processes only planner and controller make their ports anew.
fn deliver_beside(
    chunks: &[PlanChunk],
    controller: Controller,
    forging: impl FnMut(&Feedback) -> Option<Feedback> + Send,
) -> (Delivery, Vec<u64>) {
    let test_instance = TestInstance::new();
    let (over, all_open) = (AtomicBool::new(false), Barrier::new(3));
    let found = std::thread::scope(|scope| {
        let [to, from, beside] = [(); 3].map(|()| test_instance.attach());
        let (over, all_open) = (&over, &all_open);
        scope.spawn(move || {
            let forger = Forger::open(&beside);
            all_open.wait();
            forger.run(over, forging);
        });
        let controller = scope.spawn(move || {
            let mut seen = Vec::new();
            let mut subscriber = PlanSubscriber::open(&from, random_id()).unwrap();
            if controller == Controller::Unnamed {
                let named = fs::File::options().write(true).open(from.root().join("controller"));
                named.unwrap().set_len(0).unwrap();
            }
            all_open.wait();
            let mut check_chunk = accept_all(&mut seen, Duration::from_millis(2));
            let is_going = || !over.load(Ordering::Relaxed);
            while is_going() {
                subscriber.run(&mut check_chunk, &is_going).unwrap();
                subscriber.linger(&mut check_chunk, None, &is_going).unwrap();
            }
            drop(check_chunk);
            seen
        });
        let mut publisher = PlanPublisher::open(&to, random_id()).unwrap();
        all_open.wait();
        let delivery = publisher.deliver(chunks, &mut |_| {}, &|| true).unwrap();
        drop(publisher);
        over.store(true, Ordering::Relaxed);
        (delivery, controller.join().unwrap())
    });
    test_instance.close();
    found
}

/// What a forger makes of the controller's feedback: a refusal, the acceptance of a whole plan that
/// ends with the digest `end`, a later epoch, and the feedback of another controller.
fn forged_feedback(feedback: &Feedback, chunks: u64, end: Digest) -> [Feedback; 4] {
    let lie = Feedback { count: feedback.count + 1, gaps: FORGED_GAPS, ..*feedback };
    let (verdict, check) = (Verdict::Refused as u32, Check::Torque as u32);
    let (sequence, walk) = (lie.next_sequence, Feedback { next_sequence: chunks, ..lie });
    [
        Feedback { verdict, check, refused_sequence: sequence, refused_waypoint: 1, ..lie },
        Feedback { stream: end, finished: 1, ..walk },
        Feedback { epoch: lie.epoch + 1, ..lie },
        Feedback { controller_id: 99, ..lie },
    ]
}

/// The count of gaps in forged feedback.
const FORGED_GAPS: u64 = 1 << 40;

/// Every message of the controller is answered by a forged one, each claim in turn for 20 of them,
/// so that it is repeated more often than a claim needs.
#[test]
fn feedback_that_the_controller_did_not_send_is_dropped_whatever_it_contains() {
    let chunks = plan(200);
    let end = chunks[199].stream_after();
    let mut forged = 0;
    let (delivery, seen) = deliver_beside(&chunks, Controller::Named, |feedback| {
        assert!(feedback.gaps < FORGED_GAPS, "observers skip forged feedback, too");
        forged += 1;
        (feedback.session != 0).then(|| forged_feedback(feedback, 200, end)[forged / 20 % 4])
    });
    let Delivery { outcome, accepted, other_senders, .. } = delivery;
    assert_eq!((outcome, accepted), (DeliveryOutcome::Accepted, 200));
    assert!(other_senders > 10, "{other_senders} of {forged} dropped");
    assert_eq!(delivery.feedback.map(|feedback| feedback.gaps < FORGED_GAPS), Some(true));
    assert_eq!(seen, (0..200).collect::<Vec<_>>());
}

/// A process that publishes forged feedback as fast as it can; the controller accepts each chunk
/// only after one more of its messages.
#[test]
fn a_flood_of_forged_feedback_delays_no_delivery() {
    let (test_instance, chunks) = (TestInstance::new(), plan(200));
    let (over, is_open, sent) = (AtomicBool::new(false), Barrier::new(2), AtomicUsize::new(0));
    let [to, from, beside] = [(); 3].map(|()| test_instance.attach());
    let (delivery, seen) = std::thread::scope(|scope| {
        scope.spawn(|| {
            let forger = Forger::open(&beside);
            is_open.wait();
            while !over.load(Ordering::Relaxed) {
                forger.publisher.send_copy(Feedback::zeroed()).unwrap();
                sent.fetch_add(1, Ordering::Relaxed);
            }
        });
        is_open.wait();
        let controller = scope
            .spawn(|| receive_after(&from, |_| wait_for(&sent, sent.load(Ordering::Relaxed) + 1)));
        let mut planner = PlanPublisher::open(&to, random_id()).unwrap();
        planner.set_window_chunks(1);
        let delivery = planner.deliver(&chunks, &mut |_| {}, &|| true).unwrap();
        drop(planner);
        over.store(true, Ordering::Relaxed);
        (delivery, controller.join().unwrap().1)
    });
    drop((to, from, beside));
    assert_eq!((delivery.outcome, seen.len()), (DeliveryOutcome::Accepted, 200));
    assert!(delivery.other_senders > 100, "{} dropped", delivery.other_senders);
    test_instance.close();
}

/// The planner leaves after three chunks of five, while another process has a publisher of chunks
/// open.
#[test]
fn another_publisher_does_not_hide_that_the_planner_left() {
    let (test_instance, chunks) = (TestInstance::new(), plan(5));
    let beside = test_instance.attach();
    let (participant, publisher) = chunk_publisher(&beside);
    let (ended, lingered) = std::thread::scope(|scope| {
        let (to, from) = (test_instance.attach(), test_instance.attach());
        let controller = scope.spawn(move || {
            let mut subscriber = PlanSubscriber::open(&from, random_id()).unwrap();
            let mut seen = Vec::new();
            let mut check_chunk = accept_all(&mut seen, Duration::ZERO);
            let ended = subscriber.run(&mut check_chunk, &|| true).unwrap();
            // Without bound it lingers as long as a planner is attached.
            let longest = Some(Duration::from_secs(3600));
            (ended, subscriber.linger(&mut check_chunk, longest, &|| true).unwrap())
        });
        let mut planner = PlanPublisher::open(&to, random_id()).unwrap();
        let accepted = AtomicUsize::new(0);
        let progress = &mut |feedback: &Feedback| {
            accepted.store(feedback.next_sequence as usize, Ordering::Relaxed);
        };
        let is_going = || accepted.load(Ordering::Relaxed) < 3;
        planner.set_window_chunks(1);
        let delivery = planner.deliver(&chunks, progress, &is_going).unwrap();
        assert_eq!(delivery.outcome, DeliveryOutcome::Stopped);
        drop(planner);
        controller.join().unwrap()
    });
    assert_eq!((ended, lingered), (StreamEnd::PlannerLeft, None));
    drop((publisher, participant, beside));
    test_instance.close();
}

#[test]
fn a_forged_refusal_and_a_forged_acceptance_do_not_mislead() {
    let chunks = plan(60);
    let end = chunks[59].stream_after();
    let mut forged = 0;
    let (delivery, seen) = deliver_beside(&chunks, Controller::Unnamed, |feedback| {
        let next = feedback.next_sequence;
        if next < 10 * (forged + 1) || next > 50 || feedback.verdict == Verdict::Refused as u32 {
            return None;
        }
        forged += 1;
        let mut lie = *feedback;
        if forged % 2 == 1 {
            (lie.verdict, lie.check) = (Verdict::Refused as u32, Check::Torque as u32);
            (lie.refused_sequence, lie.refused_waypoint) = (next, 1);
        } else {
            (lie.next_sequence, lie.finished, lie.stream) = (60, 1, end);
        }
        Some(lie)
    });
    assert!(forged > 1, "{forged} messages were forged");
    assert_eq!((delivery.outcome, delivery.accepted), (DeliveryOutcome::Accepted, 60));
    assert_eq!(seen, (0..60).collect::<Vec<_>>());
}

#[test]
fn a_second_process_that_answers_as_the_controller_ends_the_delivery() {
    let chunks = plan(2000);
    let (delivery, seen) = deliver_beside(&chunks, Controller::Unnamed, |feedback| {
        let is_ours = feedback.controller_id == 99;
        (!is_ours).then_some(Feedback { controller_id: 99, ..*feedback })
    });
    assert_eq!(delivery.outcome, DeliveryOutcome::Contradicted);
    assert_eq!(seen, (0..seen.len() as u64).collect::<Vec<_>>(), "none lost, none twice");
}
