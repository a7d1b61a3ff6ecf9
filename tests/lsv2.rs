//! Transfers by LSV/2 to a control that keeps files: over a simulated cable with faults by script, and with the built program over TCP and a pseudo-terminal.

use std::io::{Read, Write};
use std::net::TcpListener;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use ncfix_base::source::{FileId, Source};
use ncfix_dnc::feed::{Ended, Event, Halt, LossKind, PROFILES, Patience, Profile, Sender};

use super::controls::{self, Cable, Control as _, Faults, Lsv2, Notes, Odd, Planned, Wired};
use super::support::{Run, Shop, machine};

const PATH: &str = "TNC:\\NCFIX.PM";

fn profile(name: &str) -> Profile {
    let (_, text) = PROFILES.iter().find(|(known, _)| *known == name).unwrap();
    let read = Profile::read(&Source::new(FileId(0), name, text.as_bytes().to_vec()).unwrap()).unwrap();
    // A person starts within a minute or never.
    let second = Duration::from_secs(1);
    Profile { patience: Patience { stall: 30 * second, hold: 60 * second }, ..read }
}

/// A transfer, and all that came of it.
struct Job {
    profile: Profile,
    ended: Ended,
    notes: Notes,
    planned: Vec<Vec<u8>>,
    control: Lsv2,
    may_have_run: bool,
}

impl Job {
    fn run(profile: Profile, control: Lsv2, lines: usize, busy_s: f64) -> Job {
        Job::run_until(profile, control, lines, busy_s, None)
    }

    /// The same; at `halt_s` a person stops it.
    fn run_until(profile: Profile, control: Lsv2, lines: usize, busy_s: f64, halt_s: Option<f64>) -> Job {
        let faults = Faults { most_bytes: 700, latency_s: 0.001, ..Faults::default() };
        let mut notes = Notes::default();
        let mut planned = Planned::new(lines, busy_s);
        let mut cable = Cable::new(control, faults, 1);
        let dialogue = (profile.protocol.create)(&profile).unwrap();
        let mut sender = Sender::new(dialogue, profile.window.system_bytes, &mut notes).patient(profile.patience);
        let ended = match halt_s {
            None => controls::run(&mut sender, &mut cable, &mut planned),
            Some(halt_s) => {
                let mut now_s = 0.0;
                loop {
                    let before_s = now_s;
                    now_s += 0.003;
                    assert!(now_s < 600.0);
                    cable.turn_to(now_s);
                    let now = Duration::from_secs_f64(now_s);
                    if before_s < halt_s && halt_s <= now_s {
                        assert!(sender.halt(Halt::Stop, now).is_some());
                        assert!(sender.halt(Halt::Hold, now).is_none());
                    }
                    if let Some(ended) = sender.step(now, &mut cable, &mut planned, &mut |_| ()).unwrap() {
                        break ended;
                    }
                }
            }
        };
        let may_have_run = sender.may_have_run();
        drop(sender);
        Job { profile, ended, notes, planned: planned.lines, control: cable.control, may_have_run }
    }

    fn says(&self, part: &str) -> &Job {
        let said = match &self.ended {
            Ended::Lost(_, why) | Ended::Fault(why) => why.clone(),
            other => format!("{other:?}"),
        };
        assert!(said.contains(part), "'{said}' does not say '{part}'");
        self
    }

    fn is_done(&self) -> &Job {
        assert_eq!(self.ended, Ended::Done, "{:?}", self.notes.events.last());
        self
    }

    fn has(&self, event: &Event) -> bool {
        self.notes.events.contains(event)
    }
}

