//! Kills and stops the processes of running walks at random times. No chunk may be lost, and none
//! executed twice, according to the command's report and to all feedback that an observer receives.
//!
//! The long version: `cargo test --release --test kills -- --ignored --nocapture`.
//! `SUREFOOT_KILLS_SEED=7` sets another seed.

#![allow(clippy::print_stdout, reason = "a test prints its results")]
#![allow(clippy::unwrap_used, reason = "a command that fails unexpectedly fails the test")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;
#[path = "common/random.rs"]
mod random;

use std::fs;
use std::path::Path;
use std::process::Child;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use command::{assert_nothing_left, finish, role, run, scenario, surefoot};
use random::Random;
use serde_json::Value;
use surefoot_shared_types::instance::error::InstanceError;
use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::observer::Observer;
use surefoot_shared_types::message::Feedback;

const SCENARIO: &str = "stepping_stones";
/// Most faults in one walk.
const PER_WALK_MAX: u64 = 12;
/// Longest time between two faults, ms.
const GAP_MILLIS_MAX: u64 = 220;
/// Longest stop, ms.
const STOP_MILLIS_MAX: u64 = 120;

/// Straight lines as fast as possible, and smooth motion in real time, twenty times as fast: there
/// the robot moves when its controller is killed.
const MOTIONS: [&[&str]; 2] =
    [&["--motion", "quasi_static"], &["--motion", "smooth", "--rate", "20"]];

#[derive(Clone, Copy, PartialEq)]
enum Fault {
    Kill(&'static str),
    Stop(&'static str),
}

/// Faults in random order, equally many for both roles.
fn faults(kills: u64, stops: u64, random: &mut Random) -> Vec<Fault> {
    let side = |index: u64| if index.is_multiple_of(2) { "plan" } else { "control" };
    let kills = (0..kills).map(|index| Fault::Kill(side(index)));
    let stops = (0..stops).map(|index| Fault::Stop(side(index)));
    let mut faults: Vec<Fault> = kills.chain(stops).collect();
    for last in (1..faults.len()).rev() {
        faults.swap(last, random.below(last as u64 + 1) as usize);
    }
    faults
}

fn signal(pid: libc::pid_t, signal: libc::c_int) -> bool {
    // SAFETY: kill touches no memory.
    unsafe { libc::kill(pid, signal) == 0 }
}

fn sleep(millis: u64) {
    std::thread::sleep(Duration::from_millis(millis));
}

/// Injects faults into a walk until it ends or has [`PER_WALK_MAX`]; returns how many.
fn inject(walk: &mut Child, faults: &[Fault], random: &mut Random) -> usize {
    let mut done = 0;
    while done < faults.len() && (done as u64) < PER_WALK_MAX {
        sleep(random.below(GAP_MILLIS_MAX));
        if walk.try_wait().unwrap().is_some() {
            break;
        }
        done += match faults[done] {
            Fault::Kill(subcommand) => usize::from(
                role(walk.id(), subcommand).is_some_and(|pid| signal(pid, libc::SIGKILL)),
            ),
            Fault::Stop(subcommand) => {
                let Some(pid) =
                    role(walk.id(), subcommand).filter(|pid| signal(*pid, libc::SIGSTOP))
                else {
                    continue;
                };
                sleep(random.below(STOP_MILLIS_MAX));
                usize::from(signal(pid, libc::SIGCONT))
            }
        };
    }
    done
}

/// Observes all controllers of a walk; returns the last feedback. Fails if the robot's progress
/// ever decreases.
fn observe(name: &str, over: &AtomicBool) -> Option<Feedback> {
    let mut observer = None;
    let mut last: Option<Feedback> = None;
    while !over.load(Ordering::Relaxed) {
        let Some(observer) = &observer else {
            match Instance::attach(name) {
                Ok(instance) => observer = Observer::open(&instance).ok(),
                Err(InstanceError::Missing { .. }) => {}
                Err(error) => panic!("{error}"),
            }
            sleep(1);
            continue;
        };
        while let Some(feedback) = observer.feedback().unwrap() {
            if let Some(before) = &last {
                assert!(
                    feedback.walked >= before.walked,
                    "walked decreases: {} after {}",
                    feedback.walked,
                    before.walked
                );
                assert!(
                    feedback.next_sequence >= before.next_sequence,
                    "{} after {}",
                    feedback.next_sequence,
                    before.next_sequence
                );
            }
            assert_eq!(
                feedback.walked, feedback.next_sequence,
                "a chunk was executed twice or left out"
            );
            last = Some(feedback);
        }
        sleep(1);
    }
    last
}

/// The arguments of a walk with a report.
fn arguments<'a>(scenario: &'a str, json: &'a Path, motion: &[&'a str]) -> Vec<&'a str> {
    let path = json.to_str().unwrap();
    let walk = ["walk", scenario, "--quiet", "--threads", "1", "--restarts-max", "1000"];
    [&walk, &["--json", path][..], motion].concat()
}

