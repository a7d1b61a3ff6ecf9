//! Whole transfers over a simulated cable to simulated controls, with faults by script: what is carried out is what was planned.

use ncfix_base::source::{FileId, Source};
use ncfix_dnc::feed::{Ended, Event, LossKind, PROFILES, PROTOCOLS, Profile, Sender};

use super::controls::{self, Blockwise, Cable, Control, Faults, Grbl, Marlin, Notes, Planned, Reader, Rsh};
use super::plant::random::Random;

fn profile(name: &str) -> Profile {
    let (_, text) = PROFILES.iter().find(|(known, _)| *known == name).unwrap();
    Profile::read(&Source::new(FileId(0), name, text.as_bytes().to_vec()).unwrap()).unwrap()
}

fn sender<'a>(profile: &Profile, notes: &'a mut Notes) -> Sender<'a> {
    let protocol = profile.protocol;
    Sender::new((protocol.create)(profile).unwrap(), profile.window.system_bytes, notes)
}

/// Faults of a seed: most transfers have one or two.
fn faults(seed: u64, lines: usize) -> Faults {
    let mut random = Random::new(seed, "faults");
    let mut faults =
        Faults { most_bytes: 1 + random.below(40), latency_s: random.between(0.0, 0.02), ..Faults::default() };
    for _ in 0..random.below(3) {
        let at = 1 + random.below(lines) as u64;
        match random.below(8) {
            0 => faults.lost.push(at),
            1 => faults.doubled.push(at),
            2 => faults.garbled.push(at),
            3 => faults.refuses = Some(at),
            4 => faults.corrupted.push(at),
            5 => faults.wrong_demands.push(1),
            6 => faults.reset_s = Some(random.between(0.1, 3.0)),
            _ => faults.unplugged_s = Some(random.between(0.1, 3.0)),
        }
    }
    faults
}

/// What was carried out is the beginning of what was planned: no gap, no repeat; only a line that the control has refused may be missing.
fn check((seed, refused): (u64, Option<u64>), ended: &Ended, planned: &[Vec<u8>], notes: &Notes, executed: &[Vec<u8>]) {
    let mut missing = Vec::new();
    let mut plan = planned.iter().enumerate();
    for done in executed {
        let (place, _) = plan
            .find(|(k, line)| {
                let is_next = *line == done;
                if !is_next {
                    missing.push(*k as u64 + 1);
                }
                is_next
            })
            .unwrap_or_else(|| panic!("seed {seed}: {done:?} was not to come: {ended:?}"));
        assert!(place < notes.frozen.len(), "seed {seed}");
    }
    // The one that the control was told to refuse, if it got that far.
    match ended {
        Ended::Refused(number, _) => assert_eq!(Some(*number), refused, "seed {seed}: {ended:?}"),
        _ => assert!(missing.iter().all(|number| Some(*number) == refused), "seed {seed}: {missing:?} {ended:?}"),
    }
    assert!(missing.len() <= usize::from(refused.is_some()), "seed {seed}: {missing:?} {ended:?}");
    // What may have been carried out is written down, byte for byte.
    assert_eq!(notes.frozen, planned[..notes.frozen.len()], "seed {seed}");
    if *ended == Ended::Done {
        assert_eq!(executed.len(), planned.len(), "seed {seed}: {:?}", notes.events.last());
    }
}

/// Jobs of many seeds with faults; returns how many were done. `behind` sees each control afterwards.
fn jobs<C: Control>(
    name: &str,
    seeds: std::ops::Range<u64>,
    create: fn(&Faults, f64) -> C,
    change: fn(&mut Faults),
    behind: fn(&C, &Ended, u64),
) -> usize {
    let profile = profile(name);
    let mut done = 0;
    for seed in seeds {
        let mut random = Random::new(seed, "job");
        let (count, busy_s) = (20 + random.below(60), random.between(0.001, 0.05));
        let mut faults = faults(seed, count);
        change(&mut faults);
        let mut notes = Notes::default();
        let mut planned = Planned::new(count, busy_s);
        let refused = faults.refuses;
        let mut cable = Cable::new(create(&faults, busy_s), faults, seed);
        let mut sender = sender(&profile, &mut notes);
        let ended = controls::run(&mut sender, &mut cable, &mut planned);
        done += usize::from(ended == Ended::Done);
        drop(sender);
        check((seed, refused), &ended, &planned.lines, &notes, cable.control.executed());
        behind(&cable.control, &ended, seed);
    }
    done
}

