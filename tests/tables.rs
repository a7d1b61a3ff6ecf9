//! Compensation tables: what each scheme leaves on machines of the literature, and the command.

use std::fmt::Write as _;

use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::{Condition, Machine, State};
use ncfix_model::{Accumulator, ErrorModel, Model};
use ncfix_tables::tables::check::{Check, check};
use ncfix_tables::tables::region::Region;
use ncfix_tables::tables::scheme::{self, Task};
use ncfix_tables::tables::{Control, Multiplication, Orientation, Tables, Target, Wiring, format};

use crate::support::repository;

/// Poses of a check, and the start of their generator: none of a scheme's own.
const POSES: usize = 2000;
const SEED: u64 = 7;

struct Bench {
    machine: Machine,
    errors: ErrorModel,
    tool_mm: Vector,
}

impl Bench {
    fn of(text: &str) -> Bench {
        let source = Source::new(FileId(0), "machine.toml", text.as_bytes().to_vec()).unwrap();
        let (loaded, findings) = ncfix_model::file::load(&source);
        assert!(findings.iter().all(|one| !one.is_error()), "{findings:?}");
        let (machine, errors) = loaded.unwrap();
        Bench { machine, errors, tool_mm: Vector::zeros() }
    }

    fn sample(name: &str) -> Bench {
        Bench::of(&std::fs::read_to_string(repository(&format!("samples/machines/{name}.toml"))).unwrap())
    }

    fn with_tool(self, length_mm: f64) -> Bench {
        let tool_mm = self.machine.spindle.axis * -length_mm;
        Bench { tool_mm, ..self }
    }

    fn region(&self) -> Region {
        Region::travel(&self.machine).unwrap()
    }

    fn target<'a>(&'a self, model: &'a Model, orientation: Orientation) -> Target<'a> {
        Target { machine: &self.machine, model, tool_mm: self.tool_mm, orientation }
    }

    /// The tables of a scheme as a format rounds them, or why there are none.
    fn tables(&self, wish: &Wish) -> Result<Tables, String> {
        let model = Model::new(&self.machine, &self.errors);
        let errors = Accumulator::sum(&self.machine, &self.errors, &Condition::default(), |_| true);
        let (wiring, region) = (Wiring::of(&self.machine), self.region());
        let task = Task {
            target: self.target(&model, wish.orientation),
            orientation: Some(wish.orientation),
            errors: &errors,
            region: &region,
            points: wish.points,
            tolerance_mm: wish.tolerance_um / 1e3,
            multiplication: wish.multiplication,
            format: format::find(wish.format).unwrap(),
            wiring: &wiring,
        };
        match scheme::find(wish.scheme) {
            Some(scheme) => scheme.tables(&task),
            None => scheme::auto::choose(&task).0.map(|(_, tables)| tables).ok_or_else(|| "none reaches it".to_owned()),
        }
    }

    fn check(&self, tables: &Tables, region: &Region, orientation: Orientation) -> Check {
        let model = Model::new(&self.machine, &self.errors);
        check(&self.target(&model, orientation), &Control::new(&self.machine, tables), &region.poses(POSES, SEED))
    }
}

#[derive(Clone, Copy)]
struct Wish {
    scheme: &'static str,
    format: &'static str,
    points: usize,
    tolerance_um: f64,
    orientation: Orientation,
    multiplication: Multiplication,
}

const WISH: Wish = Wish {
    scheme: "fik",
    format: "cec",
    points: 37,
    tolerance_um: 1.0,
    orientation: Orientation::Smooth,
    multiplication: Multiplication::Instead,
};

fn um(mm: f64) -> f64 {
    mm * 1e3
}

/// The machine of Esmaeili 2021, chapter 4: wCBXFZYSt, strokes 610, 560, 560 mm; where the axes have their zero is not printed.
fn chapter_4(errors: &str) -> Bench {
    Bench::of(&format!(
        "[machine]\nname = \"hu40\"\ntopology = \"wCBXFZYSt\"\n\
         [axis.X]\ndirection = [-1, 0, 0]\ntravel_mm = [-305, 305]\n\
         [axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-280, 280]\n\
         [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-280, 280]\n\
         [axis.B]\ndirection = [0, -1, 0]\ntravel_deg = [-90, 90]\n\
         [axis.C]\ndirection = [0, 0, -1]\ntravel_deg = [-360, 360]\n\
         [spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n{errors}"
    ))
}

