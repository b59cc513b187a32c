//! Discretisation: straight-sided tetrahedra with Lagrange displacements.

mod basis;
mod interpolate;
pub mod quadrature;
mod space;

pub use basis::{Tabulation, tabulate};
pub use interpolate::interpolate;
pub use space::{FunctionSpace, add_at, at};
