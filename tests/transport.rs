//! The transport end to end: publisher and subscriber on two threads of one process, over shared
//! memory.
//!
//! Every chunk is checked exactly once and in order, after restarts of either side and with a slow
//! controller. Damaged chunks are refused. No shared memory remains.

#![allow(clippy::unwrap_used, reason = "a transport that cannot be opened fails the test")]

#[path = "common/chunk_stream.rs"]
mod chunk_stream;
#[path = "common/private_folder.rs"]
mod private_folder;

use std::fs;
use std::sync::Barrier;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use bytemuck::Zeroable;
use chunk_stream::plan;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::prelude::{BackpressureStrategy, ipc};
use private_folder::private_folder;
use surefoot_controller_sim::channel::plan_subscriber::{ChunkDecision, PlanSubscriber, StreamEnd};
use surefoot_controller_sim::channel::{ReceiverStats, Refusal};
use surefoot_planner::channel::plan_publisher::{Delivery, PlanPublisher};
use surefoot_planner::channel::send_window::DeliveryOutcome;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::instance::error::ChannelError;
use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::observer::Observer;
use surefoot_shared_types::instance::participant::Participant;
use surefoot_shared_types::instance::sender::random_id;
use surefoot_shared_types::message::{Check, Feedback, Margins, PlanChunk, Verdict, WithCrc};

/// An instance in a folder of its own. [`TestInstance::close`] checks that no shared memory
/// remains.
struct TestInstance {
    base: tempfile::TempDir,
    instance: Option<Instance>,
}

impl TestInstance {
    fn new() -> Self {
        let base = private_folder("sf-test");
        let instance = Instance::create_in(base.path(), "transport").unwrap();
        Self { base, instance: Some(instance) }
    }

    /// Another handle on the instance, as in another process.
    fn attach(&self) -> Instance {
        Instance::attach_in(self.base.path(), "transport").unwrap()
    }

    fn close(mut self) {
        let prefix = self.instance.as_ref().unwrap().segment_prefix().to_owned();
        self.instance = None;
        let segments = fs::read_dir("/dev/shm")
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap());
        assert_eq!(segments.filter(|name| name.starts_with(&prefix)).count(), 0, "segments remain");
        assert!(!self.base.path().join("transport").exists(), "the root folder remains");
    }
}

/// Accepts every chunk after `time_per_chunk` and records its sequence number.
fn accept_all(
    seen: &mut Vec<u64>,
    time_per_chunk: Duration,
) -> impl FnMut(&PlanChunk, &mut dyn FnMut()) -> ChunkDecision {
    move |chunk, _| {
        std::thread::sleep(time_per_chunk);
        seen.push(chunk.sequence);
        ChunkDecision::Accepted(
            Margins { balance: 0.5, ..Margins::UNMEASURED },
            chunk.stream_after(),
        )
    }
}

/// Repeats the last feedback until the planner leaves. A further chunk is an error.
fn linger(subscriber: &mut PlanSubscriber) {
    let mut check_chunk = |_: &PlanChunk, _: &mut dyn FnMut()| panic!("a chunk after the end");
    assert_eq!(
        subscriber.linger(&mut check_chunk, Some(Duration::from_secs(20)), &|| true).unwrap(),
        None
    );
}

fn deliver(instance: &Instance, chunks: &[PlanChunk]) -> Delivery {
    let mut publisher = PlanPublisher::open(instance, random_id()).unwrap();
    publisher.deliver(chunks, &mut |_| {}, &|| true).unwrap()
}

/// Runs a subscriber to the end of the plan; returns the checked sequence numbers.
fn receive(instance: &Instance, time_per_chunk: Duration) -> (StreamEnd, Vec<u64>, ReceiverStats) {
    let mut subscriber = PlanSubscriber::open(instance, random_id()).unwrap();
    let mut seen = Vec::new();
    let mut check_chunk = accept_all(&mut seen, time_per_chunk);
    let mut ended = StreamEnd::PlannerLeft;
    while ended == StreamEnd::PlannerLeft {
        ended = subscriber.run(&mut check_chunk, &|| true).unwrap();
    }
    drop(check_chunk);
    linger(&mut subscriber);
    (ended, seen, subscriber.stats())
}

