//! The arguments of `ncfix tables`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use crate::cli::arguments::{MachineChoice, StateChoice};
use crate::cli::value::{self, MultiplicationChoice, OrientationChoice};
use crate::tables::TableOptions;
use crate::tables::live::Renewal;
use crate::tables::output::TableOutputs;
use crate::tool::ToolVector;
use ncfix_base::geometry::Axis;
use ncfix_base::units::um_from_mm;
use ncfix_tables::tables::{FORMATS, Format, format};

/// End of `ncfix tables --help`.
pub(in crate::cli) const AFTER_HELP: &str = "\
Formats (--list describes each):
  cec  enc  fanuc  pitch  heidenhain  grundig  comp  matrixkins  isg  etalon  ssfk
Schemes:
  functions      a table for each error function, for controls with their own kinematics
  grid           corrections of X, Y, Z on the smallest grid of positions that reaches the tolerance
  matrix         a matrix for scales and squareness of X, Y, Z
  own            a table for each axis over its own position, each point fitted freely
  polynomial     a table for each pair of axes, cubic polynomials (25 on five axes)
  free           a table for each pair of axes, each point fitted freely
  trigonometric  arms of the linear axes times trigonometric functions of a rotary axis (23 on five axes)
  fik            the terms of the linearized forward and inverse kinematics of the machine
  auto           the fewest tables that reach the tolerance

Tables are valid for one tool length, because a tilt of the tool moves its tip. --orientation sets the correction of rotary axes. Load tables while \
compensation is off, switch it on, and measure a circle or a few balls before and after: a wrong sign doubles the errors.

Examples:
  ncfix tables --machine mill.toml --format cec --scheme fik --tool 120 -o CEC.INI --check
  ncfix tables --machine mill.toml --format fanuc --scheme grid --tolerance 1um -o grid.csv --check
  ncfix tables --machine mill.toml --format cec --scheme auto --tolerance 2um -o CEC.INI
  ncfix tables --machine mill.toml --format cec --scheme fik --most 8 -o CEC.INI
  ncfix tables --read CEC.INI --machine mill.toml --check
  ncfix tables --machine mill.toml --format cec --scheme fik -o CEC.INI --state log.csv --watch
  ncfix tables --read OLD.INI --compare CEC.INI --svg both.svg
  ncfix tables --read CEC.INI --machine mill.toml --check --report cec.html
  ncfix tables --read EEC.INI --format comp -o joints.comp
  ncfix tables --read CEC.INI --machine bare.toml -o mill.toml";

