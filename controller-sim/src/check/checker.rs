//! The physical checks: whether a motion in one mode on given contacts may be executed.
//!
//! [`Checker::check_segment`] runs them in the order of [`PHYSICAL`] and stops at the first
//! violation; [`Checker::check_all`] runs them all. Each check lives in the file of its name.

use crate::check::acceleration;
use crate::check::balance;
use crate::check::collision;
use crate::check::contact;
use crate::check::limits;
use crate::statics::contact_load;
use crate::statics::joint_torques;
use crate::statics::sole_support;
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::Margins;
use surefoot_shared_types::message::{Check, Contact, SupportMode, Waypoint};
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::World;

use crate::check::acceleration::check_acceleration;
use crate::check::allowed_pairs::allowed_pairs;
use crate::check::motion::SampledMotion;
use crate::geometry::body::CollisionBody;
use crate::kinematics::forward::{Configuration, Posture};
use crate::statics::contact_load::ContactLoad;
use crate::statics::equilibrium::Equilibrium;
use crate::statics::sole_support::{SoleSupport, SupportFinder};

/// The physical checks, in the order in which they are made.
pub const PHYSICAL: [Check; 8] = [
    Check::Spacing,
    Check::Acceleration,
    Check::Limits,
    Check::Contact,
    Check::Balance,
    Check::Torque,
    Check::Collision,
    Check::SelfCollision,
];
/// Those of them that need a [`Case`].
const OF_CASES: [Check; 6] = [
    Check::Limits,
    Check::Contact,
    Check::Balance,
    Check::Torque,
    Check::Collision,
    Check::SelfCollision,
];

/// A robot or world that cannot be checked.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CheckerError {
    /// The robot does not fit the messages.
    #[error(
        "the robot has {joints} moving joints; at most {max} fit a message: lock some in the robot file"
    )]
    TooManyJoints {
        /// Its moving joints.
        joints: usize,
        /// What fits.
        max: usize,
    },
    /// Not a biped.
    #[error(
        "the robot has {feet} feet; the checker supports bipeds only: name a left and a right foot in the robot file"
    )]
    NotABiped {
        /// Its feet.
        feet: usize,
    },
    /// A shape that the geometry code cannot represent.
    #[error("unusable shape: {0}")]
    Shape(String),
    /// A declared sole that the foot's own shapes do not carry.
    #[error(
        "the sole of foot '{foot}' has a vertex {millimetres} mm off the foot's collision shapes: correct the sole in the robot file"
    )]
    SoleOffFoot {
        /// The foot.
        foot: String,
        /// How far, rounded.
        millimetres: u64,
    },
}

/// A motion within one mode.
#[derive(Debug, Clone, Copy)]
pub struct MotionSegment<'a> {
    /// Which feet carry the robot.
    pub mode: SupportMode,
    /// Where they stand, one per foot of the mode.
    pub contacts: &'a [Contact],
    /// The motion; at least one waypoint.
    pub waypoints: &'a [Waypoint],
}

/// A violated check.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{} at waypoint {waypoint}: {detail}", check.name())]
pub struct Violation {
    /// Which check it violates.
    pub check: Check,
    /// The waypoint of the segment at or after which it happens.
    pub waypoint: usize,
    /// One line: what, how much, the limit, and which link, foot, shape or joint.
    pub detail: String,
}

impl Violation {
    /// A violation of `check` at `waypoint`.
    pub fn new(check: Check, waypoint: usize, detail: impl Into<String>) -> Self {
        Self { check, waypoint, detail: detail.into() }
    }
}

/// Results of all checks of a segment.
#[derive(Debug, Clone, PartialEq)]
pub struct SegmentReport {
    /// The worst margins of the checks that passed.
    pub margins: Margins,
    /// The share of the joints' acceleration limits that stays unused; infinite where one is
    /// exceeded.
    pub acceleration: f64,
    /// The first violation of each check that did not.
    pub violations: Vec<Violation>,
    /// Margin beyond what the checks require.
    pub reserves: Reserves,
}

