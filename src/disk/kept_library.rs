//! Subprograms as they were when a program first read them.
//!
//! A program that is fed is executed several times: for its survey, and while its lines are sent, perhaps an hour later. A subprogram that somebody has changed
//! on the disk meanwhile must not reach the machine: nobody has checked its lines.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use ncfix_language::exec::Library;

/// Largest number of answers that are kept: a program may ask for any number of computed names.
const MOST: usize = 10_000;

/// A subprogram: its display name and its bytes.
type Text = (String, Vec<u8>);

/// Answer of a library.
#[derive(Clone, Debug, Default)]
struct Answer {
    text: Option<Text>,
    refusal: Option<String>,
}

/// The answers of a library, shared by all runs of a program.
#[derive(Clone, Debug, Default)]
pub(crate) struct KeptAnswers {
    texts: Arc<Mutex<HashMap<Vec<String>, Answer>>>,
    definitions: Arc<Mutex<Option<Vec<Text>>>>,
}

impl PartialEq for KeptAnswers {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.texts, &other.texts)
    }
}

impl Eq for KeptAnswers {}

/// A library that answers a question again as it did before.
pub(crate) struct KeptLibrary {
    inner: Box<dyn Library>,
    kept: KeptAnswers,
    /// Folders that the program has added: they belong to the question.
    added: Vec<String>,
    refused: Option<String>,
}

impl KeptLibrary {
    pub(crate) fn new(inner: Box<dyn Library>, kept: KeptAnswers) -> KeptLibrary {
        KeptLibrary { inner, kept, added: Vec::new(), refused: None }
    }

    fn ask(&mut self, question: Vec<String>, read: impl FnOnce(&mut dyn Library) -> Option<Text>) -> Option<Text> {
        let question: Vec<String> = question.into_iter().chain(self.added.iter().cloned()).collect();
        let mut texts = self.kept.texts.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(answer) = texts.get(&question) {
            self.refused = answer.refusal.clone();
            return answer.text.clone();
        }
        let text = read(self.inner.as_mut());
        self.refused = self.inner.refusal();
        if texts.len() < MOST {
            texts.insert(question, Answer { text: text.clone(), refusal: self.refused.clone() });
        }
        text
    }
}

impl Library for KeptLibrary {
    fn load(&mut self, name: &str) -> Option<Text> {
        self.ask(vec!["name".to_owned(), name.to_owned()], |inner| inner.load(name))
    }

    fn load_path(&mut self, path: &str, name: &str) -> Option<Text> {
        let question = vec!["path".to_owned(), path.to_owned(), name.to_owned()];
        self.ask(question, |inner| inner.load_path(path, name))
    }

    fn load_file(&mut self, names: &[String]) -> Option<Text> {
        let question = std::iter::once("file".to_owned()).chain(names.iter().cloned()).collect();
        self.ask(question, |inner| inner.load_file(names))
    }

    fn load_number(&mut self, number: u32) -> Option<Text> {
        self.ask(vec!["number".to_owned(), number.to_string()], |inner| inner.load_number(number))
    }

    fn refusal(&mut self) -> Option<String> {
        self.refused.take()
    }

    fn add_folder(&mut self, path: &str) {
        self.inner.add_folder(path);
        if path.is_empty() {
            self.added.clear();
        } else if !self.added.iter().any(|known| known == path) && self.added.len() < MOST {
            self.added.push(path.to_owned());
        }
    }

    fn definitions(&mut self) -> Vec<Text> {
        let mut kept = self.kept.definitions.lock().unwrap_or_else(PoisonError::into_inner);
        kept.get_or_insert_with(|| self.inner.definitions()).clone()
    }
}
