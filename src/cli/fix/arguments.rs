//! The arguments that say how a program is corrected.

use clap::{Args, ValueEnum};

use crate::cli::value;
use crate::options::Options;
use ncfix_model::Solve;
use ncfix_path::path::{Arcs, FiveAxis, OutputFrame, Rapids, Rotary};

/// Corrections beyond this are refused where nothing else is said: a machine that is further off is not a machine but a wrong unit.
pub(in crate::cli) const MOST_CORRECTION: &str = "0.2mm";

/// Arcs in the output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum ArcChoice {
    /// Arcs stay arcs where one fits within the tolerance
    #[default]
    Keep,
    /// Arcs become straight pieces
    Chords,
}

/// Rapid moves in the output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum RapidChoice {
    /// The end point is corrected where a cut begins there; else only the axes named move
    #[default]
    Ends,
    /// Left as they are
    None,
    /// The approach to a cut is subdivided and corrected like feed moves
    All,
}

/// Coordinates of the output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum FrameChoice {
    /// In the program's own zero offset
    #[default]
    Work,
    /// Machine coordinates, each block with G153
    Machine,
}

/// Five-axis transformations in the output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum FiveAxisChoice {
    /// TRAORI stays: positions of the tip in the workpiece
    #[default]
    Tcp,
    /// Positions of the axes in machine coordinates, without TRAORI
    Axes,
}

/// Radius compensation in the output of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum CompensationChoice {
    /// The way of the tool center: radius and wear at the control have no effect
    #[default]
    Center,
    /// The way of the tool center with G41 and G42 for wear: the control must have the radius 0 plus wear
    Wear,
}

/// Rotary axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum RotaryChoice {
    /// Those that the operation turns with feed are corrected, the others stay as programmed
    #[default]
    Auto,
    /// Corrected like the linear axes wherever they are not clamped
    Correct,
    /// Left as programmed; only the position of the tip is corrected
    Hold,
}

/// How a program is corrected.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct CorrectionChoice {
    /// Largest deviation of an emitted piece from the exactly corrected path, with its unit
    #[arg(long, value_name = "LENGTH", default_value = "1um", value_parser = value::positive_length_mm)]
    pub(in crate::cli) tolerance: f64,
    /// Fixed step along the leading axis instead of subdivision by tolerance, with its unit: 20mm
    #[arg(long, value_name = "LENGTH", value_parser = value::step_mm)]
    pub(in crate::cli) step: Option<f64>,
    /// Arcs
    #[arg(long, value_enum, default_value_t)]
    pub(in crate::cli) arcs: ArcChoice,
    /// Rapid moves
    #[arg(long, value_enum, default_value_t)]
    pub(in crate::cli) rapids: RapidChoice,
    /// Coordinates of the output
    #[arg(long, value_enum, default_value_t)]
    pub(in crate::cli) frame: FrameChoice,
    /// Five-axis transformations
    #[arg(long, value_enum, default_value_t)]
    pub(in crate::cli) five_axis: FiveAxisChoice,
    /// Rotary axes
    #[arg(long, value_enum, default_value_t)]
    pub(in crate::cli) rotary: RotaryChoice,
    /// Smallest increment of linear axes in the output, with its unit; without it that of the machine file
    #[arg(long, value_name = "LENGTH", value_parser = value::increment_mm)]
    pub(in crate::cli) increment: Option<f64>,
    /// Refuse corrections beyond this, with its unit
    #[arg(long, value_name = "LENGTH", default_value = MOST_CORRECTION, value_parser = value::positive_length_mm)]
    pub(in crate::cli) max_correction: f64,
}

impl CorrectionChoice {
    /// The same for the library.
    pub(in crate::cli) fn options(&self) -> Options {
        Options {
            tolerance_mm: self.tolerance,
            step_mm: self.step,
            arcs: match self.arcs {
                ArcChoice::Keep => Arcs::Keep,
                ArcChoice::Chords => Arcs::Chords,
            },
            rapids: match self.rapids {
                RapidChoice::Ends => Rapids::Ends,
                RapidChoice::None => Rapids::None,
                RapidChoice::All => Rapids::All,
            },
            frame: match self.frame {
                FrameChoice::Work => OutputFrame::Work,
                FrameChoice::Machine => OutputFrame::Machine,
            },
            five_axis: match self.five_axis {
                FiveAxisChoice::Tcp => FiveAxis::Tcp,
                FiveAxisChoice::Axes => FiveAxis::Axes,
            },
            rotary: self.rotary.into(),
            increment_mm: self.increment,
            max_correction_mm: self.max_correction,
            ..Options::default()
        }
    }
}

impl RotaryChoice {
    /// The same where there is no operation: whether rotary axes are corrected.
    pub(in crate::cli) fn solve(self) -> Solve {
        match self {
            RotaryChoice::Auto | RotaryChoice::Correct => Solve::Full,
            RotaryChoice::Hold => Solve::PositionOnly,
        }
    }
}

impl From<RotaryChoice> for Rotary {
    fn from(choice: RotaryChoice) -> Rotary {
        match choice {
            RotaryChoice::Auto => Rotary::Auto,
            RotaryChoice::Correct => Rotary::Correct,
            RotaryChoice::Hold => Rotary::Hold,
        }
    }
}
