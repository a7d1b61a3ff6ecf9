//! Identity of what an explanation names. Explanations are compared by it, never by the words that people read.

use std::fmt;

use ncfix_base::geometry::Axis;
use ncfix_model::ErrorName;
use serde::{Serialize, Serializer};

use super::EffectKind;

/// Identity of a cause in explanations and among the rivals of a finding. Its text is what people and programs read.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum CauseId {
    /// An effect and its parameter, as `location EC0X`. Variants of one cause share it, such as a load with and without a tilt.
    Effect(EffectKind, String),
    /// Causes that act together.
    Together(Vec<CauseId>),
    /// The opposite sign of all readings of this file or set-up.
    OppositeSign(String),
    /// A slope of a motion error that differs between files: the component, its axis, and the file.
    ChangedSlope(ErrorName, Axis, String),
    /// A slow change of the readings that follows no known quantity.
    SlowChange,
    /// A hypothesis, as the user states it.
    Stated(String),
}

impl CauseId {
    /// True if it is this effect, by its key in reports, with this parameter.
    #[must_use]
    pub fn is_effect(&self, key: &str, parameter: &str) -> bool {
        matches!(self, CauseId::Effect(effect, own) if own == parameter && effect.to_string() == key)
    }

    /// Returns the text of a stated hypothesis; `None` for any other cause.
    #[must_use]
    pub fn stated(&self) -> Option<&str> {
        if let CauseId::Stated(text) = self { Some(text) } else { None }
    }

    /// Several causes as one.
    pub(in crate::diagnose) fn together(mut all: Vec<CauseId>) -> CauseId {
        if all.len() == 1 { all.remove(0) } else { CauseId::Together(all) }
    }

    /// Puts the causes of an explanation in the order of their texts, each once.
    pub(in crate::diagnose) fn in_order(mut all: Vec<CauseId>) -> Vec<CauseId> {
        all.sort_by_cached_key(ToString::to_string);
        all.dedup();
        all
    }
}

impl fmt::Display for CauseId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CauseId::Effect(effect, parameter) => f.write_str(format!("{effect} {parameter}").trim_end()),
            CauseId::Together(all) => {
                for (k, one) in all.iter().enumerate() {
                    write!(f, "{}{one}", if k > 0 { " with " } else { "" })?;
                }
                Ok(())
            }
            CauseId::OppositeSign(of) => write!(f, "{} sign of {of}", EffectKind::Setup),
            CauseId::ChangedSlope(component, axis, file) => {
                write!(f, "{component} slope that differs between files ({axis} in {file}: temperature, maintenance)")
            }
            CauseId::SlowChange => f.write_str("slow change without a cause"),
            CauseId::Stated(text) => f.write_str(text),
        }
    }
}

impl Serialize for CauseId {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scale(axis: &str) -> CauseId {
        CauseId::Effect(EffectKind::Motion, format!("E{axis}{axis}"))
    }

    #[test]
    fn one_cause_together_is_itself() {
        assert_eq!(CauseId::together(vec![scale("Y")]), scale("Y"));
        assert_eq!(CauseId::together(vec![scale("Y"), scale("Z")]).to_string(), "motion EYY with motion EZZ");
    }

    #[test]
    fn equal_texts_do_not_make_equal_causes() {
        let stated = CauseId::Stated("motion EXX".to_owned());
        assert_eq!(stated.to_string(), scale("X").to_string());
        assert!(stated != scale("X") && stated.stated().is_some() && !stated.is_effect("motion", "EXX"));
        assert!(scale("X").is_effect("motion", "EXX") && !scale("X").is_effect("motion", "EYY"));
        assert_eq!(CauseId::in_order(vec![scale("Y"), scale("X"), scale("Y")]), [scale("X"), scale("Y")]);
    }

    #[test]
    fn an_effect_without_a_parameter_has_its_name_alone() {
        assert_eq!(CauseId::Effect(EffectKind::Outlier, String::new()).to_string(), "outlier");
        assert_eq!(CauseId::OppositeSign("a.csv".to_owned()).to_string(), "setup sign of a.csv");
    }
}
