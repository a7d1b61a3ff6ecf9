//! System variables, frames as values, tool data and global variables.

use ncfix_base::geometry::{AxisVector, FrameParts};
use ncfix_language::exec::{NoLibrary, Options};
use ncfix_machine::machine::{Machine, Setting, Tool, ToolChange};

use crate::exec::{check, check_codes, run_with};
use crate::machines::xyz_machine;
use crate::support::Shop;

/// A machine without errors, as a file.
pub(crate) const IDEAL: &str = r#"
[machine]
name = "ideal"
topology = "wFXYZSt"
[axis.X]
direction = [1, 0, 0]
travel_mm = [-1000, 1000]
[axis.Y]
direction = [0, 1, 0]
travel_mm = [-1000, 1000]
[axis.Z]
direction = [0, 0, 1]
travel_mm = [-1000, 1000]
"#;

/// Moves of a program on a machine, and its findings.
fn moves_on(machine: &Machine, text: &str) -> (Vec<String>, Vec<String>) {
    let (lines, codes) = run_with(text, machine, Box::new(NoLibrary), Options::default());
    (lines.into_iter().filter(|line| line.starts_with('G')).collect(), codes)
}

#[track_caller]
fn check_on(machine: &Machine, text: &str, expected: &[&str]) {
    let (moves, mut codes) = moves_on(machine, text);
    // Positions from values of the control are the subject of these programs.
    codes.retain(|code| !code.starts_with("W0243"));
    assert!(codes.is_empty(), "{codes:?}");
    assert_eq!(moves, expected);
}

/// Lines of the output of `ncfix fix`, without stamp and comments.
fn fixed(program: &str, machine: &str) -> Vec<String> {
    let shop = Shop::new().file("p.mpf", program).file("m.toml", machine);
    shop.run(["p.mpf", "-o", "out.mpf", "--machine", "m.toml"]).exits(0);
    let lines = shop.text("out.mpf");
    lines.lines().filter(|line| !line.starts_with(';')).map(|line| line.split(" ;").next().unwrap().into()).collect()
}

#[test]
fn a_settable_frame_is_written_and_acts_when_it_is_selected() {
    let mut machine = xyz_machine();
    machine.zero_offsets.clear();
    check_on(
        &machine,
        "N10 $P_UIFR[1]=CTRANS(X,100,Y,50):CROT(Z,90)
N20 G54 G17 G90 G0 X10 Y0 Z0
N30 TRANS X20
N40 X10 Y5
N50 G53 X0 Y0
N60 X11 Y5
N70 G500 X1 Y1
N80 TRANS
N90 X2 Y1
N100 M30",
        &["G0 X100 Y60 Z0", "G0 X95 Y80 Z0", "G0 X0 Y0 Z0", "G0 X95 Y81 Z0", "G0 X21 Y1 Z0", "G0 X2 Y1 Z0"],
    );
    // Without G54 behind it nothing changes, and $P_IFRAME acts at once.
    check_on(
        &machine,
        "G90 G0 X0 Y0 Z0
$P_UIFR[1]=CTRANS(X,100)
X1
G54 X1
$P_UIFR[1,Y,TR]=7 $P_UIFR[1,Z,FI]=0.5
X2 Y0 Z0
G54 Y0 Z0
$P_IFRAME=CTRANS(X,5)
X0
$P_PFRAME=$P_IFRAME:CROT(Z,90)
X1 Y0",
        &[
            "G0 X0 Y0 Z0",
            "G0 X1 Y0 Z0",
            "G0 X101 Y0 Z0",
            "G0 X102 Y0 Z0",
            "G0 X102 Y7 Z0.5",
            "G0 X5 Y7 Z0.5",
            // Z is not named: it stays where it is.
            "G0 X10 Y1 Z0.5",
        ],
    );
}

