//! Offsets, lengths, feeds and codes of Fanuc and RS274/NGC that are passed on: numbers by hand, those of RS274/NGC by LinuxCNC's interpreter.

use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_language::exec::{NoLibrary, Options};
use ncfix_machine::machine::{LengthAxis, Machine, Tool};
use ncfix_machine::snc::Kind;

use crate::iso::{check, check_codes, check_on, elements, iso_machine, run, run_with};
use crate::support::Shop;

fn strict() -> Options {
    Options { strict: true, ..Options::default() }
}

/// Offset 1 has length 80 and radius 3, offset 2 length 20, offset 3 length 50.
fn with_tools() -> Machine {
    let mut machine = iso_machine();
    let tool = |number, length| Tool { number, name: None, edge: 1, length_mm: [length, 0.0, 0.0], radius_mm: 3.0 };
    machine.tools = vec![tool(1, 80.0), tool(2, 20.0), tool(3, 50.0)];
    machine
}

/// Axis commands of all motions.
#[track_caller]
fn commands(name: &str, text: &str, machine: &Machine) -> Vec<[f64; 3]> {
    let (elements, codes) = elements(name, text, machine, Box::new(NoLibrary), Options::default());
    assert!(codes.is_empty(), "{codes:?}");
    let found = elements.iter().filter_map(|element| match &element.kind {
        Kind::Move(step) => Some([step.target.0[0], step.target.0[1], step.target.0[2]]),
        _ => None,
    });
    found.collect()
}

#[track_caller]
fn assert_near(found: &[[f64; 3]], expected: &[[f64; 3]]) {
    let near = |(a, b): (&[f64; 3], &[f64; 3])| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9);
    assert!(found.len() == expected.len() && found.iter().zip(expected).all(near), "{found:?}\n{expected:?}");
}

/// What is written for a machine without errors whose control takes whole thousandths, behind the header.
#[track_caller]
pub(crate) fn written(name: &str, more: &str, text: &str) -> Vec<String> {
    let travel = "travel_mm = [-2000, 2000]\nmax_feed_mm_min = 10000";
    let machine = format!(
        "[machine]\nname = \"test\"\ntopology = \"wFXYZSt\"\ncontroller = \"{name}\"\n[axis.X]\ndirection = [1, 0, 0]\n{travel}\n\
         [axis.Y]\ndirection = [0, 1, 0]\n{travel}\n[axis.Z]\ndirection = [0, 0, 1]\n{travel}\n[zero_offset.G54]\nX_mm = 0\n{more}\n\
         [control]\nincrement_mm = 0.001\nreference_point_1_Z_mm = 450\nreference_point_2_Z_mm = 250\nreference_point_2_X_mm = -30\n\
         reference_point_4_Y_mm = 7\n"
    );
    let shop = Shop::new().file("part.nc", text).file("m.toml", machine);
    shop.run(["part.nc", "--machine", "m.toml", "-o", "out.nc"]).exits(0);
    let text = shop.text("out.nc");
    text.lines().filter(|line| !line.starts_with(['%', '(', 'O', ';'])).map(str::to_owned).collect()
}

