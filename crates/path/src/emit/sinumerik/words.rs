//! Words without motion: modal codes, frames, tools, auxiliary functions, comments.

use super::cycle::MODAL;
use super::{ASSUMED, Sinumerik};
use ncfix_base::units::push_integer;
use ncfix_machine::snc::{Dwell, Element, FEED_MODES, FrameKind, FrameStatement, FrameWords, Kind, Word, WordValue};

use super::super::line::FEED_WORDS;
use super::super::number::push_value;

/// Words that suppress frames in their block.
const SUPPRESSING: [&str; 3] = ["G53", "G153", "SUPA"];
/// Parts of a mm or degree to which shifts, angles and factors are rounded: far finer than any increment, without rounding noise.
const VALUE_PARTS: f64 = 1e9;

impl Sinumerik {
    pub(super) fn element(&mut self, element: &Element, out: &mut Vec<u8>) {
        if let Kind::Header(bytes) = &element.kind {
            self.line.header(bytes, out);
            return;
        }
        self.stamp(out);
        match &element.kind {
            Kind::Header(_) | Kind::Move(_) | Kind::Setup(_) | Kind::Lost(_) | Kind::Cycle(_) | Kind::Empty => {}
            Kind::Keep(MODAL) if std::mem::take(&mut self.modal_call).is_empty() => {}
            Kind::Comment(bytes) => self.line.note(&[bytes]),
            // Already active.
            Kind::Feed(feed) if *feed == self.feed && element.number.is_none() => {}
            Kind::Label(label) => self.label(label),
            kind => self.words(kind),
        }
    }

    fn words(&mut self, kind: &Kind) {
        match kind {
            Kind::Keep(word) if SUPPRESSING.contains(word) => {
                self.suppressing = Some(word);
                if !self.in_machine_frame {
                    self.word(word.as_bytes());
                }
            }
            Kind::Keep(word) if *word == ASSUMED => {
                self.has_assumed = true;
                self.word(word.as_bytes());
            }
            Kind::Keep(word) => {
                if FEED_MODES.contains(word) {
                    self.line.remove_words(&FEED_WORDS);
                    // A feed of one mode is not valid in the other.
                    self.feed = f64::NAN;
                }
                self.stops.keep(&mut self.line, word);
            }
            Kind::Frame(words) => self.frame(words),
            Kind::Tool(value) => self.auxiliary(b'T', None, value),
            Kind::Before(words) => {
                // The words are assembled on the line and taken off it until the motion is written.
                let start = self.line.text.len();
                for Word { letter, extension, value } in words {
                    self.auxiliary(*letter, *extension, value);
                }
                self.line.hold_from(start);
            }
            Kind::After(words) => {
                self.line.release();
                for Word { letter, extension, value } in words {
                    self.auxiliary(*letter, *extension, value);
                }
            }
            Kind::Feed(feed) => self.feed_word(*feed),
            Kind::Dwell(dwell) => {
                let (letter, value) = match dwell {
                    Dwell::Seconds(seconds) => (&b"F"[..], *seconds),
                    Dwell::Turns(turns) => (&b"S"[..], *turns),
                };
                self.word(b"G4");
                self.word(letter);
                push_value(&mut self.line.text, value);
            }
            Kind::Message(text) if text.is_empty() => self.word(b"MSG()"),
            Kind::Message(text) => {
                self.word(b"MSG(\"");
                self.line.text.extend_from_slice(text);
                self.line.text.extend_from_slice(b"\")");
            }
            Kind::Verbatim(text) => self.word(text),
            // Only RS274/NGC has such statements.
            Kind::Here(_)
            | Kind::Header(_)
            | Kind::Comment(_)
            | Kind::Label(_)
            | Kind::Move(_)
            | Kind::Setup(_)
            | Kind::Lost(_)
            | Kind::Cycle(_)
            | Kind::Empty => {}
        }
    }

    /// Writes a label at the first execution of its block, so that a block search for the label finds the same place.
    fn label(&mut self, label: &[u8]) {
        if self.labels.insert(label.to_vec()) {
            self.line.label(label);
        }
    }

    fn auxiliary(&mut self, letter: u8, extension: Option<u32>, value: &WordValue) {
        self.word(&[letter]);
        if let Some(extension) = extension {
            push_integer(&mut self.line.text, u64::from(extension));
        }
        match value {
            WordValue::Number(number) => {
                if extension.is_some() {
                    self.line.text.push(b'=');
                }
                push_value(&mut self.line.text, *number);
            }
            WordValue::Name(name) => {
                self.line.text.extend_from_slice(b"=\"");
                self.line.text.extend_from_slice(name);
                self.line.text.push(b'"');
            }
        }
    }

    fn frame(&mut self, words: &FrameWords) {
        match words {
            FrameWords::Settable(name) => self.word(name.as_bytes()),
            FrameWords::Statement(statement) => self.frame_statement(statement),
        }
    }

    fn frame_statement(&mut self, statement: &FrameStatement) {
        if statement.additive {
            self.word(b"A");
            // The remaining word follows without a blank.
            self.line.text.extend_from_slice(word_of(statement.kind));
        } else {
            self.word(word_of(statement.kind));
        }
        if let Some(angle_rad) = statement.in_plane_rad {
            self.word(b"RPL=");
            push_value(&mut self.line.text, without_noise(angle_rad.to_degrees()));
        }
        let is_angle = matches!(statement.kind, FrameKind::Rotate | FrameKind::SolidAngles);
        let is_shift = matches!(statement.kind, FrameKind::Translate | FrameKind::Coarse | FrameKind::Fine);
        for axis in statement.named.iter() {
            self.word(b"");
            if self.axis_name(axis) {
                self.line.text.push(b'=');
            }
            let value = statement.values[axis];
            let in_degrees = is_angle || is_shift && axis.is_rotary();
            push_value(&mut self.line.text, without_noise(if in_degrees { value.to_degrees() } else { value }));
        }
    }
}

/// The word of a frame statement.
fn word_of(kind: FrameKind) -> &'static [u8] {
    match kind {
        FrameKind::Translate => b"TRANS",
        FrameKind::Rotate => b"ROT",
        FrameKind::SolidAngles => b"ROTS",
        FrameKind::Scale => b"SCALE",
        FrameKind::Mirror => b"MIRROR",
        FrameKind::Coarse => b"G58",
        FrameKind::Fine => b"G59",
    }
}

/// Rounds a value to remove the rounding noise.
fn without_noise(value: f64) -> f64 {
    (value * VALUE_PARTS).round() / VALUE_PARTS
}
