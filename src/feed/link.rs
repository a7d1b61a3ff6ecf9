//! Links to controls: shipped profiles, and those of files.

use std::path::Path;

use crate::diagnostics::Diagnostics;
use crate::disk::files;
use crate::disk::hash::short_hash;
use crate::error::Error;
use ncfix_base::source::{FileId, Source};
use ncfix_dnc::feed::{Links, Profile};

/// How a control is spoken to.
///
/// ```
/// use ncfix::prelude::*;
///
/// assert_eq!(ControlLink::named("grbl")?.name(), "grbl");
/// assert!(ControlLink::named("tin-can").is_err());
/// # Ok::<(), ncfix::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct ControlLink {
    pub(crate) profile: Profile,
    /// Hash of its text.
    pub(crate) hash: String,
}

impl ControlLink {
    /// A link whose profile is shipped: `grbl`, `marlin`, `heidenhain-fe1` …
    ///
    /// # Errors
    /// Where there is none of the name.
    pub fn named(name: &str) -> Result<ControlLink, Error> {
        ControlLink::of(&shipped(name)?, &mut Diagnostics::default())?
            .ok_or_else(|| Error::usage(format!("the profile {name} is not whole")))
    }

    /// The link of a profile file (TOML).
    ///
    /// ```no_run
    /// # use ncfix::prelude::*;
    /// let link = ControlLink::from_file("mill.toml")?;
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// Where the file cannot be read, or diagnostics forbid to use it.
    pub fn from_file(path: impl AsRef<Path>) -> Result<ControlLink, Error> {
        let mut found = Diagnostics::default();
        let source = files::read_written(path.as_ref(), FileId(0), "profile of the link")?;
        ControlLink::of(&source, &mut found)?.ok_or_else(|| Error::found(found))
    }

    /// The name of the profile.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.profile.name
    }

    /// A profile that is shipped, or that of a file; `None` where findings forbid to use it.
    ///
    /// # Errors
    /// Where there is none, or it cannot be read.
    pub(crate) fn find(link: &str, found: &mut Diagnostics) -> Result<Option<ControlLink>, Error> {
        let is_shipped = Links::default().iter().any(|shipped| shipped.name.eq_ignore_ascii_case(link));
        let is_file = Path::new(link).extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"));
        let source = if !is_shipped && is_file {
            files::read_written(Path::new(link), FileId(0), "profile of the link, --link")?
        } else {
            shipped(link)?
        };
        ControlLink::of(&source, found)
    }

    fn of(source: &Source, found: &mut Diagnostics) -> Result<Option<ControlLink>, Error> {
        match Profile::read(source) {
            Ok(profile) => Ok(Some(ControlLink { profile, hash: short_hash([source.bytes()]) })),
            Err(faults) => {
                found.extend(faults, std::slice::from_ref(source));
                Ok(None)
            }
        }
    }
}

/// The text of a profile that is shipped.
fn shipped(link: &str) -> Result<Source, Error> {
    let links = Links::default();
    let Some(found) = links.iter().find(|shipped| shipped.name.eq_ignore_ascii_case(link)) else {
        let names: Vec<&str> = links.names().collect();
        let names = names.join(", ");
        return Err(Error::usage(format!(
            "there is no link '{link}'; write one of {names}, or a profile file (.toml)"
        )));
    };
    let too_large = |_| Error::usage(format!("the profile {} is too large", found.name));
    Source::new(FileId(0), &found.name, found.text.as_bytes().to_vec()).map_err(too_large)
}
