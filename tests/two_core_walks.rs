//! Planner and controller on two cores, over a walk with the timing of a real robot.
//!
//! Every chunk must arrive before the robot needs it. The time of the transport is compared with a
//! raw ping-pong through shared memory in the same run. Only counts, orders and ratios are
//! asserted. On a machine with one core nothing is pinned.

#![allow(clippy::print_stdout, reason = "a test prints its results")]
#![allow(clippy::unwrap_used, reason = "a transport that cannot be opened fails the test")]

#[path = "common/executor.rs"]
mod executor;
#[path = "../planner/tests/common/preparation.rs"]
mod preparation;
#[path = "common/private_folder.rs"]
mod private_folder;

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use executor::executor;
use preparation::preparation_for;
use private_folder::private_folder;
use surefoot::system::cores;
use surefoot_controller_sim::channel::plan_subscriber::{ChunkDecision, PlanSubscriber, StreamEnd};
use surefoot_planner::channel::plan_publisher::PlanPublisher;
use surefoot_planner::channel::send_window::DeliveryOutcome;
use surefoot_planner::{Planner, Status};
use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::sender::random_id;
use surefoot_shared_types::message::{Feedback, PlanChunk};
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::scenario::load::load_scenario;
use surefoot_shared_types::world::load::load_world;

/// Seconds of the walk per second of the test.
const SPEED_UP: f64 = 4.0;
/// Largest ratio of the median time outside the check to the median round trip of two threads that
/// block between pings. Large, for machines with other load.
const RATIO_MAX: f64 = 100.0;
/// Round trips of the blocking ping-pong.
const BLOCKING_PINGS: u64 = 200;
/// Round trips of the spinning ping-pong.
const PINGS: u64 = 20_000;

#[allow(clippy::disallowed_methods, reason = "this test measures time")]
fn now() -> Instant {
    Instant::now()
}

/// The controller's measurements.
#[derive(Default)]
struct Log {
    /// Time between the arrival of each chunk and its start, s; negative if the robot waited.
    ahead: Vec<f64>,
    /// Sequence numbers in the order of the checks.
    order: Vec<u64>,
    /// Duration of each check, s.
    check_seconds: Vec<f64>,
}

/// Runs a controller: checks each chunk on arrival and records when the robot needs it.
fn control(instance: &Instance, scenario: &str) -> Log {
    let id = random_id();
    let (mut executor, _) = executor(scenario, id);
    let mut subscriber = PlanSubscriber::open(instance, id).unwrap();
    let mut log = Log::default();
    let mut walk_began: Option<Instant> = None;
    let mut check_chunk = |chunk: &PlanChunk, heartbeat: &mut dyn FnMut()| {
        let arrived = now();
        let began = *walk_began.get_or_insert(arrived);
        let needed = chunk.waypoints()[0].time / SPEED_UP;
        log.ahead.push(needed - arrived.duration_since(began).as_secs_f64());
        log.order.push(chunk.sequence);
        let margins = executor.check_and_execute(chunk).unwrap();
        log.check_seconds.push(arrived.elapsed().as_secs_f64());
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

/// The chunks of a scenario's plan.
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

/// The median round trip of a byte between two threads that block until it arrives, as planner and
/// controller do while a chunk is checked, s.
fn blocking_ping_pong(cores: (Option<usize>, Option<usize>)) -> f64 {
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
            for _ in 0..BLOCKING_PINGS {
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

fn walk_in_real_time(name: &str) {
    let scenario = format!("configs/scenarios/{name}.toml");
    let cores = cores::cores_of_roles(1);
    if cores.1.is_none() {
        println!("one core: nothing is pinned");
    }
    let base = private_folder("sf-two");
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
            // One chunk at a time, so that the time between two verdicts is one publication, one
            // check and one feedback.
            sender.set_window_chunks(1);
            let mut verdicts = Vec::new();
            let mut received = (0, now());
            let mut note = |feedback: &Feedback| {
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
    let late = log.ahead.iter().skip(1).filter(|ahead| **ahead < 0.0).count();
    assert_eq!(late, 0, "{name}: the robot waited for {late} chunks: {:?}", log.ahead);
    assert_eq!(verdicts.len(), chunks.len());
    let mut overhead: Vec<f64> = verdicts
        .iter()
        .zip(&log.check_seconds)
        .skip(1)
        .map(|(verdict, checked)| verdict - checked)
        .collect();
    let (raw, blocking) = (ping_pong(cores), blocking_ping_pong(cores));
    println!("{name}: publication to verdict: {}", histogram(&verdicts[1..]));
    println!("{name}: outside the check: {}", histogram(&overhead));
    let median = median(&mut overhead);
    println!(
        "{name}: median outside the check {:.1} us: {:.1} times a spinning ping-pong, {:.1} times a blocking one",
        1e6 * median,
        median / raw,
        median / blocking
    );
    assert!(median < RATIO_MAX * blocking, "{name}: {median} s against {blocking} s");
}

#[test]
fn the_robot_never_waits_on_flat_walk() {
    walk_in_real_time("flat_walk");
}

#[test]
fn the_robot_never_waits_on_stepping_stones() {
    walk_in_real_time("stepping_stones");
}
