//! `ncfix machine check` names values whose sign only unusual machines have (`W0409`); negative lengths of a touch are refused.

use super::support::Shop;

/// X carries the workpiece, Z the tool, and C turns the table about −Z.
fn machine(rest: &str) -> String {
    format!(
        "[machine]\nname = \"m\"\ntopology = \"wCXYFZt\"\ncontroller = \"sinumerik\"\n\
         [axis.X]\ndirection = [-1, 0, 0]\ntravel_mm = [0, 500]\n[axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [0, 400]\n\
         [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 300]\n[axis.C]\ndirection = [0, 0, -1]\ntravel_deg = [-360, 360]\n{rest}"
    )
}

fn named(rest: &str) -> Vec<String> {
    let shop = Shop::new().file("m.toml", machine(rest));
    let run = shop.run(["machine", "check", "m.toml"]).exits(0);
    let lines = run.stderr.lines().filter(|line| line.starts_with("warning[W0409]"));
    lines.map(str::to_owned).collect()
}

/// A body that lags is behind its command: after a positive motion, X of the workpiece side is too far in +X of the machine, because it moves to −X.
#[test]
fn a_backlash_that_goes_too_far_is_named() {
    let backlash = |component: &str, values: &str| {
        format!("[[motion]]\ncomponent = \"{component}\"\nkind = \"backlash\"\n{values}\n")
    };
    for (component, lost, unit) in [("EXX", 1.0, "um"), ("EZZ", -1.0, "um"), ("ECC", 1.0, "urad")] {
        let found = named(&backlash(component, &format!("value_{unit} = {}", 8.0 * lost)));
        assert!(found.is_empty(), "{found:?}");
        let found = named(&backlash(component, &format!("value_{unit} = {}", -8.0 * lost)));
        let says = format!("backlash {component} of {:.2} ", -8.0 * lost);
        assert!(found.len() == 1 && found[0].contains(&says), "{found:?}");
    }
    // The larger one of two ends with the unusual sign is named, and play across the axis has no usual sign.
    let found = named(&backlash("EZZ", "positions_mm = [0, 300]\nvalues_um = [-2, 5]"));
    assert!(found.len() == 1 && found[0].contains("of 5.00 µm"), "{found:?}");
    assert!(named(&backlash("EXZ", "value_um = 8")).is_empty());
    // A calibration has found it.
    let fitted = backlash("EXX", "value_um = -8") + "[uncertainty]\nEXXb = [0.5]\n";
    assert!(named(&fitted).is_empty());
}

#[test]
fn a_negative_length_is_named_or_refused() {
    let found = named("[[tool]]\nnumber = 4\nlength_mm = -120\n");
    assert!(found.len() == 1 && found[0].contains("tool 4 is -120 mm"), "{found:?}");
    let zero =
        "[zero_offset.G54]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\nset = \"touched\"\nset_at = { tool_length_mm = -120 }\n";
    let shop = Shop::new().file("m.toml", machine(zero)).file("p.mpf", "G54 G0 X10 Y10 Z100\nG1 Z90 F500\nM30\n");
    shop.run(["machine", "check", "m.toml"]).exits(4).says("tool_length_mm").says("not negative");
    std::fs::write(shop.path("m.toml"), machine(&zero.replace("tool_length_mm = -120", "tool_length_mm = 120")))
        .unwrap();
    let run = shop.run(["p.mpf", "-o", "o.mpf", "--machine", "m.toml", "--zero", "G54=touched@X325,L-150"]).exits(2);
    run.says("negative length L");
    assert!(!shop.path("o.mpf").exists());
}
