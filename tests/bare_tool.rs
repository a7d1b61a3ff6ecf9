//! Tools that cut while the control adds no length.

use std::fmt::Write as _;

use crate::support::Shop;

/// X pitches by 1 µrad per mm: at X100 the tip of a tool of 80 mm is 100e-6 · 80 mm = 8 µm beside the place that counts for a tool without a length.
#[test]
fn a_tool_that_cuts_without_its_length_is_named() {
    let machine = |controller: &str, tools: &str| {
        let mut text = format!("[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\ncontroller = \"{controller}\"\n");
        for (axis, direction) in [("X", "[1, 0, 0]"), ("Y", "[0, 1, 0]"), ("Z", "[0, 0, 1]")] {
            let _ = writeln!(text, "[axis.{axis}]\ndirection = {direction}\ntravel_mm = [-500, 500]");
        }
        text + tools
            + "[zero_offset.G54]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\nset = \"absolute\"\n\
               [[motion]]\ncomponent = \"EBX\"\nkind = \"polynomial\"\ncoefficients = [0, 1e-6]\n"
    };
    let tools = "[[tool]]\nnumber = 5\nlength_mm = 80\nradius_mm = 4\n";
    let none = "[[tool]]\nnumber = 5\nlength_mm = 0\nradius_mm = 4\n";
    let fanuc = |tool: &str, length: &str| {
        format!(
            "%\nO1\nG21 G17 G90 G40 G49 G80 G94\n{tool}G54 G0 X0. Y0. S1000 M3\nG0 {length}Z50.\nG1 X100. F500.\nM30\n%\n"
        )
    };
    let rs274 = "G21 G90 G17 G94 G54\nT5 M6\nG43 H5\nG0 X0 Y0 Z50 S1000 M3\nG1 X100 F500\nG49\nG0 Z50\nG1 X0\nM2\n";
    let sinumerik = "G17 G90 G71 G94 G54\nT5\nM6\nD0\nG0 X0 Y0 Z50 S1000 M3\nG1 X100 F500\nM30\n";
    let cases = [
        ("fanuc", tools, fanuc("T5 M6\n", ""), Some(("part.nc:7", "T5", "80.0 mm (its length"))),
        ("fanuc", tools, fanuc("T9 M6\n", ""), Some(("part.nc:7", "T9", "80.0 mm (the longest"))),
        ("fanuc", tools, fanuc("T5 M6\n", "G43 H5 "), None),
        // The gauge point is the tip of this tool.
        ("fanuc", none, fanuc("T5 M6\n", ""), None),
        ("fanuc", tools, fanuc("", ""), None),
        ("rs274", tools, rs274.to_owned(), Some(("part.nc:8", "T5", "80.0 mm (its length"))),
        ("sinumerik", tools, sinumerik.to_owned(), Some(("part.nc:6", "T5", "80.0 mm (its length"))),
    ];
    for (controller, tools, text, named) in cases {
        let shop = Shop::new().file("m.toml", machine(controller, tools)).file("part.nc", &text);
        let run = shop.run(["part.nc", "-o", "out.nc", "--machine", "m.toml"]).exits(0);
        let Some((place, tool, length)) = named else {
            assert!(!run.stderr.contains("W0333"), "{controller}: {}", run.stderr);
            continue;
        };
        run.says("warning[W0333]")
            .says(place)
            .says(&format!("{tool} cuts here"))
            .says(length)
            .says("up to 8.00 µm off");
        let required = ["check", "part.nc", "--machine", "m.toml", "--require-coverage"];
        shop.run(required).exits(4).says(&format!("{tool} cuts here"));
    }
}
