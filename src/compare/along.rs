//! The errors of two programs along their path, for the page of a verification.

use std::collections::BTreeMap;

use super::walk::Outcome;
use crate::correction::spread;
use crate::diagnostics::Diagnostics;
use crate::disk::hash::input_of;
use ncfix_base::units::um_from_mm;
use ncfix_path::path::Follow;
use ncfix_report::inputs::InputFile;
use ncfix_report::verification::{Piece, Verification};

/// Maximum number of listed moves.
const LARGEST: usize = 10;

/// Errors along the path of two programs.
#[derive(Debug, Default)]
pub(crate) struct ErrorsAlong {
    path_mm: f64,
    /// Pieces counted so far: rapid ones only until the first feed move.
    pieces: Vec<Piece>,
    has_feed: bool,
}

impl ErrorsAlong {
    /// Adds a piece of both programs.
    pub(crate) fn see(&mut self, follow: &Follow<'_>) {
        self.path_mm += follow.length_mm;
        let Some(errors_mm) = follow.errors_mm else { return };
        if !follow.rapid && !self.has_feed {
            self.has_feed = true;
            self.pieces.clear();
        }
        if follow.rapid && self.has_feed {
            return;
        }
        let errors_um = errors_mm.map(|error| um_from_mm(error) as f32);
        let path_m = (self.path_mm / 1e3) as f32;
        self.pieces.push(Piece { file: follow.original.file.0, line: follow.original.line, path_m, errors_um });
    }

    /// The verification with the results of the whole comparison.
    pub(crate) fn verification(self, outcome: &Outcome, findings: &Diagnostics) -> Verification {
        let name = |k: usize| outcome.sources[k].first().map_or_else(String::new, |source| source.name().to_owned());
        let program = |k: usize, role: &'static str| outcome.sources[k].first().map(|source| input_of(source, role));
        let mut inputs: Vec<InputFile> =
            [program(0, "original program"), program(1, "corrected program")].into_iter().flatten().collect();
        let machine = &outcome.machine;
        inputs.push(InputFile { file: machine.name.clone(), role: "machine", hash: machine.model.clone() });
        Verification {
            files: [name(0), name(1)],
            machine: machine.name.clone(),
            before: Some(spread(&outcome.comparison.before)),
            after: Some(spread(&outcome.comparison.after)),
            samples: outcome.comparison.samples,
            largest: self.largest(outcome),
            pieces: self.pieces,
            at_feed: outcome.at_feed.clone(),
            inputs,
            diagnostics: findings.json(),
        }
    }

    /// The source lines with the largest remaining errors: file and line, errors before and after, µm.
    fn largest(&self, outcome: &Outcome) -> Vec<(String, [f64; 2])> {
        let mut lines: BTreeMap<(u16, u32), [f32; 2]> = BTreeMap::new();
        for piece in &self.pieces {
            let most = lines.entry((piece.file, piece.line)).or_default();
            *most = [0, 1].map(|k| most[k].max(piece.errors_um[k]));
        }
        let mut all: Vec<_> = lines.into_iter().collect();
        all.sort_by(|(_, a), (_, b)| b[1].total_cmp(&a[1]));
        let files = &outcome.sources[0];
        let place = |(file, line): (u16, u32)| {
            let name = files.iter().find(|source| source.id().0 == file).map_or("", |source| source.name());
            format!("{name}:{line}")
        };
        all.into_iter().take(LARGEST).map(|(at, errors)| (place(at), errors.map(f64::from))).collect()
    }
}