#[test]
fn ext_shifts_all_systems_of_a_fanuc() {
    let mut machine = iso_machine();
    let mut ext = AxisVector::ZERO;
    ext.set_xyz(Vector::new(1.0, 0.0, 0.0));
    machine.zero_offsets.insert("EXT".to_owned(), ext.into());
    let text = "G90 G10 L2 P2 X100. Y0 Z0\nG54 G0 X0 Y0 Z0\nG55 X0\nG10 L2 P0 X3. Y-2. Z1.\nX0 Y0 Z0\nG91 G10 L2 P0 X0.5\nG90 X0\n\
                G54 X0\nM30";
    check_on(
        "fanuc",
        text,
        &machine,
        &["G0 X1 Y0 Z0", "G0 X101 Y0 Z0", "G0 X103 Y-2 Z1", "G0 X103.5 Y-2 Z1", "G0 X3.5 Y-2 Z1"],
    );
    // Where nothing states it, it is zero; a program may set one axis of it, and a correction knows it then.
    let (lines, codes) =
        run_with("fanuc", "G90 G10 L2 P0 Z5.\nG54 G0 X0 Y0 Z0\nM30", &iso_machine(), Box::new(NoLibrary), strict());
    assert!(codes.is_empty(), "{codes:?}");
    assert!(lines.contains(&"G0 X0 Y0 Z5".to_owned()), "{lines:?}");
    // Positions stay those of the program: the control has EXT too.
    let lines =
        written("fanuc", "[zero_offset.EXT]\nZ_mm = 25", "G21 G90 G54\nG0 X1. Y2. Z3.\nG53 G0 Z100.\nG0 Z4.\nM30\n");
    let moves: Vec<&String> = lines.iter().filter(|line| line.contains('Z')).collect();
    assert_eq!(moves, ["G0 X1. Y2. Z3.", "G53 G0 Z100.", "G0 Z4."]);
}

#[test]
fn additional_systems() {
    let mut machine = iso_machine();
    let mut second = AxisVector::ZERO;
    second.set_xyz(Vector::new(-5.0, 0.0, 0.0));
    machine.zero_offsets.insert("G54.1 P2".to_owned(), second.into());
    let text = "G90 G10 L20 P7 X10. Y20. Z30.\nG54.1 P7 G0 X1. Y2. Z3.\nG54.1 P2 X0 Y0 Z0\nG54 P7 X0\nG91 G10 L20 P7 X4.\nG90 X0\n\
                G54 X0 Y0 Z0\nG54.1 P300\nM30";
    let (lines, codes) = run_with("fanuc", text, &machine, Box::new(NoLibrary), Options::default());
    assert_eq!(codes, ["W0302:8"], "P300 has no value");
    let moves: Vec<&str> = crate::iso::moves(&lines).into_iter().filter(|line| line.starts_with("G0 ")).collect();
    assert_eq!(
        moves,
        ["G0 X11 Y22 Z33", "G0 X-5 Y0 Z0", "G0 X10 Y0 Z0", "G0 X14 Y0 Z0", "G0 X0 Y0 Z0"],
        "another system moves no axis that is not programmed"
    );
    check_codes("fanuc", "G54.1\nG54.1 P0\nG54.1 P301\nM30", &["E0210:1", "E0210:2", "E0210:3"]);
}

#[test]
fn lengths_along_z_across_the_plane_and_along_an_axis() {
    let mut machine = with_tools();
    let text = "G90 G18 G0 X0 Y0 Z0\nG43 H1 X0 Y0 Z0\nG44 H2 X0 Y0 Z0\nG49 X0 Y0 Z0\nM30";
    assert_near(&commands("fanuc", text, &machine), &[[0.0; 3], [0.0, 0.0, 80.0], [0.0, 0.0, -20.0], [0.0; 3]]);
    machine.control.iso.length_axis = LengthAxis::Plane;
    let text = "G90 G17 G0 X0 Y0 Z0\nG43 H1 Z0\nG49 X0 Y0 Z0\nG18 G43 H1 Y0\nG49 X0 Y0 Z0\nG19 G44 H1 X0\nM30";
    assert_near(
        &commands("fanuc", text, &machine),
        &[[0.0; 3], [0.0, 0.0, 80.0], [0.0; 3], [0.0, 80.0, 0.0], [0.0; 3], [-80.0, 0.0, 0.0]],
    );
    // Along two axes by two blocks: H0 ends the one across the plane, G49 both.
    let text = "G90 G17 G0 X0 Y0 Z0\nG19 G43 H1 X0\nG18 G43 H2 Y0\nX0 Y0 Z1.\nH0 Y0\nX0 Y0 Z2.\nG49 X0 Y0 Z0\nM30";
    assert_near(
        &commands("fanuc", text, &machine),
        &[
            [0.0; 3],
            [80.0, 0.0, 0.0],
            [80.0, 20.0, 0.0],
            [80.0, 20.0, 1.0],
            [80.0, 0.0, 1.0],
            [80.0, 0.0, 2.0],
            [0.0; 3],
        ],
    );
    machine.control.iso.length_axis = LengthAxis::Programmed;
    let text = "G90 G17 G0 X0 Y0 Z0\nG43 H1 Y5.\nH2 Y5.\nH3\nY5.\nG49 Y0\nG43 H3\nZ0\nM30";
    assert_near(
        &commands("fanuc", text, &machine),
        &[[0.0; 3], [0.0, 85.0, 0.0], [0.0, 25.0, 0.0], [0.0, 55.0, 0.0], [0.0; 3], [0.0, 0.0, 50.0]],
    );
    let unclear = |text: &str| run_with("fanuc", text, &machine, Box::new(NoLibrary), Options::default()).1;
    assert_eq!(unclear("G90 G0 X0 Y0 Z0\nG43 H1 X0 Y0\nM30"), ["E0210:2"]);
    assert_eq!(unclear("G90 G0 X0 Y0 Z0\nG43 H1 X0\nG43 H2 Y0\nH3\nM30"), ["E0210:4"]);
}

