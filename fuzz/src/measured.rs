//! Tables, measurements and traces.

use std::collections::BTreeMap;

use ncfix_base::csv::{DecimalSign, Table};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::StrainGauge;
use ncfix_metrology::measure::{data, reading::Readings, strain, trace};

use super::programs::machine_of;
use super::{check_findings, halves, source};

/// A table: copied byte by byte; a copy in which every cell is replaced by a number has these numbers.
pub fn table(bytes: &[u8]) {
    let file = source("table.csv", bytes);
    let (table, findings) = Table::read(&file);
    check_findings(&findings, &[&file]);
    assert_eq!(table.is_none(), findings.iter().any(Diagnostic::is_error), "{findings:?}");
    let Some(table) = table else { return };
    let mut copy = Vec::new();
    table.copy(&mut copy).finish().expect("memory takes all");
    assert_eq!(copy, bytes);
    // Where a header has quotation marks within cells the rows below it may decide what separates them.
    if !table.names().iter().any(|name| name.contains('"')) {
        replace(&table);
    }
    read_as_all(&table);
}

/// Replaces the cells of the first column that have a text by 1, 2, 3 and reads them.
fn replace(table: &Table) {
    let mut out = Vec::new();
    let mut copy = table.copy(&mut out);
    let mut wanted = Vec::new();
    for (number, row) in table.rows().enumerate() {
        assert!(table.line_of(row.place(0)) >= 1);
        if row.text(0).is_empty() {
            wanted.push(None);
        } else {
            copy.replace(row.place(0), &number.to_string()).expect("memory takes all");
            wanted.push(Some(number as f64));
        }
    }
    copy.finish().expect("memory takes all");
    let again = source("again.csv", &out);
    let (read, findings) = Table::read(&again);
    let read = read.unwrap_or_else(|| panic!("{findings:?}\n{}", String::from_utf8_lossy(&out)));
    assert_eq!(read.names(), table.names());
    assert_eq!(read.row_count(), wanted.len());
    for (row, wanted) in read.rows().zip(wanted) {
        assert_eq!(row.number(0, DecimalSign::Point).ok(), wanted);
    }
}

/// The same table as readings of axes and of a strain gauge.
fn read_as_all(table: &Table) {
    let machine = &machine_of("sinumerik").0;
    if let Ok(mut readings) = Readings::new(table, machine) {
        for row in table.rows() {
            if let Ok(reading) = readings.read(&row) {
                assert!(reading.tool_mm.iter().all(|one| one.is_finite()), "{reading:?}");
            }
        }
    }
    let gauge: Option<&StrainGauge> = machine_of("sinumerik").0.strain.as_ref();
    if let Some(gauge) = gauge {
        let _ = strain::read(table, gauge);
    }
}

/// A second file.
fn second(bytes: &[u8]) -> Source {
    Source::new(FileId(1), "second", bytes.to_vec()).expect("a fuzzer gives less than 4 GiB")
}

/// A measurement: its description and its table.
pub fn pair(bytes: &[u8]) {
    let (description, table) = halves(bytes);
    let (description, table) = (source("data.toml", description), second(table));
    let machine = &machine_of("sinumerik").0;
    for read in [data::load, data::load_with_dead, data::load_plan] {
        let (set, findings) = read("data", &table, &description, machine);
        check_findings(&findings, &[&description, &table]);
        assert_eq!(set.is_none(), findings.iter().any(Diagnostic::is_error), "{findings:?}");
        for row in set.iter().flat_map(|set| &set.observations) {
            assert!(row.values.iter().flatten().all(|value| value.is_finite()), "{row:?}");
        }
    }
}

/// A trace: its description and its table, or what a Sinumerik has recorded.
pub fn trace(bytes: &[u8]) {
    let (description, table) = halves(bytes);
    let (description, table) = (source("trace.toml", description), second(table));
    let machine = &machine_of("sinumerik").0;
    let names = ["X", "Y", "Z"].into_iter().enumerate().flat_map(|(number, axis)| {
        let number = number + 1;
        let set = (axis.to_owned(), format!("/Nck/MachineAxis/cmdPos[{number}]"));
        [set, (format!("{axis}_enc"), format!("/Nck/MachineAxis/encPos[{number}]"))]
    });
    let mut names: BTreeMap<String, String> = names.collect();
    let described = trace::describe("trace", &description);
    if let Some((described, findings)) = &described {
        check_findings(findings, &[&description]);
        names.extend(described.iter().flat_map(|one| one.signals.clone()));
    }
    let signals = trace::xml::read(&table, &names, machine);
    match &signals {
        Err(findings) => check_findings(findings, &[&table]),
        Ok(signals) => check_control(&signals.control),
    }
    if let Some((Some(described), _)) = described {
        for control in [None, signals.as_ref().ok()] {
            let (trace, findings) = trace::read(&described, &table, control, machine);
            check_findings(&findings, &[&table]);
            for run in trace.iter().flat_map(|trace| &trace.runs) {
                check_control(&run.control);
                assert!(run.readings.along.iter().flatten().all(|value| value.is_finite()));
            }
        }
    }
}

/// Times rise, and each has a set-point and an encoder.
fn check_control(control: &trace::ControlSamples) {
    assert!(control.t_s.windows(2).all(|pair| pair[0] < pair[1]));
    assert_eq!((control.set.len(), control.encoder.len()), (control.t_s.len(), control.t_s.len()));
}
