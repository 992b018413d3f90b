//! Time-optimal timing of a smooth path within the limits of joints and contacts.

mod border;
mod contact_bounds;
pub mod contact_rates;
mod force_exchange;
pub mod ground;
pub mod limit;
pub mod limits;
pub mod linear_program;
pub mod load_sharing;
mod motion_changes;
pub mod path_dynamics;
pub mod path_point;
pub mod path_timing;
pub mod profile;
mod profile_check;
pub mod rate_set;
mod single_contact;
pub mod slow_downs;
mod sole_twist;
pub mod stops;
pub mod support;
pub mod time_law;
mod timed_motion;
pub mod timed_path;
pub mod timed_robot;
mod tuning;
mod zero_moment;
