//! The frames of the robot: root, links and soles.

use surefoot_shared_types::Pose;
use surefoot_shared_types::message::Waypoint;
use surefoot_shared_types::robot::model::RobotModel;

use crate::export::ros::foxglove::{FrameTransform, FrameTransforms};
use crate::export::ros::messages::{Header, TfMessage, Time, TransformStamped, WORLD_FRAME};

/// A frame and its pose in its parent.
struct Frame {
    parent: String,
    child: String,
    parent_from_child: Pose,
}

/// The name of a foot's sole frame.
pub fn sole_frame(foot: &str) -> String {
    format!("{foot}_sole")
}

/// The frames that never move: links on fixed or locked joints, and the soles.
pub fn static_tf(model: &RobotModel) -> TfMessage {
    let fixed = model.links.iter().filter_map(|link| {
        let attachment = link.parent.as_ref().filter(|attachment| attachment.joint.is_none())?;
        Some(Frame {
            parent: model.links[attachment.parent].name.clone(),
            child: link.name.clone(),
            parent_from_child: attachment.parent_from_joint,
        })
    });
    let soles = model.feet.iter().map(|foot| Frame {
        parent: model.links[foot.link].name.clone(),
        child: sole_frame(&foot.name),
        parent_from_child: foot.link_from_sole,
    });
    let stamped = fixed.chain(soles).map(|frame| frame.stamped(0.0));
    TfMessage { transforms: stamped.collect() }
}

/// The frames that move, at a time (s) since the plan's begin.
pub fn tf(model: &RobotModel, waypoint: &Waypoint, time: f64) -> TfMessage {
    let frames = moving(model, waypoint);
    TfMessage { transforms: frames.iter().map(|frame| frame.stamped(time)).collect() }
}

/// The same frames for Foxglove.
pub fn frame_transforms(tf: &TfMessage) -> FrameTransforms {
    let transforms = tf.transforms.iter().map(|stamped| FrameTransform {
        timestamp: Time::clone(&stamped.header.stamp),
        parent_frame_id: stamped.header.frame_id.clone(),
        child_frame_id: stamped.child_frame_id.clone(),
        translation: stamped.transform.translation.clone(),
        rotation: stamped.transform.rotation.clone(),
    });
    FrameTransforms { transforms: transforms.collect() }
}

fn moving(model: &RobotModel, waypoint: &Waypoint) -> Vec<Frame> {
    let root = Frame {
        parent: WORLD_FRAME.to_owned(),
        child: model.links[0].name.clone(),
        parent_from_child: waypoint.world_from_root(),
    };
    let links = model.links.iter().filter_map(|link| {
        let attachment = link.parent.as_ref()?;
        let index = attachment.joint?;
        let (joint, position) = (&model.joints[index], waypoint.q[index]);
        Some(Frame {
            parent: model.links[attachment.parent].name.clone(),
            child: link.name.clone(),
            parent_from_child: attachment.parent_from_joint
                * joint.kind.motion(joint.axis, position),
        })
    });
    std::iter::once(root).chain(links).collect()
}

impl Frame {
    fn stamped(&self, time: f64) -> TransformStamped {
        TransformStamped {
            header: Header::at(time, &self.parent),
            child_frame_id: self.child.clone(),
            transform: (&self.parent_from_child).into(),
        }
    }
}
