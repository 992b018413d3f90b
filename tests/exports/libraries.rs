//! Exports read back with the formats' own libraries, where Python has them.

use std::path::Path;
use std::process::{Command, Stdio};

use surefoot::export::joint_selection::Selection;
use surefoot::export::quaternion::QuaternionOrder;
use surefoot::export::{ExportFormat, ExportOptions};

use crate::absent;
use crate::plan::{PLAN, exported, options};
use crate::schemas::schema_file;

/// The Python interpreter, if it has these modules; else the test is skipped.
pub fn python_with(modules: &[&str]) -> Option<String> {
    let python = std::env::var("SUREFOOT_PYTHON").unwrap_or_else(|_| "python3".into());
    let imports = format!("import {}", modules.join(", "));
    let found = Command::new(&python).args(["-c", &imports]).stderr(Stdio::null()).status();
    if found.is_ok_and(|status| status.success()) {
        return Some(python);
    }
    absent::skip(&format!("{python} lacks one of {}; set SUREFOOT_PYTHON", modules.join(", ")));
    None
}

/// Runs a script of the repository, which fails where an export is not what it ought to be.
pub fn run_script(python: &str, script: &str, arguments: &[&Path]) -> String {
    let mut command = Command::new(python);
    command.arg("-B").arg(Path::new(env!("CARGO_MANIFEST_DIR")).join(script)).args(arguments);
    let output = command.output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    text
}

#[test]
fn numpy_reads_the_arrays() {
    let Some(python) = python_with(&["numpy"]) else { return };
    let folder = tempfile::tempdir().unwrap();
    let [npz, csv] = ["walk.npz", "walk.csv"].map(|name| folder.path().join(name));
    let sampled = |format, bodies| ExportOptions {
        hz: Some(25.0),
        joints: Some(Selection::Urdf),
        quaternion: Some(QuaternionOrder::Wxyz),
        bodies,
        ..options(format)
    };
    let arrays = sampled(ExportFormat::Npz, Some(Selection::Urdf));
    std::fs::write(&npz, exported(&arrays)).unwrap();
    std::fs::write(&csv, exported(&sampled(ExportFormat::Csv, None))).unwrap();
    run_script(&python, "tests/exports/check_npz.py", &[&npz, &csv]);
}

#[test]
fn mujoco_reads_the_keyframes() {
    let Some(python) = python_with(&["mujoco", "numpy"]) else { return };
    let folder = tempfile::tempdir().unwrap();
    let [keyframes, contacts] = ["keys.xml", "contacts.json"].map(|name| folder.path().join(name));
    let hz = Some(2.0);
    let joints = Some(Selection::Surefoot);
    let options_of = |format| ExportOptions { hz, ..options(format) };
    let keys = ExportOptions { joints, ..options_of(ExportFormat::Keyframes) };
    std::fs::write(&keyframes, exported(&keys)).unwrap();
    std::fs::write(&contacts, exported(&options_of(ExportFormat::Contacts))).unwrap();
    run_script(&python, "tests/exports/check_mujoco.py", &[&keyframes, &contacts]);
}

#[test]
fn pinocchio_reads_the_contact_sequence() {
    let Some(python) = python_with(&["pinocchio", "numpy"]) else { return };
    let folder = tempfile::tempdir().unwrap();
    let contacts = folder.path().join("contacts.json");
    let hz = Some(2.0);
    let bytes = exported(&ExportOptions { hz, ..options(ExportFormat::Contacts) });
    std::fs::write(&contacts, bytes).unwrap();
    let text = run_script(&python, "tools/read_contact_sequence.py", &[&contacts]);
    assert!(text.contains("knots") && text.contains("largest residual"), "{text}");
}

#[test]
fn the_files_fit_their_schemas() {
    let Some(python) = python_with(&["jsonschema"]) else { return };
    let folder = tempfile::tempdir().unwrap();
    let [steps, contacts] = ["steps.json", "contacts.json"].map(|name| folder.path().join(name));
    std::fs::write(&steps, exported(&options(ExportFormat::Footsteps))).unwrap();
    let hz = Some(2.0);
    let sequence = ExportOptions { hz, ..options(ExportFormat::Contacts) };
    std::fs::write(&contacts, exported(&sequence)).unwrap();
    let files: [(&str, &Path); 3] = [
        ("biped-plan-1", &PLAN),
        ("surefoot-footsteps-1", &steps),
        ("surefoot-contact-sequence-1", &contacts),
    ];
    for (format, file) in files {
        run_script(&python, "tests/exports/check_schema.py", &[&schema_file(format), file]);
    }
}
