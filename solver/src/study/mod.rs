//! Studies of scenes: each a list of runs with other numbers.

pub mod sensitivity; // derivatives of probes by numbers of a scene
pub mod nearby; // the equilibrium next to a known one
pub mod course; // the states of a run, all of them
pub mod limit; // how much more pressure a state bears
pub mod pose; // where a tag is, and its stiffness
pub mod map; // probes, pose and stiffness on a grid of numbers
pub mod uncertainty; // what probes change by if numbers are off
pub mod outcome; // what a run came to, in files
pub mod validation; // simulations beside measurements
pub mod calibration; // numbers of scenes from measurements on a device
pub mod as_cast; // walls of a body as it came out of its mold
