//! Passes through words that do not change positions, with their evaluated values.
//!
//! The output has no variables and R parameters of the program, so their values replace them. Names that only the control knows (axes, spindles,
//! constants of cycles) stay as written.

use super::channel::Channel;
use super::contour_call::CONTOUR;
use super::feed;
use super::functions::is_function;
use super::gathered::Gathered;
use super::gatherer::Gatherer;
use super::level::Loaded;
use super::modal::Modal;
use super::names::{Meaning, is_indexed_letter, opaque_moves};
use super::scope::gatherer;
use super::value::Value as ExecValue;
use crate::exec::core::fault::{Fault, WITHOUT_IT, bad_value, fault};
use crate::syntax::sinumerik::{Address, ArgumentRange, Block, DimensionFunction, ExprId, Node, Value, Word};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::AxisSet;
use ncfix_base::source::Span;
use ncfix_base::units::MM_PER_INCH;
use ncfix_dialect::{Treatment, ValueUnit};
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::Kind;

/// Resolution of metric lengths and feeds, parts of a unit: without rounding noise.
const PARTS: f64 = 1e9;

/// Measuring cycles that can correct a zero offset or a tool offset (840D sl, measuring cycles: correction target of each cycle).
const MEASURING: [&str; 8] =
    ["CYCLE961", "CYCLE971", "CYCLE977", "CYCLE978", "CYCLE979", "CYCLE982", "CYCLE997", "CYCLE998"];

