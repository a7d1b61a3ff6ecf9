//! Values of a description with their origins.

/// Value with its origin.
#[derive(Clone, Debug, PartialEq)]
pub struct Known<T> {
    /// The value.
    pub value: T,
    /// Its origin.
    pub origin: KnownOrigin,
}

/// Origin of a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum KnownOrigin {
    /// A person stated it.
    Stated,
    /// It is the usual value for such a machine.
    Assumed,
    /// It follows from ISO 841 and the chain.
    Convention,
    /// It is in a file: `name:line`, with the data from which it follows.
    File(String),
}

/// The vector, or its opposite.
pub(super) fn signed(vector: [f64; 3], is_positive: bool) -> [f64; 3] {
    // Adding 0 turns -0 into 0.
    vector.map(|part| if is_positive { part } else { -part } + 0.0)
}
