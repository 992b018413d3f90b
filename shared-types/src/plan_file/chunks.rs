//! The chunks of a plan file: the stream that the planner would publish.

use std::ops::RangeInclusive;
use std::path::Path;

use bytemuck::Zeroable;
use glam::DQuat;

use crate::base::digest::Digest;
use crate::base::input_error::InputError;
use crate::base::limits::{CHUNK_WAYPOINTS_MAX, JOINTS_MAX, POLYGON_VERTICES_MAX};
use crate::message::chunk::{CHUNK_SCHEMA, FLAG_FIRST, FLAG_LAST, ROOT_FREEDOMS};
use crate::message::{Contact, Interpolation, PlanChunk, SupportMode, Waypoint, WithCrc};
use crate::plan_file::ramps::fitting_chunks;
use crate::plan_file::read::joint_order;
use crate::plan_format::blocks::{ContactBlock, PhaseBlock, PlanFile, WaypointBlock};
use crate::robot::model::RobotModel;
use crate::world::world::World;

/// Most waypoints of a chunk after its first one.
const STEPS_MAX: usize = CHUNK_WAYPOINTS_MAX - 1;
/// The plan id of the chunks.
const PLAN_ID: u64 = 1;

/// The chunks of a plan that was loaded from `plan_path`. A smooth plan states them; in another
/// plan each phase is cut into as few as possible. A contact's polygon is the whole sole.
///
/// # Errors
/// The plan does not fit the robot, or the stated chunks do not fit the rest of the file.
pub fn chunks_from_plan(
    plan: &PlanFile,
    robot: &RobotModel,
    world: &World,
    plan_path: &Path,
) -> Result<Vec<PlanChunk>, InputError> {
    let order = joint_order(plan, robot, plan_path)?;
    let refused = |element: &str, message: String| InputError::element(plan_path, element, message);
    if order.len() > JOINTS_MAX {
        return Err(refused("joint_names", format!("more than {JOINTS_MAX} joints")));
    }
    let stated = fitting_chunks(plan).map_err(|message| refused("chunks", message))?;
    let is_smooth = plan.waypoints.iter().any(|waypoint| !waypoint.velocity.is_empty());
    let mut chunks = Vec::new();
    for (at, phase) in plan.phases.iter().enumerate() {
        let head = head(phase, robot, world, order.len())
            .map_err(|message| refused(&format!("phase {at}"), message))?;
        let within = |range: &RangeInclusive<usize>| {
            phase.first <= *range.start() && *range.end() <= phase.last
        };
        let ranges: Vec<RangeInclusive<usize>> = if stated.is_empty() {
            pieces(phase).collect()
        } else {
            stated.iter().map(|chunk| chunk.first..=chunk.last).filter(within).collect()
        };
        for range in ranges {
            let mut chunk = head;
            let blocks = &plan.waypoints[range.clone()];
            for (slot, block) in chunk.waypoints.iter_mut().zip(blocks) {
                *slot = waypoint(block, &order);
            }
            chunk.waypoints_len = blocks.len() as u32;
            chunk.interpolation = match is_smooth {
                true => Interpolation::Quintic as u64,
                false => Interpolation::Linear as u64,
            };
            chunk.brake_at = plan.waypoints[*range.end()].t;
            if let Some(block) = stated.iter().find(|block| block.first == *range.start()) {
                (chunk.brake_at, chunk.brake_duration) = (block.brake_at, block.brake_duration);
                chunk.resume_duration = block.resume_duration;
            }
            chunks.push(chunk);
        }
    }
    finalize(&mut chunks);
    Ok(chunks)
}

/// The waypoints of a phase in pieces that share their ends.
fn pieces(phase: &PhaseBlock) -> impl Iterator<Item = RangeInclusive<usize>> + use<> {
    let (first, last) = (phase.first, phase.last);
    let count = (last - first).div_ceil(STEPS_MAX).max(1);
    (0..count).map(move |at| first + at * STEPS_MAX..=last.min(first + (at + 1) * STEPS_MAX))
}

