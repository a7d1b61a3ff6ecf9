//! JSON schemas of the `--json` output, one per command. They are derived from the result types, so they cannot differ from them.

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

/// Output of `ncfix diff`: programs as executed, or with `--text` as written.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
enum Diff {
    Executed(review::Review),
    Written(review::TextReview),
}

/// Line of the output of `ncfix feed`.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
enum Feed {
    Forecast(feed::Before),
    Status(feed::Status),
    Said(feed::Said),
}

/// Output of `ncfix machine`: errors at a pose (`--at`), or with `--origin` the origins of the values.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
enum Machine {
    Shares(shares::Shares),
    Origins(origin::Origins),
}

/// Output of `ncfix sensors`: a selection, or with `--watch` a line for each poll.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
enum Sensors {
    Selection(sensors::SensorReport),
    Watch(watch::WatchReport),
}

/// Returns the name of every command that has `--json`, with the schema of its output, in the order of the names.
#[must_use]
pub fn all() -> Vec<(&'static str, Value)> {
    vec![
        ("calibrate", of::<calibration::CalibrationReport>()),
        ("check", of::<json::ProgramCheck>()),
        ("decompose", of::<decomposition::DecompositionReport>()),
        ("diagnose", of::<diagnosis::DiagnosisReport>()),
        ("diff", of::<Diff>()),
        ("feed", of::<Feed>()),
        ("fix", of::<correction::CorrectionReport>()),
        ("iso230", of::<figures::FiguresReport>()),
        ("machine", of::<Machine>()),
        ("max-step", of::<steps::StepReport>()),
        ("resume", of::<feed::Plan>()),
        ("sensors", of::<Sensors>()),
        ("tables", of::<tables::TablesReport>()),
        ("verify", of::<json::VerificationReport>()),
        ("weigh", of::<load::Load>()),
    ]
}

/// Returns the schema of the serialized form of a type.
fn of<T: JsonSchema>() -> Value {
    SchemaSettings::draft2020_12().for_serialize().into_generator().into_root_schema_for::<T>().to_value()
}
