//! Whether the rounded motion of a profile is within the limits, and where it has to be slower.

use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::message::Waypoint;
use surefoot_shared_types::message::interpolation::{hermite, quintic_motion, stands};

use crate::timing::limits::Level;
use crate::timing::motion_changes::{Checked, MotionChanges};
use crate::timing::path_point::Path;
use crate::timing::slow_downs::SlowDowns;
use crate::timing::time_law::PathRates;
use crate::timing::timed_motion::EmittedInterval;
use crate::timing::timed_path::{SpanTimes, TimedPath};
use crate::timing::timed_robot::{AskedOfRobot, SpanContacts, TimedRobot, TimingMemory};
use crate::timing::tuning::{COP_MARGIN_BETWEEN, RATES_SHARE_MAX, ROUNDING_TIME, SLOWER};

/// Rounding of shares of limits.
const SHARE_TOLERANCE: f64 = 1e-9;
/// Parts of an interval between two waypoints in which the rates are compared.
const RATE_PARTS: usize = 4;
/// Distances of the root's acceleration (m/s2) and of a joint's acceleration (rad/s2 or m/s2)
/// between two waypoints from a straight line, up to which the middle between them is checked
/// alone. The first one moves the zero-moment point by 1 cm.
const EVEN_MAX: [f64; 2] = [0.1, 1.5];
/// The largest such distance that a motion may have, as a multiple of those. Where a path has a
/// corner between two waypoints, a faster motion than this is not the one that they state: a joint
/// stays within 100 rad/s2, and does within 60 in walks without such corners.
const UNEVEN_MAX: f64 = 100.0 / EVEN_MAX[1];
/// A waypoint, and what it asks of the robot where that is within the limits.
type Known<'a> = (&'a Waypoint, &'a Option<AskedOfRobot>);

/// Compares a motion with the limits. Spans that are unchanged since they were within the limits
/// are not compared again.
#[derive(Debug)]
pub(super) struct ProfileCheck<'a> {
    pub robot: &'a TimedRobot,
    pub memory: &'a mut TimingMemory,
    pub path: Path<'a>,
    pub timed: &'a TimedPath,
    pub slow_downs: &'a mut SlowDowns,
    pub changes: &'a mut MotionChanges,
}

