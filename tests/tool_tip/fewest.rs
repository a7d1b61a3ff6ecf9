//! The fewest pieces of a line of the tip, by dynamic programming, against the number that a correction writes.

use std::fmt::Write as _;
use std::io::Write as _;

use super::{Rig, TipBlock, blocks, fixed, framed, judged, minus, rigs, size};

/// Places of a line at which its error is known; a piece may end at each of them.
const PLACES: usize = 300;
const TOLERANCE_MM: f64 = 1e-3;
/// Beyond this deviation a longer piece is not examined, in tolerances: the error is smooth.
const HOPELESS: f64 = 4.0;

/// The error of the tip along a line, mm: what the words of a piece must follow.
fn errors_along(rig: &Rig, block: &TipBlock) -> Vec<[f64; 3]> {
    let place = |k: usize| {
        let words = block.at(k as f64 / PLACES as f64);
        minus(&rig.tip(&rig.commands(&words), 1.0), &block.tip(k as f64 / PLACES as f64))
    };
    (0..=PLACES).map(place).collect()
}

/// Largest distance of the error from the chord between two places, mm: the words of the ends are corrected, and the tip goes straight.
fn bend_mm(errors: &[[f64; 3]], from: usize, to: usize) -> f64 {
    let off = |k: usize| {
        let share = (k - from) as f64 / (to - from) as f64;
        size(&std::array::from_fn(|row| {
            errors[k][row] - errors[from][row] - share * (errors[to][row] - errors[from][row])
        }))
    };
    (from + 1..to).map(off).fold(0.0, f64::max)
}

/// The fewest pieces whose bends stay within the tolerance, over all ways to choose their ends.
fn fewest(errors: &[[f64; 3]]) -> usize {
    let mut best = vec![usize::MAX; PLACES + 1];
    best[0] = 0;
    for to in 1..=PLACES {
        for from in (0..to).rev() {
            let bend = bend_mm(errors, from, to);
            if bend <= TOLERANCE_MM {
                best[to] = best[to].min(best[from].saturating_add(1));
            }
            if bend > HOPELESS * TOLERANCE_MM {
                break;
            }
        }
    }
    best[PLACES]
}

/// Lines of 60 to 150 mm with turns of 5 to 60 degrees.
fn program(rig: &Rig, control: &str) -> String {
    let [a, b] = rig.rotary.map(char::from);
    let cuts = format!(
        "N50 G0 X-60 Y-50 Z40 {a}5 {b}10\nN60 G1 X60 Y-40 Z35 {a}20 {b}40 F2000\nN70 X50 Y50 Z42 {a}35 {b}95\nN80 X-55 Y45 Z30 {a}12 \
         {b}130\nN90 X-40 Y-45 Z45 {a}28 {b}150\nN100 X0 Y0 {a}6 {b}120\nN110 G0 Z80\n"
    );
    framed(rig, control, &cuts)
}

#[test]
fn pieces_of_the_tip_are_within_a_fifth_of_the_fewest_possible() {
    let mut table = String::new();
    for rig in rigs() {
        let text = program(&rig, "sinumerik");
        let least: Vec<usize> = blocks(&text)
            .iter()
            .filter(|block| block.motion == 1)
            .map(|block| fewest(&errors_along(&rig, block)))
            .collect();
        for control in ["sinumerik", "fanuc"] {
            let text = program(&rig, control);
            let (_, out) = fixed(&rig, control, &text, true);
            let (counts, worst_mm) = judged(&rig, &text, &out);
            let [all, fewest] = [&counts, &least].map(|counts| counts.iter().sum::<usize>());
            writeln!(table, "{} {control}: {counts:?} {least:?} {:.3} um", rig.name, worst_mm * 1e3).unwrap();
            assert!(worst_mm < super::LIMIT_MM, "{table}");
            assert!(all * 5 <= fewest * 6, "{table}");
            // The search knows no rounding and no correction of the rotary axes: nothing beats it by more than one piece a line.
            assert!(all + counts.len() >= fewest, "{table}");
        }
    }
    let _ = writeln!(std::io::stderr(), "{table}");
}

/// With a bend that is the same everywhere, the fewest pieces are the equal ones.
#[test]
fn equal_bends_make_equal_pieces() {
    // The chord of c k² over n places is off by c n² / 4: 60 places fit, 61 do not.
    let c = TOLERANCE_MM / (60.5_f64 * 60.5 / 4.0);
    let errors: Vec<[f64; 3]> = (0..=PLACES).map(|k| [c * (k * k) as f64, 0.0, 0.0]).collect();
    assert_eq!(fewest(&errors), PLACES / 60);
}
