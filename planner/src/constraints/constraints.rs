//! The conditions that every configuration of a plan meets, and every motion between two of them
//! [Grey 4.1]: the centre of mass over the support polygon, joint limits, torque limits, and no
//! collision. Joint limits are kept where joints are set; the rest is checked here, cheapest first.

use glam::DVec2;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::interpolate;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::config::planner::{FOOT_DRIFT_MAX, FOOT_TURN_MAX};
use surefoot_shared_types::message::SupportMode;

use crate::collision::model::{CollisionModel, FootPhase};
use crate::geometry::convex_region::ConvexRegion;
use crate::robot::gravity_torques::{FootLoad, balance_loads};
use crate::robot::kinematic_state::KinematicState;
use crate::robot::mechanism::{Configuration, Mechanism};

/// Why a configuration or motion was rejected. Each is counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Rejection {
    /// A leg does not reach its sole within its joint limits.
    Unreachable,
    /// The centre of mass leaves the support polygon.
    Balance,
    /// A joint would need more than its share of effort.
    Torque,
    /// The robot collides with the world.
    Collision,
    /// The robot collides with itself.
    SelfCollision,
    /// A stance foot would drift between two waypoints.
    FootDrift,
    /// The motion needs more steps than allowed, or a joint would jump.
    Discontinuous,
}

impl Rejection {
    /// How many kinds there are.
    pub const COUNT: usize = 7;
    /// Their names in reports, by discriminant.
    pub const NAMES: [&'static str; Self::COUNT] = [
        "unreachable",
        "balance",
        "torque",
        "collision",
        "self_collision",
        "foot_drift",
        "discontinuous",
    ];
}

/// What one mode fixes: which feet stand where, and where the centre of mass may be.
#[derive(Debug, Clone)]
pub struct Mode {
    /// Which feet carry the robot.
    pub support: SupportMode,
    /// Where the stance soles stand in the world; a swing foot's entry is not used.
    pub world_from_soles: [Pose; 2],
    /// Each stance foot's support polygon in world x and y.
    pub regions: [ConvexRegion; 2],
    /// Where the centre of mass may be.
    pub region: ConvexRegion,
    /// How deep inside the region its centroid lies, m.
    pub depth: f64,
    /// For a motion that begins where the robot was found standing.
    pub start: Option<StartBalance>,
}

/// How a robot is balanced that was found standing, maybe nearer to its support's edge than a plan
/// would bring it.
#[derive(Debug, Clone, Copy)]
pub struct StartBalance {
    /// Its centre of mass, world x and y, m.
    pub com: DVec2,
    /// The least margin that a checker accepts, m.
    pub margin_min: f64,
}

/// The share of a small region's depth that the margin of the centre of mass takes up at most.
const MARGIN_SHARE_MAX: f64 = 0.6;
/// How much nearer to the edge than at its beginning a motion from a bad start may come, m; at most
/// half of what there is.
const START_MARGIN_LOSS_MAX: f64 = 4e-3;

impl Mode {
    /// Whether a foot stands still in this mode.
    pub fn is_stance(&self, limb: usize) -> bool {
        self.support.carries(limb)
    }

    /// The foot that swings, if one does.
    pub fn swing(&self) -> Option<usize> {
        [0, 1].into_iter().find(|&limb| !self.is_stance(limb))
    }
}

/// Shares of the weight on the right foot that are tried for double support, after the one that
/// follows the centre of mass.
const LOAD_SHARES: [f64; 5] = [0.5, 0.25, 0.75, 0.1, 0.9];

/// The compiled constraints: constant during a search, shared by all threads.
#[derive(Debug)]
pub struct Constraints {
    /// The robot.
    pub robot: Mechanism,
    /// The robot's and the world's geometry.
    pub collision: CollisionModel,
    /// The parameters.
    pub config: PlannerConfig,
}

