//! A checked motion within one mode: the root, the swing sole and the free joints move along a
//! given path, the legs follow by inverse kinematics, the root gives way until the centre of mass
//! is where it shall be, and every waypoint and every motion between two is checked.

use glam::{DQuat, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{
    interpolate, rotation_about, rotation_from_scaled_axis, yaw_of,
};

use crate::collision::model::FootPhase;
use crate::constraints::constraints::Constraints;
use crate::constraints::mode::Mode;
use crate::constraints::mode_state::ModeState;
use crate::constraints::rejection::Rejection;
use crate::motion::swing_shapes::{MotionShape, outward, plateau};
use crate::primitives::level_sole::side_of;
use crate::robot::kinematic_state::KinematicState;

/// Root shifts a waypoint may take to bring the centre of mass back.
const COM_SHIFTS_MAX: usize = 4;
/// How far the centre of mass may be from its course, m.
const COM_TRACKING_TOLERANCE: f64 = 4e-3;
/// The smallest step along a path, as a share of it: less means that a joint would jump.
const STEP_MIN: f64 = 1.0 / 4096.0;
/// The share of the longest step that the next one is aimed at.
const STEP_AIM: f64 = 0.95;
/// The longest motion of any point between two waypoints, in collision steps.
const WAYPOINT_COLLISION_STEPS: f64 = 4.0;
/// The share of a leg's reach that a moving root leaves at least.
const LEG_EXTENSION_MAX: f64 = 0.997;
/// The share of a leg's reach up to which a robot stands up.
const UPRIGHT_LEG_EXTENSION: f64 = 0.96;
/// How far a robot that stands up rolls its hips, the one over the swing foot upward, rad.
const HIP_RAISE: f64 = 0.2;

/// One local path of a path.
#[derive(Debug, Clone, Copy)]
pub struct LocalPath {
    /// Where it begins.
    pub from: ModeState,
    /// Where it leads.
    pub to: ModeState,
    /// Whether it must end at `to` itself; otherwise `to` gives the direction, the legs and the
    /// centre of mass follow.
    pub exact: bool,
    /// How it is travelled.
    pub shape: MotionShape,
    /// What is asked of the swing foot's clearance.
    pub swing_foot: FootPhase,
}

impl Default for LocalPath {
    /// From the origin to there: for memory that is not in use.
    fn default() -> Self {
        let [from, to] = [ModeState::default(); 2];
        Self { from, to, exact: true, shape: MotionShape::STRAIGHT, swing_foot: FootPhase::Swing }
    }
}

/// What one trial along a local path came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// The trial was too far away; the next one is nearer.
    ShorterStep,
    /// [`LocalPlanner::here`] is the next waypoint.
    Waypoint,
    /// [`LocalPlanner::here`] is the last waypoint.
    Reached,
}

/// Follows a local path from its beginning, one trial at a time, each of which costs one unit of
/// work; then another, in the same memory.
#[derive(Debug, Clone, Default)]
pub struct LocalPlanner {
    is_active: bool,
    local_path: LocalPath,
    /// The share of the local path behind it.
    at: f64,
    /// The share that it tries to go next.
    step: f64,
    here: ModeState,
    /// Of [`LocalPlanner::here`], at the place `current`, and of the trial, which is written anew
    /// each time.
    kinematic_states: [KinematicState; 2],
    current: usize,
    intermediate_kinematic_state: KinematicState,
    /// The centre of mass at both ends, world, m.
    com_ends: [DVec3; 2],
}

impl LocalPlanner {
    /// Stands at the beginning of a local path.
    pub fn begin(&mut self, constraints: &Constraints, local_path: &LocalPath) {
        self.current = 0;
        for (kinematic_state, end) in
            self.kinematic_states.iter_mut().zip([&local_path.from, &local_path.to])
        {
            kinematic_state.update(&constraints.robot, &end.configuration);
        }
        self.com_ends = [self.kinematic_states[0].com, self.kinematic_states[1].com];
        (self.local_path, self.here) = (*local_path, local_path.from);
        (self.at, self.step) = (0.0, initial_step(local_path));
        self.is_active = true;
    }

    /// Leaves its local path.
    pub fn stop(&mut self) {
        self.is_active = false;
    }

