//! Where programs come from that are not in the file of the main program.

/// Finds subprograms that are not in the file of the main program.
pub trait Library {
    /// The file of the subprogram `name` (upper case, without ending): the name to show, and its bytes.
    fn load(&mut self, name: &str) -> Option<(String, Vec<u8>)>;

    /// The file of a program that is named with its path (`/_N_WKS_DIR/_N_PART_WPD/NAME`), if the library knows paths.
    fn load_path(&mut self, _path: &str, _name: &str) -> Option<(String, Vec<u8>)> {
        None
    }

    /// The first of these files that there is, whatever the case of its name: the name to show, and its bytes.
    fn load_file(&mut self, _names: &[String]) -> Option<(String, Vec<u8>)> {
        None
    }

    /// Why the file that was looked for last is not read though there is one, in words; it is asked for once.
    fn refusal(&mut self) -> Option<String> {
        None
    }

    /// One more folder to search (CALLPATH); an empty name takes the added ones away.
    fn add_folder(&mut self, _path: &str) {}

    /// The definition files of the control, macros first: the name to show, and the bytes.
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
