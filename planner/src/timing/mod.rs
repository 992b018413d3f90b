//! Time-optimal timing of a smooth path within the limits of joints and contacts.

pub mod path_point;
