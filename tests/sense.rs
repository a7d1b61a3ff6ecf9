//! What is believed of live sensors: the pure judge of a channel, and the file that says how it judges.

use std::time::Duration;

use ncfix_base::source::{FileId, Source};
use ncfix_dnc::sense::{
    Action, ChannelFault, ChannelReading, ChannelState, Config, Monitor, SensorChannel, SensorSources, SourceReport,
};
use proptest::prelude::*;

/// A config with one channel `T` of a file, with further keys.
fn config(keys: &str) -> Config {
    let text = format!("[source.s]\nkind = \"file\"\npath = \"x\"\n[channel.T]\nsource = \"s\"\n{keys}\n");
    read(&text).unwrap_or_else(|findings| panic!("{findings:?}"))
}

fn read(text: &str) -> Result<Config, Vec<String>> {
    let source = Source::new(FileId(0), "S.toml", text.as_bytes().to_vec()).unwrap();
    Config::read(&source).map_err(|findings| {
        let seen = |finding: &ncfix_base::diagnostic::Diagnostic| {
            let (line, _) = source.line_column(finding.place.unwrap().span.start);
            format!("{}:{line}: {}", finding.code, finding.message)
        };
        findings.iter().map(seen).collect()
    })
}

fn channel(keys: &str) -> SensorChannel {
    config(keys).channels.remove(0)
}

/// A judge and the clock that drives it.
struct Bench(Monitor, ChannelReading);

impl Bench {
    fn new(keys: &str) -> Bench {
        Bench(Monitor::new(&channel(keys)), ChannelReading::default())
    }

    /// Hears a value that was read at this instant, s.
    fn at(&mut self, t_s: f64, value: f64) -> (Option<f64>, ChannelState) {
        self.told(t_s, &SourceReport::Value(value), 0.0)
    }

    fn told(&mut self, t_s: f64, told: &SourceReport, age_s: f64) -> (Option<f64>, ChannelState) {
        self.0.hear(told, Duration::from_secs_f64(age_s), Duration::from_secs_f64(t_s));
        self.tick(t_s)
    }

    fn tick(&mut self, t_s: f64) -> (Option<f64>, ChannelState) {
        let now = Duration::from_secs_f64(t_s);
        self.0.tick(now);
        self.0.show(now, &mut self.1);
        (self.1.value_c, self.1.state)
    }

    /// Three good values of 20 °C, at 0, 10 and 20 s.
    fn warm(keys: &str) -> Bench {
        let mut bench = Bench::new(keys);
        for t_s in [0.0, 10.0, 20.0] {
            bench.at(t_s, 20.0);
        }
        assert_eq!(bench.tick(20.0), (Some(20.0), ChannelState::Good));
        bench
    }
}

const HELD_JUMP: (Option<f64>, ChannelState) = (Some(20.0), ChannelState::Held(ChannelFault::Jump));

#[test]
fn nothing_is_believed_before_some_readings_agree() {
    let mut bench = Bench::new("");
    assert_eq!(bench.tick(0.0), (None, ChannelState::Waiting));
    assert_eq!(bench.at(0.0, 20.0), (None, ChannelState::Waiting));
    // The second one contradicts the first, so that counting begins again.
    assert_eq!(bench.at(10.0, 40.0), (None, ChannelState::Waiting));
    assert_eq!(bench.at(20.0, 20.0), (None, ChannelState::Waiting));
    assert_eq!(bench.at(30.0, 20.2), (None, ChannelState::Waiting));
    assert_eq!(bench.at(40.0, 20.1), (Some(20.1), ChannelState::Good));
}

#[test]
fn faults_hold_the_last_good_value() {
    for (told, fault) in [
        (SourceReport::Value(f64::NAN), ChannelFault::Invalid),
        (SourceReport::Value(f64::INFINITY), ChannelFault::Invalid),
        (SourceReport::Value(85.0), ChannelFault::Invalid),
        (SourceReport::Value(-127.0), ChannelFault::Invalid),
        (SourceReport::Value(81.0), ChannelFault::OutOfRange),
        (SourceReport::Value(-11.0), ChannelFault::OutOfRange),
        (SourceReport::Value(0.0), ChannelFault::Jump),
        (SourceReport::Value(30.0), ChannelFault::Jump),
        (SourceReport::Nothing(ChannelFault::Disconnected, "gone".into()), ChannelFault::Disconnected),
    ] {
        let mut bench = Bench::warm("");
        assert_eq!(bench.told(30.0, &told, 0.0), (Some(20.0), ChannelState::Held(fault)), "{told:?}");
        assert!(!bench.1.note.is_empty(), "{told:?}");
        assert_eq!(
            bench.at(40.0, 20.1),
            (Some(20.0), ChannelState::Good),
            "{told:?} and back: the median of 20, 20, 20.1"
        );
        assert_eq!(bench.1.note, "");
    }
}

