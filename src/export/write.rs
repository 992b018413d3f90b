//! The export of a plan in a format.

use crate::export::error::ExportError;
use crate::export::format::ExportFormat;
use crate::export::joint_selection::Selection;
use crate::export::motion::ExportMotion;
use crate::export::options::ExportOptions;
use crate::export::quaternion::QuaternionOrder;
use crate::export::{contact_sequence, csv, footsteps, keyframes, npz, recording};

/// The bytes of an export. Equal plans and options give equal bytes.
///
/// # Errors
/// An option is missing or not the format's, names something unknown, or no contact forces hold
/// the robot at some instant.
pub fn export(motion: &ExportMotion, options: &ExportOptions) -> Result<Vec<u8>, ExportError> {
    options.check()?;
    let selection = options.joints.clone().unwrap_or(Selection::Surefoot);
    let joints = selection.joints(&motion.model)?;
    let quaternion = options.quaternion.unwrap_or(QuaternionOrder::Xyzw);
    let hz = options.hz.unwrap_or(1.0);
    match options.format {
        ExportFormat::Csv => csv::write(motion, hz, &joints, quaternion),
        ExportFormat::Npz => {
            let links = options.bodies.as_ref().map(|bodies| bodies.links(&motion.model));
            npz::write(motion, hz, &joints, quaternion, &links.transpose()?.unwrap_or_default())
        }
        ExportFormat::Footsteps => footsteps::write(motion),
        ExportFormat::Contacts => contact_sequence::write(motion, hz),
        ExportFormat::Keyframes => keyframes::write(motion, hz, &joints),
        ExportFormat::Mcap => recording::write(motion, hz),
    }
}