#[test]
fn tool_data_of_a_fanuc_program() {
    // Lengths: geometry (L10) and wear (L11, of old programs L1).
    let text = "G90 G0 X0 Y0 Z0\nG10 L10 P6 R20.\nG10 L1 P6 R1.\nG43 H6 Z0\nG10 L11 P6 R2.\nH6 Z0\nG91 G10 L10 P6 R5.\nG90 H6 Z0\n\
                G20 G10 L10 P6 R1.\nG21 H6 Z0\nM30";
    let height = |z: f64| [0.0, 0.0, z];
    assert_near(
        &commands("fanuc", text, &iso_machine()),
        &[height(0.0), height(21.0), height(22.0), height(27.0), height(27.4)],
    );
    // Radii: L12 and L13. Compensation ends above the end of the block that begins it.
    let text = "G90 G0 X0 Y0 Z0\nG10 L12 P8 R5.\nG10 L13 P8 R-0.5\nG41 D8 G1 X10. F100.\nX30.\nG40 X50.\nM30";
    check("fanuc", text, &["G0 X0 Y0 Z0", "G1 X10 Y4.5 Z0 F100", "G1 X30 Y4.5 Z0 F100", "G1 X50 Y0 Z0 F100"]);
    // The control has them for good. A step is added to its own value, which may differ from that of the machine file.
    let lines = written(
        "fanuc",
        "[[tool]]\nnumber = 6\nlength_mm = 20\nradius_mm = 4",
        "G21 G90 G54\nG91 G10 L10 P6 R5.\nG90 G10 L13 P6 R0.02\nG10 L2 P0 Z1.5\nG0 X0 Y0 Z0\nM30\n",
    );
    let data: Vec<&String> = lines.iter().filter(|line| line.contains("G10")).collect();
    assert_eq!(data, ["G91 G10 L10 P6 R5.", "G90 G10 L13 P6 R0.02", "G10 L2 P0 Z1.5"]);
    check_codes("fanuc", "G10 L10 P6\nG10 L14 P6 R1.\nM30", &["E0210:1", "E0201:2"]);
}

#[test]
fn tool_data_of_a_linuxcnc_program() {
    // Where LinuxCNC 2.9 goes.
    let text = "G21 G90 G17 G94 F100\nG10 L2 P1 X10 Y20 Z30\nG10 L2 P9 X100 Y200 Z300\nG0 X1 Y2 Z3\nG10 L1 P1 Z40\nG43 H1\nG0 Z0\n\
                G10 L10 P1 Z5\nG43 H1\nG0 Z0\nG49\nG0 Z3\nG10 L11 P3 Z7\nG43 H3\nG0 Z0\nM2";
    let at = |z: f64| [11.0, 22.0, z];
    assert_near(&commands("rs274", text, &with_tools()), &[at(33.0), at(70.0), at(65.0), at(33.0), at(-244.0)]);
    check_codes("rs274", "G10 L12 P1 R1\nG10 L1 P1\nM2", &["E0201:1", "E0210:2"]);
}

