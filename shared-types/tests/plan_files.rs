//! Plan files: a saved plan loads unchanged, an invalid one is refused.

#![allow(clippy::unwrap_used, reason = "helpers of tests, not input handling")]

mod common;

use std::path::Path;

use bytemuck::Zeroable;
use common::{Folder, ROBOT, URDF, check_no_panic};
use serde_json::{Value, json};
use surefoot_shared_types::InputError;
use surefoot_shared_types::message::{Contact, Interpolation, PlanChunk, SupportMode, Waypoint};
use surefoot_shared_types::plan_file::origin::changed_files;
use surefoot_shared_types::plan_file::ramps::fitting_chunks;
use surefoot_shared_types::plan_file::read::{joint_order, load_plan};
use surefoot_shared_types::plan_file::write::{on_ground, plan_from_chunks, save};
use surefoot_shared_types::plan_format::blocks::{EndBlock, PlanFile, PoseBlock, RobotBlock};
use surefoot_shared_types::robot::load::{load_robot, robot_from_block};
use surefoot_shared_types::scenario::load::load_scenario;
use surefoot_shared_types::world::load::{load_world, world_from_block};

fn contact(limb: u32, x: f64) -> Contact {
    Contact { limb, position: [x, 0.1, 0.0], rotation: [0.0, 0.0, 0.0, 1.0], ..Contact::zeroed() }
}

fn chunk(
    mode: SupportMode,
    contacts: &[Contact],
    times: std::ops::RangeInclusive<u32>,
) -> PlanChunk {
    let mut chunk = PlanChunk {
        mode: mode as u32,
        contacts_len: contacts.len() as u32,
        joints_len: 2,
        ..PlanChunk::zeroed()
    };
    chunk.contacts[..contacts.len()].copy_from_slice(contacts);
    for (waypoint, time) in chunk.waypoints.iter_mut().zip(times.clone()) {
        let time = f64::from(time);
        *waypoint = Waypoint {
            time,
            root_position: [0.1 * time, 0.0, 1.0 / 3.0],
            root_rotation: [0.0, 0.0, 0.0, 1.0],
            ..Waypoint::zeroed()
        };
        waypoint.q[..2].copy_from_slice(&[0.1 * time, 0.7]);
    }
    chunk.waypoints_len = times.count() as u32;
    chunk
}

/// Double support in two chunks, a step with the right foot, and an instant of double support.
fn chunks() -> Vec<PlanChunk> {
    let both = [contact(0, 0.0), contact(1, 0.0)];
    vec![
        chunk(SupportMode::Double, &both, 0..=3),
        chunk(SupportMode::Double, &both, 3..=5),
        chunk(SupportMode::Left, &both[..1], 5..=8),
        chunk(SupportMode::Double, &[both[0], contact(1, 0.4)], 8..=8),
        chunk(SupportMode::Right, &[contact(1, 0.4)], 8..=9),
    ]
}

fn plan(folder: &Folder) -> PlanFile {
    let robot = load_robot(&folder.path("robot.toml")).unwrap();
    let world = load_world(&folder.path("world.toml")).unwrap();
    let scenario = load_scenario(&folder.path("scenario.toml")).unwrap();
    let plans = folder.path("plans");
    std::fs::create_dir_all(&plans).unwrap();
    plan_from_chunks(&robot, &world, &scenario, &chunks(), &plans)
}

#[test]
fn chunks_become_waypoints_and_consecutive_phases() {
    let plan = plan(&Folder::new());
    assert_eq!(
        plan.waypoints.iter().map(|waypoint| waypoint.t).collect::<Vec<_>>(),
        (0..10).map(f64::from).collect::<Vec<_>>()
    );
    let phases: Vec<_> =
        plan.phases.iter().map(|phase| (phase.mode.as_str(), phase.first, phase.last)).collect();
    assert_eq!(phases, [("double", 0, 5), ("left", 5, 8), ("double", 8, 8), ("right", 8, 9)]);
    assert_eq!(plan.robot.urdf, "../stilts.urdf");
    assert_eq!(plan.joint_names, ["left_hip", "right_hip"]);
    let EndBlock::Feet { soles, tol } = &plan.start else { panic!("{:?}", plan.start) };
    assert_eq!((soles["left"].xyz, *tol), ([0.0, 0.1, 0.0], 2e-3));
    // Its soles are turned by 1.5 rad from the goal, which allows for 0.35 rad, as half the metres.
    assert!(matches!(&plan.goal, EndBlock::Feet { tol, .. } if (*tol - 0.175).abs() < 2e-6));
}