    /// Whether it has begun with a local path and not been stopped since.
    pub fn is_active(&self) -> bool {
        self.is_active
    }

    /// The waypoint that was reached last; every waypoint and every motion between two is checked.
    pub fn here(&self) -> &ModeState {
        &self.here
    }

    /// Whether the local path holds at a share of it. It is seen from where it was probed last, so
    /// that a local path is probed from its beginning on; whoever follows it then begins anew.
    ///
    /// # Errors
    /// What does not hold there.
    pub fn probe(
        &mut self,
        constraints: &Constraints,
        mode: &Mode,
        at: f64,
    ) -> Result<(), Rejection> {
        let feet = foot_phases(mode, self.local_path.swing_foot);
        let next_kinematic_state = &mut self.kinematic_states[1 - self.current];
        self.here = state_at(
            constraints,
            mode,
            &self.local_path,
            &self.here,
            at,
            &self.com_ends,
            next_kinematic_state,
        )?;
        constraints.check(mode, next_kinematic_state, feet)
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
        let feet = foot_phases(mode, self.local_path.swing_foot);
        let next_at = (self.at + self.step).min(1.0);
        let trial = 1 - self.current;
        let next = state_at(
            constraints,
            mode,
            &self.local_path,
            &self.here,
            next_at,
            &self.com_ends,
            &mut self.kinematic_states[trial],
        );
        let (used, bound) =
            next.as_ref().map_or((2.0, f64::INFINITY), |state| self.step_usage(constraints, state));
        self.step *= (STEP_AIM / used.max(1e-3)).clamp(0.25, 2.0);
        let state = match next {
            Ok(state) if used <= 1.0 => state,
            _ if self.step >= STEP_MIN => return Ok(Progress::ShorterStep),
            next => return Err(next.err().unwrap_or(Rejection::Discontinuous)),
        };
        constraints.check(mode, &self.kinematic_states[trial], feet)?;
        let ends = [&self.here.configuration, &state.configuration];
        constraints.check_between(
            mode,
            ends,
            bound,
            feet,
            &mut self.intermediate_kinematic_state,
        )?;
        (self.here, self.at, self.current) = (state, next_at, trial);
        self.step = self.step.min(1.0 - self.at).max(STEP_MIN);
        Ok(if self.at < 1.0 { Progress::Waypoint } else { Progress::Reached })
    }

    /// How much of the longest step between two waypoints the next one takes, and how far any point
    /// moves on the way to it (m).
    fn step_usage(&self, constraints: &Constraints, next: &ModeState) -> (f64, f64) {
        let joints = self.here.configuration.q.iter().zip(&next.configuration.q);
        let joint_step = joints.map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        let config = &constraints.config;
        let bound = constraints.collision.motion_bound(
            &self.kinematic_states[self.current],
            &self.kinematic_states[1 - self.current],
        );
        let used = (joint_step / config.waypoint_joint_step)
            .max(bound / (WAYPOINT_COLLISION_STEPS * config.collision_step));
        (used, bound)
    }
}

fn foot_phases(mode: &Mode, swing_foot: FootPhase) -> [FootPhase; 2] {
    [0, 1].map(|limb| if mode.is_stance(limb) { FootPhase::Stance } else { swing_foot })
}

/// A first guess of the step, from how far root and soles travel.
fn initial_step(local_path: &LocalPath) -> f64 {
    let distance = |a: &Pose, b: &Pose| a.translation.distance(b.translation);
    let root = distance(
        &local_path.from.configuration.world_from_root,
        &local_path.to.configuration.world_from_root,
    );
    let soles = [0, 1].map(|limb| {
        distance(&local_path.from.world_from_soles[limb], &local_path.to.world_from_soles[limb])
    });
    let length = root.max(soles[0]).max(soles[1]) + local_path.shape.swing.extra_length();
    (0.03 / length.max(1e-6)).clamp(STEP_MIN, 1.0)
}

