//! A hidden effect: where it acts in the machine or the instrument, with what shape, how large, and what is true of it.

use super::bench::Bench;
use super::machine::{DIRECTIONS, Errors, LETTERS, Machine};
use super::random::Random;
use super::reading;
use super::row::{Row, Sheet};
use super::vector::{V3, norm, scale, sub};

/// Where an effect acts; directions 0 … 5 are EX EY EZ EA EB EC, axes 0 … 4 X Y Z A C, 5 the spindle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// Added to the command of an axis.
    Command(usize),
    /// Motion error: direction, axis.
    Motion(usize, usize),
    /// Location error: direction, axis.
    Location(usize, usize),
    /// The tool from the workpiece along a direction of F.
    Tip(usize),
    /// The tool vector.
    Tool(usize),
    /// One of up to three readings.
    Reading(usize),
}

/// A function of the circumstances; times the amplitude it is mm or rad.
pub(crate) type Shape = Box<dyn Fn(&Row) -> f64>;

/// How the amplitude becomes the size that is reported.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Law {
    /// Times a factor.
    Linear(f64),
    /// Its root times a factor.
    Root(f64),
    /// From the lowest to the highest value of the first shape over the rows, times a factor.
    Span(f64),
    /// A size that the shape has in itself; the amplitude is 1.
    Fixed(f64),
}

/// What is true of a hidden effect.
#[derive(Clone, Debug, Default)]
pub(crate) struct Hidden {
    /// Row of the catalogue; 0 for an effect that it does not have.
    pub(crate) row: u8,
    pub(crate) effect: &'static str,
    pub(crate) parameter: String,
    /// Other names that no measurement of this bench, or only a fine one, could tell from it.
    pub(crate) class: Vec<(&'static str, String)>,
    /// Columns on which it depends.
    pub(crate) drivers: Vec<String>,
    pub(crate) size: f64,
    pub(crate) unit: &'static str,
    pub(crate) sensor: Option<&'static str>,
    pub(crate) lag_s: Option<f64>,
    /// mm; degrees of a rotary axis; s of a vibration.
    pub(crate) period: Option<f64>,
    /// Whether it is the same in other set-ups and on other days, so that it can gain on data held out.
    pub(crate) transfers: bool,
    /// What it makes in the readings of that used sheet in which it is strongest, µm or µrad, beyond what free unknowns of set-ups take: root
    /// mean square over all readings, and over those in which it acts (more than 5 % of its largest).
    pub(crate) rms_um: f64,
    pub(crate) rms_acting_um: f64,
}

/// An effect that acts.
pub(crate) struct Effect {
    pub(crate) hidden: Hidden,
    pub(crate) acting: Vec<(Place, Shape)>,
    pub(crate) amplitude: f64,
    pub(crate) law: Law,
    /// An unknown of set-ups that is not free in this case, because the effect is that it should be.
    pub(crate) binds: Option<&'static str>,
}

/// What a maker of effects may look at.
pub(crate) struct Stage<'a> {
    pub(crate) bench: Bench,
    pub(crate) machine: &'a Machine,
    /// Used and, behind them, held out.
    pub(crate) sheets: &'a [Sheet],
    pub(crate) used: usize,
    /// The largest effect that is asked for, mm or rad, where a shape depends on it.
    pub(crate) about: f64,
}

impl Effect {
    /// An effect with a name; nothing acts yet.
    pub(crate) fn new(
        row: u8,
        effect: &'static str,
        parameter: &str,
        drivers: &[&str],
        law: Law,
        unit: &'static str,
    ) -> Effect {
        let hidden = Hidden {
            row,
            effect,
            parameter: parameter.to_owned(),
            drivers: drivers.iter().map(|&name| name.to_owned()).collect(),
            unit,
            transfers: true,
            ..Hidden::default()
        };
        Effect { hidden, acting: Vec::new(), amplitude: 1.0, law, binds: None }
    }

    /// Lets it act.
    pub(crate) fn acts(mut self, place: Place, shape: impl Fn(&Row) -> f64 + 'static) -> Effect {
        self.acting.push((place, Box::new(shape)));
        self
    }

    /// Adds names that mean the same here.
    pub(crate) fn alias(mut self, effect: &'static str, parameter: &str) -> Effect {
        self.hidden.class.push((effect, parameter.to_owned()));
        self
    }

    /// Says that it does not hold elsewhere.
    pub(crate) fn only_here(mut self) -> Effect {
        self.hidden.transfers = false;
        self
    }

    /// Says after how much it repeats.
    pub(crate) fn repeats(mut self, period: f64) -> Effect {
        self.hidden.period = Some(period);
        self
    }

