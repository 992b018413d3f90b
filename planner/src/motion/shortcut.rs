//! Path shortcutting within one motion, and its local optimisation [Grey 4.4.6].
//!
//! A shortcut joins two waypoints of a path by a straight local path, which is checked like any
//! motion. If it is shorter, it replaces the part between them. [`Pass::Shortcuts`] joins the first
//! and the last free waypoint, then random pairs until several in a row fail. [`Pass::Corners`]
//! goes along the path, cuts corners and removes unnecessary waypoints.

use surefoot_shared_types::base::spatial::rotation_distance;

use crate::base::random::Random;
use crate::collision::model::FootPhase;
use crate::constraints::constraints::Constraints;
use crate::constraints::mode::Mode;
use crate::constraints::mode_state::ModeState;
use crate::constraints::rejection::Rejection;
use crate::motion::local_planner::{LocalPath, Progress};
use crate::motion::swing_shapes::MotionShape;
use crate::motion::tuning::{
    CORNER_EXCESS_MIN, LIFT_OFF_KEPT, METRES_PER_RADIAN, SHORTCUT_FAILURES_MAX, SHORTCUT_GAIN_MIN,
    STRAIGHT_SHARE_MAX,
};
use crate::motion::workspace::{Workspace, push};
use crate::robot::configuration::Configuration;

/// The distance between two configurations, rad: Euclidean over all joints (rad, m), the root's
/// translation (m, divided by 0.35 m/rad) and its rotation (rad).
pub fn distance(a: &Configuration, b: &Configuration) -> f64 {
    let joints: f64 = a.q.iter().zip(&b.q).map(|(x, y)| (x - y) * (x - y)).sum();
    let (a, b) = (&a.world_from_root, &b.world_from_root);
    let shift = a.translation.distance(b.translation) / METRES_PER_RADIAN;
    let turn = rotation_distance(a.rotation, b.rotation);
    (joints + shift * shift + turn * turn).sqrt()
}

/// The length of a path by [`distance`].
pub fn length(path: &[Configuration]) -> f64 {
    path.windows(2).map(|pair| distance(&pair[0], &pair[1])).sum()
}

/// A pass over a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pass {
    /// Shortcuts between waypoints far from each other.
    Shortcuts,
    /// Local optimisation at corners and unnecessary waypoints.
    Corners,
}

/// Shortens one path, one work unit at a time. `workspace.path` holds the path, first state
/// included, and is valid at all times.
#[derive(Debug, Clone)]
pub struct Shortcutting {
    pass: Pass,
    mode: Mode,
    random: Random,
    /// Work units that remain.
    work_left: u64,
    /// The first and the last waypoint that may be joined.
    free: [usize; 2],
    /// Consecutive shortcuts that failed.
    failures: u32,
    phase: ShortcutPhase,
}

#[derive(Debug, Clone)]
enum ShortcutPhase {
    /// Finding the waypoints that may change.
    Begin,
    /// Choosing two waypoints.
    Choose(Selection),
    /// Joining them.
    Join(ShortcutAttempt),
    Over,
}

#[derive(Debug, Clone, Copy)]
enum Selection {
    /// Two random waypoints.
    Shortcut,
    /// The neighbours of the next corner or unnecessary waypoint, from this one on.
    Corner(usize),
}

/// A shortcut between two waypoints that is being tried.
#[derive(Debug, Clone)]
struct ShortcutAttempt {
    selection: Selection,
    ends: [usize; 2],
    /// Length of the shortcut so far.
    length: f64,
    length_max: f64,
}

impl Shortcutting {
    /// Begins a pass over a path in a mode, with at most `work_max` work units.
    pub fn new(pass: Pass, mode: Mode, random: Random, work_max: u64) -> Self {
        Self {
            pass,
            mode,
            random,
            work_left: work_max,
            free: [0; 2],
            failures: 0,
            phase: ShortcutPhase::Begin,
        }
    }

    /// Whether its work is spent or further shortcuts are unlikely.
    pub fn has_ended(&self) -> bool {
        self.work_left == 0 || matches!(self.phase, ShortcutPhase::Over)
    }

