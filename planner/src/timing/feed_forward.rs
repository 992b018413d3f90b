//! The feed-forward torques of a waypoint: those of the plan, those at rest, and their change where
//! the rate of plan time changes.

use glam::DVec2;
use heapless::Vec as BoundedVec;
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::message::Waypoint;

use crate::timing::contact_rates::ContactProblem;
use crate::timing::leg_relief::relieve_legs;
use crate::timing::limits::TimingLimits;
use crate::timing::load_sharing::{LoadSchedule, share_load};
use crate::timing::support::FootWrench;

/// The changes of the rate of plan time (1/s) between which the torques of two feet change evenly:
/// those of a stop within half a second, and beside a single support, where the torques pass into
/// those of one foot.
const STOP_CHANGE: f64 = 4.0;
const BORDER_CHANGE: f64 = 1.0;

/// The torques of a robot at a point of its path.
pub(super) struct FeedForward<'a> {
    pub limits: &'a TimingLimits,
    /// The contacts within the limits of a level.
    pub problem: ContactProblem<'a>,
    /// The same without margins, where the robot stands on two feet.
    pub bare: Option<ContactProblem<'a>>,
    /// How two feet share the load, and the part (0 to 1) of the span at which this point is.
    pub at: (&'a LoadSchedule, f64),
}

impl FeedForward<'_> {
    /// Writes them to the waypoint at this point.
    pub fn write(&self, waypoint: &mut Waypoint) {
        let within_limits = |rate: DVec2| self.limits.within_full_efforts(self.torques(rate));
        waypoint.torque = within_limits(DVec2::X);
        waypoint.rest_torque = within_limits(DVec2::ZERO);
        // Torques of one foot change evenly with the rate, beyond the limits, too.
        let (change, [slower, faster]) = match self.bare {
            None => (1.0, [-DVec2::Y, DVec2::Y].map(|rate| self.torques(rate))),
            Some(_) => {
                let (schedule, progress) = self.at;
                let freedom = schedule.freedom(progress);
                let change = BORDER_CHANGE + (STOP_CHANGE - BORDER_CHANGE) * freedom;
                (change, [-DVec2::Y, DVec2::Y].map(|rate| within_limits(change * rate)))
            }
        };
        waypoint.rate_change_torque =
            std::array::from_fn(|joint| 0.5 * (faster[joint] - slower[joint]) / change);
    }

    /// The torques at a rate along the path, with the load shared by the schedule.
    fn torques(&self, rate: DVec2) -> [f64; JOINTS_MAX] {
        let ContactProblem { dynamics, support, chains, .. } = &self.problem;
        let excess = |wrenches: &[FootWrench; 2]| self.problem.leg_load(rate, wrenches);
        let wrenches = share_load(support, dynamics.wrench_at(rate), self.at, excess);
        let wrenches = self.relieved(rate, wrenches);
        let mut torques = std::array::from_fn(|joint| dynamics.torque(joint).at(rate));
        for (foot, (force, moment)) in support.feet.iter().zip(&wrenches) {
            for &joint in &chains[foot.limb] {
                torques[joint] -=
                    dynamics.frames.torque_of_wrench(joint, *force, *moment, foot.center);
            }
        }
        torques
    }

    /// The wrenches of two feet that both legs and both soles exert; those of one foot stay.
    fn relieved(
        &self,
        rate: DVec2,
        wrenches: BoundedVec<FootWrench, 2>,
    ) -> BoundedVec<FootWrench, 2> {
        let (Some(bare), &[first, second]) = (&self.bare, &wrenches[..]) else { return wrenches };
        let centers = [0, 1].map(|at| self.problem.support.feet[at].center);
        relieve_legs(bare, rate, [first, second], centers).into_iter().collect()
    }
}
