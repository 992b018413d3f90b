//! The commands, one file or folder each, and the dispatcher that runs them.

pub mod bench;
pub mod check;
mod colliding_links;
pub mod completions;
pub mod config;
pub mod control;
pub mod dispatch;
pub mod doctor;
pub mod explain;
pub mod export;
pub mod list;
pub mod man;
pub mod monitor;
pub mod new;
pub mod picture;
pub mod plan;
pub mod prepare;
pub mod request;
pub mod robot;
pub mod sample;
pub mod search_loop;
pub mod session;
pub mod view;
pub mod walk;
