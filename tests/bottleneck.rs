//! Bottlenecks of compensated contours: where the tool is wider than the contour, nothing is damaged without a word.

use std::f64::consts::TAU;

use ncfix_base::geometry::{AXES, AxisVector};
use ncfix_language::exec::Options;

use crate::bench_machine::Random;
use crate::compensation::with_radius;
use crate::compensation_laws::{Element, Point, beside};
use crate::flat::{execute, moves};

/// A contour through points.
fn through(points: &[Point]) -> Vec<Element> {
    points.windows(2).map(|pair| Element { start: pair[0], end: pair[1], arc: None }).collect()
}

/// The smallest distance of the way from the contour, sampled.
fn nearest(way: &[Element], contour: &[Element]) -> f64 {
    let points = way.iter().flat_map(|element| (0..=60).map(move |step| element.at(f64::from(step) / 60.0)));
    points.fold(f64::INFINITY, |nearest, point| {
        contour.iter().map(|element| element.distance(point)).fold(nearest, f64::min)
    })
}

/// Lines of the walls of its neck, and of the elements beside them.
const DAMAGED: [u32; 6] = [3, 4, 5, 9, 10, 11];

/// A chamber of 108 by 60 mm below a neck.
fn chamber(neck_mm: f64) -> Vec<Element> {
    let right = 100.0 + neck_mm;
    through(&[
        [50.0, 100.0],
        [100.0, 100.0],
        [100.0, 60.0],
        [60.0, 60.0],
        [60.0, 0.0],
        [60.0 + 108.0, 0.0],
        [60.0 + 108.0, 60.0],
        [right, 60.0],
        [right, 100.0],
        [200.0, 100.0],
    ])
}

#[test]
fn a_neck_narrower_than_the_tool_is_found_and_a_wider_one_is_not() {
    for words in ["G41", "G41 CDOF G451", "G41 KONT"] {
        // Both walls of the neck by 2 mm, and the elements that share their corners.
        let (way, codes) = beside(&chamber(8.0), words, 5.0);
        assert_eq!(codes, DAMAGED.map(|line| format!("W0234:{line}")), "{words}");
        assert!((nearest(&way, &chamber(8.0)) - 3.0).abs() < 1e-9);
        assert!(beside(&chamber(10.1), words, 5.0).1.is_empty(), "{words}");
    }
    // Seven elements are more than the look-ahead.
    let (_, codes) = beside(&chamber(8.0), "G41 CDON", 5.0);
    assert_eq!(codes, DAMAGED.map(|line| format!("E0233:{line}")));
    assert!(beside(&chamber(10.1), "G41 CDON", 5.0).1.is_empty());
    // A tool that stays above the neck where its other wall is cut deeper later.
    let program = "N1 G17 G90 T1 D1 G0 X0 Y0 Z0
G41 G1 X20 Y20 F500
X60
Y-40
X30 Y-60
X90 Y-61
Z-5
X68 Y-40
Y20
X90
G40 Y50";
    let (_, codes) = execute(program, &with_radius(5.0), Options::default());
    assert_eq!(codes, ["W0234:3", "W0234:4", "W0234:5"]);
}

#[test]
fn with_cdon_the_way_leaves_out_what_the_tool_cannot_reach() {
    // A keyhole: a neck of 8 mm into a circle of 30 mm. The arcs around the corners of the neck meet 3 mm above it.
    let mut contour =
        through(&[[50.0, 100.0], [100.0, 100.0], [100.0, 60.0], [108.0, 60.0], [108.0, 100.0], [200.0, 100.0]]);
    contour[2].arc = Some(([104.0, 30.0], false));
    let (way, codes) = beside(&contour, "G41 CDOF", 5.0);
    assert_eq!(codes, [3, 4, 5, 6, 7].map(|line| format!("W0234:{line}")));
    assert!(nearest(&way, &contour) < 3.0 + 1e-9);
    let (way, codes) = beside(&contour, "G41 CDON", 5.0);
    assert_eq!(codes, ["W0233:4", "W0233:5", "W0233:6"]);
    assert!(nearest(&way, &contour) > 5.0 - 1e-9);
    let ends: Vec<Point> = way.iter().map(|element| element.end).collect();
    let wanted = [[100.0, 105.0], [104.0, 103.0], [108.0, 105.0], [200.0, 105.0]];
    assert_eq!(ends.len(), wanted.len(), "{ends:?}");
    assert!(ends.iter().zip(wanted).all(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-9), "{ends:?}");
}

#[test]
fn a_spiral_is_too_tight_where_its_turns_are() {
    // Turns of an Archimedean spiral of lines, 12 a turn, from outside inward: the tool on the inner side.
    let spiral = |pitch: f64| {
        let points: Vec<Point> = (0..40)
            .map(|k| {
                let turn = f64::from(k) / 12.0;
                let far = 150.0 - pitch * turn;
                [300.0 + far * (turn * TAU).cos(), far * (turn * TAU).sin()]
            })
            .collect();
        through(&points)
    };
    // The wall of the next turn is nearer by the pitch; look-ahead 4 watches over 12 elements, which is one turn.
    for (pitch, is_tight) in [(8.0, true), (9.0, true), (22.0, false), (30.0, false)] {
        let contour = spiral(pitch);
        let (way, codes) = beside(&contour, "G41", 5.0);
        assert_eq!(!codes.is_empty(), is_tight, "{pitch}: {codes:?}");
        assert!(codes.iter().all(|code| code.starts_with("W0234")), "{pitch}: {codes:?}");
        assert_eq!(nearest(&way, &contour) < 5.0 - 2e-3, is_tight, "{pitch}");
    }
}

