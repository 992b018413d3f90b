//! Single-mode planning: from one transition configuration to another within their common mode [Grey 4.4.3].
//!
//! The first search between two transitions begins with primitive trajectories [Grey 4.4.5]: straight, and with the swing foot
//! raised in a few shapes. Then the trees of both grow, and each later search grows them on.
//!
//! A search is advanced by one unit of work at a time, so that no step of the planner need wait for its end.

use glam::DVec3;
use surefoot_shared_types::Pose;

use crate::collision::FootState;
use crate::constraint::{Constraints, Mode, Rejection};
use crate::motion::track::{Follower, Progress, State, Stretch, Swing, place_at};
use crate::motion::tree::Growing;
use crate::motion::workspace::{Workspace, push};

/// What is sought within one mode.
#[derive(Debug, Clone)]
pub struct Problem {
    /// The mode.
    pub mode: Mode,
    /// Where the motion begins.
    pub from: State,
    /// Where it ends.
    pub to: State,
    /// Seed, and the name of this search in the random stream.
    pub random: (u64, u64),
    /// How often this search failed before.
    pub failures: u32,
}

/// How high a swing foot is lifted off its placement before it may travel, along the sole's normal, m; tried in order.
const LIFTS: [f64; 2] = [0.02, 0.012];
/// The shapes of a swing, in the order in which they are tried.
const SWINGS: [Swing; 7] =
    [Swing::Hump(0.02), Swing::Hump(0.06), Swing::Over(0.02), Swing::Hump(0.14), Swing::Over(0.08), Swing::Over(0.2), Swing::Hump(0.3)];
/// With both feet on the ground only the root travels.
const SHIFTS: [Swing; 1] = [Swing::Straight];

/// A search within one mode.
#[derive(Debug, Clone)]
pub struct Search {
    problem: Problem,
    /// The ends of the travel: those of the problem, the swing foot lifted.
    ends: [State; 2],
    stage: Stage,
    follower: Option<Follower>,
}

#[derive(Debug, Clone)]
enum Stage {
    /// Finding how the swing foot leaves its placement at an end of the motion.
    Lift { end: usize, lift: usize },
    /// Trying a shape of the swing.
    Travel { shape: usize },
    /// Growing the trees.
    Grow(Growing),
}

impl Search {
    /// Begins, with empty memory but for the trees.
    pub fn new(problem: Problem) -> Self {
        let ends = [problem.from, problem.to];
        let stage = if problem.mode.swing().is_some() { Stage::Lift { end: 0, lift: 0 } } else { travel(&problem) };
        Self { problem, ends, stage, follower: None }
    }

    /// Spends one unit of work. At the end answers whether the motion was found: then `workspace.track` holds the waypoints
    /// after its first state, the last one included.
    pub fn advance(&mut self, constraints: &Constraints, workspace: &mut Workspace) -> Option<Result<(), Rejection>> {
        let ended = match &mut self.stage {
            &mut Stage::Lift { end, lift } => self.lift(constraints, end, lift, workspace),
            &mut Stage::Travel { shape } => self.travel(constraints, shape, workspace),
            Stage::Grow(growing) => growing.advance(constraints, &self.problem, &self.ends, &mut self.follower, workspace),
        };
        match ended {
            Ok(false) => None,
            Ok(true) => Some(self.complete(workspace)),
            Err(rejection) => Some(Err(rejection)),
        }
    }

    /// How often it tried to extend a tree; at least once, since a primitive trajectory that fails is an attempt too.
    pub fn extensions(&self) -> u32 {
        match &self.stage {
            Stage::Grow(growing) => growing.extensions().max(1),
            Stage::Lift { .. } | Stage::Travel { .. } => 1,
        }
    }

    fn lift(&mut self, constraints: &Constraints, end: usize, lift: usize, workspace: &mut Workspace) -> Result<bool, Rejection> {
        let Some(follower) = &mut self.follower else {
            workspace.lifts[end].clear();
            let begun = self.begin_lift(constraints, end, LIFTS[lift]);
            return begun.map(|()| false).or_else(|why| self.next_lift(end, lift, why, workspace));
        };
        let advanced = follower.advance(constraints, &self.problem.mode);
        let mut pushed = |progress: Progress| match progress {
            Progress::Nearer => Ok(()),
            Progress::Waypoint | Progress::Arrived => push(&mut workspace.lifts[end], follower.here().configuration),
        };
        match advanced.and_then(|progress| pushed(progress).map(|()| progress)) {
            Ok(Progress::Arrived) => {
                self.follower = None;
                self.stage = if end == 0 { Stage::Lift { end: 1, lift: 0 } } else { travel(&self.problem) };
                Ok(false)
            }
            Ok(_) => Ok(false),
            Err(why) => self.next_lift(end, lift, why, workspace),
        }
    }

