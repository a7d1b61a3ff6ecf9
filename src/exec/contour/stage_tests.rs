//! Radius compensation of Fanuc, RS274/NGC and Grundig at the stage: what a reference lists, and what arithmetic says.

use super::ContourModal;
use super::bench::Bench;
use crate::machine::{CompensationCorner, CompensationStart, Control};

fn fanuc(start: CompensationStart, corner: Option<CompensationCorner>) -> Bench {
    let control = Control { compensation_start: start, compensation_corner: corner, ..Control::default() };
    Bench::new(control, ContourModal::fanuc, 5.0)
}

fn grundig(corner: Option<CompensationCorner>) -> Bench {
    let control = Control { compensation_corner: corner, ..Control::default() };
    Bench { start: [-30.0, 20.0, 0.0], ..Bench::new(control, ContourModal::grundig, 5.0) }
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

/// The tool comes onto the contour at X0 Y0, bends by 149.036° at X0 Y50 and leaves at X30.
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

/// Behind X20 Y20 the contour goes up.
fn onto(start: [f64; 3], bench: Bench) -> Bench {
    Bench { start, ..bench }
}

const UP: &str = "G41 G1 X20 Y20
    Y60
    G40 X0";

#[test]
fn fanuc_begins_by_type_a_or_b() {
    // In front of the contour both are the same.
    for start in [A, B] {
        fanuc(start, None).check(UP, "G1 X15 Y20\nG1 X15 Y60\nG1 Y60");
    }
    // From 45° behind it: 5 mm square to the block, then 5 · tan 22.5° to the intersection.
    onto([40.0, 0.0, 0.0], fanuc(A, None)).check(UP, "G1 X15 Y20\nG1 X15 Y60\nG1 Y60");
    onto([40.0, 0.0, 0.0], fanuc(B, None)).check(UP, "G1 X16.4645 Y16.4645\nG1 X15 Y17.9289\nG1 X15 Y60\nG1 Y60");
    // The corner bends by 135°: a radius beyond it on both sides.
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
    // Mirrored to the start: the intersection lies 5 · tan 22.5° beyond the end.
    bench(B).check(&along("G40 X100 Y20"), "G1 X20 Y45\nG1 X82.0711 Y45\nG1 X83.5355 Y43.5355\nG1 X100 Y20");
    // As if the contour went down, up, or straight on.
    bench(A).check(&along("G40 X100 Y20 I0 J-10"), "G1 X20 Y45\nG1 X85 Y45\nG1 X100 Y20");
    bench(A).check(&along("G40 X100 Y20 I0 J10"), "G1 X20 Y45\nG1 X75 Y45\nG1 X100 Y20");
    bench(B).check(&along("G40 X100 Y20 I10 J0"), "G1 X20 Y45\nG1 X80 Y45\nG1 X100 Y20");
}

#[test]
fn fanuc_goes_straight_onto_the_tangents_of_arcs() {
    let bench = |radius| Bench { start: [-20.0, 0.0, 0.0], radius_mm: radius, ..fanuc(A, None) };
    // A right angle: over its tip.
    bench(5.0).check(
        "G41 G1 X0 Y0\nY50\nG2 X10 Y40 I0 J-10\nG1 Y0\nG40 X30",
        "G1 X-5\nG1 X-5 Y55\nG1 Y55\nG2 X15 Y40 J-15\nG1 X15\nG1 X30",
    );
    // The arc begins in the direction (0.6, -0.8), 143° off; its center lies to its left, with the tool.
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
    // Behind an arc the straight way is the block's own, and what stands behind it comes at its end: the mirror image.
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
    let sinumerik = Bench { modal: ContourModal::default(), ..onto([20.0, 0.0, 0.0], fanuc(A, None)) };
    sinumerik.check_codes(text, &["W0233:3"]);
}

#[test]
fn sides_change_back_along_the_same_line_only() {
    // Up on the left and down on the right is the same way of the tool.
    fanuc(A, None).check("G41 G1 X20 Y20\nY60\nG42 Y20\nG40 X0", "G1 X15 Y20\nG1 X15 Y60\nG1 X15 Y20\nG1 Y20");
    fanuc(A, None).check_codes("G41 G1 X20 Y20\nY60\nG42 X60\nG40 Y90", &["E0232:3"]);
    grundig(None).check_codes("G41 G1 X20 Y20\nY60\nG42 Y20\nG40 X0", &["E0232:3"]);
}

#[test]
fn grundig_to_and_past_an_end() {
    // 5 mm along (0.6, 0.8) are (3, 4); the height follows where the tool is, and G40 leads to the programmed end.
    grundig(None).check(
        "G43 X0 Y60\nZ-3\nG44 X-30 Y20\nG40 X-30 Y0\nX0",
        "G1 X-3 Y56\nG1 X-3 Y56 Z-3\nG1 X-33 Y16 Z-3\nG1 X-30 Z-3\nG1 Z-3",
    );
    grundig(None).check("G44 X0\nG42\nY60\nG40 X30", "G1 X5 Y20\nG1 X5 Y60\nG1 X30 Y60");
    // The end that the program has already reached.
    grundig(None).check("G43 X0\nG40 X0\nX10", "G1 X-5 Y20\nG1 Y20\nG1 X10 Y20");
    // On the wrong side, and not square to the contour.
    grundig(None).check_codes("G43 X0\nG42\nY60\nG40 X30", &["E0232:3"]);
    grundig(None).check_codes("G43 X0 Y60\nG41\nY90\nG40 X-30", &["E0232:3"]);
    grundig(None).check_codes("G43 X0\nG2 X10 Y30 I0 J10", &["E0232:2"]);
}

#[test]
fn grundig_alone_begins_with_the_next_motion() {
    grundig(None).check("G41\nX0\nY60\nG40\nX-30", "G1 X-5 Y20\nG1 X-5 Y60\nG1 X-30 Y60");
}