#[test]
fn five_hundred_chunks_reach_a_slow_controller_in_order_once_each() {
    let test_instance = TestInstance::new();
    let chunks = plan(500);
    let (delivery, (ended, seen, stats)) = std::thread::scope(|scope| {
        let (to, from) = (test_instance.attach(), test_instance.attach());
        let controller = scope.spawn(move || receive(&from, Duration::from_micros(500)));
        let delivery = deliver(&to, &chunks);
        (delivery, controller.join().unwrap())
    });
    assert_eq!(
        (delivery.outcome, delivery.accepted, ended),
        (DeliveryOutcome::Accepted, 500, StreamEnd::Finished)
    );
    assert_eq!(seen, (0..500).collect::<Vec<_>>());
    assert_eq!(delivery.feedback.unwrap().margins.balance, 0.5);
    assert_eq!(stats.accepted, 500);
    println!("sent {} resent {} {stats:?}", delivery.sent, delivery.resent);
    test_instance.close();
}

#[test]
fn lost_and_delayed_feedback_loses_no_chunk() {
    let test_instance = TestInstance::new();
    let chunks = plan(300);
    let (delivery, seen) = std::thread::scope(|scope| {
        let (to, from) = (test_instance.attach(), test_instance.attach());
        let controller = scope.spawn(move || {
            let mut subscriber = PlanSubscriber::open(&from, random_id()).unwrap();
            subscriber.inject_faults(11);
            let mut seen = Vec::new();
            let mut check_chunk = accept_all(&mut seen, Duration::from_micros(100));
            while subscriber.run(&mut check_chunk, &|| true).unwrap() != StreamEnd::Finished {}
            drop(check_chunk);
            linger(&mut subscriber);
            seen
        });
        let delivery = deliver(&to, &chunks);
        (delivery, controller.join().unwrap())
    });
    assert_eq!((delivery.outcome, delivery.accepted), (DeliveryOutcome::Accepted, 300));
    assert_eq!(seen, (0..300).collect::<Vec<_>>());
    test_instance.close();
}

#[test]
fn a_controller_slower_than_the_resend_time_receives_no_chunk_twice() {
    let test_instance = TestInstance::new();
    let chunks = plan(20);
    let (delivery, (_, seen, stats)) = std::thread::scope(|scope| {
        let (to, from) = (test_instance.attach(), test_instance.attach());
        let controller = scope.spawn(move || receive(&from, Duration::from_millis(60)));
        let delivery = deliver(&to, &chunks);
        (delivery, controller.join().unwrap())
    });
    assert_eq!((delivery.outcome, seen.len()), (DeliveryOutcome::Accepted, 20));
    assert_eq!((stats.duplicates, stats.gaps), (0, 0), "{delivery:?}");
    test_instance.close();
}

#[test]
fn restarted_controllers_continue_from_the_rest_state() {
    let test_instance = TestInstance::new();
    let chunks = plan(200);
    let (delivery, runs) = std::thread::scope(|scope| {
        let (to, from) = (test_instance.attach(), test_instance.attach());
        let controllers = scope.spawn(move || {
            let mut runs = Vec::new();
            for chunks_max in [37, 1, 8, 120] {
                let mut seen = Vec::new();
                let checked = AtomicUsize::new(0);
                let mut subscriber = PlanSubscriber::open(&from, random_id()).unwrap();
                let mut accept = accept_all(&mut seen, Duration::ZERO);
                let mut check_chunk = |chunk: &PlanChunk, heartbeat: &mut dyn FnMut()| {
                    checked.fetch_add(1, Ordering::Relaxed);
                    accept(chunk, heartbeat)
                };
                let ended = subscriber
                    .run(&mut check_chunk, &|| checked.load(Ordering::Relaxed) < chunks_max)
                    .unwrap();
                assert_eq!(ended, StreamEnd::Stopped);
                drop((subscriber, accept));
                runs.push(seen);
            }
            runs.push(receive(&from, Duration::ZERO).1);
            runs
        });
        (deliver(&to, &chunks), controllers.join().unwrap())
    });
    assert_eq!(delivery.outcome, DeliveryOutcome::Accepted);
    let lengths: Vec<usize> = runs.iter().map(Vec::len).collect();
    assert_eq!(lengths, [37, 1, 8, 120, 34]);
    assert_eq!(
        runs.concat(),
        (0..200).collect::<Vec<_>>(),
        "contiguous, once each, over all controllers"
    );
    assert_eq!(delivery.feedback.unwrap().walked, 200);
    test_instance.close();
}

