//! `surefoot bench`: what it measures and prints, and how it ends when something is wrong. No test
//! looks at how long anything takes.

#![allow(clippy::unwrap_used, reason = "a test ends where the command does not do its part")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

use std::fs;
use std::path::Path;

use command::{CommandOutput, run};
use serde_json::Value;

/// A folder with a short walk on a flat floor.
struct TestFolder {
    folder: tempfile::TempDir,
}

impl TestFolder {
    /// `more` is added to the scenario.
    fn new(more: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let configs = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
        let text = fs::read_to_string(configs.join("scenarios/flat_walk.toml")).unwrap();
        let goal = text.find("[goal]").unwrap();
        let text = format!("{}[goal]\nxyz = [1.0, 0.0, 0.0]\n{more}", &text[..goal])
            .replace("\"../", &format!("\"{}/", configs.display()));
        fs::write(folder.path().join("short.toml"), text).unwrap();
        Self { folder }
    }

    fn path(&self, name: &str) -> String {
        self.folder.path().join(name).to_str().unwrap().to_owned()
    }

    /// `surefoot bench WHAT`, on the short walk.
    fn bench(&self, what: &str, more: &[&str]) -> CommandOutput {
        let scenario = self.path("short.toml");
        run(&[&["bench", what, "--scenario", &scenario], more].concat())
    }
}

fn json(output: &CommandOutput) -> Value {
    serde_json::from_str(&output.out)
        .unwrap_or_else(|error| panic!("{error}: {}{}", output.out, output.err))
}

fn assert_bad_input(output: &CommandOutput, expected: &str) {
    assert_eq!(output.code, 2, "{}{}", output.out, output.err);
    assert_eq!(output.err.lines().count(), 1, "more than one line: {}", output.err);
    assert!(
        output.err.starts_with("error: ") && output.err.contains(expected),
        "'{expected}' is not in: {}",
        output.err
    );
    assert_eq!(output.out, "");
}

#[test]
fn thesis_reports_all_that_its_rows_promise() {
    let output = TestFolder::new("").bench("thesis", &["--trials", "2", "--check", "--json"]);
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    let report = json(&output);
    assert_eq!(report["schema"], "surefoot-bench-thesis/1");
    assert!(report["caveat"].as_str().unwrap().contains("reconstruction"));
    assert!(report["machine"]["cores"].as_u64().unwrap() > 0);
    let row = &report["rows"][0];
    assert_eq!(
        (&row["scenario"], &row["trials"], &row["found"]),
        (&"short".into(), &2.into(), &2.into())
    );
    assert_eq!(
        (&row["checked"], &row["refused"], &row["thesis"]),
        (&2.into(), &0.into(), &Value::Null)
    );
    for name in [
        "mean_seconds",
        "std_seconds",
        "p50_seconds",
        "p95_seconds",
        "max_seconds",
        "processor_mean_seconds",
        "ready_mean_seconds",
        "mean_work",
    ] {
        assert!(row[name].as_f64().unwrap() > 0.0, "{name}: {row}");
    }
    let sum: f64 = row["mean_work_by_stage"]
        .as_object()
        .unwrap()
        .values()
        .map(|work| work.as_f64().unwrap())
        .sum();
    assert_eq!(sum, row["mean_work"].as_f64().unwrap(), "the stages' work adds up");
    assert!(row["mean_seconds_by_stage"]["motions"].as_f64().unwrap() > 0.0);
    assert_eq!(row["digest"].as_str().unwrap().len(), 64);
}

#[test]
fn thesis_prints_the_thesis_beside_our_own_figures() {
    let output =
        run(&["bench", "thesis", "--scenario", "ibeam_hallway", "--trials", "1", "--threads", "1"]);
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    for expected in [
        "machine: ",
        "reconstruction",
        "Table 4.1",
        "30.59 (64.91)",
        "100 %",
        "1/1",
        " x\n",
        "sequence",
    ] {
        assert!(output.out.contains(expected), "'{expected}' is not in:\n{}", output.out);
    }
    assert!(!output.out.contains("Table 4.2"));
}

