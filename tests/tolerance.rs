//! Between the ends of the pieces: the replayed tool stays within the tolerance of the nominal path, and the pieces are few.

use ncfix_base::geometry::{Arc, Axis, AxisVector, Plane, Vector};
use ncfix_machine::machine::{Machine, State};
use ncfix_machine::snc::{Element, Kind, TextReader};
use ncfix_model::{ErrorModel, Model};
use ncfix_path::path::{Arcs, CorrectionOptions, Rapids};

use crate::bench_machine::{Random, Replay, Trace, backlash, correct, load_machine, motion, polynomial, table, tired};
use crate::machines::xyz_machine;

/// Points of a nominal trace: chords between them stay within some nm of a circle.
const TRACE_POINTS: u32 = 20_000;

/// Nominal tips along every move of SNC text.
fn nominal_traces(text: &str, model: &Model) -> Vec<Trace> {
    let mut position = AxisVector::ZERO;
    let moves = TextReader::new(text).filter_map(|element| match element.unwrap() {
        Element { kind: Kind::Move(motion), .. } => Some(motion),
        _ => None,
    });
    moves
        .map(|motion| {
            let start = std::mem::replace(&mut position, motion.target);
            let at = |fraction| match &motion.arc {
                Some(arc) => arc.at(&start, &motion.target, fraction),
                None => start.lerp(&motion.target, fraction),
            };
            let tip = |k| model.nominal(&at(f64::from(k) / f64::from(TRACE_POINTS)), &Vector::zeros()).translation;
            Trace::new((0..=TRACE_POINTS).map(tip).collect())
        })
        .collect()
}

/// Bodies that lag behind their commands: each lies within half its play to either side of its command, and the ends of the play push it along.
struct Play {
    half_mm: [f64; 3],
    /// By how much the command is ahead of the body, at least and at most, mm: at the beginning nobody knows.
    lag_mm: [[f64; 2]; 3],
}

impl Play {
    fn new(lost_mm: [f64; 3]) -> Play {
        let half_mm = lost_mm.map(|lost| 0.5 * lost);
        Play { half_mm, lag_mm: half_mm.map(|half| [-half, half]) }
    }

    fn note(&mut self, from: &AxisVector, to: &AxisVector) {
        let way = to.xyz() - from.xyz();
        for (k, lag) in self.lag_mm.iter_mut().enumerate() {
            *lag = lag.map(|lag| (lag + way[k]).clamp(-self.half_mm[k], self.half_mm[k]));
        }
    }

    /// The tip with the least and with the most that the bodies may lag: what the sense of an axis moves it by counts in proportion.
    fn tips(&self, model: &Model, command: &AxisVector) -> [Vector; 2] {
        let tip = |state: &State| model.actual(command, &Vector::zeros(), state).translation;
        let middle = tip(&State::default());
        let mut tips = [middle; 2];
        for (k, axis) in [Axis::X, Axis::Y, Axis::Z].into_iter().enumerate() {
            let [ahead, back] = [1, -1].map(|sense| {
                let mut state = State::default();
                state.direction[axis.slot()] = sense;
                tip(&state)
            });
            for (tip, lag) in tips.iter_mut().zip(self.lag_mm[k]) {
                *tip += (ahead - back) * (0.5 * lag / self.half_mm[k]);
            }
        }
        tips
    }
}

/// Corrects, replays, and gives the largest distance of the tool from the nominal path of feed moves, mm, and the number of pieces.
fn worst(text: &str, machine: &Machine, errors: &ErrorModel, options: &CorrectionOptions) -> (f64, usize) {
    worst_with_play(text, (machine, errors), options, None)
}

