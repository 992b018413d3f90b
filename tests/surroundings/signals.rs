//! Signals in every moment: ignored ones, and those that end the command.

use std::fs;
use std::process::Child;

use serde_json::Value;

use crate::command::{assert_nothing_left, finish};
use crate::shell::{Folder, wait_until};

const HUP: u32 = 1;
const INT: u32 = 2;
const TERM: u32 = 15;
const XFSZ: u32 = 25;

/// Whether a mask of a process, such as `SigCgt`, holds a signal.
fn has(pid: u32, mask: &str, signal: u32) -> bool {
    let status = fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix(mask)?.strip_prefix(':'));
    let bits = line.and_then(|text| u64::from_str_radix(text.trim(), 16).ok()).unwrap_or(0);
    bits >> (signal - 1) & 1 == 1
}

fn send(pid: u32, signal: u32) {
    // SAFETY: kill touches no memory.
    unsafe { libc::kill(pid.try_into().unwrap(), signal.try_into().unwrap()) };
}

/// Waits until the command handles signals: XFSZ is the last that it sets.
fn wait_for_handlers(child: &Child) {
    wait_until(|| has(child.id(), "SigIgn", XFSZ));
}

/// Sends a signal to a command that blocks; returns its stdout and stderr.
fn ended_by(folder: &Folder, line: &str, signal: u32) -> (String, String) {
    let child = folder.start(&format!("exec {line}"));
    wait_for_handlers(&child);
    send(child.id(), signal);
    let output = finish(child);
    assert_eq!(output.code, 128 + signal as i32, "{line}: {}{}", output.out, output.err);
    assert_nothing_left(output.pid);
    (output.out, output.err)
}

#[test]
fn a_read_of_a_pipe_without_a_writer_ends() {
    let folder = Folder::new();
    folder.good("mkfifo scenario");
    for signal in [HUP, INT, TERM] {
        for command in ["plan", "walk", "config show", "doctor", "control --instance x"] {
            let (_, err) = ended_by(&folder, &format!("$S {command} scenario"), signal);
            assert!(err.contains(&format!("error: ended by signal {signal}")), "{command}: {err}");
            assert_eq!(err.lines().count(), 1, "{command}: {err}");
        }
    }
}

#[test]
fn the_first_moments_and_the_preparation_end_without_leftovers() {
    let folder = Folder::new();
    let configs = concat!(env!("CARGO_MANIFEST_DIR"), "/configs");
    for line in ["$S walk endless.toml --quiet", "$S plan endless.toml --quiet"] {
        let (_, err) = ended_by(&folder, line, TERM);
        assert!(err.contains("ended by signal 15"), "{err}");
    }
    for signal in [HUP, INT, TERM] {
        let line =
            format!("env XDG_CACHE_HOME=$PWD/cold $S prepare {configs}/robots/hubo/robot.toml");
        let (out, _) = ended_by(&folder, &line, signal);
        assert_eq!(out, "");
        assert!(!folder.path("cold").exists(), "something is left in the cache");
    }
}

#[test]
fn a_signal_while_a_picture_is_drawn_or_written_ends() {
    let folder = Folder::new();
    folder.good("mkfifo walk.png");
    for command in ["plan", "walk"] {
        let mut child =
            folder.start(&format!("exec $S {command} flat.toml --quiet --picture walk.png"));
        let mut out = std::io::BufReader::new(child.stdout.take().unwrap());
        let mut text = String::new();
        while !text.contains("digest") {
            assert_ne!(std::io::BufRead::read_line(&mut out, &mut text).unwrap(), 0, "{text}");
        }
        // Nobody reads the pipe that the picture goes to.
        send(child.id(), TERM);
        let output = finish(child);
        assert_eq!(output.code, 143, "{}", output.err);
        assert!(output.err.contains("ended by signal 15"), "{}", output.err);
        assert_nothing_left(output.pid);
    }
    assert_eq!(folder.names(), ["walk.png"]);
}

#[test]
fn a_signal_while_a_plan_goes_to_a_pipe_ends() {
    use std::io::Read;
    use std::os::unix::fs::OpenOptionsExt;
    let folder = Folder::new();
    folder.good("mkfifo plan.json");
    for command in ["plan", "walk"] {
        let mut options = fs::OpenOptions::new();
        let pipe = options
            .read(true)
            .custom_flags(libc::O_NONBLOCK)
            .open(folder.path("plan.json"))
            .unwrap();
        let child =
            folder.start(&format!("exec $S {command} flat.toml --quiet --export plan.json"));
        // A pipe holds 64 KiB, a plan is larger: the writer blocks once it has begun.
        wait_until(|| matches!((&pipe).read(&mut [0]), Ok(1)));
        send(child.id(), TERM);
        let output = finish(child);
        assert_eq!(output.code, 143, "{command}: {}", output.err);
        assert!(output.err.contains("ended by signal 15"), "{command}: {}", output.err);
        assert_nothing_left(output.pid);
    }
}

