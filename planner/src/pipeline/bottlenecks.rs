//! Places where stage M fails most often [Grey 4.4.4].

use glam::DVec3;

use crate::motion::ids::TransitionId;
use crate::motion::mode_costs::{ModeCosts, ModeId};
use crate::motion::mode_graph::ModeGraph;
use crate::possibility::MidFeetPose;

/// Places that are remembered.
const PLACES_MAX: usize = 64;
/// Failures within this distance (m, in the metric of Gamma_P) count for one place.
const RADIUS: f64 = 0.4;

/// A place where stage M failed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bottleneck {
    /// Midway between the feet, in the world, m.
    pub position: DVec3,
    /// Number of sequences that failed there.
    pub failures: u64,
}

/// The places where sequences of a search failed, at most the first [`PLACES_MAX`].
#[derive(Debug, Default)]
pub(crate) struct Bottlenecks {
    places: heapless::Vec<(MidFeetPose, u64), PLACES_MAX>,
}

impl Bottlenecks {
    /// Counts a failure at a place.
    pub fn count_failure(&mut self, place: MidFeetPose) {
        match self.places.iter_mut().find(|(known, _)| known.distance(&place) < RADIUS) {
            Some((_, failures)) => *failures += 1,
            None => _ = self.places.push((place, 1)),
        }
    }

    /// The place with the most failures, the first of several.
    pub fn worst(&self) -> Option<Bottleneck> {
        let most = self.places.iter().rev().max_by_key(|(_, failures)| *failures);
        most.map(|&(place, failures)| Bottleneck { position: place.position, failures })
    }
}

/// The pose midway between the feet of a transition.
pub(crate) fn mid_feet_pose(graph: &ModeGraph, id: TransitionId) -> MidFeetPose {
    let (stance, other) = graph.pair(id);
    MidFeetPose::of_sole(&stance.world_from_sole)
        .interpolate(&MidFeetPose::of_sole(&other.world_from_sole), 0.5)
}

/// The mode along a sequence with the highest S(sigma), the first of several; none if no search in
/// these modes has failed.
pub(crate) fn most_attempted_mode(
    graph: &ModeGraph,
    costs: &ModeCosts,
    sequence: &[TransitionId],
) -> Option<ModeId> {
    let modes = sequence.iter().flat_map(|&id| ModeId::of(graph, id));
    let more = |best: Option<ModeId>, mode: ModeId| {
        let least = best.map_or(1, |best| costs.attempts(best));
        if costs.attempts(mode) > least { Some(mode) } else { best }
    };
    modes.fold(None, more)
}

#[cfg(test)]
mod tests {
    use glam::DQuat;
    use surefoot_shared_types::Pose;

    use super::*;
    use crate::constraints::foothold::Foothold;

    fn place(x: f64) -> MidFeetPose {
        MidFeetPose { position: DVec3::new(x, 0.0, 0.0), yaw: 0.0 }
    }

    #[test]
    fn the_worst_bottleneck_has_the_most_failures() {
        let mut bottlenecks = Bottlenecks::default();
        assert_eq!(bottlenecks.worst(), None);
        [0.0, 1.0, 1.2, 1.1, 2.0].into_iter().for_each(|x| bottlenecks.count_failure(place(x)));
        assert_eq!(bottlenecks.worst(), Some(Bottleneck { position: DVec3::X, failures: 3 }));
    }

    #[test]
    fn more_places_than_fit_keep_the_first() {
        let mut bottlenecks = Bottlenecks::default();
        (0..2 * PLACES_MAX).for_each(|x| bottlenecks.count_failure(place(x as f64)));
        bottlenecks.count_failure(place(3.0));
        assert_eq!(
            bottlenecks.worst(),
            Some(Bottleneck { position: DVec3::new(3.0, 0.0, 0.0), failures: 2 })
        );
    }

    #[test]
    fn the_most_attempted_mode_has_the_most_failed_attempts() {
        let mut graph = ModeGraph::new(3, 4, 4, 1.0);
        let foothold = |limb, x| {
            Foothold::new(
                limb,
                Pose::from_parts(DVec3::new(x, 0.0, 0.0), DQuat::IDENTITY),
                heapless::Vec::new(),
            )
        };
        let [left, right, ahead] = [(0, 0.0), (1, 0.1), (1, 0.3)]
            .map(|(limb, x)| graph.add_foothold(foothold(limb, x)).unwrap());
        graph.connect(left, right).unwrap();
        graph.connect(left, ahead).unwrap();
        let mut costs = ModeCosts::new(3, 4, 4);
        let sequence = [graph.find(right, left).unwrap(), graph.find(left, ahead).unwrap()];
        assert_eq!(most_attempted_mode(&graph, &costs, &sequence), None, "no mode was searched");
        costs.add_attempts(ModeId::Single(left), 7);
        costs.add_attempts(ModeId::Single(right), 3);
        assert_eq!(most_attempted_mode(&graph, &costs, &sequence), Some(ModeId::Single(left)));
        assert_eq!(
            most_attempted_mode(&graph, &costs, &sequence[..1]),
            Some(ModeId::Single(right)),
            "of this sequence alone"
        );
    }
}
