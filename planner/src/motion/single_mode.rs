//! Single-mode planning: from one transition configuration to another within their common mode
//! [Grey 4.4.3].
//!
//! The first search between two transitions begins with primitive trajectories [Grey 4.4.5]: the
//! shapes of `swing`. Then the trees of both grow, and each later search grows them on.
//!
//! A search is advanced by one unit of work at a time, so that no step of the planner need wait for
//! its end.

use crate::collision::FootState;
use crate::constraint::{Constraints, Mode, Rejection};
use crate::motion::lift::Lift;
use crate::motion::swing::{SHIFTS, SWINGS, Travel};
use crate::motion::track::{Follower, Progress, State, Stretch};
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

/// Where a shape of travel is probed before it is followed: at so many places, each the same share
/// of the way after the one before. One that does not hold at one of them costs little then. The
/// first shape is the likeliest, and only followed.
const PROBES: u32 = 7;

/// A search within one mode.
#[derive(Debug, Clone)]
pub struct Search {
    problem: Problem,
    /// The ends of the travel: those of the problem, the swing foot lifted.
    ends: [State; 2],
    is_lifted: [bool; 2],
    stage: Stage,
}

#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant, reason = "a box would allocate during the search")]
enum Stage {
    /// Finding how the swing foot leaves its placement at an end of the motion.
    Lift { end: usize, lift: Lift },
    /// Trying a shape of travel, so many of whose probes hold.
    Travel { shape: usize, probed: u32 },
    /// Growing the trees.
    Grow(Growing),
}

impl Search {
    /// Begins, with empty memory but for the trees, and for the lifts where the lifted ends are
    /// known.
    pub fn new(problem: Problem, lifted: [Option<State>; 2]) -> Self {
        let ends = [lifted[0].unwrap_or(problem.from), lifted[1].unwrap_or(problem.to)];
        let is_lifted = lifted.map(|known| known.is_some() || problem.mode.swing().is_none());
        let stage = stage_after(&problem, is_lifted);
        Self { problem, ends, is_lifted, stage }
    }

    /// Spends one unit of work. At the end answers whether the motion was found: then
    /// `workspace.track` holds the waypoints after its first state, the last one included.
    pub fn advance(
        &mut self,
        constraints: &Constraints,
        workspace: &mut Workspace,
    ) -> Option<Result<(), Rejection>> {
        match self.advance_stage(constraints, workspace) {
            Ok(false) => None,
            Ok(true) => Some(self.complete(workspace)),
            Err(rejection) => {
                workspace.count(rejection);
                Some(Err(rejection))
            }
        }
    }

    /// How often it tried to extend a tree; at least once, since a primitive trajectory that fails
    /// is an attempt too.
    pub fn extensions(&self) -> u32 {
        match &self.stage {
            Stage::Grow(growing) => growing.extensions().max(1),
            Stage::Lift { .. } | Stage::Travel { .. } => 1,
        }
    }

    fn advance_stage(
        &mut self,
        constraints: &Constraints,
        workspace: &mut Workspace,
    ) -> Result<bool, Rejection> {
        match &mut self.stage {
            &mut Stage::Travel { shape, probed } => {
                Ok(self.travel(constraints, shape, probed, workspace))
            }
            Stage::Grow(growing) => {
                growing.advance(constraints, &self.problem, &self.ends, workspace)
            }
            Stage::Lift { end, lift } => {
                let (end, Workspace { follower, lifts, .. }) = (*end, workspace);
                if let Some(lifted) =
                    lift.advance(constraints, &self.problem.mode, follower, &mut lifts[end])?
                {
                    self.ends[end] = lifted;
                    self.is_lifted[end] = true;
                    self.stage = stage_after(&self.problem, self.is_lifted);
                }
                Ok(false)
            }
        }
    }

    /// Probes a shape, then follows it; answers whether it led to the end.
    fn travel(
        &mut self,
        constraints: &Constraints,
        shape: usize,
        probed: u32,
        workspace: &mut Workspace,
    ) -> bool {
        let shapes = shapes(&self.problem.mode);
        if !workspace.follower.is_under_way() {
            workspace.track.clear();
            let [from, to] = self.ends;
            let stretch = Stretch {
                from,
                to,
                exact: true,
                travel: shapes[shape],
                swing_foot: FootState::Free,
            };
            workspace.follower.begin(constraints, &stretch);
            return false;
        }
        let tried = if probed < PROBES {
            probe(constraints, &self.problem.mode, &mut workspace.follower, probed)
        } else {
            follow(constraints, &self.problem.mode, workspace)
        };
        match tried {
            Ok(Tried::Arrived) => return true,
            Ok(Tried::Going) => return false,
            Ok(Tried::Holds) => {
                self.stage = Stage::Travel { shape, probed: probed + 1 };
                if probed + 1 == PROBES {
                    workspace.follower.stop();
                }
                return false;
            }
            Err(why) => workspace.count(why),
        }
        workspace.follower.stop();
        let next = shape + 1;
        self.stage = if next < shapes.len() {
            Stage::Travel { shape: next, probed: 0 }
        } else {
            Stage::Grow(Growing::new(&self.problem))
        };
        false
    }

    /// Puts the travel between lift-off and landing. A lift leads away from the placement, so
    /// landing is one in reverse.
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
pub fn solve(
    constraints: &Constraints,
    problem: &Problem,
    workspace: &mut Workspace,
) -> Result<u64, Rejection> {
    workspace.clear();
    let mut search = Search::new(problem.clone(), [None; 2]);
    let mut work = 1;
    loop {
        if let Some(ended) = search.advance(constraints, workspace) {
            return ended.map(|()| work);
        }
        work += 1;
    }
}

/// What is to be done next: lifting the ends comes first.
fn stage_after(problem: &Problem, is_lifted: [bool; 2]) -> Stage {
    match is_lifted {
        [false, _] => Stage::Lift { end: 0, lift: Lift::new(&problem.from) },
        [true, false] => Stage::Lift { end: 1, lift: Lift::new(&problem.to) },
        [true, true] if problem.failures == 0 => Stage::Travel { shape: 0, probed: PROBES },
        [true, true] => Stage::Grow(Growing::new(problem)),
    }
}

fn shapes(mode: &Mode) -> &'static [Travel] {
    if mode.swing().is_some() { &SWINGS } else { &SHIFTS }
}

/// What came of a trial of a shape.
enum Tried {
    /// It holds where it was probed.
    Holds,
    /// It is being followed.
    Going,
    /// It led to the end.
    Arrived,
}

fn probe(
    constraints: &Constraints,
    mode: &Mode,
    follower: &mut Follower,
    probed: u32,
) -> Result<Tried, Rejection> {
    let at = f64::from(probed + 1) / f64::from(PROBES + 1);
    follower.probe(constraints, mode, at).map(|()| Tried::Holds)
}

fn follow(
    constraints: &Constraints,
    mode: &Mode,
    workspace: &mut Workspace,
) -> Result<Tried, Rejection> {
    let progress = workspace.follower.advance(constraints, mode)?;
    if progress != Progress::Nearer {
        push(&mut workspace.track, workspace.follower.here().configuration)?;
    }
    Ok(if progress == Progress::Arrived { Tried::Arrived } else { Tried::Going })
}
