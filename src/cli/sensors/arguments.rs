//! The arguments of `ncfix sensors`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::MachineChoice;
use crate::cli::value;
use ncfix_metrology::calibrate::sensors::{SelectionOptions, Shrinkage};

/// End of `ncfix sensors --help`.
pub(in crate::cli) const AFTER_HELP: &str = "\
Each table is one run: t_s (s), T_NAME_C for every sensor (°C), and dx_um, dy_um, dz_um (any of them): displacement of the tool relative to the \
workpiece. A column with an axis letter (mm, deg) gives the measuring positions; each position gets its own sensors.

For each number of sensors, an exact search finds the best ones. The number is the smallest that predicts the independent run (--verify; default: the \
last third of every run, which is held out) as well as the best, within one standard error.

With --watch, the argument is the file of live sensors (docs/reference/sensors.md): their values are shown with age and state until Ctrl-C or for --for \
seconds. The exit status is 4 if one of them is not good at the end.

Examples:
  ncfix sensors S.toml --watch
  ncfix sensors S.toml --watch --for 3600 --log warm.csv
  ncfix sensors warm1.csv warm2.csv --machine mill.toml --verify other_day.csv --lags -o drift.toml";

/// `ncfix sensors`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct SensorsArguments {
    /// Tables of temperatures and displacements; with --watch the file of live sensors
    #[arg(value_name = "FILE", required = true)]
    pub(in crate::cli) data: Vec<PathBuf>,
    #[command(flatten)]
    /// Machine file and set-up files.
    pub(in crate::cli) machine: MachineChoice,
    /// Independent runs to test the result, not used for the selection; repeatable
    #[arg(long, value_name = "RUN.csv")]
    pub(in crate::cli) verify: Vec<PathBuf>,
    /// Temperature log with the same clock, if the tables have no temperatures; with --watch, the log to write
    #[arg(long, value_name = "LOG.csv")]
    pub(in crate::cli) log: Option<PathBuf>,
    /// Largest number of sensors
    #[arg(long, value_name = "N", default_value_t = 9, value_parser = clap::value_parser!(u8).range(1..=12))]
    pub(in crate::cli) most: u8,
    /// Also search for time constants
    #[arg(long)]
    pub(in crate::cli) lags: bool,
    /// Shrink the coefficients as for reading errors of this size, K (0.5 if no value is given)
    #[arg(long, value_name = "K", num_args = 0..=1, require_equals = true, default_missing_value = "0.5", value_parser = value::kelvin)]
    pub(in crate::cli) ridge: Option<f64>,
    /// Fit the coefficients to this number of principal components of the temperatures, instead of --ridge
    #[arg(long, value_name = "N", conflicts_with = "ridge", value_parser = clap::value_parser!(u8).range(1..=12))]
    pub(in crate::cli) components: Option<u8>,
    /// File to write, with drift entries for the machine file; - for standard output
    #[arg(short, long, value_name = "DRIFT.toml")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// Print one JSON object on standard output; with --watch, one line for each poll
    #[arg(long)]
    pub(in crate::cli) json: bool,
    /// Read and show live sensors
    #[arg(long, conflicts_with_all = ["machine", "setup", "verify", "most", "lags", "ridge", "components", "output"])]
    pub(in crate::cli) watch: bool,
    /// End after this time, s
    #[arg(long = "for", value_name = "SECONDS", requires = "watch", value_parser = value::seconds)]
    pub(in crate::cli) duration: Option<std::time::Duration>,
}

impl SensorsArguments {
    /// Settings of the selection.
    pub(super) fn options(&self) -> SelectionOptions {
        let ridge = Shrinkage::ReadingError(self.ridge.unwrap_or_default());
        let shrinkage = self.components.map_or(ridge, |count| Shrinkage::Components(usize::from(count)));
        SelectionOptions { most: usize::from(self.most), lags: self.lags, shrinkage }
    }
}
