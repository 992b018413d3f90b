//! Shortcuts of a route: branches between two of its vertices replace longer paths [Grey 4.3].

use crate::base::random::{Random, Stream};
use crate::possibility::branch::{BRANCHES_MAX, Branch, BranchEnd, BranchKind, BranchRequest};
use crate::possibility::route_search::{Activity, Progress, RouteSearch};

/// Shortcuts that are tried in parallel, on a short and on a long route. Of those that overlap at
/// most one is taken.
const PARALLEL_SHORTCUTS: [usize; 2] = [2, BRANCHES_MAX];
/// Shortcuts that are tried on a route of up to [`SHORTCUT_SPAN_MAX`] vertices, each by one
/// extension.
const SHORTCUTS_MAX: usize = 12;
/// The same on a longer route, for each [`SHORTCUT_SPAN_MAX`] of its vertices.
const LONG_SHORTCUTS_MAX: usize = 36;
/// Most vertices that a shortcut spans; half as many on a longer route, which is about the average
/// on a short one.
const SHORTCUT_SPAN_MAX: usize = 96;
/// Fewest vertices that a shortcut spans.
const SHORTCUT_SPAN_MIN: usize = 3;

impl RouteSearch {
    /// Inserts the shortcuts that reached their target and begins the next ones.
    pub(crate) fn shortcut_route(&mut self, seed: u64, tried: usize) {
        self.splice_all();
        self.branches.clear();
        let vertex_count = self.route.vertices.len();
        let is_long = vertex_count > SHORTCUT_SPAN_MAX;
        let (span_max, tries_max) = if is_long {
            (SHORTCUT_SPAN_MAX / 2, LONG_SHORTCUTS_MAX * vertex_count.div_ceil(SHORTCUT_SPAN_MAX))
        } else {
            (SHORTCUT_SPAN_MAX, SHORTCUTS_MAX)
        };
        if tried >= tries_max || vertex_count <= SHORTCUT_SPAN_MIN {
            self.activity = Activity::Over(Progress::Route);
            return;
        }
        let next = tries_max.min(tried + PARALLEL_SHORTCUTS[usize::from(is_long)]);
        (tried..next).for_each(|index| self.begin_shortcut(seed, index, span_max));
        self.activity = Activity::Shortcutting { tried: next };
    }

    fn begin_shortcut(&mut self, seed: u64, index: usize, span_max: usize) {
        let vertex_count = self.route.vertices.len();
        let mut random =
            Random::new(seed, Stream::Possibility, index as u64 | 1 << 40, self.generation);
        let from = random.below(vertex_count - SHORTCUT_SPAN_MIN);
        let to = from
            + SHORTCUT_SPAN_MIN
            + random.below((vertex_count - from).min(span_max) - SHORTCUT_SPAN_MIN);
        let extension = self.extension(0, self.route.vertices[to].pose, self.heading_offset, true);
        let vertices_max = to - from - 1;
        self.branches.begin(BranchRequest {
            kind: BranchKind::Shortcut { from, to },
            extension,
            from: self.route.vertices[from],
            vertices_max,
        });
    }

    /// Replaces the vertices between the ends of each branch that reached its target, from the last
    /// to the first. A branch that overlaps an inserted one is skipped.
    fn splice_all(&mut self) {
        let mut end = usize::MAX;
        loop {
            let arrived = |(index, branch): (usize, &Branch)| match (branch.kind, branch.end) {
                (BranchKind::Shortcut { from, to }, Some(BranchEnd::Reached { is_upright }))
                    if to <= end =>
                {
                    Some((from, to, index, is_upright))
                }
                _ => None,
            };
            let Some((from, to, index, is_upright)) =
                self.branches.all().iter().enumerate().filter_map(arrived).max()
            else {
                return;
            };
            end = from;
            self.splice([from, to], index, is_upright);
        }
    }

    /// Replaces the vertices between a branch's ends by the branch, if its placements fit.
    fn splice(&mut self, [from, to]: [usize; 2], branch: usize, is_upright: bool) {
        let first = self.forest.trees[0].len();
        for candidate in &self.branches.all()[branch].grown {
            if self.forest.add((0, 0), self.heading_offset, candidate).is_none() {
                return;
            }
        }
        self.spare.clear();
        self.spare.extend_from_slice(&self.route.vertices[..=from]);
        self.spare.extend_from_slice(&self.forest.trees[0][first..]);
        let joined = self.spare.len();
        self.spare.extend_from_slice(&self.route.vertices[to..]);
        self.spare[joined].is_traversed = false;
        self.spare[joined].is_upright &= is_upright;
        std::mem::swap(&mut self.spare, &mut self.route.vertices);
    }
}
