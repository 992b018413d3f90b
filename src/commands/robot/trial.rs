//! A first walk on level ground: whether a robot file works.

use std::num::NonZeroUsize;

use glam::DVec3;
use surefoot_planner::Planner;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::config::builder::ScenarioContent;
use surefoot_shared_types::config::scenario::{Scenario, StancePose};
use surefoot_shared_types::config::{CheckerConfig, ExecutionConfig, PlannerConfig};
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::{World, WorldShape};
use surefoot_shared_types::{Pose, Shape};

use crate::commands::colliding_links;
use crate::commands::search_loop;
use crate::input::preparation_cache;
use crate::report::command_error::CommandError;
use crate::report::event::{PlanResult, Planned};
use crate::report::summary::rejected;
use crate::system::cores;

/// Length of the walk, m.
const LENGTH: f64 = 1.0;
/// How far soles and headings may be from the goal, m and rad: those of a scenario file.
const TOLERANCES: [f64; 2] = [0.1, 0.35];
/// Work limit, units.
const WORK_MAX: u64 = 200_000;

/// What the walk shows.
#[derive(Debug, Clone)]
pub(crate) struct Trial {
    /// How the search ended.
    pub(crate) result: PlanResult,
    /// How it ended, in words.
    pub(crate) ending: String,
    /// Steps of the plan.
    pub(crate) steps: u64,
    /// The joint that needs the largest share of its effort on one foot, and the share in percent.
    pub(crate) strain: Option<(String, f64)>,
    /// The links that collide most often as it shifts its weight, and how often, in percent.
    pub(crate) colliding: Option<(String, f64)>,
}

/// Plans a metre on level ground.
///
/// # Errors
/// The planner cannot use the robot, or a signal comes.
pub(crate) fn run(model: &RobotModel, quiet: bool) -> Result<Trial, CommandError> {
    let (scenario, world) = (scenario(model.stance_width())?, level_ground());
    let preparation = preparation_cache::obtain(model, &scenario.planner, quiet)?.preparation;
    let threads = NonZeroUsize::new(cores::default_threads()).unwrap_or(NonZeroUsize::MIN);
    let mut planner =
        Planner::builder(model, &world, &scenario, preparation).threads(threads).build()?;
    let planned = search_loop::run(&mut planner, WORK_MAX, &mut |_| Ok(()))?;
    Ok(Trial {
        result: planned.result,
        ending: ending(&planned),
        steps: planned.steps,
        strain: strain(model, &planner),
        colliding: colliding_links::frequent(planner.constraints()),
    })
}

/// How a search ended; where its bounded work did, what it rejected.
fn ending(planned: &Planned) -> String {
    match &planned.diagnosis {
        Some(diagnosis) if planned.work >= WORK_MAX => format!(
            "none within {WORK_MAX} work units; rejected: {}",
            rejected(&diagnosis.rejections)
        ),
        _ => planned.description.clone(),
    }
}

fn strain(model: &RobotModel, planner: &Planner) -> Option<(String, f64)> {
    let postures = &planner.constraints().single_support_postures;
    let worse = postures.iter().max_by(|a, b| a.effort_use.total_cmp(&b.effort_use))?;
    let joint = &model.joints[worse.most_strained?].name;
    Some((joint.clone(), 100.0 * worse.effort_use))
}

fn scenario(stance_width: f64) -> Result<Scenario, CommandError> {
    let stance = |x: f64| StancePose { position: DVec3::new(x, 0.0, 0.0), yaw: 0.0, stance_width };
    let [goal_position_tolerance, goal_yaw_tolerance] = TOLERANCES;
    let content = ScenarioContent {
        start: stance(0.0),
        goal: stance(LENGTH),
        goal_position_tolerance,
        goal_yaw_tolerance,
        seed: 1,
        planner: PlannerConfig { work_max: WORK_MAX, ..PlannerConfig::default() },
        checker: CheckerConfig::default(),
        execution: ExecutionConfig::default(),
    };
    content.build().map_err(|error| CommandError::Usage(error.to_string()))
}

/// Ten metres of floor.
pub(crate) fn level_ground() -> World {
    World {
        mu: 0.6,
        shapes: vec![WorldShape {
            name: "floor".into(),
            world_from_shape: Pose::from_translation(-0.25 * DVec3::Z),
            shape: Shape::Box { half_extents: DVec3::new(5.0, 5.0, 0.25) },
        }],
        digest: Digest::of(&[b"level ground"]),
    }
}

impl Trial {
    /// Whether a walk was found.
    pub(crate) fn is_found(&self) -> bool {
        self.result == PlanResult::Found
    }

    /// One line for a person.
    pub(crate) fn line(&self) -> String {
        if self.is_found() {
            return format!("a metre of level ground takes {} steps", self.steps);
        }
        format!("no walk over a metre of level ground: {}", self.ending)
    }
}
