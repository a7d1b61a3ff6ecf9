//! Correction of a program: execution, correction, output, evaluation.

mod feed_limit;
mod firmware;
mod growth;
mod guard;
mod noted;
mod pieces;
mod pipeline;
pub(crate) mod subprograms;
mod wear;
mod writing;

use std::io::{self, Write};
use std::panic::resume_unwind;
use std::path::PathBuf;
use std::time::Instant;

use crate::assumed_start::assumed_start;
use crate::coverage;
use crate::datum;
use crate::diagnostics::Diagnostics;
use crate::disk::hash::short_hash;
use crate::error::Error;
use crate::head;
use crate::interval;
use crate::machine::Machine;
use crate::options::{Compensation, Options};
use crate::program::Program;
use crate::run::{self, Opened, Running, Watch};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{Source, Span};
use ncfix_base::units::um_from_mm;
use ncfix_dialect::Language;
use ncfix_language::exec::{self, Radius};
use ncfix_language::syntax;
use ncfix_model::Model;
use ncfix_path::emit::{self, CorrectionTrace, NumberSet, SubprogramStyle};
use ncfix_path::path::{self, Prediction};
use ncfix_report::correction::CorrectionReport;
use ncfix_report::guard::GuardReport;
use ncfix_report::number::micrometers;

pub(crate) use feed_limit::{contouring, servo};
pub(crate) use noted::spread;
use noted::{note, remaining, short_blocks};
pub use pieces::Pieces;
pub(crate) use pipeline::MOST_THREADS;
use pipeline::{Pipeline, threads_for};
pub(crate) use writing::Writing;

/// A program that will be corrected for a machine. It is executed only when its text, its pieces or its report are
/// requested.
///
/// ```
/// use ncfix::prelude::*;
///
/// let machine = Machine::demo();
/// let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X600 F500\nM30\n", DialectChoice::Sinumerik)?;
/// let correction = program.correct(&machine, &Options::default());
/// let mut text = Vec::new();
/// let report = correction.write_to(&mut text)?;
/// assert!(report.after.unwrap().max_um < report.before.unwrap().max_um);
/// assert!(text.starts_with(b"; ncfix"));
/// # Ok::<(), ncfix::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Correction<'a> {
    program: &'a Program,
    /// With the increments and the unit of the output.
    machine: Machine,
    model: Model,
    options: Options,
}

