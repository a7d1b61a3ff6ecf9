//! Exchanged columns, and columns or components with the wrong sign.
//!
//! The check tests all permutations and signs of the reading columns, then those of the positions of the linear axes, each with its best set-ups. It
//! reports a fault only if the given readings do not fit, another assignment fits to the noise, and the simplest such assignment is clear. The
//! machine may have errors of its own. If no assignment fits without them, terms proportional to an axis, reversing with its direction or bending
//! over it are allowed for all assignments alike. At the end, the assignment must need clearly fewer usual errors of the machine than the given one.

use super::exchanged_positions::{self, Turned};
use super::readings::{Allowance, WeighedReadings};
use super::simplest::{Thresholds, needs_fewer};
use super::single::{ROWS, by_one_cause, left, thinned};
use super::{DataDefect, DefectCheck, DefectKind, Then, View};
use crate::measure::data::{DataSet, Observation};
use ncfix_base::units::um_from_mm;

pub(super) const CHECK: DefectCheck = DefectCheck {
    name: "exchanged or reversed axes",
    made_by: "exchanged cables or columns, an instrument with the opposite sign",
    shown_by: "readings that fit the model within the noise if two columns are exchanged or one is reversed, but not as given",
    source: "likelihood over permutations",
    look,
};

/// Largest mean squared residual of readings that fit, in squares of the noise.
const FITS: f64 = 4.0;
/// Largest mean squared residual of readings with nothing but noise.
const CLEAN: f64 = 1.7;
/// Smallest ratio of the residual of the given readings to the best residual.
const WORSE: f64 = 2.5;
/// Smallest mean squared residual of the given readings if causes are fitted too, in squares of the noise.
const MUCH: f64 = 9.0;
/// Assignments with residuals within this factor are equally good.
const TIE: f64 = 1.15;
/// Maximum number of exchanged or reversed columns if causes are fitted too.
const SIMPLE: usize = 2;
/// Minimum number of runs that show it, if a cause of the machine hides the quality of the fit.
const RUNS: usize = 3;
/// Minimum share of them in the whole difference.
const SHARE: f64 = 0.9;
/// Smallest prediction, in units of the noise.
const SIZE: f64 = 2.0;
/// Largest plausible deviation of a machine from its model, mm; beyond it the readings belong to other positions.
const PLAUSIBLE_MM: f64 = 1.0;
const PERMUTATIONS: [[usize; 3]; 6] = [[0, 1, 2], [1, 0, 2], [2, 1, 0], [0, 2, 1], [1, 2, 0], [2, 0, 1]];
const COLUMNS: [&str; 3] = ["dx_um", "dy_um", "dz_um"];
const POSITIONS: [&str; 3] = ["X", "Y", "Z"];
/// A ball-bar has one column.
const OF_ONE: [&str; 3] = ["dr_um", "", ""];

/// An assignment of three columns: source and sign of each.
#[derive(Clone, Copy, Debug)]
pub(super) struct ColumnMeaning {
    pub(super) permutation: [usize; 3],
    pub(super) sign: [f64; 3],
}

impl ColumnMeaning {
    /// All assignments; the given one first.
    pub(super) fn all() -> impl Iterator<Item = ColumnMeaning> {
        PERMUTATIONS.into_iter().flat_map(|permutation| {
            let sign = |signs: usize| [0, 1, 2].map(|k| if signs >> k & 1 == 1 { -1.0 } else { 1.0 });
            (0..8).map(move |signs| ColumnMeaning { permutation, sign: sign(signs) })
        })
    }

    /// Number of columns that differ from the given assignment.
    pub(super) fn moved(&self) -> usize {
        (0..3).map(|k| usize::from(self.permutation[k] != k) + usize::from(self.sign[k] < 0.0)).sum()
    }

    /// The measurement with the readings in these columns.
    fn readings_of(&self, data: &DataSet) -> DataSet {
        let mut out = data.clone();
        for (to, from) in out.observations.iter_mut().zip(&data.observations) {
            to.values = [0, 1, 2].map(|k| from.values[self.permutation[k]].map(|value| self.sign[k] * value));
        }
        out
    }

