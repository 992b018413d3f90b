//! The robot as timing sees it: the rates that its limits allow at a point of a path, the load of a
//! motion, and its torques.

use glam::{DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::message::{Contact, Waypoint};
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::GRAVITY;

use crate::constraints::foothold::Ground;
use crate::geometry::polygon::area_and_centroid;
use crate::robot::inverse_dynamics::{GeneralizedForce, InverseDynamics, LinkFrames, VELOCITY_MAX};
use crate::timing::contact_rates::{ContactProblem, ContactRates, soles_hold};
use crate::timing::feed_forward::FeedForward;
use crate::timing::limit::Limit;
use crate::timing::limits::{Level, TimingLimits};
use crate::timing::load_sharing::LoadSchedule;
use crate::timing::path_dynamics::{Chains, PathDynamics, PathState, bears_all, joint_rates};
use crate::timing::path_point::{PathPoint, PathSpan};
use crate::timing::rate_set::RateSet;
use crate::timing::sole_twist;
use crate::timing::support::{SpanSupports, Support, supported_part};
use crate::timing::tuning::{
    CARRIED_DOUBT, INCLINED_COSINE, LANDING_SPEED_BY_DISTANCE, LANDING_SPEED_INCLINED, LIMITS_PART,
    REST_ACCELERATION, SLICK_FRICTION, STANCE_SPEEDS_MAX, TOUCHDOWN_SPEED_MAX, UNSUPPORTED_RATE,
};
use crate::timing::zero_moment::{BalanceTerms, ContactGround, GroundLoad};

/// A robot with its limits.
#[derive(Debug)]
pub struct TimedRobot {
    dynamics: InverseDynamics,
    limits: TimingLimits,
    chains: Chains,
    /// Node of each foot, and its sole in that node's frame.
    soles: [(usize, Pose); 2],
    /// Area of each sole, m2.
    sole_areas: [f64; 2],
    joints_len: usize,
    mass: f64,
}

/// Memory for the dynamics of one instant after the other, and for their programs.
#[derive(Debug, Default)]
pub(crate) struct TimingMemory {
    contact_rates: ContactRates,
    dynamics: PathDynamics,
}

/// A sole that lands at the end of a span.
#[derive(Debug)]
pub(crate) struct Landing {
    limb: usize,
    /// Where its origin lands (world), m.
    point: DVec3,
    /// Whether it or the stance sole is inclined or on uneven ground.
    is_inclined: bool,
}

/// What the limits allow at a point of a path.
#[derive(Debug)]
pub(crate) struct PointLimits {
    /// The rates.
    pub rates: RateSet,
    /// What they leave of the limits.
    pub level: Level,
    /// The load on the ground.
    pub balance: BalanceTerms,
}

/// The contacts of a span, as all of its points share them.
#[derive(Debug)]
pub(crate) struct SpanContacts<'a> {
    pub span: &'a PathSpan,
    pub ground: ContactGround,
    pub supports: SpanSupports,
    /// Distance (m) by which the centre of pressure stays further inside than at a level.
    extra: f64,
    /// Whether a stance sole is inclined, or stands on uneven ground.
    pub is_inclined: bool,
    /// By joint: whether the only contact is beyond it; `None` where one of two is.
    are_loaded: [Option<bool>; JOINTS_MAX],
}

/// What a motion asks of the robot at an instant.
#[derive(Debug, Clone)]
pub(crate) struct AskedOfRobot {
    /// Force on the robot, N.
    force: DVec3,
    /// Moment about the world's origin, N m.
    moment: DVec3,
    /// Torques with the contact where that is the only one beyond a joint, otherwise without.
    torques: [f64; JOINTS_MAX],
    /// The largest ratio of a stance sole's speed to its limit.
    slip: f64,
}

