//! The preparations of the tests' robots: built once and stored beside the build for all test
//! binaries.
#![allow(
    dead_code,
    missing_docs,
    clippy::unwrap_used,
    reason = "each test binary uses its own part"
)]

use std::path::Path;
use std::sync::{Mutex, PoisonError};

use surefoot_planner::preparation::{BuildError, Preparation, build};
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::model::RobotModel;

static KNOWN: Mutex<Vec<(Digest, Preparation)>> = Mutex::new(vec![]);

/// The preparation of a robot.
pub fn preparation_for(model: &RobotModel, config: &PlannerConfig) -> Preparation {
    try_preparation_for(model, config).unwrap()
}

/// The preparation of a robot that may be impossible to prepare.
pub fn try_preparation_for(
    model: &RobotModel,
    config: &PlannerConfig,
) -> Result<Preparation, BuildError> {
    let key = surefoot_planner::preparation::key(model, config);
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, preparation)) = known.iter().find(|(known, _)| *known == key) {
        return Ok(preparation.clone());
    }
    let preparation = obtain(model, config, &key)?;
    known.push((key, preparation.clone()));
    Ok(preparation)
}

fn obtain(
    model: &RobotModel,
    config: &PlannerConfig,
    key: &Digest,
) -> Result<Preparation, BuildError> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("surefoot");
    let path = folder.join(format!("{key}.prepared"));
    if let Some(Ok(kept)) =
        std::fs::read(&path).ok().map(|bytes| Preparation::from_bytes(&bytes, key))
    {
        return Ok(kept);
    }
    let words = build(model, config, &|_| ())?;
    let bytes: &[u8] = bytemuck::cast_slice(&words);
    std::fs::create_dir_all(&folder).unwrap();
    let mut file = tempfile::NamedTempFile::new_in(folder).unwrap();
    std::io::Write::write_all(&mut file, bytes).unwrap();
    file.persist(path).unwrap();
    Ok(Preparation::from_words(words, key)?)
}
