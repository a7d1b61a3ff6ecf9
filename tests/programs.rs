//! Every sample program runs to its end on its machine: its flat stream and its corrected text are snapshots, its error is small.

use std::collections::BTreeSet;
use std::fs;

use crate::support::{Shop, dialects, machine, repository};

/// Programs whose corrected text is a snapshot: lines, arcs, helices, five axes, an archive with foreign bytes.
const SHOWN: &[&str] =
    &["seal_groove.mpf", "helix_bore.mpf", "inch_plate.mpf", "five_axis_index.mpf", "flange.arc", "cover.mpf"];

/// A sample.
struct Sample {
    dialect: &'static str,
    /// Its file.
    program: String,
    /// The machine that it is for.
    machine: String,
}

/// The rows of the tables in the READMEs: the files of a program, the program first, and its machine.
fn rows(dialect: &str) -> Vec<(Vec<String>, String)> {
    let text = fs::read_to_string(repository(&format!("samples/programs/{dialect}/README.md"))).unwrap();
    let rows = text.lines().filter(|line| line.starts_with("| `"));
    rows.map(|row| {
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        (cells[0].split('`').skip(1).step_by(2).map(str::to_owned).collect(), cells[2].to_owned())
    })
    .collect()
}

/// All samples.
fn table() -> Vec<Sample> {
    let of = |(dialect, _): (&'static str, _)| {
        let sample =
            move |(files, machine): (Vec<String>, String)| Sample { dialect, program: files[0].clone(), machine };
        rows(dialect).into_iter().map(sample)
    };
    dialects().into_iter().flat_map(of).collect()
}

/// A shop with all samples of a dialect, so that subprograms are found.
fn shop(dialect: &str) -> Shop {
    let mut shop = Shop::new();
    for entry in fs::read_dir(repository(&format!("samples/programs/{dialect}"))).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            shop = shop.copy(path.to_str().unwrap());
        }
    }
    shop
}

/// The smallest increment of a machine's program words, µm.
fn increment_um(name: &str) -> f64 {
    let text = fs::read_to_string(machine(name)).unwrap();
    let line = text.lines().find_map(|line| line.strip_prefix("increment_mm = ")).unwrap_or("0.0001");
    line.split_whitespace().next().unwrap().parse::<f64>().unwrap() * 1000.0
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
    for (dialect, _) in dialects() {
        let listed: BTreeSet<String> = rows(dialect).into_iter().flat_map(|(files, _)| files).collect();
        let mut present: BTreeSet<String> = shop(dialect).names().into_iter().collect();
        present.remove("README.md");
        assert_eq!(listed, present);
        assert!(rows(dialect).len() >= 8, "{dialect} has few samples");
    }
}

#[test]
fn the_flat_stream_of_every_program_is_as_before() {
    for Sample { dialect, program, machine: name } in table() {
        let run = shop(dialect).run(["snc", &program, "--machine", &machine(&name)]).exits(0);
        settings().bind(|| insta::assert_snapshot!(format!("{program}.snc"), run.stdout));
    }
}

#[test]
fn every_program_is_corrected_to_below_a_micrometer() {
    for Sample { dialect, program, machine: name } in table() {
        let shop = shop(dialect);
        let run = shop.run([&program, "-o", "out", "--json", "--machine", &machine(&name)]).exits(0);
        let json = run.json();
        let number = |side: &str, key: &str| json[side][key].as_f64().unwrap();
        // Over the way, however it is divided.
        assert!(number("before", "mean_um") > 9.0, "{program}: {json}");
        // The error is at least ten times what is left of it.
        assert!(number("before", "mean_um") > 10.0 * number("after", "mean_um"), "{program}: {json}");
        // Three axes are off by up to half an increment each, a quarter in the mean.
        let increment = increment_um(&name);
        let tolerance_um = if json["drilling_cycles"].as_u64().is_some_and(|count| count > 0) { 2.0 } else { 1.0 };
        assert!(number("after", "mean_um") < 0.5 * (tolerance_um + increment), "{program}: {json}");
        // The tolerance of a piece, or of a hole that stays a cycle, and the rounding.
        assert!(number("after", "max_um") < tolerance_um + increment, "{program}: {json}");
        // Nothing is found but, where there is radius compensation, that it is worked out, and where there are milling cycles, that their strokes are own.
        let source = fs::read(repository(&format!("samples/programs/{dialect}/{program}"))).unwrap();
        let compensates = source.windows(3).any(|word| word == b"G41" || word == b"G42");
        let calls: &[&str] = match dialect {
            "sinumerik" => &[
                "CYCLE71(",
                "CYCLE72(",
                "CYCLE76(",
                "CYCLE77(",
                "LONGHOLE(",
                "POCKET3(",
                "POCKET4(",
                "SLOT1(",
                "SLOT2(",
            ],
            "grundig" => &[" G87 ", " G88 ", " G89 "],
            _ => &[],
        };
        let text = String::from_utf8_lossy(&source);
        let mills = calls.iter().any(|call| text.contains(call));
        // A zero offset that is read, beside steps of its own value.
        let reads = text.contains("_HOME=$P_UIFR[1]");
        let expected: Vec<&str> = [(compensates, "W0236"), (mills, "W0239"), (reads, "W0243")]
            .into_iter()
            .filter_map(|(is, code)| is.then_some(code))
            .collect();
        // The machines of some have no errors of an axis that they move (W0316), or rotary axes that a program for three axes does not name (W0324);
        // tests/coverage.rs looks at both.
        let of_coverage = ["W0316", "W0324"];
        let codes: Vec<String> = run.codes().into_iter().filter(|code| !of_coverage.contains(&code.as_str())).collect();
        assert_eq!(codes, expected, "{program}");
        // The written text, executed again, keeps what was predicted while it was made.
        let language = ["--dialect", dialect];
        let arguments = ["verify", &program, "out", "--json", "--machine", &machine(&name)];
        let verified = shop.run(arguments.into_iter().chain(language)).exits(0).json();
        for key in ["mean_um", "rms_um", "max_um"] {
            let of_text = verified["after"][key].as_f64().unwrap();
            // Arcs whose centers end at the increment are a little different ones when they are read again.
            assert!(
                (of_text - number("after", key)).abs() < 0.1 + 0.1 * increment,
                "{program} {key}: {of_text}, {json}"
            );
        }
    }
}

