//! Spaan's comparison of methods (1995, ch. 3) in simulation: direct measurement, hole plates and ball-bar on one machine whose errors are not all in
//! the model, tested on plates and diagonals that were not used for calibration; and the effect of a second tool vector. The figures are those of
//! docs/explanation/comparison.md: run with `NCFIX_WRITE_DOCS=1` to write it anew.

use std::fmt::Write as _;

use ncfix_base::geometry::{Axis, AxisVector, Plane, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::{Machine, State};
use ncfix_metrology::calibrate::{Column, FitOptions, fit, identify};
use ncfix_metrology::measure::data::{DataSet, Free, Setup};
use ncfix_metrology::measure::noise::Noise;
use ncfix_metrology::measure::plan::{Wishes, find};
use ncfix_metrology::measure::simulate::{ReadValue, Simulation};
use ncfix_model::motion::EntryFunction;
use ncfix_model::motion::periodic::Periodic;
use ncfix_model::motion::polynomial::Polynomial;
use ncfix_model::parameter::ParameterName;
use ncfix_model::{ErrorModel, MotionError};

use crate::support::repository;

/// Uncertainties of the instruments, mm and rad: laser, level and autocollimator, square, probing of holes, ball-bar, and the length of a
/// ball-bar with its rod.
const LASER: f64 = 0.5e-3;
const LEVEL: f64 = 0.5e-6;
const SQUARE: f64 = 2e-6;
const PROBE: f64 = 0.7e-3;
const BAR: f64 = 0.5e-3;
const ROD: f64 = 1e-3;

const SHORT: Vector = Vector::new(0.0, 0.0, -110.0);
const LONG: Vector = Vector::new(0.0, 0.0, -245.0);
const BELOW: Vector = Vector::new(0.0, -120.0, -150.0);
/// As long as the short one: the roll of Z is told by the side alone.
const ASIDE: Vector = Vector::new(120.0, 0.0, -110.0);
const LEFT: Vector = Vector::new(-120.0, 0.0, -150.0);
const RIGHT: Vector = Vector::new(120.0, 0.0, -150.0);

/// Efficiencies of Tables 3.2 to 3.4, %: direct, hole plate, ball-bar, for each direction of each of five plates.
const PRINTED: [[f64; 3]; 10] = [
    [81.0, 55.0, 50.0],
    [91.0, 93.0, 94.0],
    [69.0, 91.0, 81.0],
    [89.0, 88.0, 31.0],
    [73.0, 84.0, 49.0],
    [96.0, 93.0, 58.0],
    [94.0, 97.0, 77.0],
    [43.0, 52.0, 0.0],
    [93.0, 97.0, 71.0],
    [76.0, 88.0, 0.0],
];

/// A parameter counts as not told where its uncertainty alone moves the tip by more, mm.
const MOST: f64 = 0.01;
/// The same for a model that is kept although most of it is told badly.
const LOOSE: f64 = 0.1;

/// What a parameter of 1 does at the end of the travel, at an arm of 300 mm.
fn at_tip(name: &ParameterName) -> f64 {
    let reach: f64 = match name.component.axis() {
        Some(Axis::X) => 700.0,
        Some(Axis::Y) => 500.0,
        _ => 600.0,
    };
    reach.powi(i32::from(name.degree())) * if name.component.direction.is_rotation() { 300.0 } else { 1.0 }
}

fn polynomial(name: &str, coefficients: &[f64]) -> MotionError {
    let function = EntryFunction::Polynomial(Polynomial { coefficients: coefficients.to_vec() });
    MotionError { name: name.parse().unwrap(), function }
}

/// The sample machine after Spaan, with every component, and with a pitch error and bows of the fourth order that no cubic function can follow. What
/// says where the workpiece lies – the slopes of X and of Y along Z – is nothing that could be measured.
fn truth() -> (Machine, ErrorModel) {
    let bytes = std::fs::read(repository("samples/machines/maho700s.toml")).unwrap();
    let (machine, mut errors) =
        ncfix_model::file::load(&Source::new(FileId(0), "maho700s.toml", bytes).unwrap()).0.unwrap();
    errors.effects.clear();
    for error in &mut errors.motion {
        if ["EYX", "EZX", "EZY"].contains(&error.name.to_string().as_str())
            && let EntryFunction::Polynomial(Polynomial { coefficients }) = &mut error.function
        {
            coefficients[1] = 0.0;
        }
    }
    errors.motion.extend([
        polynomial("EAX", &[0.0, 2.0e-8, -2.5e-11]),
        polynomial("EBX", &[0.0, -3.0e-8, 4.0e-11]),
        polynomial("EZY", &[0.0, 0.0, 2.0e-8]),
        polynomial("EBY", &[0.0, 1.5e-8, -5.0e-11]),
        polynomial("ECY", &[0.0, -3.0e-8, 8.0e-11, -5.0e-14]),
        polynomial("EBZ", &[0.0, 2.5e-8, -3.0e-11]),
        polynomial("ECZ", &[0.0, 1.2e-7, -1.0e-10]),
        // a (u² − 1)² with u from −1 to 1 over the travel: bows of 4 µm.
        bow("EYX", 350.0, 4e-3),
        bow("EXZ", 300.0, -4e-3),
    ]);
    let pitch = Periodic { period: 12.0, amplitude: 1.5e-3, phase_rad: 0.0 };
    errors.motion.push(MotionError { name: "EXX".parse().unwrap(), function: EntryFunction::Periodic(pitch) });
    let pitch = Periodic { period: 12.0, amplitude: 1.0e-3, phase_rad: 1.0 };
    errors.motion.push(MotionError { name: "EZZ".parse().unwrap(), function: EntryFunction::Periodic(pitch) });
    (machine, errors)
}

fn bow(name: &str, half: f64, size: f64) -> MotionError {
    // ((q − h)² / h² − 1)² = (q² − 2 h q)² / h⁴
    polynomial(name, &[0.0, 0.0, 4.0 * size / half.powi(2), -4.0 * size / half.powi(3), size / half.powi(4)])
}

/// Cubic functions of all 18 components, squareness in the slopes of Y and Z.
fn parameters() -> Vec<ParameterName> {
    let mut out = Vec::new();
    for axis in ["X", "Y", "Z"] {
        for direction in ["X", "Y", "Z", "A", "B", "C"] {
            let is_straightness = direction != axis && ["X", "Y", "Z"].contains(&direction);
            let is_square = is_straightness && ["XY", "XZ", "YZ"].contains(&format!("{direction}{axis}").as_str());
            let first = if is_straightness && !is_square { 2 } else { 1 };
            out.extend(
                (first..=3).map(|degree| format!("E{direction}{axis}{degree}").parse::<ParameterName>().unwrap()),
            );
        }
    }
    // 18 functions of three coefficients, less three slopes.
    assert_eq!(out.len(), 51);
    out
}

struct Shop {
    machine: Machine,
    errors: ErrorModel,
}

impl Shop {
    fn plan(&self, kind: &str, wishes: Wishes) -> DataSet {
        let plan = (find(kind).unwrap().build)(&self.machine, &wishes).unwrap();
        let mut data = plan.data;
        for row in &mut data.observations {
            row.values = plan.reads.map(|is_read| is_read.then_some(0.0));
        }
        data
    }

    /// A plate whose middle is at axis positions.
    fn plate(&self, name: &str, plane: Plane, at: [f64; 3], tool: Vector) -> DataSet {
        let wishes = Wishes {
            planes: vec![plane],
            centres_mm: vec![Vector::from(at) + tool],
            tools_mm: vec![tool],
            points: Some(9),
            every: Some(50.0),
            ..Wishes::default()
        };
        let mut data = DataSet { name: name.to_owned(), ..self.plan("plate", wishes) };
        // Holes are at whole mm.
        for row in &mut data.observations {
            let place = row.reading.position.xyz().map(f64::round);
            row.reading.position.set_xyz(place);
        }
        data
    }

    /// Readings of an instrument.
    fn measured(&self, mut data: DataSet, seed: u64, noise: f64) -> DataSet {
        let mut random = Noise::new(seed);
        let plan = data.clone();
        let mut simulation = Simulation::new(&self.machine, &self.errors, &plan);
        for row in &mut data.observations {
            let Ok(ReadValue::Values(values)) = simulation.read(row) else { panic!("values") };
            row.values = values.map(|value| value.map(|value| value + noise * random.normal()));
        }
        data
    }

    /// All 18 components, each line with its own straightedge or square.
    fn direct(&self) -> Vec<DataSet> {
        let mut out = Vec::new();
        let mut squares = Noise::new(77);
        for (number, axis) in [Axis::X, Axis::Y, Axis::Z].into_iter().enumerate() {
            for (angles, letters) in [(false, "XYZ"), (true, "ABC")] {
                let wishes = Wishes {
                    axis: Some(axis),
                    components: letters.chars().map(|letter| format!("E{letter}{axis}").parse().unwrap()).collect(),
                    tools_mm: vec![SHORT],
                    points: Some(36),
                    runs: Some(2),
                    seed: 5,
                    ..Wishes::default()
                };
                let name = format!("{axis} {letters}");
                // The squares are references of the slope too, each with its own error.
                let data = DataSet { name, free: vec![Free::Offset], ..self.plan("laser", wishes) };
                let mut data = self.measured(data, 100 + number as u64, if angles { LEVEL } else { LASER });
                for component in ["EXY", "EXZ", "EYZ"] {
                    let off = SQUARE * squares.normal();
                    for row in &mut data.observations {
                        if row.component.is_some_and(|own| own.to_string() == component) {
                            row.values[0] = row.values[0].map(|value| value + off * row.reading.position[axis]);
                        }
                    }
                }
                // Straightness of X, and of Y along Z, says nothing about slopes: the straightedge was turned until it had none.
                out.push(data);
            }
        }
        out
    }

    fn plates(&self) -> Vec<DataSet> {
        [
            ("XY", Plane::XY, [350.0, 250.0, 150.0], SHORT),
            ("XY", Plane::XY, [350.0, 250.0, 450.0], LONG),
            ("ZX", Plane::ZX, [350.0, 150.0, 300.0], SHORT),
            ("ZX", Plane::ZX, [350.0, 350.0, 300.0], BELOW),
            ("YZ", Plane::YZ, [200.0, 250.0, 300.0], SHORT),
            ("YZ", Plane::YZ, [500.0, 250.0, 300.0], RIGHT),
        ]
        .into_iter()
        .enumerate()
        .map(|(number, (name, plane, at, tool))| {
            self.measured(self.plate(name, plane, at, tool), 200 + number as u64, PROBE)
        })
        .collect()
    }

    fn spheres(&self) -> Vec<DataSet> {
        let wishes = Wishes { variant: Some("spaan".into()), chord: Some(5_f64.to_radians()), ..Wishes::default() };
        // The length of the ball-bar is calibrated; rods are off by ROD.
        let data = DataSet { free: vec![Free::Centre], name: "spheres".into(), ..self.plan("sphere", wishes) };
        let mut data = self.measured(data, 300, BAR);
        let mut random = Noise::new(301);
        let rods: Vec<f64> = data.setups.iter().map(|_| ROD * random.normal()).collect();
        for row in &mut data.observations {
            row.values[0] = row.values[0].map(|value| value + rods[row.setup]);
        }
        vec![data]
    }

    /// What none of the methods has seen: Spaan's five plates, and the diagonals of the working space.
    fn held_out(&self) -> Vec<DataSet> {
        let plates = [
            ("XY plane", Plane::XY, SHORT),
            ("XZ plane (short)", Plane::ZX, SHORT),
            ("XZ plane (long)", Plane::ZX, LONG),
            ("YZ plane (left)", Plane::YZ, LEFT),
            ("YZ plane (right)", Plane::YZ, RIGHT),
        ];
        let mut out: Vec<DataSet> = plates
            .into_iter()
            .map(|(name, plane, tool)| self.plate(name, plane, [350.0, 250.0, 300.0], tool))
            .collect();
        let reach = [[150.0, 550.0], [50.0, 450.0], [100.0, 500.0]];
        let whole = [[10.0, 690.0], [10.0, 490.0], [10.0, 590.0]];
        let diagonals = [("diagonals within the reach of the plates", reach), ("diagonals of the whole space", whole)]
            .map(|(name, space)| diagonals(name, space, &out[0]));
        out.extend(diagonals);
        out.into_iter().enumerate().map(|(number, data)| self.measured(data, 400 + number as u64, PROBE)).collect()
    }

    /// Takes out of the model what the data cannot tell, and fits the rest.
    fn calibrated(&self, data: &[DataSet], limit: f64) -> (ErrorModel, Vec<String>) {
        let mut parameters = parameters();
        let mut lost = Vec::new();
        let none = ErrorModel::default();
        for _ in 0..60 {
            let found = identify(&self.machine, &none, &parameters, data).unwrap();
            let mut names: Vec<String> = found.lost.leave_out.iter().map(ToString::to_string).collect();
            if names.is_empty() {
                let worst = found.columns.iter().zip(&found.sigmas).filter_map(|(column, sigma)| match column {
                    Column::Parameter(name) => Some((at_tip(name) * sigma * PROBE, name.to_string())),
                    Column::Effect(_) | Column::Unknown(..) => None,
                });
                let worst = worst.max_by(|one, other| one.0.total_cmp(&other.0)).unwrap();
                names.extend((worst.0 > limit).then_some(worst.1));
            }
            if names.is_empty() {
                break;
            }
            parameters.retain(|parameter| !names.contains(&parameter.to_string()));
            lost.extend(names);
        }
        lost.sort();
        let found = fit(&self.machine, &none, &parameters, data, FitOptions { robust: true });
        (found.unwrap_or_else(|fault| panic!("{}: {fault:?}", data[0].name)).errors, lost)
    }

    /// What a model leaves of a measurement, by direction, mm: the set-up as it fits best.
    fn left(&self, errors: &ErrorModel, data: &DataSet) -> [Vec<f64>; 3] {
        let found =
            fit::<ParameterName>(&self.machine, errors, &[], std::slice::from_ref(data), FitOptions { robust: false })
                .unwrap();
        let mut out = [const { Vec::new() }; 3];
        let mut residuals = found.residuals.iter();
        for row in &data.observations {
            for (k, _) in row.values.iter().enumerate().filter(|(_, value)| value.is_some()) {
                out[k].push(residuals.next().unwrap().2);
            }
        }
        out
    }
}

/// Displacements along the four diagonals of a space.
fn diagonals(name: &str, space: [[f64; 2]; 3], like: &DataSet) -> DataSet {
    let mut out = DataSet { name: name.to_owned(), free: vec![Free::Offset], ..like.clone() };
    let mut row = out.observations[0];
    out.observations.clear();
    out.setups.clear();
    for diagonal in 0..4_u8 {
        let label = format!("D{diagonal}");
        out.setups.push(Setup { label, ..Setup::default() });
        for step in 0..=20 {
            let share = f64::from(step) / 20.0;
            let turned = |bit: u8| if diagonal >> bit & 1 == 1 { 1.0 - share } else { share };
            let shares = [share, turned(0), turned(1)];
            let mut position = AxisVector::ZERO;
            position.set_xyz(Vector::from_fn(|k, _| space[k][0] + (space[k][1] - space[k][0]) * shares[k]));
            row.reading.position = position;
            row.reading.state = State::default();
            row.values = [Some(0.0); 3];
            row.setup = usize::from(diagonal);
            out.observations.push(row);
        }
    }
    out
}

fn sum(values: &[f64]) -> f64 {
    values.iter().map(|value| value.abs()).sum()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0_f64, |most, value| most.max(value.abs())) * 1e3
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt() * 1e3
}