    /// Spends one work unit.
    pub fn advance(&mut self, constraints: &Constraints, workspace: &mut Workspace) {
        self.work_left = self.work_left.saturating_sub(1);
        let next = match &mut self.phase {
            ShortcutPhase::Begin => {
                self.free = free_waypoints(constraints, &self.mode, &workspace.path);
                match self.pass {
                    Pass::Shortcuts => {
                        self.join(constraints, self.free, Selection::Shortcut, workspace)
                    }
                    Pass::Corners => ShortcutPhase::Choose(Selection::Corner(0)),
                }
            }
            &mut ShortcutPhase::Choose(selection) => self.choose(constraints, selection, workspace),
            ShortcutPhase::Join(attempt) => {
                match attempt.advance(constraints, &self.mode, workspace) {
                    Ok(None) => return,
                    Ok(Some(removed)) => {
                        let (selection, ends) = (attempt.selection, attempt.ends);
                        self.after_success(selection, ends, removed)
                    }
                    Err(rejection) => {
                        let selection = attempt.selection;
                        workspace.count(rejection);
                        self.after_failure(selection)
                    }
                }
            }
            ShortcutPhase::Over => return,
        };
        self.phase = next;
    }

    /// Selects the next two waypoints and begins to join them.
    fn choose(
        &mut self,
        constraints: &Constraints,
        selection: Selection,
        workspace: &mut Workspace,
    ) -> ShortcutPhase {
        let [first, last] = self.free;
        match selection {
            Selection::Shortcut => {
                let ends = random_pair(self.free, &mut self.random);
                self.join(constraints, ends, selection, workspace)
            }
            Selection::Corner(from) => {
                let joint_step = constraints.config.waypoint_joint_step;
                let is_corner =
                    |&at: &usize| is_corner(&workspace.path[at - 1..=at + 1], joint_step);
                let Some(at) = (from.max(first + 1)..last).find(is_corner) else {
                    return ShortcutPhase::Over;
                };
                self.join(constraints, [at - 1, at + 1], Selection::Corner(at), workspace)
            }
        }
    }

    /// Begins to join two waypoints if the straight line is short enough.
    fn join(
        &mut self,
        constraints: &Constraints,
        ends: [usize; 2],
        selection: Selection,
        workspace: &mut Workspace,
    ) -> ShortcutPhase {
        let [from, to] = ends;
        if to < from + 2 {
            return self.after_failure(selection);
        }
        let path = &workspace.path[from..=to];
        let (length_max, straight_share_max) = match selection {
            Selection::Shortcut => ((1.0 - SHORTCUT_GAIN_MIN) * length(path), STRAIGHT_SHARE_MAX),
            Selection::Corner(_) => (length(path), 1.0),
        };
        if distance(&path[0], &path[to - from]) > straight_share_max * length_max {
            return self.after_failure(selection);
        }
        let state = |index: usize| state_of(constraints, &self.mode, &workspace.path[index]);
        let local_path = LocalPath {
            from: state(from),
            to: state(to),
            exact: true,
            shape: MotionShape::STRAIGHT,
            swing_foot: FootPhase::Swing,
        };
        workspace.shortcut.clear();
        workspace.local_planner.begin(constraints, &local_path);
        ShortcutPhase::Join(ShortcutAttempt { selection, ends, length: 0.0, length_max })
    }

    fn after_success(
        &mut self,
        selection: Selection,
        joined: [usize; 2],
        removed: usize,
    ) -> ShortcutPhase {
        let is_all = joined == self.free;
        self.free[1] -= removed;
        self.failures = 0;
        match selection {
            Selection::Shortcut if is_all => ShortcutPhase::Over,
            Selection::Shortcut => ShortcutPhase::Choose(selection),
            Selection::Corner(at) => {
                ShortcutPhase::Choose(Selection::Corner(at + usize::from(removed == 0)))
            }
        }
    }

