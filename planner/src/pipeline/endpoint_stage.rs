//! Stands the robot on the start and on the goal, the first and the last boundary [Grey 4.4.1].

use surefoot_shared_types::base::spatial::{wrap_angle, yaw_of};
use surefoot_shared_types::config::scenario::{GoalTolerance, Scenario, StancePose};
use surefoot_shared_types::message::{RestState, SupportMode};
use surefoot_shared_types::world::world::World;

use crate::base::capacity::ArenaFull;
use crate::constraints::mode::StartBalance;
use crate::motion::ids::FootholdId;
use crate::motion::roadmap::Boundary;
use crate::pipeline::endpoints::{
    Endpoint, Nearness, TOLERANCE_SHARE, foothold_at, stand_in, stand_within,
};
use crate::pipeline::outcome::Outcome;
use crate::pipeline::retrace::Retrace;
use crate::pipeline::search::Search;
use crate::pipeline::stage::Event;
use crate::preparation::planning_context::PlanningContext;
use crate::relaxation::Obstruction;
use crate::robot::kinematic_state::KinematicState;

/// A sole nearer to its place at the goal than this stays, m: about what a placed foot is off.
const STAY_OFFSET_MAX: f64 = 5e-3;
/// A sole turned by less than this from its heading at the goal stays, rad.
const STAY_TURN_MAX: f64 = 0.02;

/// Stands the robot on the start and on the goal: the boundaries of the first and of the last
/// segment, and the roots of Gamma_P. One unit of work.
#[derive(Debug)]
pub(crate) struct EndpointStage {
    start: StancePose,
    goal: StancePose,
    /// The state that the robot is in, in place of the start stance.
    pub rest_state: Option<RestState>,
    /// What the plan retraces first.
    pub retrace: Retrace,
    /// Distance of the centre of mass inside the support at the start, m.
    com_margin: f64,
    /// How far the soles may be from the goal.
    goal_tolerance: GoalTolerance,
    /// Whether another method searches the walk.
    pub is_other_method: bool,
    has_friction: bool,
}

impl EndpointStage {
    /// Takes start and goal from a scenario, and whether there is friction from its world.
    pub fn new(scenario: &Scenario, world: &World) -> Self {
        Self {
            start: scenario.start,
            goal: scenario.goal,
            rest_state: None,
            retrace: Retrace::default(),
            com_margin: scenario.checker.com_margin,
            goal_tolerance: scenario.goal_tolerance,
            is_other_method: false,
            has_friction: world.mu > 0.0,
        }
    }

    /// Starts in a state that the robot is in. Returns its stance, if both feet are known: its
    /// width is that of the goal, since the actual width says nothing about the steps to come.
    pub fn start_in(&mut self, rest_state: RestState) -> Option<StancePose> {
        self.rest_state = Some(rest_state);
        let stance = rest_state.stance_pose()?;
        self.start = StancePose { stance_width: self.goal.stance_width, ..stance };
        Some(self.start)
    }

    /// The stances of start and goal.
    pub fn stances(&self) -> [&StancePose; 2] {
        [&self.start, &self.goal]
    }

    /// Distance of the centre of mass inside the support at the start, m.
    pub fn com_margin(&self) -> f64 {
        self.com_margin
    }

    /// Whether every condition holds in the state that the robot is in; `false` if none is known.
    pub fn is_rest_state_valid(&self, context: &PlanningContext) -> bool {
        let constraints = &context.constraints;
        self.rest_state.is_some_and(|state| {
            stand_in(constraints, &state)
                .is_ok_and(|endpoint| endpoint.holds(constraints, self.com_margin))
        })
    }

    /// Adds the boundaries of start and goal.
    ///
    /// # Errors
    /// The foothold arena is full.
    pub fn step(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        _budget: u64,
    ) -> Result<Event, ArenaFull> {
        search.stats.work += 1;
        let endpoints = match self.endpoints(context, search) {
            Ok(endpoints) => endpoints,
            Err(outcome) => {
                search.outcome = Some(outcome);
                return Ok(Event::Invalid);
            }
        };
        for endpoint in &endpoints {
            add_boundary(context, search, endpoint)?;
        }
        let robot = &context.constraints.robot;
        let com = KinematicState::new(robot, &endpoints[0].state.configuration).com.truncate();
        search.roadmap.set_start_balance(StartBalance { com, margin_min: self.com_margin });
        let pairs = endpoints.map(|endpoint| endpoint.pair(robot));
        search.route.set_end_pairs(pairs);
        search.guide.live.searches_mut().for_each(|route| route.set_end_pairs(pairs));
        Ok(if self.is_other_method { Event::OtherMethod } else { Event::Done })
    }

