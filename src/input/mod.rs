//! The files that commands read, write and cache.

pub mod inputs;
pub mod output_files;
pub mod preparation_cache;
