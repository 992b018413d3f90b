//! The timing of a smooth walk: within the limits between its waypoints,
//! smooth, near the time-optimal one, the same at every repetition.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;
#[path = "common/power.rs"]
mod power;
#[path = "common/smooth_walk.rs"]
mod smooth_walk;
#[path = "common/walk_timing.rs"]
mod walk_timing;

use common::hubo;
use glam::{DQuat, DVec2, DVec3};
use power::power;
use smooth_walk::{SmoothWalk, smooth_walk};
use surefoot_planner::constraints::foothold::Ground;
use surefoot_planner::geometry::convex_region::ConvexRegion;
use surefoot_planner::robot::inverse_dynamics::{
    GeneralizedForce, InverseDynamics, LinkFrames, VELOCITY_MAX,
};
use surefoot_planner::robot::mechanism::Mechanism;
use surefoot_planner::timing::limit::{BindingTimes, Limit};
use surefoot_planner::timing::limits::{Level, TimingLimits};
use surefoot_planner::timing::load_sharing::LoadSchedule;
use surefoot_planner::timing::path_point::{Path, PathPoint, PathSpan};
use surefoot_planner::timing::path_timing::PathTiming;
use surefoot_planner::timing::timed_path::SpanTimes;
use surefoot_planner::timing::timed_robot::TimedRobot;
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::config::{CheckerConfig, ExecutionConfig, PlannerConfig};
use surefoot_shared_types::message::{Contact, Interpolation, Ramp, Waypoint};
use surefoot_shared_types::robot::model::{Joint, RobotModel};
use walk_timing::{FRICTION, profile_seconds};

const SHARE: f64 = 0.8;

fn execution() -> ExecutionConfig {
    ExecutionConfig { share: SHARE, ..ExecutionConfig::default() }
}

fn timing_of(model: &RobotModel, walk: &SmoothWalk) -> PathTiming {
    walk.timing(model, &execution())
}

/// A waypoint of a span of a whole path.
fn waypoint_at(
    timing: &mut PathTiming,
    path: Path<'_>,
    span: usize,
    at: (&SpanTimes, usize),
) -> Waypoint {
    timing.waypoint(path, span, at, &LoadSchedule::beside(&[], path.spans, span))
}

/// Times a whole walk at once and returns its waypoints by span.
fn timed(timing: &mut PathTiming, walk: &SmoothWalk) -> Vec<Vec<Waypoint>> {
    assert!(walk.solve(timing));
    let path = walk.path();
    (0..walk.spans.len())
        .map(|span| {
            let times = timing.span_times(span);
            (0..=times.intervals).map(|at| waypoint_at(timing, path, span, (&times, at))).collect()
        })
        .collect()
}

/// The time of the unrounded profile, s.
fn unrounded(timing: &PathTiming) -> f64 {
    let states: Vec<(f64, f64)> = timing.nodes().map(|(node, x)| (node.position, x)).collect();
    profile_seconds(&states)
}

/// What a motion needs of the limits at one instant, by this file's own formulas.
struct Instant<'a> {
    model: &'a RobotModel,
    span: &'a PathSpan,
    waypoint: &'a Waypoint,
    frames: LinkFrames,
    effort: GeneralizedForce,
}

