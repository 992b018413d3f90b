//! Where a search begins and ends: on the scenario's marks, where the robot stands, or farther
//! back.

use surefoot_shared_types::base::spatial::wrap_angle;
use surefoot_shared_types::config::scenario::{Scenario, StancePose};
use surefoot_shared_types::message::{PlanChunk, RestState, SupportMode};
use surefoot_shared_types::world::world::World;

use crate::constraints::constraints::StartBalance;
use crate::ends::{StandingGround, foothold_at, stand_as, stand_on};
use crate::foot_placement::sole_support::SurfacesError;
use crate::motion::mode_graph::ArenaFull;
use crate::outcome::Outcome;
use crate::rpg::primitive_stretches::pair_on;
use crate::rpg::{Boundary, Phase, Planner};
use crate::way_back::{is_double, lift_off_before};

/// How far back a search begins.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct WayBack {
    /// The plan's first chunks that lead there: what was walked last, backwards.
    pub chunks: usize,
    /// Places back at which a foot was lifted and every condition holds.
    pub places: usize,
}

impl Planner {
    /// Begins where the robot stands, on both feet or on one, in place of the scenario's start
    /// mark. `world` is the planner's: what it gives the feet is their support. Allocates; to be
    /// called before the first step.
    ///
    /// # Errors
    /// The world has a shape that cannot be used.
    pub fn begin_at(&mut self, world: &World, standing: &RestState) -> Result<(), SurfacesError> {
        self.start_from(
            StandingGround::new(world)?.supported_anew(&self.shared.constraints.robot, standing),
        );
        Ok(())
    }

    /// Whether every condition holds where the robot stands, as [`Planner::begin_at`] said.
    pub fn may_begin(&self) -> bool {
        let margin_min = self.scenario.checker.com_margin;
        let constraints = &self.shared.constraints;
        self.standing.is_some_and(|at| {
            stand_as(constraints, &at).is_ok_and(|end| end.holds(constraints, margin_min))
        })
    }

    /// After [`Planner::begin_at`]: begins farther back, where a foot was lifted and every
    /// condition holds. The plan then begins with the way back there. `walked` are the chunks that
    /// the robot walked, the last one to where it stands. Of such places it is the last but
    /// `places - 1`, or the farthest. Allocates; to be called before the first step.
    ///
    /// # Errors
    /// The world has a shape that cannot be used.
    pub fn walk_back(
        &mut self,
        world: &World,
        walked: &[PlanChunk],
        places: usize,
    ) -> Result<(), SurfacesError> {
        let Some(standing) = &self.standing else { return Ok(()) };
        let conditions = (&self.shared.constraints, self.scenario.checker.com_margin);
        let Some(earlier) = lift_off_before(conditions, world, standing, (walked, places))? else {
            return Ok(());
        };
        for chunk in earlier.since.iter().rev() {
            if let Err(full) = self.chunks.append_reversed(chunk) {
                self.phase = Phase::Over(Outcome::ArenaFull(full));
            }
        }
        self.way_back = WayBack { chunks: earlier.since.len(), places: earlier.places };
        self.start_from(earlier.standing);
        Ok(())
    }

    fn start_from(&mut self, standing: RestState) {
        if let Some(mark) = standing.stance_pose() {
            // How far apart the feet happen to stand says nothing of how to walk on.
            self.scenario.start =
                StancePose { stance_width: self.scenario.goal.stance_width, ..mark };
            self.growth.set_start(&self.scenario.start);
        }
        self.standing = Some(standing);
    }

    /// How often a foot is set down on the way back.
    pub(crate) fn steps_back(&self) -> usize {
        let chunks = self.chunks();
        let ends_a_step = |index: &usize| {
            !is_double(&chunks[*index]) && chunks.get(index + 1).is_none_or(is_double)
        };
        (0..self.way_back.chunks.min(chunks.len())).filter(ends_a_step).count()
    }

    /// How far back it begins, after [`Planner::walk_back`].
    pub fn way_back(&self) -> WayBack {
        self.way_back
    }

    pub(crate) fn stand_on_ends(&mut self) -> Result<Phase, ArenaFull> {
        let goal_is_start = self.standing.is_none() && self.start_is_goal();
        let (constraints, surfaces, scratch) =
            (&self.shared.constraints, &self.shared.surfaces, &mut self.scratch[0]);
        let started = match &self.standing {
            Some(standing) => stand_as(constraints, standing),
            None => stand_on(constraints, surfaces, scratch, &self.scenario.start),
        };
        let start = match started {
            Ok(end) => end,
            Err(fault) => return Ok(Phase::Over(Outcome::StartInvalid(fault))),
        };
        let goal = match stand_on(constraints, surfaces, scratch, &self.scenario.goal) {
            Ok(_) if goal_is_start => start.clone(),
            Ok(end) => end,
            Err(fault) => return Ok(Phase::Over(Outcome::GoalInvalid(fault))),
        };
        for end in [&start, &goal] {
            let mut footholds = [0; 2];
            for limb in [0, 1] {
                let foothold = &end.footholds[limb];
                // A lifted foot may have lost the place where it stood: the world was corrected
                // since.
                let usable = end.stands(limb)
                    || foothold_at(constraints, surfaces, scratch, limb, &foothold.world_from_sole)
                        .is_ok();
                if usable {
                    footholds[limb] = self.roadmap.graph.identical_or_new(foothold)?;
                }
            }
            self.roadmap.add_boundary(Boundary {
                footholds,
                state: end.state,
                support: end.support,
            });
            // Who begins or ends on feet that are farther apart than primitive postures reach must
            // step off or onto them.
            let soles = [0, 1].map(|limb| &end.footholds[limb].world_from_sole);
            self.stretches |= end.support == SupportMode::Double
                && !self.shared.preparation.step_limits().may_step(soles);
        }
        let robot = &self.shared.constraints.robot;
        let com = robot.kinematic_state(&start.state.configuration).com.truncate();
        self.roadmap
            .set_start_balance(StartBalance { com, margin_min: self.scenario.checker.com_margin });
        self.growth.set_end_pairs([&start, &goal].map(|end| pair_on(robot, end)));
        Ok(Phase::Route)
    }

    /// Whether the start is as near to the goal as the scenario asks of the end.
    fn start_is_goal(&self) -> bool {
        let Scenario { start, goal, goal_position_tolerance, goal_yaw_tolerance, .. } =
            &self.scenario;
        let prints = start.world_from_soles().into_iter().zip(goal.world_from_soles());
        prints.into_iter().all(|(at, wanted)| {
            at.translation.distance(wanted.translation) <= *goal_position_tolerance
        }) && wrap_angle(goal.yaw - start.yaw).abs() <= *goal_yaw_tolerance
    }
}
