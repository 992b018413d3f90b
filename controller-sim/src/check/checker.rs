//! The checker: whether a motion in one mode on given contacts may be executed.
//!
//! [`Checker::check_segment`] makes the checks in the order of
//! `check/checks.rs` and stops at the first violation; [`Checker::check_all`]
//! makes all of them. Each check stands in the file of its name.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::{Check, Contact, Margins, Waypoint};
use surefoot_shared_types::robot::model::{Link, RobotModel};
use surefoot_shared_types::world::world::World;

use crate::base::comparison::largest;
use crate::check::acceleration::{
    check_acceleration, check_stated_accelerations, peak_acceleration,
};
use crate::check::allowed_pairs::{describe, self_pairs, without_effect};
use crate::check::balance::{check_balance, friction_reserve};
use crate::check::checks::{PHYSICAL, PhysicalCheck};
use crate::check::collision::CollisionModel;
use crate::check::contact::{check_contact, check_landing};
use crate::check::course::Course;
use crate::check::dynamic_torque::check_dynamic_torque;
use crate::check::feed_forward::{Carriers, check_feed_forward, check_going_on};
use crate::check::limits::{check_limits, check_spacing, check_speeds};
use crate::check::motion::{SampledMotion, Spacing};
use crate::check::segment::{Case, MotionSegment, Reserves, SegmentReport, Violation};
use crate::check::sole_speed::check_sole_speeds;
use crate::check::stance_foot::StanceFoot;
use crate::check::torque::{check_torque, least_squares_torque_reserve};
use crate::check::zero_moment::check_zero_moment;
use crate::geometry::body::CollisionBody;
use crate::kinematics::forward::{Configuration, Posture};
use crate::kinematics::trajectory;
use crate::statics::contact_load::{ContactLoad, least_squares_load, moving_load};
use crate::statics::equilibrium::{ALL_FRICTION, Equilibrium};
use crate::statics::error::CheckerError;
use crate::statics::hollow_sole::HollowSole;
use crate::statics::inverse_dynamics::InverseDynamics;
use crate::statics::sole_support::{SoleSupport, SupportFinder};
use crate::statics::underside::check_soles;

/// The support of each stance foot by the world.
#[derive(Debug, Clone, PartialEq)]
pub struct SoleSupports(Vec<SoleSupport>);

impl SoleSupports {
    /// The corners of all supports in the world, m.
    pub fn corners(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.0.iter().flat_map(|support| &support.points).map(|point| point.position)
    }
}

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
    collisions: CollisionModel,
    /// The pairs of links that may overlap, one line each.
    allowed_overlaps: Vec<String>,
    /// The entries of the robot file that allow no overlap, one line each.
    idle_overlaps: Vec<String>,
    /// Whether accelerations of a smooth motion stay within the default limit where the robot file
    /// states none.
    keeps_default_accelerations: bool,
    /// Whether the robot may brake and go on within the motion: then its feed-forward torques are
    /// compared with the limits only.
    has_stops_in_motion: bool,
}

