//! Controls that are silent for a while and have lost nothing: a spindle that runs up, axes that rest before the last lines are read, a tape reader that nobody
//! has started. A job that really is lost leaves axes that cannot start by themselves.

use std::io::Read as _;
use std::net::TcpListener;
use std::thread;
use std::time::{Duration, Instant};

use ncfix_base::source::{FileId, Source};
use ncfix_dnc::feed::{Ended, PROFILES, Profile, Sender};

use super::cli_feed::{passes, signal, start};
use super::controls::{self, Cable, Control as _, Faults, Grbl, Notes, Planned};
use super::support::{Shop, machine, repository};

fn profile(name: &str) -> Profile {
    let (_, text) = PROFILES.iter().find(|(known, _)| *known == name).unwrap();
    Profile::read(&Source::new(FileId(0), name, text.as_bytes().to_vec()).unwrap()).unwrap()
}

fn faults() -> Faults {
    Faults { most_bytes: 40, latency_s: 0.002, ..Faults::default() }
}

/// Sends the lines; returns how it ended, and what was carried out, also long after the end.
fn sent(name: &str, lines: &[&str], control: Grbl, busy_s: f64) -> (Ended, Vec<String>) {
    let profile = profile(name);
    let mut notes = Notes::default();
    let mut planned = Planned::new(lines.len(), busy_s);
    planned.lines = lines.iter().map(|line| line.as_bytes().to_vec()).collect();
    let mut cable = Cable::new(control, faults(), 1);
    let mut sender = Sender::new((profile.protocol.create)(&profile).unwrap(), profile.window.system_bytes, &mut notes);
    let ended = controls::run(&mut sender, &mut cable, &mut planned);
    let executed = cable.control.executed().iter().map(|line| String::from_utf8(line.clone()).unwrap()).collect();
    (ended, executed)
}

const PLUNGE: &[&str] =
    &["G21 G90 G17 G54", "S12000 M3", "G0 Z10", "G0 X0 Y0", "G1 Z-1 F300", "G1 X0 Y2 F1500", "G0 Z10", "M30"];

fn running_up(seconds: f64) -> Grbl {
    let mut control = Grbl::new(&faults(), 0.01);
    control.runs_up_s = seconds;
    control
}

/// Grbl with a delay of its spindle reports idle and reads nothing for that time; `within_s` of the profile is 2 s.
#[test]
fn a_spindle_that_runs_up_is_no_lost_answer() {
    for (name, seconds) in [("grbl", 2.5), ("grbl", 5.0), ("grbl", 60.0), ("grblhal", 5.0)] {
        let (ended, executed) = sent(name, PLUNGE, running_up(seconds), 0.01);
        assert_eq!(ended, Ended::Done, "{name} {seconds}");
        assert_eq!(executed, PLUNGE, "{name} {seconds}");
    }
    // Without the buffer state in its reports, this can be seen for a limited time only.
    let (ended, executed) = sent("grbl", PLUNGE, running_up(5.0).that_tells_no_sizes(), 0.01);
    assert_eq!((ended, executed.len()), (Ended::Done, PLUNGE.len()));
}

/// The spindle takes longer than anything allows: the transfer ends, and what the control has not read does not move the tool afterwards.
#[test]
fn lines_of_a_lost_job_do_not_move_the_tool_by_themselves() {
    let (ended, executed) = sent("grbl", PLUNGE, running_up(40.0).that_tells_no_sizes(), 0.01);
    assert!(
        matches!(&ended, Ended::Lost(_, why) if why.contains("an answer was lost") && why.contains("feed hold (!)")),
        "{ended:?}"
    );
    assert!(executed.iter().all(|line| !line.contains('Z')), "{executed:?}");
}

/// Fifteen moves of half a second fill the planner for 7 s without an answer. Then the axes rest for 0.4 s before the line after them is read.
#[test]
fn a_single_report_of_rest_after_a_long_motion_is_no_lost_answer() {
    let mut lines: Vec<String> = (1..=20).map(|k| format!("G1 X{k} F1200")).collect();
    lines.extend(["S900 M3", "G1 X30", "M30"].map(str::to_owned));
    let lines: Vec<&str> = lines.iter().map(String::as_str).collect();
    let mut control = Grbl::new(&faults(), 0.5);
    control.runs_up_s = 0.4;
    let (ended, executed) = sent("grbl", &lines, control, 0.5);
    assert_eq!((ended, executed.len()), (Ended::Done, lines.len()));
}

/// A tape reader that nobody has started: nothing was sent, so the first Ctrl-C ends the wait.
#[test]
fn a_wait_for_the_first_xon_ends_at_the_first_signal() {
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = format!("tcp:{}", server.local_addr().unwrap());
    let reader = thread::spawn(move || {
        let (mut stream, _) = server.accept().unwrap();
        let mut all = Vec::new();
        let _ = stream.read_to_end(&mut all);
        all
    });
    // The dialogue alone matters here, so the link accepts any dialect.
    let text = std::fs::read_to_string(repository("crates/dnc/links/fanuc-rs232.toml")).unwrap();
    let any: Vec<&str> = text.lines().filter(|line| !line.starts_with("dialects")).collect();
    let shop = Shop::new().file("part.ngc", passes(1)).file("any.toml", any.join("\n"));
    let mill = machine("knee_mill");
    let arguments =
        ["feed", "part.ngc", "--machine", &mill, "--link", "any.toml", "--port", &port, "--allow-starvation"];
    let mut child = start(&shop, &[&arguments[..], &["--i-checked-the-machine-stands-still"]].concat());
    let from = Instant::now();
    while !shop.text("stderr").contains("waiting for XON: start reading at the control") {
        assert!(from.elapsed() < Duration::from_secs(60), "{}", shop.text("stderr"));
        thread::sleep(Duration::from_millis(10));
    }
    signal(&child, "INT");
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(shop.text("stderr").contains("no line was sent"), "{}", shop.text("stderr"));
    assert_eq!(reader.join().unwrap(), b"");
}
