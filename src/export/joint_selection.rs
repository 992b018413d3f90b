//! Which joints or links an export holds, and in which order.

use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::robot::urdf_order::{joints_in_urdf_order, links_in_urdf_order};

use crate::export::error::ExportError;

/// A choice of joints or links in an order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Selection {
    /// All, as the URDF file lists them.
    Urdf,
    /// All, as Surefoot's messages and plan files list them: depth first from the root.
    Surefoot,
    /// These.
    Names(Vec<String>),
}

impl Selection {
    /// The selection that a text states: `urdf`, `surefoot`, or names with commas between them.
    pub fn from_text(text: &str) -> Self {
        match text {
            "urdf" => Self::Urdf,
            "surefoot" => Self::Surefoot,
            names => Self::Names(names.split(',').map(|name| name.trim().to_owned()).collect()),
        }
    }

    /// The selected moving joints as indices into the model's.
    ///
    /// # Errors
    /// A name is unknown, is a locked joint, or stands twice; or the URDF cannot be read again.
    pub fn joints(&self, model: &RobotModel) -> Result<Vec<usize>, ExportError> {
        match self {
            Self::Urdf => Ok(joints_in_urdf_order(model)?),
            Self::Surefoot => Ok((0..model.joints.len()).collect()),
            Self::Names(names) => {
                let known = model.joints.iter().map(|joint| joint.name.as_str());
                let locked = |name: &str| {
                    let mut locked = model.locked_joints.iter();
                    let found = locked.find(|locked| locked.joint.name == name)?;
                    Some(format!(
                        "joint '{name}' is locked at {} in this plan; leave it out, and hold it \
                         there",
                        found.position
                    ))
                };
                indices(names, &known.collect::<Vec<_>>(), "moving joint", locked)
            }
        }
    }

    /// The selected links as indices into the model's.
    ///
    /// # Errors
    /// A name is unknown or stands twice, or the URDF cannot be read again.
    pub fn links(&self, model: &RobotModel) -> Result<Vec<usize>, ExportError> {
        match self {
            Self::Urdf => Ok(links_in_urdf_order(model)?),
            Self::Surefoot => Ok((0..model.links.len()).collect()),
            Self::Names(names) => {
                let known: Vec<&str> = model.links.iter().map(|link| link.name.as_str()).collect();
                indices(names, &known, "link", |_| None)
            }
        }
    }
}

/// The place of each name among the known ones. `reason` may say why a name is not there.
fn indices(
    names: &[String],
    known: &[&str],
    what: &str,
    reason: impl Fn(&str) -> Option<String>,
) -> Result<Vec<usize>, ExportError> {
    let mut found = Vec::with_capacity(names.len());
    for name in names {
        let Some(at) = known.iter().position(|known| known == name) else {
            let unknown =
                || format!("the robot has no {what} '{name}'; it has {}", known.join(", "));
            return Err(ExportError::Option(reason(name).unwrap_or_else(unknown)));
        };
        if found.contains(&at) {
            return Err(ExportError::Option(format!("{what} '{name}' is named twice")));
        }
        found.push(at);
    }
    Ok(found)
}
