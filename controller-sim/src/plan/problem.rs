//! The problem that a plan answers: the robot with its limits, the world, the tolerances, the start
//! and the goal.
//!
//! A plan may tighten a limit of the robot and never loosen it. Without a scenario the plan's own
//! robot block is all that is known: its effort limits cannot exceed those of the URDF, and its
//! acceleration limits count only where they are below the default.

use std::path::Path;

use surefoot_shared_types::InputError;
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::config::scenario::Scenario;
use surefoot_shared_types::plan_file::write::{end_block, on_ground};
use surefoot_shared_types::plan_format::blocks::{EndBlock, PhaseBlock, PlanFile, RobotBlock};
use surefoot_shared_types::robot::load::robot_from_block;
use surefoot_shared_types::robot::model::{ACCELERATION_DEFAULT, Joint, RobotModel};
use surefoot_shared_types::world::load::{load_world, world_from_block};
use surefoot_shared_types::world::world::World;

/// Distance of a sole from the start stance of a scenario, m: the ground may be up to 10 cm higher
/// or lower than the stance states, and on a slope a sole is not level.
const START_TOLERANCE: f64 = 0.12;

/// The problem that a plan answers.
#[derive(Debug, Clone)]
pub struct Problem {
    pub(crate) model: RobotModel,
    pub(crate) world: World,
    pub(crate) config: CheckerConfig,
    pub(crate) start: EndBlock,
    pub(crate) goal: EndBlock,
    /// How far soles may be turned at the goal, rad; nothing where the tolerance of `goal` says it.
    pub(crate) goal_turn_max: Option<f64>,
    /// Whose limits hold, one line each.
    pub(crate) notes: Vec<String>,
}

impl Problem {
    /// The problem that a plan states itself, with the default tolerances.
    ///
    /// # Errors
    /// The plan's robot or world cannot be loaded.
    pub fn of_plan(plan: &PlanFile, plan_path: &Path) -> Result<Self, InputError> {
        let base_dir = plan_path.parent().unwrap_or(Path::new(""));
        let mut model = robot_from_block(&plan.robot, base_dir, plan_path)?;
        let mut notes = vec![
            "limits: the plan's own robot, world, start and goal; name the scenario to check \
             against its"
                .to_owned(),
        ];
        notes.extend(standing_note(plan, &model));
        for joint in &mut model.joints {
            if joint.acceleration() > ACCELERATION_DEFAULT {
                notes.push(format!(
                    "limits: the plan states an acceleration of {} for joint {}; it may tighten \
                     the default of {ACCELERATION_DEFAULT} and not loosen it",
                    joint.acceleration(),
                    joint.name
                ));
                joint.stated_acceleration = None;
            }
        }
        let world = world_from_block(&plan.scene, base_dir, plan_path)?;
        let (start, goal) = (plan.start.clone(), plan.goal.clone());
        let config = CheckerConfig::default();
        Ok(Self { notes, ..Self::of_ends(model, world, config, [start, goal]) })
    }

    /// The problem of a robot and a world in memory, with the ends that a plan states.
    pub fn of_ends(
        model: RobotModel,
        world: World,
        config: CheckerConfig,
        [start, goal]: [EndBlock; 2],
    ) -> Self {
        Self { model, world, config, start, goal, goal_turn_max: None, notes: vec![] }
    }

    /// The problem of a robot and a world in memory, with the ends of a scenario.
    pub fn of_stances(
        model: RobotModel,
        world: World,
        scenario: &Scenario,
        plan: &PlanFile,
    ) -> Self {
        let ends = ends(&model, scenario, plan);
        let goal_turn_max = Some(scenario.goal_tolerance.yaw);
        Self { goal_turn_max, ..Self::of_ends(model, world, scenario.checker.clone(), ends) }
    }

