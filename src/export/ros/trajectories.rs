//! Trajectories and footsteps of a plan as ROS 2 messages.

use glam::{DQuat, DVec3};
use surefoot_shared_types::Pose as SpatialPose;
use surefoot_shared_types::message::{Interpolation, Waypoint};
use surefoot_shared_types::plan_format::blocks::PoseBlock;

use crate::export::footsteps::{Footstep as Step, footsteps};
use crate::export::motion::ExportMotion;
use crate::export::ros::messages::{
    Duration, Footstep, FootstepArray, Header, JointTrajectory, JointTrajectoryPoint,
    MultiDofJointTrajectory, MultiDofJointTrajectoryPoint, Point, Pose, Twist, WORLD_FRAME,
};

/// The joints at the plan's waypoints. A plan of straight lines has positions alone, which joint
/// trajectory controllers join by straight lines; a smooth one also velocities and accelerations,
/// which they join by the polynomials of degree 5 that the plan means.
pub fn joint_trajectory(motion: &ExportMotion) -> JointTrajectory {
    let joints = motion.model.joints.len();
    let is_smooth = motion.interpolation == Interpolation::Quintic;
    let begin = motion.span().0;
    let of_joints = |numbers: &[f64], is_stated: bool| {
        if is_stated { numbers[..joints].to_vec() } else { Vec::new() }
    };
    let point = |waypoint: &Waypoint| JointTrajectoryPoint {
        positions: of_joints(&waypoint.q, true),
        velocities: of_joints(&waypoint.joint_velocity, is_smooth),
        accelerations: of_joints(&waypoint.joint_acceleration, is_smooth),
        effort: of_joints(&waypoint.torque, motion.has_torque),
        time_from_start: Duration::of(waypoint.time - begin),
    };
    JointTrajectory {
        header: Header::at(0.0, ""),
        joint_names: motion.model.joints.iter().map(|joint| joint.name.clone()).collect(),
        points: motion.waypoints.iter().map(point).collect(),
    }
}

/// The root link at the plan's waypoints, with velocities and accelerations as
/// [`joint_trajectory`].
pub fn root_trajectory(motion: &ExportMotion) -> MultiDofJointTrajectory {
    let is_smooth = motion.interpolation == Interpolation::Quintic;
    let begin = motion.span().0;
    let of_root = |rates: [f64; 6]| if is_smooth { vec![Twist::of(rates)] } else { Vec::new() };
    let point = |waypoint: &Waypoint| MultiDofJointTrajectoryPoint {
        transforms: vec![(&waypoint.world_from_root()).into()],
        velocities: of_root(waypoint.root_velocity),
        accelerations: of_root(waypoint.root_acceleration),
        time_from_start: Duration::of(waypoint.time - begin),
    };
    MultiDofJointTrajectory {
        header: Header::at(0.0, WORLD_FRAME),
        joint_names: vec![motion.model.links[0].name.clone()],
        points: motion.waypoints.iter().map(point).collect(),
    }
}

/// The footsteps of a plan.
pub fn footstep_array(motion: &ExportMotion) -> FootstepArray {
    let list = footsteps(motion);
    let footsteps = list.footsteps.iter().map(|step| footstep(step, list.begin));
    FootstepArray { header: Header::at(0.0, WORLD_FRAME), footsteps: footsteps.collect() }
}

fn footstep(step: &Step, begin: f64) -> Footstep {
    let swing = step.swing.as_ref();
    let waypoints = swing.map_or(&[][..], |swing| &swing.waypoints);
    let corner = |[x, y]: &[f64; 2]| Point::from(DVec3::new(*x, *y, 0.0));
    let lift_off = swing.map_or(step.touch_down, |swing| swing.lift_off);
    Footstep {
        foot: step.foot.clone(),
        sole_pose: pose(&step.sole_pose),
        polygon: step.polygon.iter().map(corner).collect(),
        lift_off: Duration::of(lift_off - begin),
        touch_down: Duration::of(step.touch_down - begin),
        swing: waypoints.iter().map(|waypoint| pose(&waypoint.sole_pose)).collect(),
        swing_times: waypoints.iter().map(|waypoint| Duration::of(waypoint.t - begin)).collect(),
    }
}

fn pose(block: &PoseBlock) -> Pose {
    let rotation = DQuat::from_array(block.quat_xyzw);
    (&SpatialPose::from_parts(block.xyz.into(), rotation)).into()
}
