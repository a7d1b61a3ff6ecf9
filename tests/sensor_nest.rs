//! Sensors with directions of their own, stated by a matrix or fitted to a star of known moves (Andolfatto et al. 2011, 4.2). Readings are calculated here.

use crate::plant_at_speed::{Hidden, MACHINE, description, table, trace};
use crate::support::Shop;

/// A table C about X300 Y200.
const TABLE: &str = "[machine]\nname = \"table\"\ntopology = \"wCFXYZSt\"\ncontroller = \"sinumerik\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 700]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-100, 500]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-100, 400]\n[axis.C]\ndirection = [0, 0, 1]\npoint_mm = [300, 200, 0]\nmodulo = true\n\
    [spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n";

/// 100 µm per volt: two sensors are turned by the angle whose cosine is 0.6 in the plane of X and Y, the third looks along Z.
const DIRECTIONS: [[f64; 3]; 3] = [[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]];

/// Volts at a displacement in µm, with zeros of 0.1, −0.2 and 0.05 V; the first sensor is bent by a share of the square.
fn volts(displacement: [f64; 3], bend: f64) -> [f64; 3] {
    let along = DIRECTIONS.map(|n| (0..3).map(|k| n[k] * displacement[k]).sum::<f64>() / 100.0);
    [along[0] + bend * along[0] * along[0] + 0.1, along[1] - 0.2, along[2] + 0.05]
}

/// The star: the middle, and along each sensor ±1/3, ±2/3 and ±1 of 100 µm.
fn star(bend: f64) -> String {
    let mut rows = vec![[0.0; 3]];
    for direction in DIRECTIONS {
        for share in [-3.0, -2.0, -1.0, 1.0, 2.0, 3.0] {
            rows.push(direction.map(|n| n * share * 100.0 / 3.0));
        }
    }
    let row = |d: [f64; 3]| {
        let v = volts(d, bend);
        format!("  [{:.9}, {:.9}, {:.9}, {:.9}, {:.9}, {:.9}],\n", d[0], d[1], d[2], v[0], v[1], v[2])
    };
    format!("star = [\n{}]\n", rows.into_iter().map(row).collect::<String>())
}

/// An R-test on a table whose axis is displaced by e = (20, −15) µm: the tool is displaced by R e − e.
fn readings(bend: f64) -> String {
    let mut out = "X,Y,Z,C,tool_z_mm,s1_V,s2_V,s3_V\n".to_owned();
    for step in 0..36 {
        let (sin, cos) = (f64::from(step) * 10.0).to_radians().sin_cos();
        let d = [20.0 * cos + 15.0 * sin - 20.0, 20.0 * sin - 15.0 * cos + 15.0, 0.0];
        let v = volts(d, bend);
        let place = [300.0 + 120.0 * cos, 200.0 + 120.0 * sin];
        out += &format!("{:.4},{:.4},160,{},-100,{:.6},{:.6},{:.6}\n", place[0], place[1], step * 10, v[0], v[1], v[2]);
    }
    out
}

fn shop(bend: f64, sensors: &str) -> Shop {
    let text = format!(
        "[measurement]\nkind = \"displacement\"\nsigma_um = 0.1\nfree = [\"offset\"]\n[sensors]\n\
         columns = [\"s1_V\", \"s2_V\", \"s3_V\"]\n{sensors}"
    );
    Shop::new().file("m.toml", TABLE).file("r.csv", readings(bend)).file("r.toml", text)
}

const FIT: [&str; 9] =
    ["calibrate", "r.csv", "--machine", "m.toml", "--model", "EX0C,EY0C", "-o", "fitted.toml", "--json"];

#[track_caller]
fn fits(shop: &Shop, within: f64) {
    let json = shop.run(FIT).exits(0).json();
    for (row, expected) in json["parameters"].as_array().unwrap().iter().zip([20.0, -15.0]) {
        assert!((row["value"].as_f64().unwrap() - expected).abs() < within, "{row}");
    }
}

#[test]
fn directions_of_sensors_are_fitted_to_a_star_or_stated() {
    let fitted = shop(0.0, &star(0.0));
    fits(&fitted, 0.02);
    assert!(!fitted.run(FIT).stdout.contains("W0614"));
    // The columns of the matrix are the directions by 100 µm per volt, because the directions are square.
    fits(&shop(0.0, "matrix_um = [[60, -80, 0], [80, 60, 0], [0, 0, 100]]\nzero = [0.1, -0.2, 0.05]\n"), 0.02);
}

