//! Stage P: finds a guide route, and how the robot crouches along it [Grey 3, 4.1-4.3].

use std::sync::Arc;

use surefoot_shared_types::message::SupportMode;

use crate::base::capacity::ArenaFull;
use crate::motion::ids::{GOAL, START};
use crate::pipeline::direct_stage::poses_between;
use crate::pipeline::live_routes::RouteChange;
use crate::pipeline::search::Search;
use crate::pipeline::stage::Event;
use crate::possibility::{
    CrouchContext, Progress, RouteCondition, RouteSearch, StageContext, UpperBody, UpperBodyFit,
};
use crate::preparation::planning_context::PlanningContext;

/// Work units in which most routes are found. Without a route after them, or with one that meets
/// C_N alone, the relaxed problem is tried.
const WORK_BEFORE_RELAXATION: u64 = 1_500;

/// Of so many routes the first is replaced by one along which the root leans, where its trunk is
/// not free.
const REPLACED_EVERY: u64 = 4;

/// Finds a guide route from start to goal, or a detour within the current segment. Where the robot
/// must crouch, also chooses how far at each vertex. Gamma_P and the route stand in [`Search`].
#[derive(Debug)]
pub(crate) struct RouteStage {
    /// The robot above its legs.
    upper_body: Arc<UpperBody>,
    /// Distance between the feet at the ends, m.
    stance_width: f64,
    /// Whether a route is found and its crouch profile is being chosen.
    is_crouching: bool,
    /// Whether a route along which the root leans is searched beside one that is known.
    is_leaning: bool,
    /// Whether the relaxed problem is solved once more, legs included, or left out.
    is_examined: bool,
    /// Whether a route waits for that.
    is_waiting: bool,
    /// Work units that may be spent before the relaxed problem is tried.
    work_before_relaxation: u64,
}

impl RouteStage {
    /// For a robot whose feet are `stance_width` (m) apart at the ends.
    pub fn new(upper_body: Arc<UpperBody>, stance_width: f64) -> Self {
        Self {
            upper_body,
            stance_width,
            is_crouching: false,
            is_leaning: false,
            is_examined: false,
            is_waiting: false,
            work_before_relaxation: WORK_BEFORE_RELAXATION,
        }
    }

    /// Sets the distance between the feet at the ends, m.
    pub fn set_stance_width(&mut self, stance_width: f64) {
        self.stance_width = stance_width;
    }

    /// Leaves the relaxed problem out.
    pub fn skip_relaxation(&mut self, search: &mut Search) {
        (search.guide.is_relaxed, search.guide.is_ground_due) = (true, false);
        self.is_examined = true;
    }

    /// Grows the trees of stage P, or chooses the crouch profile.
    ///
    /// # Errors
    /// The trees are full before a first route is found.
    pub fn step(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        budget: u64,
    ) -> Result<Event, ArenaFull> {
        if self.is_crouching {
            return Ok(self.choose_crouch(context, search, budget));
        }
        if self.is_leaning {
            return Ok(self.search_leaning(context, search, budget));
        }
        if let Some(turn) = search.guide.live.turn.take() {
            return Ok(self.begin_turn(search, turn));
        }
        if self.begin_direct_steps(context, search) {
            return Ok(Event::Near);
        }
        if search.guide.is_ground_due {
            return Ok(Event::NoRouteYet);
        }
        let is_relaxed = search.guide.is_relaxed || search.stats.routes > 0;
        let limit = if is_relaxed { budget } else { budget.min(self.work_before_relaxation) };
        if limit == 0 && budget > 0 {
            self.work_before_relaxation = WORK_BEFORE_RELAXATION;
            return Ok(Event::NoRouteYet);
        }
        let is_found = std::mem::take(&mut self.is_waiting);
        let progress = if is_found { Progress::Route } else { self.grow(context, search, limit) };
        match progress {
            Progress::Growing => return Ok(Event::Continue),
            Progress::Route | Progress::Exhausted if !self.is_examined && is_doubtful(search) => {
                self.is_examined = true;
                self.is_waiting = progress == Progress::Route;
                return Ok(Event::NoRouteYet);
            }
            Progress::Route => {}
            Progress::Exhausted if !is_relaxed => return Ok(Event::NoRouteYet),
            Progress::Full if search.stats.routes == 0 => return Err(ArenaFull::TreeVertices),
            Progress::Exhausted if search.stats.routes == 0 && search.relax_margins() => {
                search.route.begin_again();
                return Ok(Event::Continue);
            }
            Progress::Exhausted if search.stats.routes == 0 => {
                search.stats.used_straight_line = true;
                search.route.use_straight_line();
            }
            Progress::Exhausted | Progress::Full => {
                search.segmentation.cancel_detour();
                search.route.unblock_all();
                return Ok(Event::NoFurtherRoute);
            }
        }
        begin_route(search);
        Ok(self.begin_crouch(search))
    }

    /// Begins with a live route in place of the current one.
    fn begin_turn(&mut self, search: &mut Search, turn: RouteChange) -> Event {
        search.stats.work += 1;
        search.stats.turns += 1;
        begin_route(search);
        search.connections.is_new_route = turn.is_fresh;
        search.segments.current_mut().recovery = turn.recovery;
        self.begin_crouch(search)
    }

    /// Chooses the crouch profile of a route that is neither upright nor has a root posture at each
    /// vertex.
    fn begin_crouch(&mut self, search: &mut Search) -> Event {
        let route = search.route.route();
        self.is_crouching = !route.is_upright() && !route.is_leaning();
        if self.is_crouching { Event::Continue } else { end(search) }
    }

