//! What the probes of a scene, and the objectives of a design, are built on.

use std::collections::BTreeMap;

use anyhow::Result;
use measure::probe::Probe;
use measure::quantity::{Law, Site, Targets};
use mechanics::body::Body;
use mechanics::element::FunctionSpace;

use super::Scene;
use crate::supports::Supports;

impl Scene {
    /// What quantities are built on: a body with this scene's tags, laws, supports and times.
    pub(super) fn site<'a>(
        &'a self,
        body: &'a Body,
        space: &'a FunctionSpace,
        targets: Targets,
    ) -> Result<Site<'a>> {
        let (fixed, moments) = (self.fixed(body), self.config.values().moments());
        let supports = Supports::new(&fixed, &moments, body, space)?.by_tag();
        let name = |part: usize| self.parts[part].config.name.as_str();
        let laws = self.laws.iter().map(|law| Law {
            body: name(law.part),
            name: law.name.clone(),
            material: &law.material,
            elements: law.elements(body),
        });
        Ok(Site {
            body,
            space,
            bodies: (0..self.parts.len()).map(name).collect(),
            laws: laws.collect(),
            supports,
            times: self.times(),
            probes: BTreeMap::new(),
            threads: self.config.winding.iter().map(|own| own.name.as_str()).collect(),
            targets,
        })
    }

    /// The probes on a body with this scene's tags, in the order of the scene.
    pub fn probes(&self, body: &Body, space: &FunctionSpace) -> Result<Vec<Probe>> {
        if self.config.probe.is_empty() {
            return Ok(Vec::new());
        }
        self.file.checked(|_| {
            let site = self.site(body, space, Targets::default())?;
            let probes = self.config.probe.iter().map(|config| {
                let (name, kind) = (config.name().to_owned(), config.kind());
                Ok(Probe { name, kind, quantity: config.build(&site)? })
            });
            probes.collect()
        })
    }
}
