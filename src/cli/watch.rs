//! `ncfix sensors S.toml --watch`: what live sensors say now, how old it is and whether it is believed.

use std::fs::File;
use std::io::{IsTerminal as _, Write as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::arguments::SensorsArguments;
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::output::is_same_file;
use super::stop::Stop;
use super::{input, print};
use ncfix_base::source::FileId;
use ncfix_dnc::sense::{Action, ChannelState, Config, Panel, Reading, Verdict};
use ncfix_report::json;
use ncfix_report::watch::{WatchChannel, WatchReport};

/// How often the sources are looked after.
const LOOK: Duration = Duration::from_millis(50);
/// A table on a terminal is drawn anew so often.
const REDRAW: Duration = Duration::from_millis(500);

/// Watches.
pub(super) fn run(arguments: &SensorsArguments) -> Result<ExitCode, Stop> {
    let [path] = arguments.data.as_slice() else {
        return Err(Stop::Usage("--watch reads one file of live sensors".into()));
    };
    let source = input::read_written(path, FileId(0), "live sensors")?;
    let base = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
    let mut findings = Findings::default();
    let opened = Config::read(&source).and_then(|config| Panel::open(&config, &base).map(|panel| (config, panel)));
    let (config, panel) = match opened {
        Ok(opened) => opened,
        Err(found) => {
            findings.extend(found, &[source]);
            findings.draw();
            return Ok(findings.exit_code());
        }
    };
    let log = match &arguments.log {
        Some(log) if is_same_file(log, path) => {
            return Err(Stop::Usage("the log would be written over the file of the sensors".into()));
        }
        Some(log) => Some(Log::new(log, &config)?),
        None => None,
    };
    let is_drawn = !arguments.json && std::io::stdout().is_terminal();
    Watch { config, panel, log, is_json: arguments.json, is_drawn, drawn_lines: 0 }.run(arguments.duration)
}

struct Watch {
    config: Config,
    panel: Panel,
    log: Option<Log>,
    is_json: bool,
    is_drawn: bool,
    /// Lines of the table that is on the terminal.
    drawn_lines: usize,
}

impl Watch {
    fn run(mut self, duration: Option<Duration>) -> Result<ExitCode, Stop> {
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
                if !self.is_drawn {
                    self.print_line(now)?;
                }
            }
            if self.is_drawn && (now >= draw || is_end) {
                draw = now + REDRAW;
                self.redraw(now)?;
            }
            if is_end {
                let is_good = self.panel.verdict() == Verdict::Good;
                return Ok(if is_good { ExitCode::Done } else { ExitCode::Refused });
            }
            let rest = duration.map_or(LOOK, |duration| duration.saturating_sub(start.elapsed()).min(LOOK));
            std::thread::sleep(rest);
        }
    }

    fn report(&self, now: Duration) -> WatchReport {
        let (verdict, why) = match self.panel.verdict() {
            Verdict::Good => ("good", None),
            Verdict::Waiting(names) => ("waiting", Some(format!("nothing yet of {}", names.join(", ")))),
            Verdict::Freeze(why) => ("freeze", Some(why)),
            Verdict::Act(Action::Continue, why) => ("continue", Some(why)),
            Verdict::Act(Action::Stop, why) => ("stop", Some(why)),
            Verdict::Act(Action::Hold, why) => ("hold", Some(why)),
        };
        let channels = self.config.channels.iter().zip(self.panel.channels());
        let row = |reading: &Reading, source: &str| WatchChannel {
            name: reading.name.clone(),
            value_c: reading.value_c,
            age_s: reading.age.map(|age| age.as_secs_f64()),
            state: reading.state.word(),
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

    fn print_line(&self, now: Duration) -> Result<(), Stop> {
        let report = self.report(now);
        if self.is_json { print(&json::line(&report).map_err(Stop::Usage)?) } else { print(&report.line()) }
    }

    /// Draws the table over the one that is there.
    fn redraw(&mut self, now: Duration) -> Result<(), Stop> {
        let page = self.report(now).page();
        let up = if self.drawn_lines > 0 { format!("\u{1b}[{}A", self.drawn_lines) } else { String::new() };
        self.drawn_lines = page.lines().count();
        let lines: String = page.lines().map(|line| format!("\u{1b}[K{line}\n")).collect();
        // A line that is wider than the terminal is cut, not folded: the table keeps its height.
        print(&format!("\u{1b}[?7l{up}{lines}\u{1b}[J\u{1b}[?7h"))
    }
}

/// A log as `--state` and the source `replay` read it, written as it comes: whoever ends the watch has what was read.
struct Log {
    file: File,
    path: PathBuf,
}

impl Log {
    fn new(path: &Path, config: &Config) -> Result<Log, Stop> {
        let file = File::options().write(true).create_new(true).open(path).map_err(|error| {
            if error.kind() == std::io::ErrorKind::AlreadyExists {
                Stop::Usage(format!(
                    "cannot write {}: it is there already, and a log is not written over",
                    path.display()
                ))
            } else {
                Stop::file("write", path, &error)
            }
        })?;
        let mut log = Log { file, path: path.to_path_buf() };
        let names = config.channels.iter().map(|channel| format!(",{}_C", channel.name));
        log.write(&format!("t_s{}\n", names.collect::<String>()))?;
        Ok(log)
    }

    /// Adds a row; a channel that is not good has no reading.
    fn add<'r>(&mut self, now: Duration, channels: impl Iterator<Item = &'r Reading>) -> Result<(), Stop> {
        let cell = |reading: &Reading| match (reading.state, reading.value_c) {
            (ChannelState::Good, Some(value_c)) => format!(",{value_c:.4}"),
            _ => ",".to_owned(),
        };
        let cells: String = channels.map(cell).collect();
        self.write(&format!("{:.3}{cells}\n", now.as_secs_f64()))
    }

    fn write(&mut self, text: &str) -> Result<(), Stop> {
        let written = self.file.write_all(text.as_bytes()).and_then(|()| self.file.flush());
        written.map_err(|error| Stop::file("write", &self.path, &error))
    }
}
