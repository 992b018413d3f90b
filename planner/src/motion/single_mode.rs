//! Single-mode planning: from one transition configuration to another within their common mode [Grey 4.4.3]. The straight
//! way is tried first, in a few shapes; the trees only where it fails.

use surefoot_shared_types::Pose;

use crate::collision::FootState;
use crate::constraint::{Constraints, Mode, Rejection};
use crate::motion::track::{State, Stretch, Swing, follow, place_at};
use crate::motion::tree;
use crate::motion::workspace::Workspace;

/// A search within one mode.
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
/// The swings that are tried, in order.
const SWINGS: [Swing; 7] =
    [Swing::Hump(0.02), Swing::Hump(0.06), Swing::Over(0.02), Swing::Hump(0.14), Swing::Over(0.08), Swing::Over(0.2), Swing::Hump(0.3)];

/// Searches; on success `workspace.track` holds the waypoints after `from`, `to` included.
///
/// # Errors
/// What stopped the last attempt.
pub fn solve(constraints: &Constraints, problem: &Problem, workspace: &mut Workspace) -> Result<(), Rejection> {
    workspace.track.clear();
    match problem.mode.swing() {
        None => shift(constraints, problem, workspace),
        Some(limb) => swing(constraints, problem, limb, workspace),
    }
}

fn shift(constraints: &Constraints, problem: &Problem, workspace: &mut Workspace) -> Result<(), Rejection> {
    let stretch = Stretch {
        mode: &problem.mode,
        from: &problem.from,
        to: &problem.to,
        exact: true,
        swing: Swing::Straight,
        swing_foot: FootState::Free,
    };
    if problem.failures == 0 && append(constraints, &stretch, workspace).is_ok() {
        return Ok(());
    }
    workspace.track.clear();
    tree::connect(constraints, problem, [&problem.from, &problem.to], workspace)
}

fn swing(constraints: &Constraints, problem: &Problem, limb: usize, workspace: &mut Workspace) -> Result<(), Rejection> {
    let mut last = Rejection::Unreachable;
    for lift in LIFTS {
        let lifted = [&problem.from, &problem.to].map(|state| lifted(constraints, problem, state, limb, lift, workspace));
        let [Ok(from), Ok(to)] = lifted else {
            last = lifted.into_iter().find_map(Result::err).unwrap_or(last);
            continue;
        };
        workspace.track.clear();
        match fly(constraints, problem, [&from, &to], workspace) {
            Ok(()) => return Ok(()),
            Err(rejection) => last = rejection,
        }
    }
    Err(last)
}

/// Lifts off, travels from one lifted state to the other, and lands.
fn fly(constraints: &Constraints, problem: &Problem, lifted: [&State; 2], workspace: &mut Workspace) -> Result<(), Rejection> {
    let [from, to] = lifted;
    let lift_off = leaving(problem, &problem.from, from);
    let landing = leaving(problem, to, &problem.to);
    append(constraints, &lift_off, workspace)?;
    let travel_begins = workspace.track.len();
    append(constraints, &landing, workspace)?;
    workspace.track.truncate(travel_begins);
    let straight = problem.failures == 0
        && SWINGS.iter().any(|&swing| {
            workspace.track.truncate(travel_begins);
            let travel = Stretch { mode: &problem.mode, from, to, exact: true, swing, swing_foot: FootState::Free };
            append(constraints, &travel, workspace).is_ok()
        });
    if !straight {
        workspace.track.truncate(travel_begins);
        tree::connect(constraints, problem, lifted, workspace)?;
    }
    append(constraints, &landing, workspace)
}

fn leaving<'a>(problem: &'a Problem, from: &'a State, to: &'a State) -> Stretch<'a> {
    Stretch { mode: &problem.mode, from, to, exact: true, swing: Swing::Straight, swing_foot: FootState::Leaving }
}

/// The state with the swing sole raised along its normal.
fn lifted(
    constraints: &Constraints,
    problem: &Problem,
    state: &State,
    limb: usize,
    lift: f64,
    workspace: &mut Workspace,
) -> Result<State, Rejection> {
    let mut raised = *state;
    let sole = &mut raised.world_from_soles[limb];
    *sole = Pose::from_parts(sole.translation + sole.rotation * (glam::DVec3::Z * lift), sole.rotation);
    place_at(constraints, &problem.mode, &raised, &mut workspace.work)
}

/// Follows a stretch and appends its waypoints to the track.
fn append(constraints: &Constraints, stretch: &Stretch<'_>, workspace: &mut Workspace) -> Result<(), Rejection> {
    let mut work = 0;
    let ending = follow(constraints, stretch, &mut work, &mut |state| workspace.push(&state.configuration));
    workspace.work += work;
    ending.inspect_err(|&rejection| workspace.count(rejection))
}