#[test]
fn restarted_planners_continue_from_the_acknowledged_chunk() {
    let test_instance = TestInstance::new();
    let chunks = plan(200);
    let (deliveries, (ended, seen, stats)) = std::thread::scope(|scope| {
        let (to, from) = (test_instance.attach(), test_instance.attach());
        let controller = scope.spawn(move || receive(&from, Duration::from_micros(200)));
        let mut deliveries = Vec::new();
        for chunks_max in [5, 60, 61, 150, 1000] {
            let accepted = AtomicUsize::new(0);
            let mut publisher = PlanPublisher::open(&to, random_id()).unwrap();
            let mut note = |feedback: &Feedback| {
                accepted.store(feedback.next_sequence as usize, Ordering::Relaxed)
            };
            deliveries.push(
                publisher
                    .deliver(&chunks, &mut note, &|| accepted.load(Ordering::Relaxed) < chunks_max)
                    .unwrap(),
            );
        }
        (deliveries, controller.join().unwrap())
    });
    assert_eq!(ended, StreamEnd::Finished);
    assert_eq!(seen, (0..200).collect::<Vec<_>>(), "contiguous, once each, over all planners");
    assert_eq!(
        deliveries.iter().filter(|delivery| delivery.outcome == DeliveryOutcome::Stopped).count(),
        4
    );
    assert_eq!(deliveries.last().unwrap().outcome, DeliveryOutcome::Accepted);
    println!("{stats:?}");
    test_instance.close();
}

#[test]
fn a_finished_plan_is_not_executed_again_for_a_new_planner_but_another_plan_is() {
    let test_instance = TestInstance::new();
    let chunks = plan(10);
    let mut other = plan(10);
    other[0].waypoints[0].time = -1.0;
    for index in 1..other.len() {
        other[index].stream = other[index - 1].stream_after();
    }
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let (to, from) = (test_instance.attach(), test_instance.attach());
        let stop = &stop;
        let controller = scope.spawn(move || {
            let mut seen = Vec::new();
            let mut subscriber = PlanSubscriber::open(&from, random_id()).unwrap();
            let mut check_chunk = accept_all(&mut seen, Duration::ZERO);
            while subscriber.run(&mut check_chunk, &|| !stop.load(Ordering::Relaxed)).unwrap()
                != StreamEnd::Stopped
            {}
            drop(check_chunk);
            seen
        });
        assert_eq!(deliver(&to, &chunks).outcome, DeliveryOutcome::Accepted);
        let again = deliver(&to, &chunks);
        assert_eq!((again.outcome, again.sent), (DeliveryOutcome::Accepted, 0));
        let replaced = deliver(&to, &other);
        assert_eq!((replaced.outcome, replaced.accepted), (DeliveryOutcome::Accepted, 10));
        stop.store(true, Ordering::Relaxed);
        assert_eq!(controller.join().unwrap(), (0..10).chain(0..10).collect::<Vec<_>>());
    });
    test_instance.close();
}

#[test]
fn a_refusal_ends_the_delivery_and_names_its_check() {
    let test_instance = TestInstance::new();
    let chunks = plan(30);
    let (delivery, ended) = std::thread::scope(|scope| {
        let (to, from) = (test_instance.attach(), test_instance.attach());
        let controller = scope.spawn(move || {
            let mut subscriber = PlanSubscriber::open(&from, random_id()).unwrap();
            let mut check_chunk = |chunk: &PlanChunk, _: &mut dyn FnMut()| match chunk.sequence {
                17 => {
                    ChunkDecision::Refused { check: Check::Balance, waypoint: 3, correction: None }
                }
                _ => ChunkDecision::Accepted(Margins::UNMEASURED, chunk.stream_after()),
            };
            let ended = subscriber.run(&mut check_chunk, &|| true).unwrap();
            linger(&mut subscriber);
            ended
        });
        (deliver(&to, &chunks), controller.join().unwrap())
    });
    assert_eq!(
        ended,
        StreamEnd::Refused(Refusal { sequence: 17, check: Check::Balance, waypoint: 3 })
    );
    assert_eq!(
        delivery.outcome,
        DeliveryOutcome::Refused { sequence: 17, check: Check::Balance, waypoint: 3 }
    );
    assert_eq!(delivery.accepted, 17);
    test_instance.close();
}

