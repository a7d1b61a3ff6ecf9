//! `ncfix fix --subprograms`: the control moves as with the flat program, and a body that runs several times is written once.

use std::fs;

use crate::support::{Run, Shop, dialects, machine, repository};

/// Moves and words of a program without their places in the text.
fn moves_of(snc: &Run) -> Vec<&str> {
    snc.stdout.lines().map(|line| line.split(" ;@").next().unwrap_or(line)).collect()
}

/// A square at one place, four times by calls and in a loop. The moves of the second to the fourth run begin where they end.
const SQUARE: &str = "\
G0 X10. Y10.
Z2.
G1 Z-1. F200.
X40. F400.
Y30.
X10.
Y10.
G0 Z2.
";

/// A program that calls the square four times, with its files, in the language of a dialect.
fn shop_of(dialect: &str) -> (Shop, &'static str) {
    match dialect {
        "sinumerik" => {
            let main = "%_N_PLATE_MPF\n;$PATH=/_N_WKS_DIR/_N_PLATE_WPD\nN10 G17 G90 G71 G94\nN20 T5\nN30 M6\nN40 D1\nN50 G54 S3000 M3\nN60 G0 X0 Y0 Z50\nN70 L200\nN80 L200 P2\nN90 L200\nN100 G0 Z50\nN110 M30\n";
            let square = SQUARE.replace(". ", " ").replace(".\n", "\n") + "M17\n";
            (Shop::new().file("plate.mpf", main).file("L200.SPF", square), "plate.mpf")
        }
        "fanuc" => {
            let main = "%\nO1000 (PLATE)\nG21 G17 G90 G40 G49 G80\nT4 M6\nG54 G0 X0. Y0. S2500 M3\nG43 H4 Z20.\nM98 P2000\nM98 P2000 L2\nM98 P2000\nG0 Z50.\nM5\nM30\nO2000\n";
            (Shop::new().file("plate.nc", format!("{main}{SQUARE}M99\n%\n")), "plate.nc")
        }
        "rs274" => {
            let main = "G21 G90 G91.1 G17\nT6 M6 G43\nM3 S4500\nG0 X0 Y0 Z10\no100 repeat [4]\no200 call\no100 endrepeat\nG0 Z10\nM2\n";
            (Shop::new().file("plate.ngc", format!("o200 sub\n{SQUARE}o200 endsub\n{main}")), "plate.ngc")
        }
        _ => {
            let square: String = SQUARE.lines().zip(1..).map(|(line, n)| format!("N{n} {line}\n")).collect();
            let main = "%PM9011\nN9011 (PLATE)\nN1 G17 G71 G90\nN2 G55\nN3 T9 M6\nN4 G0 X0 Y0 Z80 S1400 M3\nN5 G22 N=9101\nN6 G22 N=9101\nN7 G22 N=9101\nN8 G22 N=9101\nN9 G0 Z60\nN10 M30\n%MM9101\nN9101 (SQUARE)\n";
            (Shop::new().file("plate.pm", format!("{main}{square}")), "plate.pm")
        }
    }
}

/// The call of the first subprogram, and the number of lines that begin a subprogram.
fn marks_of(dialect: &str) -> [&'static str; 2] {
    match dialect {
        "sinumerik" => ["FOLDED_1", "PROC "],
        "fanuc" => ["M98 P7001", "\nO70"],
        "rs274" => ["o<NCFIX_1> call", "> sub"],
        _ => ["G22 N=9501", "%MM95"],
    }
}

#[test]
fn four_equal_runs_become_calls_of_one_text() {
    for (dialect, machine_name) in dialects() {
        let (shop, name) = shop_of(dialect);
        let mill = machine(machine_name);
        let ending = &name[name.find('.').unwrap()..];
        let [flat, folded] = ["flat", "folded"].map(|stem| format!("{stem}{ending}"));
        shop.run([name, "-o", &flat, "--machine", &mill]).exits(0);
        let json = shop.run([name, "-o", &folded, "--machine", &mill, "--subprograms", "--json"]).exits(0).json();
        let moves = |file: &str| shop.run(["snc", file, "--machine", &mill]).exits(0);
        assert_eq!(moves_of(&moves(&folded)), moves_of(&moves(&flat)), "{dialect}");
        shop.run(["verify", name, &folded, "--machine", &mill]).exits(0);
        // The first run begins at another height, so its approach can differ from that of the others.
        let main = shop.text(&folded);
        let [call, begin] = marks_of(dialect);
        let any = if dialect == "rs274" { "> call" } else { call.trim_end_matches(char::is_numeric) };
        let calls = main.matches(any).count();
        let subprograms = json["subprograms"].as_array().unwrap().len();
        assert!(main.contains(call) && calls >= 4, "{dialect}: {main}");
        assert!((1..=2).contains(&subprograms), "{dialect}: {json}");
        let texts: String = shop
            .names()
            .iter()
            .filter(|name| name.to_lowercase().starts_with("folded"))
            .map(|name| shop.text(name))
            .collect();
        assert_eq!(texts.matches(begin).count(), subprograms, "{dialect}: {texts}");
        assert!(json["blocks_out"].as_u64().unwrap() < shop.text(&flat).lines().count() as u64, "{dialect}: {json}");
        assert!(main.to_lowercase().contains("subprogram"), "{main}");
    }
}

