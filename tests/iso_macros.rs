//! Custom macros of Fanuc: variables, expressions, jumps, loops and calls, with expected values worked out by hand.

use ncfix_language::exec::{Library, NoLibrary, Options};
use ncfix_machine::machine::{Machine, Opaque, Setting};
use ncfix_machine::snc::Kind;

use crate::iso::{check, check_codes, check_on, elements, iso_machine, moves, run, run_with};

/// Files by name.
struct Files(&'static [(&'static str, &'static str)]);

impl Library for Files {
    fn load(&mut self, _name: &str) -> Option<(String, Vec<u8>)> {
        None
    }

    fn load_file(&mut self, names: &[String]) -> Option<(String, Vec<u8>)> {
        let (name, text) = names.iter().find_map(|name| self.0.iter().find(|(known, _)| known == name))?;
        Some(((*name).to_owned(), text.as_bytes().to_vec()))
    }
}

/// The value of an expression, through a move of X.
fn value_on(machine: &Machine, before: &str, expression: &str) -> Result<f64, Vec<String>> {
    let text = format!("G90 G0 X0 Y0 Z0\n{before}\nG0 X[{expression}]\nM30\n");
    let (lines, mut codes) = run_with("fanuc", &text, machine, Box::new(NoLibrary), Options::default());
    // A position from a value of the control is what these programs are for.
    codes.retain(|code| !code.starts_with("W0243"));
    if !codes.is_empty() {
        return Err(codes);
    }
    let last = moves(&lines).last().unwrap().split_whitespace().find_map(|word| word.strip_prefix('X')).unwrap();
    Ok(last.parse().unwrap())
}

#[track_caller]
fn is(before: &str, expression: &str, expected: f64) {
    let found = value_on(&iso_machine(), before, expression).unwrap();
    assert!((found - expected).abs() < 1e-6, "{expression} is {found}, not {expected}");
}

#[test]
fn arithmetic_follows_the_rules_of_the_control() {
    is("", "2+3*4", 14.0);
    is("", "[2+3]*4", 20.0);
    is("", "10 MOD 4", 2.0);
    is("", "-7 MOD 3", -1.0);
    is("", "7/2", 3.5);
    // AND goes with the products, OR and XOR with the sums.
    is("", "6 AND 3 + 8", 10.0);
    is("", "1 OR 6 AND 2", 3.0);
    is("", "5 XOR 1", 4.0);
    is("", "FIX[2.7]+FIX[-2.7]*10", -18.0);
    is("", "FUP[2.1]+FUP[-2.1]*10", -27.0);
    is("#1=ROUND[2.5]+ROUND[-2.5]*10", "#1", -27.0);
    is("", "SQRT[16]+ABS[-3]", 7.0);
    is("", "POW[2,10]", 1024.0);
    is("", "BIN[18]", 12.0);
    is("", "BCD[12]", 18.0);
    is("", "SIN[30]*10", 5.0);
    is("", "COS[60]*10", 5.0);
    is("", "TAN[45]", 1.0);
    is("", "ACOS[0]", 90.0);
    is("", "LN[EXP[2]]", 2.0);
    is("#1=RO[3.2]", "#1", 3.0);
}

#[test]
fn angles_lie_where_the_parameter_puts_them() {
    is("", "ATAN[-1]/[1]", 315.0);
    is("", "ATAN[1]/[-1]", 135.0);
    is("", "ASIN[-0.5]", 330.0);
    let mut machine = iso_machine();
    machine.control.macros.signed_angles = true;
    assert!((value_on(&machine, "", "ATAN[-1]/[1]").unwrap() + 45.0).abs() < 1e-9);
    assert!((value_on(&machine, "", "ASIN[-0.5]").unwrap() + 30.0).abs() < 1e-9);
}

#[test]
fn null_is_equal_to_nothing_but_null_and_counts_as_zero_elsewhere() {
    let holds = |condition: &str| {
        let text = format!("G90 G0 X0 Y0 Z0\n#2=#0\nIF [{condition}] GOTO 9\nX1.\nN9 M30\n");
        let (lines, codes) = run("fanuc", &text);
        assert!(codes.is_empty(), "{condition}: {codes:?}");
        moves(&lines).len() == 1
    };
    assert!(holds("#2 EQ #0"));
    assert!(!holds("#2 EQ 0"));
    assert!(holds("#2 NE 0"));
    assert!(!holds("#2 NE #0"));
    assert!(holds("#2 GE 0"));
    assert!(holds("#2 LE 0"));
    assert!(!holds("#2 GT 0"));
    assert!(!holds("#2 LT 0"));
    is("#2=#0", "5+#2", 5.0);
    is("#2=#0", "#2*3", 0.0);
    // Arithmetic makes a number of it; an assignment alone keeps it null.
    is("#2=#0\n#3=#2\n#4=#2+0\nIF [#3 EQ #0] THEN #5=1\nIF [#4 EQ #0] THEN #5=2", "#5", 1.0);
}

#[test]
fn what_has_no_value_is_a_finding() {
    let codes = |expression: &str| value_on(&iso_machine(), "", expression).unwrap_err();
    assert_eq!(codes("1/0"), ["E0209:3"]);
    assert_eq!(codes("SQRT[-1]"), ["E0209:3"]);
    assert_eq!(codes("LN[0]"), ["E0209:3"]);
    assert_eq!(codes("ASIN[2]"), ["E0209:3"]);
    assert_eq!(codes("TAN[90]"), ["E0209:3"]);
    assert_eq!(codes("10 MOD 0"), ["E0209:3"]);
    assert_eq!(codes("BIN[10]"), ["E0209:3"]);
    assert_eq!(codes("#50"), ["E0207:3"]);
    assert_eq!(codes("#[2.5]"), ["E0207:3"]);
    assert_eq!(codes("#3012"), ["E0219:3"]);
    assert_eq!(codes("PRM[1320]"), ["E0219:3"]);
    check_codes("fanuc", "G0 X0 Y0 Z0\n#0=5\n#50=1\n#4001=1\nM30\n", &["E0101:2", "E0207:3", "E0210:4"]);
}

#[test]
fn indirect_variables() {
    is("#1=5\n#5=7", "##1", 7.0);
    is("#1=5\n#6=8", "#[#1+1]", 8.0);
    is("#1=100\n#[#1+1]=9", "#101", 9.0);
    is("#1=3 #2=#1+1", "#2", 4.0);
}

#[test]
fn values_that_only_the_machine_knows_come_from_its_file() {
    let mut machine = iso_machine();
    machine.system.insert("#500".to_owned(), Setting::Number(12.5));
    machine.system.insert("#3012".to_owned(), Setting::Whole(120_000));
    machine.system.insert("PRM[1320]".to_owned(), Setting::Whole(800));
    assert_eq!(value_on(&machine, "", "#500*2"), Ok(25.0));
    assert_eq!(value_on(&machine, "", "#3012/1000"), Ok(120.0));
    assert_eq!(value_on(&machine, "", "PRM[1320]"), Ok(800.0));
}

#[test]
fn what_an_earlier_program_left_in_a_variable_is_not_guessed_for_a_correction() {
    let strict = || Options { strict: true, ..Options::default() };
    let text = "G0 X0 Y0 Z0\nX#500\n#501=3\nX#501\nX#102\nM30\n";
    let (_, codes) = run_with("fanuc", text, &iso_machine(), Box::new(NoLibrary), strict());
    // Parameter 6001 of the control decides if #102 is null.
    assert_eq!(codes, ["E0219:2", "E0219:5"]);
    let mut machine = iso_machine();
    machine.system.insert("#500".to_owned(), Setting::Number(12.5));
    machine.system.insert("#102".to_owned(), Setting::Text("null".to_owned()));
    let (_, codes) = run_with("fanuc", text, &machine, Box::new(NoLibrary), strict());
    assert_eq!(codes, [""; 0]);
}

#[test]
fn jumps_leave_loops_but_do_not_enter_them() {
    check(
        "fanuc",
        "G90 G0 X0 Y0 Z0\n#1=0\nWHILE [#1 LT 10] DO1\n#1=#1+1\nX#1\nIF [#1 EQ 2] GOTO 50\nEND1\nN50 Y1.\nM30\n",
        &["G0 X0 Y0 Z0", "G0 X1 Y0 Z0", "G0 X2 Y0 Z0", "G0 X2 Y1 Z0"],
    );
    let text = "G90 G0 X0 Y0 Z0\nGOTO 20\nWHILE [#1 LT 2] DO1\nN20 X1.\n#1=#1+1\nEND1\nM30\n";
    let (_, codes) = run("fanuc", text);
    assert_eq!(codes, ["E0217:2"]);
}

#[test]
fn loops_without_a_condition_end_by_a_jump_or_by_the_limit() {
    check(
        "fanuc",
        "G90 G0 X0 Y0 Z0\nDO1\n#1=#1+1\nIF [#1 GT 3] GOTO 8\nEND1\nN8 X#1\nM30\n",
        &["G0 X0 Y0 Z0", "G0 X4 Y0 Z0"],
    );
    let options = Options { max_blocks: Some(1000), ..Options::default() };
    let (_, codes) = run_with("fanuc", "G0 X0 Y0 Z0\nDO1\nEND1\nM30\n", &iso_machine(), Box::new(NoLibrary), options);
    assert_eq!(codes.len(), 1);
    assert!(codes[0].starts_with("E0214"), "{codes:?}");
}

#[test]
fn the_words_of_a_macro_call_become_variables() {
    // The example of the control's manual: I-3. is #4, I4. is #7, and D, the later one of #7, counts.
    check(
        "fanuc",
        "O1\nG90 G0 X0 Y0 Z0\nG65 P1000 A1. B2. I-3. I4. D5.\nM30\nO1000\nX#1 Y#2 Z#4\nX#7\nM99\n",
        &["G0 X0 Y0 Z0", "G0 X1 Y2 Z-3", "G0 X5 Y2 Z-3"],
    );
    // Every letter its variable.
    let text = "O1\nG90 G0 X0 Y0 Z0\n\
        G65 P2 A1. B2. C3. D7. E8. F9. H11. I4. J5. K6. M13. Q17. R18. S19. T20. U21. V22. W23. X24. Y25. Z26.\nM30\n\
        O2\n#100=0\n#101=1\nWHILE [#101 LE 26] DO1\nIF [#[#101] EQ #0] GOTO 5\nIF [#[#101] NE #101] THEN #100=#100+1000\n#100=#100+1\n\
        N5 #101=#101+1\nEND1\nX#100\nM99\n";
    check("fanuc", text, &["G0 X0 Y0 Z0", "G0 X21 Y0 Z0"]);
    check_codes("fanuc", "O1\nG0 X0 Y0 Z0\nG65 P2 G1\nM30\nO2\nM99\n", &[]);
    check_codes("fanuc", "O1\nG0 X0 Y0 Z0\nG65 A1.\nM30\n", &["E0210:3"]);
    let mut machine = iso_machine();
    machine.control.macros.arguments_two = false;
    check_on(
        "fanuc",
        "O1\nG90 G0 X0 Y0 Z0\nG65 P2 I1. I2.\nM30\nO2\nX#4 Y#7\nM99\n",
        &machine,
        &["G0 X0 Y0 Z0", "G0 X2 Y0 Z0"],
    );
}

#[test]
fn the_count_of_a_call_is_in_l_or_before_the_number() {
    let pass = "O1002\nG91 X1.\nG90 M99\n";
    let last = |call: &str| {
        let (lines, codes) = run("fanuc", &format!("O1\nG90 G0 X0 Y0 Z0\n{call}\nM30\n{pass}"));
        assert!(codes.is_empty(), "{call}: {codes:?}");
        moves(&lines).last().unwrap().to_string()
    };
    assert_eq!(last("M98 P1002"), "G0 X1 Y0 Z0");
    assert_eq!(last("M98 P51002"), "G0 X5 Y0 Z0");
    assert_eq!(last("M98 P1002 L4"), "G0 X4 Y0 Z0");
    assert_eq!(last("M98 P0021002"), "G0 X2 Y0 Z0");
    // What else stands in the block is done before the call.
    assert_eq!(last("X10. M98 P1002"), "G0 X11 Y0 Z0");
    // A number of five digits that is one.
    let (lines, codes) = run("fanuc", "O1\nG90 G0 X0 Y0 Z0\nM98 P10005\nM30\nO10005\nX7.\nM99\n");
    assert_eq!((moves(&lines).last().copied(), codes.len()), (Some("G0 X7 Y0 Z0"), 0));
}

#[test]
fn programs_have_names_too_and_lie_beside_the_file() {
    check("fanuc", "O1\nG90 G0 X0 Y0 Z0\nM98 <SIDE-A>\nM30\n<SIDE-A>\nX7.\nM99\n", &["G0 X0 Y0 Z0", "G0 X7 Y0 Z0"]);
    let files = || Box::new(Files(&[("O9010.NC", "%\nO9010\nX#1\nM98 P5\nM99\n%\n"), ("5.NC", "O5\nY3.\nM99\n")]));
    let text = "O1\nG90 G0 X0 Y0 Z0\nG65 P9010 A4.\nM30\n";
    let (lines, codes) = run_with("fanuc", text, &iso_machine(), files(), Options::default());
    assert!(codes.is_empty(), "{codes:?}");
    assert_eq!(moves(&lines), ["G0 X0 Y0 Z0", "G0 X4 Y0 Z0", "G0 X4 Y3 Z0"]);
    check_codes("fanuc", "O1\nG0 X0 Y0 Z0\nM98 P77\nM30\n", &["E0212:3"]);
}

#[test]
fn codes_call_macros_where_the_machine_file_says_so() {
    let mut machine = iso_machine();
    for (code, program) in [("G100", 9010), ("M50", 9020), ("T", 9000)] {
        machine.control.macros.codes.insert(code.to_owned(), program);
    }
    let text = "O1\nG90 G0 X0 Y0 Z0\nG100 X5. A2.\nM50 A3.\nT12\nM30\n\
        O9010\nG0 X[#24+#1]\nM99\nO9020\nY#1\nM99\nO9000\nZ#149\nM99\n";
    check_on("fanuc", text, &machine, &["G0 X0 Y0 Z0", "G0 X7 Y0 Z0", "G0 X7 Y3 Z0", "G0 X7 Y3 Z12"]);
}

#[test]
fn an_alarm_ends_the_program_with_its_text() {
    let (lines, codes) = run("fanuc", "G90 G0 X0 Y0 Z0\nIF [#1 NE #0] GOTO 5\n#3000=21(NO ARGUMENT)\nN5 X9.\nM30\n");
    assert_eq!(codes, ["E0218:3"]);
    assert_eq!(moves(&lines), ["G0 X0 Y0 Z0"]);
}

#[test]
fn positions_and_modal_codes_can_be_read() {
    is("G1 X3. Y4. F120.", "#5001+#5002*10", 43.0);
    is("G1 X3. F120.", "#4109+#4001", 121.0);
    is("", "#4003+#4006", 111.0);
    is("G91\n#1=#4003\nG90", "#1", 91.0);
    // The move itself is shifted back by 10.
    is("G92 X10. Y0", "#5001*100+#5021", 990.0);
    is("G10 L2 P2 X7. Y0 Z0", "#5241", 7.0);
    is("G10 L10 P3 R55.", "#2203+#11003", 110.0);
    is("#5242=6.", "#5242", 6.0);
    // In an inch program lengths are in inches.
    is("G20\nG0 X1.\n#1=#5001\n#2=#5021\nG21", "#1*10+#2", 11.0);
}

#[test]
fn offsets_that_are_assigned_move_what_follows() {
    let text = "G90 G54 G0 X0 Y0 Z0\n#5221=10.\nX0\nG55 X0\n#5241=3.\nX1.\nM30\n";
    check("fanuc", text, &["G0 X0 Y0 Z0", "G0 X10 Y0 Z0", "G0 X0 Y0 Z0", "G0 X4 Y0 Z0"]);
    // The external offset moves all systems at once.
    let text = "G90 G54 G0 X0 Y0 Z0\n#5201=5.\nX0\nG55 X1.\nM30\n";
    check("fanuc", text, &["G0 X0 Y0 Z0", "G0 X5 Y0 Z0", "G0 X6 Y0 Z0"]);
}

#[test]
fn an_angle_needs_a_direction() {
    is("#1=ATAN[0]/[5]", "#1", 0.0);
    is("#1=ATAN[5]/[0]", "#1", 90.0);
    assert_eq!(run("fanuc", "#1=ATAN[0]/[0]\nM30").1.len(), 1);
}

#[test]
fn if_then_does_one_statement() {
    is("#1=2\nIF [#1 EQ 2] THEN #2=5\nIF [#1 EQ 3] THEN #2=6", "#2", 5.0);
    is("#1=2\nIF [[#1 GT 1] AND [#1 LT 3]] THEN #2=5", "#2", 5.0);
    is("#1=2\nIF [[#1 GT 5] OR [#1 EQ 2]] THEN #2=7", "#2", 7.0);
}

#[test]
fn arguments_without_a_point_count_increments_where_all_numbers_do() {
    let mut machine = iso_machine();
    machine.control.iso.decimal_point = Some(ncfix_machine::machine::DecimalPoint::Increment);
    // X is a length, D and S count.
    check_on(
        "fanuc",
        "O1\nG90 G0 X0 Y0 Z0\nG65 P2 X10000 D3 S4\nM30\nO2\nX#24 Y#7 Z#19\nM99\n",
        &machine,
        &["G0 X0 Y0 Z0", "G0 X10 Y3 Z4"],
    );
}

#[test]
fn very_long_and_deep_expressions_are_refused_without_harm() {
    let long = format!("G0 X[{}1]\nM30\n", "1+".repeat(200_000));
    let (_, codes) = run("fanuc", &long);
    assert!(!codes.is_empty());
    let deep = format!("G0 X{}1{}\nM30\n", "[".repeat(5000), "]".repeat(5000));
    let (_, codes) = run("fanuc", &deep);
    assert!(!codes.is_empty());
}

/// The help names the entry that the machine file needs: of a macro P9832 it is O9832. With P9832 the program is still not found.
#[test]
fn the_help_for_a_missing_program_names_its_entry() {
    let mill = crate::cli_diff::MILL.replace("\"sinumerik\"", "\"fanuc\"");
    let shop = crate::support::Shop::new()
        .file("none.toml", &mill)
        .file("p.toml", format!("{mill}[control]\nopaque = [\"P9832\"]\n"))
        .file("o.toml", format!("{mill}[control]\nopaque = [\"O9832\"]\n"))
        .file("part.nc", "O1\nG21 G17 G90 G54\nG0 X0. Y0. Z50.\nG65 P9832\nG90 G0 X0. Y0. Z60.\nM30\n");
    for machine in ["none.toml", "p.toml"] {
        let run = shop.run(["check", "part.nc", "--machine", machine]).says("error[E0212]");
        run.says("write opaque = [\"O9832\"] in [control]");
    }
    let run = shop.run(["check", "part.nc", "--machine", "o.toml"]);
    assert!(!run.stderr.contains("E0212"), "{}", run.stderr);
}

#[test]
fn programs_of_the_control_itself_are_passed_on_with_their_values() {
    let mut machine = iso_machine();
    machine.control.opaque.push(Opaque { name: "O98*".to_owned(), moves: true });
    let text = "O1\nG90 G0 X0 Y0 Z0\n#1=5\nG65 P9810 X[#1*2] Z-3. K1.5\nG0 X1. Y1. Z1.\nM30\n";
    let (elements, codes) = elements("fanuc", text, &machine, Box::new(NoLibrary), Options::default());
    assert!(codes.is_empty(), "{codes:?}");
    let passed =
        elements.iter().position(|element| element.kind == Kind::Verbatim(b"G65 P9810 X10. Z-3. K1.5".to_vec()));
    let lost = elements.iter().position(|element| matches!(element.kind, Kind::Lost(_)));
    assert!(passed.is_some() && passed < lost, "{elements:?}");
    // Not under a shift that the output does not have.
    let shifted = "O1\nG90 G0 X0 Y0 Z0\nG52 X5.\nG65 P9810 X1.\nM30\n";
    let (_, codes) = run_with("fanuc", shifted, &machine, Box::new(NoLibrary), Options::default());
    assert_eq!(codes, ["E0201:4"]);
}