#[test]
fn frames_are_values_with_components() {
    check_on(
        &xyz_machine(),
        "DEF FRAME F_1=CTRANS(X,10,Y,20):CROT(Z,30):CSCALE(X,2,Y,2,Z,2):CMIRROR(Y), F_2[2]
G90 G0
X=F_1[X,TR] Y=F_1[Z,RT] Z=F_1[Y,SC]
IF F_1[Y,MI]==FALSE OR F_1[X,MI] GOTOF WRONG
F_2[1]=CTRANS(X,1)
F_2[1,Y,TR]=5
F_1=F_2[1]:CRPL(0,90):CFINE(X,0.5)
X=F_1[X,TR] Y=F_1[Y,TR] Z=F_1[Z,RT]
X=F_1[Y,FI] Y=$P_UIFR[1,X,TR]
$P_PFRAME=CTRANS(X,3)
X=$P_PFRAME[X,TR] Y=$P_ACTFRAME[X,TR]
F_1=INVFRAME(CTRANS(X,4))
$P_PFRAME=CTRANS()
X=F_1[X,TR] Y0
M30
WRONG: X99"
            .replace("F_1[Y,MI]==FALSE OR F_1[X,MI]", "(F_1[Y,MI]==FALSE) OR F_1[X,MI]")
            .replace("CTRANS()", "CTRANS(X,0)")
            .as_str(),
        &["G0 X10 Y30 Z2", "G0 X1 Y5 Z90", "G0 X0.5 Y100 Z90", "G0 X6 Y3 Z90", "G0 X-4 Y0 Z90"],
    );
}

#[test]
fn frames_that_cannot_be_are_refused() {
    for (program, codes) in [
        ("$P_UIFR[100]=CTRANS(X,1)", ["E0207:1"]),
        ("$P_UIFR=CTRANS(X,1)", ["E0207:1"]),
        ("$P_PFRAME=5", ["E0208:1"]),
        ("$P_PFRAME=CSCALE(X,0)", ["E0210:1"]),
        ("$P_PFRAME=CSCALE(X,2):CROT(Z,30)", ["E0209:1"]),
        ("$P_PFRAME=CTRANS(X)", ["E0104:1"]),
        ("$P_PFRAME=CTRANS(5,X)", ["E0208:1"]),
        ("$P_PFRAME=CTRANS(C,5)", ["E0309:1"]),
        ("$P_ACTFRAME=CTRANS(X,5)", ["E0210:1"]),
        ("$P_SETFRAME=CTRANS(X,5)", ["E0201:1"]),
        ("G70\n$P_PFRAME=CTRANS(X,5)", ["E0305:2"]),
        ("$P_PFRAME=CTRANS(X,5):3", ["E0208:1"]),
        ("R1=1+CTRANS(X,5)", ["E0208:1"]),
    ] {
        check_codes(program, &codes);
    }
    check("G700 G90\n$P_PFRAME=CTRANS(X,1)\nG0 X1 Y0 Z0\nX=$P_PFRAME[X,TR]", &["G0 X50.8 Y0 Z0", "G0 X50.8 Y0 Z0"]);
}

#[test]
fn the_output_carries_evaluated_assignments_in_their_places() {
    let lines = fixed(
        "N10 R1=50
N20 $P_UIFR[1]=CTRANS(X,2*R1,Y,R1):CROT(Z,90)
N30 G54 G17 G90 G0 X10 Y0 Z0
N40 $P_UIFR[1,X,FI]=0.25 $AC_MARKER[3]=R1+1
N50 $TC_DP3[1,1]=R1*2.5 $A_OUT[2]=TRUE
N60 X=$AC_MARKER[3] Y0 Z0
M30",
        IDEAL,
    );
    assert_eq!(
        lines,
        [
            "N20 $P_UIFR[1]=CTRANS(X,100,Y,50):CROT(Z,90)",
            "N30 G54 G17 G90 G0 X10 Y0 Z0",
            "N40 $P_UIFR[1,X,FI]=0.25 $AC_MARKER[3]=51",
            "N50 $TC_DP3[1,1]=125 $A_OUT[2]=TRUE",
            "N60 G0 X51 Y0 Z0",
            "M30",
        ]
    );
}

