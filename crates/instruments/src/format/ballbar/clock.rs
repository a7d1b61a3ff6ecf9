//! Angles of a circle whose readings have times: start angle plus feed over radius times the time since the first reading of the run.

use std::collections::BTreeMap;

use crate::grid::{GridLine, GridTable};
use crate::inquiry::{ImportStop, Inquiry};
use crate::readings::shown;

/// Least and largest angle of the readings of a run, degrees: less is no circle, more is three turns.
const SWEEP_DEG: std::ops::RangeInclusive<f64> = 20.0..=1085.0;
/// Angle by which the end of the readings may miss the stated end of the circle, degrees.
const END_DEG: f64 = 5.0;

/// Angle as a function of time.
pub(super) struct CircleClock {
    time: usize,
    seconds: f64,
    /// Angle at the first reading of circles in the positive and in the negative direction.
    starts_deg: [f64; 2],
    deg_per_s: f64,
    /// First time of each run, in the unit of the file, and the last angle of it with its line.
    runs: BTreeMap<usize, (f64, f64, usize)>,
}

impl CircleClock {
    /// Asks for what the angles need. `turns` are the directions that the file or an option states.
    pub(super) fn ask(
        inquiry: &mut Inquiry<'_>,
        table: &GridTable,
        (time, turns): (usize, Vec<f64>),
        (feed, radius_mm): (Option<f64>, f64),
        bounds_deg: Option<[f64; 2]>,
    ) -> Result<CircleClock, ImportStop> {
        let line = table.heading_line;
        let heading = table.headings.get(time).map_or("", |heading| heading.written.as_str()).to_lowercase();
        if heading.contains("min") {
            let help = "export the time in seconds or milliseconds";
            return Err(inquiry.refused("the time of the readings is in minutes", help, line));
        }
        let seconds = if heading.contains("ms") { 1e-3 } else { 1.0 };
        if feed.is_none() {
            inquiry.ask(
                "feed",
                "the readings have times, and the file does not state the feed of the circle",
                "mm/min, such as 1000",
            );
        }
        let said = inquiry.answer("start-angle", |own| own.start_deg);
        if said.is_none() {
            let sentence = "the readings have times, and the file does not state the angle at the first reading";
            inquiry.ask("start-angle", sentence, "degrees, with the overshoot, such as -180");
        }
        if turns.is_empty() {
            let sentence = "the readings have times, and the file does not state the direction of the circles";
            inquiry.ask("turn", sentence, "ccw or cw");
        }
        let start_deg = said.unwrap_or(0.0);
        let has = |wanted: f64| turns.contains(&wanted);
        let mut starts_deg = [start_deg; 2];
        if let (Some([from, to]), true, true) = (bounds_deg, has(1.0), has(-1.0)) {
            // The overshoot is the same at both ends, so the circle back begins as far beyond the end as the other one before the start.
            starts_deg[1] = from + to - start_deg;
            inquiry.note(format!("the first reading of clockwise circles is at {}°", shown(starts_deg[1])), 0);
        }
        let deg_per_s = (feed.unwrap_or(1000.0) / 60.0 / radius_mm).to_degrees();
        inquiry.note(
            format!(
                "angles: {} degrees per {} of the column '{}', from the first reading of each run; acceleration at the ends shifts them",
                shown(deg_per_s * seconds),
                if seconds < 1.0 { "ms" } else { "s" },
                table.headings.get(time).map_or("", |heading| heading.written.as_str())
            ),
            line,
        );
        Ok(CircleClock { time, seconds, starts_deg, deg_per_s, runs: BTreeMap::new() })
    }

    /// The angle of a row of a run with a direction, degrees.
    pub(super) fn deg(
        &mut self,
        inquiry: &Inquiry<'_>,
        table: &GridTable,
        row: &GridLine,
        run: usize,
        turn: f64,
    ) -> Result<f64, ImportStop> {
        let at = table.needed(row, self.time)?;
        let (first, _, _) = *self.runs.entry(run).or_insert((at, 0.0, row.number));
        let swept = (at - first) * self.seconds * self.deg_per_s;
        if swept < 0.0 {
            return Err(inquiry.refused(
                "the time of the readings goes back",
                "give each run a number of its own",
                row.number,
            ));
        }
        self.runs.insert(run, (first, swept, row.number));
        Ok(self.starts_deg[usize::from(turn < 0.0)] + turn * swept)
    }

    /// Checks that feed and radius fit the times. `end_deg` is the stated end of the circle.
    pub(super) fn check(&self, inquiry: &Inquiry<'_>, end_deg: Option<f64>) -> Result<(), ImportStop> {
        if !inquiry.questions().is_empty() {
            return Ok(());
        }
        for (_, swept, line) in self.runs.values() {
            let help = "check --feed, --radius and the unit of the time";
            if !SWEEP_DEG.contains(swept) {
                return Err(inquiry.refused(format!("the readings of a run sweep {}°", shown(*swept)), help, *line));
            }
            let is_short = end_deg.is_some_and(|end| swept + END_DEG < (end - self.starts_deg[0]).abs());
            if is_short {
                let message =
                    format!("the readings end at {}°, before the end of the circle", shown(self.starts_deg[0] + swept));
                return Err(inquiry.refused(message, help, *line));
            }
        }
        Ok(())
    }
}
