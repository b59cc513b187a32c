//! What balances and gauges measure of a body at rest.
//!
//! mass    Σ ρ |T|; of a body that is cut by symmetry, that of the whole       [kg]
//! gauge   from a point of the boundary straight in, to the next boundary      [m]

use anyhow::{Context, Result, ensure};
use mesh::bvh::SurfaceBvh;
use mesh::measure::{diagonal, triangle_area, triangle_normal};
use mesh::{SurfaceMesh, Vec3};
use scene::Scene;

/// How far from the surface a gauge may be placed, as a part of the body's diagonal.
const NEAR: f64 = 0.02;

/// A measurement of the shape.
pub enum Shape {
    /// Of the silicone, without inlets, tubes and sheets.
    Mass,
    /// Where a gauge is set on: a point of a facet of the boundary, by the weights of its vertices.
    Gauge([usize; 3], [f64; 3]),
}

impl Shape {
    /// The mass of a scene, whose densities have to be known.
    pub fn mass(scene: &Scene) -> Result<Self> {
        for law in &scene.laws {
            ensure!(
                law.material.density.is_some(),
                "the density of \"{}\" is not known; add density = ... [kg/m³] to its material",
                law.name.clone()
            );
        }
        Ok(Self::Mass)
    }

    /// A gauge that is set on at a point, or near it [m].
    pub fn gauge(scene: &Scene, at: [f64; 3]) -> Result<Self> {
        let x = &scene.body.mesh.vertices;
        let boundary = boundary(scene);
        let near = SurfaceBvh::new(&boundary).closest(&at.into());
        let limit = NEAR * diagonal(x);
        ensure!(
            near.distance <= limit,
            "gauge = {at:?} m is {:.2} mm from the boundary of the body; expected a point of it, at most {:.2} mm away",
            1e3 * near.distance,
            1e3 * limit
        );
        let facet = boundary.triangles[near.triangle];
        let [a, b, c] = facet.map(|v| x[v]);
        let part = |p, q| triangle_area(near.point, p, q) / triangle_area(a, b, c);
        Ok(Self::Gauge(facet, [part(b, c), part(c, a), part(a, b)]))
    }

    /// What is measured of a body with moved walls.
    pub fn value(&self, scene: &Scene) -> Result<f64> {
        let (body, x) = (&scene.body, &scene.body.mesh.vertices);
        let Self::Gauge(facet, weights) = self else {
            let mass = |law: &scene::SceneLaw| {
                let volumes = law.elements(body).map(|tet| body.mesh.volume(tet));
                law.material.density.unwrap_or(0.0) * volumes.sum::<f64>()
            };
            let whole = 2.0_f64.powi(body.planes.len() as i32);
            return Ok(whole * scene.laws.iter().map(mass).sum::<f64>());
        };
        let [a, b, c] = facet.map(|v| x[v]);
        let inward = -triangle_normal(a, b, c).normalize();
        let [p, q, r] = weights;
        let from: Vec3 = *p * a + *q * b + *r * c;
        let surface = boundary(scene);
        let own = surface.triangles.iter().position(|t| t == facet);
        let hits = SurfaceBvh::new(&surface).ray(&from, &inward);
        let hit = hits.into_iter().find(|(s, t)| *s > 0.0 && Some(*t) != own);
        hit.map(|(s, _)| s).context("gauge: there is no wall straight in from its place")
    }
}

fn boundary(scene: &Scene) -> SurfaceMesh {
    let vertices = scene.body.mesh.vertices.clone();
    SurfaceMesh { vertices, triangles: scene.body.boundary().to_vec() }
}
