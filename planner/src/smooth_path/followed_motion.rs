//! A spline along the searched motion of a phase: where the curve of the whole plan violates a
//! constraint, the robot follows the motion that was found, rounded at its waypoints, from rest to
//! rest.

use glam::{DQuat, DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::base::spatial::{rotation_from_scaled_axis, scaled_axis_from_rotation};

use crate::base::arena::reserve;
use crate::robot::configuration::{Configuration, midway};
use crate::robot::kinematic_state::KinematicState;
use crate::robot::mechanism::Mechanism;
use crate::smooth_path::followed_trial::{FOLLOWED_TRIALS, FollowedKind, FollowedTrial};
use crate::smooth_path::searched_motion::SearchedPhase;
use crate::smooth_path::spline::{around, end_weights};
use crate::smooth_path::tuning::{
    FOLLOWED_DENSITY, FOLLOWED_KEYS_MAX, FOLLOWED_KEYS_MIN, FOLLOWED_NEAR_DISTANCE, INTERVALS_MAX,
    INTERVALS_MIN, REFINEMENTS_MAX,
};

/// A configuration of the searched motion, as a key of the spline.
#[derive(Debug, Clone, Copy)]
struct FollowedKey {
    configuration: Configuration,
    com: DVec2,
    world_from_soles: [Pose; 2],
    /// Whether it belongs to the lift-off or the landing of the searched motion.
    lifts_off: bool,
}

/// What the configuration at a place of the spline aims at.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FollowedTarget {
    /// The centre of mass in world x and y, m.
    pub com: DVec2,
    /// The poses of both soles.
    pub world_from_soles: [Pose; 2],
}

/// The spline along one motion; key `i` is at place `i`.
#[derive(Debug)]
pub(crate) struct FollowedMotion {
    keys: Vec<FollowedKey>,
    kind: FollowedKind,
    /// Number of intervals between the points of the phase.
    intervals: usize,
    state: KinematicState,
}

impl FollowedMotion {
    /// Reserves memory.
    pub fn new() -> Self {
        Self {
            keys: reserve((FOLLOWED_KEYS_MAX << REFINEMENTS_MAX) + 1),
            kind: FollowedKind::Soles,
            intervals: INTERVALS_MIN,
            state: KinematicState::default(),
        }
    }

    /// Takes the motion of a phase, at even places between its waypoints, in the way of one of
    /// [`FOLLOWED_TRIALS`]. With more keys the spline comes nearer to the motion, with fewer it is
    /// shorter. The soles of feet that stand keep the poses in `stance`.
    pub fn begin(
        &mut self,
        robot: &Mechanism,
        searched: &SearchedPhase<'_>,
        stance: [Option<Pose>; 2],
        trial: u8,
    ) {
        let FollowedTrial { coarsenings, refinements, kind } = FOLLOWED_TRIALS[usize::from(trial)];
        self.kind = kind;
        self.keys.clear();
        let waypoints = searched.len();
        let lift_off = searched.lift_offs();
        let count = waypoints.clamp(FOLLOWED_KEYS_MIN, FOLLOWED_KEYS_MAX) << refinements;
        for index in 0..=count {
            let at = (index * waypoints) as f64 / count as f64;
            let before = (libm::floor(at) as usize).min(waypoints.saturating_sub(1));
            let Some((_, [from, to])) = searched.pair(before) else { return };
            let configuration = match at - before as f64 {
                0.0 => from,
                1.0 => to,
                fraction => midway(&from, &to, fraction),
            };
            self.state.update(robot, &configuration);
            let soles =
                [0, 1].map(|limb| stance[limb].unwrap_or(self.state.world_from_sole(robot, limb)));
            let com = self.state.com.truncate();
            let lifts_off = at <= lift_off[0] as f64 || at >= lift_off[1] as f64;
            self.keys.push(FollowedKey { configuration, com, world_from_soles: soles, lifts_off });
        }
        self.intervals = (FOLLOWED_DENSITY * self.end()).clamp(INTERVALS_MIN, INTERVALS_MAX);
        self.coarsen(coarsenings);
    }

