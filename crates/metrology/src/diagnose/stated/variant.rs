//! The words that distinguish a variant of a named cause from the others.

use super::super::cause::{Candidate, EffectKind, cross};
use ncfix_base::number::significant;

/// The words for a variant; `None` if its name says all.
pub(super) fn variant(one: &Candidate) -> Option<String> {
    if let Some((axis, [low, high])) = one.threshold {
        return Some(format!("starts between {axis} {} and {} mm", significant(low), significant(high)));
    }
    if let Some((constant, unit)) = one.constant {
        return Some(format!("{} {unit}", significant(constant)));
    }
    if one.cause.effect != EffectKind::Cross {
        return None;
    }
    let drivers = one.drivers.join(" and ");
    Some(match one.columns.len() {
        _ if one.cause.name == cross::LEVER.name => format!("an angle over {drivers} by its lever arm"),
        1 => format!("product of {drivers}"),
        2..=3 => format!("product of {drivers}, and each of them alone"),
        _ => format!("curved over {drivers}"),
    })
}
