//! Radius compensation together with what else a program does: other planes, tilted frames, feeds, helices, wear, flow.

use ncfix_base::geometry::{AXES, Axis, AxisVector};
use ncfix_language::exec::Options;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Element, Kind, Move};

use crate::compensation::with_radius;
use crate::flat::{check_from, execute, moves};

fn check(start: [f64; 3], text: &str, expected: &str) {
    check_from(start, text, &with_radius(5.0), expected);
}

#[track_caller]
fn codes(text: &str, options: Options) -> Vec<String> {
    execute(text, &with_radius(5.0), options).1
}

#[test]
fn over_the_intersection_where_the_tool_stands_behind_the_contour() {
    // 53 mm from the corner: the tangent to the circle of 5 mm has 52.7636 mm and meets x = 15 at 58 · 5 / 52.7636 beside the corner.
    check(
        [73.0, 20.0, 0.0],
        "N10 G17 G90 T1 D1 KONT G451
N20 G41 G1 X20 Y20 F500
N30 Y60
N40 G40 X73
N50 M30",
        "G1 X15 Y14.5038 F500
        G1 X15 Y20 F500
        G1 X15 Y60 F500
        G1 X15 Y65.4962 F500
        G1 X73 Y60 F500",
    );
}

#[test]
fn feeds_of_arcs_and_helices() {
    // Inside 15 of 20 mm, outside 25 of 20 mm.
    for (side, word, radius, feed) in [
        ("G41", "CFC", 15, 150),
        ("G41", "CFIN", 15, 150),
        ("G41", "CFTCP", 15, 200),
        ("G42", "CFC", 25, 250),
        ("G42", "CFIN", 25, 200),
        ("G42", "CFTCP", 25, 200),
    ] {
        let text = format!("G17 G90 T1 D1 {word}\n{side} G1 X70 Y50 F200\nG3 I-20 J0 TURN=2 Z-6\nG40 G1 X50 Y50\nM30");
        let x = 50 + radius;
        let expected = format!("G1 X{x} Y50 F200\nG3/17 X{x} Y50 Z-6 I-{radius} L2 F{feed}\nG1 X50 Y50 Z-6 F200");
        // A full circle about the start of its turns: TURN counts beyond the first.
        check([50.0, 50.0, 0.0], &text, &expected);
    }
}

const SHAPE: &str = "G90 G0 T1 D1 {x}0 {y}0 {z}0
G41 {words} G1 {x}20 {y}20 F500
{y}60 {z}-2
{x}60
{z}-4
{y}40
G3 {x}80 {y}40 {i}10 {j}0
G2 {x}100 {y}60 {i}20 {j}0
G1 {x}120 {y}20
G40 {x}140 {y}10
M30";

fn shape(letters: [&str; 5], words: &str) -> String {
    let mut text = SHAPE.replace("{words}", words);
    for (name, letter) in ["{x}", "{y}", "{z}", "{i}", "{j}"].into_iter().zip(letters) {
        text = text.replace(name, letter);
    }
    text
}

/// Moves of a program that runs without findings, those without length left out.
#[track_caller]
fn way(text: &str, machine: &Machine) -> Vec<(AxisVector, Move)> {
    let (elements, codes) = execute(text, machine, Options::default());
    assert!(codes.is_empty(), "{codes:?}");
    let moves = moves(&elements, AxisVector::ZERO).into_iter();
    moves.filter(|(start, motion)| motion.arc.is_some() || (motion.target - *start).max_abs(&AXES) > 1e-9).collect()
}

#[test]
fn all_planes_are_alike() {
    let machine = with_radius(5.0);
    for words in ["G450", "G451", "KONT"] {
        let flat = way(&format!("G17\n{}", shape(["X", "Y", "Z", "I", "J"], words)), &machine);
        assert!(flat.len() > 8);
        for (code, letters, axes) in [
            ("G18", ["Z", "X", "Y", "K", "I"], [Axis::Z, Axis::X, Axis::Y]),
            ("G19", ["Y", "Z", "X", "J", "K"], [Axis::Y, Axis::Z, Axis::X]),
        ] {
            let other = way(&format!("{code}\n{}", shape(letters, words)), &machine);
            assert_eq!(flat.len(), other.len());
            for ((_, a), (_, b)) in flat.iter().zip(&other) {
                for (from, to) in [Axis::X, Axis::Y, Axis::Z].into_iter().zip(axes) {
                    assert!((a.target[from] - b.target[to]).abs() < 1e-9, "{code} {a:?} {b:?}");
                }
                assert_eq!(
                    a.arc.map(|arc| (arc.clockwise, arc.extra_turns)),
                    b.arc.map(|arc| (arc.clockwise, arc.extra_turns))
                );
                assert!((a.feed - b.feed).abs() < 1e-9);
            }
        }
    }
}

