//! Shows live sensors: their values, the age of the values and whether they are plausible; and logs them.

use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::diagnostics::Diagnostics;
use crate::disk::files;
use crate::disk::output::is_same_file;
use crate::error::Error;
use ncfix_base::source::FileId;
use ncfix_dnc::sense::{Action, ChannelReading, ChannelState, Config, Panel, PanelVerdict};
use ncfix_report::watch::{WatchChannel, WatchReport, WatchVerdict, WatchedState};

/// Interval in which the sources are checked.
const LOOK: Duration = Duration::from_millis(50);
/// Shortest interval between two drawings.
const REDRAW: Duration = Duration::from_millis(500);

/// Sensors that are watched.
pub(crate) struct SensorWatch {
    config: Config,
    panel: Panel,
    log: Option<TemperatureLog>,
}

/// The times when a report is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ShownAt {
    /// With every poll of the sensors.
    Polls,
    /// A few times a second.
    Redraws,
}

impl SensorWatch {
    /// Opens the sensors of a file, and the log that is written; `None` if there are errors.
    ///
    /// # Errors
    /// If the file cannot be read, or the log cannot be written or exists already.
    pub(crate) fn open(path: &Path, log: Option<&Path>, found: &mut Diagnostics) -> Result<Option<SensorWatch>, Error> {
        let source = files::read_written(path, FileId(0), "live sensors")?;
        let base = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
        let opened = Config::read(&source).and_then(|config| Panel::open(&config, &base).map(|panel| (config, panel)));
        let (config, panel) = match opened {
            Ok(opened) => opened,
            Err(faults) => {
                found.extend(faults, &[source]);
                return Ok(None);
            }
        };
        let log = match log {
            Some(log) if is_same_file(log, path) => {
                return Err(Error::usage("the log would overwrite the sensor file".into()));
            }
            Some(log) => Some(TemperatureLog::new(log, &config)?),
            None => None,
        };
        Ok(Some(SensorWatch { config, panel, log }))
    }

    /// Watches for the given time, or without one until the process ends; returns whether all sensors are good at the end.
    ///
    /// # Errors
    /// If the log cannot be written, and those of `show`.
    pub(crate) fn run<E: From<Error>>(
        mut self,
        duration: Option<Duration>,
        at: ShownAt,
        show: &mut dyn FnMut(&WatchReport) -> Result<(), E>,
    ) -> Result<bool, E> {
        let start = Instant::now();
        let (mut poll, mut draw) = (Duration::ZERO, Duration::ZERO);
        loop {
            let now = start.elapsed();
            let is_end = duration.is_some_and(|duration| now >= duration);
            self.panel.take(now);
            if now >= poll || is_end {
                // Polls are counted from the start, so that they do not drift.
                poll = self.config.poll
                    * u32::try_from(now.as_nanos() / self.config.poll.as_nanos().max(1) + 1).unwrap_or(u32::MAX);
                if let Some(log) = &mut self.log {
                    log.add(now, self.panel.channels())?;
                }
                if at == ShownAt::Polls {
                    show(&self.report(now))?;
                }
            }
            if at == ShownAt::Redraws && (now >= draw || is_end) {
                draw = now + REDRAW;
                show(&self.report(now))?;
            }
            if is_end {
                return Ok(self.panel.verdict() == PanelVerdict::Good);
            }
            let rest = duration.map_or(LOOK, |duration| duration.saturating_sub(start.elapsed()).min(LOOK));
            std::thread::sleep(rest);
        }
    }

    fn report(&self, now: Duration) -> WatchReport {
        let (verdict, why) = match self.panel.verdict() {
            PanelVerdict::Good => (WatchVerdict::Good, None),
            PanelVerdict::Waiting(names) => {
                (WatchVerdict::Waiting, Some(format!("no reading yet from {}", names.join(", "))))
            }
            PanelVerdict::Freeze(why) => (WatchVerdict::Freeze, Some(why)),
            PanelVerdict::Act(Action::Continue, why) => (WatchVerdict::Continue, Some(why)),
            PanelVerdict::Act(Action::Stop, why) => (WatchVerdict::Stop, Some(why)),
            PanelVerdict::Act(Action::Hold, why) => (WatchVerdict::Hold, Some(why)),
        };
        let channels = self.config.channels.iter().zip(self.panel.channels());
        let row = |reading: &ChannelReading, source: &str| WatchChannel {
            name: reading.name.clone(),
            value_c: reading.value_c,
            age_s: reading.age.map(|age| age.as_secs_f64()),
            state: match reading.state {
                ChannelState::Waiting => WatchedState::Waiting,
                ChannelState::Good => WatchedState::Good,
                ChannelState::Held(_) => WatchedState::Held,
            },
            fault: match reading.state {
                ChannelState::Held(fault) => Some(fault.word()),
                _ => None,
            },
            raw: reading.raw,
            note: (!reading.note.is_empty()).then(|| reading.note.clone()),
            source: source.to_owned(),
        };
        WatchReport {
            schema: 1,
            t_s: now.as_secs_f64(),
            verdict,
            why,
            channels: channels.map(|(channel, reading)| row(reading, &channel.source)).collect(),
        }
    }
}

/// A log in the format of `--state` and the source `replay`, written as values arrive: after an interrupt the file is complete up to that time.
struct TemperatureLog {
    file: File,
    path: PathBuf,
}

impl TemperatureLog {
    fn new(path: &Path, config: &Config) -> Result<TemperatureLog, Error> {
        let file = File::options().write(true).create_new(true).open(path).map_err(|error| {
            if error.kind() == std::io::ErrorKind::AlreadyExists {
                Error::usage(format!(
                    "cannot write {}: it already exists, and a log is not overwritten",
                    path.display()
                ))
            } else {
                Error::file("write", path, &error)
            }
        })?;
        let mut log = TemperatureLog { file, path: path.to_path_buf() };
        let names = config.channels.iter().map(|channel| format!(",{}_C", channel.name));
        log.write(&format!("t_s{}\n", names.collect::<String>()))?;
        Ok(log)
    }

    /// Adds a row; a channel that is not good has no reading.
    fn add<'r>(&mut self, now: Duration, channels: impl Iterator<Item = &'r ChannelReading>) -> Result<(), Error> {
        let cell = |reading: &ChannelReading| match (reading.state, reading.value_c) {
            (ChannelState::Good, Some(value_c)) => format!(",{value_c:.4}"),
            _ => ",".to_owned(),
        };
        let cells: String = channels.map(cell).collect();
        self.write(&format!("{:.3}{cells}\n", now.as_secs_f64()))
    }

    fn write(&mut self, text: &str) -> Result<(), Error> {
        let written = self.file.write_all(text.as_bytes()).and_then(|()| self.file.flush());
        written.map_err(|error| Error::file("write", &self.path, &error))
    }
}