/// Means over the ten directions, and the page.
struct Compared {
    means: [f64; 3],
    /// Within the reach of the plates, and of the whole space.
    diagonals: Vec<[f64; 3]>,
    /// Efficiency on the diagonals of what the plates give with terms kept that they tell badly, %.
    loose: Vec<f64>,
    lost: [Vec<String>; 3],
    table: String,
}

fn compare() -> Compared {
    let (machine, errors) = truth();
    let shop = Shop { machine, errors };
    let models = [shop.direct(), shop.plates(), shop.spheres()].map(|data| shop.calibrated(&data, MOST));
    let (loose, _) = shop.calibrated(&shop.plates(), LOOSE);
    let mut loose_shares = Vec::new();
    let none = ErrorModel::default();
    let mut table = String::new();
    let mut means = [0.0; 3];
    let mut diagonals = Vec::new();
    let mut printed = PRINTED.iter();
    let mut all: [Vec<f64>; 4] = [const { Vec::new() }; 4];
    for set in shop.held_out() {
        let measured = shop.left(&none, &set);
        let left = models.each_ref().map(|(errors, _)| shop.left(errors, &set));
        if set.name.starts_with("diagonals") {
            let whole = measured.concat();
            let left = left.map(|left| left.concat());
            let shares = left.each_ref().map(|left| 100.0 * (1.0 - sum(left) / sum(&whole)));
            let of_loose = shop.left(&loose, &set).concat();
            loose_shares.push(100.0 * (1.0 - sum(&of_loose) / sum(&whole)));
            diagonals.push(shares);
            write!(table, "| {} | all | {:.1} / {:.1} |", set.name, largest(&whole), rms(&whole)).unwrap();
            for (left, share) in left.iter().zip(shares) {
                write!(table, " {:.1} / {:.1} | {share:.0} |", largest(left), rms(left)).unwrap();
            }
            table.push_str(" – |\n");
            continue;
        }
        for (k, direction) in ["X", "Y", "Z"].into_iter().enumerate().filter(|(k, _)| !measured[*k].is_empty()) {
            let whole = &measured[k];
            write!(table, "| {} | {direction} | {:.1} / {:.1} |", set.name, largest(whole), rms(whole)).unwrap();
            all[3].extend(whole);
            for (method, left) in left.iter().enumerate() {
                let share = 100.0 * (1.0 - sum(&left[k]) / sum(whole));
                means[method] += share / 10.0;
                all[method].extend(&left[k]);
                write!(table, " {:.1} / {:.1} | {share:.0} |", largest(&left[k]), rms(&left[k])).unwrap();
            }
            let [direct, plate, bar] = printed.next().unwrap();
            writeln!(table, " {direct} {plate} {bar} |").unwrap();
        }
    }
    assert!(printed.next().is_none());
    let [of_direct, of_plate, of_bar, whole] = all.each_ref().map(|values| rms(values));
    writeln!(
        table,
        "| mean of the plates | | – / {whole:.1} | – / {of_direct:.1} | {:.1} | – / {of_plate:.1} | {:.1} | – / {of_bar:.1} | {:.1} | 80.5 83.8 51.1 |",
        means[0], means[1], means[2]
    )
    .unwrap();
    Compared { means, diagonals, loose: loose_shares, lost: models.map(|(_, lost)| lost), table }
}

