//! A robot simple enough to compute by hand: a torso on two straight legs, and one arm of two
//! links.

#![allow(dead_code, reason = "each test uses a part")]

use glam::{DMat3, DVec2, DVec3};
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::base::limits::{JOINTS_MAX, POLYGON_VERTICES_MAX};
use surefoot_shared_types::message::{Contact, Waypoint};
use surefoot_shared_types::robot::model::{
    Attachment, Foot, Joint, JointKind, Link, LinkShape, RobotModel,
};
use surefoot_shared_types::world::world::{World, WorldShape};
use surefoot_shared_types::{Pose, Shape};

/// The arm's joints in `q`; joints 0 and 1 are the hips.
pub const SHOULDER: usize = 2;
pub const ELBOW: usize = 3;
/// The masses: torso, each leg, each arm link.
pub const MASSES: [f64; 3] = [20.0, 5.0, 2.0];

pub fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_translation(DVec3::new(x, y, z))
}

fn link(
    name: &str,
    mass: f64,
    com: DVec3,
    parent: Option<Attachment>,
    shapes: &[(Pose, Shape)],
) -> Link {
    let shapes = shapes.iter().map(|(link_from_shape, shape)| LinkShape {
        link_from_shape: *link_from_shape,
        shape: shape.clone(),
    });
    Link {
        name: name.into(),
        parent,
        mass,
        com,
        inertia: DMat3::IDENTITY,
        shapes: shapes.collect(),
    }
}

fn hang(parent: usize, x: f64, y: f64, z: f64, joint: usize) -> Option<Attachment> {
    Some(Attachment { parent, parent_from_joint: at(x, y, z), joint: Some(joint) })
}

fn joint(name: &str, axis: DVec3, child: usize) -> Joint {
    Joint {
        name: name.into(),
        kind: JointKind::Revolute,
        axis,
        child,
        lower: -2.5,
        upper: 2.5,
        effort: 200.0,
        velocity: 5.0,
        stated_acceleration: None,
    }
}

pub fn box_of(x: f64, y: f64, z: f64) -> Shape {
    Shape::Box { half_extents: DVec3::new(x, y, z) }
}

/// A box as a closed mesh, each face of `count` by `count` squares.
pub fn mesh(half: [f64; 3], count: usize) -> Shape {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let mut corner = |i: usize, k: usize| {
                let along = |k: usize| (2.0 * k as f64 - count as f64) / count as f64;
                let mut at = DVec3::ZERO;
                at[axis] = sign;
                (at[(axis + 1) % 3], at[(axis + 2) % 3]) = (along(i), sign * along(k));
                vertices.push(at * DVec3::from(half));
                vertices.len() as u32 - 1
            };
            for (i, k) in (0..count).flat_map(|i| (0..count).map(move |k| (i, k))) {
                let quad = [corner(i, k), corner(i + 1, k), corner(i + 1, k + 1), corner(i, k + 1)];
                triangles.push([quad[0], quad[1], quad[2]]);
                triangles.push([quad[0], quad[2], quad[3]]);
            }
        }
    }
    let source = None;
    Shape::Mesh { vertices, triangles, source }
}

/// The root stands 0.9 m over the soles, which are 0.2 x 0.1 m, 0.2 m apart.
pub fn robot() -> RobotModel {
    let leg = [
        (at(0., 0., -0.58), box_of(0.04, 0.04, 0.28)),
        (at(0., 0., -0.88), box_of(0.1, 0.05, 0.02)),
    ];
    let arm = [(at(0., 0., -0.2), Shape::Capsule { radius: 0.03, half_length: 0.15 })];
    let down = DVec3::new(0.0, 0.0, -0.2);
    let links = vec![
        link("torso", MASSES[0], DVec3::ZERO, None, &[(Pose::IDENTITY, box_of(0.1, 0.14, 0.25))]),
        link("left_leg", MASSES[1], DVec3::new(0., 0., -0.5), hang(0, 0., 0.1, 0., 0), &leg),
        link("right_leg", MASSES[1], DVec3::new(0., 0., -0.5), hang(0, 0., -0.1, 0., 1), &leg),
        link("upper_arm", MASSES[2], down, hang(0, 0., 0.25, 0.2, SHOULDER), &arm),
        link("forearm", MASSES[2], down, hang(3, 0., 0., -0.4, ELBOW), &arm),
    ];
    let sole = |name: &str, link| Foot {
        name: name.into(),
        link,
        link_from_sole: at(0., 0., -0.9),
        polygon: [(-0.1, -0.05), (0.1, -0.05), (0.1, 0.05), (-0.1, 0.05)].map(DVec2::from).to_vec(),
    };
    RobotModel {
        name: "by hand".into(),
        urdf_path: "/by_hand.urdf".into(),
        robot_path: None,
        mesh_paths: vec![],
        links,
        joints: vec![
            joint("left_hip", DVec3::Y, 1),
            joint("right_hip", DVec3::Y, 2),
            joint("shoulder", DVec3::Y, 3),
            joint("elbow", DVec3::X, 4),
        ],
        feet: vec![sole("left", 1), sole("right", 2)],
        standing_q: vec![0.0; 4],
        locked_joints: Vec::new(),
        additions: Default::default(),
        allowed_overlaps: Vec::new(),
        digest: Digest([1; 32]),
    }
}

/// A floor whose top is at z = 0, and some more shapes.
pub fn world(more: Vec<(&str, Pose, Shape)>) -> World {
    let floor = ("floor", at(0., 0., -0.25), box_of(3., 3., 0.25));
    let shape = |(name, world_from_shape, shape): (&str, Pose, Shape)| WorldShape {
        name: name.into(),
        world_from_shape,
        shape,
    };
    World {
        mu: 0.6,
        shapes: std::iter::once(floor).chain(more).map(shape).collect(),
        digest: Digest([2; 32]),
    }
}

/// The robot standing at the origin with its arm so.
pub fn waypoint(time: f64, shoulder: f64, elbow: f64) -> Waypoint {
    let mut q = [0.0; JOINTS_MAX];
    (q[SHOULDER], q[ELBOW]) = (shoulder, elbow);
    let root = Pose::from_parts(DVec3::new(0., 0., 0.9), glam::DQuat::IDENTITY);
    Waypoint::at_rest(time, &root, &q)
}

/// The arm swinging at a constant speed, `count` waypoints.
pub fn swing(from: (f64, f64), to: (f64, f64), count: usize) -> Vec<Waypoint> {
    let part = |i: usize| i as f64 / (count - 1) as f64;
    (0..count)
        .map(|i| {
            waypoint(
                i as f64,
                from.0 + part(i) * (to.0 - from.0),
                from.1 + part(i) * (to.1 - from.1),
            )
        })
        .collect()
}

/// A foot on the floor where the standing robot has it.
pub fn contact(limb: u32) -> Contact {
    let y = if limb == 0 { 0.1 } else { -0.1 };
    let polygon = [[0.0; 2]; POLYGON_VERTICES_MAX];
    Contact { limb, polygon_len: 0, position: [0., y, 0.], rotation: [0., 0., 0., 1.], polygon }
}

pub fn both_feet() -> [Contact; 2] {
    [contact(0), contact(1)]
}

/// Uniform random numbers between two bounds, the same for the same seed.
pub fn randoms(seed: u64) -> impl FnMut(f64, f64) -> f64 {
    let mut state = seed;
    move |low, high| {
        // Knuth's generator of MMIX.
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * ((state >> 11) as f64 / (1_u64 << 53) as f64)
    }
}
