//! Whether a received chunk is a valid message for this controller, before anything in it is used.
//!
//! Any process of the user can write to the shared memory, so all counts, indices and numbers are
//! checked.

use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::base::limits::{
    CHUNK_WAYPOINTS_MAX, CONTACTS_MAX, POLYGON_VERTICES_MAX,
};
use surefoot_shared_types::message::chunk::{
    CHUNK_SCHEMA, FLAG_FIRST, FLAG_LAST, RAMP_SECONDS_MAX, STOP_ROUNDING_MAX,
};
use surefoot_shared_types::message::{
    Check, Contact, Interpolation, PlanChunk, SupportMode, Waypoint, WithCrc,
};

use crate::check::segment::Violation;
use crate::chunk::continuity::{Stance, contacts_match};

/// No number of a message may be larger than this.
const NUMBER_MAX: f64 = 1e6;
/// How far a quaternion's length may be from 1.
const UNIT_ERROR_MAX: f64 = 1e-6;

/// A controller's id, and the digests of its robot, world and scenario.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Identity {
    /// The controller process's id.
    pub controller_id: u64,
    /// Digest of the robot.
    pub robot: Digest,
    /// Digest of the world.
    pub world: Digest,
    /// Digest of the scenario and its configuration.
    pub config: Digest,
}

/// Whether the bytes of a chunk are undamaged and its form is sound, in this order: CRC; schema,
/// flags, goal, then [`check_content`]. Returns the chunk's mode.
///
/// # Errors
/// The first of these conditions that does not hold.
pub fn check_message(chunk: &PlanChunk, joints: usize) -> Result<SupportMode, Violation> {
    let computed = chunk.computed_crc();
    if chunk.crc != computed {
        let detail = format!("the CRC is {:08x}, that of the bytes {computed:08x}", chunk.crc);
        return Err(Violation::new(Check::Crc, 0, detail));
    }
    check_header(chunk).map_err(|detail| Violation::new(Check::Malformed, 0, detail))?;
    check_content(chunk, joints)
}

/// Whether the motion in a chunk of any origin has a sound form, in this order: counts, mode,
/// contacts, numbers, interpolation and ramps. Returns the chunk's mode.
///
/// # Errors
/// The first of these conditions that does not hold.
pub fn check_content(chunk: &PlanChunk, joints: usize) -> Result<SupportMode, Violation> {
    let bad = |detail: String| Violation::new(Check::Malformed, 0, detail);
    check_counts(chunk, joints).map_err(bad)?;
    let mode = SupportMode::from_wire(chunk.mode)
        .ok_or_else(|| bad(format!("unknown mode {}", chunk.mode)))?;
    chunk.contacts().iter().try_for_each(|contact| check_contact(contact).map_err(bad))?;
    if !contacts_match(&Stance { mode, contacts: chunk.contacts() }) {
        return Err(bad(format!("the contacts are not those of {} support", mode.name())));
    }
    for (index, waypoint) in chunk.waypoints().iter().enumerate() {
        check_waypoint(waypoint)
            .map_err(|detail| Violation::new(Check::Malformed, index, detail))?;
    }
    check_motion(chunk).map_err(bad)?;
    Ok(mode)
}

/// The interpolation, and the ramps of plan time: the robot must stand before the chunk ends.
fn check_motion(chunk: &PlanChunk) -> Result<(), String> {
    let interpolation = Interpolation::from_wire(chunk.interpolation)
        .ok_or_else(|| format!("unknown interpolation {}", chunk.interpolation))?;
    let PlanChunk { brake_at, brake_duration, resume_duration, .. } = *chunk;
    let is_ramp = |seconds: f64| (0.0..=RAMP_SECONDS_MAX).contains(&seconds);
    if !is_ramp(brake_duration) || !is_ramp(resume_duration) {
        return Err(format!(
            "ramps of {brake_duration} s and {resume_duration} s, 0 to {RAMP_SECONDS_MAX} s are \
             possible"
        ));
    }
    let waypoints = chunk.waypoints();
    let (begin, end) = (waypoints[0].time, waypoints[waypoints.len() - 1].time);
    let stands = brake_at + 0.5 * brake_duration;
    if !(begin <= stands && stands <= end + STOP_ROUNDING_MAX) {
        return Err(format!("the robot stands at {stands} s, outside of {begin} to {end} s"));
    }
    if interpolation == Interpolation::Linear {
        return check_rests(chunk);
    }
    Ok(())
}

