//! Handmade pieces and elements, and the text that the rules of the languages require.

use crate::emit::{Stamp, WriterOptions, emit, writer};
use crate::path::{Increments, Output, OutputFrame, Piece, PieceArc, RotaryWord};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, Plane};
use ncfix_machine::snc::{
    BlockNumber, Dwell, Element, FeedUnit, FrameWords, Kind, MotionMode, Origin, RotaryDirection, Word, WordValue,
};

const LANGUAGES: [&str; 3] = ["rs274", "fanuc", "grundig"];

/// The text of a stream, or the message of its first diagnostic; the stamp is shortened.
pub(super) fn written(dialect: &str, last_block_number: Option<u32>, stream: &[Output]) -> Result<String, String> {
    let stamp = Stamp { machine: "m".into(), model: "0a".into(), source: "0b".into(), ..Stamp::default() };
    let (long, capital) = (stamp.text(), stamp.capital_text());
    let increments = Increments { linear_mm: 0.001, rotary_deg: 0.001, unit_mm: 1.0 };
    let frame = OutputFrame::Work;
    let names = Default::default();
    let options =
        WriterOptions { increments, frame, crlf: false, names, stamp, last_block_number, has_centers_reversed: false };
    let mut writer = writer(dialect, &options).unwrap();
    let (mut out, mut findings) = (Vec::new(), Vec::new());
    let items = stream.iter().cloned().map(Ok);
    let blocks = emit(items, writer.as_mut(), &mut out, |finding| findings.push(finding)).unwrap();
    if let Some(finding) = findings.into_iter().next() {
        assert_eq!(finding.code, Code::NOT_SUPPORTED);
        return Err(finding.message);
    }
    let out = String::from_utf8(out).unwrap().replace(&long, "ncfix").replace(&capital, "NCFIX");
    let without_number = |line: &str| match line.split_once(' ') {
        Some((number, rest)) if number.starts_with('N') => rest.to_owned(),
        _ => line.to_owned(),
    };
    let is_block = |line: &String| !line.starts_with(['(', ';', '%', 'O', 'N']) && !line.is_empty();
    assert_eq!(out.lines().map(without_number).filter(is_block).count() as u64, blocks, "{out}");
    Ok(out)
}

pub(super) fn lines(dialect: &str, stream: &[Output]) -> Vec<String> {
    written(dialect, None, stream).unwrap().lines().map(str::to_owned).collect()
}

/// The lines after stamp and assumptions, without numbers.
pub(super) fn body(dialect: &str, stream: &[Output]) -> Vec<String> {
    let skip = if dialect == "grundig" { 1 } else { 0 };
    let rest = |line: &String| line.splitn(skip + 1, ' ').last().unwrap_or_default().to_owned();
    lines(dialect, stream)[2..].iter().map(rest).collect()
}

fn element(starts_block: bool, number: Option<u32>, kind: Kind) -> Output {
    let number = number.map(|number| BlockNumber { main: false, number });
    Output::Element(Element { origin: Origin::default(), starts_block, number, kind })
}

pub(super) fn block(kind: Kind) -> Output {
    element(true, None, kind)
}

fn more(kind: Kind) -> Output {
    element(false, None, kind)
}

fn words(letters: &[(u8, f64)]) -> Vec<Word> {
    letters.iter().map(|&(letter, number)| Word { letter, extension: None, value: WordValue::Number(number) }).collect()
}

/// A straight feed piece that starts a block.
pub(super) fn line(axes: &[(Axis, i64)]) -> Piece {
    let (mut counts, mut named) = ([0; 9], AxisSet::EMPTY);
    for &(axis, count) in axes {
        counts[axis.slot()] = count;
        named.insert(axis);
    }
    Piece {
        origin: Origin::default(),
        starts_block: true,
        number: None,
        first: true,
        last: true,
        take_up: false,
        rapid: false,
        arc: None,
        counts,
        words: named,
        feed: 500.0,
        feed_named: false,
        unit: FeedUnit::PerMinute,
        rotary_words: [RotaryWord::Plain; 3],
        in_machine_frame: false,
        motion_mode: MotionMode::Path,
        command: AxisVector::ZERO,
        nominal: AxisVector::ZERO,
        known: named,
        is_corrected: true,
        others_stay: false,
    }
}

