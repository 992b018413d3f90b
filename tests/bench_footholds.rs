//! `surefoot bench footholds`, with few queries.

#![allow(clippy::unwrap_used, reason = "a test ends where a file cannot be read")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

use command::run;
use serde_json::Value;

/// The share of queries that a sampler answered in a world.
fn share(report: &Value, world: &str, sampler: &str) -> f64 {
    let row = report["rows"].as_array().unwrap().iter().find(|row| row["world"] == world).unwrap();
    let answers = row["samplers"]
        .as_array()
        .unwrap()
        .iter()
        .find(|answers| answers["sampler"] == sampler)
        .unwrap();
    answers["found"].as_f64().unwrap() / row["queries"].as_f64().unwrap()
}

fn without_times(mut report: Value) -> Value {
    report["machine"] = Value::Null;
    for row in report["rows"].as_array_mut().unwrap() {
        row["samplers"]
            .as_array_mut()
            .unwrap()
            .iter_mut()
            .for_each(|answers| answers["seconds_mean"] = Value::Null);
    }
    report
}

#[test]
fn json_csv_and_plot_hold_the_same_values() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let output = run(&["bench", "footholds", "--queries", "6", "--json", "--out", out]);
    assert_eq!(output.code, 0, "{}", output.err);
    let report: Value = serde_json::from_str(&output.out).unwrap();
    assert_eq!(report["rows"].as_array().unwrap().len(), 15 + 11);
    for world in
        ["parallel_bars_60", "parallel_bars_95", "features/ibeam", "features/ramp_0_9", "m_groove"]
    {
        assert_eq!(share(&report, world, "whole"), 1.0, "{world}");
    }
    assert_eq!(share(&report, "features/ramp_1_1", "whole"), 0.0);
    assert_eq!(share(&report, "m_groove", "algorithm_1"), 0.0);
    let csv = std::fs::read_to_string(folder.path().join("footholds.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 4 * (15 + 11));
    let found = format!(
        "parallel_bars_60,60,whole,6,{},",
        6.0 * share(&report, "parallel_bars_60", "whole")
    );
    assert!(csv.contains(&found), "{csv}");
    let svg = std::fs::read_to_string(folder.path().join("footholds.svg")).unwrap();
    assert_eq!((svg.matches("<polyline").count(), svg.matches("<circle").count()), (4, 4 * 15));
}

#[test]
fn the_same_seed_gives_the_same_queries() {
    let [one, again] = [(); 2]
        .map(|()| run(&["bench", "footholds", "--queries", "2", "--seed", "7", "--json"]).out);
    let [one, again]: [Value; 2] =
        [one, again].map(|text| without_times(serde_json::from_str(&text).unwrap()));
    assert_eq!(one, again);
}

#[test]
fn a_missing_folder_or_world_is_refused_in_one_line() {
    for arguments in
        [["--out", "/nowhere/at/all"], ["--worlds", "/nowhere"], ["--robot", "/nowhere.toml"]]
    {
        let output = run(&[&["bench", "footholds", "--queries", "1"][..], &arguments].concat());
        assert_eq!(output.code, 2, "{arguments:?}");
        assert_eq!(
            output.err.lines().filter(|line| line.starts_with("error: ")).count(),
            1,
            "{}",
            output.err
        );
        assert!(output.err.contains("/nowhere") && output.out.is_empty());
    }
}
