//! Shortcuts within one motion, and its local optimisation [Grey 4.4.6]. Two waypoints of a track
//! are joined straight, on the constraint manifold and checked like any motion. Where that is
//! shorter, it takes the place of what led from one to the other.
//!
//! [`Goal::Shortcuts`] joins all that may change at once, and where that fails, waypoints drawn at
//! random, as long as that brings something. [`Goal::Corners`] goes along the whole track, cuts
//! corners, and leaves out needless waypoints.

use surefoot_shared_types::spatial::rotation_distance;

use crate::body::Configuration;
use crate::collision::FootState;
use crate::constraint::{Constraints, Mode, Rejection};
use crate::motion::swing::Travel;
use crate::motion::track::{Progress, State, Stretch};
use crate::motion::tree::METRES_PER_RADIAN;
use crate::motion::workspace::{Workspace, push};
use crate::random::Random;

/// A swing foot keeps its way this near to where the motion begins and ends, m: it leaves and
/// reaches a placement along the sole's normal.
const LIFT_KEPT: f64 = 0.012;
/// A shortcut must make a stretch shorter by this share.
const GAIN_MIN: f64 = 0.05;
/// A shortcut is only tried where the straight way is shorter than this share of what it must come
/// to: a leg's joints do not move straight where its sole does.
const PROMISING_MAX: f64 = 0.9;
/// Shortcuts in a row that bring nothing before no more are tried.
const FRUITLESS_MAX: u32 = 6;
/// At a corner the way past a waypoint is longer than the way from its neighbour to the other by
/// this share.
const CORNER_MIN: f64 = 0.02;

/// The distance between two configurations: Euclidean over all joints (rad, m), the root's position
/// (m, over [`METRES_PER_RADIAN`]) and its turn (rad).
pub fn distance(a: &Configuration, b: &Configuration) -> f64 {
    let joints: f64 = a.q.iter().zip(&b.q).map(|(x, y)| (x - y) * (x - y)).sum();
    let (a, b) = (&a.world_from_root, &b.world_from_root);
    let travel = a.translation.distance(b.translation) / METRES_PER_RADIAN;
    let turn = rotation_distance(a.rotation, b.rotation);
    (joints + travel * travel + turn * turn).sqrt()
}

/// The length of a track by [`distance`].
pub fn length(track: &[Configuration]) -> f64 {
    track.windows(2).map(|pair| distance(&pair[0], &pair[1])).sum()
}

/// What a track is gone through for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Goal {
    /// Shortcuts between waypoints far from each other.
    Shortcuts,
    /// Local optimisation.
    Corners,
}

/// Makes one track shorter, a unit of work at a time. `workspace.track` holds it, its first state
/// included, and is valid at all times.
#[derive(Debug, Clone)]
pub struct Shortcutting {
    goal: Goal,
    mode: Mode,
    random: Random,
    /// Units of work that it may still spend.
    left: u64,
    /// The first and the last waypoint that may be joined.
    free: [usize; 2],
    /// Shortcuts in a row that brought nothing.
    fruitless: u32,
    stage: Stage,
}

#[derive(Debug, Clone)]
enum Stage {
    /// Finding out what may change.
    Begin,
    /// Choosing two waypoints.
    Choose(Aim),
    /// Joining them.
    Join(Joint),
    Over,
}

#[derive(Debug, Clone, Copy)]
enum Aim {
    /// Two waypoints at random.
    Shortcut,
    /// The neighbours of the next corner or needless waypoint, from this one on.
    Corner(usize),
}

/// Two waypoints on their way of being joined.
#[derive(Debug, Clone)]
struct Joint {
    aim: Aim,
    ends: [usize; 2],
    length: f64,
    length_max: f64,
}

impl Shortcutting {
    /// Begins with a track in a mode; spends at most so many units of work.
    pub fn new(goal: Goal, mode: Mode, random: Random, work_max: u64) -> Self {
        Self { goal, mode, random, left: work_max, free: [0; 2], fruitless: 0, stage: Stage::Begin }
    }

    /// Whether it has spent its work, or found all that it is likely to find.
    pub fn has_ended(&self) -> bool {
        self.left == 0 || matches!(self.stage, Stage::Over)
    }

    /// Spends one unit of work.
    pub fn advance(&mut self, constraints: &Constraints, workspace: &mut Workspace) {
        self.left = self.left.saturating_sub(1);
        let next = match &mut self.stage {
            Stage::Begin => {
                self.free = free_waypoints(constraints, &self.mode, &workspace.track);
                match self.goal {
                    Goal::Shortcuts => self.join(constraints, self.free, Aim::Shortcut, workspace),
                    Goal::Corners => Stage::Choose(Aim::Corner(0)),
                }
            }
            &mut Stage::Choose(aim) => self.choose(constraints, aim, workspace),
            Stage::Join(joint) => match joint.advance(constraints, &self.mode, workspace) {
                Ok(None) => return,
                Ok(Some(removed)) => {
                    let (aim, ends) = (joint.aim, joint.ends);
                    self.after_success(aim, ends, removed)
                }
                Err(why) => {
                    let aim = joint.aim;
                    workspace.count(why);
                    self.after_failure(aim)
                }
            },
            Stage::Over => return,
        };
        self.stage = next;
    }

