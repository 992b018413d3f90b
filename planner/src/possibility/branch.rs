//! Branches of Gamma_P grow in parallel, each until it ends. They are then merged into the trees in
//! order.
//!
//! If one branch is left and there are several threads, the placements of both feet are searched in
//! parallel, while the step to the last vertex is tested. If that step does not exist, the branch
//! discards the last vertex and continues from the one before.

use crate::base::arena::reserve;
use crate::base::work_budget;
use crate::base::work_budget::{BudgetedTask, WorkBudget};
use crate::constraints::foothold::FootPlacement;
use crate::foot_placement::{FootPlacementConfig, Scratch};
use crate::possibility::extension::{Extend, Extension};
use crate::possibility::mid_feet_pose::MidFeetPose;
use crate::possibility::root_vertex::UPRIGHT;
use crate::possibility::route_condition::RouteCondition;
use crate::possibility::tree::{Tip, Vertex, tip_at};
use crate::possibility::tuning::{BRANCH_VERTICES_MAX, BRANCHES_MAX};
use crate::possibility::vertex_candidates::{FootScratch, StageContext, VertexCandidate};

/// Kind of a branch.
#[derive(Debug, Clone, Copy)]
pub(crate) enum BranchKind {
    /// From a vertex of a tree toward a sample.
    Sample { tip: u32 },
    /// From a vertex of the tree of the start along a leg of the coarse path.
    Follow { tip: u32 },
    /// From a vertex of a tree to a vertex of the other tree.
    Connect { tip: u32, other: u32 },
    /// A replacement for the route between two of its vertices.
    Shortcut { from: usize, to: usize },
}

impl BranchKind {
    /// The vertex of a tree from which it grows; none for a shortcut.
    pub fn tip(self) -> Option<u32> {
        match self {
            Self::Sample { tip } | Self::Follow { tip } | Self::Connect { tip, .. } => Some(tip),
            Self::Shortcut { .. } => None,
        }
    }
}

/// Result of a branch.
#[derive(Debug, Clone, Copy)]
pub(crate) enum BranchEnd {
    /// It reached its target.
    Reached {
        /// Whether the upright robot fits between the tip and the target.
        is_upright: bool,
    },
    /// No stride leads further.
    Trapped,
    /// It would have more vertices than allowed.
    TooLong,
}

/// Request for a branch.
#[derive(Debug)]
pub(crate) struct BranchRequest {
    pub kind: BranchKind,
    pub extension: Extension,
    pub from: Vertex,
    /// It ends before it has this many vertices.
    pub vertices_max: usize,
}

/// A branch.
#[derive(Debug)]
pub(crate) struct Branch {
    pub kind: BranchKind,
    pub extension: Extension,
    /// The vertices after the one from which it began.
    pub grown: Vec<VertexCandidate>,
    pub end: Option<BranchEnd>,
    /// Index of the stride that led to the last vertex, if the step to it is not tested yet.
    untested_stride: Option<usize>,
    from: Vertex,
    vertices_max: usize,
    /// Its name in the random stream.
    name: u64,
    scratch: Scratch,
    work_budget: WorkBudget,
}

impl BudgetedTask for Branch {
    fn has_ended(&self) -> bool {
        self.end.is_some()
    }

    fn work_budget(&mut self) -> &mut WorkBudget {
        &mut self.work_budget
    }
}

impl Branch {
    /// A branch that has ended, with reserved memory. Allocates.
    fn new(placement: &FootPlacementConfig) -> Self {
        let origin = MidFeetPose { position: glam::DVec3::ZERO, yaw: 0.0 };
        let extension = Extension {
            target: origin,
            target_posture: UPRIGHT,
            backward: false,
            heading_offset: 0.0,
            joins: false,
            condition: RouteCondition::UpperBody,
            spacing: 0.0,
        };
        Self {
            kind: BranchKind::Sample { tip: 0 },
            extension,
            grown: reserve(BRANCH_VERTICES_MAX),
            end: Some(BranchEnd::Trapped),
            untested_stride: None,
            from: Vertex::root(origin, None),
            vertices_max: 0,
            name: 0,
            scratch: Scratch::new(placement),
            work_budget: WorkBudget::default(),
        }
    }

