//! What is prepared for the robots of the tests: made once, kept beside the build for all test
//! binaries.
#![allow(
    dead_code,
    missing_docs,
    clippy::unwrap_used,
    reason = "each test binary uses its own part"
)]

use std::path::Path;
use std::sync::{Mutex, PoisonError};

use surefoot_planner::preparation::build::{BuildError, Preparation};
use surefoot_planner::preparation::{PreparationError, build};
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::model::RobotModel;

static KNOWN: Mutex<Vec<(Digest, Preparation<'static>)>> = Mutex::new(vec![]);

/// The preparation of a robot.
pub fn preparation_for(model: &RobotModel, config: &PlannerConfig) -> Preparation<'static> {
    try_preparation_for(model, config).unwrap()
}

/// The same for a robot that it may be impossible to prepare.
pub fn try_preparation_for(
    model: &RobotModel,
    config: &PlannerConfig,
) -> Result<Preparation<'static>, BuildError> {
    let key = surefoot_planner::preparation::key(model, config);
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, preparation)) = known.iter().find(|(known, _)| *known == key) {
        return Ok(*preparation);
    }
    let preparation = obtain(model, config, &key)?;
    known.push((key, preparation));
    Ok(preparation)
}

fn obtain(
    model: &RobotModel,
    config: &PlannerConfig,
    key: &Digest,
) -> Result<Preparation<'static>, BuildError> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("surefoot");
    let path = folder.join(format!("{key}.prepared"));
    if let Some(Ok(kept)) = std::fs::read(&path).ok().map(|bytes| read(&bytes, key)) {
        return Ok(kept);
    }
    let words = build::build(model, config, &|_| ())?;
    let bytes: &[u8] = bytemuck::cast_slice(&words);
    std::fs::create_dir_all(&folder).unwrap();
    let mut file = tempfile::NamedTempFile::new_in(folder).unwrap();
    std::io::Write::write_all(&mut file, bytes).unwrap();
    file.persist(path).unwrap();
    Ok(read(bytes, key)?)
}

fn read(bytes: &[u8], key: &Digest) -> Result<Preparation<'static>, PreparationError> {
    let words: Vec<u64> =
        bytes.chunks_exact(8).map(|word| u64::from_ne_bytes(word.try_into().unwrap())).collect();
    Preparation::from_bytes(bytemuck::cast_slice(Vec::leak(words)), key)
}