impl<'a> Correction<'a> {
    pub(crate) fn new(program: &'a Program, machine: &Machine, options: &Options) -> Correction<'a> {
        let mut machine = datum::with_written(program, machine);
        if let Some(increment_mm) = options.increment_mm {
            machine.machine.control.increment_mm = increment_mm;
        }
        // A nonexistent dialect is reported when the program is opened.
        if let Ok((dialect, _)) = run::resolve(program.reading().dialect.as_deref(), Some(&machine), program.source()) {
            run::keep_unit(program.source(), dialect, false, &mut machine.machine);
        }
        let model = machine.model();
        Correction { program, machine, model, options: options.clone() }
    }

    /// Executes, corrects and writes the program. It streams: memory is bounded by the text of the program, and text
    /// that was written before an error stays written.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::demo();
    /// let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X600 F500\nM30\n", DialectChoice::Sinumerik)?;
    /// let mut text = Vec::new();
    /// let report = program.correct(&machine, &Options::default()).write_to(&mut text)?;
    /// assert_eq!(report.machine, "demo");
    /// assert!(text.ends_with(b"M30\n"));
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// If the program cannot be parsed, is refused, or cannot be corrected, or `out` refuses the text. The text must not be used then.
    pub fn write_to(&self, out: &mut (dyn Write + Send)) -> Result<CorrectionReport, Error> {
        let started = Instant::now();
        let mut found = Diagnostics::default();
        let mut report = CorrectionReport { machine: self.machine.machine.name.clone(), ..CorrectionReport::default() };
        self.correct_into(out, &mut found, &mut report)?;
        if found.has_errors() {
            return Err(Error::found(found));
        }
        report.seconds = started.elapsed().as_secs_f64();
        report.diagnostics = found.json();
        Ok(report)
    }

    fn correct_into(
        &self,
        out: &mut (dyn Write + Send),
        found: &mut Diagnostics,
        report: &mut CorrectionReport,
    ) -> Result<(), Error> {
        if self.program.was_corrected_before(found) {
            return Ok(());
        }
        let Some(prepared) = self.prepare(found)? else { return Ok(()) };
        let nothing = |_: &[PathBuf], _: &mut Diagnostics| {};
        if self.options.compensation == Compensation::Center {
            let written = prepared.write(out, None, found, report, nothing)?;
            return written.map(drop).map_err(|error| Error::sink(&error));
        }
        // It is known only after the output whether the control can follow the wear.
        let mut text = Vec::new();
        let has_wear = prepared.write(&mut text, None, found, report, nothing)?.is_ok_and(|written| written.has_wear);
        if has_wear && !found.has_errors() {
            self.try_wear(&Self::again(self.program.source(), self.program.source().name(), text.clone())?, found)?;
        }
        if !found.has_errors() {
            out.write_all(&text).map_err(|error| Error::sink(&error))?;
        }
        Ok(())
    }

    /// The complete corrected text.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::demo();
    /// let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X600 F500\nM30\n", DialectChoice::Sinumerik)?;
    /// let text = program.correct(&machine, &Options::default()).text()?;
    /// assert!(text.lines().count() > program.correct(&machine, &Options::default()).pieces()?.count());
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// The errors of [`Correction::write_to`].
    pub fn text(&self) -> Result<String, Error> {
        let mut text = Vec::new();
        self.write_to(&mut text)?;
        Ok(String::from_utf8_lossy(&text).into_owned())
    }

    /// The effect of the correction, without its text: errors along the path before and after, corrections, times.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::demo();
    /// let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X600 F500\nM30\n", DialectChoice::Sinumerik)?;
    /// let report = program.correct(&machine, &Options::default()).report()?;
    /// assert_eq!(report.blocks_in, 3);
    /// assert!(report.before.unwrap().max_um > report.after.unwrap().max_um);
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// The errors of [`Correction::write_to`].
    pub fn report(&self) -> Result<CorrectionReport, Error> {
        self.write_to(&mut io::sink())
    }

    /// The corrected pieces of moves in sequence, and between them the elements without motion.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::demo();
    /// let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X600 F500\nM30\n", DialectChoice::Sinumerik)?;
    /// let mut ends_mm = Vec::new();
    /// for output in program.correct(&machine, &Options::default()).pieces()? {
    ///     if let Output::Piece(piece) = output? {
    ///         ends_mm.push(piece.command[Axis::X]);
    ///     }
    /// }
    /// let last_mm = ends_mm.last().unwrap();
    /// assert!((last_mm - 600.0).abs() < 0.2 && *last_mm != 600.0);
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// If the program cannot be parsed or is refused. Errors of the run are items of the pieces.
    pub fn pieces(&self) -> Result<Pieces<'_>, Error> {
        let mut found = Diagnostics::default();
        let prepared = if self.program.was_corrected_before(&mut found) { None } else { self.prepare(&mut found)? };
        match prepared.filter(|_| !found.has_errors()) {
            Some(prepared) => prepared.pieces(found),
            None => Err(Error::found(found)),
        }
    }

