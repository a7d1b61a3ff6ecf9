//! Paths through the singularity of a five-axis machine, where a small tilt takes a large motion of C (Lei & Hsu 2003, 4.1): the position is
//! exact, and rotary corrections change little from block to block.

use std::f64::consts::PI;

use ncfix_base::geometry::{Axis, AxisVector, ROTARY_AXES, Vector};
use ncfix_machine::machine::{Machine, State};
use ncfix_machine::snc::{Element, Kind, TextReader};
use ncfix_model::{ErrorModel, LocationError, Model};
use ncfix_path::path::{CorrectionOptions, Piece, Rapids, Rotary, Subdivision};

use crate::bench_machine::{Replay, Run, backlash, correct, motion, polynomial};
use crate::lei_hsu::machine;
use crate::support::Shop;

/// What is documented: the most that a block changes a rotary correction near the singularity, rad.
const LIMIT_RAD: f64 = 5e-4;
/// Two roundings to half an increment of 1e-4°, and the accuracy with which the nominal place is found again here.
const NOISE_RAD: f64 = 4e-6;

/// Tilts of A, C and Z as in the rotary block of Lei & Hsu, and an offset of C.
fn errors() -> ErrorModel {
    let rows =
        [("EA0C", 120e-6), ("EB0C", -90e-6), ("EB0A", 150e-6), ("EC0A", 80e-6), ("EB0Z", -60e-6), ("EY0C", 0.02)];
    let location = rows.map(|(name, value)| LocationError { name: name.parse().unwrap(), value });
    ErrorModel { location: location.to_vec(), ..ErrorModel::default() }
}

fn options() -> CorrectionOptions {
    // Corrections of C count at the tip.
    CorrectionOptions { max_correction_mm: 2.0, rotary: Rotary::Correct, ..CorrectionOptions::default() }
}

/// Ends of the moves of a text.
fn ends(text: &str) -> Vec<AxisVector> {
    let target = |element: Element| match element.kind {
        Kind::Move(motion) => Some(motion.target),
        _ => None,
    };
    TextReader::new(text).filter_map(|element| target(element.unwrap())).collect()
}

/// What a block does, found from its counts and the chain alone.
#[derive(Clone, Copy, Debug)]
struct Block {
    /// The nominal place at its end.
    nominal: AxisVector,
    /// Correction at its end.
    correction: AxisVector,
    /// Largest distance of the tip from the programmed path within it, mm.
    off_mm: f64,
    /// Tilt of the tool axis at its end, rad.
    tilt_rad: f64,
    take_up: bool,
}

/// The blocks of the feed moves of a run of straight moves.
fn blocks(run: &Run, text: &str, machine: &Machine, errors: &ErrorModel) -> Vec<Block> {
    let ends = ends(text);
    blocks_along(run, machine, errors, |number, share| ends[number - 1].lerp(&ends[number], share))
}

/// The blocks of the feed moves of a run. The place on the programmed path that belongs to a command is the one whose nominal tip is
/// nearest to its actual tip.
fn blocks_along(
    run: &Run,
    machine: &Machine,
    errors: &ErrorModel,
    path: impl Fn(usize, f64) -> AxisVector,
) -> Vec<Block> {
    let (ideal, model) = (Model::new(machine, &ErrorModel::default()), Model::new(machine, errors));
    let tool = Vector::zeros();
    let (mut replay, mut out) = (Replay::new(machine), Vec::new());
    let (mut moves, mut at) = (0, 0.0);
    for piece in &run.pieces {
        if piece.first {
            (moves, at) = (moves + 1, 0.0);
        }
        let follow = replay.follow(piece, if piece.take_up { 1 } else { 8 });
        if piece.rapid {
            continue;
        }
        let place = |share: f64| path(moves - 1, share);
        let tip_at = |share: f64| ideal.nominal(&place(share), &tool).translation;
        let mut block = None;
        for (command, state) in follow {
            let tip = model.actual(&command, &tool, &state).translation;
            for _ in 0..if piece.take_up { 0 } else { 12 } {
                let slope = (tip_at(at + 1e-6) - tip_at(at - 1e-6)) / 2e-6;
                at += slope.dot(&(tip - tip_at(at))) / slope.norm_squared();
            }
            let nominal = place(at);
            let (target, reached) = (ideal.nominal(&nominal, &tool), model.actual(&command, &tool, &state));
            let off_mm = (reached.translation - target.translation).norm();
            let block = block.get_or_insert(Block {
                nominal,
                correction: AxisVector::ZERO,
                off_mm: 0.0,
                tilt_rad: 0.0,
                take_up: piece.take_up,
            });
            (block.nominal, block.correction, block.off_mm) = (nominal, command - nominal, block.off_mm.max(off_mm));
            block.tilt_rad = (reached.rotation.column(2) - target.rotation.column(2)).norm();
        }
        out.extend(block);
    }
    out
}