#[test]
fn contours_with_notches_keep_their_distance_or_say_where_not() {
    let (mut random, mut clean, mut damaged, mut left_out) = (Random(5), 0, 0, 0);
    for round in 0..400 {
        let corners = 4 + round % 8;
        let mut points: Vec<Point> = vec![[200.0, 0.0]];
        for k in 1..corners {
            // A notch of two or three corners between the teeth, deep and often narrow.
            let turn = |k: f64| k / f64::from(corners) * 5.5;
            let at = |turn: f64, far: f64| [300.0 - far * turn.cos(), far * turn.sin()];
            let (here, width) = (turn(f64::from(k)), random.between(0.01, 0.25));
            points.push(at(here - width, 100.0));
            points.push(at(here, random.between(30.0, 80.0)));
            if random.chance() {
                points.push(at(here + random.between(0.0, 0.2), random.between(30.0, 80.0)));
            }
            points.push(at(here + width, 100.0));
        }
        let contour = through(&points);
        let words = ["G41", "G42", "G41 CDON", "G42 CDON G451"][round as usize % 4];
        let radius = random.between(1.0, 12.0);
        let (way, codes) = beside(&contour, words, radius);
        assert!(codes.iter().all(|code| ["E0233", "W0233", "W0234"].contains(&&code[..5])), "{codes:?}");
        let near = nearest(&way, &contour);
        let is_found = codes.iter().any(|code| code.starts_with("E0233") || code.starts_with("W0234"));
        if is_found {
            damaged += 1;
        } else {
            clean += 1;
            left_out += i32::from(!codes.is_empty());
            assert!(near > radius - 2.1e-3, "round {round} {words}: {near} of {radius} {codes:?}");
        }
    }
    assert!(clean > 100 && damaged > 20 && left_out > 20, "{clean} {damaged} {left_out}");
}

#[test]
fn the_first_and_the_last_element_of_a_closed_contour_may_cross() {
    // Around a plate of 60 by 40 mm that begins 4 mm before its corner and ends 9 mm behind it; then a slot into it of 8 mm.
    let program = |slot: &str| {
        format!("N1 G17 G90 T1 D1 G0 X-20 Y-20 Z0\nG41 G1 X0 Y-4 F500\nY40\n{slot}X60\nY0\nX-9\nG40 X-20 Y-20\nM30")
    };
    let start = Options { strict: true, ..Options::default() };
    let (_, codes) = execute(&program(""), &with_radius(5.0), start);
    assert!(codes.is_empty(), "{codes:?}");
    let (_, codes) =
        execute(&program("X20\nY20\nX5\nY10\nX40\nY20\nX28\nY40\n"), &with_radius(5.0), Options::default());
    assert!(codes.contains(&"W0234:5".to_owned()) && codes.contains(&"W0234:11".to_owned()), "{codes:?}");
    assert!(!codes.contains(&"W0234:3".to_owned()) && codes.iter().all(|code| code.starts_with('W')), "{codes:?}");
}

#[test]
fn the_way_onto_a_closed_contour_and_off_it_is_no_wall() {
    // Onto a pocket of 30 by 30 mm and off it by quarters of a circle of 8 mm; 3 mm more than once around.
    let program = |words: &str, over: f64| {
        let end = 15.0 + over;
        format!(
            "N1 G17 G90 T1 D1 G0 X15 Y15 Z0
G41 {words} G1 X7 Y8 F500
G3 X15 Y0 CR=8
G1 X30
Y30
X0
Y0
X{end}
G3 X{} Y8 CR=8
G40 G1 X15 Y15
M30",
            end + 8.0
        )
    };
    for words in ["CDOF", "CDON"] {
        for over in [0.0, 3.0] {
            let (elements, codes) = execute(&program(words, over), &with_radius(5.0), Options::default());
            assert!(codes.is_empty(), "{words} {over} {codes:?}");
            let count = moves(&elements, AxisVector::ZERO)
                .iter()
                .filter(|(start, motion)| (motion.target - *start).max_abs(&AXES) > 1e-9)
                .count();
            assert_eq!(count, 10);
        }
    }
}

#[test]
fn a_full_circle_in_one_block_closes_by_itself() {
    // A bore of 40 mm, onto it and off it by quarters of 10 mm; and the same by half circles.
    for circle in ["G3 X20 Y0 I-20 J0", "G3 X-20 Y0 CR=20\nX20 Y0 CR=20"] {
        let program = format!(
            "G17 G90 T1 D1 G0 X0 Y0 Z0\nG1 G41 X10 Y-10 F500\nG3 X20 Y0 CR=10\n{circle}\nG3 X10 Y10 CR=10\nG40 G1 X0 Y0\nM30"
        );
        let (_, codes) = execute(&program, &with_radius(5.0), Options::default());
        assert!(codes.is_empty(), "{circle}: {codes:?}");
    }
}
