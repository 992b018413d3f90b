//! The chunk stream of a plan: the guarantees to its receiver, recomputed from the chunks alone.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use common::{Case, WALKS, run};
use glam::{DQuat, DVec2};
use surefoot_planner::geometry::convex_region::ConvexRegion;
use surefoot_planner::robot::configuration::Configuration;
use surefoot_planner::robot::kinematic_state::KinematicState;
use surefoot_planner::robot::mechanism::Mechanism;
use surefoot_planner::{Outcome, Planner};
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::base::spatial::rotation_distance;
use surefoot_shared_types::message::chunk::{CHUNK_SCHEMA, FLAG_FIRST, FLAG_LAST};
use surefoot_shared_types::message::{Contact, PlanChunk, SupportMode, Waypoint};

/// Largest distance of a stance sole from its contact, m and rad.
const CONTACT_TOLERANCE: f64 = 1e-6;
/// Largest share of a small support polygon's depth that `com_margin` takes up, as documented
/// there.
const MARGIN_SHARE_MAX: f64 = 0.6;

fn for_each_walk(check: impl Fn(&Case, &Planner)) {
    for walk in WALKS {
        let case = Case::shipped(walk);
        let mut planner = case.planner(2);
        assert_eq!(run(&mut planner, 20_000), Outcome::Found, "{walk}");
        check(&case, &planner);
    }
}

fn mode_of(chunk: &PlanChunk) -> SupportMode {
    SupportMode::from_wire(chunk.mode).unwrap()
}

fn stands(mode: SupportMode) -> &'static [u32] {
    match mode {
        SupportMode::Left => &[0],
        SupportMode::Right => &[1],
        SupportMode::Double => &[0, 1],
    }
}

fn configuration_of(waypoint: &Waypoint) -> Configuration {
    Configuration { world_from_root: waypoint.world_from_root(), q: waypoint.q }
}

#[test]
fn headers_identify_robot_world_and_scenario() {
    for_each_walk(|case, planner| {
        for (index, chunk) in planner.chunks().iter().enumerate() {
            let is_last = index + 1 == planner.chunks().len();
            let flags =
                if index == 0 { FLAG_FIRST } else { 0 } | if is_last { FLAG_LAST } else { 0 };
            assert_eq!(
                (chunk.schema, chunk.sequence, chunk.flags),
                (CHUNK_SCHEMA, index as u64, flags)
            );
            assert_eq!(
                (chunk.robot, chunk.world, chunk.config),
                (case.model.digest, case.world.digest, case.scenario.digest)
            );
            assert_eq!(chunk.joints_len as usize, case.model.joints.len());
            assert!((2..=chunk.waypoints.len()).contains(&(chunk.waypoints_len as usize)));
        }
    });
}

#[test]
fn the_digest_is_the_hash_chain_of_the_chunks() {
    for_each_walk(|_, planner| {
        let mut stream = Digest::default();
        for chunk in planner.chunks() {
            assert_eq!(chunk.stream, stream);
            stream = chunk.stream_after();
        }
        assert_eq!(planner.digest(), stream);
    });
}

#[test]
fn each_chunk_begins_at_the_end_of_the_one_before() {
    for_each_walk(|_, planner| {
        assert_eq!(planner.chunks()[0].waypoints()[0].time, 0.0);
        for pair in planner.chunks().windows(2) {
            assert_eq!(
                pair[0].waypoints().last(),
                pair[1].waypoints().first(),
                "chunk {}",
                pair[1].sequence
            );
        }
        let count = 1 + planner
            .chunks()
            .iter()
            .map(|chunk| chunk.waypoints().len() as u64 - 1)
            .sum::<u64>();
        assert_eq!(planner.waypoints(), count);
    });
}

#[test]
fn the_walk_begins_and_ends_at_its_stance_poses() {
    for_each_walk(|case, planner| {
        let (first, last) = (&planner.chunks()[0], planner.chunks().last().unwrap());
        for (chunk, stance) in [(first, case.scenario.start), (last, case.scenario.goal)] {
            assert_eq!(mode_of(chunk), SupportMode::Double);
            for (contact, world_from_sole) in chunk.contacts().iter().zip(stance.world_from_soles())
            {
                let sole = contact.world_from_sole();
                assert!(sole.translation.distance(world_from_sole.translation) < CONTACT_TOLERANCE);
                assert!(
                    rotation_distance(sole.rotation, world_from_sole.rotation) < CONTACT_TOLERANCE
                );
            }
        }
    });
}

/// The contacts of a chunk by limb.
fn contact(chunk: &PlanChunk, limb: u32) -> Option<&Contact> {
    chunk.contacts().iter().find(|contact| contact.limb == limb)
}

#[test]
fn a_foot_is_lifted_and_set_down_before_the_other() {
    for_each_walk(|_, planner| {
        for pair in planner.chunks().windows(2) {
            let modes = [mode_of(&pair[0]), mode_of(&pair[1])];
            let is_allowed = modes[0] == modes[1] || modes.contains(&SupportMode::Double);
            assert!(is_allowed, "chunk {}: {modes:?}", pair[1].sequence);
            for limb in [0, 1] {
                if let (Some(before), Some(after)) =
                    (contact(&pair[0], limb), contact(&pair[1], limb))
                {
                    assert_eq!(
                        before, after,
                        "chunk {}: foot {limb} moves while it stands",
                        pair[1].sequence
                    );
                }
            }
        }
    });
}

