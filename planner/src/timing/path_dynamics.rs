//! The dynamics at a point of a path: the wrench of all contacts and the joints' torques are
//! `a u + b x + g`, linear in the path's acceleration `u` and its squared speed `x`.

use glam::{DMat3, DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;

use crate::robot::inverse_dynamics::{GeneralizedForce, InverseDynamics, LinkFrames, VELOCITY_MAX};
use crate::timing::limit::Limit;
use crate::timing::limits::{Level, TimingLimits};
use crate::timing::rate_set::RateSet;
use crate::timing::support::Support;
use crate::timing::tuning::{LIMITS_PART, RATE_CHANGE_MAX, RATE_MAX};

/// The joints between the root and each foot.
pub(crate) type Chains = [heapless::Vec<usize, JOINTS_MAX>; 2];

/// A configuration with its derivatives by the path's parameter.
#[derive(Debug, Clone, Copy)]
pub struct PathState<'a> {
    /// Pose of the root in the world.
    pub root: &'a Pose,
    /// Joint positions.
    pub q: &'a [f64; JOINTS_MAX],
    /// First derivatives.
    pub first: &'a [f64; VELOCITY_MAX],
    /// Second derivatives.
    pub second: &'a [f64; VELOCITY_MAX],
}

/// The dynamics at a point of a path.
#[derive(Debug, Clone, Default)]
pub struct PathDynamics {
    /// Frames of the bodies.
    pub frames: LinkFrames,
    /// Part of the effort by unit of `u`.
    pub by_acceleration: GeneralizedForce,
    /// Part of the effort by unit of `x`.
    pub by_speed: GeneralizedForce,
    /// The effort at rest.
    pub standing: GeneralizedForce,
    /// Origin of the root, about which moments are taken, m.
    pub origin: DVec3,
}

/// An affine function of `u` and `x`: their factors and the constant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Affine {
    /// Factor of `x`, factor of `u`.
    pub slope: DVec2,
    /// Value at rest.
    pub constant: f64,
}

impl Affine {
    /// Its value.
    pub fn at(&self, rate: DVec2) -> f64 {
        self.slope.dot(rate) + self.constant
    }
}

impl PathDynamics {
    /// Writes the dynamics of a robot at a point of a path. The memory is new, or of the same
    /// robot.
    pub fn write(&mut self, robot: &InverseDynamics, state: &PathState<'_>, gravity: f64) {
        const REST: [f64; VELOCITY_MAX] = [0.0; VELOCITY_MAX];
        robot.place(state.root, state.q, &mut self.frames);
        self.by_acceleration = robot.effort(&self.frames, &REST, state.first, 0.0);
        self.by_speed = robot.effort(&self.frames, state.first, state.second, 0.0);
        self.standing = robot.effort(&self.frames, &REST, &REST, gravity);
        self.origin = state.root.translation;
    }

    /// A coordinate of the wrench about `point`: force x, y, z, then moment x, y, z.
    pub fn wrench(&self, coordinate: usize, point: DVec3) -> Affine {
        let of = |effort: &GeneralizedForce| {
            let moment = effort.moment + (self.origin - point).cross(effort.force);
            if coordinate < 3 { effort.force[coordinate] } else { moment[coordinate - 3] }
        };
        self.affine(of)
    }

    /// The wrench about `point` along `axes`: force, then moment.
    pub fn wrench_along(&self, axes: &DMat3, point: DVec3) -> [Affine; 6] {
        let into_axes = axes.transpose();
        let parts = [&self.by_speed, &self.by_acceleration, &self.standing].map(|effort| {
            let moment = effort.moment + (self.origin - point).cross(effort.force);
            [into_axes * effort.force, into_axes * moment]
        });
        std::array::from_fn(|coordinate| {
            let [x, u, constant] = parts.map(|part| part[coordinate / 3][coordinate % 3]);
            Affine { slope: DVec2::new(x, u), constant }
        })
    }