#[test]
fn lengths_by_words_of_rs274() {
    let text = "G21 G90\nG0 X0 Y0 Z0\nG43.1 Z50\nG0 X1 Z10\nG43.1 Y-3\nG0 X1 Y0 Z10\nG43.2 H2\nG0 X1 Z10\nG49\nG0 X1 Y0 Z10\nM2";
    assert_near(
        &commands("rs274", text, &with_tools()),
        &[[0.0; 3], [1.0, 0.0, 60.0], [1.0, -3.0, 60.0], [1.0, -3.0, 80.0], [1.0, 0.0, 10.0]],
    );
    let text = "G20 G90\nG0 X0 Y0 Z0\nG43.1 Z2\nG0 X1 Z1\nM2";
    assert_near(&commands("rs274", text, &iso_machine()), &[[0.0; 3], [25.4, 0.0, 76.2]]);
    // The control keeps adding it: positions stay, and the value is written in the unit of the program.
    let lines = written("rs274", "", "G20 G90 G54 G17 F10\nG0 X0 Y0 Z0\nG43.1 Z2\nG1 X1 Z1\nM2\n");
    assert!(lines.iter().any(|line| line.contains("G43.1 Z2")), "{lines:?}");
    assert!(lines.iter().any(|line| line.contains("X1 Z1")), "{lines:?}");
}

#[test]
fn a_tool_is_taken_over_by_its_number() {
    let text = "G21 G90\nG0 X0 Y0 Z0\nM61 Q3\nG43\nG0 Z0\nM2";
    assert_near(&commands("rs274", text, &with_tools()), &[[0.0; 3], [0.0, 0.0, 50.0]]);
    let lines = written("rs274", "", "G21 G90 G54\nM61 Q3\nG0 X0 Y0 Z0\nM2\n");
    assert!(lines.iter().any(|line| line == "M61 Q3"), "{lines:?}");
    check_codes("rs274", "M61\nM61 Q-1\nT1 M6 M61 Q1\nM2", &["E0210:1", "E0210:2", "E0111:3"]);
}

#[test]
fn inputs_outputs_and_codes_of_the_builder_are_passed_on_in_their_places() {
    let codes = [
        "M62 P1",
        "M63 P1",
        "M64 P2",
        "M65 P2",
        "M66 P0 L3 Q2.5",
        "M66 E1 L0",
        "M67 E1 Q0.25",
        "M68 E2 Q-3",
        "M101 P1 Q2.5",
    ];
    let mut text = "G21 G90 G54 G17 F100\nG0 X0 Y0 Z0\n".to_owned();
    let mut expected = Vec::new();
    for (number, code) in codes.iter().enumerate() {
        text += &format!("{code}\nG1 X{}\n", number + 1);
        expected.extend([(*code).to_owned(), format!("X{}", number + 1)]);
    }
    let mut lines = written("rs274", "", &(text + "M2\n"));
    lines.iter_mut().for_each(|line| *line = line.replace("G1 ", "").replace(" F100", ""));
    let from = lines.iter().position(|line| line == codes[0]).unwrap_or_else(|| panic!("{lines:?}"));
    assert_eq!(lines[from..from + expected.len()], expected);
    assert_eq!(run("rs274", "M101\nM199 P1\nM2").1, ["W0204:1", "W0204:2"]);
}

