//! The arguments of `ncfix measured`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::{MachineChoice, RotaryChoice, StateChoice};
use crate::cli::fix::arguments::MOST_CORRECTION;
use crate::cli::value;

/// What `ncfix measured --help` says last.
pub(in crate::cli) const AFTER_HELP: &str = "\
DATA.csv has a line of column names. Columns named by the axis letters of the machine (X, Y, Z, C …; mm, deg) are positions that were read and \
become those that a machine without errors would have read there. tool_x_mm, tool_y_mm, tool_z_mm (from the spindle nose to the tip) and X_dir … \
(-1, 0, 1: sense of the last motion; else it follows from the order of the rows within a run) are used; they and all other columns are passed \
through.

Examples:
  ncfix measured probing.csv -o probing_corrected.csv --machine mill.toml";

/// `ncfix measured`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct MeasuredArguments {
    /// Table of readings; - for standard input
    #[arg(value_name = "DATA.csv")]
    pub(in crate::cli) data: PathBuf,
    /// The table with corrected positions; - for standard output
    #[arg(short, long, value_name = "OUT.csv")]
    pub(in crate::cli) output: PathBuf,
    #[command(flatten)]
    /// Which machine.
    pub(in crate::cli) machine: MachineChoice,
    #[command(flatten)]
    /// In which condition.
    pub(in crate::cli) state: StateChoice,
    /// Rotary axes
    #[arg(long, value_enum, default_value_t)]
    pub(in crate::cli) rotary: RotaryChoice,
    /// Refuse corrections beyond this, with its unit
    #[arg(long, value_name = "LENGTH", default_value = MOST_CORRECTION, value_parser = value::positive_length_mm)]
    pub(in crate::cli) max_correction: f64,
}
