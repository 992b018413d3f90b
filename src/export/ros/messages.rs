//! The messages of a plan, as the packages of ROS 2 Humble and later define them.

use glam::{DQuat, DVec3};
use surefoot_shared_types::Pose as SpatialPose;

use crate::export::ros::ros_type::message;

message!(
    /// Time since an epoch.
    Time = "builtin_interfaces" / "Time" {
        /// s.
        sec: i32,
        /// ns.
        nanosec: u32,
    }
);
message!(
    /// A length of time.
    Duration = "builtin_interfaces" / "Duration" {
        /// s.
        sec: i32,
        /// ns.
        nanosec: u32,
    }
);
message!(
    /// Time and frame of a message.
    Header = "std_msgs" / "Header" {
        /// The time.
        stamp: Time,
        /// The frame.
        frame_id: String,
    }
);
message!(
    /// A text.
    Text = "std_msgs" / "String" {
        /// The text.
        data: String,
    }
);
message!(
    /// A colour, each part 0 to 1.
    ColorRgba = "std_msgs" / "ColorRGBA" {
        /// Red.
        r: f32,
        /// Green.
        g: f32,
        /// Blue.
        b: f32,
        /// Opacity.
        a: f32,
    }
);
message!(
    /// A vector.
    Vector3 = "geometry_msgs" / "Vector3" {
        /// Along x.
        x: f64,
        /// Along y.
        y: f64,
        /// Along z.
        z: f64,
    }
);
message!(
    /// A point, m.
    Point = "geometry_msgs" / "Point" {
        /// Along x.
        x: f64,
        /// Along y.
        y: f64,
        /// Along z.
        z: f64,
    }
);
message!(
    /// A unit quaternion.
    Quaternion = "geometry_msgs" / "Quaternion" {
        /// x.
        x: f64,
        /// y.
        y: f64,
        /// z.
        z: f64,
        /// w.
        w: f64,
    }
);
message!(
    /// A pose.
    Pose = "geometry_msgs" / "Pose" {
        /// The position.
        position: Point,
        /// The rotation.
        orientation: Quaternion,
    }
);
message!(
    /// A rigid motion.
    Transform = "geometry_msgs" / "Transform" {
        /// The translation.
        translation: Vector3,
        /// The rotation.
        rotation: Quaternion,
    }
);
message!(
    /// The pose of a frame in another.
    TransformStamped = "geometry_msgs" / "TransformStamped" {
        /// Time, and the parent frame.
        header: Header,
        /// The child frame.
        child_frame_id: String,
        /// The child's pose in the parent.
        transform: Transform,
    }
);
message!(
    /// Velocities, or accelerations.
    Twist = "geometry_msgs" / "Twist" {
        /// Linear, m/s.
        linear: Vector3,
        /// Angular, rad/s.
        angular: Vector3,
    }
);
message!(
    /// A force and a moment.
    Wrench = "geometry_msgs" / "Wrench" {
        /// N.
        force: Vector3,
        /// N m.
        torque: Vector3,
    }
);
message!(
    /// A wrench about the origin of a frame, along its axes.
    WrenchStamped = "geometry_msgs" / "WrenchStamped" {
        /// Time and frame.
        header: Header,
        /// The wrench.
        wrench: Wrench,
    }
);
message!(
    /// A point in a frame.
    PointStamped = "geometry_msgs" / "PointStamped" {
        /// Time and frame.
        header: Header,
        /// The point.
        point: Point,
    }
);
message!(
    /// Poses of frames.
    TfMessage = "tf2_msgs" / "TFMessage" {
        /// The poses.
        transforms: Vec<TransformStamped>,
    }
);
message!(
    /// State of joints.
    JointState = "sensor_msgs" / "JointState" {
        /// Time.
        header: Header,
        /// The joints.
        name: Vec<String>,
        /// Positions, rad or m.
        position: Vec<f64>,
        /// Velocities, rad/s or m/s.
        velocity: Vec<f64>,
        /// Efforts, N m or N.
        effort: Vec<f64>,
    }
);
message!(
    /// A point of a joint trajectory.
    JointTrajectoryPoint = "trajectory_msgs" / "JointTrajectoryPoint" {
        /// Positions, rad or m.
        positions: Vec<f64>,
        /// Velocities, rad/s or m/s; empty if the joints move on straight lines.
        velocities: Vec<f64>,
        /// Accelerations, rad/s2 or m/s2; empty where the velocities are.
        accelerations: Vec<f64>,
        /// Feed-forward efforts, N m or N; empty where the plan states none.
        effort: Vec<f64>,
        /// Time since the trajectory's begin.
        time_from_start: Duration,
    }
);
message!(
    /// A trajectory of joints.
    JointTrajectory = "trajectory_msgs" / "JointTrajectory" {
        /// The begin.
        header: Header,
        /// The joints.
        joint_names: Vec<String>,
        /// The points.
        points: Vec<JointTrajectoryPoint>,
    }
);
message!(
    /// A point of a trajectory of frames.
    MultiDofJointTrajectoryPoint = "trajectory_msgs" / "MultiDOFJointTrajectoryPoint" {
        /// The pose of each frame.
        transforms: Vec<Transform>,
        /// Velocities along the axes of the header's frame; empty on straight lines.
        velocities: Vec<Twist>,
        /// Accelerations; empty where the velocities are.
        accelerations: Vec<Twist>,
        /// Time since the trajectory's begin.
        time_from_start: Duration,
    }
);
message!(
    /// A trajectory of frames.
    MultiDofJointTrajectory = "trajectory_msgs" / "MultiDOFJointTrajectory" {
        /// The begin, and the frame in which the poses are.
        header: Header,
        /// The frames.
        joint_names: Vec<String>,
        /// The points.
        points: Vec<MultiDofJointTrajectoryPoint>,
    }
);
message!(
    /// A footstep.
    Footstep = "surefoot_msgs" / "Footstep" {
        /// "left" or "right".
        foot: String,
        /// The sole frame in the world.
        sole_pose: Pose,
        /// The sole's outline in the sole frame.
        polygon: Vec<Point>,
        /// When the foot lifts off; as `touch_down` for the start stance.
        lift_off: Duration,
        /// When it is set down.
        touch_down: Duration,
        /// The sole on its way, both ends included; empty for the start stance.
        swing: Vec<Pose>,
        /// The times of `swing`.
        swing_times: Vec<Duration>,
    }
);
message!(
    /// The footsteps of a plan: the start stance, then each landing.
    FootstepArray = "surefoot_msgs" / "FootstepArray" {
        /// The plan's begin, and the world frame.
        header: Header,
        /// The footsteps.
        footsteps: Vec<Footstep>,
    }
);

