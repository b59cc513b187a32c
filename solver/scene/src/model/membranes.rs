//! The sheets of a scene: their laws, facets and checks.

use anyhow::{Context, Result, ensure};
use mechanics::body::Body;
use mechanics::element::FunctionSpace;
use mechanics::energy::Membrane;
use mechanics::material::sheet::Specification;
use program::misfit;

use super::Scene;
use crate::config::MembraneConfig;

/// A sheet as its scene describes it.
#[derive(Clone)]
pub struct SceneMembrane {
    /// The settings.
    pub config: MembraneConfig,
    /// Thickness at rest [m].
    pub thickness: f64,
    /// Law and parameters.
    pub material: Specification,
}

impl SceneMembrane {
    /// From its settings.
    ///
    /// # Errors
    /// When they name no law.
    pub fn new(config: &MembraneConfig) -> Result<Self> {
        let material = config.specification()?;
        Ok(Self { config: config.clone(), thickness: config.thickness, material })
    }

    /// The numbers that its energy is made with: the thickness, then those of the law.
    #[must_use]
    pub fn numbers(&self) -> Vec<f64> {
        [self.thickness].into_iter().chain(self.material.values.iter().copied()).collect()
    }

    /// What reports and messages call it.
    #[must_use]
    pub fn in_words(&self) -> String {
        let numbers = self.material.law.named(&self.material.values).into_iter();
        let numbers = numbers.map(|(p, v)| match p.unit {
            "1" => format!("{} {}", p.name, v[0]),
            unit => format!("{} {:.3e} {unit}", p.name, v[0]),
        });
        format!(
            "membrane on {}: {:.3} mm, {} ({}){}",
            self.config.on,
            1e3 * self.thickness,
            self.material.law.key,
            numbers.collect::<Vec<_>>().join(", "),
            if self.config.tension { ", in tension only" } else { "" }
        )
    }
}

impl Scene {
    /// The sheets of a body, in the order of the scene.
    ///
    /// # Errors
    /// When a tag is missing, or its facets are none of the mesh.
    pub(super) fn sheets(&self, body: &Body, space: &FunctionSpace) -> Result<Vec<Membrane>> {
        let one = |membrane: &SceneMembrane| {
            let SceneMembrane { config, thickness, material } = membrane;
            let facets = body.tagged(&config.on).with_context(|| config.title())?;
            for plane in &body.planes {
                let inside = facets.iter().filter(|&&facet| plane.has_facet(facet)).count();
                ensure!(
                    inside == 0,
                    misfit!(
                        config.title(),
                        ": {inside} of its {} facets lie in the plane of symmetry {}, where the whole body \
                         goes on: there is no surface to bond a sheet to; expected a tag without them, or \
                         the whole body (solver mirror)",
                        facets.len(),
                        plane.equation()
                    )
                );
            }
            Ok(Membrane::new(space, &facets, *thickness, material.build(config.tension)))
        };
        self.membranes.iter().map(one).collect()
    }
}
