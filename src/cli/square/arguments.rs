//! The arguments of `ncfix square`.

use std::path::PathBuf;

use clap::{ArgGroup, Args, ValueEnum};

use crate::cli::arguments::MachineChoice;
use ncfix_base::geometry::Plane;

/// End of `ncfix square --help`.
pub(in crate::cli) const AFTER_HELP: &str = "\
Cut a rectangle without correction. d1 is its diagonal from the corner with the smallest positions to the one with the largest, d2 the other one. With \
a square, align one leg with one axis, and move the other axis along the other leg in its positive direction. --dial is the change of the reading, + if the \
plunger is pressed in. The corner of the square may be on either side.

Examples:
  ncfix square --machine router.toml --d1 848.740 --d2 848.316 --side 600 --read-to 0.5 -o router_square.toml
  ncfix square --machine router.toml --d1 424.31 --d2 424.12 --sides 299.80,300.10 --nominal 300,300 -o router_square.toml
  ncfix square --machine mill.toml --square 300 --dial 0.04 --read-to 0.005
  ncfix square --machine mill.toml --d1 848.740 --d2 848.316 --side 600 --check-cut square.ngc";

/// Plane of two axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum PlaneChoice {
    /// X and Y
    Xy,
    /// Y and Z
    Yz,
    /// Z and X
    Zx,
}

impl PlaneChoice {
    /// The plane.
    pub(in crate::cli) fn plane(self) -> Plane {
        match self {
            PlaneChoice::Xy => Plane::XY,
            PlaneChoice::Yz => Plane::YZ,
            PlaneChoice::Zx => Plane::ZX,
        }
    }
}

/// `ncfix square`.
#[derive(Clone, Debug, Args)]
#[command(group(ArgGroup::new("reading").args(["d1", "square"]).required(true)))]
pub(in crate::cli) struct SquareArguments {
    /// Diagonal from the smallest to the largest positions, mm; needs --d2, and --side or --sides
    #[arg(long, value_name = "MM", requires = "d2", requires = "sizes")]
    pub(in crate::cli) d1: Option<f64>,
    /// The other diagonal, mm
    #[arg(long, value_name = "MM", requires = "d1")]
    pub(in crate::cli) d2: Option<f64>,
    /// Side of the square part, mm
    #[arg(long, value_name = "MM", group = "sizes")]
    pub(in crate::cli) side: Option<f64>,
    /// Sides of the part, mm; one length for a square
    #[arg(long, value_name = "A,B", value_delimiter = ',', group = "sizes")]
    pub(in crate::cli) sides: Vec<f64>,
    /// Programmed sides of the part, mm; needs the measured ones (--sides), which then give the scales of both axes too
    #[arg(long, value_name = "A,B", value_delimiter = ',', requires = "sides")]
    pub(in crate::cli) nominal: Vec<f64>,
    /// Length of the leg of a square along which an axis moves, mm
    #[arg(long, value_name = "MM", requires = "dial")]
    pub(in crate::cli) square: Option<f64>,
    /// Change of the dial gauge on the way along the leg in the positive direction of the axis, mm; + if the plunger is pressed in
    #[arg(long, value_name = "MM", allow_hyphen_values = true, requires = "square")]
    pub(in crate::cli) dial: Option<f64>,
    /// The plunger points in the negative direction of the other axis
    #[arg(long, requires = "dial")]
    pub(in crate::cli) plunger_negative: bool,
    /// Uncertainty of your reading, as ± mm (default: 0.5 for diagonals, 0.005 for a dial gauge)
    #[arg(long, value_name = "MM")]
    pub(in crate::cli) read_to: Option<f64>,
    /// The two axes
    #[arg(long, value_enum, default_value = "xy")]
    pub(in crate::cli) plane: PlaneChoice,
    #[command(flatten)]
    /// Machine file and set-up files.
    pub(in crate::cli) machine: MachineChoice,
    /// Machine file to write, with the squareness as a location error, and with --nominal the scales; comments are kept
    #[arg(short, long, value_name = "M.toml")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// Add to the existing value: the part was cut with the correction
    #[arg(long, requires = "output")]
    pub(in crate::cli) add: bool,
    /// Write the program of a test square in X and Y
    #[arg(long, value_name = "PROGRAM")]
    pub(in crate::cli) check_cut: Option<PathBuf>,
}
