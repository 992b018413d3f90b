//! The motion along a timed path as it is emitted: between two waypoints the position along the
//! path is the quintic polynomial with the rates of both; and the load on the ground under it, at
//! any rate of plan time, between the points of the path.

use surefoot_shared_types::message::interpolation::hermite;
use surefoot_shared_types::message::{Interpolation, PlanTime, Waypoint};

use crate::timing::limits::Level;
use crate::timing::path_point::Path;
use crate::timing::time_law::PathRates;
use crate::timing::timed_path::{SpanTimes, TimedPath};
use crate::timing::timed_robot::TimedRobot;
use crate::timing::tuning::ZERO_MOMENT_DOUBT;
use crate::timing::zero_moment::ContactGround;

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
    path: Path<'a>,
    pub timed: &'a TimedPath,
    /// The span in which the last sample was.
    last: Option<SampledSpan>,
}

/// A span of a motion.
#[derive(Debug)]
struct SampledSpan {
    span: usize,
    times: SpanTimes,
    ground: ContactGround,
    /// The interval in which the last sample was, and its number.
    interval: Option<(usize, EmittedInterval)>,
}

impl SampledSpan {
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
    pub fn new(robot: &'a TimedRobot, path: Path<'a>, timed: &'a TimedPath) -> Self {
        Self { robot, path, timed, last: None }
    }

    /// Shortest time in which the robot brakes or goes on, s.
    pub fn ramp_seconds_min(&self) -> f64 {
        self.robot.ramp_seconds_min()
    }

    /// Whether the zero-moment point keeps the controller's margin at a time while plan time passes
    /// like this.
    pub fn is_upright(&mut self, time: f64, at: &PlanTime) -> bool {
        let Self { robot, path, timed, last } = self;
        let holds = |last: &SampledSpan| last.times.begin <= time && time < last.times.end;
        if !last.as_ref().is_some_and(holds) {
            *last = None;
        }
        let sampled = last.get_or_insert_with(|| {
            let span = timed.span_at(time);
            let ground = robot.contact_ground(&path.spans[span]);
            SampledSpan { span, times: timed.span_times(span), ground, interval: None }
        });
        let rates = sampled.rates_at(timed, time);
        let (node, part) = timed.node_before(sampled.span, rates.position);
        let [before, after] = [node, node + 1].map(|at| &timed.nodes[at]);
        let basis = before
            .balance
            .between(&after.balance, &before.inner, part)
            .at(rates.speed, rates.acceleration);
        sampled.ground.region(Level::Bare, ZERO_MOMENT_DOUBT).contains(&basis.moving(at)) || {
            let planned = sampled.emitted(timed, *path, time);
            let moving = robot.ground_load(&sampled.ground, &at.apply(&planned));
            sampled.ground.region(Level::Bare, 0.0).holds(&moving, || basis.at_rest)
        }
    }
}
