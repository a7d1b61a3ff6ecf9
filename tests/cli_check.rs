//! `ncfix check`: what it understands, what it reports, how it exits.

use crate::support::{Shop, dialects, machine, repository};

/// A program that every machine with X Y Z can run.
const GOOD: &str = "N10 G90 G71 G54 G0 X10 Y10 Z100\nN20 G1 X20 F500\nN30 G4 F1\nN40 M30\n";

#[test]
fn a_good_program_is_understood_and_executed() {
    let shop = Shop::new().file("part.mpf", GOOD);
    let run = shop.run(["check", "part.mpf", "--machine", &machine("demo")]).exits(0);
    assert_eq!(run.stdout, "");
    run.says("part.mpf: understood and executed, 4 moves and functions; no errors or warnings");
}

#[test]
fn json_has_the_documented_shape() {
    let shop = Shop::new().file("part.mpf", GOOD);
    let run = shop.run(["check", "part.mpf", "--json", "--machine", &machine("demo")]).exits(0);
    assert_eq!(
        run.stdout,
        "{\"parsed\":true,\"executed\":true,\"machine\":\"demo\",\"elements\":4,\"diagnostics\":[]}\n"
    );
    assert_eq!(run.stderr, "");
}

#[test]
fn what_other_languages_write_is_answered_with_what_this_one_does() {
    let shop = Shop::new().file("part.mpf", "N10 G90 G0 X1e-7 Y0 Z0\nM30\n").file("label.mpf", "A1: G90 G0 X1\nM30\n");
    let run = shop.run(["check", "part.mpf", "--machine", &machine("demo")]).exits(3);
    run.says("E0201").says("write an exponent with EX: X1EX-7");
    shop.run(["check", "label.mpf", "--machine", &machine("demo")]).exits(3).says("a label begins with two letters");
}

#[test]
fn all_faults_are_reported_in_one_run() {
    let text = "N10 G90 X\nN20 X1.2.3\nN30 M30\n";
    let shop = Shop::new().file("part.mpf", text);
    let run = shop.run(["check", "part.mpf", "--json", "--syntax-only"]).exits(3);
    let json = run.json();
    assert_eq!((json["parsed"].as_bool(), json["executed"].as_bool()), (Some(false), Some(false)));
    let places: Vec<_> = json["diagnostics"]
        .as_array()
        .unwrap()
        .iter()
        .map(|found| (found["code"].as_str().unwrap(), found["line"].as_u64().unwrap()))
        .collect();
    assert_eq!(places, [("E0103", 1), ("E0102", 2)]);
}

#[test]
fn what_cannot_be_executed_is_not_understood_and_what_is_refused_is_named_so() {
    // The statement is read, but cannot be executed: exit status 3, and the text agrees with it.
    let shop = Shop::new().file("wrong.mpf", "N10 TRACYL(40)\nM30\n").file("far.mpf", "N10 G90 G0 X9000 Y0 Z0\nM30\n");
    let check = |name: &str| shop.run(["check", name, "--machine", &machine("demo")]);
    check("wrong.mpf").exits(3).says("wrong.mpf: not understood; 1 error");
    check("far.mpf").exits(4).says("far.mpf: understood, but a correction would be refused; 1 error");
}

#[test]
fn syntax_only_needs_no_machine_and_executes_nothing() {
    let shop = Shop::new().file("part.mpf", "N10 WHILE TRUE\nN20 X=1/0\nN30 ENDWHILE\n");
    let run = shop.run(["check", "part.mpf", "--syntax-only", "--json"]).exits(0);
    assert_eq!(run.stdout, "{\"parsed\":true,\"executed\":false,\"elements\":0,\"diagnostics\":[]}\n");
}

#[test]
fn the_demo_machine_is_announced() {
    let shop = Shop::new().file("part.mpf", GOOD);
    shop.run(["check", "part.mpf"]).exits(0).says("warning[W0304]");
}

