//! Settings of the control for the text that it can read: increments, block numbers.

use super::Control;
use super::section::Section;
use ncfix_base::diagnostic::Code;

/// Returns the defaults for the language of the control, before the file is read.
pub(super) fn of_controller(controller: &str) -> Control {
    let control = Control::default();
    // IS-B of Fanuc and the word formats of Grundig have a resolution of one thousandth.
    if ["fanuc", "grundig"].iter().any(|name| controller.eq_ignore_ascii_case(name)) {
        let increment = [1e-3, 1e-3_f64.to_radians()];
        return Control { increment_mm: increment[0], increment_rad: increment[1], grid: increment, ..control };
    }
    control
}

/// Reads the settings.
pub(super) fn read(section: &mut Section<'_>, control: &mut Control) {
    let decimal = |value: f64| value > 0.0 && ((value * 1e9).round() / 1e9 - value).abs() < 1e-15 * value.max(1.0);
    const DECIMAL: &str = "a number above 0 with at most 9 decimals";
    if let Some(value) = section.number_where("increment_mm", DECIMAL, decimal) {
        control.increment_mm = value;
    }
    if let Some(value) = section.number_where("increment_deg", DECIMAL, decimal) {
        control.increment_rad = value.to_radians();
    }
    control.grid = [control.increment_mm, control.increment_rad];
    let whole = |value: f64| (1.0..=1e9).contains(&value) && value.fract() == 0.0;
    // The output states positions as decimals: one increment must be a decimal of at most nine places.
    let divides = |value: f64| whole(value) && 1e9 % value == 0.0;
    const DIVISOR: &str = "a whole number that divides 1000000000, such as 1000 or 10000";
    if let Some(value) = section.number_where("increments_per_mm", DIVISOR, divides) {
        control.increments_per_mm = Some(value);
    }
    match section.text("saved_unit") {
        None => {}
        Some("mm") => control.saved_inch = Some(false),
        Some("inch") => control.saved_inch = Some(true),
        Some(other) => {
            let message = format!("saved_unit must be \"mm\" or \"inch\", found \"{other}\"");
            let help = "write the unit of the files in which the control saves offsets and tools";
            section.report(Code::BAD_VALUE, section.place_of("saved_unit"), message, help);
        }
    }
    let block_number = |value: f64| (100.0..=99_999_999.0).contains(&value) && value.fract() == 0.0;
    if let Some(value) = section.number_where("last_block_number", "a whole number from 100 to 99999999", block_number)
    {
        // The conversion is exact: a whole number below 10⁸.
        control.last_block_number = Some(value as u32);
    }
}

/// Limits the output increments to the input resolution of the control: it would round finer values and move to other positions.
pub(super) fn keep_to_grid(control: &mut Control, controller: &str) {
    if let Some([linear_mm, rotary_rad]) = control.word_grid(controller) {
        control.increment_mm = control.increment_mm.max(linear_mm);
        control.increment_rad = control.increment_rad.max(rotary_rad);
    }
}

impl Control {
    /// Returns the grid of the words that a control of this language reads, mm and rad; `None` if it reads them exactly.
    #[must_use]
    pub fn word_grid(&self, language: &str) -> Option<[f64; 2]> {
        match language.to_ascii_lowercase().as_str() {
            "fanuc" => {
                let step = 1.0 / self.iso.increment_system.per_unit();
                Some([step, step.to_radians()])
            }
            "grundig" => Some(self.grid),
            // MD10200 counts the increments of linear axes; nothing is stated for rotary axes.
            "sinumerik" => self.increments_per_mm.map(|per_mm| [1.0 / per_mm, 0.0]),
            _ => None,
        }
    }

    /// True for linear words, and for rotary words, if they are written finer than a control of this language reads them.
    #[must_use]
    pub fn is_finer_than_read(&self, language: &str) -> [bool; 2] {
        /// Increments are decimals; their binary values differ by less than this share.
        const SAME_SHARE: f64 = 1e-9;
        let Some([linear_mm, rotary_rad]) = self.word_grid(language) else { return [false; 2] };
        [(self.increment_mm, linear_mm), (self.increment_rad, rotary_rad)]
            .map(|(written, read)| written < read * (1.0 - SAME_SHARE))
    }
}
