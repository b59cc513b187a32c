//! Rigid parts: nodes that move together, such as a fitting, a glued disc or a body much stiffer than silicone.
//!
//! u_i = Σ_j b_ij u_j      b: barycentric coordinates of X_i in the simplex of the masters j, Σ_j b_ij = 1
//!
//! The masters are one to four nodes of the part, as many as its dimension needs: any affine motion of the
//! part is one of its masters. The others, its followers, are no unknowns. The energy of
//! [`Rigid`](crate::energy::Rigid) leaves the masters only rigid motions. Relations are linear, so that every
//! derivative is exact, and surfaces between two states move along straight lines.
//!
//! Where planes of symmetry cut a part, it moves as their images allow: along one plane in its two dimensions,
//! along two or three without turning.
//!
//! Source: affine bodies, Lan et al. 2022, "Affine Body Dynamics", doi:10.1145/3528223.3530064; multi-point
//! constraints, e.g. Belytschko et al., "Nonlinear Finite Elements for Continua and Structures", section 3.

use mesh::Vec3;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::math::tensor::Mat3;

/// Extent of a part along an axis, over its largest, below which it has none there: it is flat, or a line.
const FLAT: f64 = 1e-6;

/// Extent of a part over its distance from the origin below which its nodes are one point.
const ROUNDED: f64 = 1e-12;

/// Nodes that move together.
#[derive(Clone, Debug)]
pub struct RigidSet {
    masters: Vec<usize>,
    followers: Vec<(usize, Vec<f64>)>,
    /// Principal axes of the part in the columns, those in which it has an extent.
    axes: DMatrix<f64>,
    /// Root mean square extents along them [m].
    extents: Vec<f64>,
    /// Masters' coordinates along the axes, relative to the first, in the columns but that of the first [m].
    simplex: DMatrix<f64>,
    /// Rest position of the first master [m].
    origin: Vec3,
    moves: Moves,
}

/// How a part may move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moves {
    /// Along all axes and about all.
    Freely,
    /// In a plane, by the axis normal to it (0 to 2), and about that axis.
    InPlane(usize),
    /// Without turning.
    Straight,
}

/// A point is not where the nodes of a flat or straight part are.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("it is {distance} m off the part, which has no extent there")]
pub struct OffThePart {
    /// How far off [m].
    pub distance: f64,
}

impl RigidSet {
    /// Some nodes without repetition, with the positions of all nodes at rest [m]. Of nodes that do as well, the first is
    /// a master. None where there are no nodes.
    pub fn new(nodes: &[usize], positions: &[Vec3], moves: Moves) -> Option<Self> {
        Self::hinged(nodes, &[], positions, moves)
    }

    /// As [`Self::new`], for a part that is hinged: the nodes in `held` are a point, or lie on a straight line. They are the
    /// first masters, so that the others of them follow no other node.
    pub fn hinged(
        nodes: &[usize],
        held: &[usize],
        positions: &[Vec3],
        moves: Moves,
    ) -> Option<Self> {
        let &first = nodes.first()?;
        let center = nodes.iter().map(|&n| positions[n]).sum::<Vec3>() / nodes.len() as f64;
        let (axes, extents) = principal_axes(nodes, positions, center, moves);
        let along = |x: Vec3| axes.transpose() * DVector::from_column_slice(x.as_slice());
        let spread =
            Spread { positions, along: &along, size: extents.iter().copied().fold(0.0, f64::max) };
        let masters = spread.masters(nodes, held, center, extents.len());
        let origin = masters.first().map_or(positions[first], |&m| positions[m]);
        let columns: Vec<DVector<f64>> =
            masters[1..].iter().map(|&m| along(positions[m] - origin)).collect();
        let simplex = DMatrix::from_fn(extents.len(), columns.len(), |i, j| columns[j][i]);
        let mut part =
            Self { masters, followers: Vec::new(), axes, extents, simplex, origin, moves };
        let others = nodes.iter().filter(|node| !part.masters.contains(node));
        part.followers = others.map(|&n| (n, part.weights(positions[n]))).collect();
        Some(part)
    }

    /// The nodes whose motion is that of all.
    pub fn masters(&self) -> &[usize] {
        &self.masters
    }

    /// The other nodes, each with the weights of the masters.
    pub fn followers(&self) -> &[(usize, Vec<f64>)] {
        &self.followers
    }

    /// Principal axes in columns, those in which the part has an extent.
    pub fn axes(&self) -> &DMatrix<f64> {
        &self.axes
    }

    /// Root mean square extents along the principal axes [m].
    pub fn extents(&self) -> &[f64] {
        &self.extents
    }