/// Rank of the machine's parameters, and the variance inflation of the roll of Z, with plates of one tool vector and of two.
fn roll_of_z(places: usize, tools: &[Vector]) -> (usize, [f64; 3]) {
    let (machine, errors) = truth();
    let shop = Shop { machine, errors };
    let mut data = Vec::new();
    for tool in tools {
        for (plane, at) in [
            (Plane::XY, [350.0, 250.0, 150.0]),
            (Plane::ZX, [350.0, 150.0, 300.0]),
            (Plane::YZ, [200.0, 250.0, 300.0]),
            (Plane::XY, [350.0, 250.0, 450.0]),
            (Plane::ZX, [350.0, 350.0, 300.0]),
            (Plane::YZ, [480.0, 250.0, 300.0]),
        ]
        .into_iter()
        .take(3 * places)
        {
            data.push(shop.plate("plate", plane, at, *tool));
        }
    }
    let parameters = parameters();
    let found = identify(&shop.machine, &ErrorModel::default(), &parameters, &data).unwrap();
    let roll = ["ECZ1", "ECZ2", "ECZ3"].map(|name| {
        let name: ParameterName = name.parse().unwrap();
        let column = found.columns.iter().position(|column| *column == Column::Parameter(name)).unwrap();
        found.inflation[column]
    });
    (found.machine_rank, roll)
}

