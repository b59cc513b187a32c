//! Discretisation: straight-sided tetrahedra with Lagrange displacements.

mod basis;
pub mod quadrature;
mod space;

pub use basis::{Tabulation, tabulate};
pub use space::{FunctionSpace, add_at, at};
