//! Words without motion: modal codes, offsets, tools, auxiliary functions, dwells, comments.

use super::super::comment::in_parentheses;
use super::super::is_compensation;
use super::super::line::FEED_WORDS;
use super::super::number::push_value;
use super::cycle::END;
use super::{Language, Words};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::units::push_integer;
use ncfix_machine::snc::{Dwell, Element, FrameWords, HereStatement, Kind, Origin, Word, WordValue};

/// Beginning and end of a tape.
const TAPE: &[u8] = b"%";
/// M functions that act after the motion of their line.
const STOPPING: [f64; 5] = [0.0, 1.0, 2.0, 30.0, 60.0];
/// Letters whose values are whole numbers on a Fanuc control.
const WHOLE: &[u8] = b"MSTHD";

impl Words {
    pub(super) fn element(&mut self, element: &Element, out: &mut Vec<u8>) -> Result<(), Diagnostic> {
        if let Kind::Header(bytes) = &element.kind {
            if bytes.trim_ascii() != TAPE {
                // `%100` of an ISO tape; on Grundig it names a memory and has no end.
                self.is_tape |= bytes.starts_with(TAPE) && self.flavour.language != Language::Grundig;
                self.line.header(bytes, out);
            } else if !std::mem::replace(&mut self.is_tape, true) {
                self.line.header(TAPE, out);
            }
            return Ok(());
        }
        self.stamp(out);
        if matches!(element.kind, Kind::Setup(_)) {
            self.cycle = None;
            self.place = None;
        }
        match &element.kind {
            Kind::Header(_) | Kind::Label(_) | Kind::Move(_) | Kind::Setup(_) => {}
            Kind::Lost(_) | Kind::Cycle(_) | Kind::Empty => {}
            Kind::Keep(END) => self.end_cycle(out),
            Kind::Comment(bytes) => self.comment(bytes),
            // Already active.
            Kind::Feed(feed) if *feed == self.feed && element.number.is_none() => {}
            Kind::Message(text) => self.message(text, out),
            Kind::Keep(word) if self.flavour.replaced.contains(word) || *word == "G53" => {}
            kind => {
                self.assume(out);
                return self.words(kind, &element.origin, out);
            }
        }
        Ok(())
    }

    fn comment(&mut self, bytes: &[u8]) {
        if self.flavour.is_plain {
            self.line.note(&[&in_parentheses(bytes)]);
        } else {
            self.line.note(&[bytes]);
        }
    }

    /// Writes a message to the operator if the language has messages, otherwise a comment.
    fn message(&mut self, text: &[u8], out: &mut Vec<u8>) {
        if self.flavour.language == Language::Rs274 {
            // The interpreter reads only the last comment of a line.
            if self.line.has_words() || self.line.has_comment() {
                self.line.end(out);
            }
            let text = in_parentheses(text);
            self.line.note(&[b"(MSG, ", text.get(1..).unwrap_or_default()]);
            self.line.open();
            self.line.end(out);
        } else if !text.is_empty() {
            self.line.open();
            self.line.note(&[&in_parentheses(text)]);
        }
    }

