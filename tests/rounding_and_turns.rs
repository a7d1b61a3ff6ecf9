//! What a turned frame and the last bits of sums must not do to a program of Fanuc or Grundig.

use crate::support::{Shop, machine};

/// The codes of the findings of a correction, and whether a file was written.
fn corrected(file: &str, text: &str, on: &str) -> (Vec<String>, bool) {
    let shop = Shop::new().file(file, text);
    let run = shop.run(["fix", file, "-o", "out", "--json", "--machine", &machine(on)]);
    (run.codes(), shop.path("out").exists())
}

#[test]
fn a_turned_axis_whose_partner_is_not_stated_is_refused() {
    // Behind the tool change X and Y are unknown; turned by 30 degrees, X12 alone moves both by where Y is.
    let fanuc = "O0001\nG21 G17 G90 G54 T5 M6\nG43 H5 Z30.\nG68 X0. Y0. R30.\nG0 X12.\nM30\n";
    assert_eq!(corrected("turn.nc", fanuc, "vmc"), (vec!["E0304".to_owned()], false));
    let grundig = "%PM9001\nN9001\nN1 G17 G90 G54 T5 M6\nN2 G0 Z50\nN3 G93 B4=30\nN4 G0 X12\nN5 M30\n";
    assert_eq!(corrected("turn.pm", grundig, "universal_mill"), (vec!["E0304".to_owned()], false));
    // A quarter turn needs no partner.
    let quarter = fanuc.replace("R30.", "R90.");
    assert_eq!(corrected("turn.nc", &quarter, "vmc"), (vec![], true));
}

/// How many feed moves a program has.
fn feeds(file: &str, text: &str, on: &str) -> usize {
    let shop = Shop::new().file(file, text);
    let run = shop.run(["snc", file, "--machine", &machine(on)]).exits(0);
    run.stdout.lines().filter(|line| line.starts_with("G1 ")).count()
}

#[test]
fn no_peck_is_made_of_what_rounding_leaves() {
    // 4.9 + 11.9 = 3 · 5.6, which doubles miss by a last bit.
    let fanuc = "O0001\nG21 G17 G90 G54 T9 M6\nG43 H9 Z30.\nG0 X0. Y0.\nG98 G73 X-12.226 Y-3.571 Z-11.9 R4.9 Q5.6 F100.\nG80\nM30\n";
    assert_eq!(feeds("peck.nc", fanuc, "vmc"), 3);
    // 6.6 + 6.3 + 6 + 5.7 = 24.6.
    let grundig = "%PM9001\nN9001\nN1 G17 G90 G54 T9 M6\nN2 G0 X0 Y0 Z50\nN3 G83 Y2.5 Z-24.6 K6.6 I0.3 F294\nN4 G79 X1 Y1 Z-1\nN5 M30\n";
    assert_eq!(feeds("peck.pm", grundig, "universal_mill"), 4);
}
