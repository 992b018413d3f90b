//! The keys of the curve: what the root, the centre of mass and the free joints aim at.

use glam::{DQuat, DVec2, DVec3};
use surefoot_shared_types::base::spatial::{
    rotation_about, rotation_from_scaled_axis, scaled_axis_from_rotation, wrap_angle, yaw_of,
};

use crate::constraints::constraints::Constraints;
use crate::motion::ids::TransitionId;
use crate::motion::roadmap::Roadmap;
use crate::robot::configuration::Configuration;
use crate::robot::kinematic_state::KinematicState;

/// A key of the curve.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Key {
    /// The centre of mass in world x and y, m.
    pub com: DVec2,
    /// Height of the root, m.
    pub height: f64,
    /// Heading of the root, rad.
    pub yaw: f64,
    /// Rotation of the root after the heading, as a rotation vector, rad.
    pub tilt: DVec3,
    /// The nodes of the plan whose free joints it takes the mean of.
    pub nodes: [TransitionId; 2],
}

impl Key {
    /// The key of the plan's configuration at a node.
    pub fn at_node(constraints: &Constraints, roadmap: &Roadmap, node: TransitionId) -> Self {
        let configuration = roadmap.state(node).configuration;
        let kinematic_state = KinematicState::new(&constraints.robot, &configuration);
        let root = configuration.world_from_root;
        let yaw = yaw_of(root.rotation);
        let tilt = rotation_about(DVec3::Z, -yaw) * root.rotation;
        Self {
            com: kinematic_state.com.truncate(),
            height: root.translation.z,
            yaw,
            tilt: scaled_axis_from_rotation(tilt),
            nodes: [node; 2],
        }
    }
}

/// The keys around an interval, with their weights.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WeightedKeys<'a> {
    /// The keys; those of weight 0 may be any.
    pub keys: [&'a Key; 4],
    /// Their weights, of sum 1.
    pub weights: [f64; 4],
}

impl WeightedKeys<'_> {
    /// The centre of mass in world x and y, m.
    pub fn com(&self) -> DVec2 {
        self.keys.iter().zip(self.weights).map(|(key, weight)| key.com * weight).sum()
    }

    /// The rotation of the root.
    pub fn rotation(&self) -> DQuat {
        let first = self.keys[1].yaw;
        let (mut yaw, mut tilt) = (first, DVec3::ZERO);
        for (key, weight) in self.keys.iter().zip(self.weights) {
            yaw += weight * wrap_angle(key.yaw - first);
            tilt += weight * key.tilt;
        }
        (rotation_about(DVec3::Z, yaw) * rotation_from_scaled_axis(tilt)).normalize()
    }

    /// Sets the height and the rotation of the root, and the free joints.
    pub fn pose(
        &self,
        constraints: &Constraints,
        roadmap: &Roadmap,
        configuration: &mut Configuration,
    ) {
        let root = &mut configuration.world_from_root;
        root.rotation = self.rotation();
        root.translation.z =
            self.keys.iter().zip(self.weights).map(|(key, weight)| key.height * weight).sum();
        for joint in &constraints.robot.free_joints {
            configuration.q[joint.index] = 0.0;
        }
        for (key, weight) in self.keys.iter().zip(self.weights) {
            if weight == 0.0 {
                continue;
            }
            for node in key.nodes {
                let q = &roadmap.state(node).configuration.q;
                for joint in &constraints.robot.free_joints {
                    configuration.q[joint.index] += 0.5 * weight * q[joint.index];
                }
            }
        }
    }
}
