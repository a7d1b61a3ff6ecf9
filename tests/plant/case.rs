//! A case: a machine that is known in part, its measurements as text, and the truth about both.

use std::path::{Path, PathBuf};
use std::{fs, io};

use super::bench::{self, Bench, Plan};
use super::catalogue;
use super::effect::{Effect, Hidden, Stage, micro_of, rms};
use super::fault::{self, Fault, FaultKind, Values};
use super::machine::Errors;
use super::random::Random;
use super::reading;
use super::row::{Kind, Row, Sheet};
use super::unknown::{self, Unknown};
use super::vector::{V3, add, scale, sub};
use super::write;

/// What a case shall have.
#[derive(Clone, Debug)]
pub(crate) struct Recipe {
    pub(crate) bench: Bench,
    /// Rows of the catalogue.
    pub(crate) hide: Vec<u8>,
    pub(crate) unknown: Option<Unknown>,
    pub(crate) faults: Vec<FaultKind>,
    /// What an effect makes in the readings in which it acts, in units of the noise.
    pub(crate) size_in_noise: f64,
    /// How densely is sampled: 1 is usual.
    pub(crate) fineness: f64,
    /// Share of the readings that are outliers; `None` is by the seed, from 0 to 2 %.
    pub(crate) outliers: Option<f64>,
    pub(crate) seed: u64,
}

/// A pair of files and what is true of it.
#[derive(Clone, Debug)]
pub(crate) struct File {
    pub(crate) stem: String,
    pub(crate) csv: String,
    pub(crate) toml: String,
    /// What the hidden effects make in its readings, µm (µrad), by row; 0 where nothing is read.
    pub(crate) hidden_um: Vec<V3>,
    /// Rows of the table with an outlier.
    pub(crate) outliers: Vec<usize>,
    /// What the start machine leaves of the readings without outliers when the free unknowns of the set-ups have been fitted, root mean
    /// square in µm (µrad); and what a machine that knows the truth leaves.
    pub(crate) before_um: f64,
    pub(crate) after_um: f64,
    /// Noise of a reading with the slow drift of the instrument, 1σ.
    pub(crate) noise_um: f64,
}

/// What is true.
#[derive(Clone, Debug)]
pub(crate) struct Truth {
    pub(crate) effects: Vec<Hidden>,
    pub(crate) faults: Vec<Fault>,
    /// White noise of the first file, 1σ, µm or µrad.
    pub(crate) noise_um: f64,
    /// By how much knowing the truth makes the data held out better: 1 − after/before over all its
    /// readings, root mean square, each in units of its noise.
    pub(crate) gain: f64,
}

/// A case.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) machine_toml: String,
    pub(crate) files: Vec<File>,
    pub(crate) held_out: Vec<File>,
    pub(crate) truth: Truth,
}

/// A case of some rows of the catalogue; `None` where the bench cannot show one of them.
pub(crate) fn case(bench: Bench, hide: &[u8], size_in_noise: f64, seed: u64) -> Option<Case> {
    Recipe { hide: hide.to_vec(), ..Recipe::new(bench, size_in_noise, seed) }.cook()
}

impl Recipe {
    /// Nothing hidden, at the usual density, with outliers by the seed.
    pub(crate) fn new(bench: Bench, size_in_noise: f64, seed: u64) -> Recipe {
        let (hide, unknown, faults) = (Vec::new(), None, Vec::new());
        Recipe { bench, hide, unknown, faults, size_in_noise, fineness: 1.0, outliers: None, seed }
    }

