//! Speed of feeding by the built program: a pseudo-terminal whose other end acknowledges at once, with the buffers of
//! Grbl and of grblHAL. The bench prints lines per second and the delay from an answer to the next line, as in `ncfix
//! feed --json`. For comparison it measures the system alone: the pseudo-terminal with as many lines per round trip,
//! and the calls that every line needs. With `--test` the program is short, and no limits apply.

#![allow(clippy::print_stdout, reason = "figures are what a bench is for")]

use std::io::{Read as _, Write as _};
use std::path::Path;
use std::process::{Command, ExitCode};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use serialport::{SerialPort as _, TTYPort};

/// A control: its link, the blocks and bytes of its buffers, and its time for a line.
type Control = (&'static str, &'static str, Duration);
const AT_ONCE: Duration = Duration::ZERO;
const PACED: Duration = Duration::from_millis(1);

/// Answers every line, and the requests of Grbl.
fn acknowledge(mut port: TTYPort, buffers: &str, pause: Duration, is_over: &AtomicBool) {
    let mut bytes = [0; 4096];
    let mut line = Vec::new();
    let mut answer = Vec::new();
    while !is_over.load(Ordering::Relaxed) {
        let Ok(count) = port.read(&mut bytes) else { continue };
        for &byte in &bytes[..count] {
            match byte {
                b'?' => answer.extend(format!("<Idle|MPos:0,0,0|Bf:{buffers}|FS:0,0>\r\n").bytes()),
                b'\n' if line == b"$I" => answer.extend(format!("[OPT:V,{buffers}]\r\nok\r\n").bytes()),
                b'\n' if pause > AT_ONCE => {
                    thread::sleep(pause);
                    let _ = port.write_all(b"ok\n");
                }
                b'\n' => answer.extend(b"ok\n"),
                _ => line.push(byte),
            }
            if byte == b'\n' {
                line.clear();
            }
        }
        while !answer.is_empty() {
            match port.write(&answer) {
                Ok(count) => _ = answer.drain(..count),
                Err(_) => break,
            }
        }
    }
}

/// Lines per second of the pseudo-terminal alone, with a number of lines per round trip.
fn alone(lines: usize, trips: usize) -> f64 {
    let Some((master, mut slave)) = pair() else { return f64::NAN };
    let is_over = Arc::new(AtomicBool::new(false));
    let over = Arc::clone(&is_over);
    let control = thread::spawn(move || acknowledge(master, "15,128", AT_ONCE, &over));
    let _ = slave.set_timeout(Duration::from_secs(1));
    let text = b"G1 X100.000 Y20\n".repeat(lines);
    let started = Instant::now();
    let mut bytes = [0; 4096];
    for _ in 0..trips {
        let mut left = 3 * lines;
        if slave.write_all(&text).is_err() {
            return f64::NAN;
        }
        while left > 0 {
            let Ok(count) = slave.read(&mut bytes) else { return f64::NAN };
            left = left.saturating_sub(count);
        }
    }
    let speed = (lines * trips) as f64 / started.elapsed().as_secs_f64();
    is_over.store(true, Ordering::Relaxed);
    let _ = control.join();
    speed
}

/// The calls that every line needs, from an answer to the next bytes: read, record, query the queue, write; µs.
fn calls_alone(folder: &Path, count: usize) -> Option<[f64; 3]> {
    let (master, mut slave) = pair()?;
    let is_over = Arc::new(AtomicBool::new(false));
    let over = Arc::clone(&is_over);
    let control = thread::spawn(move || acknowledge(master, "15,128", PACED, &over));
    let mut journal = std::fs::File::create(folder.join("calls")).ok()?;
    let mut bytes = [0; 64];
    let mut took = Vec::with_capacity(count);
    slave.write_all(b"G1 X0\n").ok()?;
    for _ in 0..count {
        slave.set_timeout(Duration::from_secs(1)).ok()?;
        let _count = slave.read(&mut bytes).ok()?;
        let started = Instant::now();
        journal.write_all(&[b'\n'; 47]).ok()?;
        slave.bytes_to_write().ok()?;
        slave.write_all(b"G1 X199.5923 Y91.0054 Z4.9815\n").ok()?;
        took.push(started.elapsed().as_secs_f64() * 1e6);
    }
    is_over.store(true, Ordering::Relaxed);
    let _ = control.join();
    took.sort_by(f64::total_cmp);
    Some([count / 2, count * 99 / 100, count - 1].map(|at| took[at]))
}

