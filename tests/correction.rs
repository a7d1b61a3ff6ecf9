//! What the corrector does with moves: what stays, what is cut, what is said.

use ncfix_base::geometry::{Axis, AxisSet, AxisVector, Frame, Plane, Vector};
use ncfix_machine::machine::{Machine, State, ToolChange};
use ncfix_machine::snc::{Element, Kind, Origin, Setup, TextReader};
use ncfix_model::motion::EntryFunction;
use ncfix_model::motion::periodic::Periodic;
use ncfix_model::{ErrorModel, LocationError, Model};
use ncfix_path::path::{Arcs, Centers, CorrectionOptions, OutputFrame, PieceArc, Rapids, Subdivision};

use crate::bench_machine::{
    Random, Replay, Run, backlash, correct, correct_elements, load_machine, motion, polynomial, table, tired,
};
use crate::machines::xyz_machine;

/// Counts of X, Y and Z of every piece.
fn counts(run: &Run) -> Vec<[i64; 3]> {
    run.pieces.iter().map(|piece| [piece.counts[0], piece.counts[1], piece.counts[2]]).collect()
}

fn set(letters: &str) -> AxisSet {
    letters.bytes().filter_map(Axis::from_letter).collect()
}

/// A change of setup as an element.
fn set_up(setup: Setup) -> Element {
    Element { origin: Origin::default(), starts_block: false, number: None, kind: Kind::Setup(setup.into()) }
}

fn with_tool(length_mm: f64) -> Setup {
    Setup { tool_mm: Vector::new(0.0, 0.0, -length_mm), ..Setup::default() }
}

#[test]
fn without_errors_every_move_stays_as_it_is() {
    let text = "G0 X10 Y0 Z5\nG1 X20.5 Y0.25 Z-1 F500\nG2 X30.5 Y10.25 Z-1 I0 J10 P17 F500\n\
                G3 X30.5 Y10.25 Z-4 I-5 J3.5 P17 L2 F500\nG3 X30.5 Y10.25 Z-4 I1 P17 F500\nG2 X40 Y12.25 Z-1 I0 J4.75 K2 P19 F500\n";
    let errors = ErrorModel::default();
    let in_plane_19: Vec<Element> = TextReader::new(text).map(Result::unwrap).take(5).collect();
    for options in [
        CorrectionOptions::default(),
        CorrectionOptions { subdivision: Subdivision::Step(1.0), ..CorrectionOptions::default() },
    ] {
        let run = correct_elements(in_plane_19.iter().cloned(), &xyz_machine(), &errors, options);
        assert_eq!(
            counts(&run),
            [
                [100_000, 0, 50_000],
                [205_000, 2_500, -10_000],
                [305_000, 102_500, -10_000],
                [305_000, 102_500, -40_000],
                [305_000, 102_500, -40_000]
            ]
        );
        let arcs: Vec<_> = run.pieces.iter().filter_map(|piece| piece.arc).collect();
        assert_eq!(
            arcs.iter().map(|arc| arc.center_counts).collect::<Vec<_>>(),
            [[0, 100_000, 0], [-50_000, 35_000, 0], [10_000, 0, 0]]
        );
        assert_eq!(
            arcs.iter().map(|arc| (arc.clockwise, arc.extra_turns)).collect::<Vec<_>>(),
            [(true, 0), (false, 2), (false, 0)]
        );
        assert!(run.findings.is_empty());
        assert_eq!(run.prediction.after().max_mm, 0.0);
    }
    assert_eq!(text.lines().count(), 6, "the arc in G19 is another test's");
}