/// The same state with its legs brought to its soles and the centre of mass brought back inside the
/// support region.
///
/// # Errors
/// The legs do not reach, or the shifts do not converge.
pub fn feasible_state(
    constraints: &Constraints,
    mode: &Mode,
    desired: &ModeState,
) -> Result<ModeState, Rejection> {
    let local_path = LocalPath {
        from: *desired,
        to: *desired,
        exact: false,
        shape: MotionShape::STRAIGHT,
        swing_foot: FootPhase::Swing,
    };
    state_at(
        constraints,
        mode,
        &local_path,
        desired,
        1.0,
        &[DVec3::ZERO; 2],
        &mut KinematicState::default(),
    )
}

/// The state at `t` along a local path, and its kinematic state; at its end the desired state
/// itself.
fn state_at(
    constraints: &Constraints,
    mode: &Mode,
    local_path: &LocalPath,
    here: &ModeState,
    t: f64,
    com_ends: &[DVec3; 2],
    kinematic_state: &mut KinematicState,
) -> Result<ModeState, Rejection> {
    let robot = &constraints.robot;
    if t >= 1.0 && local_path.exact {
        kinematic_state.update(robot, &local_path.to.configuration);
        return Ok(local_path.to);
    }
    let mut state = *here;
    for limb in (0..2).filter(|&limb| !mode.is_stance(limb)) {
        state.world_from_soles[limb] = swing_pose(local_path, limb, t);
    }
    let (from, to) = (&local_path.from.configuration, &local_path.to.configuration);
    let reference = root_reference(constraints, mode, local_path, &state.world_from_soles, t);
    for joint in &robot.free_joints {
        state.configuration.q[joint.index] =
            from.q[joint.index] + t * (to.q[joint.index] - from.q[joint.index]);
    }
    state.configuration.world_from_root = reference;
    let reference_com = com_ends[0].lerp(com_ends[1], t).truncate();
    let com_depth = constraints.com_margin(mode) + COM_TRACKING_TOLERANCE;
    for _ in 0..COM_SHIFTS_MAX {
        let root = &mut state.configuration.world_from_root;
        let highest = robot
            .root_height(root, &state.world_from_soles, [LEG_EXTENSION_MAX; 2])
            .ok_or(Rejection::Unreachable)?;
        root.translation.z = reference.translation.z.min(highest);
        if !robot.place_soles_near(&mut state.configuration, &state.world_from_soles) {
            return Err(Rejection::Unreachable);
        }
        kinematic_state.update(robot, &state.configuration);
        let com = kinematic_state.com.truncate();
        let error = if local_path.exact {
            reference_com - com
        } else {
            mode.region.nearest_inside(com, com_depth) - com
        };
        if error.length() <= COM_TRACKING_TOLERANCE {
            return Ok(state);
        }
        state.configuration.world_from_root.translation += error.extend(0.0);
    }
    Err(Rejection::Balance)
}

/// Where the root would be, but for its balance.
fn root_reference(
    constraints: &Constraints,
    mode: &Mode,
    local_path: &LocalPath,
    world_from_soles: &[Pose; 2],
    t: f64,
) -> Pose {
    let mut reference = interpolate(
        &local_path.from.configuration.world_from_root,
        &local_path.to.configuration.world_from_root,
        t,
    );
    if !local_path.shape.raises_root {
        return reference;
    }
    if let Some(limb) = mode.swing() {
        reference.rotation = hip_raised(reference.rotation, limb, plateau(t));
    }
    if let Some(highest) =
        constraints.robot.root_height(&reference, world_from_soles, [UPRIGHT_LEG_EXTENSION; 2])
    {
        reference.translation.z += plateau(t) * (highest - reference.translation.z).max(0.0);
    }
    reference
}

/// The root's rotation with its hip over a swing foot raised, by a share of the whole.
fn hip_raised(world_from_root: DQuat, limb: usize, share: f64) -> DQuat {
    let ahead = rotation_about(DVec3::Z, yaw_of(world_from_root)) * DVec3::X;
    (rotation_from_scaled_axis(share * side_of(limb) * HIP_RAISE * ahead) * world_from_root)
        .normalize()
}

fn swing_pose(local_path: &LocalPath, limb: usize, t: f64) -> Pose {
    let LocalPath { from, to, shape, .. } = local_path;
    let outward =
        || outward([&from.configuration.world_from_root, &to.configuration.world_from_root], limb);
    shape.swing.pose([&from.world_from_soles[limb], &to.world_from_soles[limb]], outward, t)
}