impl Checker {
    /// Prepares everything that does not depend on the motion, including the pairs of links that
    /// may touch each other.
    ///
    /// # Errors
    /// The robot is not a biped or has more joints than a message holds, a shape of the robot or
    /// of the world has no form that the checker can compute with, or a declared sole does not lie
    /// on its foot's shapes.
    pub fn new(
        model: RobotModel,
        world: World,
        config: CheckerConfig,
    ) -> Result<Self, CheckerError> {
        let joints = model.joints.len();
        if joints > JOINTS_MAX {
            return Err(CheckerError::TooManyJoints { joints, max: JOINTS_MAX });
        }
        if model.feet.len() != 2 {
            return Err(CheckerError::NotABiped { feet: model.feet.len() });
        }
        let robot_bodies = CollisionBody::of_robot(&model).map_err(CheckerError::Shape)?;
        let world_bodies = CollisionBody::of_world(&world).map_err(CheckerError::Shape)?;
        let supports = SupportFinder::new(&model, &world, &config).map_err(CheckerError::Shape)?;
        check_soles(&model, &robot_bodies, supports.undersides(), config.contact_gap_max)?;
        let unlocked = model.unlocked();
        let pairs = self_pairs(&model, &robot_bodies);
        let allowed_overlaps = describe(&pairs, &robot_bodies);
        let idle_overlaps = without_effect(&unlocked, &pairs, &robot_bodies);
        let collisions = CollisionModel::new(&model, &pairs, robot_bodies, world_bodies);
        let equilibrium = Equilibrium::new(world.mu);
        Ok(Self {
            model,
            unlocked,
            world,
            config,
            supports,
            equilibrium,
            collisions,
            allowed_overlaps,
            idle_overlaps,
            keeps_default_accelerations: false,
            has_stops_in_motion: false,
        })
    }

    /// The same checker, for smooth motions of which nothing shows that the robot can stop in them:
    /// where the robot file states no acceleration limit, that of straight lines holds.
    pub fn keeping_default_accelerations(self) -> Self {
        Self { keeps_default_accelerations: true, ..self }
    }

    /// The same checker, for motions as a robot executed them, with their stops.
    pub fn with_stops_in_motion(self) -> Self {
        Self { has_stops_in_motion: true, ..self }
    }

    /// Lets no links overlap that are clear in the starting posture, whatever the robot file says
    /// of the standing one.
    pub fn excuse_none_clear_in(&mut self, start: &Waypoint) {
        let configuration = Configuration::of_waypoint(start, self.model.joints.len());
        self.collisions.excuse_none_clear_in(&Posture::new(&self.model, &configuration));
    }

    /// The robot.
    pub fn model(&self) -> &RobotModel {
        &self.model
    }

    /// The world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The pairs of links that may overlap, one line each, with the reason.
    pub fn allowed_overlaps(&self) -> &[String] {
        &self.allowed_overlaps
    }

    /// The entries of the robot file under `[[allowed_overlaps]]` that allow nothing, one line each
    /// with the reason.
    pub fn idle_overlaps(&self) -> &[String] {
        &self.idle_overlaps
    }

    /// The links with mass that have no collision shape, each with its mass. No collision check
    /// covers them.
    pub fn unshaped_links(&self) -> impl Iterator<Item = String> {
        let unshaped = |link: &&Link| link.mass > 0.0 && link.shapes.is_empty();
        let named = |link: &Link| format!("{} ({:.2} kg)", link.name, link.mass);
        self.model.links.iter().filter(unshaped).map(named)
    }

    /// The soles that do not lie on their feet everywhere.
    pub fn hollow_soles(&self) -> impl Iterator<Item = HollowSole> {
        let feet = self.model.feet.iter().zip(self.supports.undersides());
        let hollow = feet.filter(|(_, underside)| underside.share_on_foot < 1.0);
        hollow.map(|(foot, underside)| HollowSole {
            foot: foot.name.clone(),
            percent_on_foot: 100.0 * underside.share_on_foot,
            percent_carrying: 100.0 * underside.share_carrying(),
        })
    }

    /// The worst margins of a segment. `heartbeat` is called now and then meanwhile.
    ///
    /// # Errors
    /// The first violation in the order of `check/checks.rs`.
    pub fn check_segment(
        &mut self,
        segment: &MotionSegment,
        heartbeat: &mut dyn FnMut(),
    ) -> Result<Margins, Violation> {
        let case = self.prepare(segment)?;
        let mut report = SegmentReport::UNMEASURED;
        for check in PHYSICAL {
            heartbeat();
            record(&mut report, check, self.run(check, &case, heartbeat)?);
        }
        Ok(report.margins)
    }

