//! Soles of a motion over the ground, in it, and at different heights.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

mod check_robot;
mod checked_motion;
mod smooth_swing;

use check_robot::*;
use checked_motion::{check_motion, refused};
use glam::DVec3;
use smooth_swing::{check, check_with, smooth_swing};
use surefoot_controller_sim::{Checker, ChunkExecutor, Identity, Problem, check_plan_in};
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::base::spatial::rotation_about;
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::chunk::{CHUNK_SCHEMA, FLAG_FIRST, FLAG_LAST};
use surefoot_shared_types::message::{
    Check, Contact, Interpolation, PlanChunk, SupportMode, Waypoint, WithCrc,
};
use surefoot_shared_types::plan_file::write::plan_without_origin;
use surefoot_shared_types::plan_format::blocks::EndBlock;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::World;

/// Two floors, the left one lower by half of `apart` (m) and the right one higher.
fn split_ground(apart: f64) -> World {
    let floor = |name, side: f64| {
        (name, at(0.0, 0.5 * side, -0.5 * side * apart - 0.1), box_of(1.0, 0.5, 0.1))
    };
    let mut ground = world(vec![floor("left", 1.0), floor("right", -1.0)]);
    ground.shapes.remove(0);
    ground
}

/// The same motion with the root `higher` (m) and rolled by an angle (rad).
fn moved(mut motion: Vec<Waypoint>, higher: f64, roll: f64) -> Vec<Waypoint> {
    for waypoint in &mut motion {
        waypoint.root_position[2] += higher;
        waypoint.root_rotation = rotation_about(DVec3::X, roll).to_array();
        // The soles stay where they are along y.
        waypoint.root_position[1] -= 0.9 * roll;
    }
    motion
}

#[test]
fn soles_that_move_off_the_ground_or_to_other_heights_are_refused() {
    let swing = || smooth_swing(0.1, 1.0, 6);
    let higher = |by: f64| check(&moved(swing(), by, 0.0), &[]);
    for by in [9e-4, -9e-4] {
        higher(by).unwrap();
    }
    refused(higher(1.1e-3), Check::Contact, "1.10 mm over the ground");
    refused(higher(-1.1e-3), Check::Contact, "1.10 mm in the ground");
    // A roll of 3 mrad raises the left sole by 0.6 mm against the right one.
    let on = |apart: f64, roll: f64| {
        check_with(robot(), split_ground(apart), &moved(swing(), 0.0, roll), &[])
    };
    on(0.0, 3e-3).unwrap();
    on(4e-4, -3e-3).unwrap();
    on(1e-4, 3e-3).unwrap();
    refused(on(3e-4, 3e-3), Check::Contact, "0.90 mm deeper in the ground");
    let straight = |apart: f64| {
        check_motion(
            robot(),
            split_ground(apart),
            &both_feet(),
            &[waypoint(0.0, 0.0, 0.0), waypoint(1.0, 0.0, 0.0)],
        )
    };
    straight(1.9e-3).unwrap();
    refused(straight(2.1e-3), Check::Contact, "2.10 mm deeper in the ground");
}

#[test]
fn a_foot_that_lands_early_is_refused() {
    let landing = |apart: f64, roll: f64| {
        let config = CheckerConfig::default();
        let mut checker = Checker::new(robot(), split_ground(apart), config).unwrap();
        checker.check_landing(&both_feet(), &moved(vec![waypoint(0.0, 0.0, 0.0)], 0.0, roll)[0])
    };
    landing(0.0, 2.4e-3).unwrap();
    landing(0.0, -2.4e-3).unwrap();
    landing(4e-4, -3e-3).unwrap();
    for (apart, roll, millimetres) in [(0.0, 2.6e-3, "0.52 mm deeper"), (1e-4, 2.4e-3, "0.58 mm")] {
        let violation = landing(apart, roll).unwrap_err();
        assert_eq!((violation.check, violation.waypoint), (Check::Contact, 0));
        assert!(violation.detail.contains(millimetres), "{violation}");
    }
}

#[test]
fn of_straight_lines_the_soles_count_as_they_move() {
    // Grounds 2.4 mm apart, of which the roll of the robot makes up 0.6 mm; the other way round
    // the soles are farther apart.
    let motion = || vec![waypoint(0.0, 0.0, 0.0), waypoint(1.0, 0.0, 0.0)];
    let on = |ground: World, higher: f64, roll: f64| {
        check_motion(robot(), ground, &both_feet(), &moved(motion(), higher, roll))
    };
    on(split_ground(2.4e-3), 0.0, -3e-3).unwrap();
    refused(on(split_ground(2.4e-3), 0.0, 0.0), Check::Contact, "2.40 mm deeper in the ground");
    // Nothing but the gap bounds how far both are over the ground.
    let lower = || {
        let mut ground = split_ground(0.0);
        ground.shapes.iter_mut().for_each(|shape| shape.world_from_shape.translation.z -= 1.4e-3);
        ground
    };
    on(lower(), 1.4e-3, 0.0).unwrap();
    refused(on(lower(), 1.7e-3, 0.0), Check::Contact, "may be 3.10 mm off the ground");
}

