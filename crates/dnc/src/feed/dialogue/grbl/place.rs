//! Grbl: compares the position that the control reports when it stands still with the position that the lines sent command.
//!
//! A report has the machine position (`MPos`) or that of the program (`WPos`). Their difference (`WCO`) is in the first report after it has changed, and in
//! every tenth or thirtieth report (Grbl 1.1, interface, "work coordinate offset"). The order of the axes is X, Y, Z, A, B, C; grblHAL states it in
//! `[AXS:4:XYZA]`.

use super::status::GrblReport;
use crate::feed::dialogue::position::{CommandedPosition, LETTERS, PositionComparison, number};

/// Number of reports in which the offset must have occurred: one in thirty has it.
const MOST_LOOKS: u32 = 31;
/// Number of reports that must differ: a digit of one may have been disturbed.
const DIFFERENT: u32 = 3;

/// Result of a report of a control that stands still.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum StandstillVerdict {
    /// Another report is necessary.
    Again,
    /// The position agrees for these axes; `None` if none can be compared.
    Done(Option<String>),
    /// The position differs: a sentence.
    Differs(String),
}

/// Commanded position, and what the reports have stated for the comparison.
#[derive(Debug, Default)]
pub(super) struct ReportedPlace {
    pub(super) commanded: CommandedPosition,
    /// Letters of the axes in their order, if the control states them.
    letters: Vec<u8>,
    /// Difference between machine and program coordinates, in the unit of the reports.
    offset: Vec<f64>,
    looks: u32,
    differing: u32,
}

/// Reads numbers with commas; `None` if one cannot be read.
pub(super) fn numbers(text: &str) -> Option<Vec<(f64, usize)>> {
    text.split(',').take(LETTERS.len()).map(number).collect()
}

impl ReportedPlace {
    /// Notes the axes from `[AXS:4:XYZA]`.
    pub(super) fn has_axes(&mut self, text: &str) {
        if let Some(letters) = text.split(':').nth(1) {
            self.letters = letters.bytes().take(LETTERS.len()).collect();
        }
    }

    /// Notes the offset of a report.
    pub(super) fn see(&mut self, status: &GrblReport<'_>) {
        if let Some(offset) = status.offset.and_then(numbers) {
            self.offset = offset.into_iter().map(|(value, _)| value).collect();
        }
    }

    /// Returns the position of the program that a report states; `None` if the offset is not known yet.
    fn axes(&self, status: &GrblReport<'_>) -> Option<Vec<(u8, f64, usize)>> {
        let (values, is_machine) = match (status.work, status.machine) {
            (Some(work), _) => (numbers(work)?, false),
            (None, Some(machine)) if !self.offset.is_empty() => (numbers(machine)?, true),
            _ => return None,
        };
        let letters = if self.letters.is_empty() { LETTERS } else { &self.letters[..] };
        let all = letters.iter().zip(values).enumerate();
        let shifted = all.map(|(slot, (&letter, (value, digits)))| {
            let offset = if is_machine { self.offset.get(slot).copied().unwrap_or(0.0) } else { 0.0 };
            (letter, value - offset, digits)
        });
        Some(shifted.collect())
    }

    /// Compares a report of a control that stands still after the last line sent.
    pub(super) fn look(&mut self, status: &GrblReport<'_>) -> StandstillVerdict {
        let is_stated = status.work.is_some() || status.machine.is_some();
        if !is_stated || !self.commanded.is_known() {
            return StandstillVerdict::Done(None);
        }
        let Some(axes) = self.axes(status) else {
            // Once it was asked for so often, the control does not state it.
            if self.looks >= MOST_LOOKS {
                return StandstillVerdict::Done(None);
            }
            self.looks += 1;
            return StandstillVerdict::Again;
        };
        match self.commanded.compare(&axes) {
            PositionComparison::Differs(why) => {
                self.differing += 1;
                if self.differing < DIFFERENT { StandstillVerdict::Again } else { StandstillVerdict::Differs(why) }
            }
            found => {
                self.differing = 0;
                StandstillVerdict::Done(if let PositionComparison::Agrees(axes) = found { Some(axes) } else { None })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn look(place: &mut ReportedPlace, text: &str) -> StandstillVerdict {
        let status = GrblReport::read(text).unwrap();
        place.see(&status);
        place.look(&status)
    }

    #[test]
    fn the_machine_position_less_the_offset_is_the_program_position() {
        let mut place = ReportedPlace::default();
        place.commanded.sent(b"G21 G90 G54");
        place.commanded.sent(b"G0 X10 Y20 Z5");
        assert_eq!(look(&mut place, "<Idle|MPos:-90.000,-30.000,-1.000|FS:0,0>"), StandstillVerdict::Again);
        let agrees = StandstillVerdict::Done(Some("XYZ".to_owned()));
        assert_eq!(look(&mut place, "<Idle|MPos:-90.000,-30.000,-1.000|FS:0,0|WCO:-100.000,-50.000,-6.000>"), agrees);
        assert_eq!(look(&mut place, "<Idle|MPos:-90.000,-30.000,-1.000|FS:0,0>"), agrees);
        assert_eq!(look(&mut place, "<Idle|WPos:10.000,20.000,5.000|FS:0,0>"), agrees);
        // Z did not move; one disturbed report proves nothing.
        let stands = "<Idle|MPos:-90.000,-30.000,-6.000|FS:0,0>";
        assert_eq!(
            [look(&mut place, stands), look(&mut place, stands)],
            [StandstillVerdict::Again, StandstillVerdict::Again]
        );
        assert!(matches!(look(&mut place, stands), StandstillVerdict::Differs(why) if why.contains("Z at 0.000")));
    }

    #[test]
    fn a_control_that_never_states_the_offset_is_asked_a_limited_number_of_times() {
        let mut place = ReportedPlace::default();
        place.commanded.sent(b"G0 X10");
        let report = "<Idle|MPos:0.000,0.000,0.000|FS:0,0>";
        assert_eq!(
            (0..MOST_LOOKS).filter(|_| look(&mut place, report) == StandstillVerdict::Again).count(),
            MOST_LOOKS as usize
        );
        assert_eq!(
            [look(&mut place, report), look(&mut place, report)],
            [StandstillVerdict::Done(None), StandstillVerdict::Done(None)]
        );
    }

    #[test]
    fn the_stated_order_of_the_axes_counts() {
        let mut place = ReportedPlace::default();
        place.has_axes("4:XYZU");
        place.commanded.sent(b"G21 G0 X1 U7");
        assert_eq!(
            look(&mut place, "<Idle|WPos:1.000,0.000,0.000,7.000>"),
            StandstillVerdict::Done(Some("XU".to_owned()))
        );
    }
}
