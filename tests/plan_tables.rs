//! The printed plans, number by number: Esmaeili 2021 (Tables 4-1, 5-3, 5-4, the hemisphere of ch. 4.6.2) and Spaan 1995 (Table 3.1, spectra of ch. 5).

use ncfix_base::geometry::{Axis, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::Kind;
use ncfix_metrology::measure::plan::builder::Builder;
use ncfix_metrology::measure::plan::{Wishes, find};

use crate::support::machine;

/// Table 4-1: angles of spindle, B and C, and the balls, in the order of the indices 1 to 32.
const TABLE_4_1: &str = "0 10 30 345|0 30 90 345|0 50 150 345|0 70 210 345|0 90 270 3456|0 60 180 345|0 40 120 346|0 20 60 346|\
    0 -10 -30 345|0 -30 -90 345|0 -50 -150 345|0 -70 -210 345|0 -90 -270 3456|0 -60 -180 345|0 -40 -120 346|0 -20 -60 346|\
    0 0 90 123456|0 0 240 345|0 0 300 345|0 0 180 123456|0 0 45 123456|0 0 -45 123456|0 0 -180 123456|0 0 -300 345|\
    0 0 -240 345|0 0 -90 123456|0 0 0 123456|60 0 0 3|120 0 0 3|180 0 0 3|240 0 0 3|300 0 0 3";

/// Table 5-3: A and C, row by row; the same for four balls.
const TABLE_5_3: &str = "15 60|30 180|45 280|55 340|40 240|20 120|0 0|-20 -100|-40 250|-55 350|-50 -310|-25 -40|0 180|0 280|0 360|0 320|\
    0 210|0 -160|0 -300|0 -220|0 -50|15 0|40 0|55 0|45 0|30 0|-20 0|-45 0|-55 0|-35 0|44 -30|53 -208|36 -318|30 45|21 326|9 290|\
    -16 -12|-54 -304|-40 -10|-17 100|-38 197|-5 345";

/// Table 5-4: A and C of the validation with one ball.
const TABLE_5_4: &str = "8 55|16 120|40 180|38 240|55 300|50 330|45 270|36 210|23 150|12 90|4 30|-5 -30|-12 -90|-28 -150|-31 -210|-48 -270|\
    -52 -330|-5 -300|-43 -240|-34 -180|-23 -120|-11 -55|8 140|18 190|12 250|30 290|22 310|47 10|24 50|38 100|41 160|53 200|\
    -34 -45|-43 -140|-50 -170|-20 -220|-15 -280|-10 -310|-5 -70|-16 135|-50 280|-36 94|-10 20|-26 200|28 -40|50 -300|20 -280|37 -100|\
    10 -280|0 0|0 90|0 240|0 300|0 180|0 45|0 -45|0 -180|0 -300|0 -240|0 -90";

fn loaded(name: &str) -> Machine {
    let source = Source::new(FileId(0), name, std::fs::read(machine(name)).unwrap()).unwrap();
    ncfix_model::file::load(&source).0.unwrap().0
}

fn build(kind: &str, machine: &Machine, wishes: &Wishes) -> Builder {
    (find(kind).unwrap().build)(machine, wishes).unwrap_or_else(|refused| panic!("{kind}: {refused}"))
}

fn of(variant: &str) -> Wishes {
    Wishes { variant: Some(variant.into()), tools_mm: vec![Vector::new(0.0, 0.0, -100.0)], ..Wishes::default() }
}

fn integers(text: &str) -> Vec<i64> {
    text.split_whitespace().map(|word| word.parse().unwrap()).collect()
}

fn degrees(plan: &Builder, row: usize, axis: Axis) -> i64 {
    let value = plan.data.observations[row].reading.position[axis].to_degrees();
    assert!((value - value.round()).abs() < 1e-6);
    value.round() as i64
}

#[test]
fn table_4_1() {
    let plan = build("probe", &loaded("esmaeili_xyz5"), &of("samba"));
    let mut row = 0;
    for index in TABLE_4_1.split('|') {
        let words: Vec<&str> = index.split_whitespace().collect();
        for ball in words[3].bytes() {
            let [spindle, b, c] = [0, 1, 2].map(|k| words[k].parse::<i64>().unwrap());
            assert_eq!((degrees(&plan, row, Axis::B), degrees(&plan, row, Axis::C)), (b, c), "{index}");
            let observation = &plan.data.observations[row];
            assert_eq!(observation.target, Some(usize::from(ball - b'1')), "{index}");
            assert_eq!(plan.data.setups[observation.setup].label, format!("S{spindle}"), "{index}");
            row += 1;
        }
    }
    assert_eq!((row, plan.data.observations.len()), (109, 109));
}

#[test]
fn tables_5_3_and_5_4() {
    for (variant, table, balls, count) in [("rumba", TABLE_5_3, 4, 42), ("rumba-check", TABLE_5_4, 1, 60)] {
        let plan = build("probe", &loaded("esmaeili_huron"), &of(variant));
        let pairs: Vec<Vec<i64>> = table.split('|').map(integers).collect();
        assert_eq!(pairs.len(), count);
        assert_eq!(plan.data.observations.len(), balls * count);
        for row in 0..balls * count {
            let pair = vec![degrees(&plan, row, Axis::A), degrees(&plan, row, Axis::C)];
            assert_eq!(pair, pairs[row % count], "{variant} row {row}");
            assert_eq!(plan.data.observations[row].target, Some(row / count));
        }
    }
}

/// Moves of a path that are straight and not at rapid.
fn feeds(plan: &Builder) -> Vec<Vector> {
    let moves = plan.path.iter().filter_map(|kind| if let Kind::Move(motion) = kind { Some(motion) } else { None });
    moves.filter(|motion| !motion.rapid).map(|motion| motion.target.xyz()).collect()
}

#[test]
fn the_hemisphere_of_the_validation_has_as_many_chords_as_printed() {
    // Rows every 6° are whole numbers of chords on all arcs.
    let every = Some(6_f64.to_radians());
    let wishes = Wishes { radius_mm: Some(150.0), every, ..of("esmaeili") };
    let plan = build("sphere", &loaded("demo"), &wishes);
    // Five meridians forth and back and half of the equator: eleven times 180° in steps of 0.1°; the paper has 19 809 positions in all.
    let path = feeds(&plan);
    assert_eq!(path.len(), 1 + 11 * 1800);
    assert!(path.len() <= 19_809 && path.len() + 10 > 19_809);
    let centre = plan.data.setups[0].centre_mm + Vector::new(0.0, 0.0, 100.0);
    let (first, last) = (path[0] - centre, path[path.len() - 1] - centre);
    // It ends across from where it began.
    assert!((first + last).norm() < 1e-3, "{first} {last}");
    assert!(
        path.windows(2).all(|pair| (pair[1] - pair[0]).norm() < 2.0 * 150.0 * (0.05_f64.to_radians()).sin() + 3e-4)
    );
    // Every meridian passes the pole twice.
    let poles = path.iter().filter(|point| (*point - centre - Vector::new(0.0, 0.0, 150.0)).norm() < 1e-3).count();
    assert_eq!(poles, 10);
    assert_eq!(plan.extras.iter().filter(|extra| extra.feed == Some(200.0)).count(), plan.extras.len());
}

#[test]
fn table_3_1() {
    // Experiment, radius, centre, tool.
    let printed = "4 300 300 80 300 110|14 150 300 80 300 110|27 300 400 190 300 110|29 250 400 190 300 110|89 300 50 80 300 110|\
        99 150 350 210 300 245|105 300 350 210 300 245|137 300 350 210 0 245";
    let machine = loaded("maho700s");
    let plan = build("sphere", &machine, &Wishes { chord: Some(0.08), ..of("spaan") });
    for (number, (line, setup)) in printed.split('|').zip(&plan.data.setups).enumerate() {
        let values = integers(line);
        assert_eq!(setup.label, values[0].to_string());
        assert_eq!(setup.length_mm, values[1] as f64);
        assert_eq!(setup.centre_mm, Vector::new(values[2] as f64, values[3] as f64, values[4] as f64));
        let rows: Vec<_> = plan.data.observations.iter().filter(|row| row.setup == number).collect();
        // 217 points on a whole hemisphere; what is left is on the sphere, above its centre, and within the travel less the margin.
        assert!((40..=217).contains(&rows.len()), "{} points of sphere {}", rows.len(), setup.label);
        for row in rows {
            assert_eq!(row.reading.tool_mm, Vector::new(0.0, 0.0, -values[5] as f64));
            let off = row.reading.position.xyz() + row.reading.tool_mm - setup.centre_mm;
            assert!((off.norm() - setup.length_mm).abs() < 2e-3 && off.y > -1e-3, "{off}");
        }
    }
    assert_eq!(plan.data.setups.len(), 8);
    // The first is within X and Y as a whole; behind the spindle's reach along Z is what is left out.
    for motion in plan.path.iter().filter_map(|kind| if let Kind::Move(motion) = kind { Some(motion) } else { None }) {
        for axis in [Axis::X, Axis::Y, Axis::Z] {
            let [low, high] = machine.axis(axis).unwrap().travel.unwrap();
            assert!((low + 2.0 - 1e-6..=high - 2.0 + 1e-6).contains(&motion.target[axis]));
        }
    }
    assert!(plan.notes.iter().any(|note| note.contains("outside the travel and omitted")), "{:?}", plan.notes);
}

/// Speeds, each as long as it lasts, min.
fn stages(plan: &Builder) -> Vec<(f64, usize)> {
    let mut out: Vec<(f64, usize)> = Vec::new();
    for extra in plan.extras.iter().skip(1) {
        let speed = extra.speed.unwrap();
        match out.last_mut() {
            Some((last, count)) if *last == speed => *count += 1,
            _ => out.push((speed, 1)),
        }
    }
    out
}

#[test]
fn spectra() {
    let machine = loaded("maho700s");
    let levels = |variant: &str| {
        let plan = build("drift", &machine, &of(variant));
        let minutes: Vec<f64> = plan.extras.iter().skip(1).map(|extra| extra.speed.unwrap() / 6300.0 * 100.0).collect();
        minutes.chunks(15).map(|level| level.iter().all(|one| one == &level[0]).then_some(level[0])).collect::<Vec<_>>()
    };
    // Steps of 25 % of 6300 1/min, 15 min each; from 135 min on 25 % for 30 min, which the changed spectrum makes 15 min, so that its twelfth level is
    // the highest speed.
    for variant in ["din", "pseudo-din"] {
        let levels = levels(variant);
        assert!(levels.iter().all(|level| level.is_some_and(|level| (level / 25.0).fract() == 0.0)), "{levels:?}");
        for percent in [0.0, 25.0, 50.0, 75.0, 100.0] {
            assert!(levels.contains(&Some(percent)), "{percent}");
        }
        assert_eq!(levels[9], Some(25.0));
    }
    let (din, pseudo) = (levels("din"), levels("pseudo-din"));
    assert_eq!(din[10], Some(25.0));
    assert_ne!(din[8], Some(25.0));
    assert_ne!(pseudo[10], Some(25.0));
    assert_eq!(pseudo[11], Some(100.0));
    let without: Vec<_> = din.iter().enumerate().filter(|(number, _)| *number != 10).map(|(_, level)| *level).collect();
    assert_eq!(without, pseudo);
    for seed in 1..20 {
        let random = stages(&build("drift", &machine, &Wishes { seed, ..of("random") }));
        assert_eq!(random.iter().map(|(_, minutes)| minutes).sum::<usize>(), 24 * 60);
        let (_, whole) = random.split_last().unwrap();
        assert!(whole.iter().all(|(speed, minutes)| *minutes >= 5 && (*minutes <= 45 || *speed == 0.0)));
        assert!(random.iter().all(|(speed, _)| *speed == 0.0 || (800.0..=6300.0).contains(speed)));
    }
}

/// Spaan, Fig. 5.5: 6000 1/min for 24 h, then 24 h without; Figs. 8.6 and 8.7: a stop after 360 min.
#[test]
fn a_constant_speed_is_followed_by_as_long_a_standstill() {
    let machine = loaded("maho700s");
    let day = build("drift", &machine, &of("steady"));
    assert_eq!(stages(&day), [(6000.0, 24 * 60), (0.0, 24 * 60)]);
    // A reading every minute, and the one before the spindle starts.
    assert_eq!(day.data.observations.len(), 2 * 24 * 60 + 1);
    let short = build("drift", &machine, &Wishes { hours: Some(6.0), speed: Some(4500.0), ..of("steady") });
    assert_eq!(stages(&short), [(4500.0, 360), (0.0, 360)]);
    // M0 before the way to the sensors, and before they are zeroed. The spindle is started once and stopped once: M3 with its speed, M5 alone.
    let orders: Vec<usize> = short
        .path
        .iter()
        .filter_map(|kind| if let Kind::Before(words) = kind { Some(words.len()) } else { None })
        .collect();
    assert_eq!(orders, [1, 1, 2, 1]);
}

#[test]
fn plates_have_a_set_up_for_every_tool_and_place() {
    let machine = loaded("demo");
    let [short, side] = [Vector::new(0.0, 0.0, -100.0), Vector::new(0.0, 60.0, -80.0)];
    let centres = vec![Vector::new(300.0, 200.0, 100.0), Vector::new(400.0, 300.0, 100.0)];
    let wishes =
        Wishes { tools_mm: vec![short, side], centres_mm: centres.clone(), points: Some(3), ..Wishes::default() };
    let plan = build("plate", &machine, &wishes);
    let labels: Vec<&str> = plan.data.setups.iter().map(|setup| setup.label.as_str()).collect();
    assert_eq!(labels, ["T1P1", "T1P2", "T2P1", "T2P2"]);
    assert_eq!(plan.data.observations.len(), 4 * 9);
    for (number, row) in plan.data.observations.iter().enumerate() {
        assert_eq!(row.setup, number / 9);
        let off = row.reading.position.xyz() + row.reading.tool_mm - centres[number / 9 % 2];
        assert!(off.z.abs() < 1e-9 && off.x.abs() < 50.0 + 1e-9 && off.y.abs() < 50.0 + 1e-9);
    }
    // The further poses belong to their own set-ups.
    assert_eq!(plan.candidates.iter().map(|row| row.setup).max(), Some(3));
}

#[test]
fn weights_are_put_on_and_taken_off() {
    let machine = loaded("maho700s");
    let places = vec![Vector::new(350.0, 0.0, -280.0), Vector::new(350.0, 0.0, 280.0)];
    let wishes = Wishes {
        forces_n: vec![1700.0, 4800.0],
        places_mm: places.clone(),
        components: vec!["EAX".parse().unwrap()],
        points: Some(5),
        ..Wishes::default()
    };
    let plan = build("load", &machine, &wishes);
    let mut loads: Vec<(f64, Vector)> = plan.extras.iter().map(|extra| extra.load.unwrap()).collect();
    assert_eq!(loads.len(), 6 * 2 * 5);
    loads.dedup();
    let none = (0.0, Vector::zeros());
    let expected = [none, (1700.0, places[0]), (4800.0, places[0]), (1700.0, places[1]), (4800.0, places[1]), none];
    assert_eq!(loads, expected);
    let text = ncfix_metrology::measure::plan::table::csv(&plan);
    let header: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let at = header.iter().position(|name| *name == "load_N").unwrap();
    assert_eq!(header[at..at + 4], ["load_N", "load_x_mm", "load_y_mm", "load_z_mm"]);
    let row: Vec<&str> = text.lines().nth(11).unwrap().split(',').collect();
    assert_eq!(row[at..at + 4], ["1700", "350", "0", "-280"]);
    let refused = (find("load").unwrap().build)(&machine, &Wishes::default());
    assert!(refused.unwrap_err().to_string().contains("--force"));
}
