//! What a trace at several feeds was divided into: the object for programs and its text for people; its page is in [`super::page::decomposition`].

use std::fmt::Write as _;

use serde::Serialize;

use super::compared::Input;
use super::json::Finding;
use super::number::{grouped, significant};

/// The version of the object.
pub const SCHEMA: u32 = 1;

/// The result of `ncfix decompose`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Decomposition {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Name of the machine.
    pub machine: String,
    /// Cycle of the control.
    pub cycle_ms: f64,
    /// Delay of the record of the encoders behind that of the set-points.
    pub record_delay: Delay,
    /// Delay of the readings behind the encoders; `null` where nothing was measured.
    pub reading_delay: Option<Delay>,
    /// The loops of the axes that move.
    pub servo: Vec<Loop>,
    /// Link errors beyond those of the machine file.
    pub links: Vec<Link>,
    /// How motion errors were described: `pose:6`, `path:20`.
    pub motion: String,
    /// The runs, the slowest first.
    pub runs: Vec<Run>,
    /// What gives way, in the order in which it was found.
    pub compliances: Vec<Compliance>,
    /// Power laws of the RMS: contouring and dynamic, along X, Y, Z.
    pub power_laws: Vec<Law>,
    /// The machine file that was written.
    pub output: Option<String>,
    /// The page that was written.
    pub report: Option<String>,
    /// Findings.
    pub diagnostics: Vec<Finding>,
    /// Files that it comes from.
    #[serde(skip)]
    pub inputs: Vec<Input>,
}

/// A delay.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Delay {
    /// Its value.
    pub ms: f64,
    /// Its standard uncertainty; 0 where it was given.
    pub uncertainty_ms: f64,
    /// Of every run alone.
    pub by_run_ms: Vec<f64>,
}

/// A servo loop.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Loop {
    /// Its axis.
    pub axis: String,
    /// Velocity gain; `null` where no lag is seen.
    pub velocity_gain_per_s: Option<f64>,
    /// Share of velocity feed-forward.
    pub feed_forward: f64,
    /// Lag at constant velocity.
    pub lag_ms: f64,
    /// RMS of what is left between encoder and loop, µm or µrad.
    pub rms: f64,
    /// `um` or `urad`.
    pub unit: &'static str,
    /// Shift between set-points and encoder that fits best, by run; `null` where the axis stands.
    pub shift_ms: Vec<Option<f64>>,
}

/// A link error.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Link {
    /// Its name.
    pub parameter: String,
    /// Its value beyond the machine file, µm or µrad.
    pub value: f64,
    /// `um` or `urad`.
    pub unit: &'static str,
    /// Whether the path tells it from the others.
    pub is_told: bool,
}

/// A number for each source.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct BySource<T> {
    /// The servo loops.
    pub contouring: T,
    /// Link errors.
    pub link: T,
    /// Motion errors.
    pub motion: T,
    /// Thermal drift.
    pub thermal: T,
    /// Deflections, and what else is left.
    pub dynamic: T,
}

impl<T: Copy> BySource<T> {
    /// From a list in the order of [`ncfix_metrology::decompose::SOURCES`].
    #[must_use]
    pub fn new([contouring, link, motion, thermal, dynamic]: [T; 5]) -> BySource<T> {
        BySource { contouring, link, motion, thermal, dynamic }
    }

    /// As such a list.
    #[must_use]
    pub fn list(&self) -> [T; 5] {
        [self.contouring, self.link, self.motion, self.thermal, self.dynamic]
    }
}

/// A run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Run {
    /// Its label.
    pub run: String,
    /// Programmed feed.
    pub feed_mm_min: Option<f64>,
    /// Samples in which the machine moves.
    pub samples: usize,
    /// How long it moves.
    pub moving_s: f64,
    /// Mean share of the sum of the norms.
    pub share_percent: BySource<f64>,
    /// Largest magnitude along X, Y, Z.
    pub max_um: BySource<[f64; 3]>,
    /// RMS along X, Y, Z.
    pub rms_um: BySource<[f64; 3]>,
    /// Offset against the slowest run along X, Y, Z.
    pub thermal_um: [f64; 3],
    /// The contouring error at right angles to the path in the workpiece: largest and RMS.
    pub contouring_error_um: [f64; 2],
    /// Length of that path.
    pub path_in_workpiece_mm: f64,
    /// RMS of single readings about their mean over a cycle, X, Y, Z.
    pub noise_um: [f64; 3],
    /// RMS of the dynamic part as it is, and as the compliances that the other feeds tell leave it; averaged as accelerations are.
    pub held_out_um: Option<[f64; 2]>,
    /// Along the path, for pictures.
    #[serde(skip)]
    pub along: Vec<Along>,
}

