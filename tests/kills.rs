//! Kills and stops the processes of running walks at random moments and asks that nothing is lost
//! and nothing walked twice.
//!
//! Two witnesses: the command's own report, and a logger that listens to the controllers' words all
//! the time. The long version runs by command:
//! `cargo test --release --test kills -- --ignored --nocapture`. A run is named by its seed:
//! `SUREFOOT_KILLS_SEED=7` replays another one.

#![allow(clippy::print_stdout, reason = "a test prints its results")]
#![allow(clippy::unwrap_used, reason = "a test ends where the command does not do its part")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

use std::fs;
use std::process::Child;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use command::{assert_nothing_left, finish, run, scenario, surefoot};
use serde_json::Value;
use surefoot_shared_types::instance::instance::{Instance, InstanceError};
use surefoot_shared_types::instance::observer::Observer;
use surefoot_shared_types::message::Feedback;

const SCENARIO: &str = "stepping_stones";
/// Disturbances that one walk suffers at the most.
const PER_WALK_MAX: u64 = 12;
/// The longest time between two disturbances.
const GAP_MILLIS_MAX: u64 = 220;
/// The longest stop.
const STOP_MILLIS_MAX: u64 = 120;

/// A small generator: the moments need no more.
struct Dice(u64);

impl Dice {
    fn roll(&mut self, sides: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) % sides
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Harm {
    Kill(&'static str),
    Stop(&'static str),
}

/// The harms to do, in an order that the dice choose; as many to the one side as to the other.
fn harms(kills: u64, stops: u64, dice: &mut Dice) -> Vec<Harm> {
    let side = |index: u64| if index.is_multiple_of(2) { "plan" } else { "control" };
    let kills = (0..kills).map(|index| Harm::Kill(side(index)));
    let stops = (0..stops).map(|index| Harm::Stop(side(index)));
    let mut harms: Vec<Harm> = kills.chain(stops).collect();
    for last in (1..harms.len()).rev() {
        harms.swap(last, dice.roll(last as u64 + 1) as usize);
    }
    harms
}

/// The running process of a role, by the command subcommand it was started with.
fn role(walk: u32, subcommand: &str) -> Option<libc::pid_t> {
    let children = fs::read_to_string(format!("/proc/{walk}/task/{walk}/children")).ok()?;
    let is_role = |child: &&str| {
        let line = fs::read(format!("/proc/{child}/cmdline")).unwrap_or_default();
        line.split(|byte| *byte == 0).nth(1) == Some(subcommand.as_bytes())
    };
    children.split_whitespace().find(is_role)?.parse().ok()
}

fn signal(pid: libc::pid_t, signal: libc::c_int) -> bool {
    // SAFETY: kill touches no memory.
    unsafe { libc::kill(pid, signal) == 0 }
}

fn sleep(millis: u64) {
    std::thread::sleep(Duration::from_millis(millis));
}

/// Does harm to a walk until it is over or has suffered enough; answers how many of `harms` were
/// done.
fn harm(walk: &mut Child, harms: &[Harm], dice: &mut Dice) -> usize {
    let mut done = 0;
    while done < harms.len() && (done as u64) < PER_WALK_MAX {
        sleep(dice.roll(GAP_MILLIS_MAX));
        if walk.try_wait().unwrap().is_some() {
            break;
        }
        done += match harms[done] {
            Harm::Kill(subcommand) => usize::from(
                role(walk.id(), subcommand).is_some_and(|pid| signal(pid, libc::SIGKILL)),
            ),
            Harm::Stop(subcommand) => {
                let Some(pid) =
                    role(walk.id(), subcommand).filter(|pid| signal(*pid, libc::SIGSTOP))
                else {
                    continue;
                };
                sleep(dice.roll(STOP_MILLIS_MAX));
                usize::from(signal(pid, libc::SIGCONT))
            }
        };
    }
    done
}

/// Listens to all controllers of a walk; returns the last feedback. Fails where the robot's
/// progress ever goes back.
fn log(name: &str, over: &AtomicBool) -> Option<Feedback> {
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
                    "walked went back: {} after {}",
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
                "a chunk was walked twice or left out"
            );
            last = Some(feedback);
        }
        sleep(1);
    }
    last
}

/// The digest and the number of chunks of the undisturbed plan.
fn undisturbed() -> (Value, u64) {
    let folder = tempfile::tempdir().unwrap();
    let json = folder.path().join("report.json");
    let output = run(&[
        "walk",
        &scenario(SCENARIO),
        "--quiet",
        "--threads",
        "1",
        "--json",
        json.to_str().unwrap(),
    ]);
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    let report: Value = serde_json::from_slice(&fs::read(json).unwrap()).unwrap();
    (report["digest"].clone(), report["chunks"]["accepted"].as_u64().unwrap())
}

/// One walk that suffers; answers how many harms it took.
fn suffer(harms: &[Harm], dice: &mut Dice, expected: &(Value, u64)) -> usize {
    let folder = tempfile::tempdir().unwrap();
    let json = folder.path().join("report.json");
    let arguments = [
        "walk",
        &scenario(SCENARIO),
        "--quiet",
        "--threads",
        "1",
        "--restarts-max",
        "1000",
        "--json",
        json.to_str().unwrap(),
    ];
    let mut walk = surefoot(&arguments).spawn().unwrap();
    let name = format!("walk-{}", walk.id());
    let over = AtomicBool::new(false);
    let (done, output, feedback) = std::thread::scope(|scope| {
        let logger = scope.spawn(|| log(&name, &over));
        let done = harm(&mut walk, harms, dice);
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

fn survive(kills: u64, stops: u64) {
    let seed =
        std::env::var("SUREFOOT_KILLS_SEED").ok().and_then(|text| text.parse().ok()).unwrap_or(1);
    let mut dice = Dice(seed);
    let harms = harms(kills, stops, &mut dice);
    let expected = undisturbed();
    let (mut done, mut walks) = (0, 0);
    while done < harms.len() {
        done += suffer(&harms[done..], &mut dice, &expected);
        walks += 1;
        if walks % 10 == 0 {
            println!("{walks} walks, {done} of {} harms", harms.len());
        }
        assert!(walks < 20 + 10 * harms.len(), "the walks are over before any harm is done");
    }
    println!(
        "seed {seed}: {walks} walks survived {kills} kills and {stops} stops: 0 chunks lost, 0 walked twice, nothing left"
    );
}

#[test]
fn walks_survive_a_few_kills_and_stops() {
    survive(16, 6);
}

#[test]
#[ignore = "takes a quarter of an hour; run it by command"]
fn walks_survive_a_thousand_kills_and_two_hundred_stops() {
    survive(1000, 200);
}
