//! The sampled walk as ROS 2 messages, for iceoryx2's ROS 2 gateway: `/joint_states`, `/tf` of the
//! root, and the trajectories of each accepted chunk.

use std::time::{SystemTime, UNIX_EPOCH};

use surefoot_shared_types::instance::error::ChannelError;
use surefoot_shared_types::instance::participant::Participant;
use surefoot_shared_types::instance::ros_topics::{
    JointStateByte, JointTrajectoryByte, RootTrajectoryByte, RosPublisher, TfByte,
};
use surefoot_shared_types::message::description::Name;
use surefoot_shared_types::message::{Description, PlanChunk, SetPoint, Waypoint};

use crate::export::ros::messages::{
    Duration, Header, JointState, JointTrajectory, JointTrajectoryPoint, MultiDofJointTrajectory,
    MultiDofJointTrajectoryPoint, TfMessage, Time, TransformStamped, Twist, WORLD_FRAME,
};
use crate::export::ros::ros_type::RosMessage;
use crate::report::command_error::CommandError;

/// Set-points between two messages of the robot's state.
const TICKS_PER_STATE: u64 = 10;
/// Longest message of the state, bytes.
const STATE_BYTES_MAX: usize = 12 << 10;
/// Longest trajectory of a chunk, bytes.
const TRAJECTORY_BYTES_MAX: usize = 64 << 10;

/// The publishers of all topics.
pub(crate) struct RosTopics {
    joint_states: RosPublisher<JointStateByte>,
    tf: RosPublisher<TfByte>,
    joint_trajectory: RosPublisher<JointTrajectoryByte>,
    root_trajectory: RosPublisher<RootTrajectoryByte>,
    /// The robot's names, once its description has come.
    names: Option<Names>,
}

/// Names of a robot.
struct Names {
    joints: Vec<String>,
    root_link: String,
}

impl RosTopics {
    /// Joins the services of an instance.
    ///
    /// # Errors
    /// Shared memory is full, or the transport fails.
    pub(crate) fn open(participant: &Participant) -> Result<Self, ChannelError> {
        Ok(Self {
            joint_states: RosPublisher::open(participant, "joint_states", STATE_BYTES_MAX)?,
            tf: RosPublisher::open(participant, "tf", STATE_BYTES_MAX)?,
            joint_trajectory: RosPublisher::open(
                participant,
                "joint_trajectory",
                TRAJECTORY_BYTES_MAX,
            )?,
            root_trajectory: RosPublisher::open(
                participant,
                "root_trajectory",
                TRAJECTORY_BYTES_MAX,
            )?,
            names: None,
        })
    }

    /// Publishes from then on with the names of a description.
    ///
    /// # Errors
    /// A name in it is cut.
    pub(crate) fn describe(&mut self, description: &Description) -> Result<(), CommandError> {
        let joints = description.joints().iter().map(|joint| text(&joint.name));
        let root_link = text(&description.root_link)?;
        self.names = Some(Names { joints: joints.collect::<Result<_, _>>()?, root_link });
        Ok(())
    }

    /// Whether the names are known, without which nothing is published.
    pub(crate) fn is_described(&self) -> bool {
        self.names.is_some()
    }

    /// Publishes the robot's state at every tenth set-point.
    ///
    /// # Errors
    /// The transport fails.
    pub(crate) fn publish_state(&mut self, point: &SetPoint) -> Result<(), ChannelError> {
        let Some(names) = &self.names else { return Ok(()) };
        if !point.tick.is_multiple_of(TICKS_PER_STATE) {
            return Ok(());
        }
        let (waypoint, joints) = (&point.waypoint, names.joints.len());
        let now = nanoseconds_now();
        let state = JointState {
            header: header(now, ""),
            name: names.joints.clone(),
            position: waypoint.q[..joints].to_vec(),
            velocity: waypoint.joint_velocity[..joints].to_vec(),
            effort: waypoint.torque[..joints].to_vec(),
        };
        let root = TransformStamped {
            header: header(now, WORLD_FRAME),
            child_frame_id: names.root_link.clone(),
            transform: (&waypoint.world_from_root()).into(),
        };
        self.joint_states.publish(&state.to_cdr(), now)?;
        self.tf.publish(&TfMessage { transforms: vec![root] }.to_cdr(), now)
    }

    /// Publishes the trajectories of an accepted chunk, which begin `seconds` from now at full
    /// speed.
    ///
    /// # Errors
    /// The transport fails.
    pub(crate) fn publish_chunk(
        &mut self,
        chunk: &PlanChunk,
        seconds: f64,
    ) -> Result<(), ChannelError> {
        let Some(names) = &self.names else { return Ok(()) };
        let now = nanoseconds_now();
        let begin = now + (1e9 * seconds.max(0.0)) as i64;
        let joints = names.joint_trajectory(chunk, begin).to_cdr();
        let root = names.root_trajectory(chunk, begin).to_cdr();
        self.joint_trajectory.publish(&joints, now)?;
        self.root_trajectory.publish(&root, now)
    }
}

impl Names {
    fn joint_trajectory(&self, chunk: &PlanChunk, begin: i64) -> JointTrajectory {
        let joints = self.joints.len();
        let is_smooth = chunk.is_smooth();
        let of_joints =
            |numbers: &[f64]| if is_smooth { numbers[..joints].to_vec() } else { vec![] };
        let point = |waypoint: &Waypoint| JointTrajectoryPoint {
            positions: waypoint.q[..joints].to_vec(),
            velocities: of_joints(&waypoint.joint_velocity),
            accelerations: of_joints(&waypoint.joint_acceleration),
            effort: of_joints(&waypoint.torque),
            time_from_start: since_begin(chunk, waypoint),
        };
        JointTrajectory {
            header: header(begin, ""),
            joint_names: self.joints.clone(),
            points: chunk.waypoints().iter().map(point).collect(),
        }
    }

    fn root_trajectory(&self, chunk: &PlanChunk, begin: i64) -> MultiDofJointTrajectory {
        let is_smooth = chunk.is_smooth();
        let of_root = |rates: [f64; 6]| if is_smooth { vec![Twist::of(rates)] } else { vec![] };
        let point = |waypoint: &Waypoint| MultiDofJointTrajectoryPoint {
            transforms: vec![(&waypoint.world_from_root()).into()],
            velocities: of_root(waypoint.root_velocity),
            accelerations: of_root(waypoint.root_acceleration),
            time_from_start: since_begin(chunk, waypoint),
        };
        MultiDofJointTrajectory {
            header: header(begin, WORLD_FRAME),
            joint_names: vec![self.root_link.clone()],
            points: chunk.waypoints().iter().map(point).collect(),
        }
    }
}

fn since_begin(chunk: &PlanChunk, waypoint: &Waypoint) -> Duration {
    let begin = chunk.waypoints().first().map_or(0.0, |first| first.time);
    Duration::of(waypoint.time - begin)
}

fn text(name: &Name) -> Result<String, CommandError> {
    name.text().map(str::to_owned).ok_or_else(|| {
        CommandError::Usage(
            "a name in the robot's URDF is too long for the description of the walk; shorten the \
             names of joints and links to 88 bytes"
                .into(),
        )
    })
}

/// A header at a time in ns since 1970.
fn header(time_ns: i64, frame: &str) -> Header {
    Header { stamp: Time::of_nanoseconds(time_ns), frame_id: frame.to_owned() }
}

/// The time since 1970, ns: ROS 2 stamps messages with it.
fn nanoseconds_now() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    i64::try_from(since.as_nanos()).unwrap_or(i64::MAX)
}