impl<'a> Instant<'a> {
    fn new(
        (model, robot): (&'a RobotModel, &InverseDynamics),
        span: &'a PathSpan,
        waypoint: &'a Waypoint,
    ) -> Self {
        let joined = |root: &[f64; 6], joints: &[f64; JOINTS_MAX]| {
            std::array::from_fn(|index| if index < 6 { root[index] } else { joints[index - 6] })
        };
        let v = joined(&waypoint.root_velocity, &waypoint.joint_velocity);
        let a = joined(&waypoint.root_acceleration, &waypoint.joint_acceleration);
        let mut frames = LinkFrames::default();
        robot.place(&waypoint.world_from_root(), &waypoint.q, &mut frames);
        let effort = robot.effort(&frames, &v, &a, 9.81);
        Self { model, span, waypoint, frames, effort }
    }

    /// The largest share of a joint's speed that is used.
    fn speed_use(&self) -> f64 {
        let speeds = self.model.joints.iter().zip(&self.waypoint.joint_velocity);
        speeds.map(|(joint, speed)| speed.abs() / (SHARE * joint.velocity)).fold(0.0, f64::max)
    }

    /// The torque that a joint needs in single support.
    fn torque(&self, contact: &Contact, joint: usize) -> f64 {
        let chain = self.model.chain(self.model.feet[contact.limb as usize].link);
        let origin = self.waypoint.world_from_root().translation;
        let (force, moment) = (self.effort.force, self.effort.moment);
        let load = self.frames.torque_of_wrench(joint, force, moment, origin);
        self.effort.torques[joint] - if chain.contains(&joint) { load } else { 0.0 }
    }

    /// The largest share of a joint's torque that is used in single support.
    fn torque_use(&self) -> f64 {
        let [contact] = self.span.contacts.as_slice() else { return 0.0 };
        let joints = self.model.joints.iter().enumerate();
        let use_of = |(index, joint): (usize, &Joint)| {
            self.torque(contact, index).abs() / (SHARE * joint.effort)
        };
        joints.map(use_of).fold(0.0, f64::max)
    }

    /// How far the feed-forward is from the torque that a joint needs in single support, as a share
    /// of its limit. In double support, how far its power is from that of the motion, as a share of
    /// the weight at 1 m/s.
    fn feed_forward_error(&self) -> f64 {
        let Waypoint { root_velocity, joint_velocity, torque, .. } = self.waypoint;
        if let [contact] = self.span.contacts.as_slice() {
            let error = |(index, joint): (usize, &Joint)| {
                (torque[index] - self.torque(contact, index)).abs() / joint.effort
            };
            return self.model.joints.iter().enumerate().map(error).fold(0.0, f64::max);
        }
        let v = std::array::from_fn(|index| {
            if index < 6 { root_velocity[index] } else { joint_velocity[index - 6] }
        });
        let given: f64 = torque.iter().zip(joint_velocity).map(|(torque, v)| torque * v).sum();
        (power(&self.effort, &v) - given).abs() / (self.model.mass() * 9.81)
    }

    /// The share of the friction pyramid that is used on level ground.
    fn friction_use(&self) -> f64 {
        let force = self.effort.force;
        let tangent = force.x.abs().max(force.y.abs());
        tangent / (FRICTION * std::f64::consts::FRAC_1_SQRT_2 * force.z)
    }

    /// Distance of the centre of pressure from the edge of the hull of the soles on the floor, m.
    fn pressure_margin(&self) -> f64 {
        let floor = self.span.contacts[0].position[2];
        let origin = self.waypoint.world_from_root().translation - DVec3::Z * floor;
        let (force, moment) = (self.effort.force, self.effort.moment);
        let about_floor = moment + origin.cross(force);
        let pressure = DVec2::new(-about_floor.y, about_floor.x) / force.z;
        let corners = self.span.contacts.iter().flat_map(|contact| {
            let pose = contact.world_from_sole();
            let used = &contact.polygon[..contact.polygon_len as usize];
            let corner = move |corner: &[f64; 2]| pose * DVec3::new(corner[0], corner[1], 0.0);
            used.iter().map(move |at| corner(at).truncate())
        });
        ConvexRegion::hull(corners).margin(pressure)
    }
}

/// Samples between all waypoints of a span.
fn between(waypoints: &[Waypoint]) -> impl Iterator<Item = Waypoint> + '_ {
    waypoints.windows(2).flat_map(|pair| {
        [0.0, 0.25, 0.5, 0.75, 1.0].map(|part| {
            let time = pair[0].time + part * (pair[1].time - pair[0].time);
            Interpolation::Quintic.between(&pair[0], &pair[1], time)
        })
    })
}

