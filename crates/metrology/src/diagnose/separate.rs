//! Measurements that separate a cause from its other explanations. A proposed measurement differs from those in the data.

use std::collections::BTreeMap;

use super::cause::{Candidate, Causes, EffectKind, periodic};
use super::nature::Nature;
use super::row::SceneRow;
use super::scene::{Scene, Through};
use super::size::is_angle;
use super::verdict::propose;
use crate::measure::kind::Measurand;
use ncfix_base::geometry::{AXES, Axis, Vector};
use ncfix_model::name::{DIRECTIONS, ErrorKind, ErrorName};

/// Number of steps in the shortest period.
const STEPS: f64 = 3.0;
/// A step that shows all pitches of ball screws, mm.
const MOST_STEP: f64 = 2.0;
/// Distance of points in a plan for waves, mm: with uneven steps, they resolve a pitch of a sixth of it.
const FINE: f64 = 20.0;
/// A feed at which lags are small, mm/min, and the column of feeds.
const SLOW: f64 = 500.0;
const FEED: &str = "feed_mm_min";
/// Column of spindle speeds.
const SPEED: &str = "spindle_rpm";
/// Lengths, feeds and speeds are equal if they differ by less than this share.
const OTHER: f64 = 0.1;
/// Additional length of a second tool, mm.
pub(super) const LONGER: f64 = 60.0;
/// Number of steps of a grid along a side.
const HOLES: f64 = 4.0;
/// Share of the side that a grid covers.
const WIDE: f64 = 0.8;

/// Returns the measurement that separates a cause from its first other explanation, and the command that plans it, if there is one.
pub(super) fn separating(scene: &Scene<'_>, one: &Candidate, rival: &Candidate) -> String {
    let effects = [one.cause.effect, rival.cause.effect];
    // Of an angle and a displacement over two axes, the arm of the angle decides, as it does over one axis.
    let is_by_arm = effects == [EffectKind::Cross; 2] && is_angle(one) != is_angle(rival);
    let (sentence, plan) = told_apart(if is_by_arm { [EffectKind::Motion; 2] } else { effects });
    // An offset or a tilt of a rotary axis or of the spindle shows when that axis turns.
    let turns = |candidate: &Candidate| {
        let name = candidate.columns.iter().flatten().find_map(|(through, _)| match through {
            Through::Component(name) if name.kind == ErrorKind::Location => Some(*name),
            _ => None,
        });
        name.is_some_and(|name| name.axis().is_none_or(Axis::is_rotary))
    };
    let has_rotary = scene.machine.axes.iter().flatten().any(|data| data.axis.is_rotary());
    let (sentence, plan) = if has_rotary && turns(one) && one.cause.effect == rival.cause.effect {
        (Some(BALLS), Some(SeparatingPlan::Balls))
    } else {
        (sentence, plan)
    };
    // A cause with a place gives it; otherwise that of the other explanation is used.
    let around = Around::new(scene, one).or_else(|| Around::new(scene, rival));
    let sentence = sentence.unwrap_or(one.cause.separate_by);
    let Some(plan) = plan else { return sentence.to_owned() };
    let Some(around) = around else { return sentence.to_owned() };
    let measured = Measured::new(scene, &around);
    if !measured.has(plan) {
        return with_command(sentence.to_owned(), around.command(plan));
    }
    // The data contain this measurement already: another view of the same errors.
    let other = OTHERS.iter().find(|(_, other)| !measured.has(*other) && around.command(*other).is_some());
    match other {
        Some((sentence, plan)) => with_command((*sentence).to_owned(), around.command(*plan)),
        None => AGAIN.to_owned(),
    }
}

const BALLS: &str = "the balls again with a second tool length: the effect of a tilt increases with the arm, that of an offset does not";