    /// Parses the program and checks whether it can be corrected with these options; `None` if there are errors.
    ///
    /// # Errors
    /// If an option is wrong.
    pub(crate) fn prepare(&self, found: &mut Diagnostics) -> Result<Option<Prepared<'_>>, Error> {
        if self.options.feed_limit_mm.is_some() && servo(&self.machine.machine, found).is_none() {
            return Ok(None);
        }
        let keeps_wear = self.options.compensation != Compensation::Center;
        if let Some(refusal) = wear::refusal(&self.options).filter(|_| keeps_wear) {
            found.add(refusal, &[]);
            return Ok(None);
        }
        let bytes = self.program.source().bytes();
        let threads = self.options.threads.unwrap_or_else(|| threads_for(bytes.len()));
        // The entries of the stamp about the program are determined in parallel with its parsing.
        let (opened, hash) = std::thread::scope(|scope| {
            let hashing = (threads > 1).then(|| scope.spawn(|| short_hash([bytes])));
            let opened = self.program.open(Some(&self.machine), found);
            let hash = hashing.map(|hashing| hashing.join().unwrap_or_else(|fault| resume_unwind(fault)));
            (opened, hash.unwrap_or_else(|| short_hash([bytes])))
        });
        let opened = opened?.filter(|_| !found.has_errors());
        if let Some(opened) = &opened {
            let assumed = assumed_start(&opened.source, opened.dialect, &self.machine.machine);
            found.extend(assumed, std::slice::from_ref(&opened.source));
        }
        Ok(opened.map(|opened| Prepared { correction: self, opened, hash, threads, has_sections: false }))
    }

    /// A written text, for reading it again.
    ///
    /// # Errors
    /// If it is too long.
    pub(crate) fn again(original: &Source, name: &str, text: Vec<u8>) -> Result<Source, Error> {
        let too_long = format!("{name} is too long to be read again");
        Source::new(original.id(), name, text).map_err(|_| Error::usage(too_long))
    }

    /// Checks the growth of the output after its size has changed.
    pub(crate) fn check_growth(&self, report: &mut CorrectionReport, found: &mut Diagnostics) {
        found.extend(growth::check(self.program.source(), self.options.max_growth, report), &[]);
    }

    /// Executes a written text as the control would with the largest wear to either side.
    ///
    /// # Errors
    /// If it cannot be opened.
    pub(crate) fn try_wear(&self, text: &Source, found: &mut Diagnostics) -> Result<(), Error> {
        let Compensation::Wear(largest_mm) = self.options.compensation else { return Ok(()) };
        wear::try_both(&self.program.with_source(text.clone()), largest_mm, &self.machine, found)
    }
}

/// A written corrected text.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WrittenText {
    /// True if the control compensates radii by wear.
    pub(crate) has_wear: bool,
    /// Elements of the flat stream of the original.
    pub(crate) elements: u64,
}

/// A program that is about to be corrected.
pub(crate) struct Prepared<'a> {
    correction: &'a Correction<'a>,
    opened: Opened,
    hash: String,
    threads: usize,
    /// `true` if the text has marks of sections that can become subprograms.
    has_sections: bool,
}

impl<'a> Prepared<'a> {
    /// The program at its start, with the options of the output; `keeps_cycles` if holes may stay drilling cycles, `keeps_taps` if threads may.
    ///
    /// # Errors
    /// If it cannot be written like that.
    fn start(self, [keeps_cycles, keeps_taps]: [bool; 2]) -> Result<(Running<'a>, Writing, NumberSet), Error> {
        let Prepared { correction, opened, hash, .. } = self;
        let (program, options) = (correction.program, &correction.options);
        let bytes = (program.source(), hash);
        let start = program.reading().start;
        let mut writing = Writing::new(options, start, opened.dialect.name, &correction.machine, bytes)?;
        let keeps_wear = options.compensation != Compensation::Center;
        if keeps_wear {
            writing.keep_wear();
        }
        let numbers = numbers_of(&opened.program);
        let radius = if keeps_wear { Radius::Beside(0.0) } else { Radius::Whole };
        let is_as_programmed = (options.frame, options.five_axis) == (path::OutputFrame::Work, path::FiveAxis::Tcp);
        let may_keep = !keeps_wear && writing.options.may_keep_cycles();
        let run = exec::Options {
            strict: true,
            tells_compensation: true,
            radius,
            keeps_wear,
            hides_marks: true,
            names_cycles: true,
            // With arcs as chords too: a verification does not know the options.
            fits_arcs: true,
            keeps_cycles: keeps_cycles && may_keep,
            keeps_taps: keeps_taps && may_keep,
            keeps_tapping: is_as_programmed,
            keeps_tilt: is_as_programmed && options.rotary != path::Rotary::Correct,
            ..exec::Options::default()
        };
        Ok((program.start_as(opened, &correction.machine.machine, run), writing, numbers))
    }