#[test]
fn a_smooth_walk_keeps_the_limits_near_its_optimum() {
    let model = hubo();
    let robot = InverseDynamics::new(&model);
    let walk = smooth_walk(&model, 4, 0.12);
    let mut timing = timing_of(&model, &walk);
    let spans = timed(&mut timing, &walk);
    let (end, optimum, stats) = (timing.law().end(), unrounded(&timing), timing.stats());
    println!("{end:.3} s, unrounded {optimum:.3} s, {stats:?}");
    assert_eq!((stats.rests, stats.beyond), (0, 0));
    assert!(stats.relaxed <= 2, "{stats:?}");
    assert!(end <= 1.10 * optimum, "{end} {optimum}");
    assert!(end < 8.0, "{end} s");
    let mut margin = f64::INFINITY;
    let mut uses = [0.0_f64; 3];
    for (span, waypoints) in walk.spans.iter().zip(&spans) {
        for sample in between(waypoints) {
            let instant = Instant::new((&model, &robot), span, &sample);
            margin = margin.min(instant.pressure_margin());
            let now = [instant.speed_use(), instant.torque_use(), instant.friction_use()];
            uses = std::array::from_fn(|index| uses[index].max(now[index]));
        }
    }
    println!("pressure {margin:.4} m, speed, torque, friction {uses:?}");
    // 12 % of the width of 14 cm.
    assert!(margin >= 0.0168 - 1e-4, "{margin}");
    assert!(margin < 0.0185, "the centre of pressure binds: {margin}");
    assert!(uses.iter().all(|used| *used <= 1.002), "{uses:?}");
}

#[test]
fn a_smooth_walk_is_smooth_and_the_same_again() {
    let model = hubo();
    let walk = smooth_walk(&model, 2, 0.12);
    let mut timing = timing_of(&model, &walk);
    let spans = timed(&mut timing, &walk);
    assert_eq!(timed(&mut timing, &walk), spans, "the same again");
    assert_eq!(timed(&mut timing_of(&model, &walk), &walk), spans, "from the beginning");
    for pair in spans.windows(2) {
        let (last, first) = (pair[0].last().unwrap(), pair[1][0]);
        assert!((last.time - first.time).abs() < 1e-12);
        for (a, b) in last.rates().zip(first.rates()) {
            assert!((a - b).abs() < 1e-6 * (1.0 + a.abs()), "{a} {b}");
        }
    }
    for waypoints in &spans {
        for pair in waypoints.windows(2) {
            let seconds = pair[1].time - pair[0].time;
            assert!(seconds > 0.0 && seconds <= 0.02 + 1e-9);
            for (a, b) in pair[0].joint_acceleration.iter().zip(&pair[1].joint_acceleration) {
                assert!((a - b).abs() < 30.0, "{a} {b}");
            }
        }
    }
    let rests = [spans[0][0], *spans.last().unwrap().last().unwrap()];
    let moving = |w: &Waypoint| w.joint_velocity.iter().chain(&w.root_velocity).any(|v| *v != 0.0);
    assert!(!rests.iter().any(moving), "at rest at both ends");
    assert!(spans[1].iter().all(moving), "and nowhere else");
}

/// Whether a whole walk has a timing within the limits.
fn has_timing(model: &RobotModel, walk: &SmoothWalk) -> bool {
    walk.solve(&mut timing_of(model, walk))
}

#[test]
fn a_path_beyond_a_joint_limit_has_no_timing() {
    let mut model = hubo();
    let walk = smooth_walk(&model, 2, 0.12);
    let knee = model.joints.iter().position(|joint| joint.name == "left_knee").unwrap();
    let highest = walk.points.iter().map(|point| point.q[knee]).fold(f64::NEG_INFINITY, f64::max);
    model.joints[knee].upper = highest + 2e-4;
    assert!(has_timing(&model, &walk));
    model.joints[knee].upper = highest - 1e-3;
    assert!(!has_timing(&model, &walk));
}

#[test]
fn a_stance_sole_that_the_curve_moves_is_moved_slowly() {
    let model = hubo();
    let robot = InverseDynamics::new(&model);
    let walk = smooth_walk(&model, 2, 0.12);
    let spans = timed(&mut timing_of(&model, &walk), &walk);
    let sole_speed = |spans: &[Vec<Waypoint>]| {
        let speed = |span: &PathSpan, sample: &Waypoint| {
            let limb = span.contacts[0].limb as usize;
            let chain = model.chain(model.feet[limb].link);
            let chain: Vec<usize> = chain.into_iter().collect();
            let instant = Instant::new((&model, &robot), span, sample);
            let mut v = [0.0; VELOCITY_MAX];
            v[..6].copy_from_slice(&sample.root_velocity);
            v[6..].copy_from_slice(&sample.joint_velocity);
            let sole = DVec3::from(span.contacts[0].position);
            instant.frames.point_velocity(&chain, sole, &v).length()
        };
        let of_span = |(span, waypoints): (&PathSpan, &Vec<Waypoint>)| {
            between(waypoints).map(|sample| speed(span, &sample)).fold(0.0, f64::max)
        };
        walk.spans.iter().zip(spans).map(of_span).fold(0.0, f64::max)
    };
    assert!(sole_speed(&spans) < 0.01, "{}", sole_speed(&spans));
    let span = &walk.spans[1];
    let middle = span.first.midpoint(span.last);
    let mut moved = smooth_walk(&model, 2, 0.12);
    moved.points[middle].first[0] += 0.06;
    let spans = timed(&mut timing_of(&model, &moved), &moved);
    let fastest = sole_speed(&spans);
    assert!(fastest > 0.01 && fastest < 0.0182, "{fastest}");
}

