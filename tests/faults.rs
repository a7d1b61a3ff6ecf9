//! Faults while a file is written: a full disk, a folder that cannot be written, a killed process, two at once. The output is the old file
//! or the new one, never a piece; and an input stays what it was.
#![cfg(target_os = "linux")]

use std::fs;
use std::io::{BufRead as _, BufReader, Write as _};
use std::os::unix::process::ExitStatusExt as _;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::cli_calibrate::{circles, simulate};
use crate::support::Shop;

/// Kills of a short run; `NCFIX_KILLS` says how many others.
const KILLS: u32 = 200;
const OLD: &[u8] = b"; the file of yesterday\nM30\n";
const SIGTERM: i32 = 15;
const SIGXFSZ: i32 = 25;

/// A program with so many lines, which lie on a wavy circle.
fn program(lines: u32, phase: f64) -> String {
    let mut text = String::from("G90 G54 G0 X0 Y0 Z0\nG1 F1000\n");
    for k in 0..lines {
        let turn = phase + f64::from(k) * 0.02;
        text += &format!("X{:.4} Y{:.4}\n", 60.0 * turn.cos(), 60.0 * turn.sin());
    }
    text + "M30\n"
}

/// A shop with a program, an output of yesterday, and what the program shall become.
fn shop(lines: u32) -> (Shop, Vec<u8>) {
    let shop = Shop::new().file("in.mpf", program(lines, 0.0));
    shop.run(["in.mpf", "-o", "out.mpf"]).exits(0);
    let new = shop.bytes("out.mpf");
    assert!(new.len() > 20 * lines as usize && new.ends_with(b"M30\n"));
    fs::write(shop.path("out.mpf"), OLD).unwrap();
    (shop, new)
}

/// Files of the folder but those that a kill may leave behind.
fn lasting(shop: &Shop) -> Vec<String> {
    let mut names = shop.names();
    names.retain(|name| !(name.starts_with(".ncfix-") && name.ends_with(".tmp")));
    names
}

/// A small generator (SplitMix64).
fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mut mixed = *state;
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((mixed ^ (mixed >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

#[test]
fn a_kill_leaves_the_old_file_or_the_new_one() {
    let kills = std::env::var("NCFIX_KILLS").ok().and_then(|text| text.parse().ok()).unwrap_or(KILLS);
    let (shop, new) = shop(3000);
    let input = shop.bytes("in.mpf");
    let command = || {
        let mut command = shop.command(["in.mpf", "-o", "out.mpf"]);
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        command
    };
    let start = Instant::now();
    for _ in 0..5 {
        assert!(command().status().unwrap().success());
    }
    let whole_s = start.elapsed().as_secs_f64() / 5.0;
    let (mut state, mut old, mut done, mut between) = (7, 0, 0, 0);
    for kill in 0..kills {
        fs::write(shop.path("out.mpf"), OLD).unwrap();
        let mut child = command().spawn().unwrap();
        std::thread::sleep(Duration::from_secs_f64(1.3 * whole_s * random(&mut state)));
        child.kill().unwrap();
        let was_killed = child.wait().unwrap().signal().is_some();
        let found = shop.bytes("out.mpf");
        assert!(found == OLD || found == new, "kill {kill}: a piece of {} bytes", found.len());
        assert!(was_killed || found == new);
        assert_eq!(lasting(&shop), ["in.mpf", "out.mpf"]);
        old += u32::from(found == OLD);
        done += u32::from(found == new);
        between += u32::from(shop.names().len() > 2);
        for name in shop.names().into_iter().filter(|name| name.ends_with(".tmp")) {
            fs::remove_file(shop.path(&name)).unwrap();
        }
    }
    assert!(shop.bytes("in.mpf") == input);
    if let Ok(path) = std::env::var("NCFIX_KILLS_REPORT") {
        let text = format!("{kills} kills: {old} left the old file, {done} the new one, {between} a .tmp beside it\n");
        fs::write(path, text).unwrap();
    }
    // The moments hit both sides.
    assert!(old > kills / 20 && done > kills / 50, "{old} old, {done} new of {kills}");
}

#[test]
fn a_full_disk_is_said_and_leaves_the_old_file() {
    let (shop, _) = shop(3000);
    shop.run(["in.mpf", "-o", "/dev/full"]).exits(2).says("cannot write /dev/full: No space left on device");
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    let output = shop.command(["in.mpf", "-o", "-"]).stdout(full).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("cannot write to standard output: No space left on device"), "{said}");
    // A limit of the system on the size of files: the write fails, or the process ends where nobody listens to the signal.
    for (ignored, code) in [("trap '' XFSZ; ", Some(2)), ("", None)] {
        let line = format!("{ignored}ulimit -f 8; exec \"$0\" in.mpf -o out.mpf");
        let mut limited = Command::new("sh");
        limited.args(["-c", &line, env!("CARGO_BIN_EXE_ncfix")]).current_dir(shop.path("")).stdin(Stdio::null());
        let output = limited.output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), code, "{said}");
        match code {
            Some(_) => assert!(said.contains("cannot write out.mpf: File too large"), "{said}"),
            None => assert_eq!(output.status.signal(), Some(SIGXFSZ)),
        }
        assert!(shop.bytes("out.mpf") == OLD);
        assert_eq!(shop.names(), ["in.mpf", "out.mpf"]);
    }
}

