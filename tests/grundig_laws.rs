//! Grundig: laws that hold whatever the program is, and details of words, tables and flow.

use ncfix_language::exec::{NoLibrary, Options};
use ncfix_machine::machine::{GrundigControl, ScaledAxes};

use crate::exec::Programs;
use crate::grundig::{check, check_codes, check_from, mill, motions, run, run_on, tool};
use crate::support::{Shop, machine};

fn moves(text: &str) -> Vec<String> {
    let (lines, codes) = run(text);
    assert!(codes.iter().all(|code| code.starts_with('W')), "{codes:?}");
    motions(&lines, [0.0; 3])
}

#[test]
fn a_repetition_is_what_it_stands_for() {
    let head = "N1 G17 G90 G0 X0 Y0 Z0 F100\nN2 G91 G1 X3\n";
    let looped = moves(&format!("{head}N3 Y1\nN4 G14 N1=3 J2\nN5 X-3\nN6 G14 N1=3 N2=5 J2\nN7 Z1\n"));
    let inner = "Y1\n".repeat(3) + "X-3\n";
    let unrolled = moves(&format!("{head}{}Z1\n", inner.repeat(3)));
    assert_eq!(looped, unrolled);
    assert_eq!(looped.len(), 1 + 12 + 1);
}

#[test]
fn four_repetitions_within_one_another() {
    let text = "N1 G17 G91 F100
N2 G1 X1
N3 G14 N1=2 J1
N4 Y1
N5 G14 N1=2 N2=4 J1
N6 Z1
N7 G14 N1=2 N2=6 J1
N8 X-1
N9 G14 N1=2 N2=8 J1";
    // (((2 X + Y) · 2 + Z) · 2 + X) · 2
    assert_eq!(moves(text).len(), (((2 + 1) * 2 + 1) * 2 + 1) * 2);
}

#[test]
fn a_repetition_counts_a_parameter_down() {
    assert_eq!(moves("N1 G17 G91 E1=3\nN2 G1 X1 F100\nN3 G14 N1=2 E1\nN4 Y=E1+5").len(), 1 + 3 + 1);
    assert_eq!(moves("N1 G17 G91 E1=3\nN2 G1 X1 F100\nN3 G14 N1=2 E1 K2").len(), 1 + 2);
    assert_eq!(moves("N1 G17 G91\nN2 G1 X1 F100\nN3 G14 N1=2 J0").len(), 1);
    check_codes("N1 G17 G90 G0 X1\nN3 G14 N1=1 J-1", &["E0210:2"]);
    check_codes("N1 G17 G90 G0 X1\nN3 G14 N1=7 J1", &["E0211:2"]);
}

#[test]
fn a_jump_out_of_a_section_ends_its_repetition() {
    let text = "N1 G17 G91 E1=0 F100
N2 E1=E1+1 E2=E1>2
N3 G29 E2 N=6
N4 G1 X1
N5 G14 N1=2 N2=4 J9
N6 Y1";
    assert_eq!(moves(text).len(), 3);
}

#[test]
fn two_mirrors_are_none() {
    let contour = "G0 X10 Y0\nG1 X20 F200\nG3 X30 Y10 I20 J10\nG2 X40 Y20 R10\n";
    let plain = moves(&format!("N1 G17 G90\n{contour}"));
    assert_eq!(moves(&format!("N1 G17 G90\nN2 G73 X-1 Y-1\nN3 G73 X1\nN4 G73 Y1\n{contour}")), plain);
    // Both mirrors together are half a turn.
    let mirrored = moves(&format!("N1 G17 G90\nN2 G73 X-1 Y-1\n{contour}"));
    assert_eq!(mirrored, moves(&format!("N1 G17 G90\nN2 G93 B4=180\n{contour}")));
}

