//! Straightening a route: branches that grow between two of its stations take the place of longer ways [Grey 4.3].

use super::{Activity, Branch, Growth, Progress};
use crate::possibility::extension::{Extension, Step};
use crate::random::{Random, Stream};

/// Shortcuts that are tried on a route of up to [`SHORTCUT_SPAN_MAX`] stations, each by one extension.
const SHORTCUTS_MAX: usize = 12;
/// The same on a longer route, for each [`SHORTCUT_SPAN_MAX`] of its stations: it has turned more often than it need.
const LONG_SHORTCUTS_MAX: usize = 36;
/// Shortcuts span at most this many stations, on a longer route half as many: about as far on average as where its end limits them.
const SHORTCUT_SPAN_MAX: usize = 96;
/// Shortcuts span at least this many stations.
const SHORTCUT_SPAN_MIN: usize = 3;

impl Growth {
    pub(super) fn next_shortcut(&mut self, seed: u64, tried: u32) {
        let stations = self.route.vertices.len();
        let (span_max, tries_max) = if stations > SHORTCUT_SPAN_MAX {
            (SHORTCUT_SPAN_MAX / 2, LONG_SHORTCUTS_MAX * stations.div_ceil(SHORTCUT_SPAN_MAX))
        } else {
            (SHORTCUT_SPAN_MAX, SHORTCUTS_MAX)
        };
        if tried as usize >= tries_max || stations <= SHORTCUT_SPAN_MIN {
            self.activity = Activity::Over(Progress::Route);
            return;
        }
        let mut random = Random::new(seed, Stream::Possibility, u64::from(tried) | 1 << 40, self.generation);
        let from = random.below(stations - SHORTCUT_SPAN_MIN);
        let to = from + SHORTCUT_SPAN_MIN + random.below((stations - from).min(span_max) - SHORTCUT_SPAN_MIN);
        let (first, tip) = (self.trees[0].len() as u32, self.route.vertices[from]);
        self.activity = Activity::Straightening { tried: tried + 1, branch: Some(Branch { from, to, first, tip }) };
    }

    pub(super) fn shortcut(&self, branch: &Branch) -> Extension {
        self.extension(0, self.route.vertices[branch.to].station, self.facing, true)
    }

    /// Whether a branch may end with fewer stations than the route has there.
    pub(super) fn may_be_shorter(&self, branch: &Branch) -> bool {
        let grown = self.trees[0].len() - branch.first as usize;
        grown + self.shortcut(branch).stations_left(&branch.tip.station) + 1 < branch.to - branch.from
    }

    pub(super) fn straightened(&mut self, tried: u32, mut branch: Branch, step: Step) {
        self.activity = match step {
            Step::Grown(stance) if !self.is_given_up(&stance.station) && self.add((0, 0), self.facing, &stance).is_some() => {
                branch.tip = self.trees[0][self.trees[0].len() - 1];
                Activity::Straightening { tried, branch: Some(branch) }
            }
            Step::Arrived { is_upright } => {
                self.splice(&branch, is_upright);
                Activity::Straightening { tried, branch: None }
            }
            _ => Activity::Straightening { tried, branch: None },
        };
    }

    /// Puts a branch of the first tree in place of the stations between its ends.
    fn splice(&mut self, branch: &Branch, is_upright: bool) {
        self.spare.clear();
        self.spare.extend_from_slice(&self.route.vertices[..=branch.from]);
        self.spare.extend_from_slice(&self.trees[0][branch.first as usize..]);
        let joined = self.spare.len();
        self.spare.extend_from_slice(&self.route.vertices[branch.to..]);
        self.spare[joined].is_crossed = false;
        self.spare[joined].is_upright &= is_upright;
        std::mem::swap(&mut self.spare, &mut self.route.vertices);
    }
}
