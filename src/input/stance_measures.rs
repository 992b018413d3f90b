//! Measures of a robot in its standing posture.

use surefoot_planner::kinematics::Kinematics;
use surefoot_shared_types::Pose;
use surefoot_shared_types::robot::model::RobotModel;

/// The sole frames in the root's frame.
fn soles(model: &RobotModel) -> Vec<Pose> {
    let kinematics = Kinematics::new(model);
    let mut links = vec![Pose::IDENTITY; kinematics.links_len()];
    kinematics.forward(&Pose::IDENTITY, &model.standing_q, &mut links);
    model.feet.iter().map(|foot| links[foot.link] * foot.link_from_sole).collect()
}

/// The height of the root's origin above the soles, m.
pub fn standing_height(model: &RobotModel) -> f64 {
    let soles = soles(model);
    let heights = soles.iter().map(|sole| -sole.translation.z);
    heights.sum::<f64>() / soles.len().max(1) as f64
}
