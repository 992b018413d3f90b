//! Time parameterization of a chunk: short times within the limits of the joints' speeds and
//! accelerations, of the root's speed and of the acceleration of the centre of mass (compare Kunz,
//! Stilman 2012).
//!
//! Between waypoints the motion is linear, so speeds change only at waypoints: by
//! `|v[k] - v[k-1]|`, over half the time of both intervals beside the waypoint. A chunk begins and
//! ends at rest, because the next chunk may not arrive.
//!
//! An interval of `sqrt(2 d / a)` for a displacement `d` may begin and end at rest. Where every
//! interval is that long, each change of speed is at most the sum of two stops, for which both
//! intervals have the time. From there, sweeps shorten one interval after the other as far as its
//! neighbours allow, so the times are valid after every sweep.
//!
//! An acceleration of the centre of mass moves the zero-moment point by `h / g` of it, where `h` is
//! the height of the centre of mass, and friction has to hold it. A change of its speed counts as
//! spread over at most [`SPREAD_MAX`]. At last all times are stretched until joints that pass the
//! waypoints with a continuous speed keep their limits.

use glam::{DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::{CHUNK_WAYPOINTS_MAX, JOINTS_MAX};
use surefoot_shared_types::message::Waypoint;
use surefoot_shared_types::robot::model::{Joint, RobotModel};
use surefoot_shared_types::world::world::GRAVITY;

use crate::kinematics::forward::Kinematics;
use crate::plan::joint_acceleration::needed_accelerations;
use crate::plan::tuning::{
    ACCELERATION_SHARE, BALANCE_RESERVE_MIN, CENTRE_SHIFT_SHARE, FRICTION_SHARE, HALVINGS,
    JOINT_SPEED_MAX, LIMIT_SHARE, POLYNOMIAL_SLOWDOWN, ROOT_SPEED_MAX, SPREAD_MAX, SWEEPS,
    WAYPOINT_INTERVAL_MIN,
};
use crate::robot::mechanism::LINKS_MAX;
use crate::timing::ground::Ground;

/// Most intervals of a chunk.
pub const INTERVALS_MAX: usize = CHUNK_WAYPOINTS_MAX - 1;

/// Limits of a robot's joints in a plan. Unused joints have infinite limits.
#[derive(Debug, Clone)]
pub struct TimeParameterization {
    /// Largest speeds, rad/s or m/s.
    speeds: [f64; JOINTS_MAX],
    /// Largest accelerations, rad/s2 or m/s2.
    accelerations: [f64; JOINTS_MAX],
    kinematics: Kinematics,
    balance: BalanceReserve,
    /// Largest acceleration of the centre of mass that friction holds, m/s2.
    friction_acceleration: f64,
}

/// How far accelerations may move the zero-moment point from the centre of mass, seen from above.
#[derive(Debug, Clone, Copy)]
pub struct BalanceReserve {
    /// Margin at which a motion has no reserve, m: more than the checker's, whose region may be
    /// smaller.
    pub checked_margin: f64,
    /// Most reserve that is used, m: the planner's usual margin beyond the checker's.
    pub most: f64,
}

impl BalanceReserve {
    /// The reserve of a motion whose centre of mass, seen from above, keeps `margin` (m) in its
    /// support region.
    fn of(&self, margin: f64) -> f64 {
        (margin - self.checked_margin).clamp(BALANCE_RESERVE_MIN, self.most)
    }
}

/// Displacements within an interval, each over its largest acceleration, s2.
#[derive(Debug, Clone, Copy)]
struct Displacements {
    joints: [f64; JOINTS_MAX],
    /// Of the centre of mass, seen from above.
    centre: DVec2,
}

impl Displacements {
    const NONE: Self = Self { joints: [0.0; JOINTS_MAX], centre: DVec2::ZERO };
}

/// Accumulates the intervals between a chunk's waypoints to times, from `begin` (s) on. Returns the
/// time of the last waypoint, s.
pub fn accumulate(waypoints: &mut [Waypoint], begin: f64) -> f64 {
    waypoints.iter_mut().fold(begin, |time, waypoint| {
        waypoint.time += time;
        waypoint.time
    })
}

impl TimeParameterization {
    /// The limits of a robot on ground with a coefficient of friction `mu`.
    pub fn new(model: &RobotModel, balance: BalanceReserve, mu: f64) -> Self {
        let limits = |limit: fn(&Joint) -> f64| {
            let mut limits = [f64::INFINITY; JOINTS_MAX];
            limits.iter_mut().zip(&model.joints).for_each(|(slot, joint)| *slot = limit(joint));
            limits
        };
        Self {
            speeds: limits(|joint| JOINT_SPEED_MAX.min(LIMIT_SHARE * joint.velocity)),
            accelerations: limits(|joint| ACCELERATION_SHARE * joint.acceleration()),
            kinematics: Kinematics::new(model),
            balance,
            friction_acceleration: FRICTION_SHARE * mu * GRAVITY,
        }
    }

    /// Sets the time of each of a chunk's waypoints to the interval since the waypoint before it,
    /// s; 0 at the first.
    pub fn set_intervals(&self, waypoints: &mut [Waypoint], ground: &Ground) {
        let intervals = self.intervals(waypoints, ground);
        let time_scale = self.time_scale(waypoints, &intervals);
        for (waypoint, interval) in waypoints.iter_mut().zip([0.0].iter().chain(&intervals)) {
            waypoint.time = time_scale * interval;
        }
    }

    /// Does the same for a motion along polynomials of degree 5 that rests at every waypoint. There
    /// legs that swing move the zero-moment point, too.
    pub fn set_intervals_between_rests(&self, waypoints: &mut [Waypoint], ground: &Ground) {
        let centres = self.centres_of_mass(waypoints);
        let shift_max = self.shift_max(&centres, ground);
        let (displacements, shortest) =
            self.displacements_between(waypoints, (&centres, shift_max), ground.height);
        let [mut from, mut to] = [[Pose::IDENTITY; LINKS_MAX]; 2];
        for (index, waypoint) in waypoints.iter_mut().enumerate() {
            self.kinematics.forward(&waypoint.world_from_root(), &waypoint.q, &mut to);
            if let Some(before) = index.checked_sub(1) {
                let shift = self.kinematics.zero_moment_shift([&from, &to], ground.height);
                let time = rest_to_rest(&displacements[before])
                    .max(libm::sqrt(2.0 * shift / shift_max))
                    .max(shortest[before]);
                waypoint.time = POLYNOMIAL_SLOWDOWN * time;
            }
            std::mem::swap(&mut from, &mut to);
        }
    }

    /// The factor of all times with which the joints keep their limits, at least 1.
    fn time_scale(&self, waypoints: &[Waypoint], intervals: &[f64; INTERVALS_MAX]) -> f64 {
        let needed = needed_accelerations(waypoints, intervals);
        let shares = needed.iter().zip(&self.accelerations).map(|(needed, limit)| {
            // `accelerations` are `ACCELERATION_SHARE` of the limits.
            needed * ACCELERATION_SHARE / (LIMIT_SHARE * limit)
        });
        shares.fold(1.0, f64::max).sqrt()
    }

    /// The displacements from each waypoint to the next, and the shortest times (s) within the
    /// limits of speed. `centres` are the centres of mass, which may move the zero-moment point by
    /// `shift_max` (m), and `ground` is the height of the ground, m.
    fn displacements_between(
        &self,
        waypoints: &[Waypoint],
        (centres, shift_max): (&[DVec3], f64),
        ground: f64,
    ) -> ([Displacements; INTERVALS_MAX], [f64; INTERVALS_MAX]) {
        let mut displacements = [Displacements::NONE; INTERVALS_MAX];
        let mut shortest = [0.0; INTERVALS_MAX];
        for (index, pair) in waypoints.windows(2).enumerate() {
            let centres = [centres[index], centres[index + 1]];
            let height = (centres[0].z.max(centres[1].z) - ground).max(0.0);
            let acceleration = (GRAVITY * shift_max / height).min(self.friction_acceleration);
            displacements[index] = Displacements {
                joints: self.displacements(pair),
                centre: (centres[1] - centres[0]).truncate() / acceleration,
            };
            shortest[index] = self.shortest(pair);
        }
        (displacements, shortest)
    }

    /// How far a motion through these centres of mass may move the zero-moment point, m.
    fn shift_max(&self, centres: &[DVec3], ground: &Ground) -> f64 {
        let margins = centres.iter().map(|centre| ground.region.margin(centre.truncate()));
        CENTRE_SHIFT_SHARE * self.balance.of(margins.fold(f64::INFINITY, f64::min))
    }

    /// The time from each waypoint to the next, s.
    fn intervals(&self, waypoints: &[Waypoint], ground: &Ground) -> [f64; INTERVALS_MAX] {
        let centres = self.centres_of_mass(waypoints);
        let shift_max = self.shift_max(&centres, ground);
        let (displacements, shortest) =
            self.displacements_between(waypoints, (&centres, shift_max), ground.height);
        let mut times =
            std::array::from_fn(|index| shortest[index].max(rest_to_rest(&displacements[index])));
        let count = waypoints.len().saturating_sub(1);
        for sweep in 0..SWEEPS {
            for step in 0..count {
                let index = if sweep % 2 == 0 { step } else { count - 1 - step };
                times[index] =
                    shortened(&displacements[..count], &times[..count], index, shortest[index]);
            }
        }
        times
    }

    fn centres_of_mass(&self, waypoints: &[Waypoint]) -> heapless::Vec<DVec3, CHUNK_WAYPOINTS_MAX> {
        let mut links = [Pose::IDENTITY; LINKS_MAX];
        let centre = |waypoint: &Waypoint| {
            self.kinematics.forward(&waypoint.world_from_root(), &waypoint.q, &mut links);
            self.kinematics.center_of_mass(&links)
        };
        waypoints.iter().map(centre).collect()
    }

    /// The displacement of each joint in units of its largest acceleration, s2.
    fn displacements(&self, pair: &[Waypoint]) -> [f64; JOINTS_MAX] {
        std::array::from_fn(|joint| {
            (pair[1].q[joint] - pair[0].q[joint]) / self.accelerations[joint]
        })
    }

    /// The shortest time within the speed limits, s.
    fn shortest(&self, pair: &[Waypoint]) -> f64 {
        let joint = (0..JOINTS_MAX)
            .map(|joint| (pair[1].q[joint] - pair[0].q[joint]).abs() / self.speeds[joint]);
        let root =
            pair[0].world_from_root().translation.distance(pair[1].world_from_root().translation);
        joint.fold(root / ROOT_SPEED_MAX, f64::max).max(WAYPOINT_INTERVAL_MIN)
    }
}

/// The shortest time of a displacement from rest to rest, s.
fn rest_to_rest(displacements: &Displacements) -> f64 {
    let centre = displacements.centre.length();
    let largest = displacements
        .joints
        .iter()
        .fold(centre, |largest, displacement| largest.max(displacement.abs()));
    (2.0 * largest).sqrt().max(2.0 * centre / SPREAD_MAX)
}

/// The shortest time of an interval (s), not below `shortest`, for which the changes of speed at
/// both of its ends are within the limits.
fn shortened(displacements: &[Displacements], times: &[f64], index: usize, shortest: f64) -> f64 {
    if times[index] <= shortest {
        return times[index];
    }
    let fits = |time: f64| {
        let this = Some((&displacements[index], time));
        let other = |at: usize| displacements.get(at).map(|displacement| (displacement, times[at]));
        change_fits(index.checked_sub(1).and_then(other), this)
            && change_fits(this, other(index + 1))
    };
    if fits(shortest) {
        return shortest;
    }
    let (mut below, mut time) = (shortest, times[index]);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (below + time);
        if fits(middle) { time = middle } else { below = middle }
    }
    time
}

