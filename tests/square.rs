//! `ncfix square`: squareness from diagonals and from a square, its sign on several chains, and the files that are written.

use nalgebra::{Rotation3, Vector3};

use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_machine::machine::State;
use ncfix_model::Model;

use crate::machine_file::load;
use crate::support::Shop;

/// A machine with the axes of a chain; a slide that carries the workpiece moves against its letter.
fn machine(topology: &str) -> String {
    let before = topology.split_once('F').unwrap().0;
    let mut text =
        format!("# mine\n[machine]\nname = \"m\"\ntopology = \"{topology}\"   # chain\ncontroller = \"rs274\"\n");
    for (place, letter) in ["X", "Y", "Z"].iter().enumerate() {
        let mut direction = [0; 3];
        direction[place] = if before.contains(letter) { -1 } else { 1 };
        text += &format!("\n[axis.{letter}]\ndirection = {direction:?}\ntravel_mm = [-1000, 1000]\n");
    }
    text
}

fn square(shop: &Shop, further: &[&str]) -> crate::support::Run {
    let words = ["square", "--machine", "m.toml"].into_iter().chain(further.iter().copied());
    shop.run(words)
}

/// Place of the tool in the part for a command, with the forward model of ncfix.
fn place(model: &Model, [x, y, z]: [f64; 3]) -> Vector3<f64> {
    let mut command = AxisVector::ZERO;
    command.set_xyz(Vector::from([x, y, z]));
    let pose = model.actual(&command, &Vector::zeros(), &State::default());
    Vector3::new(pose.translation.x, pose.translation.y, pose.translation.z)
}

#[test]
fn the_worked_example_is_half_a_millimeter_in_a_meter() {
    // sin γ = (848.316² − 848.740²)/(4 · 600²) = −(0.424 · 1697.056)/1440000 = −4.99689e-4.
    let shop = Shop::new().file("m.toml", machine("wFXYZSt"));
    let run = square(&shop, &["--d1", "848.740", "--d2", "848.316", "--side", "600", "--read-to", "0.5"]).exits(0);
    assert!(run.stdout.contains("X+ to Y+ is 90° − 499.7 µrad ± "), "{}", run.stdout);
    assert!(run.stdout.contains("EC0Y = -499.7 µrad on wFXYZSt: the model tilts Y, not X"), "{}", run.stdout);
    // u(γ) = u·D/(√2·a·b), u = 0.5/√3 = 0.28868: 0.28868·848.528/(1.41421·360000) = 4.8113e-4; twice that is 962.3 µrad.
    assert!(run.stdout.contains("± 962.3 µrad (95 %)"), "{}", run.stdout);
    // Over a travel of 2000 mm the correction is 1 mm, more than the 0.2 mm of a correction without an option.
    let far = ["--d1", "848.740", "--d2", "848.316", "--side", "600", "-o", "far.toml"];
    square(&shop, &far).exits(0).says("--max-correction 2mm");
    let small = ["--square", "300", "--dial", "0.02", "-o", "small.toml"];
    assert!(!square(&shop, &small).exits(0).stderr.contains("--max-correction"));
    // The uncertainty is larger than the angle.
    assert!(run.stdout.contains("not larger than its uncertainty"), "{}", run.stdout);
}