#[test]
fn damaged_chunks_are_dropped_and_counted_and_the_walk_goes_on() {
    let test_instance = TestInstance::new();
    let instance = test_instance.attach();
    let header_bits = (0..8 * std::mem::offset_of!(PlanChunk, contacts)).step_by(5);
    let body_bits =
        (8 * std::mem::offset_of!(PlanChunk, contacts)..8 * size_of::<PlanChunk>()).step_by(4001);
    let participant = Participant::open(&instance).unwrap();
    let publisher = participant.chunks.publisher_builder().create().unwrap();
    for bit in header_bits.chain(body_bits) {
        let id = random_id();
        fs::remove_file(instance.root().join("robot")).unwrap_or_default();
        let mut subscriber = PlanSubscriber::open(&instance, id).unwrap();
        let mut chunk = plan(1)[0];
        (chunk.session, chunk.target_controller) = (1, id);
        chunk.write_crc();
        let mut damaged = chunk;
        bytemuck::bytes_of_mut(&mut damaged)[bit / 8] ^= 1 << (bit % 8);
        publisher.send_copy(damaged).unwrap();
        publisher.send_copy(chunk).unwrap();
        let mut seen = Vec::new();
        let mut check_chunk = accept_all(&mut seen, Duration::ZERO);
        let ended = subscriber.run(&mut check_chunk, &|| true).unwrap();
        drop(check_chunk);
        let stats = subscriber.stats();
        let counts = (stats.received, stats.damaged, stats.accepted);
        assert_eq!((ended, counts, seen), (StreamEnd::Finished, (2, 1, 1), vec![0]), "bit {bit}");
    }
    drop((publisher, participant, instance));
    test_instance.close();
}

