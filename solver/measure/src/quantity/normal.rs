//! The mean normal of a tag times its area.
//!
//! N = ∫ n da [m²], out of the body

use anyhow::{Context as _, Result, ensure};
use mechanics::element::{FunctionSpace, at};
use mechanics::energy::Wall;
use mesh::Vec3;

use super::Site;

/// |N| over the area below which a tag has no mean normal.
const CLOSED: f64 = 1e-6;

/// A tag of which the normal is looked at.
pub struct Normal(Wall);

impl Normal {
    /// The normal of a tag.
    pub fn new(tag: &str, site: &Site) -> Result<Self> {
        let facets = site.body.facets(tag)?;
        check(&facets, &site.body.mesh.vertices).with_context(|| format!("tag \"{tag}\""))?;
        Ok(Self(Wall::new(site.space, &facets)))
    }

    /// N where the nodes are at `x` [m]: minus the force of a unit pressure, which is the gradient
    /// of the volume behind.
    pub fn at(&self, space: &FunctionSpace, x: &[Vec3]) -> Vec3 {
        let mut pull = vec![0.0; 3 * x.len()];
        self.0.add_wall_gradient(space, |n| x[n], -1.0, &mut pull);
        (0..x.len()).map(|n| at(&pull, n)).sum()
    }

    /// Adds ∂(by · N)/∂x at the nodes.
    pub fn add_by_nodes(&self, space: &FunctionSpace, x: &[Vec3], by: &Vec3, out: &mut [f64]) {
        let constant: Vec<f64> = x.iter().flat_map(|_| [by.x, by.y, by.z]).collect();
        self.0.add_stiffness_vjp(space, |n| x[n], &constant, 1.0, out);
    }
}

/// The normals of a tag must not cancel.
fn check(facets: &[[usize; 3]], rest: &[Vec3]) -> Result<()> {
    let (mut sum, mut area) = (Vec3::zeros(), 0.0);
    for [a, b, c] in facets.iter().map(|facet| facet.map(|v| rest[v])) {
        let normal = 0.5 * (b - a).cross(&(c - a));
        sum += normal;
        area += normal.norm();
    }
    ensure!(
        sum.norm() > CLOSED * area,
        "its normals cancel: their integral is {:.1e} of its area; name a tag on one side of the \
         body",
        sum.norm() / area
    );
    Ok(())
}
