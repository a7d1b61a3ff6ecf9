//! `ncfix fix`: the whole way from a program to its corrected text.

use std::collections::BTreeMap;
use std::time::Instant;

use super::arguments::{ArcChoice, FiveAxisChoice, FixArguments, FrameChoice, RapidChoice, RotaryChoice};
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::input::is_standard_stream;
use super::machine_choice::{self, Chosen};
use super::output::{Spool, Target};
use super::program::{self, Opened, Running};
use super::state;
use super::stop::Stop;
use super::{print, tell};
use crate::diagnostic::{Code, Diagnostic, Place};
use crate::emit;
use crate::exec::RapidOrder;
use crate::geometry::AXES;
use crate::path::{self, Corrector, Increments, Prediction};
use crate::report::correction::Correction;
use crate::report::json;
use crate::source::{Source, Span};
use crate::units::{um_from_mm, urad_from_rad};

/// Distance of the samples of the predicted error along the path, mm.
const SAMPLE_MM: f64 = 1.0;

/// Corrects a program.
pub(super) fn run(arguments: &FixArguments) -> Result<ExitCode, Stop> {
    let started = Instant::now();
    let job = Job::new(arguments)?;
    let mut findings = Findings::default();
    let mut report = Correction::default();
    if let Err(stop) = job.correct(&mut findings, &mut report) {
        findings.draw();
        return Err(stop);
    }
    report.seconds = started.elapsed().as_secs_f64();
    if arguments.json {
        report.diagnostics = findings.json();
        print(&json::line(&report).map_err(Stop::Usage)?)?;
    } else {
        findings.draw();
        if findings.has_errors() {
            tell(&format!("{}; nothing was written\n", findings.count()));
        } else {
            tell(&report.table());
        }
    }
    Ok(findings.exit_code())
}

/// One program and where its correction goes.
struct Job<'a> {
    arguments: &'a FixArguments,
    source: Source,
    target: Target,
    /// The target as the user named it.
    target_name: String,
}

