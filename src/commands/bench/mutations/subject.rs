//! A plan to change, with the random numbers that say where.

use glam::{DQuat, DVec3};
use surefoot_planner::base::random::Random;
use surefoot_shared_types::message::chunk::ROOT_FREEDOMS;
use surefoot_shared_types::plan_format::blocks::{ContactBlock, PlanFile, WaypointBlock};

/// A plan to change.
pub(super) struct Subject {
    pub(super) plan: PlanFile,
    pub(super) random: Random,
}

/// A change that begins and ends smoothly: its value and the two derivatives over its time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bump {
    pub(super) value: f64,
    pub(super) speed: f64,
    pub(super) acceleration: f64,
}

impl Bump {
    /// At a share of its `seconds`; it is 1 in the middle.
    pub(super) fn at(share: f64, seconds: f64) -> Self {
        let rest = 1.0 - share;
        let both = share * rest;
        let speed = 192.0 * both * both * (1.0 - 2.0 * share);
        let acceleration = 384.0 * both * (1.0 - 5.0 * both);
        Self {
            value: 64.0 * both * both * both,
            speed: speed / seconds,
            acceleration: acceleration / (seconds * seconds),
        }
    }
}

impl Subject {
    /// A waypoint that is neither the first nor the last one.
    pub(super) fn waypoint(&mut self) -> usize {
        1 + self.random.below(self.plan.waypoints.len().saturating_sub(2).max(1))
    }

    /// A joint.
    pub(super) fn joint(&mut self) -> usize {
        self.random.below(self.plan.joint_names.len())
    }

    /// A direction of space.
    pub(super) fn direction(&mut self) -> DVec3 {
        loop {
            let at = [0; 3].map(|_| self.random.uniform(-1.0, 1.0));
            let length = DVec3::from(at).length();
            if length > 0.1 && length < 1.0 {
                return DVec3::from(at) / length;
            }
        }
    }

    /// `magnitude`, or its negative.
    pub(super) fn signed(&mut self, magnitude: f64) -> f64 {
        if self.random.below(2) == 0 { magnitude } else { -magnitude }
    }

    /// A contact of a phase.
    pub(super) fn contact(&mut self) -> ContactBlock {
        let phase = self.random.below(self.plan.phases.len());
        let contacts = &self.plan.phases[phase].contacts;
        contacts[self.random.below(contacts.len())].clone()
    }

    /// All contacts that say the same as this one.
    pub(super) fn same<'a>(
        &'a mut self,
        contact: &'a ContactBlock,
    ) -> impl Iterator<Item = &'a mut ContactBlock> {
        let contacts = self.plan.phases.iter_mut().flat_map(|phase| &mut phase.contacts);
        contacts.filter(move |other| *other == contact)
    }

    /// Changes the waypoints of one to five seconds, each by its share of a bump.
    pub(super) fn bump(&mut self, change: impl Fn(&mut WaypointBlock, Bump)) {
        let seconds = self.random.uniform(1.0, 5.0);
        let last = self.plan.waypoints[self.plan.waypoints.len() - 1].t;
        let begin = self.random.uniform(0.0, (last - seconds).max(0.1));
        for waypoint in &mut self.plan.waypoints {
            let share = (waypoint.t - begin) / seconds;
            if (0.0..=1.0).contains(&share) {
                change(waypoint, Bump::at(share, seconds));
            }
        }
    }
}

/// Adds a bump of this size to a number of the velocity and of the acceleration, where they are
/// stated.
pub(super) fn add_rates(waypoint: &mut WaypointBlock, freedom: usize, bump: Bump, size: f64) {
    if let Some(speed) = waypoint.velocity.get_mut(freedom) {
        *speed += size * bump.speed;
    }
    if let Some(acceleration) = waypoint.acceleration.get_mut(freedom) {
        *acceleration += size * bump.acceleration;
    }
}

/// The place of a joint in a waypoint's velocity.
pub(super) fn freedom_of(joint: usize) -> usize {
    ROOT_FREEDOMS + joint
}

/// Adds a vector to a position.
pub(super) fn push(xyz: &mut [f64; 3], by: DVec3) {
    *xyz = (DVec3::from(*xyz) + by).to_array();
}

/// Turns a rotation about an axis of the world.
pub(super) fn turn(quat_xyzw: &mut [f64; 4], rotation: DQuat) {
    *quat_xyzw = (rotation * DQuat::from_array(*quat_xyzw)).normalize().to_array();
}