    /// Weights of the masters at a point that moves with the part [1].
    pub fn weights_at(&self, point: Vec3) -> Result<Vec<f64>, OffThePart> {
        let mut offset = DVector::from_column_slice((point - self.origin).as_slice());
        if let Moves::InPlane(normal) = self.moves {
            offset[normal] = 0.0;
        }
        let inside = &self.axes * (self.axes.transpose() * &offset);
        let distance = (offset - inside).norm();
        let size = self.extents.iter().copied().fold(0.0, f64::max);
        // without turning, all points move alike
        if self.masters.len() > 1 && distance > 1e3 * FLAT * size {
            return Err(OffThePart { distance });
        }
        Ok(self.weights(point))
    }

    fn weights(&self, point: Vec3) -> Vec<f64> {
        if self.masters.len() == 1 {
            return vec![1.0];
        }
        let offset = DVector::from_column_slice((point - self.origin).as_slice());
        let along = self.axes.transpose() * offset;
        let solved = self.simplex.clone().lu().solve(&along).expect("a simplex of full dimension");
        let first = 1.0 - solved.sum();
        std::iter::once(first).chain(solved.iter().copied()).collect()
    }

    /// Rows m_j, one for each master, with which Σ_j x_j m_jᵀ = F S: the part's deformation gradient along its
    /// principal axes, each scaled by the extent [m].
    pub fn scaled_gradients(&self) -> DMatrix<f64> {
        let dimension = self.extents.len();
        if self.masters.len() == 1 {
            return DMatrix::zeros(1, 0);
        }
        let inverse = self.simplex.clone().try_inverse().expect("a simplex of full dimension");
        let scaled = inverse * DMatrix::from_diagonal(&DVector::from_column_slice(&self.extents));
        let first = -scaled.row_sum();
        let mut rows = DMatrix::zeros(dimension + 1, dimension);
        rows.set_row(0, &first);
        (0..dimension).for_each(|j| rows.set_row(j + 1, &scaled.row(j)));
        rows
    }
}

/// Directions in which the nodes have an extent, in columns, and the root mean square extents.
fn principal_axes(
    nodes: &[usize],
    positions: &[Vec3],
    center: Vec3,
    moves: Moves,
) -> (DMatrix<f64>, Vec<f64>) {
    let normal = match moves {
        Moves::Freely => None,
        Moves::InPlane(axis) => Some(axis),
        Moves::Straight => return (DMatrix::zeros(3, 0), Vec::new()),
    };
    let mut covariance = Mat3::zeros();
    for &node in nodes {
        let mut offset = positions[node] - center;
        normal.iter().for_each(|&axis| offset[axis] = 0.0);
        covariance += offset * offset.transpose() / nodes.len() as f64;
    }
    let eigen = SymmetricEigen::new(covariance);
    let extents = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
    // below that, offsets are the rounding of positions
    let least = (FLAT * extents.max()).max(ROUNDED * center.norm());
    let kept: Vec<usize> = (0..3).filter(|&k| extents[k] > least).collect();
    let axes = DMatrix::from_fn(3, kept.len(), |i, j| eigen.eigenvectors[(i, kept[j])]);
    (axes, kept.iter().map(|&k| extents[k]).collect())
}

/// Nodes in the directions in which a part has an extent.
struct Spread<'a> {
    positions: &'a [Vec3],
    along: &'a dyn Fn(Vec3) -> DVector<f64>,
    /// The largest extent [m].
    size: f64,
}

impl Spread<'_> {
    /// Nodes that span a simplex of a dimension, far from each other: each is the one farthest from what those
    /// before it span, the first the one farthest from the centre. Those that are held come first, as many as they span.
    fn masters(
        &self,
        nodes: &[usize],
        held: &[usize],
        center: Vec3,
        dimension: usize,
    ) -> Vec<usize> {
        let Self { positions, along, size } = self;
        let first = if held.is_empty() { nodes } else { held };
        let (first, _) = farthest(first, |node| along(positions[node] - center).norm());
        let mut masters = vec![first];
        let origin = positions[first];
        let mut spanned: Vec<DVector<f64>> = Vec::new();
        let rest = |node: usize, spanned: &[DVector<f64>]| {
            spanned.iter().fold(along(positions[node] - origin), |x, unit| {
                let part = unit.dot(&x);
                x - part * unit
            })
        };
        while masters.len() <= dimension {
            let among = |nodes| farthest(nodes, |node| rest(node, &spanned).norm());
            let of_held = (!held.is_empty()).then(|| among(held));
            let beside = of_held.filter(|(_, distance)| *distance > 1e3 * FLAT * size);
            let (next, _) = beside.unwrap_or_else(|| among(nodes));
            spanned.push(rest(next, &spanned).normalize());
            masters.push(next);
        }
        masters
    }
}

