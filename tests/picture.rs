//! Pictures of a tiny robot's tiny walk, made in code.

#![allow(clippy::unwrap_used, reason = "a test ends where a picture cannot be made or read")]

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DMat3, DQuat, DVec2, DVec3};
use surefoot::picture::render::{check_extension, render, render_apng, render_png};
use surefoot::picture::{PictureError, PictureScene};
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::plan_format::blocks::{
    ContactBlock, EndBlock, PhaseBlock, PlanFile, PoseBlock, RobotBlock, SCHEMA, SceneBlock,
    WaypointBlock,
};
use surefoot_shared_types::robot::model::{
    Attachment, Foot, Joint, JointKind, Link, LinkShape, RobotModel,
};
use surefoot_shared_types::world::world::{World, WorldShape};
use surefoot_shared_types::{Pose, Shape};

const STEP: f64 = 0.4;
const STANCES: usize = 6;

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_parts(DVec3::new(x, y, z), DQuat::IDENTITY)
}

fn link(name: &str, parent: Option<Attachment>, shape: Shape) -> Link {
    let shapes = vec![LinkShape { link_from_shape: at(0.0, 0.0, 0.1), shape }];
    Link {
        name: name.into(),
        parent,
        mass: 5.0,
        com: DVec3::ZERO,
        inertia: DMat3::IDENTITY,
        shapes,
    }
}

/// A ball with two feet on sliding legs.
fn robot() -> RobotModel {
    let leg = |index: usize, y: f64| Attachment {
        parent: 0,
        parent_from_joint: at(0.0, y, -0.8),
        joint: Some(index),
    };
    let foot_box = Shape::Box { half_extents: DVec3::new(0.1, 0.05, 0.1) };
    let joint = |name: &str, child| Joint {
        name: name.into(),
        kind: JointKind::Prismatic,
        axis: DVec3::X,
        child,
        lower: -1.0,
        upper: 1.0,
        effort: 10.0,
        velocity: 1.0,
        stated_acceleration: None,
    };
    let sole =
        [[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05]].map(DVec2::from_array).to_vec();
    let foot = |name: &str, link| Foot {
        name: name.into(),
        link,
        link_from_sole: Pose::IDENTITY,
        polygon: sole.clone(),
    };
    RobotModel {
        name: "ball".into(),
        urdf_path: "ball.urdf".into(),
        robot_path: None,
        mesh_paths: vec![],
        links: vec![
            link("ball", None, Shape::Sphere { radius: 0.4 }),
            link("left_foot", Some(leg(0, 0.15)), foot_box.clone()),
            link("right_foot", Some(leg(1, -0.15)), foot_box),
        ],
        joints: vec![joint("left_leg", 1), joint("right_leg", 2)],
        feet: vec![foot("left", 1), foot("right", 2)],
        standing_q: vec![0.0, 0.0],
        locked_joints: Vec::new(),
        additions: Default::default(),
        allowed_overlaps: Vec::new(),
        digest: Digest::default(),
    }
}

fn world(wall: bool) -> World {
    let shape = |name: &str, world_from_shape, half: [f64; 3]| WorldShape {
        name: name.into(),
        world_from_shape,
        shape: Shape::Box { half_extents: half.into() },
    };
    let mut shapes = vec![shape("floor", at(1.0, 0.0, -0.25), [4.0, 4.0, 0.25])];
    if wall {
        shapes.push(shape("right_wall", at(1.0, -1.0, 1.0), [4.0, 0.05, 1.0]));
        shapes.push(shape("left_wall", at(1.0, 1.0, 1.0), [4.0, 0.05, 1.0]));
    }
    World { mu: 0.6, shapes, digest: Digest::default() }
}

