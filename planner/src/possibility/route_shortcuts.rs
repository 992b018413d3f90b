//! Shortcuts of a guide route: branches between two of its vertices replace longer parts
//! [Grey 4.3].

use crate::base::random::{Random, Stream};
use crate::possibility::branch::{Branch, BranchEnd, BranchKind, BranchRequest, Branches};
use crate::possibility::extension::Extension;
use crate::possibility::forest::Forest;
use crate::possibility::guide_route::GuideRoute;
use crate::possibility::route_condition::RouteCondition;
use crate::possibility::tuning::{
    LONG_SHORTCUTS_MAX, PARALLEL_SHORTCUTS, SHORTCUT_DRAWS, SHORTCUT_SPAN_MAX, SHORTCUT_SPAN_MIN,
    SHORTCUTS_MAX,
};
use crate::possibility::vertex_sampling::SIDES;

/// The trees, the branches and the route that shortcuts use.
type Parts<'a> = (&'a mut Forest, &'a mut Branches, &'a mut GuideRoute);

/// Shortcuts of a route.
#[derive(Debug, Default)]
pub struct RouteShortcuts {
    /// Number of shortcuts tried.
    tried: usize,
}

impl RouteShortcuts {
    /// Inserts the shortcuts that reached their target, and begins the next ones. Each is extended
    /// like `extension`, to its own target. `name` holds the seed and the generation of the random
    /// stream. Returns whether all are tried.
    pub fn advance(
        &mut self,
        (forest, branches, route): Parts<'_>,
        extension: Extension,
        name: (u64, u64),
    ) -> bool {
        splice_all((forest, branches, route));
        branches.clear();
        let vertex_count = route.vertex_count();
        let is_long = vertex_count > SHORTCUT_SPAN_MAX;
        let (span_max, tries_max) = if is_long {
            (SHORTCUT_SPAN_MAX / 2, LONG_SHORTCUTS_MAX * vertex_count.div_ceil(SHORTCUT_SPAN_MAX))
        } else {
            (SHORTCUT_SPAN_MAX, SHORTCUTS_MAX)
        };
        if self.tried >= tries_max || vertex_count <= SHORTCUT_SPAN_MIN {
            return true;
        }
        let next = tries_max.min(self.tried + PARALLEL_SHORTCUTS[usize::from(is_long)]);
        for index in self.tried..next {
            // A robot that leans has few ways, and the longest detour may be the one of them.
            let looks_at_route =
                !index.is_multiple_of(2) && extension.condition != RouteCondition::Leaning;
            let [from, to] = ends_of_shortcut(route, name, index, (span_max, looks_at_route));
            branches.begin(BranchRequest {
                kind: BranchKind::Shortcut { from, to },
                extension: Extension {
                    target: route.pose(to),
                    target_posture: route.vertices[to].posture,
                    heading_offset: sideways(route, [from, to])
                        .filter(|_| looks_at_route)
                        .unwrap_or(extension.heading_offset),
                    ..extension
                },
                from: route.vertices[from],
                vertices_max: to - from - 1,
            });
        }
        self.tried = next;
        false
    }
}

/// The random ends of a shortcut, as indices of route vertices. One that looks at the route has
/// those of several draws between which the route makes the longest detour: one loop in a long
/// route would else be met by chance.
fn ends_of_shortcut(
    route: &GuideRoute,
    (seed, generation): (u64, u64),
    index: usize,
    (span_max, looks_at_route): (usize, bool),
) -> [usize; 2] {
    let mut random = Random::new(seed, Stream::Possibility, index as u64 | 1 << 40, generation);
    let mut draw = || {
        let vertex_count = route.vertex_count();
        let from = random.below(vertex_count - SHORTCUT_SPAN_MIN);
        let span_most = (vertex_count - from).min(span_max);
        [from, from + SHORTCUT_SPAN_MIN + random.below(span_most - SHORTCUT_SPAN_MIN)]
    };
    let first = draw();
    if !looks_at_route {
        return first;
    }
    let (mut longest, mut ends_of_longest) = (detour(route, first), first);
    for _ in 1..SHORTCUT_DRAWS {
        let ends = draw();
        let length = detour(route, ends);
        if length > longest {
            (longest, ends_of_longest) = (length, ends);
        }
    }
    ends_of_longest
}

/// The heading relative to the walking direction (rad) of a part of the route that is walked
/// sideways; nothing if none is.
fn sideways(route: &GuideRoute, [from, to]: [usize; 2]) -> Option<f64> {
    let mut offsets = route.vertices[from + 1..=to].iter().map(|vertex| vertex.heading_offset);
    offsets.find(|offset| SIDES.contains(offset))
}

/// By how much the route between two of its vertices is longer than the straight line between
/// them, in the metric of Gamma_P, m.
fn detour(route: &GuideRoute, [from, to]: [usize; 2]) -> f64 {
    let along: f64 =
        route.vertices[from..=to].windows(2).map(|edge| edge[0].pose.distance(&edge[1].pose)).sum();
    along - route.pose(from).distance(&route.pose(to))
}

/// Replaces the vertices between the ends of branches that reached their target, from the last to
/// the first. A branch that overlaps an inserted one is skipped, and one where the upright robot
/// does not fit in place of a part where it does: shortcuts lead along walls, where the robot's
/// arms and legs do not fit.
fn splice_all((forest, branches, route): Parts<'_>) {
    let mut end = usize::MAX;
    loop {
        let reached = |(index, branch): (usize, &Branch)| match (branch.kind, branch.end) {
            (BranchKind::Shortcut { from, to }, Some(BranchEnd::Reached { is_upright }))
                if to <= end =>
            {
                let fits = is_upright && branch.grown.iter().all(|vertex| vertex.is_upright);
                (fits || !route.is_upright_between([from, to]))
                    .then_some((from, to, index, is_upright))
            }
            _ => None,
        };
        let Some((from, to, index, is_upright)) =
            branches.all().iter().enumerate().filter_map(reached).max()
        else {
            return;
        };
        end = from;
        splice(forest, &branches.all()[index], route, ([from, to], is_upright));
    }
}

/// Replaces the vertices between the ends of a branch, unless the placement arena is full.
fn splice(
    forest: &mut Forest,
    branch: &Branch,
    route: &mut GuideRoute,
    (ends, is_upright): ([usize; 2], bool),
) {
    let first = forest.trees[0].len();
    for candidate in &branch.grown {
        if forest.add((0, 0), branch.extension.heading_offset, candidate).is_none() {
            return;
        }
    }
    route.splice(ends, &forest.trees[0][first..], is_upright);
}
