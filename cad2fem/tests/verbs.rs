//! One program of all tests of `cad2fem`, so that they share the cores to the end.

#[allow(clippy::unwrap_used)]
mod support;

mod cli;
mod film;
mod import;
mod meshers;
mod new;
mod pack;
mod picture;
