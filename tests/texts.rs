//! EXECSTRING: texts that are executed as blocks. Expected moves are worked out by hand.

use ncfix_language::exec::{NoLibrary, Options};
use ncfix_machine::machine::{Machine, Setting};

use crate::exec::{check, check_codes, run_with};
use crate::machines::xyz_machine;

#[test]
fn a_text_is_a_block_with_the_variables_of_its_program() {
    check(
        "DEF REAL DEPTH_1=3,DEPTH_2=5,FOUND
DEF INT I
G90 G1 F100
FOR I=1 TO 2
EXECSTRING(\"FOUND=2*DEPTH_\"<<I)
EXECSTRING(\"G1 X=FOUND Z=-DEPTH_\"<<I<<\" ; a comment\")
ENDFOR
DEPTH_1=7
EXECSTRING(\"R\"<<4<<\"=DEPTH_1+1\")
Y=R4
EXECSTRING(\"\")
M30",
        &["G1 X6 Y0 Z-3 F100", "G1 X10 Y0 Z-5 F100", "G1 X10 Y8 Z-5 F100"],
    );
}

#[test]
fn a_text_calls_programs_and_gets_results_back() {
    check(
        "%_N_MAIN_MPF
DEF REAL SUM=1
G90 G1 F100
EXECSTRING(\"ADD(SUM,4)\")
X=SUM
EXECSTRING(\"M30\")
X100
%_N_ADD_SPF
PROC ADD(VAR REAL TOTAL,REAL MORE)
TOTAL=TOTAL+MORE
M17
",
        &["G1 X5 Y0 Z0 F100"],
    );
}

#[test]
fn the_end_of_a_subprogram_in_a_text_is_that_of_the_subprogram() {
    check(
        "%_N_MAIN_MPF
G90 G1 F100
PART
Y5
M30
%_N_PART_SPF
X1
EXECSTRING(\"M17\")
X2
M17
",
        &["G1 X1 Y0 Z0 F100", "G1 X1 Y5 Z0 F100"],
    );
}

#[test]
fn what_is_no_block_is_refused() {
    check_codes("EXECSTRING(\"GOTOF THERE\")\nTHERE: M30", &["E0201:1"]);
    check_codes("EXECSTRING(\"DEF REAL A\")\nM30", &["E0201:1"]);
    check_codes("EXECSTRING(5)\nM30", &["E0208:1"]);
    check_codes("EXECSTRING()\nM30", &["E0221:1"]);
    check_codes("EXECSTRING(\"G1 X\")\nM30", &["E0103:1"]);
}

#[test]
fn a_text_that_executes_itself_ends() {
    check_codes("DEF STRING[50] TX\nTX=\"EXECSTRING(TX)\"\nEXECSTRING(TX)\nM30", &["E0213:1"]);
    check_codes("DEF INT I\nFOR I=1 TO 10001\nEXECSTRING(\"R1=\"<<I)\nENDFOR\nM30", &["E0201:3"]);
}

#[test]
fn a_name_that_is_defined_nowhere_is_no_wrong_argument() {
    let program =
        |argument: &str| format!("%_N_MAIN_MPF\nSUB({argument})\nM30\n%_N_SUB_SPF\nPROC SUB(VAR REAL A)\nM17\n");
    check_codes(&program("LENGTH[1]"), &["E0206:2"]);
    check_codes(&program("LENGTH"), &["E0206:2"]);
    check_codes(&program("5"), &["E0221:2"]);
    check_codes(&program("R5"), &[]);
}

#[test]
fn a_function_that_only_the_control_can_answer_has_its_value_from_the_machine() {
    let mut machine = xyz_machine();
    let text = "IF ISFILE(\"/_N_SPF_DIR/_N_WARM_SPF\")\nG0 X1\nELSE\nG0 X2\nENDIF\nM30";
    let lines = |machine: &Machine| run_with(text, machine, Box::new(NoLibrary), Options::default());
    assert_eq!(lines(&machine).1, ["E0201:1"]);
    machine.system.insert("ISFILE(/_N_SPF_DIR/_N_WARM_SPF)".to_owned(), Setting::Truth(true));
    assert_eq!(lines(&machine), (vec!["G0 X1 Y0 Z0".to_owned(), "M30".to_owned()], vec![]));
}
