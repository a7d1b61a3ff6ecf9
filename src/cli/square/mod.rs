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
use crate::square::{SquareReadings, find};
use ncfix_path::emit::check_cut;

/// Sides of the part that the page describes if a square was measured, mm.
const SHOWN_MM: f64 = 300.0;

/// Calculates the squareness, and writes the machine file and the test square.
pub(in crate::cli) fn run(arguments: &SquareArguments) -> Result<ExitCode, Stop> {
    let numbers = [arguments.d1, arguments.d2, arguments.side, arguments.square, arguments.read_to];
    let all = numbers.into_iter().flatten().chain(arguments.sides.iter().copied());
    if let Some(wrong) = all.chain(arguments.dial.map(f64::abs)).find(|value| !value.is_finite() || *value < 0.0) {
        return Err(Stop::Usage(format!("{wrong} is not a length in mm")));
    }
    let (readings, usual) = match (arguments.d1.zip(arguments.d2), arguments.square.zip(arguments.dial)) {
        (Some((d1, d2)), _) => (SquareReadings::Diagonals([d1, d2]), 0.5),
        (None, Some((leg, dial))) => {
            (SquareReadings::Dial(leg, if arguments.plunger_negative { -dial } else { dial }), 0.005)
        }
        (None, None) => return Err(Stop::Usage("give --d1 and --d2, or --square and --dial".into())),
    };
    let sides = match (arguments.side, arguments.sides.as_slice()) {
        (Some(side), _) => [side; 2],
        (None, [a, b]) => [*a, *b],
        (None, []) => [SHOWN_MM; 2],
        _ => return Err(Stop::Usage("--sides needs two lengths in mm, such as 600,400".into())),
    };
    let mut findings = Findings::default();
    let (path, found) = machine_choice::locate(arguments.machine.machine.as_deref(), Path::new("-"));
    let source = machine_choice::source_of(path.as_deref(), found, &mut findings)?;
    let head = arguments.machine.head.as_deref();
    let chosen = machine_choice::read_head(&source, &arguments.machine.setup, head, &mut findings)?;
    findings.draw();
    let Some(chosen) = chosen else { return Ok(findings.exit_code()) };
    let read_to = arguments.read_to.unwrap_or(usual);
    let mut result = find(&chosen, arguments.plane.plane(), readings, sides, read_to)?;
    let mut together = AtomicWrites::default();
    let mut goes_out = false;
    if let Some(output) = &arguments.output {
        let text = result.written(&String::from_utf8_lossy(source.bytes()), arguments.add)?;
        let target = Target::new(output)?;
        goes_out |= !target.is_file();
        together.add(target, text.as_bytes())?;
    }
    if let Some(output) = &arguments.check_cut {
        let target = Target::new(output)?;
        goes_out |= !target.is_file();
        together.add(target, &check_cut(&chosen.machine, sides).map_err(Stop::Usage)?)?;
    }
    together.publish()?;
    if goes_out {
        tell(&result.page)
    } else {
        print(&result.page)?
    }
    Ok(findings.exit_code())
}