#[test]
fn a_program_is_stored_read_back_started_by_a_person_and_counted_when_it_has_run() {
    for (name, control) in [("lsv2", Lsv2::over_network(0.01)), ("lsv2-serial", Lsv2::over_line(0.01))] {
        let job = Job::run(profile(name), control, 300, 0.01);
        job.is_done();
        assert_eq!(job.control.executed(), job.planned, "{name}");
        assert_eq!(job.control.files[PATH], job.planned, "{name}");
        for event in [Event::Acknowledged(300), Event::Checked(300), Event::Executed(300)] {
            assert!(job.has(&event), "{name}: {event:?}");
        }
        // Stored comes before read back, and executed is last.
        let place = |event: &Event| job.notes.events.iter().position(|other| other == event).unwrap();
        assert!(place(&Event::Acknowledged(300)) < place(&Event::Checked(300)));
        assert!(place(&Event::Checked(300)) < place(&Event::Executed(300)));
        let reports = |part: &str| {
            job.notes.events.iter().any(|event| matches!(event, Event::Reported(text) if text.contains(part)))
        };
        assert!(reports("a program runs, mode automatic, line ") && reports("X0.000") && reports("Z+20.000"), "{name}");
        assert_eq!(job.control.pressed, 0, "{name}");
    }
}

#[test]
fn a_control_that_is_not_at_rest_gets_no_line() {
    type Change = fn(&mut Lsv2);
    let changes: [(Change, &str); 10] = [
        (|control| control.status = 0, "a program runs"),
        (|control| control.status = 1, "is stopped"),
        (|control| control.status = 4, "is interrupted"),
        (|control| control.status = 5, "has an error"),
        (|control| control.status = 8, "undefined"),
        (|control| control.status = 9, "is not an answer"),
        (|control| control.mode = 2, "reference points"),
        (|control| control.mode = 5, "no operating mode"),
        (|control| control.drifts = true, "the axes move"),
        (|control| control.has_dnc = false, "refuses the login DNC"),
    ];
    for (change, says) in changes {
        for (name, control) in [("lsv2", Lsv2::over_network(0.01)), ("lsv2-serial", Lsv2::over_line(0.01))] {
            let job = Job::run(profile(name), with(control, change), 5, 0.01);
            job.says(says).says("the control has nothing of this program");
            assert!(job.notes.frozen.is_empty() && job.control.files.is_empty() && !job.may_have_run, "{name}: {says}");
        }
    }
}

fn with(mut control: Lsv2, change: fn(&mut Lsv2)) -> Lsv2 {
    change(&mut control);
    control
}

#[test]
fn a_file_that_exists_is_replaced_only_if_the_profile_says_so() {
    let control =
        || with(Lsv2::over_network(0.01), |control| _ = control.files.insert(PATH.into(), vec![b"OLD".to_vec()]));
    let job = Job::run(profile("lsv2"), control(), 20, 0.01);
    job.says("exists on the control").says("replace = true");
    assert_eq!(job.control.files[PATH], [b"OLD".to_vec()]);
    let mut own = profile("lsv2");
    own.file.replaces = true;
    let job = Job::run(own, control(), 20, 0.01);
    assert_eq!(job.is_done().control.executed(), job.planned);
}

#[test]
fn a_file_with_one_wrong_bit_is_deleted_and_nobody_can_start_it() {
    for (at, is_binary) in [(0, false), (700, false), (1500, true)] {
        let mut own = profile("lsv2");
        own.file.is_binary = is_binary;
        let mut control = Lsv2::over_network(0.01);
        control.damages = Some(at);
        let job = Job::run(own, control, 200, 0.01);
        job.says("differs from the program: line ").says("was deleted");
        assert!(job.control.files.is_empty() && job.control.executed().is_empty() && !job.may_have_run, "{at}");
    }
    // As a file of bytes it is stored as it is.
    let mut own = profile("lsv2");
    own.file.is_binary = true;
    Job::run(own, Lsv2::over_network(0.01), 200, 0.01).is_done();
}