impl<'a> Job<'a> {
    /// Reads the program and looks at the target, before any work is done.
    fn new(arguments: &'a FixArguments) -> Result<Job<'a>, Stop> {
        let output = arguments.output.as_ref().unwrap_or(&arguments.input);
        if arguments.in_place && is_standard_stream(&arguments.input) {
            return Err(Stop::Usage("--in-place needs a file, not standard input".into()));
        }
        if arguments.json && is_standard_stream(output) {
            return Err(Stop::Usage("--json and the program cannot both go to standard output; give -o a file".into()));
        }
        let source = program::read(&arguments.input)?;
        let target = Target::new(output)?;
        Ok(Job { arguments, source, target, target_name: output.display().to_string() })
    }

    /// Reads the machine, corrects, and publishes the text if there is no error.
    fn correct(&self, findings: &mut Findings, report: &mut Correction) -> Result<(), Stop> {
        let arguments = self.arguments;
        let Some(mut chosen) = machine_choice::choose(&arguments.machine, &arguments.input, findings)? else {
            return Ok(());
        };
        if !state::apply(&arguments.state, &mut chosen, findings)? {
            return Ok(());
        }
        report.machine.clone_from(&chosen.machine.name);
        if emit::is_stamped(self.source.bytes()) {
            findings.add(corrected_before(&self.source), std::slice::from_ref(&self.source));
            return Ok(());
        }
        let own = (!arguments.in_place).then_some(&arguments.input);
        program::protect(&self.target, chosen.files.iter().chain(own), findings);
        if let Some(increment_mm) = arguments.increment {
            chosen.machine.control.increment_mm = increment_mm;
        }
        let opened = program::open(&self.source, &arguments.program, Some(&chosen), findings)?;
        let Some(opened) = opened.filter(|_| !findings.has_errors()) else { return Ok(()) };
        let mut spool = Spool::new(self.target.clone())?;
        self.write(opened, &chosen, &mut spool, findings, report)?;
        if findings.has_errors() {
            // Numbers of an output that does not exist would be taken for its numbers.
            *report = Correction { machine: std::mem::take(&mut report.machine), ..Correction::default() };
            return Ok(());
        }
        if let Some(backup) = spool.publish(arguments.in_place)? {
            report.backup = Some(backup.display().to_string());
        }
        report.output = Some(self.target_name.clone());
        Ok(())
    }

    /// Executes, corrects and writes. Behind the first error nothing more is written, but all findings are gathered.
    fn write(
        &self,
        opened: Opened,
        chosen: &Chosen,
        spool: &mut Spool,
        findings: &mut Findings,
        report: &mut Correction,
    ) -> Result<(), Stop> {
        let arguments = self.arguments;
        let machine = &chosen.machine;
        let model = chosen.model();
        let dialect = opened.dialect.name;
        let entry = emit::entry(dialect)
            .ok_or_else(|| Stop::Usage(format!("programs in the dialect '{dialect}' cannot be written")))?;
        let options = path::Options { turns: entry.turns, ..options(arguments) };
        if options.frame == path::OutputFrame::Machine && !entry.has_machine_frame {
            return Err(Stop::Usage(format!(
                "in the dialect '{dialect}' not every motion can be written in machine coordinates; leave out --frame machine \
                 and --five-axis axes"
            )));
        }
        let writer_options = emit::WriterOptions {
            names: machine.written_names(),
            increments: Increments::new(&machine.control),
            frame: options.frame,
            crlf: has_crlf(self.source.bytes()),
            last_block_number: machine.control.last_block_number,
            stamp: emit::Stamp {
                machine: machine.name.clone(),
                model: chosen.hash.clone(),
                state: chosen.state.clone(),
                source: machine_choice::short_hash([self.source.bytes()]),
                is_demo: chosen.is_demo,
            },
        };
        let mut writer = (entry.create)(&writer_options)
            .ok_or_else(|| Stop::Usage(format!("programs in the dialect '{dialect}' cannot be written")))?;
        let running = Running::start(opened, &arguments.input, &arguments.program, machine, true, RapidOrder::All);
        let mut corrector = Corrector::new(running, machine, &model, options);
        // Findings are few: the execution and the corrector both stop after a hundred.
        let mut found = Vec::new();
        let written = emit::emit(&mut corrector, writer.as_mut(), spool.writer(), |finding| found.push(finding));
        report.blocks_out = written.map_err(|error| spool.fault(&error))?;
        let running = corrector.elements();
        findings.extend(found, running.sources());
        program::protect(&self.target, &running.files(), findings);
        let sources = running.sources();
        for stamped in sources.iter().skip(1).filter(|source| emit::is_stamped(source.bytes())) {
            findings.add(corrected_before(stamped), sources);
        }
        note(corrector.prediction(), running, report);
        let rotary = rotary(arguments);
        let left = path::remaining(machine, &chosen.errors, &chosen.condition, corrector.poses(), rotary);
        report.remaining = left.iter().map(remaining).collect();
        Ok(())
    }
}

/// Whether the lines of a program end with CR LF.
fn has_crlf(bytes: &[u8]) -> bool {
    bytes.iter().position(|&byte| byte == b'\n').is_some_and(|at| bytes[..at].ends_with(b"\r"))
}

/// The finding for a program that carries a stamp; it points at the name in the stamp.
fn corrected_before(source: &Source) -> Diagnostic {
    const NAME: &[u8] = b"ncfix";
    let is_name = |window: &[u8]| window.eq_ignore_ascii_case(NAME);
    let at = source.bytes().windows(NAME.len()).position(is_name).unwrap_or(0);
    Diagnostic::at(
        Code::ALREADY_CORRECTED,
        Place { file: source.id(), span: Span::new(at, at + NAME.len()) },
        "this program was corrected before",
        "correct the original program",
    )
}

/// The options of the correction.
fn options(arguments: &FixArguments) -> path::Options {
    path::Options {
        tolerance_mm: arguments.tolerance,
        subdivision: arguments.step.map_or(path::Subdivision::Adaptive, path::Subdivision::Step),
        arcs: match arguments.arcs {
            ArcChoice::Keep => path::Arcs::Keep,
            ArcChoice::Chords => path::Arcs::Chords,
        },
        rapids: match arguments.rapids {
            RapidChoice::Ends => path::Rapids::Ends,
            RapidChoice::None => path::Rapids::None,
            RapidChoice::All => path::Rapids::All,
        },
        frame: match (arguments.frame, arguments.five_axis) {
            (FrameChoice::Work, FiveAxisChoice::Tcp) => path::OutputFrame::Work,
            _ => path::OutputFrame::Machine,
        },
        five_axis: match arguments.five_axis {
            FiveAxisChoice::Tcp => path::FiveAxis::Tcp,
            FiveAxisChoice::Axes => path::FiveAxis::Axes,
        },
        max_correction_mm: arguments.max_correction,
        rotary: rotary(arguments),
        sample_mm: SAMPLE_MM,
        start: arguments.program.start,
        ..path::Options::default()
    }
}

fn rotary(arguments: &FixArguments) -> path::Rotary {
    match arguments.rotary {
        RotaryChoice::Correct => path::Rotary::Correct,
        RotaryChoice::Hold => path::Rotary::Hold,
    }
}

/// What is left of a source, in the units of reports.
fn remaining(left: &path::Remaining) -> json::Remaining {
    json::Remaining {
        source: left.source,
        position_um: um_from_mm(left.position_mm),
        tilt_urad: urad_from_rad(left.tilt_rad),
        roll_urad: urad_from_rad(left.roll_rad),
    }
}

/// A spread in the units of reports.
pub(super) fn spread(spread: &path::Spread) -> json::Spread {
    json::Spread {
        mean_um: um_from_mm(spread.mean_mm()),
        rms_um: um_from_mm(spread.rms_mm()),
        max_um: um_from_mm(spread.max_mm),
    }
}

/// Takes the numbers of a prediction into the report.
fn note(prediction: &Prediction, running: &Running, report: &mut Correction) {
    report.before = Some(spread(prediction.before()));
    report.after = Some(spread(prediction.after()));
    report.blocks_in = running.blocks();
    if let Some(origin) = prediction.max_at() {
        report.max_at_line = Some(origin.line);
        let source = running.sources().iter().find(|source| source.id() == origin.file);
        report.max_at_file = source.map(|source| source.name().to_owned());
    }
    report.max_correction = AXES
        .into_iter()
        .filter(|&axis| prediction.max_correction[axis] > 0.0)
        .map(|axis| {
            let size = prediction.max_correction[axis];
            let (unit, size) = if axis.is_rotary() { ("urad", urad_from_rad(size)) } else { ("um", um_from_mm(size)) };
            (format!("{}_{unit}", char::from(axis.letter())), size)
        })
        .collect::<BTreeMap<_, _>>();
}
