//! The correction under suspicion: random machines, programs and options, and a judge that shares nothing with the correction.
//!
//! The emitted text is parsed and executed like any program. The judge moves the tool through both chains of the machine by homogeneous
//! matrices with all errors in them, and compares the tip with where the original has it on the machine without errors: in the interior
//! of pieces and at their ends. `NCFIX_PAIRS` says how many pairs there are, `NCFIX_PAIRS_FROM` the first of them.

mod draw;
mod judge;

use std::collections::BTreeMap;
use std::panic::AssertUnwindSafe;

use ncfix::diagnostic::Diagnostic;
use ncfix::dialect;
use ncfix::emit::{self, Stamp, WriterOptions};
use ncfix::exec::{Execution, NoLibrary, Options as ExecOptions};
use ncfix::geometry::{AXES, AxisVector, Vector};
use ncfix::machine::Machine;
use ncfix::model::Model;
use ncfix::path::{Corrector, Increments, Rapids, Subdivision};
use ncfix::snc::{Element, Kind, Move};
use ncfix::source::{FileId, Source};
use ncfix::syntax;

use self::draw::Pair;
use self::judge::{Judge, Senses};

/// Pairs of a short run.
const PAIRS: u64 = 100;
/// A place that is off by less than this part of the rounding is right; nobody needs to know how right.
const ENOUGH: f64 = 0.25;
/// Places of a piece that are looked at.
const PLACES: usize = 12;
/// The noise of the arithmetic, and what the readings of a program in inches or degrees leave, mm.
const NOISE_MM: f64 = 2e-6;

/// What a program does, by the numbers of its blocks.
type Groups = BTreeMap<u32, Vec<Way>>;

/// A move from where the axes stood.
struct Way {
    start: AxisVector,
    motion: Move,
    /// Takes up the backlash of axes before they go on. The tip is between its places then, and where it should be when the axes that
    /// turn back have moved at all.
    is_on_the_spot: bool,
}

impl Way {
    fn at(&self, fraction: f64) -> AxisVector {
        match &self.motion.arc {
            Some(arc) => arc.at(&self.start, &self.motion.target, fraction),
            None => self.start.lerp(&self.motion.target, fraction),
        }
    }
}

/// The worst of a property over all pairs, as a share of its bound.
#[derive(Default)]
struct Worst(BTreeMap<&'static str, (f64, u64)>);

impl Worst {
    fn note(&mut self, property: &'static str, value: f64, bound: f64, seed: u64, what: &dyn std::fmt::Display) {
        let share = value / bound;
        let worst = self.0.entry(property).or_insert((0.0, seed));
        if share > worst.0 {
            *worst = (share, seed);
        }
        assert!(share <= 1.0, "pair {seed}: {property} {value:e}, bound {bound:e}: {what}");
    }
}

fn execute(text: &str, dialect: &str, machine: &Machine) -> (Vec<Element>, Vec<Diagnostic>) {
    let source = Source::new(FileId(0), "pair", text.as_bytes().to_vec()).unwrap();
    let (program, mut found) = syntax::parse(&source, dialect::find(dialect).unwrap());
    let mut elements = Vec::new();
    let strict = ExecOptions { strict: true, ..ExecOptions::default() };
    for item in Execution::new(program, machine, Box::new(NoLibrary), strict) {
        match item {
            Ok(element) => elements.push(element),
            Err(finding) => found.push(finding),
        }
    }
    (elements, found)
}

/// The text of the correction, and what was found.
fn corrected(pair: &Pair) -> (String, Vec<Diagnostic>) {
    let model = Model::new(&pair.machine, &pair.model());
    let source = Source::new(FileId(0), "pair", pair.program.as_bytes().to_vec()).unwrap();
    let (program, _) = syntax::parse(&source, dialect::find(pair.dialect).unwrap());
    let strict = ExecOptions { strict: true, ..ExecOptions::default() };
    let execution = Execution::new(program, &pair.machine, Box::new(NoLibrary), strict);
    let mut corrector = Corrector::new(execution, &pair.machine, &model, pair.options.clone());
    let writer_options = WriterOptions {
        names: pair.machine.written_names(),
        increments: Increments::new(&pair.machine.control),
        frame: pair.options.frame,
        crlf: false,
        stamp: Stamp::default(),
        last_block_number: None,
    };
    let mut writer = emit::writer(pair.dialect, &writer_options).unwrap();
    let (mut out, mut found) = (Vec::new(), Vec::new());
    emit::emit(&mut corrector, writer.as_mut(), &mut out, |finding| found.push(finding)).unwrap();
    (String::from_utf8(out).unwrap(), found)
}

/// The moves of a stream by the block number in force.
fn groups(elements: &[Element]) -> Groups {
    let mut groups = Groups::new();
    let (mut at, mut number, mut is_on_the_spot) = (AxisVector::ZERO, 0, false);
    for element in elements {
        if element.starts_block {
            is_on_the_spot = false;
        }
        if let Kind::Comment(text) = &element.kind {
            is_on_the_spot = text.contains(&b'~');
        }
        number = element.number.map_or(number, |found| found.number);
        if let Kind::Move(motion) = &element.kind {
            groups.entry(number).or_default().push(Way { start: at, motion: *motion, is_on_the_spot });
            at = motion.target;
        }
    }
    groups
}

/// The ideal way of a block in the workpiece.
struct Ideal<'a> {
    judge: &'a Judge<'a>,
    ways: &'a [Way],
    /// Points of it with their way and the parameter there, dense enough to find the nearest place.
    points: Vec<(usize, f64, Vector)>,
}

