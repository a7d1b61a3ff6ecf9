//! `ncfix snc`: prints the flat stream of a program.
//!
//! Standard output gets each line as soon as it is known, so that a program that never ends can be looked at; a file is
//! written completely or, if there is any error, not at all.

use std::io::{self, BufWriter, Write};

use crate::cli::arguments::SncArguments;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::machine_choice::{self, Chosen};
use crate::cli::output::{Old, Spool, Target};
use crate::cli::program::{self, Running};
use crate::cli::stop::Stop;
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{AxisVector, Vector};
use ncfix_base::source::{Source, Span};
use ncfix_language::exec::RapidOrder;
use ncfix_machine::snc::{TextReader, TextWriter};

/// The start of a file that is a flat stream already.
const HEAD: &str = "; snc 1";

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
    let source = program::read(&arguments.input)?;
    let Some(chosen) = machine_choice::choose(&arguments.machine, &arguments.input, findings)? else { return Ok(()) };
    if source.bytes().starts_with(HEAD.as_bytes()) {
        return print_again(&source, target, &chosen, findings);
    }
    let Some(opened) = program::open(&source, &arguments.program, Some(&chosen), findings)? else { return Ok(()) };
    program::protect(&target, chosen.files.iter().chain([&arguments.input]), findings);
    if findings.has_errors() {
        return Ok(());
    }
    let mut running =
        program::start(opened, &arguments.input, &arguments.program, &chosen.machine, false, RapidOrder::All);
    let start = arguments.program.start;
    if target == Target::Standard {
        let out = BufWriter::new(io::stdout().lock());
        stream(out, &mut running, &chosen, start, findings).map_err(|error| Stop::output(&error))?;
        say_whether_it_moves(&source, &running, findings);
        return Ok(());
    }
    let mut spool = Spool::new(target)?;
    if let Err(error) = stream(spool.writer(), &mut running, &chosen, start, findings) {
        return Err(spool.fault(&error));
    }
    say_whether_it_moves(&source, &running, findings);
    program::protect(spool.target(), &running.files(), findings);
    if !findings.has_errors() {
        spool.publish(Old::Replaced)?;
    }
    Ok(())
}

/// Points at a program that was executed and moves nothing.
fn say_whether_it_moves(source: &Source, running: &Running, findings: &mut Findings) {
    if !running.moves() && !findings.has_errors() {
        findings.add(program::without_motion(source, Code::MOVES_NOTHING), running.sources());
    }
}

/// Reads a flat stream in its text form and prints it again.
fn print_again(source: &Source, target: Target, chosen: &Chosen, findings: &mut Findings) -> Result<(), Stop> {
    let text = String::from_utf8_lossy(source.bytes());
    let mut reader = TextReader::new(&text);
    let machine = &chosen.machine;
    // Positions are those of the tip already, so there is no tool to add.
    let mut writer = TextWriter::new(Vec::new(), &machine.name, machine.axis_set(), |_, tool| *tool)
        .map_err(|error| Stop::output(&error))?;
    while let Some(item) = reader.next() {
        match item {
            Ok(element) => {
                let lines = reader.call_lines().to_vec();
                writer.write(&element, &lines).map_err(|error| Stop::output(&error))?;
            }
            Err(fault) => {
                let start = text.split_inclusive('\n').take(fault.line - 1).map(str::len).sum();
                let place = Place { file: source.id(), span: Span::new(start, start + 1) };
                let help = "correct the line, or print the stream again from its program";
                findings
                    .add(Diagnostic::at(Code::UNEXPECTED, place, fault.message, help), std::slice::from_ref(source));
            }
        }
    }
    if findings.has_errors() {
        return Ok(());
    }
    let bytes = writer.finish().map_err(|error| Stop::output(&error))?;
    if target == Target::Standard {
        return super::print(&String::from_utf8_lossy(&bytes));
    }
    let mut spool = Spool::new(target)?;
    if let Err(error) = spool.writer().write_all(&bytes) {
        return Err(spool.fault(&error));
    }
    spool.publish(Old::Replaced).map(drop)
}

/// Writes the elements and gathers the findings.
fn stream(
    out: impl Write,
    running: &mut Running,
    chosen: &Chosen,
    start: Option<AxisVector>,
    findings: &mut Findings,
) -> io::Result<()> {
    let machine = &chosen.machine;
    let turned = |command: &AxisVector, tool_mm: &Vector| machine.turned_tool_mm(command, tool_mm);
    let mut writer = TextWriter::new(out, &machine.name, machine.axis_set(), turned)?;
    if let Some(start) = start {
        writer.start_at(start);
    }
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
