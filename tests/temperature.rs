//! Temperature, statistical: zero-point drift and expansion by hand arithmetic, on either side of the machine.

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::{Condition, Machine, State};
use ncfix_model::{ErrorModel, Model, file};

fn source(text: &str) -> Source {
    Source::new(FileId(0), "machine.toml", text.as_bytes().to_vec()).unwrap()
}

fn load(text: &str) -> (Option<(Machine, ErrorModel)>, Vec<Diagnostic>) {
    file::load(&source(text))
}

#[track_caller]
fn sound(text: &str) -> (Machine, ErrorModel) {
    let (machine, findings) = load(text);
    assert!(findings.is_empty(), "{findings:#?}");
    machine.unwrap()
}

/// A machine without errors: topology and the axes that move to the negative side for a positive command.
fn bare(topology: &str, backwards: &str) -> String {
    let mut text = format!("[machine]\nname = \"t\"\ntopology = \"{topology}\"\n");
    for letter in topology.chars().filter(|letter| "XYZABC".contains(*letter)) {
        let index = "XYZABC".find(letter).unwrap() % 3;
        let mut direction = [0, 0, 0];
        direction[index] = if backwards.contains(letter) { -1 } else { 1 };
        let travel = if "XYZ".contains(letter) { "travel_mm = [-1000, 1000]" } else { "travel_deg = [-180, 180]" };
        text += &format!("[axis.{letter}]\ndirection = {direction:?}\n{travel}\n");
    }
    text
}

fn at(pose: &[(Axis, f64)]) -> AxisVector {
    let mut command = AxisVector::ZERO;
    for &(axis, value) in pose {
        command[axis] = value;
    }
    command
}

fn readings(temperatures_c: &[(&str, f64)]) -> Condition {
    let mut condition = Condition::default();
    for (sensor, value) in temperatures_c {
        condition.add_reading(sensor, 0.0, *value);
    }
    condition
}

/// Displacement of the tool relative to the workpiece, µm.
fn tip_um(machine: &(Machine, ErrorModel), condition: &Condition, command: &AxisVector) -> Vector {
    let tool_mm = Vector::new(12.0, -7.0, -150.0);
    let model = Model::at(&machine.0, &machine.1, condition);
    model.tip_error_mm(command, command, &tool_mm, &State::default()) * 1e3
}

#[track_caller]
fn close(found: Vector, expected: [f64; 3]) {
    assert!((found - Vector::from(expected)).norm() < 1e-9, "{found} instead of {expected:?}");
}

const DRIFT: &str = "[sensor.T_bed]\nreference_C = 18.5\n[[drift]]\ndirection = \"Y\"\n\
    sensors = [{ name = \"T_head\", um_per_K = 3.1 }, { name = \"T_bed\", um_per_K = -0.8 }]\n";

#[test]
fn a_drift_without_positions_displaces_the_tool_everywhere() {
    let condition = readings(&[("T_head", 27.5), ("T_bed", 21.0)]);
    // 3.1 · 7.5 − 0.8 · 2.5
    let drift_um = 21.25;
    for (topology, backwards) in
        [("wFXYZSt", ""), ("wXYFZSt", "XY"), ("wZYXFSt", "XYZ"), ("wCAYFXZSt", "Y"), ("wFYCBXZSt", "")]
    {
        let machine = sound(&(bare(topology, backwards) + DRIFT));
        for position in [0.0, 400.0] {
            let command = at(&[(Axis::X, position), (Axis::Y, -position), (Axis::Z, 0.5 * position)]);
            close(tip_um(&machine, &condition, &command), [0.0, drift_um, 0.0]);
        }
    }
    // A table that has turned by 90° sees F's Y as its own X.
    let turned = at(&[(Axis::X, 30.0), (Axis::C, 90_f64.to_radians())]);
    close(tip_um(&sound(&(bare("wCAYFXZSt", "Y") + DRIFT)), &condition, &turned), [drift_um, 0.0, 0.0]);
    // The head of a machine that turns on the tool side does not turn it.
    close(tip_um(&sound(&(bare("wFYCBXZSt", "") + DRIFT)), &condition, &turned), [0.0, drift_um, 0.0]);
}

