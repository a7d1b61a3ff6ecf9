//! The arguments of `ncfix sensors`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::MachineChoice;
use crate::cli::value;
use ncfix_metrology::calibrate::sensors::SelectionOptions;

/// What `ncfix sensors --help` says last.
pub(in crate::cli) const AFTER_HELP: &str = "\
Each table is one run: t_s (s), T_NAME_C for every sensor (°C), and dx_um, dy_um, dz_um (any of them): displacement of the tool relative to the \
workpiece. A column with the letter of an axis (mm, deg) gives the places at which it was measured; each place gets sensors of its own.

For each number of sensors the best ones are found by exact search. The number is the smallest that tells the independent run (--verify; without it \
the last third of every run, which is held back) as well as any, within one standard error.

With --watch the argument is the file of live sensors (docs/sensors.md): their values are read and shown, with age and state, until Ctrl-C or for \
--for seconds. It ends with status 4 where one of them is not good at the end.

Examples:
  ncfix sensors S.toml --watch
  ncfix sensors S.toml --watch --for 3600 --log warm.csv
  ncfix sensors warm1.csv warm2.csv --machine mill.toml --verify other_day.csv --lags -o drift.toml";

/// `ncfix sensors`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct SensorsArguments {
    /// Tables of temperatures and displacements; with --watch the file of live sensors
    #[arg(value_name = "DATA.csv", required = true)]
    pub(in crate::cli) data: Vec<PathBuf>,
    #[command(flatten)]
    /// Which machine.
    pub(in crate::cli) machine: MachineChoice,
    /// Runs that were not learned from; may be given several times
    #[arg(long, value_name = "RUN.csv")]
    pub(in crate::cli) verify: Vec<PathBuf>,
    /// Log of temperatures with the same clock, where DATA.csv has none; with --watch the log to write
    #[arg(long, value_name = "LOG.csv")]
    pub(in crate::cli) log: Option<PathBuf>,
    /// The largest number of sensors
    #[arg(long, value_name = "N", default_value_t = 9, value_parser = clap::value_parser!(u8).range(1..=12))]
    pub(in crate::cli) most: u8,
    /// Search time constants too
    #[arg(long)]
    pub(in crate::cli) lags: bool,
    /// Shrink the coefficients as for readings that are wrong by so many K
    #[arg(long, value_name = "K", num_args = 0..=1, require_equals = true, default_missing_value = "0.5", value_parser = value::kelvin)]
    pub(in crate::cli) ridge: Option<f64>,
    /// File to write, with drift entries for the machine file; - for standard output
    #[arg(short, long, value_name = "DRIFT.toml")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// Print one JSON object on standard output; with --watch one for each poll, a line each
    #[arg(long)]
    pub(in crate::cli) json: bool,
    /// Read live sensors and show them
    #[arg(long, conflicts_with_all = ["machine", "setup", "verify", "most", "lags", "ridge", "output"])]
    pub(in crate::cli) watch: bool,
    /// End after so many seconds
    #[arg(long = "for", value_name = "SECONDS", requires = "watch", value_parser = value::seconds)]
    pub(in crate::cli) duration: Option<std::time::Duration>,
}

impl SensorsArguments {
    /// How sensors are selected.
    pub(super) fn options(&self) -> SelectionOptions {
        SelectionOptions { most: usize::from(self.most), lags: self.lags, fault_k: self.ridge.unwrap_or_default() }
    }
}
