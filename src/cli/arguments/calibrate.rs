//! The arguments of `ncfix calibrate`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::value;

/// What `ncfix calibrate --help` says last.
pub(super) const AFTER_HELP: &str = "\
A measurement is a table NAME.csv and its description NAME.toml beside it: docs/calibrate.md. All measurements are fitted together, with what is \
unknown of each set-up. START.toml gives axes and chain, and the errors to begin with; its text stays, and only the parameters of the model change. \
Where the data cannot tell the parameters apart the message says which, and nothing is written.

Examples:
  ncfix calibrate balls.csv circles.csv --machine start.toml --model mayer-13 -o machine.toml --hold-out balls_2.csv
  ncfix calibrate balls.csv --machine start.toml --model mayer-13 -o machine.toml --report balls.html";

/// `ncfix calibrate`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct CalibrateArguments {
    /// Tables of readings, each with its description NAME.toml beside it
    #[arg(value_name = "DATA.csv", required = true)]
    pub(in crate::cli) data: Vec<PathBuf>,
    /// Machine file to begin with
    #[arg(long, value_name = "START.toml")]
    pub(in crate::cli) machine: PathBuf,
    /// Parameters that are fitted: a preset (see `ncfix machine presets`), or a file with one of them in each line
    #[arg(long, value_name = "PRESET|FILE")]
    pub(in crate::cli) model: String,
    /// The machine file to write; - for standard output
    #[arg(short, long, value_name = "MACHINE.toml")]
    pub(in crate::cli) output: PathBuf,
    /// Write a page (HTML) with tables and pictures of everything; also where the calibration is refused
    #[arg(long, value_name = "REPORT.html")]
    pub(in crate::cli) report: Option<PathBuf>,
    /// Measurements that are not fitted but say how good the result is
    #[arg(long, value_name = "DATA.csv", num_args = 1..)]
    pub(in crate::cli) hold_out: Vec<PathBuf>,
    /// Count all readings alike, also those that do not fit the others
    #[arg(long)]
    pub(in crate::cli) no_robust: bool,
    /// Refuse readings and parameters beyond this, with its unit
    #[arg(long, value_name = "LENGTH", default_value = "1mm", value_parser = value::positive_length_mm)]
    pub(in crate::cli) max: f64,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub(in crate::cli) json: bool,
}