#[test]
fn a_jump_and_back_never_gets_through_and_a_new_level_does_when_the_rate_allows_it() {
    // 100 °C is allowed here, and the power-on value of 1-wire sensors is a temperature like any other.
    let keys = "range_C = [0, 120]\ninvalid = []\nmax_rate_K_per_min = 5\nstep_K = 0.5";
    let mut bench = Bench::warm(keys);
    for step in 3..70 {
        // 85 - 20 = 65 K; 0.5 K + 5 K/min let it through after 64.5 / 5 = 12.9 min = 774 s behind 20 s.
        let t_s = 10.0 * f64::from(step);
        assert_eq!(bench.at(t_s, 85.0), HELD_JUMP, "{t_s} s");
    }
    assert_eq!(bench.at(700.0, 20.0), (Some(20.0), ChannelState::Good));

    // To 30 °C: (10 - 0.5) / 5 min = 114 s behind the last good value at 20 s.
    let mut bench = Bench::warm(keys);
    for step in 3..=13 {
        assert_eq!(bench.at(10.0 * f64::from(step), 30.0), HELD_JUMP);
    }
    assert_eq!(bench.at(140.0, 30.0), (Some(30.0), ChannelState::Good));
    assert_eq!(bench.at(150.0, 30.2), (Some(30.0), ChannelState::Good));
}

#[test]
fn a_change_in_small_steps_is_no_slower_change() {
    // 0.4 K each second is 24 K/min; each step is below step_K.
    let mut bench = Bench::warm("");
    let mut highest = f64::MIN;
    for step in 1..=60 {
        let (value_c, _) = bench.at(20.0 + f64::from(step), 20.0 + 0.4 * f64::from(step));
        highest = highest.max(value_c.unwrap());
    }
    // At most step_K and what 5 K/min make in the 60 s that are looked back.
    assert!(highest < 20.0 + 0.5 + 5.0, "{highest}");
    // 4 K/min, the same for noise of ±0.2 K, is a machine that warms up.
    let mut bench = Bench::warm("");
    for step in 1..=60 {
        let noise = if step % 2 == 0 { 0.2 } else { -0.2 };
        let value = 20.0 + 4.0 / 60.0 * f64::from(step) + noise;
        assert_eq!(bench.at(20.0 + f64::from(step), value).1, ChannelState::Good, "{step}");
    }
}

#[test]
fn after_a_silence_one_reading_is_no_proof() {
    let mut bench = Bench::warm("");
    assert_eq!(bench.tick(200.0), (Some(20.0), ChannelState::Good));
    assert_eq!(
        bench.tick(200.1),
        (Some(20.0), ChannelState::Held(ChannelFault::Silent)),
        "180 s behind the last reading"
    );
    assert_eq!(bench.1.age, Some(Duration::from_secs_f64(180.1)));
    // 29 °C is possible after 10 min, more than a minute explains, and true: the third reading brings it.
    assert_eq!(bench.at(620.0, 29.0), HELD_JUMP);
    assert_eq!(bench.at(630.0, 29.0), HELD_JUMP);
    assert_eq!(bench.at(640.0, 29.0), (Some(29.0), ChannelState::Good));
    // What a minute explains is believed at once.
    assert_eq!(bench.tick(1000.0).1, ChannelState::Held(ChannelFault::Silent));
    assert_eq!(bench.at(1000.0, 32.0), (Some(29.0), ChannelState::Good), "the median of 29, 29, 32");
}