#[test]
fn thesis_takes_up_where_it_was() {
    let test_folder = TestFolder::new("");
    let out = test_folder.path("results");
    let bench = |trials: &str, more: &[&str]| {
        let output = test_folder.bench(
            "thesis",
            &[&["--trials", trials, "--threads", "1", "--json", "--out", &out], more].concat(),
        );
        assert_eq!(output.code, 0, "{}{}", output.out, output.err);
        json(&output)["rows"][0].clone()
    };
    let lines =
        || fs::read_to_string(test_folder.path("results/thesis.jsonl")).unwrap().lines().count();
    let first = bench("1", &[]);
    assert_eq!(lines(), 1);
    assert_eq!(bench("1", &[]), first, "nothing is measured twice");
    let second = bench("2", &[]);
    assert_eq!((lines(), &second["trials"]), (2, &2.into()));
    let fresh = bench("1", &["--fresh"]);
    assert_eq!((lines(), &fresh["digest"]), (1, &first["digest"]));
    assert_ne!(fresh["mean_seconds"], first["mean_seconds"], "measured anew");
    let kept: Value =
        serde_json::from_slice(&fs::read(test_folder.path("results/thesis.json")).unwrap())
            .unwrap();
    assert_eq!(kept["rows"][0], fresh);
}

#[test]
fn thesis_measures_smooth_plans_beside_searched_ones() {
    let test_folder = TestFolder::new("");
    let out = test_folder.path("results");
    let row = |more: &[&str]| {
        let fixed = ["--trials", "1", "--threads", "1", "--json", "--out", &out];
        let output = test_folder.bench("thesis", &[&fixed, more].concat());
        assert_eq!(output.code, 0, "{}{}", output.out, output.err);
        json(&output)["rows"][0].clone()
    };
    let [searched, smooth] = [row(&[]), row(&["--motion", "smooth"])];
    assert_ne!(searched["digest"], smooth["digest"]);
    let chunk_work = |row: &Value| row["mean_work_by_stage"]["chunks"].as_f64().unwrap();
    assert!(chunk_work(&smooth) > chunk_work(&searched), "timing is work of the chunks' stage");
    let complete = ["ready_mean_seconds", "mean_seconds"].map(|of| smooth[of].as_f64().unwrap());
    assert!(smooth["first_chunk_mean_seconds"].as_f64().unwrap() < complete.iter().sum());
    assert_eq!(row(&[]), searched, "the journal keeps both");
}

#[test]
fn goals_are_planned_with_the_motion_asked_for() {
    let work = |motion: &str| {
        let arguments = ["bench", "goals", "--trials", "3", "--json", "--motion", motion];
        let output = run(&arguments);
        assert_eq!(output.code, 0, "{}{}", output.out, output.err);
        let report = json(&output);
        let [first, p99] = ["first_chunk_p99", "seconds_p99"].map(|of| report[of].as_f64());
        assert!(first <= p99, "{report}");
        report["work_p50"].as_f64().unwrap()
    };
    assert!(work("quasi_static") < work("smooth"));
}

#[test]
fn thesis_does_not_hide_that_nothing_was_found() {
    let test_folder = TestFolder::new("[planner]\nwork_max = 70\n");
    let output = test_folder.bench("thesis", &["--trials", "2", "--json"]);
    assert_eq!(output.code, 3, "{}{}", output.out, output.err);
    let row = &json(&output)["rows"][0];
    assert_eq!(
        (&row["found"], &row["outcomes"]["budget_exhausted"], &row["mean_seconds"]),
        (&0.into(), &2.into(), &Value::Null)
    );
    assert!(test_folder.bench("thesis", &["--trials", "1"]).out.contains("0/1"));
}

