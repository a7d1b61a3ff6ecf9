//! `ncfix snc`: prints the flat stream of a program.
//!
//! Standard output gets each line as soon as it is known, so that a program that never ends can be looked at; a file is
//! written completely or, if there is any error, not at all.

use std::io::{self, BufWriter, Write};

use super::arguments::SncArguments;
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::machine_choice::{self, Chosen};
use super::output::{Spool, Target};
use super::program::{self, Running};
use super::stop::Stop;
use crate::geometry::{AxisVector, Vector};
use crate::snc::TextWriter;

/// Prints the stream.
pub(super) fn run(arguments: &SncArguments) -> Result<ExitCode, Stop> {
    let mut findings = Findings::default();
    let written = write(arguments, &mut findings);
    findings.draw();
    written?;
    Ok(findings.exit_code())
}

/// Opens the program and writes its stream.
fn write(arguments: &SncArguments, findings: &mut Findings) -> Result<(), Stop> {
    let source = program::read(&arguments.input)?;
    let target = arguments.output.as_deref().map(Target::new).transpose()?.unwrap_or(Target::Standard);
    let Some(chosen) = machine_choice::choose(&arguments.machine, &arguments.input, findings)? else { return Ok(()) };
    let Some(opened) = program::open(&source, &arguments.program, Some(&chosen), findings)? else { return Ok(()) };
    program::protect(&target, chosen.files.iter().chain([&arguments.input]), findings);
    if findings.has_errors() {
        return Ok(());
    }
    let mut running = Running::start(opened, &arguments.input, &arguments.program, &chosen.machine, false);
    if target == Target::Standard {
        let out = BufWriter::new(io::stdout().lock());
        return stream(out, &mut running, &chosen, findings).map_err(|error| Stop::output(&error));
    }
    let mut spool = Spool::new(target)?;
    if let Err(error) = stream(spool.writer(), &mut running, &chosen, findings) {
        return Err(spool.fault(&error));
    }
    program::protect(spool.target(), &running.files(), findings);
    if !findings.has_errors() {
        spool.publish(false)?;
    }
    Ok(())
}

/// Writes the elements and gathers the findings.
fn stream(out: impl Write, running: &mut Running, chosen: &Chosen, findings: &mut Findings) -> io::Result<()> {
    let machine = &chosen.machine;
    let turned = |command: &AxisVector, tool_mm: &Vector| machine.turned_tool_mm(command, tool_mm);
    let mut writer = TextWriter::new(out, &machine.name, machine.axis_set(), turned)?;
    while let Some(item) = running.next() {
        match item {
            Ok(element) if element.origin.calls == 0 => writer.write(&element, &[])?,
            Ok(element) => writer.write(&element, &running.call_lines(&element))?,
            Err(diagnostic) => {
                findings.add(diagnostic, running.sources());
                if findings.is_hopeless() {
                    break;
                }
            }
        }
    }
    writer.finish().map(drop)
}