/// Measurements that show the same errors in another way, the most informative first.
const OTHERS: [(&str, SeparatingPlan); 5] = [
    (
        "the same poses with a second tool length: the effect of an angle increases with the arm, that of a displacement does not",
        SeparatingPlan::Heights,
    ),
    ("a grid of points over the travel, which shows each axis along its whole length", SeparatingPlan::Grid),
    ("circles in both directions", SeparatingPlan::Circles),
    ("the line of the axis in both directions", SeparatingPlan::Line),
    ("circles of another radius", SeparatingPlan::SmallCircles),
];
/// Returns the measurement of a line along the axis of an error, and the command that plans it.
pub(super) fn line_along(scene: &Scene<'_>, one: &Candidate) -> String {
    let command = Around::new(scene, one).and_then(|around| around.command(SeparatingPlan::Line));
    with_command("the positioning of one axis".to_owned(), command)
}

/// Fallback if no other measurement remains.
const AGAIN: &str =
    "the same measurement again, with more readings: the data are too few or too noisy to separate them";

/// Returns every command that may be proposed for the possible causes in a scene.
#[must_use]
pub fn commands(causes: &Causes, scene: &Scene<'_>) -> Vec<String> {
    let mut all = propose(causes, scene);
    all.extend(
        super::cause::axes(scene)
            .filter(|axis| !axis.is_rotary())
            .map(|axis| periodic::candidate(ErrorName::motion(DIRECTIONS[axis.dimension()], axis), axis, 10.0)),
    );
    let mut out: Vec<String> = Vec::new();
    for one in &all {
        let Some(around) = Around::new(scene, one) else { continue };
        let plans = causes.iter().filter_map(|cause| told_apart([one.cause.effect, cause.cause().effect]).1);
        out.extend(
            plans.chain([SeparatingPlan::FineLine, SeparatingPlan::Drift]).filter_map(|plan| around.command(plan)),
        );
        out.sort();
        out.dedup();
    }
    out
}

fn with_command(sentence: String, command: Option<String>) -> String {
    match command {
        Some(command) => format!("{sentence} ({command})"),
        None => sentence,
    }
}

/// Kinds of measurements that `ncfix plan` writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SeparatingPlan {
    /// Circles in both directions.
    Circles,
    /// Circles at another feed, with another radius.
    SlowCircles,
    SmallCircles,
    /// A line in uneven steps, in both directions.
    Line,
    /// A line at another feed.
    SlowLine,
    /// A line in many steps.
    FineLine,
    /// A grid of holes, also with a longer tool.
    Grid,
    Heights,
    /// Balls on the table in poses of the rotary axes, with a longer tool.
    Balls,
    /// Random speeds of the spindle.
    Drift,
}

