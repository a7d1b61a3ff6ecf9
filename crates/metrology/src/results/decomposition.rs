//! A decomposition of traces at several feeds into its sources, in display units, and the machine file with links, loops and compliances.

use serde::Serialize;

use crate::decompose::signal::SIGMAS_95;
use crate::decompose::{self, AxisServoErrors, DecompositionError, LinkError, RunParts, Smooth};
use crate::measure::trace::Trace;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{AXES, AxisVector, Vector};
use ncfix_base::units::{Unit, UnitKey, um_from_mm};
use ncfix_machine::machine::edit::{Edit, Given};
use ncfix_model::name::ErrorKind;
use ncfix_model::source::dynamic;

/// The version of the object.
pub const SCHEMA: u32 = 1;

/// m/min per mm in 1/s: 1 mm per second per mm is 0.06 m/min per mm.
const M_MIN_MM_OF_PER_S: f64 = 0.06;
/// Millimeters of a meter.
const MM_PER_M: f64 = 1e3;

/// Decomposition of traces at several feeds.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DecompositionResult {
    /// Version of this format, 1.
    pub schema: u32,
    /// Name of the machine.
    pub machine: String,
    /// Cycle of the control.
    pub cycle_ms: f64,
    /// Delay of the encoder recording relative to the set-points.
    pub record_delay: Delay,
    /// Delay of the readings relative to the encoders; `null` if nothing was measured.
    pub reading_delay: Option<Delay>,
    /// The loops of the moving axes.
    pub servo: Vec<Loop>,
    /// Link errors relative to the machine file.
    pub links: Vec<LinkReport>,
    /// Representation of motion errors: `pose:6`, `path:20`.
    pub motion: String,
    /// The runs, the slowest first.
    pub runs: Vec<RunReport>,
    /// Compliances, in the order in which they were found.
    pub compliances: Vec<ComplianceReport>,
    /// Power laws of the RMS: contouring and dynamics, along X, Y, Z.
    pub power_laws: Vec<Law>,
    /// One figure for the dynamic accuracy on this path; `null` if nothing was measured.
    pub dynamic_accuracy: Option<DynamicAccuracy>,
}

/// One figure for the dynamic accuracy of a machine: comparable between machines and dates that run the same path at the same feed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DynamicAccuracy {
    /// Programmed feed of the fastest run.
    pub feed_mm_min: Option<f64>,
    /// RMS of the dynamic part of this run, as the length of the vector along X, Y, Z.
    pub rms_um: f64,
    /// Half width of its 95 % interval, with fully correlated directions.
    pub rms_95_um: f64,
}

impl DynamicAccuracy {
    /// The figure of a run.
    fn of(run: &RunReport) -> DynamicAccuracy {
        let [rms, by] = [run.rms_um.dynamic, run.rms_95_um.dynamic];
        let rms_um = rms.iter().map(|um| um * um).sum::<f64>().sqrt();
        let slope: f64 = rms.iter().zip(by).map(|(um, by)| um * by).sum();
        let rms_95_um = if rms_um > 0.0 { slope / rms_um } else { 0.0 };
        DynamicAccuracy { feed_mm_min: run.feed_mm_min, rms_um, rms_95_um }
    }
}

/// A delay.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Delay {
    /// Its value.
    pub ms: f64,
    /// Its standard uncertainty; 0 if it was given.
    pub uncertainty_ms: f64,
    /// Half width of its 95 % interval; 0 if it was given.
    pub uncertainty_95_ms: f64,
    /// Delay of every run alone.
    pub by_run_ms: Vec<f64>,
    /// Half widths of their 95 % intervals; `null` if a run does not determine it.
    pub by_run_95_ms: Vec<Option<f64>>,
    /// True if it was given, or if the half width of its interval is less than a cycle of the control.
    pub is_determined: bool,
    /// Reason why it is not determined, and the remedy.
    pub not_determined: Option<NotDetermined>,
}

/// Reason why the data do not determine a value, and the measurement that would.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct NotDetermined {
    /// The reason, without a full stop.
    pub reason: String,
    /// The measurement that determines it, without a full stop.
    pub measure: String,
}

