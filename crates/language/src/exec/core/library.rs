//! Sources of programs outside the main program's file.

/// Finds subprograms outside the main program's file.
pub trait Library {
    /// The file of the subprogram `name` (upper case, without extension): its display name, and its bytes.
    fn load(&mut self, name: &str) -> Option<(String, Vec<u8>)>;

    /// The file of a program named with its path (`/_N_WKS_DIR/_N_PART_WPD/NAME`), if the library supports paths: its display name, and its bytes.
    fn load_path(&mut self, _path: &str, _name: &str) -> Option<(String, Vec<u8>)> {
        None
    }

    /// The first existing file of these names in any case: its display name, and its bytes.
    fn load_file(&mut self, _names: &[String]) -> Option<(String, Vec<u8>)> {
        None
    }

    /// The file that contains the program of an O number, whatever its name: its display name, and its bytes.
    fn load_number(&mut self, _number: u32) -> Option<(String, Vec<u8>)> {
        None
    }

    /// The reason why the last searched file exists but is not read; returned once.
    fn refusal(&mut self) -> Option<String> {
        None
    }

    /// Adds a folder to the search (CALLPATH); an empty name removes the added ones.
    fn add_folder(&mut self, _path: &str) {}

    /// The definition files of the control, macros first: display names and bytes.
    fn definitions(&mut self) -> Vec<(String, Vec<u8>)> {
        Vec::new()
    }
}

/// A library without programs.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoLibrary;

impl Library for NoLibrary {
    fn load(&mut self, _name: &str) -> Option<(String, Vec<u8>)> {
        None
    }
}
