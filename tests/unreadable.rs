//! What makes a person read something else than what runs: carriage returns within lines, characters that do not show. Diagnosed, and never raw on a terminal.

use std::fs;

use crate::support::{Shop, machine, repository};

/// Dialect, machine, and a program with `COMMENT` in a comment.
const LANGUAGES: &[(&str, &str, &str)] = &[
    ("sinumerik", "demo", "N10 G17 G90 G71 G94\nN20 G54 G0 X0 Y0 Z50\nN30 G1 X10 F500 ; COMMENT\nN40 M30\n"),
    ("fanuc", "vmc", "%\nO1234\nN10 G21 G17 G90 G54\nN20 G0 X0. Y0. Z50.\nN30 G1 X10. F500. (COMMENT)\nN40 M30\n%\n"),
    ("rs274", "knee_mill", "G21 G17 G90 G54\nG0 X0 Y0 Z50\nG1 X10 F500 ; COMMENT\nM2\n"),
    ("grundig", "universal_mill", "%PM9001\nN9001\nN10 G54\nN20 G0 X0 Y0 Z50\nN30 G1 X10 F500 (COMMENT)\nN40 M30\n"),
];

/// Characters that a terminal would obey, or that turn the direction of text.
const HIDDEN: &[char] = &[
    '\u{7}', '\u{8}', '\u{1b}', '\u{7f}', '\u{80}', '\u{85}', '\u{9b}', '\u{9f}', '\u{200f}', '\u{202a}', '\u{202e}',
    '\u{2066}', '\u{2069}',
];

fn assert_shows(text: &str, what: &str) {
    let raw = text.chars().find(|c| HIDDEN.contains(c) || c.is_control() && !"\n\t".contains(*c));
    assert_eq!(raw, None, "{what}: {text:?}");
}

#[test]
fn a_block_behind_a_carriage_return_is_refused_in_every_language() {
    for (dialect, on, program) in LANGUAGES {
        let on = machine(on);
        for (comment, is_hidden) in
            [("COVER", false), ("COVER\rG0 Z-50", true), ("COVER\r", *dialect == "fanuc" || *dialect == "grundig")]
        {
            for end in ["\n", "\r\n"] {
                let text = program.replace("COMMENT", comment).replace('\n', end);
                let shop = Shop::new().file("part", text);
                let run = shop.run(["check", "part", "--dialect", dialect, "--machine", on.as_str()]);
                assert_eq!(
                    run.stderr.contains("error[E0315]"),
                    is_hidden,
                    "{dialect} {comment:?} {end:?}: {}",
                    run.stderr
                );
                assert_shows(&run.stderr, dialect);
                if is_hidden {
                    assert_eq!(run.code, 4, "{dialect} {comment:?}: {}", run.stderr);
                    shop.run(["part", "-o", "out", "--dialect", dialect, "--machine", on.as_str()]).exits(4);
                    assert_eq!(shop.names(), ["part"]);
                }
            }
        }
    }
}

#[test]
fn carriage_returns_alone_are_ends_of_lines() {
    for (dialect, on, program) in LANGUAGES {
        let shop = Shop::new().file("part", program.replace('\n', "\r"));
        shop.run(["check", "part", "--dialect", dialect, "--machine", machine(on).as_str()]).exits(0);
    }
}

#[test]
fn characters_that_do_not_show_are_refused() {
    for (dialect, on, program) in LANGUAGES {
        for hidden in HIDDEN {
            let shop = Shop::new().file("part", program.replace("COMMENT", &format!("CO{hidden}VER")));
            let on = machine(on);
            let run = shop
                .run(["check", "part", "--dialect", dialect, "--machine", on.as_str()])
                .exits(4)
                .says("error[E0316]")
                .says(&format!("U+{:04X}", u32::from(*hidden)));
            assert_shows(&run.stderr, dialect);
            let run = shop.run(["check", "part", "--dialect", dialect, "--machine", on.as_str(), "--json"]).exits(4);
            assert_shows(&run.stdout, dialect);
            let value: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
            assert_eq!(value["diagnostics"][0]["code"], "E0316");
        }
    }
}

