//! Mechanics of pressurised silicone: values in, values out.
//!
//! A body, its laws, supports, chambers and obstacles make a [`forward::Problem`]; [`forward`]
//! finds its equilibria and time steps, [`adjoint`] differentiates what is measured on them.
//! Nothing here reads files or settings, and nothing here writes messages for users: errors
//! have their numbers in fields.
//!
//! Modules in dependency order; each uses only those before it:

pub mod parallel; // the one parallel loop
pub mod memory; // what a factorisation takes
pub mod math; // small dense and sparse algebra
pub mod symmetry; // planes through which a part of a body is mirrored
pub mod body; // a tagged mesh
pub mod extension; // how the interior of a body follows its surface
pub mod element; // discretisation
pub mod material; // constitutive (hyperelastic) laws ψ(F)
pub mod stretch; // how far a state strains its material
pub mod rigid; // nodes that move together
pub mod contact; // contact potentials and collision detection
pub mod schedule; // values over time, as people write them
pub mod energy; // terms of the potential energy: elasticity, loads, contact
pub mod fields; // strains and stresses of a state
pub mod forward; // from energies to an equilibrium: Newton's method, load and time steps
pub mod stability; // paths of equilibria, and where these lose their stability
pub mod adjoint; // gradient of an objective over a run by the adjoint method

/// The example of the README, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

#[doc(hidden)]
pub mod testing; // small bodies and gradient checks, for the tests of all crates