#[test]
fn the_nearest_machine_file_upwards_is_used() {
    let demo = std::fs::read(machine("demo")).unwrap();
    let shop = Shop::new().file("ncfix.toml", demo).file("parts/one/part.mpf", GOOD);
    let run = shop.run(["check", "parts/one/part.mpf"]).exits(0);
    assert!(!run.stderr.contains("W0304"), "{}", run.stderr);
    let shop = Shop::new().file("parts/ncfix.toml", "[machine\n").file("parts/part.mpf", GOOD);
    shop.run(["check", "parts/part.mpf"]).exits(4).says("error[E0401]").says("ncfix.toml:1:");
}

#[test]
fn the_dialect_is_the_option_then_the_machine_then_the_name_then_the_content() {
    // Each of them is understood in one dialect only.
    let shop = Shop::new()
        .file("part.ngc", "o100 if [1 GT 0]\n  G0 X1\no100 endif\nM2\n")
        .file("tape.nc", "%\nO1234\n#100=1.\nIF [#100 EQ 2.] GOTO 5\nG0 X1.\nN5 M30\n")
        .file("loop.mpf", "N10 WHILE R1<1\nN20 R1=R1+1\nN30 ENDWHILE\n")
        .file("macro.pm", "%PM9001\nN9001 (X)\nN1 E1=10:2\nN2 M30\n")
        .file("part.mpf", GOOD);
    let check = |words: &[&str]| shop.run(["check", "--syntax-only"].iter().chain(words));
    for own in ["part.ngc", "tape.nc", "loop.mpf", "macro.pm"] {
        check(&[own]).exits(0);
    }
    check(&["part.ngc", "--machine", &machine("demo")]).exits(3);
    check(&["part.ngc", "--machine", &machine("demo"), "--dialect", "rs274"]).exits(0);
    check(&["loop.mpf", "--machine", &machine("vmc")]).exits(3);
    check(&["tape.nc", "--dialect", "sinumerik"]).exits(3);
    check(&["macro.pm", "--dialect", "fanuc"]).exits(3);
    shop.run(["check", "part.mpf", "--dialect", "latin"]).exits(2).says("unknown dialect 'latin'");
}

#[test]
fn a_name_of_hobby_controls_decides_if_nothing_else_does() {
    let text = "T1M6\nG17\nG0Z30.001\nM2\n";
    for (name, says) in [
        ("a.tap", "rs274, by its name"),
        ("a.gc", "rs274, by its name"),
        ("a.g", "rs274, by its name"),
        ("a.nc", "sinumerik, by default"),
    ] {
        Shop::new().file(name, text).run(["check", "--syntax-only", "-v", name]).says(says);
    }
}

#[test]
fn standard_input_is_read() {
    let shop = Shop::new();
    let run = shop.run_with_input(["check", "-", "--machine", &machine("demo")], b"N10 G1 X\n").exits(3);
    run.says("<stdin>:1:8");
}

#[test]
fn a_file_that_is_missing_is_wrong_usage() {
    let shop = Shop::new().file("part.mpf", GOOD);
    shop.run(["check", "other.mpf"]).exits(2).says("cannot read other.mpf: there is no such file");
    shop.run(["check", "."]).exits(2).says("it is a folder");
    shop.run(["check", "part.mpf", "--machine", "m.toml"]).exits(2).says("cannot read m.toml");
    shop.run(["check"]).exits(2);
    shop.run(["check", "part.mpf", "--bogus"]).exits(2);
}

#[test]
fn any_bytes_are_answered_without_a_crash() {
    for bytes in
        [&b""[..], b"\0\0\0\0", b"\xff\xfe\x00G\x001", b"%\n", b"\r\r\r", b"N10 G1 X\xb5\n", b"\x1b]0;title\x07"]
    {
        let shop = Shop::new().file("part.mpf", bytes);
        let run = shop.run(["check", "part.mpf", "--machine", &machine("demo")]);
        assert!([0, 3, 4].contains(&run.code), "{bytes:?}: {run:?}");
        assert!(!run.stderr.contains('\u{1b}'), "{run:?}");
    }
}

