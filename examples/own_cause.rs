//! A custom cause: the spindle becomes longer with the square of its speed, because centrifugal force acts on its bearings.
//!
//! The example calculates readings with this effect (9 µm at 10,000 rpm) and noise. The diagnosis names the cause, and
//! the example prints its gain on held-out data.

#![allow(clippy::print_stdout, reason = "an example shows what it found")]

use std::fmt::Write as _;

use ncfix::extend::cause::{Candidate, Cause, Correctable, EffectKind, Through, Weight, column};
use ncfix::prelude::{DataSet, Diagnosis, DiagnosisOptions, Error, Machine, Registry};

static GROWTH: Cause = Cause {
    name: "spindle growth with speed",
    effect: EffectKind::Own("spindle-growth"),
    made_by: "centrifugal force in the bearings of the spindle",
    shown_by: "readings along the tool that follow the square of the speed without lag",
    separate_by: "the same speeds in another order: thermal effects lag",
    correctable: Correctable::No,
    propose: |scene, out| {
        let Some(speeds) = column(scene.sets, "spindle_rpm") else { return };
        let weight = Weight::of_column(speeds, |rpm| (rpm / 10_000.0).powi(2));
        out.push(Candidate::one(&GROWTH, "Z", Through::Tip(2), weight).driven_by(&[&"spindle_rpm"]));
    },
};

/// Readings at speeds up to 18,000 rpm in random order, with noise of about 0.5 µm.
fn readings(mut seed: u32) -> Result<DataSet, Error> {
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
    DataSet::parse("speeds", table, description)
}

pub(crate) fn main() -> Result<(), Error> {
    let registry = Registry::default().with_cause(&GROWTH);
    let machine = Machine::from_file_with("samples/machines/demo.toml", &registry)?;
    let data = [readings(1)?, readings(2)?.held_out()];
    let found = Diagnosis::run(&machine, &data, &DiagnosisOptions::default())?;
    for one in found.causes() {
        println!(
            "{} {}: {:.2} ± {:.2} {} at the highest speed",
            one.effect, one.parameter, one.value, one.u95, one.unit
        );
    }
    // The value is the effect at the highest speed, 18,000 rpm: 9 µm times 1.8 squared.
    let growth = found.causes().iter().find(|one| one.effect == "spindle-growth");
    assert!(growth.is_some_and(|one| (one.value - 29.16).abs() < one.u95));
    println!("residual of the held-out readings: {:.0} % smaller", 100.0 * found.result().holdout_gain.unwrap_or(0.0));
    Ok(())
}
