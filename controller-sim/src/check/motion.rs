//! A segment's motion, sampled finely enough to check it between its waypoints.

use glam::DVec3;
use surefoot_shared_types::base::spatial::rotation_distance;
use surefoot_shared_types::message::Waypoint;
use surefoot_shared_types::robot::model::RobotModel;

use crate::base::comparison::largest;
use crate::check::tuning::SUBSTEP_MAX;
use crate::kinematics::forward::{Configuration, Posture};

/// A configuration of the motion, with its posture and centre of mass.
pub struct Sample {
    /// The waypoint at or before it.
    pub waypoint: usize,
    /// The poses of all links.
    pub posture: Posture,
    /// The centre of mass in the world.
    pub centre_of_mass: DVec3,
    /// Its index after its waypoint; 0 is the waypoint itself.
    pub substep: usize,
}

impl Sample {
    /// Whether it is a waypoint itself.
    pub fn is_waypoint(&self) -> bool {
        self.substep == 0
    }
}

/// The size of a motion from one configuration to another.
pub struct Change {
    /// Root displacement, m.
    pub root_position: f64,
    /// Root rotation, rad.
    pub root_rotation: f64,
    /// Absolute change of each joint, rad or m.
    pub joints: Vec<f64>,
}

impl Change {
    /// The change between two configurations.
    pub fn between(a: &Configuration, b: &Configuration) -> Self {
        Self {
            root_position: a.world_from_root.translation.distance(b.world_from_root.translation),
            root_rotation: rotation_distance(
                a.world_from_root.rotation,
                b.world_from_root.rotation,
            ),
            joints: a.q.iter().zip(&b.q).map(|(x, y)| (x - y).abs()).collect(),
        }
    }

    /// The largest of these numbers; NaN if one of them is NaN.
    pub fn largest(&self) -> f64 {
        largest(self.joints.iter().copied().chain([self.root_position, self.root_rotation]))
    }
}

/// Proof that the steps of a segment are bounded: the change over each step.
pub struct Spacing {
    /// One change per pair of successive waypoints.
    pub changes: Vec<Change>,
}

/// A segment's motion.
pub struct SampledMotion {
    /// The waypoints' configurations.
    pub configurations: Vec<Configuration>,
    /// Samples from the first waypoint to the last, every waypoint among them.
    pub samples: Vec<Sample>,
}

impl SampledMotion {
    /// A motion without samples.
    pub const EMPTY: Self = Self { configurations: Vec::new(), samples: Vec::new() };

    /// Samples a motion whose spacing is known to be bounded.
    pub fn new(model: &RobotModel, waypoints: &[Waypoint], Spacing { changes }: Spacing) -> Self {
        let configurations: Vec<_> = waypoints
            .iter()
            .map(|waypoint| Configuration::of_waypoint(waypoint, model.joints.len()))
            .collect();
        let mut samples = Vec::new();
        for (index, start) in configurations.iter().enumerate() {
            let substeps = changes
                .get(index)
                .map_or(1, |change| ((change.largest() / SUBSTEP_MAX).ceil() as usize).max(1));
            for substep in 0..substeps {
                let configuration = match configurations.get(index + 1) {
                    Some(end) if substep > 0 => {
                        start.towards(end, substep as f64 / substeps as f64)
                    }
                    _ => start.clone(),
                };
                let posture = Posture::new(model, &configuration);
                let centre_of_mass = posture.centre_of_mass(model);
                samples.push(Sample { waypoint: index, posture, centre_of_mass, substep });
            }
        }
        Self { configurations, samples }
    }
}

#[cfg(test)]
mod tests {
    use crate::check_robot::{robot, waypoint};

    use super::*;

    #[test]
    fn samples_are_evenly_spaced_and_no_more_than_needed() {
        let model = robot();
        let waypoints =
            [waypoint(0.0, 0.0, 0.0), waypoint(1.0, 0.045, -0.02), waypoint(2.0, 0.045, -0.02)];
        let configurations =
            waypoints.each_ref().map(|waypoint| Configuration::of_waypoint(waypoint, 4));
        let changes = configurations.windows(2).map(|pair| Change::between(&pair[0], &pair[1]));
        let spacing = Spacing { changes: changes.collect() };
        let motion = SampledMotion::new(&model, &waypoints, spacing);
        let places: Vec<(usize, usize)> =
            motion.samples.iter().map(|sample| (sample.waypoint, sample.substep)).collect();
        assert_eq!(places, [(0, 0), (0, 1), (0, 2), (0, 3), (0, 4), (1, 0), (2, 0)]);
        assert!(motion.samples[0].is_waypoint() && !motion.samples[1].is_waypoint());
        for sample in &motion.samples[..5] {
            let part = sample.substep as f64 / 5.0;
            let expected = configurations[0].towards(&configurations[1], part);
            assert_eq!(sample.posture, Posture::new(&model, &expected));
        }
    }

    #[test]
    fn the_size_of_a_change_is_its_largest_part() {
        let change = |root_position: f64, root_rotation: f64, joints: [f64; 2]| Change {
            root_position,
            root_rotation,
            joints: joints.to_vec(),
        };
        assert_eq!(change(0.1, 0.2, [0.3, 0.05]).largest(), 0.3);
        assert_eq!(change(0.5, 0.2, [0.3, 0.05]).largest(), 0.5);
        assert_eq!(change(0.1, 0.4, [0.3, 0.05]).largest(), 0.4);
        assert!(change(0.1, f64::NAN, [0.3, 0.05]).largest().is_nan());
    }
}
