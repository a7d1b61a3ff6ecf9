//! Trial of a machine file: corrects and verifies a program of lines through the whole travel, like any program of a
//! user.

use std::fmt::Write as _;

use crate::error::Error;
use crate::machine::Machine;
use crate::options::{DialectChoice, Options};
use crate::program::Program;
use crate::tool::ToolVector;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{AXES, Axis, AxisVector};
use ncfix_base::source::Source;
use ncfix_metrology::results::diagnosis::{DiagnosisResult, TravelSizes};
use ncfix_metrology::results::extended::Extended;
use ncfix_path::path::volume;

/// Share of the travel of an axis that the lines use: corrected ends stay within its limits.
const USED: f64 = 0.99;
/// Largest correction in a trial, mm. Errors found by readings are not refused for their size alone; the largest of
/// them is a millimeter.
const MAX_CORRECTION_MM: f64 = 2.0;
/// Feed of the lines, mm/min.
const FEED_MM_MIN: u32 = 1000;

/// Corrects and verifies lines through the travel with the longest tool of a machine. `None` if no axis has limits.
///
/// # Errors
/// All diagnostics that refuse the program.
pub(crate) fn try_travel(machine: &Machine) -> Result<Option<TravelSizes>, Error> {
    let Some(text) = program(machine) else { return Ok(None) };
    let original = Program::parse("travel.ngc", text, DialectChoice::Rs274)?;
    let options = Options { max_correction_mm: MAX_CORRECTION_MM, ..Options::default() };
    let corrected = Program::parse("corrected.ngc", original.correct(machine, &options).text()?, DialectChoice::Rs274)?;
    let report = original.verify(&corrected, machine)?;
    Ok(report.before.zip(report.after).map(|(before, after)| TravelSizes {
        before_rms_um: before.rms_um,
        before_max_um: before.max_um,
        after_rms_um: after.rms_um,
        after_max_um: after.max_um,
    }))
}

/// Tries the text of an extended machine file, and notes the errors along the travel in the result of the diagnosis.
/// If the lines are refused, the file must not be written; a diagnostic states the reason. A file that needs no change is
/// not written either, which is no error.
pub(crate) fn tried(
    made: Extended,
    old: Option<&Source>,
    result: &mut DiagnosisResult,
    found: &mut Vec<Diagnostic>,
) -> Option<String> {
    if result.needs_no_change() {
        return None;
    }
    let text = made.text(found)?;
    // A file that only completes others is not a machine by itself.
    let Ok(machine) = Machine::from_text("extended machine file", &text) else { return Some(text) };
    match try_travel(&machine) {
        Ok(sizes) => {
            if let Some(written) = &mut result.written {
                written.travel = sizes;
            }
            Some(text)
        }
        // Such lines are not possible on this machine, even with its old file.
        Err(_) if !old.is_some_and(|old| is_possible(&String::from_utf8_lossy(old.bytes()))) => Some(text),
        Err(error) => {
            let reason = error.to_string();
            let reason = reason.lines().next().unwrap_or_default();
            let message =
                format!("with the extended machine file, a program through the whole travel is refused: {reason}");
            let help = "nothing was written; measure in smaller steps where the cause changes, or state the term with calibrate --model";
            found.push(Diagnostic::nowhere(Code::NOT_TOLD, message, help));
            None
        }
    }
}

/// `true` if the lines can be corrected on a machine.
fn is_possible(text: &str) -> bool {
    Machine::from_text("machine file", text).is_ok_and(|machine| try_travel(&machine).is_ok())
}

/// The program, in machine coordinates.
fn program(machine: &Machine) -> Option<String> {
    let own = &machine.machine;
    let longest = own.tools.iter().max_by(|a, b| a.length_mm[0].abs().total_cmp(&b.length_mm[0].abs()));
    let length_mm = longest.map_or(0.0, |tool| tool.length_mm[0].abs());
    let lines = volume(own, &ToolVector::Length(length_mm).vector_mm(own));
    let first = lines.first()?;
    let mut text = "G21 G90 G94 G17 G40 G49 G80\n".to_owned();
    if let Some(tool) = longest.filter(|tool| tool.number > 0) {
        let _ = writeln!(text, "T{0} M6\nG43 H{0}", tool.number);
    }
    let _ = writeln!(text, "F{FEED_MM_MIN}\nG53 G0{}", words(machine, first.start()));
    for line in &lines {
        let _ = writeln!(text, "G53 G0{}\nG53 G1{}", words(machine, line.start()), words(machine, line.end()));
    }
    text += "M2\n";
    Some(text)
}

/// The words of all axes at a position.
fn words(machine: &Machine, position: &AxisVector) -> String {
    let of = |axis: Axis| {
        let data = machine.machine.axis(axis)?;
        let at = data.travel.map_or(position[axis], |[low, high]| {
            let middle = f64::midpoint(low, high);
            middle + USED * (position[axis] - middle)
        });
        Some(format!(" {axis}{:.4}", if axis.is_rotary() { at.to_degrees() } else { at }))
    };
    AXES.into_iter().filter_map(of).collect()
}