/// A bend of 0.04: on ±1 V the square is 0.04 V at both ends. The straight line through the 19 rows is at the mean of the squares,
/// 0.04 · 2 (1/9 + 4/9 + 1)/19 = 0.00655 V, so the end is 0.03345 V away, of a range of 2 V: 1.7 %.
#[test]
fn a_bent_sensor_is_named_and_a_cubic_response_follows_it() {
    let straight = shop(0.04, &star(0.04)).run(FIT);
    assert!(
        straight.stdout.contains("W0614") && straight.stdout.contains("s1_V departs from its fitted response by 1.7 %"),
        "{}",
        straight.stdout
    );
    let cubic = shop(0.04, &format!("degree = 3\n{}", star(0.04)));
    assert!(!cubic.run(FIT).stdout.contains("W0614"));
    fits(&cubic, 0.05);
}

#[test]
fn what_a_star_does_not_show_is_refused() {
    // A reading of 100 µm along Z by three quarters more than the star has.
    let far = readings(0.0).replace("160,0,-100,0.100000,-0.200000,0.050000", "160,0,-100,0.100000,-0.200000,1.800000");
    let run = shop(0.0, &star(0.0)).file("r.csv", far).run(FIT);
    assert!(run.code == 4 && run.stdout.contains("E0608") && run.stdout.contains("s3_V reads 1.8"), "{}", run.stdout);
    for (sensors, says) in [
        ("matrix_um = [[60, -80, 0], [80, 60, 0], [60, -80, 0]]\n", "does not give three directions"),
        ("", "needs either matrix_um or star"),
        ("star = [[0, 0, 0, 0, 0, 0], [1, 0, 0, 1, 0, 0]]\n", "needs more than 4 rows"),
        (
            "star = [[0,0,0,0,0,0],[100,0,0,1,0,0],[-100,0,0,-1,0,0],[0,100,0,0,1,0],[0,-100,0,0,-1,0],[50,50,0,0.5,0.5,0]]\n",
            "the star does not determine the directions",
        ),
    ] {
        let run = shop(0.0, sensors).run(FIT);
        assert!(run.code == 4 && run.stdout.contains(says), "{says}: {}", run.stdout);
    }
}

/// The same trace, once along F and once in volts of the sensors, has the same parts.
#[test]
fn a_trace_of_sensors_is_divided_like_one_along_f() {
    let (trace, _) = trace(&Hidden::default(), &[0, 5], 7);
    let plain = table(&trace);
    let mut lines = plain.lines();
    let head = lines.next().unwrap().replace("dx_um,dy_um,dz_um", "s1_V,s2_V,s3_V");
    let place = head.split(',').position(|name| name == "s1_V").unwrap();
    let mut sensed = head + "\n";
    for line in lines {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        if !cells[place].is_empty() {
            let d = [0, 1, 2].map(|k| cells[place + k].parse::<f64>().unwrap());
            // Without the zeros: they would be an offset.
            for (k, n) in DIRECTIONS.iter().enumerate() {
                cells[place + k] = format!("{:.6}", (0..3).map(|j| n[j] * d[j]).sum::<f64>() / 100.0);
            }
        }
        sensed += &(cells.join(",") + "\n");
    }
    let sensors =
        "[sensors]\ncolumns = [\"s1_V\", \"s2_V\", \"s3_V\"]\nmatrix_um = [[60, -80, 0], [80, 60, 0], [0, 0, 100]]\n";
    let shop = Shop::new()
        .file("mill.toml", MACHINE)
        .file("plain.csv", plain)
        .file("plain.toml", description())
        .file("sensed.csv", sensed)
        .file("sensed.toml", description() + sensors);
    let found = ["plain.csv", "sensed.csv"]
        .map(|name| shop.run(["decompose", name, "--machine", "mill.toml", "--json"]).exits(0).json());
    for run in 0..2 {
        for source in ["link", "motion", "dynamic"] {
            for k in 0..3 {
                let [one, other] =
                    found.each_ref().map(|found| found["runs"][run]["rms_um"][source][k].as_f64().unwrap());
                assert!((one - other).abs() < 0.01, "{run} {source} {k}: {one} {other}");
            }
        }
    }
}
