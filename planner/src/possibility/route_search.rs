//! The search for a guide route in Gamma_P: a bidirectional RRT over mid-feet poses [Grey 3, 4.3].

use glam::DVec3;
use surefoot_shared_types::config::scenario::StancePose;

use crate::base::arena::{reserve, slice_at};
use crate::base::random::{Random, Stream};
use crate::constraints::foothold::{FootPair, FootPlacement};
use crate::foot_placement::FootPlacementConfig;
use crate::geometry::bvh::Aabb;
use crate::possibility::blocked_regions::BlockedRegions;
use crate::possibility::branch::{Branch, BranchEnd, BranchKind, BranchRequest, Branches};
use crate::possibility::crouch_trial::CrouchContext;
use crate::possibility::edge_labels::Label;
use crate::possibility::extension::Extension;
use crate::possibility::forest::{Forest, LabelStats};
use crate::possibility::guide_route::GuideRoute;
use crate::possibility::joining::join_after;
use crate::possibility::lean_reduction::reduce_lean;
use crate::possibility::mid_feet_pose::MidFeetPose;
use crate::possibility::root_postures::RootPostures;
use crate::possibility::root_vertex::{PostureId, UPRIGHT};
use crate::possibility::route_condition::RouteCondition;
use crate::possibility::route_run::{
    Activity, Detour, Join, Joins, LaterConditions, Progress, Run,
};
use crate::possibility::route_shortcuts::RouteShortcuts;
use crate::possibility::tree::{Vertex, push_branch};
use crate::possibility::tuning::{
    BACKWARD_EVERY, BRANCHES_MAX, LEANING_EVERY, LEANING_SPACING_SHARE, PARALLEL_BRANCHES_MIN,
    SAMPLES_PER_BRANCH,
};
use crate::possibility::vertex_candidates::StageContext;
use crate::possibility::vertex_sampling::{BACKWARD, SampleRequest, sample};
use crate::robot::crouch::Crouch;

/// Limits of the trees.
#[derive(Debug)]
struct GrowthBounds {
    /// Largest distance between two vertices, m.
    spacing: f64,
    /// The bounds of the world, m.
    world: Aabb,
}

/// The search for a guide route: the trees of stage P and the route found last, allocated once.
#[derive(Debug)]
pub struct RouteSearch {
    pub(crate) forest: Forest,
    pub(crate) branches: Branches,
    pub(crate) joins: Joins,
    pub(crate) run: Run,
    route: GuideRoute,
    shortcuts: RouteShortcuts,
    postures: RootPostures,
    pub(crate) detour: Detour,
    blocked: BlockedRegions,
    /// The part of the route from the start that stage M has solved.
    pub(crate) traversed: Vec<Vertex>,
    /// Start and goal.
    endpoints: [Vertex; 2],
    region: GrowthBounds,
}

impl RouteSearch {
    /// A search between two `ends`, start and goal, for feet at most `walking_width` (m) apart
    /// between them, with trees of at most `vertices_max` vertices, at most `spacing` metres
    /// apart, inside the bounds `world`, m. Allocates.
    pub fn new(
        ends: [&StancePose; 2],
        walking_width: f64,
        spacing: f64,
        vertices_max: usize,
        world: &Aabb,
        placement: &FootPlacementConfig,
    ) -> Self {
        let endpoints = ends.map(|stance| Vertex::root(MidFeetPose::of_stance(stance), None));
        let mut search = Self {
            forest: Forest::new(vertices_max),
            branches: Branches::new(placement),
            joins: Joins::default(),
            run: Run::new(endpoints, *world),
            route: GuideRoute::new(ends, walking_width, vertices_max),
            shortcuts: RouteShortcuts::default(),
            postures: RootPostures::new(),
            detour: Detour { full_route: reserve(2 * vertices_max), between: None },
            blocked: BlockedRegions::default(),
            traversed: reserve(2 * vertices_max),
            endpoints,
            region: GrowthBounds { spacing, world: *world },
        };
        search.begin(search.endpoints);
        search
    }