/// The node with the largest of a distance, and that; rounding must not decide between nodes that are as far.
fn farthest(nodes: &[usize], distance: impl Fn(usize) -> f64) -> (usize, f64) {
    let mut best = (nodes[0], f64::NEG_INFINITY);
    for &node in nodes {
        let found = distance(node);
        if found > best.1 * (1.0 + 1e-9) || best.1 < 0.0 {
            best = (node, found);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;

    use super::*;
    use crate::math::random::Random;

    /// Random points in a box with edges [m].
    fn cloud(edges: [f64; 3]) -> Vec<Vec3> {
        let numbers = Random::new(7).numbers(90);
        let point = |x: &[f64]| Vec3::new(x[0] * edges[0], x[1] * edges[1], x[2] * edges[2]);
        numbers.chunks(3).map(point).collect()
    }

    /// A part follows its masters in any affine motion of its extents.
    #[test]
    fn followers_follow_their_masters() {
        let turn = Rotation3::from_euler_angles(0.4, -1.1, 2.0);
        let bent = Mat3::new(1.1, 0.2, 0.0, -0.3, 0.9, 0.1, 0.05, 0.2, 1.3);
        for (edges, count) in
            [([0.01, 0.02, 0.03], 4), ([0.01, 0.02, 0.0], 3), ([0.0, 0.0, 0.02], 2), ([0.0; 3], 1)]
        {
            let points: Vec<Vec3> =
                cloud(edges).iter().map(|x| turn * x + Vec3::new(0.1, 0.0, 0.3)).collect();
            let nodes: Vec<usize> = (0..points.len()).collect();
            let part = RigidSet::new(&nodes, &points, Moves::Freely).expect("nodes");
            assert_eq!(part.masters().len(), count);
            assert_eq!(part.followers().len(), 30 - count);
            let moved = |x: Vec3| bent * x + Vec3::new(-0.2, 0.1, 0.5);
            for (node, weights) in part.followers() {
                let sum: Vec3 =
                    part.masters().iter().zip(weights).map(|(&m, w)| moved(points[m]) * *w).sum();
                assert!((sum - moved(points[*node])).norm() < 1e-12, "{node}");
                // far masters: no weight is large
                assert!(weights.iter().all(|w| w.abs() < 4.0), "{weights:?}");
            }
        }
    }

    /// What is held of a part leads it: a point, or an edge, of which the other nodes follow its ends alone.
    #[test]
    fn a_hinge_leads_its_part() {
        let mut points = cloud([0.01, 0.02, 0.03]);
        for (i, point) in points.iter_mut().take(5).enumerate() {
            *point = Vec3::new(0.004, 0.01, 0.002 * (i as f64).powi(2));
        }
        let nodes: Vec<usize> = (0..points.len()).collect();
        for held in [&[3][..], &[0, 1, 2, 3, 4]] {
            let part = RigidSet::hinged(&nodes, held, &points, Moves::Freely).expect("nodes");
            let leads = held.len().min(2);
            assert_eq!(part.masters().len(), 4);
            assert!(part.masters()[..leads].iter().all(|m| held.contains(m)));
            for (node, weights) in part.followers().iter().filter(|(n, _)| held.contains(n)) {
                let others = &weights[leads..];
                assert!(others.iter().all(|w| w.abs() < 1e-12), "{node}: {weights:?}");
            }
        }
    }

    #[test]
    fn points_off_a_flat_part_are_refused() {
        let points = cloud([0.01, 0.02, 0.0]);
        let nodes: Vec<usize> = (0..points.len()).collect();
        let part = RigidSet::new(&nodes, &points, Moves::Freely).expect("nodes");
        assert!(part.weights_at(Vec3::new(0.03, 0.0, 0.0)).is_ok());
        let off = part.weights_at(Vec3::new(0.0, 0.0, 0.004)).expect_err("off the plane");
        assert!((off.distance - 0.004).abs() < 1e-12);
        let straight = RigidSet::new(&nodes, &points, Moves::Straight).expect("nodes");
        assert_eq!(straight.weights_at(Vec3::new(0.0, 0.0, 0.004)), Ok(vec![1.0]));
    }

    /// In a plane of symmetry, what is normal to it does not count.
    #[test]
    fn a_part_that_a_plane_cuts_moves_in_it() {
        let points = cloud([0.01, 0.02, 0.03]);
        let nodes: Vec<usize> = (0..points.len()).collect();
        let part = RigidSet::new(&nodes, &points, Moves::InPlane(0)).expect("nodes");
        assert_eq!(part.masters().len(), 3);
        for (node, weights) in part.followers() {
            let sum: Vec3 = part.masters().iter().zip(weights).map(|(&m, w)| points[m] * *w).sum();
            let off = sum - points[*node];
            assert!(off.y.abs() + off.z.abs() < 1e-12);
        }
    }
}
