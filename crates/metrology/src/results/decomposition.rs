//! A decomposition of traces at several feeds into its sources, in display units, and the machine file with compliances.

use serde::Serialize;

use crate::decompose::{self, DecompositionError, RunParts, Smooth};
use crate::measure::trace::Trace;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::Vector;
use ncfix_base::units::{UnitKey, um_from_mm};
use ncfix_machine::machine::edit::{Edit, Given};
use ncfix_model::source::dynamic;

/// The version of the object.
pub const SCHEMA: u32 = 1;

/// Decomposition of traces at several feeds.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DecompositionResult {
    /// [`SCHEMA`].
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
}

/// A delay.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Delay {
    /// Its value.
    pub ms: f64,
    /// Its standard uncertainty; 0 if it was given.
    pub uncertainty_ms: f64,
    /// Delay of every run alone.
    pub by_run_ms: Vec<f64>,
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
}

/// A link error.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LinkReport {
    /// Its name.
    pub parameter: String,
    /// Its value relative to the machine file, µm or µrad.
    pub value: f64,
    /// Unit of the value.
    pub unit: UnitKey,
    /// True if the path separates it from the others.
    pub is_told: bool,
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
    /// The key of the machine file: `um_per_m_s2`.
    pub unit: String,
    /// Relative reduction of the RMS of feeds to which it was not fitted, when it was added.
    pub gain: f64,
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
    let ms = |s: f64| 1e3 * s;
    report.cycle_ms = ms(found.cycle_s);
    if let Some(servo) = &found.servo {
        report.record_delay =
            Delay { ms: ms(servo.delay_s), uncertainty_ms: ms(servo.uncertainty_s), by_run_ms: Vec::new() };
        for axis in &servo.axes {
            let is_rotary = axis.axis.is_rotary();
            report.servo.push(Loop {
                axis: axis.axis.to_string(),
                velocity_gain_per_s: axis.velocity_gain,
                feed_forward: axis.feed_forward,
                lag_ms: ms(axis.lag_s()),
                rms: UnitKey::of(is_rotary).unit().shown(axis.rms),
                unit: UnitKey::of(is_rotary),
                shift_ms: axis.shift_s.iter().map(|(shift, _)| shift.is_finite().then_some(ms(*shift))).collect(),
            });
        }
    }
    report.reading_delay = found.clock.as_ref().map(|clock| Delay {
        ms: ms(clock.delay_s),
        uncertainty_ms: ms(clock.uncertainty_s),
        by_run_ms: clock.by_run.iter().map(|(delay, _)| ms(*delay)).collect(),
    });
    report.links = found.links.iter().map(link).collect();
    report.motion = match found.smooth {
        Smooth::Pose(degree) => format!("pose:{degree}"),
        Smooth::Path(degree) => format!("path:{degree}"),
    };
    let held = |number: usize| found.held_out_mm.get(number).map(|both| both.map(um_from_mm));
    let runs = found.runs.iter().enumerate();
    report.runs = runs.map(|(place, run)| shown_run(run, trace, held(found.fold(place)))).collect();
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
            }));
        }
    }
}

fn link(link: &decompose::LinkError) -> LinkReport {
    let is_rotation = link.name.component.direction.is_rotation();
    LinkReport {
        parameter: link.name.to_string(),
        value: UnitKey::of(is_rotation).unit().shown(link.value),
        unit: UnitKey::of(is_rotation),
        is_told: link.is_told,
    }
}

fn compliance(one: &decompose::Compliance) -> ComplianceReport {
    let factor = dynamic::factor(one.name);
    ComplianceReport {
        component: one.name.to_string(),
        axis: one.name.axis().map_or_else(String::new, |axis| axis.to_string()),
        of: if one.order == 3 { Under::Jerk } else { Under::Acceleration },
        value: one.value / factor,
        uncertainty: one.uncertainty / factor,
        unit: dynamic::key(one.name, one.order),
        gain: one.gain,
    }
}

fn um(vector: &Vector) -> [f64; 3] {
    [0, 1, 2].map(|k| um_from_mm(vector[k]))
}

fn shown_run(run: &RunParts, trace: &Trace, held_out_um: Option<[f64; 2]>) -> RunReport {
    let in_um = |of: &[[f64; 3]; 5]| BySource::new(of.map(|along| along.map(um_from_mm)));
    let norms: Vec<f64> = run.moving.clone().map(|k| um_from_mm(run.contouring[k].norm())).collect();
    let rms = (norms.iter().map(|norm| norm * norm).sum::<f64>() / norms.len().max(1) as f64).sqrt();
    let start = run.t_s.get(run.moving.start).copied().unwrap_or(0.0);
    let along = run.moving.clone().map(|k| {
        let none = Vector::zeros();
        let parts = run.parts[k].unwrap_or([run.following[k], none, none, none, none]);
        Along { t_s: run.t_s[k] - start, parts_um: parts.map(|part| um(&part)), explained_um: um(&run.explained[k]) }
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
        contouring_error_um: [norms.iter().copied().fold(0.0, f64::max), rms],
        path_in_workpiece_mm: run.in_workpiece_mm,
        noise_um: run.fast_mm.map(um_from_mm),
        held_out_um,
        along: along.collect(),
    }
}

/// The text of a machine file with the compliances added to the existing ones; `None` if it cannot contain them.
#[must_use]
pub fn extended(text: &[u8], found: &decompose::Decomposition) -> Option<String> {
    let mut edit = Edit::parse(std::str::from_utf8(text).ok()?)?;
    for one in &found.compliances {
        let (component, key) = (one.name.to_string(), dynamic::key(one.name, one.order));
        let value = rounded(one.value / dynamic::factor(one.name));
        let known = (0..edit.count("dynamic"))
            .find(|&index| edit.word("dynamic", index, "component") == Some(component.as_str()));
        let is_done = match known {
            Some(index) => {
                let sum = edit.number("dynamic", index, &key).unwrap_or(0.0) + value;
                edit.set_in("dynamic", index, &key, &Given::Number(sum))
            }
            None => {
                edit.push("dynamic", &[("component".to_owned(), Given::Text(component)), (key, Given::Number(value))])
            }
        };
        if !is_done {
            return None;
        }
    }
    Some(edit.text())
}

/// Five digits, the available accuracy.
fn rounded(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(value)
}
