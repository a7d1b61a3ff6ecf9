//! The sample machine after Spaan 1995: the sizes that the thesis prints, and the whole way with weight and temperatures.

use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::{Condition, Load, Machine, State};
use ncfix_model::{Accumulator, ErrorModel, Model};

use crate::support::repository;

fn maho() -> (Machine, ErrorModel) {
    let bytes = std::fs::read(repository("samples/machines/maho700s.toml")).unwrap();
    let (loaded, findings) = ncfix_model::file::load(&Source::new(FileId(0), "maho700s.toml", bytes).unwrap());
    assert!(findings.is_empty(), "{findings:?}");
    loaded.unwrap()
}

/// The largest deviation of the tip along one axis over a plate: two axes over their travel, the third in the middle, relative to the
/// first point as a plate is.
fn over_plate(model: &Model, axes: [Axis; 2], middle: [f64; 3], tool_mm: &Vector) -> f64 {
    let reach = |axis: Axis| if axis == Axis::X { 700.0 } else { 500.0 };
    let at = |i: f64, j: f64| {
        let mut command = AxisVector::ZERO;
        command.set_xyz(Vector::from(middle));
        command[axes[0]] = reach(axes[0]) * i;
        command[axes[1]] = reach(axes[1]) * j;
        model.deviation(&command, tool_mm, &State::default()).translation
    };
    let first = at(0.0, 0.0);
    let mut largest = 0.0_f64;
    for i in 0..=10 {
        for j in 0..=10 {
            let off = at(f64::from(i) / 10.0, f64::from(j) / 10.0) - first;
            for axis in axes {
                largest = largest.max(off[axis.dimension()].abs());
            }
        }
    }
    largest * 1e3
}

const TOOL: Vector = Vector::new(0.0, 0.0, -200.0);

#[test]
fn plates_without_compensation_are_as_bad_as_printed() {
    let (machine, errors) = maho();
    let model = Model::new(&machine, &errors);
    // Table 8.1: 80, 53 and 109 µm.
    for (axes, middle, printed) in [
        ([Axis::X, Axis::Y], [0.0, 0.0, 300.0], 80.0),
        ([Axis::X, Axis::Z], [0.0, 250.0, 0.0], 53.0),
        ([Axis::Y, Axis::Z], [350.0, 0.0, 0.0], 109.0),
    ] {
        let found = over_plate(&model, axes, middle, &TOOL);
        assert!((0.75..1.25).contains(&(found / printed)), "{axes:?}: {found} instead of {printed} µm");
    }
}

#[test]
fn a_load_on_the_front_does_what_was_found_and_one_on_the_back_little() {
    let (machine, errors) = maho();
    let of_load = |z_mm: f64| {
        let mut condition = Condition::default();
        condition.add_load(Load { force_n: 1700.0, position_mm: Vector::new(0.0, 0.0, z_mm) });
        let sum = Accumulator::sum(&machine, &errors, &condition, |effect| effect.source().name == "load");
        over_plate(&Model::summed(&sum), [Axis::Y, Axis::Z], [700.0, 0.0, 0.0], &TOOL)
    };
    // Fig. 8.4 and 8.5: 78 µm in all, and nothing beyond the 11 µm that geometry leaves.
    let (front, back) = (of_load(-280.0), of_load(280.0));
    assert!((0.75..1.25).contains(&(front / 78.0)), "{front} µm");
    assert!(back < 11.0, "{back} µm");
    // Eq. 4.1 at X 700: 85.75 µrad, 1700/4800, (375 + 280)/375.
    let mut condition = Condition::default();
    condition.add_load(Load { force_n: 1700.0, position_mm: Vector::new(0.0, 0.0, -280.0) });
    let mut command = AxisVector::ZERO;
    command[Axis::X] = 700.0;
    let sum = Accumulator::sum(&machine, &errors, &condition, |effect| effect.source().name == "load");
    let roll = sum.value("EAX".parse().unwrap(), &command, &State::default());
    let expected: f64 = -85.75e-6 * 1700.0 / 4800.0 * 655.0 / 375.0;
    assert!((roll - expected).abs() < 1e-9, "{roll} {expected}");
}
