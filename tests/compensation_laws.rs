//! Laws that the way of the tool center keeps for any contour: lengths and areas of parallel curves, distances from the contour.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_language::exec::Options;

use crate::bench_machine::Random;
use crate::compensation::with_radius;
use crate::flat::{execute, moves};

pub(crate) type Point = [f64; 2];

/// A contour element for the eyes of this test: its end, and the center and sense of an arc.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Element {
    pub(crate) start: Point,
    pub(crate) end: Point,
    pub(crate) arc: Option<(Point, bool)>,
}

fn apart(a: Point, b: Point) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

fn angle(from: Point, to: Point) -> f64 {
    (to[1] - from[1]).atan2(to[0] - from[0])
}

/// Swept angle of an arc, signed.
fn sweep(element: &Element, center: Point, clockwise: bool) -> f64 {
    let turned = angle(center, element.end) - angle(center, element.start);
    if clockwise { -(-turned).rem_euclid(TAU) } else { turned.rem_euclid(TAU) }
}

impl Element {
    pub(crate) fn at(&self, share: f64) -> Point {
        match self.arc {
            None => [
                self.start[0] + (self.end[0] - self.start[0]) * share,
                self.start[1] + (self.end[1] - self.start[1]) * share,
            ],
            Some((center, clockwise)) => {
                let turned = angle(center, self.start) + sweep(self, center, clockwise) * share;
                let radius = apart(center, self.start);
                [center[0] + radius * turned.cos(), center[1] + radius * turned.sin()]
            }
        }
    }

    fn length(&self) -> f64 {
        match self.arc {
            None => apart(self.start, self.end),
            Some((center, clockwise)) => apart(center, self.start) * sweep(self, center, clockwise).abs(),
        }
    }

    /// Half of ∮ x dy − y dx.
    fn area(&self) -> f64 {
        let ([x, y], [u, v]) = (self.start, self.end);
        match self.arc {
            None => (x * v - u * y) / 2.0,
            Some((center, clockwise)) => {
                let radius = apart(center, self.start);
                let round = radius * radius * sweep(self, center, clockwise);
                (round + center[0] * (v - y) - center[1] * (u - x)) / 2.0
            }
        }
    }

    /// Distance of a point, by its foot or the ends.
    pub(crate) fn distance(&self, point: Point) -> f64 {
        let ends = apart(point, self.start).min(apart(point, self.end));
        match self.arc {
            None => {
                let (dx, dy) = (self.end[0] - self.start[0], self.end[1] - self.start[1]);
                let share = ((point[0] - self.start[0]) * dx + (point[1] - self.start[1]) * dy) / (dx * dx + dy * dy);
                if (0.0..=1.0).contains(&share) { apart(point, self.at(share)) } else { ends }
            }
            Some((center, clockwise)) => {
                let whole = sweep(self, center, clockwise);
                let turned = angle(center, point) - angle(center, self.start);
                let turned = if clockwise { -(-turned).rem_euclid(TAU) } else { turned.rem_euclid(TAU) };
                if turned.abs() <= whole.abs() {
                    (apart(center, point) - apart(center, self.start)).abs()
                } else {
                    ends
                }
            }
        }
    }

    fn text(&self) -> String {
        let [x, y] = self.end;
        match self.arc {
            None => format!("G1 X{x:.9} Y{y:.9}"),
            Some((center, clockwise)) => {
                let code = if clockwise { 2 } else { 3 };
                format!("G{code} X{x:.9} Y{y:.9} I=AC({:.9}) J=AC({:.9})", center[0], center[1])
            }
        }
    }
}

/// The way of the tool center beside a contour without its first and last motion, and the codes that were found.
pub(crate) fn beside(contour: &[Element], words: &str, radius_mm: f64) -> (Vec<Element>, Vec<String>) {
    let start = contour[0].start;
    let mut text = format!("N1 G17 G90 G0 T1 D1 X0 Y0 Z0\nN2 {words} G1 X{:.9} Y{:.9} F500\n", start[0], start[1]);
    for element in contour {
        writeln!(text, "{}", element.text()).unwrap();
    }
    text.push_str("G40 G1 X0 Y0\nM30\n");
    let (elements, codes) = execute(&text, &with_radius(radius_mm), Options::default());
    let flat = |position: &AxisVector| [position[Axis::X], position[Axis::Y]];
    let all: Vec<Element> = moves(&elements, AxisVector::ZERO)
        .iter()
        .map(|(start, motion)| Element {
            start: flat(start),
            end: flat(&motion.target),
            arc: motion.arc.map(|arc| (arc.center_mm, arc.clockwise)),
        })
        .filter(|element| element.length() > 1e-9)
        .collect();
    for pair in all.windows(2) {
        assert!(apart(pair[0].end, pair[1].start) < 1e-12);
    }
    (all[1..all.len() - 1].to_vec(), codes)
}

