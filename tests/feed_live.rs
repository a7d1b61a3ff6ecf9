//! Lines that reach a control while a job runs: commands that it executes as the program means them, lengths that fit its buffer in any temperature, and
//! subprograms as they were checked.

use std::io::{Read as _, Write as _};
use std::net::TcpListener;
use std::sync::{Arc, Mutex};
use std::thread;

use super::cli_feed::{passes, start};
use super::controls::{Faults, Grbl, Wired};
use super::support::{Shop, machine};

/// A router without errors whose Z drifts with one sensor.
const ROUTER: &str = "[machine]\nname = \"router\"\ntopology = \"wFYXZSt\"\ncontroller = \"rs274\"\n\
    [control]\nincrement_mm = 0.001\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 600]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 900]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-80, 0]\n\
    [[drift]]\ndirection = \"Z\"\nsensors = [{ name = \"T_head\", um_per_K = 4.0 }]\n\
    [zero_offset.G54]\nX_mm = 100\nY_mm = 100\nZ_mm = -60\n";

/// A Marlin with its lines, as `parser.cpp` and `gcode.cpp` say: the first word is the command, all others are its parameters.
#[derive(Debug, Default)]
struct Firmware {
    /// Commands without number and checksum.
    commands: Vec<String>,
    /// The words that it takes as parameters although they are commands.
    ignored: Vec<String>,
    unknown: Vec<String>,
    is_relative: bool,
    is_turning: bool,
    dwell_ms: f64,
}

impl Firmware {
    fn execute(&mut self, line: &str) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let (first, rest) = words.split_first().unwrap();
        self.commands.push(line.to_owned());
        self.ignored.extend(rest.iter().filter(|word| word.starts_with(['G', 'M', 'T'])).map(|&word| word.to_owned()));
        let parameter = |letter: char| rest.iter().find_map(|word| word.strip_prefix(letter)?.parse::<f64>().ok());
        // The digits before a point are the number of the command.
        let number: String = first[1..].chars().take_while(char::is_ascii_digit).collect();
        match (&first[..1], number.as_str()) {
            ("G", "90") => self.is_relative = false,
            ("G", "91") => self.is_relative = true,
            ("G", "4") => {
                self.dwell_ms += parameter('S').map_or_else(|| parameter('P').unwrap(), |seconds| seconds * 1e3)
            }
            ("M", "3" | "4") => self.is_turning = true,
            ("M", "5") => self.is_turning = false,
            ("G", "0" | "1" | "2" | "3" | "17" | "21" | "54") | ("M", "7" | "8" | "9" | "114" | "400") => {}
            _ => self.unknown.push(line.to_owned()),
        }
    }
}

/// Serves one job over TCP.
fn marlin() -> (String, Arc<Mutex<Firmware>>) {
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = format!("tcp:{}", server.local_addr().unwrap());
    let firmware = Arc::new(Mutex::new(Firmware { is_relative: true, ..Firmware::default() }));
    let shared = Arc::clone(&firmware);
    thread::spawn(move || {
        let (mut stream, _) = server.accept().unwrap();
        let (mut bytes, mut line) = ([0; 1024], Vec::new());
        while let Ok(count @ 1..) = stream.read(&mut bytes) {
            for &byte in &bytes[..count] {
                if byte != b'\n' {
                    line.push(byte);
                    continue;
                }
                let text = String::from_utf8(std::mem::take(&mut line)).unwrap();
                let (body, _) = text.rsplit_once('*').unwrap();
                let (_, words) = body.split_once(' ').unwrap();
                if let Some(mark) = words.strip_prefix("M118 ") {
                    stream.write_all(format!("{mark}\nok\n").as_bytes()).unwrap();
                    continue;
                }
                if !words.starts_with("M110") {
                    shared.lock().unwrap().execute(words);
                }
                stream.write_all(b"ok\n").unwrap();
            }
        }
    });
    (port, firmware)
}