    /// Keeps one of `2^coarsenings` keys where the swing foot is far from its footholds.
    fn coarsen(&mut self, coarsenings: u8) {
        let last = self.end();
        let (mut kept, mut left_out) = (1, 0);
        for index in 1..=last {
            left_out += 1;
            if index == last || left_out >= 1 << coarsenings || self.is_near_foothold(index) {
                self.keys[kept] = self.keys[index];
                (kept, left_out) = (kept + 1, 0);
            }
        }
        self.keys.truncate(kept);
    }

    /// Whether the swing foot lifts off or lands at a key, or is about to.
    fn is_near_foothold(&self, index: usize) -> bool {
        let here = &self.keys[index];
        let is_near = |end: usize| {
            let there = &self.keys[end].world_from_soles;
            let soles = here.world_from_soles.iter().zip(there);
            soles
                .map(|(here, there)| here.translation.distance(there.translation))
                .all(|way| way < FOLLOWED_NEAR_DISTANCE)
        };
        here.lifts_off || is_near(0) || is_near(self.end())
    }

    /// Number of intervals between the points of the phase.
    pub fn intervals(&self) -> usize {
        self.intervals
    }

    /// The place at which the spline ends.
    pub fn end(&self) -> usize {
        self.keys.len().saturating_sub(1)
    }

    /// Distance (m) of the soles from the nearer end of the motion, along the ground there: on
    /// inclined ground a foot that lifts off along its sole's normal moves aside, too. It is 0
    /// where the searched motion lifts off or lands, which may lead aside, too.
    pub fn distance_aside(&self, place: f64) -> f64 {
        let [at, next] =
            [libm::floor, libm::ceil].map(|to| (to(place.max(0.0)) as usize).min(self.end()));
        if self.keys[at].lifts_off && self.keys[next].lifts_off {
            return 0.0;
        }
        let from = |end: usize| {
            let [here, there] = [at, end].map(|index| &self.keys[index].world_from_soles);
            let aside = |limb: usize| {
                let shift = there[limb].inverse() * here[limb].translation;
                shift.truncate().length()
            };
            aside(0).max(aside(1))
        };
        from(0).min(from(self.end()))
    }

    /// What the spline is a spline of.
    pub fn kind(&self) -> FollowedKind {
        self.kind
    }

    /// The keys around a place, with their weights.
    fn around(&self, place: f64) -> ([&FollowedKey; 4], [f64; 4]) {
        let last = self.end() - 1;
        let interval = (libm::floor(place) as usize).min(last);
        let weights = end_weights(place - interval as f64, interval == 0, interval == last);
        (around(&self.keys, interval), weights)
    }

    /// The root and all joints at a place.
    pub fn configuration(&self, place: f64) -> Configuration {
        let (around, weights) = self.around(place);
        let mut q = [0.0; JOINTS_MAX];
        for (key, weight) in around.iter().zip(weights) {
            q.iter_mut().zip(&key.configuration.q).for_each(|(sum, q)| *sum += weight * q);
        }
        let roots = around.map(|key| key.configuration.world_from_root);
        Configuration { world_from_root: mean_pose(roots, weights), q }
    }

    /// The height and the rotation of the root and the free joints at a place, written into
    /// `configuration`, and what else the configuration aims at.
    pub fn pose(
        &self,
        robot: &Mechanism,
        place: f64,
        configuration: &mut Configuration,
    ) -> FollowedTarget {
        let (around, weights) = self.around(place);
        let sum = |value: &dyn Fn(&FollowedKey) -> f64| -> f64 {
            around.iter().zip(weights).map(|(key, weight)| weight * value(key)).sum()
        };
        let root = &mut configuration.world_from_root;
        root.translation.z = sum(&|key| key.configuration.world_from_root.translation.z);
        root.rotation =
            mean_rotation(around.map(|key| key.configuration.world_from_root.rotation), weights);
        for joint in &robot.free_joints {
            configuration.q[joint.index] = sum(&|key| key.configuration.q[joint.index]);
        }
        let world_from_soles =
            [0, 1].map(|limb| mean_pose(around.map(|key| key.world_from_soles[limb]), weights));
        let com = around.iter().zip(weights).map(|(key, weight)| key.com * weight).sum();
        FollowedTarget { com, world_from_soles }
    }
}

