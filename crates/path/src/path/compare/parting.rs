//! Where the moves of a corrected program do not follow those of its original any more.

use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{AXES, AxisVector};
use ncfix_machine::snc::Origin;

use super::step::ComparedMove;

/// Ends of axes that differ by less are no sign of another move, mm and rad: corrections do that.
const OTHER_END: f64 = 0.1;

/// A place at which the programs part.
#[derive(Clone, Debug, PartialEq)]
pub struct Parting {
    /// The move of the original.
    pub original: Origin,
    /// The line of the corrected program; `None` where that has ended.
    pub corrected: Option<Origin>,
    /// What that line does, or what the corrected program does.
    why: String,
}

impl Parting {
    /// Where there is no line of the corrected program.
    pub(super) fn alone(step: &ComparedMove, why: &str) -> Parting {
        Parting { original: step.origin, corrected: None, why: why.to_owned() }
    }

    /// At a piece; `words` are the ends of the move and of the piece as programs write them. `is_new` where the piece behind it ends the move.
    pub(super) fn at(
        step: &ComparedMove,
        piece: &ComparedMove,
        why: &str,
        words: [AxisVector; 2],
        is_new: bool,
    ) -> Parting {
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
            why.push_str("; it may be new, as the line below it ends this move");
        }
        Parting { original: step.origin, corrected: Some(piece.origin), why }
    }

    /// The piece ends the next move of the original.
    pub(super) fn lacks_a_move(&mut self) {
        self.why.push_str("; this move may be missing, as that line ends the next one");
    }

    /// A finding in the original, with what the line of the corrected program is called.
    #[must_use]
    pub fn diagnostic(&self, line: impl FnOnce(&Origin) -> String) -> Diagnostic {
        let place = Place { file: self.original.file, span: self.original.span };
        let message = match &self.corrected {
            Some(origin) => format!("{} {}", line(origin), self.why),
            None => self.why.clone(),
        };
        Diagnostic::at(
            Code::CANNOT_ALIGN,
            place,
            message,
            "compare a program with what was made from it, on the same machine",
        )
    }
}