impl Gatherer<'_> {
    /// Takes a word that is passed through; `false` for another word.
    pub(super) fn passes(&self, word: &Word, block: &Block, out: &mut Gathered) -> Result<bool, Fault> {
        // Without a row: a letter with a number or an index, passed through unchanged.
        let row = match word.address {
            Address::Letter(b'L') => {
                let name: Vec<u8> =
                    self.source(word.span).iter().filter(|b| !b.is_ascii_whitespace()).copied().collect();
                let name = String::from_utf8_lossy(&name).to_ascii_uppercase();
                let Some(moves) = self.scope.machine.control.opaque_moves(&name) else { return Ok(false) };
                return self.opaque(word, block, moves, out);
            }
            // Acknowledged later by the machine; functions that end something stay after the motion.
            Address::Letter(b'M') => match word.value {
                Value::Dimension(DimensionFunction::Other, id)
                    if self
                        .scope
                        .machine
                        .head_of_word(u32::try_from(self.scope.whole(id)?).unwrap_or(u32::MAX))
                        .is_some() =>
                {
                    let message = "a word that changes the head is acknowledged later, so the block at which it acts is not known";
                    return Err(fault(Code::HEAD_CHANGE, word.span, message, "write the M word without a function"));
                }
                Value::Dimension(DimensionFunction::Other, id)
                    if !matches!(self.scope.whole(id)?, 0 | 1 | 2 | 5 | 6 | 9 | 17 | 30) =>
                {
                    None
                }
                _ => return Ok(false),
            },
            Address::Name(name) => match self.meanings[name.index()] {
                Meaning::Kept(row) => Some(row),
                Meaning::Opaque { moves } => return self.opaque(word, block, moves, out),
                _ => return Ok(false),
            },
            Address::Indexed(left) => match self.scope.program.expr(left).node {
                Node::Indexed(name, _) => match self.meanings[name.index()] {
                    Meaning::Kept(row) => Some(row),
                    Meaning::Unsupported => return self.positioning(left, word, block, out),
                    _ if is_indexed_letter(self.scope.program.names.text(name)) => None,
                    _ => return Ok(false),
                },
                _ => return Ok(false),
            },
            _ => return Ok(false),
        };
        let Some(row) = row else {
            out.verbatim.push(self.text(word, ValueUnit::None)?);
            return Ok(true);
        };
        match row.treatment {
            Treatment::BlockFeed => {
                let Value::Expr(id) = word.value else {
                    return Err(bad_value(word.span, "FB needs a value", "write for example FB=500"));
                };
                let value = self.scope.number(id)?;
                if value.is_nan() || value <= 0.0 {
                    return Err(bad_value(word.span, "a feed must be above 0", "program FB with a positive value"));
                }
                out.block_feed = Some(value * self.scale(ValueUnit::Feed));
            }
            Treatment::File => {
                let name = String::from_utf8_lossy(self.source(word.span)).into_owned();
                let name = name.split('(').next().unwrap_or_default().trim_end().to_ascii_uppercase();
                let message = format!("{name} is omitted from the output: files of the control are not changed");
                let help = "its result counts as 0, no error; remove the block if it is not needed";
                out.warning = Some(fault(Code::LEFT_OUT, word.span, message, help));
            }
            Treatment::Interrupt => {
                let end = block.comment.start.max(word.span.start);
                let span = Span { start: word.span.start, end };
                out.verbatim.push(self.source(span).trim_ascii_end().to_vec());
                out.is_complete = true;
                let message = "a program that an interrupt starts runs uncorrected on the control";
                let help = "if it cuts, correct that program too";
                out.warning = Some(fault(Code::NOT_CORRECTED, word.span, message, help));
            }
            Treatment::Lost => {
                out.verbatim.push(self.text(word, ValueUnit::None)?);
                out.lost = AxisSet::ALL;
            }
            Treatment::Refuse => {
                let shown = String::from_utf8_lossy(self.source(word.span)).into_owned();
                let shown: String = shown.chars().take(40).collect();
                let message = format!("{shown}: {}", row.meaning);
                return Err(fault(Code::NOT_SUPPORTED, word.span, message, WITHOUT_IT));
            }
            _ => {
                self.check_carrier(row.name, word)?;
                out.verbatim.push(self.text(word, row.unit)?);
            }
        }
        Ok(true)
    }

    /// Passes on only the end of a tool carrier, and not where it would end the carrier of a plane: the output states the plane without one.
    fn check_carrier(&self, name: &str, word: &Word) -> Result<(), Fault> {
        if !matches!(name, "TCARR" | "CUTMOD") {
            return Ok(());
        }
        if self.number(word)? != 0.0 {
            return Err(self.unsupported(word));
        }
        if let Some(swivelled) = self.scope.modal.swivelled.as_ref() {
            let message = format!("{name}=0 in a plane that {} has tilted", swivelled.source());
            return Err(fault(Code::BAD_SWIVEL, word.span, message, swivelled.way_out()));
        }
        Ok(())
    }

    /// A block with G25 or G26: all its words are limits.
    pub(super) fn limits(&self, block: &Block, span: Span, out: &mut Gathered) -> Result<(), Fault> {
        let mut text = Vec::new();
        for word in self.scope.program.words_of(block) {
            let is_other_code = matches!((word.address, word.value), (Address::Letter(b'G'), Value::Number(code, _)) if code != 25.0 && code != 26.0);
            let unit = match word.address {
                _ if is_other_code => {
                    let message = "G25 and G26 in a block with another G code";
                    return Err(fault(Code::MUST_STAND_ALONE, span, message, "move the other code to another block"));
                }
                Address::Letter(letter) if b"XYZUVW".contains(&letter) => ValueUnit::Length,
                Address::Letter(b'G' | b'S' | b'A' | b'B' | b'C') | Address::Extended(b'S', _) => ValueUnit::None,
                _ => {
                    let message = "G25 and G26 allow only limits in their block";
                    return Err(fault(Code::MUST_STAND_ALONE, span, message, "move the other words to another block"));
                }
            };
            if !text.is_empty() {
                text.push(b' ');
            }
            text.extend(self.text(word, unit)?);
        }
        out.verbatim.push(text);
        out.named = AxisSet::EMPTY;
        out.speed = None;
        out.before.clear();
        Ok(())
    }

    /// Passes through a call that the control executes, with its repetitions.
    fn opaque(&self, word: &Word, block: &Block, moves: bool, out: &mut Gathered) -> Result<bool, Fault> {
        self.check_contours(word)?;
        let mut text = self.text(word, ValueUnit::None)?;
        for other in self.scope.program.words_of(block).iter().filter(|other| other.span.start > word.span.start) {
            text.push(b' ');
            text.extend(self.text(other, ValueUnit::None)?);
        }
        out.verbatim.push(text);
        out.is_complete = true;
        if moves {
            out.lost = AxisSet::ALL;
        }
        if let Address::Name(name) = word.address
            && let name = self.scope.program.names.text(name)
            && MEASURING.contains(&name)
        {
            let message = format!(
                "{name} can set a zero offset or a tool offset to its measured value; the blocks after it are corrected for the values of the machine file"
            );
            let help = "compare the measured value with the machine file after the first run; if they differ by millimeters, enter it there and correct the program again";
            out.warning = Some(fault(Code::MAY_SET_OFFSETS, word.span, message, help));
        }
        Ok(true)
    }

    /// Rejects a cycle of the control whose contours the output would lack: it has neither blocks between labels nor a CYCLE62 that ncfix executes.
    fn check_contours(&self, word: &Word) -> Result<(), Fault> {
        let (Address::Name(name), Value::Arguments(range)) = (word.address, word.value) else { return Ok(()) };
        let name = self.scope.program.names.text(name);
        if name == CONTOUR {
            let kind = match self.scope.program.arguments_of(range).get(1) {
                Some(&Some(id)) => self.scope.number(id)?,
                _ => 0.0,
            };
            if kind != 0.0 {
                let message =
                    format!("{CONTOUR} of type {kind} is passed on, but the output has no blocks between its labels");
                let help = "put the contour into a file of its own, and name this file (type 0)";
                return Err(fault(Code::NOT_SUPPORTED, word.span, message, help));
            }
        } else if matches!(name, "CYCLE63" | "CYCLE64" | "CYCLE952")
            && opaque_moves(&self.scope.machine.control, CONTOUR).is_none()
        {
            let message = format!("{name} is passed on, but not the {CONTOUR} that names its contours");
            let help = format!(
                "add {CONTOUR} to control.opaque of the machine file, and put each contour into a file of its own (type 0)"
            );
            return Err(fault(Code::NOT_SUPPORTED, word.span, message, help));
        }
        Ok(())
    }

    /// The text value of an address; `None` for a number.
    pub(super) fn text_value(&self, word: &Word) -> Result<Option<Vec<u8>>, Fault> {
        let Value::Expr(id) = word.value else { return Ok(None) };
        Ok(match self.scope.value(id)? {
            ExecValue::Text(text) => Some(text),
            _ => None,
        })
    }

    fn source(&self, span: Span) -> &[u8] {
        self.scope.program.source.slice(span)
    }

    /// Factor for a value in the program's unit.
    fn scale(&self, unit: ValueUnit) -> f64 {
        let modal = self.scope.modal;
        match unit {
            ValueUnit::Length => modal.modes.scale(),
            ValueUnit::Feed if modal.inch_feed => MM_PER_INCH,
            ValueUnit::Feed | ValueUnit::None => 1.0,
        }
    }

    /// A word with evaluated values.
    pub(super) fn text(&self, word: &Word, unit: ValueUnit) -> Result<Vec<u8>, Fault> {
        let mut text = match word.address {
            Address::Letter(letter) => vec![letter],
            Address::Extended(letter, extension) => format!("{}{extension}", char::from(letter)).into_bytes(),
            Address::Name(name) => self.scope.program.names.text(name).as_bytes().to_vec(),
            Address::Indexed(left) => {
                let Node::Indexed(name, range) = self.scope.program.expr(left).node else {
                    return Ok(self.source(word.span).to_vec());
                };
                let mut text = self.scope.program.names.text(name).as_bytes().to_vec();
                text.push(b'[');
                self.arguments(range, ValueUnit::None, &mut text)?;
                text.push(b']');
                text
            }
        };
        match word.value {
            Value::None => {}
            Value::Number(value, _) => {
                if matches!(word.address, Address::Extended(..)) {
                    text.push(b'=');
                }
                text.extend(number_text(value * self.scale(unit)));
            }
            Value::Expr(id) => {
                text.push(b'=');
                text.extend(self.argument(id, unit)?);
            }
            Value::Dimension(_, id) => {
                let written = self.source(word.span);
                let start = written.iter().position(|&byte| byte == b'=').map_or(0, |at| at + 1);
                let end = written[start..].iter().position(|&byte| byte == b'(').map_or(start, |at| start + at);
                text.push(b'=');
                text.extend(written[start..end].trim_ascii().to_ascii_uppercase());
                text.push(b'(');
                text.extend(self.argument(id, unit)?);
                text.push(b')');
            }
            Value::Arguments(range) => {
                let is_list = self.source(word.span).contains(&b'=') && !matches!(word.address, Address::Name(_));
                text.extend_from_slice(if is_list { b"=(" } else { b"(" });
                self.arguments(range, unit, &mut text)?;
                text.push(b')');
            }
        }
        Ok(text)
    }

    /// Arguments with evaluated values; the unit applies to the first one.
    fn arguments(&self, range: ArgumentRange, unit: ValueUnit, out: &mut Vec<u8>) -> Result<(), Fault> {
        for (index, argument) in self.scope.program.arguments_of(range).iter().enumerate() {
            if index > 0 {
                out.push(b',');
            }
            if let Some(id) = argument {
                out.extend(self.argument(*id, if index == 0 { unit } else { ValueUnit::None })?);
            }
        }
        Ok(())
    }

    /// The value of an expression as text; the expression itself if only the control knows its names.
    fn argument(&self, id: ExprId, unit: ValueUnit) -> Result<Vec<u8>, Fault> {
        let value = match self.scope.value(id) {
            Ok(value) => value,
            Err(found) => {
                let mut names = Named::default();
                self.look(id, &mut names);
                let is_foreign = names.foreign && !names.own;
                return if is_foreign {
                    Ok(self.source(self.scope.program.expr(id).span).to_vec())
                } else {
                    Err(found)
                };
            }
        };
        Ok(match value {
            ExecValue::Text(text) => [b"\"", text.as_slice(), b"\""].concat(),
            ExecValue::Bool(truth) => if truth { &b"TRUE"[..] } else { b"FALSE" }.to_vec(),
            other => match other.number() {
                Some(number) => number_text(number * self.scale(unit)),
                None => other.text(),
            },
        })
    }

    /// Searches for names of the program and for names that only the control knows.
    fn look(&self, id: ExprId, names: &mut Named) {
        let program = self.scope.program;
        let is_own = |name| {
            let text = program.names.text(name);
            text.starts_with('$') || self.scope.variables.has(name, text)
        };
        let inside = |range: ArgumentRange, names: &mut Named| {
            for argument in program.arguments_of(range).iter().flatten() {
                self.look(*argument, names);
            }
        };
        match program.expr(id).node {
            Node::Real(_) | Node::Integer(_) | Node::Boolean(_) | Node::Text(_) => {}
            Node::Parameter(_) | Node::ParameterAt(_) => names.own = true,
            Node::Name(name) if is_own(name) => names.own = true,
            Node::Name(_) => names.foreign = true,
            Node::Indexed(name, range) => {
                names.own |= is_own(name);
                names.foreign |= !is_own(name);
                inside(range, names);
            }
            Node::Call(name, range) => {
                names.foreign |= !is_function(program.names.text(name));
                inside(range, names);
            }
            Node::Unary(_, inner) => self.look(inner, names),
            Node::Binary(_, left, right) => {
                self.look(left, names);
                self.look(right, names);
            }
        }
    }
}

