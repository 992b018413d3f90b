//! The scene of the kernels: a robot at a scenario's start, one step from there, and the world.

use std::path::Path;

use surefoot::input::inputs::{Inputs, Overrides};
use surefoot_planner::collision::model::CollisionModel;
use surefoot_planner::constraints::constraints::Constraints;
use surefoot_planner::constraints::foothold::{Foothold, double_mode, single_mode};
use surefoot_planner::constraints::mode::Mode;
use surefoot_planner::constraints::mode_state::ModeState;
use surefoot_planner::foot_placement::{FootPlacementConfig, Scratch, Surfaces};
use surefoot_planner::motion::cbirrt::SingleModeProblem;
use surefoot_planner::pipeline::Endpoint;
use surefoot_planner::pipeline::{foothold_at, stand_on};
use surefoot_planner::primitives::transition_configuration::sample;
use surefoot_planner::primitives::transition_pair::TransitionPair;
use surefoot_planner::robot::configuration::Configuration;
use surefoot_planner::robot::kinematic_state::KinematicState;
use surefoot_planner::robot::mechanism::Mechanism;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::{World, WorldShape};
use surefoot_shared_types::{Pose, Shape};

/// Length of the step, m.
const STEP: f64 = 0.25;
/// The seed of all random streams.
pub const SEED: u64 = 1;
/// Attempts at each transition of the step.
const ATTEMPTS: u64 = 200;

/// The inputs of a shipped scenario.
pub fn shipped(name: &str) -> Inputs {
    Inputs::load(
        &Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("configs/scenarios/{name}.toml")),
        Overrides::default(),
    )
    .unwrap()
}

/// The inputs with boxes around the start, so that the world holds `count` shapes. All are within
/// the robot's reach and none collides with it.
pub fn cluttered(mut inputs: Inputs, count: usize) -> Inputs {
    let middle = inputs.scenario.start.position;
    for index in inputs.world.shapes.len()..count {
        let angle = std::f64::consts::TAU * index as f64 / count as f64;
        let (sine, cosine) = libm::sincos(angle);
        let height = 0.1 + 1.3 * (index % 7) as f64 / 7.0;
        let offset = glam::DVec3::new(0.75 * cosine, 0.75 * sine, height);
        inputs.world.shapes.push(WorldShape {
            name: format!("box {index}"),
            world_from_shape: Pose::from_translation(middle + offset),
            shape: Shape::Box { half_extents: glam::DVec3::splat(0.04) },
        });
    }
    inputs
}

/// A robot at the start of a scenario.
pub struct Scene {
    pub model: RobotModel,
    pub world: World,
    pub constraints: Constraints,
    pub surfaces: Surfaces,
    pub scratch: Scratch,
    pub end: Endpoint,
    pub kinematic_state: KinematicState,
}

impl Scene {
    pub fn new(inputs: Inputs) -> Self {
        let Inputs { scenario, model, world, .. } = inputs;
        let robot = Mechanism::new(&model, &scenario.planner).unwrap();
        let collision = CollisionModel::new(&model, &world, scenario.planner.clearance).unwrap();
        let constraints = Constraints::new(robot, collision, scenario.planner);
        let placement = FootPlacementConfig::default();
        let mut scratch = Scratch::new(&placement);
        let surfaces = Surfaces::new(&world, placement).unwrap();
        let end = stand_on(&constraints, &surfaces, &mut scratch, &scenario.start).unwrap();
        let kinematic_state = KinematicState::new(&constraints.robot, &end.state.configuration);
        Self { model, world, constraints, surfaces, scratch, end, kinematic_state }
    }

    /// The mode in which the robot stands.
    pub fn standing_mode(&self) -> Mode {
        double_mode(&self.end.footholds[0], &self.end.footholds[1])
    }

    pub fn standing(&self) -> &Configuration {
        &self.end.state.configuration
    }

    /// A step of the left foot forward, if the ground supports it.
    pub fn step(&mut self) -> Option<Step> {
        let [left, right] = self.end.footholds.clone();
        let mut ahead = left.world_from_sole;
        ahead.translation += ahead.rotation * glam::DVec3::X * STEP;
        let landing =
            foothold_at(&self.constraints, &self.surfaces, &mut self.scratch, 0, &ahead).ok()?;
        let at =
            |stance: &Foothold, other: &Foothold, object| self.transition(stance, other, object);
        let states = [at(&left, &right, 1)?, at(&right, &left, 2)?, at(&right, &landing, 3)?];
        Some(Step { left, right, states })
    }

    fn transition(&self, stance: &Foothold, other: &Foothold, object: u64) -> Option<ModeState> {
        let pair = TransitionPair { stance, other };
        let mode = single_mode(stance);
        let found = (0..ATTEMPTS).find_map(|attempt| {
            sample(&self.constraints, &mode, pair, (SEED, object), attempt).ok()
        })?;
        Some(ModeState { configuration: found, world_from_soles: pair.world_from_soles() })
    }
}

/// A step: weight on the left foot, weight on the right foot, left foot placed ahead.
pub struct Step {
    pub left: Foothold,
    pub right: Foothold,
    pub states: [ModeState; 3],
}

impl Step {
    /// The weight shift from the left foot to the right.
    pub fn shift(&self) -> SingleModeProblem {
        self.problem(double_mode(&self.left, &self.right), 0)
    }

    /// The swing of the left foot.
    pub fn swing(&self) -> SingleModeProblem {
        self.problem(single_mode(&self.right), 1)
    }

    fn problem(&self, mode: Mode, first: usize) -> SingleModeProblem {
        SingleModeProblem {
            mode,
            from: self.states[first],
            to: self.states[first + 1],
            random: (SEED, first as u64),
            failures: 0,
        }
    }
}
