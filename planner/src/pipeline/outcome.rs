//! How a search ends.

use surefoot_shared_types::robot::model::FOOT_NAMES;

use crate::base::capacity::ArenaFull;
use crate::collision::model::Hit;
use crate::constraints::rejection::Rejection;
use crate::foot_placement::sole_support::NoSupport;
use crate::relaxation::Obstruction;

/// What a step of the planner leaves behind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Status {
    /// There is more to do.
    Working,
    /// The search is over.
    Done(Outcome),
}

/// How a search ended. None of these is an error: each is an honest answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outcome {
    /// A plan was found.
    Found,
    /// A bound of the budget was reached first.
    BudgetExhausted(Bound),
    /// An arena is full.
    ArenaFull(ArenaFull),
    /// The relaxed problem has no solution, or the world no friction, so there is no plan.
    Impossible(Obstruction),
    /// The robot cannot stand at the start.
    StartInvalid(EndpointError),
    /// The robot cannot stand at the goal.
    GoalInvalid(EndpointError),
    /// The chosen method cannot express the problem; what it can do.
    NotExpressible(&'static str),
    /// The chosen method has nothing left to try; why.
    MethodExhausted(&'static str),
    /// No smooth motion continues the chunks that are final.
    NoContinuation,
}

/// A bound of the budget, by the name of its parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    /// `planner.work_max`.
    Work,
}

/// Why the robot cannot stand at the start or the goal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EndpointError {
    /// A sole finds no support there.
    Unsupported {
        /// The foot.
        limb: usize,
        /// Why.
        reason: NoSupport,
    },
    /// A foot collides with the world there.
    FootCollides {
        /// The foot.
        limb: usize,
    },
    /// No standing configuration over both soles meets the constraints.
    NoPosture {
        /// The condition that failed.
        rejection: Rejection,
        /// The pair that is too near, if that is the reason.
        hit: Option<Hit>,
    },
    /// It is not known where both feet stand, or stood last.
    UnknownStance,
}

impl Outcome {
    /// One line for a person: what ended the search and what to do about it.
    pub fn describe(&self) -> String {
        match self {
            Self::Found => "plan found".into(),
            Self::BudgetExhausted(Bound::Work) => {
                "no plan: the work limit planner.work_max was reached; raise it in the scenario file".into()
            }
            Self::ArenaFull(full) => {
                format!("no plan: the arena planner.{} is full; raise it", full.parameter())
            }
            Self::Impossible(_) => "no plan is possible".into(),
            Self::StartInvalid(error) => format!("the start is invalid: {}", error.describe()),
            Self::GoalInvalid(error) => format!("the goal is invalid: {}", error.describe()),
            Self::NotExpressible(reason) => {
                format!("the method cannot express this problem: {reason}")
            }
            Self::MethodExhausted(reason) => {
                format!("no plan: the method has nothing left to try: {reason}")
            }
            Self::NoContinuation => {
                "no plan: no smooth motion continues the part that is final; quasi-static motion may"
                    .into()
            }
        }
    }

    /// The outcome's name in reports.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Found => "found",
            Self::BudgetExhausted(_) => "budget_exhausted",
            Self::ArenaFull(_) => "arena_full",
            Self::Impossible(_) => "impossible",
            Self::StartInvalid(_) => "start_invalid",
            Self::GoalInvalid(_) => "goal_invalid",
            Self::NotExpressible(_) => "not_expressible",
            Self::MethodExhausted(_) => "method_exhausted",
            Self::NoContinuation => "no_continuation",
        }
    }

    /// The parameter that ended the search, if one did.
    pub fn bound(&self) -> Option<&'static str> {
        match self {
            Self::BudgetExhausted(Bound::Work) => Some("work_max"),
            Self::ArenaFull(full) => Some(full.parameter()),
            _ => None,
        }
    }
}

impl EndpointError {
    fn describe(&self) -> String {
        let foot = |limb: &usize| FOOT_NAMES[*limb];
        match self {
            Self::Unsupported { limb, reason } => {
                format!("the {} sole is not supported there: {}", foot(limb), reason.describe())
            }
            Self::UnknownStance => "the last position of both feet is unknown".into(),
            Self::FootCollides { limb } => {
                format!("the {} foot collides with the world there", foot(limb))
            }
            Self::NoPosture { rejection, .. } => {
                format!("no standing posture there ({})", Rejection::NAMES[*rejection as usize])
            }
        }
    }
}

impl ArenaFull {
    /// The parameter that sizes the arena.
    pub fn parameter(&self) -> &'static str {
        match self {
            Self::Footholds => "footholds_max",
            Self::Transitions => "transitions_max",
            Self::TreeVertices => "tree_vertices_max",
            Self::Configurations | Self::Edges => "configurations_max",
            Self::Waypoints => "waypoints_max",
        }
    }
}
