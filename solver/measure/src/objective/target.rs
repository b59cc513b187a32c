//! Distance of a deformed surface to a target surface.
//!
//! J(u, X) = ∫_Γ d̃²(x) dA      x = ΠX + u
//!
//! d̃² is the smoothly interpolated squared distance of
//! [`DistanceField`](super::DistanceField) [m²], so J is in m⁴.
//!
//! Source: Gjoka et al. 2024, equation (16); the published scenes have the rest
//! measure.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, ensure};
use mesh::SurfaceMesh;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::kind::{Builder, Kind, MEASURE, Specification, TAGS, form, positive};
use super::surface_integral::{Density, Patch, Place};
use super::{DistanceField, DistanceKind, Equilibrium, Measure, Objective};
use crate::written::Names;

pub(super) const KIND: Kind = Kind {
    key: "target",
    formula: "∫ d̃²(x) dA, d̃ the distance of deformed points to a surface",
    unit: "m⁴",
    keys: &[
        TAGS,
        ("target", "surface file in metres"),
        ("distance", "\"squared\" (default), \"unsigned\" (published), \"signed\" (closed target)"),
        ("spacing", "of the distance's lattice [m] (1e-3)"),
        MEASURE,
    ],
    may_be_maximised: false,
    needs_contact: false,
    form: form::<Keys>(),
};

#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Keys {
    on: Names,
    target: PathBuf,
    #[serde(default)]
    distance: DistanceKind,
    #[serde(default = "a_millimetre")]
    spacing: f64,
    #[serde(default)]
    measure: Measure,
}

fn a_millimetre() -> f64 {
    1e-3
}

impl Specification for Keys {
    fn check(&self) -> Result<()> {
        positive("spacing", self.spacing)
    }

    fn files(&self) -> Vec<&Path> {
        vec![&self.target]
    }

    /// The distance field is made once and shared by all bodies.
    fn prepare(&self, folder: &Path) -> Result<Builder> {
        let path = folder.join(&self.target);
        let surface = mesh::io::read_surface(&path)?;
        check_target(&surface, self.distance).with_context(|| path.display().to_string())?;
        let field = DistanceField::new(&surface, self.spacing, self.distance);
        let (on, measure) = (self.on.clone(), self.measure);
        Ok(Box::new(move |name, bodies| {
            let patch = Patch::new(bodies.space, &bodies.facets(&on)?, measure);
            Ok(Box::new(Target::new(name, patch, field.clone())))
        }))
    }
}

/// The signed distance needs an inside.
fn check_target(surface: &SurfaceMesh, distance: DistanceKind) -> Result<()> {
    let rim = mesh::topology::boundary_edges(&surface.triangles).len();
    ensure!(
        distance != DistanceKind::Signed || rim == 0,
        "{rim} edges on the rim of an open surface, which has no inside: distance = \"signed\" \
         needs a closed target; take \"squared\""
    );
    let volume = mesh::measure::enclosed_volume(surface);
    ensure!(
        distance != DistanceKind::Signed || volume > 0.0,
        "the triangles face inwards (volume {volume:.3e} m³): distance = \"signed\" needs a \
         target that faces outwards; turn its triangles around"
    );
    Ok(())
}

/// Squared distance of a part of the surface to a target surface.
pub struct Target {
    name: String,
    patch: Patch,
    field: DistanceField,
}

impl Target {
    /// The patch that should reach the field's zero set.
    #[must_use]
    pub fn new(name: &str, patch: Patch, field: DistanceField) -> Self {
        Self { name: name.to_owned(), patch, field }
    }

    fn density(&self, place: &Place) -> Density {
        let (value, gradient) = self.field.squared_distance(&place.x());
        Density { value, by_u: gradient, by_rest: gradient }
    }

    /// Makes ready for all points at once.
    fn prepare(&self, at: &Equilibrium) {
        self.field.prepare(&self.patch.positions(at));
    }
}

impl Objective for Target {
    fn name(&self) -> &str {
        &self.name
    }

    fn value(&self, at: &Equilibrium) -> f64 {
        self.prepare(at);
        self.patch.value(at, &|place| self.density(place))
    }

    fn add_du(&self, at: &Equilibrium, weight: f64, out: &mut [f64]) {
        self.prepare(at);
        self.patch.add_du(at, &|place| self.density(place), weight, out);
    }

    fn add_drest(&self, at: &Equilibrium, weight: f64, out: &mut [f64]) {
        self.prepare(at);
        self.patch.add_drest(at, &|place| self.density(place), weight, out);
    }
}

#[cfg(test)]
mod tests {
    use mechanics::testing::sphere;

    use super::*;
    use crate::objective::tests::Case;

    #[test]
    fn derivatives_belong_to_the_value() {
        for (degree, scale) in [(1, 1.0), (2, 1.0), (2, 1e-3), (3, 1e-3)] {
            let case = Case::cube(degree, scale);
            let mut ball = sphere(2);
            ball.vertices.iter_mut().for_each(|v| *v *= 0.8 * scale);
            for kind in [DistanceKind::Squared, DistanceKind::Unsigned, DistanceKind::Signed] {
                for measure in [Measure::Rest, Measure::Deformed] {
                    let field = DistanceField::new(&ball, 0.4 * scale, kind);
                    let patch = Patch::new(&case.space, &case.facets, measure);
                    // d̃² is once continuously differentiable: small steps keep
                    // within one cell of its lattice, or cross few of its sides
                    case.check(&Target::new("t", patch, field));
                }
            }
        }
    }
}
