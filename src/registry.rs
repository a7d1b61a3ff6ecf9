//! The registries of the library, which a program can extend: error sources, causes, instruments, table formats,
//! links, sensors.

use ncfix_dialect::{Detector, Detectors};
use ncfix_dnc::feed::{LinkFile, Links, Protocol, Protocols};
use ncfix_dnc::sense::{SensorSource, SensorSources};
use ncfix_instruments::format::{InstrumentFormat, InstrumentFormats};
use ncfix_metrology::diagnose::cause::{Causes, Propose};
use ncfix_metrology::diagnose::fault::{Checks, DefectCheck};
use ncfix_metrology::measure::kind::{Instrument, Instruments};
use ncfix_model::preset::Preset;
use ncfix_model::{ErrorSource, ModelRegisters, MotionKind};
use ncfix_tables::tables::{Format, Formats, Scheme, Schemes};

/// One registry for each kind of extension. [`Registry::default`] contains the built-in entries. Each `with_…` adds
/// a custom entry; built-in entries use the same types. `docs/how-to/extending.md` describes the
/// requirements of an entry.
///
/// ```
/// use ncfix::prelude::*;
///
/// let registry = Registry::default().with_link("my-link", "name = \"my-link\"\nprotocol = \"grbl\"\n");
/// assert!(registry.links.find("my-link").is_some());
/// assert!(Registry::default().links.find("my-link").is_none());
/// ```
///
/// # Panics
/// Every `with_…` panics if the name is empty or taken, or if a section of a source is taken: that is a mistake of the program that builds the registry.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Registry {
    /// Error sources, kinds of motion errors and presets of parameters: the entries of a machine file for errors.
    pub model: ModelRegisters,
    /// Instruments.
    pub instruments: Instruments,
    /// Formats of files of instruments.
    pub instrument_formats: InstrumentFormats,
    /// Data checks.
    pub checks: Checks,
    /// Causes that a diagnosis searches for.
    pub causes: Causes,
    /// Formats of compensation tables.
    pub formats: Formats,
    /// Schemes that fill compensation tables.
    pub schemes: Schemes,
    /// Links that have a name.
    pub links: Links,
    /// Protocols that links may name.
    pub protocols: Protocols,
    /// Dialect detectors.
    pub detectors: Detectors,
    /// Sensor sources.
    pub sensor_sources: SensorSources,
}

impl Registry {
    /// Adds an error source, with its sections of the machine file.
    ///
    /// ```
    /// use ncfix::extend::source::{ErrorModel, ErrorSource, MachineFileReading, SourceInfo};
    /// use ncfix::prelude::*;
    ///
    /// static BEAM: SourceInfo = SourceInfo { name: "beam", title: "sag of a beam", sections: &["beam"], example: "" };
    ///
    /// struct Beams;
    ///
    /// impl ErrorSource for Beams {
    ///     fn info(&self) -> &'static SourceInfo {
    ///         &BEAM
    ///     }
    ///
    ///     fn read(&self, _: &mut MachineFileReading<'_, '_>, _: &mut ErrorModel) {
    ///         // Takes its section from the file and adds an effect to the model.
    ///     }
    /// }
    ///
    /// assert!(Registry::default().with_source(Beams).model.sources.find("beam").is_some());
    /// ```
    #[must_use]
    pub fn with_source(self, source: impl ErrorSource + 'static) -> Registry {
        Registry { model: self.model.with_source(source), ..self }
    }

    /// Adds a kind of motion error: `kind = "…"` of `[[motion]]`.
    ///
    /// ```
    /// use ncfix::extend::source::{Entry, EntryFunction, MotionKind};
    /// use ncfix::prelude::*;
    ///
    /// struct Sag;
    ///
    /// impl MotionKind for Sag {
    ///     fn name(&self) -> &str {
    ///         "sag"
    ///     }
    ///
    ///     fn read(&self, _: &mut Entry<'_>) -> Option<EntryFunction> {
    ///         None
    ///     }
    ///
    ///     fn example(&self) -> &str {
    ///         "component = \"EZX\"\nkind = \"sag\"\n"
    ///     }
    /// }
    ///
    /// assert!(Registry::default().with_motion_kind(Sag).model.motion_kinds.find("sag").is_some());
    /// ```
    #[must_use]
    pub fn with_motion_kind(self, kind: impl MotionKind + 'static) -> Registry {
        Registry { model: self.model.with_motion_kind(kind), ..self }
    }