#[test]
fn finished_without_the_run_of_this_file_is_no_evidence() {
    type Change = fn(&mut Lsv2);
    let changes: [(Change, &str); 7] = [
        (|control| control.cancels_at = Some(30), "was cancelled"),
        (|control| control.ends_idle = true, "did not report that the program has finished"),
        (|control| control.edits = true, "was changed: line 1"),
        (|control| control.starts_after_s = None, "no person has started the program for 60 s"),
        (|control| control.starts_path = Some("TNC:\\OTHER.PM".into()), "no person has started"),
        (|control| control.stop = Some((30, 1e9)), "the program stands for 60 s"),
        // It was finished before, by an earlier job.
        (|control| (control.status, control.starts_after_s) = (2, None), "no person has started"),
    ];
    for (change, says) in changes {
        let job = Job::run(profile("lsv2"), with(Lsv2::over_network(0.02), change), 100, 0.02);
        job.says(says).says("the control has the program");
        assert!(
            job.may_have_run && !job.notes.events.iter().any(|event| matches!(event, Event::Executed(_))),
            "{says}"
        );
    }
    // Lines that should take 0.2 s each take 0.02 s: the block search of a person, or another file.
    let job = Job::run(profile("lsv2"), Lsv2::over_network(0.02), 100, 0.2);
    job.says("not executed completely");
    // A stop and a start are a part of a run.
    let job =
        Job::run(profile("lsv2"), with(Lsv2::over_network(0.02), |control| control.stop = Some((30, 20.0))), 100, 0.02);
    let said: Vec<&str> = job.is_done().notes.events.iter().filter_map(said).collect();
    assert!(said.contains(&"a program is stopped in line 31") && said.contains(&"the program runs again"), "{said:?}");
}

fn said(event: &Event) -> Option<&str> {
    if let Event::Said(text) = event { Some(text) } else { None }
}

#[test]
fn an_older_control_without_options_is_served_as_far_as_it_goes() {
    let job =
        Job::run(profile("lsv2"), with(Lsv2::over_network(0.01), |control| control.has_secure_end = false), 300, 0.01);
    assert_eq!(job.is_done().control.executed(), job.planned);
    let job =
        Job::run(profile("lsv2"), with(Lsv2::over_network(0.01), |control| control.has_position = false), 300, 0.01);
    assert_eq!(job.is_done().control.executed(), job.planned);
    // Without the option for DNC the file is transferred and read back, and nothing is said of a run.
    let mut own = profile("lsv2");
    own.file.watches = false;
    assert!(!own.asks_idle() && profile("lsv2").asks_idle());
    let job = Job::run(
        own,
        with(Lsv2::over_network(0.01), |control| (control.has_dnc, control.starts_after_s) = (false, None)),
        300,
        0.01,
    );
    assert_eq!(job.is_done().control.files[PATH], job.planned);
    assert!(job.has(&Event::Checked(300)) && !job.has(&Event::Executed(300)) && job.control.executed().is_empty());
}