    /// Marks the sections of the text that can become subprograms. Returns how the control calls these.
    ///
    /// # Errors
    /// If the control has no subprograms.
    pub(crate) fn mark_sections(&mut self) -> Result<SubprogramStyle, Error> {
        self.has_sections = true;
        subprograms::style(self.opened.dialect.language, &self.correction.machine)
    }

    /// The tree of the program.
    pub(crate) fn program(&self) -> &syntax::Program {
        &self.opened.program
    }

    /// Executes, corrects and writes like a correction of a file, and discards the text. Returns the number of elements of the flat stream.
    ///
    /// # Errors
    /// If the program cannot be written like that.
    pub(crate) fn discard(self, watch: Option<Box<dyn Watch>>, found: &mut Diagnostics) -> Result<u64, Error> {
        let correction = self.correction;
        let mut report = CorrectionReport::default();
        let mut text = Vec::new();
        let keeps_wear = correction.options.compensation != Compensation::Center;
        let mut nowhere = io::sink();
        let sink: &mut (dyn Write + Send) = if keeps_wear { &mut text } else { &mut nowhere };
        let written = self.write(sink, watch, found, &mut report, |_, _| {})?.map_err(|error| Error::sink(&error))?;
        if written.has_wear && !found.has_errors() {
            let source = correction.program.source();
            correction.try_wear(&Correction::again(source, source.name(), text)?, found)?;
        }
        Ok(written.elements)
    }

    /// Executes, corrects and writes. After the first error the output stops, but all diagnostics are collected.
    /// `also` reports other reasons against the output when the list of read files is complete.
    ///
    /// # Errors
    /// If the program cannot be written like that; inside, where the text is refused.
    pub(crate) fn write(
        self,
        sink: &mut (dyn Write + Send),
        watch: Option<Box<dyn Watch>>,
        found: &mut Diagnostics,
        report: &mut CorrectionReport,
        also: impl FnOnce(&[PathBuf], &mut Diagnostics),
    ) -> Result<io::Result<WrittenText>, Error> {
        let (correction, threads, has_sections) = (self.correction, self.threads, self.has_sections);
        let Correction { program, machine, model, options } = correction;
        let is_required = options.require_coverage;
        let is_unlimited = options.feed_limit_mm.is_none();
        let (running, writing, numbers) = self.start([options.keeps_cycles && is_unlimited, is_unlimited])?;
        let mut running = match watch {
            Some(watch) => running.watched(watch),
            None => running,
        };
        let mut writer = writing.writer()?;
        writer.mark_passes();
        if has_sections {
            writer.mark_sections();
        }
        writer.keep_free(numbers);
        if options.guard {
            let mut words = guard::of_program(program, machine, &writing)?;
            if matches!(options.compensation, Compensation::Wear(_)) {
                words.left.push("that tool radii are 0".to_owned());
            }
            report.guard = Some(GuardReport { checked: words.checked, left: words.left });
            writer.begin_with(words.lines);
        }
        let feed_limit = options.feed_limit_mm.zip(machine.machine.servo.as_ref());
        let pipeline = Pipeline { machine: &machine.machine, model, options: &writing.options, feed_limit };
        let (passed, lacking) = match machine.machine.control.firmware {
            None => (pipeline.pass(&mut running, writer.as_mut(), sink, threads), None),
            Some(firmware) => {
                let mut watched = firmware::Watched::new(sink, firmware);
                let passed = pipeline.pass(&mut running, writer.as_mut(), &mut watched, threads);
                (passed, watched.finish(program.source()))
            }
        };
        report.blocks_out = match passed.blocks {
            Ok(blocks) => blocks,
            Err(error) => return Ok(Err(error)),
        };
        // Calls shorten the output.
        if !has_sections {
            found.extend(growth::check(program.source(), options.max_growth, report), &[]);
        }
        if let Some((limit, limited)) = options.feed_limit_mm.zip(passed.limited) {
            report.feed_limit = Some(feed_limit::report(limit, &limited));
        }
        let has_wear = passed.found.iter().any(|found| found.code == Code::WEAR_ALONE);
        found.extend(passed.found, running.sources());
        found.extend(lacking, std::slice::from_ref(program.source()));
        if !running.moves() && !found.has_errors() {
            found.add(run::without_motion(program.source(), Code::NO_MOTION), running.sources());
        }
        also(&running.files(), found);
        let sources = running.sources();
        for corrected in sources.iter().skip(1).filter_map(corrected_before) {
            found.add(corrected, sources);
        }
        let heads = head::in_use(machine, model, running.extent());
        if running.moves() && !found.has_errors() {
            let (coverage, gaps) = coverage::of_run(&heads[0].chosen, running.extent(), is_required);
            report.coverage = Some(coverage);
            found.extend(gaps, sources);
            report.zeros = head::zeros(&heads, running.extent(), options.tolerance_mm, found);
            let whole = [passed.prediction.before(), passed.prediction.after()];
            report.prediction = interval::of_run(&heads, model, whole, &passed.prediction.places());
        }
        note(&passed.prediction, &running, &machine.machine, options.tolerance_mm, report);
        if let Some((finding, source)) = short_blocks(&passed.prediction.short_blocks, sources, report) {
            found.add(finding, &[source]);
        }
        if let Some(finding) = worse(&passed.prediction, options.tolerance_mm) {
            found.add(finding, &[]);
        }
        report.remaining = head::remaining(&heads, &passed.poses).iter().map(remaining).collect();
        Ok(Ok(WrittenText { has_wear, elements: running.elements() }))
    }

