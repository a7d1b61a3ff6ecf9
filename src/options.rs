//! Options of the library: reading of a program, condition of the machine, correction.

use std::path::PathBuf;
use std::str::FromStr;

use crate::error::Error;
use crate::stated_zero::StatedZero;
use ncfix_base::geometry::AxisVector;
use ncfix_machine::machine::Load;
use ncfix_path::path::{self, Arcs, FiveAxis, OutputFrame, Rapids, Rotary, Subdivision};

/// The control language of a program.
///
/// ```
/// use ncfix::prelude::*;
///
/// assert_eq!("fanuc".parse::<DialectChoice>().unwrap(), DialectChoice::Fanuc);
/// assert!("unknown".parse::<DialectChoice>().is_err());
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum DialectChoice {
    /// Detected from the file name or the first lines, then from typical words; else Sinumerik. Parsing uses the detected dialect; running uses the dialect of
    /// the machine's control if it has one.
    #[default]
    Guess,
    /// Siemens Sinumerik 840D, 828D.
    Sinumerik,
    /// Fanuc and compatible controls.
    Fanuc,
    /// RS274/NGC as in LinuxCNC.
    Rs274,
    /// Grundig, Philips, MillPlus.
    Grundig,
}

impl DialectChoice {
    /// Its name; `None` for `Guess`.
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// assert_eq!(DialectChoice::Rs274.name(), Some("rs274"));
    /// assert_eq!(DialectChoice::Guess.name(), None);
    /// ```
    #[must_use]
    pub fn name(self) -> Option<&'static str> {
        Some(match self {
            DialectChoice::Guess => return None,
            DialectChoice::Sinumerik => "sinumerik",
            DialectChoice::Fanuc => "fanuc",
            DialectChoice::Rs274 => "rs274",
            DialectChoice::Grundig => "grundig",
        })
    }
}

impl FromStr for DialectChoice {
    type Err = Error;

    fn from_str(name: &str) -> Result<DialectChoice, Error> {
        use DialectChoice::{Fanuc, Grundig, Rs274, Sinumerik};
        let all = [Sinumerik, Fanuc, Rs274, Grundig];
        let found = all.into_iter().find(|one| one.name() == Some(name));
        found.ok_or_else(|| Error::usage(format!("unknown dialect '{name}'")))
    }
}

/// Options for reading and executing a program.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ProgramReading {
    /// Name of the dialect; by default that of the machine file, then by file name and content.
    pub(crate) dialect: Option<String>,
    /// Maximum number of executed blocks; by default two million, or twenty times the number of blocks of the program
    /// if that is more.
    pub(crate) max_blocks: Option<u64>,
    /// Levels of `/` blocks that are skipped; `/` alone is level 0.
    pub(crate) skip: [bool; 10],
    /// Axis positions before the first block, machine coordinates.
    pub(crate) start: Option<AxisVector>,
}

/// Sources of the condition of a machine: files and values.
#[derive(Clone, Debug, Default)]
pub(crate) struct ConditionFiles {
    /// Temperatures and loads: state files (TOML) or logs (CSV); values of a later file replace those of an earlier
    /// one.
    pub(crate) files: Vec<PathBuf>,
    /// Time in the log, s; by default its last entry.
    pub(crate) time_s: Option<f64>,
    /// Time in the log at which the zero point of the workpiece was set, s.
    pub(crate) zero_time_s: Option<f64>,
    /// Axis positions at which the zero point was set.
    pub(crate) zero_at: Option<AxisVector>,
    /// Statements about zero offsets.
    pub(crate) zeros: Vec<StatedZero>,
    /// The load on the table, instead of that of the files.
    pub(crate) load: Option<Load>,
}

/// Handling of radius compensation (G41, G42) in a corrected program.
///
/// ```
/// use ncfix::prelude::*;
///
/// let mut options = Options::default();
/// assert_eq!(options.compensation, Compensation::Center);
/// options.compensation = Compensation::Wear(0.1);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Compensation {
    /// The path of the tool center is written: radius and wear at the control have no effect.
    #[default]
    Center,
    /// The path of the tool center with G41 and G42 for wear: set the radius to 0 at the control and enter only the wear. The value is the
    /// largest wear to either side that the control must be able to follow, mm.
    Wear(f64),
}

