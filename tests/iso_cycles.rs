//! Canned cycles of Fanuc and RS274/NGC; the motions are those of the reference and of the controls' manuals, written out by hand.

use ncfix_base::geometry::Axis;
use ncfix_language::exec::{NoLibrary, Options};

use crate::iso::{check, check_codes, check_on, iso_machine, run, run_with};

#[test]
fn spindle_dwell_and_stop_stand_in_their_places() {
    let (lines, codes) = run(
        "fanuc",
        "G90 G0 X0 Y0 Z10. M3 S500
G98 G84 X1. Z-5. R2. P500 F100.
G86 X2. Z-5.
G88 X3. P1000
G80 M30",
    );
    assert_eq!(codes, ["W0207:2"]);
    let wanted = [
        "S500 M3",
        "G0 X0 Y0 Z10",
        "G0 X1 Y0 Z10",
        "G0 X1 Y0 Z2",
        "G1 X1 Y0 Z-5 F100",
        "G4 S0.5",
        "M4",
        "G1 X1 Y0 Z2 F100",
        "M3",
        "G0 X1 Y0 Z10",
        "G0 X2 Y0 Z10",
        "G0 X2 Y0 Z2",
        "G1 X2 Y0 Z-5 F100",
        "M5",
        "G0 X2 Y0 Z10",
        "M3",
        "G0 X3 Y0 Z10",
        "G0 X3 Y0 Z2",
        "G1 X3 Y0 Z-5 F100",
        "G4 S1",
        "M5",
        "M0",
        "G0 X3 Y0 Z10",
        "M3",
        "M30",
    ];
    assert_eq!(lines, wanted);
}

#[test]
fn fine_boring_steps_aside_in_machine_directions() {
    let mut machine = iso_machine();
    machine.control.iso.orient_shift = Some((Axis::X, -1.0));
    check_on(
        "fanuc",
        "G90 G0 X0 Y0 Z10.
G76 X10. Y0 Z-5. R2. Q0.5 F100.
G80 G51.1 X50.
G76 X20. Q0.5 R2. Z-5.",
        &machine,
        &[
            "G0 X0 Y0 Z10",
            "G0 X10 Y0 Z10",
            "G0 X10 Y0 Z2",
            "G1 X10 Y0 Z-5 F100",
            "G0 X9.5 Y0 Z-5",
            "G0 X9.5 Y0 Z10",
            "G0 X10 Y0 Z10",
            // Mirrored to 80, and still to the same side of the machine.
            "G0 X80 Y0 Z10",
            "G0 X80 Y0 Z2",
            "G1 X80 Y0 Z-5 F100",
            "G0 X79.5 Y0 Z-5",
            "G0 X79.5 Y0 Z10",
            "G0 X80 Y0 Z10",
        ],
    );
    check_codes("fanuc", "G90 G0 X0 Y0 Z10.\nG76 X10. Z-5. R2. Q0.5 F100.", &["E0210:2"]);
}

#[test]
fn tapping_is_refused_for_a_correction_where_it_may_be_rigid() {
    let program = "G54 G90 G0 X0 Y0 Z10.\nG84 X1. Y1. Z-5. R2. F100.\nM30";
    let rigid = "G54 G90 G0 X0 Y0 Z10.\nM29 S500\nG84 X1. Y1. Z-5. R2. F100.\nM30";
    let mut machine = iso_machine();
    let run = |program: &str, machine: &ncfix_machine::machine::Machine, strict: bool| {
        run_with("fanuc", program, machine, Box::new(NoLibrary), Options { strict, ..Options::default() }).1
    };
    assert_eq!(run(program, &machine, false), ["W0207:2"]);
    assert_eq!(run(program, &machine, true), ["E0201:2"]);
    machine.control.iso.rigid_tapping = Some(false);
    assert_eq!(run(program, &machine, true), ["W0207:2"]);
    assert_eq!(run(rigid, &machine, true), ["E0201:3"]);
    machine.control.iso.rigid_tapping = Some(true);
    assert_eq!(run(program, &machine, true), ["E0201:2"]);
}

#[test]
fn a_cycle_from_a_level_that_is_not_known_is_refused_for_a_correction() {
    let options = || Options { strict: true, ..Options::default() };
    let machine = iso_machine();
    for program in ["G54 G90 G0 X0 Y0\nG81 X1. Y1. Z-5. R2. F100.", "G54 G90 G0 Z5.\nG81 X1. Z-5. R2. F100."] {
        let (_, codes) = run_with("fanuc", program, &machine, Box::new(NoLibrary), options());
        assert_eq!(codes, ["E0304:2"], "{program}");
    }
    // The first hole is a motion even where the tool seems to be there.
    let (lines, codes) =
        run_with("fanuc", "G54 G90 G0 Z5.\nG81 X0 Y0 Z-5. R2. F100.", &machine, Box::new(NoLibrary), options());
    assert!(codes.is_empty(), "{codes:?}");
    assert_eq!(lines[1], "G0 X0 Y0 Z5");
}

