//! Joint accelerations.
//!
//! A smooth motion states its accelerations; they are compared with the limits that the robot file
//! states. In straight lines the speed jumps at waypoints. There the least acceleration counts with
//! which a joint can be at every waypoint in time, at rest at the first and the last one, with a
//! continuous speed: the robot stops at a segment's end when a controller takes over or no further
//! segment arrives.
//!
//! Between two waypoints a joint moves against the straight line by at most [`TRAVEL_BACK_MAX`], so
//! no wait and no swing back gives it a run-up. The speeds that can be reached at a waypoint are an
//! interval, which is followed from waypoint to waypoint.

use surefoot_shared_types::message::{Check, Waypoint};
use surefoot_shared_types::robot::model::RobotModel;

use crate::base::comparison::is_at_most;
use crate::check::segment::Violation;

/// What rounding may add to an acceleration, as a share of its limit.
const SHARE_ROUNDING: f64 = 1e-6;
/// Shares of a limit are measured to this ratio.
const SHARE_RATIO: f64 = 1.01;
/// A speed (rad/s or m/s) that rounding leaves of rest.
const REST_ROUNDING: f64 = 1e-9;
/// How far a joint may move against its straight line, rad or m: a servo's deviation.
const TRAVEL_BACK_MAX: f64 = 1e-3;
/// Larger shares of a limit count as this one.
const SHARE_MAX: f64 = 1e9;

/// An acceleration of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeakAcceleration {
    /// As a share of the joint's limit, rounded up.
    pub share: f64,
    joint: usize,
}

/// The share of the joints' acceleration limits that stays unused by straight lines. Time must
/// increase.
///
/// # Errors
/// A joint needs more than its limit.
pub fn check_acceleration(model: &RobotModel, waypoints: &[Waypoint]) -> Result<f64, Violation> {
    let PeakAcceleration { share, joint: index } = peak_acceleration(model, waypoints);
    if is_at_most(share, 1.0 + SHARE_ROUNDING) {
        return Ok(1.0 - share);
    }
    let joint = &model.joints[index];
    let (name, limit) = (&joint.name, joint.acceleration());
    let needed = share * limit;
    let detail = format!("joint {name} has to accelerate by {needed:.2}, limit {limit}");
    let waypoint = first_unreachable(waypoints, index, limit).unwrap_or(0);
    Err(Violation::new(Check::Acceleration, waypoint, detail))
}

/// As [`check_acceleration`] for a smooth motion. A limit that the robot file does not state is
/// none, unless the motion `keeps_default` limits; torques bound the acceleration of such a joint.
///
/// # Errors
/// A joint needs more than its limit.
pub fn check_stated_accelerations(
    model: &RobotModel,
    instants: &[(usize, Waypoint)],
    keeps_default: bool,
) -> Result<f64, Violation> {
    let mut worst = f64::INFINITY;
    for (index, instant) in instants {
        for (joint, acceleration) in model.joints.iter().zip(&instant.joint_acceleration) {
            let default = keeps_default.then(|| joint.acceleration());
            let Some(limit) = joint.stated_acceleration.or(default) else { continue };
            let share = acceleration.abs() / limit;
            if !is_at_most(share, 1.0 + SHARE_ROUNDING) {
                let name = &joint.name;
                let detail =
                    format!("joint {name} accelerates by {acceleration:.2}, limit {limit}");
                return Err(Violation::new(Check::Acceleration, *index, detail));
            }
            worst = worst.min(1.0 - share);
        }
    }
    Ok(worst)
}

/// The acceleration nearest to its limit, or furthest beyond it.
pub fn peak_acceleration(model: &RobotModel, waypoints: &[Waypoint]) -> PeakAcceleration {
    let mut peak = PeakAcceleration { share: 0.0, joint: 0 };
    for (index, joint) in model.joints.iter().enumerate() {
        let is_enough = |share: f64| {
            first_unreachable(waypoints, index, share * joint.acceleration()).is_none()
        };
        if peak.share > 0.0 && is_enough(peak.share) {
            continue;
        }
        peak = PeakAcceleration { share: least_share(is_enough), joint: index };
    }
    peak
}