#[test]
fn readings_count_with_their_own_time() {
    let mut bench = Bench::warm("");
    // The same reading again and again says nothing new, though it comes.
    for t_s in [30.0, 100.0, 190.0] {
        assert_eq!(bench.told(t_s, &SourceReport::Value(20.0), t_s - 20.0).1, ChannelState::Good);
    }
    assert_eq!(
        bench.told(201.0, &SourceReport::Value(20.0), 181.0),
        (Some(20.0), ChannelState::Held(ChannelFault::Silent))
    );
    // One that was read long before it came is none.
    assert_eq!(bench.told(300.0, &SourceReport::Value(20.0), 200.0).1, ChannelState::Held(ChannelFault::Silent));
    assert_eq!(bench.told(310.0, &SourceReport::Value(20.0), 5.0).1, ChannelState::Good);
    assert_eq!(bench.1.age, Some(Duration::from_secs(5)));
    // Readings from before the start are as old as they are.
    let mut bench = Bench::new("confirm = 1");
    assert_eq!(bench.told(5.0, &SourceReport::Value(20.0), 3600.0), (None, ChannelState::Waiting));
    assert_eq!(bench.told(6.0, &SourceReport::Value(20.0), 100.0).1, ChannelState::Good);
    assert_eq!(bench.tick(87.0).1, ChannelState::Held(ChannelFault::Silent));
}

#[test]
fn a_value_that_never_moves_is_stuck_where_that_is_asked_for() {
    let mut bench = Bench::warm("stuck_after_s = 60");
    assert_eq!(bench.at(70.0, 20.0).1, ChannelState::Good, "50 s since it was believed at 20 s");
    assert_eq!(bench.at(80.0, 20.0), (Some(20.0), ChannelState::Held(ChannelFault::Stuck)));
    assert_eq!(bench.at(90.0, 20.01).1, ChannelState::Good);
    let mut bench = Bench::warm("");
    for step in 3..1000 {
        assert_eq!(bench.at(10.0 * f64::from(step), 20.0).1, ChannelState::Good);
    }
}

#[test]
fn the_median_takes_what_its_number_says() {
    let mut bench = Bench::new("confirm = 1\nmedian = 4");
    let expected = [(20.0, 20.0), (20.4, 20.2), (20.2, 20.2), (20.1, 20.15), (20.3, 20.25)];
    for (index, (value, median)) in expected.into_iter().enumerate() {
        let found = bench.at(10.0 * index as f64, value).0.unwrap();
        assert!((found - median).abs() < 1e-12, "{found} {median}");
    }
    let mut bench = Bench::new("confirm = 1\nmedian = 1");
    assert_eq!(bench.at(0.0, 20.0).0, Some(20.0));
    assert_eq!(bench.at(1.0, 20.3).0, Some(20.3));
}

#[test]
fn numbers_become_temperatures_as_the_file_says() {
    let cases = [
        ("unit = \"mC\"", 21_437.0, 21.437),
        ("unit = \"K\"", 294.15, 21.0),
        ("unit = \"F\"", 68.0, 20.0),
        ("unit = \"F\"", 212.0, 100.0),
        ("scale = 0.1", 215.0, 21.5),
        // 10 mV a degree and 500 mV at 0 °C: a TMP36.
        ("unit = \"mV\"\nscale = 0.1\noffset = -50", 750.0, 25.0),
        // 4 to 20 mA for 0 to 100 °C.
        ("unit = \"mA\"\nscale = 6.25\noffset = -25", 8.0, 25.0),
    ];
    for (keys, raw, expected) in cases {
        assert!((channel(keys).to_c(raw) - expected).abs() < 1e-9, "{keys}");
    }
    // 85 °C of a sensor that gives thousandths.
    let milli = channel("unit = \"mC\"");
    assert!(milli.is_invalid(85_000.0, milli.to_c(85_000.0)) && !milli.is_invalid(84_999.0, milli.to_c(84_999.0)));
    let own = channel("invalid = [0, -999]");
    assert!(own.is_invalid(0.0, 0.0) && own.is_invalid(-999.0, -999.0) && !own.is_invalid(85.0, 85.0));
}

