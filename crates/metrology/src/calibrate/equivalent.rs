//! Changes of other unknowns that have the effect of a parameter on all readings.
//!
//! The computation uses an error-free machine, as identifiability does ([`super::identify()`]).

use crate::measure::data::DataSet;
use ncfix_base::numeric::BorderedSystem;
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorModel;

use super::design::Design;
use super::effect::Parameter;
use super::exact::exact;
use super::noise::{FIRST_ANGLE_SIGMA, FIRST_SIGMA};

/// Effect on the readings, as a share of that of the parameter, that counts as none: below it a parameter is not identifiable.
const SAME: f64 = 1e-6;
/// Derivative of a column below which it is zero, as a share of its possible motion.
const NOTHING: f64 = 1e-12;

/// For each `wanted` parameter, the changes of `others` and of the unknowns of the measurements, in the order of the columns of a fit of `others`, that together
/// have the effect of one unit on all readings. `None` if the readings show the parameter beside them. All are zero if it has no effect.
#[must_use]
pub fn equivalents(
    machine: &Machine,
    start: &ErrorModel,
    wanted: &[Parameter],
    others: &[Parameter],
    data: &[DataSet],
) -> Vec<Option<Vec<f64>>> {
    let all: Vec<Parameter> = others.iter().chain(wanted).cloned().collect();
    let own = others.len()..all.len();
    let data = exact(machine, data);
    let design = Design::new(machine, &data, &all);
    let values = design.start(&ErrorModel::default());
    let count = design.columns.len();
    let mut systems = vec![BorderedSystem::new(count, all.len()); wanted.len()];
    let (mut squares, mut strongest) = (vec![0.0_f64; count], vec![0.0_f64; count]);
    let mut rest = vec![0.0; count];
    design.walk_exact(start, &values, |line, factors| {
        let weight = if line.is_angle { FIRST_SIGMA / FIRST_ANGLE_SIGMA } else { 1.0 };
        for ((square, most), factor) in squares.iter_mut().zip(&mut strongest).zip(factors) {
            *square += (factor * weight).powi(2);
            *most = most.max(factor.abs());
        }
        rest.copy_from_slice(factors);
        rest[own.clone()].fill(0.0);
        for (system, value) in systems.iter_mut().zip(&factors[own.clone()]) {
            system.add(&rest, *value, weight);
        }
    });
    // Rounding noise counts as zero.
    let reach = design.reach(start);
    let is_nothing = |column: usize| strongest[column] < NOTHING * reach[column];
    let kept = |column: &usize| !own.contains(column);
    let of = |(number, mut system): (usize, BorderedSystem)| {
        let column = own.start + number;
        if is_nothing(column) {
            return Some(vec![0.0; count - wanted.len()]);
        }
        (0..count).filter(|&column| is_nothing(column)).for_each(|column| system.clear(column));
        let found = system.solve()?;
        let counts = |other: usize| found.unknowns[other].powi(2) * squares[other] > SAME.powi(2) * squares[column];
        let change = |other: usize| if counts(other) { found.unknowns[other] } else { 0.0 };
        (found.squares <= SAME.powi(2) * squares[column]).then(|| (0..count).filter(kept).map(change).collect())
    };
    systems.into_iter().enumerate().map(of).collect()
}

/// Tip motion per unit of each parameter, root mean square over the readings, mm.
#[must_use]
pub fn tip_effects(machine: &Machine, errors: &ErrorModel, parameters: &[Parameter], data: &[DataSet]) -> Vec<f64> {
    Design::new(machine, data, parameters).effects(errors)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::bench;
    use ncfix_model::ParameterName;
    use std::fmt::Write as _;

    fn parameters(names: &[&str]) -> Vec<Parameter> {
        names.iter().map(|name| name.parse::<ParameterName>().unwrap().into()).collect()
    }

    #[test]
    fn a_circle_does_not_show_which_axis_is_inclined() {
        let machine = bench::machine();
        // Two circles of 100 mm, about X 300, Y 200 and about X 500, Y 200.
        let mut rows = "X,Y,Z,setup,dr_um\n".to_owned();
        for (setup, x) in [("A", 300.0), ("B", 500.0)] {
            for k in 0..24 {
                let angle = f64::from(15 * k).to_radians();
                let _ = writeln!(rows, "{},{},0,{setup},0", x + 100.0 * angle.cos(), 200.0 + 100.0 * angle.sin());
            }
        }
        let description = "[measurement]\nkind = \"ballbar\"\nfree = [\"centre\"]\n[setup.A]\ncentre_mm = [300, 200, 0]\n\
                           length_mm = 100\n[setup.B]\ncentre_mm = [500, 200, 0]\nlength_mm = 100\n";
        let data = [bench::table(&machine, &rows, description)];
        let found = equivalents(
            &machine,
            &ErrorModel::default(),
            &parameters(&["EYX1", "EXX1"]),
            &parameters(&["EC0Y"]),
            &data,
        );
        // A slope of X of 1 towards Y+ closes the angle as EC0Y = −1 does, and the whole machine is turned by 1 in addition. This turn moves the tip at the
        // balls by (−200, 300) and (−200, 500), so without it the balls are at the opposite places.
        let changes = found[0].as_ref().unwrap();
        let expected = [-1.0, 200.0, -300.0, 0.0, 200.0, -500.0, 0.0];
        assert!(changes.iter().zip(expected).all(|(one, other)| (one - other).abs() < 1e-6), "{changes:?}");
        // A scale is shown beside the squareness.
        assert_eq!(found[1], None);
    }

    #[test]
    fn a_known_direction_shows_the_slope() {
        let machine = bench::machine();
        let rows = "X,Y,Z,dx_um,dy_um\n0,0,0,0,0\n100,0,0,0,0\n0,100,0,0,0\n100,100,0,0,0\n";
        let data = [bench::table(&machine, rows, "[measurement]\nkind = \"displacement\"\nfree = [\"offset\"]\n")];
        let of = |data: &[DataSet]| {
            equivalents(
                &machine,
                &ErrorModel::default(),
                &parameters(&["EYX1", "EXY1", "EZX1"]),
                &parameters(&["EC0Y"]),
                data,
            )
        };
        let found = of(&data);
        assert_eq!(found[0], None);
        // EXY1 is the opposite EC0Y. No column reads EZX.
        assert!((found[1].as_ref().unwrap()[0] + 1.0).abs() < 1e-9, "{found:?}");
        assert!(found[2].as_ref().is_some_and(|changes| changes.iter().all(|change| *change == 0.0)));
    }
}
