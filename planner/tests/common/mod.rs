//! What the planner's test binaries share: the shipped scenarios, small worlds, and a robot built
//! in code.
#![allow(
    dead_code,
    missing_docs,
    clippy::unwrap_used,
    reason = "each test binary uses its own part, and ends where a file does not load"
)]

mod preparation;

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use glam::{DMat3, DVec2, DVec3};
pub use preparation::{preparation_for, try_preparation_for};
use surefoot_planner::base::random::Random;
use surefoot_planner::preparation::build;
use surefoot_planner::{Outcome, Planner, PlannerError, Status};
use surefoot_shared_types::config::scenario::Scenario;
use surefoot_shared_types::config::{MotionKind, PlannerConfig};
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::robot::model::{Attachment, Foot, Joint, JointKind, Link, RobotModel};
use surefoot_shared_types::scenario::load::load_scenario;
use surefoot_shared_types::world::load::load_world;
use surefoot_shared_types::world::world::{World, WorldShape};
use surefoot_shared_types::{Pose, Shape};

/// The walks that every build must find.
pub const WALKS: [&str; 4] = ["flat_walk", "ibeam_gap", "stepping_stones", "ibeam_hallway"];

pub fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

pub fn hubo() -> RobotModel {
    load_robot(&repository().join("configs/robots/hubo/robot.toml")).unwrap()
}

/// The Hubo whose left hip pitch axis stands 3 cm ahead of where yaw and roll meet, so that no
/// closed form fits.
pub fn with_split_hip(model: &RobotModel) -> RobotModel {
    let mut model = model.clone();
    let joint = model.joints.iter().find(|joint| joint.name == "left_hip_pitch").unwrap();
    model.links[joint.child].parent.as_mut().unwrap().parent_from_joint.translation.x += 0.03;
    model
}

/// The words of a robot's preparation with the standard margins. The shipped robot is prepared once
/// for all tests of a binary.
pub fn preparation_of(model: &RobotModel) -> Arc<Vec<u64>> {
    static HUBO: OnceLock<(RobotModel, Arc<Vec<u64>>)> = OnceLock::new();
    let words_of =
        |model: &RobotModel| Arc::new(build(model, &PlannerConfig::default(), &|_| ()).unwrap());
    let (known, words) = HUBO.get_or_init(|| {
        let model = hubo();
        let words = words_of(&model);
        (model, words)
    });
    if known == model { words.clone() } else { words_of(model) }
}

/// All that a planner is made from.
#[derive(Clone)]
pub struct Case {
    pub model: RobotModel,
    pub world: World,
    pub scenario: Scenario,
}

impl Case {
    /// A shipped scenario whose plan keeps the searched motion.
    pub fn shipped(name: &str) -> Self {
        let smooth = Self::smooth(name);
        Self { scenario: smooth.scenario.with_motion(MotionKind::QuasiStatic), ..smooth }
    }

    /// A scenario as it is shipped, with smooth motion.
    pub fn smooth(name: &str) -> Self {
        let scenario =
            load_scenario(&repository().join(format!("configs/scenarios/{name}.toml"))).unwrap();
        Self {
            model: load_robot(&scenario.robot_path).unwrap(),
            world: load_world(&scenario.world_path).unwrap(),
            scenario,
        }
    }

    pub fn with_seed(mut self, seed: u64) -> Self {
        self.scenario = self.scenario.with_seed(seed);
        self
    }

    /// The same case with one more box in its world: its centre and half of each side.
    pub fn with_box(mut self, center: [f64; 3], half_extents: [f64; 3]) -> Self {
        self.world.shapes.push(WorldShape {
            name: format!("box {}", self.world.shapes.len()),
            world_from_shape: Pose::from_translation(center.into()),
            shape: Shape::Box { half_extents: half_extents.into() },
        });
        self
    }

    /// The same case with a changed planner configuration.
    pub fn configured(mut self, change: impl FnOnce(&mut PlannerConfig)) -> Self {
        change(&mut self.scenario.planner);
        self
    }

    pub fn try_planner(&self, threads: usize) -> Result<Planner, PlannerError> {
        // A robot that cannot be prepared is refused as that, whatever else it is given.
        let preparation = try_preparation_for(&self.model, &self.scenario.planner)
            .unwrap_or_else(|_| preparation_for(&hubo(), &PlannerConfig::default()));
        Planner::builder(&self.model, &self.world, &self.scenario, preparation)
            .uncapped_threads(NonZeroUsize::new(threads).unwrap())
            .build()
    }

    pub fn planner(&self, threads: usize) -> Planner {
        self.try_planner(threads).unwrap()
    }
}

/// Steps a planner to its end.
pub fn run(planner: &mut Planner, step: u64) -> Outcome {
    loop {
        if let Status::Done(outcome) = planner.step(step) {
            return outcome;
        }
    }
}

/// A joint of a chain: from the joint before it, along or about an axis, between two limits.
pub struct Hinge {
    pub origin: [f64; 3],
    pub kind: JointKind,
    pub axis: [f64; 3],
    pub limits: [f64; 2],
}

pub fn hinge(origin: [f64; 3], axis: [f64; 3], limits: [f64; 2]) -> Hinge {
    Hinge { origin, kind: JointKind::Revolute, axis, limits }
}

/// A robot that is a root and one chain with a foot at its end, `sole` (m) from the last joint;
/// every link weighs 2 kg.
pub fn chain_robot(hinges: &[Hinge], sole: [f64; 3]) -> RobotModel {
    let link = |name: String, parent| Link {
        name,
        parent,
        mass: 2.0,
        com: DVec3::new(0.01, -0.02, -0.1),
        inertia: DMat3::from_diagonal(DVec3::splat(0.01)),
        shapes: vec![],
    };
    let mut links = vec![link("root".into(), None)];
    let mut joints = vec![];
    for (index, hinge) in hinges.iter().enumerate() {
        let parent_from_joint = Pose::from_translation(hinge.origin.into());
        links.push(link(
            format!("link {index}"),
            Some(Attachment { parent: index, parent_from_joint, joint: Some(index) }),
        ));
        joints.push(Joint {
            name: format!("joint {index}"),
            kind: hinge.kind,
            axis: hinge.axis.into(),
            child: index + 1,
            lower: hinge.limits[0],
            upper: hinge.limits[1],
            effort: 100.0,
            velocity: 5.0,
            stated_acceleration: None,
        });
    }
    let polygon =
        [(-0.1, -0.05), (0.1, -0.05), (0.1, 0.05), (-0.1, 0.05)].map(DVec2::from).to_vec();
    let foot = Foot {
        name: "left".into(),
        link: hinges.len(),
        link_from_sole: Pose::from_translation(sole.into()),
        polygon,
    };
    let middle = |joint: &Joint| 0.5 * (joint.lower + joint.upper);
    RobotModel {
        name: "chain".into(),
        urdf_path: "chain.urdf".into(),
        robot_path: None,
        mesh_paths: vec![],
        standing_q: joints.iter().map(middle).collect(),
        links,
        joints,
        feet: vec![foot],
        locked_joints: vec![],
        additions: Default::default(),
        allowed_overlaps: Vec::new(),
        digest: Default::default(),
    }
}

/// Joint positions anywhere between the limits, `margin` away from them.
pub fn random_positions(model: &RobotModel, margin: f64, random: &mut Random) -> Vec<f64> {
    model
        .joints
        .iter()
        .map(|joint| random.uniform(joint.lower + margin, joint.upper - margin))
        .collect()
}
