//! Plans whose first chunks are sent while the rest is made: the order of events, restarts, and
//! every end on the way.

#![allow(clippy::unwrap_used, reason = "a transport that cannot be opened fails the test")]
#![allow(clippy::disallowed_methods, reason = "a test that hangs ends")]

#[path = "common/chunk_stream.rs"]
mod chunk_stream;
#[path = "common/command.rs"]
mod command;
#[path = "common/private_folder.rs"]
mod private_folder;

use std::cell::Cell;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use chunk_stream::plan;
use command::{assert_nothing_left, finish, role, run, scenario, surefoot};
use private_folder::private_folder;
use serde_json::Value;
use surefoot_controller_sim::channel::plan_subscriber::{ChunkDecision, PlanSubscriber, StreamEnd};
use surefoot_planner::channel::chunk_source::{ChunkSource, SourceState};
use surefoot_planner::channel::plan_publisher::{Delivery, PlanPublisher};
use surefoot_planner::channel::send_window::DeliveryOutcome;
use surefoot_shared_types::instance::Instance;
use surefoot_shared_types::instance::observer::Observer;
use surefoot_shared_types::instance::sender::random_id;
use surefoot_shared_types::message::{Check, Margins, PlanChunk};

/// Longest time of a delivery before its test fails.
const LONGEST_WAIT: Duration = Duration::from_secs(60);

/// A planner that makes a chunk only once the controller has accepted the one before.
struct Hesitant<'a> {
    chunks: &'a [PlanChunk],
    made: usize,
    /// The number of chunks after which it makes no more.
    end: usize,
    accepted: &'a Cell<u64>,
}

impl ChunkSource for Hesitant<'_> {
    fn chunks(&self) -> &[PlanChunk] {
        &self.chunks[..self.made]
    }

    fn state(&self) -> SourceState {
        match (self.made == self.chunks.len(), self.made == self.end) {
            (true, _) => SourceState::Complete,
            (_, true) => SourceState::Ended,
            _ => SourceState::Open,
        }
    }

    fn advance(&mut self) {
        if self.accepted.get() == self.made as u64 {
            self.made += 1;
        }
    }
}

/// Delivers the first `end` chunks of a plan as they are made to a controller that refuses the
/// chunk `refused`. Returns the delivery, how receiving ended, and the chunks received.
fn deliver(
    chunks: &[PlanChunk],
    end: usize,
    refused: Option<u64>,
) -> (Delivery, StreamEnd, Vec<u64>) {
    let base = private_folder("sf-grow");
    let instance = Instance::create_in(base.path(), "growing").unwrap();
    std::thread::scope(|scope| {
        let controller = scope.spawn(|| {
            let instance = Instance::attach_in(base.path(), "growing").unwrap();
            let mut subscriber = PlanSubscriber::open(&instance, random_id()).unwrap();
            let mut seen = Vec::new();
            let mut check = |chunk: &PlanChunk, _: &mut dyn FnMut()| {
                seen.push(chunk.sequence);
                if refused == Some(chunk.sequence) {
                    let (check, waypoint) = (Check::Balance, 1);
                    return ChunkDecision::Refused { check, waypoint, correction: None };
                }
                ChunkDecision::Accepted(Margins::UNMEASURED, chunk.stream_after())
            };
            let begun = Instant::now();
            let keep_going = || begun.elapsed() < LONGEST_WAIT;
            let ended = subscriber.run(&mut check, &keep_going).unwrap();
            let _ = subscriber.linger(&mut check, Some(LONGEST_WAIT), &keep_going).unwrap();
            (ended, seen)
        });
        let accepted = Cell::new(0);
        let mut publisher = PlanPublisher::open(&instance, random_id()).unwrap();
        let mut source = Hesitant { chunks, made: 0, end, accepted: &accepted };
        let begun = Instant::now();
        let delivery = publisher.deliver_from(
            &mut source,
            &mut |feedback| accepted.set(feedback.next_sequence),
            &|| begun.elapsed() < LONGEST_WAIT,
        );
        drop(publisher);
        let (ended, seen) = controller.join().unwrap();
        (delivery.unwrap(), ended, seen)
    })
}

#[test]
fn chunks_are_accepted_before_the_next_ones_are_made() {
    let (delivery, ended, seen) = deliver(&plan(12), 12, None);
    assert_eq!((delivery.outcome, delivery.accepted), (DeliveryOutcome::Accepted, 12));
    assert_eq!((ended, seen), (StreamEnd::Finished, (0..12).collect::<Vec<_>>()));
    assert_eq!((delivery.sent, delivery.resent), (12, 0));
    assert!(delivery.first_sent.is_some());
}

