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
    /// Which machine.
    pub(in crate::cli) machine: MachineChoice,
    #[command(flatten)]
    /// The condition of the machine.
    pub(in crate::cli) state: StateChoice,
    #[command(flatten)]
    /// How the programs are executed.
    pub(in crate::cli) program: ProgramChoice,
    /// Tolerance that the correction has promised, with its unit; without it what the stamp says
    #[arg(long, value_name = "LENGTH", value_parser = value::positive_length_mm)]
    pub(in crate::cli) promised: Option<f64>,
    /// Drive both programs through the servo loops of the machine file too (docs/reference/servo.md), and say how far off their paths they leave the tool, and their times
    #[arg(long)]
    pub(in crate::cli) at_feed: bool,
    #[command(flatten)]
    /// Which page.
    pub(in crate::cli) page: PageChoice,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub(in crate::cli) json: bool,
}
