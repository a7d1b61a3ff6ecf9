//! The tables of codes and words as the documentation shows them, and that they hold what is promised.

use std::fmt::Write as _;

use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source::{FileId, Source};
use ncfix_dialect::{CodeEffect, DIALECTS, Language, Treatment, words};
use ncfix_language::exec::{Execution, NoLibrary, Options};
use ncfix_language::syntax;

use crate::support::repository;

/// What docs/reference/codes.md must say.
fn page() -> String {
    let mut text = String::from(
        "# G and M codes\n\nThis page lists the codes of each language, and the words of a Sinumerik that are not codes. It is generated from the tables in \
         [`grammars`](../../grammars/) that the program itself reads. Diagnostic codes are not on this page: `ncfix explain E0203` explains one.\n\n\
         The column *effect* states what ncfix does. It passes on `keep` codes in their place, because they change no position. It omits `display` codes, \
         which concern only\nthe screen. It refuses `refuse` codes, because they change positions or feeds in a way that ncfix does not execute. Every other \
         effect (`execute`, `motion`, `frame` …)\nis executed: the output has the resulting positions. Drilling cycles, zero offsets and tool lengths are executed too, but stay in \
         the output. `axes`: any axis word. M codes that are not listed belong \
         to the machine builder; ncfix passes them on.\n\n",
    );
    for dialect in DIALECTS {
        // The anchor of a heading: lower case, `-` for a blank, other signs left out.
        let lower = dialect.title.to_lowercase();
        let anchor: String = lower.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c)).collect();
        writeln!(text, "- [{}](#{})", dialect.title, anchor.replace(' ', "-")).unwrap();
    }
    for dialect in DIALECTS {
        writeln!(text, "\n## {}\n", dialect.title).unwrap();
        writeln!(text, "| code | group | effect | words used | meaning |\n| --- | --- | --- | --- | --- |").unwrap();
        for row in dialect.codes().rows() {
            let effect = format!("{:?}", row.effect).to_lowercase();
            let (words, name) = (row.words.replace('-', ""), row.name.replace("..", " … "));
            writeln!(text, "| {name} | {} | {effect} | {words} | {} |", row.group, row.meaning).unwrap();
        }
        if dialect.language == Language::Sinumerik {
            text.push_str(&page_of_words());
        }
    }
    text
}

/// What the page says of the words of the Sinumerik that are no codes: the legend of the table, and the table.
fn page_of_words() -> String {
    let file = std::fs::read_to_string(repository("grammars/sinumerik-words.tsv")).unwrap();
    let legend = file
        .lines()
        .filter_map(|line| line.strip_prefix('#'))
        .skip(2)
        .map(|line| line.strip_prefix(' ').unwrap_or(line));
    let mut text = String::from("\n### Words that are not codes\n\n```text\n");
    legend.for_each(|line| writeln!(text, "{line}").unwrap());
    text.push_str(
        "```\n\n| word | place | treatment | arguments | source | meaning |\n| --- | --- | --- | --- | --- | --- |\n",
    );
    for row in words().rows() {
        let (place, treatment) = (format!("{:?}", row.place), format!("{:?}", row.treatment));
        let (place, treatment, arguments) =
            (place.to_lowercase(), treatment.to_lowercase(), row.arguments.replace('-', ""));
        writeln!(text, "| {} | {place} | {treatment} | {arguments} | {} | {} |", row.name, row.source, row.meaning)
            .unwrap();
    }
    text
}

/// Run with `NCFIX_WRITE_DOCS=1` to write the page anew.
#[test]
fn the_documentation_shows_the_tables() {
    let path = repository("docs/reference/codes.md");
    if std::env::var_os("NCFIX_WRITE_DOCS").is_some() {
        std::fs::write(&path, page()).unwrap();
    }
    let written = std::fs::read_to_string(&path).unwrap().replace("\r\n", "\n");
    let different = written.lines().zip(page().lines().map(str::to_owned)).find(|(is, should)| is != should);
    assert_eq!(different, None, "run this test with NCFIX_WRITE_DOCS=1");
    assert_eq!(written.lines().count(), page().lines().count(), "run this test with NCFIX_WRITE_DOCS=1");
}

