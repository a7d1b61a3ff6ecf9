//! `ncfix fix`: the whole way from a program to its corrected text.

use std::collections::BTreeMap;
use std::panic::resume_unwind;
use std::time::Instant;

use super::arguments::{CompensationChoice, DiffArguments, FixArguments};
use super::diff;
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::input::is_standard_stream;
use super::lanes::{self, Lanes};
use super::machine_choice::{self, Chosen, short_hash};
use super::output::{Old, Spool, Target, next_backup};
use super::program::{self, Opened, Running};
use super::state;
use super::stop::Stop;
use super::together::Together;
use super::writing::Writing;
use super::{feed_limit, pages, print, tell, wear};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{AXES, Axis};
use ncfix_base::source::{Source, Span};
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_dialect::Language;
use ncfix_language::exec::{Options, Radius};
use ncfix_language::syntax::Program;
use ncfix_path::emit::{self, NumberSet};
use ncfix_path::path::{self, Prediction};
use ncfix_path::review::Trace;
use ncfix_report::correction::Correction;
use ncfix_report::json;
use ncfix_report::number::micrometers;
use ncfix_report::review::Limit;

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
    /// Where the page with the review goes.
    page: Option<Target>,
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
        // First: what comes into being there while the program is read is newer.
        let target = Target::new(output)?;
        let source = program::read(&arguments.input)?;
        Ok(Job { arguments, source, target, target_name: output.display().to_string(), page })
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
        program::protect_program(&self.target, chosen.files.iter().chain(own), findings);
        if let Some(page) = &self.page {
            program::protect(page, chosen.files.iter().chain([&arguments.input]), findings);
            self.keep_apart(page, findings);
        }
        if arguments.feed_limit.is_some() && feed_limit::servo(&chosen.machine, findings).is_none() {
            return Ok(());
        }
        if let Some(found) =
            wear::refusal(&arguments.correction).filter(|_| arguments.compensation == CompensationChoice::Wear)
        {
            findings.add(found, &[]);
            return Ok(());
        }
        if let Some(increment_mm) = arguments.correction.increment {
            chosen.machine.control.increment_mm = increment_mm;
        }
        let bytes = self.source.bytes();
        let threads = arguments.threads.unwrap_or_else(|| lanes::threads_for(bytes.len()));
        // What the stamp says of the program is worked out beside its parsing.
        let (opened, hash) = std::thread::scope(|scope| {
            let hashing = (threads > 1).then(|| scope.spawn(|| short_hash([bytes])));
            let opened = program::open(&self.source, &arguments.program, Some(&chosen), findings);
            let hash = hashing.map(|hashing| hashing.join().unwrap_or_else(|fault| resume_unwind(fault)));
            (opened, hash.unwrap_or_else(|| short_hash([bytes])))
        });
        let opened = opened?;
        let Some(opened) = opened.filter(|_| !findings.has_errors()) else { return Ok(()) };
        program::keep_unit(&self.source, opened.dialect, false, &mut chosen.machine);
        let mut spool = Spool::new(self.target.clone())?;
        let has_wear = self.write((opened, hash), &chosen, (&mut spool, threads), findings, report)?;
        if has_wear && !findings.has_errors() {
            wear::try_both(&self.text(&mut spool)?, arguments, &chosen, findings)?;
        }
        if findings.has_errors() {
            // Numbers of an output that does not exist would be taken for its numbers.
            *report = Correction { machine: std::mem::take(&mut report.machine), ..Correction::default() };
            return Ok(());
        }
        let page = self.review(&mut spool, findings, report)?;
        if findings.has_errors() {
            *report = Correction { machine: std::mem::take(&mut report.machine), ..Correction::default() };
            return Ok(());
        }
        let mut together = Together::default();
        let old = if arguments.in_place { Old::Kept(self.source.bytes()) } else { Old::Replaced };
        if arguments.in_place { together.put(spool) } else { together.take(spool) }?;
        if let (Some(target), Some(page)) = (&self.page, page) {
            together.add(target.clone(), page.as_bytes())?;
        }
        let backup = match together.publish_first(old) {
            Err(Stop::Found(diagnostic)) => {
                findings.add(*diagnostic, &[]);
                *report = Correction { machine: std::mem::take(&mut report.machine), ..Correction::default() };
                return Ok(());
            }
            published => published?,
        };
        report.backup = backup.map(|backup| backup.display().to_string());
        report.output = Some(self.target_name.clone());
        Ok(())
    }

    /// Programs of the file that are not in the output stay only where the output is another file.
    fn keep_programs(&self, findings: &mut Findings) {
        let Some((left, source)) = findings.first_of(Code::MORE_PROGRAMS) else { return };
        let (place, source) = (left.place, source.clone());
        let message = format!("--in-place would remove other programs from {}: {}", self.target_name, left.message);
        let help = "give -o another file, or put each program into a file of its own";
        let found = match place {
            Some(place) => Diagnostic::at(Code::LOST_PROGRAM, place, message, help),
            None => Diagnostic::nowhere(Code::LOST_PROGRAM, message, help),
        };
        findings.add(found, source.as_slice());
    }

    /// A page that would be written over the program.
    fn keep_apart(&self, page: &Target, findings: &mut Findings) {
        let output = self.arguments.output.as_ref().unwrap_or(&self.arguments.input);
        if *page == self.target || page.is(output) {
            let message = format!("the review would overwrite {}", self.target_name);
            findings.add(Diagnostic::nowhere(Code::WRONG_FILE, message, "choose another file for --review"), &[]);
        }
    }

    /// The text that was written.
    fn text(&self, spool: &mut Spool) -> Result<Source, Stop> {
        Source::new(self.source.id(), &self.target_name, spool.text()?)
            .map_err(|_| Stop::Usage(format!("{} is too long to be read again", self.target_name)))
    }

    /// Executes both programs as they were read and will be written, and gives the page about what was changed.
    fn review(
        &self,
        spool: &mut Spool,
        findings: &mut Findings,
        report: &mut Correction,
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
        let corrected = arguments.output.clone().unwrap_or_else(|| arguments.input.clone());
        let sources = [self.source.clone(), self.text(spool)?];
        let comparison = DiffArguments::of_fix(arguments, original, corrected);
        let allowed_um = um_from_mm(arguments.correction.max_correction);
        let limit = |trace: &Trace| {
            let axes: Vec<Axis> = AXES.into_iter().filter(|axis| !axis.is_rotary()).collect();
            let value_um = trace.rows.iter().map(|row| row.largest(&axes)).fold(0.0, f64::max);
            let name = "the largest correction of a linear axis".to_owned();
            Limit { name, value_um, limit_um: allowed_um, is_kept: value_um <= allowed_um }
        };
        // What was found in the program is known already, and is found again.
        let mut again = Findings::default();
        let Some((verdict, text)) = diff::review(&comparison, sources, limit, &mut again)? else {
            findings.absorb(again);
            return Ok(None);
        };
        report.review = arguments.review.as_ref().map(|path| path.display().to_string());
        report.verdict = Some(verdict);
        Ok(Some(text))
    }

    /// Executes, corrects and writes. Behind the first error nothing more is written, but all findings are gathered. Whether the control
    /// compensates radii by wear.
    fn write(
        &self,
        (opened, hash): (Opened, String),
        chosen: &Chosen,
        (spool, threads): (&mut Spool, usize),
        findings: &mut Findings,
        report: &mut Correction,
    ) -> Result<bool, Stop> {
        let arguments = self.arguments;
        let machine = &chosen.machine;
        let model = chosen.model();
        let start = arguments.program.start;
        let (correction, bytes) = (&arguments.correction, (self.source.bytes(), hash));
        let limits_feed = arguments.feed_limit.is_some();
        let keeps_wear = arguments.compensation == CompensationChoice::Wear;
        let mut writing = Writing::new(correction, start, opened.dialect.name, chosen, bytes, limits_feed)?;
        if keeps_wear {
            writing.keep_wear();
        }
        let mut writer = writing.writer()?;
        writer.keep_free(numbers_of(&opened.program));
        let radius = if keeps_wear { Radius::Beside(0.0) } else { Radius::Whole };
        let options = Options { strict: true, tells_compensation: true, radius, keeps_wear, ..Options::default() };
        let mut running = Running::start_as(opened, &arguments.input, &arguments.program, machine, options);
        let feed_limit = arguments.feed_limit.zip(machine.servo.as_ref());
        let lanes = Lanes { machine, model: &model, options: &writing.options, feed_limit };
        let passed = lanes.pass(&mut running, writer.as_mut(), spool.writer(), threads);
        report.blocks_out = passed.blocks.map_err(|error| spool.fault(&error))?;
        if let Some((limit, limited)) = arguments.feed_limit.zip(passed.limited) {
            report.feed_limit = Some(feed_limit::report(limit, &limited));
        }
        let has_wear = passed.found.iter().any(|found| found.code == Code::WEAR_ALONE);
        findings.extend(passed.found, running.sources());
        if !running.moves() && !findings.has_errors() {
            findings.add(program::without_motion(&self.source, Code::NO_MOTION), running.sources());
        }
        program::protect_program(&self.target, &running.files(), findings);
        if arguments.in_place {
            self.keep_programs(findings);
        }
        let sources = running.sources();
        for stamped in sources.iter().skip(1).filter(|source| emit::is_stamped(source.bytes())) {
            findings.add(corrected_before(stamped), sources);
        }
        note(&passed.prediction, &running, report);
        if let Some(finding) = worse(&passed.prediction, arguments.correction.tolerance) {
            findings.add(finding, &[]);
        }
        let left = path::remaining(machine, &chosen.errors, &chosen.condition, &passed.poses);
        report.remaining = left.iter().map(remaining).collect();
        Ok(has_wear)
    }
}

