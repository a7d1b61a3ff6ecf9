//! The arguments of `ncfix simulate`.

use std::path::PathBuf;

use clap::Args;

use super::{MachineChoice, StateChoice};
use crate::cli::value;

/// What `ncfix simulate --help` says last.
pub(super) const AFTER_HELP: &str = "\
PLAN.csv and PLAN.toml are a measurement (docs/calibrate.md) whose columns of readings are empty or not there. MEASURED.csv has the readings, or for \
probing the axis positions, of the machine with its errors, and MEASURED.toml the description. What is unknown of a set-up is as described: the \
table ball of a ball-bar at centre_mm, a probed ball at place_mm of [ball.LABEL], else in the mean of the nominal tips of its rows.

Examples:
  ncfix simulate --machine mill.toml plan.csv -o measured.csv --noise 0.5um --seed 1";

/// `ncfix simulate`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct SimulateArguments {
    /// The planned measurement, with its description PLAN.toml beside it
    #[arg(value_name = "PLAN.csv")]
    pub(in crate::cli) plan: PathBuf,
    /// The table to write; its description goes beside it
    #[arg(short, long, value_name = "MEASURED.csv")]
    pub(in crate::cli) output: PathBuf,
    #[command(flatten)]
    /// Which machine.
    pub(in crate::cli) machine: MachineChoice,
    #[command(flatten)]
    /// In which condition.
    pub(in crate::cli) state: StateChoice,
    /// Standard deviation of normal noise on readings, with its unit; angles get as many µrad as lengths get µm
    #[arg(long, value_name = "LENGTH", value_parser = value::positive_length_mm)]
    pub(in crate::cli) noise: Option<f64>,
    /// Another number gives other noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(in crate::cli) seed: u64,
}