/// A sample, for pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Along {
    /// Since the run began to move, s.
    pub t_s: f64,
    /// The sources along X, Y, Z, µm.
    pub parts_um: [[f64; 3]; 5],
    /// What compliances explain, µm.
    pub explained_um: [f64; 3],
}

/// A compliance.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Compliance {
    /// The component that gives way.
    pub component: String,
    /// The axis that accelerates.
    pub axis: String,
    /// `acceleration` or `jerk`.
    pub of: &'static str,
    /// Its value, by `unit`.
    pub value: f64,
    /// Its standard uncertainty.
    pub uncertainty: f64,
    /// The key of the machine file: `um_per_m_s2`.
    pub unit: String,
    /// By which share the RMS of feeds that it was not fitted to fell when it was added.
    pub gain: f64,
}

/// δ = κ Fᴺ.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Law {
    /// `contouring` or `dynamic`.
    pub source: &'static str,
    /// `X`, `Y`, `Z`.
    pub direction: &'static str,
    /// κ, µm at 1 mm/min.
    pub factor_um: f64,
    /// N.
    pub exponent: f64,
    /// Half width of its interval of 95 %; `null` with two feeds.
    pub exponent_95: Option<f64>,
    /// Share of the variance of the logarithms that it explains.
    pub explained: f64,
    /// N without the slowest run.
    pub without_slowest: Option<f64>,
}

/// Names of the directions.
pub const DIRECTIONS: [&str; 3] = ["X", "Y", "Z"];

impl Decomposition {
    /// Whether an instrument measured.
    #[must_use]
    pub fn is_measured(&self) -> bool {
        self.reading_delay.is_some()
    }

    /// What it says in a sentence.
    #[must_use]
    pub fn verdict(&self) -> String {
        let Some(fast) = self.runs.last() else { return "Nothing was divided.".into() };
        let feed = fast.feed_mm_min.map_or_else(String::new, |feed| format!(" at {} mm/min", grouped(feed as u64)));
        if !self.is_measured() {
            return format!(
                "The servo loops make up to {} µm{feed}; without an instrument nothing else can be told.",
                significant(norm(fast.max_um.contouring))
            );
        }
        let mut parts: Vec<(&str, f64)> =
            ncfix_metrology::decompose::SOURCES.into_iter().zip(fast.share_percent.list()).collect();
        parts.sort_by(|a, b| b.1.total_cmp(&a.1));
        let shares: Vec<String> = parts.iter().take(3).map(|(name, share)| format!("{name} {share:.1} %")).collect();
        let named: Vec<&str> = self.compliances.iter().map(|one| one.component.as_str()).collect();
        let why = if named.is_empty() { String::new() } else { format!(" What gives way: {}.", named.join(", ")) };
        format!("Of the error{feed}: {}.{why}", shares.join(", "))
    }

    /// The text for people.
    #[must_use]
    pub fn page(&self) -> String {
        let mut out = String::new();
        let _ = writeln!(out, "{}\n", self.verdict());
        self.write_delays(&mut out);
        self.write_runs(&mut out);
        self.write_compliances(&mut out);
        self.write_laws(&mut out);
        out
    }

    fn write_delays(&self, out: &mut String) {
        let line = |out: &mut String, what: &str, delay: &Delay| {
            let by =
                if delay.uncertainty_ms > 0.0 { format!(" ± {:.3}", delay.uncertainty_ms) } else { " (given)".into() };
            let _ = writeln!(out, "{what:<40} {:>9.3}{by} ms", delay.ms);
        };
        line(out, "encoders behind set-points (record)", &self.record_delay);
        if let Some(delay) = &self.reading_delay {
            line(out, "readings behind encoders", delay);
        }
        let _ = writeln!(out, "\naxis  velocity gain, 1/s  feed-forward  lag, ms  left, RMS");
        for one in &self.servo {
            let gain = one.velocity_gain_per_s.map_or("no lag seen".into(), |gain| format!("{gain:.1}"));
            let _ = writeln!(
                out,
                "{:<4}  {gain:>18}  {:>12.4}  {:>7.3}  {} {}",
                one.axis,
                one.feed_forward,
                one.lag_ms,
                significant(one.rms),
                unit_sign(one.unit)
            );
        }
    }