    /// Value of a column, from all three columns.
    fn of(&self, value: usize, all: [f64; 3]) -> f64 {
        let value = value.min(2);
        self.sign[value] * all[self.permutation[value]]
    }

    /// True if it changes only these columns.
    pub(super) fn is_of(&self, columns: &[usize]) -> bool {
        (0..3).all(|k| columns.contains(&k) || self.permutation[k] == k && self.sign[k] > 0.0)
    }

    /// Names of the changed columns, and their fault.
    fn words(&self, columns: [&str; 3]) -> (String, ColumnFault) {
        let named = |is_one: &dyn Fn(usize) -> bool| -> Vec<&str> {
            (0..3).filter(|&k| is_one(k)).map(|k| columns[k]).collect()
        };
        let moved = named(&|k| self.permutation[k] != k);
        let reversed = named(&|k| self.sign[k] < 0.0);
        let fault = match (moved.is_empty(), reversed.is_empty()) {
            (false, true) => ColumnFault::Swapped,
            (true, _) => ColumnFault::Reversed,
            (false, false) => ColumnFault::SwappedAndReversed,
        };
        (if moved.is_empty() { reversed } else { moved }.join(" "), fault)
    }
}

/// Fault of columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ColumnFault {
    /// They are exchanged.
    Swapped,
    /// They have the opposite sign.
    Reversed,
    /// They are exchanged, and some have the opposite sign.
    SwappedAndReversed,
}

impl ColumnFault {
    fn is_reversed(self) -> bool {
        self != ColumnFault::Swapped
    }
}

impl std::fmt::Display for ColumnFault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            ColumnFault::Swapped => "swapped",
            ColumnFault::Reversed => "reversed",
            ColumnFault::SwappedAndReversed => "swapped and reversed",
        })
    }
}

/// Residuals of several assignments, the given one first.
struct Left<'w> {
    ways: &'w [ColumnMeaning],
    left: Vec<f64>,
    columns: [&'static str; 3],
    beside: Allowance,
}

/// An assignment that fits.
struct SwappedAxes {
    way: ColumnMeaning,
    of_positions: bool,
    name: String,
    what: String,
    /// True if a column may have the opposite sign, in this assignment or in one that is as good.
    may_be_reversed: bool,
    left: [f64; 2],
    beside: Allowance,
}

fn look(view: &View<'_, '_>, out: &mut Vec<DataDefect>) {
    for (set, data) in view.sets() {
        let (Some(readings), Some(trail)) = (WeighedReadings::new(view.scene, set), view.trails.get(set)) else {
            continue;
        };
        let noise = trail.noise_ratio().unwrap_or(1.0).powi(2).max(1e-6);
        let mut add = |kind: DefectKind, name: String, what: String, evidence: String| {
            let rows = [0, data.observations.len().saturating_sub(1)];
            out.push(DataDefect { kind, set, name, what, rows, evidence, then: Then::Refuse });
        };
        if data.observations.iter().any(|one| one.component.is_some()) {
            for (number, name) in data.targets.iter().enumerate() {
                let is_clear = |told: &SwappedAxes| needs_fewer_reversed(view, data, number, told.limits(noise));
                if let Some(told) = component(view, &readings, number, noise).filter(is_clear) {
                    add(DefectKind::Axes, name.clone(), told.what.clone(), told.evidence(noise));
                }
            }
            continue;
        }
        let is_clear = |told: &SwappedAxes| !is_one_cause(view, data, told) && told.needs_fewer(view, data, noise);
        if let Some(told) = columns(view, data, &readings, noise).filter(is_clear) {
            let evidence = told.evidence(noise);
            add(DefectKind::Axes, told.name, told.what, evidence);
            continue;
        }
        // A term proportional to an axis may come from the length unit of an instrument; the length of a ball-bar is known.
        let beside = if is_circle(data) { Allowance::Nothing } else { Allowance::Straight };
        let away = readings.beside(view.scene, view.tips(), beside).map_or(0.0, |readings| readings.middle());
        if away > PLAUSIBLE_MM {
            let evidence = format!(
                "half of the readings differ by {:.0} µm or more from the prediction there; no machine has such errors",
                um_from_mm(away)
            );
            add(DefectKind::Positions, data.name.clone(), "not of these positions".into(), evidence);
        }
    }
}