/// Siemens, synchronized actions: $AA_OFF shifts an axis at once, whatever the program says.
#[test]
fn a_shift_beside_the_program_is_refused() {
    for (word, codes) in [
        ("$AA_OFF[Z]=-1", &["E0201:3"][..]),
        ("$AA_OFF[X]=R1+0.5", &["E0201:3"]),
        ("$AA_TOFF[Z]=0.1", &["E0201:3"]),
        ("$AC_DRF[X]=0.2", &["E0201:3"]),
        ("$AA_OFF[Z]=0", &[]),
    ] {
        check_codes(&format!("R1=1\nG90 G0 X0 Y0 Z0\n{word}\nX1\nM30"), codes);
    }
}

/// The control has other values for the rest of the frame: those of the machine file must not replace them.
#[test]
fn only_the_assigned_component_of_a_frame_is_written() {
    let machine = format!(
        "{IDEAL}\n[zero_offset.G54]\nX_mm = 100\nY_mm = 120\nZ_mm = 80\n[zero_offset.G55]\nX_mm = 10\nfine_Y_mm = 2\nrotation_deg = [0, 0, 5]\n"
    );
    let lines = fixed(
        "N10 G17 G90 G71 G54
N20 $P_UIFR[1,X,TR]=151
N30 $P_UIFR[2,Y,FI]=0.02
N40 $P_UIFR[2,Z,RT]=30
N50 $P_UIFR[2,X,SC]=2
N60 $P_UIFR[2,Y,MI]=TRUE
N70 $P_CHBFR[1,Z,TR]=-4
N80 $P_UBFR[X,TR]=7
N90 G0 X1 Y2 Z3
M30",
        &machine,
    );
    let data: Vec<&String> = lines.iter().filter(|line| line.contains("FR[")).collect();
    assert_eq!(
        data,
        [
            "N20 $P_UIFR[1,X,TR]=151",
            "N30 $P_UIFR[2,Y,FI]=0.02",
            "N40 $P_UIFR[2,Z,RT]=30",
            "N50 $P_UIFR[2,X,SC]=2",
            "N60 $P_UIFR[2,Y,MI]=1",
            "N70 $P_CHBFR[1,Z,TR]=-4",
            "N80 $P_CHBFR[0,X,TR]=7",
        ]
    );
}

