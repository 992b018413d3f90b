//! Single-mode planning: from one transition configuration to another within their common mode
//! [Grey 4.4.3].
//!
//! The first search between two transitions begins with the parametrised trajectories of
//! `swing_shapes` [Grey 4.4.5], then runs CBiRRT. Each later search continues with the same trees.
//! A search advances one work unit at a time.

use crate::collision::model::FootPhase;
use crate::constraints::constraints::Constraints;
use crate::constraints::mode::Mode;
use crate::constraints::mode_state::ModeState;
use crate::constraints::rejection::Rejection;
use crate::motion::cbirrt::{Cbirrt, SingleModeProblem};
use crate::motion::lift_off::LiftOff;
use crate::motion::local_planner::{LocalPath, LocalPlanner, Progress};
use crate::motion::swing_shapes::{MotionShape, SHIFTS, SWINGS};
use crate::motion::tuning::PROBES;
use crate::motion::workspace::{Workspace, push};

/// A search within one mode.
#[derive(Debug, Clone)]
pub struct SingleModeSearch {
    problem: SingleModeProblem,
    /// The ends of the motion with the swing foot lifted.
    ends: [ModeState; 2],
    is_lifted: [bool; 2],
    phase: SearchPhase,
}

#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant, reason = "a box would allocate during the search")]
enum SearchPhase {
    /// Searching the lift-off at one end of the motion.
    LiftOff { end: usize, lift_off: LiftOff },
    /// Trying a swing shape; `probed` of its probes are valid.
    Shape { shape: usize, probed: u32 },
    /// Running CBiRRT.
    Grow(Cbirrt),
}

impl SingleModeSearch {
    /// A search in a workspace that is empty except for the trees, and for the lift-off paths of
    /// lifted ends that are known.
    pub fn new(problem: SingleModeProblem, lifted: [Option<ModeState>; 2]) -> Self {
        let ends = [lifted[0].unwrap_or(problem.from), lifted[1].unwrap_or(problem.to)];
        let is_lifted = lifted.map(|known| known.is_some() || problem.mode.swing().is_none());
        let phase = phase_after(&problem, is_lifted);
        Self { problem, ends, is_lifted, phase }
    }

    /// Spends one work unit. Returns the result once the search has ended: `Ok` if the motion was
    /// found, whose waypoints after the first state `workspace.path` then holds; else the last
    /// rejection.
    pub fn advance(
        &mut self,
        constraints: &Constraints,
        workspace: &mut Workspace,
    ) -> Option<Result<(), Rejection>> {
        match self.advance_phase(constraints, workspace) {
            Ok(false) => None,
            Ok(true) => Some(self.complete(workspace)),
            Err(rejection) => {
                workspace.count(rejection);
                Some(Err(rejection))
            }
        }
    }

    /// Number of tree extensions; at least 1, because a swing shape that fails counts as an
    /// attempt.
    pub fn extensions(&self) -> u32 {
        match &self.phase {
            SearchPhase::Grow(cbirrt) => cbirrt.extensions().max(1),
            SearchPhase::LiftOff { .. } | SearchPhase::Shape { .. } => 1,
        }
    }

    /// Spends one work unit of the current phase. Returns whether the path is found.
    fn advance_phase(
        &mut self,
        constraints: &Constraints,
        workspace: &mut Workspace,
    ) -> Result<bool, Rejection> {
        match &mut self.phase {
            &mut SearchPhase::Shape { shape, probed } => {
                Ok(self.try_shape(constraints, shape, probed, workspace))
            }
            SearchPhase::Grow(cbirrt) => {
                cbirrt.advance(constraints, &self.problem, &self.ends, workspace)
            }
            SearchPhase::LiftOff { end, lift_off } => {
                let (end, Workspace { local_planner, lift_offs, .. }) = (*end, workspace);
                if let Some(lifted) = lift_off.advance(
                    constraints,
                    &self.problem.mode,
                    local_planner,
                    &mut lift_offs[end],
                )? {
                    self.ends[end] = lifted;
                    self.is_lifted[end] = true;
                    self.phase = phase_after(&self.problem, self.is_lifted);
                }
                Ok(false)
            }
        }
    }