/// Kinds of names in an expression.
#[derive(Default)]
struct Named {
    /// Variables and parameters of the program.
    own: bool,
    /// Names that only the control knows.
    foreign: bool,
}

/// A number in program notation.
pub(super) fn number_text(value: f64) -> Vec<u8> {
    ((value * PARTS).round() / PARTS).to_string().into_bytes()
}

/// A call statement that the control executes: `CALL "NAME"`, `PCALL path(…)`, `EXTCALL("NAME")`.
pub(super) fn opaque_statement(
    loaded: &Loaded,
    channel: &mut Channel<'_>,
    (span, name): (Span, &str),
    arguments: Option<ArgumentRange>,
    moves: bool,
) -> Result<(), Fault> {
    let source = loaded.program.source.slice(span);
    let keyword: Vec<u8> = source.iter().take_while(|byte| byte.is_ascii_alphabetic()).copied().collect();
    let mut text = keyword.to_ascii_uppercase();
    match text.as_slice() {
        b"EXTCALL" => text.extend(format!("(\"{name}\")").into_bytes()),
        b"CALL" => text.extend(format!(" \"{name}\"").into_bytes()),
        _ => text.extend(format!(" {name}").into_bytes()),
    }
    if let Some(range) = arguments {
        text.push(b'(');
        gatherer(loaded, channel, channel.settings.machine).arguments(range, ValueUnit::None, &mut text)?;
        text.push(b')');
    }
    feed::feed_for_call(&channel.modal, &channel.splines, &mut channel.outlet);
    channel.push(Kind::Verbatim(text));
    if moves {
        channel.modal.forget_position();
        channel.push(Kind::Lost(AxisSet::ALL));
    }
    Ok(())
}