/// The digest and the number of chunks of the undisturbed plan.
fn undisturbed(motion: &[&str]) -> (Value, u64) {
    let folder = tempfile::tempdir().unwrap();
    let json = folder.path().join("report.json");
    let output = run(&arguments(&scenario(SCENARIO), &json, motion));
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    let report: Value = serde_json::from_slice(&fs::read(json).unwrap()).unwrap();
    (report["digest"].clone(), report["chunks"]["accepted"].as_u64().unwrap())
}

/// One walk with faults; returns how many were injected.
fn walk_with_faults(
    motion: &[&str],
    faults: &[Fault],
    random: &mut Random,
    expected: &(Value, u64),
) -> usize {
    let folder = tempfile::tempdir().unwrap();
    let json = folder.path().join("report.json");
    let mut walk = surefoot(&arguments(&scenario(SCENARIO), &json, motion)).spawn().unwrap();
    let name = format!("walk-{}", walk.id());
    let over = AtomicBool::new(false);
    let (done, output, feedback) = std::thread::scope(|scope| {
        let logger = scope.spawn(|| observe(&name, &over));
        let done = inject(&mut walk, faults, random);
        let output = finish(walk);
        over.store(true, Ordering::Relaxed);
        (done, output, logger.join().unwrap())
    });
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    assert_nothing_left(output.pid);
    let report: Value = serde_json::from_slice(&fs::read(&json).unwrap()).unwrap();
    let chunks = &report["chunks"];
    assert_eq!(report["outcome"], "accepted", "{report}");
    assert_eq!(report["digest"], expected.0, "{report}");
    assert_eq!(
        (chunks["accepted"].as_u64(), chunks["sent"].as_u64()),
        (Some(expected.1), Some(expected.1)),
        "{report}"
    );
    assert_eq!(
        (chunks["lost"].as_u64(), chunks["refused"].as_u64()),
        (Some(0), Some(0)),
        "{report}"
    );
    if let Some(feedback) = feedback.filter(|feedback| feedback.finished == 1) {
        assert_eq!(
            (feedback.walked, Value::from(feedback.stream.to_string())),
            (expected.1, expected.0.clone())
        );
    }
    done
}

fn survive(motion: &[&str], kills: u64, stops: u64) {
    let seed =
        std::env::var("SUREFOOT_KILLS_SEED").ok().and_then(|text| text.parse().ok()).unwrap_or(1);
    let mut random = Random(seed);
    let faults = faults(kills, stops, &mut random);
    let expected = undisturbed(motion);
    let (mut done, mut walks) = (0, 0);
    while done < faults.len() {
        done += walk_with_faults(motion, &faults[done..], &mut random, &expected);
        walks += 1;
        if walks % 10 == 0 {
            println!("{walks} walks, {done} of {} faults", faults.len());
        }
        assert!(walks < 20 + 10 * faults.len(), "the walks end before a fault is injected");
    }
    println!(
        "seed {seed}: {walks} walks survived {kills} kills and {stops} stops: 0 chunks lost, 0 executed twice, no shared memory remains"
    );
}

#[test]
fn walks_survive_a_few_kills_and_stops() {
    MOTIONS.into_iter().for_each(|motion| survive(motion, 12, 4));
}

#[test]
#[ignore = "takes 15 minutes"]
fn walks_survive_a_thousand_kills_and_two_hundred_stops() {
    MOTIONS.into_iter().for_each(|motion| survive(motion, 500, 100));
}
