//! Macros and global variables: of the program itself, of an archive, and of the definition files of a control.
use ncfix_base::source::{FileId, Source};
use ncfix_language::exec::{Execution, Library, Options};
use ncfix_language::syntax;
use ncfix_language::syntax::sinumerik::Macros;
use ncfix_machine::snc::{Kind, TextWriter};

use crate::exec::{check, run};
use crate::machines::xyz_machine;
use crate::support::{Shop, machine};

/// A control with definition files and a subprogram.
struct Control;

const MACROS: &str = "DEFINE M6 AS L6\nDEFINE UP AS G0 Z50\n";
const GLOBALS: &str = "DEF NCK REAL CLEAR_1=12.5, FIELD_1[3]=(1,2,3)\nDEF CHAN INT APR 7 APW 7 COUNT_1\nM17\n";

impl Library for Control {
    fn load(&mut self, name: &str) -> Option<(String, Vec<u8>)> {
        let text = "COUNT_1=COUNT_1+1\nUP\nM17\n";
        (name == "L6").then(|| ("L6.SPF".to_owned(), text.as_bytes().to_vec()))
    }

    fn definitions(&mut self) -> Vec<(String, Vec<u8>)> {
        [("SMAC.DEF", MACROS), ("UGUD.DEF", GLOBALS)]
            .map(|(name, text)| (name.to_owned(), text.as_bytes().to_vec()))
            .to_vec()
    }
}

#[test]
fn macros_of_one_program_of_an_archive_are_its_own() {
    let text = "%_N_UMAC_DEF\nDEFINE UP AS Z50\n%_N_MAIN_MPF\nDEFINE SIDE AS X7\nG0 UP SIDE\nL1\nM30\n%_N_L1_SPF\nUP\nSIDE\nM17";
    // SIDE is a program that is not there.
    assert_eq!(run(text).1, ["E0212:10"]);
}

#[test]
fn global_variables_of_an_archive_are_seen_by_all_programs() {
    let text = "%_N_UGUD_DEF\nDEF CHAN REAL DEEP_1=-3\nM17\n%_N_MAIN_MPF\nG0 Z=DEEP_1\nL1\nX=DEEP_1\nM30\n%_N_L1_SPF\nDEEP_1=5\nM17";
    check(text, &["G0 X0 Y0 Z-3", "G0 X5 Y0 Z-3"]);
}

#[test]
fn definition_files_of_the_control_hold_in_every_program() {
    let source = Source::new(FileId(0), "test.mpf", b"G0 X=CLEAR_1 Y=FIELD_1[2]\nM6\nX=COUNT_1 UP\n".to_vec()).unwrap();
    let mut macros = Macros::default();
    Control.definitions().iter().for_each(|(_, bytes)| macros.read(bytes));
    let (program, findings) = syntax::parse_with(&source, ncfix_dialect::sinumerik(), &macros);
    assert!(findings.is_empty(), "{findings:?}");
    let machine = xyz_machine();
    let mut out = TextWriter::new(Vec::new(), "test", machine.axis_set(), |_, tool| *tool).unwrap();
    for item in Execution::new(program, &machine, Box::new(Control), Options::default()) {
        let element = item.unwrap();
        if matches!(element.kind, Kind::Move(_)) {
            out.write(&element, &[]).unwrap();
        }
    }
    let text = String::from_utf8(out.finish().unwrap()).unwrap();
    let moves: Vec<&str> = text.lines().skip(1).map(|line| line.split(" ;").next().unwrap()).collect();
    assert_eq!(moves, ["G0 X12.5 Y3 Z0", "G0 X12.5 Y3 Z50", "G0 X1 Y3 Z50"]);
}

#[test]
fn the_command_finds_folders_and_definitions_of_the_control() {
    let shop = Shop::new()
        .file("WKS.DIR/PART.WPD/MAIN.MPF", "N10 G90 G54 G0 X0 Y0 Z50\nN20 HOLE(CLEAR_1)\nN30 UP\nN40 L7\nN50 M30\n")
        .file("SPF.DIR/HOLE.SPF", "PROC HOLE(REAL AT_1)\nG0 X=AT_1\nM17\n")
        .file("own/L7.SPF", "G0 X99\nM17\n")
        .file("DEF.DIR/UGUD.DEF", "DEF NCK REAL CLEAR_1=25\nM17\n")
        .file("DEF.DIR/UMAC.DEF", "DEFINE UP AS Z60\n");
    let text =
        std::fs::read_to_string(machine("demo")).unwrap().replace("[control]", "[control]\nsearch_path = [\"own\"]");
    let shop = shop.file("m.toml", text);
    let run = shop.run(["snc", "WKS.DIR/PART.WPD/MAIN.MPF", "--machine", "m.toml"]).exits(0);
    let moves: Vec<&str> = run.stdout.lines().filter(|line| line.starts_with("G0")).collect();
    assert_eq!(moves.len(), 4, "{}", run.stdout);
    let run = shop.run(["check", "WKS.DIR/PART.WPD/MAIN.MPF"]);
    run.exits(4).says("there is no program L7");
}