#[test]
fn the_sign_is_that_of_the_forward_model_on_every_chain() {
    // Own kinematics of the part: a parallelogram with the angle 90° + γ between its sides, by the law of cosines.
    let gamma: f64 = 4e-4;
    let (a, b) = (600.0_f64, 400.0_f64);
    let d1 = (a * a + b * b + 2.0 * a * b * (std::f64::consts::FRAC_PI_2 + gamma).cos()).sqrt();
    let d2 = (a * a + b * b - 2.0 * a * b * (std::f64::consts::FRAC_PI_2 + gamma).cos()).sqrt();
    for (topology, term, sign) in [
        ("wFXYZSt", "EC0Y", 1.0),
        ("wXYFZSt", "EC0X", -1.0),
        ("wYXFZSt", "EC0Y", 1.0),
        ("wYFXZSt", "EC0X", -1.0),
        ("wXFYZSt", "EC0Y", 1.0),
    ] {
        let shop = Shop::new().file("m.toml", machine(topology));
        let (d1, d2) = (format!("{d1:.9}"), format!("{d2:.9}"));
        let run =
            square(&shop, &["--d1", &d1, "--d2", &d2, "--sides", "600,400", "--read-to", "0.001", "-o", "s.toml"]);
        let run = run.exits(0);
        assert!(run.stdout.contains(&format!("{term} = {:.1} µrad", sign * 400.0)), "{topology}: {}", run.stdout);
        let text = shop.text("s.toml");
        assert!(text.starts_with("# mine\n") && text.contains("# chain"), "the text is kept: {text}");
        let (loaded, findings) = load(&text);
        assert!(findings.is_empty(), "{findings:?}");
        let (machine, errors) = loaded.unwrap();
        let model = Model::new(&machine, &errors);
        // The corners of the rectangle as this machine cuts them.
        let corner = |x: f64, y: f64| place(&model, [x, y, 0.0]);
        let first = (corner(a, b) - corner(0.0, 0.0)).norm();
        let second = (corner(0.0, b) - corner(a, 0.0)).norm();
        assert!((first - d1.parse::<f64>().unwrap()).abs() < 1e-3, "{topology}: {first} {d1}");
        assert!((second - d2.parse::<f64>().unwrap()).abs() < 1e-3, "{topology}: {second} {d2}");
    }
}

#[test]
fn other_planes_have_other_terms() {
    // The column leans: moving Z+ by 300 mm, the dial gauge that points to X+ reads 0.03 mm more, so γ = −100 µrad.
    for (plane, topology, term) in [("zx", "wFXYZSt", "EB0Z = 100.0"), ("yz", "wFXYZSt", "EA0Z = -100.0")] {
        let shop = Shop::new().file("m.toml", machine(topology));
        let run = square(&shop, &["--square", "300", "--dial", "0.03", "--plane", plane, "-o", "s.toml"]).exits(0);
        assert!(run.stdout.contains(term), "{plane}: {}", run.stdout);
        let (machine, errors) = load(&shop.text("s.toml")).0.unwrap();
        let model = Model::new(&machine, &errors);
        // 0.03 mm in 300 mm towards the other axis: the forward model must give the reading again.
        let moved = place(&model, [0.0, 0.0, 300.0]) - place(&model, [0.0, 0.0, 0.0]);
        let other = if plane == "zx" { moved.x } else { moved.y };
        assert!((other - 0.03).abs() < 1e-6, "{plane}: {other}");
        // Own rotation of the direction of Z by the stated value.
        let value = if plane == "zx" { 1e-4 } else { -1e-4 };
        let axis = if plane == "zx" { Vector3::y_axis() } else { Vector3::x_axis() };
        let turned = Rotation3::from_axis_angle(&axis, value) * Vector3::new(0.0, 0.0, 300.0);
        assert!((turned - moved).norm() < 1e-6, "{plane}: {turned} {moved}");
        let axes = [Axis::X, Axis::Y, Axis::Z];
        assert!(axes.iter().all(|axis| machine.axis(*axis).is_some()));
        let run =
            square(&shop, &["--square", "300", "--dial", "0.03", "--plane", plane, "--plunger-negative"]).exits(0);
        assert!(run.stdout.contains(&term.replace("= ", "= -").replace("--", "")), "{}", run.stdout);
    }
}

#[test]
fn an_existing_value_is_replaced_or_added_to() {
    let text = machine("wFXYZSt") + "\n[location]\nEC0Y = 100.0   # old\n";
    let shop = Shop::new().file("m.toml", text);
    let words = ["--d1", "848.740", "--d2", "848.316", "--side", "600"];
    square(&shop, &[&words[..], &["-o", "a.toml"]].concat()).exits(0);
    assert!(shop.text("a.toml").contains("EC0Y = -499.7   # old"), "{}", shop.text("a.toml"));
    square(&shop, &[&words[..], &["-o", "b.toml", "--add"]].concat()).exits(0);
    assert!(shop.text("b.toml").contains("EC0Y = -399.7   # old"), "{}", shop.text("b.toml"));
    // The same angle by the name of the other axis would count twice.
    let text = machine("wYFXZSt") + "\n[location]\nEC0Y = 100.0\n";
    let shop = Shop::new().file("m.toml", text);
    square(&shop, &[&words[..], &["-o", "a.toml"]].concat()).exits(2).says("remove it");
}