#[test]
fn an_arc_in_a_plane_that_is_not_selected_becomes_chords() {
    let text = "G0 X0 Y0 Z0\nG3 X5 Y10 Z0 J5 K0 P19 F500\n";
    let plane_of = |plane| {
        let setup = Setup { plane, ..Setup::default() };
        let first = set_up(setup);
        let elements = std::iter::once(first).chain(TextReader::new(text).map(Result::unwrap));
        correct_elements(elements, &xyz_machine(), &ErrorModel::default(), CorrectionOptions::default())
    };
    let kept = plane_of(Plane::YZ);
    assert_eq!(kept.pieces[1].arc.map(|arc| arc.center_counts), Some([0, 50_000, 0]));
    let chords = plane_of(Plane::XY);
    assert!(chords.pieces.len() > 50 && chords.pieces.iter().all(|piece| piece.arc.is_none()));
    assert!(chords.prediction.after().max_mm <= 1e-3);
}

#[test]
fn rounding_does_not_accumulate_over_a_hundred_thousand_blocks() {
    // Steps of a third of an increment and a bit, as an incremental program in inches makes them.
    let step = 0.000_1 / 3.0 + 1e-9;
    let mut text = String::from("G0 X0 Y0 Z0\n");
    for k in 1..=100_000 {
        text.push_str(&format!("G1 X{} Y{} Z0 F500\n", f64::from(k) * step, f64::from(k) * -0.012_7));
    }
    let machine = xyz_machine();
    let empty = correct(&text, &machine, &ErrorModel::default(), CorrectionOptions::default());
    assert_eq!(empty.pieces.len(), 100_001);
    for (k, piece) in (0_i64..).zip(&empty.pieces) {
        let expected = (k as f64 * step * 1e4).round() as i64;
        // Halves may fall either way.
        assert!((piece.counts[0] - expected).abs() <= i64::from((k as f64 * step * 1e4).fract().abs() - 0.5 < 1e-6));
        assert_eq!(piece.counts[1], -127 * k);
    }
    let errors = ErrorModel { motion: vec![motion("EXX", polynomial(&[0.0, 1e-5]))], ..ErrorModel::default() };
    let corrected = correct(&text, &machine, &errors, CorrectionOptions::default());
    let last = corrected.pieces.last().unwrap();
    // x + 1e-5 x = 100000 · step.
    assert!((last.command[Axis::X] - 1e5 * step / (1.0 + 1e-5)).abs() <= 0.5e-4 + 1e-9);
}

#[test]
fn only_axes_that_the_program_has_stated_are_written() {
    let errors = tired(&mut Random(1));
    let run = correct("G0 Z100\nG0 X10\nG0 Y20\nG1 Z5 F100\n", &xyz_machine(), &errors, CorrectionOptions::default());
    let named = ["Z", "X", "Y", "Z"].map(set);
    let known = ["Z", "XZ", "XYZ", "XYZ"].map(set);
    assert_eq!(run.pieces.len(), 4);
    for (piece, (named, known)) in run.pieces.iter().zip(named.into_iter().zip(known)) {
        assert!(named.difference(piece.words).is_empty(), "{:?}", piece.words);
        assert!(piece.words.difference(known).is_empty(), "{:?}", piece.words);
    }
    // The first move knows nothing of X and Y, so it is corrected as at zero, and Z again when they are known.
    assert!(run.pieces[2].words.contains(Axis::Z));
}

#[test]
fn words_that_do_not_change_are_not_repeated() {
    let errors = ErrorModel { motion: vec![motion("EXX", polynomial(&[0.01]))], ..ErrorModel::default() };
    let run =
        correct("G0 X0 Y0 Z0\nG1 X5 F100\nG1 X5 Y5 F100\n", &xyz_machine(), &errors, CorrectionOptions::default());
    assert_eq!(run.pieces[1].words, set("X"));
    // Named, though it stays: as in the source.
    assert_eq!(run.pieces[2].words, set("XY"));
    assert_eq!(run.pieces[1].counts[0], 49_900);
}

