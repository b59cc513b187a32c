//! det ∂x/∂ξ over a whole element as a polynomial in Bernstein form.
//!
//! x(λ) = Σ_α b_α B_α(λ),  B_α = (p!/α!) λ^α,  |α| = p
//! ∂x/∂ξ_k = p Σ_β (b_{β+e_k} − b_{β+e_0}) B_β,  |β| = p − 1
//! B_α B_β = [C(α) C(β) / C(α + β)] B_{α+β},  C(α) = |α|!/α!
//!
//! so that det ∂x/∂ξ has degree 3(p − 1): 1, 20 and 84 coefficients for p = 1,
//! 2 and 3. The polynomial lies between its smallest and its largest
//! coefficient, and equals the coefficients at the corners.
//!
//! Source: Farin, "Curves and Surfaces for CAGD", chapter on Bézier triangles;
//! as a test of elements: Johnen, Remacle and Geuzaine 2013,
//! doi:10.1016/j.jcp.2012.08.051.

use std::collections::BTreeMap;

use mesh::Vec3;
use nalgebra::DMatrix;

use super::basis::nodes;

type Index = [usize; 4];

/// Multi-indices of a degree and their places in a list of coefficients.
struct Net {
    indices: Vec<Index>,
    place: BTreeMap<Index, usize>,
}

impl Net {
    fn new(degree: usize) -> Self {
        let mut indices = Vec::new();
        for a in 0..=degree {
            for b in 0..=degree - a {
                for c in 0..=degree - a - b {
                    indices.push([degree - a - b - c, a, b, c]);
                }
            }
        }
        let place = indices.iter().enumerate().map(|(i, &index)| (index, i)).collect();
        Self { indices, place }
    }
}

/// C(α) = |α|!/α!
fn multinomial(index: Index) -> f64 {
    let factorial = |n: usize| (1..=n).map(|k| k as f64).product::<f64>();
    factorial(index.iter().sum()) / index.iter().map(|&i| factorial(i)).product::<f64>()
}

fn add(a: Index, b: Index) -> Index {
    std::array::from_fn(|k| a[k] + b[k])
}

/// Places of two factors and of their product, and its weight.
struct Term {
    first: usize,
    second: usize,
    product: usize,
    weight: f64,
}

fn product(first: &Net, second: &Net, result: &Net) -> Vec<Term> {
    let mut terms = Vec::new();
    for (i, &a) in first.indices.iter().enumerate() {
        for (j, &b) in second.indices.iter().enumerate() {
            let sum = add(a, b);
            let weight = multinomial(a) * multinomial(b) / multinomial(sum);
            terms.push(Term { first: i, second: j, product: result.place[&sum], weight });
        }
    }
    terms
}

/// How to get the Bernstein coefficients of det ∂x/∂ξ from nodal positions of a
/// degree, and how to refine them.
pub struct JacobianForm {
    /// Control points from nodal positions.
    control: DMatrix<f64>,
    /// Control points (β + e_k) of the derivatives, k = 0 … 3.
    raised: Vec<[usize; 4]>,
    degree: f64,
    crosses: Vec<Term>,
    cross_count: usize,
    dots: Vec<Term>,
    net: Net,
}

impl JacobianForm {
    /// For elements of a degree.
    pub fn new(degree: usize) -> Self {
        let (points, slopes) = (Net::new(degree), Net::new(degree - 1));
        let (cross, net) = (Net::new(2 * (degree - 1)), Net::new(3 * (degree - 1)));
        let places = nodes(4, degree);
        let values = DMatrix::from_fn(places.len(), places.len(), |a, i| {
            let index = points.indices[i];
            let lambda = |k: usize| places[a][k] as f64 / degree as f64;
            let monomial: f64 = (0..4).map(|k| lambda(k).powi(index[k] as i32)).product();
            multinomial(index) * monomial
        });
        let unit = |k: usize| std::array::from_fn(|c| usize::from(c == k));
        Self {
            control: values.try_inverse().expect("nodes of a simplex lattice are unisolvent"),
            raised: slopes
                .indices
                .iter()
                .map(|&b| std::array::from_fn(|k| points.place[&add(b, unit(k))]))
                .collect(),
            degree: degree as f64,
            crosses: product(&slopes, &slopes, &cross),
            cross_count: cross.indices.len(),
            dots: product(&cross, &slopes, &net),
            net,
        }
    }

