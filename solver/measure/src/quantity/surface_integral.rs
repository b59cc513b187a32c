//! Integrals over a part of the surface.
//!
//! J = ∫ j(X, u, t) dA        dA = ½ |g₁ × g₂| dξ,  g_α = ∂x/∂ξ_α
//!
//! with x = ΠX (rest measure) or x = ΠX + u (deformed measure). With n the unit
//! normal and φ_b the basis,
//!
//! ∂|g₁ × g₂|/∂x_b = ∂₁φ_b (g₂ × n) + ∂₂φ_b (n × g₁)
//!
//! which goes to the rest vertices by Πᵀ, and in the deformed measure to u, too.

use mechanics::element::{FunctionSpace, add_at, at};
use mechanics::parallel::map_merge;
use mesh::Vec3;

use super::{Equilibrium, Measure, Partials};

/// A point of the surface.
pub struct Place {
    /// X [m].
    pub rest: Vec3,
    /// u [m].
    pub u: Vec3,
}

impl Place {
    /// X + u [m].
    pub fn x(&self) -> Vec3 {
        self.rest + self.u
    }
}

/// j with its derivatives.
pub struct Density {
    /// j.
    pub value: f64,
    /// ∂j/∂u.
    pub by_u: Vec3,
    /// ∂j/∂X at fixed u.
    pub by_rest: Vec3,
}

/// j at a point.
pub type Integrand<'a> = &'a (dyn Fn(&Place) -> Density + Sync);

/// Facets to integrate over.
pub struct Patch {
    /// Node ids of each facet.
    facets: Vec<Vec<usize>>,
    measure: Measure,
}

/// J of one facet, with its derivatives by the facet's nodes.
struct Part {
    value: f64,
    by_u: Vec<Vec3>,
    by_rest: Vec<Vec3>,
}

impl Patch {
    /// The integral over boundary facets (vertex ids) of a space.
    ///
    /// # Panics
    /// When a facet is none of the space.
    pub fn new(space: &FunctionSpace, facets: &[[usize; 3]], measure: Measure) -> Self {
        Self { facets: facets.iter().map(|&f| space.facet_nodes(f)).collect(), measure }
    }

    /// All points with their shares of the area [m²].
    pub fn points(&self, equilibrium: &Equilibrium) -> Vec<(Place, f64)> {
        let table = equilibrium.space.facet_table();
        let rest = equilibrium.nodes(Measure::Rest);
        let of_facet = |nodes: &Vec<usize>| -> Vec<(Place, f64)> {
            let (rest, u) = (gather(nodes, |n| rest[n]), gather(nodes, |n| at(equilibrium.u, n)));
            let point = |(q, weight): (usize, &f64)| {
                let [g1, g2] = self.tangents(&rest, &u, &table.gradients[q]);
                let place = place(&rest, &u, &table.values[q]);
                (place, 0.5 * weight * g1.cross(&g2).norm())
            };
            table.weights.iter().enumerate().map(point).collect()
        };
        self.facets.iter().flat_map(of_facet).collect()
    }

    /// Deformed positions of all points [m].
    pub fn positions(&self, equilibrium: &Equilibrium) -> Vec<Vec3> {
        let nodes = equilibrium.nodes(Measure::Deformed);
        let table = equilibrium.space.facet_table();
        let of_facet = |facet: &Vec<usize>| -> Vec<Vec3> {
            let sum =
                |values: &Vec<f64>| facet.iter().zip(values).map(|(&n, v)| nodes[n] * *v).sum();
            table.values.iter().map(sum).collect()
        };
        self.facets.iter().flat_map(of_facet).collect()
    }

    /// J.
    pub fn value(&self, equilibrium: &Equilibrium, j: Integrand) -> f64 {
        let mut sum = 0.0;
        self.for_each_part(equilibrium, j, |_, part| sum += part.value);
        sum
    }

    /// Adds `weight` times the partial derivatives of J.
    pub fn add_partials(&self, at: &Equilibrium, j: Integrand, weight: f64, out: &mut Partials) {
        let mut nodal = vec![0.0; 3 * at.space.node_count()];
        self.for_each_part(at, j, |nodes, part| {
            for ((&n, by_u), by_rest) in nodes.iter().zip(&part.by_u).zip(&part.by_rest) {
                add_at(out.u, n, &(weight * by_u));
                add_at(&mut nodal, n, &(weight * by_rest));
            }
        });
        at.space.add_to_vertices(&nodal, out.rest);
    }

