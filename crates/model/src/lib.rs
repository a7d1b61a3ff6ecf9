//! Error model of a machine: forward kinematics with errors, and the commands that cancel them.
//!
//! [`ErrorModel`] is the error part of a machine file: location errors ([`location`]), motion errors ([`motion`], one file per kind of function), named as
//! in ISO 230-1 ([`name`]), and the effects of other sources ([`source`], one file each). The [`Accumulator`] adds up their contributions in one condition of
//! the machine. [`Model`] is the machine with this sum, prepared for evaluation; [`Model::actual`] is the only forward function, and [`Model::solve`] inverts it.
//! [`Model::on_intervals`] and [`Model::solve_in_cycle`] are their counterparts for the cycle of a control. [`preset`] lists the parameters ([`parameter`])
//! of a model. [`coverage`] compares positions and conditions with the measured ranges, and [`uncertainty`] varies a model
//! within its uncertainty. This crate does not contain programs or instruments.

mod accumulator;
mod body;
pub mod coverage;
mod cyclic;
mod dead_band;
mod features;
pub mod file;
mod forward;
mod inverse;
mod linear;
mod link;
pub mod location;
pub mod motion;
pub mod name;
mod orientation;
pub mod parameter;
mod plausible;
pub mod preset;
mod rotation;
pub mod shares;
pub mod source;
pub mod uncertainty;
pub mod volume_shares;
pub mod write;

pub use accumulator::Accumulator;
pub use body::Pose;
pub use dead_band::{DeadBand, Off, Room};
pub use features::Features;
pub use forward::{Model, Twist};
pub use inverse::{NotConverged, Solve};
pub use location::LocationError;
pub use motion::{MotionError, MotionFunction, MotionKind, MotionKinds};
pub use name::ErrorName;
pub use parameter::ParameterName;
pub use preset::{Preset, Presets};
pub use source::{Effect, ErrorSource, SourceInfo, Sources};

/// Error-related content that a machine file may have: registries that a caller can extend.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct ModelRegisters {
    /// Error sources, which read sections of the file.
    pub sources: Sources,
    /// Kinds of functions in `[[motion]]` and `[[load]]`.
    pub motion_kinds: MotionKinds,
    /// Presets of parameters.
    pub presets: Presets,
}

impl ModelRegisters {
    /// Adds an error source.
    ///
    /// # Panics
    /// If its name or one of its sections belongs to another source.
    #[must_use]
    pub fn with_source(self, source: impl ErrorSource + 'static) -> ModelRegisters {
        ModelRegisters { sources: self.sources.with(source), ..self }
    }

    /// Adds a kind of motion error.
    ///
    /// # Panics
    /// If its name is taken.
    #[must_use]
    pub fn with_motion_kind(self, kind: impl MotionKind + 'static) -> ModelRegisters {
        ModelRegisters { motion_kinds: self.motion_kinds.with(kind), ..self }
    }

    /// Adds a preset of parameters.
    ///
    /// # Panics
    /// If its name is taken.
    #[must_use]
    pub fn with_preset(self, preset: &'static Preset) -> ModelRegisters {
        ModelRegisters { presets: self.presets.with(preset), ..self }
    }
}

/// Errors of a machine as given by its file, in mm and rad.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ErrorModel {
    /// Position-independent errors.
    pub location: Vec<LocationError>,
    /// Position-dependent errors; entries of one component add up.
    pub motion: Vec<MotionError>,
    /// Effects of other sources: workpiece weight, temperature, …
    pub effects: Vec<Box<dyn Effect>>,
    /// All errors with each head, in the order of the heads of the machine; empty if it has none. The errors of this model are those of the first.
    pub heads: Vec<ErrorModel>,
    /// Where the file has the errors of the head alone, which come after the common ones; `None` if the machine has no heads.
    pub head_entries: Option<HeadEntries>,
}

/// Place of the errors of a head in the machine file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HeadEntries {
    /// Index of the `[[head]]` in the file.
    pub index: usize,
    /// Number of common location errors, motion errors and effects.
    pub common: [usize; 3],
}

impl ErrorModel {
    /// Returns all contributions as effects of their sources.
    pub fn effects(&self) -> impl Iterator<Item = &dyn Effect> {
        let location = self.location.iter().map(|error| error as &dyn Effect);
        let motion = self.motion.iter().map(|error| error as &dyn Effect);
        location.chain(motion).chain(self.effects.iter().map(|effect| &**effect))
    }

    /// Returns the errors with a head by its index, as those of a machine with this spindle alone.
    #[must_use]
    pub fn of_head(&self, head: u16) -> ErrorModel {
        match self.heads.get(usize::from(head)) {
            Some(of_head) => of_head.clone(),
            None => ErrorModel { heads: Vec::new(), ..self.clone() },
        }
    }

    /// Makes a head the one that is active at the start. An index without a head changes nothing.
    pub fn start_with_head(&mut self, index: usize) {
        if let Some(head) = self.heads.get(index).cloned() {
            let mut heads = std::mem::take(&mut self.heads);
            heads[..=index].rotate_right(1);
            *self = ErrorModel { heads, ..head };
        }
    }

    /// Returns all contributions, including those of every head. Common ones occur more than once.
    pub fn effects_with_heads(&self) -> impl Iterator<Item = &dyn Effect> {
        self.effects().chain(self.heads.iter().flat_map(ErrorModel::effects))
    }

    /// Returns all contributions for modification.
    pub fn effects_mut(&mut self) -> impl Iterator<Item = &mut dyn Effect> {
        let location = self.location.iter_mut().map(|error| error as &mut dyn Effect);
        let motion = self.motion.iter_mut().map(|error| error as &mut dyn Effect);
        location.chain(motion).chain(self.effects.iter_mut().map(|effect| &mut **effect as &mut dyn Effect))
    }

    /// Returns the sources of its effects, each once: first the built-in ones in the order of [`Sources`], then others in order of occurrence.
    #[must_use]
    pub fn sources(&self) -> Vec<&'static SourceInfo> {
        let mut sources: Vec<&'static SourceInfo> = Vec::new();
        for source in self.effects().map(Effect::source) {
            if !sources.iter().any(|known| known.name == source.name) {
                sources.push(source);
            }
        }
        sources.sort_by_key(|source| source::rank(source));
        sources
    }

    /// Returns the effects of a source, by its name.
    pub fn effects_of(&self, source: &str) -> impl Iterator<Item = &dyn Effect> {
        self.effects().filter(move |effect| effect.source().name == source)
    }

    /// Returns the sensors that the model needs, with every head, sorted, each once.
    #[must_use]
    pub fn sensors(&self) -> Vec<&str> {
        let of_heads = self.heads.iter().flat_map(ErrorModel::sensors);
        let mut sensors: Vec<&str> = self.effects().flat_map(Effect::sensors).chain(of_heads).collect();
        sensors.sort_unstable();
        sensors.dedup();
        sensors
    }
}
