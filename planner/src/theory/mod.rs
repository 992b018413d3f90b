//! The bounds of chapter 5 on the probability that the method w-RPG fails [Grey 5.4 to 5.7].
//!
//! Lengths are in metres, angles in radians, areas in square metres. The exploration space E has
//! six dimensions and one metric, in which one radian counts one metre; its volumes are in m^6. A
//! bound of 1 or more says nothing. Where the printed formula does not hold, the function of that
//! name says so, and another one holds.

pub mod confidence;
pub mod coverage;
pub mod disc_union;
pub mod erosion;
pub mod mode_sampling;
pub mod overall;
pub mod route_sampling;
