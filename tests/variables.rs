//! Variables: arrays, initial lists, types and their conversions, functions of texts and axes.

use crate::exec::{check, check_codes};

/// A program that moves X to each of the expressions, and the moves.
#[track_caller]
fn values(definitions: &str, expected: &[(&str, &str)]) {
    let moves: Vec<String> = expected.iter().map(|(expression, _)| format!("G0 X={expression}")).collect();
    let lines: Vec<String> = expected.iter().map(|(_, value)| format!("G0 X{value} Y0 Z0")).collect();
    let program = format!("{definitions}\nG90\n{}", moves.join("\n"));
    check(&program, &lines.iter().map(String::as_str).collect::<Vec<_>>());
}

#[test]
fn arrays_are_filled_row_by_row() {
    values(
        "DEF REAL A[3], B[2,3]=(1,2,3,4,5,6), C[5]=REP(0.5), D[4]=SET(1,,3), E_1[2,2,2]
E_1[1,0,1]=7
A[0]=SET(10,20,30)
A[1]=REP(4,1)
C[3]=REP(8)",
        &[
            ("B[0,0]", "1"),
            ("B[0,2]", "3"),
            ("B[1,0]", "4"),
            ("B[1,2]", "6"),
            ("C[0]", "0.5"),
            ("C[4]", "8"),
            ("C[2]", "0.5"),
            ("D[0]", "1"),
            ("D[1]", "0"),
            ("D[2]", "3"),
            ("D[3]", "0"),
            ("A[0]", "10"),
            ("A[1]", "4"),
            ("A[2]", "30"),
            ("E_1[1,0,1]", "7"),
            ("E_1[1,1,0]", "0"),
        ],
    );
}

#[test]
fn an_empty_slot_of_a_list_keeps_the_old_value_and_a_whole_array_is_repeated() {
    values(
        "DEF INT A[4]=(1,2,3,4)
DEF INT B_1[2,2]
A[0]=SET(5,,7)
B_1=(1,1,1)
B_1=REP(9)
R10=SET(1,2,3)
R[11]=SET(,30)
R20=REP(6,2)
R1=1 R2=R1+1",
        &[
            ("A[0]", "5"),
            ("A[1]", "2"),
            ("A[2]", "7"),
            ("A[3]", "4"),
            ("B_1[1,1]", "9"),
            ("R10", "1"),
            ("R11", "2"),
            ("R12", "30"),
            ("R20+R21+R22", "12"),
            ("R2", "2"),
            ("A[A[1]]", "7"),
        ],
    );
}

#[test]
fn lists_indices_and_sizes_have_limits() {
    for (program, codes) in [
        ("DEF INT A[3]\nA[3]=1", ["E0207:2"]),
        ("DEF INT A[3]\nA[-1]=1", ["E0207:2"]),
        ("DEF INT A[3]\nR1=A[1,1]", ["E0207:2"]),
        ("DEF INT A[3]\nR1=A", ["E0207:2"]),
        ("DEF INT A_1[3]\nA_1=5", ["E0208:2"]),
        ("DEF INT A[2]=(1,2,3)", ["E0207:1"]),
        ("DEF INT A[2]\nA[1]=SET(1,2)", ["E0207:2"]),
        ("DEF REAL A[1000,1000]", ["E0207:1"]),
        ("DEF REAL A[0]", ["E0207:1"]),
        ("DEF REAL A[2,2,2,2]", ["E0207:1"]),
        ("DEF REAL A\nR1=A[0]", ["E0207:2"]),
        ("DEF AXIS _AX\nG0 AX[_AX]=5", ["E0309:2"]),
        ("R9999=SET(1,2)", ["E0207:1"]),
        ("DEF AXIS _AX=5", ["E0208:1"]),
        ("DEF INT A=\"5\"", ["E0208:1"]),
        ("DEF CHAR C_1=256", ["E0208:1"]),
    ] {
        check_codes(program, &codes);
    }
}

#[test]
fn modifiers_change_no_value() {
    values(
        "DEF CHAN SYNRW INIRE INT APR 7 APW 7 PHU 1 LLI -5 ULI 10 A_1=3, B_1
DEF NCK REAL C_1[2]=(4,5)",
        &[("A_1", "3"), ("B_1", "0"), ("C_1[1]", "5")],
    );
}

