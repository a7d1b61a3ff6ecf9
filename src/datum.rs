//! The datum of a job: the zero offsets that a program uses, the method by which each was set, and the error of the machine that a touched one contains.

use std::collections::BTreeSet;
use std::str::FromStr;

use crate::diagnostics::Diagnostics;
use crate::error::Error;
use crate::machine::Machine;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, Vector};
use ncfix_base::units::um_from_mm;
use ncfix_machine::machine::condition::Condition;
use ncfix_machine::machine::{Datum, TouchedAt, ZeroSetting};
use ncfix_model::Model;
use ncfix_report::json::ZeroReport;

/// A statement about a zero offset on the command line: `G54=touched@X330,Y240,Z120`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StatedZero {
    /// Name of the zero offset.
    name: String,
    setting: ZeroSetting,
    /// Axis positions of the touch, machine coordinates, for the stated axes.
    at: Option<(AxisSet, AxisVector)>,
}

impl FromStr for StatedZero {
    type Err = String;

    /// Reads `G54=touched`, `G54=absolute` or `G54=probed@X330,Y240,Z120`.
    fn from_str(text: &str) -> Result<StatedZero, String> {
        let wrong = || format!("'{text}' is not a zero; write for example G54=touched or G54=touched@X330,Y240,Z120");
        let (name, rest) = text.split_once('=').ok_or_else(wrong)?;
        let (setting, place) = rest.split_once('@').map_or((rest, None), |(setting, place)| (setting, Some(place)));
        let setting = ZeroSetting::of_name(setting.trim()).ok_or_else(wrong)?;
        let of_place = |place: &str| {
            let command: AxisVector = place.parse().map_err(|_| wrong())?;
            let letters = place.split(',').filter_map(|part| part.trim().bytes().next());
            let stated = letters.filter_map(|letter| Axis::from_letter(letter.to_ascii_uppercase())).collect();
            Ok::<_, String>((stated, command))
        };
        let at = place.map(of_place).transpose()?;
        Ok(StatedZero { name: name.trim().to_ascii_uppercase(), setting, at })
    }
}

/// Notes statements about zero offsets in the machine; they override its file.
///
/// # Errors
/// If a zero offset has no value there.
pub(crate) fn state(zeros: &[StatedZero], chosen: &mut Machine) -> Result<(), Error> {
    for StatedZero { name, setting, at } in zeros {
        if !chosen.machine.zero_offsets.contains_key(name) {
            return Err(Error::usage(format!("--zero {name}: this zero offset has no value in the machine file")));
        }
        let datum = chosen.machine.datums.entry(name.clone()).or_default();
        datum.setting = Some(*setting);
        if let Some((stated, command)) = *at {
            let tool_length_mm = datum.at[0].tool_length_mm;
            datum.at = [TouchedAt { stated, command, tool_length_mm }; 3];
        }
    }
    Ok(())
}

/// A model of the machine with the errors that its zero offsets contain.
pub(crate) fn with_zeros(chosen: &Machine, model: Model) -> Model {
    let machine = &chosen.machine;
    if machine.zero_offsets.is_empty() || model.is_empty() {
        return model;
    }
    let earlier = chosen.condition.zero().map(|_| {
        let then = chosen.condition.when_zeroed();
        Model::at(machine, &chosen.errors, &then)
    });
    let then = earlier.as_ref().unwrap_or(&model);
    // Nobody knows how warm the machine was at a touch that no file states: drift counts from the reference condition.
    let reference = Model::at(machine, &chosen.errors, &Condition::default());
    let datums = machine.zero_offsets.iter().map(|(name, zero)| {
        let datum = machine.datums.get(name).copied().unwrap_or_default();
        let is_assumed = datum.setting.is_none() && earlier.is_none();
        let then = if is_assumed { &reference } else { then };
        let touch_mm = then.displacement_at(&[0, 1, 2].map(|side| datum.pose(side, zero, machine)));
        let touch_mm = if touch_mm.iter().all(|mm| mm.is_finite()) { touch_mm } else { Vector::zeros() };
        (touch_mm, is_relative(&datum))
    });
    let (touches_mm, relative): (Vec<Vector>, Vec<bool>) = datums.unzip();
    model.with_zeros(&touches_mm, &relative)
}

/// True if errors are relative to the touched position.
fn is_relative(datum: &Datum) -> bool {
    datum.method().is_relative()
}

/// The zero offsets of these indices, with a warning for those without a stated method if it matters by more than
/// `tolerance_mm`.
pub(crate) fn of_run(
    chosen: &Machine,
    model: &Model,
    used: &BTreeSet<u16>,
    tolerance_mm: f64,
    found: &mut Diagnostics,
) -> Vec<ZeroReport> {
    let machine = &chosen.machine;
    let all = machine.zero_offsets.keys().zip(0_u16..).filter(|(_, index)| used.contains(index));
    let reports = all.map(|(name, index)| {
        let datum = machine.datums.get(name).copied().unwrap_or_default();
        let contains_mm = model.touch_mm(index);
        ZeroReport {
            name: name.clone(),
            set: datum.method().name(),
            is_stated: datum.setting.is_some(),
            contains_um: [0, 1, 2].map(|axis| um_from_mm(contains_mm[axis])),
            distance_um: um_from_mm(contains_mm.norm()),
        }
    });
    let reports: Vec<ZeroReport> = reports.collect();
    let is_doubtful = |one: &&ZeroReport| !one.is_stated && one.distance_um > um_from_mm(tolerance_mm);
    // On the demo machine no workpiece was touched off.
    for one in reports.iter().filter(is_doubtful).filter(|_| !chosen.is_demo) {
        let name = &one.name;
        let message = format!("{name} counts as touched, because no method is stated; {}", one.contents());
        let help = format!(
            "state it: set = \"touched\" or \"absolute\" in [zero_offset.{name}], or --zero {name}=touched or {name}=absolute"
        );
        found.add(Diagnostic::nowhere(Code::ZERO_NOT_STATED, message, help), &[]);
    }
    reports
}

/// The zero offsets that count as touched, for the stamp: `G54-touched`; `unstated-touched` stands for all without a statement.
pub(crate) fn stamped(chosen: &Machine) -> Option<String> {
    let machine = &chosen.machine;
    let stated = |name: &String| machine.datums.get(name).and_then(|datum| datum.setting);
    let relative = machine.zero_offsets.keys().filter_map(|name| Some((name, stated(name)?)));
    let relative = relative.filter(|(_, setting)| setting.is_relative());
    let mut parts: Vec<String> =
        relative.map(|(name, setting)| format!("{}-{}", name.replace(' ', "_"), setting.name())).collect();
    if machine.zero_offsets.keys().any(|name| stated(name).is_none()) {
        parts.push(format!("unstated-{}", Datum::default().method().name()));
    }
    (!parts.is_empty()).then(|| parts.join(","))
}
