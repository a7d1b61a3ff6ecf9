//! The complete decomposition of a trace into its sources.

use std::fmt;

use crate::measure::trace::Trace;
use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_base::numeric::in_parts;
use ncfix_machine::machine::Machine;
use ncfix_model::preset;
use ncfix_model::{ErrorModel, Model, ParameterName};

use super::basis::{Basis, Smooth};
use super::clock::Clock;
use super::compliance::{Compliances, Remainder, compliances, deflection};
use super::contour::from_path;
use super::grid::RunGrid;
use super::joint::{JointFit, LinkError, SlowRun, joint};
use super::poses::RunPoses;
use super::power::{PowerLaw, power_law};
use super::quasi_static::{LinkPart, SmoothMotion, effect, links, motion};
use super::servo::ServoErrors;
use super::shares::{SourceShares, shares};
use super::signal::{SIGMAS_95, inflation};
use super::spread::{Shifts, half_widths};
use super::together::{Synchronous, synchronous_telling};

/// Search range for the nearest point of the path, forwards and backwards, s.
const WINDOW_S: f64 = 0.25;
/// Number of iterations that remove the dynamic part from the slowest run before its smooth part is fitted again.
const ROUNDS: usize = 3;
/// Path share at which a run has begun.
const BEGUN: f64 = 1e-6;
/// Maximum number of samples for the uncertainty of shares.
const SPREAD_SAMPLES: usize = 1_500;
/// Relative difference of equal feeds.
const SAME_FEED: f64 = 1e-3;

/// Options of the decomposition.
#[derive(Clone, Debug, Default)]
pub struct DecompositionOptions {
    /// The fitted link errors; empty for the default of the machine.
    pub links: Vec<ParameterName>,
    /// Representation of motion errors.
    pub smooth: Smooth,
    /// The delay of encoders relative to set-points, s, if known.
    pub record_delay_s: Option<f64>,
    /// The delay between instrument and control, s, if known.
    pub reading_delay_s: Option<f64>,
}

/// Reason why a trace cannot be decomposed.
#[derive(Clone, Debug, PartialEq)]
pub enum DecompositionError {
    /// No axis moves.
    Still,
    /// Readings and control do not overlap in time.
    Apart,
    /// Two runs do not follow one path: their indices and path lengths, mm.
    OtherPath([usize; 2], [f64; 2]),
    /// The encoder travel of an axis differs from that of its set-points, mm or rad: they have another unit.
    Units(Axis, [f64; 2]),
    /// The run with this index has too little information for links and smooth errors.
    NotIdentified(usize),
}

impl fmt::Display for DecompositionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DecompositionError::Still => f.write_str("no axis moves"),
            DecompositionError::Apart => f.write_str("readings and positions do not overlap in time"),
            DecompositionError::OtherPath(_, [one, other]) => {
                write!(f, "the runs have paths of {one:.1} and {other:.1} mm: they do not follow one path")
            }
            DecompositionError::Units(axis, [set, encoder]) => {
                let (unit, size) = if axis.is_rotary() { ("deg", 1_f64.to_degrees()) } else { ("mm", 1.0) };
                let [set, encoder] = [set, encoder].map(|value| value * size);
                write!(f, "the column {axis}_enc covers {encoder:.3} {unit} while {axis} covers {set:.3} {unit}")
            }
            DecompositionError::NotIdentified(_) => {
                f.write_str("the slowest run has too few readings to determine link and motion errors")
            }
        }
    }
}

impl std::error::Error for DecompositionError {}

/// A run and its sources; by sample, along F's directions, mm.
#[derive(Clone, Debug)]
pub struct RunParts {
    /// Its index in the trace.
    pub number: usize,
    /// Programmed feed, mm/min.
    pub feed_mm_min: Option<f64>,
    /// Time by the clock of the control, s.
    pub t_s: Vec<f64>,
    /// Relative path position, 0 to 1.
    pub path: Vec<f64>,
    /// Accelerations of the axes from the encoders, averaged as for compliances, mm/s² or rad/s².
    pub acceleration: Vec<AxisVector>,
    /// Contouring as the difference of the axes, link, motion, thermal, dynamic; `None` if the instrument did not record.
    pub parts: Vec<Option<[Vector; 5]>>,
    /// Contouring by sample, with or without instrument recording.
    pub following: Vec<Vector>,
    /// The true contouring error, at right angles to the path in the workpiece.
    pub contouring: Vec<Vector>,
    /// The part of the dynamics explained by compliances.
    pub explained: Vec<Vector>,
    /// Links and motion errors of the machine file.
    pub known: Vec<Vector>,
    /// Range of the samples in which the machine moves.
    pub moving: std::ops::Range<usize>,
    /// Shares of the sources while it moves.
    pub shares: SourceShares,
    /// Half widths of the 95 % intervals of the shares, in their units.
    pub shares_95: SourceShares,
    /// Thermal offset relative to the slowest run.
    pub thermal_mm: Vector,
    /// Half width of its 95 % interval.
    pub thermal_95_mm: Vector,
    /// Length of the path in the workpiece, mm: on a short path the true contouring error has little meaning.
    pub in_workpiece_mm: f64,
    /// RMS of single readings about their means over a control cycle, mm.
    pub fast_mm: [f64; 3],
}

