//! The pose of a tag: where it is, how it has turned, and what forces and torques on it do to both.
//!
//! With weights w of the nodes of the tag (integrals of their basis functions), mean rest position X₀ and mean position x₀,
//! the rotation R is the one that fits best: A = Σ w (x − x₀)(X − X₀)ᵀ = V R, V symmetric. A change of the
//! displacement turns it by the spin
//!
//! ω = (tr V 1 − V)⁻¹ Σ w R(X − X₀) × δu
//!
//! so mean and spin are linear in δu, and their transpose spreads a force and a torque over the nodes.

use anyhow::{Result, ensure};
use mechanics::body::Body;
use mechanics::element::{FunctionSpace, at};
use mechanics::energy::Iterate;
use mechanics::forward::{Linearization, Problem, Workspace};
use mesh::Vec3;
use nalgebra::{Matrix3, Matrix6, Rotation3, UnitQuaternion, Vector6};

/// Relative residual of the compliance.
const WANTED_RESIDUAL: f64 = 1e-9;
/// Relative residual that is still good enough.
const LARGEST_RESIDUAL: f64 = 1e-7;
/// Resistance of the nodes to a rotation below which they lie in a line, as a part of the largest [1].
const LEAST_TILT: f64 = 1e-9;

/// A tag whose pose is asked for.
pub struct Tip {
    /// Nodes with their rest position from the mean one [m], and part of the area [1].
    nodes: Vec<(usize, Vec3, f64)>,
    /// Mean rest position [m].
    centre: Vec3,
}

/// Where a tag is.
pub struct Pose {
    /// Mean position [m].
    pub position: Vec3,
    /// Rotation vector: axis times angle [rad].
    pub rotation: Vec3,
    /// Change of the rotation vector by the spin [1].
    by_spin: Matrix3<f64>,
    /// Rows by which mean and spin depend on the displacement; the latter [1/m].
    rows: [Vec<f64>; 6],
}

impl Tip {
    /// The tag of a body.
    pub fn new(body: &Body, space: &FunctionSpace, tag: &str) -> Result<Self> {
        let x = &body.mesh.vertices;
        let mut weights = std::collections::BTreeMap::<usize, f64>::new();
        let table = space.facet_table();
        for facet in body.facets(tag)? {
            let [a, b, c] = facet.map(|v| x[v]);
            let area = mesh::measure::triangle_area(a, b, c);
            let nodes = space.facet_nodes(facet);
            for (values, weight) in table.values.iter().zip(&table.weights) {
                for (node, value) in nodes.iter().zip(values) {
                    *weights.entry(*node).or_default() += area * weight * value;
                }
            }
        }
        let total: f64 = weights.values().sum();
        let place = |node: usize| space.node_position(x, node);
        let centre: Vec3 = weights.iter().map(|(&n, w)| *w / total * place(n)).sum();
        let node = |(n, w): (usize, f64)| (n, place(n) - centre, w / total);
        Ok(Self { nodes: weights.into_iter().map(node).collect(), centre })
    }

    /// The pose at a displacement [m].
    pub fn pose(&self, u: &[f64]) -> Result<Pose> {
        let mean: Vec3 = self.nodes.iter().map(|(n, _, w)| *w * at(u, *n)).sum();
        let moved =
            |(n, arm, w): &(usize, Vec3, f64)| *w * (arm + at(u, *n) - mean) * arm.transpose();
        let matrix: Matrix3<f64> = self.nodes.iter().map(moved).sum();
        let turn = best_rotation(&matrix);
        let stretch = matrix * turn.transpose();
        let stretch = 0.5 * (stretch + stretch.transpose());
        let resists = Matrix3::from_diagonal_element(stretch.trace()) - stretch;
        let eigen = resists.symmetric_eigenvalues();
        ensure!(
            eigen.min() > LEAST_TILT * eigen.max(),
            "the nodes of the tip are in a line, or its rotation is undefined: expected a tag with an area"
        );
        let inverse = resists.try_inverse().unwrap_or_default();
        let mut rows = std::array::from_fn(|_| vec![0.0; u.len()]);
        for (n, arm, w) in &self.nodes {
            // spin = inverse (w R X × δu), and r × e_k is column k of the matrix of r ×
            let spin = inverse * (*w * (turn * arm)).cross_matrix();
            for k in 0..3 {
                rows[k][3 * n + k] = *w;
                (0..3).for_each(|i| rows[3 + i][3 * n + k] = spin[(i, k)]);
            }
        }
        // by a quaternion: the angle from the trace of a matrix is not a number where rounding makes that larger than 3
        let rotation = Rotation3::from_matrix_unchecked(turn);
        let rotation = UnitQuaternion::from_rotation_matrix(&rotation).scaled_axis();
        let by_spin = by_spin(&rotation);
        Ok(Pose { position: self.centre + mean, rotation, by_spin, rows })
    }
}

impl Pose {
    /// The derivative of each of the six numbers by the displacement: of the position [1], of the
    /// rotation vector [rad/m].
    pub fn by_displacement(&self) -> [Vec<f64>; 6] {
        let mut rows = self.rows.clone();
        for i in 0..3 {
            let sum = |d: usize| (0..3).map(|j| self.by_spin[(i, j)] * self.rows[3 + j][d]).sum();
            rows[3 + i] = (0..rows[0].len()).map(sum).collect();
        }
        rows
    }

