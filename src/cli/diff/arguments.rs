//! The arguments of `ncfix diff`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::{MachineChoice, ProgramChoice, StateChoice};
use crate::cli::value;
use ncfix_base::geometry::Axis;

/// End of `ncfix diff --help`.
pub(in crate::cli) const AFTER_HELP: &str = "\
ncfix executes both programs, with the machine file that a correction would use, so expressions, loops and frames become numbers. The rows show the \
corrections of the axis words, in the coordinates of the corrected program. \"1:3\" is a move that became three pieces. Equal rows are counted.

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
    /// Machine file and set-up files.
    pub(in crate::cli) machine: MachineChoice,
    #[command(flatten)]
    /// Condition of the machine.
    pub(in crate::cli) state: StateChoice,
    #[command(flatten)]
    /// Reading and execution of the programs.
    pub(in crate::cli) program: ProgramChoice,
    /// Show only the N moves with the largest changes, the largest first
    #[arg(long, value_name = "N")]
    pub(in crate::cli) top: Option<usize>,
    /// Show only moves changed by at least this, with unit (rotary axes: displacement at 1 m)
    #[arg(long, value_name = "LENGTH", value_parser = value::positive_length_mm)]
    pub(in crate::cli) only: Option<f64>,
    /// Show only this axis; repeatable
    #[arg(long, value_name = "AXIS", value_parser = axis)]
    pub(in crate::cli) axis: Vec<Axis>,
    /// Ignore changes up to this, with unit (rotary axes: displacement at 1 m)
    #[arg(long, value_name = "LENGTH", value_parser = value::positive_length_mm)]
    pub(in crate::cli) tolerance: Option<f64>,
    /// Tolerance promised by the correction, with unit (default: that of the stamp)
    #[arg(long, value_name = "LENGTH", value_parser = value::positive_length_mm, conflicts_with = "text")]
    pub(in crate::cli) promised: Option<f64>,
    /// Exit with status 4 if an axis is changed by more than this, with unit, or there is another reason not to run the program; else with 0
    #[arg(long, value_name = "LENGTH", value_parser = value::positive_length_mm)]
    pub(in crate::cli) fail_above: Option<f64>,
    /// Write an HTML page with plots, the path and all lines side by side: one file that needs no network
    #[arg(long, value_name = "PAGE.html", conflicts_with = "text")]
    pub(in crate::cli) html: Option<PathBuf>,
    /// Journal of a transfer (`ncfix feed --journal`) whose temperatures, corrections and buffer the page shows
    #[arg(long, value_name = "JOB.jsonl", requires = "html")]
    pub(in crate::cli) journal: Option<PathBuf>,
    /// Compare the words as written, without a machine; block numbers, comments and number formats are ignored
    #[arg(long)]
    pub(in crate::cli) text: bool,
    /// Show only the summary
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