pub(super) fn rapid(axes: &[(Axis, i64)]) -> Piece {
    Piece { rapid: true, ..line(axes) }
}

fn further(piece: Piece) -> Piece {
    Piece { starts_block: false, first: false, ..piece }
}

pub(super) fn arc(axes: &[(Axis, i64)], plane: Plane, start_counts: [i64; 3], center_counts: [i64; 3]) -> Piece {
    let circle =
        PieceArc { plane, clockwise: false, center_counts, start_counts, extra_turns: 0, through_counts: None };
    Piece { arc: Some(circle), ..line(axes) }
}

pub(super) fn piece(piece: Piece) -> Output {
    Output::Piece(piece)
}

use Axis::{A, X, Y, Z};

/// A complete program with header, comments, tool, offset, motion and end.
fn program(header: &[&[u8]], comment: &[u8]) -> Vec<Output> {
    let mut stream: Vec<Output> = header.iter().map(|text| block(Kind::Header(text.to_vec()))).collect();
    stream.extend([
        element(true, Some(10), Kind::Keep("G90")),
        more(Kind::Keep("G40")),
        more(Kind::Keep("G17")),
        more(Kind::Comment(comment.to_vec())),
        element(true, Some(20), Kind::Tool(WordValue::Number(5.0))),
        more(Kind::Before(words(&[(b'M', 6.0)]))),
        element(true, Some(30), Kind::Frame(FrameWords::Settable("G54".into()))),
        more(Kind::Before(words(&[(b'S', 1200.0), (b'M', 3.0)]))),
        piece(Piece { starts_block: false, ..rapid(&[(X, 0), (Y, -500)]) }),
        element(true, Some(40), Kind::Before(words(&[(b'M', 8.0)]))),
        piece(Piece { starts_block: false, feed_named: true, ..line(&[(Z, -2000)]) }),
        piece(Piece { number: Some(BlockNumber { main: false, number: 50 }), ..line(&[(X, 10_002)]) }),
        piece(further(line(&[(X, 20_003), (Y, -501)]))),
        element(true, Some(50), Kind::Empty),
        block(Kind::Dwell(Dwell::Seconds(1.5))),
        element(true, Some(60), Kind::After(words(&[(b'M', 30.0)]))),
    ]);
    stream
}

#[test]
fn a_program_for_rs274() {
    assert_eq!(
        lines("rs274", &program(&[b"%"], b"; face")),
        [
            "%",
            "; ncfix",
            "G21 G90 G91.1 G40",
            "N10 G17 ; face",
            "N20 T5 M6",
            "N30 G54 G0 X0 Y-0.5 S1200 M3",
            "N40 G1 Z-2 F500 M8",
            "N50 G1 X10.002",
            "X20.003 Y-0.501 ;+",
            "G4 P1.5",
            "N60 M30",
            "%",
        ]
    );
}

#[test]
fn a_program_for_fanuc() {
    assert_eq!(
        lines("fanuc", &program(&[b"%", b"O0012 (PLATE)"], b"(FACE (1))")),
        [
            "%",
            "O0012 (PLATE)",
            "(NCFIX)",
            "G21 G90 G40",
            "N10 G17 (FACE  1 )",
            "N20 T5 M6",
            "N30 G54 G0 X0. Y-0.5 S1200 M3",
            "N40 G1 Z-2. F500. M8",
            "N50 G1 X10.002",
            "X20.003 Y-0.501 (+)",
            "G4 P1500",
            "N60 M30",
            "%",
        ]
    );
}

