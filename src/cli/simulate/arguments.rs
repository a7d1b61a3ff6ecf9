//! The arguments of `ncfix simulate`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::{MachineChoice, ProgramChoice, StateChoice};
use crate::cli::value;

/// What `ncfix simulate --help` says last.
pub(in crate::cli) const AFTER_HELP: &str = "\
PLAN.csv and PLAN.toml are a measurement (docs/reference/data-files.md) whose columns of readings are empty or not there. MEASURED.csv has the readings, or for \
probing the axis positions, of the machine with its errors, and MEASURED.toml the description. What is unknown of a set-up is as described: the \
table ball of a ball-bar at centre_mm, a probed ball at place_mm of [ball.LABEL], else in the mean of the nominal tips of its rows.

A part program in place of a plan is driven through the servo loops of the machine ([servo] of its file, docs/reference/servo.md), and the table is a trace: set-points \
and encoders by cycles of the control, and the tool from where the program has it. ncfix decompose reads it.

Examples:
  ncfix simulate --machine mill.toml plan.csv -o measured.csv --noise 0.5um --seed 1
  ncfix simulate --machine mill.toml part.mpf -o trace.csv
  ncfix simulate --machine mill.toml test.mpf --feed 1000,5000,20000 -o trace.csv";

/// `ncfix simulate`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct SimulateArguments {
    /// The planned measurement, with its description PLAN.toml beside it; or a part program
    #[arg(value_name = "PLAN.csv|PROGRAM")]
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
    #[command(flatten)]
    /// How a program is executed.
    pub(in crate::cli) program: ProgramChoice,
    /// Drive a program once at each of these feeds, mm/min, in place of its own
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = feed)]
    pub(in crate::cli) feed: Vec<f64>,
    /// Standard deviation of normal noise on readings, with its unit; angles get as many µrad as lengths get µm
    #[arg(long, value_name = "LENGTH", value_parser = value::positive_length_mm)]
    pub(in crate::cli) noise: Option<f64>,
    /// Another number gives other noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(in crate::cli) seed: u64,
}

fn feed(text: &str) -> Result<f64, String> {
    let value: Option<f64> = text.trim().parse().ok().filter(|feed: &f64| (1.0..=1e6).contains(feed));
    value.ok_or_else(|| "write feeds in mm/min, from 1 to 1000000, as 1000,5000".into())
}