    /// Adds a preset: a set of parameters of an error model. [`CalibrationOptions::parameters`](crate::CalibrationOptions::parameters) may name it.
    ///
    /// ```
    /// use ncfix::extend::preset::Preset;
    /// use ncfix::prelude::*;
    ///
    /// static SQUARENESS: Preset = Preset {
    ///     name: "squareness",
    ///     title: "squareness of three linear axes",
    ///     source: "ISO 230-1:2012, 3.6",
    ///     parameters: |_| Ok(["EC0X", "EB0Z", "EA0Z"].iter().filter_map(|name| name.parse().ok()).collect()),
    /// };
    ///
    /// let registry = Registry::default().with_preset(&SQUARENESS);
    /// assert!(registry.model.presets.find("squareness").is_some());
    /// ```
    #[must_use]
    pub fn with_preset(self, preset: &'static Preset) -> Registry {
        Registry { model: self.model.with_preset(preset), ..self }
    }

    /// Adds an instrument. The built-in `probe` is an example.
    ///
    /// ```
    /// use ncfix::extend::instrument::Instrument;
    /// use ncfix::prelude::*;
    ///
    /// let built_in = Registry::default();
    /// let own: &'static Instrument = Box::leak(Box::new(Instrument { name: "spindle-probe", ..**built_in.instruments.find("probe").unwrap() }));
    /// assert!(built_in.with_instrument(own).instruments.find("spindle-probe").is_some());
    /// ```
    #[must_use]
    pub fn with_instrument(self, kind: &'static Instrument) -> Registry {
        Registry { instruments: self.instruments.with(kind), ..self }
    }

    /// Adds a format of the files of an instrument, which `ncfix_instruments::import` reads with this registry. The format with the highest certainty is used.
    /// The command `ncfix import` uses only the built-in formats.
    ///
    /// ```
    /// use ncfix::extend::import::InstrumentFormat;
    /// use ncfix::prelude::*;
    ///
    /// let built_in = Registry::default();
    /// let own: &'static InstrumentFormat = Box::leak(Box::new(InstrumentFormat { name: "my-laser", ..**built_in.instrument_formats.find("targets").unwrap() }));
    /// assert!(built_in.with_instrument_format(own).instrument_formats.find("my-laser").is_some());
    /// ```
    #[must_use]
    pub fn with_instrument_format(self, format: &'static InstrumentFormat) -> Registry {
        Registry { instrument_formats: self.instrument_formats.with(format), ..self }
    }

    /// Adds a data check. It runs after the existing checks.
    ///
    /// ```
    /// use ncfix::extend::instrument::DefectCheck;
    /// use ncfix::prelude::*;
    ///
    /// let built_in = Registry::default();
    /// let one: &DefectCheck = built_in.checks.iter().next().unwrap();
    /// let own: &'static DefectCheck = Box::leak(Box::new(DefectCheck { name: "swapped columns", ..*one }));
    /// assert!(built_in.with_check(own).checks.find("swapped columns").is_some());
    /// ```
    #[must_use]
    pub fn with_check(self, check: &'static DefectCheck) -> Registry {
        Registry { checks: self.checks.with(check), ..self }
    }

    /// Adds a cause: a static `Cause`, or a value that proposes candidates.
    ///
    /// ```
    /// use ncfix::extend::cause::{Cause, Correctable, EffectKind};
    /// use ncfix::prelude::*;
    ///
    /// static GROWTH: Cause = Cause {
    ///     name: "spindle growth with speed",
    ///     effect: EffectKind::Own("spindle-growth"),
    ///     made_by: "centrifugal force in the bearings",
    ///     shown_by: "readings that follow the square of the speed",
    ///     separate_by: "the same speeds in another order",
    ///     correctable: Correctable::No,
    ///     propose: |_scene, _candidates| {},
    /// };
    ///
    /// assert!(Registry::default().with_cause(&GROWTH).causes.find("spindle growth with speed").is_some());
    /// ```
    #[must_use]
    pub fn with_cause(self, cause: impl Propose + 'static) -> Registry {
        Registry { causes: self.causes.with(cause), ..self }
    }