/// Returns the measurement that separates causes of two effects, in either order, and its plan.
fn told_apart(pair: [EffectKind; 2]) -> (Option<&'static str>, Option<SeparatingPlan>) {
    let is = |a, b| pair == [a, b] || pair == [b, a];
    let both = |a| pair == [a, a];
    let (sentence, plan) = if is(EffectKind::Location, EffectKind::ServoMismatch) {
        (
            "the circle in the other direction: squareness does not change, a servo mismatch changes its sign",
            SeparatingPlan::Circles,
        )
    } else if is(EffectKind::Backlash, EffectKind::Following) || is(EffectKind::Backlash, EffectKind::Delay) {
        ("the same line at another feed: a lag changes with the feed, backlash does not", SeparatingPlan::SlowLine)
    } else if is(EffectKind::Backlash, EffectKind::LateralPlay)
        || both(EffectKind::LateralPlay)
        || both(EffectKind::Backlash)
    {
        (
            "both directions with two tool lengths, and with an indicator along and across: the effect of a rotation of the carriage increases with the tool length",
            SeparatingPlan::Line,
        )
    } else if is(EffectKind::Backlash, EffectKind::Motion) {
        (
            "the same line in both directions at every position: backlash reverses with the direction, a motion error does not",
            SeparatingPlan::Line,
        )
    } else if is(EffectKind::Motion, EffectKind::ThermalExpansion) {
        ("the same lines at another temperature", SeparatingPlan::Line)
    } else if is(EffectKind::Location, EffectKind::ThermalSquareness) {
        ("the same lines at another temperature", SeparatingPlan::Grid)
    } else if is(EffectKind::Location, EffectKind::Setup) || is(EffectKind::Location, EffectKind::Probe) {
        return (
            Some("the length and the pre-travel of the probe set on a calibrated sphere or ring, then the same poses"),
            None,
        );
    } else if is(EffectKind::Motion, EffectKind::Setup) {
        ("the same line with the artifact shifted along it and turned by 90°", SeparatingPlan::Line)
    } else if is(EffectKind::Motion, EffectKind::Cross) {
        ("lines at three positions of the other axis", SeparatingPlan::Grid)
    } else if is(EffectKind::Motion, EffectKind::Periodic) {
        ("steps of an eighth of the period over three periods", SeparatingPlan::FineLine)
    } else if is(EffectKind::Motion, EffectKind::Location) {
        ("lines at two heights, and at the ends of the other axis", SeparatingPlan::Heights)
    } else if both(EffectKind::Motion) {
        (
            "the same lines at two positions of the other axes, and with a second tool length: the effect of an angle increases with its arm, that of a displacement does not",
            SeparatingPlan::Heights,
        )
    } else if both(EffectKind::Location) {
        ("the same poses with a second tool length, and the artifact turned by 90°", SeparatingPlan::Heights)
    } else if is(EffectKind::ThermalDrift, EffectKind::Drift)
        || both(EffectKind::ThermalDrift)
        || both(EffectKind::Drift)
    {
        (
            "a run in which the temperatures do not rise together: spindle on and off at random, then cooling",
            SeparatingPlan::Drift,
        )
    } else if is(EffectKind::ThermalDrift, EffectKind::ThermalExpansion) {
        return (Some("two poses far apart along the axis, in turn, while it warms up"), None);
    } else if both(EffectKind::ServoMismatch)
        || is(EffectKind::ServoMismatch, EffectKind::Following)
        || both(EffectKind::Following)
    {
        ("circles in the planes of the other axes at the same feed", SeparatingPlan::Circles)
    } else if is(EffectKind::Following, EffectKind::Dynamic) {
        (
            "another radius at the same feed: a lag depends on the velocity, a deflection on its square over the radius",
            SeparatingPlan::SmallCircles,
        )
    } else if is(EffectKind::Periodic, EffectKind::Dynamic) {
        (
            "another feed: a vibration moves along the path, an error that is periodic in position does not",
            SeparatingPlan::SlowCircles,
        )
    } else if pair[0] == EffectKind::Cross {
        return (None, Some(SeparatingPlan::Grid));
    } else if pair.map(Nature::of_effect).into_iter().flatten().filter(|own| *own == Nature::Instrument).count() == 1 {
        return (
            Some(
                "the same poses with the instrument set up anew, or with another one: an error of the machine stays, that of an instrument does not",
            ),
            None,
        );
    } else {
        return by_nature(pair).map_or((None, None), |(sentence, plan)| (Some(sentence), Some(plan)));
    };
    (Some(sentence), Some(plan))
}