fn polynomial(component: &str, coefficients: &[f64]) -> String {
    let listed: Vec<String> = coefficients.iter().map(|value| format!("{value:e}")).collect();
    format!("[[motion]]\ncomponent = \"{component}\"\nkind = \"polynomial\"\ncoefficients = [{}]\n", listed.join(", "))
}

/// A region in which the rotary axes stand at zero, as a grid of three axes has it.
fn without_rotary(bench: &Bench) -> Region {
    let mut region = bench.region();
    [Axis::A, Axis::B, Axis::C].into_iter().for_each(|axis| region.set(axis, [0.0; 2]));
    region
}

/// Table 4-3: squareness, offsets and scales make corrections that are straight along each axis.
#[test]
fn thirteen_errors_need_a_grid_of_two_nodes_an_axis() {
    let location = "[location]\nEA0B = -40\nEC0B = -1\nEX0C = -95.6\nEA0C = -12\nEB0C = 11\nEB0Z = -10\nEA0Y = -38\nEC0Y = 15\n\
                    EY0S = 29.3\nEX0S = -100\n";
    let scales = [("EXX", -1.7e-5), ("EYY", -2.3e-5), ("EZZ", -3.2e-5)];
    let scales: String = scales.iter().map(|&(name, scale)| polynomial(name, &[0.0, scale])).collect();
    let bench = chapter_4(&format!("{location}{scales}")).with_tool(275.86);
    let tables = bench.tables(&Wish { scheme: "grid", format: "fanuc", ..WISH }).unwrap();
    let grid = tables.grid.as_ref().unwrap();
    assert_eq!(grid.count, [2, 2, 2]);
    // As computed: the values of the format are rounded.
    let found = bench.check(&tables, &without_rotary(&bench), Orientation::Off);
    assert!(um(found.before.mean_mm()) > 20.0, "{} um", um(found.before.mean_mm()));
    let rounding = um(format::find("fanuc").unwrap().limits.resolution_mm);
    assert!(um(found.tables.max_mm()) <= f64::max(0.001, rounding), "{} um", um(found.tables.max_mm()));
}

