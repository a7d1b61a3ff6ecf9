//! Log that is replayed by the clock of the job, so that a job is reproducible bit for bit.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::condition::log;
use ncfix_machine::machine::file::Section;

use super::super::monitor::{ChannelFault, SourceReport};
use super::{Clocked, Items, Kind, OpenedSource, SourcePlan, Wanted, items};

/// Maximum length of a log, bytes.
const MOST_BYTES: u64 = 256 << 20;

pub(super) const KIND: Kind =
    Kind { name: "replay", title: "a replay of a temperature log", is_record: true, is_standard_input: false, read };

#[derive(Debug)]
struct Settings {
    path: String,
    speed: f64,
    items: Items,
}

fn read(section: &mut Section<'_>, wanted: &mut [Wanted<'_>]) -> Option<Arc<dyn SourcePlan>> {
    let path = section.required("path", "\"warm.csv\"", Section::text)?.to_owned();
    let is_speed = |value: f64| value > 0.0 && value <= 1e6;
    let speed = section.number_where("speed", "a number above 0", is_speed).unwrap_or(1.0);
    Some(Arc::new(Settings { path, speed, items: items(wanted) }))
}

impl SourcePlan for Settings {
    fn open(&self, base: &Path, _: Duration) -> Result<OpenedSource, String> {
        let path = base.join(&self.path);
        let name = path.display().to_string();
        let mut bytes = Vec::new();
        let file = File::open(&path).map_err(|error| format!("cannot read {name}: {error}"))?;
        file.take(MOST_BYTES + 1).read_to_end(&mut bytes).map_err(|error| format!("cannot read {name}: {error}"))?;
        if bytes.len() as u64 > MOST_BYTES {
            return Err(format!("cannot replay {name}: it has more than {MOST_BYTES} bytes"));
        }
        let source =
            Source::new(FileId(0), &name, bytes).map_err(|_| format!("cannot replay {name}: it is too long"))?;
        let (condition, findings) = log::load_with_dead(&source);
        let Some(condition) = condition else {
            let first = findings.iter().find(|finding| finding.is_error());
            return Err(first.map_or_else(|| format!("cannot replay {name}"), |finding| sentence(&source, finding)));
        };
        let start_s = condition.time_range_s().map_or(0.0, |[first, _]| first);
        let mut points = Vec::new();
        for (item, channel) in &self.items {
            let Some(trace) = condition.trace(item) else {
                let known: Vec<&str> = condition.sensors().collect();
                return Err(format!("{name} has no temperatures of {item}; it has {}", known.join(", ")));
            };
            let of_log = trace.points().iter();
            points.extend(of_log.map(|&(time_s, value_c)| ((time_s - start_s) / self.speed, *channel, value_c)));
        }
        points.sort_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
        let mut channels: Vec<usize> = self.items.iter().map(|(_, channel)| *channel).collect();
        channels.dedup();
        Ok(OpenedSource::Clocked(Box::new(Player { points, next: 0, channels, is_told: false })))
    }
}

/// Formats a diagnostic of the log with its place, as the log is another file than the sensor file.
fn sentence(source: &Source, finding: &Diagnostic) -> String {
    let (line, column) = finding.place.map_or((1, 1), |place| source.line_column(place.span.start));
    format!("{}:{line}:{column}: {}; {}", source.name(), finding.message, finding.help)
}

struct Player {
    /// Time since the start of the job, s; channel; temperature, °C.
    points: Vec<(f64, usize, f64)>,
    next: usize,
    channels: Vec<usize>,
    /// True if the end of the log was reported.
    is_told: bool,
}

impl Clocked for Player {
    fn until(&mut self, now: Duration, hear: &mut dyn FnMut(usize, &SourceReport, Duration)) {
        let now_s = now.as_secs_f64();
        while let Some(&(at_s, channel, value_c)) = self.points.get(self.next).filter(|(at_s, ..)| *at_s <= now_s) {
            self.next += 1;
            hear(channel, &SourceReport::Value(value_c), Duration::try_from_secs_f64(at_s).unwrap_or_default());
        }
        // The last reading stays good for as long as the interval to the one before it.
        let is_over = self.next == self.points.len();
        let last_s = self.points.last().map_or(0.0, |&(at_s, ..)| at_s);
        let before_s = self.points.iter().rev().map(|&(at_s, ..)| at_s).find(|&at_s| at_s < last_s).unwrap_or(last_s);
        let over_s = last_s + (last_s - before_s);
        if is_over && !self.is_told && now_s > over_s {
            self.is_told = true;
            let at = Duration::try_from_secs_f64(over_s).unwrap_or_default();
            let told = SourceReport::Nothing(ChannelFault::Disconnected, "the log has ended".into());
            self.channels.iter().for_each(|&channel| hear(channel, &told, at));
        }
    }
}
