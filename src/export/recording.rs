//! A plan as an MCAP recording: what a robot that walks it would publish in ROS 2, and the scene
//! for Foxglove.

use std::collections::BTreeMap;

use surefoot_controller_sim::statics::ContactLoad;
use surefoot_shared_types::InputError;

use crate::export::error::ExportError;
use crate::export::loads::StaticLoads;
use crate::export::mcap::McapWriter;
use crate::export::motion::ExportMotion;
use crate::export::ros::messages::{Text, nanoseconds};
use crate::export::ros::ros_type::RosMessage;
use crate::export::ros::{frames, scene, state, trajectories};
use crate::export::sampling::{EffortSource, Sample, samples};

/// The writer's name in recordings.
const LIBRARY: &str = concat!("surefoot ", env!("CARGO_PKG_VERSION"));

/// The recording of a plan, with its state at `hz`. Times count from the plan's begin.
///
/// # Errors
/// Too many samples, the URDF cannot be read again, or no contact forces hold the robot.
pub fn write(motion: &ExportMotion, hz: f64) -> Result<Vec<u8>, ExportError> {
    let mut recording = Recording::new();
    recording.file.metadata("surefoot", &about(motion));
    recording.add_plan(motion)?;
    let mut loads = StaticLoads::new(motion)?;
    for sample in samples(motion, hz)? {
        let load = loads.at(&sample.waypoint, sample.phase)?;
        recording.add_sample(motion, &sample, &load);
    }
    Ok(recording.file.finish())
}

/// What the recording is of.
fn about(motion: &ExportMotion) -> BTreeMap<&'static str, String> {
    let mut about = BTreeMap::from([
        ("robot", motion.model.name.clone()),
        ("interpolation", motion.interpolation.name().to_owned()),
        ("effort", EffortSource::of(motion).name().to_owned()),
        ("contact_wrenches", EffortSource::Static.name().to_owned()),
    ]);
    if let Some(origin) = &motion.origin {
        about.insert("plan_digest", origin.plan.clone());
        about.insert("robot_digest", origin.robot.clone());
        about.insert("world_digest", origin.world.clone());
    }
    about
}

/// A recording in the making.
struct Recording {
    file: McapWriter,
    schemas: BTreeMap<&'static str, u16>,
    channels: BTreeMap<String, u16>,
}

impl Recording {
    fn new() -> Self {
        let (schemas, channels) = (BTreeMap::new(), BTreeMap::new());
        Self { file: McapWriter::new(LIBRARY), schemas, channels }
    }

    /// Adds a message at a time, s.
    fn add<M: RosMessage>(&mut self, topic: &str, time: f64, message: &M) {
        let channel = match self.channels.get(topic) {
            Some(channel) => *channel,
            None => {
                let declare = || self.file.schema(M::FULL_NAME, &M::schema());
                let schema = *self.schemas.entry(M::FULL_NAME).or_insert_with(declare);
                let channel = self.file.channel(schema, topic);
                self.channels.insert(topic.to_owned(), channel);
                channel
            }
        };
        let time = u64::try_from(nanoseconds(time)).unwrap_or(0);
        self.file.message(channel, time, &message.to_cdr());
    }

    /// The messages that hold for the whole plan.
    fn add_plan(&mut self, motion: &ExportMotion) -> Result<(), ExportError> {
        let urdf = &motion.model.urdf_path;
        let data = std::fs::read_to_string(urdf)
            .map_err(|error| InputError::file(urdf, format!("cannot be read: {error}")))?;
        let footsteps = trajectories::footstep_array(motion);
        self.add("/robot_description", 0.0, &Text { data });
        self.add("/tf_static", 0.0, &frames::static_tf(&motion.model));
        self.add("/joint_trajectory", 0.0, &trajectories::joint_trajectory(motion));
        self.add("/root_trajectory", 0.0, &trajectories::root_trajectory(motion));
        self.add("/footsteps", 0.0, &footsteps);
        self.add("/footstep_markers", 0.0, &scene::footstep_markers(&footsteps));
        self.add("/world_markers", 0.0, &scene::world_markers(&motion.world)?);
        self.add("/scene", 0.0, &scene::scene_update(&motion.world, &footsteps)?);
        Ok(())
    }

    fn add_sample(&mut self, motion: &ExportMotion, sample: &Sample, load: &ContactLoad) {
        let (model, time) = (&motion.model, sample.time);
        let tf = frames::tf(model, &sample.waypoint, time);
        self.add("/frame_transforms", time, &frames::frame_transforms(&tf));
        self.add("/tf", time, &tf);
        let joints = model.joints.len();
        let planned: Vec<f64>;
        let efforts = if motion.has_torque {
            let locked = load.torques[joints..].iter().copied();
            planned = sample.waypoint.torque[..joints].iter().copied().chain(locked).collect();
            &planned
        } else {
            &load.torques
        };
        self.add("/joint_states", time, &state::joint_state(motion, sample, efforts));
        self.add("/centre_of_mass", time, &state::centre_of_mass(sample, load));
        for (limb, foot) in model.feet.iter().enumerate() {
            let wrench = state::contact_wrench(motion, sample, load, limb);
            self.add(&format!("/contact_wrench/{}", foot.name), time, &wrench);
        }
    }
}