/// Codes that a dialect must know, in tenths.
fn knows(dialect: &str, effect: CodeEffect, tenths: &[usize]) {
    let codes = ncfix_dialect::find(dialect).unwrap().codes();
    for &code in tenths {
        assert_eq!(codes.g_tenths(code).map(|row| row.effect), Some(effect), "{dialect}: G{}.{}", code / 10, code % 10);
    }
}

#[test]
fn the_tables_hold_the_codes_of_the_languages() {
    let fanuc = [
        0, 10, 20, 30, 40, 100, 110, 150, 160, 170, 180, 190, 200, 210, 280, 290, 300, 310, 400, 410, 420, 430, 440,
        490, 434, 435, 500, 510, 501, 511, 520, 530, 540, 590, 541, 650, 660, 670, 680, 690, 682, 531, 730, 740, 760,
        800, 810, 820, 830, 840, 850, 860, 870, 880, 890, 980, 990, 900, 910, 920, 930, 940, 950,
    ];
    knows("fanuc", CodeEffect::Execute, &fanuc);
    knows("fanuc", CodeEffect::Keep, &[90, 610, 620, 630, 640, 960, 970, 51, 80]);
    knows("fanuc", CodeEffect::Refuse, &[22, 32, 62, 71, 130, 1500, 431, 661, 683]);
    let rs274 = [
        0, 10, 20, 30, 40, 50, 51, 52, 53, 100, 170, 200, 210, 280, 281, 300, 301, 382, 383, 384, 385, 400, 410, 411,
        420, 421, 430, 431, 432, 490, 520, 530, 540, 590, 591, 592, 593, 730, 740, 800, 810, 820, 830, 840, 850, 860,
        890, 900, 910, 901, 911, 920, 921, 922, 923, 930, 940, 950, 980, 990, 700, 710,
    ];
    knows("rs274", CodeEffect::Execute, &rs274);
    knows("rs274", CodeEffect::Keep, &[500, 610, 611, 640, 960, 970]);
    knows("rs274", CodeEffect::Refuse, &[70, 80, 171, 510, 711, 712]);
    let grundig = [
        0, 10, 20, 30, 40, 90, 140, 170, 180, 190, 220, 230, 270, 280, 290, 400, 410, 420, 430, 440, 510, 520, 530,
        540, 590, 610, 620, 630, 640, 700, 710, 720, 730, 770, 780, 790, 810, 830, 840, 850, 860, 870, 880, 890, 900,
        910, 920, 930, 940, 950, 70, 1410,
    ];
    knows("grundig", CodeEffect::Execute, &grundig);
    knows("grundig", CodeEffect::Display, &[980, 990, 1950]);
    knows("grundig", CodeEffect::Keep, &[250, 260, 960, 970]);
    knows("grundig", CodeEffect::Refuse, &[80, 450, 2000, 2080, 3200, 6500, 7900]);
    for (dialect, numbers) in [
        ("fanuc", &[0_usize, 1, 2, 3, 30, 6, 98, 99][..]),
        ("rs274", &[0, 1, 2, 6, 30, 61, 62, 68, 70, 73, 98, 99, 150]),
        ("grundig", &[0, 1, 2, 6, 30, 53, 54, 66, 67]),
    ] {
        let codes = ncfix_dialect::find(dialect).unwrap().codes();
        assert!(numbers.iter().all(|&number| codes.m(number).is_some()), "{dialect}");
    }
}

