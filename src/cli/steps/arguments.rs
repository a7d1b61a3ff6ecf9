//! The arguments of `ncfix max-step`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::{MachineChoice, ProgramChoice, RotaryChoice, StateChoice};
use crate::cli::value;
use crate::tool::ToolVector;

/// What `ncfix max-step --help` says last.
pub(in crate::cli) const AFTER_HELP: &str = "\
Lines through the travel of all axes, or the moves of a program, are cut into pieces of a fixed step along the axis that moves farthest, as \
--step of ncfix fix does; the ends are corrected exactly, and the largest distance of the tool tip from the line in between is the \
residual. The answer is the largest step below which it stays within --residual.

Examples:
  ncfix max-step --machine mill.toml
  ncfix max-step part.mpf --machine mill.toml --residual 2um --svg steps.svg
  ncfix max-step --machine mill.toml --report steps.html";

/// `ncfix max-step`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct StepsArguments {
    /// Part program whose moves are looked at; without it lines through the whole travel
    #[arg(value_name = "PROGRAM")]
    pub(in crate::cli) input: Option<PathBuf>,
    #[command(flatten)]
    /// Which machine.
    pub(in crate::cli) machine: MachineChoice,
    #[command(flatten)]
    /// In which condition.
    pub(in crate::cli) state: StateChoice,
    #[command(flatten)]
    /// How the program is executed.
    pub(in crate::cli) program: ProgramChoice,
    /// Largest residual allowed, with its unit
    #[arg(long, value_name = "LENGTH", default_value = "5um", value_parser = value::positive_length_mm)]
    pub(in crate::cli) residual: f64,
    /// Length of the tool in mm, or vector from the spindle to its tip; without it that of the longest tool of the machine file, or those of
    /// the program
    #[arg(long, value_name = "LENGTH|X,Y,Z", allow_hyphen_values = true)]
    pub(in crate::cli) tool: Option<ToolVector>,
    /// Rotary axes
    #[arg(long, value_enum, default_value_t)]
    pub(in crate::cli) rotary: RotaryChoice,
    /// Draw residual over step into a file
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) svg: Option<PathBuf>,
    /// Write a page (HTML) with the picture and the table: one file that opens in a browser without a network
    #[arg(long, value_name = "REPORT.html")]
    pub(in crate::cli) report: Option<PathBuf>,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub(in crate::cli) json: bool,
}
