//! The zero-moment point of the moving robot stays where the contacts can hold it.
//!
//! A smooth motion has accelerations: the point is that of the whole robot's wrench by Newton and
//! Euler, at every waypoint and while the robot brakes. Straight lines have none, because their
//! speed jumps at waypoints. A robot follows them to within millimetres with accelerations that
//! last longer. So the acceleration of the centre of mass counts as the change of its mean speed
//! from one window of time to the next one, at rest before and after the segment, and so does the
//! change of the angular momentum about it.

use glam::{DVec2, DVec3};
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::Check;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::GRAVITY;

use crate::base::comparison::{is_at_most, largest};
use crate::check::centre_track::CentreTrack;
use crate::check::segment::{Case, Violation};
use crate::kinematics::forward::{Configuration, Posture};
use crate::statics::equilibrium::{ALL_FRICTION, Equilibrium, Region};
use crate::statics::inverse_dynamics::InverseDynamics;
use crate::statics::sole_support::{ContactPoint, SoleSupport};

/// The window of time over which a speed counts, s. The planner spreads changes of speed over as
/// long. The check accepts the planner's quasi-static plans, and refuses a walk of hubo in 0.35 of
/// its time.
const WINDOW: f64 = 0.2;

/// A moment about the vertical beyond friction by less than this turns a robot by some milliradians
/// within a window, by the weight, m.
const TWIST_ROUNDING: f64 = 5e-4;

/// How far inside the region the zero-moment point stays on straight lines when the change of the
/// angular momentum counts, m. How a robot smooths a jump of it is less known than for the centre
/// of mass: G1 over terrain at half of the plan's speed has 3.7 mm, and stands in a replay.
const TURNING_MARGIN_MIN: f64 = 0.0;

/// The smallest distance of the zero-moment point to the edge of the equilibrium region and of the
/// contacts' hull, m.
///
/// # Errors
/// The first instant at which it is less than the checker's `com_margin`.
pub fn check_zero_moment(
    model: &RobotModel,
    config: &CheckerConfig,
    equilibrium: &mut Equilibrium,
    case: &Case,
) -> Result<f64, Violation> {
    let friction_centre = friction_centre(&case.supports);
    let support = Support {
        region: equilibrium.region(&case.supports, ALL_FRICTION),
        height: ground_height(&case.supports),
        margin_min: config.com_margin,
        force_angle_max: force_angle_max(equilibrium, &case.supports),
        friction_centre,
        twist_max: twist_max(equilibrium, &case.supports, friction_centre),
    };
    if !case.is_smooth() {
        return check_straight(&support, &CentreTrack::new(model, case));
    }
    let mut worst = f64::INFINITY;
    for (index, instant) in &case.instants {
        let configuration = Configuration::of_waypoint(instant, model.joints.len());
        let posture = Posture::new(model, &configuration);
        let wrench = InverseDynamics::new(model, &posture, instant).contacts;
        let point = wrench.zero_moment_point(support.height);
        worst = worst.min(support.check(point.truncate(), support.margin_min, *index)?);
    }
    Ok(worst)
}

/// What holds the zero-moment point.
struct Support {
    region: Region,
    /// The height at which the point is taken, m.
    height: f64,
    margin_min: f64,
    /// The largest angle of a force that the contacts can exert to the vertical, rad.
    force_angle_max: f64,
    /// A point between the contacts, m.
    friction_centre: DVec2,
    /// The largest moment about the vertical through it, by the force that presses down, m.
    twist_max: f64,
}

impl Support {
    /// Whether the contacts can exert the force of this acceleration of the centre of mass within
    /// friction.
    fn check_force(&self, acceleration: DVec3, waypoint: usize) -> Result<(), Violation> {
        let (across, up) = (acceleration.truncate().length(), GRAVITY + acceleration.z);
        let angle = libm::atan2(across, up);
        if is_at_most(angle, self.force_angle_max) {
            return Ok(());
        }
        let detail = format!(
            "the motion needs a force {:.1} degrees off the vertical, friction holds {:.1}: it is \
             too fast",
            angle.to_degrees(),
            self.force_angle_max.to_degrees()
        );
        Err(Violation::new(Check::ZeroMoment, waypoint, detail))
    }