#[test]
fn a_shift_and_its_inverse_are_none() {
    let contour = "G0 X10 Y0\nG1 X20 F200\nG3 X30 Y10 I20 J10\n";
    let plain = moves(&format!("N1 G17 G90\n{contour}"));
    let shifted = moves(&format!("N1 G17 G90\nN2 G92 X7 Y-3\nN3 G92 B4=25\nN4 G92 B4=-25\nN5 G92 X-7 Y3\n{contour}"));
    assert_eq!(shifted, plain);
    assert_eq!(moves(&format!("N1 G17 G90\nN2 G92 X7 Y-3 B4=25\nN3 G93 X0 Y0 B4=0\n{contour}")), plain);
}

#[test]
fn macros_are_found_beside_the_program_and_eight_deep() {
    let library = || Box::new(Programs(vec![("9101.MM", "%MM9101\nN9101\nN1 G1 X5 F100\n"), ("9102", "N1 Y5\n")]));
    let text = "%PM\nN9000\nN1 G17 G90 G22 N=9101\nN2 M30";
    check_codes(text, &["E0108:3"]);
    let (lines, codes) =
        run_on("%PM\nN9000\nN1 G17 G90\nN2 G22 N=9101\nN3 G22 N=9102", &mill(), library(), Options::default());
    assert!(codes.is_empty(), "{codes:?}");
    assert_eq!(lines, ["G1 X5 Y0 Z0 F100", "G1 X5 Y5 Z0 F100"]);
    let nested = |depth: u32| {
        let mut text = "%PM\nN9000\nN1 G17 G90 F100\nN2 G22 N=1\n".to_owned();
        for k in 1..depth {
            text.push_str(&format!("%MM{k}\nN{k}\nN1 G22 N={}\n", k + 1));
        }
        text + &format!("%MM{depth}\nN{depth}\nN1 G1 X5\n")
    };
    assert_eq!(run(&nested(8)).1, [""; 0]);
    assert_eq!(run(&nested(9)).1.len(), 1);
}

#[test]
fn parameters_of_a_call_and_conditional_calls() {
    let text = "%PM\nN9000\nN1 G17 G90 E1=0\nN2 G22 N=9101 E2=7\nN3 G22 E1 N=9101\nN4 E1=1\nN5 G22 E1 N=9101 E2=9
%MM9101\nN9101\nN1 G1 X=E2 F100";
    check(text, "G1 X7 Y0 Z0\nG1 X9 Y0 Z0");
}

#[test]
fn expressions_follow_their_priorities() {
    check(
        "N1 G17 G90 E1=2+3*4:6-1 E2=-2^2 E3=(1+2)*sqrt(16) E4=E1=3 E5=sin(30)*10 E6=int(7.9)+abs(-2)
N2 G1 X=E1 Y=E2 Z=E3 F100
N3 X=E4 Y=E5 Z=E6
N4 X=10-E1 Y+4 Z=E7:4+1",
        // 2 + 12:6 − 1 = 3; −(2²) = −4; 3·4 = 12; E1=3 is true; 5; 7 + 2; E7 was never assigned.
        "G1 X3 Y-4 Z12\nG1 X1 Y5 Z9\nG1 X7 Y4 Z1",
    );
    check_codes("N1 G17 G90 E1=1:0", &["E0209:1"]);
    check_codes("N1 G17 G90 E2000=1", &["E0207:1"]);
}

#[test]
fn absolute_and_incremental_words_by_their_index() {
    check(
        "N1 G17 G90 F100\nN2 G1 X10 Y91=5\nN3 G91\nN4 X1 Y90=2\nN5 X90=4 Y1",
        "G1 X10 Y5 Z0\nG1 X11 Y2 Z0\nG1 X4 Y3 Z0",
    );
    check_codes("N1 G17 G90 G0 X1 X91=2", &["E0111:1"]);
}

