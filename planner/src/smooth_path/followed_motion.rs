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
use crate::smooth_path::tuning::{FOLLOWED_KEYS_MAX, FOLLOWED_KEYS_MIN, REFINEMENTS_MAX};

/// A configuration of the searched motion, as a key of the spline.
#[derive(Debug, Clone, Copy)]
struct FollowedKey {
    configuration: Configuration,
    com: DVec2,
    world_from_soles: [Pose; 2],
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
    state: KinematicState,
}

impl FollowedMotion {
    /// Reserves memory.
    pub fn new() -> Self {
        Self {
            keys: reserve((FOLLOWED_KEYS_MAX << REFINEMENTS_MAX) + 1),
            kind: FollowedKind::Soles,
            state: KinematicState::default(),
        }
    }

    /// Takes the motion of a phase, at even places between its waypoints, in the way of one of
    /// [`FOLLOWED_TRIALS`]. With more keys the spline comes nearer to the motion. The soles of feet
    /// that stand keep the poses in `stance`.
    pub fn begin(
        &mut self,
        robot: &Mechanism,
        searched: &SearchedPhase<'_>,
        stance: [Option<Pose>; 2],
        trial: u8,
    ) {
        let FollowedTrial { refinements, kind } = FOLLOWED_TRIALS[usize::from(trial)];
        self.kind = kind;
        self.keys.clear();
        let waypoints = searched.len();
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
            self.keys.push(FollowedKey { configuration, com, world_from_soles: soles });
        }
    }

    /// The place at which the spline ends.
    pub fn end(&self) -> usize {
        self.keys.len().saturating_sub(1)
    }

    /// Distance (m) of the soles from the nearer end of the motion, along the ground there: on
    /// inclined ground a foot that lifts off along its sole's normal moves aside, too.
    pub fn distance_aside(&self, place: f64) -> f64 {
        let at = (libm::floor(place.max(0.0)) as usize).min(self.end());
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
}