    /// Says which sensor it follows, and how slowly.
    pub(crate) fn follows(mut self, sensor: &'static str, lag_s: f64) -> Effect {
        (self.hidden.sensor, self.hidden.lag_s) = (Some(sensor), Some(lag_s));
        self
    }

    /// Adds what it does at a row.
    pub(crate) fn add(&self, row: &Row, errors: &mut Errors) {
        for (place, shape) in &self.acting {
            let value = self.amplitude * shape(row);
            match *place {
                Place::Command(axis) => errors.command[axis] += value,
                Place::Motion(direction, axis) => errors.motion[axis][direction] += value,
                Place::Location(direction, axis) => errors.location[axis][direction] += value,
                Place::Tip(direction) => errors.tip[direction] += value,
                Place::Tool(direction) => errors.tool[direction] += value,
                Place::Reading(number) => errors.reading[number] += value,
            }
        }
    }

    /// What it does to all readings of a sheet, mm or rad.
    pub(crate) fn response(&self, machine: &Machine, sheet: &Sheet) -> Vec<V3> {
        let known = |row: &Row| {
            let mut errors = Errors::default();
            machine.add_known(row, 1.0, &mut errors);
            errors
        };
        let all = |row: &Row| {
            let mut errors = known(row);
            self.add(row, &mut errors);
            errors
        };
        let difference =
            |row| sub(reading::read(machine, sheet, row, &all), reading::read(machine, sheet, row, &known));
        sheet.rows.iter().map(difference).collect()
    }

    /// Gives it the amplitude at which the readings where it acts move by `ratio` times the noise, beyond what set-ups can take. False where the
    /// bench does not show it.
    pub(crate) fn set_size(&mut self, stage: &Stage<'_>, ratio: f64) -> bool {
        let used = &stage.sheets[..stage.used];
        let rows = || used.iter().flat_map(|sheet| &sheet.rows);
        let peak = self.acting.iter().flat_map(|(_, shape)| rows().map(|row| shape(row).abs())).fold(0.0, f64::max);
        if peak == 0.0 {
            return false;
        }
        let is_fixed = matches!(self.law, Law::Fixed(_));
        self.amplitude = if is_fixed { 1.0 } else { 2e-4 / peak };
        let responses: Vec<Vec<V3>> = used
            .iter()
            .map(|sheet| reading::left(stage.machine, sheet, &self.response(stage.machine, sheet)))
            .collect();
        // In the sheet in which it is strongest.
        let cells = |k: usize| responses[k].iter().flatten().map(move |v| v / used[k].sigma);
        let sheet = (0..used.len()).max_by(|&a, &b| rms(cells(a)).total_cmp(&rms(cells(b)))).unwrap_or(0);
        let largest = cells(sheet).fold(0.0, |most: f64, v| most.max(v.abs()));
        let acting = rms(cells(sheet).filter(|v| v.abs() > 0.05 * largest));
        // What set-ups take to a hundredth would have to be absurdly large.
        if acting * used[sheet].sigma < 2e-6 {
            return false;
        }
        let factor = if is_fixed { 1.0 } else { ratio / acting };
        self.amplitude *= factor;
        let to_um = factor * used[sheet].sigma * micro_of(&used[sheet]);
        let count = used[sheet].reads.iter().filter(|&&is_read| is_read).count() as f64;
        self.hidden.rms_um = rms(cells(sheet)) * (3.0 / count).sqrt() * to_um;
        self.hidden.rms_acting_um = acting * to_um;
        self.hidden.size = match self.law {
            Law::Linear(k) => self.amplitude * k,
            Law::Root(k) => self.amplitude.sqrt() * k,
            Law::Fixed(size) => size,
            Law::Span(k) => {
                let shape = &self.acting[0].1;
                let (low, high) = rows().map(shape).fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)));
                (high - low) * self.amplitude.abs() * k
            }
        };
        true
    }
}

/// µm in mm, µrad in rad.
pub(crate) fn micro_of(sheet: &Sheet) -> f64 {
    if sheet.angles { 1e6 } else { 1e3 }
}

/// Root of the mean square; 0 of nothing.
pub(crate) fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), v| (sum + v * v, count + 1.0));
    if count > 0.0 { f64::sqrt(sum / count) } else { 0.0 }
}

/// `EYX`
pub(crate) fn motion(direction: usize, axis: usize) -> String {
    format!("E{}{}", DIRECTIONS[direction], LETTERS[axis])
}

/// `EC0Y`; the spindle is S.
pub(crate) fn location(direction: usize, axis: usize) -> String {
    let axis = LETTERS.get(axis).copied().unwrap_or("S");
    format!("E{}0{axis}", DIRECTIONS[direction])
}

/// A direction at random.
pub(crate) fn unit_vector(random: &mut Random) -> V3 {
    let v = random.normal3(1.0);
    scale(v, 1.0 / norm(v).max(1e-9))
}