fn plan() -> PlanFile {
    let waypoint = |i: usize| WaypointBlock {
        t: i as f64,
        root_xyz: [STEP * i as f64, 0.0, 0.8],
        root_quat_xyzw: [0.0, 0.0, 0.0, 1.0],
        q: vec![if i % 2 == 1 { 0.2 } else { 0.0 }, 0.0],
        velocity: vec![],
        acceleration: vec![],
        torque: vec![],
        rest_torque: vec![],
        rate_change_torque: vec![],
    };
    let contact = |foot: &str, x: f64, y: f64| ContactBlock {
        foot: foot.into(),
        sole_pose: PoseBlock { xyz: [x, y, 0.0], quat_xyzw: [0.0, 0.0, 0.0, 1.0] },
    };
    let phase = |i: usize| PhaseBlock {
        first: i,
        last: i + 1,
        mode: "double".into(),
        contacts: vec![
            contact("left", STEP * i as f64, 0.15),
            contact("right", STEP * i as f64, -0.15),
        ],
    };
    PlanFile {
        schema: SCHEMA.into(),
        robot: RobotBlock {
            urdf: "ball.urdf".into(),
            robot_file: None,
            feet: BTreeMap::new(),
            locked_joints: BTreeMap::new(),
            exact_meshes: vec![],
            effort_limits: BTreeMap::new(),
            acceleration_limits: BTreeMap::new(),
            effort_scale: None,
            urdf_additions: Default::default(),
        },
        scene: SceneBlock { mu: 0.6, shapes: Vec::new() },
        joint_names: vec!["right_leg".into(), "left_leg".into()],
        waypoints: (0..=STANCES).map(waypoint).collect(),
        phases: (0..STANCES).map(phase).collect(),
        chunks: vec![],
        start: EndBlock::Config {
            root_xyz: [0.0, 0.0, 0.8],
            root_quat_xyzw: [0.0, 0.0, 0.0, 1.0],
            q: vec![0.0, 0.0],
            tol: 1e-3,
        },
        goal: EndBlock::RootRegion {
            xy: [STEP * STANCES as f64, 0.0],
            radius: 0.2,
            z_range: None,
            yaw: None,
            yaw_tol: None,
        },
        origin: None,
        disturb_seed: None,
        executed: false,
    }
}

fn scene(wall: bool) -> PictureScene {
    PictureScene::new(&robot(), &world(wall), &plan()).unwrap()
}

/// Width, height, frames and the first frame's pixels.
fn read(path: &Path) -> (u32, u32, u32, Vec<[u8; 3]>) {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut data = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut data).unwrap();
    let info = reader.info();
    let frames = info.animation_control().map_or(1, |control| control.num_frames);
    (info.width, info.height, frames, data.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect())
}

fn count(pixels: &[[u8; 3]], is: impl Fn(i32, i32, i32) -> bool) -> usize {
    pixels.iter().filter(|p| is(p[0].into(), p[1].into(), p[2].into())).count()
}

fn blue(r: i32, _: i32, b: i32) -> bool {
    b - r > 60
}

fn red(r: i32, g: i32, b: i32) -> bool {
    r - g > 60 && r - b > 60
}

fn teal(r: i32, g: i32, b: i32) -> bool {
    g - r > 50 && (g - b).abs() < 50
}

fn magenta(r: i32, g: i32, b: i32) -> bool {
    r - g > 80 && b - g > 30 && r > b
}

#[test]
fn a_still_shows_the_walk_from_blue_to_red_on_teal_and_magenta_footholds() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("walk.png");
    render_png(&scene(false), &path).unwrap();
    let (width, height, frames, pixels) = read(&path);
    assert_eq!((width, height, frames), (1280, 720, 1));
    let counts =
        [count(&pixels, blue), count(&pixels, red), count(&pixels, teal), count(&pixels, magenta)];
    assert!(counts.iter().all(|&n| n > 500), "blue, red, teal, magenta pixels: {counts:?}");
}

#[test]
fn walls_before_the_walk_do_not_hide_it() {
    let folder = tempfile::tempdir().unwrap();
    let [open, walled] = [false, true].map(|wall| {
        let path = folder.path().join(format!("{wall}.png"));
        render_png(&scene(wall), &path).unwrap();
        let (.., pixels) = read(&path);
        count(&pixels, blue) + count(&pixels, red)
    });
    assert!(2 * walled > open, "{walled} robot pixels behind the wall, {open} without it");
}

