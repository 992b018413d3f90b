//! The centre of mass and the angular momentum of a motion of straight lines, over its time.

use glam::DVec3;
use surefoot_shared_types::base::spatial::scaled_axis_from_rotation;
use surefoot_shared_types::robot::model::RobotModel;

use crate::check::motion::Sample;
use crate::check::segment::Case;

/// The robot as a whole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Whole {
    /// The centre of mass, m.
    pub(super) centre: DVec3,
    /// The angular momentum about it since the beginning, added up over time, by mass, m2.
    pub(super) turned: DVec3,
}

impl Whole {
    fn lerp(self, other: Self, share: f64) -> Self {
        Self {
            centre: self.centre.lerp(other.centre, share),
            turned: self.turned.lerp(other.turned, share),
        }
    }
}

/// The robot as a whole at the waypoints, each with its time.
pub(super) struct CentreTrack(pub(super) Vec<(f64, Whole)>);

impl CentreTrack {
    pub(super) fn new(model: &RobotModel, case: &Case) -> Self {
        let samples = case.motion.samples.iter().filter(|sample| sample.is_waypoint());
        let mut before: Option<&Sample> = None;
        let mut turned = DVec3::ZERO;
        let track = case.waypoints.iter().zip(samples).map(|(waypoint, sample)| {
            turned += before.map_or(DVec3::ZERO, |before| turned_between(model, before, sample));
            before = Some(sample);
            (waypoint.time, Whole { centre: sample.centre_of_mass, turned })
        });
        Self(track.collect())
    }

    pub(super) fn ends(&self) -> (f64, f64) {
        let end = |end: Option<&(f64, Whole)>| end.map_or(0.0, |(time, _)| *time);
        (end(self.0.first()), end(self.0.last()))
    }

    /// The robot at a time: linear between waypoints, at rest outside of them.
    pub(super) fn at(&self, time: f64) -> Whole {
        let next = self.0.partition_point(|(at, _)| *at <= time);
        let Some(&(from, start)) = next.checked_sub(1).map(|before| &self.0[before]) else {
            return self.0[0].1;
        };
        self.0.get(next).map_or(start, |&(to, end)| start.lerp(end, (time - from) / (to - from)))
    }
}

