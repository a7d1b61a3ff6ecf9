//! Curves, threads, probing and polar words of RS274/NGC.

use ncfix_language::exec::{NoLibrary, Options};
use ncfix_machine::snc::{Kind, MotionMode, Move};

use crate::iso::{check, elements, iso_machine, moves, run};

fn steps(text: &str, strict: bool) -> (Vec<(u32, Move)>, Vec<String>) {
    let options = Options { strict, ..Options::default() };
    let (elements, codes) = elements("rs274", text, &iso_machine(), Box::new(NoLibrary), options);
    let found = elements.iter().filter_map(|element| match &element.kind {
        Kind::Move(step) => Some((element.origin.line, *step)),
        _ => None,
    });
    (found.collect(), codes)
}

/// Bernstein's polynomials.
fn bezier(points: &[[f64; 2]], t: f64) -> [f64; 2] {
    let mut work = points.to_vec();
    while work.len() > 1 {
        work = work.windows(2).map(|p| [0, 1].map(|k| p[0][k] + (p[1][k] - p[0][k]) * t)).collect();
    }
    work[0]
}

#[track_caller]
fn on_curve(found: &[(u32, Move)], line: u32, points: &[[f64; 2]]) {
    let ends: Vec<&Move> = found.iter().filter(|(at, _)| *at == line).map(|(_, step)| step).collect();
    assert_eq!(ends.len() % (15 * points.len()), 0, "equal steps, 15 for each control point");
    for (k, step) in ends.iter().enumerate() {
        let [x, y] = bezier(points, (k + 1) as f64 / ends.len() as f64);
        assert!((step.target.0[0] - x).hypot(step.target.0[1] - y) < 1e-9, "{k}");
        assert!(!step.rapid && step.feed == 100.0);
    }
}

#[test]
fn cubic_and_quadratic_curves_go_on_along_the_tangent() {
    let (found, codes) = steps(
        "G21 G90 G17 F100
G0 X0 Y0 Z0
G5 I0 J3 P0 Q-3 X1 Y1
G5 P0 Q-3 X2 Y2
G5.1 X4 Y0 I2 J2
G91 G5.1 X2 Y2 I2 J0
M2",
        false,
    );
    assert!(codes.is_empty(), "{codes:?}");
    on_curve(&found, 3, &[[0.0, 0.0], [0.0, 3.0], [1.0, -2.0], [1.0, 1.0]]);
    on_curve(&found, 4, &[[1.0, 1.0], [1.0, 4.0], [2.0, -1.0], [2.0, 2.0]]);
    on_curve(&found, 5, &[[2.0, 2.0], [4.0, 4.0], [4.0, 0.0]]);
    on_curve(&found, 6, &[[4.0, 0.0], [6.0, 0.0], [6.0, 2.0]]);
}

