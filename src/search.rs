//! Advances a planner to the end of its search.

use surefoot_planner::constraint::Rejection;
use surefoot_planner::{Outcome, Planner, Status};

use crate::allocations;
use crate::clock::Stopwatch;
use crate::failure::Failure;
use crate::line::{Diagnosis, Hindrance, Line, Planned, Searching};
use crate::signals;

/// Fewest work units between two looks at the clock: a fraction of a second. How often it looks has
/// no influence on the plan.
const WORK_PER_STEP_MIN: u64 = 20_000;
/// A long search looks again after this share of what it has spent: so seldom that entering the
/// planner's thread pool does not make its queue grow.
const SHARE_PER_STEP: u64 = 16;
/// Time between two words about the search, s.
const TELL_EVERY_SECONDS: f64 = 0.1;

/// Advances `planner` until its search ends, telling about it now and then.
///
/// # Errors
/// When a signal asks for the end, or telling fails.
pub fn run(
    planner: &mut Planner,
    work_max: u64,
    tell: &mut dyn FnMut(&Line) -> Result<(), Failure>,
) -> Result<Planned, Failure> {
    let ended = run_until(planner, work_max, tell, &mut || false)?;
    ended.ok_or_else(|| Failure::Interrupted(signals::raised().unwrap_or(libc::SIGTERM)))
}

/// Like [`run`], but nothing once a signal asks for the end, or `is_over` says so between two
/// steps.
///
/// # Errors
/// When telling fails.
pub fn run_until(
    planner: &mut Planner,
    work_max: u64,
    tell: &mut dyn FnMut(&Line) -> Result<(), Failure>,
    is_over: &mut dyn FnMut() -> bool,
) -> Result<Option<Planned>, Failure> {
    let watch = Stopwatch::start();
    let mut allocations = 0;
    let mut told_at = 0.0;
    loop {
        let before = allocations::count();
        let work = (planner.tally().work / SHARE_PER_STEP).max(WORK_PER_STEP_MIN);
        let status = planner.step_while(work, &|| signals::raised().is_none());
        allocations += allocations::count() - before;
        if let Status::Done(outcome) = status {
            return Ok(Some(planned(planner, &outcome, watch.seconds(), allocations)));
        }
        if signals::raised().is_some() || is_over() {
            return Ok(None);
        }
        if watch.seconds() - told_at > TELL_EVERY_SECONDS {
            told_at = watch.seconds();
            tell(&Line::Planning(searching(planner, work_max)))?;
        }
    }
}

fn searching(planner: &Planner, work_max: u64) -> Searching {
    let tally = planner.tally();
    Searching {
        work: tally.work,
        work_max,
        sequences: tally.sequences,
        transitions: tally.transitions_found,
        motions: tally.motions_found,
    }
}

fn planned(planner: &Planner, outcome: &Outcome, plan_seconds: f64, allocations: u64) -> Planned {
    let tally = planner.tally();
    let found = *outcome == Outcome::Found;
    Planned {
        end: outcome.into(),
        outcome: outcome.word().to_owned(),
        bound: outcome.bound().map(str::to_owned),
        description: describe(planner, outcome),
        digest: found.then(|| planner.digest().to_string()),
        plan_seconds,
        work: tally.work,
        sequences: tally.sequences,
        diagnosis: outcome.bound().map(|_| Box::new(diagnosis(planner))),
        route_edges: tally.route_edges.edges,
        route_edges_possible: tally.route_edges.possible,
        primitives: tally.primitives,
        allocations,
        steps: planner.steps(),
        waypoints: planner.waypoints(),
        chunks: planner.chunks().len() as u64,
    }
}

/// An outcome in words, with the names of what is in the way.
fn describe(planner: &Planner, outcome: &Outcome) -> String {
    let collision = &planner.constraints().collision;
    outcome.hit().map_or_else(
        || outcome.describe(),
        |hit| format!("{}: {}", outcome.describe(), collision.describe(hit)),
    )
}

fn diagnosis(planner: &Planner) -> Diagnosis {
    let tally = planner.tally();
    Diagnosis {
        is_unguided: tally.is_unguided,
        routes: tally.routes,
        hindrance: planner
            .hindrance()
            .map(|place| Hindrance { xyz: place.position.to_array(), failures: place.failures }),
        rejections: Rejection::WORDS
            .map(str::to_owned)
            .into_iter()
            .zip(tally.rejections)
            .filter(|(_, count)| *count > 0)
            .collect(),
    }
}
