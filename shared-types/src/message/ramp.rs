//! How plan time slows down and speeds up: the robot walks a plan's path at a rate between 0 and 1.
//!
//! Over a ramp of duration `D`, with `u = t / D`, the rate falls as `1 - (10 u^3 - 15 u^4 + 6 u^5)`
//! or rises as `10 u^3 - 15 u^4 + 6 u^5`. It has no jump in its second derivative at either end,
//! and plan time advances by `D / 2` in all. At plan time `p(t)` with rate `r = dp/dt`, the
//! configuration is `q(p)`, the velocity `r q'(p)`, the acceleration `r^2 q''(p) + r' q'(p)`, the
//! feed-forward torque `rest_torque + r^2 (torque - rest_torque) + r' rate_change_torque`.

use crate::message::chunk::Waypoint;

/// A ramp of the rate of plan time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Ramp {
    /// The rate falls from 1 to 0.
    Brake {
        /// Its duration, s.
        seconds: f64,
    },
    /// The rate rises from 0 to 1.
    Resume {
        /// Its duration, s.
        seconds: f64,
    },
}

/// Plan time and its derivatives at an instant of a ramp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanTime {
    /// Plan time since the beginning of the ramp, s.
    pub elapsed: f64,
    /// Its rate, seconds of the plan a second.
    pub rate: f64,
    /// The derivative of the rate, 1/s.
    pub rate_change: f64,
}

impl Ramp {
    /// Its duration, s.
    pub fn seconds(self) -> f64 {
        let (Self::Brake { seconds } | Self::Resume { seconds }) = self;
        seconds
    }

    /// How far plan time advances over the whole ramp, s.
    pub fn advance(self) -> f64 {
        0.5 * self.seconds()
    }

    /// Plan time `t` seconds after the beginning of the ramp, within its duration.
    pub fn at(self, t: f64) -> PlanTime {
        let seconds = self.seconds();
        let u = if seconds > 0.0 { (t / seconds).clamp(0.0, 1.0) } else { 1.0 };
        let risen = u * u * u * (10.0 - u * (15.0 - 6.0 * u));
        let area = seconds * u * u * u * u * (2.5 - u * (3.0 - u));
        let slope =
            if seconds > 0.0 { 30.0 * u * u * (1.0 - u) * (1.0 - u) / seconds } else { 0.0 };
        match self {
            Self::Resume { .. } => PlanTime { elapsed: area, rate: risen, rate_change: slope },
            Self::Brake { .. } => {
                PlanTime { elapsed: seconds * u - area, rate: 1.0 - risen, rate_change: -slope }
            }
        }
    }
}

impl PlanTime {
    /// The robot's motion at this rate, where `planned` is the plan's own at its instant, with its
    /// feed-forward torque. The torques at rest and by the rate's change stay the planned ones.
    pub fn apply(&self, planned: &Waypoint) -> Waypoint {
        let (rate, change) = (self.rate, self.rate_change);
        let slowed = |velocity: f64, acceleration: f64| {
            (rate * velocity, rate * rate * acceleration + change * velocity)
        };
        let mut waypoint = *planned;
        for (velocity, acceleration) in
            waypoint.root_velocity.iter_mut().zip(&mut waypoint.root_acceleration)
        {
            (*velocity, *acceleration) = slowed(*velocity, *acceleration);
        }
        for (velocity, acceleration) in
            waypoint.joint_velocity.iter_mut().zip(&mut waypoint.joint_acceleration)
        {
            (*velocity, *acceleration) = slowed(*velocity, *acceleration);
        }
        let torques = planned.torque.iter().zip(&planned.rest_torque);
        let torques = torques.zip(&planned.rate_change_torque);
        for (slot, ((moving, rest), by_change)) in waypoint.torque.iter_mut().zip(torques) {
            *slot = rest + rate * rate * (moving - rest) + change * by_change;
        }
        waypoint
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rate_is_the_derivative_of_plan_time_and_half_the_duration_passes() {
        for ramp in [Ramp::Brake { seconds: 0.4 }, Ramp::Resume { seconds: 0.3 }] {
            let step = 1e-5;
            for tick in 1..100 {
                let t = ramp.seconds() * f64::from(tick) / 100.0;
                let [before, here, after] = [t - step, t, t + step].map(|t| ramp.at(t));
                let rate = (after.elapsed - before.elapsed) / (2.0 * step);
                let change = (after.rate - before.rate) / (2.0 * step);
                assert!((rate - here.rate).abs() < 1e-8, "{ramp:?} at {t}: {rate} {here:?}");
                assert!((change - here.rate_change).abs() < 1e-6, "{ramp:?}: {change} {here:?}");
            }
            let end = ramp.at(ramp.seconds());
            assert!((end.elapsed - ramp.advance()).abs() < 1e-15 && end.rate_change == 0.0);
            assert_eq!(end.rate, f64::from(matches!(ramp, Ramp::Resume { .. })));
            assert_eq!(ramp.at(0.0).elapsed, 0.0);
        }
    }

    #[test]
    fn torque_goes_to_that_at_rest_and_with_the_change_of_the_rate() {
        let mut planned: Waypoint = bytemuck::Zeroable::zeroed();
        (planned.torque[1], planned.rest_torque[1], planned.rate_change_torque[1]) =
            (8.0, 4.0, 0.5);
        let torque = |rate: f64, rate_change: f64| {
            PlanTime { elapsed: 0.0, rate, rate_change }.apply(&planned).torque[1]
        };
        assert_eq!([torque(1.0, 0.0), torque(0.0, 0.0)], [8.0, 4.0]);
        assert_eq!([torque(0.5, 0.0), torque(0.5, -2.0)], [5.0, 4.0]);
    }

    #[test]
    fn a_ramp_without_duration_is_over_at_once() {
        let stop = Ramp::Brake { seconds: 0.0 }.at(0.0);
        assert_eq!((stop.elapsed, stop.rate, stop.rate_change), (0.0, 0.0, 0.0));
    }
}