/// The same with bodies that follow through their play.
fn worst_with_play(
    text: &str,
    (machine, errors): (&Machine, &ErrorModel),
    options: &CorrectionOptions,
    mut play: Option<Play>,
) -> (f64, usize) {
    let run = correct(text, machine, errors, options.clone());
    assert!(run.findings.is_empty(), "{:?}", run.findings);
    let model = Model::new(machine, errors);
    let mut traces = nominal_traces(text, &model).into_iter();
    let mut trace = None;
    let mut replay = Replay::new(machine);
    let mut last = AxisVector::ZERO;
    let mut largest = 0.0_f64;
    for piece in &run.pieces {
        if piece.first {
            trace = traces.next();
        }
        // The way to the first position begins anywhere.
        let is_checked = piece.origin.line > 1 && !piece.take_up && (!piece.rapid || options.rapids == Rapids::All);
        // A prime, so that no sampling of the corrector is repeated.
        for (command, state) in replay.follow(piece, 37) {
            let tips = match &mut play {
                Some(play) => {
                    play.note(&last, &command);
                    play.tips(&model, &command)
                }
                None => [model.actual(&command, &Vector::zeros(), &state).translation; 2],
            };
            last = command;
            if is_checked {
                largest = tips.iter().fold(largest, |most, tip| most.max(trace.as_mut().unwrap().distance_mm(tip)));
            }
        }
    }
    (largest, run.pieces.len())
}

/// A random program of lines, arcs and helices inside ±300 mm, as SNC text.
fn random_program(random: &mut Random, moves: usize) -> String {
    let rounded = |value: f64| (value * 1e3).round() / 1e3;
    let mut at = [0.0, 0.0, 0.0];
    let mut text = String::from("G0 X0 Y0 Z0\n");
    for _ in 0..moves {
        if random.chance() {
            at = [0, 1, 2].map(|_| rounded(random.between(-300.0, 300.0)));
            text.push_str(&format!("G1 X{} Y{} Z{} F500\n", at[0], at[1], at[2]));
            continue;
        }
        let radius = random.between(3.0, 80.0);
        let toward = random.between(0.0, std::f64::consts::TAU);
        let center = [at[0] + radius * toward.cos(), at[1] + radius * toward.sin()];
        let turned = toward + std::f64::consts::PI + random.between(0.2, 6.0);
        let end = [center[0] + radius * turned.cos(), center[1] + radius * turned.sin()];
        let z = if random.chance() { rounded(at[2] + random.between(-5.0, 5.0)) } else { at[2] };
        let code = if random.chance() { 2 } else { 3 };
        let turns = if random.chance() { " L1" } else { "" };
        let (i, j) = (center[0] - at[0], center[1] - at[1]);
        text.push_str(&format!("G{code} X{} Y{} Z{z} I{i} J{j} P17{turns} F500\n", end[0], end[1]));
        at = [end[0], end[1], z];
    }
    text
}

#[test]
fn random_machines_stay_within_the_tolerance_between_the_blocks() {
    let machine = xyz_machine();
    let mut random = Random(2026);
    for round in 0..24 {
        let errors = tired(&mut random);
        let tolerance_mm = [1e-3, 3e-4, 5e-3][round % 3];
        let arcs = if round % 4 == 3 { Arcs::Chords } else { Arcs::Keep };
        let options = CorrectionOptions { tolerance_mm, arcs, rapids: Rapids::All, ..CorrectionOptions::default() };
        let text = random_program(&mut random, 6);
        let (largest, pieces) = worst(&text, &machine, &errors, &options);
        assert!(largest <= tolerance_mm, "round {round}: {largest} mm\n{text}");
        assert!(pieces >= 7);
    }
}

#[test]
fn kinks_of_tables_stay_within_the_tolerance() {
    let mut random = Random(99);
    let positions: Vec<f64> = (-12..=12).map(|k| f64::from(k) * 25.0).collect();
    for _ in 0..8 {
        let names = ["EXX", "EYX", "EZX", "EYY", "EXY", "EZZ", "ECY"];
        let errors = ErrorModel {
            motion: names
                .into_iter()
                .map(|name| {
                    let values: Vec<f64> = positions.iter().map(|_| random.between(-6.0, 6.0)).collect();
                    motion(name, table(&positions, &values))
                })
                .collect(),
            ..ErrorModel::default()
        };
        let options = CorrectionOptions::default();
        let text = random_program(&mut random, 5);
        let (largest, _) = worst(&text, &xyz_machine(), &errors, &options);
        assert!(largest <= options.tolerance_mm, "{largest} mm\n{text}");
    }
}