impl AskedOfRobot {
    /// The polynomial of degree 3 through four instants, of which these are the weights. The slip
    /// is the largest one.
    pub(crate) fn interpolated(known: [&Self; 4], weights: [f64; 4]) -> Self {
        let mut sum =
            Self { force: DVec3::ZERO, moment: DVec3::ZERO, torques: [0.0; JOINTS_MAX], slip: 0.0 };
        for (of, weight) in known.into_iter().zip(weights) {
            sum.force += of.force * weight;
            sum.moment += of.moment * weight;
            sum.torques.iter_mut().zip(&of.torques).for_each(|(sum, of)| *sum += of * weight);
            sum.slip = sum.slip.max(of.slip);
        }
        sum
    }
}

/// Velocity and acceleration of a waypoint, root and joints in one list.
pub(crate) fn rates_of(waypoint: &Waypoint) -> [[f64; VELOCITY_MAX]; 2] {
    let joined = |root: &[f64; 6], joints: &[f64; JOINTS_MAX]| {
        std::array::from_fn(|index| if index < 6 { root[index] } else { joints[index - 6] })
    };
    [
        joined(&waypoint.root_velocity, &waypoint.joint_velocity),
        joined(&waypoint.root_acceleration, &waypoint.joint_acceleration),
    ]
}

impl TimedRobot {
    /// A biped with these limits.
    pub fn new(model: &RobotModel, limits: TimingLimits) -> Self {
        let dynamics = InverseDynamics::new(model);
        let feet = [&model.feet[0], &model.feet[1]];
        let sole = |foot: &surefoot_shared_types::robot::model::Foot| {
            let (node, node_from_link) = dynamics.tree().of_link(foot.link);
            (node, node_from_link * foot.link_from_sole)
        };
        Self {
            chains: feet.map(|foot| model.chain(foot.link).into_iter().collect()),
            soles: feet.map(sole),
            sole_areas: feet.map(|foot| area_and_centroid(&foot.polygon).0),
            joints_len: model.joints.len(),
            mass: dynamics.mass(),
            limits,
            dynamics,
        }
    }

    /// Shortest time in which it brakes or goes on, s.
    pub(super) fn ramp_seconds_min(&self) -> f64 {
        self.limits.ramp_seconds_min
    }