#[test]
fn steps_are_counted_as_the_contacts_change() {
    for_each_walk(|case, planner| {
        let mut places = [None; 2];
        let mut moved = 0;
        for placed in planner.chunks().iter().flat_map(PlanChunk::contacts) {
            let place = &mut places[placed.limb as usize];
            moved += u64::from(place.is_some_and(|known| known != *placed));
            *place = Some(*placed);
        }
        assert!(
            moved > 0 && moved <= planner.steps(),
            "{}: {moved}, {} reported",
            case.scenario.name,
            planner.steps()
        );
    });
}

#[test]
fn contacts_match_the_mode() {
    for_each_walk(|case, planner| {
        for chunk in planner.chunks() {
            let limbs: Vec<u32> = chunk.contacts().iter().map(|contact| contact.limb).collect();
            assert_eq!(limbs, stands(mode_of(chunk)));
            for contact in chunk.contacts() {
                assert!((DQuat::from_array(contact.rotation).length() - 1.0).abs() < 1e-9);
                let polygon = &contact.polygon[..contact.polygon_len as usize];
                assert!(polygon.len() >= 3);
                let outline = ConvexRegion::hull(
                    case.model.feet[contact.limb as usize].polygon.iter().copied(),
                );
                assert!(
                    polygon.iter().all(|&corner| outline.margin(corner.into()) > -1e-6),
                    "support beyond the sole"
                );
            }
        }
    });
}

#[test]
fn times_increase_and_rotations_are_unit() {
    for_each_walk(|_, planner| {
        for chunk in planner.chunks() {
            assert!(
                chunk.waypoints().windows(2).all(|pair| pair[0].time < pair[1].time),
                "chunk {}",
                chunk.sequence
            );
            let is_unit = |waypoint: &Waypoint| {
                (DQuat::from_array(waypoint.root_rotation).length() - 1.0).abs() < 1e-9
            };
            assert!(chunk.waypoints().iter().all(is_unit), "chunk {}", chunk.sequence);
        }
    });
}

#[test]
fn joint_margins_steps_and_speeds_are_within_their_limits() {
    for_each_walk(|case, planner| {
        let config = &case.scenario.planner;
        for chunk in planner.chunks() {
            for waypoint in chunk.waypoints() {
                for (joint, position) in case.model.joints.iter().zip(waypoint.q) {
                    let margin = config.joint_margin - 1e-12;
                    assert!(
                        (joint.lower + margin..=joint.upper - margin).contains(&position),
                        "{}: {position}",
                        joint.name
                    );
                }
                assert!(waypoint.q[case.model.joints.len()..].iter().all(|&unused| unused == 0.0));
            }
            for pair in chunk.waypoints().windows(2) {
                for (index, joint) in case.model.joints.iter().enumerate() {
                    let step = (pair[1].q[index] - pair[0].q[index]).abs();
                    assert!(
                        step <= config.waypoint_joint_step + 1e-12,
                        "{} moves {step}",
                        joint.name
                    );
                    assert!(
                        step / (pair[1].time - pair[0].time) <= joint.velocity,
                        "{} races",
                        joint.name
                    );
                }
            }
        }
    });
}

#[test]
fn joint_accelerations_are_within_their_limits() {
    for_each_walk(|case, planner| {
        for chunk in planner.chunks() {
            for (index, joint) in case.model.joints.iter().enumerate() {
                let (mut speed_before, mut seconds_before) = (0.0, 0.0);
                let interval = |pair: &[Waypoint]| {
                    (pair[1].time - pair[0].time, pair[1].q[index] - pair[0].q[index])
                };
                let intervals = chunk
                    .waypoints()
                    .windows(2)
                    .map(interval)
                    .map(|(seconds, way)| (seconds, way / seconds));
                for (seconds, speed) in intervals.chain([(0.0, 0.0)]) {
                    let acceleration =
                        f64::abs(speed - speed_before) / (0.5 * (seconds + seconds_before));
                    assert!(
                        acceleration < joint.acceleration(),
                        "chunk {}: {} by {acceleration}",
                        chunk.sequence,
                        joint.name
                    );
                    (speed_before, seconds_before) = (speed, seconds);
                }
            }
        }
    });
}

#[test]
fn stance_soles_are_fixed_and_the_centre_of_mass_is_above_them() {
    for_each_walk(|case, planner| {
        let robot = Mechanism::new(&case.model, &case.scenario.planner).unwrap();
        for chunk in planner.chunks() {
            let corners = chunk.contacts().iter().flat_map(|contact| {
                let sole = contact.world_from_sole();
                let polygon = &contact.polygon[..contact.polygon_len as usize];
                polygon
                    .iter()
                    .map(move |corner| (sole * DVec2::from(*corner).extend(0.0)).truncate())
            });
            let region = ConvexRegion::hull(corners);
            let depth = region.margin(region.centroid());
            let margin_min = case.scenario.planner.com_margin.min(MARGIN_SHARE_MAX * depth) - 1e-9;
            for waypoint in chunk.waypoints() {
                let kinematic_state = KinematicState::new(&robot, &configuration_of(waypoint));
                let margin = region.margin(kinematic_state.com.truncate());
                assert!(
                    margin >= margin_min,
                    "chunk {}: margin {margin}, depth {depth}",
                    chunk.sequence
                );
                for contact in chunk.contacts() {
                    let (is, wanted) = (
                        kinematic_state.world_from_sole(&robot, contact.limb as usize),
                        contact.world_from_sole(),
                    );
                    assert!(
                        is.translation.distance(wanted.translation) < CONTACT_TOLERANCE,
                        "chunk {}",
                        chunk.sequence
                    );
                    assert!(
                        rotation_distance(is.rotation, wanted.rotation) < CONTACT_TOLERANCE,
                        "chunk {}",
                        chunk.sequence
                    );
                }
            }
        }
    });
}