/// The least share of a limit that is enough, rounded up by [`SHARE_RATIO`]; 0 where nothing moves.
fn least_share(is_enough: impl Fn(f64) -> bool) -> f64 {
    const SHARE_MIN: f64 = 1e-3;
    if is_enough(0.0) {
        return 0.0;
    }
    let (mut too_little, mut enough) = (0.0, SHARE_MIN);
    while !is_enough(enough) {
        (too_little, enough) = (enough, 2.0 * enough);
        if enough > SHARE_MAX {
            return SHARE_MAX;
        }
    }
    // The limit itself decides between acceptance and refusal, so it is tried exactly.
    if too_little < 1.0 && enough > 1.0 {
        if is_enough(1.0) { enough = 1.0 } else { too_little = 1.0 }
    }
    while enough > SHARE_RATIO * too_little && enough > SHARE_MIN {
        let middle = 0.5 * (too_little + enough);
        if is_enough(middle) { enough = middle } else { too_little = middle }
    }
    enough
}

/// The first waypoint at which a joint cannot be in time with accelerations up to `limit`, or the
/// last one if it cannot be at rest there. No number is reachable that is none.
fn first_unreachable(waypoints: &[Waypoint], joint: usize, limit: f64) -> Option<usize> {
    let mut speeds = (0.0, 0.0);
    for (index, pair) in waypoints.windows(2).enumerate() {
        let seconds = pair[1].time - pair[0].time;
        let way = pair[1].q[joint] - pair[0].q[joint];
        match speeds_after(speeds, way, seconds, limit) {
            Some(after) => speeds = after,
            None => return Some(index + 1),
        }
    }
    let rests = is_at_most(speeds.0, REST_ROUNDING) && is_at_most(-REST_ROUNDING, speeds.1);
    (!rests).then(|| waypoints.len().saturating_sub(1))
}

/// The speeds that can be reached after `way` within `seconds` from one of the speeds between
/// `least` and `most`.
fn speeds_after(
    (least, most): (f64, f64),
    way: f64,
    seconds: f64,
    limit: f64,
) -> Option<(f64, f64)> {
    if way < 0.0 {
        let (lowest, highest) = speeds_after((-most, -least), -way, seconds, limit)?;
        return Some((-highest, -lowest));
    }
    // Against the way a joint is at most so fast that it stops within the travel allowed.
    let back = -(2.0 * limit * TRAVEL_BACK_MAX).sqrt();
    if !is_at_most(back, most + REST_ROUNDING) {
        return None;
    }
    let speeds = (least.max(back), most.max(back));
    let highest = highest_speed(speeds, way, seconds, limit)?;
    let lowest = lowest_speed(speeds, way, seconds, limit).max(back);
    is_at_most(back, highest).then_some((lowest.min(highest), highest))
}

/// The highest of these speeds. It is highest after full acceleration from the speed
/// `way / seconds - limit * seconds / 2`, else from the nearest speed above.
fn highest_speed((least, most): (f64, f64), way: f64, seconds: f64, limit: f64) -> Option<f64> {
    // A joint that stands, and may not accelerate, is at rest in spite of rounding.
    let slack = 1e-12 * (1.0 + limit * seconds);
    let best = way / seconds - 0.5 * limit * seconds;
    if !is_at_most(best, most + slack) {
        return None;
    }
    if is_at_most(least, best) {
        return Some(best + limit * seconds);
    }
    // From `least` the joint first slows down, then speeds up.
    let square = 2.0 * limit * limit * seconds * seconds + 4.0 * limit * (way - least * seconds);
    let speed = least - limit * seconds + square.max(0.0).sqrt();
    let slowest = (0.5 * (least + speed - limit * seconds)).min(0.0);
    if slowest * slowest <= limit * TRAVEL_BACK_MAX {
        return is_at_most(-slack * limit * seconds, square).then_some(speed);
    }
    // It moves back as far as it may, and stands for a while.
    let squared = 2.0 * limit * (way + TRAVEL_BACK_MAX) - least * least;
    is_at_most(-slack * limit * seconds, squared).then(|| squared.max(0.0).sqrt())
}