/// Marlin reads one command of a line. With `G21 G90 …` in one line, G90 is lost, and a control in G91 moves by every position; `S1000 M3` is unknown; `M5`
/// after a position is lost; the P of G4 is in milliseconds; M30 deletes a file.
#[test]
fn marlin_gets_one_command_in_a_line() {
    let part = "G21 G90 G17 G54 G94\nS1000 M3\nG4 P0.25\nG0 Z10\nX0 Y0\nG1 Z-3 F300\nG1 X50 F1500\nY50\n\
                G2 X60 Y60 I10 J0\nM8\nG1 X0\nG0 Z10 M5\nM3\nG1 Z5\nM30\n";
    let shop = Shop::new().file("part.ngc", part).file("router.toml", ROUTER);
    let (port, firmware) = marlin();
    let arguments = ["feed", "part.ngc", "--machine", "router.toml", "--link", "marlin", "--port", &port];
    shop.run([&arguments[..], &["--allow-starvation"]].concat()).exits(0);
    let firmware = firmware.lock().unwrap();
    assert!(firmware.ignored.is_empty() && firmware.unknown.is_empty(), "{firmware:?}");
    // It stood in G91, its spindle is off at the end, and the dwell was a quarter of a second.
    assert!(!firmware.is_relative && !firmware.is_turning, "{firmware:?}");
    assert!((firmware.dwell_ms - 250.0).abs() < 1e-9, "{firmware:?}");
    let count = |text: &str| firmware.commands.iter().filter(|line| *line == text).count();
    assert_eq!([count("M3 S1000"), count("M5"), count("M8"), count("M9"), count("G1 Y50")], [2, 2, 1, 1, 1]);
    assert_eq!(count("G2 X60 Y60 I10 J0"), 1, "{firmware:?}");
    // Off before the move of its block, as in RS274/NGC.
    let at = |text: &str| firmware.commands.iter().position(|line| line == text).unwrap();
    assert_eq!(firmware.commands[at("M5") + 1], "G0 Z10");
}

/// A tool change, a reference motion, an offset: Marlin has other meanings of these words.
#[test]
fn words_with_another_meaning_are_not_sent_to_marlin() {
    for word in ["T1 M6", "G28", "G10 L2 P1 X0", "G61", "M62 P1"] {
        let part = format!("G21 G90 G17 G54\nG0 Z10\nG0 X0 Y0\nG1 Z-3 F300\nX50\nG0 Z10\n{word}\nG0 X1 Y1 Z10\nM30\n");
        let shop = Shop::new().file("part.ngc", part).file("router.toml", ROUTER);
        let arguments = ["feed", "part.ngc", "--machine", "router.toml", "--dry-run", "--allow-starvation", "--link"];
        shop.run([&arguments[..], &["marlin"]].concat()).exits(4).says("error[E0701]").says("Marlin");
        let run = shop.run([&arguments[..], &["grbl"]].concat());
        // M6 and M62 are not in the list of Grbl 1.1.
        match word {
            "T1 M6" | "M62 P1" => run.exits(4).says("error[E0701]").says("Grbl 1.1 does not have M6"),
            _ => run.exits(0),
        };
    }
}

/// README of Grbl 1.1, *List of Supported G-Codes*: no tool change, length by number, cycle, radius compensation, variable or O word. Each is named although
/// the first of them stands in more lines than are shown.
#[test]
fn words_that_grbl_lacks_are_named_before_the_first_byte() {
    let many = "T1 M6\nG0 X1 Y0 Z10\n".repeat(25);
    let part = format!(
        "G21 G90 G17 G54\nG0 Z10\nX0 Y0\nM7\n{many}G43 H1\nG0 Z9\nG98 G81 X1 Y1 Z-1 R2 F50\nG80\nG0 Z10\nM30\n"
    );
    let tool = "[[tool]]\nnumber = 1\nlength_mm = 0\nradius_mm = 2\n";
    let shop = Shop::new().file("part.ngc", part).file("router.toml", format!("{ROUTER}{tool}"));
    let arguments = ["feed", "part.ngc", "--machine", "router.toml", "--dry-run", "--allow-starvation", "--link"];
    let run = shop.run([&arguments[..], &["grbl"]].concat()).exits(4);
    for words in ["Grbl 1.1 does not have M6", "Grbl 1.1 does not have G43, H"] {
        assert_eq!(run.stderr.matches(words).count(), 1, "{words}: {}", run.stderr);
    }
    // Only with the option of the build: a warning.
    run.says("warning[W0241]").says("these words: M7");
}