    /// Adds a format of compensation tables.
    ///
    /// ```
    /// use ncfix::extend::table::Format;
    /// use ncfix::prelude::*;
    ///
    /// let built_in = Registry::default();
    /// let own: &'static Format = Box::leak(Box::new(Format { name: "my-control", ..**built_in.formats.find("cec").unwrap() }));
    /// assert!(built_in.with_format(own).formats.find("my-control").is_some());
    /// ```
    #[must_use]
    pub fn with_format(self, format: &'static Format) -> Registry {
        Registry { formats: self.formats.with(format), ..self }
    }

    /// Adds a scheme that fills compensation tables.
    ///
    /// ```
    /// use ncfix::extend::table::Scheme;
    /// use ncfix::prelude::*;
    ///
    /// let built_in = Registry::default();
    /// let own: &'static Scheme = Box::leak(Box::new(Scheme { name: "mine", ..**built_in.schemes.find("fik").unwrap() }));
    /// assert!(built_in.with_scheme(own).schemes.find("mine").is_some());
    /// ```
    #[must_use]
    pub fn with_scheme(self, scheme: &'static Scheme) -> Registry {
        Registry { schemes: self.schemes.with(scheme), ..self }
    }

    /// Adds a dialect detector. The file extension decides before the lines of the file; of several detectors that match, the one added first decides.
    /// [`Program::parse_with`](crate::Program::parse_with) and [`Program::from_file_with`](crate::Program::from_file_with) use it;
    /// `examples/own_detector.rs` is a complete program.
    ///
    /// ```
    /// use ncfix::extend::dialect::{Detector, find};
    /// use ncfix::prelude::*;
    ///
    /// let own = Detector::new("post of our CAM", find("fanuc").unwrap(), &["tap"], r"^\(OUR POST \d+\)$")?;
    /// assert!(Registry::default().with_detector(own).detectors.find("post of our CAM").is_some());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn with_detector(self, detector: Detector) -> Registry {
        Registry { detectors: self.detectors.with(detector), ..self }
    }

    /// Adds a link: its name and the text of its profile (TOML). [`ControlLink::named_with`](crate::ControlLink::named_with) opens it.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let registry = Registry::default().with_link("shop-grbl", "name = \"shop-grbl\"\nprotocol = \"grbl\"\n");
    /// assert_eq!(ControlLink::named_with("shop-grbl", &registry)?.name(), "shop-grbl");
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn with_link(self, name: impl Into<String>, profile: impl Into<String>) -> Registry {
        let link = LinkFile { name: name.into().into(), text: profile.into().into() };
        Registry { links: self.links.with(link), ..self }
    }

    /// Adds a protocol that profiles may name: `protocol = "…"`.
    ///
    /// ```
    /// use ncfix::extend::link::Protocol;
    /// use ncfix::prelude::*;
    ///
    /// let built_in = Registry::default();
    /// let own: &'static Protocol = Box::leak(Box::new(Protocol { name: "my-dialogue", ..**built_in.protocols.find("grbl").unwrap() }));
    /// let profile = "name = \"mine\"\nprotocol = \"my-dialogue\"\n";
    /// let registry = built_in.with_protocol(own).with_link("mine", profile);
    /// assert!(ControlLink::named_with("mine", &registry).is_ok());
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn with_protocol(self, protocol: &'static Protocol) -> Registry {
        Registry { protocols: self.protocols.with(protocol), ..self }
    }

    /// Adds a sensor source: `kind = "…"` of a sensor file. [`sensors::from_text`](crate::sensors::from_text) takes `registry.sensor_sources`;
    /// `examples/feed_with_own_sensor.rs` is a complete program.
    ///
    /// ```
    /// use ncfix::extend::sensor::{Section, SensorSource, SourcePlan, Wanted};
    /// use ncfix::prelude::*;
    ///
    /// struct Thermometer;
    ///
    /// impl SensorSource for Thermometer {
    ///     fn name(&self) -> &str {
    ///         "thermometer"
    ///     }
    ///
    ///     fn title(&self) -> &str {
    ///         "thermometer of the spindle head"
    ///     }
    ///
    ///     fn read(&self, _: &mut Section<'_>, _: &mut [Wanted<'_>]) -> Option<std::sync::Arc<dyn SourcePlan>> {
    ///         None
    ///     }
    /// }
    ///
    /// assert!(Registry::default().with_sensor_source(Thermometer).sensor_sources.find("thermometer").is_some());
    /// ```
    #[must_use]
    pub fn with_sensor_source(self, source: impl SensorSource + 'static) -> Registry {
        Registry { sensor_sources: self.sensor_sources.with(source), ..self }
    }
}
