//! Straightening a route: branches that grow between two of its stations take the place of longer
//! ways [Grey 4.3].

use super::{Activity, Begin, Branch, End, Growth, Progress, Purpose};
use crate::possibility::branch::BRANCHES_MAX;
use crate::random::{Random, Stream};

/// Shortcuts that are tried side by side; of those that overlap at most one is taken, so more of
/// them on a longer route.
const AT_ONCE: [usize; 2] = [2, BRANCHES_MAX];
/// Shortcuts that are tried on a route of up to [`SHORTCUT_SPAN_MAX`] stations, each by one
/// extension.
const SHORTCUTS_MAX: usize = 12;
/// The same on a longer route, for each [`SHORTCUT_SPAN_MAX`] of its stations: it has turned more
/// often than it need.
const LONG_SHORTCUTS_MAX: usize = 36;
/// Shortcuts span at most this many stations, on a longer route half as many: about as far on
/// average as where its end limits them.
const SHORTCUT_SPAN_MAX: usize = 96;
/// Shortcuts span at least this many stations.
const SHORTCUT_SPAN_MIN: usize = 3;

impl Growth {
    /// Takes those of the shortcuts that have arrived, and begins the next ones.
    pub(super) fn straighten(&mut self, seed: u64, tried: usize) {
        self.splice_all();
        self.branches.clear();
        let stations = self.route.vertices.len();
        let is_long = stations > SHORTCUT_SPAN_MAX;
        let (span_max, tries_max) = if is_long {
            (SHORTCUT_SPAN_MAX / 2, LONG_SHORTCUTS_MAX * stations.div_ceil(SHORTCUT_SPAN_MAX))
        } else {
            (SHORTCUT_SPAN_MAX, SHORTCUTS_MAX)
        };
        if tried >= tries_max || stations <= SHORTCUT_SPAN_MIN {
            self.activity = Activity::Over(Progress::Route);
            return;
        }
        let next = tries_max.min(tried + AT_ONCE[usize::from(is_long)]);
        (tried..next).for_each(|index| self.begin_shortcut(seed, index, span_max));
        self.activity = Activity::Straightening { tried: next };
    }

    fn begin_shortcut(&mut self, seed: u64, index: usize, span_max: usize) {
        let stations = self.route.vertices.len();
        let mut random =
            Random::new(seed, Stream::Possibility, index as u64 | 1 << 40, self.generation);
        let from = random.below(stations - SHORTCUT_SPAN_MIN);
        let to = from
            + SHORTCUT_SPAN_MIN
            + random.below((stations - from).min(span_max) - SHORTCUT_SPAN_MIN);
        let extension = self.extension(0, self.route.vertices[to].station, self.facing, true);
        let stations_max = to - from - 1;
        self.branches.begin(Begin {
            purpose: Purpose::Shortcut { from, to },
            extension,
            from: self.route.vertices[from],
            stations_max,
        });
    }

    /// Puts the branches that have arrived in place of the stations between their ends, from the
    /// last to the first, but for those that overlap one before.
    fn splice_all(&mut self) {
        let mut end = usize::MAX;
        loop {
            let arrived = |(index, branch): (usize, &Branch)| match (branch.purpose, branch.end) {
                (Purpose::Shortcut { from, to }, Some(End::Arrived { is_upright }))
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

    /// Puts a branch in place of the stations between its ends, if there is room for its
    /// placements.
    fn splice(&mut self, [from, to]: [usize; 2], branch: usize, is_upright: bool) {
        let first = self.forest.trees[0].len();
        for stance in &self.branches.all()[branch].grown {
            if self.forest.add((0, 0), self.facing, stance).is_none() {
                return;
            }
        }
        self.spare.clear();
        self.spare.extend_from_slice(&self.route.vertices[..=from]);
        self.spare.extend_from_slice(&self.forest.trees[0][first..]);
        let joined = self.spare.len();
        self.spare.extend_from_slice(&self.route.vertices[to..]);
        self.spare[joined].is_crossed = false;
        self.spare[joined].is_upright &= is_upright;
        std::mem::swap(&mut self.spare, &mut self.route.vertices);
    }
}
