//! Programs of plans on the four controls: what the executor makes of them is the path of the plan to 1e-6 mm, with a stop or a wait at every
//! reading, first away from the workpiece, and never through what is measured.

use ncfix_base::geometry::{AXES, Arc, AxisVector, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::{Kinematics, Machine};
use ncfix_machine::snc::{Dwell, Kind, WordValue};
use ncfix_metrology::measure::plan::builder::Builder;
use ncfix_metrology::measure::plan::{Wishes, find};

use crate::support::{Shop, machine};

/// A machine of every dialect, each with a rotary axis.
const MACHINES: [&str; 4] = ["esmaeili_xyz5", "maho700s", "vmc", "knee_mill"];

#[derive(Clone, Debug, PartialEq)]
enum Step {
    /// The axes that are known, by slot, mm and degrees; for an arc its sense.
    At([Option<f64>; 9], Option<bool>),
    Wait(f64),
    Stop,
    Line(String),
}

fn loaded(name: &str) -> Machine {
    let source = Source::new(FileId(0), name, std::fs::read(machine(name)).unwrap()).unwrap();
    ncfix_model::file::load(&source).0.unwrap().0
}

fn plans(machine: &Machine) -> Vec<(&'static str, Builder)> {
    let tool = Vector::new(0.0, 0.0, -120.0);
    let base = || Wishes { tools_mm: vec![tool], chord: Some(0.03), every: Some(0.1), seed: 1, ..Wishes::default() };
    let side = Vector::new(0.0, -60.0, -80.0);
    let cases = [
        ("ballbar", Wishes { chord: None, ..base() }),
        ("sphere", Wishes { radius_mm: Some(100.0), ..base() }),
        ("sphere", Wishes { radius_mm: Some(100.0), variant: Some("esmaeili".into()), ..base() }),
        ("probe", Wishes { every: None, points: Some(8), ..base() }),
        ("laser", Wishes { every: None, runs: Some(2), ..base() }),
        ("drift", Wishes { every: None, hours: Some(0.6), ..base() }),
        ("plate", Wishes { every: Some(30.0), points: Some(3), tools_mm: vec![tool, side], ..base() }),
        (
            "plate",
            Wishes {
                every: Some(30.0),
                planes: vec![ncfix_base::geometry::Plane::ZX],
                tools_mm: vec![side],
                points: Some(3),
                ..base()
            },
        ),
        ("load", Wishes { every: None, forces_n: vec![500.0, 900.0], ..base() }),
    ];
    cases.into_iter().map(|(name, wishes)| (name, (find(name).unwrap().build)(machine, &wishes).unwrap())).collect()
}

fn shown(position: &AxisVector, machine: &Machine) -> [Option<f64>; 9] {
    let mut out = [None; 9];
    for axis in AXES.into_iter().filter(|&axis| machine.axis(axis).is_some()) {
        let value = position[axis];
        out[axis.slot()] = Some(if axis.is_rotary() { value.to_degrees() } else { value });
    }
    out
}

/// The path of a plan; what does not move is left out.
fn planned(plan: &Builder, machine: &Machine) -> Vec<Step> {
    let mut out = Vec::new();
    for kind in &plan.path {
        match kind {
            Kind::Move(motion) => {
                let sense = motion.arc.map(|Arc { clockwise, .. }| clockwise);
                out.push(Step::At(shown(&motion.target, machine), sense));
            }
            Kind::Dwell(Dwell::Seconds(seconds)) => out.push(Step::Wait(*seconds)),
            Kind::Before(words)
                if words.iter().any(|word| word.letter == b'M' && word.value == WordValue::Number(0.0)) =>
            {
                out.push(Step::Stop);
            }
            Kind::Verbatim(line) => out.push(Step::Line(String::from_utf8(line.clone()).unwrap())),
            _ => {}
        }
    }
    out
}

/// The stream of a program.
fn run(machine: &Machine, on: &str, plan: &Builder) -> (String, Vec<Step>) {
    let text = ncfix_path::emit::flat(machine, "a plan", &plan.path).unwrap();
    let shop = Shop::new().file("test.nc", &text);
    let check = shop.run(["check", "test.nc", "--machine", on]).exits(0);
    assert!(!check.stderr.contains("[W02"), "{}", check.stderr);
    let stream = shop.run(["snc", "test.nc", "--machine", on]).exits(0).stdout;
    let mut out = Vec::new();
    for line in stream.lines() {
        let words: Vec<&str> = line.split(' ').take_while(|word| !word.starts_with(';')).collect();
        match words.first().copied() {
            Some(code @ ("G0" | "G1" | "G2" | "G3")) => {
                let mut at = [None; 9];
                for word in words.iter().skip(1) {
                    for axis in AXES.into_iter().filter(|&axis| machine.axis(axis).is_some()) {
                        if let Some(value) = word.strip_prefix(char::from(axis.letter())) {
                            at[axis.slot()] = value.parse().ok();
                        }
                    }
                }
                let sense = match code {
                    "G2" => Some(true),
                    "G3" => Some(false),
                    _ => None,
                };
                out.push(Step::At(at, sense));
            }
            Some("G4") => out.push(Step::Wait(words[1].trim_start_matches('S').parse().unwrap())),
            Some("M0") => out.push(Step::Stop),
            _ => {}
        }
    }
    (String::from_utf8(text).unwrap(), out)
}

fn is_same(one: &Step, other: &Step, slots: &[usize]) -> bool {
    match (one, other) {
        (Step::At(one, sense), Step::At(other, other_sense)) => {
            sense == other_sense && slots.iter().all(|&slot| (one[slot].unwrap() - other[slot].unwrap()).abs() < 1e-6)
        }
        (one, other) => one == other,
    }
}

/// Without moves to where the axes are.
fn moving(steps: Vec<Step>, slots: &[usize]) -> Vec<Step> {
    let mut last: Option<Step> = None;
    let mut out = Vec::new();
    for step in steps {
        if let Step::At(at, sense) = &step {
            let here = Step::At(*at, None);
            let stays = sense.is_none() && last.as_ref().is_some_and(|last| is_same(last, &here, slots));
            last = Some(here);
            if stays {
                continue;
            }
        }
        out.push(step);
    }
    out
}

#[test]
fn the_stream_of_every_program_is_the_path_of_its_plan() {
    for name in MACHINES {
        let loaded = loaded(name);
        let slots: Vec<usize> =
            AXES.iter().filter(|&&axis| loaded.axis(axis).is_some()).map(|axis| axis.slot()).collect();
        for (kind, plan) in plans(&loaded) {
            let what = format!("{name} {kind}");
            let (text, mut found) = run(&loaded, &machine(name), &plan);
            assert!(text.to_ascii_lowercase().contains("machine coordinates"), "{what}: the head says how");
            let mut path = planned(&plan, &loaded);
            // The first move leads away from the workpiece, wherever the others are.
            let first = |steps: &[Step]| steps.iter().position(|step| matches!(step, Step::At(..))).unwrap();
            let (own, other) = (path.remove(first(&path)), found.remove(first(&found)));
            let (path, found) = (moving(path, &slots), moving(found, &slots));
            let (Step::At(own, None), Step::At(other, None)) = (own, other) else { panic!("{what}") };
            assert!((own[2].unwrap() - other[2].unwrap()).abs() < 1e-6, "{what}");
            assert!(own[2].unwrap() > loaded.axes[2].as_ref().unwrap().travel.unwrap()[1] - 2.001, "{what}");
            for (number, (path, found)) in path.iter().zip(&found).enumerate() {
                assert!(is_same(path, found, &slots), "{what}: step {number} is {found:?} instead of {path:?}\n{text}");
            }
            assert_eq!(path.len(), found.len(), "{what}");
        }
    }
}

/// Positions of steps without repetition.
fn distinct(positions: impl Iterator<Item = [f64; 3]>) -> Vec<[f64; 3]> {
    let mut out: Vec<[f64; 3]> = positions.collect();
    out.dedup_by(|one, other| (0..3).all(|k| (one[k] - other[k]).abs() < 1e-6));
    out
}

#[test]
fn the_machine_waits_at_every_reading() {
    for name in MACHINES {
        let loaded = loaded(name);
        for (kind, plan) in plans(&loaded) {
            let rows = distinct(plan.data.observations.iter().map(|row| row.reading.position.xyz().into()));
            let mut here = [0.0; 3];
            let mut waits = Vec::new();
            let mut passed = Vec::new();
            for step in run(&loaded, &machine(name), &plan).1 {
                match step {
                    Step::At(at, _) => {
                        here = [0, 1, 2].map(|k| at[k].unwrap());
                        passed.push(here);
                    }
                    Step::Wait(_) => waits.push(here),
                    _ => {}
                }
            }
            let what = format!("{name} {kind}");
            let is_at = |one: &[f64; 3], other: &[f64; 3]| (0..3).all(|k| (one[k] - other[k]).abs() < 1e-6);
            match kind {
                "laser" | "plate" | "load" | "drift" => {
                    let waits = distinct(waits.into_iter());
                    assert_eq!(waits.len(), rows.len(), "{what}");
                    assert!(waits.iter().zip(&rows).all(|(one, other)| is_at(one, other)), "{what}");
                }
                "sphere" => {
                    // In their order.
                    let mut way = passed.iter();
                    assert!(rows.iter().all(|row| way.any(|at| is_at(at, row))), "{what}");
                }
                // Both senses of three circles, at rest before each.
                "ballbar" => assert_eq!(waits.len(), 6, "{what}"),
                _ => assert_eq!(waits.len(), 0, "{what}"),
            }
        }
    }
}

/// Where tip and shaft of the tool are on a straight way, in the workpiece.
fn swept(kinematics: &Kinematics, from: &AxisVector, to: &AxisVector, tool_mm: &Vector) -> Vec<Vector> {
    let mut out = Vec::new();
    for part in 0..=20 {
        let mut at = *from;
        for axis in AXES {
            at[axis] += (to[axis] - from[axis]) * f64::from(part) / 20.0;
        }
        for share in [1.0, 0.8, 0.6, 0.4, 0.2] {
            out.push(kinematics.tip_mm(&at, &(tool_mm * share)));
        }
    }
    out
}

#[test]
fn no_way_leads_through_what_is_measured() {
    for name in MACHINES {
        let loaded = loaded(name);
        let kinematics = Kinematics::new(&loaded);
        for (kind, plan) in plans(&loaded) {
            let what = format!("{name} {kind}");
            let tool = plan.data.observations[0].reading.tool_mm;
            let moves: Vec<&ncfix_machine::snc::Move> = plan
                .path
                .iter()
                .filter_map(|kind| if let Kind::Move(motion) = kind { Some(motion) } else { None })
                .collect();
            if kind == "probe" {
                let mut balls: Vec<Vec<Vector>> = vec![Vec::new(); plan.data.targets.len()];
                for row in &plan.data.observations {
                    balls[row.target.unwrap()].push(kinematics.tip_mm(&row.reading.position, &tool));
                }
                for ball in balls.iter().filter_map(|ball| ball.first()) {
                    for pair in moves.windows(2) {
                        let points = swept(&kinematics, &pair[0].target, &pair[1].target, &tool);
                        let nearest = points.iter().map(|point| (point - ball).norm()).fold(f64::INFINITY, f64::min);
                        assert!(nearest > 20.0 - 0.01, "{what}: {nearest} mm from a ball");
                    }
                }
            }
            if ["sphere", "ballbar"].contains(&kind) {
                let setup = &plan.data.setups[0];
                for pair in moves.windows(2).filter(|pair| pair[1].arc.is_none()) {
                    let [from, to] = [&pair[0].target, &pair[1].target];
                    let nearest = (0..=20).map(|part| {
                        let share = f64::from(part) / 20.0;
                        (from.xyz() * (1.0 - share) + to.xyz() * share + tool - setup.centre_mm).norm()
                    });
                    let nearest = nearest.fold(f64::INFINITY, f64::min);
                    assert!(nearest > setup.length_mm - 0.5, "{what}: {nearest} mm from the ball on the table");
                }
            }
            if kind == "plate" {
                // Between the holes the tip is 20 mm off the plate.
                let (first, second) = (&plan.data.observations[0], &plan.data.observations[1]);
                let normal = if first.reading.position[ncfix_base::geometry::Axis::Y]
                    == plan.data.observations[8].reading.position[ncfix_base::geometry::Axis::Y]
                {
                    1
                } else {
                    2
                };
                assert!((first.reading.position.xyz() - second.reading.position.xyz()).norm() > 29.0);
                for pair in moves.windows(2) {
                    let [from, to] = [pair[0].target.xyz(), pair[1].target.xyz()];
                    let aside = (0..3).filter(|k| *k != normal).any(|k| (from[k] - to[k]).abs() > 1e-6);
                    let plate = first.reading.position.xyz()[normal];
                    if aside && pair[0].named == pair[1].named {
                        let height = (from[normal] - plate).abs().min((to[normal] - plate).abs());
                        assert!(height > 20.0 - 0.002, "{what}: {height} over the plate");
                    }
                }
            }
        }
    }
}
