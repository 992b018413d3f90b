//! The table of parameters names every field, holds the ranges that are enforced, and is what
//! `docs/PARAMETERS.md` and `surefoot config show` print.
//!
//! `SUREFOOT_BLESS=1 cargo test --test parameters` rewrites docs/PARAMETERS.md.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

use std::ops::Bound::{Excluded, Included};
use std::path::Path;

use command::run;
use serde_json::{Value as Json, json};
use surefoot_shared_types::config::builder::ScenarioContent;
use surefoot_shared_types::config::parameter::{Parameter, Range, Value};
use surefoot_shared_types::config::parameters::PARAMETERS;
use surefoot_shared_types::config::scenario::StancePose;
use surefoot_shared_types::config::{CheckerConfig, ExecutionConfig, PlannerConfig};

/// The defaults of all tables, as JSON.
fn defaults() -> Json {
    json!({
        "planner": PlannerConfig::default(),
        "checker": CheckerConfig::default(),
        "execution": ExecutionConfig::default(),
    })
}

/// The table of a parameter and its key within it.
fn table_and_key(name: &str) -> (&str, &str) {
    name.split_once('.').unwrap()
}

/// Sets a parameter.
fn set(tables: &mut Json, name: &str, value: Json) {
    let (table, key) = table_and_key(name);
    tables[table][key] = value;
}

/// Builds a scenario with all tables; the error names the parameter, if a range refused it.
fn build(tables: &Json) -> Result<(), String> {
    let text = |error: serde_json::Error| error.to_string();
    let stance = StancePose { position: glam::DVec3::ZERO, yaw: 0.0, stance_width: 0.2 };
    let content = ScenarioContent {
        start: stance,
        goal: stance,
        goal_position_tolerance: 0.1,
        goal_yaw_tolerance: 0.35,
        seed: 1,
        planner: serde_json::from_value(tables["planner"].clone()).map_err(text)?,
        checker: serde_json::from_value(tables["checker"].clone()).map_err(text)?,
        execution: serde_json::from_value(tables["execution"].clone()).map_err(text)?,
    };
    content.build().map(|_| ()).map_err(|error| error.parameter)
}

/// Sets the parameter that a relation couples with `name`, so that the relation holds with `value`.
fn set_related(tables: &mut Json, name: &str, value: f64) {
    let (related, other) = match name {
        "planner.clearance" => ("planner.collision_step", (1.9 * value).clamp(1e-3, 1e6)),
        "planner.collision_step" => ("planner.clearance", 0.6 * value),
        "planner.com_margin" => ("checker.com_margin", 0.5 * value),
        "checker.com_margin" => ("planner.com_margin", 1e6),
        "planner.effort_share" => ("checker.effort_share", 1.0),
        "checker.effort_share" => ("planner.effort_share", (0.5 * value).max(1e-12)),
        "planner.waypoint_joint_step" => ("checker.joint_step_max", 1e6),
        "checker.joint_step_max" => ("planner.waypoint_joint_step", 1e-3),
        "planner.support_area_min" => ("checker.support_area_min", 0.5 * value),
        "checker.support_area_min" => ("planner.support_area_min", 1e6),
        _ => return,
    };
    set(tables, related, json!(other));
}

fn accepts(parameter: &Parameter, value: f64) -> Result<(), String> {
    let mut tables = defaults();
    set_related(&mut tables, parameter.name, value);
    set(&mut tables, parameter.name, json!(value));
    build(&tables)
}

#[test]
fn the_table_names_the_fields_of_all_structs_in_their_order() {
    let planner = toml::to_string(&PlannerConfig::default()).unwrap();
    let checker = toml::to_string(&CheckerConfig::default()).unwrap();
    let execution = toml::to_string(&ExecutionConfig::default()).unwrap();
    let keys = |table: &str, text: &str| -> Vec<String> {
        text.lines().map(|line| format!("{table}.{}", line.split(' ').next().unwrap())).collect()
    };
    let fields =
        [keys("planner", &planner), keys("checker", &checker), keys("execution", &execution)];
    let fields = fields.concat();
    let names: Vec<&str> = PARAMETERS.iter().map(|parameter| parameter.name).collect();
    assert_eq!(names, fields);
}

#[test]
fn every_value_of_the_table_is_that_of_the_field_it_names() {
    let tables = defaults();
    for parameter in &PARAMETERS {
        let (table, key) = table_and_key(parameter.name);
        let value = match parameter.default_value() {
            Value::Count(count) => json!(count),
            Value::Real(number) => json!(number),
            Value::Name(name) => json!(name),
        };
        assert_eq!(value, tables[table][key], "{}", parameter.name);
    }
}

