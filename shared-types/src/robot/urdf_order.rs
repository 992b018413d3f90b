//! The order of joints and links in a URDF file, which is not that of the model.

use crate::base::input_error::InputError;
use crate::robot::model::RobotModel;
use crate::robot::urdf::{Urdf, read_urdf};

/// The model's moving joints in the order of the URDF file: indices into
/// [`RobotModel::joints`].
///
/// # Errors
/// The URDF cannot be read again.
pub fn joints_in_urdf_order(model: &RobotModel) -> Result<Vec<usize>, InputError> {
    let urdf = read_again(model)?;
    let place = |name: &String| model.joints.iter().position(|joint| joint.name == *name);
    Ok(urdf.joints.iter().filter_map(|joint| place(&joint.name)).collect())
}

/// The model's links in the order of the URDF file: indices into [`RobotModel::links`].
///
/// # Errors
/// The URDF cannot be read again.
pub fn links_in_urdf_order(model: &RobotModel) -> Result<Vec<usize>, InputError> {
    let urdf = read_again(model)?;
    let place = |name: &String| model.links.iter().position(|link| link.name == *name);
    Ok(urdf.links.iter().filter_map(|link| place(&link.name)).collect())
}

fn read_again(model: &RobotModel) -> Result<Urdf, InputError> {
    read_urdf(&model.urdf_path, &mut Vec::new())
}
