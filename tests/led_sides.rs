//! Axes at rest that follow the corrections of the others, on a control with steps of a micrometer.
//!
//! The judge is by hand: bodies that stay within their lost motion, moved by the commands of the flat stream, and the errors of the plate machine.

use crate::cycles_stay::{PlateErrors, UPRIGHT, word};
use crate::support::Shop;

/// Half the lost motion of X and of Y, mm.
const HALF_MM: f64 = 2.5e-3;
/// Tolerance, 5 % of it, and a quarter of the largest rounding error of three axes, mm.
const ALLOWED_MM: f64 = 1.0e-3 + 0.05e-3 + 0.25 * 0.866e-3;

/// The plate machine with lost motion of X and Y and whole micrometers.
fn machine(errors: PlateErrors, control: &str) -> String {
    let mut text = errors.machine(control).replace("0.0001", "0.001").replace("IS-C", "IS-B");
    for axis in ['X', 'Y'] {
        text += &format!(
            "\n[[motion]]\ncomponent = \"E{axis}{axis}\"\nkind = \"backlash\"\nvalue_um = {:.1}\n",
            -2e3 * HALF_MM
        );
    }
    text
}

/// X, Y and Z of the tool after each feed move of a flat stream, in the coordinates of the program.
fn cut_to(stream: &str, errors: PlateErrors) -> Vec<[f64; 3]> {
    let mut bodies: Option<[f64; 2]> = None;
    let mut found = Vec::new();
    for line in stream.lines().filter(|line| line.starts_with("G0 ") || line.starts_with("G1 ")) {
        let [Some(x), Some(y), Some(z)] = ['X', 'Y', 'Z'].map(|letter| word(line, letter)) else { continue };
        let command = [x, y];
        let before = bodies.unwrap_or(command);
        let led = [0, 1].map(|axis| before[axis].clamp(command[axis] - HALF_MM, command[axis] + HALF_MM));
        bodies = Some(led);
        if line.starts_with("G1 ") {
            found.push(errors.real([led[0] - 40.0, led[1] - 30.0, z - 100.0]));
        }
    }
    found
}

/// From X20 to X150, the straightness of X moves the tool by 4e-8 (190² - 60²) = 1.3 µm in Y. Y has to go back by as much, within its lost motion of 5 µm:
/// on the side where the plunge ends, its body would stay.
#[test]
fn an_axis_at_rest_follows_its_correction_through_its_lost_motion() {
    for y in [20.0, 20.3] {
        let iso =
            format!("T2 M6\nS2000 M3\nG0 X20. Y{y:.3}\nG43 H2 Z20.\nG1 Z-6. F200\nG1 X150. F400\nG1 Y90.\nG0 Z50.\n");
        for (control, name, program) in [
            (
                "sinumerik",
                "side.mpf",
                format!(
                    "G17 G90 G71 G94 G54\nT2 M6\nD1 S2000 M3\nG0 X20 Y{y:.3} Z20\nG1 Z-6 F200\nG1 X150 F400\nG1 Y90\nG0 Z50\nM30\n"
                ),
            ),
            ("rs274", "side.ngc", format!("G21 G17 G90 G40 G49 G80 G94 G54\n{iso}M2\n")),
            (
                "fanuc",
                "side.nc",
                format!(
                    "%\nO1\nG21 G17 G90 G40 G49 G80 G94 G54\n{}M30\n%\n",
                    iso.replace("F200", "F200.").replace("F400", "F400.")
                ),
            ),
            (
                "grundig",
                "side.pm",
                format!(
                    "%PM1\nN1 G17 G71 G90\nN2 G54\nN3 T2 M6\nN4 G0 X20 Y{y:.3} Z20 S1100 M3\nN5 G1 Z-6 F200\nN6 G1 X150 F400\nN7 G1 Y90\nN8 G0 Z50\nN9 M30\n"
                ),
            ),
        ] {
            let out = format!("out_{name}");
            let shop = Shop::new().file(name, program).file("m.toml", machine(UPRIGHT, control));
            shop.run(["fix", name, "-o", &out, "--machine", "m.toml"]).exits(0);
            shop.run(["verify", name, &out, "--machine", "m.toml"]).exits(0);
            let stream = shop.run(["snc", &out, "--machine", "m.toml"]).exits(0).stdout;
            let ends = cut_to(&stream, UPRIGHT);
            for wanted in [[20.0, y, -6.0], [150.0, y, -6.0], [150.0, 90.0, -6.0]] {
                let off = |end: &[f64; 3]| (0..3).map(|axis| (end[axis] - wanted[axis]).powi(2)).sum::<f64>().sqrt();
                let nearest = ends.iter().map(off).fold(f64::INFINITY, f64::min);
                assert!(nearest <= ALLOWED_MM, "{control} {y} {wanted:?} {nearest}\n{}", shop.text(&out));
            }
        }
    }
}

/// A reversal by exactly the lost motion: the tool goes there and back by 5 µm, and not by 0 or 10.
#[test]
fn a_step_of_exactly_the_lost_motion_is_made() {
    for step in ["59.995", "59.9949", "59.9951"] {
        let program = format!(
            "G17 G90 G71 G94 G54\nT2 M6\nD1 S2000 M3\nG0 X20 Y20 Z20\nG1 Z-6 F200\nG1 X60 F400\nG1 X{step}\nG1 Y40\nG1 X60\nG1 X{step}\nG1 X60\n\
             G1 Y60\nG0 Z50\nM30\n"
        );
        let shop = Shop::new().file("step.mpf", program).file("m.toml", machine(UPRIGHT, "sinumerik"));
        shop.run(["fix", "step.mpf", "-o", "out.mpf", "--machine", "m.toml"]).exits(0);
        shop.run(["verify", "step.mpf", "out.mpf", "--machine", "m.toml"]).exits(0);
        let stream = shop.run(["snc", "out.mpf", "--machine", "m.toml"]).exits(0).stdout;
        let ends = cut_to(&stream, UPRIGHT);
        let x_mm: f64 = step.parse().unwrap();
        for wanted in [[60.0, 20.0], [x_mm, 20.0], [x_mm, 40.0], [60.0, 40.0], [60.0, 60.0]] {
            let off = |end: &[f64; 3]| (end[0] - wanted[0]).hypot(end[1] - wanted[1]).hypot(end[2] + 6.0);
            let nearest = ends.iter().map(off).fold(f64::INFINITY, f64::min);
            assert!(nearest <= ALLOWED_MM, "{step} {wanted:?} {nearest}\n{}", shop.text("out.mpf"));
        }
    }
}