    /// The effects, each with its own random numbers, so that one does not change another.
    fn effects(&self, plan: &Plan) -> Option<Vec<Effect>> {
        let stage = Stage {
            bench: self.bench,
            machine: &plan.machine,
            sheets: &plan.sheets,
            used: plan.used,
            about: self.size_in_noise * plan.sheets[0].sigma,
        };
        let mut effects = Vec::new();
        for &row in self.hide.iter().filter(|&&row| row < catalogue::FIRST_FAULT) {
            let mut random = Random::new(self.seed, &format!("row {row}"));
            effects.push(catalogue::effect(row, &stage, &mut random)?);
        }
        if let Some(kind) = self.unknown {
            effects.push(unknown::effect(kind, &stage, &mut Random::new(self.seed, "unknown"))?);
        }
        Some(effects)
    }

    /// Makes the case; `None` where the bench cannot show what shall be hidden.
    pub(crate) fn cook(&self) -> Option<Case> {
        let mut plan = bench::plan(self.bench, self.fineness, self.seed);
        let mut effects = self.effects(&plan)?;
        for word in effects.iter().filter_map(|effect| effect.binds) {
            for sheet in &mut plan.sheets {
                sheet.free.retain(|free| *free != word);
                for setup in &mut sheet.setups {
                    match word {
                        "centre" => setup.off_centre = [0.0; 3],
                        "length" => setup.off_length = 0.0,
                        "tool" => setup.stylus = [0.0; 3],
                        _ => setup.turn = [0.0; 3],
                    }
                }
            }
        }
        let stage = Stage {
            bench: self.bench,
            machine: &plan.machine,
            sheets: &plan.sheets,
            used: plan.used,
            about: self.size_in_noise * plan.sheets[0].sigma,
        };
        for effect in &mut effects {
            if !effect.set_size(&stage, self.size_in_noise) {
                return None;
            }
        }
        let mut kinds = self.faults.clone();
        let random = &mut Random::new(self.seed, "faults");
        for &row in self.hide.iter().filter(|&&row| row >= catalogue::FIRST_FAULT) {
            let possible: Vec<FaultKind> =
                fault::kinds_of(row).iter().copied().filter(|&kind| fault::is_possible(kind, self.bench)).collect();
            if possible.is_empty() {
                return None;
            }
            kinds.push(random.pick(&possible));
        }
        if kinds.iter().any(|&kind| !fault::is_possible(kind, self.bench)) {
            return None;
        }
        let known = if kinds.contains(&FaultKind::Compensated) { 0.0 } else { 1.0 };
        let mut made: Vec<Made> =
            plan.sheets.iter().enumerate().map(|(k, sheet)| self.measure(&plan, sheet, &effects, known, k)).collect();
        let mut values: Vec<Values> = made.iter_mut().map(|one| one.values.clone()).collect();
        let faults: Vec<Fault> = kinds
            .iter()
            .flat_map(|&kind| fault::apply(kind, &plan.sheets[..plan.used], &mut values, self.size_in_noise, random))
            .collect();
        let files: Vec<File> = plan
            .sheets
            .iter()
            .zip(made)
            .zip(&values)
            .map(|((sheet, made), values)| File {
                csv: write::csv(&plan.machine, sheet, values),
                toml: write::toml(sheet),
                ..made.file
            })
            .collect();
        let held = files[plan.used..].iter().zip(&plan.sheets[plan.used..]);
        // Every reading counts by its noise, a file by how many it has.
        let normal = |of: fn(&File) -> f64| {
            let squares = held.clone().map(|(file, sheet)| {
                let readings = sheet.rows.len() * sheet.reads.iter().filter(|&&is_read| is_read).count();
                readings as f64 * (of(file) / (sheet.sigma * micro_of(sheet))).powi(2)
            });
            squares.sum::<f64>().sqrt()
        };
        let gain = 1.0 - normal(|file| file.after_um) / normal(|file| file.before_um);
        let noise_um = plan.sheets[0].sigma * micro_of(&plan.sheets[0]);
        let effects = effects.into_iter().map(|effect| effect.hidden).collect();
        Some(Case {
            name: format!("{:?} {:?} {:?} {:?} {}", self.bench, self.hide, self.unknown, self.faults, self.seed),
            machine_toml: plan.machine.toml(),
            held_out: files[plan.used..].to_vec(),
            files: files[..plan.used].to_vec(),
            truth: Truth { effects, faults, noise_um, gain },
        })
    }

