//! What `surefoot bench` offers.

use clap::{Args, Subcommand};

use super::footholds::FootholdsArguments;
use super::ipc::IpcArguments;

/// `surefoot bench`.
#[derive(Debug, Args)]
pub struct BenchArguments {
    /// What to measure
    #[command(subcommand)]
    pub bench: BenchCommand,
}

/// What can be measured.
#[derive(Debug, Subcommand)]
pub enum BenchCommand {
    /// Real chunks over our transport beside raw memory, a socket and plain iceoryx2
    Ipc(IpcArguments),
    /// How often foot placement sampling succeeds: figure 4.10 of the thesis, and further features
    Footholds(FootholdsArguments),
}
