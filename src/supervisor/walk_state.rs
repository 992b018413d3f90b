//! The results that the roles of a walk have reported so far.

use crate::report::event::{DeliveryResult, PlanResult, RoleEvent};
use crate::report::role::Role;

/// The results of a walk so far.
#[derive(Debug, Default)]
pub(crate) struct WalkState {
    planned: Option<PlanResult>,
    delivered: Option<DeliveryResult>,
    checked: Option<StreamDecision>,
}

/// The controller's decision on the stream that it has executed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum StreamDecision {
    Accepted,
    Refused,
}

impl WalkState {
    /// Records an event of a role.
    pub(crate) fn record(&mut self, event: &RoleEvent) {
        match event {
            RoleEvent::Planned(planned) => self.planned = Some(planned.result),
            RoleEvent::Delivered(delivered) => self.delivered = Some(delivered.result),
            RoleEvent::Checked(checked) => {
                self.checked = Some(if checked.refusal.is_some() {
                    StreamDecision::Refused
                } else {
                    StreamDecision::Accepted
                })
            }
            _ => {}
        }
    }

    /// Whether both roles have reported their results, in either order.
    pub(crate) fn is_over(&self) -> bool {
        match (self.planned, self.delivered) {
            (None, _) | (Some(PlanResult::Found), None) => false,
            (Some(PlanResult::Found), Some(DeliveryResult::Accepted)) => {
                self.checked == Some(StreamDecision::Accepted)
            }
            (Some(PlanResult::Found), Some(DeliveryResult::Refused)) => {
                self.checked == Some(StreamDecision::Refused)
            }
            _ => true,
        }
    }

    /// The result that the planner reported and the controller has not, if it is so.
    pub(crate) fn unconfirmed(&self) -> Option<&'static str> {
        match self.delivered {
            Some(DeliveryResult::Accepted) if !self.is_over() => Some("accepted"),
            Some(DeliveryResult::Refused) if !self.is_over() => Some("refused"),
            _ => None,
        }
    }

    /// Whether the walk cannot end without the process of this role.
    pub(crate) fn needs(&self, role: Role) -> bool {
        match role {
            Role::Planner => self.delivered.is_none() && !self.is_over(),
            Role::Controller => !self.is_over(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_result_of_the_planner_alone_is_unconfirmed() {
        for (result, name, checked) in [
            (DeliveryResult::Accepted, "accepted", StreamDecision::Accepted),
            (DeliveryResult::Refused, "refused", StreamDecision::Refused),
        ] {
            let planned = Some(PlanResult::Found);
            let mut state = WalkState { planned, delivered: Some(result), checked: None };
            assert_eq!((state.unconfirmed(), state.is_over()), (Some(name), false));
            state.checked = Some(checked);
            assert_eq!((state.unconfirmed(), state.is_over()), (None, true));
        }
        let mut state = WalkState { planned: Some(PlanResult::Found), ..WalkState::default() };
        assert_eq!(state.unconfirmed(), None);
        state.delivered = Some(DeliveryResult::Contradicted);
        assert_eq!((state.unconfirmed(), state.is_over()), (None, true));
    }
}
