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
//! the height of the centre of mass. A change of its speed counts as spread over at most
//! [`SPREAD_MAX`]. At last all times are stretched until joints that pass the waypoints with a
//! continuous speed keep their limits.

use glam::{DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::{CHUNK_WAYPOINTS_MAX, JOINTS_MAX};
use surefoot_shared_types::message::Waypoint;
use surefoot_shared_types::robot::model::{Joint, RobotModel};
use surefoot_shared_types::world::world::GRAVITY;

use crate::geometry::convex_region::ConvexRegion;
use crate::kinematics::forward::Kinematics;
use crate::plan::joint_acceleration::needed_accelerations;
use crate::plan::tuning::{
    ACCELERATION_SHARE, CENTRE_SHIFT_MIN, CENTRE_SHIFT_SHARE, HALVINGS, JOINT_SPEED_MAX,
    LIMIT_SHARE, ROOT_SPEED_MAX, SPREAD_MAX, SWEEPS, WAYPOINT_INTERVAL_MIN,
};
use crate::robot::mechanism::LINKS_MAX;

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
    /// How far an acceleration may move the zero-moment point, m.
    zero_moment_shift_max: f64,
    /// How far inside the support the checker requires the zero-moment point, m.
    com_margin: f64,
}

/// What carries the robot in a chunk.
#[derive(Debug)]
pub struct Support {
    /// The mean height of the feet, m.
    pub height: f64,
    /// The hull of the contacts, seen from above.
    pub region: ConvexRegion,
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
    /// The limits of a robot whose centre of mass the planner keeps `planned` (m) inside the
    /// support, where there is so much, and whose zero-moment point the checker requires `checked`
    /// (m) inside it.
    pub fn new(model: &RobotModel, planned: f64, checked: f64) -> Self {
        let limits = |limit: fn(&Joint) -> f64| {
            let mut limits = [f64::INFINITY; JOINTS_MAX];
            limits.iter_mut().zip(&model.joints).for_each(|(slot, joint)| *slot = limit(joint));
            limits
        };
        Self {
            speeds: limits(|joint| JOINT_SPEED_MAX.min(LIMIT_SHARE * joint.velocity)),
            accelerations: limits(|joint| ACCELERATION_SHARE * joint.acceleration),
            kinematics: Kinematics::new(model),
            zero_moment_shift_max: CENTRE_SHIFT_SHARE * (planned - checked),
            com_margin: checked,
        }
    }

    /// Sets the time of each of a chunk's waypoints to the interval since the waypoint before it,
    /// s; 0 at the first.
    pub fn set_intervals(&self, waypoints: &mut [Waypoint], support: &Support) {
        let intervals = self.intervals(waypoints, support);
        let time_scale = self.time_scale(waypoints, &intervals);
        for (waypoint, interval) in waypoints.iter_mut().zip([0.0].iter().chain(&intervals)) {
            waypoint.time = time_scale * interval;
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

    /// The time from each waypoint to the next, s.
    fn intervals(&self, waypoints: &[Waypoint], support: &Support) -> [f64; INTERVALS_MAX] {
        let mut displacements = [Displacements::NONE; INTERVALS_MAX];
        let (mut shortest, mut times) = ([0.0; INTERVALS_MAX], [0.0; INTERVALS_MAX]);
        let centres = self.centres(waypoints);
        let acceleration = self.centre_acceleration(&centres[..waypoints.len()], support);
        for (index, pair) in waypoints.windows(2).enumerate() {
            displacements[index] = Displacements {
                joints: self.displacements(pair),
                centre: (centres[index + 1] - centres[index]).truncate() / acceleration,
            };
            shortest[index] = self.shortest(pair);
            times[index] = shortest[index].max(rest_to_rest(&displacements[index]));
        }
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

    /// The centre of mass at each waypoint.
    fn centres(&self, waypoints: &[Waypoint]) -> [DVec3; CHUNK_WAYPOINTS_MAX] {
        let mut links = [Pose::IDENTITY; LINKS_MAX];
        let mut centres = [DVec3::ZERO; CHUNK_WAYPOINTS_MAX];
        for (centre, waypoint) in centres.iter_mut().zip(waypoints) {
            self.kinematics.forward(&waypoint.world_from_root(), &waypoint.q, &mut links);
            *centre = self.kinematics.center_of_mass(&links);
        }
        centres
    }

    /// The acceleration that moves the zero-moment point no further than the smallest margin of the
    /// centres of mass allows, m/s2.
    fn centre_acceleration(&self, centres: &[DVec3], support: &Support) -> f64 {
        let (mut margin, mut height) = (f64::INFINITY, 0.0f64);
        for centre in centres {
            margin = margin.min(support.region.margin(centre.truncate()));
            height = height.max(centre.z - support.height);
        }
        let spare = CENTRE_SHIFT_SHARE * (margin - self.com_margin);
        let shift = spare.min(self.zero_moment_shift_max).max(CENTRE_SHIFT_MIN);
        GRAVITY * shift / height
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

    const LIMIT: f64 = 5.0;

    fn timing() -> TimeParameterization {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../configs/robots/hubo/robot.toml");
        let model = load_robot(Path::new(path)).unwrap();
        TimeParameterization {
            speeds: [JOINT_SPEED_MAX; JOINTS_MAX],
            accelerations: [LIMIT; JOINTS_MAX],
            kinematics: Kinematics::new(&model),
            zero_moment_shift_max: f64::INFINITY,
            com_margin: 0.0,
        }
    }

    /// A square of 20 m on the ground, `depth` (m) below the world's origin.
    fn support(depth: f64) -> Support {
        let corners = [(-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0)];
        Support { height: -depth, region: ConvexRegion::hull(corners.map(DVec2::from)) }
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
        timing().set_intervals(&mut waypoints, &support(1.0));
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

    #[test]
    fn the_centre_of_mass_accelerates_gently() {
        let shift = 0.01;
        let timing = TimeParameterization { zero_moment_shift_max: shift, ..timing() };
        // Half a metre forwards, then to the side, at a height of 1 m over the ground.
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
        timing.set_intervals(&mut waypoints, &support(1.0 - height));
        let acceleration_max = GRAVITY * shift;
        let speed = |pair: &[Waypoint]| {
            let [a, b] = [0, 1].map(|end| DVec2::from_slice(&pair[end].root_position));
            (b - a) / pair[1].time
        };
        let mut before = (DVec2::ZERO, 0.0);
        for pair in waypoints.windows(2) {
            let here = (speed(pair), pair[1].time);
            let spread = (0.5 * (before.1 + here.1)).min(SPREAD_MAX);
            let acceleration = (here.0 - before.0).length() / spread;
            assert!(acceleration <= acceleration_max * (1.0 + 1e-9), "{acceleration}");
            before = here;
        }
    }

    #[test]
    fn one_waypoint_takes_no_time() {
        assert_eq!(timed(&[0.5])[0].time, 2.0);
    }
}
