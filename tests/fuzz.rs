//! Hostile bytes: whatever is written into shared memory, nothing that is not a sound message is
//! ever walked, believed or served, and nobody crashes.
//!
//! `SUREFOOT_FUZZ=10000000 cargo test --release --test fuzz -- --nocapture` makes ten million
//! messages of it.

#![allow(clippy::unwrap_used, reason = "a test ends where the transport cannot be opened")]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use bytemuck::{Zeroable, bytes_of_mut};
use surefoot_controller_sim::channel::plan_subscriber::{ChunkDecision, PlanSubscriber};
use surefoot_controller_sim::{Checker, ChunkExecutor, Identity};
use surefoot_planner::channel::plan_publisher::PlanPublisher;
use surefoot_planner::channel::send_window::DeliveryOutcome;
use surefoot_shared_types::config::load::load_scenario;
use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::requests::{RequestClient, RequestServer};
use surefoot_shared_types::instance::{Participant, random_id};
use surefoot_shared_types::message::feedback::FEEDBACK_SCHEMA;
use surefoot_shared_types::message::{Check, Feedback, Layout, PlanChunk, PlanRequest, WithCrc};
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::world::load::load_world;

/// Messages of each kind in continuous integration.
const MESSAGES: u64 = 60_000;

struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Spoils a sound message: all bytes, or some, or some after which the seal is put right for
    /// every second one.
    fn spoil<M: WithCrc + PartialEq>(&mut self, sound: &M) -> M {
        let mut message = *sound;
        let kind = self.roll() % 4;
        let bytes = bytes_of_mut(&mut message);
        match kind {
            0 => bytes
                .chunks_mut(8)
                .for_each(|word| word.copy_from_slice(&self.roll().to_le_bytes()[..word.len()])),
            _ => {
                for _ in 0..=self.roll() % 8 {
                    let at = self.roll() as usize % bytes.len();
                    bytes[at] = bytes[at].wrapping_add(1 + (self.roll() % 255) as u8);
                }
            }
        }
        if message == *sound {
            // Two changes of one byte can cancel each other.
            bytes_of_mut(&mut message)[0] ^= 1;
        }
        if kind == 1 && self.roll().is_multiple_of(2) {
            // A forger who knows the seal, but not what the message must say: a wrong schema.
            bytes_of_mut(&mut message)[..8]
                .copy_from_slice(&(1000 + self.roll() % 1000).to_le_bytes());
            message.write_crc();
        }
        message
    }
}

fn messages() -> u64 {
    std::env::var("SUREFOOT_FUZZ").ok().and_then(|text| text.parse().ok()).unwrap_or(MESSAGES)
}

fn test_instance() -> (tempfile::TempDir, Instance) {
    let private = fs::Permissions::from_mode(0o700);
    let base = tempfile::Builder::new()
        .prefix("sf-fuzz")
        .permissions(private)
        .tempdir_in("/dev/shm")
        .unwrap();
    let instance = Instance::create_in(base.path(), "fuzz").unwrap();
    (base, instance)
}

fn with_crc<M: WithCrc>(mut message: M) -> M {
    message.write_crc();
    message
}

