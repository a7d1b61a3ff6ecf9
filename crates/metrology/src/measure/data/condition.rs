//! The condition of the machine at every reading: temperatures, load and time in the columns of NAME.csv.
//!
//! The columns are those of a log ([`ncfix_machine::machine::condition::columns`]). With `t_s` the readings of a sensor form one trace, so that
//! lagging effects have a history. Time does not decrease, but a new run may restart it, which begins a new trace. Without `t_s` every row is a
//! steady state.
//!
//! Drift is relative to the first row of each set-up in each run, in which the instrument was zeroed.

use std::collections::HashMap;

use ncfix_base::csv::{DecimalSign, Row, Table};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_machine::machine::condition::ConditionLog;
use ncfix_machine::machine::condition::columns::{ConditionColumn, NO_LOAD, OfDead, check_load, read_cell};
use ncfix_machine::machine::condition::file::READABLE_C;
use ncfix_machine::machine::{Condition, Load};

/// Reads the conditions of one table, row by row.
#[derive(Debug)]
pub(super) struct Conditions {
    columns: Vec<ConditionColumn>,
    of_dead: OfDead,
    has_time: bool,
    has_temperatures: bool,
    load: Load,
    clocks: Vec<Clock>,
    /// The clock of each run.
    of_run: HashMap<usize, usize>,
    moments: Vec<Moment>,
    /// The zero of each set-up in each run: its first moment.
    zeros: HashMap<(usize, usize), usize>,
}

/// Readings on one time scale.
#[derive(Debug)]
struct Clock {
    /// By column.
    traces: Vec<ConditionLog>,
    last_s: f64,
    /// `true` while no temperature has changed.
    is_steady: bool,
}

/// One condition.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Moment {
    clock: usize,
    time_s: f64,
    load: Load,
    /// The moment of zero drift.
    zero: usize,
}

/// Prepares the reading of conditions, if a table has any besides the temperature of the instrument; reports incomplete ones.
pub(super) fn begin(
    table: &Table,
    own: Option<&str>,
    of_dead: OfDead,
    findings: &mut Vec<Diagnostic>,
) -> Option<Conditions> {
    let mut columns = ConditionColumn::all(table);
    // The temperature of the instrument is not one of the machine.
    if let Some(own) = own.and_then(|own| columns.get_mut(table.column(own)?)) {
        *own = ConditionColumn::Other;
    }
    check_load(table, &columns, findings);
    let has_temperatures = columns.iter().any(|column| matches!(column, ConditionColumn::Sensor(_)));
    if !has_temperatures && !columns.contains(&ConditionColumn::Force) {
        return None;
    }
    if let Some(force) = columns.iter().position(|column| *column == ConditionColumn::Force)
        && !columns.iter().any(|column| matches!(column, ConditionColumn::LoadPlace(_)))
    {
        let help =
            "add load_x_mm, load_y_mm, load_z_mm, any of them: mm from the center of the table, 0 for the center";
        let message = "the weight of a load is given, but not its position";
        findings.push(Diagnostic::at(Code::DATA_COLUMN, table.header_place(Some(force)), message, help));
    }
    Some(Conditions {
        has_time: columns.contains(&ConditionColumn::Time),
        columns,
        of_dead,
        has_temperatures,
        load: NO_LOAD,
        clocks: Vec::new(),
        of_run: HashMap::new(),
        moments: Vec::new(),
        zeros: HashMap::new(),
    })
}

impl Conditions {
    /// The index of the condition of a row.
    ///
    /// # Errors
    /// Diagnostics for cells that are not temperatures or loads, and for decreasing times.
    pub(super) fn read(
        &mut self,
        row: &Row<'_>,
        sign: DecimalSign,
        run: usize,
        setup: usize,
        t_s: Option<f64>,
    ) -> Result<usize, Vec<Diagnostic>> {
        let mut findings = Vec::new();
        let mut temperatures = vec![None; self.columns.len()];
        for (index, (column, found)) in self.columns.iter().zip(&mut temperatures).enumerate() {
            match read_cell(row, index, column, sign, &mut self.load, (self.of_dead, READABLE_C)) {
                Ok(value) if matches!(column, ConditionColumn::Sensor(_)) => {
                    *found = value;
                    if value.is_none() && !self.has_time && row.text(index).is_empty() {
                        let help = "write the temperature of this row, or add a column t_s: then it is interpolated from neighboring rows";
                        let message = "there is no temperature, and without t_s it cannot be interpolated";
                        findings.push(Diagnostic::at(Code::DATA_CELL, row.place(index), message, help));
                    }
                }
                Ok(_) => {}
                Err(finding) => findings.push(finding),
            }
        }
        if !self.load.is_plausible() {
            let place = self.columns.iter().position(|column| *column == ConditionColumn::Force);
            let help = "give newtons and mm from the center of the table: at most 10000000 N, at most 100000 mm away";
            let message = "no machine tool carries this load";
            findings.push(Diagnostic::at(Code::DATA_CELL, row.place(place.unwrap_or(0)), message, help));
        }
        if self.has_time && self.has_temperatures && t_s.is_none() {
            let column = self.columns.iter().position(|column| *column == ConditionColumn::Time);
            let help = "write the time of the row in s, or remove the column if temperatures did not change";
            let message = "there is a temperature but no time";
            findings.push(Diagnostic::at(Code::DATA_CELL, row.place(column.unwrap_or(0)), message, help));
        }
        if !findings.is_empty() {
            return Err(findings);
        }
        // Without temperatures there is no dependence on time.
        let time_s = t_s.filter(|_| self.has_temperatures).unwrap_or(0.0);
        let clock = self.clock(run, time_s).map_err(|message| {
            let column = self.columns.iter().position(|column| *column == ConditionColumn::Time);
            let help = "sort the rows of each run by time; a column run separates runs in which the time starts again";
            vec![Diagnostic::at(Code::DATA_CELL, row.place(column.unwrap_or(0)), message, help)]
        })?;
        self.note(clock, time_s, &temperatures);
        Ok(self.moment(clock, time_s, run, setup))
    }