#[test]
fn a_plan_that_ends_on_the_way_is_delivered_as_far_as_it_goes() {
    let (delivery, ended, seen) = deliver(&plan(12), 5, None);
    assert_eq!((delivery.outcome, delivery.accepted), (DeliveryOutcome::Incomplete, 5));
    assert_eq!((ended, seen), (StreamEnd::PlannerLeft, (0..5).collect::<Vec<_>>()));
}

#[test]
fn a_refusal_ends_a_delivery_whose_plan_is_not_complete() {
    let (delivery, ended, seen) = deliver(&plan(12), 12, Some(3));
    let refused = DeliveryOutcome::Refused { sequence: 3, check: Check::Balance, waypoint: 1 };
    assert_eq!((delivery.outcome, delivery.accepted, seen), (refused, 3, vec![0, 1, 2, 3]));
    assert!(matches!(ended, StreamEnd::Refused(_)), "{ended:?}");
}

/// The report of a walk.
fn report(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

/// Waits until the controller of a walk has accepted its first chunk.
fn wait_for_first_chunk(name: &str) {
    let begun = Instant::now();
    let mut observer = None;
    while begun.elapsed() < LONGEST_WAIT {
        std::thread::sleep(Duration::from_millis(1));
        let Some(observer) = &observer else {
            observer = Instance::attach(name).ok().and_then(|it| Observer::open(&it).ok());
            continue;
        };
        while let Some(feedback) = observer.feedback().unwrap() {
            if feedback.next_sequence > 0 {
                return;
            }
        }
    }
    panic!("no chunk was accepted");
}

#[test]
fn a_planner_that_is_killed_after_its_first_chunk_left_makes_the_same_plan_again() {
    let folder = tempfile::tempdir().unwrap();
    let json = folder.path().join("report.json");
    let arguments = ["walk", &scenario("flat_walk"), "--quiet", "--json", json.to_str().unwrap()];
    let undisturbed = run(&arguments);
    assert_eq!(undisturbed.code, 0, "{}{}", undisturbed.out, undisturbed.err);
    let expected = report(&json);
    let walk = surefoot(&arguments).spawn().unwrap();
    let id = walk.id();
    wait_for_first_chunk(&format!("walk-{id}"));
    // SAFETY: kill touches no memory.
    unsafe { libc::kill(role(id, "plan").unwrap(), libc::SIGKILL) };
    let output = finish(walk);
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    assert_nothing_left(output.pid);
    let report = report(&json);
    assert_eq!((&report["outcome"], &report["restarts"]), (&"accepted".into(), &1.into()));
    assert_eq!((&report["digest"], &report["walk"]), (&expected["digest"], &expected["walk"]));
    for count in ["sent", "accepted", "lost", "refused"] {
        assert_eq!(report["chunks"][count], expected["chunks"][count], "{report}");
    }
}

/// Walks with a limit of the work that the search needs, but not the smooth motion. Returns the
/// exit code and the report.
fn walk_with_little_work(replans_max: &str) -> (i32, Value) {
    let folder = tempfile::tempdir().unwrap();
    let (text, json) = (folder.path().join("little_work.toml"), folder.path().join("report.json"));
    let shipped = fs::read_to_string(scenario("flat_walk")).unwrap();
    let configs = format!("\"{}/", fs::canonicalize("configs").unwrap().display());
    let limit = format!("\n[planner]\nwork_max = {LITTLE_WORK}\n");
    fs::write(&text, shipped.replace("\"../", &configs) + &limit).unwrap();
    let [text, json_path] = [&text, &json].map(|path| path.to_str().unwrap());
    let output = run(&["walk", text, "--quiet", "--json", json_path, "--replans-max", replans_max]);
    assert_nothing_left(output.pid);
    (output.code, report(&json))
}

/// Work units that bring some of the chunks of flat_walk.
const LITTLE_WORK: u64 = 16_000;

#[test]
fn a_walk_whose_work_runs_out_goes_on_from_where_the_robot_stands() {
    let (code, report) = walk_with_little_work("8");
    assert_eq!((code, &report["outcome"]), (0, &"accepted".into()), "{report}");
    assert!(report["replans"].as_u64().unwrap() > 0, "{report}");
    assert_eq!(report["chunks"]["lost"], 0, "{report}");
}

#[test]
fn a_walk_whose_work_runs_out_for_good_ends_at_rest() {
    let (code, report) = walk_with_little_work("0");
    assert_eq!((code, &report["outcome"]), (3, &"budget_exhausted".into()), "{report}");
    let accepted = report["chunks"]["accepted"].as_u64().unwrap();
    assert!(accepted > 0 && report["chunks"]["sent"] == accepted, "{report}");
    assert_eq!((&report["chunks"]["lost"], &report["bound"]), (&0.into(), &"work_max".into()));
}
