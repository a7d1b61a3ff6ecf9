//! `ncfix machine check` and `ncfix machine show`: one machine file on its own, and its errors at a pose.

use std::path::Path;

use super::arguments::{MachineArguments, MachineCommand, ShowArguments};
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::machine_choice::{self, Chosen, Found};
use super::state;
use super::stop::Stop;
use super::value::ToolVector;
use super::{presets, print, tell};
use crate::disk::origin;
use ncfix_base::geometry::{AXES, AxisVector, Vector};
use ncfix_base::source::Source;
use ncfix_machine::machine::AxisData;
use ncfix_report::json;
use ncfix_report::machine::table;
use ncfix_report::shares::Shares;

/// Checks or shows a machine file, or what its error model may have.
pub(super) fn run(command: &MachineCommand) -> Result<ExitCode, Stop> {
    match command {
        MachineCommand::Check(arguments) => check(arguments),
        MachineCommand::Show(arguments) => show(arguments),
        MachineCommand::Presets(arguments) => presets::run(arguments),
    }
}

fn check(arguments: &MachineArguments) -> Result<ExitCode, Stop> {
    let mut findings = Findings::default();
    read(arguments, &mut findings)?;
    findings.draw();
    tell(&format!("{}: {}\n", name(arguments), findings.count()));
    Ok(findings.exit_code())
}

fn show(arguments: &ShowArguments) -> Result<ExitCode, Stop> {
    if arguments.json && !arguments.origin && arguments.at.is_none() {
        return Err(Stop::Usage(
            "--json shows the errors at a pose or the origin of values: give --at or --origin".into(),
        ));
    }
    let mut findings = Findings::default();
    let mut chosen = read(&arguments.file, &mut findings)?;
    if arguments.origin {
        return show_origin(arguments, chosen.is_some(), &findings);
    }
    if let Some(found) = &mut chosen
        && arguments.at.is_some()
        && !state::apply(&arguments.state, found, &mut findings)?
    {
        chosen = None;
    }
    if let (Some(chosen), Some(at)) = (&chosen, arguments.at) {
        check_pose(chosen, &at)?;
    } else if arguments.at.is_none() && (!arguments.state.state.is_empty() || arguments.state.load.is_some()) {
        return Err(Stop::Usage("--state and --load say something at a pose only: give --at".into()));
    }
    let shares = chosen.as_ref().zip(arguments.at).map(|(chosen, at)| shares(chosen, at, arguments));
    if let (Some(mut shares), true) = (shares.clone(), arguments.json) {
        shares.diagnostics = findings.json();
        print(&json::line(&shares).map_err(Stop::Usage)?)?;
        return Ok(findings.exit_code());
    }
    findings.draw();
    match (chosen, shares) {
        (_, Some(shares)) => print(&shares.table())?,
        (Some(chosen), None) => print(&table(&chosen.machine, &chosen.errors))?,
        (None, None) => tell(&format!("{}: {}\n", name(&arguments.file), findings.count())),
    }
    Ok(findings.exit_code())
}

/// Refuses a pose that the machine cannot take.
fn check_pose(chosen: &Chosen, at: &AxisVector) -> Result<(), Stop> {
    const ROOM: f64 = 1e-9;
    for axis in AXES {
        let shown = |value: f64| if axis.is_rotary() { value.to_degrees() } else { value };
        match chosen.machine.axis(axis) {
            None if at[axis] != 0.0 => return Err(Stop::Usage(format!("--at: the machine has no axis {axis}"))),
            Some(AxisData { travel: Some([low, high]), .. }) if !(low - ROOM..=high + ROOM).contains(&at[axis]) => {
                let [at, low, high] = [at[axis], *low, *high].map(shown);
                return Err(Stop::Usage(format!("--at: {axis} {at} is outside the travel from {low} to {high}")));
            }
            _ => {}
        }
    }
    Ok(())
}

/// What each source does to the tool at a pose.
fn shares(chosen: &Chosen, at: AxisVector, arguments: &ShowArguments) -> Shares {
    let machine = &chosen.machine;
    let tool_mm = match arguments.tool {
        Some(ToolVector::Tip(tip_mm)) => tip_mm,
        Some(ToolVector::Length(length_mm)) => -machine.spindle.axis * length_mm,
        None => Vector::zeros(),
    };
    Shares::new(machine, &chosen.errors, &chosen.condition, &at, &tool_mm, &arguments.sense.unwrap_or_default())
}

/// Shows where the values of a machine come from.
fn show_origin(arguments: &ShowArguments, is_sound: bool, findings: &Findings) -> Result<ExitCode, Stop> {
    findings.draw();
    if !is_sound {
        tell(&format!("{}: {}\n", name(&arguments.file), findings.count()));
        return Ok(findings.exit_code());
    }
    let (source, found) = locate(&arguments.file, &mut Findings::default())?;
    let origins = origin::origins(&source, found, &arguments.file.setup)?;
    print(&if arguments.json { json::line(&origins).map_err(Stop::Usage)? } else { origins.table() })?;
    Ok(findings.exit_code())
}

/// What the machine is called in a sentence.
fn name(arguments: &MachineArguments) -> String {
    arguments.file.as_ref().map_or_else(|| "the machine file".to_owned(), |file| file.display().to_string())
}

/// The text of the machine file, and how it was found.
fn locate(arguments: &MachineArguments, findings: &mut Findings) -> Result<(Source, Found), Stop> {
    let (path, found) = match &arguments.file {
        Some(file) => (Some(file.clone()), Found::Named),
        // There is no program beside which a machine file could lie.
        None => machine_choice::locate(None, Path::new("-")),
    };
    Ok((machine_choice::source_of(path.as_deref(), found, findings)?, found))
}

/// Reads the machine file with its set-up files.
fn read(arguments: &MachineArguments, findings: &mut Findings) -> Result<Option<Chosen>, Stop> {
    let (source, _) = locate(arguments, findings)?;
    Ok(machine_choice::read(&source, &arguments.setup, findings)?)
}
