//! Damaged and forged messages in shared memory: none is executed, accepted or served, and no
//! process crashes.
//!
//! `SUREFOOT_FUZZ=10000000 cargo test --release --test fuzz -- --nocapture` tests ten million
//! messages.

#![allow(clippy::unwrap_used, reason = "a transport that cannot be opened fails the test")]

#[path = "common/executor.rs"]
mod executor;
#[path = "common/private_folder.rs"]
mod private_folder;
#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/random.rs"]
mod random;

use std::fs;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use bytemuck::{Zeroable, bytes_of_mut};
use executor::executor;
use private_folder::private_folder;
use random::Random;
use surefoot_controller_sim::channel::plan_subscriber::{ChunkDecision, PlanSubscriber};
use surefoot_planner::channel::plan_publisher::PlanPublisher;
use surefoot_planner::channel::send_window::DeliveryOutcome;
use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::participant::Participant;
use surefoot_shared_types::instance::requests::{RequestClient, RequestServer};
use surefoot_shared_types::instance::sender::random_id;
use surefoot_shared_types::message::feedback::FEEDBACK_SCHEMA;
use surefoot_shared_types::message::{Check, Feedback, PlanChunk, PlanRequest, WithCrc};
use surefoot_shared_types::robot::load::load_robot;

/// Default number of messages of each kind.
const MESSAGES: u64 = 60_000;

/// A damaged copy of a valid message: all bytes random, or some bytes changed. Half of one kind of
/// the latter have another schema and a matching CRC.
fn damage<M: WithCrc + PartialEq>(valid: &M, random: &mut Random) -> M {
    let mut message = *valid;
    let kind = random.below(4);
    if kind == 0 {
        randomize(bytes_of_mut(&mut message), random);
    } else {
        change_some_bytes(bytes_of_mut(&mut message), random);
    }
    if message == *valid {
        // Two changes of one byte can cancel.
        bytes_of_mut(&mut message)[0] ^= 1;
    }
    if kind == 1 && random.below(2) == 0 {
        let schema = 1000 + random.below(1000);
        bytes_of_mut(&mut message)[..8].copy_from_slice(&schema.to_le_bytes());
        message.write_crc();
    }
    message
}

fn randomize(bytes: &mut [u8], random: &mut Random) {
    for word in bytes.chunks_mut(8) {
        word.copy_from_slice(&random.next().to_le_bytes()[..word.len()]);
    }
}

fn change_some_bytes(bytes: &mut [u8], random: &mut Random) {
    for _ in 0..=random.below(8) {
        let at = random.below(bytes.len() as u64) as usize;
        bytes[at] = bytes[at].wrapping_add(1 + random.below(255) as u8);
    }
}

fn messages() -> u64 {
    std::env::var("SUREFOOT_FUZZ").ok().and_then(|text| text.parse().ok()).unwrap_or(MESSAGES)
}

fn test_instance() -> (tempfile::TempDir, Instance) {
    let base = private_folder("sf-fuzz");
    let instance = Instance::create_in(base.path(), "fuzz").unwrap();
    (base, instance)
}

fn with_crc<M: WithCrc>(mut message: M) -> M {
    message.write_crc();
    message
}

/// A chunk that passes the checks of the transport.
fn valid_chunk(id: u64) -> PlanChunk {
    with_crc(PlanChunk {
        schema: 1,
        session: 5,
        target_controller: id,
        plan_id: 1,
        flags: 1,
        waypoints_len: 2,
        ..PlanChunk::zeroed()
    })
}

#[test]
fn forged_chunks_are_never_executed() {
    let (mut executor, identity) = executor("configs/scenarios/flat_walk.toml", 3);
    let joints_len =
        load_robot("configs/robots/hubo/robot.toml".as_ref()).unwrap().joints.len() as u32;
    let mut random = Random(5);
    let mut chunk = PlanChunk::zeroed();
    for _ in 0..messages() {
        randomize(bytes_of_mut(&mut chunk), &mut random);
        // A forged message with valid header fields and a CRC, but without a valid motion.
        (chunk.schema, chunk.target_controller, chunk.sequence, chunk.flags) =
            (1, identity.controller_id, 0, 1);
        (chunk.mode, chunk.contacts_len, chunk.joints_len) =
            (random.next() as u32 % 4, random.next() as u32 % 4, joints_len);
        chunk.waypoints_len = random.next() as u32 % 34;
        (chunk.robot, chunk.world, chunk.config) =
            (identity.robot, identity.world, identity.config);
        if random.below(2) == 0 {
            make_well_formed(&mut chunk, &mut random);
        }
        chunk.write_crc();
        assert!(executor.check_and_execute(&chunk).is_err(), "{chunk:?}");
        assert!(executor.rest_state().is_none());
    }
}

