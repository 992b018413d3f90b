//! The smooth path over a found plan: the same footholds and modes, and statically stable
//! configurations whose first two derivatives are continuous from one rest to the next.

mod curve;
mod followed_motion;
mod followed_trial;
mod key;
mod key_table;
mod layout;
mod phase_check;
mod phase_grid;
mod phase_points;
mod posture_solver;
mod searched_motion;
pub mod smoother;
mod spline;
mod swing_curve;
mod track;
mod tuning;
mod variant;
mod written_path;