#[test]
fn a_reversal_is_taken_up_on_the_spot() {
    // Lost motion: behind a negative motion X stands 6 µm farther in + than behind a positive one.
    let errors = ErrorModel { motion: vec![motion("EXX", backlash(-6.0))], ..ErrorModel::default() };
    let text = "G0 X0 Y0 Z0\nG1 X100 F500\nG1 Y10 F500\nG1 X0 F500\n";
    let run = correct(text, &xyz_machine(), &errors, CorrectionOptions::default());
    let flags: Vec<(bool, bool, bool)> = run.pieces.iter().map(|p| (p.first, p.last, p.take_up)).collect();
    let (whole, taken, rest) = ((true, true, false), (true, false, true), (false, true, false));
    // Nothing moved before the first feed move, and on which side X is nobody knows: 6 µm back from 3 µm and forward again lead it to the one.
    assert_eq!(flags, [whole, taken, (false, false, true), rest, whole, taken, rest]);
    let x: Vec<i64> = run.pieces.iter().map(|piece| piece.counts[0]).collect();
    assert_eq!(x, [0, -30, 30, 1_000_030, 1_000_030, 999_970, -30]);
    assert!(run.prediction.after().max_mm < 1e-9 && run.prediction.before().max_mm > 2.9e-3);
    assert!(run.pieces[5].words == set("X"));
}

#[test]
fn backlash_below_the_tolerance_costs_no_blocks() {
    let errors = ErrorModel { motion: vec![motion("EXX", backlash(-0.8))], ..ErrorModel::default() };
    let run = correct("G0 X0 Y0 Z0\nG1 X100 F500\nG1 X0 F500\n", &xyz_machine(), &errors, CorrectionOptions::default());
    assert_eq!(run.pieces.len(), 3);
    assert!(run.prediction.after().max_mm < 1e-3);
}

#[test]
fn a_circle_with_backlash_is_cut_where_axes_reverse() {
    let motion = vec![motion("EXX", backlash(-6.0)), motion("EYY", backlash(-4.0))];
    let errors = ErrorModel { motion, ..ErrorModel::default() };
    // The first rapid move comes from anywhere; behind the second one Y has gone through its 4 µm.
    let text = "G0 X50 Y-1 Z0\nG0 X50 Y0 Z0\nG1 X60 Y0 Z0 F500\nG3 X60 Y0 Z0 I-60 J0 P17 F500\n";
    let run = correct(text, &xyz_machine(), &errors, CorrectionOptions::default());
    let of_circle: Vec<_> = run.pieces.iter().filter(|piece| piece.origin.line == 4).collect();
    assert_eq!(of_circle.iter().filter(|piece| piece.arc.is_some()).count(), 4, "four quadrants");
    // X reverses at the start and at 180°, Y at 90° and 270° and begins at the start.
    assert_eq!(of_circle.iter().filter(|piece| piece.take_up).count(), 4);
    assert!(run.prediction.after().max_mm < 1e-3, "{:?}", run.prediction.after());
}

#[test]
fn small_errors_leave_arcs_what_they_are() {
    let errors = ErrorModel {
        location: vec![LocationError { name: "EC0Y".parse().unwrap(), value: 5e-6 }],
        motion: vec![motion("EXX", polynomial(&[0.01, 4e-6])), motion("EZX", polynomial(&[0.0, 2e-6]))],
        ..ErrorModel::default()
    };
    let text = "G0 X60 Y0 Z0\nG3 X60 Y0 Z0 I-40 J0 P17 F500\nG2 X20 Y-40 Z-3 I-40 J0 P17 L1 F500\n";
    let run = correct(text, &xyz_machine(), &errors, CorrectionOptions::default());
    let feed: Vec<_> = run.pieces.iter().filter(|piece| !piece.rapid).collect();
    assert!(feed.iter().all(|piece| piece.arc.is_some()));
    assert_eq!(feed.len(), 2, "a full circle and a helix of more than a turn, one piece each");
    assert_eq!(feed[1].arc.map(|arc| arc.extra_turns), Some(1));
    assert_eq!(feed[0].counts[..2], run.pieces[0].counts[..2], "the circle closes");
    assert!(run.prediction.after().max_mm < 1e-3);
    assert!(run.prediction.before().mean_mm() > 5e-3);
}

