//! Arrays of samples for NumPy, one array a quantity, with names beside them.

use crate::export::bodies::{BodyMotion, body_motions};
use crate::export::error::ExportError;
use crate::export::motion::ExportMotion;
use crate::export::npy;
use crate::export::quaternion::QuaternionOrder;
use crate::export::sampling::{EffortSource, Efforts, Sample, samples};
use crate::export::zip::Archive;

/// The archive of a plan.
///
/// # Errors
/// Too many samples, or no contact forces hold the robot.
pub fn write(
    motion: &ExportMotion,
    hz: f64,
    joints: &[usize],
    quaternion: QuaternionOrder,
    links: &[usize],
) -> Result<Vec<u8>, ExportError> {
    let samples: Vec<Sample> = samples(motion, hz)?.collect();
    let mut efforts = Efforts::new(motion)?;
    let mut archive = Arrays::default();
    archive.add("fps", &npy::floats(&[], &[hz]))?;
    archive.add("quaternion_order", &npy::texts(&[], &[quaternion.name()]))?;
    archive.add("effort_source", &npy::texts(&[], &[EffortSource::of(motion).name()]))?;
    archive.add("interpolation", &npy::texts(&[], &[motion.interpolation.name()]))?;
    let plan = motion.origin.as_ref().map_or("", |origin| &origin.plan);
    archive.add("plan_digest", &npy::texts(&[], &[plan]))?;
    archive.add_root(&samples, quaternion)?;
    archive.add_joints(motion, &samples, joints, &mut efforts)?;
    archive.add_contacts(motion, &samples)?;
    if !links.is_empty() {
        archive.add_bodies(motion, &samples, links, quaternion)?;
    }
    archive.finish()
}

/// An archive of arrays in the making.
#[derive(Default)]
struct Arrays {
    zip: Archive,
}

impl Arrays {
    fn add(&mut self, name: &str, file: &[u8]) -> Result<(), ExportError> {
        let added = self.zip.add(&format!("{name}.npy"), file);
        added.map_err(|error| ExportError::writer("npz", error))
    }

    /// One row of `width` numbers for each sample.
    fn add_rows(
        &mut self,
        name: &str,
        width: usize,
        rows: impl Iterator<Item = f64>,
    ) -> Result<(), ExportError> {
        let numbers: Vec<f64> = rows.collect();
        let count = numbers.len().checked_div(width).unwrap_or(0);
        self.add(name, &npy::floats(&[count, width], &numbers))
    }

    fn add_root(
        &mut self,
        samples: &[Sample],
        quaternion: QuaternionOrder,
    ) -> Result<(), ExportError> {
        let times: Vec<f64> = samples.iter().map(|sample| sample.time).collect();
        self.add("time", &npy::floats(&[times.len()], &times))?;
        let waypoints = || samples.iter().map(|sample| &sample.waypoint);
        self.add_rows("root_position", 3, waypoints().flat_map(|w| w.root_position))?;
        let rotations = waypoints().flat_map(|w| quaternion.arrange(w.root_rotation));
        self.add_rows("root_rotation", 4, rotations)?;
        self.add_rows("root_velocity", 6, waypoints().flat_map(|w| w.root_velocity))?;
        self.add_rows("root_acceleration", 6, waypoints().flat_map(|w| w.root_acceleration))
    }

    fn add_joints(
        &mut self,
        motion: &ExportMotion,
        samples: &[Sample],
        joints: &[usize],
        efforts: &mut Efforts,
    ) -> Result<(), ExportError> {
        let model = &motion.model;
        let names: Vec<&str> = joints.iter().map(|&at| model.joints[at].name.as_str()).collect();
        self.add("joint_names", &npy::texts(&[names.len()], &names))?;
        let locked = &model.locked_joints;
        let names: Vec<&str> = locked.iter().map(|locked| locked.joint.name.as_str()).collect();
        self.add("locked_joint_names", &npy::texts(&[names.len()], &names))?;
        let positions: Vec<f64> = locked.iter().map(|locked| locked.position).collect();
        self.add("locked_joint_position", &npy::floats(&[positions.len()], &positions))?;
        let mut rows = |name: &str, numbers: &dyn Fn(&Sample) -> &[f64]| {
            let row = |sample| joints.iter().map(move |&joint| numbers(sample)[joint]);
            self.add_rows(name, joints.len(), samples.iter().flat_map(row))
        };
        rows("joint_position", &|sample| &sample.waypoint.q)?;
        rows("joint_velocity", &|sample| &sample.waypoint.joint_velocity)?;
        rows("joint_acceleration", &|sample| &sample.waypoint.joint_acceleration)?;
        let mut chosen = Vec::with_capacity(samples.len() * joints.len());
        for sample in samples {
            let effort = efforts.of(sample)?;
            chosen.extend(joints.iter().map(|&joint| effort[joint]));
        }
        self.add_rows("joint_effort", joints.len(), chosen.into_iter())
    }

    fn add_contacts(
        &mut self,
        motion: &ExportMotion,
        samples: &[Sample],
    ) -> Result<(), ExportError> {
        let feet = &motion.model.feet;
        let names: Vec<&str> = feet.iter().map(|foot| foot.name.as_str()).collect();
        self.add("contact_names", &npy::texts(&[names.len()], &names))?;
        let limbs = |sample| (0..feet.len()).map(move |limb| (sample, limb));
        let stances = samples.iter().flat_map(limbs);
        let stances: Vec<bool> =
            stances.map(|(sample, limb)| Sample::is_stance(sample, motion, limb)).collect();
        self.add("contacts", &npy::booleans(&[samples.len(), feet.len()], &stances))
    }

    fn add_bodies(
        &mut self,
        motion: &ExportMotion,
        samples: &[Sample],
        links: &[usize],
        quaternion: QuaternionOrder,
    ) -> Result<(), ExportError> {
        let model = &motion.model;
        let names: Vec<&str> = links.iter().map(|&at| model.links[at].name.as_str()).collect();
        self.add("body_names", &npy::texts(&[names.len()], &names))?;
        let chosen = |sample: &Sample| {
            let all = body_motions(model, &sample.waypoint);
            links.iter().map(|&at| all[at]).collect::<Vec<_>>()
        };
        let bodies: Vec<BodyMotion> = samples.iter().flat_map(chosen).collect();
        let shape = |width| [samples.len(), links.len(), width];
        let mut rows = |name: &str, numbers: &dyn Fn(&BodyMotion) -> Vec<f64>| {
            let numbers: Vec<f64> = bodies.iter().flat_map(numbers).collect();
            let width = numbers.len() / bodies.len().max(1);
            self.add(name, &npy::floats(&shape(width), &numbers))
        };
        rows("body_position", &|body| body.world_from_link.translation.to_array().to_vec())?;
        rows("body_rotation", &|body| {
            quaternion.arrange(body.world_from_link.rotation.to_array()).to_vec()
        })?;
        rows("body_velocity", &|body| body.velocity.to_array().to_vec())?;
        rows("body_angular_velocity", &|body| body.angular_velocity.to_array().to_vec())
    }

    fn finish(self) -> Result<Vec<u8>, ExportError> {
        self.zip.finish().map_err(|error| ExportError::writer("npz", error))
    }
}