impl<'a> Ideal<'a> {
    fn new(judge: &'a Judge<'a>, ways: &'a [Way]) -> Ideal<'a> {
        let mut ideal = Ideal { judge, ways, points: Vec::new() };
        for (part, way) in ways.iter().enumerate() {
            let count = if way.motion.arc.is_some() { 64 } else { 8 };
            for k in 0..=count {
                let parameter = f64::from(k) / f64::from(count);
                ideal.points.push((part, parameter, ideal.at(part, parameter)));
            }
        }
        ideal
    }

    fn at(&self, part: usize, parameter: f64) -> Vector {
        self.judge.ideal(&self.ways[part].at(parameter))
    }

    /// Distance of a point from the way, mm: Newton's iteration for the foot of the perpendicular, from the nearest of the points. A place
    /// that is nearer than `enough_mm` ends the search.
    fn distance_mm(&self, point: &Vector, enough_mm: f64) -> f64 {
        // Both ends of a circle may be near, and both sides of a point: the nearest few, by one pass.
        let mut near = [(f64::INFINITY, 0); 5];
        for (index, (_, _, place)) in self.points.iter().enumerate() {
            let away = (place - point).norm_squared();
            if away < near[4].0 {
                let slot = near.partition_point(|&(other, _)| other <= away);
                near[slot..].rotate_right(1);
                near[slot] = (away, index);
            }
        }
        let from = |index: usize| {
            let (part, mut parameter, mut place) = self.points[index];
            let mut best = (place - point).norm();
            for _ in 0..4 {
                const STEP: f64 = 1e-5;
                let tangent = (self.at(part, (parameter + STEP).min(1.0)) - self.at(part, (parameter - STEP).max(0.0)))
                    / ((parameter + STEP).min(1.0) - (parameter - STEP).max(0.0));
                if tangent.norm_squared() == 0.0 {
                    break;
                }
                parameter = (parameter + (point - place).dot(&tangent) / tangent.norm_squared()).clamp(0.0, 1.0);
                place = self.at(part, parameter);
                best = best.min((place - point).norm());
            }
            best
        };
        let mut least = f64::INFINITY;
        for &(_, index) in near.iter().filter(|(away, _)| away.is_finite()) {
            if least < enough_mm {
                break;
            }
            least = least.min(from(index));
        }
        least
    }
}

/// Judges one pair; the code of the finding where it was refused.
fn judge(pair: &Pair, worst: &mut Worst) -> Option<String> {
    let seed = pair.seed;
    let (original, found) = execute(&pair.program, pair.dialect, &pair.machine);
    assert!(found.is_empty(), "pair {seed}: {found:?}\n{}", pair.program);
    let (text, found) = corrected(pair);
    if let Some(error) = found.iter().find(|finding| finding.is_error()) {
        return Some(error.code.to_string());
    }
    let missed = !found.is_empty();
    let (emitted, found) = execute(&text, pair.dialect, &pair.machine);
    let context = format!("{:?}\n{}\n{text}", pair.options, pair.program);
    assert!(found.is_empty(), "pair {seed}: the corrected program has {found:?}\n{context}");
    let judge = Judge::new(pair);
    let (original, emitted) = (groups(&original), groups(&emitted));
    let increment_mm = pair.machine.control.increment_mm;
    let rounding_mm = 3.0_f64.sqrt() / 2.0 * increment_mm;
    // Rounding alone may exceed the tolerance; then a bend may add a tenth of it.
    let bound_mm = pair.options.tolerance_mm.max(1.1 * rounding_mm) + NOISE_MM;
    let mut senses = Senses::new(&pair.machine);
    for (number, ways) in &emitted {
        let nominal = &original[number];
        let ideal = Ideal::new(&judge, nominal);
        let rapid = ways[0].motion.rapid;
        let is_known = nominal.iter().all(|way| way.motion.named.difference(way.motion.known).is_empty());
        let mut largest_error_mm = 0.0_f64;
        for way in nominal {
            for k in 0..=8 {
                let command = way.at(f64::from(k) / 8.0);
                largest_error_mm =
                    largest_error_mm.max((judge.actual(&command, &senses.certain) - judge.ideal(&command)).norm());
            }
        }
        let first = *number == draw::FIRST_MOVE;
        for way in ways {
            let mut last = way.start;
            for k in 1..=PLACES {
                let fraction = k as f64 / PLACES as f64;
                let command = way.at(fraction);
                if !first {
                    // From which side the first move comes nobody knows.
                    senses.note(&last, &command);
                }
                last = command;
                for data in pair.machine.axes.iter().flatten() {
                    let [low, high] = data.travel.unwrap();
                    let slack = 1e-6;
                    assert!(
                        (low - slack..=high + slack).contains(&command[data.axis]),
                        "pair {seed}: travel\n{context}"
                    );
                }
                // The first move comes from anywhere.
                let at_end = k == PLACES;
                if first && !at_end || way.is_on_the_spot || !is_known || missed {
                    continue;
                }
                let what = format_args!("N{number} to {:?}, {fraction} of it\n{context}", way.motion.target);
                let possible = senses.possible();
                let away_mm = possible
                    .iter()
                    .map(|sense| ideal.distance_mm(&judge.actual(&command, sense), ENOUGH * rounding_mm));
                let away_mm = away_mm.fold(f64::INFINITY, f64::min);
                let is_cut = matches!(pair.options.subdivision, Subdivision::Adaptive);
                if rapid && pair.options.rapids == Rapids::None {
                    // It is left as it is.
                    let turned_mm = judge.rotary_rounding_mm(&command, &senses.certain);
                    worst.note(
                        "rapid left alone",
                        away_mm,
                        largest_error_mm * 1.5 + rounding_mm + turned_mm + NOISE_MM,
                        seed,
                        &what,
                    );
                } else if rapid && pair.options.rapids == Rapids::Ends {
                    // Between ends that are right the tool is off by what the errors change on the way.
                    worst.note("rapid", away_mm, 2.0 * largest_error_mm + bound_mm, seed, &what);
                } else if is_cut {
                    worst.note("tolerance", away_mm, bound_mm, seed, &what);
                } else if at_end && !pair.is_transformed {
                    // Under a transformation a control goes on by chords of its own.
                    let held_mm = held_mm(&judge, way, &senses.certain);
                    worst.note("ends of fixed steps", away_mm, rounding_mm + NOISE_MM + held_mm, seed, &what);
                }
            }
        }
        let (from, to) = (nominal.last().unwrap(), ways.last().unwrap());
        let correction = to.motion.target - from.motion.target;
        for axis in AXES.into_iter().filter(|axis| !axis.is_rotary()) {
            let limit = pair.options.max_correction_mm + increment_mm;
            worst.note("correction", correction[axis].abs(), limit, seed, &context);
        }
        let is_left_alone = rapid && pair.options.rapids == Rapids::None;
        if !is_left_alone && is_known && !missed {
            let place = judge.ideal(&from.motion.target);
            let possible = senses.possible();
            let away_mm = possible.iter().map(|sense| (judge.actual(&to.motion.target, sense) - place).norm());
            let away_mm = away_mm.fold(f64::INFINITY, f64::min);
            worst.note("end of the block", away_mm, bound_mm, seed, &format_args!("N{number}\n{context}"));
        }
        if !rapid && !pair.is_transformed {
            check_feed(nominal, ways, worst, seed, &context);
        }
    }
    assert_eq!(original.keys().collect::<Vec<_>>(), emitted.keys().collect::<Vec<_>>(), "pair {seed}\n{context}");
    None
}

/// What axes that stand may owe to their backlash, mm: one that either sense asks to move the other way stays where it is.
fn held_mm(judge: &Judge, way: &Way, sense: &[i8; 9]) -> f64 {
    let target = &way.motion.target;
    let stands = AXES.into_iter().filter(|&axis| (target[axis] - way.start[axis]).abs() < 1e-9);
    let owed = stands.map(|axis| {
        let mut turned = *sense;
        turned[axis.slot()] = -turned[axis.slot()];
        (judge.actual(target, &turned) - judge.actual(target, sense)).norm()
    });
    owed.sum()
}

/// The feed of all pieces is that of the block; with inverse-time feed they take its time together.
fn check_feed(nominal: &[Way], ways: &[Way], worst: &mut Worst, seed: u64, context: &str) {
    let feed = nominal[0].motion.feed;
    if nominal[0].motion.inverse_time {
        // Steps on the spot take time of their own.
        let time: f64 = ways.iter().filter(|way| !way.is_on_the_spot).map(|way| 1.0 / way.motion.feed).sum();
        let whole: f64 = nominal.iter().map(|way| 1.0 / way.motion.feed).sum();
        worst.note("time of G93", (time / whole - 1.0).abs(), 1e-5, seed, &context);
    } else if nominal.len() == 1 {
        for way in ways {
            worst.note("feed", (way.motion.feed / feed - 1.0).abs(), 1e-5, seed, &context);
        }
    }
}

#[test]
fn what_is_written_is_what_was_promised() {
    let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse::<u64>().ok());
    let (from, count) = (number("NCFIX_PAIRS_FROM").unwrap_or(1), number("NCFIX_PAIRS").unwrap_or(PAIRS));
    let mut worst = Worst::default();
    let mut refused: BTreeMap<String, u64> = BTreeMap::new();
    let mut failed = Vec::new();
    for seed in from..from + count {
        // A long run goes on after a pair that fails; what it says stands in the output of the test.
        let judged = std::panic::catch_unwind(AssertUnwindSafe(|| {
            let pair = Pair::new(seed);
            judge::check_forward(&pair);
            judge(&pair, &mut worst)
        }));
        match judged {
            Ok(None) => (),
            Ok(Some(code)) => *refused.entry(code).or_default() += 1,
            Err(_) => failed.push(seed),
        }
    }
    let total: u64 = refused.values().sum();
    let mut report = format!("{count} pairs, {total} refused {refused:?}");
    for (property, (share, seed)) in &worst.0 {
        report += &format!("\n{property}: {share:.3} of its bound at pair {seed}");
    }
    if let Ok(path) = std::env::var("NCFIX_PAIRS_REPORT") {
        std::fs::write(path, &report).unwrap();
    }
    assert!(failed.is_empty(), "pairs {failed:?}\n{report}");
    assert!(3 * total < count, "{report}");
    // The bounds mean something: the worst comes near.
    assert!(worst.0["tolerance"].0 > 0.5, "{report}");
}
