//! Notes on data of a control.

use std::fmt;

/// Note on data of a control that the machine file does not carry, or that the data lack.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DataNote {
    /// Its kind.
    pub kind: DataNoteKind,
    /// A sentence with the file and, if the note has one, the line.
    pub text: String,
}

/// Kind of a note.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DataNoteKind {
    /// Data were not used, because the data do not name their axes. Values that are missing may be there.
    Unused,
    /// Programs begin with a word that ncfix does not assume and a machine file cannot state (Sinumerik MD20150).
    UnknownStart,
    /// Information for people.
    Other,
}

impl fmt::Display for DataNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}
