//! The arguments of `ncfix calibrate`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::{PageChoice, StateChoice};
use crate::cli::value;

/// End of `ncfix calibrate --help`.
pub(in crate::cli) const AFTER_HELP: &str = "\
A measurement is a table NAME.csv with its description NAME.toml in the same folder: docs/reference/data-files.md. ncfix fits all measurements \
together, with the unknowns of each set-up. START.toml has the axes, the kinematic chain and the initial errors. ncfix keeps its text and changes only \
the parameters of the model. If the data cannot separate some parameters, ncfix names them and writes nothing.

Temperature columns and load_N of a table give the condition of each row. For tables without them, --state, --time and --load give the condition of all \
measurements, including those held out.

A term states your own deviation, as for ncfix diagnose --hypothesis: docs/reference/terms.md. A term that is not a parameter of the machine file gets an entry there, if the file has one for it.

--select adds the parameters that the data support: they must be significant, and improve the prediction of left-out readings. Candidates, separated by \
commas, are presets, motion (all motion errors of the linear axes), errors (EXX), parameters (EXX2@150) and files with one parameter per line. Errors \
have degrees up to --degree, and knots every --knots within the measured range.

Without --model, ncfix takes the usual errors of the machine: positions of rotary axes, squareness, scales, backlash. It leaves out what the data do not \
determine, and says why (W0605). Then it adds higher-order terms of positioning and straightness, as --select does.

Examples:
  ncfix calibrate readings --machine start.toml -o machine.toml
  ncfix calibrate balls.csv circles.csv --machine start.toml --model mayer-13 -o machine.toml --hold-out balls_2.csv
  ncfix calibrate balls.csv --machine start.toml --model growth.txt --state shift.csv --load 2000 -o machine.toml
  ncfix calibrate laser.csv --machine start.toml --model none --select motion --knots 50mm -o machine.toml
  ncfix calibrate grid.csv --machine start.toml --model \"EC0X,EXX ~ Y^2,backlash EXX\" -o machine.toml";

/// `ncfix calibrate`. A drift counts from the zero of the instrument; a zero offset has no effect on readings.
#[derive(Clone, Debug, Args)]
#[command(mut_arg("zero", |one| one.hide(true)), mut_arg("zero_time", |one| one.help("Time in the log at which the instrument was zeroed, s: drift is relative to it")), mut_arg("zero_at", |one| one.help("Axis positions at which the instrument was zeroed (mm, deg): the drift at this pose counts as zero")))]
pub(in crate::cli) struct CalibrateArguments {
    /// Tables of readings, each with its description NAME.toml in the same folder; for a folder: all measurements in it
    #[arg(value_name = "DATA.csv|FOLDER", required = true)]
    pub(in crate::cli) data: Vec<PathBuf>,
    /// Initial machine file
    #[arg(short, long, value_name = "START.toml")]
    pub(in crate::cli) machine: PathBuf,
    /// Head of the machine file whose errors the readings contain
    #[arg(long, value_name = "NAME")]
    pub(in crate::cli) head: Option<String>,
    /// Parameters to fit: auto for those that the data determine, a preset (see `ncfix machine presets`), a file with one per line, or presets, parameters and terms such as "EXX ~ Y^2", separated by commas; `none` only together with --select
    #[arg(long, value_name = "auto|PRESET|FILE|TERMS", default_value = "auto")]
    pub(in crate::cli) model: String,
    /// Candidates for further parameters, of which the data select some: presets, motion, EXX, EXX2@150 or files, separated by commas
    #[arg(long, value_name = "CANDIDATES")]
    pub(in crate::cli) select: Option<String>,
    /// Distance between knots of candidates, whole mm
    #[arg(long, value_name = "LENGTH", default_value = "50mm", value_parser = value::whole_mm, requires = "select")]
    pub(in crate::cli) knots: i32,
    /// Highest degree of candidates (truncated powers: at most 2)
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=9), requires = "select")]
    pub(in crate::cli) degree: u8,
    /// Probability of selecting a candidate if there is no effect
    #[arg(long, value_name = "PERCENT", default_value = "1%", value_parser = value::percent, requires = "select")]
    pub(in crate::cli) significance: f64,
    #[command(flatten)]
    /// Condition for tables that do not state it.
    pub(in crate::cli) state: StateChoice,
    /// Machine file to write; - for standard output
    #[arg(short, long, value_name = "MACHINE.toml")]
    pub(in crate::cli) output: PathBuf,
    #[command(flatten)]
    /// Report page and its pictures.
    pub(in crate::cli) page: PageChoice,
    /// Measurements held out of the fit, to test the result
    #[arg(long, alias = "holdout", value_name = "DATA.csv", num_args = 1..)]
    pub(in crate::cli) hold_out: Vec<PathBuf>,
    /// Write the residual of each reading: file, line, positions, reading, model, residual
    #[arg(long, value_name = "FILE.csv")]
    pub(in crate::cli) residuals: Option<PathBuf>,
    /// Omit parameters that the data cannot separate from others, the most complex first, and list them (docs/explanation/calibration.md)
    #[arg(long)]
    pub(in crate::cli) reduce: bool,
    /// Weight all readings equally, even those that do not fit the others
    #[arg(long)]
    pub(in crate::cli) no_robust: bool,
    /// Largest reading and parameter allowed, with unit; larger ones are refused
    #[arg(long, value_name = "LENGTH", default_value = "1mm", value_parser = value::positive_length_mm)]
    pub(in crate::cli) max: f64,
    /// Simulate the readings N times with the estimated noise, fit them again, and show the scatter next to the uncertainties
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(10..=1_000_000))]
    pub(in crate::cli) monte_carlo: Option<u64>,
    /// Seed of the noise of --monte-carlo
    #[arg(long, value_name = "N", default_value_t = 1, requires = "monte_carlo")]
    pub(in crate::cli) seed: u64,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub(in crate::cli) json: bool,
}