#[test]
fn grbl_carries_out_what_was_planned_whatever_goes_wrong() {
    let no_more = |faults: &mut Faults| {
        // Nobody can tell a line with two answers beside one with none from two lines with one each.
        if !faults.doubled.is_empty() {
            faults.lost.clear();
        }
    };
    let done = jobs("grbl", 0..4000, Grbl::new, no_more, |control, _, seed| {
        assert_eq!(control.overflows, 0, "seed {seed}");
    });
    // A third has no fault at all.
    assert!(done > 1200, "{done}");
}

#[test]
fn marlin_makes_good_what_gets_lost_and_is_left_when_it_says_what_nobody_knows() {
    let done = jobs(
        "marlin",
        0..4000,
        Marlin::new,
        |faults| faults.refuses = None,
        |_, ended, seed| {
            let is_expected = match ended {
                Ended::Done => true,
                Ended::Lost(_, why) => {
                    ["reset", "the link is gone", "lost count", "more lines than were sent", "an unknown text, 'o*'"]
                        .iter()
                        .any(|part| why.contains(part))
                }
                _ => false,
            };
            assert!(is_expected, "seed {seed}: {ended:?}");
        },
    );
    // Only resets, drawn cables, wrong demands, answers too many and texts that are none end a job.
    assert!(done > 1200, "{done}");
}

#[test]
fn blockwise_transfer_repeats_what_was_refused_and_nothing_else() {
    let done = jobs(
        "heidenhain-fe1",
        0..4000,
        Blockwise::new,
        |faults| faults.reset_s = None,
        |control, ended, seed| {
            assert_eq!(control.is_ended, *ended == Ended::Done, "seed {seed}: {ended:?}");
        },
    );
    assert!(done > 1600, "{done}");
}

/// A program whose lines command a position each; the end is at X4 Y-2 Z30.
const MOVES: &[&str] =
    &["G21G90G54", "G0X1Y1", "G1Z-3F300", "X10", "Y5", "G91", "X-2", "X-2", "Y-7", "G90", "X4", "G0Z30", "M30"];

/// Sends the lines to a control; returns how it ended, and whether the end position was confirmed.
fn sent<C: Control>(name: &str, lines: &[&str], control: C, faults: Faults) -> (Ended, Option<String>) {
    let profile = profile(name);
    let mut notes = Notes::default();
    let mut planned = Planned::new(lines.len(), 0.01);
    planned.lines = lines.iter().map(|line| line.as_bytes().to_vec()).collect();
    let mut cable = Cable::new(control, faults, 1);
    let mut sender = sender(&profile, &mut notes);
    let ended = controls::run(&mut sender, &mut cable, &mut planned);
    (ended, sender.progress().in_position.clone())
}

/// A control accepts every line with `ok` and does not carry out one of them. The positions are summed by hand: X 1, 10, 8, 6, 4; Y 1, 5, -2; Z -3, 30.
#[test]
fn a_line_that_was_accepted_and_not_executed_is_found_at_the_end() {
    let places = [("grbl", false, false), ("grbl", true, false), ("grbl", false, true), ("grblhal", false, false)];
    for (name, tells_inches, tells_work) in places {
        for (ignored, is_found) in [(None, false), (Some(9), true), (Some(12), true), (Some(4), false)] {
            let faults = Faults { most_bytes: 40, latency_s: 0.002, ignored, ..Faults::default() };
            let mut control = Grbl::new(&faults, 0.01).that_tells_its_place([-200.0, -150.5, -60.25]);
            (control.tells_inches, control.tells_work) = (tells_inches, tells_work);
            let (ended, confirmed) = sent(name, MOVES, control, faults);
            if is_found {
                let Ended::Lost(kind, why) = &ended else { panic!("{name} {ignored:?}: {ended:?}") };
                assert_eq!(*kind, LossKind::AtAnotherPosition, "{name} {ignored:?}: {why}");
                assert!(why.contains("at another position"), "{why}");
            } else {
                // X10 of the fourth line is hidden by the last X4, which is absolute.
                assert_eq!((&ended, confirmed.as_deref()), (&Ended::Done, Some("XYZ")), "{name} {ignored:?}");
            }
        }
    }
    for (ignored, is_found) in [(None, false), (Some(9), true), (Some(12), true)] {
        let faults = Faults { most_bytes: 40, latency_s: 0.002, ignored, ..Faults::default() };
        let mut control = Marlin::new(&faults, 0.01);
        control.tells_place = true;
        // One command in a line, as they are sent.
        let lines =
            ["G21", "G0X1Y1", "G1Z-3F300", "G1X10", "G1Y5", "G91", "G1X-2", "G1X-2", "G1Y-7", "G90", "G1X4", "G0Z30"];
        let (ended, confirmed) = sent("marlin", &lines, control, faults);
        let is_lost =
            matches!(&ended, Ended::Lost(LossKind::AtAnotherPosition, why) if why.contains("at another position"));
        assert_eq!(is_lost, is_found, "{ignored:?}: {ended:?}");
        assert_eq!(confirmed.as_deref(), (!is_found).then_some("XYZ"), "{ignored:?}: {ended:?}");
    }
}