/// Rejects positions of the transverse axis in diameters, and cutting speeds in feet.
pub(super) fn check_diameter(machine: &Machine, modal: &mut Modal, gathered: &Gathered) -> Result<(), Fault> {
    if let (Some((_, span)), true) = (gathered.speed, modal.modes.inch)
        && matches!(modal.stated.codes.code(15), Some("G96" | "G961" | "G962"))
    {
        // The output is metric, where the number would mean m/min.
        let message = "a cutting speed in feet per minute, which is not supported yet";
        return Err(fault(Code::NOT_SUPPORTED, span, message, "program G71 or G710 and the cutting speed in m/min"));
    }
    if let Some((diameter, span)) = gathered.diameter {
        modal.diameter = diameter.then_some(span);
    }
    let axis = machine.control.transverse_axis;
    let is_programmed = gathered.named.contains(axis) || gathered.center.get(axis.slot()).is_some_and(Option::is_some);
    if modal.diameter.is_none() || !is_programmed {
        return Ok(());
    }
    let message = format!("positions of {axis} are diameters here, which is not supported yet");
    let help = "program DIAMOF and radii, or set control.transverse_axis if another axis is meant";
    Err(fault(Code::NOT_SUPPORTED, gathered.axis_spans[axis.slot()], message, help))
}
