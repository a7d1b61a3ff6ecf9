//! `ncfix fix`: what is written, what never is, and what is reported.

use std::fs;

use crate::support::{Run, Shop, dialects, machine};

/// A program with header, comments, an arc and a block number on every line.
const PART: &str = "\
%_N_PART_MPF
;$PATH=/_N_MPF_DIR
; COVER
N10 G17 G90 G71 G94
N20 T5
N30 M6 ; END MILL
N40 D1
N50 G54 S3000 M3
N60 G0 X-20 Y-10
N70 Z50
N80 Z2
N90 G1 Z-1 F200
N100 X20 F600
N110 G3 X30 Y0 I0 J10
N120 G1 Y20
N130 G0 Z50
N140 M30
";

/// A shop with the program and a shop with a program that is refused: it begins with an incremental move.
fn shop() -> Shop {
    Shop::new().file("part.mpf", PART).file("refused.mpf", "N10 G91 G0 X10\nN20 M30\n")
}

/// Runs `ncfix` with the demo machine.
fn fix(shop: &Shop, arguments: &[&str]) -> Run {
    let demo = machine("demo");
    shop.run(arguments.iter().copied().chain(["--machine", demo.as_str()]))
}

#[test]
fn the_default_command_writes_and_reports() {
    let shop = shop();
    let run = fix(&shop, &["part.mpf", "-o", "out.mpf"]).exits(0);
    assert_eq!(run.stdout, "");
    for row in [
        "error before",
        "error after",
        "improvement",
        "correction",
        "blocks",
        "computed",
        "machine      demo",
        "out.mpf",
    ] {
        assert!(run.stderr.contains(row), "{row}: {}", run.stderr);
    }
    let text = shop.text("out.mpf");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("%_N_PART_MPF"));
    assert_eq!(lines.next(), Some(";$PATH=/_N_MPF_DIR"));
    assert!(lines.next().unwrap().starts_with("; ncfix 0.1.0 machine=\"demo\" model="), "{text}");
    assert_eq!(lines.next(), Some("; COVER"));
    assert!(text.contains("N30 M6 ; END MILL\n") && text.ends_with("N140 M30\n"), "{text}");
    assert!(!text.contains("DEMO"), "{text}");
}

#[test]
fn the_long_command_is_the_same() {
    let shop = shop();
    fix(&shop, &["part.mpf", "-o", "a.mpf"]).exits(0);
    fix(&shop, &["fix", "part.mpf", "-o", "b.mpf"]).exits(0);
    assert_eq!(shop.bytes("a.mpf"), shop.bytes("b.mpf"));
}

#[test]
fn json_has_the_documented_keys() {
    let shop = shop();
    let run = fix(&shop, &["part.mpf", "-o", "out.mpf", "--json"]).exits(0);
    assert_eq!(run.stderr, "");
    let json = run.json();
    let keys: Vec<_> = json.as_object().unwrap().keys().map(String::as_str).collect();
    let mut expected = [
        "before",
        "before_form",
        "zeros",
        "after",
        "max_correction",
        "blocks_in",
        "blocks_out",
        "growth",
        "most_repeated",
        "drilling_cycles",
        "cycles_off_um",
        "drilled_by_moves",
        "cycles_need_um",
        "guard",
        "rapids_as_programmed",
        "off_at_rapids_um",
        "remaining",
        "seconds",
        "max_at_line",
        "max_at_file",
        "backup",
        "review",
        "coverage",
        "prediction",
        "verdict",
        "output",
        "machine",
        "diagnostics",
    ];
    expected.sort_unstable();
    let mut found = keys.clone();
    found.sort_unstable();
    assert_eq!(found, expected);
    let mean = |side: &str| json[side]["mean_um"].as_f64().unwrap();
    assert!(mean("before") > 1.0 && mean("after") < 0.5, "{json}");
    assert!(json["max_correction"]["X_um"].as_f64().unwrap() > 0.1, "{json}");
    assert_eq!(json["output"], "out.mpf");
    assert_eq!(json["machine"], "demo");
    assert_eq!(json["diagnostics"], serde_json::json!([]));
}

#[test]
fn standard_streams_work() {
    let shop = shop();
    fix(&shop, &["part.mpf", "-o", "out.mpf"]).exits(0);
    let demo = machine("demo");
    let run = shop.run_with_input(["-", "-o", "-", "--machine", &demo], PART.as_bytes()).exits(0);
    assert_eq!(run.stdout.as_bytes(), shop.bytes("out.mpf"));
    run.says("standard output");
}

#[test]
fn json_and_the_program_cannot_share_standard_output() {
    let shop = shop();
    let run = fix(&shop, &["part.mpf", "-o", "-", "--json"]).exits(2);
    assert_eq!(run.stdout, "");
}

