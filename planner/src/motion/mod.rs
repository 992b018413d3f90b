//! Stage M: whole-body motions over modes and transitions [Grey 4.4].

pub(crate) mod adjacency_lists;
pub(crate) mod batch_entry;
pub mod cbirrt;
pub(crate) mod edge_table;
pub mod ids;
pub(crate) mod indexed_heap;
pub(crate) mod lift_off;
pub mod local_planner;
pub(crate) mod mode_costs;
pub mod mode_graph;
pub mod roadmap;
pub(crate) mod search_batch;
pub(crate) mod sequence_search;
pub mod shortcut;
pub mod single_mode;
pub(crate) mod spatial_hash;
pub mod swing_shapes;
pub mod transition;
pub mod transition_prior;
pub(crate) mod transition_sampling;
pub(crate) mod transition_sequence;
pub mod tree_pool;
pub mod tuning;
pub mod workspace;
