//! Decomposition of a trace at several feeds: the JSON object and its text for people; its page is in [`super::page::decomposition`].

use std::fmt::Write as _;

use serde::Serialize;

use super::inputs::InputFile;
use super::json::Finding;
use super::number::{grouped, significant};
use ncfix_metrology::results::decomposition::{DecompositionResult, Delay, RunReport};

/// Output of `ncfix decompose`: the result, with its output files.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DecompositionReport {
    /// Result.
    #[serde(flatten)]
    pub found: DecompositionResult,
    /// Machine file that was written.
    pub output: Option<String>,
    /// Report page that was written.
    pub report: Option<String>,
    /// Diagnostics.
    pub diagnostics: Vec<Finding>,
    /// Files from which the result was computed.
    #[serde(skip)]
    pub inputs: Vec<InputFile>,
}

impl DecompositionReport {
    /// Returns the verdict in one sentence.
    #[must_use]
    pub fn verdict(&self) -> String {
        let Some(fast) = self.found.runs.last() else { return "Nothing was decomposed.".into() };
        let feed = fast.feed_mm_min.map_or_else(String::new, |feed| format!(" at {} mm/min", grouped(feed as u64)));
        if !self.found.is_measured() {
            return format!(
                "The servo loops cause up to {} µm{feed}; without an instrument nothing else can be determined.",
                significant(norm(fast.max_um.contouring))
            );
        }
        let mut parts: Vec<(&str, f64)> =
            ncfix_metrology::decompose::SOURCES.into_iter().zip(fast.share_percent.list()).collect();
        parts.sort_by(|a, b| b.1.total_cmp(&a.1));
        let shares: Vec<String> = parts.iter().take(3).map(|(name, share)| format!("{name} {share:.1} %")).collect();
        let named: Vec<&str> = self.found.compliances.iter().map(|one| one.component.as_str()).collect();
        let why = if named.is_empty() { String::new() } else { format!(" Compliance: {}.", named.join(", ")) };
        format!("Of the error{feed}: {}.{why}", shares.join(", "))
    }

    /// Returns the text for people.
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
        line(out, "encoder delay after set-points (record)", &self.found.record_delay);
        if let Some(delay) = &self.found.reading_delay {
            line(out, "reading delay after encoders", delay);
        }
        let _ = writeln!(out, "\naxis  velocity gain, 1/s  feed-forward  lag, ms  left, RMS");
        for one in &self.found.servo {
            let gain = one.velocity_gain_per_s.map_or("no lag seen".into(), |gain| format!("{gain:.1}"));
            let _ = writeln!(
                out,
                "{:<4}  {gain:>18}  {:>12.4}  {:>7.3}  {} {}",
                one.axis,
                one.feed_forward,
                one.lag_ms,
                significant(one.rms),
                one.unit.unit().sign()
            );
        }
    }

    fn write_runs(&self, out: &mut String) {
        if self.found.is_measured() {
            let _ = writeln!(
                out,
                "\nmean share of the norms, %\n   F, mm/min  contouring    link  motion  thermal  dynamic"
            );
            for run in &self.found.runs {
                let [c, l, m, t, d] = run.share_percent.list();
                let _ = writeln!(out, "{}  {c:>10.1}  {l:>6.1}  {m:>6.1}  {t:>7.1}  {d:>7.1}", feed_cell(run));
            }
        }
        for (title, which) in [("largest", 0), ("RMS", 1)] {
            let sources: &[(&str, usize)] = if self.found.is_measured() {
                &[("contouring", 0), ("link", 1), ("motion", 2), ("dynamic", 4)]
            } else {
                &[("contouring", 0)]
            };
            let _ = write!(out, "\n{title} along X Y Z, µm\n   F, mm/min");
            for (name, _) in sources {
                let _ = write!(out, "  {name:^20}");
            }
            out.push('\n');
            for run in &self.found.runs {
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
        for run in &self.found.runs {
            let [max, rms] = run.contouring_error_um.map(significant);
            let [x, y, z] = run.thermal_um.map(significant);
            let _ = writeln!(out, "{}  {max:>50}  {rms:>6}     {x:>6} {y:>6} {z:>6}", feed_cell(run));
        }
    }

    fn write_compliances(&self, out: &mut String) {
        if !self.found.is_measured() {
            return;
        }
        if self.found.compliances.is_empty() {
            let _ = writeln!(out, "\nNo compliance explains the residual at feeds to which it was not fitted.");
            return;
        }
        let _ =
            writeln!(out, "\ncompliance of   with                value                          gain at other feeds");
        for one in &self.found.compliances {
            let with = format!("{} of {}", one.of.words(), one.axis);
            let value = format!("{:.4} ± {:.4} {}", one.value, one.uncertainty, one.unit);
            let _ = writeln!(out, "{:<14}  {with:<18}  {value:<30} {:>5.1} %", one.component, 100.0 * one.gain);
        }
        let _ = writeln!(out, "\n   F, mm/min  dynamic part, RMS µm  residual with the compliances of other feeds");
        for run in &self.found.runs {
            if let Some([before, after]) = run.held_out_um.map(|both| both.map(significant)) {
                let _ = writeln!(out, "{}  {before:>20}  {after:>6}", feed_cell(run));
            }
        }
    }

    fn write_laws(&self, out: &mut String) {
        if self.found.power_laws.is_empty() {
            return;
        }
        let _ = writeln!(out, "\nRMS = κ Fᴺ         κ, µm         N    ± (95 %)     R²  N without the slowest run");
        for law in &self.found.power_laws {
            let limit = law.exponent_95.map_or("–".into(), |limit| format!("{limit:.2}"));
            let without = law.without_slowest.map_or("–".into(), |exponent| format!("{exponent:.2}"));
            let _ = writeln!(
                out,
                "{:<10} {}   {:>10.3e}  {:>8.2}  {limit:>10}  {:>5.3}  {without:>6}",
                law.source.words(),
                law.direction,
                law.factor_um,
                law.exponent,
                law.explained
            );
        }
    }
}

fn norm([x, y, z]: [f64; 3]) -> f64 {
    x.hypot(y).hypot(z)
}

fn feed_cell(run: &RunReport) -> String {
    let feed = run.feed_mm_min.map_or("–".into(), |feed| grouped(feed.round() as u64));
    format!("{feed:>12}")
}
