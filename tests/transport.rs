//! The transport end to end: publisher and subscriber on two threads of one process, over shared
//! memory.
//!
//! Every chunk is checked exactly once and in order, after restarts of either side and with a slow
//! controller. Damaged chunks are refused. No shared memory remains.

#![allow(clippy::unwrap_used, reason = "a transport that cannot be opened fails the test")]

#[path = "common/chunk_stream.rs"]
mod chunk_stream;
#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/delivery.rs"]
mod delivery;
#[path = "common/private_folder.rs"]
mod private_folder;

use std::fs;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use chunk_stream::plan;
use delivery::{TestInstance, accept_all, chunk_publisher, deliver, linger, receive};
use surefoot_controller_sim::channel::Refusal;
use surefoot_controller_sim::channel::plan_subscriber::{ChunkDecision, PlanSubscriber, StreamEnd};
use surefoot_planner::channel::plan_publisher::PlanPublisher;
use surefoot_planner::channel::send_window::DeliveryOutcome;
use surefoot_shared_types::instance::error::ChannelError;
use surefoot_shared_types::instance::participant::Participant;
use surefoot_shared_types::instance::sender::random_id;
use surefoot_shared_types::message::{Check, Feedback, Margins, PlanChunk, WithCrc};

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
    let (participant, publisher) = chunk_publisher(&instance);
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
