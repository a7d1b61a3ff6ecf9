//! Radius compensation of Fanuc, RS274/NGC and Grundig at the stage: expected values from a reference and from arithmetic.

use super::ContourModal;
use super::curve::{Curve, add, left, scaled};
use super::fixture::Fixture;
use ncfix_machine::machine::{CompensationCorner, CompensationStart, Control};

fn fanuc(start: CompensationStart, corner: Option<CompensationCorner>) -> Fixture {
    let control = Control { compensation_start: start, compensation_corner: corner, ..Control::default() };
    Fixture::new(control, ContourModal::fanuc, 5.0)
}

fn grundig(corner: Option<CompensationCorner>) -> Fixture {
    let control = Control { compensation_corner: corner, ..Control::default() };
    Fixture { start: [-30.0, 20.0, 0.0], ..Fixture::new(control, ContourModal::grundig, 5.0) }
}

const A: CompensationStart = CompensationStart::A;
const B: CompensationStart = CompensationStart::B;
const CIRCULAR: Option<CompensationCorner> = Some(CompensationCorner::Circular);
const LINEAR: Option<CompensationCorner> = Some(CompensationCorner::Linear);

#[test]
fn fanuc_goes_to_the_intersection_of_right_angles() {
    fanuc(A, None).check(
        "G41 G1 X20 Y20 F500
        Y60
        X60
        Y40
        X80
        G40 X100 Y40",
        "G1 X15 Y20 F500
        G1 X15 Y65 F500
        G1 X65 Y65 F500
        G1 X65 Y45 F500
        G1 X80 Y45 F500
        G1 X100 Y40 F500",
    );
}

/// The tool reaches the contour at X0 Y0, turns by 149.036° at X0 Y50 and leaves at X30.
const ACUTE: &str = "G41 G1 X0 Y0
    Y50
    X30 Y0
    G40 X50";

#[test]
fn fanuc_around_an_acute_corner() {
    let bench = |corner| onto([-20.0, 0.0, 0.0], fanuc(A, corner));
    bench(LINEAR).check(
        ACUTE,
        "G1 X-5
        G1 X-5 Y55
        G1 X1.715 Y56.8599
        G1 X34.2875 Y2.5725
        G1 X50",
    );
    bench(CIRCULAR).check(
        ACUTE,
        "G1 X-5
        G1 X-5 Y50
        G2 X4.2875 Y52.5725 I5
        G1 X34.2875 Y2.5725
        G1 X50",
    );
}

#[test]
fn grundig_to_the_contour_then_along_it() {
    let text = "F300
        G43 X0
        G41
        Y60
        X40
        Y80
        G40
        G1 X0 Y100";
    grundig(None).check(
        text,
        "G1 X-5 Y20 F300
        G1 X-5 Y60 F300
        G2 Y65 I5 F300
        G1 X35 Y65 F300
        G1 X35 Y80 F300
        G1 Y100 F300",
    );
    grundig(LINEAR).check(
        text,
        "G1 X-5 Y20 F300
        G1 X-5 Y65 F300
        G1 X35 Y65 F300
        G1 X35 Y80 F300
        G1 Y100 F300",
    );
}

/// After X20 Y20 the contour goes up.
fn onto(start: [f64; 3], bench: Fixture) -> Fixture {
    Fixture { start, ..bench }
}

const UP: &str = "G41 G1 X20 Y20
    Y60
    G40 X0";

#[test]
fn fanuc_begins_by_type_a_or_b() {
    // Before the contour both are equal.
    for start in [A, B] {
        fanuc(start, None).check(UP, "G1 X15 Y20\nG1 X15 Y60\nG1 Y60");
    }
    // From 45° behind it: 5 mm perpendicular to the block, then 5 · tan 22.5° to the intersection.
    onto([40.0, 0.0, 0.0], fanuc(A, None)).check(UP, "G1 X15 Y20\nG1 X15 Y60\nG1 Y60");
    onto([40.0, 0.0, 0.0], fanuc(B, None)).check(UP, "G1 X16.4645 Y16.4645\nG1 X15 Y17.9289\nG1 X15 Y60\nG1 Y60");
    // The corner turns by 135°: a radius beyond it on both sides.
    onto([50.0, 50.0, 0.0], fanuc(B, None))
        .check(UP, "G1 X23.5355 Y16.4645\nG1 X20 Y12.9289\nG1 X15 Y15\nG1 X15 Y60\nG1 Y60");
    onto([50.0, 50.0, 0.0], fanuc(B, CIRCULAR))
        .check(UP, "G1 X23.5355 Y16.4645\nG2 X15 Y20 I-3.5355 J3.5355\nG1 X15 Y60\nG1 Y60");
}