/// Returns the measurement that separates causes that depend on different things, in either order: it changes one of these and keeps the other.
fn by_nature(pair: [EffectKind; 2]) -> Option<(&'static str, SeparatingPlan)> {
    let [one, other] = pair.map(Nature::of_effect);
    let is = |a, b| [one, other] == [Some(a), Some(b)] || [one, other] == [Some(b), Some(a)];
    if is(Nature::Place, Nature::Time) || is(Nature::Sense, Nature::Time) {
        Some((
            "the same positions forward, backward and once more after a pause: a drift continues with the time, an error of the axis returns with the position",
            SeparatingPlan::Line,
        ))
    } else if is(Nature::Speed, Nature::Time) {
        Some(("the same path at another feed, and once more after a pause", SeparatingPlan::SlowCircles))
    } else if is(Nature::Place, Nature::Speed) {
        Some((
            "the circle in the other direction and at another feed: an error of the position does not change, a lag does",
            SeparatingPlan::Circles,
        ))
    } else if is(Nature::Place, Nature::Sense) {
        Some((
            "the same positions in both directions: a reversal error changes with the direction, an error of the position does not",
            SeparatingPlan::Line,
        ))
    } else if is(Nature::Sense, Nature::Speed) {
        Some((
            "the same path at another feed: a lag changes with the feed, a reversal error does not",
            SeparatingPlan::SlowCircles,
        ))
    } else {
        None
    }
}

/// Place of an error, and the data that a plan needs.
struct Around {
    /// The linear axis of the error, and its range.
    axis: Axis,
    travel: [f64; 2],
    /// Component of its motion.
    name: Option<ErrorName>,
    /// Linear axes of the plane in which it shows, and the shorter travel.
    plane: &'static str,
    side_mm: f64,
    tool_mm: f64,
    feed: Option<f64>,
}

impl Around {
    fn new(scene: &Scene<'_>, one: &Candidate) -> Option<Around> {
        let name = one.columns.iter().flatten().find_map(|(through, _)| match through {
            Through::Component(name) => Some(*name),
            _ => None,
        });
        let is_linear = |axis: &Axis| !axis.is_rotary() && scene.machine.axis(*axis).is_some();
        let driver = |driver: &String| {
            let letter = driver.strip_suffix("_dir").unwrap_or(driver);
            AXES.into_iter().find(|axis| axis.to_string() == *letter)
        };
        let drivers: Vec<Axis> = one.drivers.iter().filter_map(driver).filter(is_linear).collect();
        let own = name.filter(|name| name.kind == ErrorKind::Motion).and_then(|name| name.axis());
        let across = name.map(|name| name.direction.index());
        let mut dimensions: Vec<usize> = own.iter().chain(&drivers).map(|axis| axis.dimension()).collect();
        match across {
            Some(across) if across < 3 => dimensions.push(across),
            Some(turned) => dimensions.extend([0, 1, 2].into_iter().filter(|k| *k != turned - 3)),
            None => {}
        }
        dimensions.extend([0, 1, 2]);
        let mut kept: Vec<usize> = Vec::new();
        dimensions.into_iter().for_each(|k| {
            if kept.len() < 2 && !kept.contains(&k) {
                kept.push(k)
            }
        });
        kept.sort_unstable();
        let plane = match kept.as_slice() {
            [0, 1] => "XY",
            [1, 2] => "YZ",
            _ => "ZX",
        };
        let linear = [Axis::X, Axis::Y, Axis::Z];
        let axis = own.filter(is_linear).or(drivers.first().copied());
        let axis = axis.or_else(|| kept.first().and_then(|&k| linear.get(k).copied()).filter(is_linear))?;
        let travel = |axis: Axis| scene.machine.axis(axis)?.travel;
        let sides = kept.iter().filter_map(|&k| linear.get(k).copied().and_then(travel));
        let side_mm = sides.map(|[low, high]| high - low).fold(f64::INFINITY, f64::min);
        let tool_mm = scene.rows.iter().map(|row| Vector::from(row.tool_mm).norm()).fold(0.0, f64::max);
        let feeds = scene.sets.iter().flat_map(|set| &set.drivers).filter(|driver| driver.name == FEED);
        let feed = feeds.flat_map(|driver| driver.values.iter().copied()).find(|feed| feed.is_finite());
        Some(Around {
            axis,
            travel: travel(axis)?,
            name: name.filter(|_| own.is_some()),
            plane,
            side_mm,
            tool_mm,
            feed,
        })
    }