#[test]
fn five_axis_moves_stay_within_the_tolerance() {
    let (machine, errors) = load_machine("esmaeili_xyz5");
    let text = "G0 X0 Y0 Z200 B0 C0\nG1 X50 Y40 Z120 B10 C30 F500\nG1 X-60 Y40 Z80 B-35 C-120 F500\n\
                G3 X-40 Y60 Z80 I20 J0 P17 F500\nG1 X-40 Y60 Z80 B20 C0 F500\n";
    let options = CorrectionOptions { rapids: Rapids::All, ..CorrectionOptions::default() };
    let (largest, _) = worst(text, &machine, &errors, &options);
    assert!(largest <= options.tolerance_mm, "{largest} mm");
}

/// The least number of straight pieces between `nodes` evenly spread places of a line, ends exactly corrected, by dynamic
/// programming.
fn least_pieces(model: &Model, start: AxisVector, end: AxisVector, tolerance_mm: f64, nodes: usize) -> usize {
    let (tool, state) = (Vector::zeros(), State::default());
    let nominal = |fraction: f64| start.lerp(&end, fraction);
    let solve = |fraction: f64| {
        let at = nominal(fraction);
        model.solve(&at, &tool, &state, &at, ncfix_model::Solve::Full).unwrap()
    };
    let places: Vec<f64> = (0..=nodes).map(|k| k as f64 / nodes as f64).collect();
    let commands: Vec<AxisVector> = places.iter().map(|&place| solve(place)).collect();
    let fits = |i: usize, j: usize| {
        (1..32).all(|k| {
            let share = f64::from(k) / 32.0;
            let at = nominal(places[i] + (places[j] - places[i]) * share);
            model.tip_error_mm(&at, &commands[i].lerp(&commands[j], share), &tool, &state).norm() <= tolerance_mm
        })
    };
    let mut least = vec![usize::MAX; nodes + 1];
    least[0] = 0;
    for j in 1..=nodes {
        for i in (0..j).rev() {
            if least[i] < usize::MAX && least[i] + 1 < least[j] && fits(i, j) {
                least[j] = least[i] + 1;
            }
        }
    }
    least[nodes]
}

#[test]
fn pieces_are_nearly_as_few_as_can_be() {
    let machine = xyz_machine();
    let mut random = Random(4);
    let periodic =
        ErrorModel { motion: vec![motion("EYX", polynomial(&[0.0, 0.0, 4e-6, -6e-9]))], ..ErrorModel::default() };
    let mut models = vec![periodic];
    models.extend((0..3).map(|_| tired(&mut random)));
    let (mut made, mut possible) = (0, 0);
    for errors in models {
        let model = Model::new(&machine, &errors);
        let mut end = AxisVector::ZERO;
        end.set_xyz(Vector::new(480.0, 350.0, -200.0));
        let options = CorrectionOptions { tolerance_mm: 2e-4, ..CorrectionOptions::default() };
        let least = least_pieces(&model, AxisVector::ZERO, end, options.tolerance_mm, 300);
        let run = correct("G0 X0 Y0 Z0\nG1 X480 Y350 Z-200 F500\n", &machine, &errors, options);
        let pieces = run.pieces.len() - 1;
        assert!(pieces as f64 <= least as f64 * 1.15 + 1.0, "{pieces} pieces, {least} would do");
        (made, possible) = (made + pieces, possible + least);
    }
    assert!(possible > 30, "the case is no test: {possible}");
    assert!(made as f64 <= 1.15 * possible as f64, "{made} pieces, {possible} would do");
}