/// Coefficients for one sensor at three positions, not in order.
fn over(direction: char, axis: char, entries: &[(f64, f64)]) -> String {
    let key = if "ABC".contains(axis) { "at_deg" } else { "at_mm" };
    let entry = |(at, um_per_k): &(f64, f64)| {
        format!(
            "[[drift]]\ndirection = \"{direction}\"\nover = \"{axis}\"\n{key} = {at}\n\
             sensors = [{{ name = \"T_head\", um_per_K = {um_per_k} }}]\n"
        )
    };
    entries.iter().map(entry).collect()
}

#[test]
fn between_positions_a_drift_is_linear_and_outside_constant() {
    let condition = readings(&[("T_head", 25.0)]);
    let entries = over('Z', 'X', &[(400.0, 3.0), (0.0, 1.0), (200.0, -2.0)]);
    for (topology, backwards) in [("wFXYZSt", ""), ("wXYFZSt", "XY"), ("wYFXZSt", "XY"), ("wZFXYSt", "Z")] {
        let machine = sound(&(bare(topology, backwards) + &entries));
        for (x_mm, drift_um) in
            [(-50.0, 5.0), (0.0, 5.0), (50.0, 1.25), (200.0, -10.0), (300.0, 2.5), (400.0, 15.0), (500.0, 15.0)]
        {
            let command = at(&[(Axis::X, x_mm), (Axis::Z, 33.0)]);
            close(tip_um(&machine, &condition, &command), [0.0, 0.0, drift_um]);
        }
    }
}

#[test]
fn over_a_rotary_axis_a_drift_stays_along_the_axes_of_the_machine() {
    let condition = readings(&[("T_head", 22.0)]);
    let entries = over('X', 'B', &[(0.0, 1.5), (90.0, 4.0)]) + &over('Z', 'B', &[(0.0, -2.0), (90.0, 0.5)]);
    for lever in ["carried", "fixed"] {
        let bare = bare("wFXYZBSt", "").replace("[axis.B]\n", &format!("[axis.B]\nlever = \"{lever}\"\n"));
        let machine = sound(&(bare + &entries));
        close(tip_um(&machine, &condition, &at(&[(Axis::X, 9.0)])), [3.0, 0.0, -4.0]);
        close(tip_um(&machine, &condition, &at(&[(Axis::B, 90_f64.to_radians())])), [8.0, 0.0, 1.0]);
    }
    let table = sound(&(bare("wCFXYZSt", "") + &over('Y', 'C', &[(0.0, 1.0), (90.0, 2.0)])));
    close(tip_um(&table, &condition, &AxisVector::ZERO), [0.0, 2.0, 0.0]);
    // F's Y as the table sees it that has turned.
    close(tip_um(&table, &condition, &at(&[(Axis::C, 90_f64.to_radians())])), [4.0, 0.0, 0.0]);
}

#[test]
fn a_sensor_is_followed_with_its_lag() {
    let text = bare("wFXYZSt", "")
        + "[[drift]]\ndirection = \"Z\"\nsensors = [{ name = \"T_head\", um_per_K = 4.0, lag_s = 600 }, \
           { name = \"T_head\", um_per_K = -1.0 }]\n";
    let machine = sound(&text);
    let input_c = |time_s: f64| {
        21.0 + 12.0 * (time_s / 1500.0).clamp(0.0, 1.0) - 6.0 * ((time_s - 1500.0) / 900.0).clamp(0.0, 1.0)
    };
    let mut condition = Condition::default();
    for time_s in [0.0, 1500.0, 2400.0] {
        condition.add_reading("T_head", time_s, input_c(time_s));
    }
    // 600 s · dT′/dt = T − T′ by the midpoint rule.
    let (step_s, lag_s) = (0.05, 600.0);
    let mut follower_c = 21.0;
    for step in 0..=100_000 {
        let time_s = step_s * f64::from(step);
        if step % 10_000 == 0 {
            condition.set_time(time_s);
            let expected = 4.0 * (follower_c - 20.0) - (input_c(time_s) - 20.0);
            let found = tip_um(&machine, &condition, &AxisVector::ZERO);
            assert!((found.z - expected).abs() < 1e-5, "{time_s} s: {found} instead of {expected}");
        }
        let middle_c = follower_c + 0.5 * step_s * (input_c(time_s) - follower_c) / lag_s;
        follower_c += step_s * (input_c(time_s + 0.5 * step_s) - middle_c) / lag_s;
    }
}

