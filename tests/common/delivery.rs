//! A planner's and a controller's end of the transport in one process, over shared memory.

use std::fs;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use iceoryx2::port::publisher::Publisher;
use iceoryx2::prelude::{BackpressureStrategy, ipc};
use surefoot_controller_sim::channel::ReceiverStats;
use surefoot_controller_sim::channel::plan_subscriber::{ChunkDecision, PlanSubscriber, StreamEnd};
use surefoot_planner::channel::plan_publisher::{Delivery, PlanPublisher};
use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::participant::Participant;
use surefoot_shared_types::instance::sender::random_id;
use surefoot_shared_types::message::{Margins, PlanChunk};

use crate::private_folder::private_folder;

/// An instance in a folder of its own. [`TestInstance::close`] checks that no shared memory
/// remains.
pub struct TestInstance {
    base: tempfile::TempDir,
    instance: Option<Instance>,
}

impl TestInstance {
    pub fn new() -> Self {
        let base = private_folder("sf-test");
        let instance = Instance::create_in(base.path(), "transport").unwrap();
        Self { base, instance: Some(instance) }
    }

    /// Another handle on the instance, as in another process.
    pub fn attach(&self) -> Instance {
        Instance::attach_in(self.base.path(), "transport").unwrap()
    }

    pub fn close(mut self) {
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
pub fn accept_all(
    seen: &mut Vec<u64>,
    time_per_chunk: Duration,
) -> impl FnMut(&PlanChunk, &mut dyn FnMut()) -> ChunkDecision {
    accept_after(seen, move |_| std::thread::sleep(time_per_chunk))
}

/// Accepts every chunk after `pause`, which is given its sequence number, and records that.
pub fn accept_after(
    seen: &mut Vec<u64>,
    mut pause: impl FnMut(u64),
) -> impl FnMut(&PlanChunk, &mut dyn FnMut()) -> ChunkDecision {
    move |chunk, _| {
        pause(chunk.sequence);
        seen.push(chunk.sequence);
        ChunkDecision::Accepted(
            Margins { balance: 0.5, ..Margins::UNMEASURED },
            chunk.stream_after(),
        )
    }
}

/// Waits until another thread has counted to `count`, for a second at most.
pub fn wait_for(counted: &AtomicUsize, count: usize) {
    for _ in 0..10_000 {
        if counted.load(Ordering::Relaxed) >= count {
            return;
        }
        std::thread::sleep(Duration::from_micros(100));
    }
}

/// Repeats the last feedback until the planner leaves. A further chunk is an error.
pub fn linger(subscriber: &mut PlanSubscriber) {
    let mut check_chunk = |_: &PlanChunk, _: &mut dyn FnMut()| panic!("a chunk after the end");
    assert_eq!(
        subscriber.linger(&mut check_chunk, Some(Duration::from_secs(20)), &|| true).unwrap(),
        None
    );
}

pub fn deliver(instance: &Instance, chunks: &[PlanChunk]) -> Delivery {
    let mut publisher = PlanPublisher::open(instance, random_id()).unwrap();
    publisher.deliver(chunks, &mut |_| {}, &|| true).unwrap()
}

/// Runs a subscriber to the end of the plan; returns the checked sequence numbers.
pub fn receive(
    instance: &Instance,
    time_per_chunk: Duration,
) -> (StreamEnd, Vec<u64>, ReceiverStats) {
    receive_after(instance, |_| std::thread::sleep(time_per_chunk))
}

/// As [`receive`], with a pause before each chunk is accepted, as [`accept_after`] has it.
pub fn receive_after(
    instance: &Instance,
    pause: impl FnMut(u64),
) -> (StreamEnd, Vec<u64>, ReceiverStats) {
    let mut subscriber = PlanSubscriber::open(instance, random_id()).unwrap();
    let mut seen = Vec::new();
    let mut check_chunk = accept_after(&mut seen, pause);
    let mut ended = StreamEnd::PlannerLeft;
    while ended == StreamEnd::PlannerLeft {
        ended = subscriber.run(&mut check_chunk, &|| true).unwrap();
    }
    drop(check_chunk);
    linger(&mut subscriber);
    (ended, seen, subscriber.stats())
}

/// A participant, and a publisher of chunks that is not the planner's.
pub fn chunk_publisher(
    instance: &Instance,
) -> (Participant, Publisher<ipc::Service, PlanChunk, ()>) {
    let participant = Participant::open(instance).unwrap();
    let making = participant.making().unwrap();
    let builder = participant.chunks.publisher_builder();
    let publisher = builder.backpressure_strategy(BackpressureStrategy::DiscardData).create();
    drop(making);
    (participant, publisher.unwrap())
}
