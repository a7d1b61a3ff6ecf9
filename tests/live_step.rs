//! The second step: what the temperatures of the moment ask for, added to pieces that were corrected before.

use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_machine::machine::{Machine, State};
use ncfix_machine::snc::{Kind, TextReader};
use ncfix_model::{ErrorModel, Model};
use ncfix_path::path::{Allows, Asked, CorrectionOptions, Corrector, Doses, Live, Output, Piece};

use crate::bench_machine::{correct, motion, polynomial, table};
use crate::machines::xyz_machine;

/// All that is asked for, at once, where a piece allows a change; writes down what it was asked.
#[derive(Default)]
struct AtOnce {
    shift: AxisVector,
    asked: Vec<Asked>,
}

impl Doses for AtOnce {
    fn dose(&mut self, asked: &Asked) -> AxisVector {
        self.asked.push(*asked);
        match asked.allows {
            Allows::Change | Allows::Rapid => self.shift = asked.now,
            Allows::Nothing => {}
            Allows::Release => self.shift = AxisVector::ZERO,
        }
        self.shift
    }
}

/// Positioning and straightness as measured cold.
fn cold() -> ErrorModel {
    ErrorModel {
        motion: vec![
            motion("EXX", polynomial(&[0.0, 3e-5])),
            motion("EZX", table(&[-1000.0, 0.0, 1000.0], &[40.0, 0.0, 40.0])),
        ],
        ..ErrorModel::default()
    }
}

/// Warm: the scale of X is longer, Z has drifted by 23.4 µm.
fn warm() -> ErrorModel {
    let mut errors = cold();
    errors.motion.push(motion("EXX", polynomial(&[0.0, 6e-5])));
    errors.motion.push(motion("EZZ", table(&[-1000.0, 1000.0], &[23.4, 23.4])));
    errors
}

fn live(text: &str, machine: &Machine, doses: &mut dyn Doses, now: impl Fn(usize) -> bool) -> Vec<Piece> {
    let [base, hot] = [cold(), warm()].map(|errors| Model::new(machine, &errors));
    let mut stands = [f64::NAN; 3];
    let elements = TextReader::new(text).map(|element| {
        let mut element = element.unwrap();
        // The text names all axes; a program those that move.
        if let Kind::Move(motion) = &mut element.kind {
            let xyz = [Axis::X, Axis::Y, Axis::Z];
            let moves = |axis: &Axis| motion.target[*axis] != stands[axis.slot()];
            motion.named = xyz.into_iter().filter(moves).collect();
            stands = xyz.map(|axis| motion.target[axis]);
        }
        Ok(element)
    });
    let corrector = Corrector::new(elements, machine, &base, CorrectionOptions::default());
    let mut live = Live::new(machine, &base, &CorrectionOptions::default());
    let mut pieces = Vec::new();
    for output in corrector {
        if let Output::Piece(piece) = live.apply(output.unwrap(), now(pieces.len()).then_some(&hot), doses) {
            pieces.push(piece);
        }
    }
    pieces
}

const LINES: &str =
    "G0 X0 Y0 Z50\nG1 X200 Y0 Z50 F600\nG1 X200 Y100 Z50 F600\nG1 X-300 Y100 Z50 F600\nG1 X-300 Y100 Z10 F600\n";

#[test]
fn two_steps_lead_to_where_one_step_with_the_temperatures_leads() {
    let machine = xyz_machine();
    let hot = Model::new(&machine, &warm());
    let pieces = live(LINES, &machine, &mut AtOnce::default(), |_| true);
    let once = correct(LINES, &machine, &warm(), CorrectionOptions::default());
    let last =
        |pieces: &[Piece]| pieces.iter().filter(|piece| piece.last).map(|piece| piece.counts).collect::<Vec<_>>();
    let [two, one] = [last(&pieces), last(&once.pieces)];
    assert_eq!(two.len(), one.len());
    for (two, one) in two.iter().zip(&one) {
        // Rounded twice: at most one increment apart.
        assert!(two.iter().zip(one).all(|(a, b)| (a - b).abs() <= 1), "{two:?} {one:?}");
    }
    for piece in &pieces {
        let off = hot.tip_error_mm(&piece.nominal, &piece.command, &Vector::zeros(), &State::default());
        // Three axes, half an increment of the first step and half of the second each.
        assert!(off.norm() < 1.8e-4, "{piece:?} {off}");
    }
}

