//! The robot at an instant as ROS 2 messages.

use surefoot_controller_sim::statics::{ContactLoad, FootLoad};
use surefoot_shared_types::message::Contact;

use crate::export::loads::moment_about;
use crate::export::motion::ExportMotion;
use crate::export::ros::frames::sole_frame;
use crate::export::ros::messages::{
    Header, JointState, PointStamped, WORLD_FRAME, Wrench, WrenchStamped,
};
use crate::export::sampling::Sample;

/// The state of all joints, locked ones after the moving ones. `efforts` has one number a joint.
pub fn joint_state(motion: &ExportMotion, sample: &Sample, efforts: &[f64]) -> JointState {
    let (model, waypoint) = (&motion.model, &sample.waypoint);
    let joints = model.joints.len();
    let locked = &model.locked_joints;
    let names = model.joints.iter().chain(locked.iter().map(|locked| &locked.joint));
    let at_rest = locked.iter().map(|_| 0.0);
    let positions = waypoint.q[..joints].iter().copied();
    let velocities = waypoint.joint_velocity[..joints].iter().copied();
    JointState {
        header: Header::at(sample.time, ""),
        name: names.map(|joint| joint.name.clone()).collect(),
        position: positions.chain(locked.iter().map(|locked| locked.position)).collect(),
        velocity: velocities.chain(at_rest).collect(),
        effort: efforts.to_vec(),
    }
}

/// The centre of mass in the world.
pub fn centre_of_mass(sample: &Sample, load: &ContactLoad) -> PointStamped {
    PointStamped { header: Header::at(sample.time, WORLD_FRAME), point: load.centre_of_mass.into() }
}

/// The wrench of the ground on a foot, about the origin of its sole frame and along its axes; zero
/// for a foot in the air.
pub fn contact_wrench(
    motion: &ExportMotion,
    sample: &Sample,
    load: &ContactLoad,
    limb: usize,
) -> WrenchStamped {
    let contact = motion.phases[sample.phase].contact(limb);
    let foot = load.feet.iter().find(|foot| foot.limb == limb);
    let wrench = contact.zip(foot).map(|(contact, foot)| wrench(contact, foot));
    WrenchStamped {
        header: Header::at(sample.time, &sole_frame(&motion.model.feet[limb].name)),
        wrench: wrench.unwrap_or_default(),
    }
}

fn wrench(contact: &Contact, foot: &FootLoad) -> Wrench {
    let world_from_sole = contact.world_from_sole();
    let sole_from_world = world_from_sole.rotation.conjugate();
    Wrench {
        force: (sole_from_world * foot.force).into(),
        torque: (sole_from_world * (moment_about(foot, world_from_sole.translation))).into(),
    }
}
