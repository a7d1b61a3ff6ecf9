//! `ncfix fix --feed-limit`: the servo loops that it needs, and its effect, for the report.

use crate::diagnostics::Diagnostics;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::units::um_from_mm;
use ncfix_machine::machine::{Machine, Servo};
use ncfix_path::servo::{Limited, Tally};
use ncfix_report::json::{Contouring, FeedLimit};

/// The `[servo]` section of the machine file; a diagnostic if it is missing.
pub(crate) fn servo<'m>(machine: &'m Machine, findings: &mut Diagnostics) -> Option<&'m Servo> {
    if machine.changes_heads() {
        let message = format!("errors at feed are simulated for one spindle, and {} has several heads", machine.name);
        let help = "make a machine file with the [spindle] of the head that the program uses";
        findings.add(Diagnostic::nowhere(Code::NOT_SUPPORTED, message, help), &[]);
        return None;
    }
    if machine.servo.is_none() {
        let message =
            format!("the machine file of {} does not describe how its axes follow a program at feed", machine.name);
        let help = "add [servo] with cycle_ms, smoothing_ms and corner_tolerance_um, and for every axis [servo.X] with velocity_gain_per_s, \
                    feed_forward and max_acceleration_m_s2: docs/reference/servo.md";
        findings.add(Diagnostic::nowhere(Code::NO_SERVO, message, help), &[]);
    }
    machine.servo.as_ref()
}

/// A contouring error in the units of reports.
pub(crate) fn contouring(tally: &Tally) -> Contouring {
    Contouring { rms_um: um_from_mm(tally.rms_mm()), max_um: um_from_mm(tally.max_mm) }
}

/// The result of the feed limit, in the units of reports.
pub(crate) fn report(limit_mm: f64, limited: &Limited) -> FeedLimit {
    FeedLimit {
        limit_um: um_from_mm(limit_mm),
        contouring_before: contouring(&limited.before),
        contouring_after: contouring(&limited.after),
        time_before_s: limited.times_s[0],
        time_after_s: limited.times_s[1],
        slowed: limited.slowed,
        exceeding: limited.exceeding,
    }
}