/// The lowest of these speeds, if there is one. It is lowest after full braking from the speed
/// `way / seconds + limit * seconds / 2`, else from the nearest speed below.
fn lowest_speed((_, most): (f64, f64), way: f64, seconds: f64, limit: f64) -> f64 {
    let best = way / seconds + 0.5 * limit * seconds;
    if best <= most {
        return best - limit * seconds;
    }
    // From `most` the joint first speeds up, then slows down.
    let square = 2.0 * limit * limit * seconds * seconds - 4.0 * limit * (way - most * seconds);
    most + limit * seconds - square.max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check_robot::randoms;

    /// The least and the highest speed after a way from one speed, by trying motions that go to
    /// some speed, keep it for a while, and go on to the last one.
    fn tried(u: f64, way: f64, seconds: f64, limit: f64) -> Option<(f64, f64)> {
        let mut found: Option<(f64, f64)> = None;
        for (middle, w) in (0..300).flat_map(|a| (0..300).map(move |b| (a, b))) {
            let [middle, w] = [middle, w].map(|index| 0.01 * f64::from(index));
            let (first, last) = ((middle - u).abs() / limit, (w - middle).abs() / limit);
            let rest = seconds - first - last;
            let covered = 0.5 * (u + middle) * first + middle * rest + 0.5 * (middle + w) * last;
            if rest >= -1e-9 && (covered - way).abs() < 0.005 {
                let (low, high) = found.unwrap_or((w, w));
                found = Some((low.min(w), high.max(w)));
            }
        }
        found
    }

    #[test]
    fn the_speeds_that_can_be_reached_are_those_of_all_motions_tried() {
        let cases = [
            (0.0, 0.3, 1.0, 2.0),
            (1.0, 0.5, 1.0, 2.0),
            (1.0, 0.2, 1.0, 3.0),
            (1.5, 1.2, 1.0, 1.0),
            (0.2, 1.0, 1.0, 2.0),
            (2.0, 0.5, 2.0, 2.0),
        ];
        for (u, way, seconds, limit) in cases {
            let tried = tried(u, way, seconds, limit);
            let found = speeds_after((u, u), way, seconds, limit);
            match (tried, found) {
                (Some(tried), Some(found)) => {
                    // Motions back are not tried.
                    let apart = (tried.0 - found.0.max(0.0)).abs().max((tried.1 - found.1).abs());
                    assert!(apart < 0.1, "{u} {way}: {tried:?} {found:?}");
                }
                _ => assert_eq!(tried.is_some(), found.is_some(), "{u} {way}"),
            }
            let mirrored = speeds_after((-u, -u), -way, seconds, limit);
            assert_eq!(mirrored, found.map(|(low, high)| (-high, -low)));
        }
    }

    #[test]
    fn the_waypoint_that_is_not_reached_in_time_is_named() {
        let at = |time: f64, q: f64| crate::check_robot::waypoint(time, q, 0.0);
        let motion = [at(0.0, 0.0), at(1.0, 0.0), at(2.0, 0.0), at(3.0, 2.0), at(4.0, 2.0)];
        let first = |count: usize, limit: f64| {
            first_unreachable(&motion[..count], crate::check_robot::SHOULDER, limit)
        };
        assert_eq!([first(5, 8.1), first(5, 3.9), first(5, 4.2)], [None, Some(3), Some(4)]);
        // It is there in time, and cannot stand.
        assert_eq!([first(4, 8.1), first(4, 7.9), first(4, 5.0)], [None, Some(3), Some(3)]);
    }

    #[test]
    fn no_number_is_no_speed() {
        for numbers in [(f64::NAN, 0.1, 1.0), (0.0, f64::NAN, 1.0), (0.0, 0.1, f64::NAN)] {
            let (speed, way, seconds) = numbers;
            assert_eq!(speeds_after((speed, speed), way, seconds, 10.0), None, "{numbers:?}");
        }
    }

    #[test]
    fn a_wait_gives_no_run_up() {
        let back = (2.0 * 10.0 * TRAVEL_BACK_MAX).sqrt();
        let (lowest, highest) = speeds_after((0.0, 0.0), 0.0, 2.0, 10.0).unwrap();
        assert!(lowest >= -back && highest <= back, "{lowest} {highest} {back}");
        assert_eq!(speeds_after((0.5, 1.0), 0.0, 2.0, 10.0), None);
        assert_eq!(speeds_after((0.5, 1.0), -0.1, 2.0, 10.0), None);
    }
    /// Speed and place of a joint, and how far it has moved against its way.
    #[derive(Clone, Copy)]
    struct Joint {
        speed: f64,
        place: f64,
        back: f64,
    }

    impl Joint {
        fn at(speed: f64) -> Self {
            Self { speed, place: 0.0, back: 0.0 }
        }

        /// After a constant acceleration.
        fn after(self, acceleration: f64, seconds: f64) -> Self {
            let speed = self.speed + acceleration * seconds;
            let place = self.place + 0.5 * (self.speed + speed) * seconds;
            // Where the speed changes its sign, the joint goes back before or after that.
            let turn = if self.speed * speed < 0.0 { self.speed / -acceleration } else { 0.0 };
            let before = 0.5 * self.speed * turn;
            let after = place - self.place - before;
            let back = (-before).max(0.0) + (-after).max(0.0);
            Self { speed, place, back: self.back + back }
        }
    }

    #[test]
    fn every_motion_within_the_limit_ends_at_a_speed_that_can_be_reached() {
        let mut random = randoms(7);
        let mut tried = 0;
        for _ in 0..20_000 {
            let limit = random(0.5, 10.0);
            let least = random(0.0, 1.5);
            let most = least + random(0.0, 0.5);
            let mut joint = Joint::at(random(least, most));
            let mut seconds = 0.0;
            for _ in 0..4 {
                let piece = random(0.0, 0.4);
                joint = joint.after(random(-limit, limit), piece);
                seconds += piece;
            }
            if joint.back > TRAVEL_BACK_MAX || joint.speed < 0.0 || joint.place < 0.0 {
                continue;
            }
            tried += 1;
            let found = speeds_after((least, most), joint.place, seconds, limit);
            let (low, high) = found.expect("a motion goes there");
            assert!(low <= joint.speed + 1e-9 && joint.speed <= high + 1e-9, "{low} {high}");
        }
        assert!(tried > 2_000, "{tried}");
    }

    /// The end of a motion that accelerates by `first` and then by the opposite, and covers `way`.
    fn two_pieces(speed: f64, first: f64, way: f64, seconds: f64) -> Option<Joint> {
        let end =
            |switch: f64| Joint::at(speed).after(first, switch).after(-first, seconds - switch);
        let (mut low, mut high) = (0.0, seconds);
        let is_short = |switch: f64| (end(switch).place < way) == (first > 0.0);
        if !is_short(low) || is_short(high) {
            return None;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if is_short(middle) { low = middle } else { high = middle }
        }
        Some(end(low))
    }

    #[test]
    fn the_fastest_and_the_slowest_end_are_those_of_late_and_of_early_acceleration() {
        let mut random = randoms(7);
        let (mut fastest, mut slowest) = (0, 0);
        for _ in 0..5_000 {
            let (limit, seconds) = (random(0.5, 10.0), random(0.2, 1.5));
            let (speed, way) = (random(0.0, 1.5), random(0.0, 1.5));
            let found = speeds_after((speed, speed), way, seconds, limit);
            if let Some(late) = two_pieces(speed, -limit, way, seconds)
                && late.back <= TRAVEL_BACK_MAX
                && late.speed >= 0.0
            {
                let (_, high) = found.expect("late acceleration goes there");
                assert!((high - late.speed).abs() < 1e-6, "{high} {}", late.speed);
                fastest += 1;
            }
            if let Some(early) = two_pieces(speed, limit, way, seconds)
                && early.speed >= 0.0
            {
                let (low, _) = found.expect("early acceleration goes there");
                assert!((low - early.speed).abs() < 1e-6, "{low} {}", early.speed);
                slowest += 1;
            }
        }
        assert!(fastest > 300 && slowest > 300, "{fastest} {slowest}");
    }

    #[test]
    fn among_several_speeds_the_best_one_before_counts() {
        // At 2 rad/s2 over 0.5 rad within 1 s, accelerating or braking all the time ends fastest
        // and slowest: from -0.5 rad/s to 1.5, from 1.5 to -0.5.
        assert_eq!(speeds_after((0.0, 2.0), 1.0, 1.0, 1.0), Some((0.5, 1.5)));
        assert_eq!(speeds_after((0.7, 2.0), 1.0, 1.0, 1.0).unwrap().0, 0.5);
        assert_eq!(speeds_after((0.0, 1.3), 1.0, 1.0, 1.0).unwrap().1, 1.5);
        // Half the way is too fast for all of them, twice the way too slow.
        assert_eq!(speeds_after((1.6, 2.0), 0.5, 1.0, 1.0), None);
        assert_eq!(speeds_after((0.0, 1.4), 2.0, 1.0, 1.0), None);
    }

    #[test]
    fn a_run_up_is_as_long_as_a_joint_may_move_back() {
        let run_up = |speed: f64, way: f64, limit: f64| {
            speeds_after((speed, speed), way, 3.0, limit).unwrap().1
        };
        for (speed, way, limit) in [(0.0, 0.05, 10.0), (0.5, 0.05, 10.0), (0.3, 0.2, 2.0)] {
            // It brakes to rest, goes back by the travel allowed, and accelerates over the rest.
            let braking = 0.5 * speed * speed / limit;
            let from_rest = (2.0 * limit * (way - braking + TRAVEL_BACK_MAX)).sqrt();
            assert!((run_up(speed, way, limit) - from_rest).abs() < 1e-9);
        }
        // A joint that moves back stops within the travel allowed.
        let back = (2.0 * 5.0 * TRAVEL_BACK_MAX).sqrt();
        assert!(speeds_after((-0.999 * back, -0.999 * back), 0.1, 1.0, 5.0).is_some());
        assert_eq!(speeds_after((-1.01 * back, -1.01 * back), 0.1, 1.0, 5.0), None);
        assert_eq!(speeds_after((0.0, 0.0), 0.001, 1.0, 5.0).unwrap().0, -back);
    }

    #[test]
    fn the_least_share_is_rounded_up_by_a_hundredth_and_the_limit_itself_is_tried() {
        let least = |needed: f64| least_share(|share| share >= needed);
        for exponent in -14..31 {
            for factor in [1.0, 1.2, 1.7] {
                let needed = factor * 2.0_f64.powi(exponent) * 1e-1;
                let found = least(needed);
                let most = (SHARE_RATIO * needed).max(1e-3);
                assert!(needed <= found && found <= most, "{needed} {found}");
            }
        }
        assert_eq!(least(0.0), 0.0);
        assert_eq!([least(0.9999), least(1.0)], [1.0, 1.0]);
        assert!(least(1.000_001) > 1.0 && least(0.5) < 1.0);
        assert_eq!(least(f64::INFINITY), SHARE_MAX);
    }
}
