//! Distance of a deformed surface to a target surface.
//!
//! J(u, X) = ∫_Γ d̃²(x) dA      x = ΠX + u, dA of the rest shape
//!
//! d̃² is the smoothly interpolated squared distance of
//! [`DistanceField`](super::DistanceField) [m²], so J is in m⁴.
//!
//! Source: Gjoka et al. 2024, equation (16), with the rest measure of the
//! authors' scenes.

use mesh::Vec3;

use super::{DistanceField, Equilibrium, Objective};
use crate::element::{add_at, at};
use crate::parallel::map_merge;

/// Squared distance of one tag to a target surface.
pub struct Target {
    name: String,
    /// Vertex ids and node ids of each facet.
    facets: Vec<([usize; 3], Vec<usize>)>,
    field: DistanceField,
}

/// A quadrature point: position, rest weight, and d̃² with its gradient.
struct Sample {
    weight: f64,
    value: f64,
    gradient: Vec3,
}

impl Target {
    /// The facets (vertex ids, node ids) that should reach the field's zero set.
    #[must_use]
    pub fn new(name: String, facets: Vec<([usize; 3], Vec<usize>)>, field: DistanceField) -> Self {
        Self { name, facets, field }
    }

    /// Evaluates all facets in parallel and hands them over in order.
    fn for_each_facet(&self, at_: &Equilibrium, mut f: impl FnMut(usize, &[Sample])) {
        let nodes = at_.space.node_positions(at_.rest);
        let table = at_.space.facet_table();
        let positions = |facet: usize| {
            let ids = &self.facets[facet].1;
            table.values.iter().map(|values| {
                ids.iter().zip(values).map(|(&n, v)| (nodes[n] + at(at_.u, n)) * *v).sum::<Vec3>()
            })
        };
        let points: Vec<Vec3> = (0..self.facets.len()).flat_map(positions).collect();
        self.field.prepare(&points);
        let per_facet = table.weights.len();
        map_merge(
            self.facets.len(),
            |range| {
                let sample = |facet: usize| {
                    let [a, b, c] = self.facets[facet].0.map(|v| at_.rest[v]);
                    let area = mesh::measure::triangle_area(a, b, c);
                    let one = |q: usize| {
                        let (value, gradient) =
                            self.field.squared_distance(&points[facet * per_facet + q]);
                        Sample { weight: area * table.weights[q], value, gradient }
                    };
                    (0..per_facet).map(one).collect::<Vec<_>>()
                };
                range.map(sample).collect::<Vec<_>>()
            },
            |range, samples| range.zip(&samples).for_each(|(i, s)| f(i, s)),
        );
    }
}

impl Objective for Target {
    fn name(&self) -> &str {
        &self.name
    }

    fn value(&self, at_: &Equilibrium) -> f64 {
        let mut sum = 0.0;
        self.for_each_facet(at_, |_, samples| {
            sum += samples.iter().map(|s| s.weight * s.value).sum::<f64>();
        });
        sum
    }

    fn add_du(&self, at_: &Equilibrium, weight: f64, out: &mut [f64]) {
        let table = at_.space.facet_table();
        self.for_each_facet(at_, |facet, samples| {
            for (s, values) in samples.iter().zip(&table.values) {
                for (node, v) in self.facets[facet].1.iter().zip(values) {
                    add_at(out, *node, &(weight * s.weight * *v * s.gradient));
                }
            }
        });
    }

    fn add_drest(&self, at_: &Equilibrium, weight: f64, out: &mut [f64]) {
        let table = at_.space.facet_table();
        self.for_each_facet(at_, |facet, samples| {
            let vertices = self.facets[facet].0;
            let corners = vertices.map(|v| at_.rest[v]);
            let [a, b, c] = corners;
            let normal = mesh::measure::triangle_normal(a, b, c);
            let area = mesh::measure::triangle_area(a, b, c);
            let density: f64 = samples.iter().map(|s| s.weight * s.value).sum::<f64>() / area;
            for k in 0..3 {
                // ∂A/∂X_k = ½ n × (X_{k+2} − X_{k+1})
                let edge = corners[(k + 2) % 3] - corners[(k + 1) % 3];
                let mut total = density * 0.5 * normal.cross(&edge);
                for (s, point) in samples.iter().zip(&table.points) {
                    total += s.weight * point[k] * s.gradient;
                }
                add_at(out, vertices[k], &(weight * total));
            }
        });
    }
}
