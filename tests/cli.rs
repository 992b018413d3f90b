//! The command's manners: what it says and how it ends when something is wrong, and what it leaves
//! behind.

#![allow(clippy::unwrap_used, reason = "a test ends where the command does not do its part")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

#[allow(dead_code, reason = "cargo calls its main, these tests call the rest")]
#[path = "../build.rs"]
mod build_script;

use std::fs;
use std::path::Path;
use std::process::Command;

use command::{CommandOutput, assert_nothing_left, run, scenario};
use surefoot_shared_types::scenario::load::load_scenario;

/// A folder with a copy of flat_walk in which `from` is replaced by `to`.
struct TestFolder {
    folder: tempfile::TempDir,
}

impl TestFolder {
    fn new(from: &str, to: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let configs = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
        let text = fs::read_to_string(configs.join("scenarios/flat_walk.toml")).unwrap();
        assert!(text.contains(from), "flat_walk.toml has no '{from}'");
        let text =
            text.replacen(from, to, 1).replace("\"../", &format!("\"{}/", configs.display()));
        fs::write(folder.path().join("scenario.toml"), text).unwrap();
        Self { folder }
    }

    fn path(&self, name: &str) -> String {
        self.folder.path().join(name).to_str().unwrap().to_owned()
    }

    fn files(&self) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(self.folder.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

fn assert_bad_input(output: &CommandOutput, expected: &str) {
    assert_eq!(output.code, 2, "{}{}", output.out, output.err);
    assert_eq!(output.err.lines().count(), 1, "more than one line: {}", output.err);
    assert!(output.err.starts_with("error: "), "{}", output.err);
    assert!(output.err.contains(expected), "'{expected}' is not in: {}", output.err);
    assert_eq!(output.out, "");
    assert_nothing_left(output.pid);
}

#[test]
fn the_version_names_the_commit() {
    let output = run(&["--version"]);
    assert_eq!((output.code, output.err.as_str()), (0, ""));
    let commit = build_script::find(Path::new(env!("CARGO_MANIFEST_DIR"))).commit;
    assert_eq!(output.out, format!("surefoot {} ({commit})\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn usage_errors_end_with_2_and_help_with_0() {
    for wrong in [
        &[][..],
        &["fly"],
        &["walk"],
        &["walk", "x.toml", "--sed", "1"],
        &["walk", "x.toml", "--seed", "banana"],
        &["walk", "x.toml", "--seed=-1"],
        &["plan", "x.toml", "--threads", "0"],
        &["control", "x.toml"],
        &["check"],
    ] {
        let output = run(wrong);
        assert_eq!(output.code, 2, "{wrong:?}: {}", output.err);
        assert!(output.err.contains("--help"), "{wrong:?}: {}", output.err);
    }
    let output = run(&["--help"]);
    assert_eq!(output.code, 0);
    for word in ["walk", "plan", "control", "check", "doctor", "Exit codes"] {
        assert!(output.out.contains(word), "{word}");
    }
    assert!(
        !run(&["plan", "--help"]).out.contains("report-lines"),
        "how a supervisor runs a role is nobody's business"
    );
}

#[test]
fn a_missing_scenario_is_named() {
    for word in ["walk", "plan"] {
        assert_bad_input(&run(&[word, "no/such.toml"]), "no/such.toml");
    }
    assert_bad_input(&run(&["control", "no/such.toml", "--instance", "x"]), "no/such.toml");
}

#[test]
fn broken_scenarios_are_named_with_their_line() {
    for (from, to, expected) in [
        ("seed = 1", "seed = = 1", "scenario.toml:4:"),
        ("seed = 1", "sead = 1", "scenario.toml:4:"),
        ("yaw = 0.0", "yaw = nan", "scenario.toml:"),
        ("worlds/flat_walk", "worlds/nowhere", "nowhere.toml"),
        ("hubo/robot.toml", "hubo/robo.toml", "robo.toml"),
        ("seed = 1", "seed = 1\n[planner]\nwork_max = 0\n[x]", "scenario.toml:"),
    ] {
        let test_folder = TestFolder::new(from, to);
        assert_bad_input(&run(&["walk", &test_folder.path("scenario.toml"), "--quiet"]), expected);
    }
}

#[test]
fn two_outputs_of_one_name_are_refused() {
    let test_folder = TestFolder::new("seed = 1", "seed = 1");
    let (scenario, file, same) =
        (test_folder.path("scenario.toml"), test_folder.path("out"), test_folder.path("./out"));
    assert_bad_input(
        &run(&["plan", &scenario, "--export", &file, "--json", &same, "--quiet"]),
        "two outputs",
    );
}

#[test]
fn a_result_that_cannot_be_printed_is_no_success() {
    for argument in ["doctor", "--help", "--version", "help"] {
        let full = fs::File::create("/dev/full").unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_surefoot"));
        let output = command.arg(argument).stdout(full).output().unwrap();
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{argument}: {errors}");
        assert!(errors.contains("standard output"), "{argument}: {errors}");
    }
}

#[test]
fn outputs_that_cannot_be_written_are_refused_before_anything_is_planned() {
    let test_folder = TestFolder::new("seed = 1", "seed = 1");
    let before = test_folder.files();
    let file = test_folder.path("scenario.toml");
    for (option, path, expected) in [
        ("--export", test_folder.path("missing/plan.json"), "missing"),
        ("--json", test_folder.path("missing/report.json"), "missing"),
        ("--json", test_folder.path("."), "folder"),
        ("--json", test_folder.path("scenario.toml"), "this run reads"),
        ("--json", test_folder.path("report.json/"), "folder"),
        ("--picture", test_folder.path("missing/walk.png"), "missing"),
        ("--picture", test_folder.path("walk.gif"), ".apng"),
        ("--picture", test_folder.path("walk"), ".png"),
    ] {
        for word in ["walk", "plan"] {
            assert_bad_input(&run(&[word, &file, option, &path]), expected);
        }
    }
    assert_eq!(test_folder.files(), before, "something half-written");
}

#[test]
fn a_start_in_the_air_is_bad_input_and_still_reported() {
    let test_folder = TestFolder::new("xyz = [0.5, 0.0, 0.0]", "xyz = [0.5, 0.0, 3.0]");
    for word in ["walk", "plan"] {
        let output = run(&[
            word,
            &test_folder.path("scenario.toml"),
            "--quiet",
            "--json",
            &test_folder.path("report.json"),
        ]);
        assert_bad_input(&output, "the start is invalid");
        let report: serde_json::Value =
            serde_json::from_slice(&fs::read(test_folder.path("report.json")).unwrap()).unwrap();
        assert_eq!(report["outcome"], "start_invalid");
        assert!(report["digest"].is_null());
    }
}

#[test]
fn plans_that_are_none_are_named() {
    let test_folder = TestFolder::new("seed = 1", "seed = 1");
    fs::write(test_folder.path("text.json"), "hello").unwrap();
    fs::write(test_folder.path("other.json"), "{\"schema\": \"other/1\"}").unwrap();
    for name in ["missing.json", "text.json", "other.json"] {
        assert_bad_input(&run(&["check", &test_folder.path(name)]), name);
    }
}

#[test]
fn instance_names_are_checked() {
    assert_bad_input(
        &run(&["control", &scenario("flat_walk"), "--instance", "../../etc"]),
        "instance name",
    );
    assert_bad_input(
        &run(&["plan", &scenario("flat_walk"), "--quiet", "--instance", ""]),
        "instance name",
    );
}

#[test]
fn the_doctor_finds_this_machine_fit() {
    let output = run(&["doctor", &scenario("ibeam_hallway")]);
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    for expected in [
        "shared memory",
        "cores",
        "open files",
        "locked memory",
        "64 chunks delivered",
        "MiB of arenas",
        "good     robot: 'hubo' on ",
    ] {
        assert!(output.out.contains(expected), "'{expected}' is not in: {}", output.out);
    }
}

#[test]
fn the_doctor_reports_a_joint_too_weak_for_one_foot() {
    let test_folder = TestFolder::new("seed = 1", "seed = 1\n[planner]\neffort_share = 0.1\n");
    let output = run(&["doctor", &test_folder.path("scenario.toml")]);
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    let advice =
        output.out.lines().find(|line| line.starts_with("advice   robot: 'hubo'")).unwrap();
    assert!(
        advice.contains(" alone needs ") && advice.contains("planner.effort_share allows 0.1"),
        "{advice}"
    );
}

#[test]
fn the_doctor_reports_a_broken_scenario() {
    let output = run(&["doctor", "no/such.toml"]);
    assert_eq!(output.code, 2);
    assert!(output.out.contains("MISSING  scenario: no/such.toml"), "{}", output.out);
    assert_eq!(output.err.lines().count(), 1);
}

#[test]
fn a_seed_on_the_command_line_is_the_same_as_in_the_file() {
    let (one, seven) =
        (TestFolder::new("seed = 1", "seed = 1"), TestFolder::new("seed = 1", "seed = 7"));
    let load = |test_folder: &TestFolder| {
        load_scenario(Path::new(&test_folder.path("scenario.toml"))).unwrap()
    };
    let (one, seven) = (load(&one), load(&seven));
    assert_ne!(one.digest, seven.digest);
    assert_eq!(one.clone().with_seed(7).digest, seven.digest);
    assert_eq!(one.clone().with_seed(1), one);
}