/// The largest acceleration of a joint that two waypoints do not show: a quarter from one of them,
/// its distance from a straight line, rad/s2.
fn hidden_acceleration(waypoints: &[Waypoint], joint: usize) -> f64 {
    let hidden = |pair: &[Waypoint], part: f64| {
        let [a, b] = [&pair[0], &pair[1]].map(|waypoint| waypoint.joint_acceleration[joint]);
        let time = pair[0].time + part * (pair[1].time - pair[0].time);
        let between = Interpolation::Quintic.between(&pair[0], &pair[1], time);
        (between.joint_acceleration[joint] - (a + part * (b - a))).abs()
    };
    let pairs = waypoints.windows(2);
    pairs.flat_map(|pair| [0.25, 0.75].map(|part| hidden(pair, part))).fold(0.0, f64::max)
}

#[test]
fn corners_of_a_path_between_two_waypoints_are_passed_slowly() {
    let model = hubo();
    let wrist = model.joints.iter().position(|joint| joint.name.contains("wrist")).unwrap();
    let mut walk = smooth_walk(&model, 2, 0.12);
    let middle = walk.spans[1].first.midpoint(walk.spans[1].last);
    walk.points[middle].first[6 + wrist] += 4.0;
    let spans = timed(&mut timing_of(&model, &walk), &walk);
    let hidden = hidden_acceleration(&spans[1], wrist);
    assert!(hidden > 50.0 && hidden <= 100.0, "{hidden} rad/s2");
}

/// The largest ratio of the speed that the rates allow a sole that comes down to 0.02 m/s and 8 1/s
/// times its distance from the foothold.
fn hardest_landing(walk: &SmoothWalk) -> f64 {
    let model = hubo();
    let robot = Mechanism::new(&model, &PlannerConfig::default()).unwrap();
    let mut timing = timing_of(&model, walk);
    walk.begin(&mut timing);
    let mut nodes = timing.nodes().map(|(node, _)| node);
    let mut hardest = 0.0_f64;
    for span in &walk.spans {
        let points = &walk.points[span.first..=span.last];
        let nodes: Vec<_> = nodes.by_ref().take(points.len()).collect();
        let [stance] = span.contacts.as_slice() else { continue };
        let leg = &robot.legs[1 - stance.limb as usize];
        let normal = stance.world_from_sole().rotation * DVec3::Z;
        let sole = |at: &PathPoint| (at.world_from_root * leg.root_from_sole(&at.q)).translation;
        let foothold = sole(&points[points.len() - 1]);
        for at in 1..points.len() - 1 {
            let [before, after] = [at - 1, at + 1].map(|at| &points[at]);
            let speed =
                normal.dot(sole(before) - sole(after)) / (after.parameter - before.parameter);
            let limit = 0.02 + 8.0 * sole(&points[at]).distance(foothold);
            let fastest = nodes[at].rates.fastest().map_or(0.0, |rates| rates.x.sqrt());
            hardest = hardest.max(fastest * speed / limit);
        }
    }
    hardest
}

#[test]
fn on_inclined_ground_feet_come_down_slowly() {
    let walk = || smooth_walk(&hubo(), 2, 0.12);
    let level = hardest_landing(&walk());
    assert!(level > 1.2, "{level}");
    let inclined = hardest_landing(&walk().turned(DQuat::from_rotation_y(0.06)));
    assert!(inclined < 1.05, "{inclined}");
}

