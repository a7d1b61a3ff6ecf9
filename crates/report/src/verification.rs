//! Result of `ncfix verify` along the path, for its page.

use super::inputs::InputFile;
use super::json::{AtFeed, DiagnosticReport, SpreadReport};

/// Errors of two programs along the path of the original.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verification {
    /// Names of both programs.
    pub files: [String; 2],
    /// Name of the machine.
    pub machine: String,
    /// Errors of the original program.
    pub before: Option<SpreadReport>,
    /// Errors of the corrected program.
    pub after: Option<SpreadReport>,
    /// Number of points at which both were evaluated.
    pub samples: u64,
    /// All relevant pieces, in the order of the program.
    pub pieces: Vec<Piece>,
    /// Moves with the largest residuals: place, µm before and after, the largest first.
    pub largest: Vec<(String, [f64; 2])>,
    /// Behavior of both programs at feed, if requested.
    pub at_feed: Option<[AtFeed; 2]>,
    /// Files from which the result was computed.
    pub inputs: Vec<InputFile>,
    /// Diagnostics.
    pub diagnostics: Vec<DiagnosticReport>,
}

/// Piece of the corrected program.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Piece {
    /// Number of the file of the original.
    pub file: u16,
    /// Line of the original.
    pub line: u32,
    /// Length of the original path up to its end, m.
    pub path_m: f32,
    /// Largest errors of the original and of the corrected program on it, µm.
    pub errors_um: [f32; 2],
}
