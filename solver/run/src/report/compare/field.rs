//! Difference of displacement fields on different meshes.

use mechanics::element::{at, sample};
use mesh::Vec3;
use serde::Serialize;

use super::Run;

/// Difference of a displacement field from the reference, at the quadrature
/// points of the reference that lie in both bodies.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Difference {
    /// Largest length [m].
    pub max: f64,
    /// Where that is, at rest [m].
    pub at: [f64; 3],
    /// (∫ |u − u_ref|² dV / ∫ dV)^½ [m].
    pub rms: f64,
    /// The volume of the points in both bodies, as a share of the reference.
    pub volume_share: f64,
}

/// Compares the displacement of a run with the reference's.
pub fn difference(reference: &Run, run: &Run) -> Difference {
    let (points, volumes, expected) = quadrature(reference);
    let found = sample((&run.space, &run.rest, &run.u), &points);
    let mut result = Difference { max: 0.0, at: [0.0; 3], rms: 0.0, volume_share: 0.0 };
    let (mut squares, mut common) = (0.0, 0.0);
    for (((point, volume), expected), found) in points.iter().zip(&volumes).zip(expected).zip(found)
    {
        let Some(found) = found else { continue };
        let error = (found - expected).norm();
        squares += volume * error * error;
        common += volume;
        if error > result.max {
            result.max = error;
            result.at = (*point).into();
        }
    }
    // bodies with nothing in common have no difference
    result.rms = (squares / common).sqrt();
    result.volume_share = common / volumes.iter().sum::<f64>();
    result
}

/// Rest positions [m], volumes [m³] and displacements [m] of all quadrature
/// points.
fn quadrature(run: &Run) -> (Vec<Vec3>, Vec<f64>, Vec<Vec3>) {
    let (space, table) = (&run.space, run.space.volume_table());
    let (mut points, mut volumes, mut displacements) = (Vec::new(), Vec::new(), Vec::new());
    let nodes = space.element_nodes().chunks_exact(space.nodes_per_element());
    for (tet, nodes) in space.tets().iter().zip(nodes) {
        let corners = tet.map(|v| run.rest[v]);
        let [a, b, c, d] = corners;
        let volume = mesh::measure::tet_volume(a, b, c, d);
        for ((point, weight), values) in table.points.iter().zip(&table.weights).zip(&table.values)
        {
            points.push(corners.iter().zip(point).map(|(x, l)| x * *l).sum());
            volumes.push(weight * volume);
            displacements.push(nodes.iter().zip(values).map(|(&n, v)| at(&run.u, n) * *v).sum());
        }
    }
    (points, volumes, displacements)
}

#[cfg(test)]
mod tests {
    use mechanics::element::FunctionSpace;
    use mechanics::testing;

    use super::*;

    /// A field on the unit cube in n³ cells, scaled.
    fn run(n: usize, degree: usize, size: f64, field: impl Fn(Vec3) -> Vec3) -> Run {
        let mut mesh = testing::cube(n, 0.2);
        mesh.vertices.iter_mut().for_each(|x| *x *= size);
        let boundary = mesh::topology::boundary(&mesh).facets;
        let space = FunctionSpace::new(degree, mesh.vertices.len(), mesh.tets);
        let nodes = space.node_positions(&mesh.vertices);
        let u = nodes.into_iter().flat_map(|x| <[f64; 3]>::from(field(x))).collect();
        let (folder, problem) = (std::path::PathBuf::new(), serde_json::Value::Null);
        Run { folder, space, rest: mesh.vertices, boundary, u, time: 0.0, problem }
    }

    #[test]
    fn one_field_on_two_meshes_and_degrees_does_not_differ() {
        let field = |x: Vec3| Vec3::new(x.x * x.y, 1.0 - x.z * x.z, x.x);
        let found = difference(&run(3, 3, 1.0, field), &run(4, 2, 1.0, field));
        assert!(found.max < 1e-14, "{found:?}");
        assert!((found.volume_share - 1.0).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn a_known_difference_is_found() {
        let field = |x: Vec3| Vec3::new(x.y, 0.0, 0.0);
        let other = |x: Vec3| field(x) + Vec3::new(0.0, 3e-3 * x.x, 4e-3 * x.x);
        let found = difference(&run(3, 2, 1.0, field), &run(4, 1, 1.0, other));
        // |Δu| = 5e-3 x: its mean square is 25e-6/3, which the rule integrates exactly
        assert!((found.rms / 5e-3 * 3.0_f64.sqrt() - 1.0).abs() < 1e-12, "{found:?}");
        assert!(found.max > 4.5e-3 && found.max < 5e-3, "{found:?}");
        assert!(found.at[0] > 0.9, "{found:?}");
    }

    #[test]
    fn only_common_points_count() {
        let field = |x: Vec3| x;
        let found = difference(&run(4, 2, 1.0, field), &run(3, 1, 0.5, field));
        assert!(found.max < 1e-15, "{found:?}");
        assert!((found.volume_share - 0.125).abs() < 0.02, "{found:?}");
    }
}
