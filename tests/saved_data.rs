//! Set-up files: several of them, TOML and data as a control saves them.

use crate::support::{Run, Shop};
use crate::system::IDEAL;

/// Tools as a control saves them.
const TOOLS: &str = "%_N_TO1_TOA\r
;$PATH=/_N_TOA_DIR\r
CHANDATA(1)\r
METRIC\r
$TC_TP1[5]=1\r
$TC_TP2[5]=\"MILL_10\"\r
$TC_DP1[5,1]=120\r
$TC_DP3[5,1]=100.5\r
$TC_DP6[5,1]=5\r
$TC_DP12[5,1]=-0.5\r
$TC_DP15[5,1]=0.1\r
$TC_MPP6[1,3]=5\r
M17\r
";
/// Zero offsets, with an axis that the machine file does not have.
const OFFSETS: &str = "%_N_CHANNEL1_UFR
CHANDATA(1)
$P_CHBFR[0,X,TR]=0
$P_CHBFR[0,Z,TR]=1
$P_UIFR[1,X,TR]=100 $P_UIFR[1,X,FI]=0.25
$P_UIFR[1,SP1,TR]=0
$P_UIFR[1,Z,RT]=90
$P_UIFR[1,X,SC]=1
$P_UIFR[1,SP1,SC]=1
$P_UIFR[5]=CTRANS(X,7)
M17
";
const OTHERS: &str = "%_N_RPA_INI
R1=12.5
R[2]=3
%_N_UGUD_GUD
_TM[0]=4
_TM[2]=6.5
GRID_1[0,0]=1
GRID_1[1,2]=9
TEXT_1=\"AB\"
%_N_NC_TEA
N18074 $MN_MM_NUM_TOOL_CARRIER=2
$MA_BACKLASH[0,X1]=0.004
%_N_PART_MPF
G0 X1
";

fn snc(program: &str, setups: &[(&str, &str)]) -> Run {
    let mut shop = Shop::new().file("p.mpf", program).file("m.toml", IDEAL);
    let mut arguments: Vec<String> = ["snc", "p.mpf", "--machine", "m.toml"].map(str::to_owned).into();
    for (name, text) in setups {
        shop = shop.file(name, text);
        arguments.extend(["--setup".to_owned(), (*name).to_owned()]);
    }
    shop.run(arguments)
}

#[track_caller]
fn moves(program: &str, setups: &[(&str, &str)], expected: &[&str]) {
    let run = snc(program, setups).exits(0);
    let lines: Vec<&str> =
        run.stdout.lines().filter(|line| line.starts_with('G')).map(|line| line.split(" ;").next().unwrap()).collect();
    assert_eq!(lines, expected, "{}", run.stderr);
}

#[test]
fn tools_are_read_as_the_control_saves_them() {
    let program =
        "T=\"MILL_10\" M6\nD1\nG90 G0 X=$P_TOOLL[1] Y=$TC_DP6[5,1] Z=$P_TOOLR\nX=$TC_MPP6[1,3] Y=$TC_TP1[5] Z0\nM30";
    // $TC_DP6 is the radius without its wear of 0.1 mm, which $TC_DP15 has; $P_TOOLR is both.
    moves(program, &[("to.toa", TOOLS)], &["G0 X100 Y5 Z5.1", "G0 X5 Y1 Z0"]);
}

#[test]
fn zero_offsets_and_base_frames_are_read() {
    let program = "G90 G54 G0 X10 Y0 Z0\nG505 X1 Y0 Z0\nG500 X1 Y0 Z0\nM30";
    moves(program, &[("ufr.ini", OFFSETS)], &["G0 X100.25 Y10 Z1", "G0 X8 Y0 Z1", "G0 X1 Y0 Z1"]);
}

#[test]
fn an_axis_that_saved_data_do_not_state_is_reported() {
    let program = "G90 G54 G0 X10 Y0 Z0\nM30";
    let says = |setups: &[(&str, &str)]| {
        let run = snc(program, setups).exits(0);
        run.stderr.lines().filter(|line| line.contains("W0404")).map(str::to_owned).collect::<Vec<_>>()
    };
    let by_axis = "$P_UIFR[1,X,TR]=100\n$P_UIFR[1,SP1,TR]=0\n$P_UIFR[1,Y,TR]=5\n";
    let lacks = ["warning[W0404]: G54 gives X and Y but not Z, which counts as 0 unless a later --setup states it"];
    assert_eq!(says(&[("ufr.ini", by_axis)]), lacks);
    // A component before the shifts does not make the frame known.
    assert_eq!(says(&[("ufr.ini", &format!("$P_UIFR[1,X,FI]=0.5\n{by_axis}"))]), lacks);
    // All axes, a whole frame, or an offset that another file states.
    for whole in [format!("{by_axis}$P_UIFR[1,Z,TR]=0\n"), format!("{by_axis}$P_UIFR[1]=CTRANS(X,7)\n")] {
        assert_eq!(says(&[("ufr.ini", &whole)]), [""; 0], "{whole}");
    }
    let toml = "[zero_offset.G54]\nX_mm = 3\nY_mm = 0\nZ_mm = -9\n";
    assert_eq!(says(&[("s.toml", toml), ("ufr.ini", by_axis)]), [""; 0]);
}