/// Readings stay where they are.
#[test]
fn a_machine_file_replaces_only_a_machine_file() {
    let shop = Shop::new().file("m.toml", machine("wFXYZSt")).file("r.csv", "X,Y,Z,component,value_um\n0,0,0,EXX,0\n");
    let readings = ["--square", "300", "--dial", "0.03", "-o"];
    square(&shop, &[&readings[..], &["r.csv"]].concat()).exits(2).says("r.csv exists and is not a machine file");
    assert!(shop.text("r.csv").starts_with("X,Y,Z,component"));
    for _ in 0..2 {
        square(&shop, &[&readings[..], &["new.toml"]].concat()).exits(0);
    }
    shop.run(["calibrate", "r.csv", "--machine", "m.toml", "--model", "EXX1", "-o", "r.csv"])
        .exits(2)
        .says("would overwrite");
    assert!(shop.text("r.csv").starts_with("X,Y,Z,component"));
}

#[test]
fn readings_that_do_not_fit_are_refused() {
    let shop = Shop::new().file("m.toml", machine("wFXYZSt"));
    square(&shop, &["--d1", "848", "--d2", "700", "--side", "600"]).exits(2).says("do not fit");
    square(&shop, &["--square", "300", "--dial", "40"]).exits(2).says("a number is wrong");
    // 12 µm typed as mm: 40 mm/m.
    square(&shop, &["--square", "300", "--dial", "12"]).exits(2).says("12 µm is --dial 0.012");
    // 1.5 mm over 300 mm is the limit of 5 mm/m; over a travel of 2000 mm it would be 10 mm, which is never proposed.
    let large = square(&shop, &["--square", "300", "--dial", "1.5", "-o", "large.toml"]).exits(0);
    assert!(!large.stderr.contains("--max-correction"), "{}", large.stderr);
    let corner = square(&shop, &["--square", "300", "--dial", "-0.012"]).exits(0).stdout;
    assert!(
        corner.contains("let out by 0.012 mm")
            && corner.contains("makes no difference")
            && !corner.contains("change the sign"),
        "{corner}"
    );
    square(&shop, &["--d1", "848", "--d2", "848"]).exits(2);
    square(&shop, &[]).exits(2);
}

#[test]
fn the_test_square_is_a_program_of_the_machine() {
    for controller in ["rs274", "sinumerik", "fanuc"] {
        let text =
            machine("wFXYZSt").replace("rs274", controller) + "\n[zero_offset.G54]\nX_mm = 10\nY_mm = 20\nZ_mm = 30\n";
        let shop = Shop::new().file("m.toml", text);
        let words = ["--d1", "848.740", "--d2", "848.316", "--side", "600", "-o", "s.toml", "--check-cut", "square.nc"];
        square(&shop, &words).exits(0);
        let run = shop.run(["snc", "square.nc", "--machine", "m.toml", "--dialect", controller]).exits(0);
        for corner in ["X10 Y20 Z29.5", "X610 Y20 Z29.5", "X610 Y620 Z29.5", "X10 Y620 Z29.5"] {
            assert!(run.stdout.contains(corner), "{controller}: {corner}: {}", run.stdout);
        }
    }
}

#[test]
fn diagonals_far_from_the_sides_are_refused_and_uncertain_angles_are_named() {
    let shop = Shop::new().file("m.toml", machine("wFXYZSt"));
    // √2 · 300 mm = 424.264 mm. The mean of the squares of the diagonals is that of 429.551 mm, 5.287 mm more.
    let words = ["--d1", "434.183", "--d2", "424.868", "--side", "300", "--read-to", "0.05"];
    square(&shop, &words).exits(2).says("424.264 mm").says("5.287 mm too large");
    // √(299.70² + 300.20²) = 424.194 mm: one of four readings to 0.05 mm is wrong.
    let words =
        ["--d1", "424.00", "--d2", "424.10", "--sides", "299.70,300.20", "--nominal", "300,300", "--read-to", "0.05"];
    square(&shop, &words).exits(2).says("0.144 mm too small, and at most 0.125 mm");
    // With 0.5 mm of uncertainty, 424.264 · 1e-3 + 2.5 mm are possible.
    square(&shop, &["--d1", "426", "--d2", "425.8", "--side", "300"]).exits(0);
    let run = square(&shop, &["--d1", "424.30", "--d2", "424.29", "--side", "300", "--read-to", "0.05"]).exits(0);
    assert!(run.stdout.contains("the angle is not significant"), "{}", run.stdout);
}

