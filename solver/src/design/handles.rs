//! Free-form deformation of a surface patch: rigid motions of a few handles, blended by
//! bounded biharmonic weights (linear blend skinning).
//!
//! v' = v + Σ_j w_j(v) (T_j v − v),   T_j v = c_j + R_j (v − c_j) + t_j
//! R_j = R_z(α₃) R_y(α₂) R_x(α₁),     αₖ = θₖ / r_j
//!
//! w_j   bounded biharmonic weight of handle j, zero on the rim [1]
//! c_j   the vertex at which handle j sits [m]
//! t_j   translation [m]
//! α     angles [rad]
//! r_j   radius of the handle's support, r_j² = Σ_v w_j² |v − c_j|² / Σ_v w_j²,
//!       but at least the mean edge: a handle that moves hardly more than its own
//!       vertex must not spin with its variables [m]
//!
//! The variables of a handle are (θ₁, θ₂, θ₃, t_x, t_y, t_z), or t alone where handles do not
//! rotate, and perhaps o, by which the surface at it moves along its normals: to T_j v is added o d(v), with d the move
//! per distance out of the silicone ([`shifts`]). All are in metres: a
//! rotation variable is the path of a vertex at distance r_j, so that equal
//! changes of any variable move the surface about equally far. θ = 0 is the
//! shape as it is. The rim does not move, whatever the variables.
//!
//! Where a plane of symmetry cuts the patch, what lies in the plane is no rim: it moves along the
//! plane, as does a flat face that is to stay in its plane. For the component along the plane's normal
//! n, w_j is then another weight, which is zero in the plane, too; a handle in the plane does not move
//! across it. With several planes that are not at right angles,
//!
//! v' − v = P_v Σ_j (w_j + Σ_n (w_jn − w_j) n nᵀ) (T_j v − v)
//!
//! w_jn  the weight that is zero in all planes across n [1]
//! P_v   projection onto the planes in which v lies
//!
//! Source: Gjoka et al. 2024, equation (17).

use std::sync::Arc;

use mesh::measure::mean_edge;
use mesh::offset::shifts;
use mesh::{SurfaceMesh, Vec3, topology};
use scene::config::{HandleMotion, Spread};

use super::biharmonic::{WeightError, bounded_biharmonic};
use super::held::{Held, off};
use super::sampling::{TooManyHandles, spread_points};

type Mat3 = nalgebra::Matrix3<f64>;

