//! Threads, messages, words with values.

use super::tests::{arc, block, body, line, lines, piece, rapid, written};
use crate::path::Piece;
use ncfix_base::geometry::Axis::{self, X, Z};
use ncfix_base::geometry::Plane;
use ncfix_machine::snc::{Kind, MotionMode, Thread, ThreadCode};

#[test]
fn threads_and_messages() {
    let lead = Some((b'K', 1.25));
    let thread =
        |code| Piece { motion_mode: MotionMode::Thread(Thread { code, lead, change: None }), ..line(&[(Z, -9000)]) };
    let stream = [piece(thread(ThreadCode::G33)), piece(line(&[(Z, 0)]))];
    assert_eq!(body("rs274", &stream), ["G33 Z-9 K1.25", "G1 Z0 F500"]);
    assert_eq!(body("fanuc", &stream), ["G33 Z-9. F1.25", "G1 Z0. F500."]);
    assert!(written("grundig", None, &stream).unwrap_err().contains("thread"));
    assert!(written("fanuc", None, &[piece(thread(ThreadCode::G331))]).unwrap_err().contains("G331"));
    let message = [block(Kind::Message(b"TOOL (5)".to_vec())), piece(line(&[(X, 1)]))];
    assert_eq!(written("rs274", None, &message).unwrap().lines().next_back(), Some("G1 X0.001 F500"));
    let shown: Vec<String> = lines("rs274", &message).into_iter().filter(|line| line.contains("MSG")).collect();
    assert_eq!(shown, ["(MSG, TOOL  5 )"]);
    assert!(lines("fanuc", &message).contains(&"(TOOL  5 )".to_owned()));
}

#[test]
fn rigid_tapping_of_rs274_retracts_by_itself() {
    let lead = Some((b'K', 1.0));
    let tap = |code, counts: &[(Axis, i64)]| {
        piece(Piece { motion_mode: MotionMode::Thread(Thread { code, lead, change: None }), ..line(counts) })
    };
    let above = [(X, 40_001), (Z, 5002)];
    let in_and_out = |back: &[(Axis, i64)]| {
        let stream =
            [piece(rapid(&above)), tap(ThreadCode::G331, &[(X, 40_001), (Z, -12_000)]), tap(ThreadCode::G332, back)];
        body("rs274", &stream)
    };
    assert_eq!(in_and_out(&above), ["G0 X40.001 Z5.002", "G33.1 X40.001 Z-12 K1"]);
    // Backlash in Z: the control returns to its start, not to the target position.
    let back = [(X, 40_001), (Z, 5004)];
    assert_eq!(in_and_out(&back), ["G0 X40.001 Z5.002", "G33.1 X40.001 Z-12 K1", "G0 Z5.004 ;+"]);
}

#[test]
fn an_arc_does_not_take_the_p_of_another_word_for_its_turns() {
    let tolerance = || block(Kind::Verbatim(b"G64 P0.05 Q0.02".to_vec()));
    let quarter = Piece { starts_block: false, ..arc(&[(X, 1000)], Plane::XY, [0; 3], [500, 0, 0]) };
    let straight = Piece { starts_block: false, ..line(&[(X, 2000)]) };
    let stream = [tolerance(), piece(quarter), tolerance(), piece(straight)];
    assert_eq!(body("rs274", &stream), ["G64 P0.05 Q0.02", "G3 X1 I0.5 J0 F500", "G64 P0.05 Q0.02 G1 X2"]);
}