/// A controller that takes 1 ms for each chunk, beside a process that sends every chunk once more,
/// damaged.
#[test]
fn a_process_that_forges_damaged_chunks_holds_up_no_delivery() {
    let (test_instance, chunks) = (TestInstance::new(), plan(100));
    let over = AtomicBool::new(false);
    let (delivery, (ended, seen, stats)) = std::thread::scope(|scope| {
        let [to, from, beside] = [(); 3].map(|()| test_instance.attach());
        let (over, forged) = (&over, &chunks);
        scope.spawn(move || {
            let participant = Participant::open(&beside).unwrap();
            let publisher = participant.chunks.publisher_builder().create().unwrap();
            for chunk in forged.iter().cycle().take_while(|_| !over.load(Ordering::Relaxed)) {
                publisher.send_copy(PlanChunk { crc: !chunk.crc, ..*chunk }).unwrap();
                std::thread::sleep(Duration::from_millis(1));
            }
        });
        let controller = scope.spawn(move || receive(&from, Duration::from_millis(1)));
        let delivery = deliver(&to, &chunks);
        let received = controller.join().unwrap();
        over.store(true, Ordering::Relaxed);
        (delivery, received)
    });
    assert_eq!((delivery.outcome, ended), (DeliveryOutcome::Accepted, StreamEnd::Finished));
    assert_eq!(seen, (0..100).collect::<Vec<_>>());
    assert!(stats.other_senders > 5 && stats.accepted == 100, "{stats:?}");
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

/// Sends what [`forged`] makes of every chunk that arrives, until `over` is set; returns how many.
fn forge_chunks(instance: &Instance, over: &AtomicBool, is_open: &Barrier) -> usize {
    let observer = Observer::open(instance).unwrap();
    let participant = Participant::open(instance).unwrap();
    let builder = participant.chunks.publisher_builder();
    let publisher = builder.backpressure_strategy(BackpressureStrategy::DiscardData).create();
    let (publisher, mut sent) = (publisher.unwrap(), 0);
    is_open.wait();
    while !over.load(Ordering::Relaxed) {
        let Some(chunk) = observer.chunk().unwrap() else { continue };
        assert!(chunk.waypoints[0].time != FORGED_TIME, "observers skip forged chunks, too");
        for chunk in forged(&chunk) {
            sent += usize::from(publisher.send_copy(chunk).is_ok_and(|readers| readers > 0));
        }
    }
    sent
}

/// A controller that takes 1 ms for each chunk, beside a process that knows the session.
#[test]
fn chunks_that_the_planner_did_not_send_are_dropped_whatever_they_contain() {
    let (test_instance, chunks) = (TestInstance::new(), plan(100));
    let (over, is_open) = (AtomicBool::new(false), Barrier::new(2));
    let (delivery, sent, (checked, stats)) = std::thread::scope(|scope| {
        let [to, from, beside] = [(); 3].map(|()| test_instance.attach());
        let (over, is_open) = (&over, &is_open);
        let forger = scope.spawn(move || forge_chunks(&beside, over, is_open));
        let controller = scope.spawn(move || {
            let mut subscriber = PlanSubscriber::open(&from, random_id()).unwrap();
            let mut checked = Vec::new();
            let mut check_chunk = |chunk: &PlanChunk, _: &mut dyn FnMut()| {
                std::thread::sleep(Duration::from_millis(1));
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
        (delivery, forger.join().unwrap(), controller.join().unwrap())
    });
    assert_eq!(delivery.outcome, DeliveryOutcome::Accepted);
    assert_eq!(checked, (0..100).map(|sequence| (sequence, false)).collect::<Vec<_>>());
    assert!(sent > 10 && stats.other_senders > 10, "{sent} sent, {stats:?}");
    test_instance.close();
}

/// Whenever the controller looks, another chunk has arrived that it drops.
#[test]
fn a_flood_of_dropped_chunks_delays_no_heartbeat() {
    let (test_instance, chunk) = (TestInstance::new(), plan(1)[0]);
    let (instance, beside) = (test_instance.attach(), test_instance.attach());
    let participant = Participant::open(&beside).unwrap();
    let publisher = participant.chunks.publisher_builder().create().unwrap();
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

#[test]
fn without_a_controller_the_delivery_reports_it_lost() {
    let test_instance = TestInstance::new();
    let instance = test_instance.attach();
    let chunks = plan(3);
    let mut publisher = PlanPublisher::open(&instance, random_id()).unwrap();
    assert_eq!(
        publisher.deliver(&chunks, &mut |_| {}, &|| false).unwrap().outcome,
        DeliveryOutcome::Stopped
    );
    publisher.set_lost_after(Duration::from_millis(50));
    let delivery = publisher.deliver(&chunks, &mut |_| {}, &|| true).unwrap();
    assert_eq!(
        (delivery.outcome, delivery.sent, delivery.feedback),
        (DeliveryOutcome::ControllerLost, 0, None)
    );
    assert!(matches!(
        publisher.deliver(&chunks[1..], &mut |_| {}, &|| true),
        Err(ChannelError::Stream { index: 0 })
    ));
    assert!(matches!(PlanPublisher::open(&instance, 0), Err(ChannelError::Id)));
    drop((publisher, instance));
    test_instance.close();
}

#[test]
fn a_subscriber_that_never_reads_does_not_block_the_walk() {
    let test_instance = TestInstance::new();
    let logger = Participant::open(&test_instance.attach()).unwrap();
    let stuck = logger.chunks.subscriber_builder().create().unwrap();
    let chunks = plan(100);
    let (delivery, (_, seen, _)) = std::thread::scope(|scope| {
        let (to, from) = (test_instance.attach(), test_instance.attach());
        let controller = scope.spawn(move || receive(&from, Duration::ZERO));
        (deliver(&to, &chunks), controller.join().unwrap())
    });
    assert_eq!((delivery.outcome, seen.len()), (DeliveryOutcome::Accepted, 100));
    drop((stuck, logger));
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

/// A process that publishes forged feedback as fast as it can, beside a controller that answers at
/// once.
#[test]
fn a_flood_of_forged_feedback_delays_no_delivery() {
    let (test_instance, chunks) = (TestInstance::new(), plan(200));
    let (over, is_open) = (AtomicBool::new(false), Barrier::new(2));
    let (delivery, seen) = std::thread::scope(|scope| {
        let [to, from, beside] = [(); 3].map(|()| test_instance.attach());
        let (over, is_open) = (&over, &is_open);
        scope.spawn(move || {
            let forger = Forger::open(&beside);
            is_open.wait();
            while !over.load(Ordering::Relaxed) {
                forger.publisher.send_copy(Feedback::zeroed()).unwrap();
            }
        });
        is_open.wait();
        let controller = scope.spawn(move || receive(&from, Duration::ZERO));
        let delivery = deliver(&to, &chunks);
        over.store(true, Ordering::Relaxed);
        (delivery, controller.join().unwrap().1)
    });
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
    let participant = Participant::open(&beside).unwrap();
    let publisher = participant.chunks.publisher_builder().create().unwrap();
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

#[test]
fn a_second_planner_is_refused_and_the_first_delivers() {
    let test_instance = TestInstance::new();
    let chunks = plan(20);
    std::thread::scope(|scope| {
        let (to, from) = (test_instance.attach(), test_instance.attach());
        let mut first = PlanPublisher::open(&to, random_id()).unwrap();
        assert!(matches!(
            PlanPublisher::open(&test_instance.attach(), random_id()),
            Err(ChannelError::PlannerTaken)
        ));
        let controller = scope.spawn(move || receive(&from, Duration::ZERO));
        let delivery = first.deliver(&chunks, &mut |_| {}, &|| true).unwrap();
        assert_eq!(delivery.outcome, DeliveryOutcome::Accepted);
        drop(first);
        assert_eq!(controller.join().unwrap().0, StreamEnd::Finished);
    });
    test_instance.close();
}
