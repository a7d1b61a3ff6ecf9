//! All channels of a machine: takes what the sources bring without waiting for any of them, and says how far it can be relied on.

use std::path::Path;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use ncfix_base::diagnostic::{Code, Diagnostic};

use super::config::{Action, Config};
use super::monitor::{ChannelState, Fault, Monitor, Reading, Told};
use super::outlet::{Inlet, SourceSample, box_of};
use super::source::{Clocked, Opened};

/// So long a panel that goes waits for its threads; one that hangs is left behind.
const MOST_FOR_END: Duration = Duration::from_millis(300);

/// What the channels together allow.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// All are good.
    Good,
    /// These had no good value yet.
    Waiting(Vec<String>),
    /// Some are held: their last good values go on, and nothing is dosed.
    Freeze(String),
    /// One has been without a good value for so long that this is to be done. [`Action::Continue`]: go on with the values that are held.
    Act(Action, String),
}

/// A source in a thread.
struct Running {
    name: String,
    channels: Vec<usize>,
    inlet: Option<Inlet>,
    thread: JoinHandle<()>,
    has_ended: bool,
}

/// Owns the channels and the threads of their sources, which end when it is dropped.
pub struct Panel {
    monitors: Vec<Monitor>,
    readings: Vec<Reading>,
    running: Vec<Running>,
    clocked: Vec<Box<dyn Clocked>>,
    now: Duration,
    /// Kept, so that a call with nothing new makes nothing.
    samples: Vec<SourceSample>,
}

impl Panel {
    /// Starts the sources; paths in the file count from a folder.
    ///
    /// # Errors
    /// What cannot be opened at all. A source that cannot be reached yet is no such thing: its channels wait.
    pub fn open(config: &Config, base: &Path) -> Result<Panel, Vec<Diagnostic>> {
        let monitors: Vec<Monitor> = config.channels.iter().map(Monitor::new).collect();
        let reading = |monitor: &Monitor| Reading { name: monitor.channel().name.clone(), ..Reading::default() };
        let readings = monitors.iter().map(reading).collect();
        let (mut running, mut clocked, mut findings) = (Vec::new(), Vec::new(), Vec::new());
        for origin in &config.sources {
            match origin.plan.open(base, origin.poll) {
                Ok(Opened::Clocked(source)) => clocked.push(source),
                Ok(Opened::Thread(run)) => {
                    let (outlet, inlet) = box_of(&origin.channels);
                    let name = format!("sensors-{}", origin.name);
                    match thread::Builder::new().name(name).spawn(move || run(outlet)) {
                        Ok(thread) => running.push(Running {
                            name: origin.name.clone(),
                            channels: origin.channels.clone(),
                            inlet: Some(inlet),
                            thread,
                            has_ended: false,
                        }),
                        Err(error) => {
                            let message = format!("no thread for the source {}: {error}", origin.name);
                            findings.push(Diagnostic::at(Code::BAD_VALUE, origin.place, message, "try again"));
                        }
                    }
                }
                Err(message) => {
                    let help = "change the source in the file of the sensors";
                    findings.push(Diagnostic::at(Code::BAD_VALUE, origin.place, message, help));
                }
            }
        }
        if !findings.is_empty() {
            return Err(findings);
        }
        Ok(Panel { monitors, readings, running, clocked, now: Duration::ZERO, samples: Vec::new() })
    }

    /// Takes what has come, `now` being the time since the start of the job. Never waits. Returns whether some value has changed.
    pub fn take(&mut self, now: Duration) -> bool {
        self.now = now;
        let monitors = &mut self.monitors;
        for source in &mut self.clocked {
            // Each reading is heard at its own time, however often it is asked for them: the job repeats.
            source.until(now, &mut |channel, told, at| {
                if let Some(monitor) = monitors.get_mut(channel) {
                    monitor.tick(at);
                    monitor.hear(told, Duration::ZERO, at);
                }
            });
        }
        let mut hear = |channel: usize, told: &Told, age: Duration| {
            if let Some(monitor) = monitors.get_mut(channel) {
                monitor.hear(told, age, now);
            }
        };
        for running in &mut self.running {
            // Asked before the box is emptied: what a source says last is still heard.
            let has_ended = running.thread.is_finished();
            if let Some(inlet) = &running.inlet {
                inlet.take(&mut self.samples);
            }
            self.samples.drain(..).for_each(|sample| hear(sample.channel, &sample.told, sample.age()));
            if has_ended && !running.has_ended {
                running.has_ended = true;
                let told = Told::Nothing(Fault::Disconnected, format!("the source {} has ended", running.name));
                running.channels.iter().for_each(|&channel| hear(channel, &told, Duration::ZERO));
            }
        }
        let mut has_changed = false;
        for (monitor, reading) in self.monitors.iter_mut().zip(&mut self.readings) {
            monitor.tick(now);
            has_changed |= monitor.show(now, reading);
        }
        has_changed
    }

    /// All channels as they were at the last [`Panel::take`].
    pub fn channels(&self) -> impl Iterator<Item = &Reading> {
        self.readings.iter()
    }

    /// What they allow: the gravest of what is said of each.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        let mut acting: Option<(Action, String)> = None;
        let (mut waiting, mut held) = (Vec::new(), None);
        for (monitor, reading) in self.monitors.iter().zip(&self.readings) {
            if reading.state == ChannelState::Good {
                continue;
            }
            let (channel, bad_for) = (monitor.channel(), monitor.bad_for(self.now).unwrap_or_default());
            let sentence = || {
                let why = if reading.note.is_empty() { "nothing has come yet" } else { &reading.note };
                format!("{} has no good value for {:.0} s: {why}", reading.name, bad_for.as_secs_f64())
            };
            if bad_for >= channel.act_after && acting.as_ref().is_none_or(|(action, _)| *action < channel.action) {
                acting = Some((channel.action, sentence()));
            } else if reading.state == ChannelState::Waiting && bad_for < channel.act_after {
                waiting.push(reading.name.clone());
            } else if held.is_none() {
                held = Some(sentence());
            }
        }
        match (acting, held) {
            (Some((action, why)), _) if action > Action::Continue => Verdict::Act(action, why),
            _ if !waiting.is_empty() => Verdict::Waiting(waiting),
            (Some((action, why)), _) => Verdict::Act(action, why),
            (None, Some(why)) => Verdict::Freeze(why),
            (None, None) => Verdict::Good,
        }
    }
}

impl Drop for Panel {
    fn drop(&mut self) {
        for running in &mut self.running {
            running.inlet = None;
        }
        let until = Instant::now() + MOST_FOR_END;
        for running in std::mem::take(&mut self.running) {
            while !running.thread.is_finished() && Instant::now() < until {
                thread::sleep(Duration::from_millis(2));
            }
            if running.thread.is_finished() {
                // Whether it panicked has been told.
                let _ = running.thread.join();
            }
        }
    }
}
