//! What programs write: measures of a state, its strains and stresses, and their files, the
//! record of a run while it runs, its numbers by their columns, what is known where there is no equilibrium, and how far
//! runs are apart.

pub mod buckling;
pub mod columns;
pub mod compare;
pub mod crossing;
pub mod curve;
pub mod failure;
pub mod locking;
pub mod meeting;
pub mod mirror;
pub mod inflation;
pub mod record;
pub mod results;
pub mod simulation;
pub mod stability;
pub mod summary;
pub mod table;
pub mod threads;
pub mod writer;