#[test]
fn a_tilted_plane_carries_the_way_with_it() {
    let machine = with_radius(5.0);
    let text = shape(["X", "Y", "Z", "I", "J"], "G450");
    let flat = way(&format!("G17\n{text}"), &machine);
    for (frame, axes, degrees) in [
        ("ROT X30", [1, 2], 30_f64),
        ("ROT Y-20", [2, 0], -20.0),
        ("ROT Z75", [0, 1], 75.0),
        ("ROT X180", [1, 2], 180.0),
    ] {
        let tilted = way(&format!("G17\nCUT2DF\n{frame}\n{text}"), &machine);
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let back = |position: &AxisVector| {
            let mut out = *position;
            let [a, b] = axes;
            out.0[a] = cosine * position.0[a] + sine * position.0[b];
            out.0[b] = cosine * position.0[b] - sine * position.0[a];
            out
        };
        // Ends in their order; between them lie chords of arcs.
        let mut wanted = flat.iter().peekable();
        for (_, motion) in &tilted {
            let place = back(&motion.target);
            let Some((start, next)) = wanted.peek() else { panic!("{frame}: more than the way") };
            if (place - next.target).max_abs(&AXES) < 1e-9 {
                wanted.next();
            } else {
                let arc = next.arc.unwrap_or_else(|| panic!("{frame}: {place:?} is no {:?}", next.target));
                let from_center = |p: &AxisVector| (p.0[0] - arc.center_mm[0]).hypot(p.0[1] - arc.center_mm[1]);
                assert!((from_center(&place) - from_center(start)).abs() < 1e-9, "{frame}");
                assert!((place.0[2] - next.target.0[2]).abs() < 1e-9, "{frame}");
            }
        }
        assert!(wanted.next().is_none(), "{frame}");
    }
}

#[test]
fn radius_and_wear_that_the_program_writes() {
    // 5.5 + 0.25 mm from T and D on.
    check(
        [0.0; 3],
        "N10 G17 G90
N12 $TC_DP6[1,1]=5.5
N14 $TC_DP15[1,1]=0.25
N16 T1 D1
N20 G41 G1 X20 Y20 F500
N30 Y60
N40 G40 X0
N50 M30",
        "G1 X14.25 Y20 F500\nG1 X14.25 Y60 F500\nG1 X0 Y60 F500",
    );
}

#[test]
fn a_soft_approach_from_nowhere_is_refused() {
    let strict = || Options { strict: true, ..Options::default() };
    let text = "G17 G90 T1 D1\nG41 G247 DISR=10 DISCL=3 G1 X40 Y-10 Z0 F500\nG1 X60\nG40 X90 Y0\nM30";
    let found = codes(text, strict());
    assert!(found.iter().any(|code| code.ends_with(":2") && code.starts_with('E')), "{found:?}");
    assert!(codes(&text.replace("T1 D1", "T1 D1 G0 X0 Y0 Z20"), strict()).is_empty());
}

#[test]
fn compensation_ends_with_the_next_motion_whatever_the_frame() {
    // The corner of the last element at (60, 65); the frame behind G40 moves the end of the way off it.
    check(
        [0.0; 3],
        "G17 G90 T1 D1
G41 G1 X20 Y60 F500
X60
G40
TRANS X100 Y7
G1 Z3
G0 X0 Y0
TRANS
X0
M30",
        "G1 X20 Y65 F500
        G1 X60 Y65 F500
        G1 X60 Y65 Z3 F500
        G0 X100 Y7 Z3
        G0 X0 Y7 Z3",
    );
    let turned = "G17 G90 T1 D1\nG41 G1 X20 Y60 F500\nX60\nG40\nROT Z90\nG0 X0 Y10\nROT\nM30";
    check([0.0; 3], turned, "G1 X20 Y65 F500\nG1 X60 Y65 F500\nG0 X-10 Y0");
    for frame in ["ROT X30", "MIRROR X0", "G18"] {
        let found = codes(&turned.replace("ROT Z90", frame).replace("Y10", "Y10 Z5"), Options::default());
        assert_eq!(found, ["E0232:6"], "{frame}");
    }
}

