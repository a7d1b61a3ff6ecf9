//! The question to the temperature sensors in a dry run: one answer of each.

use std::time::{Duration, Instant};

use ncfix_dnc::sense::{FirstAnswer, Panel};
use ncfix_report::feed::SensorAnswer;

/// The longest time that a dry run waits for the answers: longer than the usual time limits of the sources (3 s, 5 s).
const LONGEST: Duration = Duration::from_secs(10);
/// Interval between two looks at the panel.
const LOOK: Duration = Duration::from_millis(20);

/// The first answers of all channels, in their order.
pub(super) fn ask(panel: &mut Panel) -> Vec<SensorAnswer> {
    let started = Instant::now();
    loop {
        let now = started.elapsed();
        panel.take(now);
        if now >= LONGEST || panel.first_answers().all(|(_, answer)| answer != FirstAnswer::Waiting) {
            return panel.first_answers().map(|(name, answer)| row(name, answer)).collect();
        }
        std::thread::sleep(LOOK);
    }
}

fn row(name: &str, answer: FirstAnswer) -> SensorAnswer {
    let (value_c, fault) = match answer {
        FirstAnswer::Value(value_c) => (Some(value_c), None),
        FirstAnswer::Fault(why) => (None, Some(why)),
        FirstAnswer::Waiting => (None, Some(format!("no answer within {} s", LONGEST.as_secs()))),
    };
    SensorAnswer { name: name.to_owned(), value_c, fault }
}
