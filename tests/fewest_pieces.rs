//! How few pieces a line can be cut into, by dynamic programming, against how many it is cut into; and what that saves against the fixed
//! step of Spaan (ch. 7) that leaves as much.

use std::fmt::Write as _;
use std::io::Write as _;

use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_machine::machine::{Machine, State};
use ncfix_model::motion::EntryFunction;
use ncfix_model::motion::periodic::Periodic;
use ncfix_model::{ErrorModel, Model};
use ncfix_path::path::{CorrectionOptions, Subdivision};

use crate::bench_machine::{Random, correct, motion, table, tired};
use crate::machines::xyz_machine;

/// Places of a line at which its error is known, and every how many of them a piece may end in the search for the fewest.
const PLACES: usize = 1600;
const ENDS: usize = 4;
const TOLERANCE_MM: f64 = 1e-3;

/// The error of the tip along a straight line, mm: what a piece must follow.
fn errors_along(model: &Model, from: [f64; 3], to: [f64; 3]) -> Vec<Vector> {
    let place = |k: usize| {
        let share = k as f64 / PLACES as f64;
        let mut command = AxisVector::ZERO;
        command.set_xyz(Vector::from(from).lerp(&Vector::from(to), share));
        command
    };
    let tip = |k: usize| {
        let command = place(k);
        let actual = model.actual(&command, &Vector::zeros(), &State::default()).translation;
        actual - model.nominal(&command, &Vector::zeros()).translation
    };
    (0..=PLACES).map(tip).collect()
}

/// How far the error leaves the chord between two places, mm: what is left where the ends are corrected and the axes go straight. Beyond
/// `enough` it is not looked at any more.
fn bend_mm(errors: &[Vector], from: usize, to: usize, enough: f64) -> f64 {
    let mut most = 0.0_f64;
    for k in from + 1..to {
        let share = (k - from) as f64 / (to - from) as f64;
        most = most.max((errors[k] - errors[from].lerp(&errors[to], share)).norm());
        if most > enough {
            break;
        }
    }
    most
}

/// The fewest pieces whose bends stay within the tolerance, over all ways to choose their ends.
fn fewest(errors: &[Vector]) -> usize {
    let ends = PLACES / ENDS;
    let mut best = vec![usize::MAX; ends + 1];
    best[0] = 0;
    for to in 1..=ends {
        for from in (0..to).rev() {
            let pieces = best[from].saturating_add(1);
            if pieces < best[to] && bend_mm(errors, from * ENDS, to * ENDS, TOLERANCE_MM) <= TOLERANCE_MM {
                best[to] = pieces;
            }
        }
    }
    best[ends]
}

/// The largest equal pieces of a line whose bends stay within the tolerance, mm along the axis that moves farthest.
fn step_mm(errors: &[Vector], leading_mm: f64) -> f64 {
    let fits = |pieces: usize| {
        let end = |k: usize| k * PLACES / pieces;
        (0..pieces).all(|k| bend_mm(errors, end(k), end(k + 1), TOLERANCE_MM) <= TOLERANCE_MM)
    };
    let pieces = (1..PLACES / 8).find(|&pieces| fits(pieces)).unwrap();
    leading_mm / pieces as f64
}

/// What a machine was asked for.
#[derive(Default)]
struct Counts {
    fewest: usize,
    adaptive: usize,
    fixed: usize,
}

/// Counts the pieces of lines on a machine.
fn count(machine: &Machine, errors: &ErrorModel, lines: &[([f64; 3], [f64; 3])]) -> Counts {
    let model = Model::new(machine, errors);
    let mut counts = Counts::default();
    let mut step = f64::INFINITY;
    let mut text = String::new();
    for (from, to) in lines {
        let along = errors_along(&model, *from, *to);
        counts.fewest += fewest(&along);
        let leading_mm = (0..3).map(|k| (to[k] - from[k]).abs()).fold(0.0, f64::max);
        step = step.min(step_mm(&along, leading_mm));
        let word = |at: &[f64; 3]| format!("X{} Y{} Z{}", at[0], at[1], at[2]);
        writeln!(text, "G0 {}\nG1 {} F500", word(from), word(to)).unwrap();
    }
    let options =
        CorrectionOptions { tolerance_mm: TOLERANCE_MM, max_correction_mm: 10.0, ..CorrectionOptions::default() };
    let pieces = |subdivision| {
        let run = correct(&text, machine, errors, CorrectionOptions { subdivision, ..options.clone() });
        assert!(run.findings.is_empty(), "{:?}", run.findings);
        (run.pieces.iter().filter(|piece| !piece.rapid).count(), run.prediction.after().max_mm)
    };
    let (adaptive, left_mm) = pieces(Subdivision::Adaptive);
    assert!(left_mm <= TOLERANCE_MM, "{left_mm}");
    counts.adaptive = adaptive;
    // The step of a machine is that of the place that bends most.
    counts.fixed = pieces(Subdivision::Step(step)).0;
    counts
}

