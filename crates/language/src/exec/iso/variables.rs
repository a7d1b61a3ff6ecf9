//! Variables of the macro languages: numbered and named, local and common.
//!
//! A value is an `Option`: Fanuc has null, the value of an unassigned variable. In RS274/NGC every numbered parameter has a value.

use std::collections::HashMap;

use super::data_origin::DataOrigin;
use crate::exec::core::assumed_values::AssumedValues;
use crate::exec::core::fixed_values::FixedValues;
use crate::syntax::words::{NameId, Program};
use ncfix_base::geometry::AxisVector;
use ncfix_dialect::Language;
use ncfix_machine::machine::{Machine, Setting};

/// Highest number of a local variable of Fanuc.
const FANUC_LOCALS: usize = 33;
/// Highest number of a local parameter of RS274/NGC.
const RS274_LOCALS: usize = 30;
/// Numbers of RS274/NGC end before this one.
pub(super) const RS274_END: u32 = 5602;
/// Numbers of Fanuc's common variables.
const FANUC_COMMON: std::ops::RangeInclusive<u32> = 100..=999;
/// From this number on, Fanuc variables contain the state of the control.
pub(super) const FANUC_SYSTEM: u32 = 1000;
/// User parameters of RS274/NGC: a control with a parameter file keeps them between programs, also those of the outermost level. The others above
/// contain the state of the control.
const RS274_USER_END: u32 = 5000;
/// Common variables from this number on keep their values between programs: on a Haas all of them, on a Fanuc #500 to #999. Parameter 6001, bit 6
/// (CCV), decides if those of a Fanuc below #500 survive a reset, so a program cannot know them either.
const COMMON_KEPT: u32 = 100;
/// The first common variable of a Fanuc that is retained without power.
const FANUC_RETAINED: u32 = 500;
/// Second numbers of the common variables of a Haas: #10100 is #100. #10000 to #10099 have no other number.
const HAAS_COMMON: std::ops::RangeInclusive<u32> = 10_000..=10_999;

/// Marks a variable that may contain a value of another program.
const LEFT_OVER: Option<f64> = Some(f64::NAN);

/// A value of the machine file's tables as a number.
pub(super) fn number_of(setting: &Setting) -> Option<f64> {
    match setting {
        Setting::Whole(value) => Some(*value as f64),
        Setting::Number(value) => Some(*value),
        Setting::Truth(value) => Some(f64::from(u8::from(*value))),
        Setting::Text(_) | Setting::List(_) => None,
    }
}

/// A name, common to all programs of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Symbol(u32);

/// Meaning of a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Place {
    /// A variable.
    Variable,
    /// `#0`, which is always null.
    Null,
    /// The state of the control.
    System,
    /// Not a variable.
    Nowhere,
}

/// Variables of one program level.
#[derive(Clone, Debug, Default)]
struct Locals {
    /// By number; those of the calling level, if it shares them.
    numbered: Vec<Option<f64>>,
    named: Vec<(Symbol, f64)>,
    /// Origins of numbered and named variables whose value depends on data of the control, by index.
    origins: Vec<(usize, DataOrigin)>,
    named_origins: Vec<(usize, DataOrigin)>,
    /// `true` if the numbered variables are those of the caller.
    shares: bool,
}

/// All variables of a run.
#[derive(Clone, Debug)]
pub(super) struct Variables {
    language: Language,
    is_haas: bool,
    /// The innermost level last; never empty.
    levels: Vec<Locals>,
    common: Vec<Option<f64>>,
    /// Origins of common and of global named variables whose value depends on data of the control, by index.
    common_origins: Vec<(usize, DataOrigin)>,
    global_origins: Vec<(usize, DataOrigin)>,
    /// Named variables of all levels, by symbol.
    global: Vec<Option<f64>>,
    symbols: HashMap<Box<str>, u32>,
    texts: Vec<Box<str>>,
    /// Return value of the last subroutine (RS274/NGC).
    pub(super) returned: Option<f64>,
    /// Result of the last probing motion, mm or inches and degrees, in program units.
    pub(super) probed: Option<AxisVector>,
    /// The symbols of the names of each program, in loading order.
    programs: Vec<Vec<Symbol>>,
    /// Values of other programs that were read as null.
    pub(super) assumed: AssumedValues,
    /// Values of the control that positions and conditions use.
    pub(super) fixed: FixedValues,
}

