//! What Spaan demands of the generator of the flat stream (Software error compensation of machine tools, ch. 7), one test each.

use ncfix_language::exec::{NoLibrary, Options};

use crate::grundig::{check, check_from, mill, motions, run_on, same, tool};
use crate::support::{Shop, machine};
use ncfix_base::geometry::{Axis, Vector};
use ncfix_machine::machine::Machine;

/// A program with everything that must not be in the flat stream.
const RICH: &str = "%PM9200
N9200 (EVERYTHING)
N1 G17 G90 G71 G54
N2 T2 M6
N3 G0 X-60 Y-40 Z30 S1200 M3
N4 G0 Z2
N5 G1 Z-2 F200
N6 E1=12.5 E2=2
N7 G43 X-40 F300
N8 G41
N9 G1 Y=E1*2
N10 G2 X-15 Y50 R25
N11 G1 X30
N12 G1 Y-40
N13 G40
N14 G1 X-60
N15 G22 N=9201
N16 G73 X-1 A4=0.8
N17 G22 N=9201
N18 G72
N19 G93 X10 Y5 B4=30
N20 G22 N=9201
N21 G93 X0 Y0 B4=0
N22 G0 Z20
N23 G78 P1 X60 Y10 Z0
N24 G9 X60 Y10
N25 G81 Y2 Z-5 B4 F100
N26 G79 P1
N27 G77 X60 Y10 Z0 R15 I0 J4
N28 G89 Z-4 B2 R16 I70 K2 F200
N29 G79 P1
N30 G87 X50 Y40 Z-4 B2 R12 I70 K2 F200
N31 G79 X-60 Y60 Z0
N32 G0 Z50
N33 E3=E2>5
N34 G29 E3 N=3
N35 M30
%MM9201
N9201
N1 G0 X20 Y0
N2 G1 B1=45 L1=10 F250
N3 G3 B1=90 L1=8 R10
N4 G91
N5 G1 X3
N6 Y2
N7 G14 N1=5 N2=6 J=E2
N8 G90
";

/// The lines of a corrected program, without comments.
fn corrected() -> Vec<String> {
    let shop = Shop::new().file("9200.pm", RICH);
    shop.run(["9200.pm", "-o", "out.pm", "--machine", &machine("universal_mill")]).exits(0);
    let text = std::fs::read_to_string(shop.path("out.pm")).unwrap();
    text.lines().map(|line| line.split('(').next().unwrap().trim().to_owned()).filter(|line| !line.is_empty()).collect()
}

/// A machine with three rotary axes.
fn six_axes() -> Machine {
    let mut machine = mill();
    machine.topology = "wCBAFXYZSt".parse().unwrap();
    for axis in [Axis::A, Axis::B, Axis::C] {
        let mut data = machine.axes[axis.dimension()].clone().unwrap();
        data.axis = axis;
        data.direction = Vector::zeros();
        data.direction[axis.dimension()] = 1.0;
        machine.axes[axis.slot()] = Some(data);
    }
    machine
}

fn codes(lines: &[String]) -> Vec<&str> {
    lines.iter().flat_map(|line| line.split_whitespace()).filter(|word| word.starts_with('G')).collect()
}

fn flat(text: &str) -> Vec<String> {
    let mut machine = mill();
    machine.tools.push(tool(2, 0.0, 10.0));
    let (lines, codes) = run_on(text, &machine, Box::new(NoLibrary), Options::default());
    assert!(codes.iter().all(|code| code.starts_with('W')), "{codes:?}");
    motions(&lines, [0.0; 3])
}

#[test]
fn the_flat_stream_is_geometrically_the_same_program() {
    // What an error-free machine gets is executed to the same moves as the program.
    let perfect: String = std::fs::read_to_string(machine("universal_mill"))
        .unwrap()
        .lines()
        .take_while(|line| !line.contains("position-independent errors"))
        .chain(["[zero_offset.G54]", "X_mm = -60", "[[tool]]", "number = 2", "length_mm = 112.5", "radius_mm = 10.0"])
        .map(|line| format!("{line}\n"))
        .collect();
    let shop = Shop::new().file("9200.pm", RICH).file("perfect.toml", perfect);
    shop.run(["9200.pm", "-o", "out.pm", "--machine", "perfect.toml"]).exits(0);
    let moves = |name: &str| {
        let run = shop.run(["snc", name, "--dialect", "grundig", "--machine", "perfect.toml"]).exits(0);
        let lines: Vec<String> = run.stdout.lines().map(|line| line.split(" ;").next().unwrap().to_owned()).collect();
        motions(&lines, [f64::NAN; 3])
    };
    let (before, after) = (moves("9200.pm"), moves("out.pm"));
    assert!(before.len() > 100);
    assert_eq!(before.len(), after.len());
    for (one, other) in before.iter().zip(&after) {
        let ((code, a), (other_code, b)) = (crate::grundig::words(one), crate::grundig::words(other));
        assert_eq!(code, other_code);
        for (letter, value) in a {
            // Half an increment of 0.001 mm, at centers of both coordinates.
            assert!((value - b[&letter]).abs() <= 0.0011, "{one} became {other}");
        }
    }
}