#[test]
fn nothing_is_written_where_there_is_an_error() {
    let shop = shop().file("out.mpf", "KEEP ME\n");
    fix(&shop, &["refused.mpf", "-o", "out.mpf"]).exits(4).says("error[E0304]").says("nothing was written");
    assert_eq!(shop.text("out.mpf"), "KEEP ME\n");
    let run = fix(&shop, &["refused.mpf", "-o", "-"]).exits(4);
    assert_eq!(run.stdout, "");
    let json = fix(&shop, &["refused.mpf", "-o", "new.mpf", "--json"]).exits(4).json();
    assert_eq!((json["output"].is_null(), json["after"].is_null()), (true, true), "{json}");
    assert_eq!(json["diagnostics"][0]["code"], "E0304");
    assert_eq!(shop.names(), ["out.mpf", "part.mpf", "refused.mpf"]);
}

#[test]
fn a_program_that_is_not_understood_exits_with_3() {
    let shop = Shop::new().file("a.mpf", "N10 G0 X\n").file("b.mpf", "N10 CYCLE63(1,2,3)\n");
    fix(&shop, &["a.mpf", "-o", "out.mpf"]).exits(3);
    fix(&shop, &["b.mpf", "-o", "out.mpf"]).exits(3);
    assert_eq!(shop.names(), ["a.mpf", "b.mpf"]);
}

#[test]
fn a_corrected_program_is_refused() {
    let shop = shop();
    fix(&shop, &["part.mpf", "-o", "out.mpf"]).exits(0);
    fix(&shop, &["out.mpf", "-o", "twice.mpf"]).exits(4).says("error[E0301]");
    assert_eq!(shop.names(), ["out.mpf", "part.mpf", "refused.mpf"]);
}

#[test]
fn the_demo_machine_stamps_the_output() {
    let shop = shop();
    shop.run(["part.mpf", "-o", "out.mpf"]).exits(0).says("warning[W0304]");
    assert!(shop.text("out.mpf").contains("DEMO MACHINE"), "{}", shop.text("out.mpf"));
}

#[test]
fn the_input_is_never_overwritten() {
    let shop = shop()
        .file("L1.SPF", "N10 G1 Y5 F100\nN20 M17\n")
        .file("sub.mpf", "N10 G90 G71 G54 G0 X0 Y0 Z50\nN20 L1\nN30 M30\n");
    fix(&shop, &["part.mpf", "-o", "part.mpf"]).exits(4).says("error[E0310]");
    fix(&shop, &["part.mpf", "-o", "./part.mpf"]).exits(4).says("error[E0310]");
    fix(&shop, &["sub.mpf", "-o", "L1.SPF"]).exits(4).says("error[E0310]");
    let demo = fs::read(machine("demo")).unwrap();
    let shop = shop.file("m.toml", demo);
    shop.run(["part.mpf", "-o", "m.toml", "--machine", "m.toml"]).exits(4).says("error[E0310]");
    assert_eq!(shop.text("part.mpf"), PART);
}

#[cfg(unix)]
#[test]
fn a_link_to_the_input_is_the_input() {
    let shop = shop();
    std::os::unix::fs::symlink("part.mpf", shop.path("soft.mpf")).unwrap();
    fs::hard_link(shop.path("part.mpf"), shop.path("hard.mpf")).unwrap();
    fix(&shop, &["part.mpf", "-o", "soft.mpf"]).exits(4).says("error[E0310]");
    fix(&shop, &["part.mpf", "-o", "hard.mpf"]).exits(4).says("error[E0310]");
    assert_eq!(shop.text("part.mpf"), PART);
}

#[test]
fn in_place_keeps_the_original() {
    let shop = shop().file("part.mpf.bak", "OLDER\n");
    fix(&shop, &["part.mpf", "--in-place"]).exits(0).says("part.mpf.bak1");
    assert_eq!(shop.text("part.mpf.bak"), "OLDER\n");
    assert_eq!(shop.text("part.mpf.bak1"), PART);
    assert!(shop.text("part.mpf").contains("ephemeral"));
    fix(&shop, &["refused.mpf", "--in-place"]).exits(4);
    assert_eq!(shop.names(), ["part.mpf", "part.mpf.bak", "part.mpf.bak1", "refused.mpf"]);
    fix(&shop, &["-", "--in-place"]).exits(2);
}

#[test]
fn in_place_removes_no_other_program() {
    let one = "%_N_ONE_MPF\nN10 G90 G71 G54 G0 X0 Y0 Z50\nG1 X10 F500\nM30\n";
    let two = one.replace("ONE", "TWO").replace("X10", "X20");
    let shop = Shop::new().file("two.mpf", format!("{one}{two}"));
    let machine = machine("demo");
    shop.run(["fix", "two.mpf", "--in-place", "--machine", &machine]).exits(4).says("error[E0229]");
    assert_eq!(shop.text("two.mpf"), format!("{one}{two}"));
    shop.run(["fix", "two.mpf", "-o", "out.mpf", "--machine", &machine]).exits(0).says("warning[W0203]");
}