#[test]
fn the_samples_move_alike_with_subprograms() {
    let mut compared = 0;
    for (dialect, machine_name) in dialects() {
        let mill = machine(machine_name);
        let folder = repository(&format!("samples/programs/{dialect}"));
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            let ending = name.rsplit('.').next().unwrap();
            if !["mpf", "nc", "ngc", "pm"].contains(&ending) {
                continue;
            }
            let source = path.display().to_string();
            let shop = Shop::new();
            let [flat, folded] = ["flat", "folded"].map(|stem| format!("{stem}.{ending}"));
            if shop.run([source.as_str(), "-o", &flat, "--machine", &mill]).code != 0 {
                continue;
            }
            shop.run([source.as_str(), "-o", &folded, "--machine", &mill, "--subprograms"]).exits(0);
            let moves = |file: &str| shop.run(["snc", file, "--machine", &mill]);
            let flat_moves = moves(&flat);
            // Words that only the control executes have no moves that `snc` could print.
            if flat_moves.code == 0 {
                assert_eq!(moves_of(&moves(&folded).exits(0)), moves_of(&flat_moves), "{name}");
                compared += 1;
            }
        }
    }
    assert!(compared >= 40, "{compared}");
}

#[test]
fn other_files_stay_and_earlier_output_is_replaced() {
    let (shop, name) = shop_of("sinumerik");
    let shop = shop.file("OUT_1.SPF", "M17\n").file("out_2.mpf", "M30\n");
    let demo = machine("demo");
    let fix = || shop.run([name, "-o", "out.mpf", "--machine", &demo, "--subprograms", "--json"]).exits(0).json();
    let names = |json: &serde_json::Value| -> Vec<String> {
        json["subprograms"].as_array().unwrap().iter().map(|name| name.as_str().unwrap().to_owned()).collect()
    };
    let first = names(&fix());
    assert_eq!(first[0], "OUT_3.SPF");
    assert_eq!(shop.text("OUT_1.SPF"), "M17\n");
    assert_eq!(names(&fix()), first, "its own files are replaced");
}

#[test]
fn the_first_number_can_be_given() {
    let (shop, name) = shop_of("fanuc");
    let vmc = machine("vmc");
    // Another program has O7101.
    let shop = shop.file("other.nc", "%\nO7101\nM99\n%\n");
    shop.run([name, "-o", "out.nc", "--machine", &vmc, "--subprograms=7101"]).exits(0);
    let text = shop.text("out.nc");
    assert!(text.contains("M98 P7102") && text.contains("\nO7102 ") && !text.contains("P7101"), "{text}");
}

#[test]
fn an_output_that_cannot_be_several_files_is_refused() {
    let (shop, name) = shop_of("sinumerik");
    let demo = machine("demo");
    let before = shop.names();
    shop.run([name, "-o", "-", "--machine", &demo, "--subprograms"]).exits(2).says("--subprograms needs -o a file");
    shop.run([name, "--in-place", "--machine", &demo, "--subprograms"]).exits(2);
    // A firmware without subprograms.
    let hobby = fs::read_to_string(machine("knee_mill"))
        .unwrap()
        .replace("\"linuxcnc\"", "\"grbl\"")
        .replace("\"rs274\"", "\"grbl\"");
    let shop = shop.file("hobby.toml", hobby).file("a.nc", "G21 G90\nG0 X0 Y0 Z0\nG1 X1 F100\nM2\n");
    let run = shop.run(["a.nc", "-o", "b.nc", "--machine", "hobby.toml", "--subprograms"]).exits(2);
    run.says("this control has no subprograms");
    assert_eq!(shop.names().len(), before.len() + 2);
}
