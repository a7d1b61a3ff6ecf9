//! Gathers the words of one block before its execution: gather, check, execute.

use super::address::Named;
use super::contour_words::PASSED_ON;
use super::curve::End;
use super::five_axis::TOOL_FRAME;
use super::gathered::NamedValue;
use super::gathered::{Call, Gathered};
use super::gatherer;
use super::gatherer::Gatherer;
use super::modal::MotionKind;
use super::names::Meaning;
use super::operand::undefined;
use super::pole::PoleBase;
use super::refusals;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::syntax::look_alike;
use crate::syntax::sinumerik::{Address, ArgumentRange, Block, DimensionFunction, NameId, Value, Word};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::Axis;
use ncfix_base::source::Span;
use ncfix_dialect::{CodeEffect, CodeEntry};
use ncfix_machine::snc::{FrameKind, Word as AuxWord, WordValue};

/// Largest accepted feed and speed.
const MOST: f64 = 1e9;

impl Gatherer<'_> {
    /// Reads all words of a block. Assignments are already executed.
    pub(super) fn gather(&self, block: &Block, out: &mut Gathered) -> Result<(), Fault> {
        let words = self.scope.program.words_of(block);
        for word in words {
            let found = self.word(word, block, out);
            if out.is_reference || found.is_err() && self.is_reference(words) {
                *out = self.reference(block)?;
                return Ok(());
            }
            found?;
            if out.is_complete {
                break;
            }
        }
        if let Some(span) = out.limits {
            self.limits(block, span, out)?;
        }
        if let Some((repeats, span)) = out.call_repeats {
            match &mut out.call {
                Some(call) => call.repeats = repeats,
                None => {
                    return Err(bad_value(span, "P without a subprogram call", "put P after the name of the program"));
                }
            }
        }
        if let Some(call) = &out.call
            && words.len() > 1 + usize::from(out.call_repeats.is_some())
        {
            return Err(fault(
                Code::MUST_STAND_ALONE,
                call.span,
                format!("the call of {} must be alone in its block", call.name),
                look_alike::whole(self.scope.program.source.slice(call.span))
                    .unwrap_or("give the call its own block, or correct the word"),
            ));
        }
        Ok(())
    }

    pub(super) fn word(&self, word: &Word, block: &Block, out: &mut Gathered) -> Result<(), Fault> {
        match word.address {
            Address::Name(_) | Address::Indexed(_) | Address::Letter(b'L' | b'M')
                if self.passes(word, block, out)? =>
            {
                Ok(())
            }
            Address::Letter(letter) => self.letter(letter, word, out),
            Address::Extended(b'R', _) => Ok(()),
            Address::Indexed(left) => self.indexed(left, word, out),
            Address::Extended(letter @ (b'S' | b'M' | b'H'), extension) => {
                let value = self.number(word)?;
                let word = AuxWord { letter, extension: Some(extension), value: WordValue::Number(value) };
                out.before.push(word);
                Ok(())
            }
            Address::Extended(letter, extension) => {
                match (self.numbered_axis(letter, extension), super::address::extended(letter, extension)) {
                    (Some(axis), _) => self.axis(axis.letter(), word, out),
                    _ if self.passes_axis(&format!("{}{extension}", char::from(letter)), word, out)? => Ok(()),
                    (None, Some(address)) => self.address(address, word, out),
                    (None, None) => Err(self.unnamed_axis(letter, extension, word)),
                }
            }
            Address::Name(name) => self.name(name, word, out),
        }
    }

    fn letter(&self, letter: u8, word: &Word, out: &mut Gathered) -> Result<(), Fault> {
        match letter {
            b'G' => self.g_code(word, out),
            b'X' | b'Y' | b'Z' | b'A' | b'B' | b'C' | b'U' | b'V' | b'W' => self.axis(letter, word, out),
            b'I' | b'J' | b'K' => {
                let slot = usize::from(letter - b'I');
                let absolute = match word.value {
                    Value::Dimension(DimensionFunction::Absolute, _) => true,
                    Value::Dimension(DimensionFunction::Incremental, _) => false,
                    Value::Dimension(..) => return Err(self.unsupported(word)),
                    _ => false,
                };
                if out.center[slot].replace((self.number(word)?, absolute)).is_some() {
                    return Err(gatherer::twice(word.span));
                }
                out.center_span = word.span;
                Ok(())
            }
            b'F' => {
                let value = self.number(word)?;
                if value.is_nan() || value < 0.0 {
                    return Err(bad_value(word.span, "a feed must not be negative", "program F with a positive value"));
                }
                gatherer::once(&mut out.feed, (plausible(value, word.span)?, word.span), word.span)
            }
            b'S' => gatherer::once(&mut out.speed, (plausible(self.number(word)?, word.span)?, word.span), word.span),
            b'T' => {
                let value = match self.text_value(word)? {
                    Some(name) => WordValue::Name(name),
                    None => WordValue::Number(f64::from(self.whole(word, u32::MAX)?)),
                };
                gatherer::once(&mut out.tool, (value, word.span), word.span)
            }
            b'D' => gatherer::once(&mut out.edge, (self.whole(word, 99_999)?, word.span), word.span),
            b'M' => {
                let number = self.whole(word, 99_999_999)?;
                let aux = AuxWord { letter, extension: None, value: WordValue::Number(f64::from(number)) };
                match number {
                    2 | 17 | 30 => out.program_end = Some(number),
                    0 | 1 | 5 | 9 => out.after.push(aux),
                    6 => {
                        out.tool_change = true;
                        out.before.push(aux);
                    }
                    _ => out.before.push(aux),
                }
                Ok(())
            }
            b'H' => {
                let value = WordValue::Number(self.number(word)?);
                out.before.push(AuxWord { letter, extension: None, value });
                Ok(())
            }
            b'L' => {
                let digits = self.scope.program.source.slice(word.span);
                let name: String = digits
                    .iter()
                    .filter(|b| !b.is_ascii_whitespace())
                    .map(|&b| char::from(b.to_ascii_uppercase()))
                    .collect();
                if !name[1..].bytes().all(|b| b.is_ascii_digit()) {
                    return Err(bad_value(word.span, "L takes the number of a subprogram", "write for example L10"));
                }
                self.call(name, None, word.span, out)
            }
            b'P' => {
                let repeats = self.whole(word, 9999)?;
                gatherer::once(&mut out.call_repeats, (repeats, word.span), word.span)
            }
            _ => Err(self.unsupported(word)),
        }
    }

    fn call(
        &self,
        name: String,
        arguments: Option<ArgumentRange>,
        span: Span,
        out: &mut Gathered,
    ) -> Result<(), Fault> {
        if let Some(first) = &out.call {
            return Err(fault(
                Code::UNEXPECTED,
                span,
                format!("{name} and {} in one block", first.name),
                "give each call its own block",
            ));
        }
        out.call = Some(Call { name, arguments, repeats: 1, span });
        Ok(())
    }

    fn g_code(&self, word: &Word, out: &mut Gathered) -> Result<(), Fault> {
        let number = self.whole(word, 999)?;
        match self.codes.g(number as usize) {
            Some(entry) => self.code(entry, word.span, out),
            None if (505..=599).contains(&number) => {
                self.group(8, word.span, out)?;
                out.offset = Some((format!("G{number}"), word.span));
                Ok(())
            }
            None => Err(fault(
                Code::NOT_SUPPORTED,
                word.span,
                format!("G{number} is not supported"),
                "check the code; if it is valid on the control, ncfix does not execute it yet",
            )),
        }
    }

    pub(super) fn group(&self, group: u8, span: Span, out: &mut Gathered) -> Result<(), Fault> {
        let bit = 1_u64 << (group & 63);
        if group > 0 && out.groups & bit != 0 {
            let message = format!("this is the second code of G group {group} in the block");
            return Err(fault(Code::DOUBLE_WORD, span, message, "keep one of them, or split the block"));
        }
        out.groups |= bit;
        Ok(())
    }

    pub(super) fn code(&self, entry: &'static CodeEntry, span: Span, out: &mut Gathered) -> Result<(), Fault> {
        self.group(entry.group, span, out)?;
        match entry.effect {
            CodeEffect::Motion => out.motion = MotionKind::of(entry.name).map(|kind| (kind, span)),
            CodeEffect::Dwell => out.dwell = Some(span),
            CodeEffect::Plane => {
                out.plane = entry.name[1..].parse().ok();
                out.keep.push(entry.name);
            }
            // The output is metric and absolute; the corresponding word replaces the original one.
            CodeEffect::Unit => {
                let with_feed = entry.name.len() == 4;
                out.inch = Some((entry.name.starts_with("G70"), with_feed));
                out.keep.push(if with_feed { "G710" } else { "G71" });
            }
            CodeEffect::Dimension => {
                out.incremental = Some(entry.name == "G91");
                out.keep.push("G90");
            }
            CodeEffect::Offset => out.offset = Some((entry.name.to_owned(), span)),
            CodeEffect::Suppress => {
                out.suppress = Some(entry.name);
                out.keep.push(entry.name);
            }
            CodeEffect::Frame => out.frame = FrameKind::of(entry.name).map(|(kind, additive)| (kind, additive, span)),
            CodeEffect::Pole => out.pole = PoleBase::of(entry.name).map(|base| (base, span)),
            CodeEffect::Keep => out.keep.push(entry.name),
            CodeEffect::FeedMode => {
                out.feed_mode = Some(entry.name);
                out.keep.push(entry.name);
            }
            CodeEffect::Transform if entry.group == TOOL_FRAME => {
                out.transform.tool_frame = Some((entry.name, span));
            }
            CodeEffect::Transform => out.transform.switch = Some((entry.name, span)),
            CodeEffect::Orientation => {
                // The output states the resulting directions.
                out.keep.push(if entry.name == "ORIPATH" { "ORIVECT" } else { entry.name });
                out.transform.codes.push(entry.name);
            }
            CodeEffect::Contour => gather_word(entry.name, out),
            CodeEffect::Spline => out.curve.ends.extend(End::of(entry.name)),
            CodeEffect::Display => {}
            CodeEffect::Limits => out.limits = Some(span),
            CodeEffect::Tap => out.taps = true,
            CodeEffect::Reference => out.is_reference = true,
            // The output is in radii; the transverse axis is not moved while diameters are active.
            CodeEffect::Diameter => {
                out.diameter = Some((entry.name != "DIAMOF", span));
                out.keep.push("DIAMOF");
            }
            CodeEffect::Execute | CodeEffect::Refuse => {
                let shown = format!("{} ({})", entry.name, entry.meaning);
                return Err(refusals::refusal(entry.name, &shown, span));
            }
        }
        Ok(())
    }

    pub(super) fn axis(&self, letter: u8, word: &Word, out: &mut Gathered) -> Result<(), Fault> {
        let Some(axis) = Axis::from_letter(letter) else { return Err(self.unsupported(word)) };
        if !self.machine_axes.contains(axis) {
            if self.passes_axis(&axis.to_string(), word, out)? {
                return Ok(());
            }
            let message = format!("the machine has no axis {axis}");
            let help = "check the topology in the machine file, or the program; if only the control moves it, name it in control.passed_on_axes";
            return Err(fault(Code::NO_AXIS, word.span, message, help));
        }
        if out.named.contains(axis) {
            return Err(gatherer::twice(word.span));
        }
        if let Value::Dimension(function, _) = word.value
            && !super::rotary::set_way(axis, function, word.span, out)?
        {
            return Err(self.unsupported(word));
        }
        out.axes[axis] = self.number(word)?;
        out.axis_spans[axis.slot()] = word.span;
        out.named.insert(axis);
        Ok(())
    }

    fn name(&self, name: NameId, word: &Word, out: &mut Gathered) -> Result<(), Fault> {
        let text = self.scope.program.names.text(name);
        match (self.meanings[name.index()], word.value) {
            (Meaning::Code(entry), Value::Arguments(_)) if entry.effect == CodeEffect::Display => Ok(()),
            (Meaning::Code(entry), Value::None) => self.code(entry, word.span, out),
            (Meaning::Code(entry), Value::Arguments(range))
                if entry.effect == CodeEffect::Keep && range == ArgumentRange::default() =>
            {
                self.code(entry, word.span, out)
            }
            (Meaning::Code(entry), Value::Arguments(range)) if entry.effect == CodeEffect::Transform => {
                self.transformation(entry, range, word, out)
            }
            (Meaning::Code(entry), _) if entry.effect == CodeEffect::Refuse => self.code(entry, word.span, out),
            (Meaning::Address(address), Value::Expr(_) | Value::Dimension(..)) => self.address(address, word, out),
            (Meaning::Message, Value::Arguments(range)) => {
                let text = match self.scope.program.arguments_of(range) {
                    [] | [None] => Vec::new(),
                    [Some(id), ..] => self.scope.value(*id)?.text(),
                    [None, ..] => return Err(self.unsupported(word)),
                };
                gatherer::once(&mut out.message, text, word.span)
            }
            (Meaning::Alarm, Value::Arguments(range)) => Err(self.alarm(range, word.span)?),
            (Meaning::Return, Value::None | Value::Arguments(_)) => {
                out.is_return = true;
                if let Value::Arguments(range) = word.value {
                    out.return_arguments = Some(range);
                }
                Ok(())
            }
            // Written before the words are gathered.
            (Meaning::System, Value::Expr(_) | Value::Arguments(_)) => Ok(()),
            (Meaning::Unsupported | Meaning::Return | Meaning::Alarm | Meaning::System, _) => {
                Err(self.unsupported(word))
            }
            // Assignments are executed before the words are gathered.
            (Meaning::Free, Value::Expr(_) | Value::Arguments(_)) if self.scope.variables.has(name, text) => Ok(()),
            (Meaning::Free, Value::Expr(_) | Value::Dimension(..)) => {
                if let Some(axis) = self.scope.machine.axis_named(text) {
                    return self.axis(axis.letter(), word, out);
                }
                if self.passes_axis(text, word, out)? {
                    return Ok(());
                }
                Err(undefined(format!("{text} is neither a variable nor a known address"), text, word.span))
            }
            (Meaning::Free, Value::None) => self.call(text.to_owned(), None, word.span, out),
            (Meaning::Free, Value::Arguments(range)) => self.call(text.to_owned(), Some(range), word.span, out),
            _ => Err(fault(
                Code::UNEXPECTED,
                word.span,
                format!("{text} is used in a way that is not allowed"),
                "check its spelling and value",
            )),
        }
    }

    pub(super) fn unsupported(&self, word: &Word) -> Fault {
        let text = String::from_utf8_lossy(self.scope.program.source.slice(word.span)).into_owned();
        let shown: String = text.chars().take(40).collect();
        let (start, source) = (word.span.start, &self.scope.program.source);
        let before = source.slice(Span { start: start.saturating_sub(1), end: start });
        let is_exponent = before.last().is_some_and(u8::is_ascii_digit)
            && text.strip_prefix(['e', 'E']).is_some_and(|power| power.parse::<i16>().is_ok());
        let is_number = text.len() > 1 && text.starts_with(['N', 'n']) && text[1..].bytes().all(|b| b.is_ascii_digit());
        let help = match (is_exponent, is_number) {
            (true, _) => "write an exponent with EX: X1EX-7",
            (false, true) => "a block number is the first word of its block, before a label: N115 NEXT: G1 X60",
            (false, false) => {
                let name: String = shown.chars().take_while(|c| c.is_ascii_alphabetic()).collect();
                if name.eq_ignore_ascii_case("R") {
                    return refusals::radius_of_iso(&shown, word.span);
                }
                return refusals::refusal(&name.to_ascii_uppercase(), &shown, word.span);
            }
        };
        fault(Code::NOT_SUPPORTED, word.span, format!("{shown} is not supported yet"), help)
    }

    /// The number after an address.
    pub(super) fn number(&self, word: &Word) -> Result<f64, Fault> {
        match word.value {
            Value::Number(value, _) => Ok(value),
            Value::Expr(id) | Value::Dimension(_, id) => self.scope.number(id),
            Value::None | Value::Arguments(_) => {
                Err(fault(Code::MISSING_VALUE, word.span, "this address has no value", "give it a value"))
            }
        }
    }

    /// A whole number from 0 to `max`.
    pub(super) fn whole(&self, word: &Word, max: u32) -> Result<u32, Fault> {
        let value = self.number(word)?;
        if value.fract() == 0.0 && (0.0..=f64::from(max)).contains(&value) {
            return Ok(value as u32);
        }
        Err(bad_value(word.span, format!("{value} is not a whole number from 0 to {max}"), "correct the number"))
    }
}

/// Rejects implausible feeds and speeds.
fn plausible(value: f64, span: Span) -> Result<f64, Fault> {
    if value.is_nan() || value.abs() > MOST {
        return Err(bad_value(span, format!("{value} is too large for a word"), "check the value"));
    }
    Ok(value)
}

impl Gatherer<'_> {
    /// Reads the value of a named address.
    pub(super) fn address(&self, address: Named, word: &Word, out: &mut Gathered) -> Result<(), Fault> {
        let dimension = match word.value {
            Value::Dimension(function, _) => Some(function),
            _ => None,
        };
        if out.named(address).is_some() {
            return Err(gatherer::twice(word.span));
        }
        out.addresses.push(NamedValue { address, value: self.number(word)?, dimension, span: word.span });
        Ok(())
    }
}

/// Gathers a word of the code table.
///
/// Productions `compensation` and `soft`, their codes.
pub(super) fn gather_word(name: &'static str, out: &mut Gathered) {
    out.contour.push(name);
    if PASSED_ON.contains(&name) {
        out.keep.push(name);
    }
}