#[test]
fn rapid_moves_end_where_they_should_or_stay_as_they_are() {
    let errors = ErrorModel {
        motion: vec![motion("EXX", table(&[0.0, 100.0, 200.0], &[0.0, 20.0, 0.0]))],
        ..ErrorModel::default()
    };
    let text = "G0 X0 Y0 Z0\nG0 X200\nG0 X100\nG1 X110 F500\n";
    let run =
        |rapids| correct(text, &xyz_machine(), &errors, CorrectionOptions { rapids, ..CorrectionOptions::default() });
    let ends = run(Rapids::Ends);
    assert_eq!(ends.pieces.iter().map(|piece| piece.counts[0]).take(3).collect::<Vec<_>>(), [0, 2_000_000, 999_800]);
    assert_eq!(ends.pieces.len(), 4);
    let none = run(Rapids::None);
    assert_eq!(none.pieces[2].counts[0], 1_000_000);
    // The feed move begins with a step onto the corrected path.
    assert!(none.pieces[3].take_up && none.pieces[3].counts[0] == 999_800);
    assert_eq!(none.pieces.len(), 5);
    let text = "G0 X0 Y0 Z0\nG0 X200\nG1 X190 F500\n";
    let all = correct(
        text,
        &xyz_machine(),
        &errors,
        CorrectionOptions { rapids: Rapids::All, ..CorrectionOptions::default() },
    );
    assert_eq!(all.pieces.iter().filter(|piece| piece.rapid).count(), 3, "the kink at 100 mm cuts the approach");
}

#[test]
fn a_fixed_step_follows_the_leading_axis() {
    let errors = tired(&mut Random(7));
    let options = CorrectionOptions { subdivision: Subdivision::Step(20.0), ..CorrectionOptions::default() };
    let run = correct("G0 X0 Y0 Z0\nG1 X10 Y-50 Z5 F500\n", &xyz_machine(), &errors, options);
    let y: Vec<i64> = run.pieces.iter().skip(1).map(|piece| (piece.command[Axis::Y] * 10.0).round() as i64).collect();
    assert_eq!(y, [-200, -400, -500]);
    assert_eq!(
        run.pieces.iter().map(|piece| (piece.first, piece.last)).skip(1).collect::<Vec<_>>(),
        [(true, false), (false, false), (false, true)]
    );
}

#[test]
fn machine_coordinates_are_the_same_commands() {
    let errors = tired(&mut Random(3));
    let text = "G0 X0 Y0 Z0\nG1 X100 Y50 Z-5 F500\nG3 X80 Y70 Z-5 I-20 J0 P17 F500\n";
    let mut offset = AxisVector::ZERO;
    offset.set_xyz(Vector::new(120.5, 33.25, -10.0));
    let setup = Setup { frame: Frame::translation(offset), tool_mm: Vector::new(0.0, 0.0, -95.5), ..Setup::default() };
    let elements = || {
        let first = Element {
            origin: Default::default(),
            starts_block: false,
            number: None,
            kind: Kind::Setup(setup.clone().into()),
        };
        std::iter::once(first).chain(TextReader::new(text).map(Result::unwrap))
    };
    let run = |frame| {
        correct_elements(
            elements(),
            &xyz_machine(),
            &errors,
            CorrectionOptions { frame, ..CorrectionOptions::default() },
        )
    };
    let (work, machine) = (run(OutputFrame::Work), run(OutputFrame::Machine));
    assert_eq!(work.pieces.len(), machine.pieces.len());
    for (work, machine) in work.pieces.iter().zip(&machine.pieces) {
        let shift = [0, 1, 2].map(|slot| machine.counts[slot] - work.counts[slot]);
        assert_eq!(shift, [1_205_000, 332_500, -100_000]);
        let from = |start: [i64; 3]| [0, 1, 2].map(|slot| start[slot] + shift[slot]);
        let moved = work.arc.map(|arc| PieceArc { start_counts: from(arc.start_counts), ..arc });
        assert_eq!(moved, machine.arc);
        // The command is the coordinate less the tool.
        assert!((machine.command[Axis::Z] - machine.counts[2] as f64 * 1e-4 - 95.5).abs() < 1e-9);
    }
}

