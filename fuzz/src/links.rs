//! Links: dialogues with a control that says anything, profiles, journals.

use std::collections::VecDeque;
use std::time::Duration;

use ncfix_dnc::feed::{Event, Halt, Line, PROFILES, Profile, Wire, read_journal};

use super::{check_findings, source};

/// What a dialogue may keep to itself of what was not sent, bytes: lines of its window and questions.
const MOST_WAITING: usize = 100_000;

/// A control at the other end of each shipped link. The first byte is the link; of the others some are time, halts or what the port takes, and the rest
/// is what the control says.
pub fn dialogues(bytes: &[u8]) {
    let Some((first, script)) = bytes.split_first() else { return };
    let (name, text) = PROFILES[usize::from(*first) % PROFILES.len()];
    let profile = Profile::read(&source(name, text.as_bytes())).expect("a shipped profile");
    let protocol = profile.protocol;
    let mut dialogue = (protocol.create)(&profile).expect("a shipped profile fits its protocol");
    let mut wire = Wire::default();
    let mut job = Job { sent: 0, acknowledged: 0, executed: 0, is_lost: false };
    let mut now = Duration::ZERO;
    let mut events = Vec::new();
    dialogue.open(now, &mut wire);
    let mut said: VecDeque<&[u8]> = script.split(|&byte| byte == 0xff).collect();
    while let Some(chunk) = said.pop_front() {
        // A chunk begins with how much time has passed, what the port takes, and what a person does.
        let (act, heard) = chunk.split_first().map_or((0, chunk), |(act, heard)| (*act, heard));
        now += Duration::from_millis([0, 1, 30, 300, 3_000, 60_000, 3_600_000, 20][usize::from(act % 8)]);
        let taken = wire.next([1, 16, 256, 4096][usize::from(act / 8 % 4)]).len();
        wire.took(taken);
        wire.queue(if act & 32 == 0 { 0 } else { taken });
        dialogue.hear(heard, now, &mut wire, &mut events);
        dialogue.tick(now, &mut wire, &mut events);
        if act == 0xfe {
            let _ = dialogue.halt([Halt::Hold, Halt::Stop, Halt::Abort][heard.len() % 3], now, &mut wire);
        }
        job.note(&mut events);
        let line = Line {
            number: job.sent + 1,
            text: format!("G1 X{} F500", job.sent).into_bytes(),
            busy_s: 0.1,
            ..Line::default()
        };
        if !job.is_lost && dialogue.is_open() && act < 0xfe && dialogue.has_room(line.text.len() + 2) {
            profile.check(&line.text).expect("a plain line");
            dialogue.send(&line, now, &mut wire).expect("a plain line");
            job.sent += 1;
        }
        let (lines, _) = dialogue.in_flight();
        // What opens and closes a transfer counts too, where it is answered like a line.
        assert!(lines as u64 <= job.sent + 1, "{name}: {lines} of {}", job.sent);
        assert!(wire.waiting() <= MOST_WAITING, "{name}: {}", wire.waiting());
    }
    dialogue.close(now, &mut wire);
    dialogue.tick(now, &mut wire, &mut events);
    job.note(&mut events);
    if dialogue.is_done(&wire) && !job.is_lost {
        let (lines, _) = dialogue.in_flight();
        assert_eq!(lines, 0, "{name} is done");
    }
}

/// What is known of the lines.
struct Job {
    sent: u64,
    acknowledged: u64,
    executed: u64,
    is_lost: bool,
}

impl Job {
    /// Only lines that were sent are answered, and in their order.
    fn note(&mut self, events: &mut Vec<Event>) {
        for event in events.drain(..) {
            match event {
                Event::Acknowledged(number) | Event::Left(number) => {
                    assert!((self.acknowledged..=self.sent).contains(&number), "{number} of {}", self.sent);
                    self.acknowledged = number;
                }
                Event::Executed(number) => {
                    assert!((self.executed..=self.sent).contains(&number), "{number} of {}", self.sent);
                    self.executed = number;
                }
                Event::Checked(number) => assert!(number <= self.acknowledged, "{number} of {}", self.acknowledged),
                Event::Repeated(number) => assert!(number <= self.sent, "{number} of {}", self.sent),
                Event::Refused(number, said) => {
                    assert!(number <= self.sent && !said.is_empty(), "{number} of {}", self.sent);
                    self.is_lost = true;
                }
                Event::Lost(_, why) => {
                    assert!(!why.is_empty());
                    self.is_lost = true;
                }
                Event::Holds(most, said) => assert!(most > 0 && self.sent == 0 && !said.is_empty(), "{most}: {said}"),
                Event::InPosition(axes) => assert!(!axes.is_empty()),
                Event::Paused(_) | Event::Reported(_) | Event::Said(_) | Event::Stalled | Event::ZeroOffsets(_) => {}
            }
        }
    }
}

/// A file of a link: what was read can be used.
pub fn profile(bytes: &[u8]) {
    let file = source("link.toml", bytes);
    match Profile::read(&file) {
        Err(findings) => check_findings(&findings, &[&file]),
        Ok(profile) => {
            let protocol = profile.protocol;
            if let Ok(mut dialogue) = (protocol.create)(&profile) {
                let mut wire = Wire::default();
                dialogue.open(Duration::ZERO, &mut wire);
                dialogue.hear(
                    b"ok\r\nGrbl 1.1f ['$' for help]\r\nok\r\n",
                    Duration::from_secs(1),
                    &mut wire,
                    &mut Vec::new(),
                );
            }
            let _ = profile.check(b"G1 X1");
            assert!(profile.serial.characters_per_s().is_finite());
        }
    }
}

/// A journal: its numbers follow from each other, and what was written last changes nothing of what was written before.
pub fn journal(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    match read_journal(&text) {
        Err((line, why)) => assert!(line >= 1 && line <= text.split('\n').count() && !why.is_empty(), "{line} {why}"),
        Ok(told) => {
            assert!(told.acknowledged <= told.frozen && told.executed <= told.frozen && told.left <= told.frozen);
            let numbers: Vec<u64> = told.lines.iter().map(|line| line.number).collect();
            assert!(numbers.windows(2).all(|pair| pair[1] == pair[0] + 1), "{numbers:?}");
            assert!(numbers.last().is_none_or(|last| *last == told.frozen));
            // A record without its end is none: the program died while it was written.
            assert_eq!(
                read_journal(&format!("{}x", text.get(..=text.rfind('\n').unwrap_or(0)).unwrap_or_default())).ok(),
                Some(told)
            );
        }
    }
}