#[test]
fn fanuc_ends_by_type_a_or_b_or_along_a_direction() {
    let along = |end: &str| format!("G41 G1 X20 Y40\nX80\n{end}");
    let bench = |start| onto([0.0, 40.0, 0.0], fanuc(start, None));
    bench(A).check(&along("G40 X100 Y20"), "G1 X20 Y45\nG1 X80 Y45\nG1 X100 Y20");
    // Mirrored to the start: the intersection is 5 · tan 22.5° beyond the end.
    bench(B).check(&along("G40 X100 Y20"), "G1 X20 Y45\nG1 X82.0711 Y45\nG1 X83.5355 Y43.5355\nG1 X100 Y20");
    // As if the contour continued down, up, or straight on.
    bench(A).check(&along("G40 X100 Y20 I0 J-10"), "G1 X20 Y45\nG1 X85 Y45\nG1 X100 Y20");
    bench(A).check(&along("G40 X100 Y20 I0 J10"), "G1 X20 Y45\nG1 X75 Y45\nG1 X100 Y20");
    bench(B).check(&along("G40 X100 Y20 I10 J0"), "G1 X20 Y45\nG1 X80 Y45\nG1 X100 Y20");
}

#[test]
fn fanuc_goes_straight_onto_the_tangents_of_arcs() {
    let bench = |radius| Fixture { start: [-20.0, 0.0, 0.0], radius_mm: radius, ..fanuc(A, None) };
    // A right angle: via its tip.
    bench(5.0).check(
        "G41 G1 X0 Y0\nY50\nG2 X10 Y40 I0 J-10\nG1 Y0\nG40 X30",
        "G1 X-5\nG1 X-5 Y55\nG1 Y55\nG2 X15 Y40 J-15\nG1 X15\nG1 X30",
    );
    // The arc begins in the direction (0.6, -0.8), turned by 143°; its center is on its left, with the tool.
    bench(5.0).check(
        "G41 G1 X0 Y0\nY50 F100\nG3 X16 Y42 I16 J12 F200\nG1 X40\nG40 X50 Y60",
        "G1 X-5
        G1 X-5 Y55 F100
        G1 X1 Y57 F200
        G1 X4 Y53 F200
        G3 X16 Y47 I12 J9 F200
        G1 X40 Y47 F200
        G1 X50 Y60 F200",
    );
    // After an arc the straight path is the block's own, and the following items come at its end: the mirror image.
    bench(5.0).check(
        "G42 G1 X0 Y-42\nX24\nG2 X40 Y-50 I0 J-20 F200\n(here)\nG1 X40 Y0 F100\nG40 X60",
        "G1 Y-47
        G1 X24 Y-47
        G2 X36 Y-53 J-15 F200
        G1 X39 Y-57 F200
        (here)
        G1 X45 Y-55 F100
        G1 X45 F100
        G1 X60 F100",
    );
}

#[test]
fn only_sinumerik_leaves_out_what_the_tool_does_not_reach() {
    let text = "G41 G1 X0 Y0\nY20\nX-3\nY40\nG40 X-30";
    onto([20.0, 0.0, 0.0], fanuc(A, None)).check_codes(text, &["E0233:3"]);
    onto([20.0, 0.0, 0.0], grundig(None)).check_codes(text, &["E0233:3"]);
    let sinumerik = Fixture { modal: ContourModal::default(), ..onto([20.0, 0.0, 0.0], fanuc(A, None)) };
    sinumerik.check_codes(text, &["W0233:3"]);
}

#[test]
fn sides_change_back_along_the_same_line_only() {
    // Up on the left and down on the right is the same tool path.
    fanuc(A, None).check("G41 G1 X20 Y20\nY60\nG42 Y20\nG40 X0", "G1 X15 Y20\nG1 X15 Y60\nG1 X15 Y20\nG1 Y20");
    fanuc(A, None).check_codes("G41 G1 X20 Y20\nY60\nG42 X60\nG40 Y90", &["E0232:3"]);
    grundig(None).check_codes("G41 G1 X20 Y20\nY60\nG42 Y20\nG40 X0", &["E0232:3"]);
}

