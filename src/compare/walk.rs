//! Execution of two programs in parallel and comparison of their moves, for `ncfix verify` and `ncfix diff`.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::panic::resume_unwind;

use super::at_feed::Driven;
use super::header::Header;
use super::{differences, stamp};
use crate::channel::{BatchReceiver, BatchSender, channel};
use crate::correction::servo;
use crate::coverage;
use crate::datum;
use crate::diagnostics::Diagnostics;
use crate::error::Error;
use crate::head;
use crate::interval;
use crate::machine::Machine;
use crate::program::Program;
use crate::run::{self, Running, Watch, is_wear_alone};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_base::source::{FileId, Source, Span};
use ncfix_language::exec::{Options, Radius, RapidOrder};
use ncfix_machine::machine::Kinematics;
use ncfix_machine::snc::{Element, Origin};
use ncfix_path::emit;
use ncfix_path::path::{self, Feeds, Follow, Grouping, ProgramDifference};
use ncfix_report::coverage::CoverageReport;
use ncfix_report::json::{AtFeed, ZeroReport};
use ncfix_report::prediction::PredictionReport;

/// Two programs and the options of their execution.
pub(crate) struct Pair<'a> {
    /// The original and the corrected one.
    pub(crate) programs: [&'a Program; 2],
    pub(crate) machine: &'a Machine,
    /// Tolerance of the correction as stated by the user, mm.
    pub(crate) promised: Option<f64>,
    /// True if both are also passed through the servo model of the machine.
    pub(crate) at_feed: bool,
    /// True if gaps of the coverage are errors.
    pub(crate) requires_coverage: bool,
    /// Makes the observer of the progress in the original.
    pub(crate) watch: Option<fn() -> Box<dyn Watch>>,
}

impl<'a> Pair<'a> {
    /// An original and its corrected program, with default options.
    pub(crate) fn of(programs: [&'a Program; 2], machine: &'a Machine) -> Pair<'a> {
        Pair { programs, machine, promised: None, at_feed: false, requires_coverage: false, watch: None }
    }
}

