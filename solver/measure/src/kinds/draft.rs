//! Faces that a piece of the mold, or the core, can be pulled off.
//!
//! J = Σ_f A_f max(0, s − n_f·d)²   [m²]
//!
//! A_f, n_f   area and unit normal of a facet at rest, out of the silicone [m², 1]
//! d          unit vector along which the piece that lies on the facets is pulled
//! s          sine of the draft: the least angle between the facets and the pull
//!
//! J is zero where no facet holds the piece back: each leans away from the pull by the draft at
//! least. A piece that gets past its own facets may still hit others further along the pull, which
//! `fab plan` finds. With a_f = A_f n_f, the area vector, and m = s − n·d > 0,
//!
//! ∂(A m²)/∂a = m² n − 2 m (d − (n·d) n)
//!
//! J of a part of a symmetric body is that part's share.

use std::sync::Arc;

use anyhow::{Result, ensure};
use mechanics::element::add_at;
use mesh::Vec3;
use program::{KeyPath, misfit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::quantity::{Kind, List, Quantity, RestTerm, Site, Specification};
use crate::written::Names;

pub(super) const KIND: Kind = Kind {
    key: "draft",
    formula: "Σ A max(0, draft − n·d)² over facets of area A with the normal n, at rest",
    unit: "m²",
    example: "on = 'top'\npull = [0, 1, 1]\ndraft = 0.9",
    ..Kind::of::<Keys>(&[List::Objective])
};

#[derive(Debug, Serialize, Deserialize, JsonSchema)]
struct Keys {
    /// tag, body, or list of them
    on: Names,
    /// d: the way in which the core, or a piece of the mold, is pulled off them
    pull: [f64; 3],
    /// sine of the angle by which they must lean away from it (0)
    #[serde(default)]
    draft: f64,
}

impl Specification for Keys {
    fn check(&self) -> Result<()> {
        let length = Vec3::from(self.pull).norm();
        ensure!(
            length.is_finite() && length > 0.0,
            misfit!(KeyPath::of("pull"), " = {:?}: must have a direction", self.pull)
        );
        ensure!(
            (0.0..1.0).contains(&self.draft),
            misfit!(KeyPath::of("draft"), " = {}: must be at least 0 and below 1", self.draft)
        );
        Ok(())
    }

    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        let pull = Vec3::from(self.pull);
        Ok(Arc::new(Draft::new(site.facets(&self.on)?, pull, self.draft)))
    }
}

/// Penalty on facets that hold back what is pulled off them.
pub struct Draft {
    facets: Vec<[usize; 3]>,
    pull: Vec3,
    draft: f64,
}

impl Draft {
    /// The term on facets, oriented out of the silicone, for a direction of the pull.
    #[must_use]
    pub fn new(facets: Vec<[usize; 3]>, pull: Vec3, draft: f64) -> Self {
        Self { facets, pull: pull.normalize(), draft }
    }

    /// max(0, s − n·d) of an area vector.
    fn lack(&self, area: &Vec3) -> f64 {
        (self.draft - area.dot(&self.pull) / area.norm().max(f64::MIN_POSITIVE)).max(0.0)
    }
}

fn area_vector(rest: &[Vec3], [a, b, c]: [usize; 3]) -> Vec3 {
    0.5 * (rest[b] - rest[a]).cross(&(rest[c] - rest[a]))
}

impl RestTerm for Draft {
    fn value_at(&self, rest: &[Vec3]) -> f64 {
        let one = |&facet| {
            let area = area_vector(rest, facet);
            area.norm() * self.lack(&area).powi(2)
        };
        self.facets.iter().map(one).sum()
    }

    fn add_gradient_at(&self, rest: &[Vec3], weight: f64, out: &mut [f64]) {
        for &facet in &self.facets {
            let area = area_vector(rest, facet);
            let (m, n) = (self.lack(&area), area / area.norm().max(f64::MIN_POSITIVE));
            let across = self.pull - n.dot(&self.pull) * n;
            let by_area = weight * (m * m * n - 2.0 * m * across);
            for k in 0..3 {
                // a = ½ Σ X_k × X_{k+1}
                let opposite = rest[facet[(k + 1) % 3]] - rest[facet[(k + 2) % 3]];
                add_at(out, facet[k], &(0.5 * opposite.cross(&by_area)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use mechanics::testing::sphere;

    use super::*;
    use crate::quantity::tests::Case;

    /// ∫ (s − cos θ)² dA over the part of the unit sphere where cos θ < s:
    /// 2π (1 + s)³/3.
    #[test]
    fn of_a_sphere_it_is_the_closed_form() {
        let ball = sphere(5);
        for draft in [0.0, 0.3] {
            let pull = Vec3::new(0.3, -0.4, 2.0);
            let found = Draft::new(ball.triangles.clone(), pull, draft).value_at(&ball.vertices);
            let expected = std::f64::consts::TAU * (1.0 + draft).powi(3) / 3.0;
            assert!((found / expected - 1.0).abs() < 3e-3, "{found}, {expected}");
        }
    }

    #[test]
    fn a_cube_holds_back_with_the_face_against_the_pull_and_the_sides_without_draft() {
        let case = Case::cube(1, 1.0);
        let value =
            |draft: f64| Draft::new(case.facets.clone(), Vec3::z(), draft).value_at(&case.rest);
        assert!((value(0.0) - 1.0).abs() < 1e-12, "{}", value(0.0));
        assert!((value(0.1) - (1.21 + 4.0 * 0.01)).abs() < 1e-12, "{}", value(0.1));
    }

    #[test]
    fn derivatives_belong_to_the_value() {
        for (degree, scale) in [(1, 1.0), (2, 1e-2)] {
            let case = Case::cube(degree, scale);
            case.check(&Draft::new(case.facets.clone(), Vec3::new(0.2, 0.1, 1.0), 0.2));
        }
    }
}
