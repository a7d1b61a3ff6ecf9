//! Sag and angularity compensation of the SINUMERIK 840D: `$AN_CEC` as an initialisation program.
//!
//! A table has a basic axis (input) and a compensation axis (output), equal steps between MIN and MAX, linear between, the end values outside. Tables
//! of one output are added; `$AN_CEC_MULT_BY_TABLE[t] = n` multiplies table t by the table of number n, which is its index plus 1. The result is
//! added to the set-point. (SINUMERIK 840D sl, Extended Functions K3 4.4.4; Esmaeili 2021, 2.4.5.3 and Fig. 7.3.) Units are those of the basic
//! system, here mm, and degrees.

use std::fmt::Write as _;

use super::limits::{FormatLimits, Holds};
use super::plain::{even_points, round_steps};
use super::{Format, Written, ini, marks, rounded};
use crate::tables::{Multiplication, Nodes, Sense, Tables, Wiring};

mod reader;

/// Decimals of additive values: a nanometer.
const DECIMALS: usize = 6;
/// Decimals of factors, whose products are smaller than themselves.
const FACTOR_DECIMALS: usize = 8;
/// Decimals of positions.
const POSITION_DECIMALS: usize = 6;

/// The format.
pub(super) const FORMAT: Format = Format {
    name: "cec",
    title: "SINUMERIK $AN_CEC",
    sign: "assumed: values are added to the set-point of the output axis; the manual does not state the sign, try one large value on the machine",
    holds: &[Holds::Own, Holds::Cross, Holds::Products, Holds::Senses, Holds::CrossSenses, Holds::Repetition],
    // Two tables for each of 31 axes; MD18342 accepts 2000 points; MD32720 accepts 10 mm, default 1 mm.
    limits: FormatLimits { tables: 62, points: 2000, value_mm: 10.0, resolution_mm: 1e-6, further: "" },
    round,
    faults,
    write,
    read: reader::read,
    numbers: reader::numbers,
    beside: &["enc"],
    sum_limit: Some(sum_limit),
    has_axis_numbers: true,
    is_mine,
};

/// Room of the limit of a sum above the largest one at the poses of the check, as a factor.
const ROOM: f64 = 1.1;

/// MD32720, as a remark: machine data needs a password and takes effect later than tables, so that the operator decides (K3 4.4.3).
fn sum_limit(axis: &str, largest: f64, unit: &str) -> String {
    let value = (largest * ROOM * 1e4).ceil() / 1e4;
    format!(
        "$MA_CEC_MAX_SUM[{axis}]={value} ; {unit}, MD32720: not less than this, which is a tenth above the largest sum"
    )
}

fn round(tables: &mut Tables) {
    let named: Vec<usize> = tables.lookups.iter().filter_map(|one| one.factor).collect();
    for (index, one) in tables.lookups.iter_mut().enumerate() {
        let decimals = if one.factor.is_some() || named.contains(&index) { FACTOR_DECIMALS } else { DECIMALS };
        one.values.iter_mut().for_each(|value| *value = rounded(*value, decimals));
        even_points(one, POSITION_DECIMALS);
        round_steps(one, POSITION_DECIMALS);
    }
}

fn faults(tables: &Tables, _: &Wiring) -> Vec<String> {
    let mut faults = Vec::new();
    for (index, one) in tables.lookups.iter().enumerate() {
        match one.nodes {
            Nodes::At(_) => faults.push(format!("table {index} has uneven steps, and $AN_CEC has equal ones")),
            Nodes::Even { start, step, end } if step <= 0.0 || end <= start => {
                faults.push(format!("table {index} has one point, and $AN_CEC has two at least"));
            }
            Nodes::Even { .. } => {}
        }
        if one.modulo && !one.input.is_rotary() {
            faults.push(format!("table {index} repeats over {}, which only rotary axes can", one.input));
        }
        let factor = one.factor.and_then(|factor| tables.lookups.get(factor));
        if factor.is_some_and(|factor| factor.output != one.output) {
            faults.push(format!("table {index} is multiplied by one that corrects another axis"));
        }
    }
    faults
}

/// The role of a table, for a comment.
fn role(tables: &Tables, index: usize) -> String {
    let Some(one) = tables.lookups.get(index) else { return String::new() };
    let product = one.factor.map_or(String::new(), |factor| format!(", times table {}", factor + 1));
    format!("; table {}: {} over {}{product}", index + 1, one.output, one.input)
}

fn write(tables: &Tables, wiring: &Wiring, notes: &[String]) -> Vec<Written> {
    let mut text = String::from("%_N_NC_CEC_INI\n");
    for note in notes {
        let _ = writeln!(text, "; {note}");
    }
    if tables.multiplication == Multiplication::Beside || tables.lookups.iter().any(|one| one.factor.is_some()) {
        let _ = writeln!(text, "; {}", marks::multiplication(tables.multiplication));
    }
    text.push_str("METRIC\nCHANDATA(1)\n");
    for (t, one) in tables.lookups.iter().enumerate() {
        let _ = writeln!(text, "{}", role(tables, t));
        for (n, value) in one.values.iter().enumerate() {
            let _ = writeln!(text, "$AN_CEC[{t},{n}]={value}");
        }
        let [start, end] = one.nodes.range();
        let step = if let Nodes::Even { step, .. } = one.nodes { step } else { 0.0 };
        let direction = match one.sense {
            Sense::Both => 0,
            Sense::Positive => 1,
            Sense::Negative => -1,
        };
        let rows = [
            ("INPUT_AXIS", wiring.name(one.input)),
            ("OUTPUT_AXIS", wiring.name(one.output)),
            ("STEP", step.to_string()),
            ("MIN", start.to_string()),
            ("MAX", end.to_string()),
            ("DIRECTION", direction.to_string()),
            ("MULT_BY_TABLE", one.factor.map_or(0, |factor| factor + 1).to_string()),
            ("IS_MODULO", u8::from(one.modulo).to_string()),
        ];
        for (name, value) in rows {
            let is_axis = name.ends_with("AXIS");
            let value = if is_axis { format!("({value})") } else { value };
            let _ = writeln!(text, "$AN_CEC_{name}[{t}]={value}");
        }
        if one.weight != 1.0 {
            let _ = writeln!(text, "$SN_CEC_TABLE_WEIGHT[{t}]={}", one.weight);
        }
        if !one.is_enabled {
            let _ = writeln!(text, "$SN_CEC_TABLE_ENABLE[{t}]=0");
        }
    }
    text.push_str("M17\n");
    vec![Written { suffix: String::new(), text }]
}

fn is_mine(_: &str, bytes: &[u8]) -> bool {
    ini::has(bytes, ini::TableVariable::Cec)
}
