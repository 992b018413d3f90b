//! Gamma_P: two trees that grow toward each other, a station at a time [Grey 3, 4.3].

mod straighten;

use surefoot_shared_types::config::Mark;

use super::branch::{BRANCHES_MAX, Begin, Branch, Branches, End, Purpose};
use super::extension::Extension;
use super::forest::{Forest, Labelled};
use super::label::Label;
use super::route::Route;
use super::sampling::{BACKWARD, Course, SIDES, bounds_around, draw, is_short, samples_max};
use super::stance::{Context, Pair, Placed};
use super::station::Station;
use super::tree::{Vertex, push_branch};
use crate::arena::{list_at, reserve};
use crate::collision::bvh::Aabb;
use crate::foot_placement::FootPlacementConfig;
use crate::random::{Random, Stream};

/// Branches that grow side by side toward samples at first, one of each tree. None sees what the
/// others find, so a short search has few.
const AT_ONCE_MIN: usize = 2;
/// One more for each so many samples.
const SAMPLES_PER_BRANCH: u32 = 32;
/// Places where stage M gave up that are remembered.
const GIVEN_UP_MAX: usize = 64;

/// One of so many routes that are begun anew is walked backward, the first of them.
const BACKWARD_EVERY: u64 = 3;

/// The straight way ends this near to the goal, in the metric of Gamma_P, m.
const STRAIGHT_END: f64 = 0.02;

/// A place where stage M gave up.
#[derive(Debug, Clone, Copy)]
struct GivenUp {
    place: Station,
    radius: f64,
}

/// What an advance of the growth came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// There is more to do.
    Growing,
    /// There is a guide route.
    Route,
    /// No route was found with all samples spent.
    Exhausted,
    /// No route was found before the arena was full.
    Full,
}

/// What the growth is busy with.
#[derive(Debug, Clone, Copy)]
enum Activity {
    /// Growing branches of the trees.
    Growing,
    /// Straightening the route; so many shortcuts were tried.
    Straightening { tried: usize },
    /// Labelling the edges of the route.
    Labelling,
    /// Nothing more to do.
    Over(Progress),
}

/// A branch that reaches out from vertex `tip` of a tree for vertex `met` of the other one.
#[derive(Debug, Clone, Copy)]
struct Join {
    tree: usize,
    tip: u32,
    met: u32,
    /// How far off its way the robot faces, rad.
    facing: f64,
}

/// The trees of stage P and the route found last, allocated once.
#[derive(Debug)]
pub struct Growth {
    forest: Forest,
    branches: Branches,
    /// How many of the branches that have ended are part of the trees, and what is to follow these.
    merged: usize,
    joins: heapless::Vec<Join, BRANCHES_MAX>,
    activity: Activity,
    /// Where the trees begin: at start and goal, or at both ends of a detour.
    ends: [Vertex; 2],
    whole_ends: [Vertex; 2],
    /// The way from the start that stage M has crossed.
    crossed: Vec<Vertex>,
    spacing: f64,
    world: Aabb,
    /// Where samples are drawn.
    bounds: Aabb,
    route: Route,
    spare: Vec<Vertex>,
    /// The route of which a detour replaces the stations between these two.
    whole: Vec<Vertex>,
    detour: Option<[usize; 2]>,
    given_up: heapless::Deque<GivenUp, GIVEN_UP_MAX>,
    samples: u32,
    relaxed: bool,
    /// How far off its way the robot faces unless it sidles, rad.
    facing: f64,
    /// Routes that were begun anew.
    routes: u64,
    /// How often the growth began anew; names random streams.
    generation: u64,
}

