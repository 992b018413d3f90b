//! The local planner: a checked motion between two states of a mode [LaValle 2006, 5.5].
//!
//! The root, the swing sole and the free joints follow a local path. Inverse kinematics places the
//! legs, shifts of the root correct the centre of mass, and every waypoint and every motion between
//! two waypoints is checked.

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
use crate::kinematics::Leg;
use crate::motion::swing_shapes::{MotionShape, outward, plateau};
use crate::motion::tuning::{
    FIRST_STEP_LENGTH, HIP_RAISE, MOVING_LEG_EXTENSION_MAX, PATH_STEP_AIM, PATH_STEP_MIN,
    RAISED_LEG_EXTENSION, WAYPOINT_COLLISION_STEPS, WAYPOINT_COM_SHIFTS_MAX,
};
use crate::primitives::level_sole::side_of;
use crate::robot::configuration::Configuration;
use crate::robot::constrained_projection::{ProjectionTarget, project};
use crate::robot::kinematic_state::KinematicState;

/// Largest distance of the centre of mass from its reference, m.
const COM_TRACKING_TOLERANCE: f64 = 4e-3;

/// A query of the local planner: the path between two states.
#[derive(Debug, Clone, Copy)]
pub struct LocalPath {
    /// The first state.
    pub from: ModeState,
    /// The last state.
    pub to: ModeState,
    /// Whether it must end at `to` exactly. Otherwise the legs and the centre of mass may deviate.
    pub exact: bool,
    /// The shape of the motion.
    pub shape: MotionShape,
    /// The clearance that the swing foot must keep.
    pub swing_foot: FootPhase,
}

impl Default for LocalPath {
    /// From the origin to the origin: for memory that is not in use.
    fn default() -> Self {
        let [from, to] = [ModeState::default(); 2];
        Self { from, to, exact: true, shape: MotionShape::STRAIGHT, swing_foot: FootPhase::Swing }
    }
}

/// Result of one trial along a local path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// The step was too long; the next trial is a shorter one.
    ShorterStep,
    /// [`LocalPlanner::state`] is the next waypoint.
    Waypoint,
    /// [`LocalPlanner::state`] is the last waypoint.
    Reached,
}

/// Follows one local path after another, one trial at a time. A trial costs one work unit.
#[derive(Debug, Clone, Default)]
pub struct LocalPlanner {
    is_active: bool,
    local_path: LocalPath,
    /// The fraction of the local path that is done.
    at: f64,
    /// The fraction of the next step.
    step: f64,
    /// The last waypoint.
    state: ModeState,
    /// Kinematic states of the last waypoint, at index `current`, and of the trial.
    kinematic_states: [KinematicState; 2],
    current: usize,
    intermediate_kinematic_state: KinematicState,
    /// The centre of mass at both ends, world, m.
    com_ends: [DVec3; 2],
}

impl LocalPlanner {
    /// Begins a local path.
    pub fn begin(&mut self, constraints: &Constraints, local_path: &LocalPath) {
        self.current = 0;
        for (kinematic_state, end) in
            self.kinematic_states.iter_mut().zip([&local_path.from, &local_path.to])
        {
            kinematic_state.update(&constraints.robot, &end.configuration);
        }
        self.com_ends = [self.kinematic_states[0].com, self.kinematic_states[1].com];
        (self.local_path, self.state) = (*local_path, local_path.from);
        (self.at, self.step) = (0.0, initial_step(local_path));
        self.is_active = true;
    }

    /// Ends the local path.
    pub fn stop(&mut self) {
        self.is_active = false;
    }

    /// Whether a local path has begun and not been stopped.
    pub fn is_active(&self) -> bool {
        self.is_active
    }

    /// The last waypoint reached. It and the motion to it are checked.
    pub fn state(&self) -> &ModeState {
        &self.state
    }

    /// Checks the configuration at fraction `at` of the local path. Inverse kinematics starts from
    /// the point probed last, so probes must ascend from the beginning. To follow the path after
    /// probing, begin again.
    ///
    /// # Errors
    /// The constraint that the configuration violates.
    pub fn probe(
        &mut self,
        constraints: &Constraints,
        mode: &Mode,
        at: f64,
    ) -> Result<(), Rejection> {
        let feet = foot_phases(mode, self.local_path.swing_foot);
        let next_kinematic_state = &mut self.kinematic_states[1 - self.current];
        let path =
            PathInMode { constraints, mode, path: &self.local_path, com_ends: self.com_ends };
        self.state = path.state_at(at, &self.state, next_kinematic_state)?;
        constraints.check(mode, next_kinematic_state, feet)
    }