#[test]
fn whatever_the_control_answers_the_job_ends_with_one_reason() {
    let odds = [
        Odd::Error(23),
        Odd::Error(32),
        Odd::Error(53),
        Odd::PlainError,
        Odd::Silence,
        Odd::Half,
        Odd::Giant,
        Odd::Longer,
        Odd::Shorter,
        Odd::Other,
        Odd::Text,
        Odd::Twice,
        Odd::Data,
        Odd::Messages,
    ];
    // Telegrams, and how many of them there are before: the second R_RI is the mode, the third the selected program, then positions and the run.
    let steps = [
        ("A_LG", 0),
        ("R_VR", 0),
        ("R_PR", 0),
        ("C_CC", 0),
        ("C_CC", 1),
        ("A_LG", 1),
        ("R_RI", 0),
        ("R_RI", 1),
        ("R_RI", 2),
        ("R_RI", 3),
        ("R_RI", 4),
        ("A_LG", 2),
        ("R_FI", 0),
        ("C_FL", 0),
        ("S_FL", 0),
        ("S_FL", 1),
        ("T_FD", 0),
        ("R_FL", 0),
        ("T_OK", 0),
        ("T_OK", 2),
        ("R_RI", 8),
        ("R_RI", 9),
        ("R_RI", 10),
        ("R_FL", 1),
        ("A_LO", 0),
    ];
    let (mut lost, mut done) = (0, 0);
    for (name, skip) in steps {
        for odd in odds {
            for is_line in [false, true] {
                // On a serial line only whole telegrams reach this layer; faults of its frames have a test of their own.
                let is_frame = matches!(
                    odd,
                    Odd::Half | Odd::Giant | Odd::Longer | Odd::Shorter | Odd::Text | Odd::Twice | Odd::Data
                );
                if is_line && (is_frame || matches!(name, "R_PR")) {
                    continue;
                }
                let mut control = if is_line { Lsv2::over_line(0.01) } else { Lsv2::over_network(0.01) };
                control.odd = Some((name, skip, odd));
                let own = profile(if is_line { "lsv2-serial" } else { "lsv2" });
                let job = Job::run(own, control, 400, 0.01);
                let place = format!("{name} {skip} {odd:?} {is_line}: {:?}", job.ended);
                let reasons: Vec<&String> = job
                    .notes
                    .events
                    .iter()
                    .filter_map(|event| if let Event::Lost(_, why) = event { Some(why) } else { None })
                    .collect();
                match &job.ended {
                    Ended::Done => {
                        assert!(reasons.is_empty(), "{place}");
                        assert_eq!(job.control.executed(), job.planned, "{place}");
                        done += 1;
                    }
                    Ended::Lost(_, why) => {
                        assert_eq!(reasons, [why], "{place}");
                        // If no person can have started it, a file that stays is named.
                        let stays = job.control.files.contains_key(PATH);
                        assert!(job.may_have_run || !stays || why.contains("delete it there"), "{place}");
                        assert!(!job.has(&Event::Executed(400)), "{place}");
                        lost += 1;
                    }
                    _ => panic!("{place}"),
                }
                assert_eq!(job.control.pressed, 0, "{place}");
            }
        }
    }
    // Optional questions, and the logout, may fail.
    assert!(done > 20 && lost > 250, "{done} done, {lost} lost");
}

#[test]
fn blocks_of_a_serial_line_are_repeated_as_often_as_the_profile_allows() {
    for count in [1, 3, 4] {
        let job = Job::run(profile("lsv2-serial"), with_counts(count, 0), 200, 0.01);
        let other = Job::run(profile("lsv2-serial"), with_counts(0, count), 200, 0.01);
        for job in [job, other] {
            if count <= u64::from(job.profile.most_repeats) {
                assert_eq!(job.is_done().control.executed(), job.planned);
            } else {
                job.says("4 times").says("the state of the control is unknown");
                assert!(job.control.files.is_empty());
            }
        }
    }
}

fn with_counts(refuses_blocks: u64, says_bad_check: u64) -> Lsv2 {
    let mut control = Lsv2::over_line(0.01);
    (control.refuses_blocks, control.says_bad_check) = (refuses_blocks, says_bad_check);
    control
}

#[test]
fn a_stop_leaves_no_part_of_a_file() {
    let (mut without, mut with_file) = (0, 0);
    for hundredth in 1..240 {
        let halt_s = f64::from(hundredth) / 100.0;
        let job = Job::run_until(profile("lsv2"), Lsv2::over_network(0.02), 2000, 0.02, Some(halt_s));
        assert_eq!(job.ended, Ended::Stopped, "{halt_s}");
        match job.control.files.get(PATH) {
            Some(lines) => {
                assert!(*lines == job.planned && job.may_have_run, "{halt_s}");
                with_file += 1;
            }
            None => {
                assert!(!job.may_have_run && job.control.executed().is_empty(), "{halt_s}");
                without += 1;
            }
        }
    }
    assert!(without > 30 && with_file > 30, "{without} {with_file}");
}