    /// Whether the contacts can change the motion so.
    fn check_change(&self, change: &Change, waypoint: usize) -> Result<f64, Violation> {
        let Change { centre, acceleration, spin } = *change;
        let press = GRAVITY + acceleration.z;
        let press = if press > 0.0 { press } else { f64::NAN };
        let lever = (centre.z - self.height) / press;
        let turning = DVec2::new(-spin.y, spin.x) / press;
        let point = centre.truncate() - lever * acceleration.truncate();
        let margin = self.check(point, self.margin_min, waypoint)?;
        let turned = self.check(point + turning, TURNING_MARGIN_MIN, waypoint)?;
        self.check_force(acceleration, waypoint)?;
        self.check_twist(change, press, waypoint)?;
        Ok(margin.min(turned))
    }

    /// Whether friction can turn the robot about the vertical so, beside the horizontal force.
    fn check_twist(&self, change: &Change, press: f64, waypoint: usize) -> Result<(), Violation> {
        let arm = self.friction_centre - change.centre.truncate();
        let twist = (change.spin.z - arm.perp_dot(change.acceleration.truncate())).abs() / press;
        if is_at_most(twist, self.twist_max + TWIST_ROUNDING) {
            return Ok(());
        }
        let detail = format!(
            "the motion turns the robot about the vertical with {:.1} mm of its weight, friction \
             holds at most {:.1} mm: it is too fast",
            1e3 * twist,
            1e3 * self.twist_max
        );
        Err(Violation::new(Check::ZeroMoment, waypoint, detail))
    }

    /// The distance of a zero-moment point to the edge of the region, at least `needed` (m).
    fn check(&self, point: DVec2, needed: f64, waypoint: usize) -> Result<f64, Violation> {
        let margin = self.region.margin(point.extend(self.height));
        if point.is_finite() && is_at_most(needed, margin) {
            return Ok(margin);
        }
        let detail = format!(
            "the zero-moment point is {:.2} mm inside the region that the contacts can hold, at \
             least {:.2} mm are needed: the motion is too fast",
            1e3 * margin,
            1e3 * needed
        );
        Err(Violation::new(Check::ZeroMoment, waypoint, detail))
    }
}

/// The largest angle to the vertical of a force within the friction cone of any contact point, rad;
/// no sum of such forces has a larger one.
fn force_angle_max(equilibrium: &Equilibrium, supports: &[SoleSupport]) -> f64 {
    let points = supports.iter().flat_map(|support| &support.points);
    let tilt = largest(points.map(|point| libm::acos(point.normal.z.clamp(-1.0, 1.0))));
    libm::atan(equilibrium.mu()) + tilt
}

/// The mean of the contact points, m.
fn friction_centre(supports: &[SoleSupport]) -> DVec2 {
    let points = || supports.iter().flat_map(|support| &support.points);
    let sum: DVec2 = points().map(|point| point.position.truncate()).sum();
    sum / points().count().max(1) as f64
}

/// The largest moment about the vertical through `centre`, by the force that presses down, m: all
/// of it at the farthest contact point, with a force across as large as friction and the tilt of
/// the ground let it be. No contact forces exert more.
fn twist_max(equilibrium: &Equilibrium, supports: &[SoleSupport], centre: DVec2) -> f64 {
    let points = supports.iter().flat_map(|support| &support.points);
    let reach = largest(points.map(|point| point.position.truncate().distance(centre)));
    reach * libm::tan(force_angle_max(equilibrium, supports).min(1.5))
}

/// The mean height of the centroids of the soles' supports, m: where their vertices lie, and how
/// many there are, does not matter.
fn ground_height(supports: &[SoleSupport]) -> f64 {
    let heights = supports.iter().map(|support| centroid_height(&support.points));
    heights.sum::<f64>() / supports.len().max(1) as f64
}