    /// The pose in which the sole of a swing foot began to touch the world, if it still does at the
    /// last waypoint; `before` is what this was at the first one.
    ///
    /// # Errors
    /// The foot has slid since then.
    pub(crate) fn check_touch(
        &self,
        limb: usize,
        waypoints: &[Waypoint],
        before: Option<Pose>,
    ) -> Result<Option<Pose>, Violation> {
        self.collisions.check_touch((&self.model, limb), waypoints, before)
    }

    /// The checks of a smooth motion's stops alone, on the part of them that lies within a segment.
    ///
    /// # Errors
    /// The first violation.
    pub fn check_stops(
        &mut self,
        segment: &MotionSegment,
        heartbeat: &mut dyn FnMut(),
    ) -> Result<Margins, Violation> {
        let MotionSegment { contacts, waypoints, course, .. } = *segment;
        self.check_instants(contacts, course.stop_instants(waypoints), heartbeat)
    }

    /// Whether a foot lands in time at the first waypoint of a smooth motion on both feet.
    ///
    /// # Errors
    /// One foot is deeper in the ground than the other.
    pub fn check_landing(
        &mut self,
        contacts: &[Contact],
        landing: &Waypoint,
    ) -> Result<(), Violation> {
        let spacing = Spacing { changes: Vec::new() };
        let motion = SampledMotion::new(&self.model, &[*landing], spacing);
        let (supports, feet) = self.find_feet(contacts, &motion);
        check_landing(&supports, &feet)
    }

    /// Whether contact forces explain the feed-forward torques of a smooth motion where the robot
    /// goes on from one motion to the next on the same foot.
    ///
    /// # Errors
    /// None do.
    pub fn check_going_on(
        &mut self,
        contacts: &[Contact],
        waypoint: &Waypoint,
    ) -> Result<(), Violation> {
        if self.has_stops_in_motion || contacts.len() != 1 {
            return Ok(());
        }
        let SoleSupports(supports) = self.sole_supports(contacts, &[*waypoint]);
        let generators = self.equilibrium.generators(&supports, ALL_FRICTION);
        let stance = contacts.iter().map(|contact| contact.limb as usize);
        check_going_on(&self.model, &stance.collect::<Vec<_>>(), &generators, waypoint)
    }

    /// The checks of a smooth motion at one instant.
    ///
    /// # Errors
    /// The first violation.
    pub fn check_instant(
        &mut self,
        contacts: &[Contact],
        instant: &Waypoint,
    ) -> Result<Margins, Violation> {
        self.check_instants(contacts, vec![(0, *instant)], &mut || {})
    }

    fn check_instants(
        &mut self,
        contacts: &[Contact],
        instants: Vec<(usize, Waypoint)>,
        heartbeat: &mut dyn FnMut(),
    ) -> Result<Margins, Violation> {
        let mut report = SegmentReport::UNMEASURED;
        if instants.is_empty() {
            return Ok(report.margins);
        }
        let stops: Vec<Waypoint> = instants.iter().map(|(_, instant)| *instant).collect();
        let SoleSupports(supports) = self.sole_supports(contacts, &stops);
        let (received, motion, stance_feet) = (Vec::new(), SampledMotion::EMPTY, Vec::new());
        let waypoints = Vec::new().into();
        let case = Case { contacts, supports, waypoints, received, instants, motion, stance_feet };
        for check in PhysicalCheck::OF_INSTANTS {
            heartbeat();
            record(&mut report, check, self.run(check, &case, heartbeat)?);
        }
        Ok(report.margins)
    }

    /// All checks of a segment, each up to its first violation. Waypoints too far apart to
    /// interpolate end it early.
    pub fn check_all(&mut self, segment: &MotionSegment) -> SegmentReport {
        let mut report = SegmentReport::UNMEASURED;
        let case = match self.prepare(segment) {
            Ok(case) => case,
            Err(violation) => {
                report.violations.push(violation);
                return report;
            }
        };
        for check in PHYSICAL {
            match self.run(check, &case, &mut || {}) {
                Ok(margin) => record(&mut report, check, margin),
                Err(violation) => report.violations.push(violation),
            }
        }
        report.reserves = self.reserves(&case);
        report
    }