#[test]
fn a_cut_connection_says_what_the_control_has_of_the_file() {
    let mut counts = [0; 3];
    for hundredth in 1..200 {
        let own = profile("lsv2");
        let unplugged_s = Some(f64::from(hundredth) / 100.0);
        let faults = Faults { most_bytes: 700, latency_s: 0.001, unplugged_s, ..Faults::default() };
        let (mut notes, mut planned) = (Notes::default(), Planned::new(2000, 0.02));
        let mut cable = Cable::new(Lsv2::over_network(0.02), faults, 1);
        let mut sender = Sender::new((own.protocol.create)(&own).unwrap(), own.window.system_bytes, &mut notes);
        let ended = controls::run(&mut sender, &mut cable, &mut planned);
        let Ended::Lost(LossKind::LinkGone, why) = &ended else { panic!("{hundredth}: {ended:?}") };
        let says =
            ["has nothing of this program", "an incomplete file TNC:\\NCFIX.PM may be", "the control has the program"];
        let place = says.iter().position(|part| why.contains(part)).unwrap_or_else(|| panic!("{hundredth}: {why}"));
        let stored = cable.control.files.get(PATH);
        assert!(why.starts_with("the link is gone") && sender.may_have_run() == (place == 2), "{hundredth}: {why}");
        // More than it says is never there; the last telegram may have been lost.
        assert!(place != 0 || stored.is_none(), "{hundredth}: {why}");
        assert!(place != 2 || stored.is_some_and(|lines| *lines == planned.lines), "{hundredth}: {why}");
        counts[place] += 1;
    }
    assert!(counts.iter().all(|count| *count > 3), "{counts:?}");
}

#[test]
fn a_program_that_cannot_be_made_to_its_end_is_not_sent() {
    let own = profile("lsv2");
    let (mut notes, mut planned) = (Notes::default(), Planned::new(50, 0.01));
    planned.lines[40] = b"G1 X1\x07".to_vec();
    let mut cable = Cable::new(Lsv2::over_network(0.01), Faults { most_bytes: 700, ..Faults::default() }, 1);
    let mut sender = Sender::new((own.protocol.create)(&own).unwrap(), own.window.system_bytes, &mut notes);
    let ended = controls::run(&mut sender, &mut cable, &mut planned);
    assert!(matches!(&ended, Ended::Fault(why) if why.contains("line 41")), "{ended:?}");
    assert!(!sender.may_have_run() && cable.control.files.is_empty());
}

/// Lines of a file in the control.
fn file(control: &Wired<Lsv2>, path: &str) -> Vec<String> {
    let control = control.shared.lock().unwrap();
    control.files[path].iter().map(|line| String::from_utf8(line.clone()).unwrap()).collect()
}

const PART: &str = "%PM9013\nN9013 (PLATE)\nN1 G17 G71 G90\nN2 G54\nN3 S800 M3\nN4 G0 X10 Y10 Z50\nN5 G1 Z-1 F1500\nN6 G1 X60\nN7 G0 Z50\nN8 M30\n";

fn feed(shop: &Shop, port: &str, more: &[&str]) -> Run {
    let mill = machine("universal_mill");
    let arguments = ["feed", "part.pm", "--machine", &mill, "--port", port, "--to", "TNC:\\PART.PM"];
    shop.run([&arguments[..], more].concat())
}

