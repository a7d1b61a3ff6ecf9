//! `docs/explanation/theory.md` and `docs/reference/seeds.md` name files and tests: each of them exists.

use std::fs;

use crate::support::repository;

#[test]
fn every_file_and_test_that_the_theory_names_exists() {
    let pages = ["docs/explanation/theory.md", "docs/reference/seeds.md"];
    let text = pages.map(|page| fs::read_to_string(repository(page)).unwrap()).concat();
    let is_path = |word: &&str| ["src/", "crates/", "tests/", "docs/"].iter().any(|folder| word.starts_with(folder));
    let mut files = 0;
    let mut tests = 0;
    for word in text.split('`').skip(1).step_by(2).filter(is_path) {
        let (file, test) = word.split_once("::").map_or((word, None), |(file, test)| (file, Some(test)));
        let source = fs::read_to_string(repository(file)).unwrap_or_else(|_| panic!("there is no {file}"));
        files += 1;
        if let Some(test) = test {
            assert!(
                source.contains(&format!("#[test]\nfn {test}()")) || source.contains(&format!("    fn {test}()")),
                "{word}"
            );
            tests += 1;
        }
    }
    assert!(files > 200 && tests > 185, "{files} {tests}");
}
