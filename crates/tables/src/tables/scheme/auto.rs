//! The fewest tables that reach the tolerance on a control: all supported schemes are tried, and tables that are not needed are omitted.

use super::best_sets::{best_sets, subset};
use super::{AIM, Scheme, Schemes, Task, fewer};
use crate::tables::check::{CheckedPose, left, stands};
use crate::tables::{Control, Tables};
use ncfix_base::geometry::Axis;

/// Number of poses for comparing schemes and sets of tables.
const POSES: usize = 1000;
const SEED: u64 = 0x4155_544f;
/// Numbers of table points that are tried, ascending.
const POINTS: [usize; 5] = [5, 9, 17, 33, 65];
/// Excess of the residual to the first order up to which a set is evaluated.
const FIRST_ORDER: f64 = 1.05;
/// Residual of all tables, in units of the tolerance, up to which a part of them is tried: a part is seldom better than all.
const HOPELESS: f64 = 2.0;

/// Result of a tried scheme.
#[derive(Clone, Debug, PartialEq)]
pub struct Tried {
    /// Its name.
    pub scheme: &'static str,
    /// Number of points of a table.
    pub points: usize,
    /// Numbers of tables and values, and root mean square residual: tip in mm, tilt in rad; or the reason why it does not fit. If the tolerance is
    /// reached, they are those of the fewest tables that reach it.
    pub outcome: Result<(usize, usize, [f64; 2]), String>,
}

/// The fewest tables that reach the tolerance, and the tried schemes. `None` if no scheme does.
#[must_use]
pub fn choose(task: &Task<'_>) -> (Option<(&'static Scheme, Tables)>, Vec<Tried>) {
    choose_with(&Schemes::default(), task)
}