#[test]
fn missing_scenarios_are_named_before_anything_is_measured() {
    let test_folder = TestFolder::new("");
    let out = test_folder.path("results");
    assert_bad_input(
        &test_folder.bench("thesis", &["--scenario", "no_such", "--out", &out]),
        "configs/scenarios/no_such.toml",
    );
    assert_bad_input(
        &run(&["bench", "thesis", "--configs", "nowhere"]),
        "nowhere/ibeam_hallway.toml",
    );
    assert!(!Path::new(&out).exists(), "something half-written");
}

#[test]
fn a_broken_journal_is_named() {
    let test_folder = TestFolder::new("");
    fs::create_dir(test_folder.path("results")).unwrap();
    fs::write(test_folder.path("results/thesis.jsonl"), "{\"key\": 7}\n").unwrap();
    assert_bad_input(
        &test_folder.bench("thesis", &["--trials", "1", "--out", &test_folder.path("results")]),
        "thesis.jsonl:1: ",
    );
    assert_bad_input(
        &test_folder.bench("thesis", &["--trials", "1", "--out", &test_folder.path("short.toml")]),
        "short.toml",
    );
}

#[test]
fn usage_errors_end_with_2() {
    for wrong in [
        &["bench"][..],
        &["bench", "speed"],
        &["bench", "thesis", "--trials", "0"],
        &["bench", "thesis", "--threads", "0"],
        &["bench", "thesis", "--fresh"],
    ] {
        let output = run(wrong);
        assert_eq!((output.code, output.out.as_str()), (2, ""), "{wrong:?}: {}", output.err);
    }
}

#[test]
fn the_lower_bound_compares_planning_with_checking() {
    let output =
        TestFolder::new("").bench("lower-bound", &["--trials", "2", "--threads", "1", "--json"]);
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    let row = &json(&output)["rows"][0];
    assert_eq!((&row["found"], row["faults"].as_array().unwrap().len()), (&2.into(), 0), "{row}");
    let (plan, check) = (
        row["processor_mean_seconds"].as_f64().unwrap(),
        row["check_mean_seconds"].as_f64().unwrap(),
    );
    assert!((row["ratio"].as_f64().unwrap() - plan / check).abs() < 1e-9);
    let (checked, waypoints) = (
        row["check_mean_configurations"].as_f64().unwrap(),
        row["mean_waypoints"].as_f64().unwrap(),
    );
    assert!(
        checked >= 2.0 * waypoints - 1.0,
        "each waypoint, and one configuration between any two: {row}"
    );
    assert!(
        TestFolder::new("").bench("lower-bound", &["--trials", "1"]).out.contains("check once")
    );
}

#[test]
fn ipc_leaves_nothing_in_shared_memory() {
    let left = || {
        let names = fs::read_dir("/dev/shm")
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap());
        names.filter(|name| name.starts_with("sfbench")).collect::<std::collections::BTreeSet<_>>()
    };
    let before = left();
    let output = run(&["bench", "ipc", "--rounds", "100", "--json"]);
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    assert!(left().is_subset(&before), "{:?}", left());
}

#[test]
fn replan_goes_on_from_where_the_robot_stands() {
    let replan = |seeds: &str| {
        let counts = ["--trials", seeds, "--refusals", "2", "--threads", "1"];
        let output =
            run(&[&["bench", "replan", "--scenario", "flat_walk", "--json"][..], &counts].concat());
        assert_eq!(output.code, 0, "{}{}", output.out, output.err);
        json(&output)["rows"][0].clone()
    };
    let row = replan("2");
    assert_eq!(
        (&row["plans"], &row["trials"], &row["found"]),
        (&2.into(), &4.into(), &4.into()),
        "{row}"
    );
    let [ready, search, first] = ["ready", "", "first_chunk"]
        .map(|name| format!("{name}_mean_seconds").trim_start_matches('_').to_owned());
    let [ready, search, first] = [ready, search, first].map(|name| row[name].as_f64().unwrap());
    assert!(ready < first && first < ready + search, "the first chunk leaves early: {row}");
    assert!(row["first_chunk_p50_seconds"].as_f64() <= row["first_chunk_max_seconds"].as_f64());
    assert_eq!(replan("2")["digest"], row["digest"], "the same refusals, the same plans");
    assert_ne!(replan("1")["digest"], row["digest"]);
}

