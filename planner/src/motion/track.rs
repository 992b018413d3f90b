//! A checked motion within one mode: the root, the swing sole and the free joints move along a
//! given path, the legs follow by inverse kinematics, the root gives way until the centre of mass
//! is where it shall be, and every waypoint and every motion between two is checked.

use glam::{DQuat, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::message::limits::JOINTS_MAX;
use surefoot_shared_types::spatial::{
    interpolate, rotation_about, rotation_from_scaled_axis, yaw_of,
};

use crate::body::Configuration;
use crate::collision::FootState;
use crate::constraint::{Constraints, Mode, Rejection};
use crate::motion::primitive::stand::side_of;
use crate::motion::swing::{Travel, outward, plateau};
use crate::snapshot::Snapshot;

/// A configuration together with where its soles are: the coordinates of a mode.
#[derive(Debug, Clone, Copy)]
pub struct State {
    /// Root and joints.
    pub configuration: Configuration,
    /// Both soles in the world.
    pub world_from_soles: [Pose; 2],
}

impl Default for State {
    /// At the origin: for memory that is not in use.
    fn default() -> Self {
        let configuration = Configuration { world_from_root: Pose::IDENTITY, q: [0.0; JOINTS_MAX] };
        Self { configuration, world_from_soles: [Pose::IDENTITY; 2] }
    }
}

/// Root shifts a waypoint may take to bring the centre of mass back.
const COM_SHIFTS_MAX: usize = 4;
/// How far the centre of mass may be from its course, m.
const COM_COURSE_TOLERANCE: f64 = 4e-3;
/// The smallest step along a path, as a share of it: less means that a joint would jump.
const STEP_MIN: f64 = 1.0 / 4096.0;
/// The share of the longest step that the next one is aimed at.
const STEP_AIM: f64 = 0.95;
/// The longest motion of any point between two waypoints, in collision steps.
const WAYPOINT_COLLISION_STEPS: f64 = 4.0;
/// The share of a leg's reach that a moving root leaves at least.
const REACH_SHARE_MAX: f64 = 0.997;
/// The share of a leg's reach up to which a robot stands up.
const UPRIGHT_REACH_SHARE: f64 = 0.96;
/// How far a robot that stands up rolls its hips, the one over the swing foot upward, rad.
const HIP_RAISE: f64 = 0.2;

/// One stretch of a track.
#[derive(Debug, Clone, Copy)]
pub struct Stretch {
    /// Where it begins.
    pub from: State,
    /// Where it leads.
    pub to: State,
    /// Whether it must end at `to` itself; otherwise `to` gives the direction, the legs and the
    /// centre of mass follow.
    pub exact: bool,
    /// How it is travelled.
    pub travel: Travel,
    /// What is asked of the swing foot's clearance.
    pub swing_foot: FootState,
}

impl Default for Stretch {
    /// From the origin to there: for memory that is not in use.
    fn default() -> Self {
        let [from, to] = [State::default(); 2];
        Self { from, to, exact: true, travel: Travel::STRAIGHT, swing_foot: FootState::Free }
    }
}

/// What one trial along a stretch came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// The trial was too far away; the next one is nearer.
    Nearer,
    /// [`Follower::here`] is the next waypoint.
    Waypoint,
    /// [`Follower::here`] is the last waypoint.
    Arrived,
}

/// Follows a stretch from its beginning, one trial at a time, each of which costs one unit of work;
/// then another, in the same memory.
#[derive(Debug, Clone, Default)]
pub struct Follower {
    is_under_way: bool,
    stretch: Stretch,
    /// The share of the stretch behind it.
    at: f64,
    /// The share that it tries to go next.
    step: f64,
    here: State,
    /// Of [`Follower::here`], at the place `current`, and of the trial, which is written anew each
    /// time.
    snapshots: [Snapshot; 2],
    current: usize,
    between_snapshot: Snapshot,
    /// The centre of mass at both ends, world, m.
    com_ends: [DVec3; 2],
}

impl Follower {
    /// Stands at the beginning of a stretch.
    pub fn begin(&mut self, constraints: &Constraints, stretch: &Stretch) {
        self.current = 0;
        for (snapshot, end) in self.snapshots.iter_mut().zip([&stretch.from, &stretch.to]) {
            constraints.body.snapshot_into(&end.configuration, snapshot);
        }
        self.com_ends = [self.snapshots[0].com, self.snapshots[1].com];
        (self.stretch, self.here) = (*stretch, stretch.from);
        (self.at, self.step) = (0.0, first_step(stretch));
        self.is_under_way = true;
    }