    /// The corrected pieces, with what was found so far.
    ///
    /// # Errors
    /// If the program cannot be written like that.
    fn pieces(self, found: Diagnostics) -> Result<Pieces<'a>, Error> {
        let correction = self.correction;
        let (running, writing, _) = self.start([false; 2])?;
        Ok(Pieces::new(running, &correction.machine.machine, &correction.model, writing.options, found))
    }
}

/// The diagnostic for a correction whose residual exceeds the original error by more than the permitted value, mm.
fn worse(prediction: &Prediction, tolerance_mm: f64) -> Option<Diagnostic> {
    let [before_mm, after_mm] = [prediction.before(), prediction.after()].map(|spread| spread.rms_mm());
    if after_mm <= before_mm.max(tolerance_mm) {
        return None;
    }
    let [before, after] = [before_mm, after_mm].map(|mm| micrometers(um_from_mm(mm)));
    let message =
        format!("the corrected program would have an error of {after} rms, but the original program has {before}");
    let help = "nothing was written; choose a smaller --increment, if the control has one, or a smaller --tolerance; otherwise run the original program";
    Some(Diagnostic::nowhere(Code::CORRECTION_MAKES_WORSE, message, help))
}

/// The block numbers of a program in a language that needs one on every line.
fn numbers_of(program: &syntax::Program) -> NumberSet {
    let mut numbers = NumberSet::default();
    if let syntax::Program::Words(program) = program
        && program.dialect.language == Language::Grundig
    {
        program.each_block_number(&mut |number| {
            numbers.add(number);
        });
    }
    numbers
}

/// The diagnostic for a program that carries a sign of a correction; it points at this sign. `None` for any other program.
pub(crate) fn corrected_before(source: &Source) -> Option<Diagnostic> {
    let CorrectionTrace { what, at } = emit::correction_trace(source.bytes())?;
    let message = if emit::is_stamped(source.bytes()) {
        "this program is already corrected".to_owned()
    } else {
        format!("this program is already corrected, although its first comment is missing: it has {what}")
    };
    let place = Place { file: source.id(), span: Span::new(at.start, at.end) };
    Some(Diagnostic::at(Code::ALREADY_CORRECTED, place, message, "correct the original program"))
}
