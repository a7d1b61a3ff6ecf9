//! Controls that lie, beside the faithful ones of `feed.rs`: whatever is answered, the control has received the beginning of what was to be sent, nothing
//! twice and nothing left out, the job ends, and what the journal says was carried out for sure was.
//!
//! `NCFIX_ADVERSARY_SCRIPTS` is how many scripts each dialogue gets (1,000).

use std::time::Duration;

use ncfix_base::source::{FileId, Source};
use ncfix_dnc::feed::{Bound, Ended, Journal, PROFILES, Patience, Profile, Sender, read_journal};

use super::controls::liar::{Liar, Lies};
use super::controls::part::PART;
use super::controls::{Blockwise, Control, Faults, Grbl, Marlin, Planned, Reader, Rsh};
use super::plant::random::Random;

/// Nothing may stand still for longer.
const PATIENCE: Patience = Patience { stall: Duration::from_secs(20), hold: Duration::from_secs(40) };

fn scripts() -> u64 {
    std::env::var("NCFIX_ADVERSARY_SCRIPTS").ok().and_then(|count| count.parse().ok()).unwrap_or(1000)
}

fn profile(name: &str) -> Profile {
    let (_, text) = PROFILES.iter().find(|(known, _)| *known == name).unwrap();
    Profile::read(&Source::new(FileId(0), name, text.as_bytes().to_vec()).unwrap()).unwrap()
}

/// The same where its user has stated how many blocks the planner holds: what was taken before as many counts as carried out, if it was taken.
fn bounded(profile: &Profile, is_bounded: bool) -> Profile {
    let bound = Bound { at_most: 15, source: "the planner of the double".to_owned() };
    Profile { depth: is_bounded.then_some(bound), ..profile.clone() }
}

/// What a script was about, and how it ended.
struct Told<C> {
    seed: u64,
    ended: Ended,
    planned: Vec<Vec<u8>>,
    wrote: Vec<u8>,
    /// Bytes that went out behind the end.
    last_words: Vec<u8>,
    /// Lines that are taken for carried out, and those that would not be sent when the job is taken up again.
    sure: u64,
    left_out: usize,
    frozen: usize,
    /// Lines that the control had carried out when the job ended.
    by_then: usize,
    control: C,
}

impl<C: Control> Told<C> {
    /// The beginning of what was planned, and nothing else.
    fn check_executed(&self) {
        let executed = self.control.executed();
        assert!(self.planned.starts_with(executed), "{self}: {:?}", executed.last());
        self.check_sure(executed.len());
        if self.ended == Ended::Done {
            assert_eq!(executed.len(), self.planned.len(), "{self}");
        }
    }

    /// What is taken for carried out was; it is sent again from the next line on, at the latest.
    fn check_sure(&self, executed: usize) {
        let executed = executed.min(self.by_then);
        assert!(self.sure <= executed as u64, "{self}: {} for sure, {executed} in truth", self.sure);
        assert!(self.left_out <= executed, "{self}: {} lines would be left out, {executed} in truth", self.left_out);
    }

    /// The bytes of lines that went out are the beginning of what was to go out.
    fn check_bytes(&self, bytes: &[u8], end: &[u8]) {
        let frozen = &self.planned[..self.frozen];
        let mut all: Vec<u8> = frozen.iter().flat_map(|line| line.iter().copied().chain(*b"\n")).collect();
        all.extend(end);
        assert!(all.starts_with(bytes), "{self}: {}", String::from_utf8_lossy(bytes));
    }
}

impl<C> std::fmt::Display for Told<C> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "script {}, {:?}", self.seed, self.ended)
    }
}