/// Replaces all numbers by finite ones and all quaternions by unit quaternions.
fn make_well_formed(chunk: &mut PlanChunk, random: &mut Random) {
    let mut number = || (random.next() % 2000) as f64 * 1e-3 - 1.0;
    for (index, contact) in chunk.contacts.iter_mut().enumerate() {
        (contact.limb, contact.polygon_len) = (index as u32, 4);
        (contact.position, contact.rotation) =
            ([number(), number(), number()], [0.0, 0.0, 0.0, 1.0]);
        contact.polygon = std::array::from_fn(|_| [number(), number()]);
    }
    for waypoint in &mut chunk.waypoints {
        (waypoint.time, waypoint.root_rotation) = (number(), [0.0, 0.0, 0.0, 1.0]);
        waypoint.root_position = [number(), number(), number()];
        waypoint.q = std::array::from_fn(|_| number());
    }
}

#[test]
fn damaged_chunks_are_never_checked_as_valid() {
    let (_base, instance) = test_instance();
    let participant = Participant::open(&instance).unwrap();
    let publisher = participant.chunks.publisher_builder().create().unwrap();
    let mut random = Random(1);
    // A controller ignores chunks after a refusal, so each message needs a new controller, which
    // takes longer.
    for _ in 0..messages() / 500 {
        fs::remove_file(instance.root().join("robot")).unwrap_or_default();
        let id = random_id();
        let mut subscriber = PlanSubscriber::open(&instance, id).unwrap();
        let damaged = damage(&valid_chunk(id), &mut random);
        let forged = damaged.crc_matches();
        publisher.send_copy(damaged).unwrap();
        let has_run = AtomicBool::new(false);
        let mut check_chunk = |chunk: &PlanChunk, _: &mut dyn FnMut()| {
            assert!(forged && chunk.schema != 1, "a damaged chunk was passed on to the checks");
            ChunkDecision::Refused { check: Check::Malformed, waypoint: 0, correction: None }
        };
        subscriber.run(&mut check_chunk, &|| !has_run.swap(true, Ordering::Relaxed)).unwrap();
        assert_eq!((subscriber.stats().received, subscriber.stats().accepted), (1, 0));
    }
}

#[test]
fn damaged_feedback_is_never_accepted() {
    let (_base, instance) = test_instance();
    let participant = Participant::open(&instance).unwrap();
    let publisher = participant.feedback.publisher_builder().create().unwrap();
    let mut chunk = valid_chunk(1);
    chunk.session = 0;
    let chunks = [chunk];
    let mut random = Random(2);
    let valid = with_crc(Feedback {
        schema: FEEDBACK_SCHEMA,
        controller_id: 7,
        session: 5,
        plan_id: 1,
        count: 3,
        next_sequence: 1,
        verdict: 1,
        finished: 1,
        stream: chunk.stream_after(),
        ..Feedback::zeroed()
    });
    assert!(valid.is_well_formed());
    let count = messages();
    let over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let deliverer = scope.spawn(|| {
            let mut sender = PlanPublisher::open(&instance, 5).unwrap();
            sender.set_lost_after(Duration::from_secs(3600));
            sender.deliver(&chunks, &mut |_| {}, &|| !over.load(Ordering::Relaxed)).unwrap()
        });
        for _ in 0..count {
            let damaged = damage(&valid, &mut random);
            assert!(!damaged.is_well_formed());
            publisher.send_copy(damaged).unwrap();
        }
        over.store(true, Ordering::Relaxed);
        let delivery = deliverer.join().unwrap();
        assert_eq!(
            (delivery.outcome, delivery.accepted, delivery.sent, delivery.feedback),
            (DeliveryOutcome::Stopped, 0, 0, None)
        );
    });
}

#[test]
fn damaged_requests_are_never_served() {
    let (_base, instance) = test_instance();
    let mut server = RequestServer::open(&Participant::open(&instance).unwrap(), 7).unwrap();
    let mut client = RequestClient::open(Participant::open(&instance).unwrap(), 9).unwrap();
    let mut random = Random(3);
    let valid = client.stamp(&PlanRequest { kind: 3, ..PlanRequest::zeroed() });
    for _ in 0..messages() {
        let damaged = damage(&valid, &mut random);
        client.send(&damaged).unwrap();
        assert!(server.take().unwrap().is_none(), "{damaged:?}");
    }
    client.send(&valid).unwrap();
    assert!(server.take().unwrap().is_some(), "the server serves a valid request");
}

/// Random bytes of a journal: its records and the first chunk.
const RANDOM_BYTES: usize = 40_000;

#[test]
fn a_damaged_journal_is_never_taken_over() {
    let (_base, instance) = test_instance();
    let path = instance.root().join("robot");
    drop(PlanSubscriber::open(&instance, random_id()).unwrap());
    let length = fs::metadata(&path).unwrap().len() as usize;
    let mut random = Random(4);
    let count = messages() / 500;
    for _ in 0..count {
        let mut bytes: Vec<u8> = (0..RANDOM_BYTES).map(|_| random.next() as u8).collect();
        bytes.resize(length, 0);
        fs::write(&path, bytes).unwrap();
        let subscriber = PlanSubscriber::open(&instance, random_id()).unwrap();
        assert!(subscriber.taken_over().is_none());
    }
}