/// The height of the centroid of a convex polygon, m; of a line the mean of its points'.
fn centroid_height(points: &[ContactPoint]) -> f64 {
    let at = |index: usize| points[index].position;
    let parts = (2..points.len()).map(|index| {
        let corners = [at(0), at(index - 1), at(index)];
        let area = (corners[1] - corners[0]).cross(corners[2] - corners[0]).length();
        (area, area * corners.iter().map(|corner| corner.z).sum::<f64>() / 3.0)
    });
    let (area, moment) = parts.fold((0.0, 0.0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
    if area > 0.0 {
        return moment / area;
    }
    points.iter().map(|point| point.position.z).sum::<f64>() / points.len().max(1) as f64
}

/// The zero-moment point at every instant at which its windowed value may be extreme: at the
/// waypoints, and a window before and after them. A motion to and fro within a window changes no
/// mean speed over it, so half of a window is examined, too; half of the change counts there, as
/// much as a single change counts over the whole one.
fn check_straight(support: &Support, track: &CentreTrack) -> Result<f64, Violation> {
    let (begin, end) = track.ends();
    let mut worst = f64::INFINITY;
    for (index, (time, _)) in track.0.iter().enumerate() {
        for (window, share) in [(WINDOW, 1.0), (0.5 * WINDOW, 0.5)] {
            for instant in [*time, time - window, time + window] {
                if (begin..=end).contains(&instant) {
                    let change = Change::of(track, instant, window, share);
                    worst = worst.min(support.check_change(&change, index)?);
                }
            }
        }
    }
    Ok(worst)
}

/// How the motion of the robot as a whole changes at an instant.
struct Change {
    /// The centre of mass, m.
    centre: DVec3,
    /// Its acceleration, m/s2.
    acceleration: DVec3,
    /// The change of the angular momentum about it, by mass, m2/s2.
    spin: DVec3,
}

impl Change {
    /// A share of the change from the window of time (s) before an instant to that after it.
    fn of(track: &CentreTrack, instant: f64, window: f64, share: f64) -> Self {
        let [before, here, after] =
            [instant - window, instant, instant + window].map(|time| track.at(time));
        let per_square = share / (window * window);
        Self {
            centre: here.centre,
            acceleration: per_square * (after.centre - 2.0 * here.centre + before.centre),
            spin: per_square * (after.turned - 2.0 * here.turned + before.turned),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::check::centre_track::Whole;
    use crate::check_robot::randoms;
    use crate::statics::sole_support::ContactPoint;

    use super::*;

    /// Support by points at some places, with a surface tilted about y.
    fn sole(places: &[[f64; 3]], tilt: f64) -> SoleSupport {
        let normal = DVec3::new(libm::sin(tilt), 0.0, libm::cos(tilt));
        let point = |place: &[f64; 3]| ContactPoint { position: (*place).into(), normal };
        let points = places.iter().map(point).collect();
        SoleSupport { limb: 0, area: 0.01, deepest: 0.0, points }
    }

    const SQUARE: [[f64; 3]; 4] =
        [[-1.0, -1.0, 0.5], [1.0, -1.0, 0.5], [1.0, 1.0, 0.5], [-1.0, 1.0, 0.5]];

    #[test]
    fn the_corners_of_a_sole_do_not_move_the_height_of_the_ground() {
        let sloped = [[0.0, 0.0, 0.0], [0.4, 0.0, 0.2], [0.4, 0.1, 0.2], [0.0, 0.1, 0.0]];
        let rounded = [[0.0, 0.05, 0.0], [0.0, 0.09, 0.0]];
        let more: Vec<[f64; 3]> = sloped.into_iter().chain(rounded.into_iter().rev()).collect();
        for corners in [sloped.as_slice(), &more] {
            assert!((ground_height(&[sole(corners, 0.0)]) - 0.1).abs() < 1e-12);
        }
    }

    #[test]
    fn every_sole_counts_the_same_in_the_height_of_the_ground() {
        let two = sole(&[[0.0, 0.0, 0.2], [0.0, 1.0, 0.4]], 0.0);
        assert!((ground_height(&[sole(&SQUARE, 0.0), two.clone()]) - 0.4).abs() < 1e-12);
        assert!((ground_height(&[two]) - 0.3).abs() < 1e-12);
        assert_eq!(ground_height(&[]), 0.0);
    }

    #[test]
    fn a_force_leans_as_far_as_the_steepest_contact_and_friction_let_it() {
        let equilibrium = Equilibrium::new(0.5);
        let level = force_angle_max(&equilibrium, &[sole(&SQUARE, 0.0)]);
        assert!((level - libm::atan(0.5)).abs() < 1e-12);
        let sloped = force_angle_max(&equilibrium, &[sole(&SQUARE, 0.0), sole(&SQUARE, -0.3)]);
        assert!((sloped - libm::atan(0.5) - 0.3).abs() < 1e-9);
    }

    fn support(margin_min: f64, force_angle_max: f64) -> Support {
        let region = Equilibrium::new(0.8).region(&[sole(&SQUARE, 0.0)], ALL_FRICTION);
        let (friction_centre, twist_max) = (DVec2::ZERO, 1.0);
        Support { region, height: 0.5, margin_min, force_angle_max, friction_centre, twist_max }
    }

    /// A robot whose centre of mass is at these places at these times, and does not turn.
    fn track(places: &[(f64, DVec3)]) -> CentreTrack {
        let whole = |&(time, centre): &(f64, DVec3)| (time, Whole { centre, turned: DVec3::ZERO });
        CentreTrack(places.iter().map(whole).collect())
    }

    /// The smallest margin in the square, and the largest angle of the force, over all instants.
    fn worst_of_all_instants(places: &[(f64, DVec3)]) -> (f64, f64) {
        let windows = [(WINDOW, 1.0), (0.5 * WINDOW, 0.5)];
        let worst = windows.map(|window| worst_of_windows(places, window));
        (worst[0].0.min(worst[1].0), worst[0].1.max(worst[1].1))
    }

    fn worst_of_windows(places: &[(f64, DVec3)], (window, share): (f64, f64)) -> (f64, f64) {
        let (begin, end) = (places[0].0, places[places.len() - 1].0);
        let centre = |time: f64| {
            let time = time.clamp(begin, end);
            let after = places.iter().position(|(at, _)| *at >= time).unwrap().max(1);
            let [(from, a), (to, b)] = [places[after - 1], places[after]];
            a + (b - a) * ((time - from) / (to - from))
        };
        let (mut margin, mut angle) = (f64::INFINITY, 0.0_f64);
        for step in 0..=2_000 {
            let time = begin + (end - begin) * f64::from(step) / 2_000.0;
            let here = centre(time);
            let speeds = [(time - window, time), (time, time + window)]
                .map(|(from, to)| (centre(to) - centre(from)) / window);
            let acceleration = share * (speeds[1] - speeds[0]) / window;
            let force = acceleration + DVec3::new(0.0, 0.0, GRAVITY);
            let point = here - force * ((here.z - 0.5) / force.z);
            margin = margin.min(1.0 - point.x.abs().max(point.y.abs()));
            angle = angle.max(force.angle_between(DVec3::Z));
        }
        (margin, angle)
    }

    #[test]
    fn the_worst_instant_of_straight_lines_is_that_of_all_instants() {
        let mut between = randoms(5);
        for _ in 0..100 {
            let (mut time, mut at) = (between(-3.0, 3.0), DVec3::new(0.1, -0.2, 1.3));
            let mut places = vec![(time, at)];
            for _ in 0..5 {
                time += between(0.05, 0.5);
                at += DVec3::new(between(-0.05, 0.05), between(-0.05, 0.05), between(-0.03, 0.03));
                places.push((time, at));
            }
            let (margin, angle) = worst_of_all_instants(&places);
            let track = track(&places);
            let found = check_straight(&support(-1.0, 1.5), &track).unwrap();
            assert!((found - margin).abs() < 1e-3, "{found} {margin}");
            // Both limits on both sides.
            assert!(check_straight(&support(margin - 2e-3, angle + 2e-3), &track).is_ok());
            assert!(check_straight(&support(margin + 2e-3, angle + 2e-3), &track).is_err());
            assert!(check_straight(&support(margin - 2e-3, angle - 2e-3), &track).is_err());
        }
    }

    #[test]
    fn a_robot_in_free_fall_is_refused() {
        // Within a window the centre falls faster than gravity lets it.
        let fall = |depth: f64| {
            let at = |z: f64| DVec3::new(0.0, 0.0, z);
            let places = [2.0, 2.0, 2.0 - depth, 2.0 - depth].map(at);
            track(&[0.0, 1.0, 1.2, 2.0].into_iter().zip(places).collect::<Vec<_>>())
        };
        assert!(check_straight(&support(0.0, 1.5), &fall(0.3)).is_ok());
        assert!(check_straight(&support(0.0, 1.5), &fall(0.5)).is_err());
    }

    #[test]
    fn a_motion_to_and_fro_within_a_window_is_seen() {
        let sway = |amplitude: f64, period: f64| {
            let places = (0..20).map(|index| {
                let side = amplitude * f64::from(index % 2);
                (0.5 * period * f64::from(index), DVec3::new(side, 0.0, 1.5))
            });
            check_straight(&support(0.0, 1.5), &track(&places.collect::<Vec<_>>())).unwrap()
        };
        // To and fro in 0.2 s: half of 4 times the amplitude by 0.2 s squared counts.
        let shift = 0.5 * 2.0 * 0.01 / (0.1 * 0.1) / GRAVITY;
        assert!((sway(0.01, 0.2) - (1.0 - 0.01 - shift)).abs() < 1e-9, "{}", sway(0.01, 0.2));
    }

    #[test]
    fn a_robot_that_turns_faster_than_friction_lets_it_is_refused() {
        let spinning = |axis: DVec3, turn: f64| {
            let at = |time: f64, turned: DVec3| {
                (time, Whole { centre: DVec3::new(0.0, 0.0, 1.5), turned })
            };
            CentreTrack(vec![
                at(0.0, DVec3::ZERO),
                at(1.0, DVec3::ZERO),
                at(1.2, turn * axis),
                at(2.0, turn * axis),
            ])
        };
        let twist = |turn: f64| turn / (WINDOW * WINDOW) / GRAVITY;
        let tight = |most: f64| Support { twist_max: most - TWIST_ROUNDING, ..support(0.0, 1.5) };
        let about_z = spinning(DVec3::Z, 0.01);
        assert!(check_straight(&tight(twist(0.0101)), &about_z).is_ok());
        let violation = check_straight(&tight(twist(0.0099)), &about_z).unwrap_err();
        assert!(violation.detail.contains("about the vertical"), "{violation}");
        // About an axis across, the zero-moment point moves by the same lever.
        for axis in [DVec3::X, DVec3::Y] {
            let margin = check_straight(&tight(1e-3), &spinning(axis, 0.01)).unwrap();
            assert!((margin - (1.0 - twist(0.01))).abs() < 1e-9, "{margin}");
        }
    }

    #[test]
    fn a_robot_that_turns_moves_the_zero_moment_point_to_the_side_that_turns_it() {
        // The angular momentum grows as the moment of the ground's force about the centre of mass,
        // which is 0.1 m from the edge when the turn begins and 1 m when it ends.
        let speed = 0.05 * GRAVITY * WINDOW;
        for [out, axis] in [[DVec3::X, -DVec3::Y], [DVec3::Y, DVec3::X]] {
            let margin = |sign: f64| {
                let at = |time: f64, away: f64, turned: f64| {
                    let centre = away * out + 1.5 * DVec3::Z;
                    (time, Whole { centre, turned: sign * turned * speed * axis })
                };
                let times = [at(0.0, 0.9, 0.0), at(1.0, 0.9, 0.0), at(201.0, 0.0, 200.0)];
                check_straight(&support(0.0, 1.5), &CentreTrack(times.to_vec())).unwrap()
            };
            // Outwards by 0.05 m, or inwards. The centre moves at 4.5 mm/s.
            assert!((margin(1.0) - 0.05).abs() < 5e-3, "{}", margin(1.0));
            assert!((margin(-1.0) - 0.1).abs() < 5e-3, "{}", margin(-1.0));
        }
    }

    #[test]
    fn with_a_turn_the_zero_moment_point_stays_inside_the_region_without_a_margin() {
        let change = |spin: f64| Change {
            centre: DVec3::new(0.0, 0.0, 1.5),
            acceleration: DVec3::ZERO,
            spin: spin * GRAVITY * DVec3::X,
        };
        let inside = support(0.5, 1.5).check_change(&change(0.999), 0).unwrap();
        assert!((inside - 1e-3).abs() < 1e-9, "{inside}");
        assert!(support(0.5, 1.5).check_change(&change(1.001), 0).is_err());
    }

    #[test]
    fn a_force_across_beside_the_centre_of_mass_turns_the_robot() {
        // The force acts at the origin, 0.5 m beside the centre of mass: its moment about the
        // vertical is 0.5 m times the acceleration along x.
        let change = |spin: f64| Change {
            centre: DVec3::new(0.0, 0.5, 1.5),
            acceleration: DVec3::X,
            spin: spin * DVec3::Z,
        };
        let holds = |spin: f64, twist_max: f64| {
            let support = Support { twist_max, ..support(-10.0, 1.5) };
            support.check_twist(&change(spin), GRAVITY, 0).is_ok()
        };
        assert!(holds(0.5, 0.0) && holds(0.0, 0.0505) && !holds(0.0, 0.05));
        assert!(holds(-0.5, 0.1015) && !holds(-0.5, 0.101));
    }

    #[test]
    fn the_largest_twist_is_that_of_friction_at_the_farthest_point() {
        let equilibrium = Equilibrium::new(0.5);
        let supports = [sole(&SQUARE, 0.0)];
        let twist = twist_max(&equilibrium, &supports, friction_centre(&supports));
        assert!((twist - 0.5 * std::f64::consts::SQRT_2).abs() < 1e-9, "{twist}");
    }
}
