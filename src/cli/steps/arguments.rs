//! The arguments of `ncfix max-step`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::{MachineChoice, ProgramChoice, RotaryChoice, StateChoice};
use crate::cli::value;
use crate::tool::ToolVector;

/// End of `ncfix max-step --help`.
pub(in crate::cli) const AFTER_HELP: &str = "\
ncfix divides lines through the travel of all axes, or the moves of a program, into pieces of a fixed step along the axis that moves farthest, as ncfix \
fix --step does. It corrects the ends of a piece exactly. The residual is the largest distance of the tool tip from the line between them. The result \
is the largest step up to which the residual stays within --residual.

Examples:
  ncfix max-step --machine mill.toml
  ncfix max-step part.mpf --machine mill.toml --residual 2um --svg steps.svg
  ncfix max-step --machine mill.toml --report steps.html";

/// `ncfix max-step`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct StepsArguments {
    /// Part program whose moves are evaluated (default: lines through the whole travel)
    #[arg(value_name = "PROGRAM")]
    pub(in crate::cli) input: Option<PathBuf>,
    #[command(flatten)]
    /// Machine file and set-up files.
    pub(in crate::cli) machine: MachineChoice,
    #[command(flatten)]
    /// Condition of the machine.
    pub(in crate::cli) state: StateChoice,
    #[command(flatten)]
    /// Reading and execution of the program.
    pub(in crate::cli) program: ProgramChoice,
    /// Largest residual allowed, with unit
    #[arg(long, value_name = "LENGTH", default_value = "5um", value_parser = value::positive_length_mm)]
    pub(in crate::cli) residual: f64,
    /// Tool length, mm, or vector from the spindle to the tip, mm (default: tools of the program, else the longest one of the machine file)
    #[arg(long, value_name = "LENGTH|X,Y,Z", allow_hyphen_values = true)]
    pub(in crate::cli) tool: Option<ToolVector>,
    /// Correction of the rotary axes
    #[arg(long, value_enum, default_value_t)]
    pub(in crate::cli) rotary: RotaryChoice,
    /// Draw the residual over the step into this file
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) svg: Option<PathBuf>,
    /// Write an HTML report with the picture and the table: one file that needs no network
    #[arg(long, value_name = "REPORT.html")]
    pub(in crate::cli) report: Option<PathBuf>,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub(in crate::cli) json: bool,
}