#[test]
fn the_program_speaks_lsv2_over_tcp_and_over_a_pseudo_terminal() {
    for (link, bench) in
        [("lsv2", Wired::at_network(Lsv2::over_network(0.3))), ("lsv2-serial", Wired::at_line(Lsv2::over_line(0.3)))]
    {
        let shop = Shop::new().file("part.pm", PART);
        let run = feed(&shop, &bench.name, &["--link", link, "--json"]);
        assert_eq!(run.code, 0, "{run:?}");
        let forecast: serde_json::Value = serde_json::from_str(run.stdout.lines().next().unwrap()).unwrap();
        assert_eq!(forecast["file"], "TNC:\\PART.PM");
        let end: serde_json::Value = serde_json::from_str(run.stdout.lines().last().unwrap()).unwrap();
        assert_eq!((&end["ended"], &end["executed"]), (&"done".into(), &end["lines"]), "{end}");
        assert!(end["control"].as_str().is_some_and(|text| text.contains("finished") && text.contains(" X")), "{end}");
        // The file is the corrected program with its header, without comments and stamp.
        let mill = machine("universal_mill");
        let fixed = shop.run(["part.pm", "-o", "corrected.pm", "--machine", &mill]);
        assert_eq!(fixed.code, 0, "{fixed:?}");
        let corrected = shop.text("corrected.pm");
        // Block numbers differ, because the stamp has some in the written program.
        let plain = |line: &str| {
            let words = line.split('(').next().unwrap().trim();
            let is_numbered = words.starts_with('N') && words != "N9013";
            let rest = if is_numbered { words.split_once(' ').map_or("", |(_, rest)| rest) } else { words };
            rest.to_owned()
        };
        let lines = |all: Vec<String>| -> Vec<String> {
            all.iter().map(|line| plain(line)).filter(|line| !line.is_empty()).collect()
        };
        let expected = lines(corrected.lines().map(str::to_owned).collect());
        let found = lines(file(&bench, "TNC:\\PART.PM"));
        assert_eq!(found[..2], ["%PM9013", "N9013"], "{link}");
        assert!(found.len() > 8 && expected.ends_with(&found[4..]), "{link}: {found:?} {expected:?}");
        assert!(found[0].starts_with("%PM"), "{found:?}");
        let journal = shop.text("part.pm.journal");
        assert!(journal.contains(" E done") && journal.contains(" W at ") && journal.contains(" X "), "{journal}");
    }
}

#[test]
fn a_refused_file_leaves_a_journal_that_a_new_job_replaces() {
    let shop = Shop::new().file("part.pm", PART);
    let mut full = Lsv2::over_network(0.01);
    full.odd = Some(("S_FL", 0, Odd::Error(53)));
    let run = feed(&shop, &Wired::at_network(full).name, &["--link", "lsv2"]);
    assert!(run.code == 6 && run.stderr.contains("no free space") && run.stderr.contains("was deleted"), "{run:?}");
    assert!(run.stderr.contains("was not started") && !run.stderr.contains("ncfix resume"), "{run:?}");
    assert!(shop.text("part.pm.journal").contains(" E not started, lost: "));
    let resumed = shop.run(["resume", "part.pm.journal"]);
    assert!(resumed.code == 2 && resumed.stderr.contains("no line of the job"), "{resumed:?}");
    // The control is cut off during the run: it has the program, and it is not known how far it came.
    let bench = Wired::at_network(with(Lsv2::over_network(1.0), |control| control.starts_after_s = Some(0.2)));
    let shared = Arc::clone(&bench.shared);
    let name = bench.name.clone();
    let cutter = thread::spawn(move || {
        let from = Instant::now();
        while shared.lock().unwrap().executed().is_empty() {
            assert!(from.elapsed() < Duration::from_secs(60));
            thread::sleep(Duration::from_millis(5));
        }
        drop(bench);
    });
    let run = feed(&shop, &name, &["--link", "lsv2"]);
    cutter.join().unwrap();
    assert!(run.code == 5 && run.stderr.contains("the link is gone"), "{run:?}");
    let resumed = shop.run(["resume", "part.pm.journal", "--clearance", "60mm"]);
    assert!(resumed.code == 2 && resumed.stderr.contains("block search"), "{resumed:?}");
    let again = feed(&shop, &name, &["--link", "lsv2"]);
    assert!(again.code == 4 || again.code == 5, "{again:?}");
}

