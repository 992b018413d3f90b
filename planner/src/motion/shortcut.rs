//! Shortcuts within one motion, and its local optimisation [Grey 4.4.6]. Two waypoints of a path
//! are joined straight, on the constraint manifold and checked like any motion. Where that is
//! shorter, it takes the place of what led from one to the other.
//!
//! [`Pass::Shortcuts`] joins all that may change at once, and where that fails, waypoints drawn at
//! random, as long as that brings something. [`Pass::Corners`] goes along the whole path, cuts
//! corners, and leaves out needless waypoints.

use surefoot_shared_types::base::spatial::rotation_distance;

use crate::base::random::Random;
use crate::collision::model::FootPhase;
use crate::constraints::constraints::Constraints;
use crate::constraints::mode::Mode;
use crate::constraints::mode_state::ModeState;
use crate::constraints::rejection::Rejection;
use crate::motion::cbirrt::METRES_PER_RADIAN;
use crate::motion::local_planner::{LocalPath, Progress};
use crate::motion::swing_shapes::MotionShape;
use crate::motion::workspace::{Workspace, push};
use crate::robot::configuration::Configuration;

/// A swing foot keeps its way this near to where the motion begins and ends, m: it leaves and
/// reaches a placement along the sole's normal.
const LIFT_OFF_KEPT: f64 = 0.012;
/// A shortcut must make a local path shorter by this share.
const GAIN_MIN: f64 = 0.05;
/// A shortcut is only tried where the straight way is shorter than this share of what it must come
/// to: a leg's joints do not move straight where its sole does.
const STRAIGHT_SHARE_MAX: f64 = 0.9;
/// Shortcuts in a row that bring nothing before no more are tried.
const FAILURES_MAX: u32 = 6;
/// At a corner the way past a waypoint is longer than the way from its neighbour to the other by
/// this share.
const CORNER_MIN: f64 = 0.02;

/// The distance between two configurations: Euclidean over all joints (rad, m), the root's position
/// (m, over [`METRES_PER_RADIAN`]) and its turn (rad).
pub fn distance(a: &Configuration, b: &Configuration) -> f64 {
    let joints: f64 = a.q.iter().zip(&b.q).map(|(x, y)| (x - y) * (x - y)).sum();
    let (a, b) = (&a.world_from_root, &b.world_from_root);
    let shape = a.translation.distance(b.translation) / METRES_PER_RADIAN;
    let turn = rotation_distance(a.rotation, b.rotation);
    (joints + shape * shape + turn * turn).sqrt()
}

/// The length of a path by [`distance`].
pub fn length(path: &[Configuration]) -> f64 {
    path.windows(2).map(|pair| distance(&pair[0], &pair[1])).sum()
}

/// What a path is gone through for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pass {
    /// Shortcuts between waypoints far from each other.
    Shortcuts,
    /// Local optimisation.
    Corners,
}

/// Makes one path shorter, a unit of work at a time. `workspace.path` holds it, its first state
/// included, and is valid at all times.
#[derive(Debug, Clone)]
pub struct Shortcutting {
    pass: Pass,
    mode: Mode,
    random: Random,
    /// Units of work that it may still spend.
    left: u64,
    /// The first and the last waypoint that may be joined.
    free: [usize; 2],
    /// Shortcuts in a row that brought nothing.
    failures: u32,
    phase: ShortcutPhase,
}

#[derive(Debug, Clone)]
enum ShortcutPhase {
    /// Finding out what may change.
    Begin,
    /// Choosing two waypoints.
    Choose(Selection),
    /// Joining them.
    Join(ShortcutAttempt),
    Over,
}

#[derive(Debug, Clone, Copy)]
enum Selection {
    /// Two waypoints at random.
    Shortcut,
    /// The neighbours of the next corner or needless waypoint, from this one on.
    Corner(usize),
}

/// Two waypoints on their way of being joined.
#[derive(Debug, Clone)]
struct ShortcutAttempt {
    selection: Selection,
    ends: [usize; 2],
    length: f64,
    length_max: f64,
}

