//! Comparison of the commanded position with the one that a control reports.

use ncfix_base::units::MM_PER_INCH;

use super::{CommandedPosition, is_rotary, slot};

/// Permitted difference of a linear axis, mm: half a step of a drive with 10 steps/mm, the coarsest in use.
const LINEAR_MM: f64 = 0.05;
/// Permitted difference of a rotary axis, degrees: half a step of a drive with 5 steps/°.
const ROTARY_DEG: f64 = 0.1;
/// Revolution, degrees: some controls report a rotary axis within one.
const TURN_DEG: f64 = 360.0;

/// Result of a comparison.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::feed::dialogue) enum PositionComparison {
    /// No axis can be compared.
    Nothing,
    /// These axes agree.
    Agrees(String),
    /// An axis differs. The text names both positions.
    Differs(String),
}

impl CommandedPosition {
    /// True if the end of the program may have changed the zero offset, so that a difference proves nothing.
    fn is_unsure(&self) -> bool {
        self.has_ended && (self.is_shifted || self.offset != Some(540))
    }

    /// Compares with positions that a control reports in the coordinates of the program. Each has the number of its digits after the point. The unit of a
    /// linear axis may be the inch, whatever the program uses.
    pub(in crate::feed::dialogue) fn compare(&self, reported: &[(u8, f64, usize)]) -> PositionComparison {
        if self.is_beyond {
            return PositionComparison::Nothing;
        }
        // Units of the report in units of the text, which is in millimeters unless it stated nothing.
        let factors: &[f64] =
            if self.unit_mm.is_some() { &[1.0, MM_PER_INCH] } else { &[1.0, MM_PER_INCH, 1.0 / MM_PER_INCH] };
        let first = self.by(reported, 1.0);
        let best = factors
            .iter()
            .map(|factor| self.by(reported, *factor))
            .find(|found| !matches!(found, PositionComparison::Differs(_)));
        match best {
            Some(found) => found,
            None if self.is_unsure() => PositionComparison::Nothing,
            None => first,
        }
    }

    fn by(&self, reported: &[(u8, f64, usize)], factor: f64) -> PositionComparison {
        let mut agreed = String::new();
        for &(letter, value, digits) in reported {
            let Some(slot) = slot(letter) else { continue };
            let Some(commanded) = self.axes[slot] else { continue };
            let rotary = is_rotary(slot);
            let (value, unit) = if rotary { (value, "°") } else { (value * factor, " mm") };
            let mut difference = (value - commanded).abs();
            if rotary {
                difference %= TURN_DEG;
                difference = difference.min(TURN_DEG - difference);
            }
            let digit = 0.5 * 10_f64.powi(-i32::try_from(digits).unwrap_or(0)) * if rotary { 1.0 } else { factor };
            let most = digit + if rotary { ROTARY_DEG } else { LINEAR_MM };
            if difference.is_nan() || difference > most {
                let letter = char::from(letter);
                return PositionComparison::Differs(format!(
                    "it reports {letter} at {value:.3}{unit}, the lines sent command {commanded:.3}{unit} (permitted difference {most:.2}{unit})"
                ));
            }
            agreed.push(char::from(letter));
        }
        if agreed.is_empty() { PositionComparison::Nothing } else { PositionComparison::Agrees(agreed) }
    }
}

/// Returns the reason that ends a job if the position differs, from the sentence with both positions.
pub(in crate::feed::dialogue) fn elsewhere(why: &str) -> String {
    format!(
        "the control is at another position: {why}; a line was accepted and not executed, or a person has moved the axes or changed the zero offset"
    )
}

/// Reads a number and the count of its digits after the point.
pub(in crate::feed::dialogue) fn number(text: &str) -> Option<(f64, usize)> {
    let text = text.trim();
    let value: f64 = text.parse().ok()?;
    let digits = text.split_once('.').map_or(0, |(_, digits)| digits.len());
    value.is_finite().then_some((value, digits))
}