#[test]
fn where_a_foot_lands_soles_are_as_high_as_in_the_motion() {
    let landing = |higher: f64| {
        let mut checker = Checker::new(robot(), world(vec![]), CheckerConfig::default()).unwrap();
        let at = moved(vec![waypoint(0.0, 0.0, 0.0)], higher, 0.0)[0];
        checker.check_landing(&both_feet(), &at)
    };
    for higher in [-9e-4, 9e-4] {
        landing(higher).unwrap();
    }
    for (higher, words) in [(-1.1e-3, "1.10 mm in the ground"), (1.1e-3, "1.10 mm over")] {
        let violation = landing(higher).unwrap_err();
        assert!(violation.detail.contains(words), "{violation}");
    }
}

const IDENTITY: Identity = Identity {
    controller_id: 7,
    robot: Digest([1; 32]),
    world: Digest([2; 32]),
    config: Digest([3; 32]),
};

/// The robot stands still for a second in this mode, rolled by an angle (rad).
fn still(before: Option<&PlanChunk>, mode: SupportMode, roll: f64) -> Box<PlanChunk> {
    let contacts: &[Contact] = if mode == SupportMode::Left { &[contact(0)] } else { &both_feet() };
    let begin = before.map_or(0.0, |_| 1.0);
    let motion = vec![waypoint(begin, 0.0, 0.0), waypoint(begin + 1.0, 0.0, 0.0)];
    let mut chunk: Box<PlanChunk> = Box::new(bytemuck::Zeroable::zeroed());
    (chunk.schema, chunk.target_controller, chunk.mode) = (CHUNK_SCHEMA, 7, mode as u32);
    chunk.sequence = before.map_or(0, |before| before.sequence + 1);
    chunk.flags = if before.is_none() { FLAG_FIRST } else { FLAG_LAST };
    chunk.contacts_len = contacts.len() as u32;
    chunk.contacts[..contacts.len()].copy_from_slice(contacts);
    chunk.waypoints_len = 2;
    chunk.waypoints[..2].copy_from_slice(&moved(motion, 0.0, roll));
    chunk.joints_len = 4;
    chunk.interpolation = Interpolation::Quintic as u64;
    chunk.brake_at = begin + 1.0;
    (chunk.robot, chunk.world, chunk.config) = (IDENTITY.robot, IDENTITY.world, IDENTITY.config);
    chunk.stream = before.map_or(Digest::default(), PlanChunk::stream_after);
    chunk.crc = chunk.computed_crc();
    chunk
}

/// A robot whose left foot carries it.
fn leaning() -> RobotModel {
    let mut leaning = robot();
    (leaning.links[2].mass, leaning.links[0].com.y) = (0.1, 0.1);
    leaning
}

#[test]
fn where_a_foot_is_set_down_controller_and_plan_check_look_at_its_height() {
    for (roll, lands) in [(2.4e-3, true), (3e-3, false)] {
        let first = still(None, SupportMode::Left, roll);
        let chunks = [*first.clone(), *still(Some(&first), SupportMode::Double, roll)];
        let config = CheckerConfig::default();
        let checker = Checker::new(leaning(), world(vec![]), config.clone()).unwrap();
        let mut executor = ChunkExecutor::new(checker, IDENTITY);
        executor.check_and_execute(&chunks[0]).unwrap();
        let found = executor.check_and_execute(&chunks[1]);
        assert_eq!(found.is_ok(), lands, "{found:?}");
        let region = EndBlock::RootRegion {
            xy: [0.0; 2],
            radius: 1.0,
            z_range: None,
            yaw: None,
            yaw_tol: None,
        };
        let (path, ends) = (std::path::Path::new("/by_hand.json"), [region.clone(), region]);
        let folder = std::path::Path::new("/");
        let (model, ground) = (leaning(), world(vec![]));
        let plan = plan_without_origin(&model, &ground, ends.clone(), &chunks, folder);
        let problem = Problem::of_ends(model, ground, config, ends);
        let report = check_plan_in(&plan, path, &problem).unwrap();
        assert_eq!(report.is_valid(), lands, "{:?}", report.violations().collect::<Vec<_>>());
    }
}
