//! Positions and conditions that use a zero offset or a tool value of the control: the output has numbers, and says so.

use crate::support::Shop;

const MACHINE: &str = "[machine]\nname = \"m\"\ntopology = \"wFXYZt\"\ncontroller = \"sinumerik\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-10, 900]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-10, 900]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-200, 300]\n\
    [[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 1e-5]\n\
    [zero_offset.G54]\nX_mm = 100\nY_mm = 0\nZ_mm = 0\nset = \"absolute\"\n\
    [[tool]]\nnumber = 1\nlength_mm = 120.0\nradius_mm = 4.0\n";

/// The warnings and the output of a program with this block between its approach and its end.
fn run(controller: &str, name: &str, begin: &str, block: &str, end: &str) -> (String, String) {
    let shop = Shop::new()
        .file("m.toml", MACHINE.replace("sinumerik", controller))
        .file(name, format!("{begin}{block}\n{end}"));
    let run = shop.run(["fix", name, "-o", "out.nc", "--machine", "m.toml"]).exits(0);
    (run.stderr, shop.text("out.nc"))
}

fn sinumerik(block: &str) -> (String, String) {
    let begin = "N10 G17 G90 G71 G94 G54\nN20 T1 M6\nN30 D1\nN40 G0 X10 Y10 Z50\nN50 G1 Z5 F500\n";
    run("sinumerik", "in.mpf", begin, block, "N90 X40\nN95 M30\n")
}

fn haas(block: &str) -> (String, String) {
    let begin = "%\nO0001\nN10 G17 G90 G21 G94 G54\nN20 T1 M6\nN30 G43 H1\nN40 G0 X10. Y10. Z50.\nN50 G1 Z5. F500.\n";
    run("haas", "in.nc", begin, block, "N90 G1 X40.\nN95 M30\n%\n")
}

/// The tool is 120 mm long, so Z is 120 − 80 = 40; the radius of 4 mm does not branch at 5.
#[test]
fn a_position_or_a_branch_from_data_of_the_control_is_named() {
    for (block, part) in [
        ("N60 G0 Z=$TC_DP3[1,1]-80", "Z40"),
        ("N60 G0 Z=10+$P_UIFR[1,X,TR]", "Z110"),
        ("N60 IF $TC_DP6[1,1]>5 GOTOF OUT\nN70 G0 Z20\nOUT:", "Z20"),
        ("N60 G0 Z=$P_TOOLL[1]", "Z120"),
    ] {
        let (said, text) = sinumerik(block);
        assert!(said.contains("warning[W0243]") && text.contains(part), "{block}: {said}{text}");
        assert_eq!(said.matches("W0243").count(), 1, "{said}");
    }
    for (block, part) in [
        ("N60 G0 Z[#2001-80.]", "Z40."),
        ("N60 #100=#5221\nN70 G0 Z#100", "Z100."),
        ("N60 IF[#2001 LT 100.]GOTO80\nN70 G0 Z20.\nN80", "Z20."),
    ] {
        let (said, text) = haas(block);
        assert!(said.contains("warning[W0243]") && text.contains(part), "{block}: {said}{text}");
    }
}

/// A step that the output keeps, and numbers of the program itself, are the same with other values at the control.
#[test]
fn computations_that_the_output_keeps_are_not_named() {
    for block in [
        "N60 $P_UIFR[1,X,TR]=$P_UIFR[1,X,TR]+1\nN70 G54",
        "N60 R1=20\nN70 G0 Z=R1",
        "N60 IF R1==0 GOTOF OUT\nN70 G0 Z20\nOUT:",
    ] {
        let block = format!("R1=0\n{block}");
        let (said, _) = sinumerik(&block);
        assert!(!said.contains("W0243"), "{block}: {said}");
    }
    for block in ["N60 #5221=#5221+1.", "N60 #100=20.\nN70 G0 Z#100", "N60 G10 L2 P1 X[#5221+1.]"] {
        let (said, _) = haas(block);
        assert!(!said.contains("W0243"), "{block}: {said}");
    }
}