const EXPANSION: &str = "[[expansion]]\naxis = \"X\"\nfixed_mm = 350\n\
    scale = { sensors = [\"T_1\", \"T_2\", \"T_3\"], um_per_m_K = 8.0 }\n\
    workpiece = { sensors = [\"T_work\"], um_per_m_K = 11.5, fixed_mm = 200 }\n";

/// Where the tool is in relation to the spot of the warm workpiece that it shall touch, µm along F, from the places of both: the line of
/// the scale that reads x, and the spot that was at x when everything had the reference temperature. `sense` is the motion of the tool
/// over the workpiece for a positive command.
fn off_the_spot_um(x_mm: f64, sense: f64, scale_k: f64, workpiece_k: f64) -> f64 {
    let line_mm = 350.0 + (x_mm - 350.0) * (1.0 + 8.0e-6 * scale_k);
    let spot_mm = 200.0 + (x_mm - 200.0) * (1.0 + 11.5e-6 * workpiece_k);
    sense * (line_mm - spot_mm) * 1e3
}

#[test]
fn scale_and_workpiece_expand_on_either_side() {
    let condition = readings(&[("T_1", 21.0), ("T_2", 22.0), ("T_3", 26.0), ("T_work", 24.0)]);
    // The tool moves over the workpiece towards +X where it carries X, or where the table moves towards −X.
    for (topology, backwards, sense) in
        [("wFXYZSt", "", 1.0), ("wFXYZSt", "X", -1.0), ("wXYFZSt", "XY", 1.0), ("wXYFZSt", "Y", -1.0)]
    {
        let machine = sound(&(bare(topology, backwards) + EXPANSION));
        for x_mm in [-100.0, 200.0, 350.0, 600.0] {
            let command = at(&[(Axis::X, x_mm), (Axis::Y, 80.0)]);
            let expected = off_the_spot_um(x_mm, sense, 3.0, 4.0);
            close(tip_um(&machine, &condition, &command), [expected, 0.0, 0.0]);
        }
    }
    // 8 · 3 · 0.25 − 11.5 · 4 · 0.4
    assert!((off_the_spot_um(600.0, 1.0, 3.0, 4.0) - -12.4).abs() < 1e-9);
}

#[test]
fn weights_and_lost_sensors_make_the_mean() {
    let machine = sound(&(bare("wFXYZSt", "") + EXPANSION));
    let x_600 = at(&[(Axis::X, 600.0)]);
    // The mean of 21 and 26 °C, and no word of the workpiece: 8 · 3.5 · 0.25.
    close(tip_um(&machine, &readings(&[("T_1", 21.0), ("T_3", 26.0)]), &x_600), [7.0, 0.0, 0.0]);
    let text = EXPANSION.replace("um_per_m_K = 8.0", "um_per_m_K = 8.0, weights = [1, 0, 3]");
    let machine = sound(&(bare("wFXYZSt", "") + &text));
    let condition = readings(&[("T_1", 21.0), ("T_2", 99.0), ("T_3", 25.0)]);
    close(tip_um(&machine, &condition, &x_600), [8.0, 0.0, 0.0]);
    // The only sensor with a reading does not count.
    close(tip_um(&machine, &readings(&[("T_2", 99.0)]), &x_600), [0.0; 3]);
}

#[test]
fn setting_the_zero_point_ends_a_drift_but_no_expansion() {
    let machine = sound(&(bare("wFXYZSt", "") + EXPANSION + DRIFT));
    let mut condition = readings(&[("T_1", 23.0), ("T_head", 27.5), ("T_bed", 21.0)]);
    let x_600 = at(&[(Axis::X, 600.0)]);
    close(tip_um(&machine, &condition, &x_600), [6.0, 21.25, 0.0]);
    // 3.1 · (27.5 − 24.5) − 0.8 · (21 − 20), whatever the reference temperature.
    condition.set_zero(readings(&[("T_1", 21.0), ("T_head", 24.5), ("T_bed", 20.0)]));
    close(tip_um(&machine, &condition, &x_600), [6.0, 8.5, 0.0]);
    let mut log = Condition::default();
    for (time_s, value) in [(0.0, 20.0), (100.0, 30.0), (200.0, 24.0)] {
        log.add_reading("T_head", time_s, value);
    }
    log.set_zero_at(50.0);
    for (time_s, drift_um) in [(50.0, 0.0), (100.0, 15.5), (150.0, 6.2)] {
        log.set_time(time_s);
        close(tip_um(&machine, &log, &x_600), [0.0, drift_um, 0.0]);
    }
}