/// A chunk of a phase, without waypoints.
fn head(
    phase: &PhaseBlock,
    robot: &RobotModel,
    world: &World,
    joints: usize,
) -> Result<PlanChunk, String> {
    let mode = SupportMode::from_name(&phase.mode)
        .ok_or_else(|| format!("the mode '{}' is unknown", phase.mode))?;
    let mut chunk = PlanChunk {
        schema: CHUNK_SCHEMA,
        plan_id: PLAN_ID,
        mode: mode as u32,
        joints_len: joints as u32,
        robot: robot.digest,
        world: world.digest,
        ..PlanChunk::zeroed()
    };
    for (slot, block) in chunk.contacts.iter_mut().zip(&phase.contacts) {
        *slot = contact(robot, block)?;
    }
    chunk.contacts_len = phase.contacts.len() as u32;
    Ok(chunk)
}

/// A contact of a plan file; its polygon is the whole sole.
///
/// # Errors
/// The robot has no such foot.
pub fn contact(robot: &RobotModel, block: &ContactBlock) -> Result<Contact, String> {
    let limb = robot.feet.iter().position(|foot| foot.name == block.foot);
    let limb = limb.ok_or_else(|| format!("the foot '{}' is unknown", block.foot))?;
    let sole = &robot.feet[limb].polygon;
    let mut polygon = [[0.0; 2]; POLYGON_VERTICES_MAX];
    polygon.iter_mut().zip(sole).for_each(|(corner, at)| *corner = at.to_array());
    Ok(Contact {
        limb: limb as u32,
        polygon_len: sole.len().min(POLYGON_VERTICES_MAX) as u32,
        position: block.sole_pose.xyz,
        rotation: unit(block.sole_pose.quat_xyzw),
        polygon,
    })
}

/// The same rotation, of unit length. One that is a unit quaternion within rounding stays as it is.
fn unit(quat_xyzw: [f64; 4]) -> [f64; 4] {
    let quat = DQuat::from_array(quat_xyzw);
    if (quat.length_squared() - 1.0).abs() < 4.0 * f64::EPSILON {
        return quat_xyzw;
    }
    quat.normalize().to_array()
}

/// A waypoint of a plan file, its joints in the [`joint_order`] of a robot.
pub fn waypoint(block: &WaypointBlock, order: &[usize]) -> Waypoint {
    let joints = |numbers: &[f64]| {
        let mut slots = [0.0; JOINTS_MAX];
        if !numbers.is_empty() {
            slots.iter_mut().zip(order).for_each(|(slot, &place)| *slot = numbers[place]);
        }
        slots
    };
    let root = |numbers: &[f64]| {
        let mut slots = [0.0; ROOT_FREEDOMS];
        slots.iter_mut().zip(numbers).for_each(|(slot, number)| *slot = *number);
        slots
    };
    let of_joints = |numbers: &'_ [f64]| joints(numbers.get(ROOT_FREEDOMS..).unwrap_or_default());
    Waypoint {
        time: block.t,
        root_position: block.root_xyz,
        root_rotation: unit(block.root_quat_xyzw),
        q: joints(&block.q),
        root_velocity: root(&block.velocity),
        joint_velocity: of_joints(&block.velocity),
        root_acceleration: root(&block.acceleration),
        joint_acceleration: of_joints(&block.acceleration),
        torque: joints(&block.torque),
        rest_torque: joints(&block.rest_torque),
        rate_change_torque: joints(&block.rate_change_torque),
    }
}

/// Writes sequence numbers, flags, digests and CRCs.
fn finalize(chunks: &mut [PlanChunk]) {
    let count = chunks.len();
    let mut stream = Digest::default();
    for (at, chunk) in chunks.iter_mut().enumerate() {
        chunk.sequence = at as u64;
        chunk.flags |= if at == 0 { FLAG_FIRST } else { 0 };
        chunk.flags |= if at + 1 == count { FLAG_LAST } else { 0 };
        chunk.stream = stream;
        chunk.write_crc();
        stream = chunk.stream_after();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_share_their_ends_and_hold_at_most_32_waypoints() {
        let phase = |first, last| PhaseBlock { first, last, mode: "left".into(), contacts: vec![] };
        let pieces = |first, last| pieces(&phase(first, last)).collect::<Vec<_>>();
        assert_eq!(pieces(4, 4), [4..=4]);
        assert_eq!(pieces(4, 35), [4..=35]);
        assert_eq!(pieces(4, 36), [4..=35, 35..=36]);
        assert_eq!(pieces(0, 62), [0..=31, 31..=62]);
    }
}
