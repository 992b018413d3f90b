//! The motion along a timed path as it is emitted: between two waypoints the position along the
//! path is the quintic polynomial with the rates of both; and the load on the ground under it, at
//! any rate of plan time, between the points of the path.

use surefoot_shared_types::message::interpolation::hermite;
use surefoot_shared_types::message::{Interpolation, PlanTime, Waypoint};

use crate::timing::limits::Level;
use crate::timing::path_point::Path;
use crate::timing::time_law::PathRates;
use crate::timing::timed_path::{SpanTimes, TimedPath};
use crate::timing::timed_robot::{SpanContacts, TimedRobot, TimingMemory};
use crate::timing::tuning::ZERO_MOMENT_DOUBT;

/// An interval between two waypoints.
#[derive(Debug, Clone, Copy)]
pub(super) struct EmittedInterval {
    begin: f64,
    seconds: f64,
    rates: [PathRates; 2],
}

impl EmittedInterval {
    /// The interval that begins at a waypoint of a span.
    pub fn new(timed: &TimedPath, span: usize, times: &SpanTimes, index: usize) -> Self {
        let [begin, end] = [index, index + 1].map(|at| times.at(at, times.intervals));
        let rates = [index, index + 1].map(|at| timed.rates_at(span, times, at));
        Self { begin, seconds: end - begin, rates }
    }

    /// The rates at a time (s) within it.
    pub fn at(&self, time: f64) -> PathRates {
        let [from, to] = self.rates.map(|at| [at.position, at.speed, at.acceleration]);
        let [position, speed, acceleration] = hermite(from, to, self.seconds, time - self.begin);
        PathRates { position, speed, acceleration }
    }
}

/// A robot's motion along a timed path.
#[derive(Debug)]
pub(super) struct TimedMotion<'a> {
    robot: &'a TimedRobot,
    memory: &'a mut TimingMemory,
    path: Path<'a>,
    pub timed: &'a TimedPath,
    /// The span in which the last sample was.
    last: Option<SampledSpan<'a>>,
}

/// A span of a motion.
#[derive(Debug)]
struct SampledSpan<'a> {
    span: usize,
    times: SpanTimes,
    contacts: SpanContacts<'a>,
    /// Whether its soles lie in one level plane.
    is_level: bool,
    /// The interval in which the last sample was, and its number.
    interval: Option<(usize, EmittedInterval)>,
}

impl SampledSpan<'_> {
    /// The index of the waypoint before a time (s) of the span.
    fn waypoint_before(&self, time: f64) -> usize {
        let SpanTimes { begin, end, intervals } = self.times;
        let along = (time - begin) / (end - begin) * intervals as f64;
        (along.max(0.0) as usize).min(intervals - 1)
    }

    /// The emitted motion at a time (s) of the span, as it is interpolated between waypoints.
    fn emitted(&self, timed: &TimedPath, path: Path<'_>, time: f64) -> Waypoint {
        let before = self.waypoint_before(time);
        let [from, to] =
            [before, before + 1].map(|index| timed.state(path, self.span, &self.times, index));
        Interpolation::Quintic.between(&from, &to, time)
    }

    /// The emitted rates at a time (s) of the span.
    fn rates_at(&mut self, timed: &TimedPath, time: f64) -> PathRates {
        let index = self.waypoint_before(time);
        let known = self.interval.filter(|(at, _)| *at == index);
        let interval = known
            .unwrap_or_else(|| (index, EmittedInterval::new(timed, self.span, &self.times, index)));
        self.interval = Some(interval);
        interval.1.at(time)
    }
}

impl<'a> TimedMotion<'a> {
    /// A robot's motion along a timed path.
    pub fn new(
        robot: &'a TimedRobot,
        memory: &'a mut TimingMemory,
        path: Path<'a>,
        timed: &'a TimedPath,
    ) -> Self {
        Self { robot, memory, path, timed, last: None }
    }

    /// Shortest time in which the robot brakes or goes on, s.
    pub fn ramp_seconds_min(&self) -> f64 {
        self.robot.ramp_seconds_min()
    }

    /// Whether, at a time while plan time passes like this, the zero-moment point keeps the
    /// controller's margin and contact forces within the limits move the robot.
    pub fn holds(&mut self, time: f64, at: &PlanTime) -> bool {
        let Self { robot, memory, path, timed, last } = self;
        if !last.as_ref().is_some_and(|last| last.times.begin <= time && time < last.times.end) {
            let span = timed.span_at(time);
            let contacts = robot.span_contacts(&path.spans[span], 0.0);
            let (times, is_level) = (timed.span_times(span), path.spans[span].is_level());
            *last = Some(SampledSpan { span, times, contacts, is_level, interval: None });
        }
        let Some(sampled) = last else { return false };
        let rates = sampled.rates_at(timed, time);
        let (node, part) = timed.node_before(sampled.span, rates.position);
        let [before, after] = [node, node + 1].map(|at| &timed.nodes[at]);
        let basis = before
            .balance
            .between(&after.balance, &before.inner, part)
            .at(rates.speed, rates.acceleration);
        let contacts = &sampled.contacts;
        let load = basis.moving(at);
        let level = before.level.max(after.level).max(Level::Bare);
        let is_far_inside = contacts.ground.region(Level::Bare, ZERO_MOMENT_DOUBT).contains(&load);
        let are_far_inside = sampled.is_level || TimedRobot::soles_bear(contacts, level, &load);
        if is_far_inside && are_far_inside {
            return true;
        }
        let moving = at.apply(&sampled.emitted(timed, *path, time));
        let is_upright = is_far_inside || {
            let load = robot.ground_load(&contacts.ground, &moving);
            contacts.ground.region(Level::Bare, 0.0).holds(&load, || basis.at_rest)
        };
        is_upright && (are_far_inside || robot.is_carried(memory, contacts, level, &moving))
    }
}