    /// The factored Hessian, and with it the stiffness at the tip: forces [N] and torques [N m] by small motions [m]
    /// and spins [rad]. No stiffness where the Hessian has no accurate inverse.
    pub fn stiffness(
        &self,
        problem: &Problem,
        workspace: &mut Workspace,
        at: &Iterate,
    ) -> Result<(Linearization, Option<Matrix6<f64>>)> {
        ensure!(
            problem.constraints(at).is_empty(),
            "[[chamber]]: the stiffness of a tip needs chambers with a pressure or a fixed amount of gas, not a \
             prescribed volume"
        );
        let linearization = workspace.linearize(problem, at);
        let mut compliance = Matrix6::zeros();
        for k in 0..6 {
            let mut solution = problem.restrict(&self.rows[k]);
            match workspace.solve_accurately(&mut solution, WANTED_RESIDUAL, LARGEST_RESIDUAL) {
                Some(residual) if residual <= LARGEST_RESIDUAL => {}
                _ => return Ok((linearization, None)),
            }
            let moved = problem.prolong(&solution);
            let along = |row: &Vec<f64>| row.iter().zip(&moved).map(|(r, u)| r * u).sum();
            compliance.set_column(k, &Vector6::from_iterator(self.rows.iter().map(along)));
        }
        let symmetric: Matrix6<f64> = 0.5 * (compliance + compliance.transpose());
        let stiffness = symmetric.try_inverse();
        Ok((linearization, stiffness.filter(|k| k.iter().all(|value| value.is_finite()))))
    }
}

/// The rotation that fits a matrix best, without reflection.
fn best_rotation(matrix: &Matrix3<f64>) -> Matrix3<f64> {
    let svd = matrix.svd(true, true);
    let (Some(left), Some(right)) = (svd.u, svd.v_t) else { return Matrix3::identity() };
    let mut sign = Matrix3::identity();
    // nalgebra sorts singular values; the smallest is the last
    sign[(2, 2)] = (left * right).determinant().signum();
    left * sign * right
}

/// The change of a rotation vector r by the spin: the inverse of the left Jacobian of SO(3),
/// 1 − ½ [r]× + (1/θ² − (1 + cos θ)/(2 θ sin θ)) [r]×².
fn by_spin(r: &Vec3) -> Matrix3<f64> {
    let (angle, cross) = (r.norm(), r.cross_matrix());
    let second = if angle < 1e-4 {
        1.0 / 12.0 + angle * angle / 720.0
    } else {
        (1.0 - 0.5 * angle / (0.5 * angle).tan()) / (angle * angle)
    };
    Matrix3::identity() - 0.5 * cross + second * cross * cross
}

#[cfg(test)]
mod tests {
    use mechanics::testing;
    use mesh::Tags;

    use super::*;

    /// The tag "top" of a cube.
    fn tip(degree: usize) -> (Tip, FunctionSpace, Vec<Vec3>) {
        let mesh = testing::cube(2, 0.1);
        let mut tags = Tags::new(vec!["top".to_owned()]);
        for facet in mesh::topology::boundary(&mesh).facets {
            if facet.iter().all(|&v| mesh.vertices[v].z > 1.0 - 1e-9) {
                tags.set(facet, 1);
            }
        }
        let body = Body::new(mesh, tags);
        let x = body.mesh.vertices.clone();
        let space = FunctionSpace::new(degree, x.len(), body.mesh.tets.clone());
        (Tip::new(&body, &space, "top").expect("a tag"), space, x)
    }

    fn displacement(space: &FunctionSpace, x: &[Vec3], of: impl Fn(Vec3) -> Vec3) -> Vec<f64> {
        space.node_positions(x).iter().flat_map(|&x| <[f64; 3]>::from(of(x) - x)).collect()
    }

    #[test]
    fn a_rigid_motion_is_found_again_and_at_rest_there_is_none() {
        for degree in [1, 2, 3] {
            let (tip, space, x) = tip(degree);
            let (turn, shift) = (Vec3::new(0.4, -0.9, 1.3), Vec3::new(0.1, 0.2, -0.3));
            let rotation = Rotation3::from_scaled_axis(turn);
            let u = displacement(&space, &x, |x| rotation * x + shift);
            let pose = tip.pose(&u).expect("an area");
            assert!((pose.rotation - turn).norm() < 1e-9, "{}", pose.rotation);
            assert!((pose.position - (rotation * tip.centre + shift)).norm() < 1e-9);
            for size in [0.0, 1e-12, 1e-9] {
                let u: Vec<f64> = (0..u.len()).map(|d| size * (1.7 * d as f64).sin()).collect();
                let pose = tip.pose(&u).expect("an area");
                assert!(pose.rotation.norm() < 1e-15 + 10.0 * size, "{}", pose.rotation);
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        let (tip, space, x) = tip(2);
        let rotation = Rotation3::from_scaled_axis(Vec3::new(0.4, -0.9, 1.3));
        let bend =
            |x: Vec3| rotation * (x + Vec3::new(0.2 * x.y * x.y, 0.1 * x.x, 0.3 * x.x * x.y));
        let u = displacement(&space, &x, bend);
        let along: Vec<f64> = (0..u.len()).map(|d| (1.7 * d as f64).sin()).collect();
        let at = |h: f64| {
            let moved: Vec<f64> = u.iter().zip(&along).map(|(u, a)| u + h * a).collect();
            let pose = tip.pose(&moved).expect("an area");
            [pose.position, pose.rotation]
        };
        let (h, rows) = (1e-5, tip.pose(&u).expect("an area").by_displacement());
        let [ahead, behind] = [at(h), at(-h)];
        for (k, row) in rows.iter().enumerate() {
            let exact: f64 = row.iter().zip(&along).map(|(r, a)| r * a).sum();
            let difference = (ahead[k / 3][k % 3] - behind[k / 3][k % 3]) / (2.0 * h);
            assert!((exact - difference).abs() < 1e-7, "{k}: {exact} {difference}");
        }
    }
}