/// A chunk of straight lines ends at rest, and its waypoints state no velocity.
fn check_rests(chunk: &PlanChunk) -> Result<(), String> {
    let is_resting = |waypoint: &Waypoint| waypoint.rates().all(|rate| rate == 0.0);
    let waypoints = chunk.waypoints();
    let end = waypoints[waypoints.len() - 1].time;
    if chunk.brake_at == end && chunk.brake_duration == 0.0 && waypoints.iter().all(is_resting) {
        return Ok(());
    }
    Err("straight lines with velocities, or with a stop before the end".to_owned())
}

/// Whether a chunk is addressed to this controller and made for its robot, world and scenario.
///
/// # Errors
/// The first of these, in this order, that differs.
pub fn check_identity(chunk: &PlanChunk, identity: &Identity) -> Result<(), Violation> {
    for (check, is_same, what) in [
        (Check::Controller, chunk.target_controller == identity.controller_id, "controller"),
        (Check::Robot, chunk.robot == identity.robot, "robot"),
        (Check::World, chunk.world == identity.world, "world"),
        (Check::Config, chunk.config == identity.config, "scenario or configuration"),
    ] {
        if !is_same {
            return Err(Violation::new(check, 0, format!("made for another {what}")));
        }
    }
    Ok(())
}

/// The schema, the flags and the goal.
fn check_header(chunk: &PlanChunk) -> Result<(), String> {
    if chunk.schema != CHUNK_SCHEMA {
        return Err(format!("schema {}, known is {CHUNK_SCHEMA}", chunk.schema));
    }
    if chunk.flags & !(FLAG_FIRST | FLAG_LAST) != 0 {
        return Err(format!("unknown flags {:#x}", chunk.flags));
    }
    if (chunk.flags & FLAG_FIRST != 0) != (chunk.sequence == 0) {
        let sequence = chunk.sequence;
        return Err(format!("the first-chunk flag does not fit sequence number {sequence}"));
    }
    if chunk.goal.stance_width != 0.0 && chunk.goal.stance_pose().is_none() {
        return Err("a goal with a number out of range".to_owned());
    }
    Ok(())
}

fn check_counts(chunk: &PlanChunk, joints: usize) -> Result<(), String> {
    if chunk.joints_len as usize != joints {
        return Err(format!("{} joints, the robot has {joints}", chunk.joints_len));
    }
    if !(1..=CHUNK_WAYPOINTS_MAX).contains(&(chunk.waypoints_len as usize)) {
        let count = chunk.waypoints_len;
        return Err(format!("{count} waypoints, 1 to {CHUNK_WAYPOINTS_MAX} are possible"));
    }
    if chunk.contacts_len as usize > CONTACTS_MAX {
        let count = chunk.contacts_len;
        return Err(format!("{count} contacts, at most {CONTACTS_MAX} are possible"));
    }
    Ok(())
}

fn check_contact(contact: &Contact) -> Result<(), String> {
    if contact.polygon_len as usize > POLYGON_VERTICES_MAX {
        return Err(format!(
            "a support polygon of {} vertices, at most {POLYGON_VERTICES_MAX} are possible",
            contact.polygon_len
        ));
    }
    check_numbers(contact.position.iter().chain(contact.polygon.as_flattened()), "contact")?;
    check_unit(contact.rotation, "contact")
}

fn check_waypoint(waypoint: &Waypoint) -> Result<(), String> {
    let numbers = waypoint.root_position.iter().chain(&waypoint.q).chain([&waypoint.time]);
    check_numbers(numbers, "waypoint")?;
    let rates: Vec<f64> = waypoint.rates().collect();
    check_numbers(rates.iter(), "waypoint")?;
    check_unit(waypoint.root_rotation, "waypoint")
}

fn check_numbers<'a>(mut numbers: impl Iterator<Item = &'a f64>, what: &str) -> Result<(), String> {
    numbers.try_for_each(|number| {
        if number.abs() <= NUMBER_MAX {
            Ok(())
        } else {
            Err(format!("a {what} with a number of {number}"))
        }
    })
}

fn check_unit(quaternion: [f64; 4], what: &str) -> Result<(), String> {
    let length = glam::DQuat::from_array(quaternion).length();
    let unit = (length - 1.0).abs() <= UNIT_ERROR_MAX;
    if unit { Ok(()) } else { Err(format!("a {what} with a quaternion of length {length}")) }
}