    /// Tries the next waypoint.
    ///
    /// # Errors
    /// The constraint that stops the path. The waypoints before stay valid.
    pub fn advance(
        &mut self,
        constraints: &Constraints,
        mode: &Mode,
    ) -> Result<Progress, Rejection> {
        let feet = foot_phases(mode, self.local_path.swing_foot);
        let next_at = (self.at + self.step).min(1.0);
        let trial = 1 - self.current;
        let path =
            PathInMode { constraints, mode, path: &self.local_path, com_ends: self.com_ends };
        let next = path.state_at(next_at, &self.state, &mut self.kinematic_states[trial]);
        let (used, bound) =
            next.as_ref().map_or((2.0, f64::INFINITY), |state| self.step_usage(constraints, state));
        self.step *= (PATH_STEP_AIM / used.max(1e-3)).clamp(0.25, 2.0);
        let state = match next {
            Ok(state) if used <= 1.0 => state,
            _ if self.step >= PATH_STEP_MIN => return Ok(Progress::ShorterStep),
            next => return Err(next.err().unwrap_or(Rejection::Discontinuous)),
        };
        constraints.check(mode, &self.kinematic_states[trial], feet)?;
        let ends = [&self.state.configuration, &state.configuration];
        constraints.check_between(
            mode,
            ends,
            bound,
            feet,
            &mut self.intermediate_kinematic_state,
        )?;
        (self.state, self.at, self.current) = (state, next_at, trial);
        self.step = self.step.min(1.0 - self.at).max(PATH_STEP_MIN);
        Ok(if self.at < 1.0 { Progress::Waypoint } else { Progress::Reached })
    }

    /// The share of the longest step that the step to `next` uses, and the motion bound of the
    /// step, m.
    fn step_usage(&self, constraints: &Constraints, next: &ModeState) -> (f64, f64) {
        let joints = self.state.configuration.q.iter().zip(&next.configuration.q);
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

/// The phase of each foot in a mode.
fn foot_phases(mode: &Mode, swing_foot: FootPhase) -> [FootPhase; 2] {
    [0, 1].map(|limb| if mode.is_stance(limb) { FootPhase::Stance } else { swing_foot })
}

/// The fraction of the first step, from the displacements of root and soles.
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
    (FIRST_STEP_LENGTH / length.max(1e-6)).clamp(PATH_STEP_MIN, 1.0)
}

/// The nearest state whose legs reach its soles and whose centre of mass lies inside the support
/// region of the mode.
///
/// # Errors
/// [`Rejection::Unreachable`] if the legs do not reach; [`Rejection::Balance`] if the shifts of the
/// root do not converge.
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
    let path = PathInMode { constraints, mode, path: &local_path, com_ends: [DVec3::ZERO; 2] };
    path.state_at(1.0, desired, &mut KinematicState::default())
}

/// A local path in a mode.
struct PathInMode<'a> {
    constraints: &'a Constraints,
    mode: &'a Mode,
    path: &'a LocalPath,
    /// The centres of mass at both ends, world, m.
    com_ends: [DVec3; 2],
}