/// Table 4-2, the part that acts with the rotary axes at 0. The grid has its own number of nodes along each axis, and it is the error that is left
/// that is below the tolerance: the rule of the thesis, the change from one grid to the next, stops at 14 to 19 nodes with 0.4 to 1.1 µm left.
#[test]
fn the_smallest_grid_for_84_errors_leaves_what_was_asked() {
    let bench = chapter_4(
        &[
            polynomial("EXX", &[0.0, -3.13e-4, 7.53e-8, 1.35e-10]),
            polynomial("EYX", &[0.0, 0.0, -2.74e-9, 1.22e-10]),
            polynomial("EZX", &[0.0, 0.0, -1.57e-8, -1.32e-11]),
            polynomial("EAX", &[-5.99e-4, 2.86e-8, 2.97e-10, -1.82e-13]),
            polynomial("EBX", &[0.0, -7.27e-8, -1.10e-10, 3.61e-13]),
            polynomial("ECX", &[-3.62e-3, 6.46e-8, -2.59e-11, -1.82e-12]),
            polynomial("EXY", &[-2.41e-2, 0.0, 3.43e-8, -5.12e-10]),
            polynomial("EYY", &[6.10e-2, -1.09e-4, -2.46e-8, 3.64e-11]),
            polynomial("EZY", &[0.0, 0.0, 3.30e-8, -1.19e-10]),
            polynomial("EXZ", &[0.0, 2.29e-4, -6.27e-7, 5.55e-10]),
            polynomial("EYZ", &[0.0, 0.0, 5.12e-7, -3.06e-10]),
            polynomial("EZZ", &[0.0, 1.04e-4, -3.76e-7, 3.26e-10]),
            polynomial("EAZ", &[-2.60e-4, -1.15e-7, 4.06e-10, -5.07e-13]),
            polynomial("ECZ", &[-4.28e-4, 3.47e-6, -8.99e-9, 7.56e-12]),
            polynomial("EXB", &[-1.08e-1]),
            polynomial("EAB", &[3.00e-4]),
            polynomial("EBB", &[1.95e-5]),
        ]
        .concat(),
    );
    let wish = Wish { scheme: "grid", format: "fanuc", ..WISH };
    let region = without_rotary(&bench);
    let mut nodes = Vec::new();
    for tolerance_um in [1.0, 0.1] {
        let tables = bench.tables(&Wish { tolerance_um, ..wish }).unwrap();
        let grid = tables.grid.as_ref().unwrap();
        let left = bench.check(&tables, &region, Orientation::Off).tables;
        assert!(um(left.rms_mm()) <= tolerance_um, "{:?} leaves {} um", grid.count, um(left.rms_mm()));
        nodes.push((grid.count, grid.values.len()));
        // A node less along any axis does not do, or the grid would not be the smallest.
        let model = Model::new(&bench.machine, &bench.errors);
        let target = bench.target(&model, Orientation::Off);
        for i in 0..3 {
            let mut fewer = grid.clone();
            fewer.count[i] -= 1;
            fewer.step[i] = (region.range(grid.axes[i])[1] - grid.start[i]) / (fewer.count[i] - 1) as f64;
            let value = |index: usize| {
                let mut pose = AxisVector::default();
                let position = fewer.position(fewer.node(index));
                grid.axes.iter().zip(position).for_each(|(&axis, at)| pose[axis] = at);
                let correction = target.correction(&pose, &State::default()).unwrap();
                grid.axes.map(|axis| correction[axis])
            };
            fewer.values = (0..fewer.count.iter().product()).map(value).collect();
            let fewer = Tables { grid: Some(fewer), ..Tables::default() };
            let left = bench.check(&fewer, &region, Orientation::Off).tables;
            assert!(um(left.rms_mm()) > 0.9 * tolerance_um, "{i}: {} um", um(left.rms_mm()));
        }
    }
    // Finer by the root of ten, as the error of linear interpolation goes with the square of the step.
    let growth = (nodes[1].1 as f64 / nodes[0].1 as f64).cbrt();
    assert!((2.5..3.8).contains(&growth), "{nodes:?}");
    let fanuc = format::find("fanuc").unwrap();
    let tables = bench.tables(&Wish { tolerance_um: 0.1, ..wish }).unwrap();
    assert!(!fanuc.faults_of(&tables, &Wiring::of(&bench.machine)).is_empty(), "25 nodes an axis are the limit");
}

/// The machine of Esmaeili 2021, chapter 6, with one error of Table 6-2: wCAYFXZSt, strokes 260, 420, 240 mm, A from −55° to 55°.
fn chapter_6(error: &str) -> Bench {
    Bench::of(&format!(
        "[machine]\nname = \"kolibri\"\ntopology = \"wCAYFXZSt\"\n\
         [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-130, 130]\n\
         [axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [-210, 210]\n\
         [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 240]\n\
         [axis.A]\ndirection = [-1, 0, 0]\ntravel_deg = [-55, 55]\n\
         [axis.C]\ndirection = [0, 0, -1]\ntravel_deg = [-180, 180]\n\
         [spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n{error}"
    ))
}

