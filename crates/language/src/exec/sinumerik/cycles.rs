//! The register of the control's cycles: built-in programs in the control's own language.
//!
//! A program of the same name among the user's files has priority. Elements and diagnostics of a cycle have the place of the calling block, as the
//! user does not have the text of the cycle.

use crate::exec::core::fault::{Fault, fault};
use ncfix_base::diagnostic::{Code, Place};
use ncfix_base::source::Span;
use ncfix_machine::snc::Origin;

macro_rules! cycles {
    ($($name:literal)*) => {
        /// Names, upper case, and texts of the cycles. Names with a leading underscore are called by other cycles only.
        const CYCLES: &[(&str, &[u8])] = &[
            $(($name, include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/cycles/sinumerik/", $name, ".spf")))),*
        ];
    };
}

cycles! {
    "CYCLE61" "CYCLE70" "CYCLE71" "CYCLE72" "CYCLE76" "CYCLE77" "CYCLE78" "CYCLE801" "CYCLE802" "CYCLE81" "CYCLE82" "CYCLE83" "CYCLE830" "CYCLE84"
    "CYCLE840" "CYCLE85" "CYCLE86" "CYCLE87" "CYCLE88" "CYCLE89" "CYCLE90" "HOLES1" "HOLES2" "LONGHOLE" "POCKET1" "POCKET2" "POCKET3" "POCKET4"
    "SLOT1" "SLOT2"
    "_CYC_ARC" "_CYC_AREA" "_CYC_BOW" "_CYC_DEPTH" "_CYC_DWELL" "_CYC_EITHER" "_CYC_FACE" "_CYC_LINE" "_CYC_MILL" "_CYC_OLD" "_CYC_OWN" "_CYC_PITCH"
    "_CYC_PLUNGE" "_CYC_POCKET" "_CYC_RING" "_CYC_SPIGOT" "_CYC_STROKE" "_CYC_TAP" "_CYC_THREAD" "_CYC_TOOL" "_CYC_WALL"
}

/// The name and text of a built-in cycle.
pub(super) fn source(name: &str) -> Option<(&'static str, &'static [u8])> {
    CYCLES.iter().find(|(known, _)| *known == name).copied()
}

/// Cycles whose strokes are not those of the control.
const MILLING: [&str; 14] = [
    "CYCLE61", "CYCLE70", "CYCLE71", "CYCLE72", "CYCLE76", "CYCLE77", "CYCLE90", "LONGHOLE", "POCKET1", "POCKET2",
    "POCKET3", "POCKET4", "SLOT1", "SLOT2",
];

/// True if a built-in cycle mills with strokes that are not those of the control.
pub(super) fn mills(name: &str) -> bool {
    MILLING.contains(&name)
}

/// Why the control's other cycles are refused: names, reason and help. A name with `*` is that of all cycles that begin so.
const REFUSED: &[(&[&str], &str, &str)] = &[
    (
        &["CYCLE60"],
        "the strokes of its letters are only in the control",
        "let the CAM system write the strokes as moves",
    ),
    (
        &["CYCLE63", "CYCLE64"],
        "the control itself finds the path inside the contours of CYCLE62, and no manual states it",
        "let the CAM system write the path as moves, or mill the contour with CYCLE72",
    ),
    (
        &["CYCLE79"],
        "it is not known whether its angle is that of a flat or of a corner, nor which digit makes _SWL an edge length",
        "write the flats out as a contour for CYCLE72",
    ),
    (
        &["CYCLE899"],
        "the circles and strokes of its roughing are only in the control",
        "write the slot as moves, or as an open contour for CYCLE72",
    ),
    (
        &[
            "CYCLE92", "CYCLE93", "CYCLE94", "CYCLE95", "CYCLE96", "CYCLE97", "CYCLE98", "CYCLE99", "CYCLE930",
            "CYCLE940", "CYCLE951", "CYCLE952",
        ],
        "it is a cycle for turning",
        "write its moves out",
    ),
    (
        &["CYCLE9*", "CYCLE1*"],
        "it measures, and its moves end where the probe touches",
        "measure in a program of its own that is not corrected",
    ),
];

/// The reason and the help for a cycle of the control that is not executed.
pub(super) fn refusal(name: &str) -> Option<(&'static str, &'static str)> {
    let fits = |known: &&str| known.strip_suffix('*').map_or(**known == *name, |start| name.starts_with(start));
    let mut rows = REFUSED.iter();
    rows.find(|(names, ..)| names.iter().any(fits)).map(|&(_, reason, help)| (reason, help))
}

/// The alarms that cycles raise with SETAL: number, message, help.
const ALARMS: &[(i64, &str, &str)] = &[
    (61000, "no tool radius is in force", "activate a cutting edge with a radius before the cycle"),
    (61001, "the lead of the thread is wrong", "give a size M3 to M48 of the table (MPIT), or the lead (PIT)"),
    (61002, "the machining type is not valid for the cycle", "check VARI, CDIR and the tens of VARI"),
    (
        61101,
        "reference plane, retraction plane and depth are inconsistent",
        "the reference plane must lie between the other two",
    ),
    (61102, "no spindle direction is given", "give 3 or 4 (after tapping also 5)"),
    (61103, "the number of positions is 0", "give at least 1"),
    (61104, "the slots overlap, or one is not a valid slot", "check radius, length, width and angles"),
    (61105, "the radius of the tool is too large", "use a smaller tool, or a larger corner radius"),
    (61107, "the first depth lies on the wrong side of the reference plane", "check FDEP and FDPR"),
];

/// The error of an alarm; number 0 is for unsupported functions, which the text names.
pub(super) fn alarm(number: i64, text: &str, span: Span) -> Fault {
    if number == 0 {
        let help = "write its moves out, or add the cycle to control.opaque of the machine file if the control is to run it itself";
        return fault(Code::NOT_SUPPORTED, span, format!("not supported yet: {text}"), help);
    }
    let known = ALARMS.iter().find(|(known, ..)| *known == number);
    let (message, help) =
        known.map_or(("the cycle cannot run with these arguments", "check its arguments"), |&(_, m, h)| (m, h));
    fault(Code::CYCLE_ALARM, span, format!("alarm {number}, {message}"), help)
}

/// A cycle call by a user program.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cycle {
    pub(super) name: &'static str,
    /// Origin of its elements: the calling block or, with MCALL, the block that moved to its position.
    pub(super) origin: Origin,
    /// Place of the call.
    pub(super) place: Place,
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::source::FileId;
    use std::collections::BTreeSet;

    #[test]
    fn every_file_is_in_the_register() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/cycles/sinumerik");
        let files: BTreeSet<String> = std::fs::read_dir(folder)
            .unwrap()
            .filter_map(|entry| entry.unwrap().file_name().to_str().unwrap().strip_suffix(".spf").map(str::to_owned))
            .collect();
        let names: BTreeSet<String> = CYCLES.iter().map(|(name, _)| (*name).to_owned()).collect();
        assert_eq!(files, names);
        assert_eq!(names.len(), CYCLES.len(), "a name is given twice");
    }

    #[test]
    fn every_cycle_is_understood_and_begins_with_what_it_does() {
        for (name, text) in CYCLES {
            let source = ncfix_base::source::Source::new(FileId(0), name, text.to_vec()).unwrap();
            let (_, findings) = crate::syntax::sinumerik::parse(&source, ncfix_dialect::sinumerik());
            let shown: Vec<_> = findings
                .iter()
                .map(|f| (f.place.map(|place| source.line_column(place.span.start)), &f.message))
                .collect();
            assert!(shown.is_empty(), "{name}: {shown:?}");
            let text = String::from_utf8(text.to_vec()).unwrap();
            assert!(text.starts_with("; "), "{name}");
            assert!(text.contains(&format!("\nPROC {name}(")), "{name}");
        }
    }
}