#[test]
fn groups_and_words_of_some_codes() {
    let fanuc = ncfix_dialect::find("fanuc").unwrap().codes();
    assert_eq!(fanuc.g(54).map(|row| row.group), fanuc.g_tenths(541).map(|row| row.group));
    let group = |number: usize| fanuc.g(number).map(|row| row.group);
    assert!(group(73) == group(80) && group(80) == group(89) && group(0) != group(80));
    assert!(fanuc.g(1).is_some_and(|row| row.uses(b'X') && !row.uses(b'I') && row.uses_comma(b'C')));
    assert!(fanuc.g(2).is_some_and(|row| row.uses(b'I') && row.uses(b'R') && !row.uses(b'P')));
    let rs274 = ncfix_dialect::find("rs274").unwrap().codes();
    assert!(rs274.g(1).is_some_and(|row| row.uses(b'@') && row.uses(b'^') && !row.uses(b'R')));
    assert!(rs274.g(2).is_some_and(|row| row.uses(b'P')));
    assert_eq!(rs274.g(0).map(|row| row.group), rs274.g(81).map(|row| row.group));
    let grundig = ncfix_dialect::find("grundig").unwrap().codes();
    assert!(grundig.g(1).is_some_and(|row| row.uses_indexed(b'B', 1) && !row.uses(b'I')));
    assert!(grundig.g(14).is_some_and(|row| row.uses_indexed(b'N', 2) && row.uses(b'J')));
}

/// Whether the execution of a code ends in an error.
fn fails(dialect: &'static ncfix_dialect::Dialect, name: &str) -> bool {
    let text = format!("G17 G21 G90 G94 G0 X0 Y0 Z0 F100 S100\n{}\n", name.split("..").next().unwrap());
    let source = Source::new(FileId(0), "code", text.into_bytes()).unwrap();
    let (program, findings) = syntax::parse(&source, dialect);
    assert_eq!(findings, [], "{name}");
    let machine = crate::machines::xyz_machine();
    let options = Options { max_blocks: Some(100), ..Options::default() };
    let mut found = Execution::new(program, &machine, Box::new(NoLibrary), options).filter_map(Result::err);
    found.any(|found| found.is_error())
}

#[test]
fn what_the_table_refuses_is_never_executed() {
    let mut wrong = Vec::new();
    for dialect in DIALECTS.iter().filter(|dialect| dialect.language != Language::Sinumerik) {
        let refused = dialect.codes().rows().iter().filter(|row| row.effect == CodeEffect::Refuse);
        wrong.extend(refused.filter(|row| !fails(dialect, row.name)).map(|row| (dialect.name, row.name)));
    }
    assert_eq!(wrong, []);
}

#[test]
fn every_refused_word_of_the_sinumerik_says_why() {
    let machine = crate::machines::xyz_machine();
    for row in words().rows() {
        if !matches!(row.treatment, Treatment::Refuse | Treatment::Later) {
            continue;
        }
        let values =
            row.arguments.replace("(...)", "(1)").replace("axis", "X").replace("value", "1").replace("length", "1");
        let text = format!("{}{}\n", row.name, values.replace('-', ""));
        let source = Source::new(FileId(0), "example", text.clone().into_bytes()).unwrap();
        let (program, findings) = syntax::parse(&source, ncfix_dialect::sinumerik());
        let executed =
            Execution::new(program, &machine, Box::new(NoLibrary), Options::default()).filter_map(Result::err);
        let found = findings.into_iter().chain(executed).find(Diagnostic::is_error);
        let found = found.unwrap_or_else(|| panic!("{text} is not refused"));
        assert_eq!(found.code, Code::NOT_SUPPORTED, "{text}: {}", found.message);
        // A word that may follow later says so, or why it does not.
        let reasons = match row.treatment {
            Treatment::Refuse => [row.meaning; 2],
            _ => ["not supported yet", "is not executed: "],
        };
        assert!(reasons.iter().any(|reason| found.message.contains(reason)), "{text}: {}", found.message);
    }
}
