//! Temperatures of one day on a machine: what each sensor's place really has, and what a body has that follows it slowly.

use std::f64::consts::TAU;

use super::random::Random;

/// Seconds between the values.
pub(crate) const STEP_S: f64 = 10.0;

/// One day.
#[derive(Clone, Debug)]
pub(crate) struct Climate {
    /// As the machine file would call them: `T_head`.
    pub(crate) names: Vec<&'static str>,
    /// True temperatures by sensor and step, °C.
    pub(crate) truth: Vec<Vec<f64>>,
    /// Noise of a sensor, K.
    pub(crate) noise: f64,
    /// Steps at which all is at rest: other days begin there.
    pub(crate) starts: Vec<usize>,
    /// Speed of the spindle by step.
    pub(crate) rpm: Vec<f64>,
}

/// A sensor's place: time constant, warmth from the spindle (K at full speed), share of the hall and of another place.
struct Place {
    name: &'static str,
    tau_s: f64,
    rise_k: f64,
    hall: f64,
}

const PLACES: [Place; 12] = [
    Place { name: "T_spindle", tau_s: 300.0, rise_k: 22.0, hall: 1.0 },
    Place { name: "T_head", tau_s: 1700.0, rise_k: 13.0, hall: 1.0 },
    Place { name: "T_column_front", tau_s: 5200.0, rise_k: 6.0, hall: 1.0 },
    Place { name: "T_ambient", tau_s: 60.0, rise_k: 0.0, hall: 1.0 },
    Place { name: "T_bed", tau_s: 14_000.0, rise_k: 1.0, hall: 0.8 },
    Place { name: "T_motor", tau_s: 700.0, rise_k: 17.0, hall: 1.0 },
    Place { name: "T_column_back", tau_s: 8000.0, rise_k: 2.5, hall: 1.0 },
    Place { name: "T_table", tau_s: 6000.0, rise_k: 0.7, hall: 0.9 },
    Place { name: "T_cabinet", tau_s: 2500.0, rise_k: 4.0, hall: 0.6 },
    Place { name: "T_coolant", tau_s: 3600.0, rise_k: 0.0, hall: 0.4 },
    Place { name: "T_oil", tau_s: 1200.0, rise_k: 3.0, hall: 0.3 },
    Place { name: "T_wall", tau_s: 20_000.0, rise_k: 0.0, hall: 0.7 },
];

impl Climate {
    /// A day of `hours` with a spindle that runs at changing speeds, seen by the first `sensors` places.
    pub(crate) fn spindle_day(hours: f64, sensors: usize, random: &mut Random) -> Climate {
        let steps = (hours * 3600.0 / STEP_S).ceil() as usize + 2;
        let mut rpm = Vec::with_capacity(steps);
        while rpm.len() < steps {
            let speed = if random.unit() < 0.3 { 0.0 } else { (random.between(500.0, 6300.0) / 50.0).round() * 50.0 };
            let length = (random.between(400.0, 3600.0) / STEP_S) as usize;
            rpm.extend(std::iter::repeat_n(speed, length));
        }
        rpm.truncate(steps);
        let hall = hall(steps, random);
        let mut names = Vec::new();
        let mut truth = Vec::new();
        for place in PLACES.iter().take(sensors) {
            // Places that hear little of the machine have weather of their own.
            let own = wave(steps, random, 0.35, 2500.0);
            let start = hall[0];
            let mut at = start;
            let mut values = Vec::with_capacity(steps);
            for k in 0..steps {
                let heat = place.rise_k * (rpm[k] / 6300.0).powf(1.3);
                let goal = start + place.hall * (hall[k] - start) + heat + own[k];
                at += (goal - at) * (1.0 - (-STEP_S / place.tau_s).exp());
                values.push(at);
            }
            names.push(place.name);
            truth.push(values);
        }
        Climate { names, truth, noise: 0.04, starts: Vec::new(), rpm }
    }

    /// A day at a level of temperature with sensors that each have their own difference from it and change a little or much.
    pub(crate) fn level_day(
        hours: f64,
        names: &[&'static str],
        levels: &[f64],
        swing: f64,
        random: &mut Random,
    ) -> Climate {
        let steps = (hours * 3600.0 / STEP_S).ceil() as usize + 2;
        let truth = levels
            .iter()
            .map(|level| wave(steps, random, swing, 6000.0).into_iter().map(|k| level + k).collect())
            .collect();
        Climate { names: names.to_vec(), truth, noise: 0.03, starts: Vec::new(), rpm: vec![0.0; steps] }
    }

    /// The temperature of a sensor at a time.
    pub(crate) fn at(&self, sensor: usize, t: f64) -> f64 {
        interpolated(&self.truth[sensor], t)
    }

    /// Another day behind this one, at rest when it begins. Returns when that is, s.
    pub(crate) fn append(&mut self, day: Climate) -> f64 {
        self.starts.push(self.rpm.len());
        let from = self.rpm.len() as f64 * STEP_S;
        self.rpm.extend(day.rpm);
        self.truth.iter_mut().zip(day.truth).for_each(|(all, new)| all.extend(new));
        from
    }

    /// What follows a sensor with a time constant, at all steps; it was at rest before.
    pub(crate) fn lagged(&self, sensor: usize, lag_s: f64) -> Vec<f64> {
        let mut at = self.truth[sensor][0];
        let gain = if lag_s > 0.0 { 1.0 - (-STEP_S / lag_s).exp() } else { 1.0 };
        let follow = |(step, value): (usize, &f64)| {
            if self.starts.contains(&step) {
                at = *value;
            }
            at += (value - at) * gain;
            at
        };
        self.truth[sensor].iter().enumerate().map(follow).collect()
    }

    /// Number of a sensor.
    pub(crate) fn sensor(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| *known == name)
    }
}

/// A value between the steps.
pub(crate) fn interpolated(values: &[f64], t: f64) -> f64 {
    let place = (t / STEP_S).clamp(0.0, (values.len() - 1) as f64);
    let k = (place as usize).min(values.len() - 2);
    values[k] + (values[k + 1] - values[k]) * (place - k as f64)
}

/// The hall: a day's wave and weather.
fn hall(steps: usize, random: &mut Random) -> Vec<f64> {
    let (mean, height, phase) = (random.between(19.0, 23.0), random.between(1.2, 3.0), random.between(0.0, TAU));
    let weather = wave(steps, random, 0.4, 1800.0);
    (0..steps).map(|k| mean + height * (TAU * k as f64 * STEP_S / 86_400.0 + phase).sin() + weather[k]).collect()
}

/// A slow random wave of a standard deviation and a time constant.
fn wave(steps: usize, random: &mut Random, sigma: f64, tau_s: f64) -> Vec<f64> {
    let keep = (-STEP_S / tau_s).exp();
    let mut at = sigma * random.normal();
    let mut smooth = at;
    (0..steps)
        .map(|_| {
            at = keep * at + (1.0 - keep * keep).sqrt() * sigma * random.normal();
            // Air mixes within minutes.
            smooth += (at - smooth) * (STEP_S / 240.0);
            smooth
        })
        .collect()
}