    /// Searches a route along which the root leans, by at most `budget` units of work. Without one,
    /// the route that is known is followed.
    fn search_leaning(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        budget: u64,
    ) -> Event {
        let progress = self.grow(context, search, budget);
        self.is_leaning = progress == Progress::Growing;
        match progress {
            Progress::Growing => return Event::Continue,
            Progress::Route => {
                search.stats.routes -= 1;
                begin_route(search);
            }
            Progress::Exhausted | Progress::Full => {}
        }
        end(search)
    }

    /// Lets a route grow beside the current one, by the work that is owed to it.
    pub fn grow_beside(
        &self,
        context: &PlanningContext,
        search: &mut Search,
        budget: u64,
    ) -> Event {
        let budget = search.guide.live.owed().min(budget);
        let stage_context = self.context(context, self.stance_width);
        let advance = |route: &mut RouteSearch| route.advance(&stage_context, budget);
        search.stats.work += search.guide.live.grow(advance);
        if search.guide.live.owed() > 0 { Event::Continue } else { Event::Done }
    }

    /// Makes the interpolation between start and goal the route, if the goal is near, the robot
    /// stands on both feet, and its upper body fits upright all along.
    fn begin_direct_steps(&self, context: &PlanningContext, search: &mut Search) -> bool {
        if std::mem::replace(&mut search.direct.is_tried, true) {
            return false;
        }
        let [start, goal] = [START, GOAL].map(|end| search.roadmap.boundary(end));
        let may_step = start.support == SupportMode::Double && start.footholds != goal.footholds;
        let [start, goal] = search.route.ends();
        let poses = poses_between(start, goal).filter(|_| may_step);
        let Some(poses) = poses else { return false };
        search.stats.work += 1;
        let fit = self.context(context, self.stance_width).fit_between(
            &start,
            &goal,
            RouteCondition::UpperBody,
        );
        if fit != Some(UpperBodyFit::Upright) {
            return false;
        }
        search.route.set_route(poses);
        search.segmentation.begin(START);
        search.segmentation.push(GOAL, search.route.route().vertex_count() - 1);
        true
    }

    /// What stage P reads, for feet that are `stance_width` (m) apart.
    fn context<'a>(&'a self, context: &'a PlanningContext, stance_width: f64) -> StageContext<'a> {
        StageContext {
            constraints: &context.constraints,
            surfaces: &context.surfaces,
            upper_body: &self.upper_body,
            preparation: &context.preparation,
            postures: &[],
            seed: context.seed,
            stance_width,
            threads: &context.threads,
        }
    }

    /// Grows the trees by at most `budget` units of work. The steps along the first route are as
    /// narrow as the robot walks; where no walk is found on it, others have wider ones.
    fn grow(&mut self, context: &PlanningContext, search: &mut Search, budget: u64) -> Progress {
        if search.stats.routes > 0 {
            search.route.widen_stances();
        }
        let stance_width = self.stance_width.min(search.route.route().walking_width());
        let (progress, spent) = search.route.advance(&self.context(context, stance_width), budget);
        self.work_before_relaxation = self.work_before_relaxation.saturating_sub(spent);
        search.stats.work += spent;
        search.stats.tree_edges = search.route.labelled();
        progress
    }

    /// Advances the choice of the crouch profile by at most `budget` units of work.
    fn choose_crouch(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        budget: u64,
    ) -> Event {
        let crouch_context = CrouchContext {
            constraints: &context.constraints,
            upper_body: &self.upper_body,
            threads: &context.threads,
        };
        let (spent, has_chosen) =
            search.guide.crouch.advance(&crouch_context, search.route.route(), budget);
        search.stats.work += spent;
        self.is_crouching = !has_chosen;
        let Search { guide, route, .. } = &*search;
        let must_lean = has_chosen
            && is_leaning_due(search)
            && !(guide.crouch.may_step()
                && guide.crouch.has_free_trunk(&crouch_context, route.route()));
        self.is_leaning = must_lean && search.route.begin_leaning();
        if has_chosen && !self.is_leaning { end(search) } else { Event::Continue }
    }
}

/// Whether a first route meets C_N alone at best: it may lead through what the robot cannot pass.
fn is_doubtful(search: &Search) -> bool {
    search.stats.routes == 0 && search.route.condition() == RouteCondition::Necessary
}

/// Whether a route is to be searched along which the root leans: for the first of every few routes
/// that are no detours, unless there may be another upright route beside it.
fn is_leaning_due(search: &Search) -> bool {
    !search.segmentation.has_detour()
        && !search.guide.live.has_others()
        && search.stats.routes % REPLACED_EVERY == 1
}

/// Prepares the other stages for a route that was found. Sweeps visit the vertices with placements
/// that stage P found: of a detour these are the new ones.
fn begin_route(search: &mut Search) {
    let Search { route, footholds, stats, .. } = search;
    let has_placements = |vertex: usize| !route.placements(vertex).is_empty();
    let vertices = route.route().vertex_count();
    let is_whole = !(0..vertices).any(has_placements) || stats.routes == 0;
    footholds.selection.select(vertices, |vertex| is_whole || has_placements(vertex));
    stats.routes += 1;
    stats.routes_under_c_n += u64::from(route.condition() == RouteCondition::Necessary);
    stats.leaning_routes += u64::from(route.route().is_leaning());
    stats.route_edges = route.route().labelled();
    search.connections.begin_route();
    search.guide.crouch.begin();
}

/// The route is complete: after a detour the boundaries of the segments move with it.
fn end(search: &mut Search) -> Event {
    let vertices = search.route.route().vertex_count();
    let current = search.segments.current_mut();
    if !search.segmentation.end_detour(current.segment, vertices) {
        return Event::NewRoute;
    }
    current.sweeps = 0;
    search.begin_sweep();
    Event::Detour
}
