//! Gamma_P: two trees that grow toward each other, a station at a time [Grey 3, 4.3].

mod straighten;

use surefoot_shared_types::config::Mark;

use super::extension::{Extension, Step, Tip};
use super::label::Label;
use super::route::Route;
use super::sampling::{BACKWARD, Course, SIDES, bounds_around, draw, is_short, join_crowd, nearest, samples_max};
use super::stance::{Context, Pair, Placed, Stance};
use super::station::Station;
use crate::arena::reserve;
use crate::collision::bvh::Aabb;
use crate::foot_placement::Scratch;
use crate::random::{Random, Stream};

/// Stations added by one extension.
const EXTENSION_MAX: u32 = 96;
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

/// A station of a tree.
#[derive(Debug, Clone, Copy)]
pub(super) struct Vertex {
    pub station: Station,
    /// The vertex it was reached from; the root's is itself.
    pub parent: u32,
    /// Its placements: first and count in the arena.
    pub placements: (u32, u32),
    /// The placements that it stands on, if it has two that are apart.
    pub pair: Option<Pair>,
    /// Whether primitives lead over it, once that was asked.
    pub stands: Option<bool>,
    /// Whether all that the root carries has room there with the robot upright.
    pub is_upright: bool,
    /// Whether stage M has crossed the edge that leads to it from the vertex before it on the route.
    pub is_crossed: bool,
    /// How far off the way it is walked on the robot faces, rad.
    pub facing: f64,
    /// Vertices of its tree that were added near it, and samples drawn about it.
    pub crowd: u32,
}

impl Vertex {
    pub(super) fn root(station: Station, pair: Option<Pair>) -> Self {
        Self { station, parent: 0, placements: (0, 0), pair, stands: None, is_upright: true, is_crossed: false, facing: 0.0, crowd: 0 }
    }
}

/// How many edges stage P has labelled.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Labelled {
    /// Edges of the trees.
    pub edges: u64,
    /// Those of them that are possible.
    pub possible: u64,
}

/// What the growth is busy with.
#[derive(Debug, Clone, Copy)]
enum Activity {
    /// Drawing the next sample.
    Sampling,
    /// Growing a tree from its vertex `tip`; `added` stations so far.
    Extending { tree: usize, tip: u32, added: u32, extension: Extension, ending: Ending },
    /// Straightening the route: the branch from station `from` leads to station `to` and begins at `first` in the first tree.
    Straightening { tried: u32, branch: Option<Branch> },
    /// Labelling the edges of the route.
    Labelling,
    /// Nothing more to do.
    Over(Progress),
}

#[derive(Debug, Clone, Copy)]
struct Branch {
    from: usize,
    to: usize,
    first: u32,
    tip: Vertex,
}

/// What an arrival means.
#[derive(Debug, Clone, Copy)]
enum Ending {
    /// Nothing: the target was a sample.
    Sample,
    /// The trees meet: the target is this vertex of the other tree.
    Meets(u32),
}

/// The trees of stage P and the route found last, allocated once.
#[derive(Debug)]
pub struct Growth {
    trees: [Vec<Vertex>; 2],
    placements: Vec<Placed>,
    activity: Activity,
    /// Where the trees begin: at start and goal, or at both ends of a detour.
    ends: [Vertex; 2],
    whole_ends: [Vertex; 2],
    /// The way from the start that stage M has crossed.
    crossed: Vec<Vertex>,
    labelled: Labelled,
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
    queries: u64,
}

impl Growth {
    /// Trees of at most `vertices_max` stations from `start` and `goal`, at most `spacing` metres apart, inside `world` (m).
    pub fn new(start: &Mark, goal: &Mark, spacing: f64, vertices_max: usize, world: &Aabb) -> Self {
        let vertices = || reserve(vertices_max);
        let mut growth = Self {
            trees: [vertices(), vertices()],
            placements: reserve(vertices_max * super::stance::PLACEMENTS_MAX / 2),
            activity: Activity::Sampling,
            ends: [start, goal].map(|mark| Vertex::root(Station::on(mark), None)),
            whole_ends: [start, goal].map(|mark| Vertex::root(Station::on(mark), None)),
            crossed: reserve(2 * vertices_max),
            labelled: Labelled::default(),
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
            queries: 0,
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
        self.labelled
    }

    /// Notes that stage M has crossed the route from the start to a station: that way is possible from now on.
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
        let (first, count) = self.route.vertices[index].placements;
        &self.placements[first as usize..(first + count) as usize]
    }

