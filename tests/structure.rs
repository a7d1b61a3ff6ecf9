//! Heat in the structure: segments that expand, bend and twist, against formulas of beams and against numerical integration along the beam.

use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::{Condition, Machine, State};
use ncfix_model::{ErrorModel, Model, Twist};

const HEAD: &str = "[machine]\nname = \"test\"\ntopology = \"wXYFZSt\"\n[axis.X]\ndirection = [-1, 0, 0]\ntravel_mm = [0, 800]\n\
    [axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [0, 500]\n[axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 600]\npoint_mm = [10, 20, 30]\n";

#[track_caller]
fn load(text: &str) -> (Machine, ErrorModel) {
    let source = Source::new(FileId(0), "test.toml", format!("{HEAD}{text}").into_bytes()).unwrap();
    let (loaded, findings) = ncfix_model::file::load(&source);
    assert!(findings.is_empty(), "{findings:?}");
    loaded.unwrap()
}

fn warm(readings: &[(&str, f64)]) -> Condition {
    let mut condition = Condition::default();
    readings.iter().for_each(|&(sensor, rise)| condition.add_reading(sensor, 0.0, 20.0 + rise));
    condition
}

const TOOL: Vector = Vector::new(5.0, -3.0, -150.0);

fn deviation(text: &str, condition: &Condition, xyz: [f64; 3]) -> Twist {
    let (machine, errors) = load(text);
    let mut command = AxisVector::ZERO;
    command.set_xyz(Vector::from(xyz));
    Model::at(&machine, &errors, condition).deviation(&command, &TOOL, &State::default())
}

/// The tip in F at the zero pose of the table: the tool side carries it.
fn tip(z: f64) -> Vector {
    Vector::new(0.0, 0.0, z) + TOOL
}

#[track_caller]
fn assert_near(found: &Twist, translation: Vector, rotation: Vector) {
    // Rotations are exact, these formulas are of first order: half the square of the angle times the arm stays open.
    let open = 2e-7 + 500.0 * rotation.norm_squared();
    assert!((found.translation - translation).norm() < open, "{} instead of {translation}", found.translation);
    assert!((found.rotation - rotation).norm() < 1e-10, "{} instead of {rotation}", found.rotation);
}

/// A column of 700 mm along Z, 350 mm deep along Y, 280 mm wide, clamped at (0, 300, -500); Z stands on its end.
const COLUMN: &str = "[[segment]]\nname = \"column\"\nbefore = \"Z\"\nfrom_mm = [0, 300, -500]\nto_mm = [0, 300, 200]\num_per_m_K = 12\n\
    across = [0, 1, 0]\nacross_mm = 350\nwide_mm = 280\nsensors_from = [\"a\", \"b\", \"c\", \"d\"]\n";

#[test]
fn a_warm_beam_grows() {
    // 12e-6 · 3 K · 700 mm.
    let found = deviation(COLUMN, &warm(&[("a", 3.0), ("b", 3.0), ("c", 3.0), ("d", 3.0)]), [100.0, 50.0, 40.0]);
    assert_near(&found, Vector::new(0.0, 0.0, 0.0252), Vector::zeros());
}

#[test]
fn a_gradient_bends_it_into_an_arc_away_from_the_warm_side() {
    // Corners b and c, at +Y, are 2 K warmer: curvature 12e-6 · 2 / 350, an arc of 700 mm.
    let found = deviation(COLUMN, &warm(&[("a", -1.0), ("b", 1.0), ("c", 1.0), ("d", -1.0)]), [100.0, 50.0, 40.0]);
    let angle = 12e-6 * 2.0 / 350.0 * 700.0;
    // The end leans towards -Y: about +X, as a vector along Z that turns about +X leans towards -Y.
    let turn = Vector::new(angle, 0.0, 0.0);
    let end = Vector::new(0.0, 300.0, 200.0);
    let shift = Vector::new(0.0, -0.5 * angle * 700.0, 0.0) + turn.cross(&(tip(40.0) - end));
    assert_near(&found, shift, turn);
    // The same across: corners c and d are at +n, n = Z × Y = -X.
    let found = deviation(COLUMN, &warm(&[("a", -1.0), ("b", -1.0), ("c", 1.0), ("d", 1.0)]), [0.0; 3]);
    let angle = 12e-6 * 2.0 / 280.0 * 700.0;
    // Warm at -X, so the end goes towards +X, which is a turn about +Y.
    let turn = Vector::new(0.0, angle, 0.0);
    let shift = Vector::new(0.5 * angle * 700.0, 0.0, 0.0) + turn.cross(&(tip(0.0) - end));
    assert_near(&found, shift, turn);
}

