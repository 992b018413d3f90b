//! Arenas of fixed capacity.

/// The arena that is full. Its capacity is the parameter of the same name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ArenaFull {
    /// `tree_vertices_max`.
    TreeVertices,
    /// `footholds_max`.
    Footholds,
    /// `transitions_max`.
    Transitions,
    /// `configurations_max`.
    Configurations,
    /// The table of mode edges, which `configurations_max` sizes too.
    Edges,
    /// `waypoints_max`.
    Waypoints,
}