/// Runs a script to its end, and the control until nothing is left to do.
fn run<C: Control>(
    profile: &Profile,
    (seed, random): (u64, &mut Random),
    lies: Lies,
    (is_lines, character_s): (bool, f64),
    create: impl FnOnce(f64) -> C,
) -> Told<C> {
    let busy_s = random.between(0.002, 0.06);
    let mut planned = Planned::of(&PART, busy_s);
    let mut liar = Liar::new(create(busy_s), lies, is_lines, character_s, seed);
    let mut journal = Journal::new(Vec::new(), &[]).unwrap();
    let protocol = profile.protocol;
    let dialogue = (protocol.create)(profile).unwrap();
    let mut sender = Sender::new(dialogue, profile.window.system_bytes, &mut journal).patient(PATIENCE);
    let (mut now_s, mut step_s) = (0.0, 0.002);
    let mut turn = |liar: &mut Liar<C>, sender: &mut Sender<'_>, planned: &mut Planned| {
        // The clock runs faster while nothing happens.
        step_s = if std::mem::take(&mut liar.has_moved) { 0.002 } else { f64::min(step_s * 1.2, 0.06) };
        now_s += step_s;
        liar.turn_to(now_s);
        let ended = sender.step(Duration::from_secs_f64(now_s), liar, planned, &mut |_| ()).unwrap();
        // Ten times what all lines take and what is granted, many times over.
        assert!(now_s < 900.0, "script {seed} does not end: {:?}", sender.progress());
        ended
    };
    let ended = loop {
        if let Some(ended) = turn(&mut liar, &mut sender, &mut planned) {
            break ended;
        }
    };
    let (until, by_then) = (liar.wrote.len(), liar.control.executed().len());
    (0..200).for_each(|_| _ = turn(&mut liar, &mut sender, &mut planned));
    drop(sender);
    let text = String::from_utf8(journal.into_store().unwrap()).unwrap();
    let told = read_journal(&text).unwrap();
    let last_words = liar.wrote.split_off(until);
    let holds = told.holds.as_ref().map(|(most, _)| *most).max(profile.holds_at_most());
    let (sure, left_out) = PART.restart(&told, holds.filter(|_| protocol.has_planner));
    Told {
        seed,
        ended,
        planned: planned.lines,
        wrote: liar.wrote,
        last_words,
        sure,
        left_out,
        frozen: told.frozen as usize,
        by_then,
        control: liar.control,
    }
}

/// Chances: most scripts have some kinds of lies, a few of each, so that many get far.
fn lies(random: &mut Random) -> Lies {
    let mut lies = Lies::default();
    let much = random.pick(&[0.005, 0.02, 0.1]);
    let kinds = 1 + random.below(3);
    for _ in 0..kinds {
        let one = match random.below(8) {
            0 => &mut lies.lost,
            1 => &mut lies.doubled,
            2 => &mut lies.echoed,
            3 => &mut lies.late,
            4 => &mut lies.garbled,
            5 => &mut lies.miscounted,
            6 => &mut lies.noise,
            _ => &mut lies.forged,
        };
        *one = much;
    }
    lies.forged *= 20.0;
    lies.most_surplus = usize::MAX;
    lies
}

fn texts(texts: &[&str]) -> Vec<Vec<u8>> {
    texts.iter().map(|text| format!("{text}\r\n").into_bytes()).collect()
}

fn lines_of(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    // What is behind the last end was cut off.
    bytes.split_inclusive(|byte| *byte == b'\n').filter_map(|line| line.strip_suffix(b"\n"))
}

/// Without the dwells by which a control comes to rest.
fn without_rests(bytes: &[u8]) -> Vec<u8> {
    let rest: &[u8] = b"G4 P0.01\n";
    let lines = bytes.split_inclusive(|byte| *byte == b'\n').filter(|line| *line != rest);
    let mut out = lines.collect::<Vec<_>>().concat();
    // One that was cut off.
    if let Some(begun) =
        (1..rest.len()).rev().find(|count| out.ends_with(&rest[..*count]) && bytes.last() != Some(&b'\n'))
        && out[..out.len() - begun].last().is_none_or(|byte| *byte == b'\n')
    {
        out.truncate(out.len() - begun);
    }
    out
}

/// How often each script ended well: lies that are made good, and those that come when it is over.
fn check_share(name: &str, done: u64, least: f64) {
    let share = done as f64 / scripts() as f64;
    assert!(share > least, "{name}: {done} of {} done", scripts());
}