/// A servo loop.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Loop {
    /// Its axis.
    pub axis: String,
    /// Velocity gain; `null` without a visible lag.
    pub velocity_gain_per_s: Option<f64>,
    /// Velocity feed-forward, as a share.
    pub feed_forward: f64,
    /// Lag at constant velocity.
    pub lag_ms: f64,
    /// RMS residual between encoder and loop, µm or µrad.
    pub rms: f64,
    /// Unit of the value.
    pub unit: UnitKey,
    /// Best fitting shift between set-points and encoder, by run; `null` if the axis does not move.
    pub shift_ms: Vec<Option<f64>>,
    /// Half width of the 95 % interval of the velocity gain; `null` without a visible lag.
    pub velocity_gain_95_per_s: Option<f64>,
    /// Half width of the 95 % interval of the feed-forward; `null` if it is not determined.
    pub feed_forward_95: Option<f64>,
    /// Half width of the 95 % interval of the lag; `null` if it is not determined.
    pub lag_95_ms: Option<f64>,
    /// Half width of the 95 % interval of the RMS residual.
    pub rms_95: f64,
    /// Half widths of the 95 % intervals of the shifts.
    pub shift_95_ms: Vec<Option<f64>>,
    /// True if the interval of the velocity gain is narrow enough for the machine file.
    pub is_determined: bool,
    /// Reason why the velocity gain is not determined, and the remedy.
    pub not_determined: Option<NotDetermined>,
}

/// A link error.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LinkReport {
    /// Its name.
    pub parameter: String,
    /// Its value relative to the machine file, µm or µrad; without meaning if it is not determined.
    pub value: f64,
    /// Unit of the value.
    pub unit: UnitKey,
    /// True if the path separates it from the other links.
    pub is_told: bool,
    /// True if its 95 % interval is narrower than its usual size.
    pub is_determined: bool,
    /// Half width of its 95 % interval, including the part that a smooth motion error may explain.
    pub uncertainty_95: f64,
    /// Its 95 % interval.
    pub interval_95: [f64; 2],
    /// Usual size of such an error, as a standard deviation.
    pub usual_size: f64,
    /// Reason why it is not determined, and the remedy.
    pub not_determined: Option<NotDetermined>,
}

/// A number for each source.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BySource<T> {
    /// The servo loops.
    pub contouring: T,
    /// Link errors.
    pub link: T,
    /// Motion errors.
    pub motion: T,
    /// Thermal drift.
    pub thermal: T,
    /// Deflections and other residuals.
    pub dynamic: T,
}

impl<T: Copy> BySource<T> {
    /// Creates it from a list in the order of [`crate::decompose::SOURCES`].
    #[must_use]
    pub fn new([contouring, link, motion, thermal, dynamic]: [T; 5]) -> BySource<T> {
        BySource { contouring, link, motion, thermal, dynamic }
    }

    /// The values as such a list.
    #[must_use]
    pub fn list(&self) -> [T; 5] {
        [self.contouring, self.link, self.motion, self.thermal, self.dynamic]
    }
}

/// A run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RunReport {
    /// Its label.
    pub run: String,
    /// Programmed feed.
    pub feed_mm_min: Option<f64>,
    /// Number of samples in which the machine moves.
    pub samples: usize,
    /// Duration of its motion.
    pub moving_s: f64,
    /// Mean share of the sum of the norms.
    pub share_percent: BySource<f64>,
    /// Largest magnitude along X, Y, Z.
    pub max_um: BySource<[f64; 3]>,
    /// RMS along X, Y, Z.
    pub rms_um: BySource<[f64; 3]>,
    /// Offset relative to the slowest run along X, Y, Z.
    pub thermal_um: [f64; 3],
    /// Half widths of the 95 % intervals of the shares.
    pub share_95_percent: BySource<f64>,
    /// Half widths of the 95 % intervals of the largest magnitudes.
    pub max_95_um: BySource<[f64; 3]>,
    /// Half widths of the 95 % intervals of the RMS.
    pub rms_95_um: BySource<[f64; 3]>,
    /// Half widths of the 95 % intervals of the offset.
    pub thermal_95_um: [f64; 3],
    /// The contouring error at right angles to the path in the workpiece: largest and RMS.
    pub contouring_error_um: [f64; 2],
    /// Length of that path.
    pub path_in_workpiece_mm: f64,
    /// RMS of single readings about their mean over a control cycle, X, Y, Z.
    pub noise_um: [f64; 3],
    /// RMS of the dynamic part, and its residual with the compliances of the other feeds; averaged as accelerations are.
    pub held_out_um: Option<[f64; 2]>,
    /// Samples along the path, for pictures.
    #[serde(skip)]
    pub along: Vec<Along>,
    /// Times since the start of motion at which another block began, s, for pictures.
    #[serde(skip)]
    pub transitions_s: Vec<f64>,
}