#[test]
fn arcs_are_fewer_than_chords_and_as_good() {
    let machine = xyz_machine();
    let errors = tired(&mut Random(8));
    let text = "G0 X150 Y100 Z0\nG3 X150 Y100 Z0 I-50 J20 P17 F500\n";
    let run = |arcs| worst(text, &machine, &errors, &CorrectionOptions { arcs, ..CorrectionOptions::default() });
    let (kept, chords) = (run(Arcs::Keep), run(Arcs::Chords));
    assert!(kept.0 <= 1e-3 && chords.0 <= 1e-3);
    assert!(kept.1 * 10 < chords.1, "{} arcs, {} chords", kept.1, chords.1);
}

#[test]
fn the_machine_that_is_asked_computes_the_circle_that_was_meant() {
    // The replay of these tests against the crate's own arc: they were written apart.
    let arc = Arc { plane: Plane::XY, clockwise: true, center_mm: [3.0, -4.0], extra_turns: 1 };
    let start = AxisVector::ZERO;
    let mut end = AxisVector::ZERO;
    end.set_xyz(Vector::new(8.0, -4.0, 2.0));
    let text = "G0 X0 Y0 Z0\nG2 X8 Y-4 Z2 I3 J-4 P17 L1 F500\n";
    let machine = xyz_machine();
    let run = correct(text, &machine, &ErrorModel::default(), CorrectionOptions::default());
    let mut replay = Replay::new(&machine);
    replay.follow(&run.pieces[0], 1);
    for (k, (command, _)) in (1..).zip(replay.follow(&run.pieces[1], 50)) {
        let expected = arc.at(&start, &end, f64::from(k) / 50.0);
        assert!((command.xyz() - expected.xyz()).norm() < 1e-9, "{k}");
    }
}

#[test]
fn an_axis_that_stands_still_keeps_its_sense_of_motion() {
    // Lost motion, also across the axes, and moves of one axis at a time: the others only follow their corrections.
    let machine = xyz_machine();
    let mut random = Random(312);
    let mut judged = 0;
    for round in 0..40 {
        let mut errors = tired(&mut random);
        let mut lost_mm = [0.0; 3];
        for (k, name) in ["EXX", "EYY", "EZZ", "EYX", "EXY", "EYZ"].into_iter().enumerate() {
            let value_um = -random.between(1.0, 5.0);
            errors.motion.push(motion(name, backlash(value_um)));
            // Behind a motion in the positive sense the body is half of it less than its command.
            if k < 3 {
                lost_mm[k] = -1e-3 * value_um;
            }
        }
        // Behind the first line every axis goes through its play.
        let mut text = String::from("G0 X-1 Y-1 Z-1\nG0 X0 Y0 Z0\n");
        let mut at = [0.0; 3];
        for step in 0..12 {
            at[(step + round) % 3] = (random.between(-300.0, 300.0) * 1e3).round() / 1e3;
            text.push_str(&format!("G1 X{} Y{} Z{} F500\n", at[0], at[1], at[2]));
        }
        let options = CorrectionOptions::default();
        // Where no consistent sense exists, that is said; what is judged here is what was promised.
        if correct(&text, &machine, &errors, options.clone()).findings.is_empty() {
            judged += 1;
            let play = Some(Play::new(lost_mm));
            let (largest, _) = worst_with_play(&text, (&machine, &errors), &options, play);
            assert!(largest <= options.tolerance_mm, "round {round}: {largest} mm\n{text}");
        }
    }
    assert!(judged >= 20, "{judged} of 40 programs were corrected without a warning");
}

#[test]
fn rounding_does_not_bend_short_arcs_of_an_ideal_machine() {
    let mut machine = xyz_machine();
    machine.control.increment_mm = 5e-4;
    // 1.5 mm of a circle of 60 mm: half an increment at its ends turns the bisector by enough to bend it by 9 µm.
    let text =
        "G0 X0 Y0 Z0\nG1 X242.0509 Y-178.18598 Z0 F500\nG2 X242.08163 Y-176.63468 Z0 I-59.96785 J1.96385 P17 F500\n";
    let (largest, _) = worst(text, &machine, &ErrorModel::default(), &CorrectionOptions::default());
    assert!(largest <= 1e-3, "{largest} mm");
}
