//! `ncfix fix`: from a program to its corrected text.

pub(in crate::cli) mod arguments;
mod shift;

use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::cli::arguments::FixArguments;
use crate::cli::atomic_writes::AtomicWrites;
use crate::cli::diff;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::input::is_standard_stream;
use crate::cli::machine_choice::{self, MachineSearch};
use crate::cli::output::{Old, Spool, Target, next_backup};
use crate::cli::program;
use crate::cli::stop::Stop;
use crate::cli::{pages, print, progress, tell};
use crate::compare::Pair;
use crate::correction::subprograms;
use crate::machine::Machine;
use crate::next_line;
use crate::program::{Program, keep_programs};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source::Source;
use ncfix_base::units::um_from_mm;
use ncfix_path::emit::without_sections;
use ncfix_report::correction::CorrectionReport;
use ncfix_report::json;
use ncfix_report::verdict::Grade;

/// Corrects a program.
pub(in crate::cli) fn run(arguments: &FixArguments) -> Result<ExitCode, Stop> {
    if let Some(output) = &arguments.zero_shift {
        return shift::run(arguments, output);
    }
    let started = Instant::now();
    let job = Job::new(arguments)?;
    let mut findings = Findings::default();
    let mut report = CorrectionReport::default();
    if let Err(stop) = job.correct(&mut findings, &mut report) {
        findings.draw();
        return Err(stop);
    }
    if findings.has_errors() {
        // There is no output that these numbers could describe.
        report = CorrectionReport { machine: report.machine, ..CorrectionReport::default() };
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
            tell(&(report.table() + &next_line::after_correction(report.verdict.is_some(), job.next())));
        }
    }
    let is_bad = report.verdict.as_ref().is_some_and(|verdict| verdict.grade == Grade::Bad);
    Ok(if is_bad && !findings.has_errors() { ExitCode::Different } else { findings.exit_code() })
}

/// One program and the target of its correction.
struct Job<'a> {
    arguments: &'a FixArguments,
    program: Program,
    target: Target,
    /// The target as the user named it.
    target_name: String,
    /// File of the review page.
    page: Option<Target>,
}