/// 299.80 mm for 300 mm: X moves 667 µm/m too little; 300.10 mm: Y moves 333 µm/m too much. The bed of a knee mill moves against its letters, and so do its errors.
#[test]
fn measured_sides_give_the_scales() {
    // 299.80 and 300.10 mm have diagonals of √(299.80² + 300.10²) = 424.1931 mm.
    let words =
        ["--d1", "424.193", "--d2", "424.193", "--sides", "299.80,300.10", "--nominal", "300,300", "--read-to", "0.02"];
    for (chain, sign) in [("wFXYZSt", 1.0), ("wXYFZSt", -1.0)] {
        let shop = Shop::new().file("m.toml", machine(chain));
        let run = square(&shop, &[&words[..], &["-o", "s.toml", "--check-cut", "c.nc"]].concat()).exits(0);
        assert!(run.stdout.contains("X moves -667 ±") && run.stdout.contains("Y moves +333 ±"), "{}", run.stdout);
        let text = shop.text("s.toml");
        let number =
            |line: &str| -> f64 { line.rsplit([',', '=']).next().unwrap().trim_matches([' ', ']']).parse().unwrap() };
        let of = |name: &str| {
            let (_, rest) = text.split_once(&format!("component = \"{name}\"")).unwrap_or_else(|| panic!("{text}"));
            number(rest.lines().find(|line| line.starts_with("coefficients")).unwrap())
        };
        assert!((of("EXX") + sign * 6.6667e-4).abs() < 1e-7 && (of("EYY") - sign * 3.3333e-4).abs() < 1e-7, "{text}");
        // u = 0.02/√3/300.
        let sigma = number(text.lines().find(|line| line.starts_with("EXX1")).unwrap());
        assert!((sigma - 3.849e-5).abs() < 1e-7, "{text}");
        // The test square has the programmed sides, also where they are not stated.
        assert!(shop.text("c.nc").contains("300 X 300"), "{}", shop.text("c.nc"));
    }
    let shop = Shop::new().file("m.toml", machine("wFXYZSt"));
    let plain = ["--d1", "424.193", "--d2", "424.193", "--sides", "299.80,300.10", "--check-cut", "c.nc"];
    square(&shop, &plain).exits(0);
    assert!(shop.text("c.nc").contains("300 X 300"), "{}", shop.text("c.nc"));
    // One length is that of both sides of a square, measured and programmed.
    let one = ["--d1", "423.840", "--d2", "423.840", "--sides", "299.70", "--nominal", "300", "--read-to", "0.02"];
    let run = square(&shop, &one).exits(0);
    assert!(run.stdout.contains("X moves -1000 ±") && run.stdout.contains("Y moves -1000 ±"), "{}", run.stdout);
    square(&shop, &["--d1", "500", "--d2", "500", "--sides", "300,400,500"]).exits(2).says("one or two lengths");
    // Exchanged or mistyped sides are no scales.
    let wrong = ["--d1", "500", "--d2", "500", "--sides", "300,400", "--nominal", "400,300"];
    square(&shop, &wrong).exits(2).says("more than 2 %");
}

#[test]
fn the_written_file_has_the_uncertainty_and_no_comment_against_it() {
    let shop = Shop::new();
    shop.run(["machine", "new", "m.toml", "--like", "router", "--control", "grbl"]).exits(0);
    let text = shop.text("m.toml");
    let listed = |text: &str| text.lines().any(|line| line.starts_with("#   EC0X") || line.starts_with("#   EC0Y"));
    assert!(text.contains("# No error of this machine is measured yet.") && listed(&text), "{text}");
    square(&shop, &["--d1", "424.310", "--d2", "424.220", "--side", "300", "--read-to", "0.02", "-o", "s.toml"])
        .exits(0);
    let text = shop.text("s.toml");
    assert!(!text.contains("No error of this machine is measured yet") && !listed(&text), "{text}");
    assert!(text.contains("squareness of Z and X"), "{text}");
    // u = (0.02/√3) · 424.265/(√2 · 300²) = 0.011547 · 424.265/127279 = 3.849e-5, and 38.5 µrad in the file.
    let (_, after) = text.split_once("[uncertainty]").unwrap();
    assert!(after.contains("= 38.5"), "{text}");
    shop.run(["square", "--machine", "s.toml", "--square", "300", "--dial", "0.03"]).exits(0);
}
