//! The guide route along which foot placements are sought: for now the simplest one, which turns in place at the start,
//! walks straight to the goal and turns in place there.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::config::Mark;
use surefoot_shared_types::spatial::{rotation_about, wrap_angle};

/// The largest turn between two stations, rad: a step can turn a foot by as much.
const TURN_STEP_MAX: f64 = 0.2;
/// A way shorter than this (m) is walked without turning to face it.
const FACING_DISTANCE_MIN: f64 = 0.5;

/// A route with stations at even distances.
#[derive(Debug, Clone)]
pub struct Guide {
    start: Mark,
    goal: Mark,
    /// The heading of the straight part, rad.
    heading: f64,
    /// Stations at which the robot turns before the straight part, along it, and after it.
    counts: [usize; 3],
}

impl Guide {
    /// The route from `start` to `goal` with stations at most `spacing` (m) apart.
    pub fn new(start: Mark, goal: Mark, spacing: f64) -> Self {
        let way = (goal.position - start.position).truncate();
        let length = way.length();
        let heading = if length < FACING_DISTANCE_MIN { start.yaw } else { libm::atan2(way.y, way.x) };
        let turns = |from: f64, to: f64| libm::ceil(wrap_angle(to - from).abs() / TURN_STEP_MAX) as usize;
        let counts = [turns(start.yaw, heading), libm::ceil(length / spacing) as usize, turns(heading, goal.yaw)];
        Self { start, goal, heading, counts }
    }

    /// How many stations there are, both ends included.
    pub fn stations(&self) -> usize {
        self.counts.iter().sum::<usize>() + 1
    }

    /// Where a foot would ideally stand at a station: beside the route, facing along it, as far apart as the marks say
    /// times `widening`.
    pub fn world_from_ideal_sole(&self, station: usize, limb: usize, widening: f64) -> Pose {
        let [turned, walked, turned_again] = self.shares(station);
        let first_turn = wrap_angle(self.heading - self.start.yaw);
        let second_turn = wrap_angle(self.goal.yaw - self.heading);
        let yaw = self.start.yaw + turned * first_turn + turned_again * second_turn;
        let position = self.start.position.lerp(self.goal.position, walked);
        let apart = widening * (self.start.feet_apart + walked * (self.goal.feet_apart - self.start.feet_apart));
        let rotation = rotation_about(DVec3::Z, yaw);
        let side = if limb == 0 { 0.5 } else { -0.5 };
        Pose::from_parts(position + rotation * (DVec3::Y * side * apart), rotation)
    }

    /// How much of the first turn, of the walk and of the second turn lies behind a station, each 0 to 1.
    fn shares(&self, station: usize) -> [f64; 3] {
        let mut ahead = station;
        self.counts.map(|count| {
            let done = ahead.min(count);
            ahead -= done;
            if count == 0 { 0.0 } else { done as f64 / count as f64 }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use surefoot_shared_types::spatial::yaw_of;

    fn mark(x: f64, yaw: f64) -> Mark {
        Mark { position: DVec3::new(x, 0.0, 0.0), yaw, feet_apart: 0.2 }
    }

    #[test]
    fn both_ends_are_the_marks() {
        for (start, goal) in [(mark(0.0, 0.0), mark(3.0, 0.0)), (mark(0.0, 1.0), mark(-3.0, -2.0)), (mark(0.0, 0.4), mark(0.0, -0.4))] {
            let guide = Guide::new(start, goal, 0.25);
            for limb in 0..2 {
                for (station, end) in [(0, start), (guide.stations() - 1, goal)] {
                    let (ideal, print) = (guide.world_from_ideal_sole(station, limb, 1.0), end.world_from_soles()[limb]);
                    assert!(ideal.translation.distance(print.translation) < 1e-9);
                    assert!(wrap_angle(yaw_of(ideal.rotation) - yaw_of(print.rotation)).abs() < 1e-9);
                }
            }
        }
    }

    #[test]
    fn no_two_stations_are_further_apart_than_a_step() {
        let guide = Guide::new(mark(0.0, 2.0), mark(2.0, -2.0), 0.25);
        for station in 1..guide.stations() {
            let [before, here] = [station - 1, station].map(|at| guide.world_from_ideal_sole(at, 0, 1.0));
            assert!(here.translation.distance(before.translation) < 0.26);
            assert!(wrap_angle(yaw_of(here.rotation) - yaw_of(before.rotation)).abs() <= TURN_STEP_MAX + 1e-9);
        }
    }
}