#[test]
fn what_is_wrong_with_the_file_is_said_at_its_place() {
    assert_eq!(read("").unwrap_err().len(), 2);
    let head = "[source.a]\nkind = \"file\"\npath = \"x\"\n";
    for (text, expected) in [
        ("[source.a]\nkind = \"fiel\"\n[channel.T]\nsource = \"a\"\n", "E0404:2: unknown kind \"fiel\""),
        ("[source.a]\npath = \"x\"\n[channel.T]\nsource = \"a\"\n", "E0403:1: [source.a] has no kind"),
        ("[source.a]\nkind = \"file\"\n[channel.T]\nsource = \"a\"\n", "E0403:1: [source.a] has no path"),
        (&format!("{head}[channel.T]\nsource = \"b\"\n"), "E0404:1: no channel uses [source.a]"),
        (&format!("{head}[channel.T]\nsource = \"a\"\nrange_C = [50, 10]\n"), "E0404:6: range_C must be"),
        (&format!("{head}[channel.T]\nsource = \"a\"\nmax_rate = 4\n"), "E0402:6: unknown key max_rate"),
        (
            &format!("{head}[channel.T]\nsource = \"a\"\nunit = \"mV\"\n"),
            "E0403:4: [channel.T] in mV is not a temperature",
        ),
        (&format!("{head}[channel.T]\nsource = \"a\"\naction = \"halt\"\n"), "E0404:6: there is no action 'halt'"),
        (&format!("poll_s = 0\n{head}[channel.T]\nsource = \"a\"\n"), "E0404:1: poll_s must be"),
        (&format!("{head}mode = \"all\"\n[channel.T]\nsource = \"a\"\n"), "E0404:4: there is no mode 'all'"),
    ] {
        let found = read(text).unwrap_err();
        assert!(found[0].starts_with(expected), "{text}\n{found:?}");
    }
    let twice = "[source.a]\nkind = \"stdin\"\n[source.b]\nkind = \"stdin\"\n[channel.T]\nsource = \"a\"\n[channel.U]\nsource = \"b\"\n";
    assert_eq!(read(twice).unwrap_err(), ["E0404:3: two sources read standard input"]);
}

#[cfg(not(feature = "opcua"))]
#[test]
fn a_kind_that_is_not_built_in_says_what_to_do() {
    let text = "[source.a]\nkind = \"opcua\"\nendpoint = \"x\"\n[channel.T]\nsource = \"a\"\nnode = 1\n";
    assert_eq!(read(text).unwrap_err(), ["E0404:2: this ncfix was built without opcua"]);
    let source = Source::new(FileId(0), "S.toml", text.as_bytes().to_vec()).unwrap();
    let findings = Config::read(&source).unwrap_err();
    let help =
        "build it with `--features opcua`, or read the server by a `command`, or through a gateway to MQTT or Modbus";
    assert_eq!(findings[0].help, help);
}

#[cfg(feature = "opcua")]
#[test]
fn what_is_wrong_with_a_source_of_opc_ua_is_said_at_its_place() {
    let of = |source: &str, channel: &str| {
        format!("[source.a]\nkind = \"opcua\"\n{source}\n[channel.T]\nsource = \"a\"\n{channel}\n")
    };
    let (url, node) = ("url = \"opc.tcp://plc\"", "node = \"ns=2;s=Machine.T_head\"");
    for good in
        [node, "node = \"i=2258\"", "node = \"ns=3;g=09087e75-8e5e-499b-954f-f2a9603db28a\"", "node = \"ns=1;b=TQ==\""]
    {
        assert!(read(&of(url, good)).is_ok(), "{good}");
    }
    assert!(
        read(&of(&format!("{url}\nuser = \"u\"\npassword_env = \"P\"\nuse_time = true\ntimeout_s = 2"), node)).is_ok()
    );
    for (source, channel, expected) in [
        ("", node, "E0403:1: [source.a] has no url"),
        ("url = \"http://plc\"", node, "E0404:3: 'http://plc' is not an address of a server"),
        ("url = \"opc.tcp://plc:x\"", node, "E0404:3: 'opc.tcp://plc:x' is not an address of a server"),
        (url, "", "E0403:4: [channel.T] has no node"),
        (url, "node = \"Machine.T_head\"", "E0404:6: 'Machine.T_head' is not a node"),
        (url, "node = \"ns=70000;i=1\"", "E0404:6: 'ns=70000;i=1' is not a node"),
        (url, "node = \"ns=2;i=x\"", "E0404:6: 'ns=2;i=x' is not a node"),
        (url, "node = \"g=1\"", "E0404:6: 'g=1' is not a node"),
        (url, "node = \"b=*\"", "E0404:6: 'b=*' is not a node"),
        (url, "node = \"s=\"", "E0404:6: 's=' is not a node"),
        (&format!("{url}\npassword_env = \"P\""), node, "E0403:4: [source.a] has a password but no user"),
        (&format!("{url}\nuser = \"u\"\npassword_env = \"A=B\""), node, "E0404:5: password_env is not a name"),
        (&format!("{url}\ntimeout_s = 0"), node, "E0404:4: timeout_s must be"),
        (&format!("{url}\nendpoint = \"x\""), node, "E0402:4: unknown key endpoint"),
    ] {
        let found = read(&of(source, channel)).unwrap_err();
        assert!(found.len() == 1 && found[0].starts_with(expected), "{source} {channel}\n{found:?}");
    }
}

