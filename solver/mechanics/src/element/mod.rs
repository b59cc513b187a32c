//! Finite-element discretisation: straight-sided tetrahedra with Lagrange displacements.

mod basis;
mod bernstein;
mod incidence;
mod interpolate;
pub mod quadrature;
mod space;

pub use basis::{EDGES, HIGHEST_DEGREE, Tabulation, nodes as node_indices, tabulate, values};
pub use bernstein::JacobianForm;
pub use incidence::Incidence;
pub use interpolate::{elevate, interpolate, sample, weights};
pub use space::{FunctionSpace, add_at, at};