#[test]
fn inputs_and_outputs_need_their_number_and_no_radius_compensation() {
    for code in ["M62", "M63", "M64", "M65", "M66", "M66 P1 E1", "M67 Q1", "M68 Q1"] {
        check_codes("rs274", &format!("G21 G0 X0 Y0 Z0\n{code}\nM2"), &["E0210:2"]);
    }
    for code in ["M62 P1", "M64 P1", "M66 P0 L0", "M67 E1 Q3", "M68 E1 Q3", "M51 P1", "M49"] {
        let text = format!("G21 G90 G17 F100\nT1 M6\nG0 X0 Y0 Z10\nG41 D1 G1 X10 Y0\nX20\n{code}\nX30\nG40 X40\nM2");
        let (_, codes) = run_with("rs274", &text, &with_tools(), Box::new(NoLibrary), Options::default());
        assert_eq!(codes.len(), 1, "{code}: {codes:?}");
        assert!(codes[0].ends_with(":6"), "{code}: {codes:?}");
    }
}

#[test]
fn rotations_about_lines_in_space() {
    // A third of a turn about (1, 1, 1) takes X to Y, Y to Z, Z to X: (9, 18, 27) about the center becomes (27, 9, 18).
    check(
        "fanuc",
        "G90 G0 X0 Y0 Z0\nG68 X1. Y2. Z3. I1. J1. K1. R120.\nG0 X10. Y20. Z30.\nG69\nX10. Y20. Z30.\nM30",
        &["G0 X0 Y0 Z0", "G0 X28 Y11 Z21", "G0 X10 Y20 Z30"],
    );
    // The second one stands in the coordinates of the first: (7, 1, 0) about X becomes (7, 0, 1), then about Z (0, 7, 1).
    let second = "G90 G0 X0 Y0 Z0\nG68 X0 Y0 Z0 I0 J0 K1. R90.\nG68 X5. Y0 Z0 I1. J0 K0 R90.\n";
    check("fanuc", &format!("{second}G0 X7. Y1. Z0\nM30"), &["G0 X0 Y0 Z0", "G0 X0 Y7 Z1"]);
    check_codes("fanuc", &format!("{second}G68 X0 Y0 Z0 I1. J0 K0 R90.\nM30"), &["E0201:4"]);
    check_codes("fanuc", &format!("{second}G68 X0 Y0 R90.\nM30"), &["E0201:4"]);
    // Where no center is given it is where the tool is.
    check("fanuc", "G90 G0 X1. Y2. Z3.\nG68 I1. J0 K0 R90.\nG0 X1. Y3. Z3.\nM30", &["G0 X1 Y2 Z3", "G0 X1 Y2 Z4"]);
    check_codes("fanuc", "G90 G0 X0 Y0 Z0\nG68 X0 Y0 Z0 I0 J0 K0 R90.\nM30", &["E0210:2"]);
}

#[test]
fn a_rotation_in_space_would_turn_the_tool_length_too() {
    let codes = |text: &str| run_with("fanuc", text, &with_tools(), Box::new(NoLibrary), Options::default()).1;
    assert_eq!(codes("G90 G43 H1 G0 X0 Y0 Z0\nG68 X0 Y0 Z0 I1. J0 K0 R90.\nM30"), ["E0201:2"]);
    assert_eq!(codes("G90 G0 X0 Y0 Z0\nG68 X0 Y0 Z0 I1. J0 K0 R90.\nG43 H1 Z5.\nM30"), ["E0201:3"]);
    // Not one about the tool, nor one of the plane.
    assert_eq!(codes("G90 G43 H1 G0 X0 Y0 Z0\nG68 X0 Y0 Z0 I0 J0 K1. R90.\nM30"), [""; 0]);
    assert_eq!(codes("G90 G43 H1 G0 X0 Y0 Z0\nG68 X0 Y0 R90.\nG0 X1.\nM30"), [""; 0]);
}

