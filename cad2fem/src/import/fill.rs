//! Small holes closed by the triangles of least area over their rims (Barequet and Sharir 1995,
//! doi:10.1016/0167-8396(94)00011-G).

use mesh::Vec3;
use mesh::measure::triangle_area;
use mesh::topology::boundary_loops;

use super::Patched;

/// Edges of a rim, at most: the time grows with their third power.
const MOST: usize = 200;

/// Closes every rim of up to `MOST` edges; new triangles have the patch of one beside them. Returns
/// how many rims.
pub fn fill(body: &mut Patched) -> usize {
    let rims = boundary_loops(&body.surface.triangles);
    let rims: Vec<_> = rims.into_iter().filter(|rim| (3..=MOST).contains(&rim.len())).collect();
    let mut patch_at = vec![0; body.surface.vertices.len()];
    for (corners, &patch) in body.surface.triangles.iter().zip(&body.patch) {
        corners.iter().for_each(|&v| patch_at[v] = patch);
    }
    for rim in &rims {
        // against the rim, as neighbours wind alike
        let corners: Vec<usize> = rim.iter().rev().copied().collect();
        let points: Vec<Vec3> = corners.iter().map(|&v| body.surface.vertices[v]).collect();
        for triangle in triangulated(&points) {
            body.surface.triangles.push(triangle.map(|i| corners[i]));
            body.patch.push(patch_at[corners[triangle[0]]]);
        }
    }
    rims.len()
}

/// The triangles of least area in all over a closed line, by the areas over its parts from `i` to `k`.
fn triangulated(points: &[Vec3]) -> Vec<[usize; 3]> {
    let n = points.len();
    let mut least = vec![vec![0.0; n]; n];
    let mut middle = vec![vec![0; n]; n];
    for length in 2..n {
        for i in 0..n - length {
            let k = i + length;
            let over = |m: usize| {
                least[i][m] + least[m][k] + triangle_area(points[i], points[m], points[k])
            };
            let best = (i + 1..k).map(|m| (over(m), m)).min_by(|a, b| a.0.total_cmp(&b.0));
            (least[i][k], middle[i][k]) = best.unwrap_or_default();
        }
    }
    let mut triangles = Vec::new();
    let mut parts = vec![(0, n - 1)];
    while let Some((i, k)) = parts.pop() {
        if k - i > 1 {
            let m = middle[i][k];
            triangles.push([i, m, k]);
            parts.extend([(i, m), (m, k)]);
        }
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh::solid::Solid;
    use mesh::{check, measure};

    #[test]
    fn holes_of_a_cube_are_filled_flat() {
        let surface = Solid::cube(&Vec3::zeros(), &Vec3::repeat(1.0)).to_surface();
        let mut body = Patched { patch: vec![7; 12], surface };
        body.surface.triangles.remove(3);
        let top = |t: &[usize; 3]| t.iter().all(|&v| body.surface.vertices[v].z > 0.5);
        body.surface.triangles =
            body.surface.triangles.iter().filter(|t| !top(t)).copied().collect();
        body.patch.truncate(body.surface.triangles.len());
        assert!(fill(&mut body) > 0);
        assert_eq!(check::check_surface(&body.surface), vec![]);
        assert!((measure::enclosed_volume(&body.surface) - 1.0).abs() < 1e-12);
        assert_eq!(body.patch, [7; 12]);
    }
}