/// True if a single cause of the machine explains the given readings equally well. For a reversed column it must do so better, because a slope has
/// the same effect as another sign.
fn is_one_cause(view: &View<'_, '_>, data: &DataSet, told: &SwappedAxes) -> bool {
    let sets = [thinned(data, ROWS)];
    let machine = view.scene.machine;
    let Some(as_is) = left(machine, view.scene, &sets, f64::INFINITY) else { return false };
    let single = by_one_cause(machine, &sets, &as_is) / as_is.values.len().max(1) as f64;
    let factor = if told.may_be_reversed { 1.0 / TIE } else { TIE };
    single < factor * told.left[1]
}

/// True if the readings of a component need fewer errors of the machine with the opposite sign.
fn needs_fewer_reversed(view: &View<'_, '_>, data: &DataSet, number: usize, limits: Thresholds) -> bool {
    let mut other = data.clone();
    let is_own = |row: &&mut Observation| row.component.is_some() && row.target == Some(number);
    for row in other.observations.iter_mut().filter(is_own) {
        row.values = row.values.map(|value| value.map(|value| -value));
    }
    needs_fewer(view.scene.machine, &view.scene.errors, [data, &other], limits)
}

impl SwappedAxes {
    fn limits(&self, noise: f64) -> Thresholds {
        Thresholds { fits: CLEAN * noise, tie: TIE, worse: WORSE }
    }

    /// True if the readings need clearly fewer errors of the machine with this assignment.
    fn needs_fewer(&self, view: &View<'_, '_>, data: &DataSet, noise: f64) -> bool {
        let others = if self.of_positions {
            exchanged_positions::read_in(data, &self.way)
        } else {
            vec![self.way.readings_of(data)]
        };
        let (machine, errors) = (view.scene.machine, &view.scene.errors);
        others.iter().any(|other| needs_fewer(machine, errors, [data, other], self.limits(noise)))
    }

    fn evidence(&self, noise: f64) -> String {
        let [as_is, otherwise] = self.left.map(|left| (left / noise).sqrt());
        let beside = match self.beside {
            Allowance::Nothing => "",
            Allowance::Turning => " after a fit of effects that reverse with the direction of an axis",
            Allowance::Straight => " after a fit of effects that are linear in an axis or reverse with its direction",
            Allowance::Bent => {
                " after a fit of effects that are linear or quadratic in an axis or reverse with its direction"
            }
        };
        let what = &self.what;
        let open =
            if self.left[1] > CLEAN * noise { "; because of further errors, the columns are uncertain" } else { "" };
        format!(
            "the residual of the readings as given is {as_is:.1} times their noise{beside}; {what}, it is {otherwise:.1} times{open}"
        )
    }
}

/// Tests a component with the opposite sign.
fn component(view: &View<'_, '_>, readings: &WeighedReadings, number: usize, noise: f64) -> Option<SwappedAxes> {
    for beside in Allowance::ALL {
        let readings = readings.beside(view.scene, view.tips(), beside)?;
        let left = [1.0, -1.0].map(|times| readings.left_with(Some(number), times));
        if left[0] < FITS * noise.min(1.0) || readings.matched(Some(number)).size < SIZE * noise.sqrt() {
            return None;
        }
        if left[1] < FITS * noise {
            let way = ColumnMeaning { permutation: PERMUTATIONS[0], sign: [-1.0; 3] };
            let told = SwappedAxes {
                way,
                of_positions: false,
                name: String::new(),
                what: ColumnFault::Reversed.to_string(),
                may_be_reversed: true,
                left,
                beside,
            };
            return (left[0] > WORSE * left[1]).then_some(told);
        }
    }
    None
}

/// True for a ball-bar, which has one column of readings.
fn is_circle(data: &DataSet) -> bool {
    data.setups.iter().any(|setup| setup.length_mm > 0.0)
}

