//! G43.4 of Fanuc: the tip in the workpiece, against chains of rotations written out here.

use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_language::exec::{NoLibrary, Options};
use ncfix_machine::machine::{LengthAxis, Machine};
use ncfix_machine::snc::{Element, Kind};

use crate::iso::elements;
use crate::swivel::{machine, turned};

/// Tool 1 of the machines is so long.
const LENGTH: f64 = 95.0;
/// Their G54, and where their rotary axes cross.
const G54: Vector = Vector::new(12.0, -7.0, 33.0);
const CROSSING: Vector = Vector::new(30.0, -20.0, 60.0);

fn strict() -> Options {
    Options { strict: true, ..Options::default() }
}

/// Head: C carries B, B the tool.
fn tip_of_head(command: &AxisVector) -> Vector {
    let hanging = Vector::new(0.0, 0.0, -LENGTH) - CROSSING;
    let (b, c) = (command[Axis::B].to_degrees(), command[Axis::C].to_degrees());
    CROSSING + turned(2, c) * turned(1, b) * hanging + command.xyz()
}

/// Table: A carries C, C the workpiece; both turn it against the sense of the tool's motion.
fn tip_on_table(command: &AxisVector) -> Vector {
    let tip = command.xyz() + Vector::new(0.0, 0.0, -LENGTH);
    let (a, c) = (command[Axis::A].to_degrees(), command[Axis::C].to_degrees());
    CROSSING + turned(2, c) * turned(0, a) * (tip - CROSSING)
}

/// The axis commands at the ends of the lines of a program.
#[track_caller]
fn ends(topology: &str, text: &str, lines: &[u32]) -> Vec<AxisVector> {
    ends_on(&machine(topology), text, lines)
}

#[track_caller]
fn ends_on(machine: &Machine, text: &str, lines: &[u32]) -> Vec<AxisVector> {
    let (elements, codes) = elements("fanuc", text, machine, Box::new(NoLibrary), strict());
    assert!(codes.is_empty(), "{codes:?}");
    let end = |line: &u32| {
        let step = |element: &Element| if let Kind::Move(step) = &element.kind { Some(step.target) } else { None };
        elements.iter().rev().filter(|element| element.origin.line == *line).find_map(step).unwrap()
    };
    lines.iter().map(end).collect()
}

#[test]
fn the_tip_is_where_the_program_says_while_head_or_table_turn() {
    type Tip = fn(&AxisVector) -> Vector;
    for (topology, first, tip) in
        [("wFXYZCBSt", Axis::B, tip_of_head as Tip), ("wCAYXFZSt", Axis::A, tip_on_table as Tip)]
    {
        let text = format!(
            "G17 G90 G21 G54\nG0 X0 Y0 Z300. {first}0 C0\nG43.4 H1 Z100.\nG1 X10. Y20. Z30. {first}30. C40. F500.\n\
             X-5. {first}-15. C110.\nG91 Y-4. C-20.\nG90 G52 X1.\nG0 X0 Y0 Z80. {first}0 C0\nG49\nG0 Z300.\nM30"
        );
        let found = ends(topology, &text, &[3, 4, 5, 6, 8]);
        let points = [[0.0, 0.0, 100.0], [10.0, 20.0, 30.0], [-5.0, 20.0, 30.0], [-5.0, 16.0, 30.0], [1.0, 0.0, 80.0]];
        let angles = [[0.0, 0.0], [30.0, 40.0], [-15.0, 110.0], [-15.0, 90.0], [0.0, 0.0]];
        for ((command, point), angles) in found.iter().zip(points).zip(angles) {
            let off = (tip(command) - Vector::from(point) - G54).norm();
            assert!(off < 1e-9, "{topology} {point:?}: {off}");
            let turned = [first, Axis::C].map(|axis| command[axis].to_degrees());
            assert!(turned.iter().zip(angles).all(|(a, b)| (a - b).abs() < 1e-9), "{turned:?}");
        }
    }
}

