//! What is measured on the states of bodies, and what is minimised: quantities, each with a file and
//! a row of one table.
//!
//! Modules in dependency order; each uses only those before it:

pub mod written; // names, and schemas of values
pub mod quantity; // what a quantity is, its row, and what several are made with
pub mod kinds; // the table of all quantities
pub mod entry; // a quantity as a file has it
pub mod probe; // what to measure: [[probe]]
pub mod objective; // what to minimise: [[objective]]
pub mod constraint; // what a design keeps: [[constraint]]