/// The angular momentum about the centre of mass from one sample to the next one, times the time
/// between them, by mass: each link's way beside that of the centre, and its turn.
fn turned_between(model: &RobotModel, a: &Sample, b: &Sample) -> DVec3 {
    let middle = 0.5 * (a.centre_of_mass + b.centre_of_mass);
    let drift = b.centre_of_mass - a.centre_of_mass;
    let links = model.links.iter().enumerate().map(|(index, link)| {
        let [from, to] = [a, b].map(|sample| sample.posture.world_from_link[index]);
        let (begin, end) = (from * link.com, to * link.com);
        let way = link.mass * (0.5 * (begin + end) - middle).cross(end - begin - drift);
        let turn = scaled_axis_from_rotation(from.rotation.conjugate() * to.rotation);
        way + from.rotation * (link.inertia * turn)
    });
    links.sum::<DVec3>() / model.mass()
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;
    use crate::check::motion::{Change, SampledMotion, Spacing};
    use crate::check_robot::{ELBOW, MASSES, robot, waypoint};
    use crate::kinematics::forward::{Configuration, Posture};

    fn sample(root_turn: f64, elbow: f64) -> Sample {
        let model = robot();
        let mut at = waypoint(0.0, 0.0, 0.0);
        at.q[ELBOW] = elbow;
        at.root_rotation = DQuat::from_rotation_z(root_turn).to_array();
        let posture = Posture::new(&model, &Configuration::of_waypoint(&at, 4));
        let centre_of_mass = posture.centre_of_mass(&model);
        Sample { waypoint: 0, posture, centre_of_mass, substep: 0 }
    }

    #[test]
    fn a_robot_that_turns_as_a_whole_has_the_momentum_of_its_inertia() {
        let model = robot();
        let (a, b) = (sample(0.0, 0.0), sample(0.02, 0.0));
        // The legs and both links of the arm hang 0.1, 0.1 and 0.25 m beside the axis, and each of
        // the five links has 1 kg m2 about its own.
        let beside = 2.0 * MASSES[1] * 0.1 * 0.1 + 2.0 * MASSES[2] * 0.25 * 0.25;
        let centre = 2.0 * MASSES[2] * 0.25 / model.mass();
        let inertia = 5.0 + beside - model.mass() * centre * centre;
        let turned = turned_between(&model, &a, &b);
        assert!((turned.z - 0.02 * inertia / model.mass()).abs() < 1e-5, "{turned}");
        assert!(turned.truncate().length() < 0.01 * turned.z, "{turned}");
        assert!((turned + turned_between(&model, &b, &a)).length() < 1e-12);
    }

    #[test]
    fn a_link_that_turns_alone_adds_its_own_momentum() {
        let model = robot();
        let turned = turned_between(&model, &sample(0.0, 0.0), &sample(0.0, 0.02));
        // The forearm's centre is 0.2 m below the elbow and moves by 0.02 x 0.2 m along y, less the
        // centre of mass; it is 0.6 m below the shoulder at 1.1 m.
        let way = 0.02 * 0.2;
        let height = 0.5 - sample(0.0, 0.0).centre_of_mass.z;
        let expected = 0.02 - MASSES[2] * way * height;
        assert!((turned.x - expected / model.mass()).abs() < 1e-4 * expected, "{turned}");
        let still = turned_between(&model, &sample(0.3, 0.1), &sample(0.3, 0.1));
        assert_eq!(still, DVec3::ZERO);
    }

    #[test]
    fn the_momentum_turns_with_the_robot() {
        let ahead = turned_between(&robot(), &sample(0.0, 0.0), &sample(0.0, 0.02));
        let aside = turned_between(&robot(), &sample(1.2, 0.0), &sample(1.2, 0.02));
        assert!((DQuat::from_rotation_z(1.2) * ahead - aside).length() < 1e-12, "{aside}");
    }

    #[test]
    fn turns_add_up_over_the_waypoints() {
        let model = robot();
        let waypoints = [0.0, 0.1, 0.2].map(|turn| {
            let mut at = waypoint(10.0 * turn, 0.0, 0.0);
            at.root_rotation = DQuat::from_rotation_z(turn).to_array();
            at
        });
        let places = waypoints.each_ref().map(|at| Configuration::of_waypoint(at, 4));
        let changes = places.windows(2).map(|pair| Change::between(&pair[0], &pair[1])).collect();
        let case = Case {
            contacts: &[],
            supports: Vec::new(),
            waypoints: (&waypoints[..]).into(),
            received: Vec::new(),
            instants: Vec::new(),
            motion: SampledMotion::new(&model, &waypoints, Spacing { changes }),
            stance_feet: Vec::new(),
        };
        let CentreTrack(track) = CentreTrack::new(&model, &case);
        let turned = [0, 1, 2].map(|index| track[index].1.turned.z);
        assert!(turned[0] == 0.0 && turned[1] > 0.01, "{turned:?}");
        assert!((turned[2] - 2.0 * turned[1]).abs() < 1e-9, "{turned:?}");
        assert_eq!([0, 1, 2].map(|index| track[index].0), [0.0, 1.0, 2.0]);
    }

    #[test]
    fn between_waypoints_the_robot_as_a_whole_moves_evenly() {
        let whole = |x: f64| Whole { centre: x * DVec3::X, turned: -x * DVec3::Z };
        let track = CentreTrack(vec![(1.0, whole(0.0)), (3.0, whole(1.0))]);
        let places = [0.0, 1.5, 3.0, 9.0].map(|time| track.at(time));
        assert_eq!(places, [whole(0.0), whole(0.25), whole(1.0), whole(1.0)]);
        assert_eq!(track.ends(), (1.0, 3.0));
    }
}