#[test]
fn the_length_lies_along_the_tool_whatever_g43_does() {
    let mut machine = machine("wFXYZCBSt");
    machine.control.iso.length_axis = LengthAxis::Plane;
    let text = "G90 G21 G54 G18\nG0 X0 Y0 Z300. B0 C0\nG43.4 H1 Z100.\nG1 X10. Y20. Z30. B30. C40. F500.\nM30";
    let (elements, codes) = elements("fanuc", text, &machine, Box::new(NoLibrary), strict());
    assert!(codes.is_empty(), "{codes:?}");
    let last = elements.iter().rev().find_map(|element| match &element.kind {
        Kind::Move(step) => Some(step.target),
        _ => None,
    });
    assert!((tip_of_head(&last.unwrap()) - Vector::new(10.0, 20.0, 30.0) - G54).norm() < 1e-9);
}

#[track_caller]
fn codes(topology: &str, text: &str, expected: &[&str]) {
    let (_, codes) = elements("fanuc", text, &machine(topology), Box::new(NoLibrary), strict());
    assert_eq!(codes, expected, "{text}");
}

#[test]
fn coordinates_begin_on_the_table_as_it_stands() {
    // Its system would be that of a table at 45 degrees: parameter 19696, bit 5, as delivered.
    let begin = "G17 G90 G21 G54\nG0 X0 Y0 Z300.";
    codes("wCAYXFZSt", &format!("{begin} A0 C45.\nG43.4 H1 Z100.\nM30"), &["E0201:3"]);
    codes("wCAYXFZSt", &format!("{begin} A0 C0\nG43.4 H1 X0 Y0 Z100. C45.\nM30"), &["E0201:3"]);
    codes("wCAYXFZSt", &format!("{begin} A0 C360.\nG43.4 H1 Z100.\nG1 C45. F500.\nM30"), &[]);
    codes("wCAYXFZSt", &format!("{begin}\nG43.4 H1 Z100.\nM30"), &["E0304:3"]);
    // A corrected program, which is looked at but not corrected again, may be off by its correction.
    let text = format!("{begin} A0.002 C359.99\nG43.4 H1 Z100.\nM30");
    codes("wCAYXFZSt", &text, &["E0201:3"]);
    let found = elements("fanuc", &text, &machine("wCAYXFZSt"), Box::new(NoLibrary), Options::default()).1;
    assert_eq!(found, [""; 0]);
    // A head turns no workpiece.
    codes("wFXYZCBSt", &format!("{begin} B30. C45.\nG43.4 H1 X0 Y0 Z100.\nM30"), &[]);
}

/// Mill Operator's Manual of Haas, G234: the example turns B and C before it. The coordinates are those of the table at zero.
#[test]
fn coordinates_of_the_table_at_zero_count_wherever_it_is() {
    let mut machine = machine("wCAYXFZSt");
    machine.control.iso.tip_of_table_at_zero = true;
    let begin = "G17 G90 G21 G54\nG0 X0 Y0 Z300. A30. C40.\n";
    let text = format!("{begin}G43.4 H1 X10. Y20. Z30.\nG1 X11. Z25. A35. F500.\nG91 X2. C10.\nM30");
    let found = ends_on(&machine, &text, &[3, 4, 5]);
    let wanted =
        [([10.0, 20.0, 30.0], [30.0, 40.0]), ([11.0, 20.0, 25.0], [35.0, 40.0]), ([13.0, 20.0, 25.0], [35.0, 50.0])];
    for (command, (point, angles)) in found.iter().zip(wanted) {
        let off = (tip_on_table(command) - Vector::from(point) - G54).norm();
        assert!(off < 1e-9, "{point:?}: {off}");
        let turned = [Axis::A, Axis::C].map(|axis| command[axis].to_degrees());
        assert!(turned.iter().zip(angles).all(|(a, b)| (a - b).abs() < 1e-9), "{turned:?}");
    }
    // Whether X and Y keep their values or their places at G43.4 is not certain: they are unknown until the program states them.
    let codes = |text: &str| elements("fanuc", text, &machine, Box::new(NoLibrary), strict()).1;
    assert_eq!(codes(&format!("{begin}G43.4 H1 Z100.\nG91 G1 X1. F500.\nM30")), ["E0304:4"]);
    assert_eq!(codes(&format!("{begin}G43.4 H1 Z100.\nG1 X1. Y2. Z50. F500.\nG91 X1.\nM30")), [""; 0]);
    // With the table at zero, the places are the values.
    let zero = "G17 G90 G21 G54\nG0 X0 Y0 Z300. A0 C0\n";
    assert_eq!(codes(&format!("{zero}G43.4 H1 Z100.\nG91 G1 X1. F500.\nM30")), [""; 0]);
}

