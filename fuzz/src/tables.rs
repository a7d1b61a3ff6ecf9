//! Compensation tables: what was read without an error, rounded and written, is read as the same and written as the same.

use ncfix_base::diagnostic::Diagnostic;
use ncfix_tables::tables::{FORMATS, Format, Tables, Wiring, Written};

use super::source;

/// Findings that a reader keeps at most.
const MOST_FINDINGS: usize = 100;
/// No file of a fuzzer asks for more values.
const MOST_ENTRIES: usize = 4_000_000;

/// Every format reads it.
pub fn read_and_written(bytes: &[u8]) {
    let file = source("tables.ini", bytes);
    let wiring = Wiring::usual();
    for format in FORMATS {
        let mut tables = Tables::default();
        let findings = (format.read)(&file, &wiring, &mut tables);
        assert!(findings.len() <= MOST_FINDINGS, "{}: {}", format.name, findings.len());
        super::check_findings(&findings, &[&file]);
        let _ = (format.numbers)(&file);
        if findings.iter().any(Diagnostic::is_error) {
            continue;
        }
        assert!(tables.entries() <= MOST_ENTRIES, "{}: {}", format.name, tables.entries());
        (format.round)(&mut tables);
        if !tables.is_empty() && format.faults_of(&tables, &wiring).is_empty() {
            check(format, &tables, &wiring);
        }
    }
}

fn check(format: &Format, tables: &Tables, wiring: &Wiring) {
    let files = (format.write)(tables, wiring, &[]);
    let mut again = Tables::default();
    for Written { suffix, text } in &files {
        let file = source(&format!("mill{suffix}"), text.as_bytes());
        let findings = (format.read)(&file, wiring, &mut again);
        assert!(!findings.iter().any(Diagnostic::is_error), "{}: {findings:?}\n{text}", format.name);
    }
    (format.round)(&mut again);
    let texts = |files: &[Written]| files.iter().map(|file| file.text.clone()).collect::<Vec<_>>().concat();
    assert_eq!(texts(&(format.write)(&again, wiring, &[])), texts(&files), "{}", format.name);
}
