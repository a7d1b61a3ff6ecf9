//! Subprograms beside the main program: `L123`, `POCKET` become files of its folder, whatever the case of their names.

use std::cell::RefCell;
use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use crate::exec::Library;

/// The folder of the main program.
pub(super) struct FolderLibrary {
    /// Files by lower-case name, read at the first call; several where only the case differs.
    files: Option<HashMap<String, Vec<PathBuf>>>,
    folder: Option<PathBuf>,
    loaded: Rc<RefCell<Vec<PathBuf>>>,
}

impl FolderLibrary {
    /// The folder of `program`; none for a program from standard input. The second value lists, as the program runs, the files
    /// that were read: none of them may be overwritten.
    pub(super) fn beside(program: Option<&Path>) -> (FolderLibrary, Rc<RefCell<Vec<PathBuf>>>) {
        let loaded = Rc::default();
        let folder = program.map(|program| match program.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
            _ => PathBuf::from("."),
        });
        (FolderLibrary { files: None, folder, loaded: Rc::clone(&loaded) }, loaded)
    }

    /// The file of a subprogram. Only names of files in the folder are ever compared, so no name leads out of it.
    fn find(&mut self, name: &str) -> Option<PathBuf> {
        let folder = self.folder.as_deref()?;
        let files = self.files.get_or_insert_with(|| list(folder));
        let candidates = [
            format!("{name}.SPF"),
            format!("{name}.MPF"),
            name.to_owned(),
            format!("_N_{name}_SPF"),
            format!("_N_{name}_MPF"),
        ];
        candidates.iter().find_map(|candidate| {
            let paths = files.get(&candidate.to_lowercase())?;
            let same_case = |path: &&PathBuf| path.file_name().is_some_and(|file| file == candidate.as_str());
            paths.iter().find(same_case).or_else(|| paths.first()).cloned()
        })
    }
}

/// The plain files of a folder by lower-case name, in a fixed order.
fn list(folder: &Path) -> HashMap<String, Vec<PathBuf>> {
    let mut files: HashMap<String, Vec<PathBuf>> = HashMap::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        if let (Ok(name), true) = (entry.file_name().into_string(), entry.path().is_file()) {
            files.entry(name.to_lowercase()).or_default().push(folder.join(name));
        }
    }
    files.values_mut().for_each(|paths| paths.sort());
    files
}

impl Library for FolderLibrary {
    fn load(&mut self, name: &str) -> Option<(String, Vec<u8>)> {
        let path = self.find(name)?;
        let bytes = fs::read(&path).ok()?;
        let shown = path.strip_prefix(".").unwrap_or(&path).display().to_string();
        self.loaded.borrow_mut().push(path);
        Some((shown, bytes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(files: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for file in files {
            fs::write(folder.path().join(file), file).unwrap();
        }
        folder
    }

    fn load(folder: &Path, name: &str) -> Option<String> {
        let (mut library, _) = FolderLibrary::beside(Some(&folder.join("main.mpf")));
        library.load(name).map(|(_, bytes)| String::from_utf8(bytes).unwrap())
    }

    #[test]
    fn names_are_found_in_any_case_and_form() {
        let folder = folder(&["l10.spf", "POCKET.MPF", "_N_EDGE_SPF", "PLAIN"]);
        let found = |name| load(folder.path(), name);
        assert_eq!(found("L10").as_deref(), Some("l10.spf"));
        assert_eq!(found("pocket").as_deref(), Some("POCKET.MPF"));
        assert_eq!(found("EDGE").as_deref(), Some("_N_EDGE_SPF"));
        assert_eq!(found("PLAIN").as_deref(), Some("PLAIN"));
        assert_eq!(found("L010"), None);
    }

    #[test]
    fn a_subprogram_goes_before_a_main_program() {
        let folder = folder(&["A.MPF", "A.SPF", "A"]);
        assert_eq!(load(folder.path(), "A").as_deref(), Some("A.SPF"));
    }

    #[test]
    fn no_name_leads_out_of_the_folder() {
        let outer = folder(&["SECRET.SPF"]);
        let inner = outer.path().join("inner");
        fs::create_dir(&inner).unwrap();
        assert_eq!(load(&inner, "../SECRET"), None);
        assert_eq!(load(&inner, outer.path().join("SECRET").to_str().unwrap()), None);
        assert_eq!(load(outer.path(), "inner"), None);
    }

    #[test]
    fn loaded_files_are_remembered_and_standard_input_has_none() {
        let folder = folder(&["L1.SPF"]);
        let (mut library, loaded) = FolderLibrary::beside(Some(&folder.path().join("m.mpf")));
        library.load("L1").unwrap();
        assert_eq!(*loaded.borrow(), [folder.path().join("L1.SPF")]);
        assert!(FolderLibrary::beside(None).0.load("L1").is_none());
    }
}
