//! Branches that join both trees of Gamma_P (RRT-Connect, Kuffner and LaValle 2000).

use crate::possibility::branch::{Branch, BranchKind};
use crate::possibility::forest::Forest;
use crate::possibility::route_run::{Join, Run};
use crate::possibility::tree::Vertex;
use crate::possibility::vertex_sampling::SIDES;

/// The join that follows a branch that ended at a tip. After a branch toward a sample, or the
/// first branch, the other tree grows toward its tip. After a branch toward the other tree with
/// the heading offset of the route, it is tried again with a sidestep.
pub(crate) fn join_after(
    (forest, run): (&Forest, &Run),
    branch: &Branch,
    (tree, tip): (usize, u32),
) -> Option<Join> {
    let Branch { kind, extension, ref grown, .. } = *branch;
    if let BranchKind::Connect { other, .. } = kind
        && extension.heading_offset == run.heading_offset
        && run.may_sidestep()
    {
        let heading_offset = SIDES[run.samples as usize / 2 % SIDES.len()];
        return Some(Join { tree, tip, other, heading_offset });
    }
    let reaches_out = !grown.is_empty()
        && (matches!(kind, BranchKind::Sample { .. }) || run.samples == 0 && tree == 0);
    reaches_out.then(|| {
        let Vertex { pose: at, heading_offset, .. } = forest.trees[tree][tip as usize];
        let other_tree = &forest.trees[1 - tree];
        let near = other_tree.nearest(|pose| pose.distance(&at));
        let is_alike = other_tree[near as usize].heading_offset == heading_offset;
        Join {
            tree: 1 - tree,
            tip: near,
            other: tip,
            heading_offset: if is_alike { heading_offset } else { run.heading_offset },
        }
    })
}
