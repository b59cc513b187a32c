//! The sheets of a scene: their laws, facets and checks.

use anyhow::{Context, Result, ensure};
use mechanics::body::Body;
use mechanics::element::FunctionSpace;
use mechanics::energy::{Direction, Membrane};
use mechanics::material::sheet::{Specification, Strain};
use mechanics::symmetry::Plane;
use mesh::Vec3;
use program::misfit;

use super::Scene;
use super::reinforcement::{PARALLEL, image};
use crate::config::MembraneConfig;

/// Part of the direction of a warp that lies in its sheet, at least [1].
const LEAST_PART: f64 = 0.1;

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
    pub fn new(config: &MembraneConfig) -> Result<Self> {
        let material = config.specification()?;
        Ok(Self { config: config.clone(), thickness: config.thickness, material })
    }

    /// The numbers that its energy is made with: the thickness, those of the law, and the angle of its warp [°], if it
    /// has one.
    pub fn numbers(&self) -> Vec<f64> {
        let numbers = [self.thickness].into_iter().chain(self.material.values.iter().copied());
        numbers.chain(self.config.angle).collect()
    }

    /// Whether another sheet has the same numbers, on the same tag.
    fn is_like(&self, other: &Self) -> bool {
        let numbers = |sheet: &Self| (sheet.thickness, sheet.material.values.clone());
        let config = |sheet: &Self| (sheet.config.on.clone(), sheet.config.tension);
        config(self) == config(other)
            && self.material.law.key == other.material.law.key
            && numbers(self) == numbers(other)
    }

    /// Whether another sheet like this is its mirror image at a facet with these corners: their warps are, or, where warp
    /// and weft are as stiff, the warp of one and the weft of the other.
    fn is_image(&self, own: &Direction, other: &Direction, plane: &Plane, x: [Vec3; 3]) -> bool {
        let normal = (x[1] - x[0]).cross(&(x[2] - x[0])).normalize();
        let centre = x.iter().sum::<Vec3>() / 3.0;
        let inside = |along: Vec3| (along - normal.dot(&along) * normal).normalize();
        // the image of the other is compared here, in the plane of this facet
        let mut there = other.at(image(plane, centre));
        there[plane.axis] = -there[plane.axis];
        let (here, there) = (inside(own.at(centre)), inside(there));
        let stiffness = self.material.build(false).tangent(&Strain::zeros());
        let balanced = stiffness[(0, 0)] == stiffness[(1, 1)];
        here.cross(&there).norm() < PARALLEL || balanced && here.dot(&there).abs() < PARALLEL
    }

    /// What reports and messages call it.
    pub fn in_words(&self) -> String {
        let numbers = self.material.law.named(&self.material.values).into_iter();
        let numbers = numbers.map(|(p, v)| match p.unit {
            "1" => format!("{} {}", p.name, v[0]),
            unit => format!("{} {:.3e} {unit}", p.name, v[0]),
        });
        format!(
            "membrane on {}: {:.3} mm, {} ({}){}{}",
            self.config.on,
            1e3 * self.thickness,
            self.material.law.key,
            numbers.collect::<Vec<_>>().join(", "),
            self.config
                .angle
                .map_or_else(String::new, |angle| format!(", warp at {angle}° to an axis")),
            if self.config.tension { ", in tension only" } else { "" }
        )
    }
}

impl Scene {
    /// The sheets of a body, in the order of the scene.
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
            let sheet = Membrane::new(space, &facets, *thickness, material.build(config.tension));
            let Some(direction) = config.leads()? else { return Ok(sheet) };
            check_warp(config, &direction, &facets, body)?;
            for plane in &body.planes {
                self.check_sheet_mirrored(membrane, &direction, (plane, &facets[..]), body)?;
            }
            Ok(sheet.along(direction))
        };
        self.membranes.iter().map(one).collect()
    }

    /// Refuses a sheet whose mirror image in a plane is none of the sheets on its tag.
    fn check_sheet_mirrored(
        &self,
        own: &SceneMembrane,
        direction: &Direction,
        (plane, facets): (&Plane, &[[usize; 3]]),
        body: &Body,
    ) -> Result<()> {
        let mut found = false;
        for other in self.membranes.iter().filter(|other| own.is_like(other)) {
            let Some(lead) = other.config.leads()? else { continue };
            let image = |facet: &[usize; 3]| {
                let corners = facet.map(|v| body.mesh.vertices[v]);
                own.is_image(direction, &lead, plane, corners)
            };
            found |= facets.iter().all(image);
        }
        ensure!(
            found,
            misfit!(
                own.config.title(),
                ": its mirror image in {} is no sheet of the scene, so the body is not symmetric; expected a warp along \
                 the plane or across it, another [[membrane]] on the tag with the same numbers and the opposite angle, \
                 or the whole body (solver mirror)",
                plane.equation()
            )
        );
        Ok(())
    }
}

/// Refuses a warp that is nearly across its sheet somewhere.
fn check_warp(
    membrane: &MembraneConfig,
    direction: &Direction,
    facets: &[[usize; 3]],
    body: &Body,
) -> Result<()> {
    for facet in facets {
        let [a, b, c] = facet.map(|v| body.mesh.vertices[v]);
        let centre = (a + b + c) / 3.0;
        let normal = (b - a).cross(&(c - a)).normalize();
        // where it is undefined, on an axis, none of it counts
        let part = |x: Vec3| direction.at(x).cross(&normal).norm();
        let parts = [a, b, c, centre].map(part).into_iter();
        let least = parts.map(|p| if p.is_nan() { 0.0 } else { p }).fold(f64::INFINITY, f64::min);
        ensure!(
            least >= LEAST_PART,
            misfit!(
                membrane.title(),
                ": the warp is across the sheet at ({:.6}, {:.6}, {:.6}) m, where {:.1} % of its direction lie in \
                 the sheet; expected {:.0} % or more, so another direction, or a tag without these facets",
                centre.x,
                centre.y,
                centre.z,
                100.0 * least,
                100.0 * LEAST_PART
            )
        );
    }
    Ok(())
}
