//! Synchronised actions: passed on where they move nothing, refused where they may.

use crate::machines::xyz_machine;
use crate::modes::{check, codes, written};
use ncfix_machine::machine::{AllowedSynchronised, Machine};
use ncfix_model::ErrorModel;
use ncfix_path::path::CorrectionOptions;

fn codes_on(machine: &Machine, action: &str) -> Vec<String> {
    let program = format!("G90 G0 X1\n{action}\nG0 X2\nM30");
    written(&program, machine, &ErrorModel::default(), CorrectionOptions::default()).1
}

#[test]
fn actions_that_move_nothing_come_out_as_they_are() {
    check(
        "G90 G0 X1\nN20 ID=1 WHENEVER $A_IN[1]==TRUE DO M130 ; COOL\nIDS=2 EVERY ($AA_IM[Z]>R1+5) DO $A_OUT[2]=1 SPOS=90 H5\n\
         ID=3 DO $AC_MARKER[1]=$AC_MARKER[1]+1\nDO SETAL(61000)\nCANCEL(1)\nG0 X2\nM30",
        &[
            "G90 G0 X1",
            "N20 ID=1 WHENEVER $A_IN[1]==TRUE DO M130 ; COOL",
            "IDS=2 EVERY ($AA_IM[Z]>0+5) DO $A_OUT[2]=1 SPOS=90 H5",
            "ID=3 DO $AC_MARKER[1]=$AC_MARKER[1]+1",
            "DO SETAL(61000)",
            "CANCEL(1)",
            "G0 X2",
            "M30",
        ],
    );
}

#[test]
fn variables_of_the_program_are_replaced_and_those_of_the_control_stay() {
    check(
        "DEF REAL LIMIT=2.5\nDEF INT K=7\nG90\nID=1 WHENEVER $AA_IW[X]>LIMIT DO M=K $R2=LIMIT\nM30",
        &["G90", "ID=1 WHENEVER $AA_IW[X]>2.5 DO M=7 $R2=2.5", "M30"],
    );
    assert_eq!(codes("DEF INT K\nG90\nID=1 DO K=1\nM30"), ["E0201"]);
    assert_eq!(codes("DEF INT K[2]\nG90\nID=1 DO $A_OUT[1]=K[1]\nM30"), ["E0201"]);
}

#[test]
fn actions_that_may_move_an_axis_are_refused() {
    let machine = xyz_machine();
    for action in [
        "POS[X]=10",
        "MOV[Z]=1",
        "X10",
        "Y=$AA_IW[X]",
        "$AA_OFF[X]=0.1",
        "SYNFCT(1,$AA_OFF[X],$AA_IW[Y])",
        "DELDTG(X)",
        "DELDTG",
        "TECHCYCLE",
        "RETRACT(1)",
        "TRAILON(X,Y,1)",
        "$SN_CEC_TABLE_ENABLE[0]=1",
        "$TC_DP3[1,1]=5",
        "$AN_CEC[0,1]=0.1",
        "M5 POS[AX1]=1",
        "FXS[X]=1",
        "PRESETON(X,0)",
    ] {
        assert_eq!(codes_on(&machine, &format!("ID=1 WHEN $A_IN[1]==1 DO {action}")), ["E0201"], "{action}");
    }
    // V is no axis of this machine.
    assert_eq!(codes_on(&machine, "ID=1 WHEN $A_IN[1]==1 DO POS[V]=10 FA[V]=500"), [""; 0]);
    assert_eq!(codes_on(&machine, "ID=1 WHENEVER $AC_DTEW<5 DO M8"), ["E0201"]);
}

#[test]
fn the_machine_file_allows_actions_by_their_number() {
    let mut machine = xyz_machine();
    machine.control.allow_synchronised = vec![AllowedSynchronised::Id("3".into())];
    assert_eq!(codes_on(&machine, "ID=3 WHEN $A_IN[1]==1 DO POS[X]=10"), [""; 0]);
    assert_eq!(codes_on(&machine, "IDS=3 WHENEVER $AC_DTEW<5 DO M8"), [""; 0]);
    assert_eq!(codes_on(&machine, "ID=4 WHEN $A_IN[1]==1 DO POS[X]=10"), ["E0201"]);
    assert_eq!(codes_on(&machine, "DO POS[X]=10"), ["E0201"]);
    machine.control.allow_synchronised = vec![AllowedSynchronised::All];
    assert_eq!(codes_on(&machine, "ID=4 WHEN $A_IN[1]==1 DO POS[X]=10"), [""; 0]);
    assert_eq!(codes_on(&machine, "DO POS[X]=10"), [""; 0]);
}

#[test]
fn an_action_without_number_is_pointed_out() {
    let machine = xyz_machine();
    assert_eq!(codes_on(&machine, "WHEN $AA_IW[X]>10 DO M8"), ["W0206"]);
    assert_eq!(codes_on(&machine, "DO M8"), [""; 0]);
}

#[test]
fn a_parameter_that_an_action_writes_has_no_value_in_the_program() {
    assert_eq!(codes("G90\nID=1 WHEN $A_IN[1]==1 DO $R5=3\nG0 X=R5\nM30"), ["E0209"]);
    assert_eq!(codes("G90\nID=1 WHEN $A_IN[1]==1 DO $R[6]=3\nR6=1\nG0 X=R6\nM30"), [""; 0]);
}

#[test]
fn faulty_actions_are_syntax_findings() {
    for (action, code) in [
        ("ID=1 ; A", "E0101"),
        ("ID 1 DO M8", "E0103"),
        ("ID=1 WHEN $A_IN[1]==1", "E0101"),
        ("ID=1 WHEN DO M8", "E0101"),
        ("DO", "E0101"),
        ("WHEN ($A_IN[1]==1 DO M8", "E0105"),
        ("DO SETAL(1) \"A", "E0105"),
        ("DO M8)", "E0101"),
    ] {
        assert_eq!(codes(&format!("G90\n{action}\nM30")), [code], "{action}");
    }
}
