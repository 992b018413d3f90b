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
use crate::possibility::edge_labels::Label;
use crate::possibility::extension::Extension;
use crate::possibility::forest::{Forest, LabelStats};
use crate::possibility::guide_route::GuideRoute;
use crate::possibility::mid_feet_pose::MidFeetPose;
use crate::possibility::route_condition::RouteCondition;
use crate::possibility::route_run::{Activity, Detour, Join, Joins, Progress, Run};
use crate::possibility::route_shortcuts::RouteShortcuts;
use crate::possibility::tree::{Vertex, push_branch};
use crate::possibility::tuning::{
    BACKWARD_EVERY, BRANCHES_MAX, PARALLEL_BRANCHES_MIN, SAMPLES_PER_BRANCH, STRAIGHT_END_DISTANCE,
};
use crate::possibility::vertex_candidates::StageContext;
use crate::possibility::vertex_sampling::{BACKWARD, SIDES, SampleRequest, sample, samples_max};

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
    joins: Joins,
    run: Run,
    route: GuideRoute,
    shortcuts: RouteShortcuts,
    detour: Detour,
    blocked: BlockedRegions,
    /// The part of the route from the start that stage M has solved.
    traversed: Vec<Vertex>,
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
            run: Run {
                activity: Activity::Growing,
                ends: endpoints,
                bounds: *world,
                samples: 0,
                condition: RouteCondition::UpperBody,
                heading_offset: 0.0,
                generation: 0,
                restarts: 0,
                widenings: 0,
                has_necessary: true,
            },
            route: GuideRoute::new(ends, walking_width, vertices_max),
            shortcuts: RouteShortcuts::default(),
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
        self.route.clear();
        let [mut at, goal] = self.run.ends.map(|end| end.pose);
        let count_max = self.route.vertices.capacity() - 1;
        while self.route.vertices.len() < count_max && at.distance(&goal) > STRAIGHT_END_DISTANCE {
            self.route.vertices.push(Vertex { is_upright: false, ..Vertex::root(at, None) });
            let spacing = self.region.spacing;
            at = at.step_toward(&goal, spacing, 0.0);
            at.position.z += (goal.position.z - at.position.z)
                * (spacing / at.horizontal_offset_to(&goal).length().max(spacing));
        }
        self.route.vertices.push(Vertex::root(goal, None));
        self.route.labels.resize(self.route.vertices.len(), Label::Indeterminate);
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

    /// Searches no routes under C_N alone.
    pub fn leave_out_necessary(&mut self) {
        self.run.has_necessary = false;
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
        self.detour.full_route.extend_from_slice(&self.route.vertices);
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        let vertices = self.detour.full_route.capacity() + self.traversed.capacity();
        vertices * size_of::<Vertex>()
            + self.route.bytes()
            + self.forest.bytes()
            + self.branches.bytes()
    }

    /// Spends at most `budget` work units, each one vertex that is tried. Returns the progress and
    /// the work spent.
    pub fn advance(&mut self, context: &StageContext<'_>, budget: u64) -> (Progress, u64) {
        if matches!(self.run.activity, Activity::Labelling) {
            return (self.label_next(context), 1);
        }
        let Self { forest, branches, blocked, .. } = self;
        let is_blocked = |pose: &MidFeetPose| blocked.contains(pose);
        let spent = branches.advance(context, &forest.placements, is_blocked, budget);
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
            Activity::Labelling | Activity::Over(_) => {}
        }
        let Activity::Over(progress) = self.run.activity else { return Progress::Growing };
        if progress != Progress::Route {
            return progress;
        }
        if let Some(between) = self.detour.between.take() {
            self.route.insert_into(&mut self.detour.full_route, between);
        }
        self.route.labels.clear();
        self.run.activity = Activity::Labelling;
        Progress::Growing
    }

    /// Begins a search between two ends with a straight branch from the start, or from the farthest
    /// vertex that stage M has reached, to the goal.
    fn begin(&mut self, ends: [Vertex; 2]) {
        self.run.begin(ends, &self.region.world);
        self.reset_trees();
        self.connect_directly();
    }

    /// Resets the trees to their roots and the traversed part of the route.
    fn reset_trees(&mut self) {
        self.forest.placements.clear();
        self.route.vertices.iter_mut().for_each(|vertex| vertex.placements = (0, 0));
        for (tree, &end) in self.forest.trees.iter_mut().zip(&self.run.ends) {
            tree.set(&[Vertex { parent: 0, ..end }]);
        }
        self.reuse_traversed();
    }

    /// Begins a straight branch to the goal from the vertex nearest to it.
    fn connect_directly(&mut self) {
        self.run.activity = Activity::Growing;
        self.clear_branches();
        let goal = self.run.ends[1].pose;
        let tip = self.forest.trees[0].nearest(|pose| pose.distance(&goal));
        self.join(Join { tree: 0, tip, other: 0, heading_offset: self.run.heading_offset });
    }

    /// Makes the traversed part of the route the tree of the start, unless a detour is searched.
    fn reuse_traversed(&mut self) {
        if self.detour.between.is_none() && !self.traversed.is_empty() {
            self.forest.trees[0].set(&self.traversed);
        }
    }

    /// Begins a branch from a vertex of a tree toward a vertex of the other tree.
    fn join(&mut self, Join { tree, tip, other, heading_offset }: Join) {
        let target = self.forest.trees[1 - tree][other as usize].pose;
        let extension = self.extension(tree, target, heading_offset, true);
        self.grow(
            BranchKind::Connect { tip, other },
            extension,
            self.forest.trees[tree][tip as usize],
        );
    }

    /// Begins a branch without a limit of its vertices.
    fn grow(&mut self, kind: BranchKind, extension: Extension, from: Vertex) {
        self.branches.begin(BranchRequest { kind, extension, from, vertices_max: usize::MAX });
    }

    /// The extension of a branch of a tree toward a target.
    fn extension(
        &self,
        tree: usize,
        target: MidFeetPose,
        heading_offset: f64,
        joins: bool,
    ) -> Extension {
        Extension {
            target,
            backward: tree == 1,
            heading_offset,
            joins,
            condition: self.run.condition,
            spacing: self.region.spacing,
        }
    }

    /// Removes the branches that have ended. Returns the joins that follow them.
    fn clear_branches(&mut self) -> heapless::Vec<Join, BRANCHES_MAX> {
        self.branches.clear();
        std::mem::take(&mut self.joins).next
    }

    /// Begins the next branches: the joins, and branches toward samples, whose number grows with
    /// the samples drawn. The first joins grow alone, because a straight route needs no samples.
    fn begin_branches(&mut self, seed: u64) {
        let joins = self.clear_branches();
        joins.iter().for_each(|&join| self.join(join));
        let is_first = self.run.samples == 0 && !joins.is_empty();
        let count_max = if is_first {
            0
        } else {
            (PARALLEL_BRANCHES_MIN + (self.run.samples / SAMPLES_PER_BRANCH) as usize)
                .min(BRANCHES_MAX)
        };
        while self.branches.len() < count_max && self.run.samples < samples_max(&self.run.bounds) {
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
        let extension = self.extension(tree, target, heading_offset, false);
        self.grow(BranchKind::Sample { tip }, extension, self.forest.trees[tree][tip as usize]);
    }

    /// No route meets the condition: the search continues under the next one, with the same trees.
    /// The first search continues in a wider region, up to the whole world, and fails without C_N
    /// alone: a straight line is tried first. A detour fails without it too: another route is
    /// cheaper.
    fn relax(&mut self) {
        let is_first = self.run.generation == 0;
        let condition = self.run.condition;
        let next = match condition {
            RouteCondition::UpperBody => RouteCondition::Root,
            RouteCondition::Root if is_first && self.run.widen(&self.region.world) => return,
            RouteCondition::Root
                if !is_first && self.detour.between.is_none() && self.run.has_necessary =>
            {
                RouteCondition::Necessary
            }
            RouteCondition::Root | RouteCondition::Necessary => {
                self.run.activity = Activity::Over(Progress::Exhausted);
                return;
            }
        };
        (self.run.condition, self.run.samples) = (next, 0);
        self.connect_directly();
    }

    /// A tree is full: the search restarts under the next condition, which may need fewer vertices.
    /// If it already did, the first search restarts in its wider region with other samples;
    /// otherwise it is over.
    fn overflow(&mut self) {
        if self.run.condition == RouteCondition::Necessary {
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
        let (BranchKind::Sample { tip } | BranchKind::Connect { tip, .. }) = kind else { return };
        let Some(tip) = self.add(self.joins.merged, (tree, tip), context) else {
            return self.overflow();
        };
        match (end, kind) {
            (Some(BranchEnd::Reached { is_upright }), BranchKind::Connect { other, .. }) => {
                self.forest.trees[tree][tip as usize].is_upright &= is_upright;
                return self.connect(tree, tip, other);
            }
            (Some(BranchEnd::TooLong), _) => {}
            _ => self.joins.next.extend(self.join_after(self.joins.merged, (tree, tip))),
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

    /// The join that follows a branch that ended at a tip. After a branch toward a sample, or the
    /// first branch, the other tree grows toward its tip. After a branch toward the other tree with
    /// the heading offset of the route, it is tried again with a sidestep.
    fn join_after(&self, branch: usize, (tree, tip): (usize, u32)) -> Option<Join> {
        let Branch { kind, extension, ref grown, .. } = self.branches.all()[branch];
        if let BranchKind::Connect { other, .. } = kind
            && extension.heading_offset == self.run.heading_offset
            && self.run.may_sidestep()
        {
            let heading_offset = SIDES[self.run.samples as usize / 2 % SIDES.len()];
            return Some(Join { tree, tip, other, heading_offset });
        }
        let reaches_out = !grown.is_empty()
            && (matches!(kind, BranchKind::Sample { .. }) || self.run.samples == 0 && tree == 0);
        reaches_out.then(|| {
            let Vertex { pose: at, heading_offset, .. } = self.forest.trees[tree][tip as usize];
            let other_tree = &self.forest.trees[1 - tree];
            let near = other_tree.nearest(|pose| pose.distance(&at));
            let is_alike = other_tree[near as usize].heading_offset == heading_offset;
            Join {
                tree: 1 - tree,
                tip: near,
                other: tip,
                heading_offset: if is_alike { heading_offset } else { self.run.heading_offset },
            }
        })
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
        let is_straight = self.run.samples == 0 && self.run.condition == RouteCondition::UpperBody;
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