#[test]
fn walls_that_bend_differently_twist_it() {
    // At +n (-X) the gradient along Y is 4 K, at -n it is 0: mean gradient 2 K, difference 4 K.
    let condition = warm(&[("a", 0.0), ("b", 0.0), ("c", 4.0), ("d", 0.0)]);
    let whole = deviation(COLUMN, &condition, [0.0; 3]);
    let without = deviation(&format!("{COLUMN}torsion_share = 0\n"), &condition, [0.0; 3]);
    // The wall at -X moves by ½ κ L² towards -Y, the one at +X stays: 280 mm apart. Towards -Y at -X is a turn about +Z.
    let angle = 0.5 * 12e-6 * 4.0 / 350.0 * 700.0 * 700.0 / 280.0;
    let twist = whole.rotation - without.rotation;
    assert!((twist - Vector::new(0.0, 0.0, angle)).norm() < 1e-9, "{twist} {angle}");
    let half = deviation(&format!("{COLUMN}torsion_share = 0.5\n"), &condition, [0.0; 3]);
    assert!((half.rotation - without.rotation - twist * 0.5).norm() < 1e-9);
}

/// The same beam in 7000 slices, each a little turned by the one before.
#[test]
fn temperatures_that_change_along_it_are_integrated() {
    let text = format!("{COLUMN}sensors_to = [\"e\", \"f\", \"g\", \"h\"]\ntorsion_share = 0\n");
    let corners = [[1.0, 2.5, 3.0, 0.5], [4.0, 2.0, -1.0, 0.0]];
    let names = [["a", "b", "c", "d"], ["e", "f", "g", "h"]];
    let readings: Vec<(&str, f64)> = names.iter().flatten().copied().zip(corners.iter().flatten().copied()).collect();
    let found = deviation(&text, &warm(&readings), [0.0, 0.0, 250.0]);
    let slices = 7000;
    let (mut turn, mut end, step) = (Vector::zeros(), Vector::zeros(), 700.0 / f64::from(slices));
    for k in 0..slices {
        let share = (f64::from(k) + 0.5) / f64::from(slices);
        let [a, b, c, d] = std::array::from_fn(|i| corners[0][i] + (corners[1][i] - corners[0][i]) * share);
        let mean = (a + b + c + d) / 4.0;
        let towards_y = ((b + c) - (a + d)) / 2.0;
        let towards_minus_x = ((c + d) - (a + b)) / 2.0;
        let bend = Vector::new(12e-6 * towards_y / 350.0, 12e-6 * towards_minus_x / 280.0, 0.0) * step;
        end += Vector::new(0.0, 0.0, 12e-6 * mean * step) + (turn + bend * 0.5).cross(&Vector::new(0.0, 0.0, step));
        turn += bend;
    }
    let shift = end + turn.cross(&(tip(250.0) - Vector::new(0.0, 300.0, 200.0)));
    assert_near(&found, shift, turn);
}