#[test]
fn a_program_for_grundig() {
    assert_eq!(
        lines("grundig", &program(&[b"%PM", b"N9001 (PLATE)"], b"(FACE)")),
        [
            "%PM",
            "N9001 (PLATE)",
            "N1 (NCFIX)",
            "N2 G71 G90 G40",
            "N3 G17 (FACE)",
            "N4 T5 M6",
            "N5 G54 G0 X0 Y-0.5 S1200 M3",
            "N6 G1 Z-2 F500 M8",
            "N7 G1 X10.002",
            "N8 X20.003 Y-0.501 (+)",
            "N9 G4 X1.5",
            "N10 M30",
        ]
    );
}

#[test]
fn block_numbers_of_grundig_begin_again_behind_the_last() {
    let stream: Vec<Output> = (1..=4).map(|count| piece(line(&[(X, count)]))).collect();
    let out = written("grundig", Some(3), &stream).unwrap();
    let numbers: Vec<&str> = out.lines().map(|line| line.split(' ').next().unwrap()).collect();
    assert_eq!(numbers, ["N1", "N2", "N3", "N1", "N2", "N3"]);
}

#[test]
fn numbers_of_the_source_are_there_once() {
    let numbered = |number| piece(Piece { number: Some(BlockNumber { main: false, number }), ..line(&[(X, 1)]) });
    // A loop over N20 and N30.
    let stream = [10, 20, 30, 20, 30, 40].map(numbered);
    for dialect in ["rs274", "fanuc"] {
        let starts: Vec<String> = body(dialect, &stream).iter().map(|line| line[..3].trim_end().to_owned()).collect();
        assert_eq!(starts, ["N10", "N20", "N30", "G1", "G1", "N40"]);
    }
}

#[test]
fn arcs_have_their_centers_where_the_language_wants_them() {
    // From X10 Y5 about X20 Y5.
    let quarter = arc(&[(X, 20_000), (Y, -5000)], Plane::XY, [10_000, 5000, 0], [10_000, 0, 0]);
    let circle = arc(&[(X, 10_000), (Y, 5000)], Plane::XY, [10_000, 5000, 0], [10_000, 0, 0]);
    // Only Y changes: the end point in X is not written by itself.
    let half = Piece {
        words: [Y].into_iter().collect(),
        ..arc(&[(X, 10_000), (Y, -5000)], Plane::XY, [10_000, 5000, 0], [0, -5000, 0])
    };
    let helix = arc(&[(X, 20_000), (Y, -5000), (Z, -1000)], Plane::XY, [10_000, 5000, 0], [10_000, 0, 0]);
    let in_zx = arc(&[(Z, 0), (X, 3000)], Plane::ZX, [0, 7, 3000], [0, 0, -3000]);
    let stream = [quarter, circle, half, helix, in_zx].map(piece);
    assert_eq!(
        body("rs274", &stream),
        ["G3 X20 Y-5 I10 J0 F500", "G3 X10 Y5 I10 J0", "G3 Y-5 I0 J-5", "G3 X20 Y-5 Z-1 I10 J0", "G3 X3 Z0 I0 K-3"]
    );
    assert_eq!(
        body("fanuc", &stream),
        [
            "G3 X20. Y-5. I10. J0. F500.",
            "G3 X10. Y5. I10. J0.",
            "G3 Y-5. I0. J-5.",
            "G3 X20. Y-5. Z-1. I10. J0.",
            "G3 X3. Z0. I0. K-3."
        ]
    );
    assert_eq!(
        body("grundig", &stream),
        ["G3 X20 Y-5 I20 J5 F500", "G3 I20 J5 B5=360", "G3 X10 Y-5 I10 J0", "G3 X20 Y-5 Z-1 I20 J5", "G3 X3 Z0 I0 K0"]
    );
}

#[test]
fn turns_are_counted_where_there_is_a_word_for_them() {
    let mut helix = arc(&[(X, 10_000), (Z, -3000)], Plane::XY, [10_000, 0, 0], [-10_000, 0, 0]);
    helix.arc.as_mut().unwrap().extra_turns = 2;
    let stream = [piece(helix)];
    assert_eq!(body("rs274", &stream), ["G3 X10 Z-3 I-10 J0 P3 F500"]);
    for dialect in ["fanuc", "grundig"] {
        assert!(written(dialect, None, &stream).unwrap_err().contains("several turns"), "{dialect}");
    }
}