    /// Lets stances be as wide between the ends as there.
    pub fn widen_stances(&mut self) {
        self.route.widen_stances();
    }

    /// Sets another start stance. To be called before the first advance.
    pub fn set_start(&mut self, start: &StancePose) {
        self.endpoints[0] = Vertex::root(MidFeetPose::of_stance(start), None);
        self.route.set_start(start);
        self.begin(self.endpoints);
    }

    /// Sets the placements of start and goal. To be called before the first advance.
    pub fn set_end_pairs(&mut self, pairs: [Option<FootPair>; 2]) {
        for (end, pair) in self.endpoints.iter_mut().zip(pairs) {
            end.pair = pair;
        }
        self.begin(self.endpoints);
    }

    /// The poses at the start and at the goal.
    pub fn ends(&self) -> [MidFeetPose; 2] {
        self.endpoints.map(|end| end.pose)
    }

    /// The condition of the current search, or of the route that it found.
    pub fn condition(&self) -> RouteCondition {
        self.run.condition
    }

    /// Number of edges of the trees labelled so far, and of those that are possible.
    pub fn labelled(&self) -> LabelStats {
        self.forest.labelled
    }

    /// Marks the route from the start to a vertex as solved by stage M; its edges count as possible
    /// from then on.
    pub fn mark_traversed(&mut self, vertex: usize) {
        for index in 1..=vertex {
            self.route.vertices[index].is_traversed = true;
            if self.route.labels[index] == Label::Indeterminate {
                self.route.labels[index] = Label::Traversed;
            }
        }
        self.traversed.clear();
        self.traversed.extend_from_slice(&self.route.vertices[..=vertex]);
        for (index, vertex) in self.traversed.iter_mut().enumerate() {
            (vertex.parent, vertex.placements) = (index.saturating_sub(1) as u32, (0, 0));
        }
    }

    /// The route found last.
    pub fn route(&self) -> &GuideRoute {
        &self.route
    }

    /// The edges of both trees, between points midway between the soles, m.
    pub fn tree_edges(&self) -> impl Iterator<Item = [DVec3; 2]> {
        self.forest.trees.iter().flat_map(|tree| {
            let position = |vertex: &Vertex| vertex.pose.position;
            tree.iter()
                .map(move |vertex| [position(&tree[vertex.parent as usize]), position(vertex)])
        })
    }

    /// The placements found at vertex `index` of the route.
    pub fn placements(&self, index: usize) -> &[FootPlacement] {
        slice_at(&self.forest.placements, self.route.vertices[index].placements)
    }

    /// Makes the straight line the route, regardless of obstacles and gaps. The last resort if no
    /// route was found.
    pub fn use_straight_line(&mut self) {
        self.route.make_straight(self.run.ends.map(|end| end.pose), self.region.spacing);
    }

    /// Makes these poses the route, without placements.
    pub fn set_route(&mut self, poses: impl Iterator<Item = MidFeetPose>) {
        self.route.clear();
        self.route.vertices.extend(poses.map(|pose| Vertex::root(pose, None)));
        self.route.labels.resize(self.route.vertices.len(), Label::Indeterminate);
    }

    /// Excludes the region around a pose where stage M failed from sampling; `radius` in the metric
    /// of Gamma_P, m.
    pub fn block(&mut self, pose: MidFeetPose, radius: f64) {
        self.blocked.add(pose, radius);
    }

    /// Removes all blocked regions.
    pub fn unblock_all(&mut self) {
        self.blocked.clear();
    }

    /// Restarts the search for another route from start to goal. The first of every
    /// `BACKWARD_EVERY` is walked backward, which keeps the knees clear of risers.
    pub fn restart(&mut self) {
        self.detour.between = None;
        let is_backward = self.run.restarts.is_multiple_of(BACKWARD_EVERY);
        self.run.heading_offset = if is_backward { BACKWARD } else { 0.0 };
        self.run.generation += 1;
        self.run.restarts += 1;
        self.begin(self.endpoints);
        if self.run.later.has_leant && self.run.restarts.is_multiple_of(LEANING_EVERY) {
            self.lean();
        }
    }

