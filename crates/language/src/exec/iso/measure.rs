//! Lengths and angles of words: the unit of a number, and its rounding grid.

use super::channel::Channel;
use super::channel::Warned;
use super::gathered::Gathered;
use super::modal::Modal;
use crate::exec::core::fault::bad_value;
use crate::exec::core::fault::{Fault, fault};
use crate::exec::core::grid::on_grid;
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_dialect::Language;
use ncfix_machine::machine::DecimalPoint;
use ncfix_machine::machine::Machine;

/// A length word, mm.
pub(super) fn length(channel: &mut Channel<'_>, gathered: &Gathered, letter: u8) -> Result<Option<f64>, Fault> {
    let Some(value) = gathered.raw(letter) else { return Ok(None) };
    let scale = channel.modal.modes.scale();
    if channel.is_rs274() || value == 0.0 {
        return Ok(Some(value * scale));
    }
    let per_unit = increments_per_length(channel.settings.machine, &channel.modal);
    if gathered.is_unpointed(letter) && has_increments(channel.settings.machine, &mut channel.warned, gathered, letter)?
    {
        return Ok(Some(value / per_unit * scale));
    }
    // Leads of threads have a finer resolution.
    let value = if matches!(letter, b'E' | b'F') { value } else { on_grid(value, per_unit) };
    Ok(Some(value * scale))
}

/// An angle word, rad.
pub(super) fn angle(
    machine: &Machine,
    language: Language,
    warned: &mut Warned,
    gathered: &Gathered,
    letter: u8,
) -> Result<Option<f64>, Fault> {
    let Some(value) = gathered.raw(letter) else { return Ok(None) };
    if language == Language::Rs274 || value == 0.0 {
        return Ok(Some(value.to_radians()));
    }
    let per_degree = increments_per_degree(machine);
    if gathered.is_unpointed(letter) && has_increments(machine, warned, gathered, letter)? {
        return Ok(Some((value / per_degree).to_radians()));
    }
    Ok(Some(on_grid(value, per_degree).to_radians()))
}

/// Increments of a Fanuc per length unit of the program.
pub(super) fn increments_per_length(machine: &Machine, modal: &Modal) -> f64 {
    increments_per(machine, modal.modes.inch)
}

/// Increments of a Fanuc per degree.
pub(super) fn increments_per_degree(machine: &Machine) -> f64 {
    machine.control.iso.increment_system.per_unit()
}

/// Increments of a Fanuc per inch or millimeter.
pub(super) fn increments_per(machine: &Machine, inch: bool) -> f64 {
    machine.control.iso.increment_system.per_unit() * if inch { 10.0 } else { 1.0 }
}

/// `true` if a number without decimal point counts increments. If the machine file does not define it, this is reported: a factor of a thousand is
/// not guessed.
fn has_increments(machine: &Machine, warned: &mut Warned, gathered: &Gathered, letter: u8) -> Result<bool, Fault> {
    if let Some(point) = machine.control.iso.decimal_point {
        return Ok(point == DecimalPoint::Increment);
    }
    if std::mem::replace(&mut warned.point, true) {
        return Ok(false);
    }
    let message =
        "a number without a decimal point: a parameter of the control decides between whole units and least increments";
    let help = "set control.decimal_point to \"calculator\" or \"increment\" in the machine file";
    Err(fault(Code::UNITS_DOUBT, gathered.span_of(letter), message, help))
}

/// Tolerance of a computed code that must be a whole number.
pub(super) const NEAR: f64 = 1e-3;

/// Converts the value of a code to a whole number.
pub(super) fn whole(value: f64, span: Span, what: &str) -> Result<u32, Fault> {
    let rounded = value.round();
    if (value - rounded).abs() > NEAR || !(0.0..=f64::from(u32::MAX)).contains(&rounded) {
        let message = format!("{what}{value} is not a whole number, 0 or larger");
        return Err(bad_value(span, message, "write a whole number that is not negative"));
    }
    Ok(rounded as u32)
}