    fn write_runs(&self, out: &mut String) {
        if self.is_measured() {
            let _ = writeln!(
                out,
                "\nmean share of the norms, %\n   F, mm/min  contouring    link  motion  thermal  dynamic"
            );
            for run in &self.runs {
                let [c, l, m, t, d] = run.share_percent.list();
                let _ = writeln!(out, "{}  {c:>10.1}  {l:>6.1}  {m:>6.1}  {t:>7.1}  {d:>7.1}", feed_cell(run));
            }
        }
        for (title, which) in [("largest", 0), ("RMS", 1)] {
            let sources: &[(&str, usize)] = if self.is_measured() {
                &[("contouring", 0), ("link", 1), ("motion", 2), ("dynamic", 4)]
            } else {
                &[("contouring", 0)]
            };
            let _ = write!(out, "\n{title} along X Y Z, µm\n   F, mm/min");
            for (name, _) in sources {
                let _ = write!(out, "  {name:^20}");
            }
            out.push('\n');
            for run in &self.runs {
                let of = if which == 0 { run.max_um } else { run.rms_um };
                out.push_str(&feed_cell(run));
                for &(_, source) in sources {
                    let [x, y, z] = of.list()[source].map(significant);
                    let _ = write!(out, "  {x:>6} {y:>6} {z:>6}");
                }
                out.push('\n');
            }
        }
        let _ = writeln!(
            out,
            "\n   F, mm/min  contouring error at right angles to the path, µm: largest, RMS  thermal X Y Z, µm"
        );
        for run in &self.runs {
            let [max, rms] = run.contouring_error_um.map(significant);
            let [x, y, z] = run.thermal_um.map(significant);
            let _ = writeln!(out, "{}  {max:>50}  {rms:>6}     {x:>6} {y:>6} {z:>6}", feed_cell(run));
        }
    }

    fn write_compliances(&self, out: &mut String) {
        if !self.is_measured() {
            return;
        }
        if self.compliances.is_empty() {
            let _ = writeln!(out, "\nNo compliance explains what is left at feeds that it was not fitted to.");
            return;
        }
        let _ =
            writeln!(out, "\nwhat gives way  with                value                          gain at other feeds");
        for one in &self.compliances {
            let with = format!("{} of {}", one.of, one.axis);
            let value = format!("{:.4} ± {:.4} {}", one.value, one.uncertainty, one.unit);
            let _ = writeln!(out, "{:<14}  {with:<18}  {value:<30} {:>5.1} %", one.component, 100.0 * one.gain);
        }
        let _ = writeln!(out, "\n   F, mm/min  dynamic part, RMS µm  left by the compliances of the other feeds");
        for run in &self.runs {
            if let Some([before, after]) = run.held_out_um.map(|both| both.map(significant)) {
                let _ = writeln!(out, "{}  {before:>20}  {after:>6}", feed_cell(run));
            }
        }
    }

    fn write_laws(&self, out: &mut String) {
        if self.power_laws.is_empty() {
            return;
        }
        let _ = writeln!(out, "\nRMS = κ Fᴺ         κ, µm         N    ± (95 %)     R²  N without the slowest run");
        for law in &self.power_laws {
            let limit = law.exponent_95.map_or("–".into(), |limit| format!("{limit:.2}"));
            let without = law.without_slowest.map_or("–".into(), |exponent| format!("{exponent:.2}"));
            let _ = writeln!(
                out,
                "{:<10} {}   {:>10.3e}  {:>8.2}  {limit:>10}  {:>5.3}  {without:>6}",
                law.source, law.direction, law.factor_um, law.exponent, law.explained
            );
        }
    }
}

/// `um` as `µm`.
#[must_use]
pub fn unit_sign(unit: &str) -> &'static str {
    if unit == "urad" { "µrad" } else { "µm" }
}

fn norm([x, y, z]: [f64; 3]) -> f64 {
    x.hypot(y).hypot(z)
}

fn feed_cell(run: &Run) -> String {
    let feed = run.feed_mm_min.map_or("–".into(), |feed| grouped(feed.round() as u64));
    format!("{feed:>12}")
}