#[test]
fn a_length_along_a_tilted_tool_concerns_all_its_axes() {
    let begin = "G17 G90 G21 G54\nG0 X0 Y0 Z300. B30. C0\n";
    // X has another place as soon as the length counts, Y across the tool has not.
    codes("wFXYZCBSt", &format!("{begin}G43.4 H1 Z100.\nG91 G1 X1. F500.\nM30"), &["E0304:4"]);
    codes("wFXYZCBSt", &format!("{begin}G43.4 H1 X0 Z100.\nG91 G1 X1. Y1. F500.\nM30"), &[]);
    codes("wFXYZCBSt", &format!("{begin}G43.4 H1 X0 Y0 Z100.\nG49\nG91 G1 X1. F500.\nM30"), &["E0304:5"]);
}

#[test]
fn places_of_the_machine_are_none_of_the_tip() {
    let begin = "G17 G90 G21 G54\nG0 X0 Y0 Z300. B0 C0\nG43.4 H1 Z100.\n";
    for code in ["G28 Z0", "G91 G28 Z0", "G30 Z0", "G27 Z0", "G29 Z0", "G53 G0 Z0"] {
        codes("wFXYZCBSt", &format!("{begin}{code}\nM30"), &["E0227:4"]);
    }
    codes("wFXYZCBSt", &format!("{begin}G49\nG91 G28 Z0\nM30"), &[]);
}

/// The direction of the tool that a program asks for, on the head and on the table.
fn direction_of_head(command: &AxisVector) -> Vector {
    turned(2, command[Axis::C].to_degrees()) * turned(1, command[Axis::B].to_degrees()) * Vector::z()
}

fn direction_on_table(command: &AxisVector) -> Vector {
    turned(2, command[Axis::C].to_degrees()) * turned(0, command[Axis::A].to_degrees()) * Vector::z()
}

#[test]
fn directions_of_the_tool_turn_the_axes() {
    type Of<T> = fn(&AxisVector) -> T;
    for (topology, first, tip, direction) in [
        ("wFXYZCBSt", 'B', tip_of_head as Of<Vector>, direction_of_head as Of<Vector>),
        ("wCAYXFZSt", 'A', tip_on_table, direction_on_table),
    ] {
        let text = format!(
            "G17 G90 G21 G54\nG0 X0 Y0 Z300. {first}0 C0\nG43.5 H1 Z100.\nG1 X10. Y20. Z30. I0.3 J0.2 K0.9 F500.\n\
             X-5. J-2. K4.\nX-8.\nI.1 J.1 K1.\nG2 X-4. Y24. R4. I-1. J.5 K3.\nG91 G1 Z5. K1.\nM30"
        );
        let found = ends(topology, &text, &[4, 5, 6, 7, 8, 9]);
        let expected = [
            ([10.0, 20.0, 30.0], [0.3, 0.2, 0.9]),
            ([-5.0, 20.0, 30.0], [0.0, -2.0, 4.0]),
            ([-8.0, 20.0, 30.0], [0.0, -2.0, 4.0]),
            ([-8.0, 20.0, 30.0], [0.1, 0.1, 1.0]),
            ([-4.0, 24.0, 30.0], [-1.0, 0.5, 3.0]),
            ([-4.0, 24.0, 35.0], [0.0, 0.0, 1.0]),
        ];
        for (command, (point, wanted)) in found.iter().zip(expected) {
            let off = (tip(command) - Vector::from(point) - G54).norm();
            assert!(off < 1e-9, "{topology} {point:?}: {off}");
            let off = (direction(command) - Vector::from(wanted).normalize()).norm();
            assert!(off < 1e-9, "{topology} {wanted:?}: {off}");
        }
    }
}