    /// The problem of a scenario. Limits of the plan's robot hold where they are tighter.
    ///
    /// # Errors
    /// The scenario's or the plan's robot, or the world, cannot be loaded.
    pub fn of_scenario(
        scenario: &Scenario,
        mut model: RobotModel,
        plan: &PlanFile,
        plan_path: &Path,
    ) -> Result<Self, InputError> {
        let base_dir = plan_path.parent().unwrap_or(Path::new(""));
        // How the robot stands is the scenario's to say, so that the plan's robot file is not read.
        let block = RobotBlock { robot_file: None, ..plan.robot.clone() };
        let planned = robot_from_block(&block, base_dir, plan_path)?;
        let mut notes = vec![format!("limits: those of {}", scenario.robot_path.display())];
        for joint in &mut model.joints {
            if let Some(other) = planned.joints.iter().find(|other| other.name == joint.name) {
                tighten(joint, other, &mut notes);
            }
        }
        let world = load_world(&scenario.world_path)?;
        Ok(Self { notes, ..Self::of_stances(model, world, scenario, plan) })
    }
}

/// Where it is said how the robot stands and which of its links may overlap.
fn standing_note(plan: &PlanFile, model: &RobotModel) -> Option<String> {
    let named = plan.robot.robot_file.as_ref()?;
    Some(match &model.robot_path {
        Some(path) => format!("standing posture and allowed overlaps: those of {}", path.display()),
        None => format!(
            "standing posture: joints at 0, because {named}, which the plan names, is not there or \
             not of its URDF; name the scenario"
        ),
    })
}

/// The start and the goal of a scenario, on the ground that a plan stands on.
fn ends(model: &RobotModel, scenario: &Scenario, plan: &PlanFile) -> [EndBlock; 2] {
    let end = |stance, tolerance, phase| on_contacts(end_block(model, stance, tolerance), phase);
    [
        end(&scenario.start, START_TOLERANCE, plan.phases.first()),
        end(&scenario.goal, scenario.goal_tolerance.position, plan.phases.last()),
    ]
}

/// Lowers the effort and acceleration limits of a joint to those of the plan.
fn tighten(joint: &mut Joint, planned: &Joint, notes: &mut Vec<String>) {
    let mut lower = |limit: &mut f64, other: f64, what: &str| {
        if other < *limit {
            notes.push(format!(
                "limits: joint {}: {what} {other}, tightened by the plan from {limit}",
                joint.name
            ));
            *limit = other;
        }
    };
    lower(&mut joint.effort, planned.effort, "effort");
    // A plan that states no acceleration does not free the joint of one.
    let Some(planned) = planned.stated_acceleration else { return };
    let mut limit = joint.acceleration();
    lower(&mut limit, planned, "acceleration");
    if planned <= limit {
        joint.stated_acceleration = Some(limit);
    }
}

/// A stance with the height and the tilt of the ground on which the plan's soles stand in a phase.
/// That they touch it is checked by itself.
fn on_contacts(mut stance: EndBlock, phase: Option<&PhaseBlock>) -> EndBlock {
    let contacts = phase.map_or(&[][..], |phase| &phase.contacts);
    if let EndBlock::Feet { soles, .. } = &mut stance {
        for contact in contacts {
            if let Some(level) = soles.get_mut(&contact.foot) {
                *level = on_ground(level, &contact.sole_pose);
            }
        }
    }
    stance
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check_robot::robot;

    #[test]
    fn a_plan_tightens_the_acceleration_of_a_joint_and_never_frees_it() {
        let tightened = |own: Option<f64>, stated: Option<f64>| {
            let [mut joint, mut planned] = [(); 2].map(|()| robot().joints.swap_remove(0));
            (joint.stated_acceleration, planned.stated_acceleration) = (own, stated);
            tighten(&mut joint, &planned, &mut vec![]);
            joint.stated_acceleration
        };
        for (own, stated, expected) in [
            (Some(15.0), None, Some(15.0)),
            (Some(15.0), Some(20.0), Some(15.0)),
            (Some(15.0), Some(10.0), Some(10.0)),
            (None, Some(15.0), None),
            (None, Some(10.0), Some(10.0)),
            (None, Some(3.0), Some(3.0)),
            (None, None, None),
        ] {
            assert_eq!(tightened(own, stated), expected, "{own:?} {stated:?}");
        }
    }
}
