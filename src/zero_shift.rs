//! Drift of a machine as a shift of the zero offsets, if it is the same wherever a program cuts.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::diagnostics::Diagnostics;
use crate::error::Error;
use crate::machine::Machine;
use crate::program::Program;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{AXES, Axis, AxisVector, LINEAR_AXES, Vector};
use ncfix_base::number::significant;
use ncfix_base::units::{shown_position, um_from_mm};
use ncfix_language::exec;
use ncfix_machine::machine::State;
use ncfix_machine::machine::condition::Condition;
use ncfix_machine::saved::zero_shift::shifted_zeros;
use ncfix_machine::snc::{Element, Kind};
use ncfix_model::{Model, Solve};
use ncfix_path::emit::stamped_state;

/// Maximum number of executed elements: a program may have no end.
const MOST_ELEMENTS: usize = 10_000_000;
/// Number of places along the range of an axis in which the program cuts.
const PLACES: usize = 5;
/// Maximum number of places in total.
const MOST_PLACES: usize = 100_000;

/// The shift of the zero offsets of a program.
pub(crate) struct ZeroShift {
    /// Page for people.
    pub(crate) page: String,
    /// The text for the control.
    pub(crate) text: String,
}

/// The part of the machine in which a program cuts.
struct CutVolume {
    zeros: Vec<String>,
    ranges: Vec<(Axis, [f64; 2])>,
    tools_mm: [Vector; 2],
}

/// The shift of the zero offsets in which a program cuts: minus the drift of the machine since these zeros were set, or since the reference condition.
/// It is refused if the drift differs by more than `tolerance_mm` between two places from the mean of their extremes. `variables` is the variable file of
/// a LinuxCNC, which is rewritten.
///
/// # Errors
/// If the program cannot be shifted as a whole, or no condition is given.
pub(crate) fn find(
    program: &Program,
    chosen: &Machine,
    tolerance_mm: f64,
    variables: Option<&str>,
    found: &mut Diagnostics,
) -> Result<Option<ZeroShift>, Error> {
    if !chosen.condition.has_temperatures() && chosen.condition.loads().is_empty() {
        return Err(Error::usage("--zero-shift needs the temperatures: give --state".into()));
    }
    if let Some(state) = stamped_state(program.bytes()) {
        return Err(Error::usage(format!(
            "the program was corrected for the state {state} and contains a drift already: give the original, or one that was corrected without --state"
        )));
    }
    chosen.check_one_head()?;
    let Some(volume) = cut_volume(program, chosen, found)? else { return Ok(None) };
    let reference = chosen.condition.zero().map_or_else(Condition::default, |_| chosen.condition.when_zeroed());
    let models = [&chosen.condition, &reference].map(|one| Model::at(&chosen.machine, &chosen.errors, one));
    let Some(drift) = volume.drift(&models) else {
        return Err(Error::usage("the drift has no correction at some place of the program".into()));
    };
    let [low, high] = drift;
    let middle = AxisVector(AXES.map(|axis| f64::midpoint(low[axis], high[axis])));
    let half = |axis: Axis| (high[axis] - low[axis]) / 2.0;
    let varies_mm = LINEAR_AXES.into_iter().map(half).fold(0.0, f64::hypot);
    let volume_text = volume.text();
    if varies_mm > tolerance_mm {
        let most = LINEAR_AXES.into_iter().max_by(|a, b| half(*a).total_cmp(&half(*b))).unwrap_or(Axis::X);
        let message = format!(
            "the drift is not the same over the part: it varies by ± {} µm over {volume_text}, most along {most} (± {} µm)",
            significant(um_from_mm(varies_mm)),
            significant(um_from_mm(half(most)))
        );
        let help = "correct the program for this --state instead (-o OUT); or allow it with a larger --tolerance";
        found.add(Diagnostic::nowhere(Code::DRIFT_VARIES, message, help), &[]);
        return Ok(None);
    }
    let step_mm = chosen.machine.control.increment_mm;
    let shift = AxisVector(AXES.map(|axis| (middle[axis] / step_mm).round() * step_mm));
    let shifts: BTreeMap<String, AxisVector> = volume.zeros.iter().map(|name| (name.clone(), shift)).collect();
    let words: Vec<String> = LINEAR_AXES
        .into_iter()
        .filter(|axis| chosen.machine.axis(*axis).is_some())
        .map(|axis| format!("{axis}{:+.4}", shift[axis]))
        .collect();
    let shown: Vec<String> = volume.zeros.iter().map(|name| chosen.machine.shown_offset(name)).collect();
    let mut page = String::new();
    let mut row = |name: &str, text: String| _ = writeln!(page, "{name:<12}{text}");
    row("zero shift", format!("{} mm, added to {}", words.join(" "), shown.join(", ")));
    row("varies", format!("± {} µm over {volume_text}", significant(um_from_mm(varies_mm))));
    row("valid", "for this state only; the shift replaces an earlier one, so start from the offsets without it".into());
    let notes = [
        format!("ncfix {}: drift of {}, state {}", env!("CARGO_PKG_VERSION"), chosen.machine.name, state_of(chosen)),
        format!("shift {} mm is included; make the next shift from the offsets without it", words.join(" ")),
    ];
    let text = shifted_zeros(&chosen.machine, &shifts, &notes, variables).map_err(Error::usage)?;
    Ok(Some(ZeroShift { page, text }))
}