impl Variables {
    /// Variables at the start of a run; the machine file's table may contain values retained by the control: `"#500" = 1.5`.
    pub(super) fn new(language: Language, machine: &Machine, tells_assumed: bool) -> Variables {
        let is_haas = machine.control.iso.is_haas();
        let common = match language {
            Language::Rs274 => {
                let mut common = vec![Some(0.0); RS274_END as usize];
                common[..=RS274_USER_END as usize].fill(LEFT_OVER);
                common
            }
            _ if is_haas => {
                let mut common = vec![None; *HAAS_COMMON.end() as usize + 1];
                common.iter_mut().skip(COMMON_KEPT as usize).for_each(|value| *value = LEFT_OVER);
                common
            }
            _ => {
                let mut common = vec![None; FANUC_SYSTEM as usize];
                common[COMMON_KEPT as usize..].fill(LEFT_OVER);
                common
            }
        };
        let mut variables = Variables {
            language,
            is_haas,
            levels: vec![Locals::default()],
            common,
            common_origins: Vec::new(),
            global_origins: Vec::new(),
            global: Vec::new(),
            symbols: HashMap::new(),
            texts: Vec::new(),
            returned: None,
            probed: None,
            programs: Vec::new(),
            assumed: AssumedValues::new(tells_assumed),
            fixed: FixedValues::default(),
        };
        variables.levels[0].numbered = variables.no_locals();
        if language == Language::Rs274 {
            variables.levels[0].numbered.fill(LEFT_OVER);
        }
        if language == Language::Rs274 {
            for (&number, &value) in &machine.parameters {
                variables.set(u32::try_from(number).unwrap_or(RS274_END), Some(value));
            }
        }
        for (key, setting) in &machine.system {
            let number = key.strip_prefix('#').and_then(|digits| digits.parse().ok());
            if let Some(number) = number.filter(|&number| variables.place(number) == Place::Variable) {
                variables.set(number, number_of(setting));
            }
        }
        variables
    }

    fn no_locals(&self) -> Vec<Option<f64>> {
        match self.language {
            Language::Rs274 => vec![Some(0.0); RS274_LOCALS + 1],
            _ => vec![None; FANUC_LOCALS + 1],
        }
    }

    /// Registers the names of a loaded program; program indices are in the order of these calls.
    pub(super) fn add_program(&mut self, program: &Program) {
        let names = program.names.iter().map(|name| self.symbol(name)).collect();
        self.programs.push(names);
    }

    /// The symbol of a name.
    fn symbol(&mut self, name: &str) -> Symbol {
        if let Some(&id) = self.symbols.get(name) {
            return Symbol(id);
        }
        let id = u32::try_from(self.texts.len()).unwrap_or(u32::MAX);
        self.symbols.insert(name.into(), id);
        self.texts.push(name.into());
        self.global.push(None);
        Symbol(id)
    }

    /// The symbol of a name of a program.
    pub(super) fn symbol_of(&self, program: usize, name: NameId) -> Option<Symbol> {
        self.programs.get(program)?.get(name.index()).copied()
    }

    /// The value of a name, upper case.
    pub(super) fn of_name(&self, name: &str) -> Option<f64> {
        self.symbols.get(name).and_then(|&id| self.named(Symbol(id)))
    }

    /// The name, upper case.
    pub(super) fn text(&self, symbol: Symbol) -> &str {
        self.texts.get(symbol.0 as usize).map_or("", |text| text)
    }