    fn words(&mut self, kind: &Kind, origin: &Origin, out: &mut Vec<u8>) -> Result<(), Diagnostic> {
        match kind {
            Kind::After(words) => {
                let is_stop = |word: &Word| matches!(word.value, WordValue::Number(code) if STOPPING.contains(&code));
                // In RS274/NGC all others act before the motion of their line.
                if self.flavour.language == Language::Rs274 && !words.iter().all(is_stop) {
                    self.leave_motion(out);
                }
                self.line.release();
                return words.iter().try_for_each(|word| self.auxiliary(word, origin));
            }
            Kind::Dwell(dwell) => return self.dwell(*dwell, origin, out),
            _ => self.leave_motion(out),
        }
        match kind {
            Kind::Keep(word) => {
                if FEED_WORDS.contains(word) {
                    self.line.remove_words(&FEED_WORDS);
                    self.is_inverse_time = *word == "G93";
                    // A feed of one mode is not valid in the other.
                    self.feed = f64::NAN;
                }
                self.stops.keep(&mut self.line, word);
            }
            Kind::Frame(FrameWords::Settable(name)) => self.line.word(name.as_bytes()),
            Kind::Frame(FrameWords::Statement(_)) => {
                return Err(self.no_words(origin, "a frame", "program it as coordinates"));
            }
            Kind::Tool(value) => {
                let word = Word { letter: b'T', extension: None, value: value.clone() };
                return self.auxiliary(&word, origin);
            }
            Kind::Before(words) => {
                // The words are assembled on the line and taken off it until the motion is written.
                let start = self.line.text.len();
                words.iter().try_for_each(|word| self.auxiliary(word, origin))?;
                self.line.hold_from(start);
            }
            Kind::Feed(feed) => self.feed_word(*feed),
            Kind::Here(here) => self.here(here),
            Kind::Verbatim(text) => {
                let first = text.split(|&byte| byte == b' ').next().unwrap_or_default();
                self.stops.note(std::str::from_utf8(first).unwrap_or_default());
                // A separate block, as the postprocessors of these controls write it; G91 holds for the words of one block alone.
                let is_alone =
                    self.flavour.language == Language::Grundig && is_compensation(text) || text.starts_with(b"G91 ");
                if is_alone && self.line.has_words() {
                    self.line.end(out);
                }
                self.line.word(text);
                if is_alone {
                    self.line.end(out);
                }
                self.has_p = self.flavour.language == Language::Rs274 && text.windows(2).any(|pair| pair == b" P");
                // The block may have selected another motion or feed.
                self.motion = "";
                if text.contains(&b'F') {
                    self.feed = f64::NAN;
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Writes data that the control computes from its position, far finer than any increment.
    fn here(&mut self, here: &HereStatement) {
        self.line.word(here.words.as_bytes());
        for axis in here.named.iter() {
            let value = here.values[axis];
            let shown = if axis.is_rotary() { value.to_degrees() } else { value / here.unit_mm };
            self.line.word(&[axis.letter()]);
            // Without a negative zero.
            push_value(&mut self.line.text, (shown * 1e6).round() / 1e6 + 0.0);
        }
        self.line.text.extend_from_slice(here.after.as_bytes());
        self.has_p = true;
        // As after every statement: the next motion states its code.
        self.motion = "";
    }

    fn auxiliary(&mut self, word: &Word, origin: &Origin) -> Result<(), Diagnostic> {
        let &Word { letter, extension, ref value } = word;
        let WordValue::Number(number) = *value else {
            return Err(self.no_words(origin, "a name instead of a number", "use numbers"));
        };
        self.line.word(&[letter]);
        if let Some(extension) = extension {
            if self.flavour.language != Language::Grundig {
                return Err(self.no_words(origin, "an address with a number", "use plain addresses"));
            }
            push_integer(&mut self.line.text, u64::from(extension));
            self.line.text.push(b'=');
        }
        let is_whole = self.flavour.language == Language::Fanuc && WHOLE.contains(&letter);
        push_value(&mut self.line.text, if is_whole { number.round() } else { number });
        Ok(())
    }

    /// Writes a dwell in its own line: it acts in sequence with the motions of its block, and its words must not mix with theirs.
    fn dwell(&mut self, dwell: Dwell, origin: &Origin, out: &mut Vec<u8>) -> Result<(), Diagnostic> {
        if self.line.has_words() {
            self.line.end(out);
        }
        self.line.word(b"G4");
        match (dwell, self.flavour.language) {
            (Dwell::Seconds(seconds), Language::Rs274) => {
                self.line.word(b"P");
                push_value(&mut self.line.text, seconds);
            }
            // Only controls that count turns in G95 have turns here.
            (Dwell::Seconds(time) | Dwell::Turns(time), Language::Fanuc) => {
                self.line.word(b"P");
                // Thousandths: a whole number is read identically with and without decimal point mode.
                let least = if time > 0.0 { 1.0 } else { 0.0 };
                push_value(&mut self.line.text, (time * 1000.0).round().max(least));
            }
            (Dwell::Seconds(seconds), Language::Grundig) => {
                self.line.word(b"X");
                push_value(&mut self.line.text, seconds);
            }
            (Dwell::Turns(turns), Language::Grundig) => {
                self.line.word(b"D");
                push_value(&mut self.line.text, turns);
            }
            (Dwell::Turns(_), Language::Rs274) => {
                return Err(self.no_words(origin, "a dwell in turns of the spindle", "program the dwell in seconds"));
            }
        }
        self.line.end(out);
        Ok(())
    }
}
