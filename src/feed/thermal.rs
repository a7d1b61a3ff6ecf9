//! The current temperatures: a separate thread reads the sensors and makes a model from them, so that no sensor delays a line.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use ncfix_dnc::sense::{Action, Panel, PanelVerdict, SensorOutages};
use ncfix_machine::machine::Condition;
use ncfix_model::Model;

use super::job::Transfer;
use super::source::Now;

/// Interval between two checks for new sensor values.
const LOOK: Duration = Duration::from_millis(50);

/// The status of the sensors.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) enum Standing {
    /// All are good, or no sensor is configured.
    #[default]
    Good,
    /// Some have not given a value yet.
    Waiting(String),
    /// Some are in doubt: the last good values count, nothing is dosed.
    Frozen(String),
    /// They stay bad: no further line is sent.
    Stop(String),
    /// They stay bad: the axes are held.
    Hold(String),
}

#[derive(Default)]
struct Shared {
    now: Now,
    standing: Standing,
    age: Option<Duration>,
    outages: Vec<(String, SensorOutages)>,
}

/// The current temperatures.
#[derive(Default)]
pub(super) struct Thermal {
    shared: Arc<Mutex<Shared>>,
    is_over: Arc<AtomicBool>,
}

/// The state of the thread.
struct Watch {
    job: Arc<Transfer>,
    panel: Panel,
    condition: Condition,
    /// Instant of the condition at the start, s.
    from_s: f64,
    every: Duration,
    zero_now: bool,
    looked: Option<Duration>,
    /// The model of the first step, with its zero offsets.
    base: Model,
}

impl Thermal {
    /// Starts to look at sensors.
    pub(super) fn start(
        job: &Arc<Transfer>,
        panel: Panel,
        every: Duration,
        zero_now: bool,
        started: Instant,
    ) -> Thermal {
        let thermal = Thermal::default();
        let (shared, is_over) = (Arc::clone(&thermal.shared), Arc::clone(&thermal.is_over));
        let condition = job.machine.condition.clone();
        let from_s = condition.time_s();
        let base = job.machine.model();
        let mut watch = Watch { job: Arc::clone(job), panel, condition, from_s, every, zero_now, looked: None, base };
        if let Ok(mut shared) = shared.lock() {
            shared.standing = Standing::Waiting("no reading yet".into());
        }
        thread::spawn(move || {
            while !is_over.load(Ordering::Relaxed) {
                watch.look(started.elapsed(), &shared);
                thread::sleep(LOOK);
            }
        });
        thermal
    }

    /// The current model.
    pub(super) fn now(&self) -> Now {
        self.shared.lock().unwrap_or_else(PoisonError::into_inner).now.clone()
    }

    /// The status of the sensors, and the age of the oldest of their values.
    pub(super) fn standing(&self) -> (Standing, Option<Duration>) {
        let shared = self.shared.lock().unwrap_or_else(PoisonError::into_inner);
        (shared.standing.clone(), shared.age)
    }

    /// The sensors that have lost their value, with their outages.
    pub(super) fn outages(&self) -> Vec<(String, SensorOutages)> {
        self.shared.lock().unwrap_or_else(PoisonError::into_inner).outages.clone()
    }
}

impl Drop for Thermal {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
    }
}

impl Watch {
    fn look(&mut self, now: Duration, shared: &Mutex<Shared>) {
        self.panel.take(now);
        let standing = match self.panel.verdict() {
            PanelVerdict::Good => Standing::Good,
            PanelVerdict::Waiting(names) => Standing::Waiting(names.join(", ")),
            PanelVerdict::Freeze(why) | PanelVerdict::Act(Action::Continue, why) => Standing::Frozen(why),
            PanelVerdict::Act(Action::Stop, why) => Standing::Stop(why),
            PanelVerdict::Act(Action::Hold, why) => Standing::Hold(why),
        };
        let is_due = self.looked.is_none_or(|looked| now.saturating_sub(looked) >= self.every);
        let model = (is_due && standing == Standing::Good).then(|| self.model(now));
        let age = self.panel.channels().filter_map(|reading| reading.age).max();
        let outages = self.panel.outages().map(|(name, outages)| (name.to_owned(), outages)).collect();
        let mut shared = shared.lock().unwrap_or_else(PoisonError::into_inner);
        shared.outages = outages;
        // The last good values stay in use while a sensor is in doubt.
        shared.now.is_frozen = standing != Standing::Good;
        if let Some((model, readings)) = model {
            shared.now.model = Some(model);
            shared.now.temperatures_c = Some(readings);
        }
        shared.standing = standing;
        shared.age = age;
    }

    /// The model, and the temperatures that it is for.
    fn model(&mut self, now: Duration) -> (Arc<Model>, Arc<[(String, f64)]>) {
        let time_s = self.from_s + now.as_secs_f64();
        let readings: Vec<(String, f64)> =
            self.panel.channels().filter_map(|reading| Some((reading.name.clone(), reading.value_c?))).collect();
        for (name, value_c) in &readings {
            self.condition.add_reading(name, time_s, *value_c);
        }
        self.condition.set_time(time_s);
        if self.looked.is_none() && self.zero_now {
            self.condition.set_zero_at(time_s);
        }
        self.looked = Some(now);
        (Arc::new(self.job.machine.model_now(&self.condition, &self.base)), readings.into())
    }
}
