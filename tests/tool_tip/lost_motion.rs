//! A circle of the tip while the table turns: linear axes reverse where the sum of both motions does, not where the circle or its chord does.

use crate::support::Shop;

/// A trunnion A/C that carries the workpiece, with 3 µm of lost motion in Z and no other error.
const TRUNNION: &str = "[machine]\nname = \"trunnion\"\ntopology = \"wCAYFXZSt\"\ncontroller = \"fanuc\"\n\
    [axis.C]\ndirection = [0, 0, -1]\npoint_mm = [300, -198, -440]\ntravel_deg = [-720, 720]\n\
    [axis.A]\ndirection = [-1, 0, 0]\npoint_mm = [300, -210, -480]\ntravel_deg = [-120, 120]\n\
    [axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [-700, 300]\n[axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-600, 1200]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-800, 300]\n\
    [control]\nincrement_system = \"IS-C\"\nincrement_mm = 0.0001\nincrement_deg = 0.0001\n\
    [zero_offset.G54]\nX_mm = 300\nY_mm = -198\nZ_mm = -440\nset = \"absolute\"\n\
    [[tool]]\nnumber = 1\nlength_mm = 120.0\n[[motion]]\ncomponent = \"EZZ\"\nkind = \"backlash\"\nvalue_um = -3\n";

/// The height of Z above the table: the point turns by −C about the line of C and by −A about that of A.
fn height_mm([x, y, z]: [f64; 3], a_deg: f64, c_deg: f64) -> f64 {
    let (sin, cos) = (-c_deg).to_radians().sin_cos();
    let turned = sin * x + cos * y;
    let (y, z) = (turned + 12.0, z + 40.0);
    let (sin, cos) = (-a_deg).to_radians().sin_cos();
    sin * y + cos * z
}

#[test]
fn z_steps_where_the_axis_reverses_on_a_circle_of_the_tip() {
    // A full circle about (48.9682, −112.9452) with a radius of 12 mm, while A goes from 9.486° to −1.92° and C from 105.473° to 132.258°.
    let at = |share: f64| {
        let angle = (1.253_f64).atan2(-11.935) - std::f64::consts::TAU * share;
        let radius = 11.935_f64.hypot(1.253);
        let tip = [48.9682 + radius * angle.cos(), -112.9452 + radius * angle.sin(), 24.788];
        height_mm(tip, 9.486 - 11.406 * share, 105.473 + 26.785 * share)
    };
    let heights: Vec<f64> = (0..=2000).map(|k| at(f64::from(k) / 2000.0)).collect();
    let rises: Vec<bool> = heights.windows(2).map(|pair| pair[1] > pair[0]).collect();
    // Down, up, down, up: three reversals after the plunge.
    assert_eq!((rises[0], rises.windows(2).filter(|pair| pair[0] != pair[1]).count()), (false, 3));
    let program = "%\nO1000\nN10 G21 G90 G17 G40 G80 G49 G94\nN20 T1 M6\nN30 G54\nN40 G0 A0. C0.\nN50 G43.4 H1\n\
                   N60 G0 X37.0332 Y-111.6922 Z70. A9.486 C105.473\nN70 G1 Z24.788 F5000.\n\
                   N130 G2 X37.0332 Y-111.6922 A-1.92 C132.258 I11.935 J-1.253\nN160 G0 Z120.\nN170 G49\nN180 M30\n%\n";
    let shop = Shop::new().file("m.toml", TRUNNION).file("circle.nc", program);
    let run = shop.run(["circle.nc", "-o", "out.nc", "--machine", "m.toml", "--json"]).exits(0);
    assert!(!run.stderr.contains("W0305"), "{}", run.stderr);
    let json = run.json();
    assert!(json["after"]["max_um"].as_f64().unwrap() < 1.05, "{json}");
    let out = shop.text("out.nc");
    let circle = out.lines().skip_while(|line| !line.starts_with("N130")).take_while(|line| !line.starts_with("N160"));
    // A block of Z alone, or one with hardly more, at each of them.
    assert_eq!(circle.filter(|line| line.contains("(+~)")).count(), 3, "{out}");
    let json = shop.run(["verify", "circle.nc", "out.nc", "--machine", "m.toml", "--json"]).exits(0).json();
    assert!(json["after"]["max_um"].as_f64().unwrap() < 1.05, "{json}");
}