    /// Restarts the search for the first route.
    pub fn begin_again(&mut self) {
        self.run.generation += 1;
        self.begin(self.endpoints);
    }

    /// Begins the search for a route beside that of another search: it avoids the same regions, and
    /// one more around a pose, with its radius in the metric of Gamma_P, m.
    pub fn begin_beside(&mut self, other: &Self, (pose, radius): (MidFeetPose, f64)) {
        self.blocked = other.blocked.clone();
        self.block(pose, radius);
        self.run.generation = self.run.generation.max(other.run.generation);
        self.begin_again();
    }

    /// What may follow where no upright route is found around both ends.
    pub fn later_mut(&mut self) -> &mut LaterConditions {
        &mut self.run.later
    }

    /// Lets the root lean forward and backward alone: for measurements.
    pub fn leave_out_roll(&mut self) {
        self.postures.leave_out_roll();
    }

    /// Searches a route along which the root leans where it must, beside the route that is known
    /// and is kept until then. Returns `false` if such routes are left out.
    pub fn begin_leaning(&mut self) -> bool {
        if !self.run.later.has_leaning {
            return false;
        }
        self.run.generation += 1;
        self.run.begin(self.endpoints, &self.region.world, false);
        self.run.later.leans_only = true;
        self.reset_vertices();
        self.lean();
        true
    }

    /// Lets the root lean from the first branch on.
    fn lean(&mut self) {
        (self.run.condition, self.run.samples) = (RouteCondition::Leaning, 0);
        self.run.later.has_leant = true;
        self.postures.ask_for_more();
        self.connect_directly();
    }

    /// The crouch at a vertex of a route along which the root leans; `None` on other routes.
    pub fn crouch(&self, vertex: usize) -> Option<Crouch> {
        let posture = self.route.vertices[vertex].posture as usize;
        self.route.is_leaning().then(|| self.postures.all()[posture].crouch)
    }

    /// Restarts the search for a detour that replaces the vertices between two of the route.
    pub fn begin_detour(&mut self, between: [usize; 2]) {
        self.detour.between = Some(between);
        self.run.generation += 1;
        self.run.heading_offset = if self.route.is_backward() { BACKWARD } else { 0.0 };
        self.detour.full_route.clear();
        let mut ends =
            between.map(|index| Vertex { placements: (0, 0), ..self.route.vertices[index] });
        ends[1].is_traversed = false;
        self.begin(ends);
        if self.route.is_leaning() {
            self.lean();
        }
        self.detour.full_route.extend_from_slice(&self.route.vertices);
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        let vertices = self.detour.full_route.capacity() + self.traversed.capacity();
        vertices * size_of::<Vertex>()
            + self.route.bytes()
            + self.forest.bytes()
            + self.branches.bytes()
            + self.postures.bytes()
            + self.run.path.bytes()
    }

    /// Spends at most `budget` work units, each one vertex that is tried. Returns the progress and
    /// the work spent.
    pub fn advance(&mut self, context: &StageContext<'_>, budget: u64) -> (Progress, u64) {
        match self.run.activity {
            Activity::Labelling => return (self.label_next(context), 1),
            Activity::ReducingLean { done } => return (self.reduce_next_lean(context, done), 1),
            _ => {}
        }
        if self.run.condition == RouteCondition::Leaning && self.postures.is_due() {
            let StageContext { constraints, upper_body, threads, stance_width, .. } = *context;
            let inputs = CrouchContext { constraints, upper_body, threads };
            return (Progress::Growing, self.postures.advance(&inputs, stance_width, budget));
        }
        let Self { forest, branches, blocked, postures, .. } = self;
        let is_blocked = |pose: &MidFeetPose| blocked.contains(pose);
        let inputs = StageContext { postures: postures.all(), ..*context };
        let spent = branches.advance(&inputs, &forest.placements, is_blocked, budget);
        if spent == budget {
            return (Progress::Growing, spent);
        }
        (self.finish_batch(context), spent + 1)
    }