#[test]
fn subprograms_are_found_beside_the_program_and_findings_point_into_them() {
    let shop = Shop::new()
        .file("parts/main.mpf", "N10 G90 G71 G54 G0 X0 Y0 Z100\nN20 L12\nN30 M30\n")
        .file("parts/l12.spf", "N10 G1 X10 F500\nN15 R9=0\nN20 X=1/R9\nN30 M17\n");
    let run = shop.run(["check", "parts/main.mpf", "--machine", &machine("demo")]).exits(4);
    run.says("error[E0209]").says("l12.spf:3:");
}

#[test]
fn a_program_of_another_control_is_told_what_it_reads_like() {
    let fanuc = "%\nO0001 (PART)\nG90 G54 G43 H1 Z50.\n#100=5\nG0 X[#100+1] Y0.\nM30\n%\n";
    let rs274 = "o<hole> sub\nG1 Z-1 F100\no<hole> endsub\n#<depth>=5\nG90 G54 G0 X#<depth>\nM2\n";
    let grundig = "%PM9001\nN9001 (PART)\nN1 G17 G90 T1 M67\nN2 E1=5\nN3 G0 X=E1+1 Y0 Z5\nN4 M30\n";
    let sinumerik = "%_N_A_MPF\nN10 DEF REAL DEPTH=5\nN20 G90 G54 G0 X=DEPTH\nN30 M30\n";
    let programs = [("fanuc", fanuc), ("rs274", rs274), ("grundig", grundig), ("sinumerik", sinumerik)];
    for (own, text) in programs {
        for (other, machine_name) in dialects().into_iter().filter(|(other, _)| *other != own) {
            let shop = Shop::new().file("a.nc", text);
            let run = shop.run(["check", "a.nc", "--machine", &machine(machine_name)]);
            assert_ne!(run.code, 0, "{own} on {other}: {}", run.stderr);
            let hint = format!("try --dialect {own} ");
            assert_eq!(run.stderr.matches("reads like").count(), 1, "{own} on {other}: {}", run.stderr);
            // With the first of the errors.
            let first = run.stderr.split("\n\n").next().unwrap();
            assert!(first.contains(&hint), "{own} on {other}: {}", run.stderr);
        }
    }
}

#[test]
fn no_sample_reads_like_another_dialect() {
    for (dialect, machine_name) in dialects() {
        let folder = repository(&format!("samples/programs/{dialect}"));
        let mut files = Vec::new();
        for folder in [folder.clone(), folder.join("bad")] {
            files.extend(
                std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).filter(|path| path.is_file()),
            );
        }
        assert!(files.len() > 10, "{}", files.len());
        for file in files.iter().filter(|file| file.extension().is_none_or(|extension| extension != "md")) {
            let words = ["check", file.to_str().unwrap(), "--machine", &machine(machine_name), "--max-blocks", "10000"];
            let run = Shop::new().run(words);
            assert!(!run.stderr.contains("reads like"), "{}: {}", file.display(), run.stderr);
        }
    }
}

/// What the correction would refuse is said before: ends, and where arcs lead on their way. X reaches from 0 to 300.
#[test]
fn the_travel_of_a_machine_file_counts() {
    let machine = "[machine]\nname = \"t\"\ntopology = \"wFXYZt\"\ncontroller = \"rs274\"\n\
        [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 300]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-100, 100]\n\
        [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-100, 100]\n[zero_offset.G54]\nX_mm = 10\nY_mm = 0\nZ_mm = 0\n";
    let program = "G21 G90 G54 F100\nG0 X0 Y0 Z0\nG1 X290\nX290.001\nX10\nG3 X10 Y40 I0 J20\nG3 X10 Y0 I0 J-20\nG2 X50 Y0 I20 J0\nM2\n";
    let shop = Shop::new().file("t.toml", machine).file("in.ngc", program);
    let run = shop.run(["check", "in.ngc", "--machine", "t.toml", "--json"]).exits(4);
    let json = run.json();
    let found: Vec<(String, u64)> = json["diagnostics"]
        .as_array()
        .unwrap()
        .iter()
        .map(|one| (one["code"].as_str().unwrap().to_owned(), one["line"].as_u64().unwrap()))
        .collect();
    // Line 4 ends a micrometer beyond; counter-clockwise from (20, 40) back to (20, 0) the arc leads over X 0 in the machine, which is on the limit.
    assert_eq!(found, [("E0302".to_owned(), 4)], "{json}");
    let wide = program.replace("X10", "X9").replace("X50", "X49");
    let shop = shop.file("wide.ngc", wide);
    let json = shop.run(["check", "wide.ngc", "--machine", "t.toml", "--json"]).exits(4).json();
    let lines: Vec<u64> =
        json["diagnostics"].as_array().unwrap().iter().map(|one| one["line"].as_u64().unwrap()).collect();
    assert_eq!(lines, [4, 7], "{json}");
    // Without a machine file it is the demo machine, which is named first, for the correction too.
    let demo = ["check", "fix"].map(|command| {
        let output: &[&str] = if command == "fix" { &["-o", "out.ngc"] } else { &[] };
        shop.run([command, "in.ngc", "--json"].iter().chain(output)).json()["diagnostics"].clone()
    });
    assert_eq!(demo[0], demo[1]);
    assert_eq!(demo[0][0]["code"], "W0304");
}