/// The chunks with velocities.
fn smooth_chunks() -> Vec<PlanChunk> {
    let mut chunks = chunks();
    for chunk in &mut chunks {
        chunk.interpolation = Interpolation::Quintic as u64;
        let last = chunk.waypoints_len as usize - 1;
        (chunk.brake_at, chunk.brake_duration) = (chunk.waypoints[last].time - 0.2, 0.4);
        for waypoint in &mut chunk.waypoints[..=last] {
            waypoint.root_velocity = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6];
            waypoint.root_acceleration = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
            waypoint.joint_velocity[1] = 0.7;
            waypoint.joint_acceleration[1] = 0.8;
            waypoint.torque[0] = 9.0;
            (waypoint.rest_torque[1], waypoint.rate_change_torque[0]) = (8.0, 7.0);
        }
    }
    chunks
}

fn smooth_plan(folder: &Folder) -> PlanFile {
    let robot = load_robot(&folder.path("robot.toml")).unwrap();
    let world = load_world(&folder.path("world.toml")).unwrap();
    let scenario = load_scenario(&folder.path("scenario.toml")).unwrap();
    plan_from_chunks(&robot, &world, &scenario, &smooth_chunks(), &folder.path("."))
}

#[test]
fn a_smooth_plan_states_velocity_acceleration_torque_and_where_it_may_stop() {
    let folder = Folder::new();
    let plan = smooth_plan(&folder);
    let waypoint = &plan.waypoints[4];
    assert_eq!(waypoint.velocity, [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.0, 0.7]);
    assert_eq!(waypoint.acceleration, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 0.0, 0.8]);
    assert_eq!(waypoint.torque, [9.0, 0.0]);
    assert_eq!(
        (&waypoint.rest_torque[..], &waypoint.rate_change_torque[..]),
        (&[0.0, 8.0][..], &[7.0, 0.0][..])
    );
    let chunks = fitting_chunks(&plan).unwrap();
    assert_eq!((chunks.len(), chunks[1].first, chunks[1].last), (5, 3, 5));
    assert_eq!((chunks[1].brake_at, chunks[1].brake_duration), (4.8, 0.4));
    let path = folder.path("plan.json");
    save(&plan, &path).unwrap();
    assert_eq!(load_plan(&path).unwrap(), plan);
}

#[test]
fn chunks_that_an_edit_left_behind_are_named_and_the_plan_is_still_read() {
    let folder = Folder::new();
    let plan = smooth_plan(&folder);
    let edits: [fn(&mut PlanFile); 7] = [
        |plan| plan.waypoints.iter_mut().for_each(|waypoint| waypoint.t *= 0.4),
        |plan| plan.chunks[2].first += 1,
        |plan| plan.chunks.truncate(3),
        |plan| plan.chunks[1].brake_duration = -0.1,
        |plan| plan.chunks[1].resume_duration = 20.1,
        |plan| {
            let (rest, before) =
                (plan.waypoints[plan.chunks[2].last].t, plan.chunks[1].brake_at - 0.1);
            plan.chunks[2].brake_at = before;
            plan.chunks[2].brake_duration = 2.0 * (rest - before);
        },
        |plan| {
            plan.chunks.remove(1);
            plan.chunks[1].first = 3;
        },
    ];
    for (index, edit) in edits.iter().enumerate() {
        let mut edited = plan.clone();
        edit(&mut edited);
        assert!(fitting_chunks(&edited).is_err(), "edit {index}");
        let path = folder.path("plan.json");
        save(&edited, &path).unwrap();
        load_plan(&path).unwrap();
    }
}

#[test]
fn rates_of_one_waypoint_alone_are_refused() {
    let folder = Folder::new();
    let edits: [fn(&mut PlanFile); 7] = [
        |plan| plan.waypoints[3].velocity.clear(),
        |plan| plan.waypoints[3].torque.clear(),
        |plan| plan.waypoints.iter_mut().for_each(|waypoint| waypoint.acceleration.clear()),
        |plan| plan.waypoints[2].velocity.truncate(5),
        |plan| plan.waypoints[2].torque[1] = 1e7,
        |plan| plan.waypoints[3].rest_torque.clear(),
        |plan| plan.waypoints[2].rate_change_torque.truncate(1),
    ];
    for (index, edit) in edits.iter().enumerate() {
        let mut plan = smooth_plan(&folder);
        edit(&mut plan);
        assert!(save(&plan, &folder.path("plan.json")).is_err(), "edit {index}");
    }
}