fn inflation(values: [f64; 3]) -> String {
    let shown = values.map(|value| if value.is_finite() { format!("{value:.0}") } else { "∞".to_owned() });
    shown.join(", ")
}

fn listed(names: &[String]) -> String {
    if names.is_empty() { "nothing".to_owned() } else { names.join(" ") }
}

/// Places in each plane, tools, rank, and inflation of the roll of Z.
type Told<'a> = (usize, &'a str, (usize, [f64; 3]));

fn page(compared: &Compared, tools: &[Told<'_>]) -> String {
    let mut out = String::from(
        "# Direct measurement, hole plates and ball-bar compared\n\n\
         Spaan 1995 (ch. 3) calibrated one machine in three ways. He tested each result on the same five hole plates, which were not used for\n\
         calibration. This page repeats the comparison in simulation, with plans from `ncfix plan` and the fit of `ncfix calibrate`.\n\n\
         The machine is `samples/machines/maho700s.toml` without weight and drift, with all 18 component errors. It also has errors that no cubic\n\
         function can represent:\n\n\
         - periodic screw-lead errors of 1.5 µm (X) and 1 µm (Z) with a period of 12 mm;\n\
         - bows of the fourth order of 4 µm in EYX and EXZ;\n\
         - the tilt of Y that depends on X.\n\n\
         The model is the same for all methods: cubic functions of the 18 components, with the squareness errors as slopes of Y and Z. It has\n\
         51 parameters. Parameters are omitted if the measurements cannot determine them, or if their uncertainty alone exceeds 10 µm at the tip.\n\n\
         | method | plans | standard uncertainties | not determined |\n| --- | --- | --- | --- |\n",
    );
    let rows = [
        (
            "direct",
            "`laser`, 6 components of each axis, 36 targets, 2 runs",
            "0.5 µm, 0.5 µrad; master squares with an error of 2 µrad",
        ),
        (
            "hole plates",
            "`plate`, 9 × 9 holes at 50 mm, three planes, two tools each",
            "0.7 µm; position and rotation of the plate unknown",
        ),
        (
            "ball-bar",
            "`sphere --variant spaan`, the part within the travel",
            "0.5 µm; rod lengths with an error of 1 µm, centers unknown",
        ),
    ];
    for ((name, plans, instrument), lost) in rows.iter().zip(&compared.lost) {
        writeln!(out, "| {name} | {plans} | {instrument} | {} |", listed(lost)).unwrap();
    }
    out.push_str(
        "\nEach pair is the maximum and the RMS, in µm: measured before correction, and the residual for each method. The efficiency in % follows.\n\
         The last column gives Spaan's published efficiencies (Tables 3.2, 3.3, 3.4: direct, plate, ball-bar). They are from another machine,\n\
         so compare only the order.\n\n\
         | plate | direction | measured | direct | % | plates | % | ball-bar | % | published (direct, plate, ball-bar), % |\n\
         | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    out.push_str(&compared.table);
    let shares = |shares: &[f64]| shares.iter().map(|share| format!("{share:.0} %")).collect::<Vec<_>>().join(" and ");
    let kept: Vec<f64> = compared.diagonals.iter().map(|shares| shares[1]).collect();
    writeln!(
        out,
        "\nThe limit of 10 µm matters. If terms with an uncertainty of up to 0.1 mm at the tip are kept, the model of the hole plates still fits plates.\n\
         On the diagonals its efficiency falls from {} to {}. Terms that cancel in the planes of the plates do not\n\
         cancel elsewhere. The efficiency on plates alone is no evidence for other positions. Hold out diagonals too, and compare the effects of\n\
         the parameters with their uncertainties.",
        shares(&kept),
        shares(&compared.loose),
    )
    .unwrap();
    out.push_str(
        "\
         \n## One tool vector or two\n\n\
         ECZ, the roll of the axis that carries the spindle, does not move a tip in line with the spindle. Plates were measured in three planes, at\n\
         one or two places each, with every tool. The model has all 51 parameters. A lateral stylus determines ECZ completely only with two\n\
         places, and only if both styli have the same length. If their lengths differ by 40 mm, only the sum\n\
         120 ECZ + 40 EAZ is determined.\n\n\
         | places | tools | determined, of 51 | variance inflation of ECZ1, ECZ2, ECZ3 |\n| --- | --- | --- | --- |\n",
    );
    for (places, name, (rank, roll)) in tools {
        writeln!(out, "| {places} | {name} | {rank} | {} |", inflation(*roll)).unwrap();
    }
    out
}

/// Run with `NCFIX_WRITE_DOCS=1` to write the page anew.
#[test]
fn three_methods_and_two_tools() {
    let compared = compare();
    let [direct, plates, bar] = compared.means;
    let [short, long, aside] = [
        ("110 mm along the spindle", &[SHORT][..]),
        ("110 mm and 245 mm along it", &[SHORT, LONG]),
        ("110 mm, and 110 mm with 120 mm to the side", &[SHORT, ASIDE]),
    ];
    let other = ("110 mm, and 150 mm with 120 mm to the side", &[SHORT, RIGHT][..]);
    let all = ("110 mm, 245 mm, and 110 mm with 120 mm to the side", &[SHORT, LONG, ASIDE][..]);
    let tools =
        [(1, short), (1, long), (1, aside), (1, other), (2, short), (2, long), (2, aside), (2, other), (2, all)]
            .map(|(places, (name, tools))| (places, name, roll_of_z(places, tools)));
    // Nothing along the spindle tells the roll, however many lengths and places there are. A stylus to the side does where plates lie at two places
    // and it is as long: from one of another length comes 120 ECZ + 40 EAZ.
    for (places, name, (_, roll)) in &tools {
        if [short.0, long.0].contains(name) {
            assert!(roll.iter().all(|value| value.is_infinite()), "{places} {name}: {roll:?}");
        } else {
            let is_told = *places == 2 && *name != other.0;
            assert_eq!(roll.iter().all(|value| value.is_finite()), is_told, "{places} {name}: {roll:?}");
        }
    }
    let text = page(&compared, &tools);
    let path = repository("docs/explanation/comparison.md");
    if std::env::var_os("NCFIX_WRITE_DOCS").is_some() {
        std::fs::write(&path, &text).unwrap();
    }
    // As printed: direct measurement and plates say most of it, spheres with two lengths of a tool along the spindle less.
    assert!(direct > 70.0 && plates > 70.0, "{:?}\n{text}", compared.means);
    assert!(bar < direct && bar < plates && bar > 20.0, "{:?}\n{text}", compared.means);
    assert!(["ECZ1", "ECZ2", "ECZ3"].iter().all(|name| compared.lost[2].iter().any(|lost| lost == name)));
    // Terms that are told badly do their harm where no plate lay.
    for (shares, loose) in compared.diagonals.iter().zip(&compared.loose) {
        assert!(shares[0] > 70.0 && shares[1] > loose + 20.0, "{shares:?} {loose}\n{text}");
    }
    let written = std::fs::read_to_string(&path).unwrap_or_default().replace("\r\n", "\n");
    let different = written.lines().zip(text.lines()).find(|(is, should)| is != should);
    assert_eq!(different, None, "run this test with NCFIX_WRITE_DOCS=1");
    assert_eq!(written.lines().count(), text.lines().count(), "run this test with NCFIX_WRITE_DOCS=1");
}

#[test]
fn the_printed_means_are_those_of_the_printed_tables() {
    for (k, mean) in [80.5, 83.8, 51.1].into_iter().enumerate() {
        let found = PRINTED.iter().map(|row| row[k]).sum::<f64>() / 10.0;
        assert!((found - mean).abs() < 0.05 + 1e-9, "{found} {mean}");
    }
}
