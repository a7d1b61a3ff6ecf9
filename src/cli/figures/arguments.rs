//! The arguments of `ncfix figures`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::MachineChoice;

/// What `ncfix figures --help` says last.
pub(in crate::cli) const AFTER_HELP: &str = "\
A measurement is a pair of files, NAME.csv and NAME.toml, as ncfix calibrate reads it. Figures need no error model.

direct:  A, E, R, B, M of ISO 230-2 for every component and set-up; the sense of approach stands in X_dir …, or follows from the order of the rows
ballbar: G, F, D, H of ISO 230-4 for circles in a plane through the ball on the table, without the eccentricity of the set-up; size and form of
         the sphere of least squares for rows in no plane

Examples:
  ncfix figures laser_x.csv --machine mill.toml
  ncfix figures circles.csv hemisphere.csv --machine mill.toml --json";

/// `ncfix figures`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct FiguresArguments {
    /// Tables of measurements, each with its description beside
    #[arg(value_name = "DATA.csv", required = true)]
    pub(in crate::cli) data: Vec<PathBuf>,
    #[command(flatten)]
    /// Which machine.
    pub(in crate::cli) machine: MachineChoice,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub(in crate::cli) json: bool,
}
