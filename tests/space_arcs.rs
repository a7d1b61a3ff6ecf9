//! Arcs outside the working plane: a Sinumerik gets them back as circles through a point between their ends (CIP).
//!
//! The judge is by hand: the circle through three written points, the errors of the machine at each of its points, and the distance from the programmed circle.

use crate::support::Shop;

type Place = [f64; 3];

/// X, Y and Z on the tool side; the tool is 50 mm long, so that Z of the axis is 50 mm more than Z of the program.
const MACHINE: &str = "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n[axis.X]\ndirection = [1, 0, 0]\n\
    travel_mm = [-500, 500]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-500, 500]\n[axis.Z]\ndirection = [0, 0, 1]\n\
    travel_mm = [-500, 500]\n[control]\nincrement_mm = 0.001\n[[tool]]\nnumber = 1\nlength_mm = 50\nradius_mm = 5\n\
    [zero_offset.G54]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\nset = \"absolute\"\n";
const ERRORS: &str = "[[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 1e-4]\n\
    [[motion]]\ncomponent = \"EYY\"\nkind = \"polynomial\"\ncoefficients = [0, -5e-5]\n\
    [[motion]]\ncomponent = \"EXZ\"\nkind = \"polynomial\"\ncoefficients = [0, 5e-5, 2e-7]\n\
    [[motion]]\ncomponent = \"EZY\"\nkind = \"polynomial\"\ncoefficients = [0, 3e-5, 1e-7]\n";
/// Start, point between, and end on a circle of 40 mm about (1, 1, 1), 286° of it.
const START: Place = [21.716, 48.284, -10.0];
const BETWEEN: Place = [62.887, -12.433, 9.546];
const END: Place = [57.636, 43.682, -41.318];
/// Tolerance, 5 % of it, and a quarter of the largest rounding error of three axes, µm.
const ALLOWED_UM: f64 = 1.0 + 0.05 + 0.25 * 0.866;

fn actual([x, y, z]: Place, has_errors: bool) -> Place {
    let axis_z = z + 50.0;
    if !has_errors {
        return [x, y, z];
    }
    [x + 1e-4 * x + 5e-5 * axis_z + 2e-7 * axis_z * axis_z, y - 5e-5 * y, z + 3e-5 * y + 1e-7 * y * y]
}