#[test]
fn all_coordinates_are_cartesian_and_neither_polar_nor_mixed() {
    check(
        "N1 G17 G90\nN2 G0 B2=30 L2=20\nN3 G1 B1=120 L1=4 F100\nN4 X40 B1=45\nN5 G9 X40 Y30\nN6 G3 B2=90 L2=10 R60",
        // 20 (cos 30°, sin 30°), then 4 (−½, ½√3), then 45° up to X40.
        "G0 X17.320508 Y10 Z0
G1 X15.320508 Y13.464102 Z0
G1 X40 Y38.143594 Z0
G3 X40 Y40 Z0",
    );
}

#[test]
fn all_coordinates_are_relative_to_the_machine_origin() {
    // G54 lies at X100 Y50, the shift turns by a right angle.
    check("N1 G17 G90 G54\nN2 G93 X10 Y20 B4=90\nN3 G0 X5 Y1", "G0 X109 Y75 Z0");
}

#[test]
fn all_coordinates_relate_to_the_tool_center_point() {
    let mut machine = mill();
    machine.tools.push(tool(3, 120.0, 5.0));
    let text = "N1 G17 G90 T3 M67\nN2 G0 Z10\nN3 G1 X5 F100";
    check_from(text, [0.0, 0.0, 200.0], &machine, "G0 X0 Y0 Z10\nG1 X5 Y0 Z10");
}

#[test]
fn all_axes_are_supported() {
    let (lines, codes) = run_on(
        "N1 G17 G90\nN2 G28 I5=1\nN3 G0 X1 Y2 Z3 A10 C-20\nN4 G91 G1 A5 C2.5 F100",
        &six_axes(),
        Box::new(NoLibrary),
        Options::default(),
    );
    assert!(codes.is_empty(), "{codes:?}");
    same(&motions(&lines, [0.0; 3])[..1], "G0 X1 Y2 Z3 A10 B0 C-20");
    assert!(lines[1].starts_with("G1 X1 Y2 Z3 A15 B0 C-17.5"), "{lines:?}");
}

#[test]
fn compound_movements_become_elementary_ones() {
    check("N1 G17 G90\nN2 G0 X10 Y5 Z20\nN3 X0 Y0 Z0", "G0 X0 Y0 Z20\nG0 X10 Y5 Z20\nG0 X0 Y0 Z20\nG0 X0 Y0 Z0");
    let lines = flat(RICH);
    assert!(lines.len() > 100);
    assert!(lines.iter().all(|line| ["G0 ", "G1 ", "G2 ", "G3 "].iter().any(|code| line.starts_with(code))));
}

#[test]
fn no_subprogram_calls_are_left() {
    let lines = corrected();
    assert!(codes(&lines).iter().all(|code| !["G22", "G23"].contains(code)));
    assert!(!lines.iter().any(|line| line.contains("%MM")));
}

#[test]
fn no_branches_or_repetitions_are_left() {
    assert!(codes(&corrected()).iter().all(|code| !["G14", "G29"].contains(code)));
}

#[test]
fn no_radius_correction_is_left() {
    assert!(codes(&corrected()).iter().all(|code| !["G41", "G42", "G43", "G44"].contains(code)));
}

#[test]
fn no_points_and_parameters_are_left() {
    let lines = corrected();
    assert!(codes(&lines).iter().all(|code| !["G78", "G9"].contains(code)));
    let is_left = |word: &str| (word.starts_with('E') && word != "E") || word.contains("=E") || word.starts_with('P');
    assert!(!lines.iter().flat_map(|line| line.split_whitespace()).any(is_left));
}

#[test]
fn no_mirroring_and_scaling_is_left() {
    let lines = corrected();
    assert!(codes(&lines).iter().all(|code| !["G72", "G73", "G92", "G93"].contains(code)));
}

#[test]
fn circle_milling_becomes_elementary_movements() {
    // Radius 16, tool 10: the middle of the tool goes around on 6.
    let mut machine = mill();
    machine.tools.push(tool(2, 0.0, 10.0));
    check_from(
        "N1 G17 G90 T2 M67\nN2 G89 Z-4 B2 R16 I100 K4 F200\nN3 G79 X60 Y10 Z0",
        [60.0, 10.0, 2.0],
        &machine,
        "G1 X60 Y10 Z-4
G1 X66 Y10 Z-4
G3/17 X66 Y10 Z-4 I-6 J0
G1 X60 Y10 Z-4
G0 X60 Y10 Z2",
    );
}

#[test]
fn the_edge_of_a_chamber_is_milled_with_elementary_movements() {
    // 60 x 44 with corners of 12 and a tool of 10: the way along the edge is 40 x 24 with corners of 2.
    let mut machine = mill();
    machine.tools.push(tool(2, 0.0, 10.0));
    let text = "N1 G17 G90 T2 M67\nN2 G87 X60 Y44 Z-4 B2 R12 I60 K4 F200\nN3 G79 X0 Y0 Z0";
    let (lines, _) = run_on(text, &machine, Box::new(NoLibrary), Options::default());
    let edge: Vec<String> = motions(&lines, [0.0; 3]);
    let first = edge.iter().position(|line| line.starts_with("G3")).unwrap();
    same(
        &edge[first - 1..first + 8],
        "G1 X20 Y10 Z-4
G3/17 X18 Y12 Z-4 I-2 J0
G1 X-18 Y12 Z-4
G3/17 X-20 Y10 Z-4 I0 J-2
G1 X-20 Y-10 Z-4
G3/17 X-18 Y-12 Z-4 I2 J0
G1 X18 Y-12 Z-4
G3/17 X20 Y-10 Z-4 I0 J2
G1 X20 Y0 Z-4",
    );
}