impl Constraints {
    /// How far the centre of mass stays inside a mode's support polygon, m: as configured, or less
    /// where the polygon is so small that hardly anything would be left of it, or what a start
    /// allows that is nearer to the edge.
    pub fn com_margin(&self, mode: &Mode) -> f64 {
        let wanted = self.config.com_margin.min(MARGIN_SHARE_MAX * mode.depth);
        let Some(StartBalance { com, margin_min }) = mode.start else { return wanted };
        let margin = mode.region.margin(com);
        let spare = margin - margin_min;
        if margin >= wanted || spare <= 0.0 {
            wanted
        } else {
            margin_min + (spare - START_MARGIN_LOSS_MAX).max(0.5 * spare)
        }
    }

    /// Whether the centre of mass is as far inside a mode's support region as it shall be.
    pub fn is_balanced(&self, mode: &Mode, kinematic_state: &KinematicState) -> bool {
        mode.region.contains(kinematic_state.com.truncate(), self.com_margin(mode))
    }

    /// Checks one configuration in a mode.
    ///
    /// # Errors
    /// The first condition that it violates.
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

    /// Checks the joint-linear motion between two configurations, both of which are checked
    /// themselves, on whose way no point moves further than `bound` (m,
    /// [`CollisionModel::motion_bound`]); answers how many configurations it checked. `scratch` is
    /// written over.
    ///
    /// # Errors
    /// The first condition that it violates.
    pub fn check_between(
        &self,
        mode: &Mode,
        ends: [&Configuration; 2],
        bound: f64,
        feet: [FootPhase; 2],
        scratch: &mut KinematicState,
    ) -> Result<u64, Rejection> {
        let intervals = libm::ceil(bound / self.config.collision_step).max(2.0);
        for interval in 1..intervals as usize {
            let between = midway(ends[0], ends[1], interval as f64 / intervals);
            self.robot.update_kinematic_state(&between, scratch);
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

    fn check_collision(
        &self,
        kinematic_state: &KinematicState,
        feet: [FootPhase; 2],
    ) -> Result<(), Rejection> {
        match self.collision.hit(kinematic_state, &feet) {
            None => Ok(()),
            Some(crate::collision::model::Hit::World { .. }) => Err(Rejection::Collision),
            Some(crate::collision::model::Hit::SelfPair { .. }) => Err(Rejection::SelfCollision),
        }
    }

    fn are_soles_in_place(&self, mode: &Mode, kinematic_state: &KinematicState) -> bool {
        (0..2).filter(|&limb| mode.is_stance(limb)).all(|limb| {
            let (is, wanted) =
                (self.robot.world_from_sole(kinematic_state, limb), &mode.world_from_soles[limb]);
            // The vector part of a turn's quaternion is as long as the sine of half its angle.
            let half_turn = (is.rotation.conjugate() * wanted.rotation).xyz().length();
            is.translation.distance(wanted.translation) <= FOOT_DRIFT_MAX
                && 2.0 * half_turn <= FOOT_TURN_MAX
        })
    }

    fn is_torque_feasible(&self, mode: &Mode, kinematic_state: &KinematicState) -> bool {
        let com = kinematic_state.com.truncate();
        let is_feasible =
            |loads: &[FootLoad; 2]| self.robot.statics.effort_use(kinematic_state, loads) <= 1.0;
        match mode.support {
            SupportMode::Left => is_feasible(&FootLoad::all_on(0, com)),
            SupportMode::Right => is_feasible(&FootLoad::all_on(1, com)),
            SupportMode::Double => {
                let [left, right] = [&mode.regions[0], &mode.regions[1]];
                let between = right.centroid() - left.centroid();
                let natural = ((com - left.centroid()).dot(between)
                    / between.length_squared().max(1e-9))
                .clamp(0.0, 1.0);
                let shares = std::iter::once(natural).chain(LOAD_SHARES);
                shares
                    .filter_map(|share| balance_loads([left, right], com, share))
                    .any(|loads| is_feasible(&loads))
            }
        }
    }
}

/// The configuration a fraction `t` of the way between two, as the robot moves between waypoints:
/// joints and root position linearly, root rotation along the shortest arc.
pub fn midway(a: &Configuration, b: &Configuration, t: f64) -> Configuration {
    let world_from_root = interpolate(&a.world_from_root, &b.world_from_root, t);
    let q = std::array::from_fn(|i| a.q[i] + t * (b.q[i] - a.q[i]));
    Configuration { world_from_root, q }
}