    /// Evaluates all facets in parallel and passes them to `f` in order.
    fn for_each_part(
        &self,
        equilibrium: &Equilibrium,
        j: Integrand,
        mut f: impl FnMut(&[usize], &Part),
    ) {
        let rest = equilibrium.nodes(Measure::Rest);
        let part = |range: std::ops::Range<usize>| -> Vec<Part> {
            self.facets[range].iter().map(|nodes| self.part(equilibrium, &rest, nodes, j)).collect()
        };
        map_merge(self.facets.len(), part, |range, parts| {
            self.facets[range].iter().zip(&parts).for_each(|(nodes, part)| f(nodes, part));
        });
    }

    fn part(
        &self,
        equilibrium: &Equilibrium,
        rest: &[Vec3],
        nodes: &[usize],
        j: Integrand,
    ) -> Part {
        let table = equilibrium.space.facet_table();
        let (rest, u) = (gather(nodes, |n| rest[n]), gather(nodes, |n| at(equilibrium.u, n)));
        let moves = self.moves();
        let zero = || vec![Vec3::zeros(); nodes.len()];
        let mut part = Part { value: 0.0, by_u: zero(), by_rest: zero() };
        for (q, weight) in table.weights.iter().enumerate() {
            let (values, slopes) = (&table.values[q], &table.gradients[q]);
            let [g1, g2] = self.tangents(&rest, &u, slopes);
            let normal = g1.cross(&g2);
            let area = normal.norm();
            let normal = normal / area.max(f64::MIN_POSITIVE);
            let Density { value, by_u, by_rest } = j(&place(&rest, &u, values));
            let weight = 0.5 * weight;
            part.value += weight * area * value;
            let (side1, side2) = (g2.cross(&normal), normal.cross(&g1));
            for b in 0..nodes.len() {
                let by_area = weight * value * (slopes[b][0] * side1 + slopes[b][1] * side2);
                let share = weight * area * values[b];
                part.by_u[b] += share * by_u + moves * by_area;
                part.by_rest[b] += share * by_rest + by_area;
            }
        }
        part
    }

    /// Tangents of a facet, of the shape that the measure is of, from the slopes of its basis.
    fn tangents(&self, rest: &[Vec3], u: &[Vec3], slopes: &[[f64; 3]]) -> [Vec3; 2] {
        let moves = self.moves();
        [0, 1].map(|k| {
            let x = rest.iter().zip(u).map(|(x, u)| x + moves * u);
            x.zip(slopes).map(|(x, d)| x * d[k]).sum()
        })
    }

    /// 1 where the measure moves with u, else 0.
    fn moves(&self) -> f64 {
        f64::from(u8::from(self.measure == Measure::Deformed))
    }
}

fn gather(nodes: &[usize], of: impl Fn(usize) -> Vec3) -> Vec<Vec3> {
    nodes.iter().map(|&n| of(n)).collect()
}

/// The point of a facet with these values of its basis.
fn place(rest: &[Vec3], u: &[Vec3], values: &[f64]) -> Place {
    let sum = |of: &[Vec3]| of.iter().zip(values).map(|(x, v)| x * *v).sum::<Vec3>();
    Place { rest: sum(rest), u: sum(u) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::tests::Case;

    /// The area of the cube's boundary, at rest and stretched by 2, 3 and 5.
    #[test]
    fn areas_are_of_the_shape_that_was_asked_for() {
        for degree in 1..=3 {
            let mut case = Case::cube(degree, 1.0);
            let nodes = case.space.node_positions(&case.rest);
            for (n, x) in nodes.iter().enumerate() {
                case.u[3 * n..3 * n + 3].copy_from_slice(&[x.x, 2.0 * x.y, 4.0 * x.z]);
            }
            let zero = Vec3::zeros();
            let one = |_: &Place| Density { value: 1.0, by_u: zero, by_rest: zero };
            let area =
                |measure| Patch::new(&case.space, &case.facets, measure).value(&case.at(), &one);
            assert!((area(Measure::Rest) - 6.0).abs() < 1e-13);
            assert!((area(Measure::Deformed) - 2.0 * (6.0 + 10.0 + 15.0)).abs() < 1e-12);
        }
    }
}
