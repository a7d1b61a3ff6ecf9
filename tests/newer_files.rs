//! Files that somebody writes while a run is under way: nothing newer is ever replaced.
//!
//! The machine file is a pipe: a run waits there, having read its program and having looked where it will write, until the test has changed
//! a file.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::archives::archive;
use crate::support::{Shop, machine};

const PART: &str = "N10 G17 G90 G71 G94\nN20 T5\nN30 M6\nN40 D1\nN50 G54 G0 X0 Y0 Z20\nN60 G1 X40 F500\nN70 M30\n";
/// The same length, so that only clock and content differ.
const NEWER: &str = "N10 G17 G90 G71 G94\nN20 T5\nN30 M6\nN40 D1\nN50 G54 G0 X0 Y0 Z20\nN60 G1 X41 F500\nN70 M30\n";

/// How long a run may take to come to the pipe.
const PATIENCE: Duration = Duration::from_secs(30);

/// A shop with a program, a table of positions, and a pipe where a machine file should be.
fn shop() -> Shop {
    let shop = Shop::new().file("part.mpf", PART).file("read.csv", "X,Y,Z\n1,2,3\n");
    assert!(Command::new("mkfifo").arg(shop.path("m.toml")).status().unwrap().success());
    shop
}

fn start(shop: &Shop, arguments: &[&str]) -> Child {
    // A run that reads its machine file twice would wait at the pipe for ever.
    let mut command = Command::new("timeout");
    command
        .arg("60")
        .arg(env!("CARGO_BIN_EXE_ncfix"))
        .current_dir(shop.path("."))
        .env_remove("NCFIX_MACHINE")
        .env("NO_COLOR", "1");
    command.args(arguments).args(["--machine", "m.toml"]);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Waits until a run waits for the machine file, does something, and lets the run go on.
fn meanwhile(shop: &Shop, run: Child, act: impl FnOnce()) -> Output {
    // A pipe opens for writing without waiting as soon as there is a reader.
    let begun = Instant::now();
    let pipe = loop {
        use std::os::unix::fs::OpenOptionsExt as _;
        const WITHOUT_WAITING: i32 = 0o4000;
        match fs::File::options().write(true).custom_flags(WITHOUT_WAITING).open(shop.path("m.toml")) {
            Ok(pipe) => break pipe,
            Err(_) if begun.elapsed() < PATIENCE => std::thread::sleep(Duration::from_millis(2)),
            Err(error) => panic!("nobody reads the machine file: {error}"),
        }
    };
    act();
    let text = fs::read(machine("demo")).unwrap();
    // The file is larger than a pipe may be.
    let waiting = fs::File::options().write(true).open(shop.path("m.toml")).unwrap();
    drop(pipe);
    std::io::Write::write_all(&mut &waiting, &text).unwrap();
    drop(waiting);
    run.wait_with_output().unwrap()
}

fn says(output: &Output, code: i32, words: &str) {
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{stderr}");
    assert!(stderr.contains(words), "{words}: {stderr}");
}

fn replace(path: &Path, text: &str) {
    let beside = path.with_extension("edited");
    fs::write(&beside, text).unwrap();
    fs::rename(beside, path).unwrap();
}

#[test]
fn a_program_that_changes_while_it_is_corrected_stays() {
    for by_rename in [false, true] {
        let shop = shop();
        let path = shop.path("part.mpf");
        let time = fs::metadata(&path).unwrap().modified().unwrap();
        let run = start(&shop, &["part.mpf", "--in-place"]);
        let output = meanwhile(&shop, run, || {
            if by_rename {
                replace(&path, NEWER);
            } else {
                fs::write(&path, NEWER).unwrap();
                // Somebody copies it back with its time: only the content tells.
                fs::File::options().write(true).open(&path).unwrap().set_modified(time).unwrap();
            }
        });
        says(&output, 4, "error[E0314]: part.mpf has changed since this run read it");
        assert_eq!(shop.text("part.mpf"), NEWER);
        assert_eq!(shop.names(), ["m.toml", "part.mpf", "read.csv"]);
    }
}

#[test]
fn a_program_that_stays_is_replaced() {
    let shop = shop();
    let run = start(&shop, &["part.mpf", "--in-place"]);
    says(&meanwhile(&shop, run, || {}), 0, "part.mpf.bak");
    assert_eq!(shop.text("part.mpf.bak"), PART);
    assert!(shop.text("part.mpf").contains("X40."), "{}", shop.text("part.mpf"));
    assert_eq!(shop.names(), ["m.toml", "part.mpf", "part.mpf.bak", "read.csv"]);
}

#[test]
fn of_two_runs_on_one_program_the_second_is_refused() {
    let shop = shop();
    let demo = machine("demo");
    let slow = start(&shop, &["part.mpf", "--in-place"]);
    let output = meanwhile(&shop, slow, || {
        shop.run(["part.mpf", "--in-place", "--machine", demo.as_str()]).exits(0);
    });
    says(&output, 4, "error[E0314]");
    assert_eq!(shop.text("part.mpf.bak"), PART);
    assert!(shop.text("part.mpf").contains("ncfix"), "{}", shop.text("part.mpf"));
    assert_eq!(shop.names(), ["m.toml", "part.mpf", "part.mpf.bak", "read.csv"]);
}

#[test]
fn a_program_that_is_gone_is_not_made_anew() {
    let shop = shop();
    let run = start(&shop, &["part.mpf", "--in-place"]);
    let output = meanwhile(&shop, run, || fs::remove_file(shop.path("part.mpf")).unwrap());
    says(&output, 4, "error[E0314]");
    assert_eq!(shop.names(), ["m.toml", "read.csv"]);
}

#[test]
fn every_output_is_spared_that_is_newer_than_the_start() {
    for (arguments, output) in [
        (&["part.mpf", "-o", "out"][..], "out"),
        (&["snc", "part.mpf", "-o", "out"], "out"),
        (&["correct-readings", "read.csv", "-o", "out"], "out"),
    ] {
        for before in [None, Some("older\n")] {
            let shop = shop();
            if let Some(text) = before {
                fs::write(shop.path(output), text).unwrap();
            }
            let run = start(&shop, arguments);
            let ended = meanwhile(&shop, run, || fs::write(shop.path(output), "somebody else\n").unwrap());
            let words = if before.is_some() { "out has changed since this run began" } else { "out was created after" };
            says(&ended, 4, words);
            assert_eq!(shop.text(output), "somebody else\n", "{arguments:?}");
            assert_eq!(shop.names(), ["m.toml", "out", "part.mpf", "read.csv"], "{arguments:?}");
        }
    }
}

#[test]
fn json_holds_the_diagnostic_and_no_figures() {
    let shop = shop();
    let run = start(&shop, &["part.mpf", "--in-place", "--json"]);
    let output = meanwhile(&shop, run, || fs::write(shop.path("part.mpf"), NEWER).unwrap());
    let json = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(4));
    assert!(json.contains("E0314") && !json.contains("\"after\":{"), "{json}");
}

#[test]
fn an_archive_is_not_replaced_by_one_of_its_programs() {
    let bytes = archive(&[("PART.MPF", "\\WKS.DIR\\PART.WPD\\", PART)]);
    let shop = Shop::new().file("SAVE.arc", bytes.clone());
    let demo = machine("demo");
    shop.run(["SAVE.arc", "--in-place", "--machine", demo.as_str()]).exits(2).says("is an archive of the control");
    assert_eq!(fs::read(shop.path("SAVE.arc")).unwrap(), bytes);
    assert_eq!(shop.names(), ["SAVE.arc"]);
}
