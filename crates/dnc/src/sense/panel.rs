//! All channels of a machine: takes the readings of the sources without waiting for them, and rates their reliability.

use std::path::Path;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use ncfix_base::diagnostic::{Code, Diagnostic};

use super::config::{Action, Config};
use super::monitor::{ChannelFault, ChannelReading, ChannelState, FirstAnswer, Monitor, SourceReport};
use super::outage::SensorOutages;
use super::outlet::{Inlet, SourceSample, box_of};
use super::source::{Clocked, OpenedSource};

/// Maximum time that a dropped panel waits for its threads; a thread that hangs is abandoned.
const MOST_FOR_END: Duration = Duration::from_millis(300);

/// Permission from all channels together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PanelVerdict {
    /// All channels are good.
    Good,
    /// These channels had no good value yet.
    Waiting(Vec<String>),
    /// Some channels are held: their last good values stay in use, and the correction does not approach that of the model.
    Freeze(String),
    /// A channel has been without a good value for so long that this action is due. [`Action::Continue`]: continue with the held values.
    Act(Action, String),
}

/// Source in a thread.
struct Running {
    name: String,
    channels: Vec<usize>,
    inlet: Option<Inlet>,
    thread: JoinHandle<()>,
    has_ended: bool,
}

/// Owns the channels and the threads of their sources. The threads end when it is dropped.
pub struct Panel {
    monitors: Vec<Monitor>,
    readings: Vec<ChannelReading>,
    outages: Vec<SensorOutages>,
    running: Vec<Running>,
    clocked: Vec<Box<dyn Clocked>>,
    now: Duration,
    /// Buffer that is reused, so that a call without new readings does not allocate.
    samples: Vec<SourceSample>,
}

impl Panel {
    /// Starts the sources; paths in the file are relative to `base`.
    ///
    /// # Errors
    /// Sources that can never be opened. A source that cannot be reached yet is not an error: its channels wait.
    pub fn open(config: &Config, base: &Path) -> Result<Panel, Vec<Diagnostic>> {
        let monitors: Vec<Monitor> = config.channels.iter().map(Monitor::new).collect();
        let reading =
            |monitor: &Monitor| ChannelReading { name: monitor.channel().name.clone(), ..ChannelReading::default() };
        let readings = monitors.iter().map(reading).collect();
        let (mut running, mut clocked, mut findings) = (Vec::new(), Vec::new(), Vec::new());
        for origin in &config.sources {
            match origin.plan.open(base, origin.poll) {
                Ok(OpenedSource::Clocked(source)) => clocked.push(source),
                Ok(OpenedSource::Thread(run)) => {
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
                            let message = format!("cannot start a thread for the source {}: {error}", origin.name);
                            findings.push(Diagnostic::at(Code::BAD_VALUE, origin.place, message, "try again"));
                        }
                    }
                }
                Err(message) => {
                    let help = "change the source in the sensor file";
                    findings.push(Diagnostic::at(Code::BAD_VALUE, origin.place, message, help));
                }
            }
        }
        if !findings.is_empty() {
            return Err(findings);
        }
        let outages = vec![SensorOutages::default(); monitors.len()];
        Ok(Panel { monitors, readings, outages, running, clocked, now: Duration::ZERO, samples: Vec::new() })
    }

    /// Takes the readings that have arrived; `now` is the time since the start of the job. Never waits. Returns true if any value has changed.
    pub fn take(&mut self, now: Duration) -> bool {
        self.now = now;
        let monitors = &mut self.monitors;
        for source in &mut self.clocked {
            // Each reading is heard at its own time, however often the panel is polled: the job is reproducible.
            source.until(now, &mut |channel, told, at| {
                if let Some(monitor) = monitors.get_mut(channel) {
                    monitor.tick(at);
                    monitor.hear(told, Duration::ZERO, at);
                }
            });
        }
        let mut hear = |channel: usize, told: &SourceReport, age: Duration| {
            if let Some(monitor) = monitors.get_mut(channel) {
                monitor.hear(told, age, now);
            }
        };
        for running in &mut self.running {
            // Checked before the queue is emptied, so that the last readings of a source are still heard.
            let has_ended = running.thread.is_finished();
            if let Some(inlet) = &running.inlet {
                inlet.take(&mut self.samples);
            }
            self.samples.drain(..).for_each(|sample| hear(sample.channel, &sample.told, sample.age()));
            if has_ended && !running.has_ended {
                running.has_ended = true;
                let told =
                    SourceReport::Nothing(ChannelFault::Disconnected, format!("the source {} has ended", running.name));
                running.channels.iter().for_each(|&channel| hear(channel, &told, Duration::ZERO));
            }
        }
        let mut has_changed = false;
        for ((monitor, reading), outages) in self.monitors.iter_mut().zip(&mut self.readings).zip(&mut self.outages) {
            monitor.tick(now);
            has_changed |= monitor.show(now, reading);
            outages.note(reading.state, now);
        }
        has_changed
    }

    /// Returns all channels as they were at the last [`Panel::take`].
    pub fn channels(&self) -> impl Iterator<Item = &ChannelReading> {
        self.readings.iter()
    }

    /// Returns the names of the channels that have lost their value, with their outages.
    pub fn outages(&self) -> impl Iterator<Item = (&str, SensorOutages)> {
        let all = self.readings.iter().zip(&self.outages);
        all.filter(|(_, outages)| outages.count > 0).map(|(reading, outages)| (reading.name.as_str(), *outages))
    }

    /// Returns the names of all channels with their first answers, as they were at the last [`Panel::take`].
    pub fn first_answers(&self) -> impl Iterator<Item = (&str, FirstAnswer)> {
        self.monitors.iter().map(|monitor| (monitor.channel().name.as_str(), monitor.first_answer()))
    }

    /// Returns the permission: the most severe one of all channels.
    #[must_use]
    pub fn verdict(&self) -> PanelVerdict {
        let mut acting: Option<(Action, String)> = None;
        let (mut waiting, mut held) = (Vec::new(), None);
        for (monitor, reading) in self.monitors.iter().zip(&self.readings) {
            if reading.state == ChannelState::Good {
                continue;
            }
            let (channel, bad_for) = (monitor.channel(), monitor.bad_for(self.now).unwrap_or_default());
            let sentence = || {
                let why = if reading.note.is_empty() { "no reading yet" } else { &reading.note };
                let since = match bad_for.as_secs_f64().round() {
                    seconds if seconds > 0.0 => format!(" for {seconds} s"),
                    _ => String::new(),
                };
                format!("{} has no good value{since}: {why}", reading.name)
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
            (Some((action, why)), _) if action > Action::Continue => PanelVerdict::Act(action, why),
            _ if !waiting.is_empty() => PanelVerdict::Waiting(waiting),
            (Some((action, why)), _) => PanelVerdict::Act(action, why),
            (None, Some(why)) => PanelVerdict::Freeze(why),
            (None, None) => PanelVerdict::Good,
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
                // A panic has been reported already.
                let _ = running.thread.join();
            }
        }
    }
}
