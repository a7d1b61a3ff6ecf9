//! A change of the machine between measurements, by a crash, a repair or a transport: a location error or a reversal value that differs in earlier
//! files.
//!
//! The last file shows the present state. The difference in earlier files is determined from them alone and is not written, so the location error
//! common to all files is the present one.

use super::{Candidate, Cause, Correctable, EffectKind, Weight};
use crate::diagnose::scene::{Scene, Through};
use ncfix_model::name::{DIRECTIONS, ErrorName};

pub(in crate::diagnose) const CAUSE: Cause = Cause {
    name: "change between measurements",
    effect: EffectKind::Earlier,
    made_by: "a collision, a repair, new leveling or a transport between two measurements",
    shown_by: "an error with one value in all files before a date, and another value in all files after it",
    separate_by: "measure again: the current value remains",
    correctable: Correctable::No,
    propose: |_, _| {},
};

/// Maximum number of candidates. Each boundary between neighboring files has one for each error.
const MOST: usize = 400;

/// Proposes a change at every boundary between the `used` measurements, which are in the order in which they were taken.
pub(in crate::diagnose) fn propose(scene: &Scene<'_>, used: usize, out: &mut Vec<Candidate>) {
    let linear: Vec<_> = super::linear(scene).collect();
    let axes = scene.machine.axes.iter().flatten();
    let of_axes = axes.flat_map(|data| DIRECTIONS.map(|direction| ErrorName::location(direction, data.axis)));
    let locations: Vec<ErrorName> = of_axes.collect();
    let boundaries = used.min(scene.sets.len()).saturating_sub(1);
    if boundaries * (locations.len() + linear.len()) > MOST {
        return;
    }
    for first in 1..=boundaries {
        let Some(file) = scene.sets.get(first).map(|set| &set.name) else { continue };
        for &name in &locations {
            let weight = Weight::new(move |row| f64::from(u8::from(row.set < first)));
            let one = Candidate::one(&CAUSE, format!("{name} before {file}"), Through::Component(name), weight);
            out.push(one.driven_by(&[&"file"]));
        }
        for &axis in &linear {
            // A reversal value acts with half its size on either side.
            let weight = Weight::new(move |row| if row.set < first { 0.5 * row.sense_of(axis) } else { 0.0 });
            let name = super::own(axis);
            let parameter = format!("{name} backlash before {file}");
            let one = Candidate::one(&CAUSE, parameter, Through::Component(name), weight);
            out.push(one.driven_by(&[&"file", &format!("{axis}_dir")]));
        }
    }
}
