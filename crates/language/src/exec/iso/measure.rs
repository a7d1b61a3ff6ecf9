//! Lengths and angles of words: what a number counts, and the grid on which it lies.

use super::channel::Channel;
use super::gathered::Gathered;
use crate::exec::core::fault::{Fault, fault};
use crate::exec::core::grid::on_grid;
use ncfix_base::diagnostic::Code;
use ncfix_machine::machine::DecimalPoint;

impl Channel<'_> {
    /// A length word, mm.
    pub(super) fn length(&mut self, gathered: &Gathered, letter: u8) -> Result<Option<f64>, Fault> {
        let Some(value) = gathered.raw(letter) else { return Ok(None) };
        let scale = self.modal.scale();
        if self.is_rs274() || value == 0.0 {
            return Ok(Some(value * scale));
        }
        let per_unit = self.increments_per_length();
        if gathered.is_unpointed(letter) && self.has_increments(gathered, letter)? {
            return Ok(Some(value / per_unit * scale));
        }
        // Leads of threads are finer.
        let value = if matches!(letter, b'E' | b'F') { value } else { on_grid(value, per_unit) };
        Ok(Some(value * scale))
    }

    /// An angle word, rad.
    pub(super) fn angle(&mut self, gathered: &Gathered, letter: u8) -> Result<Option<f64>, Fault> {
        let Some(value) = gathered.raw(letter) else { return Ok(None) };
        if self.is_rs274() || value == 0.0 {
            return Ok(Some(value.to_radians()));
        }
        let per_degree = self.increments_per_degree();
        if gathered.is_unpointed(letter) && self.has_increments(gathered, letter)? {
            return Ok(Some((value / per_degree).to_radians()));
        }
        Ok(Some(on_grid(value, per_degree).to_radians()))
    }

    /// Increments of a Fanuc in a length unit of the program.
    pub(super) fn increments_per_length(&self) -> f64 {
        self.increments_per(self.modal.inch)
    }

    /// Increments of a Fanuc in a degree.
    pub(super) fn increments_per_degree(&self) -> f64 {
        self.machine.control.iso.increment_system.per_unit()
    }

    /// Increments of a Fanuc in an inch or a millimeter.
    pub(super) fn increments_per(&self, inch: bool) -> f64 {
        self.machine.control.iso.increment_system.per_unit() * if inch { 10.0 } else { 1.0 }
    }

    /// Whether a number without a decimal point counts increments. Where the machine file does not say it, this is a finding: a
    /// factor of a thousand is not guessed.
    fn has_increments(&mut self, gathered: &Gathered, letter: u8) -> Result<bool, Fault> {
        if let Some(point) = self.machine.control.iso.decimal_point {
            return Ok(point == DecimalPoint::Increment);
        }
        if std::mem::replace(&mut self.point_warned, true) {
            return Ok(false);
        }
        let message =
            "a number without a decimal point, which is whole units or least increments by a parameter of the control";
        let help = "set control.decimal_point to \"calculator\" or \"increment\" in the machine file";
        Err(fault(Code::UNITS_DOUBT, gathered.span_of(letter), message, help))
    }
}