/// The largest change of a rotary correction from one block to the next, rad.
fn largest_change(blocks: &[Block]) -> f64 {
    let change = |pair: &[Block]| (pair[1].correction - pair[0].correction).max_abs(&ROTARY_AXES);
    blocks.windows(2).map(change).fold(0.0, f64::max)
}

/// A through the pole from −5° to 5° in one block, with C at rest in several places and turning, and the tip near the axis and far away.
const PATHS: [&str; 6] = [
    "G1 X20 Y60 Z150 A-5 C0 F500\nG1 X20 Y80 Z150 A5 C0 F500\n",
    "G1 X20 Y60 Z150 A-5 C70 F500\nG1 X-20 Y60 Z150 A5 C70 F500\n",
    "G1 X120 Y-60 Z150 A-5 C200 F500\nG1 X130 Y-60 Z120 A5 C200 F500\n",
    "G1 X1 Y0 Z3 A-5 C0 F500\nG1 X2 Y0 Z2 A5 C0 F500\n",
    "G1 X50 Y60 Z150 A-5 C0 F500\nG1 X50 Y80 Z150 A5 C360 F500\n",
    "G1 X50 Y60 Z150 A-5 C-30 F500\nG1 X50 Y70 Z150 A0 C-30 F500\nG1 X50 Y90 Z150 A0 C150 F500\nG1 X60 Y80 Z150 A5 C150 F500\n",
];

#[test]
fn through_the_pole_the_position_is_exact_and_rotary_corrections_are_limited() {
    let (machine, errors) = (machine(), errors());
    let model = Model::new(&machine, &errors);
    for path in PATHS {
        let text = path.replacen("G1", "G0", 1).replacen(" F500", "", 1);
        let run = correct(&text, &machine, &errors, options());
        assert!(run.findings.is_empty(), "{:?}", run.findings);
        assert!(run.prediction.after().max_mm <= 1e-3, "{path}: {:?}", run.prediction.after());
        let blocks = blocks(&run, &text, &machine, &errors);
        let (least, most) = blocks
            .iter()
            .map(|block| block.correction[Axis::C])
            .fold((0.0_f64, 0.0_f64), |(a, b), c| (a.min(c), b.max(c)));
        let change = largest_change(&blocks);
        assert!(most - least > 4.0 * LIMIT_RAD, "the limit has work to do: {least} to {most}");
        assert!(change < LIMIT_RAD + NOISE_RAD, "{path}: {change}");
        for block in &blocks {
            // The tolerance.
            assert!(block.off_mm < 1e-3, "{path}: {block:?}");
            let uncorrected = {
                let [target, reached] = [
                    model.nominal(&block.nominal, &Vector::zeros()),
                    model.actual(&block.nominal, &Vector::zeros(), &State::default()),
                ];
                (reached.rotation.column(2) - target.rotation.column(2)).norm()
            };
            // Cut finely enough, the correction keeps up: it never tilts the tool more than no correction would, and from 2.9° on it
            // is complete but for the increments.
            assert!(block.tilt_rad < uncorrected + 2e-6, "{path}: {block:?} {uncorrected}");
            if !model.is_near_singularity(&block.nominal, &Vector::zeros()) {
                assert!(block.tilt_rad < 2e-6, "{path}: {block:?}");
            }
        }
    }
}

/// C turns along an arc while A stands at 2°: arcs become shorter arcs.
#[test]
fn arcs_are_limited_too() {
    let machine = machine();
    // A tilt of the face of the table goes round with C.
    let errors = ErrorModel { motion: vec![motion("EBC", polynomial(&[150e-6]))], ..errors() };
    let text = "G0 X60 Y0 Z150 A2 C0\nG3 X-60 Y0 Z150 A2 C150 I-60 J0 P17 F500\n";
    let run = correct(text, &machine, &errors, options());
    assert!(run.findings.is_empty() && run.prediction.after().max_mm <= 1e-3);
    let blocks = blocks_along(&run, &machine, &errors, |_, share| {
        let (sine, cosine) = (PI * share).sin_cos();
        let turns = [2.0, 0.0, 150.0 * share].map(f64::to_radians);
        AxisVector([60.0 * cosine, 60.0 * sine, 150.0, 0.0, 0.0, 0.0, turns[0], turns[1], turns[2]])
    });
    let way = blocks[blocks.len() - 1].correction[Axis::C] - blocks[0].correction[Axis::C];
    assert!(way.abs() > 4.0 * LIMIT_RAD, "{way}");
    assert!(largest_change(&blocks) < LIMIT_RAD + NOISE_RAD, "{blocks:#?}");
    assert!(blocks.iter().all(|block| block.off_mm < 1e-3), "{blocks:#?}");
    assert!(run.pieces[1..].iter().any(|piece| piece.arc.is_some()));
}