    /// The factor by which the times of a motion must be stretched so that no joint exceeds its
    /// acceleration limit; at least 1.
    pub fn time_scale_min(&self, waypoints: &[Waypoint]) -> f64 {
        peak_acceleration(&self.model, waypoints).share.max(1.0).sqrt()
    }

    /// The support of each of these contacts by the world, under a robot that moves through these
    /// waypoints.
    pub fn sole_supports(&mut self, contacts: &[Contact], waypoints: &[Waypoint]) -> SoleSupports {
        let centre_of_mass = |waypoint: &Waypoint| {
            let configuration = Configuration::of_waypoint(waypoint, self.model.joints.len());
            Posture::new(&self.model, &configuration).centre_of_mass(&self.model)
        };
        let centres: Vec<DVec3> = waypoints.iter().map(centre_of_mass).collect();
        SoleSupports(self.find_supports(contacts, &centres))
    }

    fn find_supports(&mut self, contacts: &[Contact], centres: &[DVec3]) -> Vec<SoleSupport> {
        let find = |contact: &Contact| {
            let pose = contact.world_from_sole();
            let up = pose.rotation.normalize() * DVec3::Z;
            let height = largest(centres.iter().map(|at| (*at - pose.translation).dot(up)));
            self.supports.find(contact, height)
        };
        contacts.iter().map(find).collect()
    }

    /// Foot forces and joint torques in a configuration by contact forces of least squares.
    pub fn load(
        &mut self,
        sole_supports: &SoleSupports,
        configuration: &Configuration,
    ) -> ContactLoad {
        let posture = Posture::new(&self.model, configuration);
        least_squares_load(&self.unlocked, &mut self.equilibrium, &sole_supports.0, &posture)
    }

    /// As [`Self::load`], of a robot that moves as a waypoint says.
    pub fn moving_load(
        &mut self,
        sole_supports: &SoleSupports,
        waypoint: &Waypoint,
    ) -> ContactLoad {
        let (model, joints) = (&self.unlocked, self.model.joints.len());
        let posture = Posture::new(model, &Configuration::of_unlocked(model, waypoint, joints));
        let dynamics = InverseDynamics::new(model, &posture, waypoint);
        moving_load((model, &posture), &mut self.equilibrium, &sole_supports.0, &dynamics)
    }

    fn reserves(&mut self, case: &Case) -> Reserves {
        let least_squares_torque =
            least_squares_torque_reserve(&self.unlocked, &self.equilibrium, case);
        let friction = friction_reserve(&self.config, &mut self.equilibrium, case);
        Reserves { friction, least_squares_torque }
    }

