//! Program flow: calls with arguments, modal calls, repetition of program parts, branches, returns. Expected moves are worked out by hand.

use ncfix_language::exec::{NoLibrary, Options};

use crate::exec::{Programs, check, check_codes, run_with};
use crate::machines::xyz_machine;

/// The lines of the flat stream of a program that runs without findings.
#[track_caller]
fn lines(text: &str) -> Vec<String> {
    let (lines, codes) = run_with(text, &xyz_machine(), Box::new(NoLibrary), Options::default());
    assert!(codes.is_empty(), "{codes:?}");
    lines
}

#[test]
fn program_parts_are_repeated() {
    let moves = "X10 Y0 Z0,X10 Y5 Z0,X10 Y5 Z-1,X10 Y10 Z-1,X10 Y15 Z-1,X20 Y15 Z-1,X20 Y20 Z-1,X20 Y20 Z-2,X30 Y20 Z-2,\
                 X30 Y25 Z-2,X30 Y25 Z-3,X40 Y25 Z-3,X40 Y30 Z-3,X40 Y30 Z-4,X40 Y35 Z-4,X40 Y40 Z-4,X50 Y40 Z-4,\
                 X50 Y45 Z-4,X50 Y45 Z-5,X60 Y45 Z-5,X60 Y50 Z-5,X60 Y50 Z-6";
    let expected: Vec<String> = moves.split(',').map(|place| format!("G1 {place} F100")).collect();
    let expected: Vec<&str> = expected.iter().map(String::as_str).collect();
    check(
        "N10 G17 G91 G1 F100
N20 BEGIN: X10
N30 SUB: Y5
N40 FIN: Z-1
N50 REPEATB SUB P=2
N60 REPEAT BEGIN FIN P=2
N70 REPEAT BEGIN P=1
N80 M30",
        &expected,
    );
}

#[test]
fn subprograms_have_parameters_and_save_the_modal_state() {
    let text = "%_N_MAIN_MPF
;$PATH=/_N_MPF_DIR
N10 G17 G90 G0 X0 Y0 Z5
N20 STAIR(10,2)
N30 L20 P2
N40 G1 X0 Y0
N50 M30
%_N_STAIR_SPF
;$PATH=/_N_SPF_DIR
PROC STAIR(REAL A,INT CNT) SAVE
DEF INT K
G91 G1 F300
FOR K=1 TO CNT
X=A
Y=A
ENDFOR
RET
%_N_L20_SPF
;$PATH=/_N_SPF_DIR
N10 Y=IC(7)
N20 M17
";
    assert_eq!(
        lines(text),
        [
            "G0 X0 Y0 Z5",
            "G1 X10 Y0 Z5 F300",
            "G1 X10 Y10 Z5 F300",
            "G1 X20 Y10 Z5 F300",
            "G1 X20 Y20 Z5 F300",
            "G0 X20 Y27 Z5",
            "G0 X20 Y34 Z5",
            "G1 X0 Y0 Z5 F300",
            "M30",
        ]
    );
}

#[test]
fn arguments_are_values_defaults_and_variables() {
    let sub = "\n%_N_SUB_SPF\nPROC SUB(INT AA, REAL BB=2.5, VAR REAL CC, BOOL DD, STRING[8] SS=\"ab\") DISPLOF SBLOF\n\
               G0 X=AA Y=BB Z=CC\nCC=CC+1 AA=AA+1\nIF DD GOTOF LAST\nX0\nLAST: IF SS==\"ab\" GOTOF OUT\nX99\nOUT: RET";
    let text = |main: &str| format!("%_N_MAIN_MPF\nDEF REAL OWN=7\n{main}\nM30{sub}");
    check(&text("SUB(1,,OWN,TRUE)\nG0 X=OWN"), &["G0 X1 Y2.5 Z7", "G0 X8 Y2.5 Z7"]);
    check(&text("R5=3\nSUB(1.6,4,R5,0,\"cd\")\nX=R5"), &["G0 X2 Y4 Z3", "G0 X0 Y4 Z3", "G0 X99 Y4 Z3", "G0 X4 Y4 Z3"]);
    // Each run gets its values anew and the caller's variable as the last one left it.
    check(&text("R1=4\nSUB(1,1,R[R1-3],1) P3\nX=R1"), &["G0 X1 Y1 Z4", "G0 X1 Y1 Z5", "G0 X1 Y1 Z6", "G0 X7 Y1 Z6"]);
    check_codes(&text("SUB(1,2,3,1)"), &["E0221:3"]);
    check_codes(&text("SUB(1,2,,1)"), &["E0221:3"]);
    check_codes(&text("SUB(1,2,OWN,1,\"x\",6)"), &["E0221:3"]);
    check_codes(&text("SUB(\"x\",2,OWN)"), &["E0208:3"]);
}

#[test]
fn the_caller_has_its_own_variables() {
    // AA in the caller and AA in the subprogram are two variables, though they have one name.
    let text = "DEF INT AA=1\nSUB(AA+1,AA)\nG0 X=AA\nM30\n%_N_SUB_SPF\nPROC SUB(INT BB, VAR INT AA)\nAA=AA+BB*10\nM17";
    check(text, &["G0 X21 Y0 Z0"]);
}