    fn begin_lift(&mut self, constraints: &Constraints, end: usize, lift: f64) -> Result<(), Rejection> {
        let from = if end == 0 { self.problem.from } else { self.problem.to };
        let to = lifted(constraints, &self.problem.mode, &from, lift)?;
        self.ends[end] = to;
        let stretch = Stretch { from, to, exact: true, swing: Swing::Straight, swing_foot: FootState::Leaving };
        self.follower = Some(Follower::new(constraints, &stretch));
        Ok(())
    }

    fn next_lift(&mut self, end: usize, lift: usize, why: Rejection, workspace: &mut Workspace) -> Result<bool, Rejection> {
        workspace.count(why);
        self.follower = None;
        if lift + 1 == LIFTS.len() {
            return Err(why);
        }
        self.stage = Stage::Lift { end, lift: lift + 1 };
        Ok(false)
    }

    fn travel(&mut self, constraints: &Constraints, shape: usize, workspace: &mut Workspace) -> Result<bool, Rejection> {
        let shapes = shapes(&self.problem.mode);
        let Some(follower) = &mut self.follower else {
            workspace.track.clear();
            let [from, to] = self.ends;
            let stretch = Stretch { from, to, exact: true, swing: shapes[shape], swing_foot: FootState::Free };
            self.follower = Some(Follower::new(constraints, &stretch));
            return Ok(false);
        };
        let why = match follower.advance(constraints, &self.problem.mode) {
            Ok(Progress::Nearer) => return Ok(false),
            Ok(progress) => match push(&mut workspace.track, follower.here().configuration) {
                Ok(()) => return Ok(progress == Progress::Arrived),
                Err(full) => full,
            },
            Err(why) => why,
        };
        workspace.count(why);
        self.follower = None;
        if shape + 1 == shapes.len() {
            self.stage = Stage::Grow(Growing::new(&self.problem));
        } else {
            self.stage = Stage::Travel { shape: shape + 1 };
        }
        Ok(false)
    }

    /// Puts the travel between lift-off and landing. A lift leads away from the placement, so landing is one in reverse.
    fn complete(&self, workspace: &mut Workspace) -> Result<(), Rejection> {
        let Workspace { track, lifts: [off, on], .. } = workspace;
        if track.len() + off.len() + on.len() > track.capacity() {
            return Err(Rejection::Discontinuous);
        }
        track.extend_from_slice(off);
        track.rotate_right(off.len());
        if self.problem.mode.swing().is_some() {
            track.extend(on.iter().rev().skip(1));
            track.push(self.problem.to.configuration);
        }
        Ok(())
    }
}

/// Runs a search to its end; answers how many units of work it took.
///
/// # Errors
/// What stopped it last.
pub fn solve(constraints: &Constraints, problem: &Problem, workspace: &mut Workspace) -> Result<u64, Rejection> {
    workspace.clear();
    let mut search = Search::new(problem.clone());
    let mut work = 1;
    loop {
        if let Some(ended) = search.advance(constraints, workspace) {
            return ended.map(|()| work);
        }
        work += 1;
    }
}

fn travel(problem: &Problem) -> Stage {
    if problem.failures == 0 { Stage::Travel { shape: 0 } } else { Stage::Grow(Growing::new(problem)) }
}

fn shapes(mode: &Mode) -> &'static [Swing] {
    if mode.swing().is_some() { &SWINGS } else { &SHIFTS }
}

/// A state with the swing sole raised along its normal.
fn lifted(constraints: &Constraints, mode: &Mode, state: &State, lift: f64) -> Result<State, Rejection> {
    let mut raised = *state;
    if let Some(limb) = mode.swing() {
        let sole = &mut raised.world_from_soles[limb];
        *sole = Pose::from_parts(sole.translation + sole.rotation * (DVec3::Z * lift), sole.rotation);
    }
    place_at(constraints, mode, &raised)
}
