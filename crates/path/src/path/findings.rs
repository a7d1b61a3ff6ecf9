//! Diagnostics of the correction: positions outside the travel, corrections that are too large or do not exist.
//!
//! Each kind once per source line, at most a hundred.

use std::collections::HashSet;

use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{AXES, Axis, AxisSet, Vector};
use ncfix_base::source::FileId;
use ncfix_machine::machine::{Kinematics, Machine};
use ncfix_machine::snc::Origin;
use ncfix_model::NotConverged;

use super::route::Route;

/// Maximum number of diagnostics.
const MOST_FINDINGS: usize = 100;
/// Maximum number of lines that are reported because they exceed the tolerance: they leave no place for errors otherwise.
const MOST_MISSED: usize = 50;
/// Tolerance within which a command counts as on its limit: rounding noise, mm or rad.
pub(super) const ON_LIMIT: f64 = 1e-9;

/// Collects diagnostics.
#[derive(Debug)]
pub(super) struct DiagnosticCollector<'a> {
    machine: &'a Machine,
    kinematics: Kinematics,
    max_correction_mm: f64,
    reported: HashSet<(FileId, u32, Code)>,
    new: Vec<Diagnostic>,
    /// Lines in which the output exceeds the tolerance.
    missed: HashSet<(FileId, u32)>,
    /// True after an error of the program: a block was not executed, so a difference from its positions is not a correction.
    has_missed_a_block: bool,
    /// Axes whose unknown direction was reported.
    unsensed: AxisSet,
}

impl<'a> DiagnosticCollector<'a> {
    pub(super) fn new(machine: &'a Machine, max_correction_mm: f64) -> DiagnosticCollector<'a> {
        DiagnosticCollector {
            machine,
            kinematics: Kinematics::new(machine),
            max_correction_mm,
            reported: HashSet::new(),
            new: Vec::new(),
            missed: HashSet::new(),
            has_missed_a_block: false,
            unsensed: AxisSet::EMPTY,
        }
    }

    /// Notes an error of the program.
    pub(super) fn distrust_positions(&mut self) {
        self.has_missed_a_block = true;
    }

    /// Changes the head.
    pub(super) fn set_head(&mut self, head: u16) {
        self.kinematics.set_head(self.machine, head);
    }

    /// Takes the new diagnostics.
    pub(super) fn take(&mut self) -> impl Iterator<Item = Diagnostic> + '_ {
        self.new.drain(..)
    }

    /// `true` if there are no new diagnostics.
    pub(super) fn is_empty(&self) -> bool {
        self.new.is_empty()
    }

