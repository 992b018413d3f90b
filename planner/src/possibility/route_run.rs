//! The state of one search for a guide route, or for a detour.

use crate::geometry::bvh::Aabb;
use crate::possibility::coarse_path::CoarsePath;
use crate::possibility::route_condition::RouteCondition;
use crate::possibility::tree::Vertex;
use crate::possibility::tuning::{BRANCHES_MAX, LEANING_SAMPLES_DIVISOR, WIDENINGS_MAX};
use crate::possibility::vertex_sampling::{bounds_around, is_short, samples_max, widened};

/// Result of an advance of the search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// There is more to do.
    Growing,
    /// There is a guide route.
    Route,
    /// All samples are spent without a route.
    Exhausted,
    /// The arena is full without a route.
    Full,
}

/// Current activity of the search.
#[derive(Debug, Clone, Copy)]
pub enum Activity {
    /// Growing branches of the trees.
    Growing,
    /// Trying shortcuts of the route.
    Shortcutting,
    /// Choosing the least lean at the vertices of the route, one after the other.
    ReducingLean {
        /// Number of vertices done, in all passes.
        done: usize,
    },
    /// Labelling the edges of the route.
    Labelling,
    /// Nothing more to do.
    Over(Progress),
}

/// A branch from vertex `tip` of a tree toward a vertex of the other one.
#[derive(Debug, Clone, Copy)]
pub struct Join {
    /// The tree that grows.
    pub tree: usize,
    /// The vertex from which it grows.
    pub tip: u32,
    /// The vertex of the other tree toward which it grows.
    pub other: u32,
    /// Heading of the robot relative to the walking direction, rad.
    pub heading_offset: f64,
}

/// The state of the merge of ended branches, and the branches that follow them.
#[derive(Debug, Default)]
pub struct Joins {
    /// Number of ended branches that are part of the trees.
    pub merged: usize,
    /// Branches toward the other tree that begin next.
    pub next: heapless::Vec<Join, BRANCHES_MAX>,
}

/// One search for a route or for a detour.
#[derive(Debug)]
pub struct Run {
    /// Current activity.
    pub activity: Activity,
    /// The roots of the trees: start and goal, or both ends of a detour.
    pub ends: [Vertex; 2],
    /// The region in which samples are drawn (world, m).
    pub bounds: Aabb,
    /// Number of samples drawn.
    pub samples: u32,
    /// What vertices and edges must satisfy.
    pub condition: RouteCondition,
    /// Heading offset of the robot unless it sidesteps, rad.
    pub heading_offset: f64,
    /// Number of searches before, part of the random streams' names.
    pub generation: u64,
    /// Number of searches before for a route from start to goal.
    pub restarts: u64,
    /// How often the region was widened, part of the random streams' names.
    pub widenings: u32,
    /// The region that the first search reached, if it was widened (world, m).
    pub wide_region: Option<Aabb>,
    /// The coarse path that the tree of the start follows.
    pub path: CoarsePath,
    /// The conditions that may follow the first two.
    pub later: LaterConditions,
}

/// The conditions that may follow those under which the root is upright.
#[derive(Debug, Clone, Copy)]
pub struct LaterConditions {
    /// Whether the region may become wider before they follow.
    pub may_widen: bool,
    /// Whether routes under C_N alone are searched.
    pub has_necessary: bool,
    /// Whether routes along which the root leans are searched.
    pub has_leaning: bool,
    /// Whether such a route was searched before.
    pub has_leant: bool,
    /// Whether only those are searched, beside a route that is known.
    pub leans_only: bool,
}

impl Run {
    /// A search between two ends (start and goal) that has not begun, in a region. Allocates.
    pub fn new(ends: [Vertex; 2], bounds: Aabb) -> Self {
        Self {
            activity: Activity::Growing,
            ends,
            bounds,
            samples: 0,
            condition: RouteCondition::UpperBody,
            heading_offset: 0.0,
            generation: 0,
            restarts: 0,
            widenings: 0,
            wide_region: None,
            path: CoarsePath::new(),
            later: LaterConditions {
                may_widen: true,
                has_necessary: true,
                has_leaning: true,
                has_leant: false,
                leans_only: false,
            },
        }
    }

