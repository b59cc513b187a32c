//! Small dense and sparse algebra.

mod followers;
pub mod lanczos;
pub mod lanes;
pub mod least_squares;
pub mod linear;
pub mod ordering;
pub mod pool;
pub mod random;
pub mod sparse;
pub mod taylor;
pub mod tensor;