#[test]
fn on_uneven_ground_feet_come_down_slowly() {
    let on = |standing: Ground, landing: Ground| {
        let mut walk = smooth_walk(&hubo(), 2, 0.12);
        for span in &mut walk.spans {
            let stands = |limb: usize| span.support.carries(limb);
            span.grounds = [0, 1].map(|limb| if stands(limb) { standing } else { landing });
        }
        hardest_landing(&walk)
    };
    let (even, uneven, rough) = (Ground::Even, Ground::Uneven, Ground::Rough);
    assert!(on(even, even) > 4.0, "{}", on(even, even));
    for (standing, landing) in [(uneven, even), (even, uneven), (even, rough)] {
        let hardest = on(standing, landing);
        assert!(hardest < 1.3, "{standing:?}, {landing:?}: {hardest}");
    }
}

#[test]
fn on_steep_ground_the_friction_that_the_controller_counts_on_carries() {
    // Up to 29.0 degrees: atan(0.6 cos(pi / 8)).
    for (degrees, carries) in [(20.0_f64, true), (28.0, true), (30.0, false)] {
        let mut walk = smooth_walk(&hubo(), 2, 0.12);
        for contact in walk.spans.iter_mut().flat_map(|span| &mut span.contacts) {
            contact.rotation = DQuat::from_rotation_y(-degrees.to_radians()).to_array();
        }
        let mut timing = timing_of(&hubo(), &walk);
        walk.begin(&mut timing);
        let slow = timing.nodes().filter(|(node, _)| node.level == Level::Unsupported).count();
        let all = timing.nodes().count();
        assert_eq!((slow == 0, slow == all), (carries, !carries), "{degrees}: {slow} of {all}");
    }
}

#[test]
fn a_window_ends_at_rest_and_costs_little_time() {
    let model = hubo();
    let walk = smooth_walk(&model, 4, 0.12);
    let path = walk.path();
    let mut timing = timing_of(&model, &walk);
    timed(&mut timing, &walk);
    let whole = timing.law().end();
    timing.begin();
    let mut known = Vec::new();
    for count in 1..=walk.spans.len() {
        timing.add_span(path).unwrap();
        let known_path = Path { spans: &walk.spans[..count], ..path };
        assert!(timing.solve(known_path, count.saturating_sub(4), known.len()));
        let end = timing.final_spans(count == walk.spans.len());
        for span in known.len()..end {
            let times = timing.span_times(span);
            known
                .push((times, waypoint_at(&mut timing, path, span, (&times, times.intervals / 2))));
        }
        for (span, (times, middle)) in known.iter().enumerate() {
            assert_eq!(timing.span_times(span), *times, "final times stay");
            assert_eq!(waypoint_at(&mut timing, path, span, (times, times.intervals / 2)), *middle);
        }
    }
    assert_eq!(known.len(), walk.spans.len());
    assert_eq!(timing.stats().rests, 0);
    assert!(timing.law().end() < 1.05 * whole, "{} {whole}", timing.law().end());
}

/// The largest difference (s) of a node's time in the law from that of the profile's speeds.
fn largest_lag(timing: &PathTiming) -> f64 {
    let nodes: Vec<(f64, f64, bool)> =
        timing.nodes().map(|(node, x)| (node.position, x.max(0.0).sqrt(), node.rests)).collect();
    let lag = |index: usize| {
        let [(from, begin, _), (to, end, rests)] = [nodes[index], nodes[index + 1]];
        let pause = if rests { 0.1 } else { 0.0 };
        let expected = if to > from { 2.0 * (to - from) / (begin + end) } else { 0.0 } + pause;
        let taken = timing.law().time_of_node(index + 1) - timing.law().time_of_node(index);
        (taken - expected).abs()
    };
    (0..nodes.len() - 1).map(lag).fold(0.0, f64::max)
}

