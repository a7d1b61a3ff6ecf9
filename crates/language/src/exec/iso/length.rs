//! Tool length compensation: G43, G44, G49 and what tables of offsets hold.

use super::channel::Channel;
use super::codes::{Group, name_of};
use super::gather::whole;
use super::gathered::Gathered;
use crate::exec::core::fault::{Fault, bad_value, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, Vector};
use ncfix_base::source::Span;
use ncfix_machine::machine::LengthAxis;
use ncfix_machine::snc::{Kind, Word, WordValue};

/// Offsets of one number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ToolOffset {
    /// Along X, Y, Z; of a Fanuc the length is that along Z.
    pub(super) length_mm: Vector,
    pub(super) length_wear_mm: f64,
    pub(super) radius_mm: f64,
    pub(super) radius_wear_mm: f64,
    /// Whether the program has set it.
    pub(super) is_stated: bool,
}

impl Channel<'_> {
    /// Offsets of a number, as the program or the machine file set them.
    pub(super) fn tool_offset(&self, number: u32) -> Option<ToolOffset> {
        self.tools.get(&number).copied().or_else(|| {
            let tool = self.machine.tool(number, 1)?;
            let [first, second, third] = tool.length_mm;
            // Lengths 1, 2, 3 lie along Z, Y, X.
            let length_mm = Vector::new(third, second, first);
            Some(ToolOffset { length_mm, radius_mm: tool.radius_mm, ..ToolOffset::default() })
        })
    }

    /// Executes the code of length compensation. Whether it took the axis words, so that the block has no motion.
    pub(super) fn length_codes(&mut self, gathered: &Gathered) -> Result<bool, Fault> {
        let code = gathered.code(Group::Length);
        let Some(code) = code.or_else(|| self.again(gathered)) else { return Ok(false) };
        let span = if gathered.code(Group::Length).is_some() {
            gathered.code_span(Group::Length)
        } else {
            gathered.span_of(b'H')
        };
        if self.is_rs274() {
            self.no_compensation(span, &name_of(code))?;
            self.rs274_length(gathered, code, span)
        } else {
            self.fanuc_length(gathered, code, span)?;
            Ok(false)
        }
    }

    /// H alone changes the offset while compensation is on (Fanuc).
    fn again(&self, gathered: &Gathered) -> Option<u16> {
        let code = self.modal.length_code;
        (!self.is_rs274() && code != 490 && gathered.has(b'H') && gathered.code(Group::Action).is_none())
            .then_some(code)
    }

    fn rs274_length(&mut self, gathered: &Gathered, code: u16, span: Span) -> Result<bool, Fault> {
        let mut length = if code == 490 || code == 430 { Vector::zeros() } else { self.modal.length_mm };
        let mut text = name_of(code);
        let (mut takes_axes, mut assumed) = (false, false);
        match code {
            430 => {
                let number = match gathered.raw(b'H') {
                    Some(value) => whole(value, gathered.span_of(b'H'), "H")?,
                    None => self.modal.active.unwrap_or(0),
                };
                if gathered.has(b'H') {
                    self.append(&mut text, b'H', f64::from(number));
                }
                (length, assumed) = self.table_length(number, span)?;
                self.modal.h = number;
            }
            432 if gathered.has(b'H') => {
                let number = whole(gathered.raw(b'H').unwrap_or(0.0), gathered.span_of(b'H'), "H")?;
                self.append(&mut text, b'H', f64::from(number));
                let (more, is_assumed) = self.table_length(number, span)?;
                length += more;
                assumed = is_assumed;
            }
            431 | 432 => {
                takes_axes = true;
                for axis in gathered.axes.iter() {
                    if !AxisSet::XYZ.contains(axis) {
                        let message = format!("a tool offset along {axis} is not supported");
                        let at = gathered.span_of(axis.letter());
                        return Err(fault(Code::NOT_SUPPORTED, at, message, "name X, Y or Z"));
                    }
                    let value = self.axis_value(gathered, axis)?;
                    let place = &mut length[axis.slot()];
                    *place = if code == 431 { value } else { *place + value };
                    self.append_length(&mut text, axis.letter(), value);
                }
            }
            _ => {}
        }
        self.modal.length_code = code;
        self.put_length(length, assumed);
        self.push(Kind::Verbatim(text.into_bytes()));
        Ok(takes_axes)
    }

    /// The offset of a number and whether it is assumed.
    fn table_length(&mut self, number: u32, span: Span) -> Result<(Vector, bool), Fault> {
        if number == 0 {
            return Ok((Vector::zeros(), false));
        }
        if let Some(offset) = self.tool_offset(number) {
            let wear = Vector::new(0.0, 0.0, offset.length_wear_mm);
            return Ok((offset.length_mm + wear, false));
        }
        let message = format!("tool offset {number} has no value in the machine file");
        let help = "add a [[tool]] entry of this number there or in a file given with --setup";
        if self.strict {
            return Err(fault(Code::NO_TOOL, span, message, help));
        }
        self.outlet.warnings.push(fault(Code::TOOL_ASSUMED, span, format!("{message}; length 0 is used"), help));
        Ok((Vector::zeros(), true))
    }

    fn fanuc_length(&mut self, gathered: &Gathered, code: u16, span: Span) -> Result<(), Fault> {
        if code == 431 {
            let message = "G43.1 is not supported";
            return Err(fault(Code::NOT_SUPPORTED, span, message, "use G43 H with the length of the tool"));
        }
        if let Some(value) = gathered.raw(b'H') {
            self.modal.h = whole(value, gathered.span_of(b'H'), "H")?;
        }
        let is_off = code == 490;
        let (table, assumed) = if is_off { (Vector::zeros(), false) } else { self.table_length(self.modal.h, span)? };
        let size = if code == 440 { -table[2] } else { table[2] };
        // Along several axes where several blocks say so; G49 ends them all, H0 that of its axis.
        let mut length = Vector::zeros();
        if !is_off {
            if self.machine.control.iso.length_axis != LengthAxis::Z {
                length = self.modal.length_mm;
            }
            if size != 0.0 || length != Vector::zeros() {
                let is_along_tool = matches!(code, 434 | 435);
                let axis = if is_along_tool { Axis::Z } else { self.length_axis(gathered, span)? };
                length[axis.slot()] = size;
            }
        }
        if self.modal.transforms.turns(&length) {
            return Err(turned_length(span));
        }
        let (was_turning, tool_mm, axes) = (self.modal.turning.is_some(), self.setup.tool_mm, self.axis_command());
        self.switch_tip(code, gathered, span)?;
        self.modal.length_code = code;
        self.put_length(length, assumed);
        if !is_off {
            self.stand_anew(span)?;
        }
        if was_turning || self.modal.turning.is_some() {
            self.forget_moved_tip(&axes, &tool_mm);
        }
        match code {
            430 => self.push(Kind::Keep("G43")),
            440 => self.push(Kind::Keep("G44")),
            // The output gives positions of the rotary axes, also where the program gives directions.
            434 | 435 => self.push(Kind::Keep("G43.4")),
            _ => self.push(Kind::Keep("G49")),
        }
        if gathered.has(b'H') {
            let value = WordValue::Number(f64::from(self.modal.h));
            self.before.push(Word { letter: b'H', extension: None, value });
        }
        Ok(())
    }

    /// The axis along which a Fanuc compensates (parameter 5001).
    fn length_axis(&self, gathered: &Gathered, span: Span) -> Result<Axis, Fault> {
        match self.machine.control.iso.length_axis {
            LengthAxis::Z => Ok(Axis::Z),
            LengthAxis::Plane => {
                let [.., applicate] = self.modal.plane.axes();
                Ok(applicate)
            }
            LengthAxis::Programmed => {
                let mut named = gathered.axes.intersection(AxisSet::XYZ).iter();
                match (named.next(), named.next()) {
                    (Some(axis), None) => Ok(axis),
                    (None, _) => {
                        let has_length = |axis: &Axis| self.modal.length_mm[axis.slot()] != 0.0;
                        let mut in_force = AxisSet::XYZ.iter().filter(has_length);
                        match (in_force.next(), in_force.next()) {
                            (Some(_), Some(_)) => Err(unclear_axis(span)),
                            (axis, _) => Ok(axis.unwrap_or(Axis::Z)),
                        }
                    }
                    _ => Err(unclear_axis(span)),
                }
            }
        }
    }

    /// Puts a length in force.
    pub(super) fn put_length(&mut self, length_mm: Vector, assumed: bool) {
        self.modal.length_mm = length_mm;
        self.modal.length_assumed = assumed;
        self.refresh_setup();
    }
}

fn unclear_axis(span: Span) -> Fault {
    bad_value(span, "the axis of the length is not clear", "name one of X, Y, Z with G43")
}

/// The control turns the length with the coordinates, while the tool stays as it is.
pub(super) fn turned_length(span: Span) -> Fault {
    let message = "tool length compensation and a rotation in space (G68 I J K) together";
    fault(Code::NOT_SUPPORTED, span, message, "use G68.2 and G53.1, or program without G43")
}