/// A chunk as a controller waits for, as far as the transport looks.
fn sound_chunk(id: u64) -> PlanChunk {
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

/// A controller's robot that waits for its first chunk, and its identity.
fn executor() -> (ChunkExecutor, Identity) {
    let scenario = load_scenario("configs/scenarios/flat_walk.toml".as_ref()).unwrap();
    let (model, world) =
        (load_robot(&scenario.robot_path).unwrap(), load_world(&scenario.world_path).unwrap());
    let identity = Identity {
        controller_id: 3,
        robot: model.digest,
        world: world.digest,
        config: scenario.digest,
    };
    (ChunkExecutor::new(Checker::new(model, world, scenario.checker).unwrap(), identity), identity)
}

#[test]
fn forged_chunks_are_never_executed() {
    let (mut executor, identity) = executor();
    let joints_len =
        load_robot("configs/robots/hubo/robot.toml".as_ref()).unwrap().joints.len() as u32;
    let mut dice = Dice(5);
    let mut chunk = PlanChunk::zeroed();
    for _ in 0..messages() {
        bytes_of_mut(&mut chunk)
            .chunks_mut(8)
            .for_each(|word| word.copy_from_slice(&dice.roll().to_le_bytes()[..word.len()]));
        // A forger who knows everything about the message but how a robot walks.
        (chunk.schema, chunk.target_controller, chunk.sequence, chunk.flags) =
            (1, identity.controller_id, 0, 1);
        (chunk.mode, chunk.contacts_len, chunk.joints_len) =
            (dice.roll() as u32 % 4, dice.roll() as u32 % 4, joints_len);
        chunk.waypoints_len = dice.roll() as u32 % 34;
        (chunk.robot, chunk.world, chunk.config) =
            (identity.robot, identity.world, identity.config);
        if dice.roll().is_multiple_of(2) {
            tame(&mut chunk, &mut dice);
        }
        chunk.write_crc();
        assert!(executor.check_and_execute(&chunk).is_err(), "{chunk:?}");
        assert!(executor.rest_state().is_none());
    }
}

/// Makes the numbers such as a message may carry: finite, and unit quaternions.
fn tame(chunk: &mut PlanChunk, dice: &mut Dice) {
    let mut number = || (dice.roll() % 2000) as f64 * 1e-3 - 1.0;
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
fn spoiled_chunks_are_never_checked_as_valid() {
    let (_base, instance) = test_instance();
    let participant = Participant::open(&instance).unwrap();
    let publisher = participant.chunks.publisher_builder().create().unwrap();
    let mut dice = Dice(1);
    // A controller that has refused looks at nothing more: each message gets a new one, which takes
    // its time.
    for _ in 0..messages() / 500 {
        fs::remove_file(instance.root().join("robot")).unwrap_or_default();
        let id = random_id();
        let mut subscriber = PlanSubscriber::open(&instance, id).unwrap();
        let spoiled = dice.spoil(&sound_chunk(id));
        let forged = spoiled.crc_matches();
        publisher.send_copy(spoiled).unwrap();
        let looked = AtomicBool::new(false);
        let mut check_chunk = |chunk: &PlanChunk, _: &mut dyn FnMut()| {
            assert!(forged && chunk.schema != 1, "a spoiled chunk was passed on to the checks");
            ChunkDecision::Refused { check: Check::Malformed, waypoint: 0, correction: None }
        };
        subscriber.run(&mut check_chunk, &|| !looked.swap(true, Ordering::Relaxed)).unwrap();
        assert_eq!((subscriber.stats().received, subscriber.stats().accepted), (1, 0));
    }
}

#[test]
fn spoiled_feedback_is_never_accepted() {
    let (_base, instance) = test_instance();
    let participant = Participant::open(&instance).unwrap();
    let publisher = participant.feedback.publisher_builder().create().unwrap();
    let mut chunk = sound_chunk(1);
    chunk.session = 0;
    let chunks = [chunk];
    let mut dice = Dice(2);
    let sound = with_crc(Feedback {
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
    assert!(sound.is_well_formed());
    let count = messages();
    let over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let deliverer = scope.spawn(|| {
            let mut sender = PlanPublisher::open(&instance, 5).unwrap();
            sender.set_lost_after(Duration::from_secs(3600));
            sender.deliver(&chunks, &mut |_| {}, &|| !over.load(Ordering::Relaxed)).unwrap()
        });
        for _ in 0..count {
            let spoiled = dice.spoil(&sound);
            assert!(!spoiled.is_well_formed());
            publisher.send_copy(spoiled).unwrap();
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
fn spoiled_requests_are_never_served() {
    let (_base, instance) = test_instance();
    let mut server = RequestServer::open(&Participant::open(&instance).unwrap(), 7).unwrap();
    let mut client = RequestClient::open(Participant::open(&instance).unwrap(), 9).unwrap();
    let mut dice = Dice(3);
    let sound = client.stamp(&PlanRequest { kind: 3, ..PlanRequest::zeroed() });
    for _ in 0..messages() {
        let spoiled = dice.spoil(&sound);
        client.send(&spoiled).unwrap();
        assert!(server.take().unwrap().is_none(), "{spoiled:?}");
    }
    client.send(&sound).unwrap();
    assert!(server.take().unwrap().is_some(), "the desk still works");
}

#[test]
fn a_spoiled_record_is_never_taken_over() {
    let (_base, instance) = test_instance();
    let path = instance.root().join("robot");
    let mut dice = Dice(4);
    let count = messages() / 500;
    for _ in 0..count {
        let bytes: Vec<u8> = (0..2 * surefoot_shared_types::message::JournalRecord::FIELDS
            .iter()
            .map(|field| field.size)
            .sum::<usize>())
            .map(|_| dice.roll() as u8)
            .collect();
        fs::write(&path, bytes).unwrap();
        let subscriber = PlanSubscriber::open(&instance, random_id()).unwrap();
        assert!(subscriber.taken_over().is_none());
    }
}