#[test]
fn what_a_search_knows_is_reported_when_it_is_ended() {
    let folder = Folder::new();
    for command in ["plan", "walk"] {
        let mut child = folder.start(&format!("exec $S {command} endless.toml --json report.json"));
        let mut err = std::io::BufReader::new(child.stderr.take().unwrap());
        let mut text = String::new();
        while !text.contains("planner ready") {
            assert_ne!(std::io::BufRead::read_line(&mut err, &mut text).unwrap(), 0, "{text}");
        }
        send(child.id(), TERM);
        std::io::Read::read_to_string(&mut err, &mut text).unwrap();
        let output = finish(child);
        assert_eq!(output.code, 143, "{text}");
        assert!(output.out.contains("stopped before a plan was found"), "{}", output.out);
        assert!(text.contains("error: ended by signal 15"), "{text}");
        let report: Value = folder.json("report.json");
        assert_eq!(report["outcome"], "interrupted", "{command}");
        assert!(report["diagnosis"].is_object(), "{report}");
        assert_nothing_left(output.pid);
    }
}

/// Reads the lines of a command until one contains a text; returns them.
fn read_until(lines: &mut impl std::io::BufRead, end: &str) -> String {
    let mut text = String::new();
    while !text.contains(end) {
        assert_ne!(lines.read_line(&mut text).unwrap(), 0, "{text}");
    }
    text
}

/// Runs a walk, whose events go to the standard error, until these say `milestone`; ends it.
/// Returns its process and its report.
fn ended_walk(folder: &Folder, options: &str, milestone: &str) -> (u32, Value) {
    let command = format!("exec $S walk flat.toml {options} --json report.json 2>&1 >out.txt");
    let mut child = folder.start(&command);
    let mut lines = std::io::BufReader::new(child.stdout.take().unwrap());
    let mut text = read_until(&mut lines, milestone);
    send(child.id(), TERM);
    std::io::Read::read_to_string(&mut lines, &mut text).unwrap();
    let output = finish(child);
    assert_eq!(output.code, 143, "{text}");
    let report: Value = folder.json("report.json");
    assert_eq!(report["outcome"], "interrupted");
    (output.pid, report)
}

#[test]
fn an_improvement_that_is_ended_leaves_the_best_plan() {
    let folder = Folder::new();
    for signal in [INT, TERM] {
        let mut child = folder.start(
            "exec $S plan flat.toml --improve 1000000000000 --json report.json --export plan.json",
        );
        let mut err = std::io::BufReader::new(child.stderr.take().unwrap());
        let mut text = read_until(&mut err, "improving a plan");
        send(child.id(), signal);
        std::io::Read::read_to_string(&mut err, &mut text).unwrap();
        let output = finish(child);
        assert_eq!(output.code, 0, "{text}");
        assert!(output.out.contains("plan found") && output.out.contains("then stopped"));
        let report: Value = folder.json("report.json");
        assert_eq!(
            (&report["outcome"], &report["improved"]["stopped"]),
            (&"found".into(), &true.into())
        );
        let seconds = |key: &str| report["improved"][key].as_f64().unwrap();
        assert!(seconds("seconds") <= seconds("first_seconds"), "{report}");
        folder.good("$S check plan.json");
        assert_nothing_left(output.pid);
    }
}

#[test]
fn a_walk_that_is_ended_while_its_plan_improves_reports_the_plan() {
    let folder = Folder::new();
    let (process, report) = ended_walk(&folder, "--improve 1000000000000", "improving a plan");
    assert!(report["digest"].is_string() && report["improved"]["stopped"] == true, "{report}");
    assert_nothing_left(process);
}

#[test]
fn what_was_walked_is_reported_when_a_walk_is_ended() {
    let folder = Folder::new();
    let (_, report) = ended_walk(&folder, "--rate 0.05", "plan found");
    assert_eq!(report["chunks"]["lost"], 0, "{report}");
    assert!(report["digest"].is_string(), "{report}");
    let out = String::from_utf8(folder.read("out.txt")).unwrap();
    assert!(out.contains("plan found") && out.contains(" sent, "), "{out}");
}

#[test]
fn ignored_signals_stay_ignored() {
    let folder = Folder::new();
    for command in ["plan", "walk"] {
        let line = format!("trap '' HUP INT TERM; exec $S {command} flat.toml --quiet");
        let child = folder.start(&line);
        wait_for_handlers(&child);
        for signal in [HUP, INT, TERM] {
            assert!(has(child.id(), "SigIgn", signal), "{signal}");
            send(child.id(), signal);
        }
        let output = finish(child);
        assert_eq!(output.code, 0, "{}{}", output.out, output.err);
        assert_nothing_left(output.pid);
    }
}

#[test]
fn a_supervisor_that_ignores_signals_still_ends_its_processes() {
    let folder = Folder::new();
    let line = "trap '' TERM; exec $S walk endless.toml --quiet";
    let child = folder.start(line);
    let children = format!("/proc/{0}/task/{0}/children", child.id());
    let roles = || fs::read_to_string(&children).unwrap_or_default();
    wait_until(|| roles().split_whitespace().count() == 2);
    for role in roles().split_whitespace() {
        let role: u32 = role.parse().unwrap();
        wait_until(|| has(role, "SigCgt", TERM));
        assert!(!has(role, "SigIgn", TERM));
    }
    send(child.id(), INT);
    assert_eq!(finish(child).code, 130);
}