#[test]
fn nurbs_begin_where_the_tool_is_and_weigh_their_points() {
    // Two quadratic pieces whose weights are 1: their common point is halfway between the inner control points.
    let (found, codes) = steps(
        "G21 G90 G17 F100
G0 X0 Y1 Z0
G5.2 P1 L3
X2 Y2 P1
X2 Y0 P1
X0 Y0 P1
G5.3
G1 X5
M2",
        false,
    );
    assert!(codes.is_empty(), "{codes:?}");
    let curve: Vec<&(u32, Move)> = found.iter().filter(|(line, _)| *line == 7).collect();
    assert_eq!(curve.len() % 60, 0);
    let finer = curve.len() / 60;
    let place = |k: usize| [0, 1].map(|axis| curve[(k + 1) * finer - 1].1.target.0[axis]);
    let middle = [2.0, 1.0];
    for (k, points) in [(14, [[0.0, 1.0], [2.0, 2.0], middle]), (44, [middle, [2.0, 0.0], [0.0, 0.0]])] {
        let wanted = bezier(&points, 0.5);
        assert!((place(k)[0] - wanted[0]).hypot(place(k)[1] - wanted[1]) < 1e-12, "{k}");
    }
    assert_eq!(place(59), [0.0, 0.0]);
    assert_eq!(found.last().map(|(_, step)| step.target.0[0]), Some(5.0));
    // A quarter of a circle.
    let weight = 0.5_f64.sqrt();
    let text = format!("G21 G90 F100\nG0 X1 Y0 Z0\nG5.2 X1 Y1 P{weight} L3\nX0 Y1 P1\nG5.3\nM2");
    let (found, codes) = steps(&text, false);
    assert!(codes.is_empty(), "{codes:?}");
    for (_, step) in &found[1..] {
        assert!((step.target.0[0].hypot(step.target.0[1]) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn curves_that_are_none_are_refused() {
    let begin = "G21 G90 F100\nG0 X0 Y0 Z0\n";
    for block in [
        "G5 I1 P0 Q0 X1 Y1",
        "G5 I1 J1 X1 Y1",
        "G5.1 X1 Y1",
        "G5.1 X1 Y1 Z1 I1 J1",
        "G18 G5.1 X1 Y1 I1 J1",
        "G5.3",
        "G5.2 X1 P1",
        "G5.2 X1 Y1 P0",
        "G5.2 X1 Y1 P1 L3\nG5.3",
        "G5.2 X1 Y1 P1 L3\nX1 Y2 P1\nG1 X5\nG5.3",
    ] {
        let (_, codes) = run("rs274", &format!("{begin}{block}"));
        assert_eq!(codes.len(), 1, "{block} {codes:?}");
    }
}

#[test]
fn polar_words() {
    check(
        "rs274",
        "G21 G90 F100
G0 X3 Y4 Z0
G1 @10
^90
@5 ^180
G91 @1 ^-90
M2",
        &["G0 X3 Y4 Z0", "G1 X6 Y8 Z0 F100", "G1 X0 Y10 Z0 F100", "G1 X-5 Y0 Z0 F100", "G1 X0 Y6 Z0 F100"],
    );
    for block in ["G1 @5 X1", "G0 X0 Y0\n@5", "G53 G1 @5 ^1"] {
        let (_, codes) = run("rs274", &format!("G21 G90 F100\nG0 X1 Y0 Z0\n{block}"));
        assert_eq!(codes.len(), 1, "{block} {codes:?}");
    }
}

#[test]
fn threads_move_in_step_with_the_spindle() {
    let (found, codes) = steps("G21 G90 S100 M3\nG0 X0 Y0 Z0\nG33 Z-3 K1.5\nG33.1 Z-9 K1\nG0 X1\nM2", false);
    assert!(codes.is_empty(), "{codes:?}");
    let heights: Vec<f64> = found.iter().map(|(_, step)| step.target.0[2]).collect();
    // Rigid tapping ends where it began.
    assert_eq!(heights, [0.0, -3.0, -9.0, -3.0, -3.0]);
    let leads: Vec<Option<f64>> = found
        .iter()
        .map(|(_, step)| match step.motion_mode {
            MotionMode::Thread(thread) => thread.lead.map(|(_, lead)| lead),
            _ => None,
        })
        .collect();
    assert_eq!(leads, [None, Some(1.5), Some(1.0), Some(1.0), None]);
    let (_, codes) = steps("G21 G90\nG0 X0 Y0 Z0\nG33 Z-3 K1", false);
    assert_eq!(codes.len(), 1, "no spindle: {codes:?}");
}

#[test]
fn threads_on_a_lathe_are_cut_in_passes() {
    // Depth 1 behind the peak at 1: J 0.6, then 0.6 √2 = 0.849 by R2, then 1.
    let (lines, codes) = run(
        "rs274",
        "G21 G90 G18 S100 M3
G0 X20 Y0 Z5
G76 P1.5 Z-30 I-1 J0.6 K1 R2
M2",
    );
    assert!(codes.is_empty(), "{codes:?}");
    let passes = [0.6, 0.6 * 2_f64.sqrt(), 1.0];
    let mut wanted = vec!["G0 X20 Y0 Z5".to_owned()];
    for depth in passes {
        let (clear, cut) = (20.0 + 1.0 - depth, 19.0 - depth);
        for (word, x, z) in [("G0", clear, 5.0), ("G0", cut, 5.0), ("G1", cut, -30.0), ("G0", clear, -30.0)] {
            let x = format!("{x:.6}").trim_end_matches('0').trim_end_matches('.').to_owned();
            wanted.push(format!("{word} X{x} Y0 Z{z}"));
        }
    }
    wanted.push("G0 X20 Y0 Z-30".to_owned());
    assert_eq!(moves(&lines), wanted);
}

/// A thread towards +Z is one towards -Z in a mirror, with its tapers and the slide along the flank.
#[test]
fn a_thread_towards_plus_is_the_mirror_of_one_towards_minus() {
    let thread = |from: f64, to: f64| {
        let text = format!("G21 G90 G18 S100 M3\nG0 X20 Y0 Z{from}\nG76 P1.5 Z{to} I-1 J0.6 K1 R2 Q30 H1 E2 L3\nM2");
        let (found, codes) = steps(&text, false);
        assert!(codes.is_empty(), "{codes:?}");
        found.into_iter().map(|(_, step)| (step.rapid, step.target.0[0], step.target.0[2])).collect::<Vec<_>>()
    };
    let (minus, plus) = (thread(5.0, -30.0), thread(-5.0, 30.0));
    let mirrored: Vec<_> = minus.iter().map(|&(rapid, x, z)| (rapid, x, -z)).collect();
    assert_eq!(plus, mirrored);
    // 0.6 along a flank of 30 degrees.
    let slid = 0.6 * 30.0_f64.to_radians().tan();
    assert!((minus[1].2 - (5.0 - slid)).abs() < 1e-9, "{minus:?}");
}

#[test]
fn probing_ends_where_only_the_machine_knows() {
    let text = "G54 G21 G90 F100\nG0 X0 Y0 Z10\nG38.2 Z-10\nG91 G1 Z1\nM2";
    let (found, codes) = steps(text, false);
    assert!(codes.is_empty(), "{codes:?}");
    assert_eq!(found[1].1.motion_mode, MotionMode::Probe("G38.2"));
    assert_eq!(found[2].1.target.0[2], -9.0);
    let (_, codes) = steps(text, true);
    assert_eq!(codes, ["E0304:4"]);
    // An absolute position says again where it is.
    let (_, codes) = steps("G54 G21 G90 F100\nG0 X0 Y0 Z10\nG38.2 Z-10\nG0 Z5\nG91 G1 Z1 F50\nM2", true);
    assert!(codes.is_empty(), "{codes:?}");
}