#[test]
fn components_without_a_shift_do_not_make_a_zero_known() {
    let program = "G90 G54 G0 X10 Y0 Z0\nM30";
    for alone in ["[1,X,FI]=0.25", "[1,Z,RT]=90", "[1,X,SC]=2", "[1,X,MI]=1"] {
        let alone = format!("$P_UIFR{alone}\n");
        snc(program, &[("a.ini", &alone)]).exits(0).says("W0302").says("G54 has no value");
        // With the shifts of another file, in either order, it counts.
        let shifts = "$P_UIFR[1,X,TR]=100\n$P_UIFR[1,Y,TR]=0\n$P_UIFR[1,Z,TR]=0\n";
        let [one, other] = [[("a.ini", alone.as_str()), ("b.ini", shifts)], [("b.ini", shifts), ("a.ini", &alone)]]
            .map(|setups| snc(program, &setups).exits(0).stdout);
        assert!(one == other && !one.contains("G0 X110 Y0"), "{alone}: {one}{other}");
    }
    // Frames of the control that ncfix does not execute: 0 is no shift, another value moves each position.
    let toml = ("s.toml", "[zero_offset.G54]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\n");
    for name in ["$P_SETFR", "$P_EXTFR", "$P_PARTFR", "$P_TOOLFR", "$P_WPFR", "$P_CYCFR", "$P_TRAFR"] {
        snc(program, &[toml, ("a.ini", &format!("{name}[X,TR]=0\n"))]).exits(0);
        let run = snc(program, &[toml, ("a.ini", &format!("{name}[X,TR]=5\n"))]);
        assert!(run.code >= 3 && run.stderr.contains("E0201"), "{name}: {}", run.stderr);
    }
}

#[test]
fn parameters_global_variables_and_machine_data_are_read() {
    let program = "G90 G0 X=R1 Y=R2 Z=_TM[2]\nX=GRID_1[1,2] Y=GRID_1[0,0] Z=GRID_1[1,0]\nX=STRLEN(TEXT_1) Y=$MN_MM_NUM_TOOL_CARRIER Z=$MA_BACKLASH[0,X1]\nM30";
    let expected = ["G0 X12.5 Y3 Z6.5", "G0 X9 Y1 Z0", "G0 X2 Y2 Z0.004"];
    moves(program, &[("all.arc", OTHERS)], &expected);
}

#[test]
fn set_up_files_are_laid_one_over_the_other() {
    let toml = "[zero_offset.G54]\nX_mm = 3\n[system]\n\"$TC_MPP6[1,3]\" = 8\n";
    let program = "G90 G54 G0 X=$TC_MPP6[1,3] Y0 Z0\nM30";
    moves(program, &[("to.toa", TOOLS), ("ufr.ini", OFFSETS), ("s.toml", toml)], &["G0 X11 Y0 Z1"]);
    moves(program, &[("s.toml", toml), ("to.toa", TOOLS), ("ufr.ini", OFFSETS)], &["G0 X100.25 Y5 Z1"]);
}

#[test]
fn what_is_no_data_is_refused_at_its_place() {
    for (text, code) in [
        ("%_N_X_INI\nG0 X1\n", "E0101"),
        ("%_N_X_INI\nINCH\n", "E0201"),
        ("%_N_X_UFR\n$P_UIFR[1,SP1,TR]=5\n", "E0206"),
        ("%_N_X_UFR\n$P_UIFR[1,C,TR]=5\n", "E0309"),
        ("%_N_X_UFR\n$P_UIFR[100,X,TR]=5\n", "E0207"),
        ("%_N_X_GUD\nAB=5\nAB[1]=3\n", "E0207"),
        ("%_N_X_GUD\nAB[999999]=3\n", "E0207"),
        ("%_N_X_INI\nIF R1==1\nENDIF\n", "E0101"),
        ("%_N_X_INI\n$P_UIFR[1]=CTRANS(X\n", "E0105"),
    ] {
        let run = snc("G0 X1\nM30", &[("x.ini", text)]);
        assert!(run.code >= 3, "{text}: {}", run.stderr);
        assert!(run.stderr.contains(code), "{text}: {}", run.stderr);
        assert!(run.stderr.contains("x.ini:"), "{text}: {}", run.stderr);
    }
}
