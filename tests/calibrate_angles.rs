//! The model `auto` and angles of linear axes: readings with tools of two lengths show them.

use std::fmt::Write as _;

use serde_json::Value;

use crate::import::Noise;
use crate::support::Shop;

/// X carries Y, Y carries Z, Z carries the tool.
const MILL: &str = "[machine]\nname = \"bench\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 600]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 400]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-300, 0]\n";

/// An angle that grows with the position of its axis, µrad per m; displacements of the tip by it, µm, at a position and tool length in m. An angle turns what its
/// axis carries: (roll, pitch, yaw) × the vector from the axis to the tip.
struct Angle {
    name: &'static str,
    moved: fn([f64; 3], f64) -> [f64; 3],
}

/// The angles with an effect that is no straightness: those of X act on y and z − l, those of Y on z − l, those of Z on the tool.
const ANGLES: [Angle; 7] = [
    Angle { name: "EAX1", moved: |[x, y, z], l| [0.0, -x * (z - l), x * y] },
    Angle { name: "EBX1", moved: |[x, _, z], l| [x * (z - l), 0.0, 0.0] },
    Angle { name: "ECX1", moved: |[x, y, _], _| [-x * y, 0.0, 0.0] },
    Angle { name: "EAY1", moved: |[_, y, z], l| [0.0, -y * (z - l), 0.0] },
    Angle { name: "EBY1", moved: |[_, y, z], l| [y * (z - l), 0.0, 0.0] },
    Angle { name: "EAZ1", moved: |[_, _, z], l| [0.0, z * l, 0.0] },
    Angle { name: "EBZ1", moved: |[_, _, z], l| [-z * l, 0.0, 0.0] },
];

/// A machine: scales, squareness and bows that differ from number to number, and an angle.
fn readings(number: u64, angle: Option<(&Angle, f64)>) -> String {
    let mut noise = Noise(100 + number);
    let mut amount = |size: f64| size * noise.next(1.0).clamp(-2.0, 2.0);
    let [scale_x, scale_y, scale_z] = [amount(15.0), amount(15.0), amount(15.0)];
    let [square_xy, bow_yx, bow_xy, curve_x] = [amount(25.0), amount(30.0), amount(30.0), amount(20.0)];
    let mut rows = "setup,X,Y,Z,tool_z_mm,dx_um,dy_um,dz_um\n".to_owned();
    for (setup, length_mm) in [("short", 80.0), ("long", 280.0)] {
        for x in (0..=600).step_by(120) {
            for y in (0..=400).step_by(100) {
                for z in [-300, -150, 0] {
                    let at @ [xm, ym, zm] = [x, y, z].map(|mm| f64::from(mm) / 1000.0);
                    let turned = angle
                        .map_or([0.0; 3], |(angle, size)| (angle.moved)(at, length_mm / 1000.0).map(|um| um * size));
                    let errors = [
                        scale_x * xm + curve_x * xm * xm - square_xy * ym + bow_xy * ym * ym,
                        scale_y * ym + bow_yx * xm * xm,
                        scale_z * zm,
                    ];
                    let read = |k: usize, noise: &mut Noise| errors[k] + turned[k] + noise.next(0.4);
                    let [dx, dy, dz] = [read(0, &mut noise), read(1, &mut noise), read(2, &mut noise)];
                    let _ = writeln!(rows, "{setup},{x},{y},{z},-{length_mm},{dx:.3},{dy:.3},{dz:.3}");
                }
            }
        }
    }
    rows
}

/// The fitted parameters of the model `auto`.
fn fitted(rows: String) -> Vec<Value> {
    let description =
        "[measurement]\nkind = \"displacement\"\nfree = [\"offset\"]\norder = \"unknown\"\nsigma_um = 0.4\n";
    let shop = Shop::new().file("mill.toml", MILL).file("grid.csv", rows).file("grid.toml", description);
    let run = shop.run("calibrate grid.csv --machine mill.toml -o out.toml --json".split_whitespace()).exits(0);
    run.json()["parameters"].as_array().unwrap().clone()
}

/// True for a term of an angle of a linear axis.
fn is_angle(name: &str) -> bool {
    let letters: Vec<char> = name.chars().collect();
    "ABC".contains(letters[1]) && "XYZ".contains(letters[2])
}

#[test]
fn an_angle_that_two_tool_lengths_show_is_fitted() {
    let mut within = 0;
    for number in 0..10 {
        let angle = &ANGLES[usize::try_from(number).unwrap() % ANGLES.len()];
        let size = if number % 2 == 0 { 40.0 } else { -60.0 };
        let found = fitted(readings(number, Some((angle, size))));
        let own = found.iter().find(|one| one["name"] == angle.name);
        let own = own.unwrap_or_else(|| panic!("{number}: {} is not among {found:?}", angle.name));
        let [value, sigma] = ["value", "sigma"].map(|key| own[key].as_f64().unwrap());
        assert!((value - size).abs() < 4.0 * sigma && sigma < 3.0, "{number}: {own}");
        within += usize::from((value - size).abs() < 2.0 * sigma);
        let others = found.iter().filter(|one| is_angle(one["name"].as_str().unwrap())).count();
        assert_eq!(others, 1, "{number}: {found:?}");
    }
    // 95 % are expected within two standard uncertainties.
    assert!(within >= 8, "{within} of 10");
}

#[test]
fn no_angle_is_invented() {
    for number in 20..40 {
        let found = fitted(readings(number, None));
        let angles: Vec<&Value> = found.iter().filter(|one| is_angle(one["name"].as_str().unwrap())).collect();
        assert!(angles.is_empty(), "{number}: {angles:?}");
    }
}