    /// Reads a sheet with all that is there, noise and all.
    fn measure(&self, plan: &Plan, sheet: &Sheet, effects: &[Effect], known: f64, number: usize) -> Made {
        let machine = &plan.machine;
        let errors = |row: &Row, known: f64, is_all: bool| {
            let mut errors = Errors::default();
            machine.add_known(row, known, &mut errors);
            effects.iter().filter(|_| is_all).for_each(|effect| effect.add(row, &mut errors));
            errors
        };
        let read = |known: f64, is_all: bool| -> Vec<V3> {
            let at = |row: &Row| errors(row, known, is_all);
            sheet.rows.iter().map(|row| reading::read(machine, sheet, row, &at)).collect()
        };
        let (with, without) = (read(known, true), read(known, false));
        // What the start machine says, set-ups as they really are: these are fitted below, as far as they are free.
        let start = if known == 1.0 { without.clone() } else { read(1.0, false) };
        let (noise, outliers) = self.noise(sheet, number);
        let micro = micro_of(sheet);
        let mask = |v: V3| [0, 1, 2].map(|k| if sheet.reads[k] { v[k] } else { 0.0 });
        let hidden: Vec<V3> = with.iter().zip(&without).map(|(a, b)| mask(sub(*a, *b))).collect();
        let is_out = |k: &usize| outliers.binary_search(k).is_ok();
        let clean: Vec<V3> =
            noise.iter().enumerate().map(|(k, v)| if is_out(&k) { [0.0; 3] } else { mask(*v) }).collect();
        let off: Vec<V3> = (0..with.len()).map(|k| add(sub(with[k], start[k]), clean[k])).collect();
        let rest: Vec<V3> = (0..with.len()).map(|k| add(sub(without[k], start[k]), clean[k])).collect();
        let count = sheet.reads.iter().filter(|&&is_read| is_read).count() as f64;
        let size =
            |v: &[V3]| rms(reading::left(machine, sheet, v).into_iter().flatten()) * micro * (3.0 / count).sqrt();
        let unit = if sheet.kind == Kind::Probe { 1.0 } else { micro };
        let readings = with.iter().zip(&noise).map(|(a, b)| scale(add(*a, mask(*b)), unit)).collect();
        let file = File {
            stem: sheet.stem.clone(),
            csv: String::new(),
            toml: String::new(),
            hidden_um: hidden.iter().map(|v| scale(*v, micro)).collect(),
            before_um: size(&off),
            // Known errors that are not there any more are no cause that is hidden.
            after_um: size(&rest),
            noise_um: sheet.sigma * micro * (1.0 + sheet.wander[0].powi(2)).sqrt(),
            outliers,
        };
        Made { file, values: Values { readings, sensors: self.sensors(sheet, number) } }
    }

    /// White noise, slow drift of the instrument and outliers of all readings, mm or rad; and the rows of the outliers.
    fn noise(&self, sheet: &Sheet, number: usize) -> (Vec<V3>, Vec<usize>) {
        let mut random = Random::new(self.seed, &format!("noise {number}"));
        let keep = (-1.0 / sheet.wander[1]).exp();
        let slow = sheet.wander[0] * sheet.sigma;
        let mut at = random.normal3(slow);
        let mut setup = 0;
        let mut out: Vec<V3> = Vec::with_capacity(sheet.rows.len());
        for row in &sheet.rows {
            if row.setup != setup {
                (at, setup) = (random.normal3(slow), row.setup);
            }
            at = add(scale(at, keep), random.normal3(slow * (1.0 - keep * keep).sqrt()));
            out.push(add(at, random.normal3(sheet.sigma)));
        }
        let mut random = Random::new(self.seed, &format!("outliers {number}"));
        let by_seed = if random.unit() < 0.4 { 0.0 } else { random.between(0.0, 0.02) };
        let share = self.outliers.unwrap_or(by_seed);
        let mut rows = Vec::new();
        for (k, value) in out.iter_mut().enumerate() {
            if random.unit() < share {
                let axis = (0..3).filter(|&k| sheet.reads[k]).nth(random.below(3)).unwrap_or(0);
                value[axis] += random.sign() * random.between(10.0, 40.0) * sheet.sigma;
                rows.push(k);
            }
        }
        (out, rows)
    }

