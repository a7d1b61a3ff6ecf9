//! Runs the examples that stand behind the productions in `grammars/`.

use ncfix_base::source::{FileId, Source};
use ncfix_dialect::Language;
use ncfix_language::exec::{Execution, NoLibrary, Options};
use ncfix_language::syntax;

use crate::machines::xyz_machine;

/// Codes of all error findings of a program; those of the word languages are of reading alone.
fn errors_of(text: &str, dialect: &'static ncfix_dialect::Dialect) -> Vec<String> {
    let source = Source::new(FileId(0), "example", text.as_bytes().to_vec()).unwrap();
    let (program, findings) = syntax::parse(&source, dialect);
    if dialect.language != Language::Sinumerik {
        return findings.iter().map(|found| found.code.to_string()).collect();
    }
    let machine = xyz_machine();
    let options = Options { max_blocks: Some(1000), ..Options::default() };
    let executed = Execution::new(program, &machine, Box::new(NoLibrary), options).filter_map(Result::err);
    findings.into_iter().chain(executed).filter(|found| found.is_error()).map(|found| found.code.to_string()).collect()
}

#[test]
fn every_example_of_every_grammar_holds() {
    for dialect in ncfix_dialect::DIALECTS {
        let path = format!("{}/grammars/{}.ebnf", env!("CARGO_MANIFEST_DIR"), dialect.name);
        let text = std::fs::read_to_string(&path).unwrap();
        let (mut good, mut bad, mut faults) = (0, 0, Vec::new());
        for (index, line) in text.lines().enumerate() {
            let place = format!("{path}:{}", index + 1);
            if let Some(example) = line.trim_start().strip_prefix("ok:") {
                let errors = errors_of(&example.trim().replace('|', "\n"), dialect);
                if !errors.is_empty() {
                    faults.push(format!("{place}: {errors:?}"));
                }
                good += 1;
            } else if let Some(example) = line.trim_start().strip_prefix("err:") {
                let (code, example) = example.trim().split_once(' ').unwrap_or((example.trim(), ""));
                let errors = errors_of(&example.replace('|', "\n"), dialect);
                if errors.first().map(String::as_str) != Some(code) {
                    faults.push(format!("{place}: {code} expected, found {errors:?}"));
                }
                bad += 1;
            }
        }
        assert!(faults.is_empty(), "{}", faults.join("\n"));
        assert!(good >= 20 && bad >= 20, "{path}: {good} and {bad} examples");
    }
}