/// Figures 6.6 and 6.7: sums of polynomials cure five of the ten errors, products with trigonometric functions all, and so does the exact scheme.
#[test]
fn the_ten_cases_of_table_6_2() {
    let location = |name: &str, value: f64| format!("[location]\n{name} = {value:.1}\n");
    let cases = [
        ("EB0A", location("EB0A", 400.0), false),
        ("EC0A", location("EC0A", 400.0), false),
        ("EY0C", location("EY0C", 10.0), true),
        ("EA0C", location("EA0C", 400.0), true),
        ("EB0C", location("EB0C", 400.0), false),
        ("EC0X", location("EC0X", 400.0), false),
        ("EA0Z", location("EA0Z", 400.0), true),
        ("EB0Z", location("EB0Z", 400.0), false),
        ("EYY1", polynomial("EYY", &[0.0, 4e-5]), true),
        ("EZZ1", polynomial("EZZ", &[0.0, 4e-5]), true),
    ];
    let mut page = "tip error over the volume, mean and max in um, tables\n\
                    case       without         polynomial      trigonometric              fik          exact\n"
        .to_owned();
    for (name, error, is_cured) in cases {
        let bench = chapter_6(&error);
        let region = bench.region();
        let _ = write!(page, "{name}");
        for scheme in ["polynomial", "trigonometric", "fik"] {
            let wish = Wish { scheme, orientation: Orientation::SixRows, ..WISH };
            let tables = bench.tables(&wish).unwrap();
            let found = bench.check(&tables, &region, wish.orientation);
            let left = found.tables;
            if scheme == "polynomial" {
                let _ = write!(page, " {:6.1} {:6.1}", um(found.before.mean_mm()), um(found.before.max_mm()));
                assert_eq!(um(left.mean_mm()) < 1.0, is_cured, "{name}: {}", um(left.mean_mm()));
                if !is_cured {
                    assert!(left.mean_mm() > 0.2 * found.before.mean_mm(), "{name}");
                }
            } else {
                assert!(um(left.max_mm()) < 1.0, "{name} {scheme}: {}", um(left.max_mm()));
            }
            let _ = write!(page, "  {:5.1} {:5.1} {:3}", um(left.mean_mm()), um(left.max_mm()), tables.count());
            if scheme == "fik" {
                let _ = writeln!(page, "  {:5.1} {:5.1}", um(found.exact.mean_mm()), um(found.exact.max_mm()));
                assert!(um(found.exact.max_mm()) < 1e-3, "{name}");
            }
        }
    }
    insta::assert_snapshot!(page);
}

/// Table 7-2 on the 45° machine, by way of the file: 44 µm became 9.1 µm on the real one, with 40 tables.
#[test]
fn tables_for_the_45_degree_machine_as_they_are_written() {
    let bench = Bench::sample("esmaeili_huron").with_tool(150.0);
    let wiring = Wiring::of(&bench.machine);
    let cec = format::find("cec").unwrap();
    for orientation in [Orientation::Smooth, Orientation::SixRows] {
        let tables = bench.tables(&Wish { orientation, ..WISH }).unwrap();
        assert_eq!(cec.faults_of(&tables, &wiring), Vec::<String>::new());
        assert!(tables.count() <= 40, "{}", tables.count());
        let text = (cec.write)(&tables, &wiring, &[]).remove(0).text;
        let mut read = Tables::default();
        let source = Source::new(FileId(0), "CEC.INI", text.into_bytes()).unwrap();
        assert!((cec.read)(&source, &wiring, &mut read).is_empty());
        assert_eq!(read, tables, "bit by bit");
        let found = bench.check(&read, &bench.region(), orientation);
        assert!(um(found.before.mean_mm()) > 40.0);
        assert!(um(found.tables.mean_mm()) <= 1.0, "{orientation:?}: {} um", um(found.tables.mean_mm()));
        assert!(found.tables.rms_rad() < 0.7 * found.before.rms_rad(), "{orientation:?}");
    }
}

/// All 21 errors of three axes with arms: what a control with kinematics of its own, and products of tables, leave.
#[test]
fn error_functions_and_products_correct_a_machine_of_three_axes() {
    let bench = Bench::sample("demo").with_tool(120.0);
    for (scheme, format) in [("functions", "grundig"), ("functions", "isg"), ("fik", "cec")] {
        let tables = bench.tables(&Wish { scheme, format, points: 65, ..WISH }).unwrap();
        let found = bench.check(&tables, &bench.region(), Orientation::Off);
        let (before, left) = (found.before.rms_mm(), found.tables.rms_mm());
        assert!(um(before) > 5.0 && left < 0.1 * before, "{scheme} {format}: {} of {} um", um(left), um(before));
    }
}