#[test]
fn fanuc_programmed_again_begins_square_to_the_last_element() {
    // Outside and inside: the previous element ends 5 mm beside its end.
    fanuc(A, None).check(
        "G41 G1 X20 Y20\nY60\nG41 X60\nY40\nG40 X90",
        "G1 X15 Y20\nG1 X15 Y60\nG1 X65 Y65\nG1 X65 Y40\nG1 X90 Y40",
    );
    fanuc(A, None).check_codes("G41 G1 X20 Y20\nY60\nG41 G2 X30 Y70 I10 J0\nG40 G1 X90", &["E0232:3"]);
}

#[test]
fn grundig_to_and_past_an_end() {
    // 5 mm along (0.6, 0.8) are (3, 4); the height moves at the tool position, and G40 leads to the programmed end.
    grundig(None).check(
        "G43 X0 Y60\nZ-3\nG44 X-30 Y20\nG40 X-30 Y0\nX0",
        "G1 X-3 Y56\nG1 X-3 Y56 Z-3\nG1 X-33 Y16 Z-3\nG1 X-30 Z-3\nG1 Z-3",
    );
    grundig(None).check("G44 X0\nG42\nY60\nG40 X30", "G1 X5 Y20\nG1 X5 Y60\nG1 X30 Y60");
    // The end that the program has already reached.
    grundig(None).check("G43 X0\nG40 X0\nX10", "G1 X-5 Y20\nG1 Y20\nG1 X10 Y20");
    // On the wrong side, and not perpendicular to the contour.
    grundig(None).check_codes("G43 X0\nG42\nY60\nG40 X30", &["E0232:3"]);
    grundig(None).check_codes("G43 X0 Y60\nG41\nY90\nG40 X-30", &["E0232:3"]);
    grundig(None).check_codes("G43 X0\nG2 X10 Y30 I0 J10", &["E0232:2"]);
}

#[test]
fn grundig_alone_begins_with_the_next_motion() {
    grundig(None).check("G41\nX0\nY60\nG40\nX-30", "G1 X-5 Y20\nG1 X-5 Y60\nG1 X-30 Y60");
}

/// A pseudo-random generator.
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Motions from X0 Y0 that bend away from a tool on their left, as text and as curves.
fn convex(random: &mut Random) -> (String, Vec<Curve>) {
    let (mut text, mut curves) = (String::new(), Vec::new());
    let (mut place, mut heading) = ([0.0_f64; 2], 0.0_f64);
    // Limited so that the contour does not intersect itself.
    let mut left = 3.0;
    for k in 0..6 {
        let bend = random.between(0.0, left);
        let turns = if k == 0 || random.between(0.0, 1.0) < 0.3 { 0.0 } else { bend };
        left -= turns;
        heading -= turns;
        let start = place;
        if random.between(0.0, 1.0) < 0.3 {
            let (radius, sweep) = (random.between(1.0, 30.0), random.between(0.0, left).max(1e-3));
            left -= sweep;
            let offset = [radius * heading.sin(), -radius * heading.cos()];
            heading -= sweep;
            let center = [start[0] + offset[0], start[1] + offset[1]];
            place = [center[0] - radius * heading.sin(), center[1] + radius * heading.cos()];
            text += &format!("G2 X{} Y{} I{} J{}\n", place[0], place[1], offset[0], offset[1]);
            curves.push(Curve::arc(start, place, center, true, 0));
        } else {
            let length = random.between(1.0, 40.0);
            place = [start[0] + length * heading.cos(), start[1] + length * heading.sin()];
            text += &format!("G1 X{} Y{}\n", place[0], place[1]);
            curves.push(Curve::Line { start, end: place });
        }
        left = f64::max(left, 0.0);
    }
    (text, curves)
}

/// The move of a line of the fixture, from a position.
fn move_of(text: &str, start: [f64; 2]) -> Curve {
    let word = |letter: char| {
        text.split_whitespace().find_map(|word| word.strip_prefix(letter)).map_or(0.0, |value| value.parse().unwrap())
    };
    let end = [word('X'), word('Y')];
    let center = [start[0] + word('I'), start[1] + word('J')];
    match &text[..2] {
        "G2" => Curve::arc(start, end, center, true, 0),
        "G3" => Curve::arc(start, end, center, false, 0),
        _ => Curve::Line { start, end },
    }
}