/// Options of a correction. `Options::default()` gives the options of `ncfix fix` without arguments.
///
/// ```
/// use ncfix::prelude::*;
///
/// let mut options = Options::default();
/// assert_eq!((options.tolerance_mm, options.max_correction_mm), (0.001, 0.2));
/// options.tolerance_mm = 0.0005;
/// options.arcs = Arcs::Chords;
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Options {
    /// Largest deviation of an emitted piece from the exactly corrected path, mm.
    pub tolerance_mm: f64,
    /// Largest deviation of a hole that stays a drilling cycle, mm; a value below [`Self::tolerance_mm`] has no effect.
    pub hole_tolerance_mm: f64,
    /// Fixed step along the axis that moves farthest, instead of subdivision by tolerance, mm.
    pub step_mm: Option<f64>,
    /// Handling of arcs.
    pub arcs: Arcs,
    /// Handling of rapid moves.
    pub rapids: Rapids,
    /// The frame of the written coordinates. [`FiveAxis::Axes`] implies machine coordinates.
    pub frame: OutputFrame,
    /// Handling of five-axis transformations.
    pub five_axis: FiveAxis,
    /// Participation of rotary axes in the correction.
    pub rotary: Rotary,
    /// Smallest increment of linear axes in the output, mm; `None`: that of the machine file.
    pub increment_mm: Option<f64>,
    /// Larger corrections are refused, mm.
    pub max_correction_mm: f64,
    /// Handling of radius compensation.
    pub compensation: Compensation,
    /// The feed is lowered where the path deviation of the axes would exceed this, mm; needs `[servo]` in the machine file.
    pub feed_limit_mm: Option<f64>,
    /// True to refuse a program whose positions, tools or condition are outside the measured ranges of the machine.
    pub require_coverage: bool,
    /// True to leave holes to the drilling cycles of the control where the correction allows it; false to write their moves.
    pub keeps_cycles: bool,
    /// True to begin the output with words that compare zero offsets and tools of the control with those of the correction.
    pub guard: bool,
    /// A longer output is refused: written blocks per line with words of the source.
    pub max_growth: Option<f64>,
    /// Number of threads, 1 to 3; `None`: as many as are useful. The output does not depend on it.
    pub threads: Option<usize>,
}

impl Default for Options {
    fn default() -> Options {
        let path::CorrectionOptions {
            tolerance_mm,
            hole_tolerance_mm,
            arcs,
            rapids,
            frame,
            five_axis,
            rotary,
            max_correction_mm,
            ..
        } = path::CorrectionOptions::default();
        Options {
            tolerance_mm,
            hole_tolerance_mm,
            step_mm: None,
            arcs,
            rapids,
            frame,
            five_axis,
            rotary,
            increment_mm: None,
            max_correction_mm,
            compensation: Compensation::default(),
            feed_limit_mm: None,
            require_coverage: false,
            keeps_cycles: true,
            guard: false,
            max_growth: None,
            threads: None,
        }
    }
}

impl Options {
    /// The options of the corrector.
    pub(crate) fn of_path(&self) -> path::CorrectionOptions {
        path::CorrectionOptions {
            tolerance_mm: self.tolerance_mm,
            hole_tolerance_mm: self.hole_tolerance_mm,
            subdivision: self.step_mm.map_or(Subdivision::Adaptive, Subdivision::Step),
            arcs: self.arcs,
            rapids: self.rapids,
            frame: match (self.frame, self.five_axis) {
                (OutputFrame::Work, FiveAxis::Tcp) => OutputFrame::Work,
                _ => OutputFrame::Machine,
            },
            five_axis: self.five_axis,
            max_correction_mm: self.max_correction_mm,
            rotary: self.rotary,
            ..path::CorrectionOptions::default()
        }
    }
}
