//! Terms of expressions.

/// A term and what it is made of.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Node {
    Number(f64),
    Time,
    Position(usize),
    /// A name, the position of its first character in the text, and its value.
    Parameter {
        name: String,
        at: usize,
        value: f64,
    },
    Minus(Box<Node>),
    Binary(u8, Box<Node>, Box<Node>),
    Call(&'static str, Vec<Node>),
    /// A function that nobody knows, and the position of its first character.
    Unknown {
        function: String,
        at: usize,
    },
}