    /// The clock of a row. Without times each row has its own, except for equal rows.
    fn clock(&mut self, run: usize, time_s: f64) -> Result<usize, String> {
        if !self.has_time || !self.has_temperatures {
            return Ok(self.clocks.len());
        }
        let latest = self.clocks.len().checked_sub(1);
        let goes_on = |clock: usize| self.clocks.get(clock).is_some_and(|clock| time_s >= clock.last_s);
        let clock = match (self.of_run.get(&run).copied(), latest) {
            (Some(own), _) if !goes_on(own) => {
                let last_s = self.clocks.get(own).map_or(0.0, |clock| clock.last_s);
                return Err(format!("the time decreases from {last_s} s to {time_s} s"));
            }
            (Some(own), _) => own,
            (None, Some(latest)) if goes_on(latest) => latest,
            (None, _) => self.clocks.len(),
        };
        self.of_run.insert(run, clock);
        Ok(clock)
    }

    /// Adds temperatures to a clock; a new clock begins.
    fn note(&mut self, clock: usize, time_s: f64, temperatures: &[Option<f64>]) {
        if clock == self.clocks.len() {
            let traces = vec![ConditionLog::default(); self.columns.len()];
            let alone = Clock { traces, last_s: time_s, is_steady: true };
            self.clocks.push(alone);
        }
        let Some(own) = self.clocks.get_mut(clock) else { return };
        own.last_s = time_s;
        for (trace, value) in own.traces.iter_mut().zip(temperatures) {
            let Some(value) = *value else { continue };
            own.is_steady &= trace.points().last().is_none_or(|&(_, last)| last == value);
            trace.add(time_s, value);
        }
    }

    /// The index of the condition of a row; the last one if nothing has changed.
    fn moment(&mut self, clock: usize, time_s: f64, run: usize, setup: usize) -> usize {
        let next = self.moments.len();
        let zero = self.zeros.get(&(run, setup)).copied();
        if let Some(last) = next.checked_sub(1)
            && let Some(known) = self.moments.get(last).copied()
            && known.load == self.load
        {
            let is_same_zero = zero == Some(known.zero) || zero.is_none() && known.zero == last;
            let is_same = if known.clock == clock {
                known.time_s == time_s || self.clocks.get(clock).is_some_and(|clock| clock.is_steady)
            } else {
                !self.has_time && self.are_alike(known.clock, clock) || !self.has_temperatures
            };
            if is_same && (is_same_zero || !self.has_temperatures) {
                if known.clock != clock && clock + 1 == self.clocks.len() {
                    self.clocks.pop();
                }
                self.zeros.entry((run, setup)).or_insert(last);
                return last;
            }
        }
        let zero = *self.zeros.entry((run, setup)).or_insert(next);
        self.moments.push(Moment { clock, time_s, load: self.load, zero });
        next
    }

    fn are_alike(&self, one: usize, other: usize) -> bool {
        self.clocks.get(one).zip(self.clocks.get(other)).is_some_and(|(one, other)| one.traces == other.traces)
    }

    /// All conditions, by index.
    pub(super) fn finish(self) -> Vec<Condition> {
        let clocks: Vec<Condition> = self
            .clocks
            .into_iter()
            .map(|clock| {
                let mut condition = Condition::default();
                for (column, trace) in self.columns.iter().zip(clock.traces) {
                    if let ConditionColumn::Sensor(sensor) = column
                        && !trace.points().is_empty()
                    {
                        condition.set_trace(sensor, trace);
                    }
                }
                condition
            })
            .collect();
        let at = |moment: &Moment| {
            let mut condition = clocks.get(moment.clock).cloned().unwrap_or_default();
            condition.set_time(moment.time_s);
            condition
        };
        let all = self.moments.iter().map(|moment| {
            let mut condition = at(moment);
            if moment.load.force_n > 0.0 {
                condition.add_load(moment.load);
            }
            if self.has_temperatures
                && let Some(zero) = self.moments.get(moment.zero)
            {
                condition.set_zero(at(zero));
            }
            condition
        });
        all.collect()
    }
}