#[test]
fn feeds_per_turn_and_by_time_are_written_as_such() {
    for (name, point) in [("fanuc", "."), ("rs274", "")] {
        let text = format!(
            "G21 G90 G54 G17\nM3 S500\nG0 X0{point} Y0{point} Z0{point}\nG95 G1 X1{point} F0.125\nX2{point}\nG93 G1 X5{point} F2{point}\n\
             G1 X9{point} F4{point}\nG94 G1 X10{point} F300{point}\nM2\n"
        );
        let lines = written(name, "", &text);
        let moves: Vec<&String> = lines.iter().filter(|line| line.contains('X') && !line.contains("G0 ")).collect();
        let expected =
            ["G95 G1 X1. F0.125", "X2.", "G93 G1 X5. F2.", "X9. F4.", "G94 G1 X10. F300."].map(|line| match point {
                "" => line.split(' ').map(|word| word.trim_end_matches('.')).collect::<Vec<_>>().join(" "),
                _ => line.to_owned(),
            });
        let found: Vec<String> = moves.iter().map(|line| line.replace("G1 ", "")).collect();
        assert_eq!(found, expected.map(|line| line.replace("G1 ", "")), "{name}");
    }
    // A feed of the other mode does not hold on.
    check_codes("rs274", "G21 G90 G0 X0 Y0 Z0\nG94 F100\nG93 G1 X1\nM2", &["W0202:3"]);
    // In inch: 0.1 inch a turn; by time there is no unit.
    check(
        "rs274",
        "G20 G90 G0 X0 Y0 Z0\nG95\nG1 X1 F0.1\nG93\nG1 X2 F3\nM2",
        &["G0 X0 Y0 Z0", "G1 X25.4 Y0 Z0 F2.54 G95", "G1 X50.8 Y0 Z0 F3 G93"],
    );
    // The constant speed of the spindle says nothing of the feed.
    check(
        "fanuc",
        "G21 G90 G94 G54\nG97 S500 M3\nG0 X0. Y0. Z0.\nG1 X5. F100.\nM30",
        &["G0 X0 Y0 Z0", "G1 X5 Y0 Z0 F100"],
    );
}

#[test]
fn cutting_speeds_are_passed_on() {
    let lines = written("rs274", "", "G21 G90 G54 G17\nG96 D2500 S120\nM3\nG0 X0 Y0 Z0\nG97 S800\nG1 X1 F100\nM2\n");
    let text = lines.join("\n");
    assert!(
        text.contains("G96 D2500") && text.contains("S120") && text.contains("G97") && text.contains("S800"),
        "{text}"
    );
    let lines = written("fanuc", "", "G21 G90 G54 G17\nG96 P1 S120\nM3\nG0 X0 Y0 Z0\nG97 S800\nG1 X1. F100.\nM30\n");
    let text = lines.join("\n");
    assert!(
        text.contains("G96 P1") && text.contains("S120") && text.contains("G97") && text.contains("S800"),
        "{text}"
    );
    check_codes("rs274", "G96 D2500\nM2", &["E0210:1"]);
}

#[test]
fn states_of_subroutines_come_back_as_linuxcnc_brings_them() {
    let text = "o1 sub\nM73\nG91 G18 G20 G95 G55 M49 M7\nG0 X1\no1 endsub\nG21 G90 G17 G94 F100\nG10 L2 P1 X10 Y0 Z0\n\
                G10 L2 P2 X0 Y0 Z0\nG54 G0 X0 Y0 Z0\no1 call\nG1 X7\nM70\nG43.1 Z5\nG0 Z1\nM72\nG0 Z1\nM2";
    assert_near(
        &commands("rs274", text, &iso_machine()),
        &[[10.0, 0.0, 0.0], [35.4, 0.0, 0.0], [17.0, 0.0, 0.0], [17.0, 0.0, 6.0], [17.0, 0.0, 1.0]],
    );
    let lines = written(
        "rs274",
        "",
        "G21 G90 G17 G54 F100 G64 P0.05\nG0 X0 Y0 Z0\nM3 S500\nM8\nM70\nM49\nM9\nM5\nG61\nG1 X1\nM72\nG1 X2\nM2\n",
    );
    let text = lines.join("\n");
    let (_, after) = text.split_once("X1").unwrap();
    for word in ["M50 P1", "M51 P1", "M3", "M8", "G64 P0.05", "X2"] {
        assert!(after.contains(word), "{word}: {text}");
    }
    check_codes("rs274", "G21 M70\nM71\nM72\nM2", &["E0210:3"]);
}

