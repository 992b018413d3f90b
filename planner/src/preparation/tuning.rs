//! The constants of a preparation that change what it holds, or how long it takes. Any change of a
//! value changes the bytes of a preparation, so the file format's version changes with it.
//! Constants without another source were chosen with `surefoot bench` on the shipped robots.

use std::f64::consts::PI;

use crate::primitives::step_path::SECTIONS;

// Reachable space [Grey 4.2.1].

/// The side of the cubes that are swept, m.
pub(crate) const FINE_SIDE: f64 = 0.006;
/// Fine cubes along a side of the cubes of the result.
pub(crate) const COARSENING: u32 = 4;
/// Half of the longest arc between two samples of a sweep, m.
pub(crate) const HALF_ARC: f64 = 0.0025;
/// Half of the longest arc where only the box around a sweep is needed, m.
pub(crate) const BOUNDS_HALF_ARC: f64 = 0.03;
/// Number of points up to which a set is kept as points, without rounding to cubes.
pub(crate) const POINTS_MAX: usize = 50_000;
/// Cubes along a side of a block.
pub(crate) const BLOCK_CUBES: u32 = 8;

// Range of the primitives [Grey 4.4.5].

/// Heights of the lattice's vertices, as shares of the reach. Those of pairs on one floor lie in
/// the middle of a cell.
pub(crate) const RANGE_HEIGHTS: [f64; 6] = [-0.19, -0.09, -0.015, 0.015, 0.09, 0.19];
/// Turns of the lattice's vertices, rad. Those of parallel feet lie in the middle of a cell.
pub(crate) const RANGE_TURNS: [f64; 6] = [-0.3, -0.15, -0.04, 0.04, 0.15, 0.3];

// Sweep of the primitives: margins beyond those of a plan cover the pairs between the vertices.

/// Clearance beyond a plan's, m.
pub(crate) const CLEARANCE_SLACK: f64 = 0.006;
/// Clearance beyond a plan's between a leg's links and the ground on which its foot stands, m.
pub(crate) const FLOOR_SLACK: f64 = 0.002;
/// Joint margin beyond a plan's, rad.
pub(crate) const JOINT_SLACK: f64 = 0.02;
/// Balance margin beyond a plan's, m.
pub(crate) const BALANCE_SLACK: f64 = 0.004;
/// The fraction of a plan's effort that is used.
pub(crate) const EFFORT_FRACTION: f64 = 0.95;
/// Samples of each section of a half swing.
pub(crate) const SECTION_SAMPLES: [usize; SECTIONS] = [2, 6, 2, 2];
/// Samples of a shift.
pub(crate) const SHIFT_SAMPLES: usize = 5;

// Choice of the gait.

/// Reaches that are tried for the primitives, as multiples of the standing posture's.
pub(crate) const GAIT_REACHES: [f64; 3] = [1.0, 1.05, 0.95];
/// Widths that are tried, as multiples of the standing posture's.
pub(crate) const GAIT_WIDTHS: [f64; 4] = [1.0, 1.3, 0.8, 0.65];
/// Rolls of the root over the stance foot that are tried, rad.
pub(crate) const GAIT_ROLLS: [f64; 4] = [0.0, 0.06, 0.12, 0.18];
/// Shifts of the centre of mass inward of a sole's centroid that are tried, as fractions of the
/// space there.
pub(crate) const GAIT_LEANS: [f64; 2] = [0.0, 0.6];
/// The steepest placements that are tried, rad.
pub(crate) const GAIT_TILTS: [f64; 3] = [0.1, 0.06, 0.02];
/// Share of the pairs that a steeper tilt must keep to be chosen.
pub(crate) const KEPT_PAIRS_SHARE: f64 = 0.8;
/// Gaits that are tried on the whole coarse lattice: those that hold over most of its level pairs.
pub(crate) const GAIT_SHORTLIST: usize = 4;
/// Growth of the expanded geometry's boxes beyond the swept volume and the clearance, m: covers the
/// pairs between the vertices.
pub(crate) const BOX_SLACK: f64 = 0.01;
/// Vertices that one task tries.
pub(crate) const TASK_VERTICES: usize = 64;

// Slices of the robot's shapes.

/// The thickest slice, m.
pub(crate) const SLICE_THICKNESS_MAX: f64 = 0.06;

// Step limits [Grey 4.4.2].

/// Horizontal directions around the stance that are tried.
pub(crate) const BEARINGS: usize = 16;
/// Climbs of the direction, down and up, that are tried.
pub(crate) const CLIMBS: usize = 7;
/// The steepest climb, rad.
pub(crate) const CLIMB_MAX: f64 = PI / 3.0;
/// Outward turns of the touching sole that are tried.
pub(crate) const STEP_TURNS: usize = 7;
/// The largest turn, rad.
pub(crate) const STEP_TURN_MAX: f64 = 1.2;
/// Increment of the turns that are tried where the feet are side by side, rad.
pub(crate) const STEP_TURN_INCREMENT: f64 = 0.05;
/// Decrements of the step lengths that are tried, m: first the coarse one, then the fine one
/// between the last two lengths.
pub(crate) const STEP_DECREMENTS: [f64; 2] = [0.08, 0.02];
/// Distance (m) by which the feet of a walk keep from the narrowest stance.
pub(crate) const WALKING_WIDTH_MARGIN: f64 = 0.01;
/// Length of a possible step relative to those that were tried: other postures and inclined soles
/// reach farther.
pub(crate) const STEP_LENGTH_SLACK: f64 = 1.15;