#[test]
fn paths_sensors_and_dialects_are_checked_before_the_port_is_opened() {
    let sensors = "[source.log]\nkind = \"replay\"\npath = \"warm.csv\"\n[channel.T_head]\nsource = \"log\"\n";
    let shop = Shop::new()
        .file("part.pm", PART)
        .file("part.ngc", "G21 G90 G17 G54\nG0 X0 Y0 Z50\nG1 X10 F100\nM30\n")
        .file("warm.csv", "t_s,T_head_C\n0,20\n600,21\n")
        .file("s.toml", sensors)
        .file("lines.toml", "name = \"lines\"\nprotocol = \"grbl\"\n[file]\npath = 'TNC:\\A.PM'\n")
        .file("none.toml", "name = \"none\"\nprotocol = \"lsv2\"\n");
    let mill = machine("universal_mill");
    let dry =
        |more: &[&str]| shop.run([&["feed", "part.pm", "--machine", &mill, "--dry-run", "--link"][..], more].concat());
    let run = dry(&["lsv2", "--to", "TNC:\\PART.PM", "--sensors", "s.toml"]);
    assert!(
        run.code == 0 && run.stderr.contains("W0703") && run.stdout.contains("sends the file TNC:\\PART.PM"),
        "{run:?}"
    );
    for path in ["", "PART.PM", "PLC:\\A.PM", "TNC:\\", "TNC:\\A\"B.PM", "TNC:\\Ä.PM", "TNC:\\A\n.PM"] {
        let run = dry(&["lsv2", "--to", path]);
        assert!(run.code == 2 && run.stderr.contains("a path"), "{path}: {run:?}");
    }
    let run = dry(&["grundig-v24", "--to", "TNC:\\PART.PM"]);
    assert!(run.code == 2 && run.stderr.contains("omit --to"), "{run:?}");
    let run = dry(&["none.toml"]);
    assert!(run.code == 2 && run.stderr.contains("with --to"), "{run:?}");
    let run = dry(&["lines.toml"]);
    assert!(run.stderr.contains("omit [file]"), "{run:?}");
    let mill = machine("knee_mill");
    let run = shop.run(["feed", "part.ngc", "--machine", &mill, "--dry-run", "--link", "lsv2"]);
    assert!(run.code == 4 && run.stderr.contains("E0701") && run.stderr.contains("grundig"), "{run:?}");
    // Without questions for the state a person has to look.
    let own = "name = \"own\"\nprotocol = \"lsv2\"\n[file]\nwatch = false\n";
    let shop = Shop::new().file("part.pm", PART).file("own.toml", own);
    let run = feed(&shop, "tcp:127.0.0.1:1", &["--link", "own.toml"]);
    assert!(run.code == 4 && run.stderr.contains("E0705"), "{run:?}");
}

/// Peers that are not a control: they close, or say anything for as long as they are heard.
#[test]
fn a_port_that_is_no_control_ends_the_job_at_once() {
    for (says, code) in [
        (&b""[..], 5),
        (b"SSH-2.0-OpenSSH_9.2\r\n", 6),
        (b"\0\0\0\0T_OK\0\0\0\0T_OK\0\0\0\0T_OK", 6),
        (&[0xff; 4096], 6),
    ] {
        let server = TcpListener::bind("127.0.0.1:0").unwrap();
        let name = format!("tcp:{}", server.local_addr().unwrap());
        let thread = thread::spawn(move || {
            let (mut stream, _) = server.accept().unwrap();
            let _ = stream.read(&mut [0; 64]);
            let _ = stream.write_all(says);
            // An empty text closes at once.
            let mut rest = [0; 64];
            while !says.is_empty() && stream.read(&mut rest).is_ok_and(|count| count > 0) {}
        });
        let shop = Shop::new().file("part.pm", PART);
        let from = Instant::now();
        let run = feed(&shop, &name, &["--link", "lsv2"]);
        thread.join().unwrap();
        assert!(run.code == code && from.elapsed() < Duration::from_secs(30), "{run:?}");
        assert!(run.stderr.contains("no line was sent"), "{run:?}");
    }
}
