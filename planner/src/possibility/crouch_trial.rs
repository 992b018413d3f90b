//! Whether the robot can stand in a crouch, on both feet and on each.

use glam::{DQuat, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::rotation_from_rpy;

use crate::base::threads::Threads;
use crate::constraints::constraints::Constraints;
use crate::geometry::convex_region::ConvexRegion;
use crate::possibility::upper_body::UpperBody;
use crate::robot::configuration::Configuration;
use crate::robot::constrained_projection::{ProjectionTarget, project};
use crate::robot::crouch::Crouch;
use crate::robot::gravity_torques::{FootLoad, effort_use};
use crate::robot::kinematic_state::KinematicState;
use crate::robot::posture_ik::{Posture, initial_guess, solve_posture};
use crate::robot::single_support::SingleSupportPosture;

/// Read-only inputs of trials of crouches.
#[derive(Debug, Clone, Copy)]
pub struct CrouchContext<'a> {
    /// The robot and the world.
    pub constraints: &'a Constraints,
    /// The upper body.
    pub upper_body: &'a UpperBody,
    /// The threads.
    pub threads: &'a Threads,
}

/// The robot in a crouch on level ground, in the mid-feet frame.
pub(crate) struct CrouchTrial<'a> {
    constraints: &'a Constraints,
    mid_feet_from_upright: DQuat,
    mid_feet_from_soles: [Pose; 2],
    crouch: Crouch,
}

impl<'a> CrouchTrial<'a> {
    /// A robot in a crouch.
    pub fn new(constraints: &'a Constraints, upper_body: &UpperBody, crouch: Crouch) -> Self {
        let robot = &constraints.robot;
        let upright = upper_body.mid_feet_from_root();
        let mid_feet_from_soles =
            [0, 1].map(|limb| upright * robot.legs[limb].root_from_sole(&robot.standing_q));
        Self { constraints, mid_feet_from_upright: upright.rotation, mid_feet_from_soles, crouch }
    }

    /// The root in double support; `None` if the crouch is infeasible.
    pub fn mid_feet_from_root(&self) -> Option<Pose> {
        let [left, right] = [0, 1].map(|limb| self.ankle_support_region(limb));
        let region = ConvexRegion::hull(left.vertices().iter().chain(right.vertices()).copied());
        let standing = SingleSupportPosture::standing(self.constraints.robot.standing_q);
        let (configuration, _) = self.solve(&self.mid_feet_from_soles, &standing, &region)?;
        Some(configuration.world_from_root)
    }

    /// The ankle support region of a foot, in the mid-feet frame.
    fn ankle_support_region(&self, limb: usize) -> ConvexRegion {
        self.constraints.robot.soles[limb].ankle_support_region(&self.mid_feet_from_soles[limb])
    }

    /// Number of infeasible single-support stances, the other foot ahead by one of `strides`, m.
    pub fn failures(&self, strides: &[f64]) -> u32 {
        let stances = [0, 1].into_iter().flat_map(|limb| strides.iter().map(move |&x| (limb, x)));
        let is_infeasible =
            |&(limb, stride): &(usize, f64)| !self.is_feasible_on(limb, stride * DVec3::X);
        stances.filter(is_infeasible).count() as u32
    }

    /// Whether the crouch is feasible on each foot, the other one beside it: as far away as in the
    /// standing posture, or `width` (m) if that is narrower. With wide hips and bent or leaning
    /// legs the robot stands on one foot where it keeps the other one near.
    pub fn may_step(&self, width: f64) -> bool {
        let [left, right] = self.mid_feet_from_soles.map(|sole| sole.translation.y);
        let narrower = (left - right - width).max(0.0);
        [narrower, -narrower].into_iter().enumerate().all(|(limb, inward)| {
            self.is_feasible_on(limb, DVec3::ZERO)
                || narrower > 0.0 && self.is_feasible_on(limb, inward * DVec3::Y)
        })
    }

    /// Whether the crouch is feasible on foot `limb`, the other foot moved by `offset` (m).
    fn is_feasible_on(&self, limb: usize, offset: DVec3) -> bool {
        let mut soles = self.mid_feet_from_soles;
        soles[1 - limb].translation += offset;
        let region = self.ankle_support_region(limb);
        let solved = self.solve(&soles, &self.constraints.single_support_postures[limb], &region);
        solved.is_some_and(|(_, kinematic_state)| {
            let load = FootLoad::all_on(limb, kinematic_state.com.truncate());
            effort_use(&self.constraints.robot.mass_tree, &kinematic_state, &load) <= 1.0
        })
    }

    /// The configuration on given soles with its centre of mass over the middle of a region or,
    /// where the root leans far, anywhere over it; `None` if none exists or links collide with each
    /// other.
    fn solve(
        &self,
        soles: &[Pose; 2],
        single_support: &SingleSupportPosture,
        region: &ConvexRegion,
    ) -> Option<(Configuration, KinematicState)> {
        let robot = &self.constraints.robot;
        let [roll, pitch] = single_support.rotation;
        let world_from_root = self.mid_feet_from_upright
            * rotation_from_rpy(roll + self.crouch.roll, pitch + self.crouch.pitch, 0.0);
        let leg_extension = self.crouch.leg_extension * robot.standing_leg_extension;
        let mut free = single_support.q;
        self.constraints.bend_waist(&mut free, self.crouch.waist);
        let posture = Posture { world_from_root, leg_extension, com: region.centroid() };
        let is_free = |solved: &(Configuration, KinematicState)| {
            self.constraints.collision.self_hit(&solved.1).is_none()
        };
        let projected = || {
            let begin = initial_guess(robot, soles, &posture, free);
            let target = ProjectionTarget { world_from_soles: soles, region, com_margin: 0.0 };
            let mut kinematic_state = KinematicState::default();
            let configuration = project(robot, &target, &begin, &mut kinematic_state)?;
            Some((configuration, kinematic_state))
        };
        solve_posture(robot, soles, &posture, free).ok().filter(is_free).or_else(|| {
            let is_due = robot.is_projected_at(world_from_root);
            is_due.then(projected).flatten().filter(is_free)
        })
    }
}