/// Z slides along the column: its scale, straightness and angle change with its place. The tool hangs on the slide.
#[test]
fn an_axis_that_slides_along_it_has_its_scale_straightness_and_angles() {
    for lever in ["carried", "fixed"] {
        let head = HEAD.replace("point_mm = [10, 20, 30]", &format!("point_mm = [10, 20, 30]\nlever = \"{lever}\""));
        let text = COLUMN.replace("before = \"Z\"", "before = \"Z\"\nalong = \"Z\"\nat_mm = 80");
        let source = Source::new(FileId(0), "test.toml", format!("{head}{text}").into_bytes()).unwrap();
        let (loaded, findings) = ncfix_model::file::load(&source);
        assert!(findings.is_empty(), "{findings:?}");
        let (machine, errors) = loaded.unwrap();
        let condition = warm(&[("a", 1.0), ("b", 3.0), ("c", 3.0), ("d", 1.0)]);
        let model = Model::at(&machine, &errors, &condition);
        for z in [0.0, 120.0, 600.0] {
            let mut command = AxisVector::ZERO;
            command[Axis::Z] = z;
            let found = model.deviation(&command, &TOOL, &State::default());
            let reach = 80.0 + z;
            let angle = 12e-6 * 2.0 / 350.0 * reach;
            let turn = Vector::new(angle, 0.0, 0.0);
            let slide = Vector::new(0.0, 300.0, -500.0 + reach);
            let shift = Vector::new(0.0, -0.5 * angle * reach, 12e-6 * 2.0 * reach) + turn.cross(&(tip(z) - slide));
            assert_near(&found, shift, turn);
        }
    }
}

#[test]
fn on_the_table_side_the_workpiece_moves() {
    let text = "[[segment]]\nname = \"bed\"\nbefore = \"Y\"\nfrom_mm = [0, 0, -600]\nto_mm = [0, 0, -400]\num_per_m_K = 10\nsensors_from = [\"a\"]\n";
    // 10e-6 · 5 K · 200 mm upwards for the table.
    let found = deviation(text, &warm(&[("a", 5.0)]), [0.0; 3]);
    assert_near(&found, Vector::new(0.0, 0.0, -0.01), Vector::zeros());
    let spindle = text.replace("before = \"Y\"", "before = \"S\"");
    assert_near(&deviation(&spindle, &warm(&[("a", 5.0)]), [0.0; 3]), Vector::new(0.0, 0.0, 0.01), Vector::zeros());
}

#[test]
fn what_was_there_when_the_zero_point_was_set_does_not_count() {
    let mut condition = warm(&[("a", 5.0), ("b", 5.0), ("c", 5.0), ("d", 5.0)]);
    condition.set_zero(warm(&[("a", 3.0), ("b", 3.0), ("c", 3.0), ("d", 3.0)]));
    assert_near(&deviation(COLUMN, &condition, [0.0; 3]), Vector::new(0.0, 0.0, 12e-6 * 2.0 * 700.0), Vector::zeros());
}

#[test]
fn faults_of_a_segment_have_their_place() {
    for (from, to, code) in [
        ("to_mm = [0, 300, 200]", "to_mm = [0, 300, -500]", "E0404:18"),
        ("across = [0, 1, 0]", "across = [0, 1, 1]", "E0404:20"),
        ("\"c\", ", "", "E0404:23"),
        ("wide_mm = 280\n", "", "E0404:22"),
        ("across_mm = 350\n", "", "E0404:22"),
        ("before = \"Z\"", "before = \"B\"", "E0404:16"),
        ("before = \"Z\"", "before = \"Z\"\nalong = \"X\"\nat_mm = 5", "E0404:17"),
        // X is behind it, but slides across it.
        ("before = \"Z\"", "before = \"X\"\nalong = \"X\"\nat_mm = 5", "E0404:17"),
        ("before = \"Z\"", "before = \"Z\"\nalong = \"Z\"", "E0403:14"),
        ("um_per_m_K = 12", "um_per_K = 12", "E0403:14"),
        ("across_mm = 350", "across_mm = 0", "E0404:21"),
    ] {
        let text = COLUMN.replace(from, to);
        assert_ne!(text, COLUMN, "{from}");
        let source = Source::new(FileId(0), "test.toml", format!("{HEAD}{text}").into_bytes()).unwrap();
        let (loaded, findings) = ncfix_model::file::load(&source);
        assert!(loaded.is_none());
        let line = |place: ncfix_base::diagnostic::Place| {
            source.bytes()[..place.span.range().start].iter().filter(|&&byte| byte == b'\n').count() + 1
        };
        let found: Vec<String> =
            findings.iter().map(|finding| format!("{}:{}", finding.code, line(finding.place.unwrap()))).collect();
        assert!(found.contains(&code.to_owned()), "{to}: {found:?}");
    }
}