    /// Leaves its stretch.
    pub fn stop(&mut self) {
        self.is_under_way = false;
    }

    /// Whether it has begun with a stretch and not been stopped since.
    pub fn is_under_way(&self) -> bool {
        self.is_under_way
    }

    /// The waypoint that was reached last; every waypoint and every motion between two is checked.
    pub fn here(&self) -> &State {
        &self.here
    }

    /// Whether the stretch holds at a share of it. It is seen from where it was probed last, so
    /// that a stretch is probed from its beginning on; whoever follows it then begins anew.
    ///
    /// # Errors
    /// What does not hold there.
    pub fn probe(
        &mut self,
        constraints: &Constraints,
        mode: &Mode,
        at: f64,
    ) -> Result<(), Rejection> {
        let feet = foot_states(mode, self.stretch.swing_foot);
        let next_snapshot = &mut self.snapshots[1 - self.current];
        self.here =
            place(constraints, mode, &self.stretch, &self.here, at, &self.com_ends, next_snapshot)?;
        constraints.check(mode, next_snapshot, feet)
    }

    /// Tries the next waypoint.
    ///
    /// # Errors
    /// What stops it here; the waypoints before remain good.
    pub fn advance(
        &mut self,
        constraints: &Constraints,
        mode: &Mode,
    ) -> Result<Progress, Rejection> {
        let feet = foot_states(mode, self.stretch.swing_foot);
        let next_at = (self.at + self.step).min(1.0);
        let trial = 1 - self.current;
        let next = place(
            constraints,
            mode,
            &self.stretch,
            &self.here,
            next_at,
            &self.com_ends,
            &mut self.snapshots[trial],
        );
        let (used, bound) = next
            .as_ref()
            .map_or((2.0, f64::INFINITY), |state| self.use_of_step(constraints, state));
        self.step *= (STEP_AIM / used.max(1e-3)).clamp(0.25, 2.0);
        let state = match next {
            Ok(state) if used <= 1.0 => state,
            _ if self.step >= STEP_MIN => return Ok(Progress::Nearer),
            next => return Err(next.err().unwrap_or(Rejection::Discontinuous)),
        };
        constraints.check(mode, &self.snapshots[trial], feet)?;
        let ends = [&self.here.configuration, &state.configuration];
        constraints.check_between(mode, ends, bound, feet, &mut self.between_snapshot)?;
        (self.here, self.at, self.current) = (state, next_at, trial);
        self.step = self.step.min(1.0 - self.at).max(STEP_MIN);
        Ok(if self.at < 1.0 { Progress::Waypoint } else { Progress::Arrived })
    }

    /// How much of the longest step between two waypoints the next one takes, and how far any point
    /// moves on the way to it (m).
    fn use_of_step(&self, constraints: &Constraints, next: &State) -> (f64, f64) {
        let joints = self.here.configuration.q.iter().zip(&next.configuration.q);
        let joint_step = joints.map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        let config = &constraints.config;
        let bound = constraints
            .collision
            .motion_bound(&self.snapshots[self.current], &self.snapshots[1 - self.current]);
        let used = (joint_step / config.waypoint_joint_step)
            .max(bound / (WAYPOINT_COLLISION_STEPS * config.collision_step));
        (used, bound)
    }
}

fn foot_states(mode: &Mode, swing_foot: FootState) -> [FootState; 2] {
    [0, 1].map(|limb| if mode.stands(limb) { FootState::Stance } else { swing_foot })
}

/// A first guess of the step, from how far root and soles travel.
fn first_step(stretch: &Stretch) -> f64 {
    let travel = |a: &Pose, b: &Pose| a.translation.distance(b.translation);
    let root = travel(
        &stretch.from.configuration.world_from_root,
        &stretch.to.configuration.world_from_root,
    );
    let soles = [0, 1].map(|limb| {
        travel(&stretch.from.world_from_soles[limb], &stretch.to.world_from_soles[limb])
    });
    let length = root.max(soles[0]).max(soles[1]) + stretch.travel.path.detour();
    (0.03 / length.max(1e-6)).clamp(STEP_MIN, 1.0)
}

