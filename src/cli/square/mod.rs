//! `ncfix square`: squareness of two axes from two diagonals, or from a square and a dial gauge.

pub(in crate::cli) mod arguments;

use std::path::Path;

use crate::cli::arguments::SquareArguments;
use crate::cli::atomic_writes::AtomicWrites;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::output::Target;
use crate::cli::stop::Stop;
use crate::cli::{machine_choice, print, tell};
use crate::next_line;
use crate::square::{PartSides, SquareReadings, find};
use ncfix_path::emit::check_cut;

/// Calculates the squareness, and writes the machine file and the test square.
pub(in crate::cli) fn run(arguments: &SquareArguments) -> Result<ExitCode, Stop> {
    let numbers = [arguments.d1, arguments.d2, arguments.side, arguments.square, arguments.read_to];
    let all = numbers.into_iter().flatten().chain(arguments.sides.iter().chain(&arguments.nominal).copied());
    if let Some(wrong) = all.chain(arguments.dial.map(f64::abs)).find(|value| !value.is_finite() || *value < 0.0) {
        return Err(Stop::Usage(format!("{wrong} is not a length in mm")));
    }
    let (diagonals, dial) = (arguments.d1.zip(arguments.d2), arguments.square.zip(arguments.dial));
    let (readings, usual) = SquareReadings::of(diagonals, dial, arguments.plunger_negative)?;
    let part = PartSides::of(arguments.side, &arguments.sides, &arguments.nominal)?;
    let mut findings = Findings::default();
    let (path, found) = machine_choice::locate(arguments.machine.machine.as_deref(), Path::new("-"));
    let source = machine_choice::source_of(path.as_deref(), found, &mut findings)?;
    let head = arguments.machine.head.as_deref();
    let chosen = machine_choice::read_head(&source, &arguments.machine.setup, head, &mut findings)?;
    findings.draw();
    let Some(chosen) = chosen else { return Ok(findings.exit_code()) };
    let read_to = arguments.read_to.unwrap_or(usual);
    let mut result = find(&chosen, arguments.plane.plane(), readings, &part, read_to)?;
    let mut together = AtomicWrites::default();
    let mut goes_out = false;
    if let Some(output) = &arguments.output {
        let text = result.written(&chosen, &String::from_utf8_lossy(source.bytes()), arguments.add)?;
        let target = Target::new(output)?;
        target.must_be_machine_file()?;
        goes_out |= !target.is_file();
        together.add(target, text.as_bytes())?;
    }
    if let Some(output) = &arguments.check_cut {
        let target = Target::new(output)?;
        goes_out |= !target.is_file();
        together.add(target, &check_cut(&chosen.machine, part.nominal_mm).map_err(Stop::Usage)?)?;
    }
    together.publish()?;
    if goes_out {
        tell(&result.page)
    } else {
        print(&result.page)?;
    }
    if let Some(output) = &arguments.output {
        tell(&next_line::after_square(output, &chosen, &result));
    }
    Ok(findings.exit_code())
}