    /// Meaning of a number.
    pub(super) fn place(&self, number: u32) -> Place {
        match self.language {
            Language::Rs274 if (1..RS274_END).contains(&number) => Place::Variable,
            Language::Rs274 => Place::Nowhere,
            _ if number == 0 => Place::Null,
            _ if self.is_haas && HAAS_COMMON.contains(&number) => Place::Variable,
            _ if number as usize <= FANUC_LOCALS || FANUC_COMMON.contains(&number) => Place::Variable,
            _ if number >= FANUC_SYSTEM => Place::System,
            _ => Place::Nowhere,
        }
    }

    fn locals(&self) -> usize {
        if self.language == Language::Rs274 { RS274_LOCALS } else { FANUC_LOCALS }
    }

    /// The index of a variable in its store.
    fn index(&self, number: u32) -> usize {
        let short = number.wrapping_sub(*HAAS_COMMON.start());
        let is_second = self.is_haas && HAAS_COMMON.contains(&number) && FANUC_COMMON.contains(&short);
        (if is_second { short } else { number }) as usize
    }

    /// The value of a variable by number.
    pub(super) fn get(&self, number: u32) -> Option<f64> {
        let index = self.index(number);
        if index <= self.locals() {
            let level = self.levels.last();
            let value = level.and_then(|level| level.numbered.get(index).copied().flatten());
            return value.map(|value| if value.is_nan() { 0.0 } else { value });
        }
        let value = self.common.get(index).copied().flatten();
        // In RS274/NGC every parameter has a value.
        if self.language == Language::Rs274 {
            return value.map(|value| if value.is_nan() { 0.0 } else { value });
        }
        value.filter(|value| !value.is_nan())
    }

    /// `true` if a common variable still has a value of another program.
    pub(super) fn is_left_over(&self, number: u32) -> bool {
        let index = self.index(number);
        let numbered = self.levels.last().map(|level| &level.numbered);
        let store = numbered.filter(|_| index <= self.locals()).unwrap_or(&self.common);
        store.get(index).copied().flatten().is_some_and(f64::is_nan)
    }