#[test]
fn arrays_elements_axes_and_texts_are_passed() {
    let sub = "M30\n%_N_SUB_SPF\nPROC SUB(REAL FIELD[3], VAR REAL OUT_1[,], VAR REAL ONE, AXIS WHERE_1, STRING[2] SS)\n\
               OUT_1[1,1]=FIELD[2] FIELD[0]=99\nONE=ONE+1\nIF SS<>\"ab\" GOTOF OUT\nG0 AX[WHERE_1]=FIELD[1]\nOUT: M17";
    let main = "DEF REAL AA[3]=(1,2,3), BB[2,2]=REP(7), CC[2]=(5,6)\nG0\nSUB(AA,BB,CC[1],Y,\"abc\")\nX=AA[0] Y=BB[1,1] Z=CC[1]";
    check(&format!("{main}\n{sub}"), &["G0 X0 Y2 Z0", "G0 X1 Y3 Z7"]);
    let codes = |call: &str| format!("DEF REAL AA[3], BB[2,2], CC[2]\nDEF INT II[3]\n{call}\n{sub}");
    check_codes(&codes("SUB(BB,BB,CC[1],Y,\"\")"), &["E0221:3"]);
    check_codes(&codes("SUB(II,BB,CC[1],Y,\"\")"), &["E0221:3"]);
    check_codes(&codes("SUB(AA,BB,CC[1],5,\"\")"), &["E0208:3"]);
    check_codes(&codes("SUB(AA,BB,CC[2],Y,\"\")"), &["E0207:3"]);
}

#[test]
fn modal_calls_follow_each_block_that_moves() {
    check(
        "N10 G90 G0 X0 Y0 Z10
N20 MCALL DRILL(5)
N30 X1
N40 M8
N45 C1=R1
N50 ROW
N60 MCALL
N70 X9
M30
%_N_DRILL_SPF
PROC DRILL(REAL D) SAVE
G91 G0 Z=-D
Z=D
M17
%_N_ROW_SPF
X2
N20 Y1 M17"
            .replace("N45 C1=R1\n", "")
            .as_str(),
        &[
            "G0 X0 Y0 Z10",
            "G0 X1 Y0 Z10",
            "G0 X1 Y0 Z5",
            "G0 X1 Y0 Z10",
            "G0 X2 Y0 Z10",
            "G0 X2 Y0 Z5",
            "G0 X2 Y0 Z10",
            "G0 X2 Y1 Z10",
            "G0 X2 Y1 Z5",
            "G0 X2 Y1 Z10",
            "G0 X9 Y1 Z10",
        ],
    );
}

#[test]
fn a_return_may_name_its_place_in_the_caller() {
    let text = |back: &str| {
        format!("G0 X1\nSUB\nX2\nLAB: X3\nX4\nM30\n%_N_SUB_SPF\nINNER\nX9\nM17\n%_N_INNER_SPF\nX8\n{back}")
    };
    let all = ["G0 X1 Y0 Z0", "G0 X8 Y0 Z0", "G0 X9 Y0 Z0", "G0 X2 Y0 Z0", "G0 X3 Y0 Z0", "G0 X4 Y0 Z0"];
    check(&text("RET"), &all);
    check(&text("RET(\"LAB\",,2)"), &[all[0], all[1], all[4], all[5]]);
    check(&text("RET(\"LAB\",1,2)"), &[all[0], all[1], all[5]]);
    check(&text("RET(,,2)"), &[all[0], all[1], all[3], all[4], all[5]]);
    check_codes(&text("RET(\"LAB\")"), &["E0211:13"]);
}

#[test]
fn calls_by_name_and_of_parts() {
    let subs = "M30\n%_N_SUB_SPF\nG0 X1\nAA: X2\nBB: X3\nX4\nM17";
    let text = |call: &str| format!("DEF STRING[20] NAME_1=\"SUB\", FROM_1=\"AA\"\nG0\n{call}\n{subs}");
    let all = ["G0 X1 Y0 Z0", "G0 X2 Y0 Z0", "G0 X3 Y0 Z0", "G0 X4 Y0 Z0"];
    check(&text("CALL \"SUB\""), &all);
    check(&text("CALL NAME_1"), &all);
    check(&text("CALL \"/_N_SPF_DIR/_N_SUB_SPF\""), &all);
    check(&text("PCALL /_N_SPF_DIR/SUB"), &all);
    check(&text("CALL \"SU\"<<\"B\" BLOCK AA TO BB"), &all[1..3]);
    check(&text("G0 X2\nCALL NAME_1 BLOCK FROM_1 TO BB P2\nX1"), &[all[1], all[1], all[2], all[1], all[2], all[0]]);
    check_codes(&text("CALL NAME_1 BLOCK BB TO AA"), &["E0211:3"]);
    check_codes(&text("CALL \"NOWHERE\""), &["E0212:3"]);
    // A file without header is no program without name.
    check_codes("CALL \"\"\nCALL \"_SPF\"", &["E0212:1", "E0212:2"]);
    check("G0 X1\nGOTOF END_1\nAA: X2\nBB: X3\nX9\nEND_1: CALL BLOCK AA TO BB\nX4", &[all[0], all[1], all[2], all[3]]);
}

#[test]
fn a_call_finds_programs_of_the_library_by_any_form_of_their_name() {
    let library = || Box::new(Programs(vec![("POCKET", "PROC POCKET(REAL D)\nG0 Z=D\nM17")]));
    for call in ["POCKET(3)", "PCALL /_N_WKS_DIR/_N_A_WPD/_N_POCKET_SPF(3)", "MCALL POCKET(3)\nG0 X0\nMCALL"] {
        let (lines, codes) = run_with(call, &xyz_machine(), library(), Options::default());
        assert!(codes.is_empty(), "{call}: {codes:?}");
        assert_eq!(lines.last().map(String::as_str), Some("G0 X0 Y0 Z3"), "{call}");
    }
}
