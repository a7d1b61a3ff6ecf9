//! The arguments of `ncfix diagnose`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::{MachineChoice, PageChoice};

/// What `ncfix diagnose --help` says last.
pub(in crate::cli) const AFTER_HELP: &str = "\
Each measurement is a table NAME.csv with its description NAME.toml beside it: docs/calibrate.md. Every column of numbers is something that an error may \
depend on: feed_mm_min, t_s, T_NAME_C, humidity.

A cause is named where it stands beside what neighbouring readings have in common and beside the number of all that were tried, and where it also \
helps on runs or set-ups that it was not found in. What data of --holdout does not confirm is not named. docs/diagnose.md says more.

Examples:
  ncfix diagnose circles.csv --machine mill.toml
  ncfix diagnose circles.csv --machine mill.toml --holdout circles_2.csv -o extended.toml
  ncfix diagnose circles.csv --machine mill.toml --report circles.html
  ncfix diagnose warm.csv plate.csv --machine mill.toml --json";

/// `ncfix diagnose`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct DiagnoseArguments {
    /// Tables of readings, each with its description NAME.toml beside it
    #[arg(value_name = "DATA.csv", required = true)]
    pub(in crate::cli) data: Vec<PathBuf>,
    #[command(flatten)]
    /// Which machine.
    pub(in crate::cli) machine: MachineChoice,
    /// Measurements in which no cause is looked for, but which must confirm those that are found
    #[arg(long, alias = "hold-out", value_name = "DATA.csv", num_args = 1..)]
    pub(in crate::cli) holdout: Vec<PathBuf>,
    /// Write the machine file with what was found; - for standard output
    #[arg(short, long, value_name = "EXTENDED.toml")]
    pub(in crate::cli) output: Option<PathBuf>,
    #[command(flatten)]
    /// Which page.
    pub(in crate::cli) page: PageChoice,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub(in crate::cli) json: bool,
}
