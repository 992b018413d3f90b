//! Stage M: whole-body motions over modes and transitions [Grey 4.4].

pub mod edges;
pub mod foothold;
pub mod graph;
pub mod heap;
pub mod lift;
pub mod mode_costs;
pub mod place_index;
pub mod primitive;
pub mod roadmap;
pub mod round;
pub mod sampling;
pub mod sequence;
pub mod shortcut;
pub mod single_mode;
pub mod swing;
pub mod swing_lists;
pub mod track;
pub mod transition;
pub mod tree;
pub mod trees;
pub mod workspace;
