//! `surefoot bench`: measurements on this machine.

pub mod command;
pub mod footholds;
pub mod goals;
pub mod holes;
pub mod impossible;
pub mod ipc;
pub mod journal;
pub mod late;
pub mod lower_bound;
pub mod machine;
pub mod methods;
pub mod mutations;
pub mod pieces;
pub mod print_report;
pub mod replan;
pub mod row;
pub mod scale;
pub mod scenarios;
pub mod soak;
pub mod statistics;
pub mod steps;
pub mod table;
pub mod terrain;
pub mod thesis;
pub mod threads;
pub mod trial;
