//! The arguments of `ncfix verify`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::{MachineChoice, PageChoice, ProgramChoice, StateChoice};
use crate::cli::value;

/// `ncfix verify`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct VerifyArguments {
    /// Original part program
    pub(in crate::cli) original: PathBuf,
    /// Corrected part program
    pub(in crate::cli) corrected: PathBuf,
    #[command(flatten)]
    pub(in crate::cli) machine: MachineChoice,
    #[command(flatten)]
    pub(in crate::cli) state: StateChoice,
    #[command(flatten)]
    pub(in crate::cli) program: ProgramChoice,
    /// Tolerance promised by the correction, with unit (default: that of the stamp)
    #[arg(long, value_name = "LENGTH", value_parser = value::positive_length_mm)]
    pub(in crate::cli) promised: Option<f64>,
    /// Also run both programs through a model of the servo loops (docs/reference/servo.md); report path deviations and times
    #[arg(long)]
    pub(in crate::cli) at_feed: bool,
    /// Report positions, tools, temperatures and loads beyond the measured ranges of the machine file as errors
    #[arg(long)]
    pub(in crate::cli) require_coverage: bool,
    #[command(flatten)]
    pub(in crate::cli) page: PageChoice,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub(in crate::cli) json: bool,
}
