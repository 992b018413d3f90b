//! Other methods over the same robot, constraints, foot placements, worlds and work limits: the
//! simplified method of chapter 5 and the methods that the thesis compares with [Grey 2, 5].
//!
//! A method adds footholds and transitions to Gamma_M, and takes configurations and motions from
//! stage M. It returns a sequence of transitions from start to goal, all with motions. It does not
//! allocate while it searches, and counts every piece of its work.

pub(crate) mod disc_placements;
pub(crate) mod exploration;
pub(crate) mod guide_line;
pub(crate) mod lattice;
pub(crate) mod lattice_steps;
pub mod method;
pub(crate) mod method_search;
pub(crate) mod multi_modal_prm;
pub(crate) mod placements;
pub(crate) mod random_mmp;
pub(crate) mod reachability;
pub(crate) mod w_rpg;
pub(crate) mod workbench;
