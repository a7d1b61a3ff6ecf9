//! `ncfix machine presets`: sets of parameters of an error model, and their values in a machine file.

use std::path::Path;

use crate::cli::arguments::PresetArguments;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::stop::Stop;
use crate::cli::{machine_choice, print};
use crate::machine::Machine;
use ncfix_model::preset::{find, unknown};
use ncfix_report::presets::{list, page};

/// Lists the presets, or shows one of them on a machine.
pub(super) fn run(arguments: &PresetArguments) -> Result<ExitCode, Stop> {
    let preset = match &arguments.name {
        None => None,
        Some(name) => Some(find(name).ok_or_else(|| Stop::Usage(unknown(name)))?),
    };
    if preset.is_none() && arguments.machine.machine.is_none() {
        print(&list(None))?;
        return Ok(ExitCode::Done);
    }
    let mut findings = Findings::default();
    // No program has a folder to search for a machine file.
    let chosen = machine_choice::choose(&arguments.machine, Path::new("-"), &mut findings)?;
    findings.draw();
    let Some(chosen) = chosen else { return Ok(findings.exit_code()) };
    match preset {
        None => print(&list(Some(&chosen.machine)))?,
        Some(preset) => {
            let parameters = (preset.parameters)(&chosen.machine).map_err(|reason| {
                let name = &chosen.machine.name;
                Stop::Usage(format!("preset {} is not applicable to the machine {name}: {reason}", preset.name))
            })?;
            let after = arguments.after.as_ref().map(Machine::from_file).transpose()?;
            let after = after.as_ref().map(|machine| &machine.errors);
            print(&page(preset, &parameters, &chosen.machine, &chosen.errors, after))?;
        }
    }
    Ok(findings.exit_code())
}
