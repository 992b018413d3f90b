//! Fuzz targets. `tests/fuzz_files.rs` of the main workspace runs the same targets on seeded inputs.

pub mod targets;

/// Runs the target of a name, with a folder of this process for its files.
///
/// # Panics
/// The reader panics, or there is no such target.
pub fn run(name: &str, bytes: &[u8]) {
    thread_local!(static FOLDER: tempfile::TempDir =
        tempfile::tempdir_in("/dev/shm").expect("a folder in memory"));
    let target = targets::named(name).expect("the name of a target");
    FOLDER.with(|folder| (target.run)(bytes, folder.path()));
}
