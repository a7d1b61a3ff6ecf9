//! Links to controls: shipped profiles, and those of files.

use std::path::Path;

use crate::diagnostics::Diagnostics;
use crate::disk::files;
use crate::disk::hash::short_hash;
use crate::error::Error;
use crate::registry::Registry;
use ncfix_base::source::{FileId, Source};
use ncfix_dnc::feed::{Links, Profile, Protocols};

/// The link to a control: its protocol, limits and line endings, from a profile.
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
    /// A built-in link: `grbl`, `marlin`, `heidenhain-fe1` …
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// assert_eq!(ControlLink::named("heidenhain-fe1")?.name(), "heidenhain-fe1");
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// If there is no link of this name; the message lists the names.
    pub fn named(name: &str) -> Result<ControlLink, Error> {
        ControlLink::named_with(name, &Registry::default())
    }

    /// A link of a registry, whose profile may name a protocol of the registry.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let registry = Registry::default().with_link("slow", "name = \"slow\"\nprotocol = \"grbl\"\n[serial]\nbaud = 9600\n");
    /// assert_eq!(ControlLink::named_with("slow", &registry)?.name(), "slow");
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// If there is no link of this name, or its profile has errors.
    pub fn named_with(name: &str, registry: &Registry) -> Result<ControlLink, Error> {
        let mut found = Diagnostics::default();
        let link = ControlLink::of(&shipped(name, &registry.links)?, &registry.protocols, &mut found)?;
        link.ok_or_else(|| Error::found(found))
    }

    /// The link of a profile file (TOML).
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let path = std::env::temp_dir().join(format!("ncfix_link_{}.toml", std::process::id()));
    /// std::fs::write(&path, "name = \"router\"\nprotocol = \"grbl\"\n")?;
    /// let link = ControlLink::from_file(&path);
    /// std::fs::remove_file(&path)?;
    /// assert_eq!(link?.name(), "router");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If the file cannot be read or has errors.
    pub fn from_file(path: impl AsRef<Path>) -> Result<ControlLink, Error> {
        ControlLink::from_file_with(path, &Registry::default())
    }

    /// The link of a profile file (TOML), which may name a protocol of the registry.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let error = ControlLink::from_file_with("none.toml", &Registry::default()).unwrap_err();
    /// assert!(error.message().contains("none.toml"), "{error}");
    /// ```
    ///
    /// # Errors
    /// If the file cannot be read or has errors.
    pub fn from_file_with(path: impl AsRef<Path>, registry: &Registry) -> Result<ControlLink, Error> {
        let mut found = Diagnostics::default();
        let source = files::read_written(path.as_ref(), FileId(0), "profile of the link")?;
        ControlLink::of(&source, &registry.protocols, &mut found)?.ok_or_else(|| Error::found(found))
    }

    /// The name of the profile.
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// assert_eq!(ControlLink::named("grbl")?.name(), "grbl");
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn name(&self) -> &str {
        &self.profile.name
    }

    /// A shipped profile, or that of a file; `None` if there are errors in it.
    ///
    /// # Errors
    /// If it does not exist or cannot be read.
    pub(crate) fn find(link: &str, found: &mut Diagnostics) -> Result<Option<ControlLink>, Error> {
        let links = Links::default();
        let is_shipped = links.iter().any(|shipped| shipped.name.eq_ignore_ascii_case(link));
        let is_file = Path::new(link).extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"));
        let source = if !is_shipped && is_file {
            files::read_written(Path::new(link), FileId(0), files::option("profile of the link, --link"))?
        } else {
            shipped(link, &links)?
        };
        ControlLink::of(&source, &Protocols::default(), found)
    }

    fn of(source: &Source, protocols: &Protocols, found: &mut Diagnostics) -> Result<Option<ControlLink>, Error> {
        match Profile::read_with(source, protocols) {
            Ok(profile) => Ok(Some(ControlLink { profile, hash: short_hash([source.bytes()]) })),
            Err(faults) => {
                found.extend(faults, std::slice::from_ref(source));
                Ok(None)
            }
        }
    }
}

/// The text of a profile that has a name.
fn shipped(link: &str, links: &Links) -> Result<Source, Error> {
    let Some(found) = links.iter().find(|shipped| shipped.name.eq_ignore_ascii_case(link)) else {
        let names: Vec<&str> = links.names().collect();
        let names = names.join(", ");
        return Err(Error::usage(format!("unknown link '{link}'; write one of {names}, or a profile file (.toml)")));
    };
    let too_large = |_| Error::usage(format!("the profile {} is too large", found.name));
    Source::new(FileId(0), &found.name, found.text.as_bytes().to_vec()).map_err(too_large)
}
