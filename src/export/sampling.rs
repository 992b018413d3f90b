//! A plan at equal intervals of time.

use surefoot_controller_sim::statics::ContactLoad;
use surefoot_shared_types::message::Waypoint;

use crate::export::error::ExportError;
use crate::export::loads::StaticLoads;
use crate::export::motion::ExportMotion;

/// Most samples of an export.
const SAMPLES_MAX: f64 = 1e7;

/// The robot at an instant.
#[derive(Debug, Clone)]
pub struct Sample {
    /// Time since the first waypoint, s: a multiple of the interval.
    pub time: f64,
    /// The robot, with the plan's own time.
    pub waypoint: Waypoint,
    /// Index of the support phase.
    pub phase: usize,
}

impl Sample {
    /// Whether a foot carries the robot.
    pub fn is_stance(&self, motion: &ExportMotion, limb: usize) -> bool {
        motion.phases[self.phase].mode.carries(limb)
    }
}

/// Where efforts come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EffortSource {
    /// The plan states them.
    Plan,
    /// They hold the robot still: see [`StaticLoads`].
    Static,
}

impl EffortSource {
    /// The source of a plan's efforts: its own where it states them.
    pub fn of(motion: &ExportMotion) -> Self {
        if motion.has_torque { Self::Plan } else { Self::Static }
    }

    /// Its name in exports.
    pub fn name(self) -> &'static str {
        ["plan", "static"][self as usize]
    }
}

/// The instants of a plan, `1 / hz` apart, beginning with its first waypoint. The last one is at
/// the plan's end or up to one interval later, where the robot rests.
///
/// # Errors
/// There are too many.
pub fn samples(
    motion: &ExportMotion,
    hz: f64,
) -> Result<impl ExactSizeIterator<Item = Sample> + '_, ExportError> {
    let (begin, end) = motion.span();
    let count = libm::ceil((end - begin) * hz - 1e-9).max(0.0) + 1.0;
    if count > SAMPLES_MAX {
        return Err(ExportError::Option(format!(
            "{hz} Hz give {count:.0} samples; at most {SAMPLES_MAX:e} are written: lower --hz"
        )));
    }
    Ok((0..count as u32).map(move |index| {
        let time = f64::from(index) / hz;
        let waypoint = motion.sample(begin + time);
        Sample { time, phase: motion.phase_at(waypoint.time), waypoint }
    }))
}

/// The joint efforts of samples, in the model's order.
pub struct Efforts {
    /// The loads; none where the plan states efforts.
    loads: Option<StaticLoads>,
}

impl Efforts {
    /// The plan's own efforts, or static ones where it states none.
    ///
    /// # Errors
    /// Contact forces cannot be computed for the robot or the world.
    pub fn new(motion: &ExportMotion) -> Result<Self, ExportError> {
        let loads = match EffortSource::of(motion) {
            EffortSource::Plan => None,
            EffortSource::Static => Some(StaticLoads::new(motion)?),
        };
        Ok(Self { loads })
    }

    /// The efforts of a sample, N m or N; locked joints may follow the moving ones.
    ///
    /// # Errors
    /// No contact forces hold the robot.
    pub fn of(&mut self, sample: &Sample) -> Result<Vec<f64>, ExportError> {
        match &mut self.loads {
            None => Ok(sample.waypoint.torque.to_vec()),
            Some(loads) => {
                let ContactLoad { torques, .. } = loads.at(&sample.waypoint, sample.phase)?;
                Ok(torques)
            }
        }
    }
}