/// A polygon that begins and ends in the middle of its first side.
fn closed(corners: &[Point]) -> Vec<Element> {
    let middle = [f64::midpoint(corners[0][0], corners[1][0]), f64::midpoint(corners[0][1], corners[1][1])];
    let mut points = vec![middle];
    points.extend(&corners[1..]);
    points.extend([corners[0], middle]);
    points.windows(2).map(|pair| Element { start: pair[0], end: pair[1], arc: None }).collect()
}

#[test]
fn around_a_convex_polygon_length_and_area_grow_as_steiner_says() {
    let mut random = Random(7);
    for corners in 3..12 {
        // Corners on a circle, counter-clockwise: convex. The tool to the right is outside.
        let mut angles: Vec<f64> =
            (0..corners).map(|k| (f64::from(k) + random.between(0.0, 0.6)) / f64::from(corners) * TAU).collect();
        angles.sort_by(f64::total_cmp);
        let corners: Vec<Point> =
            angles.iter().map(|angle| [300.0 + 100.0 * angle.cos(), 100.0 * angle.sin()]).collect();
        let contour = closed(&corners);
        let radius = random.between(1.0, 30.0);
        let mut machine_words = "G42 G450".to_owned();
        let (way, codes) = beside(&contour, &machine_words, radius);
        assert!(codes.is_empty(), "{codes:?}");
        let sum = |elements: &[Element], of: fn(&Element) -> f64| elements.iter().map(of).sum::<f64>();
        let (length, area) = (sum(&contour, Element::length), sum(&contour, Element::area));
        // Flat corners go to the intersection: more than the arc by 2q tan(b/2) - qb in length, q² tan(b/2) - q²b/2 in area.
        let bends = contour.windows(2).map(|pair| {
            let bend = angle(pair[1].start, pair[1].end) - angle(pair[0].start, pair[0].end);
            (bend + 0.5 * TAU).rem_euclid(TAU) - 0.5 * TAU
        });
        let over: f64 = bends
            .filter(|bend| bend.abs() > 1e-9 && bend.abs() < 10_f64.to_radians())
            .map(|bend| (bend / 2.0).tan() - bend / 2.0)
            .sum();
        assert!((sum(&way, Element::length) - (length + TAU * radius + 2.0 * over * radius)).abs() < 1e-6);
        let wanted = area + length * radius + 0.5 * TAU * radius * radius + over * radius * radius;
        assert!((sum(&way, Element::area) - wanted).abs() < 1e-4, "{corners:?}");
        // Corners as sharp as they come: 2q tan(b/2) each, as long as they bend by 100 degrees at most.
        machine_words = "G42 G451".to_owned();
        let (way, _) = beside(&contour, &machine_words, radius);
        if way.iter().all(|element| element.arc.is_none()) {
            let tips: f64 = contour
                .windows(2)
                .map(|pair| {
                    let bend = angle(pair[1].start, pair[1].end) - angle(pair[0].start, pair[0].end);
                    2.0 * radius * (bend.rem_euclid(TAU) / 2.0).tan()
                })
                .sum();
            assert!((sum(&way, Element::length) - length - tips).abs() < 1e-6);
        }
    }
}

#[test]
fn inside_a_rectangle_the_way_is_a_smaller_rectangle() {
    let corners = [[100.0, 100.0], [180.0, 100.0], [180.0, 150.0], [100.0, 150.0]];
    let (way, codes) = beside(&closed(&corners), "G41", 10.0);
    assert!(codes.is_empty(), "{codes:?}");
    assert_eq!(way.len(), 5);
    assert!((way.iter().map(Element::length).sum::<f64>() - 2.0 * (60.0 + 30.0)).abs() < 1e-9);
    assert!((way.iter().map(Element::area).sum::<f64>() - 60.0 * 30.0).abs() < 1e-9);
}

