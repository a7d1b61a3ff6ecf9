//! How fast the built program feeds: a pseudo-terminal whose other end acknowledges at once. Lines a second and the delay from an answer to the next line,
//! as `ncfix feed --json` reports them. With `--test` a short program, without figures to hold.

#![allow(clippy::print_stdout, reason = "figures are what a bench is for")]

use std::io::{Read as _, Write as _};
use std::process::{Command, ExitCode};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use serialport::{SerialPort as _, TTYPort};

/// Answers every line at once, and what Grbl is asked for.
fn acknowledge(mut port: TTYPort, is_over: &AtomicBool) {
    let mut bytes = [0; 4096];
    let mut line = Vec::new();
    let mut answer = Vec::new();
    while !is_over.load(Ordering::Relaxed) {
        let Ok(count) = port.read(&mut bytes) else { continue };
        for &byte in &bytes[..count] {
            match byte {
                b'?' => answer.extend(b"<Idle|MPos:0,0,0|Bf:15,128|FS:0,0>\r\n"),
                b'\n' if line == b"$I" => answer.extend(b"[OPT:V,15,128]\r\nok\r\n"),
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

fn main() -> ExitCode {
    let is_test = std::env::args().any(|argument| argument == "--test");
    let count = if is_test { 2000 } else { 200_000 };
    let Ok((mut master, slave)) = TTYPort::pair() else {
        println!("no pseudo-terminal here");
        return ExitCode::SUCCESS;
    };
    let name = slave.name().unwrap_or_default();
    drop(slave);
    let _ = master.set_timeout(Duration::from_millis(1));
    let is_over = Arc::new(AtomicBool::new(false));
    let over = Arc::clone(&is_over);
    let control = thread::spawn(move || acknowledge(master, &over));
    let folder = std::env::temp_dir().join(format!("ncfix-feed-{}", std::process::id()));
    let program = folder.join("part.ngc");
    let mut text = "G21 G90 G17 G54\nG0 X0 Y0 Z5\nF3000\n".to_owned();
    (1..=count).for_each(|k| text += &format!("G1 X{}.{:03} Y{}\n", k % 200, k % 1000, k % 100));
    std::fs::create_dir_all(&folder).and_then(|()| std::fs::write(&program, text)).expect("a folder for the program");
    let machine = concat!(env!("CARGO_MANIFEST_DIR"), "/samples/machines/knee_mill.toml");
    let output = Command::new(env!("CARGO_BIN_EXE_ncfix"))
        .arg("feed")
        .arg(&program)
        .args([
            "--machine",
            machine,
            "--link",
            "grbl",
            "--port",
            &name,
            "--json",
            "--allow-starvation",
            "--step",
            "2000mm",
        ])
        .output()
        .expect("the program runs");
    is_over.store(true, Ordering::Relaxed);
    let _ = control.join();
    let _ = std::fs::remove_dir_all(&folder);
    let said = String::from_utf8_lossy(&output.stdout);
    let end = said.lines().last().and_then(|line| serde_json::from_str::<serde_json::Value>(line).ok());
    let Some(end) = end.filter(|end| end["ended"] == "done") else {
        println!("it did not end well: {said}{}", String::from_utf8_lossy(&output.stderr));
        return ExitCode::FAILURE;
    };
    let (lines, seconds) = (end["acknowledged"].as_f64().unwrap_or(0.0), end["time_s"].as_f64().unwrap_or(f64::NAN));
    println!(
        "{lines} lines in {seconds:.2} s: {:.0} lines/s; delay {} µs (middle, 99 %, longest)",
        lines / seconds,
        end["delay_us"]
    );
    ExitCode::SUCCESS
}
