//! Every example runs as its head says and prints what a user expects.

#![allow(clippy::unwrap_used, reason = "a test ends where an example does not start")]

use std::path::PathBuf;
use std::process::Command;

/// The program of an example, which cargo builds with the tests.
fn example(name: &str) -> Command {
    let test = std::env::current_exe().unwrap();
    let folder: PathBuf = test.parent().unwrap().parent().unwrap().join("examples");
    let mut command = Command::new(folder.join(name));
    command.current_dir(env!("CARGO_MANIFEST_DIR"));
    command
}

/// The lines that an example prints.
fn lines(command: &mut Command) -> Vec<String> {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap().lines().map(str::to_owned).collect()
}

#[test]
fn twenty_lines_print_the_footsteps_of_a_walk() {
    let printed = lines(&mut example("twenty_lines"));
    let steps = |foot: &str| printed.iter().filter(|line| line.starts_with(foot)).count();
    assert!(steps("Left") > 3 && steps("Right") > 3, "{printed:#?}");
    assert!(printed.last().unwrap().starts_with("27 joints, digest "), "{printed:#?}");
    assert_eq!(lines(&mut example("twenty_lines")), printed, "the same plan every time");
}

#[test]
fn a_robot_of_ones_own_walks() {
    let printed = lines(&mut example("own_robot"));
    assert!(printed[0].contains("27 joints: waist_yaw"), "{printed:#?}");
    assert!(printed[1].contains("footholds in"), "{printed:#?}");
}

#[test]
fn a_world_from_memory_is_walked() {
    let printed = lines(&mut example("world_from_memory"));
    assert!(printed.len() > 10 && printed.last().unwrap().contains("work units"), "{printed:#?}");
}

#[test]
fn a_control_loop_plans_in_steps() {
    let printed = lines(&mut example("control_loop"));
    assert!(printed[0].starts_with("planned in ") && printed.len() == 2, "{printed:#?}");
}

#[test]
fn a_refused_chunk_leads_to_another_plan() {
    let printed = lines(&mut example("replan"));
    assert!(printed[0].contains("is refused: collision"), "{printed:#?}");
    assert!(printed[2].starts_with("collision margin "), "{printed:#?}");
}

#[test]
fn a_plan_of_another_program_is_checked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plan.json");
    let planned = Command::new(env!("CARGO_BIN_EXE_surefoot"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["plan", "configs/scenarios/flat_walk.toml", "--quiet", "--export"])
        .arg(&path)
        .output()
        .unwrap();
    assert!(planned.status.success(), "{}", String::from_utf8_lossy(&planned.stderr));
    let printed = lines(example("check_plan").arg(&path));
    assert!(printed.last().unwrap().ends_with("accepted"), "{printed:#?}");
}

#[test]
fn a_subscriber_receives_a_walk() {
    let mut walk = Command::new(env!("CARGO_BIN_EXE_surefoot"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["walk", "configs/scenarios/stepping_stones.toml", "--quiet", "--rate", "40"])
        .spawn()
        .unwrap();
    let printed = lines(example("subscribe").arg(format!("walk-{}", walk.id())));
    assert!(walk.wait().unwrap().success());
    assert!(printed.iter().any(|line| line.starts_with("chunk ")), "{printed:#?}");
    assert!(printed.last().unwrap().contains("chunks were missed"), "{printed:#?}");
}

#[test]
fn the_readme_shows_the_twenty_lines() {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let readme = std::fs::read_to_string(root.join("README.md")).unwrap();
    let program = std::fs::read_to_string(root.join("examples/twenty_lines.rs")).unwrap();
    let main = &program[program.find("use surefoot").unwrap()..];
    assert!(readme.contains(main.trim_end()), "README.md shows another program");
}