/// A decomposed trace.
#[derive(Clone, Debug)]
pub struct Decomposition {
    /// The cycle of the control, s.
    pub cycle_s: f64,
    /// Delay of the encoders, and the loops.
    pub servo: Option<ServoErrors>,
    /// Delay of the instrument; `None` if nothing was measured.
    pub clock: Option<Clock>,
    /// The runs, the slowest first.
    pub runs: Vec<RunParts>,
    /// The link errors.
    pub links: Vec<LinkError>,
    /// Representation of motion errors.
    pub smooth: Smooth,
    /// Compliances.
    pub compliances: Vec<super::Compliance>,
    /// By run: its index in [`Decomposition::held_out_mm`].
    folds: Vec<usize>,
    /// RMS of the dynamic part of the runs of every feed, without compliances and with those predicted by the other runs, mm; averaged as
    /// accelerations are.
    pub held_out_mm: Vec<[f64; 2]>,
    /// Power laws of the RMS along X, Y, Z (mm): contouring, dynamics.
    pub laws: [[Option<PowerLaw>; 3]; 2],
}

impl Decomposition {
    /// The index of a run in [`Decomposition::held_out_mm`]: runs of one feed are held out together.
    #[must_use]
    pub fn fold(&self, run: usize) -> usize {
        self.folds.get(run).copied().unwrap_or(run)
    }
}

/// Decomposes a trace into its sources.
///
/// # Errors
/// [`DecompositionError`].
pub fn decompose(
    machine: &Machine,
    errors: &ErrorModel,
    trace: &Trace,
    options: &DecompositionOptions,
    tell: &mut dyn FnMut(&str, f64),
) -> Result<Decomposition, DecompositionError> {
    let whole = synchronous_telling(machine, trace, options, tell)?;
    let Synchronous { axes, order, grids, poses, servo, clock, left, tool_mm, nominal } = whole;
    let cycle_s = grids.first().map_or(0.0, |grid| grid.step_s);
    let mut work = Work {
        machine,
        errors,
        options,
        nominal,
        axes,
        tool_mm,
        poses: &poses,
        feeds: order.iter().map(|&number| trace.runs[number].feed_mm_min).collect(),
        left,
        known: Vec::new(),
        found: Compliances::default(),
        quasi: None,
        joint: None,
        delays_95_s: [
            SIGMAS_95 * servo.uncertainty_s,
            clock.as_ref().map_or(0.0, |clock| SIGMAS_95 * clock.uncertainty_s),
        ],
    };
    if clock.is_some() {
        tell("links, motion, dynamics", 0.5);
        work.divide(&trace.free, order[0])?;
    }
    tell("shares", 0.9);
    let runs: Vec<RunParts> =
        (0..order.len()).map(|place| work.parts(place, order[place], &grids[place], &servo)).collect();
    let law = |source: usize, k: usize| {
        let pairs: Vec<(f64, f64)> =
            runs.iter().filter_map(|run| Some((run.feed_mm_min?, run.shares.rms_mm[source][k]))).collect();
        power_law(&pairs)
    };
    let laws = [0, 4].map(|source| [0, 1, 2].map(|k| law(source, k)));
    Ok(Decomposition {
        cycle_s,
        servo: Some(servo),
        clock,
        links: work.joint.as_ref().map_or_else(Vec::new, |joint| joint.links.clone()),
        smooth: options.smooth,
        folds: folds(&work.feeds),
        held_out_mm: work.found.held_out.clone(),
        compliances: work.found.all.clone(),
        laws,
        runs,
    })
}