    /// Adds a vertex, by a stride from index `first` on, or ends the branch.
    fn grow(
        &mut self,
        (context, placements): (&StageContext<'_>, &[FootPlacement]),
        is_blocked: &impl Fn(&MidFeetPose) -> bool,
        mut first: usize,
    ) {
        loop {
            let tip = tip_of(&self.from, &self.grown, placements);
            if self.is_long(tip.pose) {
                self.end = Some(BranchEnd::TooLong);
                return;
            }
            let name = self.extension_name();
            let extended = self.extension.extend(
                context,
                tip.root(),
                first,
                name,
                &mut FootScratch::Shared(&mut self.scratch),
            );
            match extended {
                Extend::Advanced { candidate, stride }
                    if !has_step(
                        context,
                        self.extension.condition,
                        tip.placements,
                        &candidate.placements,
                    ) =>
                {
                    first = stride + 1
                }
                extended => return self.take(extended, is_blocked),
            }
        }
    }

    /// Adds a vertex or ends the branch. The placements of both feet are found in parallel, those
    /// of the second in `second_scratch`, while the step to the last vertex is tested. Returns the
    /// work units spent: 0 if that step does not exist.
    fn grow_alone(
        &mut self,
        (context, placements): (&StageContext<'_>, &[FootPlacement]),
        is_blocked: &impl Fn(&MidFeetPose) -> bool,
        second_scratch: &mut Scratch,
    ) -> u64 {
        let tip = tip_of(&self.from, &self.grown, placements);
        let (is_long, name) = (self.is_long(tip.pose), self.extension_name());
        let condition = self.extension.condition;
        let scratch = &mut self.scratch;
        let extend = || {
            (!is_long).then(|| {
                self.extension.extend(
                    context,
                    tip.root(),
                    0,
                    name,
                    &mut FootScratch::Each([scratch, second_scratch]),
                )
            })
        };
        let has_step = || {
            let before = self.untested_stride.and_then(|_| self.grown.split_last());
            before.is_none_or(|(_, before)| {
                let from = tip_of(&self.from, before, placements);
                has_step(context, condition, from.placements, tip.placements)
            })
        };
        let (extended, has_step) = context.threads.join(extend, has_step);
        match (self.untested_stride.take(), extended) {
            (Some(stride), _) if !has_step => {
                self.grown.pop();
                self.grow((context, placements), is_blocked, stride + 1);
                return 0;
            }
            (_, None) => self.end = Some(BranchEnd::TooLong),
            (_, Some(Extend::Advanced { candidate, stride })) if !is_blocked(&candidate.pose) => {
                self.untested_stride = Some(stride);
                self.grown.push(candidate);
            }
            // A blocked vertex: the branch ends if a step leads to it, else tries longer strides.
            (_, Some(Extend::Advanced { stride, .. })) => {
                self.grow((context, placements), is_blocked, stride)
            }
            (_, Some(extended)) => self.take(extended, is_blocked),
        }
        1
    }

    /// Adds a vertex that is not blocked, or ends the branch.
    fn take(&mut self, extended: Extend, is_blocked: &impl Fn(&MidFeetPose) -> bool) {
        match extended {
            Extend::Advanced { candidate, .. } if !is_blocked(&candidate.pose) => {
                self.grown.push(candidate)
            }
            Extend::Advanced { .. } | Extend::Trapped => self.end = Some(BranchEnd::Trapped),
            Extend::Reached { is_upright } => self.end = Some(BranchEnd::Reached { is_upright }),
        }
    }

    /// Whether the branch would have more vertices than allowed.
    fn is_long(&self, tip: &MidFeetPose) -> bool {
        self.grown.len() == BRANCH_VERTICES_MAX
            || self.grown.len() + self.extension.vertices_left(tip) >= self.vertices_max
    }

    /// The name of the next extension in the random stream.
    fn extension_name(&self) -> u64 {
        self.name << 7 | self.grown.len() as u64
    }
}

/// Whether a step leads from one of some placements to one of others, where the condition asks for
/// it.
fn has_step(
    context: &StageContext<'_>,
    condition: RouteCondition,
    from: &[FootPlacement],
    to: &[FootPlacement],
) -> bool {
    condition == RouteCondition::Necessary || context.has_step_between(from, to)
}

/// The tip of a branch that began at a vertex.
fn tip_of<'a>(
    from: &'a Vertex,
    grown: &'a [VertexCandidate],
    placements: &'a [FootPlacement],
) -> Tip<'a> {
    match grown.last() {
        Some(candidate) => Tip {
            pose: &candidate.pose,
            placements: &candidate.placements,
            posture: candidate.posture,
        },
        None => tip_at(from, placements),
    }
}

/// Branches that grow in parallel, allocated once.
#[derive(Debug)]
pub(crate) struct Branches {
    branches: Vec<Branch>,
    count: usize,
    /// Memory for the second foot of a branch that grows alone.
    second_scratch: Scratch,
    /// Number of branches begun so far.
    begun: u64,
}

impl Branches {
    /// No branch, with reserved memory. Allocates.
    pub fn new(placement: &FootPlacementConfig) -> Self {
        Self {
            branches: (0..BRANCHES_MAX).map(|_| Branch::new(placement)).collect(),
            count: 0,
            second_scratch: Scratch::new(placement),
            begun: 0,
        }
    }

    /// Removes all branches.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Number of branches.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Begins a branch.
    ///
    /// # Panics
    /// There are [`BRANCHES_MAX`] branches already.
    pub fn begin(&mut self, request: BranchRequest) {
        let branch = &mut self.branches[self.count];
        let BranchRequest { kind, extension, from, vertices_max } = request;
        (branch.kind, branch.extension, branch.from, branch.vertices_max) =
            (kind, extension, from, vertices_max);
        (branch.name, branch.end, branch.untested_stride) = (self.begun, None, None);
        branch.grown.clear();
        self.begun += 1;
        self.count += 1;
    }

    /// All branches, in order.
    pub fn all(&self) -> &[Branch] {
        &self.branches[..self.count]
    }

    /// Extends the branches by at most `budget` vertices in total, none of them blocked. Returns
    /// the work units spent; fewer than the budget mean that all branches have ended.
    pub fn advance(
        &mut self,
        context: &StageContext<'_>,
        placements: &[FootPlacement],
        is_blocked: impl Fn(&MidFeetPose) -> bool + Sync,
        budget: u64,
    ) -> u64 {
        let inputs = (context, placements);
        let grow = |branch: &mut Branch| branch.grow(inputs, &is_blocked, 0);
        let mut spent = 0;
        while spent < budget {
            let task_count = context.threads.count().min(2);
            let branches = &mut self.branches[..self.count];
            let mut growing = branches.iter_mut().filter(|branch| !branch.has_ended());
            spent += match (growing.next(), growing.next()) {
                (None, _) => break,
                (Some(alone), None) if task_count > 1 || alone.untested_stride.is_some() => {
                    alone.grow_alone(inputs, &is_blocked, &mut self.second_scratch)
                }
                _ => work_budget::advance_several(
                    branches,
                    task_count,
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
            branch.grown.capacity() * size_of::<VertexCandidate>() + branch.scratch.heap_bytes()
        };
        self.branches.iter().map(bytes).sum::<usize>() + self.second_scratch.heap_bytes()
    }
}
