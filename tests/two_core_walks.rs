//! The planner on one core and the controller on another, over a whole walk at the pace of a real
//! robot.
//!
//! Every chunk must be there before the robot needs it; what the transport adds to a verdict is put
//! beside a raw ping-pong through shared memory in the same run. Only counts, orders and ratios are
//! asserted. On one core the pinning is skipped.

#![allow(clippy::print_stdout, reason = "a test prints its results")]
#![allow(clippy::unwrap_used, reason = "a test ends where the transport cannot be opened")]

#[path = "../planner/tests/common/preparation.rs"]
mod preparation;

use std::fs;
use std::io::{Read, Write};
use std::os::unix::fs::PermissionsExt;
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use preparation::preparation_for;
use surefoot::system::cores;
use surefoot_controller_sim::channel::plan_subscriber::{ChunkDecision, PlanSubscriber, StreamEnd};
use surefoot_controller_sim::{Checker, ChunkExecutor, Identity};
use surefoot_planner::channel::plan_publisher::PlanPublisher;
use surefoot_planner::channel::send_window::DeliveryOutcome;
use surefoot_planner::{Planner, Status};
use surefoot_shared_types::config::load::load_scenario;
use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::random_id;
use surefoot_shared_types::message::PlanChunk;
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::world::load::load_world;

/// Faster than real time, so that a test is over soon: seconds of the walk in a second of the test.
const HASTE: f64 = 4.0;
/// What the median outside the check may be of that of two sides that sleep in the kernel between
/// pings: with a generous factor for a machine that does other work beside.
const RATIO_MAX: f64 = 100.0;
/// Pings of the sleeping sides.
const SLEEPY_PINGS: u64 = 200;
/// Round trips of the ping-pong.
const PINGS: u64 = 20_000;

#[allow(clippy::disallowed_methods, reason = "this test measures time")]
fn now() -> Instant {
    Instant::now()
}

/// What the controller's side saw.
#[derive(Default)]
struct Log {
    /// Seconds by which each chunk came before the robot reached its start; negative means that the
    /// robot waited.
    ahead: Vec<f64>,
    /// Sequence numbers in the order in which they were checked.
    order: Vec<u64>,
    /// Seconds that each check took.
    check_seconds: Vec<f64>,
}

/// The robot's pace: judges a chunk when it comes, and counts when it would have been needed.
fn control(instance: &Instance, scenario: &str) -> Log {
    let scenario = load_scenario(scenario.as_ref()).unwrap();
    let (model, world) =
        (load_robot(&scenario.robot_path).unwrap(), load_world(&scenario.world_path).unwrap());
    let id = random_id();
    let identity = Identity {
        controller_id: id,
        robot: model.digest,
        world: world.digest,
        config: scenario.digest,
    };
    let mut executor =
        ChunkExecutor::new(Checker::new(model, world, scenario.checker).unwrap(), identity);
    let mut subscriber = PlanSubscriber::open(instance, id).unwrap();
    let mut log = Log::default();
    let mut walk_began: Option<Instant> = None;
    let mut check_chunk = |chunk: &PlanChunk, heartbeat: &mut dyn FnMut()| {
        let came = now();
        let began = *walk_began.get_or_insert(came);
        let needed = chunk.waypoints()[0].time / HASTE;
        log.ahead.push(needed - came.duration_since(began).as_secs_f64());
        log.order.push(chunk.sequence);
        let margins = executor.check_and_execute(chunk).unwrap();
        log.check_seconds.push(came.elapsed().as_secs_f64());
        heartbeat();
        ChunkDecision::Accepted(margins, executor.stream())
    };
    let ended = subscriber.run(&mut check_chunk, &|| true).unwrap();
    assert_eq!(ended, StreamEnd::Finished);
    subscriber
        .linger(&mut |_, _| panic!("a chunk after the end"), Some(Duration::from_secs(10)), &|| {
            true
        })
        .unwrap();
    log
}

/// Plans the walk; its chunks.
fn plan(scenario: &str) -> Vec<PlanChunk> {
    let scenario = load_scenario(scenario.as_ref()).unwrap();
    let (model, world) =
        (load_robot(&scenario.robot_path).unwrap(), load_world(&scenario.world_path).unwrap());
    let mut planner =
        Planner::builder(&model, &world, &scenario, preparation_for(&model, &scenario.planner))
            .build()
            .unwrap();
    while planner.step(100_000) == Status::Working {}
    assert!(!planner.chunks().is_empty());
    planner.chunks().to_vec()
}

/// The median round trip of two counters in shared memory, s.
fn ping_pong(cores: (Option<usize>, Option<usize>)) -> f64 {
    let (ping, pong) = (AtomicU64::new(0), AtomicU64::new(0));
    std::thread::scope(|scope| {
        scope.spawn(|| {
            cores::pin(cores.1);
            for number in 1..=PINGS {
                while ping.load(Ordering::Acquire) < number {
                    relax(cores);
                }
                pong.store(number, Ordering::Release);
            }
        });
        let driver = scope.spawn(|| {
            cores::pin(cores.0);
            let mut trips: Vec<f64> = Vec::new();
            for number in 1..=PINGS {
                let sent = now();
                ping.store(number, Ordering::Release);
                while pong.load(Ordering::Acquire) < number {
                    relax(cores);
                }
                trips.push(sent.elapsed().as_secs_f64());
            }
            median(&mut trips)
        });
        driver.join().unwrap()
    })
}