impl PathInMode<'_> {
    /// The state at fraction `t` of the path, and its kinematic state. Inverse kinematics starts
    /// from the state `previous`. At the end of an exact path it is the last state itself.
    fn state_at(
        &self,
        t: f64,
        previous: &ModeState,
        kinematic_state: &mut KinematicState,
    ) -> Result<ModeState, Rejection> {
        let robot = &self.constraints.robot;
        if t >= 1.0 && self.path.exact {
            kinematic_state.update(robot, &self.path.to.configuration);
            return Ok(self.path.to);
        }
        let mut state = *previous;
        for limb in (0..2).filter(|&limb| !self.mode.is_stance(limb)) {
            state.world_from_soles[limb] = swing_pose(self.path, limb, t);
        }
        let (from, to) = (&self.path.from.configuration, &self.path.to.configuration);
        let reference = self.root_reference(t, &state.world_from_soles);
        for joint in &robot.free_joints {
            state.configuration.q[joint.index] =
                from.q[joint.index] + t * (to.q[joint.index] - from.q[joint.index]);
        }
        state.configuration.world_from_root = reference;
        if robot.is_projected_at(reference.rotation) {
            state.configuration = self.projected(t, &state, kinematic_state)?;
        } else {
            self.place_legs(t, &mut state, kinematic_state)?;
        }
        Ok(state)
    }

    /// Places the legs of a state on its soles, and shifts its root until the centre of mass is
    /// where the path leads it, or inside the support region.
    ///
    /// # Errors
    /// [`Rejection::Unreachable`] if the legs do not reach; [`Rejection::Balance`] if the shifts do
    /// not converge.
    fn place_legs(
        &self,
        t: f64,
        state: &mut ModeState,
        kinematic_state: &mut KinematicState,
    ) -> Result<(), Rejection> {
        let robot = &self.constraints.robot;
        let reference_height = state.configuration.world_from_root.translation.z;
        let reference_com = self.com_ends[0].lerp(self.com_ends[1], t).truncate();
        let com_depth = self.constraints.com_margin(self.mode) + COM_TRACKING_TOLERANCE;
        for _ in 0..WAYPOINT_COM_SHIFTS_MAX {
            let root = &mut state.configuration.world_from_root;
            let highest = robot
                .root_height(root, &state.world_from_soles, [MOVING_LEG_EXTENSION_MAX; 2])
                .ok_or(Rejection::Unreachable)?;
            root.translation.z = reference_height.min(highest);
            if !robot.place_soles_near(&mut state.configuration, &state.world_from_soles) {
                return Err(Rejection::Unreachable);
            }
            kinematic_state.update(robot, &state.configuration);
            let com = kinematic_state.com.truncate();
            let error = if self.path.exact {
                reference_com - com
            } else {
                self.mode.region.nearest_inside(com, com_depth) - com
            };
            if error.length() <= COM_TRACKING_TOLERANCE {
                return Ok(());
            }
            state.configuration.world_from_root.translation += error.extend(0.0);
        }
        Err(Rejection::Balance)
    }

    /// The projection of a state, whose legs need not reach its soles yet, at fraction `t`. On an
    /// exact path it begins with the legs' joints between those of both ends, which are within
    /// their limits and change as the path does.
    ///
    /// # Errors
    /// [`Rejection::Unreachable`] if the projection does not converge.
    fn projected(
        &self,
        t: f64,
        state: &ModeState,
        kinematic_state: &mut KinematicState,
    ) -> Result<Configuration, Rejection> {
        let robot = &self.constraints.robot;
        let mut begin = state.configuration;
        if self.path.exact {
            let [from, to] = [&self.path.from, &self.path.to].map(|end| &end.configuration.q);
            for joint in robot.legs.iter().flat_map(Leg::joints) {
                begin.q[joint.index] =
                    from[joint.index] + t * (to[joint.index] - from[joint.index]);
            }
        }
        let target = ProjectionTarget {
            world_from_soles: &state.world_from_soles,
            region: &self.mode.region,
            com_margin: self.constraints.com_margin(self.mode),
        };
        project(robot, &target, &begin, kinematic_state).ok_or(Rejection::Unreachable)
    }

    /// The root pose at fraction `t` before the centre of mass is corrected.
    fn root_reference(&self, t: f64, world_from_soles: &[Pose; 2]) -> Pose {
        let LocalPath { from, to, shape, .. } = self.path;
        let ends = [from, to].map(|end| &end.configuration.world_from_root);
        let mut reference = interpolate(ends[0], ends[1], t);
        if !shape.raises_root {
            return reference;
        }
        if let Some(limb) = self.mode.swing() {
            reference.rotation = hip_raised(reference.rotation, limb, plateau(t));
        }
        let highest = self.constraints.robot.root_height(
            &reference,
            world_from_soles,
            [RAISED_LEG_EXTENSION; 2],
        );
        if let Some(highest) = highest {
            reference.translation.z += plateau(t) * (highest - reference.translation.z).max(0.0);
        }
        reference
    }
}

/// The root's rotation with the hip of the swing leg raised by a share of [`HIP_RAISE`].
fn hip_raised(world_from_root: DQuat, limb: usize, share: f64) -> DQuat {
    let forward = rotation_about(DVec3::Z, yaw_of(world_from_root)) * DVec3::X;
    (rotation_from_scaled_axis(share * side_of(limb) * HIP_RAISE * forward) * world_from_root)
        .normalize()
}

/// The swing sole at fraction `t` of a local path, in the world.
fn swing_pose(local_path: &LocalPath, limb: usize, t: f64) -> Pose {
    let LocalPath { from, to, shape, .. } = local_path;
    let outward =
        || outward([&from.configuration.world_from_root, &to.configuration.world_from_root], limb);
    shape.swing.pose([&from.world_from_soles[limb], &to.world_from_soles[limb]], outward, t)
}