/// Both ends of a pseudo-terminal; the first one waits for a millisecond at most.
fn pair() -> Option<(TTYPort, TTYPort)> {
    let (mut master, slave) = TTYPort::pair().ok()?;
    master.set_timeout(Duration::from_millis(1)).ok()?;
    Some((master, slave))
}

/// Feeds a program to a control and prints the speed; false if it did not end successfully.
fn feed((link, buffers, pause): Control, program: &Path) -> bool {
    let Some((master, slave)) = pair() else {
        println!("no pseudo-terminal here");
        return true;
    };
    let name = slave.name().unwrap_or_default();
    drop(slave);
    let is_over = Arc::new(AtomicBool::new(false));
    let over = Arc::clone(&is_over);
    let control = thread::spawn(move || acknowledge(master, buffers, pause, &over));
    let machine = concat!(env!("CARGO_MANIFEST_DIR"), "/samples/machines/knee_mill.toml");
    let output = Command::new(env!("CARGO_BIN_EXE_ncfix"))
        .arg("feed")
        .arg(program)
        .args(["--machine", machine, "--link", link, "--port", &name])
        .args(["--json", "--allow-starvation", "--step", "2000mm"])
        .output()
        .expect("the program runs");
    let _ = std::fs::remove_file(program.with_extension("ngc.journal"));
    is_over.store(true, Ordering::Relaxed);
    let _ = control.join();
    let said = String::from_utf8_lossy(&output.stdout);
    let end = said.lines().last().and_then(|line| serde_json::from_str::<serde_json::Value>(line).ok());
    let Some(end) = end.filter(|end| end["ended"] == "done") else {
        println!("it did not end well: {said}{}", String::from_utf8_lossy(&output.stderr));
        return false;
    };
    let (lines, seconds) = (end["acknowledged"].as_f64().unwrap_or(0.0), end["time_s"].as_f64().unwrap_or(f64::NAN));
    println!(
        "{link}, {pause:?} a line: {lines} lines in {seconds:.2} s: {:.0} lines/s; delay {} µs (middle, 99 %, longest)",
        lines / seconds,
        end["delay_us"]
    );
    true
}

fn main() -> ExitCode {
    let is_test = std::env::args().any(|argument| argument == "--test");
    let (count, trips) = if is_test { (2000, 20) } else { (200_000, 5000) };
    let folder = std::env::temp_dir().join(format!("ncfix-feed-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for the program");
    let program = |name: &str, count: usize| {
        let mut text = "G21 G90 G17 G54\nG0 X0 Y0 Z5\nF3000\n".to_owned();
        (1..=count).for_each(|k| text += &format!("G1 X{}.{:03} Y{}\n", k % 200, k % 1000, k % 100));
        let path = folder.join(name);
        std::fs::write(&path, text).expect("the program is written");
        path
    };
    let [long, short] = [program("long.ngc", count), program("short.ngc", count / 20)];
    for lines in [2, 15] {
        println!("a pseudo-terminal alone, {lines} lines a round trip: {:.0} lines/s", alone(lines, trips));
    }
    let is_good = feed(("grbl", "15,128", AT_ONCE), &long) && feed(("grblhal", "35,1024", AT_ONCE), &long);
    if let Some([middle, most, longest]) = calls_alone(&folder, trips) {
        println!("the calls alone, {PACED:?} a line: [{middle:.1},{most:.1},{longest:.1}] µs");
    }
    let is_good = is_good && feed(("grblhal", "35,1024", PACED), &short);
    let _ = std::fs::remove_dir_all(&folder);
    if is_good { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
