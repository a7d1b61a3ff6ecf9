//! Weighs a workpiece: its weight and position from the change of a strain along an axis (Spaan 1995, ch. 4).
//!
//! The strain is linear in the weight F and its moments F pₓ, F p_z ([`StrainGauge`]), with an offset for every run and, if times are known, a linear
//! drift: least squares (`fit`). A lubrication pulse that disturbs single readings is detected by its effect on the sum of squares (`outlier`). This
//! needs more readings than unknowns: every position twice for detection, three times for location. The uncertainties are those of the readings
//! (`sigma_um_per_m`, unless the residuals contradict it, otherwise from the residuals); that of p = (F p)/F follows from both and their covariance.

pub mod at_rest;
mod fit;
mod outlier;

use std::fmt::Write as _;

use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::Vector;
use ncfix_machine::machine::condition::file::load_text;
use ncfix_machine::machine::{Load, StrainGauge};

use super::strain::StrainReading;
use fit::{WeighingEquation, WeighingFit};
use outlier::OutlierVerdict;

/// Minimum share of a signal that differs from all others: gauges are not known better than to one percent.
const LEAST_UNLIKE: f64 = 0.01;

/// If more than one in this number of readings is disturbed under a known noise, the noise is wrong.
const MOST_LEFT_OUT: usize = 10;

/// Minimum weight in standard uncertainties.
const LEAST_SIGMAS: f64 = 3.0;

/// A value and its standard uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// The value.
    pub value: f64,
    /// One standard uncertainty.
    pub sigma: f64,
}

/// A coordinate of a load, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coordinate {
    /// From the readings.
    Measured(Measured),
    /// As stated.
    Known(f64),
    /// Assumed to be 0, because it is not identifiable from the readings.
    Assumed,
}

/// Result of a weighing.
#[derive(Clone, Debug, PartialEq)]
pub struct Weighing {
    /// The weight, N.
    pub force_n: Measured,
    /// Its position relative to the center of the table along the axes of F.
    pub position_mm: [Coordinate; 3],
    /// Standard uncertainty of a reading, µm/m.
    pub noise_um_m: f64,
    /// Degrees of freedom: used readings minus unknowns.
    pub freedom: usize,
    /// Number of used readings.
    pub used: usize,
    /// Disturbed readings that are left out.
    pub left_out: Vec<Place>,
}

impl Coordinate {
    /// The value, mm.
    #[must_use]
    pub fn value(&self) -> f64 {
        match *self {
            Coordinate::Measured(measured) => measured.value,
            Coordinate::Known(value) => value,
            Coordinate::Assumed => 0.0,
        }
    }
}

impl Weighing {
    /// The load as part of a machine condition.
    #[must_use]
    pub fn load(&self) -> Load {
        let [x, y, z] = self.position_mm.map(|coordinate| coordinate.value());
        Load { force_n: self.force_n.value.max(0.0), position_mm: Vector::new(x, y, z) }
    }

    /// The text of a state file with the load, weighed from `data` on a machine.
    #[must_use]
    pub fn state_text(&self, data: &str, machine: &str) -> String {
        // A name may contain any character; a comment ends with its line.
        let name = |text: &str| text.replace(char::is_control, " ");
        let mut text = format!("# Weighed on {} from {}.\n", name(machine), name(data));
        let sigma = |coordinate: &Coordinate| match coordinate {
            Coordinate::Measured(measured) => format!("{:.1}", measured.sigma),
            Coordinate::Known(_) => "known".to_owned(),
            Coordinate::Assumed => "assumed".to_owned(),
        };
        let [x, y, z] = [0, 1, 2].map(|i| sigma(&self.position_mm[i]));
        // Writing into a String cannot fail.
        let _ = writeln!(text, "# Standard uncertainties: {:.1} N; X {x}, Y {y}, Z {z} (mm).", self.force_n.sigma);
        text + &load_text(&self.load())
    }
}

/// Weighs. `known` are coordinates of the position that are not to be measured, mm. Without a weighing there is a diagnostic that is an error.
#[must_use]
pub fn weigh(
    readings: &[StrainReading],
    gauge: &StrainGauge,
    known: [Option<f64>; 3],
) -> (Option<Weighing>, Vec<Diagnostic>) {
    let mut findings = Vec::new();
    let weighing = match Weigher::new(readings, gauge, known).weigh(&mut findings) {
        Ok(weighing) => Some(weighing),
        Err(finding) => {
            // The assumption is then irrelevant.
            findings = vec![finding];
            None
        }
    };
    (weighing, findings)
}

/// A weighing in progress.
struct Weigher<'a> {
    readings: &'a [StrainReading],
    lines: Vec<WeighingEquation>,
    sigma_um_m: Option<f64>,
    /// Unknown coordinates in the order of the columns after that of the weight.
    moments: Vec<usize>,
    position_mm: [Coordinate; 3],
}

