//! The path to which the feed of a control refers.
//!
//! Sources: LinuxCNC, G code overview, "Feed rate"; Sinumerik, programming manual, FGROUP; Fanuc, operator's manual, G01 with linear and
//! rotary axes: `G91 G1 X20. C40. F300.` takes √(20² + 40²) / 300 min.

use super::Feeds;
use super::place::SHORT_MM;
use ncfix_base::geometry::{Axis, AxisVector, ROTARY_AXES};
use ncfix_machine::machine::Machine;

/// The path of the rotary axes between two positions, degrees.
pub(super) fn turned_deg(start: &AxisVector, end: &AxisVector) -> f64 {
    let turned = ROTARY_AXES.map(|axis| (end[axis] - start[axis]).to_degrees());
    turned.iter().map(|turn| turn * turn).sum::<f64>().sqrt()
}

/// The path between two programmed positions to which the feed refers, mm or degrees. Under a transformation it is that of the tip.
pub(super) fn counted(feeds: Feeds, is_transformed: bool, [start, end]: [&AxisVector; 2]) -> f64 {
    let linear_mm = (end.xyz() - start.xyz()).norm();
    let turned_deg = turned_deg(start, end);
    match feeds {
        Feeds::OfAll if !is_transformed => linear_mm.hypot(turned_deg),
        _ if linear_mm > SHORT_MM => linear_mm,
        _ => turned_deg,
    }
}

/// `true` if words add rotary or unknown axes to the feed path (FGROUP), `false` if not; `None` without FGROUP.
pub(super) fn counts_turns(words: &[u8], machine: &Machine) -> Option<bool> {
    let words = String::from_utf8_lossy(words).to_ascii_uppercase();
    let (axes, _) = words.split_once("FGROUP(")?.1.split_once(')')?;
    let by_letter = |name: &str| name.bytes().next().filter(|_| name.len() == 1).and_then(Axis::from_letter);
    let turns = |name: &str| machine.axis_named(name).or_else(|| by_letter(name)).is_none_or(|axis| axis.is_rotary());
    Some(axes.split(',').map(str::trim).filter(|name| !name.is_empty()).any(turns))
}
