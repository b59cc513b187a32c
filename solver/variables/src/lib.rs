//! Design variables: what a shape and its loads are made of, and the steps of a search in them.

pub mod vectors; // sums, differences and products
pub mod map; // design variables to rest shape and loads, with transposed derivative
pub mod step; // quadratic models of an objective, and how far they are trusted

pub use map::{DesignMap, LoadMap, carry, check_same_body};
