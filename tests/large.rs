//! Large programs, of which only a page of the tree is there at a time: the same result as with all of it, in little memory.

use std::fmt::Write as _;
use std::process::Stdio;
use std::time::Duration;

use crate::support::Shop;

/// So many lines are more than 8 MiB, from which on pages are read.
const LINES: usize = 400_000;

/// A program of `LINES` moves on a wavy spiral.
fn program(head: &str, end: &str, number: bool) -> String {
    let mut text = String::from(head);
    for k in 0..LINES {
        let turn = k as f64 * 0.004;
        let radius = 60.0 + 20.0 * (turn * 0.0137).sin();
        if number && k % 3 == 0 {
            write!(text, "N{} ", k + 1).unwrap();
        }
        let (x, y, z) = (radius * turn.cos(), radius * turn.sin(), 5.0 * (turn * 0.31).sin());
        writeln!(text, "X{x:.4} Y{y:.4} Z{z:.4}").unwrap();
    }
    text + end
}

/// Numbers that are no places: the flat stream without the last lines of its program.
fn stream(shop: &Shop, name: &str, dialect: &str) -> Vec<String> {
    let run = shop.run(["snc", name, "--dialect", dialect]).exits(0);
    let lines: Vec<String> = run.stdout.lines().map(str::to_owned).collect();
    assert!(lines.len() > LINES, "{}", lines.len());
    lines
}

#[test]
fn pages_give_the_same_stream_as_the_whole() {
    // A label, a jump, an O-word, a number that does not rise at the end keep the whole tree; nothing else differs.
    let cases = [
        ("sinumerik", "G90 G54 G0 X0 Y0 Z0\nDEF REAL HUB=2.5 ; depth\nG1 F=HUB*400 Z=-HUB\n", "M30\n", "ENDE: M30\n"),
        (
            "fanuc",
            "%\nO1234 (SPIRAL)\nG90 G54 G0 X0. Y0. Z0.\n#1=2.5 (DEPTH)\nG1 Z-#1 F1000.\n",
            "M30\n%\n",
            "GOTO 7\nN7 M30\n%\n",
        ),
        (
            "rs274",
            "G90 G54 G21 G0 X0 Y0 Z0\n#<depth>=2.5\nG1 Z[-#<depth>] F1000\n",
            "M2\n",
            "o100 if [0]\no100 endif\nM2\n",
        ),
        ("grundig", "%PM9001\nN9001 (SPIRAL)\nG90 G0 X0 Y0 Z0\nG1 Z-2.5 F1000\n", "M30\n", "N2 M30\n"),
    ];
    for (dialect, head, end, whole) in cases {
        let number = dialect != "rs274";
        let shop =
            Shop::new().file("paged.nc", program(head, end, number)).file("whole.nc", program(head, whole, number));
        let [paged, other] = ["paged.nc", "whole.nc"].map(|name| stream(&shop, name, dialect));
        let same = paged.iter().zip(&other).take_while(|(one, other)| one.replace("paged.nc", "whole.nc") == **other);
        assert!(same.count() > LINES, "{dialect}");
    }
}

/// Most memory that a run has at a time, KiB.
#[cfg(target_os = "linux")]
fn memory(shop: &Shop, arguments: &[&str]) -> u64 {
    let mut child = shop.command(arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let status = format!("/proc/{}/status", child.id());
    let mut most = 0;
    while child.try_wait().unwrap().is_none() {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        most = line.and_then(|line| line.trim().trim_end_matches(" kB").parse().ok()).unwrap_or(most);
        std::thread::sleep(Duration::from_millis(2));
    }
    assert!(child.wait().unwrap().success());
    most
}

#[cfg(target_os = "linux")]
#[test]
fn memory_goes_with_the_text() {
    let head = "G90 G54 G0 X0 Y0 Z0\nG1 F1000\n";
    let shop = Shop::new()
        .file("paged.mpf", program(head, "M30\n", true))
        .file("whole.mpf", program(head, "ENDE: M30\n", true));
    let text_kb = shop.bytes("paged.mpf").len() as u64 / 1024;
    let [paged, whole] =
        ["paged.mpf", "whole.mpf"].map(|name| memory(&shop, &["fix", name, "-o", &format!("{name}.out")]) - text_kb);
    // What stands in memory beside the text: less than 64 MB, however long it is; a tree of all of it has more than 100 bytes a line.
    assert!(paged < 32 * 1024 && whole > paged + LINES as u64 * 100 / 1024, "{paged} {whole}");
}

#[test]
fn a_fault_at_the_end_of_a_large_program_is_found_at_its_place() {
    let text = program("G90 G54 G0 X0 Y0 Z0\nG1 F1000\n", "X1 Y(\nM30\n", true);
    let shop = Shop::new().file("p.mpf", text);
    let run = shop.run(["fix", "p.mpf", "-o", "o.mpf"]).exits(3);
    assert!(run.stderr.contains(&format!("p.mpf:{}:", LINES + 3)), "{}", run.stderr);
    assert!(!shop.path("o.mpf").exists());
}

/// A loop that could go on for ever: what its passes leave behind is written and forgotten, whatever the number of threads.
#[cfg(target_os = "linux")]
#[test]
fn passes_of_a_loop_leave_nothing_in_memory() {
    let looped = |passes: u32| {
        format!(
            "DEF INT LAPS\nG90 G54 G0 X0 Y0 Z0\nG1 F1000\nWHILE LAPS<{passes}\nX=100+50*SIN(LAPS) Y=100+50*COS(LAPS) ; pass\nX0 Y0\nLAPS=LAPS+1\nENDWHILE\nM30\n"
        )
    };
    let shop = Shop::new().file("short.mpf", looped(2_000)).file("long.mpf", looped(40_000));
    for threads in ["1", "3"] {
        let [short, long] = ["short.mpf", "long.mpf"].map(|name| {
            memory(&shop, &["fix", name, "-o", "out.mpf", "--threads", threads, "--max-blocks", "1000000"])
        });
        assert!(long < short + 2 * 1024, "{threads} threads: {short} KiB, {long} KiB");
    }
}

#[test]
fn any_number_of_threads_writes_the_same() {
    let shop = Shop::new()
        .file("paged.mpf", program("G90 G54 G0 X0 Y0 Z0\nG1 F1000\n", "M30\n", true))
        .file("faulty.mpf", "G90 G54 G0 X0 Y0 Z0\nG1 X10 F1000\nX2000\nX20\nX3000\nY=1/0\nM30\n");
    let runs = ["1", "2", "3"].map(|threads| {
        let name = format!("{threads}.mpf");
        shop.run(["fix", "paged.mpf", "-o", &name, "--threads", threads]).exits(0);
        let faulty = shop.run(["fix", "faulty.mpf", "-o", "no.mpf", "--threads", threads]).exits(4);
        assert!(!shop.path("no.mpf").exists());
        (shop.bytes(&name), faulty.stderr.clone())
    });
    assert!(runs.iter().all(|run| *run == runs[0]));
    // Without --threads too, which takes several for a program as long as this.
    shop.run(["fix", "paged.mpf", "-o", "any.mpf"]).exits(0);
    assert!(shop.bytes("any.mpf") == runs[0].0);
}
