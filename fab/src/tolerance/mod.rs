//! What the response becomes when the walls are printed off by the tolerance.
//!
//! Molds that are printed too lean leave room for thicker walls, and thinner ones if too
//! fat. The boundary of the body is moved along its normals by ± the tolerance
//! ([`offset`]), and each body is simulated by the program `solver` ([`run`]).

pub mod offset;
pub mod run;

use serde::Serialize;

/// Name of the report in the folder of a study.
pub const FILE: &str = "tolerance.json";

/// A number of the response, and how far it is spread.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Response {
    /// The name in the solver's report, such as `chambers.cavity.volume`.
    pub name: String,
    /// The unit.
    pub unit: &'static str,
    /// As designed.
    pub nominal: f64,
    /// With walls thinner by the tolerance on each side.
    pub thin: f64,
    /// With walls thicker by the tolerance on each side.
    pub thick: f64,
    /// Largest less smallest, as a part of the nominal [%]; none if that is 0.
    pub spread: Option<f64>,
}

/// A finished study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Study {
    /// Program and version.
    pub program: String,
    /// How far every wall is moved [m].
    pub tolerance: f64,
    /// Volume of the silicone as designed, thin and thick [m³].
    pub volumes: [f64; 3],
    /// What the solver reported.
    pub responses: Vec<Response>,
}

impl Response {
    /// Puts the three runs of a number side by side.
    pub fn new(name: String, unit: &'static str, [nominal, thin, thick]: [f64; 3]) -> Self {
        let width = nominal.max(thin).max(thick) - nominal.min(thin).min(thick);
        let spread = (nominal != 0.0).then(|| 100.0 * width / nominal.abs());
        Self { name, unit, nominal, thin, thick, spread }
    }
}