    /// What the sensors read.
    fn sensors(&self, sheet: &Sheet, number: usize) -> Vec<Vec<Option<f64>>> {
        let mut random = Random::new(self.seed, &format!("sensors {number}"));
        sheet.climate.as_ref().map_or_else(Vec::new, |climate| {
            (0..climate.names.len())
                .map(|k| {
                    sheet.rows.iter().map(|row| Some(climate.at(k, row.t) + climate.noise * random.normal())).collect()
                })
                .collect()
        })
    }
}

/// A sheet with its values, before faults.
struct Made {
    file: File,
    values: Values,
}

/// Where the files of a case are; descriptions lie beside their tables.
#[derive(Clone, Debug)]
pub(crate) struct Paths {
    pub(crate) machine: PathBuf,
    pub(crate) files: Vec<PathBuf>,
    pub(crate) held_out: Vec<PathBuf>,
}

impl Case {
    /// Writes it into a folder, which is made.
    pub(crate) fn save(&self, folder: &Path) -> io::Result<Paths> {
        fs::create_dir_all(folder)?;
        let machine = folder.join("machine.toml");
        fs::write(&machine, &self.machine_toml)?;
        let save = |files: &[File]| -> io::Result<Vec<PathBuf>> {
            files
                .iter()
                .map(|file| {
                    let path = folder.join(format!("{}.csv", file.stem));
                    fs::write(&path, &file.csv)?;
                    fs::write(path.with_extension("toml"), &file.toml)?;
                    Ok(path)
                })
                .collect()
        };
        Ok(Paths { machine, files: save(&self.files)?, held_out: save(&self.held_out)? })
    }

    /// The truth as text, for messages and tables.
    pub(crate) fn words(&self) -> String {
        let truth = &self.truth;
        let mut out = format!("{}: noise {:.3}, gain {:.3}\n", self.name, truth.noise_um, truth.gain);
        for hidden in &truth.effects {
            out += &format!(
                "  {:>2} {} {} {:.4} {} over {} rms {:.3}, where it acts {:.3}{}{}{}{}{}\n",
                hidden.row,
                hidden.effect,
                hidden.parameter,
                hidden.size,
                hidden.unit,
                hidden.drivers.join(" "),
                hidden.rms_um,
                hidden.rms_acting_um,
                hidden.sensor.map_or(String::new(), |name| format!(", sensor {name}")),
                hidden.lag_s.map_or(String::new(), |lag| format!(", lag {lag:.0} s")),
                hidden.period.map_or(String::new(), |period| format!(", period {period:.3}")),
                hidden.class.iter().fold(String::new(), |out, (effect, name)| out + " | " + effect + " " + name),
                if hidden.transfers { "" } else { ", only here" },
            );
        }
        for fault in &truth.faults {
            let [first, last] = fault.rows;
            out += &format!(
                "  {:>2} {} {} {} in {} {first}-{last}\n",
                fault.row, fault.kind, fault.name, fault.what, fault.file
            );
        }
        for file in self.files.iter().chain(&self.held_out) {
            let rows = file.csv.lines().count() - 1;
            out += &format!(
                "  {} {rows} rows, {} outliers, before {:.3} after {:.3} noise {:.3}\n",
                file.stem,
                file.outliers.len(),
                file.before_um,
                file.after_um,
                file.noise_um
            );
        }
        out
    }
}
