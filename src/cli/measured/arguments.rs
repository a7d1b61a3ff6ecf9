//! The arguments of `ncfix correct-readings`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::{MachineChoice, PoseRotaryChoice, StateChoice};
use crate::cli::fix::arguments::MOST_CORRECTION;
use crate::cli::value;

/// End of `ncfix correct-readings --help`.
pub(in crate::cli) const AFTER_HELP: &str = "\
DATA.csv has a line of column names. Columns named by the axis letters of the machine (X, Y, Z, C …; mm, deg) are positions read on the machine. ncfix \
replaces them by those that a machine without errors would have read. It also uses tool_x_mm, tool_y_mm, tool_z_mm (from the gauge point of the \
spindle to the tip) and X_dir … (-1, 0, 1: direction of the last motion; default: from the order of the rows within a run). It copies these and all \
other columns unchanged.

Examples:
  ncfix correct-readings probing.csv -o probing_corrected.csv --machine mill.toml";

/// `ncfix correct-readings`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct MeasuredArguments {
    /// Table of readings; - for standard input
    #[arg(value_name = "DATA.csv")]
    pub(in crate::cli) data: PathBuf,
    /// Table with corrected positions; - for standard output
    #[arg(short, long, value_name = "OUT.csv")]
    pub(in crate::cli) output: PathBuf,
    #[command(flatten)]
    /// Machine file and set-up files.
    pub(in crate::cli) machine: MachineChoice,
    #[command(flatten)]
    /// Condition of the machine.
    pub(in crate::cli) state: StateChoice,
    /// Readings of the rotary axes
    #[arg(long, value_enum, default_value_t)]
    pub(in crate::cli) rotary: PoseRotaryChoice,
    /// Largest correction allowed, with unit; larger ones are refused
    #[arg(long, value_name = "LENGTH", default_value = MOST_CORRECTION, value_parser = value::positive_length_mm)]
    pub(in crate::cli) max_correction: f64,
}
