//! The arguments of `ncfix diagnose`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::{MachineChoice, PageChoice};

/// End of `ncfix diagnose --help`.
pub(in crate::cli) const AFTER_HELP: &str = "\
Each measurement is a table NAME.csv with its description NAME.toml in the same folder: docs/reference/data-files.md. Errors may depend on any \
numeric column: feed_mm_min, t_s, T_NAME_C, humidity.

ncfix names a cause only if it remains significant with the autocorrelation of the readings and the number of candidates tested. It must also improve \
the prediction of left-out runs or set-ups, and of the data of --hold-out (docs/reference/diagnose.md).

--hypothesis tests your own term: its amount, the evidence for or against it, its gain on left-out readings, other explanations. \
docs/reference/terms.md has the grammar.

Examples:
  ncfix diagnose circles.csv --machine mill.toml
  ncfix diagnose circles.csv --machine mill.toml --hold-out circles_2.csv -o extended.toml
  ncfix diagnose grid.csv --machine mill.toml --hypothesis \"EXX ~ Y^2\" --hypothesis \"backlash EXX\"
  ncfix diagnose warm.csv plate.csv --machine mill.toml --json";

/// `ncfix diagnose`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct DiagnoseArguments {
    /// Tables of readings, each with its description NAME.toml in the same folder; for a folder: all measurements in it
    #[arg(value_name = "DATA.csv|FOLDER", required = true)]
    pub(in crate::cli) data: Vec<PathBuf>,
    #[command(flatten)]
    /// Machine file and set-up files.
    pub(in crate::cli) machine: MachineChoice,
    /// Measurements that are not used to find causes but must confirm them
    #[arg(long = "hold-out", alias = "holdout", value_name = "DATA.csv", num_args = 1..)]
    pub(in crate::cli) holdout: Vec<PathBuf>,
    /// Hypothesis to test, for example "EXX ~ Y^2" or "backlash EXX"; may be given several times
    #[arg(long, value_name = "TERM")]
    pub(in crate::cli) hypothesis: Vec<String>,
    /// Machine file to write, extended by the causes found; - for standard output
    #[arg(short, long, value_name = "EXTENDED.toml")]
    pub(in crate::cli) output: Option<PathBuf>,
    #[command(flatten)]
    /// Report page and its pictures.
    pub(in crate::cli) page: PageChoice,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub(in crate::cli) json: bool,
}
