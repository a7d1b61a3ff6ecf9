//! `ncfix snc`: the text of the flat stream on standard output or in a file.

use std::io::Read as _;

use crate::support::{Shop, machine};

#[test]
fn a_program_without_offset_and_tool_runs_in_machine_coordinates() {
    let shop =
        Shop::new().file("part.mpf", "N10 G90 G71 G0 X100 Y50.5 Z200\nN20 G1 X=IC(-10) F500\nN30 G4 F1.5\nN40 M30\n");
    let run = shop.run(["snc", "part.mpf", "--machine", &machine("demo")]).exits(0);
    assert_eq!(
        run.stdout,
        "; snc 1 machine=demo units=mm\nG0 X100 Y50.5 Z200 ;@1\nG1 X90 Y50.5 Z200 F500 ;@2\nG4 S1.5 ;@3\nM30 ;@4\n"
    );
}

#[test]
fn a_file_is_written_completely_or_not_at_all() {
    let shop =
        Shop::new().file("good.mpf", "N10 G90 G71 G0 X1 Y1 Z1\nN20 M30\n").file("bad.mpf", "N10 G0 X1\nN20 X=1/R1\n");
    shop.run(["snc", "good.mpf", "-o", "good.snc", "--machine", &machine("demo")]).exits(0);
    assert_eq!(shop.text("good.snc"), "; snc 1 machine=demo units=mm\nG0 X1 Y1 Z1 ;@1\nM30 ;@2\n");
    shop.run(["snc", "bad.mpf", "-o", "bad.snc", "--machine", &machine("demo")]).exits(4);
    assert_eq!(shop.names(), ["bad.mpf", "good.mpf", "good.snc"]);
}

#[test]
fn the_input_is_no_output() {
    let shop = Shop::new().file("part.mpf", "N10 G0 X1\n");
    shop.run(["snc", "part.mpf", "-o", "part.mpf", "--machine", &machine("demo")]).exits(4).says("error[E0310]");
    assert_eq!(shop.text("part.mpf"), "N10 G0 X1\n");
}

#[test]
fn a_program_that_never_ends_can_be_looked_at() {
    let text = "N10 G90 G71 G0 X0 Y0 Z0\nN20 WHILE TRUE\nN30 G1 X=IC(0.001) F500\nN40 ENDWHILE\n";
    let shop = Shop::new().file("part.mpf", text);
    let mut child = shop.command(["snc", "part.mpf", "--machine", &machine("demo")]).spawn().unwrap();
    let mut head = [0_u8; 64];
    let mut stdout = child.stdout.take().unwrap();
    stdout.read_exact(&mut head).unwrap();
    assert!(head.starts_with(b"; snc 1"));
    // The reader goes away: that is no failure.
    drop(stdout);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn a_program_that_never_ends_stops_at_the_limit() {
    let text = "N10 G90 G71 G0 X0 Y0 Z0\nN20 WHILE TRUE\nN30 G1 X=IC(0.001) F500\nN40 ENDWHILE\n";
    let shop = Shop::new().file("part.mpf", text);
    let run = shop.run(["snc", "part.mpf", "--max-blocks", "1000", "--machine", &machine("demo")]).exits(4);
    assert!(run.stdout.lines().count() < 1010);
    run.says("error[E0214]");
}

#[test]
fn a_flat_stream_is_read_and_printed_again() {
    let shop = Shop::new().copy("samples/programs/sinumerik/helix_bore.mpf");
    let demo = machine("demo");
    let first = shop.run(["snc", "helix_bore.mpf", "--machine", &demo]).exits(0);
    let shop = shop.file("flat.snc", &first.stdout);
    let second = shop.run(["snc", "flat.snc", "--machine", &demo]).exits(0);
    assert_eq!(first.stdout, second.stdout);
    let shop = shop.file("bad.snc", "; snc 1 machine=demo units=mm\nG0 X1 Y0 Z0\nG9 X1\n");
    let bad = shop.run(["snc", "bad.snc", "--machine", &demo]).exits(3);
    assert!(bad.stderr.contains("bad.snc:3:1"), "{}", bad.stderr);
}

/// Its words look like those of a control, but contain zero offset and tool already: a correction of it would displace the part by both.
#[test]
fn a_flat_stream_is_no_program_of_a_control() {
    let demo = machine("demo");
    for head in ["; snc 1 machine=demo units=mm", "\u{feff}\n; snc 1", "; snc 1 machine=other units=mm"] {
        let shop = Shop::new().file("flat.snc", format!("{head}\nG0 X100 Y200 Z300 ;@1\nG1 X400 Y200 Z300 F500 ;@2\n"));
        let commands: [&[&str]; 7] = [
            &["fix", "flat.snc", "-o", "o.mpf"],
            &["check", "flat.snc"],
            &["verify", "flat.snc", "flat.snc"],
            &["diff", "flat.snc", "flat.snc"],
            &["max-step", "flat.snc"],
            &["fix", "flat.snc", "--dialect", "rs274", "-o", "o.mpf"],
            &["check", "--syntax", "flat.snc", "--dialect", "fanuc"],
        ];
        for command in commands {
            let run = shop.run(command.iter().copied().chain(["--machine", &demo]).filter(|word| !word.is_empty()));
            let line = if head.starts_with(';') { "flat.snc:1:1" } else { "flat.snc:2:1" };
            run.exits(3).says("error[E0118]").says("flat stream").says(line);
            assert!(!shop.path("o.mpf").exists(), "{command:?}");
        }
    }
}

#[test]
fn the_first_arc_begins_at_the_given_start() {
    // G54 lies at X-60 Y-40, so the start is X60 Y50 there.
    let shop = Shop::new().file("arc.ngc", "G21 G17 G90\nG2 X80 Y50 I10 J0 F100\nM2\n");
    let run = shop.run(["snc", "arc.ngc", "--machine", &machine("knee_mill"), "--start", "X0,Y10,Z5,A0"]).exits(0);
    assert!(run.stdout.contains("G2 X20 Y10 Z5 A0 I10 J0"), "{}", run.stdout);
}

/// A flat stream names every axis in each move, and belongs to one machine.
#[test]
fn a_flat_stream_that_is_not_whole_is_refused() {
    let demo = machine("demo");
    let head = "; snc 1 machine=demo units=mm\n";
    let whole = format!("{head}G0 X1 Y2 Z3 ;@1\nG1 X4 Y2 Z3 F500 ;@2\n");
    let read = |text: &str| Shop::new().file("flat.snc", text).run(["snc", "flat.snc", "--machine", &demo]);
    // Blank lines and a byte order mark before the head change nothing.
    for before in ["", "\n", " \n\r\n", "\u{feff}"] {
        assert_eq!(read(&format!("{before}{whole}")).exits(0).stdout, whole, "{before:?}");
    }
    let first = read(&format!("{head}G0 X1 Y2 ;@1\nG1 X4 Y2 Z3 F500 ;@2\n")).exits(3);
    first.says("the position of Z is missing").says("flat.snc:2:1");
    let later = read(&format!("{head}G0 X1 Y2 Z3 ;@1\nG1 X4 Z3 F500 ;@2\n")).exits(3);
    later.says("the position of Y is missing").says("flat.snc:3:1");
    read(&format!("{head}G0 X1 Y2 Z3 A0 ;@1\n")).exits(3).says("the machine has no axis A");
    let other = read(&whole.replace("machine=demo", "machine=mill")).exits(4);
    assert_eq!(other.stdout, "");
    other.says("error[E0323]").says("is for the machine mill");
    read("; snc 1\nG0 X1 Y2 Z3\n").exits(3).says("names no machine");
}
