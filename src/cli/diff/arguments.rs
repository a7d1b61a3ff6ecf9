//! The arguments of `ncfix diff`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::{MachineChoice, ProgramChoice, StateChoice};
use crate::cli::value;
use ncfix_base::geometry::Axis;

/// What `ncfix diff --help` says last.
pub(in crate::cli) const AFTER_HELP: &str = "\
Both programs are executed, on the machine that is given or found as for a correction, so that expressions, loops and frames are numbers. What is \
shown is what was added to the words of the axes, in the coordinates in which the corrected program writes; \"1:3\" is a move that became three pieces.

Examples:
  ncfix diff part.mpf part_corrected.mpf --machine mill.toml
  ncfix diff part.mpf part_corrected.mpf --top 20
  ncfix diff part.mpf part_corrected.mpf --only 5um --axis Z
  ncfix diff part.mpf part_corrected.mpf --html review.html
  ncfix diff part.mpf part_corrected.mpf --fail-above 50um --json > review.json
  ncfix diff old.nc new.nc --text --tolerance 1um";

/// `ncfix diff`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct DiffArguments {
    /// Original part program
    pub(in crate::cli) original: PathBuf,
    /// Corrected part program
    pub(in crate::cli) corrected: PathBuf,
    #[command(flatten)]
    /// Which machine.
    pub(in crate::cli) machine: MachineChoice,
    #[command(flatten)]
    /// In which condition.
    pub(in crate::cli) state: StateChoice,
    #[command(flatten)]
    /// How the programs are executed.
    pub(in crate::cli) program: ProgramChoice,
    /// The N moves with the largest changes, the largest first, in place of all in the order of the program
    #[arg(long, value_name = "N")]
    pub(in crate::cli) top: Option<usize>,
    /// Only moves that are changed by at least this, with its unit; a rotary axis by what its angle makes at 1 m
    #[arg(long, value_name = "LENGTH", value_parser = value::positive_length_mm)]
    pub(in crate::cli) only: Option<f64>,
    /// Only this axis; may be given several times
    #[arg(long, value_name = "AXIS", value_parser = axis)]
    pub(in crate::cli) axis: Vec<Axis>,
    /// What is no larger is the same, with its unit; for rotary axes what their angle makes at 1 m
    #[arg(long, value_name = "LENGTH", value_parser = value::positive_length_mm)]
    pub(in crate::cli) tolerance: Option<f64>,
    /// Tolerance that the correction has promised, with its unit; without it what the stamp says
    #[arg(long, value_name = "LENGTH", value_parser = value::positive_length_mm, conflicts_with = "text")]
    pub(in crate::cli) promised: Option<f64>,
    /// Exit status 4 where an axis is changed by more, or something speaks against running it, else 0
    #[arg(long, value_name = "LENGTH", value_parser = value::positive_length_mm)]
    pub(in crate::cli) fail_above: Option<f64>,
    /// Write a page with plots, the path and all lines side by side: one file that opens in a browser without a network
    #[arg(long, value_name = "PAGE.html", conflicts_with = "text")]
    pub(in crate::cli) html: Option<PathBuf>,
    /// Show the temperatures and corrections of a transfer on the page, from its journal (`ncfix feed --journal`)
    #[arg(long, value_name = "JOB.jsonl", requires = "html")]
    pub(in crate::cli) journal: Option<PathBuf>,
    /// Compare the words as they are written, without a machine: block numbers, comments and the way numbers are written do not count
    #[arg(long)]
    pub(in crate::cli) text: bool,
    /// The summary without rows
    #[arg(long)]
    pub(in crate::cli) summary: bool,
    /// Write to the terminal without a pager
    #[arg(long)]
    pub(in crate::cli) no_pager: bool,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub(in crate::cli) json: bool,
}

fn axis(text: &str) -> Result<Axis, String> {
    let letter = if let [letter] = text.as_bytes() { Axis::from_letter(letter.to_ascii_uppercase()) } else { None };
    letter.ok_or_else(|| "an axis is X, Y, Z, U, V, W, A, B or C".to_owned())
}
