//! Readings of targets as those of one error component at a time, and the questions about what a file leaves open.

use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_machine::machine::{Branch, Machine};

use super::checks::check_runs;
use super::facts::{StatedFacts, TargetReading};
use crate::answers::MeasuredComponent;
use crate::inquiry::{ImportStop, Inquiry};
use crate::readings::{ImportedKind, ImportedReadings, ImportedRow, shown};
use crate::signs::SignMeaning;
use crate::unit::ReadingUnit;

/// Asks for everything else that a table of readings leaves open if it cannot be read on: all questions come in one round.
pub(super) fn rest(inquiry: &mut Inquiry<'_>, facts: &StatedFacts) -> ImportStop {
    let component = inquiry.answers().component.or(facts.component.map(|(component, _)| component));
    let axis = component.map(|one| one.axis).or(inquiry.answers().axis).or(facts.axis.map(|(axis, _)| axis));
    let is_angle = component.is_some_and(MeasuredComponent::is_angle);
    if axis.is_none() {
        inquiry.ask("axis", "the file does not state the axis that moved", "its letter, such as X");
    }
    if let (None, Some(line)) = (component, facts.other_quantity) {
        let sentence =
            format!("line {line} mentions a straightness or an angle, and the file does not name its component");
        inquiry.ask("component", sentence, "the error, such as EXX for positioning or EYX for a straightness");
    }
    if inquiry.answers().sign.is_none() && facts.sign.is_none() {
        inquiry.ask(
            "sign",
            "the file does not state the sign of its readings",
            "+ if the tool is then too far in the positive direction as seen from the workpiece (angles: turned by the right-hand rule), else -",
        );
    }
    if inquiry.answers().unit.is_none() && facts.unit.is_none() {
        let choices = format!("one of {}", ReadingUnit::choices(is_angle));
        inquiry.ask("unit", "the file does not state the unit of its readings", choices);
    }
    match axis {
        Some(axis) => _ = inquiry.other_positions(&[axis]),
        None if inquiry.answers().at.is_empty() => {
            let sentence = "the file does not state the positions of the axes that did not move";
            inquiry.ask("at", sentence, "all of them, in machine coordinates, such as Y200,Z100");
        }
        None => {}
    }
    if !is_angle {
        inquiry.tool();
        // A contradiction is reported when the readings can be read.
        _ = inquiry.scale_material();
    }
    ImportStop::Asks
}

/// Sense of the moving body for readings of the tool relative to the workpiece.
///
/// # Errors
/// If the axis is not parallel to the direction in F.
fn body_sense(inquiry: &Inquiry<'_>, machine: &Machine, component: MeasuredComponent) -> Result<f64, ImportStop> {
    let Some(axis) = machine.axis(component.axis) else {
        let message = format!("the machine has no axis {}", char::from(component.axis.letter()));
        return Err(inquiry.refused(message, "check --axis and --machine", 0));
    };
    let is_on_table = machine.topology.branch(component.axis) == Some(Branch::Workpiece);
    if !component.is_positioning() {
        return Ok(if is_on_table { -1.0 } else { 1.0 });
    }
    let share = axis.direction[component.direction % 3];
    if share.abs() < 0.999 {
        let message = format!(
            "{} is not parallel to an axis of F, so its positioning error is no single component",
            char::from(component.axis.letter())
        );
        return Err(inquiry.refused(message, "enter the readings as a displacement", 0));
    }
    Ok(share.signum())
}

/// The measured component by option and by a line of the file.
///
/// # Errors
/// If the two are different, or if another line of the file mentions a straightness or an angle beside a positioning.
fn with_file(
    inquiry: &Inquiry<'_>,
    said: Option<MeasuredComponent>,
    facts: &StatedFacts,
) -> Result<Option<MeasuredComponent>, ImportStop> {
    let Some((stated, line)) = facts.component else { return Ok(said) };
    if let Some(said) = said.filter(|said| *said != stated) {
        let message = format!("--component {said} contradicts the file, which names {stated}");
        return Err(inquiry.refused(message, "correct the option, or the file", line));
    }
    match facts.other_quantity.filter(|_| stated.is_positioning() && said.is_none()) {
        Some(other) => {
            let message = format!(
                "the file names {stated}, which is a positioning, and line {other} mentions a straightness, an angle or another component"
            );
            Err(inquiry.refused(message, format!("give --component {stated}, or correct the file"), line))
        }
        None => Ok(Some(stated)),
    }
}