#[test]
fn steps_reports_times_and_units_of_every_stage() {
    let output = TestFolder::new("").bench("steps", &["--core", "0", "--step", "500", "--json"]);
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    let report = json(&output);
    assert_eq!((&report["core"], &report["step_seconds"]), (&0.into(), &5e-4.into()));
    let row = &report["rows"][0];
    let [p50, p95, p99, max] =
        ["p50", "p95", "p99", "max"].map(|name| row[format!("{name}_seconds")].as_f64().unwrap());
    assert!(0.0 < p50 && p50 <= p95 && p95 <= p99 && p99 <= max, "{row}");
    assert!(row["steps"].as_u64().unwrap() > 1);
    assert_eq!(
        (&row["trials"], &row["found"], row["digest"].as_str().unwrap().len()),
        (&1.into(), &1.into(), 64)
    );
    assert!(
        row["std_seconds"].as_f64().unwrap() > 0.0
            && row["mean_work"].as_f64() <= row["step_work"].as_f64(),
        "{row}"
    );
    assert!(
        row["max_work"].as_u64() <= row["step_work"].as_u64() && row["overrun_work"] == 0,
        "{row}"
    );
    let stages = row["stages"].as_array().unwrap();
    assert_eq!(stages.len(), 11);
    assert!(
        stages.iter().all(|stage| stage["longest_seconds"].as_f64() <= stage["seconds"].as_f64())
    );
    assert_bad_input(&TestFolder::new("").bench("steps", &["--core", "9999"]), "--core 9999");
}

#[test]
fn scale_walks_over_meshes_and_draws() {
    let test_folder = TestFolder::new("");
    let out = test_folder.path("results");
    let output = run(&[
        "bench",
        "scale",
        "--part",
        "terrain",
        "--triangles",
        "10000,20000",
        "--trials",
        "1",
        "--out",
        &out,
        "--json",
    ]);
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    let report = json(&output);
    let rows = report["terrain"].as_array().unwrap();
    assert_eq!((&rows[0]["size"], &rows[1]["size"]), (&10_000.into(), &20_000.into()));
    assert_eq!(rows[0]["growth"], 1.0);
    assert!(
        rows.iter().all(|row| row["resident_bytes"].as_u64().unwrap()
            > row["arena_bytes"].as_u64().unwrap() / 100)
    );
    assert_eq!(
        fs::read_to_string(test_folder.path("results/scale_terrain.svg"))
            .unwrap()
            .matches("<circle")
            .count(),
        8
    );
    assert!(!Path::new(&test_folder.path("results/scale_gauntlet.svg")).exists());
    let kept: Value =
        serde_json::from_slice(&fs::read(test_folder.path("results/scale.json")).unwrap()).unwrap();
    assert_eq!(kept, report);
}

#[test]
fn scale_names_the_missing_file() {
    let missing = run(&["bench", "scale", "--part", "gauntlet", "--configs", "nowhere"]);
    assert_bad_input(&missing, "nowhere/gauntlet_1.toml");
    assert_bad_input(
        &run(&["bench", "scale", "--part", "terrain", "--configs", "nowhere"]),
        "nowhere/flat_walk.toml",
    );
    assert_eq!(run(&["bench", "scale", "--triangles", "0"]).code, 2);
}

#[test]
fn methods_find_walks_that_the_checks_accept() {
    let report =
        json(&TestFolder::new("").bench("methods", &["--trials", "1", "--check", "--json"]));
    assert_eq!(report["schema"], "surefoot-bench-methods/1");
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), surefoot_planner::methods::method::Method::ALL.len());
    for row in rows {
        assert_eq!((&row["found"], &row["checked"]), (&1.into(), &1.into()), "{row}");
        assert_eq!(row["refused"], 0, "{row}");
        assert!(row["mean_steps"].as_f64() > Some(1.0), "{row}");
    }
}