#[test]
fn grbl_that_lies() {
    let profile = profile("grbl");
    let (mut done, mut overrun, mut placed) = (0, 0, 0);
    for seed in 0..scripts() {
        let mut random = Random::new(seed, "grbl");
        let mut lies = lies(&mut random);
        let forgeries = [
            "ok",
            "error:9",
            "error:",
            "ALARM:1",
            "<Idle|MPos:0.000,0.000,0.000|Bf:15,128|FS:0,0>",
            "<Run|MPos:1.000,0.000,0.000|Bf:3,7>",
            "<Hold:0|MPos:0.000,0.000,0.000>",
            "<Alarm|MPos:0.000,0.000,0.000>",
            "<Sleep>",
            "Grbl 1.1h ['$' for help]",
            "GrblHAL 1.1f",
            "GRBL 0.9j ['$' for help]",
            "[MSG:Pgm End]",
            "[OPT:V,3,9]",
            ">G54G20:ok",
            "",
            "oK",
            "[MSG:'$H'|'$X' to unlock]",
            "$10=3",
        ];
        lies.forgeries = texts(&forgeries);
        let mut faults = Faults::default();
        let is_silent = random.unit() < 0.2;
        if is_silent || random.unit() < 0.2 {
            faults.reset_s = Some(random.between(0.1, 2.0));
        }
        if random.unit() < 0.15 {
            faults.refuses = Some(1 + random.below(40) as u64);
        }
        // Answers have no numbers: one too many beside one that is missing, or a refusal, cannot be told from what is right.
        let is_short =
            lies.lost + lies.garbled + lies.miscounted > 0.0 || faults.reset_s.is_some() || faults.refuses.is_some();
        // Of answers too many any number: what they would make overflow shows, and nothing is taken for carried out by them.
        lies.most_surplus = if is_short { 0 } else { random.pick(&[2, usize::MAX]) };
        if is_short {
            lies.forgeries.retain(|text| !text.starts_with(b"<"));
        }
        let tells_sizes = random.unit() < 0.6;
        let is_blind = !tells_sizes && lies.most_surplus > 2 && lies.doubled + lies.echoed + lies.forged > 0.0;
        lies.swallowed = is_silent.then_some(b"Grbl");
        let locks = random.unit() < 0.5;
        let profile = bounded(&profile, random.unit() < 0.5);
        let told = run(&profile, (seed, &mut random), lies, (true, 0.0), |busy_s| {
            let mut control = Grbl::new(&faults, busy_s);
            if !tells_sizes {
                control = control.that_tells_no_sizes();
            }
            control.locks = locks;
            // One that has answered everything, says nothing of its reset and goes on: nothing on this link shows that.
            control.resets_from = if is_silent && !locks { 40 } else { 0 };
            control
        });
        let control = &told.control;
        // Where nothing says what its buffer holds, answers without end make it overflow, and what is lost there makes good for those that are too many:
        // nobody can tell. A few of them show at the next rest.
        if control.overflows > 0 && is_blind {
            overrun += 1;
            continue;
        }
        assert_eq!(control.overflows, 0, "{told}");
        // Status, hold, and the question before the first line.
        let mut sent: Vec<u8> = told.wrote.iter().copied().filter(|byte| !b"?!".contains(byte)).collect();
        if sent.starts_with(b"$I\n") {
            sent.drain(..3);
        }
        told.check_bytes(&without_rests(&sent), b"");
        assert!(told.last_words.iter().all(|byte| *byte == b'!'), "{told}: {:?}", told.last_words);
        let before = control.before_reset.unwrap_or(control.executed().len());
        let executed = &control.executed()[..before];
        let refused = control.refused.map(|number| number as usize - 1);
        let plan: Vec<&Vec<u8>> =
            told.planned.iter().enumerate().filter(|(at, _)| Some(*at) != refused).map(|(_, line)| line).collect();
        assert!(executed.len() <= plan.len() && executed.iter().zip(&plan).all(|(done, line)| done == *line), "{told}");
        let truth = refused.map_or(before, |refused| before.min(refused));
        told.check_sure(truth);
        placed += u64::from(told.ended != Ended::Done && told.left_out > 0);
        if told.ended == Ended::Done {
            // A reset behind the last of them comes too late to matter.
            assert_eq!((executed.len(), control.refused), (told.planned.len(), None), "{told}");
            done += 1;
        }
        // What is carried out behind a reset had gone out before it showed.
        if let Some(since) = control.before_reset.map(|before| control.executed().len() - before) {
            assert!(since <= 15 + (1.0 / 0.002) as usize && (!locks || since == 0), "{told}: {since}");
        }
    }
    check_share("grbl", done, 0.2);
    assert!(placed > scripts() / 200, "{placed} places other than the beginning");
    assert!((overrun as f64) < 0.05 * scripts() as f64, "{overrun}");
}