#[test]
fn inches_are_converted() {
    let (lines, _) = run("N1 G17 G90 G70\nN2 G1 X1 F10\nN3 G3 X2 Y1 I1 J1\nN4 G71 G1 X5");
    assert_eq!(lines[0], "G1 X25.4 Y0 Z0 F254");
    assert!(lines[1].starts_with("G3 X50.8 Y25.4 Z0 I0 J25.4"), "{lines:?}");
    assert!(lines[2].starts_with("G1 X5 Y25.4 Z0"), "{lines:?}");
}

#[test]
fn helices_by_pitch_sweep_and_depth() {
    let start = [10.0, 0.0, 0.0];
    // Without a sweep the pitch and the depth say how many turns there are.
    check_from(
        "N1 G17 G90 F100\nN2 G3 I0 J0 K4 Z-6",
        start,
        &mill(),
        "G3/17 X10 Y0 Z-4 I-10 J0\nG3/17 X-10 Y0 Z-6 I-10 J0",
    );
    // With an end point they must lead there: a quarter and two turns at a pitch of 4 are 9 mm.
    check_from(
        "N1 G17 G90 F100\nN2 G3 X0 Y10 I0 J0 K4 Z-9",
        start,
        &mill(),
        "G3/17 X10 Y0 Z-4 I-10 J0\nG3/17 X10 Y0 Z-8 I-10 J0\nG3/17 X0 Y10 Z-9 I-10 J0",
    );
    for faulty in ["G3 X0 Y10 I0 J0 K4 Z-8", "G3 I0 J0 K4 B5=720 Z-9", "G3 I0 J0 K4 B5=720", "G3 X0 Y10 I0 J0 B5=90"] {
        check_codes(&format!("N1 G17 G90 F100\nN2 G0 X10 Y0 Z0\nN3 {faulty}"), &["E0205:3"]);
    }
    check_codes("N1 G17 G90 F100\nN2 G0 X10 Y0 Z0\nN3 G3 X0 Y10 I0", &["E0202:3"]);
}

#[test]
fn positioning_logic_can_be_switched_off() {
    check("N1 G17 G90\nN2 G28 I5=1\nN3 G0 X10 Z5\nN4 G27\nN5 X0 Z0", "G0 X10 Y0 Z5\nG0 X0 Y0 Z5\nG0 X0 Y0 Z0");
    // In G18 the tool lies along Y.
    check("N1 G18 G90\nN2 G0 X10 Y5 Z3", "G0 X0 Y5 Z0\nG0 X10 Y5 Z3");
}

#[test]
fn the_table_of_zero_offsets_is_read_and_written() {
    check(
        "N1 G17 G90\nN2 G149 N1=54 X7=80 Y7=81\nN3 G150 N1=54.03 X7=E80+7 Y7=E81\nN4 G54 I3\nN5 G0 X1 Y1\nN6 G53\nN7 X=E80",
        "G0 X108 Y51 Z0\nG0 X100 Y51 Z0",
    );
    check("N1 G17 G90\nN2 G54 I5 X30 Y20\nN3 G0 X1 Y1\nN4 G54\nN5 X1 Y1", "G0 X31 Y21 Z0\nG0 X101 Y51 Z0");
}

#[test]
fn tables_in_the_transfer_hold_for_the_run() {
    check(
        "%TM\nN1 T4 L80 R5.5 L4=0.5 R4=-0.5\n%ZO\nG55 X10 Y20\nN56 X1 Y2\n%PA\nE7=12\n%PO\nP3 X7 Y8
%PM9000\nN9000\nN1 G17 G90 T4 M67\nN2 G55\nN3 G0 X=E7 Y0\nN4 G56\nN5 P3\nN6 G53 G1 X0 Y0 F100\nN7 G41\nN8 X10 Y0\nN9 X20\nN10 G40\nN11 X30 Y9",
        // The text shows the tip: 80 + 0.5 below, radius 5.5 − 0.5.
        "G0 X22 Y20 Z-80.5\nG0 X8 Y10 Z-80.5\nG1 X0 Y0 Z-80.5\nG1 X10 Y5 Z-80.5\nG1 X20 Y5 Z-80.5\nG1 X30 Y9 Z-80.5",
    );
}

