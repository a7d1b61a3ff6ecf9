//! The error component that a parameter belongs to, and its words.

use ncfix_model::name::ErrorName;

/// Returns the error component that a parameter belongs to: EXX for `EXX1`; `None` if its name begins with none.
pub(crate) fn component_of(parameter: &str) -> Option<ErrorName> {
    let begins = |count: usize| parameter.get(..count).and_then(|name| name.parse::<ErrorName>().ok());
    begins(4).or_else(|| begins(3))
}

/// Returns the description of a parameter: `squareness X–Y` for `EC0X`, `positioning of X` for `EXX1`; `None` if its name is not an error component.
pub(crate) fn spelled_out(parameter: &str) -> Option<String> {
    component_of(parameter).map(|name| {
        // The parameters of a backlash end with a b: EXXb, EYXb.
        let rest = parameter.strip_prefix(&name.to_string());
        name.spelled_out() + if rest == Some("b") { ", half of the reversal value" } else { "" }
    })
}
