//! Designs: from design variables to rest shape and loads, and the search for better ones.
//!
//! Modules in dependency order; each uses only those before it:

pub mod variables; // design variables to rest shape and loads, with transposed derivative
pub mod optimize; // outer loop: steps of quadratic programs to a better shape