#[test]
fn saved_tables_are_a_set_up() {
    let shop = Shop::new()
        .file("tools.tm", "%TM\nT77 L100.5 R6\n")
        .file("offsets.zo", "%ZO\nG54 I9 X-11 Y-22 Z33\n")
        .file("9000.pm", "%PM\nN9000\nN1 G17 G90 G54 I9\nN2 T77 M6\nN3 G0 X1 Y2 Z3\nN4 M30\n");
    let options = ["--setup", "tools.tm", "--setup", "offsets.zo"];
    let on = machine("universal_mill");
    let arguments = ["snc", "9000.pm", "--machine", &on];
    let run = shop.run(arguments.into_iter().chain(options)).exits(0);
    assert!(run.stderr.is_empty(), "{}", run.stderr);
    assert!(run.stdout.contains("G0 X-10 Y-20 Z36"), "{}", run.stdout);
}

#[test]
fn tool_lengths_act_along_the_tool_axis() {
    let mut machine = mill();
    machine.tools.push(tool(5, 100.0, 6.0));
    let shown = |text: &str| {
        let (lines, codes) = run_on(text, &machine, Box::new(NoLibrary), Options::default());
        assert!(codes.is_empty(), "{codes:?}");
        lines.last().unwrap().clone()
    };
    // The text shows the tip, so the length shows where it is not restated.
    assert_eq!(shown("N1 G17 G90 G0 X0 Y0 Z0\nN2 T5 M67\nN3 G0 X1"), "G0 X1 Y0 Z-100");
    assert_eq!(shown("N1 G18 G90 G0 X0 Y0 Z0\nN2 T5 M67\nN3 G0 X1"), "G0 X1 Y-100 Z0");
    assert_eq!(shown("N1 G17 G90 G0 X0 Y0 Z0\nN2 T5 M67\nN3 G39 L0.5 R0\nN4 G0 X1"), "G0 X1 Y0 Z-100.5");
}

#[test]
fn cycles_in_the_plane_with_the_tool_along_y() {
    // Angles count from X towards -Z: the second hole of two lies at 90°.
    check_from(
        "N1 G18 G90\nN2 G81 Y2 Z-5 F100\nN3 G77 X10 Y0 Z20 R5 I0 K90 J2",
        [0.0, 10.0, 0.0],
        &mill(),
        "G0 X15 Y10 Z20
G0 X15 Y2 Z20
G1 X15 Y-5 Z20
G0 X15 Y2 Z20
G0 X10 Y2 Z15
G1 X10 Y-5 Z15
G0 X10 Y2 Z15",
    );
}

#[test]
fn what_is_not_executed_is_refused() {
    let refused = |code: &str| run(&format!("N1 G17 G90 G0 X1 Y1\nN2 {code}")).1;
    for code in ["G8 A5=30", "G6 X1", "G45 X1 Y2", "G182 R5", "G200", "G786 X1"] {
        assert_eq!(refused(code), ["E0201:2"], "{code}");
    }
    // The machine has no rotary axes.
    assert_eq!([refused("G7 A5=30"), refused("G141")], [["E0235:2"], ["E0309:2"]]);
    // The window of the graphics is nobody's business.
    check("N1 G98 X-10 Y-10 Z-10 I20 J20 K20\nN2 G17 G90 G0 X1", "G0 X1 Y0 Z0");
}