#[test]
fn a_moving_picture_has_frames_and_stays_small() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("walk.apng");
    render_apng(&scene(true), &path).unwrap();
    let (width, height, frames, pixels) = read(&path);
    assert_eq!((width, height, frames), (800, 450, 60));
    assert!(count(&pixels, blue) > 500);
    assert!(std::fs::metadata(&path).unwrap().len() < 6_000_000);
}

#[test]
fn the_camera_follows_a_long_walk() {
    let mut long = plan();
    for waypoint in &mut long.waypoints {
        waypoint.root_xyz[0] *= 5.0;
    }
    for contact in long.phases.iter_mut().flat_map(|phase| &mut phase.contacts) {
        contact.sole_pose.xyz[0] *= 5.0;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.apng");
    render_apng(&PictureScene::new(&robot(), &world(false), &long).unwrap(), &path).unwrap();
    let file = std::io::BufReader::new(std::fs::File::open(&path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut data = vec![0; reader.output_buffer_size().unwrap()];
    for _ in 0..60 {
        let info = reader.next_frame(&mut data).unwrap();
        let pixels: Vec<[u8; 3]> =
            data[..info.buffer_size()].chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
        assert!(
            count(&pixels, |r, g, b| blue(r, g, b) || red(r, g, b) || b - g > 40) > 2000,
            "the robot left the picture"
        );
    }
    assert!(std::fs::metadata(&path).unwrap().len() < 6_000_000);
}

#[test]
fn the_same_plan_gives_the_same_bytes_and_the_extension_decides() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = ["a.png", "b.PNG"].map(|name| {
        let path = folder.path().join(name);
        render(&scene(true), &path).unwrap();
        std::fs::read(path).unwrap()
    });
    assert_eq!(a, b);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn other_extensions_are_refused_with_the_two_choices() {
    for name in ["walk.gif", "walk", "png"] {
        let error = check_extension(Path::new(name)).unwrap_err();
        assert!(matches!(error, PictureError::Extension { .. }));
        assert!(
            error.to_string().contains(".png") && error.to_string().contains(".apng"),
            "{error}"
        );
    }
}

#[test]
fn a_file_that_cannot_be_written_is_named() {
    let error = render(&scene(false), Path::new("/no/such/folder/walk.png")).unwrap_err();
    assert!(
        matches!(error, PictureError::Write { .. })
            && error.to_string().contains("/no/such/folder/walk.png"),
        "{error}"
    );
}

#[test]
fn plans_that_do_not_fit_the_robot_are_refused() {
    type Damage = fn(&mut PlanFile);
    let broken: [(&str, Damage); 6] = [
        ("no waypoints", |plan| plan.waypoints.clear()),
        ("joint 'left_leg'", |plan| plan.joint_names[1] = "tail".into()),
        ("waypoint 2", |plan| plan.waypoints[2].q.truncate(1)),
        ("waypoint 3", |plan| plan.waypoints[3].root_xyz[1] = f64::NAN),
        ("'tentacle'", |plan| plan.phases[0].contacts[0].foot = "tentacle".into()),
        ("waypoints 0 to 99", |plan| plan.phases[0].last = 99),
    ];
    for (wanted, breaks) in broken {
        let mut plan = plan();
        breaks(&mut plan);
        let error = PictureScene::new(&robot(), &world(false), &plan).unwrap_err();
        assert!(error.to_string().contains(wanted), "{error} does not say {wanted}");
    }
}

#[test]
fn a_robot_without_shapes_is_refused() {
    let mut robot = robot();
    robot.links.iter_mut().for_each(|link| link.shapes.clear());
    assert!(matches!(
        PictureScene::new(&robot, &world(false), &plan()),
        Err(PictureError::NoRobotShapes)
    ));
}

#[test]
fn a_plan_that_stands_still_is_drawn() {
    let mut still = plan();
    still.waypoints.truncate(1);
    still.phases = vec![PhaseBlock { first: 0, last: 0, ..still.phases[0].clone() }];
    let folder = tempfile::tempdir().unwrap();
    for name in ["one.png", "one.apng"] {
        render(
            &PictureScene::new(&robot(), &world(false), &still).unwrap(),
            &folder.path().join(name),
        )
        .unwrap();
    }
}