    /// All branches have ended: adds the next one to the trees or the route, or begins new
    /// branches.
    fn finish_batch(&mut self, context: &StageContext<'_>) -> Progress {
        match self.run.activity {
            Activity::Growing => self.merge(context),
            Activity::Shortcutting => self.shortcut_route(context.seed),
            Activity::ReducingLean { .. } | Activity::Labelling | Activity::Over(_) => {}
        }
        let Activity::Over(progress) = self.run.activity else { return Progress::Growing };
        if progress != Progress::Route {
            return progress;
        }
        if let Some(between) = self.detour.between.take() {
            self.route.insert_into(&mut self.detour.full_route, between);
        }
        self.route.labels.clear();
        self.run.activity = if self.route.is_leaning() {
            Activity::ReducingLean { done: 0 }
        } else {
            Activity::Labelling
        };
        Progress::Growing
    }

    /// Reduces the lean of the root at the next vertex of the route.
    fn reduce_next_lean(&mut self, context: &StageContext<'_>, done: usize) -> Progress {
        let context = StageContext { postures: self.postures.all(), ..*context };
        self.run.activity = if reduce_lean(&mut self.route, &context, done) {
            Activity::ReducingLean { done: done + 1 }
        } else {
            Activity::Labelling
        };
        Progress::Growing
    }

    /// Begins a search between two ends with a straight branch from the start, or from the farthest
    /// vertex that stage M has reached, to the goal.
    fn begin(&mut self, ends: [Vertex; 2]) {
        self.run.begin(ends, &self.region.world, self.detour.between.is_some());
        self.reset_trees();
        self.connect_directly();
    }

    /// Resets the trees to their roots and the traversed part of the route, without placements.
    fn reset_trees(&mut self) {
        self.forest.placements.clear();
        self.route.vertices.iter_mut().for_each(|vertex| vertex.placements = (0, 0));
        self.reset_vertices();
    }

    /// Resets the trees to their roots and the traversed part of the route, with all placements.
    fn reset_vertices(&mut self) {
        for (tree, &end) in self.forest.trees.iter_mut().zip(&self.run.ends) {
            tree.set(&[Vertex { parent: 0, ..end }]);
        }
        self.reuse_traversed();
    }

    /// Makes the traversed part of the route the tree of the start, unless a detour is searched.
    fn reuse_traversed(&mut self) {
        if self.detour.between.is_none() && !self.traversed.is_empty() {
            self.forest.trees[0].set(&self.traversed);
        }
    }

    /// Begins a branch from a vertex of a tree toward a vertex of the other tree.
    pub(crate) fn join(&mut self, Join { tree, tip, other, heading_offset }: Join) {
        let Vertex { pose: target, posture, .. } = self.forest.trees[1 - tree][other as usize];
        let extension = Extension {
            target_posture: posture,
            ..self.extension(tree, target, heading_offset, true)
        };
        self.grow(
            BranchKind::Connect { tip, other },
            extension,
            self.forest.trees[tree][tip as usize],
        );
    }

    /// Begins a branch without a limit of its vertices.
    pub(crate) fn grow(&mut self, kind: BranchKind, extension: Extension, from: Vertex) {
        self.branches.begin(BranchRequest { kind, extension, from, vertices_max: usize::MAX });
    }

    /// The extension of a branch of a tree toward a target.
    pub(crate) fn extension(
        &self,
        tree: usize,
        target: MidFeetPose,
        heading_offset: f64,
        joins: bool,
    ) -> Extension {
        Extension {
            target,
            target_posture: UPRIGHT,
            backward: tree == 1,
            heading_offset,
            joins,
            condition: self.run.condition,
            spacing: self.spacing(),
        }
    }

