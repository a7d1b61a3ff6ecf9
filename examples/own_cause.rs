//! A cause of one's own: the spindle grows along its axis with the square of its speed, as balls and rings are pressed outwards.
//!
//! The data are made here, with this effect of 9 µm at 10,000 1/min and noise; diagnosis names it and says what it gains on data held out.

use std::fmt::Write as _;

use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::Machine;
use ncfix_metrology::diagnose::cause::{Candidate, Cause, Causes, Correctable, Effect, Weight, column};
use ncfix_metrology::diagnose::diagnose_with;
use ncfix_metrology::diagnose::scene::{Scene, Through};
use ncfix_metrology::measure::data::{self, DataSet};
use ncfix_model::ErrorModel;

static GROWTH: Cause = Cause {
    name: "spindle growth with speed",
    effect: Effect::Own("spindle-growth"),
    made_by: "centrifugal force in the bearings of the spindle",
    shown_by: "readings along the tool that follow the square of the speed at once",
    separate_by: "the same speeds in another order: heat follows late",
    correctable: Correctable::No,
    propose: |scene, out| {
        let Some(speeds) = column(scene.sets, "spindle_rpm") else { return };
        let weight = Weight::of_column(speeds, |rpm| (rpm / 10_000.0).powi(2));
        out.push(Candidate::one(&GROWTH, "Z", Through::Tip(2), weight).driven_by(&[&"spindle_rpm"]));
    },
};

/// Readings at speeds up to 18,000 1/min in an order that drifts with nothing else; noise of about 0.5 µm.
fn readings(machine: &Machine, mut seed: u32) -> DataSet {
    let mut random = move || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed >> 8) / f64::from(1 << 24)
    };
    let mut table = "t_s,X,Y,Z,spindle_rpm,dz_um\n".to_owned();
    for row in 0..120 {
        let rpm = (18.0 * random()).round() * 1000.0;
        let noise = (0..6).map(|_| random() - 0.5).sum::<f64>() * 0.7;
        let _ = writeln!(table, "{},350,250,100,{rpm},{:.2}", 10 * row, 9.0 * (rpm / 1e4).powi(2) + noise);
    }
    let description = "[measurement]\nkind = \"displacement\"\nsigma_um = 0.5\nfree = [\"offset\"]\n";
    let [table, description] = [table.as_str(), description]
        .map(|text| Source::new(FileId(0), "speeds", text.as_bytes().to_vec()).expect("a small file"));
    data::load("speeds", &table, &description, machine).0.expect("sound data")
}

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let demo = Source::new(FileId(0), "demo", std::fs::read("samples/machines/demo.toml")?).expect("a small file");
    let (machine, _) = ncfix_model::file::load(&demo).0.expect("a sound machine");
    let sets = [readings(&machine, 1), readings(&machine, 2)];
    let scene = Scene::new(&machine, &ErrorModel::default(), &sets).expect("set-ups that can be told");
    let found = diagnose_with(&Causes::default().with(&GROWTH), &scene, &scene, 1, &mut |_, _| {});
    for one in &found.findings {
        let (cause, size) = (one.candidate.cause.name, &one.size);
        println!("{cause}: {:.2} ± {:.2} {}, the largest", size.value, size.u95, size.unit);
    }
    let gain = found.held_out.ok_or("nothing was held out")?.gain.0;
    println!("of the readings held out {:.0} % less is left", 100.0 * gain);
    Ok(())
}