impl Growth {
    /// Trees of at most `vertices_max` stations from both `ends`, start and goal, at most `spacing`
    /// metres apart, inside `world` (m).
    pub fn new(
        ends: [&Mark; 2],
        spacing: f64,
        vertices_max: usize,
        world: &Aabb,
        placement: &FootPlacementConfig,
    ) -> Self {
        let [start, goal] = ends;
        let mut growth = Self {
            forest: Forest::new(vertices_max),
            branches: Branches::new(placement),
            merged: 0,
            joins: heapless::Vec::new(),
            activity: Activity::Growing,
            ends: [start, goal].map(|mark| Vertex::root(Station::on(mark), None)),
            whole_ends: [start, goal].map(|mark| Vertex::root(Station::on(mark), None)),
            crossed: reserve(2 * vertices_max),
            spacing,
            world: *world,
            bounds: *world,
            route: Route::new(start, goal, vertices_max),
            spare: reserve(2 * vertices_max),
            whole: reserve(2 * vertices_max),
            detour: None,
            given_up: heapless::Deque::new(),
            samples: 0,
            relaxed: false,
            facing: 0.0,
            routes: 0,
            generation: 0,
        };
        growth.begin(growth.whole_ends);
        growth
    }

    /// Begins at another start mark. To be called before the first advance.
    pub fn start_on(&mut self, start: &Mark) {
        self.whole_ends[0] = Vertex::root(Station::on(start), None);
        self.route.start_on(start);
        self.begin(self.whole_ends);
    }

    /// Stands start and goal on their placements. To be called before the first advance.
    pub fn stand_on(&mut self, pairs: [Option<Pair>; 2]) {
        for (end, pair) in self.whole_ends.iter_mut().zip(pairs) {
            end.pair = pair;
        }
        self.begin(self.whole_ends);
    }

    /// How many edges of the trees were labelled so far, and how many of these are possible.
    pub fn labelled(&self) -> Labelled {
        self.forest.labelled
    }

    /// Notes that stage M has crossed the route from the start to a station: that way is possible
    /// from now on.
    pub fn note_crossed(&mut self, station: usize) {
        for index in 1..=station {
            self.route.vertices[index].is_crossed = true;
            if self.route.labels[index] == Label::Indeterminate {
                self.route.labels[index] = Label::Crossed;
            }
        }
        self.crossed.clear();
        self.crossed.extend_from_slice(&self.route.vertices[..=station]);
        for (index, vertex) in self.crossed.iter_mut().enumerate() {
            (vertex.parent, vertex.placements) = (index.saturating_sub(1) as u32, (0, 0));
        }
    }

    /// The route found last.
    pub fn route(&self) -> &Route {
        &self.route
    }

    /// The placements found along station `index` of the route.
    pub fn placements(&self, index: usize) -> &[Placed] {
        list_at(&self.forest.placements, self.route.vertices[index].placements)
    }

    /// Makes the straight way the route, whatever stands or gapes there: what is left to try where
    /// no route was found.
    pub fn go_straight(&mut self) {
        self.route.clear();
        let [mut at, goal] = self.ends.map(|end| end.station);
        let fits = self.route.vertices.capacity() - 1;
        while self.route.vertices.len() < fits && at.distance(&goal) > STRAIGHT_END {
            self.route.vertices.push(Vertex { is_upright: false, ..Vertex::root(at, None) });
            at = at.toward(&goal, self.spacing, 0.0);
            at.position.z += (goal.position.z - at.position.z)
                * (self.spacing / at.way_to(&goal).length().max(self.spacing));
        }
        self.route.vertices.push(Vertex::root(goal, None));
        self.route.labels.resize(self.route.vertices.len(), Label::Indeterminate);
    }

    /// Takes a place where stage M gave up, and what is within a radius of it (m, in the metric of
    /// Gamma_P), for possible no longer.
    pub fn give_up(&mut self, place: Station, radius: f64) {
        if self.given_up.is_full() {
            self.given_up.pop_front();
        }
        let _full = self.given_up.push_back(GivenUp { place, radius });
    }

    /// Takes all places for possible again.
    pub fn forgive(&mut self) {
        self.given_up.clear();
    }

    /// Begins anew, for a route from start to goal that is another in all. The first of every few
    /// of them is walked backward, which leaves room for the knees before a riser.
    pub fn begin_again(&mut self) {
        self.detour = None;
        self.generation += 1;
        self.facing = if self.routes.is_multiple_of(BACKWARD_EVERY) { BACKWARD } else { 0.0 };
        self.routes += 1;
        self.begin(self.whole_ends);
    }