/// A contour around (300, 0), star-shaped, of lines and arcs.
fn star(random: &mut Random, count: u32) -> Vec<Element> {
    let points: Vec<Point> = (0..=count)
        .map(|k| {
            let (turn, far) = (
                f64::from(k) / f64::from(count) * 5.0,
                random.between(-1.0, 1.0) * 160.0 / f64::from(count.max(8)) + 100.0,
            );
            [(300.0 + far * turn.cos()) * 1.0, far * turn.sin()]
        })
        .collect();
    let bend = |pair: &[Point], bulge: f64| {
        let (a, b) = (pair[0], pair[1]);
        let across = [-(b[1] - a[1]), b[0] - a[0]];
        [f64::midpoint(a[0], b[0]) + bulge * across[0], f64::midpoint(a[1], b[1]) + bulge * across[1]]
    };
    points
        .windows(2)
        .map(|pair| {
            // The center beside the chord: on its left a short counter-clockwise arc.
            let bulge = random.between(0.7, 3.0);
            let arc = match random.between(0.0, 3.0) {
                kind if kind < 1.0 => None,
                kind if kind < 2.0 => Some((bend(pair, bulge), false)),
                _ => Some((bend(pair, -bulge), true)),
            };
            Element { start: pair[0], end: pair[1], arc }
        })
        .collect()
}

#[test]
fn the_tool_keeps_its_distance_from_every_element() {
    let (mut random, mut followed) = (Random(11), 0);
    for round in 0..300_u32 {
        let contour = star(&mut random, 4 + round % 40);
        let radius = random.between(0.5, 15.0);
        let side = if random.chance() { "G41" } else { "G42" };
        let (way, codes) = beside(&contour, side, radius);
        assert!(codes.iter().all(|code| code.starts_with("E0233") || code.starts_with("W0233")), "{codes:?}");
        if codes.iter().any(|code| code.starts_with('E')) {
            continue;
        }
        followed += 1;
        for element in &way {
            for step in 0..=40 {
                let point = element.at(f64::from(step) / 40.0);
                let distance = contour.iter().map(|element| element.distance(point)).fold(f64::INFINITY, f64::min);
                // Programs have nine decimals; flat corners are q / cos(b/2) off, a little more between arcs.
                assert!(distance > radius - 1e-7, "round {round}: {distance} of {radius} at {point:?}");
                assert!(distance < radius * 1.02, "round {round}: {distance} of {radius} at {point:?}");
            }
        }
    }
    assert!(followed > 200, "only {followed} contours were followed");
}

#[test]
fn contours_without_sense_end_and_stay_finite() {
    let mut random = Random(3);
    for round in 0..400 {
        let mut text = "N1 G17 G90 G0 X0 Y0 Z0\nN2 T1 D1 F500\n".to_owned();
        for _ in 0..40 {
            let choice = random.between(0.0, 22.0) as u32;
            let size = 10_f64.powf(random.between(-7.0, 4.0));
            let (x, y) = (random.between(-size, size), random.between(-size, size));
            let _ = match choice {
                0 => writeln!(text, "G41 G1 X{x:.4} Y{y:.4}"),
                1 => writeln!(text, "G42 X{x:.4}"),
                2 => writeln!(text, "G40 G1 X{x:.4} Y{y:.4}"),
                3 => writeln!(text, "G91 G1 X{x:.4} Y{y:.4} RND={size:.4}"),
                4 => writeln!(text, "G90 G1 X{x:.4} CHR={size:.4}"),
                5 => writeln!(text, "G2 I{x:.4} J{y:.4}"),
                6 => writeln!(text, "G3 I{x:.4} J{y:.4} TURN=3 Z{x:.4}"),
                7 => writeln!(text, "G3 X{x:.4} Y{y:.4} CR={:.4}", size * 3.0),
                8 => writeln!(text, "G451 KONT"),
                9 => writeln!(text, "G450 NORM"),
                10 => writeln!(text, "Z{x:.4}"),
                11 => writeln!(text, "D2 M8"),
                12 => writeln!(text, "D0"),
                13 => writeln!(text, "OFFN={x:.4}"),
                14 => writeln!(text, "G1 ANG={x:.4}"),
                15 => writeln!(text, "G247 G41 DISR={size:.4} X{x:.4} Y{y:.4}"),
                16 => writeln!(text, "G40 G348 DISR={size:.4} X{x:.4} Y{y:.4} Z1"),
                17 => writeln!(text, "AROT X{x:.4}\nRNDM={size:.4}"),
                18 => writeln!(text, "AMIRROR X0\nG0 X{x:.4} Y{y:.4}"),
                19 => writeln!(text, "CDON\nG1 X{y:.4} Y{x:.4}"),
                20 => writeln!(text, "G2 X{x:.4} Y{y:.4} CR=-{:.4}", size * 3.0),
                _ => writeln!(text, "G1 X{x:.4} Y{y:.4}"),
            };
        }
        let (elements, _) = execute(&text, &with_radius(5.0), Options::default());
        for (_, motion) in moves(&elements, AxisVector::ZERO) {
            assert!(motion.target.0.iter().all(|value| value.is_finite()), "round {round}\n{text}");
            assert!(motion.feed.is_finite() && !(motion.rapid && motion.arc.is_some()), "round {round}\n{text}");
        }
    }
}
