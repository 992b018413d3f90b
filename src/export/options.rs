//! The options of an export, and which of them a format needs.

use crate::export::error::ExportError;
use crate::export::format::ExportFormat;
use crate::export::joint_selection::Selection;
use crate::export::quaternion::QuaternionOrder;

/// Largest rate, Hz.
pub const HZ_MAX: f64 = 100_000.0;

/// The options of an export.
#[derive(Debug, Clone, PartialEq)]
pub struct ExportOptions {
    /// The format.
    pub format: ExportFormat,
    /// Samples each second.
    pub hz: Option<f64>,
    /// The joints and their order.
    pub joints: Option<Selection>,
    /// The order of a quaternion's numbers.
    pub quaternion: Option<QuaternionOrder>,
    /// The links whose motion is exported too.
    pub bodies: Option<Selection>,
}

/// Whether a format takes an option.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Need {
    Required,
    Optional,
    /// The reason.
    None(&'static str),
}

impl ExportOptions {
    /// Checks that all options that the format needs are there, and no other ones.
    ///
    /// # Errors
    /// All options that are missing, or the first that does not belong to the format.
    pub fn check(&self) -> Result<(), ExportError> {
        let format = self.format.name();
        let [hz, joints, quaternion, bodies] = needs(self.format);
        let rules = [
            ("--hz N", hz, self.hz.is_some()),
            ("--joint-order urdf|surefoot|NAME,NAME,...", joints, self.joints.is_some()),
            ("--quat xyzw|wxyz", quaternion, self.quaternion.is_some()),
            ("--bodies urdf|surefoot|NAME,NAME,...", bodies, self.bodies.is_some()),
        ];
        for (option, need, is_given) in rules {
            if let (Need::None(reason), true) = (need, is_given) {
                let name = option.split(' ').next().unwrap_or(option);
                return Err(ExportError::Option(format!(
                    "{format} takes no {name}: {reason}; leave it out"
                )));
            }
        }
        let missing =
            rules.iter().filter(|(_, need, is_given)| *need == Need::Required && !is_given);
        let missing: Vec<&str> = missing.map(|(option, ..)| *option).collect();
        if !missing.is_empty() {
            return Err(ExportError::Option(format!(
                "{format} needs {}: nothing of it is chosen silently",
                missing.join(" and ")
            )));
        }
        match self.hz {
            Some(hz) if !(hz > 0.0 && hz <= HZ_MAX) => Err(ExportError::Option(format!(
                "--hz {hz}: a rate lies above 0 and is at most {HZ_MAX}"
            ))),
            _ => Ok(()),
        }
    }
}

/// What a format needs: rate, joint order, quaternion order, bodies.
fn needs(format: ExportFormat) -> [Need; 4] {
    let named_order = Need::None("the file names each joint");
    let named_quaternion = Need::None("the file names each number of a quaternion");
    let no_bodies = Need::None("only npz holds the motion of links");
    match format {
        ExportFormat::Csv => [Need::Required, Need::Required, Need::Required, no_bodies],
        ExportFormat::Npz => [Need::Required, Need::Required, Need::Required, Need::Optional],
        ExportFormat::Footsteps => {
            let no_rate = Need::None("its times are those of the plan's waypoints");
            [no_rate, Need::None("it holds no joints"), named_quaternion, no_bodies]
        }
        ExportFormat::Contacts | ExportFormat::Mcap => {
            [Need::Required, named_order, named_quaternion, no_bodies]
        }
        ExportFormat::Keyframes => {
            let mujoco = Need::None("MuJoCo's quaternions are w, x, y, z");
            [Need::Required, Need::Required, mujoco, no_bodies]
        }
    }
}
