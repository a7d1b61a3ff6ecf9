//! Arguments for the method of correction.

use clap::{Args, ValueEnum};

use crate::cli::value;
use crate::options::Options;
use ncfix_model::Solve;
use ncfix_path::path::{Arcs, FiveAxis, OutputFrame, Rapids, Rotary};

/// Default limit of corrections: a larger one comes from a wrong unit, not from a machine.
pub(in crate::cli) const MOST_CORRECTION: &str = "0.2mm";

/// Arcs in the output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum ArcChoice {
    /// Keep an arc if an arc fits within the tolerance
    #[default]
    Keep,
    /// Replace arcs by straight pieces
    Chords,
}

/// Rapid moves in the output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum RapidChoice {
    /// Correct the end point if a cut begins there; otherwise correct only the axes named in the block
    #[default]
    Ends,
    /// Leave rapid moves unchanged
    None,
    /// Divide the approach to a cut into pieces, and correct each, as for feed moves
    All,
}

/// Coordinates of the output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum FrameChoice {
    /// Coordinates in the program's own zero offset
    #[default]
    Work,
    /// Machine coordinates, each block with G153
    Machine,
}

/// Five-axis transformations in the output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum FiveAxisChoice {
    /// Keep TRAORI: tip positions in the workpiece
    #[default]
    Tcp,
    /// Axis positions in machine coordinates, without TRAORI
    Axes,
}

/// Radius compensation in the output of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum CompensationChoice {
    /// Tool center path: radius and wear at the control have no effect
    #[default]
    Center,
    /// Tool center path with G41 and G42 for wear: set the radius to 0 at the control and enter only the wear
    Wear,
}

/// Rotary axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum RotaryChoice {
    /// Correct the axes that a feed move turns before the next tool change, and keep the others as programmed
    #[default]
    Auto,
    /// Correct them like the linear axes wherever they are not clamped
    Correct,
    /// Keep them as programmed; correct only the tip position
    Hold,
}

/// Method of correction.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct CorrectionChoice {
    /// Largest deviation of an output piece from the exactly corrected path, with unit
    #[arg(long, value_name = "LENGTH", default_value = "1um", value_parser = value::positive_length_mm)]
    pub(in crate::cli) tolerance: f64,
    /// Largest deviation of a hole that stays a drilling cycle, with unit; the larger of this and --tolerance applies
    #[arg(long, value_name = "LENGTH", default_value = "2um", value_parser = value::positive_length_mm)]
    pub(in crate::cli) hole_tolerance: f64,
    /// Fixed step along the axis that moves farthest, instead of subdivision by tolerance, with unit, such as 20mm
    #[arg(long, value_name = "LENGTH", value_parser = value::step_mm)]
    pub(in crate::cli) step: Option<f64>,
    /// Arcs in the output
    #[arg(long, value_enum, default_value_t)]
    pub(in crate::cli) arcs: ArcChoice,
    /// Rapid moves in the output
    #[arg(long, value_enum, default_value_t)]
    pub(in crate::cli) rapids: RapidChoice,
    /// Coordinates of the output
    #[arg(long, value_enum, default_value_t)]
    pub(in crate::cli) frame: FrameChoice,
    /// Five-axis transformations in the output
    #[arg(long, value_enum, default_value_t)]
    pub(in crate::cli) five_axis: FiveAxisChoice,
    /// Correction of the rotary axes
    #[arg(long, value_enum, default_value_t)]
    pub(in crate::cli) rotary: RotaryChoice,
    /// Smallest increment of linear axes in the output, with unit (default: that of the machine file)
    #[arg(long, value_name = "LENGTH", value_parser = value::increment_mm)]
    pub(in crate::cli) increment: Option<f64>,
    /// Largest correction allowed, with unit; larger ones are refused
    #[arg(long, value_name = "LENGTH", default_value = MOST_CORRECTION, value_parser = value::positive_length_mm)]
    pub(in crate::cli) max_correction: f64,
}

impl CorrectionChoice {
    /// Options for the library.
    pub(in crate::cli) fn options(&self) -> Options {
        Options {
            tolerance_mm: self.tolerance,
            hole_tolerance_mm: self.hole_tolerance,
            step_mm: self.step,
            arcs: if self.arcs == ArcChoice::Chords { Arcs::Chords } else { Arcs::Keep },
            rapids: match self.rapids {
                RapidChoice::Ends => Rapids::Ends,
                RapidChoice::None => Rapids::None,
                RapidChoice::All => Rapids::All,
            },
            frame: if self.frame == FrameChoice::Machine { OutputFrame::Machine } else { OutputFrame::Work },
            five_axis: if self.five_axis == FiveAxisChoice::Axes { FiveAxis::Axes } else { FiveAxis::Tcp },
            rotary: self.rotary.into(),
            increment_mm: self.increment,
            max_correction_mm: self.max_correction,
            ..Options::default()
        }
    }
}

/// Rotary axes at single poses: readings and set-points belong to no operation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum PoseRotaryChoice {
    /// Correct the rotary axes too
    #[default]
    #[value(alias = "auto")]
    Correct,
    /// Leave the rotary axes unchanged; correct only the tip position
    Hold,
}

impl PoseRotaryChoice {
    /// Correction of rotary axes for the library.
    pub(in crate::cli) fn solve(self) -> Solve {
        match self {
            PoseRotaryChoice::Correct => Solve::Full,
            PoseRotaryChoice::Hold => Solve::PositionOnly,
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
