//! Names of footholds and transitions, and the nodes of segment boundaries among the transitions.

/// Index of a foothold in the mode graph.
pub type FootholdId = u32;
/// Index of a transition in the mode graph. It differs from its twin in the last bit. The largest
/// values are boundary nodes.
pub type TransitionId = u32;

/// Most boundaries between segments, start and goal included.
pub const BOUNDARIES_MAX: usize = 4_096;
/// Index of the boundary at the start.
pub const START: usize = 0;
/// Index of the boundary at the goal.
pub const GOAL: usize = 1;

/// The node of a boundary, where the robot is at rest between two segments.
pub fn boundary_node(boundary: usize) -> TransitionId {
    TransitionId::MAX - boundary as TransitionId
}

/// The boundary of a node; `None` if the node is a transition.
pub fn boundary_of(node: TransitionId) -> Option<usize> {
    let index = (TransitionId::MAX - node) as usize;
    (index < BOUNDARIES_MAX).then_some(index)
}