    fn choose(&mut self, constraints: &Constraints, aim: Aim, workspace: &mut Workspace) -> Stage {
        let [first, last] = self.free;
        match aim {
            Aim::Shortcut => {
                let ends = draw(self.free, &mut self.random);
                self.join(constraints, ends, aim, workspace)
            }
            Aim::Corner(from) => {
                let joint_step = constraints.config.waypoint_joint_step;
                let is_corner =
                    |&at: &usize| is_corner(&workspace.track[at - 1..=at + 1], joint_step);
                let Some(at) = (from.max(first + 1)..last).find(is_corner) else {
                    return Stage::Over;
                };
                self.join(constraints, [at - 1, at + 1], Aim::Corner(at), workspace)
            }
        }
    }

    /// Begins to join two waypoints, if that can bring enough.
    fn join(
        &mut self,
        constraints: &Constraints,
        ends: [usize; 2],
        aim: Aim,
        workspace: &mut Workspace,
    ) -> Stage {
        let [from, to] = ends;
        if to < from + 2 {
            return self.after_failure(aim);
        }
        let track = &workspace.track[from..=to];
        let (length_max, promising_max) = match aim {
            Aim::Shortcut => ((1.0 - GAIN_MIN) * length(track), PROMISING_MAX),
            Aim::Corner(_) => (length(track), 1.0),
        };
        if distance(&track[0], &track[to - from]) > promising_max * length_max {
            return self.after_failure(aim);
        }
        let state = |index: usize| state_of(constraints, &self.mode, &workspace.track[index]);
        let stretch = Stretch {
            from: state(from),
            to: state(to),
            exact: true,
            travel: Travel::STRAIGHT,
            swing_foot: FootState::Free,
        };
        workspace.shortcut.clear();
        workspace.follower.begin(constraints, &stretch);
        Stage::Join(Joint { aim, ends, length: 0.0, length_max })
    }

    fn after_success(&mut self, aim: Aim, joined: [usize; 2], removed: usize) -> Stage {
        let is_all = joined == self.free;
        self.free[1] -= removed;
        self.fruitless = 0;
        match aim {
            Aim::Shortcut if is_all => Stage::Over,
            Aim::Shortcut => Stage::Choose(aim),
            Aim::Corner(at) => Stage::Choose(Aim::Corner(at + usize::from(removed == 0))),
        }
    }

    fn after_failure(&mut self, aim: Aim) -> Stage {
        self.fruitless += 1;
        match aim {
            Aim::Shortcut if self.fruitless < FRUITLESS_MAX => Stage::Choose(aim),
            Aim::Shortcut => Stage::Over,
            Aim::Corner(at) => Stage::Choose(Aim::Corner(at + 1)),
        }
    }
}

impl Joint {
    /// Goes on by one trial; answers by how many waypoints the track has become shorter, once they
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
        let before = workspace.follower.here().configuration;
        let progress = workspace.follower.advance(constraints, mode)?;
        if progress == Progress::Nearer {
            return Ok(None);
        }
        let [from, to] = self.ends;
        let here = workspace.follower.here().configuration;
        self.length += distance(&before, &here);
        let is_longer = self.length + distance(&here, &workspace.track[to]) > self.length_max;
        if is_longer || workspace.shortcut.len() == to - from {
            return Err(Rejection::Discontinuous);
        }
        push(&mut workspace.shortcut, here)?;
        Ok((progress == Progress::Arrived)
            .then(|| replace(&mut workspace.track, self.ends, &workspace.shortcut)))
    }
}

/// Puts a way in the place of what leads from one waypoint to another; it is no more waypoints.
/// Answers how many fewer.
fn replace(track: &mut Vec<Configuration>, [from, to]: [usize; 2], way: &[Configuration]) -> usize {
    let kept = from + 1 + way.len();
    track[from + 1..kept].copy_from_slice(way);
    track.drain(kept..=to);
    to + 1 - kept
}

/// The first and the last waypoint of a track whose swing foot is off the places where the motion
/// begins and ends.
fn free_waypoints(constraints: &Constraints, mode: &Mode, track: &[Configuration]) -> [usize; 2] {
    let Some(limb) = mode.swing() else { return [0, track.len() - 1] };
    let sole = |configuration: &Configuration| {
        state_of(constraints, mode, configuration).world_from_soles[limb].translation
    };
    let is_free = |end: usize| {
        let placement = sole(&track[end]);
        move |index: &usize| sole(&track[*index]).distance(placement) >= LIFT_KEPT
    };
    let first = (0..track.len()).find(is_free(0));
    let last = (0..track.len()).rev().find(is_free(track.len() - 1));
    [first.unwrap_or(0), last.filter(|_| first.is_some()).unwrap_or(0)]
}

/// A waypoint of a motion in a mode.
fn state_of(constraints: &Constraints, mode: &Mode, configuration: &Configuration) -> State {
    let mut world_from_soles = mode.world_from_soles;
    if let Some(limb) = mode.swing() {
        world_from_soles[limb] = configuration.world_from_root
            * constraints.body.legs[limb].root_from_sole(&configuration.q);
    }
    State { configuration: *configuration, world_from_soles }
}

/// Two waypoints at random, in their order.
fn draw([first, last]: [usize; 2], random: &mut Random) -> [usize; 2] {
    let count = last + 1 - first.min(last);
    let mut ends = [0, 1].map(|_| first + random.below(count));
    ends.sort_unstable();
    ends
}

/// Whether the way turns at the middle one of three waypoints, or its neighbours are within a step
/// of each other.
fn is_corner(track: &[Configuration], joint_step: f64) -> bool {
    let [a, b, c] = [&track[0], &track[1], &track[2]];
    let step = a.q.iter().zip(&c.q).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    step <= joint_step || distance(a, b) + distance(b, c) > (1.0 + CORNER_MIN) * distance(a, c)
}