    /// The contacts of a span, the centre of pressure `extra` (m) further inside than at a level.
    pub(super) fn span_contacts<'a>(&self, span: &'a PathSpan, extra: f64) -> SpanContacts<'a> {
        let is_inclined = span.is_uneven() || span.is_inclined();
        let levels = Level::levels(is_inclined);
        let supports = SpanSupports::new(span, levels, extra, self.limits.friction);
        let is_loaded = |joint| bears_all(supports.at(levels[0]), &self.chains, joint);
        SpanContacts {
            span,
            ground: self.contact_ground(span),
            are_loaded: std::array::from_fn(is_loaded),
            supports,
            extra,
            is_inclined,
        }
    }

    /// The rates at a point of a span, and what they leave of the limits. `touches_down`: whether
    /// the swing foot lands here. `landing`: the sole that lands at the end of the span.
    pub(crate) fn rates(
        &self,
        memory: &mut TimingMemory,
        contacts: &SpanContacts<'_>,
        point: &Waypoint,
        (landing, touches_down): (Option<&Landing>, bool),
    ) -> PointLimits {
        let SpanContacts { span, ground, supports, extra, .. } = contacts;
        let TimingMemory { contact_rates, dynamics, .. } = memory;
        let [first, second] = rates_of(point);
        let root = point.world_from_root();
        let state = PathState { root: &root, q: &point.q, first: &first, second: &second };
        dynamics.write(&self.dynamics, &state, GRAVITY);
        let dynamics = &*dynamics;
        let balance = ground.terms(dynamics);
        let slip = self.stance_slip(span, &dynamics.frames, &first);
        for &level in supports.levels() {
            let support = supports.at(level);
            let mut rates = joint_rates(
                dynamics,
                &state,
                (support, &self.chains),
                (&self.limits, level),
                self.joints_len,
            );
            let rate_max = LIMITS_PART / slip.max(SLIP_MIN);
            rates.clip(DVec2::X, rate_max.powi(2), Limit::StanceSole);
            if let Some(landing) = landing {
                let at = (&dynamics.frames, &first);
                self.clip_by_landing(&mut rates, (landing, touches_down), at);
            }
            ground.region(level, *extra).clip(&balance, &mut rates);
            sole_twist::clip(dynamics, support, &mut rates);
            let problem = self.problem(dynamics, support, level, LIMITS_PART);
            let mut found = contact_rates.restrict(&problem, &rates);
            if !self.can_start(&found, level) {
                found = contact_rates.restrict_by_program(&problem, &rates);
            }
            if self.can_start(&found, level) {
                return PointLimits { rates: found, level, balance };
            }
        }
        let mut rates = RateSet::within(UNSUPPORTED_RATE.powi(2), UNSUPPORTED_RATE);
        let level = Level::Unsupported;
        ground.region(level, *extra).clip(&balance, &mut rates);
        PointLimits { rates, level, balance }
    }

    /// Whether the path can accelerate from rest in both directions, as a level must allow: less on
    /// slick ground.
    fn can_start(&self, rates: &RateSet, level: Level) -> bool {
        let least = self.start_acceleration(level);
        let range = rates.accelerations_at(0.0);
        range.is_some_and(|[low, high]| low <= -least && high >= least)
    }

    /// The acceleration along the path from rest that a level must allow.
    fn start_acceleration(&self, level: Level) -> f64 {
        let grip = (self.limits.friction / SLICK_FRICTION).min(1.0);
        grip * if level == Level::Bare { UNSUPPORTED_RATE } else { REST_ACCELERATION }
    }

    /// Whether the robot can start in both directions within the limits of a level where it is at
    /// a sample of a motion, which has this speed along its path.
    pub(crate) fn can_start_at(
        &self,
        memory: &mut TimingMemory,
        contacts: &SpanContacts<'_>,
        level: Level,
        (sample, speed): (&Waypoint, f64),
    ) -> bool {
        let least = self.start_acceleration(level) / speed.max(SAMPLE_SPEED_MIN);
        [-least, least].into_iter().all(|change| {
            let mut starting = sample.rested();
            starting.root_acceleration = sample.root_velocity.map(|velocity| change * velocity);
            starting.joint_acceleration = sample.joint_velocity.map(|velocity| change * velocity);
            self.load(memory, contacts, level, &starting) <= 1.0
        })
    }

    /// The ground under the contacts of a span.
    pub(super) fn contact_ground(&self, span: &PathSpan) -> ContactGround {
        let is_partial = span.contacts.iter().any(|contact| {
            let (area, _) = area_and_centroid(&supported_part(contact));
            area < WHOLE_SOLE_SHARE * self.sole_areas[contact.limb as usize]
        });
        ContactGround::new(&span.contacts, self.limits.zero_moment_margin, is_partial)
    }

    fn problem<'a>(
        &'a self,
        dynamics: &'a PathDynamics,
        support: &'a Support,
        level: Level,
        efforts_part: f64,
    ) -> ContactProblem<'a> {
        ContactProblem {
            dynamics,
            support,
            chains: &self.chains,
            efforts: level.efforts(&self.limits),
            efforts_part,
            mass: self.mass,
        }
    }

    /// The sole that lands at the end of a span; `None` where both feet stand.
    pub(super) fn landing(&self, contacts: &SpanContacts<'_>, last: &PathPoint) -> Option<Landing> {
        let [stance] = contacts.span.contacts.as_slice() else { return None };
        let limb = 1 - stance.limb as usize;
        let mut frames = LinkFrames::default();
        self.dynamics.place(&last.world_from_root, &last.q, &mut frames);
        let (point, normal) = self.sole_at(&frames, limb);
        let is_uneven = contacts.span.grounds[limb] != Ground::Even;
        let is_inclined = contacts.is_inclined || is_uneven || normal.z < INCLINED_COSINE;
        Some(Landing { limb, point, is_inclined })
    }

    /// Bounds the speed of a landing sole along its normal where it lands; from or to an inclined
    /// sole also before that.
    fn clip_by_landing(
        &self,
        rates: &mut RateSet,
        (landing, touches_down): (&Landing, bool),
        (frames, first): (&LinkFrames, &[f64; VELOCITY_MAX]),
    ) {
        let (point, normal) = self.sole_at(frames, landing.limb);
        let distance = point.distance(landing.point);
        let speed_max = match (touches_down, landing.is_inclined) {
            (_, true) => LANDING_SPEED_INCLINED + LANDING_SPEED_BY_DISTANCE * distance,
            (true, false) => TOUCHDOWN_SPEED_MAX,
            (false, false) => return,
        };
        let speed = normal.dot(frames.point_velocity(&self.chains[landing.limb], point, first));
        if speed < 0.0 || touches_down {
            let rate_max = speed_max / speed.abs().max(1e-6);
            rates.clip(DVec2::X, rate_max.powi(2), Limit::Touchdown);
        }
    }

    /// The origin of a sole and its normal, in the world.
    fn sole_at(&self, frames: &LinkFrames, limb: usize) -> (DVec3, DVec3) {
        let (node, node_from_sole) = self.soles[limb];
        let frame = frames.world_from_node(node);
        let normal = frame.matrix3 * (node_from_sole.rotation * DVec3::Z);
        (frame.transform_point3(node_from_sole.translation), normal)
    }

    /// The largest ratio of a stance sole's speed to its limit, for velocities of root and joints.
    fn stance_slip(
        &self,
        span: &PathSpan,
        frames: &LinkFrames,
        velocity: &[f64; VELOCITY_MAX],
    ) -> f64 {
        let [speed_max, turn_max] = STANCE_SPEEDS_MAX;
        let slip = |contact: &Contact| {
            let limb = contact.limb as usize;
            let chain = &self.chains[limb];
            let (point, _) = self.sole_at(frames, limb);
            let speed = frames.point_velocity(chain, point, velocity).length();
            let turn = frames.angular_velocity(chain, velocity).length();
            (speed / speed_max).max(turn / turn_max)
        };
        span.contacts.iter().map(slip).fold(0.0, f64::max)
    }

    /// How far a motion is beyond the limits of a level: the largest ratio of a speed, acceleration
    /// or torque to its limit, or [`INADMISSIBLE`]; at most 1 within the limits.
    pub(crate) fn load(
        &self,
        memory: &mut TimingMemory,
        contacts: &SpanContacts<'_>,
        level: Level,
        waypoint: &Waypoint,
    ) -> f64 {
        let SpanContacts { span, ground, supports, extra, are_loaded, .. } = contacts;
        let TimingMemory { contact_rates, dynamics, .. } = memory;
        let [velocity, acceleration] = rates_of(waypoint);
        self.write_instant(waypoint, dynamics);
        let dynamics = &*dynamics;
        let support = supports.at(level);
        let (limits, efforts) = (&self.limits, level.efforts(&self.limits));
        let load_of = |of: &GeneralizedForce| ground.load((of.force, of.moment), dynamics.origin);
        let at_rest = || load_of(&self.dynamics.effort(&dynamics.frames, &REST, &REST, GRAVITY));
        let is_upright = ground.region(level, *extra).holds(&load_of(&dynamics.standing), at_rest);
        let is_admitted = is_upright && self.limits.admit(&waypoint.q);
        let mut load = if is_admitted { 0.0 } else { INADMISSIBLE };
        load = load.max(self.stance_slip(span, &dynamics.frames, &velocity));
        if level == Level::Unsupported {
            return load;
        }
        for (joint, effort) in efforts.iter().enumerate().take(self.joints_len) {
            load = load.max(velocity[6 + joint].abs() / limits.speeds[joint]);
            load = load.max(acceleration[6 + joint].abs() / limits.accelerations[joint]);
            if let Some(is_loaded) = are_loaded[joint] {
                load = load.max(dynamics.torque_of_instant(joint, is_loaded).abs() / effort);
            }
        }
        let GeneralizedForce { force, moment, .. } = dynamics.standing;
        load = load.max(sole_twist::load(support, (force, moment + dynamics.origin.cross(force))));
        let problem = self.problem(dynamics, support, level, 1.0);
        let is_carried = contact_rates.admits(&problem, DVec2::ZERO);
        if is_carried { load } else { load.max(INADMISSIBLE) }
    }

    /// Whether soles bear a load on the ground for which nearby loads are borne, too: those
    /// with the pressure moved by [`CARRIED_DOUBT`]. Where they do not, other forces may.
    pub(super) fn soles_bear(contacts: &SpanContacts<'_>, level: Level, load: &GroundLoad) -> bool {
        let (force, moment) = contacts.ground.wrench(load);
        let reach = CARRIED_DOUBT * force.z;
        let support = contacts.supports.at(level);
        [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)].into_iter().all(|(x, y)| {
            let moment = moment + reach * DVec3::new(x, y, 0.0);
            soles_hold(support, (force, moment))
        })
    }

    /// Whether contact forces within friction, soles and efforts of a level move the robot as at an
    /// instant of a motion. True where no forces are known at the level.
    pub(super) fn is_carried(
        &self,
        memory: &mut TimingMemory,
        contacts: &SpanContacts<'_>,
        level: Level,
        waypoint: &Waypoint,
    ) -> bool {
        if level == Level::Unsupported {
            return true;
        }
        let TimingMemory { contact_rates, dynamics } = memory;
        self.write_instant(waypoint, dynamics);
        let efforts = level.efforts(&self.limits);
        let bears = |joint: usize| {
            contacts.are_loaded[joint].is_none_or(|is_loaded| {
                dynamics.torque_of_instant(joint, is_loaded).abs() <= efforts[joint]
            })
        };
        let problem = self.problem(dynamics, contacts.supports.at(level), level, 1.0);
        (0..self.joints_len).all(bears) && contact_rates.admits(&problem, DVec2::ZERO)
    }

    /// What the motion of the last [`Self::load`] asks of the robot.
    pub(crate) fn asked(
        &self,
        memory: &TimingMemory,
        contacts: &SpanContacts<'_>,
        waypoint: &Waypoint,
    ) -> AskedOfRobot {
        let dynamics = &memory.dynamics;
        let [velocity, _] = rates_of(waypoint);
        let GeneralizedForce { force, moment, .. } = dynamics.standing;
        let torque = |joint: usize| {
            dynamics.torque_of_instant(joint, contacts.are_loaded[joint] == Some(true))
        };
        let mut torques = [0.0; JOINTS_MAX];
        (0..self.joints_len).for_each(|joint| torques[joint] = torque(joint));
        AskedOfRobot {
            force,
            moment: moment + dynamics.origin.cross(force),
            torques,
            slip: self.stance_slip(contacts.span, &dynamics.frames, &velocity),
        }
    }

    /// Whether a motion that is known to ask this of the robot is within the limits of a level. The
    /// bodies are nearly where they were at the last [`Self::load`], which decides where this does
    /// not hold.
    pub(crate) fn bears(
        &self,
        memory: &mut TimingMemory,
        contacts: &SpanContacts<'_>,
        level: Level,
        (waypoint, asked): (&Waypoint, &AskedOfRobot),
    ) -> bool {
        let efforts = level.efforts(&self.limits);
        let joint_holds = |joint: usize| {
            let is_own = contacts.are_loaded[joint].is_some();
            waypoint.joint_velocity[joint].abs() <= self.limits.speeds[joint]
                && waypoint.joint_acceleration[joint].abs() <= self.limits.accelerations[joint]
                && (!is_own || asked.torques[joint].abs() <= ASKED_PART * efforts[joint])
        };
        let load = contacts.ground.load((asked.force, asked.moment), DVec3::ZERO);
        let region = contacts.ground.region(level, contacts.extra + ASKED_MARGIN);
        let support = contacts.supports.at(level);
        let is_within = level != Level::Unsupported
            && asked.slip <= ASKED_SLIP
            && self.limits.admit(&waypoint.q)
            && (0..self.joints_len).all(joint_holds)
            && region.contains(&load)
            && sole_twist::load(support, (asked.force, asked.moment)) <= ASKED_PART;
        if !is_within {
            return false;
        }
        let dynamics = &mut memory.dynamics;
        dynamics.standing.force = asked.force;
        dynamics.standing.torques = asked.torques;
        let moment = asked.moment - dynamics.origin.cross(asked.force);
        let reach = ASKED_MARGIN * asked.force.z;
        [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)].into_iter().all(|(x, y)| {
            memory.dynamics.standing.moment = moment + reach * DVec3::new(x, y, 0.0);
            let problem = self.problem(&memory.dynamics, support, level, ASKED_EFFORTS_PART);
            problem.is_known_to_hold(DVec2::ZERO)
        })
    }

    /// The load on the ground by unit of squared speed at a point of a path.
    pub(super) fn load_by_speed(
        &self,
        memory: &mut TimingMemory,
        ground: &ContactGround,
        point: &Waypoint,
    ) -> GroundLoad {
        let [first, second] = rates_of(point);
        let dynamics = &mut memory.dynamics;
        self.place(point, dynamics);
        let effort = self.dynamics.effort(&dynamics.frames, &first, &second, 0.0);
        ground.load((effort.force, effort.moment), dynamics.origin)
    }

    /// The load on the ground at one instant of a motion.
    pub(super) fn ground_load(&self, ground: &ContactGround, waypoint: &Waypoint) -> GroundLoad {
        let mut dynamics = PathDynamics::default();
        self.write_instant(waypoint, &mut dynamics);
        ground.load((dynamics.standing.force, dynamics.standing.moment), dynamics.origin)
    }

    /// Writes the feed-forward torques of a waypoint, at a part (0 to 1) of its span: those of the
    /// plan, those at rest, and their change where the rate of plan time changes.
    pub(crate) fn write_torques(
        &self,
        memory: &mut TimingMemory,
        span: &PathSpan,
        level: Level,
        at: (&LoadSchedule, f64),
        waypoint: &mut Waypoint,
    ) {
        let [first, second] = rates_of(waypoint);
        let root = waypoint.world_from_root();
        let state = PathState { root: &root, q: &waypoint.q, first: &first, second: &second };
        memory.dynamics.write(&self.dynamics, &state, GRAVITY);
        let [support, bare] =
            [level, Level::Bare].map(|level| Support::new(span, level, 0.0, self.limits.friction));
        let [problem, bare] = [(&support, level), (&bare, Level::Bare)]
            .map(|(support, level)| self.problem(&memory.dynamics, support, level, 1.0));
        let bare = (support.feet.len() > 1).then_some(bare);
        FeedForward { limits: &self.limits, problem, bare, at }.write(waypoint);
    }

    /// Writes the dynamics of a motion at one instant: all of it is the constant part.
    fn write_instant(&self, waypoint: &Waypoint, dynamics: &mut PathDynamics) {
        let [velocity, acceleration] = rates_of(waypoint);
        self.place(waypoint, dynamics);
        dynamics.standing =
            self.dynamics.effort(&dynamics.frames, &velocity, &acceleration, GRAVITY);
    }

    /// Places the bodies as they are at one instant of a motion.
    fn place(&self, waypoint: &Waypoint, dynamics: &mut PathDynamics) {
        let root = waypoint.world_from_root();
        self.dynamics.place(&root, &waypoint.q, &mut dynamics.frames);
        dynamics.origin = root.translation;
    }
}

/// Velocities, or accelerations, at rest.
const REST: [f64; VELOCITY_MAX] = [0.0; VELOCITY_MAX];

/// Share of a sole's area from which all of it counts as supported.
const WHOLE_SOLE_SHARE: f64 = 0.98;

/// Smallest speed along a path that gives its direction.
const SAMPLE_SPEED_MIN: f64 = 1e-6;

/// Smallest ratio of a stance sole's speed to its limit that bounds the rates.
const SLIP_MIN: f64 = 1e-6;

/// The part of limits, the margin (m) of zero-moment point and centre of pressure, the slip of
/// stance soles over its limit, and the part of efforts of legs that share the load, within which
/// an interpolated load counts as within the limits.
const ASKED_PART: f64 = 0.999;
const ASKED_MARGIN: f64 = 1e-4;
const ASKED_SLIP: f64 = 0.9;
const ASKED_EFFORTS_PART: f64 = 0.9;

/// The load of a motion that no contact forces hold, or with a joint beyond its positions.
pub(crate) const INADMISSIBLE: f64 = 1.04;
