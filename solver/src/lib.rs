//! Simulation of pressurised silicone, adjoint gradients, and shape optimisation of air chambers.
//!
//! What people write is read by the crate `scene`, what is measured is in `measure`, how bodies move
//! in `mechanics`, how scenes are simulated in `run`, and how better shapes are found in `design`.
//!
//! Modules in dependency order; each uses only those before it:

pub mod plot; // curves as pictures
pub mod units; // units in which people measure
pub mod fit; // tensile tests to laws
pub mod export; // scenes as decks of other programs
pub mod study; // runs of a scene with other numbers: error bars, calibration, validation
pub mod cmd; // the verbs of the program, one per file