/// After a dwell the axes stand still in any case: there the position is compared, before a later line commands the same axis again.
#[test]
fn a_line_that_was_not_executed_is_found_at_the_next_stop() {
    let lines = ["G21G90G54", "G0X1Y1", "X10", "M0", "X20", "Y9", "G0X4", "M30"];
    for (ignored, is_found) in [(None, false), (Some(3), true)] {
        let faults = Faults { most_bytes: 40, latency_s: 0.002, ignored, ..Faults::default() };
        let control = Grbl::new(&faults, 0.01).that_tells_its_place([5.0, 6.0, 7.0]);
        let (ended, _) = sent("grbl", &lines, control, faults);
        let is_lost =
            matches!(&ended, Ended::Lost(_, why) if why.contains("X at 1.000 mm") && why.contains("10.000 mm"));
        assert_eq!((is_lost, ended == Ended::Done), (is_found, !is_found), "{ended:?}");
    }
}

/// A control that states no offset, and one whose program ends with a move of unknown length: the job is done, and nothing is confirmed.
#[test]
fn without_a_position_that_can_be_compared_nothing_is_confirmed() {
    let faults = || Faults { most_bytes: 40, latency_s: 0.002, ..Faults::default() };
    let (ended, confirmed) = sent("grbl", MOVES, Grbl::new(&faults(), 0.01), faults());
    assert_eq!((ended, confirmed), (Ended::Done, None));
    let control = Grbl::new(&faults(), 0.01).that_tells_its_place([0.0, 0.0, 0.0]);
    let (ended, confirmed) = sent("grbl", &["G21G90", "G0X1", "G28", "M30"], control, faults());
    assert_eq!((ended, confirmed), (Ended::Done, None));
}

#[test]
fn grbl_in_an_alarm_gets_no_line() {
    let profile = profile("grbl");
    let faults = Faults { most_bytes: 64, ..Faults::default() };
    let mut notes = Notes::default();
    let mut planned = Planned::new(5, 0.01);
    let mut cable = Cable::new(Grbl::new(&faults, 0.01).in_alarm(), faults, 1);
    let ended = controls::run(&mut sender(&profile, &mut notes), &mut cable, &mut planned);
    assert!(matches!(&ended, Ended::Lost(_, why) if why.contains("alarm")), "{ended:?}");
    assert!(notes.frozen.is_empty());
}

#[test]
fn grbl_that_is_not_idle_gets_no_line() {
    let profile = profile("grblhal");
    for state in
        ["Run", "Run:2", "Hold:0", "Hold:1", "Door:1", "Alarm:1", "Home", "Check", "Jog", "Sleep", "Tool", "Odd"]
    {
        let faults = Faults { most_bytes: 64, ..Faults::default() };
        let (mut notes, mut planned) = (Notes::default(), Planned::new(5, 0.01));
        let mut cable = Cable::new(Grbl::new(&faults, 0.01).that_says(state), faults, 1);
        let ended = controls::run(&mut sender(&profile, &mut notes), &mut cable, &mut planned);
        let shown = format!("not idle ({state})");
        assert!(matches!(&ended, Ended::Lost(_, why) if why.contains(&shown)), "{state}: {ended:?}");
        assert!(notes.frozen.is_empty() && cable.control.executed().is_empty(), "{state}");
    }
}

