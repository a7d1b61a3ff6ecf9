//! What ncfix knows of each kind of thing, and that a program extends: sources of error, causes, instruments, formats, links, sensors.

use ncfix_dialect::{Detector, Detectors};
use ncfix_dnc::feed::{LinkFile, Links, Protocol, Protocols};
use ncfix_dnc::sense::{SensorSource, SensorSources};
use ncfix_metrology::diagnose::cause::{Causes, Propose};
use ncfix_metrology::diagnose::fault::{Check, Checks};
use ncfix_metrology::measure::kind::{Instruments, Kind};
use ncfix_model::{ErrorSource, ModelRegisters, MotionKind};
use ncfix_tables::tables::{Format, Formats, Scheme, Schemes};

/// What ncfix knows of each kind of thing. [`Registry::default`] is what is built in; `with_…` add what another crate brings, each by the same way
/// as what is built in. `docs/how-to/extending.md` says what each must do.
///
/// ```
/// use ncfix::prelude::*;
///
/// let registry = Registry::default().with_link("my-link", "name = \"my-link\"\nprotocol = \"tape\"\n");
/// assert!(registry.links.find("my-link").is_some());
/// assert!(Registry::default().links.find("my-link").is_none());
/// ```
///
/// # Panics
/// Every `with_…` panics where there is one of its name: that is a slip of the program that builds the registry.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Registry {
    /// Sources of error, kinds of motion errors, presets of parameters: what a machine file may say of errors.
    pub model: ModelRegisters,
    /// Kinds of measurement.
    pub instruments: Instruments,
    /// Kinds of faults of the data.
    pub checks: Checks,
    /// Causes that a diagnosis looks for.
    pub causes: Causes,
    /// Formats of compensation tables.
    pub formats: Formats,
    /// Schemes that fill compensation tables.
    pub schemes: Schemes,
    /// Links that have a name.
    pub links: Links,
    /// Dialogues that links may name.
    pub protocols: Protocols,
    /// What gives the dialect of a file away.
    pub detectors: Detectors,
    /// Kinds of sources of live readings.
    pub sensor_sources: SensorSources,
}

impl Registry {
    /// With a source of error more.
    #[must_use]
    pub fn with_source(self, source: impl ErrorSource + 'static) -> Registry {
        Registry { model: self.model.with_source(source), ..self }
    }

    /// With a kind of motion errors more.
    #[must_use]
    pub fn with_motion_kind(self, kind: impl MotionKind + 'static) -> Registry {
        Registry { model: self.model.with_motion_kind(kind), ..self }
    }

    /// With a kind of measurement more.
    #[must_use]
    pub fn with_instrument(self, kind: &'static Kind) -> Registry {
        Registry { instruments: self.instruments.with(kind), ..self }
    }

    /// With a kind of faults of the data more, which is looked for last.
    #[must_use]
    pub fn with_check(self, check: &'static Check) -> Registry {
        Registry { checks: self.checks.with(check), ..self }
    }

    /// With a cause more: a static `Cause`, or what proposes one.
    #[must_use]
    pub fn with_cause(self, cause: impl Propose + 'static) -> Registry {
        Registry { causes: self.causes.with(cause), ..self }
    }

    /// With a format of tables more.
    #[must_use]
    pub fn with_format(self, format: &'static Format) -> Registry {
        Registry { formats: self.formats.with(format), ..self }
    }

    /// With a scheme of tables more.
    #[must_use]
    pub fn with_scheme(self, scheme: &'static Scheme) -> Registry {
        Registry { schemes: self.schemes.with(scheme), ..self }
    }

    /// With a detector of a dialect more, which is asked last.
    #[must_use]
    pub fn with_detector(self, detector: Detector) -> Registry {
        Registry { detectors: self.detectors.with(detector), ..self }
    }

    /// With a link more: its name and the text of its profile.
    #[must_use]
    pub fn with_link(self, name: impl Into<String>, profile: impl Into<String>) -> Registry {
        let link = LinkFile { name: name.into().into(), text: profile.into().into() };
        Registry { links: self.links.with(link), ..self }
    }

    /// With a dialogue more.
    #[must_use]
    pub fn with_protocol(self, protocol: &'static Protocol) -> Registry {
        Registry { protocols: self.protocols.with(protocol), ..self }
    }

    /// With a kind of sources of live readings more.
    #[must_use]
    pub fn with_sensor_source(self, source: impl SensorSource + 'static) -> Registry {
        Registry { sensor_sources: self.sensor_sources.with(source), ..self }
    }
}
