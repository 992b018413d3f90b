//! Where a plan begins and ends: at the stances that the robot was asked to walk from and to.

use surefoot_shared_types::base::spatial::{Pose, wrap_angle, yaw_of};
use surefoot_shared_types::config::scenario::{GoalTolerance, StancePose};
use surefoot_shared_types::message::chunk::FLAG_LAST;
use surefoot_shared_types::message::{PlanChunk, SupportMode, Waypoint};
use surefoot_shared_types::robot::model::RobotModel;

use crate::base::comparison::is_at_most;
use crate::kinematics::forward::{Configuration, Posture};

/// How far a sole of the first waypoint may be from the start stance, m: the ground may be up to
/// 10 cm higher or lower than the stance states.
const START_DISTANCE_MAX: f64 = 0.12;
/// How far the ground under a sole at the goal may be above or below the stance, m.
const GOAL_HEIGHT_MAX: f64 = 0.12;

/// The stance at which a plan ends, and how near.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goal {
    /// The stance.
    pub stance: StancePose,
    /// How far the soles may be from it.
    pub tolerance: GoalTolerance,
}

/// Both ends of a plan, as far as they are known.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PlanEnds {
    /// Where the robot stands before its first plan.
    pub(crate) start: Option<StancePose>,
    /// Where every plan ends.
    pub(crate) goal: KnownGoal,
}

/// What a controller knows of where plans end.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) enum KnownGoal {
    /// Nothing.
    #[default]
    None,
    /// Every plan ends at this goal.
    Same(Goal),
    /// Each plan ends, this near, at the goal that its last chunk states.
    Stated(GoalTolerance),
}

impl KnownGoal {
    /// The goal of a plan by its last chunk.
    fn of_plan(&self, last: &PlanChunk) -> Result<Option<Goal>, String> {
        match *self {
            Self::None => Ok(None),
            Self::Same(goal) => Ok(Some(goal)),
            Self::Stated(tolerance) => match last.goal.stance_pose() {
                Some(stance) => Ok(Some(Goal { stance, tolerance })),
                None => Err("the plan's last chunk does not state the goal".to_owned()),
            },
        }
    }
}

impl PlanEnds {
    /// Whether the soles of a plan's first waypoint are at the start stance.
    pub(crate) fn check_start(&self, model: &RobotModel, chunk: &PlanChunk) -> Result<(), String> {
        let Some(start) = &self.start else { return Ok(()) };
        let soles = soles_at(model, &chunk.waypoints()[0]);
        for ((foot, sole), stance) in model.feet.iter().zip(soles).zip(start.world_from_soles()) {
            let distance = sole.translation.distance(stance.translation);
            if !is_at_most(distance, START_DISTANCE_MAX) {
                let foot = &foot.name;
                return Err(format!(
                    "the {foot} sole begins {distance:.3} m from the start stance, limit \
                     {START_DISTANCE_MAX} m"
                ));
            }
        }
        Ok(())
    }

    /// Whether a plan's last chunk ends on both feet, with the soles at the goal.
    pub(crate) fn check_goal(
        &self,
        model: &RobotModel,
        chunk: &PlanChunk,
        mode: SupportMode,
    ) -> Result<(), String> {
        if chunk.flags & FLAG_LAST == 0 {
            return Ok(());
        }
        let Some(goal) = self.goal.of_plan(chunk)? else { return Ok(()) };
        if mode != SupportMode::Double {
            return Err("the plan ends on one foot".to_owned());
        }
        let waypoints = chunk.waypoints();
        let soles = soles_at(model, &waypoints[waypoints.len() - 1]);
        let stances = goal.stance.world_from_soles();
        for ((foot, sole), stance) in model.feet.iter().zip(soles).zip(stances) {
            goal.check_sole(&sole, &stance)
                .map_err(|reason| format!("the plan ends with the {} sole {reason}", foot.name))?;
        }
        Ok(())
    }
}

impl Goal {
    /// Whether a sole is at its pose at the goal. The ground decides its height and tilt.
    fn check_sole(&self, sole: &Pose, stance: &Pose) -> Result<(), String> {
        let GoalTolerance { position, yaw } = self.tolerance;
        let off = sole.translation - stance.translation;
        let (distance, height) = (off.truncate().length(), off.z.abs());
        if !is_at_most(distance, position) || !is_at_most(height, GOAL_HEIGHT_MAX) {
            return Err(format!(
                "{distance:.3} m beside its place at the goal and {height:.3} m above or below, \
                 limits {position} m and {GOAL_HEIGHT_MAX} m"
            ));
        }
        let turn = wrap_angle(yaw_of(sole.rotation) - self.stance.yaw).abs();
        if !is_at_most(turn, yaw) {
            return Err(format!("turned by {turn:.3} rad from the goal, limit {yaw} rad"));
        }
        Ok(())
    }
}

/// The poses of the soles at a waypoint.
fn soles_at<'a>(model: &'a RobotModel, waypoint: &Waypoint) -> impl Iterator<Item = Pose> + 'a {
    let configuration = Configuration::of_waypoint(waypoint, model.joints.len());
    let posture = Posture::new(model, &configuration);
    (0..model.feet.len()).map(move |limb| posture.world_from_sole(model, limb))
}
