//! O-words, parameters and expressions of RS274/NGC. What LinuxCNC does was worked out from its documentation and looked at in its
//! interpreter; the numbers of the programs are our own.

use ncfix_language::exec::{Library, NoLibrary, Options};
use ncfix_machine::machine::{Machine, Setting};

use crate::iso::{iso_machine, moves, run_with};

/// Files by name.
struct Files(&'static [(&'static str, &'static str)]);

impl Library for Files {
    fn load(&mut self, _name: &str) -> Option<(String, Vec<u8>)> {
        None
    }

    fn load_file(&mut self, names: &[String]) -> Option<(String, Vec<u8>)> {
        let fits = |name: &String| self.0.iter().find(|(known, _)| known.eq_ignore_ascii_case(name));
        let (name, text) = names.iter().find_map(fits)?;
        Some(((*name).to_owned(), text.as_bytes().to_vec()))
    }
}

fn run_on(machine: &Machine, text: &str) -> (Vec<String>, Vec<String>) {
    run_with("rs274", text, machine, Box::new(NoLibrary), Options::default())
}

/// Ends of the motions of a program without findings, as `X Y Z`.
#[track_caller]
fn ends(text: &str) -> Vec<String> {
    let (lines, codes) = run_on(&iso_machine(), text);
    assert!(codes.is_empty(), "{codes:?}");
    let ends = moves(&lines).into_iter().map(|line| {
        let words = line.split_whitespace().skip(1);
        let values: Vec<&str> = words.filter(|word| word.starts_with(['X', 'Y', 'Z'])).map(|word| &word[1..]).collect();
        values.join(" ")
    });
    ends.collect()
}

#[track_caller]
fn codes(text: &str, expected: &[&str]) {
    assert_eq!(run_on(&iso_machine(), text).1, expected);
}

#[test]
fn subroutines_have_parameters_of_their_own_and_give_a_value_back() {
    let found = ends(
        "#1=1\n#<a>=5\n#<_g>=2\no<s> sub\n #<a>=7\n #<_g>=[#<_g>+#1]\n G0 X#<a> Y#<_g> Z#<_call_level>\no<s> endsub [#1*2]\n\
         o<s> call [10]\nG0 X#<a> Y#<_value> Z#<_value_returned>\nG0 X#1\nM2\n",
    );
    assert_eq!(found, ["7 12 1", "5 20 1", "1 20 1"]);
    // What is not passed is 0, not what the caller has there.
    assert_eq!(
        ends("#3=77\no100 sub\nG0 X#1 Y#2 Z#3\no100 endsub\no100 call [1] [2]\nG0 X#3\nM2\n"),
        ["1 2 0", "77 2 0"]
    );
    // Without a value behind it, endsub gives 0 and says that there is none.
    assert_eq!(
        ends(
            "o1 sub\no1 endsub\no2 sub\no2 return [4]\nG0 X9\no2 endsub\no2 call\nG0 X#<_value>\no1 call\nG0 X[#<_value>+1] Y#<_value_returned>\nM2\n"
        ),
        ["4 0 0", "1 0 0"]
    );
}

#[test]
fn a_subroutine_may_be_defined_behind_its_call_and_behind_the_end() {
    assert_eq!(ends("o300 call [4]\nG0 X1\nM2\no300 sub\n G0 Y#1\no300 endsub\n"), ["0 4 0", "1 4 0"]);
    assert_eq!(ends("#5=200\no200 sub\nG0 X#1\no200 endsub\no#5 call [3]\no[#5] call [4]\nM2\n"), ["3 0 0", "4 0 0"]);
}

#[test]
fn subroutines_in_files_of_their_own() {
    let files = || {
        Box::new(Files(&[
            ("deep.ngc", "o<deep> sub\nG0 X#1\no<deeper> call [#1+1]\no<deep> endsub\nM2\n"),
            ("deeper.ngc", "(a comment)\no<deeper> sub\nG0 Y#1\no100 if [1]\nG0 Z2\no100 endif\no<deeper> endsub\n"),
            ("123.ngc", "o123 sub\nG0 X0 Y0\no123 endsub\n"),
        ]))
    };
    let text = "o<Deep> call [7]\no123 call\no100 if [1]\nG0 Z0\no100 endif\nM2\n";
    let (lines, found) = run_with("rs274", text, &iso_machine(), files(), Options::default());
    assert!(found.is_empty(), "{found:?}");
    assert_eq!(moves(&lines), ["G0 X7 Y0 Z0", "G0 X7 Y8 Z0", "G0 X7 Y8 Z2", "G0 X0 Y0 Z2", "G0 X0 Y0 Z0"]);
    codes("o<nowhere> call\nM2\n", &["E0212:1"]);
}

#[test]
fn branches() {
    let branch = |value: u32| {
        let text = format!(
            "#31={value}\no1 if [#31 eq 1]\nG0 X1\no1 elseif [#31 eq 2]\nG0 X2\no1 elseif [#31 eq 3]\no2 if [0]\nG0 Y9\no2 else\nG0 X3\n\
             o2 endif\no1 else\nG0 X4\no1 endif\nM2\n"
        );
        ends(&text)
    };
    assert_eq!([branch(1), branch(2), branch(3), branch(4)], [["1 0 0"], ["2 0 0"], ["3 0 0"], ["4 0 0"]]);
    assert_eq!(ends("o1 if [0]\nG0 X1\no1 endif\nG0 X2\nM2\n"), ["2 0 0"]);
}

#[test]
fn loops() {
    assert_eq!(ends("#1=0\no1 while [#1 lt 3]\nG0 X#1 Y1\n#1=[#1+1]\no1 endwhile\nM2\n"), ["0 1 0", "1 1 0", "2 1 0"]);
    assert_eq!(ends("#1=5\no1 do\nG0 X#1\n#1=[#1+1]\no1 while [#1 lt 3]\nM2\n"), ["5 0 0"]);
    assert_eq!(
        ends("G91\no1 repeat [2.6]\nG0 X1\no1 endrepeat\nG90 G0 X0\nM2\n"),
        ["1 0 0", "2 0 0", "3 0 0", "0 0 0"]
    );
    assert_eq!(
        ends("G91\no1 repeat [2]\no2 repeat [2]\nG0 X1\no2 endrepeat\nG0 Y1\no1 endrepeat\nM2\n"),
        ["1 0 0", "2 0 0", "2 1 0", "3 1 0", "4 1 0", "4 2 0"]
    );
    assert_eq!(ends("o1 repeat [0]\nG0 X1\no1 endrepeat\nG0 X2\nM2\n"), ["2 0 0"]);
}

#[test]
fn break_and_continue() {
    assert_eq!(
        ends(
            "#1=0\no1 while [#1 lt 6]\n#1=[#1+1]\no2 if [#1 eq 2]\no1 continue\no2 endif\no3 if [#1 eq 5]\no1 break\no3 endif\nG0 X#1\n\
             o1 endwhile\nG0 X9\nM2\n"
        ),
        ["1 0 0", "3 0 0", "4 0 0", "9 0 0"]
    );
    assert_eq!(
        ends("#1=0\no1 do\n#1=[#1+1]\no2 if [#1 eq 2]\no1 continue\no2 endif\nG0 X#1\no1 while [#1 lt 4]\nM2\n"),
        ["1 0 0", "3 0 0", "4 0 0"]
    );
    assert_eq!(
        ends("#1=0\no1 do\n#1=[#1+1]\nG0 X#1\no2 if [#1 eq 2]\no1 break\no2 endif\no1 while [#1 lt 5]\nG0 X9\nM2\n"),
        ["1 0 0", "2 0 0", "9 0 0"]
    );
    codes("o10 repeat [2]\no10 break\no10 endrepeat\nM2\n", &["E0106:2"]);
}

/// LinuxCNC's loops share their memory; each of these was seen in its interpreter.
#[test]
fn loops_remember_what_linuxcnc_remembers() {
    let skipping = |label: u32, start: u32| {
        format!(
            "#1=0\no{label} do\n#1=[#1+1]\no{start} if [#1 eq 2]\no{label} continue\no{start} endif\nG0 X#1\no{label} while [#1 lt 3]\n"
        )
    };
    // A continue in a do loop makes the next repeat loop run twice,
    let text = format!("{}o3 repeat [2]\nG91 G0 Y1\nG90\no3 endrepeat\nM2\n", skipping(1, 2));
    assert_eq!(ends(&text), ["1 0 0", "3 0 0", "3 1 0", "3 2 0", "3 3 0", "3 4 0"]);
    // or takes a break of a while loop for a continue.
    let text = format!(
        "{}#2=0\no6 while [#2 lt 3]\n#2=[#2+1]\nG0 Z#2\no7 if [#2 eq 1]\no6 break\no7 endif\no6 endwhile\nM2\n",
        skipping(1, 2)
    );
    assert_eq!(ends(&text), ["1 0 0", "3 0 0", "3 0 1", "3 0 2", "3 0 3"]);
    // A break of a while loop ends the next do loop.
    let text = "o1 while [1]\no1 break\no1 endwhile\n#2=0\no8 do\n#2=[#2+1]\nG0 Z#2\no8 while [#2 lt 5]\nM2\n";
    assert_eq!(ends(text), ["0 0 1"]);
    // So does one that is only passed, because the while loop ends
    let text = "#1=0\no1 while [#1 lt 2]\n#1=[#1+1]\no2 if [#1 eq 9]\no1 break\no2 endif\no1 endwhile\n\
        #1=0\no3 do\n#1=[#1+1]\nG0 X#1\no3 while [#1 lt 3]\no4 do\n#1=[#1+1]\nG0 Y#1\no4 while [#1 lt 4]\nM2\n";
    assert_eq!(ends(text), ["1 0 0", "1 2 0", "1 3 0", "1 4 0"]);
    // or never begins,
    let text = "#1=0\no1 do\n#1=[#1+1]\nG0 X#1\no2 while [0]\no2 break\no2 endwhile\no1 while [#1 lt 5]\nM2\n";
    assert_eq!(ends(text), ["1 0 0"]);
    // or because a continue stands before it: of the loop itself,
    let leaving = |first: &str, second: &str| {
        format!("#1=0\no1 do\n#1=[#1+1]\nG0 X#1\n{first}{second}G0 Y#1\no1 while [#1 lt 9]\nM2\n")
    };
    let (goes_on, ends_loop) = ("o2 if [#1 eq 2]\no1 continue\no2 endif\n", "o3 if [#1 eq 4]\no1 break\no3 endif\n");
    assert_eq!(ends(&leaving(goes_on, ends_loop)), ["1 0 0", "1 1 0", "2 1 0"]);
    assert_eq!(ends(&leaving(ends_loop, goes_on)), ["1 0 0", "1 1 0", "2 1 0", "3 1 0", "3 3 0", "4 3 0"]);
    // or of a while loop that a return leaves then.
    let text = "o9 sub\n#1=0\no1 while [1]\n#1=[#1+1]\no2 if [#1 lt 3]\no1 continue\no2 endif\no9 return\no1 break\no1 endwhile\n\
        o9 endsub\no9 call\n#1=0\no3 do\n#1=[#1+1]\nG0 X#1\no3 while [#1 lt 3]\nM2\n";
    assert_eq!(ends(text), ["1 0 0"]);
    // A break of another loop within is not passed.
    let text = "o5 while [0]\no6 while [0]\no6 break\no6 endwhile\no5 endwhile\n\
        #1=0\no3 do\n#1=[#1+1]\nG0 X#1\no3 while [#1 lt 3]\nM2\n";
    assert_eq!(ends(text), ["1 0 0", "2 0 0", "3 0 0"]);
    // A repeat loop that a return leaves goes on with the passes that were left.
    let text = "o1 sub\no2 repeat [2]\nG91 G0 X1\no1 return\no2 endrepeat\no1 endsub\n\
        o1 call\nG90 G0 X10\no1 call\nG90 G0 X20\no1 call\nG90 G0 X30\no1 call\nM2\n";
    assert_eq!(ends(text), ["1 0 0", "10 0 0", "11 0 0", "20 0 0", "30 0 0", "31 0 0"]);
}

#[test]
fn a_break_that_is_left_out_is_not_passed() {
    let text = "o1 while [0]\n/o1 break\no1 endwhile\n#1=0\no3 do\n#1=[#1+1]\nG0 X#1\no3 while [#1 lt 3]\nM2\n";
    let passes = |skip_levels: [bool; 10]| {
        let options = Options { skip_levels, ..Options::default() };
        moves(&run_with("rs274", text, &iso_machine(), Box::new(NoLibrary), options).0).len()
    };
    assert_eq!([passes([false; 10]), passes([true; 10])], [1, 3]);
}

#[test]
fn numbered_programs_share_the_parameters() {
    let text = "o1 (Example)\n#1=0\nM98 P100 L5\nG0 X#1\nM98 P100 L0\nG0 Y#1\nM30\no100\n#1=[#1+1]\nM98 P200 L5\nM99\no200\n\
        #1=[#1+0.01]\nM99\n";
    assert_eq!(ends(text), ["5.25 0 0", "5.25 5.25 0"]);
}

#[test]
fn recursion_has_ten_levels() {
    let text = "o1 sub\nG0 X#1\no2 if [#1 gt 1]\no1 call [#1-1]\no2 endif\nG0 Y#1\no1 endsub\no1 call [3]\nM2\n";
    assert_eq!(ends(text), ["3 0 0", "2 0 0", "1 0 0", "1 1 0", "1 2 0", "1 3 0"]);
    codes("o9 sub\no9 call\no9 endsub\no9 call\nM2\n", &["E0213:2"]);
}

#[test]
fn values_of_a_block_are_computed_before_its_assignments() {
    assert_eq!(ends("#3=1 #4=2\n#3=4 #4=[#3+1] G0 X#4\nG0 X#4 Y#3\nM2\n"), ["2 0 0", "2 4 0"]);
    assert_eq!(ends("#3=15 #3=6\nG0 X#3\nM2\n"), ["6 0 0"]);
}

#[test]
fn expressions() {
    let value = |expression: &str| {
        let found = ends(&format!("#<a>=5 #7=3\nG0 X[{expression}] Y1\nM2\n"));
        found[0].split(' ').next().unwrap().parse::<f64>().unwrap()
    };
    for (expression, expected) in [
        ("5 MOD -3", 2.0),
        ("-5 MOD 3", 1.0),
        ("-5.5 mod 3", 0.5),
        // Powers join from the left, as all operators do, and a sign binds first.
        ("2**3**2", 64.0),
        ("-2**2", 4.0),
        ("1 - 2 - 3", -4.0),
        ("9+8*7/6+5-4*3**2+1", 9.0 + 56.0 / 6.0 + 5.0 - 36.0 + 1.0),
        ("1 AND 0 OR 1", 1.0),
        ("1 EQ 1.0000001", 1.0),
        ("1 NE 1.0000001", 0.0),
        ("1 GT 1.0000001", 0.0),
        ("1 GE 1.0000001", 0.0),
        ("1.0000001 LE 1", 0.0),
        ("1 EQ 1.00009", 1.0),
        ("1 EQ 1.00011", 0.0),
        ("1 LE 1", 1.0),
        ("1 GE 1", 1.0),
        ("fix[-2.5]", -3.0),
        ("fix[2.8]", 2.0),
        ("fup[-2.5]", -2.0),
        ("fup[2.8]", 3.0),
        ("round[-2.5]", -3.0),
        ("round[2.5]", 3.0),
        ("atan[-1]/[-1]", -135.0),
        ("atan[3]/[4]", 36.869_898),
        ("sin[30]+cos[60]+tan[45]", 2.0),
        ("asin[-0.5]", -30.0),
        ("acos[0]", 90.0),
        ("exp[ln[7]]", 7.0),
        ("sqrt[16]*abs[-2]", 8.0),
        ("1 lt 2 and 3 gt 2", 1.0),
        ("2 or 0 xor 1", 0.0),
        ("exists[#<a>]+exists[#<zz>]*10", 1.0),
        ("#[#7+4]", 3.0),
    ] {
        let found = value(expression);
        assert!((found - expected).abs() < 1e-5, "[{expression}] is {found}, not {expected}");
    }
}

#[test]
fn what_has_no_value_is_a_finding() {
    for (block, code) in [
        ("G0 X[1/0]", "E0209:1"),
        ("G0 X[5 mod 0]", "E0209:1"),
        ("G0 X[sqrt[-1]]", "E0209:1"),
        ("G0 X[ln[0]]", "E0209:1"),
        ("G0 X[acos[1.1]]", "E0209:1"),
        ("G0 X[[0-2]**0.5]", "E0209:1"),
        ("G0 X#<nix>", "E0206:1"),
        ("#<a>=#<b>", "E0206:1"),
        ("#5400=3", "E0210:1"),
        ("#<_x>=3", "E0210:1"),
        ("#[1.5]=3", "E0207:1"),
        ("G0 X#6000", "E0207:1"),
        ("#5602=1", "E0207:1"),
        ("G0 X#5399", "E0219:1"),
        ("G0 X#<_hal[motion.pin]>", "E0219:1"),
        ("G0 X#<_ini[setup]xpos>", "E0219:1"),
    ] {
        assert_eq!(run_on(&iso_machine(), &format!("{block}\nM2\n")).1, [code], "{block}");
    }
}

#[test]
fn values_of_pins_and_of_the_ini_file_come_from_the_machine_file() {
    let mut machine = iso_machine();
    machine.system.insert("#<_HAL[MOTION.PIN]>".to_owned(), Setting::Number(2.5));
    machine.system.insert("#<_INI[SETUP]XPOS>".to_owned(), Setting::Whole(7));
    machine.system.insert("#100".to_owned(), Setting::Whole(3));
    let text = "o1 if [exists[#<_ini[setup]xpos>]]\nG0 X#<_hal[motion.pin]> Y#<_ini[setup]xpos> Z#100\no1 endif\nM2\n";
    let (lines, found) = run_on(&machine, text);
    assert!(found.is_empty(), "{found:?}");
    assert_eq!(moves(&lines), ["G0 X2.5 Y7 Z3"]);
}

#[test]
fn the_state_of_the_control_has_parameters() {
    assert_eq!(ends("G0 X1 Y2\nG0 X[#5420*10] Y[#<_y>*10] Z#5220\nM2\n"), ["1 2 0", "10 20 1"]);
    assert_eq!(ends("G0 X#<_metric> Y#<_imperial> Z#<_absolute>\nM2\n"), ["1 0 1"]);
    assert_eq!(ends("G91\n#1=#<_incremental>\nG90\nG0 X#1 Y#<_coord_system> Z#<_plane>\nM2\n"), ["1 540 170"]);
    // In inches what is read is in inches.
    assert_eq!(
        ends("G20\nG0 X1\n#1=#5420 #2=#<_abs_x> #3=#<_metric>\nG21\nG0 X#1 Y#2 Z#3\nM2\n"),
        ["25.4 0 0", "1 1 0"]
    );
    assert_eq!(ends("F120 S300 M3\nG0 X#<_feed> Y#<_rpm> Z#<_spindle_on>\nM2\n"), ["120 300 1"]);
    assert_eq!(ends("G0 X#<_line>\nG0 X#<_line>\nM2\n"), ["1 0 0", "2 0 0"]);
}

#[test]
fn zero_offsets_are_parameters_too() {
    assert_eq!(ends("G10 L2 P2 X5\nG0 X#5241 Y1\n#5241=7\nG0 X#5241\nG55 G0 X0\nM2\n"), ["5 1 0", "7 1 0", "7 1 0"]);
    // An assignment takes effect when the offset is selected.
    assert_eq!(ends("G54 G0 X1 Y0\n#5221=10\nG0 X2\nG54 G0 X2\nM2\n"), ["1 0 0", "2 0 0", "12 0 0"]);
}

#[test]
fn reference_points_are_parameters() {
    assert_eq!(
        ends("#5161=33 #5162=4 #5163=5\nG28\nG0 X1 Y2\nG30.1\nG0 X[#5181*10] Y[#5182*10]\nG30\nM2\n"),
        ["33 4 5", "1 2 5", "10 20 5", "1 2 5"]
    );
}

#[test]
fn a_probe_ends_its_way_without_touching() {
    // What it found stays what it was when the zero offset changes.
    let text =
        "G0 X1 Y2 Z3\nG0 X#5070 Y#5061\nF100 G38.3 X50 Z-5\nG0 X#5070 Y#5061 Z#5063\nG10 L2 P1 X7\nG0 X#5061\nM2\n";
    assert_eq!(ends(text), ["1 2 3", "0 0 3", "50 0 -5", "0 50 -5", "57 50 -5"]);
    let options = Options { strict: true, ..Options::default() };
    let text = "G0 X1 Y2 Z3\nF100 G38.3 Z-5\nG0 Z#5063\nM2\n";
    let (_, found) = run_with("rs274", text, &iso_machine(), Box::new(NoLibrary), options);
    assert_eq!(found, ["E0219:3"]);
}

#[test]
fn endless_loops_end() {
    let options = Options { max_blocks: Some(5000), ..Options::default() };
    let text = "G0 X0\no1 while [1]\n#1=[#1+1]\no1 endwhile\nM2\n";
    let (_, found) = run_with("rs274", text, &iso_machine(), Box::new(NoLibrary), options);
    assert_eq!(found.len(), 1);
    assert!(found[0].starts_with("E0214"), "{found:?}");
}

#[test]
fn a_main_program_that_begins_anew_is_run_once() {
    assert_eq!(ends("G0 X1\nG0 X2\nM99\nG0 X3\n"), ["1 0 0", "2 0 0"]);
}

#[test]
fn exists_asks_for_numbers_too() {
    assert_eq!(ends("#1=2 #2=99999\nG0 X EXISTS[#1] Y EXISTS[##2] Z[EXISTS[##1]+2]\nM2\n"), ["1 0 3"]);
}

#[test]
fn a_state_that_m73_saved_comes_back_with_the_return() {
    let text = "o1 sub\nM73\nG90 G0 X5 Y20\no1 endsub\nG91 G0 X1 Y1\no1 call\nG0 X1 Y1\nM2\n";
    assert_eq!(ends(text), ["1 1 0", "5 20 0", "6 21 0"]);
    let without = "o1 sub\nG90 G0 X5 Y20\no1 endsub\nG91 G0 X1 Y1\no1 call\nG0 X1 Y1\nM2\n";
    assert_eq!(ends(without), ["1 1 0", "5 20 0", "1 1 0"]);
}