/// Whether the changes of speed at the waypoint between two intervals are within their limits.
/// `None` is rest.
fn change_fits(
    before: Option<(&Displacements, f64)>,
    after: Option<(&Displacements, f64)>,
) -> bool {
    let [(a, a_time), (b, b_time)] =
        [before, after].map(|interval| interval.unwrap_or((&Displacements::NONE, 0.0)));
    let [a_rate, b_rate] = [a_time, b_time].map(|time| if time > 0.0 { 1.0 / time } else { 0.0 });
    let largest = a
        .joints
        .iter()
        .zip(&b.joints)
        .fold(0.0, |largest: f64, (a, b)| largest.max((b * b_rate - a * a_rate).abs()));
    let centre = (b.centre * b_rate - a.centre * a_rate).length();
    let seconds = 0.5 * (a_time + b_time);
    largest <= seconds && centre <= seconds.min(SPREAD_MAX)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use bytemuck::Zeroable;
    use surefoot_shared_types::robot::load::load_robot;

    use super::*;
    use crate::geometry::convex_region::ConvexRegion;
    use crate::robot::inverse_dynamics::{InverseDynamics, LinkFrames, VELOCITY_MAX};

    const LIMIT: f64 = 5.0;

    fn timing() -> TimeParameterization {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../configs/robots/hubo/robot.toml");
        let model = load_robot(Path::new(path)).unwrap();
        TimeParameterization {
            speeds: [JOINT_SPEED_MAX; JOINTS_MAX],
            accelerations: [LIMIT; JOINTS_MAX],
            kinematics: Kinematics::new(&model),
            balance: BalanceReserve { checked_margin: 0.0, most: 1e3 },
            friction_acceleration: f64::INFINITY,
        }
    }

    /// A support region of kilometres.
    fn wide() -> ConvexRegion {
        let corners = [(-1e3, -1e3), (1e3, -1e3), (1e3, 1e3), (-1e3, 1e3)];
        ConvexRegion::hull(corners.into_iter().map(|(x, y)| DVec2::new(x, y)))
    }

    #[test]
    fn the_reserve_is_what_a_motion_keeps_beyond_the_checker() {
        let balance = BalanceReserve { checked_margin: 5e-3, most: 15e-3 };
        assert_eq!(balance.of(0.1), 15e-3);
        assert!((balance.of(9e-3) - 4e-3).abs() < 1e-15);
        assert_eq!(balance.of(4e-3), BALANCE_RESERVE_MIN);
    }

    /// Waypoints of one joint.
    fn along(positions: &[f64]) -> Vec<Waypoint> {
        let waypoint = |position: &f64| {
            let mut waypoint = Waypoint::zeroed();
            waypoint.q[3] = *position;
            waypoint
        };
        positions.iter().map(waypoint).collect()
    }

    fn timed(positions: &[f64]) -> Vec<Waypoint> {
        let mut waypoints = along(positions);
        timing().set_intervals(&mut waypoints, &Ground { height: 0.0, region: wide() });
        let end = accumulate(&mut waypoints, 2.0);
        assert_eq!((waypoints[0].time, waypoints.last().unwrap().time), (2.0, end));
        waypoints
    }

    /// The largest acceleration, with rest at both ends, rad/s2.
    fn largest_acceleration(waypoints: &[Waypoint]) -> f64 {
        let mut before = (0.0, 0.0);
        let mut largest: f64 = 0.0;
        let intervals = waypoints
            .windows(2)
            .map(|pair| (pair[1].time - pair[0].time, pair[1].q[3] - pair[0].q[3]));
        for (seconds, displacement) in intervals
            .map(|(seconds, displacement)| (seconds, displacement / seconds))
            .chain([(0.0, 0.0)])
        {
            largest = largest.max((displacement - before.1).abs() / (0.5 * (seconds + before.0)));
            before = (seconds, displacement);
        }
        largest
    }

    #[test]
    fn a_single_displacement_takes_the_time_to_start_and_stop() {
        let waypoints = timed(&[0.0, 0.01]);
        assert!(
            (waypoints[1].time - waypoints[0].time - (2.0 * 0.01 / LIMIT).sqrt()).abs() < 1e-12
        );
    }

    #[test]
    fn a_long_displacement_reaches_full_speed_and_brakes() {
        let positions: Vec<f64> = (0..=INTERVALS_MAX).map(|index| 0.01 * index as f64).collect();
        let waypoints = timed(&positions);
        assert!(largest_acceleration(&waypoints) <= LIMIT * (1.0 + 1e-9));
        let speed = |at: usize| 0.01 / (waypoints[at + 1].time - waypoints[at].time);
        assert!((speed(INTERVALS_MAX / 2) - JOINT_SPEED_MAX).abs() < 1e-9);
        assert!(
            speed(0) < 0.5 * JOINT_SPEED_MAX && speed(INTERVALS_MAX - 1) < 0.5 * JOINT_SPEED_MAX
        );
        let at_full_speed = INTERVALS_MAX as f64 * 0.01 / JOINT_SPEED_MAX;
        assert!(waypoints[INTERVALS_MAX].time - waypoints[0].time < 1.2 * at_full_speed);
    }

    #[test]
    fn reversals_short_displacements_and_pauses_keep_the_limits() {
        let mut positions = vec![0.0];
        for step in
            [0.03, -0.03, 0.0, 1e-5, 0.035, 1e-4, -0.02, 0.0, 0.0, 0.04, 0.04, 1e-9, 0.04, -0.001]
        {
            positions.push(positions.last().unwrap() + step);
        }
        let waypoints = timed(&positions);
        assert!(
            largest_acceleration(&waypoints) <= LIMIT * (1.0 + 1e-9),
            "{}",
            largest_acceleration(&waypoints)
        );
        assert!(
            waypoints
                .windows(2)
                .all(|pair| pair[1].time - pair[0].time >= WAYPOINT_INTERVAL_MIN - 1e-12)
        );
    }

    /// The largest acceleration of the centre of mass, 1 m over the ground, on half a metre
    /// forwards and half a metre to the side, m/s2.
    fn acceleration_of_a_corner(timing: &TimeParameterization) -> f64 {
        let mut waypoints = vec![Waypoint::zeroed()];
        for step in 1..=20 {
            let mut waypoint = waypoints[step - 1];
            waypoint.root_position[usize::from(step > 10)] += 0.05;
            waypoints.push(waypoint);
        }
        waypoints.iter_mut().for_each(|waypoint| waypoint.root_rotation = [0.0, 0.0, 0.0, 1.0]);
        let mut links = [Pose::IDENTITY; LINKS_MAX];
        timing.kinematics.forward(&Pose::IDENTITY, &[0.0; JOINTS_MAX], &mut links);
        let height = timing.kinematics.center_of_mass(&links).z;
        timing.set_intervals(&mut waypoints, &Ground { height: height - 1.0, region: wide() });
        let speed = |pair: &[Waypoint]| {
            let [a, b] = [0, 1].map(|end| DVec2::from_slice(&pair[end].root_position));
            (b - a) / pair[1].time
        };
        let (mut before, mut largest) = ((DVec2::ZERO, 0.0), 0.0_f64);
        for pair in waypoints.windows(2) {
            let here = (speed(pair), pair[1].time);
            let spread = (0.5 * (before.1 + here.1)).min(SPREAD_MAX);
            largest = largest.max((here.0 - before.0).length() / spread);
            before = here;
        }
        largest
    }

    #[test]
    fn the_centre_of_mass_accelerates_gently() {
        let shift = 0.01;
        let balance = BalanceReserve { checked_margin: 0.0, most: shift / CENTRE_SHIFT_SHARE };
        let timing = TimeParameterization { balance, ..timing() };
        let acceleration = acceleration_of_a_corner(&timing);
        assert!(acceleration <= GRAVITY * shift * (1.0 + 1e-9), "{acceleration}");
        let friction_acceleration = 0.2 * GRAVITY * shift;
        let slick = TimeParameterization { friction_acceleration, ..timing };
        let slower = acceleration_of_a_corner(&slick);
        assert!(slower <= friction_acceleration * (1.0 + 1e-9), "{slower}");
        assert!(slower > 0.1 * acceleration, "{slower} {acceleration}");
    }

    /// The zero-moment point on the ground at `ground` (m), for a root at the origin that does not
    /// move and these accelerations of the joints, m.
    fn zero_moment_point(q: &[f64; JOINTS_MAX], a: &[f64; VELOCITY_MAX], ground: f64) -> DVec2 {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../configs/robots/hubo/robot.toml");
        let dynamics = InverseDynamics::new(&load_robot(Path::new(path)).unwrap());
        let mut frames = LinkFrames::default();
        dynamics.place(&Pose::IDENTITY, q, &mut frames);
        let load = dynamics.effort(&frames, &[0.0; VELOCITY_MAX], a, GRAVITY);
        let moment = load.moment + DVec3::new(0.0, 0.0, -ground).cross(load.force);
        DVec2::new(-moment.y, moment.x) / load.force.z
    }

    #[test]
    fn a_leg_that_swings_moves_the_zero_moment_point_as_far_as_allowed() {
        const HIP_ROLL: usize = 2;
        let (shift, ground, way) = (0.01, -0.8, 0.02);
        let balance = BalanceReserve { checked_margin: 0.0, most: shift / CENTRE_SHIFT_SHARE };
        let accelerations = [f64::INFINITY; JOINTS_MAX];
        let timing = TimeParameterization { balance, accelerations, ..timing() };
        let mut waypoints = vec![Waypoint::zeroed(); 2];
        waypoints[1].q[HIP_ROLL] = way;
        waypoints.iter_mut().for_each(|waypoint| waypoint.root_rotation = [0.0, 0.0, 0.0, 1.0]);
        timing.set_intervals_between_rests(
            &mut waypoints,
            &Ground { height: ground, region: wide() },
        );
        // The largest acceleration of a polynomial of degree 5 from rest to rest.
        let largest = 10.0 / 3f64.sqrt() * way / waypoints[1].time.powi(2);
        let mut a = [0.0; VELOCITY_MAX];
        a[6 + HIP_ROLL] = largest;
        let q = waypoints[0].q;
        let at_rest = zero_moment_point(&q, &[0.0; VELOCITY_MAX], ground);
        let moved = at_rest.distance(zero_moment_point(&q, &a, ground));
        assert!(moved > 0.8 * shift && moved < 1.01 * shift, "{moved} m");
    }

    #[test]
    fn one_waypoint_takes_no_time() {
        assert_eq!(timed(&[0.5])[0].time, 2.0);
    }
}