    /// The force and the moment about the world's origin at a rate.
    pub fn wrench_at(&self, rate: DVec2) -> (DVec3, DVec3) {
        let [force, moment] =
            [|effort: &GeneralizedForce| effort.force, |effort: &GeneralizedForce| effort.moment]
                .map(|of| {
                    of(&self.by_speed) * rate.x
                        + of(&self.by_acceleration) * rate.y
                        + of(&self.standing)
                });
        (force, moment + self.origin.cross(force))
    }

    /// A joint's torque without contacts.
    pub fn torque(&self, joint: usize) -> Affine {
        self.affine(|effort| effort.torques[joint])
    }

    /// The torque of a joint with the contacts of `support`; `None` where it depends on how they
    /// share the load.
    pub(crate) fn own_torque(
        &self,
        support: &Support,
        chains: &Chains,
        joint: usize,
    ) -> Option<Affine> {
        let is_loaded = bears_all(support, chains, joint)?;
        Some(self.affine(|effort| self.torque_of(effort, joint, is_loaded)))
    }

    /// The torque of a joint at one instant of a motion, of which all is the constant part;
    /// `is_loaded`: the only contact is beyond it.
    pub(crate) fn torque_of_instant(&self, joint: usize, is_loaded: bool) -> f64 {
        self.torque_of(&self.standing, joint, is_loaded)
    }

    /// A joint's part of an effort; `is_loaded`: the only contact is beyond it.
    fn torque_of(&self, effort: &GeneralizedForce, joint: usize, is_loaded: bool) -> f64 {
        let torque = effort.torques[joint];
        if !is_loaded {
            return torque;
        }
        let (force, moment) = (effort.force, effort.moment);
        torque - self.frames.torque_of_wrench(joint, force, moment, self.origin)
    }

    fn affine(&self, of: impl Fn(&GeneralizedForce) -> f64) -> Affine {
        let slope = DVec2::new(of(&self.by_speed), of(&self.by_acceleration));
        Affine { slope, constant: of(&self.standing) }
    }
}

/// Whether the only contact is beyond a joint; `None` where one of two is.
pub(crate) fn bears_all(support: &Support, chains: &Chains, joint: usize) -> Option<bool> {
    let is_beyond = support.feet.iter().any(|foot| chains[foot.limb].contains(&joint));
    (!is_beyond || support.feet.len() == 1).then_some(is_beyond)
}

/// The rates within the limits of each joint by itself: speeds, accelerations, and the torques that
/// do not depend on how the contacts share the load.
pub(crate) fn joint_rates(
    dynamics: &PathDynamics,
    state: &PathState<'_>,
    (support, chains): (&Support, &Chains),
    (limits, level): (&TimingLimits, Level),
    joints_len: usize,
) -> RateSet {
    let mut rates = RateSet::within(RATE_MAX * RATE_MAX, RATE_CHANGE_MAX);
    let efforts = level.efforts(limits);
    for (joint, effort) in efforts.iter().enumerate().take(joints_len) {
        let (first, second) = (state.first[6 + joint], state.second[6 + joint]);
        let speed = LIMITS_PART * limits.speeds[joint];
        let index = joint as u8;
        rates.clip(DVec2::X, (speed / first.abs().max(1e-9)).powi(2), Limit::Speed(index));
        let acceleration = LIMITS_PART * limits.accelerations[joint];
        if acceleration.is_finite() {
            let by_rates = DVec2::new(second, first);
            rates.clip(by_rates, acceleration, Limit::Acceleration(index));
            rates.clip(-by_rates, acceleration, Limit::Acceleration(index));
        }
        let Some(torque) = dynamics.own_torque(support, chains, joint) else { continue };
        let limit = LIMITS_PART * effort;
        rates.clip(torque.slope, limit - torque.constant, Limit::Torque(index));
        rates.clip(-torque.slope, limit + torque.constant, Limit::Torque(index));
    }
    rates
}