/// The world's frame.
pub const WORLD_FRAME: &str = "world";

/// Whole nanoseconds in a second.
const NANOSECONDS: i64 = 1_000_000_000;

/// A time (s) in whole nanoseconds.
pub fn nanoseconds(seconds: f64) -> i64 {
    libm::round(seconds * NANOSECONDS as f64) as i64
}

impl Time {
    /// The time this many seconds after the epoch.
    pub fn of(seconds: f64) -> Self {
        Self::of_nanoseconds(nanoseconds(seconds))
    }

    /// The time this many nanoseconds after the epoch; the last one that a message can state if it
    /// is later, in the year 2038.
    pub fn of_nanoseconds(total: i64) -> Self {
        let sec = i32::try_from(total.div_euclid(NANOSECONDS)).unwrap_or(i32::MAX);
        Self { sec, nanosec: total.rem_euclid(NANOSECONDS) as u32 }
    }
}

impl Duration {
    /// This many seconds.
    pub fn of(seconds: f64) -> Self {
        let Time { sec, nanosec } = Time::of(seconds);
        Self { sec, nanosec }
    }
}

impl Header {
    /// A header at a time (s).
    pub fn at(seconds: f64, frame: &str) -> Self {
        Self { stamp: Time::of(seconds), frame_id: frame.to_owned() }
    }
}

impl From<DVec3> for Vector3 {
    fn from(DVec3 { x, y, z }: DVec3) -> Self {
        Self { x, y, z }
    }
}

impl From<DVec3> for Point {
    fn from(DVec3 { x, y, z }: DVec3) -> Self {
        Self { x, y, z }
    }
}

impl From<DQuat> for Quaternion {
    fn from(DQuat { x, y, z, w }: DQuat) -> Self {
        Self { x, y, z, w }
    }
}

impl From<&SpatialPose> for Pose {
    fn from(pose: &SpatialPose) -> Self {
        Self { position: pose.translation.into(), orientation: pose.rotation.into() }
    }
}

impl From<&SpatialPose> for Transform {
    fn from(pose: &SpatialPose) -> Self {
        Self { translation: pose.translation.into(), rotation: pose.rotation.into() }
    }
}

impl Twist {
    /// Linear and angular velocities, one after the other.
    pub fn of([x, y, z, wx, wy, wz]: [f64; 6]) -> Self {
        let (linear, angular) = (DVec3::new(x, y, z), DVec3::new(wx, wy, wz));
        Self { linear: linear.into(), angular: angular.into() }
    }
}