#[test]
fn the_start_that_was_given_is_where_the_program_begins() {
    let errors = ErrorModel { motion: vec![motion("EXX", polynomial(&[0.01]))], ..ErrorModel::default() };
    let start = Some(AxisVector::ZERO);
    let text = "G1 X10 Y0 Z0 F500\n";
    let known = correct(text, &xyz_machine(), &errors, CorrectionOptions { start, ..CorrectionOptions::default() });
    // The machine stands uncorrected, so the first step is on the spot.
    assert_eq!(counts(&known), [[-100, 0, 0], [99_900, 0, 0]]);
    assert!(known.pieces[0].take_up);
    let unknown = correct(text, &xyz_machine(), &errors, CorrectionOptions::default());
    assert_eq!(counts(&unknown), [[99_900, 0, 0]]);
    assert_eq!(unknown.prediction.before().samples, 0, "nobody knows what the way was");
}

#[test]
fn replayed_ends_are_nominal_but_for_rounding() {
    let mut random = Random(5);
    for _ in 0..20 {
        let errors = tired(&mut random);
        let machine = xyz_machine();
        let model = Model::new(&machine, &errors);
        let mut text = String::from("G0 X0 Y0 Z0\n");
        let mut targets = vec![Vector::zeros()];
        for _ in 0..5 {
            let target = Vector::from_fn(|_, _| (random.between(-4e5, 4e5)).round() / 1e3);
            text.push_str(&format!("G1 X{} Y{} Z{} F500\n", target.x, target.y, target.z));
            targets.push(target);
        }
        let run = correct(&text, &machine, &errors, CorrectionOptions::default());
        let mut replay = Replay::new(&machine);
        let mut ends = Vec::new();
        for piece in &run.pieces {
            let commands = replay.follow(piece, 1);
            if piece.last {
                ends.push(model.actual(&commands[0].0, &Vector::zeros(), &State::default()).translation);
            }
        }
        assert_eq!(ends.len(), targets.len());
        for (end, target) in ends.iter().zip(&targets) {
            assert!((end - target).amax() < 0.5e-4 * 1.01, "{end} {target}");
        }
    }
}

#[test]
fn behind_a_frame_that_is_off_the_grid_axes_are_written_again() {
    let mut offset = AxisVector::ZERO;
    offset[Axis::X] = 0.000_04;
    offset[Axis::Y] = 20.0;
    let shifted = Setup { frame: Frame::translation(offset), ..Setup::default() };
    let moves: Vec<Element> = TextReader::new("G0 X0 Y0 Z0\nG1 Z5 F100\n").map(Result::unwrap).collect();
    let elements = [moves[0].clone(), set_up(shifted), moves[1].clone()];
    let run =
        correct_elements(elements.into_iter(), &xyz_machine(), &ErrorModel::default(), CorrectionOptions::default());
    // Y and Z have the same place in the new frame; X does not, and moves to the nearest.
    assert_eq!(run.pieces[1].words, set("XZ"));
    assert_eq!(counts(&run)[1], [0, -200_000, 50_000]);
    assert!((run.pieces[1].command[Axis::X] - 0.000_04).abs() < 1e-12);
}

