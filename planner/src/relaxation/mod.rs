//! The relaxed problem: what every plan needs, without postures, balance and most collisions. Where
//! it has no solution, no search finds a plan, and the obstruction is named at once.
//!
//! Three conditions are tested on a coarse grid, and all are necessary:
//!
//! - *Steps.* Every sole touches ground that is flat enough and, with all that a sole can touch
//!   beside it, large enough. The soles of a stance are at most
//!   [`StepLimits::reach`](crate::preparation::step_limits::StepLimits::reach) apart, since stage M
//!   connects no others. So the ground of the goal is reached from that of the start by steps
//!   between touched points of at most that reach and the extents of both soles.
//! - *Passage.* A ball that the root contains moves from start to goal without touching the world,
//!   and always within a leg's reach of ground that steps reach.
//!
//! - *Legs.* From a point that a stance foot touches, a curve of bounded length leads through foot,
//!   leg and root to the centre of that ball. Its points keep a distance from the world, except on
//!   parts shorter than a voxel, at joints that no collision shape covers. So from the ground that
//!   steps reach, a chain of as many voxels, none of them filled by the world, leads to each place
//!   of the root, and the root moves through such places only.
//!
//! Every rounding makes more possible: ground fills each voxel that it may touch, distances are
//! those of the nearest points of two voxels, and the ball is stopped between two voxels only if it
//! touches the world wherever its centre crosses the face between them. The grid is bounded; where
//! a search comes to its border, or a bound is reached, nothing is claimed.
//!
//! Where the problem has a solution, a coarse path leads over the ground that steps reach. Stage P
//! follows it where straight branches find no route.

pub(crate) mod ball_search;
pub(crate) mod column_queue;
pub(crate) mod curve_search;
pub(crate) mod element_search;
pub(crate) mod flood;
pub(crate) mod free_voxels;
pub(crate) mod gap_search;
pub(crate) mod grid;
pub(crate) mod ground;
pub(crate) mod leg_curve;
pub(crate) mod obstruction;
pub(crate) mod path_search;
pub(crate) mod relaxed_problem;
pub(crate) mod step_search;

pub use obstruction::{BareGround, Blockage, Enclosure, GroundGap, Obstruction, SteepGround};
pub(crate) use path_search::PathSearch;
pub(crate) use relaxed_problem::{
    Extent, RelaxedEnd, RelaxedOutcome, RelaxedProblem, RelaxedWorld,
};

mod tuning;
