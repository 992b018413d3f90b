//! World and scenario files: a valid file loads as written, an invalid one gives one error line.

#![allow(clippy::unwrap_used, reason = "helpers of tests, not input handling")]

mod common;

use std::path::Path;

use common::{FOOT_OBJ, Folder, SCENARIO, WORLD, check_no_panic, check_spoilings};
use glam::DVec3;
use surefoot_shared_types::config::scenario::{Scenario, StancePose};
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::scenario::load::load_scenario;
use surefoot_shared_types::world::load::load_world;
use surefoot_shared_types::world::world::World;
use surefoot_shared_types::{InputError, Shape};

fn world(folder: &Path) -> Result<World, InputError> {
    load_world(&folder.join("world.toml"))
}

fn scenario(folder: &Path) -> Result<Scenario, InputError> {
    load_scenario(&folder.join("scenario.toml"))
}

#[test]
fn a_valid_world_loads_as_written() {
    let folder = Folder::new();
    let world = world(&folder.path("")).unwrap();
    assert_eq!(world.mu, 0.6);
    assert_eq!(world.shapes.len(), 6);
    assert_eq!(world.shapes[0].shape, Shape::Box { half_extents: DVec3::new(5.0, 1.0, 0.25) });
    assert_eq!(world.shapes[2].shape, Shape::Cylinder { radius: 0.05, half_length: 1.0 });
    let axis = world.shapes[2].world_from_shape.rotation * DVec3::Z;
    assert!((axis + DVec3::Y).length() < 1e-12, "{axis}");
    assert!(
        matches!(&world.shapes[4].shape, Shape::ConvexHull { points, .. } if points.len() == 4)
    );
}

#[test]
fn a_mirrored_mesh_keeps_its_normals_outward() {
    let folder = Folder::new();
    let world = world(&folder.path("")).unwrap();
    let Shape::Mesh { vertices, triangles, source: Some(source) } = &world.shapes[5].shape else {
        panic!("not a mesh")
    };
    let volume: f64 = triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle.map(|index| vertices[index as usize]);
            a.dot(b.cross(c)) / 6.0
        })
        .sum();
    assert!((volume - 2.0 * 0.2 * 0.1 * 0.04).abs() < 1e-9, "{volume}");
    assert!(source.path.is_absolute());
    assert_eq!(source.scale, DVec3::new(1.0, -1.0, 2.0));
}

#[test]
fn the_world_digest_covers_file_and_meshes() {
    let folder = Folder::new();
    let digest = world(&folder.path("")).unwrap().digest;
    folder.write("meshes/foot.obj", format!("{FOOT_OBJ}\n").as_bytes());
    assert_ne!(world(&folder.path("")).unwrap().digest, digest);
}

#[test]
fn invalid_worlds_are_refused() {
    let cases = include_str!("data/invalid_world.txt");
    check_spoilings("world.toml", WORLD, cases, world);
}

#[test]
fn a_valid_scenario_loads_as_written() {
    let folder = Folder::new();
    let scenario = scenario(&folder.path("")).unwrap();
    assert_eq!((scenario.name.as_str(), scenario.seed), ("scenario", 7));
    assert_eq!(scenario.robot_path, folder.path("robot.toml"));
    assert_eq!(scenario.world_path, folder.path("world.toml"));
    let robot = load_robot(&scenario.robot_path).unwrap();
    assert!(robot.stance_width() > 0.0);
    assert_eq!((scenario.start.yaw, scenario.start.stance_width), (0.0, robot.stance_width()));
    assert_eq!((scenario.goal.yaw, scenario.goal.stance_width), (1.5, 0.3));
    assert_eq!((scenario.goal_tolerance.position, scenario.goal_tolerance.yaw), (0.10, 0.35));
    assert_eq!(
        (scenario.planner.work_max, scenario.planner.com_margin, scenario.checker.com_margin),
        (1000, 0.02, 0.001)
    );
}

#[test]
fn the_soles_of_a_stance_lie_beside_its_middle_and_the_seed_is_1_unless_stated() {
    let folder = Folder::new();
    folder.write("scenario.toml", SCENARIO.replacen("seed = 7\n", "", 1).as_bytes());
    let scenario = scenario(&folder.path("")).unwrap();
    assert_eq!(scenario.seed, 1);
    let stance = StancePose {
        position: DVec3::new(1.0, 2.0, 0.5),
        yaw: std::f64::consts::FRAC_PI_2,
        stance_width: 0.3,
    };
    let [left, right] = stance.world_from_soles();
    assert!((left.translation - DVec3::new(0.85, 2.0, 0.5)).length() < 1e-12, "{left:?}");
    assert!((right.translation - DVec3::new(1.15, 2.0, 0.5)).length() < 1e-12, "{right:?}");
    assert!((left.rotation * DVec3::X - DVec3::Y).length() < 1e-12, "{left:?}");
}

#[test]
fn the_scenario_digest_covers_numbers_and_not_names() {
    let digest = |from: &str, to: &str| {
        let folder = Folder::new();
        assert!(SCENARIO.contains(from));
        folder.write("scenario.toml", SCENARIO.replacen(from, to, 1).as_bytes());
        scenario(&folder.path("")).unwrap().digest
    };
    let same = digest("seed = 7", "seed = 7");
    assert_eq!(same, digest("robot.toml", "./robot.toml"));
    assert_eq!(same, digest("seed = 7", "seed = 7 # a comment"));
    for (from, to) in [
        ("seed = 7", "seed = 8"),
        ("yaw = 1.5", "yaw = 1.4"),
        ("work_max = 1000", "work_max = 1001"),
        ("0.001", "0.002"),
    ] {
        assert_ne!(same, digest(from, to), "{to}");
    }
}

#[test]
fn invalid_scenarios_are_refused() {
    let cases = include_str!("data/invalid_scenario.txt");
    check_spoilings("scenario.toml", SCENARIO, cases, scenario);
}

#[test]
fn damaged_files_cause_no_panic() {
    check_no_panic("world.toml", WORLD.as_bytes(), world);
    check_no_panic("scenario.toml", SCENARIO.as_bytes(), scenario);
    check_no_panic("meshes/foot.obj", FOOT_OBJ.as_bytes(), world);
}
