//! Queries of the collision model allocate no memory. The test is alone in its file because the
//! allocator counts for the whole process.

#[path = "common/allocations.rs"]
mod allocations;

use glam::{DQuat, DVec3};
use std::path::Path;
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::collision::model::{CollisionModel, FootPhase, Hit};
use surefoot_planner::robot::configuration::Configuration;
use surefoot_planner::robot::kinematic_state::KinematicState;
use surefoot_planner::robot::mechanism::Mechanism;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::world::world::{World, WorldShape};
use surefoot_shared_types::{Pose, Shape};

/// A world with one shape of each kind around the robot, and a mesh of 20 000 triangles below it.
fn world_of_every_shape() -> World {
    const ROWS: u32 = 101;
    let at = |i: u32, j: u32| {
        DVec3::new(
            f64::from(i) * 0.04 - 2.0,
            f64::from(j) * 0.04 - 2.0,
            -1.0 + f64::from((i * 7 + j * 3) % 5) * 0.03,
        )
    };
    let vertices = (0..ROWS * ROWS).map(|k| at(k / ROWS, k % ROWS)).collect();
    let cells = (0..ROWS - 1).flat_map(|i| (0..ROWS - 1).map(move |j| i * ROWS + j));
    let triangles =
        cells.flat_map(|k| [[k, k + ROWS, k + ROWS + 1], [k, k + ROWS + 1, k + 1]]).collect();
    let corners = (0..40)
        .map(|k| {
            DVec3::new(f64::from(k * 7 % 11), f64::from(k * 5 % 13), f64::from(k * 3 % 17)) * 0.02
        })
        .collect();
    let shapes = [
        (Shape::Mesh { vertices, triangles, source: None }, DVec3::ZERO),
        (Shape::Box { half_extents: DVec3::splat(0.2) }, DVec3::new(0.8, 0.0, 0.0)),
        (Shape::Sphere { radius: 0.2 }, DVec3::new(-0.8, 0.0, 0.0)),
        (Shape::Cylinder { radius: 0.1, half_length: 0.5 }, DVec3::new(0.0, 0.8, 0.0)),
        (Shape::Capsule { radius: 0.1, half_length: 0.5 }, DVec3::new(0.0, -0.8, 0.0)),
        (Shape::ConvexHull { points: corners, source: None }, DVec3::new(0.5, 0.5, 0.3)),
    ];
    let place = |(index, (shape, at)): (usize, (Shape, DVec3))| WorldShape {
        name: format!("shape {index}"),
        world_from_shape: Pose::from_parts(at, DQuat::IDENTITY),
        shape,
    };
    World {
        mu: 0.6,
        shapes: shapes.into_iter().enumerate().map(place).collect(),
        digest: Default::default(),
    }
}

#[test]
fn queries_allocate_no_memory() {
    let robot = load_robot(
        &Path::new(env!("CARGO_MANIFEST_DIR")).join("../configs/robots/hubo/robot.toml"),
    )
    .unwrap();
    let model = CollisionModel::new(&robot, &world_of_every_shape(), 0.01).unwrap();
    let mechanism = Mechanism::new(&robot, &PlannerConfig::default()).unwrap();
    let mut kinematic_state = KinematicState::default();
    let mut q = mechanism.standing_q;
    let mut world_hits = vec![0; 6];
    let (mut self_hits, mut free, mut foot_hits) = (0, 0, 0);
    let before = allocations::count_of_thread();
    for sample in 0..5_000 {
        let mut random = Random::new(1, Stream::Preparation, 3, sample);
        for (value, joint) in q.iter_mut().zip(&robot.joints) {
            *value = random.uniform(joint.lower, joint.upper).clamp(-0.6, 0.6);
        }
        let root = Pose::from_parts(
            DVec3::new(
                random.uniform(-0.8, 0.8),
                random.uniform(-0.8, 0.8),
                random.uniform(-0.3, 0.6),
            ),
            DQuat::IDENTITY,
        );
        kinematic_state.update(&mechanism, &Configuration { world_from_root: root, q });
        let phases = [FootPhase::Stance, FootPhase::LiftOff, FootPhase::Rising, FootPhase::Swing];
        let feet = [phases[random.below(4)], phases[random.below(4)]];
        if let Some(Hit::World { shape, .. }) = model.world_hit(&kinematic_state, &feet) {
            world_hits[shape] += 1;
        }
        self_hits += usize::from(model.self_hit(&kinematic_state).is_some());
        free += usize::from(model.hit(&kinematic_state, &feet).is_none());
        foot_hits += usize::from(
            model.foot_hit(random.below(2), &root, feet[0]).is_some()
                || model.feet_hit([&root, &kinematic_state.world_from_node(1)]),
        );
        assert!(model.motion_bound(&kinematic_state, &kinematic_state) < 1e-9);
    }
    assert_eq!(allocations::count_of_thread(), before, "queries allocated");
    assert!(
        world_hits.iter().all(|&count| count > 0) && self_hits > 0 && free > 0 && foot_hits > 0,
        "{world_hits:?} {self_hits} {free} {foot_hits}"
    );
}