#[test]
fn behind_a_tool_change_nothing_is_known() {
    let errors = ErrorModel { motion: vec![motion("EYX", polynomial(&[0.0, 0.0, 2e-6]))], ..ErrorModel::default() };
    let text = "G0 X0 Y0 Z0\nG1 X100 F500\nM6\nG1 X0 Y0 Z0 F500\nG1 X100 F500\n";
    let run = correct(text, &xyz_machine(), &errors, CorrectionOptions::default());
    let of_line = |line| run.pieces.iter().filter(|piece| piece.origin.line == line).count();
    assert_eq!(of_line(4), 1, "the way from the tool change is nobody's knowledge");
    assert!(of_line(2) > 2 && of_line(5) == of_line(2));
    // Where T changes the tool the same holds behind it, and only there.
    let text = text.replace("M6", "T5");
    let mut machine = xyz_machine();
    for (change, pieces) in [(ToolChange::M6, of_line(2)), (ToolChange::T, 1)] {
        machine.control.tool_change = change;
        let run = correct(&text, &machine, &errors, CorrectionOptions::default());
        assert_eq!(run.pieces.iter().filter(|piece| piece.origin.line == 4).count(), pieces, "{change:?}");
    }
}

#[test]
fn a_longer_tool_is_corrected_before_it_cuts() {
    // A roll of 100 µrad: the tip goes aside by 10 µm for every 100 mm of tool.
    let errors = ErrorModel { motion: vec![motion("EAX", polynomial(&[1e-4]))], ..ErrorModel::default() };
    let moves: Vec<Element> = TextReader::new("G0 X0 Y0 Z0\nG1 X10 F500\nG1 X20 F500\n").map(Result::unwrap).collect();
    let elements =
        [set_up(with_tool(50.0)), moves[0].clone(), moves[1].clone(), set_up(with_tool(150.0)), moves[2].clone()];
    let run = correct_elements(elements.into_iter(), &xyz_machine(), &errors, CorrectionOptions::default());
    let y: Vec<f64> = run.pieces.iter().map(|piece| (piece.command[Axis::Y] * 1e4).round()).collect();
    assert_eq!(y, [-50.0, -50.0, -150.0, -150.0]);
    assert!(run.pieces[2].take_up && run.pieces[2].first && run.pieces[3].last);
}

#[test]
fn the_tip_is_off_by_the_rounding_of_linear_axes_only() {
    let (mut machine, errors) = load_machine("esmaeili_xyz5");
    // 0.01°: 87 µm at half a meter.
    machine.control.increment_rad = 0.01_f64.to_radians();
    // As the chords of a transformation have them: between the increments.
    let text = "G0 X10.5 Y-20.25 Z150 B12.343 C56.783\nG1 X60 Y70 Z180 B-30.5 C-100.003 F500\n";
    check_rounding(text, &machine, &errors);
    check_rounding(text, &machine, &ErrorModel::default());
}

fn check_rounding(text: &str, machine: &Machine, errors: &ErrorModel) {
    let model = Model::new(machine, errors);
    let run = correct(text, machine, errors, CorrectionOptions::default());
    let mut replay = Replay::new(machine);
    let targets: Vec<AxisVector> = TextReader::new(text)
        .filter_map(|element| if let Kind::Move(motion) = element.unwrap().kind { Some(motion.target) } else { None })
        .collect();
    let mut ends = run.pieces.iter().filter_map(|piece| {
        let commands = replay.follow(piece, 1);
        piece.last.then(|| commands[0])
    });
    for target in targets {
        let (command, state) = ends.next().unwrap();
        let off = model.tip_error_mm(&target, &command, &Vector::zeros(), &state);
        assert!(off.norm() < 0.5e-4 * 3_f64.sqrt() * 1.01, "{off}");
        assert!((command[Axis::B] - target[Axis::B]).abs() <= 0.006_f64.to_radians());
    }
}

#[test]
fn where_no_useful_arc_fits_there_are_chords() {
    let periodic = EntryFunction::Periodic(Periodic { period: 2.0, amplitude: 0.02, phase_rad: 0.0 });
    let errors = ErrorModel { motion: vec![motion("EYX", periodic)], ..ErrorModel::default() };
    let text = "G0 X10 Y0 Z0\nG3 X-10 Y0 I-10 J0 P17 F500\n";
    let run = correct(text, &xyz_machine(), &errors, CorrectionOptions::default());
    let arcs = run.pieces.iter().filter(|piece| piece.arc.is_some()).count();
    // At its start the circle hardly moves X, so arcs fit there.
    assert!(run.pieces.len() > 20 && arcs < 5, "{arcs} arcs of {} pieces", run.pieces.len());
    assert!(run.prediction.after().max_mm <= 1e-3);
}

