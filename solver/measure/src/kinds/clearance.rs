//! Barrier against self-contact of the rest surface.
//!
//! J = Σ_k m_k b(d_k², d̂²)
//!
//! d_k   distance of pair k of features of the surface without a common
//!       vertex [m]
//! m_k   parallel-edge mollifier, one for vertex–triangle pairs [1]
//! d̂     activation distance [m]
//! b     log barrier of [`density`](mechanics::contact::density) [m⁴]
//!
//! J is in m⁴: with d̂ = 5·10⁻⁵ m and weight one, as in the published scenes, it
//! is about 10⁻¹⁷ and only its becoming infinite matters. Facets that have
//! already passed through each other are not detected here: a design checks its shapes for that.
//!
//! Where planes of symmetry cut the body, the surface is that of the whole, and J is the
//! body's share of it.
//!
//! Source: Li et al. 2020, doi:10.1145/3386569.3392425, applied to the rest shape.

use mechanics::contact::candidates::close_within;
use mechanics::contact::density::{Density, Repulsion};
use mechanics::contact::images::Mirrored;
use mechanics::contact::pairs::{Features, Pair};
use mechanics::contact::rest_potential;
use mechanics::symmetry::Plane;

use super::*;
use crate::quantity::RestTerm;

pub(super) const KIND: Kind = Kind {
    key: "clearance",
    formula: "log barrier between parts of the rest surface that are not neighbours",
    unit: "m⁴",
    example: "activation = 0.6",
    ..Kind::of::<Keys>(&[List::Objective])
};

#[derive(Debug, Serialize, Deserialize, JsonSchema)]
struct Keys {
    /// distance below which it acts [m]
    activation: f64,
}

impl Specification for Keys {
    fn check(&self) -> Result<()> {
        positive("activation", self.activation)
    }

    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        let boundary = site.body.boundary();
        Ok(Arc::new(Clearance::new(&site.body.planes, boundary, self.activation)))
    }
}

/// Barrier between parts of one surface.
pub struct Clearance {
    whole: Mirrored,
    surface: Features,
    repulsion: Repulsion,
}

impl Clearance {
    /// The term of a set of facets, usually the whole boundary, that acts below
    /// `activation` [m].
    pub fn new(planes: &[Plane], facets: &[[usize; 3]], activation: f64) -> Self {
        let repulsion = Repulsion { density: Density::Log, minimum: 0.0, activation };
        let (whole, sets) = Mirrored::new(planes, &[facets.to_vec()]);
        Self { whole, surface: Features::new(&sets[0]), repulsion }
    }

    /// Pairs at positions of the whole.
    fn pairs(&self, x: &[Vec3]) -> Vec<Pair> {
        close_within(&self.surface, x, self.repulsion.range())
    }
}

impl RestTerm for Clearance {
    fn admit(&self, rest: &[Vec3]) -> Result<(), String> {
        let x = self.whole.positions(rest);
        let pairs = self.pairs(&x);
        let touches = |p: &&Pair| self.repulsion.is_violated(p.closest(&p.gather(&x)).d2);
        let Some(first) = pairs.iter().find(touches) else { return Ok(()) };
        let p = x[first.corners()[0]];
        Err(format!(
            "{} pairs of the rest surface touch, the first at ({:.5}, {:.5}, {:.5}) m",
            pairs.iter().filter(touches).count(),
            p.x,
            p.y,
            p.z
        ))
    }

    fn value_at(&self, rest: &[Vec3]) -> f64 {
        let x = self.whole.positions(rest);
        self.whole.share() * rest_potential::value(&self.pairs(&x), &x, &self.repulsion)
    }

    fn add_gradient_at(&self, rest: &[Vec3], weight: f64, out: &mut [f64]) {
        let x = self.whole.positions(rest);
        let (weight, mut by_x) = (weight * self.whole.share(), vec![0.0; 3 * x.len()]);
        rest_potential::add_gradient(&self.pairs(&x), &x, &self.repulsion, weight, &mut by_x);
        self.whole.add_to_vertices(&by_x, out);
    }
}

#[cfg(test)]
mod tests {
    use mechanics::testing::square;

    use super::*;

    #[test]
    fn a_flat_sheet_costs_nothing_and_touching_is_infinite() {
        let sheet = square(6, 0.0);
        let term = Clearance::new(&[], &sheet.triangles, 0.05);
        assert!(term.value_at(&sheet.vertices) == 0.0);
        let mut folded = sheet.vertices;
        let (first, last) = (0, folded.len() - 1);
        folded[first] = folded[last];
        assert!(term.value_at(&folded).is_infinite());
    }
}
