//! Comments on a line of their own that a program leaves out: in branches that do not run, and after the end.

use crate::support::{Shop, machine};

/// Programs with the lines of comments that the output must have, in this order, and how often.
const PROGRAMS: [(&str, &str, &str, &[&str]); 4] = [
    (
        "in.mpf",
        "demo",
        "; head\nN10 G90 G71 G17 G94 G54\nN20 T1 M6\nN30 G0 X10 Y10 Z50\nN40 R1=2\nN50 IF R1==1\n; left side\nN60 G1 X20 F500\n\
         N70 ELSE\n; right side\nN80 G1 X30 F500\nN90 ENDIF\nN95 GOTOF AFTER\n; jumped over\nN96 G1 X99\nN97 AFTER: G1 X40\n\
         N100 FOR R2=1 TO 3\n; of the loop\nN105 IF R2==2\n; the second pass\nN106 G1 X41\nN107 ENDIF\nN110 G1 Y=R2*10\nN120 ENDFOR\n\
         N130 M30\n; after the end\n; Programmer: Smith\n",
        &[
            "head",
            "left side",
            "right side",
            "jumped over",
            "of the loop",
            "the second pass",
            "the second pass",
            "after the end",
            "Smith",
        ],
    ),
    (
        "in.nc",
        "vmc",
        "%\nO0001 (HEAD)\nN10 G90 G21 G17 G94 G54\nN20 T1 M6\nN30 G0 X10. Y10. Z50.\n#1=2\nIF[#1EQ1]GOTO60\n(RIGHT SIDE)\nN50 G1 X30. F500\n\
         GOTO70\n(LEFT SIDE)\nN60 G1 X20. F500\nN70 G1 Y20.\nM30\n(AFTER THE END)\n%\n",
        &["HEAD", "RIGHT SIDE", "LEFT SIDE", "AFTER THE END"],
    ),
    (
        "in.ngc",
        "knee_mill",
        "(head)\nN10 G90 G21 G17 G94 G54\nN20 T1 M6\nN30 G0 X10 Y10 Z50\n#1=2\no1 if [#1 EQ 1]\n(left side)\n(DEBUG,#1)\nG1 X20 F500\no1 else\n\
         (right side)\nG1 X30 F500\no1 endif\n#2=1\no2 while [#2 LE 3]\n(of the loop)\nG1 Y[#2*10]\n#2=[#2+1]\no2 endwhile\n\
         o3 while [#2 LE 3]\n(never runs)\nG1 Y5\no3 endwhile\nM2\n(after the end)\n",
        &["head", "left side", "right side", "of the loop", "never runs", "after the end"],
    ),
    (
        "in.pm",
        "universal_mill",
        "%PM9001\nN9001 (HEAD)\nN1 G54\nN2 G0 X0 Y0 Z50\nN3 G29 E1 E1=1 N=6\nN4 (JUMPED OVER)\nN5 G1 X5 F1000\nN6 G1 X1 F1000\nN7 M30\nN8 (AFTER THE END)\n",
        &["HEAD", "JUMPED OVER", "AFTER THE END"],
    ),
];

#[test]
fn comments_that_a_program_leaves_out_stay_where_they_are() {
    for (name, on, program, wanted) in PROGRAMS {
        let shop = Shop::new().file(name, program);
        let out = format!("out_{name}");
        shop.run(["fix", name, "-o", &out, "--machine", &machine(on)]).exits(0);
        let text = shop.text(&out);
        let mut rest = text.as_str();
        for note in wanted {
            let at = rest.find(note).unwrap_or_else(|| panic!("{name}: {note} is missing or too early\n{text}"));
            rest = &rest[at + note.len()..];
        }
        for note in wanted {
            let times = wanted.iter().filter(|other| *other == note).count();
            assert_eq!(text.matches(note).count(), times, "{name}: {note}\n{text}");
        }
        assert!(
            !text.to_ascii_uppercase().contains("DEBUG"),
            "a text that shows values of a branch that does not run\n{text}"
        );
        shop.run(["verify", name, &out, "--machine", &machine(on)]).exits(0);
    }
}