/// A disk of its own that is too small; only where this system lets a test have one.
#[test]
fn a_small_disk_is_full_in_the_middle() {
    let (shop, new) = shop(3000);
    fs::create_dir(shop.path("disk")).unwrap();
    let on_disk = |size: &str, line: &str| {
        let line = format!("mount -t tmpfs -o size={size} none disk && printf old > disk/out.mpf || exit 77; {line}");
        let mut command = Command::new("unshare");
        command.args(["-rm", "sh", "-c", &line, env!("CARGO_BIN_EXE_ncfix")]).current_dir(shop.path(""));
        command.stdin(Stdio::null()).output()
    };
    let line = "\"$0\" in.mpf -o disk/out.mpf; echo $? $(cat disk/out.mpf) $(ls -A disk)";
    let Ok(output) = on_disk("64k", line) else { return };
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    if output.status.code() != Some(0) {
        // Without the right to mount, the tests of /dev/full and of the limit have said it.
        return;
    }
    let said = text(&output.stderr);
    assert_eq!(text(&output.stdout), "2 old out.mpf\n", "{said}");
    assert!(said.contains("cannot write disk/out.mpf: No space left on device"), "{said}");
    // One disk has room for the text once: there, what is kept until all is known lies beside the new file.
    let line = "\"$0\" in.mpf -o disk/out.mpf; echo $? $(wc -c < disk/out.mpf) $(ls -A disk)";
    let output = on_disk("16m", line).unwrap();
    assert_eq!(text(&output.stdout), format!("0 {} out.mpf\n", new.len()), "{}", text(&output.stderr));
}

#[test]
fn folders_that_cannot_be_written_are_said() {
    let (shop, _) = shop(10);
    // Not even the administrator makes files there.
    shop.run(["in.mpf", "-o", "/proc/out.mpf"]).exits(2).says("cannot write /proc/out.mpf: ");
    shop.run(["in.mpf", "-o", "/sys/out.mpf"]).exits(2).says("cannot write /sys/out.mpf: ");
    shop.run(["in.mpf", "-o", "missing/out.mpf"]).exits(2).says("there is no such file or folder");
    shop.run(["in.mpf", "-o", "in.mpf/out.mpf"]).exits(2).says("cannot write in.mpf/out.mpf: ");
    let mut permissions = fs::metadata(shop.path("out.mpf")).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(shop.path("out.mpf"), permissions).unwrap();
    shop.run(["in.mpf", "-o", "out.mpf"]).exits(2).says("cannot write out.mpf: it is write-protected");
    assert!(shop.bytes("out.mpf") == OLD);
    assert_eq!(shop.names(), ["in.mpf", "out.mpf"]);
}

