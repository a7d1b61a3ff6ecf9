//! Memory of a run: the text and at most 64 MB, whatever the text is made of.
#![cfg(target_os = "linux")]

use std::process::Stdio;

use crate::support::Shop;

/// Text of a case, bytes: with a thousandth of it a list of lines would not be seen beside 64 MB.
const TEXT: usize = 12 << 20;
/// Beside the text, KiB, as docs/reference/limits.md has it.
const BESIDE_KIB: u64 = 64 << 10;

/// Most memory that a run has at a time, KiB, by the kernel's own count.
fn memory(shop: &Shop, arguments: &[&str]) -> u64 {
    let mut child = shop.command(arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let status = format!("/proc/{}/status", child.id());
    let mut most = 0;
    while child.try_wait().unwrap().is_none() {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        most = line.and_then(|line| line.trim().trim_end_matches(" kB").parse().ok()).unwrap_or(most);
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    most
}

#[test]
fn memory_is_that_of_the_text_and_a_little_more() {
    // Dialect, head, what fills the file, tail.
    let cases: &[(&str, &str, &str, &str)] = &[
        ("sinumerik", "", ";\n", "G1 X1 F100\nM30\n"),
        ("sinumerik", "", "\n", "G1 X1 F100\nM30\n"),
        ("sinumerik", "", "%\n", "M30\n"),
        ("sinumerik", "", "?\n", "M30\n"),
        ("sinumerik", "X(\n", "; comment\n", "M30\n"),
        ("sinumerik", "", "N1\n", "M30\n"),
        ("sinumerik", "", "\u{1b}\n", "M30\n"),
        ("fanuc", "%\nO1\n", "()\n", "N10 G1 X1. F100.\nM30\n%\n"),
        ("fanuc", "", "(\n", "M30\n"),
        ("fanuc", "", "%\n", "M30\n"),
        ("fanuc", "%\n", "O1\nM99\n", "%\n"),
        ("fanuc", "%\nO1\n", "N1\n", "M30\n%\n"),
        ("rs274", "", ";\n", "G21 G1 X1 F100\nM2\n"),
        ("rs274", "", "(\n", "M2\n"),
        ("grundig", "%PM9001\nN9001\n", "(A)\n", "N1 G1 X1 F100\nN2 M30\n"),
        ("grundig", "%PM9001\n", "(A)\n", "N1 G1 X1 F100\nN2 M30\n"),
        ("grundig", "", "%PM1\n", ""),
    ];
    for (dialect, head, line, tail) in cases {
        let text = format!("{head}{}{tail}", line.repeat(TEXT / line.len()));
        let most = (text.len() as u64 >> 10) + BESIDE_KIB;
        let shop = Shop::new().file("part", text);
        let used = memory(&shop, &["check", "part", "--syntax-only", "--dialect", dialect]);
        assert!(used > 0 && used < most, "{dialect} {line:?}: {used} KiB, {most} KiB are allowed");
    }
}
