//! The plan that the tests export.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use surefoot::export::{ExportFormat, ExportMotion, ExportOptions, export};

use crate::command::run;

/// A short walk of Hubo.
pub static PLAN: LazyLock<PathBuf> = LazyLock::new(|| {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("exports");
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(format!("plan-{}.json", std::process::id()));
    let text = path.to_str().unwrap();
    let scenario = "configs/scenarios/ibeam_gap.toml";
    let arguments = ["plan", scenario, "--motion", "quasi_static", "--quiet", "--export", text];
    let output = run(&arguments);
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    path
});

/// The plan as it is exported.
pub static MOTION: LazyLock<ExportMotion> = LazyLock::new(|| ExportMotion::load(&PLAN).unwrap());

/// The bytes of an export of the plan.
pub fn exported(options: &ExportOptions) -> Vec<u8> {
    export(&MOTION, options).unwrap_or_else(|error| panic!("{error}"))
}

/// Options with a format alone.
pub fn options(format: ExportFormat) -> ExportOptions {
    ExportOptions { format, hz: None, joints: None, quaternion: None, bodies: None }
}
