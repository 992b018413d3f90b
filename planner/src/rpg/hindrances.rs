//! Where a search does not get on: what whoever gets no plan asks first.

use glam::DVec3;

use crate::possibility::MidFeetPose;

/// Places that are remembered.
const PLACES_MAX: usize = 64;
/// What is this near to a place belongs to it, m in the metric of Gamma_P.
const RADIUS: f64 = 0.4;

/// A place where stage M could not go on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hindrance {
    /// Between the feet, in the world, m.
    pub position: DVec3,
    /// Sequences that failed there.
    pub failures: u64,
}

/// All such places of a search, or the first ones where they are very many.
#[derive(Debug, Default)]
pub(crate) struct Hindrances {
    places: heapless::Vec<(MidFeetPose, u64), PLACES_MAX>,
}

impl Hindrances {
    /// Counts a failure at a place.
    pub fn note(&mut self, place: MidFeetPose) {
        match self.places.iter_mut().find(|(known, _)| known.distance(&place) < RADIUS) {
            Some((_, failures)) => *failures += 1,
            None => _ = self.places.push((place, 1)),
        }
    }

    /// Where most sequences failed; the first of several.
    pub fn worst(&self) -> Option<Hindrance> {
        let most = self.places.iter().rev().max_by_key(|(_, failures)| *failures);
        most.map(|&(place, failures)| Hindrance { position: place.position, failures })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn station(x: f64) -> MidFeetPose {
        MidFeetPose { position: DVec3::new(x, 0.0, 0.0), yaw: 0.0 }
    }

    #[test]
    fn the_worst_place_is_where_most_failed() {
        let mut hindrances = Hindrances::default();
        assert_eq!(hindrances.worst(), None);
        [0.0, 1.0, 1.2, 1.1, 2.0].into_iter().for_each(|x| hindrances.note(station(x)));
        assert_eq!(hindrances.worst(), Some(Hindrance { position: DVec3::X, failures: 3 }));
    }

    #[test]
    fn more_places_than_fit_lose_none_of_the_first() {
        let mut hindrances = Hindrances::default();
        (0..2 * PLACES_MAX).for_each(|place| hindrances.note(station(place as f64)));
        hindrances.note(station(3.0));
        assert_eq!(
            hindrances.worst(),
            Some(Hindrance { position: DVec3::new(3.0, 0.0, 0.0), failures: 2 })
        );
    }
}
