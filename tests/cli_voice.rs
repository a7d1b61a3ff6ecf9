//! `--quiet`, `--verbose`, progress, and what is said once instead of dozens of times.

use std::process::Command;
use std::time::{Duration, Instant};

use crate::support::{Shop, machine, repository};

const GOOD: &str = "N10 G90 G71 G54 G0 X10 Y10 Z100\nN20 G1 X20 F500\nN30 M30\n";

#[test]
fn quiet_says_errors_only() {
    let shop = Shop::new().file("part.mpf", GOOD).file("bad.mpf", "N10 X1.2.3\nN20 M30\n");
    // A warning and a report, without the switch.
    shop.run(["part.mpf", "-o", "out.mpf"]).exits(0).says("warning[W0304]").says("error after");
    for words in [["-q", "part.mpf", "-o", "out.mpf"], ["part.mpf", "-o", "out.mpf", "--quiet"]] {
        let run = shop.run(words).exits(0);
        assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""));
    }
    let run = shop.run(["-q", "check", "bad.mpf"]).exits(3).says("error[E0102]");
    assert!(!run.stderr.contains("warning") && !run.stderr.contains("not understood"), "{}", run.stderr);
    // Wrong usage is an error.
    shop.run(["-q", "check", "none.mpf"]).exits(2).says("cannot read none.mpf");
}

#[test]
fn what_goes_to_standard_output_does_not_depend_on_the_switches() {
    let shop = Shop::new().file("part.mpf", GOOD).file("bad.mpf", "N10 X1.2.3\nN20 M30\n");
    let demo = machine("demo");
    for words in [
        &["check", "part.mpf", "--json"][..],
        &["check", "bad.mpf", "--json"],
        &["verify", "part.mpf", "part.mpf", "--json", "--machine", &demo],
        &["snc", "part.mpf", "--machine", &demo],
        &["machine", "show", &demo],
        &["explain", "E0101"],
    ] {
        let plain = shop.run(words);
        for switch in ["-q", "-v", "--quiet", "--verbose"] {
            let before = shop.run([switch].iter().chain(words));
            let behind = shop.run(words.iter().chain(&[switch]));
            assert_eq!((&before.stdout, before.code), (&plain.stdout, plain.code), "{switch} {words:?}");
            assert_eq!((&behind.stdout, &behind.stderr), (&before.stdout, &before.stderr), "{words:?} {switch}");
        }
    }
    shop.run(["-q", "-v", "check", "part.mpf"]).exits(2).says("cannot be used with");
}

#[test]
fn verbose_says_which_files_were_read_and_why() {
    let main = "N10 G90 G71 G54 G0 X10 Y10 Z100\nN20 L7\nN30 M30\n";
    let shop = Shop::new()
        .file("part.mpf", main)
        .file("L7.SPF", "N10 G1 X20 F500\nN20 M17\n")
        .file("job.toml", "[zero_offset.G54]\nX_mm = 1\nY_mm = 1\nZ_mm = 1\n")
        .file("warm.toml", "[temperature_C]\nT_bed = 21.0\n");
    let demo = machine("demo");
    let words = ["-v", "part.mpf", "-o", "o.mpf", "--machine", &demo, "--setup", "job.toml", "--state", "warm.toml"];
    let run = shop.run(words);
    let notes: Vec<&str> = run.stderr.lines().filter_map(|line| line.strip_prefix("note: ")).collect();
    assert!(notes[0].starts_with(&format!("ncfix {}, ", env!("CARGO_PKG_VERSION"))), "{notes:?}");
    for expected in [
        "read part.mpf: program",
        &format!("read {demo}: machine file, --machine"),
        "read job.toml: set-up file, --setup",
        "read warm.toml: state, --state",
        "dialect of part.mpf: sinumerik, the controller of the machine file",
        "read L7.SPF: subprogram, in a folder that belongs to the program",
    ] {
        assert_eq!(notes.iter().filter(|note| **note == expected).count(), 1, "{expected}\n{}", run.stderr);
    }
    // Without a machine file the name tells the dialect, or the option.
    let shop = Shop::new().file("part.ngc", "G21 G90 G0 X1\nM2\n");
    let run = shop.run(["check", "-v", "part.ngc"]).exits(0);
    run.says("note: dialect of part.ngc: rs274, by its name or first lines")
        .says("note: machine: the demo machine, embedded");
    let run = shop.run(["check", "-v", "part.ngc", "--dialect", "fanuc"]);
    run.says("note: dialect of part.ngc: fanuc, --dialect");
    // And nothing of all this without the switch.
    assert!(!shop.run(["check", "part.ngc"]).exits(0).stderr.contains("note:"));
}

