//! The library's ends of the transport: a plan and its replan are delivered, and read by others.

#![allow(clippy::unwrap_used, reason = "a call that fails fails the test")]

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use surefoot::{
    DeliveryOutcome, Event, Goal, Message, Parameters, Plan, PlanChunk, Planner, Prepared,
    Publisher, Robot, Stance, Subscriber, World,
};
use surefoot_controller_sim::channel::plan_subscriber::{ChunkDecision, PlanSubscriber};
use surefoot_shared_types::instance::Instance;
use surefoot_shared_types::instance::sender::random_id;
use surefoot_shared_types::message::Margins;

/// Two walks, the second from where the first one ends.
fn plans() -> [Plan; 2] {
    let robot = Robot::load("configs/robots/hubo/robot.toml").unwrap();
    let world = World::load("configs/worlds/flat_walk.toml").unwrap();
    let cache = Path::new(env!("CARGO_TARGET_TMPDIR")).join("surefoot");
    let prepared = Prepared::in_folder(&robot, &Parameters::default(), cache).unwrap();
    let mut planner = Planner::builder(&prepared, &world).build().unwrap();
    let plan = planner.plan(Stance::at(0.5, 0.0, 0.0), Goal::at(0.8, 0.0, 0.0)).unwrap();
    let there = plan.sample(plan.duration());
    let on = planner.replan(&there, &Event::GoalChanged(Goal::at(1.1, 0.0, 0.0))).unwrap();
    [plan, on]
}

/// The epoch and the sequence number of every chunk that a controller checks, until it is over.
fn received(instance: &Instance, is_over: &AtomicBool) -> Vec<(u64, u64)> {
    let mut subscriber = PlanSubscriber::open(instance, random_id()).unwrap();
    let mut seen = vec![];
    let mut accept = |chunk: &PlanChunk, _: &mut dyn FnMut()| {
        seen.push((chunk.epoch, chunk.sequence));
        ChunkDecision::Accepted(Margins::UNMEASURED, chunk.stream_after())
    };
    while !is_over.load(Ordering::Relaxed) {
        subscriber.run(&mut accept, &|| !is_over.load(Ordering::Relaxed)).unwrap();
    }
    seen
}

#[test]
fn a_plan_and_its_replan_are_delivered_and_read_by_others() {
    let plans = plans();
    let name = format!("library-{}", std::process::id());
    let mut publisher = Publisher::open(&name).unwrap();
    let (instance, is_over) = (Instance::attach(&name).unwrap(), AtomicBool::new(false));
    let mut reader = Subscriber::open(&name).unwrap();
    let seen = std::thread::scope(|scope| {
        let controller = scope.spawn(|| received(&instance, &is_over));
        let outcomes = plans.each_ref().map(|plan| publisher.deliver(plan).unwrap().outcome);
        let mut messages = std::iter::from_fn(|| reader.next().unwrap());
        let (first, is_answered) =
            (messages.next(), messages.any(|message| matches!(message, Message::Feedback(_))));
        is_over.store(true, Ordering::Relaxed);
        assert_eq!(outcomes, [DeliveryOutcome::Accepted; 2]);
        assert!(matches!(first, Some(Message::Chunk(chunk)) if chunk.sequence == 0));
        assert!(is_answered);
        controller.join().unwrap()
    });
    let chunks = plans.iter().flat_map(Plan::chunks);
    assert_eq!(seen, chunks.map(|chunk| (chunk.epoch, chunk.sequence)).collect::<Vec<_>>());
}
