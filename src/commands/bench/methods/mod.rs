//! `surefoot bench methods`, `rho` and `theory`: the methods on the same worlds [Grey 5].

pub mod method_journal;
pub mod method_report;
pub mod method_row;
pub mod method_trial;
pub mod methods_bench;
pub mod rho_bench;
pub mod theory_bench;
pub mod theory_numbers;