#[test]
fn values_are_converted_as_their_variable_asks() {
    values(
        "DEF INT I_1=2.5, I_2=-2.5, I_3=TRUE
DEF BOOL B_1=0.1, B_2=\"\", B_3=\"A\"
DEF CHAR C_1=\"A\", C_2=66
DEF STRING[3] S_1=\"ABCDE\"
DEF STRING[9] S_2=C_2, S_3=\"axis . ok\"
S_3[5]=\"X\"
S_2[1]=67",
        &[
            ("I_1", "3"),
            ("I_2", "-2"),
            ("I_3", "1"),
            ("B_1+B_2+B_3", "2"),
            ("C_1", "65"),
            ("STRLEN(S_1)", "3"),
            ("S_1==\"ABC\"", "1"),
            ("S_2==\"BC\"", "1"),
            ("S_1[1]", "66"),
            ("S_1[1]==\"B\"", "1"),
            ("S_3==\"axis X ok\"", "1"),
        ],
    );
}

#[test]
fn axes_are_values() {
    check(
        "DEF AXIS _AX=X, _FIELD[2]=(Y,Z)
G90 G0 AX[_AX]=10 AX[_FIELD[0]]=20
AX[AXNAME(\"Z\")]=5 AX[X]=IC(1)
IF _AX==X
_AX=_FIELD[1]
ENDIF
AX[_AX]=AX_Z
IF AXSTRING(_AX)<>\"Z\" GOTOF WRONG
IF ISAXIS(3) AX[AX2]=30
M30
WRONG: X99"
            .replace("IF ISAXIS(3) AX[AX2]=30", "IF NOT ISAXIS(3) GOTOF WRONG\nAX[AX2]=30")
            .replace("AX_Z", "7")
            .as_str(),
        &["G0 X10 Y20 Z0", "G0 X11 Y20 Z5", "G0 X11 Y20 Z7", "G0 X11 Y30 Z7"],
    );
}

#[test]
fn texts_are_searched_and_cut() {
    values(
        "DEF STRING[40] S_1=\"QUICK: 12.5EX1;\"
R1=12.5",
        &[
            ("STRLEN(S_1)", "15"),
            ("INDEX(S_1,\":\")", "5"),
            ("INDEX(S_1,\"?\")", "-1"),
            ("RINDEX(S_1,\"1\")", "13"),
            ("MINDEX(S_1,\"0123456789\")", "7"),
            ("MATCH(S_1,\"12\")", "7"),
            ("NUMBER(SUBSTR(S_1,7,7))", "125"),
            ("ISNUMBER(\"1E5\")", "0"),
            ("ISNUMBER(\"-1.5\")", "1"),
            ("SUBSTR(S_1,7)==\"12.5EX1;\"", "1"),
            ("TOLOWER(\"AbC\")==\"abc\"", "1"),
            ("(\"R1=\"<<R1<<\" \"<<5)==\"R1=12.5 5\"", "1"),
            ("SPRINT(\"%5.2F|%D|%3S\",R1,7,\"A\")==\"12.50|7|  A\"", "1"),
        ],
    );
    check_codes("R1=NUMBER(\"ABC\")", &["E0209:1"]);
    check_codes("R1=STRLEN(5)", &["E0208:1"]);
    check_codes("R1=STRLEN(\"A\",\"B\")", &["E0104:1"]);
}

#[test]
fn operators_have_the_values_of_the_language() {
    values(
        "",
        &[
            ("7/2", "3.5"),
            ("7 DIV 2", "3"),
            ("2+3*4", "14"),
            ("ROUND(2.5)", "3"),
            ("ROUND(-2.5)", "-2"),
            ("TRUNC(-2.7)", "-2"),
            ("ROUNDUP(2.1)", "3"),
            ("ATAN2(1,-1)", "135"),
            ("POT(3)", "9"),
            ("5 B_AND 3", "1"),
            ("5 B_OR 3", "7"),
            ("5 B_XOR 3", "6"),
            ("B_NOT 5", "-6"),
            ("'H1F'", "31"),
            ("'B101'", "5"),
            ("1.5EX2", "150"),
            ("-7 MOD 3", "-1"),
            ("(10*0.1==1)", "1"),
            ("BOUND(0,10,12)+MINVAL(1,2)+MAXVAL(1,2)", "13"),
            ("-2*-3", "6"),
        ],
    );
}

#[test]
fn a_jump_to_the_start_defines_nothing_anew() {
    let text = "DEF INT COUNT_1=1\nG0 X=COUNT_1 Y0 Z0\nCOUNT_1=COUNT_1+1\nIF COUNT_1<4 GOTOS\nM30";
    check(text, &["G0 X1 Y0 Z0", "G0 X2 Y0 Z0", "G0 X3 Y0 Z0"]);
}

#[test]
fn names_that_read_as_addresses_are_refused_where_they_are_defined() {
    for name in ["A1", "S1", "G54"] {
        check_codes(&format!("DEF INT {name}\nG0 X1"), &["E0216:1"]);
    }
    check_codes("DEF INT R_, K\nG0 X=K", &[]);
}