/// `G1 X50 Y50 F1500` has 16 characters and can become `G1 X50 Y50 Z-3.001 F1500` with 24, if Z drifts and the control takes 22.
#[test]
fn a_line_that_temperatures_can_make_too_long_is_refused_before_the_first_byte() {
    let part = "G21 G90 G17 G54 G94\nS1000 M3\nG0 Z10\nG0 X0 Y0\nG1 Z-3 F300\nG1 X50 Y50 F1500\nG0 Z10\nM5\nM30\n";
    let sensors = "[source.log]\nkind = \"replay\"\npath = \"warm.csv\"\n[channel.T_head]\nsource = \"log\"\n";
    let link = |longest: u32| format!("name = \"own\"\nprotocol = \"grbl\"\n[text]\nlongest_line = {longest}\n");
    let shop = Shop::new()
        .file("part.ngc", part)
        .file("router.toml", ROUTER)
        .file("s.toml", sensors)
        .file("warm.csv", "t_s,T_head_C\n0,20\n1000,21\n")
        .file("short.toml", link(22))
        .file("long.toml", link(24));
    let arguments = ["feed", "part.ngc", "--machine", "router.toml", "--dry-run", "--allow-starvation", "--link"];
    shop.run([&arguments[..], &["short.toml"]].concat()).exits(0);
    let run = shop.run([&arguments[..], &["short.toml", "--sensors", "s.toml"]].concat()).exits(4);
    let run = run.says("error[E0701]").says("line 6 of the original").says("up to 24 characters");
    assert_eq!(run.stderr.matches("E0701").count(), 1, "{}", run.stderr);
    shop.run([&arguments[..], &["long.toml", "--sensors", "s.toml"]].concat()).exits(0);
}

/// A subprogram is called near the end of a long job. Somebody edits it while the job runs.
#[test]
fn a_subprogram_that_changes_during_a_job_reaches_the_control_as_it_was_checked() {
    let part = passes(60).replace("M5\nM30\n", "o<low> call\nM5\nM30\n");
    let low = |z: u32| format!("o<low> sub\nG0 X0 Y0\nG1 Z-{z} F300\nG1 Z2\nG0 Z50\no<low> endsub\nM2\n");
    let bench = Wired::at_line(Grbl::new(&Faults::default(), 0.003));
    let shop = Shop::new().file("part.ngc", part).file("low.ngc", low(2));
    let mill = machine("knee_mill");
    let arguments = ["feed", "part.ngc", "--machine", &mill, "--link", "grbl", "--port", &bench.name];
    let mut child = start(&shop, &[&arguments[..], &["--allow-starvation"]].concat());
    bench.wait_for(5);
    std::fs::write(shop.path("low.ngc"), low(9)).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(0), "{}", shop.text("stderr"));
    let executed = bench.executed();
    let depth = |line: &String| line.split(' ').find_map(|word| word.strip_prefix('Z')?.parse::<f64>().ok());
    let deepest = executed.iter().filter_map(depth).fold(0.0, f64::min);
    // Corrections of this machine are below 0.2 mm.
    assert!((deepest + 2.0).abs() < 0.2, "{deepest}");
}

/// 70 °F are 21 °C. A column that names another unit is not the value of the only channel in °C.
#[test]
fn a_number_after_the_names_of_other_columns_is_no_value() {
    let sensors = "poll_s = 0.1\nconfirm = 1\nmedian = 1\n[source.log]\nkind = \"file\"\npath = \"log.csv\"\n[channel.T_head]\nsource = \"log\"\n";
    let watch = |log: &str| {
        let shop = Shop::new().file("s.toml", sensors).file("log.csv", log);
        shop.run(["sensors", "s.toml", "--watch", "--for", "0.5"])
    };
    let run = watch("T_head_F\n70\n").exits(4);
    assert!(run.stdout.contains("no column of 'T_head_F'") && !run.stdout.contains("70.00"), "{}", run.stdout);
    assert!(watch("T_head=21 T_head=25\n").exits(4).stdout.contains("two values"));
    assert!(watch("T_head_C\n21\n").exits(0).stdout.contains("T_head 21.00"));
    // A sentence is not a line of names.
    assert!(watch("sensor 3 is ready\n21\n").exits(0).stdout.contains("T_head 21.00"));
}
