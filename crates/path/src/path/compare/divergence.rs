//! A divergence between the moves of a corrected program and those of its original.

use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{AXES, AxisVector};
use ncfix_machine::snc::Origin;

use super::step::ComparedMove;

/// Axis difference at an end below which it does not indicate another move, mm and rad: corrections may cause it.
const OTHER_END: f64 = 0.1;

/// A place at which the programs diverge.
#[derive(Clone, Debug, PartialEq)]
pub struct Divergence {
    /// The move of the original.
    pub original: Origin,
    /// The line of the corrected program; `None` if that program has ended.
    pub corrected: Option<Origin>,
    /// Description of that line, or of the corrected program.
    why: String,
    /// True if the check of `--guard` may have ended the corrected program.
    is_guarded: bool,
}

impl Divergence {
    /// A divergence without a line of the corrected program.
    pub(super) fn alone(step: &ComparedMove<'_>, why: &str) -> Divergence {
        Divergence { original: step.origin, corrected: None, why: why.to_owned(), is_guarded: false }
    }

    /// A corrected program that ends before its first move.
    pub(super) fn guarded(step: &ComparedMove<'_>) -> Divergence {
        let why = "the corrected program ends before its first move; a guard (--guard) ends it if a zero offset or tool differs from the correction";
        Divergence { is_guarded: true, ..Divergence::alone(step, why) }
    }

    /// A divergence at a piece; `words` are the ends of the move and of the piece as written. `is_new` if the next piece ends the move.
    pub(super) fn at(
        step: &ComparedMove<'_>,
        piece: &ComparedMove<'_>,
        why: &str,
        words: [AxisVector; 2],
        is_new: bool,
    ) -> Divergence {
        let others = AXES.into_iter().filter(|&axis| (words[0][axis] - words[1][axis]).abs() > OTHER_END);
        let ends = others.map(|axis| {
            let [wanted, found] =
                words.map(|words| if axis.is_rotary() { words[axis].to_degrees() } else { words[axis] });
            format!("{axis} at {found:.3} instead of {wanted:.3}")
        });
        let ends: Vec<String> = ends.collect();
        let mut why = why.to_owned();
        if !ends.is_empty() {
            why = format!("{why}: it ends with {}", ends.join(", "));
        }
        if is_new {
            why.push_str("; it may be new, because the next line ends this move");
        }
        Divergence { original: step.origin, corrected: Some(piece.origin), why, is_guarded: false }
    }

    /// Adds that the piece ends the next move of the original.
    pub(super) fn lacks_a_move(&mut self) {
        self.why.push_str("; this move may be missing, because that line ends the next one");
    }

    /// A diagnostic in the original; `line` names the line of the corrected program.
    #[must_use]
    pub fn diagnostic(&self, line: impl FnOnce(&Origin) -> String) -> Diagnostic {
        let place = Place { file: self.original.file, span: self.original.span };
        let message = match &self.corrected {
            Some(origin) => format!("{} {}", line(origin), self.why),
            None => self.why.clone(),
        };
        let help = if self.is_guarded {
            "give the zero offsets and tools of the correction; if they have changed since, correct the original again"
        } else {
            "compare a program with its own corrected program, on the same machine"
        };
        Diagnostic::at(Code::CANNOT_ALIGN, place, message, help)
    }
}