    /// Begins anew, for a detour that replaces the stations between two of the route.
    pub fn begin_detour(&mut self, between: [usize; 2]) {
        self.detour = Some(between);
        self.generation += 1;
        self.facing = if self.route.is_backward() { BACKWARD } else { 0.0 };
        self.whole.clear();
        let mut ends =
            between.map(|index| Vertex { placements: (0, 0), ..self.route.vertices[index] });
        ends[1].is_crossed = false;
        self.begin(ends);
        self.whole.extend_from_slice(&self.route.vertices);
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        let lists = [&self.spare, &self.whole, &self.crossed, &self.route.vertices];
        let vertices = lists.map(Vec::capacity).iter().sum::<usize>();
        vertices * size_of::<Vertex>()
            + self.route.labels.capacity() * size_of::<Label>()
            + self.forest.bytes()
            + self.branches.bytes()
    }

    /// Spends at most `budget` units of work, each a station that is tried; answers what that came
    /// to, and how much was spent.
    pub fn advance(&mut self, context: &Context<'_>, budget: u64) -> (Progress, u64) {
        if matches!(self.activity, Activity::Labelling) {
            return (self.label_next(context), 1);
        }
        let Self { forest, branches, given_up, .. } = self;
        let is_barred = |station: &Station| {
            given_up.iter().any(|known| known.place.distance(station) < known.radius)
        };
        let spent = branches.advance(context, &forest.placements, is_barred, budget);
        if spent == budget {
            return (Progress::Growing, spent);
        }
        (self.conclude(context), spent + 1)
    }

    /// All branches have ended: one after the other becomes part of the trees, or of the route, and
    /// the next ones begin.
    fn conclude(&mut self, context: &Context<'_>) -> Progress {
        match self.activity {
            Activity::Growing => self.merge(context),
            Activity::Straightening { tried } => self.straighten(context.seed, tried),
            Activity::Labelling | Activity::Over(_) => {}
        }
        let Activity::Over(progress) = self.activity else { return Progress::Growing };
        if progress != Progress::Route {
            return progress;
        }
        if let Some([first, last]) = self.detour.take() {
            self.insert_detour(first, last);
        }
        self.route.labels.clear();
        self.activity = Activity::Labelling;
        Progress::Growing
    }

    /// The straight way is tried first: from the start to the goal, or from the farthest place that
    /// stage M has reached.
    fn begin(&mut self, ends: [Vertex; 2]) {
        self.ends = ends;
        self.bounds = bounds_around(ends.map(|end| end.station.position), &self.world);
        self.samples = 0;
        self.relaxed = false;
        self.plant();
        self.try_first();
    }

    /// Leaves of the trees their roots, and what is crossed.
    fn plant(&mut self) {
        self.forest.placements.clear();
        self.route.vertices.iter_mut().for_each(|vertex| vertex.placements = (0, 0));
        for (tree, &end) in self.forest.trees.iter_mut().zip(&self.ends) {
            tree.set(&[Vertex { parent: 0, ..end }]);
        }
        self.grow_on_what_is_crossed();
    }

    /// Straight to the goal, from the vertex that is nearest to it.
    fn try_first(&mut self) {
        self.activity = Activity::Growing;
        self.forget_branches();
        let goal = self.ends[1].station;
        let tip = self.forest.trees[0].nearest(|station| station.distance(&goal));
        self.join(Join { tree: 0, tip, met: 0, facing: self.facing });
    }

    fn grow_on_what_is_crossed(&mut self) {
        if self.detour.is_none() && !self.crossed.is_empty() {
            self.forest.trees[0].set(&self.crossed);
        }
    }

    /// Begins to grow a tree from one of its vertices toward one of the other tree.
    fn join(&mut self, Join { tree, tip, met, facing }: Join) {
        let target = self.forest.trees[1 - tree][met as usize].station;
        let extension = self.extension(tree, target, facing, true);
        self.grow(Purpose::Meet { tip, met }, extension, self.forest.trees[tree][tip as usize]);
    }

