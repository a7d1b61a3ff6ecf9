//! Arcs of several turns for controls whose blocks turn once, or go down a helix by less than a turn.
use ncfix_base::source::{FileId, Source};
use ncfix_language::exec::{Execution, NoLibrary, Options as ExecOptions};
use ncfix_language::syntax;
use ncfix_machine::machine::Machine;
use ncfix_model::{ErrorModel, Model};
use ncfix_path::emit::{self, Stamp, WriterOptions};
use ncfix_path::path::{CorrectionOptions, Corrector, Increments, Output, OutputFrame, Turns};

use crate::bench_machine::{motion, polynomial};
use crate::machines::xyz_machine;

/// Three turns and a quarter down from X30 about X20 Y10, by 6.5 mm, then a circle, then arcs that are less.
const PROGRAM: &str = "N10 G17 G90 G0 X30 Y10 Z0\nN20 G3 X20 Y20 Z-6.5 I-10 J0 TURN=3 F500\nN30 G3 I0 J-10 TURN=1\n\
                       N40 G2 X30 Y10 I0 J-10\nN50 M30\n";

fn machine() -> Machine {
    let mut machine = xyz_machine();
    machine.control.increment_mm = 1e-3;
    machine
}

fn corrected(errors: &ErrorModel, turns: Turns, dialect: &str) -> (Vec<Output>, String) {
    let machine = machine();
    let model = Model::new(&machine, errors);
    let source = Source::new(FileId(0), "test.mpf", PROGRAM.as_bytes().to_vec()).unwrap();
    let (program, findings) = syntax::parse(&source, ncfix_dialect::sinumerik());
    assert!(findings.is_empty(), "{findings:?}");
    let execution = Execution::new(program, &machine, Box::new(NoLibrary), ExecOptions::default());
    let stream: Vec<Output> =
        Corrector::new(execution, &machine, &model, CorrectionOptions { turns, ..CorrectionOptions::default() })
            .flatten()
            .collect();
    let options = WriterOptions {
        names: machine.written_names(),
        increments: Increments::new(&machine.control),
        frame: OutputFrame::Work,
        crlf: false,
        stamp: Stamp::default(),
        last_block_number: None,
        has_centers_reversed: false,
    };
    let mut writer = emit::writer(dialect, &options).unwrap();
    let mut out = Vec::new();
    emit::emit(stream.iter().cloned().map(Ok), writer.as_mut(), &mut out, |finding| panic!("{finding:?}")).unwrap();
    (stream, String::from_utf8(out).unwrap())
}

fn arcs_of(text: &str) -> Vec<&str> {
    text.lines().filter(|line| line.contains(" I") || line.contains("I0")).collect()
}

#[test]
fn every_turn_is_a_block_with_its_share_of_the_third_axis() {
    let (_, text) = corrected(&ErrorModel::default(), Turns::One, "fanuc");
    // 6.5 mm over 3.25 turns are 2 mm a turn.
    assert_eq!(
        arcs_of(&text),
        [
            "N20 G3 X30. Y10. Z-2. I-10. J0. F500.",
            "Z-4. I-10. J0. (+)",
            "Z-6. I-10. J0. (+)",
            "X20. Y20. Z-6.5 I-10. J0. (+)",
            "N30 G3 I0. J-10.",
            "I0. J-10. (+)",
            "N40 G2 X30. Y10. I0. J-10.",
        ]
    );
}

#[test]
fn a_helix_goes_down_by_less_than_a_turn_where_a_block_must_not_turn_in_full() {
    let (stream, text) = corrected(&ErrorModel::default(), Turns::OneFlat, "grundig");
    let arcs: Vec<&str> = arcs_of(&text).into_iter().map(|line| line.split_once(' ').unwrap().1).collect();
    let (helix, others) = arcs.split_at(arcs.len() - 3);
    assert_eq!(others, ["G3 I20 J10 B5=360", "I20 J10 B5=360 (+)", "G2 X30 Y10 I20 J10"]);
    assert!(
        helix.iter().all(|line| line.contains('X') && line.contains('Y') && line.contains(" I20 J10")),
        "{helix:?}"
    );
    assert!(helix.last().unwrap().starts_with("X20 Y20 Z-6.5 "), "{helix:?}");
    let mut swept = 0.0;
    for output in stream {
        let Output::Piece(piece) = output else { continue };
        if piece.arc.is_none() || swept >= 1170.0 {
            continue;
        }
        // Z says how far around its end lies: 6.5 mm over 1170 degrees.
        let around = piece.counts[2] as f64 / -6500.0 * 1170.0;
        assert!(around - swept < 359.0, "{piece:?}");
        let (y, x) = around.to_radians().sin_cos();
        assert!((piece.counts[0] as f64 - (20_000.0 + 10_000.0 * x)).abs() < 20.0, "{piece:?}");
        assert!((piece.counts[1] as f64 - (10_000.0 + 10_000.0 * y)).abs() < 20.0, "{piece:?}");
        swept = around;
    }
    assert_eq!(swept, 1170.0);
}

#[test]
fn corrected_turns_end_on_the_circle_that_their_centers_say() {
    let errors = ErrorModel {
        motion: vec![
            motion("EXX", polynomial(&[0.0, 2e-4])),
            motion("EYZ", polynomial(&[0.0, 1e-3])),
            motion("EZY", polynomial(&[0.0, 0.0, 5e-6])),
        ],
        ..ErrorModel::default()
    };
    for (turns, dialect) in [(Turns::One, "fanuc"), (Turns::OneFlat, "grundig"), (Turns::Several, "rs274")] {
        let (stream, text) = corrected(&errors, turns, dialect);
        assert!(!arcs_of(&text).is_empty());
        let mut at = [0_i64; 3];
        for output in &stream {
            let Output::Piece(piece) = output else { continue };
            let end = [piece.counts[0], piece.counts[1], piece.counts[2]];
            if let Some(arc) = &piece.arc {
                assert_eq!(arc.start_counts, at, "{dialect}");
                let center = [at[0] + arc.center_counts[0], at[1] + arc.center_counts[1]];
                let radius = |point: [i64; 3]| ((point[0] - center[0]) as f64).hypot((point[1] - center[1]) as f64);
                // Counts of a micrometer: both radii within the rounding of the center.
                assert!((radius(at) - radius(end)).abs() < 2.0, "{dialect}: {piece:?}");
                assert!(turns == Turns::Several || arc.extra_turns == 0);
                let is_full = at[..2] == end[..2];
                assert!(!(turns == Turns::OneFlat && is_full && at[2] != end[2]), "{piece:?}");
            }
            at = end;
        }
    }
}