#[test]
fn a_saved_plan_loads_bit_for_bit() {
    let folder = Folder::new();
    let plan = plan(&folder);
    let path = folder.path("plans/plan.json");
    save(&plan, &path).unwrap();
    assert_eq!(load_plan(&path).unwrap(), plan);
    let left: Vec<_> = std::fs::read_dir(folder.path("plans"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    assert_eq!(left, ["plan.json"]);
}

#[test]
fn a_plan_with_a_byte_order_mark_is_read_and_a_cut_one_is_called_cut() {
    let folder = Folder::new();
    let plan = plan(&folder);
    let path = folder.path("plan.json");
    save(&plan, &path).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    folder.write("plan.json", format!("\u{feff}{text}").as_bytes());
    assert_eq!(load_plan(&path).unwrap(), plan);
    folder.write("plan.json", &text.as_bytes()[..text.len() / 2]);
    let error = load_plan(&path).unwrap_err().to_string();
    assert!(error.contains("as if it were cut"), "{error}");
}

#[test]
fn a_plan_holds_its_robot_and_world() {
    let folder = Folder::new();
    let plan = plan(&folder);
    let (plans, path) = (folder.path("plans"), folder.path("plans/plan.json"));
    let robot = robot_from_block(&plan.robot, &plans, &path).unwrap();
    let original = load_robot(&folder.path("robot.toml")).unwrap();
    assert_eq!(
        (&robot.links, &robot.joints, &robot.feet),
        (&original.links, &original.joints, &original.feet)
    );
    assert_eq!(robot.standing_q, original.standing_q);
    assert_eq!(robot.robot_path, original.robot_path);
    let world = world_from_block(&plan.scene, &plans, &path).unwrap();
    assert_eq!(world.shapes, load_world(&folder.path("world.toml")).unwrap().shapes);
    assert_eq!(joint_order(&plan, &robot, &path).unwrap(), [0, 1]);
}

#[test]
fn files_that_changed_since_the_plan_are_named() {
    let folder = Folder::new();
    let plan = plan(&folder);
    let files = &plan.origin.as_ref().unwrap().files;
    let names: Vec<&str> = files.keys().map(String::as_str).collect();
    assert_eq!(names, ["../meshes/foot.obj", "../stilts.urdf"]);
    let path = folder.path("plans/plan.json");
    assert_eq!(changed_files(&plan, &path), [""; 0]);
    folder.write("stilts.urdf", format!("{URDF}<!-- later -->").as_bytes());
    let changed = changed_files(&plan, &path);
    assert_eq!(changed, ["../stilts.urdf: its content is not what the plan was made from"]);
}

#[test]
fn a_level_end_is_moved_onto_the_ground_that_a_contact_shows() {
    let pose = |xyz: [f64; 3], tilt: f64| PoseBlock {
        xyz,
        quat_xyzw: [0.0, libm::sin(0.5 * tilt), 0.0, libm::cos(0.5 * tilt)],
    };
    let level = pose([1.2, 0.3, 0.5], 0.0);
    let moved = on_ground(&level, &pose([1.0, 0.0, 0.58], 0.2));
    let height = 0.58 - 0.2 * libm::tan(0.2);
    assert!((moved.xyz[2] - height).abs() < 1e-12, "{moved:?}");
    assert!((moved.quat_xyzw[1] - libm::sin(0.1)).abs() < 1e-12, "{moved:?}");
    assert_eq!(moved.xyz[..2], level.xyz[..2]);
    for other in [0.5, 0.61, 0.39] {
        assert_eq!(on_ground(&level, &pose([1.2, 0.3, other], 0.0)), level, "{other}");
    }
    assert_eq!(on_ground(&level, &pose([1.2, 0.3, 0.59], 0.0)).xyz[2], 0.59);
}

#[test]
fn a_configuration_at_an_end_is_met_to_a_thousandth_unless_stated() {
    let block = json!({
        "type": "config", "root_xyz": [0, 0, 1], "root_quat_xyzw": [0, 0, 0, 1], "q": [0.1]
    });
    let EndBlock::Config { tol, .. } = serde_json::from_value(block).unwrap() else {
        panic!("not a configuration")
    };
    assert_eq!(tol, 1e-3);
}

#[test]
fn how_the_robot_stands_is_read_in_the_robot_file_of_its_urdf_alone() {
    let folder = Folder::new();
    let block = plan(&folder).robot;
    folder.write("other.urdf", URDF.as_bytes());
    folder.write("other.toml", ROBOT.replace("stilts.urdf", "other.urdf").as_bytes());
    let plans = folder.path("plans");
    let standing = |robot_file: Option<&str>| {
        let block = RobotBlock { robot_file: robot_file.map(str::to_owned), ..block.clone() };
        let robot = robot_from_block(&block, &plans, &plans.join("plan.json")).unwrap();
        (robot.robot_path.is_some(), robot.standing_q)
    };
    assert_eq!(standing(Some("../robot.toml")), (true, vec![0.3, 0.2]));
    for other in [None, Some("../gone.toml"), Some("../other.toml")] {
        assert_eq!(standing(other), (false, vec![0.0, 0.2]), "{other:?}");
    }
}

#[test]
fn a_plan_names_the_links_with_exact_meshes() {
    let folder = Folder::new();
    assert!(plan(&folder).robot.exact_meshes.is_empty());
    folder.write("robot.toml", format!("exact_meshes = [\"right_foot\"]\n{ROBOT}").as_bytes());
    let (plans, path) = (folder.path("plans"), folder.path("plans/plan.json"));
    let robot = robot_from_block(&plan(&folder).robot, &plans, &path).unwrap();
    assert_eq!(robot.links, load_robot(&folder.path("robot.toml")).unwrap().links);
}

#[test]
fn joint_names_may_have_any_order_but_must_be_the_robots() {
    let folder = Folder::new();
    let robot = load_robot(&folder.path("robot.toml")).unwrap();
    let mut plan = plan(&folder);
    let path = folder.path("plan.json");
    for (names, expected) in [
        (vec!["right_hip", "left_hip"], Ok(vec![1, 0])),
        (vec!["left_hip"], Err("lacks 'right_hip'")),
        (vec!["left_hip", "tail"], Err("'tail'")),
        (vec!["left_hip", "right_hip", "left_hip"], Err("twice")),
    ] {
        plan.joint_names = names.into_iter().map(str::to_owned).collect();
        match (joint_order(&plan, &robot, &path), expected) {
            (Ok(order), Ok(expected)) => assert_eq!(order, expected),
            (Err(error), Err(expected)) => assert!(error.to_string().contains(expected), "{error}"),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn an_impossible_plan_or_path_is_not_saved() {
    let folder = Folder::new();
    let mut plan = plan(&folder);
    assert!(
        save(&plan, &folder.path("gone/plan.json"))
            .unwrap_err()
            .to_string()
            .contains("cannot be written")
    );
    plan.waypoints[4].q[1] = f64::NAN;
    let path = folder.path("plan.json");
    assert!(save(&plan, &path).unwrap_err().to_string().contains("waypoint 4"));
    assert!(!path.exists());
}

/// Loads the valid plan with the value at a JSON pointer replaced. `Null` is written as null.
fn load_with(pointer: &str, value: Value) -> Result<PlanFile, InputError> {
    let folder = Folder::new();
    let mut json = serde_json::to_value(plan(&folder)).unwrap();
    *json.pointer_mut(pointer).unwrap_or_else(|| panic!("no {pointer}")) = value;
    folder.write("plan.json", json.to_string().as_bytes());
    load_plan(&folder.path("plan.json"))
}

#[test]
fn a_plan_may_weaken_the_motors_of_its_robot_but_not_strengthen_them() {
    let folder = Folder::new();
    let mut json = serde_json::to_value(plan(&folder)).unwrap();
    let mut scaled = |scale: f64| {
        json["robot"]["effort_scale"] = json!(scale);
        folder.write("plan.json", json.to_string().as_bytes());
        load_plan(&folder.path("plan.json")).map(|plan| plan.robot.effort_scale)
    };
    assert_eq!([scaled(0.5).unwrap(), scaled(1.0).unwrap()], [Some(0.5), Some(1.0)]);
    for scale in [1.0001, 1.5, 0.0, -1.0] {
        let refused = scaled(scale).unwrap_err().to_string();
        assert!(refused.contains(&format!("effort_scale is {scale}; it must be")), "{refused}");
    }
}

#[test]
fn a_mistyped_key_is_refused_and_one_of_another_program_is_not() {
    let folder = Folder::new();
    let written = serde_json::to_value(plan(&folder)).unwrap();
    let renamed = |pointer: &str, from: &str, to: &str| {
        let mut json = written.clone();
        let object = json.pointer_mut(pointer).unwrap().as_object_mut().unwrap();
        let value = object.remove(from).unwrap_or_else(|| json!(1));
        object.insert(to.to_owned(), value);
        folder.write("plan.json", json.to_string().as_bytes());
        load_plan(&folder.path("plan.json")).map(drop).map_err(|error| error.to_string())
    };
    for (pointer, from, to) in [
        ("/robot", "effort_limits", "effort_limit"),
        ("/robot", "effort_limits", "effortLimits"),
        ("/robot", "locked_joints", "locked_joint"),
        ("/robot", "robot_file", "robotfile"),
        ("", "origin", "Origin"),
    ] {
        let refused = renamed(pointer, from, to).unwrap_err();
        let expected = format!("the key '{to}' is unknown; is '{from}' meant?");
        assert!(refused.contains(&expected), "{refused}");
    }
    assert_eq!(renamed("", "none", "author"), Ok(()));
    assert_eq!(renamed("/robot", "none", "colour"), Ok(()));
}

#[test]
fn invalid_plans_are_refused() {
    for (pointer, value, complaint) in [
        ("/schema", json!("biped-plan/2"), "only 'biped-plan/1'"),
        ("/scene/mu", json!(1e7), "scene: mu"),
        ("/joint_names", json!(["left_hip", "left_hip"]), "joint_names: names 'left_hip' twice"),
        ("/robot/feet", json!({}), "robot: its feet"),
        ("/robot/effort_limits/left_hip", json!(-1), "effort_limits 'left_hip'"),
        ("/robot/feet/left/sole_pose/quat_xyzw", json!([0, 0, 0, 2]), "foot 'left': quaternion"),
        ("/waypoints/3/t", json!(2.0), "waypoint 3: t is 2"),
        ("/waypoints/3/t", Value::Null, "plan.json:1"),
        ("/waypoints/3/q", json!([0.0]), "waypoint 3: q has 1"),
        ("/waypoints/3/q", json!([0.0, 1e300]), "waypoint 3: q"),
        ("/waypoints/3/root_xyz", json!([0, 0, 2e6]), "waypoint 3: position"),
        ("/waypoints/3/root_quat_xyzw", json!([0, 0, 0, 1.001]), "waypoint 3: quaternion"),
        ("/waypoints", json!([]), "phase 0: covers"),
        ("/phases", json!([]), "at least one phase"),
        ("/phases/0/first", json!(1), "phase 0: begins at waypoint 1"),
        ("/phases/1/first", json!(6), "phase 1: begins at waypoint 6 instead of 5"),
        ("/phases/1/last", json!(4), "phase 1: covers"),
        ("/phases/3/last", json!(8), "phase 3: ends at waypoint 8"),
        ("/phases/3/last", json!(10), "phase 3: covers"),
        ("/phases/3/last", json!(u64::MAX), "phase 3: covers"),
        ("/phases/1/mode", json!("hop"), "phase 1: has the unknown mode 'hop'"),
        ("/phases/1/mode", json!("double"), "phase 1: has contacts [\"left\"]"),
        ("/phases/1/contacts/0/foot", json!("tail"), "phase 1: has contacts [\"tail\"]"),
        (
            "/phases/1/contacts/0/sole_pose/quat_xyzw",
            json!([0, 0, 0, 0]),
            "phase 1: contact 'left': quaternion",
        ),
        ("/start/tol", json!(0), "start: tol"),
        ("/goal/soles", json!({"left": {"xyz": [0, 0, 0]}}), "goal: its feet"),
        ("/goal/type", json!("dance"), "dance"),
    ] {
        let error = load_with(pointer, value.clone())
            .err()
            .unwrap_or_else(|| panic!("{pointer} = {value} was accepted"))
            .to_string();
        assert!(error.contains(complaint), "{pointer} = {value}: {error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
}

#[test]
fn damaged_plans_cause_no_panic() {
    let folder = Folder::new();
    let text = serde_json::to_string(&plan(&folder)).unwrap();
    check_no_panic("plan.json", text.as_bytes(), |folder: &Path| {
        load_plan(&folder.join("plan.json"))
    });
    folder.write("deep.json", "[".repeat(1_000_000).as_bytes());
    assert!(load_plan(&folder.path("deep.json")).is_err());
}