#[test]
fn a_channel_has_the_rules_of_the_file_and_its_own_over_them() {
    let text = "poll_s = 60\naction = \"stop\"\nact_after_s = 20\nrange_C = [5, 60]\n[source.a]\nkind = \"stdin\"\npoll_s = 2\n\
                [channel.T]\nsource = \"a\"\n[channel.U]\nsource = \"a\"\naction = \"hold\"\nmax_age_s = 5\n";
    let config = read(text).unwrap();
    let [t, u] = config.channels.as_slice() else { panic!() };
    assert_eq!((t.action, t.act_after.as_secs(), t.range_c), (Action::Stop, 20, [5.0, 60.0]));
    assert_eq!((u.action, u.act_after.as_secs(), u.max_age.as_secs()), (Action::Hold, 20, 5));
    // Three polls, where that is more than three minutes.
    assert_eq!(t.max_age.as_secs(), 180);
    assert_eq!(config.sources[0].poll.as_secs(), 2);
    assert_eq!(read(&text.replace("poll_s = 60", "poll_s = 100")).unwrap().channels[0].max_age.as_secs(), 300);
}

#[test]
fn every_kind_of_source_is_registered() {
    let folder = crate::support::repository("crates/dnc/src/sense/source");
    let mut files: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned())
        .filter(|name| name != "mod")
        .collect();
    files.sort();
    let kinds = SensorSources::default();
    assert_eq!(kinds.names().collect::<Vec<_>>(), files);
    let page = std::fs::read_to_string(crate::support::repository("docs/reference/sensors.md")).unwrap();
    for name in kinds.names() {
        assert!(page.contains(&format!("kind = \"{name}\"")), "docs/reference/sensors.md has no example of {name}");
    }
}

proptest! {
    /// A machine that warms up by at most 3 K/min with noise of ±0.1 K, and a sensor that says anything else at random: what is handed on is never
    /// farther from the truth than the rate allows in the age of the value, and the noise, and never a fault.
    #[test]
    fn no_fault_becomes_a_temperature(
        faults in prop::collection::vec(prop::option::weighted(0.3, prop_oneof![
            Just(f64::NAN), Just(0.0), Just(85.0), Just(-127.0), Just(32768.0), Just(1e300), -40.0..140.0_f64,
        ]), 10..200),
        noise in prop::collection::vec(-0.1..0.1_f64, 200),
        rate_k_per_min in -3.0..3.0_f64,
    ) {
        let mut bench = Bench::new("range_C = [5, 60]");
        let truth = |t_s: f64| 30.0 + rate_k_per_min.abs() * 5.0 * (rate_k_per_min.signum() * t_s / 300.0).sin();
        for (index, (fault, noise)) in faults.iter().zip(&noise).enumerate() {
            let t_s = 10.0 * index as f64;
            let value = fault.unwrap_or(truth(t_s) + noise);
            let (value_c, _) = bench.at(t_s, value);
            if let Some(value_c) = value_c {
                let age_s = bench.1.age.unwrap().as_secs_f64();
                // A fault may pass for a temperature where it is as near as the rate allows: 5.5 K in the minute that is looked back, and as much
                // for the truth meanwhile. The median of three lies between them.
                let most = 0.5 + 5.0 * (age_s + 60.0) / 60.0 + 3.0 * (age_s + 20.0) / 60.0 + 0.1;
                prop_assert!((value_c - truth(t_s)).abs() <= most, "{value_c} {} at {t_s}", truth(t_s));
            }
        }
    }
}
