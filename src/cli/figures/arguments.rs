//! The arguments of `ncfix iso230`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::MachineChoice;

/// End of `ncfix iso230 --help`.
pub(in crate::cli) const AFTER_HELP: &str = "\
A measurement is a pair of files, NAME.csv and NAME.toml, as ncfix calibrate reads it. Figures need no error model, except what it explains of features.

direct:  A, E, R, B, M of ISO 230-2 for every component and set-up; the direction of approach is given in X_dir …, or is taken from the row order; the first row is left out if its direction is unknown; if its target then lacks a direction, there are no figures
ballbar: G, F, D, H of ISO 230-4 for circles in a plane through the ball on the table, without the eccentricity of the set-up; D and H only where the readings of each path are at most 0.1 rad (5.7 deg) apart; size and form of the least-squares sphere for rows that are not in one plane
features: deviations of a workpiece that was machined and then measured (ncfix plan workpiece): rms and largest value, what the errors of the machine file explain, the change from level to level, and each feature; of a second table also the change against the first

Examples:
  ncfix iso230 laser_x.csv --machine mill.toml
  ncfix iso230 circles.csv hemisphere.csv --machine mill.toml --json
  ncfix iso230 part_before.csv part_after.csv --machine mill.toml";

/// `ncfix iso230`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct FiguresArguments {
    /// Tables of readings, each with its description NAME.toml in the same folder; for a folder: all measurements in it
    #[arg(value_name = "DATA.csv|FOLDER", required = true)]
    pub(in crate::cli) data: Vec<PathBuf>,
    #[command(flatten)]
    /// Machine file and set-up files.
    pub(in crate::cli) machine: MachineChoice,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub(in crate::cli) json: bool,
}
