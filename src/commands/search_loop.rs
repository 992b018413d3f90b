//! Advances a planner to the end of its search.

use surefoot_planner::constraints::constraints::Constraints;
use surefoot_planner::constraints::rejection::Rejection;
use surefoot_planner::pipeline::{Improvement, SearchStats};
use surefoot_planner::{Outcome, Planner, Status};
use surefoot_shared_types::message::LimitKind;

use crate::commands::colliding_links;
use crate::report::binding::{BindingShare, shares_of};
use crate::report::command_error::CommandError;
use crate::report::event::{
    Bottleneck, CollidingLinks, Diagnosis, Improved, PlanResult, Planned, RoleEvent,
    SearchProgress, SmoothMotion,
};
use crate::report::liveness;
use crate::report::walk_facts::WalkFacts;
use crate::system::clock::Stopwatch;
use crate::system::{allocations, signals};

/// Fewest work units between two readings of the clock: a fraction of a second. The plan does not
/// depend on it.
const WORK_PER_STEP_MIN: u64 = 1_000;
/// A long search reads the clock after one part in this many of its work so far.
const SHARE_PER_STEP: u64 = 16;
/// Least share of self-collisions among all rejections that is a main reason.
const SELF_COLLISIONS_MIN: f64 = 0.25;
/// Time between two progress events, s.
const EMIT_INTERVAL_SECONDS: f64 = 0.1;

/// Advances `planner` until its search ends. Reports its progress at intervals, and its results so
/// far if a signal comes.
///
/// # Errors
/// A signal comes, or reporting fails.
pub fn run(
    planner: &mut Planner,
    work_max: u64,
    emit: &mut dyn FnMut(&RoleEvent) -> Result<(), CommandError>,
) -> Result<Planned, CommandError> {
    let mut search = SearchLoop::begin(work_max);
    search.run(planner, emit)
}

/// What a search came to.
#[derive(Debug)]
pub enum Searched {
    /// It has ended.
    Ended(Box<Planned>),
    /// The first chunk is final; the rest of the plan is to be made.
    FirstChunk,
    /// It was interrupted.
    Interrupted,
}

/// A search that is advanced in steps, and its measurements.
#[derive(Debug)]
pub struct SearchLoop {
    watch: Stopwatch,
    work_max: u64,
    allocations: u64,
    emitted_at: f64,
    /// Time until the first chunk was final, s.
    first_chunk: Option<f64>,
    /// Whether the improvement of the plan was reported.
    is_improving: bool,
}

impl SearchLoop {
    /// Begins a search with this limit of its work.
    pub fn begin(work_max: u64) -> Self {
        Self {
            watch: Stopwatch::start(),
            work_max,
            allocations: 0,
            emitted_at: 0.0,
            first_chunk: None,
            is_improving: false,
        }
    }

    /// Time since the search began, s.
    pub fn seconds(&self) -> f64 {
        self.watch.seconds()
    }

    /// Advances the search to its end, as [`run`] does.
    ///
    /// # Errors
    /// A signal comes, or reporting fails.
    pub fn run(
        &mut self,
        planner: &mut Planner,
        emit: &mut dyn FnMut(&RoleEvent) -> Result<(), CommandError>,
    ) -> Result<Planned, CommandError> {
        loop {
            match self.until_first_chunk(planner, emit, &mut || false)? {
                Searched::Ended(planned) => return Ok(*planned),
                Searched::FirstChunk => {}
                Searched::Interrupted => {
                    emit(&RoleEvent::Planned(self.interrupted(planner)))?;
                    return Err(CommandError::interrupted());
                }
            }
        }
    }

