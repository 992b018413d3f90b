//! The options of the simulated robot, which `surefoot walk` and `surefoot control` share.

use std::path::PathBuf;

use clap::Args;
use surefoot_controller_sim::{LATE_SHARE, LateChunks};
use surefoot_shared_types::config::MotionKind;

use crate::cli::values::whole_number;

/// Largest rate of simulated time, in multiples of real time.
const RATE_MAX: f64 = 1e6;

/// How the simulated robot walks.
#[derive(Debug, Clone, Args)]
pub struct SimulationArguments {
    /// The actual world in which the robot walks, if it is not the scenario's: a file, or the name
    /// of a world that the program carries; shapes are matched by name
    #[arg(long, alias = "truth", value_name = "WORLD")]
    pub ground_truth: Option<PathBuf>,
    /// Walk in simulated time, this many times as fast as real time (0: as fast as possible), and
    /// publish the state of the robot
    #[arg(long, value_name = "RATE", value_parser = rate)]
    pub rate: Option<f64>,
    /// Set feet down up to 5 mm and 1 degree off, and lose and delay the controller's feedback, as
    /// this seed determines
    #[arg(long, value_name = "SEED", value_parser = whole_number::<u64>)]
    pub disturb: Option<u64>,
    /// Hold chunks back by up to 3 s of the robot's time, as this seed determines: a share of 0.2
    /// of them, or the stated one. The robot brakes, stands and goes on
    #[arg(long, value_name = "SEED[:SHARE]", value_parser = late_chunks)]
    pub late: Option<LateChunks>,
    /// Write the motion as the robot walked it, its stops included, as a plan
    #[arg(long, value_name = "WALKED.json")]
    pub executed: Option<PathBuf>,
}

/// A kind of motion.
pub(crate) fn motion(name: &str) -> Result<MotionKind, String> {
    MotionKind::from_name(name)
        .ok_or_else(|| format!("one of {} is needed", MotionKind::NAMES.join(", ")))
}

/// The rate of simulated time.
pub(crate) fn rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(rate) if (0.0..=RATE_MAX).contains(&rate) => Ok(rate),
        _ => Err(format!("a rate lies between 0 and {RATE_MAX}")),
    }
}

fn late_chunks(text: &str) -> Result<LateChunks, String> {
    let (seed, share) =
        text.split_once(':').map_or((text, None), |(seed, share)| (seed, Some(share)));
    let seed = seed.parse().map_err(|_| "the seed is a whole number, 0 or more".to_owned())?;
    let share = share.map_or(Ok(LATE_SHARE), late_share)?;
    Ok(LateChunks { seed, share })
}

/// The share of chunks that come late.
pub(crate) fn late_share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(share) if (0.0..=1.0).contains(&share) => Ok(share),
        _ => Err("the share of late chunks lies between 0 and 1".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn late_chunks_are_a_seed_and_a_share() {
        assert_eq!(late_chunks("7"), Ok(LateChunks { seed: 7, share: LATE_SHARE }));
        assert_eq!(late_chunks("7:0.5"), Ok(LateChunks { seed: 7, share: 0.5 }));
        assert!(
            ["", "x", "1:2", "1:-0.1", "1:nan", "1:"].iter().all(|text| late_chunks(text).is_err())
        );
    }
}
