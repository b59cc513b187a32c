//! Cotangent Laplacian and vertex areas of a triangle surface.
//!
//! (L w)_v = Σ_w ½ (cot α + cot β) (w_v − w_w)     positive semidefinite [1]
//! A_v     = the part of the surface nearer to v than to other corners [m²]
//!
//! α, β are the angles opposite to the edge vw; in an obtuse triangle the
//! obtuse corner gets half of the area and the others a quarter.
//!
//! Source: Pinkall and Polthier 1993, doi:10.1080/10586458.1993.10504266;
//! Meyer et al. 2003, doi:10.1007/978-3-662-05105-4_2.

use std::collections::BTreeMap;

use mesh::{SurfaceMesh, Vec3};

/// Twice the area below which a triangle counts as degenerate, in units of its
/// longest edge squared [1]; bounds the cotangents of slivers.
const DEGENERATE: f64 = 1e-8;

/// Sparse symmetric matrix by rows.
pub type Rows = Vec<BTreeMap<usize, f64>>;

/// L, and A_v of all vertices.
pub fn cotangent_laplacian(surface: &SurfaceMesh) -> (Rows, Vec<f64>) {
    let n = surface.vertices.len();
    let (mut rows, mut areas) = (vec![BTreeMap::new(); n], vec![0.0; n]);
    for (t, triangle) in surface.triangles.iter().enumerate() {
        let cot = cotangents(&surface.corners(t));
        let corner_areas = corner_areas(&surface.corners(t), &cot);
        for k in 0..3 {
            areas[triangle[k]] += corner_areas[k];
            let (i, j) = (triangle[(k + 1) % 3], triangle[(k + 2) % 3]);
            for (a, b) in [(i, j), (j, i)] {
                *rows[a].entry(b).or_insert(0.0) -= 0.5 * cot[k];
                *rows[a].entry(a).or_insert(0.0) += 0.5 * cot[k];
            }
        }
    }
    (rows, areas)
}

/// Edge vectors leaving corner k of a triangle.
fn legs(x: &[Vec3; 3], k: usize) -> (Vec3, Vec3) {
    (x[(k + 1) % 3] - x[k], x[(k + 2) % 3] - x[k])
}

fn cotangents(x: &[Vec3; 3]) -> [f64; 3] {
    let longest2 = (0..3).map(|k| legs(x, k).0.norm_squared()).fold(0.0, f64::max);
    let (a, b) = legs(x, 0);
    let double_area = a.cross(&b).norm().max(DEGENERATE * longest2).max(f64::MIN_POSITIVE);
    std::array::from_fn(|k| {
        let (a, b) = legs(x, k);
        a.dot(&b) / double_area
    })
}

fn corner_areas(x: &[Vec3; 3], cot: &[f64; 3]) -> [f64; 3] {
    let (a, b) = legs(x, 0);
    let area = 0.5 * a.cross(&b).norm();
    if let Some(obtuse) = cot.iter().position(|&c| c < 0.0) {
        return std::array::from_fn(|k| if k == obtuse { area / 2.0 } else { area / 4.0 });
    }
    std::array::from_fn(|k| {
        let (a, b) = legs(x, k);
        (cot[(k + 2) % 3] * a.norm_squared() + cot[(k + 1) % 3] * b.norm_squared()) / 8.0
    })
}

#[cfg(test)]
mod tests {
    use mechanics::testing::square;

    use super::*;

    #[test]
    fn linear_functions_are_harmonic_and_areas_add_up() {
        let n = 8;
        let surface = square(n, 0.3);
        let (rows, areas) = cotangent_laplacian(&surface);
        assert!((areas.iter().sum::<f64>() - 1.0).abs() < 1e-13);
        assert!(areas.iter().all(|&a| a > 0.0));
        let f = |v: usize| 3.0 * surface.vertices[v].x - 2.0 * surface.vertices[v].y + 1.0;
        for (v, row) in rows.iter().enumerate() {
            let interior = v % (n + 1) % n != 0 && v / (n + 1) % n != 0;
            let sum: f64 = row.iter().map(|(&w, c)| c * f(w)).sum();
            assert!(!interior || sum.abs() < 1e-12, "{sum}");
        }
    }
}