/// Lines of 300 to 500 mm through the travel.
fn lines(random: &mut Random, count: usize) -> Vec<([f64; 3], [f64; 3])> {
    let mut place = |low: f64, high: f64| [0, 1, 2].map(|_| random.between(low, high).round());
    (0..count).map(|_| (place(0.0, 60.0), place(400.0, 500.0))).collect()
}

#[test]
fn pieces_are_within_a_tenth_of_the_fewest_possible() {
    let machine = xyz_machine();
    let mut random = Random(7);
    let mut all = Counts::default();
    for case in 0..4 {
        let mut errors = tired(&mut random);
        // Ten times as tired, so that a line takes tens of pieces.
        let grown = errors.motion.iter_mut();
        grown.for_each(|error| error.function = error.function.scaled(12.0));
        if case == 2 {
            let knots: Vec<f64> = (0..=50).map(|k| f64::from(k) * 10.0).collect();
            let values: Vec<f64> = knots.iter().map(|_| random.between(-6.0, 6.0)).collect();
            errors.motion.push(motion("EYX", table(&knots, &values)));
        }
        if case == 3 {
            let screw = Periodic { period: 40.0, amplitude: 0.006, phase_rad: 0.3 };
            errors.motion.push(motion("EZX", EntryFunction::Periodic(screw)));
        }
        let counts = count(&machine, &errors, &lines(&mut random, 4));
        let (most, least) = (counts.adaptive as f64, counts.fewest as f64);
        assert!(counts.fewest > 40, "too few pieces to tell: {}", counts.fewest);
        assert!(most <= 1.1 * least, "case {case}: {most} pieces, {least} are possible");
        // The search knows ends on a grid and no rounding: what beats it by more would not keep the tolerance.
        assert!(most >= 0.97 * least, "case {case}: {most} pieces, {least} are possible");
        let figures = format!("case {case}: fewest {least}, adaptive {most}, fixed step {}", counts.fixed);
        writeln!(std::io::stderr(), "{figures}").unwrap();
        all.fewest += counts.fewest;
        all.adaptive += counts.adaptive;
        all.fixed += counts.fixed;
    }
    assert!(all.fixed as f64 > 1.3 * all.adaptive as f64, "{} {}", all.fixed, all.adaptive);
}

/// The places at which dynamic programming may cut are the only thing that it does not know: with a bend that is the same everywhere the
/// fewest pieces are the equal ones, and both find them.
#[test]
fn equal_bends_make_equal_pieces() {
    let machine = xyz_machine();
    // The chord of a x² over s is off by a s² / 4: a little less than 1 µm at 20 mm.
    let a = 0.99 * 4.0 * TOLERANCE_MM / 400.0;
    let errors = ErrorModel {
        motion: vec![motion("EXX", crate::bench_machine::polynomial(&[0.0, -500.0 * a, a]))],
        ..ErrorModel::default()
    };
    let model = Model::new(&machine, &errors);
    let along = errors_along(&model, [0.0, 100.0, 100.0], [500.0, 100.0, 100.0]);
    assert_eq!(fewest(&along), 25);
    assert_eq!((step_mm(&along, 500.0) * 10.0).round(), 200.0);
    let run = correct(
        "G0 X0 Y100 Z100\nG1 X500 F500\n",
        &machine,
        &errors,
        CorrectionOptions { max_correction_mm: 1.0, ..CorrectionOptions::default() },
    );
    // A little is kept for what lies between the samples, and for rounding.
    let ends: Vec<f64> = run.pieces.iter().map(|piece| piece.nominal[Axis::X]).collect();
    assert!((25..=27).contains(&(ends.len() - 1)), "{ends:?}");
}
