//! The constraints that every configuration of a plan satisfies, and every motion between two of
//! them [Grey 4.1]: the centre of mass over the support polygon, torque limits, and no collision.
//! Joint limits are satisfied where joints are set. Cheap tests come first.

use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::config::planner::{FOOT_DRIFT_MAX, FOOT_TURN_MAX};
use surefoot_shared_types::config::{CheckerConfig, PlannerConfig};
use surefoot_shared_types::message::SupportMode;

use crate::collision::model::{CollisionModel, FootPhase, Hit};
use crate::constraints::mode::{Mode, StartBalance};
use crate::constraints::rejection::Rejection;
use crate::constraints::tuning::{
    COM_MARGIN_RESERVE, CURVE_MARGIN_SHARE, CURVE_ROUNDING, INTERVALS_MIN, LOAD_SHARES,
    MARGIN_DEPTH_SHARE_MAX, MORE_LOAD_SHARES, START_MARGIN_LOSS_MAX,
};
use crate::constraints::waist::Waist;
use crate::robot::configuration::{Configuration, midway};
use crate::robot::gravity_torques::{FootLoad, balance_loads, effort_use};
use crate::robot::kinematic_state::KinematicState;
use crate::robot::mechanism::Mechanism;
use crate::robot::single_support::SingleSupportPosture;

/// The compiled constraints. Constant during a search and shared by all threads.
#[derive(Debug)]
pub struct Constraints {
    /// The robot.
    pub robot: Mechanism,
    /// The joint that bends the trunk forward, if there is one.
    pub waist: Option<Waist>,
    /// Default postures in single support, by stance limb.
    pub single_support_postures: [SingleSupportPosture; 2],
    /// The geometry of the robot and the world.
    pub collision: CollisionModel,
    /// The parameters.
    pub config: PlannerConfig,
    /// The margin of the centre of mass that the checker demands, m.
    pub checked_com_margin: f64,
    /// Shares of the weight on the right foot that are tried in double support, after the share
    /// that follows from the centre of mass.
    load_shares: &'static [f64],
}

impl Constraints {
    /// Compiles the constraints and derives the single-support postures and how far the waist
    /// bends. The checker's margin is the default one.
    pub fn new(robot: Mechanism, collision: CollisionModel, config: PlannerConfig) -> Self {
        let single_support_postures = [0, 1].map(|limb| SingleSupportPosture::derive(&robot, limb));
        let waist = Waist::new(&robot, &collision);
        let checked_com_margin = CheckerConfig::default().com_margin;
        let load_shares = &LOAD_SHARES;
        Self {
            robot,
            waist,
            single_support_postures,
            collision,
            config,
            checked_com_margin,
            load_shares,
        }
    }

    /// The farthest forward bend of the waist from the standing posture, rad; 0 without a waist.
    pub fn waist_bend_max(&self) -> f64 {
        self.waist.map_or(0.0, |waist| waist.bend_max)
    }

    /// Bends the waist, if there is one, forward by `angle` (rad), as far as its limits allow.
    pub fn bend_waist(&self, q: &mut [f64; JOINTS_MAX], angle: f64) {
        if let Some(waist) = self.waist {
            waist.bend(q, angle);
        }
    }

    /// Relaxes the margin of the centre of mass to `com_margin` (m), multiplies the usable efforts,
    /// and tries more shares of the weight in double support.
    pub(crate) fn relax(&mut self, com_margin: f64, effort_factor: f64) {
        self.config.com_margin = com_margin;
        self.robot.mass_tree.scale_efforts(effort_factor);
        self.load_shares = &MORE_LOAD_SHARES;
    }

    /// Margin of the centre of mass inside a mode's region, m: the configured one, less in small
    /// regions, and less for motions from a start that is nearer to the border.
    pub fn com_margin(&self, mode: &Mode) -> f64 {
        let checked = self.checked_com_margin + COM_MARGIN_RESERVE;
        let in_small_region = (MARGIN_DEPTH_SHARE_MAX * mode.depth).max(checked);
        let desired = self.config.com_margin.min(in_small_region);
        let Some(StartBalance { com, margin_min }) = mode.start else { return desired };
        let margin = mode.region.margin(com);
        let spare = margin - margin_min;
        if margin >= desired || spare <= 0.0 {
            desired
        } else {
            margin_min + (spare - START_MARGIN_LOSS_MAX).max(0.5 * spare)
        }
    }

    /// Whether the centre of mass keeps its margin inside the mode's region.
    pub fn is_balanced(&self, mode: &Mode, kinematic_state: &KinematicState) -> bool {
        mode.region.contains(kinematic_state.com.truncate(), self.com_margin(mode))
    }

