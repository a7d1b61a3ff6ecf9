//! Sources of live readings on this computer: files, standard input, commands, logs that are played again; and the command that shows them.

use std::fs::{self, File};
use std::io::Write as _;
use std::path::Path;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use ncfix_base::source::{FileId, Source};
use ncfix_dnc::sense::{
    Action, ChannelFault, ChannelReading, ChannelState, Config, LineReader, Panel, PanelVerdict, SourceReport, stamp,
};

use proptest::prelude::*;

use crate::support::Shop;

pub(crate) fn open(text: &str, base: &Path) -> Panel {
    let source = Source::new(FileId(0), "S.toml", text.as_bytes().to_vec()).unwrap();
    let config = Config::read(&source).unwrap_or_else(|findings| panic!("{findings:?}"));
    Panel::open(&config, base).unwrap_or_else(|findings| panic!("{findings:?}"))
}

/// The clock of all panels: it goes on from one wait to the next.
fn clock() -> Duration {
    static START: OnceLock<Instant> = OnceLock::new();
    START.get_or_init(Instant::now).elapsed()
}

/// Takes until a condition holds.
#[track_caller]
pub(crate) fn until(panel: &mut Panel, what: &str, is_so: impl Fn(&[&ChannelReading]) -> bool) {
    let start = clock();
    loop {
        panel.take(clock());
        let readings: Vec<&ChannelReading> = panel.channels().collect();
        if is_so(&readings) {
            return;
        }
        assert!(clock() - start < Duration::from_secs(30), "{what}: {readings:?}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[track_caller]
pub(crate) fn until_value(panel: &mut Panel, expected_c: f64) {
    until(panel, &format!("{expected_c} °C"), |readings| {
        readings[0].value_c.is_some_and(|value_c| (value_c - expected_c).abs() < 1e-9)
            && readings[0].state == ChannelState::Good
    });
}

#[track_caller]
pub(crate) fn until_fault(panel: &mut Panel, fault: ChannelFault) {
    until(panel, &format!("{fault:?}"), |readings| readings[0].state == ChannelState::Held(fault));
}

/// A fast source of one channel `T`; rules that let single values through.
fn fast(source: &str) -> String {
    format!(
        "poll_s = 0.05\nconfirm = 1\nmedian = 1\nmax_rate_K_per_min = 10000\n[source.s]\n{source}\n[channel.T]\nsource = \"s\"\n"
    )
}

/// What lines tell the channels `T` and `U`, in order.
fn told(lines: &[&str]) -> Vec<(usize, SourceReport)> {
    let mut reader = LineReader::new(&[("T".into(), 0), ("U".into(), 1)], true);
    let mut found = Vec::new();
    lines.iter().for_each(|line| reader.read(line.as_bytes(), &mut |channel, told, _| found.push((channel, told))));
    found
}

#[test]
fn lines_say_themselves_what_they_are() {
    let value = |channel, value| (channel, SourceReport::Value(value));
    assert_eq!(told(&["t_s,T_C,U", "0,20.5,21", "1,,22"]), [value(0, 20.5), value(1, 21.0), value(1, 22.0)]);
    assert_eq!(told(&["U_C;note;T_C", "1,5;a b;-2"]), [value(0, -2.0), value(1, 1.5)]);
    assert_eq!(
        told(&["\u{feff}\"T\"\tU", "20\t\"21\"", "T,U", "3,4"]),
        [value(0, 20.0), value(1, 21.0), value(0, 3.0), value(1, 4.0)]
    );
    assert_eq!(told(&["# a comment", "", "T=20.5 U=21", "U=3;X=1"]), [value(0, 20.5), value(1, 21.0), value(1, 3.0)]);
    assert_eq!(told(&["{\"T\": 20.5, \"U\": \"21\"}", "{\"X\": 1}"]), [value(0, 20.5), value(1, 21.0)]);
    let mut alone = LineReader::new(&[("T".into(), 7)], true);
    alone.read(b"21.5\n", &mut |channel, told, _| assert_eq!((channel, told), value(7, 21.5)));
    let mut deep = LineReader::new(&[("head.temps.1".into(), 0)], true);
    deep.read(b"{\"head\":{\"temps\":[1,2.5]}}", &mut |channel, told, _| assert_eq!((channel, told), value(0, 2.5)));
}

#[test]
fn lines_that_say_nothing_are_faults_and_never_numbers() {
    for lines in [
        &["0,20.5,21"][..],
        &["t_s,X", "0,20"],
        &["T,U", "20"],
        &["T,U", "20,21,22"],
        &["{\"T\": 20"],
        &["20.5"],
        &["T=abc U=nan"],
        &["{\"T\": null, \"U\": [1]}"],
        &["T,U", "UNAVAILABLE,1e999"],
    ] {
        let found = told(lines);
        assert!(found.len() >= 2, "{lines:?}");
        assert!(
            found.iter().all(|(_, told)| matches!(told, SourceReport::Nothing(ChannelFault::Invalid, _))),
            "{lines:?} {found:?}"
        );
    }
}

#[test]
fn times_of_lines_are_taken() {
    let mut lines = LineReader::new(&[("T".into(), 0)], true);
    let expected = stamp("2024-02-29T12:00:00Z");
    for text in
        ["{\"time\":\"2024-02-29T12:00:00Z\",\"T\":1}", "T=1 ts=1709208000", "time,T", "2024-02-29T13:00:00+01:00,1"]
    {
        lines.read(text.as_bytes(), &mut |_, _, stamp| assert!(stamp == expected && stamp.is_some(), "{text}"));
    }
    let mut without = LineReader::new(&[("T".into(), 0)], false);
    without.read(b"T=1 ts=1709208000", &mut |_, _, stamp| assert_eq!(stamp, None));
}

#[test]
fn a_growing_file_is_followed_through_partial_lines_rotation_and_truncation() {
    let shop = Shop::new().file("log.csv", "t_s,T_C\n0,20\n");
    let path = shop.path("log.csv");
    let append = |text: &str| File::options().append(true).open(&path).unwrap().write_all(text.as_bytes()).unwrap();
    let mut panel = open(&fast("kind = \"file\"\npath = \"log.csv\""), shop.path("").as_path());
    until_value(&mut panel, 20.0);
    append("1,21");
    std::thread::sleep(Duration::from_millis(200));
    panel.take(clock());
    assert_eq!(panel.channels().next().unwrap().value_c, Some(20.0), "half a line is no reading");
    append(".5\n");
    until_value(&mut panel, 21.5);
    // Replaced: what was still written into the old one comes first.
    append("2,22\n");
    std::thread::sleep(Duration::from_millis(100));
    fs::rename(&path, shop.path("log.old")).unwrap();
    fs::write(&path, "T_C,t_s\n23,0\n").unwrap();
    until_value(&mut panel, 23.0);
    append("24,1\n");
    until_value(&mut panel, 24.0);
    // Cut short and begun again.
    fs::write(&path, "T_C\n25\n").unwrap();
    until_value(&mut panel, 25.0);
    fs::remove_file(&path).unwrap();
    until_fault(&mut panel, ChannelFault::Disconnected);
    fs::write(&path, "T_C\n26\n").unwrap();
    until_value(&mut panel, 26.0);
}

#[test]
fn of_a_long_file_the_last_row_counts_and_it_is_as_old_as_the_file() {
    let rows: String = (0..40_000).map(|row| format!("{row},{}\n", 20.0 + f64::from(row) * 1e-4)).collect();
    let shop = Shop::new().file("log.csv", format!("t_s,T_C\n{rows}"));
    let text = fast("kind = \"file\"\npath = \"log.csv\"");
    let mut panel = open(&text, shop.path("").as_path());
    until_value(&mut panel, 20.0 + 39_999.0 * 1e-4);
    let file = File::options().append(true).open(shop.path("log.csv")).unwrap();
    file.set_modified(std::time::SystemTime::now() - Duration::from_secs(3600)).unwrap();
    let mut panel = open(&text, shop.path("").as_path());
    until(&mut panel, "old", |readings| readings[0].note.contains("old"));
    assert_eq!(panel.channels().next().unwrap().state, ChannelState::Waiting, "an hour-old row is no reading");
}

#[test]
fn a_file_that_holds_a_value_is_read_each_time() {
    let shop = Shop::new().file("temperature", "21437\n");
    let text = fast("kind = \"file\"\npath = \"temperature\"\nmode = \"value\"") + "unit = \"mC\"\n";
    let mut panel = open(&text, shop.path("").as_path());
    until_value(&mut panel, 21.437);
    fs::write(shop.path("temperature"), "85000\n").unwrap();
    until_fault(&mut panel, ChannelFault::Invalid);
    assert_eq!(panel.channels().next().unwrap().value_c, Some(21.437));
    fs::write(shop.path("temperature"), "").unwrap();
    until_fault(&mut panel, ChannelFault::Disconnected);
    fs::write(shop.path("temperature"), "21500\n").unwrap();
    until_value(&mut panel, 21.5);
}

#[test]
fn a_command_is_read_and_ended_where_it_hangs() {
    let shop = Shop::new().file("values", "T=20.5\n");
    let mut panel = open(&fast("kind = \"command\"\ncommand = [\"cat\", \"values\"]"), shop.path("").as_path());
    until_value(&mut panel, 20.5);
    fs::write(shop.path("values"), "T_C,x\n21.5,1\n").unwrap();
    until_value(&mut panel, 21.5);
    fs::remove_file(shop.path("values")).unwrap();
    until_fault(&mut panel, ChannelFault::Disconnected);

    // What it starts is ended with it: the shell waits for its child.
    let source = "kind = \"command\"\ncommand = [\"sh\", \"-c\", \"echo T=20; test -e slow && { sleep 61.25 & wait; }; true\"]\ntimeout_s = 1";
    let mut panel = open(&fast(source), shop.path("").as_path());
    until_value(&mut panel, 20.0);
    fs::write(shop.path("slow"), "").unwrap();
    until(&mut panel, "ended", |readings| readings[0].note.contains("took longer than 1 s"));
    drop(panel);
    assert!(!is_running("sleep 61.25"), "a child of the command was left behind");
}

/// Whether a command runs, by the list of processes.
fn is_running(command: &str) -> bool {
    let words: Vec<u8> = command.replace(' ', "\0").into_bytes();
    let entries = fs::read_dir("/proc").unwrap().flatten();
    entries
        .map(|entry| entry.path().join("cmdline"))
        .any(|path| fs::read(path).is_ok_and(|line| line.starts_with(&words) && line.len() <= words.len() + 1))
}

#[test]
fn a_source_that_hangs_keeps_nobody_waiting() {
    let shop = Shop::new();
    let pipe = shop.path("pipe");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let text = "poll_s = 0.05\n[source.a]\nkind = \"command\"\ncommand = [\"sleep\", \"62.5\"]\ntimeout_s = 100\n\
                [source.b]\nkind = \"file\"\npath = \"pipe\"\n\
                [channel.T]\nsource = \"a\"\n[channel.U]\nsource = \"b\"\n";
    let mut panel = open(text, shop.path("").as_path());
    std::thread::sleep(Duration::from_millis(100));
    let start = Instant::now();
    for step in 0..10_000 {
        assert!(!panel.take(Duration::from_millis(step)));
    }
    // 10,000 takes in less than one of the two waits.
    assert!(start.elapsed() < Duration::from_secs(10), "{:?}", start.elapsed());
    assert_eq!(panel.verdict(), PanelVerdict::Waiting(vec!["T".into(), "U".into()]));
    let start = Instant::now();
    drop(panel);
    assert!(start.elapsed() < Duration::from_secs(5), "{:?}", start.elapsed());
    let start = Instant::now();
    while is_running("sleep 62.5") {
        assert!(start.elapsed() < Duration::from_secs(10), "the command was left behind");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// A log in which T warms up, is silent from 240 to 600 s, and U jumps for one row.
const LOG: &str = "t_s,T_C,U_C\n100,20,22\n160,21,22\n220,22,80\n280,23,22\n340,24,22.1\n400,,22\n460,,22\n520,,22\n580,,22\n640,,22\n700,25,22\n";

fn replay(keys: &str) -> String {
    format!(
        "median = 1\n{keys}\n[source.log]\nkind = \"replay\"\npath = \"log.csv\"\n[channel.T]\nsource = \"log\"\n[channel.U]\nsource = \"log\"\n"
    )
}

#[test]
fn a_log_is_played_by_the_clock_of_the_job() {
    let shop = Shop::new().file("log.csv", LOG);
    let states = |step_s: u64| {
        let mut panel = open(&replay(""), shop.path("").as_path());
        let mut seen = Vec::new();
        for t_s in (0..=600).step_by(step_s as usize) {
            panel.take(Duration::from_secs(t_s));
            if t_s % 60 == 0 {
                seen.push((t_s, panel.channels().cloned().collect::<Vec<_>>(), panel.verdict()));
            }
        }
        seen
    };
    let seen = states(60);
    // However often it is asked, the job sees the same.
    assert_eq!(seen, states(1));
    assert_eq!(seen, states(20));
    let values: Vec<_> =
        seen.iter().map(|(_, readings, _)| (readings[0].value_c.unwrap(), readings[1].value_c.unwrap())).collect();
    assert_eq!(values[..5], [(20.0, 22.0), (21.0, 22.0), (22.0, 22.0), (23.0, 22.0), (24.0, 22.1)]);
    assert_eq!(seen[2].1[1].state, ChannelState::Held(ChannelFault::Jump), "80 °C for one row");
    assert!(matches!(&seen[2].2, PanelVerdict::Freeze(why) if why.contains("80.0 °C")));
    assert_eq!(seen[7].2, PanelVerdict::Good, "180 s old");
    assert_eq!(seen[8].1[0].state, ChannelState::Held(ChannelFault::Silent), "240 s old");
    assert_eq!(seen[10].1[0].state, ChannelState::Good);
    // Ten times as fast.
    let mut panel = open(
        &replay("").replace("path", "speed = 10\npath").replace("median", "max_rate_K_per_min = 50\nmedian"),
        shop.path("").as_path(),
    );
    panel.take(Duration::from_secs(24));
    assert_eq!(panel.channels().next().unwrap().value_c, Some(24.0));
    // Behind its end there is nothing.
    panel.take(Duration::from_secs(66));
    assert_eq!(panel.channels().next().unwrap().state, ChannelState::Good);
    panel.take(Duration::from_secs(67));
    assert_eq!(panel.channels().next().unwrap().state, ChannelState::Held(ChannelFault::Disconnected));
}

#[test]
fn what_is_bad_for_long_is_acted_upon() {
    let shop = Shop::new().file("log.csv", LOG);
    let at = |keys: &str, t_s: u64| {
        let mut panel = open(&replay(keys), shop.path("").as_path());
        for t_s in (0..=t_s).step_by(10) {
            panel.take(Duration::from_secs(t_s));
        }
        panel.verdict()
    };
    // T is silent from 240 + 180 s on.
    assert_eq!(at("action = \"stop\"\nact_after_s = 60", 420), PanelVerdict::Good);
    assert!(matches!(at("action = \"stop\"\nact_after_s = 60", 470), PanelVerdict::Freeze(_)));
    assert!(
        matches!(at("action = \"stop\"\nact_after_s = 60", 480), PanelVerdict::Act(Action::Stop, why) if why.starts_with("T "))
    );
    assert!(matches!(at("action = \"hold\"\nact_after_s = 0", 430), PanelVerdict::Act(Action::Hold, _)));
    assert!(matches!(at("act_after_s = 60", 490), PanelVerdict::Act(Action::Continue, _)));
    assert_eq!(at("action = \"stop\"\nact_after_s = 60", 600), PanelVerdict::Good, "it has come back");
}

#[test]
fn a_log_that_cannot_be_played_is_refused_when_it_is_opened() {
    let shop = Shop::new().file("log.csv", "t_s,T_C\n0,20\nx,21\n").file("S.toml", replay(""));
    shop.run(["sensors", "S.toml", "--watch", "--for", "1"]).exits(4).says("log.csv:3:1").says("E0404");
    let shop = Shop::new().file("log.csv", "t_s,T_C\n0,20\n").file("S.toml", replay(""));
    shop.run(["sensors", "S.toml", "--watch", "--for", "1"]).exits(4).says("has no temperatures of U");
    let shop = Shop::new().file("S.toml", replay(""));
    shop.run(["sensors", "S.toml", "--watch", "--for", "1"]).exits(4).says("cannot read log.csv");
}

#[test]
fn the_command_shows_writes_a_log_and_says_whether_all_is_good() {
    let sensors = "poll_s = 0.2\nconfirm = 1\n[source.in]\nkind = \"stdin\"\n[channel.T_head]\nsource = \"in\"\n[channel.T_bed]\nsource = \"in\"\nitem = \"bed\"\n";
    let shop = Shop::new().file("S.toml", sensors);
    let input = b"{\"T_head\": 21.5, \"bed\": 20.25}\n";
    let run = shop
        .run_with_input(["sensors", "S.toml", "--watch", "--for", "1", "--json", "--log", "out.csv"], input)
        .exits(4);
    let rows: Vec<serde_json::Value> = run.stdout.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert!((3..=8).contains(&rows.len()), "{}", run.stdout);
    let last = &rows[rows.len() - 1];
    assert_eq!((&last["schema"], &last["verdict"]), (&1.into(), &"freeze".into()));
    let head = &last["channels"][0];
    assert_eq!((&head["name"], &head["value_C"], &head["state"]), (&"T_head".into(), &21.5.into(), &"held".into()));
    assert_eq!((&head["fault"], &head["source"]), (&"disconnected".into(), &"in".into()));
    assert_eq!(last["channels"][1]["value_C"], 20.25);
    let log = shop.text("out.csv");
    assert!(log.starts_with("t_s,T_head_C,T_bed_C\n"), "{log}");
    // A log is never written over.
    shop.run(["sensors", "S.toml", "--watch", "--for", "1", "--log", "out.csv"]).exits(2).says("it already exists");
    assert_eq!(shop.text("out.csv"), log);

    // A file that holds a value stays good; its log is one that can be played.
    let sensors = "poll_s = 0.1\nconfirm = 1\n[source.f]\nkind = \"file\"\nmode = \"value\"\npath = \"v\"\n[channel.T_head]\nsource = \"f\"\n";
    let shop = Shop::new().file("S.toml", sensors).file("v", "21.5");
    let run = shop.run(["sensors", "S.toml", "--watch", "--for", "1", "--log", "out.csv"]).exits(0);
    assert!(run.stdout.lines().last().unwrap().ends_with("good  T_head 21.50 °C"), "{}", run.stdout);
    let source = Source::new(FileId(0), "out.csv", shop.bytes("out.csv")).unwrap();
    let (condition, findings) = ncfix_machine::machine::condition::log::load(&source);
    assert!(findings.is_empty(), "{findings:?}");
    assert_eq!(condition.unwrap().temperature_c("T_head", 0.0), Some(21.5));
}

#[test]
fn the_command_refuses_what_it_cannot_watch() {
    let shop = Shop::new().file("S.toml", "[channel.T]\nsource = \"x\"\n");
    shop.run(["sensors", "S.toml", "--watch"]).exits(4).says("the file has no source").says("there is no source 'x'");
    shop.run(["sensors", "none.toml", "--watch"]).exits(2).says("there is no such file");
    shop.run(["sensors", "S.toml", "S.toml", "--watch"]).exits(2).says("one file");
    shop.run(["sensors", "S.toml", "--for", "3"]).exits(2);
    shop.run(["sensors", "S.toml", "--watch", "--for", "0"]).exits(2).says("above 0");
}

proptest! {
    /// Whatever a source sends: what is told is a finite number or a fault.
    #[test]
    fn any_bytes_are_a_number_or_a_fault(
        lines in prop::collection::vec(prop_oneof![
            prop::collection::vec(any::<u8>(), 0..60),
            "[{\\[]?[TU\":=,; 0-9.e+-]{0,30}[}\\]]?".prop_map(String::into_bytes),
            Just(b"t_s,T_C,U".to_vec()),
        ], 0..20),
    ) {
        let mut reader = LineReader::new(&[("T".into(), 0), ("U".into(), 1)], true);
        for line in &lines {
            reader.read(line, &mut |channel, told, _| {
                assert!(channel < 2);
                assert!(!matches!(told, SourceReport::Value(value) if !value.is_finite()));
            });
        }
    }
}