/// Where nobody has stated where an axis is, its place is assumed, and no reason to say that it is outside: as for a correction, which refuses the start.
#[test]
fn assumed_places_are_outside_of_nothing() {
    let machine = machine("esmaeili_xyz5");
    for program in
        ["G90 G71 G54\nG91 G0 X-9000\nX-10\nM30\n", "G90 G71 G54 G0 X10 Y10 Z10\nG74 Z1=0\nG91 G0 Z-9000\nM30\n"]
    {
        let shop = Shop::new().file("in.mpf", program);
        let check = shop.run(["check", "in.mpf", "--machine", &machine]);
        let fix = shop.run(["in.mpf", "-o", "out.mpf", "--machine", &machine]);
        assert!(fix.code != 0 && !fix.stderr.contains("E0302"), "{}", fix.stderr);
        assert!(!check.stderr.contains("E0302"), "{}", check.stderr);
    }
    let sample = repository("samples/programs/sinumerik/L100.SPF").display().to_string();
    let check = Shop::new().run(["check", &sample, "--machine", &machine]);
    assert!(!check.stderr.contains("E0302"), "{}", check.stderr);
}

#[test]
fn a_program_that_moves_nothing_is_pointed_out() {
    // The O number ends the part before it; what stands behind M30 is never reached; a skipped block moves only where it is not skipped.
    for text in ["O1\nG21\nM30\nG1 X5. F100.\n", "O1\nM5\nM30\n", "O1\n/G1 X5. F100.\nM30\n"] {
        let shop = Shop::new().file("part.nc", text);
        let vmc = machine("vmc");
        let skip: &[&str] = if text.contains('/') { &["--skip", "0"] } else { &[] };
        let run = shop.run(["snc", "part.nc", "--machine", &vmc].iter().chain(skip).copied()).exits(0);
        assert!(run.stderr.contains("warning[W0238]"), "{text}: {}", run.stderr);
        shop.run(["check", "part.nc", "--machine", &vmc].iter().chain(skip).copied()).exits(4).says("error[E0223]");
        shop.run(["fix", "part.nc", "-o", "out.nc", "--machine", &vmc].iter().chain(skip).copied())
            .exits(4)
            .says("error[E0223]");
    }
    // One that moves is none.
    let shop = Shop::new().file("part.nc", "O1\nG21\nG1 X5. F100.\nM30\n");
    let run = shop.run(["check", "part.nc", "--machine", &machine("vmc")]).exits(0);
    assert!(!run.stderr.contains("W0238"), "{}", run.stderr);
}

