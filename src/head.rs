//! Heads of a machine: the machine with one of them alone, and the models and results with several.

use std::borrow::Cow;

use crate::datum;
use crate::diagnostics::Diagnostics;
use crate::error::Error;
use crate::machine::Machine;
use ncfix_machine::machine::Condition;
use ncfix_machine::machine::file::nearest;
use ncfix_machine::snc::extent::PathExtent;
use ncfix_model::Model;
use ncfix_path::path::{self, PoseSample, Remaining};
use ncfix_report::json::ZeroReport;

impl Machine {
    /// The machine with one of its heads alone: its spindle and errors, as if the file had no other. A program that selects another head is refused.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let text = "[machine]\nname = \"m\"\ntopology = \"wFXZt\"\n[axis.X]\ndirection = [1, 0, 0]\n[axis.Z]\ndirection = [0, 0, 1]\n\
    ///     [[head]]\nname = \"a\"\nselect = [\"M53\"]\nstart = true\n\
    ///     [[head]]\nname = \"b\"\nselect = [\"M54\"]\n[head.location]\nEX0S = 7.0\n";
    /// let machine = Machine::from_text("m.toml", text)?.with_head("b")?;
    /// let error = machine.deviation(&"X0,Z0".parse()?, ToolVector::Length(0.0), &State::default());
    /// assert!((error.position_um[0] - 7.0).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If the machine has no head of this name.
    pub fn with_head(&self, name: &str) -> Result<Machine, Error> {
        Ok(self.with_head_alone(self.head_index(name)?))
    }

    /// Names of the heads, the one that is active at the start of a program first; empty without heads.
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// assert_eq!(Machine::demo().heads().count(), 0);
    /// ```
    pub fn heads(&self) -> impl Iterator<Item = &str> {
        self.machine.heads.iter().map(|head| head.name.as_str())
    }

    /// Numbers of the heads, in the order of the machine file from 0, with their names; empty without heads.
    pub(crate) fn numbered_heads(&self) -> Vec<(u64, String)> {
        let entries = self.errors.heads.iter().map(|own| own.head_entries.map(|entries| entries.index as u64));
        let names = self.machine.heads.iter().map(|head| head.name.clone());
        entries.zip(names).filter_map(|(number, name)| Some((number?, name))).collect()
    }

    /// The machine with another head at the start of a program.
    ///
    /// # Errors
    /// If it has no head of this name.
    pub(crate) fn starting_with(mut self, name: &str) -> Result<Machine, Error> {
        let index = self.head_index(name)?;
        self.machine.start_with_head(index);
        self.errors.start_with_head(index);
        Ok(self)
    }

    /// The machine with one head: the named one, or the only one.
    ///
    /// # Errors
    /// If there are several and none is named.
    pub(crate) fn with_one_head(self, named: Option<&str>) -> Result<Machine, Error> {
        if let Some(name) = named {
            return self.with_head(name);
        }
        self.check_one_head()?;
        Ok(self)
    }

    /// The machine with the named head alone, if one is named; a pose needs one head.
    ///
    /// # Errors
    /// If there are several and none is named.
    pub(crate) fn with_shown_head(self, named: Option<&str>, is_at_pose: bool) -> Result<Machine, Error> {
        if named.is_none() && !is_at_pose { Ok(self) } else { self.with_one_head(named) }
    }

    /// Refuses a machine with several heads.
    ///
    /// # Errors
    /// If there are several.
    pub(crate) fn check_one_head(&self) -> Result<(), Error> {
        if !self.machine.changes_heads() {
            return Ok(());
        }
        let names = self.names();
        Err(Error::usage(format!(
            "the machine {} has several heads, and this is for one of them: choose it with --head {names}",
            self.machine.name
        )))
    }

    fn names(&self) -> String {
        self.heads().collect::<Vec<_>>().join(" or ")
    }

    fn head_index(&self, name: &str) -> Result<usize, Error> {
        self.machine.head_named(name).ok_or_else(|| {
            let help = match nearest(name, self.heads()) {
                Some(near) => format!("; did you mean {near}?"),
                None if self.machine.heads.is_empty() => "; it has no [[head]] at all".to_owned(),
                None => format!("; it has {}", self.names()),
            };
            Error::usage(format!("--head {name}: the machine {} has no such head{help}", self.machine.name))
        })
    }

