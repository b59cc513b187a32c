//! Simulation of pressurised silicone, adjoint gradients, and shape optimisation of air chambers.
//!
//! What people write is read by the crate `scene`, what is measured is in `measure`, and how
//! bodies move in `mechanics`.
//!
//! Modules in dependency order; each uses only those before it:

pub mod plot; // curves as pictures
pub mod units; // units in which people measure
pub mod fit; // tensile tests to laws
pub mod design; // design variables to rest shape and loads, with transposed derivative
pub mod report; // what programs write of states, runs, failures and comparisons
pub mod run; // simulates a scene: states, verdict, derivatives, report
pub mod export; // scenes as decks of other programs
pub mod study; // runs of a scene with other numbers: error bars, calibration, validation
pub mod optimize; // outer loop: steps of quadratic programs to a better shape
pub mod cmd; // the verbs of the program, one per file
