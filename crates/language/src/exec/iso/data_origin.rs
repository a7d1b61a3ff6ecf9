//! Origin of a value in a zero offset or a tool value of the control.

use crate::exec::core::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;

/// Origin of a value in data of the control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum DataOrigin {
    /// The value of the variable of this number, and a step in the unit of the program.
    Stepped { number: u32, step: f64 },
    /// Computed from such a value in another way.
    Computed,
}

impl DataOrigin {
    /// `true` if it is the value of the variable of this number and a step other than 0.
    pub(super) fn adds_to(self, place: u32) -> bool {
        matches!(self, DataOrigin::Stepped { number, step } if number == place && step != 0.0)
    }

    /// Returns the sum as it is written, without brackets: `#5221+5`. The step is multiplied by a factor for the unit of the output.
    pub(super) fn text(self, factor: f64) -> Option<String> {
        let DataOrigin::Stepped { number, step } = self else { return None };
        let shown = decimals(step * factor);
        Some(match shown.as_str() {
            "0" => format!("#{number}"),
            shown if shown.starts_with('-') => format!("#{number}{shown}"),
            shown => format!("#{number}+{shown}"),
        })
    }
}

/// The error for a value that the output cannot keep as the control computes it.
pub(super) fn not_kept(span: Span) -> Fault {
    let message = "the new value is computed from a zero offset or a tool value of the control, and not as its value plus a number";
    let help = "write the change as a sum, such as #5221=#5221+5. or G10 L2 P1 X[#5221+5.], or write the new value as a number";
    fault(Code::NO_SYSTEM_VALUE, span, message, help)
}

/// A value with up to six decimals, without trailing zeros.
pub(super) fn decimals(value: f64) -> String {
    let mut shown = format!("{value:.6}");
    shown.truncate(shown.trim_end_matches('0').trim_end_matches('.').len());
    if shown == "-0" { "0".to_owned() } else { shown }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sum_is_written_as_the_control_computes_it() {
        let text = |number, step| DataOrigin::Stepped { number, step }.text(1.0).unwrap();
        assert_eq!([text(5221, 5.0), text(5221, -0.25), text(5221, 0.0)], ["#5221+5", "#5221-0.25", "#5221"]);
        assert_eq!(DataOrigin::Computed.text(1.0), None);
    }
}