/// The same state with its legs brought to its soles and the centre of mass brought back inside the
/// support region.
///
/// # Errors
/// The legs do not reach, or the shifts do not converge.
pub fn place_at(
    constraints: &Constraints,
    mode: &Mode,
    wished: &State,
) -> Result<State, Rejection> {
    let stretch = Stretch {
        from: *wished,
        to: *wished,
        exact: false,
        travel: Travel::STRAIGHT,
        swing_foot: FootState::Free,
    };
    place(constraints, mode, &stretch, wished, 1.0, &[DVec3::ZERO; 2], &mut Snapshot::default())
}

/// The state at `t` along a stretch, and its snapshot; at its end the wished-for state itself.
fn place(
    constraints: &Constraints,
    mode: &Mode,
    stretch: &Stretch,
    here: &State,
    t: f64,
    com_ends: &[DVec3; 2],
    snapshot: &mut Snapshot,
) -> Result<State, Rejection> {
    let body = &constraints.body;
    if t >= 1.0 && stretch.exact {
        body.snapshot_into(&stretch.to.configuration, snapshot);
        return Ok(stretch.to);
    }
    let mut state = *here;
    for limb in (0..2).filter(|&limb| !mode.stands(limb)) {
        state.world_from_soles[limb] = swing_pose(stretch, limb, t);
    }
    let (from, to) = (&stretch.from.configuration, &stretch.to.configuration);
    let course = root_course(constraints, mode, stretch, &state.world_from_soles, t);
    for joint in &body.free_joints {
        state.configuration.q[joint.index] =
            from.q[joint.index] + t * (to.q[joint.index] - from.q[joint.index]);
    }
    state.configuration.world_from_root = course;
    let course_com = com_ends[0].lerp(com_ends[1], t).truncate();
    let com_depth = constraints.com_margin(mode) + COM_COURSE_TOLERANCE;
    for _ in 0..COM_SHIFTS_MAX {
        let root = &mut state.configuration.world_from_root;
        let highest = body
            .root_height(root, &state.world_from_soles, [REACH_SHARE_MAX; 2])
            .ok_or(Rejection::Unreachable)?;
        root.translation.z = course.translation.z.min(highest);
        if !body.place_soles_near(&mut state.configuration, &state.world_from_soles) {
            return Err(Rejection::Unreachable);
        }
        body.snapshot_into(&state.configuration, snapshot);
        let com = snapshot.com.truncate();
        let error = if stretch.exact {
            course_com - com
        } else {
            mode.region.nearest_inside(com, com_depth) - com
        };
        if error.length() <= COM_COURSE_TOLERANCE {
            return Ok(state);
        }
        state.configuration.world_from_root.translation += error.extend(0.0);
    }
    Err(Rejection::Balance)
}

/// Where the root would be, but for its balance.
fn root_course(
    constraints: &Constraints,
    mode: &Mode,
    stretch: &Stretch,
    world_from_soles: &[Pose; 2],
    t: f64,
) -> Pose {
    let mut course = interpolate(
        &stretch.from.configuration.world_from_root,
        &stretch.to.configuration.world_from_root,
        t,
    );
    if !stretch.travel.stands_up {
        return course;
    }
    if let Some(limb) = mode.swing() {
        course.rotation = hip_raised(course.rotation, limb, plateau(t));
    }
    if let Some(highest) =
        constraints.body.root_height(&course, world_from_soles, [UPRIGHT_REACH_SHARE; 2])
    {
        course.translation.z += plateau(t) * (highest - course.translation.z).max(0.0);
    }
    course
}

/// The root's rotation with its hip over a swing foot raised, by a share of the whole.
fn hip_raised(world_from_root: DQuat, limb: usize, share: f64) -> DQuat {
    let ahead = rotation_about(DVec3::Z, yaw_of(world_from_root)) * DVec3::X;
    (rotation_from_scaled_axis(share * side_of(limb) * HIP_RAISE * ahead) * world_from_root)
        .normalize()
}

fn swing_pose(stretch: &Stretch, limb: usize, t: f64) -> Pose {
    let Stretch { from, to, travel, .. } = stretch;
    let outward =
        || outward([&from.configuration.world_from_root, &to.configuration.world_from_root], limb);
    travel.path.pose([&from.world_from_soles[limb], &to.world_from_soles[limb]], outward, t)
}