impl ProfileCheck<'_> {
    /// A span before which all end by a time (s). The rounded law passes a node at most half of
    /// `ROUNDING_TIME` after the unrounded one.
    fn first_span(&self, from: f64) -> usize {
        let law = &self.timed.law;
        let begins_before =
            |(node, _): &(usize, f64)| law.time_of_node(*node) + ROUNDING_TIME <= from;
        self.timed.starts.partition_point(begins_before).saturating_sub(1)
    }

    /// Compares the rounded rates after a time (s) with those of the nodes around.
    pub fn rates_are_within(&mut self, from: f64) -> bool {
        let mut is_within = true;
        for span in self.first_span(from)..self.timed.spans() {
            if self.changes.is_checked(Checked::Rates, span) {
                continue;
            }
            let times = self.timed.span_times(span);
            let mut span_is_within = true;
            for index in 0..times.intervals {
                if times.end > from && times.at(index + 1, times.intervals) >= from {
                    span_is_within &= self.interval_is_within((span, &times, index), from);
                }
            }
            if span_is_within {
                self.changes.mark(Checked::Rates, span);
            }
            is_within &= span_is_within;
        }
        is_within
    }

    /// Compares rates in an interval between two waypoints after a time (s).
    fn interval_is_within(
        &mut self,
        (span, times, index): (usize, &SpanTimes, usize),
        from: f64,
    ) -> bool {
        let interval = EmittedInterval::new(self.timed, span, times, index);
        let is_last = index + 1 == times.intervals;
        let mut is_within = true;
        for part in 0..RATE_PARTS + usize::from(is_last) {
            let time = times.at(RATE_PARTS * index + part, RATE_PARTS * times.intervals);
            if time >= from {
                is_within &= self.rate_is_within(span, interval.at(time));
            }
        }
        is_within
    }

    fn rate_is_within(&mut self, span: usize, rates: PathRates) -> bool {
        let share = self.timed.share_of(span, &rates);
        if share > RATES_SHARE_MAX {
            self.slow_downs.ask_near(self.timed, rates.position, rates.speed, SLOWER / share);
        }
        share <= RATES_SHARE_MAX
    }

    /// Checks the motion after a time (s) as it is emitted.
    pub fn motion_is_within(&mut self, from: f64) -> bool {
        let mut is_within = true;
        for span in self.first_span(from)..self.timed.spans() {
            if self.changes.is_checked(Checked::Motion, span) {
                continue;
            }
            let times = self.timed.span_times(span);
            let span_is_within = times.end <= from || self.span_is_within(span, &times, from);
            if span_is_within {
                self.changes.mark(Checked::Motion, span);
            }
            is_within &= span_is_within;
        }
        is_within
    }

    /// Checks every waypoint and the curves between them.
    fn span_is_within(&mut self, span: usize, times: &SpanTimes, from: f64) -> bool {
        let mut is_within = true;
        let contacts = &self.robot.span_contacts(&self.path.spans[span], COP_MARGIN_BETWEEN);
        let on = (span, contacts);
        let mut here = self.timed.state(self.path, span, times, 0);
        let mut asked = None;
        if here.time >= from {
            asked = self.sample_asks(on, &here);
            is_within &= asked.is_some();
        }
        for index in 0..times.intervals {
            let next = self.timed.state(self.path, span, times, index + 1);
            let mut next_asked = None;
            if next.time >= from {
                next_asked = self.sample_asks(on, &next);
                is_within &= next_asked.is_some();
            }
            if 0.5 * (here.time + next.time) >= from {
                is_within &= self.curve_is_within(on, [(&here, &asked), (&next, &next_asked)]);
            }
            (here, asked) = (next, next_asked);
        }
        is_within
    }

    /// Checks instants between two waypoints, and what they ask of the robot: the middle, and more
    /// where an acceleration is far from a straight line.
    fn curve_is_within(&mut self, on: (usize, &SpanContacts<'_>), ends: [Known<'_>; 2]) -> bool {
        let [(here, _), (next, _)] = ends;
        let at = |part: f64| quintic_motion(here, next, here.time + (next.time - here.time) * part);
        let unevenness = unevenness(here, next);
        if unevenness <= 1.0 {
            return self.sample_is_within(on, &at(0.5));
        }
        if unevenness > UNEVEN_MAX {
            let rates = self.timed.law.at(0.5 * (here.time + next.time));
            let slower = SLOWER * libm::sqrt(UNEVEN_MAX / unevenness);
            self.slow_downs.ask_near(self.timed, rates.position, rates.speed, slower);
            return false;
        }
        self.uneven_curve_is_within(on, ends, at)
    }

    /// Checks instants between two waypoints as if what they ask of the robot were the polynomial
    /// of degree 3 through that at both waypoints and a quarter from them; where it is not within
    /// the limits, the instant itself.
    fn uneven_curve_is_within(
        &mut self,
        on: (usize, &SpanContacts<'_>),
        [(_, first), (_, last)]: [Known<'_>; 2],
        at: impl Fn(f64) -> Waypoint,
    ) -> bool {
        let quarters = [0.25, 0.75].map(|part| self.sample_asks(on, &at(part)));
        let mut is_within = quarters.iter().all(Option::is_some);
        let known = match (first, &quarters, last) {
            (Some(a), [Some(b), Some(c)], Some(d)) => Some([a, b, c, d]),
            _ => None,
        };
        for part in [0.125, 0.375, 0.5, 0.625, 0.875] {
            let sample = at(part);
            let is_borne = known.is_some_and(|known| {
                let asked = AskedOfRobot::interpolated(known, weights_at(part));
                self.robot.bears(self.memory, on.1, self.level_at(on.0, &sample), (&sample, &asked))
            });
            is_within &= is_borne || self.sample_is_within(on, &sample);
        }
        is_within
    }

    /// The level of the nodes around a sample.
    fn level_at(&self, span: usize, sample: &Waypoint) -> Level {
        let position = self.timed.law.at(sample.time).position;
        let (node, _) = self.timed.node_before(span, position);
        self.timed.nodes[node].level.max(self.timed.nodes[node + 1].level)
    }

    /// What a sample asks of the robot, if it is within the limits.
    fn sample_asks(
        &mut self,
        on: (usize, &SpanContacts<'_>),
        sample: &Waypoint,
    ) -> Option<AskedOfRobot> {
        let is_within = self.sample_is_within(on, sample);
        is_within.then(|| self.robot.asked(self.memory, on.1, sample))
    }

    /// Compares a sample with the first level, from those of the nodes around it on, within which
    /// the robot can stand there, and start from there.
    fn sample_is_within(
        &mut self,
        (span, contacts): (usize, &SpanContacts<'_>),
        sample: &Waypoint,
    ) -> bool {
        let Self { robot, memory, timed, slow_downs, .. } = self;
        let rates = timed.law.at(sample.time);
        let (node, _) = timed.node_before(span, rates.position);
        let mut level = timed.nodes[node].level.max(timed.nodes[node + 1].level);
        loop {
            let mut load = |at: &Waypoint| robot.load(memory, contacts, level, at);
            let moving = load(sample);
            if moving <= 1.0 + SHARE_TOLERANCE {
                return true;
            }
            let standing = load(&sample.rested());
            let at = (sample, rates.speed);
            let stays = standing < 1.0 && robot.can_start_at(memory, contacts, level, at);
            if let Some(next) = contacts.supports.next(level).filter(|_| !stays) {
                level = next;
                continue;
            }
            let slower = SLOWER * (1.0 - standing).max(0.0) / (moving - standing);
            slow_downs.ask_near(timed, rates.position, rates.speed, slower);
            return false;
        }
    }
}

/// The weights of four instants, at 0, 1/4, 3/4 and 1, in the polynomial of degree 3 through them.
fn weights_at(part: f64) -> [f64; 4] {
    const PLACES: [f64; 4] = [0.0, 0.25, 0.75, 1.0];
    PLACES.map(|own| {
        let others = PLACES.iter().filter(|&&other| other != own);
        others.map(|other| (part - other) / (own - other)).product()
    })
}

/// The largest distance of an acceleration from a straight line, a quarter from two waypoints, as a
/// multiple of [`EVEN_MAX`].
fn unevenness(here: &Waypoint, next: &Waypoint) -> f64 {
    let seconds = next.time - here.time;
    let distance = |[from, to]: [[f64; 3]; 2]| {
        if stands(from, to) {
            return 0.0;
        }
        [0.25, 0.75].into_iter().fold(0.0_f64, |largest, part| {
            let [.., acceleration] = hermite(from, to, seconds, part * seconds);
            let straight = from[2] + (to[2] - from[2]) * part;
            largest.max((acceleration - straight).abs())
        })
    };
    let root = |at: &Waypoint, axis: usize| {
        [at.root_position[axis], at.root_velocity[axis], at.root_acceleration[axis]]
    };
    let joint = |at: &Waypoint, joint: usize| {
        [at.q[joint], at.joint_velocity[joint], at.joint_acceleration[joint]]
    };
    let of_root = (0..3).map(|axis| distance([here, next].map(|at| root(at, axis))) / EVEN_MAX[0]);
    let of_joints = (0..JOINTS_MAX)
        .map(|index| distance([here, next].map(|at| joint(at, index))) / EVEN_MAX[1]);
    of_root.chain(of_joints).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_instants_give_a_polynomial_of_degree_3() {
        let cubic = |part: f64| 3.0 - 2.0 * part + 5.0 * part * part - 7.0 * part * part * part;
        for part in [0.125, 0.375, 0.5, 0.625, 0.875] {
            let known = [0.0, 0.25, 0.75, 1.0].map(cubic);
            let sum: f64 = weights_at(part).into_iter().zip(known).map(|(w, at)| w * at).sum();
            assert!((sum - cubic(part)).abs() < 1e-12, "{part}: {sum}");
        }
    }
}