/// The fewest tables among these schemes that reach the tolerance, as [`choose`] determines them; of equally many tables, those with the fewest values.
#[must_use]
pub fn choose_with(schemes: &Schemes, task: &Task<'_>) -> (Option<(&'static Scheme, Tables)>, Vec<Tried>) {
    let poses = poses(task);
    let mut best: Option<(&'static Scheme, Tables)> = None;
    let mut tried = Vec::new();
    let most = task.format.limits.points;
    let points: Vec<usize> = POINTS.into_iter().filter(|&points| most == 0 || points <= most).collect();
    for &scheme in schemes.iter() {
        if best.as_ref().is_some_and(|(_, best)| best.count() <= 1 && best.entries() <= POINTS[0]) {
            break;
        }
        let mut trial = SchemeTrial { task, scheme, poses: &poses, best: None, tried: Vec::new() };
        trial.run(&points, best.as_ref().map(|(_, tables)| tables.count()));
        trial.tried.sort_by_key(|one| one.points);
        tried.append(&mut trial.tried);
        if let Some(tables) = trial.best
            && best.as_ref().is_none_or(|(_, best)| size(&tables) < size(best))
        {
            best = Some((scheme, tables));
        }
    }
    (best, tried)
}

/// The best set of at most `most` tables among these schemes: all tables of its scheme, and the set. `None` if no scheme has one.
#[must_use]
pub fn choose_at_most(
    schemes: &Schemes,
    task: &Task<'_>,
    most: usize,
) -> (Option<(&'static Scheme, [Tables; 2])>, Vec<Tried>) {
    let poses = poses(task);
    let mut best: Option<(f64, &'static Scheme, [Tables; 2])> = None;
    let mut tried = Vec::new();
    let limit = task.format.limits.points;
    let points = if limit == 0 { task.points } else { task.points.min(limit) };
    for &scheme in schemes.iter() {
        let task = Task { points, ..*task };
        let made = scheme.tables(&task).and_then(|tables| {
            let few = fewer::at_most(&task, &tables, most);
            if few.count() > most {
                return Err(format!("no part of its {} tables was found", tables.count()));
            }
            task.format.faults_of(&few, task.wiring).into_iter().next().map_or(Ok([tables, few]), Err)
        });
        let outcome = made.map(|[tables, few]| {
            let errors = left(&task.target, &Control::new(task.target.machine, &few), &poses);
            let row = (few.count(), few.entries(), [errors.rms_mm(), errors.rms_rad()]);
            if best.as_ref().is_none_or(|(least, ..)| errors.rms_mm() < *least) {
                best = Some((errors.rms_mm(), scheme, [tables, few]));
            }
            row
        });
        tried.push(Tried { scheme: scheme.name, points, outcome });
    }
    (best.map(|(_, scheme, tables)| (scheme, tables)), tried)
}

/// The fewest of these tables that reach the tolerance and fit the format; `None` if no set does.
#[must_use]
pub fn fewest(task: &Task<'_>, tables: &Tables) -> Option<Tables> {
    fewest_at(task, tables, &poses(task))
}

fn fewest_at(task: &Task<'_>, tables: &Tables, poses: &[CheckedPose]) -> Option<Tables> {
    let aim = AIM * task.tolerance_mm;
    let holds = |tables: &Tables| {
        task.format.faults_of(tables, task.wiring).is_empty()
            && left(&task.target, &Control::new(task.target.machine, tables), poses).rms_mm() <= aim
    };
    let sets = best_sets(task, tables, poses);
    let near = sets.iter().filter(|set| set.rms_mm <= FIRST_ORDER * aim);
    let slim = near.map(|set| subset(tables, &set.kept)).find(holds);
    slim.or_else(|| holds(tables).then(|| tables.clone()))
}

/// Poses in both directions of the axes with direction-dependent errors: they count even if a control has no tables for them.
fn poses(task: &Task<'_>) -> Vec<CheckedPose> {
    let has_senses = |axis: &Axis| task.target.model.features(*axis).backlash;
    let axes: Vec<Axis> = task.region.axes().filter(has_senses).collect();
    stands(&task.region.reached(task.target.machine).poses(POSES, SEED), &axes)
}

fn size(tables: &Tables) -> (usize, usize) {
    (tables.count(), tables.entries())
}

/// The search of one scheme.
struct SchemeTrial<'a> {
    task: &'a Task<'a>,
    scheme: &'static Scheme,
    poses: &'a [CheckedPose],
    /// Its fewest tables that reach the tolerance.
    best: Option<Tables>,
    tried: Vec<Tried>,
}

impl SchemeTrial<'_> {
    /// Tries these numbers of points: the fewest tables first of all, then the fewest points. `known` is the number of tables of another scheme.
    ///
    /// With the most points, tables leave the smallest residual, and most of them can be omitted. The numbers of points between matter only if the
    /// fewest points need more tables, or do not reach the tolerance, and the most points do.
    fn run(&mut self, points: &[usize], known: Option<usize>) {
        let [first, between @ .., last] = points else {
            if let [only] = points {
                let _ = self.attempt(*only);
            }
            return;
        };
        let coarse = match self.attempt(*first) {
            Ok(coarse) => coarse,
            Err(()) => return,
        };
        if self.scheme.finds_nodes || coarse.is_some_and(|count| count <= 1) {
            return;
        }
        let fine = self.attempt(*last).ok().flatten();
        let is_beaten = |count: usize| known.is_some_and(|known| known < count);
        // Neither the fewest nor the most points reach the tolerance, both need the same tables, or another scheme needs fewer.
        if fine == coarse || fine.is_some_and(is_beaten) {
            return;
        }
        for &points in between {
            match self.attempt(points) {
                Ok(Some(count)) if fine.is_none_or(|fine| count <= fine) => return,
                Ok(_) => {}
                Err(()) => return,
            }
        }
    }

    /// Makes tables with a number of points; returns the number of those that reach the tolerance.
    fn attempt(&mut self, points: usize) -> Result<Option<usize>, ()> {
        let task = Task { points, ..*self.task };
        let mut slim = None;
        let outcome = self.scheme.tables(&task).and_then(|tables| {
            let errors = left(&task.target, &Control::new(task.target.machine, &tables), self.poses);
            if errors.rms_mm() <= HOPELESS * task.tolerance_mm {
                slim = fewest_at(&task, &tables, self.poses);
            }
            let shown = match &slim {
                Some(slim) => (slim, left(&task.target, &Control::new(task.target.machine, slim), self.poses)),
                // An excessive number of tables may fit after omitting those with little effect.
                None => match task.format.faults_of(&tables, task.wiring).into_iter().next() {
                    Some(fault) => return Err(fault),
                    None => (&tables, errors),
                },
            };
            Ok((shown.0.count(), shown.0.entries(), [shown.1.rms_mm(), shown.1.rms_rad()]))
        });
        let is_made = outcome.is_ok();
        self.tried.push(Tried { scheme: self.scheme.name, points, outcome });
        if !is_made {
            return Err(());
        }
        let count = slim.as_ref().map(Tables::count);
        if let Some(slim) = slim
            && self.best.as_ref().is_none_or(|best| size(&slim) < size(best))
        {
            self.best = Some(slim);
        }
        Ok(count)
    }
}