/// The simplest other assignment of the columns that fits.
fn columns(view: &View<'_, '_>, data: &DataSet, readings: &WeighedReadings, noise: f64) -> Option<SwappedAxes> {
    let values = readings.values();
    let ways: Vec<ColumnMeaning> = ColumnMeaning::all().filter(|way| way.is_of(&values)).collect();
    let columns = if is_circle(data) { OF_ONE } else { COLUMNS };
    let mut turned: Option<Turned> = None;
    let mut told: Option<SwappedAxes> = None;
    let mut first: Option<Vec<f64>> = None;
    for beside in Allowance::ALL {
        let Some(own) = readings.beside(view.scene, view.tips(), beside) else { break };
        let left: Vec<f64> = ways.iter().map(|way| own.left_if(None, &|value, all| way.of(value, all), 1.0)).collect();
        let left = Left { ways: &ways, left, columns, beside };
        // With many fitted terms the given readings fit better than without them.
        if left.fits_as_is(noise) && (beside == Allowance::Nothing || left.told(noise, CLEAN).is_none()) {
            break;
        }
        let as_is = left.as_is();
        first.get_or_insert_with(|| left.left.clone());
        // Each assignment of the positions needs its own prediction, from fewer rows.
        let turned = turned.get_or_insert_with(|| exchanged_positions::turned(view.scene, data));
        let of_positions = std::iter::once(as_is).chain(turned.left.iter().map(|left| left[beside as usize])).collect();
        let of_positions = Left { ways: &turned.ways, left: of_positions, columns: POSITIONS, beside };
        for left in [&left, &of_positions] {
            if let Some(own) =
                left.told(noise, FITS).filter(|own| told.as_ref().is_none_or(|told| own.left[1] < told.left[1]))
            {
                told = Some(own);
            }
        }
        if told.as_ref().is_some_and(|told| told.left[1] < CLEAN * noise) {
            return told;
        }
    }
    // With an additional cause, nothing fits until the allowed terms fit everything. Then the result without allowed terms counts, if all runs agree.
    told.or_else(|| {
        let first = Left { ways: &ways, left: first?, columns, beside: Allowance::Nothing };
        let (_, best) = first.left.iter().zip(&ways).min_by(|a, b| a.0.total_cmp(b.0))?;
        let (runs, share) = readings.better_if(&|value, all| best.of(value, all));
        first.told(noise, f64::INFINITY).filter(|_| runs >= RUNS && share > SHARE)
    })
}

impl Left<'_> {
    fn as_is(&self) -> f64 {
        self.left.first().copied().unwrap_or(0.0)
    }

    fn fits_as_is(&self, noise: f64) -> bool {
        self.as_is() < FITS * noise.min(1.0)
    }

    /// The simplest good assignment, if its mean squared residual is within `fits` squares of the noise.
    fn told(&self, noise: f64, fits: f64) -> Option<SwappedAxes> {
        let as_is = self.as_is();
        let best = self.left.iter().copied().fold(f64::INFINITY, f64::min);
        // Allowed terms may fit better by chance, as other causes leave slightly more than noise with any assignment.
        let least = if self.beside == Allowance::Nothing { 0.0 } else { MUCH * noise };
        if best > fits * noise || as_is < (WORSE * best).max(least) {
            return None;
        }
        let good = || self.ways.iter().zip(&self.left).filter(|(_, left)| **left < TIE * best);
        let simplest = good().map(|(way, _)| way.moved()).min()?;
        // With many allowed terms, one of many assignments fits by chance.
        if self.beside != Allowance::Nothing && simplest > SIMPLE {
            return None;
        }
        let mut simple = good().filter(|(way, _)| way.moved() == simplest);
        let (way, left) = simple.next()?;
        let (name, fault) = way.words(self.columns);
        let (mut what, mut may_be_reversed) = (fault.to_string(), fault.is_reversed());
        // The set-ups hide which one it is, but it is certainly one of them.
        for (other, how) in simple.map(|(way, _)| way.words(self.columns)) {
            what.push_str(&format!(", or {other} {how}"));
            may_be_reversed |= how.is_reversed();
        }
        let of_positions = self.columns == POSITIONS;
        let left = [as_is, *left];
        Some(SwappedAxes { way: *way, of_positions, name, what, may_be_reversed, left, beside: self.beside })
    }
}