/// Handles could not be placed on a patch.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum HandleError {
    /// More handles than vertices.
    #[error(transparent)]
    TooMany(#[from] TooManyHandles),
    /// No weights for the handles.
    #[error(transparent)]
    Weights(#[from] WeightError),
}

/// A weight for each vertex, by handle [1].
type Weights = Arc<Vec<Vec<f64>>>;

/// Handles on a surface patch.
#[derive(Clone, Debug)]
pub struct Handles {
    /// Vertex ids of the patch, ascending, rim included.
    vertices: Vec<usize>,
    centers: Vec<Vec3>,
    radii: Vec<f64>,
    /// Weights by handle, in the order of `vertices`.
    weights: Weights,
    /// Normals of planes, with the weights of the motion along them.
    across: Vec<(Vec3, Weights)>,
    /// Indices in `vertices` of those that lie in planes, with orthonormal directions in which they
    /// do not move.
    in_planes: Vec<(usize, Vec<Vec3>)>,
    /// d of each vertex.
    normals: Vec<Vec3>,
    motion: HandleMotion,
}

/// Spreads `count` handles evenly over a patch of a mesh at rest positions `rest`, by
/// `spread`, and computes their weights.
///
/// # Errors
/// [`HandleError`] if the patch has too few vertices or is degenerate.
pub fn sample_handles(
    rest: &[Vec3],
    patch: &[[usize; 3]],
    held: Held,
    count: usize,
    spread: Spread,
) -> Result<Handles, HandleError> {
    let (surface, vertices) = topology::submesh(rest, patch);
    let rim = held.rim(&surface, &vertices);
    let points = spread_points(&surface, &rim, count, spread)?;
    let weights = Arc::new(bounded_biharmonic(&surface, &rim, &points)?);
    let mut across = Vec::new();
    for normal in held.normals() {
        let in_plane: Vec<usize> =
            (0..vertices.len()).filter(|&v| held.along(vertices[v], &normal)).collect();
        if !in_plane.is_empty() {
            let mut stays = [in_plane, rim.clone()].concat();
            stays.sort_unstable();
            stays.dedup();
            across.push((normal, Arc::new(weights_across(&surface, &stays, &points)?)));
        }
    }
    let fixed = vertices.iter().map(|&v| held.directions(v).0).enumerate();
    let in_planes = fixed.filter(|(_, fixed)| !fixed.is_empty()).collect();
    let centers: Vec<Vec3> = points.iter().map(|&p| surface.vertices[p]).collect();
    let edge = mean_edge(&surface.vertices, &surface.triangles);
    let radii = centers
        .iter()
        .zip(&*weights)
        .map(|(c, w)| radius(&surface.vertices, c, w).max(edge))
        .collect();
    let motion = HandleMotion::default();
    let normals = shifts(rest, patch).into_values().collect();
    Ok(Handles { vertices, centers, radii, weights, across, in_planes, normals, motion })
}

/// Weights of the handles for the component across a plane, zero at the `held` vertices in it;
/// a handle that is one of them does not move across it at all.
fn weights_across(
    surface: &SurfaceMesh,
    held: &[usize],
    points: &[usize],
) -> Result<Vec<Vec<f64>>, WeightError> {
    let is_held = |point: &usize| held.binary_search(point).is_ok();
    let free: Vec<usize> = points.iter().copied().filter(|p| !is_held(p)).collect();
    let mut weights = bounded_biharmonic(surface, held, &free)?.into_iter();
    let none = || vec![0.0; surface.vertices.len()];
    let one = |p: &usize| if is_held(p) { Some(none()) } else { weights.next() };
    Ok(points.iter().map(one).map(Option::unwrap_or_default).collect())
}

/// Root mean square distance to `center`, weighted with w² [m].
fn radius(vertices: &[Vec3], center: &Vec3, weights: &[f64]) -> f64 {
    let squares =
        || vertices.iter().zip(weights).map(|(v, w)| (w * w, (v - center).norm_squared()));
    let (moment, total) = squares().fold((0.0, 0.0), |(m, t), (w2, d2)| (m + w2 * d2, t + w2));
    (moment / total).sqrt()
}

impl Handles {
    /// These handles with another motion.
    #[must_use]
    pub fn with(self, motion: HandleMotion) -> Self {
        Self { motion, ..self }
    }

    /// Number of design variables.
    #[must_use]
    pub fn variables(&self) -> usize {
        self.variables_each() * self.centers.len()
    }

    fn variables_each(&self) -> usize {
        match self.motion {
            HandleMotion::Rigid => 6,
            HandleMotion::RigidAndOffset => 7,
            HandleMotion::Translation => 3,
        }
    }

    /// Vertex ids of the patch, ascending, rim included.
    #[must_use]
    pub fn vertices(&self) -> &[usize] {
        &self.vertices
    }

    /// Rest positions of the handles [m].
    #[must_use]
    pub fn centers(&self) -> &[Vec3] {
        &self.centers
    }

    /// Positions of the patch vertices for variables `theta` [m], from the rest
    /// positions `rest` of the whole mesh with which the handles were made.
    #[must_use]
    pub fn apply(&self, theta: &[f64], rest: &[Vec3]) -> Vec<Vec3> {
        assert_eq!(theta.len(), self.variables(), "variables of all handles");
        let mut way = vec![Vec3::zeros(); self.vertices.len()];
        for (j, motion) in self.motions(theta).iter().enumerate() {
            let turn = motion.rotation() - Mat3::identity();
            for (i, &v) in self.vertices.iter().enumerate() {
                let arm = rest[v] - self.centers[j];
                let moved = turn * arm + motion.translation + motion.offset * self.normals[i];
                way[i] += self.weighted(j, i, &moved);
            }
        }
        self.project(&mut way);
        self.vertices.iter().zip(way).map(|(&v, way)| rest[v] + way).collect()
    }

    /// (∂v'/∂θ)ᵀ `bar` for cotangents of the patch vertices.
    #[must_use]
    pub fn vjp(&self, theta: &[f64], rest: &[Vec3], bar: &[Vec3]) -> Vec<f64> {
        assert_eq!(bar.len(), self.vertices.len(), "one cotangent per patch vertex");
        let mut bar = bar.to_vec();
        self.project(&mut bar);
        let mut gradient = Vec::with_capacity(self.variables());
        for (j, motion) in self.motions(theta).iter().enumerate() {
            // the derivatives by the six variables need only Σ w v̄ and Σ w v̄ (v − c)ᵀ
            let (mut force, mut moment, mut outward) = (Vec3::zeros(), Mat3::zeros(), 0.0);
            for (i, &v) in
                self.vertices.iter().enumerate().filter(|(i, _)| bar[*i] != Vec3::zeros())
            {
                let pull = self.weighted(j, i, &bar[i]);
                force += pull;
                outward += pull.dot(&self.normals[i]);
                moment += pull * (rest[v] - self.centers[j]).transpose();
            }
            if self.motion != HandleMotion::Translation {
                let slopes = motion.rotation_slopes();
                gradient.extend(slopes.map(|slope| slope.dot(&moment) / self.radii[j]));
            }
            gradient.extend([force.x, force.y, force.z]);
            if self.motion == HandleMotion::RigidAndOffset {
                gradient.push(outward);
            }
        }
        gradient
    }

    /// (w + Σ_n (w_n − w) n nᵀ) d, with the weights of handle j at vertex i: symmetric in d.
    fn weighted(&self, j: usize, i: usize, d: &Vec3) -> Vec3 {
        let w = self.weights[j][i];
        let add =
            |sum: Vec3, (n, across): &(Vec3, Weights)| sum + (across[j][i] - w) * n.dot(d) * n;
        self.across.iter().fold(w * d, add)
    }

    /// Takes from vectors at the vertices what leads out of planes in which they stay.
    fn project(&self, vectors: &mut [Vec3]) {
        for (i, fixed) in &self.in_planes {
            vectors[*i] = off(fixed, &vectors[*i]);
        }
    }

    fn motions(&self, theta: &[f64]) -> Vec<Motion> {
        let motion = |(own, radius): (&[f64], &f64)| {
            let (own, offset) = match self.motion {
                HandleMotion::RigidAndOffset => own.split_at(own.len() - 1),
                _ => (own, &[][..]),
            };
            let (turn, translation) = own.split_at(own.len() - 3);
            let angle = |k: usize| turn.get(k).map_or(0.0, |path| path / radius);
            Motion {
                angles: [0, 1, 2].map(angle),
                translation: Vec3::from_column_slice(translation),
                offset: offset.first().copied().unwrap_or(0.0),
            }
        };
        theta.chunks_exact(self.variables_each()).zip(&self.radii).map(motion).collect()
    }
}

/// A rigid motion about a handle's center.
struct Motion {
    /// Angles about x, y, z [rad].
    angles: [f64; 3],
    /// Translation [m].
    translation: Vec3,
    /// o [m].
    offset: f64,
}

impl Motion {
    /// R_z R_y R_x.
    fn rotation(&self) -> Mat3 {
        let [x, y, z] = self.axes();
        z.0 * y.0 * x.0
    }

    /// ∂R/∂α₁, ∂R/∂α₂, ∂R/∂α₃.
    fn rotation_slopes(&self) -> [Mat3; 3] {
        let [x, y, z] = self.axes();
        [z.0 * y.0 * x.1, z.0 * y.1 * x.0, z.1 * y.0 * x.0]
    }

    /// Rotation about each axis with its derivative.
    fn axes(&self) -> [(Mat3, Mat3); 3] {
        let mut axes = [(Mat3::identity(), Mat3::zeros()); 3];
        for (k, (rotation, slope)) in axes.iter_mut().enumerate() {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let (sin, cos) = self.angles[k].sin_cos();
            for (matrix, on, off) in [(rotation, cos, sin), (slope, -sin, cos)] {
                matrix[(i, i)] = on;
                matrix[(j, j)] = on;
                matrix[(i, j)] = -off;
                matrix[(j, i)] = off;
            }
        }
        axes
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use mechanics::math::random::Random;
    use mechanics::testing::{cap, check_gradient, sphere};

    use super::*;
    use crate::design::sampling::rim;

    #[test]
    fn zero_is_the_rest_shape_and_the_rim_never_moves() {
        let surface = cap(3);
        let handles = sample_handles(
            &surface.vertices,
            &surface.triangles,
            Held::default(),
            5,
            Spread::RePick,
        )
        .unwrap();
        let x = &surface.vertices;
        assert_eq!(&handles.apply(&vec![0.0; handles.variables()], x), x);
        let moved = handles.apply(&Random::new(31).numbers(handles.variables()), x);
        assert!(rim(&surface).iter().all(|&v| moved[v] == x[v]));
        let farthest = moved.iter().zip(x).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(farthest > 0.1);
    }

    #[test]
    fn one_handle_on_a_closed_surface_is_a_rigid_motion() {
        let ball = sphere(2);
        let handles =
            sample_handles(&ball.vertices, &ball.triangles, Held::default(), 1, Spread::RePick)
                .unwrap();
        let moved = handles.apply(&[0.3, -0.8, 0.5, 1.0, 2.0, 3.0], &ball.vertices);
        let distances = |x: &[Vec3]| -> Vec<f64> { x.iter().map(|v| (v - x[7]).norm()).collect() };
        for (a, b) in distances(&moved).iter().zip(distances(&ball.vertices)) {
            // weights are one to 1e-8
            assert!((a - b).abs() < 1e-7, "{a} {b}");
        }
    }

    /// A quarter turn about x, then y, then z: e_z → −e_y → −e_y → e_x.
    #[test]
    fn rotations_are_about_x_then_y_then_z() {
        let motion = Motion {
            angles: [std::f64::consts::FRAC_PI_2; 3],
            translation: Vec3::zeros(),
            offset: 0.0,
        };
        assert!((motion.rotation() * Vec3::z() - Vec3::x()).norm() < 1e-15);
    }

    #[test]
    fn the_vjp_is_the_gradient() {
        let surface = cap(2);
        let x = &surface.vertices;
        let handles =
            sample_handles(x, &surface.triangles, Held::default(), 3, Spread::RePick).unwrap();
        check_vjp(&handles, x);
        let translated = handles.with(HandleMotion::Translation);
        assert_eq!(translated.variables(), 9);
        check_vjp(&translated, x);
        let swelling = translated.with(HandleMotion::RigidAndOffset);
        assert_eq!(swelling.variables(), 21);
        check_vjp(&swelling, x);
    }

    fn check_vjp(handles: &Handles, x: &[Vec3]) {
        let theta: Vec<f64> =
            Random::new(32).numbers(handles.variables()).iter().map(|t| 0.4 * t).collect();
        // J = Σ (aᵥ·v' + ½ |v'|²)
        let mut random = Random::new(33);
        let a: Vec<Vec3> = x.iter().map(|_| random.vector()).collect();
        let value = |theta: &[f64]| -> f64 {
            let moved = handles.apply(theta, x);
            moved.iter().zip(&a).map(|(v, a)| a.dot(v) + 0.5 * v.norm_squared()).sum()
        };
        let moved = handles.apply(&theta, x);
        let bar: Vec<Vec3> = moved.iter().zip(&a).map(|(v, a)| a + v).collect();
        check_gradient(&theta, &handles.vjp(&theta, x, &bar), 1e-2, value);
    }
}
