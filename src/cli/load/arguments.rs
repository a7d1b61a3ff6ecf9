//! The arguments of `ncfix weigh`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::MachineChoice;
use ncfix_metrology::measure::weighing::known_place;

/// End of `ncfix weigh --help`.
pub(in crate::cli) const AFTER_HELP: &str = "\
STRAIN.csv has a line of column names: the letter of the moved axis (X; mm), strain_um_m (µm/m), and optionally run and t_s (s). [strain] of the \
machine file has the reading of the gauge for a load; for a [[load_sensor]], the table has its column instead. Readings of one run share an offset, which drifts linearly with time if t_s is present. \
Measure every position twice, so that a reading disturbed by a lubrication pulse is detected. Uncertainties are standard uncertainties.

Examples:
  ncfix weigh strain.csv --machine mill.toml -o state.toml";

/// `ncfix weigh`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct LoadArguments {
    /// Table of readings; - for standard input
    #[arg(value_name = "STRAIN.csv")]
    pub(in crate::cli) data: PathBuf,
    /// State file to write, with the load; - for standard output
    #[arg(short, long, value_name = "STATE.toml")]
    pub(in crate::cli) output: Option<PathBuf>,
    #[command(flatten)]
    /// Machine file and set-up files.
    pub(in crate::cli) machine: MachineChoice,
    /// Known coordinates of the load, mm from the center of the table; the others are measured
    #[arg(long, value_name = "X0,Z-280", value_parser = known_place, allow_hyphen_values = true)]
    pub(in crate::cli) known: Option<[Option<f64>; 3]>,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub(in crate::cli) json: bool,
}
