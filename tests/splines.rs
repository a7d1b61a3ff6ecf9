//! Splines and polynomials as chords: the curve they stand for, the ends, what stands between their blocks.

use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_machine::snc::{Element, Kind};

use crate::bench_machine::Random;
use crate::five_axis::{elements, execute};
use crate::machines::xyz_machine;

/// Ends of all moves from a line of the program on, with the start of the first.
fn points(text: &str, from_line: u32) -> Vec<[f64; 3]> {
    let elements = elements(text, &xyz_machine());
    let mut last = [0.0; 3];
    let mut points = Vec::new();
    for element in &elements {
        if let Kind::Move(motion) = &element.kind {
            let here = [motion.target[Axis::X], motion.target[Axis::Y], motion.target[Axis::Z]];
            if element.origin.line >= from_line {
                if points.is_empty() {
                    points.push(last);
                }
                points.push(here);
            }
            last = here;
        }
    }
    points
}

/// Distance of a point from a chain of chords.
fn off(chain: &[[f64; 3]], point: [f64; 3]) -> f64 {
    let mut least = f64::INFINITY;
    for pair in chain.windows(2) {
        let way: [f64; 3] = std::array::from_fn(|k| pair[1][k] - pair[0][k]);
        let to: [f64; 3] = std::array::from_fn(|k| point[k] - pair[0][k]);
        let square: f64 = way.iter().map(|part| part * part).sum();
        let share = if square > 0.0 {
            (way.iter().zip(to).map(|(a, b)| a * b).sum::<f64>() / square).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let distance: f64 = (0..3).map(|k| (to[k] - share * way[k]).powi(2)).sum::<f64>().sqrt();
        least = least.min(distance);
    }
    least
}

const TOLERANCE: f64 = 2.5e-4;

#[test]
fn a_polynomial_is_its_curve() {
    let chain = points("N10 G17 G90 G1 X0 Y0 Z0 F600\nN20 POLY PO[X]=(4,0.25) PO[Y]=(2) PL=4\n", 2);
    for k in 0..=100 {
        let p = f64::from(k) * 0.04;
        assert!(off(&chain, [0.25 * p * p, 0.5 * p, 0.0]) <= TOLERANCE);
    }
    // And no end of a chord is elsewhere.
    assert!(chain.iter().all(|[x, y, _]| (x - y * y).abs() < 1e-9));
    assert_eq!(chain.last(), Some(&[4.0, 2.0, 0.0]));
    assert!((10..200).contains(&chain.len()), "{}", chain.len());
}

#[test]
fn a_denominator_makes_a_quarter_circle() {
    let text = "N1 G17 G90 G1 X10 Y0 Z0 F600\nN2 POLY PO[X]=(0,-10) PO[Y]=(10) PO[]=(2,1) Z3\n";
    let chain = points(text, 2);
    assert!(chain.iter().all(|[x, y, _]| (x.hypot(*y) - 10.0).abs() < 1e-9));
    // Z keeps its proportion to the parameter: at p = 1/2 the curve is at (6, 8).
    assert!(off(&chain, [6.0, 8.0, 1.5]) <= TOLERANCE);
    assert_eq!(chain.last(), Some(&[0.0, 10.0, 3.0]));
    // The same in inch, shifted and turned, is a circle about the shifted zero.
    let text = "N1 G17 G90 G70 TRANS X1 Y2\nAROT Z30\nN2 G1 X1 Y0 Z0 F60\nN3 POLY PO[X]=(0,-1) PO[Y]=(1) PO[]=(2,1)\n";
    let chain = points(text, 4);
    assert!(chain.iter().all(|[x, y, _]| ((x - 25.4).hypot(y - 50.8) - 25.4).abs() < 1e-9));
    let [x, y, _] = chain[chain.len() - 1];
    assert!((x - 25.4 + 25.4 * 0.5).abs() < 1e-9 && (y - 50.8 - 25.4 * 0.75_f64.sqrt()).abs() < 1e-9);
}

#[test]
fn axes_without_polynomial_and_blocks_without_poly_are_straight() {
    let chain = points("N1 G17 G90 G1 X1 Y1 Z1 F600\nN2 POLY X4 Y2\nN3 G1 PO[X]=(8,5)\n", 2);
    assert_eq!(chain, [[1.0, 1.0, 1.0], [4.0, 2.0, 1.0], [8.0, 2.0, 1.0]]);
}

#[test]
fn a_b_spline_follows_its_polygon() {
    let text = "N10 G17 G90 G1 X0 Y0 Z0 F500\nN20 BSPLINE X10 Y20\nN30 X20 Y20\nN40 X30 Y0\nN50 G1 X40\n";
    let chain = points(text, 2);
    // The cubic Bernstein polynomials of (0 0) (10 20) (20 20) (30 0), by hand.
    for point in [[0.0, 0.0], [7.5, 11.25], [15.0, 15.0], [22.5, 11.25], [30.0, 0.0]] {
        assert!(off(&chain, [point[0], point[1], 0.0]) <= TOLERANCE);
    }
    assert!(
        chain.iter().take(chain.len() - 1).all(|[x, y, _]| (y - 60.0 * (x / 30.0) * (1.0 - x / 30.0)).abs() < 1e-9)
    );
    assert_eq!(chain[chain.len() - 2..], [[30.0, 0.0, 0.0], [40.0, 0.0, 0.0]]);
    // Degree 2 with a weight of 1/√2: a quarter of a circle.
    let text = "N1 G17 G90 G1 X10 Y0 Z0 F500\nN2 BSPLINE SD=2 X10 Y10 PW=0.7071067811865476\nN3 X0 Y10\nN4 G1 X0 Y0\n";
    let chain = points(text, 2);
    assert!(chain.iter().take(chain.len() - 1).all(|[x, y, _]| (x.hypot(*y) - 10.0).abs() < 1e-9));
}

/// Points of a circle: the cubic spline comes near to it, meets all points and has no corner.
#[test]
fn splines_through_points_meet_them_and_turn_smoothly() {
    for (kind, near) in [("CSPLINE", 2e-3), ("ASPLINE", 2e-2)] {
        let place = |k: u32| (f64::from(k) * 10.0).to_radians().sin_cos();
        let mut text = String::from("N1 G17 G90 G1 X20 Y0 Z0 F500 BTAN ETAN\nN2 Y0.001\n");
        let mut through = Vec::new();
        for k in 1..=36 {
            let (y, x) = place(k);
            text += &format!("N{} {} X{:.6} Y{:.6}\n", k + 2, if k == 1 { kind } else { "" }, 20.0 * x, 20.0 * y);
            through.push([(20.0 * x * 1e6).round() / 1e6, (20.0 * y * 1e6).round() / 1e6, 0.0]);
        }
        text += "N99 G1 Y10\n";
        let chain = points(&text, 3);
        for point in &through {
            assert!(chain.iter().any(|end| (0..3).all(|k| (end[k] - point[k]).abs() < 1e-9)), "{kind} {point:?}");
        }
        let circle = &chain[..chain.len() - 1];
        assert!(circle.iter().all(|[x, y, _]| (x.hypot(*y) - 20.0).abs() < near), "{kind}");
        for three in circle.windows(3) {
            let heading = |a: [f64; 3], b: [f64; 3]| (b[1] - a[1]).atan2(b[0] - a[0]);
            let turn = (heading(three[1], three[2]) - heading(three[0], three[1])).sin();
            assert!(turn.abs() < 0.05, "{kind}: a corner of {turn}");
        }
    }
}

#[test]
fn what_stands_between_the_blocks_of_a_spline_keeps_its_place() {
    let text = "N1 G17 G90 G1 X0 Y0 Z0 F500\nN2 CSPLINE X10 Y5\nN3 M8\nN4 X20 Y0 F300\nN5 MSG(\"NOW\")\nN6 X30 Y5 M9\nN7 G1 X40\n";
    let elements = elements(text, &xyz_machine());
    let lines: Vec<u32> = elements.iter().map(|element| element.origin.line).collect();
    assert!(lines.is_sorted(), "{lines:?}");
    let moves = |line: u32| {
        let of_line = |element: &&Element| element.origin.line == line;
        elements.iter().filter(of_line).filter(|e| matches!(e.kind, Kind::Move(_))).count()
    };
    assert!(moves(2) > 3 && moves(4) > 3 && moves(6) > 3 && moves(7) == 1);
    let feed = |line: u32| {
        let of_line = elements.iter().filter(|element| element.origin.line == line);
        of_line
            .filter_map(|element| if let Kind::Move(motion) = &element.kind { Some(motion.feed) } else { None })
            .next()
    };
    assert_eq!((feed(2), feed(4)), (Some(500.0), Some(300.0)));
    // A natural end has no curvature: the last chords turn less and less.
    let last: Vec<AxisVector> = elements
        .iter()
        .filter_map(|e| if let Kind::Move(motion) = &e.kind { Some(motion.target) } else { None })
        .collect();
    assert_eq!(last[last.len() - 2][Axis::X], 30.0);
}

#[test]
fn faults_of_curves_are_found() {
    let start = "N1 G17 G90 G1 X0 Y0 Z0 F500\n";
    for (text, code) in [
        ("N2 POLY PO[X]=(1,2,3,4,5,6)\n", "E0210"),
        ("N2 POLY PO[X]=(1,2) PL=0\n", "E0210"),
        ("N2 POLY PO[X]=(1,2) PO[]=(-1,2)\n", "E0210"),
        ("N2 BSPLINE X1 PW=-1\n", "E0210"),
        ("N2 BSPLINE X1 SD=4\n", "E0210"),
        ("N2 BSPLINE X1 Y3 PL=1\nN3 X3 PL=2\nN4 G1 X9\n", "E0201"),
        ("N2 G5\n", "E0201"),
        ("N2 INVCW X10 Y0 I1\n", "E0201"),
    ] {
        let (_, found) = execute(&format!("{start}{text}"), &xyz_machine());
        assert_eq!(found.first().map(|finding| finding.code.as_str()), Some(code), "{text}: {found:#?}");
    }
    let (_, found) = execute("N1 CSPLINE X1 Y1 F100\n", &xyz_machine());
    assert_eq!(found[0].code.as_str(), "E0304");
}

/// Whatever the points: an end in bounded time, no panic, the last point met.
#[test]
fn wild_points_come_to_an_end() {
    let mut random = Random(8);
    for kind in ["ASPLINE", "BSPLINE", "CSPLINE"] {
        for ends in ["BNAT ENAT", "BTAN ETAN", "BAUTO EAUTO"] {
            let mut text = format!("N1 G17 G90 {ends} G1 X0 Y0 Z0 F500\nN2 {kind}\n");
            for _ in 0..40 {
                let size = 10_f64.powf(random.between(-4.0, 3.0));
                let [x, y, z] = std::array::from_fn(|_| random.between(-size, size));
                text += &format!("X{x:.4} Y{y:.4} Z{z:.4}\n");
                if random.chance() && random.chance() {
                    text += &format!("X{x:.4}\n");
                }
            }
            text += "X1 Y2 Z3\nG1 X4\n";
            let chain = points(&text, 2);
            let last = chain[chain.len() - 2];
            assert_eq!(last, [1.0, 2.0, 3.0], "{kind} {ends}");
            assert!(chain.iter().flatten().all(|value| value.is_finite()));
        }
    }
}