    /// The robot at the start and at the goal.
    fn endpoints(
        &self,
        context: &PlanningContext,
        search: &mut Search,
    ) -> Result<[Endpoint; 2], Outcome> {
        let PlanningContext { constraints, surfaces, .. } = context;
        let scratch = &mut search.footholds.scratch[0];
        let mut stand_at = |stance: &StancePose, nearness: Nearness| {
            stand_within(constraints, surfaces, scratch, (stance, nearness))
        };
        let start = match &self.rest_state {
            Some(state) => stand_in(constraints, state),
            None => stand_at(&self.start, Nearness::USUAL),
        };
        let start = start.map_err(Outcome::StartInvalid)?;
        let nearness = Nearness::of_goal(&self.goal_tolerance);
        let goal = stand_at(&self.goal, nearness).map_err(Outcome::GoalInvalid)?;
        if self.rest_state.is_none() && self.is_at_goal([&start, &goal]) {
            return Ok([start.clone(), start]);
        }
        if !self.has_friction {
            return Err(Outcome::Impossible(Obstruction::NoFriction));
        }
        Ok([start, goal])
    }

    /// Whether the soles are where the goal has them. A goal within its tolerances alone is walked
    /// to: it may be one short step away.
    fn is_at_goal(&self, [start, goal]: [&Endpoint; 2]) -> bool {
        let GoalTolerance { position, yaw } = self.goal_tolerance;
        let offset_max = STAY_OFFSET_MAX.min(TOLERANCE_SHARE * position);
        let turn_max = STAY_TURN_MAX.min(TOLERANCE_SHARE * yaw);
        self.goal.world_from_soles().into_iter().enumerate().all(|(limb, wanted)| {
            let [sole, at_goal] =
                [start, goal].map(|endpoint| endpoint.footholds[limb].world_from_sole);
            let place = wanted.translation.with_z(at_goal.translation.z);
            let turn = wrap_angle(yaw_of(sole.rotation) - self.goal.yaw).abs();
            sole.translation.distance(place) <= offset_max && turn <= turn_max
        })
    }
}

/// Adds an endpoint as a boundary of a segment.
fn add_boundary(
    context: &PlanningContext,
    search: &mut Search,
    endpoint: &Endpoint,
) -> Result<(), ArenaFull> {
    let footholds =
        [add_foothold(context, search, endpoint, 0)?, add_foothold(context, search, endpoint, 1)?];
    let Endpoint { state, support, .. } = *endpoint;
    search.roadmap.add_boundary(Boundary { footholds, state, support });
    // From footholds that are farther apart than primitive postures reach, and onto them, only
    // long steps lead.
    let soles = [0, 1].map(|limb| &endpoint.footholds[limb].world_from_sole);
    search.connections.long_steps |= endpoint.support == SupportMode::Double
        && !context.preparation.step_limits().may_step(soles);
    Ok(())
}

/// Adds a foothold of an endpoint. A lifted foot may have lost its foothold where the world was
/// corrected: then it is not added, and the result is 0.
fn add_foothold(
    context: &PlanningContext,
    search: &mut Search,
    endpoint: &Endpoint,
    limb: usize,
) -> Result<FootholdId, ArenaFull> {
    let PlanningContext { constraints, surfaces, .. } = context;
    let foothold = &endpoint.footholds[limb];
    let scratch = &mut search.footholds.scratch[0];
    let is_usable = endpoint.stands(limb)
        || foothold_at(constraints, surfaces, scratch, limb, &foothold.world_from_sole).is_ok();
    if is_usable { search.roadmap.graph.identical_or_new(foothold) } else { Ok(0) }
}