#[test]
fn nothing_is_added_without_parameters_rise_or_readings() {
    let full = bare("wFXYZSt", "") + EXPANSION + DRIFT + &over('X', 'Z', &[(0.0, 1.0), (300.0, 2.0)]);
    let (machine, mut errors) = sound(&full);
    let warm = readings(&[("T_1", 23.0), ("T_work", 30.0), ("T_head", 27.5), ("T_bed", 21.0)]);
    assert_eq!(errors.sensors(), ["T_1", "T_2", "T_3", "T_bed", "T_head", "T_work"]);
    assert!(!Model::at(&machine, &errors, &warm).is_empty());
    assert!(Model::new(&machine, &errors).is_empty());
    let cold = readings(&[("T_1", 20.0), ("T_work", 20.0), ("T_head", 20.0), ("T_bed", 18.5)]);
    assert!(Model::at(&machine, &errors, &cold).is_empty());
    let mut names = Vec::new();
    for effect in errors.effects_mut() {
        effect.visit_parameters(&mut |parameter, value| {
            names.push(parameter.name.to_owned());
            *value = 0.0;
        });
    }
    let expected = [
        "drift.X@Z0.T_head",
        "drift.X@Z300.T_head",
        "drift.Y.T_head",
        "drift.Y.T_bed",
        "expansion.X.scale",
        "expansion.X.workpiece",
    ]
    .map(str::to_owned);
    assert_eq!(names, expected);
    assert!(Model::at(&machine, &errors, &warm).is_empty());
}

/// Code and the text at the place of each finding.
fn seen(text: &str) -> Vec<(String, String)> {
    let source = source(text);
    let at = |finding: &Diagnostic| String::from_utf8_lossy(source.slice(finding.place.unwrap().span)).into();
    load(text).1.iter().map(|finding| (finding.code.to_string(), at(finding))).collect()
}

#[track_caller]
fn finds(section: &str, expected: &[(&str, &str)]) {
    let text = bare("wFXYBZSt", "") + section;
    let expected: Vec<(String, String)> = expected.iter().map(|(code, at)| ((*code).into(), (*at).into())).collect();
    assert_eq!(seen(&text), expected, "{section}");
}

#[test]
fn faults_of_drifts_are_found_at_their_places() {
    let entry = |head: &str| format!("[[drift]]\n{head}\nsensors = [{{ name = \"T\", um_per_K = 1 }}]\n");
    finds(&entry("direction = \"Q\""), &[("E0404", "\"Q\"")]);
    finds(&entry("direction = \"X\"\nover = \"Q\"\nat_mm = 1"), &[("E0404", "\"Q\"")]);
    finds(&entry("direction = \"X\"\nover = \"C\"\nat_deg = 1"), &[("E0404", "\"C\"")]);
    finds(&entry("direction = \"X\"\nover = \"X\"\nat_deg = 1"), &[("E0407", "at_deg")]);
    finds(&entry("direction = \"X\"\nover = \"B\"\nat_mm = 1"), &[("E0407", "at_mm")]);
    finds(&entry("direction = \"X\"\nover = \"X\""), &[("E0403", "[[drift]]")]);
    finds(&entry("direction = \"X\"\nat_mm = 1"), &[("E0403", "at_mm")]);
    let endless = bare("wFXYBZSt", "").replace("travel_deg = [-180, 180]", "modulo = true");
    let turned = endless + &entry("direction = \"X\"\nover = \"B\"\nat_deg = -90");
    assert_eq!(seen(&turned), [("E0404".to_owned(), "-90".to_owned())]);
    // B carries Z.
    finds(&entry("direction = \"X\"\nover = \"Z\"\nat_mm = 1"), &[("E0404", "\"Z\"")]);
    finds("[[drift]]\ndirection = \"X\"\n", &[("E0403", "[[drift]]")]);
    finds("[[drift]]\ndirection = \"X\"\nsensors = []\n", &[("E0404", "[]")]);
    finds(
        "[[drift]]\ndirection = \"X\"\nsensors = [{ name = 3, um_per_K = \"a\", lag_s = -1, tau_s = 3 }]\n",
        &[("E0404", "3"), ("E0404", "\"a\""), ("E0404", "-1"), ("E0402", "tau_s")],
    );
    let twice = entry("direction = \"X\"") + &entry("direction = \"X\"");
    finds(&twice, &[("E0408", "[[drift]]")]);
    let mixed = entry("direction = \"X\"\nover = \"X\"\nat_mm = 1") + &entry("direction = \"X\"");
    finds(&mixed, &[("E0404", "[[drift]]")]);
    let other_axis = entry("direction = \"X\"\nover = \"X\"\nat_mm = 1")
        + &entry("direction = \"X\"\nover = \"Y\"\nat_mm = 1")
        + &entry("direction = \"Z\"\nover = \"Y\"\nat_mm = 1");
    finds(&other_axis, &[("E0404", "[[drift]]")]);
    let place_twice = [3, 1, 3].map(|at| entry(&format!("direction = \"X\"\nover = \"X\"\nat_mm = {at}")));
    finds(&place_twice.concat(), &[("E0408", "[[drift]]")]);
}