#[test]
fn other_letters_are_no_matter() {
    let (dialect, on, program) = LANGUAGES[0];
    for comment in [
        &b"ABDECKUNG \xfc\xdf"[..],
        "ABDECKUNG üß – 加工".as_bytes(),
        b"\xbc\xd3\xb9\xa4\xc2\x80",
        b"TAB\tTAB",
        b"\x00\x00",
    ] {
        let (before, behind) = program.split_once("COMMENT").unwrap();
        let shop = Shop::new().file("part", [before.as_bytes(), comment, behind.as_bytes()].concat());
        shop.run(["check", "part", "--dialect", dialect, "--machine", machine(on).as_str()]).exits(0);
    }
}

#[test]
fn snc_shows_names_of_tools() {
    // A byte of Latin-1 is no UTF-8: it comes as \xf6, and is read again as that.
    let shop = Shop::new().file("part.mpf", b"N10 G90 G54 T=\"FR\xf6SER 10\"\nN20 G0 X1 Y2 Z3\nN30 M30\n");
    let demo = machine("demo");
    let run = shop.run(["snc", "part.mpf", "--machine", demo.as_str()]);
    assert!(run.stdout.contains("T=\"FR\\xf6SER 10\""), "{}{}", run.stdout, run.stderr);
    assert_shows(&run.stdout, "snc");
    fs::write(shop.path("part.snc"), &run.stdout).unwrap();
    let again = shop.run(["snc", "part.snc", "--machine", demo.as_str()]).exits(0);
    assert_eq!(again.stdout, run.stdout);
}

#[test]
fn names_of_files_are_shown_without_their_controls() {
    let name = "a\u{1b}[2J\u{202e}b.mpf";
    let shop = Shop::new().file(name, LANGUAGES[0].2.replace("X10", "Q")).file("good.mpf", LANGUAGES[0].2);
    let demo = machine("demo");
    for arguments in [
        &["check", name][..],
        &["check", name, "--json"],
        &["check", "missing\u{1b}[2J.mpf"],
        &["snc", name],
        &["diff", name, "good.mpf"],
        &["verify", "good.mpf", name],
        &["good.mpf", "-o", "out\u{1b}[31m\u{9b}2J.mpf"],
        &["good.mpf", "-o", "out\u{1b}[31m\u{9b}2J.mpf", "--json"],
        &["good.mpf", "-o", "out2\u{8}.mpf", "-v"],
        &["explain", "E\u{1b}[2J"],
    ] {
        let with_machine = if arguments[0] == "explain" { &[][..] } else { &["--machine", demo.as_str()] };
        let run = shop.run(arguments.iter().chain(with_machine).copied());
        assert_shows(&run.stdout, &format!("{arguments:?}"));
        assert_shows(&run.stderr, &format!("{arguments:?}"));
        if arguments.contains(&"--json") {
            let parsed: Result<serde_json::Value, _> = serde_json::from_str(&run.stdout);
            assert!(parsed.is_ok(), "{}", run.stdout);
        }
    }
}

#[test]
fn names_in_a_machine_file_are_refused_at_their_place() {
    let demo = fs::read_to_string(machine("demo")).unwrap();
    for (from, to) in [
        ("name = \"demo\"", "name = \"de\\u001bmo\""),
        ("name = \"demo\"", "name = \"de\\u202Emo\""),
        ("name = \"demo\"", "name = \"de\\u009bmo\""),
        ("name = \"demo\"", "name = \"de\\bmo\""),
        ("controller = \"sinumerik\"", "controller = \"sinu\\u007fmerik\""),
    ] {
        assert!(demo.contains(from));
        let shop = Shop::new().file("m.toml", demo.replacen(from, to, 1)).file("p.mpf", LANGUAGES[0].2);
        let run = shop.run(["check", "p.mpf", "--machine", "m.toml"]).exits(4).says("error[E0409]").says("m.toml:");
        assert_shows(&run.stderr, to);
    }
    // A carriage return in a comment is no TOML.
    let shop = Shop::new()
        .file("m.toml", demo.replacen("# A made-up", "# A\rname = 1 made-up", 1))
        .file("p.mpf", LANGUAGES[0].2);
    shop.run(["check", "p.mpf", "--machine", "m.toml"]).exits(4).says("error[E0401]");
}