    /// Makes the straight way the route, whatever stands or gapes there: what is left to try where no route was found.
    pub fn go_straight(&mut self) {
        self.route.clear();
        let [mut at, goal] = self.ends.map(|end| end.station);
        let fits = self.route.vertices.capacity() - 1;
        while self.route.vertices.len() < fits && at.distance(&goal) > STRAIGHT_END {
            self.route.vertices.push(Vertex { is_upright: false, ..Vertex::root(at, None) });
            at = at.toward(&goal, self.spacing, 0.0);
            at.position.z += (goal.position.z - at.position.z) * (self.spacing / at.way_to(&goal).length().max(self.spacing));
        }
        self.route.vertices.push(Vertex::root(goal, None));
        self.route.labels.resize(self.route.vertices.len(), Label::Indeterminate);
    }

    /// Takes a place where stage M gave up, and what is within a radius of it (m, in the metric of Gamma_P), for possible no longer.
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

    /// Begins anew, for a route from start to goal that is another in all. The first of every few of them is walked backward, which
    /// leaves room for the knees before a riser.
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
        let mut ends = between.map(|index| Vertex { placements: (0, 0), ..self.route.vertices[index] });
        ends[1].is_crossed = false;
        self.begin(ends);
        self.whole.extend_from_slice(&self.route.vertices);
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        let lists = [&self.trees[0], &self.trees[1], &self.spare, &self.whole, &self.crossed, &self.route.vertices];
        let vertices = lists.map(Vec::capacity).iter().sum::<usize>();
        vertices * size_of::<Vertex>()
            + self.route.labels.capacity() * size_of::<Label>()
            + self.placements.capacity() * size_of::<Placed>()
    }

    /// Does a small piece of work: at most one station is added.
    pub fn advance(&mut self, context: &Context<'_>, scratch: &mut [Scratch; 2]) -> Progress {
        if matches!(self.activity, Activity::Labelling) {
            return self.label_next(context);
        }
        let progress = self.advance_within(context, scratch);
        if progress == Progress::Route
            && let Some([first, last]) = self.detour.take()
        {
            self.insert_detour(first, last);
        }
        if progress == Progress::Route {
            self.route.labels.clear();
            self.activity = Activity::Labelling;
            return Progress::Growing;
        }
        progress
    }

    fn advance_within(&mut self, context: &Context<'_>, scratch: &mut [Scratch; 2]) -> Progress {
        match self.activity {
            Activity::Sampling => self.sample(context.seed),
            Activity::Extending { tree, tip, added, extension, ending } => {
                let name = self.next_query();
                let step = extension.step(context, tip_at(&self.trees[tree][tip as usize], &self.placements), name, scratch);
                self.extended((tree, tip, added), extension, ending, step, context);
            }
            Activity::Straightening { tried, branch: None } => self.next_shortcut(context.seed, tried),
            Activity::Straightening { tried, branch: Some(branch) } if !self.may_be_shorter(&branch) => {
                self.activity = Activity::Straightening { tried, branch: None };
            }
            Activity::Straightening { tried, branch: Some(branch) } => {
                let extension = self.shortcut(&branch);
                let name = self.next_query();
                let step = extension.step(context, tip_at(&branch.tip, &self.placements), name, scratch);
                self.straightened(tried, branch, step);
            }
            Activity::Labelling | Activity::Over(_) => {}
        }
        match self.activity {
            Activity::Over(progress) => progress,
            _ => Progress::Growing,
        }
    }

    /// The straight way is tried first: from the start to the goal, or from the farthest place that stage M has reached.
    fn begin(&mut self, ends: [Vertex; 2]) {
        self.ends = ends;
        self.bounds = bounds_around(ends.map(|end| end.station.position), &self.world);
        self.samples = 0;
        self.relaxed = false;
        self.plant();
        self.activity = self.first_try();
    }

    /// Leaves of the trees their roots, and what is crossed.
    fn plant(&mut self) {
        self.placements.clear();
        self.route.vertices.iter_mut().for_each(|vertex| vertex.placements = (0, 0));
        for (tree, &end) in self.trees.iter_mut().zip(&self.ends) {
            tree.clear();
            tree.push(Vertex { parent: 0, ..end });
        }
        self.grow_on_what_is_crossed();
    }

    /// Straight to the goal, from the vertex that is nearest to it.
    fn first_try(&self) -> Activity {
        let goal = self.ends[1].station;
        let tip = nearest(&self.trees[0], |station| station.distance(&goal));
        self.join((0, tip), 0, self.facing)
    }

    fn grow_on_what_is_crossed(&mut self) {
        let fits = self.crossed.len() <= self.trees[0].capacity();
        if self.detour.is_none() && !self.crossed.is_empty() && fits {
            self.trees[0].clear();
            self.trees[0].extend_from_slice(&self.crossed);
        }
    }

    /// Grows a tree from one of its vertices toward vertex `met` of the other tree.
    fn join(&self, (tree, tip): (usize, u32), met: u32, facing: f64) -> Activity {
        let target = self.trees[1 - tree][met as usize].station;
        let extension = self.extension(tree, target, facing, true);
        Activity::Extending { tree, tip, added: 0, extension, ending: Ending::Meets(met) }
    }

    fn extension(&self, tree: usize, target: Station, facing: f64, joins: bool) -> Extension {
        Extension { target, backward: tree == 1, facing, joins, relaxed: self.relaxed, spacing: self.spacing }
    }

    /// Whether the robot may also step sideways: where half of the samples found no other way. On a long course only once stage M has
    /// given a route up: it relaxes its demands before, since there are more places that arms brush against than slits.
    fn sidles(&self) -> bool {
        let is_late = 2 * self.samples >= samples_max(&self.bounds);
        is_late && (self.generation > 0 || is_short(&self.bounds))
    }

    fn next_query(&mut self) -> u64 {
        self.queries += 1;
        self.queries
    }

    fn sample(&mut self, seed: u64) {
        if self.samples == samples_max(&self.bounds) {
            self.relax();
            return;
        }
        let mut random = Random::new(seed, Stream::Possibility, u64::from(self.samples) << 1 | u64::from(self.relaxed), self.generation);
        let tree = (self.samples % 2) as usize;
        let toward = self.trees[1 - tree][0].station.position;
        let course = Course { bounds: &self.bounds, toward, backward: tree == 1, facing: self.facing, sidles: self.sidles() };
        let (tip, target, facing) = draw(&mut self.trees[tree], &course, self.samples / 2, &mut random);
        self.samples += 1;
        let extension = self.extension(tree, target, facing, false);
        self.activity = Activity::Extending { tree, tip, added: 0, extension, ending: Ending::Sample };
    }

    /// The sufficient conditions cannot be met all along: the necessary ones are enough from now on. What has grown meets them.
    fn relax(&mut self) {
        if self.relaxed {
            self.activity = Activity::Over(Progress::Exhausted);
            return;
        }
        self.relaxed = true;
        self.samples = 0;
        self.activity = self.first_try();
    }

    /// There is no room for more stations: what demands less may need fewer, so it begins anew with that; what demands least is over.
    fn overflow(&mut self) {
        if self.relaxed {
            self.activity = Activity::Over(Progress::Full);
            return;
        }
        self.plant();
        self.relax();
    }

    fn extended(&mut self, branch: (usize, u32, u32), extension: Extension, ending: Ending, step: Step, context: &Context<'_>) {
        let (tree, tip, added) = branch;
        match step {
            Step::Grown(stance) if self.is_given_up(&stance.station) => self.stopped(branch, extension.facing, ending),
            Step::Grown(stance) => match self.add((tree, tip), extension.facing, &stance) {
                Some(tip) if added < EXTENSION_MAX => {
                    self.label_edge(tree, tip, context);
                    self.activity = Activity::Extending { tree, tip, added: added + 1, extension, ending };
                }
                Some(_) => self.activity = Activity::Sampling,
                None => self.overflow(),
            },
            Step::Arrived { is_upright } => match ending {
                Ending::Meets(met) => {
                    self.trees[tree][tip as usize].is_upright &= is_upright;
                    self.met(tree, tip, met);
                }
                Ending::Sample => self.stopped(branch, extension.facing, ending),
            },
            Step::Blocked => self.stopped(branch, extension.facing, ending),
        }
    }

    /// A branch came to its end; if it grew toward a sample, or was the first try, the other tree reaches out for its tip. If that
    /// has reached out already, facing as on all of the route, it tries once more sideways.
    fn stopped(&mut self, (tree, tip, added): (usize, u32, u32), facing: f64, ending: Ending) {
        if let Ending::Meets(met) = ending
            && facing == self.facing
            && self.sidles()
        {
            let side = SIDES[self.samples as usize / 2 % SIDES.len()];
            self.activity = self.join((tree, tip), met, side);
            return;
        }
        let reaches_out = added > 0 && (matches!(ending, Ending::Sample) || self.samples == 0 && tree == 0);
        self.activity = if reaches_out {
            let Vertex { station: at, facing, .. } = self.trees[tree][tip as usize];
            let near = nearest(&self.trees[1 - tree], |station| station.distance(&at));
            let is_alike = self.trees[1 - tree][near as usize].facing == facing;
            self.join((1 - tree, near), tip, if is_alike { facing } else { self.facing })
        } else {
            Activity::Sampling
        };
    }

    fn is_given_up(&self, station: &Station) -> bool {
        self.given_up.iter().any(|known| known.place.distance(station) < known.radius)
    }

    fn label_edge(&mut self, tree: usize, tip: u32, context: &Context<'_>) {
        let [parent, tip] = [self.trees[tree][tip as usize].parent, tip].map(|index| index as usize);
        let label = {
            let [from, to] = [parent, tip].map(|index| context.pair_of(&mut self.trees[tree][index]));
            from.zip(to).map_or(Label::Indeterminate, |(from, to)| context.label_between(&from, &to))
        };
        self.labelled.edges += 1;
        self.labelled.possible += u64::from(label.is_possible());
    }

    /// Labels the next edge of the route.
    fn label_next(&mut self, context: &Context<'_>) -> Progress {
        let Route { vertices, labels, .. } = &mut self.route;
        let next = labels.len();
        let before = next.checked_sub(1).and_then(|index| context.pair_of(&mut vertices[index]));
        let pair = context.pair_of(&mut vertices[next]);
        let label = before.zip(pair).map_or(Label::Indeterminate, |(from, to)| context.label_between(&from, &to));
        labels.push(if label == Label::Indeterminate && vertices[next].is_crossed { Label::Crossed } else { label });
        if labels.len() < vertices.len() {
            return Progress::Growing;
        }
        self.activity = Activity::Over(Progress::Route);
        Progress::Route
    }

    fn add(&mut self, (tree, parent): (usize, u32), facing: f64, stance: &Stance) -> Option<u32> {
        if self.trees[tree].len() == self.trees[tree].capacity() {
            return None;
        }
        let root = Vertex::root(stance.station, stance.pair);
        let mut vertex = Vertex { placements: self.keep(stance)?, parent, facing, is_upright: stance.is_upright, ..root };
        join_crowd(&mut self.trees[tree], &mut vertex);
        self.trees[tree].push(vertex);
        Some((self.trees[tree].len() - 1) as u32)
    }

    fn keep(&mut self, stance: &Stance) -> Option<(u32, u32)> {
        let first = self.placements.len() as u32;
        if self.placements.len() + stance.placements.len() > self.placements.capacity() {
            return None;
        }
        self.placements.extend_from_slice(&stance.placements);
        Some((first, stance.placements.len() as u32))
    }

    /// The trees meet: the route leads from the start over both vertices to the goal.
    fn met(&mut self, tree: usize, tip: u32, met: u32) {
        let tips = if tree == 0 { [tip, met] } else { [met, tip] };
        self.route.clear();
        push_branch(&self.trees[0], tips[0], &mut self.route.vertices);
        self.route.vertices.reverse();
        push_branch(&self.trees[1], tips[1], &mut self.route.vertices);
        let is_straight = self.samples == 0 && !self.relaxed;
        self.activity = if is_straight { Activity::Over(Progress::Route) } else { Activity::Straightening { tried: 0, branch: None } };
    }

    /// Puts the route just found in place of the stations between two of the whole one, if that fits.
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

/// A vertex as the end of a branch, with its placements, or at least those that it stands on.
fn tip_at<'a>(vertex: &'a Vertex, placements: &'a [Placed]) -> Tip<'a> {
    let (first, count) = vertex.placements;
    let known =
        if count > 0 { &placements[first as usize..(first + count) as usize] } else { vertex.pair.as_ref().map_or(&[][..], |pair| pair) };
    Tip { station: &vertex.station, placements: known }
}

/// Appends a vertex and those it was reached from, the root last.
fn push_branch(tree: &[Vertex], tip: u32, out: &mut Vec<Vertex>) {
    let mut at = tip as usize;
    while out.len() < out.capacity() {
        out.push(tree[at]);
        if at == 0 {
            break;
        }
        at = tree[at].parent as usize;
    }
}
