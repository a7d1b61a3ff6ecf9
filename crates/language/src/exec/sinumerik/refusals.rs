//! Words whose refusal has a reason and a remedy of its own.

use crate::exec::core::fault::{Fault, WITHOUT_IT, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;

/// Words, reason and remedy.
const REASONS: &[(&[&str], &str, &str)] = &[
    (
        &["ISOCALL"],
        "it runs a program in the ISO language, and ncfix executes a program in one language",
        "write the called program in the language of this one, or correct it with `--dialect fanuc` as a program of its own",
    ),
    (
        &["G291"],
        "the blocks after it are in the ISO language, and ncfix executes a program in one language",
        "put them into a file of their own and correct it with `--dialect fanuc`",
    ),
    (
        &["TCARR", "TCOFR", "CUTMOD"],
        "it turns the tool length by a tool carrier, whose data are only in the control",
        "tilt the plane with CYCLE800, which uses the rotary axes of the machine file",
    ),
    (
        &["PAROT"],
        "it turns the frame by a tool carrier, whose data are only in the control",
        "tilt the plane with CYCLE800, or program the rotation with AROT",
    ),
    (
        &["TOROTX", "TOROTY"],
        "no manual at hand states the direction of the other two axes of this frame",
        "let Z point along the tool with TOROT, or program the rotation with AROT",
    ),
];

/// R with a number in a motion: R is a parameter of this control, and the radius of an arc has an address of its own.
pub(super) fn radius_of_iso(shown: &str, span: Span) -> Fault {
    let message = format!("{shown} is no word of a motion: R is a parameter of this control, such as R1=5");
    let help = "write the radius of an arc with CR=, and a length of polar coordinates with RP=: G3 X70 Y10 CR=40";
    fault(Code::NOT_SUPPORTED, span, message, help)
}

/// The refusal of a word that is known and not executed; `shown` is what the message names.
pub(super) fn refusal(name: &str, shown: &str, span: Span) -> Fault {
    let row = REASONS.iter().find(|(names, ..)| names.contains(&name));
    let (message, help) = match row {
        Some((_, reason, help)) => (format!("{shown} is not executed: {reason}"), *help),
        None => (format!("{shown} is not supported yet"), WITHOUT_IT),
    };
    fault(Code::NOT_SUPPORTED, span, message, help)
}
