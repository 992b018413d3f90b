//! Publishes what readers have to know of a walk, and makes it from robot and digests.

use bytemuck::Zeroable;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::ipc;

use crate::base::digest::Digest;
use crate::base::limits::{CONTACTS_MAX, JOINTS_MAX};
use crate::instance::error::ChannelError;
use crate::instance::services::Service;
use crate::message::description::{
    CONVENTIONS, DESCRIPTION_SCHEMA, FootDescription, JointDescription,
};
use crate::message::{Description, WithCrc};
use crate::robot::model::{Foot, Joint, JointKind, RobotModel};

/// A process's publisher of its description.
#[derive(Debug)]
pub(crate) struct DescriptionPublisher {
    publisher: Publisher<ipc::Service, Description, ()>,
    _service: Service<Description>,
}

impl DescriptionPublisher {
    /// Publishes a description. Hold the lock `making` meanwhile.
    pub(crate) fn open(
        service: Service<Description>,
        description: &Description,
    ) -> Result<Self, ChannelError> {
        let publisher = service.publisher_builder().create().map_err(|error| {
            ChannelError::transport("creating the publisher of the description", error)
        })?;
        let failed = |error| ChannelError::transport("sending the description", error);
        let slot = publisher.loan_uninit().map_err(|error| {
            ChannelError::transport("loaning shared memory for the description", error)
        })?;
        slot.write_payload(*description).send().map_err(failed)?;
        Ok(Self { publisher, _service: service })
    }

    /// Delivers the description to readers that have joined since. A reader that cannot be
    /// connected is tried again at the next call.
    pub(crate) fn refresh(&self) {
        let _ = self.publisher.update_connections();
    }
}

impl Description {
    /// The description of a robot. `sender` is the planner's session or the controller's id.
    pub fn of(sender: u64, model: &RobotModel, world: Digest, config: Digest) -> Self {
        let mut description = Self {
            schema: DESCRIPTION_SCHEMA,
            sender,
            joints_len: model.joints.len().min(JOINTS_MAX) as u32,
            feet_len: model.feet.len().min(CONTACTS_MAX) as u32,
            robot: model.digest,
            world,
            config,
            robot_name: model.name.as_str().into(),
            root_link: model.links[0].name.as_str().into(),
            mass: model.mass(),
            ..Self::zeroed()
        };
        description.conventions[..CONVENTIONS.len()].copy_from_slice(CONVENTIONS.as_bytes());
        for (slot, joint) in description.joints.iter_mut().zip(&model.joints) {
            *slot = joint_description(joint);
        }
        for (slot, foot) in description.feet.iter_mut().zip(&model.feet) {
            *slot = foot_description(model, foot);
        }
        description.write_crc();
        description
    }
}

fn joint_description(joint: &Joint) -> JointDescription {
    JointDescription {
        name: joint.name.as_str().into(),
        kind: match joint.kind {
            JointKind::Revolute => 0,
            JointKind::Prismatic => 1,
        },
        lower: joint.lower,
        upper: joint.upper,
        velocity: joint.velocity,
        acceleration: joint.acceleration(),
        effort: joint.effort,
    }
}

fn foot_description(model: &RobotModel, foot: &Foot) -> FootDescription {
    let mut description = FootDescription {
        name: foot.name.as_str().into(),
        link: model.links[foot.link].name.as_str().into(),
        position: foot.link_from_sole.translation.to_array(),
        rotation: foot.link_from_sole.rotation.to_array(),
        ..FootDescription::zeroed()
    };
    for (slot, vertex) in description.polygon.iter_mut().zip(&foot.polygon) {
        *slot = vertex.to_array();
        description.polygon_len += 1;
    }
    description
}