#[test]
fn where_a_window_fails_the_motion_is_that_of_the_window_before() {
    let model = hubo();
    let mut walk = smooth_walk(&model, 4, 0.12);
    // Nothing moves through the middle of the sixth span: the sole would.
    let span = &walk.spans[5];
    let middle = span.first.midpoint(span.last);
    walk.points[middle].first[0] += 2e3;
    let mut timing = timing_of(&model, &walk);
    let path = walk.path();
    timing.begin();
    let mut is_within = true;
    for count in 1..=walk.spans.len() {
        if !is_within {
            break;
        }
        timing.add_span(path).unwrap();
        let known_path = Path { spans: &walk.spans[..count], ..path };
        is_within = timing.solve(known_path, count.saturating_sub(2), 0);
        assert!(largest_lag(&timing) < 1e-9, "{count} spans: {}", largest_lag(&timing));
    }
    assert!(!is_within && timing.stats().rests > 0, "{:?}", timing.stats());
    // The path ends at rest before the span that has no timing, and every chunk has a stop.
    let known = timing.spans();
    let spans = timing.end_at_last_rest(Path { spans: &walk.spans[..known], ..path });
    assert!(spans > 0 && spans < known && spans == timing.spans(), "{spans} of {known}");
    assert_eq!(timing.final_spans(true), spans);
    let mut last = None;
    for span in 0..spans {
        let times = timing.span_times(span);
        for chunk in 0..times.chunks() {
            assert!(timing.stop(span, chunk).is_some(), "{span} {chunk}");
        }
        last = Some(waypoint_at(&mut timing, path, span, (&times, times.intervals)));
    }
    let last = last.unwrap();
    assert!(last.joint_velocity.iter().chain(&last.root_velocity).all(|v| *v == 0.0));
    let begin = &walk.points[walk.spans[spans].first];
    let rest = timing.resting_waypoint(
        path,
        spans,
        begin.parameter,
        &LoadSchedule::beside(&[], path.spans, spans),
    );
    assert_eq!((rest.q, rest.world_from_root()), (last.q, last.world_from_root()));
    assert!(rest.torque.iter().any(|torque| *torque != 0.0));
}

#[test]
fn every_instant_is_bound_by_one_limit_or_none() {
    let model = hubo();
    let walk = smooth_walk(&model, 4, 0.12);
    let mut timing = timing_of(&model, &walk);
    timed(&mut timing, &walk);
    let mut times = BindingTimes::default();
    for span in 0..walk.spans.len() {
        let chunks = 0..timing.span_times(span).chunks();
        chunks.for_each(|chunk| times.add_all(&timing.binding_times(span, chunk)));
    }
    let bound: f64 = times.iter().map(|(_, seconds)| seconds).sum();
    // The law waits for half of the rounding time before the first node.
    assert!((bound + times.free + 0.1 - timing.law().end()).abs() < 1e-9);
    let of = |limit: Limit| times.iter().find(|entry| entry.0 == limit).unwrap().1;
    let balance = of(Limit::CentreOfPressure) + of(Limit::ZeroMoment) + of(Limit::Contacts);
    println!("{bound:.2} s bound, {balance:.2} s by balance, {:.2} s by none", times.free);
    assert!(bound > 0.7 * timing.law().end() && balance > 0.5 * bound);
}

#[test]
fn every_chunk_holds_a_stop_within_the_limits() {
    let model = hubo();
    let robot = InverseDynamics::new(&model);
    let walk = smooth_walk(&model, 4, 0.12);
    let mut timing = timing_of(&model, &walk);
    let spans = timed(&mut timing, &walk);
    let all: Vec<Waypoint> = spans.concat();
    let (mut brake_after, mut longest, mut latest) = (0.0, 0.0_f64, f64::INFINITY);
    for (index, waypoints) in spans.iter().enumerate() {
        let times = timing.span_times(index);
        for chunk in 0..times.chunks() {
            let [first, last] = times.chunk(chunk);
            let (begin, end) = (waypoints[first].time, waypoints[last].time);
            assert!(last - first < 32 && times.chunk_times(chunk) == [begin, end]);
            let stop = timing.stop(index, chunk).unwrap();
            println!("{index} {begin:.3}..{end:.3} {stop:?}");
            let rest = stop.brake_at + 0.5 * stop.brake_duration;
            assert!(stop.brake_at >= brake_after && rest <= end + 1e-9 && rest > begin);
            let shortest = stop.brake_duration.min(stop.resume_duration);
            assert!(shortest >= execution().ramp_seconds_min || rest == timing.law().end());
            longest = longest.max(stop.brake_duration);
            latest = latest.min(stop.brake_at - begin);
            let ramps = [
                (stop.brake_at, Ramp::Brake { seconds: stop.brake_duration }),
                (rest, Ramp::Resume { seconds: stop.resume_duration }),
            ];
            for (from, ramp) in ramps {
                for tick in 0..=40 {
                    let at = ramp.at(ramp.seconds() * f64::from(tick) / 40.0);
                    let time = (from + at.elapsed).min(timing.law().end());
                    let planned = Interpolation::Quintic.sample(&all, time);
                    let sample = at.apply(&planned);
                    let span = &walk.spans[spans
                        .iter()
                        .position(|span| span[span.len() - 1].time >= time - 1e-9)
                        .unwrap()];
                    let instant = Instant::new((&model, &robot), span, &sample);
                    let margin = instant.pressure_margin();
                    assert!(margin >= 0.016, "{ramp:?} {tick} {margin}");
                    assert!(instant.torque_use() <= 1.01 && instant.speed_use() <= 1.0);
                    let error = instant.feed_forward_error();
                    assert!(error < 0.01, "{ramp:?} {tick}: {error}");
                }
            }
            brake_after = stop.brake_at;
        }
    }
    println!("longest {longest:.3} s, least wait {latest:.3} s");
    assert!(longest < 2.5, "{longest}");
}