impl<'a> Weigher<'a> {
    fn new(readings: &'a [StrainReading], gauge: &'a StrainGauge, known: [Option<f64>; 3]) -> Weigher<'a> {
        let position_mm = known.map(|value| value.map_or(Coordinate::Assumed, Coordinate::Known));
        let moments: Vec<usize> =
            (0..3).filter(|&i| known[i].is_none() && gauge.moments[i].is_some()).take(fit::UNKNOWNS - 1).collect();
        let line = |reading: &StrainReading| {
            let signal = |values: &[f64]| gauge.signal(values, reading.position).unwrap_or_default();
            let moment = |i: usize| gauge.moments[i].as_deref().map_or(0.0, signal);
            let mut columns = [0.0; fit::UNKNOWNS];
            // A load at a known position also acts through the moment of that position.
            columns[0] = signal(&gauge.force) + (0..3).map(|i| known[i].unwrap_or_default() * moment(i)).sum::<f64>();
            for (column, &i) in columns[1..].iter_mut().zip(&moments) {
                *column = moment(i);
            }
            WeighingEquation {
                columns,
                value: reading.strain_um_m - gauge.empty.as_deref().map_or(0.0, signal),
                run: reading.run,
                time_s: reading.time_s,
                is_used: true,
            }
        };
        let lines = readings.iter().map(line).collect();
        Weigher { readings, lines, sigma_um_m: gauge.sigma_um_m, moments, position_mm }
    }

    fn weigh(mut self, findings: &mut Vec<Diagnostic>) -> Result<Weighing, Diagnostic> {
        for &i in &self.moments {
            self.position_mm[i] = Coordinate::Measured(Measured { value: 0.0, sigma: f64::INFINITY });
        }
        self.demand_separation(findings)?;
        let left_out = self.leave_out()?;
        for &place in &left_out {
            let message = "this reading is excluded: it contradicts the others, as after a lubrication pulse";
            findings.push(Diagnostic::at(
                Code::READING_LEFT_OUT,
                place,
                message,
                "repeat the run if there are several",
            ));
        }
        let fit = WeighingFit::new(&self.lines, self.moments.len() + 1)
            .ok_or_else(|| self.refusal(NOT_TOLD, NOT_TOLD_HELP))?;
        if fit.freedom == 0 && self.sigma_um_m.is_none() {
            return Err(self.refusal(
                "there are as many unknowns as readings, so the uncertainty of the load is not known",
                "measure every position twice, or give sigma_um_per_m in [strain]",
            ));
        }
        if fit.freedom < 2 {
            let message = "a reading disturbed by a lubrication pulse cannot be detected: there are too few readings";
            findings.push(self.warning(message.to_owned(), "measure every position at least twice"));
        }
        let noise_um_m = self.noise(&fit, findings);
        let weighing = self.result(&fit, noise_um_m, left_out, findings);
        if weighing.force_n.value < -LEAST_SIGMAS * weighing.force_n.sigma {
            let message = format!("the weight is negative: {:.0} N", weighing.force_n.value);
            let help = "check the signs in [strain] and of the readings, and the empty table (empty_um_per_m)";
            return Err(self.refusal(&message, help));
        }
        Ok(weighing)
    }

    /// Leaves out disturbed readings and returns their places.
    fn leave_out(&mut self) -> Result<Vec<Place>, Diagnostic> {
        let count = self.moments.len() + 1;
        let mut verdict = outlier::leave_out(&mut self.lines, count, self.sigma_um_m);
        let is_rule = |verdict: &OutlierVerdict| match verdict {
            OutlierVerdict::LeftOut(indices) => indices.len() > (self.readings.len() / MOST_LEFT_OUT).max(2),
            OutlierVerdict::Rivals(_) => true,
        };
        if self.sigma_um_m.is_some() && is_rule(&verdict) {
            // That many disturbed readings mean that the noise is larger than stated.
            self.lines.iter_mut().for_each(|line| line.is_used = true);
            verdict = outlier::leave_out(&mut self.lines, count, None);
        }
        let place = |index: usize| self.readings.get(index).map(|reading| reading.place);
        match verdict {
            OutlierVerdict::LeftOut(indices) => Ok(indices.into_iter().filter_map(place).collect()),
            OutlierVerdict::Rivals(indices) => {
                let place = indices.iter().find_map(|&index| place(index));
                let message = format!(
                    "{} readings contradict each other, this one and others at or near its position; one or two are disturbed, as after a lubrication pulse, but it is not known which",
                    indices.len()
                );
                let help = "measure all positions again as a further run; three readings of a position show which one is disturbed";
                Err(match place {
                    Some(place) => Diagnostic::at(Code::LOAD_NOT_TOLD, place, message, help),
                    None => self.refusal(&message, help),
                })
            }
        }
    }

    /// Drops moments whose signals cannot be separated from the others.
    fn demand_separation(&mut self, findings: &mut Vec<Diagnostic>) -> Result<(), Diagnostic> {
        loop {
            let count = self.moments.len() + 1;
            let shares: Vec<f64> = (0..count).map(|column| fit::unlike_share(&self.lines, count, column)).collect();
            if shares.iter().all(|&share| share >= LEAST_UNLIKE) {
                return Ok(());
            }
            // The weight has priority; of the moments the least identifiable is dropped.
            let least = (1..count).min_by(|&one, &other| f64::total_cmp(&shares[one], &shares[other]));
            let Some(column) = least else { return Err(self.refusal(NOT_TOLD, NOT_TOLD_HELP)) };
            let i = self.moments.remove(column - 1);
            self.position_mm[i] = Coordinate::Assumed;
            let letter = ['X', 'Y', 'Z'][i];
            let likeness = fit::likeness(&self.lines, column);
            let message = format!(
                "the readings do not determine the position of the load along {letter}; {letter} 0 is assumed, and the weight changes by {:.0} % for each 100 mm of deviation",
                likeness * 1e4
            );
            let help = format!(
                "state the coordinate in mm if you know it, for example --known {letter}25; runs with more positions, or in both directions with t_s, may determine it"
            );
            findings.push(self.warning(message, &help));
            for line in &mut self.lines {
                line.columns[column..].rotate_left(1);
                line.columns[fit::UNKNOWNS - 1] = 0.0;
            }
        }
    }

    /// Standard uncertainty of a reading.
    fn noise(&self, fit: &WeighingFit, findings: &mut Vec<Diagnostic>) -> f64 {
        let found = (fit.squares / fit.freedom.max(1) as f64).sqrt();
        let Some(sigma) = self.sigma_um_m else { return found };
        if fit.freedom == 0 || (found / sigma).powi(2) <= outlier::highest_ratio(fit.freedom) {
            return sigma;
        }
        let message = format!("the readings scatter by {found:.3} µm/m, more than sigma_um_per_m = {sigma} allows");
        findings.push(self.warning(message, "the scatter is used; check [strain] and how the strain was measured"));
        found
    }

    fn result(
        &self,
        fit: &WeighingFit,
        noise_um_m: f64,
        left_out: Vec<Place>,
        findings: &mut Vec<Diagnostic>,
    ) -> Weighing {
        let covariance = fit.cofactors * (noise_um_m * noise_um_m);
        let force = Measured { value: fit.unknowns[0], sigma: covariance[(0, 0)].sqrt() };
        let mut position_mm = self.position_mm;
        let is_seen = force.value > LEAST_SIGMAS * force.sigma;
        if !is_seen {
            let message = format!(
                "the load is not significant: {:.0} N with a standard uncertainty of {:.0} N",
                force.value, force.sigma
            );
            findings.push(self.warning(message, "the position is assumed to be the center of the table"));
        }
        for (column, &i) in self.moments.iter().enumerate().map(|(index, i)| (index + 1, i)) {
            position_mm[i] = Coordinate::Assumed;
            if is_seen {
                // p = M/F, so dp = (dM − p dF)/F.
                let value = fit.unknowns[column] / force.value;
                let variance = covariance[(column, column)] - 2.0 * value * covariance[(0, column)]
                    + value * value * covariance[(0, 0)];
                let sigma = variance.max(0.0).sqrt() / force.value;
                position_mm[i] = Coordinate::Measured(Measured { value, sigma });
            }
        }
        let used = self.lines.iter().filter(|line| line.is_used).count();
        Weighing { force_n: force, position_mm, noise_um_m, freedom: fit.freedom, used, left_out }
    }

    fn refusal(&self, message: &str, help: &str) -> Diagnostic {
        self.finding(Code::LOAD_NOT_TOLD, message, help)
    }

    fn warning(&self, message: String, help: &str) -> Diagnostic {
        self.finding(Code::LOAD_ASSUMED, &message, help)
    }

    fn finding(&self, code: Code, message: &str, help: &str) -> Diagnostic {
        match self.readings.first() {
            Some(reading) => Diagnostic::at(code, reading.place, message, help),
            None => Diagnostic::nowhere(code, message, help),
        }
    }
}

