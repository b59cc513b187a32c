//! Finite elements of pressurised silicone, adjoint gradients, and shape
//! optimisation of air chambers.
//!
//! Modules in dependency order; each uses only those before it:

pub mod parallel; // the one parallel loop
pub mod memory; // what a factorisation may take
pub mod math; // small dense and sparse algebra
pub mod plot; // curves as pictures
pub mod symmetry; // planes through which a part of a body is mirrored
pub mod body; // a tagged mesh
pub mod element; // discretisation
pub mod material; // constitutive (hyperelastic) laws ψ(F)
pub mod silicone; // known materials
pub mod fit; // tensile tests to laws
pub mod stretch; // how far a state strains its material
pub mod contact; // contact potentials and collision detection
pub mod schedule; // values over time, as people write them
pub mod energy; // terms of the potential energy: elasticity, loads, contact
pub mod forward; // from energies to an equilibrium: Newton's method, load and time steps
pub mod objective; // what to minimise
pub mod probe; // what to measure
pub mod adjoint; // gradient of an objective over a run by the adjoint method
pub mod config; // what people write
pub mod supports; // Dirichlet conditions: fixed degrees of freedom
pub mod scene; // config and files to objects
pub mod design; // design variables to rest shape and loads, with transposed derivative
pub mod sensitivity; // derivatives of probes by numbers of a scene
pub mod uncertainty; // what probes change by if numbers are off
pub mod locking; // what elements of a degree hold back
pub mod report; // what programs write of states, runs, failures and comparisons
pub mod validation; // simulations beside measurements
pub mod calibration; // numbers of scenes from measurements on a device
pub mod as_cast; // walls of a body as it came out of its mold
pub mod polyfem; // scenes of PolyFEM to scenes of ours
pub mod optimize; // outer loop: quasi-Newton steps to a better shape
pub mod cmd; // the verbs of the program, one per file

#[cfg(test)]
mod testing;
