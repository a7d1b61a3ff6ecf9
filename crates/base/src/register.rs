//! Registries: the known entries of one kind (error sources, causes, formats …) by name, which a caller can extend.
//!
//! A registry is a value: no registry is global, and each function that needs one gets it as an argument. Built-in entries are added by the same
//! [`Register::with`] as those of a caller.

use std::fmt;
use std::sync::Arc;

/// Entry type of a registry: implemented for the trait object or the type of an entry.
pub trait Registered {
    /// Name of an entry in messages: `error source`.
    const KIND: &'static str;

    /// Returns the name by which it is found; no other entry has it.
    fn name(&self) -> &str;

    /// Returns the built-in entries, in the order in which tables show them.
    fn built_in() -> Vec<Box<Self>>;

    /// Returns why two entries cannot both be in one registry, other than by their names: a sentence without a full stop.
    fn conflict(&self, _other: &Self) -> Option<String> {
        None
    }
}

/// Entries of one kind, in the order in which they were added. [`Register::default`] contains the built-in ones.
pub struct Register<T: ?Sized>(Vec<Arc<T>>);

/// Reason why an entry conflicts with an existing one: a sentence without a full stop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused(pub String);

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Refused {}

impl<T: ?Sized + Registered> Register<T> {
    /// Returns a registry without entries.
    #[must_use]
    pub fn empty() -> Register<T> {
        Register(Vec::new())
    }

    /// Adds an entry.
    ///
    /// # Panics
    /// If [`Self::try_with`] refuses it: two entries with the same name are a bug of the program that builds the registry.
    #[must_use]
    pub fn with(self, entry: impl Into<Box<T>>) -> Register<T> {
        match self.try_with(entry) {
            Ok(register) => register,
            Err(refused) => panic!("{refused}"),
        }
    }

    /// As [`Self::with`], but returns an error instead of a panic.
    ///
    /// # Errors
    /// [`Refused`] if its name is empty, or an existing entry has its name or another property that must be unique.
    pub fn try_with(mut self, entry: impl Into<Box<T>>) -> Result<Register<T>, Refused> {
        let entry = entry.into();
        if entry.name().is_empty() {
            return Err(Refused(format!("the name of the {} is empty", T::KIND)));
        }
        if self.find(entry.name()).is_some() {
            return Err(Refused(format!("the {} \"{}\" already exists", T::KIND, entry.name())));
        }
        if let Some(why) = self.iter().find_map(|known| known.conflict(&entry)) {
            return Err(Refused(format!("{} \"{}\": {why}", T::KIND, entry.name())));
        }
        self.0.push(Arc::from(entry));
        Ok(self)
    }

    /// Returns all entries, in the order in which they were added.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = &T> + ExactSizeIterator {
        self.0.iter().map(|entry| &**entry)
    }

    /// Returns the entry with this name.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<&T> {
        self.iter().find(|entry| entry.name() == name)
    }

    /// Returns shared ownership of the entry with this name.
    #[must_use]
    pub fn shared(&self, name: &str) -> Option<Arc<T>> {
        self.0.iter().find(|entry| entry.name() == name).cloned()
    }

    /// Returns the names of all entries, in their order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.iter().map(Registered::name)
    }
}

impl<T: ?Sized + Registered> Default for Register<T> {
    fn default() -> Self {
        T::built_in().into_iter().fold(Register::empty(), |register, entry| register.with(entry))
    }
}

impl<T: ?Sized> Clone for Register<T> {
    fn clone(&self) -> Self {
        Register(self.0.clone())
    }
}

impl<T: ?Sized + Registered> fmt::Debug for Register<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.names()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    trait Tool {
        fn call(&self) -> &str;
    }

    struct Named(&'static str);

    impl Tool for Named {
        fn call(&self) -> &str {
            self.0
        }
    }

    impl From<Named> for Box<dyn Tool> {
        fn from(named: Named) -> Self {
            Box::new(named)
        }
    }

    impl Registered for dyn Tool {
        const KIND: &'static str = "tool";

        fn name(&self) -> &str {
            self.call()
        }

        fn built_in() -> Vec<Box<Self>> {
            vec![Box::new(Named("saw")), Box::new(Named("file"))]
        }

        fn conflict(&self, other: &Self) -> Option<String> {
            (self.call() == "saw" && other.call() == "axe").then(|| "a saw is there".into())
        }
    }

    #[test]
    fn entries_of_a_caller_stand_behind_those_that_are_built_in() {
        let register = Register::<dyn Tool>::default().with(Named("plane"));
        assert_eq!(register.names().collect::<Vec<_>>(), ["saw", "file", "plane"]);
        assert_eq!(register.find("plane").map(Tool::call), Some("plane"));
        assert_eq!(format!("{register:?}"), "[\"saw\", \"file\", \"plane\"]");
        assert!(Register::<dyn Tool>::default().find("plane").is_none());
    }

    #[test]
    fn a_second_of_the_same_name_is_refused() {
        let add = |name| Register::<dyn Tool>::default().try_with(Named(name)).err().map(|refused| refused.0);
        assert_eq!(add("saw").as_deref(), Some("the tool \"saw\" already exists"));
        assert_eq!(add("axe").as_deref(), Some("tool \"axe\": a saw is there"));
        assert_eq!(add("").as_deref(), Some("the name of the tool is empty"));
        assert_eq!(add("plane"), None);
    }
}