impl<'a> Job<'a> {
    /// Reads the program and checks the target before any work is done.
    fn new(arguments: &'a FixArguments) -> Result<Job<'a>, Stop> {
        let output = arguments.output.as_ref().unwrap_or(&arguments.input);
        if arguments.in_place && is_standard_stream(&arguments.input) {
            return Err(Stop::Usage("--in-place needs a file, not standard input".into()));
        }
        if arguments.json && is_standard_stream(output) {
            return Err(Stop::Usage("--json and the program cannot both go to standard output; give -o a file".into()));
        }
        if arguments.subprograms.is_some() && is_standard_stream(output) {
            return Err(Stop::Usage("--subprograms needs -o a file: the output can be several files".into()));
        }
        let page = arguments.review.as_deref().map(pages::file).transpose()?;
        if page.is_some() && [output, &arguments.input].into_iter().any(|path| is_standard_stream(path)) {
            return Err(Stop::Usage("--review needs a program in a file and -o a file: the page shows both".into()));
        }
        if arguments.in_place && program::is_in_archive(&arguments.input) {
            let archive = arguments.input.display();
            return Err(Stop::Usage(format!(
                "{archive} is an archive of the control, which --in-place would replace by one program; give -o a file"
            )));
        }
        // The target first: a file that appears there while the program is read is newer.
        let target = Target::new(output)?;
        let program = program::of(&arguments.input, &arguments.program)?;
        Ok(Job { arguments, program, target, target_name: output.display().to_string(), page })
    }

    /// Reads the machine, corrects, and publishes the text if there is no error.
    fn correct(&self, findings: &mut Findings, report: &mut CorrectionReport) -> Result<(), Stop> {
        let arguments = self.arguments;
        let search = MachineSearch::of_program(&arguments.input);
        let found = machine_choice::choose_in(&arguments.machine, &arguments.state, search, findings)?;
        let Some(chosen) = found else { return Ok(()) };
        report.machine.clone_from(&chosen.machine.name);
        let correction = self.program.correct(&chosen, &arguments.options());
        if self.program.was_corrected_before(findings) {
            return Ok(());
        }
        let own = (!arguments.in_place).then_some(&arguments.input);
        program::protect_program(&self.target, chosen.files.iter().chain(own), findings);
        if let Some(page) = &self.page {
            program::protect(page, chosen.files.iter().chain([&arguments.input]), findings);
            self.keep_apart(page, findings);
        }
        let Some(mut prepared) = correction.prepare(findings)? else { return Ok(()) };
        let folds = arguments.subprograms.map(|first| Ok::<_, Stop>((prepared.mark_sections()?, first))).transpose()?;
        let mut spool = Spool::new(self.target.clone())?;
        let mut called = Vec::new();
        let guard = |read: &[PathBuf], findings: &mut Findings| {
            called.extend_from_slice(read);
            program::protect_program(&self.target, read, findings);
            if arguments.in_place {
                keep_programs(&self.target_name, findings);
            }
        };
        let written = prepared.write(spool.writer(), Some(progress::watch()), findings, report, guard)?;
        let has_wear = written.map_err(|error| spool.fault(&error))?.has_wear;
        if has_wear && !findings.has_errors() {
            correction.try_wear(&self.text(&mut spool)?, findings)?;
        }
        if findings.has_errors() {
            return Ok(());
        }
        let page = self.review(&chosen, &mut spool, findings, report)?;
        if findings.has_errors() {
            return Ok(());
        }
        let mut together = AtomicWrites::default();
        let old = if arguments.in_place { Old::Kept(self.program.bytes()) } else { Old::Replaced };
        if let Some(style) = folds {
            let source = (self.program.bytes(), &called[..]);
            let (main, beside) = subprograms::fold(&spool.text()?, style, self.output(), source, report)?;
            correction.check_growth(report, findings);
            if findings.has_errors() {
                return Ok(());
            }
            together.add(self.target.clone(), &main)?;
            beside.into_iter().try_for_each(|(target, text)| together.add(target, &text))?;
        } else {
            if arguments.in_place { together.put(spool) } else { together.take(spool) }?;
        }
        if let (Some(target), Some(page)) = (&self.page, page) {
            together.add(target.clone(), page.as_bytes())?;
        }
        let backup = match together.publish_first(old) {
            Err(error) if error.code() == Some(Code::NEWER_FILE) => {
                findings.absorb(error.diagnostics().clone());
                return Ok(());
            }
            published => published?,
        };
        report.backup = backup.map(|backup| backup.display().to_string());
        report.output = Some(self.target_name.clone());
        Ok(())
    }

    /// The row with the test of the output; empty where a condition or a start of the command would be missing in it.
    fn next(&self) -> String {
        let FixArguments { input, output, machine, state, program, .. } = self.arguments;
        let is_told = state.time.is_none() && state.zero_time.is_none() && state.zero_at.is_none();
        let is_plain = program.skip.is_none() && program.start.is_none() && program.max_blocks.is_none();
        let same = next_line::SameMachine {
            machine: machine.machine.as_deref(),
            head: machine.head.as_deref(),
            dialect: program.dialect.as_deref(),
            setups: &machine.setup,
            states: &state.state,
            zeros: &state.zero,
        };
        let output = output.as_deref().filter(|_| is_told && is_plain && state.load.is_none());
        output.map_or_else(String::new, |output| next_line::after_fix(input, output, same))
    }

    /// Refuses a page that would overwrite the program.
    fn keep_apart(&self, page: &Target, findings: &mut Findings) {
        let output = self.output();
        if *page == self.target || page.is(output) {
            let message = format!("the review would overwrite {}", self.target_name);
            findings.add(Diagnostic::nowhere(Code::WRONG_FILE, message, "choose another file for --review"), &[]);
        }
    }

    /// The file of the corrected program.
    fn output(&self) -> &Path {
        self.arguments.output.as_ref().unwrap_or(&self.arguments.input)
    }

    /// The text that was written.
    fn text(&self, spool: &mut Spool) -> Result<Source, Stop> {
        let text = without_sections(&spool.text()?);
        Ok(crate::Correction::again(self.program.source(), &self.target_name, text)?)
    }

    /// Executes both programs as read and as they will be written, and returns the review page.
    fn review(
        &self,
        machine: &Machine,
        spool: &mut Spool,
        findings: &mut Findings,
        report: &mut CorrectionReport,
    ) -> Result<Option<String>, Stop> {
        let Some(page) = &self.page else { return Ok(None) };
        let arguments = self.arguments;
        let kept = arguments.in_place.then(|| next_backup(&self.target)).flatten();
        if kept.as_ref().is_some_and(|kept| page.is(kept)) {
            return Err(Stop::Usage(format!(
                "--review {page} is where the original would be kept; choose another file"
            )));
        }
        let original = kept.unwrap_or_else(|| arguments.input.clone());
        let output = arguments.output.clone().unwrap_or_else(|| arguments.input.clone());
        let corrected = Program::new(self.text(spool)?, &output, self.program.reading().clone());
        let names = [original, output].map(|path| path.display().to_string());
        let pair = Pair {
            programs: [&self.program, &corrected],
            machine,
            promised: None,
            at_feed: false,
            requires_coverage: false,
            watch: Some(progress::watch),
        };
        let allowed_um = um_from_mm(arguments.correction.max_correction);
        // Most diagnostics of the program are found again; the verdict needs those of the correction too.
        let mut again = Findings::default();
        let Some(mut reviewed) = pair.review(names, allowed_um, &mut again)? else {
            findings.absorb(again);
            return Ok(None);
        };
        reviewed.review.take_in(findings.json());
        let text = diff::page(&reviewed.review, &reviewed.trace, (&reviewed.outcome, corrected.source()), None)?;
        report.review = arguments.review.as_ref().map(|path| path.display().to_string());
        report.verdict = Some(reviewed.review.verdict);
        Ok(Some(text))
    }
}
