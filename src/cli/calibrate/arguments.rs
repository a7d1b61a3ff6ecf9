//! The arguments of `ncfix calibrate`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::{PageChoice, StateChoice};
use crate::cli::value;

/// What `ncfix calibrate --help` says last.
pub(in crate::cli) const AFTER_HELP: &str = "\
A measurement is a table NAME.csv and its description NAME.toml beside it: docs/reference/data-files.md. All measurements are fitted together, with what is \
unknown of each set-up. START.toml gives axes and chain, and the errors to begin with; its text stays, and only the parameters of the model change. \
Where the data cannot tell the parameters apart the message says which, and nothing is written.

Columns of temperatures and load_N in a table say in which condition a row was read; --state, --time and --load say it for all measurements where the \
tables do not, those held out too.

--select finds which further parameters the data needs: candidates enter, leave and take each other's place as long as a criterion falls, are tested with \
the correlation of neighbouring readings, and must say something of readings that were held out. Candidates are presets, motion (all motion errors of the \
linear axes), errors (EXX), parameters (EXX2@150) and files with one of them in each line, with commas between them; errors have degrees up to \
--degree, and knots every --knots inside what was measured.

Examples:
  ncfix calibrate balls.csv circles.csv --machine start.toml --model mayer-13 -o machine.toml --hold-out balls_2.csv
  ncfix calibrate balls.csv --machine start.toml --model mayer-13 -o machine.toml --report balls.html
  ncfix calibrate balls.csv --machine start.toml --model growth.txt --state shift.csv --load 2000 -o machine.toml
  ncfix calibrate laser.csv --machine start.toml --model none --select motion --knots 50mm -o machine.toml
  ncfix calibrate laser.csv level.csv --machine start.toml --model spaan-21 --select EXX,EYX1@300 -o machine.toml";

/// `ncfix calibrate`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct CalibrateArguments {
    /// Tables of readings, each with its description NAME.toml beside it
    #[arg(value_name = "DATA.csv", required = true)]
    pub(in crate::cli) data: Vec<PathBuf>,
    /// Machine file to begin with
    #[arg(long, value_name = "START.toml")]
    pub(in crate::cli) machine: PathBuf,
    /// Parameters that are fitted: a preset (see `ncfix machine presets`), a file with one of them in each line, or none beside --select
    #[arg(long, value_name = "PRESET|FILE")]
    pub(in crate::cli) model: String,
    /// Candidates, of which the data chooses those that it needs beside --model: a preset, motion, EXX, EXX2@150, or a file, with commas
    #[arg(long, value_name = "CANDIDATES")]
    pub(in crate::cli) select: Option<String>,
    /// Distance of the knots of candidates, whole mm
    #[arg(long, value_name = "LENGTH", default_value = "50mm", value_parser = value::whole_mm, requires = "select")]
    pub(in crate::cli) knots: i32,
    /// Highest degree of candidates; truncated powers have 2 at most
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=9), requires = "select")]
    pub(in crate::cli) degree: u8,
    /// Chance that a candidate is chosen where there is no effect at all
    #[arg(long, value_name = "PERCENT", default_value = "1%", value_parser = value::percent, requires = "select")]
    pub(in crate::cli) significance: f64,
    #[command(flatten)]
    /// The condition where the tables do not say it.
    pub(in crate::cli) state: StateChoice,
    /// The machine file to write; - for standard output
    #[arg(short, long, value_name = "MACHINE.toml")]
    pub(in crate::cli) output: PathBuf,
    #[command(flatten)]
    /// Which page.
    pub(in crate::cli) page: PageChoice,
    /// Measurements that are not fitted but say how good the result is
    #[arg(long, alias = "holdout", value_name = "DATA.csv", num_args = 1..)]
    pub(in crate::cli) hold_out: Vec<PathBuf>,
    /// Leave out parameters that the data cannot tell from others, the least simple ones first, and say which (docs/reference/calibrate.md)
    #[arg(long)]
    pub(in crate::cli) reduce: bool,
    /// Count all readings alike, also those that do not fit the others
    #[arg(long)]
    pub(in crate::cli) no_robust: bool,
    /// Refuse readings and parameters beyond this, with its unit
    #[arg(long, value_name = "LENGTH", default_value = "1mm", value_parser = value::positive_length_mm)]
    pub(in crate::cli) max: f64,
    /// Simulate the readings so many times, with the noise that was found, fit them again, and show the scatter beside the uncertainties
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(10..=1_000_000))]
    pub(in crate::cli) monte_carlo: Option<u64>,
    /// Another number gives other noise for --monte-carlo
    #[arg(long, value_name = "N", default_value_t = 1, requires = "monte_carlo")]
    pub(in crate::cli) seed: u64,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub(in crate::cli) json: bool,
}