    /// Advances the search until its first chunk is final or it ends, or until a signal comes or
    /// `is_over` returns true between two steps. A search whose first chunk is final is advanced to
    /// its end. One that improves its plan ends with the best one then.
    ///
    /// # Errors
    /// Reporting fails.
    pub fn until_first_chunk(
        &mut self,
        planner: &mut Planner,
        emit: &mut dyn FnMut(&RoleEvent) -> Result<(), CommandError>,
        is_over: &mut dyn FnMut() -> bool,
    ) -> Result<Searched, CommandError> {
        let had_chunk = self.first_chunk.is_some();
        loop {
            let work = (planner.stats().work / SHARE_PER_STEP).max(WORK_PER_STEP_MIN);
            if let Some(planned) = self.step(planner, work, emit)? {
                return Ok(Searched::Ended(Box::new(planned)));
            }
            if !had_chunk && self.first_chunk.is_some() {
                return Ok(Searched::FirstChunk);
            }
            if signals::raised().is_some() || is_over() {
                let best = self.stop_improving(planner).map(Box::new);
                return Ok(best.map_or(Searched::Interrupted, Searched::Ended));
            }
        }
    }

    /// Advances the search by `work` units, at first no further than to its first final chunk.
    /// Returns its result once it has ended.
    ///
    /// # Errors
    /// Reporting fails.
    pub fn step(
        &mut self,
        planner: &mut Planner,
        work: u64,
        emit: &mut dyn FnMut(&RoleEvent) -> Result<(), CommandError>,
    ) -> Result<Option<Planned>, CommandError> {
        let before = allocations::count();
        let status = if self.first_chunk.is_none() {
            planner.step_to_first_chunk(work, &liveness::keep_going)
        } else {
            planner.step_while(work, &liveness::keep_going)
        };
        self.allocations += allocations::count() - before;
        if self.first_chunk.is_none() && !planner.final_chunks().is_empty() {
            self.first_chunk = Some(self.watch.seconds());
        }
        if let Status::Done(outcome) = status {
            return Ok(Some(self.planned(planner, Some(&outcome))));
        }
        if let Some(Improvement { first_seconds, .. }) = planner.improvement()
            && !self.is_improving
        {
            self.is_improving = true;
            emit(&RoleEvent::Improving { first_seconds })?;
        }
        if self.watch.seconds() - self.emitted_at > EMIT_INTERVAL_SECONDS {
            self.emitted_at = self.watch.seconds();
            emit(&RoleEvent::Planning(search_progress(planner, self.work_max)))?;
        }
        Ok(None)
    }

    /// Ends the improvement of a plan. Returns the best one, or `None` if there is none yet.
    pub fn stop_improving(&mut self, planner: &mut Planner) -> Option<Planned> {
        if !planner.stop_improving() {
            return None;
        }
        self.first_chunk = Some(self.watch.seconds());
        let mut planned = self.planned(planner, Some(&Outcome::Found));
        if let Some(improved) = &mut planned.improved {
            improved.stopped = true;
        }
        Some(planned)
    }

    /// What a search that is stopped has found so far.
    pub fn interrupted(&self, planner: &Planner) -> Planned {
        self.planned(planner, None)
    }

    fn planned(&self, planner: &Planner, outcome: Option<&Outcome>) -> Planned {
        let Self { allocations, first_chunk, .. } = *self;
        planned(
            planner,
            outcome,
            &SearchTimes { plan: self.watch.seconds(), first_chunk },
            allocations,
        )
    }
}

fn search_progress(planner: &Planner, work_max: u64) -> SearchProgress {
    let stats = planner.stats();
    SearchProgress {
        work: stats.work,
        work_max,
        sequences: stats.sequences,
        transitions: stats.transitions_found,
        motions: stats.motions_found,
    }
}

/// Times of a search, s.
struct SearchTimes {
    plan: f64,
    /// Until the first chunk was final.
    first_chunk: Option<f64>,
}

/// What a search has found; without an outcome a signal ended it.
fn planned(
    planner: &Planner,
    outcome: Option<&Outcome>,
    times: &SearchTimes,
    allocations: u64,
) -> Planned {
    let stats = planner.stats();
    let found = outcome == Some(&Outcome::Found);
    let bound = outcome.and_then(Outcome::bound);
    let walk = found.then(|| WalkFacts::of_chunks(planner.chunks()));
    let stopped = || "stopped before a plan was found".to_owned();
    Planned {
        result: outcome.map_or(PlanResult::Stopped, PlanResult::from),
        outcome: outcome.map_or("interrupted", Outcome::name).to_owned(),
        bound: bound.map(str::to_owned),
        description: outcome.map_or_else(stopped, |outcome| planner.describe(outcome)),
        digest: found.then(|| planner.digest().to_string()),
        plan_seconds: times.plan,
        first_chunk_seconds: times.first_chunk.filter(|_| found),
        work: stats.work,
        sequences: stats.sequences,
        diagnosis: (bound.is_some() || outcome.is_none()).then(|| Box::new(diagnosis(planner))),
        route_edges: stats.route_edges.edges,
        route_edges_possible: stats.route_edges.possible,
        primitives: stats.primitives,
        allocations,
        steps: walk.map_or(0, |walk| walk.steps),
        waypoints: planner.waypoints(),
        chunks: planner.chunks().len() as u64,
        walk,
        smooth: planner.binding_times().map(|_| Box::new(smooth_motion(planner, &stats))),
        improved: planner.improvement().filter(|_| found).map(improved),
    }
}

