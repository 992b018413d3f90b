//! input.

pub mod inputs;
pub mod output_files;
pub mod preparation_cache;