    fn with_head_alone(&self, index: usize) -> Machine {
        let mut out = self.clone();
        out.machine.start_with_head(index);
        out.machine.has_fixed_head = true;
        if let Ok(head) = u16::try_from(index) {
            out.errors = self.errors.of_head(head);
        }
        out
    }

    /// The error model in the condition of the machine, with all heads.
    pub(crate) fn model(&self) -> Model {
        self.with_all_heads(|machine| datum::with_zeros(machine, machine.model_at(&machine.condition)))
    }

    /// The error model in a condition, without zero offsets and with the first head.
    pub(crate) fn model_at(&self, condition: &Condition) -> Model {
        Model::at(&self.machine, &self.errors, condition)
    }

    /// The error model in a condition with all heads, and the zero offsets of `base`, which has all heads too.
    pub(crate) fn model_now(&self, condition: &Condition, base: &Model) -> Model {
        let of = |machine: &Machine, head: u16| machine.model_at(condition).with_zeros_of(base.for_head(head));
        let first = of(self, 0);
        if !self.machine.changes_heads() {
            return first;
        }
        let others = (1..self.machine.heads.len()).filter_map(|index| u16::try_from(index).ok());
        let others = others.map(|head| of(&self.with_head_alone(usize::from(head)), head));
        first.with_heads(others.collect())
    }

    /// Makes a model for each head.
    fn with_all_heads(&self, of: impl Fn(&Machine) -> Model) -> Model {
        let first = of(self);
        if !self.machine.changes_heads() {
            return first;
        }
        let others = (1..self.machine.heads.len()).map(|index| of(&self.with_head_alone(index)));
        first.with_heads(others.collect())
    }
}

/// A head with which a program moves: the machine with this head alone, and its model.
pub(crate) struct HeadInUse<'m> {
    pub(crate) chosen: Cow<'m, Machine>,
    pub(crate) model: &'m Model,
    /// Its index.
    pub(crate) head: u16,
}

/// The zero offsets with each of these heads, and warnings about those without a stated method.
pub(crate) fn zeros(
    heads: &[HeadInUse<'_>],
    extent: &PathExtent,
    tolerance_mm: f64,
    found: &mut Diagnostics,
) -> Vec<ZeroReport> {
    let mut all = Vec::new();
    if let Some(first) = heads.first() {
        datum::without_use(&first.chosen, extent.zeros(), found);
    }
    for one in heads {
        let used = extent.zeros_with(one.head);
        let mut own = datum::of_run(&one.chosen, one.model, &used, extent.tools_mm(), tolerance_mm, found);
        if let Some(head) = one.chosen.machine.heads.first().filter(|_| heads.len() > 1) {
            own.iter_mut().for_each(|zero| zero.name += &format!(" ({})", head.name));
        }
        all.append(&mut own);
    }
    all
}

/// The residual of each error source, the largest of these heads.
pub(crate) fn remaining(heads: &[HeadInUse<'_>], poses: &[PoseSample]) -> Vec<Remaining> {
    let mut all: Vec<Remaining> = Vec::new();
    for one in heads {
        let Machine { machine, errors, condition, .. } = &*one.chosen;
        let own: Vec<PoseSample> = poses.iter().filter(|pose| pose.head == one.head).copied().collect();
        for left in path::remaining(machine, errors, condition, &own) {
            match all.iter_mut().find(|known| known.source == left.source) {
                Some(known) => {
                    known.position_mm = known.position_mm.max(left.position_mm);
                    known.tilt_rad = known.tilt_rad.max(left.tilt_rad);
                    known.roll_rad = known.roll_rad.max(left.roll_rad);
                }
                None => all.push(left),
            }
        }
    }
    all
}

/// The heads with which a program moves. A machine without heads has one; so has a program without motion.
pub(crate) fn in_use<'m>(chosen: &'m Machine, model: &'m Model, extent: &PathExtent) -> Vec<HeadInUse<'m>> {
    if !chosen.machine.changes_heads() {
        return vec![HeadInUse { chosen: Cow::Borrowed(chosen), model, head: 0 }];
    }
    let of = |&head: &u16| HeadInUse {
        chosen: Cow::Owned(chosen.with_head_alone(usize::from(head))),
        model: model.for_head(head),
        head,
    };
    let heads: Vec<HeadInUse<'_>> = extent.heads().iter().map(of).collect();
    if heads.is_empty() { vec![of(&0)] } else { heads }
}
