//! One program of all tests of `fab`, so that they share the cores to the end.

mod fixture;

mod bodies;
mod castings;
mod chambers;
mod damage;
mod films;
mod fitting;
mod judges;
mod models;
mod mold;
mod plan;
mod sheet;