const NOT_TOLD: &str = "the strain of these readings does not determine the weight: it changes along the axis only as its offset and drift do";
const NOT_TOLD_HELP: &str =
    "measure at all positions of [strain] in every run; with a column t_s measure in both directions, or remove it";

/// The place of a workpiece as a person writes it, `X0,Z-280`: coordinates in mm, `None` for those that are not given.
///
/// # Errors
/// A coordinate is wrong or given twice. The error is a sentence.
pub fn known_place(text: &str) -> Result<[Option<f64>; 3], String> {
    let mut place = [None; 3];
    for part in text.split(',').map(str::trim) {
        let wrong = || format!("'{part}' is not a coordinate; write for example X0,Z-280");
        let letter = part.bytes().next().ok_or_else(wrong)?.to_ascii_uppercase();
        let index = b"XYZ".iter().position(|&known| known == letter).ok_or_else(wrong)?;
        let number: f64 = part.get(1..).and_then(|number| number.trim().parse().ok()).ok_or_else(wrong)?;
        if !number.is_finite() || place[index].is_some() {
            return Err(wrong());
        }
        place[index] = Some(number);
    }
    Ok(place)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_names_some_coordinates() {
        assert_eq!(known_place("Z-280, x1.5"), Ok([Some(1.5), None, Some(-280.0)]));
        for wrong in ["", "A1", "X", "Xnan", "X1,X2", "X1,", "é"] {
            assert!(known_place(wrong).is_err(), "{wrong}");
        }
    }
}
