//! The files that commands read, write and cache.

pub mod cache_file;
pub mod cache_folder;
pub mod inputs;
pub mod output_files;
pub mod preparation_cache;
pub mod shipped;
pub mod stance_measures;