#[test]
fn marlin_that_lies() {
    let profile = profile("marlin");
    let (mut done, mut placed) = (0, 0);
    for seed in 0..scripts() {
        let mut random = Random::new(seed, "marlin");
        let mut lies = lies(&mut random);
        let forgeries = [
            "ok",
            "ok N1005 P15 B3",
            "Resend: 1",
            "Resend: 2",
            "Resend: 1004",
            "Resend:1010",
            "rs N1012",
            "Resend: 10x3",
            "start",
            "Marlin 2.1.2",
            "echo: External Reset",
            "\u{7f}STart",
            "Error:checksum mismatch, Last Line: 1003",
            "Error:Printer halted. kill() called!",
            "wait",
            "echo:busy: processing",
            "echo:busy: paused for user",
            "//action:cancel",
            "T:20.0 /0.0",
            "ncfix-1040",
            "echo:Unknown command: \"G77\"",
            "skip 1",
        ];
        lies.forgeries = texts(&forgeries);
        let mut faults = Faults::default();
        let is_silent = random.unit() < 0.3;
        if is_silent || random.unit() < 0.1 {
            faults.reset_s = Some(random.between(0.1, 2.0));
        }
        for _ in 0..random.below(4) {
            faults.corrupted.push(1 + random.below(60) as u64);
        }
        lies.swallowed = is_silent.then_some(b"start");
        let (says_ok, numbers_ok) = (random.unit() < 0.5, random.unit() < 0.4);
        let profile = bounded(&profile, random.unit() < 0.5);
        let told = run(&profile, (seed, &mut random), lies, (true, 0.0), |busy_s| {
            let mut control = Marlin::new(&faults, busy_s);
            (control.says_ok, control.numbers_ok) = (says_ok, numbers_ok);
            control
        });
        told.check_executed();
        assert!(told.last_words.is_empty(), "{told}: {:?}", told.last_words);
        // Every line goes out behind the one before it, or once more; and always as the same bytes.
        let (mut last, mut last_number) = (0, 0);
        for line in lines_of(&told.wrote) {
            let text = String::from_utf8(line.to_vec()).unwrap();
            let (body, sum) = text.rsplit_once('*').unwrap();
            assert_eq!(sum.parse::<u8>().unwrap(), body.bytes().fold(0, |sum, byte| sum ^ byte), "{told}");
            let (number, words) = body[1..].split_once(' ').unwrap();
            if words.starts_with("M110") || words.starts_with("M118") || ["M114", "M400"].contains(&words) {
                continue;
            }
            // M110, M114, M400 and M118 have numbers of their own.
            let number = number.parse::<u64>().unwrap();
            last += usize::from(number != last_number);
            assert!(number >= last_number, "{told}: {text} behind {last_number}");
            assert_eq!(told.planned[last - 1], words.as_bytes(), "{told}");
            last_number = number;
        }
        placed += u64::from(told.ended != Ended::Done && told.left_out > 0);
        done += u64::from(told.ended == Ended::Done);
    }
    assert!(placed > scripts() / 200, "{placed} places other than the beginning");
    check_share("marlin", done, 0.2);
}

#[test]
fn blockwise_transfer_that_lies() {
    let profile = profile("heidenhain-fe1");
    let mut done = 0;
    for seed in 0..scripts() {
        let mut random = Random::new(seed, "block");
        let mut lies = lies(&mut random);
        // An ACK or NAK that nobody has said cannot be told from one; what else there is can.
        lies.forgeries = [&[0x00][..], &[0x18], &[0x04], &[0x11], &[0x15, 0x18], b"ok\r\n", &[0x7f], &[0x86]]
            .map(<[u8]>::to_vec)
            .to_vec();
        lies.echoed = 0.0;
        // Bits that turn an answer into the other one are no parity error only if there are two of them.
        let mut faults = Faults::default();
        for _ in 0..random.below(4) {
            faults.corrupted.push(1 + random.below(60) as u64);
        }
        let character_s = 1.0 / profile.serial.characters_per_s();
        let told =
            run(&profile, (seed, &mut random), lies, (false, character_s), |busy_s| Blockwise::new(&faults, busy_s));
        told.check_executed();
        assert!(told.last_words.is_empty(), "{told}: {:?}", told.last_words);
        assert_eq!(told.sure, 0, "{told}");
        // STX, text, ETB and check character, behind one another; one that was refused once more.
        let mut bytes = &told.wrote[told.wrote.iter().position(|byte| *byte == 0x02).unwrap_or(told.wrote.len())..];
        let mut last = 0;
        while let Some(end) = bytes.iter().position(|byte| *byte == 0x17) {
            let (text, rest) = (&bytes[1..end], bytes.get(end + 2..).unwrap_or_default());
            let is_again = last > 0 && told.planned[last - 1] == text;
            assert!(
                is_again || told.planned.get(last).is_some_and(|line| line == text),
                "{told}: {text:?} behind {last}"
            );
            last += usize::from(!is_again);
            bytes = rest;
        }
        done += u64::from(told.ended == Ended::Done);
    }
    check_share("block", done, 0.2);
}