#[test]
fn places_of_the_machine_are_passed_on() {
    let shop = Shop::new().file(
        "9000.pm",
        "%PM\nN9000\nN1 G17 G90 G54\nN2 T2 M6\nN3 G0 X1 Y2 Z3\nN4 G74 Z-1 L1\nN5 G0 X20\nN6 Z5\nN7 G74 X1=1 Y1=1 K1\nN8 M30\n",
    );
    shop.run(["9000.pm", "-o", "out.pm", "--machine", &machine("universal_mill")]).exits(0);
    let text = std::fs::read_to_string(shop.path("out.pm")).unwrap();
    assert!(text.contains("G74 Z-1 L1") && text.contains("G74 X1=1 Y1=1 K1"), "{text}");
    // What is relative to an unknown place is refused.
    let shop = Shop::new()
        .file("9000.pm", "%PM\nN9000\nN1 G17 G90 G54\nN2 T2 M6\nN3 G0 X1 Y2 Z3\nN4 G74 Z-1 L1\nN5 G91 G0 Z5\nN6 M30\n");
    let run = shop.run(["9000.pm", "-o", "out.pm", "--json", "--machine", &machine("universal_mill")]);
    assert_eq!(run.codes(), ["E0304"]);
}

#[test]
fn further_programs_are_pointed_out() {
    check_codes("%PM1\nN1\nN1 G17 G90 G0 X1\nN2 M30\n%PM2\nN2\nN1 X2\nN2 M30", &["W0203:5"]);
    check(
        "%PM1\nN1\nN1 G17 G90 G0 X1\nN2 G23 N=2\nN3 X3\nN4 M30\n%PM2\nN2\nN1 X2\nN2 M30",
        "G0 X1 Y0 Z0\nG0 X2 Y0 Z0\nG0 X3 Y0 Z0",
    );
}

#[test]
fn blocks_behind_a_slash_are_left_out_on_demand() {
    let text = "N1 G17 G90 G0 X1\n/N2 X2\nN3 X3";
    let mut options = Options::default();
    options.skip_levels[0] = true;
    let (lines, codes) = run_on(text, &mill(), Box::new(NoLibrary), options);
    assert_eq!((lines.len(), codes), (2, vec!["W0201:2".to_owned()]));
    assert_eq!(run(text).0.len(), 3);
}

#[test]
fn settings_say_how_frames_act_together() {
    let at = |set: fn(&mut GrundigControl), text: &str, expected: &str| {
        let mut machine = mill();
        set(&mut machine.control.grundig);
        check_from(text, [0.0; 3], &machine, expected);
    };
    // (10, 0) turned is (0, 10), shifted (20, 20); mirrored outside (-20, 20), inside it was (-10, 0) first.
    let text = "N1 G17 G90\nN2 G93 X20 Y10 B4=90\nN3 G73 X-1\nN4 G0 X10 Y0";
    at(|_| {}, text, "G0 X20 Y0 Z0");
    at(|settings| settings.mirror_outside = true, text, "G0 X-20 Y20 Z0");
    // A second shift behind a quarter turn.
    let text = "N1 G17 G90\nN2 G92 X20 B4=90\nN3 G92 X5\nN4 G0 X1 Y0";
    at(|_| {}, text, "G0 X20 Y6 Z0");
    at(|settings| settings.shift_is_turned = false, text, "G0 X25 Y1 Z0");
    at(|settings| settings.turns_first = true, text, "G0 X0 Y26 Z0");
    let text = "N1 G17 G90\nN2 G73 A4=200\nN3 G0 X1 Y2\nN4 Z3";
    let scaled = |settings: &mut GrundigControl| {
        settings.scale_in_percent = true;
        settings.scaled_axes = ScaledAxes::All;
    };
    at(scaled, text, "G0 X2 Y4 Z0\nG0 X2 Y4 Z6");
    at(|settings| settings.positioning_logic = false, "N1 G17 G90\nN2 G0 X1 Z2", "G0 X1 Y0 Z2");
    // A chamfer of 3 is 3 / sqrt(2) from a right corner.
    let text = "N1 G17 G90 G64 F100\nN2 G1 X20 I1=3\nN3 Y20";
    at(|settings| settings.chamfer_is_length = true, text, "G1 X17.87868 Y0 Z0\nG1 X20 Y2.12132 Z0\nG1 X20 Y20 Z0");
}