#[test]
fn the_corrected_text_is_as_before() {
    for Sample { dialect, program, machine: name } in table() {
        if !SHOWN.contains(&program.as_str()) {
            continue;
        }
        let shop = shop(dialect);
        shop.run([&program, "-o", "out", "--machine", &machine(&name)]).exits(0);
        let text = String::from_utf8_lossy(&shop.bytes("out")).replace('\r', "");
        // The stamp holds hashes of files that change for other reasons.
        let is_stamp = |line: &&str| line.trim_start_matches(['(', ';', ' ']).to_lowercase().starts_with("ncfix ");
        let lines: Vec<&str> = text.lines().filter(|line| !is_stamp(line)).collect();
        assert_eq!(lines.len() + 1, text.lines().count(), "{program} has one stamp");
        settings().bind(|| insta::assert_snapshot!(program, lines.join("\n")));
    }
}

/// A machine file without its errors.
fn perfect(name: &str) -> String {
    let file = fs::read_to_string(machine(name)).unwrap();
    let tables: Vec<&str> = file.split("\n[").collect();
    let is_error = |table: &&&str| table.starts_with("location]") || table.starts_with("[motion]]");
    tables.iter().filter(|table| !is_error(table)).copied().collect::<Vec<_>>().join("\n[")
}

#[test]
fn a_machine_without_errors_changes_no_motion() {
    // Five axes under a transformation are cut into other pieces. Splines become arcs, which tests/executed_curves.rs judges.
    let has_other_pieces = |sample: &Sample| sample.machine.starts_with("esm") || sample.program.starts_with("spline.");
    for Sample { dialect, program, machine: name } in table().into_iter().filter(|sample| !has_other_pieces(sample)) {
        let shop = shop(dialect).file("perfect.toml", perfect(&name));
        shop.run([&program, "-o", "out", "--machine", "perfect.toml"]).exits(0);
        let motion = |name: &str| -> Vec<String> {
            let run = shop.run(["snc", name, "--machine", "perfect.toml", "--dialect", dialect]).exits(0);
            let lines = run.stdout.lines().filter(|line| line.starts_with("G0") || line.starts_with("G1"));
            lines.map(|line| line.split(" F").next().unwrap().split(" ;").next().unwrap().to_owned()).collect()
        };
        let (original, corrected) = (motion(&program), motion("out"));
        assert_eq!(original.len(), corrected.len(), "{program}");
        let within = increment_um(&name) / 1000.0 * 0.501 + 1e-6;
        for (one, other) in original.iter().zip(&corrected) {
            assert!(is_near(one, other, within), "{program}: {one} became {other}");
        }
    }
}

/// Whether two lines of the flat stream have the same words, numbers equal within the increment of the output.
fn is_near(one: &str, other: &str, within: f64) -> bool {
    let (one, other): (Vec<&str>, Vec<&str>) = (one.split(' ').collect(), other.split(' ').collect());
    one.len() == other.len()
        && one.iter().zip(&other).all(|(one, other)| {
            let number = |word: &str| word[1..].parse::<f64>().unwrap();
            one[..1] == other[..1] && (number(one) - number(other)).abs() < within
        })
}