/// What stands in the stream, motions by their ends.
fn order(elements: &[Element]) -> Vec<String> {
    let shown = elements.iter().filter_map(|element| match &element.kind {
        Kind::Move(motion) => {
            Some(format!("{:.3} {:.3} {:.3}", motion.target.0[0], motion.target.0[1], motion.target.0[2]))
        }
        Kind::Message(text) | Kind::Comment(text) => Some(String::from_utf8_lossy(text).into_owned()),
        Kind::After(words) => Some(words.iter().map(|word| char::from(word.letter)).collect()),
        _ => None,
    });
    shown.collect()
}

#[test]
fn flow_under_compensation_keeps_the_order() {
    let text = "G17 G90 T1 D1 G0 X0 Y0 Z0
G41 G1 X20 Y20 F500
Y60
MSG(\"A\")
STOPRE
X60
MSG(\"B\")
R1=R1+1
AROUND:
G91 X10
MSG(\"C\")
Y10
ENDLABEL:
REPEAT AROUND P=1
G90 MSG(\"D\")
G40 X200
M30";
    let (elements, codes) = execute(text, &with_radius(5.0), Options::default());
    assert!(codes.is_empty(), "{codes:?}");
    // G41: 5 mm to the left. Steps of 10 mm up and to the right: inner corners at the foot, outer ones at the top.
    let found = order(&elements);
    let messages: Vec<&str> =
        found.iter().map(String::as_str).filter(|text| text.len() < 9 && !text.is_empty()).collect();
    assert_eq!(messages.iter().filter(|text| text.contains('C')).count(), 2, "{found:?}");
    let at = |wanted: &str| {
        found.iter().position(|text| text == wanted).unwrap_or_else(|| panic!("no {wanted} in {found:?}"))
    };
    assert!(at("15.000 60.000 0.000") < at("A") && at("A") < at("B"), "{found:?}");
    assert!(at("B") < at("C") && at("C") < at("D"), "{found:?}");
}

#[test]
fn cycles_and_actual_positions_under_compensation_are_refused() {
    let program = |before: &str, inside: &str| {
        format!(
            "G17 G90 T1 D1 G0 X0 Y0 Z10 F100 S100 M3\n{before}\nG41 G1 X20 Y20\nY60\n{inside}\nX100\nMCALL\nG40 X140\nM30\n"
        )
    };
    let found = |before: &str, inside: &str| codes(&program(before, inside), Options::default());
    assert_eq!(found("", "CYCLE81(10,0,2,-15)"), ["E0232:5"]);
    assert!(found("MCALL CYCLE81(10,0,2,-15)", "").iter().all(|code| code == "E0232:2"));
    assert!(!found("MCALL CYCLE81(10,0,2,-15)", "").is_empty());
    assert_eq!(found("", "R1=$AA_IM[X]"), ["E0219:5"]);
    assert!(found("", "R1=$AA_IM[Z]+$P_EP[X]").is_empty());
}

#[test]
fn subprograms_carry_the_contour_on() {
    let contour = |call: &str, sub: &str, save: &str| {
        format!("G17 G90 T1 D1 G0 X0 Y0 Z0\n{call}\nX100\nG40 X140\nM30\n%_N_SUB_SPF\nPROC SUB{save}\n{sub}\nM17\n")
    };
    // Compensation on in the caller, or by the subprogram for the caller.
    let expected = "G1 X15 Y20 F500
        G1 X15 Y60 F500
        G2/17 X20 Y65 I5 F500
        G1 X60 Y65 F500
        G1 X100 Y65 F500
        G1 X140 Y60 F500";
    check([0.0; 3], &contour("G41 G1 X20 Y20 F500\nY60\nSUB", "X60", ""), expected);
    check([0.0; 3], &contour("SUB", "G41 G1 X20 Y20 F500\nY60\nX60", ""), expected);
    // With SAVE G40 is back in force: the next motion ends it.
    check(
        [0.0; 3],
        &contour("G1 F500\nSUB", "G41 G1 X20 Y20 F500\nY60\nX60", " SAVE"),
        "G1 X15 Y20 F500
        G1 X15 Y60 F500
        G2/17 X20 Y65 I5 F500
        G1 X60 Y65 F500
        G1 X100 Y60 F500
        G1 X140 Y60 F500",
    );
}