/// `ncfix tables`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct TablesArguments {
    #[command(flatten)]
    /// Machine file and set-up files.
    pub(in crate::cli) machine: MachineChoice,
    #[command(flatten)]
    /// Condition of the machine.
    pub(in crate::cli) state: StateChoice,
    /// Format of the tables to write
    #[arg(long, value_name = "FORMAT", value_parser = named)]
    pub(in crate::cli) format: Option<&'static Format>,
    /// Scheme that fills the tables
    #[arg(long, value_name = "SCHEME", default_value = "auto", conflicts_with = "read")]
    pub(in crate::cli) scheme: String,
    /// File to write; formats of several files extend its name. With --read and without --format, M.toml is the machine file with the errors that
    /// the tables remove
    #[arg(short, long, value_name = "OUT")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// Read tables of a control: a file, several that belong together, or an archive
    #[arg(long, value_name = "FILE", num_args = 1..)]
    pub(in crate::cli) read: Vec<PathBuf>,
    /// Compare with the tables of another file: the corrections of both at poses of the volume
    #[arg(long, value_name = "FILE", requires = "read")]
    pub(in crate::cli) compare: Option<PathBuf>,
    /// Compute the residual error over the volume with the tables as written
    #[arg(long)]
    pub(in crate::cli) check: bool,
    /// Also count the tables that each error needs if the machine has no other; without a size in the machine file, 10 µm, 400 µrad or 40 µm/m
    #[arg(long, conflicts_with = "read")]
    pub(in crate::cli) each_error: bool,
    /// Continue, and read --state again: if a correction has changed by more than --change, write the tables again; until Ctrl-C or --for
    #[arg(long, requires = "state", conflicts_with_all = ["read", "json", "svg", "report", "most"])]
    pub(in crate::cli) watch: bool,
    /// Smallest change of a correction for which --watch writes the tables again, with unit; for a rotary axis at an arm of 1 m
    #[arg(long, value_name = "LENGTH", default_value = "1um", requires = "watch", value_parser = value::positive_length_mm)]
    pub(in crate::cli) change: f64,
    /// Interval for reading --state again, s
    #[arg(long, value_name = "SECONDS", default_value = "60", requires = "watch", value_parser = value::seconds)]
    pub(in crate::cli) update_s: Duration,
    /// End --watch after this time, s
    #[arg(long = "for", value_name = "SECONDS", requires = "watch", value_parser = value::seconds)]
    pub(in crate::cli) duration: Option<Duration>,
    /// Number of poses of the check
    #[arg(long, value_name = "N", default_value_t = 2000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(in crate::cli) poses: u32,
    /// Residual error allowed at the tool tip, RMS over the volume, with unit
    #[arg(long, value_name = "LENGTH", default_value = "1um", value_parser = value::positive_length_mm)]
    pub(in crate::cli) tolerance: f64,
    /// Largest number of tables: make the best set of them, and print the residual of the best set of each number
    #[arg(long, value_name = "N", conflicts_with = "read", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(in crate::cli) most: Option<u32>,
    /// Number of points of a table
    #[arg(long, value_name = "N", default_value_t = 37, value_parser = clap::value_parser!(u32).range(2..=2000))]
    pub(in crate::cli) points: u32,
    /// Correction of the tool direction by the rotary axes (default: smooth; six-rows for polynomial and trigonometric)
    #[arg(long, value_enum)]
    pub(in crate::cli) orientation: Option<OrientationChoice>,
    /// Range of an axis that the tables cover, mm or deg, instead of its travel; repeatable
    #[arg(long, value_name = "AXIS=LOW..HIGH", value_parser = value::axis_range, allow_hyphen_values = true)]
    pub(in crate::cli) range: Vec<(Axis, [f64; 2])>,
    /// Name of an axis at the control, such as X=AX1; repeatable
    #[arg(long, value_name = "AXIS=NAME", value_parser = value::axis_name)]
    pub(in crate::cli) axis_name: Vec<(Axis, String)>,
    /// Rule of the control for multiplied tables: only the product, or the product plus the table's own value (default: by the file or the machine
    /// file, else instead)
    #[arg(long, value_enum)]
    pub(in crate::cli) multiplication: Option<MultiplicationChoice>,
    /// Tool length along the spindle, mm, or X,Y,Z from gauge point to tip, mm (default: the longest tool of the machine file)
    #[arg(long, value_name = "LENGTH|X,Y,Z", allow_hyphen_values = true)]
    pub(in crate::cli) tool: Option<ToolVector>,
    /// Draw the tables into this file
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) svg: Option<PathBuf>,
    /// Write an HTML report with the residual errors, pictures and tables: one file that needs no network
    #[arg(long, value_name = "REPORT.html")]
    pub(in crate::cli) report: Option<PathBuf>,
    /// List formats and schemes
    #[arg(long)]
    pub(in crate::cli) list: bool,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub(in crate::cli) json: bool,
}

impl TablesArguments {
    /// The times and the change of --watch.
    pub(super) fn renewal(&self) -> Renewal {
        Renewal { period: self.update_s, least_um: um_from_mm(self.change), duration: self.duration }
    }

    /// The picture, the page and the JSON object.
    pub(super) fn outputs(&self) -> TableOutputs<'_> {
        TableOutputs { svg: self.svg.as_deref(), report: self.report.as_deref(), is_json: self.json }
    }

    /// Options to make and check the tables.
    pub(super) fn options(&self) -> TableOptions {
        TableOptions {
            scheme: self.scheme.clone(),
            points: self.points as usize,
            tolerance_mm: self.tolerance,
            tool: self.tool,
            poses: self.poses as usize,
            orientation: self.orientation.map(OrientationChoice::orientation),
            ranges_mm_deg: self.range.clone(),
            axis_names: self.axis_name.clone(),
            multiplication: self.multiplication.map(MultiplicationChoice::multiplication),
            tries_fewer: self.check || self.report.is_some(),
            most: self.most.map(|most| most as usize),
            each_error: self.each_error,
        }
    }
}

fn named(text: &str) -> Result<&'static Format, String> {
    let names = || FORMATS.iter().map(|format| format.name).collect::<Vec<_>>().join(", ");
    format::find(text).ok_or_else(|| format!("the formats are {}", names()))
}