/// LinuxCNC refuses two M codes of one group in a block, and two P.
#[test]
fn m_codes_of_one_group_come_back_on_lines_of_their_own() {
    let m_codes = |text: &str| -> Vec<String> {
        written("rs274", "", text).into_iter().filter(|line| line.starts_with('M') || line.starts_with('S')).collect()
    };
    assert_eq!(
        m_codes("G21 G90 F100\nG0 X0 Y0 Z0\nM7\nM8\nM70\nM9\nM72\nM2\n"),
        ["M7", "M8", "M9", "M9", "M7", "M8", "M2"]
    );
    assert_eq!(
        m_codes("G21 G90 F100\nG0 X0 Y0 Z0\nS100 M3\nM70\nM49\nM5 M8\nM72\nM2\n"),
        ["S100 M3", "M49", "M5 M8", "M9", "M50 P1", "M51 P1", "M3", "M2"]
    );
}

#[test]
fn reference_points_are_written_in_machine_coordinates() {
    let lines = written(
        "fanuc",
        "[zero_offset.G55]\nX_mm = 100\nZ_mm = 200",
        "G21 G90 G55 G17\nG0 X1. Y2. Z3.\nG91 G28 Z0\nG90 G0 Z5.\nG30 X10. Z20.\nG0 X0 Z5.\nG30 P4 Y3.\nM30\n",
    );
    let moves: Vec<&String> =
        lines.iter().filter(|line| line.contains("G0 ") || line.starts_with(['X', 'Y', 'Z'])).collect();
    assert_eq!(
        moves,
        [
            "G0 X1. Y2. Z3.",
            "G53 G0 Z450.",
            "G90 G0 Z5.",
            "G0 X10. Z20.",
            "G53 G0 X-30. Z250.",
            "G0 X0. Z5.",
            "G0 Y3.",
            "G53 G0 Y7.",
        ]
    );
}

#[test]
fn curves_in_inch() {
    // A quarter of a circle with a radius of an inch.
    let weight = 0.5_f64.sqrt();
    let text = format!(
        "G20 G90\nF10 G0 X1 Y0 Z0\nG5.2 X1 Y1 P{weight} L3\nX0 Y1 P1\nG5.3\nG91 G5.1 X2 Y0 I1 J1\nG90 G1 X0\nM2"
    );
    let (elements, codes) = elements("rs274", &text, &iso_machine(), Box::new(NoLibrary), Options::default());
    assert!(codes.is_empty(), "{codes:?}");
    let steps = |line: u32| -> Vec<[f64; 2]> {
        let of_line = elements.iter().filter(|element| element.origin.line == line);
        let steps = of_line.filter_map(|element| match &element.kind {
            Kind::Move(step) => {
                assert_eq!(step.feed, 254.0);
                Some([step.target[Axis::X], step.target[Axis::Y]])
            }
            _ => None,
        });
        steps.collect()
    };
    let quarter = steps(5);
    assert!(quarter.len() >= 45 && quarter.iter().all(|[x, y]| (x.hypot(*y) - 25.4).abs() < 1e-9));
    assert_eq!(quarter.last(), Some(&[0.0, 25.4]));
    // (0, 1), (1, 2), (2, 1): y = 1 + x − x²/2 in inch.
    let parabola = steps(6);
    let on_curve = |[x, y]: &[f64; 2]| (y / 25.4 - (1.0 + x / 25.4 - (x / 25.4).powi(2) / 2.0)).abs() < 1e-9;
    assert!(parabola.len() >= 45 && parabola.iter().all(on_curve));
    assert_eq!(parabola.last(), Some(&[50.8, 25.4]));
}