#[test]
fn cold_pieces_stay_as_they_are() {
    let machine = xyz_machine();
    let pieces = live(LINES, &machine, &mut AtOnce::default(), |_| false);
    let expected = correct(LINES, &machine, &cold(), CorrectionOptions::default()).pieces;
    assert_eq!(pieces.len(), expected.len());
    assert!(pieces.iter().zip(&expected).all(|(a, b)| (a.counts, a.arc) == (b.counts, b.arc)));
}

#[test]
fn a_block_that_lacks_the_axis_gets_its_word_when_its_shift_changes() {
    let machine = xyz_machine();
    let text = "G0 X0 Y0 Z50\nG1 X0 Y10 Z50 F600\nG1 X0 Y20 Z50 F600\nG1 X0 Y30 Z50 F600\n";
    // It becomes warm behind the second block.
    let pieces = live(text, &machine, &mut AtOnce::default(), |k| k >= 2);
    let words: Vec<bool> = pieces.iter().map(|piece| piece.words.contains(Axis::Z)).collect();
    assert_eq!(words, [true, false, true, false]);
    assert_eq!(pieces[2].counts[2] - pieces[1].counts[2], -234);
    assert_eq!(pieces[3].counts[2], pieces[2].counts[2]);
}

#[test]
fn an_arc_keeps_its_center_and_the_shift_that_it_began_with() {
    let machine = xyz_machine();
    let text = "G0 X0 Y0 Z50\nG1 X10 Y0 Z50 F600\nG3 X0 Y10 Z50 I-10 J0 P17 F600\nG3 X-10 Y0 Z50 I0 J-10 P17 F600\nG1 X-20 Y0 Z50 F600\n";
    let mut doses = AtOnce::default();
    let warmed = live(text, &machine, &mut doses, |k| k >= 1);
    let cold = live(text, &machine, &mut AtOnce::default(), |_| false);
    assert_eq!(warmed.len(), cold.len());
    let shifts: Vec<[i64; 3]> = warmed
        .iter()
        .zip(&cold)
        .map(|(warm, cold)| std::array::from_fn(|slot| warm.counts[slot] - cold.counts[slot]))
        .collect();
    assert!(cold.iter().filter(|piece| piece.arc.is_some()).count() >= 2);
    for ((warm, cold), shift) in warmed.iter().zip(&cold).zip(&shifts) {
        if let (Some(warm), Some(cold)) = (warm.arc, cold.arc) {
            assert_eq!(warm.center_counts, cold.center_counts);
            // That of the block before the arcs: 10 mm of 60 µm/m, 23.4 µm.
            assert_eq!(*shift, [-6, 0, -234]);
            let moved: [i64; 3] = std::array::from_fn(|slot| warm.start_counts[slot] - cold.start_counts[slot]);
            assert_eq!(moved, *shift);
        }
    }
    // Behind the arcs the rest follows: −20 mm of 60 µm/m.
    assert_eq!(shifts.last(), Some(&[12, 0, -234]));
    // Ways and times: a quarter of a circle of 10 mm at 600 mm/min.
    let arcs: f64 = doses.asked.iter().filter(|asked| asked.allows == Allows::Nothing).map(|asked| asked.way_mm).sum();
    assert!((arcs - 10.0 * std::f64::consts::PI).abs() < 0.01, "{arcs}");
    let asked = &doses.asked[1];
    assert!((asked.time_s - 1.0).abs() < 1e-3 && (asked.way_mm - 10.0).abs() < 1e-2, "{asked:?}");
}
