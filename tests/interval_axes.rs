//! The interval of the largest error along each axis contains the place of that error, however short the cut there is.

use crate::support::Shop;

/// X is 100 µm/m too long and Y 200 µm/m, each ± 1 µm/m.
const LONG: &str = "[machine]\nname = \"long\"\ntopology = \"wFXYZt\"\ncontroller = \"sinumerik\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 500]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 500]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-200, 200]\n\
    [[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 1e-4]\n\
    [[motion]]\ncomponent = \"EYY\"\nkind = \"polynomial\"\ncoefficients = [0, 2e-4]\n\
    [uncertainty]\nEXX1 = 1e-6\nEYY1 = 1e-6\n";

/// 20 m of cuts at Y 400, and in the middle 2 mm at X 302.
fn program() -> String {
    let passes = "X110\nX10\n".repeat(100);
    format!(
        "N10 G17 G90 G71 G94\nG0 X10 Y400 Z50\nG1 Z-5 F500\n{passes}G0 Z50\nX300 Y10\nG1 Z-5\nX302\n\
         G0 Z50\nX10 Y400\nG1 Z-5\n{passes}G0 Z50\nM30\n"
    )
}

#[test]
fn the_largest_error_along_an_axis_is_found_in_a_short_cut() {
    let shop = Shop::new().file("m.toml", LONG).file("in.mpf", program());
    let json = shop.run(["in.mpf", "-o", "out.mpf", "--machine", "m.toml", "--json"]).exits(0).json();
    let end = |side: &str, axis: &str, end: usize| json["prediction"][side]["axes_um"][axis][end].as_f64().unwrap();
    // 302 mm · 100 µm/m = 30.2 µm ± 1.96 · 0.302 µm; at Y 400, 80 µm ± 1.96 · 0.4 µm.
    for (axis, largest, sigma) in [("X", 30.2, 0.302), ("Y", 80.0, 0.4)] {
        let [low, high] = [end("before", axis, 0), end("before", axis, 1)];
        assert!((low - (largest - 1.96 * sigma)).abs() < 0.6 * sigma, "{axis}: {low} {high}");
        assert!((high - (largest + 1.96 * sigma)).abs() < 0.6 * sigma, "{axis}: {low} {high}");
        // The correction removes the known part: 97.5 % of the magnitudes are below 2.24 σ.
        let high = end("after", axis, 1);
        assert!((high - 2.24 * sigma).abs() < 0.4 * sigma, "{axis} after: {high}");
    }
}

/// X lags by 6 µm, and the first cut begins where X may be on either side: 3 µm to either side, before and after.
#[test]
fn a_body_on_an_unknown_side_widens_the_interval_along_its_axis() {
    let machine = "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n\
        [axis.X]\ndirection = [1, 0, 0]\n[axis.Y]\ndirection = [0, 1, 0]\n[axis.Z]\ndirection = [0, 0, 1]\n\
        [[motion]]\ncomponent = \"EXX\"\nkind = \"backlash\"\nvalue_um = -6\n[uncertainty]\nEXXb = 0.02\n";
    let shop = Shop::new().file("m.toml", machine).file("in.mpf", "G0 X100 Y0 Z0\nG1 Y50 F500\nX150\nM30\n");
    let run = shop.run(["in.mpf", "-o", "out.mpf", "--machine", "m.toml", "--json"]).exits(0);
    assert!(run.codes().contains(&"W0308".to_owned()), "{:?}", run.codes());
    let json = run.json();
    for side in ["before", "after"] {
        let high = json["prediction"][side]["axes_um"]["X"][1].as_f64().unwrap();
        assert!(high > 2.9 && high < 6.2, "{side}: {high}");
    }
    // The known reversals need no such room.
    let shop = Shop::new().file("m.toml", machine).file("in.mpf", "G0 X90 Y0 Z0\nX100\nG1 Y50 F500\nX150\nM30\n");
    let json = shop.run(["in.mpf", "-o", "out.mpf", "--machine", "m.toml", "--json"]).exits(0).json();
    let high = json["prediction"]["after"]["axes_um"]["X"][1].as_f64().unwrap();
    assert!(high < 0.7, "{high}");
}