/// A sample, for pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Along {
    /// Time since the start of motion, s.
    pub t_s: f64,
    /// The sources along X, Y, Z, µm.
    pub parts_um: [[f64; 3]; 5],
    /// Part explained by compliances, µm.
    pub explained_um: [f64; 3],
    /// Accelerations of the axes, m/s² or rad/s².
    pub acceleration: AxisVector,
}

/// A compliance.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ComplianceReport {
    /// The compliant component.
    pub component: String,
    /// The axis that accelerates.
    pub axis: String,
    /// Cause of the deflection.
    pub of: Under,
    /// Its value, in `unit`.
    pub value: f64,
    /// Its standard uncertainty.
    pub uncertainty: f64,
    /// Half width of its 95 % interval.
    pub uncertainty_95: f64,
    /// The key of the machine file: `um_per_m_s2`.
    pub unit: String,
    /// Relative reduction of the RMS of feeds to which it was not fitted, when it was added.
    pub gain: f64,
    /// True if its 95 % interval excludes zero. Other compliances are not named.
    pub is_determined: bool,
}

/// Cause of a deflection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Under {
    /// Acceleration.
    #[default]
    Acceleration,
    /// Jerk.
    Jerk,
}

impl Under {
    /// In words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Under::Acceleration => "acceleration",
            Under::Jerk => "jerk",
        }
    }
}

/// The source described by a power law.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum LawOf {
    /// The servo loops.
    #[default]
    Contouring,
    /// Deflections.
    Dynamic,
}

impl LawOf {
    /// In words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            LawOf::Contouring => "contouring",
            LawOf::Dynamic => "dynamic",
        }
    }
}

/// Power law δ = κ Fᴺ.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Law {
    /// Its source.
    pub source: LawOf,
    /// `X`, `Y`, `Z`.
    pub direction: &'static str,
    /// κ, µm at 1 mm/min.
    pub factor_um: f64,
    /// N.
    pub exponent: f64,
    /// Half width of its 95 % interval; `null` with two feeds.
    pub exponent_95: Option<f64>,
    /// Explained share of the variance of the logarithms.
    pub explained: f64,
    /// N without the slowest run.
    pub without_slowest: Option<f64>,
    /// 95 % interval of κ; `null` with two feeds.
    pub factor_95_um: Option<[f64; 2]>,
    /// Half width of the 95 % interval of N without the slowest run.
    pub without_slowest_95: Option<f64>,
    /// True if the interval of N separates whole exponents.
    pub is_determined: bool,
    /// Reason why N is not determined, and the remedy.
    pub not_determined: Option<NotDetermined>,
}

/// Names of the directions.
pub const DIRECTIONS: [&str; 3] = ["X", "Y", "Z"];

impl DecompositionResult {
    /// `true` if an instrument measured.
    #[must_use]
    pub fn is_measured(&self) -> bool {
        self.reading_delay.is_some()
    }
}

/// The diagnostic for traces that cannot be decomposed.
#[must_use]
pub fn told(fault: &DecompositionError) -> Diagnostic {
    let (code, help) = match fault {
        DecompositionError::Still => {
            (Code::NOT_TOLD, "record while the axes move, and check that set-points are in mm and degrees")
        }
        DecompositionError::Apart => {
            (Code::NOT_TOLD, "check t_s of both records: their clocks may differ by up to half a second")
        }
        DecompositionError::OtherPath(..) => {
            (Code::NOT_TOLD, "give runs of one program; decompose runs of another program separately")
        }
        DecompositionError::Units(..) => {
            (Code::DATA_SIZE, "write set-points and encoders in mm and degrees: is a column in inches or rad?")
        }
        DecompositionError::NotIdentified(_) => {
            (Code::NOT_TOLD, "record a longer run, or give fewer --links and a lower degree of --motion")
        }
    };
    Diagnostic::nowhere(code, fault.to_string(), help)
}