#[test]
fn linuxcnc_cycles() {
    let (lines, codes) = run(
        "rs274",
        "G21 G90 G17 F100 S500 M3
G0 X0 Y40 Z1
G98 G85 X5 Z-5 R3
G99 G89 X6 Z-5 R3 P0.5
G84 X9 Z-5 R2 P0.2
G88 X12 Z-5 R2 P0.1
G98 G81 X13 R2 Z-3
G91 X1 L2
G90 G1 X0
M2",
    );
    assert_eq!(codes, ["W0207:5"]);
    let wanted = [
        "S500 M3",
        "G0 X0 Y40 Z1",
        "G0 X0 Y40 Z3",
        "G0 X5 Y40 Z3",
        "G1 X5 Y40 Z-5 F100",
        "G1 X5 Y40 Z3 F100",
        "G0 X6 Y40 Z3",
        "G1 X6 Y40 Z-5 F100",
        "G4 S0.5",
        "G1 X6 Y40 Z3 F100",
        // The level of the first cycle, 1, is below R.
        "G0 X6 Y40 Z2",
        "G0 X9 Y40 Z2",
        "G1 X9 Y40 Z-5 F100",
        "M5",
        "M4",
        "G4 S0.2",
        "G1 X9 Y40 Z2 F100",
        "M5",
        "M3",
        "G0 X12 Y40 Z2",
        "G1 X12 Y40 Z-5 F100",
        "G4 S0.1",
        "M5",
        "M0",
        "M3",
        "G0 X12 Y40 Z2",
        "G0 X13 Y40 Z2",
        "G1 X13 Y40 Z-3 F100",
        "G0 X13 Y40 Z2",
        // R counts from that level, Z from R.
        "G0 X13 Y40 Z3",
        "G0 X14 Y40 Z3",
        "G1 X14 Y40 Z0 F100",
        "G0 X14 Y40 Z3",
        "G0 X15 Y40 Z3",
        "G1 X15 Y40 Z0 F100",
        "G0 X15 Y40 Z3",
        "G1 X0 Y40 Z3 F100",
        "M2",
    ];
    assert_eq!(lines, wanted);
}

#[test]
fn linuxcnc_refuses_what_it_needs_and_does_not_get() {
    let begin = "G21 G90 F100 S500 M3\nG0 X0 Y0 Z10\n";
    for block in [
        "G81 X1 Z-1",
        "G81 X1 R1",
        "G81 X1 R-2 Z-1",
        "G82 X1 R1 Z-1",
        "G83 X1 R1 Z-1",
        "G83 X1 R1 Z-1 Q0",
        "G81 X1 R1 Z-1 L0",
        "G74 X1 R1 Z-1",
        "G81 X1 R1 Z-1 A5",
    ] {
        let (_, codes) = run("rs274", &format!("{begin}{block}"));
        assert_eq!(codes.len(), 1, "{block} {codes:?}");
    }
    check_codes("rs274", &format!("{begin}G87 X1 R1 Z-1 I1 J1 K1"), &["E0201:3"]);
}

#[test]
fn linuxcnc_takes_a_tool_for_drawn_out_behind_g88() {
    // The next hole begins above, whether the tool was there or not.
    check(
        "rs274",
        "G21 G90 F100 S500 M3\nG0 X0 Y0 Z10\nG88 X1 Z-2 R1 P0 L2\nG80\nG81 Z-3 R1",
        &[
            "G0 X0 Y0 Z10",
            "G0 X1 Y0 Z10",
            "G0 X1 Y0 Z1",
            "G1 X1 Y0 Z-2 F100",
            "G0 X1 Y0 Z1",
            "G1 X1 Y0 Z-2 F100",
            "G0 X1 Y0 Z1",
            "G1 X1 Y0 Z-3 F100",
            "G0 X1 Y0 Z1",
        ],
    );
    let program = "G54 G21 G90 F100 S500 M3\nG0 X0 Y0 Z10\nG88 X1 Z-2 R1 P0\nX2";
    let options = Options { strict: true, ..Options::default() };
    let (_, codes) = run_with("rs274", program, &iso_machine(), Box::new(NoLibrary), options);
    assert_eq!(codes, ["E0304:4"]);
}

#[test]
fn exact_stops_hold_within_linuxcnc_cycles_and_the_mode_of_the_program_comes_back() {
    use ncfix_machine::snc::Kind;
    let text = "G21 G90 F100\nG64 P0.05\nG0 X0 Y0 Z10\nG81 X1 Z-1 R1\nX2\nG0 X3\nG61\nG81 X4 Z-1 R1\nM2";
    let (elements, codes) =
        crate::iso::elements("rs274", text, &iso_machine(), Box::new(NoLibrary), Options::default());
    assert!(codes.is_empty(), "{codes:?}");
    let modes: Vec<(u32, String)> = elements
        .iter()
        .filter_map(|element| match &element.kind {
            Kind::Keep(word) if word.starts_with("G6") => Some((element.origin.line, (*word).to_owned())),
            Kind::Verbatim(text) => Some((element.origin.line, String::from_utf8(text.clone()).unwrap())),
            _ => None,
        })
        .collect();
    let wanted = [(2, "G64 P0.05"), (4, "G61"), (6, "G64 P0.05"), (7, "G61")];
    assert_eq!(modes, wanted.map(|(line, text)| (line, text.to_owned())));
}