    /// Returns the command that writes a plan; `None` if the axis has none.
    fn command(&self, plan: SeparatingPlan) -> Option<String> {
        let tool = hundredths(self.tool_mm);
        let tool = if tool > 0.0 { format!(" --tool {tool}") } else { String::new() };
        // Half of the measured feed, or a slow one.
        let feed = self.feed.map_or(SLOW, |feed| (feed / 2.0).max(1.0).round());
        let component = match self.name.filter(|name| name.axis() == Some(self.axis)) {
            Some(name) => format!(" --component {name}"),
            None => String::new(),
        };
        let length = self.travel[1] - self.travel[0];
        let line = format!("laser --axis {}{component}", self.axis);
        let own = match plan {
            SeparatingPlan::Circles => format!("ballbar --plane {}", self.plane),
            SeparatingPlan::SlowCircles => format!("ballbar --plane {} --feed {feed}", self.plane),
            SeparatingPlan::SmallCircles => format!("ballbar --plane {} --radius 50", self.plane),
            SeparatingPlan::Line => line,
            SeparatingPlan::SlowLine => format!("{line} --feed {feed}"),
            SeparatingPlan::FineLine => format!("{line} --points {}", (length / FINE).round().clamp(21.0, 201.0)),
            SeparatingPlan::Grid | SeparatingPlan::Heights => {
                let every = (self.side_mm * WIDE / HOLES / 10.0).floor() * 10.0;
                if !(every > 0.0 && every.is_finite()) {
                    return None;
                }
                // Readings without a tool vector are at the spindle nose, where no probe can be.
                let [short, longer] =
                    if self.tool_mm > 0.0 { [self.tool_mm, self.tool_mm + LONGER] } else { [LONGER, 2.0 * LONGER] };
                let [short, longer] = [short, longer].map(hundredths);
                let (first, second) = if plan == SeparatingPlan::Heights {
                    (format!(" --tool {short}"), format!(" --tool {longer}"))
                } else {
                    (tool.clone(), String::new())
                };
                return Some(format!(
                    "ncfix plan plate --plane {} --every {every}{first}{second} --machine M.toml -o PLAN.csv",
                    self.plane
                ));
            }
            SeparatingPlan::Balls => {
                let longer = hundredths(self.tool_mm + LONGER);
                return Some(format!("ncfix plan probe --tool {longer} --machine M.toml -o PLAN.csv"));
            }
            SeparatingPlan::Drift => "drift --variant random".to_owned(),
        };
        Some(format!("ncfix plan {own}{tool} --machine M.toml -o PLAN.csv"))
    }
}

/// Returns the kinds of measurements in a scene.
struct Measured {
    circles: bool,
    radii: bool,
    line: bool,
    feeds: bool,
    fine: bool,
    grid: bool,
    heights: bool,
    speeds: bool,
}