    /// Says if a common variable keeps its value between programs, as a verb of a message.
    pub(super) fn keeps(&self, number: u32) -> &'static str {
        let is_certain = self.is_haas || self.language == Language::Rs274 || number >= FANUC_RETAINED;
        if is_certain { "keeps" } else { "may keep" }
    }

    /// Sets a variable by number.
    pub(super) fn set(&mut self, number: u32, value: Option<f64>) {
        let index = self.index(number);
        let cell = if index <= self.locals() {
            self.levels.last_mut().and_then(|level| level.numbered.get_mut(index))
        } else {
            self.common.get_mut(index)
        };
        if let Some(cell) = cell {
            *cell = value;
        }
        note(self.origins_mut(index), index, None);
    }

    /// Origins of the numbered variables among which an index is.
    fn origins_mut(&mut self, index: usize) -> Option<&mut Vec<(usize, DataOrigin)>> {
        if index <= self.locals() {
            self.levels.last_mut().map(|level| &mut level.origins)
        } else {
            Some(&mut self.common_origins)
        }
    }

    /// Origin of the value of a variable by number, if it depends on data of the control.
    pub(super) fn origin(&self, number: u32) -> Option<DataOrigin> {
        let index = self.index(number);
        if index <= self.locals() {
            find(&self.levels.last()?.origins, index)
        } else {
            find(&self.common_origins, index)
        }
    }

    /// Notes the origin of the value that a variable was set to.
    pub(super) fn set_origin(&mut self, number: u32, origin: DataOrigin) {
        let index = self.index(number);
        note(self.origins_mut(index), index, Some(origin));
    }

    /// Origin of the value of a named variable, if it depends on data of the control.
    pub(super) fn origin_of_name(&self, symbol: Symbol) -> Option<DataOrigin> {
        let index = symbol.0 as usize;
        if self.is_global(symbol) {
            find(&self.global_origins, index)
        } else {
            find(&self.levels.last()?.named_origins, index)
        }
    }

    /// Notes the origin of the value that a named variable was set to; `None` if it does not depend on data of the control.
    pub(super) fn set_origin_of_name(&mut self, symbol: Symbol, origin: Option<DataOrigin>) {
        let index = symbol.0 as usize;
        let origins = if self.is_global(symbol) {
            Some(&mut self.global_origins)
        } else {
            self.levels.last_mut().map(|level| &mut level.named_origins)
        };
        note(origins, index, origin);
    }

    /// `true` if a name is common to all levels.
    fn is_global(&self, symbol: Symbol) -> bool {
        self.language != Language::Rs274 || self.text(symbol).starts_with('_')
    }

    /// The value of a name; `None` if it has none.
    pub(super) fn named(&self, symbol: Symbol) -> Option<f64> {
        if self.is_global(symbol) {
            return self.global.get(symbol.0 as usize).copied().flatten();
        }
        self.levels.last()?.named.iter().find(|(known, _)| *known == symbol).map(|&(_, value)| value)
    }

    /// Sets a named variable.
    pub(super) fn set_named(&mut self, symbol: Symbol, value: Option<f64>) {
        if self.is_global(symbol) {
            if let Some(cell) = self.global.get_mut(symbol.0 as usize) {
                *cell = value;
            }
        } else if let (Some(level), Some(value)) = (self.levels.last_mut(), value) {
            match level.named.iter_mut().find(|(known, _)| *known == symbol) {
                Some(cell) => cell.1 = value,
                None => level.named.push((symbol, value)),
            }
        }
    }

    /// Begins a program level with its own local variables, the first of which have these values.
    pub(super) fn enter(&mut self, arguments: &[(u32, f64, Option<DataOrigin>)]) {
        let numbered = self.no_locals();
        self.levels.push(Locals { numbered, ..Locals::default() });
        for &(number, value, origin) in arguments {
            self.set(number, Some(value));
            if let Some(origin) = origin {
                self.set_origin(number, origin);
            }
        }
    }

    /// Begins a program level that shares its caller's numbered variables.
    pub(super) fn enter_shared(&mut self) {
        let taken = |level: &mut Locals| (std::mem::take(&mut level.numbered), std::mem::take(&mut level.origins));
        let (numbered, origins) = self.levels.last_mut().map(taken).unwrap_or_default();
        self.levels.push(Locals { numbered, origins, shares: true, ..Locals::default() });
    }

    /// Ends the innermost level.
    pub(super) fn leave(&mut self) {
        if self.levels.len() < 2 {
            return;
        }
        if let (Some(left), Some(level)) = (self.levels.pop(), self.levels.last_mut())
            && left.shares
        {
            (level.numbered, level.origins) = (left.numbered, left.origins);
        }
    }

    /// Number of levels above the outermost one.
    pub(super) fn depth(&self) -> usize {
        self.levels.len() - 1
    }
}

/// Finds the origin of an index.
fn find(origins: &[(usize, DataOrigin)], index: usize) -> Option<DataOrigin> {
    origins.iter().find(|(known, _)| *known == index).map(|&(_, origin)| origin)
}

/// Sets or removes the origin of an index.
fn note(origins: Option<&mut Vec<(usize, DataOrigin)>>, index: usize, origin: Option<DataOrigin>) {
    let Some(origins) = origins else { return };
    let known = origins.iter().position(|(known, _)| *known == index);
    match (known, origin) {
        (Some(at), Some(origin)) => origins[at].1 = origin,
        (Some(at), None) => _ = origins.swap_remove(at),
        (None, Some(origin)) => origins.push((index, origin)),
        (None, None) => {}
    }
}

/// Reason why the control state has no value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Missing {
    /// There is no such variable.
    Unknown,
    /// Known only to the machine.
    OnlyMachine,
    /// The program has not stated the position.
    Unstated,
    /// Positions cannot be read under radius compensation.
    Compensated,
}
