//! Makes the lines of a link from corrected pieces: thermal correction, rate limit, text.
//!
//! [`Lines`] takes the outputs of the first step one by one, with the current model, and returns the lines that they complete. A writer ends a line when the
//! next block begins, so a line becomes available one output later. Comments, messages and headers are not sent: they cost time on a slow link, and some
//! controls reject them. A link that sends a file sends the header. The profile adds the frame that a link needs.

mod block;
mod heights;
mod rate_limiter;
pub mod restart;
mod rules;
mod taken;
mod told;

use std::collections::VecDeque;
use std::sync::Arc;

use crate::feed::{DosingLimits, Line, LineRewriter};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{AXIS_COUNT, AxisVector};
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Dwell, Element, Kind};
use ncfix_model::Model;
use ncfix_path::emit::{Writer, is_stamped};
use ncfix_path::path::{CONTINUES, CONTINUES_ON_THE_SPOT, CorrectionOptions, Live, ON_THE_SPOT, Output};

pub use heights::Heights;
pub use rules::Grammar;
pub use taken::Ends;

use rate_limiter::RateLimiter;

/// Settings for making lines.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Settings {
    /// Limits on the rate of change of the applied correction due to temperature.
    pub limits: DosingLimits,
    /// True if the correction changes only on moves that do not cut.
    pub rapids_only: bool,
    /// True if letters are converted to capitals.
    pub is_upper_case: bool,
    /// True if the header of the program is sent: the link sends a file.
    pub keeps_headers: bool,
}

/// Data of a line that is being written.
#[derive(Clone, Copy, Debug, Default)]
struct About {
    source_line: u32,
    element: u64,
    busy_s: f64,
    shift: AxisVector,
    asked: AxisVector,
}

/// Makes the lines of a program.
pub struct Lines<'a> {
    live: Live<'a>,
    writer: Box<dyn Writer + 'a>,
    /// Converts the lines for a control that reads them in another way.
    rewriter: Option<Box<dyn LineRewriter>>,
    doser: RateLimiter,
    settings: Settings,
    /// Model in force, if temperatures are known.
    model: Option<Arc<Model>>,
    text: Vec<u8>,
    /// Codes that are added to the first line.
    stated: &'a str,
    ready: VecDeque<Line>,
    /// Data of the line that the writer holds back.
    about: About,
    element: u64,
    number: u64,
    /// Dwell times that the next piece would count again, s.
    waited_s: f64,
}

