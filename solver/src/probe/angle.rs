//! Angle between two tags.
//!
//! q = angle between N₁ and N₂, from 0 to 180°      N = ∫ n da of the deformed tag   [deg]
//!
//! N is the mean normal, out of the body, times the area. A closed surface has none. q has no
//! derivative at 0 and 180°.

use std::sync::Arc;

use anyhow::{Context as _, Result, ensure};
use mesh::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::kind::{Kind, OTHER_TAG, Site, Specification, TAG, form};
use crate::element::{FunctionSpace, at};
use crate::energy::Wall;
use crate::objective::{Equilibrium, Measure, Objective};

pub(super) const KIND: Kind = Kind {
    key: "angle",
    formula: "angle between the mean normals of two tags, from 0 to 180",
    unit: "deg",
    keys: &[TAG, OTHER_TAG],
    needs_contact: false,
    form: form::<Keys>(),
};

/// |N| over the area below which a tag has no mean normal.
const CLOSED: f64 = 1e-6;

#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Keys {
    on: String,
    to: String,
}

impl Specification for Keys {
    fn build(&self, name: &str, site: &Site) -> Result<Arc<dyn Objective>> {
        let side = |tag: &String| -> Result<Wall> {
            let facets = site.body.facets(tag)?;
            check_normal(&facets, &site.body.mesh.vertices)
                .with_context(|| format!("tag \"{tag}\""))?;
            Ok(Wall::new(site.space, &facets))
        };
        let sides = [side(&self.on)?, side(&self.to)?];
        Ok(Arc::new(Angle { name: name.to_owned(), sides }))
    }
}

/// The normals of a tag must not cancel.
fn check_normal(facets: &[[usize; 3]], rest: &[Vec3]) -> Result<()> {
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

/// The angle between two walls.
struct Angle {
    name: String,
    sides: [Wall; 2],
}

impl Angle {
    /// Adds `weight` ∂q/∂x at the nodes.
    fn add_by_nodes(&self, state: &Equilibrium, weight: f64, out: &mut [f64]) {
        let x = state.nodes(Measure::Deformed);
        let [a, b] = self.sides.each_ref().map(|side| area_vector(side, state.space, &x));
        let Some(across) = a.cross(&b).try_normalize(0.0) else { return };
        let by = [a.cross(&across) / a.norm_squared(), across.cross(&b) / b.norm_squared()];
        for (side, by) in self.sides.iter().zip(by) {
            let constant: Vec<f64> = x.iter().flat_map(|_| [by.x, by.y, by.z]).collect();
            side.add_stiffness_vjp(state.space, |n| x[n], &constant, weight.to_degrees(), out);
        }
    }
}

/// ∫ n da [m²]: minus the force of a unit pressure, which is the gradient of the volume behind.
fn area_vector(wall: &Wall, space: &FunctionSpace, x: &[Vec3]) -> Vec3 {
    let mut pull = vec![0.0; 3 * x.len()];
    wall.add_wall_gradient(space, |n| x[n], -1.0, &mut pull);
    (0..x.len()).map(|n| at(&pull, n)).sum()
}

impl Objective for Angle {
    fn name(&self) -> &str {
        &self.name
    }

    fn value(&self, state: &Equilibrium) -> f64 {
        let x = state.nodes(Measure::Deformed);
        let [a, b] = self.sides.each_ref().map(|side| area_vector(side, state.space, &x));
        a.cross(&b).norm().atan2(a.dot(&b)).to_degrees()
    }

    fn add_du(&self, state: &Equilibrium, weight: f64, out: &mut [f64]) {
        self.add_by_nodes(state, weight, out);
    }

    fn add_drest(&self, state: &Equilibrium, weight: f64, out: &mut [f64]) {
        let mut nodal = vec![0.0; 3 * state.space.node_count()];
        self.add_by_nodes(state, weight, &mut nodal);
        state.space.add_to_vertices(&nodal, out);
    }
}