    fn grow(&mut self, purpose: Purpose, extension: Extension, from: Vertex) {
        self.branches.begin(Begin { purpose, extension, from, stations_max: usize::MAX });
    }

    fn extension(&self, tree: usize, target: Station, facing: f64, joins: bool) -> Extension {
        Extension {
            target,
            backward: tree == 1,
            facing,
            joins,
            relaxed: self.relaxed,
            spacing: self.spacing,
        }
    }

    /// Whether the robot may also step sideways: where half of the samples found no other way. On a
    /// long course only once stage M has given a route up: it relaxes its demands before, since
    /// there are more places that arms brush against than slits.
    fn sidles(&self) -> bool {
        let is_late = 2 * self.samples >= samples_max(&self.bounds);
        is_late && (self.generation > 0 || is_short(&self.bounds))
    }

    /// Forgets the branches that have ended; answers what is to follow them.
    fn forget_branches(&mut self) -> heapless::Vec<Join, BRANCHES_MAX> {
        self.branches.clear();
        self.merged = 0;
        std::mem::take(&mut self.joins)
    }

    /// Begins the next branches: those that join, and others toward samples, the more the longer
    /// they have been drawn. The first of all join alone, since the straight way needs none
    /// besides.
    fn begin_branches(&mut self, seed: u64) {
        let joins = self.forget_branches();
        joins.iter().for_each(|&join| self.join(join));
        let is_first = self.samples == 0 && !joins.is_empty();
        let at_once = if is_first {
            0
        } else {
            (AT_ONCE_MIN + (self.samples / SAMPLES_PER_BRANCH) as usize).min(BRANCHES_MAX)
        };
        while self.branches.len() < at_once && self.samples < samples_max(&self.bounds) {
            self.sample(seed);
        }
        if self.branches.len() == 0 {
            self.relax();
        }
    }

    fn sample(&mut self, seed: u64) {
        let mut random = Random::new(
            seed,
            Stream::Possibility,
            u64::from(self.samples) << 1 | u64::from(self.relaxed),
            self.generation,
        );
        let tree = (self.samples % 2) as usize;
        let toward = self.forest.trees[1 - tree][0].station.position;
        let course = Course {
            bounds: &self.bounds,
            toward,
            backward: tree == 1,
            facing: self.facing,
            sidles: self.sidles(),
        };
        let (tip, target, facing) =
            draw(&mut self.forest.trees[tree], &course, self.samples / 2, &mut random);
        self.samples += 1;
        let extension = self.extension(tree, target, facing, false);
        self.grow(Purpose::Sample { tip }, extension, self.forest.trees[tree][tip as usize]);
    }

    /// The sufficient conditions cannot be met all along: the necessary ones are enough from now
    /// on. What has grown meets them.
    fn relax(&mut self) {
        if self.relaxed {
            self.activity = Activity::Over(Progress::Exhausted);
            return;
        }
        self.relaxed = true;
        self.samples = 0;
        self.try_first();
    }

    /// There is no room for more stations: what demands less may need fewer, so it begins anew with
    /// that; what demands least is over.
    fn overflow(&mut self) {
        if self.relaxed {
            self.activity = Activity::Over(Progress::Full);
            return;
        }
        self.plant();
        self.relax();
    }

    /// Adds the next branch to its tree, and once all are added begins others; or makes a route of
    /// the first that meets the other tree.
    fn merge(&mut self, context: &Context<'_>) {
        let Some(&Branch { purpose, extension, end, .. }) = self.branches.all().get(self.merged)
        else {
            return self.begin_branches(context.seed);
        };
        let tree = usize::from(extension.backward);
        let (Purpose::Sample { tip } | Purpose::Meet { tip, .. }) = purpose else { return };
        let Some(tip) = self.add(self.merged, (tree, tip), context) else { return self.overflow() };
        match (end, purpose) {
            (Some(End::Arrived { is_upright }), Purpose::Meet { met, .. }) => {
                self.forest.trees[tree][tip as usize].is_upright &= is_upright;
                return self.meet(tree, tip, met);
            }
            (Some(End::Long), _) => {}
            _ => self.joins.extend(self.join_after(self.merged, (tree, tip))),
        }
        self.merged += 1;
    }