#[test]
fn faults_of_expansions_are_found_at_their_places() {
    let entry = |keys: &str| format!("[[expansion]]\n{keys}\n");
    let scale = "scale = { sensors = [\"T\"], um_per_m_K = 8 }";
    finds(&entry(&format!("axis = \"B\"\nfixed_mm = 0\n{scale}")), &[("E0404", "\"B\"")]);
    finds(&entry("axis = \"X\"\nfixed_mm = 0"), &[("E0403", "[[expansion]]")]);
    finds(&entry(&format!("axis = \"X\"\n{scale}")), &[("E0403", "{ sensors = [\"T\"], um_per_m_K = 8 }")]);
    finds(&(entry(&format!("axis = \"X\"\nfixed_mm = 0\n{scale}")).repeat(2)), &[("E0404", "\"X\"")]);
    let weights = |weights: &str| {
        entry(&format!(
            "axis = \"X\"\nfixed_mm = 0\nworkpiece = {{ sensors = [\"T\", \"U\"], weights = {weights}, um_per_m_K = 8 }}"
        ))
    };
    for bad in ["[1]", "[1, -1]", "[0, 0]", "[1, \"a\"]"] {
        finds(&weights(bad), &[("E0404", bad)]);
    }
    finds(
        &weights("[1, 0]").replace("um_per_m_K", "um_per_K"),
        &[("E0403", "{ sensors = [\"T\", \"U\"], weights = [1, 0], um_per_K = 8 }"), ("E0402", "um_per_K")],
    );
}

/// The tool holder also turns (Spaan 1995, Fig. 5.1). At a rise of 5 K it turns by 20 µrad about X and −15 µrad about Y. The tip is at (12, −7, −150) mm from
/// the gauge point, so ω × r is 15 · 0.150 = 2.25 µm along X, 20 · 0.150 = 3 µm along Y, and −20 · 0.007 + 15 · 0.012 = 0.04 µm along Z.
#[test]
fn rotations_of_the_tool_holder_move_the_tip_by_its_arm() {
    let turned = "[[drift]]\ndirection = \"A\"\nsensors = [{ name = \"T_head\", urad_per_K = 4 }]\n\
        [[drift]]\ndirection = \"B\"\nsensors = [{ name = \"T_head\", urad_per_K = -3 }]\n";
    for (topology, backwards) in [("wFXYZSt", ""), ("wXYFZSt", "XY"), ("wCAYFXZSt", "Y")] {
        let machine = sound(&(bare(topology, backwards) + turned));
        let found = tip_um(&machine, &readings(&[("T_head", 25.0)]), &at(&[(Axis::X, 30.0)]));
        assert!((found - Vector::new(2.25, 3.0, 0.04)).norm() < 1e-3, "{topology}: {found}");
    }
    // A rotation has no unit of length, and no positions.
    for (wrong, code) in [
        ("[[drift]]\ndirection = \"A\"\nsensors = [{ name = \"T\", um_per_K = 4 }]\n", "urad_per_K"),
        (
            "[[drift]]\ndirection = \"A\"\nover = \"Z\"\nat_mm = 0\nsensors = [{ name = \"T\", urad_per_K = 4 }]\n",
            "a rotation of the tool holder over an axis",
        ),
    ] {
        let (machine, findings) = load(&(bare("wFXYZSt", "") + wrong));
        assert!(machine.is_none(), "{wrong}");
        assert!(findings.iter().any(|one| one.message.contains(code) || one.help.contains(code)), "{findings:#?}");
    }
}
