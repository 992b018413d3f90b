//! Stage M: whole-body motions over modes and transitions [Grey 4.4].

pub(crate) mod adjacency_lists;
pub mod cbirrt;
pub(crate) mod edge_table;
pub(crate) mod indexed_heap;
pub(crate) mod lift_off;
pub mod local_planner;
pub mod mode_graph;
pub(crate) mod search_batch;
pub(crate) mod spatial_hash;
pub mod swing_shapes;
pub mod transition_sampling;
pub(crate) mod transition_sequence;
pub mod tree_pool;

pub mod mode_costs;
pub mod roadmap;
pub mod shortcut;
pub mod single_mode;
pub mod transition_prior;
pub mod workspace;