#[test]
fn an_output_that_cannot_be_written_is_wrong_usage() {
    let shop = shop();
    fix(&shop, &["part.mpf", "-o", "no/such/folder/out.mpf"]).exits(2).says("cannot write");
    fix(&shop, &["part.mpf", "-o", "."]).exits(2).says("it is a folder");
    fix(&shop, &["part.mpf"]).exits(2);
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let text: String = std::iter::once("N10 G90 G71 G54 G0 X0 Y0 Z50\nG1 F500\n".to_owned())
        .chain((0..20_000).map(|step| format!("X{} Y{}\n", step % 100, step % 37)))
        .chain(["M30\n".to_owned()])
        .collect();
    let shop = Shop::new().file("long.mpf", text);
    let mut child = shop.command(["long.mpf", "-o", "-", "--machine", &machine("demo")]).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn options_change_the_output() {
    let shop = shop();
    let lines = |name: &str| shop.text(name).lines().count();
    fix(&shop, &["part.mpf", "-o", "plain.mpf"]).exits(0);
    fix(&shop, &["part.mpf", "-o", "chords.mpf", "--arcs", "chords"]).exits(0);
    assert!(!shop.text("chords.mpf").contains("G3"));
    fix(&shop, &["part.mpf", "-o", "step.mpf", "--step", "5mm"]).exits(0);
    assert!(lines("step.mpf") > lines("plain.mpf"));
    fix(&shop, &["part.mpf", "-o", "coarse.mpf", "--increment", "1um"]).exits(0);
    let decimals = |text: &str| {
        let words = text.lines().filter(|line| !line.contains(';')).flat_map(str::split_whitespace);
        words.filter_map(|word| word.strip_prefix(['X', 'Y', 'Z'])?.split_once('.')).map(|(_, part)| part.len()).max()
    };
    assert_eq!((decimals(&shop.text("plain.mpf")), decimals(&shop.text("coarse.mpf"))), (Some(4), Some(3)));
    fix(&shop, &["part.mpf", "-o", "machine.mpf", "--frame", "machine"]).exits(0);
    assert!(shop.text("machine.mpf").contains("G153"));
    fix(&shop, &["part.mpf", "-o", "none.mpf", "--rapids", "none"]).exits(0);
    assert!(shop.text("none.mpf").contains("N60 G0 X-20 Y-10\n"), "{}", shop.text("none.mpf"));
}

#[test]
fn word_languages_have_no_machine_frame_in_the_output() {
    for (dialect, machine_name) in dialects().into_iter().filter(|(dialect, _)| *dialect != "sinumerik") {
        let shop = Shop::new().file("a.nc", "%\nN10 G90 G54 G0 X0. Y0. Z50.\nN20 M30\n");
        let machine = machine(machine_name);
        for option in [["--frame", "machine"], ["--five-axis", "axes"]] {
            let run =
                shop.run(["a.nc", "-o", "b.nc", "--dialect", dialect, "--machine", &machine].iter().chain(&option));
            let run = run.exits(2);
            assert!(run.stderr.contains(&format!("in the dialect '{dialect}'")), "{}", run.stderr);
            assert!(run.stderr.contains("do not use --frame machine or --five-axis axes"), "{}", run.stderr);
            assert_eq!(shop.names(), ["a.nc"]);
        }
        // Nothing else is wrong with the program.
        shop.run(["a.nc", "-o", "b.nc", "--dialect", dialect, "--machine", &machine]).exits(0);
    }
}

#[test]
fn a_start_makes_an_incremental_beginning_possible() {
    let shop = shop();
    fix(&shop, &["refused.mpf", "-o", "out.mpf", "--start", "X300,Y200,Z100"]).exits(0);
}

#[test]
fn crlf_and_foreign_bytes_come_through() {
    let part =
        b"%_N_A_MPF\r\n; \xcf\xc3\xb5\xb6\r\nN10 G90 G71 G54 G0 X0 Y0 Z50 ; \xfc\r\nN20 MSG(\"\xb0\")\r\nN30 M30\r\n";
    let shop = Shop::new().file("a.mpf", part);
    fix(&shop, &["a.mpf", "-o", "b.mpf"]).exits(0);
    let out = shop.bytes("b.mpf");
    assert!(out.split_inclusive(|&byte| byte == b'\n').all(|line| line.ends_with(b"\r\n")), "{}", out.escape_ascii());
    for text in [&b"; \xcf\xc3\xb5\xb6\r\n"[..], b"; \xfc\r\n", b"MSG(\"\xb0\")"] {
        assert!(out.windows(text.len()).any(|part| part == text), "{}", out.escape_ascii());
    }
}

#[test]
fn a_pose_where_two_linear_axes_are_parallel_has_no_correction() {
    // B carries Z: at B90 it moves along X, and nothing moves along Z any more.
    let machine = "[machine]
name = \"nutating\"
topology = \"wFXBYZSt\"
[axis.X]
direction = [1, 0, 0]
travel_mm = [-500, 500]
[axis.Y]
direction = [0, 1, 0]
travel_mm = [-500, 500]
[axis.Z]
direction = [0, 0, 1]
travel_mm = [-500, 500]
[axis.B]
direction = [0, 1, 0]
travel_deg = [-100, 100]
[location]
EC0Y = 20.0
";
    let shop = Shop::new()
        .file("m.toml", machine)
        .file("good.mpf", "N10 G90 G71 G0 X10 Y10 Z10 B60\nN20 G1 X20 F500\nN30 M30\n")
        .file("bad.mpf", "N10 G90 G71 G0 X10 Y10 Z10 B90\nN20 G1 X20 F500\nN30 M30\n");
    shop.run(["good.mpf", "-o", "out.mpf", "--machine", "m.toml"]).exits(0);
    shop.run(["bad.mpf", "-o", "none.mpf", "--machine", "m.toml"]).exits(4).says("error[E0308]");
    assert!(!shop.path("none.mpf").exists());
}

#[test]
fn words_of_a_rapid_block_keep_their_values() {
    let text = "N10 G90 G71 G54 G0 X0 Y0 Z50\nN20 G0 Z5 F300 M8\nN30 G1 Z-1\nN40 G9 G1 X300 M9\nN50 RET\n";
    let shop = Shop::new().file("part.mpf", text);
    fix(&shop, &["part.mpf", "-o", "out.mpf", "--tolerance", "0.2um"]).exits(0);
    let out = shop.text("out.mpf");
    let line = |number: &str| out.lines().find(|line| line.starts_with(number)).unwrap().to_owned();
    assert!(line("N20").ends_with("F300 M8"), "{out}");
    // The exact stop and M9 belong to the end of the programmed move, not to its first piece.
    let last = out.lines().filter(|line| line.ends_with("M9 ;+")).count();
    assert!(last == 1 && out.contains("G9 X300.") && !line("N40").contains("G9"), "{out}");
    assert!(line("N50").ends_with("RET"), "{out}");
}

#[test]
fn a_subprogram_that_was_corrected_before_is_refused() {
    let stamped =
        "; NCFIX 0.1.0 MACHINE=\"DEMO\" MODEL=1 SOURCE=2 EPHEMERAL: FOR THIS MACHINE ONLY\nN10 G1 X5 F100\nM17\n";
    let shop =
        Shop::new().file("part.mpf", "N10 G90 G71 G54 G0 X0 Y0 Z50\nN20 L10\nN30 M30\n").file("L10.SPF", stamped);
    let run = fix(&shop, &["part.mpf", "-o", "out.mpf"]).exits(4).says("error[E0301]");
    assert!(run.stderr.contains("L10.SPF:1:"), "{}", run.stderr);
    assert!(!shop.path("out.mpf").exists());
}

#[test]
fn a_fault_of_syntax_does_not_hide_what_is_not_supported() {
    let shop =
        Shop::new().file("part.mpf", "N10 G90 G71 G54 G0 X0 Y0 Z50\nN20 X10..5\nN30 GEOAX(1,X)\nN40 CYCLE63(1)\n");
    let run = fix(&shop, &["part.mpf", "-o", "out.mpf"]).exits(3);
    for place in ["part.mpf:2:", "part.mpf:3:", "part.mpf:4:"] {
        assert!(run.stderr.contains(place), "{}", run.stderr);
    }
}

/// Without a review nothing compares the output, and `fix` says so. A review whose verdict is bad has a status of its own.
#[test]
fn the_output_has_a_verdict_or_the_command_for_it() {
    let demo = machine("demo");
    let text = "G90 G71 G94\nG0 X50 Y50 Z100\nG1 X600 F500\nM30\n";
    let shop = Shop::new().file("part.mpf", text);
    let fix = ["part.mpf", "-o", "out.mpf", "--machine", &demo];
    let plain = shop.run(fix).exits(0);
    plain.says("verdict      none yet: the output was not compared").says("next         ncfix verify part.mpf out.mpf");
    let reviewed = shop.run(fix.iter().chain(&["--review", "page.html"])).exits(0);
    assert!(!reviewed.stderr.contains("none yet"), "{}", reviewed.stderr);
    shop.run(["part.mpf", "--in-place", "--machine", &demo]).exits(0).says("ncfix verify ORIGINAL CORRECTED does it");
}