    /// The data of a segment whose steps are short.
    fn prepare<'a>(&mut self, segment: &MotionSegment<'a>) -> Result<Case<'a>, Violation> {
        let MotionSegment { contacts, waypoints, course, .. } = *segment;
        let spacing = check_spacing(&self.model, &self.config, waypoints)?;
        if course == Course::Straight {
            let motion = SampledMotion::new(&self.model, waypoints, spacing);
            let (supports, stance_feet) = self.find_feet(contacts, &motion);
            let (received, instants) = (Vec::new(), Vec::new());
            let waypoints = waypoints.into();
            let case =
                Case { contacts, supports, waypoints, received, instants, motion, stance_feet };
            return Ok(case);
        }
        if let Some((index, time)) = course.abrupt_stop(waypoints) {
            let detail =
                format!("in motion the robot brakes or goes on within no time at {time} s");
            return Err(Violation::new(Check::Acceleration, index, detail));
        }
        let (received, knots): (Vec<usize>, Vec<Waypoint>) = trajectory::knots(waypoints)
            .map_err(|index| {
                let detail = "the curve to the next waypoint bends too much for its duration";
                Violation::new(Check::Spacing, index, detail)
            })?
            .into_iter()
            .unzip();
        let spacing = check_spacing(&self.model, &self.config, &knots).map_err(|violation| {
            Violation { waypoint: received[violation.waypoint], ..violation }
        })?;
        let motion = SampledMotion::new(&self.model, &knots, spacing);
        let (supports, stance_feet) = self.find_feet(contacts, &motion);
        let mut instants: Vec<(usize, Waypoint)> =
            received.iter().copied().zip(knots.iter().copied()).collect();
        instants.extend(course.stop_instants(waypoints));
        let waypoints = knots.into();
        Ok(Case { contacts, supports, waypoints, received, instants, motion, stance_feet })
    }

    /// The support of each contact, and its foot in each sample of the motion.
    fn find_feet(
        &mut self,
        contacts: &[Contact],
        motion: &SampledMotion,
    ) -> (Vec<SoleSupport>, Vec<StanceFoot>) {
        let centres: Vec<DVec3> =
            motion.samples.iter().map(|sample| sample.centre_of_mass).collect();
        let supports = self.find_supports(contacts, &centres);
        let feet_in = |sample| contacts.iter().map(move |contact| (contact, sample));
        let foot = |(contact, sample)| StanceFoot::new(&self.model, contact, sample);
        let stance_feet = motion.samples.iter().flat_map(feet_in).map(foot).collect();
        (supports, stance_feet)
    }

    /// Makes one check; infinity where it measures no margin.
    fn run(
        &mut self,
        check: PhysicalCheck,
        case: &Case,
        heartbeat: &mut dyn FnMut(),
    ) -> Result<f64, Violation> {
        let (model, config) = (&self.model, &self.config);
        let joints = model.joints.len();
        let result = match check {
            // A case exists only for waypoints whose spacing holds.
            PhysicalCheck::Spacing => return check_speeds(model, &case.instants),
            PhysicalCheck::Acceleration if case.is_smooth() => {
                let keeps_default = self.keeps_default_accelerations;
                return check_stated_accelerations(model, &case.instants, keeps_default);
            }
            PhysicalCheck::ZeroMoment => {
                return check_zero_moment(model, config, &mut self.equilibrium, case);
            }
            PhysicalCheck::DynamicTorque => {
                let generators = self.equilibrium.generators(&case.supports, ALL_FRICTION);
                let touches = |at: &Waypoint| self.collisions.touches_world(model, case, at);
                let carriers = Carriers { generators: &generators, touches: &touches };
                check_feed_forward(model, &carriers, case, self.has_stops_in_motion)?;
                return check_dynamic_torque(
                    &self.unlocked,
                    joints,
                    config,
                    &generators,
                    case,
                    heartbeat,
                );
            }
            PhysicalCheck::Acceleration => check_acceleration(model, &case.waypoints),
            PhysicalCheck::Limits => check_limits(model, case),
            PhysicalCheck::Contact => {
                check_sole_speeds(model, case)?;
                check_contact(model, config, case)
            }
            PhysicalCheck::Balance => check_balance(model, config, &mut self.equilibrium, case),
            PhysicalCheck::Torque => {
                check_torque(&self.unlocked, config, &self.equilibrium, case, heartbeat)
            }
            PhysicalCheck::Collision => self.collisions.check_world(model, config, case, heartbeat),
            PhysicalCheck::SelfCollision => {
                self.collisions.check_self(model, config, case, heartbeat)
            }
        };
        result.map_err(|violation| case.as_received(violation))
    }
}

/// Lowers the margin of a check in the report to `margin`.
fn record(report: &mut SegmentReport, check: PhysicalCheck, margin: f64) {
    if let Some(worst) = check.margin(report) {
        *worst = worst.min(margin);
    }
}