/// A matrix takes scales and squareness; tables of own positions only what an axis does along itself.
#[test]
fn a_matrix_and_tables_of_own_positions_take_what_they_can() {
    let errors = [polynomial("EXX", &[0.0, 4e-5]), polynomial("EYY", &[0.0, -3e-5]), "[location]\nEC0Y = 60\n".into()];
    let machine = "[machine]\nname = \"mill\"\ntopology = \"wFXYZSt\"\n[axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 500]\n\
                   [axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 400]\n[axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 300]\n\
                   [spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n";
    let bench = Bench::of(&format!("{machine}{}", errors.concat()));
    let tables = bench.tables(&Wish { scheme: "matrix", format: "matrixkins", ..WISH }).unwrap();
    // X motor: X − 4e-5 X + 6e-5 Y, for Y turned by 60 µrad about Z moves −X.
    let wanted = [[1.0 - 4e-5, 6e-5, 0.0], [0.0, 1.0 + 3e-5, 0.0], [0.0, 0.0, 1.0]];
    for (row, wanted) in tables.matrix.unwrap().iter().zip(wanted) {
        for (value, wanted) in row.iter().zip(wanted) {
            assert!((value - wanted).abs() < 1e-8, "{value} {wanted}");
        }
    }
    let left = bench.check(&tables, &bench.region(), Orientation::Off).tables;
    assert!(um(left.max_mm()) < 0.01, "{} um", um(left.max_mm()));
    for format in ["enc", "comp", "ssfk"] {
        let tables = bench.tables(&Wish { scheme: "own", format, points: 9, ..WISH }).unwrap();
        assert!(tables.lookups.iter().all(|one| one.input == one.output) && tables.count() >= 2, "{format}");
        // The squareness stays: 60 µrad · Y less its mean, 400 mm · 60 µrad / √12 = 6.9 µm.
        let left = bench.check(&tables, &bench.region(), Orientation::Off).tables;
        assert!((um(left.rms_mm()) - 6.93).abs() < 0.3, "{format}: {} um", um(left.rms_mm()));
    }
}

/// Squareness and offsets of every axis, on chains with rotary axes on either side, both on the table, both in the head, or none: the exact scheme
/// is derived from the chain.
#[test]
fn location_errors_of_any_chain_are_corrected() {
    let chains = ["wFXYZSt", "wYFXZSt", "wCAYFXZSt", "wCBXFZYSt", "wCFXYZBSt", "wAFXYZBSt", "wXYFZCASt", "wFXYZCBSt"];
    for topology in chains {
        let tool = topology.split('F').nth(1).unwrap();
        let mut text = format!(
            "[machine]\nname = \"any\"\ntopology = \"{topology}\"\n[spindle]\norigin_mm = [0, 0, 50]\naxis = [0, 0, 1]\n"
        );
        let mut location = "[location]\nEX0S = 12\nEY0S = -7\n".to_owned();
        for (number, letter) in topology.chars().filter(|letter| "XYZABC".contains(*letter)).enumerate() {
            let sign = if tool.contains(letter) { 1 } else { -1 };
            let mut direction = [0; 3];
            direction["XYZABC".find(letter).unwrap() % 3] = sign;
            let travel = match letter {
                'X' | 'Y' | 'Z' => "travel_mm = [-200, 200]",
                'C' => "travel_deg = [-180, 180]",
                _ => "travel_deg = [-60, 60]",
            };
            let _ = writeln!(text, "[axis.{letter}]\ndirection = {direction:?}\n{travel}");
            let parts = if "ABC".contains(letter) { "XYZABC" } else { "ABC" };
            for (index, part) in parts.chars().enumerate() {
                // Any numbers up to 30: those of a linear congruence.
                let value = ((number * 7 + index * 13 + 5) * 29 % 61) as f64 - 30.0;
                let _ = writeln!(location, "E{part}0{letter} = {value:.1}");
            }
        }
        let bench = Bench::of(&format!("{text}{location}")).with_tool(100.0);
        for orientation in [Orientation::Off, Orientation::Smooth, Orientation::SixRows] {
            let tables = bench.tables(&Wish { points: 73, orientation, ..WISH }).unwrap();
            let found = bench.check(&tables, &bench.region(), orientation);
            let left = um(found.tables.max_mm());
            assert!(left < 0.3 && um(found.before.mean_mm()) > 10.0, "{topology} {orientation:?}: {left} um");
        }
    }
}