/// Turns readings into those of one error component at a time.
pub(in crate::format) fn direct(
    inquiry: &mut Inquiry<'_>,
    found: Vec<TargetReading>,
    facts: StatedFacts,
) -> Result<ImportedReadings, ImportStop> {
    let named = found.iter().find_map(|reading| reading.component);
    let said = inquiry.answer("component", |own| own.component);
    let said_axis = inquiry.answer("axis", |own| own.axis);
    let said = with_file(inquiry, said, &facts)?;
    let component = match (said, named, said_axis, facts.axis) {
        (Some(component), None, axis, stated) => {
            if axis.is_some_and(|axis| axis != component.axis) {
                return Err(inquiry.refused(
                    match facts.component {
                        Some(_) => format!("--axis contradicts the file, which names the component {component}"),
                        None => format!("--axis and --component {component} name different axes"),
                    },
                    if facts.component.is_some() { "remove --axis, or correct the file" } else { "give one of them" },
                    0,
                ));
            }
            if let Some((_, line)) = stated.filter(|(axis, _)| *axis != component.axis) {
                let by = if facts.component.is_some() { "the component" } else { "--component" };
                let message = format!("{by} {component} contradicts the file, which names another axis");
                return Err(inquiry.refused(message, "correct the option, or the file", line));
            }
            match facts.component {
                Some((_, line)) => inquiry.note(format!("measured error: {component}"), line),
                None => inquiry.note(format!("measured error: --component {component}"), 0),
            }
            component
        }
        (said, Some(component), axis, _) => {
            let is_other = |own: MeasuredComponent| said.is_some_and(|said| said != own);
            if found.iter().filter_map(|reading| reading.component).any(is_other)
                || axis.is_some_and(|axis| axis != component.axis)
            {
                if let Some((stated, line)) = facts.component {
                    let message = format!("a line names the component {stated}, and the headings name {component}");
                    return Err(inquiry.refused(message, "correct the file", line));
                }
                let option = if said.is_some() { "component" } else { "axis" };
                let message = format!("--{option} contradicts the headings, which name {component}");
                return Err(inquiry.refused(message, format!("remove --{option}, or correct the headings"), 0));
            }
            inquiry.note("measured errors: named by the headings", 0);
            component
        }
        (None, None, said, stated) => {
            let Some(axis) = said.or(stated.map(|(axis, _)| axis)) else {
                return Err(rest(inquiry, &facts));
            };
            match stated {
                Some((stated, line)) if stated != axis => {
                    let message = format!("--axis {} contradicts the file", char::from(axis.letter()));
                    return Err(inquiry.refused(message, "correct the option, or the file", line));
                }
                Some((_, line)) if said.is_none() => inquiry.note(format!("axis: {}", char::from(axis.letter())), line),
                _ => inquiry.note(format!("axis: --axis {}", char::from(axis.letter())), 0),
            }
            if let Some(line) = facts.other_quantity {
                let sentence = format!(
                    "line {line} mentions a straightness or an angle, and the file does not name its component"
                );
                inquiry.ask(
                    "component",
                    sentence,
                    format!(
                        "the error, such as E{0}{0} for positioning or E{1}{0} for a straightness",
                        char::from(axis.letter()),
                        // A direction across the axis.
                        if axis.letter() == b'Y' { 'X' } else { 'Y' }
                    ),
                );
                // Sign, point and temperature are asked for in the words of the component.
                return Err(ImportStop::Asks);
            } else {
                inquiry.note(
                    format!(
                        "measured error: positioning of {} (use --component for others)",
                        char::from(axis.letter())
                    ),
                    0,
                );
            }
            MeasuredComponent::positioning(axis)
        }
    };
    let machine = inquiry.machine;
    body_sense(inquiry, machine, component)?;
    let axis = component.axis;
    let target_unit = match facts.target_unit {
        Some((unit, line)) if unit.is_angle() != axis.is_rotary() => {
            let message = format!(
                "the targets are in {}, which is no unit of the positions of {}",
                unit.sign(),
                char::from(axis.letter())
            );
            return Err(inquiry.refused(message, "check --axis and the columns", line));
        }
        Some((unit, line)) => {
            inquiry.note(format!("unit of the targets: {}", unit.sign()), line);
            unit
        }
        None if axis.is_rotary() => ReadingUnit::Angle("deg", std::f64::consts::PI / 180.0),
        None => ReadingUnit::Length("mm", 1.0),
    };
    if facts.target_unit.is_none() {
        inquiry.note(
            format!("unit of the targets: {} is assumed; all targets are within the travel", target_unit.sign()),
            0,
        );
    }
    let largest = found.iter().map(|reading| reading.value.abs()).fold(0.0, f64::max);
    let unit = inquiry.unit(facts.unit, component.is_angle(), largest)?;
    check_runs(inquiry, &found, unit)?;
    if facts.target_unit.is_none() && unit == ReadingUnit::Length("inch", 25.4) {
        let sentence = "the readings are in inches, and the file does not state the unit of the targets";
        inquiry.ask("columns", sentence, "the meaning of each column with the unit, such as target [inch],1+,1-");
    }
    let letter = char::from(axis.letter());
    let question = if component.is_positioning() {
        format!(
            "the file does not state the sign of its readings: does a positive reading mean that {letter} is too far in the positive direction?"
        )
    } else if component.is_angle() {
        format!(
            "the file does not state the sign of its readings: is the tool turned about +{} (right-hand rule), seen from the workpiece, where a reading is positive?",
            ['X', 'Y', 'Z'][component.direction % 3]
        )
    } else {
        format!(
            "the file does not state the sign of its readings: is the tool too far in +{}, seen from the workpiece, where a reading is positive?",
            component.letter()
        )
    };
    let is_difference =
        component.is_positioning() && found.iter().all(|one| one.component.is_none_or(|own| own.is_positioning()));
    let meaning = if is_difference { SignMeaning::Difference } else { SignMeaning::Direction };
    let sign = inquiry.sign(facts.sign, &question, meaning)?;
    let tool = if component.is_angle()
        && found.iter().all(|reading| reading.component.is_none_or(MeasuredComponent::is_angle))
        && inquiry.answers().tool.is_none()
    {
        ncfix_base::geometry::Vector::zeros()
    } else {
        inquiry.tool()
    };
    let is_length = component.is_positioning() && !component.is_angle();
    let stretch = if is_length { inquiry.scale_material()?.stretch() } else { 0.0 };
    let position =
        |target: f64| if axis.is_rotary() { target_unit.inner(target).to_degrees() } else { target_unit.inner(target) };
    let zero = inquiry.given(axis).unwrap_or(0.0);
    if inquiry.given(axis).is_some() {
        inquiry.note(format!("target 0 of the file is {letter} {zero} of the machine (--at)"), 0);
    } else {
        inquiry.note("targets are machine coordinates", 0);
    }
    let span = found
        .iter()
        .map(|reading| position(reading.target))
        .fold([f64::MAX, f64::MIN], |[low, high], at| [low.min(at), high.max(at)]);
    if found.len() > 2 && span[1] - span[0] < 1.0 {
        let message = format!("the targets span only {}: the columns may be swapped", shown(span[1] - span[0]));
        return Err(inquiry.refused(
            message,
            "name the columns with --columns",
            facts.target_unit.map_or(0, |(_, line)| line),
        ));
    }
    let columns: Vec<&'static str> = match found
        .iter()
        .map(|reading| reading.component.unwrap_or(component).is_angle())
        .fold((false, false), |(lengths, angles), is_angle| (lengths || !is_angle, angles || is_angle))
    {
        (true, true) => vec!["value_um", "value_urad"],
        (false, true) => vec!["value_urad"],
        _ => vec!["value_um"],
    };
    let mut out = ImportedReadings::new(ImportedKind::Direct, vec![axis], columns);
    out.fixed = inquiry.other_positions(&[axis]);
    out.tool_mm = [tool[0], tool[1], tool[2]];
    out.sigma = inquiry.answer("sigma", |own| own.sigma);
    let is_across = |one: MeasuredComponent| !one.is_angle() && !one.is_positioning() && !one.axis.is_rotary();
    if found.iter().any(|reading| is_across(reading.component.unwrap_or(component))) {
        out.is_square = inquiry.answer("reference", |own| own.is_square).unwrap_or(false);
    }
    if found.iter().all(|reading| reading.sense.is_none()) {
        let note = "direction of approach: from the order of the rows; an end target that is read twice is the turn";
        inquiry.note(note, 0);
    }
    let mut worst: Option<(f64, f64, MeasuredComponent)> = None;
    for reading in found {
        let own = reading.component.unwrap_or(component);
        if own.axis != axis {
            return Err(inquiry.refused(
                format!("{own} and {component} are errors of different axes"),
                "import them from a file for each axis",
                reading.line,
            ));
        }
        let is_angle = own.is_angle();
        // A table with lengths and angles has each column in its own unit.
        let Some(own_unit) = reading.unit.or((unit.is_angle() == is_angle).then_some(unit)) else {
            let message = format!("the heading of {own} states no unit, and {} does not fit it", unit.sign());
            return Err(inquiry.refused(message, "write the units into the headings, such as EBX [arcsec]", 0));
        };
        if own_unit.is_angle() != is_angle {
            let message = format!("{} is not a unit of {own}", own_unit.sign());
            return Err(inquiry.refused(message, "correct the heading", 0));
        }
        let at = position(reading.target);
        let mut fine = sign * own_unit.fine(reading.value);
        if own.is_positioning() && !is_angle {
            fine -= um_from_mm(stretch * at);
        }
        if worst.is_none_or(|(most, _, _): (f64, _, _)| fine.abs() > most.abs()) {
            worst = Some((fine, at + zero, own));
        }
        let value = Some(fine * body_sense(inquiry, machine, own)?);
        let values = if out.value_columns.len() == 1 {
            vec![value]
        } else if is_angle {
            vec![None, value]
        } else {
            vec![value, None]
        };
        out.rows.push(ImportedRow {
            run: reading.run,
            position: vec![at + zero],
            sense: reading.sense,
            label: own.to_string(),
            values,
            line: reading.line,
            ..ImportedRow::default()
        });
    }
    if let Some((fine, at, own)) = worst {
        out.sign_sentence = sentence(fine, at, own);
    }
    Ok(out)
}

/// Describes a reading so that a person can check its sign.
fn sentence(fine: f64, at: f64, component: MeasuredComponent) -> String {
    let place = format!("at {} {} ", char::from(component.axis.letter()), shown(at));
    let size = format!("{:.1}", fine.abs());
    let mark = if fine < 0.0 { '-' } else { '+' };
    if component.is_positioning() {
        let unit = if component.is_angle() {
            format!("{size} µrad ({:.1}\")", fine.abs() / urad_from_rad(std::f64::consts::PI / 648_000.0))
        } else {
            format!("{size} µm")
        };
        let how = if fine < 0.0 { "less" } else { "more" };
        return format!("{place}the true position is {unit} {how} than commanded ({mark})");
    }
    let letter = ['X', 'Y', 'Z'][component.direction % 3];
    if component.is_angle() {
        format!(
            "{place}the tool is turned by {size} µrad about {mark}{letter} (right-hand rule), seen from the workpiece"
        )
    } else {
        format!("{place}the tool is {size} µm too far in {mark}{letter}, seen from the workpiece")
    }
}