#[test]
fn a_piece_that_begins_off_its_place_is_looked_at_where_it_deviates_most() {
    // Less than the tolerance, so that nothing is taken up: a chord behind the reversal begins 0.9 µm off the circle, and bends as well.
    for (size_um, least_mm) in [(0.9, 8e-4), (-0.9, 9e-4)] {
        let errors = ErrorModel { motion: vec![motion("EXX", backlash(size_um))], ..ErrorModel::default() };
        let mut machine = xyz_machine();
        machine.control.increment_mm = 1e-5;
        let text = "G0 X40 Y1 Z0\nG1 X30 Y0 F500\nG3 X30 Y0 I-30 J0 P17 F500\n";
        let run =
            correct(text, &machine, &errors, CorrectionOptions { arcs: Arcs::Chords, ..CorrectionOptions::default() });
        let model = Model::new(&machine, &errors);
        let mut replay = Replay::new(&machine);
        let mut worst = 0.0_f64;
        for piece in &run.pieces {
            for (command, state) in replay.follow(piece, 24) {
                if piece.origin.line == 3 {
                    let [x, y, _] = <[f64; 3]>::from(model.actual(&command, &Vector::zeros(), &state).translation);
                    worst = worst.max((x.hypot(y) - 30.0).abs());
                }
            }
        }
        assert!((least_mm..1.01e-3).contains(&worst), "{worst:e}");
    }
}

/// A control that keeps the center as it is written moves on a spiral, whose middle is off the circle by half of what the radii differ by.
#[test]
fn arcs_are_judged_as_the_control_of_the_output_moves() {
    let mut machine = xyz_machine();
    machine.control.increment_mm = 1e-3;
    let options = CorrectionOptions { tolerance_mm: 1e-3, centers: Centers::AsWritten, ..CorrectionOptions::default() };
    let mut random = Random(5);
    let mut arcs = 0;
    for _ in 0..2000 {
        let radius = random.between(0.5, 1.5);
        // Nearly a full turn: the chord is short.
        let (from, short) = (random.between(-3.0, 3.0), random.between(0.1, 0.5));
        let [start, end] = [from, from - short].map(|angle: f64| [radius * angle.cos(), radius * angle.sin()]);
        let text = format!(
            "G0 X{:.9} Y{:.9} Z0\nG3 X{:.9} Y{:.9} I{:.9} J{:.9} P17 F500\n",
            start[0], start[1], end[0], end[1], -start[0], -start[1]
        );
        let run = correct(&text, &machine, &ErrorModel::default(), options.clone());
        let [first, piece, ..] = &run.pieces[..] else { panic!("{text}") };
        let Some(arc) = piece.arc else { continue };
        arcs += 1;
        let at = |counts: i64| counts as f64 * 1e-3;
        let [from, to] = [first, piece].map(|piece| [at(piece.counts[0]), at(piece.counts[1])]);
        let center = [from[0] + at(arc.center_counts[0]), from[1] + at(arc.center_counts[1])];
        let radii = [from, to].map(|place| (place[0] - center[0]).hypot(place[1] - center[1]));
        let angles = [from, to].map(|place| (place[1] - center[1]).atan2(place[0] - center[0]));
        let sweep = (angles[1] - angles[0]).rem_euclid(std::f64::consts::TAU);
        for k in 1..48 {
            let share = f64::from(k) / 48.0;
            let (sine, cosine) = (angles[0] + sweep * share).sin_cos();
            let reach = radii[0] * (1.0 - share) + radii[1] * share;
            let off = (center[0] + reach * cosine).hypot(center[1] + reach * sine) - radius;
            assert!(off.abs() < 1.01e-3, "{off:e} at {share}: {text}");
        }
    }
    assert!(arcs > 500, "{arcs}");
}
