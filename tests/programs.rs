//! Every sample program runs to its end on its machine: its flat stream and its corrected text are snapshots, its error is small.

use std::collections::BTreeSet;
use std::fs;

use crate::support::{Shop, machine, repository};

/// Where the Sinumerik samples are.
const FOLDER: &str = "samples/programs/sinumerik";

/// Programs whose corrected text is a snapshot: lines, arcs, helices, five axes, an archive with foreign bytes.
const SHOWN: &[&str] =
    &["seal_groove.mpf", "helix_bore.mpf", "inch_plate.mpf", "five_axis_index.mpf", "flange.arc", "cover.mpf"];

/// The rows of the table in the README: program and machine.
fn table() -> Vec<(String, String)> {
    let text = fs::read_to_string(repository(FOLDER).join("README.md")).unwrap();
    let rows = text.lines().filter(|line| line.starts_with("| `"));
    rows.map(|row| {
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        (cells[0].split('`').nth(1).unwrap().to_owned(), cells[2].to_owned())
    })
    .collect()
}

/// A shop with all samples, so that subprograms are found.
fn shop() -> Shop {
    let mut shop = Shop::new();
    for entry in fs::read_dir(repository(FOLDER)).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            shop = shop.copy(path.to_str().unwrap());
        }
    }
    shop
}

/// Settings of the snapshots in a folder of their own, one file per program.
fn settings() -> insta::Settings {
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_snapshot_path("snapshots/programs");
    settings.set_omit_expression(true);
    settings
}

#[test]
fn every_program_is_in_the_table() {
    let listed: BTreeSet<String> = table().into_iter().map(|(program, _)| program).collect();
    let is_main = |name: &String| name.ends_with(".mpf") || name.ends_with(".arc");
    let present: BTreeSet<String> = shop().names().into_iter().filter(is_main).collect();
    assert_eq!(listed, present);
    assert!(listed.len() >= 8);
}

#[test]
fn the_flat_stream_of_every_program_is_as_before() {
    let shop = shop();
    for (program, name) in table() {
        let run = shop.run(["snc", &program, "--machine", &machine(&name)]).exits(0);
        settings().bind(|| insta::assert_snapshot!(format!("{program}.snc"), run.stdout));
    }
}

#[test]
fn every_program_is_corrected_to_below_a_micrometer() {
    let shop = shop();
    for (program, name) in table() {
        let run = shop.run([&program, "-o", "out", "--json", "--machine", &machine(&name)]).exits(0);
        let json = run.json();
        let number = |side: &str, key: &str| json[side][key].as_f64().unwrap();
        assert!(number("before", "mean_um") > 10.0, "{program}: {json}");
        assert!(number("after", "mean_um") < 0.5, "{program}: {json}");
        // The tolerance of a piece, and the rounding of three axes to 0.1 µm.
        assert!(number("after", "max_um") < 1.0 + 0.1, "{program}: {json}");
        assert_eq!(json["diagnostics"], serde_json::json!([]), "{program}");
        // The written text, executed again, keeps what was predicted while it was made.
        let verified = shop.run(["verify", &program, "out", "--json", "--machine", &machine(&name)]).exits(0).json();
        for key in ["mean_um", "rms_um", "max_um"] {
            let of_text = verified["after"][key].as_f64().unwrap();
            assert!((of_text - number("after", key)).abs() < 0.1, "{program} {key}: {of_text}, {json}");
        }
    }
}

#[test]
fn the_corrected_text_is_as_before() {
    let shop = shop();
    for (program, name) in table().into_iter().filter(|(program, _)| SHOWN.contains(&program.as_str())) {
        shop.run([&program, "-o", "out", "--machine", &machine(&name)]).exits(0);
        let text = String::from_utf8_lossy(&shop.bytes("out")).replace('\r', "");
        // The stamp holds hashes of files that change for other reasons.
        let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with("; ncfix ")).collect();
        assert_eq!(lines.len() + 1, text.lines().count(), "{program} has one stamp");
        settings().bind(|| insta::assert_snapshot!(program, lines.join("\n")));
    }
}

#[test]
fn a_machine_without_errors_changes_no_motion() {
    let file = fs::read_to_string(machine("demo")).unwrap();
    let tables: Vec<&str> = file.split("\n[").collect();
    let is_error = |table: &&&str| table.starts_with("location]") || table.starts_with("[motion]]");
    let perfect = tables.iter().filter(|table| !is_error(table)).copied().collect::<Vec<_>>().join("\n[");
    let shop = shop().file("perfect.toml", perfect);
    for (program, _) in table().into_iter().filter(|(_, name)| name == "demo") {
        shop.run([&program, "-o", "out.mpf", "--machine", "perfect.toml"]).exits(0);
        let motion = |name: &str| -> Vec<String> {
            let run = shop.run(["snc", name, "--machine", "perfect.toml"]).exits(0);
            let lines = run.stdout.lines().filter(|line| line.starts_with("G0") || line.starts_with("G1"));
            lines.map(|line| line.split(" F").next().unwrap().split(" ;").next().unwrap().to_owned()).collect()
        };
        let (original, corrected) = (motion(&program), motion("out.mpf"));
        assert_eq!(original.len(), corrected.len(), "{program}");
        for (one, other) in original.iter().zip(&corrected) {
            assert!(is_near(one, other), "{program}: {one} became {other}");
        }
    }
}

/// Whether two lines of the flat stream have the same words, numbers equal within the increment of the output.
fn is_near(one: &str, other: &str) -> bool {
    let (one, other): (Vec<&str>, Vec<&str>) = (one.split(' ').collect(), other.split(' ').collect());
    one.len() == other.len()
        && one.iter().zip(&other).all(|(one, other)| {
            let number = |word: &str| word[1..].parse::<f64>().unwrap();
            one[..1] == other[..1] && (number(one) - number(other)).abs() < 0.000_051
        })
}