    /// Probes a shape, then follows it. Returns whether the end is reached.
    fn try_shape(
        &mut self,
        constraints: &Constraints,
        shape: usize,
        probed: u32,
        workspace: &mut Workspace,
    ) -> bool {
        let shapes = shapes(&self.problem.mode);
        if !workspace.local_planner.is_active() {
            workspace.path.clear();
            let [from, to] = self.ends;
            let local_path = LocalPath {
                from,
                to,
                exact: true,
                shape: shapes[shape],
                swing_foot: FootPhase::Swing,
            };
            workspace.local_planner.begin(constraints, &local_path);
            return false;
        }
        let trial = if probed < PROBES {
            probe(constraints, &self.problem.mode, &mut workspace.local_planner, probed)
        } else {
            follow(constraints, &self.problem.mode, workspace)
        };
        match trial {
            Ok(Trial::Reached) => return true,
            Ok(Trial::Unfinished) => return false,
            Ok(Trial::Valid) => {
                self.phase = SearchPhase::Shape { shape, probed: probed + 1 };
                if probed + 1 == PROBES {
                    workspace.local_planner.stop();
                }
                return false;
            }
            Err(rejection) => workspace.count(rejection),
        }
        workspace.local_planner.stop();
        let next = shape + 1;
        self.phase = if next < shapes.len() {
            SearchPhase::Shape { shape: next, probed: 0 }
        } else {
            SearchPhase::Grow(Cbirrt::new(&self.problem))
        };
        false
    }

    /// Adds lift-off and landing to the path. The landing is the lift-off of the last state in
    /// reverse.
    fn complete(&self, workspace: &mut Workspace) -> Result<(), Rejection> {
        let Workspace { path, lift_offs: [off, on], .. } = workspace;
        if path.len() + off.len() + on.len() > path.capacity() {
            return Err(Rejection::Discontinuous);
        }
        path.extend_from_slice(off);
        path.rotate_right(off.len());
        if self.problem.mode.swing().is_some() {
            path.extend(on.iter().rev().skip(1));
            path.push(self.problem.to.configuration);
        }
        Ok(())
    }
}

/// Runs a search to its end. Returns the work units spent.
///
/// # Errors
/// The last rejection, if no motion is found.
pub fn solve(
    constraints: &Constraints,
    problem: &SingleModeProblem,
    workspace: &mut Workspace,
) -> Result<u64, Rejection> {
    workspace.clear();
    let mut search = SingleModeSearch::new(problem.clone(), [None; 2]);
    let mut work = 1;
    loop {
        if let Some(ended) = search.advance(constraints, workspace) {
            return ended.map(|()| work);
        }
        work += 1;
    }
}

/// The next phase. The lift-offs come first.
fn phase_after(problem: &SingleModeProblem, is_lifted: [bool; 2]) -> SearchPhase {
    match is_lifted {
        [false, _] => SearchPhase::LiftOff { end: 0, lift_off: LiftOff::new(&problem.from) },
        [true, false] => SearchPhase::LiftOff { end: 1, lift_off: LiftOff::new(&problem.to) },
        [true, true] if problem.failures == 0 => SearchPhase::Shape { shape: 0, probed: PROBES },
        [true, true] => SearchPhase::Grow(Cbirrt::new(problem)),
    }
}

/// The motion shapes of a mode.
fn shapes(mode: &Mode) -> &'static [MotionShape] {
    if mode.swing().is_some() { &SWINGS } else { &SHIFTS }
}

/// Result of one trial of a shape.
enum Trial {
    /// The probe is valid.
    Valid,
    /// The end is not reached yet.
    Unfinished,
    /// The end is reached.
    Reached,
}

/// Probes a shape at the next of its evenly spaced points.
fn probe(
    constraints: &Constraints,
    mode: &Mode,
    local_planner: &mut LocalPlanner,
    probed: u32,
) -> Result<Trial, Rejection> {
    let at = f64::from(probed + 1) / f64::from(PROBES + 1);
    local_planner.probe(constraints, mode, at).map(|()| Trial::Valid)
}

/// Makes one trial along a shape.
fn follow(
    constraints: &Constraints,
    mode: &Mode,
    workspace: &mut Workspace,
) -> Result<Trial, Rejection> {
    let progress = workspace.local_planner.advance(constraints, mode)?;
    if progress != Progress::ShorterStep {
        push(&mut workspace.path, workspace.local_planner.state().configuration)?;
    }
    Ok(if progress == Progress::Reached { Trial::Reached } else { Trial::Unfinished })
}
