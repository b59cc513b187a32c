//! Terms of expressions.

/// What a name without a meaning is used as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unknown {
    Name,
    Function,
}

/// A term and what it is made of.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Node {
    Number(f64),
    Time,
    Position(usize),
    /// A name that has no value, and the position of its first character in the text: that of a
    /// parameter, or of a function that nobody knows.
    Name {
        used: Unknown,
        name: String,
        at: usize,
    },
    /// A name and its value.
    Parameter {
        name: String,
        value: f64,
    },
    Minus(Box<Node>),
    Binary(u8, Box<Node>, Box<Node>),
    Call(&'static str, Vec<Node>),
}
