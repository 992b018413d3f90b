//! A motion in one mode, and the results of its checks.

use std::borrow::Cow;

use surefoot_shared_types::message::{Check, Contact, Margins, SupportMode, Waypoint};

use crate::check::course::Course;
use crate::check::motion::{Sample, SampledMotion};
use crate::check::stance_foot::StanceFoot;
use crate::statics::sole_support::SoleSupport;

/// A motion within one mode.
#[derive(Debug, Clone, Copy)]
pub struct MotionSegment<'a> {
    /// The feet that carry the robot.
    pub mode: SupportMode,
    /// The poses of these feet, one contact per foot of the mode.
    pub contacts: &'a [Contact],
    /// The motion; at least one waypoint.
    pub waypoints: &'a [Waypoint],
    /// How it goes from waypoint to waypoint.
    pub course: Course<'a>,
}

/// A violated check.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{} at waypoint {waypoint}: {detail}", check.name())]
pub struct Violation {
    /// The check.
    pub check: Check,
    /// The waypoint of the segment at or after which the violation occurs.
    pub waypoint: usize,
    /// One line: the quantity, its value, the limit, and which link, foot, shape or joint.
    pub detail: String,
}

impl Violation {
    /// A violation of `check` at `waypoint`.
    pub fn new(check: Check, waypoint: usize, detail: impl Into<String>) -> Self {
        Self { check, waypoint, detail: detail.into() }
    }
}

/// Results of the checks of a segment.
#[derive(Debug, Clone, PartialEq)]
pub struct SegmentReport {
    /// The worst margins of the checks that hold.
    pub margins: Margins,
    /// The share of the joints' acceleration limits that stays unused; infinite where a limit is
    /// exceeded.
    pub acceleration: f64,
    /// The first violation of each violated check.
    pub violations: Vec<Violation>,
    /// Margin beyond what the checks require.
    pub reserves: Reserves,
}

impl SegmentReport {
    /// A report before any check.
    pub(crate) const UNMEASURED: Self = Self {
        margins: Margins::UNMEASURED,
        acceleration: f64::INFINITY,
        violations: Vec::new(),
        reserves: Reserves::UNMEASURED,
    };
}

/// Margin beyond what the checks require. Reported, not enforced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reserves {
    /// The share of the friction that is not needed, in sixteenths, rounded down.
    pub friction: f64,
    /// The share of the effort limits that stays unused by contact forces of least squares.
    pub least_squares_torque: f64,
}

impl Reserves {
    /// Reserves before any measurement.
    pub const UNMEASURED: Self =
        Self { friction: f64::INFINITY, least_squares_torque: f64::INFINITY };

    /// The smaller of each pair.
    pub fn min(&self, other: &Self) -> Self {
        Self {
            friction: self.friction.min(other.friction),
            least_squares_torque: self.least_squares_torque.min(other.least_squares_torque),
        }
    }
}

/// A segment with the data that several checks need.
pub(crate) struct Case<'a> {
    /// The contacts of the mode.
    pub(crate) contacts: &'a [Contact],
    /// The support of each contact by the world.
    pub(crate) supports: Vec<SoleSupport>,
    /// The waypoints of straight lines: those received, or the knots of a smooth motion.
    pub(crate) waypoints: Cow<'a, [Waypoint]>,
    /// For each of `waypoints`, the received one at or before it; empty where they are the same.
    pub(crate) received: Vec<usize>,
    /// Instants of a smooth motion with their velocities and accelerations, and the received
    /// waypoint before each; none in straight lines.
    pub(crate) instants: Vec<(usize, Waypoint)>,
    /// The configurations along the motion.
    pub(crate) motion: SampledMotion,
    /// The foot of each contact in each sample of the motion, sample by sample.
    pub(crate) stance_feet: Vec<StanceFoot>,
}

impl Case<'_> {
    /// The samples of the motion, each with the feet of the contacts.
    pub(crate) fn samples_with_feet(&self) -> impl Iterator<Item = (&Sample, &[StanceFoot])> {
        self.motion.samples.iter().zip(self.stance_feet.chunks(self.contacts.len().max(1)))
    }

    /// Whether the motion is smooth.
    pub(crate) fn is_smooth(&self) -> bool {
        !self.instants.is_empty()
    }

    /// A violation at one of `waypoints` with the index of the received one.
    pub(crate) fn as_received(&self, violation: Violation) -> Violation {
        let waypoint = self.received.get(violation.waypoint).copied();
        Violation { waypoint: waypoint.unwrap_or(violation.waypoint), ..violation }
    }

    /// The indices of the stance feet.
    pub(crate) fn stance(&self) -> Vec<usize> {
        self.contacts.iter().map(|contact| contact.limb as usize).collect()
    }
}