/// What is written beside a program or a machine file is written with it, or neither is.
#[test]
fn a_page_that_cannot_be_written_leaves_everything_as_it_was() {
    let shop = circles().file("in.mpf", program(10, 0.0)).file("out.mpf", OLD).file("new.toml", OLD);
    simulate(&shop, "plan.csv", "circles.csv", "0.3um", "5");
    let calibrate = ["calibrate", "circles.csv", "--machine", "start.toml", "--model", "model.txt", "-o", "new.toml"];
    let diagnose = ["diagnose", "circles.csv", "--machine", "start.toml", "-o", "new.toml"];
    let (names, before) = (shop.names(), shop.bytes("in.mpf"));
    for page in ["/dev/full", "/proc/page.html"] {
        let said = format!("cannot write {page}: ");
        shop.run(["in.mpf", "-o", "out.mpf", "--review", page]).exits(2).says(&said);
        shop.run(["in.mpf", "--in-place", "--review", page]).exits(2).says(&said);
        shop.run([&calibrate[..], &["--report", page]].concat()).exits(2).says(&said);
        shop.run([&calibrate[..], &["--svg", "/proc/pictures"]].concat()).exits(2).says("cannot write /proc/pictures");
        shop.run([&diagnose[..], &["--report", page]].concat()).exits(2).says(&said);
        assert_eq!(shop.names(), names, "{page}");
        assert!(shop.bytes("out.mpf") == OLD && shop.bytes("new.toml") == OLD, "{page}");
        assert!(shop.bytes("in.mpf") == before, "{page}");
    }
    // With a page that can be written all is written.
    shop.run([&diagnose[..], &["--report", "page.html"]].concat()).exits(0);
    assert!(shop.bytes("new.toml") != OLD && shop.path("page.html").exists());
}

#[test]
fn several_runs_on_one_output_leave_one_of_their_texts() {
    let shop = Shop::new().file("a.mpf", program(2000, 0.0)).file("b.mpf", program(1500, 1.0));
    let whole = ["a.mpf", "b.mpf"].map(|name| {
        shop.run([name, "-o", "out.mpf"]).exits(0);
        shop.bytes("out.mpf")
    });
    for _ in 0..5 {
        let runs: Vec<_> = (0..8)
            .map(|k| {
                let mut command = shop.command([["a.mpf", "b.mpf"][k % 2], "-o", "out.mpf"]);
                command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
            })
            .collect();
        // A reader sees a whole text at any time.
        let mut written = 0;
        for mut run in runs {
            let found = shop.bytes("out.mpf");
            assert!(whole.contains(&found), "{} bytes", found.len());
            match run.wait().unwrap().code() {
                Some(0) => written += 1,
                // It found a newer text than at its start, and leaves it.
                Some(4) => {}
                other => panic!("{other:?}"),
            }
        }
        assert!(written > 0);
        assert!(whole.contains(&shop.bytes("out.mpf")));
        assert_eq!(shop.names(), ["a.mpf", "b.mpf", "out.mpf"]);
    }
}

#[test]
fn a_request_to_end_and_a_reader_that_goes_are_obeyed() {
    let (shop, _) = shop(300_000);
    let mut child = shop.command(["in.mpf", "-o", "out.mpf"]).stdin(Stdio::null()).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(40));
    assert!(Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap().success());
    let start = Instant::now();
    let status = child.wait().unwrap();
    assert_eq!(status.signal(), Some(SIGTERM), "{status:?}");
    assert!(start.elapsed() < Duration::from_secs(2));
    assert!(shop.bytes("out.mpf") == OLD);
    // `| head -1`: no complaint, and no endless run.
    for arguments in [["in.mpf", "-o", "-"], ["snc", "in.mpf", "--quiet"]] {
        let mut child = shop.command(arguments).stdin(Stdio::null()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        assert!(!line.is_empty());
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(0) && !said.contains("error"), "{:?} {said}", output.status);
    }
}