    /// Adds a branch to its tree; answers its tip, or `None` where there is no room.
    fn add(
        &mut self,
        branch: usize,
        (tree, mut tip): (usize, u32),
        context: &Context<'_>,
    ) -> Option<u32> {
        let branch = &self.branches.all()[branch];
        for stance in &branch.grown {
            tip = self.forest.add((tree, tip), branch.extension.facing, stance)?;
            self.forest.label_edge((tree, tip), context);
        }
        Some(tip)
    }

    /// What follows where a branch came to its end at a tip: if it grew toward a sample, or was the
    /// first try, the other tree reaches out for its tip. If it reached out itself, facing as on
    /// all of the route, it tries once more sideways.
    fn join_after(&self, branch: usize, (tree, tip): (usize, u32)) -> Option<Join> {
        let Branch { purpose, extension, ref grown, .. } = self.branches.all()[branch];
        if let Purpose::Meet { met, .. } = purpose
            && extension.facing == self.facing
            && self.sidles()
        {
            return Some(Join {
                tree,
                tip,
                met,
                facing: SIDES[self.samples as usize / 2 % SIDES.len()],
            });
        }
        let reaches_out = !grown.is_empty()
            && (matches!(purpose, Purpose::Sample { .. }) || self.samples == 0 && tree == 0);
        reaches_out.then(|| {
            let Vertex { station: at, facing, .. } = self.forest.trees[tree][tip as usize];
            let other = &self.forest.trees[1 - tree];
            let near = other.nearest(|station| station.distance(&at));
            let is_alike = other[near as usize].facing == facing;
            Join {
                tree: 1 - tree,
                tip: near,
                met: tip,
                facing: if is_alike { facing } else { self.facing },
            }
        })
    }

    /// Labels the next edge of the route.
    fn label_next(&mut self, context: &Context<'_>) -> Progress {
        let Route { vertices, labels, .. } = &mut self.route;
        let next = labels.len();
        let before = next.checked_sub(1).and_then(|index| context.pair_of(&mut vertices[index]));
        let pair = context.pair_of(&mut vertices[next]);
        let label = before
            .zip(pair)
            .map_or(Label::Indeterminate, |(from, to)| context.label_between(&from, &to));
        labels.push(if label == Label::Indeterminate && vertices[next].is_crossed {
            Label::Crossed
        } else {
            label
        });
        if labels.len() < vertices.len() {
            return Progress::Growing;
        }
        self.activity = Activity::Over(Progress::Route);
        Progress::Route
    }

    /// The trees meet: the route leads from the start over both vertices to the goal.
    fn meet(&mut self, tree: usize, tip: u32, met: u32) {
        let tips = if tree == 0 { [tip, met] } else { [met, tip] };
        self.route.clear();
        push_branch(&self.forest.trees[0], tips[0], &mut self.route.vertices);
        self.route.vertices.reverse();
        push_branch(&self.forest.trees[1], tips[1], &mut self.route.vertices);
        let is_straight = self.samples == 0 && !self.relaxed;
        self.forget_branches();
        self.activity = if is_straight {
            Activity::Over(Progress::Route)
        } else {
            Activity::Straightening { tried: 0 }
        };
    }

    /// Puts the route just found in place of the stations between two of the whole one, if that
    /// fits.
    fn insert_detour(&mut self, first: usize, last: usize) {
        if self.whole.len() + self.route.vertices.len() > self.spare.capacity() {
            std::mem::swap(&mut self.whole, &mut self.route.vertices);
            return;
        }
        self.spare.clear();
        self.spare.extend_from_slice(&self.whole[..first]);
        self.spare.extend_from_slice(&self.route.vertices);
        self.spare.extend_from_slice(&self.whole[last + 1..]);
        std::mem::swap(&mut self.spare, &mut self.route.vertices);
    }
}
