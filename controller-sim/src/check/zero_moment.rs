//! The zero-moment point of the moving robot stays where the contacts can hold it.
//!
//! A smooth motion has accelerations: the point is that of the whole robot's wrench by Newton and
//! Euler, at every waypoint and while the robot brakes. Straight lines have none, because their
//! speed jumps at waypoints. A robot follows them to within millimetres with accelerations that
//! last longer. So the acceleration of the centre of mass counts as the change of its mean speed
//! from one window of time to the next one, at rest before and after the segment.

use glam::{DVec2, DVec3};
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::{Check, Waypoint};
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::GRAVITY;

use crate::base::comparison::{is_at_most, largest};
use crate::check::segment::{Case, Violation};
use crate::kinematics::forward::{Configuration, Posture};
use crate::statics::equilibrium::{ALL_FRICTION, Equilibrium, Region};
use crate::statics::inverse_dynamics::InverseDynamics;

/// The window of time over which a speed counts, s. The planner spreads changes of speed over as
/// long. The check accepts the planner's quasi-static plans, and refuses a walk of hubo in 0.35 of
/// its time.
const WINDOW: f64 = 0.2;

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
    let support = Support {
        region: equilibrium.region(&case.supports, ALL_FRICTION),
        height: ground_height(case),
        margin_min: config.com_margin,
        force_angle_max: force_angle_max(equilibrium, case),
    };
    if !case.is_smooth() {
        return check_straight(&support, case);
    }
    let mut worst = f64::INFINITY;
    for (index, instant) in &case.instants {
        let configuration = Configuration::of_waypoint(instant, model.joints.len());
        let posture = Posture::new(model, &configuration);
        let wrench = InverseDynamics::new(model, &posture, instant).contacts;
        let point = wrench.zero_moment_point(support.height);
        worst = worst.min(support.check(point.truncate(), *index)?);
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

    fn check(&self, point: DVec2, waypoint: usize) -> Result<f64, Violation> {
        let margin = self.region.margin(point.extend(self.height));
        if point.is_finite() && is_at_most(self.margin_min, margin) {
            return Ok(margin);
        }
        let detail = format!(
            "the zero-moment point is {:.2} mm inside the region that the contacts can hold, at \
             least {:.2} mm are needed: the motion is too fast",
            1e3 * margin,
            1e3 * self.margin_min
        );
        Err(Violation::new(Check::ZeroMoment, waypoint, detail))
    }
}

/// The largest angle to the vertical of a force within the friction cone of any contact point, rad;
/// no sum of such forces has a larger one.
fn force_angle_max(equilibrium: &Equilibrium, case: &Case) -> f64 {
    let points = case.supports.iter().flat_map(|support| &support.points);
    let tilt = largest(points.map(|point| libm::acos(point.normal.z.clamp(-1.0, 1.0))));
    libm::atan(equilibrium.mu()) + tilt
}

/// The mean height of the soles' supports, m: each counts the same, however many points it has.
fn ground_height(case: &Case) -> f64 {
    let heights = case.supports.iter().map(|support| {
        let count = support.points.len().max(1) as f64;
        support.points.iter().map(|point| point.position.z).sum::<f64>() / count
    });
    heights.sum::<f64>() / case.supports.len().max(1) as f64
}

/// The zero-moment point at every instant at which its windowed value may be extreme: at the
/// waypoints, and a window before and after them.
fn check_straight(support: &Support, case: &Case) -> Result<f64, Violation> {
    let track = CentreTrack::new(case);
    let (begin, end) = track.ends();
    let mut worst = f64::INFINITY;
    for (index, (time, _)) in track.0.iter().enumerate() {
        for instant in [*time, time - WINDOW, time + WINDOW] {
            if !(begin..=end).contains(&instant) {
                continue;
            }
            let [before, here, after] =
                [instant - WINDOW, instant, instant + WINDOW].map(|time| track.at(time));
            let acceleration = (after - 2.0 * here + before) / (WINDOW * WINDOW);
            let press = GRAVITY + acceleration.z;
            let lever = (here.z - support.height) / if press > 0.0 { press } else { f64::NAN };
            let point = here.truncate() - lever * acceleration.truncate();
            worst = worst.min(support.check(point, index)?);
            support.check_force(acceleration, index)?;
        }
    }
    Ok(worst)
}

/// The centre of mass at the waypoints, each with its time.
struct CentreTrack(Vec<(f64, DVec3)>);

impl CentreTrack {
    fn new(case: &Case) -> Self {
        let at_waypoints = case.motion.samples.iter().filter(|sample| sample.is_waypoint());
        let centre = |(waypoint, centre): (&Waypoint, DVec3)| (waypoint.time, centre);
        let centres = at_waypoints.map(|sample| sample.centre_of_mass);
        Self(case.waypoints.iter().zip(centres).map(centre).collect())
    }

    fn ends(&self) -> (f64, f64) {
        let end = |end: Option<&(f64, DVec3)>| end.map_or(0.0, |(time, _)| *time);
        (end(self.0.first()), end(self.0.last()))
    }

    /// The centre of mass at a time: linear between waypoints, at rest outside of them.
    fn at(&self, time: f64) -> DVec3 {
        let next = self.0.partition_point(|(at, _)| *at <= time);
        let Some(&(from, start)) = next.checked_sub(1).map(|before| &self.0[before]) else {
            return self.0[0].1;
        };
        self.0.get(next).map_or(start, |&(to, end)| start.lerp(end, (time - from) / (to - from)))
    }
}