impl Measured {
    fn new(scene: &Scene<'_>, around: &Around) -> Measured {
        let kind = |row: &&SceneRow| scene.sets.get(row.set).map(|set| set.kind.measurand);
        let plane: Vec<Axis> =
            [Axis::X, Axis::Y, Axis::Z].into_iter().filter(|axis| around.plane.contains(&axis.to_string())).collect();
        let differ = |values: &mut dyn Iterator<Item = f64>, share: f64| {
            let [low, high] = values
                .filter(|value| value.is_finite())
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]);
            high > low && high - low > share * high.abs().max(low.abs())
        };
        let both = |rows: &[&SceneRow], axis: Axis| {
            [-1.0, 1.0].iter().all(|side| rows.iter().any(|row| row.sense_of(axis) == *side))
        };
        let moves = |rows: &[&SceneRow], axis: Axis| differ(&mut rows.iter().map(|row| row.position[axis]), 0.0);
        let of = |measurand: Measurand| -> Vec<&SceneRow> {
            scene.rows.iter().filter(|row| kind(row) == Some(measurand)).collect()
        };
        let bars: Vec<&SceneRow> = of(Measurand::BallDistance);
        let lengths = scene.sets.iter().filter(|set| set.kind.measurand == Measurand::BallDistance);
        let line: Vec<&SceneRow> = of(Measurand::Component)
            .into_iter()
            .filter(|row| around.name.is_none() || row.component == around.name)
            .collect();
        let mut places: Vec<i64> = line.iter().map(|row| (row.position[around.axis] * 1e3).round() as i64).collect();
        places.sort_unstable();
        places.dedup();
        let plates: Vec<&SceneRow> = of(Measurand::Displacement);
        let column = |name: &str| -> Vec<f64> {
            let drivers = scene.sets.iter().flat_map(|set| &set.drivers).filter(|driver| driver.name == name);
            drivers.flat_map(|driver| driver.values.iter().copied()).collect()
        };
        Measured {
            circles: plane.iter().all(|&axis| moves(&bars, axis) && both(&bars, axis))
                && turns_both_ways(&bars, &plane),
            radii: differ(&mut lengths.flat_map(|set| &set.setups).map(|setup| setup.length_mm), OTHER),
            line: moves(&line, around.axis) && both(&line, around.axis),
            feeds: differ(&mut column(FEED).into_iter(), OTHER),
            fine: places.len() as f64 >= (around.travel[1] - around.travel[0]) / FINE,
            grid: plane.iter().all(|&axis| moves(&plates, axis)),
            heights: differ(&mut scene.rows.iter().map(|row| Vector::from(row.tool_mm).norm()), OTHER),
            speeds: differ(&mut column(SPEED).into_iter(), OTHER),
        }
    }

    fn has(&self, plan: SeparatingPlan) -> bool {
        match plan {
            SeparatingPlan::Circles => self.circles,
            SeparatingPlan::SlowCircles => self.circles && self.feeds,
            SeparatingPlan::SmallCircles => self.circles && self.radii,
            SeparatingPlan::Line => self.line,
            SeparatingPlan::SlowLine => self.line && self.feeds,
            SeparatingPlan::FineLine => self.line && self.fine,
            SeparatingPlan::Grid => self.grid,
            SeparatingPlan::Heights | SeparatingPlan::Balls => self.heights,
            SeparatingPlan::Drift => self.speeds,
        }
    }
}

/// True if one sequence of rows turns in one direction in a plane, and another in the opposite one.
fn turns_both_ways(rows: &[&SceneRow], plane: &[Axis]) -> bool {
    let [first, second] = plane else { return false };
    let mut areas: BTreeMap<usize, f64> = BTreeMap::new();
    for pair in rows.windows(2).filter(|pair| pair[0].sequence == pair[1].sequence) {
        let at = |row: &SceneRow, axis: Axis| row.position[axis] - rows[0].position[axis];
        let [a, b] = [pair[0], pair[1]];
        *areas.entry(a.sequence).or_insert(0.0) += at(a, *first) * at(b, *second) - at(b, *first) * at(a, *second);
    }
    areas.values().any(|area| *area > 0.0) && areas.values().any(|area| *area < 0.0)
}

/// A wave of the same component with another period.
pub(super) fn every(parameter: &str, period: f64) -> String {
    format!("{parameter} every {} mm", hundredths(period))
}

/// Returns the measurement that separates a wave from a shorter one that is equal at the measured places.
pub(super) fn steps(scene: &Scene<'_>, one: &Candidate, shortest: f64) -> String {
    let longest = one.constant.map_or(shortest, |(period, _)| period.max(shortest));
    let step = hundredths((shortest / STEPS).min(MOST_STEP));
    let sentence = format!(
        "the same line at points of uneven spacing, or every {step} mm over {} mm",
        hundredths((3.0 * longest / step).ceil() * step)
    );
    with_command(sentence, Around::new(scene, one).and_then(|around| around.command(SeparatingPlan::FineLine)))
}

/// Rounds to hundredths.
pub(super) fn hundredths(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}
