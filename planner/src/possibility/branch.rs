//! Branches of Gamma_P that grow side by side: each by itself until it ends, then all of them become part of the trees, in order.

use super::extension::{Extension, Step, Tip};
use super::stance::{Context, Placed, ScratchOfFeet, Stance};
use super::station::Station;
use super::tree::{Vertex, tip_at};
use crate::allowance::{self, Allowance, Piece};
use crate::arena::reserve;
use crate::foot_placement::{FootPlacementConfig, Scratch};

/// Branches that grow side by side.
pub(super) const BRANCHES_MAX: usize = 8;
/// Stations of one branch.
const STATIONS_MAX: usize = 97;

/// What a branch is for.
#[derive(Debug, Clone, Copy)]
pub(super) enum Purpose {
    /// To reach a sample, from a vertex of a tree.
    Sample { tip: u32 },
    /// To meet the other tree at a vertex of it, from a vertex of a tree.
    Meet { tip: u32, met: u32 },
    /// To take the place of the route between two of its stations.
    Shortcut { from: usize, to: usize },
}

/// How a branch ended.
#[derive(Debug, Clone, Copy)]
pub(super) enum End {
    /// On its target.
    Arrived {
        /// Whether the upright robot has room on the last piece of the way.
        is_upright: bool,
    },
    /// It cannot go on.
    Blocked,
    /// It has as many stations as it may have.
    Long,
}

/// A branch that is to be grown.
#[derive(Debug)]
pub(super) struct Begin {
    pub purpose: Purpose,
    pub extension: Extension,
    pub from: Vertex,
    /// It ends where it will have as many stations.
    pub stations_max: usize,
}

/// A branch.
#[derive(Debug)]
pub(super) struct Branch {
    pub purpose: Purpose,
    pub extension: Extension,
    /// What has grown, from the vertex that it began at.
    pub grown: Vec<Stance>,
    pub end: Option<End>,
    from: Vertex,
    stations_max: usize,
    /// Names its random stream.
    name: u64,
    scratch: Scratch,
    allowance: Allowance,
}

impl Piece for Branch {
    fn has_ended(&self) -> bool {
        self.end.is_some()
    }

    fn allowance(&mut self) -> &mut Allowance {
        &mut self.allowance
    }
}

impl Branch {
    fn new(placement: &FootPlacementConfig) -> Self {
        let nowhere = Station { position: glam::DVec3::ZERO, yaw: 0.0 };
        let extension = Extension { target: nowhere, backward: false, facing: 0.0, joins: false, relaxed: false, spacing: 0.0 };
        Self {
            purpose: Purpose::Sample { tip: 0 },
            extension,
            grown: reserve(STATIONS_MAX),
            end: Some(End::Blocked),
            from: Vertex::root(nowhere, None),
            stations_max: 0,
            name: 0,
            scratch: Scratch::new(placement),
            allowance: Allowance::default(),
        }
    }

    /// Grows by a station, or ends; with a `helper` the placements of both feet are found side by side.
    fn advance(
        &mut self,
        (context, placements): (&Context<'_>, &[Placed]),
        is_barred: &impl Fn(&Station) -> bool,
        helper: Option<&mut Scratch>,
    ) {
        let tip = match self.grown.last() {
            Some(stance) => Tip { station: &stance.station, placements: &stance.placements },
            None => tip_at(&self.from, placements),
        };
        if self.grown.len() == STATIONS_MAX || self.grown.len() + self.extension.stations_left(tip.station) >= self.stations_max {
            self.end = Some(End::Long);
            return;
        }
        let name = self.name << 7 | self.grown.len() as u64;
        let mut scratch = match helper {
            Some(helper) => ScratchOfFeet::Each([&mut self.scratch, helper]),
            None => ScratchOfFeet::Shared(&mut self.scratch),
        };
        match self.extension.step(context, tip, name, &mut scratch) {
            Step::Grown(stance) if !is_barred(&stance.station) => self.grown.push(stance),
            Step::Grown(_) | Step::Blocked => self.end = Some(End::Blocked),
            Step::Arrived { is_upright } => self.end = Some(End::Arrived { is_upright }),
        }
    }
}

/// Branches that grow side by side, allocated once.
#[derive(Debug)]
pub(super) struct Branches {
    branches: Vec<Branch>,
    count: usize,
    /// For the other foot of a branch that grows alone.
    helper: Scratch,
    /// How many were ever begun.
    begun: u64,
}

impl Branches {
    /// None yet.
    pub fn new(placement: &FootPlacementConfig) -> Self {
        Self { branches: (0..BRANCHES_MAX).map(|_| Branch::new(placement)).collect(), count: 0, helper: Scratch::new(placement), begun: 0 }
    }

    /// Forgets all branches.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Begins another one. There must be room for it.
    pub fn begin(&mut self, begin: Begin) {
        let branch = &mut self.branches[self.count];
        let Begin { purpose, extension, from, stations_max } = begin;
        (branch.purpose, branch.extension, branch.from, branch.stations_max) = (purpose, extension, from, stations_max);
        (branch.name, branch.end) = (self.begun, None);
        branch.grown.clear();
        self.begun += 1;
        self.count += 1;
    }

    /// All of them, in order.
    pub fn all(&self) -> &[Branch] {
        &self.branches[..self.count]
    }

    /// Grows them by at most so many stations together, none where it is barred; answers how many units of work that took. Less than the
    /// budget means that all have ended.
    pub fn advance(
        &mut self,
        context: &Context<'_>,
        placements: &[Placed],
        is_barred: impl Fn(&Station) -> bool + Sync,
        budget: u64,
    ) -> u64 {
        let site = (context, placements);
        let several = context.threads.count().min(2);
        let grow = |branch: &mut Branch| branch.advance(site, &is_barred, None);
        let mut spent = 0;
        while spent < budget {
            let branches = &mut self.branches[..self.count];
            let mut growing = branches.iter_mut().filter(|branch| !branch.has_ended());
            spent += match (growing.next(), growing.next()) {
                (None, _) => break,
                (Some(alone), None) if several > 1 => {
                    alone.advance(site, &is_barred, Some(&mut self.helper));
                    1
                }
                _ => allowance::advance_several(branches, several, budget - spent, context.threads, grow),
            };
        }
        spent
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        let bytes = |branch: &Branch| branch.grown.capacity() * size_of::<Stance>() + branch.scratch.heap_bytes();
        self.branches.iter().map(bytes).sum::<usize>() + self.helper.heap_bytes()
    }
}