#[test]
fn tables_that_are_active_are_among_the_files() {
    let table = "$AN_CEC_INPUT_AXIS[0]=(AX1)\n";
    let text = std::fs::read_to_string(machine("demo")).unwrap();
    let text = text.replace("[machine]\n", "[machine]\nactive_tables = [\"CEC.INI\"]\n");
    let shop = Shop::new().file("part.mpf", GOOD).file("m.toml", text).file("CEC.INI", table);
    shop.run(["-v", "check", "part.mpf", "--machine", "m.toml"]).says("CEC.INI: compensation tables");
}

#[test]
fn a_program_of_another_control_is_told_once_at_the_top() {
    let demo = machine("demo");
    let program = repository("samples/programs/fanuc/fixtures.nc").display().to_string();
    let shop = Shop::new();
    let run = shop.run(["check", &program, "--machine", &demo]).exits(3);
    let first = run.stderr.lines().next().unwrap();
    assert!(first.starts_with("help: ") && first.contains("reads like Fanuc"), "{}", run.stderr);
    assert!(first.contains("(the controller of the machine file): try --dialect fanuc"), "{first}");
    assert!((1..=3).contains(&run.stderr.matches("error[").count()), "{}", run.stderr);
    // Nothing is lost: all are counted, in the JSON, and drawn for whoever means it.
    let json = shop.run(["check", &program, "--machine", &demo, "--json"]).exits(3).json();
    let count = json["diagnostics"].as_array().unwrap().len();
    assert!(count > 5, "{json}");
    run.says(&format!("{count} errors")).says("not shown: 4 more errors of this file");
    let run = shop.run(["check", &program, "--machine", &demo, "--dialect", "sinumerik"]).exits(3);
    // Repeated ones are drawn once.
    let drawn = run.stderr.matches("error[").count();
    assert!(drawn > 3 && drawn <= count && run.stderr.contains("also in line"), "{}", run.stderr);
    run.says(&format!("{count} errors"));
}

/// Runs a command line on a terminal of its own; what the terminal got, and how long it took.
fn on_a_terminal(shop: &Shop, words: &[&str]) -> Option<(String, Duration)> {
    let script = Command::new("script").arg("--version").output();
    if !script.is_ok_and(|output| String::from_utf8_lossy(&output.stdout).contains("util-linux")) {
        // Nothing else here makes a terminal for another program.
        return None;
    }
    let mut line = env!("CARGO_BIN_EXE_ncfix").to_owned();
    words.iter().for_each(|word| line.push_str(&format!(" '{word}'")));
    let started = Instant::now();
    let mut command = Command::new("script");
    command.args(["-qec", &line, "/dev/null"]).current_dir(shop.path("")).env_remove("NCFIX_MACHINE");
    let output = command.stdin(std::process::Stdio::null()).output().unwrap();
    Some((String::from_utf8_lossy(&output.stdout).into_owned(), started.elapsed()))
}

#[test]
fn long_work_shows_that_it_goes_on_where_somebody_sees_it() {
    // Long enough on any computer: a loop grows until it takes more than a second.
    let program = |turns: u64| {
        format!("N10 R1=0\nN20 WHILE R1<{turns}\nN30 R1=R1+1\nN40 ENDWHILE\nN50 G90 G71 G0 X0 Y0 Z50\nN60 M30\n")
    };
    let demo = machine("demo");
    let words = ["check", "loop.mpf", "--max-blocks", "1000000000", "--machine", &demo];
    let mut turns = 200_000;
    let (shop, seen) = loop {
        let shop = Shop::new().file("loop.mpf", program(turns));
        let Some((seen, took)) = on_a_terminal(&shop, &words) else { return };
        if took > Duration::from_millis(1500) {
            break (shop, seen);
        }
        turns *= 2;
    };
    assert!(seen.contains("\rcheck: 0.5 s") || seen.contains("\rcheck: 0.6 s"), "{seen:?}");
    // The line is taken away before the result.
    assert!(seen.contains("\r\u{1b}[Kloop.mpf: understood and executed"), "{seen:?}");
    let (quiet, _) =
        on_a_terminal(&shop, &["-q", "check", "loop.mpf", "--max-blocks", "1000000000", "--machine", &demo]).unwrap();
    assert_eq!(quiet, "");
    // No terminal, no line; and none for what is short.
    let run = shop.run(words).exits(0);
    assert!(!run.stderr.contains('\r'), "{:?}", run.stderr);
    let short = Shop::new().file("loop.mpf", program(10));
    let (seen, _) = on_a_terminal(&short, &words).unwrap();
    assert!(!seen.contains("check: "), "{seen:?}");
}