impl Shortcutting {
    /// Begins with a path in a mode; spends at most so many units of work.
    pub fn new(pass: Pass, mode: Mode, random: Random, work_max: u64) -> Self {
        Self {
            pass,
            mode,
            random,
            left: work_max,
            free: [0; 2],
            failures: 0,
            phase: ShortcutPhase::Begin,
        }
    }

    /// Whether it has spent its work, or found all that it is likely to find.
    pub fn has_ended(&self) -> bool {
        self.left == 0 || matches!(self.phase, ShortcutPhase::Over)
    }

    /// Spends one unit of work.
    pub fn advance(&mut self, constraints: &Constraints, workspace: &mut Workspace) {
        self.left = self.left.saturating_sub(1);
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

    /// Begins to join two waypoints, if that can bring enough.
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
            Selection::Shortcut => ((1.0 - GAIN_MIN) * length(path), STRAIGHT_SHARE_MAX),
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
            Selection::Shortcut if self.failures < FAILURES_MAX => ShortcutPhase::Choose(selection),
            Selection::Shortcut => ShortcutPhase::Over,
            Selection::Corner(at) => ShortcutPhase::Choose(Selection::Corner(at + 1)),
        }
    }
}

impl ShortcutAttempt {
    /// Goes on by one trial; answers by how many waypoints the path has become shorter, once they
    /// are joined.
    ///
    /// # Errors
    /// What stops it: [`Rejection::Discontinuous`] where it would be no shorter.
    fn advance(
        &mut self,
        constraints: &Constraints,
        mode: &Mode,
        workspace: &mut Workspace,
    ) -> Result<Option<usize>, Rejection> {
        let before = workspace.local_planner.here().configuration;
        let progress = workspace.local_planner.advance(constraints, mode)?;
        if progress == Progress::ShorterStep {
            return Ok(None);
        }
        let [from, to] = self.ends;
        let here = workspace.local_planner.here().configuration;
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

/// Puts a way in the place of what leads from one waypoint to another; it is no more waypoints.
/// Answers how many fewer.
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

/// The first and the last waypoint of a path whose swing foot is off the places where the motion
/// begins and ends.
fn free_waypoints(constraints: &Constraints, mode: &Mode, path: &[Configuration]) -> [usize; 2] {
    let Some(limb) = mode.swing() else { return [0, path.len() - 1] };
    let sole = |configuration: &Configuration| {
        state_of(constraints, mode, configuration).world_from_soles[limb].translation
    };
    let is_free = |end: usize| {
        let placement = sole(&path[end]);
        move |index: &usize| sole(&path[*index]).distance(placement) >= LIFT_OFF_KEPT
    };
    let first = (0..path.len()).find(is_free(0));
    let last = (0..path.len()).rev().find(is_free(path.len() - 1));
    [first.unwrap_or(0), last.filter(|_| first.is_some()).unwrap_or(0)]
}

/// A waypoint of a motion in a mode.
fn state_of(constraints: &Constraints, mode: &Mode, configuration: &Configuration) -> ModeState {
    let mut world_from_soles = mode.world_from_soles;
    if let Some(limb) = mode.swing() {
        world_from_soles[limb] = configuration.world_from_root
            * constraints.robot.legs[limb].root_from_sole(&configuration.q);
    }
    ModeState { configuration: *configuration, world_from_soles }
}

/// Two waypoints at random, in their order.
fn random_pair([first, last]: [usize; 2], random: &mut Random) -> [usize; 2] {
    let count = last + 1 - first.min(last);
    let mut ends = [0, 1].map(|_| first + random.below(count));
    ends.sort_unstable();
    ends
}

/// Whether the way turns at the middle one of three waypoints, or its neighbours are within a step
/// of each other.
fn is_corner(path: &[Configuration], joint_step: f64) -> bool {
    let [a, b, c] = [&path[0], &path[1], &path[2]];
    let step = a.q.iter().zip(&c.q).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    step <= joint_step || distance(a, b) + distance(b, c) > (1.0 + CORNER_MIN) * distance(a, c)
}