#[test]
fn an_input_that_goes_away_or_never_ends_is_no_harm() {
    let shop = Shop::new().file("in.mpf", program(100, 0.0));
    shop.run(["in.mpf", "-o", "whole.mpf"]).exits(0);
    assert!(Command::new("mkfifo").arg(shop.path("pipe")).status().unwrap().success());
    // A pipe that delivers slowly; the file has gone when it is corrected.
    let mut child =
        shop.command(["pipe", "-o", "out.mpf", "--dialect", "sinumerik"]).stdin(Stdio::null()).spawn().unwrap();
    let mut pipe = fs::File::options().write(true).open(shop.path("pipe")).unwrap();
    fs::remove_file(shop.path("pipe")).unwrap();
    for piece in shop.bytes("in.mpf").chunks(700) {
        pipe.write_all(piece).unwrap();
        std::thread::sleep(Duration::from_millis(3));
    }
    drop(pipe);
    assert!(child.wait().unwrap().success());
    let moves =
        |name: &str| shop.text(name).lines().filter(|line| line.contains('X')).map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(moves("out.mpf"), moves("whole.mpf"));
    // Not there at all, a folder, a file that is no text.
    shop.run(["gone.mpf", "-o", "no.mpf"]).exits(2).says("cannot read gone.mpf: there is no such file or folder");
    shop.run([".", "-o", "no.mpf"]).exits(2).says("it is a folder");
    assert!(!shop.path("no.mpf").exists());
}

/// No output replaces what the run has read, by whatever option or program, and no two outputs are one file.
#[test]
fn what_was_read_is_never_replaced() {
    let machine = fs::read(crate::support::machine("demo")).unwrap();
    let shop =
        circles().file("m.toml", &machine).file("setup.toml", "[zero_offset.G54]\nX_mm = 1\nY_mm = 0\nZ_mm = 0\n");
    let shop = shop.file("in.mpf", "G90 G54 G0 X10 Y10 Z100\nL7\nM30\n").file("L7.SPF", "G1 X20 F500\nM17\n");
    simulate(&shop, "plan.csv", "circles.csv", "0.3um", "5");
    shop.run(["in.mpf", "-o", "out.mpf", "--machine", "m.toml"]).exits(0);
    let calibrate = ["calibrate", "circles.csv", "--machine", "start.toml", "--model", "model.txt"];
    let names = shop.names();
    let before: Vec<Vec<u8>> = names.iter().map(|name| shop.bytes(name)).collect();
    let verify = ["verify", "in.mpf", "out.mpf", "--machine", "m.toml", "--setup", "setup.toml"];
    let diff = ["diff", "in.mpf", "out.mpf", "--machine", "m.toml", "--setup", "setup.toml"];
    let fix = ["in.mpf", "-o", "new.mpf", "--machine", "m.toml"];
    for (command, end) in [
        (&verify[..], &["--report", "m.toml"][..]),
        (&verify, &["--report", "setup.toml"]),
        (&verify, &["--report", "L7.SPF"]),
        (&diff, &["--html", "m.toml"]),
        (&diff, &["--html", "setup.toml"]),
        (&fix, &["--review", "L7.SPF"]),
        (&calibrate, &["-o", "new.toml", "--report", "model.txt"]),
        (&calibrate, &["-o", "model.txt"]),
        (&calibrate, &["-o", "new.toml", "--svg", "new.toml"]),
        (&["max-step", "--machine", "m.toml"], &["--svg", "new.svg", "--report", "new.svg"]),
    ] {
        let run = shop.run([command, end].concat());
        let says = ["would overwrite", "two outputs of this run", "--svg needs a folder"];
        let is_said = says.iter().any(|reason| run.stderr.contains(reason));
        assert!([2, 4].contains(&run.code) && is_said, "{command:?} {end:?}: {}", run.stderr);
        assert_eq!(shop.names(), names, "{command:?} {end:?}");
        for (name, bytes) in names.iter().zip(&before) {
            assert!(shop.bytes(name) == *bytes, "{command:?} {end:?}: {name}");
        }
    }
    // A device refuses before anything else is there; `/dev/stdout` is a pipe here.
    shop.run([&fix[..1], &["-o", "/dev/full", "--review", "page.html", "--machine", "m.toml"]].concat()).exits(2);
    assert_eq!(shop.names(), names);
    let piped = shop.run(["in.mpf", "-o", "/dev/stdout", "--machine", "m.toml"]).exits(0).stdout;
    assert!(piped.contains("M30"), "{piped}");
    // Beside a link the original stays under the name of what the link leads to.
    std::os::unix::fs::symlink("in.mpf", shop.path("link.mpf")).unwrap();
    shop.run(["link.mpf", "--in-place", "--review", "page.html", "--machine", "m.toml"]).exits(0);
    assert!(shop.path("in.mpf.bak").exists() && shop.text("page.html").contains("in.mpf.bak"));
}