/// A reverses at 1.5° with a lateral play: the correction of C would jump. It is limited on the spot and in the blocks behind it.
#[test]
fn a_jump_of_the_errors_is_spread_over_blocks() {
    let machine = machine();
    let errors = ErrorModel { motion: vec![motion("EBA", backlash(0.08))], ..errors() };
    let text = "G0 X20 Y60 Z150 A-1 C0\nG1 X20 Y70 Z150 A1.5 C0 F500\nG1 X20 Y75 Z150 A1.2 C0 F500\nG1 X20 Y80 Z150 A0.9 C0 F500\n\
                G1 X20 Y85 Z150 A0.6 C0 F500\nG1 X20 Y90 Z150 A0.3 C0 F500\n";
    let run = correct(text, &machine, &errors, options());
    assert!(run.findings.is_empty(), "{:?}", run.findings);
    let blocks = blocks(&run, text, &machine, &errors);
    // The play is taken up at the start, too.
    let reversal = blocks.iter().rposition(|block| block.take_up).expect("the tip moves at the reversal");
    assert!(reversal > 2, "{blocks:#?}");
    // Damped, a tilt takes s / (s² + λ²) of C, λ² = ε² (1 − s²/ε²)², ε = 0.05: 13.1 times 80 µrad where A reverses, 6.9 times at 0.9°.
    let motion_of_c = |degrees: f64| {
        let (s, e) = (degrees.to_radians().sin(), 0.05_f64);
        s / (s * s + e * e * (1.0 - s * s / (e * e)).powi(2))
    };
    assert!(80e-6 * motion_of_c(1.5) > 2.0 * LIMIT_RAD, "{}", motion_of_c(1.5));
    let at = |blocks: &[Block]| {
        let [low, high] = [0, 1].map(|k| (blocks[k].nominal[Axis::A].to_degrees(), blocks[k].correction[Axis::C]));
        low.1 + (high.1 - low.1) * (0.9 - low.0) / (high.0 - low.0)
    };
    let is_around = |pair: &&[Block]| {
        (pair[0].nominal[Axis::A].to_degrees() - 0.9) * (pair[1].nominal[Axis::A].to_degrees() - 0.9) <= 0.0
    };
    let up = blocks[..reversal].windows(2).find(is_around).map(at).unwrap();
    let down = blocks[reversal..].windows(2).rfind(is_around).map(at).unwrap();
    let play = up - down;
    assert!((play - 80e-6 * motion_of_c(0.9)).abs() < 3e-5, "made up for at 0.9°: {play}");
    assert!(largest_change(&blocks) < LIMIT_RAD + NOISE_RAD, "{blocks:#?}");
    // The play itself is gone when A moves, behind the step on the spot.
    assert!(blocks.iter().all(|block| block.take_up || block.off_mm < 1e-3), "{blocks:#?}");
    assert!(blocks.len() < 40, "a jump is not climbed in splinters: {}", blocks.len());
}

/// With a fixed step pieces are not cut for it; the limit holds all the same, and the position.
#[test]
fn pieces_of_a_fixed_step_are_limited_too() {
    let (machine, errors) = (machine(), errors());
    let text = "G0 X20 Y60 Z150 A-2.5 C0\nG1 X20 Y80 Z150 A2.5 C0 F500\n";
    let run = correct(text, &machine, &errors, CorrectionOptions { subdivision: Subdivision::Step(5.0), ..options() });
    let blocks = blocks(&run, text, &machine, &errors);
    assert_eq!(blocks.len(), 4);
    assert!(largest_change(&blocks) < LIMIT_RAD + NOISE_RAD, "{blocks:#?}");
    let model = Model::new(&machine, &errors);
    for piece in &run.pieces[1..] {
        // Each end exactly, whatever C is.
        let block = blocks
            .iter()
            .find(|block| (piece.command - block.nominal - block.correction).max_abs(&ROTARY_AXES) < 1e-12);
        let off = model.tip_error_mm(&block.unwrap().nominal, &piece.command, &Vector::zeros(), &State::default());
        assert!(off.norm() < 2e-4, "{off}");
    }
}

