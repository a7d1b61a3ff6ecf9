//! The longest lines that temperatures can make. While a job runs, its lines get words of axes that they do not name, and more digits. A line that becomes too
//! long for the control would stop the job in the cut. So the survey makes all lines a second time, with temperatures that change with every piece.

use std::sync::Arc;

use super::job::Transfer;
use crate::error::Error;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::Axis;
use ncfix_dnc::drip::{Lines, Settings};
use ncfix_dnc::feed::DosingLimits;
use ncfix_model::Model;
use ncfix_path::path::{Increments, Output};

/// Temperatures of all sensors, °C, in turn. Their difference moves an axis by at least an increment, unless the effect of the sensor is negligible.
const IN_TURN_C: [f64; 2] = [37.3, 6.1];
/// Time between these readings, s: longer than any lag.
const LATER_S: f64 = 1e7;
/// Largest number of lines that are reported.
const MOST: usize = 20;
/// Positions below this may become negative, mm or inch: shifts are smaller.
const NEAR_ZERO: f64 = 0.25;

/// Makes the lines of a job for temperatures that change with every piece.
pub(super) struct LiveLines<'a> {
    job: &'a Transfer,
    lines: Lines<'a>,
    models: [Arc<Model>; 2],
    taken: usize,
    /// Decimals of a position.
    decimals: usize,
    /// The lines that can become too long.
    pub(super) refused: Vec<Diagnostic>,
}

impl<'a> LiveLines<'a> {
    /// Begins at the first line; `None` if the model has no sensors.
    ///
    /// # Errors
    /// If the program cannot be written.
    pub(super) fn new(job: &'a Transfer, base: &'a Model) -> Result<Option<LiveLines<'a>>, Error> {
        let machine = &job.machine;
        let sensors = machine.errors.sensors();
        if sensors.is_empty() {
            return Ok(None);
        }
        let mut condition = machine.condition.clone();
        let mut time_s = condition.time_s();
        let models = IN_TURN_C.map(|temperature_c| {
            time_s += LATER_S;
            for sensor in &sensors {
                condition.add_reading(sensor, time_s, temperature_c);
            }
            time_s += LATER_S;
            condition.set_time(time_s);
            Arc::new(machine.model_now(&condition, base))
        });
        let unlimited = DosingLimits { per_block: f64::INFINITY, per_mm: f64::INFINITY, per_s: f64::INFINITY };
        let settings = Settings { limits: unlimited, ..job.settings };
        let lines = Lines::new(&machine.machine, base, &job.writing.options, job.writing.writer()?, settings)
            .rewritten(job.link.profile.protocol.rewrite.map(|create| create()))
            .stating(&job.stated);
        let decimals = decimals(Increments::new(&machine.machine.control).linear_mm);
        Ok(Some(LiveLines { job, lines, models, taken: 0, decimals, refused: Vec::new() }))
    }

    /// Takes the next element.
    pub(super) fn take(&mut self, output: &Output) {
        let model = &self.models[self.taken % self.models.len()];
        self.taken += usize::from(matches!(output, Output::Piece(_)));
        // A line that cannot be made is reported by the survey itself.
        if self.lines.take(output.clone(), Some(model), false).is_ok() {
            self.check();
        }
    }

    /// Takes the end of the program.
    pub(super) fn finish(&mut self) {
        if self.lines.finish().is_ok() {
            self.check();
        }
    }

    fn check(&mut self) {
        let longest = self.job.link.profile.longest_line;
        while let Some(line) = self.lines.pop() {
            let text = String::from_utf8_lossy(&line.text);
            let moved = [Axis::X, Axis::Y, Axis::Z].map(|axis| line.offset[axis.slot()] != 0.0);
            let length = longest_of(&text, moved, self.decimals);
            if length <= longest || self.refused.len() >= MOST {
                continue;
            }
            let message = format!(
                "line {} of the original can become '{text}' while the temperatures change: up to {length} characters, and the control accepts {longest}; it would stop in the middle of the job",
                line.source_line
            );
            let help = "write the words of that block in two blocks, remove its block number, choose a larger --increment, or feed without --sensors";
            self.refused.push(Diagnostic::nowhere(Code::NOT_FOR_LINK, message, help));
        }
    }
}

/// The largest length of a line whose positions along some axes change a little: with all decimals, and with a sign where a position is near zero.
fn longest_of(text: &str, [x, y, z]: [bool; 3], decimals: usize) -> usize {
    let moves = |letter: char| [('X', x), ('Y', y), ('Z', z)].contains(&(letter, true));
    let more = text.split_ascii_whitespace().map(|word| {
        let value = word.strip_prefix(moves).map_or("", |value| value.strip_prefix('=').unwrap_or(value));
        let Ok(number) = value.parse::<f64>() else { return 0 };
        let missing = match value.split_once('.') {
            Some((_, digits)) => decimals.saturating_sub(digits.len()),
            None => 1 + decimals,
        };
        missing + usize::from((0.0..NEAR_ZERO).contains(&number))
    });
    text.len() + more.sum::<usize>()
}

/// Decimals that a multiple of an increment can have.
fn decimals(increment: f64) -> usize {
    let is_whole = |places: &usize| {
        let counted = increment * 10_f64.powi(*places as i32);
        (counted - counted.round()).abs() < 1e-6 && counted > 0.5
    };
    (0..9).find(is_whole).unwrap_or(9)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_form_of_a_line_has_all_decimals_and_a_sign() {
        // X5 → X5.001, Y0.1 → Y-0.101, Z-3.0370 stays.
        assert_eq!(longest_of("G1 X5 Y0.1 Z-3.037 F1200", [true; 3], 3), "G1 X5.001 Y-0.101 Z-3.037 F1200".len());
        assert_eq!(longest_of("X=IC(5) Z=7.", [true; 3], 4), "X=IC(5) Z=7.0001".len());
        // Only Z drifts.
        assert_eq!(longest_of("G1 X5 Y0.1 Z3", [false, false, true], 3), "G1 X5 Y0.1 Z3.001".len());
        assert_eq!([1.0, 0.001, 0.0005, 0.0001, 0.01].map(decimals), [0, 3, 4, 4, 2]);
    }
}
