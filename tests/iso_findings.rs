//! Fanuc and RS274/NGC: what must not get lost on the way to the output, or must not pass in silence.

use ncfix_language::exec::{NoLibrary, Options};

use crate::iso::{check_codes, iso_machine, run, run_with};
use crate::support::{Shop, machine};

fn strict(name: &str, text: &str) -> Vec<String> {
    let options = Options { strict: true, ..Options::default() };
    run_with(name, text, &iso_machine(), Box::new(NoLibrary), options).1
}

/// The lines of a corrected program.
fn fixed(on: &str, name: &str, text: &str) -> Vec<String> {
    let shop = Shop::new().file(name, text);
    shop.run(["fix", name, "-o", "out.nc", "--machine", &machine(on)]).exits(0);
    shop.text("out.nc").lines().map(|line| line.trim_end().to_owned()).collect()
}

/// 300 ft/min are 300 · 0.3048 m/min.
#[test]
fn a_cutting_speed_in_feet_becomes_one_in_meters() {
    for (name, text) in [
        ("rs274", "G20 G90 G97\nG96 D2000 S300 M3\nS400\nG97 S500\nG21\nG96 S300\nM2"),
        ("fanuc", "G20 G90 G97\nG96 S300 M3\nS400\nG97 S500\nG21\nG96 S300\nM30"),
    ] {
        let (lines, codes) = run(name, text);
        assert_eq!(codes, [""; 0]);
        let speeds: Vec<&str> =
            lines.iter().flat_map(|line| line.split(' ')).filter(|word| word.starts_with('S')).collect();
        assert_eq!(speeds, ["S91.44", "S121.92", "S500", "S300"], "{lines:?}");
    }
}

#[test]
fn words_that_bear_on_motion_are_not_left_out() {
    for block in
        ["G2 X10. Y0. Z-5. I-10. J0. L3", "G1 X10. I5.", "G1 X10. J5.", "G0 X10. P1", "G1 X10. Q2.", "G96 S100 Q1"]
    {
        let text = format!("G21 G90 G17 G0 X10. Y0. Z0.\nG1 F100.\n{block}\nM30");
        check_codes("fanuc", &text, &["E0210:3"]);
    }
    check_codes("fanuc", "G21 G90 G0 X0. H3\nM30", &["E0210:1"]);
    check_codes("fanuc", "G21 G90 G80\nM3 S100 P1\nM30", &["E0210:2"]);
}

/// X, Y and Z would be limits and a position.
#[test]
fn limits_of_travel_stand_alone() {
    check_codes("fanuc", "G21 G90 G0 X0. Y0. Z0.\nG0 G22 X10. Y10. Z10. I-10. J-10. K-10.\nM30", &["E0108:2"]);
    check_codes("fanuc", "G21 G90 G0 X0. Y0. Z0.\nG22 X10. Y10. Z10. I-10. J-10. K-10.\nG0 X1.\nM30", &[]);
}

#[test]
fn tapping_by_feed_moves_is_pointed_out_once_a_cycle() {
    check_codes("rs274", "G21 G90 G17 G94 G0 X0 Y0 Z5\nS100 M3\nG84 X1 Z-5 R2 P0 F100\nX2\nG80\nM2", &["W0207:3"]);
    check_codes(
        "fanuc",
        "G21 G90 G17 G94 G0 X0. Y0. Z5.\nS100 M3\nG74 X1. Z-5. R2. F100.\nX2.\nG80\nM30",
        &["W0207:3"],
    );
}