impl SegmentReport {
    /// Nothing measured yet.
    const UNMEASURED: Self = Self {
        margins: Margins::UNMEASURED,
        acceleration: f64::INFINITY,
        violations: Vec::new(),
        reserves: Reserves::UNMEASURED,
    };
}

/// Margin beyond what the checks require. Reported, not enforced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reserves {
    /// The share of the friction that is not needed, in sixteenths, rounded down.
    pub friction: f64,
    /// The share of the effort limits that stays unused by contact forces of least squares.
    pub least_squares_torque: f64,
}

impl Reserves {
    /// Nothing measured yet.
    pub const UNMEASURED: Self =
        Self { friction: f64::INFINITY, least_squares_torque: f64::INFINITY };

    /// The smaller of each pair.
    pub fn min(&self, other: &Self) -> Self {
        Self {
            friction: self.friction.min(other.friction),
            least_squares_torque: self.least_squares_torque.min(other.least_squares_torque),
        }
    }
}

/// The support of each stance foot by the world.
#[derive(Debug, Clone, PartialEq)]
pub struct SoleSupports(Vec<SoleSupport>);

/// Checks motions of one robot in one world.
pub struct Checker {
    model: RobotModel,
    /// The robot with its locked joints as joints: their motors must hold them, and they keep links
    /// apart.
    unlocked: RobotModel,
    world: World,
    config: CheckerConfig,
    supports: SupportFinder,
    equilibrium: Equilibrium,
    collisions: collision::CollisionModel,
}

impl Checker {
    /// Prepares all that does not depend on the motion, among it which links may touch each other.
    ///
    /// # Errors
    /// The robot is not a biped or has more joints than a message holds, a shape of the robot or
    /// the world has no form that the checker can compute with, or a foot's shapes do not carry its
    /// sole.
    pub fn new(
        model: RobotModel,
        world: World,
        config: CheckerConfig,
    ) -> Result<Self, CheckerError> {
        if model.joints.len() > JOINTS_MAX {
            return Err(CheckerError::TooManyJoints {
                joints: model.joints.len(),
                max: JOINTS_MAX,
            });
        }
        if model.feet.len() != 2 {
            return Err(CheckerError::NotABiped { feet: model.feet.len() });
        }
        let robot_bodies = CollisionBody::of_robot(&model).map_err(CheckerError::Shape)?;
        let world_bodies = CollisionBody::of_world(&world).map_err(CheckerError::Shape)?;
        sole_support::check_soles(&model, &robot_bodies, config.contact_gap_max)?;
        let supports = SupportFinder::new(&model, &world, &config).map_err(CheckerError::Shape)?;
        let unlocked = model.unlocked();
        let allowed = allowed_pairs(&unlocked, &robot_bodies);
        let collisions =
            collision::CollisionModel::new(&model, &allowed, robot_bodies, world_bodies);
        let equilibrium = Equilibrium::new(world.mu);
        Ok(Self { model, unlocked, world, config, supports, equilibrium, collisions })
    }

    /// The robot.
    pub fn model(&self) -> &RobotModel {
        &self.model
    }

    /// The world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The worst margins of a segment, or the first violation in the order of [`PHYSICAL`].
    /// `heartbeat` is called now and then meanwhile.
    ///
    /// # Errors
    /// The first violation.
    pub fn check_segment(
        &mut self,
        segment: &MotionSegment,
        heartbeat: &mut dyn FnMut(),
    ) -> Result<Margins, Violation> {
        let mut margins = Margins::UNMEASURED;
        let spacing = limits::check_spacing(&self.model, &self.config, segment)?;
        check_acceleration(&self.model, segment.waypoints)?;
        let case = self.prepare(segment, spacing);
        for check in &OF_CASES {
            heartbeat();
            record(&mut margins, *check, self.run(*check, &case, heartbeat)?);
        }
        Ok(margins)
    }