#[test]
fn methods_go_on_where_they_were() {
    let folder = TestFolder::new("");
    let out = folder.path("results");
    let bench = |more: &[&str]| {
        let fixed = ["--method", "rpg", "--threads", "1", "--json", "--out", &out];
        folder.bench("methods", &[&fixed, more].concat())
    };
    let row = |more: &[&str]| json(&bench(more))["rows"][0].clone();
    let journal = folder.path("results/methods.jsonl");
    let lines = || fs::read_to_string(&journal).unwrap().lines().count();
    let second = row(&["--trials", "1", "--first-seed", "2"]);
    assert_eq!(lines(), 2, "the setup and a result");
    assert_eq!(row(&["--trials", "1", "--first-seed", "2"]), second, "nothing is measured twice");
    let both = row(&["--trials", "2"]);
    assert_eq!((lines(), &both["trials"]), (3, &2.into()), "the second is known");
    let broken = fs::read_to_string(&journal).unwrap();
    fs::write(&journal, &broken[..broken.len() - 9]).unwrap();
    assert_eq!(row(&["--trials", "2"])["trials"], 2);
    assert_eq!(lines(), 3, "half a line is measured anew");
    let other_work = ["--trials", "1", "--work", "5000"];
    assert_bad_input(&bench(&other_work), "methods.jsonl:1: holds results of surefoot ");
    assert_eq!(row(&[&other_work[..], &["--fresh"]].concat())["found"], 1);
    let other_program = fs::read_to_string(&journal).unwrap().replacen('(', "(other ", 1);
    fs::write(&journal, other_program).unwrap();
    assert_bad_input(&bench(&other_work), "; this is surefoot ");
}

#[test]
fn rho_measures_w_rpg_over_the_radius() {
    let folder = TestFolder::new("");
    let out = folder.path("results");
    fs::create_dir(&out).unwrap();
    let output = folder.bench("rho", &["--trials", "1", "--shares", "1,inf", "--out", &out]);
    assert_eq!(output.code, 0, "{}", output.err);
    let csv = fs::read_to_string(Path::new(&out).join("rho.csv")).unwrap();
    let rows: Vec<&str> = csv.lines().skip(1).collect();
    assert!(rows[0].contains(",w-rpg,1,1,1,") && rows[1].contains(",mmprm,,,1,"), "{csv}");
    assert!(fs::read_to_string(Path::new(&out).join("rho.svg")).unwrap().starts_with("<svg"));
    let growing =
        ["--method", "rpg-discs", "--trials", "1", "--shares", "0.5", "--rho-growth", "2"];
    let row = json(&folder.bench("rho", &[&growing[..], &["--json"]].concat()))["rows"][0].clone();
    assert_eq!((&row["method"], &row["disc_radius_growth"]), (&"rpg-discs".into(), &2.0.into()));
    assert!(row["found"] == 1 && row["disc_radius_share"] == 0.5, "{row}");
    let other = folder.bench("rho", &["--method", "astar", "--trials", "1"]);
    assert!(other.code == 2 && other.err.contains("w-rpg or rpg-discs"), "{}", other.err);
}

#[test]
fn theory_prints_the_bound_beside_the_measured_rate() {
    let report = json(&TestFolder::new("").bench("theory", &["--trials", "2", "--json"]));
    let row = &report["rows"][0];
    let (numbers, number) = (&row["numbers"], |value: &Value| value.as_f64().unwrap());
    let [length, route_length] = ["length", "route_length"].map(|name| number(&numbers[name]));
    assert!(number(&numbers["modes"]) >= 2.0 && length > route_length, "{row}");
    assert!(number(&numbers["cylinder_radius"]) > 0.0, "{row}");
    assert!(number(&numbers["clearance"]) > 0.0 && number(&numbers["volume"]) > 0.0, "{row}");
    assert_eq!(row["trials"], 2);
    assert!(number(&row["bound"]) <= 1.0 && number(&row["limits"][0]) <= number(&row["bound"]));
}
