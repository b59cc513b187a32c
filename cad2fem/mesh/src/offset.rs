//! Walls that are off: vertices moved so that their facets move along their normals.
//!
//! d minimises Σ w (n·d − 1)² over the facets at a vertex     move per distance [1]
//!
//! n    outward unit normal of a facet; w its angle at the vertex
//!
//! On a smooth surface d is the normal, at an edge both sides move by the distance. Quadric
//! errors as in Garland and Heckbert 1997.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, SymmetricEigen};

use crate::Vec3;

/// Directions in which normals vary by less than this part of the most are not moved in:
/// normals within 20° count as one.
const SMALLEST_EIGENVALUE: f64 = 0.03;

/// Moves per distance of the vertices of facets, which turn their normals outward.
pub fn shifts(x: &[Vec3], facets: &[[usize; 3]]) -> BTreeMap<usize, Vec3> {
    quadrics(x, facets).into_iter().map(|(v, quadric)| (v, quadric.least())).collect()
}

/// Adds to `out` the cotangents of the positions x for those of [`shifts`], of which `bar` has
/// one for each vertex. Where normals are about to count as one, [`shifts`] jumps and has no
/// derivative.
pub fn add_shifts_vjp(x: &[Vec3], facets: &[[usize; 3]], bar: &[Vec3], out: &mut [Vec3]) {
    let quadrics = quadrics(x, facets);
    let bars: BTreeMap<usize, (Matrix3<f64>, Vec3)> =
        quadrics.iter().map(|(&v, quadric)| (v, quadric.vjp(&bar[v]))).collect();
    for facet in facets {
        let (normal, length) = normal(x, facet);
        let mut normal_bar = Vec3::zeros();
        for k in 0..3 {
            let (matrix_bar, sum_bar) = &bars[&facet[k]];
            let [p, q] = sides(x, facet, k);
            let angle_bar = (matrix_bar * normal + sum_bar).dot(&normal);
            normal_bar += p.angle(&q) * ((matrix_bar + matrix_bar.transpose()) * normal + sum_bar);
            // an angle grows as its sides turn away from each other
            let p_bar = -angle_bar / p.norm_squared() * normal.cross(&p);
            let q_bar = angle_bar / q.norm_squared() * normal.cross(&q);
            out[facet[(k + 1) % 3]] += p_bar;
            out[facet[(k + 2) % 3]] += q_bar;
            out[facet[k]] -= p_bar + q_bar;
        }
        let across_bar = (normal_bar - normal * normal.dot(&normal_bar)) / length;
        let [p, q] = sides(x, facet, 0);
        let (p_bar, q_bar) = (q.cross(&across_bar), across_bar.cross(&p));
        out[facet[1]] += p_bar;
        out[facet[2]] += q_bar;
        out[facet[0]] -= p_bar + q_bar;
    }
}

/// Unit normal of a facet, and the length before: twice its area.
fn normal(x: &[Vec3], facet: &[usize; 3]) -> (Vec3, f64) {
    let [p, q] = sides(x, facet, 0);
    let across = p.cross(&q);
    let length = across.norm();
    (if length > 0.0 { across / length } else { across }, length.max(f64::MIN_POSITIVE))
}

/// From a corner of a facet to the two others.
fn sides(x: &[Vec3], facet: &[usize; 3], k: usize) -> [Vec3; 2] {
    [1, 2].map(|i| x[facet[(k + i) % 3]] - x[facet[k]])
}

/// The quadric of the facets at a vertex.
#[derive(Default)]
struct Quadric {
    /// Σ w n nᵀ.
    matrix: Matrix3<f64>,
    /// Σ w n.
    sum: Vec3,
}

fn quadrics(x: &[Vec3], facets: &[[usize; 3]]) -> BTreeMap<usize, Quadric> {
    let mut quadrics: BTreeMap<usize, Quadric> = BTreeMap::new();
    for facet in facets {
        let (normal, _) = normal(x, facet);
        for k in 0..3 {
            let [p, q] = sides(x, facet, k);
            let angle = p.angle(&q);
            let quadric = quadrics.entry(facet[k]).or_default();
            quadric.matrix += normal * normal.transpose() * angle;
            quadric.sum += normal * angle;
        }
    }
    quadrics
}