#[test]
fn answers_that_an_earlier_job_left_in_the_port_say_nothing_about_now() {
    for name in ["grbl", "grblhal"] {
        let faults = Faults { most_bytes: 64, ..Faults::default() };
        let (mut notes, mut planned) = (Notes::default(), Planned::new(5, 0.01));
        let mut cable = Cable::new(Grbl::new(&faults, 0.01).with_answers_that_nobody_read(), faults, 1);
        let ended = controls::run(&mut sender(&profile(name), &mut notes), &mut cable, &mut planned);
        assert_eq!(ended, Ended::Done, "{name}");
        assert_eq!(cable.control.executed().len(), 5, "{name}");
    }
}

#[test]
fn what_a_control_states_of_its_planner_is_written_down_before_the_first_line() {
    let faults = Faults { most_bytes: 64, ..Faults::default() };
    let controls = [
        // The buffer of segments comes on top: 16.
        (Grbl::new(&faults, 0.01), Some((31, "[OPT:V,15,128]"))),
        (Grbl::new(&faults, 0.01).of_a_hundred_blocks(), Some((116, "[OPT:V,100,1024]"))),
        (Grbl::new(&faults, 0.01).that_tells_no_sizes(), None),
        // It knows no $I; what is free of an idle one is all that there is.
        (Grbl::new(&faults, 0.01).that_is_old(), Some((31, "Bf:15,128"))),
    ];
    for (control, expected) in controls {
        let (mut notes, mut planned) = (Notes::default(), Planned::new(5, 0.01));
        let mut cable = Cable::new(control, faults.clone(), 1);
        let ended = controls::run(&mut sender(&profile("grblhal"), &mut notes), &mut cable, &mut planned);
        assert_eq!(ended, Ended::Done);
        let holds: Vec<(usize, u64, &str)> = (0..)
            .zip(&notes.events)
            .filter_map(|(place, event)| match event {
                Event::Holds(most, said) => Some((place, *most, said.as_str())),
                _ => None,
            })
            .collect();
        let first = notes.events.iter().position(|event| matches!(event, Event::Acknowledged(_))).unwrap();
        match (expected, &holds[..]) {
            (None, []) => {}
            (Some((most, said)), [(place, found, words)]) => {
                assert!(*place < first && *found == most && words.contains(said), "{holds:?}");
            }
            _ => panic!("{expected:?}: {holds:?}"),
        }
    }
}

#[test]
fn a_bound_of_a_planner_needs_its_source_and_a_planner() {
    let read = |text: &str| Profile::read(&Source::new(FileId(0), "own.toml", text.as_bytes().to_vec()).unwrap());
    let depth =
        |protocol: &str, rest: &str| read(&format!("name = \"own\"\nprotocol = \"{protocol}\"\n[depth]\n{rest}"));
    let good = depth("marlin", "at_most = 64\nsource = \"Configuration_adv.h\"").unwrap();
    assert_eq!(good.depth.map(|bound| bound.at_most), Some(64));
    for (protocol, rest) in [
        ("marlin", "at_most = 64"),
        ("grbl", "source = \"a guess\""),
        ("grbl", "at_most = 64\nsource = \" \""),
        ("grbl", "at_most = -1\nsource = \"a manual\""),
        ("tape", "at_most = 5\nsource = \"a manual\""),
        ("block", "at_most = 5\nsource = \"a manual\""),
        ("linuxcncrsh", "at_most = 5\nsource = \"a manual\""),
    ] {
        assert!(depth(protocol, rest).is_err(), "{protocol}: {rest}");
    }
    // Of those that are shipped none claims one.
    for (name, _) in PROFILES {
        assert_eq!(profile(name).depth, None, "{name}");
    }
}