/// The weighted mean of near poses.
fn mean_pose(poses: [Pose; 4], weights: [f64; 4]) -> Pose {
    let position: DVec3 =
        poses.iter().zip(weights).map(|(pose, weight)| pose.translation * weight).sum();
    Pose::from_parts(position, mean_rotation(poses.map(|pose| pose.rotation), weights))
}

/// The weighted mean of near rotations, by their rotation vectors from the second one.
fn mean_rotation(rotations: [DQuat; 4], weights: [f64; 4]) -> DQuat {
    let first = rotations[1];
    let turns = rotations.iter().zip(weights).map(|(rotation, weight)| {
        scaled_axis_from_rotation(first.conjugate() * *rotation) * weight
    });
    (first * rotation_from_scaled_axis(turns.sum())).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spline_of_joints_passes_both_ends_and_stays_among_its_keys() {
        let key = |index: usize| {
            let wave = libm::sin(1.7 * index as f64);
            let position = DVec3::new(0.02 * index as f64, wave, 0.0);
            let rotation = rotation_from_scaled_axis(DVec3::new(0.1 * wave, 0.0, 0.2));
            let mut q = [0.0; JOINTS_MAX];
            q[3] = if index < 2 { 0.0 } else { wave.abs() };
            let world_from_root = Pose::from_parts(position, rotation);
            FollowedKey {
                configuration: Configuration { world_from_root, q },
                com: DVec2::ZERO,
                world_from_soles: [Pose::IDENTITY; 2],
                lifts_off: false,
            }
        };
        let mut motion = FollowedMotion::new();
        motion.kind = FollowedKind::Joints;
        motion.keys.extend((0..7).map(key));
        for end in [0, motion.end()] {
            let [at, given] = [motion.configuration(end as f64), key(end).configuration];
            let apart = at.world_from_root.translation - given.world_from_root.translation;
            assert!(apart.length() < 1e-12 && (at.q[3] - given.q[3]).abs() < 1e-12);
        }
        let (step, places) = (1e-3, 6_000);
        let at = |index: i32| motion.configuration(step * f64::from(index));
        for index in 1..places {
            let [before, here, after] = [-1, 0, 1].map(|shift| at(index + shift));
            assert!((0.0..=1.0).contains(&here.q[3]), "a limit of a joint at {index}");
            let bend = before.q[3] - 2.0 * here.q[3] + after.q[3];
            assert!(bend.abs() < 3.0 * step * step, "{index}: {bend}");
        }
    }

    #[test]
    fn keys_are_left_out_far_from_the_footholds_only() {
        let mut motion = FollowedMotion::new();
        motion.keys.extend((0..=40).map(|index| {
            let swing = DVec3::new(0.01 * f64::from(index), 0.0, 0.0);
            FollowedKey {
                configuration: Configuration {
                    world_from_root: Pose::IDENTITY,
                    q: [0.0; JOINTS_MAX],
                },
                com: DVec2::ZERO,
                world_from_soles: [Pose::IDENTITY, Pose::from_translation(swing)],
                lifts_off: index <= 3 || index >= 36,
            }
        }));
        motion.coarsen(2);
        let places = motion.keys.iter().map(|key| 100.0 * key.world_from_soles[1].translation.x);
        let kept: Vec<i32> = places.map(|place| libm::round(place) as i32).collect();
        assert_eq!(kept, [0, 1, 2, 3, 7, 11, 15, 19, 23, 27, 31, 35, 36, 37, 38, 39, 40]);
        assert_eq!(motion.distance_aside(2.5), 0.0, "it lifts off");
        assert!(motion.distance_aside(3.5) > 0.02);
    }
}