fn improved(improvement: Improvement) -> Improved {
    let Improvement { first_work, work, first_seconds, seconds, rounds, kept } = improvement;
    Improved { first_work, work, first_seconds, seconds, rounds, kept, stopped: false }
}

fn smooth_motion(planner: &Planner, stats: &SearchStats) -> SmoothMotion {
    let (binding, slowed_share) = binding_of(planner);
    SmoothMotion {
        rests: stats.rests,
        searched_phases: stats.searched_phases,
        relaxed_points: stats.relaxed_points,
        beyond_limits: stats.beyond_limits,
        without_stop: stats.without_stop,
        untimed_pieces: stats.untimed_pieces,
        binding,
        slowed_share,
    }
}

/// What binds a smooth motion, the longest first, and the share of its time in which it is slower
/// than its rates allow.
fn binding_of(planner: &Planner) -> (Vec<BindingShare>, f64) {
    let Some(times) = planner.binding_times() else { return (vec![], 0.0) };
    let of_limits = times.iter().map(|(limit, seconds)| (limit.kind(), limit.joint(), seconds));
    let all: Vec<_> = of_limits.chain([(LimitKind::None, None, times.free)]).collect();
    let total: f64 = all.iter().map(|(.., seconds)| seconds).sum();
    let name = |joint: usize| planner.joint_name(joint).map(str::to_owned);
    (shares_of(all, name), times.slowed / total.max(f64::MIN_POSITIVE))
}

fn diagnosis(planner: &Planner) -> Diagnosis {
    let stats = planner.stats();
    Diagnosis {
        used_straight_line: stats.used_straight_line,
        routes: stats.routes,
        bottleneck: planner
            .bottleneck()
            .map(|place| Bottleneck { xyz: place.position.to_array(), failures: place.failures }),
        rejections: Rejection::NAMES
            .map(str::to_owned)
            .into_iter()
            .zip(stats.rejections)
            .filter(|(_, count)| *count > 0)
            .collect(),
        colliding: colliding(planner.constraints(), &stats.rejections),
    }
}

/// The links that collide most often, where self-collisions are a main reason of rejections.
fn colliding(
    constraints: &Constraints,
    rejections: &[u64; Rejection::COUNT],
) -> Option<CollidingLinks> {
    let total: u64 = rejections.iter().sum();
    let collisions = rejections[Rejection::SelfCollision as usize];
    let is_main = collisions as f64 >= SELF_COLLISIONS_MIN * total as f64 && total > 0;
    let (links, percent) = is_main.then(|| colliding_links::most_often(constraints))??;
    Some(CollidingLinks { links, percent })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::commands::colliding_links::tests::{constraints_of, hubo_with_a_ball};

    #[test]
    fn links_that_collide_are_named_where_self_collisions_are_a_main_reason() {
        let constraints = constraints_of(&hubo_with_a_ball());
        let named = |collisions| {
            let mut rejections = [0; Rejection::COUNT];
            rejections[Rejection::SelfCollision as usize] = collisions;
            rejections[Rejection::Unreachable as usize] = 100 - collisions;
            colliding(&constraints, &rejections).map(|pair| pair.describe())
        };
        let line = named(30).unwrap();
        let begin = "link 'right_shin' collides with link 'right_foot' in ";
        assert!(line.starts_with(begin) && line.ends_with("as it shifts its weight"), "{line}");
        assert_eq!((named(20), named(0)), (None, None));
    }
}
