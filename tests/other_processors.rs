//! The same plans as if on other processors: with the features hidden that the C library would use,
//! without address randomisation, and with more searches than cores. Other builds and emulated
//! processors: `tools/other_processors.sh`.

#![allow(clippy::unwrap_used, reason = "a test ends where the command does not do its part")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::Command;

use command::{finish, run, scenario, surefoot};
use serde_json::Value;

/// The processor features that glibc must not use: all that came after the first x86-64 processors.
const MASK: &str = "glibc.cpu.hwcaps=-AVX512F,-AVX512VL,-AVX2,-AVX,-FMA,-FMA4,-BMI1,-BMI2,-ERMS,-FSRM,-LZCNT,-MOVBE,-POPCNT,-SSE4_2,-SSE4_1,-SSSE3";
const TUNABLES: &str = "GLIBC_TUNABLES";
const LOADER: &str = "/lib64/ld-linux-x86-64.so.2";
const SCENARIOS: [&str; 6] =
    ["flat_walk", "ibeam_gap", "ibeam_hallway", "stairs", "stepping_stones", "cinder_blocks"];

/// The golden digest of a scenario.
fn golden(name: &str) -> String {
    let text = std::fs::read_to_string(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/golden_digests.txt"),
    )
    .unwrap();
    let line = text.lines().find(|line| line.split(' ').next() == Some(name)).unwrap();
    line.rsplit(' ').next().unwrap().to_owned()
}

/// What the C library's loader says of the processor.
fn features(mask: &str) -> Vec<String> {
    let output = Command::new(LOADER).arg("--list-diagnostics").env(TUNABLES, mask).output();
    let text = String::from_utf8_lossy(&output.map(|output| output.stdout).unwrap_or_default())
        .into_owned();
    text.lines()
        .filter(|line| line.starts_with("x86.cpu_features") || line.starts_with("dl_hwcaps"))
        .map(str::to_owned)
        .collect()
}

/// Has the system load the command's memory always at the same addresses, where it permits that.
fn at_fixed_addresses(command: &mut Command) {
    // SAFETY: the closure makes one system call and touches no memory.
    unsafe {
        command.pre_exec(|| {
            libc::personality(libc::ADDR_NO_RANDOMIZE as libc::c_ulong);
            Ok(())
        });
    }
}

#[test]
fn neither_processor_features_nor_addresses_nor_load_change_a_plan() {
    if features(MASK) == features("") {
        eprintln!(
            "this system's C library hides no processor features: the masked runs are like the others"
        );
    }
    let folder = tempfile::tempdir().unwrap();
    // The first process prepares the robot; the others find the preparation.
    assert_eq!(run(&["prepare", "configs/robots/hubo/robot.toml", "--quiet"]).code, 0);
    let mut running = vec![];
    for name in SCENARIOS {
        for (masked, fixed, threads) in
            [(false, false, "1"), (true, false, "2"), (false, true, "3"), (true, true, "4")]
        {
            let json = folder.path().join(format!("{name}-{threads}.json"));
            let mut plan = surefoot(&[
                "plan",
                &scenario(name),
                "--quiet",
                "--threads",
                threads,
                "--json",
                json.to_str().unwrap(),
            ]);
            if masked {
                plan.env(TUNABLES, MASK);
            }
            if fixed {
                at_fixed_addresses(&mut plan);
            }
            running.push((name, (masked, fixed, threads), json, plan.spawn().unwrap()));
        }
    }
    for (name, how, json, child) in running {
        let output = finish(child);
        assert_eq!(output.code, 0, "{name} {how:?}: {}", output.err);
        let report: Value = serde_json::from_slice(&std::fs::read(json).unwrap()).unwrap();
        assert_eq!(
            report["digest"],
            golden(name),
            "{name}: masked, fixed addresses, threads: {how:?}"
        );
    }
}