/// A job that was killed leaves lines in the control and answers that nobody has read: a report, and `ok` after `ok` while the control goes on.
#[test]
fn answers_to_an_earlier_job_are_none_to_this_one() {
    let profile = profile("grbl");
    let faults = Faults { most_bytes: 64, ..Faults::default() };
    for busy_s in [0.01, 0.2, 0.7] {
        for is_old in [false, true] {
            let mut control = Grbl::new(&faults, busy_s);
            if is_old {
                control = control.that_is_old();
            }
            let earlier: Vec<Vec<u8>> = (10..30).map(|k| format!("G1X{k}").into_bytes()).collect();
            control.hear(b'?', 0.0);
            let bytes = earlier.iter().flat_map(|line| line.iter().copied().chain([b'\n']));
            bytes.for_each(|byte| control.hear(byte, 0.0));
            let mut notes = Notes::default();
            let mut planned = Planned::new(40, 0.01);
            let mut cable = Cable::new(control, faults.clone(), 1);
            let mut ended = controls::run(&mut sender(&profile, &mut notes), &mut cable, &mut planned);
            // Where it is still busy with that job it gets no line; when it has come to rest it does.
            if let Ended::Lost(_, why) = &ended {
                assert!(why.contains("not idle (Run") && notes.frozen.is_empty(), "{busy_s} {is_old}: {why}");
                assert_eq!(cable.control.executed(), earlier, "{busy_s} {is_old}");
                notes = Notes::default();
                cable = Cable::new(cable.control, faults.clone(), 2);
                ended = controls::run(&mut sender(&profile, &mut notes), &mut cable, &mut planned);
            } else {
                assert!(busy_s < 0.2, "{busy_s} {is_old}");
            }
            assert_eq!(ended, Ended::Done, "{busy_s} {is_old}");
            assert_eq!(cable.control.executed(), [earlier, planned.lines].concat(), "{busy_s} {is_old}");
            assert_eq!(cable.control.overflows, 0);
        }
    }
}

#[test]
fn an_answer_that_got_lost_may_have_been_a_refusal() {
    let profile = profile("grbl");
    let faults = Faults { most_bytes: 64, lost: vec![10], ..Faults::default() };
    let mut notes = Notes::default();
    let mut planned = Planned::new(30, 0.01);
    let mut cable = Cable::new(Grbl::new(&faults, 0.01), faults, 1);
    let ended = controls::run(&mut sender(&profile, &mut notes), &mut cable, &mut planned);
    assert!(matches!(&ended, Ended::Lost(_, why) if why.contains("an answer was lost")), "{ended:?}");
    assert!(!notes.events.contains(&Event::Acknowledged(30)));
}

/// Transfers to readers with faults; returns how many had everything carried out.
fn readers(name: &str, reserve: usize, seeds: std::ops::Range<u64>) -> usize {
    let profile = profile(name);
    let mut whole = 0;
    for seed in seeds {
        let mut random = Random::new(seed, "job");
        let (count, busy_s) = (20 + random.below(60), random.between(0.001, 0.2));
        let mut faults = faults(seed, 8);
        (faults.refuses, faults.latency_s) = (None, random.between(0.0, 0.002));
        faults.characters_per_s = profile.serial.characters_per_s();
        faults.tells_queue = random.unit() < 0.5;
        let is_lost = !faults.lost.is_empty();
        let is_garbled = !faults.garbled.is_empty();
        let is_cut = faults.reset_s.is_some() || faults.unplugged_s.is_some();
        let mut notes = Notes::default();
        let mut planned = Planned::new(count, busy_s);
        let mut reader = Reader::new(&faults, busy_s, reserve, seed);
        reader.is_reading = profile.frame.start.is_empty();
        let mut cable = Cable::new(reader, faults, seed);
        let mut sender = sender(&profile, &mut notes);
        let ended = controls::run_with_patience(&mut sender, &mut cable, &mut planned, 3);
        let progress = sender.progress().clone();
        drop(sender);
        let (control, executed) = (&cable.control, cable.control.executed());
        // No gap, no repeat: the beginning of what was planned. Whether a reset cut it short this link does not tell.
        assert!(planned.lines.starts_with(executed), "seed {seed}: {ended:?}");
        assert_eq!(notes.frozen, planned.lines[..notes.frozen.len()], "seed {seed}");
        assert_eq!(progress.acknowledged, 0, "seed {seed}");
        // What was carried out has left, and what has left was frozen.
        let left = progress.left as usize;
        assert!(left <= notes.frozen.len(), "seed {seed}");
        if ended == Ended::Done {
            assert!(executed.len() <= left, "seed {seed}");
            assert_eq!(left, count, "seed {seed}");
        }
        // Too much comes only where an XOFF got lost, and then the control stands.
        assert!(control.overflows == 0 || is_lost, "seed {seed}: {ended:?}");
        if !is_lost && !is_garbled && !is_cut {
            assert_eq!((&ended, executed.len()), (&Ended::Done, count), "seed {seed}");
            assert_eq!(progress.stalls, 0, "seed {seed}");
        }
        // It never goes on blind: where it did not end well it was said that nothing moves, that the control was reset or that the cable is drawn.
        let is_told = match &ended {
            Ended::Done => true,
            Ended::Lost(_, why) if why.contains("as requested") => progress.stalls >= 3,
            // The first XON got lost, and nothing was sent.
            Ended::Stopped => left == 0 && progress.stalls >= 3,
            Ended::Lost(_, why) if why.contains("has no meaning on this link") => is_garbled,
            // An XOFF got lost, and nothing went over.
            Ended::Lost(_, why) if why.contains("although it receives them") => is_lost || is_garbled,
            Ended::Lost(_, why) => is_cut && (why.contains("reset (SYN)") || why.contains("the link is gone")),
            _ => false,
        };
        assert!(is_told, "seed {seed}: {ended:?}");
        whole += usize::from(executed.len() == count);
    }
    whole
}