/// The finding for a correction that leaves more than there was, beyond what was asked for, mm.
fn worse(prediction: &Prediction, tolerance_mm: f64) -> Option<Diagnostic> {
    let [before_mm, after_mm] = [prediction.before(), prediction.after()].map(|spread| spread.rms_mm());
    if after_mm <= before_mm.max(tolerance_mm) {
        return None;
    }
    let [before, after] = [before_mm, after_mm].map(|mm| micrometers(um_from_mm(mm)));
    let message = format!("the corrected program would leave {after} rms where the program as it is leaves {before}");
    let help = "nothing was written; a smaller --increment, if the control has one, or a smaller --tolerance; else run the program as it is";
    Some(Diagnostic::nowhere(Code::CORRECTION_MAKES_WORSE, message, help))
}

/// The block numbers of a program in a language that needs one on every line.
fn numbers_of(program: &Program) -> NumberSet {
    let mut numbers = NumberSet::default();
    if let Program::Words(program) = program
        && program.dialect.language == Language::Grundig
    {
        program.each_block_number(&mut |number| {
            numbers.add(number);
        });
    }
    numbers
}

/// The finding for a program that carries a stamp; it points at the name in the stamp.
pub(super) fn corrected_before(source: &Source) -> Diagnostic {
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
    report.rapids_as_programmed = prediction.as_programmed;
    report.off_at_rapids_um = um_from_mm(prediction.off_cut_mm);
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