    /// Coefficients of det ∂x/∂ξ for nodal positions [m³].
    pub fn coefficients(&self, x: &[Vec3]) -> Vec<f64> {
        let control: Vec<Vec3> = (0..x.len())
            .map(|i| x.iter().enumerate().map(|(a, x)| self.control[(i, a)] * x).sum())
            .collect();
        let slope = |k: usize| -> Vec<Vec3> {
            let along = |r: &[usize; 4]| self.degree * (control[r[k]] - control[r[0]]);
            self.raised.iter().map(along).collect()
        };
        let (d1, d2, d3) = (slope(1), slope(2), slope(3));
        let mut cross = vec![Vec3::zeros(); self.cross_count];
        for t in &self.crosses {
            cross[t.product] += t.weight * d1[t.first].cross(&d2[t.second]);
        }
        let mut result = vec![0.0; self.net.indices.len()];
        for t in &self.dots {
            result[t.product] += t.weight * cross[t.first].dot(&d3[t.second]);
        }
        result
    }

    /// Place of the coefficient at a corner, which is the value there.
    pub fn corner(&self, corner: usize) -> usize {
        let degree = self.net.indices[0][0];
        self.net.place[&std::array::from_fn(|c| if c == corner { degree } else { 0 })]
    }

    /// Coefficients on the half of the simplex whose corner `moved` goes to the
    /// middle of its edge to the corner `kept` (de Casteljau): averages r times
    /// along the edge where γ_moved = r.
    pub fn half(&self, coefficients: &[f64], kept: usize, moved: usize) -> Vec<f64> {
        let one = |index: &Index| {
            let r = index[moved];
            let (mut sum, mut binomial) = (0.0, 0.5_f64.powi(r as i32));
            for s in 0..=r {
                let mut source = *index;
                source[moved] -= s;
                source[kept] += s;
                sum += binomial * coefficients[self.net.place[&source]];
                binomial *= (r - s) as f64 / (s + 1) as f64;
            }
            sum
        };
        self.net.indices.iter().map(one).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::basis::tabulate;
    use super::super::quadrature;
    use super::*;
    use crate::math::random::Random;
    use crate::math::tensor::Mat3;

    /// Σ c_γ B_γ(λ)
    fn evaluate(form: &JacobianForm, coefficients: &[f64], lambda: &[f64]) -> f64 {
        let bernstein = |index: &Index| {
            multinomial(*index) * (0..4).map(|k| lambda[k].powi(index[k] as i32)).product::<f64>()
        };
        form.net.indices.iter().zip(coefficients).map(|(i, c)| bernstein(i) * c).sum()
    }

    fn random_nodes(degree: usize) -> Vec<Vec3> {
        let mut random = Random::new(21);
        let place = |n: Vec<usize>| Vec3::new(n[1] as f64, n[2] as f64, n[3] as f64);
        nodes(4, degree).into_iter().map(|n| place(n) + 0.4 * random.vector()).collect()
    }

    #[test]
    fn the_form_equals_the_determinant_everywhere() {
        for degree in 1..=3 {
            let form = JacobianForm::new(degree);
            let x = random_nodes(degree);
            let coefficients = form.coefficients(&x);
            assert_eq!(coefficients.len(), [1, 20, 84][degree - 1]);
            let table = tabulate(degree, &quadrature::tetrahedron(7));
            for (point, gradients) in table.points.iter().zip(&table.gradients) {
                let column = |k: usize| x.iter().zip(gradients).map(|(x, g)| x * g[k]).sum();
                let jacobian = Mat3::from_columns(&[column(0), column(1), column(2)]);
                let value = evaluate(&form, &coefficients, point);
                assert!((value - jacobian.determinant()).abs() < 1e-11);
            }
        }
    }

    #[test]
    fn halves_hold_the_same_polynomial() {
        let form = JacobianForm::new(3);
        let coefficients = form.coefficients(&random_nodes(3));
        for (kept, moved) in [(0, 1), (3, 1), (2, 0)] {
            let half = form.half(&coefficients, kept, moved);
            for local in quadrature::tetrahedron(5).points {
                let mut lambda = local.clone();
                lambda[kept] += 0.5 * local[moved];
                lambda[moved] = 0.5 * local[moved];
                let (a, b) =
                    (evaluate(&form, &half, &local), evaluate(&form, &coefficients, &lambda));
                assert!((a - b).abs() < 1e-11, "{a} {b}");
            }
        }
    }
}
