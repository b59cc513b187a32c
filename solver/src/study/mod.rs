//! Studies of scenes: each a list of runs with other numbers.

pub mod pose; // where a tag is, and its stiffness
pub mod map; // probes, pose and stiffness on a grid of numbers
pub mod table; // measured tables
pub mod least_squares; // numbers by which simulations fit measurements best
pub mod validation; // simulations beside measurements
pub mod calibration; // numbers of scenes from measurements on a device
