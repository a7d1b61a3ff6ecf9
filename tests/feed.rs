//! Whole transfers over a simulated cable to simulated controls, with faults by script: what is carried out is what was planned.

use ncfix::feed::{Ended, Event, PROFILES, PROTOCOLS, Profile, Sender};
use ncfix::source::{FileId, Source};

use super::controls::{self, Blockwise, Cable, Control, Faults, Grbl, Marlin, Notes, Planned};
use super::plant::random::Random;

fn profile(name: &str) -> Profile {
    let (_, text) = PROFILES.iter().find(|(known, _)| *known == name).unwrap();
    Profile::read(&Source::new(FileId(0), name, text.as_bytes().to_vec()).unwrap()).unwrap()
}

fn sender<'a>(profile: &Profile, notes: &'a mut Notes) -> Sender<'a> {
    let protocol = PROTOCOLS.iter().find(|protocol| protocol.name == profile.protocol).unwrap();
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
fn marlin_makes_good_whatever_gets_lost_or_garbled_in_either_way() {
    let done = jobs(
        "marlin",
        0..4000,
        Marlin::new,
        |faults| faults.refuses = None,
        |_, ended, seed| {
            let is_expected = match ended {
                Ended::Done => true,
                Ended::Lost(why) => {
                    ["reset", "the link is gone", "asks for line"].iter().any(|part| why.contains(part))
                }
                _ => false,
            };
            assert!(is_expected, "seed {seed}: {ended:?}");
        },
    );
    // Only resets, drawn cables and wrong demands end a job.
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

#[test]
fn grbl_in_an_alarm_gets_no_line() {
    let profile = profile("grbl");
    let faults = Faults { most_bytes: 64, ..Faults::default() };
    let mut notes = Notes::default();
    let mut planned = Planned::new(5, 0.01);
    let mut cable = Cable::new(Grbl::new(&faults, 0.01).in_alarm(), faults, 1);
    let ended = controls::run(&mut sender(&profile, &mut notes), &mut cable, &mut planned);
    assert!(matches!(&ended, Ended::Lost(why) if why.contains("alarm")), "{ended:?}");
    assert!(notes.frozen.is_empty());
}

#[test]
fn an_answer_that_got_lost_may_have_been_a_refusal() {
    let profile = profile("grbl");
    let faults = Faults { most_bytes: 64, lost: vec![10], ..Faults::default() };
    let mut notes = Notes::default();
    let mut planned = Planned::new(30, 0.01);
    let mut cable = Cable::new(Grbl::new(&faults, 0.01), faults, 1);
    let ended = controls::run(&mut sender(&profile, &mut notes), &mut cable, &mut planned);
    assert!(matches!(&ended, Ended::Lost(why) if why.contains("an answer was lost")), "{ended:?}");
    assert!(!notes.events.contains(&Event::Acknowledged(30)));
}