    /// All checks of a segment, each up to its first violation. Waypoints too far apart to
    /// interpolate end it early.
    pub fn check_all(&mut self, segment: &MotionSegment) -> SegmentReport {
        let mut report = SegmentReport::UNMEASURED;
        match limits::check_spacing(&self.model, &self.config, segment) {
            Err(violation) => report.violations.push(violation),
            Ok(spacing) => {
                match check_acceleration(&self.model, segment.waypoints) {
                    Ok(margin) => report.acceleration = margin,
                    Err(violation) => report.violations.push(violation),
                }
                let case = self.prepare(segment, spacing);
                for check in &OF_CASES {
                    match self.run(*check, &case, &mut || {}) {
                        Ok(margin) => record(&mut report.margins, *check, margin),
                        Err(violation) => report.violations.push(violation),
                    }
                }
                report.reserves = self.reserves(&case);
            }
        }
        report
    }

    /// How many times as long a motion must take, so that no joint accelerates more than it may; at
    /// least 1.
    pub fn time_scale_min(&self, waypoints: &[Waypoint]) -> f64 {
        acceleration::peak_acceleration(&self.model, waypoints).share.max(1.0).sqrt()
    }

    /// The support of each of these contacts by the world.
    pub fn sole_supports(&mut self, contacts: &[Contact]) -> SoleSupports {
        SoleSupports(contacts.iter().map(|contact| self.supports.find(contact)).collect())
    }

    /// Foot forces and joint torques in a configuration by contact forces of least squares.
    pub fn load(
        &mut self,
        sole_supports: &SoleSupports,
        configuration: &Configuration,
    ) -> ContactLoad {
        let posture = Posture::new(&self.model, configuration);
        contact_load::least_squares_load(
            &self.unlocked,
            &mut self.equilibrium,
            &sole_supports.0,
            &posture,
        )
    }

    fn reserves(&mut self, case: &Case) -> Reserves {
        Reserves {
            friction: balance::friction_reserve(&self.config, &mut self.equilibrium, case),
            least_squares_torque: joint_torques::least_squares_torque_reserve(
                &self.unlocked,
                &self.equilibrium,
                case,
            ),
        }
    }

    fn prepare(&mut self, segment: &MotionSegment, spacing: limits::Spacing) -> Case {
        let contacts = segment.contacts.to_vec();
        let supports = contacts.iter().map(|contact| self.supports.find(contact)).collect();
        Case {
            contacts,
            supports,
            motion: SampledMotion::new(&self.model, segment.waypoints, spacing),
        }
    }

    fn run(
        &mut self,
        check: Check,
        case: &Case,
        heartbeat: &mut dyn FnMut(),
    ) -> Result<f64, Violation> {
        match check {
            Check::Limits => limits::check_limits(&self.model, case),
            Check::Contact => contact::check_contact(&self.model, &self.config, case),
            Check::Balance => {
                balance::check_balance(&self.model, &self.config, &mut self.equilibrium, case)
            }
            Check::Torque => joint_torques::check_torque(
                &self.unlocked,
                &self.config,
                &mut self.equilibrium,
                case,
                heartbeat,
            ),
            Check::Collision => {
                self.collisions.check_world(&self.model, &self.config, case, heartbeat)
            }
            Check::SelfCollision => {
                self.collisions.check_self(&self.model, &self.config, case, heartbeat)
            }
            _ => Ok(f64::INFINITY),
        }
    }
}

/// A segment with what several checks need of it.
pub(crate) struct Case {
    pub(crate) contacts: Vec<Contact>,
    /// The support of each contact by the world.
    pub(crate) supports: Vec<SoleSupport>,
    pub(crate) motion: SampledMotion,
}

fn record(margins: &mut Margins, check: Check, margin: f64) {
    let field = match check {
        Check::Limits => &mut margins.limits,
        Check::Contact => &mut margins.contact,
        Check::Balance => &mut margins.balance,
        Check::Collision => &mut margins.collision,
        Check::SelfCollision => &mut margins.self_collision,
        Check::Torque => &mut margins.torque,
        _ => return,
    };
    *field = field.min(margin);
}