/// The machine has errors in all axes; where its reference point is, is none of them.
#[test]
fn a_reference_move_is_exact_and_names_its_axes_alone() {
    let text = "%\nO1\nG21 G17 G90 G40 G49 G80 G94\nT10 M6\nG90 G54 G0 X0. Y40. S900 M3\nG43 H10 Z30.\nG1 X10. F100.\nG91 G28 Z0.\n\
                G28 X0. Y0.\nG90 M30\n%\n";
    let lines = fixed("vmc", "o1.nc", text);
    let homes: Vec<&String> = lines.iter().filter(|line| line.contains("G53")).collect();
    assert_eq!(homes, ["G53 G0 Z0.", "G53 G0 X0. Y0."], "{lines:#?}");
    // Whatever else is corrected.
    assert!(!lines.iter().any(|line| line.starts_with("G0 X0. Y40.")), "{lines:#?}");
}

/// LinuxCNC: "Cannot do g1 with zero feed rate".
#[test]
fn each_feed_mode_clears_the_feed_of_rs274() {
    check_codes("rs274", "G21 F10\nG90 G17 G54 G94\nG1 X1\nM2", &["W0202:3"]);
    check_codes("rs274", "G21 G94 F10\nG1 X1\nM2", &[]);
    assert_eq!(strict("rs274", "G21 G90 G94 F10\nG0 X0 Y0 Z0\nG94 G1 X2\nM2"), ["E0215:3"]);
    check_codes("fanuc", "G21 G94 F10.\nG94 G1 X1.\nM30", &[]);
}

/// The F of a block with an error was not executed; the next feed move is not an error of its own.
#[test]
fn a_block_with_an_error_takes_its_feed_with_it() {
    for (name, head, error, end) in [
        ("sinumerik", "G90 G17 G71 G94\nG0 X0 Y0 Z0", "G1 X=1/0 F100", "M30"),
        ("fanuc", "G90 G17 G21 G94\nG0 X0. Y0. Z0.", "G1 X[1/0] F100.", "M30"),
        ("rs274", "G90 G17 G21 G94\nG0 X0 Y0 Z0", "G1 X[1/0] F100", "M2"),
    ] {
        let found = strict(name, &format!("{head}\n{error}\nG1 Y5.\n{end}"));
        assert!(found.len() == 1 && !found[0].starts_with("E0215"), "{name}: {found:?}");
        // Without an F in the block with the error, both are reported.
        let found = strict(name, &format!("{head}\n{}\nG1 Y5.\n{end}", error.rsplit_once(' ').unwrap().0));
        assert!(found.iter().any(|one| one.starts_with("E0215")), "{name}: {found:?}");
    }
}

/// The position of a block with an error was not reached; an arc from there is not an error of its own.
#[test]
fn a_block_with_an_error_takes_its_position_with_it() {
    for (name, head, error, other, end) in [
        ("sinumerik", "G90 G17 G71 G94\nG0 X0 Y0 Z0 F100", "G1 X=1/0 Y10", "R1=1/0", "M30"),
        ("fanuc", "G90 G17 G21 G94\nG0 X0. Y0. Z0. F100.", "G1 X[1/0] Y10.", "#1=[1/0]", "M30"),
        ("rs274", "G90 G17 G21 G94 F100\nG0 X0 Y0 Z0", "G1 X[1/0] Y10", "#1=[1/0]", "M2"),
    ] {
        // From (0, 0) about (5, 0) to (50, 0): the radii are 5 and 45.
        let arc = "G2 X50. Y0. I5. J0.";
        let found = strict(name, &format!("{head}\n{error}\n{arc}\n{end}"));
        assert!(found.len() == 1 && !found[0].starts_with("E0203"), "{name}: {found:?}");
        // Without a position in the block with the error, both are reported.
        let found = strict(name, &format!("{head}\n{other}\n{arc}\n{end}"));
        assert!(found.len() == 2 && found[1].starts_with("E0203"), "{name}: {found:?}");
    }
}

