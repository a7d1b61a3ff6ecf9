//! What `ncfix verify` measured along the path, for its page.

use super::inputs::Input;
use super::json::{AtFeed, Finding, Spread};

/// The errors of two programs along the path of the original.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verification {
    /// Names of both programs.
    pub files: [String; 2],
    /// Name of the machine.
    pub machine: String,
    /// Of the original program.
    pub before: Option<Spread>,
    /// Of the corrected program.
    pub after: Option<Spread>,
    /// Points at which both were evaluated.
    pub samples: u64,
    /// All pieces that count, in the order of the program.
    pub pieces: Vec<Piece>,
    /// The moves that the correction leaves most of: place, µm before and after, the largest first.
    pub largest: Vec<(String, [f64; 2])>,
    /// What the axes make of both programs at feed, where that was asked for.
    pub at_feed: Option<[AtFeed; 2]>,
    /// Files that it comes from.
    pub inputs: Vec<Input>,
    /// Findings.
    pub diagnostics: Vec<Finding>,
}

/// A piece of the corrected program.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Piece {
    /// Number of the file of the original.
    pub file: u16,
    /// Line of the original.
    pub line: u32,
    /// Length of the path of the original up to its end, m.
    pub path_m: f32,
    /// The largest errors of the original and of the corrected program on it, µm.
    pub errors_um: [f32; 2],
}
