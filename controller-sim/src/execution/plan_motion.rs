//! The motion that a chunk plans, at any instant.

use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::message::{PlanChunk, Waypoint};

use crate::kinematics::forward::Configuration;
use crate::kinematics::trajectory;

/// The motion of a chunk at a time (s), with its torques; before and after the chunk, that of its
/// first and last waypoint. Straight lines have no speed.
pub(crate) fn planned_in(chunk: &PlanChunk, time: f64) -> Waypoint {
    let waypoints = chunk.waypoints();
    let after = waypoints.partition_point(|waypoint| waypoint.time < time).min(waypoints.len() - 1);
    let (from, to) = (&waypoints[after.saturating_sub(1)], &waypoints[after]);
    let seconds = to.time - from.time;
    let share = if seconds > 0.0 { ((time - from.time) / seconds).clamp(0.0, 1.0) } else { 1.0 };
    let mixed = |of: fn(&Waypoint) -> &[f64; JOINTS_MAX]| -> [f64; JOINTS_MAX] {
        let (from, to) = (of(from), of(to));
        std::array::from_fn(|joint| from[joint] + share * (to[joint] - from[joint]))
    };
    let torque = mixed(|waypoint| &waypoint.torque);
    let rest_torque = mixed(|waypoint| &waypoint.rest_torque);
    let rate_change_torque = mixed(|waypoint| &waypoint.rate_change_torque);
    if chunk.is_smooth() && seconds > 0.0 {
        let instant = trajectory::between(from, to, time.clamp(from.time, to.time));
        return Waypoint { torque, rest_torque, rate_change_torque, ..instant };
    }
    let joints = chunk.joints_len as usize;
    let [start, end] = [from, to].map(|waypoint| Configuration::of_waypoint(waypoint, joints));
    let Configuration { world_from_root, q } = start.towards(&end, share);
    let mut waypoint = Waypoint { time, torque, rest_torque, rate_change_torque, ..to.rested() };
    waypoint.root_position = world_from_root.translation.to_array();
    waypoint.root_rotation = world_from_root.rotation.to_array();
    waypoint.q.iter_mut().zip(q).for_each(|(slot, position)| *slot = position);
    waypoint
}
