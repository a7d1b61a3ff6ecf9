//! The arguments of `ncfix simulate`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::{MachineChoice, ProgramChoice, StateChoice};
use crate::cli::value;

/// End of `ncfix simulate --help`.
pub(in crate::cli) const AFTER_HELP: &str = "\
PLAN.csv and PLAN.toml are a measurement (docs/reference/data-files.md) whose reading columns are empty or missing. MEASURED.csv gets the readings of the machine \
with its errors (for probing: the axis positions), and MEASURED.toml the description. Unknowns of a set-up have the described values: the \
table ball of a ball-bar is at centre_mm, a probed ball at place_mm of [ball.LABEL], else at the mean of the nominal tips of its rows. To try an error \
of your own, write it into a copy of the machine file ([[motion]]), and simulate with this copy (docs/reference/plan.md).

A part program instead of a plan runs through a model of the servo loops ([servo] of the machine file, docs/reference/servo.md). The table is then a trace for ncfix \
decompose: set-points and encoder positions in each cycle of the control, and the deviation of the tool from the programmed position.

Examples:
  ncfix simulate --machine mill.toml plan.csv -o measured.csv --noise 0.5um --seed 1
  ncfix simulate --machine mill.toml part.mpf -o trace.csv
  ncfix simulate --machine mill.toml test.mpf --feed 1000,5000,20000 -o trace.csv";

/// `ncfix simulate`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct SimulateArguments {
    /// Planned measurement, with its description PLAN.toml in the same folder; or a part program
    #[arg(value_name = "PLAN.csv|PROGRAM")]
    pub(in crate::cli) plan: PathBuf,
    /// Table to write; its description goes into the same folder
    #[arg(short, long, value_name = "MEASURED.csv")]
    pub(in crate::cli) output: PathBuf,
    #[command(flatten)]
    /// Machine file and set-up files.
    pub(in crate::cli) machine: MachineChoice,
    #[command(flatten)]
    /// Condition of the machine.
    pub(in crate::cli) state: StateChoice,
    #[command(flatten)]
    /// Reading and execution of the program.
    pub(in crate::cli) program: ProgramChoice,
    /// Run the program once at each of these feeds, mm/min, instead of its own
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = feed)]
    pub(in crate::cli) feed: Vec<f64>,
    /// Standard deviation of normal noise on readings, with unit; for angles the same number in µrad as for lengths in µm
    #[arg(long, value_name = "LENGTH", value_parser = value::positive_length_mm)]
    pub(in crate::cli) noise: Option<f64>,
    /// Seed of the noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(in crate::cli) seed: u64,
}

fn feed(text: &str) -> Result<f64, String> {
    let value: Option<f64> = text.trim().parse().ok().filter(|feed: &f64| (1.0..=1e6).contains(feed));
    value.ok_or_else(|| "write feeds in mm/min, from 1 to 1000000, such as 1000,5000".into())
}
