//! Rounds of footholds that are uniform over position and heading, without the tables, cells and
//! limits of the other actions: with them every walk is found in the end, as docs/COMPLETENESS.md
//! states it [Grey 5.3, 5.7.2]. In a search with discs of given radii, rounds replace all sweeps.

use std::f64::consts::PI;

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::rotation_about;

use crate::base::random::Random;
use crate::geometry::bvh::Aabb;
use crate::methods::method::MethodParameters;

/// Footholds that a round samples, of both feet together.
const ROUND_FOOTHOLDS: u32 = 96;
/// Routes that are left before the first round, and more of them before each later one.
const ROUTES_PER_ROUND: u64 = 3;
/// rho of the first round, relative to the longest level step.
const FIRST_RADIUS_SHARE: f64 = 0.5;
/// Radii of a cycle, each twice the one before; the last round of a cycle covers the whole world.
const RADII: u64 = 3;

/// When a round of uniform footholds is due, and its region.
#[derive(Debug)]
pub(crate) struct UniformRounds {
    /// Number of rounds begun.
    pub rounds: u64,
    /// Routes left since the last round.
    left: u64,
    /// The longest level step, m.
    step_max: f64,
    /// The bounds of the world, m.
    world: Aabb,
    /// The radii and sizes of rounds that replace all sweeps; none where rounds are a last resort.
    discs: Option<MethodParameters>,
}

impl UniformRounds {
    /// No round yet, for a robot with this longest level step (m) in a world. `discs` makes rounds
    /// replace all sweeps.
    pub fn new(step_max: f64, world: Aabb, discs: Option<MethodParameters>) -> Self {
        Self { rounds: 0, left: 0, step_max, world, discs }
    }

    /// Whether rounds replace all sweeps.
    pub fn replace_sweeps(&self) -> bool {
        self.discs.is_some()
    }

    /// Whether footholds of any heading may be used, on a route of one segment.
    pub fn may_face_anywhere(&self) -> bool {
        self.rounds > 0 || self.discs.is_some()
    }

    /// Footholds that a round samples, of both feet together.
    pub fn round_footholds(&self) -> u32 {
        self.discs.map_or(ROUND_FOOTHOLDS, |parameters| 2 * parameters.placements)
    }

    /// Counts a route that is to be left. Returns whether a round begins in its place. The number
    /// of routes between two rounds grows, so that every sequence over the footholds of all rounds
    /// has its turn.
    pub fn is_due(&mut self) -> bool {
        if self.discs.is_some() {
            return false;
        }
        self.left += 1;
        if self.left < ROUTES_PER_ROUND * (self.rounds + 1) {
            return false;
        }
        (self.left, self.rounds) = (0, self.rounds + 1);
        true
    }

    /// rho of the current round, m: the radius of the discs about the vertices of the route. `None`
    /// for the whole world.
    fn disc_radius(&self) -> Option<f64> {
        if let Some(parameters) = &self.discs {
            let share = parameters.disc_radius_share_of(self.rounds);
            return share.is_finite().then_some(share * self.step_max);
        }
        let index = self.rounds.saturating_sub(1) % (RADII + 1);
        let doubled = FIRST_RADIUS_SHARE * self.step_max * (1 << index) as f64;
        (index < RADII).then_some(doubled)
    }

    /// Whether a placement may be used that was found near a drawn one: with discs of given radii,
    /// if it lies in the disc about `around`.
    pub fn may_use(&self, around: DVec3, position: DVec3) -> bool {
        let disc_radius = self.discs.and(self.disc_radius());
        let distance = around.truncate().distance(position.truncate());
        disc_radius.is_none_or(|disc_radius| distance <= disc_radius)
    }

    /// A sole pose of the current round: uniform over a disc about a vertex at `around`, or over
    /// the world, and over all headings.
    pub fn draw(&self, around: DVec3, random: &mut Random) -> Pose {
        let position = match self.disc_radius() {
            Some(disc_radius) => {
                let distance = disc_radius * libm::sqrt(random.uniform(0.0, 1.0));
                let (sin, cos) = libm::sincos(random.uniform(-PI, PI));
                around + distance * DVec3::new(cos, sin, 0.0)
            }
            None => DVec3::from_array(std::array::from_fn(|axis| {
                random.uniform(self.world.min[axis], self.world.max[axis])
            })),
        };
        Pose::from_parts(position, rotation_about(DVec3::Z, random.uniform(-PI, PI)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::Stream;

    fn rounds() -> UniformRounds {
        UniformRounds::new(0.8, Aabb { min: DVec3::splat(-2.0), max: DVec3::splat(3.0) }, None)
    }

    #[test]
    fn given_discs_grow_with_each_round_and_hold_every_placement() {
        let parameters = MethodParameters {
            disc_radius_share: 0.5,
            disc_radius_growth: 2.0,
            ..Default::default()
        };
        let mut uniform = UniformRounds { discs: Some(parameters), ..rounds() };
        assert!(uniform.replace_sweeps() && uniform.may_face_anywhere());
        assert!(!(1..=60).any(|_| uniform.is_due()));
        for (round, disc_radius) in [(1, 0.4), (2, 0.8), (3, 1.6), (9, 1.6)] {
            uniform.rounds = round;
            assert_eq!(uniform.disc_radius(), Some(disc_radius));
            let may_use = |distance| uniform.may_use(DVec3::Y, DVec3::new(distance, 1.0, 0.3));
            assert!(may_use(0.99 * disc_radius) && !may_use(1.01 * disc_radius));
        }
    }

    #[test]
    fn rounds_become_rarer_and_never_end() {
        let mut uniform = rounds();
        let due: Vec<u64> = (1..=60).filter(|_| uniform.is_due()).collect();
        assert_eq!(due, [3, 9, 18, 30, 45]);
    }

    #[test]
    fn discs_double_up_to_the_whole_world_and_begin_again() {
        let mut uniform = rounds();
        let radii: Vec<Option<f64>> = (1..=5)
            .map(|round| {
                uniform.rounds = round;
                uniform.disc_radius()
            })
            .collect();
        assert_eq!(radii, [Some(0.4), Some(0.8), Some(1.6), None, Some(0.4)]);
    }

    #[test]
    fn poses_fill_the_disc_and_face_everywhere() {
        let mut uniform = rounds();
        uniform.rounds = 2;
        let mut counts = [[0u32; 4]; 2];
        for index in 0..4_000 {
            let mut random = Random::new(1, Stream::UniformFoothold, 0, index);
            let pose = uniform.draw(DVec3::ONE, &mut random);
            let offset = pose.translation - DVec3::ONE;
            assert!(offset.length() <= 0.8 && offset.z == 0.0);
            let quarter = |x: f64, y: f64| usize::from(x > 0.0) * 2 + usize::from(y > 0.0);
            let ahead = pose.rotation * DVec3::X;
            counts[0][quarter(offset.x, offset.y)] += 1;
            counts[1][quarter(ahead.x, ahead.y)] += 1;
        }
        assert!(
            counts.as_flattened().iter().all(|count| (880..1_120).contains(count)),
            "{counts:?}"
        );
    }
}