#[test]
fn what_the_execution_knows_is_read() {
    let mut machine = xyz_machine();
    machine.control.tool_change = ToolChange::T;
    machine.tools =
        vec![Tool { number: 7, name: Some("MILL".into()), edge: 1, length_mm: [100.0, 2.0, 3.0], radius_mm: 5.0 }];
    check_on(
        &machine,
        "G90 G0 X10 Y20 Z30
TRANS X5
X=$P_EP[X] Y=$AA_IM[Y] Z=$AA_IW[Z]+1
TRANS
T7 D1
G0 X=$P_TOOLNO Y=$P_TOOL Z=$P_TOOLR
X=$P_TOOLL[1] Y=$P_TOOLL[2] Z=$P_TOOLL[3]
T=\"MILL\"
X=GETT(\"MILL\",1) Y=$TC_DP6[7,1] Z=$TC_DP3[7,1]
F200
X=$P_F Y=$P_SIM Z=$MN_SCALING_SYSTEM_IS_METRIC
G19
X=100*($P_AXN1==Y)+10*($P_AXN2==Z)+($P_AXN3==X) Y0 Z0
R5=3
X=$R[5] Y=$AC_PARAM[2] Z=ISVAR(\"R5\")+ISVAR(\"$P_F\")+ISVAR(\"NO_NAME\")"
            .replace("T=\"MILL\"\n", "")
            .as_str(),
        &[
            "G0 X10 Y20 Z30",
            "G0 X10 Y20 Z31",
            "G0 X7 Y1 Z5",
            "G0 X100 Y2 Z3",
            "G0 X7 Y5 Z100",
            "G0 X200 Y0 Z1",
            "G0 X111 Y0 Z0",
            "G0 X3 Y0 Z2",
        ],
    );
}

#[test]
fn numbers_of_codes_in_their_groups_are_known() {
    let text = "G90 G0 X0 Y0 Z0
X=$P_GG[1] Y=$P_GG[6] Z=$P_GG[14]
G1 F100 G18 G64 SOFT
X=$P_GG[1] Y=$P_GG[6] Z=$P_GG[10]
X=$P_GG[21] Y=$P_GG[7] Z=$P_GG[8]
G500
X=$P_UIFRNUM+$P_GG[8]";
    let expected = ["G0 X0 Y0 Z0", "G0 X1 Y1 Z1", "G1 X2 Y2 Z2 F100", "G1 X2 Y1 Z1 F100", "G1 X1 Y1 Z1 F100"];
    check(text, &expected);
    check_codes("R1=$P_GG[64]", &["E0219:1"]);
    check(
        "G[1]=1 G[14]=1 X=$P_GG[13] Y0 Z0\nR1=3 G710 G[6]=1\nG[1]=R1-2 X=$P_GG[13]\nS500\nX=$P_S/100 Y=$P_MC",
        &["G0 X2 Y0 Z0", "G0 X4 Y0 Z0", "G0 X5 Y0 Z0"],
    );
    check_codes("G[1]=99", &["E0201:1"]);
    check("G[8]=1 G0 X1 Y0 Z0", &["G0 X1 Y0 Z0"]);
}

#[test]
fn save_brings_assigned_frames_back() {
    let program = |body: &str| {
        format!(
            "$P_PFRAME=CTRANS(X,5)\nATRANS Y1\nG90 G0 X0 Y0 Z0\nSUB_1\nX1 Y0 Z0\nM30\n%_N_SUB_1_SPF\nPROC SUB_1 SAVE\n{body}\nRET"
        )
    };
    let lines = fixed(&program("TRANS X20\nX2 Y0 Z0"), IDEAL);
    let places = ["$P_PFRAME=CTRANS(X,5)", "ATRANS Y1", "X1 Y0 Z0", "M30"];
    assert_eq!(lines[lines.len() - 4..], places, "{lines:?}");
    let shop = Shop::new().file("p.mpf", program("$P_UIFR[1]=CTRANS(X,3)\nG54 X2 Y0 Z0")).file("m.toml", IDEAL);
    let lines = shop.run(["p.mpf", "-o", "-", "--machine", "m.toml"]).exits(0).stdout;
    assert!(lines.contains("G500\nX1"), "{lines}");
}

#[test]
fn tool_data_of_the_program_are_those_of_the_tool() {
    let mut machine = xyz_machine();
    machine.control.tool_change = ToolChange::T;
    machine.tools.clear();
    // L1 = 100 + 0.5 + 10: the spindle stands above the tip by that much; the text form shows the tip.
    let (moves, codes) = moves_on(
        &machine,
        "$TC_TP2[3]=\"DRILL\"
$TC_DP1[3,2]=200 $TC_DP3[3,2]=100 $TC_DP12[3,2]=0.5 $TC_DP21[3,2]=10 $TC_DP6[3,2]=4 $TC_DP15[3,2]=-0.25
T=\"DRILL\" D2
G90 G0 X=$P_TOOLL[1] Y=$P_TOOLR Z=$AA_IM[Z]
Z0
X=$AA_IM[Z]",
    );
    assert!(codes.is_empty(), "{codes:?}");
    assert_eq!(moves[0], "G0 X110.5 Y3.75 Z0");
    assert_eq!(moves[2], "G0 X110.5 Y3.75 Z0");
}

#[test]
fn the_table_of_the_machine_file_answers_for_the_machine() {
    let mut machine = xyz_machine();
    for (key, value) in [
        ("$A_IN[3]", Setting::Truth(true)),
        ("$MA_POS[AX1]", Setting::Number(1.5)),
        ("ISFILE(\"X_SPF\")", Setting::Truth(true)),
    ] {
        machine.system.insert(key.replace('"', ""), value);
    }
    check_on(
        &machine,
        "G90 G0 X=10*$A_IN[1+2] Y=$MA_POS[AX1] Z=ISFILE(\"X_SPF\")
$A_IN[3]=FALSE
X=10*$A_IN[3]",
        &["G0 X10 Y1.5 Z1", "G0 X0 Y1.5 Z1"],
    );
    check_codes("R1=$A_IN[1]", &["E0219:1"]);
    check_codes("R1=$TC_DP6[1,1]", &["E0219:1"]);
    check_codes("$AN_CEC[0,1]=0.5", &["E0220:1"]);
    check_codes("$MA_BACKLASH[0,X]=0.5", &["E0220:1"]);
}

#[test]
fn global_variables_of_the_machine_file_are_known() {
    let mut machine = xyz_machine();
    let list = Setting::List(vec![Setting::Whole(1), Setting::Number(2.5), Setting::Whole(3)]);
    machine.gud.insert("_TM".into(), list);
    machine.gud.insert("DEPTH_1".into(), Setting::Whole(4));
    check_on(
        &machine,
        "G90 G0 X=_TM[1] Y=DEPTH_1 Z0\nDEPTH_1=9 _TM[0]=8\nX=_TM[0] Y=DEPTH_1",
        &["G0 X2.5 Y4 Z0", "G0 X8 Y9 Z0"],
    );
    // A definition gives the type, the table the value.
    check_on(
        &machine,
        "DEF NCK REAL DEPTH_1=1\nDEF CHAN INT OTHER_1=3\nG90 G0 X=DEPTH_1/8 Y=OTHER_1 Z0",
        &["G0 X0.5 Y3 Z0"],
    );
    check_codes("G0 X=DEPTH_1", &["E0206:1"]);
}

#[test]
fn zero_offsets_of_the_machine_file_turn_scale_and_mirror() {
    let mut machine = xyz_machine();
    let parts = FrameParts {
        translation: AxisVector([10.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        rotation: [0.0, 0.0, 90_f64.to_radians()],
        mirror: [true, false, false],
        ..FrameParts::default()
    };
    machine.zero_offsets.insert("G55".into(), parts);
    check_on(&machine, "G90 G55 G0 X5 Y2 Z0", &["G0 X8 Y-5 Z0"]);
    let file = format!(
        "{IDEAL}[zero_offset.G55]\nX_mm = 10\nfine_Y_mm = 0.5\nrotation_deg = [0, 0, 90]\nmirror = [\"X\"]\nscale = [2, 2, 2]\n"
    );
    let shop = Shop::new().file("m.toml", file).file("p.mpf", "G90 G55 G0 X5 Y2 Z1\nM30\n");
    let run = shop.run(["snc", "p.mpf", "--machine", "m.toml"]).exits(0);
    // X -> -X, twice as large, turned: (-10, 4) becomes (-4, -10), shifted by (10, 0.5).
    assert!(run.stdout.contains("G0 X6 Y-9.5 Z2"), "{}", run.stdout);
    let shown = shop.run(["machine", "show", "m.toml"]).exits(0).stdout;
    assert!(shown.contains("X10 Y0.5 Z0 rotated 0 0 90 deg scaled 2 2 2 mirrored X"), "{shown}");
    let bad =
        format!("{IDEAL}[zero_offset.G55]\nscale = [0, 1, 1]\n[zero_offset.G56]\nmirror = [\"A\"]\n[system]\nX = 1\n");
    let shop = Shop::new().file("m.toml", bad);
    let run = shop.run(["machine", "check", "m.toml"]).exits(4);
    assert_eq!(
        run.stderr.matches("error[E0404]").count() + run.stderr.matches("error[E0402]").count(),
        3,
        "{}",
        run.stderr
    );
}