#[test]
fn readers_get_every_byte_whatever_happens_to_those_that_hold_the_flow() {
    // So much room is left when they say XOFF: what is handed over, and what goes out until it is heard.
    let whole = readers("fanuc-rs232", 24, 0..2000) + readers("siemens-v24", 120, 2000..4000);
    assert!(whole > 2000, "{whole}");
}

#[test]
fn an_xon_that_got_lost_is_said_and_nothing_goes_on() {
    let profile = profile("fanuc-rs232");
    let rate = profile.serial.characters_per_s();
    // The second byte that the control says is its first XOFF, the third the XON behind it.
    let faults = Faults { most_bytes: 64, lost: vec![3], characters_per_s: rate, ..Faults::default() };
    let (mut notes, mut planned) = (Notes::default(), Planned::new(200, 0.2));
    let mut reader = Reader::new(&faults, 0.2, 24, 1);
    reader.asks_again = false;
    let mut cable = Cable::new(reader, faults, 1);
    let mut sender = sender(&profile, &mut notes);
    let ended = controls::run_with_patience(&mut sender, &mut cable, &mut planned, 3);
    let stalls = sender.progress().stalls;
    drop(sender);
    assert!(matches!(&ended, Ended::Lost(_, why) if why.contains("as requested")), "{ended:?}");
    assert_eq!((stalls, cable.control.asked.contains(&3)), (3, true));
    // All that came whole was carried out.
    let executed = cable.control.executed();
    assert!(executed.len() < 200 && planned.lines.starts_with(executed), "{}", executed.len());
}

#[test]
fn linuxcnc_carries_out_one_line_after_the_other() {
    let profile = profile("linuxcnc");
    let mut done = 0;
    for seed in 0..4000 {
        let mut random = Random::new(seed, "job");
        let (count, busy_s) = (5 + random.below(20), random.between(0.001, 0.5));
        let mut faults = faults(seed, count);
        // Bytes do not get lost there, but somebody may break off what runs.
        if std::mem::take(&mut faults.lost).pop().is_some() {
            faults.broken_off_s = Some(random.between(0.5, 4.0));
        }
        faults.doubled.clear();
        faults.garbled.clear();
        let refused = faults.refuses;
        let (mut notes, mut planned) = (Notes::default(), Planned::new(count, busy_s));
        planned.lines[0] = b"M3S500".to_vec();
        let mut cable = Cable::new(Rsh::new(&faults, busy_s), faults.clone(), seed);
        let mut sender = sender(&profile, &mut notes);
        let ended = controls::run(&mut sender, &mut cable, &mut planned);
        let progress = sender.progress().clone();
        drop(sender);
        let executed = cable.control.executed();
        assert!(planned.lines.starts_with(executed), "seed {seed}: {ended:?}");
        let acknowledged = progress.acknowledged as usize;
        assert_eq!(progress.executed.unwrap_or(0), progress.acknowledged, "seed {seed}");
        // What is acknowledged is done; the one behind it may be.
        assert!(acknowledged <= executed.len() && executed.len() <= acknowledged + 1, "seed {seed}: {ended:?}");
        match &ended {
            Ended::Done => assert_eq!(executed.len(), count, "seed {seed}"),
            Ended::Refused(number, said) => {
                assert_eq!(Some(*number), refused, "seed {seed}");
                assert!(said.contains("positive limit"), "seed {seed}: {said}");
                assert_eq!(acknowledged as u64 + 1, *number, "seed {seed}");
            }
            Ended::Lost(_, why) => {
                let is_expected = why.contains("the link is gone") && faults.unplugged_s.is_some()
                    || why.contains("was switched off") && faults.reset_s.is_some()
                    || why.contains("machine is off") && faults.reset_s.is_some()
                    || why.contains("the spindle has stopped") && faults.reset_s.is_some()
                    || why.contains("it does not switch to MDI") && faults.reset_s.is_some()
                    || why.contains("aborted") && faults.broken_off_s.is_some();
                assert!(is_expected, "seed {seed}: {ended:?}");
            }
            Ended::Stopped | Ended::Held(_) | Ended::Fault(_) => panic!("seed {seed}: {ended:?}"),
        }
        done += usize::from(ended == Ended::Done);
    }
    // More than a third has no fault that matters here.
    assert!(done > 1600, "{done}");
}

