//! One program of all tests of `fab`, so that they share the cores to the end.

mod fixture;

mod castings;
mod chambers;
mod damage;
mod films;
mod fitting;
mod hard;
mod judges;
mod mold;
mod plan;
mod sheet;
mod sound;