/// Rows of the table in docs/reference/settings.md.
fn rows() -> Vec<[String; 4]> {
    let page = fs::read_to_string(repository("docs/reference/settings.md")).unwrap();
    let table = page.split("## Ranges of numbers").nth(1).unwrap();
    let rows = table.lines().filter(|line| line.starts_with("| `"));
    rows.map(|line| {
        let cells: Vec<String> = line.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect();
        <[String; 4]>::try_from(cells).unwrap()
    })
    .collect()
}

#[test]
fn the_ranges_of_the_documentation_are_those_of_the_program() {
    let written = rows();
    let known: Vec<[String; 4]> = ncfix_machine::machine::range::RANGES
        .iter()
        .map(|range| {
            [format!("`{}`", range.keys), range.least.to_string(), range.most.to_string(), range.reason.to_owned()]
        })
        .collect();
    if std::env::var_os("NCFIX_WRITE_DOCS").is_some() {
        let lines =
            known.iter().map(|[keys, least, most, reason]| format!("| {keys} | {least} | {most} | {reason} |\n"));
        panic!("the rows are\n{}", lines.collect::<String>());
    }
    assert_eq!(written, known);
}

#[test]
fn numbers_out_of_their_range_are_refused_at_their_place() {
    let demo = fs::read_to_string(machine("demo")).unwrap();
    for (from, to) in [
        ("increment_mm = 0.0001", "increment_mm = 0.00000999"),
        ("increment_mm = 0.0001", "increment_mm = 0.2"),
        ("increment_deg = 0.0001", "increment_deg = 1"),
        ("arc_tolerance_mm = 0.01 ", "arc_tolerance_mm = 1.001 "),
        ("arc_tolerance_mm = 0.01 ", "arc_tolerance_mm = 1e300 "),
        ("arc_tolerance_ratio = 0.001", "arc_tolerance_ratio = 0.5"),
        ("reference_temperature_C = 20.0", "reference_temperature_C = -300"),
        ("origin_mm = [0, 0, 0] ", "origin_mm = [0, 2e6, 0] "),
        ("max_feed_mm_min = 15000", "max_feed_mm_min = 1e8"),
    ] {
        assert!(demo.contains(from), "{from}");
        let text = demo.replacen(from, to, 1);
        let line = text.lines().position(|line| line.starts_with(to.trim_end())).unwrap() + 1;
        let shop = Shop::new().file("m.toml", text).file("p.mpf", LANGUAGES[0].2);
        shop.run(["check", "p.mpf", "--machine", "m.toml"]).exits(4).says("error[E04").says(&format!("m.toml:{line}:"));
    }
    // The option has the same range.
    let shop = Shop::new().file("p.mpf", LANGUAGES[0].2);
    for increment in ["0.009um", "0.11mm"] {
        shop.run(["p.mpf", "-o", "o", "--machine", machine("demo").as_str(), "--increment", increment]).exits(2);
    }
    shop.run(["p.mpf", "-o", "o", "--machine", machine("demo").as_str(), "--increment", "0.01um"]).exits(0);
}

#[test]
fn a_list_without_end_is_refused() {
    let many = vec!["0"; 65].join(",");
    let text = fs::read_to_string(machine("demo")).unwrap()
        + &format!("\n[[motion]]\ncomponent = \"EYZ\"\nkind = \"polynomial\"\ncoefficients = [{many}]\n");
    let shop = Shop::new().file("m.toml", text).file("p.mpf", LANGUAGES[0].2);
    shop.run(["check", "p.mpf", "--machine", "m.toml"]).exits(4).says("error[E0410]").says("65 numbers");
}
