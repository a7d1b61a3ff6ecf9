//! Runs the examples that stand behind the productions in `grammars/`, and looks for the functions that read them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use ncfix_base::source::{FileId, Source};
use ncfix_dialect::Language;
use ncfix_language::exec::{Execution, NoLibrary, Options};
use ncfix_language::syntax;

use crate::machines::xyz_machine;
use crate::support::repository;

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

/// The productions that a grammar has.
fn productions_of(dialect: &str) -> BTreeSet<String> {
    let text = std::fs::read_to_string(repository(&format!("grammars/{dialect}.ebnf"))).unwrap();
    let is_name =
        |name: &str| !name.is_empty() && name.bytes().all(|byte| byte.is_ascii_lowercase() || b"_".contains(&byte));
    let heads = text.lines().filter_map(|line| line.split_once('=')).map(|(head, _)| head.trim_end());
    heads.filter(|head| is_name(head)).map(str::to_owned).collect()
}

/// The productions that the doc of a function names, with their dialects: "Productions `sum` and `product` (fanuc, rs274), `power` (rs274)". Where
/// no dialect stands, it is the Sinumerik.
fn named_in(doc: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    for (at, word) in doc.match_indices("Production") {
        let mut rest = doc[at + word.len()..].trim_start_matches('s');
        let mut waiting: Vec<&str> = Vec::new();
        loop {
            rest = rest.trim_start_matches([' ', ',']);
            rest = rest.strip_prefix("and ").unwrap_or(rest);
            if let Some((name, behind)) = rest.strip_prefix('`').and_then(|rest| rest.split_once('`')) {
                waiting.push(name);
                rest = behind;
            } else if let Some((dialects, behind)) = rest.strip_prefix('(').and_then(|rest| rest.split_once(')')) {
                for dialect in dialects.split(", ") {
                    found.extend(waiting.iter().map(|name| (dialect.to_owned(), (*name).to_owned())));
                }
                waiting.clear();
                rest = behind;
            } else {
                break;
            }
        }
        found.extend(waiting.iter().map(|name| ("sinumerik".to_owned(), (*name).to_owned())));
    }
    found
}

/// Every production has a function that says in its doc that it reads it, and no doc names a production that there is not.
#[test]
fn every_production_of_every_grammar_has_its_function() {
    let mut named: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for path in rust_files(&repository("crates/language/src")) {
        let text = std::fs::read_to_string(&path).unwrap();
        let mut doc = String::new();
        for line in text.lines().map(str::trim) {
            if let Some(comment) = line.strip_prefix("///") {
                doc.push_str(comment);
            } else if line.starts_with("#[") {
                continue;
            } else {
                let found = named_in(&doc);
                assert!(
                    found.is_empty() || line.contains("fn "),
                    "{}: a production without a function: {doc}",
                    path.display()
                );
                for (dialect, name) in found {
                    named.entry(dialect).or_default().insert(name);
                }
                doc.clear();
            }
        }
    }
    for dialect in ncfix_dialect::DIALECTS {
        let (written, read) = (productions_of(dialect.name), named.remove(dialect.name).unwrap_or_default());
        let missing: Vec<_> = written.difference(&read).collect();
        let unknown: Vec<_> = read.difference(&written).collect();
        assert!(written.len() >= 15, "{}: {written:?}", dialect.name);
        assert!(missing.is_empty(), "{}: no function names {missing:?}", dialect.name);
        assert!(unknown.is_empty(), "{}: the grammar has no {unknown:?}", dialect.name);
    }
    assert!(named.is_empty(), "unknown dialects: {named:?}");
}

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(rust_files(&path));
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
    found
}
