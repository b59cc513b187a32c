//! The probes of a scene.

use anyhow::Result;
use measure::probe::{Probe, Site};
use mechanics::body::Body;
use mechanics::element::FunctionSpace;

use super::Scene;
use crate::supports::Supports;

impl Scene {
    /// The probes on a body with this scene's tags, in the order of the scene.
    ///
    /// # Errors
    /// When a tag is missing, or a point lies outside of the body.
    pub fn probes(&self, body: &Body, space: &FunctionSpace) -> Result<Vec<Probe>> {
        if self.config.probe.is_empty() {
            return Ok(Vec::new());
        }
        self.file.checked(|_| self.built_probes(body, space))
    }

    fn built_probes(&self, body: &Body, space: &FunctionSpace) -> Result<Vec<Probe>> {
        let (fixed, moments) = (self.fixed(body), self.config.moments());
        let supports = Supports::new(&fixed, &moments, body, space)?.by_tag();
        let site = Site { body, space, supports: &supports };
        let probes = self.config.probe.iter().map(|config| {
            let (name, kind, quantity) =
                (config.name().to_owned(), config.kind(), config.build(&site)?);
            Ok(Probe { name, kind, quantity })
        });
        probes.collect()
    }
}
