//! Recognizes texts of controls whose language is not supported. Words that look familiar in such texts move the tool differently.

use std::sync::LazyLock;

use ncfix_base::pattern::{RegexSet, patterns};

use super::blocks::lines;

/// Number of bytes that are examined: such texts are recognizable at their beginning.
const HEAD: usize = 8192;

/// Control whose language is not supported.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Foreign {
    /// Common name.
    pub name: &'static str,
    /// Text that was found.
    pub found: String,
    /// Line of the text, from 1.
    pub line: u32,
    /// Beginning of the line, bytes from the start of the text.
    pub at: usize,
}

/// Language with patterns of its lines, and the number of matches that identifies it.
struct Language {
    name: &'static str,
    marks: &'static [&'static str],
    enough: usize,
}

const LANGUAGES: &[Language] = &[
    Language {
        name: "a Heidenhain Klartext program",
        // `0 BEGIN PGM FLANGE MM`, `1 BLK FORM 0.1 Z X+0 Y+0 Z-20`, `5 TOOL CALL 3 Z S2000`
        marks: &[
            r"^[0-9]*\s*BEGIN PGM ",
            r"^[0-9]*\s*BLK FORM ",
            r"^[0-9]*\s*TOOL CALL ",
            r"^[0-9]*\s*CYCL DEF ",
            r"^[0-9]*\s*END PGM ",
        ],
        enough: 1,
    },
    Language {
        name: "an Okuma OSP program",
        // `$PART.MIN%`, `CALL O100`, `VC1=10`, `G15 H1`, `G56 H1 HA=1`, `G85 NLAP1 D4`
        marks: &[
            r"^\$.*\.MIN",
            r"(?:^|[^A-Z_])CALL O",
            r"^VC[0-9]+\s*=",
            r"(?:^| )G15 H",
            r"^G56 H(?:A|.*[^A-Z_]HA)",
            r"^NLAP|(?:^|[^A-Z_])G85 NLAP",
        ],
        enough: 2,
    },
    Language {
        name: "an Okuma OSP program",
        // `$PART.MIN%`
        marks: &[r"^\$[^ ]+\.MIN%$"],
        enough: 1,
    },
    Language {
        name: "a 3D printer program",
        // `;FLAVOR:Marlin`, `M104 S200`, `G92 E0`, `G1 X10 Y5 E0.3`, `M117 Heating`
        marks: &["^;FLAVOR:", "^M(?:104|109|140|190) S", "^G92 E", "^G[01] (?-i:(?:.* )?E[-.0-9])", "^M117 [A-Z]"],
        enough: 2,
    },
    Language {
        name: "a ShopMill or ShopTurn program of a Sinumerik (work plan steps)",
        // `N10 E_HEAD(...)`
        marks: &[r"(?:^|[^A-Z_])E_HEAD\(", r"(?:^|[^A-Z_])F_HEAD\("],
        enough: 1,
    },
    Language {
        name: "a Heidenhain DIN/ISO program",
        // `%FLANGE G71 *`, `N10 G30 G17 X+0 Y+0 Z-20*`, `N20 G31 G90 X+100 Y+100 Z+0*`
        marks: &[r"^%\S+\s+G7[01]\s*\*", r"^N[0-9]+\s*G30\s*G17.*\*", r"^N[0-9]+\s*G31\s*G9[01].*\*"],
        enough: 1,
    },
    Language {
        name: "a program of an older Sinumerik (@ codes)",
        // `%MPF 90`, `N1 @371 R52 K2 K0`, `L100 @714`
        marks: &[r"^%(?:MPF|SPF)\s*[0-9]+", r"(?:^|\s)@[0-9]{3}(?:\s|$)", r"^N[0-9]+\s.*@[0-9]{3}\s+[RKP][0-9]"],
        enough: 2,
    },
    Language {
        name: "a Fagor program",
        // `%PART,MX--,`, `#RTCP ON`, `(RPT N10,N20)N5`, `(PCALL 10)`, `(P100=P101 F1 1)`
        marks: &[
            r"^%[^,]*,M[XT]",
            r"^#(?:RTCP|TLC|HSC|KIN ID|CS|ACS)\b",
            r"^(?:N[0-9]+\s*)?\((?:RPT\s+N[0-9]|(?:P|M)?CALL\s+[0-9P])",
            r"^(?:N[0-9]+\s*)?\(P[0-9]+\s*=",
            r"^(?:N[0-9]+\s*)?\(IF\s.*GOTO\s*N?[0-9]",
        ],
        enough: 2,
    },
    Language {
        name: "a Fagor program",
        // `%00228`, `N0010 T1.1`: the tool and its offset in one word.
        marks: &[r"^%[0-9]{5,6}$", r"^(?:N[0-9]+\s*)?(?:[^(;]*[^A-Z_(;])?T[0-9]+\.[0-9]+(?:[^0-9]|$)"],
        enough: 2,
    },
    Language {
        name: "a NUM program",
        // `G77 H100 N10 N20`, `G79 L1=5 N100`, `E81000=1`, `L1=L1+1`, `$0 TEXT`
        marks: &[
            r"(?:^|\s)G77\s*(?:H|N)[0-9]",
            r"(?:^|\s)G79\s*(?:N|L[0-9]+\s*[=<>]|E[0-9])",
            r"(?:^|\s)E[5-9][0-9]{4}(?:\s|=|$)",
            r"^(?:N[0-9]+\s*)?L[0-9]{1,3}\s*=\s*(?:L[0-9]|E[0-9]{5}|[-.0-9])",
            r"^\$[0-9]\s",
            r"(?:^|\s)G16\s*[PQR][-+](?:\s|$)",
        ],
        enough: 2,
    },
    Language {
        name: "a program of a Cincinnati Acramatic control",
        // `: (PGM, NAME="1001")`, `(MSG, TEXT)` alone is also LinuxCNC.
        marks: &[r"^:\s*(?:[0-9]+\s*)?\(PGM,\s*NAME="],
        enough: 1,
    },
    Language {
        name: "a program for an ISG kernel, for example of Beckhoff TwinCAT",
        // `#SLOPE [TYPE=STEP]`, `#CONTOUR MODE [DEV PATH_DEV=0.1]`, `#TRAFO ON`, `V.P.DEPTH=3`
        marks: &[
            r"^(?:N[0-9]+\s*)?#(?:SLOPE\s*\[|SET SLOPE |CONTOUR MODE|TRAFO (?:ON|OFF))",
            r"^(?:N[0-9]+\s*)?V\.[GPLS]\.[A-Z][A-Z0-9_]*\s*=",
        ],
        enough: 1,
    },
    Language {
        name: "a program of an EdingCNC or KinetiC-NC control",
        // `MSG "TEXT"`
        marks: &[r#"^(?:N[0-9]+\s*)?MSG\s+["']"#],
        enough: 1,
    },
    Language {
        name: "a Fadal program (format 1)",
        // `N5E1X1.Y1.` calls a work offset, `N6H1Z1.` a tool length
        marks: &[
            r"^(?:N[0-9]+\s*)?(?:G0*\s*)?E[0-9]{1,2}\s*X[-.0-9]",
            r"^(?:N[0-9]+\s*)?(?:G0*\s*)?H[0-9]{1,2}\s*Z[-.0-9]+\s*(?:M[0-9]+\s*)*$",
        ],
        enough: 2,
    },
    Language {
        name: "a program of a wire EDM machine",
        // `//ACCUTEX WEDM CUTTING CONDITIONS`
        marks: &[r"^//.*WEDM"],
        enough: 1,
    },
    Language {
        name: "a Mazatrol conversational program",
        // `UNo. UNIT`
        marks: &[r"^UNo\..*UNIT"],
        enough: 1,
    },
];

/// Marks of all languages in sequence.
static MARKS: LazyLock<RegexSet> =
    LazyLock::new(|| patterns(LANGUAGES.iter().flat_map(|language| language.marks).copied()));

/// Returns the control of a text in an unsupported language; `None` if none is recognized.
#[must_use]
pub fn foreign(bytes: &[u8]) -> Option<Foreign> {
    let head = bytes.get(..bytes.len().min(HEAD)).unwrap_or_default();
    let mut is_found = vec![None; LANGUAGES.iter().map(|language| language.marks.len()).sum()];
    for (number, (at, line)) in (1..).zip(lines(head)) {
        let text = line.trim_ascii();
        for mark in &MARKS.matches(text) {
            if let Some(first) = is_found.get_mut(mark) {
                first.get_or_insert((number, at, text));
            }
        }
    }
    let mut rest = is_found.as_slice();
    LANGUAGES.iter().find_map(|language| {
        let (own, others) = rest.split_at(language.marks.len());
        rest = others;
        let (line, at, text) = own.iter().flatten().min()?;
        if own.iter().flatten().count() < language.enough {
            return None;
        }
        let found = text.iter().take(40).map(|&byte| if (b' '..0x7f).contains(&byte) { char::from(byte) } else { '?' });
        Some(Foreign { name: language.name, found: found.collect(), line: *line, at: *at })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mark_is_a_pattern_and_enough_of_them_tell() {
        assert_eq!(MARKS.len(), LANGUAGES.iter().map(|language| language.marks.len()).sum::<usize>());
        for (text, name) in [
            ("0  BEGIN PGM FLANGE MM\n", "Heidenhain"),
            ("1 blk form 0.1 Z X+0 Y+0 Z-20", "Heidenhain"),
            ("$PART.MIN%\nN1 CALL O100 \n", "Okuma"),
            ("$PART.MIN%\nG0 X1", "Okuma"),
            ("VC1 =10\nG56 H1 HA=1", "Okuma"),
            ("N1 G15 H1\nG85 NLAP1 D4", "Okuma"),
            (";FLAVOR:Marlin\nG1 X10 Y5 E0.3", "3D printer"),
            ("m104 S200\ng92 E0", "3D printer"),
            ("M109 S160\nM117 Heating", "3D printer"),
            ("N10 E_HEAD(1,2)", "ShopMill"),
            ("#SLOPE[TYPE=STEP]\nG00 X1", "ISG"),
            ("N20 V.P.DEPTH = 3", "ISG"),
            ("UNo. UNIT ADD. S.", "Mazatrol"),
            ("%FLANGE G71 *\nN10 G30 G17 X+0 Y+0 Z-20*", "DIN/ISO"),
            ("%MPF  90\nN1 @371 R52 K2 K0", "older Sinumerik"),
            ("%PART,MX--,\n#RTCP ON", "Fagor"),
            ("N10 (RPT N1,N5)N2\n(P100=P101 F1 1)", "Fagor"),
            ("%00228\nN0000 M6\nN0010 T1.1 (PLATO D63)", "Fagor"),
            ("%1\nL1=5\nG77 H100 N10 N20", "NUM"),
            ("//\n//ACCUTEX WEDM CUTTING CONDITIONS --BEGIN--", "wire EDM"),
            (": (PGM, NAME=\"1001\")\nN10 G0 X1", "Acramatic"),
            ("G21\nN5 msg \"Tool 3\"", "EdingCNC"),
            ("N5E1X1.Y1.\nN6 H1 Z1. M8", "Fadal"),
        ] {
            assert!(foreign(text.as_bytes()).is_some_and(|found| found.name.contains(name)), "{text}");
        }
        for text in [
            "N10 FE_HEAD(1)",
            "G7 A5=15. L1=1\n%MPF1",
            "G77 X1\nL1=5",
            "(CALL ME)\n(IF NEEDED)",
            "G1 X1 e5\nG92 E0",
            "G56 H1 XHA=1\nG15 H1",
            "$PART.MIN\nTOCALL O1",
            "G12 E5\nG92 E0",
            "%00228\nT1 M6",
            "(MSG, Tool 3)\nMSG(\"Tool 3\")\n: (PART)",
            "G43 H1 Z1.\nE1 X1",
            "H1 Z1.\nG1 E0.3 X1",
            "T1.1\nM6",
            "%00228\n(T1.1)\nSET1.1",
            "",
        ] {
            assert_eq!(foreign(text.as_bytes()), None, "{text}");
        }
        let found = foreign(b"G0 X1\nG92 E0\n M140 S60\n").unwrap();
        assert_eq!((found.line, found.at, found.found.as_str()), (2, 6, "G92 E0"));
    }
}