#[test]
fn the_tip_stays_on_its_line_while_the_direction_changes() {
    let text = "G17 G90 G21 G54\nG0 X0 Y0 Z300. B0 C0\nG43.5 H1 Z100.\nG1 X50. I1. J1. K2. F500.\nM30";
    let (elements, codes) = elements("fanuc", text, &machine("wFXYZCBSt"), Box::new(NoLibrary), strict());
    assert!(codes.is_empty(), "{codes:?}");
    let on_line = crate::five_axis::chords(&elements, &machine("wFXYZCBSt"), 4);
    let points: Vec<Vector> = on_line.iter().map(|command| tip_of_head(command) - G54).collect();
    assert!(points.len() > 10, "{}", points.len());
    assert!(points.iter().all(|tip| tip.y.abs() < 1e-9 && (tip.z - 100.0).abs() < 1e-9), "{points:?}");
}

/// Positions of B and C in degrees that the control takes for a direction, from where they stand. The first two are examples of the
/// manual of the control (series 30i, tool center point control of type 2: master axis C, slave axis B).
#[test]
fn of_two_ways_the_control_takes_the_one_with_less_motion_of_its_first_axis() {
    let (sine, cosine) = 60.0_f64.to_radians().sin_cos();
    // To B 30 with C 350, or to B -30 with C 170.
    let (near_x, near_y) = (0.5 * 10.0_f64.to_radians().cos(), 0.5 * 10.0_f64.to_radians().sin());
    for (start, direction, wanted) in [
        ([180.0, 90.0], [-1.0, 0.0, 0.0], [270.0, 0.0]),
        ([45.0, 90.0], [0.0, 0.0, 1.0], [0.0, 90.0]),
        // C 180 with B 60 would turn both together less, and C more.
        ([10.0, 85.0], [-sine, 0.0, cosine], [-60.0, 0.0]),
        // Both turn both axes alike; the one that ends nearer to zero, or to whole turns.
        ([0.0, 260.0], [near_x, -near_y, 0.75_f64.sqrt()], [30.0, 350.0]),
        ([0.0, 80.0], [-near_x, near_y, 0.75_f64.sqrt()], [-30.0, -10.0]),
    ] {
        let ([b, c], [i, j, k]) = (start, direction);
        let text = format!(
            "G17 G90 G21 G54\nG0 X0 Y0 Z300. B{b:.3} C{c:.3}\nG43.5 H1 X0 Y0 Z100.\nG1 I{i:.12} J{j:.12} K{k:.12} F500.\nM30"
        );
        let found = ends("wFXYZCBSt", &text, &[4]);
        let angles = [Axis::B, Axis::C].map(|axis| found[0][axis].to_degrees());
        assert!(angles.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-6), "{start:?}: {angles:?}");
    }
}

#[test]
fn directions_that_the_control_refuses() {
    let head = "G17 G90 G21 G54\nG0 X0 Y0 Z300. B0 C0\n";
    let table = "G17 G90 G21 G54\nG0 X0 Y0 Z300. A0 C0\n";
    // In the block of G43.5 only heads may turn.
    codes("wFXYZCBSt", &format!("{head}G43.5 H1 X0 Y0 Z100. I1. K3.\nM30"), &[]);
    codes("wCAYXFZSt", &format!("{table}G43.5 H1 X0 Y0 Z100. I1. K3.\nM30"), &["E0210:3"]);
    codes("wFXYZCBSt", &format!("{head}G43.5 H1 Z100.\nG1 X1. B5. F500.\nM30"), &["E0210:4"]);
    codes("wFXYZCBSt", &format!("{head}G43.5 H1 Z100.\nG1 X1. I0 F500.\nM30"), &["E0210:4"]);
    codes("wFXYZCBSt", &format!("{head}G43.5 H1 Z100. Q2.\nM30"), &["E0201:3"]);
    codes("wFXYZCBSt", &format!("{head}G43.5 H1 Z100.\nG2 X10. I5. F500.\nM30"), &["E0202:4"]);
    // Which way the axes go depends on where they stand.
    codes("wFXYZCBSt", "G17 G90 G21 G54\nG0 X0 Y0 Z300.\nG43.5 H1 X0 Y0 Z100. I1. K3.\nM30", &["E0304:3"]);
    // A is the only axis that turns: no way to a direction beside its plane.
    codes("wAYXFZSt", &format!("{}G43.5 H1 Z100.\nG1 I1. K1. F500.\nM30", table.replace(" C0", "")), &["E0240:4"]);
}
