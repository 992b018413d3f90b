//! Preparations of robots, read from the user's cache or built and saved there.
//!
//! A damaged file is built again. If nothing can be saved, a warning is printed.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use indicatif::{ProgressBar, ProgressStyle};
use surefoot_planner::preparation::Preparation;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::model::RobotModel;

use crate::input::cache_file;
use crate::input::cache_folder::{NO_CACHE_FOLDER, cache_folder};
use crate::report::command_error::CommandError;
use crate::system::clock::Stopwatch;
use crate::system::signals::{self, Activity};
use crate::system::terminal;

/// Steps of the progress bar.
const BAR_STEPS: f64 = 1000.0;

/// A preparation that lives as long as the program.
#[derive(Debug, Clone)]
pub struct Prepared {
    /// The preparation.
    pub preparation: Preparation,
    /// Its origin.
    pub origin: Origin,
}

/// The origin of a preparation.
#[derive(Debug, Clone, PartialEq)]
pub enum Origin {
    /// A file of the cache.
    Cached(PathBuf),
    /// Built now.
    Built {
        /// Time it took, s.
        seconds: f64,
        /// The file that holds it, if it could be saved.
        saved: Option<PathBuf>,
    },
}

/// The preparations that this process has obtained, by the digest of their inputs.
static OBTAINED: Mutex<BTreeMap<Digest, Prepared>> = Mutex::new(BTreeMap::new());

/// The preparation of a robot, from the cache or built now, once per process. `quiet` shows neither
/// progress nor warnings.
///
/// # Errors
/// The planner cannot move the robot.
pub fn obtain(
    model: &RobotModel,
    config: &PlannerConfig,
    quiet: bool,
) -> Result<Prepared, CommandError> {
    let key = surefoot_planner::preparation::key(model, config);
    let mut obtained = OBTAINED.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = obtained.get(&key) {
        return Ok(known.clone());
    }
    let prepared = find_or_make(model, config, quiet)?;
    obtained.insert(key, prepared.clone());
    Ok(prepared)
}

fn find_or_make(
    model: &RobotModel,
    config: &PlannerConfig,
    quiet: bool,
) -> Result<Prepared, CommandError> {
    let key = surefoot_planner::preparation::key(model, config);
    let path = cache_folder().map(|folder| folder.join(format!("{key}.prepared")));
    if let Some(found) = path.as_deref().and_then(|path| from_cache(path, &key)) {
        return Ok(found);
    }
    let watch = Stopwatch::start();
    let words = build(model, config, quiet)?;
    let seconds = watch.seconds();
    let preparation = Preparation::from_words(words, &key)
        .map_err(|error| CommandError::Preparation(error.to_string()))?;
    let saved = match &path {
        Some(path) => cache_file::write(path, preparation.bytes())
            .map(|()| path.clone())
            .map_err(|reason| format!("{}: {reason}", path.display())),
        None => Err(NO_CACHE_FOLDER.to_owned()),
    };
    if let (Err(reason), false) = (&saved, quiet) {
        warn(reason);
    }
    let saved = saved.ok();
    Ok(Prepared { preparation, origin: Origin::Built { seconds, saved } })
}

fn warn(reason: &str) {
    terminal::print_note(&format!(
        "warning: the robot's preparation cannot be saved; the next run builds it again: {reason}"
    ));
}

/// The preparation for `key` in the cache; `None` if it is missing, damaged or no regular file.
fn from_cache(path: &Path, key: &Digest) -> Option<Prepared> {
    let preparation = Preparation::from_bytes(&cache_file::read(path)?, key).ok()?;
    Some(Prepared { preparation, origin: Origin::Cached(path.to_owned()) })
}

fn build(
    model: &RobotModel,
    config: &PlannerConfig,
    quiet: bool,
) -> Result<Vec<u64>, CommandError> {
    signals::set_activity(Activity::Preparing);
    let bar = if quiet || !terminal::is_watched() { ProgressBar::hidden() } else { new_bar() };
    let built = surefoot_planner::preparation::build(model, config, &|share| {
        bar.set_position((BAR_STEPS * share) as u64)
    });
    bar.finish_and_clear();
    signals::set_activity(Activity::Other);
    built.map_err(|source| CommandError::Robot { urdf: model.urdf_path.clone(), source })
}

fn new_bar() -> ProgressBar {
    let style = ProgressStyle::with_template(
        "preparing the robot {bar:20} {percent:>3}%  once for all its walks",
    );
    ProgressBar::new(BAR_STEPS as u64)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