fn less(a: Place, b: Place) -> Place {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn dot(a: Place, b: Place) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn cross(a: Place, b: Place) -> Place {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: Place) -> Place {
    a.map(|part| part / dot(a, a).sqrt())
}

/// A circle: center, two directions at right angles, radius, and the angle from its first point to its last.
struct Circle {
    center: Place,
    first: Place,
    second: Place,
    radius: f64,
    sweep: f64,
}

impl Circle {
    /// The center is where the plane of the points meets the two planes that are as far from the first as from each of the others (Cramer's rule).
    fn of(from: Place, between: Place, to: Place) -> Circle {
        let normal = unit(cross(less(between, from), less(to, from)));
        let rows = [normal, less(between, from), less(to, from)];
        let half = |one: Place| 0.5 * (dot(one, one) - dot(from, from));
        let right = [dot(normal, from), half(between), half(to)];
        let determinant = dot(rows[0], cross(rows[1], rows[2]));
        let parts = [cross(rows[1], rows[2]), cross(rows[2], rows[0]), cross(rows[0], rows[1])];
        let center = [0, 1, 2].map(|k| (0..3).map(|row| right[row] * parts[row][k]).sum::<f64>() / determinant);
        let out = less(from, center);
        let (first, radius) = (unit(out), dot(out, out).sqrt());
        let second = cross(normal, first);
        let last = less(to, center);
        let sweep = dot(last, second).atan2(dot(last, first)).rem_euclid(std::f64::consts::TAU);
        Circle { center, first, second, radius, sweep }
    }

    fn at(&self, share: f64) -> Place {
        let (sine, cosine) = (self.sweep * share).sin_cos();
        [0, 1, 2].map(|k| self.center[k] + self.radius * (self.first[k] * cosine + self.second[k] * sine))
    }

    fn distance(&self, point: Place) -> f64 {
        let out = less(point, self.center);
        let height = dot(out, cross(self.first, self.second));
        let in_plane = (dot(out, out) - height * height).sqrt();
        (in_plane - self.radius).hypot(height)
    }
}

fn number(line: &str, word: &str) -> Option<f64> {
    line.split_whitespace().find_map(|own| own.strip_prefix(word)?.parse().ok())
}

/// The circles of a corrected program.
fn circles(text: &str) -> Vec<Circle> {
    let mut at = [0.0; 3];
    let mut found = Vec::new();
    for line in text.lines().map(|line| line.split(';').next().unwrap()) {
        let mut to = at;
        for (place, word) in to.iter_mut().zip(["X", "Y", "Z"]) {
            *place = number(line, word).unwrap_or(*place);
        }
        if let [Some(x), Some(y), Some(z)] = ["I1=", "J1=", "K1="].map(|word| number(line, word)) {
            found.push(Circle::of(at, [x, y, z], to));
        }
        at = to;
    }
    found
}

fn program(frame: &str) -> String {
    let words = |place: Place, letters: [&str; 3]| {
        let words: Vec<String> =
            letters.iter().zip(place).map(|(letter, place)| format!("{letter}{place:.3}")).collect();
        words.join(" ")
    };
    let [start, end] = [START, END].map(|place| words(place, ["X", "Y", "Z"]));
    let between = words(BETWEEN, ["I1=", "J1=", "K1="]);
    format!("G17 G90 G71 G94 G54\nT1\nM6\nD1\n{frame}G0 {start}\nCIP {end} {between} F500\nG1 X0\nG0 Z200\nM30\n")
}

fn corrected(errors: &str, frame: &str) -> String {
    let shop = Shop::new().file("m.toml", format!("{MACHINE}{errors}")).file("p.mpf", program(frame));
    shop.run(["p.mpf", "-o", "out.mpf", "--machine", "m.toml"]).exits(0);
    shop.run(["verify", "p.mpf", "out.mpf", "--machine", "m.toml"]).exits(0);
    shop.text("out.mpf")
}

#[test]
fn an_arc_in_space_stays_a_few_arcs() {
    let nominal = Circle::of(START, BETWEEN, END);
    // Without errors it is the arc of the program; with them it becomes an ellipse, which four arcs follow. As chords it had 370 blocks.
    for (errors, most, allowed_um) in [("", 1, 1e-6), (ERRORS, 4, ALLOWED_UM)] {
        let text = corrected(errors, "");
        let found = circles(&text);
        assert!((1..=most).contains(&found.len()), "{text}");
        assert!(!text.contains(" I-") && text.matches("\nG1 ").count() == 1, "{text}");
        let swept: f64 = found.iter().map(|circle| circle.sweep).sum();
        assert!((swept - nominal.sweep).abs() < 1e-3, "{swept}, not {}", nominal.sweep);
        for circle in &found {
            for k in 0..=200 {
                let off_um = 1e3 * nominal.distance(actual(circle.at(f64::from(k) / 200.0), !errors.is_empty()));
                assert!(off_um < allowed_um, "{off_um}\n{text}");
            }
        }
    }
}

#[test]
fn in_a_turned_frame_its_words_are_those_of_the_frame() {
    // Without errors the words are those of the program.
    for frame in ["ROT RPL=30\n", "MIRROR X0\n"] {
        let text = corrected("", frame);
        assert!(text.contains("CIP X57.636 Y43.682 Z-41.318 I1=62.887 J1=-12.433 K1=9.546"), "{text}");
        // With errors, verify has executed and accepted the arcs.
        let text = corrected(ERRORS, frame);
        assert!((1..=8).contains(&circles(&text).len()), "{text}");
    }
    // Unequal scales make an ellipse of the circle: chords.
    let text = corrected("", "SCALE X1.5\n");
    assert!(circles(&text).is_empty() && text.matches('\n').count() > 50, "{text}");
}