impl<'a> Lines<'a> {
    /// Begins at the first line of a program that `base` has corrected with `options`. `writer` writes the lines.
    #[must_use]
    pub fn new(
        machine: &'a Machine,
        base: &'a Model,
        options: &CorrectionOptions,
        writer: Box<dyn Writer + 'a>,
        settings: Settings,
    ) -> Lines<'a> {
        Lines {
            live: Live::new(machine, base, options),
            writer,
            rewriter: None,
            doser: RateLimiter::new(settings.limits),
            settings,
            model: None,
            text: Vec::new(),
            stated: "",
            ready: VecDeque::new(),
            about: About::default(),
            element: 0,
            number: 0,
            waited_s: 0.0,
        }
    }

    /// The lines with codes in the first one that the program assumes and does not state. A control keeps the codes of an earlier program.
    #[must_use]
    pub fn stating(self, stated: &'a str) -> Self {
        Lines { stated, ..self }
    }

    /// The lines as a control gets them that does not read them as they are.
    #[must_use]
    pub fn rewritten(self, rewriter: Option<Box<dyn LineRewriter>>) -> Self {
        Lines { rewriter, ..self }
    }

    /// Takes the next output of the first step, with the current model. If `is_frozen`, the applied correction approaches no target.
    ///
    /// # Errors
    /// `E0201` if the language has no words for it; `E0701` if the control has no lines with this effect.
    pub fn take(&mut self, output: Output, now: Option<&Arc<Model>>, is_frozen: bool) -> Result<(), Diagnostic> {
        self.element += 1;
        let is_rapid = matches!(&output, Output::Piece(piece) if piece.rapid && !piece.take_up);
        if self.model.is_none() || is_rapid || !self.settings.rapids_only {
            self.model = now.map(Arc::clone).or(self.model.take());
        }
        self.doser.is_frozen = is_frozen;
        let keeps_headers = self.settings.keeps_headers;
        let output = match output {
            Output::Element(Element { kind: Kind::Header(_), .. }) if keeps_headers => output,
            Output::Element(Element {
                kind: Kind::Comment(_) | Kind::Label(_) | Kind::Header(_) | Kind::Message(_),
                origin,
                starts_block,
                number,
            }) => Output::Element(Element { kind: Kind::Empty, origin, starts_block, number }),
            other => other,
        };
        let output = self.live.apply(output, self.model.as_deref(), &mut self.doser);
        let about = self.about(&output);
        if self.about.element == 0 {
            // Text before the first words comes with them.
            self.about = About { busy_s: 0.0, ..about };
        }
        self.text.clear();
        self.writer.write(&output, &mut self.text)?;
        if self.cut()? {
            self.about = about;
        } else {
            self.about = About { busy_s: self.about.busy_s + about.busy_s, ..about };
        }
        Ok(())
    }

    /// Ends the program: text that is still held back becomes lines.
    ///
    /// # Errors
    /// `E0701` if the control has no lines with this effect.
    pub fn finish(&mut self) -> Result<(), Diagnostic> {
        self.text.clear();
        self.writer.finish(&mut self.text);
        self.cut().map(drop)
    }

    /// Returns the next line that is ready.
    pub fn pop(&mut self) -> Option<Line> {
        self.ready.pop_front()
    }

    fn about(&mut self, output: &Output) -> About {
        let applied = self.live.applied();
        let (origin, busy_s) = match output {
            Output::Piece(piece) => (piece.origin, applied.time_s - std::mem::take(&mut self.waited_s)),
            Output::Cycle(block) => (block.origin, 0.0),
            Output::Element(element) => {
                let dwell_s = match element.kind {
                    Kind::Dwell(Dwell::Seconds(seconds)) => seconds.max(0.0),
                    _ => 0.0,
                };
                self.waited_s += dwell_s;
                (element.origin, dwell_s)
            }
        };
        About { source_line: origin.line, element: self.element, busy_s, shift: applied.shift, asked: applied.asked }
    }

    /// Splits the text into lines. Returns true if there was at least one.
    fn cut(&mut self) -> Result<bool, Diagnostic> {
        let mut is_first = true;
        let whole = std::mem::take(&mut self.text);
        for text in whole.split(|&byte| byte == b'\n') {
            let text = without_mark(text.trim_ascii());
            if text.is_empty() || text == b"%" || is_stamped(text) {
                continue;
            }
            let mut text = text.to_vec();
            if self.settings.is_upper_case {
                text.make_ascii_uppercase();
            }
            let busy_s = if std::mem::take(&mut is_first) { self.about.busy_s } else { 0.0 };
            match &mut self.rewriter {
                None => self.push(text, busy_s),
                Some(rewriter) => {
                    let lines =
                        rewriter.rewrite(&text).map_err(|why| not_for_link(self.about.source_line, &text, &why))?;
                    // The control is busy with the motion, which comes late in the order of the words.
                    let last = lines.iter().rposition(|line| line.starts_with(b"G")).unwrap_or(0);
                    for (at, line) in lines.into_iter().enumerate() {
                        self.push(line, if at == last { busy_s } else { 0.0 });
                    }
                }
            }
        }
        self.text = whole;
        Ok(!is_first)
    }

    fn push(&mut self, mut text: Vec<u8>, busy_s: f64) {
        self.number += 1;
        if self.number == 1 && !self.stated.is_empty() {
            text.push(b' ');
            text.extend(self.stated.bytes());
        }
        self.ready.push_back(Line {
            number: self.number,
            text,
            source_line: self.about.source_line,
            element: self.about.element,
            offset: slots(&self.about.shift),
            target: slots(&self.about.asked),
            busy_s,
            temperatures_c: None,
        });
    }
}

/// A line that the control does not execute as the program means it.
fn not_for_link(source_line: u32, text: &[u8], why: &str) -> Diagnostic {
    let text = String::from_utf8_lossy(text);
    let message = format!("line {source_line} of the original becomes '{text}'; {why}");
    let help = "change the program there, or choose the link of your control with --link";
    Diagnostic::nowhere(Code::NOT_FOR_LINK, message, help)
}

/// Removes the mark of an added piece from a line.
fn without_mark(text: &[u8]) -> &[u8] {
    let Some(at) = text.iter().rposition(|byte| b";(".contains(byte)) else { return text };
    let (words, comment) = text.split_at(at);
    let comment: Vec<u8> = comment.iter().copied().filter(|byte| !b";() ".contains(byte)).collect();
    let is_mark = [CONTINUES, CONTINUES_ON_THE_SPOT, ON_THE_SPOT].iter().any(|mark| mark.as_bytes() == comment);
    if is_mark { words.trim_ascii_end() } else { text }
}

fn slots(vector: &AxisVector) -> [f64; AXIS_COUNT] {
    ncfix_base::geometry::AXES.map(|axis| vector[axis])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_of_added_pieces_stay_at_home_and_words_do_not() {
        for (line, left) in [
            ("X1 Y2 ;+", "X1 Y2"),
            ("G1 X1 (+~)", "G1 X1"),
            ("X1 ; +", "X1"),
            ("; ~", ""),
            ("X=IC(5)", "X=IC(5)"),
            ("G1 X1", "G1 X1"),
            ("M3 (a+)", "M3 (a+)"),
        ] {
            assert_eq!(without_mark(line.as_bytes()), left.as_bytes(), "{line}");
        }
    }
}
