//! A spline along the searched motion of a phase: where the curve of the whole plan violates a
//! constraint, the robot follows the motion that was found, rounded at its waypoints, from rest to
//! rest.

use glam::{DQuat, DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{rotation_from_scaled_axis, scaled_axis_from_rotation};

use crate::base::arena::reserve;
use crate::robot::configuration::{Configuration, midway};
use crate::robot::kinematic_state::KinematicState;
use crate::robot::mechanism::Mechanism;
use crate::smooth_path::limit_slack::{Kept, RootOffset};
use crate::smooth_path::searched_motion::SearchedPhase;
use crate::smooth_path::spline::{around, end_weights};
use crate::smooth_path::tuning::{
    FOLLOWED_KEYS_MAX, FOLLOWED_KEYS_MIN, FOLLOWED_TRIALS, REFINEMENTS_MAX, SLACK_KEYS,
};

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
    state: KinematicState,
}

impl FollowedMotion {
    /// Reserves memory.
    pub fn new() -> Self {
        Self {
            keys: reserve((FOLLOWED_KEYS_MAX << REFINEMENTS_MAX) + 1),
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
        let (refinements, is_inside) = FOLLOWED_TRIALS[usize::from(trial)];
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
        if is_inside {
            self.move_inside(robot);
        }
    }

    /// Moves the keys between both ends away from the limits of the legs' joints, beyond which the
    /// spline may lead where the searched motion runs along them.
    fn move_inside(&mut self, robot: &Mechanism) {
        let Self { keys, state } = self;
        let end = keys.len().saturating_sub(1);
        let mut offset = RootOffset::default();
        for (index, key) in keys.iter_mut().enumerate().take(end).skip(1) {
            let FollowedKey { configuration, com, world_from_soles } = key;
            let kept = Kept { com: *com, world_from_soles };
            offset = kept.offset_inside(robot, configuration, offset, state);
            let share = (index.min(end - index) as f64 / SLACK_KEYS as f64).min(1.0);
            if let Some(moved) = kept.with(robot, configuration, offset.scaled(share), state) {
                *configuration = moved;
            }
        }
    }

    /// The place at which the spline ends.
    pub fn end(&self) -> usize {
        self.keys.len().saturating_sub(1)
    }

    /// Horizontal distance (m) of the soles from the nearer end of the motion.
    pub fn distance_aside(&self, place: f64) -> f64 {
        let at = (libm::floor(place.max(0.0)) as usize).min(self.end());
        let from = |end: usize| {
            let [here, there] = [at, end].map(|index| &self.keys[index].world_from_soles);
            let aside = |limb: usize| {
                let shift = here[limb].translation - there[limb].translation;
                shift.truncate().length()
            };
            aside(0).max(aside(1))
        };
        from(0).min(from(self.end()))
    }

    /// The height and the rotation of the root and the free joints at a place, written into
    /// `configuration`, and what else the configuration aims at.
    pub fn pose(
        &self,
        robot: &Mechanism,
        place: f64,
        configuration: &mut Configuration,
    ) -> FollowedTarget {
        let last = self.end() - 1;
        let interval = (libm::floor(place) as usize).min(last);
        let weights = end_weights(place - interval as f64, interval == 0, interval == last);
        let around = around(&self.keys, interval);
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
        let world_from_soles = [0, 1].map(|limb| {
            let poses = around.map(|key| key.world_from_soles[limb]);
            let position: DVec3 =
                poses.iter().zip(weights).map(|(pose, weight)| pose.translation * weight).sum();
            Pose::from_parts(position, mean_rotation(poses.map(|pose| pose.rotation), weights))
        });
        let com = around.iter().zip(weights).map(|(key, weight)| key.com * weight).sum();
        FollowedTarget { com, world_from_soles }
    }
}

/// The weighted mean of near rotations, by their rotation vectors from the second one.
fn mean_rotation(rotations: [DQuat; 4], weights: [f64; 4]) -> DQuat {
    let first = rotations[1];
    let turns = rotations.iter().zip(weights).map(|(rotation, weight)| {
        scaled_axis_from_rotation(first.conjugate() * *rotation) * weight
    });
    (first * rotation_from_scaled_axis(turns.sum())).normalize()
}