/// Fills the report.
pub fn fill(found: &decompose::Decomposition, trace: &Trace, report: &mut DecompositionResult) {
    report.cycle_ms = ms(found.cycle_s);
    if let Some(servo) = &found.servo {
        report.record_delay = delay(servo.delay_s, servo.uncertainty_s, &[], found.cycle_s);
        for axis in &servo.axes {
            let is_rotary = axis.axis.is_rotary();
            report.servo.push(Loop {
                axis: axis.axis.to_string(),
                velocity_gain_per_s: axis.velocity_gain,
                feed_forward: axis.feed_forward,
                lag_ms: ms(axis.lag_s()),
                rms: UnitKey::of(is_rotary).unit().shown(axis.rms),
                unit: UnitKey::of(is_rotary),
                shift_ms: axis.shift_s.iter().map(|(shift, _)| finite(ms(*shift))).collect(),
                velocity_gain_95_per_s: axis.velocity_gain.and_then(|_| finite(axis.limits.velocity_gain)),
                feed_forward_95: finite(axis.limits.feed_forward),
                lag_95_ms: finite(ms(axis.limits.lag_s)),
                rms_95: UnitKey::of(is_rotary).unit().shown(axis.limits.rms),
                shift_95_ms: axis.shift_s.iter().map(|(_, error)| finite(SIGMAS_95 * ms(*error))).collect(),
                is_determined: axis.is_determined(),
                not_determined: (!axis.is_determined()).then(|| no_gain(axis)),
            });
        }
    }
    let of_clock = |clock: &decompose::Clock| delay(clock.delay_s, clock.uncertainty_s, &clock.by_run, found.cycle_s);
    report.reading_delay = found.clock.as_ref().map(of_clock);
    report.links = found.links.iter().map(link).collect();
    report.motion = match found.smooth {
        Smooth::Pose(degree) => format!("pose:{degree}"),
        Smooth::Path(degree) => format!("path:{degree}"),
    };
    let held = |number: usize| found.held_out_mm.get(number).map(|both| both.map(um_from_mm));
    let runs = found.runs.iter().enumerate();
    let delay_s = found.servo.as_ref().map_or(0.0, |servo| servo.delay_s);
    report.runs = runs.map(|(place, run)| shown_run(run, trace, delay_s, held(found.fold(place)))).collect();
    report.dynamic_accuracy = report.runs.last().filter(|_| report.is_measured()).map(DynamicAccuracy::of);
    report.compliances = found.compliances.iter().map(compliance).collect();
    for (source, laws) in [LawOf::Contouring, LawOf::Dynamic].into_iter().zip(&found.laws) {
        for (direction, law) in DIRECTIONS.into_iter().zip(laws) {
            report.power_laws.extend(law.map(|law| Law {
                source,
                direction,
                factor_um: um_from_mm(law.factor),
                exponent: law.exponent,
                exponent_95: law.exponent_limit.is_finite().then_some(law.exponent_limit),
                explained: law.explained,
                without_slowest: law.without_first,
                factor_95_um: law.exponent_limit.is_finite().then_some(law.factor_interval.map(um_from_mm)),
                without_slowest_95: law.without_first_limit.and_then(finite),
                is_determined: law.is_determined(),
                not_determined: (!law.is_determined()).then(|| no_law(&law)),
            }));
        }
    }
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

fn ms(s: f64) -> f64 {
    1e3 * s
}

/// A delay with its standard uncertainty, those of the runs, and the cycle of the control, s.
fn delay(delay_s: f64, uncertainty_s: f64, by_run: &[(f64, f64)], cycle_s: f64) -> Delay {
    // The encoders and set-points of one cycle belong together only if the delay is known to a cycle.
    let is_determined = SIGMAS_95 * uncertainty_s < cycle_s;
    Delay {
        is_determined,
        not_determined: (!is_determined).then(|| NotDetermined {
            reason: format!("± {:.1} ms is more than a cycle of {:.1} ms", SIGMAS_95 * ms(uncertainty_s), ms(cycle_s)),
            measure: "a path with corners and reversals of several axes, at a higher feed".into(),
        }),
        ms: ms(delay_s),
        uncertainty_ms: ms(uncertainty_s),
        uncertainty_95_ms: SIGMAS_95 * ms(uncertainty_s),
        by_run_ms: by_run.iter().map(|(delay, _)| ms(*delay)).collect(),
        by_run_95_ms: by_run.iter().map(|(_, error)| finite(SIGMAS_95 * ms(*error))).collect(),
    }
}

fn link(link: &decompose::LinkError) -> LinkReport {
    let is_rotation = link.name.component.direction.is_rotation();
    let shown = |value: f64| UnitKey::of(is_rotation).unit().shown(value);
    LinkReport {
        parameter: link.name.to_string(),
        value: shown(link.value),
        unit: UnitKey::of(is_rotation),
        is_told: link.is_told,
        is_determined: link.is_determined,
        uncertainty_95: shown(link.uncertainty_95),
        interval_95: [link.value - link.uncertainty_95, link.value + link.uncertainty_95].map(shown),
        usual_size: shown(link.usual_size),
        not_determined: (!link.is_determined).then(|| NotDetermined {
            reason: if link.is_told {
                let sign = UnitKey::of(is_rotation).unit().sign();
                let [by, usual] = [link.uncertainty_95, link.usual_size].map(shown);
                let wide = 2.0 * by;
                format!("± {by:.1} {sign} is {wide:.1} {sign} wide, more than the usual size of {usual:.1} {sign}")
            } else {
                "other links have the same effect on this path".into()
            },
            measure:
                "a path over a larger part of the travel, or ncfix calibrate with measurements over the whole volume"
                    .into(),
        }),
    }
}

/// Reason why the velocity gain of a loop is not determined.
fn no_gain(axis: &AxisServoErrors) -> NotDetermined {
    let reason = match axis.velocity_gain {
        None => "no lag is visible".into(),
        Some(_) if axis.limits.velocity_gain.is_finite() => {
            format!("± {:.1} 1/s is more than an eighth of it", axis.limits.velocity_gain)
        }
        Some(_) => "this motion does not separate it from the feed-forward".into(),
    };
    NotDetermined { reason, measure: format!("reversals of {} at a higher feed, without feed-forward", axis.axis) }
}

/// Reason why an exponent is not determined.
fn no_law(law: &decompose::PowerLaw) -> NotDetermined {
    let reason = if law.exponent_limit.is_finite() {
        format!("its interval of ± {:.2} does not separate whole exponents", law.exponent_limit)
    } else {
        "a line through two feeds has no interval".into()
    };
    NotDetermined { reason, measure: "the same path at more feeds, over a wider range".into() }
}

fn compliance(one: &decompose::Compliance) -> ComplianceReport {
    let factor = dynamic::factor(one.name);
    ComplianceReport {
        component: one.name.to_string(),
        axis: one.name.axis().map_or_else(String::new, |axis| axis.to_string()),
        of: if one.order == 3 { Under::Jerk } else { Under::Acceleration },
        value: one.value / factor,
        uncertainty: one.uncertainty / factor,
        uncertainty_95: SIGMAS_95 * one.uncertainty / factor,
        unit: dynamic::key(one.name, one.order),
        gain: one.gain,
        is_determined: SIGMAS_95 * one.uncertainty < one.value.abs(),
    }
}

fn um(vector: &Vector) -> [f64; 3] {
    [0, 1, 2].map(|k| um_from_mm(vector[k]))
}

fn shown_run(run: &RunParts, trace: &Trace, delay_s: f64, held_out_um: Option<[f64; 2]>) -> RunReport {
    let transitions = trace.runs.get(run.number).into_iter().flat_map(|one| &one.transitions_s);
    let in_um = |of: &[[f64; 3]; 5]| BySource::new(of.map(|along| along.map(um_from_mm)));
    let norms: Vec<f64> = run.moving.clone().map(|k| um_from_mm(run.contouring[k].norm())).collect();
    let rms = (norms.iter().map(|norm| norm * norm).sum::<f64>() / norms.len().max(1) as f64).sqrt();
    let start = run.t_s.get(run.moving.start).copied().unwrap_or(0.0);
    let along = run.moving.clone().map(|k| {
        let none = Vector::zeros();
        let parts = run.parts[k].unwrap_or([run.following[k], none, none, none, none]);
        let mut acceleration = run.acceleration[k];
        for axis in AXES.into_iter().filter(|axis| !axis.is_rotary()) {
            acceleration[axis] /= MM_PER_M;
        }
        Along {
            t_s: run.t_s[k] - start,
            parts_um: parts.map(|part| um(&part)),
            explained_um: um(&run.explained[k]),
            acceleration,
        }
    });
    RunReport {
        run: trace.runs.get(run.number).map_or_else(String::new, |one| one.label.clone()),
        feed_mm_min: run.feed_mm_min,
        samples: run.moving.len(),
        moving_s: run.t_s.get(run.moving.end.saturating_sub(1)).map_or(0.0, |end| end - start),
        share_percent: BySource::new(run.shares.percent),
        max_um: in_um(&run.shares.max_mm),
        rms_um: in_um(&run.shares.rms_mm),
        thermal_um: um(&run.thermal_mm),
        share_95_percent: BySource::new(run.shares_95.percent),
        max_95_um: in_um(&run.shares_95.max_mm),
        rms_95_um: in_um(&run.shares_95.rms_mm),
        thermal_95_um: um(&run.thermal_95_mm),
        contouring_error_um: [norms.iter().copied().fold(0.0, f64::max), rms],
        path_in_workpiece_mm: run.in_workpiece_mm,
        noise_um: run.fast_mm.map(um_from_mm),
        held_out_um,
        along: along.collect(),
        // Blocks begin by the set-points, which the encoders follow later.
        transitions_s: transitions.map(|t_s| t_s + delay_s - start).collect(),
    }
}

/// The text of a machine file with the links that were found, determined loops and compliances; `None` if it cannot contain them. It is unchanged without any of these.
#[must_use]
pub fn extended(text: &[u8], found: &decompose::Decomposition) -> Option<String> {
    let mut edit = Edit::parse(std::str::from_utf8(text).ok()?)?;
    let links = found.links.iter().filter(|link| link.is_found()).all(|link| write_link(&mut edit, link));
    let loops = found.servo.iter().flat_map(|servo| &servo.axes).filter(|axis| axis.is_determined());
    let loops = loops.into_iter().all(|axis| write_loop(&mut edit, axis));
    let compliances = found.compliances.iter().all(|one| write_compliance(&mut edit, one));
    (links && loops && compliances).then(|| edit.text())
}

/// Adds a link to the location error of the machine file. A parameter of a motion error is for the calibration, which sees its whole axis.
fn write_link(edit: &mut Edit, link: &LinkError) -> bool {
    let component = link.name.component;
    if component.kind != ErrorKind::Location {
        return true;
    }
    // A tilt of the spindle belongs to one head.
    if component.axis().is_none() && edit.count("head") > 0 {
        return false;
    }
    let key = component.to_string();
    let value = Unit::of(component.direction.is_rotation()).shown(link.value);
    let sum = edit.number("location", 0, &key).unwrap_or(0.0) + rounded(value);
    edit.set("location", &key, &Given::Number(sum))
}

/// Replaces gain and feed-forward of a loop that the machine file has. Without `[servo]` its limits of accelerations and corners are unknown, and none is
/// written.
fn write_loop(edit: &mut Edit, axis: &AxisServoErrors) -> bool {
    let key = |name: &str| format!("{}.{name}", axis.axis);
    let (by_s, by_min, forward) = (key("velocity_gain_per_s"), key("velocity_gain_m_min_mm"), key("feed_forward"));
    let Some(gain) = axis.velocity_gain else { return true };
    if !edit.has("servo", 0, &axis.axis.to_string()) {
        return true;
    }
    // The file takes a share up to 1; more is written as 1 within its interval, and otherwise not at all.
    if axis.feed_forward - axis.limits.feed_forward > 1.0 || axis.feed_forward < 0.0 {
        return true;
    }
    let (key, gain) = if edit.has("servo", 0, &by_min) { (by_min, gain * M_MIN_MM_OF_PER_S) } else { (by_s, gain) };
    let share = rounded(axis.feed_forward.min(1.0));
    edit.set_at("servo", 0, &key, &Given::Number(rounded(gain)))
        && edit.set_at("servo", 0, &forward, &Given::Number(share))
}

/// Adds a compliance to those of its component.
fn write_compliance(edit: &mut Edit, one: &decompose::Compliance) -> bool {
    let (component, key) = (one.name.to_string(), dynamic::key(one.name, one.order));
    let value = rounded(one.value / dynamic::factor(one.name));
    let known =
        (0..edit.count("dynamic")).find(|&index| edit.word("dynamic", index, "component") == Some(component.as_str()));
    match known {
        Some(index) => {
            let sum = edit.number("dynamic", index, &key).unwrap_or(0.0) + value;
            edit.set_in("dynamic", index, &key, &Given::Number(sum))
        }
        None => edit.push("dynamic", &[("component".to_owned(), Given::Text(component)), (key, Given::Number(value))]),
    }
}

/// Five digits, the available accuracy.
fn rounded(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(value)
}
