//! EXECSTRING: texts that are executed as blocks. Expected moves are worked out by hand.

use ncfix_language::exec::{NoLibrary, Options};
use ncfix_machine::machine::{Machine, Setting};

use crate::exec::{check_codes, run_with};
use crate::machines::xyz_machine;

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
