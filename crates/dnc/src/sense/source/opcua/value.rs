//! Interpretation of the variables of a server.

use std::time::SystemTime;

use opcua::types::{DataValue, NodeId, ServerState, StatusCode, Variant};

use super::super::super::monitor::{ChannelFault, SourceReport};

/// Returns why a server has no values at all. A server that does not report its state is assumed to run.
pub(super) fn halt(state: &DataValue) -> Option<String> {
    let Some(Variant::Int32(number)) = state.value else { return None };
    match ServerState::try_from(number) {
        Ok(ServerState::Running | ServerState::Unknown) | Err(_) => None,
        Ok(state) => Some(format!("the server is not running: its state is {state:?}")),
    }
}

pub(super) fn nothing(why: String) -> SourceReport {
    SourceReport::Nothing(ChannelFault::Invalid, why)
}

/// Returns the value of a variable, and its source time if times are used.
pub(super) fn told(node: &NodeId, value: &DataValue, has_times: bool) -> (SourceReport, Option<SystemTime>) {
    let status = value.status.unwrap_or(StatusCode::Good);
    // A number that was set instead of the sensor is not a measured value.
    if !status.is_good() || status.sub_code() == StatusCode::GoodLocalOverride.sub_code() {
        return (nothing(format!("the server reports for {node}: {status}")), None);
    }
    let told = match value.value.as_ref().map_or(Err("no value"), number) {
        Ok(number) => SourceReport::Value(number),
        Err(kind) => nothing(format!("{node} has {kind}")),
    };
    if !has_times {
        return (told, None);
    }
    let time = value.source_timestamp.or(value.server_timestamp).filter(|time| !time.is_null());
    match time {
        Some(time) => (told, Some(time.as_chrono().into())),
        None => (nothing(format!("the server does not state when {node} was read")), None),
    }
}

/// Returns the number of a value, or the kind of value found instead.
fn number(value: &Variant) -> Result<f64, &'static str> {
    let number = match value {
        Variant::SByte(number) => f64::from(*number),
        Variant::Byte(number) => f64::from(*number),
        Variant::Int16(number) => f64::from(*number),
        Variant::UInt16(number) => f64::from(*number),
        Variant::Int32(number) => f64::from(*number),
        Variant::UInt32(number) => f64::from(*number),
        Variant::Int64(number) => *number as f64,
        Variant::UInt64(number) => *number as f64,
        // The shortest decimal of a 32-bit number, not the long one of the equal 64-bit number.
        Variant::Float(number) => number.to_string().parse().unwrap_or(f64::NAN),
        Variant::Double(number) => *number,
        Variant::Empty => return Err("no value"),
        Variant::Boolean(_) => return Err("a truth value, not a number"),
        Variant::String(_) | Variant::LocalizedText(_) => return Err("a text, not a number"),
        Variant::DateTime(_) => return Err("a time, not a number"),
        Variant::Array(_) => return Err("an array, not a number"),
        _ => return Err("a value that is not a number"),
    };
    if number.is_finite() { Ok(number) } else { Err("no finite number") }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use opcua::types::{Array, DateTime, VariantScalarTypeId};

    use super::*;

    fn of(value: Variant, status: StatusCode) -> SourceReport {
        let value = DataValue { value: Some(value), status: Some(status), ..DataValue::default() };
        told(&NodeId::new(2, "T"), &value, false).0
    }

    #[test]
    fn numbers_of_all_kinds_are_numbers() {
        let numbers = [
            (Variant::SByte(-5), -5.0),
            (Variant::Byte(200), 200.0),
            (Variant::Int16(-215), -215.0),
            (Variant::UInt16(65_535), 65_535.0),
            (Variant::Int32(-70_000), -70_000.0),
            (Variant::UInt32(4_000_000_000), 4e9),
            (Variant::Int64(-5_000_000_000), -5e9),
            (Variant::UInt64(5_000_000_000), 5e9),
            (Variant::Float(21.4), 21.4),
            (Variant::Double(21.437), 21.437),
        ];
        for (value, expected) in numbers {
            assert_eq!(of(value, StatusCode::Good), SourceReport::Value(expected));
        }
    }

    #[test]
    fn what_is_no_number_is_refused_and_named() {
        let array = Array::new(VariantScalarTypeId::Double, vec![Variant::Double(21.0)]).unwrap();
        let others = [
            (Variant::Boolean(true), "ns=2;s=T has a truth value, not a number"),
            (Variant::from("21.5"), "ns=2;s=T has a text, not a number"),
            (Variant::from(DateTime::now()), "ns=2;s=T has a time, not a number"),
            (Variant::from(array), "ns=2;s=T has an array, not a number"),
            (Variant::Empty, "ns=2;s=T has no value"),
            (Variant::from(NodeId::new(0, 1_u32)), "ns=2;s=T has a value that is not a number"),
            (Variant::Double(f64::NAN), "ns=2;s=T has no finite number"),
            (Variant::Float(f32::INFINITY), "ns=2;s=T has no finite number"),
        ];
        for (value, why) in others {
            assert_eq!(of(value, StatusCode::Good), nothing(why.into()));
        }
        assert_eq!(told(&NodeId::new(2, "T"), &DataValue::default(), false).0, nothing("ns=2;s=T has no value".into()));
    }

    #[test]
    fn only_good_values_count() {
        let codes = [
            StatusCode::BadNoCommunication,
            StatusCode::UncertainLastUsableValue,
            StatusCode::GoodLocalOverride,
            // A code that no version of the standard has.
            StatusCode::from(0x8fff_0000),
        ];
        for code in codes {
            assert!(
                matches!(of(Variant::Double(21.0), code), SourceReport::Nothing(ChannelFault::Invalid, _)),
                "{code}"
            );
        }
        let why = "the server reports for ns=2;s=T: BadNoCommunication".to_owned();
        assert_eq!(of(Variant::Double(21.0), StatusCode::BadNoCommunication), nothing(why));
        assert_eq!(of(Variant::Double(21.0), StatusCode::GoodClamped), SourceReport::Value(21.0));
    }

    #[test]
    fn the_time_of_the_source_counts_where_that_is_asked_for() {
        let at = |seconds: u64| SystemTime::UNIX_EPOCH + Duration::from_secs(seconds);
        let time = |seconds: u64| Some(DateTime::from(opcua::types::DateTimeUtc::from(at(seconds))));
        let mut value = DataValue { value: Some(21.0.into()), ..DataValue::default() };
        let node = NodeId::new(2, "T");
        let unknown = "the server does not state when ns=2;s=T was read".to_owned();
        assert_eq!(told(&node, &value, true), (nothing(unknown), None));
        value.server_timestamp = time(1_800_000_060);
        assert_eq!(told(&node, &value, true), (SourceReport::Value(21.0), Some(at(1_800_000_060))));
        value.source_timestamp = time(1_800_000_000);
        assert_eq!(told(&node, &value, true), (SourceReport::Value(21.0), Some(at(1_800_000_000))));
        assert_eq!(told(&node, &value, false), (SourceReport::Value(21.0), None));
    }

    #[test]
    fn a_server_that_does_not_run_has_no_values() {
        let state = |number: i32| DataValue { value: Some(number.into()), ..DataValue::default() };
        assert_eq!(halt(&state(0)), None);
        assert_eq!(halt(&state(3)).as_deref(), Some("the server is not running: its state is Suspended"));
        assert!(halt(&state(6)).is_some());
        // State missing, or not in the standard.
        assert_eq!(halt(&DataValue::default()), None);
        assert_eq!(halt(&state(99)), None);
    }
}