    /// Checks one configuration in a mode.
    ///
    /// # Errors
    /// The first constraint that it violates.
    pub fn check(
        &self,
        mode: &Mode,
        kinematic_state: &KinematicState,
        feet: [FootPhase; 2],
    ) -> Result<(), Rejection> {
        if !self.is_balanced(mode, kinematic_state) {
            return Err(Rejection::Balance);
        }
        if !self.is_torque_feasible(mode, kinematic_state) {
            return Err(Rejection::Torque);
        }
        self.check_collision(kinematic_state, feet)
    }

    /// Checks the joint-linear motion between two configurations that satisfy the constraints.
    /// `bound` (m, [`CollisionModel::motion_bound`]) limits the displacement of every point on the
    /// way. Returns the number of configurations checked. `scratch` is overwritten.
    ///
    /// # Errors
    /// The first constraint that a configuration in between violates.
    pub fn check_between(
        &self,
        mode: &Mode,
        ends: [&Configuration; 2],
        bound: f64,
        feet: [FootPhase; 2],
        scratch: &mut KinematicState,
    ) -> Result<u64, Rejection> {
        let intervals = libm::ceil(bound / self.config.collision_step).max(INTERVALS_MIN);
        for interval in 1..intervals as usize {
            let between = midway(ends[0], ends[1], interval as f64 / intervals);
            scratch.update(&self.robot, &between);
            if !self.is_balanced(mode, scratch) {
                return Err(Rejection::Balance);
            }
            if !self.are_soles_in_place(mode, scratch) {
                return Err(Rejection::FootDrift);
            }
            self.check_collision(scratch, feet)?;
        }
        Ok(intervals as u64 - 1)
    }

    /// Checks a configuration on the curve between two that satisfy the constraints: it may use
    /// half of the joints' margin, and its stance soles may drift. `scratch` is overwritten.
    ///
    /// # Errors
    /// The first constraint that it violates.
    pub fn check_on_curve(
        &self,
        mode: &Mode,
        configuration: &Configuration,
        scratch: &mut KinematicState,
    ) -> Result<(), Rejection> {
        let beyond = CURVE_MARGIN_SHARE * self.config.joint_margin + CURVE_ROUNDING;
        if !self.robot.is_within_limits(&configuration.q, beyond) {
            return Err(Rejection::Unreachable);
        }
        scratch.update(&self.robot, configuration);
        self.are_soles_in_place(mode, scratch).then_some(()).ok_or(Rejection::FootDrift)
    }

    fn check_collision(
        &self,
        kinematic_state: &KinematicState,
        feet: [FootPhase; 2],
    ) -> Result<(), Rejection> {
        match self.collision.hit(kinematic_state, &feet) {
            None => Ok(()),
            Some(Hit::World { .. }) => Err(Rejection::Collision),
            Some(Hit::SelfPair { .. }) => Err(Rejection::SelfCollision),
        }
    }

    fn are_soles_in_place(&self, mode: &Mode, kinematic_state: &KinematicState) -> bool {
        (0..2).filter(|&limb| mode.is_stance(limb)).all(|limb| {
            let reached = kinematic_state.world_from_sole(&self.robot, limb);
            let required = &mode.world_from_soles[limb];
            // The vector part of a rotation's quaternion has the length of the sine of half its
            // angle, which is about half the angle.
            let half_angle = (reached.rotation.conjugate() * required.rotation).xyz().length();
            reached.translation.distance(required.translation) <= FOOT_DRIFT_MAX
                && 2.0 * half_angle <= FOOT_TURN_MAX
        })
    }

    fn is_torque_feasible(&self, mode: &Mode, kinematic_state: &KinematicState) -> bool {
        let com = kinematic_state.com.truncate();
        let is_feasible = |loads: &[FootLoad; 2]| {
            effort_use(&self.robot.mass_tree, kinematic_state, loads) <= 1.0
        };
        match mode.support {
            SupportMode::Left => is_feasible(&FootLoad::all_on(0, com)),
            SupportMode::Right => is_feasible(&FootLoad::all_on(1, com)),
            SupportMode::Double => {
                let [left, right] = [&mode.regions[0], &mode.regions[1]];
                let between = right.centroid() - left.centroid();
                let natural = ((com - left.centroid()).dot(between)
                    / between.length_squared().max(SQUARED_DISTANCE_MIN))
                .clamp(0.0, 1.0);
                let shares = std::iter::once(natural).chain(self.load_shares.iter().copied());
                shares
                    .filter_map(|share| balance_loads([left, right], com, share))
                    .any(|loads| is_feasible(&loads))
            }
        }
    }
}

/// Smallest squared distance between two regions' centroids that is divided by, m2.
const SQUARED_DISTANCE_MIN: f64 = 1e-9;