#[test]
fn around_outer_corners_the_tool_keeps_its_distance_and_misses_nothing() {
    let mut random = Random(7);
    for round in 0..300 {
        let (text, contour) = convex(&mut random);
        let corner = if round % 2 == 0 { LINEAR } else { CIRCULAR };
        let start = [-40.0, random.between(-30.0, 60.0), 0.0];
        let begins = if round % 3 == 0 { A } else { B };
        let mut bench = onto(start, if round % 5 == 0 { grundig(corner) } else { fanuc(begins, corner) });
        bench.radius_mm = random.between(0.5, 9.0);
        let last = contour.last().unwrap();
        let away = add(last.end(), scaled(left(last.last_tangent()), 100.0));
        let (moves, codes) = bench.run(&format!("G41 G1 X0 Y0\n{text}G40 G1 X{} Y{}", away[0], away[1]));
        assert!(codes.is_empty(), "{codes:?} {text}");
        let mut place = [start[0], start[1]];
        let mut way = Vec::new();
        for text in &moves {
            let curve = move_of(text, place);
            place = curve.end();
            way.push(curve);
        }
        // Decimals of the fixture.
        let tolerance = 2e-3;
        for element in &contour {
            for (index, curve) in way.iter().enumerate().take(way.len() - 1).skip(1) {
                let gap = curve.gap(element, 1e3);
                assert!(
                    gap > bench.radius_mm - tolerance,
                    "{round}: move {index} {gap} of {}\n{text}\n{moves:#?}",
                    bench.radius_mm
                );
            }
            for share in [0.01, 0.5, 0.99] {
                let along = element.length() * share;
                let beside = add(element.at(along), scaled(left(element.tangent(along)), bench.radius_mm));
                let missed = way.iter().map(|curve| curve.distance(beside)).fold(f64::INFINITY, f64::min);
                assert!(missed < tolerance, "{round}: {missed} at {beside:?}\n{text}\n{moves:#?}");
            }
        }
    }
}

#[test]
fn whatever_comes_moves_hang_together() {
    let mut random = Random(3);
    let rules: [fn(&Control) -> ContourModal; 4] =
        [|_| ContourModal::default(), ContourModal::fanuc, |_| ContourModal::rs274(), ContourModal::grundig];
    for round in 0..4000 {
        let control = Control {
            compensation_start: if round % 8 < 4 { A } else { B },
            compensation_corner: [None, LINEAR, CIRCULAR][round / 4 % 3],
            ..Control::default()
        };
        let mut bench = Fixture::new(control, rules[round % 4], [5.0, 0.0, -3.0, 1e-9, 1e9][(round / 7) % 5]);
        bench.start = [random.between(-9.0, 9.0).round(), 0.0, 0.0];
        let mut place = [bench.start[0], 0.0];
        let mut text = String::new();
        for _ in 0..random.between(1.0, 14.0) as usize {
            let end = [random.between(-20.0, 20.0).round(), random.between(-20.0, 20.0).round()];
            let code = ["", "", "", "", "G40 ", "G41 ", "G42 ", "G43 ", "G44 "]
                [random.between(0.0, if round % 4 == 3 { 8.99 } else { 6.99 }) as usize];
            match random.between(0.0, 6.0) as usize {
                0 => text += &format!("{code}\n"),
                1 => text += &format!("{code}G1 Z{}\n", end[0]),
                2 => {
                    // A point on the perpendicular bisector, sometimes the middle; a full circle if the ends are equal.
                    let [dx, dy] = [end[0] - place[0], end[1] - place[1]];
                    let share = random.between(-2.0, 2.0).round() / 2.0;
                    let [i, j] = if dx == 0.0 && dy == 0.0 {
                        [2.0, 0.0]
                    } else {
                        [dx / 2.0 - dy * share, dy / 2.0 + dx * share]
                    };
                    text += &format!("{code}G{} X{} Y{} I{i} J{j}\n", 2 + round % 2, end[0], end[1]);
                    place = end;
                }
                3 => {
                    text += &format!("{code}G0 X{} Y{}\n", end[0], end[1]);
                    place = end;
                }
                _ => {
                    text += &format!("{code}G1 X{} Y{} Z1\n", end[0], place[1]);
                    place[0] = end[0];
                }
            }
        }
        let (moves, codes) = bench.run(&text);
        assert!(!codes.is_empty() || moves.len() <= 200, "{text}");
    }
}
