//! `ncfix snc`: prints the flat stream of a program.
//!
//! Standard output gets each line as soon as it is known, so that a program with an endless loop can be examined; a file is
//! written completely or, if there is any error, not at all.

use std::io::{self, BufWriter};

use crate::cli::arguments::SncArguments;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::output::{Old, Spool, Target};
use crate::cli::stop::Stop;
use crate::cli::{machine_choice, print, program, progress};
use crate::disk::stated_machine::is_flat;
use crate::moves::{self, FlatText};

/// Prints the stream.
pub(in crate::cli) fn run(arguments: &SncArguments) -> Result<ExitCode, Stop> {
    let mut findings = Findings::default();
    let written = write(arguments, &mut findings);
    findings.draw();
    written?;
    Ok(findings.exit_code())
}

/// Opens the program and writes its stream.
fn write(arguments: &SncArguments, findings: &mut Findings) -> Result<(), Stop> {
    let target = arguments.output.as_deref().map(Target::new).transpose()?.unwrap_or(Target::Standard);
    let part = program::of(&arguments.input, &arguments.program)?;
    let found = machine_choice::choose(&arguments.machine, part.search(&arguments.input), findings)?;
    let Some(machine) = found else { return Ok(()) };
    if is_flat(part.bytes()) {
        let Some(text) = moves::written_again(&part, &machine, findings) else { return Ok(()) };
        if target == Target::Standard {
            return print(&String::from_utf8_lossy(&text));
        }
        let mut spool = Spool::new(target)?;
        spool.writer().write_all(&text).map_err(|error| spool.fault(&error))?;
        return Ok(spool.publish(Old::Replaced).map(drop)?);
    }
    let Some(flat) = FlatText::of(&part, &machine, Some(progress::watch), findings)? else { return Ok(()) };
    program::protect(&target, machine.files.iter().chain([&arguments.input]), findings);
    if findings.has_errors() {
        return Ok(());
    }
    if target == Target::Standard {
        let out = BufWriter::new(io::stdout().lock());
        flat.write(out, findings).map_err(|error| Stop::output(&error))?;
        return Ok(());
    }
    let mut spool = Spool::new(target)?;
    let read = flat.write(spool.writer(), findings).map_err(|error| spool.fault(&error))?;
    program::protect(spool.target(), &read, findings);
    if !findings.has_errors() {
        spool.publish(Old::Replaced)?;
    }
    Ok(())
}