/// The median round trip of a byte between two sides that sleep until it comes, as ours do while a
/// chunk is checked, s.
fn sleepy_ping_pong(cores: (Option<usize>, Option<usize>)) -> f64 {
    let (mut near, mut far) = UnixStream::pair().unwrap();
    std::thread::scope(|scope| {
        scope.spawn(move || {
            cores::pin(cores.1);
            let mut byte = [0];
            while far.read_exact(&mut byte).is_ok() {
                far.write_all(&byte).unwrap();
            }
        });
        let driver = scope.spawn(move || {
            cores::pin(cores.0);
            let mut trips: Vec<f64> = Vec::new();
            for _ in 0..SLEEPY_PINGS {
                std::thread::sleep(Duration::from_millis(2));
                let sent = now();
                near.write_all(&[1]).unwrap();
                near.read_exact(&mut [0]).unwrap();
                trips.push(sent.elapsed().as_secs_f64());
            }
            median(&mut trips)
        });
        driver.join().unwrap()
    })
}

fn relax(cores: (Option<usize>, Option<usize>)) {
    if cores.1.is_some() { std::hint::spin_loop() } else { std::thread::yield_now() }
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Counts of times by powers of two of a microsecond.
fn histogram(seconds: &[f64]) -> String {
    let bucket = |second: &f64| (1e6 * second).max(1.0).log2() as usize;
    let mut counts = [0_u32; 40];
    seconds.iter().for_each(|second| counts[bucket(second).min(39)] += 1);
    let used = counts.iter().enumerate().filter(|(_, count)| **count > 0);
    used.map(|(power, count)| format!("{} us: {count}", 1_u64 << power))
        .collect::<Vec<_>>()
        .join(", ")
}

fn walk_at_pace(name: &str) {
    let scenario = format!("configs/scenarios/{name}.toml");
    let cores = cores::cores_of_roles(1);
    if cores.1.is_none() {
        println!("one core: nothing is pinned");
    }
    let private = fs::Permissions::from_mode(0o700);
    let base = tempfile::Builder::new()
        .prefix("sf-two")
        .permissions(private)
        .tempdir_in("/dev/shm")
        .unwrap();
    let instance = Instance::create_in(base.path(), "two").unwrap();
    let chunks = plan(&scenario);
    let (log, verdicts) = std::thread::scope(|scope| {
        let controller = scope.spawn(|| {
            cores::pin(cores.1);
            control(&instance, &scenario)
        });
        let planner = scope.spawn(|| {
            cores::pin(cores.0);
            let mut sender = PlanPublisher::open(&instance, random_id()).unwrap();
            // One on its way at a time: the time between two verdicts is then a publication, a
            // judgement and an answer.
            sender.set_window_chunks(1);
            let mut verdicts = Vec::new();
            let mut received = (0, now());
            let mut note = |feedback: &surefoot_shared_types::message::Feedback| {
                if feedback.next_sequence > received.0 {
                    verdicts.push(received.1.elapsed().as_secs_f64());
                    received = (feedback.next_sequence, now());
                }
            };
            let delivery = sender.deliver(&chunks, &mut note, &|| true).unwrap();
            assert_eq!(
                (delivery.outcome, delivery.accepted),
                (DeliveryOutcome::Accepted, chunks.len() as u64)
            );
            assert_eq!(delivery.resent, 0);
            verdicts
        });
        (controller.join().unwrap(), planner.join().unwrap())
    });
    assert_eq!(log.order, (0..chunks.len() as u64).collect::<Vec<_>>());
    let starved = log.ahead.iter().skip(1).filter(|ahead| **ahead < 0.0).count();
    assert_eq!(starved, 0, "{name}: the robot waited for {starved} chunks: {:?}", log.ahead);
    assert_eq!(verdicts.len(), chunks.len());
    let mut overhead: Vec<f64> = verdicts
        .iter()
        .zip(&log.check_seconds)
        .skip(1)
        .map(|(verdict, checked)| verdict - checked)
        .collect();
    let (raw, sleepy) = (ping_pong(cores), sleepy_ping_pong(cores));
    println!("{name}: publication to verdict: {}", histogram(&verdicts[1..]));
    println!("{name}: of it outside the check: {}", histogram(&overhead));
    let median = median(&mut overhead);
    println!(
        "{name}: median outside the check {:.1} us: {:.1} times a spinning ping-pong, {:.1} times a sleeping one",
        1e6 * median,
        median / raw,
        median / sleepy
    );
    assert!(median < RATIO_MAX * sleepy, "{name}: {median} s against {sleepy} s");
}

#[test]
fn flat_walk_never_starves_the_robot() {
    walk_at_pace("flat_walk");
}

#[test]
fn stepping_stones_never_starve_the_robot() {
    walk_at_pace("stepping_stones");
}
