//! Selections → named boundary tags, surfaces inside and volumes.
//!
//! A tag file lists selections in order; every boundary facet of the mesh goes
//! to the first selection that holds its centroid. Lengths are metres.

pub mod assign;
pub mod cmd;
pub mod config;
pub mod facets;
pub mod inside;
pub mod select;
pub mod volumes;
pub mod wall;