#[test]
fn inverse_time_says_its_feed_on_every_feed_move() {
    let stream = [
        block(Kind::Keep("G93")),
        piece(Piece { starts_block: false, feed: 2.5, feed_named: true, ..line(&[(X, 1000)]) }),
        piece(further(Piece { feed: 2.5, ..line(&[(X, 2000)]) })),
        piece(Piece { feed: 2.5, ..rapid(&[(X, 3000)]) }),
        piece(Piece { feed: 1.0, ..line(&[(X, 4000)]) }),
        block(Kind::Keep("G94")),
        piece(Piece { starts_block: false, feed: 1.0, ..line(&[(X, 5000)]) }),
        piece(Piece { feed: 1.0, ..line(&[(X, 6000)]) }),
    ];
    assert_eq!(body("rs274", &stream), ["G93 G1 X1 F2.5", "X2 F2.5 ;+", "G0 X3", "G1 X4 F1", "G94 G1 X5 F1", "G1 X6"]);
    assert_eq!(body("fanuc", &stream)[1], "X2. F2.5 (+)");
}

#[test]
fn behind_a_change_of_the_feed_mode_an_equal_feed_is_written_again() {
    let at = |x, feed| piece(Piece { feed, ..line(&[(X, x)]) });
    let stream = [
        at(1000, 0.5),
        block(Kind::Keep("G95")),
        at(2000, 0.5),
        at(3000, 0.5),
        block(Kind::Keep("G94")),
        at(4000, 0.5),
    ];
    for dialect in LANGUAGES {
        let feeds: Vec<bool> =
            body(dialect, &stream).iter().filter(|line| line.contains('X')).map(|line| line.contains('F')).collect();
        assert_eq!(feeds, [true, true, false, true], "{dialect}");
    }
}

#[test]
fn words_and_dwells_between_two_motions_of_a_block_stay_between_them() {
    let stream = [
        piece(line(&[(Z, -9000)])),
        more(Kind::Before(words(&[(b'M', 4.0)]))),
        more(Kind::Dwell(Dwell::Seconds(0.25))),
        piece(Piece { starts_block: false, ..line(&[(Z, 2000)]) }),
        more(Kind::After(words(&[(b'M', 9.0)]))),
        piece(line(&[(X, 1000)])),
        more(Kind::After(words(&[(b'M', 1.0)]))),
    ];
    let expected = [
        ["G1 Z-9 F500", "M4", "G4 P0.25", "G1 Z2", "M9", "G1 X1 M1"],
        ["G1 Z-9. F500.", "M4", "G4 P250", "G1 Z2. M9", "G1 X1. M1", ""],
        ["G1 Z-9 F500", "M4", "G4 X0.25", "G1 Z2 M9", "G1 X1 M1", ""],
    ];
    for (dialect, expected) in LANGUAGES.into_iter().zip(expected) {
        let expected: Vec<&str> = expected.into_iter().filter(|line| !line.is_empty()).collect();
        assert_eq!(body(dialect, &stream), expected, "{dialect}");
    }
}

#[test]
fn machine_coordinates_are_for_rapid_moves_on_fanuc_and_straight_ones_on_rs274() {
    let home = Piece { in_machine_frame: true, ..rapid(&[(Z, 0)]) };
    let stream = [block(Kind::Keep("G53")), piece(Piece { starts_block: false, ..home }), piece(line(&[(X, 1)]))];
    assert_eq!(body("rs274", &stream), ["G53 G0 Z0", "G1 X0.001 F500"]);
    assert_eq!(body("fanuc", &stream), ["G53 G0 Z0.", "G1 X0.001 F500."]);
    let slow = [piece(Piece { rapid: false, ..home })];
    assert_eq!(body("rs274", &slow), ["G53 G1 Z0 F500"]);
    assert!(written("fanuc", None, &slow).unwrap_err().contains("machine coordinates"));
    let circle = Piece { in_machine_frame: true, ..arc(&[(X, 1)], Plane::XY, [0; 3], [1, 0, 0]) };
    assert!(written("rs274", None, &[piece(circle)]).unwrap_err().contains("machine coordinates"));
}

