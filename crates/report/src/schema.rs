//! JSON schemas of what `--json` prints, one per command: derived from the types of the results, so that they cannot differ from them.

#![allow(
    dead_code,
    clippy::large_enum_variant,
    reason = "the enums say which results one command has; only their schemas are used"
)]

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::Serialize;
use serde_json::Value;

use super::{
    calibration, correction, decomposition, diagnosis, feed, figures, json, load, origin, review, sensors, shares,
    steps, tables, watch,
};

/// What `ncfix diff` prints: programs as they are executed, or with `--text` as they are written.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
enum Diff {
    Executed(review::Review),
    Written(review::TextReview),
}

/// A line of what `ncfix feed` prints.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
enum Feed {
    Forecast(feed::Before),
    Status(feed::Status),
    Said(feed::Said),
}

/// What `ncfix machine` prints: errors at a pose (`--at`), or with `--origin` where the values come from.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
enum Machine {
    Shares(shares::Shares),
    Origins(origin::Origins),
}

/// What `ncfix sensors` prints: a selection, or with `--watch` a line for each poll.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
enum Sensors {
    Selection(sensors::SensorReport),
    Watch(watch::WatchReport),
}

/// The name of every command that has `--json`, with the schema of what it prints, in the order of the names.
#[must_use]
pub fn all() -> Vec<(&'static str, Value)> {
    vec![
        ("calibrate", of::<calibration::CalibrationReport>()),
        ("check", of::<json::Check>()),
        ("decompose", of::<decomposition::DecompositionReport>()),
        ("diagnose", of::<diagnosis::DiagnosisReport>()),
        ("diff", of::<Diff>()),
        ("feed", of::<Feed>()),
        ("fix", of::<correction::Correction>()),
        ("iso230", of::<figures::Figures>()),
        ("machine", of::<Machine>()),
        ("max-step", of::<steps::StepReport>()),
        ("resume", of::<feed::Plan>()),
        ("sensors", of::<Sensors>()),
        ("tables", of::<tables::TablesReport>()),
        ("verify", of::<json::Verification>()),
        ("weigh", of::<load::Load>()),
    ]
}

/// The schema of a type as it is printed.
fn of<T: JsonSchema>() -> Value {
    SchemaSettings::draft2020_12().for_serialize().into_generator().into_root_schema_for::<T>().to_value()
}
