//! Benches: what an afternoon with an instrument measures, as sheets of rows, used and held out.

mod ballbar;
mod drift;
mod five;
mod laser;
mod load;
mod plate;

use super::machine::Machine;
use super::random::Random;
use super::row::{Kind, Row, Setup, Sheet};

/// A kind of afternoon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bench {
    /// Laser, level and straightedge on three linear axes, at rest.
    Laser,
    /// Laser while the axes move at several feeds.
    OnTheFly,
    /// Circles in three planes.
    Ballbar,
    /// Hole plate in several placements.
    Plate,
    /// A day of spindle speeds at one or three places.
    Drift,
    /// Several runs in one set-up, the instrument set to zero for each: by the seed on days that begin at rest, or in the course of one day with a
    /// clock that begins again or goes on.
    DriftRuns,
    /// Level and straightedge with loads.
    Load,
    /// Chase the ball with five axes.
    FiveAxis,
    /// Plate and laser at several temperatures.
    HotCold,
}

/// The benches of the table of rates.
pub(crate) const BENCHES: [Bench; 8] = [
    Bench::Laser,
    Bench::OnTheFly,
    Bench::Ballbar,
    Bench::Plate,
    Bench::Drift,
    Bench::Load,
    Bench::FiveAxis,
    Bench::HotCold,
];

/// Machine and sheets.
#[derive(Debug)]
pub(crate) struct Plan {
    pub(crate) machine: Machine,
    /// Those that are given and, behind them, those that are held out.
    pub(crate) sheets: Vec<Sheet>,
    pub(crate) used: usize,
}

/// The plan of a bench; `fineness` multiplies how densely it samples where that is free to choose.
pub(crate) fn plan(bench: Bench, fineness: f64, seed: u64) -> Plan {
    let random = &mut Random::new(seed, "plan");
    let mill = Machine::mill(seed);
    let (machine, used, held) = match bench {
        Bench::Laser => {
            let held = laser::at_rest(random, "held_", &[0], 2);
            (mill, laser::at_rest(random, "", &[1, 2], 5), held)
        }
        Bench::OnTheFly => {
            let used = vec![laser::moving(random, "fly", &[100.0, 1000.0, 6000.0], fineness)];
            (mill, used, vec![laser::moving(random, "held_fly", &[400.0, 3000.0], fineness)])
        }
        Bench::Ballbar => {
            let used = ballbar::sheet(random, "ballbar", &[1000.0, 3000.0], &[100.0, 150.0], 1.0 / fineness, seed);
            let held = ballbar::sheet(random, "held_ballbar", &[1500.0, 2500.0], &[150.0], 1.0 / fineness, seed);
            (mill, vec![used], vec![held])
        }
        Bench::Plate => {
            let used = plate::sheet(random, "plate", &[(0.0, 50.0), (90.0, 50.0), (30.0, 250.0)]);
            (mill, vec![used], vec![plate::sheet(random, "held_plate", &[(-20.0, 150.0), (70.0, 30.0)])])
        }
        Bench::Drift => {
            let places = if seed.is_multiple_of(2) { 1 } else { 3 };
            let sensors = 6 + (seed % 7) as usize;
            let [used, held] =
                ["drift", "held_drift"].map(|stem| drift::sheet(random, stem, places, sensors, fineness));
            (mill, vec![used], vec![held])
        }
        Bench::DriftRuns => {
            let sensors = 4 + (seed % 4) as usize;
            let [used, held] = [("runs", 4), ("held_runs", 2)]
                .map(|(stem, count)| drift::runs(random, stem, (count, seed % 3), sensors, fineness));
            (mill, vec![used], vec![held])
        }
        Bench::Load => (Machine::mill(0), load::sheets(random, "", false), load::sheets(random, "held_", true)),
        Bench::FiveAxis => {
            let machine = Machine::five_axis();
            let used = five::sheet(&machine, random, "probe", &[-60.0, -25.0, 0.0, 30.0, 60.0], 12);
            let held = five::sheet(&machine, random, "held_probe", &[-45.0, 10.0, 50.0], 7);
            (machine, vec![used], vec![held])
        }
        Bench::HotCold => (mill, drift::hot_and_cold(random, "", 3), drift::hot_and_cold(random, "held_", 2)),
    };
    let count = used.len();
    let mut sheets: Vec<Sheet> = used.into_iter().chain(held).collect();
    for (day, sheet) in sheets.iter_mut().enumerate() {
        sheet.rows.iter_mut().for_each(|row| row.day = day);
        mount(sheet, random);
    }
    Plan { machine, sheets, used: count }
}

/// What nobody knows of the set-ups: always there, so that no effect is found by its absence.
fn mount(sheet: &mut Sheet, random: &mut Random) {
    let has: Vec<&str> = sheet.free.clone();
    let angles = sheet.angles;
    for setup in &mut sheet.setups {
        if has.contains(&"centre") {
            setup.off_centre = random.normal3(0.015);
        }
        if has.contains(&"length") {
            setup.off_length = 0.004 * random.normal();
        }
        if has.contains(&"tool") {
            setup.stylus = random.normal3(0.008);
        }
        if has.contains(&"rotation") {
            setup.turn = random.normal3(60e-6);
        }
        if has.contains(&"offset") && sheet.kind == Kind::Displacement {
            setup.offset = random.normal3(0.03);
        }
        if has.contains(&"offset") && sheet.kind == Kind::Direct {
            for zero in setup.zero.iter_mut().flatten() {
                *zero = if angles { 20e-6 } else { 0.01 } * random.normal();
            }
        }
    }
}

/// Adds a set-up with a label and gives its number.
fn add_setup(sheet: &mut Sheet, label: &str) -> usize {
    sheet.setups.push(Setup { label: label.to_owned(), ..Setup::default() });
    sheet.setups.len() - 1
}

/// Puts the axes where the commanded tool point is at a place.
fn to_point(row: &mut Row, point: [f64; 3]) {
    (0..3).for_each(|k| row.q[k] = point[k] - row.tool[k]);
}