    fn after_failure(&mut self, selection: Selection) -> ShortcutPhase {
        self.failures += 1;
        match selection {
            Selection::Shortcut if self.failures < SHORTCUT_FAILURES_MAX => {
                ShortcutPhase::Choose(selection)
            }
            Selection::Shortcut => ShortcutPhase::Over,
            Selection::Corner(at) => ShortcutPhase::Choose(Selection::Corner(at + 1)),
        }
    }
}

impl ShortcutAttempt {
    /// Makes one trial. Returns the number of waypoints removed once the shortcut has replaced its
    /// part of the path.
    ///
    /// # Errors
    /// The constraint that stops it; [`Rejection::Discontinuous`] if it would not be shorter.
    fn advance(
        &mut self,
        constraints: &Constraints,
        mode: &Mode,
        workspace: &mut Workspace,
    ) -> Result<Option<usize>, Rejection> {
        let before = workspace.local_planner.state().configuration;
        let progress = workspace.local_planner.advance(constraints, mode)?;
        if progress == Progress::ShorterStep {
            return Ok(None);
        }
        let [from, to] = self.ends;
        let here = workspace.local_planner.state().configuration;
        self.length += distance(&before, &here);
        let is_longer = self.length + distance(&here, &workspace.path[to]) > self.length_max;
        if is_longer || workspace.shortcut.len() == to - from {
            return Err(Rejection::Discontinuous);
        }
        push(&mut workspace.shortcut, here)?;
        Ok((progress == Progress::Reached)
            .then(|| replace(&mut workspace.path, self.ends, &workspace.shortcut)))
    }
}

/// Replaces the part of a path between two waypoints by one with at most as many waypoints. Returns
/// the number removed.
fn replace(
    path: &mut Vec<Configuration>,
    [from, to]: [usize; 2],
    replacement: &[Configuration],
) -> usize {
    let kept = from + 1 + replacement.len();
    path[from + 1..kept].copy_from_slice(replacement);
    path.drain(kept..=to);
    to + 1 - kept
}

/// The first and the last waypoint whose swing sole is farther than [`LIFT_OFF_KEPT`] from where it
/// begins and ends.
fn free_waypoints(constraints: &Constraints, mode: &Mode, path: &[Configuration]) -> [usize; 2] {
    let Some(limb) = mode.swing() else { return [0, path.len() - 1] };
    let sole = |configuration: &Configuration| {
        state_of(constraints, mode, configuration).world_from_soles[limb].translation
    };
    let is_free = |end: usize| {
        let foothold = sole(&path[end]);
        move |index: &usize| sole(&path[*index]).distance(foothold) >= LIFT_OFF_KEPT
    };
    let first = (0..path.len()).find(is_free(0));
    let last = (0..path.len()).rev().find(is_free(path.len() - 1));
    [first.unwrap_or(0), last.filter(|_| first.is_some()).unwrap_or(0)]
}

/// The state of a waypoint in a mode.
fn state_of(constraints: &Constraints, mode: &Mode, configuration: &Configuration) -> ModeState {
    let mut world_from_soles = mode.world_from_soles;
    if let Some(limb) = mode.swing() {
        world_from_soles[limb] = configuration.world_from_root
            * constraints.robot.legs[limb].root_from_sole(&configuration.q);
    }
    ModeState { configuration: *configuration, world_from_soles }
}

/// Two random waypoints of a range, in order.
fn random_pair([first, last]: [usize; 2], random: &mut Random) -> [usize; 2] {
    let count = last + 1 - first.min(last);
    let mut ends = [0, 1].map(|_| first + random.below(count));
    ends.sort_unstable();
    ends
}

/// Whether the path bends at the middle one of three waypoints, or its neighbours are within one
/// step of each other.
fn is_corner(path: &[Configuration], joint_step: f64) -> bool {
    let [a, b, c] = [&path[0], &path[1], &path[2]];
    let step = a.q.iter().zip(&c.q).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    step <= joint_step
        || distance(a, b) + distance(b, c) > (1.0 + CORNER_EXCESS_MIN) * distance(a, c)
}
