//! Machine files, data that a control has saved, states and logs.

use ncfix_base::diagnostic::Diagnostic;
use ncfix_language::exec::apply_archive;
use ncfix_machine::machine::condition;
use ncfix_machine::machine::edit::Edit;
use ncfix_machine::machine::file::apply_setup;
use ncfix_model::file::load;

use super::programs::machine_of;
use super::{check_findings, source};

/// A machine file: its findings are in it, and an editor that changes nothing leaves every line.
pub fn machine(bytes: &[u8]) {
    let file = source("machine.toml", bytes);
    let (machine, findings) = load(&file);
    check_findings(&findings, &[&file]);
    assert_eq!(machine.is_none(), findings.iter().any(Diagnostic::is_error), "{findings:?}");
    let text = std::str::from_utf8(bytes);
    let edit = text.ok().and_then(Edit::parse);
    if let (Ok(text), Some(edit)) = (text, &edit) {
        // But for the end of the last line and the mark of UTF-8.
        assert!(
            edit.text().lines().eq(text.trim_start_matches('\u{feff}').lines()),
            "{text}\n became\n{}",
            edit.text()
        );
    }
    // A machine that is there can be changed: both readers of TOML know its text.
    assert!(edit.is_some() || machine.is_none(), "a machine that cannot be edited");
    if let Some((machine, errors)) = machine {
        // Whoever has a machine can ask it.
        let model = ncfix_model::Model::new(&machine, &errors);
        let zero = ncfix_base::geometry::AxisVector::ZERO;
        let pose =
            model.actual(&zero, &ncfix_base::geometry::Vector::zeros(), &ncfix_machine::machine::State::default());
        let _ = format!("{pose:?}");
    }
    let mut machine = machine_of("sinumerik").0.clone();
    let before = machine.clone();
    let findings = apply_setup(&file, &mut machine);
    check_findings(&findings, &[&file]);
    if findings.iter().any(Diagnostic::is_error) {
        assert_eq!(machine.tools.len(), before.tools.len());
        assert_eq!(machine.zero_offsets, before.zero_offsets);
    }
}

/// What controls save: tools, zero offsets, parameters, archives.
pub fn saved_data(bytes: &[u8]) {
    let file = source("saved", bytes);
    for name in ["sinumerik", "grundig"] {
        let mut machine = machine_of(name).0.clone();
        let findings = apply_archive(&file, &mut machine);
        check_findings(&findings, &[&file]);
        for tool in &machine.tools {
            assert!(tool.length_mm.iter().all(|one| one.is_finite()) && tool.radius_mm.is_finite(), "{tool:?}");
        }
    }
}

/// State files and logs of temperatures and loads.
pub fn state(bytes: &[u8]) {
    let file = source("state", bytes);
    let readers = [condition::file::load, condition::log::load, condition::log::load_with_dead];
    for read in readers {
        let (condition, findings) = read(&file);
        check_findings(&findings, &[&file]);
        assert_eq!(condition.is_none(), findings.iter().any(Diagnostic::is_error), "{findings:?}");
        let Some(condition) = condition else { continue };
        assert!(condition.time_range_s().is_none_or(|[first, last]| first <= last));
        for sensor in condition.sensors() {
            for lag_s in [0.0, 60.0, 1e5] {
                let value = condition.temperature_c(sensor, lag_s);
                assert!(value.is_none_or(f64::is_finite), "{sensor} {value:?}");
            }
        }
    }
    let _ = condition::log::is_log(&file);
}