impl Pair<'_> {
    /// Opens both programs and walks them side by side; `None` if there are errors.
    ///
    /// # Errors
    /// If their dialect does not exist.
    pub(crate) fn compare(
        &self,
        findings: &mut Diagnostics,
        see: &mut dyn FnMut(Follow<'_>),
    ) -> Result<Option<Outcome>, Error> {
        if self.at_feed && servo(&self.machine.machine, findings).is_none() {
            return Ok(None);
        }
        let machine = datum::with_written(self.programs[0], self.machine);
        let open = |program: &Program| {
            let mut own = Diagnostics::default();
            let opened = program.open(Some(self.machine), &mut own);
            (opened, own)
        };
        let [original, corrected] = std::thread::scope(|scope| {
            let corrected = scope.spawn(|| open(self.programs[1]));
            [open(self.programs[0]), corrected.join().unwrap_or_else(|fault| resume_unwind(fault))]
        });
        findings.absorb(original.1);
        findings.absorb(corrected.1);
        let (Some(original), Some(corrected)) = (original.0?, corrected.0?) else { return Ok(None) };
        Ok(Pair { machine: &machine, ..*self }.walked([original, corrected], findings, see))
    }

    fn walked(
        &self,
        [original, corrected]: [run::Opened; 2],
        findings: &mut Diagnostics,
        see: &mut dyn FnMut(Follow<'_>),
    ) -> Option<Outcome> {
        let chosen = self.machine;
        let sources = &self.programs.map(|program| program.source().clone());
        let has_wear_alone = is_wear_alone(&sources[1]);
        if has_wear_alone && !is_wear_alone(&sources[0]) {
            findings.add(wear_alone(&sources[1]), &sources[1..]);
        }
        let start = |opened: run::Opened, program: &Program, requires_values: bool| {
            let is_stamped = emit::is_stamped(opened.source.bytes());
            let rapid_order = if is_stamped { RapidOrder::None } else { RapidOrder::Stated };
            // If the control corrects the wear, the original contains none.
            let radius = if has_wear_alone && !is_stamped { Radius::Beside(0.0) } else { Radius::Whole };
            let options = Options {
                rapid_order,
                radius,
                requires_values,
                keeps_tilt: true,
                keeps_cycles: true,
                fits_arcs: true,
                ..Options::default()
            };
            program.start_as(opened, &chosen.machine, options)
        };
        let mut promise = stamp::promise(sources, chosen, self.promised, findings);
        if let Some(promise) = &mut promise {
            // The increment of a program in inches differs.
            let mut machine = chosen.machine.clone();
            machine.control.increment_mm = promise.increment_mm.unwrap_or(machine.control.increment_mm);
            run::keep_unit(&sources[0], original.dialect, false, &mut machine);
            promise.increment_mm = Some(path::Increments::new(&machine.control).linear_mm);
            promise.in_axes |= emit::entry(corrected.dialect.name).is_some_and(|entry| !entry.has_transformation);
        }
        let is_marked = emit::is_stamped(sources[1].bytes()) && !emit::is_stamped(sources[0].bytes());
        let grouping = if is_marked { Grouping::ByMarks } else { Grouping::ByPlace };
        let feeds = [&original, &corrected]
            .map(|opened| emit::entry(opened.dialect.name).map_or(Feeds::default(), |entry| entry.feeds));
        let is_inch = run::is_inch(&sources[1], corrected.dialect);
        let assumed = emit::entry(corrected.dialect.name).map_or("", |entry| entry.assumed);
        let (filler, ahead) = channel();
        std::thread::scope(|scope| {
            // One thread executes the corrected program ahead; the other one executes the original and compares.
            let run = move || send(start(corrected, self.programs[1], false), filler);
            let thread = scope.spawn(run);
            // With an unknown zero or tool, the errors of the machine at the cut are unknown, and so is any verdict. Another one in the corrected
            // program is a difference.
            let mut original = start(original, self.programs[0], true);
            if let Some(watch) = self.watch {
                original = original.watched(watch());
            }
            let stated = self.programs[0].reading().start;
            let how = How {
                of_path: path::How { grouping, feeds, promise, start: stated },
                at_feed: self.at_feed,
                requires_coverage: self.requires_coverage,
                start: stated,
                assumed: if is_marked { assumed } else { "" },
                is_inch,
            };
            walk((original, ahead), &how, chosen, findings, see, || {
                thread.join().unwrap_or_else(|fault| resume_unwind(fault))
            })
        })
    }
}

/// An element, or a diagnostic with the files in which it may be.
type Item = Result<Element, (Diagnostic, Vec<Source>)>;

/// Executes a program to its end, or until the receiver stops, and returns its files.
fn send(mut running: Running<'_>, to: BatchSender<Item>) -> Vec<Source> {
    let items = std::iter::from_fn(|| {
        let item = running.next()?;
        Some(item.map_err(|finding| (finding, running.sources().to_vec())))
    });
    to.put_all(items);
    running.sources().to_vec()
}

/// Options of the comparison of two programs.
struct How {
    of_path: path::How,
    at_feed: bool,
    requires_coverage: bool,
    start: Option<AxisVector>,
    /// Settings of the corrected program before its first move.
    assumed: &'static str,
    /// True if the corrected program is in inches.
    is_inch: bool,
}

/// Compares two running programs; `files` ends the corrected one and returns its files.
fn walk(
    (mut original, corrected): (Running<'_>, BatchReceiver<Item>),
    how: &How,
    chosen: &Machine,
    findings: &mut Diagnostics,
    see: &mut dyn FnMut(Follow<'_>),
    files: impl FnOnce() -> Vec<Source>,
) -> Option<Outcome> {
    let model = chosen.model();
    let increments = [chosen.machine.control.increment_mm, chosen.machine.control.increment_rad];
    let written_mm = how.of_path.promise.and_then(|promise| promise.increment_mm);
    let rounding_mm = written_mm.map_or(0.0, |linear_mm| {
        path::Increments { linear_mm, ..path::Increments::new(&chosen.machine.control) }.rounding_mm()
    });
    let kinematics = Kinematics::new(&chosen.machine);
    let mut beyond: BTreeMap<Axis, (u64, u32)> = BTreeMap::new();
    let mut see = |follow: Follow<'_>| {
        if let Some(axis) = kinematics.beyond_travel(&follow.command) {
            beyond.entry(axis).or_insert((0, follow.corrected.line)).0 += 1;
        }
        see(follow);
    };
    let mut differences: Vec<ProgramDifference> = Vec::new();
    let mut differ = |difference: ProgramDifference| {
        if differences.len() < differences::MOST {
            differences.push(difference);
        }
    };
    let shared = RefCell::new(std::mem::take(findings));
    let items = std::iter::from_fn(|| {
        let item = original.next()?;
        Some(item.map_err(|finding| (finding, original.sources().to_vec())))
    });
    let options = path::CorrectionOptions { start: how.start, ..path::CorrectionOptions::default() };
    let servo = chosen.machine.servo.as_ref().filter(|_| how.at_feed);
    let driven = || servo.map(|servo| Driven::new(&chosen.machine, servo, &model, &options));
    let (result, driven, headers) = {
        let mut original = Clean { items, findings: &shared, mark: 0, driven: driven(), header: Header::default() };
        let mut corrected = Clean {
            items: corrected,
            findings: &shared,
            mark: OF_CORRECTED,
            driven: driven(),
            header: Header::default(),
        };
        let result = path::compare_seeing(
            &mut original,
            &mut corrected,
            how.of_path,
            &chosen.machine,
            &model,
            (&mut see, &mut differ),
        );
        (result, [original.driven, corrected.driven], [original.header, corrected.header])
    };
    let sources = [original.sources().to_vec(), files()];
    let source = |marked: FileId| {
        let marks = [0, OF_CORRECTED];
        let mut all = sources.iter().zip(marks).flat_map(|(own, mark)| own.iter().map(move |one| (one, mark)));
        all.find(|(one, mark)| one.id().0 ^ mark == marked.0).map(|(one, _)| one.clone())
    };
    let max_at = result.as_ref().ok().and_then(|comparison| comparison.max_at);
    let max_at = max_at.and_then(|origin| Some((origin.line, source(origin.file)?.name().to_owned())));
    *findings = shared.into_inner();
    let mut told = Vec::new();
    for mut one in differences {
        one.corrected.file.0 ^= OF_CORRECTED;
        told.push(differences::diagnostic(&one, [&sources[0], &sources[1]]));
    }
    if let Some(corrected) = sources[1].first().filter(|source| emit::is_stamped(source.bytes())) {
        told.extend(differences::skipped(corrected));
        if !how.assumed.is_empty() {
            told.extend(differences::assigned(corrected));
        }
        let lacks = headers[1].lacks(&headers[0], how.assumed, corrected);
        told.extend(lacks.into_iter().map(|word| differences::unstated(word, corrected)));
    }
    match result {
        Ok(comparison) => {
            let heads = head::in_use(chosen, &model, original.extent());
            let (coverage, gaps) = coverage::of_run(&heads[0].chosen, original.extent(), how.requires_coverage);
            let tolerance_mm = path::CorrectionOptions::default().tolerance_mm;
            let zeros = head::zeros(&heads, original.extent(), tolerance_mm, findings);
            let prediction =
                interval::of_run(&heads, &model, [&comparison.before, &comparison.after], &comparison.places);
            let (refused, noted) = if how.requires_coverage { (gaps, Vec::new()) } else { (Vec::new(), gaps) };
            findings.extend(noted, &sources[0]);
            let machine = MachineUsed {
                name: chosen.machine.name.clone(),
                model: chosen.hash.clone(),
                state: chosen.state.clone(),
            };
            let [original, corrected] = driven;
            let fed = original.zip(corrected).map(|pair| {
                let of = |k: usize| {
                    let own: &[Source] = &sources[k];
                    |file: FileId| own.iter().find(|source| source.id() == file).cloned()
                };
                [pair.0.finish(of(0)), pair.1.finish(of(1))]
            });
            Some(Outcome {
                comparison,
                max_at,
                sources,
                increments,
                rounding_mm,
                is_inch: how.is_inch,
                beyond,
                machine,
                at_feed: fed,
                coverage,
                prediction,
                zeros,
                refused,
                differences: told,
            })
            .filter(|_| !findings.has_errors())
        }
        Err(mut divergences) => {
            // If a program could not be executed to its end, differences at the end are expected, but earlier ones
            // are reported; a missing line leads to an impossible arc.
            if findings.has_errors() {
                let line = divergences
                    .first()
                    .and_then(|divergence| divergence.corrected)
                    .map_or(0, |origin| origin.line as usize);
                let is_later = |(code, place): (Code, Option<usize>)| {
                    place.is_some_and(|place| place >= line || ARCS.contains(&code))
                };
                if line == 0 || !findings.errors_in(&sources[1]).all(is_later) {
                    return None;
                }
                divergences.truncate(1);
            }
            findings.extend(told, &sources[1]);
            for divergence in divergences {
                let name = |origin: &Origin| differences::line(origin, source(origin.file).as_ref());
                let mut diagnostic = divergence.diagnostic(name);
                let source = diagnostic.place.and_then(|place| source(place.file));
                if let (Some(place), Some(source)) = (&mut diagnostic.place, &source) {
                    place.file = source.id();
                }
                findings.add(diagnostic, source.as_slice());
            }
            None
        }
    }
}

/// Diagnostics for impossible arcs.
const ARCS: &[Code] = &[Code::ARC_OFF_CIRCLE, Code::RADIUS_TOO_SMALL];

/// The result of a comparison.
pub(crate) struct Outcome {
    pub(crate) comparison: path::Comparison,
    /// Line and file of the largest remaining error.
    pub(crate) max_at: Option<(u32, String)>,
    /// The files of the original, and those of the corrected program.
    pub(crate) sources: [Vec<Source>; 2],
    /// Increments of the control, mm and rad.
    pub(crate) increments: [f64; 2],
    /// Tip displacement by which the increments of the corrected program round its positions, mm; 0 without a stamp.
    pub(crate) rounding_mm: f64,
    /// True if the corrected program is in inches.
    pub(crate) is_inch: bool,
    /// Pieces of the corrected program that end outside the travel of an axis: their number, and the line of the
    /// first one.
    pub(crate) beyond: BTreeMap<Axis, (u64, u32)>,
    pub(crate) machine: MachineUsed,
    /// Differences that are not corrections, as diagnostics for the corrected program.
    pub(crate) differences: Vec<Diagnostic>,
    /// Path deviations of both at feed, if requested.
    pub(crate) at_feed: Option<[AtFeed; 2]>,
    /// The coverage of the original by the measured ranges.
    pub(crate) coverage: CoverageReport,
    /// The interval of the errors; `None` without errors.
    pub(crate) prediction: Option<PredictionReport>,
    /// The zero offsets of the original.
    pub(crate) zeros: Vec<ZeroReport>,
    /// Gaps in the coverage that are not permitted.
    pub(crate) refused: Vec<Diagnostic>,
}

/// The machine on which they were executed.
pub(crate) struct MachineUsed {
    pub(crate) name: String,
    /// Hash of its file.
    pub(crate) model: String,
    /// Hash of its state.
    pub(crate) state: Option<String>,
}

/// Offset of the file numbers of the corrected program. Both programs number their files from 0, and a diagnostic
/// must refer to the right one.
const OF_CORRECTED: u16 = 1 << 15;

/// The elements of a program without its diagnostics, which are stored separately.
struct Clean<'f, 'm, I> {
    items: I,
    findings: &'f RefCell<Diagnostics>,
    mark: u16,
    driven: Option<Driven<'m>>,
    header: Header,
}

impl<I: Iterator<Item = Item>> Iterator for Clean<'_, '_, I> {
    type Item = Element;

    fn next(&mut self) -> Option<Element> {
        loop {
            match self.items.next()? {
                Ok(mut element) => {
                    if let Some(driven) = &mut self.driven {
                        driven.element(&element);
                    }
                    self.header.see(&element);
                    element.origin.file.0 ^= self.mark;
                    return Some(element);
                }
                Err((finding, sources)) => self.findings.borrow_mut().add(finding, &sources),
            }
        }
    }
}

/// The diagnostic for a program that leaves the wear to the control: nothing in its text shows that a register has the radius of the tool in addition.
fn wear_alone(source: &Source) -> Diagnostic {
    let place = Place { file: source.id(), span: Span::new(0, 1) };
    let message = "radius compensation at the control is for wear alone: the radius must be 0 there in each register of G41 and G42, plus wear";
    let help = "set the radius in the register to 0 before the program runs, and restore it before another program uses the register";
    Diagnostic::at(Code::WEAR_ALONE, place, message, help)
}