    /// The distance between vertices, m.
    pub(crate) fn spacing(&self) -> f64 {
        let is_leaning = self.run.condition == RouteCondition::Leaning;
        self.region.spacing * if is_leaning { LEANING_SPACING_SHARE } else { 1.0 }
    }

    /// Removes the branches that have ended. Returns the joins that follow them.
    pub(crate) fn clear_branches(&mut self) -> heapless::Vec<Join, BRANCHES_MAX> {
        self.branches.clear();
        std::mem::take(&mut self.joins).next
    }

    /// Begins the next branches: the joins, and branches toward samples, whose number grows with
    /// the samples drawn. The first joins grow alone, because a straight route needs no samples.
    fn begin_branches(&mut self, seed: u64) {
        let joins = self.clear_branches();
        joins.iter().for_each(|&join| self.join(join));
        if joins.is_empty() && self.follow_next_leg() {
            return;
        }
        let is_first = self.run.samples == 0 && !joins.is_empty();
        let count_max = if is_first {
            0
        } else {
            (PARALLEL_BRANCHES_MIN + (self.run.samples / SAMPLES_PER_BRANCH) as usize)
                .min(BRANCHES_MAX)
        };
        while self.branches.len() < count_max && self.run.samples < self.run.samples_max() {
            self.sample(seed);
        }
        if self.branches.len() == 0 {
            self.relax();
        }
    }

    /// Draws a sample and begins a branch toward it.
    fn sample(&mut self, seed: u64) {
        let Run { samples, heading_offset, .. } = self.run;
        let object = u64::from(samples) << 1 | self.run.stream_bits();
        let mut random = Random::new(seed, Stream::Possibility, object, self.run.stream());
        let tree = (samples % 2) as usize;
        let toward = self.forest.trees[1 - tree][0].pose.position;
        let request = SampleRequest {
            bounds: &self.run.bounds,
            toward,
            backward: tree == 1,
            heading_offset,
            may_sidestep: self.run.may_sidestep(),
        };
        let (tip, target, heading_offset) =
            sample(&mut self.forest.trees[tree], &request, samples / 2, &mut random);
        self.run.samples += 1;
        let target_posture = match self.run.condition {
            RouteCondition::Leaning => random.below(self.postures.all().len()) as PostureId,
            _ => UPRIGHT,
        };
        let extension =
            Extension { target_posture, ..self.extension(tree, target, heading_offset, false) };
        self.grow(BranchKind::Sample { tip }, extension, self.forest.trees[tree][tip as usize]);
    }

    /// No route meets the condition: the search continues under the next one, with the same trees.
    /// The first search continues in a wider region before, up to the whole world. On a detour the
    /// root leans only where it leans on the route.
    fn relax(&mut self) {
        let (is_first, is_detour) = (self.run.generation == 0, self.detour.between.is_some());
        let is_upright = self.run.condition == RouteCondition::Root;
        let may_widen = is_first && is_upright && self.run.later.may_widen;
        if may_widen && self.run.widen(&self.region.world) {
            return;
        }
        let may_lean = !is_detour || self.route.is_leaning();
        match self.run.next_condition(is_detour, may_lean) {
            Some(RouteCondition::Leaning) => self.lean(),
            Some(next) => {
                (self.run.condition, self.run.samples) = (next, 0);
                self.connect_directly();
            }
            None => self.run.activity = Activity::Over(Progress::Exhausted),
        }
    }

    /// A tree is full: the search restarts under the next condition, which may need fewer vertices.
    /// If it already did, the first search restarts in its wider region with other samples;
    /// otherwise it is over.
    fn overflow(&mut self) {
        if self.run.condition >= RouteCondition::Leaning {
            self.run.activity = Activity::Over(Progress::Exhausted);
        } else if self.run.condition == RouteCondition::UpperBody {
            self.reset_trees();
            self.relax();
        } else if self.run.generation == 0 && self.run.renew() {
            self.reset_trees();
            self.connect_directly();
        } else {
            self.run.activity = Activity::Over(Progress::Full);
        }
    }