/// LinuxCNC shows `val 2.500000 7 1.25  x` and `a 2.500000`.
#[test]
fn texts_show_the_values_that_are_executed_away() {
    let text = "#1=2.5\n#<_deep>=7\n#<own>=1.25\n(debug, val #1 %d#<_deep> %.2f#<OWN> x)\n(print,a #1)\n(MSG, v #1)\nG21 G90 G0 X0 Y0 Z0\nM2";
    let lines = fixed("knee_mill", "a.ngc", text).join("\n");
    assert!(lines.contains("(DEBUG, val 2.500000 7 1.25 x)"), "{lines}");
    assert!(lines.contains("(PRINT,a 2.500000)"), "{lines}");
    assert!(lines.contains("(MSG, v #1)"), "{lines}");
}

/// LinuxCNC shows `pass 1.000000`, `pass 2.000000`, `pass 3.000000`, and three times `turn`.
#[test]
fn texts_in_a_loop_show_the_values_of_each_pass() {
    let text = "#1=0\no1 repeat [3]\n#1=[#1+1] (plain)\n(debug,pass #1)\n(MSG,turn)\n(LOG,a #1)\no1 endrepeat\nG21 G90 G0 X0 Y0 Z0\nM2";
    let lines = fixed("knee_mill", "a.ngc", text);
    let shown = |part: &str| lines.iter().filter_map(|line| line.find(part).map(|at| line[at..].to_owned())).collect();
    let debug: Vec<String> = shown("(DEBUG");
    assert_eq!(debug, [1, 2, 3].map(|pass| format!("(DEBUG,pass {pass}.000000)")), "{lines:#?}");
    let log: Vec<String> = shown("(LOG");
    assert_eq!(log, [1, 2, 3].map(|pass| format!("(LOG,a {pass}.000000)")), "{lines:#?}");
    assert_eq!(lines.iter().filter(|line| line.contains("(MSG,turn)")).count(), 3, "{lines:#?}");
    assert_eq!(lines.iter().filter(|line| line.contains("(plain)")).count(), 1, "{lines:#?}");
}

#[test]
fn texts_with_values_are_bounded_and_searched_once() {
    // 2000 openings without end, and values of 300 digits each, twenty thousand times.
    let openings = "#<".repeat(2000);
    let long = "%.9f#1 ".repeat(500);
    let started = std::time::Instant::now();
    let text = format!(
        "#1=[10**300]\no1 repeat [20000]\n(debug,{openings})\n(debug,{long})\no1 endrepeat\nG21 G90 G0 X0 Y0 Z0\nM2"
    );
    let lines = fixed("knee_mill", "a.ngc", &text);
    assert!(lines.iter().all(|line| line.len() <= 250), "{}", lines.len());
    assert!(lines.iter().filter(|line| line.contains("(DEBUG,100000000")).count() == 20_000, "{}", lines.len());
    assert!(started.elapsed() < std::time::Duration::from_secs(10), "{:?}", started.elapsed());
}

#[test]
fn a_corrected_position_is_not_stored() {
    let text = "G21 G90 G0 X1 Y2 Z3\nG28.1\nG30.1\nM2";
    assert_eq!(strict("rs274", text), ["E0201:2", "E0201:3"]);
    check_codes("rs274", text, &[]);
}

#[test]
fn inches_are_not_passed_on_in_codes_of_the_vendor() {
    check_codes("fanuc", "G20 G90\nG187 P1 E.002\nM30", &["E0201:2"]);
    check_codes("fanuc", "G20 G90\nG187 P1\nM30", &[]);
    check_codes("fanuc", "G21 G90\nG187 P1 E.05\nM30", &[]);
}

/// The output stays in inches, with six decimals.
#[test]
fn a_pitch_has_as_many_digits_as_controls_read() {
    let text = "G20 G90 G17 G94 G0 X0 Y0 Z1\nS100 M3\nG33 Z0.5 K[0.0707+1/30000000]\nM2";
    let lines = fixed("knee_mill", "a.ngc", text).join("\n");
    // 0.0707 + 1/3·10⁻⁷
    assert!(lines.contains("K0.0707\n"), "{lines}");
}
