//! `ncfix import`: lists of centers of balls, one row for each ball and pose.

use std::fmt::Write as _;

use crate::import::{Noise, calibrated, import, shop};
use crate::support::Shop;

/// A machine with a rotary table C on the workpiece side.
fn rotary() -> Shop {
    let shop = shop();
    let machine = shop
        .text("tool.toml")
        .replace("wFXYZSt", "wCFXYZSt")
        .replace("[spindle]", "[axis.C]\ndirection = [0, 0, 1]\npoint_mm = [300, 200, 0]\nmodulo = true\n[spindle]");
    shop.file("rotary.toml", machine)
}

/// Centers of a ball 100 mm beside the axis C, which is 20 µm too far in +X and 15 µm in −Y.
fn rows(noise: &mut Noise, line: impl Fn(usize, f64, [f64; 3]) -> String) -> String {
    let mut text = String::new();
    for k in 0..8 {
        let c = 45.0 * f64::from(k);
        let (sin, cos) = c.to_radians().sin_cos();
        let center = [300.020 + 100.0 * cos, 199.985 + 100.0 * sin, 50.0].map(|mm| mm + noise.next(0.0003));
        let _ = writeln!(text, "{}", line(k as usize + 1, c, center));
    }
    text
}

#[track_caller]
fn demand_place(shop: &Shop) {
    let found = calibrated(shop, "rotary.toml", "EX0C,EY0C");
    for (name, value) in [("EX0C", 20.0), ("EY0C", -15.0)] {
        let (_, estimate, sigma) = found.iter().find(|(own, ..)| own == name).unwrap();
        assert!((estimate - value).abs() <= 3.0 * sigma + 0.2, "{name}: {found:?}");
    }
}

#[test]
fn a_list_of_centers_is_a_probing() {
    let mut noise = Noise(37);
    let numbered = rows(&mut noise, |k, c, [x, y, z]| format!("{k};{c};{x:.4};{y:.4};{z:.4};25.000"));
    let named = rows(&mut noise, |_, c, [x, y, z]| format!("b1;{c};{x:.4};{y:.4};{z:.4}"));
    let shop = rotary()
        .file("numbered.csv", format!("No;C [deg];Xm [mm];Ym [mm];Zm [mm];dia [mm]\n{numbered}"))
        .file("named.csv", format!("ball;C;X;Y;Z\n{named}"));
    let run = import(&shop, "numbered.csv", "rotary.toml", &["--tool", "0"]).exits(0);
    for part in ["format: ball-centres", "no column names the ball", "columns that are not read: No, dia [mm]"] {
        assert!(run.stderr.contains(part), "{part}: {}", run.stderr);
    }
    demand_place(&shop);
    // The unit is asked, with the largest position: 400.02 mm at 0°.
    let run = import(&shop, "named.csv", "rotary.toml", &["--tool", "0"]).exits(4).says("E0616");
    assert!(run.stderr.contains("the unit of its positions (largest 400.0"), "{}", run.stderr);
    import(&shop, "named.csv", "rotary.toml", &["--tool", "0", "--unit", "mm"]).exits(0).says("balls: 1, centers: 8");
    demand_place(&shop);
}

#[test]
fn what_a_list_of_centers_leaves_open_is_asked() {
    let mut noise = Noise(41);
    let points = rows(&mut noise, |k, c, [x, y, z]| format!("P{k};{c};{x:.4};{y:.4};{z:.4}"));
    let head = "point;C [deg];X [mm];Y [mm];Z [mm]\n";
    let shop = rotary()
        .file("points.csv", format!("{head}{points}"))
        .file("two.csv", "C [deg];X [mm];Y [mm];Z [mm]\n0;400;200;50\n90;300;300;50\n0;350;200;50\n");
    import(&shop, "points.csv", "rotary.toml", &["--tool", "0"]).exits(4).says("E0616").says("give --columns");
    import(&shop, "points.csv", "rotary.toml", &["--tool", "0", "--columns", "-,C,X,Y,Z"]).exits(0);
    demand_place(&shop);
    // Two balls without names: 50 mm apart at C 0.
    import(&shop, "two.csv", "rotary.toml", &["--tool", "0"])
        .exits(4)
        .says("E0618")
        .says("is 50 mm from its place in line 2");
    // Points without rotary axes are only centers if the option says so.
    let plain = "name;X [mm];Y [mm];Z [mm]\nb1;100;100;50\nb2;200;100;50\nb1;100.001;100;50\n";
    let shop = shop.file("plain.csv", plain);
    import(&shop, "plain.csv", "tool.toml", &["--tool", "0"]).exits(4).says("E0617");
    import(&shop, "plain.csv", "tool.toml", &["--tool", "0", "--as", "ball-centres"]).exits(0);
}

/// A column that gives each row its unit is not passed over: the rows may be in mm and in inches.
#[test]
fn a_unit_in_each_row_is_no_column_to_pass_over() {
    let mut noise = Noise(43);
    let centers = rows(&mut noise, |k, c, [x, y, z]| {
        format!("b1;{c};{x:.4};{y:.4};{z:.4};{}", if k % 2 == 0 { "mm" } else { "inch" })
    });
    // Five touches of each of two balls, 10 mm from their centers.
    let of_ball = |name: &str, x: f64| {
        let sides = [(10, 0, 0), (-10, 0, 0), (0, 10, 0), (0, -10, 0), (0, 0, 10)];
        sides.map(|(dx, dy, dz)| format!("{name};{};{};{};mm\n", x + f64::from(dx), 100 + dy, 50 + dz)).concat()
    };
    let touches = format!("ball;X;Y;Z;unit\n{}{}", of_ball("b1", 100.0), of_ball("b2", 200.0));
    let shop = rotary()
        .file("centers.csv", format!("ball;C [deg];X;Y;Z;unit\n{centers}"))
        .file("touches.csv", touches)
        .file("displaced.csv", "X,Y,Z,dx,unit\n0,0,0,0.001,mm\n100,0,0,0.002,inch\n200,0,0,0.003,mm\n");
    for name in ["centers.csv", "touches.csv", "displaced.csv"] {
        import(&shop, name, "rotary.toml", &["--tool", "0", "--unit", "mm"]).exits(4).says("'unit' is not read");
    }
}
