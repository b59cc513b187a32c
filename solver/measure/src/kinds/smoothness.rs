//! Smoothness of a part of the rest surface.
//!
//! scale invariant   J = Σ_v |S_v / ℓ_v|²       [1]
//! plain             J = Σ_v |S_v / n_v|²       [m²]
//!
//! S_v = Σ_w (X_v − X_w)   over the n_v neighbours w of v along edges [m]
//! ℓ_v = Σ_w |X_v − X_w|   [m]
//!
//! Neighbours are those within the chosen facets, so that a vertex on the rim
//! has neighbours on one side only. In a plane of symmetry it has their mirror images, too, and
//! counts for its share of the whole: 1/2 in one plane, 1/4 in two. With P, which sets to zero
//! the components across the planes of v, S_v = Σ_w m_w P (X_v − X_w), where w and its images
//! are m_w vertices; so for ℓ_v and n_v. The scale-invariant form does not change with the size
//! of the model; both change with the number of vertices, and with them the
//! balance to other terms.
//!
//! Source: Huang et al., "Differentiable solver for time-dependent deformation
//! problems with contact", arXiv:2205.13643, scale-invariant smoothing.

use mechanics::symmetry::Plane;
use mesh::topology;
use program::Names;

use super::*;

pub(super) const KIND: Kind = Kind {
    key: "smoothness",
    unit: "1 or m²",
    example: "on = 'top'\nform = 'plain'",
    ..Kind::of::<Keys>(&[List::Objective])
};

program::table! {
    /// Σ_v |Σ_w (X_v − X_w)|² / (Σ_w |X_v − X_w|)², plain: over the number of w
    #[derive(Debug)]
    struct Keys {
        /// tag, body, or list of them
        on: Names;
        /// "scale-invariant" or "plain"
        form: SmoothnessForm = SmoothnessForm::ScaleInvariant;
    }
}

impl Specification for Keys {
    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        let facets = site.facets(&self.on)?;
        Ok(Arc::new(Smoothness::new(&facets, &site.body.planes, self.form)))
    }
}

/// How the neighbour vector is normalised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SmoothnessForm {
    /// By the sum of the edge lengths.
    ScaleInvariant,
    /// By the number of edges.
    Plain,
}

/// Penalty on vertices away from the middle of their neighbours.
pub struct Smoothness {
    form: SmoothnessForm,
    /// By ascending vertex ids.
    stars: Vec<Star>,
}

/// A vertex with its neighbours.
struct Star {
    vertex: usize,
    /// Vertex ids, each with the number m of the vertices that it and its images are.
    neighbours: Vec<(usize, f64)>,
    /// The diagonal of P.
    along: Vec3,
    /// Share of the vertex in the whole.
    share: f64,
}

impl Star {
    fn new(vertex: usize, neighbours: impl Iterator<Item = usize>, planes: &[Plane]) -> Self {
        let of_vertex = || planes.iter().filter(|plane| plane.contains(vertex));
        let mut along = Vec3::repeat(1.0);
        of_vertex().for_each(|plane| along[plane.axis] = 0.0);
        let images =
            |w: usize| of_vertex().map(|p| if p.contains(w) { 1.0 } else { 2.0 }).product();
        let share = of_vertex().map(|_| 0.5).product();
        Self { vertex, neighbours: neighbours.map(|w| (w, images(w))).collect(), along, share }
    }
}

impl Smoothness {
    /// The term on a set of facets.
    pub fn new(facets: &[[usize; 3]], planes: &[Plane], form: SmoothnessForm) -> Self {
        let mut sides: Vec<[usize; 2]> =
            topology::edge_facets(facets).into_keys().flat_map(|[a, b]| [[a, b], [b, a]]).collect();
        sides.sort_unstable();
        let stars = sides
            .chunk_by(|a, b| a[0] == b[0])
            .map(|star| Star::new(star[0][0], star.iter().map(|side| side[1]), planes))
            .collect();
        Self { form, stars }
    }

    /// S_v, and the length or number it is divided by.
    fn neighbour_vector(&self, rest: &[Vec3], star: &Star) -> (Vec3, f64) {
        let edge = |w: usize| rest[star.vertex] - rest[w];
        let neighbours = || star.neighbours.iter();
        let sum: Vec3 = neighbours().map(|&(w, images)| images * edge(w)).sum();
        let length = match self.form {
            SmoothnessForm::ScaleInvariant => {
                let total: f64 = neighbours().map(|&(w, images)| images * edge(w).norm()).sum();
                total.max(f64::MIN_POSITIVE)
            }
            SmoothnessForm::Plain => neighbours().map(|&(_, images)| images).sum(),
        };
        (sum.component_mul(&star.along), length)
    }

    fn value_at(&self, rest: &[Vec3]) -> f64 {
        let one = |star: &Star| {
            let (sum, length) = self.neighbour_vector(rest, star);
            star.share * (sum / length).norm_squared()
        };
        self.stars.iter().map(one).sum()
    }

    fn add_gradient_at(&self, rest: &[Vec3], weight: f64, out: &mut [f64]) {
        for star in &self.stars {
            let (sum, length) = self.neighbour_vector(rest, star);
            let (v, s) = (star.vertex, sum / length);
            for &(w, images) in &star.neighbours {
                // ∂ℓ/∂X_v of one edge; the plain form divides by a constant
                let unit = match self.form {
                    SmoothnessForm::ScaleInvariant => {
                        (rest[v] - rest[w]).try_normalize(0.0).unwrap_or_default()
                    }
                    SmoothnessForm::Plain => Vec3::zeros(),
                };
                let scale = star.share * images * (2.0 * weight / length);
                // s has no part across the planes
                let g = scale * (s - s.norm_squared() * unit);
                for k in 0..3 {
                    out[3 * v + k] += g[k];
                    out[3 * w + k] -= g[k];
                }
            }
        }
    }
}

impl Quantity for Smoothness {
    fn value(&self, at: &Equilibrium) -> f64 {
        self.value_at(at.rest)
    }

    fn add_partials(&self, at: &Equilibrium, weight: f64, out: &mut Partials) {
        self.add_gradient_at(at.rest, weight, out.rest);
    }
}

#[cfg(test)]
mod tests {
    use mechanics::testing::{sphere, square};

    use super::*;

    #[test]
    fn a_regular_patch_is_smooth_inside_and_the_size_does_not_matter() {
        let surface = square(6, 0.0);
        let inner: Vec<[usize; 3]> = surface.triangles.clone();
        let term = Smoothness::new(&inner, &[], SmoothnessForm::ScaleInvariant);
        let mut gradient = vec![0.0; 3 * surface.vertices.len()];
        term.add_gradient_at(&surface.vertices, 1.0, &mut gradient);
        // a vertex two rings inside feels neither the rim nor its neighbours
        let middle = 3 * 7 + 3;
        assert!(gradient[3 * middle..3 * middle + 3].iter().all(|g| g.abs() < 1e-13));

        let ball = sphere(2);
        let term = Smoothness::new(&ball.triangles, &[], SmoothnessForm::ScaleInvariant);
        let large: Vec<Vec3> = ball.vertices.iter().map(|v| v * 1e3).collect();
        let (a, b) = (term.value_at(&ball.vertices), term.value_at(&large));
        assert!(a > 0.0 && (a - b).abs() < 1e-12 * a);
    }
}