impl Quadric {
    /// The shortest d with the least error: the pseudo-inverse f(A) s, where f(λ) is 1/λ, but 0
    /// for directions in which normals hardly vary.
    fn least(&self) -> Vec3 {
        let SymmetricEigen { eigenvalues, eigenvectors } = self.matrix.symmetric_eigen();
        let inverse = inverses(&eigenvalues);
        let along = eigenvectors.transpose() * self.sum;
        eigenvectors * inverse.component_mul(&along)
    }

    /// Cotangents of A and s for that of d: Ā = V (F ∘ (Vᵀd̄)(Vᵀs)ᵀ) Vᵀ with the divided
    /// differences F of f (Daleckii and Krein 1965), s̄ = f(A) d̄.
    fn vjp(&self, bar: &Vec3) -> (Matrix3<f64>, Vec3) {
        let SymmetricEigen { eigenvalues: l, eigenvectors: v } = self.matrix.symmetric_eigen();
        let f = inverses(&l);
        let (a, b) = (v.transpose() * bar, v.transpose() * self.sum);
        let difference = |i: usize, j: usize| match (f[i] > 0.0, f[j] > 0.0) {
            (true, true) => -f[i] * f[j],
            (false, false) => 0.0,
            _ => (f[i] - f[j]) / (l[i] - l[j]),
        };
        let inner = Matrix3::from_fn(|i, j| difference(i, j) * a[i] * b[j]);
        (v * inner * v.transpose(), v * f.component_mul(&a))
    }
}

/// f of eigenvalues.
fn inverses(eigenvalues: &Vec3) -> Vec3 {
    let largest = eigenvalues.max();
    eigenvalues.map(|l| if l > SMALLEST_EIGENVALUE * largest { 1.0 / l } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_faces_of_a_cube_move_by_the_distance() {
        let corner = |v: usize| Vec3::from_fn(|k, _| (v >> k & 1) as f64);
        let corners: Vec<Vec3> = (0..8).map(corner).collect();
        let squares =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let facets: Vec<[usize; 3]> =
            squares.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let moves = shifts(&corners, &facets);
        assert_eq!(moves.len(), 8);
        for (v, d) in moves {
            assert!((d - (2.0 * corners[v] - Vec3::repeat(1.0))).norm() < 1e-12, "{v}: {d:?}");
        }
    }

    /// An edge, a corner and a flat vertex, all of them at some distance from where their rank
    /// would change: Taylor slopes of 2.
    #[test]
    fn the_derivative_is_that_of_the_shifts() {
        let number = |i: usize| (i as f64 * 12.9898).sin() * 43_758.545_3 % 1.0;
        let vector = |i: usize| Vec3::from_fn(|k, _| number(3 * i + k + 1));
        let corner = |v: usize| Vec3::from_fn(|k, _| (v >> k & 1) as f64);
        let mut x: Vec<Vec3> = (0..8).map(corner).collect();
        x.push(Vec3::new(0.45, 0.55, 0.0)); // in the middle of the lower face
        x.iter_mut().enumerate().for_each(|(i, x)| *x += 0.02 * vector(i));
        let squares = [[4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let mut facets: Vec<[usize; 3]> =
            squares.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        facets.extend([[0, 2, 8], [2, 3, 8], [3, 1, 8], [1, 0, 8]]);
        let bar: Vec<Vec3> = (0..9).map(|i| vector(20 + i)).collect();
        let value =
            |x: &[Vec3]| -> f64 { shifts(x, &facets).iter().map(|(&v, d)| bar[v].dot(d)).sum() };
        let mut gradient = vec![Vec3::zeros(); 9];
        add_shifts_vjp(&x, &facets, &bar, &mut gradient);
        let direction: Vec<Vec3> = (0..9).map(|i| vector(40 + i)).collect();
        let slope: f64 = gradient.iter().zip(&direction).map(|(g, q)| g.dot(q)).sum();
        let remainder = |e: f64| {
            let moved: Vec<Vec3> = x.iter().zip(&direction).map(|(x, q)| x + e * q).collect();
            (value(&moved) - value(&x) - e * slope).abs()
        };
        assert!(slope.abs() > 0.1, "{slope}");
        for e in [1e-3, 5e-4] {
            let order = (remainder(e) / remainder(0.5 * e)).log2();
            assert!((order - 2.0).abs() < 0.1, "{order}");
        }
    }
}
