//! Finite elements of pressurised silicone, adjoint gradients, and shape
//! optimisation of air cavities.
//!
//! Modules in dependency order; each uses only those before it:

pub mod parallel; // 0. the one parallel loop
#[rustfmt::skip]
pub mod math; // 1. small dense and sparse algebra
pub mod adjoint; // 9. gradient of an objective at an equilibrium
pub mod body; // 2. a tagged mesh
pub mod config; // top layer: what people write
pub mod contact; // 4. distances between surfaces
pub mod design; // 8. design variables to rest shape, with transpose
pub mod element; // 2. discretisation
pub mod energy; // 5. terms of the potential energy
pub mod forward; // 6. from energies to an equilibrium
pub mod material; // 3. constitutive laws ψ(F)
pub mod objective; // 7. what to minimise
pub mod optimize; // 10. outer loop
pub mod results; // top layer: what programs write
pub mod scene; // top layer: config and files to objects

#[cfg(test)]
mod testing;