    /// Begins with two roots inside `world` (m), in the region that the first search reached if
    /// it is a search for another route, or around both roots.
    pub fn begin(&mut self, ends: [Vertex; 2], world: &Aabb, is_detour: bool) {
        self.ends = ends;
        let known = self.wide_region.filter(|_| !is_detour);
        self.bounds =
            known.unwrap_or_else(|| bounds_around(ends.map(|end| end.pose.position), world));
        (self.samples, self.condition, self.widenings) = (0, RouteCondition::UpperBody, 0);
        self.later.leans_only = false;
    }

    /// The condition that follows where no route meets the current one; none if it is the last.
    /// The first search fails without C_N alone: a straight line is tried first. A detour fails
    /// without it too: another route is cheaper. The root leans if the first search has shown that
    /// no upright route is free, or a route that its trunk is not.
    pub fn next_condition(&self, is_detour: bool, may_lean: bool) -> Option<RouteCondition> {
        let LaterConditions { has_necessary, has_leaning, has_leant, leans_only, .. } = self.later;
        let may_lean = may_lean && has_leaning && (has_leant || self.generation == 0);
        let may_be_necessary = self.generation > 0 && !is_detour && has_necessary && !leans_only;
        match self.condition {
            RouteCondition::UpperBody => Some(RouteCondition::Root),
            RouteCondition::Root if may_lean => Some(RouteCondition::Leaning),
            RouteCondition::Root | RouteCondition::Leaning if may_be_necessary => {
                Some(RouteCondition::Necessary)
            }
            RouteCondition::Root | RouteCondition::Leaning | RouteCondition::Necessary => None,
        }
    }

    /// Continues in a wider region, first under the strictest condition again. Returns `false` if
    /// the region is the whole world.
    pub fn widen(&mut self, world: &Aabb) -> bool {
        let bounds = widened(&self.bounds, world);
        let is_wider = bounds != self.bounds;
        if is_wider {
            (self.samples, self.condition) = (0, RouteCondition::UpperBody);
            self.widenings += 1;
            self.bounds = bounds;
            self.wide_region = Some(bounds);
        }
        is_wider
    }

    /// Begins anew in the same region with other samples. Returns `false` after
    /// [`WIDENINGS_MAX`] attempts.
    pub fn renew(&mut self) -> bool {
        let may_renew = (1..WIDENINGS_MAX).contains(&self.widenings);
        if may_renew {
            (self.samples, self.condition) = (0, RouteCondition::UpperBody);
            self.widenings += 1;
        }
        may_renew
    }

    /// Name of the random streams of this search and its region.
    pub fn stream(&self) -> u64 {
        u64::from(self.widenings) << 32 | self.generation
    }

    /// Names the condition in the random streams of samples.
    pub fn stream_bits(&self) -> u64 {
        match self.condition {
            RouteCondition::UpperBody => 0,
            RouteCondition::Root => 1,
            RouteCondition::Leaning => 1 << 47,
            RouteCondition::Necessary => 1 << 48,
        }
    }

    /// Most samples under the condition.
    pub fn samples_max(&self) -> u32 {
        let all = samples_max(&self.bounds);
        if self.condition == RouteCondition::Leaning { all / LEANING_SAMPLES_DIVISOR } else { all }
    }

    /// Whether the robot may sidestep: once half of the samples are spent. In a long region only
    /// after stage M has rejected a route, because the condition is relaxed first: places where
    /// arms collide are more frequent than passages narrower than the shoulders.
    pub fn may_sidestep(&self) -> bool {
        let is_late = 2 * self.samples >= samples_max(&self.bounds);
        is_late && (self.generation > 0 || is_short(&self.bounds))
    }
}

/// A detour that is searched.
#[derive(Debug)]
pub struct Detour {
    /// The route of which the detour replaces a part.
    pub full_route: Vec<Vertex>,
    /// The vertices between which it replaces the route; none while a whole route is searched.
    pub between: Option<[usize; 2]>,
}