#[test]
fn linuxcnc_that_lies() {
    let profile = profile("linuxcnc");
    let (mut done, mut unseen) = (0, 0);
    for seed in 0..scripts() {
        let mut random = Random::new(seed, "rsh");
        let mut lies = lies(&mut random);
        let forgeries = [
            "SET MDI ACK",
            "SET MDI NAK",
            "PROGRAM_STATUS IDLE",
            "PROGRAM_STATUS RUNNING",
            "PROGRAM_STATUS PAUSED",
            "SET WAIT ACK",
            "ENABLE ON",
            "ENABLE OFF",
            "MACHINE ON",
            "MODE MANUAL",
            "SPINDLE 0 OFF",
            "ERROR OK",
            "ERROR x",
            "error: x",
            "HELLO ACK EMCNETSVR 1.1",
            "SET NAK",
            "x",
        ];
        lies.forgeries = texts(&forgeries);
        // One that is missing beside the same one made up cannot be told from what is right.
        if lies.lost + lies.garbled + lies.miscounted > 0.0 {
            (lies.forged, lies.echoed, lies.doubled) = (0.0, 0.0, 0.0);
        }
        let mut faults = Faults::default();
        match random.below(10) {
            0 => faults.reset_s = Some(random.between(0.5, 5.0)),
            1 => faults.broken_off_s = Some(random.between(0.5, 5.0)),
            2 => faults.refuses = Some(1 + random.below(20) as u64),
            _ => {}
        }
        let told = run(&profile, (seed, &mut random), lies, (true, 0.0), |busy_s| Rsh::new(&faults, busy_s));
        if told.control.unseen {
            unseen += 1;
            continue;
        }
        told.check_executed();
        let sent: Vec<&[u8]> =
            lines_of(&told.wrote).filter_map(|line| line.strip_suffix(b"\r")?.strip_prefix(b"set mdi ")).collect();
        if let [trial, lines @ ..] = &sent[..] {
            assert_eq!(*trial, b"(ncfix)", "{told}");
            assert!(
                lines.len() <= told.frozen && lines.iter().zip(&told.planned).all(|(line, plan)| line == plan),
                "{told}"
            );
        }
        assert!(told.last_words.is_empty(), "{told}: {:?}", told.last_words);
        done += u64::from(told.ended == Ended::Done);
    }
    assert!(20 * unseen < scripts(), "{unseen}");
    check_share("linuxcncrsh", done, 0.1);
}

#[test]
fn a_reader_that_lies() {
    let mut done = 0;
    for seed in 0..scripts() {
        let mut random = Random::new(seed, "tape");
        let (name, reserve) = random.pick(&[("fanuc-rs232", 24), ("siemens-v24", 120)]);
        let profile = profile(name);
        let mut lies = lies(&mut random);
        lies.forgeries =
            [&[0x11][..], &[0x13], &[0x16], &[0x15], &[0x00], &[0x12], b"x", &[0x93]].map(<[u8]>::to_vec).to_vec();
        let mut faults = Faults::default();
        if random.unit() < 0.2 {
            faults.reset_s = Some(random.between(0.3, 3.0));
        }
        let character_s = 1.0 / profile.serial.characters_per_s();
        let told = run(&profile, (seed, &mut random), lies, (false, character_s), |busy_s| {
            let mut reader = Reader::new(&faults, busy_s, reserve, seed);
            reader.is_reading = profile.frame.start.is_empty();
            reader
        });
        let executed = told.control.executed();
        assert!(told.planned.starts_with(executed), "{told}: {:?}", executed.last());
        assert_eq!(told.sure, 0, "{told}");
        let sent = told.wrote.strip_prefix(&profile.frame.start[..]).unwrap_or_default();
        told.check_bytes(sent, &profile.frame.trailer);
        assert!(told.last_words.is_empty(), "{told}: {:?}", told.last_words);
        done += u64::from(told.ended == Ended::Done);
    }
    check_share("tape", done, 0.2);
}