/// A rapid move brings the orientation that the cut behind it begins with; treated like a feed move it is cut and limited.
#[test]
fn rapid_moves_arrive_with_the_whole_correction() {
    let (machine, errors) = (machine(), errors());
    let text = "G0 X20 Y60 Z150 A-2.5 C0\nG0 X20 Y60 Z150 A2.5 C0\nG1 X21 Y60 Z150 A2.5 C0 F500\n";
    let at_ends = |run: &Run| -> Vec<f64> { run.pieces.iter().map(|piece: &Piece| piece.command[Axis::C]).collect() };
    let ends = at_ends(&correct(text, &machine, &errors, options()));
    assert!((ends[1] - ends[0]).abs() > 4.0 * LIMIT_RAD && (ends[2] - ends[1]).abs() < 0.1 * LIMIT_RAD, "{ends:?}");
    let ends = at_ends(&correct(text, &machine, &errors, CorrectionOptions { rapids: Rapids::All, ..options() }));
    assert!(
        ends.len() > 6 && ends.windows(2).all(|pair| (pair[1] - pair[0]).abs() < LIMIT_RAD + NOISE_RAD),
        "{ends:?}"
    );
}

/// `--rotary hold`: rotary axes go where the program says, to the increment; the tip is in its place all the same, and the tilt stays.
#[test]
fn held_rotary_axes_keep_their_places_and_the_position_is_corrected() {
    let (machine, errors) = (machine(), errors());
    let model = Model::new(&machine, &errors);
    let text = "G0 X20 Y60 Z150 A-5 C30\nG1 X40 Y80 Z150 A5 C120 F500\nG1 X-40 Y30 Z140 A60 C120 F500\nG1 X-40 Y30 Z100 A60 C120 F500\n";
    let held = correct(text, &machine, &errors, CorrectionOptions { rotary: Rotary::Hold, ..options() });
    assert!(held.findings.is_empty() && held.prediction.after().max_mm <= 1e-3);
    assert!(held.prediction.before().max_mm > 0.02);
    let blocks = blocks(&held, text, &machine, &errors);
    for block in &blocks {
        assert!(block.correction.max_abs(&ROTARY_AXES) < NOISE_RAD, "{block:?}");
        assert!(block.off_mm < 1e-3, "{block:?}");
        let [target, reached] = [
            model.nominal(&block.nominal, &Vector::zeros()),
            model.actual(&block.nominal, &Vector::zeros(), &State::default()),
        ];
        let uncorrected = (reached.rotation.column(2) - target.rotation.column(2)).norm();
        assert!((block.tilt_rad - uncorrected).abs() < 3e-6 && uncorrected > 1e-5, "{block:?} {uncorrected}");
    }
    // Exactly the programmed counts at the ends of the moves.
    let ends: Vec<[i64; 2]> =
        held.pieces.iter().filter(|piece| piece.last).map(|piece| [piece.counts[6], piece.counts[8]]).collect();
    assert_eq!(ends, [[-50_000, 300_000], [50_000, 1_200_000], [600_000, 1_200_000], [600_000, 1_200_000]]);
    let corrected = correct(text, &machine, &errors, options());
    assert!(corrected.pieces.iter().filter(|piece| piece.last).all(|piece| piece.counts[8] % 100_000 != 0));
}

/// The same through the program: rotary words of the output are those of the input.
#[test]
fn the_option_hold_keeps_rotary_words() {
    let program =
        "N5 T1 M6\nN10 G17 G90 G71 G54 D1\nN20 G0 X20 Y60 Z150 A40 C30\nN30 G1 X40 Y80 F500\nN40 A55 C-12.5\nN50 M30\n";
    let shop = Shop::new().file("PART.MPF", program);
    let machine = crate::support::machine("esmaeili_huron");
    let words = |rotary: &str| -> Vec<String> {
        shop.run(["PART.MPF", "-o", "OUT.MPF", "--machine", machine.as_str(), "--rotary", rotary]).exits(0);
        let text = shop.text("OUT.MPF");
        text.split_whitespace().filter(|word| word.starts_with(['A', 'C'])).map(str::to_owned).collect()
    };
    let held = words("hold");
    assert_eq!((held.first().unwrap().as_str(), held.get(1).unwrap().as_str()), ("A40", "C30"));
    assert_eq!(held[held.len() - 2..], ["A55", "C-12.5"]);
    let corrected = words("correct");
    for word in ["A40", "C30", "A55", "C-12.5"] {
        assert!(!corrected.iter().any(|other| other == word), "{word} is corrected: {corrected:?}");
    }
}