    /// Checks travel and correction of a piece along `emitted`, which ends at this parameter of the programmed move.
    pub(super) fn check(
        &mut self,
        origin: &Origin,
        known: AxisSet,
        (whole, parameter): (&Route<'_>, f64),
        emitted: &Route<'_>,
        tool_mm: &Vector,
    ) {
        let machine = self.machine;
        let nominal = &whole.at(parameter);
        let mut is_outside = false;
        let excess_mm = emitted.excess_mm();
        for data in machine.axes.iter().flatten().filter(|data| known.contains(data.axis)) {
            let end = emitted.end[data.axis];
            let is_far_inside = |[low, high]: &[f64; 2]| {
                let (least, most) = (end.min(emitted.start[data.axis]), end.max(emitted.start[data.axis]));
                emitted.is_of_tip() && !data.axis.is_rotary() && least - excess_mm >= *low && most + excess_mm <= *high
            };
            if let Some([low, high]) = data.travel.filter(|travel| !is_far_inside(travel)) {
                let [least, most] = span_of(emitted, data.axis);
                // The end of the whole move, corrected if this is its last piece.
                let whole_end = if parameter >= 1.0 { end } else { whole.end[data.axis] };
                // Ranges, so that NaN is outside.
                let is_below = |position: f64| !(low - ON_LIMIT..).contains(&position);
                if is_below(least) {
                    is_outside = true;
                    let on_the_way = [span_of(whole, data.axis)[0], least];
                    let (position, is_end) = place_outside(whole_end, on_the_way, is_below);
                    self.out_of_travel(origin, data.axis, position, is_end, ("below", low));
                }
                let is_above = |position: f64| !(..=high + ON_LIMIT).contains(&position);
                if is_above(most) {
                    is_outside = true;
                    let on_the_way = [span_of(whole, data.axis)[1], most];
                    let (position, is_end) = place_outside(whole_end, on_the_way, is_above);
                    self.out_of_travel(origin, data.axis, position, is_end, ("above", high));
                }
            }
            let correction = end - nominal[data.axis];
            let at_tip_mm = if data.axis.is_rotary() && correction != 0.0 {
                self.kinematics.arc_mm(data.axis, (nominal, end), tool_mm)
            } else {
                correction
            };
            // Beyond the travel the errors are extrapolated, and their size says nothing about the machine.
            let can_judge = !is_outside && !self.has_missed_a_block;
            if can_judge && !(..=self.max_correction_mm).contains(&at_tip_mm.abs()) {
                let message = format!(
                    "the correction of {} is {} at the tool, more than {}",
                    data.axis,
                    micrometers(at_tip_mm),
                    micrometers(self.max_correction_mm)
                );
                let help = "check the units in the machine file before raising --max-correction";
                self.report(origin, Code::CORRECTION_TOO_LARGE, message, help.into());
            }
        }
    }

    /// Reports content that output in machine coordinates cannot express: an axis at an unknown position, or a thread whose lead belongs to an axis
    /// of the frame.
    pub(super) fn in_machine_frame(&mut self, origin: &Origin, unknown: Option<Axis>, is_turned_thread: bool) {
        if let Some(axis) = unknown {
            let message = format!("the frame moves {axis}, but the program has not yet stated the position of {axis}");
            let help = "begin with a block that names X, Y and Z, or do not use --frame machine";
            self.report(origin, Code::UNKNOWN_START, message, help.into());
        }
        if is_turned_thread {
            let message = "a thread in a rotated, scaled or mirrored frame cannot be written with --frame machine";
            let help = "do not use --frame machine: the lead belongs to an axis of the frame";
            self.report(origin, Code::NOT_SUPPORTED, message.into(), help.into());
        }
    }

    /// Reports data computed from the position of an axis that is not known here.
    pub(super) fn here_unknown(&mut self, origin: &Origin, words: &str, axis: Axis) {
        let message = format!("{words} uses the position of {axis}, which is not known here");
        let help = "let the program move the axis to an absolute position before it; if a probe ended the move, measure in a program of its own, which is not corrected";
        self.report(origin, Code::UNKNOWN_START, message, help.into());
    }

    /// Reports data computed from the position under a transformation, where that position is not one of the axes.
    pub(super) fn here_in_transform(&mut self, origin: &Origin, words: &str) {
        let message = format!("{words} while a transformation of the axes is in force");
        self.report(origin, Code::NOT_SUPPORTED, message, "end the transformation before it".into());
    }

    pub(super) fn not_converged(&mut self, origin: &Origin, failure: NotConverged) {
        let message = if failure.residual_mm.is_finite() {
            format!("no correction was found here; the residual is {}", micrometers(failure.residual_mm))
        } else {
            "no correction was found here: the errors of the machine file have no finite value".into()
        };
        let help = "check the error model: a coefficient in a wrong unit is the usual reason; then check that the machine can move the tool in all directions";
        self.report(origin, Code::NOT_CONVERGED, message, help.into());
    }

    /// Reports a piece that exceeds the tolerance.
    pub(super) fn tolerance_missed(&mut self, origin: &Origin, is_cut: bool, deviation_mm: f64, tolerance_mm: f64) {
        if !is_cut {
            let message = format!(
                "this move must stay in one piece and is up to {} off the path, more than {}",
                micrometers(deviation_mm),
                micrometers(tolerance_mm)
            );
            let help = "program it in several blocks where the control allows it, or allow a larger --tolerance";
            self.report(origin, Code::ONE_PIECE, message, help.into());
        } else if self.missed.len() < MOST_MISSED && self.missed.insert((origin.file, origin.line)) {
            let message = format!(
                "the output is {} off the exact path here, and cannot stay within {}",
                micrometers(deviation_mm),
                micrometers(tolerance_mm)
            );
            let help = "correct it again with a larger --tolerance, or with a finer increment that the control reads; verify may refuse it as it is";
            let place = Place { file: origin.file, span: origin.span };
            self.new.push(Diagnostic::at(Code::TOLERANCE_NOT_REACHED, place, message, help));
        }
    }

    /// Reports, once for each axis, an unknown direction of approach.
    pub(super) fn sense_unknown(&mut self, origin: &Origin, axis: Axis, half_mm: f64) {
        if self.unsensed.contains(axis) {
            return;
        }
        self.unsensed.insert(axis);
        let message = format!(
            "the direction in which {axis} reached this position is unknown: its backlash can cause an error of up to {}",
            micrometers(half_mm)
        );
        let help = format!(
            "let the program move {axis} by more than that before it cuts; without a tool change before the cut, --start helps as well"
        );
        // One for each axis, even in the same line.
        let place = Place { file: origin.file, span: origin.span };
        self.new.push(Diagnostic::at(Code::SENSE_UNKNOWN, place, message, help));
    }

    /// Reports a feed that would refer to the path of the correction.
    pub(super) fn feed_of_another_way(&mut self, origin: &Origin) {
        let message =
            "rotary axes turn here, and with the correction the feed would apply to X, Y, Z instead".to_owned();
        let help = "the rotary axes would turn at their maximum speed, and this program cannot state the time of a block here (G93): turn the axes at rapid, or with a feed in G94 on a control that has G93";
        self.report(origin, Code::FEED_OF_ANOTHER_WAY, message, help.into());
    }

    /// Reports a feed of tip and rotary axes together that cannot be expressed in axis coordinates.
    pub(super) fn feed_of_turns(&mut self, origin: &Origin) {
        let message = "the feed includes rotary axes (FGROUP), under a transformation that the output does not contain"
            .to_owned();
        let help = "do not use --five-axis axes, or remove the rotary axes from FGROUP".into();
        self.report(origin, Code::FEED_OF_ANOTHER_WAY, message, help);
    }

    fn out_of_travel(&mut self, origin: &Origin, axis: Axis, position: f64, is_end: bool, (side, limit): (&str, f64)) {
        let unit = if axis.is_rotary() { "deg" } else { "mm" };
        let shown = |value: f64| ncfix_base::units::shown_position(axis.is_rotary(), value);
        let (position, limit) = (shown(position), shown(limit));
        let message = if is_end {
            format!("{axis} {position:.4} {unit} is {side} the limit of {limit} {unit}")
        } else {
            format!("during this move {axis} reaches {position:.4} {unit}, {side} the limit of {limit} {unit}")
        };
        let help = format!(
            "the position is that of the axis in machine coordinates, not of the tool tip; check zero offset and tool length (machine file or --setup), or axis.{axis}.travel_{unit} in the machine file"
        );
        self.report(origin, Code::OUT_OF_TRAVEL, message, help);
    }

    fn report(&mut self, origin: &Origin, code: Code, message: String, help: String) {
        let key = (origin.file, origin.line, code);
        if self.reported.len() < MOST_FINDINGS && self.reported.insert(key) {
            let place = Place { file: origin.file, span: origin.span };
            self.new.push(Diagnostic::at(code, place, message, help));
        }
    }
}

/// Smallest and largest position of an axis at the end of a path and at its turning points.
fn span_of(way: &Route<'_>, axis: Axis) -> [f64; 2] {
    let end = way.end[axis];
    let (mut least, mut most) = (end, end);
    if way.arc().is_some() || way.is_of_tip() && !(axis.is_rotary() && way.turns_in_proportion()) {
        let mut at = 0.0;
        loop {
            at = way.next_turning([axis].into_iter().collect(), at);
            if at >= 1.0 {
                break;
            }
            let turning = way.at(at)[axis];
            (least, most) = (least.min(turning), most.max(turning));
        }
    }
    [least, most]
}

/// The position to report for a move that leaves the travel: the programmed end if it is outside. Otherwise the farthest one on the path, programmed
/// if that is outside, or corrected. True for the end.
fn place_outside(end: f64, on_the_way: [f64; 2], is_outside: impl Fn(f64) -> bool) -> (f64, bool) {
    if is_outside(end) {
        return (end, true);
    }
    let [programmed, corrected] = on_the_way;
    (if is_outside(programmed) { programmed } else { corrected }, false)
}

/// Formats a length for a message.
fn micrometers(mm: f64) -> String {
    let um = mm * 1e3;
    if um.abs() < 1.0 { format!("{um:.3} µm") } else { format!("{um:.1} µm") }
}

/// The linear axes that position the tip: X Y Z, and U V W if the machine lacks the primary letter.
pub(super) fn placing_axes(machine: &Machine) -> AxisSet {
    let of_dimension =
        |dimension| AXES.into_iter().filter(move |axis| !axis.is_rotary() && axis.dimension() == dimension);
    (0..3).filter_map(|dimension| of_dimension(dimension).find(|&axis| machine.axis(axis).is_some())).collect()
}