/// The link errors of a machine: the eight of five axes, otherwise the squareness of linear axes.
fn default_links(machine: &Machine) -> Vec<ParameterName> {
    preset::location_errors(machine)
}

/// Contributions of the machine file at a sample: links, other errors, dynamics; mm.
type Known = [Vector; 3];

/// A decomposition in progress.
struct Work<'a> {
    machine: &'a Machine,
    errors: &'a ErrorModel,
    options: &'a DecompositionOptions,
    nominal: Model,
    axes: Vec<Axis>,
    tool_mm: Vector,
    poses: &'a [RunPoses],
    feeds: Vec<Option<f64>>,
    /// χ − χenc.
    left: Vec<Vec<Option<Vector>>>,
    known: Vec<Vec<Known>>,
    found: Compliances,
    quasi: Option<(LinkPart, SmoothMotion)>,
    /// The links with all that motion errors may take from them.
    joint: Option<JointFit>,
    /// Half widths of the 95 % intervals of the delays of encoders and readings, s.
    delays_95_s: [f64; 2],
}

impl Work<'_> {
    fn divide(
        &mut self,
        free: &[crate::measure::trace::TraceUnknown],
        reference: usize,
    ) -> Result<(), DecompositionError> {
        self.known = self.known();
        let names =
            if self.options.links.is_empty() { default_links(self.machine) } else { self.options.links.clone() };
        let slow = self.poses.first().ok_or(DecompositionError::Still)?;
        let basis = Basis::new(self.options.smooth, &self.axes, &slow.encoder);
        for _ in 0..ROUNDS {
            // Compliance in the slowest run is not a motion error.
            let rest = self.minus(0, |work, number| {
                let known: Vector = work.known[0][number].iter().sum();
                known + deflection(&work.nominal, &work.found.all, &work.tool_mm, slow, number)
            });
            let links = links(&self.nominal, &names, free, &self.tool_mm, slow, &rest)
                .ok_or(DecompositionError::NotIdentified(reference))?;
            let of_links =
                |number: usize| links.at(&self.nominal, &self.tool_mm, slow, number) + links.setup_at(slow, number);
            let rest: Vec<Option<Vector>> =
                rest.iter().enumerate().map(|(k, rest)| rest.map(|rest| rest - of_links(k))).collect();
            let motion = motion(basis.clone(), slow, &rest).ok_or(DecompositionError::NotIdentified(reference))?;
            self.quasi = Some((links, motion));
            let dynamic: Vec<Vec<Option<Vector>>> = (0..self.poses.len())
                .map(|run| {
                    let offset = self.thermal(run);
                    self.minus(run, |work, number| work.quasi_static(run, number) + offset + work.known[run][number][2])
                })
                .collect();
            let folds = folds(&self.feeds);
            let remainders: Vec<Remainder<'_>> = self
                .poses
                .iter()
                .zip(&dynamic)
                .zip(folds)
                .map(|((poses, left), fold)| Remainder { poses, left, fold })
                .collect();
            self.found = compliances(&self.nominal, &self.axes, &self.tool_mm, &remainders);
        }
        self.joint = self.joint(free);
        Ok(())
    }

    /// Links and motion errors of the slowest run, fitted together.
    fn joint(&self, free: &[crate::measure::trace::TraceUnknown]) -> Option<JointFit> {
        let (poses, (links, motion)) = (self.poses.first()?, self.quasi.as_ref()?);
        let left = self.minus(0, |work, number| {
            let known: Vector = work.known[0][number].iter().sum();
            known + deflection(&work.nominal, &work.found.all, &work.tool_mm, poses, number)
        });
        let run = SlowRun {
            model: &self.nominal,
            axes: &self.axes,
            tool_mm: &self.tool_mm,
            poses,
            links,
            motion,
            left: &left,
        };
        joint(&run, free)
    }

    /// Residual of a run after subtracting a contribution.
    fn minus(&self, run: usize, what: impl Fn(&Self, usize) -> Vector) -> Vec<Option<Vector>> {
        let each = self.left[run].iter().enumerate();
        each.map(|(number, left)| left.map(|left| left - what(self, number))).collect()
    }

    fn known(&self) -> Vec<Vec<Known>> {
        let location = ErrorModel { location: self.errors.location.clone(), ..ErrorModel::default() };
        let [location, all] = [&location, self.errors].map(|errors| Model::new(self.machine, errors));
        let none = all.is_empty();
        in_parts(self.poses, &|poses| {
            let each = (0..poses.count()).map(|number| {
                if none {
                    return [Vector::zeros(); 3];
                }
                let links = poses.predicted(&location, &self.tool_mm, number, false);
                let still = poses.predicted(&all, &self.tool_mm, number, false);
                let whole = poses.predicted(&all, &self.tool_mm, number, true);
                [links, still - links, whole - still]
            });
            each.collect()
        })
    }

    fn of_links(&self, run: usize, number: usize) -> Vector {
        let own =
            self.quasi.as_ref().map(|(links, _)| links.at(&self.nominal, &self.tool_mm, &self.poses[run], number));
        own.unwrap_or_default() + self.known[run][number][0]
    }

    fn of_motion(&self, run: usize, number: usize) -> Vector {
        let poses = &self.poses[run];
        let own = self.quasi.as_ref().map(|(_, motion)| motion.at(&poses.encoder[number], poses.share[number]));
        own.unwrap_or_default() + self.known[run][number][1]
    }

    /// Links, motion and set-up.
    fn quasi_static(&self, run: usize, number: usize) -> Vector {
        let setup = self.quasi.as_ref().map(|(links, _)| links.setup_at(&self.poses[run], number));
        self.of_links(run, number) + self.of_motion(run, number) + setup.unwrap_or_default()
    }

    /// The mean residual of a run after quasi-static errors and deflections (eq. 18, with the deflections removed); 0 for the slowest one.
    fn thermal(&self, run: usize) -> Vector {
        if run == 0 {
            return Vector::zeros();
        }
        let rest = self.minus(run, |work, number| {
            let given = deflection(&work.nominal, &work.found.all, &work.tool_mm, &work.poses[run], number);
            work.quasi_static(run, number) + work.known[run][number][2] + given
        });
        let count = rest.iter().flatten().count().max(1) as f64;
        rest.into_iter().flatten().sum::<Vector>() / count
    }

    /// Half width of the 95 % interval of the mean residual of a run, mm: neighbors that are alike count as one.
    fn mean_95(&self, run: usize, thermal_mm: &Vector) -> Vector {
        let rest = self.minus(run, |work, number| {
            let given = deflection(&work.nominal, &work.found.all, &work.tool_mm, &work.poses[run], number);
            work.quasi_static(run, number) + work.known[run][number][2] + given + thermal_mm
        });
        Vector::from_fn(|k, _| {
            let values: Vec<f64> = rest.iter().flatten().map(|rest| rest[k]).collect();
            let count = values.len().max(1) as f64;
            let variance = values.iter().map(|value| value * value).sum::<f64>() / count;
            SIGMAS_95 * (variance * inflation(&values) / count).sqrt()
        })
    }

    /// Half width of the 95 % interval of the thermal offset of a run, mm: that of its mean and that of the slowest run.
    fn thermal_95(&self, run: usize, thermal_mm: &Vector) -> Vector {
        if run == 0 {
            return Vector::zeros();
        }
        let [own, slow] = [self.mean_95(run, thermal_mm), self.mean_95(0, &Vector::zeros())];
        own.zip_map(&slow, f64::hypot)
    }

    /// Half widths of the 95 % intervals of the shares of a run.
    fn shares_95(
        &self,
        run: usize,
        moving: &[(usize, [Vector; 5])],
        thermal_95_mm: &Vector,
        cycle_s: f64,
    ) -> SourceShares {
        let poses = &self.poses[run];
        let few: Vec<(usize, [Vector; 5])> =
            moving.iter().copied().step_by(moving.len().div_ceil(SPREAD_SAMPLES).max(1)).collect();
        let mut shifts = Shifts::default();
        if let (Some(joint), Some((links, _))) = (&self.joint, &self.quasi) {
            let of = |number: usize| -> Vec<Vector> {
                let names = links.links.iter().map(|link| link.name);
                names.map(|name| effect(&self.nominal, name, &self.tool_mm, poses, number)).collect()
            };
            let effects: Vec<Vec<Vector>> = few.iter().map(|(number, _)| of(*number)).collect();
            let off: Vec<f64> =
                joint.links.iter().zip(&links.links).map(|(whole, first)| whole.value - first.value).collect();
            shifts.add_links(&effects, &off, &joint.covariance);
        }
        // A speed in samples is half of the difference of the neighbors.
        let rate = |of: &[Vector], number: usize| {
            let last = of.len().saturating_sub(1);
            (of[(number + 1).min(last)] - of[number.saturating_sub(1)]) / (2.0 * cycle_s)
        };
        let none = Vector::zeros();
        let [record_s, reading_s] = self.delays_95_s.map(|delay| delay / SIGMAS_95);
        let contouring = few.iter().map(|(k, _)| [rate(&poses.nominal[0], *k) * record_s, none, none, none, none]);
        shifts.add(contouring.collect());
        if self.quasi.is_some() {
            let late = few.iter().map(|(k, _)| [none, none, none, none, rate(&poses.nominal[1], *k) * reading_s]);
            shifts.add(late.collect());
            for along in 0..3 {
                let drift = Vector::ith(along, thermal_95_mm[along] / SIGMAS_95);
                shifts.add(few.iter().map(|_| [none, none, none, drift, -drift]).collect());
            }
        }
        let samples: Vec<[Vector; 5]> = few.into_iter().map(|(_, parts)| parts).collect();
        half_widths(&samples, &shifts)
    }

    fn parts(&self, run: usize, number: usize, grid: &RunGrid, servo: &ServoErrors) -> RunParts {
        let poses = &self.poses[run];
        let count = poses.count();
        let has_readings = self.quasi.is_some();
        let thermal_mm = if has_readings { self.thermal(run) } else { Vector::zeros() };
        let following: Vec<Vector> = (0..count).map(|k| poses.nominal[1][k] - poses.nominal[0][k]).collect();
        let mut explained = vec![Vector::zeros(); count];
        let mut parts = vec![None; count];
        if has_readings {
            for k in 0..count {
                explained[k] =
                    deflection(&self.nominal, &self.found.all, &self.tool_mm, poses, k) + self.known[run][k][2];
                let Some(left) = self.left[run][k] else { continue };
                let quasi = self.quasi_static(run, k) + thermal_mm;
                let [links, motion] = [self.of_links(run, k), self.of_motion(run, k)];
                parts[k] = Some([following[k], links, motion, thermal_mm, left - quasi]);
            }
        }
        let first = poses.share.iter().position(|share| *share > BEGUN).unwrap_or(0);
        let last = poses.share.iter().rposition(|share| *share < 1.0 - BEGUN).unwrap_or(count.saturating_sub(1));
        let moving = first..(last + 1).max(first);
        let none = Vector::zeros();
        let divided: Vec<(usize, [Vector; 5])> = if has_readings {
            moving.clone().filter_map(|k| Some((k, parts[k]?))).collect()
        } else {
            moving.clone().map(|k| (k, [following[k], none, none, none, none])).collect()
        };
        let shares = shares(divided.iter().map(|(_, parts)| *parts));
        let thermal_95_mm = if has_readings { self.thermal_95(run, &thermal_mm) } else { none };
        let shares_95 = self.shares_95(run, &divided, &thermal_95_mm, grid.step_s);
        let tips = |of: &[AxisVector]| -> Vec<Vector> {
            of.iter().map(|at| self.nominal.nominal(at, &self.tool_mm).translation).collect()
        };
        let path = tips(&poses.set);
        let window = ((WINDOW_S + servo.delay_s.abs()) / grid.step_s).ceil() as usize;
        let actual = tips(&poses.encoder);
        let contouring = (0..count).map(|k| poses.to_f[k] * from_path(&path, &actual[k], k, window)).collect();
        RunParts {
            number,
            feed_mm_min: self.feeds[run],
            t_s: (0..count).map(|k| grid.time(k)).collect(),
            path: poses.share.clone(),
            acceleration: poses.acceleration.clone(),
            parts,
            following,
            contouring,
            explained,
            known: self.known.get(run).map_or_else(Vec::new, |known| known.iter().map(|own| own[0] + own[1]).collect()),
            moving,
            shares,
            shares_95,
            thermal_mm,
            thermal_95_mm,
            in_workpiece_mm: path.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum(),
            fast_mm: grid.fast_mm,
        }
    }
}

/// Runs of one feed are held out together.
fn folds(feeds: &[Option<f64>]) -> Vec<usize> {
    let mut folds: Vec<usize> = Vec::with_capacity(feeds.len());
    for (run, feed) in feeds.iter().enumerate() {
        let same = |other: &Option<f64>| match (feed, other) {
            (Some(a), Some(b)) => (a / b - 1.0).abs() < SAME_FEED,
            _ => false,
        };
        let known = feeds[..run].iter().position(same).map(|other| folds[other]);
        let next = folds.iter().map(|fold| fold + 1).max().unwrap_or(0);
        folds.push(known.unwrap_or(next));
    }
    folds
}