#[test]
fn linuxcnc_that_is_not_ready_gets_no_line() {
    let profile = profile("linuxcnc");
    for (change, says) in [
        (Box::new(|control: &mut Rsh| control.is_on = false) as Box<dyn Fn(&mut Rsh)>, "switch it on"),
        (Box::new(|control: &mut Rsh| control.is_homed = false), "when not homed"),
    ] {
        let faults = Faults { most_bytes: 64, ..Faults::default() };
        let (mut notes, mut planned) = (Notes::default(), Planned::new(5, 0.01));
        let mut control = Rsh::new(&faults, 0.01);
        change(&mut control);
        let mut cable = Cable::new(control, faults, 1);
        let ended = controls::run(&mut sender(&profile, &mut notes), &mut cable, &mut planned);
        assert!(matches!(&ended, Ended::Lost(_, why) if why.contains(says)), "{ended:?}");
        assert!(notes.frozen.is_empty());
    }
}

#[test]
fn linuxcnc_that_another_client_takes_over_gets_no_further_line() {
    let profile = profile("linuxcnc");
    for tenth in 10..60 {
        let faults = Faults { most_bytes: 64, ..Faults::default() };
        let (mut notes, mut planned) = (Notes::default(), Planned::new(40, 0.3));
        let mut control = Rsh::new(&faults, 0.3);
        control.taken_over_s = Some(f64::from(tenth) / 10.0);
        let mut cable = Cable::new(control, faults, 1);
        let ended = controls::run(&mut sender(&profile, &mut notes), &mut cable, &mut planned);
        let executed = cable.control.executed();
        assert!(planned.lines.starts_with(executed) && executed.len() < 40, "{tenth}: {ended:?}");
        let says =
            ["took over the control", "second password", "neither set_wait nor wait_mode", "does not switch to MDI"];
        assert!(
            matches!(&ended, Ended::Lost(_, why) if says.iter().any(|part| why.contains(part))),
            "{tenth}: {ended:?}"
        );
        assert!(
            executed.is_empty() || matches!(&ended, Ended::Lost(_, why) if why.contains(says[0])),
            "{tenth}: {ended:?}"
        );
    }
}

#[test]
fn linuxcnc_is_not_asked_for_what_it_cannot_do_in_mdi() {
    let profile = profile("linuxcnc");
    for (text, says) in [("M0", "does not stop at M0"), ("O100 CALL", "O-words"), ("G1 X1 M30\nG1X2", "has ended")] {
        let faults = Faults { most_bytes: 64, ..Faults::default() };
        let (mut notes, mut planned) = (Notes::default(), Planned::new(1, 0.01));
        // A % and a blank line say nothing to it.
        planned.lines = [b"%".to_vec(), b"".to_vec()].to_vec();
        planned.lines.extend(text.split('\n').map(|line| line.as_bytes().to_vec()));
        let mut cable = Cable::new(Rsh::new(&faults, 0.01), faults, 1);
        let ended = controls::run(&mut sender(&profile, &mut notes), &mut cable, &mut planned);
        assert!(matches!(&ended, Ended::Fault(why) if why.contains(says)), "{text}: {ended:?}");
        assert!(notes.events.contains(&Event::Executed(2)), "{text}");
    }
}

#[test]
fn every_link_and_protocol_is_documented_and_every_profile_is_shipped() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(folder.join("docs/reference/feed.md")).unwrap();
    for name in PROFILES.iter().map(|(name, _)| *name).chain(PROTOCOLS.iter().map(|protocol| protocol.name)) {
        assert!(text.contains(&format!("`{name}`")), "docs/reference/feed.md does not name {name}");
    }
    for entry in std::fs::read_dir(folder.join("crates/dnc/links")).unwrap() {
        let name = entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned();
        assert!(PROFILES.iter().any(|(known, _)| *known == name), "links/{name}.toml is not registered");
    }
}