#[test]
fn every_line_of_a_block_that_stops_runs_through_but_the_last() {
    let cut = |word| {
        let stream = [
            block(Kind::Keep(word)),
            piece(Piece { starts_block: false, last: false, ..line(&[(X, 1000)]) }),
            piece(further(line(&[(X, 2000)]))),
        ];
        stream.to_vec()
    };
    assert_eq!(body("rs274", &cut("G61.1")), ["G61 G1 X1 F500", "G61.1 X2 ;+"]);
    assert_eq!(body("fanuc", &cut("G61")), ["G64 G1 X1. F500.", "G61 X2. (+)"]);
    assert_eq!(body("fanuc", &cut("G9")), ["G1 X1. F500.", "G9 X2. (+)"]);
    // G9 has another meaning there.
    assert_eq!(body("grundig", &cut("G27")), ["G27 G1 X1 F500", "X2 (+)"]);
}

#[test]
fn rotary_axes_are_written_as_plain_degrees_or_not_at_all() {
    let turn =
        |word| piece(Piece { rotary_words: [word, RotaryWord::Plain, RotaryWord::Plain], ..line(&[(A, 370_500)]) });
    for (dialect, text) in LANGUAGES.into_iter().zip(["G1 A370.5 F500", "G1 A370.5 F500.", "G1 A370.5 F500"]) {
        assert_eq!(body(dialect, &[turn(RotaryWord::Plain)]), [text]);
        for word in [
            RotaryWord::Within(RotaryDirection::Shortest),
            RotaryWord::Within(RotaryDirection::Negative),
            RotaryWord::Step(1),
        ] {
            assert!(written(dialect, None, &[turn(word)]).unwrap_err().contains("turns"), "{dialect}");
        }
    }
    let within = [turn(RotaryWord::Within(RotaryDirection::Plain))];
    assert_eq!(body("fanuc", &within), ["G1 A10.5 F500."]);
    // The sign of a wrapped position is its direction.
    assert!(written("rs274", None, &within).is_err());
}

#[test]
fn what_has_no_words_is_refused() {
    let turns = [block(Kind::Dwell(Dwell::Turns(3.0)))];
    assert!(written("rs274", None, &turns).unwrap_err().contains("turns of the spindle"));
    assert_eq!(body("fanuc", &turns), ["G4 P3000"]);
    assert_eq!(body("grundig", &turns), ["G4 D3"]);
    let positioning = [piece(Piece { motion_mode: MotionMode::Positioning, ..rapid(&[(X, 1)]) })];
    let name = [block(Kind::Tool(WordValue::Name(b"MILL".to_vec())))];
    for dialect in LANGUAGES {
        assert!(written(dialect, None, &positioning).unwrap_err().contains("on its own"), "{dialect}");
        assert!(written(dialect, None, &name).unwrap_err().contains("name"), "{dialect}");
    }
}

#[test]
fn a_long_comment_does_not_lengthen_a_line_with_words() {
    let long = format!("({})", "A".repeat(230));
    let stream =
        [block(Kind::Comment(long.clone().into_bytes())), piece(Piece { starts_block: false, ..line(&[(X, 1)]) })];
    assert_eq!(body("rs274", &stream), [long.as_str(), "G1 X0.001 F500"]);
}

#[test]
fn a_piece_that_moves_nothing_writes_nothing() {
    let still = Piece { words: AxisSet::EMPTY, ..further(line(&[])) };
    let stream = [piece(line(&[(X, 1)])), piece(still), more(Kind::After(words(&[(b'M', 30.0)])))];
    assert_eq!(body("fanuc", &stream), ["G1 X0.001 F500. M30"]);
}