    /// Adds the next branch to its tree. The first branch that reaches the other tree makes a
    /// route; once all are added, new branches begin.
    fn merge(&mut self, context: &StageContext<'_>) {
        let Some(&Branch { kind, extension, end, .. }) = self.branches.all().get(self.joins.merged)
        else {
            return self.begin_branches(context.seed);
        };
        let tree = usize::from(extension.backward);
        let Some(tip) = kind.tip() else { return };
        let Some(tip) = self.add(self.joins.merged, (tree, tip), context) else {
            return self.overflow();
        };
        match (end, kind) {
            (Some(BranchEnd::Reached { is_upright }), BranchKind::Connect { other, .. }) => {
                self.forest.trees[tree][tip as usize].is_upright &= is_upright;
                return self.connect(tree, tip, other);
            }
            (end, BranchKind::Follow { .. }) => self.end_leg(end, tip),
            (Some(BranchEnd::TooLong), _) => {}
            _ => self.joins.next.extend(join_after(
                (&self.forest, &self.run),
                &self.branches.all()[self.joins.merged],
                (tree, tip),
            )),
        }
        self.joins.merged += 1;
    }

    /// Adds a branch to its tree. Returns its tip; `None` if an arena is full.
    fn add(
        &mut self,
        branch: usize,
        (tree, mut tip): (usize, u32),
        context: &StageContext<'_>,
    ) -> Option<u32> {
        let branch = &self.branches.all()[branch];
        for candidate in &branch.grown {
            tip = self.forest.add((tree, tip), branch.extension.heading_offset, candidate)?;
            self.forest.label_edge((tree, tip), context);
        }
        Some(tip)
    }

    /// Labels the next edge of the route.
    fn label_next(&mut self, context: &StageContext<'_>) -> Progress {
        let GuideRoute { vertices, labels, .. } = &mut self.route;
        let next = labels.len();
        let before = next.checked_sub(1).and_then(|index| context.pair_of(&mut vertices[index]));
        let pair = context.pair_of(&mut vertices[next]);
        let label = before
            .zip(pair)
            .map_or(Label::Indeterminate, |(from, to)| context.label_between(&from, &to));
        labels.push(if label == Label::Indeterminate && vertices[next].is_traversed {
            Label::Traversed
        } else {
            label
        });
        if labels.len() < vertices.len() {
            return Progress::Growing;
        }
        self.run.activity = Activity::Over(Progress::Route);
        Progress::Route
    }

    /// Makes the route from the start over two connected vertices to the goal.
    fn connect(&mut self, tree: usize, tip: u32, other: u32) {
        let tips = if tree == 0 { [tip, other] } else { [other, tip] };
        self.route.clear();
        push_branch(&self.forest.trees[0], tips[0], &mut self.route.vertices);
        self.route.vertices.reverse();
        push_branch(&self.forest.trees[1], tips[1], &mut self.route.vertices);
        let is_straight = self.run.samples == 0
            && !self.run.path.is_begun()
            && self.run.condition == RouteCondition::UpperBody;
        self.clear_branches();
        self.shortcuts = RouteShortcuts::default();
        self.run.activity =
            if is_straight { Activity::Over(Progress::Route) } else { Activity::Shortcutting };
    }

    /// Inserts the shortcuts found, and begins the next ones.
    fn shortcut_route(&mut self, seed: u64) {
        let extension = self.extension(0, self.run.ends[1].pose, self.run.heading_offset, true);
        let Self { forest, branches, route, shortcuts, run, .. } = self;
        if shortcuts.advance((forest, branches, route), extension, (seed, run.generation)) {
            run.activity = Activity::Over(Progress::Route);
        }
    }
}
