//! Branches of Gamma_P that grow side by side: each by itself until it ends, then all of them
//! become part of the trees, in order.
//!
//! Where one is left alone and there are several threads, both feet's placements are looked for
//! side by side, and while the next station is, whether a step leads to the one before it. That is
//! taken for granted meanwhile: where it turns out to be wrong, the branch goes on from before as
//! if nothing had been looked for.

use super::extension::{Extension, Step};
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

/// Where a branch ends so far.
#[derive(Debug, Clone, Copy)]
pub struct Tip<'a> {
    /// The station.
    pub station: &'a Station,
    /// The placements there; none where they are not known.
    pub placements: &'a [Placed],
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
    /// The stride that led to the last one, where it is still to be asked whether a step does.
    unproven: Option<usize>,
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
        let extension = Extension {
            target: nowhere,
            backward: false,
            facing: 0.0,
            joins: false,
            relaxed: false,
            spacing: 0.0,
        };
        Self {
            purpose: Purpose::Sample { tip: 0 },
            extension,
            grown: reserve(STATIONS_MAX),
            end: Some(End::Blocked),
            unproven: None,
            from: Vertex::root(nowhere, None),
            stations_max: 0,
            name: 0,
            scratch: Scratch::new(placement),
            allowance: Allowance::default(),
        }
    }

    /// Grows by a station, by a stride from `first` on, or ends.
    fn grow(
        &mut self,
        (context, placements): (&Context<'_>, &[Placed]),
        is_barred: &impl Fn(&Station) -> bool,
        mut first: usize,
    ) {
        loop {
            let tip = tip_of(&self.from, &self.grown, placements);
            if self.is_long(tip.station) {
                self.end = Some(End::Long);
                return;
            }
            let name = self.name_of_step();
            let step = self.extension.step(
                context,
                tip.station,
                first,
                name,
                &mut ScratchOfFeet::Shared(&mut self.scratch),
            );
            match step {
                Step::Reached { stance, stride }
                    if !context.has_step_between(tip.placements, &stance.placements) =>
                {
                    first = stride + 1
                }
                step => return self.take(step, is_barred),
            }
        }
    }

    /// Grows by a station, or ends, the placements of both feet found side by side with a
    /// `helper`'s memory; meanwhile it is asked whether a step leads to the station before. Answers
    /// how many units of work that took: none where none does.
    fn grow_alone(
        &mut self,
        (context, placements): (&Context<'_>, &[Placed]),
        is_barred: &impl Fn(&Station) -> bool,
        helper: &mut Scratch,
    ) -> u64 {
        let tip = tip_of(&self.from, &self.grown, placements);
        let (is_long, name) = (self.is_long(tip.station), self.name_of_step());
        let scratch = &mut self.scratch;
        let look = || {
            (!is_long).then(|| {
                self.extension.step(
                    context,
                    tip.station,
                    0,
                    name,
                    &mut ScratchOfFeet::Each([scratch, helper]),
                )
            })
        };
        let leads = || {
            let before = self.unproven.and_then(|_| self.grown.split_last());
            before.is_none_or(|(_, before)| {
                context.has_step_between(
                    tip_of(&self.from, before, placements).placements,
                    tip.placements,
                )
            })
        };
        let (step, leads) = context.threads.both(look, leads);
        match (self.unproven.take(), step) {
            (Some(stride), _) if !leads => {
                self.grown.pop();
                self.grow((context, placements), is_barred, stride + 1);
                return 0;
            }
            (_, None) => self.end = Some(End::Long),
            (_, Some(Step::Reached { stance, stride })) if !is_barred(&stance.station) => {
                self.unproven = Some(stride);
                self.grown.push(stance);
            }
            // It ends there if a step leads there; else it goes on by longer strides.
            (_, Some(Step::Reached { stride, .. })) => {
                self.grow((context, placements), is_barred, stride)
            }
            (_, Some(step)) => self.take(step, is_barred),
        }
        1
    }

    /// Grows by a station, none where it is barred, or ends.
    fn take(&mut self, step: Step, is_barred: &impl Fn(&Station) -> bool) {
        match step {
            Step::Reached { stance, .. } if !is_barred(&stance.station) => self.grown.push(stance),
            Step::Reached { .. } | Step::Blocked => self.end = Some(End::Blocked),
            Step::Arrived { is_upright } => self.end = Some(End::Arrived { is_upright }),
        }
    }

    fn is_long(&self, tip: &Station) -> bool {
        self.grown.len() == STATIONS_MAX
            || self.grown.len() + self.extension.stations_left(tip) >= self.stations_max
    }

    /// Names the next step in the random stream.
    fn name_of_step(&self) -> u64 {
        self.name << 7 | self.grown.len() as u64
    }
}

/// Where a branch that began at a vertex ends so far.
fn tip_of<'a>(from: &'a Vertex, grown: &'a [Stance], placements: &'a [Placed]) -> Tip<'a> {
    match grown.last() {
        Some(stance) => Tip { station: &stance.station, placements: &stance.placements },
        None => tip_at(from, placements),
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
        Self {
            branches: (0..BRANCHES_MAX).map(|_| Branch::new(placement)).collect(),
            count: 0,
            helper: Scratch::new(placement),
            begun: 0,
        }
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
        (branch.purpose, branch.extension, branch.from, branch.stations_max) =
            (purpose, extension, from, stations_max);
        (branch.name, branch.end, branch.unproven) = (self.begun, None, None);
        branch.grown.clear();
        self.begun += 1;
        self.count += 1;
    }

    /// All of them, in order.
    pub fn all(&self) -> &[Branch] {
        &self.branches[..self.count]
    }

    /// Grows them by at most so many stations together, none where it is barred; answers how many
    /// units of work that took. Less than the budget means that all have ended.
    pub fn advance(
        &mut self,
        context: &Context<'_>,
        placements: &[Placed],
        is_barred: impl Fn(&Station) -> bool + Sync,
        budget: u64,
    ) -> u64 {
        let site = (context, placements);
        let several = context.threads.count().min(2);
        let grow = |branch: &mut Branch| branch.grow(site, &is_barred, 0);
        let mut spent = 0;
        while spent < budget {
            let branches = &mut self.branches[..self.count];
            let mut growing = branches.iter_mut().filter(|branch| !branch.has_ended());
            spent += match (growing.next(), growing.next()) {
                (None, _) => break,
                (Some(alone), None) if several > 1 => {
                    alone.grow_alone(site, &is_barred, &mut self.helper)
                }
                _ => allowance::advance_several(
                    branches,
                    several,
                    budget - spent,
                    context.threads,
                    grow,
                ),
            };
        }
        spent
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        let bytes = |branch: &Branch| {
            branch.grown.capacity() * size_of::<Stance>() + branch.scratch.heap_bytes()
        };
        self.branches.iter().map(bytes).sum::<usize>() + self.helper.heap_bytes()
    }
}
