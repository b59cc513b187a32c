//! Small dense and sparse algebra.

pub mod linear;
pub mod ordering;
pub mod random;
pub mod sparse;
pub mod taylor;
pub mod tensor;