/// Every bad sample of a dialect, and programs that only a correction refuses: with a drift of the position, and beyond the travel by the correction alone.
#[test]
fn check_says_what_a_correction_refuses() {
    let mut refused = 0;
    for (dialect, machine_name) in dialects() {
        let on = machine(machine_name);
        let mut files: Vec<_> = std::fs::read_dir(repository(&format!("samples/programs/{dialect}/bad")))
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .filter(|path| path.extension().is_none_or(|extension| extension != "md"))
            .collect();
        files.sort();
        for file in &files {
            let name = file.file_name().unwrap().to_str().unwrap();
            let shop = Shop::new().copy(file.to_str().unwrap());
            let fix = shop.run(["fix", name, "-o", "out", "--machine", &on, "--json", "--max-blocks", "1000"]);
            let check = shop.run(["check", name, "--machine", &on, "--json", "--max-blocks", "1000"]);
            assert_eq!(check.code, fix.code, "{name}: {}", check.stderr);
            if ![0, 3, 4].contains(&fix.code) {
                continue;
            }
            let check = check.json();
            if check.get("support_file").is_none() {
                assert_eq!(check["diagnostics"], fix.json()["diagnostics"], "{name}");
                refused += usize::from(fix.code != 0);
            }
            assert_eq!(check["executed"].as_bool().unwrap(), fix.code == 0, "{name}");
        }
    }
    assert!(refused > 60, "{refused}");
    let on = machine("demo");
    let cases: [(&str, &[&str], &str); 4] = [
        ("N10 G90 G71 G54\nN20 G91 G1 X10 F100\nN30 M30\n", &[], "E0304"),
        ("N10 G90 G71 G54 G0 X10 Y10 Z100\nN20 G1 X600 F500\nN30 M30\n", &["--max-correction", "1um"], "E0303"),
        ("N10 G90 G71 G599 G0 X10 Y10 Z100\nN20 G1 X20 F500\nN30 M30\n", &[], "E0306"),
        ("N10 G90 G71 G54 G0 X10 Y10 Z100\nN20 G1 X99999 F500\nN30 M30\n", &[], "E0302"),
    ];
    for (text, options, code) in cases {
        let shop = Shop::new().file("part.mpf", text);
        let of = |words: &[&str]| shop.run(words.iter().chain(&["--machine", &on, "--json"]).chain(options)).exits(4);
        let check = of(&["check", "part.mpf"]).json();
        let fix = of(&["fix", "part.mpf", "-o", "out.mpf"]).json();
        assert_eq!(check["diagnostics"], fix["diagnostics"], "{text}");
        assert!(check["diagnostics"].as_array().unwrap().iter().any(|one| one["code"] == code), "{check}");
        assert_eq!(shop.names(), ["part.mpf"], "a check writes nothing");
    }
}

/// Blank lines before the `%` count: `G0 X1.` is line 4 of the file, `G1 X2.` line 5.
#[test]
fn lines_before_the_tape_count() {
    let shop = Shop::new().file("part.nc", "\n%\nG21 G90 G17 G54 G94\nG0 X1. Y1. Z1.\nG1 X2. F100.\nM30\n%\n");
    let run = shop.run(["snc", "part.nc"]).exits(0);
    let line_of = |start: &str| run.stdout.lines().find(|line| line.starts_with(start)).unwrap_or_default().to_owned();
    assert!(line_of("G0 ").ends_with(";@4") && line_of("G1 ").ends_with(";@5"), "{}", run.stdout);
}

/// A stream with a gap is another path: what stands before the error is printed, and nothing after it.
#[test]
fn a_stream_ends_before_the_first_error() {
    let text = "N10 G90 G71 G54 G0 X10 Y10 Z100\nN20 G1 X20 F500\nN30 X=1/(R1-R1)\nN40 X30\nN50 M30\n";
    let shop = Shop::new().file("part.mpf", text);
    let run = shop.run(["snc", "part.mpf", "--machine", &machine("demo")]).exits(4);
    assert!(run.stdout.contains(";@2") && !run.stdout.contains(";@4") && !run.stdout.contains(";@5"), "{}", run.stdout);
}

/// An error of the machine file is not one of the program.
#[test]
fn an_error_of_the_machine_file_says_nothing_about_the_program() {
    let wrong = std::fs::read_to_string(machine("demo")).unwrap().replace("topology = ", "topologie = ");
    let shop = Shop::new().file("part.mpf", GOOD).file("mill.toml", wrong);
    for further in [&[][..], &["--syntax-only"]] {
        let run = shop.run(["check", "part.mpf", "--machine", "mill.toml"].iter().chain(further)).exits(4);
        let run = run.says("part.mpf: not examined, because of an error in mill.toml");
        assert!(!run.stderr.contains("understood"), "{}", run.stderr);
    }
}