#[test]
fn no_ramp_begins_before_a_rest_that_lies_before_its_chunk() {
    let model = hubo();
    let mut walk = smooth_walk(&model, 4, 0.12);
    walk.spans[5].starts_at_rest = true;
    let longer = ExecutionConfig { ramp_seconds_min: 1.1, ..execution() };
    let mut timing = walk.timing(&model, &longer);
    timed(&mut timing, &walk);
    let rest = timing.span_times(5).begin;
    for span in 0..walk.spans.len() {
        for chunk in 0..timing.span_times(span).chunks() {
            let stop = timing.stop(span, chunk).unwrap();
            assert!(span < 5 || stop.brake_at >= rest, "{span} {chunk} {stop:?} {rest}");
            assert!(span >= 5 || stop.brake_at <= rest, "{span} {chunk} {stop:?} {rest}");
        }
    }
}

#[test]
fn on_one_foot_the_torques_of_a_change_of_the_rate_are_not_cut_off_at_the_limits() {
    let model = hubo();
    let walk = smooth_walk(&model, 4, 0.12);
    let known = timed(&mut timing_of(&model, &walk), &walk);
    let mut limits = TimingLimits::new(&model, &execution(), FRICTION, &CheckerConfig::default());
    limits.full_efforts = limits.full_efforts.map(|effort| 0.2 * effort);
    let points_max = walk.points.len() + walk.spans.len();
    let cut = timed(&mut PathTiming::new(TimedRobot::new(&model, limits), points_max), &walk);
    let mut are_cut = 0;
    for (span, (known, cut)) in walk.spans.iter().zip(known.iter().zip(&cut)) {
        for (known, cut) in known.iter().zip(cut).filter(|_| span.contacts.len() == 1) {
            assert_eq!(known.q, cut.q);
            assert_eq!(known.rate_change_torque, cut.rate_change_torque);
            are_cut += usize::from(known.rest_torque != cut.rest_torque);
        }
    }
    assert!(are_cut > 10, "{are_cut}");
}

/// The largest change of a torque on two feet where the rate changes by 1 1/s, as a share of its
/// limit, for a robot whose limits are so many times those of hubo.
fn largest_change_on_two_feet(efforts: f64) -> f64 {
    let mut model = hubo();
    model.joints.iter_mut().for_each(|joint| joint.effort *= efforts);
    let walk = smooth_walk(&model, 4, 0.12);
    let spans = timed(&mut timing_of(&model, &walk), &walk);
    let mut largest = 0.0_f64;
    for (span, waypoints) in walk.spans.iter().zip(&spans) {
        for waypoint in waypoints.iter().filter(|_| span.contacts.len() == 2) {
            for (joint, torque) in model.joints.iter().zip(&waypoint.rate_change_torque) {
                largest = largest.max(torque.abs() / joint.effort);
            }
        }
    }
    largest
}

#[test]
fn on_two_feet_a_change_of_the_rate_asks_for_moderate_torques() {
    // With these limits the feet exchange forces at most of the rates.
    let largest = largest_change_on_two_feet(0.3);
    assert!(largest > 0.05 && largest < 0.15, "{largest}");
}
