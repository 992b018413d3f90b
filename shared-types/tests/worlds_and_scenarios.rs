//! World and scenario files: a valid file loads as written, an invalid one gives one error line.

#![allow(clippy::unwrap_used, reason = "helpers of tests, not input handling")]

mod common;

use std::path::Path;

use common::{FOOT_OBJ, Folder, SCENARIO, Spoiling, WORLD, check_no_panic, check_spoilings};
use glam::DVec3;
use surefoot_shared_types::config::scenario::Scenario;
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
    let points = "points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]";
    let ball = "sphere = { radius = 0.1 }";
    let cases = [
        Spoiling { from: "mu = 0.6", to: "", complaint: &["world.toml", "mu"] },
        Spoiling { from: "mu = 0.6", to: "mu = -1", complaint: &["world.toml:1", "mu", "-1"] },
        Spoiling { from: "mu = 0.6", to: "mu = nan", complaint: &["world.toml:1", "mu", "NaN"] },
        Spoiling { from: "mu = 0.6", to: "mu = 11", complaint: &["mu", "11"] },
        Spoiling {
            from: "mu = 0.6",
            to: "mu = 0.6\ngravity = 3",
            complaint: &["world.toml:2", "gravity"],
        },
        Spoiling {
            from: "\"ball\"",
            to: "\"floor\"",
            complaint: &["world.toml:8", "shape 'floor'", "same name"],
        },
        Spoiling { from: "\"ball\"", to: "\" \"", complaint: &["world.toml:8", "needs a name"] },
        Spoiling {
            from: ball,
            to: "",
            complaint: &["world.toml:8", "shape 'ball'", "needs one of"],
        },
        Spoiling {
            from: ball,
            to: "sphere = { radius = 0.1 }\nbox = { half_extents = [1, 1, 1] }",
            complaint: &["shape 'ball'", "more than one"],
        },
        Spoiling {
            from: ball,
            to: "sphere = { radius = 0 }",
            complaint: &["shape 'ball'", "radius", "positive"],
        },
        Spoiling {
            from: ball,
            to: "sphere = { radius = inf }",
            complaint: &["shape 'ball'", "radius", "inf"],
        },
        Spoiling {
            from: ball,
            to: "sphere = { radius = 2e6 }",
            complaint: &["shape 'ball'", "2000000"],
        },
        Spoiling {
            from: ball,
            to: "sphere = { diameter = 1 }",
            complaint: &["world.toml:10", "diameter"],
        },
        Spoiling {
            from: "[5, 1, 0.25]",
            to: "[5, -1, 0.25]",
            complaint: &["shape 'floor'", "half_extents", "positive"],
        },
        Spoiling {
            from: "length = 2",
            to: "length = 0",
            complaint: &["shape 'pipe'", "length", "positive"],
        },
        Spoiling {
            from: "xyz = [0, 0, -0.25]",
            to: "xyz = [0, 0, nan]",
            complaint: &["shape 'floor'", "position", "NaN"],
        },
        Spoiling {
            from: "quat_xyzw = [0, 0, 0, 1]",
            to: "quat_xyzw = [0, 0, 0, 1.1]",
            complaint: &["shape 'rail'", "quaternion"],
        },
        Spoiling {
            from: "quat_xyzw = [0, 0, 0, 1]",
            to: "quat_xyzw = [0, 0, 0, 1]\nrpy = [0, 0, 0]",
            complaint: &["shape 'rail'", "keep one"],
        },
        Spoiling {
            from: "[0, 0, 1]] }",
            to: "[1, 1, 0]] }",
            complaint: &["shape 'wedge'", "one plane"],
        },
        Spoiling { from: points, to: "points = []", complaint: &["shape 'wedge'", "one plane"] },
        Spoiling {
            from: points,
            to: "scale = [1, 1, 1]",
            complaint: &["shape 'wedge'", "either points"],
        },
        Spoiling {
            from: "scale = [1, -1, 2]",
            to: "scale = [1, 0, 2]",
            complaint: &["shape 'block'", "scale"],
        },
        Spoiling {
            from: "meshes/foot.obj",
            to: "meshes/gone.obj",
            complaint: &["shape 'block'", "gone.obj", "cannot be read"],
        },
        Spoiling {
            from: "meshes/foot.obj",
            to: "world.toml",
            complaint: &["shape 'block'", "world.toml"],
        },
        Spoiling { from: WORLD, to: "mu = 0.6", complaint: &["at least one shape"] },
    ];
    check_spoilings("world.toml", WORLD, &cases, world);
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
    let work = "work_max = 1000";
    let cases = [
        Spoiling { from: "robot = \"robot.toml\"", to: "", complaint: &["scenario.toml", "robot"] },
        Spoiling { from: "seed = 7", to: "seed = -7", complaint: &["scenario.toml:3"] },
        Spoiling { from: "seed = 7", to: "speed = 7", complaint: &["scenario.toml:3", "speed"] },
        Spoiling {
            from: "xyz = [0, 0, 0]",
            to: "xyz = [0, 0, inf]",
            complaint: &["scenario.toml:5", "[start]", "inf"],
        },
        Spoiling {
            from: "stance_width = 0.3",
            to: "stance_width = 0",
            complaint: &["scenario.toml:8", "[goal]", "stance_width"],
        },
        Spoiling {
            from: "stance_width = 0.3",
            to: "position_tolerance = 0",
            complaint: &["[goal]", "position_tolerance"],
        },
        Spoiling {
            from: "stance_width = 0.3",
            to: "yaw_tolerance = nan",
            complaint: &["[goal]", "yaw_tolerance"],
        },
        Spoiling {
            from: work,
            to: "work_max = 0",
            complaint: &["scenario.toml:13", "planner.work_max"],
        },
        Spoiling { from: work, to: "footholds_max = 0", complaint: &["planner.footholds_max"] },
        Spoiling {
            from: work,
            to: "transitions_max = 4000000000",
            complaint: &["planner.transitions_max"],
        },
        Spoiling { from: work, to: "waypoints_max = 1", complaint: &["planner.waypoints_max"] },
        Spoiling { from: work, to: "work = 3", complaint: &["scenario.toml:14", "work"] },
        Spoiling {
            from: work,
            to: "clearance = 0",
            complaint: &["planner.clearance", "above 0.0005"],
        },
        Spoiling { from: work, to: "joint_margin = -0.1", complaint: &["planner.joint_margin"] },
        Spoiling { from: work, to: "collision_step = nan", complaint: &["planner.collision_step"] },
        Spoiling {
            from: work,
            to: "route_vertex_spacing = inf",
            complaint: &["planner.route_vertex_spacing"],
        },
        Spoiling {
            from: work,
            to: "effort_share = 1.5",
            complaint: &["planner.effort_share", "share"],
        },
        Spoiling {
            from: work,
            to: "effort_share = 1.0",
            complaint: &["planner.effort_share", "below checker.effort_share"],
        },
        Spoiling {
            from: work,
            to: "waypoint_joint_step = 0.2",
            complaint: &["planner.waypoint_joint_step", "below checker.joint_step_max"],
        },
        Spoiling {
            from: work,
            to: "support_area_min = 5e-4",
            complaint: &["planner.support_area_min", "above checker.support_area_min"],
        },
        Spoiling {
            from: "com_margin = 0.001",
            to: "com_margin = 0.02",
            complaint: &["planner.com_margin", "above checker.com_margin"],
        },
        Spoiling {
            from: work,
            to: "collision_step = 0.02",
            complaint: &["planner.clearance", "half of planner.collision_step"],
        },
        Spoiling {
            from: "com_margin = 0.001",
            to: "penetration_max = -1",
            complaint: &["checker.penetration_max"],
        },
        Spoiling {
            from: work,
            to: "collision_step = 1e-7",
            complaint: &["planner.collision_step", "between"],
        },
        Spoiling {
            from: work,
            to: "waypoint_joint_step = 1e-12",
            complaint: &["planner.waypoint_joint_step", "at least"],
        },
        Spoiling {
            from: work,
            to: "route_vertex_spacing = 1e-9",
            complaint: &["planner.route_vertex_spacing", "between"],
        },
        Spoiling {
            from: work,
            to: "joint_margin = 5",
            complaint: &["scenario.toml:13", "planner.joint_margin", "between"],
        },
        Spoiling {
            from: "com_margin = 0.001",
            to: "foot_position_max = 0",
            complaint: &["scenario.toml:17", "checker.foot_position_max"],
        },
        Spoiling {
            from: "com_margin = 0.001",
            to: "foot_position_max = 1e-9",
            complaint: &["checker.foot_position_max", "the planner"],
        },
        Spoiling {
            from: "com_margin = 0.001",
            to: "foot_rotation_max = 1e-9",
            complaint: &["checker.foot_rotation_max", "the planner"],
        },
        Spoiling {
            from: "com_margin = 0.001",
            to: "contact_gap_max = 1e-9",
            complaint: &["checker.contact_gap_max", "the planner"],
        },
        Spoiling {
            from: "com_margin = 0.001",
            to: "contact_tilt_max = 1e-9",
            complaint: &["checker.contact_tilt_max", "the planner"],
        },
    ];
    check_spoilings("scenario.toml", SCENARIO, &cases, scenario);
}

#[test]
fn damaged_files_cause_no_panic() {
    check_no_panic("world.toml", WORLD.as_bytes(), world);
    check_no_panic("scenario.toml", SCENARIO.as_bytes(), scenario);
    check_no_panic("meshes/foot.obj", FOOT_OBJ.as_bytes(), world);
}
