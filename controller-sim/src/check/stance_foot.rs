//! The difference of a stance foot from its declared pose.

use glam::DVec2;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::rotation_distance;
use surefoot_shared_types::message::Contact;
use surefoot_shared_types::robot::model::RobotModel;

use crate::base::comparison::largest;
use crate::check::motion::Sample;

/// A stance foot at an instant, and its difference from the declared pose.
pub(crate) struct StanceFoot {
    /// Distance of the sole frames, m.
    pub(crate) distance: f64,
    /// Rotation between them, rad.
    pub(crate) turn: f64,
    /// Largest distance of a point of the sole from its declared place, m.
    pub(crate) displacement: f64,
    /// Height of the middle of the sole over its declared place, along the declared normal, m.
    pub(crate) lift: f64,
    /// The most by which the centre of mass moves when the foot takes its declared pose and the
    /// robot moves with it, m.
    pub(crate) shift: f64,
}

impl StanceFoot {
    /// The foot of a contact in a sample of a motion.
    pub(crate) fn new(model: &RobotModel, contact: &Contact, sample: &Sample) -> Self {
        let limb = contact.limb as usize;
        let declared = contact.world_from_sole();
        let declared = Pose::from_parts(declared.translation, declared.rotation.normalize());
        let actual = sample.posture.world_from_sole(model, limb);
        let distance = declared.translation.distance(actual.translation);
        let turn = rotation_distance(declared.rotation, actual.rotation);
        let displaced =
            |vertex: &DVec2| (declared * vertex.extend(0.0)).distance(actual * vertex.extend(0.0));
        let corners = &model.feet[limb].polygon;
        let middle = (corners.iter().sum::<DVec2>() / corners.len() as f64).extend(0.0);
        let lift = (declared.inverse() * (actual * middle)).z;
        let lever = sample.centre_of_mass.distance(actual.translation);
        Self {
            distance,
            turn,
            displacement: largest(corners.iter().map(displaced)),
            lift,
            shift: distance + turn * lever,
        }
    }
}
