//! What a plan is as a walk: its duration, pace and detours.

use glam::DVec3;
use serde::{Deserialize, Serialize};
use surefoot_shared_types::message::{PlanChunk, SupportMode, Waypoint};

/// Feet whose places differ by less are at one place, m.
const SAME_PLACE: f64 = 1e-9;
/// A path or a number of steps exceeds a bound beyond this rounding.
const ROUNDING: f64 = 1e-6;

/// A plan as a walk.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct WalkFacts {
    /// Duration, s.
    pub seconds: f64,
    /// From the first place of the root to the last, seen from above, m.
    pub metres: f64,
    /// Length of the root's path, m.
    pub root_path: f64,
    /// Steps: how often a foot is lifted and set down.
    pub steps: u64,
    /// Fewer steps do not do, were each as long as the longest one of the plan.
    pub steps_min: u64,
}

impl WalkFacts {
    /// Of places of the root with their times (s), of the places of each foot in their order, and
    /// of the successive support modes, of which neighbours may be equal.
    pub fn new(
        root: impl IntoIterator<Item = (f64, DVec3)>,
        feet: [Vec<DVec3>; 2],
        modes: impl IntoIterator<Item = SupportMode>,
    ) -> Self {
        let root: Vec<(f64, DVec3)> = root.into_iter().collect();
        let (Some(first), Some(last)) = (root.first(), root.last()) else { return Self::default() };
        let swings = feet.iter().flat_map(|foot| foot.windows(2));
        let lengths: Vec<f64> = swings.map(|pair| pair[0].distance(pair[1])).collect();
        let longest = lengths.iter().copied().fold(0.0, f64::max);
        let least = |foot: &Vec<DVec3>| {
            let way = foot.first().zip(foot.last()).map_or(0.0, |(a, b)| a.distance(*b));
            if longest > 0.0 { (way / longest - ROUNDING).ceil().max(0.0) as u64 } else { 0 }
        };
        Self {
            seconds: last.0 - first.0,
            metres: first.1.truncate().distance(last.1.truncate()),
            root_path: root.windows(2).map(|pair| pair[0].1.distance(pair[1].1)).sum(),
            steps: steps_of(modes),
            steps_min: feet.iter().map(least).sum(),
        }
    }

    /// Of a complete stream of chunks.
    pub fn of_chunks(chunks: &[PlanChunk]) -> Self {
        let waypoints = chunks.iter().flat_map(PlanChunk::waypoints);
        let place = |waypoint: &Waypoint| (waypoint.time, waypoint.root_position.into());
        let mut feet = [Vec::new(), Vec::new()];
        for contact in chunks.iter().flat_map(PlanChunk::contacts) {
            if let Some(foot) = feet.get_mut(contact.limb as usize) {
                add_place(foot, contact.position.into());
            }
        }
        let modes = chunks.iter().filter_map(|chunk| SupportMode::from_wire(chunk.mode));
        Self::new(waypoints.map(place), feet, modes)
    }

    /// One line of text.
    pub fn describe(&self) -> String {
        let Self { seconds, metres, root_path, steps, steps_min } = *self;
        let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
        let mut text =
            format!("{metres:.2} m in {seconds:.1} s: {:.3} m/s", share(metres, seconds));
        if steps > 0 {
            text += &format!(
                ", {:.2} s a step, {steps} steps (at least {steps_min} as long as the longest one)",
                share(seconds, steps as f64)
            );
        }
        if metres > 0.1 {
            text += &format!(", root path {:.2} m per metre", root_path / metres);
        }
        text
    }
}

/// How often a foot is set down: a mode on one foot is followed by one on both.
fn steps_of(modes: impl IntoIterator<Item = SupportMode>) -> u64 {
    let (mut steps, mut was_single) = (0, false);
    for mode in modes {
        let is_single = mode != SupportMode::Double;
        steps += u64::from(was_single && !is_single);
        was_single = is_single;
    }
    steps
}

/// Adds a place of a foot if it is another one than the last.
pub fn add_place(foot: &mut Vec<DVec3>, place: DVec3) {
    if foot.last().is_none_or(|last| last.distance(place) > SAME_PLACE) {
        foot.push(place);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_walk_of_two_steps_that_sways_is_described() {
        let root = [(1.0, [0.0, 0.0]), (2.0, [0.3, 0.4]), (5.0, [1.0, 0.0])];
        let root = root.map(|(time, [x, y])| (time, DVec3::new(x, y, 1.0)));
        let mut feet = [vec![DVec3::ZERO], vec![DVec3::Y]];
        for (foot, x) in [(0, 0.0), (0, 0.5), (1, 1.0), (0, 1.0), (1, 1.0)] {
            let place = DVec3::new(x, foot as f64, 0.0);
            add_place(&mut feet[foot], place);
        }
        // The left foot, twice the right foot, the second time where it stands.
        use SupportMode::{Double, Left, Right};
        let modes = [Double, Right, Right, Double, Left, Double, Double, Left, Double];
        let facts = WalkFacts::new(root, feet, modes);
        assert_eq!((facts.steps, facts.steps_min, facts.seconds), (3, 2, 4.0));
        assert!((facts.root_path - 0.5 - libm::sqrt(0.65)).abs() < 1e-12, "{facts:?}");
        assert_eq!(
            facts.describe(),
            "1.00 m in 4.0 s: 0.250 m/s, 1.33 s a step, 3 steps (at least 2 as long as the \
             longest one), root path 1.31 m per metre"
        );
    }

    #[test]
    fn a_robot_that_stands_walks_nowhere() {
        let facts = WalkFacts::new([(0.0, DVec3::ZERO)], [vec![DVec3::ZERO], vec![]], []);
        assert_eq!(facts, WalkFacts::default());
        assert_eq!(facts.describe(), "0.00 m in 0.0 s: 0.000 m/s");
    }
}
