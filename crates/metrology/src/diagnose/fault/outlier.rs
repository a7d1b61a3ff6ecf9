//! Single readings far from the previous one, the next one and their own repetitions. A spike after a reversal recurs at the next visit and is no
//! outlier.

use super::trail::ReadingTrail;
use super::{DataDefect, DefectCheck, DefectKind, Then, View};

pub(super) const CHECK: DefectCheck = DefectCheck {
    name: "single readings far out",
    made_by: "a chip under the probe, an interrupted beam, a touched cable",
    shown_by: "isolated in time, and not repeated at the same position",
    source: "isolation and non-repetition; median of absolute deviations",
    look,
};

/// Smallest distance from both neighbors and from the repetitions, in units of the noise.
const FAR: f64 = 7.0;

fn look(view: &View<'_, '_>, out: &mut Vec<DataDefect>) {
    for (set, data) in view.sets() {
        let Some(trail) = view.trails.get(set).filter(|trail| trail.is_repeated) else { continue };
        let mut readings: Vec<(usize, usize)> = trail.channels.iter().flat_map(far).collect();
        readings.sort_unstable();
        let (Some(first), Some(last)) = (readings.first(), readings.last()) else { continue };
        out.push(DataDefect {
            kind: DefectKind::Outlier,
            set,
            name: data.name.clone(),
            what: "far from neighbors and repetitions".into(),
            rows: [first.0, last.0],
            evidence: match readings.len() {
                1 => format!("1 reading is more than {FAR} times the noise from both"),
                count => format!("{count} readings are more than {FAR} times the noise from both"),
            },
            then: Then::WithoutReadings(readings),
        });
    }
}

fn far(channel: &ReadingTrail) -> Vec<(usize, usize)> {
    let left = |place: usize| channel.left.get(place).copied().filter(|left| left.is_finite());
    let limit = FAR * channel.noise;
    let is_far = |place: usize| {
        let Some(own) = left(place) else { return false };
        let sides = [place.checked_sub(1).and_then(left), left(place + 1)];
        let away = |side: f64| (own - side) * own.signum() > limit;
        own.abs() > limit && sides.iter().flatten().all(|side| away(*side)) && sides.iter().any(Option::is_some)
    };
    (0..channel.at.len()).filter(|&place| is_far(place)).map(|place| channel.at[place]).collect()
}