/// What two readings of the manual mean for a product: tables for each correct alike where they are read so.
#[test]
fn products_are_right_in_both_readings() {
    let bench = Bench::sample("esmaeili_huron").with_tool(150.0);
    let poses = bench.region().poses(50, 3);
    let corrections = |multiplication: Multiplication| -> Vec<AxisVector> {
        let tables = bench.tables(&Wish { multiplication, ..WISH }).unwrap();
        assert_eq!(tables.multiplication, multiplication);
        let control = Control::new(&bench.machine, &tables);
        poses.iter().map(|pose| control.correction(pose, &bench.tool_mm, &State::default())).collect()
    };
    let [instead, beside] = [Multiplication::Instead, Multiplication::Beside].map(corrections);
    for (one, other) in instead.iter().zip(&beside) {
        for axis in [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::C] {
            assert!((one[axis] - other[axis]).abs() < 2e-5, "{axis}: {} {}", one[axis], other[axis]);
        }
    }
}

/// A control that adds a table which only serves as a factor, and one that does not, do the same: no table is a factor only.
#[test]
fn no_table_is_only_a_factor() {
    let tables = Bench::sample("esmaeili_huron").tables(&WISH).unwrap();
    for (index, one) in tables.lookups.iter().enumerate() {
        if let Some(factor) = one.factor {
            assert_eq!(tables.lookups[factor].factor, Some(index));
        }
    }
}

#[test]
fn auto_needs_no_more_tables_than_any_scheme_that_reaches_the_tolerance() {
    let bench = chapter_6("[location]\nEB0A = 400\nEC0X = 40\n");
    let wish = Wish { scheme: "auto", tolerance_um: 2.0, ..WISH };
    let tables = bench.tables(&wish).unwrap();
    let found = bench.check(&tables, &bench.region(), wish.orientation);
    assert!(um(found.tables.rms_mm()) <= 2.0, "{} um", um(found.tables.rms_mm()));
    for scheme in ["polynomial", "free", "trigonometric", "fik"] {
        let other = bench.tables(&Wish { scheme, ..wish }).unwrap();
        let left = bench.check(&other, &bench.region(), wish.orientation).tables;
        assert!(um(left.rms_mm()) > 2.0 || tables.count() <= other.count(), "{scheme}: {}", other.count());
    }
    // Nobody reaches a picometre.
    assert!(bench.tables(&Wish { tolerance_um: 1e-6, ..wish }).is_err());
}

/// Functions that are free at every point contain cubic polynomials: on no machine may they leave more. A hundredth is the chance of other poses.
#[test]
fn free_functions_leave_no_more_than_the_polynomials_that_they_contain() {
    let samples = ["demo", "esmaeili_huron", "esmaeili_xyz5", "knee_mill", "maho700s", "universal_mill", "vmc"];
    for name in samples {
        let bench = Bench::sample(name).with_tool(100.0);
        let region = bench.region().reached(&bench.machine);
        let [free, simple] = ["free", "polynomial"].map(|scheme| {
            let tables = bench.tables(&Wish { scheme, ..WISH }).unwrap();
            um(bench.check(&tables, &region, WISH.orientation).tables.rms_mm())
        });
        assert!(free <= 1.01 * simple, "{name}: {free} {simple}");
    }
}

/// A backlash of 6 µm: half of it in each sense.
#[test]
fn a_reversal_gets_a_table_for_each_sense() {
    let bench = chapter_6("[[motion]]\ncomponent = \"EXX\"\nkind = \"backlash\"\nvalue_um = 6.0\n");
    let tables = bench.tables(&Wish { orientation: Orientation::Off, ..WISH }).unwrap();
    let control = Control::new(&bench.machine, &tables);
    for (sense, wanted) in [(1, -0.003), (-1, 0.003), (0, 0.0)] {
        let mut state = State::default();
        state.direction[Axis::X.slot()] = sense;
        let found = control.correction(&AxisVector::default(), &bench.tool_mm, &state)[Axis::X];
        assert!((found - wanted).abs() < 1e-6, "{sense}: {found}");
    }
}

#[test]
fn the_documents_name_every_scheme_and_format() {
    let read = |name: &str| std::fs::read_to_string(repository(name)).unwrap();
    let (schemes, formats) = (read("docs/reference/tables.md"), read("docs/reference/table-formats.md"));
    for one in scheme::SCHEMES {
        assert!(schemes.contains(&format!("| `{}` |", one.name)), "docs/reference/tables.md lacks {}", one.name);
    }
    for one in format::FORMATS {
        assert!(formats.contains(&format!("`{}`", one.name)), "docs/reference/table-formats.md lacks {}", one.name);
    }
}