#[test]
fn the_ends_of_every_range_are_enforced() {
    for parameter in &PARAMETERS {
        let name = parameter.name;
        let (low, high) = match parameter.range {
            Range::Counts { least, most } => {
                assert_count_ends(parameter, least, most);
                continue;
            }
            Range::Reals { low, high } => (low, high),
            Range::Names(names) => {
                assert_names(parameter, names);
                continue;
            }
        };
        for (bound, outward) in [(low, -1.0), (high, 1.0)] {
            let (Included(end) | Excluded(end)) = bound else { panic!("{name} has no end") };
            let step = outward * 1e-9_f64.max(1e-9 * end.abs());
            let refused = match bound {
                Included(_) => end + step,
                _ => end,
            };
            let accepted = if matches!(bound, Included(_)) { end } else { end - step };
            assert_eq!(accepts(parameter, accepted), Ok(()), "{name} = {accepted}");
            assert_eq!(accepts(parameter, refused), Err(name.to_owned()), "{name} = {refused}");
        }
    }
}

/// Counts are checked as integers; beyond the largest `u32` or `u64` the field's type refuses.
fn assert_count_ends(parameter: &Parameter, least: u64, most: u64) {
    let with = |count: u64| {
        let mut tables = defaults();
        set(&mut tables, parameter.name, json!(count));
        build(&tables)
    };
    assert_eq!(with(least), Ok(()), "{} = {least}", parameter.name);
    assert_eq!(with(most), Ok(()), "{} = {most}", parameter.name);
    if let Some(below) = least.checked_sub(1) {
        assert_eq!(with(below), Err(parameter.name.to_owned()));
    }
    match most.checked_add(1) {
        Some(above) if most < u32::MAX.into() => {
            assert_eq!(with(above), Err(parameter.name.to_owned()));
        }
        Some(above) => assert!(with(above).unwrap_err().contains("u32"), "{}", parameter.name),
        None => {}
    }
}

/// Each name is accepted; another one is refused by the field's type, which lists them.
fn assert_names(parameter: &Parameter, names: &[&str]) {
    let with = |name: &str| {
        let mut tables = defaults();
        set(&mut tables, parameter.name, json!(name));
        build(&tables)
    };
    for name in names {
        assert_eq!(with(name), Ok(()), "{} = {name}", parameter.name);
        assert!(with("another").unwrap_err().contains(name), "{}", parameter.name);
    }
}

/// The text above the tables of the document.
const INTRODUCTION: &str = "\
# Parameters

The parameters that a scenario may set in `[planner]`, `[checker]` and `[execution]`.
`surefoot config show` prints their values; with a scenario, also where each value comes from. The
tables are those of `shared-types/src/config/parameters.rs`;
`SUREFOOT_BLESS=1 cargo test --test parameters` rewrites this file. Grey is the thesis that the
README names; decision 0003 is [0003-planner-margins.md](decisions/0003-planner-margins.md).
";

/// The document.
fn document() -> String {
    let mut text = INTRODUCTION.to_owned();
    for table in ["planner", "checker", "execution"] {
        text += &format!("\n## [{table}]\n\n");
        text += "| Parameter | Default | Unit | Range | Effect | Source |\n";
        text += "| --- | --- | --- | --- | --- | --- |\n";
        for parameter in PARAMETERS.iter().filter(|row| table_and_key(row.name).0 == table) {
            text += &row(parameter);
        }
    }
    text
}

fn row(parameter: &Parameter) -> String {
    let mut range = parameter.range.to_string();
    if !parameter.relation.is_empty() {
        range += &format!("; {}", parameter.relation);
    }
    format!(
        "| `{}` | {} | {} | {range} | {} | {} |\n",
        table_and_key(parameter.name).1,
        parameter.default_value().rounded(),
        parameter.unit,
        parameter.effect,
        parameter.source
    )
}

#[test]
fn the_document_shows_the_table() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/PARAMETERS.md");
    let expected = document();
    if std::env::var_os("SUREFOOT_BLESS").is_some() {
        std::fs::write(&path, expected).unwrap();
    } else {
        assert!(
            std::fs::read_to_string(&path).unwrap() == expected,
            "docs/PARAMETERS.md shows another table; rewrite it with \
             SUREFOOT_BLESS=1 cargo test --test parameters the_document_shows_the_table"
        );
    }
}

#[test]
fn config_show_prints_defaults_and_the_lines_of_a_scenario() {
    let defaults = run(&["config", "show"]);
    assert_eq!(defaults.code, 0, "{}", defaults.err);
    assert_eq!(defaults.out.lines().count(), PARAMETERS.len() + 1);
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/scenarios/no_way_wall.toml");
    let scenario = run(&["config", "show", path]);
    let work = scenario.out.lines().find(|line| line.starts_with("planner.work_max")).unwrap();
    assert!(work.contains("30000") && work.ends_with("no_way_wall.toml:17"), "{work}");
    let json: Json = serde_json::from_str(&run(&["config", "show", path, "--json"]).out).unwrap();
    let rows = json["parameters"].as_array().unwrap();
    assert_eq!(rows.len(), PARAMETERS.len());
    assert_eq!((&rows[0]["value"], &rows[0]["line"]), (&json!(30_000), &json!(17)));
    assert_eq!((&rows[1]["origin"], &rows[1]["line"]), (&json!("default"), &Json::Null));
}