fn state_of(chosen: &Machine) -> &str {
    chosen.state.as_deref().unwrap_or_default()
}

/// The volume in which a program cuts; `None` if there are errors.
fn cut_volume(program: &Program, chosen: &Machine, found: &mut Diagnostics) -> Result<Option<CutVolume>, Error> {
    let Some(opened) = program.open(Some(chosen), found)?.filter(|_| !found.has_errors()) else { return Ok(None) };
    let mut running = program.start_as(opened, &chosen.machine, exec::Options::default());
    let (mut count, mut is_assumed) = (0, false);
    while let Some(element) = running.next() {
        count += 1;
        match element {
            Ok(_) if count > MOST_ELEMENTS => return Err(Error::usage("the program has no end".into())),
            Ok(element) => {
                if let Kind::Setup(setup) = &element.kind {
                    is_assumed = setup.assumed;
                }
                let is_unknown = is_assumed && matches!(&element.kind, Kind::Move(one) if !one.rapid);
                let unknown = is_unknown.then_some("the zero offset or the tool has no value where the program cuts");
                if let Some(why) = unknown.or(obstacle(&element)) {
                    return Err(Error::usage(format!("{why}; correct the program for this --state instead")));
                }
            }
            Err(diagnostic) => {
                found.add(diagnostic, running.sources());
            }
        }
    }
    if found.has_errors() {
        return Ok(None);
    }
    let extent = running.extent();
    let names: Vec<&String> = chosen.machine.zero_offsets.keys().collect();
    let zeros: Option<Vec<String>> =
        extent.zeros().iter().map(|index| names.get(usize::from(*index)).map(|&name| name.clone())).collect();
    let (Some(zeros), Some(tools_mm)) = (zeros.filter(|zeros| !zeros.is_empty()), extent.tools_mm()) else {
        return Err(Error::usage(
            "the program cuts in no zero offset of the machine file, so nothing can be shifted".into(),
        ));
    };
    if let Some((_, axes)) = extent.unknown() {
        let axes: Vec<String> = axes.iter().map(|axis| axis.to_string()).collect();
        return Err(Error::usage(format!("the position of {} is not known where the program cuts", axes.join(", "))));
    }
    Ok(Some(CutVolume { zeros, ranges: extent.axes().collect(), tools_mm }))
}

/// The reason why a shift of the zero offset does not shift all moves in the same way.
fn obstacle(element: &Element) -> Option<&'static str> {
    match &element.kind {
        Kind::Setup(setup) if setup.transform.is_some() => Some("a transformation of five axes turns the zero offset"),
        Kind::Setup(setup) if setup.written_zero.is_some() => Some("the program sets its zero offset itself"),
        Kind::Move(one) if one.tip.is_some() => Some("a transformation of five axes turns the zero offset"),
        Kind::Move(one) if !one.rapid && one.in_machine_frame => Some("the program cuts in machine coordinates"),
        _ => None,
    }
}

impl CutVolume {
    /// `X0 .. 300, Y-20 .. 80`, mm and deg.
    fn text(&self) -> String {
        let shown = |axis: Axis, value: f64| (shown_position(axis.is_rotary(), value) * 10.0).round() / 10.0 + 0.0;
        let range = |(axis, [low, high]): &(Axis, [f64; 2])| {
            if low == high {
                format!("{axis}{}", shown(*axis, *low))
            } else {
                format!("{axis}{} .. {}", shown(*axis, *low), shown(*axis, *high))
            }
        };
        self.ranges.iter().map(range).collect::<Vec<_>>().join(", ")
    }

    /// Lowest and highest change of the correction of each axis between two conditions, mm; `None` if the tip cannot be placed.
    fn drift(&self, [now, then]: &[Model; 2]) -> Option<[AxisVector; 2]> {
        let mut low = AxisVector([f64::INFINITY; AXES.len()]);
        let mut high = AxisVector([f64::NEG_INFINITY; AXES.len()]);
        let counts: Vec<usize> =
            self.ranges.iter().map(|(_, [low, high])| if low == high { 1 } else { PLACES }).collect();
        let places = counts.iter().try_fold(1_usize, |all, count| all.checked_mul(*count))?.min(MOST_PLACES);
        let state = State::default();
        for index in 0..places {
            let mut rest = index;
            let mut pose = AxisVector::default();
            for ((axis, [low, high]), count) in self.ranges.iter().zip(&counts) {
                let place = rest % count;
                rest /= count;
                pose[*axis] = low + (high - low) * place as f64 / (count - 1).max(1) as f64;
            }
            for tool_mm in &self.tools_mm {
                let solve = |model: &Model| model.solve(&pose, tool_mm, &state, &pose, Solve::PositionOnly).ok();
                let change = solve(now)? - solve(then)?;
                for axis in LINEAR_AXES {
                    low[axis] = low[axis].min(change[axis]);
                    high[axis] = high[axis].max(change[axis]);
                }
            }
        }
        Some([low, high])
    }
}
