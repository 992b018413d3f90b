//! Containers: processes with equal numbers, and shared memory that is missing or read-only. A
//! program whose file is replaced while it runs.

use std::fs;
use std::process::Command;

use surefoot_shared_types::base::user::effective_uid;

use crate::absent;
use crate::command::{finish, role};
use crate::shell::{Folder, wait_until};

/// Whether this process may enter namespaces of its own.
fn may_unshare() -> bool {
    let entered = Command::new("unshare").args(["-m", "-p", "-f", "true"]).output();
    let may = entered.is_ok_and(|output| output.status.success());
    if !may {
        absent::skip("may not unshare");
    }
    may
}

#[test]
fn two_walks_with_one_process_number_run_side_by_side() {
    if !may_unshare() {
        return;
    }
    let folder = Folder::new();
    let mut first = folder.start("exec unshare -p -f --kill-child $S walk endless.toml --quiet");
    let user = effective_uid();
    wait_until(|| fs::exists(format!("/dev/shm/surefoot-{user}/walk-1")).unwrap());
    folder.good("unshare -p -f --kill-child $S walk flat.toml --quiet");
    assert!(first.try_wait().unwrap().is_none());
    first.kill().unwrap();
    first.wait().unwrap();
}

#[test]
fn a_walk_may_have_a_name() {
    let folder = Folder::new();
    let name = format!("named-{}", std::process::id());
    folder.good(&format!("$S walk flat.toml --quiet --instance {name}"));
    let err = folder.error("$S walk flat.toml --quiet --instance NO");
    assert!(err.contains("instance name 'NO'"), "{err}");
}

#[test]
fn shared_memory_that_is_missing_or_read_only_is_named() {
    if !may_unshare() {
        return;
    }
    let folder = Folder::new();
    let missing = "mount -t tmpfs t /mnt && cp -a /dev/null /dev/zero /dev/urandom /mnt && \
                   mount --bind /mnt /dev";
    for (mount, reason) in
        [("mount -t tmpfs -o ro t /dev/shm", "Read-only"), (missing, "No such file")]
    {
        for command in ["walk flat.toml --quiet", "control flat.toml --instance x", "doctor"] {
            let line = format!("unshare -m sh -c '{mount} && {} {command} </dev/null'", "$S");
            let output = folder.run(&line);
            assert_eq!(output.code, 2, "{command}: {}", output.err);
            let text = format!("{}{}", output.out, output.err);
            assert!(text.contains("/dev/shm") && text.contains(reason), "{command}: {text}");
            assert_eq!(output.err.lines().count(), 1, "{}", output.err);
        }
        folder.good(&format!("unshare -m sh -c '{mount} && $S plan flat.toml --quiet </dev/null'"));
    }
}

#[test]
fn a_program_whose_file_is_replaced_restarts_its_processes() {
    let folder = Folder::new();
    fs::copy(env!("CARGO_BIN_EXE_surefoot"), folder.path("program")).unwrap();
    let child = folder.start("exec ./program walk flat.toml --quiet --json report.json");
    let role = |subcommand: &str| role(child.id(), subcommand);
    wait_until(|| role("plan").is_some() && role("control").is_some());
    fs::remove_file(folder.path("program")).unwrap();
    fs::write(folder.path("program"), "#!/bin/false\n").unwrap();
    let controller = role("control").unwrap();
    folder.good(&format!("kill -KILL {controller}"));
    let output = finish(child);
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    assert_eq!(folder.json("report.json")["restarts"], 1);
}
