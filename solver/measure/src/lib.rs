//! What is measured on the states of bodies, and what is minimised.
//!
//! Modules in dependency order; each uses only those before it:

pub mod written; // names, and schemas of values
pub mod objective; // what to minimise
pub mod probe; // what to measure
